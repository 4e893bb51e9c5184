//! Gates on stored data: a gate file whose `files` name recordings and whose `file` names designs of the
//! store. Children decide the pairs; the library makes the outcome.

use crate::app::{App, Parts, recording_of_pulse};
use crate::clock::now_ms;
use crate::problem::Problem;
use crate::store::{
    Blobs, GateOutcome, GateRecording, GateStanding, Job, JobState, Ledger, ListedRecording,
    Manifest, Page, Question, RecordingFilter, StoreError, StoredDesign, StoredFile, StoredGate,
    sha256_hex,
};
use axum::http::StatusCode;
use glob::{MatchOptions, Pattern};
use latchgate::gate::plan::PlannedRecording;
use latchgate::gate::{
    self, Baseline, GateFile, GateSummary, JudgedRecording, Plan, SummaryOptions, file, junit,
    markdown, page,
};
use latchgate::pipeline::{
    Answer, DecisionRow, Design, Error, Limits, NUMBERS_REVISION, Reason, Request, apply_override,
    pulse,
};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::Read;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Largest number of recordings among which a gate's names are sought.
const LOOKED_THROUGH: u32 = 100_000;

/// Time between two polls for gates whose last pair is decided.
const LOOK: Duration = Duration::from_millis(500);

/// Time after which an outcome that could not be made is retried.
const AGAIN: Duration = Duration::from_secs(5);

/// Largest number of pairs not as required that get a full report.
const IN_FULL: usize = 50;

/// Submission of a gate: its file and settings.
#[derive(Debug, Clone, Default)]
pub struct GateSubmission {
    /// Name.
    pub name: String,
    /// The gate file.
    pub text: String,
    /// The gate to compare with.
    pub baseline: Option<String>,
    /// True if pairs of the baseline may be gone.
    pub allow_removed: bool,
    /// True if a pair that is no worse than in the baseline is accepted.
    pub no_worse: bool,
    /// Day at which exceptions must be valid; today unless stated.
    pub date: Option<String>,
}

/// A gate that can be submitted.
pub struct PlannedGate {
    /// The gate.
    pub gate: StoredGate,
    /// The question of each pair.
    pub pairs: Vec<Question>,
    /// Pulses among its recordings, which may not be kept yet.
    pub pulses: Vec<Manifest>,
}

/// Finds the recordings and designs that a gate file names; keeps nothing.
///
/// # Errors
///
/// A problem with everything that is wrong with the file, or that the baseline has no outcome.
pub fn planned(parts: &Parts, submission: GateSubmission) -> Result<PlannedGate, Problem> {
    let mut file = GateFile::from_toml(&submission.name, &submission.text, &Limits::default())
        .map_err(bad_gate)?;
    let pulses = pulses(&mut file)?;
    // Each pair is compared with each rule in this process, so their number is bounded.
    let rules = (file.require.len() + file.allow.len()) as u64;
    within("gate_rules", parts.config.gate_rules, rules, "rules")?;
    let mut errors = Vec::new();
    let recordings = recordings(&*parts.ledger, &file, &pulses, &mut errors)?;
    let mut versions = BTreeMap::new();
    let designs = designs(&*parts.ledger, &file, &mut versions, &mut errors)?;
    let count = (recordings.len() * designs.len()) as u64;
    within("gate_pairs", parts.config.gate_pairs, count, "pairs")?;
    let plan =
        Plan::from_parts(&submission.name, &file, recordings, designs, errors).map_err(bad_gate)?;
    if let Some(id) = &submission.baseline {
        baseline(parts, id)?;
    }
    let date = match submission.date {
        Some(date) if file::is_day(&date) => date,
        Some(date) => {
            let text = format!("date: a day such as 2027-03-31, found `{date}`");
            return Err(Problem::bad_request(text));
        }
        None => latchgate::pipeline::calendar::day(now_ms().div_euclid(86_400_000)),
    };
    let mut stored = StoredGate {
        id: String::new(),
        name: submission.name,
        text: submission.text,
        recordings: plan.recordings.iter().map(entered).collect(),
        designs: plan.designs.iter().map(|design| json!(design)).collect(),
        versions,
        baseline: submission.baseline,
        allow_removed: submission.allow_removed,
        no_worse: submission.no_worse,
        // Without exceptions the day has no effect, and must not change the gate's identity.
        date: if file.allow.is_empty() {
            String::new()
        } else {
            date
        },
        created_ms: 0,
    };
    stored.id = sha256_hex(format!("{NUMBERS_REVISION}{}", json!(stored)).as_bytes());
    stored.created_ms = now_ms();
    let pairs = (0..plan.recordings.len() * plan.designs.len())
        .map(|number| question(&stored, number, true))
        .collect();
    Ok(PlannedGate {
        gate: stored,
        pairs,
        pulses,
    })
}

/// Replaces each pulse among the files by its canonical word; returns the recordings that they are.
fn pulses(file: &mut GateFile) -> Result<Vec<Manifest>, Problem> {
    let mut pulses = Vec::new();
    let files = file
        .recordings
        .iter_mut()
        .flat_map(|entry| &mut entry.files);
    for word in files.filter(|word| word.starts_with(pulse::PREFIX)) {
        let pulse = recording_of_pulse(word)?;
        word.clone_from(&pulse.name);
        pulses.push(pulse);
    }
    Ok(pulses)
}

/// Refuses a gate beyond the limit of a key of the configuration.
fn within(key: &str, limit: u64, found: u64, what: &str) -> Result<(), Problem> {
    if found <= limit {
        return Ok(());
    }
    let way_out = format!("divide the gate, or raise `{key}` in the service's configuration");
    let (status, found) = (StatusCode::PAYLOAD_TOO_LARGE, format!("{found} {what}"));
    Err(Problem::over(status, key, limit, found, &way_out))
}

/// Returns the question of a pair, in the order of recordings, and of designs for each.
pub(crate) fn question(gate: &StoredGate, number: usize, decision_alone: bool) -> Question {
    let recording = &gate.recordings[number / gate.designs.len()];
    let design = &gate.designs[number % gate.designs.len()];
    let name = design["name"].as_str().unwrap_or("");
    Question {
        recording: recording.id.clone(),
        request: recording.request.clone(),
        design: design.clone(),
        design_name: gate.versions.get(name).cloned(),
        decision_alone,
    }
}

fn entered(recording: &PlannedRecording) -> GateRecording {
    GateRecording {
        name: recording.name.clone(),
        id: recording.path.display().to_string(),
        request: json!(*recording.request),
    }
}

/// Returns a problem with all mistakes of a gate file.
fn bad_gate(errors: Vec<Error>) -> Problem {
    let first = errors.first().map(Problem::of_recording);
    let texts: Vec<String> = errors.iter().map(ToString::to_string).collect();
    Problem {
        code: "bad-gate".into(),
        place: first.and_then(|problem| problem.place),
        ..Problem::bad_request(texts.join("\n"))
    }
}

/// Finds the recordings that the entries name, by name, pattern or identity: of one name the newest.
fn recordings(
    ledger: &dyn Ledger,
    file: &GateFile,
    pulses: &[Manifest],
    errors: &mut Vec<Error>,
) -> Result<Vec<PlannedRecording>, StoreError> {
    let Page {
        entries: mut stored,
        damaged,
        ..
    } = ledger.recordings(&RecordingFilter {
        limit: LOOKED_THROUGH,
        ..RecordingFilter::default()
    })?;
    // They are kept once the gate is admitted.
    stored.extend(pulses.iter().map(|pulse| ListedRecording {
        id: pulse.id(),
        name: pulse.name.clone(),
        bytes: pulse.bytes(),
        owner: String::new(),
        created_ms: 0,
        channels: None,
        verdicts: 0,
    }));
    let mut newest: BTreeMap<&str, &ListedRecording> = BTreeMap::new();
    for recording in &stored {
        newest.entry(&recording.name).or_insert(recording);
    }
    let mut planned_by_name: BTreeMap<String, PlannedRecording> = BTreeMap::new();
    for entry in &file.recordings {
        let request = Arc::new(entry.request.clone());
        for files in &entry.files {
            let is_identity = stored.iter().any(|recording| recording.id == *files);
            if let Some(what) = damaged.first().filter(|_| !is_identity) {
                // The damaged row might be one that the pattern means, and a gate must not omit it silently.
                let expected = format!("recordings that can be read to tell which `{files}` means");
                let hint = "upload that recording again, restore a backup, or name the recordings by identity";
                let found = format!("a damaged row: {what}");
                errors.push(Error::malformed(expected, found, hint).at(entry.place.clone()));
                continue;
            }
            let mut named = named(files, &stored, &newest).peekable();
            if named.peek().is_none() {
                let expected = format!("a stored recording named `{files}`");
                let hint = "upload it first, or mend the name; /recordings lists them, for programs /v1/recordings";
                errors.push(Error::malformed(expected, "none", hint).at(entry.place.clone()));
            }
            for (mut name, recording) in named {
                if let Some(channel) = &entry.request.channel {
                    name = format!("{name}#{channel}");
                }
                let planned = PlannedRecording {
                    name: name.clone(),
                    line: entry.place.line,
                    path: PathBuf::from(&recording.id),
                    request: Arc::clone(&request),
                };
                let differs = |earlier: &&PlannedRecording| {
                    earlier.path != planned.path || earlier.request != planned.request
                };
                let conflict = planned_by_name.get(&name).filter(differs);
                if conflict.is_some() {
                    let expected = format!("`{name}` with one setting");
                    let hint = "let one entry match it, or give it a channel in both";
                    let two = "two entries that judge it differently";
                    errors.push(Error::malformed(expected, two, hint).at(entry.place.clone()));
                }
                planned_by_name.insert(name, planned);
            }
        }
    }
    Ok(planned_by_name.into_values().collect())
}

/// Returns the recordings that a name, pattern or identity means, each with its name in the gate.
fn named<'a>(
    files: &'a str,
    stored: &'a [ListedRecording],
    newest: &'a BTreeMap<&str, &ListedRecording>,
) -> Box<dyn Iterator<Item = (String, &'a ListedRecording)> + 'a> {
    if let Some(recording) = stored.iter().find(|recording| recording.id == files) {
        let short = files.get(..8).unwrap_or(files);
        let name = format!("{}@{short}", recording.name);
        return Box::new(std::iter::once((name, recording)));
    }
    let options = MatchOptions {
        require_literal_separator: true,
        ..MatchOptions::new()
    };
    let pattern = Pattern::new(files).ok();
    let matches = move |name: &str| {
        name == files
            || pattern
                .as_ref()
                .is_some_and(|pattern| pattern.matches_with(name, options))
    };
    Box::new(
        newest
            .iter()
            .filter(move |(name, _)| matches(name))
            .map(|(name, recording)| ((*name).to_string(), *recording)),
    )
}

/// Reads the designs that the entries name: `name@version`, or `name` for the newest.
fn designs(
    ledger: &dyn Ledger,
    file: &GateFile,
    versions: &mut BTreeMap<String, String>,
    errors: &mut Vec<Error>,
) -> Result<Vec<Design>, StoreError> {
    let mut by_name: BTreeMap<String, Design> = BTreeMap::new();
    for entry in &file.designs {
        let (mut design, reference) = match &entry.file {
            None => (Design::reference(), None),
            Some(reference) => match StoredDesign::find(ledger, reference)? {
                Some(stored) => {
                    let reference = stored.reference();
                    let odd = |_| StoreError::Damaged {
                        what: format!("the design {reference}"),
                    };
                    let design = serde_json::from_value(stored.design).map_err(odd)?;
                    (design, Some(reference))
                }
                None => {
                    let expected = format!("a stored design named `{reference}`");
                    let hint = "submit it first, or mend the name; /designs lists them, for programs /v1/designs";
                    let error = Error::malformed(expected, "none", hint);
                    errors.push(error.at(entry.place.clone()));
                    continue;
                }
            },
        };
        let changed = entry
            .set
            .iter()
            .try_for_each(|text| apply_override(&mut design, text));
        if let Err(error) = changed.and_then(|()| Ok(design.validate()?)) {
            errors.push(error.at(entry.place.clone()));
        }
        if let Some(name) = &entry.name {
            design.name.clone_from(name);
        }
        if by_name.contains_key(&design.name) {
            let expected = format!("one design named `{}`", design.name);
            let error = Error::malformed(expected, "two", "give one of them another `name`");
            errors.push(error.at(entry.place.clone()));
        }
        let reference = reference.filter(|_| entry.set.is_empty());
        versions.extend(reference.map(|full| (design.name.clone(), full)));
        by_name.insert(design.name.clone(), design);
    }
    Ok(by_name.into_values().collect())
}

/// Reads a file of a gate's outcome.
pub(crate) fn read(blobs: &dyn Blobs, file: &StoredFile) -> Result<Vec<u8>, StoreError> {
    let mut bytes = Vec::new();
    blobs.open(&file.sha256)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn baseline(parts: &Parts, id: &str) -> Result<Baseline, Problem> {
    let standing = parts.ledger.gate(id)?;
    let standing = standing.ok_or_else(|| Problem::not_found("such baseline"))?;
    let Some(outcome) = settled(parts, standing)?.outcome else {
        let text = "the baseline is not decided yet; wait until it is";
        return Err(Problem::new(
            StatusCode::CONFLICT,
            "baseline-open",
            "Not yet",
            text,
        ));
    };
    let summary = outcome.files.get("summary.json");
    let summary = summary.ok_or_else(|| Problem::not_found("summary of the baseline"))?;
    let bytes = read(&*parts.blobs, summary)?;
    Baseline::from_json(id, &bytes).map_err(|error| Problem::of_recording(&error))
}

/// Makes the outcome of a gate whose pairs are all decided, unless it was made before.
///
/// # Errors
///
/// A problem if something cannot be read or kept.
pub fn settled(parts: &Parts, mut standing: GateStanding) -> Result<GateStanding, Problem> {
    let gate = &standing.gate;
    let count = gate.recordings.len() * gate.designs.len();
    if standing.outcome.is_some() || standing.decided < count as u64 {
        return Ok(standing);
    }
    let jobs = parts.ledger.pairs(&gate.id)?;
    if !jobs.iter().all(|job| job.state.has_ended()) {
        return Ok(standing);
    }
    standing.outcome = Some(match no_decision(&jobs) {
        Some(problem) => end_without(parts, gate, &problem)?,
        None => settle(parts, gate, decisions(gate, &jobs))?,
    });
    Ok(standing)
}

/// Returns a problem if the machine or the store left pairs without a decision. That is no fault of their
/// recordings, and the gate has no summary until it is submitted again.
fn no_decision(jobs: &[Job]) -> Option<Problem> {
    let lost = jobs.iter().filter_map(|job| match &job.state {
        JobState::Refused { problem } => problem["status"]
            .as_u64()
            .filter(|status| *status >= 500 || problem["code"] == "recording-deleted")
            .and(problem["detail"].as_str()),
        _ => None,
    });
    let lost: Vec<&str> = lost.collect();
    let first = lost.first()?;
    let detail = format!(
        "{} of {} pairs have no decision, the first because {first}; what is judged is kept, \
         submit the gate again to go on",
        lost.len(),
        jobs.len()
    );
    let title = "Pairs of the gate were not judged";
    let status = StatusCode::SERVICE_UNAVAILABLE;
    Some(Problem::new(status, "pairs-not-judged", title, detail))
}

/// Ends a gate with a problem. Submitting it again has the remaining pairs judged.
fn end_without(
    parts: &Parts,
    gate: &StoredGate,
    problem: &Problem,
) -> Result<GateOutcome, Problem> {
    tracing::warn!(gate = %gate.id, detail = %problem.detail, "a gate has no summary");
    let outcome = GateOutcome {
        exit_code: 4,
        not_as_required: (gate.recordings.len() * gate.designs.len()) as u64,
        files: BTreeMap::new(),
        problem: Some(problem.to_value()),
    };
    parts.ledger.end_gate(&gate.id, &outcome)?;
    Ok(outcome)
}

/// Makes the outcome of a gate out of its decisions, and keeps it.
fn settle(
    parts: &Parts,
    gate: &StoredGate,
    judged: Vec<JudgedRecording>,
) -> Result<GateOutcome, Problem> {
    let (plan, summary) = summed_up(parts, gate, judged)?;
    let mut files = BTreeMap::new();
    let odd = |error: Error| Problem::of_recording(&error);
    let mut keep = |name: &str, bytes: Vec<u8>| -> Result<(), StoreError> {
        let mut writer = parts.blobs.begin()?;
        writer.write(&bytes)?;
        files.insert(name.to_string(), writer.finish(name)?);
        Ok(())
    };
    let mut text = Vec::new();
    summary.write_json(&mut text).map_err(odd)?;
    keep("summary.json", text)?;
    let mut text = Vec::new();
    summary.write_csv(&mut text).map_err(odd)?;
    keep("summary.csv", text)?;
    let mut text = Vec::new();
    junit::write(&summary, &mut text).map_err(odd)?;
    keep("junit.xml", text)?;
    keep("summary.md", markdown::render(&summary).into_bytes())?;
    let text = page::render(&summary, &page::ReportFolders::new());
    keep("index.html", text.into_bytes())?;
    let outcome = GateOutcome {
        exit_code: summary.exit_code,
        not_as_required: summary.counts.not_as_required as u64,
        files,
        problem: None,
    };
    parts.ledger.end_gate(&gate.id, &outcome)?;
    for number in summary.worst().into_iter().take(IN_FULL) {
        let question = question(gate, number, false);
        let owner = format!("gate {}", plan.gate);
        parts.ledger.submit(&question.id(), &question, &owner)?;
    }
    parts.crew.ring();
    Ok(outcome)
}

/// Makes the outcome of every gate whose last pair is decided, until the service ends.
pub async fn keep(app: App) {
    let (mut last_ended, mut failed_since) = (None, None::<Instant>);
    loop {
        let counters = app.crew.counters();
        let ended = [&counters.jobs_done, &counters.jobs_refused];
        let ended = ended.map(|counter| counter.load(Ordering::Relaxed));
        let again = failed_since.is_some_and(|failed_since| failed_since.elapsed() > AGAIN);
        if last_ended != Some(ended) || again {
            last_ended = Some(ended);
            let is_whole = match app.apart(settle_open).await {
                Ok(is_whole) => is_whole,
                Err(problem) => {
                    tracing::warn!(problem = %problem.detail, "open gates cannot be looked at");
                    false
                }
            };
            failed_since = (!is_whole).then(Instant::now);
        }
        tokio::time::sleep(LOOK).await;
    }
}

/// Makes the outcome of every gate whose last pair is decided; false if one could not be made. The others are
/// made all the same.
fn settle_open(parts: &Parts) -> Result<bool, Problem> {
    let mut is_whole = true;
    for standing in parts.ledger.open_gates()?.entries {
        let gate = standing.gate.id.clone();
        if let Err(problem) = settled(parts, standing) {
            tracing::warn!(%gate, problem = %problem.detail, "an outcome cannot be made");
            is_whole = false;
        }
    }
    Ok(is_whole)
}

/// Compares the decisions of a gate with its requirements.
fn summed_up(
    parts: &Parts,
    gate: &StoredGate,
    judged: Vec<JudgedRecording>,
) -> Result<(Plan, GateSummary), Problem> {
    let limits = Limits::default();
    let file = GateFile::from_toml(&gate.name, &gate.text, &limits).map_err(bad_gate)?;
    let odd = |what: String| StoreError::Damaged { what };
    let request = |value: &Value| serde_json::from_value::<Request>(value.clone());
    let mut recordings = Vec::with_capacity(gate.recordings.len());
    for recording in &gate.recordings {
        recordings.push(PlannedRecording {
            name: recording.name.clone(),
            line: None,
            path: PathBuf::from(&recording.id),
            request: Arc::new(request(&recording.request).map_err(|e| odd(e.to_string()))?),
        });
    }
    let designs: Result<Vec<Design>, _> = gate
        .designs
        .iter()
        .map(|design| serde_json::from_value(design.clone()))
        .collect();
    let designs = designs.map_err(|error| odd(error.to_string()))?;
    let plan =
        Plan::from_parts(&gate.name, &file, recordings, designs, Vec::new()).map_err(bad_gate)?;
    let baseline_gate = gate.baseline.as_deref().map(|id| baseline(parts, id));
    let baseline_gate = baseline_gate.transpose()?;
    let options = SummaryOptions {
        date: &gate.date,
        baseline: baseline_gate.as_ref(),
        allow_removed: gate.allow_removed,
        no_worse: gate.no_worse,
    };
    let summary = gate::summarise(&plan, judged, options);
    Ok((plan, summary))
}

/// Collects the decisions of a gate from the jobs of its pairs.
fn decisions(gate: &StoredGate, jobs: &[Job]) -> Vec<JudgedRecording> {
    let mut judged = Vec::with_capacity(gate.recordings.len());
    for jobs in jobs.chunks(gate.designs.len()) {
        let rows: Vec<DecisionRow> = jobs.iter().zip(&gate.designs).map(row_of).collect();
        // All pairs of a recording share its file and channel, so any decided one has both.
        let read = jobs.iter().find_map(|job| match &job.state {
            JobState::Decided { row } => Some(row),
            _ => None,
        });
        let read = |key: &str| Some(read?[key].as_str()?.to_string());
        judged.push(JudgedRecording {
            sha256: read("sha256"),
            channel: read("channel"),
            rows,
            ..JudgedRecording::default()
        });
    }
    judged
}

/// Returns the row of a pair; unusable if its job has no answer.
fn row_of((job, design): (&Job, &Value)) -> DecisionRow {
    let refused = match &job.state {
        JobState::Decided { row } => {
            match serde_json::from_value(row.get("row").unwrap_or(row).clone()) {
                Ok(row) => return row,
                Err(error) => json!({"detail": error.to_string()}),
            }
        }
        JobState::Refused { problem } => problem.clone(),
        _ => Value::Null,
    };
    let word = |key: &str, other: &str| refused[key].as_str().unwrap_or(other).to_string();
    DecisionRow {
        report_id: job.id.clone(),
        verdict: Answer::Unusable,
        reason: Reason {
            code: word("code", "unreadable").into(),
            text: word("detail", "no decision was kept"),
        },
        threshold_rad: design["criterion"]["threshold_rad"]
            .as_f64()
            .unwrap_or_default(),
        peak_angle_rad: None,
        uncertainty_rad: None,
        coast_peak_angle_rad: None,
        share: None,
    }
}
