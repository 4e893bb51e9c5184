//! The search for the margin of one quantity: first where the nominal runs change their answer,
//! then, from there, where the verdict by the whole rule does.

use super::change::{VerdictChange, VerdictSearch};
use super::quantity::{SearchRange, applied};
use super::runs::{LeverTrial, NominalRuns};
use super::search::{self, Crossing, Edge, Probe, SearchResult};
use super::{Basis, Margin, MarginOptions, NominalAnswer, POINTS_MAX, POINTS_MIN, Quantity};
use crate::conditioning::Conditioned;
use crate::error::{Error, ErrorKind};
use crate::model::Design;
use crate::parallel::Control;
use crate::recording::Finding;
use crate::verdict::assess;
use crate::verdict::early::MemberCache;
use crate::verdict::faults::Faults;
use crate::verdict::meter::Meter;
use crate::verdict::usable_span::window_samples;
use std::cell::{Cell, RefCell};

/// Samples times values that a search begins with, at most, unless [`POINTS_MIN`] needs more.
const SAMPLES_TIMES_POINTS: usize = 1_600_000;

/// Samples times changes of the answer that are narrowed down, at most, unless there is but one.
const SAMPLES_TIMES_NARROWED: usize = 12_000;

/// Everything that the searches for the margins of one verdict share.
pub(super) struct MarginSearch<'a> {
    pub(super) runs: NominalRuns<'a>,
    conditioned: &'a Conditioned,
    findings: &'a [Finding],
    design: &'a Design,
    options: &'a MarginOptions,
    /// The recording carries a blocking finding.
    pub(super) spoiled: bool,
    pub(super) basis: Basis,
    /// The torque with which the strongest opening sample lifts the lever [N m].
    lift_off_nm: f64,
    /// The answer of the nominal runs at present.
    pub(super) state: NominalAnswer,
    /// Whether the verdict passes at present, once that was asked: it is the same of every
    /// quantity.
    passes: Cell<Option<bool>>,
}

impl<'a> MarginSearch<'a> {
    pub(super) fn new(
        conditioned: &'a Conditioned,
        findings: &'a [Finding],
        design: &'a Design,
        options: &'a MarginOptions,
        control: &'a Control<'a>,
        work: &'a Meter,
    ) -> Result<Self, Error> {
        let policy = &options.policy;
        let signal = &conditioned.used;
        let runs = NominalRuns {
            signal,
            policy,
            window: window_samples(signal, policy.window_s)?,
            control,
            enough_rad: design.criterion.threshold_rad + 2.0 * search::WHIRL_RAD,
            work,
        };
        let faults = Faults::of(conditioned, conditioned.filter, findings, policy.window_s);
        let spoiled = faults.first_bad.is_some();
        let signs = policy.polarity.signs().iter();
        let strongest = signs
            .flat_map(|sign| signal.samples.iter().map(|a| -sign.sign() * a))
            .fold(0.0, f64::max);
        Ok(Self {
            state: runs.exact(&LeverTrial::new(design, 1.0))?.state(),
            runs,
            conditioned,
            findings,
            design,
            options,
            spoiled,
            // A spoiled recording never passes, whatever the design.
            basis: if spoiled {
                Basis::NominalRun
            } else {
                options.basis
            },
            lift_off_nm: design.lever.unbalance_kg_m() * strongest,
            passes: Cell::new(None),
        })
    }

    pub(super) fn range(&self, quantity: Quantity) -> SearchRange {
        let radius_m = self.options.counterweight_radius_m;
        SearchRange::of(quantity, self.design, radius_m, self.lift_off_nm)
    }

    fn applied(&self, quantity: Quantity, value: f64) -> (Design, f64) {
        let radius_m = self.options.counterweight_radius_m;
        applied(quantity, self.design, radius_m, value)
    }

    /// Finds every change of the nominal runs' answer over a range.
    pub(super) fn changes(
        &self,
        quantity: Quantity,
        range: &SearchRange,
    ) -> Result<SearchResult, Error> {
        let samples = self.runs.signal.samples.len().max(1);
        let points = self.options.points;
        let points = points
            .unwrap_or_else(|| (SAMPLES_TIMES_POINTS / samples).clamp(POINTS_MIN, POINTS_MAX));
        let trial = |value: f64| {
            let (design, scale) = self.applied(quantity, value);
            LeverTrial::new(&design, scale)
        };
        search::changes(
            &range.grid(points),
            &Probe {
                scan: &|values| {
                    let trials: Vec<LeverTrial> =
                        values.iter().map(|value| trial(*value)).collect();
                    self.runs.scan(&trials)
                },
                exact: &|value| self.runs.exact(&trial(value)),
                width: &|value| range.width(value),
                near_rad: 0.01 * self.design.criterion.threshold_rad,
                distance: &|value| range.distance(value),
                narrowed: (SAMPLES_TIMES_NARROWED / samples).clamp(1, POINTS_MIN),
            },
        )
    }

    /// Returns whether the verdict by the whole rule is a pass at a value; `cache` is of values of
    /// the same quantity, and with `trust_cache` a pass is not certain.
    pub(super) fn verdict_passes(
        &self,
        quantity: Quantity,
        value: f64,
        cache: &mut MemberCache,
        trust_cache: bool,
    ) -> Result<bool, Error> {
        let (design, scale) = self.applied(quantity, value);
        let mut scaled = self.conditioned.clone();
        if quantity == Quantity::Scale {
            for samples in [&mut scaled.raw.samples, &mut scaled.used.samples] {
                samples.iter_mut().for_each(|a| *a *= scale);
            }
            scaled.bias_m_s2 *= scale;
        }
        let passes = assess::passes_cached(
            &scaled,
            self.findings,
            &design,
            &self.options.policy,
            (cache, trust_cache),
            self.runs.control,
            self.runs.work,
        );
        match passes {
            Err(error) if *error.kind() == ErrorKind::Stopped => Err(error),
            // What cannot be judged is no pass.
            passes => Ok(passes.unwrap_or(false)),
        }
    }

    /// Finds the margin of a quantity, of which the nominal runs `found` their changes.
    pub(super) fn answer(
        &self,
        quantity: Quantity,
        range: &SearchRange,
        found: &SearchResult,
    ) -> Result<Margin, Error> {
        let changes: Vec<&Crossing> = found
            .crossings
            .iter()
            .filter(|crossing| crossing.edge == Edge::Pass)
            .collect();
        let distance = |crossing: &Crossing| range.distance(crossing.better_end());
        let nominal = changes
            .iter()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
            .map(|crossing| (crossing.better_end(), (crossing.low.0, crossing.high.0)));
        let verdict = self
            .verdict_change(quantity, range, found, &changes)?
            .map(|change| (change.passes, change.bracket()));
        let passes_at_present = match (self.basis, self.passes.get()) {
            (Basis::Verdict, Some(passes)) => passes,
            _ => self.state == NominalAnswer::Pass,
        };
        let answer = match self.basis {
            Basis::NominalRun => nominal,
            Basis::Verdict => verdict,
        };
        let at = answer.map(|(at, _)| at);
        let reason = || self.reason(quantity, range, passes_at_present);
        Ok(Margin {
            quantity,
            title: quantity.title().into(),
            unit: quantity.unit().into(),
            present: range.present,
            passes_at_present,
            at,
            bracket: answer.map(|(_, bracket)| bracket),
            change_percent: at
                .filter(|_| range.present > 0.0)
                .map(|at| (at / range.present - 1.0) * 100.0),
            basis: self.basis,
            nominal_at: nominal.map(|(at, _)| at),
            nominal_bracket: nominal.map(|(_, bracket)| bracket),
            verdict_at: verdict.map(|(at, _)| at),
            verdict_bracket: verdict.map(|(_, bracket)| bracket),
            reason: at.is_none().then(reason),
            searched: (range.low, range.high),
            values: found.points.len(),
            changes: changes.len(),
            settled_at: settled(&changes, quantity.is_safer_above()),
            convention: quantity.convention().into(),
        })
    }

    /// Finds the nearest change of the verdict by the whole rule; none on a spoiled recording,
    /// which never passes.
    fn verdict_change(
        &self,
        quantity: Quantity,
        range: &SearchRange,
        found: &SearchResult,
        changes: &[&Crossing],
    ) -> Result<Option<VerdictChange>, Error> {
        if self.spoiled {
            return Ok(None);
        }
        let cache = RefCell::new(MemberCache::default());
        let verdict = VerdictSearch {
            passes: &|value, trust_cache| {
                self.verdict_passes(quantity, value, &mut cache.borrow_mut(), trust_cache)
            },
            range,
            points: &found.points,
            width: if self.basis == Basis::Verdict {
                1e-4
            } else {
                1e-6
            },
        };
        let passes = match self.passes.get() {
            Some(passes) => passes,
            None => (verdict.passes)(range.present, false)?,
        };
        self.passes.set(Some(passes));
        verdict.nearest(changes, self.state == NominalAnswer::Pass, passes)
    }

    /// Says why there is no value at which the answer changes.
    fn reason(&self, quantity: Quantity, range: &SearchRange, passes: bool) -> String {
        let number = |value: f64| crate::units::plain(value, 5);
        let (low, high) = (number(range.low), number(range.high));
        let unit = match quantity.unit() {
            "" => String::new(),
            unit => format!(" {unit}"),
        };
        let whose = match self.basis {
            Basis::NominalRun => "the nominal run",
            Basis::Verdict => "the verdict",
        };
        if self.runs.work.limit_reached().is_some() {
            return format!("the search from {low} to {high}{unit} ended at the limit `work`");
        }
        match self.basis {
            _ if passes => format!("{whose} is a pass everywhere from {low} to {high}{unit}"),
            Basis::NominalRun => {
                format!("{whose} is nowhere a pass from {low} to {high}{unit}")
            }
            Basis::Verdict => format!(
                "no value from {low} to {high}{unit} was found at which the verdict is a pass"
            ),
        }
    }
}

/// The last change on the way to the one end of the range that passes; where both do, to that
/// which is the safer.
fn settled(changes: &[&Crossing], safer_above: bool) -> Option<f64> {
    let (first, last) = (changes.first()?, changes.last()?);
    match (first.low.1.pass <= 0.0, last.high.1.pass <= 0.0) {
        (true, true) if safer_above => Some(last.high.0),
        (true, _) => Some(first.low.0),
        (false, true) => Some(last.high.0),
        (false, false) => None,
    }
}
