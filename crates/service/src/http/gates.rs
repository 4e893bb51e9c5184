//! Gates: every stored recording of a list with every stored design of another.

use super::files;
use super::jobs::Events;
use crate::app::App;
use crate::auth::Visitor;
use crate::gate::{self, GateSubmission, PlannedGate};
use crate::problem::{Placed, Problem, Queried, bounded};
use crate::store::GateStanding;
use axum::Json;
use axum::extract::{Extension, State};
use axum::http::{StatusCode, header};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::time::Duration;
use tokio_stream::wrappers::ReceiverStream;
use utoipa::{IntoParams, ToSchema};

/// Time between two polls of a gate whose events are streamed.
const LOOK: Duration = Duration::from_millis(300);

/// How a gate is asked.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub(super) struct GateQuery {
    /// Name, of up to 64 letters.
    name: Option<String>,
    /// The gate to compare with, by its identity.
    baseline: Option<String>,
    /// Pairs of the baseline may be gone.
    allow_removed: Option<bool>,
    /// What was not as required in the baseline and is no worse is let stand.
    no_worse: Option<bool>,
    /// The day against which exceptions are held, `YYYY-MM-DD`; today unless stated.
    date: Option<String>,
}

/// How far a gate is.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub(crate) struct GateEntry {
    /// Its identity.
    pub(crate) id: String,
    /// Name.
    pub(crate) name: String,
    /// `running`, `done`, or `failed` where pairs were left undecided.
    pub(crate) state: String,
    /// Pairs of a recording and a design.
    pub(crate) pairs: u64,
    /// Pairs that are decided.
    pub(crate) decided: u64,
    /// What `latchgate gate` would end with, once it is done: 0 only if every pair is as required.
    pub(crate) exit_code: Option<u8>,
    /// Why it failed.
    #[schema(value_type = Option<Problem>)]
    pub(crate) problem: Option<Value>,
    /// Pairs that are not as required, once it is done.
    pub(crate) not_as_required: Option<u64>,
    /// The gate that it is compared with.
    pub(crate) baseline: Option<String>,
    /// When it came [ms since 1970].
    pub(crate) created_ms: i64,
    /// Addresses of its files, once it is done.
    pub(crate) files: Vec<String>,
}

impl GateEntry {
    /// Says how far a gate is.
    pub(crate) fn of(standing: GateStanding) -> Self {
        let GateStanding {
            gate,
            decided,
            outcome,
        } = standing;
        let state = match &outcome {
            None => "running",
            Some(outcome) if outcome.problem.is_some() => "failed",
            Some(_) => "done",
        };
        let names = outcome.iter().flat_map(|outcome| outcome.files.keys());
        let files = names.map(|name| format!("/v1/gates/{}/{name}", gate.id));
        Self {
            files: files.collect(),
            state: state.into(),
            problem: outcome.as_ref().and_then(|outcome| outcome.problem.clone()),
            pairs: (gate.recordings.len() * gate.designs.len()) as u64,
            decided,
            exit_code: outcome.as_ref().map(|outcome| outcome.exit_code),
            not_as_required: outcome.map(|outcome| outcome.not_as_required),
            id: gate.id,
            name: gate.name,
            baseline: gate.baseline,
            created_ms: gate.created_ms,
        }
    }
}

/// Finds a gate; makes its outcome if all pairs are decided.
pub(crate) async fn find(app: &App, id: &str) -> Result<GateStanding, Problem> {
    let gate_id = id.to_string();
    let standing = app
        .on_disk(move |parts| parts.ledger.gate(&gate_id))
        .await?
        .ok_or_else(|| Problem::not_found("such gate"))?;
    app.apart(move |parts| gate::settled(parts, standing)).await
}

/// Submits a gate: the gate file of the command line, whose `files` name stored recordings by name,
/// pattern or identity, and whose `file` names a stored design.
#[utoipa::path(
    post, path = "/v1/gates", params(GateQuery),
    request_body(content((String = "application/toml"), (String = "text/plain"))),
    responses(
        (status = 200, description = "It is done", body = GateEntry),
        (status = 202, description = "It is worked on; `Location` says where to look", body = GateEntry),
    )
)]
pub(super) async fn submit(
    State(app): State<App>,
    Extension(visitor): Extension<Visitor>,
    Queried(query): Queried<GateQuery>,
    text: Result<String, axum::extract::rejection::StringRejection>,
) -> Result<Response, Problem> {
    let text = text.map_err(|error| Problem::of_body(error.status(), error.body_text()))?;
    let name = query.name.unwrap_or_else(|| "gate".into());
    if name.is_empty() || name.chars().count() > 64 || name.contains(char::is_control) {
        return Err(Problem::bad_request("name: up to 64 letters"));
    }
    let submission = GateSubmission {
        name,
        text,
        baseline: query.baseline,
        allow_removed: query.allow_removed == Some(true),
        no_worse: query.no_worse == Some(true),
        date: query.date,
    };
    let submitting = app.clone();
    let id = app
        .apart(move |parts| {
            let PlannedGate {
                gate,
                pairs,
                pulses,
            } = gate::planned(parts, submission)?;
            if parts.ledger.gate(&gate.id)?.is_none() {
                submitting.admit_jobs(&visitor, pairs.len() as u64)?;
            }
            // Only now, so that a refused gate leaves nothing.
            for pulse in &pulses {
                parts.keep_pulse(pulse, &visitor.name)?;
            }
            parts.ledger.put_gate(&gate, pairs, &visitor.name)?;
            Ok(gate.id)
        })
        .await?;
    app.crew.ring();
    let entry = GateEntry::of(find(&app, &id).await?);
    let status = match entry.exit_code {
        Some(_) => StatusCode::OK,
        None => StatusCode::ACCEPTED,
    };
    let place = [(header::LOCATION, format!("/v1/gates/{id}"))];
    Ok((status, place, Json(entry)).into_response())
}

/// Which part of a list is wanted.
#[derive(Debug, Clone, Default, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub(crate) struct GatePart {
    /// What the part before returned as `next`.
    pub(crate) cursor: Option<i64>,
    /// Entries, 1 to 200.
    #[param(minimum = 1, maximum = 200)]
    pub(crate) limit: Option<u32>,
}

/// Part of a list of gates, the newest first.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub(crate) struct GateList {
    /// The gates.
    pub(crate) gates: Vec<GateEntry>,
    /// The `cursor` of the next part; absent at the end.
    pub(crate) next: Option<i64>,
    /// Rows that are damaged and left out; the log and `latchgate-serve fsck` name them.
    pub(crate) damaged: usize,
}

/// Lists gates, the newest first.
#[utoipa::path(
    get, path = "/v1/gates", params(GatePart),
    responses((status = 200, description = "A part of the list", body = GateList))
)]
pub(super) async fn list(
    State(app): State<App>,
    Queried(part): Queried<GatePart>,
) -> Result<Json<GateList>, Problem> {
    Ok(Json(listed(&app, part).await?))
}

pub(crate) async fn listed(app: &App, part: GatePart) -> Result<GateList, Problem> {
    let limit = bounded("limit", part.limit, 50, (1, 200))?;
    let page = app
        .on_disk(move |parts| parts.ledger.gates(part.cursor, limit))
        .await?;
    let (damaged, next) = (page.damaged.len(), page.next);
    let gates = page.entries.into_iter().map(GateEntry::of).collect();
    Ok(GateList {
        gates,
        next,
        damaged,
    })
}

/// Says how far a gate is.
#[utoipa::path(
    get, path = "/v1/gates/{id}",
    params(("id" = String, Path, description = "The gate's identity")),
    responses((status = 200, description = "How far it is", body = GateEntry))
)]
pub(super) async fn get(
    State(app): State<App>,
    Placed(id): Placed<String>,
) -> Result<Json<GateEntry>, Problem> {
    Ok(Json(GateEntry::of(find(&app, &id).await?)))
}

/// Tells how far a gate is as it goes: `progress` events, then one `done`.
#[utoipa::path(
    get, path = "/v1/gates/{id}/events",
    params(("id" = String, Path, description = "The gate's identity")),
    responses(
        (status = 200, description = "Events", body = Object, content_type = "text/event-stream"),
    )
)]
pub(super) async fn events(
    State(app): State<App>,
    Placed(id): Placed<String>,
) -> Result<Events, Problem> {
    let mut entry = GateEntry::of(find(&app, &id).await?);
    let (sender, received) = tokio::sync::mpsc::channel(4);
    tokio::spawn(async move {
        loop {
            let done = entry.exit_code.is_some();
            let data = serde_json::to_string(&entry).unwrap_or_default();
            let name = if done { "done" } else { "progress" };
            let event = Event::default().event(name).data(data);
            if sender.send(Ok(event)).await.is_err() || done {
                return;
            }
            let before = entry.decided;
            while entry.decided == before && entry.exit_code.is_none() {
                tokio::time::sleep(LOOK).await;
                if sender.is_closed() {
                    return;
                }
                match find(&app, &id).await {
                    Ok(standing) => entry = GateEntry::of(standing),
                    Err(_) => return,
                }
            }
        }
    });
    Ok(Sse::new(ReceiverStream::new(received)).keep_alive(KeepAlive::default()))
}

/// Sends a file of a gate: `summary.json`, `summary.csv`, `junit.xml`, `summary.md` or `index.html`.
#[utoipa::path(
    get, path = "/v1/gates/{id}/{file}",
    params(
        ("id" = String, Path, description = "The gate's identity"),
        ("file" = String, Path, description = "Its name")
    ),
    responses(
        (status = 200, description = "The file", content(
            (String = "text/html"), (String = "text/markdown"), (String = "text/csv"), (String = "application/xml"),
            (Object = "application/json"))),
    )
)]
pub(super) async fn file(
    State(app): State<App>,
    Placed((id, name)): Placed<(String, String)>,
) -> Result<Response, Problem> {
    let outcome = find(&app, &id).await?.outcome;
    let file = outcome.and_then(|outcome| outcome.files.get(&name).cloned());
    let file = file.ok_or_else(|| Problem::not_found("such file of this gate, or not yet"))?;
    let mut response = files::send(&app, &file).await?;
    files::contained(response.headers_mut());
    Ok(response)
}
