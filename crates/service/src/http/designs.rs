//! Designs by name and version; a version never changes.

use crate::app::App;
use crate::clock::now_ms;
use crate::pool::{design_of, request_of};
use crate::problem::{Placed, Problem};
use crate::store::StoredDesign;
use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use latchgate::pipeline::{Design, Request, apply_override};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use utoipa::ToSchema;

/// A design to keep.
#[derive(Debug, Clone, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct DesignSubmission {
    /// Name: letters, digits, `.`, `-` and `_`.
    name: String,
    /// The tables of a design file, or `name@version` of one that is kept.
    #[serde(default = "empty")]
    #[schema(value_type = Object)]
    design: Value,
    /// Overrides, `lever.preload_torque_nm=2.82`.
    #[serde(default)]
    set: Vec<String>,
}

/// A design that is kept.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub(super) struct KeptDesign {
    /// Name.
    name: String,
    /// Version, counted from 1.
    version: i64,
    /// Name and version, as questions use them.
    reference: String,
    /// Every number of it.
    #[schema(value_type = Object)]
    design: Value,
    /// When it came [ms since 1970].
    created_ms: i64,
}

impl From<StoredDesign> for KeptDesign {
    fn from(stored: StoredDesign) -> Self {
        Self {
            reference: stored.reference(),
            name: stored.name,
            version: stored.version,
            design: stored.design,
            created_ms: stored.created_ms,
        }
    }
}

/// Designs that are kept.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub(super) struct DesignList {
    /// By name, the newest version first.
    designs: Vec<KeptDesign>,
    /// Rows that are damaged and left out; the log and `latchgate-serve fsck` name them.
    damaged: usize,
}

/// Finds a design by `name` or `name@version`.
pub(crate) async fn find(app: &App, reference: &str) -> Result<StoredDesign, Problem> {
    let wanted = reference.to_string();
    let found = app
        .on_disk(move |parts| StoredDesign::find(&*parts.ledger, &wanted))
        .await?;
    found.ok_or_else(|| Problem::not_found(&format!("design {reference}; see /v1/designs")))
}

/// Makes a design plain: tables, or one that is kept, with overrides; returns its name and version
/// where it is kept.
pub(super) async fn resolved(
    app: &App,
    design: &Value,
    set: &[String],
    request: &Request,
) -> Result<(Design, Option<String>), Problem> {
    let (design, name) = match design {
        Value::String(name) => {
            let stored = find(app, name).await?;
            let full = stored.reference();
            (stored.design, Some(full))
        }
        design => (design.clone(), None),
    };
    let mut design = design_of(&design, request)?;
    let changed = set
        .iter()
        .try_for_each(|text| apply_override(&mut design, text));
    changed
        .and_then(|()| request.check_design(&design))
        .map_err(|error| Problem::bad_request(format!("set: {error}")))?;
    Ok((design, name))
}

/// Lists the designs.
#[utoipa::path(
    get, path = "/v1/designs",
    responses((status = 200, description = "The designs", body = DesignList))
)]
pub(super) async fn list(State(app): State<App>) -> Result<Json<DesignList>, Problem> {
    let stored = app.on_disk(|parts| parts.ledger.designs()).await?;
    let damaged = stored.damaged.len();
    let designs = stored.entries.into_iter().map(KeptDesign::from).collect();
    Ok(Json(DesignList { designs, damaged }))
}

/// Keeps a design; one that says the same as the newest version is that version.
#[utoipa::path(
    post, path = "/v1/designs", request_body = DesignSubmission,
    responses(
        (status = 201, description = "It is kept", body = KeptDesign),
    )
)]
pub(super) async fn submit(
    State(app): State<App>,
    submitted: Result<Json<DesignSubmission>, axum::extract::rejection::JsonRejection>,
) -> Result<Response, Problem> {
    let Json(submitted) =
        submitted.map_err(|error| Problem::of_body(error.status(), error.body_text()))?;
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_');
    let name = submitted.name;
    if name.is_empty() || name.len() > 64 || !name.chars().all(plain) {
        let text = "name: up to 64 letters, digits, `.`, `-` and `_`";
        return Err(Problem::bad_request(text));
    }
    app.admit_bytes(1 << 20)?;
    let request = request_of(&json!({}))?;
    let (mut design, _) = resolved(&app, &submitted.design, &submitted.set, &request).await?;
    // Kept, it is a design of its own, and nothing of it is an override.
    design.modified.clear();
    design.modified_from.clear();
    if submitted.design["name"].is_null() {
        design.name.clone_from(&name);
    }
    let design = json!(design);
    let stored = app
        .on_disk(move |parts| parts.ledger.put_design(&name, &design, now_ms()))
        .await?;
    Ok((StatusCode::CREATED, Json(KeptDesign::from(stored))).into_response())
}

/// Finds a design: its newest version, or the one that `name@version` names.
#[utoipa::path(
    get, path = "/v1/designs/{name}",
    params(("name" = String, Path, description = "Name, or name@version")),
    responses(
        (status = 200, description = "The design", body = KeptDesign),
    )
)]
pub(super) async fn get(
    State(app): State<App>,
    Placed(name): Placed<String>,
) -> Result<Json<KeptDesign>, Problem> {
    Ok(Json(find(&app, &name).await?.into()))
}

pub(super) fn empty() -> Value {
    json!({})
}
