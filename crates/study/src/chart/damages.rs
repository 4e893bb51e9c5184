//! What damage to a recording is seen: shares of blocked, told and silent passes, kind by kind.

use crate::damages::{Damages, Row};
use latchgate_report::plot::canvas::{Anchor, Canvas};
use latchgate_report::plot::frame::{self, Frame, LegendEntry, Sample, Scale};
use latchgate_report::plot::{Figure, WIDTH};

const NAME: &str = "damages";

/// Rules of the bars, in terms of the colours' variables.
pub(super) const RULES: &str = "\
.plot .blocked{fill:var(--first)}
.plot .held{fill:var(--first);opacity:.4}
.plot .told{fill:var(--second)}
.plot .silent{fill:var(--fail)}
.plot .small{font-size:12px}
";

/// Height of one kind's bar and of the room around it.
const BAR: f64 = 14.0;
const ROOM: f64 = 22.0;

/// Left edge of the bars; names of kinds stand left of it.
const LEFT: f64 = 250.0;

pub(super) fn draw(result: &Damages) -> Figure {
    let mut canvas = Canvas::with_capacity(64 * 1024);
    let title = "What damage to a recording is seen, and what cannot be";
    let runs: u32 = result.rows.iter().map(|row| row.runs).sum();
    let top = frame::header(
        &mut canvas,
        24.0,
        title,
        &[
            format!(
                "{runs} random damages of recordings that the lever fails; one channel in ten is coarse"
            ),
            "Below the line: what is left is another plausible recording, which nobody can tell."
                .into(),
        ],
        &[
            LegendEntry::new(Sample::Patch("blocked"), "blocked"),
            LegendEntry::new(Sample::Patch("held"), "fails or undecided all the same"),
            LegendEntry::new(Sample::Patch("told"), "passes with a new warning"),
            LegendEntry::new(Sample::Patch("silent"), "passes in silence"),
        ],
    ) + 20.0;
    let kinds: Vec<&[Row]> = result.rows.chunk_by(|a, b| a.kind == b.kind).collect();
    let bottom = top + ROOM * (kinds.len() as f64 + 1.0);
    let place = (LEFT, WIDTH - 60.0, top, bottom);
    let panel = Frame::narrow(place, Scale::Linear(0.0, 100.0), Scale::Linear(0.0, 1.0));
    let mut y = top + 0.5 * (ROOM - BAR);
    let mut said = String::from("Shares of damages by kind.");
    for (index, rows) in kinds.iter().enumerate() {
        if index > 0 && rows[0].undetectable && !kinds[index - 1][0].undetectable {
            let across = y + 0.5 * BAR;
            canvas.line("edge", (24.0, across), (panel.right, across));
            y += ROOM;
        }
        said.push_str(&bar(&mut canvas, &panel, rows, y));
        y += ROOM;
    }
    for percent in [0.0, 25.0, 50.0, 75.0, 100.0] {
        let x = panel.x.place(percent);
        canvas.line("tick", (x, bottom), (x, bottom + 4.0));
        let text = format!("{percent} %");
        canvas.text("muted small", (x, bottom + 18.0), Anchor::Middle, &text);
    }
    Figure {
        name: NAME,
        title: title.into(),
        caption: "What the program sees of random damages, by kind.".into(),
        description: said,
        height: bottom + 34.0,
        body: canvas.into_string(),
    }
}

/// Draws the shares of one kind and says them.
fn bar(canvas: &mut Canvas, panel: &Frame, rows: &[Row], y: f64) -> String {
    let sum = |of: fn(&Row) -> u32| f64::from(rows.iter().map(of).sum::<u32>());
    let runs = sum(|row| row.runs).max(1.0);
    let name = (LEFT - 10.0, y + BAR - 3.0);
    canvas.text("small", name, Anchor::End, rows[0].kind);
    let mut from = 0.0;
    let silent = 100.0 * sum(|row| row.silent) / runs;
    for (class, count) in [
        ("blocked", sum(|row| row.blocked)),
        ("held", sum(|row| row.not_passed)),
        ("told", sum(|row| row.told)),
        ("silent", sum(|row| row.silent)),
    ] {
        let to = from + 100.0 * count / runs;
        let (left, right) = (panel.x.place(from), panel.x.place(to));
        if right > left {
            canvas.rectangle(class, (left, y), (right - left, BAR));
        }
        from = to;
    }
    let text = format!("{silent:.1} %");
    let at = (panel.right + 8.0, y + BAR - 3.0);
    canvas.text("muted small", at, Anchor::Start, &text);
    format!(" {}: {silent:.1} % silent.", rows[0].kind)
}
