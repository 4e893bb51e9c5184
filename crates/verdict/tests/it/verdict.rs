//! Guards the decision: each branch of the rule, and the error budget.

mod draws;
mod ensemble;
mod faults;
mod interpolation_error;
mod noise;
mod passes;
mod reasons;
mod rule;
mod window;

use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::range::Window;
use latchgate_kernel::replay::{self, Method, RunOptions, RunOutcome};
use latchgate_kernel::signal::Reading;
use latchgate_kernel::units::{AccelerationUnit, OpensWhen, SampleRate};
use latchgate_recording::error::Error;
use latchgate_recording::{Channel, Finding};
use latchgate_verdict::conditioning::{
    self, Between, BiasWindow, Conditioned, ConditioningOptions, FilterChoice, Noise, Signal,
    between,
};
use latchgate_verdict::decision::{VariantRun, unanimous, worse};
use latchgate_verdict::{
    Answer, AssessDetail, AssessExtras, Assessment, ModelChoice, Polarity, Policy,
};
use std::borrow::Cow;

use crate::support::{half_sine, weak};

const G: f64 = 9.806_65;

/// A signal at 10 kHz from −50 ms to 250 ms whose acceleration [g] is `of(t)`.
fn samples(of: impl Fn(f64) -> f64) -> Signal {
    Signal {
        start_s: -0.05,
        rate: SampleRate::from_hertz(10_000.0).unwrap(),
        samples: (-500..=2500)
            .map(|index| G * of(f64::from(index) / 10_000.0))
            .collect(),
    }
}

/// A conditioned channel to which nothing was done.
fn as_recorded(signal: Signal) -> Conditioned {
    let channel = Channel {
        name: "acc_y".into(),
        unit: Some(AccelerationUnit::MetrePerSecondSquared),
        unit_source: "option",
        stated: latchgate_recording::Stated::default(),
        start_s: signal.start_s,
        rate: signal.rate,
        values: signal.samples.clone(),
        findings: Vec::new(),
        pulse: None,
    };
    let options = ConditioningOptions {
        bias: BiasWindow::None,
        filter: FilterChoice::None,
        synthetic: true,
        ..ConditioningOptions::default()
    };
    let conditioned = conditioning::condition(&channel, &options).unwrap();
    assert_eq!(conditioned.used, signal);
    conditioned
}

fn options(model: ModelChoice, polarity: Polarity) -> Policy {
    Policy::new(model, polarity)
}

/// Assesses with the filter table, on two threads.
fn assess(
    conditioned: &Conditioned,
    findings: &[Finding],
    design: &Design,
    policy: &Policy,
) -> Result<Assessment, Error> {
    let extras = AssessExtras {
        filter_table: true,
        ..AssessExtras::default()
    };
    let control = Control::unwatched(2);
    latchgate_verdict::assess(conditioned, findings, design, policy, extras, &control)
}

fn passes(
    conditioned: &Conditioned,
    findings: &[Finding],
    design: &Design,
    policy: &Policy,
) -> Result<bool, Error> {
    let control = Control::unwatched(2);
    let extras = AssessExtras {
        detail: AssessDetail::Decision,
        ..AssessExtras::default()
    };
    let assessed =
        latchgate_verdict::assess(conditioned, findings, design, policy, extras, &control)?;
    Ok(assessed.answer == Answer::Pass)
}

const RIGID: ModelChoice = ModelChoice::Only(StopModel::Rigid);
const NEGATIVE: Polarity = Polarity::Declared(OpensWhen::Negative);

fn with_threshold(threshold_rad: f64) -> Design {
    let mut design = Design::reference();
    design.criterion.threshold_rad = threshold_rad;
    design
}

/// The same with a bias that is known for certain, so that it decides nothing.
fn with_certain_bias(threshold_rad: f64) -> Design {
    let mut design = with_threshold(threshold_rad);
    design.input.bias_g = 0.0;
    design
}

fn judge(signal: &Signal, findings: &[Finding], design: &Design, options: &Policy) -> Assessment {
    assess(&as_recorded(signal.clone()), findings, design, options).unwrap()
}

fn read(signal: &Signal) -> Reading<'_> {
    between::read(Cow::Borrowed(signal), Between::BandLimited).unwrap()
}

/// A run made without the verdict's help.
fn explicit(signal: &Signal, stop: StopModel, sign: OpensWhen) -> RunOutcome {
    let options = RunOptions::new(stop, sign);
    replay::run(read(signal), &Design::reference(), &options).unwrap()
}

/// The peak of a run of which nothing else is asked, as runs for a comparison are made.
fn peak_alone(reading: &Reading<'_>, stop: StopModel, sign: OpensWhen) -> f64 {
    let options = RunOptions {
        error_bound: false,
        peak_only: true,
        ..RunOptions::new(stop, sign)
    };
    let outcome = replay::run(reading, &Design::reference(), &options).unwrap();
    outcome.run.peak_angle_rad
}

/// Peak and U of a lever that is at rest at the end, from explicit runs; the recording has no noise.
fn peak_and_uncertainty(signal: &Signal, stop: StopModel) -> (f64, f64) {
    let own = explicit(signal, stop, OpensWhen::Negative).run;
    assert_eq!(own.coast_peak_angle_rad, None);
    let peak = |reading: &Reading<'_>| peak_alone(reading, stop, OpensWhen::Negative);
    let recording = as_recorded(signal.clone());
    let interpolation = interpolation_rad(&recording, own.peak_angle_rad, peak)
        + 2.0 * deviation_rad(signal, left_out_m_s2(signal), &Design::reference(), stop);
    (own.peak_angle_rad, own.numerical_error_rad + interpolation)
}

/// What other readings do to a peak where the course of impacts is the same on all: the change to the cubic,
/// and what corners and jumps between samples may do.
fn interpolation_rad(
    conditioned: &Conditioned,
    own: f64,
    peak: impl Fn(&Reading<'_>) -> f64,
) -> f64 {
    let quintic = read(&conditioned.used);
    let trace = conditioning::corner_trace(conditioned).unwrap();
    let corners = [1.0, -1.0, 2.0, -2.0].map(|times| {
        let moved = quintic.plus(times, &read(&trace));
        (peak(&moved) - own).abs()
    });
    (peak(&quintic.cubic()) - own).abs() + corners.into_iter().fold(0.0, f64::max)
}

/// How far quintics are from cubics halfway between the samples: the largest root mean square over 10 ms.
fn left_out_m_s2(signal: &Signal) -> f64 {
    let quintic = read(signal);
    let cubic = quintic.cubic();
    let count = signal.samples.len() - 1;
    let away = |index: usize| {
        let [quintic, cubic] = [&quintic, &cubic].map(|of| of.at(index, 0.5).unwrap());
        (quintic - cubic) * (quintic - cubic)
    };
    let squares: Vec<f64> = (0..count).map(away).collect();
    let span = (0.01 * signal.rate.hertz()).round() as usize;
    let sums = (0..count).map(|first| squares[first..count.min(first + span)].iter().sum());
    (sums.fold(0.0, f64::max) / span as f64).sqrt()
}

/// What a white noise of the samples does to the peak, to first order.
fn deviation_rad(signal: &Signal, noise_m_s2: f64, design: &Design, stop: StopModel) -> f64 {
    let options = RunOptions {
        noise_m2_s3: Some(noise_m_s2 * noise_m_s2 / signal.rate.hertz()),
        ..RunOptions::new(stop, OpensWhen::Negative)
    };
    let outcome = replay::run(read(signal), design, &options).unwrap();
    outcome.deviation_rad.unwrap()
}

#[track_caller]
fn check_answer(assessment: &Assessment, answer: Answer, codes: &[&str]) {
    let found: Vec<&str> = assessment.why.iter().map(|reason| &*reason.code).collect();
    assert_eq!(assessment.answer, answer, "{:#?}", assessment.why);
    assert_eq!(found, codes, "{:#?}", assessment.why);
    for reason in &assessment.why {
        let (first, last) = (reason.text.chars().next(), reason.text.chars().last());
        assert!(
            first.is_some_and(|c| c.is_uppercase() || c.is_ascii_digit()),
            "{}",
            reason.text
        );
        assert_eq!(last, Some('.'), "{}", reason.text);
        assert!(
            !reason.text.contains("NaN") && !reason.text.contains("inf "),
            "{}",
            reason.text
        );
    }
}

/// Where twice the noise's standard deviation alone spans the limit, it is named with its cure.
#[test]
fn verif_noise_that_decides_is_named() {
    let quiet = as_recorded(samples(weak));
    let own = options(RIGID, NEGATIVE);
    let peak = assess(&quiet, &[], &with_certain_bias(0.1), &own)
        .unwrap()
        .nominal
        .peak_angle_rad;
    let design = with_certain_bias(peak + 1e-4);
    assert_eq!(
        assess(&quiet, &[], &design, &own).unwrap().answer,
        Answer::Pass
    );
    for (step_m_s2, words) in [
        (
            0.0,
            [
                "The noise before contact, 0.31 g, decides",
                "A quieter channel",
            ],
        ),
        (
            10.4,
            ["The recorder's step of 1.1 g decides", "A finer recorder"],
        ),
    ] {
        let noisy = Conditioned {
            noise: Noise {
                deviation_m_s2: 3.0,
                step_m_s2,
                on_grid: step_m_s2 > 0.0,
            },
            ..quiet.clone()
        };
        let found = assess(&noisy, &[], &design, &own).unwrap();
        assert_eq!(found.answer, Answer::Undecided, "{:?}", found.budget);
        assert_eq!(found.why[0].code, "noise-decides");
        for word in words {
            assert!(found.why[0].text.contains(word), "{}", found.why[0].text);
        }
        assert_eq!(found.budget.noise, found.answers[0].noise_rad);
    }
}

/// To first order as by draws: the standard deviation of the peak is that of many noisy recordings, within a
/// factor of two.
#[test]
fn val_the_noise_carried_along_is_that_of_noisy_recordings() {
    let quiet = samples(|t| half_sine(t, 0.0, 0.012, -9.0) + half_sine(t, 0.02, 0.01, 6.0));
    for (model, stop) in [
        (RIGID, StopModel::Rigid),
        (ModelChoice::Only(StopModel::Soft), StopModel::Soft),
    ] {
        let noise = Noise {
            deviation_m_s2: 1.0,
            ..Noise::default()
        };
        let noisy = Conditioned {
            noise,
            ..as_recorded(quiet.clone())
        };
        let found = assess(
            &noisy,
            &[],
            &with_threshold(1e-4),
            &options(model, NEGATIVE),
        )
        .unwrap();
        let stated = found.budget.noise.unwrap();
        let mut random = crate::support::Random(5);
        let mut squares = 0.0;
        for _ in 0..64 {
            let mut drawn = quiet.clone();
            for a in &mut drawn.samples {
                // Of twelve uniform draws the sum less six is nearly normal.
                let sum: f64 = (0..12).map(|_| random.between(0.0, 1.0)).sum();
                *a += sum - 6.0;
            }
            let peak = explicit(&drawn, stop, OpensWhen::Negative)
                .run
                .peak_angle_rad;
            let change = peak - found.nominal.peak_angle_rad;
            squares += change * change;
        }
        let seen = libm::sqrt(squares / 64.0);
        println!("{stop:?}: stated {stated:e}, seen {seen:e}");
        assert!(
            stated > 0.5 * seen && stated < 2.0 * seen,
            "{stated} {seen}"
        );
    }
}

/// Part 3 at its bounds: at peak + U a pass, at peak − U not yet a fail.
#[test]
fn verif_pass_and_fail_turn_at_the_uncertainty() {
    let signal = samples(weak);
    let (peak, uncertainty) = peak_and_uncertainty(&signal, StopModel::Rigid);
    assert!(peak > 0.005 && uncertainty > 1e-9, "{peak} {uncertainty}");
    // With a stated start no bound in closed form takes the place of the error that was measured.
    let own = Policy {
        initial_angle_rad: Some(0.0),
        ..options(RIGID, NEGATIVE)
    };
    let at = |threshold: f64| judge(&signal, &[], &with_certain_bias(threshold), &own);
    let below = ["threshold-not-crossed", "uncertainty", "nominal-runs-only"];
    check_answer(&at(0.1), Answer::Pass, &below);
    let spans = [
        "threshold-not-crossed",
        "uncertainty-spans-threshold",
        "nominal-runs-only",
    ];
    assert_eq!(at(peak + uncertainty).answer, Answer::Pass);
    check_answer(
        &at((peak + uncertainty) * (1.0 - 1e-12)),
        Answer::Undecided,
        &spans,
    );
    check_answer(&at(peak), Answer::Undecided, &spans);
    // A step ends where the limit is crossed, which moves the last digits of the noise carried along.
    let crossed = [
        "threshold-crossed",
        "uncertainty-spans-threshold",
        "nominal-runs-only",
    ];
    check_answer(
        &at(peak - uncertainty * (1.0 - 1e-4)),
        Answer::Undecided,
        &crossed,
    );
    let fails = ["threshold-crossed", "uncertainty", "nominal-runs-only"];
    check_answer(&at(peak - uncertainty * (1.0 + 1e-4)), Answer::Fail, &fails);
    check_answer(&at(0.5 * peak), Answer::Fail, &fails);
}

#[test]
fn verif_a_lever_that_is_pressed_into_its_stop_passes() {
    let signal = samples(|t| half_sine(t, 0.0, 0.03, 12.0));
    let rigid = judge(
        &signal,
        &[],
        &Design::reference(),
        &options(RIGID, NEGATIVE),
    );
    check_answer(
        &rigid,
        Answer::Pass,
        &["never-released", "uncertainty", "nominal-runs-only"],
    );
    assert_eq!(rigid.nominal.peak_angle_rad, 0.0);
}

/// A record that ends while the lever rises is no pass, however low the lever stands then.
#[test]
fn verif_a_coast_beyond_the_limit_forbids_a_pass() {
    let whole = samples(|t| half_sine(t, 0.0, 0.01, -20.0));
    let mut cut = whole.clone();
    cut.samples.truncate(500 + 110);
    // By straight lines, for which the end of the record changes nothing before it.
    let own = Policy {
        between: Between::Linear,
        ..options(RIGID, NEGATIVE)
    };
    let assessment = judge(&cut, &[], &Design::reference(), &own);
    let nominal = &assessment.nominal;
    assert!(
        nominal.peak_angle_rad < 0.1 && nominal.coast_peak_angle_rad.unwrap() > 0.1,
        "{nominal:?}"
    );
    check_answer(
        &assessment,
        Answer::Undecided,
        &[
            "coast-reaches-limit",
            "threshold-not-crossed",
            "uncertainty",
            "nominal-runs-only",
        ],
    );
    // The coast of the cut record is what the rest of the whole one holds: no acceleration.
    let rest = judge(&whole, &[], &Design::reference(), &own);
    assert_eq!(rest.answer, Answer::Fail);
    let change = rest.nominal.peak_angle_rad / nominal.coast_peak_angle_rad.unwrap() - 1.0;
    assert!(change.abs() < 1e-9, "{change}");
}

/// Part 3 at the coast's bound, on each stop and in each direction: at its peak + its own error a pass, below no
/// more. That error is the kernel's bound of the coast's peak, never less than that of the window's, and what the
/// recording leaves.
#[test]
fn verif_a_pass_turns_at_the_coast_and_its_error() {
    for (stop, opens_when, peak_g) in [
        (StopModel::Rigid, OpensWhen::Negative, -20.0),
        (StopModel::Rigid, OpensWhen::Positive, 20.0),
        (StopModel::Soft, OpensWhen::Negative, -20.0),
        (StopModel::Soft, OpensWhen::Positive, 20.0),
    ] {
        let mut cut = samples(|t| half_sine(t, 0.0, 0.01, peak_g));
        cut.samples.truncate(500 + 70);
        // A truncation so large that the coast's bound counts beside what lies between the samples.
        let policy = Policy {
            between: Between::Linear,
            tolerance_rad: Some(1e-5),
            ..options(ModelChoice::Only(stop), Polarity::Declared(opens_when))
        };
        let run_options = RunOptions {
            tolerance_rad: policy.tolerance_rad,
            ..RunOptions::new(stop, opens_when)
        };
        let outcome = replay::run(&cut, &Design::reference(), &run_options).unwrap();
        let coast_rad = outcome.run.coast_peak_angle_rad.unwrap();
        let numerical_rad = outcome.run.numerical_error_rad;
        assert!(outcome.run.peak_angle_rad < 0.5 * coast_rad, "{outcome:?}");
        let case = format!("{stop:?}, {opens_when:?}");
        assert!(outcome.coast_error_rad > 1.1 * numerical_rad, "{case}");
        let at = |limit_rad: f64| judge(&cut, &[], &with_certain_bias(limit_rad), &policy);
        let stated = &at(10.0).answers[0];
        let left_rad = stated.interpolation_error_rad.unwrap() + 2.0 * stated.noise_rad.unwrap();
        let error_rad = outcome.coast_error_rad.max(numerical_rad) + left_rad;
        let bound_rad = coast_rad + error_rad;
        assert_eq!(at(bound_rad * (1.0 + 1e-12)).answer, Answer::Pass, "{case}");
        let below = at(bound_rad * (1.0 - 1e-12));
        let codes = [
            "coast-reaches-limit",
            "threshold-not-crossed",
            "uncertainty",
            "nominal-runs-only",
        ];
        check_answer(&below, Answer::Undecided, &codes);
    }
}

/// Nearly all scattered levers stay below while the record runs, and many open just after it.
#[test]
fn verif_varied_levers_that_coast_beyond_the_limit_forbid_a_pass() {
    let last = 110_u16;
    let until = |t: f64| t < (f64::from(last) + 0.5) / 10_000.0;
    let longer = samples(|t| {
        if until(t) {
            half_sine(t, 0.0, 0.02, -12.0)
        } else {
            0.0
        }
    });
    let mut cut = longer.clone();
    // One sample of nothing, so that the coast begins as in the longer record.
    cut.samples.truncate(500 + usize::from(last) + 2);
    let coast = explicit(&cut, StopModel::Rigid, OpensWhen::Negative)
        .run
        .coast_peak_angle_rad;
    let own = Policy {
        members: 128,
        between: Between::Linear,
        ..options(RIGID, NEGATIVE)
    };
    let design = with_certain_bias(1.012 * coast.unwrap());
    let found = judge(&cut, &[], &design, &own);
    let ensemble = found.ensemble.as_ref().unwrap();
    assert_eq!(found.answer, Answer::Undecided, "{:#?}", found.why);
    assert_eq!(
        found.why[0].code, "members-coast-beyond",
        "{:#?}",
        found.why
    );
    assert_eq!(found.why[1].code, "members-cross", "{:#?}", found.why);
    assert_eq!(ensemble.exceeded, 0);
    assert!(ensemble.p_upper <= 0.05 && ensemble.p_upper_with_coast > 0.05);
    // They are those that cross where the record goes on.
    let rest = judge(&longer, &[], &design, &own);
    assert_eq!(rest.answer, Answer::Undecided);
    assert_eq!(rest.ensemble.unwrap().exceeded, ensemble.exceeded_in_coast);
    // The short question is answered alike.
    let conditioned = as_recorded(cut);
    assert!(!passes(&conditioned, &[], &design, &own).unwrap());
}

#[test]
fn verif_stops_that_differ_leave_it_undecided() {
    // A push without corners, since the error by those is larger than the stops' difference.
    let signal = samples(|t| {
        let push = half_sine(t, 0.0, 0.01, 1.0);
        let rebound = half_sine(t, 0.01, 0.03, 1.0);
        -6.4 * push * push + 0.64 * rebound * rebound
    });
    let [rigid, soft] =
        [StopModel::Rigid, StopModel::Soft].map(|stop| peak_and_uncertainty(&signal, stop));
    let between = with_certain_bias(0.5 * (rigid.0 + soft.0));
    assert!(
        (rigid.0 - soft.0).abs() > 2.0 * rigid.1.max(soft.1),
        "{rigid:?} {soft:?}"
    );
    let both = judge(
        &signal,
        &[],
        &between,
        &options(ModelChoice::Auto, NEGATIVE),
    );
    check_answer(
        &both,
        Answer::Undecided,
        &[
            "stop-model-decides",
            "threshold-crossed",
            "uncertainty",
            "nominal-runs-only",
        ],
    );
    let text = &both.why[0].text;
    assert!(
        text.contains("rigid stop, negative acceleration: ")
            && text.contains("pass")
            && text.contains("fail"),
        "{text}"
    );
    let mut alone: Vec<Answer> = [StopModel::Rigid, StopModel::Soft]
        .map(|stop| {
            judge(
                &signal,
                &[],
                &between,
                &options(ModelChoice::Only(stop), NEGATIVE),
            )
            .answer
        })
        .to_vec();
    alone.sort_by_key(|answer| answer.exit_code());
    assert_eq!(alone, [Answer::Pass, Answer::Fail]);
    // What each holds is the run asked for alone.
    for stop in [StopModel::Rigid, StopModel::Soft] {
        let run = explicit(&signal, stop, OpensWhen::Negative).run;
        assert_eq!(both.models[&stop].peak_angle_rad, run.peak_angle_rad);
    }
    assert_eq!(both.nominal.peak_angle_rad, rigid.0.max(soft.0));
}

#[test]
fn verif_polarity_undeclared_must_agree_and_both_takes_the_worse() {
    let one_sided = samples(|t| half_sine(t, 0.0, 0.03, 12.0));
    let of = |signal: &Signal, polarity| {
        judge(
            signal,
            &[],
            &Design::reference(),
            &options(ModelChoice::Auto, polarity),
        )
    };
    let undeclared = of(&one_sided, Polarity::Undeclared);
    check_answer(
        &undeclared,
        Answer::Undecided,
        &[
            "polarity-decides",
            "threshold-crossed",
            "uncertainty",
            "nominal-runs-only",
        ],
    );
    assert!(undeclared.why[0].text.contains("`opens_when`"));
    assert!(
        undeclared
            .findings
            .iter()
            .any(|finding| finding.code == "polarity-undeclared")
    );
    let both = of(&one_sided, Polarity::Both);
    check_answer(
        &both,
        Answer::Fail,
        &[
            "threshold-crossed",
            "polarity-decides",
            "uncertainty",
            "nominal-runs-only",
        ],
    );
    for assessment in [&undeclared, &both] {
        assert_eq!(assessment.nominal.opens_when, OpensWhen::Positive);
        assert_eq!(assessment.polarities.len(), 2);
        assert!(assessment.polarities.values().all(|stops| stops.len() == 2));
    }
    assert!(both.budget.polarity.is_none() && undeclared.budget.polarity.is_some());
    let two_sided = samples(|t| half_sine(t, 0.0, 0.03, 12.0) + half_sine(t, 0.05, 0.03, -12.0));
    assert_eq!(of(&two_sided, Polarity::Undeclared).answer, Answer::Fail);
    let quiet = samples(|t| half_sine(t, 0.0, 0.03, 0.5));
    assert_eq!(of(&quiet, Polarity::Undeclared).answer, Answer::Pass);
    assert_eq!(of(&quiet, Polarity::Both).answer, Answer::Pass);
}

#[test]
fn verif_answers_join_as_the_rule_says() {
    use Answer::{Fail, Pass, Undecided};
    for (answers, all, worst) in [
        (&[Pass, Pass][..], Pass, Pass),
        (&[Fail, Fail], Fail, Fail),
        (&[Pass, Fail], Undecided, Fail),
        (&[Fail, Undecided], Undecided, Fail),
        (&[Pass, Undecided], Undecided, Undecided),
        (&[Undecided, Undecided], Undecided, Undecided),
        (&[Pass], Pass, Pass),
        (&[], Undecided, Undecided),
    ] {
        assert_eq!(unanimous(answers), all, "{answers:?}");
        assert_eq!(worse(answers), worst, "{answers:?}");
    }
}

// ---------------------------------------------------------------- findings that block

/// Crosses 0.1 rad soon after 0 and stays above for long.
fn lost() -> Signal {
    samples(|t| half_sine(t, 0.0, 0.03, -20.0))
}

fn blocking(at_s: Option<f64>) -> Vec<Finding> {
    let finding = Finding::blocking("clipping", "the channel was saturated");
    vec![match at_s {
        Some(at_s) => finding.at(at_s),
        None => finding,
    }]
}

/// Part 1 before part 2: what was lost before the fault is a fail, whatever comes after.
#[test]
fn verif_a_blocking_finding_after_the_crossing_keeps_the_fail() {
    let signal = lost();
    let crossing = explicit(&signal, StopModel::Rigid, OpensWhen::Negative)
        .run
        .first_crossing_s
        .unwrap();
    let with = |at_s| {
        judge(
            &signal,
            &blocking(at_s),
            &Design::reference(),
            &options(ModelChoice::Auto, NEGATIVE),
        )
    };
    check_answer(
        &with(Some(crossing + 0.002)),
        Answer::Fail,
        &[
            "threshold-crossed",
            "failed-before-fault",
            "uncertainty",
            "nominal-runs-only",
        ],
    );
    let unusable = ["clipping"];
    check_answer(&with(Some(crossing)), Answer::Unusable, &unusable);
    check_answer(&with(Some(0.0)), Answer::Unusable, &unusable);
    check_answer(&with(Some(-0.05)), Answer::Unusable, &unusable);
    check_answer(&with(Some(-7.0)), Answer::Unusable, &unusable);
    check_answer(&with(None), Answer::Unusable, &unusable);
    // The earliest of several counts, in whatever order they come.
    let two = [blocking(Some(crossing + 0.002)), blocking(Some(0.001))].concat();
    let both = judge(
        &signal,
        &two,
        &Design::reference(),
        &options(ModelChoice::Auto, NEGATIVE),
    );
    assert_eq!(both.answer, Answer::Unusable);
    // Where the opening direction is not declared, the one that fails before the fault is named.
    let undeclared = judge(
        &signal,
        &blocking(Some(crossing + 0.002)),
        &Design::reference(),
        &options(ModelChoice::Auto, Polarity::Undeclared),
    );
    let expected = ["clipping", "failed-before-fault"];
    check_answer(&undeclared, Answer::Unusable, &expected);
    let text = &undeclared.why[1].text;
    assert!(text.starts_with("If negative acceleration opens"), "{text}");
}

#[test]
fn verif_a_blocking_finding_forbids_a_pass_and_an_undecided() {
    let signal = samples(weak);
    let (peak, _) = peak_and_uncertainty(&signal, StopModel::Rigid);
    for threshold in [0.1, peak] {
        for at_s in [None, Some(-0.05), Some(0.001), Some(0.25)] {
            let assessment = judge(
                &signal,
                &blocking(at_s),
                &with_threshold(threshold),
                &options(RIGID, NEGATIVE),
            );
            assert_eq!(assessment.answer, Answer::Unusable, "{threshold} {at_s:?}");
            assert_eq!(assessment.why[0].text, "The channel was saturated.");
            assert_eq!(assessment.why.len(), 1, "{:?}", assessment.why);
        }
    }
    let harmless = [Finding::info("a", "b"), Finding::warning("c", "d").at(0.0)];
    let assessment = judge(
        &signal,
        &harmless,
        &with_threshold(0.1),
        &options(RIGID, NEGATIVE),
    );
    assert_eq!(assessment.answer, Answer::Pass);
}

#[test]
fn verif_a_fault_after_the_window_does_not_count_and_is_told() {
    let signal = samples(weak);
    let judged = |at_s, end_s| {
        let own = Policy {
            window_s: Some(Window::new(-0.01, end_s)),
            ..options(ModelChoice::Auto, NEGATIVE)
        };
        judge(&signal, &blocking(Some(at_s)), &Design::reference(), &own)
    };
    let late = judged(0.2, 0.15);
    assert_eq!(late.answer, Answer::Pass);
    let finding = late
        .findings
        .iter()
        .find(|finding| finding.code == "fault-after-window")
        .unwrap();
    assert_eq!(finding.at_s, Some(0.2));
    assert_eq!(late.why[1].code, "fault-after-window");
    for (at_s, end_s) in [(0.15, 0.15), (0.1, 0.15), (-0.04, 0.15), (0.2, 9.0)] {
        let early = judged(at_s, end_s);
        assert_eq!(early.answer, Answer::Unusable, "{at_s} {end_s}");
        assert!(
            !early
                .findings
                .iter()
                .any(|finding| finding.code == "fault-after-window")
        );
    }
}

#[test]
fn verif_a_crossing_outside_the_window_is_told() {
    let signal = lost();
    let own = |from, to| Policy {
        window_s: Some(Window::new(from, to)),
        ..options(RIGID, NEGATIVE)
    };
    let early = judge(&signal, &[], &Design::reference(), &own(-0.04, -0.01));
    check_answer(
        &early,
        Answer::Pass,
        &[
            "never-released",
            "crossing-outside-window",
            "uncertainty",
            "nominal-runs-only",
        ],
    );
    let crossing = explicit(&signal, StopModel::Rigid, OpensWhen::Negative)
        .run
        .first_crossing_s;
    let finding = early
        .findings
        .iter()
        .find(|finding| finding.code == "crossing-outside-window")
        .unwrap();
    assert_eq!(finding.at_s, crossing);
    let whole = judge(&signal, &[], &Design::reference(), &own(-0.04, 0.2));
    assert!(
        !whole
            .findings
            .iter()
            .any(|finding| finding.code == "crossing-outside-window")
    );
}

/// A run that the method could not follow decides nothing, whatever numbers it left behind.
#[test]
fn verif_a_run_that_broke_down_decides_nothing() {
    let mut outcome = explicit(&samples(weak), StopModel::Rigid, OpensWhen::Negative);
    for peak in [0.0, 1.0, f64::MAX] {
        outcome.run.peak_angle_rad = peak;
        for broke_down in [false, true] {
            outcome.broke_down = broke_down;
            let judged = VariantRun {
                share: None,
                outcome: outcome.clone(),
                interpolation_error_rad: 0.0,
                noise_rad: 0.0,
                noise_draws: None,
                bound: None,
            };
            let expected = match (broke_down, peak > 0.1) {
                (true, _) => Answer::Undecided,
                (false, true) => Answer::Fail,
                (false, false) => Answer::Pass,
            };
            assert_eq!(judged.answer(0.1), expected, "{peak} {broke_down}");
        }
    }
    let own = Policy {
        method: Method::Rk4 {
            steps_per_period: 3,
        },
        ..options(ModelChoice::Only(StopModel::Soft), NEGATIVE)
    };
    let assessment = judge(
        &samples(|t| half_sine(t, -0.05, 0.2, -20.0)),
        &[],
        &Design::reference(),
        &own,
    );
    assert_ne!(assessment.answer, Answer::Pass);
    assert!(
        assessment
            .findings
            .iter()
            .any(|finding| finding.code == "method-known-to-fail")
    );
}

// ---------------------------------------------------------------- the budget

/// Each part is the difference of two runs that anybody can make. The lever fails: the noise of a run that could
/// pass is drawn.
#[test]
fn verif_each_part_of_the_budget_is_the_difference_of_two_runs() {
    let channel = Channel {
        name: "acc_y".into(),
        unit: Some(AccelerationUnit::MetrePerSecondSquared),
        unit_source: "option",
        stated: latchgate_recording::Stated::default(),
        start_s: -0.05,
        rate: SampleRate::from_hertz(10_000.0).unwrap(),
        values: samples(|t| weak(t) + 0.05 * (t * 2_345.0).sin() + 0.2).samples,
        findings: Vec::new(),
        pulse: None,
    };
    let conditioned = conditioning::condition(&channel, &ConditioningOptions::default()).unwrap();
    assert!(conditioned.bias_samples > 100 && conditioned.filter.is_some());
    let used = &conditioned.used;
    let design = with_threshold(1e-4);
    for (model, stop, other) in [
        (RIGID, StopModel::Rigid, StopModel::Soft),
        (
            ModelChoice::Only(StopModel::Soft),
            StopModel::Soft,
            StopModel::Rigid,
        ),
    ] {
        let sign = OpensWhen::Negative;
        let assessment =
            assess(&conditioned, &[], &design, &self::options(model, NEGATIVE)).unwrap();
        let options = RunOptions::new(stop, sign);
        let run = replay::run(read(used), &design, &options).unwrap().run;
        let own = run.peak_angle_rad;
        assert_eq!(assessment.nominal.peak_angle_rad, own);
        let budget = assessment.budget;
        assert_eq!(budget.numerical, Some(run.numerical_error_rad));
        let part =
            |signal: &Signal, stop, sign| Some((peak_alone(&read(signal), stop, sign) - own).abs());
        let peak = |reading: &Reading<'_>| peak_alone(reading, stop, sign);
        let readings = interpolation_rad(&conditioned, own, peak);
        let noises = [conditioned.noise.deviation_m_s2, left_out_m_s2(used)];
        let both = libm::hypot(noises[0], noises[1]);
        let parts = noises.map(|noise| deviation_rad(used, both, &design, stop) * noise / both);
        let near = |found: Option<f64>, want: f64| (found.unwrap() / want - 1.0).abs() < 1e-9;
        assert!(
            near(budget.interpolation, readings + 2.0 * parts[1]),
            "{budget:?}"
        );
        // That of a noise of 0.035 m/s² before the event.
        assert!(near(budget.noise, parts[0]), "{budget:?} {parts:?}");
        assert!(
            budget.noise > Some(1e-6) && budget.noise < Some(1e-3),
            "{budget:?}"
        );
        assert_eq!(budget.model, part(used, other, sign));
        assert_eq!(
            budget.filter,
            part(
                &conditioning::filtered(&conditioned, None).unwrap(),
                stop,
                sign
            )
        );
        assert!(budget.filter > Some(0.0));
        let shifted = |shift: f64| {
            let mut signal = used.clone();
            signal.samples.iter_mut().for_each(|a| *a += shift);
            part(&signal, stop, sign).unwrap()
        };
        let error = conditioned.bias_standard_error_m_s2;
        assert!(error > 0.0);
        assert_eq!(budget.bias, Some(shifted(error).max(shifted(-error))));
        assert_eq!(budget.polarity, None, "declared");

        let undeclared = assess(
            &conditioned,
            &[],
            &design,
            &self::options(model, Polarity::Undeclared),
        )
        .unwrap();
        let sign = undeclared.nominal.opens_when;
        let reading = read(used);
        let change = peak_alone(&reading, stop, sign) - peak_alone(&reading, stop, sign.reversed());
        let told = undeclared.budget.polarity.unwrap();
        assert!((told - change.abs()).abs() < 1e-12, "{told} {change}");
        assert!(change > 0.0, "the nominal run is the larger");
    }
    // Nothing removed, nothing filtered.
    let plain = judge(
        &samples(weak),
        &[],
        &Design::reference(),
        &options(RIGID, NEGATIVE),
    );
    assert_eq!(plain.budget.bias, None);
    assert_eq!(plain.budget.filter, Some(0.0));
}

/// A lever that starts inside the soft stop was refused: the comparison with the rigid stop,
/// which admits no such state, took the whole verdict with it.
#[test]
fn regress_a_start_inside_the_soft_stop_is_judged() {
    let own = Policy {
        initial_angle_rad: Some(-1e-4),
        ..options(ModelChoice::Only(StopModel::Soft), NEGATIVE)
    };
    let assessment = judge(&samples(weak), &[], &Design::reference(), &own);
    assert_eq!(assessment.answer, Answer::Pass);
    assert_eq!(assessment.budget.model, None);
}

#[test]
fn verif_threads_and_evidence_change_no_number() {
    let signal = samples(weak);
    let plain = judge(
        &signal,
        &[],
        &Design::reference(),
        &options(ModelChoice::Auto, Polarity::Undeclared),
    );
    for threads in [2, 3, 16] {
        let extras = AssessExtras {
            filter_table: true,
            evidence: true,
            ..AssessExtras::default()
        };
        let mut other = latchgate_verdict::assess(
            &as_recorded(signal.clone()),
            &[],
            &Design::reference(),
            &options(ModelChoice::Auto, Polarity::Undeclared),
            extras,
            &Control::unwatched(threads),
        )
        .unwrap();
        assert!(other.evidence.take().is_some());
        assert_eq!(other, plain);
    }
}

#[test]
fn verif_windows_that_hold_nothing_are_refused() {
    for (from, until) in [(5.0, 6.0), (-3.0, -2.0), (0.000_01, 0.000_09), (0.25, 0.5)] {
        let own = Policy {
            window_s: Some(Window::new(from, until)),
            ..options(RIGID, NEGATIVE)
        };
        let error =
            assess(&as_recorded(samples(weak)), &[], &Design::reference(), &own).unwrap_err();
        assert!(
            error
                .to_string()
                .contains("at least two samples of the record, which runs from -0.05 to 0.25"),
            "{error}"
        );
    }
}
