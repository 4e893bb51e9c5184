//! Progress of questions, requested once or streamed.

use crate::app::App;
use crate::clock::now_ms;
use crate::pool::{FirstAnswer, Progress, Step};
use crate::problem::{Placed, Problem};
use crate::store::{Job, JobState};
use axum::Json;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::sse::{Event, KeepAlive, KeepAliveStream, Sse};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use serde_json::{Value, json};
use std::convert::Infallible;
use std::time::Duration;
use tokio::sync::watch;
use tokio_stream::wrappers::{ReceiverStream, WatchStream};
use tokio_stream::{Stream, StreamExt};
use utoipa::ToSchema;

/// How far a job is.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub(super) struct JobStanding {
    /// The job.
    job: String,
    /// `queued`, `running`, `done` or `refused`.
    state: String,
    /// Where its steps are told as they happen (server-sent events).
    events: String,
    /// The report, once it is done.
    report_id: Option<String>,
    /// Where the verdict is, once it is done.
    verdict: Option<String>,
    /// What is done now, while it runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    doing: Option<Step>,
    /// Jobs that come before it, while it waits.
    #[serde(skip_serializing_if = "Option::is_none")]
    behind: Option<u64>,
    /// How long it has waited, or has been worked on [s].
    #[serde(skip_serializing_if = "Option::is_none")]
    since_s: Option<f64>,
    /// How long the work on such a verdict usually takes [s]; absent until one of its kind was made since the start.
    #[serde(skip_serializing_if = "Option::is_none")]
    usual_s: Option<f64>,
    /// The verdict, where it is known before its advice and report.
    first_answer: Option<FirstAnswer>,
    /// Why there is none, where it was refused.
    #[schema(value_type = Option<Object>)]
    problem: Option<Value>,
}

impl JobStanding {
    /// Describes a job at the point that `progress` says; what waits has a place in the queue.
    async fn of(app: &App, job: &Job, progress: &Progress) -> Result<Self, Problem> {
        let state = &progress.state;
        let id = job.id.clone();
        let place = match state {
            JobState::Queued => app.on_disk(move |parts| parts.ledger.place(&id)).await?,
            _ => None,
        };
        let waits = place.map(|place| (now_ms() - place.since_ms).max(0) as f64 / 1e3);
        let usual = (!state.has_ended()).then(|| app.crew.usual_time(&job.question));
        let job = &job.id;
        let report_id = match state {
            JobState::Done { report_id } => Some(report_id.clone()),
            _ => None,
        };
        Ok(Self {
            job: job.into(),
            state: state.name().into(),
            events: format!("/v1/jobs/{job}/events"),
            verdict: report_id.as_ref().map(|id| format!("/v1/verdicts/{id}")),
            report_id,
            doing: progress.step,
            behind: place.map(|place| place.behind),
            since_s: waits.or(progress.began.map(|began| seconds(began.elapsed()))),
            usual_s: usual.flatten().map(seconds),
            first_answer: progress.first_answer.clone(),
            problem: match state {
                JobState::Refused { problem } => Some(problem.clone()),
                _ => None,
            },
        })
    }
}

/// Returns a time in seconds, to the millisecond.
fn seconds(time: Duration) -> f64 {
    time.as_millis() as f64 / 1e3
}

/// Answers that a question became a job.
pub(super) async fn accepted(
    app: &App,
    job: &Job,
    progress: &Progress,
) -> Result<Response, Problem> {
    let place = [(header::LOCATION, format!("/v1/jobs/{}", job.id))];
    let standing = Json(JobStanding::of(app, job, progress).await?);
    Ok((StatusCode::ACCEPTED, place, standing).into_response())
}

/// Reads a problem back.
pub(super) fn problem_of(problem: Value) -> Problem {
    Problem::of_value(problem).unwrap_or_else(|| Problem::not_found("answer"))
}

/// Finds a job that is watched, and how far it is: it may have ended before it was watched.
async fn find(
    app: &App,
    id: String,
    watched: &watch::Receiver<Progress>,
) -> Result<(Job, Progress), Problem> {
    let job = app.on_disk(move |parts| parts.ledger.job(&id)).await?;
    let job = job.ok_or_else(|| Problem::not_found("such job"))?;
    let mut progress = Progress::from(job.state.clone());
    let watched = watched.borrow();
    if watched.state == progress.state {
        progress = watched.clone();
    }
    drop(watched);
    Ok((job, progress))
}

/// Says how far a job is.
#[utoipa::path(
    get, path = "/v1/jobs/{id}",
    params(("id" = String, Path, description = "The job")),
    responses(
        (status = 200, description = "How far it is", body = JobStanding),
    )
)]
pub(super) async fn get(
    State(app): State<App>,
    Placed(id): Placed<String>,
) -> Result<Json<JobStanding>, Problem> {
    let watched = app.crew.watch(&id);
    let (job, progress) = find(&app, id, &watched).await?;
    Ok(Json(JobStanding::of(&app, &job, &progress).await?))
}

/// Time after which the standing of a job is told again: its place in the queue changes by what others do.
const TOLD_AGAIN: Duration = Duration::from_secs(2);

/// Tells how far a job is as it goes: `progress` events with `part`, then one `done` or `refused`.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/events",
    params(("id" = String, Path, description = "The job")),
    responses(
        (status = 200, description = "Events", body = Object, content_type = "text/event-stream"),
    )
)]
pub(super) async fn events(
    State(app): State<App>,
    Placed(id): Placed<String>,
) -> Result<Events, Problem> {
    let watched = app.crew.watch(&id);
    let (job, now) = find(&app, id, &watched).await?;
    let changes = WatchStream::from_changes(watched.clone());
    let steps = tokio_stream::once(now).chain(changes);
    let steps = steps.timeout_repeating(tokio::time::interval(TOLD_AGAIN));
    Ok(event_stream(steps.then(move |step| {
        let progress = step.unwrap_or_else(|_| watched.borrow().clone());
        let (app, job) = (app.clone(), job.clone());
        async move {
            let event = event(&app, &job, &progress).await;
            (event, progress.state.has_ended())
        }
    })))
}

/// A stream of server-sent events.
pub(super) type Events = Sse<KeepAliveStream<ReceiverStream<Result<Event, Infallible>>>>;

/// Returns a stream of events up to the first that is marked as the last.
pub(super) fn event_stream(events: impl Stream<Item = (Event, bool)> + Send + 'static) -> Events {
    let (sender, received) = tokio::sync::mpsc::channel(4);
    tokio::spawn(async move {
        let mut events = std::pin::pin!(events);
        while let Some((event, ends)) = events.next().await {
            if sender.send(Ok(event)).await.is_err() || ends {
                return;
            }
        }
    });
    Sse::new(ReceiverStream::new(received)).keep_alive(KeepAlive::default())
}

async fn event(app: &App, job: &Job, progress: &Progress) -> Event {
    let standing = match JobStanding::of(app, job, progress).await {
        Ok(standing) => standing,
        Err(problem) => return Event::default().comment(problem.code),
    };
    let mut data = json!(standing);
    data["part"] = json!(progress.part);
    let name = match &progress.state {
        JobState::Done { .. } | JobState::Decided { .. } => "done",
        JobState::Refused { .. } => "refused",
        _ => "progress",
    };
    Event::default().event(name).data(data.to_string())
}
