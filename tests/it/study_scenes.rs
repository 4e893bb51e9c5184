//! The studies of the paper's Figs. 2, 3, 4, 5, 10 and 11: values against numbers of a separate
//! program in quadruple precision, and what the command writes and refuses.

use latchgate_document::design_file::apply_override;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::excitation::Harmonic;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::{self, RunOptions, State, TracePoint};
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::{OpensWhen, SampleRate};
use latchgate_study::chart;
use latchgate_study::free::{self, Against, FreeMotion, Release};
use latchgate_study::histories::{self, Histories, History};
use latchgate_study::restitution::{self, FreeContact};
use latchgate_study::{Headline, free_vibration, shock, spectrogram, step_size};
use latchgate_verdict::conditioning::spectrum;
use std::f64::consts::{PI, TAU};
use std::path::PathBuf;
use std::process::Output;

#[track_caller]
fn check_near(what: &str, got: f64, want: f64, tolerance: f64) {
    assert!(
        (got - want).abs() <= tolerance,
        "{what}: {got:.17e}, expected {want:.17e} ± {tolerance:e}"
    );
}

#[track_caller]
fn check_relative(what: &str, got: f64, want: f64, tolerance: f64) {
    check_near(what, got, want, tolerance * want.abs());
}

#[track_caller]
fn headline(headlines: &[Headline], subject: &str, what: &str) -> f64 {
    let found: Vec<&Headline> = headlines
        .iter()
        .filter(|line| line.subject == subject && line.what.starts_with(what))
        .collect();
    assert_eq!(found.len(), 1, "headlines `{what}` of {subject}: {found:?}");
    found[0].value.unwrap()
}

fn equivalence(design: &Design) -> restitution::Equivalence {
    restitution::run(&restitution::Options {
        design: design.clone(),
        points: 100,
    })
    .unwrap()
}

/// Eq. (2.5) at round values of R.
#[test]
fn val_damping_ratios_agree_with_quad_precision() {
    let result = equivalence(&Design::reference());
    for (restitution, ratio) in [
        (0.05, 0.690_106_730_559_821_7),
        (0.1, 0.591_155_033_798_897_5),
        (0.2, 0.455_949_810_769_126_1),
        (0.3, 0.357_857_130_503_316_65),
        (0.4, 0.279_997_993_335_041_6),
        (0.5, 0.215_453_761_966_246_78),
        (0.6, 0.160_493_046_664_283_83),
        (0.7, 0.112_808_450_693_581_3),
        (0.8, 0.070_850_300_195_368_06),
        (0.9, 0.033_518_449_105_676_37),
        (0.95, 0.016_324_986_916_656_453),
        (0.99, 0.003_199_104_891_256_285),
    ] {
        let row = result
            .rows
            .iter()
            .find(|row| (row.restitution - restitution).abs() < 1e-12)
            .unwrap();
        check_relative(
            &format!("R = {restitution}"),
            row.damping_ratio,
            ratio,
            4e-15,
        );
    }
    let (first, last) = (result.rows[0], result.rows[result.rows.len() - 1]);
    assert!(first.restitution < 1e-13 && first.damping_ratio > 0.99);
    check_near("R = 1", last.damping_ratio, 0.0, 0.0);
}

/// The design's own damping: 133.59 N s/m stands for R = 0.8 in the formula without unit of time.
#[test]
fn val_the_damping_of_the_paper_fits_the_formula_that_has_no_unit() {
    let result = equivalence(&Design::reference());
    let formula = |what| headline(&result.headlines, "formula", what);
    check_relative(
        "R of half a period",
        result.half_period_ratio,
        0.799_987_744_129_295_6,
        1e-14,
    );
    check_relative(
        "cs for exactly 0.8, pivot counted in",
        formula("the same with the pivot"),
        133.580_874_389_763_26,
        1e-13,
    );
    check_near("cs for 0.8", formula("cs = 2 I0"), 133.59, 5e-4);
    // As printed the formula gives 13 µs, and a damping five thousand times too large.
    check_near("as printed [s]", formula("cR/(I0"), 1.335_988e-5, 1e-10);
    assert!(formula("cs if that were taken") > 7e5);
}

/// The stop's limits: half a period, its tension, what preload takes away.
#[test]
fn val_limits_of_the_equivalence_agree_with_quad_precision() {
    let design = Design::reference();
    let result = equivalence(&design);
    let free = FreeContact::new(&design, 0.0).unwrap();
    check_relative(
        "half period",
        free.half_period_s(),
        2.969_231_197_838_952e-4,
        1e-14,
    );
    check_relative(
        "tension from",
        result.tension_from_s.unwrap(),
        2.835_192_243_336_35e-4,
        1e-12,
    );
    check_relative(
        "let go there",
        result.released_ratio.unwrap(),
        0.808_088_071_150_798,
        1e-12,
    );
    let loaded = FreeContact::new(&design, design.lever.preload_torque_nm).unwrap();
    // Entry and exit of the first contacts of a free vibration from 0.5 rad.
    for (entry, exit, length) in [
        (
            14.678_784_023_032_48,
            11.740_139_963_680_36,
            5.978_227_109_495_373e-2 - 5.948_519_467_434_196e-2,
        ),
        (
            11.685_441_253_223_22,
            9.345_501_991_592_556,
            1.709_227_569_843_545_9e-1 - 1.706_256_412_885_331e-1,
        ),
        (
            9.306_856_148_644_371,
            7.442_662_505_133_383,
            2.728_522_577_893_915e-1 - 2.725_550_928_673_394e-1,
        ),
    ] {
        let left = loaded.exit(entry).unwrap();
        check_relative("exit speed", left.speed_rad_s, exit, 1e-14);
        check_near("contact", left.time_s, length, 1e-15);
    }
}

/// The closed form of a contact and the kernel are the same; below the capture speed neither
/// comes out.
#[test]
fn verif_the_contact_is_the_kernels() {
    let design = Design::reference();
    let capture = equivalence(&design).capture_speed_rad_s.unwrap();
    let loaded = FreeContact::new(&design, design.lever.preload_torque_nm).unwrap();
    for speed in [40.0, 1.0, 0.03, 1.001 * capture] {
        let exit = loaded.exit(speed).unwrap();
        // In flight just after the exit, spring and damping have not yet done anything.
        let start = State::new(0.0, -speed);
        let motion = let_go(&design, Against::Soft, 0.1, start, exit.time_s);
        check_near("angle at the exit", motion.final_angle_rad, 0.0, 1e-15);
        let velocity = motion.final_velocity_rad_s;
        check_relative("exit speed", velocity, exit.speed_rad_s, 1e-9);
    }
    assert!(loaded.exit(0.999 * capture).is_none());
    let slow = State::new(0.0, -0.999 * capture);
    let motion = let_go(&design, Against::Soft, 0.1, slow, 0.05);
    assert!(
        motion
            .trace
            .iter()
            .skip(1)
            .all(|point| point.angle_rad <= 0.0)
    );
}

/// No preload keeps no lever, a stop damped beyond all measure keeps every one.
#[test]
fn verif_extreme_stops_are_answered() {
    let mut design = Design::reference();
    apply_override(&mut design, "lever.preload_torque_nm=0").unwrap();
    assert!(equivalence(&design).capture_speed_rad_s.is_none());
    apply_override(&mut design, "stop.damping_n_s_per_m=1e4").unwrap();
    let result = equivalence(&design);
    assert!(result.tension_from_s.is_none() && result.pushes.is_empty());
    assert!(
        result
            .rebounds
            .iter()
            .all(|rebound| rebound.ratio.is_none())
    );
    let svg = chart::restitution(&result);
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
}

/// At rest, half a radian from the stop.
const FROM_HALF: State = State::new(0.5, 0.0);

fn let_go(
    design: &Design,
    against: Against,
    preload_torque_nm: f64,
    start: State,
    duration_s: f64,
) -> FreeMotion {
    free::run(
        design,
        against,
        &Release {
            preload_torque_nm,
            start,
            duration_s,
            rate_hz: 1000.0,
        },
    )
    .unwrap()
}

/// Number of the impact, time [s], velocity before [rad/s].
type Impact = (usize, f64, f64);

#[track_caller]
fn check_impacts(motion: &FreeMotion, count: usize, impacts: &[Impact]) {
    let what = format!(
        "{}, T0 = {}",
        motion.against.name(),
        motion.preload_torque_nm
    );
    assert_eq!(motion.impacts.len(), count, "{what}");
    for (index, time, velocity) in impacts {
        let got = motion.impacts[*index];
        check_near(&format!("{what}: time {index}"), got[0], *time, 2e-14);
        check_near(
            &format!("{what}: velocity {index}"),
            got[1],
            *velocity,
            2e-12,
        );
    }
}

/// Fig. 4: impacts of free vibrations from 0.5 rad.
#[test]
fn val_free_vibrations_agree_with_quad_precision() {
    let design = Design::reference();
    let run = |against, preload, end| let_go(&design, against, preload, FROM_HALF, end);
    check_impacts(
        &run(Against::Rigid, 0.0, 2.5),
        16,
        &[
            (0, 0.077_113_574_842_300_29, -10.160_538_424_289_69),
            (1, 0.231_089_372_073_775_86, -8.063_213_864_128_116),
            (7, 1.154_944_155_462_629_3, -2.013_988_178_968_870_6),
            (15, 2.386_750_533_314_434, -0.316_802_476_658_573_1),
        ],
    );
    check_impacts(
        &run(Against::Soft, 0.0, 2.5),
        16,
        &[
            (0, 0.077_113_574_842_300_29, -10.160_538_424_289_69),
            (1, 0.231_386_295_193_559_76, -8.063_090_336_994_89),
            (15, 2.391_204_380_111_192_3, -0.316_729_684_023_977_5),
        ],
    );
    let rigid = run(Against::Rigid, 0.1, 2.5);
    check_impacts(
        &rigid,
        43,
        &[
            (0, 0.059_485_194_674_341_96, -14.678_784_023_032_48),
            (1, 0.170_337_842_935_417_2, -11.688_308_573_197_884),
            (2, 0.271_993_783_769_651_8, -9.311_967_727_773_11),
            (9, 0.694_569_437_244_324_7, -1.922_193_920_534_315_3),
            (19, 0.814_915_209_764_420_9, -0.205_525_528_778_910_83),
            (42, 0.829_437_180_663_301_7, -1.212_594_215_728_772e-3),
        ],
    );
    // Infinitely many bounces end here.
    check_near(
        "rest",
        rigid.settled_s.unwrap(),
        0.829_523_400_832_410_4,
        2e-14,
    );
    let soft = run(Against::Soft, 0.1, 2.5);
    check_impacts(
        &soft,
        29,
        &[
            (0, 0.059_485_194_674_341_96, -14.678_784_023_032_48),
            (1, 0.170_625_641_288_533_1, -11.685_441_253_223_22),
            (4, 0.445_003_905_712_333_07, -5.911_614_475_249_542),
            (19, 0.817_452_984_396_734_1, -0.191_891_067_210_967_17),
            (28, 0.830_795_988_135_648_4, -9.731_263_418_941_813e-3),
        ],
    );
    check_near(
        "stays",
        soft.settled_s.unwrap(),
        0.830_795_988_135_648_4,
        2e-14,
    );
}

/// Fig. 4: the lever that meets nothing swings through.
#[test]
fn val_free_vibrations_without_a_stop_agree_with_quad_precision() {
    let design = Design::reference();
    for (preload, angle, velocity) in [
        (0.0, -0.450_020_474_656_129_44, -0.315_888_053_366_708_7),
        (0.1, -0.963_545_055_551_334_6, -0.486_638_352_483_848_8),
    ] {
        let motion = let_go(&design, Against::Nothing, preload, FROM_HALF, 2.0);
        check_near("angle", motion.final_angle_rad, angle, 2e-14);
        check_near("velocity", motion.final_velocity_rad_s, velocity, 4e-13);
        assert!(motion.final_error_rad.unwrap() < 1e-11);
        assert!(motion.impacts.is_empty() && motion.settled_s.is_none());
    }
}

/// Fig. 4a: about π/ω0 from impact to impact; Fig. 4b: ever less.
#[test]
fn val_the_period_is_constant_without_preload_and_shrinks_with_it() {
    let result = free_vibration::run(&free_vibration::Options {
        design: Design::reference(),
        models: vec![StopModel::Rigid, StopModel::Soft],
        angle_rad: 0.5,
        velocity_rad_s: 0.0,
        periods: 5.0,
    })
    .unwrap();
    assert_eq!(result.motions.len(), 6);
    check_relative(
        "π/ω0",
        result.half_period_s,
        PI / 20.403_225_949_905_967,
        1e-14,
    );
    for motion in &result.motions {
        let intervals = motion.intervals();
        match (motion.against, motion.preload_torque_nm > 0.0) {
            (Against::Nothing, _) => assert!(intervals.is_empty()),
            (Against::Rigid, false) => {
                for interval in intervals {
                    check_near("rigid", interval.length_s, 0.153_975_797_231_475_6, 1e-13);
                }
            }
            (_, false) => {
                for interval in intervals {
                    // Half a swing, and the contact.
                    check_near("soft", interval.length_s, 0.154_272_720_351_259_4, 1e-13);
                }
            }
            (_, true) => {
                assert!(intervals.len() > 20);
                let shrinks = intervals.is_sorted_by(|a, b| b.length_s < a.length_s);
                assert!(shrinks);
            }
        }
    }
}

fn sizes(steps_per_period: &[u32], points: u32) -> step_size::StepSize {
    step_size::run(&step_size::Options {
        design: Design::reference(),
        angular_frequency_rad_s: 20.0,
        steps_per_period: steps_per_period.to_vec(),
        angle_rad: 0.5,
        velocity_rad_s: 0.0,
        periods: 3,
        points,
    })
    .unwrap()
}

/// Fig. 3: what the fixed step gives back, contact by contact, as another program with the same
/// step has it.
#[test]
fn val_the_fixed_step_gives_back_what_others_saw() {
    let result = sizes(&[10_000, 1000], 2);
    let [fine, coarse] = [&result.runs[0], &result.runs[1]];
    let seen = [0.8372, 0.8159, 0.8525, 0.8094, 0.8509, 0.8522, 0.8468];
    for (got, want) in fine.exit_over_entry.iter().zip(seen) {
        check_near("N = 10000", *got, want, 6e-5);
    }
    assert!(!fine.gains_energy && fine.exit_over_entry.len() > 20);
    check_near("ωR·Δt", fine.reach, 0.333_233_498_902_822_7, 1e-13);
    // Beyond the limit rounding decides after two contacts; these two are the method's own.
    check_near("N = 1000", coarse.exit_over_entry[0], -1.0174, 6e-5);
    check_near("N = 1000", coarse.exit_over_entry[1], 9.798, 2e-3);
    assert!(coarse.gains_energy && coarse.amplification > 2.5);
    check_near(
        "right",
        result.right_ratio.unwrap(),
        0.799_803_304_228_668_2,
        1e-13,
    );
}

/// The limit: |R(z)| = 1 at 2.931, N = 1137; near it and beyond steps fail, far below they are
/// right.
#[test]
fn verif_the_limit_of_the_step_lies_where_it_must() {
    let result = sizes(&[1000], 40);
    check_near("limit", result.limit, 2.931, 1e-3);
    check_relative(
        "N",
        result.limit_steps_per_period * result.limit,
        10_607.151_710_838_385 * TAU / 20.0,
        1e-13,
    );
    for scan in &result.scan {
        if scan.steps_per_period < 0.95 * result.limit_steps_per_period {
            assert!(scan.failing_share > 0.5, "{scan:?}");
        }
        if scan.steps_per_period > 3000.0 {
            assert!(scan.failing_share <= 0.0, "{scan:?}");
        }
        if scan.steps_per_period > 4e5 {
            check_relative("least", scan.least_ratio, 0.799_803_304, 1e-3);
            check_relative("largest", scan.largest_ratio, 0.799_803_304, 1e-3);
        }
    }
}

fn bounces(periods: f64) -> spectrogram::MotionSpectrogram {
    spectrogram::run(&spectrogram::Options {
        design: Design::reference(),
        model: StopModel::Soft,
        angle_rad: 0.5,
        velocity_rad_s: 0.0,
        periods,
        window_periods: 0.75,
    })
    .unwrap()
}

/// Fig. 5: the ridge is one over the time between impacts, and the transform's strongest line runs
/// along it.
#[test]
fn verif_the_ridge_is_where_the_spectrogram_is_strongest() {
    let result = bounces(3.0);
    let first = 1.0 / (0.170_625_641_288_533_1 - 0.059_485_194_674_341_96);
    check_near("first", result.bounces[0].frequency_hz, first, 1e-10);
    assert!(
        result
            .bounces
            .windows(2)
            .all(|pair| pair[1].frequency_hz > pair[0].frequency_hz)
    );
    let resolution = 2.0 / result.amplitudes.window_s;
    for bounce in &result.bounces[1..7] {
        let (_, row) = result
            .amplitudes
            .time_s
            .iter()
            .zip(&result.amplitudes.amplitudes)
            .min_by(|a, b| {
                (a.0 - bounce.time_s)
                    .abs()
                    .total_cmp(&(b.0 - bounce.time_s).abs())
            })
            .unwrap();
        let strongest = (0..row.len())
            .max_by(|a, b| row[*a].total_cmp(&row[*b]))
            .unwrap();
        check_near(
            "strongest line",
            result.amplitudes.frequency_hz[strongest],
            bounce.frequency_hz,
            0.5 * resolution,
        );
    }
}

/// A tone shows its amplitude, wherever between the lines of the window it lies.
#[test]
fn verif_a_tone_shows_its_amplitude() {
    let rate = SampleRate::from_hertz(1000.0).unwrap();
    for frequency in [50.0, 51.7, 123.4] {
        let tone: Vec<f64> = (0..2000)
            .map(|index| 3.0 * (TAU * frequency * f64::from(index) / 1000.0).sin())
            .collect();
        let result = spectrum::short_time(&tone, 2.0, rate, 300, 40);
        assert!(result.time_s.len() >= 30 && result.time_s.len() <= 40);
        check_near("first centre", result.time_s[0], 2.15, 1e-12);
        for row in &result.amplitudes {
            let largest = row.iter().copied().fold(0.0, f64::max);
            check_near("amplitude", largest, 3.0, 0.02);
        }
    }
    let none = spectrum::short_time(&[0.0; 10], 0.0, rate, 300, 40);
    assert!(none.time_s.is_empty());
}

fn three_starts(gravity_m_s2: f64) -> Histories {
    histories::run(&histories::Options {
        design: Design::reference(),
        models: vec![StopModel::Rigid, StopModel::Soft],
        gravity_m_s2,
        amplitude_g: 1.0,
        angular_frequency_rad_s: 100.0,
        starts: histories::STARTS.to_vec(),
        periods: 40,
        transient: 1000,
    })
    .unwrap()
}

#[track_caller]
fn history(result: &Histories, model: StopModel, angle: f64) -> &History {
    result
        .histories
        .iter()
        .find(|history| history.model == model && (history.start.angle_rad - angle).abs() < 1e-12)
        .unwrap()
}

/// Fig. 10 on the soft stop: rest, a motion of period two with four impacts, one of period one.
#[test]
fn val_the_three_histories_end_where_quad_precision_does() {
    let result = three_starts(9.81);
    let soft = |angle| history(&result, StopModel::Soft, angle);
    for (angle, impacts) in [
        (
            0.8,
            [
                (0, 0.063_038_768_012_339_33, -19.896_045_105_009_71),
                (4, 0.485_369_304_752_695_5, -7.722_031_801_735_252),
                (9, 0.700_008_295_410_080_6, -1.470_128_248_449_573_4),
            ],
        ),
        (
            0.56,
            [
                (0, 0.057_909_816_502_279_87, -14.934_918_180_293_083),
                (4, 0.447_636_215_814_202_8, -4.805_490_232_384_333),
                (9, 0.600_664_903_676_872_5, -1.484_908_937_425_225_4),
            ],
        ),
        (
            0.9,
            [
                (0, 0.064_547_446_918_546_67, -22.002_907_633_056_78),
                (4, 0.495_842_221_211_819_4, -7.519_676_415_214_675),
                (9, 0.781_456_748_791_336_4, -5.364_151_867_330_277),
            ],
        ),
    ] {
        for (index, time, velocity) in impacts {
            let got = soft(angle).impacts[index];
            check_near("time", got[0], time, 1e-12);
            check_near("velocity", got[1], velocity, 1e-9);
        }
    }
    let one = &soft(0.8).settled;
    assert!(one.rests && one.period == Some(1) && one.impacts == 0);
    let two = &soft(0.56).settled;
    assert!(!two.rests && two.period == Some(2) && two.impacts == 4);
    check_near(
        "peak of II",
        two.peak_angle_rad,
        0.019_105_028_304_198_09,
        1e-12,
    );
    let nearest = two
        .section
        .iter()
        .map(|state| {
            (state[0] - 0.016_315_723_135_980_73).abs() + (state[1] - 0.168_775_969_578_507_9).abs()
        })
        .fold(f64::INFINITY, f64::min);
    assert!(nearest < 1e-9, "section of II: {nearest:e}");
    let three = &soft(0.9).settled;
    assert!(!three.rests && three.period == Some(1) && three.impacts == 1);
    check_near(
        "peak of III",
        three.peak_angle_rad,
        0.088_881_716_444_083_2,
        1e-11,
    );
    check_near("III", three.section[0][0], 0.069_436_590_396_707_85, 1e-10);
    check_near("III", three.section[0][1], 2.714_407_353_373_553_7, 1e-8);
}

/// Fig. 10 on the rigid stop: all three starts go to rest, though its other attractors exist.
#[test]
fn val_on_the_rigid_stop_all_three_go_to_rest() {
    for gravity in [9.81, 9.80665] {
        let result = three_starts(gravity);
        for angle in histories::STARTS.map(|start| start.angle_rad) {
            let settled = &history(&result, StopModel::Rigid, angle).settled;
            assert!(settled.rests, "{gravity}, {angle}: {settled:?}");
        }
    }
    let result = three_starts(9.81);
    let ninth = |angle| history(&result, StopModel::Rigid, angle).impacts[9];
    check_near("0.8", ninth(0.8)[0], 0.699_111_053_994_993, 1e-12);
    check_near("0.56", ninth(0.56)[0], 0.599_480_630_522_223_9, 1e-12);
    check_near("0.9", ninth(0.9)[0], 0.768_525_749_897_734_3, 1e-12);
}

/// Points of a trace inside the kernel's long steps lie on the motion: a run that ends there ends
/// in that state.
#[test]
fn verif_points_inside_long_steps_lie_on_the_motion() {
    let result = three_starts(9.81);
    let trace = &history(&result, StopModel::Soft, 0.9).trace;
    let largest_gap = trace
        .windows(2)
        .map(|pair| pair[1].time_s - pair[0].time_s)
        .fold(0.0, f64::max);
    assert!(largest_gap <= result.period_s / 63.9, "{largest_gap:e}");
    assert!(
        trace
            .windows(2)
            .all(|pair| pair[1].time_s >= pair[0].time_s)
    );
    let sine = Harmonic {
        amplitude_m_s2: 9.81,
        angular_frequency_rad_s: 100.0,
        phase_rad: 0.0,
    };
    let options = RunOptions {
        initial: Some(State::new(0.9, 0.0)),
        ..RunOptions::new(StopModel::Soft, OpensWhen::Negative)
    };
    let away = |point: &&TracePoint| point.angle_rad > 1e-3;
    for point in trace.iter().skip(1).filter(away).take(600).step_by(37) {
        let run = replay::run_harmonic(&sine, point.time_s, &Design::reference(), &options)
            .unwrap()
            .run;
        check_near("angle", point.angle_rad, run.final_angle_rad, 1e-13);
        check_near(
            "velocity",
            point.velocity_rad_s,
            run.final_velocity_rad_s,
            1e-11,
        );
    }
}

/// A burst of 35 ms and 1000 g as the separate program had it: rounded to 0.001 m/s².
fn other_burst() -> Signal {
    let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
    let mut samples: Vec<f64> = (0..=700)
        .map(|index| {
            let t = f64::from(index) / 20_000.0;
            let tones: f64 = (1..=24)
                .map(|j| {
                    let j = f64::from(j);
                    let phase = (golden * j * j).fract();
                    (TAU * (20.0 * j * t + phase)).sin()
                })
                .sum();
            let envelope = (PI * t / 0.035).sin();
            let value = 174.6547 * 9.81 * envelope * envelope * tones;
            (value * 1000.0).round() / 1000.0
        })
        .collect();
    samples.resize(6001, 0.0);
    Signal {
        start_s: 0.0,
        rate: SampleRate::from_hertz(20_000.0).unwrap(),
        samples,
    }
}

/// A shock like that of Fig. 11, both stops.
#[test]
fn val_the_answer_to_a_shock_agrees_with_quad_precision() {
    let signal = other_burst();
    for (model, peak, peak_time, crossing, release, impact) in [
        (
            StopModel::Rigid,
            4.155_691_020_497_392,
            0.081_821_111_087_188_87,
            7.629_583_571_380_77e-3,
            9.838_568_487_900_99e-4,
            0.155_928_277_233_893_08,
        ),
        (
            StopModel::Soft,
            4.158_772_800_900_859,
            0.081_830_846_870_026_07,
            7.612_917_787_661_68e-3,
            1.029_617_298_680_133e-3,
            0.155_940_107_206_659_73,
        ),
    ] {
        let run = shock::respond(&signal, &Design::reference(), model)
            .unwrap()
            .run;
        check_near("peak", run.peak_angle_rad, peak, 1e-12);
        check_near("peak time", run.peak_time_s, peak_time, 1e-9);
        check_near("crossing", run.first_crossing_s.unwrap(), crossing, 1e-13);
        check_near("release", run.first_release_s.unwrap(), release, 1e-13);
        assert_eq!(run.impacts, 1);
        check_near("impact", run.impact_list[0][0], impact, 1e-13);
    }
}

/// Both readings of Fig. 11: they differ by what one g is, and the lever opens in either.
#[test]
fn val_both_readings_of_the_shock_open_the_lever() {
    let result = shock::run(&shock::Options {
        design: Design::reference(),
        models: vec![StopModel::Rigid, StopModel::Soft],
        gravity_m_s2: 9.81,
        amplitude_g: 1000.0,
        duration_s: 0.3,
    })
    .unwrap();
    assert_eq!(result.responses.len(), 4);
    let peaks: Vec<f64> = result
        .responses
        .iter()
        .map(|response| response.peak_acceleration_m_s2)
        .collect();
    check_relative("near 1000 g", peaks[0], 9810.0, 1e-3);
    check_relative("factor", peaks[0] / peaks[2], 9.81, 1e-14);
    for response in &result.responses {
        assert!(response.run.peak_angle_rad > 0.1, "{response:?}");
        assert!(response.run.numerical_error_rad < 1e-10);
    }
    assert_eq!(result.signals[0].samples.len(), 6001);
}

/// Charts hold no number that is none, and keep to the size of a page.
#[test]
fn verif_charts_of_the_scenes_are_whole() {
    let free = free_vibration::run(&free_vibration::Options {
        design: Design::reference(),
        models: vec![StopModel::Soft],
        angle_rad: 0.5,
        velocity_rad_s: 0.0,
        periods: 5.0,
    })
    .unwrap();
    let shock = shock::run(&shock::Options {
        design: Design::reference(),
        models: vec![StopModel::Rigid],
        gravity_m_s2: 9.81,
        amplitude_g: 1000.0,
        duration_s: 0.3,
    })
    .unwrap();
    for (name, svg) in [
        (
            "restitution",
            chart::restitution(&equivalence(&Design::reference())),
        ),
        ("step-size", chart::step_size(&sizes(&[10_000, 1000], 30))),
        ("free-vibration", chart::free_vibration(&free)),
        ("spectrogram", chart::spectrogram(&bounces(3.0))),
        // A lever that is watched too shortly to bounce.
        ("spectrogram", chart::spectrogram(&bounces(0.8))),
        ("histories", chart::histories(&three_starts(9.81))),
        ("shock", chart::shock(&shock)),
    ] {
        assert!(
            svg.starts_with("<svg ") && svg.ends_with("</svg>\n"),
            "{name}"
        );
        let shown = svg.replace("base64", "");
        assert!(!shown.contains("NaN"), "{name}");
        assert!(!svg.contains("var(--"), "{name}: a rule kept its variable");
        assert!(svg.contains("prefers-color-scheme:dark"), "{name}");
        assert!(svg.len() < 300_000, "{name}: {} bytes", svg.len());
    }
}

fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("scenes-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    folder
}

fn latchgate(arguments: &[&str]) -> Output {
    crate::support::program()
        .args(arguments)
        .env("NO_COLOR", "1")
        .output()
        .unwrap()
}

#[track_caller]
fn check_files(name: &str, arguments: &[&str], parameter: &str) {
    let out = folder(name);
    let mut all = vec!["study", name, "--out", out.to_str().unwrap()];
    all.extend(["--format", "json"]);
    all.extend(arguments);
    let output = latchgate(&all);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{all:?}: {said}");
    let printed: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(printed["study"], name);
    assert!(printed["elapsed_s"].as_f64().unwrap() >= 0.0);
    assert!(printed["parameters"]["design"]["lever"].is_object());
    assert!(!printed["parameters"][parameter].is_null(), "{parameter}");
    assert!(printed["results"].is_object());
    assert!(printed["headlines"].as_array().unwrap().len() > 5);
    crate::study::check_sentence(name, &printed);
    let stored = std::fs::read(out.join(format!("{name}.json"))).unwrap();
    assert_eq!(stored, output.stdout, "{name}.json is what stdout got");
    let csv = std::fs::read_to_string(out.join(format!("{name}.csv"))).unwrap();
    assert!(csv.lines().count() > 20 && !csv.contains("NaN") && !csv.contains("inf"));
    assert!(out.join(format!("{name}.svg")).metadata().unwrap().len() > 3000);
}

#[test]
fn cli_study_scenes_write_rows_figures_and_charts() {
    check_files("restitution", &["--points", "20"], "points");
    check_files(
        "step-size",
        &["--steps-per-period", "2000", "--points", "8"],
        "steps_per_period",
    );
    check_files("free-vibration", &["--model", "rigid"], "phi0_rad");
    check_files("spectrogram", &["--model", "rigid"], "window");
    check_files(
        "histories",
        &["--phi0", "0.3", "--periods", "10", "--amplitude", "5"],
        "gravity_m_s2",
    );
    check_files("shock", &["--amplitude", "50"], "amplitude_g");
}

#[test]
fn cli_study_scenes_take_any_design() {
    for arguments in [
        ["free-vibration", "--set", "lever.preload_torque_nm=0"].as_slice(),
        &["spectrogram", "--set", "lever.preload_torque_nm=0"],
        &["restitution", "--set", "stop.restitution=0"],
        &[
            "step-size",
            "--set",
            "stop.stiffness_n_per_m=1e5",
            "--points",
            "8",
        ],
        &[
            "histories",
            "--set",
            "lever.preload_torque_nm=2",
            "--periods",
            "5",
        ],
        &["shock", "--set", "lever.preload_torque_nm=50"],
        &[
            "histories",
            "--model",
            "soft",
            "--phi0=-1e-6",
            "--periods",
            "5",
        ],
    ] {
        let out = folder("design");
        let mut all = vec!["study"];
        all.extend(arguments);
        all.extend(["--out", out.to_str().unwrap()]);
        let output = latchgate(&all);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{all:?}: {said}");
    }
}

#[track_caller]
fn check_refused(arguments: &[&str], code: i32, words: &[&str]) {
    let mut all = vec!["study"];
    all.extend(arguments);
    let out = folder("refused");
    all.extend(["--out", out.to_str().unwrap()]);
    let output = latchgate(&all);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{all:?}: {said}");
    for word in words {
        assert!(said.contains(word), "{all:?}: expected `{word}` in: {said}");
    }
}

#[test]
fn cli_study_scenes_refuse_wrong_usage() {
    check_refused(&["restitution", "--points", "1"], 2, &["--points"]);
    check_refused(&["restitution", "--omega", "1"], 2, &["--omega"]);
    check_refused(
        &["step-size", "--steps-per-period", "0"],
        2,
        &["--steps-per-period"],
    );
    check_refused(&["step-size", "--model", "rigid"], 2, &["--model"]);
    check_refused(
        &["free-vibration", "--phi0", "-0.1"],
        2,
        &["--phi0", "--model soft"],
    );
    check_refused(&["free-vibration", "--periods", "1e9"], 2, &["1000"]);
    check_refused(&["spectrogram", "--model", "auto"], 2, &["rigid", "soft"]);
    check_refused(
        &["spectrogram", "--window", "3", "--periods", "2"],
        2,
        &["--window", "--periods"],
    );
    check_refused(&["histories", "--phi0", "NaN"], 2, &["--phi0"]);
    check_refused(&["histories", "--omega", "0"], 2, &["--omega"]);
    check_refused(&["shock", "--duration", "1e6"], 2, &["100"]);
    check_refused(&["shock", "--amplitude", "0"], 2, &["--amplitude"]);
}

/// A negative value after a space is the option's value, so that its range is what is spoken of.
#[test]
fn cli_study_tells_a_negative_value_from_an_option() {
    for study in ["bifurcation", "attractor", "excitation-map"] {
        check_refused(
            &[study, "--amplitude", "-5..3"],
            2,
            &["--amplitude", "-5..3", "from 0 to 50000 g"],
        );
    }
    check_refused(&["bifurcation", "--omega", "-3"], 2, &["--omega", "'-3'"]);
    check_refused(
        &["bifurcation", "--gravity", "-9"],
        2,
        &["--gravity", "'-9'"],
    );
    check_refused(
        &["excitation-map", "--omega", "-5..3"],
        2,
        &["--omega", "above 0"],
    );
    check_refused(&["basins", "--grid", "-2x3"], 2, &["--grid", "from 1 to"]);
    check_refused(
        &["bifurcation", "--points", "-5"],
        2,
        &["--points", "-5 is not in"],
    );
}

/// What only the design makes impossible is no wrong usage.
#[test]
fn cli_study_scenes_end_with_four_where_the_design_forbids() {
    for study in ["free-vibration", "spectrogram"] {
        check_refused(
            &[study, "--set", "lever.spring_stiffness_nm_per_rad=0"],
            4,
            &["spring_stiffness", "natural periods"],
        );
    }
}
