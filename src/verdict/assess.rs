//! From a conditioned channel to an answer: which runs are made, and what they say together.

use super::decision::{Judged, unanimous, worse};
use super::{Answer, ErrorBudget, Evidence, Reason, RunAnswer, Trace, why};
use crate::conditioning::{self, Cfc, Conditioned, Signal, bias, resample, spectrum};
use crate::error::{Error, ErrorKind};
use crate::model::Design;
use crate::model::stop::StopModel;
use crate::recording::{Finding, Severity};
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

    pub(super) fn stops(self) -> &'static [StopModel] {
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
    pub(super) fn signs(self) -> &'static [OpensWhen] {
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
    /// Where the nominal peak's uncertainty comes from.
    pub budget: ErrorBudget,
    /// Findings of the replay; those of reading and conditioning are not repeated.
    pub findings: Vec<Finding>,
    /// What a report draws, if asked for.
    pub evidence: Option<Evidence>,
}

/// Replays `conditioned` and decides. `findings` are those of reading and conditioning.
///
/// # Errors
///
/// As [`replay::run`]; [`ErrorKind::OutOfRange`] for a window without two samples.
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
    let pairs: Vec<(OpensWhen, StopModel)> = options
        .polarity
        .signs()
        .iter()
        .flat_map(|sign| options.model.stops().iter().map(|stop| (*sign, *stop)))
        .collect();
    let judged = bench.judge_all(
        &pairs,
        window,
        if options.evidence {
            Purpose::Drawing
        } else {
            Purpose::Deciding
        },
    )?;
    let threshold = design.criterion.threshold_rad;
    let of_rule_3 = combine(options.polarity, &pairs, &judged, threshold);
    let counted = |finding: &&Finding| counts(finding, options.window_s);
    let first_bad = findings
        .iter()
        .filter(|finding| finding.severity == Severity::Blocking)
        .filter(counted)
        .map(|finding| finding.at_s.unwrap_or(f64::NEG_INFINITY))
        .min_by(f64::total_cmp);
    let answer = match first_bad {
        None => of_rule_3,
        Some(bad_s) => match samples_before(signal, bad_s, window) {
            Some(good) => {
                let before = bench.judge_all(&pairs, Some(good), Purpose::Deciding)?;
                match combine(options.polarity, &pairs, &before, threshold) {
                    Answer::Fail => Answer::Fail,
                    _ => Answer::Unusable,
                }
            }
            None => Answer::Unusable,
        },
    };

    let nominal_index = index_of_largest(&judged);
    let (sign, stop) = pairs[nominal_index];
    let budget = bench.budget(conditioned, window, &pairs, &judged, nominal_index)?;
    let mut own_findings = replay_findings(design, options, signal.rate.interval(), &judged);
    let outside = bench.crossing_outside(&pairs, &judged, window)?;
    own_findings.extend(outside.map(|at| crossing_outside_window(at, design)));
    own_findings.extend(late_faults(findings, options.window_s));
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
    let evidence = options.evidence.then(|| Evidence {
        raw: conditioned.raw.clone(),
        used: conditioned.used.clone(),
        traces: traces(&pairs, &judged, (sign, stop)),
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
        budget,
        findings: own_findings,
        evidence,
    })
}

/// What a run is for, which says what it need not carry along.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Purpose {
    /// Decides, and is drawn.
    Drawing,
    /// Decides.
    Deciding,
    /// Is compared with one that decides: its own error does not matter.
    Comparison,
}

/// What every run of one assessment shares.
struct Bench<'a> {
    design: &'a Design,
    options: &'a AssessOptions,
    signal: &'a Signal,
    /// The band-limited fourfold of the samples.
    fine: &'a Signal,
}

/// Samples of a recording from which further threads gain more than their start costs.
const SHARED_SAMPLES: usize = 20_000;

impl Bench<'_> {
    /// Threads that the runs are shared among: one for a short recording.
    fn threads(&self) -> usize {
        if self.signal.samples.len() < SHARED_SAMPLES {
            1
        } else {
            self.options.threads
        }
    }

    /// The initial state asked for, what is left open being that of rest on the stop.
    fn initial(&self, stop: StopModel) -> Option<(f64, f64)> {
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

    fn run(
        &self,
        signal: &Signal,
        pair: (OpensWhen, StopModel),
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
    fn judge_all(
        &self,
        pairs: &[(OpensWhen, StopModel)],
        window: Option<(usize, usize)>,
        purpose: Purpose,
    ) -> Result<Vec<Judged>, Error> {
        let fine_window = window.map(|(first, last)| (4 * first, 4 * last));
        let tasks: Vec<(usize, bool)> = (0..pairs.len())
            .flat_map(|pair| [(pair, true), (pair, false)])
            .collect();
        let outcomes = in_parallel(self.threads(), &tasks, |&(pair, fine)| {
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
            });
        }
        Ok(judged)
    }

    /// When the lever first crosses the threshold outside the judged window, if it does so on
    /// a stop and polarity that do not cross inside.
    fn crossing_outside(
        &self,
        pairs: &[(OpensWhen, StopModel)],
        judged: &[Judged],
        window: Option<(usize, usize)>,
    ) -> Result<Option<f64>, Error> {
        let tasks: Vec<(OpensWhen, StopModel)> = pairs
            .iter()
            .zip(judged)
            .filter(|(_, judged)| window.is_some() && judged.run().first_crossing_s.is_none())
            .map(|(pair, _)| *pair)
            .collect();
        let mut first: Option<f64> = None;
        for outcome in in_parallel(self.threads(), &tasks, |pair| {
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
        pairs: &[(OpensWhen, StopModel)],
        judged: &[Judged],
        nominal: usize,
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
        let mut reruns: Vec<(Part, Signal, (OpensWhen, StopModel))> = Vec::new();
        if conditioned.filter.is_some() {
            reruns.push((
                Part::Filter,
                conditioning::without_filter(conditioned)?,
                (sign, stop),
            ));
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
        let outcomes = in_parallel(self.threads(), &reruns, |(_, signal, pair)| {
            self.run(signal, *pair, window, Purpose::Comparison)
        });
        let mut budget = ErrorBudget {
            numerical: Some(judged[nominal].run().numerical_error_rad),
            interpolation: Some(judged[nominal].interpolation_error_rad),
            model: model_peak.map(|other| (other - peak).abs()),
            filter: conditioned.filter.is_none().then_some(0.0),
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
fn in_parallel<T: Sync, R: Send>(
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

/// Joins what the pairs say by parts 3 and 4 of the rule.
fn combine(
    polarity: Polarity,
    pairs: &[(OpensWhen, StopModel)],
    judged: &[Judged],
    threshold: f64,
) -> Answer {
    let per_sign: Vec<Answer> = polarity
        .signs()
        .iter()
        .map(|sign| {
            let answers: Vec<Answer> = pairs
                .iter()
                .zip(judged)
                .filter(|((s, _), _)| s == sign)
                .map(|(_, judged)| judged.answer(threshold))
                .collect();
            unanimous(&answers)
        })
        .collect();
    match polarity {
        Polarity::Both => worse(&per_sign),
        Polarity::Declared(_) | Polarity::Undeclared => unanimous(&per_sign),
    }
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
pub(super) fn counts(finding: &Finding, window_s: Option<(f64, f64)>) -> bool {
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
pub(super) fn window_samples(
    signal: &Signal,
    (from, to): (f64, f64),
) -> Result<(usize, usize), Error> {
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

fn traces(
    pairs: &[(OpensWhen, StopModel)],
    judged: &[Judged],
    nominal: (OpensWhen, StopModel),
) -> Vec<Trace> {
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
