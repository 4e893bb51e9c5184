//! The lever on a smooth sine: a run, and the same observed once a period.

use super::forcing::Sine;
use super::kernel::Kernel;
use super::recorder::Recorder;
use super::tangent::Tangent;
use super::{RunOptions, RunOutcome, State, Within};
use crate::error::Error;
use crate::model::Design;
use crate::model::excitation::Harmonic;
use crate::model::stop::StopModel;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Periods that a run may last.
pub(super) const PERIODS_MAX: f64 = 1e7;

/// Points of a trace in a quarter of a period, at least: enough to draw the curve by lines.
const TRACE_POINTS_PER_QUARTER: f64 = 16.0;

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
    pub(super) fn start_s(&self, index: u64) -> f64 {
        index as f64 * self.length
    }

    /// Returns quarter `index`, up to `end` [s].
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
) -> RunOutcome {
    pulp::Arch::new().dispatch(HarmonicRun {
        excitation,
        end,
        design,
        options,
    })
}

/// The run, compiled for what the machine has.
struct HarmonicRun<'a> {
    excitation: &'a Harmonic,
    end: f64,
    design: &'a Design,
    options: &'a RunOptions,
}

impl pulp::WithSimd for HarmonicRun<'_> {
    type Output = RunOutcome;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _simd: S) -> RunOutcome {
        let mut kernel = super::body::begin(0.0, self.design, self.options);
        let quarters = Quarters::new(self.excitation, &kernel);
        if self.options.trace {
            kernel.recorder.trace_gap_s = quarters.length / TRACE_POINTS_PER_QUARTER;
        }
        let error = kernel.angle_error();
        kernel.recorder.open_window(kernel.angle, 0.0, error);
        let mut index = 0;
        while quarters.start_s(index) < self.end && !kernel.stuck {
            kernel.advance_sine(&quarters.piece(index, self.end));
            index += 1;
        }
        let question = super::Question {
            design: self.design,
            options: self.options,
            first: 0,
            last: 0,
            within: &Within::UNBOUNDED,
        };
        super::drive::finish(kernel, self.end, &question, false)
    }
}

/// Checks what a stroboscope starts from.
pub(super) fn check(
    stop: StopModel,
    excitation: &Harmonic,
    initial: Option<State>,
) -> Result<(), Error> {
    let mut options = RunOptions::new(stop, crate::units::OpensWhen::Negative);
    options.initial = initial;
    super::check_initial(&options)?;
    let quarter = FRAC_PI_2 / excitation.angular_frequency_rad_s;
    let sound = quarter > 0.0
        && quarter.is_finite()
        && excitation.amplitude_m_s2.is_finite()
        && excitation.phase_rad.is_finite();
    if !sound {
        return Err(Error::out_of_range(
            "excitation (amplitude [m/s²], angular frequency [rad/s], phase [rad])",
            "finite numbers, the frequency positive",
            format!(
                "({}, {}, {})",
                excitation.amplitude_m_s2, excitation.angular_frequency_rad_s, excitation.phase_rad
            ),
        ));
    }
    Ok(())
}

/// The lever as a stroboscope sees it, at the same phase of each period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// Angle [rad].
    pub angle_rad: f64,
    /// Angular velocity [rad/s].
    pub velocity_rad_s: f64,
    /// Largest angle in the period that has just ended [rad].
    pub peak_angle_rad: f64,
    /// Impacts (soft stop: contact entries) in it, faster than 1e-3 rad/s.
    pub impacts: u64,
    /// Whether the lever came to rest on the rigid stop in it.
    pub rested: bool,
}

impl Section {
    /// Returns the state that is seen.
    pub fn state(&self) -> State {
        State::new(self.angle_rad, self.velocity_rad_s)
    }
}

/// Derivatives of the state at the end of a stretch of periods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StrobeMap {
    /// By the state at the start: d(angle, velocity)/d(angle, velocity), row by row.
    pub by_state: [[f64; 2]; 2],
    /// By the relative strength of the excitation: A d(angle, velocity)/dA [rad, rad/s].
    pub by_amplitude: [f64; 2],
}

/// A lever on a smooth sine, observed once a period.
///
/// The excitation is a(t) = A sin(ω t + θ), negative opening; the first period starts at t = 0.
///
/// # Source
///
/// Section 3 of the paper: stroboscopic sections at t = 0 mod 2π/ω.
#[derive(Debug, Clone)]
pub struct Strobe {
    kernel: Kernel,
    quarters: Quarters,
}

impl Strobe {
    /// Puts a lever in its initial state, or at rest.
    ///
    /// # Errors
    ///
    /// [`crate::error::Error::OutOfRange`] for an initial state that the stop does not admit,
    /// an angular frequency that is not positive, an amplitude or a phase that is not finite.
    pub fn new(
        design: &Design,
        stop: StopModel,
        excitation: &Harmonic,
        initial: Option<State>,
    ) -> Result<Self, Error> {
        check(stop, excitation, initial)?;
        let kernel = Kernel::new(design, stop, initial, None, Recorder::peak_only())
            .for_ever()
            .without_error_bound();
        Ok(Self {
            quarters: Quarters::new(excitation, &kernel),
            kernel,
        })
    }

    /// Returns the state.
    pub fn state(&self) -> State {
        self.kernel.state()
    }

    /// Follows derivatives from here on; see [`Self::map`].
    pub fn start_map(&mut self) {
        self.kernel.tangent = Some(Tangent::START);
    }

    /// Returns the derivatives since [`Self::start_map`]; `None` if nobody called that.
    pub fn map(&self) -> Option<StrobeMap> {
        self.kernel
            .tangent
            .map(|Tangent([first, second, third])| StrobeMap {
                by_state: [[first[0], second[0]], [first[1], second[1]]],
                by_amplitude: third,
            })
    }

    /// Moves on by a period; `None` if the lever can no longer be followed.
    pub fn advance(&mut self) -> Option<Section> {
        pulp::Arch::new().dispatch(Period { strobe: self })
    }
}

/// A period, compiled for what the machine has.
struct Period<'a> {
    strobe: &'a mut Strobe,
}

impl pulp::WithSimd for Period<'_> {
    type Output = Option<Section>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _simd: S) -> Self::Output {
        let Strobe { kernel, quarters } = self.strobe;
        let (impacts_before, rests_before) = (kernel.recorder.impacts, kernel.rests);
        kernel.recorder.open_window(kernel.angle, 0.0, 0.0);
        for index in 0..4 {
            kernel.advance_sine(&quarters.piece(index, f64::INFINITY));
        }
        let (angle_rad, velocity_rad_s) = (kernel.angle, kernel.velocity);
        (!kernel.stuck).then(|| Section {
            angle_rad,
            velocity_rad_s,
            peak_angle_rad: kernel.recorder.peak.angle.max(angle_rad),
            impacts: kernel.recorder.impacts - impacts_before,
            rested: kernel.rests > rests_before,
        })
    }
}
