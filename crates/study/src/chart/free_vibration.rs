//! Free vibration with and without a stop, and the time from impact to impact.

use crate::free::{Against, FreeMotion};
use crate::free_vibration::FreeVibration;
use latchgate_document::number::{exact, significant};
use latchgate_report::plot::canvas::{Anchor, Canvas};
use latchgate_report::plot::frame::{self, Frame, LegendEntry, Scale};
use latchgate_report::plot::{Figure, WIDTH};

const NAME: &str = "free-vibration";

pub(super) fn draw(result: &FreeVibration) -> Figure {
    let mut canvas = Canvas::with_capacity(128 * 1024);
    let title = "Free vibration with and without impact";
    let shown = |against| {
        result
            .motions
            .iter()
            .any(|motion| motion.against == against)
    };
    let legend: Vec<LegendEntry> = [
        (Against::Nothing, "without a stop"),
        (Against::Rigid, "rigid stop"),
        (Against::Soft, "soft stop"),
    ]
    .into_iter()
    .filter(|(against, _)| shown(*against))
    .map(|(against, text)| LegendEntry::line(class(against), text))
    .collect();
    let mut top = frame::header(
        &mut canvas,
        72.0,
        title,
        &[
            "Let go at rest away from the stop unless the command says otherwise; no excitation."
                .into(),
        ],
        &legend,
    ) + 22.0;
    let mut preloads: Vec<f64> = Vec::new();
    for motion in &result.motions {
        if preloads
            .last()
            .is_none_or(|last| *last < motion.preload_torque_nm)
        {
            preloads.push(motion.preload_torque_nm);
        }
    }
    for (index, preload) in preloads.iter().enumerate() {
        let motions: Vec<&FreeMotion> = result
            .motions
            .iter()
            .filter(|motion| motion.preload_torque_nm.to_bits() == preload.to_bits())
            .collect();
        let place = (72.0, WIDTH - 16.0, top, top + 220.0);
        history(&mut canvas, result, &motions, index, place);
        top += 220.0 + 76.0;
    }
    let place = (72.0, WIDTH - 16.0, top, top + 170.0);
    intervals(&mut canvas, result, place);
    Figure {
        name: NAME,
        title: title.into(),
        caption: "The paper's Fig. 4.".into(),
        description: description(result),
        height: top + 170.0 + 50.0,
        body: canvas.into_string(),
    }
}

fn class(against: Against) -> &'static str {
    match against {
        Against::Nothing => "line nothing",
        Against::Rigid => "line rigid",
        Against::Soft => "line soft dash",
    }
}

fn description(result: &FreeVibration) -> String {
    let mut text = String::from("Angle against time after a release away from the stop.");
    for motion in &result.motions {
        if let (Some(first), Some(interval)) = (motion.impacts.first(), motion.intervals().first())
        {
            text.push_str(&format!(
                " T0 = {} N·m, {} stop: first impact at {} s, the next {} s later.",
                exact(motion.preload_torque_nm),
                motion.against.name(),
                significant(first[0], 6),
                significant(interval.1, 6)
            ));
        }
    }
    text
}

fn history(
    canvas: &mut Canvas,
    result: &FreeVibration,
    motions: &[&FreeMotion],
    index: usize,
    place: frame::PanelPlace,
) {
    let angles = motions
        .iter()
        .flat_map(|motion| motion.trace.iter().map(|point| point.angle_rad));
    let panel = Frame::narrow(
        place,
        Scale::Linear(0.0, result.duration_s),
        frame::range(angles, 0.06),
    );
    let preload = motions
        .first()
        .map_or(0.0, |motion| motion.preload_torque_nm);
    let letter = if index == 0 { 'a' } else { 'b' };
    let words = if preload > 0.0 {
        "the time between impacts shrinks"
    } else {
        "impacts at equal distances, about π/ω0"
    };
    panel.title(
        canvas,
        &format!("({letter}) T0 = {} N·m: {words}", exact(preload)),
    );
    panel.grid(canvas, Some("time [s]"), Some("angle φ [rad]"));
    panel.begin_inside(canvas, &format!("{NAME}-{index}"));
    panel.level(canvas, "zero", 0.0);
    for motion in motions {
        let points = motion
            .trace
            .iter()
            .map(|point| (point.time_s, point.angle_rad));
        panel.function(canvas, class(motion.against), points);
    }
    canvas.end_group();
    panel.frame(canvas);
    if let Some(time) = motions
        .iter()
        .filter(|motion| motion.against == Against::Rigid)
        .find_map(|motion| motion.settled_s)
    {
        let at = panel.place(time, 0.0);
        canvas.circle("spot", at, 4.0);
        canvas.text(
            "small halo",
            (at.0 + 8.0, at.1 - 9.0),
            Anchor::Start,
            &format!("at rest from {} s (rigid stop)", significant(time, 6)),
        );
    }
}

fn intervals(canvas: &mut Canvas, result: &FreeVibration, place: frame::PanelPlace) {
    let all: Vec<(f64, f64)> = result
        .motions
        .iter()
        .flat_map(FreeMotion::intervals)
        .chain(std::iter::once((0.0, result.half_period_s)))
        .collect();
    let (low, high) = frame::extent(all.iter().map(|interval| interval.1));
    let high = high + 0.1 * (high - low);
    let panel = Frame::narrow(
        place,
        Scale::Linear(0.0, result.duration_s),
        Scale::Linear(0.0, high),
    );
    panel.title(canvas, "Time from each impact to the next");
    panel.grid(canvas, Some("time [s]"), Some("to the next impact [s]"));
    panel.begin_inside(canvas, "free-vibration-intervals");
    panel.level(canvas, "edge", result.half_period_s);
    // Two stops all but agree: the dots of one are enough.
    let marked = result
        .motions
        .iter()
        .map(|motion| motion.against)
        .find(|against| *against != Against::Nothing);
    for motion in &result.motions {
        let points = motion.intervals();
        if points.is_empty() {
            continue;
        }
        panel.function(canvas, class(motion.against), points.iter().copied());
        if Some(motion.against) == marked {
            let text = format!("T0 = {} N·m", exact(motion.preload_torque_nm));
            if let Some(at) = below(&panel, &points, &text) {
                canvas.text("small halo", at, Anchor::Start, &text);
            }
            for (time, interval) in points.iter().take(40) {
                canvas.circle("spot", panel.place(*time, *interval), 2.4);
            }
        }
    }
    canvas.end_group();
    panel.frame(canvas);
    let level = panel.y.place(result.half_period_s);
    canvas.text(
        "muted small halo",
        (panel.right - 8.0, level + 15.0),
        Anchor::End,
        &format!("π/ω0 = {} s", significant(result.half_period_s, 6)),
    );
}

/// Returns where a text stands that begins with a falling or level curve, right below it.
fn below(panel: &Frame, points: &[(f64, f64)], text: &str) -> Option<(f64, f64)> {
    let placed: Vec<(f64, f64)> = points.iter().map(|(x, y)| panel.place(*x, *y)).collect();
    let left = placed.first()?.0;
    let right = left + 7.0 * text.chars().count() as f64;
    let lowest = placed
        .windows(2)
        .filter(|two| two[0].0 <= right)
        .map(|two| {
            let part = ((right - two[0].0) / (two[1].0 - two[0].0)).clamp(0.0, 1.0);
            two[0].1 + part * (two[1].1 - two[0].1)
        })
        .fold(placed[0].1, f64::max);
    Some((left, (lowest + 18.0).min(panel.bottom - 6.0)))
}
