//! Decisions held against what is required: exceptions, baseline, exit code.

use super::baseline::{Baseline, BaselineComparison};
use super::pairs::{COULD_NOT, Pair, PairNames, PairStanding, Pairs, PlacedRows, severity};
use super::plan::Plan;
use super::run::JudgedRecording;
use super::store::Store;
use super::summary::{Counts, GateProblem, GateSummary, PART_SCHEMA, SummaryRecording};
use crate::pipeline::{Answer, NUMBERS_REVISION};
use latchgate_recording::error::Error;
use std::sync::Arc;
use std::time::Duration;

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
/// [`latchgate_recording::error::ErrorKind::Io`] if a decision can no longer be read.
pub fn hold(
    plan: &Plan,
    judged: Vec<JudgedRecording>,
    store: &Arc<Store>,
    asked: Asked<'_>,
) -> Result<GateSummary, Error> {
    let times = judged.iter().flat_map(|judged| {
        let known = judged.times.iter().copied().map(Some);
        known
            .chain(std::iter::repeat(None))
            .take(plan.designs.len())
    });
    let times: Vec<Option<Duration>> = times.collect();
    let mut judged = judged.into_iter();
    let mut summary = hold_each(plan, store, asked, usize::MAX, |_| {
        let judged = judged.next().unwrap_or_default();
        let rows = store.rows(&judged.rows)?;
        Ok(HeldRecording {
            sha256: judged.sha256,
            channel: judged.channel,
            rows: judged.rows.into_iter().zip(rows).collect(),
        })
    })?;
    summary.times = times;
    Ok(summary)
}

/// A recording whose decisions are at hand.
#[derive(Debug, Default)]
pub(super) struct HeldRecording {
    pub(super) sha256: Option<String>,
    pub(super) channel: Option<String>,
    /// One for each design.
    pub(super) rows: PlacedRows,
}

/// As [`hold`], with the decisions of one recording after the other; of more than `most` pairs those
/// are kept that an output names.
pub(super) fn hold_each(
    plan: &Plan,
    store: &Arc<Store>,
    asked: Asked<'_>,
    most: usize,
    mut of: impl FnMut(usize) -> Result<HeldRecording, Error>,
) -> Result<GateSummary, Error> {
    let mut recordings = Vec::with_capacity(plan.recordings.len());
    let mut counts = Counts::default();
    let mut needed = vec![false; plan.exceptions.len()];
    let mut comparison = asked.baseline.map(Baseline::comparison);
    let mut worst = 0;
    let pairs = Pairs::stored(
        Arc::clone(store),
        names(plan),
        most,
        |number| {
            let held = of(number)?;
            recordings.push(SummaryRecording {
                name: plan.recordings[number].name.clone(),
                sha256: held.sha256,
                channel: held.channel,
            });
            Ok(held.rows)
        },
        |pair| {
            let exception = stand(plan, pair, asked, &mut needed);
            counts.add(pair.standing, pair.row.verdict);
            worst = worst.max(severity(pair.exit_code()));
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
            line: None,
            text: format!(
                "{recording} with {design} stands in the baseline and was not judged; put it \
                 back, or say that pairs may be gone with the setting `allow_removed`"
            ),
        }));
    }
    if counts.unusable == counts.pairs {
        problems.push(GateProblem {
            code: "nothing-judged".into(),
            line: None,
            text: "no pair was judged: this is never a pass".into(),
        });
    }
    let worst = if problems.is_empty() && counts.pairs > 0 {
        worst
    } else {
        severity(COULD_NOT)
    };
    let exit_code = [0, 3, 1, COULD_NOT]
        .into_iter()
        .find(|code| severity(*code) == worst);
    Ok(GateSummary {
        schema: if plan.part {
            PART_SCHEMA.into()
        } else if pairs.is_whole() {
            "latchgate.gate/1".into()
        } else {
            "latchgate.sweep/1".into()
        },
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
        times: Vec::new(),
    })
}

fn names(plan: &Plan) -> PairNames {
    let exceptions = plan.exceptions.iter();
    PairNames {
        recordings: plan.recordings.iter().map(|own| own.name.clone()).collect(),
        designs: plan.designs.iter().map(|own| own.name.clone()).collect(),
        exceptions: exceptions
            .map(|own| (own.reason.clone(), own.until.clone()))
            .collect(),
    }
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

/// Finds exceptions that expired, or that no pair needs where all were judged.
fn exceptions(plan: &Plan, needed: &[bool], date: &str) -> Vec<GateProblem> {
    let mut problems = Vec::new();
    for (exception, needed) in plan.exceptions.iter().zip(needed) {
        let place = &exception.place;
        let reason = &exception.reason;
        if date > exception.until.as_str() {
            problems.push(GateProblem {
                code: "exception-expired".into(),
                line: place.line,
                text: format!(
                    "{place}: the exception \"{reason}\" held until {}, this is {date}; decide the \
                     pair, or extend it",
                    exception.until
                ),
            });
        } else if !needed && !plan.part {
            problems.push(GateProblem {
                code: "exception-not-needed".into(),
                line: place.line,
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
