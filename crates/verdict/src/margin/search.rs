//! The runs and rules at one value of a quantity, and the walk over its grid.

use super::quantity::{GridBounds, Quantity, between, within_cell};
use super::{Advice, Basis, Boundary, Change, Margin, MarginOptions, NominalAnswer, Scan};
use crate::assess::assess_again;
use crate::conditioning::{self, Conditioned};
use crate::ensemble::bounds::{LOOKS, members_needed};
use crate::faults::Faults;
use crate::in_plane;
use crate::meter::Meter;
use crate::readings::{ReadingCache, Readings};
use crate::runs::{RunDetail, RunSetup};
use crate::usable_span::{SampleSpan, window_samples};
use crate::{Answer, AssessDetail, AssessExtras, Assessment, DrawnRuns, Polarity, Policy};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::criterion::Criterion;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::replay::RunOutcome;
use latchgate_kernel::units::{STANDARD_GRAVITY, plain};
use latchgate_recording::Finding;
use latchgate_recording::error::Error;
use std::borrow::Cow;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Values of a grid that the rule is asked at side by side, whatever the threads.
const SIDE_BY_SIDE: usize = 8;

/// Values that nominal runs are made at side by side: between such batches, never in one, the search
/// looks at its limit on work, so that threads do not move where it ends.
const NOMINAL_SIDE_BY_SIDE: usize = 64;

/// Cells of a grid in a row, from the advice on, that pass at every number asked in them.
const CLEAN_CELLS: usize = 5;

/// Times as many steps that a search may take as a verdict.
const WORK_TIMES: u64 = 20;

/// Relative width of the bracket of a change of the nominal runs.
const NOMINAL_WIDTH: f64 = 1e-12;

/// Halvings after which a bracket is as narrow as numbers are.
const HALVINGS: usize = 64;

/// Returns the members that a search asks at most: those of the first look that can show a share small enough for a
/// pass, which any larger ensemble looks at first.
fn members_asked(criterion: Criterion) -> u32 {
    let needed = members_needed(criterion.open_share, criterion.confidence);
    let look = LOOKS.into_iter().find(|look| *look >= needed);
    look.unwrap_or(needed)
}

/// How far the nominal levers are from a pass and from a fail at one value [rad].
#[derive(Debug, Clone, Copy, PartialEq)]
struct Excess {
    /// Above zero the answer is no pass; infinite where the lever could not be followed.
    pass: f64,
    /// Above zero the answer is a fail; never more than `pass`.
    fail: f64,
}

impl Excess {
    /// That of what was not asked for the limit on work: neither pass nor fail.
    const UNASKED: Self = Self {
        pass: f64::INFINITY,
        fail: f64::NEG_INFINITY,
    };

    fn state(self) -> NominalAnswer {
        if self.pass <= 0.0 {
            NominalAnswer::Pass
        } else if self.fail > 0.0 {
            NominalAnswer::Fail
        } else {
            NominalAnswer::Undecided
        }
    }
}

/// What was found of one quantity.
pub(super) struct Answered {
    pub(super) margin: Margin,
    pub(super) boundaries: Vec<Boundary>,
    pub(super) scan: Scan,
}

/// Everything that the searches for the margins of one verdict share.
pub(super) struct MarginSearch<'a> {
    conditioned: &'a Conditioned,
    readings: ReadingCache,
    /// The recording with its bias left in, where a pass needs both.
    biased: Option<(Conditioned, ReadingCache)>,
    findings: &'a [Finding],
    design: &'a Design,
    options: &'a MarginOptions,
    window: Option<SampleSpan>,
    bounds: GridBounds,
    /// The recording carries a blocking finding.
    pub(super) spoiled: bool,
    pub(super) basis: Basis,
    /// The answer of the nominal runs at present.
    pub(super) state: NominalAnswer,
    /// The verdict is a pass at present.
    verdict_passes: bool,
    /// Steps taken so far.
    spent: AtomicU64,
    /// Something was not asked for the limit on work.
    cut: AtomicBool,
}

impl<'a> MarginSearch<'a> {
    pub(super) fn new(
        conditioned: &'a Conditioned,
        findings: &'a [Finding],
        design: &'a Design,
        options: &'a MarginOptions,
        control: &Control<'_>,
    ) -> Result<Self, Error> {
        let policy = &options.policy;
        let signal = &conditioned.used;
        let signs = policy.polarity.signs().iter();
        let unbalance_sign = design.lever.unbalance_sign();
        let mut strongest_m_s2 = 0.0;
        for sign in signs {
            let along = in_plane::tangential(conditioned, &design.lever, *sign)?;
            let opening = along
                .samples
                .iter()
                .map(|a| -unbalance_sign * sign.sign() * a);
            strongest_m_s2 = opening.fold(strongest_m_s2, f64::max);
        }
        let faults = Faults::of(conditioned, conditioned.filter, findings, policy.window_s);
        let spoiled = faults.first_bad.is_some();
        let mut search = Self {
            conditioned,
            readings: ReadingCache::default(),
            biased: conditioning::without_doubtful_bias(conditioned)?
                .map(|biased| (biased, ReadingCache::default())),
            findings,
            design,
            options,
            window: window_samples(signal, policy.window_s)?,
            bounds: GridBounds {
                strongest_m_s2,
                counterweight_radius_m: options.counterweight_radius_m,
            },
            spoiled,
            // A spoiled recording never passes, whatever the design.
            basis: if spoiled {
                Basis::NominalRun
            } else {
                options.basis
            },
            state: NominalAnswer::Pass,
            verdict_passes: false,
            spent: AtomicU64::new(0),
            cut: AtomicBool::new(false),
        };
        search.state = search.nominal(Quantity::Scale, 1.0, control)?.state();
        search.verdict_passes = match options.passes_at_present {
            Some(passes) => passes && !spoiled,
            None => search.rule_passes(Quantity::Scale, 1.0, DrawnRuns::All, control)?,
        };
        Ok(search)
    }

    /// Returns whether the answer that the margins rest on is a pass at present.
    fn passes_at_present(&self) -> bool {
        match self.basis {
            Basis::NominalRun => self.state == NominalAnswer::Pass,
            Basis::Verdict => self.verdict_passes,
        }
    }

    fn applied(&self, quantity: Quantity, value: f64) -> (Design, f64) {
        let radius_m = self.bounds.counterweight_radius_m;
        quantity.applied(self.design, radius_m, value)
    }

    /// Tells whether the limit on work is reached, and notes that something was not asked for it.
    fn is_at_the_limit(&self) -> bool {
        let reached = self.spent.load(Ordering::Relaxed) / WORK_TIMES >= self.options.policy.work;
        if reached {
            self.cut.store(true, Ordering::Relaxed);
        }
        reached
    }

    fn limit_rad(&self, quantity: Quantity, value: f64) -> f64 {
        self.applied(quantity, value).0.criterion.threshold_rad
    }

    /// Returns how far the nominal levers are from a pass at a value.
    fn nominal(
        &self,
        quantity: Quantity,
        value: f64,
        control: &Control<'_>,
    ) -> Result<Excess, Error> {
        let (design, scale) = self.applied(quantity, value);
        let fresh = ReadingCache::default();
        let (conditioned, readings) = scaled(self.conditioned, scale, &self.readings, &fresh);
        let policy = &self.options.policy;
        let work = Meter::new(policy.work);
        let setup = RunSetup {
            design: &design,
            policy,
            follow_all: true,
            detail: AssessDetail::Decision,
            control: &control.with_threads(1),
            signal: &conditioned.used,
            drawn_runs: None,
            readings: Readings::of(&conditioned, readings, policy.between),
            window: self.window,
            work: &work,
        };
        let runs = setup.nominal_runs(&policy.variants(), RunDetail::PeakOnly)?;
        self.spent.fetch_add(work.spent(), Ordering::Relaxed);
        Ok(joined(policy, &runs, design.criterion.threshold_rad))
    }

    /// Assesses the recording with a quantity at a value.
    fn assessed(
        &self,
        quantity: Quantity,
        value: f64,
        (conditioned, readings): (&Conditioned, &ReadingCache),
        drawn_runs: DrawnRuns,
        control: &Control<'_>,
    ) -> Result<Assessment, Error> {
        let policy = &self.options.policy;
        let (design, scale) = self.applied(quantity, value);
        let fresh = ReadingCache::default();
        let (conditioned, readings) = scaled(conditioned, scale, readings, &fresh);
        let policy = Policy {
            members: policy.members.min(members_asked(design.criterion)),
            ..policy.clone()
        };
        let extras = AssessExtras {
            detail: AssessDetail::Decision,
            drawn_runs,
            ..AssessExtras::default()
        };
        let assessment = control.unmeasured(|control| {
            let samples = (extras, readings);
            assess_again(
                &conditioned,
                self.findings,
                &design,
                &policy,
                samples,
                control,
            )
        })?;
        self.spent.fetch_add(assessment.work, Ordering::Relaxed);
        Ok(assessment)
    }

    /// Returns whether the whole rule passes at a value, on the samples and, where their bias is doubtful,
    /// on those with the bias left in. What cannot be judged is no pass.
    fn rule_passes(
        &self,
        quantity: Quantity,
        value: f64,
        drawn_runs: DrawnRuns,
        control: &Control<'_>,
    ) -> Result<bool, Error> {
        if self.spoiled {
            return Ok(false);
        }
        let biased = self.biased.as_ref().map(|(of, readings)| (of, readings));
        for samples in std::iter::once((self.conditioned, &self.readings)).chain(biased) {
            match self.assessed(quantity, value, samples, drawn_runs, control) {
                Err(error) if error.is_stopped() => return Err(error),
                Ok(assessment) if assessment.answer == Answer::Pass => {}
                _ => return Ok(false),
            }
        }
        Ok(true)
    }

    /// Finds from where on every value of a quantity passes.
    pub(super) fn advice(
        &self,
        quantity: Quantity,
        control: &Control<'_>,
    ) -> Result<Advice, Error> {
        Walk::new(self, quantity, control).advice()
    }

    /// Finds the margin of a quantity.
    pub(super) fn answer(
        &self,
        quantity: Quantity,
        control: &Control<'_>,
    ) -> Result<Answered, Error> {
        let mut walk = Walk::new(self, quantity, control);
        let present = quantity.present(self.design);
        let mut values = walk.grid.clone();
        values.push(present);
        values.sort_unstable_by(f64::total_cmp);
        values.dedup_by(|a, b| a.to_bits() == b.to_bits());
        let mut points: Vec<(f64, Excess)> = Vec::with_capacity(values.len());
        for values in values.chunks(NOMINAL_SIDE_BY_SIDE) {
            let excesses = if self.is_at_the_limit() {
                vec![Excess::UNASKED; values.len()]
            } else {
                control.unmeasured(|control| {
                    control.try_map(values, |value| self.nominal(quantity, *value, control))
                })?
            };
            points.extend(values.iter().copied().zip(excesses));
        }
        let excess_by_bits = points
            .iter()
            .map(|(value, excess)| (value.to_bits(), *excess));
        walk.nominal.extend(excess_by_bits);
        // First, so that it counts no values that only the nearest change is asked at.
        let advice = walk.advice()?;
        let stays = |value: f64| Ok(walk.nominal_at(value, control)?.pass <= 0.0);
        let stays_now = self.state == NominalAnswer::Pass;
        let nominal_change = walk.nearest(&points, stays_now, true, &stays)?;
        let passes = |value: f64| walk.passes_at(value);
        let verdict_change = if self.spoiled {
            None
        } else {
            walk.nearest(&points, self.verdict_passes, false, &passes)?
        };
        // What was not asked for the limit on work is no change.
        let is_whole = !self.cut.load(Ordering::Relaxed);
        let verdict_change = verdict_change.filter(|_| is_whole);
        let nominal_change = nominal_change.filter(|_| is_whole);
        let change = match self.basis {
            Basis::NominalRun => nominal_change,
            Basis::Verdict => verdict_change,
        };
        let reason = change
            .is_none()
            .then(|| self.reason(quantity, &walk.grid, &advice));
        let boundaries = walk.boundaries(&points)?;
        let scan = Scan {
            quantity,
            present,
            points: points
                .iter()
                .map(|(value, excess)| {
                    let peak = excess.pass + self.limit_rad(quantity, *value);
                    (*value, peak.is_finite().then_some(peak))
                })
                .collect(),
        };
        Ok(Answered {
            margin: Margin {
                change,
                nominal_change,
                verdict_change,
                reason,
                advice,
                ..self.unasked(quantity)
            },
            boundaries,
            scan,
        })
    }

    /// Returns the answer for a quantity that was not searched.
    pub(super) fn unasked(&self, quantity: Quantity) -> Margin {
        const WHY: &str = "the search was stopped before";
        let grid = quantity.grid(self.design, &self.bounds);
        let (low, high) = ends(&grid);
        let until = if quantity.is_safer_above() { high } else { low };
        Margin {
            quantity,
            title: quantity.title().into(),
            unit: quantity.unit().into(),
            present: quantity.present(self.design),
            passes_at_present: self.passes_at_present(),
            basis: self.basis,
            change: None,
            nominal_change: None,
            verdict_change: None,
            reason: Some(WHY.into()),
            searched: (low, high),
            values: grid.len(),
            convention: quantity.convention().into(),
            advice: Advice::unasked(until, WHY),
        }
    }

    /// Says why there is no value at which the answer changes.
    fn reason(&self, quantity: Quantity, grid: &[f64], advice: &Advice) -> String {
        let (low, high) = ends(grid);
        let range = format!("from {} to {}", plain(low, 3), quantity.shown(high));
        let whose = match self.basis {
            Basis::NominalRun => "the nominal run",
            Basis::Verdict => "the verdict",
        };
        if self.cut.load(Ordering::Relaxed) {
            return format!("the search {range} ended at the limit `work`");
        }
        if self.passes_at_present() {
            return match advice.does_not {
                None => format!("{whose} is a pass at every value tried {range}"),
                Some(value) => format!(
                    "{whose} is a pass at every value of the first search {range}, but the whole rule is none at {}",
                    quantity.shown(value)
                ),
            };
        }
        let why = advice.reason.as_ref();
        let why = why.map_or_else(String::new, |why| format!(": {why}"));
        format!("{whose} is a pass at no value {range}{why}")
    }

    /// Says why the rule does not pass at a value.
    fn hindrance(
        &self,
        quantity: Quantity,
        value: f64,
        control: &Control<'_>,
    ) -> Result<String, Error> {
        if self.spoiled {
            return Ok("a blocking finding makes the recording unusable".into());
        }
        let shown_value = quantity.shown(value);
        let samples = (self.conditioned, &self.readings);
        if self.is_at_the_limit() {
            return Ok("the search ended at the limit `work`".into());
        }
        let assessed = match self.assessed(quantity, value, samples, DrawnRuns::All, control) {
            Err(error) if error.is_stopped() => return Err(error),
            Err(error) => return Ok(format!("at {shown_value} nothing can be judged: {error}")),
            Ok(assessed) => assessed,
        };
        let (input, lever) = (&self.design.input, &self.design.lever);
        let error_g = self.conditioned.bias_standard_error_m_s2 / STANDARD_GRAVITY;
        let bias_g = error_g.max(input.bias_g);
        let holds_g = lever.lift_off_acceleration_m_s2() / STANDARD_GRAVITY;
        // Among hundreds of members some have a bias of three standard deviations.
        if quantity == Quantity::Scale && 3.0 * bias_g > holds_g {
            return Ok(format!(
                "the bias alone opens this lever: it is uncertain by {} g (one standard deviation), and the preload holds {} g",
                plain(bias_g, 2),
                plain(holds_g, 3)
            ));
        }
        // A bound that spares an ensemble stands in no pass's way.
        let mut why = assessed.why.iter();
        Ok(match why.find(|why| why.code != "no-member-can-cross") {
            Some(why) if assessed.answer != Answer::Pass => {
                format!("at {shown_value}: {}", why.text.trim_end_matches('.'))
            }
            _ => format!("at {shown_value} the doubt about the bias leaves no pass"),
        })
    }
}

/// A walk over the grid of one quantity, with what was asked on the way.
struct Walk<'w, 'a> {
    search: &'w MarginSearch<'a>,
    quantity: Quantity,
    control: &'w Control<'w>,
    grid: Vec<f64>,
    /// The nominal levers at values of the grid, by their bits, where those were run.
    nominal: BTreeMap<u64, Excess>,
    /// What the rule said, by the bits of values.
    rule: RefCell<BTreeMap<u64, bool>>,
}

impl<'w, 'a> Walk<'w, 'a> {
    fn new(search: &'w MarginSearch<'a>, quantity: Quantity, control: &'w Control<'w>) -> Self {
        Self {
            search,
            quantity,
            control,
            grid: quantity.grid(search.design, &search.bounds),
            nominal: BTreeMap::new(),
            rule: RefCell::default(),
        }
    }

    fn nominal_at(&self, value: f64, control: &Control<'_>) -> Result<Excess, Error> {
        match self.nominal.get(&value.to_bits()) {
            Some(known) => Ok(*known),
            None if self.search.is_at_the_limit() => Ok(Excess::UNASKED),
            None => self.search.nominal(self.quantity, value, control),
        }
    }

    /// Returns whether the whole rule passes at each of some values, in their order.
    /// Where a nominal lever opens, it cannot.
    fn passes(&self, values: &[f64]) -> Result<Vec<bool>, Error> {
        let answered = |value: &f64| self.rule.borrow().get(&value.to_bits()).copied();
        let open: Vec<f64> = values
            .iter()
            .copied()
            .filter(|value| answered(value).is_none())
            .collect();
        let threads = self.control.threads.div_ceil(open.len().max(1));
        let (search, quantity, nominal) = (self.search, self.quantity, &self.nominal);
        if !open.is_empty() && search.is_at_the_limit() {
            return Ok(vec![false; values.len()]);
        }
        let answers = self.control.try_map(&open, |value| {
            let control = self.control.with_threads(threads);
            let excess = match nominal.get(&value.to_bits()) {
                Some(answered) => *answered,
                None => search.nominal(quantity, *value, &control)?,
            };
            let passes = excess.pass <= 0.0
                && search.rule_passes(quantity, *value, DrawnRuns::Doubtful, &control)?;
            Ok::<_, Error>(passes)
        })?;
        let bits = open.iter().map(|value| value.to_bits());
        self.rule.borrow_mut().extend(bits.zip(answers));
        Ok(values.iter().filter_map(answered).collect())
    }

    /// Returns whether the whole rule passes at a value.
    fn passes_at(&self, value: f64) -> Result<bool, Error> {
        Ok(self.passes(&[value])?.contains(&true))
    }

    /// Asks the whole rule from the safe end on, down to the first value that does not pass; then at numbers
    /// of three digits in the cells of the grid, upwards from there, until [`CLEAN_CELLS`] of them pass throughout.
    fn advice(&self) -> Result<Advice, Error> {
        let mut order = self.grid.clone();
        if self.quantity.is_safer_above() {
            order.reverse();
        }
        let until = order.first().copied().unwrap_or_default();
        let (passing, mut does_not) = self.as_far_as_they_pass(&order)?;
        let mut safe_from = passing.last().copied();
        let mut clean_cells = 0;
        // Near its limit a lever passes at some values by luck, so that one pass proves none beside it.
        for cell in order[..order.len().min(passing.len() + 1)].windows(2).rev() {
            if clean_cells == CLEAN_CELLS {
                break;
            }
            let mut values = within_cell(cell[0], cell[1]);
            values.push(cell[1]);
            let (passing, failing) = self.as_far_as_they_pass(&values)?;
            if failing.is_some() {
                safe_from = passing.last().or(cell.first()).copied();
                does_not = failing;
                clean_cells = 0;
            } else {
                clean_cells += 1;
            }
        }
        if let (Some(from), Some(end)) = (safe_from, does_not) {
            let values = between(from, end);
            let (passing, failing) = self.as_far_as_they_pass(&values)?;
            safe_from = passing.last().copied().or(safe_from);
            does_not = failing.or(does_not);
        }
        while let Some(from) = safe_from.filter(|_| !self.search.is_at_the_limit()) {
            if self.passes_with_all_draws(from)? {
                break;
            }
            (safe_from, does_not) = (self.next_safer(from), Some(from));
        }
        let reason = match safe_from {
            Some(_) => None,
            None => Some(self.search.hindrance(self.quantity, until, self.control)?),
        };
        let cut = self.search.cut.load(Ordering::Relaxed);
        let mut advice = Advice {
            safe_from,
            until,
            does_not: does_not.filter(|_| !cut),
            tried: 0,
            reason,
            text: String::new(),
        };
        let answers = self.rule.borrow();
        let values = answers.keys().map(|bits| f64::from_bits(*bits));
        advice.tried = values
            .filter(|value| advice.covers(self.quantity, *value))
            .count();
        let present = self.quantity.present(self.search.design);
        advice.text = advice.sentence(self.quantity, present, self.search.verdict_passes);
        if cut && advice.safe_from.is_some() {
            advice
                .text
                .push_str("; the search ended there at the limit `work`");
        }
        Ok(advice)
    }

    /// Returns whether the whole rule passes at a value, under all draws of the noise, and keeps the answer.
    fn passes_with_all_draws(&self, value: f64) -> Result<bool, Error> {
        let (search, control) = (self.search, self.control);
        let passes = search.rule_passes(self.quantity, value, DrawnRuns::All, control)?;
        self.rule.borrow_mut().insert(value.to_bits(), passes);
        Ok(passes)
    }

    /// Returns the nearest value on the safer side that was asked and passes.
    fn next_safer(&self, from: f64) -> Option<f64> {
        let rule = self.rule.borrow();
        let passing = rule.iter().filter(|(_, passes)| **passes);
        let values = passing.map(|(bits, _)| f64::from_bits(*bits));
        if self.quantity.is_safer_above() {
            values.filter(|value| *value > from).reduce(f64::min)
        } else {
            values.filter(|value| *value < from).reduce(f64::max)
        }
    }

    /// Returns the values before the first that does not pass, and that one.
    fn as_far_as_they_pass<'v>(
        &self,
        values: &'v [f64],
    ) -> Result<(&'v [f64], Option<f64>), Error> {
        let mut count = 0;
        for values_side_by_side in values.chunks(SIDE_BY_SIDE) {
            let answers = self.passes(values_side_by_side)?;
            let first = answers.iter().position(|passes| !passes);
            count += first.unwrap_or(answers.len());
            if first.is_some() {
                break;
            }
        }
        Ok((&values[..count], values.get(count).copied()))
    }

    /// Returns the nearest change, among neighbours of `points`, from the answer at present, `now`: halved
    /// at numbers of three digits, or as far as [`NOMINAL_WIDTH`] where it shall be `exact`.
    fn nearest(
        &self,
        points: &[(f64, Excess)],
        now: bool,
        exact: bool,
        passes: &dyn Fn(f64) -> Result<bool, Error>,
    ) -> Result<Option<Change>, Error> {
        let present = self.quantity.present(self.search.design);
        let distance = |value: f64| {
            if self.quantity.is_ratio() {
                libm::log(value / present).abs()
            } else {
                (value - present).abs()
            }
        };
        let mut order: Vec<usize> = (0..points.len())
            .filter(|index| points[*index].0.to_bits() != present.to_bits())
            .collect();
        order.sort_by(|a, b| distance(points[*a].0).total_cmp(&distance(points[*b].0)));
        for index in order {
            let mut outside = points[index].0;
            if passes(outside)? == now {
                continue;
            }
            // The neighbour towards the present value was asked before, or is that value.
            let neighbour = if outside > present {
                index - 1
            } else {
                index + 1
            };
            let mut inside = points[neighbour].0;
            let middle = |inside: f64, outside: f64| {
                if exact {
                    let wide =
                        (inside - outside).abs() > NOMINAL_WIDTH * inside.abs().max(outside.abs());
                    return wide.then(|| f64::midpoint(inside, outside));
                }
                let values = between(inside, outside);
                values.get(values.len() / 2).copied()
            };
            for _ in 0..HALVINGS {
                let Some(middle) = middle(inside, outside) else {
                    break;
                };
                if passes(middle)? == now {
                    inside = middle;
                } else {
                    outside = middle;
                }
            }
            let (passes, does_not) = if now {
                (inside, outside)
            } else {
                (outside, inside)
            };
            return Ok(Some(Change { passes, does_not }));
        }
        Ok(None)
    }

    /// Returns every change of the nominal runs' answer between neighbours; narrowed down where the
    /// margins are those of the nominal run.
    fn boundaries(&self, points: &[(f64, Excess)]) -> Result<Vec<Boundary>, Error> {
        let cells: Vec<&[(f64, Excess)]> = points
            .windows(2)
            .filter(|cell| cell[0].1.state() != cell[1].1.state())
            .collect();
        let (search, quantity) = (self.search, self.quantity);
        let mut boundaries = Vec::with_capacity(cells.len());
        for cells in cells.chunks(SIDE_BY_SIDE) {
            let halvings = match search.basis {
                Basis::NominalRun if !search.is_at_the_limit() => HALVINGS,
                Basis::NominalRun | Basis::Verdict => 0,
            };
            boundaries.extend(self.control.unmeasured(|control| {
                control.try_map(cells, |cell| {
                    let ends = (cell[0], cell[1]);
                    search.boundary(quantity, ends, halvings, control)
                })
            })?);
        }
        Ok(boundaries)
    }
}

impl MarginSearch<'_> {
    /// Returns the change of the nominal runs' answer between two values.
    fn boundary(
        &self,
        quantity: Quantity,
        (mut low, mut high): ((f64, Excess), (f64, Excess)),
        halvings: usize,
        control: &Control<'_>,
    ) -> Result<Boundary, Error> {
        let of_pass = [low.1.state(), high.1.state()].contains(&NominalAnswer::Pass);
        let is_better = |excess: Excess| {
            let edge = if of_pass { excess.pass } else { excess.fail };
            edge <= 0.0
        };
        let better_below = is_better(low.1);
        for _ in 0..halvings {
            if high.0 - low.0 <= NOMINAL_WIDTH * high.0 {
                break;
            }
            let middle = f64::midpoint(low.0, high.0);
            let excess = self.nominal(quantity, middle, control)?;
            if is_better(excess) == better_below {
                low = (middle, excess);
            } else {
                high = (middle, excess);
            }
        }
        Ok(Boundary {
            quantity: quantity.name().into(),
            unit: quantity.unit().into(),
            at: if better_below { low.0 } else { high.0 },
            bracket: (low.0, high.0),
            below: low.1.state(),
            above: high.1.state(),
        })
    }
}

/// Joins what the stops of each sign did, in the order of signs, by parts 3 and 4 of the decision rule
/// with no error counted: a pass if no run goes beyond the limit in window or coast; a fail if every one
/// does in the window, or for polarities declared as both every one of a sign. A lever that could not be
/// followed counts as one that goes beyond any limit: nothing that is not known passes.
fn joined(policy: &Policy, runs: &[RunOutcome], threshold_rad: f64) -> Excess {
    let reach = |outcome: &RunOutcome| {
        let peak = outcome.run.peak_angle_rad;
        let coast = outcome.run.coast_peak_angle_rad;
        let highest = coast.map_or(peak, |coast| if coast > peak { coast } else { peak });
        let is_followed =
            !outcome.broke_down && peak.is_finite() && coast.is_none_or(f64::is_finite);
        if is_followed {
            (peak, highest)
        } else {
            (f64::NEG_INFINITY, f64::INFINITY)
        }
    };
    let reaches: Vec<(f64, f64)> = runs.iter().map(reach).collect();
    let highest = reaches.iter().map(|(_, highest)| *highest);
    let least_of_signs = reaches.chunks(policy.model.stops().len()).map(|of_sign| {
        let peaks = of_sign.iter().map(|(peak, _)| *peak);
        peaks.fold(f64::INFINITY, f64::min)
    });
    let fail = match policy.polarity {
        Polarity::Both => least_of_signs.fold(f64::NEG_INFINITY, f64::max),
        Polarity::Declared(_) | Polarity::Undeclared => {
            least_of_signs.fold(f64::INFINITY, f64::min)
        }
    };
    Excess {
        pass: highest.fold(f64::NEG_INFINITY, f64::max) - threshold_rad,
        fail: fail - threshold_rad,
    }
}

/// Returns the least and the greatest value of a grid.
fn ends(grid: &[f64]) -> (f64, f64) {
    (
        grid.first().copied().unwrap_or_default(),
        grid.last().copied().unwrap_or_default(),
    )
}

/// Returns the recording with every sample multiplied, and the cache of its readings: `fresh` where its
/// samples are others.
fn scaled<'c>(
    conditioned: &'c Conditioned,
    scale: f64,
    readings: &'c ReadingCache,
    fresh: &'c ReadingCache,
) -> (Cow<'c, Conditioned>, &'c ReadingCache) {
    if scale.to_bits() == 1.0_f64.to_bits() {
        return (Cow::Borrowed(conditioned), readings);
    }
    let mut scaled = conditioned.clone();
    scale_samples(&mut scaled, scale);
    (Cow::Owned(scaled), fresh)
}

fn scale_samples(conditioned: &mut Conditioned, scale: f64) {
    for samples in [&mut conditioned.raw.samples, &mut conditioned.used.samples] {
        samples.iter_mut().for_each(|a| *a *= scale);
    }
    conditioned.formula = conditioned
        .formula
        .take()
        .map(|formula| formula.scaled(scale, 0.0));
    conditioned.bias_m_s2 *= scale;
    // A recording that is so many times as strong is as noisy for its strength.
    conditioned.noise.deviation_m_s2 *= scale;
    conditioned.noise.step_m_s2 *= scale;
    if let Some(second) = &mut conditioned.second {
        scale_samples(&mut second.conditioned, scale);
    }
}
