//! Guards what an ensemble is made of: generator, draws, bounds, members, looks. Values from
//! outside: Random123's known answers for Philox, those of R's `binom.test` and `qnorm`, closed
//! forms.

use super::*;
use latchgate_kernel::model::criterion::Criterion;
use latchgate_kernel::model::stop::damping_ratio;
use latchgate_kernel::model::tolerance::Tolerance;
use latchgate_kernel::replay::batch::Member;
use latchgate_kernel::units::Restitution;
use latchgate_verdict::decision::ShareBounds;
use latchgate_verdict::ensemble::bounds::{
    incomplete_beta, look_confidence, lower, members_needed, upper,
};
use latchgate_verdict::ensemble::draw::{inverse_normal, philox, truncated_normal, uniform};
use latchgate_verdict::ensemble::{self, Count, LOOKS, Scatter, looks};

/// Of each bound at each of the four looks, which may err in 5 % of cases together.
const LOOK_CONFIDENCE: f64 = 1.0 - 0.05 / 4.0;

#[track_caller]
pub(super) fn check_close(name: &str, found: f64, expected: f64, relative: f64) {
    let error = (found - expected).abs();
    assert!(
        error <= relative * expected.abs(),
        "{name}: {found} instead of {expected}"
    );
}

// ---------------------------------------------------------------- draws

/// Known answers published with the generator (Random123, `kat_vectors`, philox4x32 10).
#[test]
fn val_philox_known_answers() {
    for (counter, key, expected) in [
        (
            [0; 4],
            [0; 2],
            [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8],
        ),
        (
            [u32::MAX; 4],
            [u32::MAX; 2],
            [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd],
        ),
        (
            [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
            [0xa409_3822, 0x299f_31d0],
            [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1],
        ),
    ] {
        assert_eq!(philox(counter, key), expected);
    }
}

#[test]
fn val_inverse_normal_at_published_points() {
    for (p, z) in [
        (0.5, 0.0),
        (0.75, 0.674_489_750_196_081_7),
        (0.975, 1.959_963_984_540_054),
        (0.001, -3.090_232_306_167_813),
        (1e-10, -6.361_340_902_404_055),
    ] {
        check_close("z", inverse_normal(p), z, 4e-15);
    }
    for p in [0.0, 1.0, -0.1, 1.1, f64::NAN, 1e-12] {
        assert!(inverse_normal(p).is_nan(), "{p}");
    }
}

/// Φ(Φ⁻¹(p)) = p; a relative error of z in a tail is one of p about z² times as large.
#[test]
fn verif_inverse_normal_is_an_inverse() {
    let mut worst: f64 = 0.0;
    for step in 1..16_384 {
        let p = f64::from(step) / 32_768.0;
        let z = inverse_normal(p);
        let back = 0.5 * libm::erfc(-z / std::f64::consts::SQRT_2);
        worst = worst.max((back / p - 1.0).abs() / (1.0 + z * z));
        // 1 − p is exact here, and the distribution symmetric.
        assert_eq!(inverse_normal(1.0 - p), -z);
    }
    assert!(worst < 8e-16, "{worst:e}");
}

/// Mean 0, variance 1 − 6 φ(3)/(2 Φ(3) − 1) = 0.973337, nothing beyond ±3, and no correlation
/// between neighbours, streams or seeds; each within four standard errors.
#[test]
fn verif_draws_have_the_truncated_distribution() {
    let count = 100_000_u32;
    let total = f64::from(count);
    let draws = |seed, stream| -> Vec<f64> {
        (0..count)
            .map(|member| truncated_normal(seed, member, stream))
            .collect()
    };
    let own = draws(1, 0);
    assert!(own.iter().all(|z| z.abs() <= 3.0));
    let mean = own.iter().sum::<f64>() / total;
    assert!(mean.abs() < 4.0 / total.sqrt(), "{mean}");
    let variance = own.iter().map(|z| z * z).sum::<f64>() / total;
    // The fourth moment of the truncated distribution is 2.68.
    let error = ((2.68 - 0.947) / total).sqrt();
    assert!((variance - 0.973_337).abs() < 4.0 * error, "{variance}");
    let tail = own.iter().filter(|z| z.abs() > 2.0).count() as f64 / total;
    let expected = (0.045_500_264 - 0.002_699_796) / 0.997_300_204;
    assert!(
        (tail - expected).abs() < 4.0 * (expected / total).sqrt(),
        "{tail}"
    );
    let shifted: Vec<f64> = own[1..].iter().copied().chain([own[0]]).collect();
    for (name, other) in [
        ("neighbours", shifted),
        ("streams", draws(1, 1)),
        ("seeds", draws(2, 0)),
        ("high word of the seed", draws(1 << 32, 0)),
    ] {
        let product = own.iter().zip(&other).map(|(a, b)| a * b).sum::<f64>() / total;
        assert!(product.abs() < 4.0 / total.sqrt(), "{name}: {product}");
    }
    for member in 0..1000 {
        let u = uniform(7, member, 3);
        assert!(u > 0.0 && u < 1.0);
    }
}

// ---------------------------------------------------------------- bounds

/// Two-sided 95 % intervals of `binom.test` in R, and closed forms at none and all.
#[test]
fn val_clopper_pearson_against_published_intervals() {
    for (count, members, low, high) in [
        (1, 10, 0.002_528_579, 0.445_016_1),
        (5, 20, 0.086_571_47, 0.491_045_9),
        (0, 10, 0.0, 0.308_497_1),
        (10, 10, 0.691_502_9, 1.0),
    ] {
        check_close("lower", lower(count, members, 0.975), low, 3e-7);
        check_close("upper", upper(count, members, 0.975), high, 3e-7);
    }
    for members in [1, 128, 512, 2048, 10_000, 1_000_000] {
        let total = members as f64;
        let most = -libm::expm1(libm::log(0.0125) / total);
        check_close("none", upper(0, members, LOOK_CONFIDENCE), most, 1e-9);
        let least = libm::exp(libm::log(0.0125) / total);
        check_close("all", lower(members, members, LOOK_CONFIDENCE), least, 1e-9);
        assert_eq!(lower(0, members, LOOK_CONFIDENCE), 0.0);
        assert_eq!(upper(members, members, LOOK_CONFIDENCE), 1.0);
    }
    assert_eq!((lower(0, 0, 0.9), upper(0, 0, 0.9)), (0.0, 1.0));
}

/// P(X ≥ k) of the binomial distribution at the lower bound, P(X ≤ k) at the upper one, is what
/// the confidence leaves: the sum itself, not its continued fraction.
#[test]
fn verif_bounds_solve_the_binomial_tail() {
    let term = |k: u64, n: u64, p: f64| {
        let (k, n) = (k as f64, n as f64);
        libm::exp(
            libm::lgamma(n + 1.0) - libm::lgamma(k + 1.0) - libm::lgamma(n - k + 1.0)
                + k * libm::log(p)
                + (n - k) * libm::log1p(-p),
        )
    };
    for n in [3_u64, 128, 512, 2048] {
        for k in [1, 2, n / 20, n / 2, n - n / 20, n - 1] {
            if k == 0 || k >= n {
                continue;
            }
            let p = lower(k, n, LOOK_CONFIDENCE);
            let tail: f64 = (k..=n).map(|k| term(k, n, p)).sum();
            check_close("lower", tail, 0.0125, 1e-9);
            let p = upper(k, n, LOOK_CONFIDENCE);
            let tail: f64 = (0..=k).map(|k| term(k, n, p)).sum();
            check_close("upper", tail, 0.0125, 1e-9);
        }
    }
    // I(x; a, b) + I(1 − x; b, a) = 1, and I(x; 1, 1) = x.
    for (x, a, b) in [(0.3, 2.0, 5.0), (0.01, 40.0, 4000.0), (0.7, 900.0, 3.5)] {
        let sum = incomplete_beta(x, a, b) + incomplete_beta(1.0 - x, b, a);
        check_close("sum", sum, 1.0, 1e-12);
        check_close("uniform", incomplete_beta(x, 1.0, 1.0), x, 1e-14);
    }
}

/// How many members may cross at each look for a pass, and how many must for a fail: sums of
/// the binomial distribution, made by another program. `docs/decision.md` has the same numbers.
#[test]
fn val_what_each_look_can_decide() {
    let expected = [
        (1, 78, 127),
        (14, 282, 498),
        (80, 1076, 1968),
        (451, 5113, 9549),
    ];
    for (look, (pass, fail, alone)) in LOOKS.into_iter().zip(expected) {
        let members = u64::from(look);
        let high = |count| upper(count, members, LOOK_CONFIDENCE);
        let low = |count| lower(count, members, LOOK_CONFIDENCE);
        assert!(high(pass) <= 0.05 && high(pass + 1) > 0.05, "{look}");
        assert!(low(fail) > 0.5 && low(fail - 1) <= 0.5, "{look}");
        assert!(low(alone) >= 0.95 && low(alone - 1) < 0.95, "{look}");
    }
}

#[test]
fn verif_members_that_were_not_followed_count_against_either_answer() {
    let peaks: Vec<f64> = (0..128)
        .map(|index| match index {
            0..100 => 0.01,
            100..120 => 0.3,
            _ => f64::NAN,
        })
        .collect();
    let count = Count::of(&peaks, 0.1);
    assert_eq!(
        (count.members, count.exceeded, count.failed_to_run),
        (128, 20, 8)
    );
    let ShareBounds {
        lower: low,
        upper: high,
        upper_with_coast,
        allowed: _,
    } = count.share(&Criterion::default());
    assert_eq!(low, lower(20, 128, LOOK_CONFIDENCE));
    assert_eq!(high, upper(28, 128, LOOK_CONFIDENCE));
    assert_eq!(upper_with_coast.to_bits(), high.to_bits());
    // Of those that stay below in the window, 30 exceed it in the coast and 5 get lost there.
    let highest: Vec<f64> = (0..128)
        .map(|member| match member {
            0..30 => 0.11,
            30..35 => f64::NAN,
            _ => peaks[member],
        })
        .collect();
    let count = Count::with_coast(&peaks, &highest, 0.1);
    assert_eq!((count.exceeded, count.exceeded_in_coast), (20, 35));
    let share = count.share(&Criterion::default());
    assert_eq!(share.upper, upper(28, 128, LOOK_CONFIDENCE));
    assert_eq!(share.upper_with_coast, upper(63, 128, LOOK_CONFIDENCE));
    // The limit itself is not exceeded; a member that is no lever has an infinite angle, and is open.
    let count = Count::of(&[0.1, f64::INFINITY, f64::NAN], 0.1);
    assert_eq!((count.exceeded, count.failed_to_run), (1, 1));
    let none = Count::of(&[f64::NAN; 128], 0.1).share(&Criterion::default());
    assert_eq!((none.lower, none.upper), (0.0, 1.0));
}

#[test]
fn verif_there_are_at_most_four_looks() {
    assert_eq!(looks(10_000), [128, 512, 2048, 10_000]);
    assert_eq!(looks(1_000_000), [128, 512, 2048, 1_000_000]);
    assert_eq!(looks(2048), [128, 512, 2048]);
    assert_eq!(looks(600), [128, 512, 600]);
    assert_eq!(looks(128), [128]);
    assert_eq!(looks(7), [7]);
    assert!(looks(0).is_empty());
}

// ---------------------------------------------------------------- members

pub(super) fn with_tolerances(tolerances: &[(&str, f64)]) -> Design {
    let mut design = Design::reference();
    design.tolerance = tolerances
        .iter()
        .map(|(key, deviation)| ((*key).to_string(), Tolerance::Deviation(*deviation)))
        .collect();
    design
}

/// Returns a number of a member by its key.
fn value(member: &Member, key: &str) -> f64 {
    match key {
        "moment_of_inertia_kg_m2" => member.lever.moment_of_inertia_kg_m2,
        "pivot_damping_nm_s_per_rad" => member.lever.pivot_damping_nm_s_per_rad,
        "spring_stiffness_nm_per_rad" => member.lever.spring_stiffness_nm_per_rad,
        "preload_torque_nm" => member.lever.preload_torque_nm,
        "mass_kg" => member.lever.mass_kg,
        "center_of_mass_m" => member.lever.center_of_mass_m,
        "restitution" => member.stop.restitution,
        "stiffness_n_per_m" => member.stop.stiffness_n_per_m,
        "damping_n_s_per_m" => member.stop.damping_n_s_per_m,
        "radius_m" => member.stop.radius_m,
        "scale" => member.scale,
        "bias" => member.bias_m_s2,
        _ => panic!("{key}"),
    }
}

const KEYS: [&str; 10] = [
    "moment_of_inertia_kg_m2",
    "pivot_damping_nm_s_per_rad",
    "spring_stiffness_nm_per_rad",
    "preload_torque_nm",
    "mass_kg",
    "center_of_mass_m",
    "restitution",
    "stiffness_n_per_m",
    "damping_n_s_per_m",
    "radius_m",
];

/// Each key scatters its own number, by its own deviation, and no other's draws.
#[test]
fn verif_each_tolerance_scatters_its_own_number() {
    let bare = Scatter::new(&with_tolerances(&[]), 0.0, 5).unwrap();
    let nominal = bare.member(0);
    for key in KEYS {
        let deviation = 0.01 * value(&nominal, key);
        let design = with_tolerances(&[(key, deviation)]);
        let scatter = Scatter::new(&design, 0.0, 5).unwrap();
        assert_eq!(scatter.member(0), nominal, "{key}: member 0 is nominal");
        let (mut sum, mut square) = (0.0, 0.0);
        for index in 1..=4000 {
            let (member, other) = (scatter.member(index), bare.member(index));
            for second in KEYS {
                let follows = key == "restitution" && second == "damping_n_s_per_m";
                if second == key {
                    let moved = (value(&member, key) - value(&nominal, key)) / deviation;
                    assert!(moved.abs() <= 3.0 + 1e-9, "{key}: {moved}");
                    sum += moved;
                    square += moved * moved;
                } else if !follows {
                    assert_eq!(value(&member, second), value(&nominal, second), "{key}");
                }
            }
            assert_eq!(member.scale, other.scale);
            assert_eq!(member.bias_m_s2, other.bias_m_s2);
        }
        assert!((sum / 4000.0).abs() < 0.07, "{key}");
        assert!((square / 4000.0 - 0.973).abs() < 0.09, "{key}: {square}");
    }
}

/// Scale and bias: the larger of the design's bias and the measured error, in m/s².
#[test]
fn verif_scale_and_bias_of_the_input() {
    for (error_m_s2, expected) in [(0.0, 0.1 * G), (0.5, 0.1 * G), (2.0, 2.0)] {
        let scatter = Scatter::new(&Design::reference(), error_m_s2, 1).unwrap();
        let (mut scale, mut bias) = (0.0, 0.0);
        for index in 1..=4000 {
            let member = scatter.member(index);
            scale += (member.scale - 1.0) * (member.scale - 1.0);
            bias += member.bias_m_s2 * member.bias_m_s2;
        }
        let deviation = |sum: f64| (sum / 4000.0 / 0.973_337).sqrt();
        check_close("scale", deviation(scale), 0.01, 0.04);
        check_close("bias", deviation(bias), expected, 0.04);
        let bias = scatter
            .parameters()
            .iter()
            .find(|parameter| parameter.name == "input.bias_g")
            .unwrap();
        check_close("deviation", bias.deviation, expected / G, 1e-12);
    }
}

/// The soft stop's damping moves with the restitution through ξ(R), whatever a design says of
/// both, and R stays within 0 and 1.
#[test]
fn verif_damping_follows_the_restitution() {
    let ratio = |restitution: f64| damping_ratio(Restitution::from_ratio(restitution).unwrap());
    for (restitution, damping) in [(0.8, 133.59), (0.8, 0.0), (0.5, 20.0), (0.99, 5.0)] {
        let mut design = with_tolerances(&[("restitution", 0.02)]);
        design.stop.restitution = restitution;
        design.stop.damping_n_s_per_m = damping;
        let scatter = Scatter::new(&design, 0.0, 3).unwrap();
        for index in 0..2000 {
            let stop = scatter.member(index).stop;
            assert!((0.0..=1.0).contains(&stop.restitution));
            let expected = damping * ratio(stop.restitution) / ratio(restitution);
            check_close("damping", stop.damping_n_s_per_m, expected, 1e-12);
        }
    }
    // From a stop that loses nothing: what ξ(R) adds to it.
    let mut design = with_tolerances(&[("restitution", 0.02)]);
    design.stop.restitution = 1.0;
    design.stop.damping_n_s_per_m = 0.0;
    let scatter = Scatter::new(&design, 0.0, 3).unwrap();
    let mut lossy = 0;
    for index in 0..200 {
        let mut moved = design.clone();
        moved.stop = scatter.member(index).stop;
        let expected = ratio(moved.stop.restitution);
        let pivot = design.lever.pivot_damping_nm_s_per_rad;
        let own = moved.stop.damping_n_s_per_m * moved.stop.radius_m * moved.stop.radius_m;
        check_close(
            "ξ",
            moved.contact_damping_ratio() * own / (own + pivot),
            expected,
            1e-12,
        );
        lossy += u32::from(expected > 0.0);
    }
    assert!((60..140).contains(&lossy), "{lossy}");
}

#[track_caller]
fn check_refused(key: &str, value: f64) {
    let mut design = Design::reference();
    design.override_number(key, value).unwrap();
    let error = ensemble::check(&design).unwrap_err().to_string();
    assert!(
        error.contains(key) && error.contains("`members` = 0"),
        "{error}"
    );
    assert!(Scatter::new(&design, 0.0, 1).is_err());
}

/// Draws reach three deviations: what must be positive has to stay so.
#[test]
fn verif_tolerances_that_leave_what_is_physical_are_refused() {
    let design = Design::reference();
    let nominal = Scatter::new(&design, 0.0, 1).unwrap().member(0);
    for key in KEYS {
        if key == "restitution" {
            continue;
        }
        let value = value(&nominal, key);
        let mut good = design.clone();
        good.override_number(&format!("tolerance.{key}"), 0.333 * value)
            .unwrap();
        assert!(ensemble::check(&good).is_ok(), "{key}");
        check_refused(&format!("tolerance.{key}"), 0.334 * value);
    }
    check_refused("input.scale", 0.334);
    check_refused("input.scale", 1.0 / 3.0);
    let mut wide = design.clone();
    wide.override_number("tolerance.restitution", 5.0).unwrap();
    let scatter = Scatter::new(&wide, 0.0, 1).unwrap();
    assert!((0..500).all(|index| (0.0..=1.0).contains(&scatter.member(index).stop.restitution)));
    // What may vanish may be a third of itself, and no draw is less than nothing.
    let mut third = design;
    third.tolerance = [(
        "preload_torque_nm".to_string(),
        Tolerance::Deviation(0.1 / 3.0),
    )]
    .into();
    let scatter = Scatter::new(&third, 0.0, 1).unwrap();
    assert!((0..20_000).all(|index| scatter.member(index).lever.preload_torque_nm >= 0.0));
}

// ---------------------------------------------------------------- shares that a design states

/// The members of which none may open, against the closed form 1 − (1 − share)ᵐ ≥ confidence of a look.
#[test]
fn val_members_that_a_share_needs() {
    for (share, members) in [(0.05, 86), (0.01, 437), (0.001, 4380)] {
        assert_eq!(members_needed(share, 0.95), members);
        let enough = upper(0, u64::from(members), LOOK_CONFIDENCE);
        let fewer = upper(0, u64::from(members) - 1, LOOK_CONFIDENCE);
        assert!(
            enough <= share && fewer > share,
            "{share}: {enough}, {fewer}"
        );
    }
    assert_eq!(look_confidence(0.95), LOOK_CONFIDENCE);
}

/// Draws of a small share are whole: as many lie beyond three standard deviations as of a normal distribution, 0.27 %,
/// and of a larger share none.
#[test]
fn val_draws_of_a_small_share_are_not_truncated() {
    const DRAWS: u32 = 400_000;
    for (open_share, least, most) in [(0.05, 0, 0), (0.02, 0, 0), (0.0199, 980, 1180)] {
        let mut design = with_tolerances(&[("preload_torque_nm", 0.01)]);
        design.criterion.open_share = open_share;
        let scatter = Scatter::new(&design, 0.0, 3).unwrap();
        let parameter = scatter.parameters().iter().find(|one| one.is_of_lever());
        let beyond = (1..=DRAWS)
            .filter(|member| scatter.draw(*member, parameter.unwrap()).abs() > 3.0)
            .count();
        assert!((least..=most).contains(&beyond), "{open_share}: {beyond}");
    }
}
