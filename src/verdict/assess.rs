//! From a conditioned channel to an answer: which runs are made, and what they say together.

use super::decision::{Judged, Share, decide, unanimous, worse};
use super::ensemble::{self, Count, End, Ensemble, Scatter};
use super::filters::{self, FilterRow};
use super::what_if::{self, WhatIf};
use super::{
    Answer, ErrorBudget, Evidence, Reason, RunAnswer, ScreenedRun, Trace, ribbon, screen, why,
};
use crate::conditioning::{Cfc, Conditioned, Signal, bias, resample, spectrum};
use crate::error::{Error, ErrorKind};
use crate::model::Design;
use crate::model::stop::StopModel;
use crate::recording::{Finding, Severity};
use crate::replay::batch::{self, BatchOptions};
use crate::replay::{self, Method, Outcome, Run, RunOptions};
use crate::units::{OpensWhen, SampleInterval};
use std::collections::BTreeMap;

/// Which stop models decide.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelChoice {
    /// Both; undecided where they differ.
    Auto,
    /// One of them.
    Only(StopModel),
}

impl ModelChoice {
    /// Returns the word that options and verdicts use.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Only(stop) => stop.name(),
        }
    }

    fn stops(self) -> &'static [StopModel] {
        match self {
            Self::Auto => &[StopModel::Rigid, StopModel::Soft],
            Self::Only(StopModel::Rigid) => &[StopModel::Rigid],
            Self::Only(StopModel::Soft) => &[StopModel::Soft],
        }
    }
}

/// The sign of the recorded acceleration that opens, and who says so.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Polarity {
    /// One sign, declared.
    Declared(OpensWhen),
    /// Both signs, declared: the worse counts.
    Both,
    /// Nobody says: both are judged, and if they differ the verdict is undecided.
    Undeclared,
}

impl Polarity {
    fn signs(self) -> &'static [OpensWhen] {
        match self {
            Self::Declared(OpensWhen::Negative) => &[OpensWhen::Negative],
            Self::Declared(OpensWhen::Positive) => &[OpensWhen::Positive],
            Self::Both | Self::Undeclared => &[OpensWhen::Negative, OpensWhen::Positive],
        }
    }
}

/// What is asked of an assessment.
#[derive(Debug, Clone, PartialEq)]
pub struct AssessOptions {
    /// Stop models that decide.
    pub model: ModelChoice,
    /// Polarity.
    pub polarity: Polarity,
    /// Integrator.
    pub method: Method,
    /// Truncation let pass in a step [rad].
    pub tolerance_rad: Option<f64>,
    /// Initial angle [rad]; `None` for that of rest on the stop.
    pub initial_angle_rad: Option<f64>,
    /// Initial angular velocity [rad/s]; `None` for rest.
    pub initial_velocity_rad_s: Option<f64>,
    /// Judged window [s].
    pub window_s: Option<(f64, f64)>,
    /// Largest ensemble; 0 for nominal runs alone.
    pub members: u32,
    /// Seed of the ensemble.
    pub seed: u64,
    /// Judge the recording after each filter as well.
    pub filter_table: bool,
    /// Threads to use; the numbers do not depend on it.
    pub threads: usize,
    /// Keep trajectories and spectra for a report.
    pub evidence: bool,
}

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
    pub models: BTreeMap<&'static str, Run>,
    /// Per polarity and stop, where two polarities were judged.
    pub polarities: BTreeMap<&'static str, BTreeMap<&'static str, Run>>,
    /// What each stop and polarity says by itself.
    pub answers: Vec<RunAnswer>,
    /// The ensemble of the stop and polarity with the largest nominal peak.
    pub ensemble: Option<Ensemble>,
    /// That of each stop and polarity, where there are several.
    pub ensembles: Vec<Ensemble>,
    /// What one input moved by one standard deviation does to the nominal run.
    pub what_if: Vec<WhatIf>,
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
    options: &AssessOptions,
) -> Result<Assessment, Error> {
    let signal = &conditioned.used;
    let window = options
        .window_s
        .map(|window| window_samples(signal, window))
        .transpose()?;
    let fine = resample::upsample_fourfold(signal);
    let bench = Bench {
        design,
        options,
        signal,
        fine: &fine,
    };
    let pairs: Vec<Pair> = options
        .polarity
        .signs()
        .iter()
        .flat_map(|sign| options.model.stops().iter().map(|stop| (*sign, *stop)))
        .collect();
    let purpose = if options.evidence {
        Purpose::Drawing
    } else {
        Purpose::Deciding
    };
    let mut judged = bench.judge_all(&pairs, window, purpose)?;
    let threshold = design.criterion.threshold_rad;
    let counted = |finding: &&Finding| counts(finding, options.window_s);
    let first_bad = findings
        .iter()
        .filter(|finding| finding.severity == Severity::Blocking)
        .filter(counted)
        .map(|finding| finding.at_s.unwrap_or(f64::NEG_INFINITY))
        .min_by(f64::total_cmp);
    let scope = first_bad.map_or(Scope::Whole, |bad_s| {
        samples_before(signal, bad_s, window).map_or(Scope::Nothing, Scope::Until)
    });
    let mut before = match scope {
        Scope::Until(good) => bench.judge_all(&pairs, Some(good), Purpose::Deciding)?,
        Scope::Whole | Scope::Nothing => Vec::new(),
    };
    let scatter = (options.members > 0)
        .then(|| Scatter::new(design, conditioned.bias_standard_error_m_s2, options.seed))
        .transpose()?;
    let ensembles = match (&scatter, scope) {
        (None, _) | (_, Scope::Nothing) => Vec::new(),
        (Some(scatter), Scope::Whole) => {
            bench.ensembles(scatter, &pairs, &mut judged, window, false)?
        }
        (Some(scatter), Scope::Until(good)) => {
            bench.ensembles(scatter, &pairs, &mut before, Some(good), true)?
        }
    };
    let joined = |judged: &[Judged]| {
        let answers: Vec<Answer> = judged.iter().map(|run| run.answer(threshold)).collect();
        combine(options.polarity, &pairs, &answers)
    };
    let answer = scope.answer(joined(&judged), joined(&before));

    let nominal_index = index_of_largest(&judged);
    let (sign, stop) = pairs[nominal_index];
    let filtered = if options.filter_table {
        filters::table(&bench, conditioned, &pairs, window, scope, &judged, &before)?
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
    let mut own_findings = replay_findings(design, options, signal.rate.interval(), &judged);
    own_findings.extend(filters::filter_decides(&filters));
    let outside = bench.crossing_outside(&pairs, &judged, window)?;
    own_findings.extend(outside.map(|at| crossing_outside_window(at, design)));
    own_findings.extend(late_faults(findings, options.window_s));
    let what_if = match (&scatter, scope) {
        (Some(scatter), Scope::Whole) => {
            what_if::reruns(&bench, conditioned, scatter, &pairs, &judged, window)?
        }
        _ => Vec::new(),
    };
    let why = why::reasons(&why::Case {
        answer,
        design,
        options,
        pairs: &pairs,
        judged: &judged,
        nominal: nominal_index,
        findings,
        first_bad,
        outside,
        late_fault: first_late_fault(findings, options.window_s),
        budget: &budget,
        ensembles: &ensembles,
        what_if: &what_if,
    });
    let mut models = BTreeMap::new();
    for stop in options.model.stops() {
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
            models.insert(stop.name(), run.clone());
        }
    }
    let mut polarities: BTreeMap<&'static str, BTreeMap<&'static str, Run>> = BTreeMap::new();
    if options.polarity.signs().len() > 1 {
        for ((sign, stop), judged) in pairs.iter().zip(&judged) {
            polarities
                .entry(sign.name())
                .or_default()
                .insert(stop.name(), judged.run().clone());
        }
    }
    let ribbon = match &scatter {
        Some(scatter) if options.evidence => ribbon::around(&bench, scatter, (sign, stop), window)?,
        _ => None,
    };
    let evidence = options.evidence.then(|| Evidence {
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
        ensemble: ensembles.get(nominal_index).cloned(),
        ensembles: if ensembles.len() > 1 {
            ensembles
        } else {
            Vec::new()
        },
        what_if,
        filters,
        budget,
        screens: screen::of_runs(design, signal, &pairs, |stop| bench.initial(stop), window),
        findings: own_findings,
        evidence,
    })
}

/// A stop and the sign that opens.
pub(super) type Pair = (OpensWhen, StopModel);

/// Which samples an answer may rest on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scope {
    /// All of the judged window.
    Whole,
    /// Those from first to last, before a blocking finding.
    Until((usize, usize)),
    /// None: a blocking finding holds from the start.
    Nothing,
}

impl Scope {
    /// Parts 1 and 2 of the rule, from what part 3 says of all samples and of the good ones.
    pub(super) fn answer(self, of_all: Answer, of_good: Answer) -> Answer {
        match self {
            Self::Whole => of_all,
            Self::Until(_) if of_good == Answer::Fail => Answer::Fail,
            Self::Until(_) | Self::Nothing => Answer::Unusable,
        }
    }
}

/// What a run is for, which says what it need not carry along.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    /// Decides, and is drawn.
    Drawing,
    /// Decides.
    Deciding,
    /// Is compared with one that decides: its own error does not matter.
    Comparison,
}

/// What every run of one assessment shares.
#[derive(Clone, Copy)]
pub(super) struct Bench<'a> {
    pub(super) design: &'a Design,
    pub(super) options: &'a AssessOptions,
    pub(super) signal: &'a Signal,
    /// The band-limited fourfold of the samples.
    pub(super) fine: &'a Signal,
}

/// Samples, of all runs, from which further threads gain more than their start costs.
const SHARED_SAMPLES: usize = 20_000;

/// Members that a thread takes at a time.
const MEMBERS_TAKEN: usize = 64;

impl Bench<'_> {
    /// Threads that `runs` runs are shared among: one for a few of a short recording.
    pub(super) fn threads(&self, runs: usize) -> usize {
        if self.signal.samples.len().saturating_mul(runs) < SHARED_SAMPLES {
            1
        } else {
            self.options.threads
        }
    }

    /// The initial state asked for, what is left open being that of rest on the stop.
    pub(super) fn initial(&self, stop: StopModel) -> Option<(f64, f64)> {
        let (angle, velocity) = (
            self.options.initial_angle_rad,
            self.options.initial_velocity_rad_s,
        );
        if angle.is_none() && velocity.is_none() {
            return None;
        }
        let rest = match stop {
            StopModel::Rigid => 0.0,
            StopModel::Soft => self.design.stop.rest_angle_rad(&self.design.lever),
        };
        Some((angle.unwrap_or(rest), velocity.unwrap_or(0.0)))
    }

    pub(super) fn run(
        &self,
        signal: &Signal,
        pair: Pair,
        window: Option<(usize, usize)>,
        purpose: Purpose,
    ) -> Result<Outcome, Error> {
        // The error budget reruns with the other stop, which the method asked for may not know.
        let (method, tolerance_rad) = if self.options.method.admits(pair.1) {
            (self.options.method, self.options.tolerance_rad)
        } else {
            (Method::EventDriven, None)
        };
        replay::run(
            signal,
            self.design,
            &RunOptions {
                stop: pair.1,
                opens_when: pair.0,
                method,
                tolerance_rad,
                step_s: None,
                initial: self.initial(pair.1),
                window,
                trace: purpose == Purpose::Drawing,
                error_bound: purpose != Purpose::Comparison,
            },
        )
    }

    /// Runs every pair on the samples and on their fourfold.
    pub(super) fn judge_all(
        &self,
        pairs: &[Pair],
        window: Option<(usize, usize)>,
        purpose: Purpose,
    ) -> Result<Vec<Judged>, Error> {
        let fine_window = window.map(|(first, last)| (4 * first, 4 * last));
        let tasks: Vec<(usize, bool)> = (0..pairs.len())
            .flat_map(|pair| [(pair, true), (pair, false)])
            .collect();
        let outcomes = in_parallel(self.threads(1), &tasks, |&(pair, fine)| {
            if fine {
                self.run(self.fine, pairs[pair], fine_window, Purpose::Comparison)
            } else {
                self.run(self.signal, pairs[pair], window, purpose)
            }
        });
        let mut judged = Vec::with_capacity(pairs.len());
        let mut outcomes = outcomes.into_iter();
        while let (Some(fine), Some(nominal)) = (outcomes.next(), outcomes.next()) {
            let (fine, outcome) = (fine?, nominal?);
            let highest = |run: &Run| {
                run.coast_peak_angle_rad
                    .map_or(run.peak_angle_rad, |coast| coast.max(run.peak_angle_rad))
            };
            let interpolation_error_rad = (fine.run.peak_angle_rad - outcome.run.peak_angle_rad)
                .abs()
                .max(if outcome.run.coast_peak_angle_rad.is_some() {
                    (highest(&fine.run) - highest(&outcome.run)).abs()
                } else {
                    0.0
                });
            judged.push(Judged {
                outcome,
                // A rerun that could not be followed bounds nothing.
                interpolation_error_rad: if fine.broke_down {
                    f64::MAX
                } else {
                    interpolation_error_rad
                },
                share: None,
            });
        }
        Ok(judged)
    }

    /// Runs the ensemble of every pair, look by look, until the rule decides or what is still
    /// open can no longer change the answer; notes in `judged` what it adds. `limited`: the
    /// samples end before a fault.
    fn ensembles(
        &self,
        scatter: &Scatter,
        pairs: &[Pair],
        judged: &mut [Judged],
        window: Option<(usize, usize)>,
        limited: bool,
    ) -> Result<Vec<Ensemble>, Error> {
        let threshold = self.design.criterion.threshold_rad;
        let polarity = self.options.polarity;
        // The largest nominal peak comes first: its ensemble is the one that is shown.
        let mut order: Vec<usize> = (0..pairs.len()).collect();
        order.sort_by(|a, b| {
            let peak = |index: &usize| judged[*index].run().peak_angle_rad;
            peak(b).total_cmp(&peak(a))
        });
        let mut peaks: Vec<Vec<f64>> = vec![Vec::new(); pairs.len()];
        let mut looks = vec![0; pairs.len()];
        let mut answers: Vec<Option<Answer>> = vec![None; pairs.len()];
        let mut ends = vec![End::NoMatter; pairs.len()];
        for (number, look) in (1..).zip(ensemble::looks(self.options.members)) {
            for &pair in &order {
                let settled =
                    looks[pair] > 0 && settled(polarity, pairs, &answers, judged, threshold);
                if answers[pair].is_some() || settled {
                    continue;
                }
                self.extend(scatter, pairs[pair], window, look, &mut peaks[pair])?;
                looks[pair] = number;
                let share = Count::of(&peaks[pair], threshold).share();
                judged[pair].share = Some(share);
                let answer = judged[pair].answer(threshold);
                if answer != Answer::Undecided {
                    (answers[pair], ends[pair]) = (Some(answer), End::Decided);
                } else if look == self.options.members {
                    (answers[pair], ends[pair]) = (Some(answer), End::LastLook);
                }
            }
        }
        let until = window
            .filter(|_| limited)
            .map(|(_, last)| self.signal.time_s(last));
        Ok((0..pairs.len())
            .map(|pair| {
                ensemble::summarise(
                    scatter,
                    &peaks[pair],
                    threshold,
                    pairs[pair],
                    (looks[pair], ends[pair]),
                    until,
                )
            })
            .collect())
    }

    /// Runs the members of one pair up to `look`, those that are in `peaks` not again.
    fn extend(
        &self,
        scatter: &Scatter,
        pair: Pair,
        window: Option<(usize, usize)>,
        look: u32,
        peaks: &mut Vec<f64>,
    ) -> Result<(), Error> {
        let known = u32::try_from(peaks.len()).unwrap_or(look);
        let tasks: Vec<u32> = (known..look).step_by(MEMBERS_TAKEN).collect();
        let threads = self.threads(tasks.len().saturating_mul(MEMBERS_TAKEN));
        for result in in_parallel(threads, &tasks, |&first| {
            let count = MEMBERS_TAKEN.min((look - first) as usize);
            self.peaks(pair, window, count, &|index| {
                scatter.member(first.saturating_add(u32::try_from(index).unwrap_or(0)))
            })
        }) {
            peaks.extend(result?);
        }
        Ok(())
    }

    /// Returns the peaks of `count` members on one stop and polarity [rad], NaN where one could
    /// not be followed.
    pub(super) fn peaks(
        &self,
        pair: Pair,
        window: Option<(usize, usize)>,
        count: usize,
        member: &(impl Fn(usize) -> batch::Member + Sync),
    ) -> Result<Vec<f64>, Error> {
        let options = BatchOptions {
            stop: pair.1,
            opens_when: pair.0,
            initial: self.initial(pair.1),
            window,
            coast: false,
            threads: 1,
        };
        let peaks = batch::peaks(self.signal, count, member, &options)?;
        Ok(peaks.iter().map(|peak| peak.peak_angle_rad).collect())
    }

    /// When the lever first crosses the threshold outside the judged window, if it does so on
    /// a stop and polarity that do not cross inside.
    fn crossing_outside(
        &self,
        pairs: &[Pair],
        judged: &[Judged],
        window: Option<(usize, usize)>,
    ) -> Result<Option<f64>, Error> {
        let tasks: Vec<Pair> = pairs
            .iter()
            .zip(judged)
            .filter(|(_, judged)| window.is_some() && judged.run().first_crossing_s.is_none())
            .map(|(pair, _)| *pair)
            .collect();
        let mut first: Option<f64> = None;
        for outcome in in_parallel(self.threads(1), &tasks, |pair| {
            self.run(self.signal, *pair, None, Purpose::Comparison)
        }) {
            let crossing = outcome?.run.first_crossing_s;
            first = match (first, crossing) {
                (Some(first), Some(crossing)) => Some(first.min(crossing)),
                (first, crossing) => first.or(crossing),
            };
        }
        Ok(first)
    }

    fn budget(
        &self,
        conditioned: &Conditioned,
        window: Option<(usize, usize)>,
        pairs: &[Pair],
        judged: &[Judged],
        nominal: usize,
        unfiltered_peak: Option<f64>,
    ) -> Result<ErrorBudget, Error> {
        let (sign, stop) = pairs[nominal];
        let peak = judged[nominal].run().peak_angle_rad;
        let other_stop = match stop {
            StopModel::Rigid => StopModel::Soft,
            StopModel::Soft => StopModel::Rigid,
        };
        let known = |pair| {
            pairs
                .iter()
                .position(|known| *known == pair)
                .map(|index| judged[index].run().peak_angle_rad)
        };
        // Each entry is a rerun: the signal to use and the pair to run it with.
        let mut reruns: Vec<(Part, Signal, Pair)> = Vec::new();
        if unfiltered_peak.is_none() && conditioned.filter.is_some() {
            let unfiltered = filters::filtered(conditioned, None)?;
            reruns.push((Part::Filter, unfiltered, (sign, stop)));
        }
        if conditioned.bias_samples > 0 {
            for direction in [-1.0, 1.0] {
                let mut shifted = self.signal.clone();
                let shift = direction * conditioned.bias_standard_error_m_s2;
                shifted.samples.iter_mut().for_each(|a| *a += shift);
                reruns.push((Part::Bias, shifted, (sign, stop)));
            }
        }
        let model_peak = known((sign, other_stop));
        // A lever that starts inside the soft stop has no counterpart on the rigid one.
        let admitted = other_stop == StopModel::Soft
            || self
                .options
                .initial_angle_rad
                .is_none_or(|angle| angle >= 0.0);
        if model_peak.is_none() && admitted {
            reruns.push((Part::Model, self.signal.clone(), (sign, other_stop)));
        }
        let outcomes = in_parallel(self.threads(1), &reruns, |(_, signal, pair)| {
            self.run(signal, *pair, window, Purpose::Comparison)
        });
        let mut budget = ErrorBudget {
            numerical: Some(judged[nominal].run().numerical_error_rad),
            interpolation: Some(judged[nominal].interpolation_error_rad),
            model: model_peak.map(|other| (other - peak).abs()),
            filter: unfiltered_peak
                .or(conditioned.filter.is_none().then_some(peak))
                .map(|other| (other - peak).abs()),
            bias: None,
            polarity: None,
        };
        for ((part, _, _), outcome) in reruns.iter().zip(outcomes) {
            let change = (outcome?.run.peak_angle_rad - peak).abs();
            let entry = match part {
                Part::Filter => &mut budget.filter,
                Part::Bias => &mut budget.bias,
                Part::Model => &mut budget.model,
            };
            *entry = Some(entry.map_or(change, |before| before.max(change)));
        }
        if self.options.polarity == Polarity::Undeclared {
            budget.polarity = known((sign.reversed(), stop)).map(|other| (other - peak).abs());
        }
        Ok(budget)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Filter,
    Bias,
    Model,
}

/// Calls `work` on each item, on up to `threads` threads; results in the items' order.
pub(super) fn in_parallel<T: Sync, R: Send>(
    threads: usize,
    items: &[T],
    work: impl Fn(&T) -> R + Sync,
) -> Vec<R> {
    let threads = threads.clamp(1, items.len().max(1));
    if threads == 1 {
        return items.iter().map(work).collect();
    }
    let next = std::sync::atomic::AtomicUsize::new(0);
    let take = || {
        let mut done = Vec::new();
        loop {
            let index = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            match items.get(index) {
                Some(item) => done.push((index, work(item))),
                None => return done,
            }
        }
    };
    let mut results: Vec<(usize, R)> = std::thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|_| scope.spawn(take)).collect();
        let mut results = take();
        for other in others {
            match other.join() {
                Ok(part) => results.extend(part),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        results
    });
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}

/// Joins what the pairs say by parts 3 and 4 of the rule; no answers, no pass.
pub(super) fn combine(polarity: Polarity, pairs: &[Pair], answers: &[Answer]) -> Answer {
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
fn settled(
    polarity: Polarity,
    pairs: &[Pair],
    answers: &[Option<Answer>],
    judged: &[Judged],
    threshold: f64,
) -> bool {
    let none_exceeds = Share {
        lower: 0.0,
        upper: 0.0,
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

fn index_of_largest(judged: &[Judged]) -> usize {
    let mut largest = 0;
    for (index, candidate) in judged.iter().enumerate() {
        if candidate.run().peak_angle_rad > judged[largest].run().peak_angle_rad {
            largest = index;
        }
    }
    largest
}

/// A fault that begins after the judged window does not count.
fn counts(finding: &Finding, window_s: Option<(f64, f64)>) -> bool {
    match (window_s, finding.at_s) {
        (Some((_, end)), Some(at)) => at <= end,
        _ => true,
    }
}

fn late_faults(findings: &[Finding], window_s: Option<(f64, f64)>) -> Option<Finding> {
    let first = first_late_fault(findings, window_s)?;
    Some(Finding::warning(
        "fault-after-window",
        format!(
            "What blocks a verdict from {} on lies after the end of the judged window and does not count; the verdict says nothing about what follows the window.",
            why::instant(first)
        ),
    )
    .at(first))
}

/// When the first blocking finding begins that lies after the judged window.
fn first_late_fault(findings: &[Finding], window_s: Option<(f64, f64)>) -> Option<f64> {
    findings
        .iter()
        .filter(|finding| finding.severity == Severity::Blocking && !counts(finding, window_s))
        .filter_map(|finding| finding.at_s)
        .min_by(f64::total_cmp)
}

fn crossing_outside_window(at_s: f64, design: &Design) -> Finding {
    Finding::warning(
        "crossing-outside-window",
        format!(
            "Outside the judged window the lever crosses the limit of {} rad, first at {}; with --window that does not count.",
            design.criterion.threshold_rad,
            why::instant(at_s)
        ),
    )
    .at(at_s)
}

/// First and last sample inside a window.
fn window_samples(signal: &Signal, (from, to): (f64, f64)) -> Result<(usize, usize), Error> {
    let rate = signal.rate.hertz();
    let count = signal.samples.len();
    // A billionth of a sample absorbs the rounding of a bound that was meant to hit a sample.
    let place = |time: f64| (time - signal.start_s) * rate;
    #[expect(clippy::cast_precision_loss, reason = "indices stay far below 2^53")]
    let last = count as f64 - 1.0;
    let first_index = (place(from) - 1e-6).ceil().max(0.0);
    let last_index = (place(to) + 1e-6).floor().min(last);
    if first_index.is_nan() || last_index.is_nan() || first_index >= last_index {
        return Err(ErrorKind::OutOfRange {
            what: "window [s]".into(),
            expected: format!(
                "an interval that holds at least two samples of the record, which runs from {} to {}",
                signal.start_s,
                signal.end_s()
            ),
            found: format!("{from}..{to}"),
        }
        .into());
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 0 and the number of samples"
    )]
    Ok((first_index as usize, last_index as usize))
}

/// The judged samples before the first bad one, if there are two.
fn samples_before(
    signal: &Signal,
    bad_s: f64,
    window: Option<(usize, usize)>,
) -> Option<(usize, usize)> {
    let (first, last) = window.unwrap_or((0, signal.samples.len() - 1));
    let place = (bad_s - signal.start_s) * signal.rate.hertz();
    #[expect(clippy::cast_precision_loss, reason = "indices stay far below 2^53")]
    if place.is_nan() || place <= first as f64 + 2.0 {
        return None;
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "positive, and cut at the last sample"
    )]
    let good = ((place - 1e-6).ceil() as usize).saturating_sub(1).min(last);
    (good > first + 1).then_some((first, good))
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

/// What the replay itself found odd.
fn replay_findings(
    design: &Design,
    options: &AssessOptions,
    interval: SampleInterval,
    judged: &[Judged],
) -> Vec<Finding> {
    let mut findings = Vec::new();
    if options.polarity == Polarity::Undeclared {
        findings.push(Finding::warning(
            "polarity-undeclared",
            "Neither option nor card says which sign of the recorded acceleration opens the lever; both were judged. State it with --opens-when or in the card.",
        ));
    }
    if judged
        .iter()
        .any(|j| j.run().peak_angle_rad > std::f64::consts::FRAC_PI_2)
    {
        findings.push(Finding::info(
            "beyond-geometry",
            "The angle exceeds π/2, where a lever on a latch has long met other parts: the crossing of the threshold stands, the size of the peak does not.",
        ));
    }
    if let Some(j) = judged.iter().find(|j| j.outcome.broke_down) {
        findings.push(Finding::warning(
            "method-broke-down",
            format!("The {} method could not follow the lever on the {} stop{}; its numbers mean nothing.", j.run().method, j.run().model.name(), j.outcome.breakdown.map_or_else(String::new, |why| format!(": {}", why.text()))),
        ));
    }
    findings.extend(method_findings(design, options, interval, judged));
    for j in judged {
        let run = j.run();
        if run.numerical_error_rad > 0.01 * design.criterion.threshold_rad
            && options.method == Method::EventDriven
        {
            findings.push(Finding::warning(
                "rounding-amplified",
                format!(
                    "{} impacts on the {} stop have carried rounding to {:.1e} rad: the peak is not known better than that.",
                    run.impacts,
                    run.model.name(),
                    run.numerical_error_rad
                ),
            ));
        }
        if run.first_crossing_s.is_some_and(|time| time < 0.0) {
            findings.push(
                Finding::warning(
                    "crossing-before-contact",
                    format!("On the {} stop the threshold is crossed before time zero, the instant of first contact: check bias, filter and time zero.", run.model.name()),
                )
                .at(run.first_crossing_s.unwrap_or(0.0)),
            );
        }
    }
    findings
}

/// What is known of the method that was asked for.
fn method_findings(
    design: &Design,
    options: &AssessOptions,
    interval: SampleInterval,
    judged: &[Judged],
) -> Vec<Finding> {
    let method = options.method;
    let mut findings = Vec::new();
    match method {
        Method::EventDriven => return findings,
        Method::Rk4 { .. } => findings.push(Finding::warning(
            "fixed-step-method",
            "The fixed-step method sees impacts only at the end of a step; it is for comparison, and its stated error is an estimate from halving the step.",
        )),
        _ => findings.push(Finding::warning(
            "comparison-method",
            format!(
                "The {} method is for comparison; its stated error is an estimate from a second run with {}.",
                method.name(),
                if method.steps_per_period().is_some() { "half the step" } else { "a tenth of the tolerance" }
            ),
        )),
    }
    for stop in [StopModel::Rigid, StopModel::Soft] {
        if judged.iter().any(|j| j.run().model == stop) {
            for text in method.known_failures(design, stop, interval, options.tolerance_rad) {
                if !findings.iter().any(|known| known.text == text) {
                    findings.push(Finding::warning("method-known-to-fail", text));
                }
            }
        }
    }
    findings
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
