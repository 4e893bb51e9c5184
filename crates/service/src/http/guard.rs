//! Authentication, same-origin checks on every change, and headers of every answer.

use super::caller::Peer;
use super::listener::NO_ADDRESS;
use super::{Caller, INTERFACE, Needs, declared};
use crate::app::{App, BODIES_BYTES};
use crate::audit;
use crate::auth::{Presented, Recognition, Visitor, Way};
use crate::http::pages;
use crate::problem::{Problem, QUESTION_BYTES};
use crate::supply::Held;
use axum::body::HttpBody as _;
use axum::extract::{MatchedPath, Request, State};
use axum::http::header::{self, HeaderName, HeaderValue};
use axum::http::{HeaderMap, Method, StatusCode, Version};
use axum::middleware::Next;
use axum::response::{IntoResponse, Redirect, Response};
use std::sync::atomic::Ordering;
use std::time::Instant;
use tokio_stream::StreamExt;

/// Name of the cookie that the page's sign-in sets.
pub(crate) const COOKIE: &str = "latchgate-session";

/// Name of the cookie behind TLS: browsers accept it from this host alone, and send it over TLS alone.
pub(crate) const TLS_COOKIE: &str = "__Host-latchgate-session";

/// Paths without authentication and rate limit, for monitoring and for the files of pages.
const FREE: &[&str] = &["/healthz", "/readyz", "/assets/{name}"];

/// Largest body of a sign-in [bytes].
pub(super) const LOGIN_BYTES: usize = 4 << 10;

/// Largest body of a sign-out [bytes].
const LOGOUT_BYTES: usize = 64;

/// Content security policy of pages: they load from this service, and nothing inline.
const POLICY: &str = "default-src 'self'; base-uri 'none'; form-action 'self'; frame-ancestors 'self'; object-src 'none'";

/// Admits or refuses a request, passes it on, and logs its outcome.
pub(super) async fn watch(State(app): State<App>, mut request: Request, next: Next) -> Response {
    let began = Instant::now();
    let method = request.method().clone();
    let is_interface = is_interface(request.uri().path());
    let path = request.extensions().get::<MatchedPath>();
    let path = path.map_or_else(|| "-".to_string(), |path| path.as_str().to_string());
    let peer = request.extensions().get::<Peer>();
    let peer = peer.copied().unwrap_or(Peer {
        address: NO_ADDRESS,
        is_proxy: false,
        is_spare: false,
    });
    let caller = Caller::of(peer, request.headers(), &app.config.proxies);
    request.extensions_mut().insert(caller);
    app.traffic.open.fetch_add(1, Ordering::Relaxed);
    let admitted = if FREE.contains(&path.as_str()) {
        Ok(Visitor::nobody())
    } else if peer.is_spare {
        Err(Box::new(no_place(&app).into_response()))
    } else {
        admit(
            &app,
            &path,
            &method,
            (request.version(), request.headers().clone()),
            (caller, peer),
        )
        .await
    };
    let (visitor, mut response) = match admitted {
        Ok(visitor) => {
            let name = visitor.name.clone();
            let owner = match visitor.way {
                Way::Nobody => caller.network().to_string(),
                _ => name.clone(),
            };
            request.extensions_mut().insert(visitor);
            match received(&app, &path, request, &owner).await {
                // The body's memory is held until the answer.
                Ok((request, _held)) => (name, next.run(request).await),
                Err(problem) => (name, problem.into_response()),
            }
        }
        Err(refused) => ("-".to_string(), *refused),
    };
    app.traffic.open.fetch_sub(1, Ordering::Relaxed);
    let status = response.status();
    if matches!(status, StatusCode::UNAUTHORIZED | StatusCode::FORBIDDEN) {
        let what = format!("{method} {path}");
        audit::record("refused", &what, &visitor, caller);
    }
    let counter = match status.as_u16() {
        ..400 => &app.traffic.answered,
        400..500 => &app.traffic.refused,
        _ => &app.traffic.failed,
    };
    counter.fetch_add(1, Ordering::Relaxed);
    let took = began.elapsed();
    app.traffic.took(method.as_str(), &path, took);
    let ms = u64::try_from(took.as_millis()).unwrap_or(u64::MAX);
    // Query and headers are not logged, since they may contain secrets.
    tracing::info!(%method, path, status = status.as_u16(), ms, visitor, from = %caller, "request");
    if let Some(problem) = response.extensions_mut().remove::<Problem>()
        && !is_interface
    {
        // Headers such as Retry-After and WWW-Authenticate stay.
        response.headers_mut().remove(header::CONTENT_TYPE);
        response.headers_mut().remove(header::CONTENT_LENGTH);
        let page = pages::problem(&problem).into_response();
        let (parts, body) = page.into_parts();
        response.headers_mut().extend(parts.headers);
        *response.body_mut() = body;
    }
    guarded(response.headers_mut());
    response
}

fn no_place(app: &App) -> Problem {
    let (connections_max, address_max) = (app.config.connections, app.config.address_connections);
    let found = format!("as many, or {address_max} of this address, that are open");
    let status = StatusCode::SERVICE_UNAVAILABLE;
    Problem::later(status, "connections", connections_max as u64, found, 1)
}

/// Waits for the whole body of a request that is no upload, within a deadline. Without it a client that sends a
/// byte now and then would hold a place for hours. Memory is taken for bytes that have come, so a silent client takes
/// none, and a share of it by `owner`.
async fn received(
    app: &App,
    path: &str,
    request: Request,
    owner: &str,
) -> Result<(Request, Option<Held>), Problem> {
    let method = request.method();
    let is_upload = *method == Method::POST && path == "/v1/recordings";
    if is_upload || matches!(*method, Method::GET | Method::HEAD) {
        return Ok((request, None));
    }
    let (name, bytes_max) = match path {
        "/login" => ("login_bytes", LOGIN_BYTES),
        "/logout" => ("logout_bytes", LOGOUT_BYTES),
        _ => ("body_bytes", QUESTION_BYTES),
    };
    let too_large = || {
        let way_out = "a question or a gate file is shorter; recordings go to /v1/recordings";
        let (status, found) = (StatusCode::PAYLOAD_TOO_LARGE, "a larger body".into());
        Problem::over(status, name, bytes_max as u64, found, way_out)
    };
    if request.body().size_hint().lower() > bytes_max as u64 {
        return Err(too_large());
    }
    let (head, body) = request.into_parts();
    let read_body = async {
        let (mut held, mut bytes) = (app.bodies.open(owner), Vec::new());
        let mut pieces = body.into_data_stream();
        while let Some(piece) = pieces.next().await {
            let cut = |_| Problem::bad_request("the body ended before it was whole");
            let piece = piece.map_err(cut)?;
            if bytes.len() + piece.len() > bytes_max {
                return Err(too_large());
            }
            // It is refused and does not wait: bodies that wait for each other's memory would end none of them.
            if !held.grow(piece.len() as u64) {
                let found = "more, most of it of this token or address".into();
                let status = StatusCode::TOO_MANY_REQUESTS;
                return Err(Problem::later(status, "bodies", BODIES_BYTES, found, 1));
            }
            bytes.extend_from_slice(&piece);
        }
        Ok((bytes, held))
    };
    let time = app.config.question_time;
    match tokio::time::timeout(time, read_body).await {
        Ok(read) => {
            let (bytes, held) = read?;
            Ok((Request::from_parts(head, bytes.into()), Some(held)))
        }
        Err(_) => {
            let text = format!(
                "the body took longer than {} s; send it at once, or raise `question_s` in the \
                 service's configuration",
                time.as_secs()
            );
            let status = StatusCode::REQUEST_TIMEOUT;
            Err(Problem::new(status, "too-slow", "Too slow", text))
        }
    }
}

/// Returns true if a path is for programs, which get problem documents in place of pages.
fn is_interface(path: &str) -> bool {
    let is_described = |(_, is_described, _): &(&str, &str, Needs)| *is_described == path;
    path == "/v1" || path.starts_with("/v1/") || INTERFACE.iter().any(is_described)
}

/// Adds the headers of every answer, unless it has them already.
fn guarded(headers: &mut HeaderMap) {
    let default_headers: [(HeaderName, &'static str); 6] = [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "same-origin"),
        (header::CACHE_CONTROL, "no-store"),
        (
            HeaderName::from_static("cross-origin-opener-policy"),
            "same-origin",
        ),
        (
            HeaderName::from_static("cross-origin-resource-policy"),
            "same-origin",
        ),
    ];
    for (name, value) in default_headers {
        headers
            .entry(name)
            .or_insert(HeaderValue::from_static(value));
    }
}

async fn admit(
    app: &App,
    path: &str,
    method: &Method,
    (version, headers): (Version, HeaderMap),
    (caller, peer): (Caller, Peer),
) -> Result<Visitor, Box<Response>> {
    let headers = &headers;
    let refuse = |problem: Problem| Box::new(problem.into_response());
    same_origin(method, headers).map_err(refuse)?;
    let mut recognition = match user_of_proxy(app, headers, peer).map_err(refuse)? {
        Some(user) => Recognition::Known(user),
        None => match recognised(app, headers).await.map_err(refuse)? {
            Recognition::Open(_) if !is_local(app, version, headers, peer) => Recognition::Stranger,
            recognition => recognition,
        },
    };
    let (rate, burst) = (app.config.rate_per_s, app.config.rate_burst);
    let too_many = |wait: u32| {
        let found = "more requests of this token or address".into();
        let status = StatusCode::TOO_MANY_REQUESTS;
        refuse(Problem::later(status, "rate", rate, found, wait))
    };
    if recognition == Recognition::Stranger {
        // Strangers are limited by address, so that one cannot keep the others from signing in.
        let address = caller.network().to_string();
        let allowed = app.of_addresses.take(&address, rate, burst);
        allowed.map_err(too_many)?;
    }
    if !matches!(recognition, Recognition::Known(_))
        && let Some(presented) = presented(headers)
    {
        // The token may have been made since the tokens were read.
        let looked = app.on_disk(move |parts| parts.door.look_anew(&*parts.ledger, &presented));
        match looked.await.map_err(refuse)? {
            Recognition::Open(_) => {}
            seen => recognition = seen,
        }
    }
    if let Recognition::Open(visitor) | Recognition::Known(visitor) = &recognition {
        let allowed = app.of_tokens.take(&visitor.name, rate, burst);
        allowed.map_err(too_many)?;
    }
    let asked_as = if *method == Method::HEAD {
        "GET"
    } else {
        method.as_str()
    };
    let route = declared().find(|(verb, known, _)| *verb == asked_as && *known == path);
    match (recognition, route) {
        (Recognition::Open(visitor), _) => Ok(visitor),
        (Recognition::Known(visitor), route) => {
            let needs = route.and_then(|(_, _, needs)| needs).unwrap_or(&[]);
            if let Some(scope) = needs.iter().find(|scope| !visitor.may(**scope)) {
                return Err(refuse(Problem::forbidden(*scope)));
            }
            Ok(visitor)
        }
        // A stranger may use routes without authentication, and does not learn which others exist.
        (Recognition::Stranger, Some((_, _, None))) => Ok(Visitor::nobody()),
        (Recognition::Stranger, _) => {
            let wants_page = headers
                .get(header::ACCEPT)
                .and_then(|accept| accept.to_str().ok())
                .is_some_and(|accept| accept.contains("text/html"));
            if wants_page && *method == Method::GET {
                return Err(Box::new(Redirect::to("/login").into_response()));
            }
            Err(Box::new(unknown()))
        }
    }
}

/// Checks the credential of a request, without the disk if the cache allows.
async fn recognised(app: &App, headers: &HeaderMap) -> Result<Recognition, Problem> {
    let (presented, asking_app) = (presented(headers), app.clone());
    let looked = match app.door.look_again(presented.as_ref()) {
        Some(seen) => Ok(Ok(seen)),
        None => {
            let look = move || {
                asking_app
                    .door
                    .look(&*asking_app.ledger, presented.as_ref())
            };
            tokio::task::spawn_blocking(look).await
        }
    };
    match looked {
        Ok(Ok(seen)) => Ok(seen),
        Ok(Err(error)) => Err(error.into()),
        Err(_) => Err(Problem::not_found("answer")),
    }
}

/// Returns the user that a configured proxy names in a request. A name from another peer, or beside a token, is
/// refused, since one of the two must be forged or mistaken.
fn user_of_proxy(app: &App, headers: &HeaderMap, peer: Peer) -> Result<Option<Visitor>, Problem> {
    let Some(users) = &app.config.users else {
        return Ok(None);
    };
    let mut names = headers.get_all(&users.header).iter();
    let Some(name) = names.next() else {
        return Ok(None);
    };
    let refused = |text: String| {
        let title = "The user is not taken";
        Err(Problem::new(
            StatusCode::UNAUTHORIZED,
            "user-header",
            title,
            text,
        ))
    };
    let header = &users.header;
    if !peer.is_proxy {
        return refused(format!(
            "`{header}` is taken from the socket and from the addresses of `proxies` alone"
        ));
    }
    if headers.contains_key(header::AUTHORIZATION) {
        return refused(format!(
            "`{header}` stands beside a token; send one of them"
        ));
    }
    let fits = |name: &&str| {
        let letters = name.chars().count();
        (1..=200).contains(&letters) && !name.contains(|c: char| c.is_control() || c == '#')
    };
    match name.to_str().ok().map(str::trim).filter(fits) {
        Some(name) if names.next().is_none() => Ok(Some(Visitor::of_proxy(
            name,
            users.scopes.clone(),
            &users.sign_out_url,
        ))),
        _ => refused(format!("`{header}` must be one name of up to 200 letters")),
    }
}

fn unknown() -> Response {
    let text = "send a token that is known: Authorization: Bearer TOKEN. The first one is made at the service's \
                machine: latchgate-serve token create NAME";
    let status = StatusCode::UNAUTHORIZED;
    let mut response = Problem::new(status, "no-token", "No known token", text).into_response();
    let scheme = HeaderValue::from_static("Bearer");
    response
        .headers_mut()
        .insert(header::WWW_AUTHENTICATE, scheme);
    response
}

/// Returns the credential of a request: a token in its header, or a session in the page's cookie.
fn presented(headers: &HeaderMap) -> Option<Presented> {
    let bearer = headers
        .get(header::AUTHORIZATION)
        .and_then(|value| value.to_str().ok()?.split_once(' '))
        .filter(|(scheme, _)| scheme.eq_ignore_ascii_case("bearer"));
    if let Some((_, token)) = bearer {
        return Some(Presented::Token(token.trim().into()));
    }
    session(headers).map(Presented::Session)
}

/// Returns the session of the page's cookie.
pub(crate) fn session(headers: &HeaderMap) -> Option<String> {
    // Another host or port may have set the plain cookie, so it does not count behind TLS.
    let cookie_name = if behind_tls(headers) {
        TLS_COOKIE
    } else {
        COOKIE
    };
    let cookies = headers.get_all(header::COOKIE).iter();
    let mut cookies = cookies
        .filter_map(|value| value.to_str().ok())
        .flat_map(|value| value.split(';'));
    cookies.find_map(|cookie| {
        let (name, value) = cookie.trim().split_once('=')?;
        (name == cookie_name).then(|| value.to_string())
    })
}

/// Returns true if a proxy reports that its client uses TLS.
pub(crate) fn behind_tls(headers: &HeaderMap) -> bool {
    headers
        .get("x-forwarded-proto")
        .is_some_and(|proto| proto == "https")
}

/// Refuses a change requested by a page of another origin.
fn same_origin(method: &Method, headers: &HeaderMap) -> Result<(), Problem> {
    if matches!(*method, Method::GET | Method::HEAD) {
        return Ok(());
    }
    let text_of = |name: &HeaderName| headers.get(name).and_then(|value| value.to_str().ok());
    let site = text_of(&HeaderName::from_static("sec-fetch-site"));
    let from_elsewhere = site.is_some_and(|site| !matches!(site, "same-origin" | "none"));
    let host = text_of(&header::HOST).unwrap_or("");
    let other_origin = headers.contains_key(header::ORIGIN)
        && text_of(&header::ORIGIN)
            .and_then(|origin| origin.split_once("://"))
            .is_none_or(|(_, origin)| origin != host);
    if from_elsewhere || other_origin {
        let text = "a page from elsewhere may not change anything here";
        return Err(Problem::new(
            StatusCode::FORBIDDEN,
            "other-origin",
            "Forbidden",
            text,
        ));
    }
    Ok(())
}

/// Returns true if a request comes from a program of this machine, as far as it shows: only such a request needs no
/// token while none exists. A proxy shows by the configuration, by the headers that proxies add, and by HTTP/1.0,
/// which nginx speaks unless told otherwise. The host must be the machine's, lest a page from elsewhere resolves its
/// own name to this address (DNS rebinding).
fn is_local(app: &App, version: Version, headers: &HeaderMap, peer: Peer) -> bool {
    let config = &app.config;
    let is_forwarded = headers.keys().any(|name| {
        let name = name.as_str();
        name.starts_with("x-forwarded")
            || ["forwarded", "via", "x-real-ip", "x-client-ip"].contains(&name)
    });
    let host = headers
        .get(header::HOST)
        .and_then(|host| host.to_str().ok());
    let host = host.unwrap_or("").to_lowercase();
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|digit| digit.is_ascii_digit()) => name,
        _ => host.as_str(),
    };
    config.users.is_none()
        && config.proxies.is_empty()
        && config.listen.is_private()
        && peer.address.to_canonical().is_loopback()
        && !is_forwarded
        && version != Version::HTTP_10
        && ["localhost", "127.0.0.1", "[::1]"].contains(&name)
}
