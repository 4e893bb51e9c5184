//! Guards the bounds that spare an ensemble: what they spare would have said the same.

use crate::in_plane;
use crate::support::{Random, random_design, signal, unconditioned};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY};
use latchgate_verdict::conditioning::Conditioned;
use latchgate_verdict::{
    Answer, AssessExtras, Assessment, Bound, ModelChoice, Polarity, Policy, assess,
};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Pulses one after another: amplitude [g] (negative opens), duration [s], shape.
#[derive(Clone, Copy)]
enum Shape {
    HalfSine,
    /// Terminal-peak sawtooth.
    Sawtooth,
    Pause,
}

fn pulses(rate: f64, parts: &[(Shape, f64, f64)]) -> Signal {
    let total: f64 = parts.iter().map(|part| part.2).sum();
    let count = (total * rate).round() as usize;
    let samples = (0..=count)
        .map(|k| {
            let mut t = k as f64 / rate;
            for &(shape, amplitude, duration) in parts {
                if t < duration - 1e-9 / rate {
                    return STANDARD_GRAVITY
                        * amplitude
                        * match shape {
                            Shape::HalfSine => libm::sin(PI * t / duration),
                            Shape::Sawtooth => t / duration,
                            Shape::Pause => 0.0,
                        };
                }
                t -= duration;
            }
            0.0
        })
        .collect();
    signal(rate, samples)
}

const KINDS: [&str; 9] = [
    "opening half-sine",
    "opening sawtooth",
    "holding sawtooth",
    "opening, then holding",
    "counter pulses",
    "burst",
    "two pulses far apart",
    "noise",
    "plateau",
];

fn random_recording(random: &mut Random, kind: usize) -> Signal {
    use Shape::{HalfSine, Pause, Sawtooth};
    let rate = [2_000.0, 5_000.0, 10_000.0, 20_000.0][random.below(4)];
    let mut short = || random.scale(5e-4, 2e-2);
    let (one, two, three) = (short(), short(), short());
    let tail = (Pause, 0.0, random.scale(1e-3, 0.05));
    let mut made = match kind {
        0 => pulses(rate, &[(Pause, 0.0, 1e-3), (HalfSine, -1.0, one), tail]),
        1 => pulses(rate, &[(Sawtooth, -1.0, one), tail]),
        2 => pulses(rate, &[(Sawtooth, 1.0, one), tail]),
        3 => {
            let strong = random.scale(0.3, 30.0);
            pulses(
                rate,
                &[
                    (HalfSine, -1.0, one),
                    (Pause, 0.0, two),
                    (HalfSine, strong, three),
                    tail,
                ],
            )
        }
        4 => {
            let mut parts = vec![];
            for k in 0..2 + random.below(4) {
                let sign = if k % 2 == 0 { -1.0 } else { 1.0 };
                parts.push((
                    HalfSine,
                    sign * random.scale(0.3, 3.0),
                    random.scale(1e-3, 1e-2),
                ));
                parts.push((Pause, 0.0, random.scale(1e-4, 2e-2)));
            }
            parts.push(tail);
            pulses(rate, &parts)
        }
        5 => {
            let tone = random.scale(20.0, 400.0);
            let decay = random.scale(3e-3, 3e-2);
            let phase = random.between(0.0, 6.3);
            let count = (5.0 * decay * rate) as usize + 2;
            let samples = (0..count)
                .map(|k| {
                    let t = k as f64 / rate;
                    9.8 * t / decay
                        * libm::exp(1.0 - t / decay)
                        * (libm::sin(2.0 * PI * tone * t + phase)
                            + libm::sin(2.0 * PI * 1.618 * tone * t))
                })
                .collect();
            signal(rate, samples)
        }
        6 => {
            let second = random.scale(0.5, 2.0);
            pulses(
                1_000.0,
                &[
                    (HalfSine, -1.0, random.scale(3e-3, 1e-2)),
                    (Pause, 0.0, random.scale(0.05, 1.0)),
                    (HalfSine, -second, random.scale(3e-3, 1e-2)),
                    tail,
                ],
            )
        }
        7 => {
            let count = 3 + random.below(200);
            let samples = (0..count)
                .map(|_| 9.8 * random.between(-1.0, 1.0))
                .collect();
            signal(rate, samples)
        }
        _ => {
            let count = 3 + random.below(300);
            let place = random.below(count);
            let (before, after) = (random.between(-1.0, 1.0), random.between(-2.0, 1.0));
            let samples = (0..count)
                .map(|k| 9.8 * if k < place { before } else { after })
                .collect();
            signal(rate, samples)
        }
    };
    if random.one_in(3) {
        let noise = random.scale(1e-4, 0.1);
        for a in &mut made.samples {
            *a += noise * random.between(-9.8, 9.8);
        }
    }
    if random.one_in(4) {
        let bias = random.between(-0.1, 0.1);
        made.samples.iter_mut().for_each(|a| *a += 9.8 * bias);
    }
    made
}

fn judge(signal: &Signal, design: &Design, policy: &Policy, follow_all: bool) -> Assessment {
    judge_recording(&unconditioned(signal), design, policy, follow_all)
}

fn judge_recording(
    recording: &Conditioned,
    design: &Design,
    policy: &Policy,
    follow_all: bool,
) -> Assessment {
    let extras = AssessExtras {
        follow_all,
        ..AssessExtras::default()
    };
    let control = Control::unwatched(1);
    assess(recording, &[], design, policy, extras, &control).unwrap()
}

/// Scenes of an ordinary run.
const SCENES: u64 = 580;

/// Scenes of two sensors.
const IN_PLANE_SCENES: u64 = 180;

/// What bounds spared of the stops and signs of all scenes.
#[derive(Default)]
struct Spared {
    by_bound: BTreeMap<&'static str, u32>,
    runs: u32,
}

impl Spared {
    /// Checks that what is spared of a recording would have said the same, as all of its levers stay below the limit.
    #[track_caller]
    fn check(&mut self, recording: &Conditioned, design: &Design, policy: &Policy, label: &str) {
        let found = judge_recording(recording, design, policy, false);
        let full = judge_recording(recording, design, policy, true);
        assert_eq!(found.answer, full.answer, "{label}");
        assert_eq!(found.nominal, full.nominal, "{label}");
        for (answer, full_answer) in found.answers.iter().zip(&full.answers) {
            self.runs += 1;
            let Some(bound) = answer.bound else {
                continue;
            };
            assert_eq!(answer.answer, full_answer.answer, "{label}");
            assert_eq!(
                answer.uncertainty_rad, full_answer.uncertainty_rad,
                "{label}"
            );
            let variant = (answer.model, answer.opens_when);
            let of_variant =
                |one: &&latchgate_verdict::Ensemble| (one.model, one.opens_when) == variant;
            let ensembles = || full.ensembles.iter().chain(&full.ensemble);
            // One that could not change the answer any more was not run in full either.
            if let Some(ensemble) = ensembles().find(of_variant) {
                let crossing = ensemble.exceeded + ensemble.exceeded_in_coast;
                assert_eq!(crossing + ensemble.failed_to_run, 0, "{label}");
            }
            *self.by_bound.entry(bound.name()).or_default() += 1;
        }
    }

    /// Checks that either bound spared something, of so many.
    #[track_caller]
    fn check_both_bounds(&self, least: u32) {
        println!(
            "{:?} of {} stops and signs spared",
            self.by_bound, self.runs
        );
        for bound in [Bound::NeverLifts, Bound::CannotReach] {
            let count = self.by_bound.get(bound.name()).copied().unwrap_or(0);
            assert!(count >= least, "{:?}", self.by_bound);
        }
    }
}

/// A recording of this kind, weak or strong.
fn random_scene(random: &mut Random, kind: usize) -> Signal {
    let mut signal = random_recording(random, kind);
    let scale = random.scale(0.03, 30.0);
    signal.samples.iter_mut().for_each(|a| *a *= scale);
    signal
}

/// A design and a policy of a scene.
fn random_question(random: &mut Random, seed: u64) -> (Design, Policy) {
    let mut design = random_design(random);
    design.criterion.threshold_rad = random.scale(0.01, 0.6);
    design.input.scale = random.scale(1e-3, 0.05);
    design.input.bias_g = random.scale(1e-3, 0.3);
    let polarity = match random.one_in(5) {
        true => Polarity::Undeclared,
        false => Polarity::Declared(OpensWhen::Negative),
    };
    let policy = Policy {
        members: [128, 600][random.below(2)],
        seed,
        ..Policy::new(ModelChoice::Auto, polarity)
    };
    (design, policy)
}

/// Over scenes of every kind, weak and strong, a bound spares an ensemble of which no lever crosses, and no
/// answer differs from that of the ensemble.
#[test]
fn prop_what_a_bound_spares_would_have_said_the_same() {
    let mut spared = Spared::default();
    for seed in 0..SCENES {
        let mut random = Random(40_000_000 + seed);
        let kind = (seed % KINDS.len() as u64) as usize;
        let signal = random_scene(&mut random, kind);
        let (design, policy) = random_question(&mut random, seed);
        let label = format!("seed {seed} ({})", KINDS[kind]);
        spared.check(&unconditioned(&signal), &design, &policy, &label);
    }
    spared.check_both_bounds(20);
}

/// The same of two sensors, each of a kind and strength of its own, before levers that see them at any angle.
#[test]
fn prop_what_a_bound_spares_of_two_sensors_would_have_said_the_same() {
    let mut spared = Spared::default();
    for seed in 0..IN_PLANE_SCENES {
        let mut random = Random(50_000_000 + seed);
        let kinds = [0, 1].map(|_| random.below(KINDS.len()));
        let [y, mut x] = kinds.map(|kind| random_scene(&mut random, kind));
        // One clock: what is missing of the second is rest.
        x.samples.resize(y.samples.len(), 0.0);
        x.rate = y.rate;
        let (mut design, policy) = random_question(&mut random, seed);
        in_plane::turn(&mut design.lever, random.between(-1.3, 1.3));
        let errors_m_s2 = [0, 1].map(|_| random.scale(1e-3, 3.0));
        let recording = in_plane::two_sensors((&y, errors_m_s2[0]), (&x, errors_m_s2[1]));
        let label = format!("seed {seed} ({} and {})", KINDS[kinds[0]], KINDS[kinds[1]]);
        spared.check(&recording, &design, &policy, &label);
    }
    spared.check_both_bounds(10);
}

/// A weak pulse never lifts the lever off its rigid stop; nothing is spared near the limit, with a start of its
/// own, or where every ensemble is asked for.
#[test]
fn verif_bounds_spare_what_they_speak_of() {
    let pulse = |peak_g: f64| {
        let parts = [
            (Shape::Pause, 0.0, 0.01),
            (Shape::HalfSine, peak_g, 0.01),
            (Shape::Pause, 0.0, 0.05),
        ];
        pulses(10_000.0, &parts)
    };
    let policy = Policy {
        members: 128,
        ..Policy::new(ModelChoice::Auto, Polarity::Declared(OpensWhen::Negative))
    };
    let design = Design::reference();
    let bounds = |found: &Assessment| -> Vec<Option<Bound>> {
        found.answers.iter().map(|own| own.bound).collect()
    };
    let weak = judge(&pulse(-0.5), &design, &policy, false);
    assert_eq!(weak.answer, Answer::Pass);
    assert_eq!(
        bounds(&weak),
        [Some(Bound::NeverLifts), Some(Bound::CannotReach)]
    );
    assert!(weak.ensemble.is_none() && weak.ensembles.is_empty());
    assert_eq!(
        bounds(&judge(&pulse(-0.5), &design, &policy, true)),
        [None, None]
    );
    assert_eq!(
        bounds(&judge(&pulse(-8.3), &design, &policy, false)),
        [None, None]
    );
    let moving = Policy {
        initial_velocity_rad_s: Some(0.1),
        ..policy
    };
    assert_eq!(
        bounds(&judge(&pulse(-0.5), &design, &moving, false)),
        [None, None]
    );
}

/// A small acceleration that holds the lever is scaled down where a large bias takes it off its stop.
#[test]
fn regress_what_holds_the_lever_is_scaled_down() {
    let held = signal(10_000.0, vec![1.5; 1_000]);
    let mut design = Design::reference();
    design.input.scale = 0.1;
    design.input.bias_g = 0.4;
    let policy = Policy {
        members: 128,
        ..Policy::new(
            ModelChoice::Only(StopModel::Rigid),
            Polarity::Declared(OpensWhen::Negative),
        )
    };
    // 1.05 m/s² at three standard deviations less, and −11.77 of bias: beyond −10.43, where the lever lifts.
    assert_eq!(judge(&held, &design, &policy, false).answers[0].bound, None);
    // At 0.3 g of bias −8.8 m/s² are left.
    design.input.bias_g = 0.3;
    let bound = judge(&held, &design, &policy, false).answers[0].bound;
    assert_eq!(bound, Some(Bound::NeverLifts));
}
