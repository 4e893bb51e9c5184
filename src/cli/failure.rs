//! The reasons for which a command ends without an answer.

use latchgate_kernel::error::Error as KernelError;
use latchgate_recording::error::{Error, ErrorKind};

/// Exit code for an error that the command line alone shows.
pub(super) const WRONG_USAGE: u8 = 2;

/// Exit code for an error that depends on data.
pub(super) const COULD_NOT: u8 = 4;

/// Exit code for a command that Ctrl-C ended.
pub(super) const INTERRUPTED: u8 = 130;

/// The reason for which a command ends without an answer.
#[derive(Debug)]
pub(super) enum Failure {
    /// An error that the command line alone shows.
    Usage(Error),
    /// An error that depends on data.
    Data(Error),
    /// Ended by Ctrl-C.
    Interrupted,
}

impl Failure {
    /// Returns the failure of an error that depends on data, or of work that was stopped.
    pub(super) fn of_data(error: Error) -> Self {
        match error.kind() {
            ErrorKind::Kernel(KernelError::Stopped) => Self::Interrupted,
            _ => Self::Data(error),
        }
    }
}
