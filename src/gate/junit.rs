//! JUnit XML, as CI systems read it: a suite per design, a test per recording.
//!
//! # Source
//!
//! The schema `junit-10.xsd` of the Jenkins xUnit plugin, without `timestamp` and `hostname`: the same
//! answers give the same bytes except for `time`. It is written by hand, since the output of the
//! libraries for this format does not fit that schema.

use super::pairs::{Pair, PairStanding};
use super::summary::{GateSummary, unwritten};
use super::text;
use crate::pipeline::Answer;
use latchgate_recording::error::Error;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};
use std::collections::BTreeMap;
use std::io;
use std::time::Duration;

/// Longest message [characters].
const MESSAGE_MAX: usize = 2000;

/// One `testcase` element.
struct TestCase {
    name: String,
    outcome: TestOutcome,
    /// What an overview shows in one line.
    brief: String,
    /// The whole message: it stands once in a case.
    message: String,
    /// Which report has the evidence; of a pass the message before it.
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

/// Writes the file; in a suite the worst comes first.
///
/// # Errors
///
/// [`latchgate_recording::error::ErrorKind::Io`] if it cannot be written.
pub fn write(summary: &GateSummary, out: &mut dyn io::Write) -> Result<(), Error> {
    let suites = suites(summary);
    let mut writer = Writer::new_with_indent(out, b' ', 1);
    document(&mut writer, summary, &suites)
        .and_then(|()| writer.get_mut().write_all(b"\n"))
        .map_err(unwritten)
}

/// Tests by suite. The flag is true for a design's suite: a design may be named `gate`, too.
type Suites<'a> = BTreeMap<(bool, &'a str), Vec<TestCase>>;

fn suites(summary: &GateSummary) -> Suites<'_> {
    let mut suites = Suites::new();
    for problem in &summary.problems {
        let suite = suites.entry((false, "gate")).or_default();
        suite.push(TestCase {
            name: problem.code.clone(),
            outcome: TestOutcome::Error,
            brief: problem.code.clone(),
            message: problem.text.clone(),
            text: String::new(),
            time: None,
        });
    }
    for standing in &summary.statics {
        let suite = suites.entry((true, &standing.design)).or_default();
        let outcome = match standing.holds {
            true => TestOutcome::Passed,
            false => TestOutcome::Failure,
        };
        suite.push(TestCase {
            name: "static".into(),
            brief: if standing.holds {
                "holds"
            } else {
                "does not hold"
            }
            .into(),
            message: standing.text(),
            text: match outcome {
                TestOutcome::Passed => standing.text(),
                _ => String::new(),
            },
            outcome,
            time: None,
        });
    }
    let mut numbers: Vec<usize> = (0..summary.pairs.len()).collect();
    numbers.sort_by_key(|&number| (summary.pairs[number].rank(), number));
    for number in numbers {
        let pair = &summary.pairs[number];
        let suite = suites.entry((true, &pair.design)).or_default();
        suite.push(pair_case(
            pair,
            summary.times.get(number).copied().flatten(),
        ));
    }
    suites
}

fn outcome(standing: PairStanding, verdict: Answer) -> TestOutcome {
    match (standing, verdict) {
        (PairStanding::AsRequired, _) => TestOutcome::Passed,
        (PairStanding::Allowed | PairStanding::NoWorse, _) => TestOutcome::Skipped,
        (PairStanding::NotAsRequired, Answer::Unusable) => TestOutcome::Error,
        (PairStanding::NotAsRequired, _) => TestOutcome::Failure,
    }
}

fn pair_case(pair: &Pair, time: Option<Duration>) -> TestCase {
    let message = format!("{}: {}", pair.row.verdict.name(), text::describe(pair));
    let outcome = outcome(pair.standing, pair.row.verdict);
    let id = format!("report_id {}", pair.row.report_id);
    TestCase {
        name: pair.recording.clone(),
        text: match outcome {
            TestOutcome::Passed => format!("{message}\n{id}"),
            _ => id,
        },
        brief: format!(
            "{}; {} required",
            pair.row.verdict.name(),
            pair.required.name()
        ),
        outcome,
        message,
        time,
    }
}

fn seconds(time: Duration) -> String {
    format!("{:.3}", time.as_secs_f64())
}

fn document(
    writer: &mut Writer<&mut dyn io::Write>,
    summary: &GateSummary,
    suites: &Suites<'_>,
) -> io::Result<()> {
    let count = |cases: &[TestCase], outcome: TestOutcome| {
        let cases = cases.iter().filter(|case| case.outcome == outcome);
        cases.count().to_string()
    };
    writer.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let root = writer
        .create_element("testsuites")
        .with_attribute(("name", clean(&summary.gate).as_str()));
    root.write_inner_content(|writer| {
        for ((_, name), cases) in suites {
            let times = cases.iter().filter_map(|case| case.time);
            let time = times.reduce(|sum, time| sum + time).map(seconds);
            let suite = writer
                .create_element("testsuite")
                .with_attribute(("name", clean(name).as_str()))
                .with_attribute(("tests", cases.len().to_string().as_str()))
                .with_attribute(("failures", count(cases, TestOutcome::Failure).as_str()))
                .with_attribute(("errors", count(cases, TestOutcome::Error).as_str()))
                .with_attribute(("skipped", count(cases, TestOutcome::Skipped).as_str()))
                .with_attributes(time.as_deref().map(|time| ("time", time)));
            suite.write_inner_content(|writer| {
                cases.iter().try_for_each(|case| test(writer, name, case))
            })?;
        }
        Ok(())
    })?;
    Ok(())
}

fn test(writer: &mut Writer<&mut dyn io::Write>, suite: &str, case: &TestCase) -> io::Result<()> {
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
                .with_attribute(("message", clean(&case.brief).as_str()))
                .with_attribute(("type", kind))
                .write_text_content(BytesText::new(&message))?;
        }
        if !text.is_empty() {
            writer
                .create_element("system-out")
                .write_text_content(BytesText::new(&text))?;
        }
        Ok(())
    })?;
    Ok(())
}

/// Replaces characters that XML 1.0 does not allow, and cuts a text that is too long.
fn clean(text: &str) -> String {
    let allowed = |c: char| {
        matches!(c, '\t' | '\n') || (!c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}'))
    };
    text.chars()
        .take(MESSAGE_MAX)
        .map(|c| if allowed(c) { c } else { '\u{fffd}' })
        .collect()
}
