//! Damping ratio against restitution, and the limits of the equivalence.

use crate::restitution::Equivalence;
use latchgate_document::number::{exact, significant, trimmed};
use latchgate_report::plot::chart::At::{Low, Value};
use latchgate_report::plot::chart::{Chart, HALVES, Panel, Point, Shape, WHOLE};
use latchgate_report::plot::frame::{NARROW, Scale, range};

pub(super) fn chart(result: &Equivalence) -> Chart {
    Chart {
        name: "restitution",
        title: "Damping ratio of a soft stop that stands for a restitution".into(),
        notes: vec!["ξ = −ln R/√(π² + ln² R), eq. (2.5); cs = 2 I0 ωR ξ/ls². It holds for half a period of free contact.".into()],
        panels: vec![curve(result), rebounds(result), pushes(result)],
        room: [30.0, 82.0, 50.0],
        caption: "The curve of the paper's Fig. 2, and two limits of the equivalence.".into(),
        description: format!(
            "Damping ratio against restitution, falling from 1 at R = 0 to 0 at R = 1; the design's \
             R = {} and ξ = {}. Below, exit over entry speed of a contact with preload against the \
             speed of entry, and the stop's torque over a contact, which turns into tension before \
             its end.",
            exact(result.restitution),
            significant(result.damping_ratio, 5)
        ),
        ..Chart::default()
    }
}

fn curve(result: &Equivalence) -> Panel {
    let rows = result.rows.iter();
    let rows = rows.map(|row| Point::new(row.restitution, row.damping_ratio));
    let (x, y) = (result.half_period_ratio, result.damping_ratio);
    let spot = (Value(x, 0.0), Value(y, 0.0));
    // The text stands above the curve, with room for half of it on each side.
    let (words_x, words_y) = (x.clamp(0.24, 0.76), (y + 0.38).min(0.9));
    let words = |down| (Value(words_x, 0.0), Value(words_y, down));
    let ratio_text = format!("this stop: ξ = cs ls²/(2 I0 ωR) = {}", significant(y, 5));
    let speed_text = format!(
        "gives back {} of the speed; R = {} asked",
        significant(x, 6),
        exact(result.restitution)
    );
    Panel::new(&NARROW, WHOLE, 240.0)
        .title("(a) equivalent damping ratio")
        .x("coefficient of restitution R [–]", Scale::Linear(0.0, 1.0))
        .y("damping ratio ξ [–]", Scale::Linear(0.0, 1.0))
        .function(
            "line bold rigid",
            [Point::new(0.0, 1.0)].into_iter().chain(rows),
        )
        .segment("edge", spot, (spot.0, Low(0.0)))
        .segment("edge", spot, (Low(0.0), spot.1))
        .segment(
            "tick",
            (spot.0, Value(words_y, 26.0)),
            (spot.0, Value(y, -6.0)),
        )
        .marks("spot", Shape::Circle(5.0), [Point::new(x, y)])
        .text("halo", words(0.0), ratio_text)
        .text("halo", words(19.0), speed_text)
}

fn rebounds(result: &Equivalence) -> Panel {
    let restitution = result.restitution;
    let ratios = result.rebounds.iter().filter_map(|rebound| rebound.ratio);
    let top = ratios.fold(restitution, f64::max) * 1.12;
    let speeds = Scale::Logarithmic(
        result
            .rebounds
            .first()
            .map_or(1e-3, |rebound| rebound.speed_rad_s),
        result
            .rebounds
            .last()
            .map_or(1e2, |rebound| rebound.speed_rad_s),
    );
    let points = result.rebounds.iter();
    let points =
        points.map(|rebound| Point::new(rebound.speed_rad_s, rebound.ratio.unwrap_or(0.0)));
    Panel::new(&NARROW, HALVES[0], 228.0)
        .title("(b) with preload, slow levers stay")
        .x("speed of entry [rad/s]", speeds)
        .y(
            "exit speed/entry speed [–]",
            Scale::Linear(0.0, top.max(1e-3)),
        )
        .level("edge", restitution)
        .function("line bold soft", points)
        .text(
            "muted small halo",
            (Low(8.0), Value(restitution, -6.0)),
            format!("R = {}", exact(restitution)),
        )
        .each(result.capture_speed_rad_s, |panel, speed| {
            let text = format!("stays below {} rad/s", significant(speed, 3));
            panel.text("small halo", (Value(speed, 12.0), Low(-12.0)), text)
        })
}

fn pushes(result: &Equivalence) -> Panel {
    let points = || {
        result
            .pushes
            .iter()
            .map(|push| Point::new(push.time_s * 1e3, push.torque_nm))
    };
    let end_ms = points().next_back().map_or(1.0, |point| point.x);
    let torques = points().map(|point| point.y).chain([0.0]);
    let speed = trimmed(result.speed_rad_s, 4);
    let from_ms = result.tension_from_s.map(|from| from * 1e3);
    Panel::new(&NARROW, HALVES[1], 228.0)
        .title(format!("(c) entry at {speed} rad/s: late, the stop pulls"))
        .x(
            "time from the entry [ms]",
            Scale::Linear(0.0, end_ms * 1.02),
        )
        .y("torque of the stop [N·m]", range(torques, 0.08))
        .level("zero", 0.0)
        .function("line bold soft", points())
        .each(from_ms, |panel, from_ms| {
            panel.band("pull", from_ms, end_ms)
        })
        .each(
            from_ms.zip(result.released_ratio),
            |panel, (from_ms, ratio)| {
                let from = format!("tension from {} ms on;", trimmed(from_ms, 4));
                let ratio = format!("if it let go there: {}", significant(ratio, 4));
                let label_place = |down| (Value(from_ms, -70.0), Value(0.0, down));
                panel.text("small halo", label_place(-24.0), from).text(
                    "small halo",
                    label_place(-8.0),
                    ratio,
                )
            },
        )
}
