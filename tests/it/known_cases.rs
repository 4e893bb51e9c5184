//! The cases at which methods are known to fail, each with its right answer and what it costs:
//! grazes, unlucky steps, large angles, long records, starts between attractors, motion without
//! memory, and rounding that impacts carry beyond all use.

use crate::support::{data, replay, signal};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::excitation::Harmonic;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::{self, Method, RunOptions, State, Strobe};
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::{OpensWhen, SampleRate};
use latchgate_study::cases::{self, Drive, StudyCase};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const RIGID: StopModel = StopModel::Rigid;
const SOFT: StopModel = StopModel::Soft;

/// Gravity of the quad-precision reference values [m/s²].
const REFERENCE_GRAVITY: f64 = 9.81;

#[track_caller]
fn check_near(what: &str, got: f64, want: f64, tolerance: f64) {
    assert!(
        (got - want).abs() <= tolerance,
        "{what}: got {got:e}, want {want:e}, off by {:e}, tolerated {tolerance:e}",
        got - want
    );
}

/// A graze on −5 g sin(100 t + 1) from (0.00497…, `velocity`), 12 ms on.
#[track_caller]
fn check_graze(stop: StopModel, start_velocity: f64, want: State, tolerance: f64) {
    let sine = Harmonic {
        amplitude_m_s2: -5.0 * REFERENCE_GRAVITY,
        angular_frequency_rad_s: 100.0,
        phase_rad: 1.0,
    };
    let start = RunOptions {
        initial: Some(State::new(0.004_973_986_935_791_459, start_velocity)),
        ..RunOptions::new(stop, OpensWhen::Negative)
    };
    let outcome = replay::run_harmonic(&sine, 0.012, &Design::reference(), &start).unwrap();
    let what = format!("{} from {start_velocity:e}", stop.name());
    let (angle, velocity) = want.into();
    let run = &outcome.run;
    let error = (run.final_angle_rad - angle).abs();
    let stated = outcome.final_error_rad.unwrap();
    println!("{what}: off by {error:e}, stated {stated:e}");
    assert!(
        error <= stated,
        "{what}: off by {error:e}, stated {stated:e}"
    );
    check_near(&what, run.final_angle_rad, angle, tolerance);
    check_near(&what, run.final_velocity_rad_s, velocity, 1e3 * tolerance);
}

/// The touch itself, and as little as 1e-12 rad/s to either side of it, in quad precision: on the
/// rigid stop a step of 2.6e-8 rad, on the soft one none.
#[test]
fn val_grazes_to_a_millionth_of_a_millionth() {
    for (stop, velocity, angle, end, tolerance) in [
        (
            RIGID,
            -1.918_939_039_055_295,
            9.843_735_722_359_507e-3,
            2.689_690_142_450_111_6,
            1e-9,
        ),
        (
            SOFT,
            -1.918_939_039_055_295,
            9.843_735_722_359_507e-3,
            2.689_690_142_450_111_6,
            1e-14,
        ),
        (
            RIGID,
            -1.918_939_039_054_294_9,
            9.843_735_722_371_38e-3,
            2.689_690_142_451_080_5,
            1e-14,
        ),
        (
            SOFT,
            -1.918_939_039_054_294_9,
            9.843_735_722_371_38e-3,
            2.689_690_142_451_080_5,
            1e-14,
        ),
        (
            RIGID,
            -1.918_939_039_056_295,
            9.843_761_276_036_231e-3,
            2.689_693_766_617_508_8,
            1e-10,
        ),
        (
            SOFT,
            -1.918_939_039_056_295,
            9.843_735_722_347_659e-3,
            2.689_690_142_449_146_3,
            1e-14,
        ),
        (
            RIGID,
            -1.919_939_039_055_294_8,
            1.065_714_232_680_187_2e-2,
            2.803_232_588_386_267_5,
            1e-14,
        ),
        (
            SOFT,
            -1.919_939_039_055_294_8,
            1.013_993_207_072_917_7e-2,
            2.731_958_078_625_57,
            1e-14,
        ),
    ] {
        check_graze(stop, velocity, State::new(angle, end), tolerance);
    }
}

fn scaled(mut case: StudyCase, factor: f64) -> StudyCase {
    if let Drive::Samples(record) = &mut case.drive {
        for a in &mut record.samples {
            *a *= factor;
        }
    }
    case
}

/// A weak recording of chatter on the soft stop. With events on the grid a finer step is not a
/// better one, and two runs may agree on a wrong angle: the error stated from them is an
/// estimate, and the method's finding says what it leaves out.
#[test]
fn verif_a_finer_step_on_the_grid_is_no_better_by_itself() {
    let case = scaled(cases::recording(REFERENCE_GRAVITY).unwrap(), 0.05);
    let run = |parts: Option<f64>| {
        let mut options = RunOptions::new(SOFT, OpensWhen::Negative);
        if let Some(parts) = parts {
            options.method = Method::Rk4 {
                steps_per_period: 1,
            };
            options.step_s = Some(1e-4 / parts);
        }
        case.replay(&Design::reference(), &options).unwrap().run
    };
    let truth = run(None);
    check_near(
        "event-driven",
        truth.peak_angle_rad,
        0.011_765_066_783_240,
        1e-14,
    );
    let error = |parts| (run(Some(parts)).peak_angle_rad - truth.peak_angle_rad).abs();
    let (two, three, thirty, fifty) = (error(2.0), error(3.0), error(30.0), error(50.0));
    assert!(three > 1.2 * two, "{three:e} after {two:e}");
    assert!(fifty > 1.1 * thirty, "{fifty:e} after {thirty:e}");
    // Thirty steps a sample agree with sixty by chance.
    let stated = run(Some(30.0)).numerical_error_rad;
    assert!(stated < 0.1 * thirty, "stated {stated:e} of {thirty:e}");
    let design = Design::reference();
    let steps_per_period = (replay::fixed_step_s(&design, 1) * 30.0 / 1e-4).round() as u32;
    let known = Method::Rk4 { steps_per_period }.known_failures(
        &design,
        SOFT,
        SampleRate::from_hertz(10_000.0).unwrap().interval(),
        None,
    );
    assert!(
        known.iter().any(|text| text.contains("on the grid")),
        "{known:?}"
    );
}

/// Work of the event-driven method: these very counts, on every machine. A change that costs or
/// saves work shows here.
#[track_caller]
fn check_work(case: &StudyCase, stop: StopModel, steps: u64, rhs: u64, events: u64) {
    for error_bound in [true, false] {
        let options = RunOptions {
            initial: case.initial,
            error_bound,
            ..RunOptions::new(stop, OpensWhen::Negative)
        };
        let work = case
            .replay(&Design::reference(), &options)
            .unwrap()
            .run
            .work;
        assert_eq!(
            (work.steps, work.rhs, work.events),
            (steps, rhs, events),
            "{} {}",
            case.name,
            stop.name()
        );
    }
}

#[test]
fn verif_the_work_of_standard_scenes() {
    let shock = cases::shock(REFERENCE_GRAVITY).unwrap();
    check_work(&shock, RIGID, 674, 6263, 7);
    check_work(&shock, SOFT, 709, 6183, 9);
    let recording = cases::recording(REFERENCE_GRAVITY).unwrap();
    check_work(&recording, RIGID, 2993, 27_668, 3);
    check_work(&recording, SOFT, 3005, 27_814, 5);
    let chatter = scaled(recording, 0.05);
    check_work(&chatter, RIGID, 2998, 26_973, 13);
    check_work(&chatter, SOFT, 3050, 17_758, 50);
    let sine = cases::harmonic(REFERENCE_GRAVITY, 5.0, 100.0, 100);
    check_work(&sine, RIGID, 1213, 23_119, 51);
    check_work(&sine, SOFT, 1376, 26_584, 110);
}

/// A pulse of a half-sine.
fn pulse(rate: f64, amplitude: f64, length_s: f64, before: usize, after: usize) -> Signal {
    let count = (length_s * rate).round() as usize;
    let mut samples = vec![0.0; before];
    samples.extend((0..=count).map(|k| -amplitude * libm::sin(PI * k as f64 / count as f64)));
    samples.extend(vec![0.0; after]);
    signal(rate, samples)
}

/// Motion late in a long record: five minutes of silence change no bit of the peak on the rigid
/// stop, and the instants by no more than the resolution of time so late.
#[test]
fn verif_a_late_pulse_is_the_pulse_alone() {
    let before = 3_000_000;
    for stop in [RIGID, SOFT] {
        let run = |before| {
            let record = pulse(10_000.0, 30.0 * REFERENCE_GRAVITY, 0.011, before, 500);
            replay(
                &record,
                &Design::reference(),
                &RunOptions::new(stop, OpensWhen::Negative),
            )
            .run
        };
        let (late, alone) = (run(before), run(1));
        let what = stop.name();
        assert!(alone.peak_angle_rad > 0.1, "{what}");
        if stop == RIGID {
            assert_eq!(
                late.peak_angle_rad.to_bits(),
                alone.peak_angle_rad.to_bits()
            );
            assert_eq!(late.work.steps, alone.work.steps);
        } else {
            check_near(what, late.peak_angle_rad, alone.peak_angle_rad, 2e-16);
        }
        let offset = (before - 1) as f64 / 10_000.0;
        for (name, late, alone) in [
            ("peak", Some(late.peak_time_s), Some(alone.peak_time_s)),
            ("release", late.first_release_s, alone.first_release_s),
            ("crossing", late.first_crossing_s, alone.first_crossing_s),
        ] {
            let resolution = f64::EPSILON * 2.0 * offset;
            check_near(name, late.unwrap() - offset, alone.unwrap(), resolution);
        }
        assert_eq!(late.impacts, alone.impacts, "{what}");
        assert!(
            late.numerical_error_rad < 1e-12,
            "{:e}",
            late.numerical_error_rad
        );
    }
}

/// An attractor of the soft stop at ω = 100 rad/s and A = 1, by what a period and its peak are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Attractor {
    /// Pressed onto the stop.
    Rest,
    /// Twice the excitation's period.
    Doubled,
    /// The excitation's period, peak 0.0889 rad.
    Thrown,
}

fn attractor(start: f64, quarters: u32) -> Attractor {
    let sine = Harmonic {
        amplitude_m_s2: REFERENCE_GRAVITY,
        angular_frequency_rad_s: 100.0,
        phase_rad: FRAC_PI_2 * f64::from(quarters),
    };
    let initial = Some(State::new(start, 0.0));
    let mut strobe = Strobe::new(&Design::reference(), SOFT, &sine, initial).unwrap();
    for _ in 0..400 {
        strobe.advance().unwrap();
    }
    let [first, second, third] = [(); 3].map(|()| strobe.advance().unwrap());
    let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
    assert!(
        near(first.angle_rad, third.angle_rad),
        "{start} has not settled"
    );
    if first.peak_angle_rad < 1e-4 {
        Attractor::Rest
    } else if near(first.angle_rad, second.angle_rad) {
        check_near(
            "peak of III",
            first.peak_angle_rad,
            0.088_881_716_444_083_3,
            1e-12,
        );
        Attractor::Thrown
    } else {
        Attractor::Doubled
    }
}

/// Which attractor a start leads to depends on the phase of the excitation.
#[test]
fn val_the_phase_selects_the_attractor() {
    use Attractor::{Doubled, Rest, Thrown};
    for (start, want) in [
        (0.8, [Rest, Thrown, Thrown, Rest]),
        (0.56, [Doubled, Rest, Rest, Rest]),
        (0.9, [Thrown, Thrown, Rest, Thrown]),
    ] {
        let got = [0, 1, 2, 3].map(|quarters| attractor(start, quarters));
        assert_eq!(got, want, "from {start}");
    }
}

/// The orbit that (0.1, 0) settles on at ω = 20 rad/s and A = 40: these states at t = 0 mod 2π/ω,
/// in this order, and over again within `back`.
#[track_caller]
fn check_orbit(stop: StopModel, back: f64, points: &[State]) {
    let sine = Harmonic {
        amplitude_m_s2: 40.0 * REFERENCE_GRAVITY,
        angular_frequency_rad_s: 20.0,
        phase_rad: 0.0,
    };
    let start = Some(State::new(0.1, 0.0));
    let mut strobe = Strobe::new(&Design::reference(), stop, &sine, start).unwrap();
    for _ in 0..200 {
        strobe.advance().unwrap();
    }
    let distance = |state: State, point: State| {
        let (angle, velocity) = (state - point).into();
        f64::max(angle.abs(), velocity.abs() / 20.0)
    };
    for _ in 0..points.len() {
        if distance(strobe.state(), points[0]) < 1e-3 {
            break;
        }
        strobe.advance().unwrap();
    }
    let mut before = vec![None; points.len()];
    for round in 0..3 {
        for (index, point) in points.iter().enumerate() {
            let what = format!("{} {index} in round {round}", stop.name());
            let state = strobe.state();
            check_near(&what, distance(state, *point), 0.0, 1e-8);
            if let Some(before) = before[index].replace(state) {
                check_near(&what, distance(state, before), 0.0, back);
            }
            strobe.advance().unwrap();
        }
    }
}

/// Where the lever rests once an orbit it forgets what was before: periods of nine and six, to the
/// last bit on the rigid stop, where steps on the grid show a cloud. From rest to rest rounding
/// grows ten million times, so that double precision knows a point to 1e-8 rad.
#[test]
fn val_orbits_of_nine_and_six_periods() {
    check_orbit(
        RIGID,
        0.0,
        &[
            State::new(1.267_409_838_042_811_8, 12.297_275_056_906_912),
            State::new(0.133_950_672_216_708_66, 7.017_229_509_580_746),
            State::new(0.528_799_173_956_144, 18.201_701_214_556_566),
            State::new(0.856_069_720_999_286_1, 20.990_063_856_190_16),
            State::new(1.440_992_342_966_873_6, 19.052_191_859_007_174),
            State::new(1.371_168_318_729_475_1, -2.596_210_749_133_214),
            State::new(0.620_374_848_047_918_6, 16.007_217_817_671_77),
            State::new(1.042_417_480_826_954_2, 22.994_274_154_473_583),
            State::new(1.431_856_893_196_737_2, 10.781_594_521_802_176),
        ],
    );
    check_orbit(
        SOFT,
        1e-10,
        &[
            State::new(1.227_560_710_454_321_3, 22.675_943_914_886_17),
            State::new(0.299_589_681_395_596_2, 6.513_913_123_469_031),
            State::new(0.528_844_193_401_186_4, 18.202_442_129_973_48),
            State::new(0.937_867_743_971_423_9, 21.805_248_585_844_25),
            State::new(0.285_985_471_830_834_8, 18.355_271_437_681_1),
            State::new(0.654_733_057_157_243_6, 19.959_338_363_928_84),
        ],
    );
}

fn file(name: &str, record: &Signal) -> PathBuf {
    let mut text = String::from("time [s],acceleration [m/s2]\n");
    for (index, a) in record.samples.iter().enumerate() {
        writeln!(text, "{},{a:e}", record.time_s(index)).unwrap();
    }
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("known-{name}.csv"));
    std::fs::write(&path, text).unwrap();
    path
}

/// Judges a recording as it is, neither filtered nor moved.
#[track_caller]
fn check_verdict(path: &Path, more: &[&str], code: i32, finding: &str) -> serde_json::Value {
    let output = crate::support::program()
        .arg("replay")
        .arg(path)
        .args(["--filter", "none", "--bias", "none", "--members", "0"])
        .args(["--no-report", "--format", "json"])
        .args(more)
        .env("NO_COLOR", "1")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(
        output.status.code(),
        Some(code),
        "{}: {said}",
        path.display()
    );
    let verdict: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let findings = verdict["findings"].as_array().unwrap();
    assert!(
        findings.iter().any(|known| known["code"] == finding),
        "{}: no {finding} in {findings:?}",
        path.display()
    );
    verdict
}

/// 100 g for 35 ms: 5.54 rad with cos φ, 11 rad without. Far beyond what a lever on a latch can
/// turn, and said so.
#[test]
fn cli_angles_beyond_the_geometry_are_told() {
    let record = pulse(10_000.0, 100.0 * REFERENCE_GRAVITY, 0.035, 0, 1000);
    let path = file("half-sine", &record);
    for (stop, peak) in [("rigid", 5.535_94), ("soft", 5.535_57)] {
        let verdict = check_verdict(
            &path,
            &[
                "--opens-when",
                "negative",
                "--model",
                stop,
                "--between",
                "linear",
            ],
            1,
            "beyond-geometry",
        );
        let got = verdict["nominal"]["peak_angle_rad"].as_f64().unwrap();
        check_near(stop, got, peak, 1e-5);
    }
}

#[track_caller]
fn check_amplified(path: &Path, more: &[&str], impacts: u64, times: f64) {
    let verdict = check_verdict(path, more, 3, "rounding-amplified");
    assert_eq!(verdict["verdict"], "undecided");
    let nominal = &verdict["nominal"];
    let peak = nominal["peak_angle_rad"].as_f64().unwrap();
    let stated = nominal["numerical_error_rad"].as_f64().unwrap();
    assert!(stated > times * peak, "stated {stated:e} of {peak}");
    assert!(nominal["impacts"].as_u64().unwrap() > impacts);
}

/// Motion that never rests and grows e^0.5 a period apart: after 150 periods rounding is all there
/// is, and no peak below a threshold passes.
#[test]
fn cli_rounding_that_impacts_amplify_leaves_the_verdict_open() {
    let intervals = (150.0 * TAU / 100.0 * 10_000.0) as usize;
    let samples = (0..=intervals)
        .map(|k| 2.5 * REFERENCE_GRAVITY * libm::sin(100.0 * k as f64 / 10_000.0))
        .collect();
    let path = file("chaos", &signal(10_000.0, samples));
    for stop in ["rigid", "soft"] {
        let more = ["--opens-when", "negative", "--model", stop];
        let high = ["--set", "criterion.threshold_rad=0.5"];
        check_amplified(&path, &[&more[..], &high[..]].concat(), 50, 10.0);
    }
}

/// A real channel at full bandwidth whose 231 contacts leave the bound on rounding larger than the peak: the replay in
/// double-double arithmetic finds a smaller one.
#[test]
fn cli_rounding_on_a_real_channel_is_measured_in_double_double_arithmetic() {
    let path = data("recordings/nhtsa_v07292.147");
    let more = ["--opens-when", "positive", "--model", "soft", "--unit", "g"];
    let verdict = check_verdict(&path, &more, 3, "rounding-amplified");
    let nominal = &verdict["nominal"];
    let peak = nominal["peak_angle_rad"].as_f64().unwrap();
    let stated = nominal["numerical_error_rad"].as_f64().unwrap();
    assert!(stated < peak, "stated {stated:e} of {peak}");
    assert!(nominal["impacts"].as_u64().unwrap() > 200);
}
