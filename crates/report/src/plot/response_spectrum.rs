//! The chart of latch response spectra: lift-off over stroke, with zone, envelope and designs.

use super::chart::At::{High, Low, Value};
use super::chart::{Chart, Edges, Panel, Point, Shape};
use super::frame::{LegendEntry, Sample, Scale, WIDE};
use super::{Figure, WIDTH};
use crate::escape;
use crate::spectrum_words::{is_pulse, short_names, subtitle};
use latchgate_document::SpectrumDocument;
use latchgate_document::number::significant;
use latchgate_document::spectrum_document::DesignPoint;
use latchgate_kernel::range::Range;
use latchgate_kernel::units::STANDARD_GRAVITY;

/// Rules of this chart beyond those of all plots.
pub(crate) const RULES: &str = include_str!("spectrum.css");

/// Classes of curves that are told apart.
const CURVES: [&str; 12] = [
    "curve of-0",
    "curve of-1",
    "curve of-2",
    "curve of-3",
    "curve of-4",
    "curve of-5",
    "curve of-6",
    "curve of-7",
    "curve of-8",
    "curve of-9",
    "curve of-10",
    "curve of-11",
];

/// Edges of the panel: room for the title at its left.
const EDGES: Edges = Edges::new(86.0, WIDTH - 16.0);

/// Class of a pulse by formula.
const PULSE: &str = "curve of-pulse";

/// Class of each of more curves than that.
const MANY: &str = "curve of-many";

/// Curves up to which each shows its zone and its push without bounces.
const WITH_ZONE: usize = 2;
const ZONES: [&str; WITH_ZONE] = ["zone-0", "zone-1"];
const PUSHES: [&str; WITH_ZONE] = ["push-0", "push-1"];

/// The static requirement of 49 CFR 571.206 and UN R11 [g].
const STATIC_G: f64 = 30.0;

/// Returns the chart as a file of its own.
pub(crate) fn stand_alone(figure: &Figure) -> String {
    figure.stand_alone_with(RULES)
}

/// Draws the chart.
pub(crate) fn figure(document: &SpectrumDocument) -> Figure {
    let strokes_mm: Vec<f64> = document
        .stroke_m
        .iter()
        .map(|stroke| stroke * 1e3)
        .collect();
    let along = |values: &[Option<f64>]| -> Vec<Point> {
        let pairs = strokes_mm.iter().zip(values);
        let point = |(mm, value): (&f64, &Option<f64>)| {
            Point::new(
                *mm,
                value.map_or(f64::NAN, |value| value / STANDARD_GRAVITY),
            )
        };
        pairs.map(point).collect()
    };
    let (x, y) = scales(document);
    let Scale::Logarithmic(lowest, _) = y else {
        unreachable!("both scales are logarithmic")
    };
    let count = document.recordings.len();
    let with_zone = count <= WITH_ZONE;
    let several = count > 1;
    let curves = document.spectrum_m_s2.iter().enumerate();
    let recorded = document.recordings.iter().filter(|curve| !is_pulse(curve));
    let recorded = recorded.count();
    let class = |index: usize| {
        if recorded > 0 && is_pulse(&document.recordings[index]) {
            return PULSE;
        }
        let few = recorded.max(1) <= CURVES.len() && (recorded > 0 || count <= CURVES.len());
        let before = document.recordings[..index].iter();
        let number = before
            .filter(|curve| recorded == 0 || !is_pulse(curve))
            .count();
        CURVES.get(number).copied().filter(|_| few).unwrap_or(MANY)
    };
    let zones = curves.clone().take(if with_zone { WITH_ZONE } else { 0 });
    let zones = zones.map(|(index, spectrum)| {
        let lower = document.zone_from_m_s2[index].iter().zip(spectrum);
        // A zone that reaches below the lowest window is drawn down to the edge.
        let lower = lower.map(|(from, spectrum)| spectrum.map(|_| from.unwrap_or(0.0)));
        let lower: Vec<Option<f64>> = lower.collect();
        let drawn = |point: &Point| point.y.is_finite();
        let upper = along(spectrum).into_iter().filter(drawn);
        let below = along(&lower).into_iter().filter(drawn).rev();
        let below = below.map(|point| Point::new(point.x, point.y.max(lowest)));
        (index, upper.chain(below).collect::<Vec<_>>())
    });
    let pushes = (0..count.min(if with_zone { WITH_ZONE } else { 0 })).map(|index| {
        let values = &document.single_push_m_s2[index];
        let positive = values
            .iter()
            .map(|value| Some(*value).filter(|value| *value > 0.0));
        (index, along(&positive.collect::<Vec<_>>()))
    });
    let panel = Panel::new(&WIDE, EDGES, 520.0)
        .x("stroke s* = φ* I0/(m L) [mm]", x)
        .y("lift-off a* = T0/(m L) [g]", y)
        .each(zones.collect::<Vec<_>>(), |panel, (index, outline)| {
            panel.lines(ZONES[index], outline)
        })
        .level("edge", STATIC_G)
        .text(
            "muted halo",
            (High(-8.0), Value(STATIC_G, -6.0)),
            "30 g, static requirement",
        )
        .each(pushes.collect::<Vec<_>>(), |panel, (index, points)| {
            panel.lines(PUSHES[index], points)
        })
        .each(curves, |panel, (index, spectrum)| {
            panel.lines(class(index), along(spectrum))
        })
        .each(several.then_some(()), |panel, ()| {
            panel.lines("envelope", along(&document.envelope_m_s2))
        })
        .each(&document.share_m_s2, |panel, values| {
            panel.lines("share", along(values))
        })
        .each(&document.designs, design);
    let panel = panel.text(
        "muted halo",
        (Low(10.0), Low(-12.0)),
        "above a curve: stays · in its zone: small things decide · below: opens",
    );
    Chart {
        name: "spectrum",
        title: match count {
            1 => "Latch response spectrum".into(),
            _ => "Latch response spectra".into(),
        },
        notes: subtitle(document).into(),
        legend: legend(document, class),
        panels: vec![panel],
        room: [10.0, 0.0, 58.0],
        origin: format!(
            "report {}",
            document.report_id.chars().take(12).collect::<String>()
        ),
        caption: caption(document),
        description: description(document),
    }
    .draw()
}

/// Adds a design: its point, and how far three standard deviations of its tolerances reach.
fn design(panel: Panel, design: &DesignPoint) -> Panel {
    let (low_mm, high_mm) = design.stroke_span_m;
    let (low, high) = design.liftoff_span_m_s2;
    let place = |mm: f64, a_m_s2: f64| {
        let (x, y) = (mm * 1e3, a_m_s2 / STANDARD_GRAVITY);
        (Value(x, 0.0), Value(y, 0.0))
    };
    let (mm, g) = (
        design.stroke_m * 1e3,
        design.liftoff_m_s2 / STANDARD_GRAVITY,
    );
    panel
        .patch("cloud", place(low_mm, low), place(high_mm, high))
        .marks("design", Shape::Diamond(6.0), [Point::new(mm, g)])
        .beside(
            "strong halo",
            (Value(mm, 0.0), Value(g, 5.0)),
            escape::terminal(&design.name).into_owned(),
        )
}

/// Returns scales that show every curve and design.
fn scales(document: &SpectrumDocument) -> (Scale, Scale) {
    let ends = |pair: (f64, f64)| [pair.0, pair.1];
    let designs = document.designs.iter();
    let strokes = document.stroke_m.iter().copied();
    let strokes = strokes.chain(
        designs
            .clone()
            .flat_map(|design| ends(design.stroke_span_m)),
    );
    let x = strokes.fold(Range::EMPTY, |range, stroke| range.including(stroke * 1e3));
    let spectra = document.spectrum_m_s2.iter().flatten();
    let zones = document.zone_from_m_s2.iter().flatten();
    let values = spectra.chain(zones).filter_map(|value| *value);
    let values = values.chain(designs.flat_map(|design| ends(design.liftoff_span_m_s2)));
    let y = values.fold(Range::EMPTY.including(STATIC_G), |range, value| {
        range.including(value / STANDARD_GRAVITY)
    });
    (
        Scale::Logarithmic(x.low, x.high),
        Scale::Logarithmic(y.low / 1.4, y.high * 1.5),
    )
}

fn legend(document: &SpectrumDocument, class: impl Fn(usize) -> &'static str) -> Vec<LegendEntry> {
    let count = document.recordings.len();
    let names = short_names(document).into_iter().enumerate();
    let told = names.filter(|(index, _)| class(*index) != MANY);
    let mut legend: Vec<LegendEntry> = told
        .map(|(index, name)| LegendEntry::line(class(index), name))
        .collect();
    let many = (0..count).filter(|index| class(*index) == MANY).count();
    if many > 0 {
        legend.push(LegendEntry::line(MANY, format!("{many} curves")));
    }
    if count > 1 {
        legend.push(LegendEntry::line("envelope", "envelope"));
    }
    if let Some(share) = document.request.share {
        let text = format!("covers {} % of the curves", significant(share * 100.0, 4));
        legend.push(LegendEntry::line("share", text));
    }
    if count <= WITH_ZONE {
        legend.push(LegendEntry::new(Sample::Patch(ZONES[0]), "zone"));
        legend.push(LegendEntry::line(PUSHES[0], "one push, without bounces"));
    }
    legend
}

fn caption(document: &SpectrumDocument) -> String {
    let zone = match document.recordings.len() {
        0..=WITH_ZONE => {
            " Within the zone a lever stays or opens by small things. The dotted line is what one push from rest asks for: it leaves out bounces and bounds nothing."
        }
        _ => " The zone of each curve stands in the table.",
    };
    format!(
        "A latch whose lift-off at its stroke lies above the curve stays shut under the recording: of {} levers in the window at most {} opens.{zone} The curve describes and passes nothing; a verdict comes from a replay.",
        document.settings.levers, document.settings.opening_allowed
    )
}

fn description(document: &SpectrumDocument) -> String {
    let mut text =
        String::from("Log-log chart of lift-off in g over stroke in mm, from 1 to 200 mm.");
    let names = short_names(document);
    for (name, spectrum) in names.iter().zip(&document.spectrum_m_s2) {
        let at = |wanted_mm: f64| {
            let near = |stroke: &f64| (stroke * 1e3 - wanted_mm).abs() < 1e-6;
            let place = document.stroke_m.iter().position(near)?;
            spectrum[place].map(|value| significant(value / STANDARD_GRAVITY, 3))
        };
        let values = [1.0, 10.0, 100.0].map(|mm| {
            let value = at(mm).unwrap_or_else(|| "none".into());
            format!("{value} at {mm} mm")
        });
        text.push_str(&format!(" {name}: {}.", values.join(", ")));
    }
    text
}
