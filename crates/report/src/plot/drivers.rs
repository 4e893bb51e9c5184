//! Drivers of the peak: rank correlations as bars, the longest on top.

use super::PlotContext;
use super::chart::At::{High, Low, Value};
use super::chart::{Chart, Edges, Panel};
use super::frame::{LEFT, LegendEntry, RIGHT, Sample, Scale, WIDE};
use crate::words;
use latchgate_document::number::significant;
use latchgate_verdict::ensemble::Driver;

pub(super) const NAME: &str = "drivers";

pub(super) fn chart(context: &PlotContext) -> Option<Chart> {
    let ensemble = context.document.ensemble.as_ref()?;
    let drivers = ensemble.drivers.iter();
    let drivers = drivers.filter_map(|driver| Some((driver, driver.rank_correlation?)));
    let rows: Vec<(&Driver, f64)> = drivers.collect();
    if rows.is_empty() {
        return None;
    }
    let chance = ensemble.rank_correlation_by_chance;
    let list = rows.iter().map(|(driver, correlation)| {
        let name = words::parameter(&driver.parameter);
        format!("{name}: {}", significant(*correlation, 2))
    });
    let list: Vec<String> = list.collect();
    let panel = Panel::new(
        &WIDE,
        Edges::new(LEFT + 250.0, RIGHT),
        12.0 + 30.0 * rows.len() as f64,
    )
    .x(
        "rank correlation with the peak [−]",
        Scale::Linear(-1.0, 1.0),
    )
    .y("", Scale::Cells(rows.len()))
    .each(chance, |panel, chance| {
        panel.band("chance", -chance, chance)
    })
    .each(
        rows.iter().rev().zip(0..),
        |panel, (&(driver, correlation), row)| {
            let class = if correlation > 0.0 {
                "raises"
            } else {
                "lowers"
            };
            let y = |down| Value(f64::from(row) + 0.5, down);
            let (from, to) = (
                (Value(0.0, 0.0), y(-10.0)),
                (Value(correlation, 0.0), y(10.0)),
            );
            panel
                .patch(class, from, to)
                .text(
                    "",
                    (Low(-12.0), y(5.0)),
                    words::parameter(&driver.parameter),
                )
                .text("muted", (High(10.0), y(5.0)), share(driver))
        },
    )
    .upright("zero", 0.0)
    .text("muted", (High(10.0), Low(42.0)), "share");
    let patch = |class, text| LegendEntry::new(Sample::Patch(class), text);
    Some(Chart {
        name: NAME,
        title: "What drives the peak".into(),
        legend: vec![
            patch("raises", "more of it, a higher peak"),
            patch("lowers", "more of it, a lower peak"),
            patch("chance", "no more than chance"),
        ],
        panels: vec![panel],
        caption: words::drivers_sentence(ensemble),
        description: format!(
            "Spearman’s rank correlation of each varied parameter with the largest angle. {}.",
            list.join("; ")
        ),
        ..context.chart()
    })
}

fn share(driver: &Driver) -> String {
    driver.share.map_or_else(String::new, |share| {
        format!("{:.0}\u{00A0}%", 100.0 * share)
    })
}
