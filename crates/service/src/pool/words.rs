//! Messages between parent and child. The bytes of files follow the message that names them.

use crate::jail::Jail;
use crate::store::Summary;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// An order to a child.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(tag = "order", rename_all = "kebab-case")]
pub enum Order {
    /// List what a recording holds, read as a request says.
    Inspect {
        /// The recording's identity.
        recording: String,
        /// How it is read.
        request: Value,
    },
    /// Answer a question.
    Answer {
        /// How.
        how: How,
        /// The recording's identity.
        recording: String,
        /// How it is read, conditioned and judged.
        request: Value,
        /// The lever.
        design: Value,
        /// Who asks, the maker of the report; empty where the service knows nobody.
        by: String,
    },
    /// Try something that the jail must stop.
    Try {
        /// What.
        trial: Trial,
    },
}

impl Order {
    /// Returns true if nobody waits for the order alone, as for a pair of a gate.
    pub fn stands_back(&self) -> bool {
        matches!(
            self,
            Self::Answer {
                how: How::Decide,
                ..
            }
        )
    }

    /// Returns the identity of the recording that the order needs.
    pub fn needs(&self) -> Option<&str> {
        match self {
            Self::Inspect { recording, .. } | Self::Answer { recording, .. } => Some(recording),
            Self::Try { .. } => None,
        }
    }
}

/// Extent of the answer to a question.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum How {
    /// Judged, with the report.
    Judge,
    /// Decided, and no more: a pair of a gate.
    Decide,
    /// By the nominal runs alone, nothing drawn.
    WhatIf,
}

/// A trial against the jail.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Trial {
    /// Open a file to read.
    OpenFile,
    /// Make a file.
    WriteFile,
    /// Connect by TCP.
    Connect,
    /// Send a datagram.
    SendDatagram,
    /// Start a program.
    StartProgram,
    /// Send a signal to its parent.
    SignalParent,
    /// Take 1 GiB of memory.
    TakeMemory,
    /// Make memory that may be run.
    RunMemory,
    /// Raise the limit of its memory.
    RaiseMemory,
    /// Compute without end.
    TakeTime,
}

impl Trial {
    /// Lists every trial.
    pub const ALL: [Self; 10] = [
        Self::OpenFile,
        Self::WriteFile,
        Self::Connect,
        Self::SendDatagram,
        Self::StartProgram,
        Self::SignalParent,
        Self::TakeMemory,
        Self::RunMemory,
        Self::RaiseMemory,
        Self::TakeTime,
    ];
}

/// A file whose bytes follow the message.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Enclosed {
    pub(super) name: String,
    pub(super) bytes: u64,
}

/// The recording that an order encloses.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Enclosure {
    /// The name to read it under.
    pub(super) name: String,
    pub(super) files: Vec<Enclosed>,
    pub(super) card: Option<Enclosed>,
}

/// The message of an order, with the recording that it needs if the child does not hold it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct OrderMessage {
    pub(super) order: Order,
    pub(super) enclosed: Option<Enclosure>,
    /// Seconds of processor time that the order may take.
    pub(super) cpu_s: u64,
}

/// A message of a child.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(tag = "says", rename_all = "kebab-case")]
pub(super) enum ChildMessage {
    /// The child is ready, in this jail.
    Hello { jail: Jail },
    /// The child works.
    Beat(Beat),
    /// The answer, with the files that follow and the recordings that the child holds now.
    Answer {
        answer: Answer,
        files: Vec<Enclosed>,
        holds: Vec<String>,
    },
}

/// A sign that a child works on its order.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Beat {
    /// The part that is done, 0 to 1, if known.
    pub part: Option<f64>,
    /// The step that begins.
    #[serde(default)]
    pub step: Option<Step>,
    /// The verdict, once: advice and report follow.
    pub first_answer: Option<FirstAnswer>,
}

/// A step of the way to a verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Step {
    /// The recording is read and conditioned.
    Reading,
    /// The levers are replayed and judged.
    Judging,
    /// What would change the verdict is searched.
    Advising,
    /// The report is drawn.
    Reporting,
}

/// A verdict that is known before its advice and report.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct FirstAnswer {
    /// `pass`, `fail`, `undecided` or `unusable`.
    pub verdict: String,
    /// What the lever does, or what would decide it, in a sentence.
    pub headline: String,
}

/// A child's answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Answer {
    /// What a recording holds.
    Listing {
        /// The listing.
        listing: Value,
    },
    /// A verdict; its report follows as files.
    Verdict {
        /// The report's identity.
        report_id: String,
        /// What lists show of it.
        summary: Box<Summary>,
        /// SHA-256 of the document without its `run`.
        content_sha256: String,
    },
    /// A decision alone.
    Decision {
        /// The row.
        row: Value,
    },
    /// The document of nominal runs.
    WhatIf {
        /// The document.
        document: Value,
        /// Angle of the nominal lever at each sample [rad].
        angle_rad: Vec<f32>,
    },
    /// There is no answer.
    Problem {
        /// Why.
        problem: Value,
    },
    /// What came of a trial.
    Tried {
        /// Whether it was stopped.
        stopped: bool,
        /// By what, or what it reached.
        how: String,
    },
}
