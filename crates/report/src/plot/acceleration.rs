//! Acceleration over time: as recorded and as used.

use super::PlotContext;
use super::chart::{At, Chart, Panel, Point};
use super::frame::{self, LegendEntry, Sample, Scale};
use crate::words::{DIGITS, instant};
use latchgate_document::Document;
use latchgate_document::number::significant;
use latchgate_kernel::range::Range;
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY};
use latchgate_recording::Severity;
use latchgate_verdict::Evidence;
use latchgate_verdict::conditioning::Cfc;

pub(super) const NAME: &str = "acceleration";

pub(super) fn chart(context: &PlotContext) -> Option<Chart> {
    let Evidence {
        raw, used, second, ..
    } = context.evidence;
    let second = second.as_ref().map(|second| ("velocity", second));
    let signals: Vec<(&str, &Signal)> = [("raw", raw), ("used", used)]
        .into_iter()
        .chain(second)
        .collect();
    let samples = signals.iter().flat_map(|(_, signal)| &signal.samples);
    let range = frame::extent(samples.map(|value| value / STANDARD_GRAVITY));
    if range == Range::EMPTY {
        return None;
    }
    let Range { low, high } = range.including(0.0);
    let margin = ((high - low) * 0.06).max(1e-6);
    let conditioning = context.document.conditioning.as_ref();
    let bias_window = conditioning.and_then(|block| block.bias_window_s);
    let scale = context.time_scale;
    let faults = faults(context);
    let panel = context
        .over_time(270.0)
        .y(
            "acceleration [g]",
            Scale::Linear(low - margin, high + margin),
        )
        .right(STANDARD_GRAVITY, "acceleration [m/s²]")
        .each(bias_window, |panel, (from, to)| {
            panel.band("band", from * scale, to * scale)
        })
        .level("zero", 0.0)
        .each(signals, |panel, (class, signal)| {
            let samples = signal.samples.iter().enumerate();
            let points = samples.map(|(index, value)| {
                Point::new(signal.time_s(index) * scale, value / STANDARD_GRAVITY)
            });
            panel.function(class, points)
        })
        .each(
            faults.iter().take(8).zip(0..),
            |panel, ((at_s, code), line)| {
                let y = At::High(18.0 + 18.0 * f64::from(line));
                panel.upright("fault", at_s * scale).beside(
                    "alarm halo",
                    (At::Value(at_s * scale, 0.0), y),
                    *code,
                )
            },
        );
    let panel = opening_side(context, context.judged_window(panel));
    let peak = peak_sentence(context);
    Some(Chart {
        name: NAME,
        title: "Lateral acceleration".into(),
        legend: legend(context, bias_window.is_some(), !faults.is_empty()),
        panels: vec![panel],
        caption: format!(
            "As recorded (grey) and as the lever feels it (black): {}.{peak}",
            used_text(context.document)
        ),
        description: format!(
            "Acceleration in g and m/s² over time, as recorded and as used, from {} to {}.{peak}",
            instant(context.span.from_s),
            instant(context.span.until_s)
        ),
        ..context.chart()
    })
}

fn legend(context: &PlotContext, has_bias: bool, has_faults: bool) -> Vec<LegendEntry> {
    let mut entries = vec![
        LegendEntry::line("raw", "as recorded"),
        LegendEntry::line("used", used_text(context.document)),
    ];
    if let Some(block) = &context.document.in_plane {
        let text = format!("{}, across, as used", block.radial_channel);
        entries.push(LegendEntry::line("velocity", text));
    }
    if has_bias {
        entries.push(LegendEntry::new(Sample::Patch("band"), "bias window"));
    }
    if has_faults {
        entries.push(LegendEntry::line("fault", "blocking finding"));
    }
    if context.document.request.window_s.is_some() {
        entries.push(LegendEntry::line("edge", "judged window"));
    }
    entries
}

fn peak_sentence(context: &PlotContext) -> String {
    let recording = &context.document.recording;
    match (recording.peak_g, recording.peak_time_s) {
        (Some(peak), Some(at)) => format!(
            " The largest recorded magnitude is {} g at {}.",
            significant(peak, DIGITS),
            instant(at)
        ),
        _ => String::new(),
    }
}

/// Returns where blocking findings begin [s], with their codes.
fn faults<'a>(context: &PlotContext<'a>) -> Vec<(f64, &'a str)> {
    context
        .document
        .findings
        .iter()
        .filter(|finding| finding.severity == Severity::Blocking)
        .filter_map(|finding| Some((finding.at_s?, &*finding.code)))
        .collect()
}

pub(super) fn used_text(document: &Document) -> String {
    let Some(block) = &document.conditioning else {
        return "as used".into();
    };
    let bias = if block.bias_window_s.is_some() {
        "bias removed"
    } else {
        "no bias removed"
    };
    let filter = filter_text(block.filter);
    format!("as used ({bias}, {filter})")
}

/// Returns the filter as a legend names it: `CFC 1000`, `no filter`.
pub(super) fn filter_text(filter: Option<Cfc>) -> String {
    filter.map_or_else(
        || "no filter".into(),
        |class| format!("CFC {}", class.class()),
    )
}

/// Says which side of zero opens the lever of the nominal run.
fn opening_side(context: &PlotContext, panel: Panel) -> Panel {
    panel.each(&context.document.nominal, |panel, run| {
        let (y, text) = match run.opens_when {
            OpensWhen::Negative => (At::Low(-9.0), "\u{2193} opens"),
            OpensWhen::Positive => (At::High(18.0), "\u{2191} opens"),
        };
        let nominal = match context.document.polarities.len() {
            0 | 1 => "",
            _ => " (nominal run)",
        };
        panel.text(
            "muted halo",
            (At::High(-8.0), y),
            format!("{text}{nominal}"),
        )
    })
}
