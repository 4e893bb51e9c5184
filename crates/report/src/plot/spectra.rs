//! Amplitude spectra before and after conditioning.

use super::acceleration::filter_text;
use super::canvas::{Anchor, Canvas};
use super::frame::{self, Frame, LEFT, LegendEntry, RIGHT, Scale};
use super::{Figure, PlotContext, thin};
use latchgate_document::number::trimmed;
use latchgate_kernel::units::STANDARD_GRAVITY;
use latchgate_verdict::conditioning::spectrum::AmplitudeSpectrum;

pub(super) const NAME: &str = "amplitude-spectra";

/// Decades below the largest amplitude that are shown.
const DEPTH: f64 = 1e-5;

/// What the scale reaches above the largest amplitude, so that the labels stand free.
const HEADROOM: f64 = 12.0;

pub(super) fn draw(context: &PlotContext) -> Option<Figure> {
    let evidence = context.evidence;
    let spectra = [&evidence.spectrum_raw, &evidence.spectrum_used];
    let points = || spectra.into_iter().flat_map(shown);
    let largest = points().map(|(_, amplitude)| amplitude).fold(0.0, f64::max);
    let least = points()
        .map(|(_, amplitude)| amplitude)
        .fold(f64::INFINITY, f64::min);
    let low_hz = points()
        .map(|(frequency, _)| frequency)
        .fold(f64::INFINITY, f64::min);
    let high_hz = points().map(|(frequency, _)| frequency).fold(0.0, f64::max);
    if !(largest > 0.0 && high_hz > low_hz) {
        return None;
    }

    let conditioning = context.document.conditioning.as_ref();
    let class = conditioning
        .and_then(|block| block.filter)
        .map(|filter| f64::from(filter.class()));
    let design_hz = conditioning.and_then(|block| block.filter_design_frequency_hz);

    let mut canvas = Canvas::with_capacity(96 * 1024);
    let title = "Amplitude spectra before and after conditioning";
    let entries = [
        LegendEntry::line("raw", "as recorded"),
        LegendEntry::line("used", used_text(context)),
    ];
    let top = frame::header(&mut canvas, LEFT, title, &[], &entries);
    let bottom = top + 270.0;
    let height = bottom + frame::FOOTER;
    let low = least.max(largest * DEPTH) * 0.8;
    let panel = Frame::wide(
        (top, bottom),
        Scale::Logarithmic(low_hz, high_hz),
        Scale::Logarithmic(low, largest * HEADROOM),
    );
    panel.grid(&mut canvas, Some("frequency [Hz]"), Some("amplitude [g]"));
    panel.begin_inside(&mut canvas, "amplitude-spectra-clip");
    for (class, spectrum) in ["raw", "used"].into_iter().zip(spectra) {
        let points = thin::columns(
            shown(spectrum).map(|(frequency, amplitude)| panel.place(frequency, amplitude)),
            1.0,
        );
        canvas.polyline(class, points.into_iter());
    }
    canvas.end_group();
    frequencies(&mut canvas, &panel, class, design_hz);
    panel.frame(&mut canvas);
    frame::footer(&mut canvas, &context.origin, height);

    let filter = match (class, design_hz) {
        (Some(class), Some(design)) => format!(
            " The filter passes what lies below its class frequency, {class} Hz, and falls off \
             beyond; each of its two passes is designed at fd = {} Hz.",
            trimmed(design, 6)
        ),
        _ => " No filter was applied.".to_string(),
    };
    Some(Figure {
        name: NAME,
        title: title.into(),
        caption: format!(
            "A pure tone shows its amplitude at its frequency; both scales are logarithmic.{filter}"
        ),
        description: format!(
            "Amplitude in g against frequency from {} to {} Hz, as recorded and as used; the \
             largest is {} g.{filter}",
            trimmed(low_hz, 4),
            trimmed(high_hz, 4),
            trimmed(largest, 4)
        ),
        height,
        body: canvas.into_string(),
    })
}

/// Says which filter stands between the spectra.
fn used_text(context: &PlotContext) -> String {
    match &context.document.conditioning {
        None => "as used".into(),
        Some(block) => format!("as used ({})", filter_text(block.filter)),
    }
}

/// Marks the filter's class and design frequency.
fn frequencies(canvas: &mut Canvas, panel: &Frame, class: Option<f64>, design_hz: Option<f64>) {
    // One label to the left of its line and one to the right, so that they keep apart.
    let marks = [(class, "class", false), (design_hz, "fd", true)];
    for (frequency, name, right) in marks {
        let Some(frequency) = frequency.filter(|frequency| panel.x.contains(*frequency)) else {
            continue;
        };
        panel.upright(canvas, "edge", frequency);
        let x = panel.x.place(frequency);
        let text = format!("{name} {} Hz", trimmed(frequency, 5));
        let room = RIGHT - x > 108.0;
        let (at, anchor) = match (right, room) {
            (true, true) => ((x + 7.0, panel.top + 18.0), Anchor::Start),
            (true, false) => ((x - 7.0, panel.top + 38.0), Anchor::End),
            (false, _) => ((x - 7.0, panel.top + 18.0), Anchor::End),
        };
        canvas.text("halo", at, anchor, &text);
    }
}

/// Returns frequency [Hz] and amplitude [g] of what a logarithmic scale can show.
fn shown(spectrum: &AmplitudeSpectrum) -> impl Iterator<Item = (f64, f64)> + '_ {
    spectrum
        .frequency_hz
        .iter()
        .zip(&spectrum.amplitude_m_s2)
        .map(|(&frequency, &amplitude)| (frequency, amplitude / STANDARD_GRAVITY))
        .filter(|(frequency, amplitude)| {
            *frequency > 0.0 && *amplitude > 0.0 && frequency.is_finite() && amplitude.is_finite()
        })
}
