//! The summary as one page that opens offline: a matrix of recordings and designs.

use super::pairs::{Pair, PairStanding};
use super::summary::{GateSummary, unwritten};
use super::text;
use crate::pipeline::Answer;
use latchgate_document::number;
use latchgate_recording::error::Error;
use latchgate_report::{UNSEEN, escape, page};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::io;

/// Cells up to which the whole matrix is shown; beyond, the worst of each recording and design.
const CELLS_MAX: usize = 50_000;

/// Designs up to which a matrix fits on an upright sheet.
const UPRIGHT_DESIGNS_MAX: usize = 8;

/// Designs up to which it fits on a sheet at all.
const PRINTED_DESIGNS_MAX: usize = 20;

/// Recordings up to which the matrix stands above the lists.
const FIRST_RECORDINGS_MAX: usize = 100;

/// Pairs that are listed.
const LISTED: usize = 50;

/// The page's own rules, beside those of a report.
const STYLE: &str = include_str!("page.css");

/// Sorting and filtering; the page is complete without it.
const SCRIPT: &str = include_str!("page.js");

/// Folders of full reports, relative to the page, by the number of their pair.
pub type ReportFolders = BTreeMap<usize, String>;

/// Writes the page.
///
/// # Errors
///
/// [`latchgate_recording::error::ErrorKind::Io`] if it cannot be written, or a decision no longer be read.
pub fn write(
    summary: &GateSummary,
    reports: &ReportFolders,
    file: &mut dyn io::Write,
) -> Result<(), Error> {
    let mut out = String::new();
    let frame = page::PageFrame {
        title: &format!("latchgate gate {}", summary.gate),
        style: STYLE,
        script: SCRIPT,
    };
    out.push_str(&frame.head());
    let (tone, answer) = if summary.exit_code == 0 {
        ("pass", "Passed")
    } else {
        ("fail", "Not passed")
    };
    let _ = write!(
        out,
        "<main class=\"wide\">\n<header><h1>Gate {}</h1><p class=\"id\">latchgate {}</p></header>\n\
         <section class=\"card {tone}\" aria-label=\"Answer\"><div class=\"answer\"><div><strong>{answer}</strong><span>{}</span></div></div>",
        escape::markup(&summary.gate),
        escape::markup(&summary.version),
        escape::markup(&text::headline(summary))
    );
    if !summary.problems.is_empty() {
        out.push_str("<ul class=\"why\">");
        for problem in &summary.problems {
            let _ = write!(
                out,
                "<li>{} <code>{}</code></li>",
                escape::markup(&problem.text),
                escape::markup(&problem.code)
            );
        }
        out.push_str("</ul>");
    }
    counts(&mut out, summary);
    if summary.counts.pass > 0 {
        let _ = write!(out, "<p class=\"note\">Not seen: {UNSEEN}.</p>");
    }
    out.push_str("</section>\n");
    let mut put = |text: &str| file.write_all(text.as_bytes()).map_err(unwritten);
    put(&out)?;
    // A matrix that is seen at once is the answer; a long one is looked up.
    let first = has_matrix(summary) && summary.recordings.len() <= FIRST_RECORDINGS_MAX;
    if first {
        all_pairs(summary, reports, &mut put)?;
    }
    put(&lists(summary, reports)?)?;
    if !first {
        all_pairs(summary, reports, &mut put)?;
    }
    put("</main>\n")?;
    put(&frame.tail())
}

/// Returns the pairs that stand out, a list for each way, and what changed since the baseline.
fn lists(summary: &GateSummary, reports: &ReportFolders) -> Result<String, Error> {
    let mut out = String::new();
    for (id, title, standing) in [
        (
            "worst",
            "Not as required, the worst first",
            PairStanding::NotAsRequired,
        ),
        (
            "exceptions",
            "Let through by an exception",
            PairStanding::Allowed,
        ),
        (
            "no-worse",
            "Not as required, but no worse than the baseline",
            PairStanding::NoWorse,
        ),
    ] {
        let (numbers, all) = summary.standing(standing);
        if !numbers.is_empty() {
            let _ = write!(out, "<section id=\"{id}\">\n<h2>{title}</h2>\n");
            let told = numbers.iter().filter(|number| reports.contains_key(number));
            let told = told.count();
            if (1..all).contains(&told) {
                let _ = writeln!(
                    out,
                    "<p class=\"note\">The first {told} of {all} have a full report.</p>"
                );
            }
            list(&mut out, summary, (&numbers, all), reports)?;
        }
    }
    changes(&mut out, summary);
    Ok(out)
}

/// Writes the matrix, or of very many pairs the worst.
fn all_pairs(
    summary: &GateSummary,
    reports: &ReportFolders,
    put: &mut impl FnMut(&str) -> Result<(), Error>,
) -> Result<(), Error> {
    put(&matrix_head(summary))?;
    if has_matrix(summary) {
        matrix(summary, reports, put)?;
    } else {
        worst_of_each(summary, put)?;
    }
    put("</section>\n")
}

fn counts(out: &mut String, summary: &GateSummary) {
    let counts = &summary.counts;
    out.push_str("<dl class=\"key\">");
    for (what, count) in [
        ("recording", summary.recordings.len()),
        ("design", summary.designs.len()),
        ("as required", counts.as_required),
        ("not as required", counts.not_as_required),
        ("pass", counts.pass),
        ("fail", counts.fail),
        ("undecided", counts.undecided),
        ("unusable", counts.unusable),
    ] {
        // Of answers it is said how many there are, of things what they are.
        let many = matches!(what, "recording" | "design") && count != 1;
        let many = if many { "s" } else { "" };
        let _ = write!(
            out,
            "<div><dt>{what}{many}</dt><dd class=\"value\">{}</dd></div>",
            number::count(count as u64)
        );
    }
    out.push_str("</dl>");
}

fn list(
    out: &mut String,
    summary: &GateSummary,
    (numbers, all): (&[usize], usize),
    reports: &ReportFolders,
) -> Result<(), Error> {
    out.push_str(
        "<table class=\"pairs\"><thead><tr><th>answer</th><th>recording</th>\
         <th>design</th><th>what</th><th>report</th></tr></thead>\n<tbody>\n",
    );
    let mut shown = 0;
    for alike in text::told_alike(&summary.pairs, numbers, LISTED)? {
        let pair = &alike.first;
        let report = alike.numbers.iter().find_map(|number| reports.get(number));
        let link = report.map_or_else(String::new, |folder| {
            format!(
                "<a href=\"{}/report.html\">open</a>",
                escape::markup(folder)
            )
        });
        let _ = writeln!(
            out,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{link}</td></tr>",
            answer(pair.row.verdict),
            escape::markup(&pair.recording),
            escape::markup(&alike.designs(summary)),
            escape::markup(&text::what(pair))
        );
        shown += alike.numbers.len();
    }
    out.push_str("</tbody></table>\n");
    if all > shown {
        let _ = writeln!(
            out,
            "<p class=\"note\">{} in {}.</p>",
            text::counted(all - shown, "further pair"),
            summary.rest()
        );
    }
    out.push_str("</section>\n");
    Ok(())
}

/// An answer with its sign, so that colour is not all that tells.
fn answer(verdict: Answer) -> String {
    format!(
        "<span class=\"badge {0}\">{1} {0}</span>",
        verdict.name(),
        text::glyph(verdict)
    )
}

fn changes(out: &mut String, summary: &GateSummary) {
    let Some(baseline) = &summary.baseline else {
        return;
    };
    out.push_str(
        "<section id=\"baseline\">\n<h2>Since the baseline</h2>\n<table class=\"facts\"><tbody>\n",
    );
    for (what, pairs) in [
        ("Newly failing", &baseline.newly_failing),
        ("Fixed", &baseline.fixed),
        ("Added", &baseline.added),
        ("Gone", &baseline.removed),
    ] {
        let names: Vec<String> = pairs
            .iter()
            .take(LISTED)
            .map(|(recording, design)| {
                escape::markup(&format!("{recording} with {design}")).into_owned()
            })
            .collect();
        let _ = writeln!(
            out,
            "<tr><th>{what}</th><td>{} {}</td></tr>",
            pairs.len(),
            names.join(", ")
        );
    }
    out.push_str("</tbody></table>\n");
    if !baseline.moved.is_empty() {
        out.push_str(
            "<h3>Margins that moved by more than their uncertainty</h3>\n<table class=\"pairs\"><thead><tr><th>recording</th><th>design</th>\
             <th class=\"number\">before [rad]</th><th class=\"number\">now [rad]</th></tr></thead><tbody>\n",
        );
        for moved in baseline.moved.iter().take(LISTED) {
            let _ = writeln!(
                out,
                "<tr><td>{}</td><td>{}</td><td class=\"number\">{}</td><td class=\"number\">{}</td></tr>",
                escape::markup(&moved.recording),
                escape::markup(&moved.design),
                number::significant(moved.margin_before_rad, 4),
                number::significant(moved.margin_now_rad, 4)
            );
        }
        out.push_str("</tbody></table>\n");
    }
    out.push_str("</section>\n");
}

/// Tells whether every pair is shown.
fn has_matrix(summary: &GateSummary) -> bool {
    summary.pairs.is_whole() && summary.pairs.len() <= CELLS_MAX
}

fn matrix_head(summary: &GateSummary) -> String {
    let whole = has_matrix(summary);
    let wide = if whole && summary.designs.len() > UPRIGHT_DESIGNS_MAX {
        " class=\"wide\""
    } else {
        ""
    };
    format!(
        "<section id=\"matrix\"{wide}>\n<h2>Recordings and designs</h2>\n<p class=\"note\">Each cell holds the answer and the margin: how far \
         the nominal peak stays below the limit angle, its error taken off, in percent of the limit. A ring marks what is not as required.{}</p>\n\
         <div class=\"tools\" hidden><label>Recordings <input type=\"search\" id=\"filter\" placeholder=\"part of a name\"></label> \
         <label><input type=\"checkbox\" id=\"only\"> only what is not as required</label> \
         <button type=\"button\" id=\"by-name\">by name</button> <button type=\"button\" id=\"by-worst\">worst first</button> \
         <span id=\"shown\" role=\"status\"></span></div>\n",
        if whole {
            ""
        } else {
            " Of this many pairs only the worst of each recording and of each design are shown."
        }
    )
}

/// Writes a list of the worst pair of each recording and of each design.
fn worst_of_each(
    summary: &GateSummary,
    put: &mut impl FnMut(&str) -> Result<(), Error>,
) -> Result<(), Error> {
    let pairs = &summary.pairs;
    let designs = summary.designs.len().max(1);
    // Of each design, then of each recording.
    let mut worst: Vec<Option<usize>> = vec![None; designs];
    for number in 0..pairs.len() {
        let (recording, design) = (pairs.place(number) / designs, pairs.place(number) % designs);
        worst.resize(worst.len().max(designs + recording + 1), None);
        for place in [design, designs + recording] {
            let held = worst[place].get_or_insert(number);
            if pairs.rank(number) < pairs.rank(*held) {
                *held = number;
            }
        }
    }
    put(
        "<table class=\"pairs\"><thead><tr><th>answer</th><th>recording</th><th>design</th><th>margin</th></tr></thead><tbody>\n",
    )?;
    let ranked: BTreeSet<_> = worst
        .into_iter()
        .flatten()
        .map(|number| pairs.rank(number))
        .collect();
    for (_, _, number) in ranked {
        let pair = pairs.get(number)?;
        put(&format!(
            "<tr data-name=\"{1}\"><td>{0}</td><td>{1}</td><td>{2}</td><td class=\"number\">{3}</td></tr>\n",
            answer(pair.row.verdict),
            escape::markup(&pair.recording),
            escape::markup(&pair.design),
            percent(&pair)
        ))?;
    }
    put("</tbody></table>\n")
}

/// Writes the whole matrix, a row per recording.
fn matrix(
    summary: &GateSummary,
    reports: &ReportFolders,
    put: &mut impl FnMut(&str) -> Result<(), Error>,
) -> Result<(), Error> {
    let many = summary.designs.len() > PRINTED_DESIGNS_MAX;
    if many {
        put(
            "<p class=\"paper note\">The matrix is too wide to be printed; summary.json holds every pair.</p>\n",
        )?;
    }
    put(if many {
        "<div class=\"scroll unprinted\""
    } else {
        "<div class=\"scroll\""
    })?;
    put(
        " tabindex=\"0\" role=\"region\" aria-label=\"Matrix of recordings and designs\"><table class=\"matrix\"><thead><tr><th scope=\"col\">recording</th>",
    )?;
    for design in &summary.designs {
        put(&format!(
            "<th scope=\"col\">{}</th>",
            escape::markup(&design.name)
        ))?;
    }
    put("</tr></thead>\n<tbody>\n")?;
    let designs = summary.designs.len();
    for (row, recording) in summary.recordings.iter().enumerate() {
        let first = row * designs;
        let cells = summary.pairs.some(first..first + designs)?;
        let folders = (first..).map(|number| reports.get(&number));
        put(&matrix_row(&recording.name, cells.iter().zip(folders)))?;
    }
    put("</tbody></table></div>\n")
}

fn matrix_row<'a>(
    name: &str,
    cells: impl Iterator<Item = (&'a Pair, Option<&'a String>)> + Clone,
) -> String {
    let worst = cells.clone().map(|(pair, _)| pair.exit_code()).max();
    let least = cells
        .clone()
        .filter_map(|(pair, _)| pair.row.margin())
        .fold(f64::INFINITY, f64::min);
    let mut out = format!(
        "<tr data-name=\"{0}\" data-bad=\"{1}\" data-margin=\"{2:.4}\"><th scope=\"row\">{0}</th>",
        escape::markup(name),
        u8::from(worst.unwrap_or(0) != 0),
        least.clamp(-1e6, 1e6)
    );
    for (pair, folder) in cells {
        let bad = if pair.exit_code() == 0 { "" } else { " bad" };
        let what = format!(
            "{} with {}: {}, {}",
            pair.recording,
            pair.design,
            pair.row.verdict.name(),
            text::what(pair)
        );
        let inner = format!(
            "<span aria-hidden=\"true\">{}</span> {}",
            text::glyph(pair.row.verdict),
            percent(pair)
        );
        let inner = match folder {
            Some(folder) => format!(
                "<a href=\"{}/report.html\">{inner}</a>",
                escape::markup(folder)
            ),
            None => inner,
        };
        let _ = write!(
            out,
            "<td class=\"{} m{}{bad}\" title=\"{}\">{inner}</td>",
            pair.row.verdict.name(),
            shade(pair),
            escape::markup(&what)
        );
    }
    out.push_str("</tr>\n");
    out
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
            // Away from the limit by rounding is no margin.
            let text = format!("{:.0}", (100.0 * margin).floor());
            format!("{} %", text.replace('-', "\u{2212}"))
        }
        None => number::ABSENT.into(),
    }
}
