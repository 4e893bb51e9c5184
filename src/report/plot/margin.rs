//! Charts of margins: the limit under half-sine pulses, the peak over each quantity, the map.

use super::axis::Axis;
use super::canvas::{Anchor, Canvas};
use super::colour::viridis;
use super::panel::{Entry, Mark};
use super::panel::{LEFT, Panel, RIGHT, header};
use super::raster::encode;
use super::{Figure, WIDTH, series};
use crate::margin::{LimitCurve, LimitPoint, Map, Margins, Quantity, Scan};
use crate::report::MarginDocument;
use crate::report::number::{significant, trimmed};
use crate::report::words;

/// Rules of these charts beyond those of all plots.
pub(in crate::report) const RULES: &str = "\
.plot .ground{fill:none;stroke:var(--paper);stroke-width:5;stroke-linecap:round}
.plot .boundary{fill:none;stroke:var(--ink);stroke-width:2;stroke-linecap:round}
";

/// Returns a chart as a file of its own.
pub(in crate::report) fn stand_alone(figure: &Figure) -> String {
    figure.stand_alone_with(RULES)
}

/// Draws every chart that there is data for: limit, peaks, map.
pub(in crate::report) fn figures(document: &MarginDocument, margins: &Margins) -> Vec<Figure> {
    let mut figures = Vec::new();
    figures.extend(margins.limit.as_ref().map(limit));
    figures.push(scans(document, margins));
    figures.extend(margins.map.as_ref().and_then(|map| draw_map(document, map)));
    figures
}

/// Durations that are named on the curve [ms].
const NAMED_MS: [f64; 7] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0];

fn limit(limit: &LimitCurve) -> Figure {
    let height = 560.0;
    let mut canvas = Canvas::with_capacity(32 * 1024);
    let mut entries = Vec::new();
    let mut stops = Vec::new();
    for point in &limit.points {
        if !stops.contains(&point.model) {
            stops.push(point.model);
        }
    }
    const CLASSES: [&str; 2] = ["trace-0", "trace-1"];
    for (stop, class) in stops.iter().zip(CLASSES) {
        entries.push(Entry::new(
            Mark::Line(class),
            format!("limit, {}", words::stop(*stop)),
        ));
    }
    entries.push(Entry::new(
        Mark::Line("edge"),
        "bounds of very long and very short pulses",
    ));
    let title = "Half-sine pulses that just reach the limit";
    let top = header(&mut canvas, title, &entries);
    let known = |point: &LimitPoint| Some((point.velocity_change_m_s?, point.amplitude_g?));
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
        if low > 0.0 {
            (low / 1.5, high * 1.6)
        } else {
            (high / 1e3, high * 1.6)
        }
    };
    let (x, y) = (wider(x), wider(y));
    let bottom = height - 56.0;
    let panel = Panel {
        top: top + 8.0,
        bottom,
        x: Axis::logarithmic(x.0, x.1, LEFT, RIGHT),
        y: Axis::logarithmic(y.0, y.1, bottom, top + 8.0),
    };
    panel.grid(
        &mut canvas,
        Some("change of velocity [m/s]"),
        "peak acceleration [g]",
    );
    panel.clip(&mut canvas, "margin-limit-clip");
    canvas.begin_clipped("margin-limit-clip");
    let level = panel.y.place(limit.static_threshold_g);
    canvas.line("edge", (LEFT, level), (RIGHT, level));
    let upright = panel.x.place(limit.impulse_threshold_m_s);
    canvas.line("edge", (upright, panel.top), (upright, panel.bottom));
    for (stop, class) in stops.iter().zip(CLASSES) {
        canvas.polyline(
            class,
            limit
                .points
                .iter()
                .filter(|point| point.model == *stop)
                .filter_map(known)
                .map(|(change, amplitude)| panel.place(change, amplitude)),
        );
    }
    canvas.end_group();
    for point in limit
        .points
        .iter()
        .filter(|point| Some(point.model) == stops.first().copied())
    {
        let named = NAMED_MS
            .iter()
            .any(|named| (point.duration_s * 1e3 - named).abs() < 1e-9);
        if let (true, Some((change, amplitude))) = (named, known(point)) {
            let at = panel.place(change, amplitude);
            canvas.circle("mark", at, 3.6);
            canvas.text(
                "muted halo",
                (at.0 + 9.0, at.1 - 5.0),
                Anchor::Start,
                &format!("{} ms", trimmed(point.duration_s * 1e3, 3)),
            );
        }
    }
    canvas.text(
        "muted halo",
        (RIGHT - 8.0, level - 7.0),
        Anchor::End,
        &format!("T0/(mL) = {} g", significant(limit.static_threshold_g, 4)),
    );
    canvas.text(
        "muted halo",
        (upright + 7.0, panel.bottom - 10.0),
        Anchor::Start,
        &format!("{} m/s", significant(limit.impulse_threshold_m_s, 4)),
    );
    for point in &limit.recording {
        if !(point.velocity_change_m_s > 0.0 && point.peak_g > 0.0) {
            continue;
        }
        let at = panel.place(point.velocity_change_m_s, point.peak_g);
        canvas.diamond("cross", at, 7.0);
        panel.label(
            &mut canvas,
            "strong halo",
            (at.0, at.1 + 5.0),
            &if limit.recording.len() == 1 {
                "recording".to_string()
            } else {
                format!("recording, {}", words::opens(point.opens_when))
            },
        );
    }
    // Beyond the curve and below it, where neither curve nor bounds are.
    canvas.text(
        "muted halo",
        (RIGHT - 8.0, level - 27.0),
        Anchor::End,
        "above the curve: beyond the limit",
    );
    canvas.text(
        "muted halo",
        (RIGHT - 8.0, panel.bottom - 10.0),
        Anchor::End,
        "below: stays within it",
    );
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
    let top = header(
        &mut canvas,
        title,
        &[
            Entry::new(Mark::Line("used"), "largest peak of the runs that count"),
            Entry::new(Mark::Line("limit"), "limit"),
            Entry::new(Mark::Line("edge"), "present"),
        ],
    );
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
    let (right, bottom) = (left + PANEL_WIDTH, top + PANEL_HEIGHT);
    let limit = document.threshold_rad;
    let (low, high) = match (scan.points.first(), scan.points.last()) {
        (Some(first), Some(last)) => (first.0, last.0),
        _ => (0.0, 1.0),
    };
    let x = if scan.ratios {
        Axis::logarithmic(low, high, left, right)
    } else {
        Axis::linear(low, high, left, right)
    };
    let y = Axis::logarithmic(limit / 100.0, limit * 100.0, bottom, top);
    series::grid(canvas, &x, &y, (left, right), (top, bottom));
    let unit = match scan.quantity.unit() {
        "" => "–",
        unit => unit,
    };
    canvas.text(
        "",
        (f64::midpoint(left, right), bottom + 41.0),
        Anchor::Middle,
        &format!("{} [{unit}]", scan.quantity.title()),
    );
    canvas.upward_text(
        "",
        (left - 54.0, f64::midpoint(top, bottom)),
        "peak angle [rad]",
    );
    let held = |peak: f64| y.place(peak.clamp(y.low(), y.high()));
    if x.contains(scan.present) {
        let at = x.place(scan.present);
        canvas.line("edge", (at, top), (at, bottom));
    }
    canvas.polyline(
        "used",
        scan.points
            .iter()
            .map(|(value, peak)| (x.place(*value), peak.map_or(f64::NAN, held))),
    );
    canvas.line("limit", (left, y.place(limit)), (right, y.place(limit)));
    for boundary in &document.boundaries {
        let of_pass = boundary.below != boundary.above
            && [boundary.below, boundary.above].contains(&crate::margin::State::Pass);
        if boundary.quantity == scan.quantity.name() && of_pass {
            canvas.circle("mark", (x.place(boundary.at), y.place(limit)), 4.2);
        }
    }
    canvas.rectangle("frame", (left, top), (PANEL_WIDTH, PANEL_HEIGHT));
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
    let top = header(
        &mut canvas,
        title,
        &[Entry::new(Mark::Line("boundary"), legend)],
    );
    let (columns, rows) = (request.columns, request.rows);
    let panel = Panel::linear(
        (request.x.low, request.x.high),
        (request.y.low, request.y.high),
        top + 14.0,
        height - 58.0,
    );
    let known = map.peaks_rad.iter().flatten().copied();
    let limit = document.threshold_rad;
    let positive = known.clone().filter(|peak| *peak > 0.0);
    let low = positive.fold(limit, f64::min).max(limit / 100.0);
    let high = known.fold(limit, f64::max).min(limit * 100.0);
    let (low, high) = if low < high {
        (low, high)
    } else {
        (limit / 2.0, limit * 2.0)
    };
    let share = |peak: f64| {
        (libm::log(peak.clamp(low, high)) - libm::log(low)) / (libm::log(high) - libm::log(low))
    };
    let mut pixels = Vec::with_capacity(3 * columns * rows);
    for row in (0..rows).rev() {
        for column in 0..columns {
            pixels.extend(match map.peaks_rad[row * columns + column] {
                Some(peak) => viridis(share(peak)),
                None => [128, 128, 128],
            });
        }
    }
    panel.grid(&mut canvas, Some(&request.x.key), &request.y.key);
    panel.clip(&mut canvas, "margin-map-clip");
    canvas.begin_clipped("margin-map-clip");
    // A picture element is as wide as the grid's step, with the grid value in its middle.
    let half = (
        0.5 * (request.x.high - request.x.low) / (columns - 1) as f64,
        0.5 * (request.y.high - request.y.low) / (rows - 1) as f64,
    );
    let corner = panel.place(request.x.low - half.0, request.y.high + half.1);
    let opposite = panel.place(request.x.high + half.0, request.y.low - half.1);
    canvas.png(
        &encode(&pixels, columns, rows)?,
        corner,
        (opposite.0 - corner.0, opposite.1 - corner.1),
    );
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
    colour_bar(&mut canvas, &panel, low, high, limit)?;
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

fn colour_bar(canvas: &mut Canvas, panel: &Panel, low: f64, high: f64, limit: f64) -> Option<()> {
    let steps: Vec<u8> = (0..64)
        .rev()
        .flat_map(|step| viridis((f64::from(step) + 0.5) / 64.0))
        .collect();
    let corner = (RIGHT + 10.0, panel.top);
    canvas.png(
        &encode(&steps, 1, 64)?,
        corner,
        (14.0, panel.bottom - panel.top),
    );
    canvas.rectangle("frame", corner, (14.0, panel.bottom - panel.top));
    let axis = Axis::logarithmic(low, high, panel.bottom, panel.top);
    for tick in axis.ticks(46.0, 0.0) {
        if tick.label.is_empty() {
            continue;
        }
        let y = axis.place(tick.value);
        canvas.line("tick", (RIGHT + 24.0, y), (RIGHT + 29.0, y));
        canvas.text("muted", (RIGHT + 33.0, y + 5.0), Anchor::Start, &tick.label);
    }
    let y = axis.place(limit);
    canvas.line("limit", (RIGHT + 4.0, y), (RIGHT + 28.0, y));
    canvas.text(
        "",
        (WIDTH - 4.0, panel.top - 10.0),
        Anchor::End,
        "peak [rad]",
    );
    Some(())
}
