//! The design's limit under half-sine pulses: amplitude against change of velocity.

use crate::{ModelChoice, Screens};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::pulse::Pulse;
use latchgate_kernel::replay::Within;
use latchgate_kernel::replay::batch::{self, AskedPeaks, BatchOptions, Member, SensorView};
use latchgate_kernel::signal::{Projection, Signal};
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY, SampleRate};
use latchgate_recording::error::Error;
use serde::{Deserialize, Serialize};

/// Durations of the pulses [s]: 1 to 100 ms by the preferred numbers R20 of ISO 3.
pub const DURATIONS_MS: [f64; 41] = [
    1.0, 1.12, 1.25, 1.4, 1.6, 1.8, 2.0, 2.24, 2.5, 2.8, 3.15, 3.55, 4.0, 4.5, 5.0, 5.6, 6.3, 7.1,
    8.0, 9.0, 10.0, 11.2, 12.5, 14.0, 16.0, 18.0, 20.0, 22.4, 25.0, 28.0, 31.5, 35.5, 40.0, 45.0,
    50.0, 56.0, 63.0, 71.0, 80.0, 90.0, 100.0,
];

/// Sample intervals of a pulse; straight lines between samples take (π/N)²/12, less than 1e-6,
/// off its change of velocity.
const INTERVALS: u32 = 1000;

/// Amplitudes that are looked at, from the smallest on.
const AMPLITUDES: usize = 120;

/// Levers that are run side by side.
const TOGETHER: usize = 16;

/// Relative width of a bracket.
const WIDTH: f64 = 1e-12;

/// A half-sine pulse that just brings the lever to the threshold.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LimitPoint {
    /// Stop model.
    pub model: StopModel,
    /// Duration of the pulse [s].
    pub duration_s: f64,
    /// The greatest amplitude below which every smaller one stays at or below the threshold [g];
    /// `None` if none between a tenth and ten times the sum of the two bounds reaches it.
    pub amplitude_g: Option<f64>,
    /// Its bracket [g].
    pub amplitude_bracket_g: Option<(f64, f64)>,
    /// Change of velocity of that pulse, 2·amplitude·duration/π [m/s].
    pub velocity_change_m_s: Option<f64>,
}

/// The place of the recording on the chart.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RecordingPoint {
    /// Sign of the recorded acceleration that is taken to open.
    pub opens_when: OpensWhen,
    /// Largest acceleration in the opening direction, as used [g].
    pub peak_g: f64,
    /// Largest change of velocity in the opening direction between two samples [m/s].
    pub velocity_change_m_s: f64,
}

/// The design's limit, and the recording beside it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LimitCurve {
    /// T0/(mL), below which no length of pulse lifts a lever off a rigid stop [g].
    pub static_threshold_g: f64,
    /// The least change of velocity that brings a lever on a rigid stop to the threshold [m/s].
    pub impulse_threshold_m_s: f64,
    /// Critical pulses, by stop and then by duration.
    pub points: Vec<LimitPoint>,
    /// The recording, for each sign that counts.
    pub recording: Vec<RecordingPoint>,
}

/// Finds the limit of `design` for each stop of `model`.
///
/// # Errors
///
/// As [`latchgate_kernel::replay::run`].
pub fn limit_curve(
    design: &Design,
    model: ModelChoice,
    recording: Vec<RecordingPoint>,
    control: &Control<'_>,
) -> Result<LimitCurve, Error> {
    let bounds = Screens::of(design, None);
    let pulses: Vec<(StopModel, f64)> = model
        .stops()
        .iter()
        .flat_map(|stop| DURATIONS_MS.map(|duration_ms| (*stop, duration_ms / 1e3)))
        .collect();
    let points = control.try_map(&pulses, |&(stop, duration_s)| {
        // The pulses themselves are shared among the threads.
        let single_threaded = control.with_threads(1);
        single_threaded.unmeasured(|control| critical_pulse(design, stop, duration_s, control))
    })?;
    Ok(LimitCurve {
        static_threshold_g: bounds.static_threshold_g,
        impulse_threshold_m_s: bounds.impulse_threshold_m_s,
        points,
        recording,
    })
}

/// Finds the half-sine pulse of `duration_s` [s] that just brings the lever, at rest when it
/// begins, to its threshold, while it acts or after.
///
/// # Errors
///
/// As [`latchgate_kernel::replay::run`].
pub fn critical_pulse(
    design: &Design,
    stop: StopModel,
    duration_s: f64,
    control: &Control<'_>,
) -> Result<LimitPoint, Error> {
    let signal = half_sine(duration_s)?;
    let bounds = Screens::of(design, None);
    // Neither bound alone lets the lever reach the threshold, and about their sum does.
    let impulsive =
        bounds.impulse_threshold_m_s * std::f64::consts::PI / (2.0 * duration_s * STANDARD_GRAVITY);
    let sum = bounds.static_threshold_g + impulsive;
    let grid: Vec<f64> = (0..=AMPLITUDES)
        .map(|index| sum * libm::pow(10.0, 2.0 * index as f64 / AMPLITUDES as f64 - 1.0))
        .collect();
    let mut bracket = None;
    let mut stays = None;
    for amplitudes in grid.chunks(TOGETHER) {
        let first = first_to_open(&signal, design, stop, amplitudes, control)?;
        let before = first.map_or(amplitudes.len(), |first| first);
        stays = before.checked_sub(1).map(|last| amplitudes[last]).or(stays);
        if let Some(first) = first {
            bracket = stays.map(|low| (low, amplitudes[first]));
            break;
        }
    }
    // Sixteen values between the ends narrow the bracket by seventeen each time.
    while let Some((low, high)) = bracket.filter(|(low, high)| high - low > WIDTH * high) {
        let step = (high - low) / (TOGETHER + 1) as f64;
        let amplitudes: Vec<f64> = (1..=TOGETHER).map(|n| low + step * n as f64).collect();
        bracket = Some(
            match first_to_open(&signal, design, stop, &amplitudes, control)? {
                Some(0) => (low, amplitudes[0]),
                Some(first) => (amplitudes[first - 1], amplitudes[first]),
                None => (amplitudes[TOGETHER - 1], high),
            },
        );
    }
    let amplitude = bracket.map(|(low, _)| low);
    Ok(LimitPoint {
        model: stop,
        duration_s,
        amplitude_g: amplitude,
        amplitude_bracket_g: bracket,
        velocity_change_m_s: amplitude.map(|amplitude| {
            2.0 * amplitude * STANDARD_GRAVITY * duration_s / std::f64::consts::PI
        }),
    })
}

/// Returns the first of some amplitudes [g] at which the lever goes beyond its threshold, or cannot be
/// followed.
fn first_to_open(
    signal: &Signal,
    design: &Design,
    stop: StopModel,
    amplitudes_g: &[f64],
    control: &Control<'_>,
) -> Result<Option<usize>, Error> {
    let threshold = design.criterion.threshold_rad;
    let options = BatchOptions {
        stop,
        projection: Projection::ALIGNED,
        opens_when: OpensWhen::Negative,
        initial: None,
        window: None,
        coast: true,
        asked: AskedPeaks {
            from_rad: 0.0,
            to_rad: 2.0 * threshold,
        },
        threshold_rad: f64::INFINITY,
        threads: 1,
    };
    let member = |index: usize| Member {
        lever: design.lever,
        stop: design.stop,
        scale: amplitudes_g[index],
        bias_m_s2: 0.0,
        second: SensorView::default(),
        catch: design.catch,
    };
    let within = Within {
        control,
        ..Within::UNBOUNDED
    };
    let peaks = batch::peaks_within(signal, amplitudes_g.len(), &member, &options, &within)?;
    let opens = |highest: f64| !highest.is_finite() || highest > threshold;
    Ok(peaks.iter().position(|peak| opens(peak.highest_rad())))
}

/// Returns a half-sine pulse of one g in the opening direction.
fn half_sine(duration_s: f64) -> Result<Signal, Error> {
    // A pulse as long as it has intervals: its last sample is zero and not what rounding leaves of sin π.
    let pulse = Pulse::HalfSine {
        peak: -STANDARD_GRAVITY,
        duration_s: f64::from(INTERVALS),
    };
    Ok(Signal {
        rate: SampleRate::from_hertz(f64::from(INTERVALS) / duration_s)?,
        ..pulse.signal(1.0)?
    })
}

/// Places a recording on the chart: its largest acceleration in the opening direction, and the
/// largest rise of the velocity in that direction from one sample to a later one.
pub fn recording_point(signal: &Signal, opens_when: OpensWhen) -> RecordingPoint {
    let sign = opens_when.sign();
    let mut peak = 0.0_f64;
    let (mut gain, mut largest_gain) = (0.0_f64, 0.0_f64);
    let interval = signal.rate.interval().seconds();
    for a in &signal.samples {
        peak = peak.max(-sign * a);
    }
    for pair in signal.samples.windows(2) {
        gain = (gain - sign * 0.5 * (pair[0] + pair[1]) * interval).max(0.0);
        largest_gain = largest_gain.max(gain);
    }
    RecordingPoint {
        opens_when,
        peak_g: peak / STANDARD_GRAVITY,
        velocity_change_m_s: largest_gain,
    }
}
