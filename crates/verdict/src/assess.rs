//! From a conditioned channel to an answer: which runs are made, and what they say together.

use super::bounds;
use super::decision::{Bound, ShareBounds, VariantRun};
use super::ensemble::{Count, Ensemble, Scatter, Varied};
use super::faults::Faults;
use super::filters::{self, FilterRow};
use super::mechanism::{self, Mechanism};
use super::meter::Meter;
use super::opening::{self, Opening};
use super::plane_findings::{LEFT_OUT, plane_findings};
use super::policy::{AssessDetail, AssessExtras, Policy, Variant};
use super::readings::{ReadingCache, Readings};
use super::replay_findings::{
    crossing_outside_window, replay_findings, window_in_milliseconds, work_limit_reached,
};
use super::runs::{RunDetail, RunSetup, index_of_largest};
use super::usable_span::{UsableSpan, window_samples};
use super::variant::{Crossings, VariantResult};
use super::what_if::{self, WhatIf};
use super::{
    Answer, ErrorBudget, Evidence, Reason, RunAnswer, SampledSeries, Trace, budget, looks,
    quantile_band, reasons,
};
use crate::conditioning::{Conditioned, spectrum};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::replay::Run;
use latchgate_kernel::units::OpensWhen;
use latchgate_recording::Finding;
use latchgate_recording::error::Error;
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
    /// The answer of each stop and polarity by itself.
    pub answers: Vec<RunAnswer>,
    /// The ensemble of the stop and polarity with the largest nominal peak.
    pub ensemble: Option<Ensemble>,
    /// When the lever opens.
    pub opens: Option<Opening>,
    /// The same by opening direction, where two were judged; none of a direction in which no lever opens.
    pub openings: BTreeMap<OpensWhen, Opening>,
    /// That of each stop and polarity that was not left out, where there are several.
    pub ensembles: Vec<Ensemble>,
    /// The nominal runs with one input moved by one standard deviation.
    pub what_if: Vec<WhatIf>,
    /// What differs from member to member of an ensemble; `None` where none was asked for or nothing does.
    pub varied: Option<Varied>,
    /// A pass waits for a person's word, so that the answer is undecided.
    pub word_missing: bool,
    /// The mechanism beside the lever, and what it did; `None` of the lever alone.
    pub mechanism: Option<Mechanism>,
    /// All of the judged window could be judged: no blocking finding took any of it.
    pub whole: bool,
    /// The answer of the nominal runs after each filter.
    pub filters: Vec<FilterRow>,
    /// The parts of the nominal peak's uncertainty.
    pub budget: ErrorBudget,
    /// Findings of the replay; those of reading and conditioning are not repeated.
    pub findings: Vec<Finding>,
    /// The curves of a report, if asked for.
    pub evidence: Option<Evidence>,
    /// Steps that all of it took.
    pub work: u64,
}

/// One assessment: the recording, the question, and what follows from both before any run.
struct Assessing<'a> {
    setup: RunSetup<'a>,
    conditioned: &'a Conditioned,
    /// Of reading and conditioning.
    findings: &'a [Finding],
    extras: AssessExtras,
    faults: Faults,
    span: UsableSpan,
    scatter: Option<Scatter>,
}

/// Steps that a recording may take of which no sample can be judged: enough for a drawing of a crash, and little
/// of an hour between two samples.
const WORK_OF_NOTHING: u64 = 8_000_000;

/// Replays `conditioned` and decides. `findings` are those of reading and conditioning.
///
/// # Errors
///
/// As [`latchgate_kernel::replay::run`]; [`OutOfRange`](latchgate_kernel::error::Error::OutOfRange) for a window without two
/// samples, or for tolerances that leave what is physical, as [`super::ensemble::check`];
/// [`Stopped`](latchgate_kernel::error::Error::Stopped).
pub fn assess(
    conditioned: &Conditioned,
    findings: &[Finding],
    design: &Design,
    policy: &Policy,
    extras: AssessExtras,
    control: &Control<'_>,
) -> Result<Assessment, Error> {
    let cache = ReadingCache::default();
    assess_again(
        conditioned,
        findings,
        design,
        policy,
        (extras, &cache),
        control,
    )
}

/// As [`assess`], with other readings of the samples from `cache`, which is of this recording.
///
/// # Errors
///
/// As [`assess`].
pub fn assess_again(
    conditioned: &Conditioned,
    findings: &[Finding],
    design: &Design,
    policy: &Policy,
    (extras, cache): (AssessExtras, &ReadingCache),
    control: &Control<'_>,
) -> Result<Assessment, Error> {
    let signal = &conditioned.used;
    let window = window_samples(signal, policy.window_s)?;
    let faults = Faults::of(conditioned, conditioned.filter, findings, policy.window_s);
    let span = UsableSpan::of(&faults, signal, window);
    let work = Meter::new(match span {
        UsableSpan::Nothing => policy.work.min(WORK_OF_NOTHING),
        _ => policy.work,
    });
    let assessing = Assessing {
        setup: RunSetup {
            design,
            policy,
            follow_all: extras.follow_all,
            detail: extras.detail,
            control,
            signal,
            drawn_runs: (span == UsableSpan::Whole).then_some(extras.drawn_runs),
            readings: Readings::of(conditioned, cache, policy.between),
            window,
            work: &work,
        },
        conditioned,
        findings,
        extras,
        span,
        faults,
        scatter: scatter(conditioned, design, policy)?,
    };
    let mut results = assessing.follow()?;
    assessing.sample(&mut results)?;
    assessing.conclude(results)
}

/// The scatter of an ensemble, if the policy asks for one and anything varies.
fn scatter(
    conditioned: &Conditioned,
    design: &Design,
    policy: &Policy,
) -> Result<Option<Scatter>, Error> {
    let scattered = || {
        let error_m_s2 = conditioned.bias_standard_error_m_s2;
        let scatter = Scatter::new(design, error_m_s2, policy.seed)?.at(policy.model.stops());
        Ok::<_, Error>(of_sensors(scatter, conditioned, design))
    };
    let scatter = (policy.members > 0).then(scattered).transpose()?;
    // Members that are all alike are none.
    Ok(scatter.filter(|scatter| scatter.varied().is_some()))
}

/// Adds the scatter of a second in-plane sensor, if there is one.
fn of_sensors(scatter: Scatter, conditioned: &Conditioned, design: &Design) -> Scatter {
    match &conditioned.second {
        Some(second) => {
            scatter.with_second_sensor(design, second.conditioned.bias_standard_error_m_s2)
        }
        None => scatter,
    }
}

impl Assessing<'_> {
    /// Makes the nominal runs of every variant with their errors, and asks which ensembles are spared.
    fn follow(&self) -> Result<Vec<VariantResult>, Error> {
        let setup = &self.setup;
        let variants = setup.policy.variants();
        let detail = if self.extras.evidence {
            RunDetail::Trace
        } else {
            RunDetail::Errors
        };
        let mut runs = setup.full_runs(&variants, detail)?;
        for run in &mut runs {
            run.bound = self.bound(run.variant())?;
            run.share = run.bound.map(|_| self.share_of_none());
        }
        let mut before_fault = match self.span {
            UsableSpan::Until(_) => self
                .usable()
                .full_runs(&variants, RunDetail::Errors)?
                .into_iter(),
            UsableSpan::Whole | UsableSpan::Nothing => Vec::new().into_iter(),
        };
        let pairs = variants.into_iter().zip(runs);
        Ok(pairs
            .map(|(variant, run)| VariantResult {
                variant,
                run,
                before_fault: before_fault.next(),
                ensemble: None,
                crossings: Crossings::default(),
            })
            .collect())
    }

    /// Returns the bound that spares an ensemble, where one would be run over the whole window.
    fn bound(&self, variant: Variant) -> Result<Option<Bound>, Error> {
        match &self.scatter {
            Some(scatter)
                if !self.setup.follow_all
                    && scatter.has_end()
                    && self.span == UsableSpan::Whole =>
            {
                bounds::bound(&self.setup, scatter, variant)
            }
            _ => Ok(None),
        }
    }

    /// Bounds of the share of an ensemble of which no lever crosses.
    fn share_of_none(&self) -> ShareBounds {
        let none_crosses = Count {
            members: self.setup.policy.members,
            exceeded: 0,
            exceeded_in_coast: 0,
            failed_to_run: 0,
        };
        none_crosses.share(&self.setup.design.criterion)
    }

    /// The runs over the samples that count.
    fn usable(&self) -> RunSetup<'_> {
        match self.span {
            UsableSpan::Until(good) => RunSetup {
                window: Some(good),
                ..self.setup
            },
            UsableSpan::Whole | UsableSpan::Nothing => self.setup,
        }
    }

    /// Runs the ensembles over the samples that count.
    fn sample(&self, results: &mut [VariantResult]) -> Result<(), Error> {
        match &self.scatter {
            Some(scatter) if self.span != UsableSpan::Nothing => {
                let limited = self.span != UsableSpan::Whole;
                looks::run_ensembles(&self.usable(), scatter, results, limited)
            }
            _ => Ok(()),
        }
    }

    /// Joins the answers, works out what stands beside them, and puts it into words.
    fn conclude(&self, results: Vec<VariantResult>) -> Result<Assessment, Error> {
        let setup = &self.setup;
        let (design, policy) = (setup.design, setup.policy);
        let mut answer = self.answer(&results);
        let runs: Vec<&VariantRun> = results.iter().map(|result| &result.run).collect();
        let nominal_index = index_of_largest(runs.iter().map(|run| run.run()));
        let nominal = &results[nominal_index];
        let filtered = if self.extras.filter_table {
            filters::table(setup, self.conditioned, self.findings, &results)?
        } else {
            Vec::new()
        };
        let unfiltered_peak = filters::unfiltered_peak(&filtered, nominal.variant);
        let brief = self.is_brief();
        let budget = if brief {
            ErrorBudget::default()
        } else {
            budget::budget(setup, self.conditioned, &results, nominal, unfiltered_peak)?
        };
        let filters: Vec<FilterRow> = filtered.into_iter().map(|filtered| filtered.row).collect();
        // What comes of faulty samples says nothing.
        let telling = if answer == Answer::Unusable {
            &[]
        } else {
            &runs[..]
        };
        let mut findings = replay_findings(design, policy, setup.signal.rate.interval(), telling);
        let is_pass = answer == Answer::Pass;
        let plane = plane_findings(setup, self.conditioned, telling, is_pass)?;
        findings.extend(plane.findings);
        if is_pass && plane.forbids_pass.is_some() {
            answer = Answer::Undecided;
        }
        findings.extend(self.pressed_shut());
        findings.extend(filters::filter_decides(&filters, setup.threshold_rad()));
        let outside = setup.crossing_outside(telling)?;
        findings.extend(outside.map(crossing_outside_window));
        let window = policy.window_s.into_iter();
        findings
            .extend(window.filter_map(|span| window_in_milliseconds(span, setup.signal.end_s())));
        findings.extend(self.faults.findings());
        let mut what_if = if brief {
            Vec::new()
        } else {
            self.what_if(&results)?
        };
        let openings = match answer {
            // What comes of faulty samples is no event.
            Answer::Unusable => BTreeMap::new(),
            _ => opening::by_direction(
                &self.usable(),
                self.scatter.as_ref().filter(|_| !brief),
                &results,
            )?,
        };
        let opens = opening::earliest(openings.values());
        let evidence = self.evidence(&results, nominal)?;
        let judged = self.span != UsableSpan::Nothing;
        let work_limit = setup.work.limit_reached().filter(|_| judged);
        findings.extend(work_limit.map(work_limit_reached));
        let varied = self.scatter.as_ref().and_then(Scatter::varied);
        let mut case = reasons::Explained {
            answer,
            design,
            policy,
            results: &results,
            nominal,
            findings: self.findings,
            faults: &self.faults,
            outside,
            work_limit,
            budget: &budget,
            noise: self.conditioned.noise,
            what_if: &[],
            varied,
            opens: opens.as_ref(),
        };
        if brief && reasons::inputs_may_come_first(&case) {
            what_if = self.what_if(&results)?;
        }
        case.what_if = &what_if;
        let mut why = reasons::reasons(&case);
        let reason = |finding: &Finding| Reason {
            code: finding.code.clone(),
            text: finding.text.clone(),
        };
        let left_out = findings.iter().filter(|finding| finding.code == LEFT_OUT);
        match plane.forbids_pass.filter(|_| is_pass) {
            Some(forbids) => why.insert(0, reason(&forbids)),
            None if is_pass => why.extend(left_out.map(reason)),
            None => {}
        }
        let of_each = |run: &&VariantRun| run.stated(setup.threshold_rad());
        Ok(Assessment {
            answer,
            why,
            nominal: nominal.run.run().clone(),
            models: by_model(&runs),
            polarities: by_polarity(policy, &runs),
            answers: runs.iter().map(of_each).collect(),
            ensemble: nominal.ensemble.clone(),
            opens,
            openings: match policy.polarity.signs() {
                [_, _, ..] => openings,
                _ => BTreeMap::new(),
            },
            word_missing: false,
            varied,
            mechanism: Mechanism::of(design, &results),
            whole: self.span == UsableSpan::Whole,
            what_if,
            filters,
            budget,
            findings,
            evidence,
            work: setup.work.spent(),
            ensembles: several(results.into_iter().filter_map(|result| result.ensemble)),
        })
    }

    /// Tells whether what the decision does not take is left out. Not near the limit of work, which
    /// what is left out might have reached.
    fn is_brief(&self) -> bool {
        /// Times the work of the decision that all the rest takes at most.
        const REST: u64 = 64;
        let work = self.setup.work;
        self.extras.detail < AssessDetail::Whole && work.left() / REST > work.spent()
    }

    /// The whole rule: parts 1 and 2 over what parts 3 and 4 say of all samples and of the good
    /// ones.
    fn answer(&self, results: &[VariantResult]) -> Answer {
        let runs: Vec<&VariantRun> = results.iter().map(|result| &result.run).collect();
        let before = results
            .iter()
            .filter_map(|result| result.before_fault.as_ref());
        let of_good = self.setup.joined(&before.collect::<Vec<_>>());
        self.span.answer(self.setup.joined(&runs), of_good)
    }

    /// Returns the finding of a pulse of one sign that only presses the lever shut, in the one direction judged.
    fn pressed_shut(&self) -> Option<Finding> {
        let setup = &self.setup;
        let &[opens_when] = setup.policy.polarity.signs() else {
            return None;
        };
        let sign = opens_when.sign() * setup.design.lever.unbalance_sign();
        let presses = |a: &f64| sign * a >= 0.0;
        let pressed =
            self.conditioned.formula.is_some() && setup.signal.samples.iter().all(presses);
        pressed.then(|| {
            Finding::warning(
                "pulse-presses-shut",
                "The pulse only presses the lever shut: it never opens in the direction that was judged. Judge the other one, or both.",
            )
        })
    }

    /// Reruns with one input moved; none where a fault ends what can be judged.
    fn what_if(&self, results: &[VariantResult]) -> Result<Vec<WhatIf>, Error> {
        if self.span != UsableSpan::Whole {
            return Ok(Vec::new());
        }
        let setup = &self.setup;
        let spent: u64 = results.iter().map(|result| result.run.outcome.spent).sum();
        if !setup.work.allows(8 * spent) {
            return Ok(Vec::new());
        }
        // The bias belongs to the recording: nominal runs alone are asked about it as well.
        let of_bias = || {
            let error = self.conditioned.bias_standard_error_m_s2;
            let scatter = Scatter::of_bias(setup.design, error, setup.policy.seed);
            of_sensors(scatter, self.conditioned, setup.design).bias_alone()
        };
        let moved = self.scatter.clone().unwrap_or_else(of_bias);
        what_if::reruns(setup, self.conditioned, &moved, results)
    }

    /// Trajectories, spread and spectra for a report, if asked for.
    fn evidence(
        &self,
        results: &[VariantResult],
        nominal: &VariantResult,
    ) -> Result<Option<Evidence>, Error> {
        if !self.extras.evidence {
            return Ok(None);
        }
        let quantile_band = match &self.scatter {
            Some(scatter) if self.setup.work.allows(64 * nominal.run.outcome.spent) => {
                quantile_band::around(&self.setup, scatter, nominal.variant)?
            }
            _ => None,
        };
        let Conditioned {
            raw, used, second, ..
        } = self.conditioned;
        let traces = traces(results, nominal.variant);
        Ok(Some(Evidence {
            raw: raw.clone(),
            used: used.clone(),
            second: second
                .as_ref()
                .map(|second| second.conditioned.used.clone()),
            series: SampledSeries::of(raw, used, &traces),
            traces,
            quantile_band,
            catch_traces: mechanism::catch_traces(results),
            spectrum_raw: spectrum::amplitude_spectrum(raw),
            spectrum_used: spectrum::amplitude_spectrum(used),
            spectrogram: spectrum::spectrogram(used),
            sled206: None,
        }))
    }
}

/// Returns the run with the larger peak of each stop.
fn by_model(runs: &[&VariantRun]) -> BTreeMap<StopModel, Run> {
    let mut models: BTreeMap<StopModel, Run> = BTreeMap::new();
    for run in runs.iter().map(|run| run.run()) {
        let larger = models.get(&run.model);
        if larger.is_none_or(|larger| run.peak_angle_rad > larger.peak_angle_rad) {
            models.insert(run.model, run.clone());
        }
    }
    models
}

/// Returns every run by sign and stop, where two signs were judged.
fn by_polarity(
    policy: &Policy,
    runs: &[&VariantRun],
) -> BTreeMap<OpensWhen, BTreeMap<StopModel, Run>> {
    let mut polarities: BTreeMap<OpensWhen, BTreeMap<StopModel, Run>> = BTreeMap::new();
    if policy.polarity.signs().len() > 1 {
        for run in runs.iter().map(|run| run.run()) {
            let of_sign = polarities.entry(run.opens_when).or_default();
            of_sign.insert(run.model, run.clone());
        }
    }
    polarities
}

/// Returns the ensembles if there are several: a single one is shown by itself.
fn several(ensembles: impl Iterator<Item = Ensemble>) -> Vec<Ensemble> {
    let ensembles: Vec<Ensemble> = ensembles.collect();
    if ensembles.len() > 1 {
        ensembles
    } else {
        Vec::new()
    }
}

/// Returns the trajectories, that of the nominal run first.
fn traces(results: &[VariantResult], nominal: Variant) -> Vec<Trace> {
    let mut traces: Vec<(Variant, Trace)> = results
        .iter()
        .map(|result| {
            let Variant { opens_when, model } = result.variant;
            let points = result.run.outcome.trace.clone();
            let trace = Trace {
                model,
                opens_when,
                points,
            };
            (result.variant, trace)
        })
        .collect();
    let of_nominal = traces.iter().position(|(variant, _)| *variant == nominal);
    if let Some(place) = of_nominal {
        traces[..=place].rotate_right(1);
    }
    traces.into_iter().map(|(_, trace)| trace).collect()
}
