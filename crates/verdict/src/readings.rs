//! The readings of one recording: what may lie between its samples.
//!
//! The model takes straight lines. What they leave out shows when the samples are read otherwise:
//! refined within their band, twofold, fourfold and sixteenfold; and with what no refinement can
//! know, a corner or a jump somewhere between two samples as recorded, taken to open or to shut.

use super::screen::{Seen, SeenBefore};
use crate::conditioning::{self, Conditioned, Signal, resample};
use latchgate_kernel::units::{OpensWhen, SampleRate};
use latchgate_recording::error::Error;
use std::borrow::Cow;
use std::sync::OnceLock;

/// Samples of a recording beyond which it is not refined sixteenfold, so that memory stays
/// bounded: what would ask for it is taken to be in doubt.
const SIXTEENFOLD_MAX: usize = 200_000;

/// Times the trace of corners and jumps that is added to the samples, the largest first.
///
/// The trapezoids of straight lines miss a jump between two samples by half an interval times its
/// height, a corner by a twelfth of the interval squared times its change of slope. The trace adds up to
/// 1.5 of a jump, and to 0.16 to 0.77 of a corner's change of slope times the interval: once it covers
/// either, whatever part of the interval it falls on. Twice it shows what lies a little beyond, where
/// impacts are about to come in another order.
pub(super) const CORNERS: [f64; 4] = [-2.0, 2.0, -1.0, 1.0];

/// A way to read the samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum SampleReading {
    /// Refined twofold.
    Twofold,
    /// Refined fourfold.
    Fourfold,
    /// Refined sixteenfold.
    Sixteenfold,
    /// As used, with so many times the trace of corners and jumps.
    Corners(f64),
}

impl SampleReading {
    /// Samples of the reading per sample of the recording.
    pub(super) fn factor(self) -> usize {
        match self {
            Self::Twofold => 2,
            Self::Fourfold => 4,
            Self::Sixteenfold => 16,
            Self::Corners(_) => 1,
        }
    }
}

/// Samples of a reading of [`Readings::fine`] per sample of the recording.
pub(super) const FINE_FACTOR: usize = 4;

/// Other readings of one signal, each made when it is first asked for.
#[derive(Debug, Default)]
pub struct ReadingCache {
    twofold: OnceLock<Signal>,
    fourfold: OnceLock<Signal>,
    sixteenfold: OnceLock<Signal>,
    corner_trace: OnceLock<Signal>,
    /// The fourfold, and the fourfold with corners in the order of [`CORNERS`].
    fine: [OnceLock<Signal>; CORNERS.len()],
    /// Of the samples themselves, of the fourfold, and of those with corners.
    known: OnceLock<SeenBefore>,
    known_of_fine: [OnceLock<SeenBefore>; 1 + CORNERS.len()],
}

/// A recording as it is used, with its other readings.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Readings<'a> {
    conditioned: &'a Conditioned,
    cache: &'a ReadingCache,
}

impl<'a> Readings<'a> {
    /// Returns the readings of a recording, which `cache` is of.
    pub(crate) fn of(conditioned: &'a Conditioned, cache: &'a ReadingCache) -> Self {
        Self { conditioned, cache }
    }

    /// Returns the samples as bounds see them.
    pub(super) fn seen(&self, opens_when: OpensWhen) -> Seen<'a> {
        let signal = &self.conditioned.used;
        let before = self.cache.known.get_or_init(|| SeenBefore::of(signal));
        Seen::known(signal, before, opens_when)
    }

    /// Returns the readings that a bound of the peak must hold on, to hold on all, as bounds see them:
    /// the fourfold without corners and with them, each when it is asked for.
    pub(super) fn fine(
        &self,
        opens_when: OpensWhen,
    ) -> impl Iterator<Item = Result<Seen<'a>, Error>> + use<'a> {
        let readings = *self;
        let cache = self.cache;
        cache
            .known_of_fine
            .iter()
            .enumerate()
            .map(move |(place, before)| {
                let signal = match place.checked_sub(1) {
                    None => readings.fourfold(),
                    Some(corners) => readings.fine_corners(corners)?,
                };
                let before = before.get_or_init(|| SeenBefore::of(signal));
                Ok(Seen::known(signal, before, opens_when))
            })
    }

    /// Tells whether the sixteenfold can be had.
    pub(super) fn has_sixteenfold(&self) -> bool {
        self.conditioned.used.samples.len() <= SIXTEENFOLD_MAX
    }

    /// Returns one of them.
    ///
    /// # Errors
    ///
    /// As [`conditioning::corner_trace`].
    pub(super) fn signal(&self, reading: SampleReading) -> Result<Cow<'a, Signal>, Error> {
        let cache = self.cache;
        Ok(match reading {
            SampleReading::Twofold => {
                Cow::Borrowed(cache.twofold.get_or_init(|| every_other(self.fourfold())))
            }
            SampleReading::Fourfold => Cow::Borrowed(self.fourfold()),
            SampleReading::Sixteenfold => Cow::Borrowed(
                cache
                    .sixteenfold
                    .get_or_init(|| resample::upsample_again(self.fourfold())),
            ),
            SampleReading::Corners(times) => {
                Cow::Owned(moved(&self.conditioned.used, times, self.corner_trace()?))
            }
        })
    }

    fn fourfold(&self) -> &'a Signal {
        let Self { conditioned, cache } = *self;
        cache
            .fourfold
            .get_or_init(|| resample::upsample_fourfold(&conditioned.used))
    }

    /// Returns the fourfold with a multiple of [`CORNERS`], by its place.
    fn fine_corners(&self, place: usize) -> Result<&'a Signal, Error> {
        let cache = self.cache;
        let trace = self.corner_trace()?;
        Ok(cache.fine[place].get_or_init(|| {
            resample::upsample_fourfold(&moved(&self.conditioned.used, CORNERS[place], trace))
        }))
    }

    fn corner_trace(&self) -> Result<&'a Signal, Error> {
        let Self { conditioned, cache } = *self;
        if let Some(trace) = cache.corner_trace.get() {
            return Ok(trace);
        }
        let trace = conditioning::corner_trace(conditioned, conditioned.filter)?;
        Ok(cache.corner_trace.get_or_init(|| trace))
    }
}

fn every_other(signal: &Signal) -> Signal {
    Signal {
        rate: SampleRate::from_hertz(0.5 * signal.rate.hertz()).unwrap_or(signal.rate),
        samples: signal.samples.iter().copied().step_by(2).collect(),
        ..*signal
    }
}

/// Returns the samples with a multiple of the trace of corners added.
fn moved(signal: &Signal, times: f64, trace: &Signal) -> Signal {
    let samples = signal.samples.iter().zip(&trace.samples);
    Signal {
        samples: samples.map(|(a, trace)| a + times * trace).collect(),
        ..*signal
    }
}
