//! How far rounding has carried: the covariance of the state's error, propagated along the
//! trajectory and through every impact by its saltation matrix, with the part that all
//! steps share (rounding of the parameters) kept apart because it adds up coherently.
//!
//! Step-halving cannot see this error: it grows with the flow, by orders of magnitude in a
//! dozen impacts. Rest wipes it out, since the state is then exactly known. A white noise of the
//! excitation is carried along in the same way.
//!
//! # Source
//!
//! Saltation matrix: Leine and Nijmeijer, "Dynamics and Bifurcations of Non-Smooth
//! Mechanical Systems", ch. 7; Müller, Chaos, Solitons & Fractals 5 (1995) 1671.

/// Rounding of one operation, relative; the standard deviation of a few of them together.
const ROUNDING: f64 = 1.5e-16;

/// Standard deviations that the stated bound covers.
const COVERAGE: f64 = 6.0;

/// Error of the state (angle, angular velocity): covariance and coherent part.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sensitivity {
    variance_angle: f64,
    covariance: f64,
    variance_velocity: f64,
    /// Change of the state for a relative change of 1 in the excitation [rad, rad/s].
    excitation: [f64; 2],
    /// The same for the preload.
    preload: [f64; 2],
    /// Variance of the angular velocity per time that a noise of the excitation adds [rad²/s³].
    noise: f64,
    /// Variance of the angle, covariance and variance of the velocity from that noise.
    of_noise: [f64; 3],
    /// Stretches not yet applied.
    pending: Smooths,
}

/// Stretches applied together at most: short against any swing, long enough to cost little.
const PENDING_MAX: u32 = 16;

/// What several smooth stretches in a row do to the error.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Smooths {
    /// Their length [s].
    pub(super) time: f64,
    /// ∫ stiffness dt [1/s].
    pub(super) stiffness: f64,
    /// ∫ b cos u dt [rad/s].
    pub(super) push: f64,
    /// Sum of the squared sizes of the angle [rad²].
    pub(super) angle_square: f64,
    /// Sum of the squared sizes of the velocity and of what changes it [rad²/s²].
    pub(super) velocity_square: f64,
    /// Sum of what the steps neglect [rad].
    pub(super) truncation: f64,
    /// The same of the velocity [rad/s]: what it is worth later on.
    pub(super) truncation_velocity: f64,
    /// How many they are.
    pub(super) count: u32,
}

/// What a smooth stretch does to the error.
#[derive(Debug, Clone, Copy)]
pub(super) struct Smooth {
    /// Its length [s].
    pub(super) time: f64,
    /// Stiffness of a deviation, k/I0 − b sin u [1/s²].
    pub(super) stiffness: f64,
    /// Excitation term b cos u [rad/s²].
    pub(super) push: f64,
    /// Sizes of the other terms of the right-hand side, preload and spring [rad/s²].
    pub(super) force: f64,
    /// Size of what is added up to the angle reached [rad].
    pub(super) angle: f64,
    /// Size of what is added up to the velocity reached [rad/s].
    pub(super) velocity: f64,
    /// What the step neglects [rad].
    pub(super) truncation: f64,
    /// The same of the velocity [rad/s]: what it is worth later on.
    pub(super) truncation_velocity: f64,
}

/// A linear map of a state's deviation.
#[derive(Debug, Clone, Copy)]
pub(super) struct StateMap(pub(super) [[f64; 2]; 2]);

impl Sensitivity {
    /// Forgets everything: the state is exactly known.
    #[inline]
    pub(super) fn reset(&mut self) {
        *self = Self::with_noise(self.noise);
    }

    /// Returns what is known of a state exactly known, under an excitation with this noise [rad²/s³].
    pub(super) fn with_noise(noise: f64) -> Self {
        Self {
            noise,
            ..Self::default()
        }
    }

    /// Tells whether a noise of the excitation is carried along.
    pub(super) fn carries_noise(&self) -> bool {
        self.noise > 0.0
    }

    /// Returns a bound on the error of the angle [rad].
    #[inline]
    pub(super) fn angle_error(&self) -> f64 {
        let error = COVERAGE
            * (self.variance_angle.sqrt()
                + ROUNDING * (self.excitation[0].abs() + self.preload[0].abs()));
        // Beyond what a double holds nothing is known.
        if error.is_nan() { f64::INFINITY } else { error }
    }

    /// Returns a bound on the error of an angle inside the next stretch [rad], `size` [rad]
    /// being that of the terms it is the sum of.
    pub(super) fn angle_error_within(&self, size: f64) -> f64 {
        self.angle_error() + COVERAGE * ROUNDING * size
    }

    /// Takes in a smooth stretch; its effect is applied together with its neighbours'.
    #[inline]
    pub(super) fn smooth(&mut self, stretch: &Smooth) {
        let pending = &mut self.pending;
        pending.time += stretch.time;
        pending.stiffness += stretch.stiffness * stretch.time;
        pending.push += stretch.push * stretch.time;
        let velocity = stretch.velocity + (stretch.push.abs() + stretch.force) * stretch.time;
        pending.velocity_square += velocity * velocity;
        pending.angle_square += stretch.angle * stretch.angle;
        pending.truncation += stretch.truncation;
        pending.truncation_velocity += stretch.truncation_velocity;
        pending.count += 1;
    }

    /// Takes in several stretches at once.
    #[inline]
    pub(super) fn smooths(&mut self, more: &Smooths) {
        let pending = &mut self.pending;
        pending.time += more.time;
        pending.stiffness += more.stiffness;
        pending.push += more.push;
        pending.angle_square += more.angle_square;
        pending.velocity_square += more.velocity_square;
        pending.truncation += more.truncation;
        pending.truncation_velocity += more.truncation_velocity;
        pending.count += more.count;
    }

    /// Returns a bound on the error of the angle within the next `time` [s], of smooth motion.
    ///
    /// What is pending must have been applied.
    pub(super) fn angle_error_soon(&self, time: f64) -> f64 {
        let velocity = self.variance_velocity.sqrt()
            + ROUNDING * (self.excitation[1].abs() + self.preload[1].abs());
        2.0 * (self.angle_error() + COVERAGE * velocity * time)
    }

    /// Tells whether so much is pending that it should be applied.
    #[inline]
    pub(super) fn is_full(&self) -> bool {
        self.pending.count >= PENDING_MAX
    }

    /// Applies what is pending: the flow of δ'' = −damping δ' − stiffness δ with the mean
    /// stiffness, and the rounding of every stretch; `pressing` is the preload term [rad/s²].
    pub(super) fn apply(&mut self, damping: f64, pressing: f64) {
        let pending = std::mem::take(&mut self.pending);
        if pending.count == 0 || pending.time <= 0.0 {
            return;
        }
        let stiffness = pending.stiffness / pending.time;
        let map = StateMap::oscillator(stiffness, damping, pending.time);
        self.apply_together(&pending, &map, pressing);
    }

    /// Applies stretches of which `map` is the flow.
    pub(super) fn apply_together(&mut self, stretches: &Smooths, map: &StateMap, pressing: f64) {
        let time = stretches.time;
        let StateMap([[kept, lever], _]) = *map;
        self.map(map);
        // The response to a constant force f is f (1 - kept)/stiffness and f lever; both in the
        // limit of a short time where the stiffness does not count.
        let stiffness = stretches.stiffness / time;
        let long = is_long(stiffness, time);
        let (angle, velocity) = if long {
            ((1.0 - kept) / (stiffness * time), lever / time)
        } else {
            (0.5 * time, 1.0)
        };
        self.excitation[0] -= stretches.push * angle;
        self.excitation[1] -= stretches.push * velocity;
        self.preload[0] -= pressing * time * angle;
        self.preload[1] -= pressing * time * velocity;
        let (mut angle, mut velocity) = (stretches.angle_square, stretches.velocity_square);
        if long && stiffness > 0.0 {
            // What was rounded early has swung from the one to the other since.
            (angle, velocity) = (angle + velocity / stiffness, velocity + angle * stiffness);
        }
        self.variance_angle += ROUNDING * ROUNDING * angle;
        self.variance_velocity += ROUNDING * ROUNDING * velocity;
        let noise = self.noise * time;
        let [angle, covariance, velocity] = &mut self.of_noise;
        if long && stiffness > 0.0 {
            *angle += 0.5 * noise / stiffness;
            *velocity += 0.5 * noise;
        } else {
            *angle += noise * time * time / 3.0;
            *covariance += 0.5 * noise * time;
            *velocity += noise;
        }
        // What is cut off has the same sign for steps on end: it adds up, not its square.
        self.variance_angle = raised(self.variance_angle, stretches.truncation);
        self.variance_velocity = raised(self.variance_velocity, stretches.truncation_velocity);
    }

    /// Carries the error through an event; `place` [rad] is the rounding of the event's place.
    ///
    /// What is pending must have been applied.
    #[inline]
    pub(super) fn event(&mut self, saltation: &StateMap, place: f64) {
        let place = ROUNDING * place;
        self.variance_angle += place * place;
        self.map(saltation);
    }

    /// Adds an independent error of the angular velocity [rad/s].
    pub(super) fn add_velocity(&mut self, error: f64) {
        let sigma = error / COVERAGE;
        self.variance_velocity += sigma * sigma;
    }

    /// Returns the standard deviation of the angle from the noise [rad].
    pub(super) fn deviation(&self) -> f64 {
        self.of_noise[0].sqrt()
    }

    /// Adds an independent deviation of the angular velocity to that of the noise [rad/s].
    pub(super) fn add_noise(&mut self, deviation: f64) {
        self.of_noise[2] += deviation * deviation;
    }

    #[inline]
    fn map(&mut self, map: &StateMap) {
        let StateMap([[a, b], [c, d]]) = map;
        let variance = [self.variance_angle, self.covariance, self.variance_velocity];
        [self.variance_angle, self.covariance, self.variance_velocity] = map.of_variance(variance);
        if self.carries_noise() {
            self.of_noise = map.of_variance(self.of_noise);
        }
        for vector in [&mut self.excitation, &mut self.preload] {
            *vector = [a * vector[0] + b * vector[1], c * vector[0] + d * vector[1]];
        }
    }
}

/// The variance after the standard deviation has grown by `more`.
#[inline]
fn raised(variance: f64, more: f64) -> f64 {
    variance + more * (2.0 * variance.sqrt() + more)
}

/// Tells whether a deviation swings in `time`.
#[inline]
fn is_long(stiffness: f64, time: f64) -> bool {
    stiffness.abs() * time * time >= 0.5 * SHORT
}

/// Zero for what rounding has made negative; NaN stays.
#[inline]
fn not_negative(variance: f64) -> f64 {
    if variance < 0.0 { 0.0 } else { variance }
}

impl StateMap {
    /// Returns what becomes of a variance of the angle, a covariance and a variance of the velocity.
    #[inline]
    fn of_variance(&self, [p, q, r]: [f64; 3]) -> [f64; 3] {
        let Self([[a, b], [c, d]]) = self;
        let (ap, aq) = (a * p + b * q, a * q + b * r);
        let (cp, cq) = (c * p + d * q, c * q + d * r);
        [
            not_negative(ap * a + aq * b),
            ap * c + aq * d,
            not_negative(cp * c + cq * d),
        ]
    }

    /// Returns the flow over `time` [s] of δ'' = −damping δ' − stiffness δ, both constant.
    #[inline]
    pub(super) fn oscillator(stiffness: f64, damping: f64, time: f64) -> Self {
        if !is_long(stiffness, time) && damping * time < 0.5 * SHORT {
            let (kt2, ct) = (stiffness * time * time, damping * time);
            let a = 1.0 - 0.5 * kt2;
            let b = time * (1.0 - 0.5 * ct);
            return Self([[a, b], [-stiffness * b, a - damping * b]]);
        }
        // exp(−γ/2 t) (cos ωt, sin ωt/ω), or its hyperbolic twin beyond critical damping.
        let half = 0.5 * damping;
        let square = stiffness - half * half;
        let rate = (-square).max(0.0).sqrt();
        if rate * time > FAR_APART {
            // Of the two exponentials the fast one is gone.
            let slow = stiffness / (half + rate);
            let odd = 0.5 * libm::exp(-slow * time) / rate;
            return Self([[(half + rate) * odd, odd], [-stiffness * odd, -slow * odd]]);
        }
        let decay = libm::exp(-half * time);
        let (even, odd) = if square > 0.0 {
            let omega = square.sqrt();
            (libm::cos(omega * time), libm::sin(omega * time) / omega)
        } else if square < 0.0 {
            (libm::cosh(rate * time), libm::sinh(rate * time) / rate)
        } else {
            (1.0, time)
        };
        let (even, odd) = (decay * even, decay * odd);
        Self([
            [even + half * odd, odd],
            [-stiffness * odd, even - half * odd],
        ])
    }
}

/// Half the difference of the two rates of an overdamped stop times the time, from which on nothing is left of the
/// faster exponential against the slower.
const FAR_APART: f64 = 40.0;

/// Up to half of this size of (ωt)² and γt two terms of the flow's series are good to 1e-4.
const SHORT: f64 = 1e-2;
