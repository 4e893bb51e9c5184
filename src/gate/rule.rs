//! Decisions held against what is required: exceptions, baseline, exit code.

use super::baseline::{Baseline, BaselineComparison};
use super::pairs::{COULD_NOT, Pair, PairMark, PairStanding, Pairs, severity};
use super::plan::Plan;
use super::run::JudgedRecording;
use super::store::Store;
use super::summary::{Counts, GateProblem, GateSummary, SummaryRecording};
use crate::error::Error;
use crate::pipeline::{Answer, NUMBERS_REVISION};
use std::sync::Arc;

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
///
/// # Errors
///
/// [`crate::error::ErrorKind::Io`] if a decision can no longer be read.
pub fn hold(
    plan: &Plan,
    judged: Vec<JudgedRecording>,
    store: &Arc<Store>,
    asked: Asked<'_>,
) -> Result<GateSummary, Error> {
    let mut rows = Vec::with_capacity(judged.len());
    let recordings = plan
        .recordings
        .iter()
        .zip(judged)
        .map(|(recording, judged)| {
            rows.push(judged.rows);
            SummaryRecording {
                name: recording.name.clone(),
                sha256: judged.sha256,
                channel: judged.channel,
            }
        });
    let recordings = recordings.collect();
    let mut counts = Counts::default();
    let mut needed = vec![false; plan.exceptions.len()];
    let mut comparison = asked.baseline.map(Baseline::comparison);
    let pairs = Pairs::stored(
        Arc::clone(store),
        plan.recordings
            .iter()
            .map(|recording| recording.name.clone())
            .collect(),
        plan.designs
            .iter()
            .map(|design| design.name.clone())
            .collect(),
        plan.exceptions
            .iter()
            .map(|own| (own.reason.clone(), own.until.clone()))
            .collect(),
        rows,
        |pair| {
            let exception = stand(plan, pair, asked, &mut needed);
            counts.add(pair.standing, pair.row.verdict);
            if let Some(comparison) = &mut comparison {
                comparison.see(pair);
            }
            exception
        },
    )?;
    let mut problems = exceptions(plan, &needed, asked.date);
    let comparison = comparison.map(BaselineComparison::changes);
    if let Some(comparison) = comparison.as_ref().filter(|_| !asked.allow_removed) {
        problems.extend(comparison.removed.iter().map(|(recording, design)| GateProblem {
            code: "pair-vanished".into(),
            text: format!(
                "{recording} with {design} stands in the baseline and was not judged; put it \
                 back, or say that pairs may be gone with the setting `allow_removed`"
            ),
        }));
    }
    if counts.unusable == counts.pairs {
        problems.push(GateProblem {
            code: "nothing-judged".into(),
            text: "no pair was judged: this is never a pass".into(),
        });
    }
    let of_pairs = pairs.marks().iter().map(PairMark::exit_code);
    let of_problems = problems.iter().map(|_| COULD_NOT);
    let exit_code = of_pairs
        .chain(of_problems)
        .max_by_key(|code| severity(*code));
    Ok(GateSummary {
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
    })
}

/// Says what is required of a pair and where it stands; returns the exception that lets it through.
/// Exceptions that some pair needs are marked in `needed`.
fn stand(plan: &Plan, pair: &mut Pair, asked: Asked<'_>, needed: &mut [bool]) -> Option<u16> {
    pair.required = plan.required(&pair.recording, &pair.design);
    let undecided = pair.row.verdict == Answer::Undecided && pair.required != Answer::Undecided;
    let mut through = None;
    for (number, exception) in plan.exceptions.iter().enumerate().filter(|_| undecided) {
        if through.is_none() && exception.matches(&pair.recording, &pair.design) {
            needed[number] = true;
            if *asked.date <= *exception.until {
                through = u16::try_from(number).ok();
            }
        }
    }
    let (recording, design) = (&pair.recording, &pair.design);
    pair.standing = if pair.row.verdict == pair.required {
        PairStanding::AsRequired
    } else if let Some(number) = through {
        let exception = &plan.exceptions[usize::from(number)];
        pair.exception = Some((exception.reason.clone(), exception.until.clone()));
        PairStanding::Allowed
    } else if asked.no_worse
        && asked.baseline.is_some_and(|baseline| {
            baseline.was_no_better(recording, design, pair.required, &pair.row)
        })
    {
        PairStanding::NoWorse
    } else {
        PairStanding::NotAsRequired
    };
    through
}

/// Finds exceptions that expired, or that no pair needs.
fn exceptions(plan: &Plan, needed: &[bool], date: &str) -> Vec<GateProblem> {
    let mut problems = Vec::new();
    for (exception, needed) in plan.exceptions.iter().zip(needed) {
        let place = &exception.place;
        let reason = &exception.reason;
        if date > exception.until.as_str() {
            problems.push(GateProblem {
                code: "exception-expired".into(),
                text: format!(
                    "{place}: the exception \"{reason}\" held until {}, this is {date}; decide the \
                     pair, or extend it",
                    exception.until
                ),
            });
        } else if !needed {
            problems.push(GateProblem {
                code: "exception-not-needed".into(),
                text: format!(
                    "{place}: no pair that the exception \"{reason}\" names is undecided and without \
                     an earlier exception; take it out"
                ),
            });
        }
    }
    problems
}

impl Counts {
    fn add(&mut self, standing: PairStanding, verdict: Answer) {
        self.pairs += 1;
        *match standing {
            PairStanding::AsRequired => &mut self.as_required,
            PairStanding::Allowed => &mut self.allowed,
            PairStanding::NoWorse => &mut self.no_worse,
            PairStanding::NotAsRequired => &mut self.not_as_required,
        } += 1;
        *match verdict {
            Answer::Pass => &mut self.pass,
            Answer::Fail => &mut self.fail,
            Answer::Undecided => &mut self.undecided,
            Answer::Unusable => &mut self.unusable,
        } += 1;
    }
}
