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

use latchgate_verdict::Answer::{self, Fail, Pass, Undecided};
use latchgate_verdict::decision::{PeakEstimate, ShareBounds, decide};

const LIMIT: f64 = 0.1;

fn standing(peak: f64, uncertainty: f64) -> PeakEstimate {
    PeakEstimate {
        peak_angle_rad: peak,
        uncertainty_rad: uncertainty,
        coast_at_most_rad: None,
        followed: true,
        bounded: true,
    }
}

#[track_caller]
fn check(standing: PeakEstimate, share: Option<(f64, f64)>, expected: Answer) {
    let share = share.map(|(lower, upper)| ShareBounds {
        lower,
        upper,
        upper_with_coast: upper,
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
