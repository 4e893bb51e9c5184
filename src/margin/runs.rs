//! What the lever does at one setting, or at many: the runs that a search rests on.

use super::search::Excess;
use crate::conditioning::Signal;
use crate::error::Error;
use crate::model::Design;
use crate::model::lever::Lever;
use crate::model::stop::{Stop, StopModel};
use crate::parallel::Control;
use crate::replay::batch::{self, BatchOptions, Member, MemberPeak};
use crate::replay::{self, Method, RunOptions};
use crate::units::OpensWhen;
use crate::verdict::{Polarity, Policy};

/// A lever, its stop and threshold, and the scale of the recording.
#[derive(Debug, Clone, Copy)]
pub(super) struct Setting {
    lever: Lever,
    stop: Stop,
    pub(super) threshold_rad: f64,
    scale: f64,
}

impl Setting {
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
struct Reach {
    peak: f64,
    highest: f64,
}

/// What every run of a search shares.
pub(super) struct Bench<'a> {
    pub(super) signal: &'a Signal,
    pub(super) policy: &'a Policy,
    pub(super) control: &'a Control<'a>,
    pub(super) window: Option<(usize, usize)>,
}

impl Bench<'_> {
    fn stops(&self) -> &'static [StopModel] {
        self.policy.model.stops()
    }

    fn signs(&self) -> &'static [OpensWhen] {
        self.policy.polarity.signs()
    }

    /// The initial state asked for, what is left open being that of rest on the stop.
    fn initial(&self, setting: &Setting, stop: StopModel) -> Option<(f64, f64)> {
        let (angle, velocity) = (
            self.policy.initial_angle_rad,
            self.policy.initial_velocity_rad_s,
        );
        if angle.is_none() && velocity.is_none() {
            return None;
        }
        let rest = match stop {
            StopModel::Rigid => 0.0,
            StopModel::Soft => setting.stop.rest_angle_rad(&setting.lever),
        };
        Some((angle.unwrap_or(rest), velocity.unwrap_or(0.0)))
    }

    /// Joins what the stops of each sign did, in the order of signs, by parts 3 and 4 of the
    /// decision rule with no error counted: a pass if no run goes beyond the threshold in window
    /// or coast; a fail if every one does in the window, or for polarities declared as both every
    /// one of a sign.
    fn joined(&self, reaches: &[Reach], threshold_rad: f64) -> Excess {
        let highest = reaches.iter().map(|reach| reach.highest);
        let least_of_signs = reaches.chunks(self.stops().len()).map(|of_sign| {
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

    /// Returns the excess at each setting, by levers side by side where the run asked for
    /// allows it.
    pub(super) fn scan(&self, settings: &[Setting]) -> Result<Vec<Excess>, Error> {
        let started_by_speed_alone =
            self.policy.initial_angle_rad.is_none() && self.policy.initial_velocity_rad_s.is_some();
        if started_by_speed_alone {
            // The soft stop's angle of rest is each lever's own.
            return settings
                .iter()
                .map(|setting| self.exact_at(setting))
                .collect();
        }
        let mut of_pairs: Vec<Vec<MemberPeak>> = Vec::new();
        for sign in self.signs() {
            for stop in self.stops() {
                let options = BatchOptions {
                    stop: *stop,
                    opens_when: *sign,
                    initial: settings
                        .first()
                        .and_then(|setting| self.initial(setting, *stop)),
                    window: self.window,
                    coast: true,
                    threads: self.control.threads,
                };
                let member = |index: usize| {
                    let setting = &settings[index];
                    Member {
                        lever: setting.lever,
                        stop: setting.stop,
                        scale: setting.scale,
                        bias_m_s2: 0.0,
                    }
                };
                of_pairs.push(batch::peaks(
                    self.signal,
                    settings.len(),
                    &member,
                    &options,
                )?);
            }
        }
        Ok(settings
            .iter()
            .enumerate()
            .map(|(index, setting)| {
                let reaches: Vec<Reach> = of_pairs
                    .iter()
                    .map(|peaks| {
                        let MemberPeak {
                            peak_angle_rad,
                            coast_peak_angle_rad,
                            ..
                        } = peaks[index];
                        reach(peak_angle_rad, coast_peak_angle_rad, true)
                    })
                    .collect();
                self.joined(&reaches, setting.threshold_rad)
            })
            .collect())
    }

    /// Returns the excess at one setting by the method asked for.
    pub(super) fn exact(&self, design: &Design, scale: f64) -> Result<Excess, Error> {
        self.exact_at(&Setting::new(design, scale))
    }

    pub(super) fn exact_at(&self, setting: &Setting) -> Result<Excess, Error> {
        let scaled = Signal {
            samples: self
                .signal
                .samples
                .iter()
                .map(|a| a * setting.scale)
                .collect(),
            ..*self.signal
        };
        let design = Design {
            lever: setting.lever,
            stop: setting.stop,
            ..Design::reference()
        };
        let mut reaches = Vec::new();
        for sign in self.signs() {
            for stop in self.stops() {
                let (method, tolerance_rad) = if self.policy.method.admits(*stop) {
                    (self.policy.method, self.policy.tolerance_rad)
                } else {
                    (Method::EventDriven, None)
                };
                let outcome = replay::run(
                    &scaled,
                    &design,
                    &RunOptions {
                        method,
                        tolerance_rad,
                        initial: self.initial(setting, *stop),
                        window: self.window,
                        error_bound: false,
                        ..RunOptions::new(*stop, *sign)
                    },
                )?;
                let run = &outcome.run;
                reaches.push(reach(
                    run.peak_angle_rad,
                    run.coast_peak_angle_rad,
                    !outcome.broke_down,
                ));
            }
        }
        Ok(self.joined(&reaches, setting.threshold_rad))
    }
}

/// A lever that could not be followed counts as one that goes beyond any threshold: nothing that
/// is not known passes.
fn reach(peak: f64, coast: Option<f64>, followed: bool) -> Reach {
    let known = followed && peak.is_finite() && coast.is_none_or(f64::is_finite);
    if known {
        Reach {
            peak,
            highest: coast.map_or(peak, |coast| coast.max(peak)),
        }
    } else {
        Reach {
            peak: f64::NEG_INFINITY,
            highest: f64::INFINITY,
        }
    }
}
