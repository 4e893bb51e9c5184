//! Files of an upload: streamed to the disk and hashed on the way, but never parsed in this process.

use super::form::Form;
use crate::app::App;
use crate::problem::Problem;
use crate::store::{BlobWriter, Manifest, StoreError};
use axum::body::{Body, Bytes};
use axum::extract::Request;
use axum::http::{StatusCode, header};
use std::sync::Arc;
use tokio_stream::{Stream, StreamExt};

/// Largest number of letters of a name.
const NAME_LETTERS: usize = 200;

/// Largest number of bytes of a form besides its files.
const FORM_BYTES: u64 = 1 << 20;

/// Largest card [bytes].
const CARD_BYTES: u64 = 1 << 20;

/// Bytes of an upload that are written together; each upload holds as many in memory at most, and a piece.
const WRITTEN_BYTES: usize = 64 << 10;

/// An upload whose files are on the disk, but not in their final places.
pub(super) struct Received {
    name: String,
    files: Vec<(String, BlobWriter)>,
    card: Option<(String, BlobWriter)>,
}

impl Received {
    /// Puts the files in their places.
    ///
    /// # Errors
    ///
    /// [`StoreError`] if the disk refuses.
    pub(super) fn keep(self) -> Result<Manifest, StoreError> {
        let kept = |(name, blob): (String, BlobWriter)| blob.finish(&name);
        let files: Result<Vec<_>, _> = self.files.into_iter().map(kept).collect();
        let mut manifest = Manifest {
            name: self.name,
            files: files?,
            card: self.card.map(kept).transpose()?,
        };
        manifest.files.sort();
        Ok(manifest)
    }
}

/// Receives an upload: the raw file, or a form with `file`, `card` and further parts. `stated` is its length,
/// `left_bytes` the bytes that its token may still upload.
///
/// # Errors
///
/// A problem: too large, too many, too slow, a name that no file may have, a full disk.
pub(super) async fn receive(
    app: &App,
    name: Option<String>,
    request: Request,
    stated: Option<u64>,
    left_bytes: u64,
) -> Result<Received, Problem> {
    let form = request
        .headers()
        .get(header::CONTENT_TYPE)
        .and_then(|kind| kind.to_str().ok())
        .is_some_and(|kind| kind.starts_with("multipart/form-data"));
    let room = Room {
        left_bytes: app.config.upload_bytes.min(left_bytes),
        share: (left_bytes < app.config.upload_bytes).then_some(app.config.own_bytes),
        bytes_max: app.config.upload_bytes,
    };
    // A form has lines around its parts.
    if let Some(length) = stated
        && length
            > room
                .left_bytes
                .saturating_add(if form { FORM_BYTES } else { 0 })
    {
        return Err(room.crossed(&format!("{length} bytes")));
    }
    app.admit_bytes(stated.unwrap_or(0))?;
    let received = async {
        if form {
            of_form(app, name, request, room).await
        } else {
            of_body(app, name, request.into_body(), room).await
        }
    };
    match tokio::time::timeout(app.config.upload_time, received).await {
        Ok(outcome) => outcome,
        Err(_) => {
            let text = format!(
                "the upload took longer than {} s",
                app.config.upload_time.as_secs()
            );
            Err(Problem::new(
                StatusCode::REQUEST_TIMEOUT,
                "too-slow",
                "Too slow",
                text,
            ))
        }
    }
}

/// Limits of an upload.
#[derive(Clone, Copy)]
struct Room {
    /// Bytes that may still come.
    left_bytes: u64,
    /// Total share of its token, if that is the tighter limit.
    share: Option<u64>,
    /// Largest size of one upload [bytes].
    bytes_max: u64,
}

impl Room {
    fn crossed(self, found: &str) -> Problem {
        if let Some(share) = self.share {
            return Problem::beyond_share(share, found.into());
        }
        let found = found.to_string();
        let way_out = "cut the recording to what is needed, or raise `upload_mib` in the \
                       service's configuration";
        let status = StatusCode::PAYLOAD_TOO_LARGE;
        Problem::over(status, "upload_bytes", self.bytes_max, found, way_out)
    }
}

async fn of_body(
    app: &App,
    name: Option<String>,
    body: Body,
    room: Room,
) -> Result<Received, Problem> {
    let name = plain(&name.ok_or_else(|| {
        Problem::bad_request("state the file's name, which readers go by: ?name=NAME")
    })?)?;
    let cut = |error: axum::Error| Problem::bad_request(format!("the upload: {error}"));
    let pieces = body.into_data_stream().map(move |piece| piece.map_err(cut));
    let received = store(app, pieces, room).await?;
    Ok(Received {
        name: name.clone(),
        files: vec![(name, received)],
        card: None,
    })
}

async fn of_form(
    app: &App,
    name: Option<String>,
    request: Request,
    mut room: Room,
) -> Result<Received, Problem> {
    let mut form = Form::begin(
        request,
        room.left_bytes.saturating_add(FORM_BYTES),
        room.crossed("a longer form"),
    )
    .await?;
    let mut received = Received {
        name: name.as_deref().map(plain).transpose()?.unwrap_or_default(),
        files: Vec::new(),
        card: None,
    };
    while let Some(part) = form.next().await? {
        let role = part.role().to_string();
        let file_name = part.file_name().map(String::from);
        let is_card = role == "card";
        let file_name = match file_name {
            Some(file_name) => plain(&file_name)?,
            None if is_card => "card.toml".into(),
            None => return Err(Problem::bad_request("each file of a form needs a name")),
        };
        if received.files.len() >= app.config.upload_files {
            let files_max = app.config.upload_files as u64;
            let way_out = "send the files of one test alone, or an archive";
            let status = StatusCode::PAYLOAD_TOO_LARGE;
            return Err(Problem::over(
                status,
                "upload_files",
                files_max,
                "more files".into(),
                way_out,
            ));
        }
        let own_room = if is_card && room.left_bytes > CARD_BYTES {
            Room {
                left_bytes: CARD_BYTES,
                share: None,
                bytes_max: CARD_BYTES,
            }
        } else {
            room
        };
        let blob = store(app, part, own_room).await?;
        room.left_bytes -= blob.bytes().min(room.left_bytes);
        if is_card {
            received.card = Some((file_name, blob));
            continue;
        }
        if role == "file" && received.name.is_empty() {
            received.name.clone_from(&file_name);
        }
        if received
            .files
            .iter()
            .any(|(earlier, _)| *earlier == file_name)
        {
            return Err(Problem::bad_request(format!(
                "two files of the name {file_name}"
            )));
        }
        received.files.push((file_name, blob));
    }
    if received.files.is_empty() {
        return Err(Problem::bad_request(
            "the form holds no file; name its part `file`",
        ));
    }
    if received.name.is_empty() {
        let text = "name the part to read `file`, or the folder that the parts form: ?name=NAME";
        return Err(Problem::bad_request(text));
    }
    Ok(received)
}

/// Writes a stream of bytes into an unplaced blob, and closes it, since a form may have many. A thread that may wait
/// for the disk is taken for bytes that are there alone: one that waited for a client would be kept from all others.
async fn store(
    app: &App,
    stream: impl Stream<Item = Result<Bytes, Problem>>,
    room: Room,
) -> Result<BlobWriter, Problem> {
    let blobs = Arc::clone(&app.blobs);
    let mut writer = on_disk(move || blobs.begin()).await?;
    let mut stream = std::pin::pin!(stream);
    let (mut bytes, mut held_bytes, mut held) = (0_u64, 0_usize, Vec::new());
    while let Some(piece) = stream.next().await {
        let piece = piece?;
        bytes += piece.len() as u64;
        if bytes > room.left_bytes {
            return Err(room.crossed("a larger upload"));
        }
        held_bytes += piece.len();
        held.push(piece);
        if held_bytes >= WRITTEN_BYTES {
            let pieces = std::mem::take(&mut held);
            held_bytes = 0;
            writer = on_disk(move || written(writer, &pieces)).await?;
        }
    }
    on_disk(move || {
        let mut writer = written(writer, &held)?;
        writer.close()?;
        Ok(writer)
    })
    .await
}

fn written(mut writer: BlobWriter, pieces: &[Bytes]) -> Result<BlobWriter, StoreError> {
    for piece in pieces {
        writer.write(piece)?;
    }
    Ok(writer)
}

/// Does work that may wait for the disk, on a thread for such work.
async fn on_disk<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, StoreError> + Send + 'static,
) -> Result<T, Problem> {
    match tokio::task::spawn_blocking(work).await {
        Ok(done) => Ok(done?),
        Err(error) => Err(StoreError::Broken {
            reason: error.to_string(),
        }
        .into()),
    }
}

/// Checks the name of a file of an upload: relative, with `/` between folders.
fn plain(name: &str) -> Result<String, Problem> {
    let odd = |c: char| c.is_control() || c == '\\';
    let parts_fit = name.split('/').all(|part| !matches!(part, "" | "." | ".."));
    if name.chars().count() <= NAME_LETTERS && parts_fit && !name.contains(odd) {
        return Ok(name.into());
    }
    Err(Problem::bad_request(format!(
        "a name of up to {NAME_LETTERS} letters with `/` between folders, no `..` and no `\\`"
    )))
}
