//! Columns that count the rows: where no stamp tells the time, they alone show a missing row.

use crate::recording::Finding;

/// First steps whose median is taken for the usual one.
const FIRST: usize = 4096;

/// Share of like steps from which on a column counts, whatever its name [-].
const COUNTS: f64 = 0.9;

/// Share of the usual step by which a like one may be off [-].
const OFF: f64 = 0.5;

/// What is wrong with a count.
#[derive(Debug, PartialEq)]
pub(super) struct CounterFault {
    /// The row before the first fault, counted from 0, and the two counts there.
    pub(super) row: usize,
    pub(super) counts: (f64, f64),
    /// Faults in all.
    pub(super) faults: usize,
    pub(super) usual: f64,
}

/// Returns the usual step of a column that counts and the first place at which it does not;
/// `None` if it counts nothing. `named` is whether its name says that it is a running number.
pub(super) fn judge(counts: &[f64], named: bool) -> Option<(f64, Option<CounterFault>)> {
    if counts.len() < 3
        || counts
            .iter()
            .all(|count| count.total_cmp(&counts[0]).is_eq())
    {
        return None;
    }
    let mut first: Vec<f64> = counts
        .windows(2)
        .take(FIRST)
        .map(|pair| pair[1] - pair[0])
        .collect();
    let middle = first.len() / 2;
    let usual = *first.select_nth_unstable_by(middle, f64::total_cmp).1;
    let off = |pair: &[f64]| {
        let step = pair[1] - pair[0];
        let alike = (step - usual).abs() <= OFF * usual.abs();
        usual <= 0.0 || !(alike || wraps(pair[0], pair[1]))
    };
    let faults = counts.windows(2).filter(|pair| off(pair)).count();
    let alike = counts
        .windows(2)
        .filter(|pair| (pair[1] - pair[0] - usual).abs() <= OFF * usual.abs())
        .count();
    let share = alike as f64 / (counts.len() - 1) as f64;
    let whole = || counts.iter().all(|count| count.fract().abs() <= 0.0);
    // A name such as `i` may be that of a current.
    let counting = if named && whole() {
        true
    } else {
        share >= COUNTS && usual.abs() > 0.0
    };
    if !counting {
        return None;
    }
    let fault = counts.windows(2).position(off).map(|row| CounterFault {
        row,
        counts: (counts[row], counts[row + 1]),
        faults,
        usual,
    });
    Some((usual, fault))
}

/// Tells whether a counter of 8, 16 or 32 bits begins anew.
fn wraps(before: f64, after: f64) -> bool {
    after.abs() <= 0.0
        && [255.0, 65_535.0, 4_294_967_295.0]
            .iter()
            .any(|most| (before - most).abs() <= 0.0)
}

/// Returns the finding for a faulty count of the column `name`, on `line`, at `at_s` [s];
/// `stamped` is whether stamps tell the time.
pub(super) fn finding(
    name: &str,
    fault: &CounterFault,
    line: Option<u64>,
    at_s: Option<f64>,
    stamped: bool,
) -> Finding {
    let (before, after) = fault.counts;
    let place = line.map_or(String::new(), |line| format!(" (line {line})"));
    let more = match fault.faults {
        0 | 1 => String::new(),
        faults => format!("; so it does at {faults} places"),
    };
    let text = format!(
        "`{name}` goes from {before} to {after}{place}, where its usual step is {}{more}; rows are missing, doubled or out of order",
        fault.usual
    );
    let finding = if stamped {
        Finding::warning("index-gap", format!("{text}, or the stamps were made anew"))
    } else {
        Finding::blocking("index-gap", format!("{text}, and no column tells the time"))
    };
    Finding { at_s, ..finding }
}

#[cfg(test)]
mod tests {
    use super::judge;

    #[track_caller]
    fn check(counts: &[f64], named: bool, expected: Option<(f64, Option<usize>)>) {
        let found = judge(counts, named).map(|(usual, fault)| (usual, fault.map(|f| f.row)));
        assert_eq!(found, expected, "{counts:?}");
    }

    #[test]
    fn verif_counts_that_skip_repeat_or_run_back_are_told() {
        check(&[0.0, 1.0, 2.0, 3.0], true, Some((1.0, None)));
        check(&[0.0, 2.0, 4.0, 6.0], true, Some((2.0, None)));
        check(&[0.0, 1.0, 2.0, 4.0, 5.0], true, Some((1.0, Some(2))));
        check(&[0.0, 1.0, 1.0, 2.0, 3.0], true, Some((1.0, Some(1))));
        check(&[0.0, 1.0, 2.0, 0.0, 1.0], true, Some((1.0, Some(2))));
        check(&[3.0, 2.0, 1.0, 0.0], true, Some((-1.0, Some(0))));
        check(&[0.0, 0.0, 0.0, 1.0], true, Some((0.0, Some(0))));
        check(&[254.0, 255.0, 0.0, 1.0], true, Some((1.0, None)));
        // The number of a test, a current, and a channel without a name that says what it is.
        check(&[7.0, 7.0, 7.0, 7.0], true, None);
        check(&[0.5, 0.25, 0.75, 0.25, 0.5], true, None);
        check(&[0.0, 1.0, 5.0, 3.0, 9.0], false, None);
        // A clock that nothing calls one.
        let mut ticks: Vec<f64> = (0..40).map(|k| 100.0 * f64::from(k)).collect();
        check(&ticks, false, Some((100.0, None)));
        ticks.remove(20);
        check(&ticks, false, Some((100.0, Some(19))));
    }
}
