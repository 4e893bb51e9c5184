//! The nominal runs that a search rests on: of one trial, or of many side by side.

use super::search::Excess;
use crate::meter::Meter;
use crate::{Polarity, Policy, Variant};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::lever::Lever;
use latchgate_kernel::model::stop::{Stop, StopModel};
use latchgate_kernel::parallel::Control;
use latchgate_kernel::replay::batch::{self, AskedPeaks, BatchOptions, Member, MemberPeak};
use latchgate_kernel::replay::{self, Breakdown, RunOptions};
use latchgate_kernel::signal::Signal;
use latchgate_recording::error::Error;

/// One value to try: a lever, its stop and threshold, and the scale of the recording.
#[derive(Debug, Clone, Copy)]
pub(super) struct LeverTrial {
    lever: Lever,
    stop: Stop,
    pub(super) threshold_rad: f64,
    scale: f64,
}

impl LeverTrial {
    pub(super) fn new(design: &Design, scale: f64) -> Self {
        Self {
            lever: design.lever,
            stop: design.stop,
            threshold_rad: design.criterion.threshold_rad,
            scale,
        }
    }
}

/// Largest angle of one run in the window, and of window and coast [rad].
#[derive(Debug, Clone, Copy)]
struct LeverReach {
    peak: f64,
    highest: f64,
}

/// Trials that a thread takes at a time.
const TRIALS_TAKEN: usize = 32;

/// The nominal runs of one recording, by any lever and at any scale.
#[derive(Clone, Copy)]
pub(super) struct NominalRuns<'a> {
    pub(super) signal: &'a Signal,
    pub(super) policy: &'a Policy,
    pub(super) window: Option<(usize, usize)>,
    pub(super) control: &'a Control<'a>,
    /// An angle beyond which no more is asked of a lever in a scan [rad].
    pub(super) enough_rad: f64,
    /// What all runs of the search may take and have taken.
    pub(super) work: &'a Meter,
}

impl NominalRuns<'_> {
    fn initial(&self, trial: &LeverTrial, model: StopModel) -> Option<(f64, f64)> {
        self.policy.initial(model, &trial.stop, &trial.lever)
    }

    /// Joins what the stops of each sign did, in the order of signs, by parts 3 and 4 of the
    /// decision rule with no error counted: a pass if no run goes beyond the threshold in window
    /// or coast; a fail if every one does in the window, or for polarities declared as both every
    /// one of a sign.
    fn joined(&self, reaches: &[LeverReach], threshold_rad: f64) -> Excess {
        let highest = reaches.iter().map(|reach| reach.highest);
        let least_of_signs = reaches
            .chunks(self.policy.model.stops().len())
            .map(|of_sign| {
                let peaks = of_sign.iter().map(|reach| reach.peak);
                peaks.fold(f64::INFINITY, f64::min)
            });
        let fail = match self.policy.polarity {
            Polarity::Both => least_of_signs.fold(f64::NEG_INFINITY, f64::max),
            Polarity::Declared(_) | Polarity::Undeclared => {
                least_of_signs.fold(f64::INFINITY, f64::min)
            }
        };
        Excess {
            pass: highest.fold(f64::NEG_INFINITY, f64::max) - threshold_rad,
            fail: fail - threshold_rad,
        }
    }

    /// Returns the excess of each trial, by levers side by side where the run asked for allows it.
    pub(super) fn scan(&self, trials: &[LeverTrial]) -> Result<Vec<Excess>, Error> {
        self.control.check()?;
        let started_by_speed_alone =
            self.policy.initial_angle_rad.is_none() && self.policy.initial_velocity_rad_s.is_some();
        if started_by_speed_alone {
            // The soft stop's angle of rest is each lever's own.
            return trials.iter().map(|trial| self.exact(trial)).collect();
        }
        let variants = self.policy.variants();
        let tasks: Vec<(Variant, &[LeverTrial])> = variants
            .iter()
            .flat_map(|variant| trials.chunks(TRIALS_TAKEN).map(|taken| (*variant, taken)))
            .collect();
        self.work.share_out(tasks.len());
        let found = self
            .control
            .try_map(&tasks, |(variant, taken)| self.peaks(*variant, taken))?;
        let found: Vec<LeverReach> = found.into_iter().flatten().collect();
        Ok(trials
            .iter()
            .enumerate()
            .map(|(index, trial)| {
                let of_variants = found.chunks(trials.len()).map(|of| of[index]);
                self.joined(&of_variants.collect::<Vec<_>>(), trial.threshold_rad)
            })
            .collect())
    }

    /// Returns how far the levers of some trials come on one variant; zero for those that stay in the
    /// soft stop.
    fn peaks(&self, variant: Variant, trials: &[LeverTrial]) -> Result<Vec<LeverReach>, Error> {
        let options = BatchOptions {
            stop: variant.model,
            opens_when: variant.opens_when,
            initial: trials
                .first()
                .and_then(|trial| self.initial(trial, variant.model)),
            window: self.window,
            coast: true,
            asked: AskedPeaks {
                from_rad: 0.0,
                to_rad: self.enough_rad,
            },
            threads: 1,
        };
        let member = |index: usize| {
            let trial = &trials[index];
            Member {
                lever: trial.lever,
                stop: trial.stop,
                scale: trial.scale,
                bias_m_s2: 0.0,
            }
        };
        let within = self.work.within_of_members(self.control);
        let peaks = batch::peaks_within(self.signal, trials.len(), &member, &options, &within)?;
        self.work.add(peaks.iter().map(|peak| peak.spent).sum());
        let reached = |of: &MemberPeak| {
            // What is no number stays none.
            let peak = if of.peak_angle_rad < 0.0 {
                0.0
            } else {
                of.peak_angle_rad
            };
            reach(peak, of.coast_peak_angle_rad, true)
        };
        Ok(peaks.iter().map(reached).collect())
    }

    /// Returns the excess of one trial by the method asked for.
    pub(super) fn exact(&self, trial: &LeverTrial) -> Result<Excess, Error> {
        self.control.check()?;
        let scaled = Signal {
            samples: self
                .signal
                .samples
                .iter()
                .map(|a| a * trial.scale)
                .collect(),
            ..*self.signal
        };
        let design = Design {
            lever: trial.lever,
            stop: trial.stop,
            ..Design::reference()
        };
        let mut reaches = Vec::new();
        for Variant { opens_when, model } in self.policy.variants() {
            let (method, tolerance_rad) = self.policy.method_on(model);
            let options = RunOptions {
                method,
                tolerance_rad,
                initial: self.initial(trial, model),
                window: self.window,
                error_bound: false,
                peak_only: true,
                ..RunOptions::new(model, opens_when)
            };
            self.work.share_out(1);
            let within = self.work.within(self.control);
            let outcome = replay::run_within(&scaled, &design, &options, &within)?;
            self.work.add(outcome.spent);
            if outcome.breakdown == Some(Breakdown::TooManySteps) {
                self.work.cut();
            }
            let (peak, coast) = (outcome.run.peak_angle_rad, outcome.run.coast_peak_angle_rad);
            reaches.push(reach(peak, coast, !outcome.broke_down));
        }
        Ok(self.joined(&reaches, trial.threshold_rad))
    }
}

/// A lever that could not be followed counts as one that goes beyond any threshold: nothing that
/// is not known passes.
fn reach(peak: f64, coast: Option<f64>, followed: bool) -> LeverReach {
    let known = followed && peak.is_finite() && coast.is_none_or(f64::is_finite);
    if known {
        LeverReach {
            peak,
            highest: coast.map_or(peak, |coast| coast.max(peak)),
        }
    } else {
        LeverReach {
            peak: f64::NEG_INFINITY,
            highest: f64::INFINITY,
        }
    }
}
