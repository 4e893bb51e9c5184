//! JUnit XML, as CI systems read it: a suite per design, a test per recording.
//!
//! # Source
//!
//! The schema `junit-10.xsd` of the Jenkins xUnit plugin, of which `timestamp` and `hostname` are left
//! out: the same answers give the same bytes but for `time`. Writers for this format were not taken, since
//! theirs does not fit that schema.

use super::pairs::{Pair, PairStanding, Pairs};
use super::summary::{GateSummary, unwritten};
use super::text;
use crate::pipeline::Answer;
use latchgate_recording::error::Error;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};
use std::collections::BTreeMap;
use std::io;
use std::time::Duration;

/// Most tests: one CI system refuses more in a file, another more than 250 000 nodes.
const TESTS_MAX: usize = 5000;

/// Longest message [characters].
const MESSAGE_MAX: usize = 2000;

/// A test of the file, and what it is of.
enum Case {
    /// A pair, by its number.
    Pair(usize),
    /// Anything else.
    Other(Box<Written>),
}

/// A test as it is written.
struct Written {
    name: String,
    outcome: TestOutcome,
    message: String,
    /// What stands as text within it.
    text: String,
    time: Option<Duration>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum TestOutcome {
    Passed,
    /// Not as required.
    Failure,
    /// Could not be judged.
    Error,
    /// Let through by an exception, or no worse than the baseline.
    Skipped,
}

/// Writes the file. All that is not as required comes first; where there are more pairs than a
/// file may hold tests, the others stand as one test per recording.
///
/// # Errors
///
/// [`latchgate_recording::error::ErrorKind::Io`] if it cannot be written, or a decision no longer be read.
pub fn write(summary: &GateSummary, out: &mut dyn io::Write) -> Result<(), Error> {
    let suites = suites(summary);
    let mut writer = Writer::new_with_indent(out, b' ', 1);
    document(&mut writer, summary, &suites)
        .and_then(|()| writer.get_mut().write_all(b"\n"))
        .map_err(unwritten)
}

/// Tests by their suite: its name, after whether it is a design's, for a design may have any name.
type Suites<'a> = BTreeMap<(bool, &'a str), Vec<Case>>;

fn suites(summary: &GateSummary) -> Suites<'_> {
    let pairs = &summary.pairs;
    let mut own: Vec<Case> = summary
        .problems
        .iter()
        .map(|problem| {
            Case::Other(Box::new(Written {
                name: problem.code.clone(),
                outcome: TestOutcome::Error,
                message: problem.text.clone(),
                text: String::new(),
                time: None,
            }))
        })
        .collect();
    let (worst, not_as_required) = summary.standing(PairStanding::NotAsRequired);
    let all = own.len() + summary.counts.pairs.max(pairs.len());
    let mut listed: Vec<usize> = (0..pairs.len()).collect();
    let mut recordings = Vec::new();
    if all > TESTS_MAX {
        let room = TESTS_MAX.saturating_sub(own.len() + 1);
        own.truncate(TESTS_MAX - 1);
        listed = worst[..worst.len().min(room)].to_vec();
        // An exception is never left out while there is room.
        let allowed = pairs.standing(PairStanding::Allowed);
        listed.extend(allowed.into_iter().take(room - listed.len()));
        if not_as_required > room {
            own.push(Case::Other(Box::new(further(not_as_required - room))));
        } else {
            recordings = per_recording(summary, TESTS_MAX - own.len() - listed.len());
        }
    }
    listed.sort_by_key(|&number| pairs.rank(number));
    let mut suites = Suites::new();
    for (name, cases) in [("gate", own), ("recordings", recordings)] {
        if !cases.is_empty() {
            suites.insert((false, name), cases);
        }
    }
    let designs = summary.designs.len().max(1);
    for number in listed {
        let design = &summary.designs[pairs.place(number) % designs];
        suites
            .entry((true, &design.name))
            .or_default()
            .push(Case::Pair(number));
    }
    suites
}

fn further(left: usize) -> Written {
    Written {
        name: "further pairs".into(),
        outcome: TestOutcome::Failure,
        message: format!(
            "not as required: {}; the others are the worst",
            text::counted(left, "further pair")
        ),
        text: String::new(),
        time: None,
    }
}

/// One test per recording of which every pair stands, at most `most`; those of others are listed.
fn per_recording(summary: &GateSummary, most: usize) -> Vec<Case> {
    let designs = summary.designs.len();
    let pairs = &summary.pairs;
    let mut stands = vec![true; summary.recordings.len()];
    for index in pairs.worst() {
        // Where not all pairs are at hand the worst of each recording is.
        stands[pairs.place(index) / designs.max(1)] = false;
    }
    let named = summary.recordings.iter().zip(stands);
    let named = named.filter(|(_, stands)| *stands).take(most);
    named
        .map(|(recording, _)| {
            Case::Other(Box::new(Written {
                name: recording.name.clone(),
                outcome: TestOutcome::Passed,
                message: String::new(),
                text: format!("all stand: {}", text::counted(designs, "design")),
                time: None,
            }))
        })
        .collect()
}

fn outcome(standing: PairStanding, verdict: Answer) -> TestOutcome {
    match (standing, verdict) {
        (PairStanding::AsRequired, _) => TestOutcome::Passed,
        (PairStanding::Allowed | PairStanding::NoWorse, _) => TestOutcome::Skipped,
        (PairStanding::NotAsRequired, Answer::Unusable) => TestOutcome::Error,
        (PairStanding::NotAsRequired, _) => TestOutcome::Failure,
    }
}

impl Case {
    fn outcome(&self, pairs: &Pairs) -> TestOutcome {
        match self {
            Self::Pair(number) => {
                let mark = &pairs.marks()[*number];
                outcome(mark.standing, mark.verdict)
            }
            Self::Other(written) => written.outcome,
        }
    }
}

fn of_pair(pair: &Pair, time: Option<Duration>) -> Written {
    let what = format!("{}: {}", pair.row.verdict.name(), text::what(pair));
    Written {
        name: pair.recording.clone(),
        outcome: outcome(pair.standing, pair.row.verdict),
        message: what.clone(),
        text: format!("{what}\nreport_id {}", pair.row.report_id),
        time,
    }
}

/// Returns the time that a pair took, where it was judged in this run.
fn time_of(summary: &GateSummary, number: usize) -> Option<Duration> {
    *summary.times.get(summary.pairs.place(number))?
}

fn seconds(time: Duration) -> String {
    format!("{:.3}", time.as_secs_f64())
}

fn document(
    writer: &mut Writer<&mut dyn io::Write>,
    summary: &GateSummary,
    suites: &Suites<'_>,
) -> io::Result<()> {
    let count = |cases: &[Case], outcome: TestOutcome| {
        cases
            .iter()
            .filter(|case| case.outcome(&summary.pairs) == outcome)
            .count()
            .to_string()
    };
    writer.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let root = writer
        .create_element("testsuites")
        .with_attribute(("name", clean(&summary.gate).as_str()));
    root.write_inner_content(|writer| {
        for ((_, name), cases) in suites {
            let known = cases.iter().filter_map(|case| match case {
                Case::Pair(number) => time_of(summary, *number),
                Case::Other(_) => None,
            });
            let time = known.reduce(|sum, time| sum + time).map(seconds);
            let suite = writer
                .create_element("testsuite")
                .with_attribute(("name", clean(name).as_str()))
                .with_attribute(("tests", cases.len().to_string().as_str()))
                .with_attribute(("failures", count(cases, TestOutcome::Failure).as_str()))
                .with_attribute(("errors", count(cases, TestOutcome::Error).as_str()))
                .with_attribute(("skipped", count(cases, TestOutcome::Skipped).as_str()))
                .with_attributes(time.as_deref().map(|time| ("time", time)));
            suite.write_inner_content(|writer| {
                cases.iter().try_for_each(|case| match case {
                    Case::Other(written) => test(writer, name, written),
                    Case::Pair(number) => {
                        let pair = summary.pairs.get(*number).map_err(io::Error::other)?;
                        test(writer, name, &of_pair(&pair, time_of(summary, *number)))
                    }
                })
            })?;
        }
        Ok(())
    })?;
    Ok(())
}

fn test(writer: &mut Writer<&mut dyn io::Write>, suite: &str, case: &Written) -> io::Result<()> {
    let time = case.time.map(seconds);
    let element = writer
        .create_element("testcase")
        .with_attribute(("name", clean(&case.name).as_str()))
        .with_attribute(("classname", format!("latchgate.{}", clean(suite)).as_str()))
        .with_attributes(time.as_deref().map(|time| ("time", time)));
    let kind = match case.outcome {
        TestOutcome::Passed => None,
        TestOutcome::Failure => Some(("failure", "not-as-required")),
        TestOutcome::Error => Some(("error", "not-judged")),
        TestOutcome::Skipped => Some(("skipped", "let-through")),
    };
    let text = clean(&case.text);
    element.write_inner_content(|writer| {
        if let Some((name, kind)) = kind {
            let message = clean(&case.message);
            writer
                .create_element(name)
                .with_attribute(("message", message.as_str()))
                .with_attribute(("type", kind))
                .write_text_content(BytesText::new(&message))?;
        }
        if !text.is_empty() {
            // Some readers show this and nothing else.
            writer
                .create_element("system-out")
                .write_text_content(BytesText::new(&text))?;
        }
        Ok(())
    })?;
    Ok(())
}

/// Replaces what XML 1.0 does not allow, and cuts what is too long.
fn clean(text: &str) -> String {
    let allowed = |c: char| {
        matches!(c, '\t' | '\n') || (!c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}'))
    };
    text.chars()
        .take(MESSAGE_MAX)
        .map(|c| if allowed(c) { c } else { '\u{fffd}' })
        .collect()
}
