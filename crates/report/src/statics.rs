//! Output of `latchgate static`: its text, and a page to file.

pub use super::folder::STATIC_FILE as DOCUMENT_FILE;
use super::html::static_page;
use super::json;
use super::terminal::{Look, fitted_table, wrapped};
use latchgate_document::number::significant;
use latchgate_document::static_document::{StaticDocument, StaticElement};
use latchgate_kernel::model::linkage::Reduced;
use latchgate_kernel::model::vector::Vector;
use latchgate_kernel::units::STANDARD_GRAVITY;
use latchgate_recording::error::Error;
use latchgate_verdict::statics::{
    Direction, NotShown, REQUIRED_G, SPRING_DEVIATIONS, Standard, StaticAnswer, StaticRow,
};
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

/// Returns the word that a page begins with, and its colour: all that is asked is held, something is not, or it would
/// be by a spring whose least output nobody states.
pub(crate) fn word(document: &StaticDocument) -> (&'static str, &'static str) {
    let mut all = document.answers.iter().map(|answer| answer.holds);
    if all.clone().any(|holds| holds == Some(false)) {
        return ("fail", "DOES NOT HOLD 30 g");
    }
    let not_shown = document.answers.iter().find_map(|answer| answer.not_shown);
    match not_shown {
        None if all.all(|holds| holds == Some(true)) => ("pass", "HOLDS 30 g"),
        Some(NotShown::Spring) => ("undecided", "SPRING NOT STATED"),
        _ => ("undecided", "NOT SHOWN TO HOLD 30 g"),
    }
}

/// Returns the answers, a sentence for each standard.
pub(crate) fn headlines(document: &StaticDocument) -> Vec<String> {
    let sentence = |answer: &StaticAnswer| {
        let name = answer.standard.name();
        let says = match answer.holds {
            Some(true) => format!("holds {REQUIRED_G} g"),
            Some(false) => format!("does not hold {REQUIRED_G} g"),
            None => match answer.not_shown {
                Some(NotShown::Joined) => format!(
                    "not shown: {REQUIRED_G} g is held only while its elements stay joined; apart they open at {}. State \
                     pinned = true of those that cannot part",
                    answer.apart_g.map_or_else(String::new, g)
                ),
                Some(NotShown::Axis) => {
                    "not shown: no axis is stated, and the worst direction does not hold it".into()
                }
                Some(NotShown::Spring) | None => format!(
                    "not shown: {REQUIRED_G} g is held by the nominal spring, whose least output is not stated"
                ),
            },
        };
        let opens = match answer.opens_at_g {
            Some(level) => format!("opens at {} ({})", g(level), answer.direction.name()),
            None => "nothing opens it".into(),
        };
        // Any direction is that of every door.
        let door = match answer.standard {
            Standard::Fmvss206 => format!(", {}", document.door.name()),
            Standard::UnR11 | Standard::SaeJ839 => String::new(),
        };
        format!("{name}{door}: {says}; {opens}.")
    };
    let mut lines: Vec<String> = document.answers.iter().map(sentence).collect();
    let spring = document.spring.deviations;
    if let Some(fewer) = spring.filter(|deviations| *deviations < SPRING_DEVIATIONS) {
        lines.push(format!(
            "The spring counts {fewer} standard deviations below its nominal output, as asked; {SPRING_DEVIATIONS} unless asked."
        ));
    }
    if let Some(sled) = &document.sled {
        lines.push(sled.text());
    }
    lines
}

/// Returns a level, cut and not rounded, so that none is shown above its value.
pub fn g(value: f64) -> String {
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
pub(crate) const HEADS: [&str; 12] = [
    "Direction",
    "#s, r",
    "#Lifts off",
    "#SAE J839",
    "#gravity",
    "#Held",
    "#Step",
    "#Apart",
    "#counts",
    "#nominal",
    "#of 30 g",
    "#interior",
];

/// Returns the cells of a row: thresholds, and margins as parts of the load.
pub(crate) fn cells(row: &StaticRow) -> [String; 12] {
    let level = |value: Option<f64>| match (value, row.share) {
        (Some(value), _) => g(value),
        (None, None) => "never".into(),
        (None, Some(_)) => "–".into(),
    };
    let part = |value: Option<f64>| value.map_or_else(|| "–".into(), part);
    let parts = match (row.share, row.across) {
        (Some(s), Some(r)) => format!("{s:.4}, {r:.4}").replace('-', "−"),
        (Some(_), None) if row.direction == Direction::Space => "1".into(),
        (Some(s), None) => format!("{s:.4}"),
        (None, _) => "–".into(),
    };
    [
        row.direction.name().into(),
        parts,
        level(row.lift_off_g),
        level(row.j839_g),
        row.j839_with_gravity_g.map_or_else(|| "–".into(), g),
        level(row.hold_g),
        level(row.step_g),
        row.apart_g.map_or_else(|| "–".into(), g),
        level(row.counts_g),
        level(row.nominal_g),
        part(row.margin),
        part(row.margin_interior),
    ]
}

/// What stands in the columns, to be computed by hand.
pub(crate) const FORMULAS: &str = "Lifts off T0/(m L s); SAE J839 (T0 + k0 φ*/2)/(m L s), with gravity less by what 1 g \
    pushes open; held (T0 + k0 φ*)/(m L (s cos φ* + r sin φ*)); step (T0 φ* + k0 φ*²/2)/(m L (s sin φ* + r (1 − cos φ*))); \
    s and r: parts of the acceleration that open along and across the way. What counts is SAE J839 with gravity, or the \
    step if that is less, less the part of its work that 1 g does, but no less than lifts off, less the part of 1 g that opens; \
    of 30 g, interior: that over the load, 1 or more holds it.";

/// Heads of the columns of a linkage.
pub(crate) const LINKAGE_HEADS: [&str; 9] = [
    "Element",
    "#Mass m [kg]",
    "#Arm L [m]",
    "#Spring",
    "#k [N·m/rad]",
    "#Ratio i",
    "#i T [N·m]",
    "#i² k [N·m/rad]",
    "#i m L [kg·m]",
];

/// Returns the cells of the elements, as stated and reduced to the lever's pivot, with their sums last.
pub(crate) fn linkage_rows(document: &StaticDocument) -> Vec<[String; 9]> {
    let elements = document.linkage.iter();
    let mut rows: Vec<[String; 9]> = elements.clone().map(element_cells).collect();
    let reduced = || elements.clone().map(|element| &element.reduced);
    let sum = |of: &dyn Fn(&Reduced) -> f64| plain(reduced().map(of).sum());
    let vectors: Option<Vec<Vector>> = reduced().map(|own| own.unbalance_vector_kg_m).collect();
    let unbalance = match vectors {
        Some(vectors) => {
            let zero = Vector([0.0; 3]);
            vector(vectors.into_iter().fold(zero, Vector::plus))
        }
        None => sum(&|own| own.unbalance_kg_m),
    };
    rows.push([
        "sum".into(),
        sum(&|own| own.mass_kg),
        String::new(),
        String::new(),
        String::new(),
        String::new(),
        sum(&|own| own.preload_torque_nm),
        sum(&|own| own.spring_stiffness_nm_per_rad),
        unbalance,
    ]);
    rows
}

fn vector(Vector(parts): Vector) -> String {
    parts.map(plain).join(", ")
}

fn element_cells(element: &StaticElement) -> [String; 9] {
    let StaticElement { element, reduced } = element;
    let arm = match (element.arm_m, element.axis, element.center_of_mass) {
        (Some(arm), ..) => plain(arm),
        (None, Some(axis), Some(center)) => {
            format!("axis {}; centre {}", vector(axis), vector(center))
        }
        _ => String::new(),
    };
    let of_force = format!(
        "{} N × {} m",
        plain(element.spring_force_n),
        plain(element.spring_arm_m)
    );
    let of_torque = format!("{} N·m", plain(element.spring_torque_nm));
    let spring = match (
        element.spring_torque_nm == 0.0,
        element.spring_force_n == 0.0,
    ) {
        (true, true) => "none".into(),
        (true, false) => of_force,
        (false, true) => of_torque,
        (false, false) => format!("{of_torque} + {of_force}"),
    };
    [
        element.name.clone(),
        plain(element.mass_kg),
        arm,
        spring,
        plain(element.spring_stiffness_nm_per_rad),
        plain(element.ratio),
        plain(reduced.preload_torque_nm),
        plain(reduced.spring_stiffness_nm_per_rad),
        reduced
            .unbalance_vector_kg_m
            .map_or_else(|| plain(reduced.unbalance_kg_m), vector),
    ]
}

/// Returns the properties of the lever: names with values.
pub(crate) fn facts(document: &StaticDocument) -> Vec<(&'static str, String)> {
    let number = |value: f64| plain(value);
    let limit = super::words::limit_angle(document.threshold_rad);
    let design = match document.modified.is_empty() {
        true => document.design.clone(),
        false => format!(
            "{}, modified: {}",
            document.design,
            document.modified.join(", ")
        ),
    };
    let stated = document.document.stated().into_iter();
    let stated: Vec<String> = stated
        .map(|(name, value)| format!("{} {value}", name.to_lowercase()))
        .collect();
    let mut facts: Vec<(&'static str, String)> = vec![("Design", design)];
    if !stated.is_empty() {
        facts.push(("Document", stated.join(", ")));
    }
    facts.push(("Door", document.door.name().into()));
    facts.push(("Spring", spring(document)));
    facts.push((
        "Counted torque",
        format!(
            "{} N·m, the average of closed and limit angle, {limit}",
            number(document.averaged_torque_nm)
        ),
    ));
    let unbalance = number(document.unbalance_kg_m);
    facts.push((
        "Unbalance m·L",
        match (document.mass_kg, document.center_of_mass_m) {
            (Some(mass), Some(arm)) => {
                let arm = number(arm.abs());
                format!("{} kg × {arm} m = {unbalance} kg·m", number(mass))
            }
            _ => format!("{unbalance} kg·m"),
        },
    ));
    let torque_left_nm = document.torque_left_nm;
    facts.push((
        "Left at 30 g",
        format!(
            "{} N·m ({} kgf·m), worst direction, without gravity",
            significant(torque_left_nm, 5),
            significant(torque_left_nm / STANDARD_GRAVITY, 5)
        ),
    ));
    if let Some([axis, center]) = document.axis_and_center {
        let text = format!("axis {}; from the pivot {} m", vector(axis), vector(center));
        facts.push(("Centre of mass", text));
    }
    if let Some(opening) = document.opening {
        let [x, y, z] = opening.0.map(|part| significant(part, 4));
        facts.push(("Opens towards", format!("X {x}, Y {y}, Z {z}")));
    }
    facts
}

/// Returns a number without digits that nobody stated.
fn plain(value: f64) -> String {
    let rounded = format!("{value:.6e}").parse::<f64>();
    let shown = rounded.map_or_else(|_| value.to_string(), |value| value.to_string());
    shown.replace('-', "−")
}

/// Says what is stated of the spring, and by which output the rows are.
fn spring(document: &StaticDocument) -> String {
    let spring = &document.spring;
    let nominal = plain(document.preload_torque_nm);
    let (stiffness, least) = (
        document.spring_stiffness_nm_per_rad,
        spring.least_stiffness_nm_per_rad,
    );
    let counted = match least.filter(|least| *least < stiffness) {
        Some(0.0) => ", counted as none: its scatter is not stated, or larger than it".to_string(),
        Some(least) => format!(", so at least {}", plain(least)),
        None => String::new(),
    };
    let stiffness = format!("{} N·m/rad{counted}", plain(stiffness));
    match (
        spring.least_torque_nm,
        spring.deviations,
        spring.deviation_nm,
    ) {
        (Some(least), Some(deviations), Some(deviation)) => format!(
            "{nominal} N·m closed, standard deviation {} N·m, so at least {} N·m ({deviations} of them less); {stiffness}",
            plain(deviation),
            plain(least)
        ),
        (Some(least), ..) => {
            format!(
                "{nominal} N·m closed, at least {} N·m as stated; {stiffness}",
                plain(least)
            )
        }
        (None, ..) => {
            format!("{nominal} N·m closed, its least output not stated; {stiffness}")
        }
    }
}

/// Returns the thresholds for a terminal: the answer, the lever, a row for each direction, then the notes.
pub fn text(document: &StaticDocument, report: Option<&Path>, look: Look) -> String {
    let mut out = format!("STATIC  {}\n", word(document).1);
    for line in headlines(document) {
        let _ = writeln!(
            out,
            "{}",
            wrapped(&format!("        {}", (look.worded)(&line)), look.width, 10)
        );
    }
    for (name, value) in facts(document) {
        let value = (look.worded)(&value);
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
        // What each element is by itself stands on the page.
        let mut rows: Vec<Vec<String>> = vec![plain(&LINKAGE_HEADS)];
        rows.extend(linkage_rows(document).into_iter().map(Vec::from));
        rows.iter_mut().for_each(|row| drop(row.drain(2..5)));
        table(&mut out, rows);
    }
    let mut rows: Vec<Vec<String>> = vec![plain(&HEADS)];
    rows.extend(document.rows.iter().map(|row| cells(row).to_vec()));
    rows.iter_mut().for_each(|row| drop(row.remove(1)));
    table(&mut out, rows);
    out.push('\n');
    for row in clauses(document) {
        let line = format!("  {:<22} {}", row.0, row.1);
        let _ = writeln!(out, "{}", wrapped(&line, look.width, 25));
    }
    out.push('\n');
    let notes = document.notes.iter().map(String::as_str);
    for note in std::iter::once(FORMULAS).chain(notes) {
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
        let (name, clause) = (row.direction.name(), row.direction.clause(document.door));
        match clauses.last_mut().filter(|(_, last)| *last == clause) {
            Some((names, _)) => {
                names.push_str(", ");
                names.push_str(name);
            }
            None => clauses.push((name.into(), clause)),
        }
    }
    if document.opening.is_some() {
        clauses.push(("nominal".into(), "what counts, by the nominal spring"));
        clauses.push(("interior".into(), "interior compartment doors, 10 g across and vertical, 30 g along: 49 CFR 571.201 S5.3.1"));
    }
    clauses
}
