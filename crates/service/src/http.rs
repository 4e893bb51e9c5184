//! The HTTP interface: routes, their scopes, and the headers of every answer.
//!
//! - `guard`: authentication, same-origin checks, headers of every answer;
//! - `listener`: the address or socket for requests;
//! - `server`: connections under deadlines, and the end of service;
//! - `places`: limits on connections, in all and by address;
//! - `paced`: connections whose client must read at a least pace;
//! - `caller`: origin of a request;
//! - `operations`: health, readiness, limits, counters, the description of the interface;
//! - `recordings`: uploads;
//! - `form`: parts of an upload's form;
//! - `upload`: files of an upload;
//! - `verdicts`: questions, answers and their files;
//! - `jobs`: questions in progress;
//! - `gates`: recordings and designs, each with each;
//! - `designs`: designs by name and version;
//! - `files`: stored bytes as answers;
//! - `pages`: pages for the browser.

mod caller;
pub(crate) mod designs;
mod files;
mod form;
pub(crate) mod gates;
mod guard;
mod jobs;
mod listener;
mod operations;
mod paced;
mod pages;
mod places;
pub(crate) mod recordings;
mod server;
mod upload;
pub(crate) mod verdicts;

pub(crate) use caller::Caller;
pub(crate) use guard::{COOKIE, TLS_COOKIE, behind_tls, session};
pub use listener::Listener;
pub(crate) use places::SPARE;
pub use server::{EndingSignals, serve};

use crate::app::App;
use crate::auth::Scope;
use crate::problem::{Problem, QUESTION_BYTES};
use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use serde_json::{Value, json};
use std::any::Any;
use utoipa::OpenApi;
use utoipa_axum::router::{OpenApiRouter, UtoipaMethodRouterExt};
use utoipa_axum::routes;

/// The scopes that a route needs, all of them; `None` for a route without authentication.
pub type Needs = Option<&'static [Scope]>;

const READ: Needs = Some(&[Scope::Read]);
const SUBMIT: Needs = Some(&[Scope::Submit]);
/// Scopes of a question; its answer comes from stored data, so it also reads.
const ASK: Needs = Some(&[Scope::Submit, Scope::Read]);
const DELETE: Needs = Some(&[Scope::Delete]);
const ADMIN: Needs = Some(&[Scope::Admin]);

/// The routes outside the description of the interface, with their scopes.
const PAGES: &[(&str, &str, Needs)] = &[
    ("GET", "/", READ),
    ("GET", "/recordings", READ),
    ("GET", "/recordings/{id}", READ),
    ("POST", "/recordings/{id}/delete", DELETE),
    ("GET", "/verdicts/{report_id}", READ),
    ("GET", "/compare", READ),
    ("GET", "/gates", READ),
    ("GET", "/gates/{id}", READ),
    ("GET", "/gates/{id}/runs/{number}", READ),
    ("GET", "/designs", READ),
    ("GET", "/login", None),
    ("POST", "/login", None),
    ("POST", "/logout", None),
    ("GET", "/assets/{name}", None),
];

/// The routes of the interface, with their scopes.
const INTERFACE: &[(&str, &str, Needs)] = &[
    ("GET", "/healthz", None),
    ("GET", "/readyz", None),
    ("GET", "/openapi.json", READ),
    ("GET", "/metrics", ADMIN),
    ("GET", "/v1/limits", READ),
    ("GET", "/v1/recordings", READ),
    ("POST", "/v1/recordings", SUBMIT),
    ("GET", "/v1/recordings/{id}", READ),
    ("DELETE", "/v1/recordings/{id}", DELETE),
    ("GET", "/v1/deletions", READ),
    ("GET", "/v1/verdicts", READ),
    ("POST", "/v1/verdicts", ASK),
    ("POST", "/v1/what-if", ASK),
    ("GET", "/v1/verdicts/{report_id}", READ),
    ("GET", "/v1/verdicts/{report_id}/{file}", READ),
    ("GET", "/v1/jobs/{id}", READ),
    ("GET", "/v1/jobs/{id}/events", READ),
    ("GET", "/v1/gates", READ),
    ("POST", "/v1/gates", ASK),
    ("GET", "/v1/gates/{id}", READ),
    ("GET", "/v1/gates/{id}/events", READ),
    ("GET", "/v1/gates/{id}/{file}", READ),
    ("GET", "/v1/designs", READ),
    ("POST", "/v1/designs", SUBMIT),
    ("GET", "/v1/designs/{name}", READ),
    ("DELETE", "/v1/designs/{name}", DELETE),
];

/// Lists every route: method, path and scopes.
pub fn declared() -> impl Iterator<Item = (&'static str, &'static str, Needs)> {
    INTERFACE.iter().chain(PAGES).copied()
}

#[derive(OpenApi)]
#[openapi(
    info(
        title = "latchgate",
        description = "Recordings in, verdicts out. Errors are problem documents (RFC 9457)."
    ),
    components(schemas(Problem))
)]
struct Description;

fn interface() -> OpenApiRouter<App> {
    OpenApiRouter::with_openapi(Description::openapi())
        .routes(routes!(operations::healthz))
        .routes(routes!(operations::readyz))
        .routes(routes!(operations::openapi))
        .routes(routes!(operations::metrics))
        .routes(routes!(operations::limits))
        .routes(routes!(recordings::list, recordings::submit).layer(DefaultBodyLimit::disable()))
        .routes(routes!(recordings::get, recordings::delete))
        .routes(routes!(recordings::deletions))
        .routes(routes!(verdicts::list, verdicts::submit))
        .routes(routes!(verdicts::what_if))
        .routes(routes!(verdicts::get))
        .routes(routes!(verdicts::file))
        .routes(routes!(jobs::get))
        .routes(routes!(jobs::events))
        .routes(routes!(gates::list, gates::submit))
        .routes(routes!(gates::get))
        .routes(routes!(gates::events))
        .routes(routes!(gates::file))
        .routes(routes!(designs::list, designs::submit))
        .routes(routes!(designs::get, designs::delete))
}

/// Returns the description of the interface, made from the code.
pub fn openapi() -> String {
    let (_, description) = interface().split_for_parts();
    let mut description = json!(description);
    for (method, path, needs) in INTERFACE {
        secure(
            &mut description["paths"][path][method.to_lowercase()],
            *needs,
        );
    }
    description["components"]["securitySchemes"] = json!({
        "token": {"type": "http", "scheme": "bearer", "description": "`latchgate-serve token create`; where no token exists, programs of the machine itself are asked for none"},
        "cookie": {"type": "apiKey", "in": "cookie", "name": COOKIE, "description": "What the page's sign-in sets"},
    });
    format!("{description:#}\n")
}

/// Adds to the description of a route its scopes, and its refusals without them or beyond the rate limit.
fn secure(operation: &mut Value, needs: Needs) {
    let refusal = |text: &str| {
        let schema = json!({"$ref": "#/components/schemas/Problem"});
        json!({"description": text, "content": {"application/problem+json": {"schema": schema}}})
    };
    let responses = &mut operation["responses"];
    responses["429"] = refusal("Too many requests; `Retry-After` says when to come again");
    for (status, text) in [
        ("4XX", "Refused"),
        ("5XX", "Not now, or what is stored is damaged"),
    ] {
        if responses[status].is_null() {
            responses[status] = refusal(text);
        }
    }
    operation["security"] = json!([]);
    if let Some(scopes) = needs {
        let names: Vec<&str> = scopes.iter().map(|scope| scope.name()).collect();
        let text = format!(
            "The token has not the scope `{}`, or another page asks",
            names.join("` and `")
        );
        operation["responses"]["401"] = refusal("No token that is known");
        operation["responses"]["403"] = refusal(&text);
        operation["security"] = json!([{"token": names}, {"cookie": names}]);
    }
}

/// Returns the router of the service.
pub fn router(app: App) -> Router {
    let (routes, _) = interface().split_for_parts();
    routes
        .merge(pages::routes())
        .fallback(|| async { Problem::not_found("page or route of this address") })
        .method_not_allowed_fallback(|| async {
            let text = "this address does not take this method; see /openapi.json";
            Problem::new(
                StatusCode::METHOD_NOT_ALLOWED,
                "method",
                "Method not allowed",
                text,
            )
        })
        .layer(DefaultBodyLimit::max(QUESTION_BYTES))
        .layer(tower_http::timeout::RequestBodyTimeoutLayer::new(
            app.config.body_time,
        ))
        .layer(tower_http::catch_panic::CatchPanicLayer::custom(panicked))
        .layer(axum::middleware::from_fn_with_state(
            app.clone(),
            guard::watch,
        ))
        .with_state(app)
}

/// Answers a request whose handler panicked.
fn panicked(_: Box<dyn Any + Send>) -> Response {
    let text = "the program is at fault; its log says more";
    let status = StatusCode::INTERNAL_SERVER_ERROR;
    Problem::new(status, "fault", "A fault of the program", text).into_response()
}
