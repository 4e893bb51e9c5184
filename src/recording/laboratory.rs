//! The laboratory's own words: validity limits and faults that stand in comment text.
//!
//! Status codes often say that all is well where the comment says until when: "NO VALID DATA
//! AFTER 64.6 MILLISECONDS". The comment counts. What it says of a time is taken as the instant
//! on the file's clock from which the samples are no evidence.

use super::Finding;

/// Words that take the worth from a sample.
const FAULTS: &[&str] = &[
    "INVALID",
    "QUESTIONABLE",
    "EXCEEDED",
    "EXCEEDS",
    "SATURATED",
    "SATURATES",
    "SATURATION",
    "CLIPPED",
    "CLIPPING",
    "CLIPS",
    "OVERRANGE",
    "OVERRANGED",
    "OVERLOAD",
    "OVERLOADED",
    "LOST",
    "LOSS",
    "FAILED",
    "FAILS",
    "FAILURE",
    "DISCONNECTED",
    "BROKE",
    "BROKEN",
    "SEVERED",
    "DROPOUT",
    "DROPOUTS",
    "ERRATIC",
    "UNRELIABLE",
    "UNUSABLE",
    "SUSPECT",
    "DEFECT",
    "DEFECTIVE",
    "MALFUNCTION",
    "MALFUNCTIONED",
    "MEANINGLESS",
    "BAD",
    "DAMAGED",
    "INTERMITTENT",
    "DETACHED",
    "LOOSE",
    "DEBONDED",
    "UNPLUGGED",
    "CORRUPT",
    "CORRUPTED",
    "DEAD",
    "UNGÜLTIG",
    "AUSGEFALLEN",
    "ÜBERSTEUERT",
    "DEFEKT",
];

/// Words for what is worth a look.
const DOUBTS: &[&str] = &[
    "SPIKE",
    "SPIKES",
    "NOISE",
    "NOISY",
    "DRIFT",
    "DRIFTS",
    "SHIFT",
    "SHIFTED",
    "ANOMALY",
    "ANOMALIES",
    "ANOMALOUS",
];

/// Words for samples that can be used.
const GOOD: &[&str] = &["VALID", "GOOD", "USABLE", "GÜLTIG"];

/// Words that point to the time before an instant.
const BEFORE: &[&str] = &[
    "BEFORE", "PRIOR", "UNTIL", "TILL", "TO", "THROUGH", "FIRST", "WITHIN", "BIS", "VOR",
];

/// What a remark says of the samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Remark {
    /// They are no evidence: from an instant on the file's clock [s], or throughout.
    Invalid(Option<f64>),
    /// They are worth a look: from an instant on, or throughout.
    Doubtful(Option<f64>),
}

/// Reads what a comment says of the samples; `None` if nothing.
pub(super) fn remark(comment: &str) -> Option<Remark> {
    let words = words(comment);
    let says = |list: &[&str]| {
        words
            .iter()
            .enumerate()
            .any(|(index, word)| list.contains(&word.as_str()) && !denied(&words, index))
    };
    let denies_good = words
        .iter()
        .enumerate()
        .any(|(index, word)| GOOD.contains(&word.as_str()) && denied(&words, index));
    let instants = instants(&words);
    let first = instants
        .iter()
        .map(|(_, instant)| *instant)
        .min_by(f64::total_cmp);
    let points_before = instants.iter().any(|(index, _)| {
        let from = index.saturating_sub(3);
        words[from..*index]
            .iter()
            .any(|word| BEFORE.contains(&word.as_str()))
            // "from 60 to 65 ms" names a stretch, not all that came before.
            && !words[..*index].iter().any(|word| word == "FROM" || word == "BETWEEN")
    });
    if says(FAULTS) || denies_good {
        return Some(Remark::Invalid(first.filter(|_| !points_before)));
    }
    if says(GOOD) && first.is_some() {
        // "valid until 80 ms" against "valid after 10 ms", which spoils the start.
        return Some(Remark::Invalid(first.filter(|_| points_before)));
    }
    if says(DOUBTS) {
        return Some(Remark::Doubtful(first.filter(|_| !points_before)));
    }
    None
}

/// Characters of a note that are shown.
const LONGEST_NOTE: usize = 300;

/// Words that fill the place of a comment.
const NO_COMMENTS: &[&str] = &[
    "",
    "NO COMMENTS",
    "NO COMMENT",
    "NONE",
    "NO REMARKS",
    "KEINE",
    "NOVALUE",
    "N A",
    "NA",
    "OK",
];

/// Returns the finding for a comment: what it says of the samples, and where it says nothing
/// of them that is known here, its text to be read by a person.
pub(super) fn told(comment: &str, instant: Option<f64>) -> Option<Finding> {
    finding(comment, instant).or_else(|| {
        let nothing = NO_COMMENTS.contains(&words(comment).join(" ").as_str());
        (!nothing).then(|| Finding {
            at_s: instant,
            ..Finding::info(
                "notes",
                format!(
                    "the laboratory notes: \"{}\"",
                    comment
                        .trim()
                        .chars()
                        .take(LONGEST_NOTE)
                        .collect::<String>()
                ),
            )
        })
    })
}

/// Returns the finding for what a comment says; `instant` stands in for a remark without a
/// time of its own [s].
pub(super) fn finding(comment: &str, instant: Option<f64>) -> Option<Finding> {
    let comment = comment.trim();
    let (finding, at_s) = match remark(comment)? {
        Remark::Invalid(at_s) => (
            Finding::blocking(
                "invalid-by-laboratory",
                format!("the laboratory says of this channel: \"{comment}\""),
            ),
            at_s,
        ),
        Remark::Doubtful(at_s) => (
            Finding::warning(
                "laboratory-remark",
                format!("the laboratory says of this channel: \"{comment}\""),
            ),
            at_s,
        ),
    };
    Some(Finding {
        at_s: at_s.or(instant),
        ..finding
    })
}

/// Tells whether "no", "not" or the like stands right before a word.
fn denied(words: &[String], index: usize) -> bool {
    index > 0
        && matches!(
            words[index - 1].as_str(),
            "NO" | "NOT" | "WITHOUT" | "NON" | "KEINE" | "NICHT"
        )
}

/// Splits a comment into words in capitals; a number and a unit written together come apart.
fn words(comment: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut word = String::new();
    let mut flush = |word: &mut String| {
        let trimmed = word.trim_matches(['.', ',', '-', '+']);
        // A minus before a digit belongs to the number.
        let sign = if word.starts_with('-') && trimmed.starts_with(|c: char| c.is_ascii_digit()) {
            "-"
        } else {
            ""
        };
        if !trimmed.is_empty() {
            words.push(format!("{sign}{trimmed}"));
        }
        word.clear();
    };
    for character in comment.chars() {
        if !character.is_alphanumeric() && !matches!(character, '.' | ',' | '-' | '+') {
            flush(&mut word);
            continue;
        }
        let before = word.chars().last();
        let splits = match before {
            // "64.6MS"
            Some(last) => last.is_ascii_digit() && character.is_alphabetic(),
            None => false,
        };
        // "EVENT,QUESTIONABLE" and "60-65"
        let joins = matches!(character, ',' | '-' | '+' | '.') && !word.is_empty();
        if splits {
            flush(&mut word);
        }
        if joins && (character == '-' || !before.is_some_and(|c| c.is_ascii_digit())) {
            flush(&mut word);
            if character == '-' && before.is_some_and(|c| c.is_ascii_digit()) {
                continue;
            }
        }
        word.extend(character.to_uppercase());
    }
    flush(&mut word);
    words
}

/// Finds numbers with a unit of time: index of the number among the words, and instant [s].
fn instants(words: &[String]) -> Vec<(usize, f64)> {
    // The exponent goes in before the number is read, so that 64.6 ms are 0.0646 s to the bit.
    let number = |word: &String, exponent: i32| -> Option<f64> {
        format!("{}e{exponent}", word.replace(',', "."))
            .parse::<f64>()
            .ok()
            .filter(|value| value.is_finite())
    };
    let mut found = Vec::new();
    for (index, pair) in words.windows(2).enumerate() {
        let Some(exponent) = exponent(&pair[1]) else {
            continue;
        };
        let Some(instant) = number(&pair[0], exponent) else {
            continue;
        };
        found.push((index, instant));
        // "between 60 and 65 ms", "60 to 65 ms", "60-65 ms"
        let earlier = match index {
            0 => None,
            1 => number(&words[0], exponent),
            _ => match words[index - 1].as_str() {
                "AND" | "TO" | "BIS" | "UND" => number(&words[index - 2], exponent),
                _ => number(&words[index - 1], exponent),
            },
        };
        found.extend(earlier.map(|earlier| (index, earlier)));
    }
    found
}

/// Returns the power of ten of a unit of time in seconds.
fn exponent(word: &str) -> Option<i32> {
    match word {
        "S" | "SEC" | "SECS" | "SECOND" | "SECONDS" | "SEKUNDEN" => Some(0),
        "MS" | "MSEC" | "MSECS" | "MILLISEKUNDEN" => Some(-3),
        "US" | "USEC" | "MICROSECONDS" => Some(-6),
        // NHTSA's own files hold "MILLSECONDS".
        other if other.starts_with("MILL") && other.contains("SECOND") => Some(-3),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::{Remark, remark};

    #[track_caller]
    fn check_remark(comment: &str, expected: Option<Remark>) {
        assert_eq!(remark(comment), expected, "{comment}");
    }

    /// Comments of the kind that laboratories write, with what a person reads in them.
    #[test]
    fn val_comments_say_from_when_on_samples_are_no_evidence() {
        for (comment, instant) in [
            ("NO VALID DATA AFTER 64.6 MILLISECONDS", 0.0646),
            (
                "EXCEEDED FULL SCALE AT 61.4 MILLSECONDS, QUESTIONABLE DATA THEREAFTER",
                0.0614,
            ),
            ("Sensor failed at 80ms", 0.08),
            ("DATA VALID UNTIL 90 MS", 0.09),
            ("valid for first 75,5 msec", 0.0755),
            ("signal lost after 0.12 s", 0.12),
            ("CLIPPED BETWEEN 60 AND 65 MS", 0.06),
            ("saturated 60-65 ms", 0.06),
            ("QUESTIONABLE FROM 60 TO 65 MS", 0.06),
        ] {
            check_remark(comment, Some(Remark::Invalid(Some(instant))));
        }
        for comment in [
            "NO VALID DATA",
            "QUESTIONABLE DATA THROUGHOUT THE EVENT.",
            "CRUX MID UPPER RIGHT THORAX;QUESTIONABLE DATA PER VRTC",
            "NO VALID DATA BEFORE 12 MS",
            "data valid after 12 ms",
            "LOST COMMUNICATION",
        ] {
            check_remark(comment, Some(Remark::Invalid(None)));
        }
        check_remark("SPIKE AT 40 MS", Some(Remark::Doubtful(Some(0.04))));
        for comment in [
            "",
            "NO COMMENTS",
            "DRIVER SIDE FOOTREST",
            "NO FAILURE",
            "OK",
            "SEAT BELT CLIP",
            "FILTERED AT 1650 HZ",
            "TIME ZERO AT 20 MS",
        ] {
            check_remark(comment, None);
        }
    }
}
