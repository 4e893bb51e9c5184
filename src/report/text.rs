//! The verdict for a terminal.

use super::number::plain;
use super::words::margin;
use super::words::{self, DIGITS};
use super::{REPORT_FILE, escape};
use crate::replay::Run;
use crate::report::Document;
use crate::verdict::Answer;
use std::fmt::Write as _;
use std::path::Path;

/// Returns the verdict as a few aligned lines: the word first, then peak, limit, margin, first
/// crossing, impacts, stops, reasons, findings, and where the report is, if one was written
/// into `report`. Numbers are ASCII, so that they can be copied into other programs.
#[must_use]
pub fn render(document: &Document, report: Option<&Path>) -> String {
    let mut out = String::with_capacity(2048);
    out.push_str(words::answer(document.verdict));
    out.push('\n');
    let recording = &document.recording;
    let mut subject = recording.file.clone();
    if let Some(channel) = &recording.channel {
        let _ = write!(subject, ", channel {channel}");
    }
    let _ = write!(subject, ", design {}", document.design.name);
    line(&mut out, "recording", &subject);
    let limit = format!("{} rad", document.threshold_rad);
    match &document.nominal {
        Some(run) => nominal(&mut out, document, run, &limit),
        None => {
            line(&mut out, "peak", "none: nothing was replayed");
            line(&mut out, "limit", &limit);
        }
    }
    runs(&mut out, document);
    ensemble(&mut out, document);
    if let Some(ladder) = &document.ladder {
        line(
            &mut out,
            "decided by",
            &format!("{}. {}", ladder.rung.name(), ladder.text),
        );
    }
    if let Some(preload) = &document.preload_answer {
        line(&mut out, "design", &preload.text);
    }
    for (index, reason) in document.why.iter().enumerate() {
        let name = if index == 0 { "why" } else { "" };
        line(&mut out, name, &words::sentence(&reason.text));
    }
    findings(&mut out, document);
    if let Some(report) = report {
        let path = report.join(REPORT_FILE).display().to_string();
        line(&mut out, "report", &path);
    }
    out
}

/// Writes a name and what belongs to it; whatever `text` holds, it stays on its line.
fn line(out: &mut String, name: &str, text: &str) {
    let _ = writeln!(out, "  {name:<15} {}", escape::terminal(text));
}

fn nominal(out: &mut String, document: &Document, run: &Run, limit: &str) {
    if document.verdict == Answer::Unusable {
        line(
            out,
            "caution",
            "the recording carries no answer; the figures below are no evidence of a pass",
        );
    }
    line(
        out,
        "peak",
        &format!(
            "{} rad at {} ({}, {})",
            plain(run.peak_angle_rad, DIGITS),
            time(run.peak_time_s),
            words::stop(run.model),
            words::opens(run.opens_when)
        ),
    );
    line(out, "limit", limit);
    let (margin, share) = margin(document.threshold_rad, run.peak_angle_rad);
    line(
        out,
        "margin",
        &format!(
            "{} rad ({} % of the limit)",
            plain(margin, DIGITS),
            plain(share, 4)
        ),
    );
    let crossing = run.first_crossing_s.map_or_else(
        || "none".to_string(),
        |at| {
            format!(
                "{}, above the limit for {} in all",
                time(at),
                time(run.time_above_threshold_s)
            )
        },
    );
    line(out, "first crossing", &crossing);
    line(out, "impacts", &run.impacts.to_string());
    if let Some(coast) = run.coast_peak_angle_rad {
        line(
            out,
            "coast",
            &format!(
                "to {} rad at most after the last judged sample",
                plain(coast, DIGITS)
            ),
        );
    }
}

fn runs(out: &mut String, document: &Document) {
    let describe = |run: &Run| {
        let crossing = run.first_crossing_s.map_or_else(
            || "does not cross the limit".to_string(),
            |at| format!("first crosses the limit at {}", time(at)),
        );
        format!("peak {} rad, {crossing}", plain(run.peak_angle_rad, DIGITS))
    };
    if document.polarities.is_empty() {
        for (stop, run) in &document.models {
            line(out, &format!("{} stop", stop.name()), &describe(run));
        }
    }
    for (sign, stops) in &document.polarities {
        for (stop, run) in stops {
            line(
                out,
                &format!("{} stop", stop.name()),
                &format!("{} opens: {}", sign.name(), describe(run)),
            );
        }
    }
}

/// How many of the scattered levers cross, what drives the peak, and the filters in a line.
fn ensemble(out: &mut String, document: &Document) {
    if let Some(ensemble) = &document.ensemble {
        let percent = |share: f64| plain(100.0 * share, 3);
        let spread = ensemble.peak_angle_rad.map_or_else(String::new, |peak| {
            format!(
                "; peak {} to {} rad in 9 of 10",
                plain(peak.p05, 3),
                plain(peak.p95, 3)
            )
        });
        let coasting = match ensemble.exceeded_in_coast {
            0 => String::new(),
            members => format!("; {members} more coast beyond it afterwards"),
        };
        line(
            out,
            "ensemble",
            &format!(
                "{} of {} members cross the limit{}, {} to {} % of all{coasting}{spread}",
                ensemble.exceeded,
                ensemble.members,
                words::until(ensemble).replace('\u{00A0}', " "),
                percent(ensemble.p_lower),
                percent(ensemble.p_upper)
            ),
        );
        let drivers: Vec<String> = ensemble
            .drivers
            .iter()
            .filter_map(|driver| {
                Some(format!(
                    "{} ({})",
                    driver.parameter,
                    plain(driver.rank_correlation?, 2)
                ))
            })
            .take(3)
            .collect();
        if !drivers.is_empty() {
            line(
                out,
                "driven by",
                &format!("{} by rank correlation", drivers.join(", ")),
            );
        }
    }
    let filters: Vec<String> = document
        .filters
        .iter()
        .filter_map(|row| {
            Some(format!(
                "{} {} ({})",
                row.filter,
                row.verdict?.name(),
                plain(row.peak_angle_rad?, 3)
            ))
        })
        .collect();
    if !filters.is_empty() {
        line(out, "by filter", &filters.join(", "));
    }
}

fn findings(out: &mut String, document: &Document) {
    if document.findings.is_empty() {
        line(out, "findings", "none");
        return;
    }
    let mut findings: Vec<_> = document.findings.iter().collect();
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    for (index, finding) in findings.into_iter().enumerate() {
        let word = finding.severity.name();
        let at = finding
            .at_s
            .map(|at| format!(" at {}", time(at)))
            .unwrap_or_default();
        line(
            out,
            if index == 0 { "findings" } else { "" },
            &format!(
                "{word} {}{at}: {}",
                finding.code,
                words::sentence(&finding.text)
            ),
        );
    }
}

fn time(seconds: f64) -> String {
    if seconds.abs() < 10.0 {
        format!("{} ms", plain(seconds * 1e3, DIGITS))
    } else {
        format!("{} s", plain(seconds, 7))
    }
}
