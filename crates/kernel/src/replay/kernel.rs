//! The event-driven kernel: flight, contact, dwell and chatter of one lever.
//!
//! Between two samples the excitation is a polynomial and the motion smooth, so a short Taylor
//! step carries the lever to the end of the sample or to the next event, whichever comes
//! first. Nothing is tied to the sampling grid: a release is the first root of the excitation's
//! polynomial, an impact that of the step's, a sequence of ever smaller bounces ends at its
//! accumulation time.

use super::breakdown::Breakdown;
use super::catch_run::CatchRun;
use super::ends::{Arrival, Ceiling, Ends, Met, hit};
use super::forcing::{Forcing, Polynomial, SINE_ORDER, Sine};
use super::recorder::{COUNTED_SPEED, Peak, Recorder};
use super::sensitivity::{Sensitivity, Smooth, Smooths, StateMap};
use super::tangent::{Tangent, TangentStep};
pub(super) use super::taylor::PEAK_TRUNCATION;
use super::taylor::{
    AngleSlope, Branch, STEP_MAX, Start, StepExcitation, TaylorSeries, Tolerance, Turned,
};
use super::{State, TracePoint, Within, Work};
use crate::model::design::Design;
use crate::model::lever::Lever;
use crate::model::stop::{Stop, StopModel};
use crate::numerics::polynomial;
use crate::signal::STRAIGHT;

/// Coefficients of a flight step. Twelve orders keep the truncation of a 0.1 ms step of a
/// lever at 100 rad/s below 1e-17 rad.
const FLIGHT_ORDER: usize = 13;

/// Coefficients of a step in contact, where the stop's own frequency times a 0.1 ms step is
/// near one.
const CONTACT_ORDER: usize = 22;

/// Largest phase, stop's own frequency times the step, of a step in contact [rad]:
/// 1.25^21/21! is 2e-18.
const CONTACT_PHASE_MAX: f64 = 1.25;

/// Truncation of a step that is let pass, relative to the angle and its change: a tenth of
/// what rounding does to them.
const TRUNCATION: f64 = 1e-17;

/// The same under a polynomial of more than two terms; what a run that states its error lets pass is a tenth
/// of it and counts in the error.
pub(super) const CURVED_TRUNCATION: f64 = 1e-14;

/// Standard deviations of a noise within which a lever that passes its stop may graze it.
const GRAZE_DEVIATIONS: f64 = 3.0;

/// A bounce this slow [rad/s] on a pressed lever is rest, whatever the series says.
const SPEED_MIN: f64 = 1e-30;

/// Largest relative second-order term of the chatter's series for which its sum is taken in
/// closed form; the neglected third order is its square.
const CHATTER_TERM_MAX: f64 = 1e-6;

/// Times the sine and cosine are turned on before they are computed afresh, so that their
/// rounding does not add up.
const TURNS_MAX: u32 = 64;

/// Bounces within one sample before the kernel gives up.
const EVENTS_PER_SAMPLE_MAX: u32 = 200_000;

/// Steps that the damping of the stop may make of one sample before the kernel gives up: a stop in which
/// there are more is thousands of times as damped as one that takes all speed.
const DAMPED_STEPS_MAX: f64 = 2000.0;

/// Steps before the kernel gives up: so many, and so many more per sample. A lever that
/// bounces on a perfect stop for an hour would otherwise keep the machine for days.
const STEPS_MAX: (u64, u64) = (20_000_000, 16);

/// Angle [rad] that a step from rest may reach: the terms by which the cosine follows the
/// angle then are beyond double precision from order 14 on, where they would come next.
const FIRST_STEP_ANGLE: f64 = 1e-4;

/// How the lever moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// At rest on the rigid stop.
    Dwell,
    /// Off the stop.
    Flight,
    /// Pressed into the soft stop.
    Contact,
    /// At rest on the stop above.
    Held,
}

/// The next step of a flight.
enum FlightStep {
    /// It lasts so long [s].
    Flies(f64),
    /// There is none: the lever rests from this local time on [s].
    Rests(f64),
}

/// Bounces on a stop that a lever is pressed onto, from just after an impact on.
struct Bounces {
    /// v, away from the stop [rad/s].
    speed: f64,
    /// R [-].
    restitution: f64,
    /// α, towards the stop [rad/s²].
    pressed: f64,
    /// Its rate [rad/s³], and a bound on its second derivative [rad/s⁴].
    rate: f64,
    bend: f64,
    /// What the angle may change α by, at most [1/s²].
    stiffness: f64,
    /// γ [1/s].
    damping: f64,
}

impl Bounces {
    /// Returns the time until they end [s], to second order in v:
    /// 2v/(α(1−R)) · (1 − v/(1−R) · (2α'/(3α²) + γ/(3α))).
    fn time(&self) -> f64 {
        2.0 * self.speed / (self.pressed * (1.0 - self.restitution)) * (1.0 + self.second_order())
    }

    fn second_order(&self) -> f64 {
        self.speed / (1.0 - self.restitution)
            * (2.0 * -self.rate / (3.0 * self.pressed * self.pressed)
                - self.damping / (3.0 * self.pressed))
    }

    /// Tells whether the second order is below 1e-6, so that what is left out is below its square.
    fn are_short(&self) -> bool {
        let time = self.time();
        let bend = self.bend * time * time / self.pressed;
        let spring = self.stiffness * self.speed * self.speed / (self.pressed * self.pressed);
        self.second_order().abs() <= CHATTER_TERM_MAX
            && bend <= CHATTER_TERM_MAX * CHATTER_TERM_MAX
            && spring <= CHATTER_TERM_MAX * CHATTER_TERM_MAX
    }
}

/// One lever on one stop.
#[derive(Debug, Clone)]
pub(super) struct Kernel {
    stop: StopModel,
    free: Branch,
    contact: Branch,
    restitution: f64,
    /// m L/I0: base acceleration to angular acceleration [1/m].
    gain: f64,
    tolerance: Tolerance,
    phase: Phase,
    /// Angle [rad].
    pub(super) angle: f64,
    /// Angular velocity [rad/s].
    pub(super) velocity: f64,
    /// Sine and cosine of the angle, and how often they were turned on since they were
    /// computed afresh.
    turned: Turned,
    turns: u32,
    /// The lever has just left rest at the instant of zero net torque.
    lifting: bool,
    /// Carry the error along; a rerun for a comparison does not need it.
    bounds_error: bool,
    pub(super) sensitivity: Sensitivity,
    /// Standard deviation of the highest angle so far from the noise carried along [rad].
    pub(super) deviation: f64,
    /// Changes that are carried along, if anyone asks for them.
    pub(super) tangent: Option<Tangent>,
    /// Times the lever has come to rest on the rigid stop.
    pub(super) rests: u64,
    pub(super) recorder: Recorder,
    pub(super) work: Work,
    /// What ends its flight beside its own stop.
    pub(super) ends: Ends,
    /// Longest step in flight [s].
    flight_step_max: f64,
    /// Longest step in contact [s].
    contact_step_max: f64,
    steps_max: u64,
    /// Set when one sample held more events than any chatter can, the steps ran out, or the
    /// state left what a double can hold.
    pub(super) stuck: bool,
    /// Why it was set, where that is not that the steps ran out.
    pub(super) breakdown: Option<Breakdown>,
}

impl Kernel {
    /// Builds a lever in its initial state, or at rest.
    pub(super) fn new(
        design: &Design,
        stop: StopModel,
        initial: Option<State>,
        tolerance: Option<f64>,
        recorder: Recorder,
    ) -> Self {
        Self::of_parts(
            &design.lever,
            &design.stop,
            stop,
            initial,
            tolerance,
            recorder,
        )
    }

    /// The same of a lever and its stop.
    pub(super) fn of_parts(
        lever: &Lever,
        stop_of: &Stop,
        stop: StopModel,
        initial: Option<State>,
        tolerance: Option<f64>,
        recorder: Recorder,
    ) -> Self {
        let inertia = lever.moment_of_inertia_kg_m2;
        let pressing = lever.preload_torque_nm / inertia;
        let at_rest = State::new(stop_of.rest_angle_rad(stop, lever), 0.0);
        let (phase, state) = match (stop.yields(), initial) {
            (false, None) => (Phase::Dwell, at_rest),
            (true, None) => (Phase::Contact, at_rest),
            (true, Some(state)) if state.angle_rad < 0.0 => (Phase::Contact, state),
            (_, Some(state)) => (Phase::Flight, state),
        };
        let mut kernel = Self {
            stop,
            free: Branch {
                pressing,
                damping: lever.pivot_damping_nm_s_per_rad / inertia,
                stiffness: lever.spring_stiffness_nm_per_rad / inertia,
            },
            contact: Branch {
                pressing,
                damping: stop_of.contact_damping_nm_s_per_rad(lever) / inertia,
                stiffness: stop_of.contact_stiffness_nm_per_rad(lever) / inertia,
            },
            restitution: stop_of.restitution,
            gain: lever.unbalance_kg_m() / inertia,
            tolerance: Tolerance {
                absolute: tolerance.unwrap_or(0.0),
                relative: TRUNCATION,
            },
            phase,
            angle: state.angle_rad,
            velocity: state.velocity_rad_s,
            turned: Turned::of(state.angle_rad),
            turns: 0,
            lifting: false,
            bounds_error: true,
            sensitivity: Sensitivity::default(),
            deviation: 0.0,
            tangent: None,
            rests: 0,
            recorder,
            work: Work::default(),
            ends: Ends::NONE,
            flight_step_max: f64::INFINITY,
            contact_step_max: f64::INFINITY,
            steps_max: STEPS_MAX.0,
            stuck: false,
            breakdown: None,
        };
        // Over a longer step in contact the terms of the series grow before they fall, and a
        // truncation relative to their sum says nothing of the angle.
        let phase = CONTACT_PHASE_MAX / kernel.contact.stiffness.sqrt();
        kernel.flight_step_max = kernel.free.step_max();
        kernel.contact_step_max = kernel.contact.step_max().min(phase);
        if stop.yields() {
            // A static equilibrium computed in double precision is off by its rounding.
            kernel
                .sensitivity
                .event(&StateMap([[1.0, 0.0], [0.0, 1.0]]), state.angle_rad);
        }
        kernel
    }

    /// Allows the steps that a record of `samples` may need.
    pub(super) fn for_samples(mut self, samples: usize) -> Self {
        self.steps_max = STEPS_MAX.0 + STEPS_MAX.1 * samples as u64;
        self
    }

    /// Allows no more than this many steps, whatever the record.
    pub(super) fn at_most(&mut self, steps_max: u64) {
        self.steps_max = self.steps_max.min(steps_max);
    }

    /// Returns whether the steps ran out.
    pub(super) fn took_too_many(&self) -> bool {
        self.work.counted() > self.steps_max
    }

    /// Allows any number of steps: whoever drives the lever stops by himself.
    pub(super) fn for_ever(mut self) -> Self {
        self.steps_max = u64::MAX;
        self
    }

    /// Leaves the error's bound out: the run's stated error is then meaningless.
    pub(super) fn without_error_bound(mut self) -> Self {
        self.bounds_error = false;
        self
    }

    /// Tells whether the run states its error.
    pub(super) fn states_error(&self) -> bool {
        self.bounds_error
    }

    /// Carries a white noise of the base acceleration along with the error [m²/s³].
    pub(super) fn carry_noise(&mut self, noise: f64) {
        self.sensitivity = Sensitivity::with_noise(noise * self.gain * self.gain);
    }

    /// Lets this part of the motion pass in a step, which the stated error counts.
    pub(super) fn letting_pass(mut self, relative: f64) -> Self {
        self.tolerance.relative = self.tolerance.relative.max(relative);
        self
    }

    /// Lets [`PEAK_TRUNCATION`] pass in a step.
    pub(super) fn for_peak(mut self) -> Self {
        self.tolerance.relative = PEAK_TRUNCATION;
        self
    }

    /// Returns the state.
    pub(super) fn state(&self) -> State {
        State::new(self.angle, self.velocity)
    }

    /// Returns the coefficients off the stop.
    pub(super) fn free_branch(&self) -> &Branch {
        &self.free
    }

    /// Returns what turns a base acceleration into an angular one [1/m].
    pub(super) fn gain(&self) -> f64 {
        self.gain
    }

    /// Returns whether the lever is off the stop and in motion.
    pub(super) fn flies_free(&self) -> bool {
        self.phase == Phase::Flight && self.angle > 0.0 && !self.lifting && !self.stuck
    }

    /// Returns sine and cosine of the angle.
    pub(super) fn turned(&self) -> Turned {
        self.turned
    }

    /// Returns the truncation that a step lets pass.
    pub(super) fn tolerance(&self) -> Tolerance {
        self.tolerance
    }

    /// Puts a lever that flies free where it has got to [rad, rad/s], with sine and cosine.
    pub(super) fn put(&mut self, angle: f64, velocity: f64, turned: Turned) {
        self.angle = angle;
        self.velocity = velocity;
        self.turned = turned;
        self.turns = TURNS_MAX / 2;
    }

    /// Returns the coefficients in contact, if the stop yields.
    pub(super) fn contact_branch(&self) -> Option<&Branch> {
        self.stop.yields().then_some(&self.contact)
    }

    /// Returns whether the lever is in the soft stop, off φ = 0.
    pub(super) fn is_pressed(&self) -> bool {
        self.phase == Phase::Contact && self.angle < 0.0 && !self.stuck
    }

    /// Puts a lever in contact where it has got to [rad, rad/s].
    pub(super) fn put_pressed(&mut self, angle: f64, velocity: f64) {
        self.angle = angle;
        self.velocity = velocity;
        self.turned = Turned::ZERO.by(angle);
        self.turns = 0;
    }

    /// Takes in what steps in contact do to the error, of which `map` carries a deviation along.
    pub(super) fn take_pressed_error(&mut self, steps: &Smooths, map: &StateMap) {
        if self.bounds_error {
            self.settle_error();
            self.sensitivity
                .apply_together(steps, map, self.contact.pressing);
        }
    }

    /// Takes in what steps taken elsewhere do to the error.
    pub(super) fn take_error(&mut self, steps: &Smooths) {
        if self.bounds_error {
            self.sensitivity.smooths(steps);
            if self.sensitivity.is_full() {
                self.settle_error();
            }
        }
    }

    /// Returns a bound on the error of the angle within the next `time` [s] of free flight [rad].
    pub(super) fn error_soon(&mut self, time: f64) -> f64 {
        if !self.bounds_error {
            return 0.0;
        }
        /// Further from its stop a lever is not asked whether noise makes it graze [rad]: nearly every
        /// sample of a noisy recording would be.
        const GRAZED_MAX: f64 = 1e-4;
        self.settle_error();
        let error = self.sensitivity.angle_error_soon(time);
        if self.stop.yields() {
            return error;
        }
        let grazed = GRAZE_DEVIATIONS * self.sensitivity.deviation();
        error.max(grazed.min(GRAZED_MAX))
    }

    /// Returns whether the lever is at rest on the rigid stop.
    pub(super) fn dwells(&self) -> bool {
        self.phase == Phase::Dwell
    }

    /// Returns the acceleration, in the model's sign, below which a lever at rest leaves
    /// the rigid stop [m/s²].
    pub(super) fn lift_off_acceleration(&self) -> f64 {
        -self.free.pressing / self.gain
    }

    /// Returns the acceleration along, in the model's sign, above which a lever that rests on the stop above
    /// falls from it [m/s²].
    pub(super) fn letting_go_acceleration(&self) -> f64 {
        let Ceiling { angle, turned, .. } = self.ends.above;
        let level = self.free.pressing + self.free.stiffness * angle;
        -level / (self.gain * turned.cosine)
    }

    /// Advances over one sample interval that starts at `time` and lasts `length` [s], with the base
    /// acceleration along, and where there is one across, a polynomial of the part of it [m/s², model sign].
    pub(super) fn advance<const K: usize>(
        &mut self,
        time: f64,
        length: f64,
        base: &[f64; K],
        across: Option<&[f64; K]>,
    ) {
        // A lever on the face of its stop may leave it at once.
        let inside = self.phase == Phase::Contact && self.angle < 0.0;
        if inside && length > DAMPED_STEPS_MAX * self.contact.damped_step_max() {
            self.break_down(Breakdown::StopTooDamped);
            return;
        }
        self.pass::<_, FLIGHT_ORDER>(&self.stretch(time, length, base, across));
    }

    /// Returns the excitation of such an interval.
    pub(super) fn stretch<const K: usize>(
        &self,
        time: f64,
        length: f64,
        base: &[f64; K],
        across: Option<&[f64; K]>,
    ) -> Polynomial<K> {
        let scaled = |terms: &[f64; K]| terms.map(|term| term * self.gain);
        Polynomial {
            time,
            length,
            terms: scaled(base),
            across: across.map(scaled),
        }
    }

    /// Advances over a stretch to its end, or to a gate; returns the local time reached.
    pub(super) fn advance_over<const K: usize>(&mut self, stretch: &Polynomial<K>) -> f64 {
        self.ends.at_gate = false;
        self.pass::<_, FLIGHT_ORDER>(stretch)
    }

    /// Advances over a piece of a sine.
    pub(super) fn advance_sine(&mut self, sine: &Sine) {
        self.pass::<_, SINE_ORDER>(sine);
    }

    /// Advances over a stretch of smooth excitation, in flight by series of `N` coefficients.
    fn pass<F: Forcing, const N: usize>(&mut self, stretch: &F) -> f64 {
        let mut local = 0.0;
        let mut guard = 0;
        while local < stretch.length() && !self.ends.at_gate {
            local = match self.phase {
                Phase::Dwell => self.dwell(stretch, local),
                Phase::Held => self.held(stretch, local),
                Phase::Flight => self.flight::<F, N>(stretch, local),
                Phase::Contact => self.contact(stretch, local),
            };
            guard += 1;
            if guard > EVENTS_PER_SAMPLE_MAX {
                self.break_down(Breakdown::TooManyEvents);
                break;
            }
        }
        if !(self.angle.is_finite() && self.velocity.is_finite()) {
            self.break_down(Breakdown::NotFinite);
        } else if self.took_too_many() {
            self.stuck = true;
        }
        let end = if self.ends.at_gate {
            local
        } else {
            stretch.length()
        };
        let time = stretch.time() + end;
        self.recorder.point(time, self.angle, self.velocity);
        end
    }

    /// Rest on the stop above: leaves where the net torque changes sign. Returns the local time reached.
    fn held<F: Forcing>(&mut self, stretch: &F, local: f64) -> f64 {
        let (level, onto) = self.pressing_above(stretch);
        let (root, lifting) = if level + onto.at(local) < 0.0 {
            (local, false)
        } else {
            match onto.falls_below(level, local) {
                Some(root) => (root, true),
                None => return stretch.length(),
            }
        };
        self.release_above();
        self.lifting = lifting;
        let time = stretch.time() + root;
        self.recorder.point(time, self.angle, 0.0);
        root.min(stretch.length())
    }

    /// Lets a lever go that rests on a stop above, or did until now.
    pub(super) fn release_above(&mut self) {
        if self.phase == Phase::Held {
            self.phase = Phase::Flight;
            self.work.events += 1;
        }
    }

    /// Tells whether it rests on the stop above.
    pub(super) fn is_held(&self) -> bool {
        self.phase == Phase::Held
    }

    /// Returns what presses the lever onto what is above it: a constant and what is added to it [rad/s²].
    fn pressing_above<F: Forcing>(&self, stretch: &F) -> (f64, F) {
        let Ceiling { angle, turned, .. } = self.ends.above;
        let level = -self.free.pressing - self.free.stiffness * angle;
        (level, stretch.onto(turned.sine, turned.cosine))
    }

    /// Returns the angular acceleration of a lever at rest on what is above it [rad/s²].
    pub(super) fn acceleration_above<F: Forcing>(&self, stretch: &F, local: f64) -> f64 {
        let (level, onto) = self.pressing_above(stretch);
        level + onto.at(local)
    }

    /// The lever meets the stop above with `self.velocity` ≥ 0.
    fn strike<F: Forcing>(&mut self, stretch: &F, local: f64, restitution: f64) {
        let before = self.velocity;
        let time = stretch.time() + local;
        self.settle_error();
        self.work.events += 1;
        if before > COUNTED_SPEED {
            self.ends.strikes += 1;
            let strike = self.arrival(time);
            let first = self.ends.new_strikes.map_or(strike, |[first, _]| first);
            self.ends.new_strikes = Some([first, strike]);
        }
        if self.recorder.judging {
            self.recorder.peak.offer(self.angle, time, 0.0);
        }
        let (level, onto) = self.pressing_above(stretch);
        let pressed = level + onto.at(local);
        let after = -restitution * before;
        if after.abs() > SPEED_MIN {
            self.rebound(restitution, before, pressed, before * stretch.length());
            self.recorder.point(time, self.angle, after);
            return;
        }
        self.rest_above(pressed);
    }

    /// Returns how it comes, at `time` [s], to what is above it or to a gate.
    pub(super) fn arrival(&mut self, time: f64) -> Arrival {
        Arrival {
            time,
            velocity: self.velocity,
            error: self.angle_error(),
            deviation: self.sensitivity.deviation(),
        }
    }

    /// Puts the lever to rest on what is above it, where that presses it there.
    fn rest_above(&mut self, pressed: f64) {
        self.put_above(0.0);
        if pressed >= 0.0 {
            self.phase = Phase::Held;
            self.sensitivity.reset();
        }
    }

    /// Puts the lever on what is above it.
    fn put_above(&mut self, velocity: f64) {
        self.angle = self.ends.above.angle;
        self.turned = self.ends.above.turned;
        self.turns = 0;
        self.velocity = velocity;
    }

    /// Turns a lever round at a stop at which it would have the acceleration `drive` without damping [rad/s²];
    /// `place` is the size of the terms that placed the impact [rad].
    fn rebound(&mut self, restitution: f64, before: f64, drive: f64, place: f64) {
        let after = -restitution * before;
        let acceleration = |velocity: f64| drive - self.free.damping * velocity;
        let shear = (restitution * acceleration(before) + acceleration(after)) / before;
        let map = StateMap([[-restitution, 0.0], [shear, -restitution]]);
        if self.bounds_error {
            self.sensitivity.event(&map, place);
        }
        self.event_tangent(&map);
        self.velocity = after;
        self.phase = Phase::Flight;
    }

    /// Rest on the rigid stop: leaves where the net torque changes sign. Returns the local
    /// time reached.
    fn dwell<F: Forcing>(&mut self, stretch: &F, local: f64) -> f64 {
        if self.free.pressing + stretch.at(local) < 0.0 {
            // The torque jumped: at the first sample, or at the end of a chatter.
            self.lift_off(stretch, local, false);
            return local;
        }
        let Some(root) = stretch.falls_below(self.free.pressing, local) else {
            return stretch.length();
        };
        self.lift_off(stretch, root, true);
        root.min(stretch.length())
    }

    fn lift_off<F: Forcing>(&mut self, stretch: &F, local: f64, lifting: bool) {
        self.phase = Phase::Flight;
        self.set_on_stop(0.0);
        self.lifting = lifting;
        self.sensitivity.reset();
        self.rest_tangent();
        self.work.events += 1;
        self.recorder.release(stretch.time() + local);
        self.recorder.point(stretch.time() + local, 0.0, 0.0);
    }

    /// Flight to the end of the sample, the end of the series' reach, or what it meets first.
    fn flight<F: Forcing, const N: usize>(&mut self, stretch: &F, local: f64) -> f64 {
        if self.stays_at_an_end(stretch, local) {
            return local;
        }
        let step = match self.flight_step(stretch, local) {
            FlightStep::Rests(at) => return at,
            FlightStep::Flies(step) => step,
        };
        let start = Start {
            angle: self.angle,
            turned: self.turned,
            velocity: self.velocity,
            lifting: self.lifting,
        };
        self.lifting = false;
        let mut excitation = stretch.series(local, step);
        if start.lifting {
            let turning = stretch.across_at(local) * self.turned.sine;
            let pressing = self.free.pressing + self.free.stiffness * self.angle - turning;
            excitation.as_mut()[0] = -pressing / self.turned.cosine;
        }
        let across = stretch.across(local, step);
        let excitation = StepExcitation {
            along: excitation.as_ref(),
            across: across.as_ref().map_or(&[], AsRef::as_ref),
            count_min: F::COUNT_MIN,
        };
        let series = TaylorSeries::<N>::new(&self.free, &start, step, excitation, &self.tolerance);
        let reach = series.valid_part();
        if reach.is_nan() || reach <= 0.0 {
            return self.give_up(stretch);
        }
        let crossings = self.ends.crossings(&series, reach);
        let part = crossings.first().unwrap_or(reach);
        let met = crossings.met();
        if self.bounds_error {
            self.near_graze(&series, part, step, met == Some(Met::Stop));
            self.near_gates(&series, part, step, crossings.passes_a_gate());
        }
        self.take_in(&series, stretch, local, part, step, &start);
        let whole = part >= 1.0 && step >= stretch.length() - local;
        let reached = (local + part * step).min(stretch.length());
        match met {
            Some(Met::Stop) => {
                self.set_on_stop(self.velocity.min(0.0));
                self.land(stretch, reached);
            }
            Some(Met::GateBelow) => self.come_to_gate_below(),
            Some(Met::Above) => self.come_above(stretch, reached),
            None if whole => return stretch.length(),
            None => {
                let time = stretch.time() + reached;
                self.recorder.point(time, self.angle, self.velocity);
            }
        }
        reached
    }

    /// Tells whether a flight ends where it begins: on the stop, at what is above, or at a gate; what happens there
    /// has then happened.
    #[inline]
    fn stays_at_an_end<F: Forcing>(&mut self, stretch: &F, local: f64) -> bool {
        if self.angle <= 0.0 && !self.lifting {
            if !self.leaves(stretch, local) {
                self.land(stretch, local);
                return true;
            }
            // Known already but of a start on the stop.
            self.recorder.release(stretch.time() + local);
        }
        let (is_above, rises) = (self.angle >= self.ends.above.angle, self.velocity >= 0.0);
        if !is_above || self.lifting || !rises {
            return false;
        }
        match self.ends.above.restitution {
            // Pushed off at once: nothing holds it there.
            Some(_) if self.velocity <= 0.0 && self.acceleration_above(stretch, local) < 0.0 => {
                false
            }
            Some(restitution) => {
                self.strike(stretch, local, restitution);
                true
            }
            None => {
                self.ends.at_gate = true;
                true
            }
        }
    }

    /// Chooses the next step of a flight, which small bounces that sum up and a torque that comes back end at once.
    #[inline]
    fn flight_step<F: Forcing>(&mut self, stretch: &F, local: f64) -> FlightStep {
        let is_above = self.angle >= self.ends.above.angle;
        let slope = match is_above {
            true => self.pressing_above(stretch).1.slope_at(local),
            false => stretch.slope_at(local),
        };
        if self.lifting && slope >= 0.0 {
            // The torque vanished at the very end of a sample and comes back in the next.
            self.lifting = false;
            self.phase = if is_above { Phase::Held } else { Phase::Dwell };
            return FlightStep::Rests(local);
        }
        let mut step = (stretch.length() - local)
            .min(self.flight_step_max)
            .min(across_step_max(stretch))
            .min(stretch.step_max());
        if self.lifting || (self.angle <= 0.0 && self.velocity <= 0.0) {
            step = step.min(libm::cbrt(6.0 * FIRST_STEP_ANGLE / slope.abs()));
            let bend = stretch.bend();
            if !F::LONG && bend > 0.0 {
                step = step.min((24.0 * FIRST_STEP_ANGLE / bend).sqrt().sqrt());
            }
        }
        let pressed = self.free.pressing + stretch.at(local);
        if self.angle <= 0.0 && self.velocity > 0.0 && pressed > 0.0 {
            if let Some(rests_at) = self.chatter(stretch, local) {
                return FlightStep::Rests(rests_at);
            }
            // A small bounce: a step of a little more than its flight keeps the root well
            // inside the step.
            step = step.min(2.5 * self.velocity / pressed);
        }
        if is_above && self.velocity < 0.0 {
            let pressed = self.acceleration_above(stretch, local);
            if pressed > 0.0 {
                if let Some(rests_at) = self.chatter_above(stretch, local, pressed) {
                    return FlightStep::Rests(rests_at);
                }
                step = step.min(-2.5 * self.velocity / pressed);
            }
        }
        FlightStep::Flies(step)
    }

    /// The lever comes to the gate below.
    fn come_to_gate_below(&mut self) {
        self.angle = self.ends.gate_below;
        self.turned = Turned::of(self.angle);
        self.turns = 0;
        self.ends.at_gate = true;
    }

    /// The lever comes to what is above it.
    fn come_above<F: Forcing>(&mut self, stretch: &F, local: f64) {
        self.put_above(self.velocity.max(0.0));
        match self.ends.above.restitution {
            Some(restitution) => self.strike(stretch, local, restitution),
            None => self.ends.at_gate = true,
        }
    }

    /// Widens the error after a turn so close to the stop above that an impact could have been missed, or made,
    /// within the error of the angle; notes one so close to a gate.
    fn near_gates<const N: usize>(
        &mut self,
        series: &TaylorSeries<N>,
        part: f64,
        step: f64,
        hit: bool,
    ) {
        let (below, above) = (self.ends.gate_below, self.ends.above.angle);
        let turns = series.slope() * series.at(part).slope < 0.0;
        if hit || !turns || !(below.is_finite() || above.is_finite()) {
            return;
        }
        let error = self.angle_error().max(1e-15 * series.slope().abs());
        let grazed = GRAZE_DEVIATIONS * self.sensitivity.deviation();
        let reach = series.slope().abs() + series.curved.angle + error.max(grazed);
        let start = series.start();
        if start + reach < above && start - reach > below {
            return;
        }
        let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
        let (derivative, count) = series.derivative();
        polynomial::sign_changes(&derivative[..count], part, &mut |x, _| {
            let angle = series.at(x).angle;
            (lowest, highest) = (lowest.min(angle), highest.max(angle));
            true
        });
        let away = above - highest;
        let is_stop = self.ends.above.restitution.is_some();
        self.ends.grazes_gate |= lowest - below <= error.max(grazed);
        self.ends.grazes_gate |= !is_stop && away <= error.max(grazed);
        let Some(restitution) = self.ends.above.restitution else {
            return;
        };
        let curvature = 2.0 * series.bend().abs() / (step * step);
        let thrown = |height: f64| (1.0 + restitution) * (2.0 * curvature * height).sqrt();
        if away <= error {
            self.sensitivity.add_velocity(thrown(error));
        }
        if away <= grazed {
            self.sensitivity
                .add_noise(thrown(grazed) / GRAZE_DEVIATIONS);
        }
    }

    fn rest_tangent(&mut self) {
        if let Some(tangent) = &mut self.tangent {
            tangent.rest();
        }
    }

    fn event_tangent(&mut self, map: &StateMap) {
        if let Some(tangent) = &mut self.tangent {
            tangent.event(map);
        }
    }

    /// Follows the lever no further; the first reason stays.
    #[cold]
    fn break_down(&mut self, why: Breakdown) {
        self.stuck = true;
        self.breakdown.get_or_insert(why);
    }

    /// The series holds numbers beyond a double: there is no step that could be taken.
    #[cold]
    fn give_up<F: Forcing>(&mut self, stretch: &F) -> f64 {
        self.break_down(Breakdown::NotFinite);
        stretch.length()
    }

    /// Takes in a step up to `part`: what is kept of the trajectory, the error, the new state.
    #[inline]
    fn take_in<F: Forcing, const N: usize>(
        &mut self,
        series: &TaylorSeries<N>,
        stretch: &F,
        local: f64,
        part: f64,
        step: f64,
        start: &Start,
    ) {
        self.work.steps += 1;
        self.work.rhs += series.orders();
        let branch = if self.phase == Phase::Contact {
            &self.contact
        } else {
            &self.free
        };
        let (damping, pressing) = (branch.damping, branch.pressing);
        let highest = self.recorder.peak.angle;
        self.recorder
            .stretch(series, part, stretch.time() + local, step, || {
                self.sensitivity.apply(damping, pressing);
                // A peak in the first step from rest has no error but the step's own, and
                // there the terms of the torque may all but cancel.
                let torque = pressing
                    + stretch.at(local).abs()
                    + (branch.stiffness + stretch.across_most()) * start.angle.abs();
                let elapsed = part * step;
                self.sensitivity.angle_error_within(
                    start.angle.abs()
                        + series.slope().abs()
                        + series.curved.angle
                        + torque * elapsed * elapsed,
                )
            });
        if self.sensitivity.carries_noise() && self.recorder.peak.angle > highest {
            self.sensitivity.apply(damping, pressing);
            self.deviation = self.sensitivity.deviation();
        }
        if let Some(tangent) = &mut self.tangent {
            tangent.smooth(&TangentStep {
                branch,
                angle: series.coefficients(),
                excitation: stretch.series(local, step).as_ref(),
                turned: start.turned,
                step,
                part,
            });
        }
        let AngleSlope { angle, slope } = series.at(part);
        if self.bounds_error {
            let elapsed = part * step;
            let middle = stretch.at(local + 0.5 * elapsed);
            let across = stretch.across_at(local + 0.5 * elapsed);
            let turning = across * start.turned.sine;
            let per_second = 1.0 / step;
            let truncation = series.tail_at(part);
            self.sensitivity.smooth(&Smooth {
                time: elapsed,
                stiffness: branch.stiffness
                    - middle * start.turned.sine
                    - across * start.turned.cosine,
                push: middle * start.turned.cosine - turning,
                // What acts across may cancel the push, and is rounded all the same.
                force: pressing
                    + branch.stiffness * start.angle.abs().max(angle.abs())
                    + turning.abs()
                    + if start.lifting {
                        // The instant of release is rounded, and the torque grows from it.
                        let time = local + elapsed;
                        (stretch.slope_at(local).abs() + 0.5 * stretch.bend() * time) * time
                    } else {
                        0.0
                    },
                angle: start.angle.abs() + series.slope().abs() + series.curved.angle,
                velocity: (series.slope().abs() + series.curved.slope) * per_second,
                truncation,
                truncation_velocity: if self.tolerance.counts() {
                    truncation * series.tail_order() * per_second / part.max(f64::MIN_POSITIVE)
                } else {
                    // The last terms kept are below rounding, those cut off far below.
                    0.0
                },
            });
            if self.sensitivity.is_full() || F::LONG {
                self.sensitivity.apply(damping, pressing);
            }
        }
        let turn = angle - self.angle;
        if turn.abs() <= Turned::SMALL && self.turns < TURNS_MAX {
            self.turned = self.turned.by(turn);
            self.turns += 1;
        } else {
            self.turned = Turned::of(angle);
            self.turns = 0;
        }
        self.angle = angle;
        self.velocity = slope / step;
    }

    /// Puts the lever on φ = 0.
    fn set_on_stop(&mut self, velocity: f64) {
        self.angle = 0.0;
        self.velocity = velocity;
        self.turned = Turned::ZERO;
        self.turns = 0;
    }

    /// Returns a bound on the error of the angle [rad].
    pub(super) fn angle_error(&mut self) -> f64 {
        self.settle_error();
        self.sensitivity.angle_error()
    }

    /// Applies what is pending to the error.
    fn settle_error(&mut self) {
        if !self.bounds_error {
            return;
        }
        let branch = if self.phase == Phase::Contact {
            &self.contact
        } else {
            &self.free
        };
        self.sensitivity.apply(branch.damping, branch.pressing);
    }

    /// Tells whether a lever at φ ≤ 0 in flight moves off the stop, and puts it on φ = 0.
    fn leaves<F: Forcing>(&mut self, stretch: &F, local: f64) -> bool {
        self.set_on_stop(self.velocity);
        if self.velocity != 0.0 {
            return self.velocity > 0.0;
        }
        let torque = self.free.pressing + stretch.at(local);
        torque < 0.0 || (torque <= 0.0 && stretch.slope_at(local) < 0.0)
    }

    /// The lever meets the stop at φ = 0 with `self.velocity` ≤ 0.
    fn land<F: Forcing>(&mut self, stretch: &F, local: f64) {
        let before = self.velocity;
        let time = stretch.time() + local;
        self.settle_error();
        self.work.events += 1;
        self.recorder.impact(time, before);
        self.recorder.point(time, 0.0, before);
        let pressed = self.free.pressing + stretch.at(local);
        match self.stop.yields() {
            true => {
                self.pass_stop(
                    self.free.damping - self.contact.damping,
                    before * stretch.length(),
                );
                self.phase = Phase::Contact;
            }
            false => {
                let after = -self.restitution * before;
                if after <= SPEED_MIN {
                    self.rest_or_leave(pressed);
                } else {
                    let place = before * stretch.length();
                    self.rebound(self.restitution, before, -pressed, place);
                    self.recorder.release(time);
                    self.recorder.point(time, 0.0, after);
                }
            }
        }
    }

    fn rest_or_leave(&mut self, pressed: f64) {
        self.set_on_stop(0.0);
        if pressed >= 0.0 {
            self.phase = Phase::Dwell;
            self.rests += 1;
            self.sensitivity.reset();
            self.rest_tangent();
        } else {
            // A graze: touched at zero speed and pushed off again.
            self.phase = Phase::Flight;
        }
    }

    /// Sums up the remaining bounces if they end inside this sample; returns the local time of rest. Only
    /// bounces too slow to be counted are summed. Where the peak alone is asked for, it is enough that bounds show the lever to rest before the sample ends,
    /// after bounces none of which is the peak: what follows does not depend on when it came to rest.
    fn chatter<F: Forcing>(&mut self, stretch: &F, local: f64) -> Option<f64> {
        let speed = self.velocity;
        let counted = speed > COUNTED_SPEED && !self.recorder.peak_alone;
        if self.stop.yields() || self.restitution >= 1.0 || counted {
            return None;
        }
        let pressed = self.free.pressing + stretch.at(local);
        if pressed <= 0.0 {
            return None;
        }
        let bounces = Bounces {
            speed,
            restitution: self.restitution,
            pressed,
            rate: stretch.slope_at(local),
            bend: stretch.bend(),
            stiffness: self.free.stiffness + stretch.across_most(),
            damping: self.free.damping,
        };
        let time = bounces.time();
        let short =
            speed <= COUNTED_SPEED && bounces.are_short() && local + time <= stretch.length();
        let end = if short {
            self.offer_bounce(pressed, stretch.time() + local);
            local + time
        } else if self.recorder.peak_alone {
            (local + time.max(0.0)).min(self.rests_by(stretch, local)?)
        } else {
            return None;
        };
        self.work.events += 1;
        self.recorder.point(stretch.time() + end, 0.0, 0.0);
        self.rest_or_leave(self.free.pressing + stretch.at(end));
        Some(end)
    }

    /// The same below the stop above, where no bounce is a peak.
    fn chatter_above<F: Forcing>(&mut self, stretch: &F, local: f64, pressed: f64) -> Option<f64> {
        let restitution = self.ends.above.restitution?;
        let (_, onto) = self.pressing_above(stretch);
        let bounces = Bounces {
            speed: -self.velocity,
            restitution,
            pressed,
            rate: onto.slope_at(local),
            bend: onto.bend(),
            stiffness: self.free.stiffness + stretch.at(local).abs() + stretch.across_most(),
            damping: self.free.damping,
        };
        let end = local + bounces.time();
        let sums_up = restitution < 1.0 && bounces.speed <= COUNTED_SPEED && bounces.are_short();
        if !sums_up || end > stretch.length() {
            return None;
        }
        self.work.events += 1;
        self.recorder
            .point(stretch.time() + end, self.ends.above.angle, 0.0);
        self.rest_above(self.acceleration_above(stretch, end));
        Some(end)
    }

    /// Notes the height of the bounce that begins at `time`, the highest of those to come.
    fn offer_bounce(&mut self, pressed: f64, time: f64) {
        if self.recorder.judging {
            let speed = self.velocity;
            let error = self.angle_error();
            self.recorder.peak.offer(
                speed * speed / (2.0 * pressed),
                time + speed / pressed,
                error,
            );
        }
    }

    /// Returns the local time by which a lever that has just left the stop certainly rests on it, if
    /// that is inside the sample and none of its bounces could be the peak.
    ///
    /// Under a pressing acceleration between α₁ and α₂ a bounce of speed v is no higher than v²/(2α₁),
    /// lasts no longer than 2v/α₁ and is followed by one of no more than R √(α₂/α₁) v: a geometric
    /// series. Spring and damping only shorten it, but that damping slows the fall and the spring
    /// speeds it up, for which α₁ and α₂ leave room.
    fn rests_by<F: Forcing>(&mut self, stretch: &F, local: f64) -> Option<f64> {
        /// Part that rounding, and the cosine of the angle, may take.
        const ROOM: f64 = 1e-6;
        /// Largest α₂/α₁: with it no fall is faster than twice the speed of the bounce.
        const RATIO_MAX: f64 = 4.0;
        let speed = self.velocity;
        let length = stretch.length();
        let (from, to) = (stretch.at(local), stretch.at(length));
        let bent = 0.125 * stretch.bend() * (length - local) * (length - local);
        let weakest_press = self.free.pressing + from.min(to) - bent;
        let strongest_press = self.free.pressing + from.max(to) + bent;
        let low = (1.0 - ROOM) * weakest_press - 4.0 * self.free.damping * speed;
        let height = speed * speed / (2.0 * low);
        let strongest = from.abs().max(to.abs()) + bent;
        let turning = (strongest * height + stretch.across_most()) * height;
        if low.is_nan() || low <= 0.0 || turning > ROOM * low {
            return None;
        }
        let high = (1.0 + ROOM) * strongest_press + self.free.stiffness * height;
        let next = self.restitution * (high / low).sqrt();
        let rests = local + 2.0 * speed / (low * (1.0 - next));
        let error = self.angle_error();
        let (peak, ..) = self.recorder.awaits(error);
        let ends = high <= RATIO_MAX * low && next < 1.0 && rests < length;
        (ends && height <= peak).then_some(rests)
    }

    /// Carries the error's map through φ = 0 of the soft stop, where the damping changes by
    /// `drop` [1/s]; `place` is the size of the terms that placed the event [rad].
    fn pass_stop(&mut self, drop: f64, place: f64) {
        let map = StateMap([[1.0, 0.0], [drop, 1.0]]);
        if self.bounds_error {
            self.sensitivity.event(&map, place);
        }
        self.event_tangent(&map);
    }

    /// Contact to the end of the sample, the end of the series' reach, or lift-off.
    fn contact<F: Forcing>(&mut self, stretch: &F, local: f64) -> f64 {
        if self.angle >= 0.0 && self.leaves(stretch, local) {
            self.phase = Phase::Flight;
            self.recorder.release(stretch.time() + local);
            return local;
        }
        let step = (stretch.length() - local)
            .min(self.contact_step_max)
            .min(across_step_max(stretch))
            .min(stretch.step_max());
        let start = Start {
            angle: self.angle,
            turned: self.turned,
            velocity: self.velocity,
            lifting: false,
        };
        let (along, across) = (stretch.series(local, step), stretch.across(local, step));
        let excitation = StepExcitation {
            along: along.as_ref(),
            across: across.as_ref().map_or(&[], AsRef::as_ref),
            count_min: F::COUNT_MIN,
        };
        let series = TaylorSeries::<CONTACT_ORDER>::new(
            &self.contact,
            &start,
            step,
            excitation,
            &self.tolerance,
        );
        let reach = series.valid_part();
        if reach.is_nan() || reach <= 0.0 {
            return self.give_up(stretch);
        }
        let hit = hit(&series, reach, -1.0, 0.0);
        let part = hit.unwrap_or(reach);
        self.take_in(&series, stretch, local, part, step, &start);
        if hit.is_none() && part >= 1.0 && step >= stretch.length() - local {
            return stretch.length();
        }
        let reached = (local + part * step).min(stretch.length());
        if hit.is_some() {
            self.settle_error();
            self.set_on_stop(self.velocity.max(0.0));
            self.work.events += 1;
            self.pass_stop(
                self.contact.damping - self.free.damping,
                self.velocity * step,
            );
            self.phase = Phase::Flight;
            self.recorder.release(stretch.time() + reached);
        }
        self.recorder
            .point(stretch.time() + reached, self.angle, self.velocity);
        reached
    }

    /// Widens the error after a pass so close to the stop that an impact could have been
    /// missed, or made, within the error of the angle.
    fn near_graze<const N: usize>(
        &mut self,
        series: &TaylorSeries<N>,
        part: f64,
        step: f64,
        hit: bool,
    ) {
        if hit || self.stop.yields() || series.slope() >= 0.0 {
            return;
        }
        if series.at(part).slope <= 0.0 {
            return;
        }
        let error = self.angle_error().max(1e-15 * series.slope().abs());
        let grazed = GRAZE_DEVIATIONS * self.sensitivity.deviation();
        if series.start() + series.slope() - series.curved.angle > error.max(grazed) {
            return;
        }
        let mut lowest = series.start();
        let (derivative, count) = series.derivative();
        polynomial::sign_changes(&derivative[..count], part, &mut |x, rises| {
            if rises {
                lowest = lowest.min(series.at(x).angle);
            }
            true
        });
        let curvature = 2.0 * series.bend().abs() / (step * step);
        let thrown = |height: f64| (1.0 + self.restitution) * (2.0 * curvature * height).sqrt();
        if lowest <= error {
            self.sensitivity.add_velocity(thrown(error));
        }
        if lowest <= grazed {
            let deviation = thrown(grazed) / GRAZE_DEVIATIONS;
            self.sensitivity.add_noise(deviation);
        }
    }

    /// Tells whether the energy left, at a = 0, is too small to reach beyond `angle`.
    fn cannot_rise_above(&self, angle: f64) -> bool {
        let potential = |u: f64| {
            let stiffness = if u < 0.0 && self.stop.yields() {
                self.contact.stiffness
            } else {
                self.free.stiffness
            };
            self.free.pressing * u + 0.5 * stiffness * u * u
        };
        let energy = 0.5 * self.velocity * self.velocity + potential(self.angle);
        if self.stop.yields() && angle <= 0.0 {
            // A compressed stop holds energy too: as long as there is any, it may throw the
            // lever out. What remains here is worth a nanoradian per second.
            return energy <= 1e-18;
        }
        energy <= potential(angle) * (1.0 + 1e-12)
    }
}

/// A lever, alone or with what stands beside it, that can be carried on without excitation.
pub(super) trait Coasting {
    /// Returns the lever.
    fn lever(&mut self) -> &mut Kernel;

    /// Carries on without excitation from `time` over `length` [s].
    fn carry_on(&mut self, time: f64, length: f64);

    /// Returns what a catch did, and its trajectory.
    fn catch_run(&mut self) -> Option<(CatchRun, Vec<TracePoint>)>;

    /// Returns what it cost, as limits count it.
    fn spent(&mut self) -> u64 {
        self.lever().work.counted()
    }

    /// Moves on without excitation from `time` until the lever can no longer rise above what
    /// it has reached; returns the largest angle and a bound on its error, or `None` if it
    /// cannot be followed that far.
    fn coast(&mut self, time: f64, within: &Within<'_>) -> Option<Peak> {
        /// Longest stretch of a coast [s].
        const STRETCH: f64 = 5e-3;
        /// Stretches after which a coast is given up: an undamped lever between perfect stops
        /// has passed its highest point long before.
        const STRETCHES_MAX: u32 = 200_000;
        let lever = self.lever();
        lever.recorder.trace = None;
        let error = lever.angle_error();
        lever.recorder.open_window(lever.angle, time, error);
        let mut now = time;
        let mut looked = lever.work.steps;
        for _ in 0..STRETCHES_MAX {
            let lever = self.lever();
            if lever.phase == Phase::Dwell || lever.cannot_rise_above(lever.recorder.highest()) {
                return Some(lever.recorder.peak);
            }
            self.carry_on(now, STRETCH);
            now += STRETCH;
            let lever = self.lever();
            if lever.stuck || within.ends(lever.work.steps, &mut looked) {
                return None;
            }
        }
        None
    }
}

impl Coasting for Kernel {
    fn lever(&mut self) -> &mut Kernel {
        self
    }

    fn carry_on(&mut self, time: f64, length: f64) {
        self.advance(time, length, &[0.0; STRAIGHT], None);
    }

    fn catch_run(&mut self) -> Option<(CatchRun, Vec<TracePoint>)> {
        None
    }
}

/// Returns the longest step of a lever whose acceleration what acts across makes grow or swing [s].
#[inline]
fn across_step_max<F: Forcing>(stretch: &F) -> f64 {
    let across = stretch.across_most();
    if across > 0.0 {
        STEP_MAX / across.sqrt()
    } else {
        f64::INFINITY
    }
}
