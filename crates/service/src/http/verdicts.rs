//! Questions, answers and their files.

use super::files;
use super::jobs::{self, JobStanding};
use crate::app::{App, recording_of_pulse};
use crate::auth::Visitor;
use crate::pool::{Answer, How, Order, Progress, request_of};
use crate::problem::{Placed, Problem, Queried, bounded};
use crate::store::{
    Job, JobState, Question, Remake, ResultFilter, ResultOrder, StoreError, StoredResult, Summary,
};
use axum::Json;
use axum::extract::{Extension, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use latchgate::pipeline::{Document, NUMBERS_REVISION, pulse};
use latchgate::report::{REPORT_FILE, SERIES_FILE, VERDICT_FILE};
use maud::{Markup, PreEscaped, html};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::time::Duration;
use tokio::sync::watch;
use utoipa::{IntoParams, ToSchema};

/// A question.
#[derive(Debug, Clone, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Asking {
    /// The recording's identity, or the word of a pulse, `pulse:half-sine,peak=30g,duration=11ms`.
    recording: String,
    /// Settings by the words of the command line, `_` for `-`: how the recording is read,
    /// conditioned and judged.
    #[serde(default = "super::designs::empty")]
    #[schema(value_type = Object)]
    request: Value,
    /// The design: tables of a design file, or `name@version` of one that is kept.
    #[serde(default = "super::designs::empty")]
    #[schema(value_type = Object)]
    design: Value,
    /// Overrides of the design, `lever.preload_torque_nm=2.82`.
    #[serde(default)]
    set: Vec<String>,
}

/// How long a question waits.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub(super) struct Waiting {
    /// Seconds to wait for the answer before the question becomes a job, at most 60.
    #[param(minimum = 0, maximum = 60)]
    wait: Option<u32>,
}

/// Returns a question with every setting and every number of the design written out.
async fn question(app: &App, asking: Asking) -> Result<Question, Problem> {
    let request = request_of(&asking.request)?;
    let (design, design_name) =
        super::designs::resolved(app, &asking.design, &asking.set, &request).await?;
    Ok(Question {
        recording: asking.recording,
        request: json!(request),
        design: json!(design),
        design_name,
        decision_alone: false,
    })
}

/// Asks for a verdict.
#[utoipa::path(
    post, path = "/v1/verdicts", params(Waiting), request_body = Asking,
    responses(
        (status = 200, description = "The verdict, the document of the command line", body = Object),
        (status = 202, description = "It is worked on; `Location` says where to look", body = JobStanding),
    )
)]
pub(super) async fn submit(
    State(app): State<App>,
    Extension(visitor): Extension<Visitor>,
    Queried(waiting): Queried<Waiting>,
    asking: Result<Json<Asking>, axum::extract::rejection::JsonRejection>,
) -> Result<Response, Problem> {
    let wait = match waiting.wait {
        None => app.config.wait,
        stated => Duration::from_secs(u64::from(bounded("wait", stated, 0, (0, 60))?)),
    };
    let Json(asking) =
        asking.map_err(|error| Problem::of_body(error.status(), error.body_text()))?;
    let mut asking = asking;
    let pulse = if asking.recording.starts_with(pulse::PREFIX) {
        let pulse = recording_of_pulse(&asking.recording)?;
        asking.recording = pulse.id();
        Some(pulse)
    } else {
        None
    };
    let question = question(&app, asking).await?;
    let id = question.id();
    let job_id = id.clone();
    let earlier = app
        .on_disk(move |parts| match parts.ledger.job(&job_id) {
            // The job is replaced by a new one, since the question is at hand.
            Err(StoreError::Damaged { .. }) => Ok(None),
            earlier => earlier,
        })
        .await?;
    if let Some(Job {
        state: JobState::Done { report_id },
        ..
    }) = earlier
    {
        if let Some(pulse) = pulse.clone() {
            // Where it was deleted meanwhile, its report can be made again from now on.
            let (admitting, owner) = (app.clone(), visitor.name.clone());
            app.apart(move |parts| match parts.recording(&pulse.id()) {
                Ok(_) => Ok(()),
                Err(_) => {
                    admitting.admit_bytes(pulse.bytes())?;
                    parts.keep_pulse(&pulse, &owner)
                }
            })
            .await?;
        }
        match answered(&app, &report_id).await {
            Err(problem) if problem.code == "damaged" => {
                let job_id = id.clone();
                app.on_disk(move |parts| parts.ledger.requeue(&job_id))
                    .await?;
            }
            sent => return sent,
        }
    }
    let watched = app.crew.watch(&id);
    let (admitting, job_id) = (app.clone(), id.clone());
    let (job, is_new) = app
        .apart(move |parts| {
            if pulse.is_none() {
                parts.recording(&question.recording)?;
            }
            admitting.admit_jobs(&visitor, 1)?;
            // Only now, so that a refused question leaves nothing.
            if let Some(pulse) = pulse {
                parts.keep_pulse(&pulse, &visitor.name)?;
            }
            let submitted = parts.ledger.submit(&job_id, &question, &visitor.name);
            Ok(submitted?)
        })
        .await?;
    if is_new {
        app.crew.ring();
    }
    let running = watched.clone();
    match ended(&app, job.clone(), watched, wait).await? {
        JobState::Done { report_id } => answered(&app, &report_id).await,
        JobState::Refused { problem } => Err(jobs::problem_of(problem)),
        _ => {
            let progress = running.borrow().clone();
            jobs::accepted(&app, &job, &progress).await
        }
    }
}

/// Waits until a job has ended, or for `wait`; returns its state then.
async fn ended(
    app: &App,
    job: Job,
    mut watched: watch::Receiver<Progress>,
    wait: Duration,
) -> Result<JobState, Problem> {
    let ended = async {
        let mut state = job.state;
        while !state.has_ended() {
            if watched.changed().await.is_err() {
                // No more progress comes: the job has ended meanwhile, or the service ends.
                let id = job.id;
                let job = app.on_disk(move |parts| parts.ledger.job(&id)).await?;
                return Ok(job.map_or(JobState::Queued, |job| job.state));
            }
            state = watched.borrow_and_update().state.clone();
        }
        Ok::<_, Problem>(state)
    };
    match tokio::time::timeout(wait, ended).await {
        Ok(state) => state,
        Err(_) => Ok(JobState::Running),
    }
}

async fn result(app: &App, report_id: &str) -> Result<StoredResult, Problem> {
    let id = report_id.to_string();
    let stored = app.on_disk(move |parts| parts.ledger.result(&id)).await?;
    stored.ok_or_else(|| Problem::not_found("such verdict"))
}

/// Sends a verdict's document.
async fn answered(app: &App, report_id: &str) -> Result<Response, Problem> {
    let result = result(app, report_id).await?;
    let mut response = send_or_remake(app, &result, VERDICT_FILE, false).await?;
    let place = format!("/v1/verdicts/{report_id}");
    if let Ok(place) = place.parse() {
        response.headers_mut().insert(header::LOCATION, place);
    }
    Ok(response)
}

/// Asks what the nominal lever does, soon; nothing is kept.
#[utoipa::path(
    post, path = "/v1/what-if", request_body = Asking,
    responses(
        (status = 200, description = "The document of the nominal runs alone; its card, where HTML is asked for", content(
            (Object = "application/json"), (String = "text/html"))),
    )
)]
pub(super) async fn what_if(
    State(app): State<App>,
    Extension(visitor): Extension<Visitor>,
    headers: HeaderMap,
    asking: Result<Json<Asking>, axum::extract::rejection::JsonRejection>,
) -> Result<Response, Problem> {
    let Json(asking) =
        asking.map_err(|error| Problem::of_body(error.status(), error.body_text()))?;
    let question = question(&app, asking).await?;
    let recording_id = question.recording.clone();
    let stored = app
        .apart(move |parts| parts.recording(&recording_id))
        .await?;
    let order = Order::Answer {
        how: How::WhatIf,
        recording: question.recording,
        request: question.request,
        design: question.design,
        by: String::new(),
    };
    let asked = app.crew.ask(&visitor.name, order, Some(stored.manifest));
    match asked.await?.answer {
        Answer::WhatIf {
            document,
            angle_rad,
        } => {
            let accepted = headers.get(header::ACCEPT);
            if accepted.is_some_and(|kind| kind == "text/html") {
                let document: Document =
                    serde_json::from_value(document).map_err(|_| Problem::not_found("answer"))?;
                return Ok(card(&document, &angle_rad).into_response());
            }
            Ok(Json(document).into_response())
        }
        Answer::Problem { problem } => Err(jobs::problem_of(problem)),
        _ => Err(Problem::not_found("answer")),
    }
}

/// Returns the card of a what-if, with the data of its curve.
fn card(document: &Document, angle_rad: &[f32]) -> Markup {
    html! {
        (latchgate::report::html::answer(document))
        @if !angle_rad.is_empty() { script type="application/json" { (PreEscaped(json!(angle_rad).to_string())) } }
    }
}

/// Sends a verdict: the document of the command line, which never changes.
#[utoipa::path(
    get, path = "/v1/verdicts/{report_id}",
    params(("report_id" = String, Path, description = "The report's identity, with or without `.json`")),
    responses(
        (status = 200, description = "The document", body = Object),
        (status = 304, description = "As the client has it"),
    )
)]
pub(super) async fn get(
    State(app): State<App>,
    Placed(report_id): Placed<String>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let report_id = report_id.strip_suffix(".json").unwrap_or(&report_id);
    sent(&app, report_id, VERDICT_FILE, false, &headers).await
}

async fn sent(
    app: &App,
    report_id: &str,
    name: &str,
    download: bool,
    headers: &HeaderMap,
) -> Result<Response, Problem> {
    let result = result(app, report_id).await?;
    let own = files::headers_of_report(&result, name, download);
    let tag = own.get(header::ETAG).and_then(|tag| tag.to_str().ok());
    let is_cached = headers
        .get(header::IF_NONE_MATCH)
        .and_then(|value| value.to_str().ok())
        .is_some_and(|value| tag.is_some_and(|tag| value.contains(tag)));
    if is_cached && result.files.contains_key(name) {
        return Ok((StatusCode::NOT_MODIFIED, own).into_response());
    }
    send_or_remake(app, &result, name, download).await
}

/// Longest wait for a file that is made again.
const REMAKE: Duration = Duration::from_secs(60);

/// Sends a file of a report; one that was lost is made again first.
async fn send_or_remake(
    app: &App,
    result: &StoredResult,
    name: &str,
    download: bool,
) -> Result<Response, Problem> {
    let lost = match files::send_of_report(app, result, name, download).await {
        Err(problem) if problem.code == "damaged" => problem,
        // It was removed with its recording, and can be made again if that was uploaded again.
        Err(problem) if result.is_stripped && is_of_report(name) => problem,
        sent => return sent,
    };
    let (report_id, lost_name) = (result.report_id.clone(), name.to_string());
    let Some(made) = remade(app, &report_id, &lost_name).await? else {
        return Err(lost);
    };
    files::send_of_report(app, &made, name, download).await
}

/// Has the files that a page needs of a report made again, if they were lost.
pub(crate) async fn made_whole(app: &App, report_id: &str) -> Result<(), Problem> {
    for name in [VERDICT_FILE, SERIES_FILE] {
        let result = result(app, report_id).await?;
        let Some(file) = result.files.get(name) else {
            continue;
        };
        let sha256 = file.sha256.clone();
        let opened = app.on_disk(move |parts| parts.blobs.open(&sha256)).await;
        if opened.is_err_and(|problem| problem.code == "damaged") {
            remade(app, report_id, name).await?;
        }
    }
    Ok(())
}

/// Plots that a report may have.
const PLOTS: [&str; 8] = [
    "acceleration.svg",
    "amplitude-spectra.svg",
    "angle.svg",
    "drivers.svg",
    "event.svg",
    "phase-plane.svg",
    "spectrogram.svg",
    "spread.svg",
];

/// Returns true if a report may have a file of that name.
fn is_of_report(name: &str) -> bool {
    [VERDICT_FILE, SERIES_FILE, REPORT_FILE].contains(&name) || PLOTS.contains(&name)
}

/// Has a report with a lost file made again; `None` if that is impossible.
async fn remade(app: &App, report_id: &str, lost: &str) -> Result<Option<StoredResult>, Problem> {
    let (id, lost) = (report_id.to_string(), lost.to_string());
    let (remake_id, name) = (id.clone(), lost.clone());
    let remake = app
        .on_disk(move |parts| parts.ledger.remake(&remake_id, &name))
        .await?;
    let job = match remake {
        Remake::Waits(job) => job,
        Remake::Deleted(deletion) => return Err(Problem::deleted(&deletion)),
        Remake::OtherNumbers(revision) => {
            let text = format!(
                "{lost} of this report was lost; it was made with revision {revision} of the \
                 numbers, and this program has {NUMBERS_REVISION}: restore a backup, start that \
                 program on the data, or ask the question anew"
            );
            return Err(Problem::new(
                StatusCode::GONE,
                "other-numbers",
                "Lost, and made with other numbers",
                text,
            ));
        }
        Remake::Impossible => return Ok(None),
    };
    tracing::warn!(
        report_id,
        lost,
        "a file of a report was lost and is made again"
    );
    let watched = app.crew.watch(&job.id);
    app.crew.ring();
    match ended(app, job, watched, REMAKE).await? {
        JobState::Done { .. } => Ok(Some(result(app, &id).await?)),
        JobState::Refused { problem } => Err(jobs::problem_of(problem)),
        _ => {
            let text = format!("{lost} was lost and is made again; come back soon");
            Err(Problem::busy(StatusCode::SERVICE_UNAVAILABLE, text, 5))
        }
    }
}

/// How a file is wanted.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub(super) struct FileWanted {
    /// `true` for an attachment.
    download: Option<bool>,
}

/// Sends a file of a report: `report.html`, `series.csv`, `verdict.json`, or a plot as `.svg`.
#[utoipa::path(
    get, path = "/v1/verdicts/{report_id}/{file}",
    params(
        ("report_id" = String, Path, description = "The report's identity"),
        ("file" = String, Path, description = "Its name"),
        FileWanted
    ),
    responses(
        (status = 200, description = "The file", content(
            (String = "text/html"), (String = "text/csv"), (String = "image/svg+xml"),
            (Object = "application/json"), (Vec<u8> = "application/octet-stream"))),
        (status = 304, description = "As the client has it"),
    )
)]
pub(super) async fn file(
    State(app): State<App>,
    Placed((report_id, name)): Placed<(String, String)>,
    Queried(wanted): Queried<FileWanted>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    sent(
        &app,
        &report_id,
        &name,
        wanted.download == Some(true),
        &headers,
    )
    .await
}

/// Which verdicts are wanted.
#[derive(Debug, Clone, Default, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub(crate) struct Wanted {
    /// `pass`, `fail`, `undecided` or `unusable`.
    pub(crate) verdict: Option<String>,
    /// The recording's identity.
    pub(crate) recording: Option<String>,
    /// The design's name.
    pub(crate) design: Option<String>,
    /// A part of the name of file, channel or design, or of the report's identity.
    pub(crate) filter: Option<String>,
    /// The order: `newest` first unless stated.
    #[serde(default)]
    #[param(inline)]
    pub(crate) sort: ResultOrder,
    /// What the part before returned as `next`.
    pub(crate) cursor: Option<i64>,
    /// Entries, 1 to 200.
    #[param(minimum = 1, maximum = 200)]
    pub(crate) limit: Option<u32>,
}

/// A verdict in a list.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub(crate) struct VerdictEntry {
    /// The report's identity.
    pub(crate) report_id: String,
    /// The recording's identity.
    pub(crate) recording: String,
    /// When it was made [ms since 1970].
    pub(crate) created_ms: i64,
    /// What was judged, and how that came out.
    #[serde(flatten)]
    pub(crate) summary: Summary,
}

/// Part of a list of verdicts, the newest first.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub(crate) struct VerdictList {
    /// The verdicts.
    pub(crate) verdicts: Vec<VerdictEntry>,
    /// The `cursor` of the next part; absent at the end.
    pub(crate) next: Option<i64>,
    /// Rows that are damaged and left out; the log and `latchgate-serve fsck` name them.
    pub(crate) damaged: usize,
}

/// Lists verdicts, the newest first.
#[utoipa::path(
    get, path = "/v1/verdicts", params(Wanted),
    responses(
        (status = 200, description = "A part of the list", body = VerdictList),
    )
)]
pub(super) async fn list(
    State(app): State<App>,
    Queried(wanted): Queried<Wanted>,
) -> Result<Json<VerdictList>, Problem> {
    Ok(Json(listed(&app, wanted).await?))
}

pub(crate) async fn listed(app: &App, query: Wanted) -> Result<VerdictList, Problem> {
    let limit = bounded("limit", query.limit, 50, (1, 200))?;
    let filter = ResultFilter {
        verdict: query.verdict,
        recording: query.recording,
        design: query.design,
        text: query.filter,
        order: query.sort,
        after: query.cursor,
        limit,
    };
    let page = app
        .on_disk(move |parts| parts.ledger.results(&filter))
        .await?;
    let (damaged, next) = (page.damaged.len(), page.next);
    let verdicts = page.entries.into_iter().map(|stored| VerdictEntry {
        report_id: stored.report_id,
        recording: stored.recording,
        created_ms: stored.created_ms,
        summary: stored.summary,
    });
    let verdicts = verdicts.collect();
    Ok(VerdictList {
        verdicts,
        next,
        damaged,
    })
}
