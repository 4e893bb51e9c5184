//! What became of each pair and of the whole: the document of a gate.

use super::baseline::{Baseline, Comparison};
use super::plan::Plan;
use super::run::Judged;
use crate::pipeline::{Answer, Design, NUMBERS_REVISION, Row};
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;

/// Exit code of a gate of which something could not be done, or in which nothing was judged.
pub const COULD_NOT: u8 = 4;

/// summary.json, key by key.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Summary {
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
    pub problems: Vec<Problem>,
    /// The designs.
    pub designs: Vec<Design>,
    /// The recordings.
    pub recordings: Vec<SummaryRecording>,
    /// Each recording with each design, in the order of their names.
    pub pairs: Vec<Pair>,
    /// What changed since the baseline; `None` without one.
    pub baseline: Option<Comparison>,
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
pub struct Problem {
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
pub enum Standing {
    /// It answers as required.
    AsRequired,
    /// It is undecided, and an exception lets it through.
    Allowed,
    /// It is not as required, but was not in the baseline either and is no worse.
    NoWorse,
    /// It is not as required.
    NotAsRequired,
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
    pub standing: Standing,
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
            (Standing::NotAsRequired, Answer::Unusable) => COULD_NOT,
            (Standing::NotAsRequired, Answer::Undecided) => Answer::Undecided.exit_code(),
            // A pass where a fail was required is a failure of the gate.
            (Standing::NotAsRequired, _) => Answer::Fail.exit_code(),
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
fn severity(code: u8) -> u8 {
    match code {
        0 => 0,
        3 => 1,
        1 => 2,
        _ => 3,
    }
}

/// What is asked of a summary beside its gate.
#[derive(Debug, Clone, Copy, Default)]
pub struct Asked<'a> {
    /// The day against which exceptions are held, `YYYY-MM-DD`.
    pub date: &'a str,
    /// An earlier summary.
    pub baseline: Option<&'a Baseline>,
    /// Pairs of the baseline may be gone.
    pub allow_removed: bool,
    /// What was not as required in the baseline and is no worse is let stand.
    pub no_worse: bool,
}

impl Summary {
    /// Holds the decisions of a plan against what it requires.
    #[must_use]
    pub fn of(plan: &Plan, judged: Vec<Judged>, asked: Asked<'_>) -> Self {
        let mut pairs = Vec::with_capacity(plan.recordings.len() * plan.designs.len());
        let mut recordings = Vec::with_capacity(plan.recordings.len());
        for (recording, judged) in plan.recordings.iter().zip(judged) {
            recordings.push(SummaryRecording {
                name: recording.name.clone(),
                sha256: judged.sha256,
                channel: judged.channel,
            });
            for (design, row) in plan.designs.iter().zip(judged.rows) {
                pairs.push(pair(plan, &recording.name, &design.name, row, asked));
            }
        }
        let mut problems = exceptions(plan, &pairs, asked.date);
        let comparison = asked.baseline.map(|baseline| baseline.compare(&pairs));
        if let Some(comparison) = comparison.as_ref().filter(|_| !asked.allow_removed) {
            problems.extend(comparison.removed.iter().map(|(recording, design)| Problem {
                code: "pair-vanished".into(),
                text: format!(
                    "{recording} with {design} stands in the baseline and was not judged; put it \
                     back, or say that pairs may be gone with the setting `allow_removed`"
                ),
            }));
        }
        let counts = counts(&pairs);
        if counts.unusable == counts.pairs {
            problems.push(Problem {
                code: "nothing-judged".into(),
                text: "no pair was judged: this is never a pass".into(),
            });
        }
        let of_pairs = pairs.iter().map(Pair::exit_code);
        let of_problems = problems.iter().map(|_| COULD_NOT);
        let exit_code = of_pairs
            .chain(of_problems)
            .max_by_key(|code| severity(*code));
        Self {
            schema: "latchgate.gate/1".into(),
            gate: plan.gate.clone(),
            exit_code: exit_code.unwrap_or(COULD_NOT),
            counts,
            problems,
            designs: plan.designs.clone(),
            recordings,
            pairs,
            baseline: comparison,
            version: env!("CARGO_PKG_VERSION").into(),
            numbers_revision: NUMBERS_REVISION,
        }
    }

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

fn pair(plan: &Plan, recording: &str, design: &str, row: Row, asked: Asked<'_>) -> Pair {
    let required = plan.required(recording, design);
    let exception = plan
        .exceptions
        .iter()
        .find(|exception| exception.matches(recording, design) && *asked.date <= *exception.until)
        .filter(|_| row.verdict == Answer::Undecided);
    let standing = if row.verdict == required {
        Standing::AsRequired
    } else if exception.is_some() {
        Standing::Allowed
    } else if asked.no_worse
        && asked
            .baseline
            .is_some_and(|baseline| baseline.was_no_better(recording, design, required, &row))
    {
        Standing::NoWorse
    } else {
        Standing::NotAsRequired
    };
    Pair {
        recording: recording.into(),
        design: design.into(),
        required,
        exception: exception
            .filter(|_| standing == Standing::Allowed)
            .map(|exception| (exception.reason.clone(), exception.until.clone())),
        standing,
        row,
    }
}

/// Finds exceptions that expired, or that no pair needs.
fn exceptions(plan: &Plan, pairs: &[Pair], date: &str) -> Vec<Problem> {
    let mut problems = Vec::new();
    for exception in &plan.exceptions {
        let place = &exception.place;
        let reason = &exception.reason;
        let undecided = |pair: &&Pair| {
            pair.row.verdict == Answer::Undecided
                && pair.required != Answer::Undecided
                && exception.matches(&pair.recording, &pair.design)
        };
        if date > exception.until.as_str() {
            problems.push(Problem {
                code: "exception-expired".into(),
                text: format!(
                    "{place}: the exception \"{reason}\" held until {}, this is {date}; decide the \
                     pair, or extend it",
                    exception.until
                ),
            });
        } else if !pairs.iter().any(|pair| undecided(&pair)) {
            problems.push(Problem {
                code: "exception-not-needed".into(),
                text: format!(
                    "{place}: no pair that the exception \"{reason}\" names is undecided; take it out"
                ),
            });
        }
    }
    problems
}

fn counts(pairs: &[Pair]) -> Counts {
    let mut counts = Counts {
        pairs: pairs.len(),
        ..Counts::default()
    };
    for pair in pairs {
        *match pair.standing {
            Standing::AsRequired => &mut counts.as_required,
            Standing::Allowed => &mut counts.allowed,
            Standing::NoWorse => &mut counts.no_worse,
            Standing::NotAsRequired => &mut counts.not_as_required,
        } += 1;
        *match pair.row.verdict {
            Answer::Pass => &mut counts.pass,
            Answer::Fail => &mut counts.fail,
            Answer::Undecided => &mut counts.undecided,
            Answer::Unusable => &mut counts.unusable,
        } += 1;
    }
    counts
}
