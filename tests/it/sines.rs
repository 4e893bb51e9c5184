//! The studies of sines: bifurcation, attractor, basins, excitation-map. Numbers of quad precision
//! are the results of a separate program that shares no code with the crate; g = 9.81 m/s².

mod commands;
mod properties;

use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::range::Range;
use latchgate_kernel::replay::State;
use latchgate_study::attractor::{self, Attractor};
use latchgate_study::basins::{self, Basins};
use latchgate_study::bifurcation::{self, Sweep};
use latchgate_study::excitation_map;
use latchgate_study::orbit::{self, BifurcationKind, ForcedLever};
use std::sync::atomic::{AtomicBool, Ordering};

/// Gravity of the quad-precision reference values [m/s²].
const GRAVITY: f64 = 9.81;

const BOTH: [StopModel; 2] = [StopModel::Rigid, StopModel::Soft];

fn forced(stop: StopModel, angular_frequency_rad_s: f64) -> ForcedLever {
    ForcedLever {
        design: Design::reference(),
        stop,
        gravity_m_s2: GRAVITY,
        angular_frequency_rad_s,
    }
}

/// Nobody stops the work.
fn all(threads: usize) -> Control<'static> {
    Control {
        threads,
        proceed: &|_| true,
    }
}

/// Says no once all columns are done: while branches are followed, cells cut, sections added.
fn after_the_first_step<T>(of: impl FnOnce(&Control<'_>) -> T) -> T {
    let first = AtomicBool::new(true);
    of(&Control {
        threads: 2,
        proceed: &|part| {
            if part.is_none_or(|part| part < 1.0) {
                return first.load(Ordering::Relaxed);
            }
            first.swap(false, Ordering::Relaxed)
        },
    })
}

#[track_caller]
fn check_near(what: &str, got: f64, want: f64, tolerance: f64) {
    assert!(
        (got - want).abs() <= tolerance,
        "{what}: got {got:.16e}, want {want:.16e}, off by {:e}",
        got - want
    );
}

fn one_amplitude(
    forced: ForcedLever,
    amplitude_g: f64,
    transient: u32,
    periods: u32,
) -> attractor::Options {
    attractor::Options {
        forced,
        amplitudes_g: Range::new(amplitude_g, amplitude_g),
        points: 1,
        transient,
        periods,
        initial: Some(State::new(0.1, 0.0)),
        compared_steps: None,
    }
}

/// Stop, amplitude [g], section, trace and determinant of the map where two impacts or more do not
/// wipe out every difference.
type Point = (StopModel, f64, State, Option<(f64, f64)>);

/// Fig. 6: ω = 20 rad/s.
const SINGLE: [Point; 24] = [
    (
        StopModel::Rigid,
        34.0,
        State::new(0.151_854_808_375_077_14, 12.301_361_672_568_515),
        None,
    ),
    (
        StopModel::Rigid,
        36.0,
        State::new(0.093_235_889_384_158_42, 3.463_407_892_349_420_7),
        None,
    ),
    (
        StopModel::Rigid,
        38.0,
        State::new(0.297_782_799_376_685_67, 10.997_799_904_853_045),
        None,
    ),
    (
        StopModel::Rigid,
        54.0,
        State::new(3.144_122_422_942_467_6, 58.843_889_646_764_93),
        Some((-0.934_184_836_238, 0.396_354_444_727_081)),
    ),
    (
        StopModel::Rigid,
        56.0,
        State::new(3.187_770_855_126_154, 56.115_047_189_207_63),
        Some((-1.171_805_328_986, 0.396_354_444_727_081)),
    ),
    (
        StopModel::Rigid,
        58.0,
        State::new(3.224_642_692_501_351_6, 53.763_795_417_401_53),
        Some((-1.288_332_063_707_000_2, 0.396_354_444_727_081)),
    ),
    (
        StopModel::Rigid,
        60.0,
        State::new(3.257_331_302_190_362_3, 51.647_904_897_984_7),
        Some((-1.294_255_197_675, 0.396_354_444_727_081)),
    ),
    (
        StopModel::Rigid,
        62.0,
        State::new(3.287_416_754_273_984_5, 49.673_756_325_913_51),
        Some((-1.198_435_871_106, 0.396_354_444_727_081)),
    ),
    (
        StopModel::Rigid,
        64.0,
        State::new(3.316_074_504_136_430_3, 47.766_261_199_534_874),
        Some((-1.010_661_730_01, 0.396_354_444_727_081)),
    ),
    (
        StopModel::Rigid,
        66.0,
        State::new(3.344_418_745_118_157, 45.849_495_771_798_39),
        Some((-0.742_658_016_876, 0.396_354_444_727_081)),
    ),
    (
        StopModel::Rigid,
        68.0,
        State::new(3.373_848_374_410_248, 43.823_499_680_912_66),
        Some((-0.408_651_531_462, 0.396_354_444_727_081)),
    ),
    (
        StopModel::Rigid,
        70.0,
        State::new(3.406_677_221_186_517_7, 41.516_375_519_200_14),
        Some((-0.026_482_950_960_4, 0.396_354_444_727_081)),
    ),
    (
        StopModel::Soft,
        34.0,
        State::new(0.146_563_337_914_172_75, 12.089_805_670_326_81),
        None,
    ),
    (
        StopModel::Soft,
        36.0,
        State::new(0.093_272_673_850_670_73, 3.464_306_712_323_226_7),
        None,
    ),
    (
        StopModel::Soft,
        38.0,
        State::new(0.297_825_463_532_516_15, 10.998_673_927_638_361),
        None,
    ),
    (
        StopModel::Soft,
        54.0,
        State::new(3.131_187_455_935_336_8, 59.806_795_863_975_17),
        Some((-0.888_967_111_284, 0.397_531_989_819_456)),
    ),
    (
        StopModel::Soft,
        56.0,
        State::new(3.175_569_673_217_717, 57.034_969_329_677_15),
        Some((-1.146_908_375_474, 0.397_642_564_765_468)),
    ),
    (
        StopModel::Soft,
        58.0,
        State::new(3.212_453_176_995_670_6, 54.677_968_312_146_24),
        Some((-1.282_767_314_26, 0.397_754_884_677_903)),
    ),
    (
        StopModel::Soft,
        60.0,
        State::new(3.244_654_984_934_889, 52.584_472_907_745_955),
        Some((-1.308_108_571_737, 0.397_870_192_340_019)),
    ),
    (
        StopModel::Soft,
        62.0,
        State::new(3.273_802_737_072_041, 50.660_279_406_786_934),
        Some((-1.231_997_060_73, 0.397_989_097_489_706)),
    ),
    (
        StopModel::Soft,
        64.0,
        State::new(3.301_013_633_620_687_7, 48.835_776_671_676_79),
        Some((-1.063_975_897_34, 0.398_111_713_499_138)),
    ),
    (
        StopModel::Soft,
        66.0,
        State::new(3.327_228_499_999_565_6, 47.048_348_845_780_77),
        Some((-0.815_149_767_938, 0.398_237_509_008_674)),
    ),
    (
        StopModel::Soft,
        68.0,
        State::new(3.353_478_469_161_547_3, 45.226_061_332_327_994),
        Some((-0.498_540_057_122, 0.398_364_789_493_146)),
    ),
    (
        StopModel::Soft,
        70.0,
        State::new(3.381_288_560_958_442, 43.259_639_752_863_6),
        Some((-0.129_243_562_382_6, 0.398_489_310_361_29)),
    ),
];

/// Fig. 6: where the paper draws a line the lever does the same in every period, on either stop.
#[test]
fn val_the_lines_of_fig_6_are_single_points() {
    for (stop, amplitude, state, map) in SINGLE {
        let (angle, velocity) = state.into();
        let what = format!("{} A = {amplitude}", stop.name());
        let mut options = one_amplitude(forced(stop, 20.0), amplitude, 250, 10);
        // Motion that does not rest comes through chaos from afar, and at 70 g on the soft stop
        // has a neighbour of period 6: which is reached is rounding's choice, so start next to it.
        if map.is_some() {
            options.initial = Some(State::new(angle + 1e-3, velocity));
        }
        let found = attractor::run(&options, &all(2)).unwrap();
        assert!(found.complete, "{what}");
        assert_eq!(found.periods, [(amplitude, Some(1))], "{what}");
        let orbit = found.orbit.expect("a period has its orbit");
        check_near(&what, orbit.points[0].angle_rad, angle, 1e-9);
        check_near(&what, orbit.points[0].velocity_rad_s, velocity, 1e-9);
        // The rows are the trajectory itself.
        let last = found.rows.last().unwrap();
        check_near(&what, last.angle_rad, angle, 1e-9);
        check_near(&what, last.angular_velocity_rad_s, velocity, 1e-9);
        match map {
            Some((trace, determinant)) => {
                check_near(&what, orbit.trace, trace, 1e-9);
                check_near(&what, orbit.determinant, determinant, 1e-9);
                assert!(!found.superstable, "{what}");
            }
            // It rests in every period; the soft stop only damps what differs.
            None if stop == StopModel::Rigid => assert!(found.superstable, "{what}"),
            None => assert!(orbit.spectral_radius() < 0.01, "{what}"),
        }
    }
}

const NINE: [State; 9] = [
    State::new(1.267_409_838_042_811_8, 12.297_275_056_906_917),
    State::new(0.133_950_672_216_708_64, 7.017_229_509_580_746),
    State::new(0.528_799_173_956_144, 18.201_701_214_565_563),
    State::new(0.856_069_720_999_286_1, 20.990_063_856_100_19),
    State::new(1.440_992_342_966_873_6, 19.052_191_859_007_173),
    State::new(1.371_168_318_729_475_2, -2.596_210_749_133_214),
    State::new(0.620_374_848_047_918_6, 16.007_217_817_673_727),
    State::new(1.042_417_480_826_954_2, 22.994_274_154_473_583),
    State::new(1.431_856_896_737_196, 10.781_594_518_021_661),
];

const SIX: [State; 6] = [
    State::new(1.227_560_710_454_321_4, 22.675_943_914_861_687),
    State::new(0.299_589_681_395_596_16, 6.513_913_123_469_031),
    State::new(0.528_844_193_401_186_4, 18.202_442_129_973_477),
    State::new(0.937_867_743_971_423_9, 21.805_248_585_844_204),
    State::new(0.285_985_471_830_834_8, 18.355_271_437_681_104),
    State::new(0.654_733_057_157_243_6, 19.959_338_363_928_84),
];

/// Fig. 7: what the paper takes for chaos has period nine on the rigid stop, six on the soft one.
#[track_caller]
fn check_fig_7(stop: StopModel, points: &[State]) {
    let options = one_amplitude(forced(stop, 20.0), 40.0, 200, 60);
    let found = attractor::run(&options, &all(2)).unwrap();
    let period = u32::try_from(points.len()).unwrap();
    assert_eq!(found.periods, [(40.0, Some(period))]);
    assert!(found.complete);
    let growth = found.growth.expect("measured along the period");
    assert!(growth.resolved(), "{growth:?}");
    let orbit = found.orbit.expect("a period has its orbit");
    assert_eq!(orbit.period, period);
    // A rest on the rigid stop wipes every difference out, one on the soft stop damps it.
    assert_eq!(found.superstable, stop == StopModel::Rigid);
    assert!(orbit.spectral_radius() < 1e-3);
    let shift = (0..points.len())
        .find(|shift| options.forced.distance(orbit.points[*shift], points[0]) < 1e-6)
        .expect("the first of the points");
    for (index, point) in points.iter().enumerate() {
        let got = orbit.points[(shift + index) % points.len()];
        let what = format!("{} point {index}", stop.name());
        // A velocity counts by ω, as in the study. At the last point before the rest, the second
        // of the tables, rounding has grown by all the decades of the period.
        let tolerance = if index == 1 {
            2e-15 * libm::pow(10.0, growth.decades_max)
        } else {
            2e-10
        };
        let (angle, velocity) = (*point).into();
        check_near(&what, got.angle_rad, angle, tolerance);
        check_near(&what, got.velocity_rad_s / 20.0, velocity / 20.0, tolerance);
    }
}

#[test]
fn val_the_attractors_of_fig_7_are_periodic() {
    check_fig_7(StopModel::Rigid, &NINE);
    check_fig_7(StopModel::Soft, &SIX);
}

/// With standard gravity the rigid period exceeds 90 in quad precision, beyond what a double
/// carries: whatever repeats itself there is rounding's, and is not claimed.
#[test]
fn val_no_period_is_claimed_where_rounding_decides() {
    let standard = ForcedLever {
        gravity_m_s2: 9.80665,
        ..forced(StopModel::Rigid, 20.0)
    };
    // Two amplitudes spare the measurement of growth that follows where there is but one.
    let options = attractor::Options {
        amplitudes_g: Range::new(40.0, 40.000_1),
        points: 2,
        ..one_amplitude(standard, 40.0, 200, 600)
    };
    let found = attractor::run(&options, &all(2)).unwrap();
    assert_eq!(found.periods[0], (40.0, None));
    assert!(found.orbit.is_none() && !found.superstable);
}

/// The same in the diagram: a lever that rests repeats itself to the last bit in the end, which
/// makes no period of it.
#[test]
fn regress_a_diagram_claims_no_period_of_rounding() {
    let rigid = forced(StopModel::Rigid, 20.0);
    let diagram = bifurcation::run(
        &bifurcation::Options {
            forced: rigid.clone(),
            amplitudes_g: Range::new(39.9, 40.1),
            points: 41,
            transient: 100,
            periods: 120,
            initial: Some(State::new(0.1, 0.0)),
            sweep: Sweep::None,
            doublings: 0,
        },
        &all(2),
    )
    .unwrap();
    assert_eq!(diagram.columns[20].period, Some(9), "A = 40");
    let mut doubted = 0;
    for column in &diagram.columns {
        let seen = orbit::period_of(&rigid, &column.sections, 1e-7);
        let last = column.sections.last().unwrap();
        let grown = |period| {
            let start = last.state();
            orbit::difference_growth(&rigid, column.amplitude_g, Some(start), 0, 2 * period)
                .unwrap()
                .is_none_or(|growth| growth.resolved())
        };
        let want = seen.filter(|period| grown(*period));
        assert_eq!(column.period, want, "A = {}", column.amplitude_g);
        doubted += u32::from(seen.is_some() && want.is_none());
    }
    assert!(doubted > 0, "no column shows what is guarded against");
}

/// Amplitudes 39.9 to 40.1 g: means over 401 amplitudes and their standard errors.
#[track_caller]
fn check_ensemble(stop: StopModel, want: [(f64, f64); 3]) {
    let options = attractor::Options {
        amplitudes_g: Range::new(39.9, 40.1),
        points: 60,
        ..one_amplitude(forced(stop, 20.0), 0.0, 100, 100)
    };
    let found = attractor::run(&options, &all(2)).unwrap();
    let statistics = found.statistics.expect("several amplitudes");
    assert_eq!(statistics.amplitudes, 60);
    assert!(found.growth.is_none() && found.orbit.is_none() && found.complete);
    let got = [
        statistics.angle_rad,
        statistics.angular_velocity_rad_s,
        statistics.share_beyond_1_rad,
    ];
    for (index, (got, (mean, error))) in got.iter().zip(want).enumerate() {
        let combined = got.standard_error.hypot(error);
        let what = format!("{} mean {index}", stop.name());
        check_near(&what, got.mean, mean, 4.0 * combined);
        // The errors of samples go with the root of their size, within what batches leave open.
        let expected = error * (401.0_f64 / 60.0).sqrt();
        let ratio = got.standard_error / expected;
        assert!((0.5..2.0).contains(&ratio), "{what}: error {ratio} of it");
    }
    check_means(&found);
}

/// The statistics are those of the rows.
#[track_caller]
fn check_means(found: &Attractor) {
    let means: Vec<f64> = found
        .rows
        .chunk_by(|a, b| a.amplitude_g == b.amplitude_g)
        .map(|rows| rows.iter().map(|row| row.angle_rad).sum::<f64>() / rows.len() as f64)
        .collect();
    assert_eq!(means.len(), found.periods.len());
    let count = means.len() as f64;
    let mean = means.iter().sum::<f64>() / count;
    let variance = means.iter().map(|one| (one - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let got = found.statistics.unwrap().angle_rad;
    check_near("mean of means", got.mean, mean, 1e-13);
    check_near(
        "its error",
        got.standard_error,
        (variance / count).sqrt(),
        1e-13,
    );
}

#[test]
fn val_the_ensemble_of_fig_7_agrees_with_quad_precision() {
    check_ensemble(
        StopModel::Rigid,
        [
            (1.139_140_746_6, 0.015_904_697_8),
            (22.726_729_644_5, 0.325_865_898_8),
            (0.450_336_658_4, 0.010_117_339_3),
        ],
    );
    check_ensemble(
        StopModel::Soft,
        [
            (1.189_382_390_3, 0.013_765_823_0),
            (23.429_588_886_2, 0.320_059_1),
            (0.502_867_828_0, 0.008_632_753_0),
        ],
    );
}

/// ω = 100 rad/s, A = 2.5 on the soft stop is chaotic: 0.507 per period from long runs with the
/// variational equation.
#[test]
fn val_chaos_shows_its_exponent() {
    let options = one_amplitude(forced(StopModel::Soft, 100.0), 2.5, 200, 600);
    let found = attractor::run(&options, &all(2)).unwrap();
    assert_eq!(found.periods, [(2.5, None)]);
    let growth = found.growth.expect("measured");
    let exponent = growth.lyapunov().expect("no rests");
    assert!(exponent > 20.0 * growth.standard_error, "{growth:?}");
    assert!(growth.standard_error > 1e-3, "{growth:?}");
    check_near("λ", exponent, 0.507, 4.0 * growth.standard_error);
    assert!(!growth.resolved(), "{growth:?}");
}

/// The same on the rigid stop: rare rests make the trajectory of a double repeat itself, over a
/// stretch in which rounding has grown to the motion's size.
#[test]
fn val_rare_rests_make_no_period() {
    let options = one_amplitude(forced(StopModel::Rigid, 100.0), 2.5, 200, 3000);
    let found = attractor::run(&options, &all(2)).unwrap();
    assert_eq!(found.periods, [(2.5, None)]);
    assert!(found.orbit.is_none() && !found.superstable);
    let growth = found.growth.expect("measured instead");
    assert!(
        growth.rests > 0 && growth.lyapunov().is_none(),
        "{growth:?}"
    );
}

/// On the soft stop a long contact wipes out what a double holds: with g = 9.80665 the digits at
/// A = 40 repeat themselves, though rounding has grown to the motion's size in between. The exponent
/// of what is repeated, 0.48 per period with a standard error of 0.02, used to pass for that of
/// chaos; it jumps with the last digits of A.
#[test]
fn regress_digits_that_repeat_have_no_exponent() {
    let soft = orbit::ForcedLever {
        gravity_m_s2: 9.806_65,
        ..forced(StopModel::Soft, 20.0)
    };
    let options = one_amplitude(soft, 40.0, 200, 600);
    let found = attractor::run(&options, &all(2)).unwrap();
    assert_eq!(found.periods, [(40.0, None)]);
    let growth = found.growth.expect("measured");
    assert!(growth.lyapunov().is_none(), "{growth:?}");
    assert!(growth.returned.is_some() && growth.forgets(), "{growth:?}");
    assert!(!growth.resolved(), "{growth:?}");
}

/// Midpoints of 100 × 100 cells of (0, 1) × (−20, 20), 300 periods: cells that rest, of period two,
/// of period one.
#[track_caller]
fn check_basins(stop: StopModel, cells: [usize; 3]) -> Basins {
    // The cells are wanted, not the quarters of those at a boundary.
    let found = after_the_first_step(|control| basins_of(stop, 100, 300, control));
    let periods: Vec<u32> = found.attractors.iter().map(|one| one.period).collect();
    assert_eq!(periods, [1, 2, 1], "{}", stop.name());
    for (attractor, want) in found.attractors.iter().zip(cells) {
        let index = Some(attractor.index);
        let got = found.cells.iter().filter(|cell| **cell == index).count();
        assert_eq!(got, want, "{} {}", stop.name(), attractor.name);
        check_near(
            &attractor.name,
            attractor.share.unwrap(),
            want as f64 / 1e4,
            1e-12,
        );
        check_near("error", attractor.standard_error.unwrap(), 2.5e-3, 1.5e-3);
    }
    found
}

fn basins_options(stop: StopModel, side: u32, transient: u32) -> basins::Options {
    basins::Options {
        forced: forced(stop, 100.0),
        amplitude_g: 1.0,
        angle_rad: Range::new(0.0, 1.0),
        velocity_rad_s: Range::new(-20.0, 20.0),
        grid: (side, side),
        transient,
    }
}

fn basins_of(stop: StopModel, side: u32, transient: u32, control: &Control<'_>) -> Basins {
    basins::run(&basins_options(stop, side, transient), control).unwrap()
}

#[test]
fn val_the_basins_of_the_rigid_stop_agree_with_another_program() {
    check_basins(StopModel::Rigid, [3012, 212, 6776]);
}

#[test]
fn val_the_basins_of_the_soft_stop_agree_with_another_program() {
    check_attractors(&check_basins(StopModel::Soft, [3129, 186, 6685]));
}

/// Attractors of A = 1 are those of quad precision, found without a guess.
#[track_caller]
fn check_attractors(found: &Basins) {
    let [rest, second, third] = found.attractors.as_slice() else {
        panic!("{:?}", found.attractors);
    };
    assert_eq!(rest.name, "I (rest)");
    assert_eq!(second.name, "II (period 2)");
    assert_eq!(third.name, "III (period 1)");
    let angle = third.points[0].angle_rad;
    check_near("III", angle, 0.069_436_590_396_707_85, 1e-12);
    check_near("III", third.peak_angle_rad, 0.088_881_716_444_083, 1e-9);
    check_near("II", second.peak_angle_rad, 0.019_105_028_3, 1e-9);
    assert!(rest.peak_angle_rad <= 1e-9);
    assert_eq!(rest.capture_radius_rad, 0.0);
    for moving in [second, third] {
        let radius = moving.capture_radius_rad;
        assert!((1e-4..=0.1).contains(&radius), "{radius}");
    }
}

/// m A g L = T0: 1.0632… with g = 9.81 m/s², 1.0636… with standard gravity.
#[test]
fn val_a_lever_at_rest_leaves_its_stop_at_the_lift_off_amplitude() {
    let rigid = forced(StopModel::Rigid, 100.0);
    check_near("9.81", rigid.lift_off_g(), 1.063_226_067_11, 1e-11);
    let standard = ForcedLever {
        gravity_m_s2: 9.80665,
        ..rigid.clone()
    };
    check_near("9.80665", standard.lift_off_g(), 1.063_589_270_38, 1e-11);
    for (part, moves) in [(1.0 - 1e-9, false), (1.0 + 1e-9, true)] {
        let mut strobe = rigid.strobe(part * rigid.lift_off_g(), None).unwrap();
        let peak = strobe.advance().unwrap().peak_angle_rad;
        assert_eq!(peak > 0.0, moves, "{part}: {peak:e}");
    }
}

/// The diagram finds the branch of motion III by itself: its birth and three doublings. The first
/// column rests; motion III next to it once passed for going on from that, and was not followed.
#[test]
fn val_a_diagram_finds_its_cascade() {
    let options = bifurcation::Options {
        forced: forced(StopModel::Soft, 100.0),
        amplitudes_g: Range::new(0.35, 2.2),
        points: 12,
        transient: 200,
        periods: 30,
        initial: Some(State::new(0.07, 2.7)),
        sweep: Sweep::None,
        doublings: 3,
    };
    let diagram = bifurcation::run(&options, &all(2)).unwrap();
    let branch = diagram
        .branches
        .iter()
        .find(|branch| {
            branch.birth.as_ref().is_some_and(|birth| {
                birth.kind == BifurcationKind::SaddleNode
                    && (birth.orbit.amplitude_g - 0.415_660_115_422_949_8).abs() <= 1e-9
            })
        })
        .expect("the branch of motion III");
    assert_eq!(branch.doublings.len(), 3);
    for (found, want) in branch.doublings.iter().zip([
        1.753_715_585_397_385,
        2.085_106_076_038_248,
        2.149_008_291_822_270_6,
    ]) {
        check_near("doubling", found.orbit.amplitude_g, want, 1e-9);
    }
    let said = diagram.headlines();
    assert!(
        said.iter()
            .any(|line| line.what == "period 1: doubles to 2 at A [g]")
    );
    // Once is enough for each branch.
    let births: Vec<f64> = diagram
        .branches
        .iter()
        .filter_map(|branch| branch.birth.as_ref())
        .map(|birth| birth.orbit.amplitude_g)
        .collect();
    for (index, birth) in births.iter().enumerate() {
        assert!(
            births[..index]
                .iter()
                .all(|other| (other - birth).abs() > 1e-9)
        );
    }
}

/// Largest angle of a lever that starts from rest [rad].
fn peak(forced: &ForcedLever, amplitude_g: f64, periods: u32) -> f64 {
    let mut strobe = forced.strobe(amplitude_g, None).unwrap();
    (0..periods)
        .map(|_| strobe.advance().unwrap().peak_angle_rad)
        .fold(f64::NEG_INFINITY, f64::max)
}

/// Below lift-off nothing moves on the rigid stop, and the soft one only gives its own deflection
/// back; the contour is where the threshold is first exceeded.
#[test]
fn val_the_map_of_excitations_starts_at_lift_off() {
    for stop in BOTH {
        let options = excitation_map::Options {
            forced: forced(stop, 1.0),
            amplitudes_g: Range::new(0.0, 6.0),
            angular_frequencies_rad_s: Range::new(10.0, 300.0),
            grid: (12, 6),
            periods: 10,
        };
        let map = excitation_map::run(&options, &all(2)).unwrap();
        assert!(map.complete);
        assert_eq!((map.rows.len(), map.boundary.len()), (72, 6));
        check_near("lift-off", map.lift_off_g, 1.063_226_067_11, 1e-11);
        for row in map
            .rows
            .iter()
            .filter(|row| row.amplitude_g < map.lift_off_g)
        {
            match stop {
                StopModel::Rigid => assert_eq!(row.peak_angle_rad, 0.0, "{row:?}"),
                StopModel::Soft => assert!(row.peak_angle_rad.abs() < 1e-4, "{row:?}"),
            }
        }
        for row in map
            .rows
            .iter()
            .filter(|row| row.amplitude_g > map.lift_off_g)
        {
            assert!(row.peak_angle_rad > 0.0, "{row:?}");
        }
        let mut contours = 0;
        for at in &map.boundary {
            let there = ForcedLever {
                angular_frequency_rad_s: at.angular_frequency_rad_s,
                ..options.forced.clone()
            };
            let exceeds = |row: &&excitation_map::Row| {
                row.angular_frequency_rad_s == at.angular_frequency_rad_s
                    && row.peak_angle_rad > 0.1
            };
            let first = map.rows.iter().find(exceeds).map(|row| row.amplitude_g);
            let (Some(first), Some(contour)) = (first, at.amplitude_g) else {
                assert_eq!(first, at.amplitude_g, "{at:?}");
                continue;
            };
            contours += 1;
            assert!(map.lift_off_g < contour && contour <= first, "{at:?}");
            assert!(first - contour <= 0.5, "{at:?}: not next to {first}");
            assert!(peak(&there, contour, 10) > 0.1, "{at:?}");
            // Under chaos the angle goes up and down within less than that.
            let within = (1..=50).map(|step| contour * (1.0 - 2e-8 * f64::from(step)));
            let mut below = within.map(|amplitude| peak(&there, amplitude, 10));
            assert!(below.any(|peak| peak <= 0.1), "{at:?}");
        }
        assert!(contours >= 3, "{:?}", map.boundary);
    }
}
