//! What a channel holds at high frequencies, against what is said of it.
//!
//! A structure in a crash rings at hundreds of hertz, and what a sensor adds of its own is there as well.
//! Where that is missing, the channel was filtered, or curves were laid through the samples of a slow
//! clock; neither shows in single samples.

use super::{ConditioningOptions, Signal, bias, spectrum, without_bias};
use latchgate_kernel::units::plain;
use latchgate_recording::{Channel, Finding, Severity};

/// Frequencies of a crash's push and of a structure's ringing [Hz].
const LOW_HZ: std::ops::RangeInclusive<f64> = 5.0..=60.0;
const HIGH_HZ: std::ops::RangeInclusive<f64> = 500.0..=1500.0;

/// Mean power of the high frequencies against that of the low ones [dB] below which a channel is empty
/// there, where CFC 1000 or no filter is stated: channels of structures have −17 at least.
const EMPTY_DB: f64 = -40.0;

/// The same where nothing is stated: pushes of a sled have −69 with their sensor's noise, CFC 60 leaves
/// −67, cubic curves through samples of 100 Hz −77 and less.
const EMPTY_UNSTATED_DB: f64 = -75.0;

/// Part of the record at either end over which it is faded, so that its ends are no steps.
const FADED_PART: f64 = 0.1;

/// Samples of which a record is padded to a multiple, so that its length has no large prime factor but of long
/// ones.
const TRANSFORMED_BY: usize = 512;

/// Warns of a raw channel that holds nothing above 500 Hz although nothing says that it was filtered.
pub(super) fn finding(
    raw: &Signal,
    channel: &Channel,
    options: &ConditioningOptions,
) -> Option<Finding> {
    let stated = &channel.stated;
    // What CFC 1000 lets pass begins to fall at 1650 Hz, and so do the analogue filters before it.
    let wide = stated.unfiltered
        || options.wide_band
        || stated.filter_class.as_deref() == Some("1000")
        || stated.prefilter_hz.is_some();
    if says_filtered(channel) || options.synthetic || raw.rate.hertz() < 2.0 * HIGH_HZ.end() {
        return None;
    }
    let level_db = level_db(raw)?;
    let limit = if wide { EMPTY_DB } else { EMPTY_UNSTATED_DB };
    (level_db < limit).then(|| {
        let text = format!(
            "the channel has no content above {} Hz ({} dB against {} to {} Hz). It was filtered, \
             or interpolated by curves from a slow clock. The file does not say so. Export it as \
             it was recorded",
            HIGH_HZ.start(),
            plain(level_db, 2),
            LOW_HZ.start(),
            LOW_HZ.end()
        );
        Finding::warning("band-empty", text)
    })
}

/// True if the file says that the channel was filtered in a way that counts.
pub(super) fn says_filtered(channel: &Channel) -> bool {
    channel
        .findings
        .iter()
        .any(|finding| finding.code == "already-filtered" && finding.severity == Severity::Warning)
}

/// Returns the mean power of the high frequencies against that of the low ones [dB].
pub(super) fn level_db(raw: &Signal) -> Option<f64> {
    let (zero, _) = bias::bias(raw, super::BiasWindow::PreEvent).ok()?;
    let mut faded = without_bias(raw, zero.mean_m_s2);
    let count = faded.samples.len();
    let fade = (FADED_PART * count as f64) as usize;
    for index in 0..fade {
        let part = index as f64 / fade as f64;
        let weight = 0.5 - 0.5 * libm::cos(std::f64::consts::PI * part);
        faded.samples[index] *= weight;
        faded.samples[count - 1 - index] *= weight;
    }
    // Zeros after the fade change no power, and a length with small factors transforms at once.
    let length = count.next_multiple_of(TRANSFORMED_BY);
    faded.samples.resize(length, 0.0);
    let spectrum = spectrum::amplitude_spectrum(&faded);
    let mean_power = |band: std::ops::RangeInclusive<f64>| {
        let lines = spectrum.frequency_hz.iter().zip(&spectrum.amplitude_m_s2);
        let inside = lines.filter(|(frequency, _)| band.contains::<f64>(frequency));
        let powers: Vec<f64> = inside.map(|(_, amplitude)| amplitude * amplitude).collect();
        (!powers.is_empty()).then(|| powers.iter().sum::<f64>() / powers.len() as f64)
    };
    let (low, high) = (mean_power(LOW_HZ)?, mean_power(HIGH_HZ)?);
    (low > 0.0).then(|| 10.0 * libm::log10(high / low))
}
