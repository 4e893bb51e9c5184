//! The document of a static calculation.

use crate::blocks::RunBlock;
use latchgate_kernel::model::linkage::{LinkageElement, Reduced};
use latchgate_kernel::model::vector::Vector;
use latchgate_kernel::units::STANDARD_GRAVITY;
use latchgate_verdict::statics::{StaticLever, StaticRow};
use serde::Serialize;

/// What `latchgate static` answers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StaticDocument {
    /// `latchgate.static/1`.
    pub schema: &'static str,
    /// Name of the design.
    pub design: String,
    /// Keys that overrides gave another value, each with that and the one before.
    pub modified: Vec<String>,
    /// SHA-256 of the design file, where there is one.
    pub design_sha256: Option<String>,
    /// Preload torque T0 [N m].
    pub preload_torque_nm: f64,
    /// Stiffness k0 [N m/rad].
    pub spring_stiffness_nm_per_rad: f64,
    /// The spring's average torque between closed and limit angle [N m].
    pub averaged_torque_nm: f64,
    /// Unbalance m·L [kg m].
    pub unbalance_kg_m: f64,
    /// Limit angle [rad].
    pub threshold_rad: f64,
    /// In which direction the unbalance moves as the lever opens, in the axes of a vehicle's left door.
    pub opening: Option<Vector>,
    /// The part of gravity that pushes it open [-], negative where it holds it shut.
    pub gravity_share: Option<f64>,
    /// The thresholds by direction.
    pub rows: Vec<StaticRow>,
    /// The least of what counts [g].
    pub worst_g: f64,
    /// The torque that is left at 30 g in the worst direction, without gravity [N m].
    pub torque_left_nm: f64,
    /// The elements of a linkage with what each comes to.
    pub linkage: Vec<StaticElement>,
    /// What the numbers cover and leave out.
    pub notes: Vec<String>,
    /// Version.
    pub run: RunBlock,
}

/// An element of a linkage.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StaticElement {
    /// As the design states it.
    pub element: LinkageElement,
    /// What it comes to about the lever's pivot.
    pub reduced: Reduced,
}

impl StaticDocument {
    /// Puts the thresholds of a lever together.
    pub fn of(lever: &StaticLever, design_sha256: Option<String>, run: RunBlock) -> Self {
        let elements = lever.linkage.iter().map(|element| StaticElement {
            reduced: element.reduced(),
            element: element.clone(),
        });
        Self {
            schema: "latchgate.static/1",
            design: lever.name.clone(),
            modified: lever.modified.clone(),
            design_sha256,
            preload_torque_nm: lever.preload_torque_nm,
            spring_stiffness_nm_per_rad: lever.spring_stiffness_nm_per_rad,
            averaged_torque_nm: lever.averaged_torque_nm(),
            unbalance_kg_m: lever.unbalance_kg_m,
            threshold_rad: lever.threshold_rad,
            opening: lever.opening,
            gravity_share: lever.gravity_share(),
            rows: lever.rows(),
            worst_g: lever.worst_g(),
            torque_left_nm: lever.torque_left_nm(),
            linkage: elements.collect(),
            notes: notes(lever),
            run,
        }
    }
}

/// Says what the numbers cover and leave out.
fn notes(lever: &StaticLever) -> Vec<String> {
    let mut notes = Vec::new();
    if !lever.not_stated.is_empty() {
        let names = lever.not_stated.join(", ");
        notes.push(format!(
            "Not stated in the design, so that of the paper's example: {names}."
        ));
    }
    notes.push(
        "Friction and the work of the latch are left out, the spring is the average of closed and limit angle."
            .to_string(),
    );
    notes.push(match lever.gravity_share() {
        None => "No axis is stated: the worst direction answers for every other, and gravity counts as if it opened. \
                 State lever.axis and lever.center_of_mass for the vehicle's axes."
            .into(),
        Some(share) if share > 1e-12 => {
            format!("Gravity pushes the lever open with {share:.3} g and is counted.")
        }
        Some(_) => "Gravity does not push the lever open and is left out (UN R11 Annex 4, 2.1.1).".into(),
    });
    if lever.opening.is_some() {
        notes.push("Axes of a left door: X forward, Y to the right, Z down. On a right door +Y and −Y change places.".into());
    }
    if lever.linkage.is_empty() {
        notes.push("Held: at the limit angle, along a direction fixed to the vehicle; worst of all, along the turned arm. Step: \
             at once and for good, undamped.".into());
    } else {
        notes.push(
            "Held and step are not told of a linkage, whose elements turn by different angles."
                .into(),
        );
    }
    if lever.has_catch {
        notes.push(
            "The inertia catch is not counted: these are the levels of the lever alone.".into(),
        );
    }
    if let Some(alone) = Reduced::unbalanced_kg_m(&lever.linkage) {
        let level = lever.averaged_torque_nm() / (alone * STANDARD_GRAVITY);
        notes.push(format!(
            "Elements balance one another, taken as rigidly joined. One that can leave its neighbour does not: \
             without those that hold the latch shut it opens at {level:.2} g."
        ));
    }
    notes.push(
        "49 CFR 571.206, 571.201 and UN R11 were read in copies, SAE J839 was not: compare before filing."
            .into(),
    );
    notes
}
