//! What the runs say: comparison, impacts, error budget, bounds, findings.
//!
//! Each function writes one section of the page from the blocks of the document that tell of runs;
//! they share which runs are shown and how an angle is worded.

use super::markup::Page;
use crate::words::{self, DIGITS, instant, margin};
use latchgate_document::Document;
use latchgate_document::number::{ABSENT, count, milliseconds, significant};
use latchgate_kernel::replay::Run;
use latchgate_recording::Finding;

/// Rows of the impacts table that are always shown.
const IMPACTS_SHOWN: usize = 20;

/// Impacts that are listed at most.
const IMPACTS_LISTED: usize = 200;

/// Writes the runs side by side.
pub(super) fn runs(page: &mut Page, document: &Document) {
    let runs = compared(document);
    if runs.is_empty() {
        return;
    }
    let heads: Vec<String> = runs
        .iter()
        .map(|run| {
            let nominal = if is_nominal(document, run) {
                " (nominal)"
            } else {
                ""
            };
            format!(
                "#{}, {}{nominal}",
                words::stop(run.model),
                words::opens(run.opens_when)
            )
        })
        .collect();
    let mut columns = vec!["Quantity"];
    columns.extend(heads.iter().map(String::as_str));
    page.table("runs", &columns);
    quantities(page, document, &runs);
    page.end_table();
    if document.models.len() < 2 {
        page.note(&format!(
            "Stop model asked for: {}. Only the stops shown were run.",
            document.request.model.name()
        ));
    }
}

/// Writes a row for each quantity of the runs.
fn quantities(page: &mut Page, document: &Document, runs: &[&Run]) {
    let threshold = document.threshold_rad;
    let optional = |value: Option<f64>, show: &dyn Fn(f64) -> String| {
        value.map_or_else(|| "none".to_string(), show)
    };
    let ms = |seconds: f64| milliseconds(seconds, DIGITS);
    let number = |value: f64| significant(value, DIGITS);
    type Show<'a> = &'a dyn Fn(&Run) -> String;
    let answer = |run: &Run| {
        document
            .answers
            .iter()
            .find(|answer| answer.model == run.model && answer.opens_when == run.opens_when)
    };
    let error = |value: Option<f64>| value.map_or_else(|| ABSENT.into(), |v| significant(v, 3));
    let rows: [(&str, Show); 18] = [
        ("Verdict alone", &|run| {
            answer(run).map_or_else(|| ABSENT.into(), |answer| answer.answer.name().into())
        }),
        ("Peak angle [rad]", &|run| number(run.peak_angle_rad)),
        ("Time of the peak [ms]", &|run| ms(run.peak_time_s)),
        ("Margin, limit − peak [rad]", &|run| {
            number(margin(threshold, run.peak_angle_rad).0)
        }),
        ("Uncertainty U of the peak [rad]", &|run| {
            error(answer(run).and_then(|answer| answer.uncertainty_rad))
        }),
        ("First crossing of the limit [ms]", &|run| {
            optional(run.first_crossing_s, &ms)
        }),
        ("Time above the limit [ms]", &|run| {
            ms(run.time_above_threshold_s)
        }),
        ("First release from the stop [ms]", &|run| {
            optional(run.first_release_s, &ms)
        }),
        ("Impacts faster than 0.001 rad/s", &|run| count(run.impacts)),
        ("Angle at the window’s end [rad]", &|run| {
            number(run.final_angle_rad)
        }),
        ("Angular velocity there [rad/s]", &|run| {
            number(run.final_velocity_rad_s)
        }),
        ("Still moving at the end", &|run| yes_no(run.moving_at_end)),
        ("Coast peak afterwards [rad]", &|run| {
            optional(run.coast_peak_angle_rad, &number)
        }),
        ("Uncertainty U of the coast peak [rad]", &|run| {
            error(answer(run).and_then(|answer| answer.coast_uncertainty_rad))
        }),
        ("Bound on the numerical error [rad]", &|run| {
            significant(run.numerical_error_rad, 3)
        }),
        ("Method", &|run| run.method.name().to_string()),
        ("Steps · evaluations", &|run| {
            format!("{} · {}", count(run.work.steps), count(run.work.rhs))
        }),
        ("Releases, impacts, contacts, rests", &|run| {
            count(run.work.events)
        }),
    ];
    for (name, show) in rows {
        page.raw("<tr>");
        page.element("th", "", name);
        for run in runs {
            let above = name.starts_with("Peak") && run.peak_angle_rad > threshold;
            let class = if above { "number above" } else { "number" };
            page.element("td", class, &show(run));
        }
        page.raw("</tr>\n");
    }
}

/// Returns the runs to compare: per polarity and stop where two polarities were judged, else
/// per stop, else the nominal one alone.
fn compared(document: &Document) -> Vec<&Run> {
    let by_polarity: Vec<&Run> = document
        .polarities
        .values()
        .flat_map(|stops| stops.values())
        .collect();
    if !by_polarity.is_empty() {
        return by_polarity;
    }
    if !document.models.is_empty() {
        return document.models.values().collect();
    }
    document.nominal.iter().collect()
}

fn is_nominal(document: &Document, run: &Run) -> bool {
    document
        .nominal
        .as_ref()
        .is_some_and(|nominal| nominal.model == run.model && nominal.opens_when == run.opens_when)
}

fn yes_no(value: bool) -> String {
    if value { "yes" } else { "no" }.into()
}

/// Writes the impacts of the nominal run.
pub(super) fn impacts(page: &mut Page, document: &Document) {
    let Some(run) = &document.nominal else {
        return;
    };
    let listed = &run.impact_list[..run.impact_list.len().min(IMPACTS_LISTED)];
    if listed.is_empty() {
        page.paragraph("The lever never struck its stop faster than 0.001 rad/s.");
        return;
    }
    let shown = &listed[..listed.len().min(IMPACTS_SHOWN)];
    let rest = &listed[shown.len()..];
    let total = count(run.impacts);
    page.paragraph(&if run.impacts == 1 {
        "The lever struck its stop once; the velocity is that before the impact.".to_string()
    } else {
        format!(
            "The lever struck its stop {total} times; velocities are those before the impact{}.",
            if rest.is_empty() {
                ""
            } else {
                ", and the first 20 impacts come first"
            }
        )
    });
    let half = shown.len().div_ceil(2).max(5);
    impact_columns(page, "sides tight", shown, 1, half);
    if !rest.is_empty() {
        page.raw("<details>\n<summary>");
        page.text(&format!("Impacts {} to {}", shown.len() + 1, listed.len()));
        page.raw("</summary>\n");
        impact_columns(
            page,
            "sides three",
            rest,
            shown.len() + 1,
            rest.len().div_ceil(3),
        );
        page.raw("</details>\n");
        page.note(&format!(
            "verdict.json lists the first {} of {total} impacts.",
            listed.len()
        ));
    }
}

fn impact_columns(page: &mut Page, class: &str, list: &[[f64; 2]], first: usize, rows: usize) {
    page.raw("<div class=\"");
    page.raw(class);
    page.raw("\">\n");
    for (column, chunk) in list.chunks(rows.max(1)).enumerate() {
        page.table("impacts", &["#No.", "#time [ms]", "#velocity [rad/s]"]);
        for (index, [at_s, velocity]) in chunk.iter().enumerate() {
            let number = first + column * rows.max(1) + index;
            page.raw("<tr>");
            page.element("td", "number", &number.to_string());
            page.element("td", "number", &milliseconds(*at_s, 6));
            page.element("td", "number", &significant(*velocity, DIGITS));
            page.raw("</tr>\n");
        }
        page.end_table();
    }
    page.raw("</div>\n");
}

/// Writes where the peak's uncertainty comes from.
pub(super) fn budget(page: &mut Page, document: &Document) {
    let Some(run) = &document.nominal else {
        return;
    };
    page.section("budget", "How sure is the largest angle");
    let (margin, _) = margin(document.threshold_rad, run.peak_angle_rad);
    page.paragraph(&format!(
        "Each part is a change of the nominal lever’s largest angle, by a rerun; distance to the \
         limit angle {}\u{00A0}rad.",
        significant(margin.abs(), 3)
    ));
    page.table(
        "budget",
        &[
            "Part",
            "What was changed",
            "#Change of the peak [rad]",
            "Against the margin",
        ],
    );
    for part in words::budget(document) {
        page.raw("<tr>");
        page.element("th", "", part.name);
        page.element("td", "", part.meaning);
        match part.value {
            Some(value) => {
                page.element("td", "number", &significant(value, 4));
                if value.abs() >= margin.abs() {
                    page.element("td", "above", "as large or larger");
                } else {
                    page.element("td", "", "smaller");
                }
            }
            None => {
                page.element("td", "number", ABSENT);
                page.element("td", "", part.absent);
            }
        }
        page.raw("</tr>\n");
    }
    page.end_table();
    if document.ensemble.is_none() && words::spared(document).is_none() {
        page.note(
            "No ensemble was run: tolerances of the design and the uncertainty of the input have \
             no part in this verdict, and small changes of either may change it.",
        );
    }
    page.end_section();
}

/// Writes a row of the bounds: its name, its value and what the recording has of it.
fn bound(page: &mut Page, name: &str, value: &str, here: &str) {
    page.raw("<tr>");
    page.element("th", "", name);
    page.element("td", "number", value);
    page.element("td", "", here);
    page.raw("</tr>\n");
}

/// Writes static and impulse threshold, and which ensembles a bound spares.
pub(super) fn screens(page: &mut Page, document: &Document) {
    let screens = &document.screens;
    page.table("bounds", &["Bound", "#Value", "Here"]);
    let peak = document
        .conditioning
        .as_ref()
        .and_then(|block| block.peak_g);
    let here = peak.map_or_else(
        || "nothing was conditioned to compare with".into(),
        |peak| {
            format!(
                "largest magnitude as used, either sign: {}\u{00A0}g",
                significant(peak, DIGITS)
            )
        },
    );
    bound(
        page,
        "Static: below this, in the opening direction, a lever at rest never leaves a rigid stop",
        &format!(
            "{}\u{00A0}g ({}\u{00A0}m/s²)",
            significant(screens.static_threshold_g, DIGITS),
            significant(screens.static_threshold_m_s2, DIGITS)
        ),
        &here,
    );
    let measured = screens.impulse_m_s.map_or_else(
        || "not measured".into(),
        |impulse| {
            let against = if impulse < screens.impulse_threshold_m_s {
                "below the bound"
            } else {
                "not below the bound, which then proves nothing"
            };
            format!(
                "measured {}\u{00A0}m/s: {against}",
                significant(impulse, DIGITS)
            )
        },
    );
    bound(
        page,
        "Impulse: the least ∫|a| dt that can bring the lever to the limit",
        &format!(
            "{}\u{00A0}m/s",
            significant(screens.impulse_threshold_m_s, DIGITS)
        ),
        &measured,
    );
    for run in &document.answers {
        if let Some(found) = run.bound {
            let name = format!(
                "{}, {}",
                words::stop(run.model),
                words::opens(run.opens_when)
            );
            let text = format!("the loosest of the varied levers {}", found.name());
            bound(page, &name, "", &text);
        }
    }
    page.end_table();
}

/// Findings of the first page.
const FINDINGS_SHOWN: usize = 5;

/// Writes what blocks or warns, and what the laboratory says; the rest is counted.
pub(super) fn main_findings(page: &mut Page, document: &Document) {
    page.section("findings", "Findings");
    let mut told: Vec<&Finding> = document
        .findings
        .iter()
        .filter(|finding| words::always_told(finding))
        .collect();
    told.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    if !told.is_empty() {
        page.raw("<ul class=\"found\">\n");
    }
    for finding in told.iter().take(FINDINGS_SHOWN) {
        page.raw("<li>");
        let class = format!("badge {}", finding.severity.name());
        page.element("span", &class, words::severity(finding.severity));
        page.raw(" ");
        page.text(&words::sentence(&finding.text));
        if let Some(at) = finding.at_s {
            page.text(&format!(" From {}.", instant(at)));
        }
        page.element("code", "", &finding.code);
        page.raw("</li>\n");
    }
    if !told.is_empty() {
        page.raw("</ul>\n");
    }
    let rest = document.findings.len() - told.len().min(FINDINGS_SHOWN);
    page.raw("<p class=\"sum\">");
    page.text(&match (told.len(), rest) {
        (0, 0) => "Nothing odd was found in the recording, its conditioning or its replay.".into(),
        (0, rest) => format!("No warnings. Notes: {rest}. "),
        (_, 0) => String::new(),
        (_, rest) => format!("Further findings: {rest}. "),
    });
    if rest > 0 {
        page.raw("<a href=\"#all-findings\">All findings</a>");
    }
    page.raw("</p>\n");
    page.end_section();
}

/// Writes the findings, the weightiest first.
pub(super) fn findings(page: &mut Page, document: &Document) {
    if document.findings.is_empty() {
        page.paragraph("Nothing odd was found in the recording, its conditioning or its replay.");
        return;
    }
    let mut findings: Vec<&Finding> = document.findings.iter().collect();
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    page.table("findings", &["Severity", "What was found", "#From"]);
    for finding in findings {
        let class = format!("badge {}", finding.severity.name());
        page.raw("<tr><td>");
        page.element("span", &class, words::severity(finding.severity));
        page.raw("</td><td>");
        page.text(&words::sentence(&finding.text));
        page.element("code", "", &finding.code);
        page.raw("</td>");
        page.element(
            "td",
            "number",
            &finding.at_s.map_or_else(|| "whole record".into(), instant),
        );
        page.raw("</tr>\n");
    }
    page.end_table();
    page.note(
        "Blocking findings forbid a pass; the verdict is unusable unless the lever was lost \
         before the data went bad. Warnings and notes change no verdict.",
    );
}
