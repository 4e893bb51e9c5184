//! Why a command ended without an answer of its own.

use latchgate_kernel::error::Error as KernelError;
use latchgate_recording::error::{Error, ErrorKind};

/// Exit code for wrong usage: known to be wrong from the command line alone.
pub(super) const WRONG_USAGE: u8 = 2;

/// Exit code for anything that depends on data and could not be done.
pub(super) const COULD_NOT: u8 = 4;

/// Exit code for a command that Ctrl-C ended.
pub(super) const INTERRUPTED: u8 = 130;

/// Why a command ended without an answer of its own.
#[derive(Debug)]
pub(super) enum Failure {
    /// Wrong from the command line alone.
    Usage(Error),
    /// Depends on data.
    Data(Error),
    /// Ended by Ctrl-C.
    Interrupted,
}

impl Failure {
    /// Returns the failure of an error that depends on data, or that says that the work was
    /// stopped.
    pub(super) fn of_data(error: Error) -> Self {
        match error.kind() {
            ErrorKind::Kernel(KernelError::Stopped) => Self::Interrupted,
            _ => Self::Data(error),
        }
    }
}
