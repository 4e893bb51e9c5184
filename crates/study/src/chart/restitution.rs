//! Damping ratio against restitution, and where the equivalence ends.

use crate::restitution::Equivalence;
use latchgate_document::number::{exact, significant, trimmed};
use latchgate_report::plot::canvas::{Anchor, Canvas};
use latchgate_report::plot::frame::{self, Frame, Scale};
use latchgate_report::plot::{Figure, WIDTH};

const NAME: &str = "restitution";

pub(super) fn draw(result: &Equivalence) -> Figure {
    let mut canvas = Canvas::with_capacity(32 * 1024);
    let title = "Damping ratio of a soft stop that stands for a restitution";
    frame::header(
        &mut canvas,
        72.0,
        title,
        &["ξ = −ln R/√(π² + ln² R), eq. (2.5); cs = 2 I0 ωR ξ/ls². It holds for half a period of free contact.".into()],
        &[],
    );
    curve(&mut canvas, result);
    rebounds(&mut canvas, result);
    pushes(&mut canvas, result);
    Figure {
        name: NAME,
        title: title.into(),
        caption: "The curve of the paper's Fig. 2, and two limits of the equivalence.".into(),
        description: format!(
            "Damping ratio against restitution, falling from 1 at R = 0 to 0 at R = 1; the design's \
             R = {} and ξ = {}. Below, exit over entry speed of a contact with preload against the \
             speed of entry, and the stop's torque over a contact, which turns into tension before \
             its end.",
            exact(result.restitution),
            significant(result.damping_ratio, 5)
        ),
        height: 690.0,
        body: canvas.into_string(),
    }
}

fn curve(canvas: &mut Canvas, result: &Equivalence) {
    let panel = Frame::narrow(
        (72.0, WIDTH - 24.0, 90.0, 330.0),
        Scale::Linear(0.0, 1.0),
        Scale::Linear(0.0, 1.0),
    );
    panel.title(canvas, "(a) equivalent damping ratio");
    panel.grid(
        canvas,
        Some("coefficient of restitution R [–]"),
        Some("damping ratio ξ [–]"),
    );
    panel.begin_inside(canvas, "restitution-curve");
    let start = std::iter::once((0.0, 1.0));
    let rows = result
        .rows
        .iter()
        .map(|row| (row.restitution, row.damping_ratio));
    panel.function(canvas, "line bold rigid", start.chain(rows));
    canvas.end_group();
    panel.frame(canvas);
    let at = panel.place(result.half_period_ratio, result.damping_ratio);
    let foot = panel.place(result.half_period_ratio, 0.0);
    let wall = panel.place(0.0, result.damping_ratio);
    canvas.line("edge", at, foot);
    canvas.line("edge", at, wall);
    canvas.circle("spot", at, 5.0);
    let x = at.0.clamp(panel.left + 190.0, panel.right - 190.0);
    let y = (at.1 - 92.0).max(panel.top + 22.0);
    canvas.line("tick", (at.0, y + 26.0), (at.0, at.1 - 6.0));
    canvas.text(
        "halo",
        (x, y),
        Anchor::Middle,
        &format!(
            "this stop: ξ = cs ls²/(2 I0 ωR) = {}",
            significant(result.damping_ratio, 5)
        ),
    );
    canvas.text(
        "halo",
        (x, y + 19.0),
        Anchor::Middle,
        &format!(
            "gives back {} of the speed; R = {} asked",
            significant(result.half_period_ratio, 6),
            exact(result.restitution)
        ),
    );
}

fn rebounds(canvas: &mut Canvas, result: &Equivalence) {
    let ratios = result.rebounds.iter().filter_map(|rebound| rebound.ratio);
    let top = ratios.fold(result.restitution, f64::max) * 1.12;
    let speeds = Scale::Logarithmic(
        result.rebounds.first().map_or(1e-3, |at| at.speed_rad_s),
        result.rebounds.last().map_or(1e2, |at| at.speed_rad_s),
    );
    let panel = Frame::narrow(
        (72.0, 438.0, 412.0, 640.0),
        speeds,
        Scale::Linear(0.0, top.max(1e-3)),
    );
    panel.title(canvas, "(b) with preload, slow levers stay");
    panel.grid(
        canvas,
        Some("speed of entry [rad/s]"),
        Some("exit speed/entry speed [–]"),
    );
    panel.level(canvas, "edge", result.restitution);
    panel.begin_inside(canvas, "restitution-rebounds");
    let points = result
        .rebounds
        .iter()
        .map(|rebound| (rebound.speed_rad_s, rebound.ratio.unwrap_or(0.0)));
    panel.function(canvas, "line bold soft", points);
    canvas.end_group();
    panel.frame(canvas);
    canvas.text(
        "muted small halo",
        (panel.left + 8.0, panel.y.place(result.restitution) - 6.0),
        Anchor::Start,
        &format!("R = {}", exact(result.restitution)),
    );
    if let Some(speed) = result.capture_speed_rad_s {
        let (x, _) = panel.place(speed, 0.0);
        canvas.text(
            "small halo",
            (x + 12.0, panel.bottom - 12.0),
            Anchor::Start,
            &format!("stays below {} rad/s", significant(speed, 3)),
        );
    }
}

fn pushes(canvas: &mut Canvas, result: &Equivalence) {
    let torques = || result.pushes.iter().map(|push| push.torque_nm);
    let end_ms = result.pushes.last().map_or(1.0, |push| push.time_s * 1e3);
    let panel = Frame::narrow(
        (520.0, WIDTH - 24.0, 412.0, 640.0),
        Scale::Linear(0.0, end_ms * 1.02),
        frame::range(torques().chain(std::iter::once(0.0)), 0.08),
    );
    panel.title(
        canvas,
        &format!(
            "(c) entry at {} rad/s: late, the stop pulls",
            trimmed(result.speed_rad_s, 4)
        ),
    );
    panel.grid(
        canvas,
        Some("time from the entry [ms]"),
        Some("torque of the stop [N·m]"),
    );
    panel.begin_inside(canvas, "restitution-pushes");
    if let Some(from) = result.tension_from_s {
        let (left, _) = panel.place(from * 1e3, 0.0);
        let (right, _) = panel.place(end_ms, 0.0);
        canvas.rectangle(
            "pull",
            (left, panel.top),
            (right - left, panel.bottom - panel.top),
        );
    }
    panel.level(canvas, "zero", 0.0);
    panel.function(
        canvas,
        "line bold soft",
        result
            .pushes
            .iter()
            .map(|push| (push.time_s * 1e3, push.torque_nm)),
    );
    canvas.end_group();
    panel.frame(canvas);
    if let (Some(from), Some(ratio)) = (result.tension_from_s, result.released_ratio) {
        let x = panel.x.place(from * 1e3) - 70.0;
        let zero = panel.y.place(0.0);
        canvas.text(
            "small halo",
            (x, zero - 24.0),
            Anchor::End,
            &format!("tension from {} ms on;", trimmed(from * 1e3, 4)),
        );
        canvas.text(
            "small halo",
            (x, zero - 8.0),
            Anchor::End,
            &format!("if it let go there: {}", significant(ratio, 4)),
        );
    }
}
