//! The bounds on a rigid stop.
//!
//! The bound on the energy is kept as a speed W, √(2E/I0) while the lever rises and the larger
//! of R √(2E/I0) and √(2V/I0) while it falls, V being what spring and preload hold at its
//! angle: continuous over impacts, and growing at most by mL/I0 times the opening acceleration
//! plus R times the holding one. Numbers in comments are those of `docs/screens.md`.

use super::arc::{self, Arc, LowerSolution};
use super::{Measured, Seen, Subject, Terms, areas, together};

/// Runs over the samples once.
pub(super) fn measure(
    terms: &Terms,
    subject: &Subject,
    seen: &Seen,
    only_decide: bool,
) -> Measured {
    let (angle, velocity) = subject.initial.unwrap_or((0.0, 0.0));
    if angle < 0.0 {
        return Measured::default();
    }
    let (first, last) = seen.window(subject);
    let mut pass = RigidPass::new(terms, subject, seen, first);
    if angle > 0.0 || velocity.abs() > 0.0 {
        pass.start(angle, velocity);
    }
    let from_rest = pass.moving.is_none();
    pass.judge(0);
    let mut index = 0;
    let mut from = seen.at(0);
    while index < last {
        if pass.moving.is_none() {
            let still = pass.pressed(seen, index, last);
            if still > index {
                pass.skip(index, still);
                index = still;
                from = seen.at(index);
                continue;
            }
        }
        let to = seen.at(index + 1);
        pass.interval(index, from, to);
        index += 1;
        from = to;
        if pass.fails || (only_decide && pass.hopeless()) {
            break;
        }
    }
    if !pass.fails {
        pass.end();
    }
    let opening = (from_rest && !only_decide).then(|| {
        (0..=last)
            .map(|index| -seen.at(index))
            .fold(0.0, |most: f64, a| if a <= most { most } else { a })
    });
    pass.measured(opening)
}

/// What is known at the sample that has been reached.
struct RigidPass<'a> {
    terms: &'a Terms,
    /// Weight of a holding acceleration in W.
    holding: f64,
    quiet_rule: Option<QuietRule>,
    arc: Option<Arc>,
    first: usize,
    /// Nothing while the lever certainly rests on its stop.
    moving: Option<Moving>,
    /// Largest bound so far on the speed that tells how far the lever gets, and whether each
    /// stayed below the limit.
    energy: f64,
    energy_holds: bool,
    /// The same by the impulse alone, from the first release to the record's end.
    impulse: f64,
    released: bool,
    lower: f64,
    fails: bool,
    /// No angle beyond the threshold before the window, proven.
    clean_before: bool,
}

/// What is known of a lever that may be off its stop.
struct Moving {
    /// Gain of W since the start, G.
    gained: f64,
    /// Largest of W − gain over the instants at which the first rise may have ended.
    turned: f64,
    rise: Option<Rise>,
    lower: Option<LowerSolution>,
    quiet: Option<Quiet>,
}

/// The first rise: angle and velocity are at most those of the comparison.
struct Rise {
    upper: (f64, f64),
    /// Angle and velocity are at least these.
    lower: (f64, f64),
    /// Bound on the speed √(2E/I0).
    speed: f64,
    elapsed: f64,
    /// What the terms of the velocity add up to, for the rounding.
    size: f64,
    start_angle: f64,
}

/// A time of weak excitation, after which the lever rests.
struct Quiet {
    elapsed: f64,
    needed: f64,
}

/// What counts as weak, and what follows.
struct QuietRule {
    acceleration: f64,
    /// Least pressing angular acceleration under it.
    pressing: f64,
    /// Rest comes within 2/pressing times (W + γ φ(W) + this times W).
    bounces: f64,
}

impl QuietRule {
    /// (R7) Bounces shrink by R q, q² being the ratio of strongest to weakest pressing.
    fn of(terms: &Terms, restitution: f64, lift_off: f64) -> Option<Self> {
        /// Largest share of lift-off that counts as weak.
        const SHARE_MAX: f64 = 0.5;
        if restitution >= 1.0 || lift_off <= 0.0 {
            return None;
        }
        // The share for which R q lies half-way between R and 1.
        let wanted = 0.5 * (1.0 + restitution) / restitution.max(1e-3);
        let wanted = wanted * wanted;
        let share = ((wanted - 1.0) / (wanted + 1.0)).min(SHARE_MAX);
        let ratio = ((1.0 + share) / (1.0 - share)).sqrt();
        Some(Self {
            acceleration: share * lift_off,
            pressing: (1.0 - share) * terms.pressing,
            bounces: ratio / (1.0 - restitution * ratio),
        })
    }
}

impl<'a> RigidPass<'a> {
    fn new(terms: &'a Terms, subject: &Subject, seen: &Seen, first: usize) -> Self {
        let lift_off = subject.lever.lift_off_acceleration_m_s2();
        Self {
            terms,
            holding: subject.stop.restitution.max(terms.overhang),
            quiet_rule: QuietRule::of(terms, subject.stop.restitution, lift_off),
            arc: Arc::new(seen.interval_s, terms.damping, terms.stiffness),
            first,
            moving: None,
            energy: 0.0,
            energy_holds: true,
            impulse: 0.0,
            released: false,
            lower: 0.0,
            fails: false,
            clean_before: false,
        }
    }

    /// A lever that is let go at `angle` with `velocity`.
    fn start(&mut self, angle: f64, velocity: f64) {
        let potential = self.terms.speed_at(angle);
        let speed = together(velocity, potential);
        self.released = true;
        self.impulse = speed;
        let falling = velocity <= 0.0;
        // (R2) Falling, W counts what the next impact leaves.
        let restitution = self.holding;
        let turned = if falling {
            (restitution * speed).max(potential)
        } else {
            f64::NEG_INFINITY
        };
        self.energy = if falling { turned } else { potential };
        if angle > self.terms.threshold {
            self.energy_holds = false;
        }
        if falling && !self.terms.stays_below(turned, turned) {
            self.energy_holds = false;
        }
        self.moving = Some(Moving {
            gained: 0.0,
            turned,
            rise: (!falling).then_some(Rise {
                upper: (angle, velocity),
                lower: (angle, velocity),
                speed,
                elapsed: 0.0,
                size: velocity,
                start_angle: angle,
            }),
            lower: Some(LowerSolution {
                state: (angle, velocity),
                elapsed: 0.0,
                size: velocity.abs(),
                start_angle: angle,
                since: 0,
            }),
            quiet: None,
        });
    }

    /// Returns the sample up to which the net torque presses from sample `index` on.
    fn pressed(&self, seen: &Seen, index: usize, last: usize) -> usize {
        /// Samples looked at together, so that the compiler compares them side by side.
        const BLOCK: usize = 16;
        let terms = self.terms;
        let level = -terms.pressing * (1.0 - 2.0 * terms.slack) / terms.gain;
        let above = |a: &f64| seen.factor * a + seen.offset_m_s2 > level;
        let samples = &seen.samples[index..=last];
        let mut count = 0;
        for block in samples.chunks_exact(BLOCK) {
            if !block.iter().fold(true, |all, a| all & above(a)) {
                break;
            }
            count += BLOCK;
        }
        count += samples[count..].iter().take_while(|a| above(a)).count();
        index + count.saturating_sub(1)
    }

    /// Rest from sample `from` to sample `to`.
    fn skip(&mut self, from: usize, to: usize) {
        if (from..=to).contains(&self.first) {
            self.clean_before = self.energy_holds;
        }
    }

    fn hopeless(&self) -> bool {
        !self.energy_holds
            && self
                .moving
                .as_ref()
                .is_none_or(|moving| moving.lower.is_none())
    }

    /// Advances over the interval that starts at sample `index`.
    fn interval(&mut self, index: usize, from: f64, to: f64) {
        let terms = self.terms;
        let length = terms.interval;
        let (opening, holding) = areas(from, to, length);
        if self.moving.is_none() {
            // (R1) At rest while the net torque presses.
            let floor = terms.slack * terms.pressing;
            let before = terms.pressing + terms.gain * from;
            let after = terms.pressing + terms.gain * to;
            if before > floor && after > floor {
                self.judge(index + 1);
                return;
            }
            let located = before > floor && after < -floor;
            let (at, part) = if located {
                let part = length * (after / (after - before)).clamp(0.0, 1.0);
                (-terms.pressing / terms.gain, part)
            } else {
                (from, length)
            };
            let (opening, holding) = areas(at, to, part);
            self.released = true;
            self.impulse += terms.gain * (opening + holding);
            self.release(index, at, to, part, located);
            let gain = terms.gain * (opening + self.holding * holding);
            if let Some(moving) = &mut self.moving {
                moving.gained = gain;
            }
            self.account();
        } else {
            self.impulse += terms.gain * (opening + holding);
            self.rise(from, to, opening, holding);
            if let Some(moving) = &mut self.moving {
                moving.gained += terms.gain * (opening + self.holding * holding);
            }
            self.account();
            self.advance_lower(from, to);
            self.rest(from, to);
        }
        self.judge(index + 1);
    }

    /// The lever leaves rest: a straight line from `from` to `to` over `length`, the whole or the
    /// last part of the interval from sample `index`; `located` where the net torque vanishes
    /// at its start.
    fn release(&mut self, index: usize, from: f64, to: f64, length: f64, located: bool) {
        let terms = self.terms;
        let mut moving = Moving {
            gained: 0.0,
            turned: 0.0,
            rise: None,
            lower: None,
            quiet: None,
        };
        let arc = if length < terms.interval {
            Arc::new(length, terms.damping, terms.stiffness)
        } else {
            self.arc
        };
        if let Some(arc) = arc {
            let raised = 2.0 * terms.slack * terms.pressing;
            let most = |a: f64| terms.torque_at_most(a, terms.cosine) + raised;
            let upper = arc.advance((0.0, 0.0), most(from), most(to));
            let size = length * (most(from).abs().max(most(to).abs()) + terms.pressing);
            // (R5) The lever has risen all along if the torque at the highest angle that it can
            // have reached was positive.
            let reached = 0.5 * length * length * most(from).max(most(to)).max(0.0);
            let cosine = self.cosine_at(reached);
            let least = |a: f64| terms.torque_at_least(a, cosine);
            let lower = arc.advance((0.0, 0.0), least(from), least(to));
            // From a located release on φ ≤ F' t³/6, and the cosine takes from the torque F' t
            // less than its share F' t⁵ (p0 + F' t)/72 of it.
            let push = -(terms.pressing + terms.gain * to);
            let square = length * length;
            let share = push * square * square * (terms.pressing + push) / 72.0;
            let pushed_open = if located {
                share < 0.5
            } else {
                least(from) > 0.0 && least(to) > 0.0
            };
            let rises = pushed_open
                && lower.1 > terms.slack * size
                && arc::velocities_compare(length, terms.damping, terms.stiffness);
            if rises {
                moving.turned = f64::NEG_INFINITY;
                moving.rise = Some(Rise {
                    upper,
                    lower,
                    speed: terms.gain * areas(from, to, length).0,
                    elapsed: length,
                    size,
                    start_angle: 0.0,
                });
            }
            moving.lower = Some(LowerSolution {
                state: arc.advance(
                    (0.0, 0.0),
                    terms.torque_at_least(from, terms.cosine),
                    terms.torque_at_least(to, terms.cosine),
                ),
                elapsed: length,
                size,
                start_angle: 0.0,
                since: index,
            });
        }
        self.moving = Some(moving);
    }

    /// Least cosine of an angle from 0 to `angle`, and not beyond the threshold.
    fn cosine_at(&self, angle: f64) -> f64 {
        (1.0 - 0.5 * angle * angle).max(self.terms.cosine)
    }

    /// Advances the first rise over a whole interval.
    fn rise(&mut self, from: f64, to: f64, opening: f64, holding: f64) {
        let terms = self.terms;
        let Some(arc) = self.arc else {
            self.give_up_rise();
            return;
        };
        let Some(moving) = &mut self.moving else {
            return;
        };
        let Some(rise) = &mut moving.rise else {
            return;
        };
        let length = terms.interval;
        let elapsed = rise.elapsed + length;
        if !arc::velocities_compare(elapsed, terms.damping, terms.stiffness) {
            self.give_up_rise();
            return;
        }
        let most = (
            terms.torque_at_most(from, terms.cosine),
            terms.torque_at_most(to, terms.cosine),
        );
        let pull = most.0.max(most.1);
        let size = rise.size
            + length
                * (terms.gain * from.abs().max(to.abs())
                    + terms.pressing
                    + terms.stiffness * rise.upper.0.max(0.0));
        let doubt = terms.slack * (rise.start_angle + size * elapsed);
        // Highest angle in the interval, by its end's torque and speed.
        let highest = rise.upper.0
            + rise.upper.1.max(0.0) * length
            + 0.5 * length * length * pull.max(0.0)
            + doubt;
        let cosine = (1.0 - 0.5 * highest * highest).max(terms.cosine);
        let least = (
            terms.torque_at_least(from, cosine),
            terms.torque_at_least(to, cosine),
        );
        // (R6) The rise goes on where the least velocity stays positive all through.
        let fastest = rise.upper.1.max(0.0) + length * pull.max(0.0);
        let falls = least.0.min(least.1) - terms.damping * fastest - terms.stiffness * highest;
        let rises_on = rise.lower.1 + falls.min(0.0) * length > terms.slack * size;
        let gain = terms.gain * (opening + terms.overhang * holding);
        let speed = rise.speed + gain;
        // Farthest in this interval: by energy or by angle, whichever is known better.
        let by_angle = terms.speed_at(highest);
        let far = speed.min(by_angle);
        if !(terms.stays_below(speed, speed) || highest <= terms.threshold * (1.0 - terms.slack)) {
            self.energy_holds = false;
        }
        self.energy = self.energy.max(far);
        if !rises_on {
            // (R4) A turn here leaves W at most what the angle reached holds; by energy the
            // interval's gain counts once, before the turn or after it.
            let turned = rise.speed.min(by_angle) - moving.gained;
            if turned > moving.turned || turned.is_nan() {
                moving.turned = turned;
            }
        }
        rise.upper = arc.advance(rise.upper, most.0, most.1);
        rise.lower = arc.advance(rise.lower, least.0, least.1);
        rise.elapsed = elapsed;
        rise.size = size;
        if rise.upper.1 < -terms.slack * size {
            moving.rise = None;
            return;
        }
        let angle = rise.upper.0.max(0.0) + doubt;
        let velocity = rise.upper.1.max(0.0) + terms.slack * size;
        rise.speed = speed.min(together(velocity, terms.speed_at(angle)));
    }

    /// The comparison has run out: any instant may be a turn.
    fn give_up_rise(&mut self) {
        let Some(moving) = &mut self.moving else {
            return;
        };
        if let Some(rise) = moving.rise.take() {
            moving.turned = moving.turned.max(rise.speed - moving.gained);
        }
    }

    /// Holds W against the limit.
    fn account(&mut self) {
        let Some(moving) = &self.moving else {
            return;
        };
        if moving.turned > f64::NEG_INFINITY || moving.turned.is_nan() || moving.gained.is_nan() {
            let bound = moving.turned + moving.gained;
            let size = moving.gained + bound.abs();
            if !self.terms.stays_below(bound, size) {
                self.energy_holds = false;
            }
            self.energy = self.energy.max(bound);
        }
        if let Some(rise) = &moving.rise
            && rise.elapsed <= self.terms.interval
        {
            // The interval of the release itself.
            let far = rise.speed.min(self.terms.speed_at(rise.upper.0.max(0.0)));
            self.energy = self.energy.max(far);
            if !(self.terms.stays_below(rise.speed, rise.speed)
                || rise.upper.0 <= self.terms.threshold * (1.0 - self.terms.slack))
            {
                self.energy_holds = false;
            }
        }
    }

    fn advance_lower(&mut self, from: f64, to: f64) {
        let terms = self.terms;
        let (Some(moving), Some(arc)) = (&mut self.moving, self.arc) else {
            return;
        };
        let Some(lower) = &mut moving.lower else {
            return;
        };
        lower.elapsed += terms.interval;
        if !arc::angles_compare(lower.elapsed, terms.damping, terms.stiffness) {
            moving.lower = None;
            return;
        }
        lower.size += terms.interval
            * (terms.gain * from.abs().max(to.abs())
                + terms.pressing
                + terms.stiffness * lower.state.0.abs());
        lower.state = match &moving.rise {
            // (R6) As long as the first rise has not ended, its own comparison is the closer.
            Some(rise) if moving.turned <= f64::NEG_INFINITY => rise.lower,
            _ => arc.advance(
                lower.state,
                terms.torque_at_least(from, terms.cosine),
                terms.torque_at_least(to, terms.cosine),
            ),
        };
    }

    /// (R7) Weak excitation for long enough brings the lever to rest.
    fn rest(&mut self, from: f64, to: f64) {
        let (Some(rule), Some(moving)) = (&self.quiet_rule, &mut self.moving) else {
            return;
        };
        if !(self.energy_holds && from.abs().max(to.abs()) <= rule.acceleration) {
            moving.quiet = None;
            return;
        }
        let terms = self.terms;
        if let Some(quiet) = &mut moving.quiet {
            quiet.elapsed += terms.interval;
            if quiet.elapsed > quiet.needed {
                self.moving = None;
            }
            return;
        }
        // From the end of this interval on.
        let turned = moving.turned + moving.gained * (1.0 + terms.slack);
        let speed = moving
            .rise
            .as_ref()
            .map_or(turned, |rise| turned.max(rise.speed));
        let needed = 2.0 / rule.pressing
            * (speed + terms.damping * terms.reach(speed) + rule.bounces * speed);
        moving.quiet = Some(Quiet {
            elapsed: 0.0,
            needed: needed * (1.0 + 1e-6) + 1e-12,
        });
    }

    /// Holds what is known at sample `index` against window and threshold.
    fn judge(&mut self, index: usize) {
        if index == self.first {
            self.clean_before = self.energy_holds;
        }
        if index < self.first {
            return;
        }
        let terms = self.terms;
        if let Some(lower) = self
            .moving
            .as_ref()
            .and_then(|moving| moving.lower.as_ref())
        {
            let doubt = terms.slack * (lower.start_angle + lower.size * lower.elapsed);
            let angle = lower.state.0 - doubt;
            self.lower = self.lower.max(angle);
            // (R8) Before the window nothing may have crossed, or the crossing may lie there.
            if angle > terms.threshold * (1.0 + terms.slack)
                && (self.first == 0 || self.clean_before || lower.since >= self.first)
            {
                self.fails = true;
            }
        }
    }

    /// After the last sample nothing adds energy.
    fn end(&mut self) {
        let Some(moving) = &self.moving else {
            return;
        };
        if let Some(rise) = &moving.rise {
            if !self.terms.stays_below(rise.speed, rise.speed) {
                self.energy_holds = false;
            }
            self.energy = self.energy.max(rise.speed);
        }
    }

    fn measured(self, opening: Option<f64>) -> Measured {
        let terms = self.terms;
        let passes_energy = self.energy_holds && !self.fails;
        let passes_impulse = passes_energy && terms.stays_below(self.impulse, self.impulse);
        Measured {
            opening,
            impulse: Some(self.impulse),
            energy: Some(self.energy),
            lower: Some(self.lower),
            passes_static: passes_energy && opening.is_some() && !self.released,
            passes_impulse,
            passes_energy,
            fails: self.fails,
            peak_at_most: passes_energy
                .then(|| terms.reach(self.energy * (1.0 + terms.slack)) * (1.0 + terms.slack)),
        }
    }
}
