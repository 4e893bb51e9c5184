//! What `latchgate margin` hands over: its text, and the files of its report.

pub use super::folder::MARGIN_FILE as DOCUMENT_FILE;
use super::margin_words::{advised, direction, headline, titled, without_advice};
use super::terminal::{Look, TerminalLines};
use super::words;
use super::{html, json, plot};
use latchgate_document::MarginDocument;
use latchgate_document::number::plain;
use latchgate_kernel::units::shortest;
use latchgate_recording::Severity;
use latchgate_recording::error::Error;
use latchgate_verdict::Answer;
use latchgate_verdict::margin::{LimitPoint, Margins};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// File name of the page.
pub const PAGE_FILE: &str = "margin.html";

/// Every file that a report may hold.
const FILES: [&str; 6] = [
    PAGE_FILE,
    DOCUMENT_FILE,
    "margin-scan.csv",
    "margin-scan.svg",
    "margin-limit.csv",
    "margin-limit.svg",
];

/// Returns the files of a margin's report, names with bytes: page, document, tables and plots, the
/// page first.
pub fn files(document: &MarginDocument, margins: &Margins) -> Vec<(String, Vec<u8>)> {
    let figures = plot::margin_figures(document, margins);
    let mut files = vec![
        (PAGE_FILE.to_string(), html::margin_page(document, &figures)),
        (DOCUMENT_FILE.to_string(), json::render(document)),
        ("margin-scan.csv".to_string(), scan_table(margins)),
    ];
    if let Some(limit) = &margins.limit {
        files.push(("margin-limit.csv".to_string(), limit_table(&limit.points)));
    }
    for figure in &figures {
        let name = format!("{}.svg", figure.name);
        files.push((name, plot::margin_stand_alone(figure)));
    }
    let bytes = |(name, text): (String, String)| (name, text.into_bytes());
    files.into_iter().map(bytes).collect()
}

/// Writes [`files`] into `dir`, which is created if absent, and returns their paths, the page's
/// first. Files of these names from an earlier run are removed first.
///
/// # Errors
///
/// [`latchgate_recording::error::ErrorKind::Io`] if `dir` cannot be made or a file not be removed or written.
pub fn write(
    dir: &Path,
    document: &MarginDocument,
    margins: &Margins,
) -> Result<Vec<PathBuf>, Error> {
    super::folder::put(dir, &FILES, &files(document, margins))
}

/// Returns a number with all its digits, or nothing.
fn cell(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

fn scan_table(margins: &Margins) -> String {
    let mut out = String::from("quantity,value,peak_angle_rad\n");
    for scan in &margins.scans {
        for (value, peak) in &scan.points {
            let _ = writeln!(out, "{},{value},{}", scan.quantity.name(), cell(*peak));
        }
    }
    out
}

fn limit_table(points: &[LimitPoint]) -> String {
    let mut out = String::from(
        "model,duration_s,amplitude_g,amplitude_low_g,amplitude_high_g,velocity_change_m_s\n",
    );
    for point in points {
        let (low, high) = point
            .amplitude_bracket_g
            .map_or((None, None), |(low, high)| (Some(low), Some(high)));
        let _ = writeln!(
            out,
            "{},{},{},{},{},{}",
            point.model.name(),
            point.duration_s,
            cell(point.amplitude_g),
            cell(low),
            cell(high),
            cell(point.velocity_change_m_s)
        );
    }
    out
}

/// Returns the margins for a terminal, a screen at most: the verdict with the advice, what was judged, one
/// table, then its notes. All boundaries and findings are in the files.
pub fn text(document: &MarginDocument, report: Option<&Path>, look: Look) -> String {
    let mut out = TerminalLines::new(look);
    out.headline(document.verdict, &headline(document));
    let recording = &document.recording;
    let channel = recording.channel.as_ref();
    let channel = channel.map_or(String::new(), |channel| format!(", channel {channel}"));
    out.line("recording", &format!("{}{channel}", recording.file));
    if let Some((_, first)) = words::test_facts(&document.test).first() {
        out.line("test", first);
    }
    let design = words::design(&document.design);
    let limit = words::limit_angle(document.threshold_rad);
    out.line("design", &format!("{design}; limit angle {limit}"));
    out.line("direction", &words::direction(recording));
    if document.verdict != Answer::Unusable {
        margins(&mut out, document);
    }
    let grave = document.findings.iter();
    let grave: Vec<_> = grave
        .filter(|finding| finding.severity > Severity::Info)
        .collect();
    for (index, finding) in grave.iter().take(FINDINGS_SHOWN).enumerate() {
        let text = words::sentence(&finding.text);
        let text = format!("{}: {text}", finding.code);
        out.graded(
            if index == 0 { "findings" } else { "" },
            finding.severity,
            &text,
        );
    }
    if grave.len() > FINDINGS_SHOWN {
        let more = format!("{} more, as replay tells", grave.len() - FINDINGS_SHOWN);
        out.line("", &more);
    }
    if let Some(report) = report {
        out.raw("report", &look.path(&report.join(PAGE_FILE)));
    }
    out.into_string()
}

/// Writes the table of margins and its notes.
fn margins(out: &mut TerminalLines, document: &MarginDocument) {
    out.blank();
    out.table(&table(document));
    out.blank();
    for (index, note) in document.notes.iter().enumerate() {
        out.line(if index == 0 { "notes" } else { "" }, note);
    }
    let titles: Vec<String> = without_advice(document)
        .into_iter()
        .map(|(title, _)| title)
        .collect();
    if !titles.is_empty() {
        let text = format!(
            "{}: the safe end does not pass; the page says why",
            titles.join(", ")
        );
        out.line("no advice", &text);
    }
    if let Some(pulses) = half_sines(document) {
        out.line("half-sine", &format!("just reaches the limit: {pulses}"));
    }
}

/// Findings that the terminal shows.
const FINDINGS_SHOWN: usize = 2;

fn table(document: &MarginDocument) -> Vec<Vec<String>> {
    let head = [
        "quantity",
        "present",
        "passes from",
        "tried to",
        "nearest change",
        "",
    ];
    let mut rows = vec![head.map(String::from).to_vec()];
    for answer in &document.answers {
        let nearest = answer.at();
        rows.push(vec![
            titled(answer, document.counterweight.radius_m),
            shortest(answer.present),
            advised(answer),
            shortest(answer.advice.until),
            nearest.map_or_else(|| "none".into(), shortest),
            nearest.map_or_else(String::new, |_| direction(answer).into()),
        ]);
    }
    rows
}

/// Durations of the limit that the terminal shows [ms].
const SHOWN_MS: [f64; 5] = [1.0, 5.0, 10.0, 20.0, 100.0];

/// Returns the half-sine pulses that just reach the limit, on the stop that needs less.
fn half_sines(document: &MarginDocument) -> Option<String> {
    let limit = document.limit.as_ref()?;
    let of_shown = |shown: &f64| {
        let points = limit.points.iter();
        let points = points.filter(|point| (point.duration_s * 1e3 - shown).abs() < 1e-9);
        let least = points
            .filter_map(|point| point.amplitude_g)
            .reduce(f64::min)?;
        Some(format!("{} g for {shown} ms", plain(least, 3)))
    };
    let pulses: Vec<String> = SHOWN_MS.iter().filter_map(of_shown).collect();
    (!pulses.is_empty()).then(|| pulses.join(", "))
}
