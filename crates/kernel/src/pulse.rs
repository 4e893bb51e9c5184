//! Pulses: accelerations by formula.

use crate::error::Error;
use crate::signal::{Reading, Signal};
use crate::units::SampleRate;
use std::borrow::Cow;
use std::f64::consts::{PI, TAU};

/// An acceleration that lasts from 0 to its duration and is zero elsewhere, in the unit of its peak.
///
/// # Source
///
/// Half-sine, final-peak sawtooth and trapezoid are the shapes of IEC 60068-2-27.
///
/// # Examples
///
/// ```
/// use latchgate_kernel::pulse::Pulse;
///
/// let pulse = Pulse::HalfSine { peak: 30.0, duration_s: 0.011 };
/// assert_eq!(pulse.at(0.0055), 30.0);
/// assert_eq!(pulse.at(0.011), 0.0);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum Pulse {
    /// Half a period of a sine.
    HalfSine {
        /// Largest value.
        peak: f64,
        /// Duration [s].
        duration_s: f64,
    },
    /// A sine squared: smooth at both ends.
    Haversine {
        /// Largest value.
        peak: f64,
        /// Duration [s].
        duration_s: f64,
    },
    /// A straight rise that ends at the peak at once.
    Sawtooth {
        /// Value at the end of the rise.
        peak: f64,
        /// Duration [s].
        duration_s: f64,
    },
    /// A straight rise and a straight fall, equally long.
    Triangle {
        /// Value in the middle.
        peak: f64,
        /// Duration [s].
        duration_s: f64,
    },
    /// A straight rise, a plateau and a straight fall.
    Trapezoid {
        /// Value of the plateau.
        peak: f64,
        /// Duration of the rise [s].
        rise_s: f64,
        /// Duration of the plateau [s].
        plateau_s: f64,
        /// Duration of the fall [s].
        fall_s: f64,
    },
    /// Straight lines from vertex to vertex, in order of time; zero before the first.
    Polyline(
        /// The vertices.
        Vec<Vertex>,
    ),
    /// Tones under a haversine; see [`tones`].
    Burst {
        /// Factor of the tones.
        scale: f64,
        /// Duration [s].
        duration_s: f64,
        /// Set of phases, as [`tones`] takes it.
        phases: f64,
    },
}

/// A vertex of a polyline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertex {
    /// Time [s].
    pub time_s: f64,
    /// Value there.
    pub value: f64,
}

impl Vertex {
    /// Returns a vertex of a time [s] and a value.
    pub const fn new(time_s: f64, value: f64) -> Self {
        Self { time_s, value }
    }
}

impl Pulse {
    /// Returns the duration [s].
    pub fn duration_s(&self) -> f64 {
        match *self {
            Self::HalfSine { duration_s, .. }
            | Self::Haversine { duration_s, .. }
            | Self::Sawtooth { duration_s, .. }
            | Self::Triangle { duration_s, .. }
            | Self::Burst { duration_s, .. } => duration_s,
            Self::Polyline(ref vertices) => vertices.last().map_or(0.0, |last| last.time_s),
            Self::Trapezoid {
                rise_s,
                plateau_s,
                fall_s,
                ..
            } => rise_s + plateau_s + fall_s,
        }
    }

    /// Returns the value at `time_s` after the pulse's begin.
    pub fn at(&self, time_s: f64) -> f64 {
        if !(0.0..self.duration_s()).contains(&time_s) {
            return 0.0;
        }
        match *self {
            Self::HalfSine { peak, duration_s } => peak * libm::sin(PI * time_s / duration_s),
            Self::Haversine { peak, duration_s } => {
                let sine = libm::sin(PI * (time_s / duration_s));
                peak * (sine * sine)
            }
            Self::Sawtooth { peak, duration_s } => peak * time_s / duration_s,
            Self::Triangle { peak, duration_s } => {
                peak * (1.0 - (2.0 * time_s / duration_s - 1.0).abs())
            }
            Self::Trapezoid {
                peak,
                rise_s,
                plateau_s,
                fall_s,
            } => {
                let since_plateau_s = time_s - rise_s - plateau_s;
                if time_s < rise_s {
                    peak * time_s / rise_s
                } else if since_plateau_s <= 0.0 {
                    peak
                } else {
                    peak * (1.0 - since_plateau_s / fall_s)
                }
            }
            Self::Polyline(ref vertices) => on_lines(vertices, time_s),
            Self::Burst {
                scale,
                duration_s,
                phases,
            } => {
                let envelope = libm::sin(PI * time_s / duration_s);
                scale * envelope * envelope * tones(time_s, phases)
            }
        }
    }

    /// Returns the vertices of a pulse of straight lines.
    fn vertices(&self) -> Option<Vec<Vertex>> {
        let rise = |peak, duration_s| vec![Vertex::new(0.0, 0.0), Vertex::new(duration_s, peak)];
        Some(match *self {
            Self::Polyline(ref vertices) => vertices.clone(),
            Self::Sawtooth { peak, duration_s } => rise(peak, duration_s),
            Self::Triangle { peak, duration_s } => {
                let mut vertices = rise(peak, 0.5 * duration_s);
                vertices.push(Vertex::new(duration_s, 0.0));
                vertices
            }
            Self::Trapezoid {
                peak,
                rise_s,
                plateau_s,
                fall_s,
            } => {
                let mut vertices = rise(peak, rise_s);
                vertices.push(Vertex::new(rise_s + plateau_s, peak));
                vertices.push(Vertex::new(rise_s + plateau_s + fall_s, 0.0));
                // A side that takes no time is a jump at the begin or at the end.
                vertices.dedup_by(|next, before| {
                    let jumps = next.time_s <= before.time_s;
                    if jumps && next.time_s <= 0.0 {
                        before.value = next.value;
                    }
                    jumps
                });
                vertices
            }
            Self::HalfSine { .. } | Self::Haversine { .. } | Self::Burst { .. } => return None,
        })
    }

    /// Returns the pulse and `tail` intervals of zero behind it, read as its formula runs between samples:
    /// it begins and ends with a jump where that does.
    ///
    /// Its vertices are to lie on samples. A half-sine or haversine of 200 intervals is followed to 1e-14 of
    /// its peak.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] for tones, which have no such reading.
    pub fn reading(&self, rate: SampleRate, tail: usize) -> Result<Reading<'static>, Error> {
        let interval = rate.interval().seconds();
        let end = (self.duration_s() * rate.hertz()).round() as usize;
        let mut signal = Signal {
            start_s: 0.0,
            rate,
            samples: vec![0.0; end + 1 + tail],
        };
        if let Some(vertices) = self.vertices() {
            let place = |vertex: &Vertex| (vertex.time_s * rate.hertz()).round() as usize;
            for pair in vertices.windows(2) {
                let (first, last) = (place(&pair[0]), place(&pair[1]));
                let per_interval = (pair[1].value - pair[0].value) / (last - first).max(1) as f64;
                for index in first..last {
                    signal.samples[index] = pair[0].value + per_interval * (index - first) as f64;
                }
                signal.samples[last] = pair[1].value;
            }
            return Ok(Reading::from(signal).ending_at(end));
        }
        let (mut slopes, mut bends) = (signal.samples.clone(), signal.samples.clone());
        for index in 0..=end {
            let part = index as f64 / end as f64;
            let [value, slope, bend] = match *self {
                Self::HalfSine { peak, duration_s } => {
                    let turn = PI / duration_s * interval;
                    let (sine, cosine) = libm::sincos(PI * part);
                    [
                        peak * sine,
                        peak * turn * cosine,
                        -peak * turn * turn * sine,
                    ]
                }
                Self::Haversine { peak, duration_s } => {
                    let turn = PI / duration_s * interval;
                    let sine = libm::sin(PI * part);
                    let (double_sine, double_cosine) = libm::sincos(TAU * part);
                    [
                        peak * (sine * sine),
                        peak * turn * double_sine,
                        2.0 * peak * turn * turn * double_cosine,
                    ]
                }
                _ => {
                    return Err(Error::out_of_range(
                        "a pulse to be read between samples",
                        "a half-sine, a haversine or straight lines",
                        "tones",
                    ));
                }
            };
            signal.samples[index] = value;
            slopes[index] = slope;
            bends[index] = bend;
        }
        Ok(Reading::quintic(Cow::Owned(signal), slopes, bends)?.ending_at(end))
    }

    /// Returns samples of the pulse from its begin to its end, the last one included.
    ///
    /// # Errors
    ///
    /// [`Error::NotPositive`] for a rate that is none.
    pub fn signal(&self, rate_hz: f64) -> Result<Signal, Error> {
        let rate = SampleRate::from_hertz(rate_hz)?;
        // 0.035 s at 20 kHz come out a little above 700 intervals.
        let intervals = (self.duration_s() * rate_hz - 1e-6).ceil() as u64;
        Ok(Signal {
            start_s: 0.0,
            rate,
            samples: (0..=intervals)
                .map(|index| self.at(index as f64 / rate_hz))
                .collect(),
        })
    }
}

/// Returns the value on straight lines between vertices; zero before the first.
fn on_lines(vertices: &[Vertex], time_s: f64) -> f64 {
    let next = vertices.partition_point(|vertex| vertex.time_s <= time_s);
    match (
        next.checked_sub(1).map(|before| vertices[before]),
        vertices.get(next),
    ) {
        (None, _) => 0.0,
        (Some(last), None) => last.value,
        (Some(a), Some(b)) => {
            a.value + (b.value - a.value) * ((time_s - a.time_s) / (b.time_s - a.time_s))
        }
    }
}

/// Returns 24 tones from 20 to 480 Hz at `time_s`: Σ sin(2π (20 j t + frac(n P j²))), P the golden
/// ratio's fraction, which spreads the phases; another `phases` n is another set of them.
pub fn tones(time_s: f64, phases: f64) -> f64 {
    let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
    (1..=24)
        .map(|j| {
            let j = f64::from(j);
            let turns = phases * golden * j * j;
            libm::sin(TAU * (20.0 * j * time_s + (turns - turns.floor())))
        })
        .sum()
}
