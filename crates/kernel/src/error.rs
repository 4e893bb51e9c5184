//! What a lever, a signal or a run can be refused for.
//!
//! Readers and everything above them wrap these kinds in an error of their own, which knows the
//! place in a file.

use std::fmt;

/// Why there is no answer.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// A quantity that must be finite and positive is not.
    NotPositive {
        /// The quantity with its unit.
        what: &'static str,
        /// The value found.
        found: f64,
    },
    /// A value lies outside its permitted range.
    OutOfRange {
        /// The quantity with its unit.
        what: String,
        /// The permitted range in words.
        expected: String,
        /// The value found.
        found: String,
    },
    /// A sample or time stamp that is not a finite number.
    NonFinite {
        /// The text or value found.
        found: String,
    },
    /// Too few samples.
    TooShort {
        /// What needs them.
        what: &'static str,
        /// The least number.
        needed: usize,
        /// The number found.
        found: usize,
    },
    /// A key or name that is not known.
    UnknownName {
        /// The kind of name, for example "design key".
        what: &'static str,
        /// The name found.
        found: String,
        /// The known names.
        known: Vec<String>,
    },
    /// The caller's [`Control`](crate::parallel::Control) ended the work.
    Stopped,
}

impl Error {
    /// Returns an [`Error::OutOfRange`]: what was expected and found.
    pub fn out_of_range(
        what: impl Into<String>,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> Self {
        Self::OutOfRange {
            what: what.into(),
            expected: expected.into(),
            found: found.into(),
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotPositive { what, found } => {
                write!(f, "{what} must be finite and positive, found {found}")
            }
            Self::OutOfRange {
                what,
                expected,
                found,
            } => write!(f, "{what} must be {expected}, found {found}"),
            Self::NonFinite { found } => write!(
                f,
                "expected a finite number, found `{found}`; leave the sample out, so that the gap shows in time"
            ),
            Self::TooShort {
                what,
                needed,
                found,
            } => write!(f, "{what} needs at least {needed} samples, found {found}"),
            Self::UnknownName { what, found, known } => {
                write!(f, "unknown {what} `{found}`; known: {}", known.join(", "))
            }
            Self::Stopped => f.write_str("the work was stopped before its end"),
        }
    }
}

impl std::error::Error for Error {}
