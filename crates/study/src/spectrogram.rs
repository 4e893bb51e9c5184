//! The paper's Fig. 5: spectrogram of the free vibration with preload, and the frequency of its
//! bounces.

use super::free::{self, Against, FreeMotion, Release};
use super::{Figures, Headline};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::State;
use latchgate_kernel::units::SampleRate;
use latchgate_recording::error::Error;
use latchgate_verdict::conditioning::spectrum::{self, ShortTime};
use serde::Serialize;

/// Options of the spectrogram of a free vibration.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Options {
    /// The lever.
    pub design: Design,
    /// Stop.
    pub model: StopModel,
    /// Initial angle [rad].
    #[serde(rename = "phi0_rad")]
    pub angle_rad: f64,
    /// Initial angular velocity [rad/s].
    #[serde(rename = "omega0_rad_s")]
    pub velocity_rad_s: f64,
    /// Length [natural periods].
    pub periods: f64,
    /// Window [natural periods].
    #[serde(rename = "window")]
    pub window_periods: f64,
}

/// A bounce: from one impact to the next.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Bounce {
    /// The middle between the two impacts [s].
    pub time_s: f64,
    /// One over its length [Hz].
    pub frequency_hz: f64,
}

/// A cell of the spectrogram, as a row.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Row {
    /// Centre of the window [s].
    pub time_s: f64,
    /// Frequency [Hz].
    pub frequency_hz: f64,
    /// Amplitude of the angular velocity [rad/s].
    pub amplitude_rad_s: f64,
}

/// Result of the study.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionSpectrogram {
    /// The motion.
    pub motion: FreeMotion,
    /// Its bounces.
    pub bounces: Vec<Bounce>,
    /// Short-time amplitudes of the angular velocity [rad/s].
    pub amplitudes: ShortTime,
    /// Highest frequency kept: 1.6 times that of the tenth bounce, or of the last [Hz].
    pub highest_hz: f64,
    /// Length of the motion [s].
    pub duration_s: f64,
    /// Headline figures.
    pub headlines: Vec<Headline>,
}

/// Points of the motion in a natural period.
const POINTS_PER_PERIOD: f64 = 1024.0;

/// Largest number of windows in the picture.
const COLUMNS: usize = 320;

/// Runs the study.
///
/// The angular velocity is transformed, not the angle: over a bounce its mean is zero, so that
/// no line at zero frequency hides the bounces.
///
/// # Errors
///
/// As [`free::natural_period_s`] and [`free::run`]; [`OutOfRange`](latchgate_kernel::error::Error::OutOfRange) for a
/// window longer than the motion.
pub fn run(options: &Options) -> Result<MotionSpectrogram, Error> {
    let design = &options.design;
    let period = free::natural_period_s(design)?;
    if options.window_periods >= options.periods {
        return Err(Error::out_of_range(
            "window [natural periods]",
            format!("shorter than the motion, {}", options.periods),
            options.window_periods.to_string(),
        ));
    }
    let rate_hz = POINTS_PER_PERIOD / period;
    let duration_s = options.periods * period;
    let motion = free::run(
        design,
        Against::stop(options.model),
        &Release {
            preload_torque_nm: design.lever.preload_torque_nm,
            start: State::new(options.angle_rad, options.velocity_rad_s),
            duration_s,
            rate_hz,
        },
    )?;
    let velocities = uniform(&motion, rate_hz, duration_s);
    let rate = SampleRate::from_hertz(rate_hz)?;
    let length = (options.window_periods * POINTS_PER_PERIOD) as usize;
    let mut amplitudes = spectrum::short_time(&velocities, 0.0, rate, length, COLUMNS);
    let bounces: Vec<Bounce> = motion
        .intervals()
        .into_iter()
        .map(|interval| Bounce {
            time_s: interval.middle_s,
            frequency_hz: 1.0 / interval.length_s,
        })
        .collect();
    let half_the_rate = 0.5 * rate_hz;
    let highest_hz = bounces
        .get(9)
        .or(bounces.last())
        .map_or(half_the_rate, |bounce| {
            (1.6 * bounce.frequency_hz).min(half_the_rate)
        });
    let bins = amplitudes
        .frequency_hz
        .iter()
        .take_while(|frequency| **frequency <= highest_hz)
        .count();
    amplitudes.frequency_hz.truncate(bins);
    for row in &mut amplitudes.amplitudes {
        row.truncate(bins);
    }
    let mut figures = Figures::of("bounces", options.model);
    let frequency_hz = |index: usize| bounces.get(index).map(|bounce| bounce.frequency_hz);
    figures.say("frequency of the first [Hz]", frequency_hz(0));
    figures.say("frequency of the second [Hz]", frequency_hz(1));
    figures.say("frequency of the fifth [Hz]", frequency_hz(4));
    figures.say("frequency of the tenth [Hz]", frequency_hz(9));
    figures.say("natural frequency ω0/2π, without stop [Hz]", 1.0 / period);
    figures.say("stays on the stop from [s]", motion.settled_s);
    figures.say("window [s]", amplitudes.window_s);
    Ok(MotionSpectrogram {
        motion,
        bounces,
        amplitudes,
        highest_hz,
        duration_s,
        headlines: figures.lines,
    })
}

/// Returns the angular velocity at equal distances. The history holds these instants, so straight lines between its
/// points only round the time.
fn uniform(motion: &FreeMotion, rate_hz: f64, duration_s: f64) -> Vec<f64> {
    let count = (duration_s * rate_hz).floor() as usize + 1;
    let trace = &motion.trace;
    let mut next = 0;
    (0..count)
        .map(|index| {
            let time = index as f64 / rate_hz;
            while next < trace.len() && trace[next].time_s <= time {
                next += 1;
            }
            match (next.checked_sub(1).map(|last| trace[last]), trace.get(next)) {
                (Some(before), Some(after)) => {
                    let share = (time - before.time_s) / (after.time_s - before.time_s);
                    before.velocity_rad_s + share * (after.velocity_rad_s - before.velocity_rad_s)
                }
                (Some(last), None) => last.velocity_rad_s,
                (None, Some(first)) => first.velocity_rad_s,
                (None, None) => 0.0,
            }
        })
        .collect()
}

impl MotionSpectrogram {
    /// Returns the cells as rows.
    pub fn rows(&self) -> impl Iterator<Item = Row> {
        let amplitudes = &self.amplitudes;
        amplitudes
            .time_s
            .iter()
            .zip(&amplitudes.amplitudes)
            .flat_map(move |(time_s, row)| {
                amplitudes
                    .frequency_hz
                    .iter()
                    .zip(row)
                    .map(|(frequency_hz, amplitude)| Row {
                        time_s: *time_s,
                        frequency_hz: *frequency_hz,
                        amplitude_rad_s: *amplitude,
                    })
            })
    }
}
