//! The bounds on a soft stop.
//!
//! While the lever is certainly in contact its motion is linear and known exactly; from the
//! first instant on at which it may have left, only its energy is followed, counted from that
//! of rest in the stop. Numbers in comments are those of `docs/screens.md`.

use super::arc::{self, Arc, LowerSolution};
use super::{Measured, Seen, Subject, Terms, areas, rounding, together};

/// Runs over the samples once.
pub(super) fn measure(
    terms: &Terms,
    subject: &Subject,
    seen: &Seen,
    only_decide: bool,
) -> Measured {
    let (first, last) = seen.window(subject);
    let stop = Contact::of(terms, subject);
    let (angle, velocity) = subject.initial.unwrap_or((-stop.rest, 0.0));
    let mut pass = SoftPass {
        terms,
        arc: Arc::new(seen.interval_s, terms.damping, terms.stiffness),
        first,
        speed: 0.0,
        lower: None,
        lowest: f64::NEG_INFINITY,
        holds: true,
        clean_before: false,
        fails: false,
    };
    let mut index = 0;
    let mut from = seen.at(0);
    let mut inside = stop.enter(angle, velocity);
    if inside.is_none() {
        pass.leave(&stop, 0, angle, velocity, 0.0);
    }
    pass.judge(0);
    while index < last {
        let to = seen.at(index + 1);
        if let Some(contact) = &mut inside
            && !contact.stays(&stop, from, to)
        {
            let (angle, velocity, doubt) = contact.state(&stop);
            pass.leave(&stop, index, angle, velocity, doubt);
            inside = None;
        }
        if inside.is_none() {
            pass.interval(&stop, from, to);
        }
        index += 1;
        from = to;
        pass.judge(index);
        if pass.fails || (only_decide && !pass.holds && pass.lower.is_none()) {
            break;
        }
    }
    if let Some(contact) = &inside {
        // Without excitation the energy of the last instant is the most there will be.
        let (angle, velocity, doubt) = contact.state(&stop);
        pass.speed = stop.speed(terms, angle, velocity) + doubt;
        pass.check();
    }
    let passes = pass.holds && !pass.fails;
    Measured {
        impulse: Some(pass.speed),
        lower: Some(pass.lowest),
        passes_impulse: passes,
        fails: pass.fails,
        peak_at_most: passes.then(|| stop.reach(terms, pass.speed)),
        ..Measured::default()
    }
}

/// How far the samples of one recording drive a lever in contact, per unit of g = mL/I0:
/// y'' + 2ξΩy' + Ω²y = −a, from rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ContactResponse {
    /// Least and largest deviation.
    pub(super) least: f64,
    pub(super) most: f64,
    /// Largest deviation to either side, by (S2) alone.
    pub(super) far: f64,
    /// √(y'² + Ω²y²) at the last sample.
    pub(super) end: f64,
}

/// Returns what the samples, as recorded, do to a lever in contact that swings so.
pub(super) fn response(seen: &Seen, frequency: f64, ratio: f64) -> ContactResponse {
    let turn = Turn::new(seen.interval_s, frequency, ratio);
    let [[ss, sf], [fs, ff]] = turn.matrix;
    let (period, spread) = (1.0 / frequency, (1.0 - ratio * ratio).sqrt());
    let (compliance, swing) = (period * period, period / spread);
    let slack = rounding(seen.samples.len());
    let bulge = 0.125 * turn.length * turn.length * frequency * (1.0 + 2.0 * ratio) / spread;
    let (mut angle, mut velocity, mut doubt) = (0.0_f64, 0.0, 0.0);
    let (mut least, mut most, mut far) = (0.0_f64, 0.0_f64, 0.0_f64);
    for pair in seen.samples.windows(2) {
        let (begin, end) = (pair[0], pair[1]);
        // (S1), (S2) and (S3), as for one lever.
        let slope = (end - begin) * turn.per_length;
        let lag = 2.0 * ratio * slope * compliance * period;
        let (from, to) = (lag - begin * compliance, lag - end * compliance);
        let drift = -slope * compliance;
        let (stiff, fast) = (frequency * (angle - from), velocity - drift);
        let square = fast * fast + 2.0 * ratio * stiff * fast + stiff * stiff;
        let measure = square.max(0.0).sqrt();
        doubt += slack * (measure + begin.abs().max(end.abs()) * period);
        let angle_end = to + (ss * stiff + sf * fast) * period;
        let beyond = bulge * measure + doubt * swing;
        let around = (measure + doubt) * swing;
        let (low, high) = (from.min(to) - around, from.max(to) + around);
        most = most.max((angle.max(angle_end) + beyond).min(high));
        least = least.min((angle.min(angle_end) - beyond).max(low));
        far = far.max(high.abs()).max(low.abs());
        (angle, velocity) = (angle_end, drift + fs * stiff + ff * fast);
        doubt *= turn.decay;
    }
    ContactResponse {
        least,
        most,
        far,
        end: together(velocity, frequency * angle) * (1.0 + slack) + 2.0 * doubt / spread,
    }
}

/// The stop's constants.
struct Contact {
    /// Ω = √((k0 + ks ls²)/I0) [rad/s]; damping ratio of the contact.
    frequency: f64,
    ratio: f64,
    /// δ = T0/(k0 + ks ls²) [rad].
    rest: f64,
    /// cs ls²/I0 [1/s].
    drag: f64,
    /// b = gain times acceleration.
    gain: f64,
    /// The sample interval as a whole, and in parts that are short against 1/Ω.
    whole: Turn,
    part: Turn,
    parts: u32,
    slack: f64,
    /// 1/Ω, √(1 − ξ²) and 1/(Ω √(1 − ξ²)).
    period: f64,
    spread: f64,
    swing: f64,
}

/// What a length of time does to a deviation (Ω y, y') from the moving balance.
struct Turn {
    length: f64,
    per_length: f64,
    matrix: [[f64; 2]; 2],
    decay: f64,
}

impl Turn {
    fn new(length: f64, frequency: f64, ratio: f64) -> Self {
        let phase = frequency * length;
        let damped = (1.0 - ratio * ratio).max(0.0).sqrt();
        let decay = libm::exp(-ratio * phase);
        let (sine, cosine) = libm::sincos(damped * phase);
        let across = sine / damped;
        Self {
            length,
            per_length: 1.0 / length,
            matrix: [
                [decay * (cosine + ratio * across), decay * across],
                [-decay * across, decay * (cosine - ratio * across)],
            ],
            decay,
        }
    }
}

/// Phase Ω h of a part of an interval [rad], and the most parts that one is cut into.
const PART_PHASE: f64 = 0.07;
const PARTS_MAX: f64 = 64.0;

impl Contact {
    fn of(terms: &Terms, subject: &Subject) -> Self {
        let (lever, stop) = (&subject.lever, &subject.stop);
        let inertia = lever.moment_of_inertia_kg_m2;
        let frequency = stop.contact_angular_frequency_rad_s(lever);
        let ratio = 0.5 * stop.contact_damping_nm_s_per_rad(lever) / (inertia * frequency);
        let parts = (frequency * terms.interval / PART_PHASE)
            .ceil()
            .clamp(1.0, PARTS_MAX);
        let spread = (1.0 - ratio * ratio).max(0.0).sqrt();
        Self {
            frequency,
            ratio,
            rest: -stop.rest_angle_rad(lever),
            drag: stop.damping_n_s_per_m * stop.radius_m * stop.radius_m / inertia,
            gain: terms.gain,
            whole: Turn::new(terms.interval, frequency, ratio),
            part: Turn::new(terms.interval / parts, frequency, ratio),
            parts: parts as u32,
            slack: terms.slack,
            period: 1.0 / frequency,
            spread,
            swing: 1.0 / (frequency * spread),
        }
    }

    /// A lever that starts in the stop at `angle` with `velocity`; nothing where its motion
    /// there is not followed.
    fn enter(&self, angle: f64, velocity: f64) -> Option<InContact> {
        (angle < 0.0 && self.ratio < 0.999 && self.whole.matrix[0][0].is_finite()).then_some(
            InContact {
                angle,
                velocity,
                doubt: 0.0,
            },
        )
    }

    /// √(2Ê/I0), Ê being the energy above that of rest [rad/s].
    fn speed(&self, terms: &Terms, angle: f64, velocity: f64) -> f64 {
        if angle < 0.0 {
            together(velocity, self.frequency * (angle + self.rest))
        } else {
            let free = terms.speed_at(angle);
            let stored = terms.pressing * self.rest;
            (velocity * velocity + free * free + stored).sqrt()
        }
    }

    /// The largest angle, zero or more, that energy of `speed` reaches.
    fn reach(&self, terms: &Terms, speed: f64) -> f64 {
        let square = speed * speed * (1.0 + 4.0 * self.slack) - terms.pressing * self.rest;
        terms.reach(square.max(0.0).sqrt()) * (1.0 + self.slack)
    }
}

/// A lever that is certainly in contact.
#[derive(Clone, Copy)]
struct InContact {
    angle: f64,
    velocity: f64,
    /// Bound on what cosine and rounding have added, in the measure of (S2) [rad/s].
    doubt: f64,
}

impl InContact {
    /// Advances over an interval if the lever certainly stays in contact all through it;
    /// else it stays where it is.
    fn stays(&mut self, stop: &Contact, from: f64, to: f64) -> bool {
        let mut ahead = *self;
        if ahead.stays_over(stop, &stop.whole, from, to) {
            *self = ahead;
            return true;
        }
        ahead = *self;
        let step = (to - from) / f64::from(stop.parts);
        for part in 0..stop.parts {
            let begin = from + step * f64::from(part);
            if !ahead.stays_over(stop, &stop.part, begin, begin + step) {
                return false;
            }
        }
        *self = ahead;
        true
    }

    fn stays_over(&mut self, stop: &Contact, turn: &Turn, from: f64, to: f64) -> bool {
        let Contact {
            frequency,
            ratio,
            period,
            ..
        } = *stop;
        let compliance = period * period;
        let (begin, end) = (stop.gain * from, stop.gain * to);
        let slope = (end - begin) * turn.per_length;
        // (S1) The particular solution under a ramp.
        let lag = 2.0 * ratio * slope * compliance * period;
        let balance = |push: f64| -stop.rest - push * compliance + lag;
        let drift = -slope * compliance;
        let (stiff, fast) = (
            frequency * (self.angle - balance(begin)),
            self.velocity - drift,
        );
        // (S2) y'² + 2ξΩ y y' + Ω² y² falls as e^(−2ξΩt), and is at least 1 − ξ² times Ω² y²
        // or y'².
        let measure = (fast * fast + 2.0 * ratio * stiff * fast + stiff * stiff)
            .max(0.0)
            .sqrt();
        let most = begin.abs().max(end.abs());
        let size = measure + frequency * stop.rest + most * period;
        let doubt = self.doubt + stop.slack * size;
        let swing = (measure + doubt) * stop.swing;
        let [[ss, sf], [fs, ff]] = turn.matrix;
        let (stiff_end, fast_end) = (ss * stiff + sf * fast, fs * stiff + ff * fast);
        let angle_end = balance(end) + stiff_end * period;
        // (S3) Between its ends the angle rises above both by no more than its curvature lets it.
        let curvature = frequency * measure * (1.0 + 2.0 * ratio) / stop.spread;
        let arched = self.angle.max(angle_end)
            + 0.125 * turn.length * turn.length * curvature
            + doubt * stop.swing;
        let highest = arched.min(balance(begin).max(balance(end)) + swing);
        let deepest = balance(begin).min(balance(end)) - swing;
        // (S4) What the cosine takes from the torque drives the deviation; twice what it adds
        // covers that the lever may be that much deeper itself.
        let added = turn.length * most * 0.5 * deepest * deepest;
        let added_swing = 2.0 * added * stop.swing;
        if !(highest + added_swing < 0.0 && added_swing <= 0.1 * deepest.abs()) {
            return false;
        }
        self.angle = angle_end;
        self.velocity = drift + fast_end;
        self.doubt = turn.decay * doubt + 2.0 * added;
        true
    }

    /// Angle, velocity and how far either may be off, the angle times Ω [rad/s].
    fn state(&self, stop: &Contact) -> (f64, f64, f64) {
        let doubt = 2.0 * self.doubt / stop.spread
            + stop.slack * (self.velocity.abs() + stop.frequency * self.angle.abs());
        (self.angle, self.velocity, doubt)
    }
}

/// What is known of a lever that may have left.
struct SoftPass<'a> {
    terms: &'a Terms,
    arc: Option<Arc>,
    first: usize,
    /// Bound on √(2Ê/I0).
    speed: f64,
    lower: Option<LowerSolution>,
    lowest: f64,
    holds: bool,
    clean_before: bool,
    fails: bool,
}

impl SoftPass<'_> {
    /// The lever may leave from sample `index` on.
    fn leave(&mut self, stop: &Contact, index: usize, angle: f64, velocity: f64, doubt: f64) {
        self.speed = stop.speed(self.terms, angle, velocity) + 2.0 * doubt;
        self.check();
        // (S6) The damper may pull while the stop relaxes, by no more than its way.
        let below = angle - doubt / stop.frequency;
        let pulled = stop.drag * (-below).max(0.0);
        self.lower = Some(LowerSolution {
            state: (below, velocity - doubt - pulled),
            elapsed: 0.0,
            size: velocity.abs() + pulled + doubt,
            start_angle: below.abs(),
            since: index,
        });
    }

    fn interval(&mut self, stop: &Contact, from: f64, to: f64) {
        let terms = self.terms;
        let (opening, holding) = areas(from, to, terms.interval);
        self.speed += terms.gain * (opening + holding);
        self.check();
        // (S7) The bound on the cosine holds as deep as the lever can be.
        let depth = stop.rest + self.speed / stop.frequency;
        let (Some(lower), Some(arc), true) = (&mut self.lower, self.arc, depth <= terms.threshold)
        else {
            self.lower = None;
            return;
        };
        lower.elapsed += terms.interval;
        if !arc::velocities_compare(lower.elapsed, terms.damping, terms.stiffness) {
            self.lower = None;
            return;
        }
        lower.size += terms.interval
            * (terms.gain * from.abs().max(to.abs())
                + terms.pressing
                + terms.stiffness * lower.state.0.abs());
        lower.state = arc.advance(
            lower.state,
            terms.torque_at_least(from, terms.cosine),
            terms.torque_at_least(to, terms.cosine),
        );
    }

    fn check(&mut self) {
        if !self.terms.stays_below(self.speed, self.speed) {
            self.holds = false;
        }
    }

    fn judge(&mut self, index: usize) {
        if index == self.first {
            self.clean_before = self.holds;
        }
        if index < self.first {
            return;
        }
        let terms = self.terms;
        if let Some(lower) = &self.lower {
            let doubt = terms.slack * (lower.start_angle + lower.size * lower.elapsed);
            let angle = lower.state.0 - doubt;
            self.lowest = self.lowest.max(angle);
            if angle > terms.threshold * (1.0 + terms.slack)
                && (self.first == 0 || self.clean_before || lower.since >= self.first)
            {
                self.fails = true;
            }
        }
    }
}
