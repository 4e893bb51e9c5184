//! Acceleration over time: as recorded and as used.

use super::canvas::{Anchor, Canvas};
use super::frame::{self, Frame, LEFT, LegendEntry, RIGHT, Sample};
use super::{Figure, PlotContext, thin};
use crate::words::{DIGITS, instant};
use latchgate_document::number::significant;
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY};
use latchgate_recording::Severity;
use latchgate_verdict::conditioning::Cfc;

pub(super) const NAME: &str = "acceleration";

pub(super) fn draw(context: &PlotContext) -> Option<Figure> {
    let evidence = context.evidence;
    let (low, high) = frame::extent(
        [&evidence.raw, &evidence.used]
            .into_iter()
            .flat_map(|signal| signal.samples.iter().copied()),
    );
    if low > high {
        return None;
    }
    let (low, high) = (
        low.min(0.0) / STANDARD_GRAVITY,
        high.max(0.0) / STANDARD_GRAVITY,
    );
    let margin = ((high - low) * 0.06).max(1e-6);

    let conditioning = context.document.conditioning.as_ref();
    let bias_window = conditioning.and_then(|block| block.bias_window_s);
    let faults = faults(context);
    let entries = legend(context, bias_window.is_some(), !faults.is_empty());
    let mut canvas = Canvas::with_capacity(96 * 1024);
    let title = "Lateral acceleration";
    let top = frame::header(&mut canvas, LEFT, title, &[], &entries);
    let bottom = top + 270.0;
    let height = bottom + frame::FOOTER;
    let panel = Frame::over_time(context, (low - margin, high + margin), top, bottom);
    if let Some((from, to)) = bias_window {
        let scale = context.time_scale;
        let x = (
            panel.x.place(from * scale).clamp(LEFT, RIGHT),
            panel.x.place(to * scale).clamp(LEFT, RIGHT),
        );
        canvas.rectangle("band", (x.0, top), ((x.1 - x.0).max(1.0), bottom - top));
    }
    let time = context.time_label();
    panel.grid(&mut canvas, Some(&time), Some("acceleration [g]"));
    panel.right_scale(&mut canvas, STANDARD_GRAVITY, "acceleration [m/s²]");
    panel.level(&mut canvas, "zero", 0.0);
    panel.begin_inside(&mut canvas, "acceleration-clip");
    for (class, signal) in [("raw", &evidence.raw), ("used", &evidence.used)] {
        canvas.polyline(class, points(context, &panel, signal).into_iter());
    }
    canvas.end_group();
    judged_window(&mut canvas, context, &panel);
    for (index, (at_s, code)) in faults.iter().take(8).enumerate() {
        let x = panel.x.place(at_s * context.time_scale);
        canvas.line("fault", (x, top), (x, bottom));
        let y = top + 18.0 + index as f64 * 18.0;
        panel.label(&mut canvas, "alarm halo", (x, y), code);
    }
    opening_side(&mut canvas, context, &panel);
    panel.frame(&mut canvas);
    frame::footer(&mut canvas, &context.origin, height);

    let peak = peak_sentence(context);
    Some(Figure {
        name: NAME,
        title: title.into(),
        caption: format!(
            "As recorded (grey) and as the lever feels it (black): {}.{peak}",
            used_text(context)
        ),
        description: format!(
            "Acceleration in g and m/s² over time, as recorded and as used, from {} to {}.{peak}",
            instant(context.span_s.0),
            instant(context.span_s.1)
        ),
        height,
        body: canvas.into_string(),
    })
}

fn legend(context: &PlotContext, has_bias: bool, has_faults: bool) -> Vec<LegendEntry> {
    let mut entries = vec![
        LegendEntry::line("raw", "as recorded"),
        LegendEntry::line("used", used_text(context)),
    ];
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

pub(super) fn used_text(context: &PlotContext) -> String {
    let Some(block) = &context.document.conditioning else {
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

fn points(context: &PlotContext, panel: &Frame, signal: &Signal) -> Vec<(f64, f64)> {
    thin::columns(
        signal.samples.iter().enumerate().map(|(index, value)| {
            panel.place(
                signal.time_s(index) * context.time_scale,
                value / STANDARD_GRAVITY,
            )
        }),
        1.0,
    )
}

/// Marks where the judged window starts and ends, if one was asked for.
pub(super) fn judged_window(canvas: &mut Canvas, context: &PlotContext, panel: &Frame) {
    if let Some((start, end)) = context.document.request.window_s {
        for instant in [start, end] {
            panel.upright(canvas, "edge", instant * context.time_scale);
        }
    }
}

/// Says which side of zero opens the lever of the nominal run.
fn opening_side(canvas: &mut Canvas, context: &PlotContext, panel: &Frame) {
    let Some(run) = &context.document.nominal else {
        return;
    };
    let (y, text) = match run.opens_when {
        OpensWhen::Negative => (panel.bottom - 9.0, "\u{2193} opens"),
        OpensWhen::Positive => (panel.top + 18.0, "\u{2191} opens"),
    };
    let nominal = if context.document.polarities.len() > 1 {
        " (nominal run)"
    } else {
        ""
    };
    canvas.text(
        "muted halo",
        (RIGHT - 8.0, y),
        Anchor::End,
        &format!("{text}{nominal}"),
    );
}
