//! Charts of margins: the limit under half-sine pulses, the peak over each quantity, the map.

use super::canvas::{Anchor, Canvas};
use super::frame::{Frame, LEFT, LegendEntry, RIGHT, Scale, header};
use super::{Figure, WIDTH, heat};
use crate::words;
use latchgate_document::MarginDocument;
use latchgate_document::number::{significant, trimmed};
use latchgate_kernel::model::stop::StopModel;
use latchgate_verdict::margin::search::followed_to_rad;
use latchgate_verdict::margin::{LimitCurve, LimitPoint, Map, Margins, Quantity, Scan};

/// Rules of these charts beyond those of all plots.
pub(crate) const RULES: &str = "\
.plot .ground{fill:none;stroke:var(--paper);stroke-width:5;stroke-linecap:round}
.plot .boundary{fill:none;stroke:var(--ink);stroke-width:2;stroke-linecap:round}
";

/// Returns a chart as a file of its own.
pub(crate) fn stand_alone(figure: &Figure) -> String {
    figure.stand_alone_with(RULES)
}

/// Draws every chart that there is data for: limit, peaks, map.
pub(crate) fn figures(document: &MarginDocument, margins: &Margins) -> Vec<Figure> {
    let mut figures = Vec::new();
    figures.extend(margins.limit.as_ref().map(limit));
    figures.push(scans(document, margins));
    figures.extend(margins.map.as_ref().and_then(|map| draw_map(document, map)));
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
    let level = followed_to_rad(document.threshold_rad);
    let mut of_peak = String::from("largest peak of the runs that count");
    let mut peaks = margins.scans.iter().flat_map(|scan| &scan.points);
    if peaks.any(|(_, peak)| peak.is_some_and(|peak| peak >= level)) {
        of_peak.push_str(&format!(
            "; above {} rad: at least that",
            significant(level, 2)
        ));
    }
    let entries = [
        LegendEntry::line("used", of_peak),
        LegendEntry::line("limit", "limit"),
        LegendEntry::line("edge", "present"),
    ];
    let top = header(&mut canvas, LEFT, title, &[], &entries);
    // The unbalance enters as the scale does and would give the same picture.
    let shown: Vec<&Scan> = margins
        .scans
        .iter()
        .filter(|scan| scan.quantity != Quantity::Unbalance)
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
        caption: "Each quantity is varied alone. Circles mark every change between pass and no pass; angles below a hundredth or above a hundred times the limit are drawn at the edge.".into(),
        description: format!(
            "Peak angle over scale of the recording, preload, counterweight and restitution, against the limit of {} rad.",
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
    let x = if scan.ratios {
        Scale::Logarithmic(low, high)
    } else {
        Scale::Linear(low, high)
    };
    let panel = Frame::open(
        (left, left + PANEL_WIDTH, top, top + PANEL_HEIGHT),
        x,
        Scale::Logarithmic(limit / 100.0, limit * 100.0),
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
    panel.level(canvas, "limit", limit);
    for boundary in &document.boundaries {
        let of_pass = boundary.below != boundary.above
            && [boundary.below, boundary.above]
                .contains(&latchgate_verdict::margin::NominalAnswer::Pass);
        if boundary.quantity == scan.quantity.name() && of_pass {
            canvas.circle("mark", panel.place(boundary.at, limit), 4.2);
        }
    }
    panel.frame(canvas);
}

fn draw_map(document: &MarginDocument, map: &Map) -> Option<Figure> {
    let height = 600.0;
    let mut canvas = Canvas::with_capacity(64 * 1024);
    let title = "Peak angle over two design keys";
    let request = &map.request;
    let inside = map.present.is_some_and(|(x, y)| {
        (request.x.low..=request.x.high).contains(&x)
            && (request.y.low..=request.y.high).contains(&y)
    });
    let legend = if inside {
        "boundary of the pass; the circle is the present design"
    } else {
        "boundary of the pass; the present design lies outside the map"
    };
    let entries = [LegendEntry::line("boundary", legend)];
    let top = header(&mut canvas, LEFT, title, &[], &entries);
    let (columns, rows) = (request.columns, request.rows);
    let panel = Frame::wide(
        (top + 14.0, height - 58.0),
        Scale::Linear(request.x.low, request.x.high),
        Scale::Linear(request.y.low, request.y.high),
    );
    let limit = document.threshold_rad;
    let range = peak_range(map, limit);
    panel.grid(&mut canvas, Some(&request.x.key), Some(&request.y.key));
    panel.begin_inside(&mut canvas, "margin-map-clip");
    peaks(&mut canvas, &panel, map, range)?;
    for class in ["ground", "boundary"] {
        for (from, to) in &map.segments {
            let place = |index: &usize| {
                let vertex = &map.vertices[*index];
                panel.place(vertex.x, vertex.y)
            };
            canvas.line(class, place(from), place(to));
        }
    }
    canvas.end_group();
    if let Some((x, y)) = map.present
        && inside
    {
        canvas.circle("mark", panel.place(x, y), 6.0);
    }
    panel.frame(&mut canvas);
    let bar = (RIGHT + 10.0, panel.top, panel.bottom);
    let scale = Scale::Logarithmic(range.0, range.1);
    let axis = heat::colour_bar(&mut canvas, bar, scale, |tick| tick.label.clone())?;
    let y = axis.place(limit);
    canvas.line("limit", (RIGHT + 4.0, y), (RIGHT + 28.0, y));
    let unit = (WIDTH - 4.0, panel.top - 10.0);
    canvas.text("", unit, Anchor::End, "peak [rad]");
    Some(Figure {
        name: "margin-map",
        title: title.into(),
        caption: format!(
            "Largest angle of the stops and polarities that count, on {columns} × {rows} designs; on the line it meets the limit of {limit} rad, as found by further runs between them, and on its darker side nominal runs pass, no error counted. Grey: no lever can have both values."
        ),
        description: format!(
            "Peak angle over {} and {}; {} of {} designs pass, {} points on the boundary.",
            request.x.key, request.y.key, map.passing, map.judged, map.boundary_points
        ),
        height,
        body: canvas.into_string(),
    })
}

/// Returns the ends of the colours [rad], at most a hundredth and a hundred times the limit.
fn peak_range(map: &Map, limit: f64) -> (f64, f64) {
    let known = map.peaks_rad.iter().flatten().copied();
    let positive = known.clone().filter(|peak| *peak > 0.0);
    let low = positive.fold(limit, f64::min).max(limit / 100.0);
    let high = known.fold(limit, f64::max).min(limit * 100.0);
    if low < high {
        (low, high)
    } else {
        (limit / 2.0, limit * 2.0)
    }
}

/// Draws the peak of every design: a cell is as wide as the grid's step, with the grid value in its
/// middle.
fn peaks(canvas: &mut Canvas, panel: &Frame, map: &Map, (low, high): (f64, f64)) -> Option<()> {
    let request = &map.request;
    let (columns, rows) = (request.columns, request.rows);
    let share = |peak: f64| {
        (libm::log(peak.clamp(low, high)) - libm::log(low)) / (libm::log(high) - libm::log(low))
    };
    let half = (
        0.5 * (request.x.high - request.x.low) / (columns - 1) as f64,
        0.5 * (request.y.high - request.y.low) / (rows - 1) as f64,
    );
    let corner = panel.place(request.x.low - half.0, request.y.high + half.1);
    let opposite = panel.place(request.x.high + half.0, request.y.low - half.1);
    let cells = heat::cells((columns, rows), |column, row| {
        map.peaks_rad[row * columns + column].map(share)
    })?;
    canvas.png(
        &cells,
        corner,
        (opposite.0 - corner.0, opposite.1 - corner.1),
    );
    Some(())
}
