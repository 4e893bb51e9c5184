//! Free vibration with and without a stop, and the time from impact to impact.

use super::angles;
use crate::free::{Against, FreeMotion};
use crate::free_vibration::FreeVibration;
use latchgate_document::number::{exact, significant};
use latchgate_kernel::range::Range;
use latchgate_report::plot::chart::At::{High, Value};
use latchgate_report::plot::chart::{Chart, Panel, Point, Points, Shape, WHOLE};
use latchgate_report::plot::frame::{LegendEntry, NARROW, Scale, extent, range};

pub(super) fn chart(result: &FreeVibration) -> Chart {
    let is_shown = |against| {
        result
            .motions
            .iter()
            .any(|motion| motion.against == against)
    };
    let stops = [
        (Against::Nothing, "without a stop"),
        (Against::Rigid, "rigid stop"),
        (Against::Soft, "soft stop"),
    ];
    let stops = stops.into_iter().filter(|(against, _)| is_shown(*against));
    let by_preload = result
        .motions
        .chunk_by(|a, b| a.preload_torque_nm.to_bits() == b.preload_torque_nm.to_bits());
    let histories = ('a'..).zip(by_preload);
    let histories = histories.map(|(letter, motions)| history(result, motions, letter));
    Chart {
        name: "free-vibration",
        title: "Free vibration with and without impact".into(),
        notes: vec![
            "Let go at rest away from the stop unless the command says otherwise; no excitation."
                .into(),
        ],
        legend: stops
            .map(|(against, text)| LegendEntry::line(class(against), text))
            .collect(),
        panels: histories.chain([intervals(result)]).collect(),
        room: [22.0, 76.0, 50.0],
        caption: "The paper's Fig. 4.".into(),
        description: description(result),
        ..Chart::default()
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
                significant(interval.length_s, 6)
            ));
        }
    }
    text
}

/// Returns the angle over time with one preload torque.
fn history(result: &FreeVibration, motions: &[FreeMotion], letter: char) -> Panel {
    let preload = motions[0].preload_torque_nm;
    let words = if preload > 0.0 {
        "the time between impacts shrinks"
    } else {
        "impacts at equal distances, about π/ω0"
    };
    let points = motions.iter().flat_map(|motion| angles(&motion.trace, 1.0));
    let mut rigid = motions
        .iter()
        .filter(|motion| motion.against == Against::Rigid);
    let settled = rigid.find_map(|motion| motion.settled_s);
    Panel::new(&NARROW, WHOLE, 220.0)
        .title(format!("({letter}) T0 = {} N·m: {words}", exact(preload)))
        .x("time [s]", Scale::Linear(0.0, result.duration_s))
        .y("angle φ [rad]", range(points.map(|point| point.y), 0.06))
        .level("zero", 0.0)
        .each(motions, |panel, motion| {
            panel.function(class(motion.against), angles(&motion.trace, 1.0))
        })
        .each(settled, |panel, time| {
            let text = format!("at rest from {} s (rigid stop)", significant(time, 6));
            panel
                .marks("spot", Shape::Circle(4.0), [Point::new(time, 0.0)])
                .text("small halo", (Value(time, 8.0), Value(0.0, -9.0)), text)
        })
}

/// Returns the time from each impact to the next.
fn intervals(result: &FreeVibration) -> Panel {
    let half_period = result.half_period_s;
    let intervals = result.motions.iter().flat_map(FreeMotion::intervals);
    let Range { low, high } = extent(
        intervals
            .map(|interval| interval.length_s)
            .chain([half_period]),
    );
    // The intervals of both stops nearly agree, so one stop has dots.
    let mut stops = result.motions.iter().map(|motion| motion.against);
    let marked = stops.find(|against| *against != Against::Nothing);
    let curves = result.motions.iter();
    let curves = curves.map(|motion| {
        let points = motion.intervals().into_iter();
        let points = points.map(|interval| Point::new(interval.middle_s, interval.length_s));
        (motion, points.collect::<Points>())
    });
    let dotted = curves
        .clone()
        .filter(|(motion, _)| Some(motion.against) == marked);
    Panel::new(&NARROW, WHOLE, 170.0)
        .title("Time from each impact to the next")
        .x("time [s]", Scale::Linear(0.0, result.duration_s))
        .y(
            "to the next impact [s]",
            Scale::Linear(0.0, high + 0.1 * (high - low)),
        )
        .level("edge", half_period)
        .each(curves, |panel, (motion, points)| {
            panel.function(class(motion.against), points)
        })
        .each(dotted, |panel, (motion, mut points)| {
            points.truncate(40);
            let Some(&first) = points.first() else {
                return panel;
            };
            // The text stands just below the curve, which never rises.
            let over = points
                .iter()
                .take_while(|point| point.x < first.x + 0.1 * result.duration_s);
            let lowest = over.fold(first.y, |lowest, point| point.y.min(lowest));
            let text = format!("T0 = {} N·m", exact(motion.preload_torque_nm));
            panel.marks("spot", Shape::Circle(2.4), points).text(
                "small halo",
                (Value(first.x, 6.0), Value(lowest, 18.0)),
                text,
            )
        })
        .text(
            "muted small halo",
            (High(-8.0), Value(half_period, 15.0)),
            format!("π/ω0 = {} s", significant(half_period, 6)),
        )
}
