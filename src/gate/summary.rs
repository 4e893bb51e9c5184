//! The document of a gate: the result of each pair, and the answer of all.

use super::pairs::{COULD_NOT, Pair, PairStanding, severity};
use crate::pipeline::{Answer, Design};
use latchgate_recording::error::Error;
use latchgate_report::escape;
use latchgate_verdict::statics::{Door, Standard};
use serde::{Deserialize, Serialize};
use std::io;
use std::time::Duration;

/// The schema of a summary.
pub(super) const SCHEMA: &str = "latchgate.gate/1";

/// The schema of a summary of chosen pairs: no answer of the gate, and no baseline.
pub(super) const PART_SCHEMA: &str = "latchgate.gate-part/1";

/// summary.json, key by key.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct GateSummary {
    /// `latchgate.gate/1`; `latchgate.gate-part/1` where not every pair was judged.
    pub schema: String,
    /// Name of the gate file.
    pub gate: String,
    /// The process's exit code: 0 only if every pair is as required or let through, and there is no
    /// problem.
    pub exit_code: u8,
    /// Numbers of pairs by result.
    pub counts: Counts,
    /// Problems that are no pair's answer: exceptions that expired or are not needed, pairs that
    /// vanished.
    pub problems: Vec<GateProblem>,
    /// The designs.
    pub designs: Vec<Design>,
    /// The recordings.
    pub recordings: Vec<SummaryRecording>,
    /// Each recording with each design, in the order of their names.
    pub pairs: Vec<Pair>,
    /// The static load that each design bears, where the gate requires one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub statics: Vec<StaticStanding>,
    /// Changes since the baseline; `None` without one.
    pub baseline: Option<Changes>,
    /// Version of latchgate.
    pub version: String,
    /// Revision of the numbers.
    pub numbers_revision: u32,
    /// Time of each pair in this run, by its number, where it is known. It goes into `junit.xml` only:
    /// the same answers give the same bytes elsewhere.
    #[serde(skip)]
    pub times: Vec<Option<Duration>>,
}

/// Numbers of pairs by result.
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

/// The static load that a design bears, against what is required.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StaticStanding {
    /// The design.
    pub design: String,
    /// The standard whose directions count.
    pub standard: Standard,
    /// The door that it holds.
    pub door: Door,
    /// Opens at this constant acceleration in the worst of them, by the least output of its spring [g]; `None` where
    /// nothing opens it.
    pub opens_at_g: Option<f64>,
    /// Required load [g].
    pub required_g: f64,
    /// True if it holds the required load.
    pub holds: bool,
    /// False of a design that does not state how far its spring scatters: it holds nothing.
    pub spring_stated: bool,
    /// What opens it if the elements of a linkage that are not pinned part [g].
    pub apart_g: Option<f64>,
}

impl StaticStanding {
    /// Returns the result as a sentence.
    pub fn text(&self) -> String {
        let Self {
            design,
            standard,
            door,
            opens_at_g,
            required_g,
            holds,
            spring_stated,
            apart_g,
        } = self;
        let apart = match apart_g.filter(|apart| apart < required_g) {
            Some(apart) => format!(
                "; its elements apart at {}: state pinned = true of those that cannot part",
                latchgate_report::statics::g(apart)
            ),
            None => String::new(),
        };
        let holds = if *holds { "holds" } else { "does not hold" };
        let level = match opens_at_g {
            Some(level) => format!("opens at {}", latchgate_report::statics::g(*level)),
            None => "nothing opens it".into(),
        };
        let spring = match spring_stated {
            true => "by its spring's least output",
            false => {
                "by its nominal spring, and how far that scatters is not stated: state tolerance.preload_torque_nm"
            }
        };
        format!(
            "{design} {holds} {required_g} g ({}; {}): {level} {spring}{apart}",
            standard.name(),
            door.name()
        )
    }
}

/// A problem that is no pair's answer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct GateProblem {
    /// Stable name.
    pub code: String,
    /// The problem, its place, and the remedy.
    pub text: String,
    /// Line of the gate file.
    #[serde(skip)]
    pub line: Option<u64>,
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

/// Changes since a baseline.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Changes {
    /// Revision of the numbers that the baseline was made with.
    pub numbers_revision: u32,
    /// Pairs that were as required and are not, by recording and design.
    pub newly_failing: Vec<(String, String)>,
    /// Pairs that were not as required and are.
    pub fixed: Vec<(String, String)>,
    /// Pairs whose margin moved by more than its uncertainty.
    pub moved: Vec<Moved>,
    /// Pairs that the baseline does not have.
    pub added: Vec<(String, String)>,
    /// Pairs that only the baseline has.
    pub removed: Vec<(String, String)>,
}

/// A pair whose margin, its limit less its peak, moved by more than its uncertainty.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Moved {
    /// Name of the recording.
    pub recording: String,
    /// Name of the design.
    pub design: String,
    /// Margin of the baseline [rad].
    pub margin_before_rad: f64,
    /// Margin now [rad].
    pub margin_now_rad: f64,
}

impl GateSummary {
    /// Adds a problem that is no pair's answer.
    pub fn add_problem(&mut self, code: &str, text: &str) {
        self.problems.push(GateProblem {
            code: code.into(),
            text: text.into(),
            line: None,
        });
        if severity(COULD_NOT) > severity(self.exit_code) {
            self.exit_code = COULD_NOT;
        }
    }

    /// Returns the numbers of the pairs that are not as required, the worst first: by exit code, by margin, by
    /// name.
    pub fn worst(&self) -> Vec<usize> {
        let mut numbers = self.with_standing(PairStanding::NotAsRequired);
        numbers.sort_by_key(|&number| (self.pairs[number].rank(), number));
        numbers
    }

    /// Returns the numbers of the pairs with that standing.
    pub(super) fn with_standing(&self, standing: PairStanding) -> Vec<usize> {
        (0..self.pairs.len())
            .filter(|&number| self.pairs[number].standing == standing)
            .collect()
    }

    /// Returns the number of pairs with that answer that are not as required.
    pub(super) fn not_as_required(&self, verdict: Answer) -> usize {
        self.pairs
            .iter()
            .filter(|pair| pair.standing == PairStanding::NotAsRequired)
            .filter(|pair| pair.row.verdict == verdict)
            .count()
    }

    /// True if only chosen pairs were judged.
    pub(super) fn is_part(&self) -> bool {
        self.schema == PART_SCHEMA
    }

    /// Writes the document: keys in the order of the type.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if it cannot be written.
    pub fn write_json(&self, mut out: &mut dyn io::Write) -> Result<(), Error> {
        serde_json::to_writer_pretty(&mut out, self)
            .map_err(io::Error::from)
            .and_then(|()| out.write_all(b"\n"))
            .map_err(unwritten)
    }

    /// Writes a table of the pairs, one a line.
    ///
    /// # Errors
    ///
    /// As [`Self::write_json`].
    pub fn write_csv(&self, out: &mut dyn io::Write) -> Result<(), Error> {
        let mut table = csv::Writer::from_writer(out);
        let written = table.write_record([
            "recording",
            "design",
            "required",
            "standing",
            "verdict",
            "reason",
            "peak_angle_rad",
            "uncertainty_rad",
            "threshold_rad",
            "coast_peak_angle_rad",
            "share_lower",
            "share_upper",
            "report_id",
        ]);
        let number = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
        let lines = self.pairs.iter().map(|Pair { row, .. }| {
            [
                row.peak_angle_rad,
                row.uncertainty_rad,
                Some(row.threshold_rad),
                row.coast_peak_angle_rad,
                row.share.map(|share| share.low),
                row.share.map(|share| share.high),
            ]
            .map(number)
        });
        written
            .and_then(|()| {
                self.pairs
                    .iter()
                    .zip(lines)
                    .try_for_each(|(pair, numbers)| {
                        let names = [&pair.recording, &pair.design].map(|name| escape::cell(name));
                        let words = [
                            &*names[0],
                            &*names[1],
                            pair.required.name(),
                            pair.standing.name(),
                            pair.row.verdict.name(),
                            &*pair.row.reason.code,
                        ];
                        let numbers = numbers.iter().map(String::as_str);
                        let id = [pair.row.report_id.as_str()];
                        table.write_record(words.into_iter().chain(numbers).chain(id))
                    })
            })
            .map_err(io::Error::from)
            .and_then(|()| table.flush())
            .map_err(unwritten)
    }
}

/// Returns the error for an output of a gate that could not be written.
pub(super) fn unwritten(error: io::Error) -> Error {
    Error::io("write the gate's report", &error)
}
