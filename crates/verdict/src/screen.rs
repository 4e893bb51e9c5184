//! Closed-form bounds that decide without an integrator.
//!
//! Each bound is a proof, written out in `docs/screens.md`, that the lever of one design on one
//! recording, its samples joined by straight lines, never exceeds the threshold or certainly
//! does. They speak of the motion itself, not of a computed one: no numerical error enters, and
//! what the joining of the samples may hide is not covered. A bound that cannot decide says
//! nothing.
//!
//! - `arc`: the linear motion that a lever is compared with: y'' + γ y' + κ y = F(t), F linear
//!   over a sample, solved exactly;
//! - `held`: the bound on a lever that never leaves its soft stop, for all that swing alike;
//! - `rigid`: the bounds on a rigid stop;
//! - `soft`: the bounds on a soft stop.

mod arc;
mod held;
mod rigid;
mod soft;

use super::Screens;
use held::Responses;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::lever::Lever;
use latchgate_kernel::model::stop::{Stop, StopModel};
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY};
use serde::{Deserialize, Serialize};

/// The answer that a bound proves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Decided {
    /// The threshold is never exceeded, the coast after the last sample included.
    Pass,
    /// The threshold is exceeded inside the judged window.
    Fail,
}

/// A kind of bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Screen {
    /// The largest opening acceleration against lift-off, T0/(mL): below it a lever at rest on
    /// the rigid stop does not move.
    Static,
    /// ∫|a| dt from the first possible release on against the speed that reaches the threshold.
    Impulse,
    /// The same energy with what preload, impacts and times of rest take away; rigid stop only.
    Energy,
    /// The least angle that the lever has reached against the threshold.
    FirstFlight,
}

impl Screen {
    /// Returns the word that verdicts use.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Static => "static",
            Self::Impulse => "impulse",
            Self::Energy => "energy",
            Self::FirstFlight => "first-flight",
        }
    }

    /// Returns the unit of the bound's value and limit.
    #[must_use]
    pub fn unit(self) -> BoundUnit {
        match self {
            Self::Static => BoundUnit::MetrePerSecondSquared,
            Self::Impulse | Self::Energy => BoundUnit::MetrePerSecond,
            Self::FirstFlight => BoundUnit::Radian,
        }
    }
}

/// Unit of a bound's value and limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum BoundUnit {
    /// Of an acceleration.
    #[serde(rename = "m/s2")]
    MetrePerSecondSquared,
    /// Of a speed.
    #[serde(rename = "m/s")]
    MetrePerSecond,
    /// Of an angle.
    #[serde(rename = "rad")]
    Radian,
}

impl BoundUnit {
    /// Returns its symbol.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::MetrePerSecondSquared => "m/s2",
            Self::MetrePerSecond => "m/s",
            Self::Radian => "rad",
        }
    }
}

/// One bound on one lever and recording.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bound {
    /// Which.
    pub screen: Screen,
    /// The value of the recording; `None` where the bound does not apply.
    pub value: Option<f64>,
    /// The limit of that value: at or below it the first three prove a pass, above it the
    /// last proves a failure.
    pub limit: f64,
    /// Unit of both.
    pub unit: BoundUnit,
    /// The answer it proves.
    pub decides: Option<Decided>,
}

/// The bounds of one lever on one recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Screened {
    /// Every bound, the simplest first.
    pub bounds: [Bound; 4],
    /// The answer they prove together; they cannot contradict one another.
    pub answer: Option<Decided>,
    /// The simplest bound that proves it.
    pub by: Option<Screen>,
    /// Of a proven pass, an angle that the lever does not exceed [rad].
    pub peak_at_most_rad: Option<f64>,
}

/// A lever, its stop and the question.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Subject {
    /// The lever.
    pub lever: Lever,
    /// Its stop.
    pub stop: Stop,
    /// The model of the stop.
    pub model: StopModel,
    /// The angle that must not be exceeded [rad]. A caller that wants room for an error of the
    /// samples asks for a smaller one to prove a pass and for a larger one to prove a failure.
    pub threshold_rad: f64,
    /// Initial angle [rad] and angular velocity [rad/s]; `None` for rest on the stop.
    pub initial: Option<(f64, f64)>,
    /// First and last sample of the judged window; `None` for all.
    pub window: Option<(usize, usize)>,
}

/// A recording as one lever sees it: factor times sample plus offset is the acceleration in the
/// model's sign, negative opening.
#[derive(Debug, Clone, Copy)]
pub struct Seen<'a> {
    samples: &'a [f64],
    interval_s: f64,
    factor: f64,
    offset_m_s2: f64,
    extent: Extent,
    /// Where it is seen by several levers.
    responses: Option<&'a Responses>,
}

/// What is known of the samples as recorded as a whole: once for all signs, levers and members.
#[derive(Debug)]
pub struct SeenBefore {
    extent: Extent,
    responses: Responses,
}

impl SeenBefore {
    /// Returns what one pass over the samples says; what levers in contact make of them follows when
    /// it is asked for.
    #[must_use]
    pub fn of(signal: &Signal) -> Self {
        Self {
            extent: Extent::of(signal),
            responses: Responses::default(),
        }
    }
}

/// The samples' range and integral.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Extent {
    least: f64,
    most: f64,
    /// ∫|a| dt.
    impulse: f64,
}

impl Extent {
    fn of(signal: &Signal) -> Self {
        // A sample that is no number may slip through here; the impulse keeps it.
        let extreme = |wins: fn(f64, f64) -> bool, from: f64| {
            let samples = signal.samples.iter();
            samples.fold(from, |best, a| if wins(best, *a) { best } else { *a })
        };
        Self {
            least: extreme(|best, a| best <= a, f64::INFINITY),
            most: extreme(|best, a| best >= a, f64::NEG_INFINITY),
            impulse: absolute_impulse(signal),
        }
    }
}

impl<'a> Seen<'a> {
    /// Returns the recording as it stands.
    ///
    /// One pass over the samples; what it finds serves all members that see the recording
    /// [changed](Self::changed).
    #[must_use]
    pub fn of(signal: &'a Signal, opens_when: OpensWhen) -> Self {
        Self {
            samples: &signal.samples,
            interval_s: signal.rate.interval().seconds(),
            factor: opens_when.sign(),
            offset_m_s2: 0.0,
            extent: Extent::of(signal),
            responses: None,
        }
    }

    /// As [`Self::of`], of a signal that other levers saw before.
    #[must_use]
    pub fn known(signal: &'a Signal, known: &'a SeenBefore, opens_when: OpensWhen) -> Self {
        Self {
            samples: &signal.samples,
            interval_s: signal.rate.interval().seconds(),
            factor: opens_when.sign(),
            offset_m_s2: 0.0,
            extent: known.extent,
            responses: Some(&known.responses),
        }
    }

    /// Returns the recording with its acceleration scaled and a bias added [m/s², recording's
    /// polarity], as a member of an ensemble sees it.
    #[must_use]
    pub fn changed(self, scale: f64, bias_m_s2: f64) -> Self {
        Self {
            offset_m_s2: self.factor * bias_m_s2 + self.offset_m_s2,
            factor: self.factor * scale,
            ..self
        }
    }

    fn at(&self, index: usize) -> f64 {
        self.factor * self.samples[index] + self.offset_m_s2
    }

    /// Least acceleration in the model's sign.
    fn at_least(&self) -> f64 {
        let Extent { least, most, .. } = self.extent;
        (self.factor * least).min(self.factor * most) + self.offset_m_s2
    }

    /// Upper bound on |a|.
    fn at_most_either_way(&self) -> f64 {
        let Extent { least, most, .. } = self.extent;
        self.factor.abs() * least.abs().max(most.abs()) + self.offset_m_s2.abs()
    }

    /// Upper bound on ∫|a| dt over the whole record.
    fn impulse_at_most(&self) -> f64 {
        let length = self.samples.len() as f64 * self.interval_s;
        self.factor.abs() * self.extent.impulse + self.offset_m_s2.abs() * length
    }

    /// First judged sample and last sample that drives the lever.
    fn window(&self, subject: &Subject) -> (usize, usize) {
        let end = self.samples.len() - 1;
        let (first, last) = subject.window.unwrap_or((0, end));
        (first.min(end), last.min(end))
    }
}

/// Returns every bound of `subject` on `seen`.
///
/// One pass over the samples, nothing allocated.
#[must_use]
pub fn screen(subject: &Subject, seen: &Seen) -> Screened {
    measure(subject, seen, false).screened(subject)
}

/// Returns what [`screen`] proves, without its numbers; stops as soon as nothing more can be proven.
pub(super) fn screen_briefly(subject: &Subject, seen: &Seen) -> Screened {
    Screened {
        answer: decide(subject, seen),
        ..Measured::default().screened(subject)
    }
}

/// Returns an angle that the lever does not exceed [rad], as [`screen`] does, where the bounds
/// prove a pass; stops as soon as they cannot.
#[must_use]
pub fn peak_at_most(subject: &Subject, seen: &Seen) -> Option<f64> {
    if stays_in_contact(subject, seen) {
        return Some(0.0);
    }
    let measured = measure(subject, seen, true);
    let passes = measured.answer() == Some(Decided::Pass);
    measured.peak_at_most.filter(|_| passes)
}

/// Returns what the bounds prove, and stops as soon as nothing more can be proven.
///
/// This is [`screen`] without its numbers, for members of an ensemble: far from the threshold
/// it does not look at the samples at all.
#[must_use]
pub fn decide(subject: &Subject, seen: &Seen) -> Option<Decided> {
    let terms = Terms::of(subject, seen)?;
    if terms.passes_at_once(subject, seen) || stays_in_contact(subject, seen) {
        return Some(Decided::Pass);
    }
    measure(subject, seen, true).answer()
}

/// Tells what a pass over the samples would say, too: the lever never leaves its soft stop.
fn stays_in_contact(subject: &Subject, seen: &Seen) -> bool {
    subject.model == StopModel::Soft
        && Terms::of(subject, seen)
            .is_some_and(|terms| held::stays_in_contact(&terms, subject, seen))
}

fn measure(subject: &Subject, seen: &Seen, only_decide: bool) -> Measured {
    let Some(terms) = Terms::of(subject, seen) else {
        return Measured::default();
    };
    match subject.model {
        StopModel::Rigid => rigid::measure(&terms, subject, seen, only_decide),
        StopModel::Soft => soft::measure(&terms, subject, seen, only_decide),
    }
}

/// What one pass over the samples gives. Speeds are √(2E/I0), the speed that a lever of energy
/// E has on the stop [rad/s].
#[derive(Debug, Clone, Copy, Default)]
struct Measured {
    /// Largest opening acceleration [m/s²], of a lever at rest on a rigid stop.
    opening: Option<f64>,
    /// Bound on the speed by the impulse alone.
    impulse: Option<f64>,
    /// Sharpened bound on the speed.
    energy: Option<f64>,
    /// Largest value inside the window of a solution that the angle cannot be below [rad].
    lower: Option<f64>,
    /// What each proves.
    passes_static: bool,
    passes_impulse: bool,
    passes_energy: bool,
    fails: bool,
    /// Of a pass, an angle that is not exceeded [rad].
    peak_at_most: Option<f64>,
}

impl Measured {
    fn answer(&self) -> Option<Decided> {
        if self.passes_static || self.passes_impulse || self.passes_energy {
            Some(Decided::Pass)
        } else if self.fails {
            Some(Decided::Fail)
        } else {
            None
        }
    }

    fn screened(&self, subject: &Subject) -> Screened {
        let gain = subject.lever.unbalance_kg_m() / subject.lever.moment_of_inertia_kg_m2;
        let limit = speed_limit(subject) / gain;
        let bound = |screen: Screen, value: Option<f64>, limit: f64, decides: bool| Bound {
            screen,
            value: value.filter(|value| value.is_finite()),
            limit,
            unit: screen.unit(),
            decides: decides.then_some(if screen == Screen::FirstFlight {
                Decided::Fail
            } else {
                Decided::Pass
            }),
        };
        let in_m_s = |speed: Option<f64>| speed.map(|speed| speed / gain);
        let bounds = [
            bound(
                Screen::Static,
                self.opening,
                subject.lever.lift_off_acceleration_m_s2(),
                self.passes_static,
            ),
            bound(
                Screen::Impulse,
                in_m_s(self.impulse),
                limit,
                self.passes_impulse,
            ),
            bound(
                Screen::Energy,
                in_m_s(self.energy),
                limit,
                self.passes_energy,
            ),
            bound(
                Screen::FirstFlight,
                self.lower,
                subject.threshold_rad,
                self.fails,
            ),
        ];
        Screened {
            bounds,
            answer: self.answer(),
            by: bounds
                .iter()
                .find(|bound| bound.decides.is_some())
                .map(|bound| bound.screen),
            peak_at_most_rad: self
                .peak_at_most
                .filter(|_| self.answer() == Some(Decided::Pass)),
        }
    }
}

/// The speed of a lever on its stop whose energy just reaches the threshold [rad/s].
fn speed_limit(subject: &Subject) -> f64 {
    let lever = &subject.lever;
    let inertia = lever.moment_of_inertia_kg_m2;
    let stored = match subject.model {
        StopModel::Rigid => 0.0,
        // Energy counts from that of rest in the soft stop.
        StopModel::Soft => -0.5 * lever.preload_torque_nm * subject.stop.rest_angle_rad(lever),
    };
    let threshold = subject.threshold_rad;
    (2.0 * (lever.preload_torque_nm * threshold
        + 0.5 * lever.spring_stiffness_nm_per_rad * threshold * threshold
        + stored)
        / inertia)
        .sqrt()
}

/// The lever's constants, divided by its inertia, and what rounding is allowed for.
#[derive(Debug, Clone, Copy)]
struct Terms {
    /// p0 = T0/I0 [rad/s²].
    pressing: f64,
    /// κ = k0/I0 [1/s²].
    stiffness: f64,
    /// γ = c0/I0 [1/s].
    damping: f64,
    /// g = mL/I0 [1/m].
    gain: f64,
    threshold: f64,
    /// Least cosine of an angle from −φ* to φ*.
    cosine: f64,
    /// What an acceleration that holds at φ = 0 may push open at the threshold, −cos φ* [-].
    overhang: f64,
    /// Speed that reaches the threshold [rad/s].
    limit: f64,
    /// Relative allowance for rounding.
    slack: f64,
    interval: f64,
}

impl Terms {
    /// Returns nothing for a lever, question or recording that the proofs do not speak of.
    fn of(subject: &Subject, seen: &Seen) -> Option<Self> {
        let (lever, stop) = (&subject.lever, &subject.stop);
        let positive = |value: f64| value > 0.0 && value.is_finite();
        let admitted = |value: f64| value >= 0.0 && value.is_finite();
        let threshold = subject.threshold_rad;
        let good = positive(lever.moment_of_inertia_kg_m2)
            && positive(lever.mass_kg)
            && positive(lever.center_of_mass_m)
            && admitted(lever.pivot_damping_nm_s_per_rad)
            && admitted(lever.spring_stiffness_nm_per_rad)
            && admitted(lever.preload_torque_nm)
            && (0.0..=1.0).contains(&stop.restitution)
            && positive(stop.stiffness_n_per_m)
            && admitted(stop.damping_n_s_per_m)
            && positive(stop.radius_m)
            && positive(threshold)
            && positive(seen.interval_s)
            && seen.factor.is_finite()
            && seen.offset_m_s2.is_finite()
            && seen.samples.len() >= 2
            && subject
                .initial
                .is_none_or(|(angle, velocity)| angle.is_finite() && velocity.is_finite());
        if !good {
            return None;
        }
        let inertia = lever.moment_of_inertia_kg_m2;
        let cosine = if threshold < std::f64::consts::PI {
            libm::cos(threshold)
        } else {
            -1.0
        };
        Some(Self {
            pressing: lever.preload_torque_nm / inertia,
            stiffness: lever.spring_stiffness_nm_per_rad / inertia,
            damping: lever.pivot_damping_nm_s_per_rad / inertia,
            gain: lever.unbalance_kg_m() / inertia,
            threshold,
            cosine,
            overhang: (-cosine).max(0.0),
            limit: speed_limit(subject),
            slack: rounding(seen.samples.len()),
            interval: seen.interval_s,
        })
    }

    /// Returns whether what is known of the recording as a whole proves a pass from rest.
    fn passes_at_once(&self, subject: &Subject, seen: &Seen) -> bool {
        /// Keeps clear of what the pass over the samples would allow for in rounding.
        const CLEAR: f64 = 1e-9;
        let Extent {
            least,
            most,
            impulse,
        } = seen.extent;
        let sound = impulse.is_finite() && least.is_finite() && most.is_finite();
        if !sound || subject.initial.is_some() {
            return false;
        }
        let pressed = subject.model == StopModel::Rigid
            && self.pressing + self.gain * seen.at_least() > CLEAR * self.pressing;
        let impulse = self.gain * seen.impulse_at_most();
        pressed || impulse <= self.limit * (1.0 - CLEAR - self.slack)
    }

    /// Returns the speed that potential energy alone comes to at `angle` ≥ 0 [rad/s].
    fn speed_at(&self, angle: f64) -> f64 {
        (angle * (2.0 * self.pressing + self.stiffness * angle)).sqrt()
    }

    /// Returns the angle up to which energy of `speed` reaches [rad].
    fn reach(&self, speed: f64) -> f64 {
        let square = speed * speed;
        if square > 0.0 {
            square
                / (self.pressing + (self.pressing * self.pressing + self.stiffness * square).sqrt())
        } else {
            0.0
        }
    }

    /// Returns whether energy of `speed`, made up of terms of `size`, certainly does not reach
    /// the threshold.
    fn stays_below(&self, speed: f64, size: f64) -> bool {
        speed + self.slack * size <= self.limit * (1.0 - self.slack)
    }

    /// Returns the largest angular acceleration that excitation and preload give a lever
    /// between 0 and the threshold.
    fn torque_at_most(&self, acceleration: f64, cosine: f64) -> f64 {
        let push = -self.gain * acceleration;
        push.max(push * cosine) - self.pressing
    }

    /// Returns the least.
    fn torque_at_least(&self, acceleration: f64, cosine: f64) -> f64 {
        let push = -self.gain * acceleration;
        push.min(push * cosine) - self.pressing
    }
}

/// Returns the relative allowance for rounding: a sum of n terms is off by n roundings; four times
/// that, and a hundred for what each term is made of.
fn rounding(count: usize) -> f64 {
    4.0 * f64::EPSILON * (count as f64 + 100.0)
}

/// Returns the speed whose energy is that of two speeds together.
fn together(first: f64, second: f64) -> f64 {
    (first * first + second * second).sqrt()
}

/// Returns ∫ max(−a, 0) dt and ∫ max(a, 0) dt of a straight line from `from` to `to` over
/// `length`, exactly.
fn areas(from: f64, to: f64, length: f64) -> (f64, f64) {
    if from <= 0.0 && to <= 0.0 {
        (-0.5 * (from + to) * length, 0.0)
    } else if from >= 0.0 && to >= 0.0 {
        (0.0, 0.5 * (from + to) * length)
    } else {
        // Two triangles on either side of the zero.
        let scale = 0.5 * length / (to - from).abs();
        let (below, above) = (from.min(to), from.max(to));
        (below * below * scale, above * above * scale)
    }
}

/// Returns the bounds of `design`, with the impulse of `signal` over its judged samples.
///
/// # Source
///
/// Static: eq. (2.1) at rest. Impulse: with E = I0 φ'²/2 + T0 φ + k0 φ²/2, damping and
/// impacts only lower E, so d√E/dt ≤ mL|a|/√(2 I0); reaching φ* from rest needs
/// ∫|a| dt ≥ √(2 I0 (T0 φ* + k0 φ*²/2))/(mL). It holds for a rigid stop with R ≤ 1.
#[must_use]
pub fn screens(design: &Design, signal: Option<&Signal>) -> Screens {
    let lever = &design.lever;
    let threshold = design.criterion.threshold_rad;
    let energy = lever.preload_torque_nm * threshold
        + 0.5 * lever.spring_stiffness_nm_per_rad * threshold * threshold;
    let static_threshold = lever.lift_off_acceleration_m_s2();
    Screens {
        static_threshold_g: static_threshold / STANDARD_GRAVITY,
        static_threshold_m_s2: static_threshold,
        impulse_threshold_m_s: (2.0 * lever.moment_of_inertia_kg_m2 * energy).sqrt()
            / lever.unbalance_kg_m(),
        impulse_m_s: signal.map(absolute_impulse),
        runs: Vec::new(),
    }
}

/// Returns ∫|a| dt [m/s] of a signal that is linear between its samples.
fn absolute_impulse(signal: &Signal) -> f64 {
    let length = signal.rate.interval().seconds();
    signal
        .samples
        .windows(2)
        .map(|pair| {
            let (opening, holding) = areas(pair[0], pair[1], length);
            opening + holding
        })
        .sum()
}
