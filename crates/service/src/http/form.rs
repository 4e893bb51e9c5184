//! Parts of a form, read with bounded memory.
//!
//! The reader of forms takes all of the body that has arrived, and searches for the end of a head from its
//! beginning each time. So it gets the body in pieces, the next one only when it cannot go on without. A form
//! is refused if it brings neither a head nor bytes of a file for long.

use crate::problem::Problem;
use axum::body::{Body, BodyDataStream, Bytes};
use axum::extract::multipart::{Field, Multipart, MultipartError};
use axum::extract::{FromRequest, Request};
use axum::http::StatusCode;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};
use tokio_stream::Stream;

/// Largest number of bytes between two pieces of files: lines before the first part, and a part's head.
pub(super) const HEAD_BYTES: u64 = 16 << 10;

/// Size of a piece of the body [bytes].
const PIECE: usize = 8 << 10;

/// A form that is being received.
pub(super) struct Form {
    parts: Multipart,
    meter: Meter,
}

impl Form {
    /// Begins a form of at most `bytes_max` bytes; a longer one is refused with `beyond`.
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
    /// A problem: the body is no form, or has too many bytes besides its files.
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

/// Advances a form; grants the next piece of the body only if the form cannot advance without it.
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
            // The granted piece was not taken, so no more of the body has arrived.
            return Poll::Pending;
        }
        count.is_granted = true;
    }
}

fn broken(error: &MultipartError) -> Problem {
    Problem::bad_request(error.body_text())
}

/// Bytes taken of a body.
#[derive(Debug)]
struct Count {
    /// True if one more piece may be taken.
    is_granted: bool,
    /// Bytes taken since the form last advanced.
    pending: u64,
    /// Bytes taken in total.
    total: u64,
    /// Largest number of bytes in total.
    bytes_max: u64,
    /// Problem of a longer body.
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

/// A body that yields a piece only after it was granted.
struct Metered {
    body: BodyDataStream,
    unread: Bytes,
    meter: Meter,
}

impl Stream for Metered {
    type Item = Result<Bytes, axum::Error>;

    fn poll_next(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        let metered = self.get_mut();
        // No wake is lost: `advanced` grants a piece and polls again.
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
