//! Excitation that opens the latch: the largest angle of a lever from rest, over amplitude and frequency.

use super::Headline;
use super::orbit::ForcedLever;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::range::Range;
use latchgate_kernel::replay::strobe_batch::{self, Ending};
use latchgate_recording::error::Error;
use serde::Serialize;

/// Options of one map of excitations.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Options {
    /// Lever and stop; its frequency is not used, and the range takes its place in JSON.
    #[serde(flatten)]
    pub forced: ForcedLever,
    /// Amplitudes [g].
    #[serde(rename = "amplitude_g")]
    pub amplitudes_g: Range,
    /// Least and largest angular frequency [rad/s]; those between are evenly spaced in the logarithm.
    #[serde(rename = "omega_rad_s")]
    pub angular_frequencies_rad_s: Range,
    /// Amplitudes × frequencies.
    pub grid: (u32, u32),
    /// Periods of the excitation over which each lever is followed.
    pub periods: u32,
}

/// One excitation.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Row {
    /// Amplitude [g].
    pub amplitude_g: f64,
    /// Angular frequency [rad/s].
    pub angular_frequency_rad_s: f64,
    /// Largest angle from rest [rad].
    pub peak_angle_rad: f64,
}

/// Least amplitude that exceeds the threshold at a frequency.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ContourPoint {
    /// Angular frequency [rad/s].
    pub angular_frequency_rad_s: f64,
    /// An amplitude that exceeds the threshold [g] next to one, within 1e-6 of it, that does not;
    /// every smaller one on the grid does not either. `None` if none on the grid does. Where motion
    /// is chaotic, still smaller ones between those of the grid may exceed it.
    pub amplitude_g: Option<f64>,
}

/// Result of the study.
#[derive(Debug, Clone, PartialEq)]
pub struct ExcitationMap {
    /// Options of the study.
    pub options: Options,
    /// Amplitude above which a lever at rest leaves the rigid stop [g].
    pub lift_off_g: f64,
    /// The map, the amplitude running fastest.
    pub rows: Vec<Row>,
    /// The threshold's contour.
    pub boundary: Vec<ContourPoint>,
    /// True if the work was not stopped.
    pub complete: bool,
}

impl Options {
    fn amplitude(&self, index: u32) -> f64 {
        let Range { low, high } = self.amplitudes_g;
        low + (high - low) * (f64::from(index) + 0.5) / f64::from(self.grid.0)
    }

    fn frequency(&self, index: u32) -> f64 {
        let Range { low, high } = self.angular_frequencies_rad_s;
        let part = (f64::from(index) + 0.5) / f64::from(self.grid.1);
        low * libm::pow(high / low, part)
    }

    /// Returns the largest angle from rest [rad]; infinite for a lever that cannot be followed.
    fn peak(&self, amplitude_g: f64, angular_frequency_rad_s: f64) -> Result<f64, Error> {
        let forced = ForcedLever {
            angular_frequency_rad_s,
            ..self.forced.clone()
        };
        let mut strobe = forced.strobe(amplitude_g, None)?;
        let mut peak = f64::NEG_INFINITY;
        for _ in 0..self.periods {
            let Some(section) = strobe.advance() else {
                return Ok(f64::INFINITY);
            };
            peak = peak.max(section.peak_angle_rad);
        }
        Ok(peak)
    }
}

impl Options {
    /// Returns the largest angles from rest at every amplitude of the grid [rad], computed side by side.
    fn peaks(&self, angular_frequency_rad_s: f64) -> Result<Vec<f64>, Error> {
        let forced = ForcedLever {
            angular_frequency_rad_s,
            ..self.forced.clone()
        };
        let amplitude_g = |index: usize| self.amplitude(u32::try_from(index).unwrap_or(0));
        let followed = strobe_batch::follow(
            &forced.design,
            self.grid.0 as usize,
            &|index| forced.start(None, amplitude_g(index)),
            // Frequencies run in parallel, so the levers of one share a thread.
            &forced.batch(self.periods, self.periods, true, 1),
            &|_, _, _| false,
            None,
        )?;
        Ok(followed
            .iter()
            .map(|lever| match lever.ending {
                Ending::Lost => f64::INFINITY,
                Ending::Done | Ending::Periods => lever
                    .sections
                    .iter()
                    .map(|section| section.peak_angle_rad)
                    .fold(f64::NEG_INFINITY, f64::max),
            })
            .collect())
    }
}

/// Computes the map, frequency by frequency.
///
/// # Errors
///
/// As [`latchgate_kernel::replay::Strobe::new`].
pub fn run(options: &Options, control: &Control<'_>) -> Result<ExcitationMap, Error> {
    let threshold = options.forced.design.criterion.threshold_rad;
    let lines = control.map(options.grid.1 as usize, |line| {
        let frequency = options.frequency(u32::try_from(line).unwrap_or(0));
        let rows: Vec<Row> = options
            .peaks(frequency)?
            .into_iter()
            .zip(0..)
            .map(|(peak_angle_rad, index)| Row {
                amplitude_g: options.amplitude(index),
                angular_frequency_rad_s: frequency,
                peak_angle_rad,
            })
            .collect();
        let first = rows.iter().position(|row| row.peak_angle_rad > threshold);
        let amplitude_g = match first {
            None => None,
            Some(first) => {
                let mut high = rows[first].amplitude_g;
                let mut low = if first == 0 {
                    0.0
                } else {
                    rows[first - 1].amplitude_g
                };
                while high - low > 1e-6 * high {
                    let middle = f64::midpoint(low, high);
                    if options.peak(middle, frequency)? > threshold {
                        high = middle;
                    } else {
                        low = middle;
                    }
                }
                Some(high)
            }
        };
        Ok::<_, Error>((
            rows,
            ContourPoint {
                angular_frequency_rad_s: frequency,
                amplitude_g,
            },
        ))
    });
    let complete = lines.iter().all(Option::is_some);
    let mut map = ExcitationMap {
        options: options.clone(),
        lift_off_g: options.forced.lift_off_g(),
        rows: Vec::new(),
        boundary: Vec::new(),
        complete,
    };
    for line in lines.into_iter().flatten() {
        let (rows, boundary): (Vec<Row>, ContourPoint) = line?;
        map.rows.extend(rows);
        map.boundary.push(boundary);
    }
    Ok(map)
}

impl ExcitationMap {
    /// Returns the headline figures.
    pub fn headlines(&self) -> Vec<Headline> {
        let line = |what: &str, value: Option<f64>| Headline {
            digits: Headline::DIGITS,
            subject: "excitation that opens".into(),
            model: Some(self.options.forced.stop),
            what: what.into(),
            value,
        };
        let weakest = self
            .boundary
            .iter()
            .filter_map(|point| {
                point
                    .amplitude_g
                    .map(|a| (a, point.angular_frequency_rad_s))
            })
            .min_by(|a, b| a.0.total_cmp(&b.0));
        vec![
            line(
                "a lever at rest leaves the rigid stop at A [g]",
                Some(self.lift_off_g),
            ),
            line(
                "least A of the contour beyond the threshold from rest [g]",
                weakest.map(|point| point.0),
            ),
            line("at ω [rad/s]", weakest.map(|point| point.1)),
        ]
    }
}
