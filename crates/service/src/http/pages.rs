//! The pages: made here as HTML, with a script of their own, and the report's for curves with cursors.
//!
//! - `recording`: what a recording holds, and the form that asks for a verdict;
//! - `verdict`: a verdict as its report shows it, and what-if;
//! - `compare`: verdicts side by side;
//! - `gates`: gates with their matrix;
//! - `designs`: designs by version;
//! - `history`: how near the verdicts on a recording come to their limit angles;
//! - `lists`: lists of verdicts and recordings;
//! - `fields`: fields of forms that more than one page has;
//! - `words`: messages of the interface in the words of the pages;
//! - `show`: numbers and words for people.

mod compare;
mod designs;
mod fields;
mod gates;
mod history;
mod lists;
mod recording;
mod show;
mod verdict;
mod words;

use crate::app::App;
use crate::audit;
use crate::auth::{Presented, Recognition, Scope, Visitor, Way};
use crate::http::Caller;
use crate::http::verdicts::{Wanted, listed};
use crate::problem::{Placed, Problem, Queried};
use crate::store::StoredSession;
use axum::Router;
use axum::body::Bytes;
use axum::extract::rejection::BytesRejection;
use axum::extract::{Extension, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Redirect, Response};
use axum::routing::{get, post};
use latchgate::report::{self, escape::terminal as line};
use maud::{DOCTYPE, Markup, html};
use serde_json::json;
use std::borrow::Cow;

/// Returns a file that pages load: its media type and its text.
fn asset_of(name: &str) -> Option<(&'static str, Cow<'static, str>)> {
    let script = "text/javascript; charset=utf-8";
    let style = "text/css; charset=utf-8";
    Some(match name {
        "app.js" => (script, include_str!("../../assets/app.js").into()),
        "app.css" => (style, include_str!("../../assets/app.css").into()),
        // What the pages have from the report.
        "event.js" => (script, report::html::SCRIPT.into()),
        "report.css" => (style, report::html::style().into()),
        "icon.svg" => (
            "image/svg+xml",
            include_str!("../../assets/icon.svg").into(),
        ),
        _ => return None,
    })
}

/// Returns the routes of the pages.
pub(super) fn routes() -> Router<App> {
    Router::new()
        .route("/", get(home))
        .route("/recordings", get(lists::page))
        .route("/recordings/{id}", get(recording::page))
        .route("/recordings/{id}/delete", post(recording::delete))
        .route("/verdicts/{report_id}", get(verdict::page))
        .route("/compare", get(compare::page))
        .route("/gates", get(gates::list))
        .route("/gates/{id}", get(gates::page))
        .route("/gates/{id}/runs/{number}", get(gates::run))
        .route("/designs", get(designs::page))
        .route("/login", get(login_form).post(login))
        .route("/logout", post(logout))
        .route("/assets/{name}", get(asset))
}

/// Shows a problem.
pub(crate) fn problem(problem: &Problem) -> Markup {
    let body = html! {
        h1 { (problem.title) }
        p { (words::on_the_page(&problem.detail)) }
        p { a href="/" { "All verdicts" } }
    };
    layout(None, &problem.title, &body)
}

/// Puts a page together, for whoever is signed in.
fn layout(visitor: Option<&Visitor>, title: &str, body: &Markup) -> Markup {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) " · latchgate" }
                link rel="stylesheet" href="/assets/report.css";
                link rel="stylesheet" href="/assets/app.css";
                link rel="icon" href="/assets/icon.svg";
                script src="/assets/app.js" type="module" {}
            }
            body {
                a.skip href="#main" { "To the content" }
                header.top {
                    nav aria-label="Pages" {
                        a.brand href="/" { "latchgate" }
                        a href="/" { "Verdicts" }
                        a href="/recordings" { "Recordings" }
                        a href="/gates" { "Gates" }
                        a href="/designs" { "Designs" }
                        a href="/openapi.json" { "API" }
                        @if let Some(visitor) = visitor { (signed_in(visitor)) }
                    }
                }
                main id="main" { (body) }
                div id="told" role="status" aria-live="polite" {}
            }
        }
    }
}

/// Says who is signed in, with a way out.
fn signed_in(visitor: &Visitor) -> Markup {
    html! {
        @if visitor.way == Way::Open {
            span.visitor { "No sign-in: open to this machine alone" }
        } @else if visitor.way == Way::Proxy {
            span.visitor {
                "Signed in as " strong { (line(&visitor.name)) }
                @if visitor.sign_out.is_empty() { " by the proxy" } @else { " " a href=(visitor.sign_out) { "Sign out" } }
            }
        } @else {
            form.visitor method="post" action="/logout" {
                span { "Signed in as " strong { (line(&visitor.name)) } }
                button { "Sign out" }
            }
        }
    }
}

/// Says where files go, and who sees them.
fn walls() -> Markup {
    html! { "Files go to the server named in the address bar. Everybody who signs in there sees every recording." }
}

/// The first page: where files are dropped, and what was judged.
async fn home(
    State(app): State<App>,
    Extension(visitor): Extension<Visitor>,
    Queried(wanted): Queried<Wanted>,
) -> Result<Markup, Problem> {
    let list = listed(&app, wanted.clone()).await?;
    let filter = wanted.filter.as_deref().unwrap_or("");
    let chosen = wanted.verdict.as_deref().unwrap_or("");
    let design = wanted.design.as_deref().unwrap_or("");
    let keys = [("filter", filter), ("verdict", chosen), ("design", design)];
    let sorting = lists::Sorting::new("/", &wanted.sort, &keys);
    let is_part = wanted.cursor.is_some() || keys.iter().any(|(_, value)| !value.is_empty());
    let body = html! {
        h1 { "Would the door have stayed shut?" }
        @if visitor.may(Scope::Submit) { (drop_zone()) }
        h2 { "Verdicts" }
        @if is_part || !list.verdicts.is_empty() { form.filters method="get" action="/" {
            label { "File, channel or design " input type="search" name="filter" value=(filter); }
            label { "Verdict "
                select name="verdict" {
                    @for (word, shown) in [("", "all"), ("pass", "pass"), ("fail", "fail"), ("undecided", "undecided"), ("unusable", "unusable")] {
                        option value=(word) selected[word == chosen] { (shown) }
                    }
                }
            }
            @if !design.is_empty() { input type="hidden" name="design" value=(design); }
            button { "Show" }
            @if is_part { a href="/" { "Show all" } }
        } }
        @if list.verdicts.is_empty() {
            @if is_part { p role="status" { "No verdict fits this search. " a href="/" { "Clear the search" } } }
            @else { p { "None yet." } @if visitor.may(Scope::Submit) { (sample()) } }
        } @else {
            (lists::verdicts(&list.verdicts, Some(&sorting)))
        }
        (show::damaged(list.damaged))
        (sorting.older(list.next))
    };
    Ok(layout(Some(&visitor), "Verdicts", &body))
}

/// Where files are dropped.
fn drop_zone() -> Markup {
    html! {
        section.drop id="drop" aria-labelledby="drop-title" {
            h2 id="drop-title" { "A recording" }
            p { "Drop a file here, with its card or the other files of its test, or choose it. " (walls()) }
            p {
                label.button for="files" { "Choose files" }
                input id="files" type="file" multiple;
            }
            progress id="upload" max="1" value="0" hidden aria-label="Upload" {}
            p id="upload-told" role="status" {}
        }
    }
}

/// A pulse that stands for a recording where nobody has one at hand.
const SAMPLE: &str = "pulse:half-sine,peak=30g,duration=10ms";

/// Offers a first verdict.
fn sample() -> Markup {
    html! {
        p { "No recording at hand? Try a half-sine pulse of 30 g and 10 ms against the paper's lever." }
        p { button type="button" id="pair" data-asking=(json!({"recording": SAMPLE})) { "Judge the sample" } }
        (fields::waiting("judging"))
        p.error id="pair-told" role="alert" {}
    }
}

async fn asset(Placed(name): Placed<String>) -> Response {
    match asset_of(&name) {
        Some((kind, text)) => {
            let headers = [
                (header::CONTENT_TYPE, kind),
                (header::CACHE_CONTROL, "private, max-age=600"),
            ];
            (headers, text.into_owned()).into_response()
        }
        None => Problem::not_found("such file").into_response(),
    }
}

async fn login_form(
    State(app): State<App>,
    Extension(visitor): Extension<Visitor>,
) -> Result<Markup, Problem> {
    let token = visitor.token;
    let mut sessions = app.on_disk(|parts| parts.ledger.sessions()).await?;
    sessions.retain(|session| Some(session.token) == token);
    Ok(sign_in(&visitor, "", &sessions))
}

/// Asks for a token; `refused` says why the last one was not taken. Shows where somebody is signed in
/// with the visitor's token.
fn sign_in(visitor: &Visitor, refused: &str, sessions: &[StoredSession]) -> Markup {
    let signed_in = visitor.may(Scope::Read).then_some(visitor);
    let body = html! {
        h1 { "Sign in" }
        p { "Your token comes from whoever runs this server. Everybody who signs in sees every recording." }
        form.fields method="post" action="/login" {
            label { "Token "
                input type="password" name="token" autocomplete="current-password" required
                    aria-invalid=[(!refused.is_empty()).then_some("true")] aria-describedby=[(!refused.is_empty()).then_some("token-error")];
                @if !refused.is_empty() { span.error id="token-error" role="alert" { (refused) } }
            }
            button.primary { "Sign in" }
        }
        @if !sessions.is_empty() {
            h2 { "Signed in with this token" }
            ul { @for session in sessions {
                li { "since " (show::instant(session.created_ms)) ", last used " (show::instant(session.seen_ms)) }
            } }
            form method="post" action="/logout" {
                input type="hidden" name="everywhere" value="true";
                button { "Sign out everywhere" }
            }
        }
    };
    layout(signed_in, "Sign in", &body)
}

async fn login(
    State(app): State<App>,
    Extension(visitor): Extension<Visitor>,
    headers: HeaderMap,
    Extension(caller): Extension<Caller>,
    body: Result<Bytes, BytesRejection>,
) -> Response {
    let body = match body {
        Ok(body) => String::from_utf8_lossy(&body).into_owned(),
        Err(error) => return Problem::of_body(error.status(), error.body_text()).into_response(),
    };
    let token = body.strip_prefix("token=").unwrap_or("").trim().to_string();
    let signed_in = app
        .on_disk(move |parts| {
            let presented = Presented::Token(token);
            let recognition = parts.door.look_anew(&*parts.ledger, &presented)?;
            let session = match &recognition {
                Recognition::Known(Visitor {
                    token: Some(token), ..
                }) => Some(parts.door.sign_in(&*parts.ledger, *token)?),
                _ => None,
            };
            Ok((recognition, session))
        })
        .await;
    match signed_in {
        Ok((Recognition::Known(visitor), Some(session))) => {
            let token = format!("{}#{}", visitor.name, visitor.token.unwrap_or_default());
            audit::record("signed in", &token, &visitor.name, caller);
            let lasts = app.config.session.as_secs();
            let (name, attributes) = cookie(&headers);
            let text = format!("{name}={}; Max-Age={lasts}{attributes}", session.reveal());
            with_cookies("/", &[text])
        }
        Ok((Recognition::Open(_), _)) if visitor.way == Way::Open => {
            Redirect::to("/").into_response()
        }
        Ok(_) => {
            let text = "This token is not known here, was revoked or has ended. Check it, or ask for a new one.";
            (StatusCode::UNAUTHORIZED, sign_in(&visitor, text, &[])).into_response()
        }
        Err(problem) => problem.into_response(),
    }
}

async fn logout(
    State(app): State<App>,
    Extension(visitor): Extension<Visitor>,
    headers: HeaderMap,
    body: Bytes,
) -> Result<Response, Problem> {
    let session = crate::http::session(&headers);
    let everywhere = visitor.token.filter(|_| *body == *b"everywhere=true");
    app.on_disk(move |parts| {
        if let Some(session) = session {
            parts.door.sign_out(&*parts.ledger, &session)?;
        }
        everywhere.map_or(Ok(()), |token| {
            parts.door.sign_out_everywhere(&*parts.ledger, token)
        })
    })
    .await?;
    let (name, attributes) = cookie(&headers);
    let mut response = with_cookies("/login", &[format!("{name}=; Max-Age=0{attributes}")]);
    let cleared = HeaderValue::from_static("\"cache\", \"storage\"");
    response.headers_mut().insert("clear-site-data", cleared);
    Ok(response)
}

/// Returns the name of the session's cookie, and what follows its value and its age. Behind TLS no
/// other host and no other port may set it.
fn cookie(headers: &HeaderMap) -> (&'static str, &'static str) {
    if crate::http::behind_tls(headers) {
        (
            crate::http::TLS_COOKIE,
            "; Path=/; HttpOnly; SameSite=Strict; Secure",
        )
    } else {
        (crate::http::COOKIE, "; Path=/; HttpOnly; SameSite=Strict")
    }
}

fn with_cookies(place: &str, cookies: &[String]) -> Response {
    let mut response = Redirect::to(place).into_response();
    for text in cookies {
        if let Ok(text) = HeaderValue::from_str(text) {
            response.headers_mut().append(header::SET_COOKIE, text);
        }
    }
    response
}
