//! Histories from several initial states, each whole and in its last periods.

use crate::histories::{Histories, History};
use latchgate_document::number::{exact, significant};
use latchgate_kernel::model::stop::StopModel;
use latchgate_report::plot::canvas::{Anchor, Canvas};
use latchgate_report::plot::frame::{self, Frame, Scale};
use latchgate_report::plot::{Figure, WIDTH};

const NAME: &str = "histories";

/// Periods of the excitation in the panels at the right.
const LATE_PERIODS: f64 = 6.0;

pub(super) fn draw(result: &Histories) -> Figure {
    let mut canvas = Canvas::with_capacity(192 * 1024);
    let (amplitude, frequency) = result.excitation;
    let title = format!(
        "Where different starts end up: A = {} g, ω = {} rad/s",
        exact(amplitude),
        exact(frequency)
    );
    let legend = frame::stop_legend(class, &|model| {
        let mut histories = result.histories.iter();
        histories.any(|history| history.model == model)
    });
    let mut top = frame::header(
        &mut canvas,
        72.0,
        &title,
        &["Left: from the start. Right: the last periods shown, on a scale of their own.".into()],
        &legend,
    ) + 22.0;
    let mut index = 0;
    while index < result.histories.len() {
        let start = result.histories[index].start;
        let group: Vec<&History> = result.histories[index..]
            .iter()
            .take_while(|history| history.start.map(f64::to_bits) == start.map(f64::to_bits))
            .collect();
        row(&mut canvas, result, &group, index, top);
        index += group.len();
        top += 170.0 + 92.0;
    }
    Figure {
        name: NAME,
        title,
        caption: "The paper's Fig. 10.".into(),
        description: description(result),
        height: top - 22.0,
        body: canvas.into_string(),
    }
}

fn class(model: StopModel) -> &'static str {
    match model {
        StopModel::Rigid => "line rigid",
        StopModel::Soft => "line soft",
    }
}

fn description(result: &Histories) -> String {
    let mut text = String::from("Angle against time.");
    for history in &result.histories {
        text.push_str(&format!(
            " From ({}, {}), {} stop: {}.",
            history.start[0],
            history.start[1],
            history.model.name(),
            history.settled.words()
        ));
    }
    text
}

fn row(canvas: &mut Canvas, result: &Histories, group: &[&History], index: usize, top: f64) {
    let points = |history: &History| -> Vec<(f64, f64)> {
        history
            .trace
            .iter()
            .map(|point| (point.time_s, point.angle_rad))
            .collect()
    };
    let all = group.iter().flat_map(|history| points(history));
    let whole = Frame::narrow(
        (72.0, 560.0, top, top + 170.0),
        Scale::Linear(0.0, result.duration_s),
        frame::range(all.map(|point| point.1), 0.05),
    );
    let from = (result.duration_s - LATE_PERIODS * result.period_s).max(0.0);
    let late = group
        .iter()
        .flat_map(|history| points(history))
        .filter(|point| point.0 >= from)
        .map(|point| point.1);
    let (low, high) = frame::extent(late);
    let room = 0.08 * (high - low);
    // A lever at rest deserves no scale that makes mountains of rounding.
    let (low, high) = ((low - room).min(-0.002), (high + room).max(0.02));
    let end = Frame::narrow(
        (640.0, WIDTH - 16.0, top, top + 170.0),
        Scale::Linear(from, result.duration_s),
        Scale::Linear(low, high),
    );
    let letter = char::from(
        b'a' + u8::try_from(index / group.len().max(1))
            .unwrap_or(25)
            .min(25),
    );
    let start = group[0].start;
    whole.title(
        canvas,
        &format!(
            "({letter}) from φ = {} rad, φ′ = {} rad/s",
            exact(start[0]),
            exact(start[1])
        ),
    );
    for (panel, name, y_title) in [(whole, "whole", Some("angle φ [rad]")), (end, "late", None)] {
        panel.grid(canvas, Some("time [s]"), y_title);
        panel.begin_inside(canvas, &format!("{NAME}-{name}-{index}"));
        panel.level(canvas, "zero", 0.0);
        for history in group {
            panel.function(canvas, class(history.model), points(history).into_iter());
        }
        canvas.end_group();
        panel.frame(canvas);
    }
    for (line, history) in group.iter().enumerate() {
        let y = whole.top + 18.0 + 17.0 * line as f64;
        let peak = if history.settled.rests {
            String::new()
        } else {
            format!(
                ", up to {} rad",
                significant(history.settled.peak_angle_rad, 4)
            )
        };
        canvas.text(
            "small halo",
            (whole.right - 8.0, y),
            Anchor::End,
            &format!(
                "{} stop: {}{peak}",
                history.model.name(),
                history.settled.words()
            ),
        );
    }
}
