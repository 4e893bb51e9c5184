//! Periodic orbits and their bifurcations against quad-precision values (the tables are the
//! results of a separate program; g = 9.81 m/s²).

use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::State;
use latchgate_study::cascade::{self, BranchBounds, Cascade};
use latchgate_study::orbit::{self, BifurcationKind, ForcedLever, Orbit};

fn forced(stop: StopModel, angular_frequency_rad_s: f64) -> ForcedLever {
    ForcedLever {
        design: Design::reference(),
        stop,
        gravity_m_s2: 9.81,
        angular_frequency_rad_s,
    }
}

#[track_caller]
fn check_near(what: &str, got: f64, want: f64, tolerance: f64) {
    assert!(
        (got - want).abs() <= tolerance,
        "{what}: got {got:.16e}, want {want:.16e}, off by {:e}",
        got - want
    );
}

#[track_caller]
fn find(forced: &ForcedLever, amplitude: f64, period: u32, guess: State) -> Orbit {
    orbit::find(forced, amplitude, period, guess).expect("an orbit near the guess")
}

#[test]
fn val_orbits_of_the_basins() {
    let soft = forced(StopModel::Soft, 100.0);
    let third = find(&soft, 1.0, 1, State::new(0.07, 2.7));
    check_near(
        "III angle",
        third.points[0].angle_rad,
        0.069_436_590_396_707_85,
        1e-13,
    );
    check_near(
        "III velocity",
        third.points[0].velocity_rad_s,
        2.714_407_357_353_373_7,
        1e-11,
    );
    check_near(
        "III peak",
        third.peak_angle_rad,
        0.088_881_716_444_083_3,
        1e-12,
    );
    check_near("III determinant", third.determinant, 0.635_737, 1e-6);
    let [(re, im), _] = third.multipliers();
    check_near("III multiplier", re, -0.081_55, 1e-5);
    check_near("III multiplier", im, 0.793, 1e-3);
    let second = find(&soft, 1.0, 2, State::new(0.016_3, 0.169));
    check_near(
        "II angle",
        second.points[0].angle_rad,
        0.016_315_723_135_980_73,
        1e-12,
    );
    assert_eq!(second.impacts, 4);
    let rigid = forced(StopModel::Rigid, 100.0);
    let third = find(&rigid, 1.0, 1, State::new(0.07, 2.7));
    let angle = third.points[0].angle_rad;
    check_near("rigid III", angle, 0.070_207_868_965_3, 1e-12);
}

#[track_caller]
fn check_cascade(name: &str, cascade: &Cascade, birth: f64, doublings: &[f64]) {
    let found = cascade.birth.as_ref().expect("a birth");
    assert_eq!(found.kind, BifurcationKind::SaddleNode);
    check_near(name, found.orbit.amplitude_g, birth, 1e-12);
    assert_eq!(cascade.doublings.len(), doublings.len(), "{name}");
    for (index, (found, want)) in cascade.doublings.iter().zip(doublings).enumerate() {
        let what = format!("{name} PD{}", index + 1);
        println!("{what} off {:e}", found.orbit.amplitude_g - want);
        check_near(&what, found.orbit.amplitude_g, *want, 1e-12);
    }
}

/// A branch of orbits of period 1, with the values of a separate program.
struct Branch {
    name: &'static str,
    stop: StopModel,
    /// Amplitude [g] at which the orbit is sought, and a state near it.
    start: (f64, State),
    birth_g: f64,
    doublings_g: [f64; 6],
}

const III: (f64, State) = (1.0, State::new(0.069, 2.71));

const II: (f64, State) = (0.97, State::new(0.0177, 0.124));

const BRANCHES: [Branch; 4] = [
    Branch {
        name: "soft III",
        stop: StopModel::Soft,
        start: III,
        birth_g: 0.415_660_115_422_949_8,
        doublings_g: [
            1.753_715_585_397_385,
            2.085_106_076_038_248,
            2.149_008_291_822_270_6,
            2.159_468_878_485_024,
            2.161_658_104_234_564_4,
            2.162_127_210_957_830_2,
        ],
    },
    Branch {
        name: "rigid III",
        stop: StopModel::Rigid,
        start: III,
        birth_g: 0.418_637_738_151_618_6,
        doublings_g: [
            1.758_247_378_163_540_2,
            2.088_094_212_997_889,
            2.151_644_021_855_348_3,
            2.162_045_348_182_782_6,
            2.164_222_036_629_215_3,
            2.164_688_453_329_971,
        ],
    },
    Branch {
        name: "soft II",
        stop: StopModel::Soft,
        start: II,
        birth_g: 0.888_156_704_883_802_5,
        doublings_g: [
            0.985_769_527_728_497_7,
            1.007_932_551_878_239_8,
            1.011_794_645_669_725,
            1.012_595_444_763_319_4,
            1.012_767_321_168_545_5,
            1.012_804_168_692_631_2,
        ],
    },
    Branch {
        name: "rigid II",
        stop: StopModel::Rigid,
        start: II,
        birth_g: 0.891_682_740_591_421_5,
        doublings_g: [
            0.989_309_508_772_555_5,
            1.011_431_468_013_381_6,
            1.015_281_764_146_538,
            1.016_079_656_859_288_5,
            1.016_250_908_548_559,
            1.016_287_622_162_008_6,
        ],
    },
];

fn check_branch(branch: &Branch) {
    let (name, doublings) = (branch.name, &branch.doublings_g);
    let forced = forced(branch.stop, 100.0);
    let (amplitude_g, guess) = branch.start;
    let orbit = find(&forced, amplitude_g, 1, guess);
    let bounds = BranchBounds::all(6);
    let cascade = cascade::follow(&forced, &orbit, 0.01 * amplitude_g, &bounds);
    check_cascade(name, &cascade, branch.birth_g, doublings);
    // Those of the separate program's own values, and with that on their way to Feigenbaum's.
    let ratios = cascade.ratios();
    for (index, (got, at)) in ratios.iter().zip(doublings.windows(3)).enumerate() {
        let want = (at[1] - at[0]) / (at[2] - at[1]);
        check_near(&format!("{name} ratio {index}"), *got, want, 1e-3);
    }
    let last = ratios[ratios.len() - 1];
    check_near(name, last, 4.669_201_6, 0.01);
    let tends = cascade.accumulation_g().unwrap();
    let gap = doublings[5] - doublings[4];
    check_near(name, tends, doublings[5] + gap / 3.669_201_6, 1e-8);
}

#[test]
fn val_cascades_of_motions_ii_and_iii_on_both_stops() {
    let failed: Vec<&str> = std::thread::scope(|scope| {
        let checks: Vec<_> = BRANCHES
            .iter()
            .map(|branch| (branch.name, scope.spawn(|| check_branch(branch))))
            .collect();
        let checks = checks.into_iter();
        checks
            .filter_map(|(name, check)| check.join().err().map(|_| name))
            .collect()
    });
    assert!(failed.is_empty(), "branches that differ: {failed:?}");
}
