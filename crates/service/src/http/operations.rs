//! Health, readiness, limits, counters, the description of the interface.

use super::form::HEAD_BYTES;
use super::guard::LOGIN_BYTES;
use crate::app::App;
use crate::config::meaning;
use crate::jail::Jail;
use crate::pool::WAITING;
use crate::problem::{Problem, QUESTION_BYTES};
use axum::Json;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use latchgate::pipeline::Limits;
use serde::Serialize;
use std::fmt::Write as _;
use std::sync::atomic::{AtomicU64, Ordering};
use utoipa::ToSchema;

/// Says that the process answers.
#[utoipa::path(get, path = "/healthz", responses((status = 200, description = "It answers", body = String)))]
pub(super) async fn healthz() -> &'static str {
    "ok\n"
}

/// Says whether work is taken.
#[utoipa::path(
    get, path = "/readyz",
    responses(
        (status = 200, description = "Work is taken", body = String),
    )
)]
pub(super) async fn readyz(State(app): State<App>) -> Result<&'static str, Problem> {
    app.admit_bytes(0)?;
    app.on_disk(|parts| parts.ledger.job("").map(|_| ()))
        .await?;
    Ok("ready\n")
}

/// Describes the interface.
#[utoipa::path(get, path = "/openapi.json", responses((status = 200, description = "OpenAPI 3.1", body = Object)))]
pub(super) async fn openapi() -> impl IntoResponse {
    (
        [(header::CONTENT_TYPE, "application/json")],
        super::openapi(),
    )
}

/// A limit with its value.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub(super) struct ListedLimit {
    /// Name.
    name: String,
    /// Value.
    value: u64,
    /// What it counts.
    unit: String,
    /// What is counted where.
    meaning: String,
    /// How to change it.
    change: String,
}

/// Every limit, and the jail in which recordings are read.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub(super) struct LimitList {
    /// Limits.
    limits: Vec<ListedLimit>,
    /// What the kernel gives.
    jail: Jail,
}

/// Lists every limit, and the jail in which recordings are read.
#[utoipa::path(get, path = "/v1/limits", responses((status = 200, description = "Limits", body = LimitList)))]
pub(super) async fn limits(State(app): State<App>) -> Json<LimitList> {
    let config = &app.config;
    let own = [
        ("upload_bytes", config.upload_bytes, "bytes", "upload_mib"),
        (
            "upload_files",
            config.upload_files as u64,
            "files",
            "upload_files",
        ),
        ("upload_time", config.upload_time.as_secs(), "s", "upload_s"),
        ("order_time", config.order_time.as_secs(), "s", "order_s"),
        (
            "child_memory",
            config.child_memory_bytes,
            "bytes",
            "child_memory_mib",
        ),
        ("free_bytes", config.free_bytes, "bytes", "free_mib"),
        ("queue", config.queue, "jobs", "queue"),
        ("own_queue", config.own_queue, "jobs", "own_queue"),
        ("own_bytes", config.own_bytes, "bytes", "own_mib"),
        ("gate_pairs", config.gate_pairs, "pairs", "gate_pairs"),
        ("gate_rules", config.gate_rules, "rules", "gate_rules"),
        (
            "connections",
            config.connections as u64,
            "connections",
            "connections",
        ),
        (
            "address_connections",
            config.address_connections as u64,
            "connections",
            "address_connections",
        ),
        (
            "question_time",
            config.question_time.as_secs(),
            "s",
            "question_s",
        ),
        (
            "rate",
            config.rate_per_s,
            "requests per second",
            "rate_per_s",
        ),
    ];
    let own = own.into_iter().map(|(name, value, unit, key)| ListedLimit {
        name: name.into(),
        value,
        unit: unit.into(),
        meaning: meaning(key).into(),
        change: format!("`{key}` in the service's configuration"),
    });
    let fixed = |name: &str, value: u64, unit: &str, meaning: &str| ListedLimit {
        name: name.into(),
        value,
        unit: unit.into(),
        meaning: meaning.into(),
        change: "fixed".into(),
    };
    let fixed = [
        fixed(
            "body_bytes",
            QUESTION_BYTES as u64,
            "bytes",
            "Bytes of a question or a gate file.",
        ),
        fixed(
            "login_bytes",
            LOGIN_BYTES as u64,
            "bytes",
            "Bytes of a sign-in.",
        ),
        fixed(
            "waiting",
            WAITING as u64,
            "orders",
            "Uploads, what-ifs and plots that wait for a child.",
        ),
        fixed(
            "form_head_bytes",
            HEAD_BYTES,
            "bytes",
            "Bytes of an upload's form before a file, and between two files.",
        ),
    ];
    let of_reading = Limits::default()
        .entries()
        .into_iter()
        .map(|limit| ListedLimit {
            change: format!("`request.limit.{}` of a question", limit.name),
            name: limit.name.into(),
            value: limit.value,
            unit: limit.unit.into(),
            meaning: limit.meaning.into(),
        });
    Json(LimitList {
        limits: own.chain(fixed).chain(of_reading).collect(),
        jail: app.crew.jail().clone(),
    })
}

/// Counts what is done, for Prometheus.
#[utoipa::path(
    get, path = "/metrics",
    responses(
        (status = 200, description = "Counters", body = String, content_type = "text/plain"),
    )
)]
pub(super) async fn metrics(State(app): State<App>) -> Result<Response, Problem> {
    let load = app.on_disk(|parts| parts.ledger.load("")).await?;
    let free = app.blobs.free_bytes()?;
    let (traffic, pool) = (&app.traffic, app.crew.counters());
    let counted = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
    let lines = [
        (
            "requests_answered_total",
            "counter",
            counted(&traffic.answered),
        ),
        (
            "requests_refused_total",
            "counter",
            counted(&traffic.refused),
        ),
        ("requests_failed_total", "counter", counted(&traffic.failed)),
        ("requests_open", "gauge", counted(&traffic.open)),
        ("jobs_queued", "gauge", load.queued),
        ("jobs_running", "gauge", load.running),
        ("jobs_done_total", "counter", counted(&pool.jobs_done)),
        ("jobs_refused_total", "counter", counted(&pool.jobs_refused)),
        (
            "children_lost_total",
            "counter",
            counted(&pool.children_lost),
        ),
        ("places_busy_ms_total", "counter", counted(&pool.busy_ms)),
        ("disk_free_bytes", "gauge", free),
    ];
    let mut text = String::new();
    for (name, kind, value) in lines {
        let _ = write!(
            text,
            "# TYPE latchgate_{name} {kind}\nlatchgate_{name} {value}\n"
        );
    }
    let kind = [(header::CONTENT_TYPE, "text/plain; version=0.0.4")];
    Ok((StatusCode::OK, kind, text).into_response())
}
