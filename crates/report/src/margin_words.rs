//! Words of an answer that the terminal and the page of `latchgate margin` share.

use latchgate_document::margin_document::MarginDocument;
use latchgate_document::number::plain;
use latchgate_kernel::units::shortest;
use latchgate_verdict::Answer;
use latchgate_verdict::margin::{Margin, Quantity};

/// Returns a bracket with enough digits to distinguish its ends, 17 at most.
pub(super) fn bracket((low, high): (f64, f64)) -> String {
    let digits = (4..=17)
        .find(|digits| plain(low, *digits) != plain(high, *digits))
        .unwrap_or(17);
    format!("[{}, {}]", plain(low, digits), plain(high, digits))
}

/// Returns the change in percent with its sign; none from a present value of zero.
pub(super) fn change(answer: &Margin) -> Option<String> {
    let percent = answer.change_percent()?;
    let sign = if percent >= 0.0 { "+" } else { "" };
    Some(format!("{sign}{} %", plain(percent, 3)))
}

/// Returns the first sentence: the advice on the preload, as a replay gives it.
pub(super) fn headline(document: &MarginDocument) -> String {
    if document.verdict == Answer::Unusable {
        return "No margin: a blocking finding makes the recording unusable.".into();
    }
    let mut answers = document.answers.iter();
    let preload = answers.find(|answer| answer.quantity == Quantity::Preload);
    let design = match document.verdict {
        Answer::Pass => "",
        _ => "With this design. ",
    };
    preload.map_or_else(String::new, |answer| {
        format!("{design}{}.", answer.advice.text)
    })
}

/// Returns the name of a quantity with its unit.
pub(super) fn titled(answer: &Margin, counterweight_radius_m: f64) -> String {
    let title = match answer.quantity {
        Quantity::Counterweight => format!("{} at {counterweight_radius_m} m", answer.title),
        _ => answer.title.to_string(),
    };
    match answer.quantity.unit() {
        "" => title,
        unit => format!("{title} [{unit}]"),
    }
}

/// Returns the value from which on every value tried passes, and to which side.
pub(super) fn advised(answer: &Margin) -> String {
    let side = if answer.quantity.is_safer_above() {
        "and above"
    } else {
        "and below"
    };
    answer.advice.safe_from.map_or_else(
        || "none".into(),
        |from| format!("{} {side}", shortest(from)),
    )
}

/// Returns the kind of change: where passes begin or end.
pub(super) fn direction(answer: &Margin) -> &'static str {
    // A change at the present value itself lies on the side that the answer leaves open.
    let at = answer.at().filter(|at| (*at - answer.present).abs() > 0.0);
    let towards_fail = !answer.quantity.is_safer_above();
    let above = at.map_or(answer.passes_at_present == towards_fail, |at| {
        at > answer.present
    });
    match (answer.passes_at_present, above) {
        (true, true) => "no pass above",
        (true, false) => "no pass below",
        (false, _) if answer.is_isolated() => "isolated pass",
        (false, true) => "passes above",
        (false, false) => "passes below",
    }
}

/// Returns the quantities without an advice, joined, with the reason that they share.
pub(super) fn without_advice(document: &MarginDocument) -> Vec<(String, String)> {
    let mut reasons: Vec<(String, String)> = Vec::new();
    for answer in &document.answers {
        let Some(why) = &answer.advice.reason else {
            continue;
        };
        match reasons.iter_mut().find(|(_, reason)| reason == why) {
            Some((titles, _)) => {
                titles.push_str(", ");
                titles.push_str(&answer.title);
            }
            None => reasons.push((answer.title.to_string(), why.clone())),
        }
    }
    reasons
}
