//! Amplitude spectra before and after conditioning.

use super::PlotContext;
use super::acceleration::filter_text;
use super::chart::{ACROSS, At, Chart, Panel, Point};
use super::frame::{LegendEntry, Scale, WIDE, extent};
use latchgate_document::number::trimmed;
use latchgate_kernel::units::STANDARD_GRAVITY;
use latchgate_verdict::conditioning::spectrum::AmplitudeSpectrum;

pub(super) const NAME: &str = "amplitude-spectra";

/// Decades below the largest amplitude that are shown.
const DEPTH: f64 = 1e-5;

/// Factor from the largest amplitude to the top of the scale, which leaves room for the labels.
const HEADROOM: f64 = 12.0;

pub(super) fn chart(context: &PlotContext) -> Option<Chart> {
    let evidence = context.evidence;
    let spectra = [&evidence.spectrum_raw, &evidence.spectrum_used];
    let points = || spectra.into_iter().flat_map(shown);
    let amplitudes = extent(points().map(|point| point.y));
    let frequencies = extent(points().map(|point| point.x));
    if !(amplitudes.high > 0.0 && frequencies.width() > 0.0) {
        return None;
    }
    let conditioning = context.document.conditioning.as_ref();
    let class = conditioning
        .and_then(|block| block.filter)
        .map(|filter| f64::from(filter.class()));
    let design_hz = conditioning.and_then(|block| block.filter_design_frequency_hz);
    let low = amplitudes.low.max(amplitudes.high * DEPTH) * 0.8;
    let marks = [(class, "class", 18.0), (design_hz, "fd", 38.0)].into_iter();
    let marks = marks.filter_map(|(hz, name, y)| Some((hz?, name, y)));
    let marks = marks.filter(|(hz, ..)| frequencies.contains(*hz));
    let panel = Panel::new(&WIDE, ACROSS, 270.0)
        .x(
            "frequency [Hz]",
            Scale::Logarithmic(frequencies.low, frequencies.high),
        )
        .y(
            "amplitude [g]",
            Scale::Logarithmic(low, amplitudes.high * HEADROOM),
        )
        .each(
            ["raw", "used"].into_iter().zip(spectra),
            |panel, (class, spectrum)| panel.function(class, shown(spectrum)),
        )
        .each(marks, |panel, (hz, name, y)| {
            let text = format!("{name} {} Hz", trimmed(hz, 5));
            panel
                .upright("edge", hz)
                .beside("halo", (At::Value(hz, 0.0), At::High(y)), text)
        });
    let filter = match (class, design_hz) {
        (Some(class), Some(design)) => format!(
            " The filter passes what lies below its class frequency, {class} Hz, and falls off \
             beyond; each of its two passes is designed at fd = {} Hz.",
            trimmed(design, 6)
        ),
        _ => " No filter was applied.".to_string(),
    };
    Some(Chart {
        name: NAME,
        title: "Amplitude spectra before and after conditioning".into(),
        legend: vec![
            LegendEntry::line("raw", "as recorded"),
            LegendEntry::line("used", used_text(context)),
        ],
        panels: vec![panel],
        caption: format!(
            "A pure tone shows its amplitude at its frequency; both scales are logarithmic.{filter}"
        ),
        description: format!(
            "Amplitude in g against frequency from {} to {} Hz, as recorded and as used; the \
             largest is {} g.{filter}",
            trimmed(frequencies.low, 4),
            trimmed(frequencies.high, 4),
            trimmed(amplitudes.high, 4)
        ),
        ..context.chart()
    })
}

/// Returns the filter between the two spectra in words.
fn used_text(context: &PlotContext) -> String {
    match &context.document.conditioning {
        None => "as used".into(),
        Some(block) => format!("as used ({})", filter_text(block.filter)),
    }
}

/// Returns frequency [Hz] and amplitude [g] of the lines that a logarithmic scale can show.
fn shown(spectrum: &AmplitudeSpectrum) -> impl Iterator<Item = Point> + '_ {
    spectrum
        .frequency_hz
        .iter()
        .zip(&spectrum.amplitude_m_s2)
        .map(|(&frequency, &amplitude)| Point::new(frequency, amplitude / STANDARD_GRAVITY))
        .filter(|point| point.x > 0.0 && point.y > 0.0 && point.is_finite())
}
