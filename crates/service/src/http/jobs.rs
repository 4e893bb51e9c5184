//! Progress of questions, requested once or streamed.

use crate::app::App;
use crate::pool::{FirstAnswer, Progress};
use crate::problem::{Placed, Problem};
use crate::store::JobState;
use axum::Json;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::sse::{Event, KeepAlive, KeepAliveStream, Sse};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use serde_json::{Value, json};
use std::convert::Infallible;
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
    /// The verdict, where it is known before its advice and report.
    first_answer: Option<FirstAnswer>,
    /// Why there is none, where it was refused.
    #[schema(value_type = Option<Object>)]
    problem: Option<Value>,
}

impl JobStanding {
    fn of(job: &str, progress: &Progress) -> Self {
        let state = &progress.state;
        let report_id = match state {
            JobState::Done { report_id } => Some(report_id.clone()),
            _ => None,
        };
        Self {
            job: job.into(),
            state: state.name().into(),
            events: format!("/v1/jobs/{job}/events"),
            verdict: report_id.as_ref().map(|id| format!("/v1/verdicts/{id}")),
            report_id,
            first_answer: progress.first_answer.clone(),
            problem: match state {
                JobState::Refused { problem } => Some(problem.clone()),
                _ => None,
            },
        }
    }
}

/// Answers that a question became a job.
pub(super) fn accepted(job: &str, progress: &Progress) -> Response {
    let place = [(header::LOCATION, format!("/v1/jobs/{job}"))];
    let standing = Json(JobStanding::of(job, progress));
    (StatusCode::ACCEPTED, place, standing).into_response()
}

/// Reads a problem back.
pub(super) fn problem_of(problem: Value) -> Problem {
    Problem::of_value(problem).unwrap_or_else(|| Problem::not_found("answer"))
}

async fn state_of(app: &App, id: &str) -> Result<JobState, Problem> {
    let job_id = id.to_string();
    let job = app.on_disk(move |parts| parts.ledger.job(&job_id)).await?;
    Ok(job.ok_or_else(|| Problem::not_found("such job"))?.state)
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
    let state = state_of(&app, &id).await?;
    let mut progress = Progress::from(state);
    if progress.state == JobState::Running {
        progress.first_answer = watched.borrow().first_answer.clone();
    }
    Ok(Json(JobStanding::of(&id, &progress)))
}

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
    // The job may have ended before it was watched.
    let state = state_of(&app, &id).await?;
    let now = Progress::from(state);
    let steps = tokio_stream::once(now).chain(WatchStream::from_changes(watched));
    Ok(event_stream(steps.map(move |progress| {
        let event = event(&id, &progress);
        (event, progress.state.has_ended())
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

fn event(id: &str, progress: &Progress) -> Event {
    let mut data = json!(JobStanding::of(id, progress));
    data["part"] = json!(progress.part);
    let name = match &progress.state {
        JobState::Done { .. } | JobState::Decided { .. } => "done",
        JobState::Refused { .. } => "refused",
        _ => "progress",
    };
    Event::default().event(name).data(data.to_string())
}
