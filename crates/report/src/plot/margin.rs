//! Charts of margins: the limit under half-sine pulses, the peak over each quantity.

use super::Figure;
use super::chart::At::{High, Low, Value};
use super::chart::{ACROSS, Chart, Edges, HALVES, Panel, Point, Shape};
use super::frame::{LegendEntry, OPEN, Scale, StopClasses, WIDE};
use crate::words;
use latchgate_document::MarginDocument;
use latchgate_document::number::{significant, trimmed};
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::range::Range;
use latchgate_verdict::margin::{LimitCurve, LimitPoint, Margins, Quantity, Scan};
use std::f64::consts::FRAC_PI_2;

/// Rules of these charts beyond those of all plots.
pub(crate) const RULES: &str = include_str!("margin.css");

/// Returns a chart as a file of its own.
pub(crate) fn stand_alone(figure: &Figure) -> String {
    figure.stand_alone_with(RULES)
}

/// Draws the charts that have data: limit, peaks.
pub(crate) fn figures(document: &MarginDocument, margins: &Margins) -> Vec<Figure> {
    let charts = margins.limit.iter().map(limit);
    charts
        .chain([scans(document, margins)])
        .map(Chart::draw)
        .collect()
}

/// Durations that are named on the curve [ms].
const NAMED_MS: [f64; 7] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0];

fn limit(limit: &LimitCurve) -> Chart {
    let mut stops: Vec<StopModel> = limit.points.iter().map(|point| point.model).collect();
    stops.dedup();
    let curves = || stops.iter().map(|stop| (*stop, StopClasses::of(*stop).run));
    let points = |stop| {
        let points = limit.points.iter().filter(move |point| point.model == stop);
        points.filter_map(|point| Some((point.duration_s * 1e3, values(point)?)))
    };
    let named = stops.first().into_iter().flat_map(|stop| points(*stop));
    let named = named.filter(|(ms, _)| NAMED_MS.iter().any(|named| (ms - named).abs() < 1e-9));
    let recorded = limit.recording.iter();
    let recorded = recorded.filter(|point| point.velocity_change_m_s > 0.0 && point.peak_g > 0.0);
    let (static_g, impulse) = (limit.static_threshold_g, limit.impulse_threshold_m_s);
    let (x, y) = limit_scales(limit);
    let panel = Panel::new(&WIDE, ACROSS, 436.0)
        .x("change of velocity [m/s]", x)
        .y("peak acceleration [g]", y)
        .level("edge", static_g)
        .upright("edge", impulse)
        .each(curves(), |panel, (stop, class)| {
            panel.lines(class, points(stop).map(|(_, point)| point))
        })
        .each(named, |panel, (ms, point)| {
            let text = format!("{} ms", trimmed(ms, 3));
            panel.marks("mark", Shape::Circle(3.6), [point]).text(
                "muted halo",
                (Value(point.x, 9.0), Value(point.y, -5.0)),
                text,
            )
        })
        .text(
            "muted halo",
            (High(-8.0), Value(static_g, -7.0)),
            format!("T0/(mL) = {} g", significant(static_g, 4)),
        )
        .text(
            "muted halo",
            (Value(impulse, 7.0), Low(-10.0)),
            format!("{} m/s", significant(impulse, 4)),
        )
        // Both texts stand where neither curve nor bounds pass.
        .text(
            "muted halo",
            (High(-8.0), Value(static_g, -27.0)),
            "above the curve: beyond the limit",
        )
        .text(
            "muted halo",
            (High(-8.0), Low(-10.0)),
            "below: stays within it",
        )
        .each(recorded, |panel, point| {
            let (x, y) = (point.velocity_change_m_s, point.peak_g);
            let text = match limit.recording.len() {
                1 => "recording".to_string(),
                _ => format!("recording, {}", words::opens(point.opens_when)),
            };
            panel
                .marks("cross", Shape::Diamond(7.0), [Point::new(x, y)])
                .beside("strong halo", (Value(x, 0.0), Value(y, 5.0)), text)
        });
    let entries =
        curves().map(|(stop, class)| LegendEntry::line(class, format!("limit, {}", stop.label())));
    let bounds = LegendEntry::line("edge", "bounds of very long and very short pulses");
    Chart {
        name: "margin-limit",
        title: "Half-sine pulses that just reach the limit".into(),
        legend: entries.chain([bounds]).collect(),
        panels: vec![panel],
        room: [8.0, 0.0, 56.0],
        caption: "Pulses above and to the right of the curve bring the lever beyond the limit, from rest, while they last or after. The recording is placed by its largest acceleration and its largest change of velocity in the opening direction; no half-sine, it is judged by its replay and not by its place here.".into(),
        description: description(limit),
        ..Chart::default()
    }
}

/// Returns change of velocity [m/s] and amplitude [g] of a point, if it has both.
fn values(point: &LimitPoint) -> Option<Point> {
    Some(Point::new(point.velocity_change_m_s?, point.amplitude_g?))
}

/// Returns scales that show the curve, its bounds and the recording.
fn limit_scales(limit: &LimitCurve) -> (Scale, Scale) {
    let mut x = Range::EMPTY.including(limit.impulse_threshold_m_s);
    let mut y = Range::EMPTY.including(limit.static_threshold_g);
    let recorded = limit
        .recording
        .iter()
        .map(|point| Point::new(point.velocity_change_m_s, point.peak_g));
    for point in limit.points.iter().filter_map(values).chain(recorded) {
        if point.x > 0.0 && point.y > 0.0 {
            (x, y) = (x.including(point.x), y.including(point.y));
        }
    }
    let wider = |Range { low, high }: Range| {
        let low = if low > 0.0 { low / 1.5 } else { high / 1e3 };
        Scale::Logarithmic(low, high * 1.6)
    };
    (wider(x), wider(y))
}

fn description(limit: &LimitCurve) -> String {
    let mut text = format!(
        "Log-log chart of peak acceleration in g over change of velocity in m/s; bounds {} g and {} m/s.",
        significant(limit.static_threshold_g, 5),
        significant(limit.impulse_threshold_m_s, 4)
    );
    for point in &limit.recording {
        text.push_str(&format!(
            " The recording, {}: {} g and {} m/s.",
            words::opens(point.opens_when),
            significant(point.peak_g, 4),
            significant(point.velocity_change_m_s, 4)
        ));
    }
    text
}

fn scans(document: &MarginDocument, margins: &Margins) -> Chart {
    // Unbalance and arm enter as the scale does and would give the same picture.
    let scans = margins.scans.iter();
    let scans = scans.filter(|scan| !matches!(scan.quantity, Quantity::Unbalance | Quantity::Arm));
    let scans = scans.zip(HALVES.into_iter().cycle());
    Chart {
        name: "margin-scan",
        title: "Peak angle over each quantity".into(),
        legend: vec![
            LegendEntry::line("used", "largest peak of the nominal runs that count"),
            LegendEntry::line("limit", "limit angle"),
            LegendEntry::line("edge", "present"),
        ],
        panels: scans
            .map(|(scan, edges)| scan_panel(document, scan, edges))
            .collect(),
        room: [26.0, 88.0, 66.0],
        caption: "Each quantity is varied alone. Circles mark every change of the nominal runs between pass and no pass; angles below a hundredth of the limit or beyond 90° are drawn at the edge.".into(),
        description: format!(
            "Peak angle over scale of the recording, preload, spring stiffness, counterweight, restitution and limit angle, against the limit of {} rad.",
            document.threshold_rad
        ),
        ..Chart::default()
    }
}

fn scan_panel(document: &MarginDocument, scan: &Scan, edges: Edges) -> Panel {
    let limit = document.threshold_rad;
    let (low, high) = match (scan.points.first(), scan.points.last()) {
        (Some(first), Some(last)) => (first.0, last.0),
        _ => (0.0, 1.0),
    };
    let x = if scan.quantity.is_ratio() && low > 0.0 {
        Scale::Logarithmic(low, high)
    } else {
        Scale::Linear(low, high)
    };
    let unit = match scan.quantity.unit() {
        "" => "–",
        unit => unit,
    };
    let (least, largest) = (limit / 100.0, (2.0 * limit).max(FRAC_PI_2));
    let limit_at = |value: f64| match scan.quantity {
        Quantity::LimitAngle => value.clamp(least, largest),
        _ => limit,
    };
    let peaks = scan.points.iter().map(|(value, peak)| {
        let peak = peak.map_or(f64::NAN, |peak| peak.clamp(least, largest));
        Point::new(*value, peak)
    });
    let limits = scan
        .points
        .iter()
        .map(|(value, _)| Point::new(*value, limit_at(*value)));
    let boundaries = document.boundaries.iter().filter(|boundary| {
        let answers = [boundary.below, boundary.above];
        boundary.quantity == scan.quantity.name()
            && answers[0] != answers[1]
            && answers.contains(&latchgate_verdict::margin::NominalAnswer::Pass)
    });
    let boundaries = boundaries.map(|boundary| Point::new(boundary.at, limit_at(boundary.at)));
    Panel::new(&OPEN, edges, 230.0)
        .x(format!("{} [{unit}]", scan.quantity.title()), x)
        .y("peak angle [rad]", Scale::Logarithmic(least, largest))
        .upright("edge", scan.present)
        .lines("used", peaks)
        .lines("limit", limits)
        .marks("mark", Shape::Circle(4.2), boundaries)
}
