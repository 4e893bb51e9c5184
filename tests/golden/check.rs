//! What the answer to a case must hold.

use super::answer::{errors, inspect, judge, listing, written};
use super::{Case, Read};
use latchgate::document::json::render;
use latchgate::pipeline::{Control, Document, Error, Listing, Outcome, Request};
use latchgate_kernel::units::{AccelerationUnit, SampleRate};
use latchgate_recording::{Channel, Limits, ReadOptions, Selection, Source, Stated, card};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

/// Findings that speak of the conditioning and the replay, not of the file, and of the push, which is a
/// short formula.
const LEFT_ASIDE: &[&str] = &[
    "axis-accepted",
    "axis-unknown",
    "band-empty",
    "beyond-geometry",
    "clock-accepted",
    "filter-not-causal",
    "noise-accepted",
    "noise-short",
    "noise-unknown",
    "peak-in-end-padding",
    "polarity-undeclared",
];

/// A case that was judged.
pub(super) struct Judged {
    /// The exit code of its verdict.
    pub(super) code: i32,
    /// The document, read.
    pub(super) document: Value,
    /// All in which the answer differs from what was expected.
    pub(super) faults: Vec<String>,
}

/// Judges a case once and compares everything that is said of it.
pub(super) fn judged(case: &Case, path: &Path) -> Judged {
    let outcome = judge(case, path);
    let text = written(&outcome);
    let document: Value = serde_json::from_str(&text).unwrap();
    let inspected = inspect(case, path).map(|listing| {
        let text = render(&listing);
        let value = serde_json::from_str(&text).unwrap();
        (listing, text, value)
    });
    let message = errors(case, path, &outcome);
    let mut faults = differences(case, &outcome, &document, &message);
    match &case.read {
        Some(read) => {
            let listing = inspected.as_ref().map(|(_, _, listing)| listing);
            faults.extend(differences_of_reading(read, &document, listing));
        }
        // What `inspect` says of such a file is no promise of a verdict.
        None => {
            if let Ok((listing, ..)) = &inspected
                && let Some(channel) = &listing.replay.channel
            {
                faults.push(format!("inspect takes {channel} of a refused file"));
            }
        }
    }
    faults.extend(one_reading_differs(path));
    faults.extend(read_back_differs::<Document>(&text, &document));
    faults.extend(super::shown::faults(&outcome.document));
    if let Ok((listing, text, value)) = &inspected {
        faults.extend(read_back_differs::<Listing>(text, value));
        faults.extend(candidates_that_lead_nowhere(listing, path));
    }
    Judged {
        code: i32::from(outcome.document.verdict.exit_code()),
        document,
        faults,
    }
}

fn codes(findings: &Value) -> BTreeSet<String> {
    let listed = findings.as_array().unwrap().iter();
    listed
        .map(|finding| {
            let word = |key: &str| finding[key].as_str().unwrap().to_string();
            (word("severity"), word("code"))
        })
        .filter(|(_, code)| !LEFT_ASIDE.contains(&code.as_str()))
        .map(|(severity, code)| format!("{severity} {code}"))
        .collect()
}

fn hash(read: &Read) -> Option<String> {
    let channel = Channel {
        name: String::new(),
        unit: Some(AccelerationUnit::from_spelling(&read.unit).unwrap()),
        unit_source: "",
        start_s: read.start_s,
        rate: SampleRate::from_hertz(read.rate_hz).unwrap(),
        values: read.values.clone()?,
        stated: Stated::default(),
        findings: Vec::new(),
        pulse: None,
    };
    channel.content_sha256()
}

/// Differences, one sentence each.
#[derive(Default)]
struct Differences(Vec<String>);

impl Differences {
    fn same(&mut self, what: &str, found: impl ToString, expected: impl ToString) {
        let (found, expected) = (found.to_string(), expected.to_string());
        if found != expected {
            self.0
                .push(format!("{what}: expected {expected}, found {found}"));
        }
    }
}

/// Compares verdict, findings and message.
fn differences(case: &Case, outcome: &Outcome, document: &Value, message: &str) -> Vec<String> {
    let mut found = Differences::default();
    let code = i32::from(outcome.document.verdict.exit_code());
    found.same("exit code", code, case.exit);
    let expected: BTreeSet<String> = case.findings.iter().cloned().collect();
    found.same(
        "findings",
        format!("{:?}", codes(&document["findings"])),
        format!("{expected:?}"),
    );
    // What to choose from and what to try belong to the line before them.
    let leads_on = |line: &&str| {
        line.starts_with("  choose: latchgate replay ") || line.starts_with("  try: latchgate ")
    };
    found.same(
        "lines of the message",
        message.lines().filter(|line| !leads_on(line)).count(),
        usize::from(case.exit == 4),
    );
    for words in &case.says {
        if !message.contains(words.as_str()) {
            found.same("message", message, format!("one that holds `{words}`"));
        }
    }
    if case.read.is_none() {
        found.same("verdict", &document["verdict"], "\"unusable\"");
    }
    found.0
}

/// Compares channel, unit, clock and samples, with what `inspect` says of them.
fn differences_of_reading(
    read: &Read,
    document: &Value,
    inspected: Result<&Value, &Error>,
) -> Vec<String> {
    let mut found = Differences::default();
    let recording = &document["recording"];
    found.same(
        "channel",
        &recording["channel"],
        Value::from(read.channel.clone()),
    );
    found.same("unit", &recording["unit"], format!("\"{}\"", read.unit));
    found.same("samples", &recording["samples"], read.samples);
    let close = |found: &Value, expected: f64| {
        let found = found.as_f64().unwrap_or(f64::NAN);
        // Where time was mended, its rate is a measurement.
        let slack = if read.values.is_some() { 1e-12 } else { 1e-3 };
        (found - expected).abs() <= slack * expected.abs().max(1e-3)
    };
    for (key, expected) in [("sample_rate_hz", read.rate_hz), ("start_s", read.start_s)] {
        if !close(&recording[key], expected) {
            found.same(key, &recording[key], expected);
        }
    }
    if let Some(hash) = hash(read) {
        found.same(
            "hash of the signal",
            &recording["content_sha256"],
            format!("\"{hash}\""),
        );
    }
    // What `inspect` lists is what `replay` takes.
    match inspected {
        Err(error) => found.same("inspect", error, "a listing"),
        Ok(listing) => {
            let taken = &listing["replay"]["channel"];
            found.same("inspect takes", taken, &recording["channel"]);
            let mut channels = listing["channels"].as_array().unwrap().iter();
            let entry = channels.find(|entry| {
                entry["name"] == *taken && entry["content_sha256"] == recording["content_sha256"]
            });
            found.same(
                "status in the list of inspect",
                entry.map_or(&Value::Null, |entry| &entry["status"]),
                "\"taken\"",
            );
            let series = listing["series"]["time_s"].as_array();
            found.same(
                "samples of inspect's series",
                series.map_or(0, Vec::len),
                read.samples,
            );
        }
    }
    found.0
}

/// Each channel that is offered can be taken, and leads further.
fn candidates_that_lead_nowhere(listing: &Listing, path: &Path) -> Vec<String> {
    let mut faults = Vec::new();
    for offered in &listing.replay.candidates {
        let request = Request {
            channel: Some(offered.clone()),
            ..Request::default()
        };
        let choice = match self::listing(path, &request) {
            Ok(listing) => serde_json::to_string(&listing.replay).unwrap(),
            Err(error) => {
                faults.push(format!("{offered}: {error}"));
                continue;
            }
        };
        if choice.contains("several channels") || choice.contains("no channel") {
            faults.push(format!("{offered}: {choice}"));
        }
    }
    faults
}

/// Finds where one reading for the chosen channel and for all of them gives another answer than
/// two, with what a card or options could say.
fn one_reading_differs(path: &Path) -> Option<String> {
    let limits = Limits::default();
    let source = Source::File(path.to_path_buf());
    let card = card::read_beside(&source, &limits).ok().flatten();
    let card = card.map(|(card, _)| card).unwrap_or_default();
    let stated = ReadOptions {
        channel: card.channel,
        rate_hz: card.rate,
        unit: card.unit,
        unit_from_card: card.unit.is_some(),
        ..ReadOptions::default()
    };
    let rated = ReadOptions {
        rate_hz: Some(10_000.0),
        unit: Some(AccelerationUnit::StandardGravity),
        ..stated.clone()
    };
    let all = latchgate_recording::read(&source, &stated, Selection::Every, &limits);
    let channels = all.iter().flat_map(|all| &all.channels).take(3);
    let named = channels.map(|channel| ReadOptions {
        channel: Some(channel.name.clone()),
        ..stated.clone()
    });
    let ways: Vec<ReadOptions> = named.chain([stated.clone(), rated]).collect();
    ways.iter().find_map(|options| {
        let both = latchgate_recording::read_both(&source, options, &limits, &Control::default());
        let alone = |selection| latchgate_recording::read(&source, options, selection, &limits);
        let (chosen, every) = (alone(Selection::Lateral), alone(Selection::Every));
        (both.chosen != chosen || both.every != every).then(|| {
            format!("read once: {both:?}\nread twice: {chosen:?}\n{every:?}\n with {options:?}")
        })
    })
}

/// Finds a document that is not read back as it was written.
fn read_back_differs<T: Serialize + DeserializeOwned>(
    text: &str,
    written: &Value,
) -> Option<String> {
    let document: T = match serde_json::from_str(text) {
        Ok(document) => document,
        Err(error) => return Some(format!("cannot be read back: {error}")),
    };
    let again = serde_json::to_value(&document).unwrap();
    (again != *written).then(|| format!("read back as {again}, written as {written}"))
}
