//! The ensemble, its drivers, and the answers of the nominal runs by filter.

use super::markup::{figure, heads, stop_and_sign};
use crate::escape::terminal as line;
use crate::plot::Figure;
use crate::words;
use latchgate_document::Document;
use latchgate_document::number::{ABSENT, count, significant, trimmed};

use latchgate_kernel::units::OpensWhen;
use latchgate_verdict::decision::{FAIL_SHARE_MIN, FAIL_SHARE_WITH_NOMINAL, looks_in_words};
use latchgate_verdict::ensemble::{End, Ensemble};
use latchgate_verdict::what_if::Change;
use latchgate_verdict::wording::{filter_name, percent, percent_bound};
use latchgate_verdict::{Answer, FilterRow};
use maud::{Markup, html};

/// Returns the ensemble of each stop and opening direction.
pub(super) fn ensemble(document: &Document) -> Markup {
    let Some(shown) = &document.ensemble else {
        return html! {};
    };
    let ensembles = words::ensembles(document);
    html! {
        // A phone scrolls the table sideways; the tab index lets keys scroll it too.
        section #ensembles tabindex="0" {
            (gauge(ensembles))
            p.sum { (line(&share_sentence(shown))) }
            table.ensembles {
                (heads(&[
                    "Stop and sign",
                    "#Members",
                    "#Cross the limit",
                    "#Share that opens, bounds",
                    "#Peak: 5 % quantile [°]",
                    "#Median [°]",
                    "#95 % quantile [°]",
                    "#Largest [°]",
                    "Ended",
                ]))
                tbody { @for ensemble in ensembles { (row(ensemble, document.threshold_rad)) } }
            }
            @if let Some(until) = shown.judged_until_s {
                p.note {
                    "The recording is faulty later on: members are judged up to " (words::instant(until)) " only."
                }
            }
            @if ensembles.iter().any(|ensemble| ensemble.failed_to_run > 0) {
                p.note {
                    "Members that could not be followed count as crossing in the upper bound and as not "
                    "crossing in the lower one."
                }
            }
        }
    }
}

/// Draws the bounds of the share of levers that cross against those of the rule, a bar for each
/// stop and polarity.
fn gauge(ensembles: &[Ensemble]) -> Markup {
    let track_x = if ensembles.len() > 1 { 212.0 } else { 0.0 };
    let width = 860.0 - track_x;
    let x = |share: f64| track_x + share * width;
    let bottom = 20.0 + 17.0 * ensembles.len() as f64;
    let marks = [
        (
            ensembles.first().map_or(0.0, |first| first.open_share),
            "start",
            7.0,
            "a pass allows ",
        ),
        (FAIL_SHARE_WITH_NOMINAL, "start", 7.0, ""),
        (FAIL_SHARE_MIN, "end", -7.0, ""),
    ];
    html! {
        svg.gauge.share viewBox={ "0 0 860 " (bottom) } aria-hidden="true" {
            @for (row, ensemble) in ensembles.iter().enumerate() {
                @let y = 20.0 + 17.0 * row as f64;
                @let (from, to) = (x(ensemble.p_lower), x(ensemble.p_upper));
                @if ensembles.len() > 1 {
                    text x="0" y=(y + 10.5) { (stop_and_sign(ensemble.model, ensemble.opens_when)) }
                }
                rect.track x=(track_x) y=(y) width=(width) height="12" rx="2" {}
                rect.bar x=(hundredths(from)) y=(y) width=(hundredths((to - from).max(2.0))) height="12" rx="2" {}
                @if ensemble.exceeded_in_coast > 0 {
                    @let width = x(ensemble.p_upper_with_coast) - to;
                    rect.bar opacity="0.35" x=(hundredths(to)) y=(y) width=(hundredths(width)) height="12" {}
                }
            }
            @for (share, anchor, dx, text) in marks {
                @let x = x(share);
                line.mark x1=(hundredths(x)) y1="5" x2=(hundredths(x)) y2=(bottom - 3.0) {}
                text x=(hundredths(x + dx)) y="13" text-anchor=(anchor) { (text) (percent(share)) " %" }
            }
        }
    }
}

fn hundredths(length: f64) -> String {
    format!("{length:.2}")
}

fn share_sentence(ensemble: &Ensemble) -> String {
    let lost = ensemble.lost_in_words(Answer::Undecided);
    let lost = lost.map_or_else(String::new, |lost| format!(", {lost}"));
    format!(
        "{} of {} {} open{}{lost}: {} ({}).{}",
        count(u64::from(ensemble.exceeded)),
        count(u64::from(ensemble.members)),
        ensemble.varied.members(),
        words::until(ensemble),
        ensemble.share_that_opens(Answer::Undecided),
        stop_and_sign(ensemble.model, ensemble.opens_when),
        words::coasting(ensemble).map_or_else(String::new, |coasting| format!(" {coasting}.")),
    )
}

fn interval(ensemble: &Ensemble) -> String {
    format!(
        "{} to {}\u{00A0}%",
        percent_bound(ensemble.p_lower, f64::floor),
        percent_bound(ensemble.p_upper, f64::ceil)
    )
}

fn row(ensemble: &Ensemble, threshold: f64) -> Markup {
    let lost = ensemble.failed_to_run;
    let quantiles = ensemble.peak_angle_rad;
    html! {
        tr {
            th { (stop_and_sign(ensemble.model, ensemble.opens_when)) }
            td.number { (count(u64::from(ensemble.members))) }
            td.number {
                (count(u64::from(ensemble.exceeded)))
                @if lost > 0 { " (+" (count(u64::from(lost))) " lost)" }
            }
            td.number { (interval(ensemble)) }
            (peak(quantiles.map(|q| q.p05), threshold))
            (peak(quantiles.map(|q| q.p50), threshold))
            (peak(quantiles.map(|q| q.p95), threshold))
            (peak(quantiles.map(|q| q.max), threshold))
            td {
                @match ensemble.ended {
                    End::Decided => "enough for an answer",
                    End::LastLook => "last look, undecided",
                    End::NoMatter => "could not change the answer",
                    End::NoPass => "the error forbids a pass, too few open for a fail",
                    End::WorkLimit => "ended by the limit `work`",
                }
            }
        }
    }
}

/// Digits of an angle in a table.
const ANGLE_DIGITS: usize = 3;

/// Returns the cell of a peak in degrees; one beyond the limit is bold.
fn peak(radians: Option<f64>, threshold_rad: f64) -> Markup {
    let above = radians.is_some_and(|peak| peak > threshold_rad);
    let text = radians.map_or_else(
        || ABSENT.into(),
        |peak| words::degrees_cell(peak, ANGLE_DIGITS),
    );
    html! { td.number .above[above] { (text) } }
}

/// As [`peak`], after a filter.
fn filtered(
    document: &Document,
    row: &FilterRow,
    radians: Option<f64>,
    answer: Option<Answer>,
) -> Markup {
    let above = radians.is_some_and(|peak| peak > document.threshold_rad);
    let text = radians.map_or_else(
        || ABSENT.into(),
        |peak| words::filtered_angle(document, row, peak, answer),
    );
    html! { td.number .above[above] { (text) } }
}

/// Returns the drivers of the peak, parameter by parameter.
pub(super) fn sensitivity(document: &Document, drivers: Option<&Figure>) -> Markup {
    let Some(shown) = &document.ensemble else {
        return html! {};
    };
    let looks = looks_in_words(|look| match (look / 1000, look % 1000) {
        (0..10, _) => look.to_string(),
        (thousands, rest) => format!("{thousands} {rest:03}"),
    });
    html! {
        @if let Some(drivers) = drivers { (figure(drivers)) }
        @else { p.note { (line(&words::drivers_sentence(shown))) } }
        @if !shown.drivers.is_empty() { (inputs(document, shown)) }
        p.note {
            "Each member is the design and the recording with independent normal draws; the first is the nominal "
            "lever on the recording as it is. The rule looks at them after "
            (looks) " and stops where it can decide. Draws: " (line(&shown.generator)) "; seed " (shown.seed)
            ". Each bound holds at " (percent(shown.confidence)) "\u{00A0}% confidence (Clopper and Pearson), "
            "so that the four looks together err in at most "
            (percent(1.0 - document.design.criterion.confidence)) "\u{00A0}% of cases."
        }
    }
}

/// Returns the effect of each varied parameter, among the others and alone.
fn inputs(document: &Document, shown: &Ensemble) -> Markup {
    let alone = !document.what_if.is_empty();
    let mut columns = vec![
        "Parameter",
        "#One standard deviation",
        "#Rank correlation",
        "#Share of its square",
    ];
    if alone {
        columns.extend(["#Peak with one less [°]", "#Peak with one more [°]"]);
    }
    let number = |value: Option<String>| value.unwrap_or_else(|| ABSENT.into());
    let bias_kept = document
        .what_if
        .iter()
        .find(|what_if| what_if.how == Change::BiasKept);
    html! {
        table.inputs {
            (heads(&columns))
            tbody {
                @for driver in &shown.drivers {
                    tr {
                        th { (line(words::parameter(&driver.parameter))) }
                        td.number {
                            (trimmed(driver.standard_deviation, 4))
                            @match words::parameter_unit(&driver.parameter) { "" => {} unit => { "\u{00A0}" (unit) } }
                        }
                        td.number { (number(driver.rank_correlation.map(|value| significant(value, 2)))) }
                        td.number { (number(driver.share.map(|share| format!("{:.0}\u{00A0}%", 100.0 * share)))) }
                        @if alone {
                            @for how in [Change::Less, Change::More] {
                                @let changed = document.what_if.iter()
                                    .find(|what_if| what_if.input == driver.parameter && what_if.how == how);
                                (peak(changed.map(|what_if| what_if.peak_angle_rad), document.threshold_rad))
                            }
                        }
                    }
                }
            }
        }
        @if alone {
            p.note {
                "The last two columns are nominal runs with one parameter moved, the largest peak of the stops and "
                "signs that count; figures in bold exceed the limit."
                @if let Some(kept) = bias_kept {
                    " With the bias of " (trimmed(kept.change, 4)) "\u{00A0}g left in, the peak is "
                    (words::bounded_angle(kept.peak_angle_rad)) "."
                }
            }
        }
    }
}

/// Returns the answers of the nominal runs after each filter.
pub(super) fn filters(document: &Document) -> Markup {
    if document.filters.is_empty() {
        return html! {};
    }
    let directions = document.filters.iter().map(|row| &row.by_direction);
    let directions = directions.max_by_key(|directions| directions.len());
    let signs: Vec<OpensWhen> = directions
        .into_iter()
        .flatten()
        .map(|direction| direction.opens_when)
        .collect();
    let angle_columns: Vec<String> = match signs.as_slice() {
        [] => vec!["#Largest angle [°]".into()],
        several => several
            .iter()
            .map(|sign| {
                format!(
                    "#{}: largest angle [°]",
                    words::capital(words::opens(*sign))
                )
            })
            .collect(),
    };
    // Of the filter in use the varied levers have answered too.
    let joint = words::directions(document);
    let has_undecided = document.filters.iter().any(|row| {
        let mut answers = row.by_direction.iter().map(|direction| direction.answer);
        match signs.is_empty() {
            true => row.verdict == Some(Answer::Undecided),
            false => answers.any(|answer| answer == Answer::Undecided),
        }
    });
    let mut columns = vec!["Filter"];
    for column in &angle_columns {
        columns.extend([column.as_str(), "Answer"]);
    }
    columns.push("Remark");
    html! {
        section {
            table.filters {
                (heads(&columns))
                tbody {
                    @for row in &document.filters {
                        tr .nominal[row.chosen] {
                            th { (filter_name(row.filter)) }
                            @if signs.is_empty() {
                                (filtered(document, row, row.peak_angle_rad, row.verdict))
                                td { (words::filtered_answer(document, row)) }
                            }
                            @for sign in &signs {
                                @let direction = row.by_direction.iter().find(|direction| direction.opens_when == *sign);
                                @let answer = direction.map(|direction| direction.answer);
                                (filtered(document, row, direction.and_then(|direction| direction.peak_angle_rad), answer))
                                @let joint = joint.iter().find(|joint| row.chosen && joint.sign == sign.name());
                                @if let Some(joint) = joint { td { (joint.word) } }
                                @else { td { (answer.map_or("–", Answer::name)) } }
                            }
                            td {
                                @if let Some(reason) = &row.reason { (line(&words::sentence(reason))) }
                                @else if row.chosen { "in use" }
                            }
                        }
                    }
                }
            }
            p.note {
                "Limit angle " (words::limit_angle(document.threshold_rad)) "."
                @if has_undecided {
                    " Undecided: the error of the largest angle reaches the limit; the varied levers, which have no part here, may decide."
                }
                " Where filters disagree, do not rely on a pass."
            }
        }
    }
}
