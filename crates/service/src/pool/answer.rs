//! A child's answer to each order; the only code that reads an upload.

use super::words::{Answer, Beat, FirstAnswer, How, Order, Step};
use crate::clock::now_ms;
use crate::problem::{Problem, for_http};
use crate::store::{Summary, sha256_hex};
use latchgate::pipeline::{
    self, Control, Design, Document, Evidence, Extras, Limits, Outcome, Prepared, Refused, Request,
    Source, design_from_json,
};
use latchgate::report;
use serde_json::{Map, Value, json};
use std::time::Instant;

/// Number of prepared recordings that are kept.
const PREPARED: usize = 4;

/// Number of lines of a text file in its preview.
const PREVIEW_LINES: usize = 24;

/// Largest number of letters of such a line.
const PREVIEW_LETTERS: usize = 200;

/// Largest number of samples of a what-if's curve.
const CURVE: usize = 200_000;

/// Files that go with an answer, names with bytes.
pub(super) type Files = Vec<(String, Vec<u8>)>;

/// Answers orders; keeps the recordings prepared last, the latest last.
#[derive(Debug, Default)]
pub(super) struct Worker {
    prepared: Vec<(String, Prepared)>,
}

impl Worker {
    /// Drops the prepared forms of recordings that are no longer held.
    pub(super) fn keep_only(&mut self, held_ids: &[String]) {
        self.prepared
            .retain(|(key, _)| held_ids.iter().any(|id| key.starts_with(id.as_str())));
    }

    /// Answers an order about `source`, whose text `head` begins with; `tell` takes each step of a verdict, and the
    /// verdict before its advice and report are worked out.
    pub(super) fn answer(
        &mut self,
        order: &Order,
        (source, head): (&Source, &[u8]),
        control: &Control<'_>,
        tell: &dyn Fn(Beat),
    ) -> (Answer, Files) {
        let answered = match order {
            Order::Inspect { request, .. } => inspect(source, request, head, control),
            Order::Answer {
                how,
                recording,
                request,
                design,
                by,
            } => {
                let question = (request, design, by.as_str());
                self.question(*how, (recording, source), question, control, tell)
            }
            Order::Try { trial } => Ok((super::trials::attempt(*trial), Files::new())),
        };
        answered.unwrap_or_else(|problem| {
            let problem = problem.to_value();
            (Answer::Problem { problem }, Files::new())
        })
    }

    /// Answers a question; an unusable recording gives a problem, or a row that says so.
    fn question(
        &mut self,
        how: How,
        (recording, source): (&str, &Source),
        (request, design, by): (&Value, &Value, &str),
        control: &Control<'_>,
        tell: &dyn Fn(Beat),
    ) -> Result<(Answer, Files), Problem> {
        /// Part of the work that is done with the verdict, about; its advice takes the rest.
        const VERDICT_PART: f64 = 0.2;
        let started = Instant::now();
        let begin = |step: Step, first_answer: Option<FirstAnswer>| {
            // Nobody follows the steps of the others, which are short.
            if how == How::Judge {
                tell(Beat {
                    step: Some(step),
                    first_answer,
                    ..Beat::default()
                });
            }
        };
        let mut stated = request.clone();
        if how == How::WhatIf
            && let Some(settings) = stated.as_object_mut()
        {
            settings.insert("members".into(), json!(0));
        }
        let question = request_of(&stated)?;
        let design = design_of(design, &question)?;
        begin(Step::Reading, None);
        let prepared = self.prepared(recording, source, (&stated, &question), control);
        begin(Step::Judging, None);
        if how == How::Decide {
            let (row, read) = match &prepared {
                Ok(prepared) => (prepared.row(&design, control), prepared.recording()),
                Err(refused) => (Ok(refused.row(&design)), refused.recording()),
            };
            let row = row.map_err(|error| Problem::of_recording(&error))?;
            let row = json!({"row": row, "sha256": read.sha256, "channel": read.channel});
            return Ok((Answer::Decision { row }, Files::new()));
        }
        let extras = Extras {
            filter_table: how == How::Judge,
            preload_answer: false,
            evidence: how != How::Decide,
        };
        let verdict_part = if how == How::Judge { VERDICT_PART } else { 1.0 };
        let (prepared, mut outcome) = match prepared {
            Ok(prepared) => control.during(0.0, verdict_part, |control| {
                (Some(prepared), prepared.judge(&design, extras, control))
            }),
            Err(refused) => (None, refused.outcome(&design)),
        };
        if outcome.refusal.is_some() {
            return Err(refusal(&outcome));
        }
        if let (How::Judge, Some(prepared)) = (how, prepared) {
            let first_answer = FirstAnswer {
                verdict: outcome.document.verdict.name().into(),
                headline: for_http(&report::headline(&outcome.document)),
            };
            begin(Step::Advising, Some(first_answer));
            let advised = control.during(verdict_part, 1.0, |control| {
                prepared.advise(&design, &mut outcome.document, control)
            });
            advised.map_err(|error| Problem::of_recording(&error))?;
            begin(Step::Reporting, None);
        }
        if how == How::WhatIf {
            let answer = Answer::WhatIf {
                document: json!(outcome.document),
                angle_rad: nominal_angle(outcome.evidence.as_ref()),
            };
            return Ok((answer, Files::new()));
        }
        let today = pipeline::calendar::day(now_ms().div_euclid(86_400_000));
        let run = &mut outcome.document.run;
        (run.elapsed_s, run.date) = (started.elapsed().as_secs_f64(), Some(today));
        if !by.is_empty() {
            run.by = Some(by.into());
        }
        let answer = Answer::Verdict {
            report_id: outcome.document.report_id.clone(),
            summary: Box::new(summary(&outcome.document)),
            content_sha256: content_sha256(&outcome.document),
        };
        Ok((answer, outcome.files()))
    }

    /// Returns a recording as read and conditioned for a request; prepares it unless it is kept.
    fn prepared(
        &mut self,
        recording: &str,
        source: &Source,
        (stated, request): (&Value, &Request),
        control: &Control<'_>,
    ) -> Result<&Prepared, Box<Refused>> {
        let key = format!("{recording}{stated}");
        let index = self
            .prepared
            .iter()
            .position(|(earlier_key, _)| *earlier_key == key);
        let prepared = match index {
            Some(index) => self.prepared.remove(index).1,
            None => Prepared::open(source, request, &Limits::default(), control)?,
        };
        if self.prepared.len() >= PREPARED {
            self.prepared.remove(0);
        }
        self.prepared.push((key, prepared));
        Ok(&self.prepared.last().expect("one was put there").1)
    }
}

/// Returns the angle of the nominal lever at each sample [rad]; nothing for a signal that is too long.
fn nominal_angle(evidence: Option<&Evidence>) -> Vec<f32> {
    let runs = evidence.map_or(&[][..], |evidence| &evidence.series.runs);
    let angle = runs.first().map_or(&[][..], |run| &run.angle_rad);
    if angle.len() > CURVE {
        return Vec::new();
    }
    // Single precision is finer than any drawing.
    angle.iter().map(|angle| *angle as f32).collect()
}

/// Reads settings as keys and values state them.
///
/// # Errors
///
/// A problem that names the key and what it takes.
pub(crate) fn request_of(request: &Value) -> Result<Request, Problem> {
    serde_json::from_value::<Request>(request.clone())
        .map_err(|error| error.to_string())
        .and_then(|request| match request.check() {
            Ok(()) => Ok(request),
            Err(error) => Err(error.to_string()),
        })
        .map_err(|detail| Problem {
            code: "bad-setting".into(),
            ..Problem::bad_request(format!("request: {detail}"))
        })
}

/// Reads a design as keys and values state it, and checks it with the question.
///
/// # Errors
///
/// A problem that names the key and what it takes.
pub(crate) fn design_of(design: &Value, request: &Request) -> Result<Design, Problem> {
    let bad = |detail: String| Problem {
        code: "bad-design".into(),
        ..Problem::bad_request(format!("design: {}", for_http(&detail)))
    };
    let mut design = design_from_json(design).map_err(bad)?;
    if design.name.is_empty() {
        design.name = "design".into();
    }
    request
        .check_design(&design)
        .map_err(|error| bad(error.to_string()))?;
    Ok(design)
}

fn refusal(outcome: &Outcome) -> Problem {
    let mut problem = match &outcome.refusal {
        Some(error) => Problem::of_recording(error),
        None => Problem::bad_request("nothing was judged"),
    };
    problem.candidates = outcome
        .offers
        .iter()
        .map(|offer| offer.channel.clone())
        .collect();
    problem.document = Some(json!(outcome.document));
    problem
}

fn summary(document: &Document) -> Summary {
    Summary {
        file: document.recording.file.clone(),
        channel: document.recording.channel.clone(),
        design: document.design.name.clone(),
        modified: changed(&document.design),
        changes: changes(&document.design),
        design_version: None,
        verdict: document.verdict.name().into(),
        headline: for_http(&report::headline(document)),
        opens_when: document.recording.opens_when.map(|sign| sign.name().into()),
        why: document
            .why
            .first()
            .map_or_else(String::new, |reason| for_http(&reason.text)),
        peak_angle_rad: document.nominal.as_ref().map(|run| run.peak_angle_rad),
        uncertainty_rad: document
            .nominal
            .as_ref()
            .and_then(|run| document.answer_of(run)?.uncertainty_rad),
        threshold_rad: document.threshold_rad,
        members: document
            .ensemble
            .as_ref()
            .map_or(0, |ensemble| u64::from(ensemble.members)),
    }
}

/// Lists the overridden numbers of a design, `key=value`.
fn changed(design: &Design) -> Vec<String> {
    let values = json!(design);
    let value = |key: &str| {
        let (table, name) = key.split_once('.').unwrap_or(("", key));
        format!("{key}={}", values[table][name])
    };
    design.modified.iter().map(|key| value(key)).collect()
}

/// Returns the overrides of a design in words; without any, its differences from the paper's design.
fn changes(design: &Design) -> String {
    let mut described = design.clone();
    if design.modified.is_empty() {
        let (values, paper) = (json!(design), json!(Design::reference()));
        for (table, numbers) in values.as_object().into_iter().flatten() {
            for (key, number) in numbers.as_object().into_iter().flatten() {
                let paper_value = paper[table][key].as_f64();
                if number.is_number() && number.as_f64() != paper_value {
                    let key = format!("{table}.{key}");
                    described
                        .modified_from
                        .extend(paper_value.map(|paper_value| (key.clone(), paper_value)));
                    described.modified.push(key);
                }
            }
        }
    }
    let words = report::full_design(&described);
    match words.strip_prefix(&design.name) {
        Some(changes) => changes.to_string(),
        // The words of the paper's design do not begin with its name.
        None => words
            .find(", modified: ")
            .map_or_else(String::new, |index| words[index..].to_string()),
    }
}

/// Hashes a document without what may differ between two runs.
fn content_sha256(document: &Document) -> String {
    let mut value = json!(document);
    if let Some(keys) = value.as_object_mut() {
        keys.remove("run");
    }
    sha256_hex(report::json::render(&value).as_bytes())
}

fn inspect(
    source: &Source,
    request: &Value,
    head: &[u8],
    control: &Control<'_>,
) -> Result<(Answer, Files), Problem> {
    let request = request_of(request)?;
    let listing = pipeline::inspect(source, &request, &Limits::default(), control)
        .map_err(|error| Problem::of_recording(&error));
    let mut value = Map::new();
    match listing {
        Ok(listing) => {
            let sparks = listing.channels.iter().map(|channel| channel.spark.clone());
            let mut channels = json!(listing.channels);
            for (channel, spark) in channels.as_array_mut().into_iter().flatten().zip(sparks) {
                channel["spark"] = json!(spark);
            }
            value.insert("format".into(), json!(listing.recording.format));
            value.insert("sha256".into(), json!(listing.recording.sha256));
            value.insert("channel".into(), json!(listing.replay.channel));
            let reason = listing.replay.reason.as_deref().map(for_http);
            value.insert("reason".into(), json!(reason));
            value.insert("channels".into(), channels);
            value.insert("candidates".into(), json!(listing.replay.candidates));
            value.insert("findings".into(), json!(listing.findings));
        }
        Err(problem) => {
            for list in ["channels", "candidates", "findings"] {
                value.insert(list.into(), json!([]));
            }
            value.insert("problem".into(), problem.to_value());
        }
    }
    let mapping = pipeline::table_mapping(source, &request, &Limits::default(), control);
    value.insert("mapping".into(), json!(mapping.ok().flatten()));
    value.insert("preview".into(), json!(preview(head)));
    let listing = Value::Object(value);
    Ok((Answer::Listing { listing }, Files::new()))
}

/// Returns the first lines of a text file; none of another.
fn preview(head: &[u8]) -> Vec<String> {
    let head = &head[..head.len().min(64 << 10)];
    if head.contains(&0) {
        return Vec::new();
    }
    let text = String::from_utf8_lossy(head);
    let lines = text.lines().take(PREVIEW_LINES);
    lines
        .map(|line| line.chars().take(PREVIEW_LETTERS).collect())
        .collect()
}
