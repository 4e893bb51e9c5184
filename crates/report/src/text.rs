//! The verdict for a terminal.

use super::sensor_place::{sensor_place, siblings};
use super::terminal::{self, Look, TerminalLines};
use super::{REPORT_FILE, VERDICT_FILE};
use super::{headline, opening, words};
use latchgate_document::Document;
use latchgate_document::number::plain;
use latchgate_recording::{Finding, Severity};
use latchgate_verdict::Answer;
use latchgate_verdict::sled::SledCheck;
use latchgate_verdict::wording::filter_name;
use std::path::Path;

/// Findings shown without detail.
const FINDINGS: usize = 3;

/// Letters shown of a finding that does not block, without detail.
const LETTERS: usize = 140;

/// Returns the verdict in a few lines: [`answer`] and [`afterwards`].
pub fn render(document: &Document, report: Option<&Path>, look: Look) -> String {
    answer(document, look) + &afterwards(document, report, None, look)
}

/// Returns the part that needs no further work: the verdict and its meaning, what was judged, peak and
/// limit angle, its grounds and the most severe findings. With [`Look::detail`] it says how the answer
/// was decided.
pub fn answer(document: &Document, look: Look) -> String {
    let mut out = TerminalLines::new(look);
    out.headline(document.verdict, &headline::headline(document));
    let recording = &document.recording;
    let channel = recording.channel.as_ref();
    let channel = channel.map_or(String::new(), |channel| format!(", channel {channel}"));
    out.line("recording", &format!("{}{channel}", recording.file));
    let test: Vec<String> = words::test_facts(&document.test)
        .into_iter()
        .map(|(_, value)| value)
        .collect();
    if !test.is_empty() && look.detail {
        out.line("test", &test.join("; "));
    } else if let Some(first) = document.test.test.as_ref().or(test.first()) {
        out.line("test", first);
    }
    out.line("design", &words::with_unstated(&document.design));
    if document.verdict == Answer::Unusable {
        if let Some(text) = words::before_fault(document) {
            out.line("before", text);
        }
    } else {
        judged(&mut out, document);
    }
    findings(&mut out, document, look.detail);
    if look.detail {
        detail(&mut out, document);
    }
    out.into_string()
}

/// Returns the part that takes longer than the verdict: the advice, the paths of the report in `report` and of
/// its `pdf`, if they were written, and how to verify it.
pub fn afterwards(
    document: &Document,
    report: Option<&Path>,
    pdf: Option<&Path>,
    look: Look,
) -> String {
    let mut out = TerminalLines::new(look);
    if let Some(preload) = words::preload(document) {
        let text = format!("{preload}.");
        if words::is_isolated_pass(document) {
            out.graded("advice", Severity::Warning, &text);
        } else {
            out.line("advice", &text);
        }
    } else if document.verdict != Answer::Unusable {
        out.line(
            "advice",
            "latchgate margin searches for the preloads that pass",
        );
    }
    for (index, text) in (document.sled206.iter().flat_map(SledCheck::sentences)).enumerate() {
        out.line(if index == 0 { "sled pulse" } else { "" }, &text);
    }
    if let Some(restitution) = words::restitution(document) {
        let text = format!("{restitution}.");
        if words::is_isolated_restitution(document) {
            out.graded("restitution", Severity::Warning, &text);
        } else {
            out.line("restitution", &text);
        }
    }
    if let Some(report) = report {
        out.raw("report", &look.path(&report.join(REPORT_FILE)));
        if let Some(pdf) = pdf {
            out.raw("pdf", &look.path(pdf));
        }
        let verdict = report.join(VERDICT_FILE).display().to_string();
        out.raw(
            "verify",
            &format!("latchgate verify {}", super::escape::shell(&verdict)),
        );
    }
    out.into_string()
}

/// Writes the results of a usable recording.
fn judged(out: &mut TerminalLines, document: &Document) {
    let several = document.polarities.len() > 1;
    if several {
        for row in words::directions(document) {
            out.line(row.sign, &format!("{}: {}", row.word, row.text));
        }
        out.line("limit", &words::limit_angle(document.threshold_rad));
    } else if let Some(run) = words::leading_run(document) {
        let peak = words::peak(document, run);
        out.line(
            "peak",
            &format!(
                "{peak}; limit angle {}",
                words::limit_angle(document.threshold_rad)
            ),
        );
        if let Some(text) = words::stops(document) {
            out.line("stops", &text);
        }
    }
    if let Some(text) = words::catch(document) {
        out.line("catch", text);
    }
    if let Some(text) = words::varied(document) {
        out.line("varied", &text);
    } else if let Some(bound) = words::sparing_bound(document) {
        let text = format!(
            "none of the varied levers can open: the worst {}",
            bound.name()
        );
        out.line("varied", &text);
    }
    if let Some(text) = words::what_was_varied(document) {
        out.line("varied by", &text);
    }
    out.line("direction", &words::direction(&document.recording));
    if let Some(place) = sensor_place(&document.recording, document.transfer.as_ref()) {
        out.line("place", &place);
    }
    if let Some(each) = siblings(&document.siblings) {
        out.line("channels", &each);
    }
    if let Some(text) = words::in_plane(document) {
        out.line("in plane", &text);
    }
    if let Some(conditioning) = &document.conditioning {
        let signal = words::conditioned(conditioning);
        let without = words::without_filter(document).unwrap_or_default();
        out.line("signal", &format!("{signal}{without}"));
    }
    if document.verdict == Answer::Pass {
        out.line("not seen", words::UNSEEN);
    }
}

/// Writes the findings: the most severe, or all of them.
fn findings(out: &mut TerminalLines, document: &Document, detail: bool) {
    if document.findings.is_empty() {
        out.line("findings", "none");
        return;
    }
    let mut findings: Vec<&Finding> = document.findings.iter().collect();
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    let is_shown = |finding: &&&Finding| detail || words::is_always_shown(finding);
    let shown: Vec<&&Finding> = findings.iter().filter(is_shown).collect();
    let shown_max = if detail { usize::MAX } else { FINDINGS };
    let mut name = "findings";
    for finding in shown.iter().take(shown_max) {
        let instant = finding
            .at_s
            .map_or_else(String::new, |at_s| format!(" at {}", words::instant(at_s)));
        let text = words::sentence(&finding.text);
        let in_full = detail || finding.severity == Severity::Blocking || words::is_remark(finding);
        let text = if in_full {
            text
        } else {
            words::first_sentences(&out.worded(&text), LETTERS)
        };
        out.graded(
            name,
            finding.severity,
            &format!("{}{instant}: {text}", finding.code),
        );
        name = "";
    }
    let hidden = findings.len() - shown.len().min(shown_max);
    if hidden > 0 {
        let more = if shown.is_empty() { "" } else { " more" };
        let notes = if shown.len() <= shown_max {
            "note"
        } else {
            "finding"
        };
        let many = if hidden == 1 { "" } else { "s" };
        out.line(
            name,
            &format!("{hidden}{more} {notes}{many}; -v tells them"),
        );
    }
}

/// Writes how the answer was decided.
fn detail(out: &mut TerminalLines, document: &Document) {
    for (index, reason) in document.why.iter().enumerate() {
        let name = if index == 0 { "why" } else { "" };
        out.line(name, &words::sentence(&reason.text));
    }
    if document.verdict == Answer::Unusable {
        return;
    }
    if let Some(run) = &document.nominal {
        out.line("impacts", &words::impacts(run));
        if let Some(coast) = run.coast_peak_angle_rad {
            let coast = words::bounded_angle(coast);
            out.line(
                "coast",
                &format!("after the record ends the lever could still reach {coast}"),
            );
        }
    }
    if let Some(ensemble) = &document.ensemble {
        let drivers: Vec<String> = ensemble
            .drivers
            .iter()
            .filter_map(|driver| {
                let correlation = plain(driver.rank_correlation?, 2);
                Some(format!(
                    "{} ({correlation})",
                    words::parameter(&driver.parameter)
                ))
            })
            .take(3)
            .collect();
        if !drivers.is_empty() {
            let text = format!("to {} (rank correlation)", drivers.join(", "));
            out.line("sensitive", &text);
        }
    }
    let filters: Vec<String> = document
        .filters
        .iter()
        .filter_map(|row| {
            let peak = words::filtered_angle(document, row, row.peak_angle_rad?, row.verdict);
            let degree = if peak.ends_with(|c: char| c.is_ascii_digit()) {
                "°"
            } else {
                ""
            };
            let answer = words::filtered_answer(document, row);
            let filter = filter_name(row.filter);
            Some(format!("{filter} {peak}{degree} ({answer})"))
        })
        .collect();
    if !filters.is_empty() {
        let text = format!("nominal lever alone: {}", filters.join(", "));
        out.line("by filter", &text);
    }
    out.line("report id", &document.report_id);
}

/// A recording that was judged, or not, in a table of several.
#[derive(Debug, Clone, Copy)]
pub struct TableRow<'a> {
    /// Its document.
    pub document: &'a Document,
    /// True if it was judged.
    pub judged: bool,
    /// Folder of its report.
    pub report: Option<&'a Path>,
}

/// Returns a table of several recordings, the worst first, and a line that sums it up.
pub fn table(rows: &[TableRow<'_>], look: Look) -> String {
    let mut order: Vec<&TableRow> = rows.iter().collect();
    order.sort_by_key(|row| rank(row.document.verdict));
    let heads = [
        "verdict",
        "recording",
        "peak",
        "opens at",
        "findings",
        "channel",
        "report",
    ];
    let mut cells = vec![heads.map(String::from).to_vec()];
    cells.extend(order.into_iter().map(|row| table_row(row, look)));
    // A narrow terminal has no room for the last columns; the reports hold them.
    let mut table = terminal::table(&cells, &[2, 3]);
    while look
        .width
        .is_some_and(|width| terminal::widest(&table) > width)
        && cells[0].len() > 3
    {
        cells.iter_mut().for_each(|row| row.truncate(row.len() - 1));
        table = terminal::table(&cells, &[2, 3]);
    }
    let sum: Vec<String> = [
        Answer::Unusable,
        Answer::Fail,
        Answer::Undecided,
        Answer::Pass,
    ]
    .into_iter()
    .filter_map(|answer| {
        let number = rows.iter().filter(|row| row.document.verdict == answer);
        let number = number.count();
        (number > 0).then(|| format!("{number} {}", answer.name()))
    })
    .collect();
    let passes = rows.iter().any(|row| row.document.verdict == Answer::Pass);
    let mut unseen = TerminalLines::new(look);
    if passes {
        unseen.line("not seen", words::UNSEEN);
    }
    let unseen = unseen.into_string();
    let worst = rows.iter().map(|row| row.document.verdict);
    let worst = worst.min_by_key(|answer| rank(*answer));
    let head = worst.map_or_else(String::new, |worst| look.verdict(worst));
    format!(
        "{head}  {} recordings: {}\n{table}{unseen}",
        rows.len(),
        sum.join(", ")
    )
}

/// Returns the place of an answer among several, the worst first.
pub fn rank(answer: Answer) -> u8 {
    match answer {
        Answer::Unusable => 0,
        Answer::Fail => 1,
        Answer::Undecided => 2,
        Answer::Pass => 3,
    }
}

fn table_row(row: &TableRow<'_>, look: Look) -> Vec<String> {
    let document = row.document;
    let shown = |text: &str| super::escape::terminal(text).into_owned();
    let none = || "–".to_string();
    let run = document.nominal.as_ref();
    // An answer that depends on the opening direction has no single run to show.
    let has_one_answer = document.verdict != Answer::Undecided || document.polarities.len() < 2;
    let run = run.filter(|_| has_one_answer && document.verdict != Answer::Unusable);
    let peak = run.map_or_else(none, |run| words::short_peak(document, run));
    let opens = document
        .opens
        .filter(|opens| has_one_answer && opens.first_s.is_some());
    let report = row.report.map(|folder| folder.join(REPORT_FILE));
    let verdict = if row.judged {
        look.verdict(document.verdict)
    } else {
        "! NOT JUDGED".into()
    };
    vec![
        verdict,
        shown(&document.recording.file),
        peak.replace('\u{00A0}', " "),
        opens
            .map_or_else(none, |opens| opening::cell(&opens))
            .replace('\u{00A0}', " "),
        words::findings_count(document),
        document
            .recording
            .channel
            .as_deref()
            .map_or_else(none, shown),
        report.map_or_else(none, |path| look.path(&path)),
    ]
}
