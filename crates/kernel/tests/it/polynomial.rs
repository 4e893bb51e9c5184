//! Roots of short polynomials: in order, none missed, none made up.

use latchgate_kernel::numerics::polynomial::{
    CAPACITY, evaluate, evaluate_with_derivative, first_fall, sign_changes,
};
use latchgate_test_support::Random;

/// Coefficients of scale · Π (x − root).
fn from_roots(scale: f64, roots: &[f64]) -> Vec<f64> {
    let mut p = vec![scale];
    for root in roots {
        let mut next = vec![0.0; p.len() + 1];
        for (k, c) in p.iter().enumerate() {
            next[k + 1] += c;
            next[k] -= root * c;
        }
        p = next;
    }
    p
}

fn found(p: &[f64], end: f64) -> Vec<(f64, bool)> {
    let mut list = vec![];
    sign_changes(p, end, &mut |x, rises| {
        list.push((x, rises));
        true
    });
    list
}

#[track_caller]
fn check_roots(p: &[f64], end: f64, roots: &[f64], tolerance: f64) {
    let list = found(p, end);
    assert_eq!(list.len(), roots.len(), "{list:?} of {roots:?}");
    for ((x, _), root) in list.iter().zip(roots) {
        assert!((x - root).abs() <= tolerance, "{list:?} of {roots:?}");
    }
    for pair in list.windows(2) {
        assert!(pair[0].0 < pair[1].0 && pair[0].1 != pair[1].1, "{list:?}");
    }
    let falls = list.iter().find(|(_, rises)| !rises).map(|(x, _)| *x);
    assert_eq!(first_fall(p, end), falls);
}

#[test]
fn val_simple_roots() {
    check_roots(&from_roots(1.0, &[0.25]), 1.0, &[0.25], 2e-16);
    check_roots(&from_roots(-3.0, &[0.25, 0.75]), 1.0, &[0.25, 0.75], 1e-15);
    check_roots(&from_roots(1.0, &[-0.5, 0.3, 1.5]), 1.0, &[0.3], 1e-15);
    check_roots(&from_roots(1.0, &[-1.0, 2.0]), 1.0, &[], 0.0);
    check_roots(&[1.0, 0.0, 1.0], 1.0, &[], 0.0);
    check_roots(&[], 1.0, &[], 0.0);
    check_roots(&[5.0], 1.0, &[], 0.0);
    check_roots(&[0.0, 0.0, 0.0], 1.0, &[], 0.0);
}

/// The joints of the halvings are no special places.
#[test]
fn val_roots_on_the_joints_of_the_halvings() {
    for root in [0.5, 0.25, 0.125, 0.75, 0.375] {
        check_roots(&from_roots(1.0, &[root, -2.0]), 1.0, &[root], 1e-15);
        check_roots(
            &from_roots(1.0, &[root, 0.9, 0.95]),
            1.0,
            &[root, 0.9, 0.95],
            1e-12,
        );
        // Touched from above: no change of sign.
        check_roots(&from_roots(1.0, &[root, root]), 1.0, &[], 0.0);
        // A triple root is one change of sign.
        check_roots(&from_roots(1.0, &[root, root, root]), 1.0, &[root], 1e-4);
    }
}

/// Two roots as close as a graze's: both found, in order.
#[test]
fn val_close_pairs_are_two_roots() {
    for distance in [1e-2, 1e-4, 1e-6] {
        let (a, b) = (0.3, 0.3 + distance);
        let list = found(&from_roots(1.0, &[a, b]), 1.0);
        assert_eq!(list.len(), 2, "{distance}: {list:?}");
        assert!(!list[0].1 && list[1].1);
        assert!((list[0].0 - a).abs() < 1e-15 / distance);
        assert!((list[1].0 - b).abs() < 1e-15 / distance);
    }
}

#[test]
fn val_roots_at_the_ends_belong_to_the_neighbours() {
    check_roots(&from_roots(1.0, &[0.0, 0.5]), 1.0, &[0.5], 1e-15);
    check_roots(&from_roots(1.0, &[1.0, 0.5]), 1.0, &[0.5], 1e-15);
    check_roots(&from_roots(1.0, &[0.0, 1.0]), 1.0, &[], 0.0);
}

/// Well-separated roots of random polynomials, up to the capacity.
#[test]
fn prop_random_roots_are_found() {
    for seed in 0..3000 {
        let mut random = Random(seed);
        let inside = random.below(5);
        let mut roots: Vec<f64> = vec![];
        while roots.len() < inside {
            let root = random.between(0.02, 0.98);
            if roots.iter().all(|r| (r - root).abs() > 0.05) {
                roots.push(root);
            }
        }
        roots.sort_by(f64::total_cmp);
        let mut all = roots.clone();
        for _ in 0..random.below(4) {
            all.push(if random.one_in(2) {
                random.between(-3.0, -0.2)
            } else {
                random.between(1.2, 4.0)
            });
        }
        let p = from_roots(random.between(-2.0, 2.0), &all);
        check_roots(&p, 1.0, &roots, 1e-11);
    }
}

/// A stretched interval only stretches the places.
#[test]
fn verif_the_interval_may_have_any_length() {
    for end in [1e-9, 0.1, 7.0, 1e6] {
        let p = from_roots(1.0, &[0.2 * end, 0.7 * end]);
        let list = found(&p, end);
        assert_eq!(list.len(), 2);
        assert!((list[0].0 / end - 0.2).abs() < 1e-14);
        assert!((list[1].0 / end - 0.7).abs() < 1e-14);
    }
}

/// Whatever the coefficients: the visits are in order, alternate, and end.
#[test]
fn prop_any_coefficients_end_in_order() {
    for seed in 0..3000 {
        let mut random = Random(seed);
        let count = 2 + random.below(CAPACITY - 1);
        let p: Vec<f64> = (0..count)
            .map(|_| match random.below(5) {
                0 => 0.0,
                1 => random.between(-1.0, 1.0),
                2 => random.scale(1e-300, 1e-200),
                3 => -random.scale(1e-20, 1e20),
                _ => random.scale(1e-20, 1e20),
            })
            .collect();
        let list = found(&p, 1.0);
        assert!(list.len() < count, "seed {seed}");
        for pair in list.windows(2) {
            assert!(pair[0].0 <= pair[1].0, "seed {seed}: {list:?}");
        }
        for (x, _) in list {
            assert!((0.0..=1.0).contains(&x), "seed {seed}");
        }
    }
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(found(&[1.0, bad, -3.0, 1.0], 1.0), []);
        assert_eq!(found(&[-1.0, bad], 1.0), []);
        assert_eq!(found(&[bad; CAPACITY], 1.0), []);
    }
}

/// A parabola that ends above zero by little more than its rounding, and a tail that takes as much: the
/// value at the end is -4.4e-16 in exact numbers.
#[test]
fn regress_a_tail_that_turns_a_parabola_is_seen() {
    let p = [
        261.013_470_251_503_4,
        -107.364_888_770_673_5,
        -52.423_177_359_271_78,
        -1.488_958_652_983_620_4e-6,
    ];
    let list = found(&p, 1.431_093_906_370_850_8);
    assert!(matches!(list[..], [(_, false)]), "{list:?}");
}

#[test]
fn verif_value_and_derivative_agree() {
    let p = [3.0, -2.0, 0.5, 0.25];
    for x in [0.0, 0.5, 1.0, -2.0] {
        let (value, derivative) = evaluate_with_derivative(&p, x);
        assert_eq!(value, evaluate(&p, x));
        assert_eq!(derivative, -2.0 + x + 0.75 * x * x);
    }
}
