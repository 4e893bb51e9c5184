//! A sine's period cut into equal pieces: what is known of each before any lever flies.

use super::{State, StrobeBatchOptions};
use crate::model::Design;
use crate::model::stop::StopModel;
use crate::range::Range;
use crate::replay::eventless_step::StepCoefficients;
use crate::replay::forcing::Sine;
use crate::replay::kernel::Kernel;
use crate::replay::recorder::Recorder;
use crate::replay::taylor::Branch;
use std::f64::consts::{PI, TAU};

/// Terms of a piece's series: all that a step of eleven orders has a use for.
pub(super) const TERMS: usize = 10;

/// Fewest and most pieces of a period.
const PIECES: (usize, usize) = (48, 1 << 15);

/// Largest truncation of a step over a piece that is aimed at, relative to the motion: a fifth of
/// what is let pass.
const TRUNCATION: f64 = 2e-17;

/// Depth in the soft stop [rad] down to which cos φ = 1: what that leaves out is 5e-11 of the
/// excitation, 1e-15 rad at 100 g.
const SHALLOW: f64 = 1e-5;

/// Returns the pieces into which a period is cut for a lever shaken by `amplitude` [m/s²].
pub(super) fn pieces(design: &Design, angular_frequency: f64, amplitude: f64) -> usize {
    let kernel = lever(design, StopModel::Rigid);
    let period = TAU / angular_frequency;
    let strength = (kernel.gain() * amplitude).abs();
    // How fast levers are that a sine keeps going, by and large, from the reference lever's runs
    // at ω = 20 and 100 rad/s; one that is faster takes its pieces by the kernel.
    let speed = (strength / angular_frequency)
        .max((1.2 * strength).sqrt())
        .min((16.0 * strength).sqrt())
        .max(10.0);
    let mut pieces = PIECES.0;
    while pieces < PIECES.1 {
        let length = period / pieces as f64;
        // Order ten of the angle is the excitation times order eight of what turns, and that
        // times an eighth of the turn is what a step takes for its truncation.
        let turn = (speed + angular_frequency) * length;
        let bend = (strength + kernel.free_branch().pressing) * length / speed;
        let truncation = bend * libm::pow(turn, 9.0) / (8.0 * 40_320.0 * 90.0);
        if truncation <= TRUNCATION
            && StepCoefficients::scaled(kernel.free_branch(), length).is_some()
        {
            break;
        }
        // By four thirds and by one and a half in turns: 48, 64, 96, 128 ...
        pieces = if pieces.is_multiple_of(3) {
            pieces / 3 * 4
        } else {
            pieces / 2 * 3
        };
    }
    pieces
}

fn lever(design: &Design, stop: StopModel) -> Kernel {
    Kernel::new(design, stop, None, None, Recorder::peak_only())
}

/// A period in pieces.
pub(super) struct Cut {
    /// Length of a piece [s].
    pub(super) length: f64,
    angular_frequency: f64,
    /// Turn of the sine over a piece [rad].
    pub(super) swing: f64,
    /// T0/I0 [rad/s²].
    pub(super) pressing: f64,
    pub(super) table: Vec<Piece>,
    /// The lever off the stop; `None` if a piece is too long for its own motion.
    pub(super) coefficients: Option<StepCoefficients<f64>>,
    settled: Option<SteadyResponse>,
}

/// One piece, of a sine of amplitude one.
pub(super) struct Piece {
    /// Time of its start in the period [s].
    time: f64,
    /// Phase of its start [rad].
    phase: f64,
    /// Cosine of that.
    cosine: f64,
    /// The sine in powers of the time over the piece.
    pub(super) series: [f64; TERMS],
    /// Bound on its size over the piece.
    pub(super) strongest: f64,
    /// Bounds on its values over the piece.
    range: Range,
}

impl Piece {
    fn new(index: usize, pieces: usize, angular_frequency: f64, phase: f64) -> Self {
        let turn = TAU / pieces as f64;
        let phase_at = |index: usize| phase % TAU + index as f64 * turn;
        let (sine, cosine) = libm::sincos(phase_at(index));
        let after = libm::sin(phase_at(index + 1));
        // The derivatives go round: sine, cosine, −sine, −cosine.
        let round = [sine, cosine, -sine, -cosine];
        let mut factor = 1.0;
        let series = std::array::from_fn(|n| {
            let term = factor * round[n % 4];
            factor *= turn / (n + 1) as f64;
            term
        });
        // Off its chord a sine is by no more than an eighth of the turn's square.
        let bulge = 0.125 * turn * turn + 1e-12;
        Self {
            time: index as f64 * turn / angular_frequency,
            phase: phase_at(index),
            cosine,
            series,
            strongest: (sine.abs().max(after.abs()) + bulge).min(1.0),
            range: Range::new(sine.min(after) - bulge, sine.max(after) + bulge),
        }
    }

    /// Returns a bound below b over the piece for a sine of `strength` [rad/s²].
    #[inline(always)]
    pub(super) fn lowest(&self, strength: f64) -> f64 {
        (strength * self.range.low).min(strength * self.range.high)
    }

    /// Returns the piece as the scalar kernel takes it.
    pub(super) fn sine(&self, cut: &Cut, strength: f64) -> Sine {
        Sine {
            time: self.time,
            length: cut.length,
            amplitude: strength.abs(),
            angular_frequency: cut.angular_frequency,
            phase: self.phase + if strength < 0.0 { PI } else { 0.0 },
        }
    }
}

impl Cut {
    /// Cuts the period into `pieces`.
    pub(super) fn new(design: &Design, options: &StrobeBatchOptions, pieces: usize) -> Self {
        let angular_frequency = options.angular_frequency_rad_s;
        let kernel = lever(design, options.stop);
        let length = TAU / angular_frequency / pieces as f64;
        let piece = |index| Piece::new(index, pieces, angular_frequency, options.phase_rad);
        Self {
            length,
            angular_frequency,
            swing: TAU / pieces as f64,
            pressing: kernel.free_branch().pressing,
            table: (0..pieces).map(piece).collect(),
            coefficients: StepCoefficients::scaled(kernel.free_branch(), length),
            settled: kernel
                .contact_branch()
                .and_then(|branch| SteadyResponse::new(branch, angular_frequency, length)),
        }
    }

    /// Takes a lever that stays shallow in the soft stop over piece `index`; false if it may not
    /// stay there.
    pub(super) fn press(&self, kernel: &mut Kernel, strength: f64, index: usize) -> bool {
        let Some(settled) = self.settled.as_ref().filter(|_| kernel.is_pressed()) else {
            return false;
        };
        let (from, to) = (
            &self.table[index],
            &self.table[(index + 1) % self.table.len()],
        );
        let (before, after) = (settled.state(strength, from), settled.state(strength, to));
        let angle = kernel.angle - before.angle_rad;
        let velocity = kernel.velocity - before.velocity_rad_s;
        // The energy of what rings falls.
        let ring = (angle * angle + velocity * velocity / settled.stiffness).sqrt();
        let Range { low, high } = settled.range(strength, from);
        if !(high + ring < 0.0 && low - ring > -SHALLOW) {
            return false;
        }
        if kernel.recorder.judging && high + ring > kernel.recorder.peak.angle {
            // Where the settled motion is slower than the ringing, a turn may be the peak.
            let speed = ring * settled.stiffness.sqrt() + settled.bend(strength, self.swing);
            let (from, to) = (before.velocity_rad_s, after.velocity_rad_s);
            let slowest = if from * to > 0.0 {
                from.abs().min(to.abs())
            } else {
                0.0
            };
            if slowest <= 1.01 * speed {
                return false;
            }
        }
        let [[a, b], [c, d]] = settled.ring;
        kernel.put_pressed(
            after.angle_rad + (a * angle + b * velocity),
            after.velocity_rad_s + (c * angle + d * velocity),
        );
        true
    }
}

/// The lever in the soft stop as a linear oscillator on a sine: what it settles to, and what of
/// a difference from that is left after a piece.
struct SteadyResponse {
    /// Angle under the preload alone [rad].
    rest: f64,
    /// Response per b in phase with the sine [s²].
    in_phase: f64,
    /// Response per b in phase with the cosine [s²].
    in_quadrature: f64,
    angular_frequency: f64,
    /// k/I0 [1/s²].
    stiffness: f64,
    ring: [[f64; 2]; 2],
}

impl SteadyResponse {
    /// Solves u'' + γ u' + k u = −p − b sin; `None` unless it rings.
    fn new(branch: &Branch, angular_frequency: f64, length: f64) -> Option<Self> {
        let (half, stiffness) = (0.5 * branch.damping, branch.stiffness);
        let ringing = (stiffness - half * half).sqrt();
        let apart = stiffness - angular_frequency * angular_frequency;
        let lag = branch.damping * angular_frequency;
        let size = apart * apart + lag * lag;
        let (sine, cosine) = libm::sincos(ringing * length);
        let (decay, sine) = (libm::exp(-half * length), sine / ringing);
        (ringing > 0.0 && size > 0.0).then(|| Self {
            rest: -branch.pressing / stiffness,
            in_phase: -apart / size,
            in_quadrature: lag / size,
            angular_frequency,
            stiffness,
            ring: [
                [decay * (cosine + half * sine), decay * sine],
                [-decay * stiffness * sine, decay * (cosine - half * sine)],
            ],
        })
    }

    /// Returns the state settled to, at the start of `piece`.
    fn state(&self, strength: f64, piece: &Piece) -> State {
        let (with, across) = (strength * self.in_phase, strength * self.in_quadrature);
        let (sine, cosine) = (piece.series[0], piece.cosine);
        State::new(
            self.rest + (with * sine + across * cosine),
            self.angular_frequency * (with * cosine - across * sine),
        )
    }

    /// Returns how far that velocity is off its chord over a piece, at most [rad/s].
    fn bend(&self, strength: f64, turn: f64) -> f64 {
        let size = strength.abs() * (self.in_phase.abs() + self.in_quadrature.abs());
        0.125 * turn * turn * self.angular_frequency * size
    }

    /// Returns bounds on that angle over `piece` [rad].
    fn range(&self, strength: f64, piece: &Piece) -> Range {
        let (with, across) = (strength * self.in_phase, strength * self.in_quadrature);
        let (from_low, from_high) = (with * piece.range.low, with * piece.range.high);
        Range::new(
            self.rest + from_low.min(from_high) - across.abs(),
            self.rest + from_low.max(from_high) + across.abs(),
        )
    }
}
