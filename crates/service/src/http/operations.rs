//! Health, readiness, limits, counters, the description of the interface.

use super::form::HEAD_BYTES;
use super::guard::LOGIN_BYTES;
use crate::app::{App, BODIES_BYTES, FREE_FILES};
use crate::clock::now_ms;
use crate::config::meaning;
use crate::jail::Jail;
use crate::pool::{ANSWERS, WAITING};
use crate::problem::{Problem, QUESTION_BYTES};
use axum::Json;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use latchgate::pipeline::{Limits, NUMBERS_REVISION};
use serde::Serialize;
use std::fmt::Write as _;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use utoipa::ToSchema;

/// Says that the process answers.
#[utoipa::path(get, path = "/healthz", responses((status = 200, description = "It answers", body = String)))]
pub(super) async fn healthz() -> &'static str {
    "ok\n"
}

/// Says whether work is taken: the service does not end, there is space on the disk, and the ledger was
/// written within the last second.
#[utoipa::path(
    get, path = "/readyz",
    responses(
        (status = 200, description = "Work is taken", body = String),
        (status = 503, description = "No work is taken; `detail` says why", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(super) async fn readyz(State(app): State<App>) -> Result<&'static str, Problem> {
    let ready = app.admit_bytes(1 << 20);
    let ready = match ready {
        Ok(()) => app.probe().await.map_err(Problem::from),
        refused => refused,
    };
    let unready = |problem: Problem| Problem {
        status: StatusCode::SERVICE_UNAVAILABLE.as_u16(),
        ..problem
    };
    ready.map_err(unready)?;
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
    let service_limits = [
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
        ("own_designs", config.own_designs, "designs", "own_designs"),
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
    let service_limits = service_limits
        .into_iter()
        .map(|(name, value, unit, key)| ListedLimit {
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
            "free_files",
            FREE_FILES,
            "files",
            "Files (inodes) that uploads and jobs leave free on the disk.",
        ),
        fixed(
            "bodies",
            BODIES_BYTES,
            "bytes",
            "Bytes of bodies under way, uploads aside; each token or address at most as many as are free.",
        ),
        fixed(
            "waiting",
            WAITING,
            "orders",
            "Uploads, what-ifs and plots that wait for a child; of one token at most as many as are free.",
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
        limits: service_limits.chain(fixed).chain(of_reading).collect(),
        jail: app.crew.jail().clone(),
    })
}

/// Returns a text as the value of a label.
fn escaped(text: &str) -> String {
    text.replace('\\', "\\\\")
        .replace('"', "\\\"")
        .replace('\n', "\\n")
}

/// Counts what is done, for Prometheus.
#[utoipa::path(
    get, path = "/metrics",
    responses(
        (status = 200, description = "Counters", body = String, content_type = "text/plain"),
    )
)]
pub(super) async fn metrics(State(app): State<App>) -> Result<Response, Problem> {
    let (load, census) = app
        .on_disk(|parts| Ok((parts.ledger.load("")?, parts.ledger.census()?)))
        .await?;
    let free = app.blobs.free()?;
    let (traffic, pool) = (&app.traffic, app.crew.counters());
    let counted = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
    let oldest_ms = census
        .oldest_ms
        .map_or(0, |oldest| now_ms() - oldest)
        .max(0);
    let mut text = String::new();
    let mut describe = |name: &str, kind: &str, help: &str, samples: &str| {
        let _ = write!(
            text,
            "# HELP latchgate_{name} {help}\n# TYPE latchgate_{name} {kind}\n{samples}"
        );
    };
    let build = format!(
        "latchgate_build_info{{version=\"{}\",numbers_revision=\"{NUMBERS_REVISION}\"}} 1\n",
        env!("CARGO_PKG_VERSION")
    );
    describe("build_info", "gauge", "The program that answers.", &build);
    let times = "request_duration_seconds";
    let histogram = traffic.histogram(&format!("latchgate_{times}"));
    let help = "Time until the answer to a request began, by kind.";
    describe(times, "histogram", help, &histogram);
    let answers = ANSWERS.iter().zip(&pool.answers).map(|(answer, counter)| {
        let count = counted(counter);
        format!("latchgate_verdicts_total{{answer=\"{answer}\"}} {count}\n")
    });
    let help = "Jobs by what their answer says, pairs of gates among them.";
    describe(
        "verdicts_total",
        "counter",
        help,
        &answers.collect::<String>(),
    );
    let busy = Duration::from_millis(counted(&pool.busy_ms)).as_secs_f64();
    let busy = format!("latchgate_places_busy_seconds_total {busy}\n");
    let help = "Time for which places were at work.";
    describe("places_busy_seconds_total", "counter", help, &busy);
    let by_owner = app.crew.by_owner();
    let busy = by_owner.iter().flat_map(|(owner, figures)| {
        let owner = escaped(owner);
        [("orders", figures.orders), ("jobs", figures.jobs)].map(|(work, time)| {
            let time = time.as_secs_f64();
            format!(
                "latchgate_owner_busy_seconds_total{{owner=\"{owner}\",work=\"{work}\"}} {time}\n"
            )
        })
    });
    let help = "Time for which places were at work for an owner: on uploads, what-ifs and what is read anew (orders), \
                and on jobs.";
    describe(
        "owner_busy_seconds_total",
        "counter",
        help,
        &busy.collect::<String>(),
    );
    let waiting = by_owner.iter().map(|(owner, figures)| {
        let (owner, waiting) = (escaped(owner), figures.waiting);
        format!("latchgate_owner_orders_waiting{{owner=\"{owner}\"}} {waiting}\n")
    });
    let help = "Orders of an owner that wait for a place.";
    describe(
        "owner_orders_waiting",
        "gauge",
        help,
        &waiting.collect::<String>(),
    );
    for (name, kind, value, help) in [
        (
            "requests_answered_total",
            "counter",
            counted(&traffic.answered),
            "Requests that were answered as asked.",
        ),
        (
            "requests_refused_total",
            "counter",
            counted(&traffic.refused),
            "Requests that were refused (4xx).",
        ),
        (
            "requests_failed_total",
            "counter",
            counted(&traffic.failed),
            "Requests that could not be answered (5xx).",
        ),
        (
            "requests_open",
            "gauge",
            counted(&traffic.open),
            "Requests under way.",
        ),
        ("jobs_queued", "gauge", load.queued, "Jobs that wait."),
        ("jobs_running", "gauge", load.running, "Jobs that run."),
        (
            "jobs_oldest_seconds",
            "gauge",
            oldest_ms.unsigned_abs() / 1000,
            "Age of the oldest job that waits; 0 where none does.",
        ),
        (
            "jobs_done_total",
            "counter",
            counted(&pool.jobs_done),
            "Jobs that were answered.",
        ),
        (
            "jobs_refused_total",
            "counter",
            counted(&pool.jobs_refused),
            "Jobs that have no answer.",
        ),
        (
            "gates_open",
            "gauge",
            census.open_gates,
            "Gates without an outcome yet.",
        ),
        (
            "children_lost_total",
            "counter",
            counted(&pool.children_lost),
            "Children that gave no answer to an order.",
        ),
        (
            "recording_bytes",
            "gauge",
            census.recording_bytes,
            "Bytes of all recordings that are kept.",
        ),
        (
            "stored_bytes",
            "gauge",
            app.blobs.stored_bytes(),
            "Bytes of all files that are kept.",
        ),
        (
            "disk_free_bytes",
            "gauge",
            free.bytes,
            "Bytes that are free where the data lie.",
        ),
    ] {
        describe(name, kind, help, &format!("latchgate_{name} {value}\n"));
    }
    if let Some(files) = free.files {
        let help = "Files (inodes) that are free where the data lie.";
        let sample = format!("latchgate_disk_free_files {files}\n");
        describe("disk_free_files", "gauge", help, &sample);
    }
    let kind = [(header::CONTENT_TYPE, "text/plain; version=0.0.4")];
    Ok((StatusCode::OK, kind, text).into_response())
}
