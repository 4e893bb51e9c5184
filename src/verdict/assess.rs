//! From a conditioned channel to an answer: which runs are made, and what they say together.

use super::bench::{self, Bench, Pair, Purpose, Recall, samples_before, window_samples};
use super::decision::{Judged, Share, decide, unanimous, worse};
use super::ensemble::{Ensemble, Scatter};
use super::filters::{self, FilterRow};
use super::ladder::{self, Climbed, Ladder};
use super::policy::{Extras, Polarity, Policy};
use super::remarks::{Faults, crossing_outside_window, replay_findings};
use super::what_if::{self, WhatIf};
use super::{
    Answer, ErrorBudget, Evidence, Reason, RunAnswer, ScreenedRun, Trace, ribbon, screen, why,
};
use crate::conditioning::{Cfc, Conditioned, Signal, bias, resample, spectrum};
use crate::error::Error;
use crate::model::Design;
use crate::model::stop::StopModel;
use crate::parallel::Control;
use crate::recording::Finding;
use crate::replay::{Outcome, Run};
use crate::units::OpensWhen;
use std::collections::BTreeMap;

/// The answer with everything it rests on.
#[derive(Debug, Clone, PartialEq)]
pub struct Assessment {
    /// The answer.
    pub answer: Answer,
    /// Its reasons, the weightiest first.
    pub why: Vec<Reason>,
    /// The run with the largest peak.
    pub nominal: Run,
    /// Per stop, the run with the larger peak.
    pub models: BTreeMap<StopModel, Run>,
    /// Per polarity and stop, where two polarities were judged.
    pub polarities: BTreeMap<OpensWhen, BTreeMap<StopModel, Run>>,
    /// What each stop and polarity says by itself.
    pub answers: Vec<RunAnswer>,
    /// The ensemble of the stop and polarity with the largest nominal peak.
    pub ensemble: Option<Ensemble>,
    /// That of each stop and polarity that was not left out, where there are several.
    pub ensembles: Vec<Ensemble>,
    /// Which rung decided.
    pub ladder: Ladder,
    /// What one input moved by one standard deviation does to the nominal run.
    pub what_if: Vec<WhatIf>,
    /// Whether all of the judged window could be judged: no blocking finding took any of it.
    pub whole: bool,
    /// What the nominal runs say after each filter.
    pub filters: Vec<FilterRow>,
    /// Where the nominal peak's uncertainty comes from.
    pub budget: ErrorBudget,
    /// What the closed-form bounds prove, per polarity and stop.
    pub screens: Vec<ScreenedRun>,
    /// Findings of the replay; those of reading and conditioning are not repeated.
    pub findings: Vec<Finding>,
    /// What a report draws, if asked for.
    pub evidence: Option<Evidence>,
}

/// Replays `conditioned` and decides. `findings` are those of reading and conditioning.
///
/// # Errors
///
/// As [`replay::run`]; [`ErrorKind::OutOfRange`] for a window without two samples, or for
/// tolerances that leave what is physical, as [`ensemble::check`].
pub fn assess(
    conditioned: &Conditioned,
    findings: &[Finding],
    design: &Design,
    policy: &Policy,
    extras: Extras,
    control: &Control<'_>,
) -> Result<Assessment, Error> {
    let signal = &conditioned.used;
    let window = policy
        .window_s
        .map(|window| window_samples(signal, window))
        .transpose()?;
    let fine = resample::upsample_fourfold(signal);
    let bench = Bench {
        design,
        policy,
        follow_all: extras.follow_all,
        control,
        signal,
        fine: &fine,
    };
    let pairs = pairs(policy);
    let purpose = if extras.evidence {
        Purpose::Drawing
    } else {
        Purpose::Deciding
    };
    let threshold = design.criterion.threshold_rad;
    let scope_with = |filter: Option<Cfc>| {
        let faults = Faults::of(conditioned, filter, findings, policy.window_s);
        (Scope::of(&faults, signal, window), faults)
    };
    let (scope, faults) = scope_with(conditioned.filter);
    let scatter = (policy.members > 0)
        .then(|| Scatter::new(design, conditioned.bias_standard_error_m_s2, policy.seed))
        .transpose()?;
    let screens = screen::of_runs(design, signal, &pairs, |stop| bench.initial(stop), window);
    let asked = std::cell::RefCell::new(vec![None; pairs.len()]);
    let spare = |outcomes: &[Outcome]| {
        let mut spared = vec![None; pairs.len()];
        if ladder::may_leave_out(policy, extras.follow_all, scope).is_err() {
            return spared;
        }
        let largest = index_of_largest(outcomes.iter().map(|outcome| &outcome.run));
        for (index, outcome) in outcomes.iter().enumerate() {
            let screened = screens.get(index).and_then(|run| run.answer);
            let scatter = scatter.as_ref();
            let known = ladder::known(&bench, scatter, pairs[index], window, outcome, screened);
            asked.borrow_mut()[index] = Some(known);
            let proven = known.proves(outcome, threshold, policy.members);
            spared[index] = proven.filter(|_| index != largest).map(|_| known);
        }
        spared
    };
    let mut judged = bench.judge_all(&pairs, window, purpose, &spare)?;
    let mut before = match scope {
        Scope::Until(good) => {
            bench.judge_all(&pairs, Some(good), Purpose::Deciding, &bench::follow_all)?
        }
        Scope::Whole | Scope::Nothing => Vec::new(),
    };
    let ensembles = match (&scatter, scope) {
        (None, _) | (_, Scope::Nothing) => vec![None; pairs.len()],
        (Some(scatter), Scope::Whole) => {
            bench.ensembles(scatter, &pairs, &mut judged, window, false)?
        }
        (Some(scatter), Scope::Until(good)) => {
            bench.ensembles(scatter, &pairs, &mut before, Some(good), true)?
        }
    };
    let joined = |judged: &[Judged]| {
        let answers: Vec<Answer> = judged.iter().map(|run| run.answer(threshold)).collect();
        combine(policy.polarity, &pairs, &answers)
    };
    let answer = scope.answer(joined(&judged), joined(&before));

    let nominal_index = index_of_largest(judged.iter().map(Judged::run));
    let (sign, stop) = pairs[nominal_index];
    let filtered = if extras.filter_table {
        let scopes = |filter| scope_with(filter).0;
        filters::table(
            &bench,
            conditioned,
            &pairs,
            window,
            &scopes,
            &judged,
            &before,
        )?
    } else {
        Vec::new()
    };
    let budget = bench.budget(
        conditioned,
        window,
        &pairs,
        &judged,
        nominal_index,
        filters::unfiltered_peak(&filtered, nominal_index),
    )?;
    let filters: Vec<FilterRow> = filtered.into_iter().map(|filtered| filtered.row).collect();
    let mut own_findings = replay_findings(design, policy, signal.rate.interval(), &judged);
    own_findings.extend(filters::filter_decides(&filters));
    let outside = bench.crossing_outside(&pairs, &judged, window)?;
    own_findings.extend(outside.map(|at| crossing_outside_window(at, design)));
    own_findings.extend(faults.findings());
    let what_if = if scope == Scope::Whole {
        // The bias belongs to the recording: nominal runs alone are asked about it as well.
        let of_bias =
            || Scatter::of_bias(design, conditioned.bias_standard_error_m_s2, policy.seed);
        let moved = scatter.clone().unwrap_or_else(of_bias);
        what_if::reruns(&bench, conditioned, &moved, &pairs, &judged, window)?
    } else {
        Vec::new()
    };
    let why = why::reasons(&why::Case {
        answer,
        design,
        policy,
        pairs: &pairs,
        judged: &judged,
        nominal: nominal_index,
        findings,
        faults: &faults,
        outside,
        budget: &budget,
        ensembles: &ensembles,
        what_if: &what_if,
    });
    let ladder = ladder::climbed(&Climbed {
        policy,
        follow_all: extras.follow_all,
        design,
        signal,
        scope,
        pairs: &pairs,
        judged: if before.is_empty() { &judged } else { &before },
        known: &asked.into_inner(),
        screens: &screens,
        ensembles: &ensembles,
    });
    let mut models = BTreeMap::new();
    for stop in policy.model.stops() {
        let runs = pairs
            .iter()
            .zip(&judged)
            .filter(|((_, s), _)| s == stop)
            .map(|(_, judged)| judged.run());
        if let Some(run) = runs.reduce(|a, b| {
            if b.peak_angle_rad > a.peak_angle_rad {
                b
            } else {
                a
            }
        }) {
            models.insert(*stop, run.clone());
        }
    }
    let mut polarities: BTreeMap<OpensWhen, BTreeMap<StopModel, Run>> = BTreeMap::new();
    if policy.polarity.signs().len() > 1 {
        for ((sign, stop), judged) in pairs.iter().zip(&judged) {
            polarities
                .entry(*sign)
                .or_default()
                .insert(*stop, judged.run().clone());
        }
    }
    let ribbon = match &scatter {
        Some(scatter) if extras.evidence => ribbon::around(&bench, scatter, (sign, stop), window)?,
        _ => None,
    };
    let evidence = extras.evidence.then(|| Evidence {
        raw: conditioned.raw.clone(),
        used: conditioned.used.clone(),
        traces: traces(&pairs, &judged, (sign, stop)),
        ribbon,
        spectrum_raw: spectrum::amplitude_spectrum(&conditioned.raw),
        spectrum_used: spectrum::amplitude_spectrum(&conditioned.used),
        spectrogram: spectrum::spectrogram(&conditioned.used),
    });
    Ok(Assessment {
        answer,
        why,
        nominal: judged[nominal_index].run().clone(),
        models,
        polarities,
        answers: judged.iter().map(|run| run.stated(threshold)).collect(),
        ensemble: ensembles.get(nominal_index).cloned().flatten(),
        ensembles: if ensembles.iter().flatten().count() > 1 {
            ensembles.into_iter().flatten().collect()
        } else {
            Vec::new()
        },
        ladder,
        whole: scope == Scope::Whole,
        what_if,
        filters,
        budget,
        screens,
        findings: own_findings,
        evidence,
    })
}

/// Returns whether the answer of [`assess`] is a pass, with no more runs than that takes.
///
/// # Errors
///
/// As [`assess`].
pub fn passes(
    conditioned: &Conditioned,
    findings: &[Finding],
    design: &Design,
    policy: &Policy,
    control: &Control<'_>,
) -> Result<bool, Error> {
    passes_again(
        conditioned,
        findings,
        design,
        policy,
        &mut Recall::default(),
        false,
        control,
    )
}

/// As [`passes`], of a design or recording like one that was asked about before: `recall` says
/// which members to ask first, which saves most of them and changes no answer. With `presumed` a
/// pass is not certain where it would take the members of which `recall` says that they stay
/// below; what is no pass is.
pub(crate) fn passes_again(
    conditioned: &Conditioned,
    findings: &[Finding],
    design: &Design,
    policy: &Policy,
    recall: &mut Recall,
    presumed: bool,
    control: &Control<'_>,
) -> Result<bool, Error> {
    if Faults::of(conditioned, conditioned.filter, findings, policy.window_s)
        .first_bad
        .is_some()
    {
        return Ok(false);
    }
    let signal = &conditioned.used;
    let window = policy
        .window_s
        .map(|window| window_samples(signal, window))
        .transpose()?;
    let fine = resample::upsample_fourfold(signal);
    let bench = Bench {
        design,
        policy,
        follow_all: true,
        control,
        signal,
        fine: &fine,
    };
    let pairs = pairs(policy);
    let judged = bench.judge_all(&pairs, window, Purpose::Deciding, &bench::follow_all)?;
    if policy.members == 0 {
        let threshold = design.criterion.threshold_rad;
        let answers: Vec<Answer> = judged.iter().map(|run| run.answer(threshold)).collect();
        return Ok(combine(policy.polarity, &pairs, &answers) == Answer::Pass);
    }
    let scatter = Scatter::new(design, conditioned.bias_standard_error_m_s2, policy.seed)?;
    bench.all_pass(&scatter, &pairs, &judged, window, recall, presumed)
}

/// The stops and polarities that count.
fn pairs(policy: &Policy) -> Vec<Pair> {
    policy
        .polarity
        .signs()
        .iter()
        .flat_map(|sign| policy.model.stops().iter().map(|stop| (*sign, *stop)))
        .collect()
}

/// Which samples an answer may rest on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scope {
    /// All of the judged window.
    Whole,
    /// Those from first to last, before a blocking finding.
    Until((usize, usize)),
    /// None: a blocking finding holds from the start.
    Nothing,
}

impl Scope {
    /// Returns the samples that faults leave.
    fn of(faults: &Faults, signal: &Signal, window: Option<(usize, usize)>) -> Self {
        faults.first_bad.map_or(Self::Whole, |bad_s| {
            samples_before(signal, bad_s, window).map_or(Self::Nothing, Self::Until)
        })
    }

    /// Parts 1 and 2 of the rule, from what part 3 says of all samples and of the good ones.
    pub(crate) fn answer(self, of_all: Answer, of_good: Answer) -> Answer {
        match self {
            Self::Whole => of_all,
            Self::Until(_) if of_good == Answer::Fail => Answer::Fail,
            Self::Until(_) | Self::Nothing => Answer::Unusable,
        }
    }
}

/// Joins what the pairs say by parts 3 and 4 of the rule; no answers, no pass.
pub(crate) fn combine(polarity: Polarity, pairs: &[Pair], answers: &[Answer]) -> Answer {
    let per_sign: Vec<Answer> = polarity
        .signs()
        .iter()
        .map(|sign| {
            let own: Vec<Answer> = pairs
                .iter()
                .zip(answers)
                .filter(|((s, _), _)| s == sign)
                .map(|(_, answer)| *answer)
                .collect();
            unanimous(&own)
        })
        .collect();
    match polarity {
        Polarity::Both => worse(&per_sign),
        Polarity::Declared(_) | Polarity::Undeclared => unanimous(&per_sign),
    }
}

/// Returns whether all answers that the open pairs may still give lead to one.
pub(crate) fn settled(
    polarity: Polarity,
    pairs: &[Pair],
    answers: &[Option<Answer>],
    judged: &[Judged],
    threshold: f64,
) -> bool {
    let none_exceeds = Share {
        lower: 0.0,
        upper: 0.0,
        upper_with_coast: 0.0,
    };
    let mut joined: Vec<Vec<Answer>> = vec![Vec::new()];
    for (answer, judged) in answers.iter().zip(judged) {
        let mut possible = vec![Answer::Fail, Answer::Undecided];
        if decide(&judged.standing(), threshold, Some(none_exceeds)) == Answer::Pass {
            possible.push(Answer::Pass);
        }
        let possible = answer.map_or(possible, |answer| vec![answer]);
        // At most four pairs of three answers.
        joined = joined
            .iter()
            .flat_map(|before| {
                possible
                    .iter()
                    .map(|answer| [before.as_slice(), &[*answer]].concat())
            })
            .collect();
    }
    let mut outcomes = joined
        .iter()
        .map(|answers| combine(polarity, pairs, answers));
    let first = outcomes.next();
    outcomes.all(|outcome| Some(outcome) == first)
}

fn index_of_largest<'a>(runs: impl Iterator<Item = &'a Run>) -> usize {
    let peaks: Vec<f64> = runs.map(|run| run.peak_angle_rad).collect();
    let mut largest = 0;
    for (index, peak) in peaks.iter().enumerate() {
        if *peak > peaks[largest] {
            largest = index;
        }
    }
    largest
}

fn traces(pairs: &[Pair], judged: &[Judged], nominal: (OpensWhen, StopModel)) -> Vec<Trace> {
    let mut traces: Vec<Trace> = pairs
        .iter()
        .zip(judged)
        .map(|(&(opens_when, model), judged)| Trace {
            model,
            opens_when,
            points: judged.outcome.trace.clone(),
        })
        .collect();
    traces.sort_by_key(|trace| (trace.opens_when, trace.model) != nominal);
    traces
}

/// Returns the name of a filter as verdicts state it.
#[must_use]
pub fn filter_name(filter: Option<Cfc>) -> &'static str {
    filter.map_or("none", Cfc::name)
}

/// Returns how the bias's standard error counts correlated samples.
#[must_use]
pub fn bias_method() -> &'static str {
    bias::STANDARD_ERROR_METHOD
}
