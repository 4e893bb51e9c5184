//! Designs by name and version; a version never changes.

use super::Caller;
use crate::app::App;
use crate::audit;
use crate::auth::{Scope, Visitor};
use crate::clock::now_ms;
use crate::pool::{design_of, request_of};
use crate::problem::{Placed, Problem, Queried, bounded};
use crate::store::StoredDesign;
use axum::Json;
use axum::extract::{Extension, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use latchgate::pipeline::{Design, Request, apply_override};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use utoipa::{IntoParams, ToSchema};

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

/// Letters of a design's name.
const NAME_LETTERS: usize = 200;

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
    /// Who submitted it.
    owner: String,
}

impl From<StoredDesign> for KeptDesign {
    fn from(stored: StoredDesign) -> Self {
        Self {
            reference: stored.reference(),
            name: stored.name,
            version: stored.version,
            design: stored.design,
            created_ms: stored.created_ms,
            owner: stored.owner,
        }
    }
}

/// A design in a list.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub(super) struct DesignEntry {
    /// Name.
    name: String,
    /// Version, counted from 1.
    version: i64,
    /// Name and version, as questions use them.
    reference: String,
    /// When it came [ms since 1970].
    created_ms: i64,
    /// Who submitted it.
    owner: String,
}

/// Which part of the list is wanted.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub(super) struct DesignPart {
    /// What the part before returned as `next`.
    cursor: Option<u32>,
    /// Entries, 1 to 200.
    #[param(minimum = 1, maximum = 200)]
    limit: Option<u32>,
}

/// Part of a list of designs.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub(super) struct DesignList {
    /// By name, the newest version first.
    designs: Vec<DesignEntry>,
    /// The `cursor` of the next part; absent at the end.
    next: Option<i64>,
    /// Rows that are damaged and left out; the log and `latchgate-serve fsck` name them.
    damaged: usize,
}

/// Finds a design by `name` or `name@version`.
pub(crate) async fn find(app: &App, reference: &str) -> Result<StoredDesign, Problem> {
    let name = reference.to_string();
    let stored = app
        .on_disk(move |parts| StoredDesign::find(&*parts.ledger, &name))
        .await?;
    stored.ok_or_else(|| Problem::not_found(&format!("design {reference}; see /v1/designs")))
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
    get, path = "/v1/designs", params(DesignPart),
    responses((status = 200, description = "A part of the list", body = DesignList))
)]
pub(super) async fn list(
    State(app): State<App>,
    Queried(part): Queried<DesignPart>,
) -> Result<Json<DesignList>, Problem> {
    let limit = bounded("limit", part.limit, 50, (1, 200))?;
    let stored = app
        .on_disk(move |parts| parts.ledger.designs(part.cursor.unwrap_or(0), limit))
        .await?;
    let designs = stored.entries.into_iter().map(|stored| DesignEntry {
        reference: stored.reference(),
        name: stored.name,
        version: stored.version,
        created_ms: stored.created_ms,
        owner: stored.owner,
    });
    Ok(Json(DesignList {
        designs: designs.collect(),
        next: stored.next,
        damaged: stored.damaged.len(),
    }))
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
    Extension(visitor): Extension<Visitor>,
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
    if submitted.design.is_string() && !visitor.may(Scope::Read) {
        return Err(Problem::forbidden(Scope::Read));
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
    let letters = design.name.chars().count();
    if letters > NAME_LETTERS {
        let text = format!("design.name: up to {NAME_LETTERS} letters, found {letters}");
        return Err(Problem::bad_request(text));
    }
    let design = json!(design);
    let stored = app
        .apart(move |parts| {
            let (kept, designs_max) = (
                parts.ledger.designs_of(&visitor.name)?,
                parts.config.own_designs,
            );
            if kept >= designs_max {
                let way_out = "delete designs of this name, or have `own_designs` raised in the \
                               service's configuration";
                let (status, found) = (StatusCode::INSUFFICIENT_STORAGE, format!("{kept} kept"));
                return Err(Problem::over(
                    status,
                    "own_designs",
                    designs_max,
                    found,
                    way_out,
                ));
            }
            let (owner, now) = (&visitor.name, now_ms());
            Ok(parts.ledger.put_design(&name, &design, owner, now)?)
        })
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

/// Deletes a version of a design. Its number is not given again, and what was judged with it stays.
#[utoipa::path(
    delete, path = "/v1/designs/{name}",
    params(("name" = String, Path, description = "name@version")),
    responses(
        (status = 204, description = "It is deleted"),
    )
)]
pub(super) async fn delete(
    State(app): State<App>,
    Extension(visitor): Extension<Visitor>,
    Extension(caller): Extension<Caller>,
    Placed(reference): Placed<String>,
) -> Result<StatusCode, Problem> {
    let named = reference.rsplit_once('@');
    let named = named.and_then(|(name, version)| Some((name, version.parse::<i64>().ok()?)));
    let Some((name, version)) = named else {
        return Err(Problem::bad_request("state the version: name@version"));
    };
    let name = name.to_string();
    let is_deleted = app
        .on_disk(move |parts| parts.ledger.delete_design(&name, version))
        .await?;
    if !is_deleted {
        return Err(Problem::not_found(&format!("design {reference}")));
    }
    audit::record("design deleted", &reference, &visitor.name, caller);
    Ok(StatusCode::NO_CONTENT)
}

pub(super) fn empty() -> Value {
    json!({})
}
