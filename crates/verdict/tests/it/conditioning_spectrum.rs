//! Guards the spectra: tones read their amplitude, and the squares add up.

use crate::support::{Random, signal_from};
use latchgate_kernel::signal::Signal;
use latchgate_verdict::conditioning::spectrum::{amplitude_spectrum, spectrogram};
use std::f64::consts::PI;

fn signal(rate_hz: f64, samples: Vec<f64>) -> Signal {
    signal_from(rate_hz, -0.02, samples)
}

fn tone(rate_hz: f64, frequency_hz: f64, amplitude: f64, count: usize) -> Signal {
    signal(
        rate_hz,
        (0..count)
            .map(|n| amplitude * (2.0 * PI * frequency_hz * n as f64 / rate_hz + 0.7).sin())
            .collect(),
    )
}

#[track_caller]
fn check_line(amplitudes: &[f64], frequencies: &[f64], frequency_hz: f64, expected: f64) {
    let (line, found) = amplitudes
        .iter()
        .enumerate()
        .max_by(|a, b| a.1.total_cmp(b.1))
        .unwrap();
    assert!((found / expected - 1.0).abs() < 0.01, "{found}");
    assert!(
        (frequencies[line] - frequency_hz).abs() < 1e-6,
        "{}",
        frequencies[line]
    );
}

#[test]
fn val_a_tone_shows_its_amplitude_at_its_frequency() {
    for (count, frequency_hz) in [
        (1000, 480.0),
        (1000, 4_990.0),
        (997, 10_000.0 * 48.0 / 997.0),
    ] {
        let spectrum = amplitude_spectrum(&tone(10_000.0, frequency_hz, 37.0, count));
        check_line(
            &spectrum.amplitude_m_s2,
            &spectrum.frequency_hz,
            frequency_hz,
            37.0,
        );
        assert_eq!(spectrum.frequency_hz.len(), count / 2 + 1);
    }
    let constant = amplitude_spectrum(&signal(1000.0, vec![-2.5; 64]));
    assert!((constant.amplitude_m_s2[0] - 2.5).abs() < 1e-12);
}

#[test]
fn val_a_spectrogram_shows_a_tone_in_every_window() {
    let frequency_hz = 10_000.0 * 12.0 / 128.0;
    let record = tone(10_000.0, frequency_hz, 37.0, 3000);
    let found = spectrogram(&record);
    assert!((found.window_s - 0.0128).abs() < 1e-12);
    assert_eq!(found.time_s.len(), found.amplitude_m_s2.len());
    assert!((found.time_s[0] - (-0.02 + 0.0064)).abs() < 1e-12);
    assert!((found.time_s[1] - found.time_s[0] - 0.0032).abs() < 1e-12);
    for row in &found.amplitude_m_s2 {
        check_line(row, &found.frequency_hz, frequency_hz, 37.0);
    }
    assert!((found.frequency_hz.last().unwrap() - 5_000.0).abs() < 1e-9);
}

/// Parseval: half the square of each amplitude, the whole square at both ends.
#[test]
fn prop_squares_of_the_spectrum_add_up_to_the_mean_square() {
    for (seed, count) in [(1, 4126), (2, 997), (3, 2), (4, 1), (5, 1023)] {
        println!("seed {seed}");
        let mut random = Random::new(seed);
        let samples: Vec<f64> = (0..count).map(|_| 3.0 + 50.0 * random.normal()).collect();
        let mean_square = samples.iter().map(|x| x * x).sum::<f64>() / samples.len() as f64;
        let spectrum = amplitude_spectrum(&signal(12_500.0, samples));
        let sum: f64 = spectrum
            .amplitude_m_s2
            .iter()
            .enumerate()
            .map(|(line, a)| {
                let whole = line == 0 || 2 * line == count;
                a * a * if whole { 1.0 } else { 0.5 }
            })
            .sum();
        assert!(
            (sum / mean_square - 1.0).abs() < 1e-12,
            "{sum} {mean_square}"
        );
    }
}

#[test]
fn verif_spectra_of_any_length_stay_bounded() {
    for count in [0, 1, 2, 7, 8, 9, 31, 100, 100_000] {
        let record = tone(10_000.0, 200.0, 1.0, count);
        let found = spectrogram(&record);
        assert!(found.time_s.len() <= 300 && found.frequency_hz.len() <= 2049);
        assert_eq!(found.time_s.is_empty(), count < 8);
        assert!(
            found
                .amplitude_m_s2
                .iter()
                .all(|row| row.len() == found.frequency_hz.len())
        );
        assert_eq!(
            amplitude_spectrum(&record).frequency_hz.is_empty(),
            count == 0
        );
    }
}
