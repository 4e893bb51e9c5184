//! What became of each pair and of the whole: the document of a gate.

use crate::pipeline::{Answer, Design, Row};
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;

/// Exit code of a gate of which something could not be done, or in which nothing was judged.
pub const COULD_NOT: u8 = 4;

/// summary.json, key by key.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GateSummary {
    /// `latchgate.gate/1`.
    pub schema: String,
    /// Name of the gate file.
    pub gate: String,
    /// The process's exit code: 0 only if every pair stands and nothing else is wrong.
    pub exit_code: u8,
    /// How many pairs are what.
    pub counts: Counts,
    /// What is wrong beside the pairs: exceptions that expired or are not needed, pairs that
    /// vanished.
    pub problems: Vec<GateProblem>,
    /// The designs.
    pub designs: Vec<Design>,
    /// The recordings.
    pub recordings: Vec<SummaryRecording>,
    /// Each recording with each design, in the order of their names.
    pub pairs: Vec<Pair>,
    /// What changed since the baseline; `None` without one.
    pub baseline: Option<Changes>,
    /// Version of latchgate.
    pub version: String,
    /// Revision of the numbers.
    pub numbers_revision: u32,
}

/// How many pairs are what.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counts {
    /// All pairs.
    pub pairs: usize,
    /// Pairs that answer as required.
    pub as_required: usize,
    /// Undecided pairs that an exception lets through.
    pub allowed: usize,
    /// Pairs that are not as required, but were not in the baseline either and are no worse.
    pub no_worse: usize,
    /// Pairs that are not as required.
    pub not_as_required: usize,
    /// Pairs by their answer.
    pub pass: usize,
    /// See `pass`.
    pub fail: usize,
    /// See `pass`.
    pub undecided: usize,
    /// See `pass`.
    pub unusable: usize,
}

/// Something wrong that is no pair's answer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct GateProblem {
    /// Stable name.
    pub code: String,
    /// What is wrong, where, and what to do.
    pub text: String,
}

/// A recording of a summary.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SummaryRecording {
    /// Its name in the gate.
    pub name: String,
    /// SHA-256 of the file, where it was read.
    pub sha256: Option<String>,
    /// The channel that was judged.
    pub channel: Option<String>,
}

/// Where a pair stands with what is required of it.
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

/// What changed since a baseline.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Changes {
    /// Revision of the numbers that the baseline was made with.
    pub numbers_revision: u32,
    /// Pairs that were as required and are not, by recording and design.
    pub newly_failing: Vec<(String, String)>,
    /// Pairs that were not as required and are.
    pub fixed: Vec<(String, String)>,
    /// Pairs whose peak moved by more than its uncertainty.
    pub moved: Vec<Moved>,
    /// Pairs that the baseline does not have.
    pub added: Vec<(String, String)>,
    /// Pairs that only the baseline has.
    pub removed: Vec<(String, String)>,
}

/// A pair whose peak moved by more than its uncertainty.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Moved {
    /// Name of the recording.
    pub recording: String,
    /// Name of the design.
    pub design: String,
    /// Peak of the baseline [rad].
    pub before_rad: f64,
    /// Peak now [rad].
    pub now_rad: f64,
}

/// One recording with one design.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Pair {
    /// Name of the recording.
    pub recording: String,
    /// Name of the design.
    pub design: String,
    /// What is required.
    pub required: Answer,
    /// Where it stands.
    pub standing: PairStanding,
    /// Reason and last day of the exception that lets it through.
    pub exception: Option<(String, String)>,
    /// The decision.
    pub row: Row,
}

impl Pair {
    /// Returns the exit code that the pair alone would give: 0 where it stands.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match (self.standing, self.row.verdict) {
            (PairStanding::NotAsRequired, Answer::Unusable) => COULD_NOT,
            (PairStanding::NotAsRequired, Answer::Undecided) => Answer::Undecided.exit_code(),
            // A pass where a fail was required is a failure of the gate.
            (PairStanding::NotAsRequired, _) => Answer::Fail.exit_code(),
            _ => 0,
        }
    }

    /// Orders pairs, the worst first: by exit code, then by margin, then by name.
    #[must_use]
    pub fn rank(&self) -> (Reverse<u8>, i64, &str, &str) {
        // Of a pass where a fail was required the largest margin is the worst.
        let sign = if self.required == Answer::Fail {
            -1.0
        } else {
            1.0
        };
        let margin = self.row.margin().map_or(f64::MIN, |margin| sign * margin);
        let ordered = (margin.clamp(-1e9, 1e9) * 1e6) as i64;
        (
            Reverse(severity(self.exit_code())),
            ordered,
            &self.recording,
            &self.design,
        )
    }
}

/// Orders exit codes as contracts have it: 4 is worse than 1, 1 than 3, 3 than 0.
pub(super) fn severity(code: u8) -> u8 {
    match code {
        0 => 0,
        3 => 1,
        1 => 2,
        _ => 3,
    }
}

impl GateSummary {
    /// Returns the pairs that are not as required, the worst first.
    #[must_use]
    pub fn worst(&self) -> Vec<&Pair> {
        let mut found: Vec<&Pair> = self
            .pairs
            .iter()
            .filter(|pair| pair.exit_code() != 0)
            .collect();
        found.sort_by_key(|pair| pair.rank());
        found
    }

    /// Returns the document: keys in the order of the type, one line per pair.
    #[must_use]
    pub fn to_json(&self) -> String {
        let mut text = serde_json::to_string_pretty(self).unwrap_or_default();
        text.push('\n');
        text
    }
}
