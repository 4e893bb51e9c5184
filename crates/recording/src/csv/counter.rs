//! Columns that count the rows: without stamps they alone show a missing row.

use super::clock::{is_fractional, natural_unit};
use crate::Finding;
use crate::time_base::brief;

/// Number of first steps whose median is the usual step.
const FIRST: usize = 4096;

/// Share of the usual step by which a like one may differ [-].
const OFF: f64 = 0.5;

/// Counts after which counters of 8, 16 and 32 bits begin anew.
const LAST: [f64; 3] = [255.0, 65_535.0, 4_294_967_295.0];

/// Returns the finding on a column that counts: it skips, repeats or runs back, or counts by another step
/// than 1. A column counts if it holds whole numbers under a name that says so (`named`), or like steps
/// but for one of ten. `stated_hz` is the rate where no stamps give the time; `place` returns line and
/// instant of a row [s].
pub(super) fn finding(
    name: &str,
    counts: &[f64],
    named: bool,
    stated_hz: Option<f64>,
    place: impl Fn(usize) -> (Option<u64>, Option<f64>),
) -> Option<Finding> {
    let stamped = stated_hz.is_none();
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
        let stated_hz = stated_hz.filter(|_| named && (usual - 1.0).abs() > 1e-9)?;
        let text = match is_fractional(usual) {
            // A clock in another unit, which the rate confirms.
            true if natural_unit(1.0 / (stated_hz * usual), None).is_some() => return None,
            true => format!(
                "`{name}` rises by {} a row, which no count does. In seconds that is {} Hz, but \
                 {stated_hz} Hz is stated. Check the rate",
                brief(usual),
                brief(1.0 / usual)
            ),
            false => format!(
                "`{name}` counts by {} a row. If samples were left out, the stated rate is that \
                 many times too high. Check the rate",
                brief(usual)
            ),
        };
        return Some(Finding::warning("index-step", text));
    };
    let (line, at_s) = place(row);
    let text = format!(
        "`{name}` goes from {} to {}{}, but its usual step is {}; there are {} such places. Rows \
         are missing, doubled or out of order",
        counts[row],
        counts[row + 1],
        line.map_or(String::new(), |line| format!(" (line {line})")),
        brief(usual),
        faults.len()
    );
    let finding = match stamped {
        true => Finding::warning(
            "index-gap",
            format!("{text}, or the stamps were made afterwards. Look at the rows there"),
        ),
        false => Finding::blocking(
            "index-gap",
            format!(
                "{text}, and no column holds the time. Look at the rows there, and export again"
            ),
        ),
    };
    Some(finding.since(at_s))
}
