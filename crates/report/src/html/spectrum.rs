//! The page of `latchgate spectrum`.

use super::markup::{code_fact, fact, figure as drawing, heads};
use crate::escape::terminal as line;
use crate::page::PageFrame;
use crate::plot::{Figure, SPECTRUM_RULES};
use crate::spectrum_words::{
    ON_PAGE_MM, design, g, headline, makers, remarks, rows, sensor, subtitle,
};
use crate::words;
use latchgate_document::SpectrumDocument;
use latchgate_document::number::{ABSENT, significant};
use maud::{Markup, html};

/// Returns the page as one self-contained HTML document.
pub(crate) fn page(document: &SpectrumDocument, figure: &Figure) -> String {
    let count = document.recordings.len();
    let subject = match document.recordings.as_slice() {
        [only] => only.recording.file.clone(),
        _ => format!("{count} curves"),
    };
    let frame = PageFrame {
        title: &format!("spectrum · {} · latchgate", line(&subject)),
        identity: "spectrum",
        style: SPECTRUM_RULES,
        script: "",
    };
    let table = rows(document, ON_PAGE_MM);
    let head: Vec<&str> = table[0].iter().map(String::as_str).collect();
    let told = remarks(document);
    let makers = makers(document);
    let body = html! {
        main {
            header {
                div {
                    p { "Latch response spectrum: what any latch must have" }
                    h1 { (line(&subject)) }
                }
                div.id { p { "latchgate " (line(&document.run.version)) } }
            }
            section #answer {
                p { strong { (line(&headline(document))) } }
                (drawing(figure))
            }
            @if !document.designs.is_empty() {
                section #designs {
                    h2 { "Designs" }
                    ul { @for point in &document.designs { li { (line(&design(document, point))) } } }
                    p.note { "A design's place is that of all of it, three standard deviations of preload, mass, arm and inertia to every side, by its own spring, damping, stops and angles." }
                }
            }
            section #curves tabindex="0" {
                h2 { "Curves [g]" }
                table {
                    (heads(&head))
                    tbody { @for row in &table[1..] { (table_row(row)) } }
                }
                p.note { "From where not every lever opens … to the spectrum, above which a lever stays; – where no window opens." }
                @if count > 1 && !makers.is_empty() {
                    h2 { "Who makes the envelope" }
                    ul { @for maker in &makers { li { (line(maker)) } } }
                }
            }
            @if !told.is_empty() {
                section #findings {
                    h2 { "Findings" }
                    ul { @for (severity, text) in &told { li { strong { (words::severity(*severity)) } " " (line(text)) } } }
                }
            }
            section #settings {
                h2 { "What the levers share" }
                table.facts {
                    tbody {
                        (fact("Levers", &subtitle(document).join("; ")))
                        (fact("Reading", &readings(document)))
                        (fact("Angles", &angles(document)))
                    }
                }
            }
            section #recordings {
                h2 { "Recordings" }
                @for curve in &document.recordings {
                    details {
                        summary { (line(&curve.name)) ", " (line(&sensor(curve))) }
                        table.facts {
                            tbody {
                                (fact("Strongest", &g(curve.strongest_m_s2)))
                                (fact("Filter", curve.conditioning.filter.map_or("none", |filter| filter.name())))
                                @for (name, value) in words::test_facts(&curve.test) { (fact(name, &value)) }
                                (code_fact("SHA-256", curve.recording.sha256.as_deref().unwrap_or(ABSENT)))
                                @for finding in &curve.findings {
                                    (fact(&finding.code, &words::sentence(&finding.text)))
                                }
                            }
                        }
                    }
                }
                table.facts { tbody { (code_fact("Report", &document.report_id)) } }
            }
        }
    };
    frame.head() + &body.into_string() + &frame.tail()
}

fn table_row(row: &[String]) -> Markup {
    html! {
        tr {
            @for (column, cell) in row.iter().enumerate() {
                @if column < 2 { th { (line(cell)) } } @else { td.number { (line(cell)) } }
            }
        }
    }
}

fn readings(document: &SpectrumDocument) -> String {
    let settings = &document.settings;
    format!(
        "scale ± {} %, bias ± {} g or its standard error; {} readings with noise and between the samples shared by {} levers; seed {}",
        significant(settings.scale_deviation * 100.0, 3),
        significant(settings.bias_deviation_m_s2 / 9.80665, 3),
        settings.readings,
        settings.levers,
        settings.seed
    )
}

fn angles(document: &SpectrumDocument) -> String {
    let limit = document.settings.limit_angle_rad;
    format!(
        "cos φ is taken as 1: for a limit angle of {} rad that is {} % of the load at most",
        significant(limit, 3),
        significant((1.0 - libm::cos(limit)) * 100.0, 2)
    )
}
