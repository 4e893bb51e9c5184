//! Remarks: free words of laboratories and operators, for a person to read.
//!
//! Readers collect the texts and their places; this file makes findings of them, by one rule for all
//! formats. A remark with a fault word or an instant blocks the verdict, from that instant on where it is
//! plain, until a person has read it and accepted it by its text. Nothing else is understood: "no clipping"
//! blocks as "clipping" does. Every other remark on a channel is shown.
//!
//! - `reading`: fault words and instants of a text.

mod reading;

use super::channel_name::filtered::{Filtered, filter_in, says_unfiltered};
use super::channel_name::gravity::says_gravity;
use super::source::sha256;
use super::words::{Words, word_list};
use super::{Finding, Severity, Stated};
use crate::error::nearest_name;
use crate::setting::Setting;
use latchgate_kernel::units::SampleRate;
use reading::NamedInstant;
use std::collections::BTreeSet;

/// A remark that a person has read and accepts: it does not block any more.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AcceptedRemark {
    /// The remark as it is shown; the number of blanks in a row does not matter.
    pub text: String,
    /// True if the card beside the recording, not a setting, accepts it.
    pub by_card: bool,
}

impl AcceptedRemark {
    /// Returns the name of the card or setting that accepts it.
    fn acceptor(&self) -> String {
        match self.by_card {
            true => "the card".into(),
            false => Setting::AcceptedRemarks.to_string(),
        }
    }
}

/// Place of a remark, which decides what it concerns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum RemarkPlace {
    /// In the words on a channel: it may concern all of its samples.
    Channel,
    /// On a line apart from the samples: an instant there is mostly a date or a duration.
    Apart,
    /// Beside a sample, at that instant [s] if it is known: it concerns that sample and all after it.
    Beside(Option<f64>),
    /// Beside a sample, in a column of states, and not a word for a good sample.
    State(Option<f64>),
}

/// A text with its place.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Remark {
    /// Without breaks of lines and with single blanks.
    text: String,
    place: RemarkPlace,
    /// Introduction of the text: "the laboratory says of this channel".
    introduction: String,
}

/// Most characters of a remark that are shown.
const SHOWN: usize = 2000;

/// Most characters of a remark in the setting that accepts it.
const QUOTED: usize = 240;

impl Remark {
    /// Builds a remark of a text.
    pub(super) fn new(text: &str, place: RemarkPlace, introduction: impl Into<String>) -> Self {
        Self {
            text: in_a_line(text),
            place,
            introduction: introduction.into(),
        }
    }

    /// Builds a remark of the laboratory on a channel, perhaps cut into pieces at a fixed width.
    pub(super) fn of_channel<T: AsRef<str>>(pieces: &[T]) -> Self {
        let pieces: Vec<&str> = pieces.iter().map(AsRef::as_ref).collect();
        let introduction = "the laboratory says of this channel";
        Self::new(&pieces.join(" "), RemarkPlace::Channel, introduction)
    }

    /// Returns the text as it is shown and accepted.
    pub(super) fn shown(&self) -> String {
        let count = self.text.chars().count();
        if count <= SHOWN {
            return self.text.clone();
        }
        cut_to(SHOWN, &self.text, &tail(&self.text))
    }

    /// Returns the text of the setting that accepts it.
    fn quoted(&self) -> String {
        quoted(&self.shown())
    }

    /// Returns the doubt about the samples, and the instant from which it holds [s]; `None` without one.
    fn doubt(&self) -> Option<(String, Option<f64>)> {
        let reading = reading::read(&self.text);
        let from = match reading.instant {
            Some(NamedInstant::BadFrom(at_s)) => Some(at_s),
            _ => None,
        };
        let from = match self.place {
            RemarkPlace::Channel | RemarkPlace::Apart => from,
            // A text beside a sample with an instant of its own concerns both: the earlier one counts.
            RemarkPlace::Beside(at_s) | RemarkPlace::State(at_s) if reading.instant.is_none() => {
                at_s
            }
            RemarkPlace::Beside(at_s) | RemarkPlace::State(at_s) => {
                from.zip(at_s).map(|(a, b)| a.min(b))
            }
        };
        let doubt = match (reading.fault, self.place) {
            (Some(fault), _) => format!("\"{fault}\" is a fault word"),
            (None, RemarkPlace::State(_)) => "That does not mean a good sample".into(),
            (None, RemarkPlace::Apart) => return None,
            (None, _) if reading.instant.is_none() => return None,
            _ => "It names an instant".into(),
        };
        Some((doubt, from))
    }

    /// Returns the finding on it, on the file's clock.
    fn finding(&self, accepted: &[AcceptedRemark], span: Span) -> Option<Finding> {
        let reading = reading::read(&self.text);
        let (shown, quoted) = (self.shown(), self.quoted());
        let says = format!("{}: \"{shown}\"", self.introduction);
        let Some((doubt, from)) = self.doubt() else {
            let is_apart = self.place == RemarkPlace::Apart;
            let is_shown =
                !reading.is_empty && (!is_apart || reading.denies || reading.instant.is_some());
            let at_s = match self.place {
                RemarkPlace::Beside(at_s) => at_s,
                _ => None,
            };
            return is_shown.then(|| Finding::info("laboratory-remark", says).since(at_s));
        };
        let outside = from.filter(|at_s| !span.holds(*at_s));
        let at_s = from.filter(|_| outside.is_none());
        let accepted = accepted.iter().find(|acceptance| {
            let text = in_a_line(&acceptance.text);
            text == quoted || text == shown
        });
        let finding = match accepted {
            Some(acceptance) => {
                let acceptor = acceptance.acceptor();
                let text = format!(
                    "{says}. {doubt}. A person accepted the remark, by {acceptor}. Read it before you \
                     use the verdict"
                );
                Finding::warning("remark-accepted", text)
            }
            None => {
                let bad = match (at_s, outside) {
                    (Some(_), _) => "no sample from there on counts".into(),
                    (None, Some(at_s)) => {
                        format!("no sample counts, since {at_s} s lies outside the record")
                    }
                    (None, None) => "no sample counts".to_string(),
                };
                let text = format!(
                    "{says}. {doubt}: {bad}. If you have checked the samples, accept this remark: \
                     {} = {}, or in the card {} = [{}]",
                    Setting::AcceptedRemarks,
                    quoted_for_a_shell(&quoted),
                    Setting::AcceptedRemarks.key(),
                    serde_json::Value::from(quoted.as_str())
                );
                Finding::blocking("laboratory-remark", text)
            }
        };
        Some(finding.since(at_s))
    }
}

/// The span of a record on the file's clock.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span {
    pub(super) start_s: f64,
    /// Time of the last sample [s].
    pub(super) end_s: f64,
    pub(super) interval_s: f64,
}

impl Span {
    pub(super) fn new(start_s: f64, rate: SampleRate, samples: usize) -> Self {
        Self {
            start_s,
            end_s: start_s + samples.saturating_sub(1) as f64 / rate.hertz(),
            interval_s: 1.0 / rate.hertz(),
        }
    }

    /// Returns the span that covers both.
    pub(super) fn with(self, other: Self) -> Self {
        Self {
            start_s: self.start_s.min(other.start_s),
            end_s: self.end_s.max(other.end_s),
            interval_s: self.interval_s.max(other.interval_s),
        }
    }

    /// True if an instant is in the span; a curve may end with the last good sample.
    pub(super) fn holds(self, at_s: f64) -> bool {
        (self.start_s - self.interval_s..=self.end_s + self.interval_s).contains(&at_s)
    }
}

/// Returns the tail of a cut text, which identifies it.
fn tail(text: &str) -> String {
    let hash = &sha256(text.as_bytes())[..16];
    format!("… [{} characters, SHA-256 {hash}]", text.chars().count())
}

fn cut_to(length: usize, text: &str, tail: &str) -> String {
    text.chars().take(length).chain(tail.chars()).collect()
}

/// Returns the text of the setting that accepts a remark, by the text as it is shown.
fn quoted(shown: &str) -> String {
    let count = shown.chars().count();
    if count <= QUOTED {
        return shown.to_string();
    }
    // A text longer than is shown has its tail already.
    let before = shown
        .char_indices()
        .nth(SHOWN)
        .map(|(index, _)| &shown[index..]);
    match before {
        Some(own_tail) => cut_to(QUOTED, shown, own_tail),
        None => cut_to(QUOTED, shown, &tail(shown)),
    }
}

/// Returns the texts of remarks as they are shown, without empty ones.
pub(super) fn shown(remarks: &[Remark]) -> Vec<String> {
    let speaks = |remark: &&Remark| !reading::read(&remark.text).is_empty;
    remarks.iter().filter(speaks).map(Remark::shown).collect()
}

/// Most findings of one severity; of more, only the number is shown.
const MOST: usize = 20;

/// Returns the findings of remarks, each instant on the file's clock.
pub(super) fn findings(
    remarks: &[Remark],
    accepted: &[AcceptedRemark],
    span: Span,
) -> Vec<Finding> {
    let mut seen_texts = BTreeSet::new();
    let mut findings = Vec::new();
    let mut more: [Option<(usize, Finding)>; 3] = Default::default();
    for remark in remarks {
        // Of lines with the same text one is enough.
        if remark.place == RemarkPlace::Apart && !seen_texts.insert(remark.text.as_str()) {
            continue;
        }
        let Some(finding) = remark.finding(accepted, span) else {
            continue;
        };
        let severity = finding.severity;
        let is_alike = |finding: &&Finding| finding.severity == severity;
        let before = findings.iter().filter(is_alike);
        if severity == Severity::Warning || before.count() < MOST {
            findings.push(finding);
            continue;
        }
        let (count, last) = more[severity as usize].get_or_insert_with(|| (0, finding.clone()));
        *count += 1;
        // The earliest instant counts, and no instant means the whole record.
        last.at_s = last.at_s.zip(finding.at_s).map(|(a, b)| a.min(b));
    }
    findings.extend(more.into_iter().flatten().map(|(count, last)| Finding {
        text: format!("{count} more remarks, shown when those that block are accepted"),
        ..last
    }));
    findings
}

/// Returns the instant from which remarks plainly call the samples of a channel bad [s].
pub(super) fn plainly_bad_from(remarks: &[Remark]) -> Option<f64> {
    let from = |remark: &Remark| remark.doubt().and_then(|(_, from)| from);
    remarks.iter().filter_map(from).min_by(f64::total_cmp)
}

/// Adds the remarks' words on gravity, and on a filter that was applied before the channel was stored, to
/// the stated facts.
pub(super) fn add_stated_filters(
    remarks: &[Remark],
    stated: &mut Stated,
    findings: &mut Vec<Finding>,
) {
    let is_on_channel = |remark: &&Remark| remark.place == RemarkPlace::Channel;
    for remark in remarks.iter().filter(is_on_channel) {
        stated.unfiltered |= says_unfiltered(&remark.text);
        stated.gravity |= says_gravity(&remark.text);
        match filter_in(&remark.text) {
            Some(Filtered::Class(class)) => {
                if stated.filter_class.as_ref() != Some(&class) {
                    findings.push(Stated::class_finding(&class));
                }
                stated.filter_class.get_or_insert(class);
            }
            Some(Filtered::Unclassed) => findings.push(Finding::filtered(&format!(
                "the laboratory says that the channel was filtered, but not with which class \
                 (\"{}\")",
                remark.shown()
            ))),
            None => {}
        }
    }
}

/// Returns the findings on acceptances without a remark: it was corrected or changed since.
pub(super) fn not_found(accepted: &[AcceptedRemark], remarks: &[String]) -> Vec<Finding> {
    // The comparison takes time as the product of the lengths, so it is bounded.
    let candidates: Vec<&str> = remarks.iter().take(100).map(String::as_str).collect();
    let absent = accepted.iter().filter(|acceptance| {
        let text = in_a_line(&acceptance.text);
        let matches = |shown: &String| *shown == text || quoted(shown) == text;
        !remarks.iter().any(matches)
    });
    absent
        .map(|acceptance| {
            let nearest = match nearest_name(&acceptance.text, &candidates) {
                Some(nearest) => format!("The nearest is \"{nearest}\""),
                None if candidates.is_empty() => "There is no remark".into(),
                None => "None is like it".into(),
            };
            let text = format!(
                "{} accepts the remark \"{}\", which is not there. {nearest}. Remove the \
                 acceptance",
                acceptance.acceptor(),
                acceptance.text
            );
            Finding::warning("accepted-remark-not-found", text)
        })
        .collect()
}

/// True if a text has a fault word.
pub(super) fn has_fault(text: &str) -> bool {
    reading::read(text).fault.is_some()
}

/// Names of entries with free words: keys of a header, columns of a table.
static KEYS: Words = word_list!("remark-keys");

/// True if a key or the name of a column announces free words.
pub(super) fn is_key(name: &str) -> bool {
    name.to_lowercase()
        .split(|c: char| !c.is_alphanumeric())
        .any(|word| KEYS.contains(&word))
}

/// Most different texts beside samples that are kept.
const KEPT: usize = 1000;

/// Words beside samples, as they are collected: each text with the first row that has it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Cells<Row> {
    texts: Vec<(Row, String)>,
    known: BTreeSet<String>,
    /// True if the texts are states, of which only some mean a good sample.
    states: bool,
    last: String,
}

impl<Row: Copy> Cells<Row> {
    pub(super) fn new(states: bool) -> Self {
        Self {
            texts: Vec::new(),
            known: BTreeSet::new(),
            states,
            last: String::new(),
        }
    }

    /// Keeps a text beside a sample, unless it is known already.
    pub(super) fn hear(&mut self, row: Row, text: &str) {
        if text == self.last || self.texts.len() > KEPT {
            return;
        }
        self.last = text.into();
        let text = in_a_line(text);
        if !text.is_empty() && self.known.insert(text.clone()) {
            self.texts.push((row, text));
        }
    }

    /// Returns each text once.
    pub(super) fn texts(&self) -> impl Iterator<Item = &str> {
        self.texts.iter().map(|(_, text)| &**text)
    }

    /// True if there were more texts than are kept.
    pub(super) fn is_full(&self) -> bool {
        self.texts.len() > KEPT
    }

    /// Returns the remarks; `place_of` returns the instant of a row [s] and its place in words, `name` is that
    /// of the column.
    pub(super) fn remarks(
        &self,
        name: &str,
        place_of: impl Fn(Row) -> (Option<f64>, String),
    ) -> Vec<Remark> {
        let remark = |(place, (row, text)): (usize, &(Row, String))| {
            let (at_s, beside) = place_of(*row);
            let introduction = format!("the column `{name}` says{beside}");
            // The texts beyond the limit are unknown, so they count as a bad state.
            let (text, more) = match place {
                KEPT => ("more texts than are read", true),
                _ => (text.as_str(), false),
            };
            let text = match self.states {
                true => format!("{name}: {text}"),
                false => text.into(),
            };
            let place = match self.states || more {
                true => RemarkPlace::State(at_s),
                false => RemarkPlace::Beside(at_s),
            };
            Remark::new(&text, place, introduction)
        };
        self.texts.iter().enumerate().map(remark).collect()
    }
}

/// Writes a text in one line: single blanks in place of breaks, of runs of blanks and of
/// characters that control a terminal.
fn in_a_line(text: &str) -> String {
    let controls = |c: char| {
        c.is_control()
            || matches!(c, '\u{200B}'..='\u{200F}' | '\u{2028}'..='\u{202E}' | '\u{2060}'..='\u{2069}' | '\u{FEFF}')
    };
    let words = text.split(|c: char| c.is_whitespace() || controls(c));
    let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
    words.join(" ")
}

/// Quotes a text so that a shell reads it as one word.
fn quoted_for_a_shell(text: &str) -> String {
    if text.contains(['"', '$', '`', '\\', '!']) {
        format!("'{}'", text.replace('\'', "'\\''"))
    } else {
        format!("\"{text}\"")
    }
}
