//! The readings of one recording: what may lie between its samples.
//!
//! The lever is driven by one reading. What that leaves out shows when the samples are read otherwise: by
//! polynomials of a lower degree, and with what no reading can know, a corner or a jump somewhere
//! between two samples as recorded, taken to open or to shut.

use crate::conditioning::between::{self, Between};
use crate::conditioning::{self, Conditioned};
use crate::noise_spectrum::NoiseSpectrum;
use latchgate_kernel::signal::{Reading, Signal};
use latchgate_recording::error::Error;
use std::borrow::Cow;
use std::sync::OnceLock;

/// Times the trace of corners and jumps that is added to the samples, the largest first.
///
/// A smooth reading misses a jump between two samples by half an interval times its height, a corner by a
/// twelfth of the interval squared times its change of slope. The trace adds up to 1.5 of a jump, and to 0.16
/// to 0.77 of a corner's change of slope times the interval: once it covers either, whatever part of the
/// interval it falls on. Twice it shows what lies a little beyond, where impacts are about to come in another order.
pub(super) const CORNERS: [f64; 4] = [-2.0, 2.0, -1.0, 1.0];

/// Time that a lever takes to swing from its stop beyond its limit, at least [s].
const SWING_S: f64 = 0.01;

/// A way to read the samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum SampleReading {
    /// By polynomials of fifth degree within their band.
    Quintic,
    /// By polynomials of third degree through the same samples and slopes.
    Cubic,
    /// As the first, with so many times the trace of corners and jumps.
    Corners(f64),
    /// The same with the second sensor's trace of the other sign.
    OpposedCorners(f64),
}

/// Other readings of one signal, each made when it is first asked for.
#[derive(Debug, Default)]
pub struct ReadingCache {
    quintic: OnceLock<Reading<'static>>,
    left_out: OnceLock<[f64; 2]>,
    trace: OnceLock<Reading<'static>>,
    noise_spectra: OnceLock<Vec<NoiseSpectrum>>,
    draws: OnceLock<NoisyReadings>,
}

/// The recording under each draw of its noise: a search asks them of every value that it tries.
#[derive(Debug)]
struct NoisyReadings {
    /// Seed and reading that they are of.
    of: (u64, Between),
    readings: Vec<OnceLock<Reading<'static>>>,
}

/// Memory that the readings of all draws may take [bytes]; those of longer recordings are made anew each time.
const DRAWS_BYTES: usize = 64 << 20;

/// A recording as it is used, with its readings.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Readings<'a> {
    conditioned: &'a Conditioned,
    cache: &'a ReadingCache,
    between: Between,
}

impl<'a> Readings<'a> {
    /// Returns the readings of a recording, which `cache` is of; `between` is the one that drives the
    /// lever.
    pub(crate) fn of(
        conditioned: &'a Conditioned,
        cache: &'a ReadingCache,
        between: Between,
    ) -> Self {
        Self {
            conditioned,
            cache,
            between,
        }
    }

    /// Returns the recording.
    pub(super) fn conditioned(&self) -> &'a Conditioned {
        self.conditioned
    }

    /// Returns how the lever's own reading runs between samples.
    pub(super) fn between(&self) -> Between {
        self.between
    }

    /// Returns the reading that drives the lever.
    ///
    /// # Errors
    ///
    /// As [`between::read`].
    pub(super) fn own(&self) -> Result<Reading<'a>, Error> {
        match self.between {
            Between::Linear => joined(self.of_each(|sensor| Ok((&sensor.used).into()))?),
            Between::BandLimited | Between::Exact => Ok(self.quintic()?.into()),
        }
    }

    /// Returns the reading of samples that stand in for those of each sensor.
    ///
    /// # Errors
    ///
    /// Those of `samples`; as [`between::read`].
    pub(super) fn read(
        &self,
        samples: impl Fn(&Conditioned) -> Result<Signal, Error>,
    ) -> Result<Reading<'static>, Error> {
        joined(self.of_each(|sensor| {
            let samples = Cow::Owned(samples(sensor)?);
            between::read(samples, self.between)
        })?)
    }

    /// Does `of` the judged sensor and the second one.
    fn of_each<T>(
        &self,
        of: impl Fn(&'a Conditioned) -> Result<T, Error>,
    ) -> Result<(T, Option<T>), Error> {
        let second = self.conditioned.second.as_deref();
        let second = second.map(|second| of(&second.conditioned)).transpose()?;
        Ok((of(self.conditioned)?, second))
    }

    /// True where nothing is left open between the samples: a pulse that is followed as its formula runs.
    pub(super) fn is_exact(&self) -> bool {
        self.between != Between::Linear && self.conditioned.is_exact()
    }

    /// Returns one of them.
    ///
    /// # Errors
    ///
    /// As [`conditioning::corner_trace`].
    pub(super) fn reading(&self, which: SampleReading) -> Result<Reading<'a>, Error> {
        self.read_as(self.quintic()?, which)
    }

    /// Returns samples that were read by polynomials of fifth degree as one of them reads them.
    ///
    /// # Errors
    ///
    /// As [`conditioning::corner_trace`].
    pub(super) fn read_as<'r>(
        &self,
        quintic: &'r Reading<'static>,
        which: SampleReading,
    ) -> Result<Reading<'r>, Error> {
        Ok(match which {
            SampleReading::Quintic => quintic.into(),
            SampleReading::Cubic => quintic.cubic(),
            SampleReading::Corners(times) => quintic.plus(times, self.trace()?),
            SampleReading::OpposedCorners(times) => {
                let opposed = Reading::from(self.trace()?).with_second_scaled(-1.0, 0.0);
                quintic.plus(times, &opposed)
            }
        })
    }

    /// Returns the standard deviations, as of a white noise of the recorded samples, of what cubics leave out of
    /// each sensor: the largest root mean square over the time that a lever takes to swing [m/s²].
    ///
    /// # Errors
    ///
    /// As [`between::read`].
    fn left_out_m_s2(&self) -> Result<[f64; 2], Error> {
        if self.is_exact() {
            return Ok([0.0; 2]);
        }
        let quintic = self.quintic()?;
        Ok(*self.cache.left_out.get_or_init(|| {
            let Conditioned { raw, used, .. } = self.conditioned;
            let span = (SWING_S * used.rate.hertz()).ceil().max(1.0) as usize;
            let of_sensor = |reading: &Reading<'_>| {
                (swing_square(reading, span) * raw.rate.hertz() / used.rate.hertz()).sqrt()
            };
            [of_sensor(quintic), quintic.second().map_or(0.0, of_sensor)]
        }))
    }

    /// Returns the standard deviations, as of white noises of the recorded samples, of the recorder's and the
    /// channel's own, and of what cubics leave out [m/s²]; of two sensors together, each with its weight.
    ///
    /// # Errors
    ///
    /// As [`between::read`].
    pub(super) fn noises_m_s2(&self, weights: [f64; 2]) -> Result<[f64; 2], Error> {
        let [first, second] = self.left_out_m_s2()?;
        let recorded = self.conditioned.noise.deviation_m_s2;
        let Some(second_sensor) = self.conditioned.second.as_deref() else {
            return Ok([recorded, first]);
        };
        let joined = |a: f64, b: f64| libm::hypot(weights[0] * a, weights[1] * b);
        let across = second_sensor.conditioned.noise.deviation_m_s2;
        Ok([joined(recorded, across), joined(first, second)])
    }

    /// Returns the spectrum of each sensor's recorded noise.
    pub(super) fn noise_spectra(&self) -> &'a [NoiseSpectrum] {
        self.cache.noise_spectra.get_or_init(|| {
            let sensors = self.conditioned.sensors();
            sensors
                .map(|sensor| NoiseSpectrum::of(&sensor.raw, &sensor.noise))
                .collect()
        })
    }

    /// Returns the recording under draw `number` of `count` of its noise, made by `make` where it is not kept.
    ///
    /// # Errors
    ///
    /// Those of `make`.
    pub(super) fn drawn(
        &self,
        seed: u64,
        (number, count): (u32, u32),
        make: impl FnOnce() -> Result<Reading<'static>, Error>,
    ) -> Result<Reading<'a>, Error> {
        let of = (seed, self.between);
        let samples = self.conditioned.used.samples.len() * self.conditioned.sensors().count();
        // A sample with its two derivatives.
        let bytes = samples.saturating_mul(3 * size_of::<f64>());
        if bytes.saturating_mul(count as usize) > DRAWS_BYTES {
            return make();
        }
        let kept = self.cache.draws.get_or_init(|| NoisyReadings {
            of,
            readings: (0..count).map(|_| OnceLock::new()).collect(),
        });
        match kept.readings.get(number as usize).filter(|_| kept.of == of) {
            None => make(),
            Some(place) => match place.get() {
                Some(reading) => Ok(reading.into()),
                None => {
                    let reading = make()?;
                    Ok(place.get_or_init(|| reading).into())
                }
            },
        }
    }

    /// Returns both together, as a white noise in time; `None` without any [m²/s³].
    ///
    /// # Errors
    ///
    /// As [`between::read`].
    pub(super) fn noise_m2_s3(&self, weights: [f64; 2]) -> Result<Option<f64>, Error> {
        let [recorded, between] = self.noises_m_s2(weights)?;
        let strength = libm::hypot(recorded, between);
        let interval = self.conditioned.raw.rate.interval().seconds();
        Ok((strength > 0.0).then_some(strength * strength * interval))
    }

    fn quintic(&self) -> Result<&'a Reading<'static>, Error> {
        let cache = self.cache;
        if let Some(reading) = cache.quintic.get() {
            return Ok(reading);
        }
        let reading = joined(self.of_each(|sensor| match sensor.exact() {
            Some(exact) => Ok(exact),
            None => between::read(Cow::Owned(sensor.used.clone()), Between::BandLimited),
        })?)?;
        Ok(cache.quintic.get_or_init(|| reading))
    }

    fn trace(&self) -> Result<&'a Reading<'static>, Error> {
        let cache = self.cache;
        if let Some(trace) = cache.trace.get() {
            return Ok(trace);
        }
        let trace = joined(self.of_each(|sensor| {
            let trace = conditioning::corner_trace(sensor)?;
            between::read(Cow::Owned(trace), Between::BandLimited)
        })?)?;
        Ok(cache.trace.get_or_init(|| trace))
    }
}

/// Returns the largest mean square, over so many intervals, of what cubics leave out [m²/s⁴].
fn swing_square(reading: &Reading<'_>, span: usize) -> f64 {
    let squares: Vec<f64> = reading.beyond_cubic().map(|away| away * away).collect();
    let (mut sum, mut largest) = (0.0, 0.0_f64);
    for (index, square) in squares.iter().enumerate() {
        let gone = index.checked_sub(span).map_or(0.0, |gone| squares[gone]);
        sum += square - gone;
        largest = largest.max(sum);
    }
    largest / span as f64
}

/// Puts the reading of the second sensor beside that of the judged one.
fn joined<'r>((first, second): (Reading<'r>, Option<Reading<'r>>)) -> Result<Reading<'r>, Error> {
    Ok(match second {
        Some(second) => first.beside(second)?,
        None => first,
    })
}
