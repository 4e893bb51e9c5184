//! The ensemble, what drives it, and what the nominal runs say with one thing changed.

use super::markup::Page;
use crate::plot::Figure;
use crate::words::{self, DIGITS};
use latchgate_document::Document;
use latchgate_document::number::{ABSENT, count, exact, significant, trimmed};
use latchgate_verdict::Answer;
use latchgate_verdict::decision::{
    FAIL_SHARE_MIN, FAIL_SHARE_WITH_NOMINAL, PASS_SHARE_MAX, looks_in_words,
};
use latchgate_verdict::ensemble::{End, Ensemble};
use latchgate_verdict::what_if::Change;
use latchgate_verdict::wording::filter_name;
use std::fmt::Write as _;

/// Draws the bounds of the share of levers that cross against those of the rule, a bar for each
/// stop and polarity.
fn gauge(page: &mut Page, document: &Document) {
    let Some(shown) = &document.ensemble else {
        return;
    };
    let all = all(document, shown);
    let from_x = if all.len() > 1 { 212.0 } else { 0.0 };
    let x = |share: f64| from_x + share * (860.0 - from_x);
    let bottom = 20.0 + 17.0 * all.len() as f64;
    let mut svg = String::new();
    // Writing into a String cannot fail.
    let _ = write!(
        svg,
        "<svg class=\"gauge share\" viewBox=\"0 0 860 {bottom}\" aria-hidden=\"true\">"
    );
    let mut y = 20.0;
    for ensemble in all {
        let (from, to) = (x(ensemble.p_lower), x(ensemble.p_upper));
        if all.len() > 1 {
            let _ = write!(
                svg,
                "<text x=\"0\" y=\"{}\">{}, {}</text>",
                y + 10.5,
                words::stop(ensemble.model),
                words::opens(ensemble.opens_when)
            );
        }
        let _ = write!(
            svg,
            "<rect class=\"track\" x=\"{from_x}\" y=\"{y}\" width=\"{}\" height=\"12\" rx=\"2\"/>\
             <rect class=\"bar\" x=\"{from:.2}\" y=\"{y}\" width=\"{:.2}\" height=\"12\" rx=\"2\"/>",
            860.0 - from_x,
            (to - from).max(2.0)
        );
        if ensemble.exceeded_in_coast > 0 {
            let _ = write!(
                svg,
                "<rect class=\"bar\" opacity=\"0.35\" x=\"{to:.2}\" y=\"{y}\" width=\"{:.2}\" height=\"12\"/>",
                x(ensemble.p_upper_with_coast) - to
            );
        }
        y += 17.0;
    }
    for (share, anchor, dx, text) in [
        (PASS_SHARE_MAX, "start", 7.0, "a pass allows "),
        (FAIL_SHARE_WITH_NOMINAL, "start", 7.0, ""),
        (FAIL_SHARE_MIN, "end", -7.0, ""),
    ] {
        let at = x(share);
        let percent = words::percent(share);
        let _ = write!(
            svg,
            "<line class=\"mark\" x1=\"{at:.2}\" y1=\"5\" x2=\"{at:.2}\" y2=\"{}\"/>\
             <text x=\"{:.2}\" y=\"13\" text-anchor=\"{anchor}\">{text}{percent} %</text>",
            bottom - 3.0,
            at + dx,
        );
    }
    svg.push_str("</svg>\n");
    page.raw(&svg);
    page.raw("<p class=\"sum\">");
    page.text(&share_sentence(shown));
    page.raw("</p>\n");
}

fn all<'a>(document: &'a Document, shown: &'a Ensemble) -> &'a [Ensemble] {
    if document.ensembles.is_empty() {
        std::slice::from_ref(shown)
    } else {
        &document.ensembles
    }
}

fn share_sentence(ensemble: &Ensemble) -> String {
    let lost = match ensemble.failed_to_run {
        0 => String::new(),
        lost => format!(
            ", {} could not be followed and count{} against either answer",
            count(u64::from(lost)),
            if lost == 1 { "s" } else { "" }
        ),
    };
    format!(
        "Levers that cross the limit{}: {} of {}{lost}; of all such levers {} ({}, {}), each bound \
         at {}\u{00A0}% confidence.{}",
        words::until(ensemble),
        count(u64::from(ensemble.exceeded)),
        count(u64::from(ensemble.members)),
        interval(ensemble),
        words::stop(ensemble.model),
        words::opens(ensemble.opens_when),
        trimmed(100.0 * ensemble.confidence, 4),
        words::coasting(ensemble).map_or_else(String::new, |coasting| format!(" {coasting}.")),
    )
}

fn interval(ensemble: &Ensemble) -> String {
    format!(
        "{} to {}\u{00A0}%",
        words::percent(ensemble.p_lower),
        words::percent(ensemble.p_upper)
    )
}

/// Writes the ensemble of each stop and opening direction.
pub(super) fn ensemble(page: &mut Page, document: &Document) {
    let Some(shown) = &document.ensemble else {
        return;
    };
    page.wide_section("ensemble", "Levers varied within tolerances");
    gauge(page, document);
    page.table(
        "ensembles",
        &[
            "Stop and sign",
            "#Members",
            "#Cross the limit",
            "#Of all such levers",
            "#Peak: 5 % quantile [rad]",
            "#Median [rad]",
            "#95 % quantile [rad]",
            "#Largest [rad]",
            "Ended",
        ],
    );
    let all = all(document, shown);
    for ensemble in all {
        row(page, ensemble, document.threshold_rad);
    }
    page.end_table();
    if let Some(until) = shown.judged_until_s {
        page.note(&format!(
            "The recording is faulty later on: members are judged up to {} only.",
            words::instant(until)
        ));
    }
    if all.iter().any(|ensemble| ensemble.failed_to_run > 0) {
        page.note(
            "Members that could not be followed count as crossing in the upper bound and as not \
             crossing in the lower one.",
        );
    }
    page.end_section();
}

/// Writes what drives the peak, parameter by parameter.
pub(super) fn sensitivity(page: &mut Page, document: &Document, drivers: Option<&Figure>) {
    let Some(shown) = &document.ensemble else {
        return;
    };
    if let Some(figure) = drivers {
        page.figure(figure);
    } else {
        page.note(&words::drivers_sentence(shown));
    }
    inputs(page, document, shown);
    let looks = looks_in_words(|look| match (look / 1000, look % 1000) {
        (0..10, _) => look.to_string(),
        (thousands, rest) => format!("{thousands} {rest:03}"),
    });
    page.note(&format!(
        "Each member is the design and the recording with independent normal draws, truncated at \
         three standard deviations; the first is the nominal lever. The rule looks at them after \
         {looks} and stops where it can decide. Draws: {}; seed {}. Each bound holds at \
         {}\u{00A0}% confidence (Clopper and Pearson), so that the four looks together err in at \
         most 5\u{00A0}% of cases.",
        shown.generator,
        shown.seed,
        trimmed(100.0 * shown.confidence, 4)
    ));
}

fn row(page: &mut Page, ensemble: &Ensemble, threshold: f64) {
    page.raw("<tr>");
    page.element(
        "th",
        "",
        &format!(
            "{}, {}",
            words::stop(ensemble.model),
            words::opens(ensemble.opens_when)
        ),
    );
    page.element("td", "number", &count(u64::from(ensemble.members)));
    let lost = match ensemble.failed_to_run {
        0 => String::new(),
        lost => format!(" (+{} lost)", count(u64::from(lost))),
    };
    let crossed = format!("{}{lost}", count(u64::from(ensemble.exceeded)));
    page.element("td", "number", &crossed);
    page.element("td", "number", &interval(ensemble));
    let quantiles = ensemble.peak_angle_rad;
    for value in [
        quantiles.map(|q| q.p05),
        quantiles.map(|q| q.p50),
        quantiles.map(|q| q.p95),
        quantiles.map(|q| q.max),
    ] {
        peak(page, value, threshold);
    }
    page.element(
        "td",
        "",
        match ensemble.ended {
            End::Decided => "decided",
            End::LastLook => "last look, undecided",
            End::NoMatter => "could not change the answer",
            End::WorkLimit => "ended by the limit `work`",
        },
    );
    page.raw("</tr>\n");
}

fn peak(page: &mut Page, value: Option<f64>, threshold: f64) {
    let class = if value.is_some_and(|value| value > threshold) {
        "number above"
    } else {
        "number"
    };
    let text = value.map_or_else(|| ABSENT.into(), |value| significant(value, 4));
    page.element("td", class, &text);
}

/// Writes what each scattered parameter does, among the others and alone.
fn inputs(page: &mut Page, document: &Document, shown: &Ensemble) {
    if shown.drivers.is_empty() {
        return;
    }
    let alone = !document.what_if.is_empty();
    let mut heads = vec![
        "Parameter",
        "#One standard deviation",
        "#Rank correlation",
        "#Share of its square",
    ];
    if alone {
        heads.extend(["#Peak with one less [rad]", "#Peak with one more [rad]"]);
    }
    page.table("inputs", &heads);
    for driver in &shown.drivers {
        page.raw("<tr>");
        page.element("th", "", words::parameter(&driver.parameter));
        page.element(
            "td",
            "number",
            &match words::parameter_unit(&driver.parameter) {
                "" => trimmed(driver.standard_deviation, 4),
                unit => format!("{}\u{00A0}{unit}", trimmed(driver.standard_deviation, 4)),
            },
        );
        let number = |value: Option<f64>, show: &dyn Fn(f64) -> String| {
            value.map_or_else(|| ABSENT.to_string(), show)
        };
        page.element(
            "td",
            "number",
            &number(driver.rank_correlation, &|value| significant(value, 2)),
        );
        page.element(
            "td",
            "number",
            &number(driver.share, &|share| {
                format!("{:.0}\u{00A0}%", 100.0 * share)
            }),
        );
        if alone {
            for how in [Change::Less, Change::More] {
                let found = document
                    .what_if
                    .iter()
                    .find(|what_if| what_if.input == driver.parameter && what_if.how == how);
                let value = found.map(|what_if| what_if.peak_angle_rad);
                peak(page, value, document.threshold_rad);
            }
        }
        page.raw("</tr>\n");
    }
    page.end_table();
    if alone {
        let kept = document
            .what_if
            .iter()
            .find(|what_if| what_if.how == Change::BiasKept)
            .map_or_else(String::new, |what_if| {
                format!(
                    " With the bias of {}\u{00A0}g left in, the peak is {}\u{00A0}rad.",
                    trimmed(what_if.change, 4),
                    significant(what_if.peak_angle_rad, 4)
                )
            });
        page.note(&format!(
            "The last two columns are nominal runs with one parameter moved, the largest peak of \
             the stops and signs that count; figures in bold exceed the limit.{kept}"
        ));
    }
}

/// Writes what the nominal runs say after each filter.
pub(super) fn filters(page: &mut Page, document: &Document) {
    if document.filters.is_empty() {
        return;
    }
    page.section("filters", "After each filter");
    page.table(
        "filters",
        &["Filter", "Nominal levers", "#Largest angle [rad]", "Remark"],
    );
    for row in &document.filters {
        page.raw(if row.chosen {
            "<tr class=\"nominal\">"
        } else {
            "<tr>"
        });
        page.element("th", "", filter_name(row.filter));
        page.element("td", "", row.verdict.map_or(ABSENT, Answer::name));
        let text = row
            .peak_angle_rad
            .map_or_else(|| ABSENT.into(), |value| significant(value, DIGITS));
        let above = row
            .peak_angle_rad
            .is_some_and(|peak| peak > document.threshold_rad);
        page.element("td", if above { "number above" } else { "number" }, &text);
        let note = match (&row.reason, row.chosen) {
            (Some(reason), _) => words::sentence(reason),
            (None, true) => "chosen: the verdict rests on it".into(),
            (None, false) => String::new(),
        };
        page.element("td", "", &note);
        page.raw("</tr>\n");
    }
    page.end_table();
    page.note(&format!(
        "Nominal runs, limit {}\u{00A0}rad. A heavier filter takes away what opens the lever: where the \
         answer hangs on the filter, the lighter one is the safer.",
        exact(document.threshold_rad)
    ));
    page.end_section();
}
