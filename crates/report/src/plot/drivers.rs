//! What drives the peak: rank correlations as bars, the longest on top.

use super::axis::Axis;
use super::canvas::{Anchor, Canvas};
use super::frame::{self, LEFT, LegendEntry, Sample};
use super::{Figure, PlotContext, WIDTH};
use crate::words;
use latchgate_document::number::significant;
use latchgate_verdict::ensemble::Driver;

pub(super) const NAME: &str = "drivers";

/// Edges of the bars.
const FROM: f64 = LEFT + 250.0;
const TO: f64 = WIDTH - 92.0;

/// Height of a row.
const ROW: f64 = 30.0;

pub(super) fn draw(context: &PlotContext) -> Option<Figure> {
    let ensemble = context.document.ensemble.as_ref()?;
    let rows: Vec<(&Driver, f64)> = ensemble
        .drivers
        .iter()
        .filter_map(|driver| Some((driver, driver.rank_correlation?)))
        .collect();
    if rows.is_empty() {
        return None;
    }
    let entries = [
        LegendEntry::new(Sample::Patch("raises"), "more of it, a higher peak"),
        LegendEntry::new(Sample::Patch("lowers"), "more of it, a lower peak"),
        LegendEntry::new(Sample::Patch("chance"), "no more than chance"),
    ];
    let title = "What drives the peak";
    let mut canvas = Canvas::with_capacity(8 * 1024);
    let top = frame::header(&mut canvas, LEFT, title, &[], &entries);
    let bottom = top + 12.0 + ROW * rows.len() as f64;
    let height = bottom + frame::FOOTER;
    let axis = Axis::linear(-1.0, 1.0, FROM, TO);
    if let Some(chance) = ensemble.rank_correlation_by_chance {
        let chance = chance.min(1.0);
        let (from, to) = (axis.place(-chance), axis.place(chance));
        canvas.rectangle("chance", (from, top), (to - from, bottom - top));
    }
    for tick in axis.ticks(80.0, frame::LETTER) {
        let x = axis.place(tick.value);
        canvas.line("grid", (x, top), (x, bottom));
        canvas.line("tick", (x, bottom), (x, bottom + 5.0));
        canvas.text("muted", (x, bottom + 20.0), Anchor::Middle, &tick.label);
    }
    let zero = axis.place(0.0);
    bars(&mut canvas, &axis, &rows, top + 6.0);
    canvas.line("zero", (zero, top), (zero, bottom));
    canvas.rectangle("frame", (FROM, top), (TO - FROM, bottom - top));
    canvas.text(
        "",
        (f64::midpoint(FROM, TO), bottom + 42.0),
        Anchor::Middle,
        "rank correlation with the peak [−]",
    );
    canvas.text("muted", (TO + 10.0, bottom + 42.0), Anchor::Start, "share");
    frame::footer(&mut canvas, &context.origin, height);
    let list: Vec<String> = rows
        .iter()
        .map(|(driver, correlation)| {
            format!(
                "{}: {}",
                words::parameter(&driver.parameter),
                significant(*correlation, 2)
            )
        })
        .collect();
    Some(Figure {
        name: NAME,
        title: title.into(),
        caption: words::drivers_sentence(ensemble),
        description: format!(
            "Spearman’s rank correlation of each scattered parameter with the peak angle. {}.",
            list.join("; ")
        ),
        height,
        body: canvas.into_string(),
    })
}

/// Draws a bar for each parameter, with its name and its share, from `y` down.
fn bars(canvas: &mut Canvas, axis: &Axis, rows: &[(&Driver, f64)], mut y: f64) {
    let zero = axis.place(0.0);
    for (driver, correlation) in rows {
        let end = axis.place(*correlation);
        let class = if *correlation > 0.0 {
            "raises"
        } else {
            "lowers"
        };
        canvas.rectangle(
            class,
            (zero.min(end), y + 5.0),
            ((end - zero).abs().max(1.0), ROW - 10.0),
        );
        canvas.text(
            "",
            (FROM - 12.0, y + ROW / 2.0 + 5.0),
            Anchor::End,
            words::parameter(&driver.parameter),
        );
        canvas.text(
            "muted",
            (TO + 10.0, y + ROW / 2.0 + 5.0),
            Anchor::Start,
            &share(driver),
        );
        y += ROW;
    }
}

fn share(driver: &Driver) -> String {
    driver.share.map_or_else(String::new, |share| {
        format!("{:.0}\u{00A0}%", 100.0 * share)
    })
}
