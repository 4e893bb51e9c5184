//! Columns that count the rows: where no stamp tells the time, they alone show a missing row.

use crate::recording::Finding;

/// First steps whose median is taken for the usual one.
const FIRST: usize = 4096;

/// Share of the usual step by which a like one may be off [-].
const OFF: f64 = 0.5;

/// Counts after which counters of 8, 16 and 32 bits begin anew.
const LAST: [f64; 3] = [255.0, 65_535.0, 4_294_967_295.0];

/// Returns what is odd about a column that counts: where it skips, repeats or runs back, or that it
/// counts by another step than 1. A column counts if it holds whole numbers under a name that says
/// so, or like steps but for one of ten. `named` is whether its name says that it counts, `stamped`
/// whether stamps tell the time; `place` gives line and instant of a row [s].
pub(super) fn finding(
    name: &str,
    counts: &[f64],
    (named, stamped): (bool, bool),
    place: impl Fn(usize) -> (Option<u64>, Option<f64>),
) -> Option<Finding> {
    let steps: Vec<f64> = counts.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.len() < 2 || steps.iter().all(|step| *step == 0.0) {
        return None;
    }
    let mut first = steps[..steps.len().min(FIRST)].to_vec();
    let middle = first.len() / 2;
    let usual = *first.select_nth_unstable_by(middle, f64::total_cmp).1;
    let alike = |step: &&f64| (**step - usual).abs() <= OFF * usual.abs();
    let runs = usual != 0.0 && 10 * steps.iter().filter(alike).count() >= 9 * steps.len();
    // A name such as `i` may be that of a current.
    if !(runs || named && counts.iter().all(|count| count.fract() == 0.0)) {
        return None;
    }
    let wraps = |row: usize| counts[row + 1] == 0.0 && LAST.contains(&counts[row]);
    let off = |row: &usize| usual <= 0.0 || !(alike(&&steps[*row]) || wraps(*row));
    let faults: Vec<usize> = (0..steps.len()).filter(off).collect();
    let Some(row) = faults.first().copied() else {
        let text = format!(
            "`{name}` counts by {usual}; if samples were left out, the stated rate is that many \
             times too high"
        );
        let told = named && !stamped && (usual - 1.0).abs() > 1e-9;
        return told.then(|| Finding::warning("index-step", text));
    };
    let (line, at_s) = place(row);
    let text = format!(
        "`{name}` goes from {} to {}{}, where its usual step is {usual}, at {} places in all; \
         rows are missing, doubled or out of order",
        counts[row],
        counts[row + 1],
        line.map_or(String::new(), |line| format!(" (line {line})")),
        faults.len()
    );
    let finding = match stamped {
        true => Finding::warning("index-gap", format!("{text}, or the stamps were made anew")),
        false => Finding::blocking("index-gap", format!("{text}, and no column tells the time")),
    };
    Some(finding.since(at_s))
}

#[cfg(test)]
mod tests {
    use super::finding;

    #[track_caller]
    fn check(counts: &[f64], named: bool, expected: Option<(&str, Option<u64>)>) {
        let place = |row| (Some(row as u64), None);
        let found = finding("n", counts, (named, false), place);
        let line = |text: &str| text.split_once("line ")?.1.split(')').next()?.parse().ok();
        let found = found.as_ref().map(|one| (&*one.code, line(&one.text)));
        assert_eq!(found, expected, "{counts:?}");
    }

    #[test]
    fn verif_counts_that_skip_repeat_or_run_back_are_told() {
        check(&[0.0, 1.0, 2.0, 3.0], true, None);
        check(&[0.0, 2.0, 4.0, 6.0], true, Some(("index-step", None)));
        check(
            &[0.0, 1.0, 2.0, 4.0, 5.0],
            true,
            Some(("index-gap", Some(2))),
        );
        check(
            &[0.0, 1.0, 1.0, 2.0, 3.0],
            true,
            Some(("index-gap", Some(1))),
        );
        check(
            &[0.0, 1.0, 2.0, 0.0, 1.0],
            true,
            Some(("index-gap", Some(2))),
        );
        check(&[3.0, 2.0, 1.0, 0.0], true, Some(("index-gap", Some(0))));
        check(&[0.0, 0.0, 0.0, 1.0], true, Some(("index-gap", Some(0))));
        check(&[254.0, 255.0, 0.0, 1.0], true, None);
        // The number of a test, a current, and a channel without a name that says what it is.
        check(&[7.0, 7.0, 7.0, 7.0], true, None);
        check(&[0.5, 0.25, 0.75, 0.25, 0.5], true, None);
        check(&[0.0, 1.0, 5.0, 3.0, 9.0], false, None);
        // A clock that nothing calls one.
        let mut ticks: Vec<f64> = (0..40).map(|k| 100.0 * f64::from(k)).collect();
        check(&ticks, false, None);
        ticks.remove(20);
        check(&ticks, false, Some(("index-gap", Some(19))));
    }
}
