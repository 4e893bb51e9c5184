//! The search for the margin of one quantity: first where the nominal runs change their answer,
//! then, from there, where the verdict by the whole rule does.

use super::advice::{self, Advice, AdviceProbe, MEMBERS_ASKED, ROOM};
use super::change::{VerdictChange, VerdictSearch};
use super::quantity::{SearchRange, applied};
use super::runs::{LeverTrial, NominalRuns};
use super::search::{self, Crossing, Edge, Excess, Probe, SearchResult};
use super::{Basis, Margin, MarginOptions, NominalAnswer, POINTS_MAX, POINTS_MIN, Quantity};
use crate::assess::{NominalPass, PassQuestion, PassingRuns};
use crate::conditioning::{self, Conditioned};
use crate::early::MemberCache;
use crate::faults::Faults;
use crate::interpolation::{Course, apart_s};
use crate::meter::Meter;
use crate::readings::ReadingCache;
use crate::usable_span::window_samples;
use crate::wording::angle;
use crate::{Answer, AssessDetail, AssessExtras, Policy, Variant};
use latchgate_kernel::model::Design;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::units::{STANDARD_GRAVITY, plain};
use latchgate_recording::Finding;
use latchgate_recording::error::Error;
use std::borrow::Cow;
use std::cell::RefCell;
use std::sync::{Arc, Mutex, PoisonError};

/// Samples times values that a search begins with, at most, unless [`POINTS_MIN`] needs more.
const SAMPLES_TIMES_POINTS: usize = 800_000;

/// Samples times values that a search looks at, at most, unless twice its first ones are more.
const SAMPLES_TIMES_VALUES: usize = 4_000_000;

/// Members that a search for a change of the verdict asks: a pass at their looks is one of any
/// larger ensemble. What it finds is made certain by all of them.
const MEMBERS_SEARCHED: u32 = 512;

/// Samples beyond which a recording is a long one.
const LONG_SAMPLES: usize = 10_000;

/// Samples times changes of the answer that are narrowed down, at most, unless there is but one.
const SAMPLES_TIMES_NARROWED: usize = 12_000;

/// What was found of the nominal levers, by the part of the limit and the scale of the recording, as
/// bits, in their order.
type KnownAt<T> = Vec<((u64, u64), T)>;

/// The runs of each set of samples, which pass alone; or the variant that does not, if it is known.
type PassingAt = Arc<Result<Vec<PassingRuns>, Option<Variant>>>;

/// Returns what a lock guards; whoever panicked has left it whole, since it is written at once.
fn locked<T>(guarded: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    guarded.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Everything that the searches for the margins of one verdict share.
pub(super) struct MarginSearch<'a> {
    pub(super) runs: NominalRuns<'a>,
    conditioned: &'a Conditioned,
    findings: &'a [Finding],
    design: &'a Design,
    options: &'a MarginOptions,
    /// The recording carries a blocking finding.
    pub(super) spoiled: bool,
    /// Other readings of its samples.
    readings: ReadingCache,
    /// The recording with its bias left in, where a pass needs both.
    biased: Option<(Conditioned, ReadingCache)>,
    pub(super) basis: Basis,
    /// The torque with which the strongest opening sample lifts the lever [N m].
    lift_off_nm: f64,
    /// The answer of the nominal runs at present.
    pub(super) state: NominalAnswer,
    nominal_at: Mutex<KnownAt<NominalPass>>,
    passing_at: Mutex<KnownAt<PassingAt>>,
    courses_at: Mutex<KnownAt<Vec<(f64, Course)>>>,
    /// Whether the verdict passes at present, once that was asked: it is the same of every
    /// quantity.
    passes: Mutex<Option<bool>>,
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
            enough_rad: search::followed_to_rad(design.criterion.threshold_rad),
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
            readings: ReadingCache::default(),
            biased: conditioning::without_doubtful_bias(conditioned)?
                .map(|biased| (biased, ReadingCache::default())),
            // A spoiled recording never passes, whatever the design.
            basis: if spoiled {
                Basis::NominalRun
            } else {
                options.basis
            },
            lift_off_nm: design.lever.unbalance_kg_m() * strongest,
            nominal_at: Mutex::default(),
            passing_at: Mutex::default(),
            courses_at: Mutex::default(),
            passes: Mutex::default(),
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

    fn trial(&self, quantity: Quantity, value: f64) -> LeverTrial {
        let (design, scale) = self.applied(quantity, value);
        LeverTrial::new(&design, scale)
    }

    /// Returns the excess of the nominal levers at values, side by side.
    fn scan(&self, quantity: Quantity, values: &[f64]) -> Result<Vec<Excess>, Error> {
        let trial = |value: &f64| self.trial(quantity, *value);
        let trials: Vec<LeverTrial> = values.iter().map(trial).collect();
        self.runs.scan(&trials)
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
        let grid = range.grid(points);
        search::changes(
            &grid,
            &Probe {
                scan: &|values| self.scan(quantity, values),
                exact: &|value| self.runs.exact(&self.trial(quantity, value)),
                width: &|value| range.width(value),
                near_rad: 0.01 * self.design.criterion.threshold_rad,
                distance: &|value| range.distance(value),
                values_max: match self.options.points {
                    Some(_) => 5 * grid.len(),
                    None => (SAMPLES_TIMES_VALUES / samples).clamp(2 * grid.len(), 5 * grid.len()),
                },
                narrowed: (SAMPLES_TIMES_NARROWED / samples).clamp(1, POINTS_MIN),
            },
        )
    }

    pub(super) fn threshold_rad(&self) -> f64 {
        self.design.criterion.threshold_rad
    }

    /// Members of the ensemble; none where nominal runs alone are judged.
    pub(super) fn members(&self) -> u32 {
        self.options.policy.members
    }

    /// Returns whether the verdict by the whole rule is a pass at a value, with `room`, a part of
    /// the limit, for the limit; of the `members` that the policy asks for no more are asked.
    /// `cache` is of values of the same quantity, and if it is trusted a pass is not certain.
    pub(super) fn rule_passes(
        &self,
        quantity: Quantity,
        value: f64,
        (room, members): (f64, Option<u32>),
        (cache, trust_cache): (&mut MemberCache, bool),
    ) -> Result<bool, Error> {
        let alone = self.passing_at(quantity, value, room, cache)?;
        let runs = match &*alone {
            Ok(runs) => runs,
            Err(variant) => {
                if let Some(variant) = variant {
                    cache.stands_in_the_way(*variant);
                }
                return Ok(false);
            }
        };
        let (mut runs, mut own) = (runs.iter(), Some(cache));
        let members = members.unwrap_or(u32::MAX);
        self.each(
            (quantity, value),
            (room, members),
            self.runs.work,
            &mut |question| {
                let Some(runs) = runs.next() else {
                    return Ok(false);
                };
                // What is known of members holds for the samples that are asked about first.
                match own.take() {
                    Some(cache) => question.members_pass(runs, (cache, trust_cache)),
                    None => question.members_pass(runs, (&mut MemberCache::default(), false)),
                }
            },
        )
    }

    /// Returns the nominal runs at a value if all of them pass alone.
    fn passing_at(
        &self,
        quantity: Quantity,
        value: f64,
        room: f64,
        cache: &MemberCache,
    ) -> Result<PassingAt, Error> {
        self.known(
            &self.passing_at,
            (quantity, value),
            room,
            &|quantity, value| {
                let (mut runs, mut in_the_way) = (Vec::new(), None);
                let pass = self.each(
                    (quantity, value),
                    (room, u32::MAX),
                    self.runs.work,
                    &mut |question| {
                        let found = question.passing_runs(cache)?;
                        let pass = found.is_ok();
                        match found {
                            Ok(found) => runs.push(found),
                            Err(variant) => in_the_way = variant,
                        }
                        Ok(pass)
                    },
                )?;
                Ok(Arc::new(if pass { Ok(runs) } else { Err(in_the_way) }))
            },
        )
    }

    /// Returns what the rule says of the nominal lever at a value, with `room`, a part of the limit,
    /// for the limit.
    fn nominal_pass(
        &self,
        quantity: Quantity,
        value: f64,
        room: f64,
        work: &Meter,
    ) -> Result<NominalPass, Error> {
        self.known(
            &self.nominal_at,
            (quantity, value),
            room,
            &|quantity, value| {
                let (mut in_doubt, mut sensitive) = (false, false);
                let passes = self.each((quantity, value), (room, 0), work, &mut |question| {
                    let found = question.nominal()?;
                    in_doubt |= found.in_doubt;
                    sensitive |= found.sensitive;
                    Ok(found.passes)
                })?;
                Ok(NominalPass {
                    passes,
                    in_doubt,
                    sensitive,
                })
            },
        )
    }

    /// As [`Self::nominal_pass`] of several values side by side. Each may take its part of the work that is
    /// left, so that the answers do not depend on the threads.
    fn nominal_passes(
        &self,
        quantity: Quantity,
        values: &[f64],
        room: f64,
    ) -> Result<Vec<NominalPass>, Error> {
        let work = self.runs.work;
        if let [value] = values {
            return Ok(vec![self.nominal_pass(quantity, *value, room, work)?]);
        }
        let part = work.left() / values.len().max(1) as u64;
        let asked: Vec<(f64, Meter)> = values.iter().map(|at| (*at, Meter::new(part))).collect();
        let found = self.runs.control.unmeasured(|control| {
            control.try_map(&asked, |(value, work)| {
                self.nominal_pass(quantity, *value, room, work)
            })
        });
        for (_, own) in &asked {
            work.add(own.spent());
            if own.limit_reached().is_some() {
                work.cut();
            }
        }
        found
    }

    /// Returns the highest angle [rad] of each nominal lever at a value, and how it came to its peak.
    fn courses(&self, quantity: Quantity, value: f64) -> Result<Vec<(f64, Course)>, Error> {
        self.known(
            &self.courses_at,
            (quantity, value),
            1.0,
            &|quantity, value| {
                let mut found = Vec::new();
                self.each(
                    (quantity, value),
                    (1.0, 0),
                    self.runs.work,
                    &mut |question| {
                        found.extend(question.courses()?);
                        Ok(true)
                    },
                )?;
                Ok(found)
            },
        )
    }

    /// Returns what `known` holds at a value, or asks. The nominal levers do the same at a scale of the
    /// recording and at that unbalance: the model holds both as a product. Asked is the unbalance, of
    /// which samples and readings are there already.
    fn known<T: Clone>(
        &self,
        known: &Mutex<KnownAt<T>>,
        (quantity, value): (Quantity, f64),
        room: f64,
        ask: &dyn Fn(Quantity, f64) -> Result<T, Error>,
    ) -> Result<T, Error> {
        /// Units in the last place by which two ways to one scale may differ.
        const ROUNDED: u64 = 4;
        let present = self.design.lever.unbalance_kg_m();
        let (scale, unbalance) = match quantity {
            Quantity::Scale if present > 0.0 => (value, value * present),
            Quantity::Unbalance if present > 0.0 => (value / present, value),
            _ => return ask(quantity, value),
        };
        let (room, bits) = (room.to_bits(), scale.to_bits());
        let first_from = |known: &KnownAt<T>, from| known.partition_point(|(at, _)| *at < from);
        {
            let known = locked(known);
            let nearest = known.get(first_from(&known, (room, bits.saturating_sub(ROUNDED))));
            let last = (room, bits.saturating_add(ROUNDED));
            if let Some((_, found)) = nearest.filter(|(at, _)| *at <= last) {
                return Ok(found.clone());
            }
        }
        let found = ask(Quantity::Unbalance, unbalance)?;
        let mut known = locked(known);
        let place = first_from(&known, (room, bits));
        known.insert(place, ((room, bits), found.clone()));
        Ok(found)
    }

    /// Asks a question about a value, on the samples and, where their bias is doubtful, on those
    /// with the bias left in; returns whether the answer is yes each time. What cannot be judged is
    /// no pass.
    fn each(
        &self,
        (quantity, value): (Quantity, f64),
        (room, members): (f64, u32),
        work: &Meter,
        ask: &mut dyn FnMut(&PassQuestion<'_>) -> Result<bool, Error>,
    ) -> Result<bool, Error> {
        let (mut design, scale) = self.applied(quantity, value);
        design.criterion.threshold_rad *= room;
        let policy = Policy {
            members: self.options.policy.members.min(members),
            ..self.options.policy.clone()
        };
        let biased = self.biased.as_ref().map(|(of, readings)| (of, readings));
        let of_each = std::iter::once((self.conditioned, &self.readings)).chain(biased);
        for (conditioned, readings) in of_each {
            // Readings are of one set of samples, and a scaled recording has others.
            let fresh = ReadingCache::default();
            let (conditioned, readings) = if quantity == Quantity::Scale {
                (Cow::Owned(scaled(conditioned, scale)), &fresh)
            } else {
                (Cow::Borrowed(conditioned), readings)
            };
            let passes = ask(&PassQuestion {
                conditioned: &conditioned,
                readings,
                findings: self.findings,
                design: &design,
                policy: &policy,
                control: self.runs.control,
                work,
            });
            match passes {
                Err(error) if error.is_stopped() => return Err(error),
                Ok(true) => {}
                _ => return Ok(false),
            }
        }
        Ok(true)
    }

    /// Says what stands in the way of a pass at a value.
    pub(super) fn hindrance(&self, quantity: Quantity, value: f64) -> Result<String, Error> {
        if self.spoiled {
            return Ok("a blocking finding spoils the recording".into());
        }
        let (design, scale) = self.applied(quantity, value);
        let conditioned = scaled(self.conditioned, scale);
        let policy = Policy {
            members: self.members().min(MEMBERS_ASKED),
            ..self.options.policy.clone()
        };
        let extras = AssessExtras {
            detail: AssessDetail::Decision,
            ..AssessExtras::default()
        };
        let control = self.runs.control;
        let (findings, at) = (self.findings, plain(value, 4));
        let unit = quantity.unit();
        let at = format!("{at}{}{unit}", if unit.is_empty() { "" } else { " " });
        let assessed =
            match crate::assess(&conditioned, findings, &design, &policy, extras, control) {
                Err(error) if error.is_stopped() => return Err(error),
                Err(error) => return Ok(format!("at {at} nothing can be judged: {error}")),
                Ok(assessed) => assessed,
            };
        if assessed.answer == Answer::Pass && self.biased.is_none() {
            return Ok(format!(
                "at {at} the verdict is a pass, but without a tenth of the limit to spare, or beside values that may be none"
            ));
        }
        let found = &assessed.findings;
        if found.iter().any(|of| of.code == "method-broke-down") {
            return Ok(format!("even at {at} a lever cannot be followed"));
        }
        let (run, threshold) = (&assessed.nominal, self.threshold_rad());
        if run.peak_angle_rad > threshold {
            let peak = angle(run.peak_angle_rad, 3);
            return Ok(format!("even at {at} the nominal lever reaches {peak}"));
        }
        let crossing = assessed.ensemble.filter(|of| of.exceeded > 0);
        let Some(ensemble) = crossing else {
            let error = assessed.answers.iter().filter_map(|of| of.uncertainty_rad);
            let error = plain(error.fold(0.0, f64::max), 2);
            return Ok(format!(
                "even at {at} the error of the nominal peak, {error} rad, or the doubt about its bias leaves no pass"
            ));
        };
        let bias_g =
            (conditioned.bias_standard_error_m_s2 / STANDARD_GRAVITY).max(design.input.bias_g);
        let holds_g = design.lever.lift_off_acceleration_m_s2() / STANDARD_GRAVITY;
        // Among hundreds of members some have a bias of three standard deviations.
        if 3.0 * bias_g > holds_g {
            return Ok(format!(
                "the bias alone opens this lever: it is uncertain by {} g (one standard deviation), and the preload holds {} g",
                plain(bias_g, 2),
                plain(holds_g, 3)
            ));
        }
        Ok(format!(
            "even at {at} {} of {} scattered levers cross",
            ensemble.exceeded, ensemble.members
        ))
    }

    /// Finds from where on every value of a quantity passes, of which the nominal runs `found` their
    /// changes.
    pub(super) fn advice(
        &self,
        quantity: Quantity,
        range: &SearchRange,
        found: &SearchResult,
    ) -> Result<Advice, Error> {
        let probe = AdviceProbe {
            nominal: &|values| self.nominal_passes(quantity, values, ROOM),
            scan: &|values| self.scan(quantity, values),
            courses: &|value| self.courses(quantity, value),
            apart_s: apart_s(self.runs.signal),
            rule: &|value, asked, cache| self.rule_passes(quantity, value, asked, (cache, false)),
            hindrance: &|value| self.hindrance(quantity, value),
            threshold_rad: self.threshold_rad(),
            with_members: self.members() > 0,
            spoiled: self.spoiled,
            long: self.runs.signal.samples.len() > LONG_SAMPLES,
        };
        advice::advise(&probe, quantity, range, found)
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
        let passes_at_present = match (self.basis, *locked(&self.passes)) {
            (Basis::Verdict, Some(passes)) => passes,
            _ => self.state == NominalAnswer::Pass,
        };
        let answer = match self.basis {
            Basis::NominalRun => nominal,
            Basis::Verdict => verdict,
        };
        let at = answer.map(|(at, _)| at);
        let advice = self.advice(quantity, range, found)?;
        let reason = || self.reason(quantity, range, passes_at_present, &advice);
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
            isolated: match at {
                Some(at) if !passes_at_present => self.is_isolated(quantity, range, at, &advice)?,
                _ => false,
            },
            advice,
        })
    }

    /// Tells whether values between a pass and the advice are not found to pass: of the nominal levers
    /// at several, of an ensemble near the pass and half-way.
    fn is_isolated(
        &self,
        quantity: Quantity,
        range: &SearchRange,
        at: f64,
        advice: &Advice,
    ) -> Result<bool, Error> {
        const BETWEEN: u32 = 11;
        /// Parts of the way at which the ensemble is asked.
        const WITH_MEMBERS: [f64; 3] = [1.0 / 12.0, 0.25, 0.5];
        let Some(from) = advice.safe_from else {
            return Ok(true);
        };
        let (near, far) = (range.place(at), range.place(from));
        if ((at >= from) == quantity.is_safer_above()) || self.spoiled {
            return Ok(false);
        }
        let between = |part: f64| range.value(near + (far - near) * part);
        // A nominal lever costs one run, an ensemble hundreds: the one is asked first and more often.
        for step in 1..=BETWEEN {
            let value = between(f64::from(step) / f64::from(BETWEEN + 1));
            if !self
                .nominal_pass(quantity, value, 1.0, self.runs.work)?
                .passes
            {
                return Ok(true);
            }
        }
        let asked = (1.0, Some(MEMBERS_ASKED));
        let mut cache = MemberCache::default();
        for part in WITH_MEMBERS {
            if !self.rule_passes(quantity, between(part), asked, (&mut cache, false))? {
                return Ok(true);
            }
        }
        Ok(false)
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
                let cache = (&mut *cache.borrow_mut(), trust_cache);
                self.rule_passes(quantity, value, (1.0, Some(MEMBERS_SEARCHED)), cache)
            },
            range,
            points: &found.points,
            width: if self.basis == Basis::Verdict {
                1e-3
            } else {
                1e-6
            },
        };
        let passes = match *locked(&self.passes) {
            Some(passes) => passes,
            None => {
                let cache = (&mut *cache.borrow_mut(), false);
                self.rule_passes(quantity, range.present, (1.0, None), cache)?
            }
        };
        *locked(&self.passes) = Some(passes);
        let found = verdict.nearest(changes, self.state == NominalAnswer::Pass, passes)?;
        match found {
            Some(change) => self.certain(quantity, range, change, &mut cache.borrow_mut()),
            None => Ok(None),
        }
    }

    /// Makes a change certain by all members: where the value that was no pass by the first of them
    /// is one, the next is further away; none is left at an end of the range.
    fn certain(
        &self,
        quantity: Quantity,
        range: &SearchRange,
        found: VerdictChange,
        cache: &mut MemberCache,
    ) -> Result<Option<VerdictChange>, Error> {
        // At the edge of the nominal passes both are one value.
        let at_edge = found.passes.to_bits() == found.does_not.to_bits();
        if at_edge || self.members() <= MEMBERS_SEARCHED {
            return Ok(Some(found));
        }
        let (mut passes, mut does_not) = (found.passes, found.does_not);
        loop {
            let asked = (1.0, None);
            if !self.rule_passes(quantity, does_not, asked, (&mut *cache, false))? {
                return Ok(Some(VerdictChange { passes, does_not }));
            }
            let (from, to) = (range.place(passes), range.place(does_not));
            passes = does_not;
            let unit = if range.ratios {
                1.0
            } else {
                range.high - range.low
            };
            // The steps double, so that few questions reach the end of the range.
            let step = (2.0 * (to - from).abs()).max(1e-3 * unit);
            does_not = range.value(to + step.copysign(to - from));
            let at_an_end = |value: f64| value <= range.low || value >= range.high;
            if at_an_end(passes) && at_an_end(does_not) {
                return Ok(None);
            }
        }
    }

    /// Returns the answer for a quantity that was not searched.
    pub(super) fn unasked(&self, quantity: Quantity, range: &SearchRange) -> Margin {
        const WHY: &str = "the search was stopped before";
        let end = if quantity.is_safer_above() {
            range.high
        } else {
            range.low
        };
        Margin {
            quantity,
            title: quantity.title().into(),
            unit: quantity.unit().into(),
            present: range.present,
            passes_at_present: match (self.basis, *locked(&self.passes)) {
                (Basis::Verdict, Some(passes)) => passes,
                _ => self.state == NominalAnswer::Pass,
            },
            at: None,
            bracket: None,
            change_percent: None,
            basis: self.basis,
            nominal_at: None,
            nominal_bracket: None,
            verdict_at: None,
            verdict_bracket: None,
            reason: Some(WHY.into()),
            searched: (range.low, range.high),
            values: 0,
            changes: 0,
            settled_at: None,
            convention: quantity.convention().into(),
            advice: Advice::unasked(end, WHY),
            isolated: false,
        }
    }

    /// Says why there is no value at which the answer changes.
    fn reason(
        &self,
        quantity: Quantity,
        range: &SearchRange,
        passes: bool,
        advice: &Advice,
    ) -> String {
        let number = |value: f64| plain(value, 5);
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
        if passes {
            return format!("{whose} is a pass everywhere from {low} to {high}{unit}");
        }
        let why = advice.reason.as_ref();
        let why = why.map_or_else(String::new, |why| format!(": {why}"));
        match self.basis {
            Basis::NominalRun => {
                format!("{whose} is nowhere a pass from {low} to {high}{unit}{why}")
            }
            Basis::Verdict => format!(
                "no value from {low} to {high}{unit} was found at which the verdict is a pass{why}"
            ),
        }
    }
}

/// Returns the recording with every sample multiplied.
fn scaled(conditioned: &Conditioned, scale: f64) -> Conditioned {
    let mut scaled = conditioned.clone();
    for samples in [&mut scaled.raw.samples, &mut scaled.used.samples] {
        samples.iter_mut().for_each(|a| *a *= scale);
    }
    scaled.bias_m_s2 *= scale;
    scaled
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
