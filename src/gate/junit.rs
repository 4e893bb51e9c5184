//! JUnit XML, as CI systems read it: a suite per design, a test per recording.
//!
//! # Source
//!
//! The schema `junit-10.xsd` of the Jenkins xUnit plugin, of which `time`, `timestamp` and
//! `hostname` are left out, so that the same answers give the same bytes.

use super::summary::{GateSummary, Pair, PairStanding};
use super::text;
use crate::pipeline::Answer;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};
use std::collections::BTreeMap;
use std::io;

/// Most tests: one CI system refuses more in a file, another more than 250 000 nodes.
const TESTS_MAX: usize = 5000;

/// Longest message [characters].
const MESSAGE_MAX: usize = 2000;

/// A test of the file.
struct Case {
    suite: String,
    name: String,
    outcome: TestOutcome,
    message: String,
    /// What stands as text within it.
    text: String,
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

/// Returns the file. All that is not as required comes first; where there are more pairs than a
/// file may hold tests, the others stand as one test per recording.
#[must_use]
pub fn render(summary: &GateSummary) -> String {
    let mut suites: BTreeMap<String, Vec<Case>> = BTreeMap::new();
    for case in cases(summary) {
        suites.entry(case.suite.clone()).or_default().push(case);
    }
    let mut writer = Writer::new_with_indent(Vec::new(), b' ', 1);
    // Writing into memory does not fail.
    let _ = write(&mut writer, summary, &suites);
    let mut text = String::from_utf8_lossy(&writer.into_inner()).into_owned();
    text.push('\n');
    text
}

fn cases(summary: &GateSummary) -> Vec<Case> {
    let mut found: Vec<Case> = summary
        .problems
        .iter()
        .map(|problem| Case {
            suite: "gate".into(),
            name: problem.code.clone(),
            outcome: TestOutcome::Error,
            message: problem.text.clone(),
            text: String::new(),
        })
        .collect();
    let worst = summary.worst();
    let all = found.len() + summary.pairs.len();
    if all <= TESTS_MAX {
        let mut pairs: Vec<&Pair> = summary.pairs.iter().collect();
        pairs.sort_by_key(|pair| pair.rank());
        found.extend(pairs.into_iter().map(of_pair));
        return found;
    }
    let room = TESTS_MAX.saturating_sub(found.len() + 1);
    found.truncate(TESTS_MAX - 1);
    let shown = worst.len().min(room);
    found.extend(worst[..shown].iter().map(|pair| of_pair(pair)));
    if shown < worst.len() {
        found.push(Case {
            suite: "gate".into(),
            name: "further pairs".into(),
            outcome: TestOutcome::Failure,
            message: format!(
                "{} further pairs are not as required; summary.json lists them",
                worst.len() - shown
            ),
            text: String::new(),
        });
        return found;
    }
    let room = TESTS_MAX - found.len();
    let mut standing: BTreeMap<&str, usize> = BTreeMap::new();
    for pair in summary.pairs.iter().filter(|pair| pair.exit_code() == 0) {
        *standing.entry(&pair.recording).or_default() += 1;
    }
    let recordings = summary.recordings.iter().take(room).map(|recording| Case {
        suite: "recordings".into(),
        name: recording.name.clone(),
        outcome: TestOutcome::Passed,
        message: String::new(),
        text: format!(
            "{} of {} designs stand",
            standing.get(recording.name.as_str()).unwrap_or(&0),
            summary.designs.len()
        ),
    });
    found.extend(recordings);
    found
}

fn of_pair(pair: &Pair) -> Case {
    let outcome = match (pair.standing, pair.row.verdict) {
        (PairStanding::AsRequired, _) => TestOutcome::Passed,
        (PairStanding::Allowed | PairStanding::NoWorse, _) => TestOutcome::Skipped,
        (PairStanding::NotAsRequired, Answer::Unusable) => TestOutcome::Error,
        (PairStanding::NotAsRequired, _) => TestOutcome::Failure,
    };
    let what = format!("{}: {}", pair.row.verdict.name(), text::what(pair));
    Case {
        suite: pair.design.clone(),
        name: pair.recording.clone(),
        outcome,
        message: what.clone(),
        text: format!("{what}\nreport_id {}", pair.row.report_id),
    }
}

fn write(
    writer: &mut Writer<Vec<u8>>,
    summary: &GateSummary,
    suites: &BTreeMap<String, Vec<Case>>,
) -> io::Result<()> {
    let count = |cases: &[Case], outcome: TestOutcome| {
        cases
            .iter()
            .filter(|case| case.outcome == outcome)
            .count()
            .to_string()
    };
    writer.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let root = writer
        .create_element("testsuites")
        .with_attribute(("name", clean(&summary.gate).as_str()));
    root.write_inner_content(|writer| {
        for (name, cases) in suites {
            let suite = writer
                .create_element("testsuite")
                .with_attribute(("name", clean(name).as_str()))
                .with_attribute(("tests", cases.len().to_string().as_str()))
                .with_attribute(("failures", count(cases, TestOutcome::Failure).as_str()))
                .with_attribute(("errors", count(cases, TestOutcome::Error).as_str()))
                .with_attribute(("skipped", count(cases, TestOutcome::Skipped).as_str()));
            suite.write_inner_content(|writer| {
                cases.iter().try_for_each(|case| test(writer, case))
            })?;
        }
        Ok(())
    })?;
    Ok(())
}

fn test(writer: &mut Writer<Vec<u8>>, case: &Case) -> io::Result<()> {
    let element = writer
        .create_element("testcase")
        .with_attribute(("name", clean(&case.name).as_str()))
        .with_attribute((
            "classname",
            format!("latchgate.{}", clean(&case.suite)).as_str(),
        ));
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
