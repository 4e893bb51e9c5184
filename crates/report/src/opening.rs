//! The instant at which a lever opens, with the digits that its spread allows.

use latchgate_document::Document;
use latchgate_document::number::trimmed;
use latchgate_kernel::replay::Run;
use latchgate_verdict::ensemble::Varied;
use latchgate_verdict::{Answer, Opening};

/// A spread above this part of the median, and above [`SPREAD_S`], is shown as a span [-].
const SPREAD_PART: f64 = 0.02;

/// A spread above this is shown as a span [s].
const SPREAD_S: f64 = 5e-4;

/// No instant is shown finer than this [s].
const FINEST_S: f64 = 1e-5;

/// From here on an instant is shown in seconds [s].
const LONG_S: f64 = 10.0;

/// Verb before an instant of opening that is certain.
pub const OPENS: &str = "opens";

/// Verb before an instant of opening that is not certain.
pub const MAY_OPEN: &str = "may open";

/// Returns the verb before an instant of opening under an answer.
pub fn opens_or_may(answer: Answer) -> &'static str {
    match answer {
        Answer::Undecided => MAY_OPEN,
        _ => OPENS,
    }
}

/// First and last instant between which nine of ten varied levers that open do so.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpeningSpan {
    /// Its start [s].
    pub start_s: f64,
    /// Its end [s].
    pub end_s: f64,
}

/// Returns the span in which varied levers open, where it is too long for one instant.
pub fn span(opens: &Opening) -> Option<OpeningSpan> {
    let (start_s, middle, end_s) = (opens.p05_s?, opens.p50_s?, opens.p95_s?);
    let longest = SPREAD_S.max(SPREAD_PART * middle.abs());
    (end_s - start_s > longest).then_some(OpeningSpan { start_s, end_s })
}

/// Returns when the lever opens: `opens at 14.4 ms`, `opens between 77 and 104 ms (90 % of the varied levers)`, or
/// how many varied levers do where the nominal one does not.
///
/// `verb` is `opens` or `may open`.
pub fn sentence(opens: &Opening, verb: &str) -> String {
    if opens.first_s.is_none() {
        let members = members(opens);
        return format!("{} of {} {members} open", opens.exceeded, opens.members);
    }
    match span(opens) {
        Some(_) if opens.exceeded < opens.members => {
            format!(
                "{verb} {} (90\u{00A0}% of the {} that open)",
                instant(opens),
                members(opens)
            )
        }
        Some(_) => format!(
            "{verb} {} (90\u{00A0}% of the {})",
            instant(opens),
            members(opens)
        ),
        None => format!("{verb} {}", instant(opens)),
    }
}

/// Names what was varied.
fn members(opens: &Opening) -> &'static str {
    opens.varied.unwrap_or(Varied::Levers).members()
}

/// Returns the instant: `at 14.4 ms`, or `between 77 and 104 ms`.
fn instant(opens: &Opening) -> String {
    if let Some(OpeningSpan { start_s, end_s }) = span(opens) {
        // The span has two digits and is rounded outwards, so that it holds the unrounded one.
        let unit = power_of_ten(end_s - start_s, f64::floor) / 10.0;
        let start = rounded(start_s, unit, f64::floor);
        let end = rounded(end_s, unit, f64::ceil);
        let (scale, name) = time_unit(end_s);
        return format!(
            "between {} and {}\u{00A0}{name}",
            fixed(start * scale, unit * scale),
            fixed(end * scale, unit * scale)
        );
    }
    match (opens.p05_s, opens.p50_s, opens.p95_s) {
        (Some(start_s), Some(middle), Some(end_s)) => {
            let unit = power_of_ten((end_s - start_s).max(FINEST_S), f64::ceil);
            let (scale, name) = time_unit(middle);
            let middle = rounded(middle, unit, f64::round);
            format!("at {}\u{00A0}{name}", fixed(middle * scale, unit * scale))
        }
        _ => format!("at {}", nominal_instant(opens.first_s.unwrap_or(f64::NAN))),
    }
}

/// As [`sentence`] in a cell of a table: `14.4 ms`, `77 … 104 ms`.
pub fn cell(opens: &Opening) -> String {
    if opens.first_s.is_none() {
        return sentence(opens, OPENS);
    }
    let text = instant(opens);
    let text = text
        .trim_start_matches("at ")
        .trim_start_matches("between ");
    text.replace(" and ", " … ")
}

/// Returns an instant of one nominal run, which has no spread.
pub fn nominal_instant(seconds: f64) -> String {
    let (scale, name) = time_unit(seconds);
    format!("{}\u{00A0}{name}", trimmed(seconds * scale, 3))
}

/// Returns when a run opens: the [`sentence`] of its varied levers if the document has one, else the instant at
/// which the nominal lever crosses; `None` if it does not cross.
pub fn of_run(document: &Document, run: &Run) -> Option<String> {
    let crossing = run.first_crossing_s?;
    let is_of_run =
        |opens: &&Opening| (opens.model, opens.opens_when) == (run.model, run.opens_when);
    let named = document
        .opens
        .iter()
        .chain(document.opens_by_direction.values())
        .filter(is_of_run)
        .find(|opens| opens.first_s.is_some());
    let verb = opens_or_may(
        document
            .answer_of(run)
            .map_or(document.verdict, |answer| answer.answer),
    );
    Some(match named {
        Some(opens) => sentence(opens, verb),
        None => format!("{verb} at {} (nominal lever)", nominal_instant(crossing)),
    })
}

fn time_unit(seconds: f64) -> (f64, &'static str) {
    if seconds.abs() < LONG_S {
        (1e3, "ms")
    } else {
        (1.0, "s")
    }
}

fn power_of_ten(value: f64, round: fn(f64) -> f64) -> f64 {
    // The logarithm of a power of ten may be off by a few ulp; it must not move to the next integer.
    let exponent = libm::log10(value);
    let nearest = exponent.round();
    let exponent = if (exponent - nearest).abs() < 1e-9 {
        nearest
    } else {
        round(exponent)
    };
    libm::pow(10.0, exponent)
}

fn rounded(value: f64, unit: f64, round: fn(f64) -> f64) -> f64 {
    round(value / unit) * unit
}

/// Returns a number with the decimals of `unit`.
fn fixed(value: f64, unit: f64) -> String {
    let decimals = (-libm::log10(unit) - 1e-9).ceil().clamp(0.0, 9.0) as usize;
    format!("{value:.decimals$}").replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use latchgate_kernel::model::stop::StopModel;
    use latchgate_kernel::units::OpensWhen;

    #[track_caller]
    fn check_opening(quantiles_ms: [f64; 3], exceeded: u32, expected: &str, expected_cell: &str) {
        let [p05_s, p50_s, p95_s] = quantiles_ms.map(|ms| Some(ms / 1e3));
        let opens = Opening {
            first_s: p50_s,
            model: StopModel::Rigid,
            opens_when: OpensWhen::Negative,
            p05_s,
            p50_s,
            p95_s,
            members: 128,
            exceeded,
            varied: None,
        };
        let plain = |text: String| text.replace('\u{00A0}', " ");
        assert_eq!(plain(sentence(&opens, "opens")), expected);
        assert_eq!(plain(cell(&opens)), expected_cell);
    }

    #[test]
    fn verif_an_instant_has_the_digits_that_its_spread_deserves() {
        let spread = "opens between 77 and 104 ms (90 % of the varied levers)";
        check_opening([77.3, 90.0, 103.2], 128, spread, "77 … 104 ms");
        let some = "opens between 77 and 104 ms (90 % of the varied levers that open)";
        check_opening([77.3, 90.0, 103.2], 100, some, "77 … 104 ms");
        check_opening([14.36, 14.4, 14.44], 128, "opens at 14.4 ms", "14.4 ms");
        // 0.1 ms is itself the smallest power of ten that is not below the spread.
        check_opening([14.35, 14.41, 14.45], 128, "opens at 14.4 ms", "14.4 ms");
        check_opening([14.2, 14.41, 14.6], 128, "opens at 14 ms", "14 ms");
        check_opening([14.41, 14.41, 14.41], 128, "opens at 14.41 ms", "14.41 ms");
        check_opening(
            [-0.2, 0.4, 0.9],
            128,
            "opens between −0.2 and 0.9 ms (90 % of the varied levers)",
            "−0.2 … 0.9 ms",
        );
    }

    #[test]
    fn verif_varied_levers_alone_have_a_count_and_no_instant() {
        let opens = Opening {
            first_s: None,
            model: StopModel::Soft,
            opens_when: OpensWhen::Positive,
            p05_s: Some(0.01),
            p50_s: Some(0.02),
            p95_s: Some(0.03),
            members: 512,
            exceeded: 7,
            varied: None,
        };
        assert_eq!(sentence(&opens, "opens"), "7 of 512 varied levers open");
        assert_eq!(cell(&opens), "7 of 512 varied levers open");
    }
}
