//! Charts of margins: the limit under half-sine pulses, the peak over each quantity.

use super::Figure;
use super::canvas::{Anchor, Canvas};
use super::frame::{Frame, LEFT, LegendEntry, RIGHT, Scale, header};
use crate::words;
use latchgate_document::MarginDocument;
use latchgate_document::number::{significant, trimmed};
use latchgate_kernel::model::stop::StopModel;
use latchgate_verdict::margin::{LimitCurve, LimitPoint, Margins, Quantity, Scan};
use std::f64::consts::FRAC_PI_2;

/// Rules of these charts beyond those of all plots.
pub(crate) const RULES: &str = include_str!("margin.css");

/// Returns a chart as a file of its own.
pub(crate) fn stand_alone(figure: &Figure) -> String {
    figure.stand_alone_with(RULES)
}

/// Draws every chart that there is data for: limit, peaks.
pub(crate) fn figures(document: &MarginDocument, margins: &Margins) -> Vec<Figure> {
    let mut figures = Vec::new();
    figures.extend(margins.limit.as_ref().map(limit));
    figures.push(scans(document, margins));
    figures
}

/// Durations that are named on the curve [ms].
const NAMED_MS: [f64; 7] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0];

/// Classes of the curves of limits, by stop.
const CLASSES: [&str; 2] = ["run-rigid", "run-soft"];

fn limit(limit: &LimitCurve) -> Figure {
    let height = 560.0;
    let mut canvas = Canvas::with_capacity(32 * 1024);
    let mut stops: Vec<StopModel> = Vec::new();
    for point in &limit.points {
        if !stops.contains(&point.model) {
            stops.push(point.model);
        }
    }
    let mut entries: Vec<LegendEntry> = stops
        .iter()
        .zip(CLASSES)
        .map(|(stop, class)| LegendEntry::line(class, format!("limit, {}", words::stop(*stop))))
        .collect();
    entries.push(LegendEntry::line(
        "edge",
        "bounds of very long and very short pulses",
    ));
    let title = "Half-sine pulses that just reach the limit";
    let top = header(&mut canvas, LEFT, title, &[], &entries);
    let (x, y) = limit_scales(limit);
    let panel = Frame::wide((top + 8.0, height - 56.0), x, y);
    panel.grid(
        &mut canvas,
        Some("change of velocity [m/s]"),
        Some("peak acceleration [g]"),
    );
    limit_curves(&mut canvas, &panel, limit, &stops);
    limit_words(&mut canvas, &panel, limit);
    for point in &limit.recording {
        if !(point.velocity_change_m_s > 0.0 && point.peak_g > 0.0) {
            continue;
        }
        let at = panel.place(point.velocity_change_m_s, point.peak_g);
        canvas.diamond("cross", at, 7.0);
        let text = if limit.recording.len() == 1 {
            "recording".to_string()
        } else {
            format!("recording, {}", words::opens(point.opens_when))
        };
        panel.label(&mut canvas, "strong halo", (at.0, at.1 + 5.0), &text);
    }
    panel.frame(&mut canvas);
    Figure {
        name: "margin-limit",
        title: title.into(),
        caption: "Pulses above and to the right of the curve bring the lever beyond the limit, from rest, while they last or after. The recording is placed by its largest acceleration and its largest change of velocity in the opening direction; no half-sine, it is judged by its replay and not by its place here.".into(),
        description: description(limit),
        height,
        body: canvas.into_string(),
    }
}

/// Returns change of velocity [m/s] and amplitude [g] of a point, where both are known.
fn known(point: &LimitPoint) -> Option<(f64, f64)> {
    Some((point.velocity_change_m_s?, point.amplitude_g?))
}

/// Returns scales that show the curve, its bounds and the recording.
fn limit_scales(limit: &LimitCurve) -> (Scale, Scale) {
    let mut x = (limit.impulse_threshold_m_s, limit.impulse_threshold_m_s);
    let mut y = (limit.static_threshold_g, limit.static_threshold_g);
    let recorded = limit
        .recording
        .iter()
        .map(|point| (point.velocity_change_m_s, point.peak_g));
    for (change, amplitude) in limit.points.iter().filter_map(known).chain(recorded) {
        if change > 0.0 && amplitude > 0.0 {
            x = (x.0.min(change), x.1.max(change));
            y = (y.0.min(amplitude), y.1.max(amplitude));
        }
    }
    let wider = |(low, high): (f64, f64)| {
        let low = if low > 0.0 { low / 1.5 } else { high / 1e3 };
        Scale::Logarithmic(low, high * 1.6)
    };
    (wider(x), wider(y))
}

/// Draws the bounds, the curve of each stop, and the durations along the first.
fn limit_curves(canvas: &mut Canvas, panel: &Frame, limit: &LimitCurve, stops: &[StopModel]) {
    let of = |stop: StopModel| limit.points.iter().filter(move |point| point.model == stop);
    panel.begin_inside(canvas, "margin-limit-clip");
    panel.level(canvas, "edge", limit.static_threshold_g);
    panel.upright(canvas, "edge", limit.impulse_threshold_m_s);
    for (stop, class) in stops.iter().zip(CLASSES) {
        let points = of(*stop).filter_map(known);
        canvas.polyline(class, points.map(|(x, y)| panel.place(x, y)));
    }
    canvas.end_group();
    for point in stops.first().into_iter().flat_map(|stop| of(*stop)) {
        let named = NAMED_MS
            .iter()
            .any(|named| (point.duration_s * 1e3 - named).abs() < 1e-9);
        if let (true, Some((change, amplitude))) = (named, known(point)) {
            let at = panel.place(change, amplitude);
            canvas.circle("mark", at, 3.6);
            let text = format!("{} ms", trimmed(point.duration_s * 1e3, 3));
            let beside = (at.0 + 9.0, at.1 - 5.0);
            canvas.text("muted halo", beside, Anchor::Start, &text);
        }
    }
}

/// Names the bounds and the two sides of the curve.
fn limit_words(canvas: &mut Canvas, panel: &Frame, limit: &LimitCurve) {
    let level = panel.y.place(limit.static_threshold_g);
    let upright = panel.x.place(limit.impulse_threshold_m_s);
    let threshold = significant(limit.static_threshold_g, 4);
    let foot = panel.bottom - 10.0;
    let mut write =
        |at: (f64, f64), anchor, text: &str| canvas.text("muted halo", at, anchor, text);
    write(
        (RIGHT - 8.0, level - 7.0),
        Anchor::End,
        &format!("T0/(mL) = {threshold} g"),
    );
    write(
        (upright + 7.0, foot),
        Anchor::Start,
        &format!("{} m/s", significant(limit.impulse_threshold_m_s, 4)),
    );
    // Beyond the curve and below it, where neither curve nor bounds are.
    write(
        (RIGHT - 8.0, level - 27.0),
        Anchor::End,
        "above the curve: beyond the limit",
    );
    write((RIGHT - 8.0, foot), Anchor::End, "below: stays within it");
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

/// Left edges and sizes of the panels of peaks.
const COLUMNS: [f64; 2] = [78.0, 530.0];
const PANEL_WIDTH: f64 = 346.0;
const PANEL_HEIGHT: f64 = 230.0;
const ROW_HEIGHT: f64 = 318.0;

fn scans(document: &MarginDocument, margins: &Margins) -> Figure {
    let title = "Peak angle over each quantity";
    let mut canvas = Canvas::with_capacity(256 * 1024);
    let entries = [
        LegendEntry::line("used", "largest peak of the nominal runs that count"),
        LegendEntry::line("limit", "limit angle"),
        LegendEntry::line("edge", "present"),
    ];
    let top = header(&mut canvas, LEFT, title, &[], &entries);
    // Unbalance and arm enter as the scale does and would give the same picture.
    let shown: Vec<&Scan> = margins
        .scans
        .iter()
        .filter(|scan| !matches!(scan.quantity, Quantity::Unbalance | Quantity::Arm))
        .collect();
    for (index, scan) in shown.iter().enumerate() {
        let corner = (
            COLUMNS[index % 2],
            top + 26.0 + (index / 2) as f64 * ROW_HEIGHT,
        );
        scan_panel(&mut canvas, document, scan, corner);
    }
    let height = top + 4.0 + shown.len().div_ceil(2) as f64 * ROW_HEIGHT;
    Figure {
        name: "margin-scan",
        title: title.into(),
        caption: "Each quantity is varied alone. Circles mark every change of the nominal runs between pass and no pass; angles below a hundredth of the limit or beyond 90° are drawn at the edge.".into(),
        description: format!(
            "Peak angle over scale of the recording, preload, spring stiffness, counterweight, restitution and limit angle, against the limit of {} rad.",
            document.threshold_rad
        ),
        height,
        body: canvas.into_string(),
    }
}

fn scan_panel(
    canvas: &mut Canvas,
    document: &MarginDocument,
    scan: &Scan,
    (left, top): (f64, f64),
) {
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
    let panel = Frame::open(
        (left, left + PANEL_WIDTH, top, top + PANEL_HEIGHT),
        x,
        Scale::Logarithmic(limit / 100.0, (2.0 * limit).max(FRAC_PI_2)),
    );
    let unit = match scan.quantity.unit() {
        "" => "–",
        unit => unit,
    };
    panel.grid(
        canvas,
        Some(&format!("{} [{unit}]", scan.quantity.title())),
        Some("peak angle [rad]"),
    );
    let y = panel.y;
    panel.upright(canvas, "edge", scan.present);
    let held = |peak: f64| y.place(peak.clamp(y.low(), y.high()));
    canvas.polyline(
        "used",
        scan.points
            .iter()
            .map(|(value, peak)| (panel.x.place(*value), peak.map_or(f64::NAN, held))),
    );
    let limit_at = |value: f64| match scan.quantity {
        Quantity::LimitAngle => value.clamp(y.low(), y.high()),
        _ => limit,
    };
    let limits = scan.points.iter();
    canvas.polyline(
        "limit",
        limits.map(|(value, _)| panel.place(*value, limit_at(*value))),
    );
    for boundary in &document.boundaries {
        let of_pass = boundary.below != boundary.above
            && [boundary.below, boundary.above]
                .contains(&latchgate_verdict::margin::NominalAnswer::Pass);
        if boundary.quantity == scan.quantity.name() && of_pass {
            canvas.circle("mark", panel.place(boundary.at, limit_at(boundary.at)), 4.2);
        }
    }
    panel.frame(canvas);
}
