//! Guards two in-plane sensors near the limit: the size of each term that the second one adds to the scatter,
//! to the ensemble and to the bounds that spare an ensemble.
//!
//! The lever turns about a vertical axis and its centre of mass lies behind the pivot, turned outwards or
//! inwards by an angle α. Of a left door Y counts by cos α along the way of the centre of mass and by sin α
//! along the arm, X by sin α and cos α.

use crate::support::{signal, unconditioned};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::lever::Lever;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::model::vector::Vector;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::replay::{self, RunOptions};
use latchgate_kernel::signal::{Reading, Signal};
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY};
use latchgate_verdict::conditioning::{Between, Conditioned, SecondSensor};
use latchgate_verdict::ensemble::Scatter;
use latchgate_verdict::{
    AssessExtras, Assessment, Bound, ModelChoice, Polarity, Policy, RunAnswer, assess,
};

const STOPS: [StopModel; 2] = [StopModel::Rigid, StopModel::Soft];

/// The signs of Y that open the left and the right door.
const DOORS: [OpensWhen; 2] = [OpensWhen::Positive, OpensWhen::Negative];

/// Standard deviations at which draws end.
const DRAWS_END: f64 = 3.0;

/// Angles of the centre of mass behind the pivot [degrees]: X counts along the arm alone, or in both directions.
const ANGLES_DEG: [f64; 3] = [0.0, 35.0, -50.0];

/// The sign of Y that opens.
fn opening(opens_when: OpensWhen) -> f64 {
    match opens_when {
        OpensWhen::Positive => 1.0,
        OpensWhen::Negative => -1.0,
    }
}

/// The sign of X that opens where the centre of mass lies at this angle.
fn opening_sign_of_x(angle_rad: f64) -> f64 {
    -angle_rad.signum()
}

/// Turns a lever about a vertical axis, its centre of mass at `angle_rad` behind the pivot.
pub(super) fn turn(lever: &mut Lever, angle_rad: f64) {
    let (sine, cosine) = libm::sincos(angle_rad);
    let distance_m = lever.center_of_mass_m;
    lever.axis = Some(Vector([0.0, 0.0, 1.0]));
    lever.center_of_mass = Some(Vector([-distance_m * cosine, -distance_m * sine, 0.0]));
}

/// The paper's lever, its centre of mass at `angle_rad` behind the pivot.
fn turned_design(angle_rad: f64) -> Design {
    let mut design = Design::reference();
    turn(&mut design.lever, angle_rad);
    design
}

/// Two sensors, each with the standard error of its bias [m/s²].
pub(super) fn two_sensors(y: (&Signal, f64), x: (&Signal, f64)) -> Conditioned {
    let sensor = |(signal, bias_standard_error_m_s2): (&Signal, f64)| Conditioned {
        bias_standard_error_m_s2,
        ..unconditioned(signal)
    };
    Conditioned {
        second: Some(Box::new(SecondSensor {
            name: "acc_x".into(),
            axis: Some('X'),
            judged_is_reversed: false,
            judged_side: None,
            conditioned: sensor(x),
        })),
        ..sensor(y)
    }
}

/// Judges one stop where this sign of Y opens, along straight lines between the samples.
fn judge(
    recording: &Conditioned,
    design: &Design,
    (stop, opens_when): (StopModel, OpensWhen),
) -> Assessment {
    let policy = Policy {
        members: 128,
        between: Between::Linear,
        ..Policy::new(ModelChoice::Only(stop), Polarity::Declared(opens_when))
    };
    let control = Control::unwatched(1);
    let extras = AssessExtras::default();
    assess(recording, &[], design, &policy, extras, &control).unwrap()
}

// ---------------------------------------------------------------- the scatter

/// Scale and bias of the second sensor: as uncertain as the first by the design, the bias by its own measured
/// error where that is the larger.
#[test]
fn verif_scale_and_bias_of_the_second_sensor() {
    /// Variance of a normal distribution that ends at three standard deviations.
    const TRUNCATED_VARIANCE: f64 = 0.973_337;
    let design = Design::reference();
    let design_bias_m_s2 = 0.1 * STANDARD_GRAVITY;
    for (error_m_s2, expected_m_s2) in
        [(0.0, design_bias_m_s2), (0.5, design_bias_m_s2), (2.0, 2.0)]
    {
        // The error of the first sensor is another one, so that neither takes the other's place.
        let scatter = Scatter::new(&design, 7.0, 1)
            .unwrap()
            .with_second_sensor(&design, error_m_s2);
        let second_of = |index| scatter.member(index).second;
        let deviation = |of_member: &dyn Fn(u32) -> f64| {
            let squares = (1..=4000).map(|index| of_member(index) * of_member(index));
            (squares.sum::<f64>() / 4000.0 / TRUNCATED_VARIANCE).sqrt()
        };
        let scale = deviation(&|index| second_of(index).scale - 1.0);
        let bias_m_s2 = deviation(&|index| second_of(index).bias_m_s2);
        assert!((scale / 0.01 - 1.0).abs() < 0.04, "{error_m_s2}: {scale}");
        assert!(
            (bias_m_s2 / expected_m_s2 - 1.0).abs() < 0.04,
            "{error_m_s2}: {bias_m_s2}"
        );
        assert_eq!(scatter.member(0).second.scale, 1.0);
        assert_eq!(scatter.member(0).second.bias_m_s2, 0.0);
    }
}

/// A push along Y and a longer one along X [m/s²], in 100 samples at 2 kHz.
fn pushes(y_m_s2: f64, x_m_s2: f64) -> [Signal; 2] {
    [(y_m_s2, 0.012), (x_m_s2, 0.03)].map(|(peak_m_s2, length_s)| {
        let at = |index: i32| {
            let part = (f64::from(index) / 2000.0 - 0.001) / length_s;
            match (0.0..=1.0).contains(&part) {
                true => peak_m_s2 * libm::sin(std::f64::consts::PI * part),
                false => 0.0,
            }
        };
        signal(2000.0, (0..100).map(at).collect())
    })
}

/// The ensemble of two sensors is what each of its levers does on samples that are scaled and shifted by hand,
/// each sensor by draws of its own: the peaks, and how many cross a limit in their midst.
#[test]
fn verif_an_ensemble_of_two_sensors_is_what_its_members_say() {
    const SEED: u64 = 1;
    let (scale, biases_m_s2) = (0.01, [0.8, 3.0]);
    for angle_deg in ANGLES_DEG {
        let angle_rad = angle_deg.to_radians();
        let (sine, cosine) = libm::sincos(angle_rad);
        let mut design = turned_design(angle_rad);
        design.stop.restitution = 0.8;
        design.tolerance.clear();
        design.input.scale = scale;
        design.input.bias_g = 0.01;
        let scatter = Scatter::new(&design, biases_m_s2[0], SEED)
            .unwrap()
            .with_second_sensor(&design, biases_m_s2[1]);
        let draw = |index: u32, name: &str| {
            let mut parameters = scatter.parameters().iter();
            let parameter = parameters.find(|parameter| parameter.name == name);
            scatter.draw(index, parameter.unwrap())
        };
        // Of the right door Y is mirrored, but for what the draws add.
        for (stop, opens_when) in STOPS
            .into_iter()
            .flat_map(|stop| DOORS.map(|door| (stop, door)))
        {
            let side = opening(opens_when);
            let [y, x] = pushes(side * 80.0, 60.0 * opening_sign_of_x(angle_rad));
            let peak_of = |index: u32| {
                let scales = ["input.scale", "input.radial_scale"].map(|name| draw(index, name));
                let shifts = ["input.bias_g", "input.radial_bias_g"].map(|name| draw(index, name));
                let read = |sensor: usize, sample: f64| {
                    (1.0 + scale * scales[sensor]) * sample + biases_m_s2[sensor] * shifts[sensor]
                };
                let both = |y_part: f64, x_part: f64| {
                    let pairs = y.samples.iter().zip(&x.samples);
                    let sum = |(y, x): (&f64, &f64)| y_part * read(0, *y) + x_part * read(1, *x);
                    signal(y.rate.hertz(), pairs.map(sum).collect())
                };
                let along = both(-side * cosine, sine);
                let outwards = both(-side * sine, -cosine);
                let reading = Reading::from(&along).beside((&outwards).into()).unwrap();
                let options = RunOptions::new(stop, OpensWhen::Negative);
                let outcome = replay::run(&reading, &design, &options).unwrap();
                outcome.run.peak_angle_rad
            };
            let mut peaks: Vec<f64> = (0..128).map(peak_of).collect();
            peaks.sort_by(f64::total_cmp);
            let crossing = 40;
            let mut design = design.clone();
            design.criterion.threshold_rad =
                f64::midpoint(peaks[127 - crossing], peaks[128 - crossing]);
            let recording = two_sensors((&y, biases_m_s2[0]), (&x, biases_m_s2[1]));
            let ensemble = judge(&recording, &design, (stop, opens_when))
                .ensemble
                .unwrap();
            let case = format!("{angle_deg}°, {stop:?}, {opens_when:?}");
            assert_eq!(ensemble.exceeded as usize, crossing, "{case}");
            let quantiles = ensemble.peak_angle_rad.unwrap();
            for (found, expected) in [
                (quantiles.max, peaks[127]),
                (quantiles.p50, f64::midpoint(peaks[63], peaks[64])),
            ] {
                let away = (found / expected - 1.0).abs();
                assert!(away < 1e-6, "{case}: {found} for {expected}");
            }
        }
    }
}

// ---------------------------------------------------------------- the bounds

/// What a bound is about: a recording that jumps from rest to constant accelerations, on which it ends, and the
/// scatter of a design by hand.
struct Jump {
    /// Angle of the centre of mass [rad]; `None` where Y alone is recorded.
    angle_rad: Option<f64>,
    /// Samples at rest before it.
    rest_samples: usize,
    /// Intervals after it.
    intervals: usize,
    /// Limit [rad].
    limit_rad: f64,
}

const SCALE: f64 = 0.02;
/// Standard deviations of the biases of Y, which the design states, and X, which was measured [m/s²].
const BIASES_M_S2: [f64; 2] = [0.4, 0.9];
const TOLERANCES: [(&str, f64); 4] = [
    ("mass_kg", 0.004),
    ("preload_torque_nm", 0.005),
    ("moment_of_inertia_kg_m2", 2e-5),
    ("spring_stiffness_nm_per_rad", 0.01),
];
const RATE_HZ: f64 = 10_000.0;

impl Jump {
    fn design(&self) -> Design {
        let mut design = match self.angle_rad {
            Some(angle_rad) => turned_design(angle_rad),
            None => Design::reference(),
        };
        design.criterion.threshold_rad = self.limit_rad;
        design.input.scale = SCALE;
        design.input.bias_g = BIASES_M_S2[0] / STANDARD_GRAVITY;
        let tolerances = TOLERANCES.map(|(key, deviation)| (key.to_string(), deviation.into()));
        design.tolerance = tolerances.into();
        design
    }

    /// By how much Y and X count along the way of the centre of mass, and along the arm.
    fn cosines(&self) -> [[f64; 2]; 2] {
        let Some(angle_rad) = self.angle_rad else {
            return [[1.0, 0.0], [0.0, 0.0]];
        };
        let (sine, cosine) = libm::sincos(angle_rad);
        [[cosine.abs(), sine.abs()], [sine.abs(), cosine.abs()]]
    }

    /// Judges it at these accelerations of Y and X [m/s²], on a stop of the left or the right door.
    fn answer(&self, [y, x]: [f64; 2], stop: StopModel, opens_when: OpensWhen) -> RunAnswer {
        let samples = |level: f64| {
            let rest = std::iter::repeat_n(0.0, self.rest_samples);
            let levels = std::iter::repeat_n(level, self.intervals + 1);
            signal(RATE_HZ, rest.chain(levels).collect())
        };
        let y = samples(opening(opens_when) * y);
        let recording = match self.angle_rad {
            Some(_) => two_sensors((&y, 0.0), (&samples(x), BIASES_M_S2[1])),
            None => unconditioned(&y),
        };
        let mut found = judge(&recording, &self.design(), (stop, opens_when));
        found.answers.remove(0)
    }
}

/// Mass, preload, inertia and stiffness of the lever that opens most easily, where draws end.
fn loosest_lever() -> [f64; 4] {
    let lever = Design::reference().lever;
    let [mass, preload, inertia, stiffness] =
        TOLERANCES.map(|(_, deviation)| DRAWS_END * deviation);
    [
        lever.mass_kg + mass,
        lever.preload_torque_nm - preload,
        lever.moment_of_inertia_kg_m2 - inertia,
        lever.spring_stiffness_nm_per_rad - stiffness,
    ]
}

/// Checks on both sides of a bound, at this part of the accelerations that meet it exactly, on both doors.
#[track_caller]
fn check_bound(jump: &Jump, levels: [f64; 2], stop: StopModel, bound: Bound) {
    for opens_when in DOORS {
        for (part, is_spared) in [(1.0 - 1e-4, true), (1.0 + 1e-4, false)] {
            let found = jump.answer(levels.map(|level| part * level), stop, opens_when);
            let case = format!(
                "{:?} rad, {} samples at rest, {} intervals, limit {}, {stop:?}, {opens_when:?}, {part}",
                jump.angle_rad, jump.rest_samples, jump.intervals, jump.limit_rad
            );
            assert_eq!(found.bound == Some(bound), is_spared, "{case}: {found:?}");
        }
    }
}

/// The impulse of all sensors, each at the end of its draws, against √(2 I0 (T0 φ* + k0 φ*²/2))/(m L) of the
/// loosest lever: every interval counts, on a rigid stop from the one on in which it can lift, on a soft one from
/// the first.
#[test]
fn verif_cannot_reach_turns_at_the_impulse_of_all_sensors() {
    let [mass, preload, inertia, stiffness] = loosest_lever();
    let distance_m = Design::reference().lever.center_of_mass_m;
    let angles = ANGLES_DEG.map(|angle_deg| Some(angle_deg.to_radians()));
    for angle_rad in [&[None], &angles[..]].concat() {
        for (rest_samples, intervals) in [(0, 1), (0, 3), (1, 0), (4, 1), (4, 3)] {
            // The sine of the arm's part grows up to a right angle alone.
            for limit_rad in [0.1, 1.2, 2.0] {
                let jump = Jump {
                    angle_rad,
                    rest_samples,
                    intervals,
                    limit_rad,
                };
                let energy = preload * limit_rad + 0.5 * stiffness * limit_rad * limit_rad;
                let needed_m_s = (2.0 * inertia * energy).sqrt() / (mass * distance_m);
                let [along, outwards] = jump.cosines();
                let sine = libm::sin(limit_rad.min(std::f64::consts::FRAC_PI_2));
                let weight = |sensor: usize| along[sensor] + sine * outwards[sensor];
                let bias_m_s2: f64 = (0..2)
                    .map(|sensor| weight(sensor) * DRAWS_END * BIASES_M_S2[sensor])
                    .sum();
                for stop in STOPS {
                    // At rest the bias alone acts, and that not on a lever pressed onto a rigid stop.
                    let jumps = intervals + usize::from(rest_samples > 0);
                    let rests = match stop {
                        StopModel::Rigid => 0,
                        StopModel::Soft => rest_samples.saturating_sub(1),
                    };
                    let in_rest = rests as f64 * bias_m_s2;
                    let level_m_s2 = (needed_m_s * RATE_HZ - in_rest) / jumps as f64 - bias_m_s2;
                    // Y alone, X alone as far as Y opens at all, and both.
                    for shares in [[1.0, 0.0], [0.02, 0.98], [0.5, 0.5]] {
                        let is_recorded = |sensor: usize| weight(sensor) > 0.0;
                        if shares[1] > 0.0 && !is_recorded(1) {
                            continue;
                        }
                        let levels = [0, 1].map(|sensor| match is_recorded(sensor) {
                            true => {
                                let scale = 1.0 + DRAWS_END * SCALE;
                                shares[sensor] * level_m_s2 / (scale * weight(sensor))
                            }
                            false => 0.0,
                        });
                        let opening_sign = opening_sign_of_x(angle_rad.unwrap_or(0.0));
                        let levels = [levels[0], opening_sign * levels[1]];
                        check_bound(&jump, levels, stop, Bound::CannotReach);
                    }
                }
            }
        }
    }
}

/// The acceleration along the way of the centre of mass, each sensor where it opens most at the end of its draws,
/// against T0/(m L) of the loosest lever: what holds is scaled down.
#[test]
fn verif_never_lifts_turns_at_the_acceleration_of_all_sensors() {
    let [mass, preload, ..] = loosest_lever();
    let lift_off_m_s2 = preload / (mass * Design::reference().lever.center_of_mass_m);
    let angles = ANGLES_DEG.map(|angle_deg| Some(angle_deg.to_radians()));
    for angle_rad in [&[None], &angles[..]].concat() {
        for (rest_samples, intervals) in [(0, 1), (4, 0), (4, 3)] {
            let jump = Jump {
                angle_rad,
                rest_samples,
                intervals,
                limit_rad: 0.1,
            };
            let [along, _] = jump.cosines();
            let bias_m_s2: f64 = (0..2)
                .map(|sensor| along[sensor] * DRAWS_END * BIASES_M_S2[sensor])
                .sum();
            let (up, down) = (1.0 + DRAWS_END * SCALE, 1.0 - DRAWS_END * SCALE);
            let opening_m_s2 = lift_off_m_s2 - bias_m_s2;
            // X adds to what Y does, or takes away half of it.
            for (y_opens, x_opens) in [(1.0, 0.0), (0.4, 0.6), (1.5, -0.5)] {
                let has_part = along[1] > 0.0;
                // While it still rises from rest, X holds nothing.
                let holds_at_once = x_opens >= 0.0 || rest_samples == 0;
                if (x_opens != 0.0 && !has_part) || !holds_at_once {
                    continue;
                }
                let scale = |part: f64| if part > 0.0 { up } else { down };
                let y = y_opens * opening_m_s2 / (up * along[0]);
                let x = match has_part {
                    true => x_opens * opening_m_s2 / (scale(x_opens) * along[1]),
                    false => 0.0,
                };
                let x = opening_sign_of_x(angle_rad.unwrap_or(0.0)) * x;
                check_bound(&jump, [y, x], StopModel::Rigid, Bound::NeverLifts);
            }
        }
    }
}
