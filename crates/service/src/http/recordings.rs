//! Recordings: uploaded, listed, looked into.

use super::upload;
use crate::app::App;
use crate::auth::Visitor;
use crate::clock::now_ms;
use crate::pool::{Answer, Order};
use crate::problem::{Placed, Problem, Queried, bounded};
use crate::store::StoredRecording;
use axum::Json;
use axum::extract::{Extension, Request, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use utoipa::{IntoParams, ToSchema};

/// A recording and what it holds.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub(crate) struct Recording {
    /// Its identity: the same files under the same names have the same one.
    pub(crate) id: String,
    /// Name of the file, or of the folder that the files form.
    pub(crate) name: String,
    /// Bytes of all files.
    pub(crate) bytes: u64,
    /// When it came [ms since 1970].
    pub(crate) created_ms: i64,
    /// What it holds: `channels`, `candidates`, `findings`, `format`, the `channel` that a verdict
    /// would take and the `reason`, the first lines as `preview`, how a table was understood as `mapping`; `problem` where it cannot be read
    /// as asked for.
    #[serde(flatten)]
    #[schema(value_type = Object)]
    pub(crate) listing: Value,
}

impl Recording {
    pub(crate) fn of(stored: StoredRecording, listing: Value) -> Self {
        Self {
            bytes: stored.manifest.bytes(),
            name: stored.manifest.name,
            id: stored.id,
            created_ms: stored.created_ms,
            listing,
        }
    }
}

/// What an upload states.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub(super) struct Stated {
    /// The file's name, which readers go by; of a form the name of the folder that its files form.
    name: Option<String>,
}

/// Uploads a recording: the raw file, or a form with `file`, `card` and further parts.
#[utoipa::path(
    post, path = "/v1/recordings", params(Stated),
    request_body(content(
        (Vec<u8> = "application/octet-stream"),
        (Object = "multipart/form-data"),
    )),
    responses(
        (status = 201, description = "It is kept", body = Recording),
        (status = 200, description = "It was known", body = Recording),
    )
)]
pub(super) async fn submit(
    State(app): State<App>,
    Extension(visitor): Extension<Visitor>,
    Queried(stated): Queried<Stated>,
    request: Request,
) -> Result<Response, Problem> {
    let length = request.headers().get(header::CONTENT_LENGTH);
    let length = length.and_then(|length| length.to_str().ok()?.parse().ok());
    // Until what was sent is counted among what is kept.
    let reserved = app.reserve(&visitor.name, length).await?;
    let manifest = upload::receive(&app, stated.name, request, length, reserved.left()).await?;
    let id = manifest.id();
    let owner = visitor.name.clone();
    let is_new = app
        .on_disk(move |parts| parts.ledger.put_recording(&manifest, &owner, now_ms()))
        .await?;
    drop(reserved);
    let recording = look(&app, &id, None).await?;
    let status = if is_new {
        StatusCode::CREATED
    } else {
        StatusCode::OK
    };
    let place = [(header::LOCATION, format!("/v1/recordings/{id}"))];
    Ok((status, place, Json(recording)).into_response())
}

/// Finds a recording and what it holds, looked into by a child where that is not known.
pub(crate) async fn look(
    app: &App,
    id: &str,
    request: Option<Value>,
) -> Result<Recording, Problem> {
    let wanted = id.to_string();
    let stored = app
        .on_disk(move |parts| parts.ledger.recording(&wanted))
        .await?;
    let stored = stored.ok_or_else(|| Problem::not_found("such recording"))?;
    if let (Some(listing), None) = (&stored.listing, &request) {
        let mut listing = listing.clone();
        let program = without_program(&mut listing);
        let is_read = listing.get("problem").is_none();
        // Another program, or children that may take more, may read what ended its reader.
        if is_read || program.is_some_and(|program| program == app.ledger.program()) {
            return Ok(Recording::of(stored, listing));
        }
    }
    let keeps = request.is_none();
    let order = Order::Inspect {
        recording: stored.id.clone(),
        request: request.unwrap_or_else(|| json!({})),
    };
    let (listing, lasts) = match app.crew.ask(order, Some(stored.manifest.clone())).await {
        Ok(delivered) => match delivered.answer {
            Answer::Listing { listing } if listing.is_object() => (listing, true),
            Answer::Problem { problem } => (nothing_read(problem), false),
            _ => return Err(Problem::not_found("listing of this recording")),
        },
        // It stays kept; what it holds can be asked for again, but not if that ends its reader.
        Err(problem) => {
            let lasts = problem.code == "ends-its-reader";
            (nothing_read(problem.to_value()), lasts)
        }
    };
    if keeps && lasts {
        let (id, mut listing) = (stored.id.clone(), listing.clone());
        if listing.get("problem").is_some() {
            listing[PROGRAM] = json!(app.ledger.program());
        }
        app.on_disk(move |parts| parts.ledger.put_listing(&id, &listing))
            .await?;
    }
    Ok(Recording::of(stored, listing))
}

/// Key of a kept listing that says what could not read it.
const PROGRAM: &str = "program";

/// Takes out of a kept listing what could not read it.
fn without_program(listing: &mut Value) -> Option<Value> {
    listing.as_object_mut()?.remove(PROGRAM)
}

fn nothing_read(problem: Value) -> Value {
    json!({"channels": [], "candidates": [], "findings": [], "preview": [], "problem": problem})
}

/// How a recording is read.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub(super) struct Reading {
    /// Settings as a JSON object, for example `{"header_line": 3, "decimal": ","}`.
    request: Option<String>,
}

/// Says what a recording holds, as it is or as other settings read it.
#[utoipa::path(
    get, path = "/v1/recordings/{id}",
    params(("id" = String, Path, description = "The recording's identity"), Reading),
    responses(
        (status = 200, description = "What it holds", body = Recording),
    )
)]
pub(super) async fn get(
    State(app): State<App>,
    Placed(id): Placed<String>,
    Queried(reading): Queried<Reading>,
) -> Result<Json<Recording>, Problem> {
    let request = reading.request.map(|text| {
        serde_json::from_str::<Value>(&text)
            .map_err(|error| Problem::bad_request(format!("request: {error}")))
    });
    let request = request.transpose()?;
    if let Some(request) = &request {
        crate::pool::request_of(request)?;
    }
    Ok(Json(look(&app, &id, request).await?))
}

/// Which part of a list is wanted.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub(super) struct Part {
    /// What the part before returned as `next`.
    cursor: Option<i64>,
    /// Entries, 1 to 200.
    #[param(minimum = 1, maximum = 200)]
    limit: Option<u32>,
}

/// A recording in a list.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub(super) struct RecordingEntry {
    id: String,
    name: String,
    bytes: u64,
    created_ms: i64,
}

/// Part of a list of recordings, the newest first.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub(super) struct RecordingList {
    recordings: Vec<RecordingEntry>,
    /// The `cursor` of the next part; absent at the end.
    next: Option<i64>,
    /// Rows that are damaged and left out; the log and `latchgate-serve fsck` name them.
    damaged: usize,
}

/// Lists recordings, the newest first.
#[utoipa::path(
    get, path = "/v1/recordings", params(Part),
    responses(
        (status = 200, description = "A part of the list", body = RecordingList),
    )
)]
pub(super) async fn list(
    State(app): State<App>,
    Queried(part): Queried<Part>,
) -> Result<Json<RecordingList>, Problem> {
    let limit = bounded("limit", part.limit, 50, (1, 200))?;
    let found = app
        .on_disk(move |parts| parts.ledger.recordings(part.cursor, limit))
        .await?;
    let (damaged, next) = (found.damaged.len(), found.next);
    let recordings = found.entries.into_iter().map(|stored| RecordingEntry {
        bytes: stored.manifest.bytes(),
        name: stored.manifest.name,
        id: stored.id,
        created_ms: stored.created_ms,
    });
    let recordings = recordings.collect();
    Ok(Json(RecordingList {
        recordings,
        next,
        damaged,
    }))
}
