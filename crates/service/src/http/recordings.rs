//! Recordings: uploaded, listed, looked into.

use super::{Caller, upload};
use crate::app::App;
use crate::auth::Visitor;
use crate::clock::now_ms;
use crate::pool::{Answer, Order};
use crate::problem::{Placed, Problem, Queried, bounded};
use crate::store::{Deletion, ListedRecording, RecordingFilter, RecordingOrder, StoredRecording};
use axum::Json;
use axum::extract::{Extension, Request, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::sync::PoisonError;
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
    /// Who uploaded it.
    pub(crate) owner: String,
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
    pub(crate) fn of(stored: StoredRecording, mut listing: Value) -> Self {
        // A child lists what is in the recording; what it is, is said here.
        if let Some(keys) = listing.as_object_mut() {
            keys.retain(|key, _| !OWN_KEYS.contains(&key.as_str()));
        }
        Self {
            bytes: stored.manifest.bytes(),
            name: stored.manifest.name,
            id: stored.id,
            owner: stored.owner,
            created_ms: stored.created_ms,
            listing,
        }
    }
}

/// Keys of a recording beside its listing.
const OWN_KEYS: [&str; 5] = ["id", "name", "bytes", "owner", "created_ms"];

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
    let received =
        upload::receive(&app, stated.name, request, length, reserved.left_bytes()).await?;
    let owner = visitor.name.clone();
    let (id, is_new) = app
        .on_disk(move |parts| {
            let placing = parts.blobs.placing();
            let _together = placing.read().unwrap_or_else(PoisonError::into_inner);
            let manifest = received.keep()?;
            let is_new = parts.ledger.put_recording(&manifest, &owner, now_ms())?;
            Ok((manifest.id(), is_new))
        })
        .await?;
    drop(reserved);
    let recording = look(&app, &visitor.name, &id, None).await?;
    let status = if is_new {
        StatusCode::CREATED
    } else {
        StatusCode::OK
    };
    let place = [(header::LOCATION, format!("/v1/recordings/{id}"))];
    Ok((status, place, Json(recording)).into_response())
}

/// Finds a recording and what it holds, looked into by a child in the owner's turn where that is not known.
pub(crate) async fn look(
    app: &App,
    owner: &str,
    id: &str,
    request: Option<Value>,
) -> Result<Recording, Problem> {
    let recording_id = id.to_string();
    let stored = app
        .apart(move |parts| parts.recording(&recording_id))
        .await?;
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
    let manifest = Some(stored.manifest.clone());
    let (listing, lasts) = match app.crew.ask(owner, order, manifest).await {
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
    Extension(visitor): Extension<Visitor>,
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
    Ok(Json(look(&app, &visitor.name, &id, request).await?))
}

/// Which recordings are wanted.
#[derive(Debug, Clone, Default, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub(crate) struct Part {
    /// A part of the name, of who uploaded it, or of the identity.
    pub(crate) filter: Option<String>,
    /// The order: `newest` first unless stated.
    #[serde(default)]
    #[param(inline)]
    pub(crate) sort: RecordingOrder,
    /// What the part before returned as `next`.
    pub(crate) cursor: Option<i64>,
    /// Entries, 1 to 200.
    #[param(minimum = 1, maximum = 200)]
    pub(crate) limit: Option<u32>,
}

/// Part of a list of recordings.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub(crate) struct RecordingList {
    /// The recordings.
    pub(crate) recordings: Vec<ListedRecording>,
    /// The `cursor` of the next part; absent at the end.
    pub(crate) next: Option<i64>,
    /// Rows that are damaged and left out; the log and `latchgate-serve fsck` name them.
    pub(crate) damaged: usize,
}

/// Lists recordings.
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
    Ok(Json(listed(&app, part).await?))
}

pub(crate) async fn listed(app: &App, part: Part) -> Result<RecordingList, Problem> {
    let filter = RecordingFilter {
        text: part.filter,
        order: part.sort,
        after: part.cursor,
        limit: bounded("limit", part.limit, 50, (1, 200))?,
    };
    let page = app
        .on_disk(move |parts| parts.ledger.recordings(&filter))
        .await?;
    Ok(RecordingList {
        damaged: page.damaged.len(),
        recordings: page.entries,
        next: page.next,
    })
}

/// Deletes a recording: its files, what it holds, and of its reports all but the documents.
#[utoipa::path(
    delete, path = "/v1/recordings/{id}",
    params(("id" = String, Path, description = "The recording's identity")),
    responses(
        (status = 200, description = "What remains of it", body = Deletion),
    )
)]
pub(super) async fn delete(
    State(app): State<App>,
    Extension(visitor): Extension<Visitor>,
    Extension(caller): Extension<Caller>,
    Placed(id): Placed<String>,
) -> Result<Json<Deletion>, Problem> {
    Ok(Json(deleted(&app, id, visitor, caller).await?))
}

pub(crate) async fn deleted(
    app: &App,
    id: String,
    visitor: Visitor,
    caller: Caller,
) -> Result<Deletion, Problem> {
    let _turn = app.sweeping.lock().await;
    app.apart(move |parts| {
        parts.delete(std::slice::from_ref(&id), &visitor.name, "asked", caller)?;
        let deletion = parts.ledger.deletion(&id)?;
        deletion.ok_or_else(|| Problem::not_found("such recording"))
    })
    .await
}

/// Which part of a list is wanted.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub(super) struct DeletionPart {
    /// What the part before returned as `next`.
    cursor: Option<i64>,
    /// Entries, 1 to 200.
    #[param(minimum = 1, maximum = 200)]
    limit: Option<u32>,
}

/// Part of a list of deletions, the newest first.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub(super) struct DeletionList {
    deletions: Vec<Deletion>,
    /// The `cursor` of the next part; absent at the end.
    next: Option<i64>,
    /// Rows that are damaged and left out; the log and `latchgate-serve fsck` name them.
    damaged: usize,
}

/// Lists the recordings that were deleted, when and by whom.
#[utoipa::path(
    get, path = "/v1/deletions", params(DeletionPart),
    responses(
        (status = 200, description = "A part of the list", body = DeletionList),
    )
)]
pub(super) async fn deletions(
    State(app): State<App>,
    Queried(part): Queried<DeletionPart>,
) -> Result<Json<DeletionList>, Problem> {
    let limit = bounded("limit", part.limit, 50, (1, 200))?;
    let page = app
        .on_disk(move |parts| parts.ledger.deletions(part.cursor, limit))
        .await?;
    Ok(Json(DeletionList {
        damaged: page.damaged.len(),
        deletions: page.entries,
        next: page.next,
    }))
}
