//! A lever beside an inertia catch: two levers that never drive each other.
//!
//! Which of the two comes first, the lever to φb or the catch to ψb, decides whether the lever is stopped; a gate at
//! each angle ends a stretch there, exactly. Whoever cannot be influenced by the other goes first: below φb the
//! catch, beyond it the lever, which then stops the catch at ψb.

use super::body::{Body, begin, limited};
use super::catch_run::CatchRun;
use super::contact_fast::FastContact;
use super::ends::{Arrival, Ceiling};
use super::flight_fast::FastFlight;
use super::forcing::{Forcing, Polynomial};
use super::kernel::{Coasting, Kernel};
use super::recorder::Recorder;
use super::{Question, TracePoint};
use crate::model::catch::Catch;
use crate::model::stop::StopModel;
use crate::signal::{Mix, Pieces, STRAIGHT};

/// Standard deviations of a noise within which the two come together.
const TIE_DEVIATIONS: f64 = 2.0;

/// A lever and a catch.
pub(super) struct Pair<'a, const K: usize> {
    pieces: Pieces<'a, K>,
    interval: f64,
    /// Recorded acceleration to the model's.
    sign: f64,
    parts: Catch,
    lever: Kernel,
    catch: Kernel,
    lever_flight: Option<FastFlight>,
    catch_flight: Option<FastFlight>,
    pressed: Option<FastContact<K>>,
    /// The catch blocks the lever.
    engaged: bool,
    /// The lever is beyond the angle at which it can be stopped.
    beyond: bool,
    /// The catch stays where it is.
    locked: bool,
    /// The catch turned so close to its engagement angle that it may as well have passed it [s].
    grazed_s: Option<f64>,
    record: CatchRun,
}

impl<'a, const K: usize> Pair<'a, K> {
    pub(super) fn new(pieces: Pieces<'a, K>, question: &Question<'_>, parts: Catch) -> Self {
        let (options, design) = (question.options, question.design);
        let signal = pieces.signal;
        let sign = options.opens_when.sign() * design.lever.unbalance_sign();
        let interval = signal.rate.interval().seconds();
        let mut recorder = Recorder::peak_only();
        recorder.trace = options.trace.then(Vec::new);
        let mut catch = Kernel::of_parts(
            &parts.as_lever(),
            &parts.rest_stop(),
            StopModel::Rigid,
            None,
            options.tolerance_rad,
            recorder,
        );
        if !options.error_bound {
            catch = catch.without_error_bound();
        }
        if let Some(noise) = options.noise_m2_s3 {
            catch.carry_noise(noise);
        }
        catch.recorder.open_window(0.0, signal.start_s, 0.0);
        catch.recorder.point(signal.start_s, 0.0, 0.0);
        let lever = begin(signal.start_s, design, options);
        let [lever, catch] = [lever, catch].map(|kernel| limited::<K>(kernel, question));
        let (along, across) = (Mix::scaled(sign, 0.0), Mix::scaled(1.0, 0.0));
        let beyond = lever.angle > parts.lever_angle_rad;
        let mut pair = Self {
            lever_flight: FastFlight::new(&lever, interval, sign),
            catch_flight: FastFlight::new(&catch, interval, sign),
            pressed: FastContact::new(&lever, interval, along, across),
            pieces,
            interval,
            sign,
            parts,
            lever,
            catch,
            // A catch that need not move to block does so for ever.
            engaged: parts.engagement_angle_rad <= 0.0,
            locked: parts.engagement_angle_rad <= 0.0,
            beyond,
            grazed_s: None,
            record: CatchRun::default(),
        };
        pair.place_gates();
        pair
    }

    /// Sets what ends each body's flight.
    fn place_gates(&mut self) {
        let Catch {
            engagement_angle_rad: engagement,
            end_stop_angle_rad: end,
            lever_angle_rad: blocked,
            ..
        } = self.parts;
        let (lever, catch) = (&mut self.lever, &mut self.catch);
        (lever.ends.gate_below, lever.ends.above) = match (self.beyond, self.engaged) {
            (true, _) => (blocked, Ceiling::NONE),
            (false, true) => {
                let restitution = self.parts.engagement_restitution;
                (f64::NEG_INFINITY, Ceiling::stop(blocked, restitution))
            }
            (false, false) => (f64::NEG_INFINITY, Ceiling::gate(blocked)),
        };
        (catch.ends.gate_below, catch.ends.above) = match (self.engaged, self.beyond) {
            (true, _) if self.parts.reversible => {
                let restitution = self.parts.end_stop_restitution;
                (engagement, Ceiling::stop(end, restitution))
            }
            (true, _) => (engagement, Ceiling::gate(end)),
            (false, true) => {
                let restitution = self.parts.engagement_restitution;
                (f64::NEG_INFINITY, Ceiling::stop(engagement, restitution))
            }
            (false, false) => (f64::NEG_INFINITY, Ceiling::gate(engagement)),
        };
    }

    /// Where the lever leans on the engaged catch: carries the catch through whole samples that keep it there,
    /// and the lever at rest; returns how many.
    #[inline(always)]
    fn held_samples(&mut self, index: usize, stop_at: usize) -> usize {
        if !self.lever.is_held() {
            return 0;
        }
        let end = index + self.pressed_above(&self.lever, index, stop_at);
        if self.locked {
            return end - index;
        }
        if self.catch.is_held() {
            return self.pressed_above(&self.catch, index, end);
        }
        let flight = self.catch_flight.as_ref();
        flight.map_or(0, |flight| {
            flight.fly(&mut self.catch, &self.pieces, index, end)
        })
    }

    /// Returns how many samples certainly press a body onto what is above it.
    #[inline(always)]
    fn pressed_above(&self, body: &Kernel, index: usize, end: usize) -> usize {
        let letting_go = body.letting_go_acceleration();
        self.pieces.above(index, end, -self.sign, -letting_go)
    }

    /// Carries the lever through whole samples in which nothing happens to it; returns how many.
    #[inline(always)]
    fn lever_samples(&mut self, index: usize, stop_at: usize) -> usize {
        if self.lever.dwells() {
            let lift_off = self.lever.lift_off_acceleration();
            return self.pieces.above(index, stop_at, self.sign, lift_off);
        }
        let mut carried = 0;
        if let Some(flight) = &self.lever_flight {
            carried = flight.fly(&mut self.lever, &self.pieces, index, stop_at);
        }
        if carried == 0
            && let Some(pressed) = &self.pressed
        {
            carried = pressed.press(&mut self.lever, &self.pieces, index, stop_at);
        }
        carried
    }

    /// Carries the catch through samples in which the lever neither reaches φb nor returns to it.
    #[inline(always)]
    fn catch_samples(&mut self, index: usize, end: usize) {
        let mut index = index;
        while index < end && !self.locked {
            let mut carried = 0;
            if self.catch.dwells() {
                let lift_off = self.catch.lift_off_acceleration();
                carried = self.pieces.above(index, end, self.sign, lift_off);
            } else if self.catch.is_held() {
                carried = self.pressed_above(&self.catch, index, end);
            } else if let Some(flight) = &self.catch_flight {
                carried = flight.fly(&mut self.catch, &self.pieces, index, end);
            }
            if carried == 0 {
                let mut base = self.pieces.terms(index);
                for a in &mut base {
                    *a *= self.sign;
                }
                let time = self.pieces.signal.time_s(index);
                let stretch = self.catch.stretch(time, self.interval, &base, None);
                self.catch_over(&stretch);
                carried = 1;
            }
            index += carried;
        }
    }

    /// Carries the catch over a stretch, through its gates.
    fn catch_over<const J: usize>(&mut self, stretch: &Polynomial<J>) {
        let mut rest = *stretch;
        while rest.length() > 0.0 && !self.locked {
            let reached = self.catch.advance_over(&rest);
            self.note_graze(rest.time() + reached);
            if !self.catch.ends.at_gate {
                break;
            }
            self.catch_at_gate(rest.time() + reached);
            rest = rest.between(reached, rest.length());
        }
    }

    /// Keeps when the catch turned close to its engagement angle.
    fn note_graze(&mut self, time: f64) {
        if std::mem::take(&mut self.catch.ends.grazes_gate) {
            self.grazed_s.get_or_insert(time);
        }
    }

    /// The catch comes to its engagement angle, or, where it stays there, to its end stop.
    ///
    /// An engaged catch that moves up comes to a gate only at the end stop that keeps it: see
    /// [`Self::place_gates`].
    fn catch_at_gate(&mut self, time: f64) {
        if self.engaged && self.catch.velocity >= 0.0 {
            self.locked = true;
            self.record.locked_s = Some(time);
            return;
        }
        self.engaged = !self.engaged;
        if self.engaged {
            self.record.engaged_s.get_or_insert(time);
        }
        self.place_gates();
    }

    /// Carries both over an interval that starts at `time` and lasts `length` [s].
    fn carry<const J: usize>(&mut self, time: f64, length: f64, base: &[f64; J]) {
        /// Events of both within an interval before it is given up.
        const EVENTS_MAX: u32 = 100_000;
        let of_lever = self.lever.stretch(time, length, base, None);
        let of_catch = self.catch.stretch(time, length, base, None);
        let mut from = 0.0;
        for _ in 0..EVENTS_MAX {
            let (lever, catch) = (
                of_lever.between(from, length),
                of_catch.between(from, length),
            );
            from += if self.beyond {
                self.lever_first(&lever, &catch)
            } else {
                self.catch_first(&lever, &catch)
            };
            if from >= length || self.lever.stuck || self.catch.stuck {
                return;
            }
        }
        self.lever.stuck = true;
    }

    /// Beyond φb: the lever goes on to the end of the stretch or back to φb, then the catch to the same instant.
    fn lever_first<const J: usize>(&mut self, lever: &Polynomial<J>, catch: &Polynomial<J>) -> f64 {
        let reached = self.lever.advance_over(lever);
        self.catch_over(&catch.between(0.0, reached));
        if self.lever.ends.at_gate {
            let arrival = self.lever.arrival(lever.time() + reached);
            if !self.catch.is_held() {
                self.tie_if_close(&arrival);
            } else if arrival.velocity < 0.0 {
                // When the lever lets it go is as uncertain as the lever.
                let speed = -arrival.velocity;
                let delay = arrival.error / speed;
                let pushed = self
                    .catch
                    .acceleration_above(catch, reached.min(catch.length()));
                self.catch.sensitivity.add_velocity(pushed.abs() * delay);
                let deviation = pushed.abs() * arrival.deviation / speed;
                self.catch.sensitivity.add_noise(deviation);
            }
            self.catch.release_above();
            self.beyond = false;
            self.place_gates();
        }
        reached
    }

    /// Below φb: the catch goes on to the end of the stretch or to a gate, then the lever; where the lever finds
    /// φb free before, both stand at that instant instead.
    fn catch_first<const J: usize>(&mut self, lever: &Polynomial<J>, catch: &Polynomial<J>) -> f64 {
        let trace = self.catch.recorder.trace.take();
        let before = self.catch.clone();
        let points = trace.as_ref().map_or(0, Vec::len);
        self.catch.recorder.trace = trace;
        let mut reached = lever.length();
        if !self.locked {
            reached = self.catch.advance_over(catch);
            self.note_graze(catch.time() + reached);
        }
        let impacts = self.lever.ends.strikes;
        let came = self.lever.advance_over(&lever.between(0.0, reached));
        let time = lever.time() + came;
        if std::mem::take(&mut self.lever.ends.grazes_gate) {
            self.record.tie_s.get_or_insert(time);
        }
        if self.lever.ends.at_gate {
            self.record.lever_arrives_s.get_or_insert(time);
            self.record
                .lever_arrives_rad_s
                .get_or_insert(self.lever.velocity);
            let mut trace = self.catch.recorder.trace.take();
            if let Some(trace) = &mut trace {
                trace.truncate(points);
            }
            self.catch = before;
            self.catch.recorder.trace = trace;
            if !self.locked {
                self.catch.advance_over(&catch.between(0.0, came));
            }
            let arrival = self.lever.arrival(time);
            self.tie_if_close(&arrival);
            self.pass(time);
            return came;
        }
        if self.lever.ends.strikes > impacts {
            self.struck(impacts == 0, before, catch);
        }
        if self.catch.ends.at_gate && !self.locked {
            self.catch_at_gate(catch.time() + reached);
            if !self.engaged && self.lever.is_held() {
                self.slip(lever, reached);
            }
        }
        reached
    }

    /// The lever goes past φb.
    fn pass(&mut self, time: f64) {
        self.record.lever_passes_s.get_or_insert(time);
        self.beyond = true;
        self.place_gates();
    }

    /// The catch falls back from under a lever that rests on it.
    fn slip<const J: usize>(&mut self, lever: &Polynomial<J>, local: f64) {
        let (speed, error) = (self.catch.velocity.abs(), self.catch.angle_error());
        let pushed = self.lever.acceleration_above(lever, local).abs();
        self.lever.sensitivity.add_velocity(pushed * error / speed);
        let deviation = self.catch.sensitivity.deviation();
        self.lever.sensitivity.add_noise(pushed * deviation / speed);
        self.lever.release_above();
        self.pass(lever.time() + local);
    }

    /// The lever has met the engaged catch within a stretch, at the start of which the catch was `before`.
    fn struck<const J: usize>(&mut self, is_first: bool, before: Kernel, catch: &Polynomial<J>) {
        let Some(strikes) = self.lever.ends.new_strikes.take() else {
            return;
        };
        if is_first {
            self.record.lever_arrives_s.get_or_insert(strikes[0].time);
            self.record
                .lever_arrives_rad_s
                .get_or_insert(strikes[0].velocity);
        }
        self.record.stops = self.lever.ends.strikes;
        if self.locked {
            return;
        }
        // The catch has gone on: how close it was to letting the lever pass is seen where it was then. The first
        // strike may come just after it engaged, the last just before it falls back.
        let after = std::mem::replace(&mut self.catch, before);
        let mut from = 0.0;
        for strike in &strikes {
            let until = strike.time - catch.time();
            if until > from {
                self.catch.advance_over(&catch.between(from, until));
                from = until;
            }
            self.tie_if_close(strike);
        }
        self.catch = after;
    }

    /// Notes a tie where the catch is as close to its engagement angle as the errors are large when the
    /// lever comes to φb.
    fn tie_if_close(&mut self, arrival: &Arrival) {
        let away = (self.parts.engagement_angle_rad - self.catch.angle).abs();
        if !self.locked && away <= self.doubt(arrival) {
            self.record.tie_s.get_or_insert(arrival.time);
        }
    }

    /// Returns how uncertain the catch's angle is against the lever when that comes to φb [rad].
    fn doubt(&mut self, arrival: &Arrival) -> f64 {
        let speed = arrival.velocity;
        let errors = [self.catch.angle_error(), arrival.error];
        let noises = [self.catch.sensitivity.deviation(), arrival.deviation];
        let [of_catch, of_lever] = [0, 1].map(|body| errors[body] + TIE_DEVIATIONS * noises[body]);
        of_catch + of_lever * (self.catch.velocity / speed).abs()
    }
}

impl<const K: usize> Body for Pair<'_, K> {
    #[inline(always)]
    fn calm_samples(&mut self, index: usize, stop_at: usize) -> usize {
        let held = self.held_samples(index, stop_at);
        if held > 0 {
            return held;
        }
        let carried = self.lever_samples(index, stop_at);
        self.catch_samples(index, index + carried);
        carried
    }

    #[inline(always)]
    fn sample(&mut self, index: usize) {
        let mut base = self.pieces.terms(index);
        for a in &mut base {
            *a *= self.sign;
        }
        self.carry(self.pieces.signal.time_s(index), self.interval, &base);
        self.lever.stuck |= self.catch.stuck;
    }
}

impl<const K: usize> Coasting for Pair<'_, K> {
    fn lever(&mut self) -> &mut Kernel {
        &mut self.lever
    }

    fn carry_on(&mut self, time: f64, length: f64) {
        self.carry(time, length, &[0.0; STRAIGHT]);
        self.lever.stuck |= self.catch.stuck;
    }

    fn spent(&mut self) -> u64 {
        self.lever.work.counted() + self.catch.work.counted()
    }

    fn catch_run(&mut self) -> Option<(CatchRun, Vec<TracePoint>)> {
        let mut record = self.record;
        record.peak_angle_rad = self.catch.recorder.peak.angle.max(self.catch.angle);
        if record.lever_arrives_s.is_some() && record.tie_s.is_none() {
            record.tie_s = self.grazed_s;
        }
        let trace = self.catch.recorder.trace.take().unwrap_or_default();
        Some((record, trace))
    }
}
