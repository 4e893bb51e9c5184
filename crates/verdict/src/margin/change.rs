//! Where the verdict by the whole rule changes, which is dear to ask for.

use super::quantity::SearchRange;
use super::search::{Crossing, Excess};
use latchgate_recording::error::Error;

/// A change of the verdict: the last value without and the first with it, which of both passes.
#[derive(Debug, Clone, Copy)]
pub(super) struct VerdictChange {
    pub(super) passes: f64,
    pub(super) does_not: f64,
}

impl VerdictChange {
    pub(super) fn bracket(self) -> (f64, f64) {
        (
            self.passes.min(self.does_not),
            self.passes.max(self.does_not),
        )
    }
}

/// Looks for the nearest change of a verdict that is dear to ask for, by what the nominal runs
/// say: a pass needs more than theirs.
pub(super) struct VerdictSearch<'a> {
    /// Whether the verdict passes at a value. The second argument allows a pass that is not
    /// certain: cheaper, where values nearby were asked about before.
    pub(super) passes: &'a dyn Fn(f64, bool) -> Result<bool, Error>,
    pub(super) range: &'a SearchRange,
    /// The nominal runs that the search saw, in ascending order.
    pub(super) points: &'a [(f64, Excess)],
    /// Width of the bracket, on the scale of places, of a span of length one.
    pub(super) width: f64,
}

/// First step from a boundary of the nominal runs, on the scale of places.
const FIRST_STEP: f64 = 1e-3;

/// Ranges in which the nominal runs pass that are looked into, the nearest first; one that
/// reaches an end of the range is looked into in any case.
const SPANS: usize = 3;

/// The same of those that are longer than the first step: a needle is soon asked, and hardly ever
/// an answer.
const LONG_SPANS: usize = 24;

/// Values to either side, evenly between the present one and the change that was found, at which
/// the whole rule is asked whether there is a nearer one.
const BETWEEN: u32 = 24;

/// Width of a bracket below which a question is cheap: no ensemble is asked.
const CHEAP_WIDTH: f64 = 5e-5;

/// Parts of a narrow stretch at whose joints the whole rule is asked, where that is cheap.
const PARTS: u32 = 16;

/// First steps that a narrow stretch is long at most.
const PARTS_STEPS: f64 = 8.0;

/// Nominal peaks, the highest, between the present value and a boundary of the nominal runs
/// at which the whole rule is asked: what comes close to the threshold may be no pass.
const CLOSE_CALLS: usize = 6;

/// Uncertain passes that may turn out wrong before no more are taken.
const WRONG_MAX: usize = 4;

impl VerdictSearch<'_> {
    /// Length that widths and steps are relative to.
    fn unit(&self) -> f64 {
        if self.range.ratios {
            1.0
        } else {
            self.range.high - self.range.low
        }
    }

    /// Returns the nearest change; `passes` says what the verdict is at present.
    pub(super) fn nearest(
        &self,
        changes: &[&Crossing],
        nominal_passes: bool,
        passes: bool,
    ) -> Result<Option<VerdictChange>, Error> {
        if passes {
            self.leaving(changes)
        } else {
            self.reaching(changes, nominal_passes)
        }
    }

    /// From a present pass to the nearest value that is none, to either side.
    fn leaving(&self, changes: &[&Crossing]) -> Result<Option<VerdictChange>, Error> {
        let here = self.range.place(self.range.present);
        let mut best: Option<VerdictChange> = None;
        for upwards in [true, false] {
            let next = if upwards {
                changes.iter().find(|c| c.high.0 > self.range.present)
            } else {
                changes.iter().rev().find(|c| c.low.0 < self.range.present)
            };
            let (end, certain) = match (next, upwards) {
                (Some(crossing), true) => (crossing.high.0, true),
                (Some(crossing), false) => (crossing.low.0, true),
                (None, true) => (self.range.high, false),
                (None, false) => (self.range.low, false),
            };
            // What is no nearer than the other side's change is not the answer.
            let mut end = self.range.place(end);
            let mut certain = certain;
            if let Some(best) = best {
                let reach = self.range.distance(best.does_not);
                let mirrored = if upwards { here + reach } else { here - reach };
                if (mirrored - here).abs() < (end - here).abs() {
                    (end, certain) = (mirrored, false);
                }
            }
            if let Some(doubt) = self.close_call(here, end)? {
                (end, certain) = (doubt, true);
            }
            if !certain && self.passes_at(end)? {
                continue;
            }
            let change = self.halve(here, end)?;
            if best.is_none_or(|best| {
                self.range.distance(change.does_not) < self.range.distance(best.does_not)
            }) {
                best = Some(change);
            }
        }
        self.nearer(here, best)
    }

    /// Asks between the present value, which passes, and the change that was found, or the ends of
    /// the range, whether there is a nearer one.
    fn nearer(
        &self,
        here: f64,
        found: Option<VerdictChange>,
    ) -> Result<Option<VerdictChange>, Error> {
        let (low, high) = (self.low_place(), self.range.place(self.range.high));
        let reach = found.map_or((high - here).max(here - low), |found| {
            self.range.distance(found.does_not)
        });
        let between = (1..=BETWEEN)
            .flat_map(|step| {
                let away = reach * f64::from(step) / f64::from(BETWEEN + 1);
                [here + away, here - away]
            })
            .filter(|place| (low..=high).contains(place));
        match self.first_no_pass(between)? {
            Some(place) => self.halve(here, place).map(Some),
            None => Ok(found),
        }
    }

    /// The nearest of the close calls between `here` and `end` at which the verdict is no pass.
    fn close_call(&self, here: f64, end: f64) -> Result<Option<f64>, Error> {
        let between = |place: f64| (place - here) * (place - end) < 0.0;
        let mut tops: Vec<(f64, f64)> = self
            .points
            .windows(3)
            .map(|near| (near[0].1.pass, near[1], near[2].1.pass))
            .filter(|(before, top, after)| top.1.pass >= *before && top.1.pass >= *after)
            .map(|(_, top, _)| (self.range.place(top.0), top.1.pass))
            .filter(|(place, excess)| between(*place) && *excess <= 0.0)
            .collect();
        tops.sort_by(|a, b| b.1.total_cmp(&a.1));
        tops.truncate(CLOSE_CALLS);
        tops.sort_by(|a, b| (a.0 - here).abs().total_cmp(&(b.0 - here).abs()));
        self.first_no_pass(tops.into_iter().map(|(place, _)| place))
    }

    /// The first of some places at which the verdict is no pass.
    fn first_no_pass(&self, places: impl Iterator<Item = f64>) -> Result<Option<f64>, Error> {
        for place in places {
            if !self.passes_at(place)? {
                return Ok(Some(place));
            }
        }
        Ok(None)
    }

    fn passes_at(&self, place: f64) -> Result<bool, Error> {
        (self.passes)(self.range.value(place), false)
    }

    /// From no pass at present to the nearest value that is one.
    fn reaching(
        &self,
        changes: &[&Crossing],
        nominal_passes: bool,
    ) -> Result<Option<VerdictChange>, Error> {
        let here = self.range.place(self.range.present);
        let distance = |(from, to): &(f64, f64)| {
            if (*from..=*to).contains(&here) {
                0.0
            } else {
                (from - here).abs().min((to - here).abs())
            }
        };
        let mut spans = self.nominal_passes(changes, nominal_passes);
        spans.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        let mut best: Option<VerdictChange> = None;
        let reaches_an_end = |(from, to): &(f64, f64)| {
            *from <= self.low_place() || *to >= self.range.place(self.range.high)
        };
        let mut long_ones = 0;
        for (index, (from, to)) in spans.into_iter().enumerate() {
            let long = to - from > FIRST_STEP * self.unit();
            long_ones += usize::from(long);
            let near = index < SPANS || (long && long_ones <= LONG_SPANS);
            if !near && !reaches_an_end(&(from, to)) {
                continue;
            }
            let starts = if (from..=to).contains(&here) {
                vec![(here, to), (here, from)]
            } else if here < from {
                vec![(from, to)]
            } else {
                vec![(to, from)]
            };
            for (start, end) in starts {
                let near = |change: &VerdictChange| self.range.distance(change.passes);
                if best.is_some_and(|best| near(&best) <= (start - here).abs()) {
                    continue;
                }
                if let Some(change) = self.inwards(start, end)?
                    && best.is_none_or(|best| near(&change) < near(&best))
                {
                    best = Some(change);
                }
            }
        }
        Ok(best)
    }

    /// Ranges in which the nominal runs pass, on the scale of places.
    fn nominal_passes(&self, changes: &[&Crossing], nominal_passes: bool) -> Vec<(f64, f64)> {
        let place = |value: f64| self.range.place(value);
        let mut spans = Vec::new();
        let first_passes = changes
            .first()
            .map_or(nominal_passes, |first| first.low.1.pass <= 0.0);
        let mut from = first_passes.then(|| self.low_place());
        for crossing in changes {
            if crossing.low.1.pass <= 0.0 {
                if let Some(from) = from.take() {
                    spans.push((from, place(crossing.low.0)));
                }
            } else {
                from = Some(place(crossing.high.0));
            }
        }
        if let Some(from) = from {
            spans.push((from, place(self.range.high)));
        }
        spans
    }

    fn low_place(&self) -> f64 {
        self.range.place(self.range.low)
    }

    /// Steps from `start`, where the verdict is no pass or just one, towards `end` until it is.
    fn inwards(&self, start: f64, end: f64) -> Result<Option<VerdictChange>, Error> {
        let side = (end - start).signum();
        let length = (end - start).abs();
        let mut before = start;
        let mut step = FIRST_STEP * self.unit();
        if self.passes_at(start)? {
            let value = self.range.value(start);
            return Ok(Some(VerdictChange {
                passes: value,
                does_not: value,
            }));
        }
        while step < length {
            let place = start + side * step;
            if self.passes_at(place)? {
                return self.halve(place, before).map(Some);
            }
            before = place;
            step *= 2.0;
        }
        // What is left of the range: its end, or what lies within where it is a narrow one.
        let parts = if self.width < CHEAP_WIDTH { PARTS } else { 2 };
        let within =
            (1..parts).map(|part| start + (end - start) * f64::from(part) / f64::from(parts));
        let narrow = step <= 2.0 * PARTS_STEPS * FIRST_STEP * self.unit();
        let within: Vec<f64> = if narrow { within.collect() } else { Vec::new() };
        let middle = f64::midpoint(start, end);
        for place in within.into_iter().chain([end, middle]) {
            if self.passes_at(place)? {
                let from = if (place - start).abs() > (before - start).abs() {
                    before
                } else {
                    start
                };
                return self.halve(place, from).map(Some);
            }
        }
        Ok(None)
    }

    /// Whether the verdict passes at a place, certain or not: after some uncertain passes that
    /// were wrong, no more are taken.
    fn may_pass_at(&self, place: f64, wrong: usize) -> Result<bool, Error> {
        (self.passes)(self.range.value(place), wrong < WRONG_MAX)
    }

    /// Halves the way between a place that passes and one that does not. Passes on the way may be
    /// uncertain; the ends of the bracket are certain.
    fn halve(&self, passing: f64, not_passing: f64) -> Result<VerdictChange, Error> {
        let side = (passing - not_passing).signum();
        let width = self.width * self.unit();
        let (mut passes, mut does_not) = (passing, not_passing);
        let mut wrong = 0;
        loop {
            while (passes - does_not).abs() > width {
                let middle = f64::midpoint(passes, does_not);
                if self.may_pass_at(middle, wrong)? {
                    passes = middle;
                } else {
                    does_not = middle;
                }
            }
            let certain = wrong >= WRONG_MAX || same(passes, passing);
            if certain || self.passes_at(passes)? {
                return Ok(VerdictChange {
                    passes: self.range.value(passes),
                    does_not: self.range.value(does_not),
                });
            }
            // Back towards the place that is certain, in steps that double.
            wrong += 1;
            (does_not, passes) = (passes, passing);
            let mut step = width;
            while step < (passing - does_not).abs() {
                let place = does_not + side * step;
                if self.may_pass_at(place, wrong)? {
                    passes = place;
                    break;
                }
                does_not = place;
                step *= 2.0;
            }
        }
    }
}

fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits()
}
