//! The only place that prints.

use crate::error::{Error, ErrorKind, Place};
use std::io::{self, Write};

/// Writes data to stdout. A reader that has gone away is no error of ours.
///
/// # Errors
///
/// [`ErrorKind::Io`] if the data could not be written for another reason, for example a full disk:
/// an answer that nobody got must not end with the exit code of one.
pub(super) fn data(text: &str) -> Result<(), Error> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::from(ErrorKind::Io {
                action: "write the answer",
                reason: error.to_string(),
            })
            .at(Place::file("stdout")))
        }
        _ => Ok(()),
    }
}

/// Writes a message to stderr.
pub(super) fn talk(text: &str) {
    let mut err = io::stderr().lock();
    let _ = writeln!(err, "{text}");
}
