//! What the samples carry along, and how its parts begin.

use super::kernel::{CURVED_TRUNCATION, Coasting, Kernel};
use super::recorder::Recorder;
use super::{Question, RunOptions};
use crate::model::Design;
use crate::signal::STRAIGHT;

/// What moves under the samples: a lever, alone or beside what stands next to it.
pub(super) trait Body: Coasting {
    /// Carries it through whole samples from `index` on, before `stop_at`, in which nothing happens to it;
    /// returns how many.
    fn calm_samples(&mut self, index: usize, stop_at: usize) -> usize;

    /// Carries it over the sample `index`, whatever happens in it.
    fn sample(&mut self, index: usize);
}

/// Puts the lever of an event-driven run where it starts, at `start` [s].
pub(super) fn begin(start: f64, design: &Design, options: &RunOptions) -> Kernel {
    let recorder = Recorder::new(design.criterion.threshold_rad, options.trace);
    let mut kernel = Kernel::new(
        design,
        options.stop,
        options.initial,
        options.tolerance_rad,
        recorder,
    );
    if !options.error_bound {
        kernel = kernel.without_error_bound();
        if options.peak_only {
            kernel = kernel.for_peak();
        }
    }
    if let Some(noise) = options.noise_m2_s3 {
        kernel.carry_noise(noise);
    }
    let (angle, velocity) = (kernel.angle, kernel.velocity);
    if angle > 0.0 || (angle >= 0.0 && velocity > 0.0) {
        kernel.recorder.release(start);
    }
    kernel.recorder.point(start, angle, velocity);
    kernel
}

/// Lets a body's part take what a run of the question may take, and pass what it may leave out.
pub(super) fn limited<const K: usize>(kernel: Kernel, question: &Question<'_>) -> Kernel {
    let mut kernel = kernel.for_samples(question.last);
    if K > STRAIGHT {
        // A run that is compared with another need not be as exact.
        let times = if question.options.error_bound {
            0.1
        } else {
            100.0
        };
        kernel = kernel.letting_pass(times * CURVED_TRUNCATION);
    }
    kernel.at_most(question.within.steps_max);
    kernel
}
