//! The lever on a smooth sine, piece by piece.

use super::forcing::Sine;
use super::kernel::Kernel;
use super::{Outcome, RunOptions};
use crate::model::Design;
use crate::model::excitation::Harmonic;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Periods that a run may last.
pub(super) const PERIODS_MAX: f64 = 1e7;

/// A sine cut into quarters of its period, so that no phase grows with time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Quarters {
    /// b = m L a/I0 of a whole sine [rad/s²].
    amplitude: f64,
    angular_frequency: f64,
    /// Phase at time 0, within a turn [rad].
    phase: f64,
    /// Length of a quarter [s].
    length: f64,
}

impl Quarters {
    /// Cuts `excitation`, which acts on `kernel`, in the model's sign.
    pub(super) fn new(excitation: &Harmonic, kernel: &Kernel) -> Self {
        let amplitude = kernel.gain() * excitation.amplitude_m_s2;
        let turned = if amplitude < 0.0 { PI } else { 0.0 };
        Self {
            amplitude: amplitude.abs(),
            angular_frequency: excitation.angular_frequency_rad_s,
            phase: excitation.phase_rad % TAU + turned,
            length: FRAC_PI_2 / excitation.angular_frequency_rad_s,
        }
    }

    /// Returns the time at which quarter `index` starts [s].
    #[expect(clippy::cast_precision_loss, reason = "far below 2^53")]
    pub(super) fn start_s(&self, index: u64) -> f64 {
        index as f64 * self.length
    }

    /// Returns quarter `index`, up to `end` [s].
    #[expect(clippy::cast_precision_loss, reason = "at most three")]
    pub(super) fn piece(&self, index: u64, end: f64) -> Sine {
        let time = self.start_s(index);
        Sine {
            time,
            length: self.length.min(end - time),
            amplitude: self.amplitude,
            angular_frequency: self.angular_frequency,
            phase: self.phase + (index % 4) as f64 * FRAC_PI_2,
        }
    }
}

/// Runs the event-driven kernel from time 0 to `end` [s].
pub(super) fn run(
    excitation: &Harmonic,
    end: f64,
    design: &Design,
    options: &RunOptions,
) -> Outcome {
    pulp::Arch::new().dispatch(Drive {
        excitation,
        end,
        design,
        options,
    })
}

/// The run, compiled for what the machine has.
struct Drive<'a> {
    excitation: &'a Harmonic,
    end: f64,
    design: &'a Design,
    options: &'a RunOptions,
}

impl pulp::WithSimd for Drive<'_> {
    type Output = Outcome;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _simd: S) -> Outcome {
        let mut kernel = super::begin(0.0, self.design, self.options);
        let quarters = Quarters::new(self.excitation, &kernel);
        let error = kernel.angle_error();
        let angle = kernel.state().0;
        kernel.tally.open_window(angle, 0.0, error);
        let mut index = 0;
        while quarters.start_s(index) < self.end && !kernel.stuck {
            kernel.advance_sine(&quarters.piece(index, self.end));
            index += 1;
        }
        super::finish(kernel, self.end, self.design, self.options)
    }
}
