//! Guards part 3 of the rule as a function of numbers, branch by branch:
//!
//! | nominal run | p | answer |
//! | --- | --- | --- |
//! | peak + U and coast + error at most the limit | upper bound at most 5 % | pass |
//! | the same | upper bound above 5 % | undecided |
//! | the same | lower bound at least 95 % | fail |
//! | coast + error beyond the limit | upper bound at most 5 % | undecided |
//! | peak + U beyond, peak − U not | lower bound below 95 % | undecided |
//! | peak + U beyond, peak − U not | lower bound at least 95 % | fail |
//! | peak − U beyond the limit | lower bound above 50 % | fail |
//! | peak − U beyond the limit | lower bound at most 50 % | undecided |
//! | not followed | lower bound below 95 % | undecided |
//! | not followed | lower bound at least 95 % | fail |
//!
//! and the same without an ensemble. Parts 1, 2 and 4 are guarded end to end beside this file.

use super::{explicit, samples};
use crate::support::weak;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::units::OpensWhen;
use latchgate_verdict::Answer::{self, Fail, Pass, Undecided};
use latchgate_verdict::decision::{PeakEstimate, ShareBounds, VariantRun, decide};

const LIMIT: f64 = 0.1;

fn standing(peak: f64, uncertainty: f64) -> PeakEstimate {
    PeakEstimate {
        peak_angle_rad: peak,
        uncertainty_rad: uncertainty,
        coast_at_most_rad: None,
        followed: true,
        bounded: true,
        opening_draws: 0,
    }
}

#[track_caller]
fn check(standing: PeakEstimate, share: Option<(f64, f64)>, expected: Answer) {
    let share = share.map(|(lower, upper)| ShareBounds {
        lower,
        upper,
        upper_with_coast: upper,
        allowed: 0.05,
    });
    assert_eq!(
        decide(&standing, LIMIT, share),
        expected,
        "{standing:?} {share:?}"
    );
}

#[test]
fn verif_every_branch_with_an_ensemble() {
    let above = |x: f64| x.next_up();
    let below = |x: f64| x.next_down();
    let low = standing(0.05, 0.01);
    check(low, Some((0.0, 0.03)), Pass);
    check(low, Some((0.0, 0.05)), Pass);
    check(low, Some((0.0, above(0.05))), Undecided);
    check(low, Some((0.6, 0.9)), Undecided);
    check(low, Some((below(0.95), 1.0)), Undecided);
    check(low, Some((0.95, 1.0)), Fail);

    // Levers that exceed the threshold in the coast alone hold back a pass, and make no fail.
    let coasts = |upper_with_coast| ShareBounds {
        lower: 0.0,
        upper: 0.03,
        upper_with_coast,
        allowed: 0.05,
    };
    assert_eq!(decide(&low, LIMIT, Some(coasts(0.05))), Pass);
    assert_eq!(decide(&low, LIMIT, Some(coasts(above(0.05)))), Undecided);
    assert_eq!(decide(&low, LIMIT, Some(coasts(1.0))), Undecided);

    // U counts: at the limit a pass, beyond it none.
    check(standing(0.0625, 0.0375), Some((0.0, 0.03)), Pass);
    check(standing(0.0625, 0.037_501), Some((0.0, 0.03)), Undecided);
    check(standing(0.125, 0.025_001), Some((0.6, 0.9)), Undecided);
    check(standing(0.125, 0.024_999), Some((0.6, 0.9)), Fail);

    let spans = standing(0.1, 0.02);
    check(spans, Some((0.0, 0.01)), Undecided);
    check(spans, Some((0.6, 0.94)), Undecided);
    check(spans, Some((0.95, 0.99)), Fail);

    let high = standing(0.3, 0.01);
    check(high, Some((0.0, 0.01)), Undecided);
    check(high, Some((0.4, 0.6)), Undecided);
    check(high, Some((0.5, 0.6)), Undecided);
    check(high, Some((above(0.5), 0.6)), Fail);
    check(high, Some((0.96, 1.0)), Fail);
}

#[test]
fn verif_a_coast_holds_back_a_pass_only() {
    let coasting = |peak: f64, coast: f64, error: f64| PeakEstimate {
        coast_at_most_rad: Some(coast + error),
        ..standing(peak, 0.001)
    };
    for share in [None, Some((0.0, 0.04))] {
        check(coasting(0.05, 0.0625, 0.0375), share, Pass);
        check(coasting(0.05, 0.0625, 0.0376), share, Undecided);
        check(coasting(0.05, 0.2, 0.001), share, Undecided);
    }
    check(coasting(0.05, 0.2, 0.001), Some((0.96, 1.0)), Fail);
    check(coasting(0.2, 0.05, 0.001), Some((0.6, 0.7)), Fail);
    check(coasting(0.2, 0.05, 0.001), None, Fail);
}

/// Errors of a run [rad].
#[derive(Debug, Clone, Copy)]
struct Errors {
    numerical: f64,
    coast: f64,
    interpolation: f64,
    noise: f64,
}

/// Checks that a run whose coast rises to twice its peak passes at the coast's peak + error, and not a bit below.
#[track_caller]
fn check_coast_bound(errors: Errors, share: Option<ShareBounds>) {
    let coast_rad = 0.0625;
    let mut outcome = explicit(&samples(weak), StopModel::Rigid, OpensWhen::Negative);
    outcome.run.peak_angle_rad = 0.5 * coast_rad;
    outcome.run.numerical_error_rad = errors.numerical;
    outcome.run.coast_peak_angle_rad = Some(coast_rad);
    outcome.coast_error_rad = errors.coast;
    let judged = VariantRun {
        outcome,
        interpolation_error_rad: errors.interpolation,
        noise_rad: errors.noise,
        noise_draws: None,
        share,
        bound: None,
    };
    let numerical_rad = errors.numerical.max(errors.coast);
    let error_rad = numerical_rad + errors.interpolation + 2.0 * errors.noise;
    let bound_rad = coast_rad + error_rad;
    let case = format!("{errors:?}, {share:?}");
    let stated = judged.stated(bound_rad).coast_uncertainty_rad;
    assert_eq!(stated, Some(error_rad), "{case}");
    assert_eq!(judged.answer(bound_rad), Pass, "{case}");
    for limit_rad in [bound_rad.next_down(), bound_rad - 1e-12] {
        assert_eq!(judged.answer(limit_rad), Undecided, "{case}");
        assert!(judged.held_back_by_coast(limit_rad), "{case}");
    }
}

/// What a pass must leave room for above the coast's peak: the larger of its own numerical error and of the
/// window's, the interpolation error and twice the noise. Each is a power of two or nothing, so that the sums are
/// exact.
#[test]
fn verif_each_part_of_the_coasts_error_counts() {
    const SIZES_RAD: [f64; 3] = [0.0, 1.0 / 256.0, 1.0 / 64.0];
    let few_cross = ShareBounds {
        lower: 0.0,
        upper: 0.03,
        upper_with_coast: 0.03,
        allowed: 0.05,
    };
    // Each part takes each size, whatever the others are.
    for number in 0..81 {
        let size = |place: u32| SIZES_RAD[number / 3_usize.pow(place) % 3];
        let errors = Errors {
            numerical: size(0),
            coast: size(1),
            interpolation: size(2),
            noise: size(3),
        };
        check_coast_bound(errors, None);
        check_coast_bound(errors, Some(few_cross));
    }
}

#[test]
fn verif_every_branch_without_an_ensemble() {
    check(standing(0.05, 0.01), None, Pass);
    check(standing(0.0625, 0.0375), None, Pass);
    check(standing(0.0625, 0.0376), None, Undecided);
    check(standing(0.125, 0.0251), None, Undecided);
    check(standing(0.125, 0.0249), None, Fail);
}

/// What was not followed decides nothing; members that were do, where nearly all cross.
#[test]
fn verif_a_nominal_run_that_was_not_followed() {
    for peak in [0.0, 0.2, f64::MAX] {
        let lost = PeakEstimate {
            followed: false,
            ..standing(peak, 0.0)
        };
        check(lost, None, Undecided);
        check(lost, Some((0.0, 0.01)), Undecided);
        check(lost, Some((0.6, 0.9)), Undecided);
        check(lost, Some((0.95, 1.0)), Fail);
    }
    check(standing(0.05, f64::INFINITY), Some((0.0, 0.01)), Undecided);
    check(standing(0.2, f64::INFINITY), Some((0.6, 0.9)), Undecided);
}
