//! The summary as one page that opens offline: a matrix of recordings and designs.

use super::pairs::{Pair, PairStanding};
use super::summary::GateSummary;
use super::text;
use crate::pipeline::Answer;
use latchgate_document::number;
use latchgate_report::escape::terminal as line;
use latchgate_report::{UNSEEN, page};
use maud::{Markup, PreEscaped, html};
use std::collections::BTreeMap;

/// Cells up to which the matrix is shown: a browser turns slow beyond.
const CELLS_MAX: usize = 20_000;

/// Designs up to which a matrix fits on an upright sheet.
const UPRIGHT_DESIGNS_MAX: usize = 8;

/// Designs up to which it fits on a sheet at all.
const PRINTED_DESIGNS_MAX: usize = 20;

/// Recordings up to which the matrix stands above the lists.
const FIRST_RECORDINGS_MAX: usize = 100;

/// Largest number of pairs in a list.
const LISTED: usize = 50;

/// The page's own rules, beside those of a report.
const STYLE: &str = include_str!("page.css");

/// Sorting and filtering; the page is complete without it.
const SCRIPT: &str = include_str!("page.js");

/// Folders of full reports, relative to the page, by the number of their pair.
pub type ReportFolders = BTreeMap<usize, String>;

/// Returns the page.
pub fn render(summary: &GateSummary, reports: &ReportFolders) -> String {
    let frame = page::PageFrame {
        title: &format!("latchgate gate {}", summary.gate),
        identity: "gate",
        style: STYLE,
        script: SCRIPT,
    };
    // A short matrix is the answer at a glance; a long one is a table to look things up in.
    let matrix_first = summary.recordings.len() <= FIRST_RECORDINGS_MAX;
    let body = html! {
        main.wide {
            header { h1 { "Gate " (line(&summary.gate)) } p.id { "latchgate " (summary.version) } }
            (answer(summary))
            @if matrix_first { (matrix(summary, reports)) (lists(summary, reports)) }
            @else { (lists(summary, reports)) (matrix(summary, reports)) }
        }
    };
    frame.head() + &body.into_string() + &frame.tail()
}

fn answer(summary: &GateSummary) -> Markup {
    let (tone, answer) = if summary.exit_code == 0 {
        ("pass", "Passed")
    } else {
        ("fail", "Not passed")
    };
    html! {
        section.card.(tone) aria-label="Answer" {
            div.answer { div { strong { (answer) } span { (line(&text::headline(summary))) } } }
            @if !summary.statics.is_empty() {
                ul { @for standing in &summary.statics { li { "Static: " (line(&standing.text())) } } }
            }
            @if !summary.problems.is_empty() {
                ul.why {
                    @for problem in &summary.problems { li { (line(&problem.text)) " " code { (problem.code) } } }
                }
            }
            (counts(summary))
            @for design in text::repeated_designs(summary) { p.note { "Designs: " (line(&design)) "." } }
            @if summary.counts.pass > 0 { p.note { "Not seen: " (UNSEEN) "." } }
        }
    }
}

fn counts(summary: &GateSummary) -> Markup {
    let counts = &summary.counts;
    let (recordings, designs) = (summary.recordings.len(), summary.designs.len());
    html! {
        dl.key {
            @for (what, count) in [
                (if recordings == 1 { "recording" } else { "recordings" }, recordings),
                (if designs == 1 { "design" } else { "designs" }, designs),
                ("as required", counts.as_required),
                ("not as required", counts.not_as_required),
                ("pass", counts.pass),
                ("fail", counts.fail),
                ("undecided", counts.undecided),
                ("unusable", counts.unusable),
            ] {
                div { dt { (what) } dd.value { (number::count(count as u64)) } }
            }
        }
    }
}

/// Returns the pairs that need attention, a list for each kind, and the changes since the baseline.
fn lists(summary: &GateSummary, reports: &ReportFolders) -> Markup {
    let allowed = summary.with_standing(PairStanding::Allowed);
    let no_worse = summary.with_standing(PairStanding::NoWorse);
    html! {
        (list(summary, reports, "worst", "Not as required, the worst first", &summary.worst()))
        (list(summary, reports, "exceptions", "Let through by an exception", &allowed))
        (list(summary, reports, "no-worse", "Not as required, but no worse than the baseline", &no_worse))
        (changes(summary))
    }
}

fn list(
    summary: &GateSummary,
    reports: &ReportFolders,
    id: &str,
    title: &str,
    numbers: &[usize],
) -> Markup {
    if numbers.is_empty() {
        return html! {};
    }
    let has_report = |number: &&usize| reports.contains_key(number);
    let reported = numbers.iter().filter(has_report).count();
    let mut groups = text::grouped(&summary.pairs, numbers);
    groups.truncate(LISTED);
    let shown: usize = groups.iter().map(|group| group.numbers.len()).sum();
    html! {
        section id=(id) {
            h2 { (title) }
            @if (1..numbers.len()).contains(&reported) {
                p.note { "The first " (reported) " of " (numbers.len()) " have a full report." }
            }
            table.pairs {
                thead { tr { th { "answer" } th { "recording" } th { "design" } th { "what" } th { "report" } } }
                tbody {
                    @for group in &groups {
                        tr {
                            td { (badge(group.worst.row.verdict)) }
                            td { (line(&group.worst.recording)) }
                            td { (line(&group.designs(summary))) }
                            td { (line(&group.description(summary))) }
                            td {
                                @if let Some(folder) = group.numbers.iter().find_map(|number| reports.get(number)) {
                                    a href={ (folder) "/report.html" } { "open" }
                                }
                            }
                        }
                    }
                }
            }
            @if numbers.len() > shown {
                p.note { (text::counted(numbers.len() - shown, "further pair")) " in summary.csv." }
            }
        }
    }
}

/// An answer with its sign, so that the page can be read without colours.
fn badge(verdict: Answer) -> Markup {
    html! { span.badge.(verdict.name()) { (text::glyph(verdict)) " " (verdict.name()) } }
}

fn changes(summary: &GateSummary) -> Markup {
    let Some(baseline) = &summary.baseline else {
        return html! {};
    };
    let names = |pairs: &[(String, String)]| {
        let names = pairs.iter().take(LISTED);
        let names = names.map(|(recording, design)| format!("{recording} with {design}"));
        names.collect::<Vec<_>>().join(", ")
    };
    html! {
        section #baseline {
            h2 { "Since the baseline" }
            table.facts {
                tbody {
                    @for (what, pairs) in [
                        ("Newly failing", &baseline.newly_failing),
                        ("Fixed", &baseline.fixed),
                        ("Added", &baseline.added),
                        ("Gone", &baseline.removed),
                    ] {
                        tr { th { (what) } td { (pairs.len()) " " (line(&names(pairs))) } }
                    }
                }
            }
            @if !baseline.moved.is_empty() {
                h3 { "Margins that moved by more than their uncertainty" }
                table.pairs {
                    thead { tr { th { "recording" } th { "design" } th.number { "before [rad]" } th.number { "now [rad]" } } }
                    tbody {
                        @for moved in baseline.moved.iter().take(LISTED) {
                            tr {
                                td { (line(&moved.recording)) }
                                td { (line(&moved.design)) }
                                td.number { (number::significant(moved.margin_before_rad, 4)) }
                                td.number { (number::significant(moved.margin_now_rad, 4)) }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Returns all pairs, a row per recording.
fn matrix(summary: &GateSummary, reports: &ReportFolders) -> Markup {
    let designs = summary.designs.len().max(1);
    if summary.pairs.len() > CELLS_MAX {
        return html! {
            section #matrix {
                h2 { "Recordings and designs" }
                p.note { "Too many pairs to show at once; summary.csv has all." }
            }
        };
    }
    let rows = summary.recordings.iter().zip(summary.pairs.chunks(designs));
    let many = designs > PRINTED_DESIGNS_MAX;
    html! {
        section #matrix .wide[designs > UPRIGHT_DESIGNS_MAX] {
            h2 { "Recordings and designs" }
            p.note {
                "Each cell shows the answer and the margin: how far the nominal lever's largest \
                 angle plus its error stays below the limit angle, "
                "in percent of the limit. A ring marks what is not as required."
            }
            div.tools hidden {
                label { "Recordings " input type="search" id="filter" placeholder="part of a name"; } " "
                label { input type="checkbox" id="only"; " only what is not as required" } " "
                button type="button" id="by-name" { "by name" } " "
                button type="button" id="by-worst" { "worst first" } " "
                span #shown role="status" {}
            }
            @if many {
                p.paper.note { "The matrix is too wide to print; summary.csv has every pair." }
            }
            div.scroll.unprinted[many] tabindex="0" role="region" aria-label="Matrix of recordings and designs" {
                table.matrix {
                    thead {
                        tr {
                            th scope="col" { "recording" }
                            @for design in &summary.designs { th scope="col" { (line(&design.name)) } }
                        }
                    }
                    tbody {
                        @for (row, (recording, pairs)) in rows.enumerate() {
                            (matrix_row(&recording.name, pairs, row * designs, reports))
                        }
                    }
                }
            }
        }
    }
}

/// Returns a row of the matrix; `first` is the number of its first pair.
fn matrix_row(name: &str, pairs: &[Pair], first: usize, reports: &ReportFolders) -> Markup {
    let bad = pairs.iter().any(|pair| pair.exit_code() != 0);
    let margins = pairs.iter().filter_map(|pair| pair.row.margin());
    let least = margins.fold(f64::INFINITY, f64::min).clamp(-1e6, 1e6);
    html! {
        tr data-name=(line(name)) data-bad=(u8::from(bad)) data-margin=(format!("{least:.4}")) {
            th scope="row" { (line(name)) }
            @for (number, pair) in (first..).zip(pairs) { (cell(pair, reports.get(&number))) }
        }
        (PreEscaped("\n"))
    }
}

fn cell(pair: &Pair, report: Option<&String>) -> Markup {
    let verdict = pair.row.verdict;
    let (recording, design) = (&pair.recording, &pair.design);
    let title = format!(
        "{recording} with {design}: {}, {}",
        verdict.name(),
        text::describe(pair)
    );
    let inner = html! { span aria-hidden="true" { (text::glyph(verdict)) } " " (percent(pair)) };
    html! {
        td class={ (verdict.name()) " m" (shade(pair)) } .bad[pair.exit_code() != 0] title=(line(&title)) {
            @if let Some(folder) = report { a href={ (folder) "/report.html" } { (inner) } } @else { (inner) }
        }
    }
}

/// One of five shades by the margin: 0 beyond the limit or without a peak, 4 far below it.
fn shade(pair: &Pair) -> u8 {
    match pair.row.margin() {
        Some(margin) if margin > 0.75 => 4,
        Some(margin) if margin > 0.5 => 3,
        Some(margin) if margin > 0.25 => 2,
        Some(margin) if margin > 0.0 => 1,
        _ => 0,
    }
}

fn percent(pair: &Pair) -> String {
    match pair.row.margin() {
        Some(margin) if margin < -9.99 => "< \u{2212}999 %".into(),
        Some(margin) => {
            // Rounded down: a rounded-up margin would show a distance that is not there.
            let text = format!("{:.0}", (100.0 * margin).floor());
            format!("{} %", text.replace('-', "\u{2212}"))
        }
        None => number::ABSENT.into(),
    }
}
