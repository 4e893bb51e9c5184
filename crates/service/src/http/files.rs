//! Stored bytes as answers. The hash of a file is checked before its first byte is sent.

use crate::app::App;
use crate::problem::Problem;
use crate::store::{StoredFile, StoredResult};
use axum::body::Body;
use axum::http::header::{self, HeaderValue};
use axum::response::Response;
use tokio_util::io::ReaderStream;

/// Size of a piece that is sent [bytes].
const PIECE: usize = 64 << 10;

/// Content security policy of a report's page, which may show itself and nothing more.
const SANDBOX: &str = "sandbox allow-scripts; default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

/// Sends a stored file piece by piece.
pub(super) async fn send(app: &App, file: &StoredFile) -> Result<Response, Problem> {
    let (sha256, length) = (file.sha256.clone(), file.bytes);
    let opened = app.on_disk(move |parts| parts.blobs.open(&sha256)).await?;
    // The file is read asynchronously, so that no thread waits for a slow client.
    let pieces = ReaderStream::with_capacity(tokio::fs::File::from_std(opened), PIECE);
    let mut response = Response::new(Body::from_stream(pieces));
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_LENGTH, HeaderValue::from(length));
    headers.insert(
        header::CONTENT_TYPE,
        HeaderValue::from_static(kind(&file.name)),
    );
    Ok(response)
}

/// Returns the media type of a report's file.
fn kind(name: &str) -> &'static str {
    match name.rsplit('.').next() {
        Some("html") => "text/html; charset=utf-8",
        Some("svg") => "image/svg+xml",
        Some("csv") => "text/csv; charset=utf-8",
        Some("json") => "application/json",
        Some("xml") => "application/xml",
        Some("md") => "text/markdown; charset=utf-8",
        _ => "application/octet-stream",
    }
}

/// Sends a file of a report, which never changes and may only be displayed by a browser.
pub(super) async fn send_of_report(
    app: &App,
    result: &StoredResult,
    name: &str,
    download: bool,
) -> Result<Response, Problem> {
    let file = result.files.get(name);
    let file = file.ok_or_else(|| Problem::not_found("such file in this report"))?;
    let mut response = send(app, file).await?;
    response
        .headers_mut()
        .extend(headers_of_report(result, name, download));
    Ok(response)
}

/// Returns the headers of a report's file, which are those of its 304 as well: a browser takes them for its copy.
pub(super) fn headers_of_report(
    result: &StoredResult,
    name: &str,
    download: bool,
) -> header::HeaderMap {
    let mut headers = header::HeaderMap::new();
    let tag = format!("\"{}-{name}\"", result.report_id);
    if let Ok(tag) = HeaderValue::from_str(&tag) {
        headers.insert(header::ETAG, tag);
    }
    // A browser must ask before each use of its copy, so that the copy is useless after a sign-out.
    let cache_control = HeaderValue::from_static("private, no-cache");
    headers.insert(header::CACHE_CONTROL, cache_control);
    contained(&mut headers);
    if download || name.ends_with(".csv") {
        headers.insert(header::CONTENT_DISPOSITION, attachment(result, name));
    }
    headers
}

/// Adds the headers by which a file may only display itself.
pub(super) fn contained(headers: &mut header::HeaderMap) {
    let sandbox = HeaderValue::from_static(SANDBOX);
    headers.insert(header::CONTENT_SECURITY_POLICY, sandbox);
}

/// Returns the name of a download from recording, design and report, in characters that any system takes.
pub(super) fn attachment(result: &StoredResult, name: &str) -> HeaderValue {
    let summary = &result.summary;
    let full_name = format!("{}-{}", summary.file, summary.design);
    let plain: String = full_name
        .chars()
        .take(60)
        .map(|c| {
            if c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_') {
                c
            } else {
                '_'
            }
        })
        .collect();
    let plain = plain.trim_start_matches('.');
    let id = result.report_id.get(..8).unwrap_or("");
    let text = format!("attachment; filename=\"{plain}-{id}-{name}\"");
    HeaderValue::from_str(&text).unwrap_or(HeaderValue::from_static("attachment"))
}
