//! The summary for a terminal.

use super::pairs::{Pair, PairStanding};
use super::summary::GateSummary;
use crate::pipeline::{Answer, DecisionRow};
use latchgate_document::number;
use latchgate_report::angle::KnownPeak;
use latchgate_report::{UNSEEN, escape, full_design};
use latchgate_verdict::wording::percent_bound;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Largest number of lines of pairs and of problems: one screen.
const LISTED: usize = 20;

/// Largest number of characters of a pair's description.
const TEXT_MAX: usize = 800;

/// Returns the summary: the answer, then problems and pairs, the worst first, then the counts.
pub fn render(summary: &GateSummary, folder: Option<&str>) -> String {
    let mut out = String::new();
    let counts = &summary.counts;
    let whose = if summary.is_part() {
        "CHOSEN PAIRS"
    } else {
        "GATE"
    };
    let not = if summary.exit_code == 0 { "" } else { "NOT " };
    let _ = writeln!(out, "{whose} {not}PASSED  {}", headline(summary));
    for problem in summary.problems.iter().take(LISTED) {
        let _ = writeln!(
            out,
            "  {:<10} {}",
            "problem",
            escape::terminal(&problem.text)
        );
    }
    further(
        &mut out,
        summary.problems.len().saturating_sub(LISTED),
        "problem",
    );
    for standing in summary.statics.iter().filter(|standing| !standing.holds) {
        let _ = writeln!(
            out,
            "  {:<10} {}",
            "static",
            escape::terminal(&standing.text())
        );
    }
    lines(&mut out, summary, &summary.worst(), LISTED);
    // Every exception is listed: a pair that is let through must not hide behind a count.
    let allowed = summary.with_standing(PairStanding::Allowed);
    lines(&mut out, summary, &allowed, usize::MAX);
    if let Some(baseline) = &summary.baseline {
        let _ = writeln!(
            out,
            "  {:<10} {} newly failing, {} fixed, {} moved, {} added, {} gone",
            "baseline",
            baseline.newly_failing.len(),
            baseline.fixed.len(),
            counted(baseline.moved.len(), "margin"),
            baseline.added.len(),
            baseline.removed.len()
        );
        if baseline.numbers_revision != summary.numbers_revision {
            let _ = writeln!(
                out,
                "  {:<10} its numbers are of revision {}, these of {}: margins may have moved with the program",
                "", baseline.numbers_revision, summary.numbers_revision
            );
        }
    }
    let _ = writeln!(
        out,
        "  {:<10} pass {}, fail {}, undecided {}, unusable {}",
        "answers", counts.pass, counts.fail, counts.undecided, counts.unusable
    );
    for standing in summary.statics.iter().filter(|standing| standing.holds) {
        let _ = writeln!(
            out,
            "  {:<10} {}",
            "static",
            escape::terminal(&standing.text())
        );
    }
    for design in repeated_designs(summary) {
        let _ = writeln!(out, "  {:<10} {}", "designs", escape::terminal(&design));
    }
    if counts.pass > 0 {
        let _ = writeln!(out, "  {:<10} {UNSEEN}", "not seen");
    }
    if let Some(folder) = folder {
        let _ = writeln!(out, "  {:<10} {}", "report", escape::terminal(folder));
    }
    out
}

/// Names the designs that repeat every value of the paper's lever under another name: the first few,
/// and the number of the others.
pub(super) fn repeated_designs(summary: &GateSummary) -> Vec<String> {
    let designs = summary.designs.iter();
    let repeated: Vec<String> = designs
        .filter(|design| design.repeats_reference())
        .map(full_design)
        .collect();
    let further = repeated.len().saturating_sub(DESIGNS_NAMED);
    let more = (further > 0).then(|| counted(further, "further such design"));
    let named = repeated.into_iter().take(DESIGNS_NAMED);
    named.chain(more).collect()
}

/// Returns a count with its noun, `what` being the noun for one.
pub fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

fn further(out: &mut String, count: usize, what: &str) {
    if count > 0 {
        let further = counted(count, &format!("further {what}"));
        let _ = writeln!(out, "  {:<10} {further}", "");
    }
}

/// Writes the pairs of these numbers, at most `lines_max` lines of them, and the number of the others.
fn lines(out: &mut String, summary: &GateSummary, numbers: &[usize], lines_max: usize) {
    let mut shown = 0;
    for group in grouped(&summary.pairs, numbers).iter().take(lines_max) {
        let pair = group.worst;
        let mut description = group.description(summary);
        if let Some((cut, _)) = description.char_indices().nth(TEXT_MAX) {
            description.truncate(cut);
            description.push('…');
        }
        let designs = group.designs(summary);
        let text = format!("{} with {designs}: {description}", pair.recording);
        let _ = writeln!(
            out,
            "  {:<10} {}",
            pair.row.verdict.name(),
            escape::terminal(&text)
        );
        shown += group.numbers.len();
    }
    further(out, numbers.len() - shown, "pair");
}

/// Pairs of one recording with the same answer and the same exception.
pub(super) struct PairGroup<'a> {
    /// The worst pair.
    pub(super) worst: &'a Pair,
    pub(super) numbers: Vec<usize>,
}

/// Groups the pairs of these numbers, which begin with the worst.
pub(super) fn grouped<'a>(pairs: &'a [Pair], numbers: &[usize]) -> Vec<PairGroup<'a>> {
    let mut groups: Vec<PairGroup<'_>> = Vec::new();
    let mut places = BTreeMap::new();
    for &number in numbers {
        let pair = &pairs[number];
        let kind = (&pair.recording, pair.row.verdict.name(), &pair.exception);
        let place = *places.entry(kind).or_insert(groups.len());
        match groups.get_mut(place) {
            Some(group) => group.numbers.push(number),
            None => groups.push(PairGroup {
                worst: pair,
                numbers: vec![number],
            }),
        }
    }
    groups
}

/// Number of designs that are named of a group.
const DESIGNS_NAMED: usize = 3;

impl PairGroup<'_> {
    /// Returns the names of the designs.
    pub(super) fn designs(&self, summary: &GateSummary) -> String {
        let count = self.numbers.len();
        if count == summary.designs.len() && count > 1 {
            return format!("each of the {count} designs");
        }
        let named = self.numbers.iter().take(DESIGNS_NAMED);
        let named: Vec<&str> = named
            .map(|&number| &*summary.pairs[number].design)
            .collect();
        match count - named.len() {
            0 => named.join(", "),
            further => format!(
                "{} and {}",
                named.join(", "),
                counted(further, "other design")
            ),
        }
    }

    /// Returns the description of the pairs: that of the worst, where they differ.
    pub(super) fn description(&self, summary: &GateSummary) -> String {
        let worst = describe(self.worst);
        let differ = |number: &usize| describe(&summary.pairs[*number]) != worst;
        match self.numbers.iter().any(differ) {
            true => format!("at worst {worst}"),
            false => worst,
        }
    }
}

/// Returns the answer of the gate, in one sentence.
pub(super) fn headline(summary: &GateSummary) -> String {
    let counts = &summary.counts;
    let mut text = match counts.not_as_required {
        0 if counts.pairs == 1 => "the one pair is as required".into(),
        0 => format!("all {} pairs are as required", counts.pairs),
        some => {
            let are = if some == 1 { "is" } else { "are" };
            let pairs = counted(counts.pairs, "pair");
            let answers = [
                Answer::Fail,
                Answer::Pass,
                Answer::Undecided,
                Answer::Unusable,
            ];
            let counted_answers: Vec<String> = answers
                .into_iter()
                .map(|answer| (summary.not_as_required(answer), answer))
                .filter(|(count, _)| *count > 0)
                .map(|(count, answer)| format!("{count} {}", answer.name()))
                .collect();
            let answers = counted_answers.join(", ");
            format!("{some} of {pairs} {are} not as required: {answers}")
        }
    };
    let open = summary
        .statics
        .iter()
        .filter(|standing| !standing.holds)
        .count();
    if open > 0 {
        let verb = if open == 1 { "opens" } else { "open" };
        let _ = write!(
            text,
            "; {} {verb} under the static load",
            counted(open, "design")
        );
    }
    if counts.allowed > 0 {
        let _ = write!(text, ", {} by an exception", counts.allowed);
    }
    if counts.no_worse > 0 {
        let _ = write!(text, ", {} no worse than the baseline", counts.no_worse);
    }
    if !summary.problems.is_empty() {
        let _ = write!(text, "; {}", counted(summary.problems.len(), "problem"));
    }
    if summary.is_part() {
        text.push_str("; not the gate's answer, which needs every pair");
    }
    let _ = write!(text, " (exit {})", summary.exit_code);
    text
}

/// Returns the sign of an answer.
pub(super) fn glyph(verdict: Answer) -> char {
    match verdict {
        Answer::Pass => '✓',
        Answer::Fail => '✗',
        Answer::Undecided => '?',
        Answer::Unusable => '∅',
    }
}

/// Returns a pair's description: peak, requirement, exception and reason.
pub(super) fn describe(pair: &Pair) -> String {
    let required = format!("{} required", pair.required.name());
    let peak = peak(&pair.row).map(|peak| format!("{peak}; "));
    let reason = &pair.row.reason.text;
    let exception = pair
        .exception
        .as_ref()
        .map_or_else(String::new, |(reason, until)| {
            format!("; let through until {until}: {reason}")
        });
    match (peak, pair.row.verdict) {
        // The peak beside its limit is the reason.
        (Some(peak), Answer::Pass | Answer::Fail) => {
            format!("{peak}{}{required}", share(&pair.row).unwrap_or_default())
        }
        (peak, _) => format!(
            "{}{required}{exception}; {reason}",
            peak.unwrap_or_default()
        ),
    }
}

/// Returns the share of varied levers that cross, where the peak alone does not decide.
fn share(row: &DecisionRow) -> Option<String> {
    let share = row.share?;
    let distance = (row.peak_angle_rad? - row.threshold_rad).abs();
    let decides = distance > row.uncertainty_rad?;
    (!decides).then(|| {
        format!(
            "{} to {} % of levers and readings open; ",
            percent_bound(share.low, f64::floor),
            percent_bound(share.high, f64::ceil)
        )
    })
}

/// Returns the peak with its error and the limit.
pub(super) fn peak(row: &DecisionRow) -> Option<String> {
    let opens = row.verdict == Answer::Fail;
    let (error, limit) = (row.uncertainty_rad, row.threshold_rad);
    let peak = KnownPeak::of(row.peak_angle_rad?, error, limit, opens);
    let name = if matches!(peak, KnownPeak::Open(_)) {
        ""
    } else {
        "peak "
    };
    let limit = number::trimmed(limit.to_degrees(), 3);
    let text = format!("{name}{}, limit {limit}°", peak.short());
    Some(text.replace('\u{00A0}', " "))
}
