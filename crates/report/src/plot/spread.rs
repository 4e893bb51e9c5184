//! How far the scattered levers spread around the nominal one, over time.

use super::angle::result_sentence;
use super::canvas::Canvas;
use super::frame::{self, Frame, LEFT, LegendEntry, Sample};
use super::{Figure, PlotContext, acceleration, thin};
use crate::words;
use latchgate_document::number::{count, exact};
use latchgate_kernel::model::stop::StopModel;
use latchgate_verdict::{QuantileBand, Trace};

pub(super) const NAME: &str = "spread";

pub(super) fn draw(context: &PlotContext) -> Option<Figure> {
    let band = context.evidence.quantile_band.as_ref()?;
    let document = context.document;
    let threshold = document.threshold_rad;
    let nominal = context
        .evidence
        .traces
        .iter()
        .find(|trace| trace.model == band.model && trace.opens_when == band.opens_when);
    let angles = || {
        band.p05
            .iter()
            .chain(&band.p95)
            .copied()
            .chain(
                nominal
                    .iter()
                    .flat_map(|trace| trace.points.iter().map(|point| point.angle_rad)),
            )
            .filter(|angle| angle.is_finite())
    };
    let high = angles().fold(threshold, f64::max);
    let low = angles().fold(0.0, f64::min);
    let range = (low - (high - low) * 0.03, high + (high - low) * 0.10);

    let (ribbon, run) = classes(band);
    let entries = [
        LegendEntry::new(Sample::Patch(ribbon), "9 of 10 levers at each instant"),
        LegendEntry::line("median", "median"),
        LegendEntry::line(run, "nominal run"),
        LegendEntry::line("limit", "limit"),
    ];
    let mut canvas = Canvas::with_capacity(64 * 1024);
    let title = "Spread of the scattered levers";
    let top = frame::header(&mut canvas, LEFT, title, &[], &entries);
    let panel = Frame::over_time(context, range, top, top + 250.0);
    let height = panel.bottom + frame::FOOTER;
    let time = context.time_label();
    panel.grid(&mut canvas, Some(&time), Some("angle φ [rad]"));
    panel.level(&mut canvas, "zero", 0.0);
    panel.begin_inside(&mut canvas, "spread-clip");
    curves(&mut canvas, context, &panel, nominal);
    canvas.end_group();
    acceleration::judged_window(&mut canvas, context, &panel);
    panel.limit(
        &mut canvas,
        threshold,
        &format!("limit {} rad", exact(threshold)),
    );
    panel.frame(&mut canvas);
    frame::footer(&mut canvas, &context.origin, height);
    let members = count(u64::try_from(band.members).unwrap_or(u64::MAX));
    let which = format!(
        "{}, {}",
        words::stop(band.model),
        words::opens(band.opens_when)
    );
    Some(Figure {
        name: NAME,
        title: title.into(),
        caption: format!(
            "The first {members} members of the ensemble ({which}), the nominal lever among them. \
             At each instant five in a hundred lie above the band and five below; single levers \
             leave it for a moment, so peaks are read from the table of the ensemble, not from \
             the band."
        ),
        description: format!(
            "Band between the 5 % and 95 % quantile of the angle of {members} scattered levers \
             over time ({which}), with their median and the nominal run. {}",
            result_sentence(context)
        ),
        height,
        body: canvas.into_string(),
    })
}

/// Returns the classes of the band and of the run within it, in the colour of their stop.
fn classes(band: &QuantileBand) -> (&'static str, &'static str) {
    match band.model {
        StopModel::Rigid => ("ribbon of-rigid", "run-rigid"),
        StopModel::Soft => ("ribbon of-soft", "run-soft"),
    }
}

/// Draws the band, the nominal run and the median.
fn curves(canvas: &mut Canvas, context: &PlotContext, panel: &Frame, nominal: Option<&Trace>) {
    let Some(band) = &context.evidence.quantile_band else {
        return;
    };
    let scale = context.time_scale;
    let along = |values: &[f64]| -> Vec<(f64, f64)> {
        band.time_s
            .iter()
            .zip(values)
            .map(|(time, angle)| panel.place(time * scale, *angle))
            .collect()
    };
    let outline = along(&band.p95)
        .into_iter()
        .chain(along(&band.p05).into_iter().rev());
    let (ribbon, run) = classes(band);
    canvas.polyline(ribbon, outline);
    if let Some(trace) = nominal {
        let points = thin::columns(
            trace
                .points
                .iter()
                .map(|point| panel.place(point.time_s * scale, point.angle_rad)),
            0.5,
        );
        canvas.polyline(run, points.into_iter());
    }
    canvas.polyline("median", along(&band.p50).into_iter());
}
