//! Guards what noise may not do: pass where a noisy lever could not be followed, or be left out because a method
//! to compare with carries none along.

use super::*;
use std::f64::consts::{PI, TAU};

/// Judges with what the decision takes and no more.
fn decided(recording: &Conditioned, design: &Design, policy: &Policy) -> Assessment {
    let extras = AssessExtras {
        detail: AssessDetail::Decision,
        ..AssessExtras::default()
    };
    let control = Control::unwatched(2);
    latchgate_verdict::assess(recording, &[], design, policy, extras, &control).unwrap()
}

const SOFT: ModelChoice = ModelChoice::Only(StopModel::Soft);

/// A stop so damped that a lever in it is glued and cannot be followed, before a lever without preload, which an
/// opening acceleration takes off its face at once.
fn glued() -> Design {
    let mut design = with_certain_bias(1.2);
    design.lever.preload_torque_nm = 0.0;
    design.stop.damping_n_s_per_m = 1e12;
    design
}

/// A draw, or half a step of the recorder, that presses the lever into such a stop cannot be followed, and makes
/// the noise boundless: it is no pass, whatever the limit. The nominal lever, which is followed, passes.
#[test]
fn verif_a_noisy_rerun_that_broke_down_bounds_nothing() {
    let weakly_opening_m_s2 = 2.0;
    let step_m_s2 = 3.0 * weakly_opening_m_s2;
    let offset = Noise {
        deviation_m_s2: step_m_s2 / 12.0_f64.sqrt(),
        step_m_s2,
        on_grid: true,
    };
    // Enough that the noise is drawn, since first order says more than 0.02 rad.
    let drawn = Noise {
        deviation_m_s2: 30.0 * weakly_opening_m_s2,
        ..Noise::default()
    };
    for (sign, opens_when) in [(-1.0, OpensWhen::Negative), (1.0, OpensWhen::Positive)] {
        let signal = Signal {
            start_s: 0.0,
            rate: SampleRate::from_hertz(10_000.0).unwrap(),
            samples: vec![sign * weakly_opening_m_s2; 300],
        };
        let quiet = as_recorded(signal);
        let policy = options(SOFT, Polarity::Declared(opens_when));
        let judged = |noise: Noise, design: &Design| {
            let noisy = Conditioned {
                noise,
                ..quiet.clone()
            };
            decided(&noisy, design, &policy)
        };
        let followed = judged(Noise::default(), &glued());
        assert_eq!(followed.answer, Answer::Pass, "{:#?}", followed.why);
        let lively = Design {
            stop: Design::reference().stop,
            ..glued()
        };
        for (name, noise) in [("half a step", offset), ("draws", drawn)] {
            let case = format!("{name}, {opens_when:?}");
            // Where noisy levers can be followed, so large a noise is still a number.
            let bounded = judged(noise, &lively);
            assert!(bounded.answers[0].noise_rad.is_some(), "{case}");
            let boundless = judged(noise, &glued());
            assert_eq!(
                boundless.answer,
                Answer::Undecided,
                "{case}: {:#?}",
                boundless.why
            );
            assert_eq!(boundless.answers[0].noise_rad, None, "{case}");
            assert_eq!(boundless.answers[0].uncertainty_rad, None, "{case}");
        }
    }
}

/// Noise to first order, which no draw could be made for within the limit on work, is believed where the answer does
/// not hang on eight times as much of it, and nowhere else. Here draws would press the lever into a stop in which it
/// cannot be followed; the noise is that of a tone which cubics do not follow, once the lever is far from its stop.
#[test]
fn verif_first_order_alone_makes_no_pass_within_eight_deviations() {
    const WEAKLY_OPENING_M_S2: f64 = 2.0;
    const ROOM: f64 = 8.0;
    for (sign, opens_when) in [(-1.0, OpensWhen::Negative), (1.0, OpensWhen::Positive)] {
        let tone = |index: u32| {
            let time = (f64::from(index) - 200.0) / 10_000.0;
            let phase = TAU * 2_500.0 * time + 0.25 * PI;
            half_sine(time, 0.0, 0.02, 1.0).powi(2) * phase.cos()
        };
        let signal = Signal {
            start_s: 0.0,
            rate: SampleRate::from_hertz(10_000.0).unwrap(),
            samples: (0..400)
                .map(|index| sign * WEAKLY_OPENING_M_S2 + 3_000.0 * tone(index))
                .collect(),
        };
        let recording = Conditioned {
            noise: Noise::default(),
            ..as_recorded(signal.clone())
        };
        let judged = |limit_rad: f64, work: u64| {
            let mut design = glued();
            design.criterion.threshold_rad = limit_rad;
            let policy = Policy {
                work,
                ..options(SOFT, Polarity::Declared(opens_when))
            };
            decided(&recording, &design, &policy)
        };
        let run = RunOptions {
            noise_m2_s3: Some(left_out_m_s2(&signal).powi(2) / signal.rate.hertz()),
            ..RunOptions::new(StopModel::Soft, opens_when)
        };
        let carried = replay::run(read(&signal), &glued(), &run).unwrap();
        let deviation_rad = carried.deviation_rad.unwrap();
        // Enough for all but the draws.
        let mut limits = (0..200).map(|step| (100.0 * 1.05_f64.powi(step)) as u64);
        let is_pass = |work: &u64| judged(1.5, *work).answer == Answer::Pass;
        let work = limits.find(is_pass).unwrap();
        let far = judged(1.5, work);
        let coast_rad = far.nominal.coast_peak_angle_rad.unwrap();
        let error_rad = far.answers[0].coast_uncertainty_rad.unwrap() - 2.0 * deviation_rad;
        assert!(coast_rad > far.nominal.peak_angle_rad && error_rad > 0.0);
        let at = |deviations: f64, work: u64| {
            judged(
                coast_rad + error_rad + 2.0 * deviations * deviation_rad,
                work,
            )
            .answer
        };
        for deviations in [1.01, 0.5 * ROOM, 0.999 * ROOM] {
            let case = format!("{deviations}, {opens_when:?}");
            assert_eq!(at(deviations, work), Answer::Undecided, "{case}");
        }
        assert_eq!(at(1.001 * ROOM, work), Answer::Pass, "{opens_when:?}");
        // Draws that are made are believed at any limit.
        assert_eq!(
            at(2.0 * ROOM, 100_000_000),
            Answer::Undecided,
            "{opens_when:?}"
        );
    }
}

/// Corners before a block, twice as strong as their trace, press a lever into a stop in which it cannot be followed,
/// where no other reading does. Nothing bounds the error then, and there is no pass; before half the block, whose
/// corners do not come so far, it passes.
#[test]
fn verif_a_reading_that_broke_down_bounds_nothing() {
    for opens_when in [OpensWhen::Negative, OpensWhen::Positive] {
        for (block_m_s2, lost, expected) in [(32.0, 0, Answer::Pass), (64.0, 1, Answer::Undecided)]
        {
            let opening_m_s2 = |index| match (10..20).contains(&index) {
                true => 2.0 + block_m_s2,
                false => 2.0,
            };
            let signal = Signal {
                start_s: 0.0,
                rate: SampleRate::from_hertz(10_000.0).unwrap(),
                samples: (0..300)
                    .map(|index| -opens_when.sign() * opening_m_s2(index))
                    .collect(),
            };
            let recording = Conditioned {
                noise: Noise::default(),
                ..as_recorded(signal.clone())
            };
            let broke_down = |reading: &Reading<'_>| {
                let run = RunOptions::new(StopModel::Soft, opens_when);
                let outcome = replay::run(reading, &glued(), &run).unwrap();
                outcome.broke_down
            };
            let quintic = read(&signal);
            let case = format!("{block_m_s2}, {opens_when:?}");
            assert!(
                !broke_down(&quintic) && !broke_down(&quintic.cubic()),
                "{case}"
            );
            let trace = conditioning::corner_trace(&recording).unwrap();
            let corners = [-2.0, -1.0, 1.0, 2.0].map(|times| quintic.plus(times, &read(&trace)));
            assert_eq!(
                corners.iter().filter(|one| broke_down(one)).count(),
                lost,
                "{case}"
            );
            let policy = options(SOFT, Polarity::Declared(opens_when));
            let found = decided(&recording, &glued(), &policy);
            assert_eq!(found.answer, expected, "{case}: {:#?}", found.why);
            let is_bounded = found.answers[0].interpolation_error_rad.is_some();
            assert_eq!(is_bounded, lost == 0, "{case}");
        }
    }
}

/// A method to compare with carries no noise along, so its own is drawn: it is that of noisy recordings, and what
/// it spans is no fail. However high the limit, none of them passes.
#[test]
fn verif_a_method_to_compare_with_has_a_noise_and_cannot_pass() {
    const HIGH_LIMIT_RAD: f64 = 1.5;
    let steps_per_period = 2_000;
    let methods = [
        (Method::Rk4 { steps_per_period }, RIGID),
        (Method::Rk4 { steps_per_period }, SOFT),
        (Method::Rk4Located { steps_per_period }, RIGID),
        (Method::Dopri5 { at_samples: true }, RIGID),
        (Method::Dopri5 { at_samples: true }, SOFT),
        (Method::Dopri5 { at_samples: false }, SOFT),
        (Method::MoreauJean { steps_per_period }, RIGID),
    ];
    // One swing, so that first order holds and no impact makes more of the noise.
    let quiet = as_recorded(samples(|t| half_sine(t, 0.0, 0.012, -9.0)));
    let noisy = Conditioned {
        noise: Noise {
            deviation_m_s2: 3.0,
            ..Noise::default()
        },
        ..quiet.clone()
    };
    for (method, model) in methods {
        let compared = Policy {
            method,
            ..options(model, NEGATIVE)
        };
        let judged = |recording: &Conditioned, limit_rad: f64, policy: &Policy| {
            decided(recording, &with_certain_bias(limit_rad), policy)
        };
        let case = format!("{method:?}, {model:?}");
        let reference = judged(&noisy, HIGH_LIMIT_RAD, &options(model, NEGATIVE));
        assert_eq!(reference.answer, Answer::Pass, "{:#?}", reference.why);
        let expected_rad = reference.answers[0].noise_rad.unwrap();
        for recording in [&quiet, &noisy] {
            let found = judged(recording, HIGH_LIMIT_RAD, &compared);
            assert_eq!(found.answer, Answer::Undecided, "{case}: {:#?}", found.why);
        }
        let silent = judged(&quiet, HIGH_LIMIT_RAD, &compared);
        assert_eq!(silent.answers[0].noise_rad, Some(0.0), "{case}");
        // A limit that the noise spans, and that is exceeded without it.
        let silent_error_rad = silent.answers[0].uncertainty_rad.unwrap();
        let limit_rad = silent.nominal.peak_angle_rad - silent_error_rad - 0.5 * expected_rad;
        let exceeded = judged(&quiet, limit_rad, &compared);
        assert_eq!(exceeded.answer, Answer::Fail, "{case}: {:#?}", exceeded.why);
        let spanned = judged(&noisy, limit_rad, &compared);
        assert_eq!(
            spanned.answer,
            Answer::Undecided,
            "{case}: {:#?}",
            spanned.why
        );
        // Sixteen draws are off by a factor of two at most, but for one set in a thousand.
        let noise_rad = spanned.answers[0].noise_rad.unwrap();
        assert!(
            noise_rad > 0.5 * expected_rad && noise_rad < 2.0 * expected_rad,
            "{case}: {noise_rad} for {expected_rad}"
        );
    }
}

/// One of 128 draws may open a lever that passes, and no two.
#[test]
fn verif_a_pass_lets_one_draw_open() {
    use latchgate_verdict::decision::{
        OPENING_DRAWS_MAX, PASS_DRAWS, PeakEstimate, ShareBounds, decide,
    };
    let opened = |opening_draws| PeakEstimate {
        peak_angle_rad: 0.01,
        uncertainty_rad: 0.001,
        coast_at_most_rad: None,
        followed: true,
        bounded: true,
        opening_draws,
    };
    assert_eq!((OPENING_DRAWS_MAX, PASS_DRAWS), (1, 128));
    let none_cross = Some(ShareBounds::NONE_CROSSES);
    for share in [None, none_cross] {
        for (draws, expected) in [
            (0, Answer::Pass),
            (1, Answer::Pass),
            (2, Answer::Undecided),
            (128, Answer::Undecided),
        ] {
            assert_eq!(decide(&opened(draws), 0.1, share), expected, "{draws}");
        }
    }
}

/// Two pushes of which the second, lower by itself, is raised by noise: its impacts amplify what the first push
/// leaves. First order knows of the first alone, and of a noise far below it. The draws open the lever, and the
/// verdict says so.
#[test]
fn regress_another_maximum_takes_over_under_noise() {
    let path = "tests/data/noisy_near_the_limit.csv";
    let channel = crate::support::one(
        &crate::support::root().join(path),
        &latchgate_recording::ReadOptions::default(),
    );
    let recording = conditioning::condition(&channel.0, &ConditioningOptions::default()).unwrap();
    for members in [0, 10_000] {
        let mut design = with_certain_bias(0.1);
        design.tolerance.insert("restitution".into(), 1e-3.into());
        (design.input.scale, design.input.bias_g) = (1e-3, 2e-3);
        let policy = Policy {
            members,
            ..options(RIGID, NEGATIVE)
        };
        let found = decided(&recording, &design, &policy);
        assert!(found.nominal.peak_angle_rad < 0.04);
        assert_eq!(
            found.answer,
            Answer::Undecided,
            "{members}: {:#?}",
            found.why
        );
        assert_eq!(found.why[0].code, "noise-decides");
        let opening = found.answers[0].opening_draws.unwrap();
        // Of 256 draws of its noise 23.4 % open (4.8 % one standard deviation of 128 and of 256 together).
        assert!((13..=47).contains(&opening), "{opening}");
        assert!(found.answers[0].noise_97_5_rad.unwrap() > 0.5);
    }
}

/// A lever that could pass is replayed under draws of its noise or does not pass: where the limit on work forbids
/// them the answer is open, and the finding says so.
#[test]
fn verif_draws_that_the_limit_on_work_forbids_make_no_pass() {
    let noisy = Conditioned {
        noise: Noise {
            deviation_m_s2: 0.05,
            ..Noise::default()
        },
        ..as_recorded(samples(weak))
    };
    for model in [RIGID, SOFT] {
        let (mut passes, mut forbidden) = (0, 0);
        for power in 8..26 {
            let policy = Policy {
                work: 1 << power,
                ..options(model, NEGATIVE)
            };
            let found = decided(&noisy, &with_certain_bias(0.1), &policy);
            let answer = &found.answers[0];
            if found.answer == Answer::Pass {
                assert!(answer.opening_draws.is_some(), "{model:?}, {power}");
                passes += 1;
            } else {
                assert_eq!(found.answer, Answer::Undecided, "{model:?}, {power}");
                let is_said = found.findings.iter().any(|one| one.code == "work-limit");
                assert!(is_said, "{model:?}, {power}");
                // The nominal run was followed, and nothing but the draws is missing.
                let nominal = answer
                    .interpolation_error_rad
                    .is_some_and(|error| error < 0.01);
                forbidden += usize::from(nominal && answer.noise_rad.is_none());
            }
        }
        assert!(passes > 0 && forbidden > 0, "{passes}, {forbidden}");
    }
}
