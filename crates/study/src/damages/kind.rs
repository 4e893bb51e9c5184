//! The kinds of damage, and the effect of each on the samples of a recording.

use super::Chance;
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::SampleRate;
use std::f64::consts::TAU;

macro_rules! kinds {
    ($($(#[$doc:meta])* $kind:ident $name:literal $undetectable:literal;)*) => {
        /// A kind of damage.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Kind {
            $($(#[$doc])* $kind,)*
        }

        impl Kind {
            /// Every kind.
            pub const ALL: &[Self] = &[$(Self::$kind,)*];

            /// Returns the name of the kind.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$kind => $name,)*
                }
            }

            /// Returns true if the damage leaves another plausible recording, so that it cannot
            /// be detected.
            pub fn is_undetectable(self) -> bool {
                match self {
                    $(Self::$kind => $undetectable,)*
                }
            }
        }
    };
}

kinds! {
    /// The opening side ends at one level.
    ClippedSide "one side clipped" false;
    /// Both sides end at one level.
    ClippedBoth "both sides clipped" false;
    /// The opening side is missing.
    HalfWave "half wave" false;
    /// Every minus sign is lost.
    Rectified "minus signs lost" false;
    /// One side ends at a level on which the last digit flickers.
    ClippedFlickering "clipped, last digit flickers" false;
    /// The code of the converter runs over and comes back.
    Wrapped "wrap-around" false;
    /// Zeros over a stretch of the event.
    Zeros "zeros" false;
    /// One value over a stretch of the event.
    Held "held" false;
    /// One value on which the last digit flickers over a stretch of the event.
    Flickering "held, last digit flickers" false;
    /// A straight line over a stretch of the event.
    Filled "filled in by a line" false;
    /// Single samples are zero.
    Dropped "single zeros" false;
    /// The lowest frequencies are missing: AC coupling.
    HighPass "high pass" false;
    /// The zero moves in the event.
    ZeroShift "zero shift" false;
    /// Small values are zero.
    DeadBand "dead band" false;
    /// The beginning is missing.
    CutStart "cut at its start" false;
    /// The end is missing.
    CutEnd "cut at its end" false;
    /// The clock runs too fast.
    Hastened "clock too fast" true;
    /// One side ends at a level with the channel's noise on it.
    ClippedNoisy "clipped, noise on it" true;
    /// Large values are compressed smoothly.
    SoftClipped "compressed smoothly" true;
    /// Clipped, then smoothed.
    ClippedSmoothed "clipped, then smoothed" true;
    /// A factor.
    Scaled "scaled" true;
    /// The sign turned.
    Turned "sign turned" true;
    /// High frequencies are missing.
    LowPass "low pass" true;
    /// Averaged over neighbours.
    Averaged "moving average" true;
    /// A stretch of the event is replaced by noise as before it.
    Replaced "replaced by noise" true;
    /// Samples are missing under a clock that counts them.
    RowsLost "rows lost, renumbered" true;
}

/// A recording with the properties that damages depend on.
pub(super) struct Specimen<'a> {
    signal: &'a Signal,
    /// First sample at or after time zero.
    zero: usize,
    mean: f64,
    pub(super) noise: f64,
    pub(super) quantum: f64,
    peak: f64,
}

impl<'a> Specimen<'a> {
    pub(super) fn new(signal: &'a Signal) -> Self {
        let zero = ((-signal.start_s * signal.rate.hertz()).ceil().max(1.0) as usize)
            .min(signal.samples.len());
        let before = &signal.samples[..zero];
        let mean = before.iter().sum::<f64>() / before.len() as f64;
        let squares: f64 = before
            .iter()
            .map(|value| (value - mean) * (value - mean))
            .sum();
        let mut levels = signal.samples.clone();
        levels.sort_unstable_by(f64::total_cmp);
        let steps = levels.windows(2).map(|pair| pair[1] - pair[0]);
        let quantum = steps.filter(|step| *step > 1e-6).fold(1e9, f64::min);
        let peak = |most: f64, value: &f64| most.max((value - mean).abs());
        Self {
            signal,
            zero,
            mean,
            noise: (squares / before.len() as f64).sqrt(),
            quantum,
            peak: signal.samples.iter().fold(0.0, peak),
        }
    }

    /// Returns a damaged copy on the same grid; severity 0 to 1.
    pub(super) fn damaged(&self, kind: Kind, severity: f64, chance: &mut Chance) -> Signal {
        let mut damaged = self.signal.clone();
        match kind {
            Kind::CutStart | Kind::CutEnd | Kind::RowsLost | Kind::Hastened => {
                self.take_away(kind, severity, &mut damaged, chance);
            }
            Kind::Zeros | Kind::Held | Kind::Flickering | Kind::Filled | Kind::Replaced => {
                self.stretch(kind, severity, &mut damaged.samples, chance);
            }
            Kind::HighPass | Kind::LowPass | Kind::Averaged => {
                damaged.samples = self.filtered(kind, severity);
            }
            Kind::ClippedSmoothed => {
                let clipped = self.damaged(Kind::ClippedBoth, severity, chance);
                damaged.samples = Specimen::new(&clipped).filtered(Kind::LowPass, 0.5 * severity);
            }
            _ => {
                for (index, value) in damaged.samples.iter_mut().enumerate() {
                    *value = self.sample(kind, severity, index, *value, chance);
                }
            }
        }
        for value in &mut damaged.samples {
            *value = (*value / self.quantum).round() * self.quantum;
        }
        damaged
    }

    fn samples_of(&self, seconds: f64) -> usize {
        (seconds * self.signal.rate.hertz()).round() as usize
    }

    /// Returns the damaged value of a single sample.
    fn sample(
        &self,
        kind: Kind,
        severity: f64,
        index: usize,
        value: f64,
        chance: &mut Chance,
    ) -> f64 {
        // The limit falls from 60 % of the peak to 3 % with the severity.
        let limit = self.peak * libm::pow(0.05, severity) * 0.6;
        let off = value - self.mean;
        let flicker = f64::from(u8::from(chance.next().is_multiple_of(3))) * self.quantum;
        match kind {
            Kind::ClippedSide => value.max(self.mean - limit),
            Kind::ClippedBoth => self.mean + off.clamp(-limit, limit),
            Kind::HalfWave => value.max(0.0),
            Kind::Rectified => value.abs(),
            Kind::ClippedFlickering if off < -limit => self.mean - limit + flicker,
            Kind::ClippedNoisy if off < -limit => self.mean - limit + self.noise * chance.normal(),
            Kind::Wrapped => (off + limit).rem_euclid(2.0 * limit) - limit + self.mean,
            Kind::SoftClipped => self.mean + limit * libm::tanh(off / limit),
            Kind::Dropped if index >= self.zero => {
                if chance.between(0.0, 1.0) < 0.1 + 0.8 * severity {
                    0.0
                } else {
                    value
                }
            }
            Kind::ZeroShift if index >= self.zero + self.samples_of(0.01) => {
                value + self.peak * (0.02 + 0.3 * severity)
            }
            Kind::DeadBand if off.abs() < self.peak * (0.02 + 0.4 * severity) => 0.0,
            Kind::Scaled => value * libm::pow(0.1, 0.2 + 0.8 * severity),
            Kind::Turned => -value,
            _ => value,
        }
    }

    /// Damages a stretch that begins at most 10 ms before time zero, or 20 ms after it.
    fn stretch(&self, kind: Kind, severity: f64, samples: &mut [f64], chance: &mut Chance) {
        let shift = chance.between(-0.01, 0.02) * self.signal.rate.hertz();
        let first = (self.zero as f64 + shift).max(1.0) as usize;
        let length = self.samples_of(0.005 * libm::pow(20.0, severity));
        let last = (first + length).min(samples.len() - 2);
        let (from, to) = (samples[first - 1], samples[last + 1]);
        let steps = (last + 2 - first) as f64;
        for (index, value) in samples.iter_mut().enumerate().take(last + 1).skip(first) {
            let flicker = f64::from(u8::from(chance.next().is_multiple_of(3))) * self.quantum;
            *value = match kind {
                Kind::Zeros => 0.0,
                Kind::Held => from,
                Kind::Flickering => from + flicker,
                Kind::Filled => from + (to - from) * (index + 1 - first) as f64 / steps,
                _ => self.mean + self.noise * chance.normal(),
            };
        }
    }

    fn take_away(&self, kind: Kind, severity: f64, damaged: &mut Signal, chance: &mut Chance) {
        let samples = &mut damaged.samples;
        match kind {
            Kind::CutStart => {
                let cut = self.zero + self.samples_of(0.03 * severity);
                let cut = cut.min(samples.len() - 2);
                samples.drain(..cut);
                damaged.start_s = self.signal.time_s(cut);
            }
            Kind::CutEnd => {
                let kept_samples = self.zero + self.samples_of(0.002 + 0.03 * (1.0 - severity));
                samples.truncate(kept_samples);
            }
            Kind::RowsLost => {
                let first = self.zero + self.samples_of(chance.between(0.0, 0.01));
                let lost = self.samples_of(0.002 + 0.05 * severity);
                let end = (first + lost).min(samples.len() - 1);
                samples.drain(first..end);
            }
            _ => {
                let factor = 1.5 + 8.5 * severity;
                damaged.start_s /= factor;
                damaged.rate = SampleRate::from_hertz(self.signal.rate.hertz() * factor)
                    .unwrap_or(self.signal.rate);
            }
        }
    }

    fn filtered(&self, kind: Kind, severity: f64) -> Vec<f64> {
        let samples = &self.signal.samples;
        if kind == Kind::Averaged {
            let reach = 2 + (severity * 40.0) as usize;
            return (0..samples.len())
                .map(|index| {
                    let from = index.saturating_sub(reach);
                    let near = &samples[from..(index + reach + 1).min(samples.len())];
                    near.iter().sum::<f64>() / near.len() as f64
                })
                .collect();
        }
        let corner = match kind {
            Kind::HighPass => 10.0 + 40.0 * severity,
            _ => 30.0 * libm::pow(20.0, 1.0 - severity),
        };
        let part = 1.0 - libm::exp(-TAU * corner / self.signal.rate.hertz());
        let mut low = samples.first().copied().unwrap_or(0.0);
        let mut again = low;
        samples
            .iter()
            .map(|value| {
                low += part * (value - low);
                again += part * (low - again);
                if kind == Kind::HighPass {
                    value - low
                } else {
                    again
                }
            })
            .collect()
    }
}
