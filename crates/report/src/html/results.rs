//! What the runs say: comparison, impacts, error budget, bounds, findings.
//!
//! Each function returns a part of the page, made from the document's blocks on runs.

use super::markup::{heads, stop_and_sign};
use crate::escape::terminal as line;
use crate::statics::{g, part};
use crate::words::{self, DIGITS, instant, margin};
use latchgate_document::Document;
use latchgate_document::number::{ABSENT, count, milliseconds, significant};
use latchgate_kernel::replay::Run;
use latchgate_recording::{Finding, Severity};
use latchgate_verdict::Mechanism;
use latchgate_verdict::statics::REQUIRED_G;
use maud::{Markup, html};
use std::f64::consts::FRAC_PI_2;

/// Rows of the impacts table that are always shown.
const IMPACTS_SHOWN: usize = 20;

/// Largest number of impacts listed.
const IMPACTS_LISTED: usize = 200;

/// Text in place of findings.
pub(super) const NO_FINDINGS: &str =
    "Nothing odd was found in the recording, its conditioning or its replay.";

/// Returns the runs side by side.
pub(super) fn runs(document: &Document) -> Markup {
    let runs = compared(document);
    let columns: Vec<_> = runs.iter().map(|run| quantities(document, run)).collect();
    let Some(first) = columns.first() else {
        return html! {};
    };
    let threshold = document.threshold_rad;
    html! {
        table.runs {
            thead {
                tr {
                    th scope="col" { "Quantity" }
                    @for run in &runs {
                        th.number scope="col" {
                            (stop_and_sign(run.model, run.opens_when))
                            @if is_nominal(document, run) { " (nominal)" }
                        }
                    }
                }
            }
            tbody {
                @for (row, (name, _)) in first.iter().enumerate() {
                    tr {
                        th { (name) }
                        @for (run, column) in runs.iter().zip(&columns) {
                            @let above = name.starts_with("Peak") && run.peak_angle_rad > threshold;
                            td.number .above[above] { (column[row].1) }
                        }
                    }
                }
            }
        }
        @if document.models.len() < 2 {
            p.note {
                "Stop model asked for: " (document.request.model.name()) ". Only the stops shown were run."
            }
        }
    }
}

/// Returns the quantities of a run, names with values.
fn quantities(document: &Document, run: &Run) -> [(&'static str, String); 18] {
    let answer = document.answer_of(run);
    let verdict = answer.map_or(ABSENT, |answer| answer.answer.name());
    let number = |value: f64| significant(value, DIGITS);
    let degrees = |radians: f64| words::degrees_cell(radians, DIGITS);
    // What cannot be computed is told with three digits nowhere.
    let known = |text: String| match words::has_figure(document, run) {
        true => text,
        false => "not known".into(),
    };
    let ms = |seconds: f64| milliseconds(seconds, DIGITS);
    let optional = |value: Option<String>| value.unwrap_or_else(|| "none".into());
    let error =
        |value: Option<f64>| value.map_or_else(|| ABSENT.into(), |v| words::degrees_cell(v, 3));
    let uncertainty = answer.and_then(|answer| answer.uncertainty_rad);
    let coast_uncertainty = answer.and_then(|answer| answer.coast_uncertainty_rad);
    let margin = margin(document.threshold_rad, run.peak_angle_rad).0;
    let moving = if run.moving_at_end { "yes" } else { "no" };
    let work = &run.work;
    [
        ("Answer of this run", verdict.into()),
        ("Peak angle [°]", known(degrees(run.peak_angle_rad))),
        ("Time of the peak [ms]", known(ms(run.peak_time_s))),
        (
            "Margin, limit − peak [°]",
            // A peak beyond 90° has no figure, and so no share of the limit.
            if run.peak_angle_rad > FRAC_PI_2 {
                "none".into()
            } else {
                known(degrees(margin))
            },
        ),
        ("Uncertainty U of the peak [°]", error(uncertainty)),
        (
            "First crossing of the limit [ms]",
            optional(run.first_crossing_s.map(ms)),
        ),
        ("Time above the limit [ms]", ms(run.time_above_threshold_s)),
        (
            "First release from the stop [ms]",
            optional(run.first_release_s.map(ms)),
        ),
        ("Impacts faster than 0.001 rad/s", count(run.impacts)),
        (
            "Angle at the window’s end [°]",
            known(degrees(run.final_angle_rad)),
        ),
        (
            "Angular velocity there [rad/s]",
            known(number(run.final_velocity_rad_s)),
        ),
        ("Still moving at the end", moving.into()),
        (
            "Coast peak afterwards [°]",
            optional(run.coast_peak_angle_rad.map(degrees)),
        ),
        (
            "Uncertainty U of the coast peak [°]",
            error(coast_uncertainty),
        ),
        (
            "Bound on the numerical error [rad]",
            significant(run.numerical_error_rad, 3),
        ),
        ("Method", run.method.name().to_string()),
        (
            "Steps · evaluations",
            format!("{} · {}", count(work.steps), count(work.rhs)),
        ),
        ("Releases, impacts, contacts, rests", count(work.events)),
    ]
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

/// Returns the impacts of the nominal run.
pub(super) fn impacts(document: &Document) -> Markup {
    let Some(run) = &document.nominal else {
        return html! {};
    };
    let listed = &run.impact_list[..run.impact_list.len().min(IMPACTS_LISTED)];
    if listed.is_empty() {
        return html! { p { "The lever never struck its stop faster than 0.001 rad/s." } };
    }
    let (shown, folded) = listed.split_at(listed.len().min(IMPACTS_SHOWN));
    let total = count(run.impacts);
    let next = shown.len() + 1;
    html! {
        p {
            @if run.impacts == 1 {
                "The lever struck its stop once; the velocity is that before the impact."
            } @else {
                "The lever struck its stop " (total) " times; velocities are those before the impact"
                @if !folded.is_empty() { ", and the first 20 impacts come first" }
                "."
            }
        }
        (impact_columns("tight", shown, 1, shown.len().div_ceil(2).max(5)))
        @if !folded.is_empty() {
            details {
                summary { "Impacts " (next) " to " (listed.len()) }
                (impact_columns("three", folded, next, folded.len().div_ceil(3)))
            }
            @if (listed.len() as u64) < run.impacts {
                p.note { "verdict.json lists the first " (listed.len()) " of " (total) " impacts." }
            }
        }
    }
}

/// Returns impacts in columns of `rows`; `first` is the number of the first one.
fn impact_columns(class: &str, list: &[[f64; 2]], first: usize, rows: usize) -> Markup {
    let mut numbers = first..;
    html! {
        div.sides.(class) {
            @for column in list.chunks(rows.max(1)) {
                table.impacts {
                    (heads(&["#No.", "#time [ms]", "#velocity [rad/s]"]))
                    tbody {
                        @for ([time_s, velocity], number) in column.iter().zip(&mut numbers) {
                            tr {
                                td.number { (number) }
                                td.number { (milliseconds(*time_s, 6)) }
                                td.number { (significant(*velocity, DIGITS)) }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Returns the parts of the peak's uncertainty.
pub(super) fn budget(document: &Document) -> Markup {
    let Some(run) = &document.nominal else {
        return html! {};
    };
    let margin = margin(document.threshold_rad, run.peak_angle_rad).0.abs();
    // Beyond a quarter turn the size of the peak means nothing, and so do its parts.
    let is_beyond = run.peak_angle_rad > FRAC_PI_2;
    let counted = words::uncertainty(document, run);
    let of = |run: &Run| match document.polarities.len() {
        0 | 1 => run.model.label().to_string(),
        _ => stop_and_sign(run.model, run.opens_when),
    };
    html! {
        section #budget {
            h2 { "Uncertainty of the largest angle" }
            table.budget {
                (heads(&["Part", "What was changed", "#Change [°]", "Against the distance to the limit"]))
                tbody {
                    @for part in words::budget(document) {
                        tr {
                            th { (part.name) }
                            td { (part.meaning) }
                            @if let Some(value) = part.value {
                                td.number { (words::degrees_cell(value, 3)) }
                                @if is_beyond { td { (ABSENT) } }
                                @else if value.abs() >= margin { td.above { "as large or larger" } } @else { td { "smaller" } }
                            } @else {
                                td.number { (ABSENT) }
                                td { (part.absent) }
                            }
                        }
                    }
                    tr.nominal {
                        th { "U" }
                        td { "the sum of the first three (" (of(run)) ")" }
                        td.number { (counted.map_or_else(|| ABSENT.into(), |error| words::degrees_cell(error, 3))) }
                        @if is_beyond || counted.is_none() { td { (ABSENT) } }
                        @else if counted.is_some_and(|error| error >= margin) { td.above { "as large or larger" } }
                        @else { td { "smaller" } }
                    }
                }
            }
            @if document.ensemble.is_none() && words::sparing_bound(document).is_none() {
                p.note {
                    "No ensemble was run: tolerances of the design and the uncertainty of the input have "
                    "no part in this verdict, and small changes of either may change it."
                }
            }
        }
    }
}

/// Returns the recording as a sled pulse, where that was requested.
pub(super) fn sled(document: &Document) -> Markup {
    html! {
        @if let Some(check) = &document.sled206 {
            section #sled206 {
                h2 { "As a sled pulse" }
                ul { @for text in check.sentences() { li { (line(&text)) } } }
            }
        }
    }
}

/// Returns static and impulse threshold, and which ensembles a bound spares.
pub(super) fn screens(document: &Document) -> Markup {
    let screens = &document.screens;
    let conditioning = document.conditioning.as_ref();
    let peak_g = conditioning.and_then(|block| block.peak_g);
    html! {
        table.bounds {
            (heads(&["Bound", "#Value", "Here"]))
            tbody {
                tr {
                    th { "Static: below this, in the opening direction, a lever at rest never leaves a rigid stop" }
                    td.number {
                        (significant(screens.static_threshold_g, DIGITS)) "\u{00A0}g ("
                        (significant(screens.static_threshold_m_s2, DIGITS)) "\u{00A0}m/s²)"
                    }
                    td {
                        @if let Some(peak) = peak_g {
                            "largest magnitude as used, either sign: " (significant(peak, DIGITS)) "\u{00A0}g"
                        } @else {
                            "nothing was conditioned to compare with"
                        }
                    }
                }
                @for (what, level) in [
                    ("Static by SAE J839: the spring's average over the way to the limit", Some(screens.j839_threshold_g)),
                    ("Static, held at the limit, the arm turned with the lever", screens.hold_threshold_g),
                    ("A step for good, undamped, in its worst direction", screens.step_threshold_g),
                ] {
                    @if let Some(level) = level {
                        tr { th { (what) } td.number { (significant(level, DIGITS)) "\u{00A0}g" } td {} }
                    }
                }
                @if let Some(Mechanism::InertiaCatch { lift_off_g, speed_ratio, .. }) = &document.mechanism {
                    tr {
                        th { "Inertia catch: below this, in the opening direction, it never leaves its rest stop" }
                        td.number { @if let Some(level) = lift_off_g { (significant(*level, DIGITS)) "\u{00A0}g" } @else { "none" } }
                        td { "to be less than the lever's, or the lever is off its stop first" }
                    }
                    tr {
                        th { "Inertia catch: speed ratio χ = (S₂/(I₂ψb))/(S₁/(I₁φb))" }
                        td.number { @if let Some(ratio) = speed_ratio { (significant(*ratio, DIGITS)) } @else { "none" } }
                        td { "from 1 on the catch is first in a blow from rest; a rebound only the replay finds" }
                    }
                }
                tr {
                    th { "What counts of it in any direction, with gravity where that opens or is not known (UN R11 Annex 4, 2.1; SAE J839)" }
                    td.number { (g(screens.static_counts_g)) }
                    td { (part(screens.static_counts_g / REQUIRED_G)) " of the 30\u{00A0}g required" }
                }
                tr {
                    th { "Impulse: the least ∫|a| dt that can bring the lever to the limit" }
                    td.number { (significant(screens.impulse_threshold_m_s, DIGITS)) "\u{00A0}m/s" }
                    td {
                        @if let Some(impulse) = screens.impulse_m_s {
                            "measured " (significant(impulse, DIGITS)) "\u{00A0}m/s: "
                            @if impulse < screens.impulse_threshold_m_s { "below the bound" }
                            @else { "not below the bound, which then proves nothing" }
                        } @else {
                            "not measured"
                        }
                    }
                }
                @for run in &document.answers {
                    @if let Some(bound) = run.bound {
                        tr {
                            th { (stop_and_sign(run.model, run.opens_when)) }
                            td.number {}
                            td { "the worst of the varied levers " (bound.name()) }
                        }
                    }
                }
            }
        }
    }
}

/// Findings of the first page.
const FINDINGS_SHOWN: usize = 5;

/// Returns the findings that block or warn, and the laboratory's remarks; the others are counted.
pub(super) fn main_findings(document: &Document) -> Markup {
    let findings = document.findings.iter();
    let mut main: Vec<&Finding> = findings
        .filter(|finding| words::is_always_shown(finding))
        .collect();
    main.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    let hidden = document.findings.len() - main.len().min(FINDINGS_SHOWN);
    html! {
        section #findings {
            h2 { "Findings" }
            @if !main.is_empty() {
                ul.found {
                    @for finding in main.iter().take(FINDINGS_SHOWN) {
                        li {
                            (badge(finding.severity)) " " (line(&words::sentence(&finding.text)))
                            @if let Some(start_s) = finding.at_s { " From " (instant(start_s)) "." }
                            code { (line(&finding.code)) }
                        }
                    }
                }
            }
            p.sum {
                @match (main.is_empty(), hidden) {
                    (true, 0) => (NO_FINDINGS),
                    (true, _) => { "No warnings. Notes: " (hidden) ". " }
                    (false, 0) => {}
                    (false, _) => { "Further findings: " (hidden) ". " }
                }
                @if hidden > 0 {
                    a.screen href="#all-findings" { "All findings" }
                    span.paper { "They stand on the page, under All findings, and in verdict.json." }
                }
            }
        }
    }
}

/// Returns the findings, the most severe first.
pub(super) fn findings(document: &Document) -> Markup {
    if document.findings.is_empty() {
        return html! { p { (NO_FINDINGS) } };
    }
    let mut findings: Vec<&Finding> = document.findings.iter().collect();
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    html! {
        table.findings {
            (heads(&["Severity", "What was found", "#From"]))
            tbody {
                @for finding in findings {
                    tr {
                        td { (badge(finding.severity)) }
                        td { (line(&words::sentence(&finding.text))) code { (line(&finding.code)) } }
                        td.number { (finding.at_s.map_or_else(|| "whole record".into(), instant)) }
                    }
                }
            }
        }
        p.note {
            "Blocking findings forbid a pass; the verdict is unusable unless the lever was lost before "
            "the data went bad. A pass waits while a warning asks for a person's word; other warnings and notes change no verdict."
        }
    }
}

fn badge(severity: Severity) -> Markup {
    html! { span.badge.(severity.name()) { (words::severity(severity)) } }
}
