//! Detection of damage to a recording: shares of blocked, warned and silent passes, kind by kind.

use crate::damages::{Damages, Row};
use latchgate_report::plot::WIDTH;
use latchgate_report::plot::chart::At::{High, Low, Value};
use latchgate_report::plot::chart::{Chart, Edges, Panel};
use latchgate_report::plot::frame::{LegendEntry, NARROW, Sample, Scale};

/// Rules of the bars, in terms of the colours' variables.
pub(super) const RULES: &str = "\
.plot .blocked{fill:var(--first)}
.plot .held{fill:var(--first);opacity:.4}
.plot .told{fill:var(--second)}
.plot .silent{fill:var(--fail)}
.plot .small{font-size:12px}
";

pub(super) fn chart(result: &Damages) -> Chart {
    let kinds: Vec<&[Row]> = result.rows.chunk_by(|a, b| a.kind == b.kind).collect();
    let rows = kinds.len() + 1;
    let title = "share [%]; at the right, of passes in silence";
    let mut panel = Panel::new(&NARROW, Edges::new(250.0, WIDTH - 60.0), 22.0 * rows as f64)
        .x(title, Scale::Linear(0.0, 100.0))
        .y("", Scale::Cells(rows));
    let mut description = String::from("Shares of damages by kind.");
    let mut y = rows as f64 - 0.5;
    for (index, kind) in kinds.iter().enumerate() {
        if index > 0 && kind[0].undetectable && !kinds[index - 1][0].undetectable {
            panel = panel.level("edge", y);
            y -= 1.0;
        }
        let silent;
        (panel, silent) = bar(panel, kind, y);
        description.push_str(&silent);
        y -= 1.0;
    }
    let runs: u32 = result.rows.iter().map(|row| row.runs).sum();
    let patch = |class, text| LegendEntry::new(Sample::Patch(class), text);
    Chart {
        name: "damages",
        title: "What damage to a recording is seen, and what cannot be".into(),
        notes: vec![
            format!(
                "{runs} random damages of recordings that the lever fails; one channel in ten is coarse"
            ),
            "Below the line: what is left is another plausible recording, which nobody can tell."
                .into(),
        ],
        legend: vec![
            patch("blocked", "blocked"),
            patch("held", "fails or undecided all the same"),
            patch("told", "passes with a new warning"),
            patch("silent", "passes in silence"),
        ],
        panels: vec![panel],
        room: [20.0, 0.0, 50.0],
        caption: "What the program sees of random damages, by kind.".into(),
        description,
        ..Chart::default()
    }
}

/// Adds the bar of one kind around `y`; returns its shares in words as well.
fn bar(mut panel: Panel, rows: &[Row], y: f64) -> (Panel, String) {
    let sum = |of: fn(&Row) -> u32| f64::from(rows.iter().map(of).sum::<u32>());
    let share = 100.0 / sum(|row| row.runs).max(1.0);
    let mut from = 0.0;
    for (class, count) in [
        ("blocked", sum(|row| row.blocked)),
        ("held", sum(|row| row.not_passed)),
        ("told", sum(|row| row.told)),
        ("silent", sum(|row| row.silent)),
    ] {
        let to = from + share * count;
        if count > 0.0 {
            let corner = |x, down| (Value(x, 0.0), Value(y, down));
            panel = panel.patch(class, corner(from, -7.0), corner(to, 7.0));
        }
        from = to;
    }
    let (kind, silent) = (rows[0].kind, share * sum(|row| row.silent));
    let panel = panel.text("small", (Low(-10.0), Value(y, 4.0)), kind).text(
        "muted small",
        (High(8.0), Value(y, 4.0)),
        format!("{silent:.1} %"),
    );
    (panel, format!(" {kind}: {silent:.1} % silent."))
}
