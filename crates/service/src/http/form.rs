//! Parts of a form, of which no more is held than what was not understood yet.
//!
//! The reader of forms takes as much of the body as has come, and looks for the end of a head from its
//! beginning each time. So the body is handed to it in pieces, the next one only when it can go on no
//! further without, and a form that brings neither head nor bytes of a file for long is refused.

use crate::problem::Problem;
use axum::body::{Body, BodyDataStream, Bytes};
use axum::extract::multipart::{Field, Multipart, MultipartError};
use axum::extract::{FromRequest, Request};
use axum::http::StatusCode;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};
use tokio_stream::Stream;

/// Bytes of a form between two pieces of its files: lines before the first part, and a part's head.
pub(super) const HEAD_BYTES: u64 = 16 << 10;

/// Bytes of a body that are handed over at a time.
const PIECE: usize = 8 << 10;

/// A form that is being received.
pub(super) struct Form {
    parts: Multipart,
    meter: Meter,
}

impl Form {
    /// Begins a form of at most so many bytes in all; `beyond` is said of one that is longer.
    ///
    /// # Errors
    ///
    /// A problem if it names no boundary.
    pub(super) async fn begin(
        request: Request,
        bytes_max: u64,
        beyond: Problem,
    ) -> Result<Self, Problem> {
        let meter = Arc::new(Mutex::new(Count {
            is_granted: false,
            pending: 0,
            total: 0,
            bytes_max,
            beyond,
        }));
        let (head, body) = request.into_parts();
        let metered = Metered {
            body: body.into_data_stream(),
            unread: Bytes::new(),
            meter: Arc::clone(&meter),
        };
        let request = Request::from_parts(head, Body::from_stream(metered));
        let parts = Multipart::from_request(request, &())
            .await
            .map_err(|error| Problem::bad_request(error.body_text()))?;
        Ok(Self { parts, meter })
    }

    /// Returns the next part.
    ///
    /// # Errors
    ///
    /// A problem: no form, or one that is too long beside its files.
    pub(super) async fn next(&mut self) -> Result<Option<Part<'_>>, Problem> {
        let meter = Arc::clone(&self.meter);
        let mut next = std::pin::pin!(self.parts.next_field());
        let next = std::future::poll_fn(|context| {
            advanced(&meter, context, |context| next.as_mut().poll(context))
        });
        let field = next.await?.map_err(|error| broken(&error))?;
        let meter = Arc::clone(&self.meter);
        Ok(field.map(|field| Part { field, meter }))
    }
}

/// A part of a form, a stream of its bytes.
pub(super) struct Part<'a> {
    field: Field<'a>,
    meter: Meter,
}

impl Part<'_> {
    /// Returns its name in the form.
    pub(super) fn role(&self) -> &str {
        self.field.name().unwrap_or("")
    }

    /// Returns the name of its file.
    pub(super) fn file_name(&self) -> Option<&str> {
        self.field.file_name()
    }
}

impl Stream for Part<'_> {
    type Item = Result<Bytes, Problem>;

    fn poll_next(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        let part = self.get_mut();
        let field = &mut part.field;
        let next = advanced(&part.meter, context, |context| {
            Pin::new(&mut *field).poll_next(context)
        });
        next.map(|next| match next {
            Ok(Some(Ok(bytes))) => Some(Ok(bytes)),
            Ok(Some(Err(error))) => Some(Err(broken(&error))),
            Ok(None) => None,
            Err(problem) => Some(Err(problem)),
        })
    }
}

/// Goes on with a form: the next piece of the body is granted only when there is no way without.
fn advanced<T>(
    meter: &Meter,
    context: &mut Context<'_>,
    mut poll: impl FnMut(&mut Context<'_>) -> Poll<T>,
) -> Poll<Result<T, Problem>> {
    loop {
        if let Poll::Ready(step) = poll(context) {
            locked(meter).pending = 0;
            return Poll::Ready(Ok(step));
        }
        let mut count = locked(meter);
        count.within_limits()?;
        if count.is_granted {
            // It was not taken: nothing more has come yet.
            return Poll::Pending;
        }
        count.is_granted = true;
    }
}

fn broken(error: &MultipartError) -> Problem {
    Problem::bad_request(error.body_text())
}

/// What was taken of a body.
#[derive(Debug)]
struct Count {
    /// True if one more piece may be taken.
    is_granted: bool,
    /// Bytes that were taken since the form last went on.
    pending: u64,
    /// Bytes that were taken in all.
    total: u64,
    /// Bytes that may be taken in all.
    bytes_max: u64,
    /// What is said of more.
    beyond: Problem,
}

impl Count {
    fn within_limits(&self) -> Result<(), Problem> {
        let status = StatusCode::PAYLOAD_TOO_LARGE;
        if self.pending > HEAD_BYTES {
            let way_out = "a part's head holds its name and the file's name, and no more";
            let found = format!("{} bytes without a file", self.pending);
            return Err(Problem::over(
                status,
                "form_head_bytes",
                HEAD_BYTES,
                found,
                way_out,
            ));
        }
        if self.total > self.bytes_max {
            return Err(self.beyond.clone());
        }
        Ok(())
    }
}

type Meter = Arc<Mutex<Count>>;

fn locked(meter: &Meter) -> MutexGuard<'_, Count> {
    meter.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A body that gives a piece only where one was granted.
struct Metered {
    body: BodyDataStream,
    unread: Bytes,
    meter: Meter,
}

impl Stream for Metered {
    type Item = Result<Bytes, axum::Error>;

    fn poll_next(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        let metered = self.get_mut();
        // Whoever polls the form grants a piece and polls again, so that no wake is lost here.
        if !locked(&metered.meter).is_granted {
            return Poll::Pending;
        }
        if metered.unread.is_empty() {
            match Pin::new(&mut metered.body).poll_next(context) {
                Poll::Ready(Some(Ok(bytes))) => metered.unread = bytes,
                other => return other,
            }
        }
        let piece = metered.unread.split_to(PIECE.min(metered.unread.len()));
        let mut count = locked(&metered.meter);
        count.is_granted = false;
        count.pending += piece.len() as u64;
        count.total += piece.len() as u64;
        Poll::Ready(Some(Ok(piece)))
    }
}
