//! Guards the ladder: leaving out what bounds prove changes no verdict, and what it says of
//! itself is so.

use crate::screens::{KINDS, random_recording};
use crate::support::{Random, random_design};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::replay::Method;
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY, SampleRate};
use latchgate_verdict::conditioning::{Conditioned, FilterStandard, Signal};
use latchgate_verdict::ladder::Rung;
use latchgate_verdict::screen::{self, Decided, Seen, Subject};
use latchgate_verdict::{Answer, AssessExtras, Assessment, ModelChoice, Polarity, Policy, assess};
use std::collections::BTreeMap;

const NEGATIVE: Polarity = Polarity::Declared(OpensWhen::Negative);

fn as_recorded(signal: &Signal) -> Conditioned {
    Conditioned {
        raw: signal.clone(),
        used: signal.clone(),
        bias_m_s2: 0.0,
        bias_standard_error_m_s2: 0.0,
        bias_samples: 0,
        bias_window_s: None,
        filter: None,
        filter_standard: FilterStandard::Iso6487,
        resample_hz: None,
        velocity_change_m_s: 0.0,
        slow_clock: None,
        findings: Vec::new(),
    }
}

fn judge(signal: &Signal, design: &Design, options: &Policy) -> Assessment {
    judge_with(signal, design, options, AssessExtras::default())
}

/// Judges with every stop followed in full.
fn judge_in_full(signal: &Signal, design: &Design, options: &Policy) -> Assessment {
    let extras = AssessExtras {
        follow_all: true,
        ..AssessExtras::default()
    };
    judge_with(signal, design, options, extras)
}

fn judge_with(
    signal: &Signal,
    design: &Design,
    options: &Policy,
    extras: AssessExtras,
) -> Assessment {
    let control = Control::unwatched(1);
    assess(&as_recorded(signal), &[], design, options, extras, &control).unwrap()
}

/// A half-sine pulse [g, s] at 10 kHz, with rest before and after.
fn pulse(peak_g: f64, length_s: f64) -> Signal {
    let rate = 10_000.0;
    Signal {
        start_s: -0.01,
        rate: SampleRate::from_hertz(rate).unwrap(),
        samples: (-100..=1200)
            .map(|index| {
                let t = f64::from(index) / rate;
                if (0.0..length_s).contains(&t) {
                    peak_g * STANDARD_GRAVITY * libm::sin(std::f64::consts::PI * t / length_s)
                } else {
                    0.0
                }
            })
            .collect(),
    }
}

fn asked(members: u32, polarity: Polarity) -> Policy {
    Policy {
        members,
        ..Policy::new(ModelChoice::Auto, polarity)
    }
}

// What it does to clear cases.

#[track_caller]
fn check_climbed(
    signal: &Signal,
    options: &Policy,
    rung: Rung,
    left_out: &[(StopModel, Answer)],
) -> Assessment {
    let found = judge(signal, &Design::reference(), options);
    assert_eq!(found.ladder.rung, rung, "{:#?}", found.ladder);
    let out: Vec<(StopModel, Answer)> = found
        .ladder
        .stops
        .iter()
        .filter(|step| step.left_out)
        .map(|step| (step.model, step.answer))
        .collect();
    assert_eq!(out, left_out, "{:#?}", found.ladder);
    // Its nominal run is there all the same, and that with the larger peak is followed.
    assert_eq!(found.models.len(), 2);
    for step in found.ladder.stops.iter().filter(|step| step.left_out) {
        let run = &found.models[&step.model];
        assert!(run.peak_angle_rad <= found.nominal.peak_angle_rad);
        let answer = found.answers.iter().find(|own| own.model == step.model);
        assert_eq!(answer.unwrap().interpolation_error_rad, None);
        assert!(found.ensembles.iter().all(|own| own.model != step.model));
    }
    found
}

/// Far below the limit the bounds prove a pass of both stops, with and without an ensemble.
#[test]
fn verif_a_weak_pulse_is_proven_to_pass() {
    for members in [0, 128, 10_000] {
        let found = check_climbed(
            &pulse(-2.0, 0.01),
            &asked(members, NEGATIVE),
            Rung::Bounds,
            &[(StopModel::Rigid, Answer::Pass)],
        );
        assert_eq!(found.answer, Answer::Pass);
        assert_eq!(found.ensemble.is_some(), members > 0);
        let runs = 1 + 5 + u64::from(members.min(128));
        assert_eq!(found.ladder.samples_replayed, 1301 * runs);
    }
}

/// A crossing in the first flight proves a failure by nearly all scattered levers; of the
/// nominal lever alone it does not, since the rule then asks for the error of its peak.
#[test]
fn verif_a_strong_pulse_is_proven_to_fail() {
    let strong = pulse(-40.0, 0.01);
    let found = judge(&strong, &Design::reference(), &asked(10_000, NEGATIVE));
    assert_eq!(found.answer, Answer::Fail);
    assert_eq!(found.ladder.rung, Rung::Bounds);
    assert_eq!(found.ladder.stops.iter().filter(|s| s.left_out).count(), 1);
    check_climbed(&strong, &asked(0, NEGATIVE), Rung::NominalRuns, &[]);
}

/// A holding pulse that ends suddenly: a certain failure on the soft stop, which it throws open, and
/// no certain pass on the rigid one, since nobody knows what it does within its last interval.
#[test]
fn verif_a_jump_that_may_open_is_not_left_to_bounds() {
    let mut sawtooth = pulse(0.0, 0.01);
    for (index, a) in sawtooth.samples.iter_mut().enumerate() {
        if (100..200).contains(&index) {
            *a = 10.0 * (index as f64 - 99.0) * STANDARD_GRAVITY;
        }
    }
    let found = check_climbed(&sawtooth, &asked(128, NEGATIVE), Rung::Ensemble, &[]);
    assert_eq!(found.answer, Answer::Undecided);
    assert!(found.models[&StopModel::Soft].peak_angle_rad > 0.2);
    assert_eq!(found.models[&StopModel::Rigid].peak_angle_rad, 0.0);
}

/// Near the limit no bound decides, and both stops are followed.
#[test]
fn verif_near_the_limit_nothing_is_left_out() {
    let near = pulse(-8.3, 0.01);
    let found = check_climbed(&near, &asked(512, NEGATIVE), Rung::Ensemble, &[]);
    assert_eq!(found.ensembles.len(), 2);
    assert!(
        found.ladder.text.contains("no bound proves"),
        "{}",
        found.ladder.text
    );
}

/// Where the proofs do not speak, nothing is left out, and the ladder says why.
#[test]
fn verif_what_the_proofs_do_not_cover_is_followed() {
    let weak = pulse(-2.0, 0.01);
    let own = asked(128, NEGATIVE);
    for (options, word) in [
        (
            Policy {
                initial_velocity_rad_s: Some(0.1),
                ..own.clone()
            },
            "initial state",
        ),
        (
            Policy {
                method: Method::Rk4 {
                    steps_per_period: 2000,
                },
                ..own.clone()
            },
            "method",
        ),
        (
            Policy {
                model: ModelChoice::Only(StopModel::Soft),
                ..own.clone()
            },
            "given",
        ),
    ] {
        check_followed(&judge(&weak, &Design::reference(), &options), word);
    }
    check_followed(&judge_in_full(&weak, &Design::reference(), &own), "in full");
}

#[track_caller]
fn check_followed(found: &Assessment, word: &str) {
    // A method that states no bound decides no pass.
    let expected = if word == "method" {
        Answer::Undecided
    } else {
        Answer::Pass
    };
    assert_eq!(found.answer, expected);
    assert!(found.ladder.stops.iter().all(|step| !step.left_out));
    assert!(found.ladder.text.contains(word), "{}", found.ladder.text);
}

/// With two polarities each is proven by itself.
#[test]
fn verif_polarities_are_proven_one_by_one() {
    let strong = pulse(-40.0, 0.01);
    let own = asked(128, Polarity::Undeclared);
    let found = judge(&strong, &Design::reference(), &own);
    let full = judge_in_full(&strong, &Design::reference(), &own);
    assert_eq!(
        (found.answer, full.answer),
        (Answer::Undecided, Answer::Undecided)
    );
    assert!(found.ladder.stops.iter().any(|step| step.left_out));
    assert!(found.ladder.samples_replayed < full.ladder.samples_replayed / 2);
}

// Against the full run.

/// What a run over random cases found.
#[derive(Default)]
struct Tally {
    cases: u32,
    passes: u32,
    left_out: u32,
    by_bounds: u32,
    samples: u64,
    in_full: u64,
}

/// A scale that brings the recording near what bounds can prove, or any.
fn random_scale(random: &mut Random, recording: &Signal, design: &Design) -> f64 {
    if random.one_in(2) {
        return random.scale(0.1, 300.0);
    }
    let model = if random.one_in(2) {
        StopModel::Rigid
    } else {
        StopModel::Soft
    };
    let subject = Subject {
        lever: design.lever,
        stop: design.stop,
        model,
        threshold_rad: design.criterion.threshold_rad,
        initial: None,
        window: None,
    };
    let seen = Seen::of(recording, OpensWhen::Negative);
    let wanted = if random.one_in(2) {
        Some(Decided::Pass)
    } else {
        None
    };
    let (mut low, mut high) = (1e-3, 1e4);
    for _ in 0..16 {
        let middle = libm::sqrt(low * high);
        let answer = screen::decide(&subject, &seen.changed(middle, 0.0));
        if answer == Some(Decided::Pass) || answer == wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    low * random.scale(0.6, 1.3)
}

#[track_caller]
fn check_against_full_runs(base: u64, cases: u64) {
    let mut of_kind: Vec<Tally> = KINDS.iter().map(|_| Tally::default()).collect();
    let mut answers: BTreeMap<&str, u32> = BTreeMap::new();
    for seed in base..base + cases {
        let mut random = Random(seed);
        let kind = (seed % KINDS.len() as u64) as usize;
        let mut signal = random_recording(&mut random, kind);
        let mut design = random_design(&mut random);
        design.criterion.threshold_rad = random.scale(0.01, 0.6);
        design.tolerance.clear();
        if random.one_in(2) {
            design.tolerance.insert("restitution".into(), 0.02);
            design.tolerance.insert(
                "preload_torque_nm".into(),
                0.05 * design.lever.preload_torque_nm,
            );
        }
        let scale = random_scale(&mut random, &signal, &design);
        signal.samples.iter_mut().for_each(|a| *a *= scale);
        design.input.scale = random.scale(1e-3, 0.05);
        design.input.bias_g = random.scale(1e-3, 0.3);
        let count = signal.samples.len();
        let window_s = random.one_in(6).then(|| {
            let first = random.below(count / 2);
            (signal.time_s(first), signal.time_s(count - 1))
        });
        let polarity = if random.one_in(5) {
            Polarity::Undeclared
        } else {
            NEGATIVE
        };
        let options = Policy {
            window_s,
            seed,
            ..asked([0, 128, 128, 600][random.below(4)], polarity)
        };
        let own = judge(&signal, &design, &options);
        let full = judge_in_full(&signal, &design, &options);
        let label = || {
            format!(
                "seed {seed} ({}): {} by {:#?}, in full {} by {:#?}",
                KINDS[kind],
                own.answer.name(),
                own.ladder,
                full.answer.name(),
                full.answers
            )
        };
        assert_eq!(own.answer, full.answer, "{}", label());
        assert_eq!(own.nominal, full.nominal, "{}", label());
        assert_eq!(own.ensemble, full.ensemble, "{}", label());
        let mut out = 0;
        for step in &own.ladder.stops {
            let truth = full
                .answers
                .iter()
                .find(|other| (other.model, other.opens_when) == (step.model, step.opens_when))
                .unwrap();
            if step.left_out || step.by == Rung::Bounds {
                assert_eq!(step.answer, truth.answer, "{}", label());
            }
            out += u32::from(step.left_out);
        }
        let tally = &mut of_kind[kind];
        tally.cases += 1;
        tally.passes += u32::from(own.answer == Answer::Pass);
        tally.left_out += u32::from(out > 0);
        tally.by_bounds += u32::from(own.ladder.rung == Rung::Bounds);
        tally.samples += own.ladder.samples_replayed;
        tally.in_full += full.ladder.samples_replayed;
        *answers.entry(own.answer.name()).or_default() += 1;
    }
    println!("{cases} cases: {answers:?}");
    let (mut samples, mut in_full, mut out) = (0, 0, 0);
    for (kind, tally) in KINDS.iter().zip(&of_kind) {
        let share = |count: u32| 100.0 * f64::from(count) / f64::from(tally.cases.max(1));
        println!(
            "  {kind}: {} cases, {:.0} % pass; a stop left out in {:.0} %, bounds alone decide {:.0} %; samples replayed {:.0} % of the full run",
            tally.cases,
            share(tally.passes),
            share(tally.left_out),
            share(tally.by_bounds),
            100.0 * tally.samples as f64 / tally.in_full as f64
        );
        samples += tally.samples;
        in_full += tally.in_full;
        out += tally.left_out;
    }
    println!(
        "  all: samples replayed {:.1} % of the full run",
        100.0 * samples as f64 / in_full as f64
    );
    // A ladder that leaves nothing out would agree with everything.
    assert!(u64::from(out) * 3 > cases, "{out} of {cases}");
    for answer in ["pass", "fail", "undecided"] {
        assert!(
            u64::from(answers.get(answer).copied().unwrap_or(0)) * 50 > cases,
            "{answers:?}"
        );
    }
}

/// Cases of an ordinary run; `LATCHGATE_LADDER_CASES` asks for another number.
const CASES: u64 = if cfg!(debug_assertions) { 400 } else { 2_000 };

#[test]
fn prop_the_ladder_answers_as_the_full_run_of_both_stops() {
    let asked = std::env::var("LATCHGATE_LADDER_CASES").ok();
    let cases = asked.map_or(CASES, |cases| cases.parse().unwrap());
    check_against_full_runs(30_000_000, cases);
}
