//! The advice: the value from which on every value that is searched passes by the whole rule.
//!
//! The search goes from the end of the range that holds the lever best towards the other. The
//! nominal runs of the scan show how far it may go; on that way the rule is asked, without an
//! ensemble at [`ASKED`] values and with the first look of one from there back. Each time a tenth
//! of the limit must be left, so that values between those that are asked have room. Where a nominal
//! lever near the limit begins to come to its peak after other impacts, the rule is asked on both
//! sides: there readings of the samples disagree, in bands too narrow to be hit otherwise. Where the nominal
//! peak has a top beyond the value found, it is looked at more closely and the rule asked at its highest.

use super::Quantity;
use super::quantity::SearchRange;
use super::search::{self, Excess, ScanFn, SearchResult};
use crate::assess::NominalPass;
use crate::early::MemberCache;
use crate::interpolation::{Course, DIFFERING_TIMES};
use latchgate_kernel::units::{plain, shortest};
use latchgate_recording::error::Error;
use serde::{Deserialize, Serialize};

/// From where on every value searched passes by the whole rule.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Advice {
    /// The value; `None` with a reason.
    pub safe_from: Option<f64>,
    /// The end of the range, to which every value searched passes.
    pub until: f64,
    /// Values from there on that the rule was asked of, with an ensemble where there is one.
    pub by_rule: usize,
    /// Values from there on at which the nominal levers were run.
    pub by_nominal_runs: usize,
    /// Why there is none.
    pub reason: Option<String>,
    /// In a sentence.
    pub text: String,
}

/// Most values at which the rule is asked without an ensemble, more towards where the nominal lever
/// begins to cross; a quarter of them on a long recording.
const ASKED: usize = 96;

/// Values that are asked side by side, whatever the threads: the last ones may be in vain.
const SIDE_BY_SIDE: usize = 4;

/// Part of the peak from which on a neighbour that differs by as much shows a jump between them.
const JUMP: f64 = 0.5;

/// Part of the limit from which on a peak is looked at for changes of its course: on another reading
/// of the samples a scene reached three times its peak.
const DIFFERING_PART: f64 = 0.1;

/// Times that a cell is halved to find where the course of a lever changes.
const HALVINGS: usize = 8;

/// Changes of course that are looked at: where there are more, the motion is chaotic.
const CHANGES_MAX: usize = 48;

/// Part of the limit within which a value must pass.
pub(super) const ROOM: f64 = 0.9;

/// Values beyond the one advised at which the ensemble is asked as well.
const CHECKED: usize = 4;

/// Tops of the nominal peak beyond the value advised at which the rule is asked.
const TOPS: usize = 8;

/// Of these, the highest at which the ensemble is asked as well.
const TOPS_WITH_MEMBERS: usize = 3;

/// Part of the limit from which on a top is asked.
const TOP_PART: f64 = 0.1;

/// Significant digits of a value that is advised.
const DIGITS: i32 = 3;

/// Members that are asked at most: a pass at the first look is one of any larger ensemble, which
/// looks at the same members.
pub(super) const MEMBERS_ASKED: u32 = 128;

/// A part of the limit that must suffice, and the members that are asked at most.
pub(super) type RoomAndMembers = (f64, Option<u32>);

/// What the rule says of the nominal levers at several values, in their order.
type NominalPasses = Result<Vec<NominalPass>, Error>;

/// The ways to ask about a value of one quantity.
pub(super) struct AdviceProbe<'a> {
    /// What the rule says of the nominal levers at values, with [`ROOM`].
    pub(super) nominal: &'a dyn Fn(&[f64]) -> NominalPasses,
    /// How far the nominal levers are from a pass at values, by the method of the scan.
    pub(super) scan: &'a ScanFn<'a>,
    /// The highest angle of each nominal lever, and how it came to its peak.
    pub(super) courses: &'a dyn Fn(f64) -> Result<Vec<(f64, Course)>, Error>,
    /// Peaks further apart are different ones [s].
    pub(super) apart_s: f64,
    /// Whether the whole rule says pass.
    pub(super) rule: &'a dyn Fn(f64, RoomAndMembers, &mut MemberCache) -> Result<bool, Error>,
    /// What stands in the way of a pass.
    pub(super) hindrance: &'a dyn Fn(f64) -> Result<String, Error>,
    pub(super) threshold_rad: f64,
    /// An ensemble is asked.
    pub(super) with_members: bool,
    /// A blocking finding leaves no pass.
    pub(super) spoiled: bool,
    /// The recording is a long one.
    pub(super) long: bool,
}

/// The courses of the nominal levers at a value.
#[derive(Clone)]
struct Courses {
    value: f64,
    levers: Vec<(f64, Course)>,
}

impl Courses {
    fn at(of: &AdviceSearch<'_>, value: f64) -> Result<Self, Error> {
        let levers = (of.probe.courses)(value)?;
        Ok(Self { value, levers })
    }
}

struct AdviceSearch<'s> {
    probe: &'s AdviceProbe<'s>,
    quantity: Quantity,
    range: &'s SearchRange,
    /// The values of the scan from the safe end on, as far as the nominal levers pass.
    free: Vec<(f64, Excess)>,
    cache: MemberCache,
    /// Values that pass by the rule, with or without an ensemble.
    asked: Vec<f64>,
    /// Values next to tops of the nominal peak at which the nominal levers were run.
    looked_at: Vec<f64>,
    /// The value and the angle [rad] at which they came highest next to a place.
    highest: Vec<Option<(f64, f64)>>,
    /// What the whole rule said of values.
    known: Vec<(f64, bool)>,
}

/// Finds the advice for a quantity, of which the nominal runs `found` their changes.
pub(super) fn advise(
    probe: &AdviceProbe<'_>,
    quantity: Quantity,
    range: &SearchRange,
    found: &SearchResult,
) -> Result<Advice, Error> {
    let above = quantity.is_safer_above();
    let mut free: Vec<(f64, Excess)> = found.points.clone();
    if above {
        free.reverse();
    }
    let safe_end = if above { range.high } else { range.low };
    let stay = free.iter().take_while(|(_, excess)| excess.pass <= 0.0);
    free.truncate(stay.count());
    let highest = vec![None; free.len()];
    let mut of = AdviceSearch {
        probe,
        quantity,
        range,
        free,
        cache: MemberCache::default(),
        asked: Vec::new(),
        looked_at: Vec::new(),
        highest,
        known: Vec::new(),
    };
    let safe_from = if probe.spoiled { None } else { of.safe_from()? };
    let beyond = |value: f64| safe_from.is_some_and(|from| (value >= from) == above);
    let counted = |values: &[f64]| values.iter().filter(|value| beyond(**value)).count();
    let scanned: Vec<f64> = of.free.iter().map(|(value, _)| *value).collect();
    let reason = match safe_from {
        Some(_) => None,
        None => Some((probe.hindrance)(safe_end)?),
    };
    let mut advice = Advice {
        safe_from,
        until: safe_end,
        by_rule: counted(&of.asked),
        by_nominal_runs: counted(&scanned) + counted(&of.looked_at),
        reason,
        text: String::new(),
    };
    advice.text = text(&advice, quantity, range);
    Ok(advice)
}

impl AdviceSearch<'_> {
    fn safe_from(&mut self) -> Result<Option<f64>, Error> {
        let mut passing = self.nominal_passes()?;
        let members = self.probe.with_members;
        if members && let Some(last) = self.last_with_ensemble(&passing)? {
            passing.truncate(last + 1);
        } else if members {
            passing.clear();
        }
        // The digits that it deserves, to the safe side; which is a value of its own to ask.
        while let Some(place) = passing.pop() {
            let value = self.rounded(self.free[place].0);
            if !(self.passes(value)? && self.checked(&passing)?) {
                continue;
            }
            match self.top_without_pass(place)? {
                Some(top) => passing.retain(|place| *place < top),
                None => return Ok(Some(value)),
            }
        }
        Ok(None)
    }

    /// Asks the rule without an ensemble from the safe end on until it is no pass, or a lever is so
    /// sensitive that it may be none at a value nearby; returns the places of the values that pass.
    fn nominal_passes(&mut self) -> Result<Vec<usize>, Error> {
        let mut passing = Vec::new();
        let mut in_doubt = false;
        let side_by_side = if self.probe.long { 1 } else { SIDE_BY_SIDE };
        'way: for places in self.places().chunks(side_by_side) {
            let values: Vec<f64> = places.iter().map(|place| self.free[*place].0).collect();
            for (index, found) in (self.probe.nominal)(&values)?.into_iter().enumerate() {
                in_doubt |= found.in_doubt;
                if !found.passes || found.sensitive {
                    break 'way;
                }
                self.asked.push(values[index]);
                passing.push(places[index]);
            }
        }
        // Where readings were seen to disagree, or the peak jumps, they may do so at any value.
        let threshold = self.probe.threshold_rad;
        let peak = |(_, excess): &(f64, Excess)| excess.pass + threshold;
        let in_danger = |point: &(f64, Excess)| self.is_in_danger(peak(point));
        let jumps = |pair: &[(f64, Excess)]| {
            let (a, b) = (peak(&pair[0]), peak(&pair[1]));
            pair.iter().any(in_danger) && (a - b).abs() > JUMP * a.max(b)
        };
        in_doubt |= self.free.windows(2).any(jumps);
        if in_doubt && let Some(first) = self.free.iter().position(in_danger) {
            passing.retain(|place| *place < first);
        }
        if let Some(changed) = self.first_doubtful_change(passing.last().copied())? {
            passing.retain(|place| *place < changed);
        }
        Ok(passing)
    }

    /// Tells whether a peak would be no pass where readings of the samples disagree.
    fn is_in_danger(&self, peak_rad: f64) -> bool {
        (1.0 + DIFFERING_TIMES) * peak_rad > ROOM * self.probe.threshold_rad
    }

    /// Tells whether a peak may be another one altogether on another reading of the samples.
    fn may_differ(&self, peak_rad: f64) -> bool {
        peak_rad > DIFFERING_PART * self.probe.threshold_rad
    }

    /// Returns the first place, as far as `last`, before which the rule is no pass where a nominal
    /// lever that moves begins to come to its peak otherwise. Readings of the samples disagree
    /// about where that is, in a band that may be too narrow for any search to hit; but the course on
    /// its two sides differs, and that is seen.
    fn first_doubtful_change(&self, last: Option<usize>) -> Result<Option<usize>, Error> {
        let threshold = self.probe.threshold_rad;
        let danger = |(_, excess): &(f64, Excess)| self.may_differ(excess.pass + threshold);
        let (Some(first), Some(last)) = (self.free.iter().position(danger), last) else {
            return Ok(None);
        };
        let mut before: Option<Courses> = None;
        let mut changes = 0;
        for place in first.saturating_sub(1)..=last {
            let here = Courses::at(self, self.free[place].0)?;
            if let Some(before) = before.take()
                && let Some((from, to)) = self.change_of_course(before, here.clone())?
            {
                changes += 1;
                let both = |found: Vec<NominalPass>| found.iter().all(|of| of.passes);
                if changes > CHANGES_MAX || !both((self.probe.nominal)(&[from, to])?) {
                    return Ok(Some(place));
                }
            }
            before = Some(here);
        }
        Ok(None)
    }

    /// Returns two values close together between which the course changes: in the impacts before the
    /// peak; or in the peak's time, by a jump, which stays however close the values are.
    fn change_of_course(
        &self,
        mut from: Courses,
        mut to: Courses,
    ) -> Result<Option<(f64, f64)>, Error> {
        let moved = |from: &Courses, to: &Courses| self.moved(from, to).unwrap_or(f64::INFINITY);
        for _ in 0..HALVINGS {
            if moved(&from, &to) <= self.probe.apart_s {
                return Ok(None);
            }
            let middle = Courses::at(self, f64::midpoint(from.value, to.value))?;
            if moved(&from, &middle) > moved(&middle, &to) {
                to = middle;
            } else {
                from = middle;
            }
        }
        let changes = moved(&from, &to) > self.probe.apart_s;
        Ok(changes.then_some((from.value, to.value)))
    }

    /// Returns by how much the peak's time moves between two values [s], of the levers that matter
    /// the largest; `None` if the impacts before a peak are others.
    fn moved(&self, from: &Courses, to: &Courses) -> Option<f64> {
        let mut largest = 0.0_f64;
        for ((peak, course), (other_peak, other)) in from.levers.iter().zip(&to.levers) {
            if self.may_differ(peak.max(*other_peak)) {
                largest = largest.max(course.moved_s(other)?);
            }
        }
        Some(largest)
    }

    /// Places of the values to ask, from the safe end on, closer together towards the other.
    fn places(&self) -> Vec<usize> {
        let (Some(first), Some(last)) = (self.free.first(), self.free.last()) else {
            return Vec::new();
        };
        let (from, to) = (self.range.place(first.0), self.range.place(last.0));
        let asked = if self.probe.long { ASKED / 4 } else { ASKED };
        let mut places = Vec::with_capacity(asked + 1);
        for index in 0..=asked {
            let rest = 1.0 - index as f64 / asked as f64;
            let wanted = (rest * rest * (to - from)).abs();
            let before =
                |(value, _): &(f64, Excess)| (self.range.place(*value) - to).abs() >= wanted;
            places.push(self.free.partition_point(before).saturating_sub(1));
        }
        places.dedup();
        places
    }

    /// Returns the last of the values, counted from the safe end, that passes with an ensemble:
    /// from the other end back in steps that double, then by halves.
    fn last_with_ensemble(&mut self, passing: &[usize]) -> Result<Option<usize>, Error> {
        let mut fails = passing.len();
        let mut step = 1;
        let mut passes = loop {
            let Some(index) = passing.len().checked_sub(step) else {
                if fails == 0 || !self.passes_rounded(passing[0])? {
                    return Ok(None);
                }
                break 0;
            };
            if self.passes_rounded(passing[index])? {
                break index;
            }
            fails = index;
            step *= 2;
        };
        while fails - passes > 1 {
            let middle = usize::midpoint(passes, fails);
            if self.passes_rounded(passing[middle])? {
                passes = middle;
            } else {
                fails = middle;
            }
        }
        Ok(Some(passes))
    }

    /// Asks the rule where the nominal levers beyond a place come highest, the highest first: of the nominal
    /// levers, and with an ensemble at the first few. Returns the first place that is no pass. Between
    /// the values that are asked a lever may resonate with its bounces, and scattered levers cross there.
    fn top_without_pass(&mut self, last: usize) -> Result<Option<usize>, Error> {
        let threshold = self.probe.threshold_rad;
        let peak = |place: usize| self.free[place].1.pass + threshold;
        let mut tops: Vec<usize> = (1..last)
            .filter(|place| peak(*place) >= peak(place - 1) && peak(*place) > peak(place + 1))
            .filter(|place| peak(*place) > TOP_PART * threshold)
            .collect();
        tops.sort_by(|a, b| peak(*b).total_cmp(&peak(*a)));
        tops.truncate(TOPS);
        for (index, top) in tops.into_iter().enumerate() {
            let (value, highest_rad) = self.highest_near(top)?;
            let nominal = (self.probe.nominal)(&[value])?;
            let in_danger = self.is_in_danger(highest_rad);
            let held = |of: &NominalPass| of.passes && !of.sensitive && !(of.in_doubt && in_danger);
            if !nominal.iter().all(held) {
                return Ok(Some(top));
            }
            let with_members = self.probe.with_members && index < TOPS_WITH_MEMBERS;
            if with_members && !self.passes(value)? {
                return Ok(Some(top));
            }
            if !with_members && !self.asked.contains(&value) {
                self.asked.push(value);
            }
        }
        Ok(None)
    }

    /// Returns the value at which the nominal levers come highest next to a place, inside the range, and how
    /// high [rad].
    fn highest_near(&mut self, place: usize) -> Result<(f64, f64), Error> {
        if let Some(known) = self.highest[place] {
            return Ok(known);
        }
        let at = |place: usize| self.free[place].0;
        let mut values: Vec<f64> = search::inside(at(place - 1), at(place)).collect();
        values.extend(search::inside(at(place), at(place + 1)));
        let mut highest = self.free[place];
        for (value, excess) in values.iter().zip((self.probe.scan)(&values)?) {
            if excess.pass > highest.1.pass {
                highest = (*value, excess);
            }
        }
        self.looked_at.extend(values);
        let found = (highest.0, highest.1.pass + self.probe.threshold_rad);
        self.highest[place] = Some(found);
        Ok(found)
    }

    /// Asks the rule at some of the values that are safer yet, the nearest first.
    fn checked(&mut self, passing: &[usize]) -> Result<bool, Error> {
        if !self.probe.with_members {
            return Ok(true);
        }
        for step in 0..CHECKED {
            let Some(index) = passing.len().checked_sub(1 << step) else {
                break;
            };
            if !self.passes(self.free[passing[index]].0)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Asks the whole rule about a value of the scan, rounded as it would be advised.
    fn passes_rounded(&mut self, place: usize) -> Result<bool, Error> {
        self.passes(self.rounded(self.free[place].0))
    }

    fn passes(&mut self, value: f64) -> Result<bool, Error> {
        let mut known = self.known.iter();
        if let Some((_, passes)) = known.find(|(asked, _)| asked.to_bits() == value.to_bits()) {
            return Ok(*passes);
        }
        let passes = (self.probe.rule)(value, (ROOM, Some(MEMBERS_ASKED)), &mut self.cache)?;
        self.known.push((value, passes));
        if passes {
            self.asked.push(value);
        }
        Ok(passes)
    }

    /// Returns the value rounded to the safe side, within the range.
    fn rounded(&self, value: f64) -> f64 {
        let (low, high) = (self.range.low, self.range.high);
        if value <= 0.0 || !value.is_finite() {
            return value;
        }
        let exponent = libm::floor(libm::log10(value)) as i32;
        // A power of ten below one is not exact: its inverse is.
        let digits = DIGITS - 1 - exponent;
        let unit = libm::pow(10.0, f64::from(digits.abs()));
        let (times, over) = if digits >= 0 {
            (unit, 1.0)
        } else {
            (1.0, unit)
        };
        let whole = value * times / over;
        let whole = if self.quantity.is_safer_above() {
            whole.ceil()
        } else {
            whole.floor()
        };
        (whole * over / times).clamp(low, high)
    }
}

/// Says it in a sentence, with the present value.
fn text(advice: &Advice, quantity: Quantity, range: &SearchRange) -> String {
    let unit = match quantity.unit() {
        "" => String::new(),
        unit => format!(" {unit}"),
    };
    let title = quantity.title();
    let until = plain(advice.until, 3);
    let direction = if quantity.is_safer_above() {
        "up"
    } else {
        "down"
    };
    match (advice.safe_from, &advice.reason) {
        (Some(from), _) => format!(
            "Every {title} searched from {}{unit} {direction} to {until}{unit} passes: {} values by the rule with a tenth of the limit to spare, {} by the nominal lever; present: {}{unit}.",
            shortest(from),
            advice.by_rule,
            advice.by_nominal_runs,
            shortest(range.present),
        ),
        (None, reason) => format!(
            "No {title} was found from which on every value {direction} to {until}{unit} passes{}.",
            reason
                .as_ref()
                .map_or_else(String::new, |why| format!(": {why}"))
        ),
    }
}

impl Advice {
    /// Returns the advice where nothing was asked.
    pub(super) fn unasked(until: f64, reason: &str) -> Self {
        Self {
            safe_from: None,
            until,
            by_rule: 0,
            by_nominal_runs: 0,
            reason: Some(reason.into()),
            text: String::new(),
        }
    }
}
