//! What `latchgate spectrum` hands over: its text, and the files of its report.

pub use super::folder::SPECTRUM_FILE as DOCUMENT_FILE;
use super::terminal::{Look, TerminalLines, fitted_table, wrapped};
use super::{html, json, plot};
use crate::escape;
use crate::spectrum_words::{design, headline, makers, remarks, rows, subtitle};
use latchgate_document::SpectrumDocument;
use latchgate_recording::error::Error;
use std::path::{Path, PathBuf};

/// File name of the page.
pub const PAGE_FILE: &str = "spectrum.html";

const TABLE_FILE: &str = "spectrum.csv";
const CHART_FILE: &str = "spectrum.svg";

/// Strokes of the table on a terminal [mm].
const ON_TERMINAL_MM: &[f64] = &[1.0, 5.0, 20.0, 100.0];

/// Returns the files of a report, names with bytes: page, document, table and chart, the page first.
pub fn files(document: &SpectrumDocument) -> Vec<(String, Vec<u8>)> {
    let figure = plot::spectrum_figure(document);
    let files = [
        (PAGE_FILE, html::spectrum_page(document, &figure)),
        (DOCUMENT_FILE, json::render(document)),
        (TABLE_FILE, csv(document)),
        (CHART_FILE, plot::spectrum_stand_alone(&figure)),
    ];
    files
        .map(|(name, text)| (name.to_string(), text.into_bytes()))
        .into()
}

/// Writes [`files`] into `dir`, which is created if absent, and returns their paths, the page's first.
///
/// # Errors
///
/// [`latchgate_recording::error::ErrorKind::Io`] if `dir` cannot be made or a file not be removed or written.
pub fn write(dir: &Path, document: &SpectrumDocument) -> Result<Vec<PathBuf>, Error> {
    let ours = [PAGE_FILE, DOCUMENT_FILE, TABLE_FILE, CHART_FILE];
    super::folder::put(dir, &ours, &files(document))
}

/// Returns every curve with its zone as a table, a stroke a row, empty where there is no value.
fn csv(document: &SpectrumDocument) -> String {
    let mut rows = csv::Writer::from_writer(Vec::new());
    let mut head = vec!["stroke_m".to_string(), "envelope_m_s2".into()];
    for curve in &document.recordings {
        let name = escape::terminal(&curve.name);
        let name = escape::cell(&name);
        head.push(format!("{name} spectrum_m_s2"));
        head.push(format!("{name} zone_from_m_s2"));
        head.push(format!("{name} single_push_m_s2"));
    }
    let cell = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
    // Into memory nothing fails.
    if document.share_m_s2.is_some() {
        head.insert(2, "share_m_s2".into());
    }
    let _ = rows.write_record(&head);
    for (place, stroke_m) in document.stroke_m.iter().enumerate() {
        let mut row = vec![stroke_m.to_string(), cell(document.envelope_m_s2[place])];
        row.extend(document.share_m_s2.iter().map(|share| cell(share[place])));
        for index in 0..document.recordings.len() {
            row.push(cell(document.spectrum_m_s2[index][place]));
            row.push(cell(document.zone_from_m_s2[index][place]));
            row.push(cell(Some(document.single_push_m_s2[index][place])));
        }
        let _ = rows.write_record(&row);
    }
    let bytes = rows.into_inner().unwrap_or_default();
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Returns the answer for a terminal.
pub fn text(document: &SpectrumDocument, report: Option<&Path>, look: Look) -> String {
    let mut out = format!("{}\n\n", wrapped(&headline(document), look.width, 0));
    let rows: Vec<Vec<String>> = rows(document, ON_TERMINAL_MM)
        .into_iter()
        .map(|row| {
            // Where each sensor stands is told of those that make the envelope.
            let cells = row.into_iter().enumerate();
            let cells = cells
                .filter(|(column, _)| *column != 1)
                .map(|(_, cell)| cell);
            cells
                .map(|cell| escape::terminal(cell.trim_start_matches('#')).into_owned())
                .collect()
        })
        .collect();
    out += &fitted_table(&rows, 1, look.width);
    let mut lines = TerminalLines::new(look);
    lines.blank();
    lines.line(
        "in g",
        "from where not every lever opens … to the spectrum, above which a lever stays",
    );
    lines.line("levers", &subtitle(document).join("; "));
    for (index, maker) in makers(document)
        .iter()
        .enumerate()
        .filter(|_| document.recordings.len() > 1)
    {
        lines.line(if index == 0 { "envelope" } else { "" }, maker);
    }
    for (index, point) in document.designs.iter().enumerate() {
        let name = if index == 0 { "designs" } else { "" };
        lines.line(name, &design(document, point));
    }
    let told = remarks(document);
    for (index, (severity, text)) in told.iter().take(REMARKS_SHOWN).enumerate() {
        lines.graded(if index == 0 { "findings" } else { "" }, *severity, text);
    }
    if told.len() > REMARKS_SHOWN {
        let more = format!("{} more on the page", told.len() - REMARKS_SHOWN);
        lines.line("", &more);
    }
    lines.line(
        "",
        "It describes and passes nothing: a verdict comes from latchgate replay.",
    );
    if let Some(report) = report {
        lines.raw("report", &look.path(&report.join(PAGE_FILE)));
    }
    out += &lines.into_string();
    out
}

/// Remarks that the terminal shows.
const REMARKS_SHOWN: usize = 6;
