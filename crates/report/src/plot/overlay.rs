//! Verdicts over one time axis, aligned at first contact.

use super::event::{EventCurve, EventDrawing, EventMark, EventPanel, limit_name, with_room};
use super::{Figure, time_unit};
use crate::comparison::{VERDICTS_MAX, letter};
use crate::{series, words};
use latchgate_document::Document;
use latchgate_kernel::range::{Range, Window};
use latchgate_kernel::units::STANDARD_GRAVITY;
use latchgate_verdict::SampledSeries;
use serde_json::Value;

/// Rules of this drawing beyond those of all plots: neither of two verdicts has the colour of a stop.
pub(crate) const RULES: &str = include_str!("overlay.css");

const CLASSES: [&str; VERDICTS_MAX] = [
    "verdict-a",
    "verdict-b",
    "verdict-c",
    "verdict-d",
    "verdict-e",
    "verdict-f",
    "verdict-g",
    "verdict-h",
];

/// The series of verdicts at common instants.
#[derive(Debug)]
pub(crate) struct CommonSeries {
    time_s: Vec<f64>,
    used_m_s2: Vec<Vec<f64>>,
    velocity_m_s: Vec<Vec<f64>>,
    angle_rad: Vec<Vec<f64>>,
}

impl CommonSeries {
    /// Interpolates all series linearly at the instants of each, within the time that all cover.
    /// `None` if they have no two instants in common.
    pub(crate) fn of(tables: &[SampledSeries]) -> Option<Self> {
        let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
        for table in tables {
            table.runs.first()?;
            (from, to) = (
                from.max(*table.time_s.first()?),
                to.min(*table.time_s.last()?),
            );
        }
        let instants = tables.iter().flat_map(|table| &table.time_s);
        let mut time_s: Vec<f64> = instants
            .copied()
            .filter(|time| (from..=to).contains(time))
            .collect();
        time_s.sort_unstable_by(f64::total_cmp);
        time_s.dedup();
        if time_s.len() < 2 {
            return None;
        }
        let each = |values: fn(&SampledSeries) -> &[f64]| {
            let each = tables.iter();
            each.map(|table| interpolated(&time_s, &table.time_s, values(table)))
                .collect()
        };
        Some(Self {
            used_m_s2: each(|table| &table.used_m_s2),
            velocity_m_s: each(|table| &table.velocity_m_s),
            angle_rad: each(|table| &series::ordered(table)[0].angle_rad),
            time_s,
        })
    }

    /// Returns the series as a table.
    pub(crate) fn csv(&self) -> String {
        use std::fmt::Write as _;
        let mut out = String::from("time_s");
        for what in ["acceleration_used_m_s2", "velocity_m_s", "angle_rad"] {
            for place in 0..self.angle_rad.len() {
                let _ = write!(out, ",{}_{what}", letter(place).to_ascii_lowercase());
            }
        }
        out.push('\n');
        for (index, time) in self.time_s.iter().enumerate() {
            let _ = write!(out, "{time}");
            for values in [&self.used_m_s2, &self.velocity_m_s, &self.angle_rad] {
                for column in values {
                    // Writing into a String cannot fail.
                    let _ = write!(out, ",{}", column[index]);
                }
            }
            out.push('\n');
        }
        out
    }
}

/// Returns values at the instants `to_s`, which lie within `time_s`.
fn interpolated(to_s: &[f64], time_s: &[f64], values: &[f64]) -> Vec<f64> {
    let mut next = 1;
    to_s.iter()
        .map(|&instant| {
            while next + 1 < time_s.len() && time_s[next] < instant {
                next += 1;
            }
            let (t0, t1) = (time_s[next - 1], time_s[next]);
            let part = (instant - t0) / (t1 - t0);
            values[next - 1] + part * (values[next] - values[next - 1])
        })
        .collect()
}

/// Draws the figure, and returns with it the data from which a script redraws it. `view` is the window
/// shown at first.
pub(crate) fn draw(
    series: &CommonSeries,
    documents: &[&Document],
    view: Window,
) -> (Figure, Value) {
    let shown = (&*series.time_s, view);
    let in_g = 1.0 / STANDARD_GRAVITY;
    let limits = documents.iter().map(|document| document.threshold_rad);
    let limit = limits.clone().fold(0.0, f64::max);
    let names: Vec<String> = documents
        .iter()
        .map(|document| words::report_name(document))
        .collect();
    let verdicts = documents.len();
    let drawing = EventDrawing {
        title: "Acceleration, velocity and angle of the levers",
        time_s: &series.time_s,
        view,
        panels: [
            EventPanel::new(
                "a [g]".into(),
                curves("acceleration", 1, &series.used_m_s2),
                in_g,
                shown,
                None,
            ),
            EventPanel::new(
                "v [m/s]".into(),
                curves("velocity", 1 + verdicts, &series.velocity_m_s),
                1.0,
                shown,
                None,
            ),
            EventPanel::new(
                "angle φ [rad]".into(),
                curves("angle", 1 + 2 * verdicts, &series.angle_rad),
                1.0,
                shown,
                Some(limit),
            ),
        ],
        limit: (limit, limit_name(limit)),
        marks: marks(documents, view),
        bar: None,
        time_unit: time_unit(view),
        origin: &format!("reports {}", names.join(", ")),
    };
    let apart = limits.clone().any(|own| (own - limit).abs() > 0.0);
    let caption = format!(
        "All as used, aligned at t = 0, where all have samples.{}",
        if apart {
            " The limit angles differ; the largest is drawn."
        } else {
            ""
        }
    );
    let description = format!(
        "Acceleration, its integral and the angle of the lever over time for each verdict, from {} to {}.",
        words::instant(view.from_s),
        words::instant(view.until_s)
    );
    drawing.draw(caption, description)
}

/// Returns the curves of all verdicts, which begin in column `first` of the table.
fn curves<'a>(what: &str, first: usize, values: &'a [Vec<f64>]) -> Vec<EventCurve<'a>> {
    let each = values.iter().zip(CLASSES).enumerate();
    let each = each.map(|(place, (values, class))| EventCurve {
        class,
        name: format!("{what} {}", letter(place)),
        read: letter(place).to_string(),
        column: first + place,
        values,
    });
    each.collect()
}

fn marks(documents: &[&Document], view: Window) -> Vec<EventMark> {
    let mut marks = vec![EventMark::at(0.0, "t = 0".into(), "contact")];
    for (place, document) in documents.iter().enumerate() {
        let name = format!("{} ", letter(place));
        marks.extend(EventMark::opening(document, &name));
    }
    marks.retain(|mark| mark.in_view(view).is_some());
    marks
}

/// Returns the window in which any pulse acts or any lever moves, with some room.
pub(crate) fn view(series: &CommonSeries, documents: &[&Document]) -> Window {
    let (first, last) = (series.time_s[0], series.time_s[series.time_s.len() - 1]);
    let mut span = Range::EMPTY.including(0.0_f64.clamp(first, last));
    let mut include = |at: f64| span = span.including(at);
    for values in &series.used_m_s2 {
        let largest = values
            .iter()
            .fold(0.0_f64, |largest, value| largest.max(value.abs()));
        let at_work = values.iter().map(|value| value.abs() > 0.05 * largest);
        for (time, _) in series.time_s.iter().zip(at_work).filter(|(_, is)| *is) {
            include(*time);
        }
    }
    for run in documents
        .iter()
        .filter_map(|document| document.nominal.as_ref())
    {
        include(run.peak_time_s.clamp(first, last));
    }
    for opens in documents.iter().filter_map(|document| document.opens) {
        let instants = [opens.first_s, opens.p05_s, opens.p95_s];
        let instants = instants.into_iter().flatten();
        instants.for_each(|instant_s| include(instant_s.clamp(first, last)));
    }
    with_room(span, Window::new(first, last))
}
