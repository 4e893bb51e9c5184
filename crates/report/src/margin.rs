//! What `latchgate margin` hands over: its text, and the files of its report.

use super::margin_words::{advised, direction, never};
use super::words;
use super::{escape, html, json, plot};
use latchgate_document::MarginDocument;
use latchgate_document::number::plain;
use latchgate_kernel::units::shortest;
use latchgate_recording::Severity;
use latchgate_recording::error::Error;
use latchgate_verdict::margin::{LimitPoint, Margins, Quantity};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// File name of the page.
pub const PAGE_FILE: &str = "margin.html";

/// File name of the document.
pub const DOCUMENT_FILE: &str = "margin.json";

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

/// A number with all its digits, or nothing.
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

/// Returns the margins for a terminal, a screen at most: one table, then what must be said of it.
/// All boundaries and findings stand in the files.
pub fn text(document: &MarginDocument, report: Option<&Path>) -> String {
    let mut out = String::with_capacity(4096);
    let _ = writeln!(out, "{}", words::answer(document.verdict));
    let line = |out: &mut String, name: &str, text: &str| {
        let _ = writeln!(out, "  {name:<15} {}", escape::terminal(text));
    };
    let recording = &document.recording;
    let mut subject = recording.file.clone();
    if let Some(channel) = &recording.channel {
        let _ = write!(subject, ", channel {channel}");
    }
    let _ = write!(
        subject,
        ", design {}, limit {} rad",
        words::design(&document.design).replace('\u{00A0}', " "),
        document.threshold_rad
    );
    line(&mut out, "recording", &subject);
    out.push('\n');
    table(&mut out, document);
    out.push('\n');
    for (index, note) in document.notes.iter().enumerate() {
        line(&mut out, if index == 0 { "notes" } else { "" }, note);
    }
    for (title, why) in never(document) {
        line(&mut out, "never", &format!("{title}: {why}."));
    }
    limit(&mut out, document);
    let grave = document.findings.iter();
    let grave: Vec<_> = grave
        .filter(|finding| finding.severity > Severity::Info)
        .collect();
    for (index, finding) in grave.iter().take(FINDINGS_SHOWN).enumerate() {
        let text = words::sentence(&finding.text);
        let text = format!("{} {}: {text}", finding.severity.name(), finding.code);
        line(&mut out, if index == 0 { "findings" } else { "" }, &text);
    }
    if grave.len() > FINDINGS_SHOWN {
        let more = format!("{} more, as replay tells", grave.len() - FINDINGS_SHOWN);
        line(&mut out, "", &more);
    }
    if let Some(report) = report {
        line(
            &mut out,
            "report",
            &report.join(PAGE_FILE).display().to_string(),
        );
    }
    out
}

/// Findings that the terminal shows.
const FINDINGS_SHOWN: usize = 2;

fn table(out: &mut String, document: &MarginDocument) {
    let mut rows = vec![[
        "quantity".to_string(),
        "present".into(),
        "passes from".into(),
        "tried to".into(),
        "nearest change".into(),
        "".into(),
    ]];
    for answer in &document.answers {
        let title = if answer.quantity == Quantity::Counterweight {
            format!(
                "{} fixed at {} m",
                answer.title, document.counterweight.radius_m
            )
        } else {
            answer.title.to_string()
        };
        rows.push([
            title,
            answer.quantity.shown(answer.present),
            advised(answer),
            shortest(answer.advice.until),
            answer
                .at()
                .map_or_else(|| "none".into(), |at| answer.quantity.shown(at)),
            answer
                .at()
                .map_or_else(String::new, |_| direction(answer).into()),
        ]);
    }
    let mut widths = [0; 6];
    for row in &rows {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.chars().count());
        }
    }
    for row in &rows {
        let mut line = String::from(" ");
        for (width, cell) in widths.iter().zip(row) {
            let _ = write!(line, " {cell:<width$} ");
        }
        out.push_str(line.trim_end());
        out.push('\n');
    }
}

/// Durations of the limit that the terminal shows [ms].
const SHOWN_MS: [f64; 5] = [1.0, 5.0, 10.0, 20.0, 100.0];

/// Writes the limit under half-sine pulses, a line for each stop.
fn limit(out: &mut String, document: &MarginDocument) {
    let Some(limit) = &document.limit else {
        return;
    };
    let mut stops = Vec::new();
    for point in &limit.points {
        if !stops.contains(&point.model) {
            stops.push(point.model);
        }
    }
    for stop in stops {
        let of_shown = |shown: &f64| {
            let point = limit.points.iter().find(|point| {
                point.model == stop && (point.duration_s * 1e3 - shown).abs() < 1e-9
            })?;
            Some(format!("{} g for {shown} ms", plain(point.amplitude_g?, 3)))
        };
        let pulses: Vec<String> = SHOWN_MS.iter().filter_map(of_shown).collect();
        let name = stop.name();
        let pulses = pulses.join(", ");
        let _ = writeln!(
            out,
            "  half-sine       just reaches the limit, {name}: {pulses}"
        );
    }
}
