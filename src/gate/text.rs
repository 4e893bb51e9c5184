//! The summary for a terminal.

use super::summary::{GateSummary, Pair, PairStanding};
use crate::pipeline::Row;
use crate::report::{escape, number};
use std::fmt::Write as _;

/// Pairs that are listed.
const LISTED: usize = 20;

/// Returns the summary: the answer first, then what is wrong, the worst first, then the counts.
#[must_use]
pub fn render(summary: &GateSummary, folder: Option<&str>) -> String {
    let mut out = String::new();
    let counts = &summary.counts;
    let answer = if summary.exit_code == 0 {
        "GATE PASSED"
    } else {
        "GATE NOT PASSED"
    };
    let _ = writeln!(out, "{answer}  {}", headline(summary));
    for problem in summary.problems.iter().take(LISTED) {
        let _ = writeln!(
            out,
            "  {:<10} {}",
            "problem",
            escape::terminal(&problem.text)
        );
    }
    further(&mut out, summary.problems.len(), "problems");
    let worst = summary.worst();
    for pair in worst.iter().take(LISTED) {
        line(&mut out, pair);
    }
    further(&mut out, worst.len(), "pairs not as required");
    for pair in summary
        .pairs
        .iter()
        .filter(|pair| pair.standing == PairStanding::Allowed)
    {
        line(&mut out, pair);
    }
    if let Some(baseline) = &summary.baseline {
        let _ = writeln!(
            out,
            "  {:<10} {} newly failing, {} fixed, {} peaks moved, {} added, {} gone",
            "baseline",
            baseline.newly_failing.len(),
            baseline.fixed.len(),
            baseline.moved.len(),
            baseline.added.len(),
            baseline.removed.len()
        );
    }
    let _ = writeln!(
        out,
        "  {:<10} pass {}, fail {}, undecided {}, unusable {}",
        "answers", counts.pass, counts.fail, counts.undecided, counts.unusable
    );
    if let Some(folder) = folder {
        let _ = writeln!(out, "  {:<10} {}", "report", escape::terminal(folder));
    }
    out
}

fn further(out: &mut String, all: usize, what: &str) {
    if all > LISTED {
        let _ = writeln!(out, "  {:<10} {} further {what}", "", all - LISTED);
    }
}

/// Returns what became of the gate, in one sentence.
pub(super) fn headline(summary: &GateSummary) -> String {
    let counts = &summary.counts;
    let mut text = match counts.not_as_required {
        0 => format!("all {} pairs stand", counts.pairs),
        some => format!("{some} of {} pairs are not as required", counts.pairs),
    };
    if counts.allowed > 0 {
        let _ = write!(text, ", {} by an exception", counts.allowed);
    }
    if counts.no_worse > 0 {
        let _ = write!(text, ", {} no worse than the baseline", counts.no_worse);
    }
    if !summary.problems.is_empty() {
        let many = if summary.problems.len() == 1 { "" } else { "s" };
        let _ = write!(text, ", {} problem{many}", summary.problems.len());
    }
    let _ = write!(text, " (exit {})", summary.exit_code);
    text
}

fn line(out: &mut String, pair: &Pair) {
    let text = format!("{} with {}: {}", pair.recording, pair.design, what(pair));
    let _ = writeln!(
        out,
        "  {:<10} {}",
        pair.row.verdict.name(),
        escape::terminal(&text)
    );
}

/// Returns what is to be said of a pair beside its names and its answer.
pub(super) fn what(pair: &Pair) -> String {
    let mut text = match peak(&pair.row) {
        Some(peak) => format!("{peak}; {} required", pair.required.name()),
        None => format!("{} required", pair.required.name()),
    };
    match &pair.exception {
        Some((reason, until)) => {
            let _ = write!(text, "; let through until {until}: {reason}");
        }
        None => {
            let _ = write!(text, "; {}", pair.row.reason.text);
        }
    }
    text
}

/// Returns the peak with its error and the limit.
pub(super) fn peak(row: &Row) -> Option<String> {
    let peak = row.peak_angle_rad?;
    let error = row.uncertainty_rad.map_or_else(String::new, |error| {
        format!(" ± {}", number::plain(error, 2))
    });
    Some(format!(
        "peak {}{error} rad, limit {} rad",
        number::plain(peak, 4),
        row.threshold_rad
    ))
}
