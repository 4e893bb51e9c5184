//! Decisions held against what is required: exceptions, baseline, exit code.

use super::baseline::Baseline;
use super::plan::Plan;
use super::run::JudgedRecording;
use super::summary::{
    COULD_NOT, Counts, GateProblem, GateSummary, Pair, PairStanding, SummaryRecording, severity,
};
use crate::pipeline::{Answer, NUMBERS_REVISION, Row};

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

/// Holds the decisions of a plan against what it requires.
#[must_use]
pub fn hold(plan: &Plan, judged: Vec<JudgedRecording>, asked: Asked<'_>) -> GateSummary {
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
        problems.extend(comparison.removed.iter().map(|(recording, design)| GateProblem {
            code: "pair-vanished".into(),
            text: format!(
                "{recording} with {design} stands in the baseline and was not judged; put it \
                 back, or say that pairs may be gone with the setting `allow_removed`"
            ),
        }));
    }
    let counts = counts(&pairs);
    if counts.unusable == counts.pairs {
        problems.push(GateProblem {
            code: "nothing-judged".into(),
            text: "no pair was judged: this is never a pass".into(),
        });
    }
    let of_pairs = pairs.iter().map(Pair::exit_code);
    let of_problems = problems.iter().map(|_| COULD_NOT);
    let exit_code = of_pairs
        .chain(of_problems)
        .max_by_key(|code| severity(*code));
    GateSummary {
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

fn pair(plan: &Plan, recording: &str, design: &str, row: Row, asked: Asked<'_>) -> Pair {
    let required = plan.required(recording, design);
    let exception = plan
        .exceptions
        .iter()
        .find(|exception| exception.matches(recording, design) && *asked.date <= *exception.until)
        .filter(|_| row.verdict == Answer::Undecided);
    let standing = if row.verdict == required {
        PairStanding::AsRequired
    } else if exception.is_some() {
        PairStanding::Allowed
    } else if asked.no_worse
        && asked
            .baseline
            .is_some_and(|baseline| baseline.was_no_better(recording, design, required, &row))
    {
        PairStanding::NoWorse
    } else {
        PairStanding::NotAsRequired
    };
    Pair {
        recording: recording.into(),
        design: design.into(),
        required,
        exception: exception
            .filter(|_| standing == PairStanding::Allowed)
            .map(|exception| (exception.reason.clone(), exception.until.clone())),
        standing,
        row,
    }
}

/// Finds exceptions that expired, or that no pair needs.
fn exceptions(plan: &Plan, pairs: &[Pair], date: &str) -> Vec<GateProblem> {
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
            problems.push(GateProblem {
                code: "exception-expired".into(),
                text: format!(
                    "{place}: the exception \"{reason}\" held until {}, this is {date}; decide the \
                     pair, or extend it",
                    exception.until
                ),
            });
        } else if !pairs.iter().any(|pair| undecided(&pair)) {
            problems.push(GateProblem {
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
            PairStanding::AsRequired => &mut counts.as_required,
            PairStanding::Allowed => &mut counts.allowed,
            PairStanding::NoWorse => &mut counts.no_worse,
            PairStanding::NotAsRequired => &mut counts.not_as_required,
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
