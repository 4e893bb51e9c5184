//! Decisions compared with the requirements: exceptions, baseline, exit code.

use super::baseline::{Baseline, BaselineComparison};
use super::pairs::{COULD_NOT, Pair, PairStanding, severity};
use super::plan::Plan;
use super::run::JudgedRecording;
use super::summary::{
    Counts, GateProblem, GateSummary, PART_SCHEMA, SCHEMA, StaticStanding, SummaryRecording,
};
use crate::pipeline::{Answer, Design, NUMBERS_REVISION};
use latchgate_verdict::statics::{StaticLever, StaticQuestion};

/// Options of a summary beside its gate.
#[derive(Debug, Clone, Copy, Default)]
pub struct SummaryOptions<'a> {
    /// The day on which exceptions must still hold, `YYYY-MM-DD`.
    pub date: &'a str,
    /// An earlier summary.
    pub baseline: Option<&'a Baseline>,
    /// Pairs of the baseline may be gone.
    pub allow_removed: bool,
    /// Pairs that were not as required in the baseline and are no worse are let through.
    pub no_worse: bool,
}

/// Compares the decisions of a plan, recording by recording in its order, with its requirements.
pub fn summarise(
    plan: &Plan,
    judged: Vec<JudgedRecording>,
    options: SummaryOptions<'_>,
) -> GateSummary {
    let mut recordings = Vec::with_capacity(plan.recordings.len());
    let (mut pairs, mut times) = (Vec::new(), Vec::new());
    let mut counts = Counts::default();
    let mut needed = vec![false; plan.exceptions.len()];
    let mut comparison = options.baseline.map(Baseline::comparison);
    let mut worst = 0;
    for (recording, judged) in plan.recordings.iter().zip(judged) {
        recordings.push(SummaryRecording {
            name: recording.name.clone(),
            sha256: judged.sha256,
            channel: judged.channel,
        });
        let mut took = judged.times.into_iter();
        for (design, row) in plan.designs.iter().zip(judged.rows) {
            let mut pair = Pair {
                recording: recording.name.clone(),
                design: design.name.clone(),
                required: plan.required(&recording.name, &design.name),
                standing: PairStanding::NotAsRequired,
                exception: None,
                row,
            };
            set_standing(plan, &mut pair, options, &mut needed);
            counts.add(pair.standing, pair.row.verdict);
            worst = worst.max(severity(pair.exit_code()));
            if let Some(comparison) = &mut comparison {
                comparison.add(&pair);
            }
            pairs.push(pair);
            times.push(took.next());
        }
    }
    let statics = statics(plan);
    if statics.iter().any(|standing| !standing.holds) {
        worst = worst.max(severity(Answer::Fail.exit_code()));
    }
    let mut problems = exceptions(plan, &needed, options.date);
    let changes = comparison.map(BaselineComparison::changes);
    if let Some(changes) = changes.as_ref().filter(|_| !options.allow_removed) {
        problems.extend(changes.removed.iter().map(|(recording, design)| GateProblem {
            code: "pair-vanished".into(),
            line: None,
            text: format!(
                "{recording} with {design} is in the baseline, but was not judged; restore it, or \
                 allow it with the setting `allow_removed`"
            ),
        }));
    }
    // True of a gate without pairs, too: it must not pass.
    if counts.unusable == counts.pairs {
        problems.push(GateProblem {
            code: "nothing-judged".into(),
            line: None,
            text: "no pair was judged, which is never a pass".into(),
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
    GateSummary {
        schema: if plan.part {
            PART_SCHEMA.into()
        } else {
            SCHEMA.into()
        },
        gate: plan.gate.clone(),
        exit_code: exit_code.unwrap_or(COULD_NOT),
        counts,
        problems,
        designs: plan.designs.clone(),
        recordings,
        pairs,
        statics,
        baseline: changes,
        version: env!("CARGO_PKG_VERSION").into(),
        numbers_revision: NUMBERS_REVISION,
        times,
    }
}

/// Compares every design with the required static load.
fn statics(plan: &Plan) -> Vec<StaticStanding> {
    let Some(required) = plan.require_static else {
        return Vec::new();
    };
    let standing = |design: &Design| {
        let question = StaticQuestion {
            standard: Some(required.standard),
            door: required.door,
            ..StaticQuestion::default()
        };
        let lever = StaticLever::from(design);
        let is_stated = lever.with_least_spring(&question).is_some();
        let rows = lever.rows_at_least(&question);
        let answers = StaticLever::answers(&question, &rows, is_stated);
        let answer = answers.first();
        let least = answer.and_then(|answer| answer.opens_at_g);
        let apart_g = answer.and_then(|answer| answer.apart_g);
        // A level that is none holds nothing; of a lever that nothing opens there is none either.
        let never_opens =
            answer.is_some_and(|answer| least.is_none() && answer.holds != Some(false));
        let stays = |level: Option<f64>| level.is_none_or(|level| level >= required.load_g);
        let is_held = (never_opens || least.is_some()) && stays(least) && stays(apart_g);
        StaticStanding {
            design: design.name.clone(),
            standard: required.standard,
            door: required.door,
            opens_at_g: least,
            required_g: required.load_g,
            holds: is_stated && is_held,
            spring_stated: is_stated,
            apart_g,
        }
    };
    plan.designs.iter().map(standing).collect()
}

/// Sets the standing of a pair, and marks in `needed` the exceptions that it needs.
fn set_standing(plan: &Plan, pair: &mut Pair, options: SummaryOptions<'_>, needed: &mut [bool]) {
    // An exception lets only undecided pairs through: a fail or an unusable recording never passes.
    let undecided = pair.row.verdict == Answer::Undecided && pair.required != Answer::Undecided;
    for (exception, needed) in plan.exceptions.iter().zip(needed).filter(|_| undecided) {
        if pair.exception.is_none() && exception.matches(&pair.recording, &pair.design) {
            // Marked even where it expired: then it is reported as expired, not as superfluous.
            *needed = true;
            if *options.date <= *exception.until {
                pair.exception = Some((exception.reason.clone(), exception.until.clone()));
            }
        }
    }
    let (recording, design) = (&pair.recording, &pair.design);
    pair.standing = if pair.row.verdict == pair.required {
        PairStanding::AsRequired
    } else if pair.exception.is_some() {
        PairStanding::Allowed
    } else if options.no_worse
        && options.baseline.is_some_and(|baseline| {
            baseline.was_no_better(recording, design, pair.required, &pair.row)
        })
    {
        PairStanding::NoWorse
    } else {
        PairStanding::NotAsRequired
    };
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
                    "{place}: the exception \"{reason}\" ended on {}, today is {date}; decide the \
                     pair, or extend the exception",
                    exception.until
                ),
            });
        } else if !needed && !plan.part {
            problems.push(GateProblem {
                code: "exception-not-needed".into(),
                line: place.line,
                text: format!(
                    "{place}: the exception \"{reason}\" matches no undecided pair without an \
                     earlier exception; remove it"
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
