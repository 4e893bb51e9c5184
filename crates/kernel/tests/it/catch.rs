//! An inertia catch beside the lever, in the kernel.
//!
//! Instants and peaks are those of a Taylor series of both bodies at 200 bits, from knot to knot of
//! each pulse; the lever is the paper's with a preload of 1 N m.

use latchgate_kernel::model::Design;
use latchgate_kernel::model::catch::Catch;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::{self, CatchRun, Method, Run, RunOptions, RunOutcome};
use latchgate_kernel::signal::{Reading, Signal};
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY, SampleRate};

/// A knot of a pulse: time [s], acceleration [g].
type Knot = (f64, f64);

fn catch() -> Catch {
    Catch {
        moment_of_inertia_kg_m2: 1e-6,
        pivot_damping_nm_s_per_rad: 1e-6,
        spring_stiffness_nm_per_rad: 0.002,
        preload_torque_nm: 0.0037,
        unbalance_kg_m: 4.8e-5,
        engagement_angle_rad: 0.15,
        end_stop_angle_rad: 0.3,
        lever_angle_rad: 0.06,
        rest_restitution: 0.4,
        end_stop_restitution: 0.4,
        engagement_restitution: 0.3,
        reversible: true,
    }
}

fn design_with(catch: Option<Catch>) -> Design {
    let mut design = Design::reference();
    design.lever.preload_torque_nm = 1.0;
    design.catch = catch;
    design
}

/// Samples straight lines between knots until `end_s`.
fn sampled(knots: &[Knot], rate_hz: f64, end_s: f64) -> Signal {
    let value = |time: f64| {
        let segment = knots
            .windows(2)
            .find(|pair| time >= pair[0].0 - 1e-12 && time <= pair[1].0 + 1e-12);
        segment.map_or(0.0, |pair| {
            let part = (time - pair[0].0) / (pair[1].0 - pair[0].0);
            pair[0].1 + (pair[1].1 - pair[0].1) * part
        })
    };
    let count = (end_s * rate_hz).round() as usize + 1;
    Signal {
        start_s: 0.0,
        rate: SampleRate::from_hertz(rate_hz).unwrap(),
        samples: (0..count)
            .map(|index| value(index as f64 / rate_hz) * STANDARD_GRAVITY)
            .collect(),
    }
}

/// Two trapezoids of −40 g, 12 ms each.
fn two_pulses(gap_s: f64) -> Vec<Knot> {
    let of_one = |start: f64| {
        [
            (start, 0.0),
            (start + 0.001, -40.0),
            (start + 0.011, -40.0),
            (start + 0.012, 0.0),
        ]
    };
    [of_one(0.0), of_one(0.012 + gap_s)].concat()
}

/// Twelve periods of a triangle wave of 500 Hz, the opening half first.
fn ringing(amplitude_g: f64) -> Vec<Knot> {
    let mut knots = vec![(0.0, 0.0)];
    for half in 0..24 {
        let start = f64::from(half) * 0.001;
        let sign = if half % 2 == 0 { -1.0 } else { 1.0 };
        knots.extend([(start + 0.0005, sign * amplitude_g), (start + 0.001, 0.0)]);
    }
    knots
}

fn run(design: &Design, reading: &Reading<'_>) -> RunOutcome {
    let options = RunOptions::new(StopModel::Rigid, OpensWhen::Negative);
    replay::run(reading, design, &options).unwrap()
}

/// What a case must give; `None` for what does not happen.
struct Expected {
    peak_angle_rad: f64,
    first_crossing_s: Option<f64>,
    engaged_s: Option<f64>,
    lever_arrives_s: Option<f64>,
    lever_passes_s: Option<f64>,
    locked_s: Option<f64>,
}

#[track_caller]
fn check(name: &str, outcome: &RunOutcome, expected: &Expected) {
    #[track_caller]
    fn close(what: &str, found: Option<f64>, expected: Option<f64>) {
        match (found, expected) {
            (Some(found), Some(expected)) => {
                let away = (found - expected).abs();
                assert!(away <= 1e-12, "{what}: {found}, {away:e} away");
            }
            (found, expected) => assert_eq!(found, expected, "{what}"),
        }
    }
    let catch = outcome.catch.expect("the catch is told of");
    let Run {
        peak_angle_rad,
        first_crossing_s,
        ..
    } = outcome.run;
    let what = |part: &str| format!("{name}: {part}");
    close(
        &what("peak"),
        Some(peak_angle_rad),
        Some(expected.peak_angle_rad),
    );
    if expected.first_crossing_s.is_some() {
        close(
            &what("crossing"),
            first_crossing_s,
            expected.first_crossing_s,
        );
    }
    let CatchRun {
        engaged_s,
        locked_s,
        lever_arrives_s,
        lever_passes_s,
        tie_s,
        ..
    } = catch;
    close(&what("engaged"), engaged_s, expected.engaged_s);
    close(&what("arrives"), lever_arrives_s, expected.lever_arrives_s);
    close(&what("passes"), lever_passes_s, expected.lever_passes_s);
    close(&what("locked"), locked_s, expected.locked_s);
    assert_eq!(tie_s, None, "{name}: a tie");
}

#[test]
fn verif_each_instant_of_lever_and_catch_is_that_of_the_series() {
    const SLED: [Knot; 4] = [(0.0, 0.0), (0.022, -33.0), (0.057, -33.0), (0.085, 0.0)];
    const BLOW: [Knot; 3] = [(0.0, 0.0), (0.0005, -300.0), (0.001, 0.0)];
    let held = Expected {
        peak_angle_rad: 0.06,
        first_crossing_s: None,
        engaged_s: None,
        lever_arrives_s: None,
        lever_passes_s: None,
        locked_s: None,
    };
    let step = sampled(&[(0.0, -30.0), (0.05, -30.0)], 10_000.0, 0.1);
    let step = Reading::from(&step).ending_at(500);
    let outcome = run(&design_with(Some(catch())), &step);
    let expected = Expected {
        engaged_s: Some(0.005_385_881_646_629_625),
        lever_arrives_s: Some(0.007_663_407_434_552_142),
        ..held
    };
    check("a step of 30 g", &outcome, &expected);
    let speed = outcome.catch.unwrap().lever_arrives_rad_s.unwrap();
    assert!((speed - 15.618_982_683_305_457).abs() < 1e-12, "{speed}");

    let slow = Catch {
        moment_of_inertia_kg_m2: 3e-6,
        ..catch()
    };
    let irreversible = Catch {
        reversible: false,
        ..catch()
    };
    let cases: [(&str, Catch, Vec<Knot>, Expected); 7] = [
        (
            "the sled pulse",
            catch(),
            SLED.to_vec(),
            Expected {
                engaged_s: Some(0.016_141_246_550_943_4),
                lever_arrives_s: Some(0.020_249_051_107_897_42),
                ..held
            },
        ),
        (
            "a blow of 300 g",
            catch(),
            BLOW.to_vec(),
            Expected {
                engaged_s: Some(0.002_841_796_280_089_217),
                lever_arrives_s: Some(0.005_270_393_599_409_373),
                ..held
            },
        ),
        (
            "a blow and a slow catch",
            slow,
            BLOW.to_vec(),
            Expected {
                peak_angle_rad: 0.102_072_167_018_531_4,
                first_crossing_s: Some(0.011_884_888_300_739_139),
                lever_arrives_s: Some(0.005_270_393_599_409_373),
                lever_passes_s: Some(0.005_270_393_599_409_373),
                ..held
            },
        ),
        (
            "two pulses, a reversible catch",
            catch(),
            two_pulses(0.016),
            Expected {
                peak_angle_rad: 0.733_836_703_863_600_4,
                engaged_s: Some(0.005_058_223_780_534_052),
                lever_arrives_s: Some(0.006_850_148_730_732_922),
                lever_passes_s: Some(0.031_710_381_875_066_52),
                ..held
            },
        ),
        (
            "two pulses, an irreversible catch",
            irreversible,
            two_pulses(0.016),
            Expected {
                engaged_s: Some(0.005_058_223_780_534_052),
                lever_arrives_s: Some(0.006_850_148_730_732_922),
                locked_s: Some(0.006_931_581_566_388_679),
                ..held
            },
        ),
        (
            "ringing of 150 g",
            catch(),
            ringing(150.0),
            Expected {
                peak_angle_rad: 0.046_480_095_734_121_58,
                ..held
            },
        ),
        (
            "ringing of 300 g",
            catch(),
            ringing(300.0),
            Expected {
                peak_angle_rad: 0.149_189_984_002_328_56,
                first_crossing_s: Some(0.019_607_496_860_955_645),
                engaged_s: Some(0.006_910_089_015_855_027),
                lever_arrives_s: Some(0.017_137_542_743_749_68),
                lever_passes_s: Some(0.017_137_542_743_749_68),
                ..held
            },
        ),
    ];
    for (name, catch, knots, expected) in cases {
        let signal = sampled(&knots, 10_000.0, 0.15);
        let outcome = run(&design_with(Some(catch)), &(&signal).into());
        check(name, &outcome, &expected);
    }
}

/// Two pulses that are each held alone open the door from one gap on: the catch is falling back when
/// the second comes.
#[test]
fn verif_the_gap_from_which_two_pulses_open_is_found() {
    /// From the series at 200 bits [ms].
    const GAP_MS: f64 = 13.505_975_831_717_8;
    let design = design_with(Some(catch()));
    let peak_at = |gap_s: f64| {
        // Knots off the samples would be rounded off: the second pulse starts on one of its own rate.
        let rate_hz = 12_000.0 / (0.012 + gap_s);
        let period = 1.0 / rate_hz;
        let second = 12_000.0 * period;
        let knots = two_pulses(gap_s);
        assert!((knots[4].0 - second).abs() < 1e-12);
        run(&design, &(&sampled(&knots, rate_hz, 0.1)).into())
            .run
            .peak_angle_rad
    };
    // Corners between samples cut off less than 3e-7 s of a pulse.
    assert!(peak_at((GAP_MS - 0.01) * 1e-3) <= 0.06 + 1e-12);
    assert!(peak_at((GAP_MS + 0.01) * 1e-3) > 0.1);
}

/// A catch that falls back in the sample after the lever struck it could have done so before, within the noise.
#[test]
fn regress_a_catch_that_falls_back_just_after_a_strike_is_a_tie() {
    let samples = include_str!("../../../../tests/data/late_fall.txt").lines();
    let in_g = samples.filter(|line| !line.starts_with('#'));
    let signal = Signal {
        start_s: -0.005,
        rate: SampleRate::from_hertz(20_000.0).unwrap(),
        samples: in_g
            .map(|line| line.parse::<f64>().unwrap() * STANDARD_GRAVITY)
            .collect(),
    };
    let mut design = Design::reference();
    design.stop.restitution = 0.0;
    let lever = &mut design.lever;
    lever.moment_of_inertia_kg_m2 = 0.000_979_06;
    lever.pivot_damping_nm_s_per_rad = 0.000_162_622;
    lever.spring_stiffness_nm_per_rad = 0.241_455;
    lever.preload_torque_nm = 0.479_32;
    lever.mass_kg = 0.341_093;
    lever.center_of_mass_m = 0.032_959_2;
    design.catch = Some(Catch {
        moment_of_inertia_kg_m2: 6.267_45e-7,
        pivot_damping_nm_s_per_rad: 2.756_01e-6,
        spring_stiffness_nm_per_rad: 0.005_224_09,
        preload_torque_nm: 0.000_160_608,
        unbalance_kg_m: 2.277_68e-5,
        engagement_angle_rad: 0.178_84,
        end_stop_angle_rad: 0.371_24,
        lever_angle_rad: 0.093_264_5,
        rest_restitution: 0.869,
        end_stop_restitution: 0.95,
        engagement_restitution: 0.95,
        reversible: true,
    });
    // The noise of the file as a density: (0.05 g)² times the sample interval.
    for (noise_m2_s3, is_tie) in [(None, false), (Some(1.2e-5), true)] {
        let options = RunOptions {
            noise_m2_s3,
            ..RunOptions::new(StopModel::Rigid, OpensWhen::Negative)
        };
        let outcome = replay::run(&signal, &design, &options).unwrap();
        assert!(
            (outcome.run.peak_angle_rad - 0.093_264_5).abs() < 1e-12,
            "it is held"
        );
        let tie_s = outcome.catch.unwrap().tie_s;
        assert_eq!(tie_s.is_some(), is_tie, "{noise_m2_s3:?}: {tie_s:?}");
    }
}

/// A catch that nothing drives, or that blocks only where the lever never comes, changes no bit.
#[test]
fn verif_a_catch_that_takes_no_part_changes_nothing() {
    let signal = sampled(&two_pulses(0.016), 10_000.0, 0.1);
    let reading = Reading::from(&signal);
    let plain = run(&design_with(None), &reading);
    let idle = Catch {
        unbalance_kg_m: 0.0,
        ..catch()
    };
    let far = Catch {
        lever_angle_rad: 1e9,
        ..catch()
    };
    for (name, catch) in [("idle", idle), ("far", far)] {
        let outcome = run(&design_with(Some(catch)), &reading);
        let same = [
            (outcome.run.peak_angle_rad, plain.run.peak_angle_rad),
            (
                outcome.run.numerical_error_rad,
                plain.run.numerical_error_rad,
            ),
        ];
        for (with, without) in same {
            assert_eq!(with.to_bits(), without.to_bits(), "{name}");
        }
        assert_eq!(outcome.run.first_crossing_s, plain.run.first_crossing_s);
        assert_eq!(outcome.run.impacts, plain.run.impacts);
    }
}

/// A catch that blocks without moving is a second stop at φb: the lever's peak is φb itself, and it
/// leaves with restitution eb, against undamped free flight under a constant acceleration.
#[test]
fn verif_a_catch_without_travel_is_a_second_stop() {
    let mut design = design_with(Some(Catch {
        engagement_angle_rad: 0.0,
        end_stop_angle_rad: 0.0,
        ..catch()
    }));
    let signal = sampled(&[(0.0, -30.0), (0.05, -30.0)], 10_000.0, 0.1);
    let reading = Reading::from(&signal).ending_at(500);
    let outcome = run(&design, &reading);
    assert!((outcome.run.peak_angle_rad - 0.06).abs() <= 1e-15);
    let first = outcome.catch.unwrap();
    assert_eq!(first.engaged_s, None);
    let free = run(&design_with(None), &reading);
    assert!(free.run.peak_angle_rad > 0.1);
    // The instant at which the lever comes to φb is that at which a plain lever passes it.
    design.catch = None;
    design.criterion.threshold_rad = 0.06;
    let passing = run(&design, &reading).run.first_crossing_s.unwrap();
    assert!((first.lever_arrives_s.unwrap() - passing).abs() <= 1e-14);
}

/// Only the event-driven kernel follows two bodies.
#[test]
fn verif_other_methods_refuse_a_catch() {
    let signal = sampled(&two_pulses(0.016), 10_000.0, 0.1);
    let options = RunOptions {
        method: Method::Dopri5 { at_samples: true },
        tolerance_rad: Some(1e-10),
        ..RunOptions::new(StopModel::Rigid, OpensWhen::Negative)
    };
    let refused = replay::run(&signal, &design_with(Some(catch())), &options);
    assert!(refused.unwrap_err().to_string().contains("catch"));
}
