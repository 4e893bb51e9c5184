//! Power spectra of short blocks, and the quietest of them bin by bin.

use rustfft::FftPlannerScalar;
use rustfft::num_complex::Complex;
use std::f64::consts::PI;
use std::ops::RangeInclusive;

/// Length of a block [s], rounded to a power of two of samples, and the fewest samples of one.
const BLOCK_S: f64 = 0.02;
const FEWEST: usize = 64;

/// Share of the blocks below the floor of a bin [-].
pub(super) const FLOOR_PART: f64 = 0.2;

/// Spectra of Hann blocks that overlap by half, the line of least squares removed from each: white noise of variance
/// σ² has a mean of σ² in every bin.
pub(super) struct BlockSpectra {
    /// Frequency of a bin by its number [Hz].
    pub(super) bin_hz: f64,
    pub(super) blocks: Vec<Vec<f64>>,
}

impl BlockSpectra {
    pub(super) fn of(values: &[f64], hertz: f64) -> Self {
        let mut length = FEWEST;
        while 2.0 * length as f64 <= BLOCK_S * hertz * std::f64::consts::SQRT_2 {
            length *= 2;
        }
        while length > FEWEST && length > values.len() {
            length /= 2;
        }
        let fft = FftPlannerScalar::new().plan_fft_forward(length);
        let weight = |index: usize| 0.5 - 0.5 * libm::cos(2.0 * PI * index as f64 / length as f64);
        let weights: Vec<f64> = (0..length).map(weight).collect();
        let power: f64 = weights.iter().map(|weight| weight * weight).sum();
        let middle = 0.5 * (length as f64 - 1.0);
        let places: Vec<f64> = (0..length).map(|index| index as f64 - middle).collect();
        let spread: f64 = places.iter().map(|place| place * place).sum();
        let spectrum = |block: &[f64]| {
            let mean = block.iter().sum::<f64>() / length as f64;
            let products = block
                .iter()
                .zip(&places)
                .map(|(value, place)| value * place);
            let slope = products.sum::<f64>() / spread;
            let bent = block.iter().zip(&places).zip(&weights);
            let mut work: Vec<Complex<f64>> = bent
                .map(|((value, place), weight)| {
                    Complex::from((value - mean - slope * place) * weight)
                })
                .collect();
            fft.process(&mut work);
            let bins = work[..=length / 2].iter();
            bins.map(|bin| bin.norm_sqr() / power).collect()
        };
        let starts = (0..).map(|number| number * (length / 2));
        let starts = starts.take_while(|start| start + length <= values.len());
        Self {
            bin_hz: hertz / length as f64,
            blocks: starts
                .map(|start| spectrum(&values[start..start + length]))
                .collect(),
        }
    }

    /// Returns the numbers of the bins of a band [Hz].
    pub(super) fn bins(&self, band: RangeInclusive<f64>) -> Vec<usize> {
        let bins = self.blocks.first().map_or(0, Vec::len);
        let is_inside = |bin: &usize| band.contains(&(*bin as f64 * self.bin_hz));
        (0..bins).filter(is_inside).collect()
    }

    /// Returns the mean power of each block in a band [Hz].
    pub(super) fn band_power(&self, band: RangeInclusive<f64>) -> Vec<f64> {
        let bins = self.bins(band);
        self.blocks.iter().map(|block| mean(block, &bins)).collect()
    }

    /// Returns the floor of each bin: what all but the quietest blocks exceed.
    pub(super) fn floor(&self) -> Vec<f64> {
        let bins = self.blocks.first().map_or(0, Vec::len);
        let floor_of = |bin: usize| {
            let mut powers: Vec<f64> = self.blocks.iter().map(|block| block[bin]).collect();
            let place = (FLOOR_PART * powers.len() as f64) as usize;
            *powers.select_nth_unstable_by(place, f64::total_cmp).1
        };
        (0..bins).map(floor_of).collect()
    }
}

/// Returns the mean of some bins; 0 of none.
pub(super) fn mean(spectrum: &[f64], bins: &[usize]) -> f64 {
    let powers = bins.iter().map(|bin| spectrum[*bin]);
    powers.sum::<f64>() / bins.len().max(1) as f64
}

/// Returns a ratio of powers [dB].
pub(super) fn decibels(power: f64, other: f64) -> f64 {
    10.0 * libm::log10((power + 1e-30) / (other + 1e-30))
}
