//! The pairs of a gate, and their order.

use crate::pipeline::{Answer, DecisionRow};
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;

/// Exit code of a gate of which something could not be done, or in which nothing was judged.
pub const COULD_NOT: u8 = 4;

/// Standing of a pair against its required answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PairStanding {
    /// It answers as required.
    AsRequired,
    /// It is undecided, and an exception lets it through.
    Allowed,
    /// It is not as required, but was not in the baseline either and is no worse.
    NoWorse,
    /// It is not as required.
    NotAsRequired,
}

impl PairStanding {
    /// Returns its name.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::AsRequired => "as-required",
            Self::Allowed => "allowed",
            Self::NoWorse => "no-worse",
            Self::NotAsRequired => "not-as-required",
        }
    }
}

/// One recording with one design.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Pair {
    /// Name of the recording.
    pub recording: String,
    /// Name of the design.
    pub design: String,
    /// The required answer.
    pub required: Answer,
    /// Standing against the required answer.
    pub standing: PairStanding,
    /// Reason and last day of the exception that lets it through.
    pub exception: Option<(String, String)>,
    /// The decision.
    pub row: DecisionRow,
}

impl Pair {
    /// Returns the exit code that the pair alone would give: 0 if as required or let through.
    pub fn exit_code(&self) -> u8 {
        match (self.standing, self.row.verdict) {
            (PairStanding::NotAsRequired, Answer::Unusable) => COULD_NOT,
            (PairStanding::NotAsRequired, Answer::Undecided) => Answer::Undecided.exit_code(),
            // A pass where a fail was required is a failure of the gate.
            (PairStanding::NotAsRequired, _) => Answer::Fail.exit_code(),
            _ => 0,
        }
    }

    /// Orders pairs, the worst first: by exit code, by margin in millionths of the threshold. Of passes
    /// where a fail was required that of the largest margin is the worst.
    pub(super) fn rank(&self) -> (Reverse<u8>, i64) {
        let sign = if self.required == Answer::Fail {
            -1.0
        } else {
            1.0
        };
        let margin = self.row.margin().map_or(f64::MIN, |margin| sign * margin);
        let margin = (margin.clamp(-1e9, 1e9) * 1e6) as i64;
        (Reverse(severity(self.exit_code())), margin)
    }
}

/// Orders exit codes by severity: 4 is worse than 1, 1 than 3, 3 than 0. Their numbers do not.
pub(super) fn severity(code: u8) -> u8 {
    match code {
        0 => 0,
        3 => 1,
        1 => 2,
        _ => 3,
    }
}
