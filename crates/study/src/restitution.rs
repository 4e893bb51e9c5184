//! The paper's Fig. 2: the damping ratio equivalent to a restitution, and the limits of the equivalence.

use super::{Figures, Headline};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::{StopModel, damping_ratio};
use latchgate_kernel::range::Range;
use latchgate_kernel::replay::State;
use latchgate_kernel::units::Restitution;
use latchgate_recording::error::Error;
use serde::Serialize;
use std::f64::consts::PI;

/// Options of the study of restitution.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Options {
    /// The lever.
    pub design: Design,
    /// Points of the curve.
    pub points: u32,
}

/// A point of the curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Row {
    /// Coefficient of restitution R [-].
    pub restitution: f64,
    /// Damping ratio ξ [-], eq. (2.5).
    pub damping_ratio: f64,
    /// Damping of this design's stop that has this ratio, 2 I0 ωR ξ/ls² [N s/m].
    pub damping_n_s_per_m: f64,
}

/// Change of speed in a contact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rebound {
    /// Speed of entry [rad/s].
    pub speed_rad_s: f64,
    /// Speed of exit over speed of entry [-]; `None` if the lever stays.
    pub ratio: Option<f64>,
    /// Length of the contact [s]; `None` if the lever stays.
    pub contact_s: Option<f64>,
}

/// The stop's torque in a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Push {
    /// Time from the entry [s].
    pub time_s: f64,
    /// Torque of the stop on the lever [N m]; negative is tension.
    pub torque_nm: f64,
}

/// Result of the study.
#[derive(Debug, Clone, PartialEq)]
pub struct Equivalence {
    /// ξ against R.
    pub rows: Vec<Row>,
    /// Exit over entry speed against entry speed, with the design's preload.
    pub rebounds: Vec<Rebound>,
    /// The stop's torque over the contact after the reference entry.
    pub pushes: Vec<Push>,
    /// Instant at which that torque turns into tension [s]; `None` if the contact does not oscillate.
    pub tension_from_s: Option<f64>,
    /// Speed of the reference entry [rad/s].
    pub speed_rad_s: f64,
    /// The design's restitution [-].
    pub restitution: f64,
    /// The design's damping ratio ξ = cs ls²/(2 I0 ωR) [-].
    pub damping_ratio: f64,
    /// Restitution that eq. (2.4) gives for the design's whole contact, pivot included [-].
    pub half_period_ratio: f64,
    /// Exit over entry speed if the contact ends where the force of the stop is zero, without preload [-].
    pub released_ratio: Option<f64>,
    /// Speed below which the soft stop keeps the lever [rad/s]; `None` if it never does.
    pub capture_speed_rad_s: Option<f64>,
    /// Headline figures.
    pub headlines: Vec<Headline>,
}

/// Speed of the reference entry [rad/s]: near that of the first impact of the paper's Fig. 4b.
const SPEED: f64 = 14.678_784;

/// Digits of the figures, which include pairs of dampings and speeds that differ in the fifth.
const DIGITS: usize = 7;

/// Range of the speeds of entry [rad/s].
const SPEEDS: Range = Range::new(1e-3, 100.0);

/// Points of the curve below its first regular one, two in a decade.
pub const FOOT: u32 = 24;

/// A contact with the soft stop, solved exactly: between entry and exit the equation of a lever
/// without excitation is linear.
///
/// # Source
///
/// Eq. (2.2) with A = 0 and φ(0) = 0: φ = −q + e^(−δt) (q cos ω_d t + B sin ω_d t) with
/// q = T0/kR, δ = cR/(2 I0), ω_d = √(ωR² − δ²), B = (δ q − v)/ω_d.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeContact {
    offset: f64,
    decay: f64,
    frequency: f64,
    stiffness: f64,
    damping: f64,
}

/// Exit of a lever from a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exit {
    /// Time since the entry [s].
    pub time_s: f64,
    /// Angular velocity [rad/s].
    pub speed_rad_s: f64,
}

impl FreeContact {
    /// Returns the contact of `design` under a preload; `None` if it is overdamped, so that the lever never
    /// leaves.
    pub fn new(design: &Design, preload_torque_nm: f64) -> Option<Self> {
        let (lever, stop) = (&design.lever, &design.stop);
        let inertia = lever.moment_of_inertia_kg_m2;
        let stiffness = stop.contact_stiffness_nm_per_rad(lever);
        let decay = stop.contact_damping_nm_s_per_rad(lever) / (2.0 * inertia);
        let square = stiffness / inertia - decay * decay;
        let radius = stop.radius_m * stop.radius_m;
        (square > 0.0).then(|| Self {
            offset: preload_torque_nm / stiffness,
            decay,
            frequency: square.sqrt(),
            stiffness: stop.stiffness_n_per_m * radius,
            damping: stop.damping_n_s_per_m * radius,
        })
    }

    /// Returns half a period of the damped contact, π/ω_d [s].
    pub fn half_period_s(&self) -> f64 {
        PI / self.frequency
    }

    /// Returns the state at `time` [s] after an entry with `speed` [rad/s].
    pub fn state(&self, time: f64, speed: f64) -> State {
        let (sine, cosine) = libm::sincos(self.frequency * time);
        let fade = libm::exp(-self.decay * time);
        let (a, b) = (
            self.offset,
            (self.decay * self.offset - speed) / self.frequency,
        );
        State::new(
            -self.offset + fade * (a * cosine + b * sine),
            fade * ((self.frequency * b - self.decay * a) * cosine
                - (self.frequency * a + self.decay * b) * sine),
        )
    }

    /// Returns the stop's torque on the lever [N m] in a state; negative is tension.
    pub fn torque_nm(&self, state: State) -> f64 {
        -(self.stiffness * state.angle_rad + self.damping * state.velocity_rad_s)
    }

    /// Returns the exit after an entry with `speed` [rad/s]; `None` if the lever stays.
    pub fn exit(&self, speed: f64) -> Option<Exit> {
        // The velocity is zero at the deepest point, and again at the highest point of a lever that stays.
        // An exit lies between the two.
        let deepest = self.turn(speed);
        let highest = deepest + self.half_period_s();
        let out = |time: f64| self.state(time, speed).angle_rad > 0.0;
        if !out(highest) {
            return None;
        }
        let time_s = bisect(deepest, highest, out);
        Some(Exit {
            time_s,
            speed_rad_s: self.state(time_s, speed).velocity_rad_s,
        })
    }

    /// Returns the instant at which the stop's torque turns into tension after an entry with `speed` [rad/s].
    pub fn tension_from_s(&self, speed: f64) -> f64 {
        let deepest = self.turn(speed);
        let pulls = |time: f64| self.torque_nm(self.state(time, speed)) < 0.0;
        bisect(deepest, deepest + self.half_period_s(), pulls)
    }

    /// Returns the first time at which the velocity is zero [s].
    fn turn(&self, speed: f64) -> f64 {
        // φ' = e^(−δt) (−v cos ω_d t − C sin ω_d t), C = ω_d q + δ B.
        let b = (self.decay * self.offset - speed) / self.frequency;
        let c = self.frequency * self.offset + self.decay * b;
        let turned = libm::atan2(speed, -c);
        (if turned > 0.0 { turned } else { turned + PI }) / self.frequency
    }
}

/// Returns the point at which `is` becomes true between `low`, where it is false, and `high`, where it is true.
fn bisect(mut low: f64, mut high: f64, is: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..200 {
        let middle = f64::midpoint(low, high);
        if middle <= low || middle >= high {
            break;
        }
        if is(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

/// Runs the study.
///
/// # Errors
///
/// As [`Restitution::from_ratio`]; the design's own restitution is valid.
pub fn run(options: &Options) -> Result<Equivalence, Error> {
    let design = &options.design;
    let (lever, stop) = (&design.lever, &design.stop);
    let frequency = stop.contact_angular_frequency_rad_s(lever);
    let radius = stop.radius_m * stop.radius_m;
    let inertia = lever.moment_of_inertia_kg_m2;
    let damping = |ratio: f64| 2.0 * inertia * frequency * ratio / radius;
    let rows = equivalence(options.points, damping)?;
    let free = FreeContact::new(design, 0.0);
    let loaded = FreeContact::new(design, lever.preload_torque_nm);
    let rebound = |speed_rad_s: f64| {
        let exit = loaded.and_then(|contact| contact.exit(speed_rad_s));
        Rebound {
            speed_rad_s,
            ratio: exit.map(|exit| exit.speed_rad_s / speed_rad_s),
            contact_s: exit.map(|exit| exit.time_s),
        }
    };
    let steps = 10 * options.points;
    let rebounds: Vec<Rebound> = (0..=steps)
        .map(|index| {
            let share = f64::from(index) / f64::from(steps);
            rebound(SPEEDS.low * libm::pow(SPEEDS.high / SPEEDS.low, share))
        })
        .collect();
    // Only a preload keeps a slow lever; without one every speed leaves.
    let capture_speed_rad_s = loaded
        .filter(|_| rebound(SPEEDS.low).ratio.is_none())
        .filter(|_| rebound(SPEEDS.high).ratio.is_some())
        .map(|contact| {
            bisect(SPEEDS.low, SPEEDS.high, |speed| {
                contact.exit(speed).is_some()
            })
        });
    let tension_from_s = free.map(|contact| contact.tension_from_s(SPEED));
    let released_ratio = free
        .zip(tension_from_s)
        .map(|(contact, time)| contact.state(time, SPEED).velocity_rad_s / SPEED);
    let pushes = free.map_or_else(Vec::new, |contact| pushes(&contact));
    let design_ratio = stop.damping_n_s_per_m * radius / (2.0 * inertia * frequency);
    let mut answer = Equivalence {
        rows,
        rebounds,
        pushes,
        tension_from_s,
        speed_rad_s: SPEED,
        restitution: stop.restitution,
        damping_ratio: design_ratio,
        half_period_ratio: free.map_or(0.0, |contact| {
            libm::exp(-contact.decay * contact.half_period_s())
        }),
        released_ratio,
        capture_speed_rad_s,
        headlines: Vec::new(),
    };
    answer.headlines = headlines(design, &answer, free, &rebound)?;
    Ok(answer)
}

/// Returns the torque of the stop over one contact without preload.
fn pushes(contact: &FreeContact) -> Vec<Push> {
    let end = contact.half_period_s();
    (0..=300)
        .map(|index| {
            let time_s = end * f64::from(index) / 300.0;
            Push {
                time_s,
                torque_nm: contact.torque_nm(contact.state(time_s, SPEED)),
            }
        })
        .collect()
}

/// Returns the damping ratio of each restitution.
fn equivalence(points: u32, damping: impl Fn(f64) -> f64) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    // Towards R = 0 the curve becomes vertical, so the points at its foot are spaced by decades.
    let last = f64::from(points);
    let foot = (1..=FOOT).map(|index| libm::pow(10.0, -0.5 * f64::from(FOOT + 1 - index)) / last);
    let body = (1..=points).map(|index| f64::from(index) / last);
    for restitution in foot.chain(body) {
        let ratio = damping_ratio(Restitution::from_ratio(restitution)?);
        rows.push(Row {
            restitution,
            damping_ratio: ratio,
            damping_n_s_per_m: damping(ratio),
        });
    }
    Ok(rows)
}

fn headlines(
    design: &Design,
    answer: &Equivalence,
    free: Option<FreeContact>,
    rebound: &dyn Fn(f64) -> Rebound,
) -> Result<Vec<Headline>, Error> {
    let (lever, stop) = (&design.lever, &design.stop);
    let frequency = stop.contact_angular_frequency_rad_s(lever);
    let radius = stop.radius_m * stop.radius_m;
    let inertia = lever.moment_of_inertia_kg_m2;
    let ratio = damping_ratio(Restitution::from_ratio(stop.restitution)?);
    let torque = stop.contact_damping_nm_s_per_rad(lever);
    let mut formula = Figures::of("formula", StopModel::Soft).digits(DIGITS);
    formula.say("R of the design [-]", stop.restitution);
    formula.say("ξ for it, eq. (2.5) [-]", ratio);
    formula.say(
        "cs = 2 I0 ωR ξ/ls² for it [N s/m]",
        2.0 * inertia * frequency * ratio / radius,
    );
    formula.say(
        "the same with the pivot's damping counted in [N s/m]",
        (2.0 * inertia * frequency * ratio - lever.pivot_damping_nm_s_per_rad) / radius,
    );
    formula.say("cs of the design [N s/m]", stop.damping_n_s_per_m);
    formula.say("its ξ = cs ls²/(2 I0 ωR) [-]", answer.damping_ratio);
    formula.say(
        "cR/(I0 ωR²) as printed, which is a time [s]",
        torque / (inertia * frequency * frequency),
    );
    formula.say(
        "cs if that were taken for ξ [N s/m]",
        ratio * inertia * frequency * frequency / radius,
    );
    let mut limits = Figures::of("limits of the equivalence", StopModel::Soft).digits(DIGITS);
    limits.say(
        "half period of contact π/ω_d [s]",
        free.map(|contact| contact.half_period_s()),
    );
    limits.say(
        "exit over entry speed, no preload [-]",
        free.map(|_| answer.half_period_ratio),
    );
    for speed in [answer.speed_rad_s, 1.0, 0.1] {
        limits.say(
            &format!(
                "with preload, entry at {} rad/s [-]",
                latchgate_kernel::units::plain(speed, 4)
            ),
            rebound(speed).ratio,
        );
    }
    limits.say(
        "entry speed below which the lever stays [rad/s]",
        answer.capture_speed_rad_s,
    );
    limits.say(
        "stop pulls from, after the entry, no preload [s]",
        answer.tension_from_s,
    );
    limits.say(
        "exit over entry speed if it let go there [-]",
        answer.released_ratio,
    );
    Ok([formula.lines, limits.lines].concat())
}
