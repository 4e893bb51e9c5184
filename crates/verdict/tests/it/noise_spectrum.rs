//! Guards the spectrum that draws of a noise have: that of a known process, from long and short stretches.

use crate::support::Random;
use latchgate_kernel::units::SampleRate;
use latchgate_verdict::conditioning::{Noise, Signal};
use latchgate_verdict::noise_spectrum::{NoiseSpectrum, ORDER_MAX, QUIET_SAMPLES};
use std::f64::consts::TAU;

/// Draws an autoregression of second order with innovations of one, once it is stationary.
fn autoregression([first, second]: [f64; 2], count: usize, random: &mut Random) -> Vec<f64> {
    let (mut last, mut before) = (0.0, 0.0);
    let mut next = || {
        let value = first * last + second * before + random.normal();
        (before, last) = (last, value);
        value
    };
    for _ in 0..1_000 {
        next();
    }
    (0..count).map(|_| next()).collect()
}

/// Its power, by its formula.
fn power([first, second]: [f64; 2], cycles: f64) -> f64 {
    let (turn, twice) = (TAU * cycles, 2.0 * TAU * cycles);
    let real = 1.0 - first * turn.cos() - second * twice.cos();
    let imaginary = first * turn.sin() + second * twice.sin();
    1.0 / (real * real + imaginary * imaginary)
}

fn deviation(samples: &[f64]) -> f64 {
    let mean = samples.iter().sum::<f64>() / samples.len() as f64;
    let squares: f64 = samples.iter().map(|a| (a - mean) * (a - mean)).sum();
    (squares / (samples.len() - 1) as f64).sqrt()
}

/// The variance of a spectrum: its integral over all frequencies.
fn variance(spectrum: &NoiseSpectrum) -> f64 {
    let powers = (0..2_000).map(|part| spectrum.power((f64::from(part) + 0.5) / 4_000.0));
    powers.sum::<f64>() / 2_000.0
}

/// Autocovariances at the first lags, of values around zero.
fn autocovariances(samples: &[f64]) -> [f64; 6] {
    std::array::from_fn(|lag| {
        let pairs = samples.iter().zip(&samples[lag..]);
        pairs.map(|(a, b)| a * b).sum::<f64>() / (samples.len() - lag) as f64
    })
}

fn fitted(quiet: &[f64], step: f64) -> NoiseSpectrum {
    NoiseSpectrum::fitted(quiet, deviation(quiet), step)
}

/// Coefficients: white, slow, alternating, a resonance.
const PROCESSES: [[f64; 2]; 4] = [[0.0, 0.0], [0.9, 0.0], [-0.5, 0.0], [1.6, -0.9]];

/// The fit to a long stretch has the power of the process, and draws have its variance and autocorrelation.
#[test]
fn val_a_known_autoregression_is_recovered() {
    for process in PROCESSES {
        let mut random = Random::new(11);
        let quiet = autoregression(process, 200_000, &mut random);
        let spectrum = fitted(&quiet, 0.0);
        assert_eq!(spectrum.order(), ORDER_MAX);
        for part in 0..=20 {
            let cycles = f64::from(part) / 40.0;
            let ratio = spectrum.power(cycles) / power(process, cycles);
            // Fourteen coefficients of as many samples are off by 1.2 % of the power, one standard deviation; more
            // at a resonance, whose place moves.
            assert!(
                (0.9..1.1).contains(&ratio),
                "{process:?} at {cycles}: {ratio}"
            );
        }
        // That many draws of the quiet stretch's own length end to end hold 8 sets.
        let expected = autocovariances(&quiet);
        let mut mean = [0.0; 6];
        for draw in 0..8 {
            let drawn = spectrum.drawn(50_000, 3, 0, draw);
            for (mean, covariance) in mean.iter_mut().zip(autocovariances(&drawn)) {
                *mean += covariance / 8.0;
            }
        }
        for (lag, (mean, expected_here)) in mean.iter().zip(expected).enumerate() {
            let miss = (mean - expected_here).abs() / expected[0];
            assert!(
                miss < 0.02,
                "{process:?} lag {lag}: {mean} for {expected_here}"
            );
        }
    }
}

/// Draws are stationary from their first sample on.
#[test]
fn verif_a_draw_begins_as_it_goes_on() {
    for process in PROCESSES {
        let quiet = autoregression(process, 20_000, &mut Random::new(5));
        let spectrum = fitted(&quiet, 0.0);
        let draws: Vec<Vec<f64>> = (0..4_000).map(|n| spectrum.drawn(40, 1, 0, n)).collect();
        let mean_product = |first: usize, second: usize| {
            let products = draws.iter().map(|draw| draw[first] * draw[second]);
            products.sum::<f64>() / draws.len() as f64
        };
        let variance = variance(&spectrum);
        for index in [0, 1, 5, 14, 39] {
            let ratio = mean_product(index, index) / variance;
            // 4 000 squares are off by 2.2 %, one standard deviation.
            assert!(
                (0.91..1.09).contains(&ratio),
                "{process:?} {index}: {ratio}"
            );
        }
        let (early, late) = (mean_product(0, 1), mean_product(37, 38));
        assert!((early - late).abs() < 0.12 * variance, "{process:?}");
    }
}

/// A draw is a function of seed, sensor and draw alone: each moves all of it, and the number of samples none.
#[test]
fn verif_seed_sensor_and_draw_each_give_other_samples() {
    let quiet = autoregression([0.9, 0.0], 150, &mut Random::new(2));
    let spectrum = fitted(&quiet, 1.0);
    let one = spectrum.drawn(100, 1, 0, 0);
    assert_eq!(one, spectrum.drawn(300, 1, 0, 0)[..100]);
    let others = [(2, 0, 0), (1 << 32, 0, 0), (1, 1, 0), (1, 0, 1)];
    for (seed, sensor, draw) in others {
        let other = spectrum.drawn(100, seed, sensor, draw);
        let equal = one.iter().zip(&other).filter(|(a, b)| a == b).count();
        assert_eq!(equal, 0, "{seed} {sensor} {draw}");
        let scale = deviation(&one) * deviation(&other) * 99.0;
        let product: f64 = one.iter().zip(&other).map(|(a, b)| a * b).sum();
        assert!(product.abs() < 0.8 * scale, "{seed} {sensor} {draw}");
    }
}

/// The variance is that of the stretch, one standard error high: of white samples √(2/n), of slow ones more.
#[test]
fn verif_the_variance_is_one_standard_error_high() {
    // The formula for an autoregression of first order: its squared correlations sum to (1 + r²)/(1 − r²).
    for correlation in [0.0_f64, 0.5, 0.9] {
        let sum = (1.0 + correlation * correlation) / (1.0 - correlation * correlation);
        for count in [300, 1_000, 10_000] {
            let mut ratio = 0.0;
            for seed in 0..20 {
                let quiet = autoregression([correlation, 0.0], count, &mut Random::new(seed));
                let high = variance(&fitted(&quiet, 0.0)) / (deviation(&quiet) * deviation(&quiet));
                ratio += (high - 1.0) / (2.0 * sum / count as f64).sqrt() / 20.0;
            }
            assert!(
                (0.75..1.25).contains(&ratio),
                "{correlation}, {count}: {ratio}"
            );
        }
    }
}

/// Short stretches get a lower order, and a power that does not fall towards low frequencies: over many of them the
/// slow part is never far below that of the process, and their variance is that of the stretch at least.
#[test]
fn verif_a_short_stretch_keeps_its_low_end() {
    for (count, order) in [(199, 9), (100, 5), (40, 2), (20, 1), (19, 0), (2, 0)] {
        let quiet = autoregression([0.6, 0.0], count, &mut Random::new(9));
        assert_eq!(fitted(&quiet, 0.0).order(), order, "{count}");
    }
    assert_eq!(
        fitted(
            &autoregression([0.6, 0.0], QUIET_SAMPLES, &mut Random::new(9)),
            0.0
        )
        .order(),
        ORDER_MAX
    );
    // A resonance in the middle: what lies below it falls, and is held.
    let resonant = [0.9, -0.81];
    let mut held = 0;
    for seed in 0..50 {
        let quiet = autoregression(resonant, 60, &mut Random::new(seed));
        let spectrum = fitted(&quiet, 0.0);
        let lowest = spectrum.power(0.0);
        let largest = (0..=32)
            .map(|part| spectrum.power(4.0 / 60.0 * f64::from(part) / 32.0))
            .fold(0.0, f64::max);
        // What is added at zero frequency adds to the largest as well, less of it.
        assert!(lowest > 0.65 * largest, "{seed}: {lowest} {largest}");
        held += usize::from(lowest > 1.02 * power(resonant, 0.0));
        let drawn = spectrum.drawn(20_000, seed, 0, 0);
        assert!(deviation(&drawn) > 0.85 * deviation(&quiet), "{seed}");
    }
    assert!(held > 10, "{held}");
}

/// Equal samples, and samples spread over no more than rounding does, leave the recorder's step: white.
#[test]
fn verif_a_silent_stretch_leaves_rounding() {
    let step = 0.3;
    let rounding = step / 12.0_f64.sqrt();
    for quiet in [vec![1.5; 500], vec![]] {
        let spectrum = NoiseSpectrum::fitted(&quiet, rounding, step);
        assert_eq!(spectrum.order(), 0);
        for cycles in [0.0, 0.1, 0.5] {
            let ratio = spectrum.power(cycles) / (rounding * rounding);
            assert!((ratio - 1.0).abs() < 1e-12, "{ratio}");
        }
        let drawn = spectrum.drawn(50_000, 1, 0, 0);
        assert!((deviation(&drawn) / rounding - 1.0).abs() < 0.02);
    }
    // Without a step there is nothing at all.
    assert_eq!(
        NoiseSpectrum::fitted(&[], 0.0, 0.0).drawn(3, 1, 0, 0),
        [0.0; 3]
    );
}

/// No noise has less of any frequency than rounding does, however narrow the band of the quiet stretch.
#[test]
fn verif_the_step_is_the_floor_of_every_spectrum() {
    let quiet = autoregression([1.9, -0.95], 2_000, &mut Random::new(4));
    let step = 20.0 * deviation(&quiet) / 12.0_f64.sqrt() / 8.0;
    let rounding = step / 12.0_f64.sqrt();
    let (without, with) = (fitted(&quiet, 0.0), fitted(&quiet, step));
    assert!(without.power(0.5) < 0.1 * rounding * rounding);
    for part in 0..=50 {
        let power = with.power(f64::from(part) / 100.0);
        assert!(power >= 0.999 * rounding * rounding, "{part}: {power}");
    }
}

/// The noise of a recording is that of its samples before −1 ms, and its step where there are none.
#[test]
fn verif_the_quiet_stretch_ends_before_the_event() {
    let mut samples = autoregression([0.9, 0.0], 400, &mut Random::new(8));
    let quiet = samples[..391].to_vec();
    samples.extend([100.0, -300.0, 900.0, 5.0]);
    let signal = |start_s: f64| Signal {
        start_s,
        rate: SampleRate::from_hertz(10_000.0).unwrap(),
        samples: samples.clone(),
    };
    let noise = Noise {
        deviation_m_s2: deviation(&quiet),
        step_m_s2: 0.1,
        on_grid: true,
    };
    let expected = NoiseSpectrum::fitted(&quiet, noise.deviation_m_s2, 0.1);
    assert_eq!(NoiseSpectrum::of(&signal(-0.04), &noise), expected);
    assert_eq!(NoiseSpectrum::of(&signal(0.0), &noise).order(), 0);
}
