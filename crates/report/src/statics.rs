//! Output of `latchgate static`: its text, and a page to file.

pub use super::folder::STATIC_FILE as DOCUMENT_FILE;
use super::html::static_page;
use super::json;
use super::terminal::{Look, fitted_table, wrapped};
use latchgate_document::number::significant;
use latchgate_document::static_document::{StaticDocument, StaticElement};
use latchgate_kernel::units::STANDARD_GRAVITY;
use latchgate_recording::error::Error;
use latchgate_verdict::statics::{Direction, REQUIRED_G, StaticRow};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// File name of the page.
pub const PAGE_FILE: &str = "static.html";

/// Writes page and document into `dir`, which is created if absent, and returns their paths.
///
/// # Errors
///
/// [`latchgate_recording::error::ErrorKind::Io`] if `dir` cannot be made or a file not be removed or written.
pub fn write(dir: &Path, document: &StaticDocument) -> Result<Vec<PathBuf>, Error> {
    let files = [
        (PAGE_FILE.to_string(), static_page(document).into_bytes()),
        (
            DOCUMENT_FILE.to_string(),
            json::render(document).into_bytes(),
        ),
    ];
    super::folder::put(dir, &[PAGE_FILE, DOCUMENT_FILE], &files)
}

/// Returns the answer in a sentence.
pub(crate) fn headline(document: &StaticDocument) -> String {
    let condition = match document.opening {
        Some(_) => "in the worst direction",
        None => "in the worst direction, gravity counted",
    };
    if document.worst_g >= REQUIRED_G {
        return format!(
            "Holds {REQUIRED_G} g in every direction: opens at {} {condition}.",
            g(document.worst_g)
        );
    }
    let axes = document.rows.iter().filter(|row| is_axis(row.direction));
    let (mut axis_rows, mut all_hold) = (0, true);
    for row in axes {
        axis_rows += 1;
        all_hold &= row.holds(REQUIRED_G);
    }
    let axes = match (axis_rows, all_hold) {
        (0, _) => "",
        (_, true) => " It holds along the axes, not in any direction.",
        (_, false) => " It does not hold along the axes either.",
    };
    format!(
        "Does not hold {REQUIRED_G} g: opens at {} {condition}.{axes}",
        g(document.worst_g)
    )
}

fn is_axis(direction: Direction) -> bool {
    !matches!(direction, Direction::Plane | Direction::Space)
}

/// Returns a level, cut and not rounded, so that none is shown above its value.
pub(crate) fn g(value: f64) -> String {
    format!("{}\u{00A0}g", significant(cut(value, 4), 4))
}

/// Returns a level as a part of a load, cut as well.
pub(crate) fn part(value: f64) -> String {
    significant(cut(value, 3), 3)
}

/// Cuts a positive number to so many digits.
fn cut(value: f64, digits: i32) -> f64 {
    if !(value.is_finite() && value > 0.0) {
        return value;
    }
    let unit = libm::pow(
        10.0,
        libm::floor(libm::log10(value)) - f64::from(digits - 1),
    );
    // A number without further digits must not lose its last one to a rounding error.
    let steps = value / unit;
    let kept_steps = if (steps - steps.round()).abs() < 1e-9 {
        steps.round()
    } else {
        steps.floor()
    };
    kept_steps * unit
}

/// Heads of the columns of thresholds.
pub(crate) const HEADS: [&str; 8] = [
    "Direction",
    "#Lifts off",
    "#SAE J839",
    "#with gravity",
    "#Held",
    "#Step",
    "#of 30 g",
    "#interior",
];

/// Returns the cells of a row: thresholds, and margins as parts of the load.
pub(crate) fn cells(row: &StaticRow) -> [String; 8] {
    let level = |value: Option<f64>| match (value, row.share) {
        (Some(value), _) => g(value),
        (None, None) => "never".into(),
        (None, Some(_)) => "–".into(),
    };
    let part = |value: Option<f64>| value.map_or_else(|| "–".into(), part);
    [
        row.direction.name().into(),
        level(row.lift_off_g),
        level(row.j839_g),
        row.j839_with_gravity_g.map_or_else(|| "–".into(), g),
        level(row.hold_g),
        level(row.step_g),
        part(row.margin),
        part(row.margin_interior),
    ]
}

/// Heads of the columns of a linkage.
pub(crate) const LINKAGE_HEADS: [&str; 6] = [
    "Element",
    "#Mass [kg]",
    "#Ratio",
    "#Spring T [N·m]",
    "#Stiffness [N·m/rad]",
    "#m·L [kg·m]",
];

/// Returns the cells of an element, reduced to the lever's pivot.
pub(crate) fn element_cells(element: &StaticElement) -> [String; 6] {
    let StaticElement { element, reduced } = element;
    let number = |value: f64| significant(value, 5);
    let unbalance = match reduced.unbalance_vector_kg_m {
        Some(vector) => vector.0.map(number).join(", "),
        None => number(reduced.unbalance_kg_m),
    };
    [
        element.name.clone(),
        number(element.mass_kg),
        number(element.ratio),
        number(reduced.preload_torque_nm),
        number(reduced.spring_stiffness_nm_per_rad),
        unbalance,
    ]
}

/// Returns the properties of the lever: names with values.
pub(crate) fn facts(document: &StaticDocument) -> Vec<(&'static str, String)> {
    let number = |value: f64| significant(value, 7);
    let limit = super::words::limit_angle(document.threshold_rad);
    let design = match document.modified.is_empty() {
        true => document.design.clone(),
        false => format!(
            "{}, modified: {}",
            document.design,
            document.modified.join(", ")
        ),
    };
    let mut facts = vec![
        ("Design", design),
        (
            "Spring",
            format!(
                "{} N·m closed, {} N·m/rad, {} N·m on average up to the limit angle, {limit}",
                number(document.preload_torque_nm),
                number(document.spring_stiffness_nm_per_rad),
                number(document.averaged_torque_nm)
            ),
        ),
        (
            "Unbalance m·L",
            format!("{} kg·m", number(document.unbalance_kg_m)),
        ),
    ];
    let torque_left_nm = document.torque_left_nm;
    facts.push((
        "Left at 30 g",
        format!(
            "{} N·m ({} kgf·m), worst direction, without gravity",
            significant(torque_left_nm, 5),
            significant(torque_left_nm / STANDARD_GRAVITY, 5)
        ),
    ));
    if let Some(opening) = document.opening {
        let [x, y, z] = opening.0.map(|part| significant(part, 4));
        facts.push(("Opens towards", format!("X {x}, Y {y}, Z {z}")));
    }
    facts
}

/// Returns the thresholds for a terminal: the answer, the lever, a row for each direction, then the notes.
pub fn text(document: &StaticDocument, report: Option<&Path>, look: Look) -> String {
    let mut out = wrapped(&format!("STATIC  {}", headline(document)), look.width, 8);
    out.push('\n');
    for (name, value) in facts(document) {
        let line = format!("  {name:<14} {}", super::escape::terminal(&value));
        let _ = writeln!(out, "{}", wrapped(&line, look.width, 17));
    }
    let plain = |heads: &[&str]| {
        heads
            .iter()
            .map(|head| head.trim_start_matches('#').to_string())
            .collect()
    };
    let table = |out: &mut String, rows: Vec<Vec<String>>| {
        out.push('\n');
        for line in fitted_table(&rows, 1, look.width).lines() {
            let _ = writeln!(out, "  {}", super::escape::terminal(line));
        }
    };
    if !document.linkage.is_empty() {
        let mut rows: Vec<Vec<String>> = vec![plain(&LINKAGE_HEADS)];
        rows.extend(
            document
                .linkage
                .iter()
                .map(|element| element_cells(element).to_vec()),
        );
        table(&mut out, rows);
    }
    let mut rows: Vec<Vec<String>> = vec![plain(&HEADS)];
    rows.extend(document.rows.iter().map(|row| cells(row).to_vec()));
    table(&mut out, rows);
    out.push('\n');
    for row in clauses(document) {
        let line = format!("  {:<22} {}", row.0, row.1);
        let _ = writeln!(out, "{}", wrapped(&line, look.width, 25));
    }
    out.push('\n');
    for note in &document.notes {
        let _ = writeln!(out, "{}", wrapped(&format!("  {note}"), look.width, 2));
    }
    if let Some(report) = report {
        let _ = writeln!(
            out,
            "  report         {}",
            look.path(&report.join(PAGE_FILE))
        );
    }
    out
}

/// Returns which clause each row answers; rows of one clause together.
pub(crate) fn clauses(document: &StaticDocument) -> Vec<(String, &'static str)> {
    let mut clauses: Vec<(String, &'static str)> = Vec::new();
    for row in &document.rows {
        let (name, clause) = (row.direction.name(), row.direction.clause());
        match clauses.last_mut().filter(|(_, last)| *last == clause) {
            Some((names, _)) => {
                names.push_str(", ");
                names.push_str(name);
            }
            None => clauses.push((name.into(), clause)),
        }
    }
    if document.opening.is_some() {
        clauses.push(("interior".into(), "interior compartment doors, 10 g across and vertical, 30 g along: 49 CFR 571.201 S5.3.1"));
    }
    clauses
}
