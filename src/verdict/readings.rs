//! The readings of one recording: what may lie between its samples.
//!
//! The model takes straight lines. What they leave out shows when the samples are read otherwise:
//! refined within their band, twofold, fourfold and sixteenfold; and with what no refinement can
//! know, a corner or a jump somewhere between two samples, taken to open or to shut.

use super::screen::{Seen, SeenBefore};
use crate::conditioning::{Signal, resample};
use crate::units::{OpensWhen, SampleRate};
use std::sync::OnceLock;

/// Part of what lies above half the Nyquist frequency by which a sample may mislead.
///
/// The trapezoids of straight lines miss a jump between two samples by half an interval times its
/// height, a corner by a twelfth of the interval squared times its change of slope. The magnitudes
/// above half the Nyquist frequency add up to 1.04 of a jump, and to 0.34 to 0.61 of a corner's
/// change of slope times the interval: half of them covers either, whatever part of the interval
/// it falls on.
const MISLEADING_PART: f64 = 0.5;

/// Samples of a recording beyond which it is not refined sixteenfold, so that memory stays
/// bounded: what would ask for it is taken to be in doubt.
const SIXTEENFOLD_MAX: usize = 200_000;

/// A way to read the samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SampleReading {
    /// Refined twofold.
    Twofold,
    /// Refined fourfold.
    Fourfold,
    /// Refined sixteenfold.
    Sixteenfold,
    /// As recorded, with what corners and jumps could add.
    More,
    /// As recorded, with what they could take away.
    Less,
    /// The fourfold of [`Self::More`].
    FineMore,
    /// The fourfold of [`Self::Less`].
    FineLess,
}

impl SampleReading {
    /// Those that a bound of the peak must hold on, to hold on all.
    pub(super) const FINE: [Self; 3] = [Self::Fourfold, Self::FineMore, Self::FineLess];

    /// Samples of the reading per sample of the recording.
    pub(super) fn factor(self) -> usize {
        match self {
            Self::Twofold => 2,
            Self::Fourfold | Self::FineMore | Self::FineLess => 4,
            Self::Sixteenfold => 16,
            Self::More | Self::Less => 1,
        }
    }
}

/// Other readings of one signal, each made when it is first asked for.
#[derive(Debug, Default)]
pub(crate) struct ReadingCache {
    twofold: OnceLock<Signal>,
    fourfold: OnceLock<Signal>,
    sixteenfold: OnceLock<Signal>,
    more: OnceLock<Signal>,
    less: OnceLock<Signal>,
    fine_more: OnceLock<Signal>,
    fine_less: OnceLock<Signal>,
    /// Of the samples themselves, and of the readings in the order of [`SampleReading::FINE`].
    known: OnceLock<SeenBefore>,
    known_of_fine: [OnceLock<SeenBefore>; 3],
}

/// A signal with its other readings.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Readings<'a> {
    signal: &'a Signal,
    cache: &'a ReadingCache,
}

impl<'a> Readings<'a> {
    /// Returns the readings of `signal`, which `cache` is of.
    pub(crate) fn of(signal: &'a Signal, cache: &'a ReadingCache) -> Self {
        Self { signal, cache }
    }

    /// Returns the samples as bounds see them.
    pub(super) fn seen(&self, opens_when: OpensWhen) -> Seen<'a> {
        let of = || SeenBefore::of(self.signal);
        Seen::known(self.signal, self.cache.known.get_or_init(of), opens_when)
    }

    /// Returns the readings of [`SampleReading::FINE`] as bounds see them, each when it is asked
    /// for.
    pub(super) fn fine(
        &self,
        opens_when: OpensWhen,
    ) -> impl Iterator<Item = (SampleReading, Seen<'a>)> + use<'a> {
        let readings = *self;
        let all = SampleReading::FINE.into_iter();
        all.zip(&readings.cache.known_of_fine)
            .map(move |(reading, known)| {
                let signal = readings.signal(reading);
                let known = known.get_or_init(|| SeenBefore::of(signal));
                (reading, Seen::known(signal, known, opens_when))
            })
    }

    /// Tells whether the sixteenfold can be had.
    pub(super) fn has_sixteenfold(&self) -> bool {
        self.signal.samples.len() <= SIXTEENFOLD_MAX
    }

    /// Returns one of them.
    pub(super) fn signal(&self, reading: SampleReading) -> &'a Signal {
        let Self { signal, cache } = *self;
        let fourfold = || self.signal(SampleReading::Fourfold);
        let fine = |reading| resample::upsample_fourfold(self.signal(reading));
        match reading {
            SampleReading::Twofold => cache.twofold.get_or_init(|| every_other(fourfold())),
            SampleReading::Fourfold => cache
                .fourfold
                .get_or_init(|| resample::upsample_fourfold(signal)),
            SampleReading::Sixteenfold => cache
                .sixteenfold
                .get_or_init(|| resample::upsample_again(fourfold())),
            SampleReading::More => cache.more.get_or_init(|| moved(signal, MISLEADING_PART)),
            SampleReading::Less => cache.less.get_or_init(|| moved(signal, -MISLEADING_PART)),
            SampleReading::FineMore => cache.fine_more.get_or_init(|| fine(SampleReading::More)),
            SampleReading::FineLess => cache.fine_less.get_or_init(|| fine(SampleReading::Less)),
        }
    }
}

fn every_other(signal: &Signal) -> Signal {
    Signal {
        rate: SampleRate::from_hertz(0.5 * signal.rate.hertz()).unwrap_or(signal.rate),
        samples: signal.samples.iter().copied().step_by(2).collect(),
        ..*signal
    }
}

/// Returns the samples with a part of what lies above half the Nyquist frequency added to each.
fn moved(signal: &Signal, part: f64) -> Signal {
    let unknown = resample::above_half_nyquist(signal);
    let samples = signal.samples.iter().zip(&unknown);
    Signal {
        samples: samples
            .map(|(a, unknown)| a + part * unknown.abs())
            .collect(),
        ..*signal
    }
}
