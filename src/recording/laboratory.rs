//! The laboratory's own words: validity limits and faults that stand in comment text.
//!
//! Status codes often say that all is well where the comment says until when: "NO VALID DATA
//! AFTER 64.6 MILLISECONDS". The comment counts. What it says of a time is taken as the instant
//! on the file's clock from which the samples are no evidence. A comment that names an instant
//! and is not understood asks for a look: it may say the same in words that are not known here.
//!
//! - `tokens`: words, numbers and instants of a comment;
//! - `words`: the words that laboratories use, in capitals.

mod tokens;
mod words;

use super::Finding;
use super::words::{Words, word_list};
use tokens::{Token, instants, tokens};
use words::{
    AT, BEFORE, BETWEEN, COUNTED, DATA, DENIALS, DOUBTFUL_PHRASES, DOUBTS, FAULTS, FAULTS_ALONE,
    FAULTY_PHRASES, GOOD, LIMITING, MAY_BE_MISSING, NEEDED, NEEDED_OF_DATA, NO_COMMENTS,
    OF_SAMPLES, OFTEN_MISSPELT, OTHER_UNITS, STRETCH, UP_TO,
};

/// What a remark says of the samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Remark {
    /// They are no evidence: from an instant on the file's clock [s], or throughout.
    Invalid(Option<f64>),
    /// They are worth a look: from an instant on, or throughout.
    Doubtful(Option<f64>),
    /// An instant is named, and what happened then is not understood.
    Unclear,
}

impl Remark {
    /// Orders remarks: the higher, the less the samples are worth.
    fn weight(self) -> (u8, f64) {
        let early = |at_s: Option<f64>| at_s.map_or(f64::INFINITY, |at_s| -at_s);
        match self {
            Self::Unclear => (0, 0.0),
            Self::Doubtful(at_s) => (1, early(at_s)),
            Self::Invalid(at_s) => (2, early(at_s)),
        }
    }
}

/// Reads what a comment says of the samples; `None` if nothing.
pub(super) fn remark(comment: &str) -> Option<Remark> {
    let tokens = tokens(comment);
    let instants = instants(&tokens);
    let says = |list: &[&str]| {
        (0..tokens.len())
            .any(|index| tokens[index].is_one_of(list) && denial(&tokens, index).is_none())
    };
    // What cannot be placed counts throughout.
    let placed = !has_bare_instant(&tokens) && instants.iter().all(|(_, at_s)| at_s.is_some());
    let first = instants
        .iter()
        .filter_map(|(_, at_s)| *at_s)
        .min_by(f64::total_cmp)
        .filter(|_| placed);
    // "from 60 to 65 ms" names a stretch, not all that came before.
    let stretch = tokens
        .iter()
        .position(|token| token.is_one_of(&["FROM", "BETWEEN"]));
    let points_before = instants.iter().any(|(index, _)| {
        let from = index.saturating_sub(3);
        tokens[from..*index]
            .iter()
            .any(|token| token.is_one_of(&BEFORE))
            && stretch.is_none_or(|stretch| stretch >= *index)
    });
    let alone = tokens.len() == 1 && tokens[0].is_one_of(&FAULTS_ALONE);
    let misspelt = (0..tokens.len())
        .any(|index| tokens[index].resembles(&OFTEN_MISSPELT) && denial(&tokens, index).is_none());
    if says(&FAULTS)
        || alone
        || misspelt
        || has_phrase(&tokens, &FAULTY_PHRASES)
        || denies_what_is_needed(&tokens)
    {
        return Some(Remark::Invalid(first.filter(|_| !points_before)));
    }
    if is_all_there_is(&tokens, &instants) {
        return Some(Remark::Invalid(first));
    }
    // "valid 0-30 ms" is no less a limit than "valid 0 to 30 ms".
    let is_number = |index: usize| matches!(tokens.get(index), Some(Token::Number(_)));
    let in_stretch = instants
        .iter()
        .any(|(index, _)| *index > 0 && is_number(index - 1));
    let limited = tokens
        .iter()
        .any(|token| token.is_one_of(&LIMITING) || token.is_one_of(&BEFORE));
    if says(&GOOD) && (limited || in_stretch) && !instants.is_empty() {
        // "valid until 80 ms" against "valid after 10 ms", which spoils the start.
        return Some(Remark::Invalid(
            first.filter(|_| points_before || in_stretch),
        ));
    }
    if says(&DOUBTS) || has_phrase(&tokens, &DOUBTFUL_PHRASES) {
        return Some(Remark::Doubtful(first.filter(|_| !points_before)));
    }
    (!instants.is_empty()).then_some(Remark::Unclear)
}

/// Tells whether a denial takes the worth from the samples.
fn denies_what_is_needed(tokens: &[Token]) -> bool {
    (0..tokens.len()).any(|index| {
        let token = &tokens[index];
        if ![&GOOD, &NEEDED, &NEEDED_OF_DATA]
            .iter()
            .any(|list| token.is_one_of(list))
        {
            return false;
        }
        let Some(denial) = denial(tokens, index) else {
            return false;
        };
        if token.is_one_of(&GOOD) {
            return true;
        }
        if token.is_one_of(&NEEDED_OF_DATA) {
            return tokens[..denial]
                .iter()
                .rfind(|token| !token.is_one_of(&BETWEEN))
                .is_none_or(|token| token.is_one_of(&DATA));
        }
        let next = tokens[index + 1..]
            .iter()
            .find(|token| !token.is_one_of(&BETWEEN));
        token.is_one_of(&NEEDED) && !next.is_some_and(|token| token.is_one_of(&MAY_BE_MISSING))
    })
}

/// Tells whether a time is said to be all for which there are samples, or good ones: "ONLY 30 MS
/// OF DATA", "USE FIRST 30 MS ONLY".
fn is_all_there_is(tokens: &[Token], instants: &[(usize, Option<f64>)]) -> bool {
    let only = |token: &Token| token.is_one_of(&["ONLY", "NUR"]);
    tokens.iter().any(|token| token.is_one_of(&OF_SAMPLES))
        && instants.iter().any(|(index, _)| {
            let before = tokens[..*index]
                .iter()
                .rfind(|token| !token.is_one_of(&UP_TO) && !matches!(token, Token::Number(_)));
            before.is_some_and(only) || tokens.get(index + 2).is_some_and(only)
        })
}

/// Tells whether words that are harmless one by one stand together as in one of the phrases.
fn has_phrase(tokens: &[Token], phrases: &[Vec<Vec<&str>>]) -> bool {
    phrases.iter().any(|phrase| {
        (0..tokens.len()).any(|start| {
            let mut rest = tokens[start..].iter().enumerate();
            let fits = phrase.iter().enumerate().all(|(place, words)| {
                rest.find(|(_, token)| {
                    place == 0 || token.is_one_of(words) || !token.is_one_of(&BETWEEN)
                })
                .is_some_and(|(_, token)| token.is_one_of(words))
            });
            fits && denial(tokens, start).is_none()
        })
    })
}

/// Tells whether a number stands where an instant is expected, without a unit.
fn has_bare_instant(tokens: &[Token]) -> bool {
    (1..tokens.len()).any(|index| {
        let is_number = matches!(tokens[index], Token::Number(_));
        let before = tokens[..index].iter().rfind(|token| {
            !token.is_one_of(&BETWEEN) && !token.is_one_of(&["TIME", "ABOUT", "APPROX", "T"])
        });
        let stands_for_one =
            before.is_some_and(|token| token.is_one_of(&AT)) || tokens[index - 1].is_one_of(&["T"]);
        let after = tokens.get(index + 1);
        let has_unit =
            after.is_some_and(|token| token.is_one_of(&OTHER_UNITS) || token.exponent().is_some());
        // "from 60 to 65 ms": the unit stands at the second one.
        let in_stretch = after
            .is_some_and(|token| matches!(token, Token::Number(_)) || token.is_one_of(&STRETCH))
            && tokens[index + 1..]
                .iter()
                .take(3)
                .any(|token| token.exponent().is_some());
        is_number && stands_for_one && !has_unit && !in_stretch
    })
}

/// Characters of a note that are shown.
const LONGEST_NOTE: usize = 300;

/// Characters of a remark that are shown.
const LONGEST_REMARK: usize = 2000;

/// Returns the finding for a comment: what it says of the samples, and where it says nothing
/// of them that is known here, its text to be read by a person.
pub(super) fn told(comment: &str, instant: Option<f64>) -> Option<Finding> {
    finding(comment, instant).or_else(|| note(comment, instant))
}

/// Returns the finding for a comment that was cut into pieces at a fixed width.
///
/// Whether a blank was lost at a cut is not known: of all ways to join the pieces, the one that
/// leaves the samples the least worth counts.
pub(super) fn told_in_pieces(pieces: &[&str], instant: Option<f64>) -> Option<Finding> {
    joined(pieces)
        .into_iter()
        .filter_map(|text| Some((remark(&text)?.weight(), text)))
        .reduce(|worst, next| {
            let worse = next
                .0
                .0
                .cmp(&worst.0.0)
                .then(next.0.1.total_cmp(&worst.0.1));
            if worse.is_gt() { next } else { worst }
        })
        .and_then(|(_, text)| finding(&text, instant))
        .or_else(|| note(&pieces.join(" "), instant))
}

/// Cuts up to which every way of joining all pieces is looked at.
const ALL_WAYS: usize = 4;

/// Pieces that are looked at together where there are more.
const TOGETHER: usize = 3;

/// Joins pieces with and without blanks at the cuts.
fn joined(pieces: &[&str]) -> Vec<String> {
    let cuts = pieces.len().saturating_sub(1);
    if cuts <= ALL_WAYS {
        return (0..1_u32 << cuts)
            .map(|way| {
                let mut text = String::new();
                for (index, piece) in pieces.iter().enumerate() {
                    if index > 0 && (way >> (index - 1)) & 1 == 0 {
                        text.push(' ');
                    }
                    text.push_str(piece);
                }
                text
            })
            .collect();
    }
    let mut ways = vec![pieces.join(" "), pieces.concat()];
    // A comment of a few lines somewhere in many.
    ways.extend(pieces.windows(TOGETHER).flat_map(joined));
    ways
}

fn note(comment: &str, instant: Option<f64>) -> Option<Finding> {
    let words: Vec<String> = tokens(comment)
        .iter()
        .filter(|token| **token != Token::Break)
        .map(Token::shown)
        .collect();
    let nothing = words.is_empty() || NO_COMMENTS.contains(&words.join(" ").as_str());
    (!nothing).then(|| Finding {
        at_s: instant,
        ..Finding::info(
            "notes",
            format!(
                "the laboratory notes: \"{}\"",
                shortened(comment, LONGEST_NOTE)
            ),
        )
    })
}

fn shortened(comment: &str, most: usize) -> String {
    comment.trim().chars().take(most).collect()
}

/// Returns the finding for what a comment says; `instant` stands in for a remark without a
/// time of its own [s].
pub(super) fn finding(comment: &str, instant: Option<f64>) -> Option<Finding> {
    let comment = comment.trim();
    let remark = remark(comment)?;
    let comment = shortened(comment, LONGEST_REMARK);
    let (finding, at_s) = match remark {
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
        Remark::Unclear => (
            Finding::warning(
                "laboratory-remark",
                format!(
                    "the laboratory says of this channel: \"{comment}\"; what it says of that \
                     instant is not understood here: read it before the verdict is used"
                ),
            ),
            None,
        ),
    };
    Some(Finding {
        at_s: at_s.or(instant),
        ..finding
    })
}

/// Takes what the laboratory says of an instant outside of the record, from `start_s` to
/// `end_s` with samples `interval_s` apart [s], as said of all of it: clock or instant are not
/// what they seem.
pub(super) fn hold_against_record(
    finding: &mut Finding,
    start_s: f64,
    end_s: f64,
    interval_s: f64,
) {
    if finding.code != "invalid-by-laboratory" {
        return;
    }
    let Some(at_s) = finding.at_s else { return };
    // A curve may end with the last sample that is good.
    if (start_s - interval_s..=end_s + interval_s).contains(&at_s) {
        return;
    }
    finding.at_s = None;
    finding.text = format!(
        "{}; {at_s} s lies outside of the record, from {start_s} s to {end_s} s, so that no \
         sample is taken for good",
        finding.text
    );
}

/// What may stand between a denial and what is missing: "NO BUFFER OVERRUN".
static CARRIED: Words = word_list!("validity-carried");

/// Returns the index of the denial of a word: "no", "not" or the like before it.
fn denial(tokens: &[Token], index: usize) -> Option<usize> {
    let may_be_missing = tokens[index].is_one_of(&MAY_BE_MISSING);
    let at = tokens[..index].iter().rposition(|token| {
        let passed = token.is_one_of(&BETWEEN)
            || (may_be_missing && (token.is_one_of(&CARRIED) || token.is_one_of(&COUNTED)));
        !passed
    })?;
    // "0 samples dropped"
    let none = matches!(&tokens[at], Token::Number(Some((digits, _))) if digits == "0")
        && (may_be_missing || tokens[index].is_one_of(&COUNTED));
    (none || tokens[at].is_one_of(&DENIALS)).then_some(at)
}

#[cfg(test)]
mod tests {
    use super::{Remark, remark, told_in_pieces};

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
            ("NO VALID DATA AFTER .010 SECONDS", 0.01),
            ("NO VALID DATA AFTER 1.0E-2 S", 0.01),
            ("NO VALID DATA AFTER 10 MILISECONDS", 0.01),
            ("NO DATA AFTER 10 MILLISECONDS", 0.01),
            ("DATA NOT USEABLE AFTER 10 MS", 0.01),
            ("DO NOT USE DATA AFTER 10 MS", 0.01),
            ("DATA OK UNTIL 10 MS", 0.01),
            ("VALID DATA ENDS AT 10 MS", 0.01),
            ("DATA ENDS AT 10 MS", 0.01),
            ("DATA IS NOT CONSIDERED VALID AFTER 10 MS", 0.01),
            ("OVER RANGE AT 10 MS", 0.01),
            ("OVER-RANGE AT 10 MS", 0.01),
            ("OFF SCALE AT 10 MS", 0.01),
            ("REACHED FULL SCALE AT 10 MS", 0.01),
            ("FULL SCALE WAS REACHED AT 10 MS", 0.01),
            ("CABLE CUT AT 10 MS", 0.01),
            ("SENSOR CAME OFF AT 10 MS", 0.01),
            ("CHANNEL WENT OPEN AT 10 MS", 0.01),
            ("CHANNEL INOPERATIVE AFTER 10 MS", 0.01),
            ("DATA TRUNCATED AT 10 MS", 0.01),
            ("DISREGARD DATA AFTER 10 MS", 0.01),
            ("NO FAILURE, DATA LOST AFTER 10 MS", 0.01),
            ("NO VALID DATA AFTER 10 MS; TRIGGER AT 1 SECOND", 0.01),
            ("KEINE DATEN AB 10 MS", 0.01),
            ("ungültig ab 10 ms", 0.01),
            ("UNGUELTIG AB 10 MS", 0.01),
            ("Kabelbruch bei 10 ms", 0.01),
            ("DATA VALID 0-30 MS", 0.0),
            ("DATA VALID 0 TO 30 MS", 0.0),
            ("ONLY 30 MS OF DATA", 0.03),
            ("USE ONLY FIRST 30 MS", 0.03),
            ("USE FIRST 30 MS ONLY", 0.03),
            ("FLATLINED AT 30 MS", 0.03),
            ("CHANNEL DIED AT 30 MS", 0.03),
            ("SATURTED AT 30MS", 0.03),
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
            "QUES. DATA THROUGHOUT THE EVENT.",
            "NO DATA",
            "DID NOT RECORD",
            "ACCELEROMETER NOT RECORDED",
            "NO DATA CHANNEL FAILED",
            "WRONG POLARITY",
            "ERRONEOUS DATA",
            "DATA ERROR",
            "DATA COLLECTION ERROR",
            "SENSOR BOTTOMED OUT",
            "RAILED",
            "NOT MEASURED",
            "NOT INSTALLED",
            "UMBILICAL CUT",
            "QUESTIONALBE DATA",
            "INVAILD",
            "FLAT LINE",
            "MAXED OUT",
            "samples skipped",
            "buffer overrun",
            "buffer overrun, samples skipped",
            "dropped samples",
            "3 samples dropped",
            "missed data",
            "gap",
            "gap in data",
            "clip",
            "clipped",
            "OVL",
            "overload",
            "DAQ error",
            // Read in two ways, or without a unit: no sample is good.
            "NO VALID DATA AFTER 1,000 MS",
            "QUESTIONABLE AFTER 10",
            "NO VALID DATA AFTER T=10; TRIGGER AT 100 MS",
            "NO VALID DATA AFTER 10-2 S",
        ] {
            check_remark(comment, Some(Remark::Invalid(None)));
        }
        check_remark("SPIKE AT 40 MS", Some(Remark::Doubtful(Some(0.04))));
        for comment in [
            "POLARITY REVERSED",
            "AXES SWITCHED",
            "X AND Y AXES INTERCHANGED",
            "UNITS ARE M/S2",
            "DATA IN M/S/S",
            "CHANNEL MISLABELED",
        ] {
            check_remark(comment, Some(Remark::Doubtful(None)));
        }
        for comment in [
            "TIME ZERO AT 20 MS",
            "SOMETHING HAPPENED AT 10 MS",
            "CHANNEL OK, TRIGGER AT 20 MS",
        ] {
            check_remark(comment, Some(Remark::Unclear));
        }
        for comment in [
            "",
            "NO COMMENTS",
            "DRIVER SIDE FOOTREST",
            "NO FAILURE",
            "OK",
            "SEAT BELT CLIP",
            "FILTERED AT 1650 HZ",
            "ANTI-ALIAS CUT-OFF 1650 HZ, 5 V AT FULL SCALE",
            "NO DATA LOST",
            "NO DATA WAS LOST AFTER THE EVENT",
            "NO SIGNAL CONDITIONING USED",
            "SERIAL NUMBER NOT RECORDED",
            "IMPACT AT 15 M/S",
            "NO CLIPPING",
            "NOT CLIPPED",
            "NO DATA GAPS",
            "NO DATA ERROR",
            "NO BUFFER OVERRUN",
            "NO SENSOR OVERLOAD",
            "NO SAMPLES SKIPPED",
            "NO DROPPED SAMPLES",
            "0 samples dropped",
            "0 dropped samples",
            "DATA CORRECTED",
            "VALIDATED DATA",
            "OPERATIVE",
            "DETECTED BY SWITCH",
            "TEMPERATURE NOT MEASURED",
        ] {
            check_remark(comment, None);
        }
    }

    /// Words may be cut, and not be cut, in one comment.
    #[test]
    fn val_pieces_of_a_comment_are_joined_both_ways() {
        let filler = ["a word"; 8];
        for pieces in [
            &["no val", "id data after 10 ms"][..],
            &["no", "valid data after 10 ms"],
            &["no val", "id data", "after 10 ms"],
            &["no val", "id data after 1", "0 ms"],
            &[
                &filler[..],
                &["no val", "id data", "after 10 ms"],
                &filler[..],
            ]
            .concat(),
        ] {
            let finding = told_in_pieces(pieces, None).expect("a finding");
            assert_eq!(finding.code, "invalid-by-laboratory", "{pieces:?}");
            // From there on, or throughout where a reading has no instant.
            assert!(
                finding.at_s.is_none_or(|at_s| at_s <= 0.01),
                "{pieces:?}: {finding:?}"
            );
        }
        assert_eq!(
            told_in_pieces(&["door, lower", "hinge"], None).map(|finding| finding.code),
            Some("notes".into())
        );
    }

    /// The work grows with the length of a comment, not with its square.
    #[test]
    fn regress_long_comments_are_read_in_one_pass() {
        for (part, expected) in [
            ("TO 1 S ", Some(Remark::Unclear)),
            ("NO THE DATA ", Some(Remark::Invalid(None))),
            ("A CABLE THE ", None),
            ("AT THE 1 ", None),
        ] {
            assert_eq!(remark(&part.repeat(50_000)), expected, "{part}");
        }
    }
}
