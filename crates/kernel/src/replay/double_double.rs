//! The nominal replay once more in double-double arithmetic: where rounding alone is what a peak's stated error
//! consists of, it says how far that peak is off.
//!
//! A plain integrator of its own, without lanes, bounds or closed sums: a Taylor series a step, every impact and
//! contact entered at a root that Newton's method has placed to 31 digits, every bounce followed. It shares the
//! search for a first root with the kernel, and nothing else. Whatever it is not made for ends it without an answer,
//! and the stated error stays.

use super::{ErrorStatement, RunOptions, RunOutcome, Within, energy_j};
use crate::error::Error;
use crate::model::Design;
use crate::model::stop::StopModel;
use crate::numerics::polynomial;
use crate::signal::{CURVED, Pieces, Projection, Reading, STRAIGHT};
use twofloat::TwoFloat;

/// Coefficients of a step.
const ORDER: usize = 30;

/// What the last coefficients of a step may add to the angle [rad]: some digits of a double-double are left to it.
const TRUNCATION: f64 = 1e-32;

/// A bounce this slow [rad/s] on a pressed lever is rest.
const REST_SPEED: f64 = 1e-24;

/// A net acceleration of a lever at rest, relative to its preload, below which it is just leaving its stop.
const LEAVES: f64 = 1e-28;

/// Steps within one interval before it is given up.
const STEPS_PER_INTERVAL_MAX: u32 = 50_000;

/// Halvings of a step before it is given up.
const HALVINGS_MAX: u32 = 60;

/// A minimum above the stop, relative to the terms of its step, that doubles cannot tell from an impact.
const GRAZE: f64 = 1e-12;

/// What the error stated of a run in doubles is worth in double-doubles: their rounding is 10⁻¹⁶ of it, what the steps
/// neglect, at angles beyond 10⁻⁶ rad, below this.
const ROOM: f64 = 1e-10;

/// What a double can hold of an angle of one radian [rad].
const DOUBLE: f64 = 1e-15;

/// Steps of a replay in doubles that one of these costs, as limits count it.
const COST: u64 = 64;

/// How far the lever comes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heights {
    /// In the judged window [rad].
    pub peak_rad: f64,
    /// After it, without excitation [rad]; `None` where that was not asked for.
    pub coast_rad: Option<f64>,
}

/// Returns how far the lever of a design comes, computed in double-double arithmetic, and after the last judged
/// sample too if it `coasts`; `None` where that is not made for it: a catch, a second sensor, a state stated at the
/// start, a graze, more bounces than it follows, the end of what the run may take. With it what that cost, as limits
/// count it.
///
/// # Errors
///
/// [`Error::Stopped`].
pub fn heights<'a>(
    reading: impl Into<Reading<'a>>,
    design: &Design,
    options: &RunOptions,
    coasts: bool,
    within: &Within<'_>,
) -> Result<(Option<Heights>, u64), Error> {
    let reading = reading.into();
    let is_made_for = design.catch.is_none()
        && reading.second().is_none()
        && options.projection == Projection::ALIGNED
        && options.initial.is_none()
        && reading.signal().samples.len() >= 2;
    if !is_made_for {
        return Ok((None, 0));
    }
    let found = if reading.is_straight() {
        Replay::of(&reading.pieces::<STRAIGHT>(), design, options, within).run(coasts)
    } else {
        Replay::of(&reading.pieces::<CURVED>(), design, options, within).run(coasts)
    };
    within.control.check()?;
    Ok(found)
}

/// Replaces the stated errors of an event-driven run by what a replay in double-double arithmetic says of its peaks,
/// where that is less, or where the two contradict each other.
///
/// # Errors
///
/// As [`heights`].
pub fn narrow<'a>(
    outcome: &mut RunOutcome,
    reading: impl Into<Reading<'a>>,
    design: &Design,
    options: &RunOptions,
    within: &Within<'_>,
) -> Result<(), Error> {
    let run = &outcome.run;
    let stated = run.numerical_error_rad;
    let is_bounded = stated < f64::MAX;
    if outcome.broke_down || !is_bounded {
        return Ok(());
    }
    let coasts = run.coast_peak_angle_rad.is_some();
    let (heights, spent) = heights(reading, design, options, coasts, within)?;
    outcome.spent += spent;
    let Some(heights) = heights else {
        return Ok(());
    };
    let off = |found: f64, height: f64, stated: f64| {
        let difference = (found - height).abs();
        let off = difference + ROOM * stated + DOUBLE;
        // Where the two differ by more than the bound, one of them is wrong.
        if difference > stated {
            off
        } else {
            off.min(stated)
        }
    };
    let run = &mut outcome.run;
    run.numerical_error_rad = off(run.peak_angle_rad, heights.peak_rad, stated);
    run.error = ErrorStatement::Bound(run.numerical_error_rad);
    if let (Some(found), Some(height)) = (run.coast_peak_angle_rad, heights.coast_rad) {
        outcome.coast_error_rad = off(found, height, outcome.coast_error_rad);
    }
    Ok(())
}

/// How the lever moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// At rest on the rigid stop.
    Dwell,
    /// Off the stop.
    Flight,
    /// Pressed into the soft stop.
    Contact,
}

/// φ'' = −pressing − stiffness φ − damping φ' − b cos φ.
#[derive(Debug, Clone, Copy)]
struct Branch {
    pressing: TwoFloat,
    stiffness: TwoFloat,
    damping: TwoFloat,
}

/// What one lever does under one reading.
struct Replay<'a, const K: usize> {
    pieces: &'a Pieces<'a, K>,
    design: &'a Design,
    stop: StopModel,
    within: &'a Within<'a>,
    /// First and last judged sample.
    window: (usize, usize),
    free: Branch,
    contact: Branch,
    restitution: TwoFloat,
    /// m L/I0 with the sign that turns a recorded acceleration into the model's [1/m].
    gain: TwoFloat,
    interval: TwoFloat,
    phase: Phase,
    angle: TwoFloat,
    velocity: TwoFloat,
    sine: TwoFloat,
    cosine: TwoFloat,
    /// The lever leaves rest at an instant of no net torque.
    lifting: bool,
    /// Its highest angle is asked for.
    judging: bool,
    highest: TwoFloat,
    steps: u64,
    looked: u64,
}

/// A step: coefficients of angle [rad] and angular velocity [rad/s], sine and cosine, in powers of its part.
struct Series {
    angle: [TwoFloat; ORDER],
    velocity: [TwoFloat; ORDER],
    sine: [TwoFloat; ORDER],
    cosine: [TwoFloat; ORDER],
}

/// The stop's angle within a step.
#[derive(Debug, Clone, Copy)]
enum Event {
    /// It is not reached.
    None,
    /// It is reached at this part of the step.
    At(TwoFloat),
    /// That cannot be told.
    Unknown,
}

const ZERO: TwoFloat = TwoFloat::from_f64(0.0);
const ONE: TwoFloat = TwoFloat::from_f64(1.0);

impl<'a, const K: usize> Replay<'a, K> {
    fn of(
        pieces: &'a Pieces<'a, K>,
        design: &'a Design,
        options: &RunOptions,
        within: &'a Within<'a>,
    ) -> Self {
        let (lever, stop) = (&design.lever, &design.stop);
        let number = TwoFloat::from_f64;
        let inertia = number(lever.moment_of_inertia_kg_m2);
        let pressing = quotient(number(lever.preload_torque_nm), inertia);
        let square = TwoFloat::new_mul(stop.radius_m, stop.radius_m);
        let (stiffness, damping) = (
            number(lever.spring_stiffness_nm_per_rad),
            number(lever.pivot_damping_nm_s_per_rad),
        );
        let contact_stiffness = stiffness + square * stop.stiffness_n_per_m;
        let sign = options.opens_when.sign() * lever.unbalance_sign();
        let unbalance = TwoFloat::new_mul(lever.mass_kg, lever.center_of_mass_m.abs());
        let last = pieces.signal.samples.len() - 1;
        let (first, last) = options
            .window
            .map_or((0, last), |(from, to)| (from.min(last), to.min(last)));
        let (phase, angle) = match options.stop.yields() {
            false => (Phase::Dwell, ZERO),
            true => (
                Phase::Contact,
                -quotient(number(lever.preload_torque_nm), contact_stiffness),
            ),
        };
        let (sine, cosine) = turned(angle);
        Self {
            pieces,
            design,
            stop: options.stop,
            within,
            window: (first, last),
            free: Branch {
                pressing,
                stiffness: quotient(stiffness, inertia),
                damping: quotient(damping, inertia),
            },
            contact: Branch {
                pressing,
                stiffness: quotient(contact_stiffness, inertia),
                damping: quotient(damping + square * stop.damping_n_s_per_m, inertia),
            },
            restitution: number(stop.restitution),
            gain: quotient(unbalance, inertia) * sign,
            interval: quotient(ONE, number(pieces.signal.rate.hertz())),
            phase,
            angle,
            velocity: ZERO,
            sine,
            cosine,
            lifting: false,
            judging: false,
            highest: number(f64::NEG_INFINITY),
            steps: 0,
            looked: 0,
        }
    }

    /// Returns how far the lever comes, and what that cost.
    fn run(mut self, coasts: bool) -> (Option<Heights>, u64) {
        let heights = self.heights(coasts);
        (heights, COST * self.steps)
    }

    fn heights(&mut self, coasts: bool) -> Option<Heights> {
        let (first, last) = self.window;
        for index in 0..last {
            if index == first {
                self.judge();
            }
            if self.phase == Phase::Dwell && self.stays_pressed(index) {
                continue;
            }
            let terms = self.pieces.exact_terms(index).map(|a| self.gain * a);
            self.carry(&terms, self.interval)?;
        }
        if first >= last {
            self.judge();
        }
        let peak_rad = self.highest.hi();
        let coast_rad = if coasts { Some(self.coast()?) } else { None };
        Some(Heights {
            peak_rad,
            coast_rad,
        })
    }

    /// Tells whether an interval presses a lever at rest onto its stop, by far more than rounding.
    fn stays_pressed(&self, index: usize) -> bool {
        /// Part of the preload that is left as room.
        const CLEAR: f64 = 1e-6;
        let range = self.pieces.range(index);
        let [low, high] = [range.low, range.high].map(|a| self.gain.hi() * a);
        let pressing = self.free.pressing.hi();
        low.min(high) > -pressing * (1.0 - CLEAR)
    }

    fn judge(&mut self) {
        self.judging = true;
        self.highest = self.angle;
    }

    /// Moves on without excitation until the lever cannot rise above what it has reached since; returns that.
    fn coast(&mut self) -> Option<f64> {
        /// Longest stretch [s], and how many there are at most.
        const STRETCH: f64 = 5e-3;
        const STRETCHES_MAX: u32 = 200_000;
        self.judge();
        for _ in 0..STRETCHES_MAX {
            if self.phase == Phase::Dwell || self.cannot_rise() {
                return Some(self.highest.hi());
            }
            self.carry(&[ZERO; K], TwoFloat::from_f64(STRETCH))?;
        }
        None
    }

    fn cannot_rise(&self) -> bool {
        /// Energy of a compressed stop that throws no lever out [J]; the rest of rounding.
        const NOTHING_J: f64 = 1e-21;
        const ROUNDING: f64 = 1e-12;
        let energy = |angle: f64, velocity: f64| energy_j(self.design, self.stop, angle, velocity);
        let (best, now) = (
            self.highest.hi(),
            energy(self.angle.hi(), self.velocity.hi()),
        );
        if self.stop.yields() && best <= 0.0 {
            let Design { stop, lever, .. } = self.design;
            let least = energy(stop.rest_angle_rad(self.stop, lever), 0.0);
            return now - least <= NOTHING_J;
        }
        now <= energy(best, 0.0) * (1.0 - ROUNDING)
    }

    /// Carries the lever over an interval of which b is given in powers of its part [rad/s²].
    fn carry(&mut self, terms: &[TwoFloat; K], length: TwoFloat) -> Option<()> {
        let mut part = ZERO;
        for _ in 0..STEPS_PER_INTERVAL_MAX {
            self.steps += 1;
            if COST * self.steps > self.within.steps_max
                || self.within.ends(COST * self.steps, &mut self.looked)
            {
                return None;
            }
            part = match self.phase {
                Phase::Dwell => self.leave(terms, part)?,
                Phase::Flight | Phase::Contact => self.step(terms, length, part)?,
            };
            if part >= ONE {
                return Some(());
            }
        }
        None
    }

    /// Lets a lever at rest leave its stop within what is left of an interval; returns the part at which it does.
    fn leave(&mut self, terms: &[TwoFloat; K], part: TwoFloat) -> Option<TwoFloat> {
        let rest = ONE - part;
        let mut net = shifted(terms, part, rest);
        net[0] += self.free.pressing;
        let level = net[0].hi() / self.free.pressing.hi().max(f64::MIN_POSITIVE);
        if level < -LEAVES {
            // Pushed off by a jump of the excitation.
            self.phase = Phase::Flight;
            return Some(part);
        }
        let mut root = ZERO;
        if level > LEAVES {
            let mut doubles = [0.0; K];
            for (double, term) in doubles.iter_mut().zip(&net) {
                *double = term.hi();
            }
            let end = evaluate(&net, ONE);
            let guess = match polynomial::first_fall(&doubles, 1.0) {
                Some(guess) => guess,
                None if end >= ZERO => return Some(ONE),
                None => 1.0,
            };
            root = newton(&net, guess)?;
            if root >= ONE {
                return Some(ONE);
            }
        }
        if slope(&net, root) >= ZERO {
            return if level > LEAVES { None } else { Some(ONE) };
        }
        self.phase = Phase::Flight;
        self.lifting = true;
        Some(part + root * rest)
    }

    /// Takes a step in flight or contact within what is left of an interval; returns the part that it comes to.
    fn step(
        &mut self,
        terms: &[TwoFloat; K],
        length: TwoFloat,
        part: TwoFloat,
    ) -> Option<TwoFloat> {
        let mut step = ONE - part;
        let pressed = self.free.pressing + evaluate(terms, part) * self.cosine;
        if self.phase == Phase::Flight && self.angle == ZERO && !self.lifting && pressed > ZERO {
            // A bounce that is over soon: its end lies in the middle of the step.
            let flight = 4.0 * self.velocity.hi() / (pressed.hi() * length.hi());
            step = step.min(TwoFloat::from_f64(flight));
        }
        let mut series = None;
        for _ in 0..HALVINGS_MAX {
            let taken = self.series(terms, length, part, step);
            if taken.is_short() {
                series = Some(taken);
                break;
            }
            step *= 0.5;
        }
        let series = series?;
        let (is_event, reached) = match self.event(&series) {
            Event::At(root) => (true, root),
            Event::None => (false, ONE),
            Event::Unknown => return None,
        };
        self.note_turns(&series, reached.hi());
        self.lifting = false;
        self.angle = evaluate(&series.angle, reached);
        self.velocity = evaluate(&series.velocity, reached);
        self.sine = evaluate(&series.sine, reached);
        self.cosine = evaluate(&series.cosine, reached);
        let ends = !is_event && part + step >= ONE;
        let came = part + reached * step;
        if is_event {
            (self.angle, self.sine, self.cosine) = (ZERO, ZERO, ONE);
            self.meet(terms, came);
        }
        if self.judging {
            self.highest = self.highest.max(self.angle);
        }
        Some(if ends { ONE } else { came.min(ONE) })
    }

    /// The lever is at its stop's angle.
    fn meet(&mut self, terms: &[TwoFloat; K], part: TwoFloat) {
        self.phase = match (self.stop.yields(), self.phase) {
            (false, _) => {
                self.velocity = -(self.velocity * self.restitution);
                let pressed = self.free.pressing + evaluate(terms, part);
                match self.velocity.hi() < REST_SPEED && pressed > ZERO {
                    true => {
                        self.velocity = ZERO;
                        Phase::Dwell
                    }
                    false => Phase::Flight,
                }
            }
            (true, Phase::Contact) => Phase::Flight,
            (true, _) => Phase::Contact,
        };
    }

    /// Returns the series of a step from `part` of an interval over a further `step` of it.
    fn series(
        &self,
        terms: &[TwoFloat; K],
        length: TwoFloat,
        part: TwoFloat,
        step: TwoFloat,
    ) -> Series {
        let branch = match self.phase {
            Phase::Contact => &self.contact,
            _ => &self.free,
        };
        let time = length * step;
        let mut push = shifted(terms, part, step);
        if self.lifting {
            push[0] = -self.free.pressing;
        }
        let mut series = Series {
            angle: [ZERO; ORDER],
            velocity: [ZERO; ORDER],
            sine: [ZERO; ORDER],
            cosine: [ZERO; ORDER],
        };
        series.angle[0] = self.angle;
        series.velocity[0] = self.velocity;
        series.sine[0] = self.sine;
        series.cosine[0] = self.cosine;
        for n in 0..ORDER - 1 {
            let next = (n + 1) as f64;
            let mut torque =
                branch.stiffness * series.angle[n] + branch.damping * series.velocity[n];
            if n == 0 {
                torque += branch.pressing;
            }
            for (j, push) in push.iter().enumerate().take(n + 1) {
                torque += *push * series.cosine[n - j];
            }
            let (mut sine, mut cosine) = (ZERO, ZERO);
            for j in 0..=n {
                sine += series.cosine[j] * series.velocity[n - j];
                cosine -= series.sine[j] * series.velocity[n - j];
            }
            let over = time / next;
            series.angle[n + 1] = over * series.velocity[n];
            series.velocity[n + 1] = -(over * torque);
            series.sine[n + 1] = over * sine;
            series.cosine[n + 1] = over * cosine;
        }
        series
    }

    /// Looks for the part of a step at which the lever comes to its stop's angle.
    fn event(&self, series: &Series) -> Event {
        let side = match self.phase {
            Phase::Contact => -1.0,
            _ => 1.0,
        };
        let doubles = series.doubles(side);
        // A start on the stop is a known root; it is divided out.
        let Some(skip) = doubles.iter().position(|c| *c != 0.0) else {
            return Event::None;
        };
        if doubles[skip] < 0.0 {
            return Event::Unknown;
        }
        let guess = polynomial::first_fall(&doubles[skip..], 1.0);
        let end = side * evaluate(&series.angle, ONE);
        let guess = match guess {
            Some(guess) => guess,
            None if end < ZERO => 1.0,
            None if self.phase == Phase::Flight && self.grazes(&doubles[skip..]) => {
                return Event::Unknown;
            }
            None => return Event::None,
        };
        match newton(&series.angle[skip..], guess) {
            Some(root) if root <= ONE => Event::At(root),
            Some(_) => Event::None,
            None => Event::Unknown,
        }
    }

    /// Tells whether the angle, divided by the powers that it begins with, turns as close to zero as doubles can tell.
    fn grazes(&self, doubles: &[f64]) -> bool {
        let size: f64 = doubles.iter().map(|c| c.abs()).sum();
        let mut lowest = f64::INFINITY;
        turns(doubles, 1.0, &mut |at, rises| {
            if rises {
                lowest = lowest.min(polynomial::evaluate(doubles, at));
            }
        });
        !self.stop.yields() && lowest < GRAZE * size
    }

    /// Keeps the highest angle at which the lever turns up to `reached`.
    fn note_turns(&mut self, series: &Series, reached: f64) {
        if !self.judging {
            return;
        }
        let mut highest = self.highest;
        turns(&series.doubles(1.0), reached, &mut |at, rises| {
            if !rises {
                highest = highest.max(evaluate(&series.angle, TwoFloat::from_f64(at)));
            }
        });
        self.highest = highest;
    }
}

impl Series {
    /// Tells whether what it leaves out is small enough.
    fn is_short(&self) -> bool {
        let tail = |c: &[TwoFloat; ORDER]| c[ORDER - 1].hi().abs() + c[ORDER - 2].hi().abs();
        // A velocity is worth its angle over a second; sine and cosine multiply what is no larger.
        [&self.angle, &self.velocity, &self.sine, &self.cosine]
            .into_iter()
            .all(|c| tail(c) <= TRUNCATION)
    }

    fn doubles(&self, side: f64) -> [f64; polynomial::CAPACITY] {
        let mut doubles = [0.0; polynomial::CAPACITY];
        for (double, c) in doubles.iter_mut().zip(&self.angle) {
            *double = side * c.hi();
        }
        doubles
    }
}

/// Visits where a polynomial turns up to `end`, with whether it rises from there.
fn turns(doubles: &[f64], end: f64, visit: &mut impl FnMut(f64, bool)) {
    let mut slope = [0.0; polynomial::CAPACITY];
    for (n, (slope, c)) in slope.iter_mut().zip(&doubles[1..]).enumerate() {
        *slope = (n + 1) as f64 * c;
    }
    polynomial::sign_changes(&slope[..doubles.len() - 1], end, &mut |at, rises| {
        visit(at, rises);
        true
    });
}

fn evaluate(coefficients: &[TwoFloat], at: TwoFloat) -> TwoFloat {
    coefficients.iter().rev().fold(ZERO, |sum, c| sum * at + *c)
}

fn slope(coefficients: &[TwoFloat], at: TwoFloat) -> TwoFloat {
    let pairs = coefficients.iter().enumerate().skip(1).rev();
    pairs.fold(ZERO, |sum, (n, c)| sum * at + *c * n as f64)
}

/// Returns a quotient to all digits, by long division: that of the crate is good to those of a double alone.
fn quotient(of: TwoFloat, by: TwoFloat) -> TwoFloat {
    let first = of.hi() / by.hi();
    let rest = of - by * first;
    let second = rest.hi() / by.hi();
    let rest = rest - by * second;
    TwoFloat::new_add(first, second) + rest.hi() / by.hi()
}

/// Returns the root of a polynomial next to a guess that is good to double precision; `None` where it does not settle.
fn newton(coefficients: &[TwoFloat], guess: f64) -> Option<TwoFloat> {
    /// Steps, each of which doubles the digits.
    const STEPS: u32 = 6;
    /// Change at which it has settled, relative to the place.
    const SETTLED: f64 = 1e-26;
    let mut at = TwoFloat::from_f64(guess);
    for _ in 0..STEPS {
        let change = quotient(evaluate(coefficients, at), slope(coefficients, at));
        at -= change;
        if change.hi().abs() <= SETTLED * at.hi().abs() {
            return Some(at);
        }
    }
    None
}

/// Returns the coefficients of a polynomial from `part` on in powers of the part of a further `step`.
fn shifted<const K: usize>(terms: &[TwoFloat; K], part: TwoFloat, step: TwoFloat) -> [TwoFloat; K] {
    let mut c = *terms;
    for first in 0..K - 1 {
        for n in (first..K - 1).rev() {
            let above = c[n + 1];
            c[n] += part * above;
        }
    }
    let mut power = ONE;
    for c in &mut c {
        *c *= power;
        power *= step;
    }
    c
}

/// Returns sine and cosine of a small angle [rad].
fn turned(angle: TwoFloat) -> (TwoFloat, TwoFloat) {
    /// Terms of both together: an angle of one radian needs 28.
    const TERMS: u32 = 40;
    let (mut sine, mut cosine, mut term) = (ZERO, ZERO, ONE);
    for n in 0..TERMS {
        match n % 4 {
            0 => cosine += term,
            1 => sine += term,
            2 => cosine -= term,
            _ => sine -= term,
        }
        term *= angle / f64::from(n + 1);
    }
    (sine, cosine)
}
