//! Problem documents (RFC 9457): expected, found, place and remedy, in the words of the library adapted to
//! HTTP.

use crate::auth::Scope;
use crate::store::{Deletion, StoreError};
use axum::extract::{FromRequestParts, Path, Query};
use axum::http::request::Parts;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use latchgate::pipeline::KernelError;
use latchgate::pipeline::calendar::day;
use latchgate::pipeline::{Error, ErrorKind};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Largest question or gate file [bytes].
pub const QUESTION_BYTES: usize = 1 << 20;

/// Why there is no answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Problem {
    /// `urn:latchgate:problem:` and the code.
    #[serde(rename = "type")]
    pub kind: String,
    /// The kind of problem in a few words.
    pub title: String,
    /// HTTP status.
    pub status: u16,
    /// What was expected, what was found, and what to try.
    pub detail: String,
    /// Stable name of the kind.
    pub code: String,
    /// Where it went wrong.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<ProblemPlace>,
    /// The limit that was crossed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit: Option<ProblemLimit>,
    /// `unusable` where a recording was looked at and carries no answer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verdict: Option<String>,
    /// What `request.channel` takes for each of the channels to choose from.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub candidates: Vec<String>,
    /// The document that says so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Object>)]
    pub document: Option<Value>,
    /// Seconds after which to try again.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub retry_after_s: Option<u32>,
}

/// Where in an upload something went wrong.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct ProblemPlace {
    /// File name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Line, counted from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub line: Option<u64>,
    /// Column, counted from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<u64>,
    /// Byte, counted from 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub byte: Option<u64>,
    /// Channel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channel: Option<String>,
}

/// A limit that was crossed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct ProblemLimit {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: u64,
    /// What was observed.
    pub found: String,
}

impl Problem {
    /// Returns the problem of a body that could not be read.
    pub fn of_body(status: StatusCode, text: String) -> Self {
        if status == StatusCode::PAYLOAD_TOO_LARGE {
            let way_out = "a question or a gate file is shorter; recordings go to /v1/recordings";
            let (bytes_max, found) = (QUESTION_BYTES as u64, "a larger body".into());
            return Self::over(status, "body_bytes", bytes_max, found, way_out);
        }
        Self::bad_request(text)
    }

    /// Returns a problem of a kind.
    pub fn new(status: StatusCode, code: &str, title: &str, detail: impl Into<String>) -> Self {
        Self {
            kind: format!("urn:latchgate:problem:{code}"),
            title: title.into(),
            status: status.as_u16(),
            detail: detail.into(),
            code: code.into(),
            place: None,
            limit: None,
            verdict: None,
            candidates: Vec::new(),
            document: None,
            retry_after_s: None,
        }
    }

    /// Returns a problem: something does not exist.
    pub fn not_found(what: &str) -> Self {
        let detail = format!("there is no {what}");
        Self::new(StatusCode::NOT_FOUND, "not-found", "Not found", detail)
    }

    /// Reads a problem that a child or the store wrote; `None` if it is not one.
    pub fn of_value(value: Value) -> Option<Self> {
        let problem: Self = serde_json::from_value(value).ok()?;
        (400..600).contains(&problem.status).then_some(problem)
    }

    /// Returns a problem: a token lacks a scope.
    pub fn forbidden(scope: Scope) -> Self {
        let text = format!(
            "this token may not do that; it needs the scope `{}`",
            scope.name()
        );
        Self::new(StatusCode::FORBIDDEN, "forbidden", "Forbidden", text)
    }

    /// Returns a problem: a recording was deleted, with the time and the name.
    pub fn deleted(deletion: &Deletion) -> Self {
        let reason = match deletion.why.as_str() {
            "asked" => format!("by {}", deletion.by),
            _ => "because it had grown too old (`keep_days`)".to_string(),
        };
        let detail = format!(
            "{} was deleted on {} {reason}; its verdicts stay, its samples are gone; upload it again \
             to ask anew",
            deletion.name,
            day(deletion.deleted_ms.div_euclid(86_400_000))
        );
        Self::new(
            StatusCode::GONE,
            "recording-deleted",
            "The recording was deleted",
            detail,
        )
    }

    /// Returns a problem: the request cannot be read.
    pub fn bad_request(detail: impl Into<String>) -> Self {
        let detail = for_http(&detail.into());
        Self::new(
            StatusCode::BAD_REQUEST,
            "bad-request",
            "Bad request",
            detail,
        )
    }

    /// Returns a problem: a limit on concurrent work is reached, and a later request may succeed.
    pub fn later(
        status: StatusCode,
        name: &str,
        value: u64,
        found: String,
        retry_after_s: u32,
    ) -> Self {
        let way_out = format!("try again in {retry_after_s} s");
        Self {
            retry_after_s: Some(retry_after_s),
            code: "busy".into(),
            kind: "urn:latchgate:problem:busy".into(),
            title: "Too much to do".into(),
            ..Self::over(status, name, value, found, &way_out)
        }
    }

    /// Returns a problem: what a visitor may keep is used up.
    pub fn beyond_share(own_bytes: u64, found: String) -> Self {
        let way_out = "delete recordings of this name, or have `own_mib` raised in the service's \
                       configuration";
        let status = StatusCode::INSUFFICIENT_STORAGE;
        Self::over(status, "own_bytes", own_bytes, found, way_out)
    }

    /// Returns a problem: the service cannot answer now.
    pub fn busy(status: StatusCode, detail: impl Into<String>, retry_after_s: u32) -> Self {
        Self {
            retry_after_s: Some(retry_after_s),
            ..Self::new(status, "busy", "Too much to do", detail)
        }
    }

    /// Returns a problem: a limit was crossed.
    pub fn over(status: StatusCode, name: &str, value: u64, found: String, way_out: &str) -> Self {
        let detail = format!("limit {name} of {value} crossed: found {found}; {way_out}");
        Self {
            limit: Some(ProblemLimit {
                name: name.into(),
                value,
                found,
            }),
            ..Self::new(status, "limit-exceeded", "A limit was crossed", detail)
        }
    }

    /// Returns the problem of a recording that cannot be read or judged, worded for HTTP.
    pub fn of_recording(error: &Error) -> Self {
        let place = error.place();
        let (code, title) = named(error.kind());
        let mut detail = for_http(&error.to_string());
        let limit = match error.kind() {
            ErrorKind::LimitExceeded {
                limit,
                value,
                found,
            } => {
                // A limit is a field of its name here.
                let assigned = format!("the field `request.limit` = {limit}=VALUE");
                detail = detail.replace(&assigned, &format!("`request.limit.{limit}`"));
                Some(ProblemLimit {
                    name: (*limit).into(),
                    value: *value,
                    found: found.clone(),
                })
            }
            _ => None,
        };
        let place = ProblemPlace {
            file: place.file.clone(),
            line: place.line,
            column: place.column,
            byte: place.byte,
            channel: place.channel.clone(),
        };
        Self {
            place: (place != ProblemPlace::default()).then_some(place),
            limit,
            verdict: Some("unusable".into()),
            ..Self::new(StatusCode::UNPROCESSABLE_ENTITY, code, title, detail)
        }
    }

    /// Returns the problem as a value.
    pub fn to_value(&self) -> Value {
        serde_json::to_value(self).expect("a problem has text keys only")
    }
}

/// The query of a request; one that cannot be read is answered with a problem document.
#[derive(Debug, Clone, Copy)]
pub struct Queried<T>(pub T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequestParts<S> for Queried<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let query = Query::<T>::from_request_parts(parts, state).await;
        let query = query.map_err(|error| Problem::bad_request(error.body_text()))?;
        Ok(Self(query.0))
    }
}

/// The parameters in the path of a request; those that cannot be read are answered with a problem document.
#[derive(Debug, Clone, Copy)]
pub struct Placed<T>(pub T);

impl<T: DeserializeOwned + Send, S: Send + Sync> FromRequestParts<S> for Placed<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let path = Path::<T>::from_request_parts(parts, state).await;
        let path = path.map_err(|error| Problem::bad_request(error.body_text()))?;
        Ok(Self(path.0))
    }
}

/// Returns a number of a query within its bounds, or its default.
///
/// # Errors
///
/// A problem that names the bounds.
pub fn bounded(
    name: &str,
    stated: Option<u32>,
    otherwise: u32,
    (least, most): (u32, u32),
) -> Result<u32, Problem> {
    let number = stated.unwrap_or(otherwise);
    if (least..=most).contains(&number) {
        return Ok(number);
    }
    let text = format!("{name}: a whole number from {least} to {most}, found {number}");
    Err(Problem::bad_request(text))
}

impl From<StoreError> for Problem {
    fn from(error: StoreError) -> Self {
        let (status, code, title) = match &error {
            StoreError::Full => (
                StatusCode::INSUFFICIENT_STORAGE,
                "disk-full",
                "The disk is full",
            ),
            StoreError::Damaged { .. } => (
                StatusCode::INTERNAL_SERVER_ERROR,
                "damaged",
                "What is stored is damaged",
            ),
            StoreError::TokensLost => (
                StatusCode::SERVICE_UNAVAILABLE,
                "damaged",
                "The tokens are damaged",
            ),
            StoreError::Deleted => (StatusCode::GONE, "recording-deleted", "It was deleted"),
            _ => (
                StatusCode::INTERNAL_SERVER_ERROR,
                "store",
                "The store does not work",
            ),
        };
        if status.is_server_error() {
            tracing::error!(%error, "a request could not be answered");
        }
        let retry_after_s = (error == StoreError::Full).then_some(5);
        Self {
            retry_after_s,
            ..Self::new(status, code, title, error.to_string())
        }
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let status = StatusCode::from_u16(self.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let body = serde_json::to_vec(&self).unwrap_or_default();
        let kind = HeaderValue::from_static("application/problem+json");
        let mut response = (status, [(header::CONTENT_TYPE, kind)], body).into_response();
        if let Some(seconds) = self.retry_after_s {
            response
                .headers_mut()
                .insert(header::RETRY_AFTER, HeaderValue::from(seconds));
        }
        // The guard shows it as a page if a person requested one.
        response.extensions_mut().insert(self);
        response
    }
}

/// Returns code and title of a kind of error.
fn named(kind: &ErrorKind) -> (&'static str, &'static str) {
    match kind {
        ErrorKind::Kernel(KernelError::NotPositive { .. } | KernelError::OutOfRange { .. }) => {
            ("out-of-range", "A value is out of range")
        }
        ErrorKind::BadSetting { .. } => ("bad-setting", "A setting does not take this value"),
        ErrorKind::UnknownName { .. } => ("unknown-name", "An unknown name"),
        ErrorKind::Empty { .. } => ("empty", "Nothing to read"),
        ErrorKind::RefusedFormat { .. } => ("refused-format", "A format that is not read"),
        ErrorKind::UnknownFormat { .. } => ("unknown-format", "The format is not recognised"),
        ErrorKind::MissingUnit => ("missing-unit", "Nothing states the unit"),
        ErrorKind::UnnamedColumns { .. } => ("unnamed-columns", "Nothing names the columns"),
        ErrorKind::MissingTime => ("missing-time", "Nothing states the time"),
        ErrorKind::NoSuchChannel { .. } => ("no-such-channel", "No channel of that name"),
        ErrorKind::AmbiguousChannel { .. } => {
            ("several-channels", "Several channels could be meant")
        }
        ErrorKind::NoChannel { .. } => ("no-channel", "No lateral acceleration"),
        ErrorKind::Kernel(KernelError::TooShort { .. }) => ("too-short", "Too few samples"),
        ErrorKind::LimitExceeded { .. } => ("limit-exceeded", "A limit was crossed"),
        ErrorKind::RateTooLow { .. } => ("rate-too-low", "The sample rate is too low"),
        ErrorKind::TimeNotIncreasing { .. } => ("time-not-increasing", "Time does not increase"),
        ErrorKind::Truncated { .. } => ("truncated", "The file is cut"),
        _ => ("unreadable", "The recording cannot be read as asked for"),
    }
}

/// Adapts a message of the library to HTTP: ``the setting `channel` `` becomes the field `request.channel` of the
/// body.
pub fn for_http(text: &str) -> String {
    text.replace("the setting `set`", "the field `set`")
        .replace("the setting `design`", "the field `design`")
        .replace("the setting `", "the field `request.")
}
