//! The document of a static calculation.

use crate::blocks::RunBlock;
use crate::design_document::DesignDocument;
use latchgate_kernel::model::linkage::{LinkageElement, Reduced};
use latchgate_kernel::model::vector::Vector;
use latchgate_verdict::Answer;
use latchgate_verdict::statics::{
    Door, Standard, StaticAnswer, StaticLever, StaticQuestion, StaticRow,
};
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
    /// What part, revision and drawing it is of, where the design file says so.
    pub document: DesignDocument,
    /// The door that the latch holds.
    pub door: Door,
    /// Nominal preload torque T0 [N m].
    pub preload_torque_nm: f64,
    /// Nominal stiffness k0 [N m/rad].
    pub spring_stiffness_nm_per_rad: f64,
    /// The spring's least output, by which the rows are.
    pub spring: SpringOutput,
    /// The spring's average torque between closed and limit angle, at its least output where that is known [N m].
    pub averaged_torque_nm: f64,
    /// Mass m [kg] of a single lever.
    pub mass_kg: Option<f64>,
    /// Its arm L [m].
    pub center_of_mass_m: Option<f64>,
    /// Axis of a single lever [-] and the way from its pivot to its centre of mass [m], in the vehicle's axes.
    pub axis_and_center: Option<[Vector; 2]>,
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
    /// What each standard is answered.
    pub answers: Vec<StaticAnswer>,
    /// The torque that is left at 30 g in the worst direction, without gravity [N m].
    pub torque_left_nm: f64,
    /// The elements of a linkage with what each comes to.
    pub linkage: Vec<StaticElement>,
    /// What a replay of the sled pulse says beside it; `None` of a linkage that lacks what a replay needs.
    pub sled: Option<SledBeside>,
    /// What the numbers cover and leave out.
    pub notes: Vec<String>,
    /// Version.
    pub run: RunBlock,
}

/// The output of a spring, as the standards count it: the least.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SpringOutput {
    /// Whether the least output is known.
    pub stated: bool,
    /// Standard deviations below the nominal output at which it is taken; `None` where it is stated by itself.
    pub deviations: Option<f64>,
    /// One standard deviation of the closed spring's torque [N m].
    pub deviation_nm: Option<f64>,
    /// The closed spring's least torque [N m].
    pub least_torque_nm: Option<f64>,
    /// Its least stiffness [N m/rad].
    pub least_stiffness_nm_per_rad: Option<f64>,
}

/// A replay of a sled pulse beside the thresholds, the pulse along the worst direction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SledBeside {
    /// The pulse's word.
    pub pulse: String,
    /// The verdict.
    pub verdict: Answer,
    /// What the lever does, or what would decide it, in a sentence.
    pub headline: String,
    /// Elements of the linkage may part, which the replay does not follow.
    pub may_part: bool,
    /// `report_id` of the replay.
    pub report_id: String,
    /// Whether the static load is held in any direction, as the replay's pulse has it.
    pub static_holds: Option<bool>,
    /// Whether it is by the nominal spring.
    pub static_holds_nominally: bool,
}

impl SledBeside {
    /// Says what the replay found, and why where that is the other of what the static load says.
    pub fn text(&self) -> String {
        let why = match (self.static_holds, self.verdict) {
            (Some(true), Answer::Fail) => {
                " 30 g at rest do not open it: the pulse rises above 30 g and comes within milliseconds, so that the \
                 lever's speed carries it on."
            }
            (Some(true), Answer::Undecided) if !self.may_part => {
                " The static load counts the spring's scatter alone, not that of mass, arm, stop and pulse."
            }
            (Some(false), Answer::Pass) if self.static_holds_nominally => {
                " The static load counts every spring by its least output; the replay lets a few of a hundred levers open."
            }
            (Some(false), Answer::Pass) => {
                " A constant load opens it: the pulse ends before the lever has come to its limit."
            }
            _ => "",
        };
        format!(
            "Replay of {}, along the worst direction: {}. {}{why}",
            self.pulse,
            self.verdict.name(),
            self.headline
        )
    }
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
    pub fn of(
        (lever, document): (&StaticLever, DesignDocument),
        question: &StaticQuestion,
        sled: Option<SledBeside>,
        design_sha256: Option<String>,
        run: RunBlock,
    ) -> Self {
        let least = lever.with_least_spring(question);
        let counted = least.as_ref().unwrap_or(lever);
        let rows = lever.rows_at_least(question);
        let in_any_direction = StaticQuestion {
            standard: Some(Standard::UnR11),
            ..*question
        };
        let holds = |rows: &[StaticRow]| {
            let answers = StaticLever::answers(&in_any_direction, rows, least.is_some());
            answers.first().and_then(|answer| answer.holds)
        };
        let sled = sled.map(|sled| SledBeside {
            static_holds: holds(&rows),
            static_holds_nominally: holds(&lever.rows()) == Some(true),
            ..sled
        });
        let spring = SpringOutput {
            stated: least.is_some(),
            deviations: (least.is_some() && question.spring_torque_min_nm.is_none())
                .then_some(question.spring_deviations),
            deviation_nm: lever.preload_deviation_nm,
            least_torque_nm: least.as_ref().map(|least| least.preload_torque_nm),
            least_stiffness_nm_per_rad: least
                .as_ref()
                .map(|least| least.spring_stiffness_nm_per_rad),
        };
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
            document,
            door: question.door,
            spring,
            averaged_torque_nm: counted.averaged_torque_nm(),
            mass_kg: lever.mass_and_arm.map(|[mass, _]| mass),
            center_of_mass_m: lever.mass_and_arm.map(|[_, arm]| arm),
            axis_and_center: lever.axis_and_center,
            unbalance_kg_m: lever.unbalance_kg_m,
            threshold_rad: lever.threshold_rad,
            opening: lever.opening,
            gravity_share: lever.gravity_share(),
            answers: StaticLever::answers(question, &rows, spring.stated),
            rows,
            torque_left_nm: counted.torque_left_nm(),
            linkage: elements.collect(),
            notes: notes(counted, &spring, sled.is_some()),
            sled,
            run,
        }
    }
}

impl SpringOutput {
    /// Says by which output of the spring the rows are.
    fn text(&self) -> String {
        match (self.least_torque_nm, self.deviations) {
            (Some(least), Some(deviations)) => format!(
                "The spring counts with its least output, {least:.4} N·m closed: the nominal one less {deviations} \
                 standard deviations (UN R11 Annex 4, 2.1.1; SAE J839). The column nominal is without them."
            ),
            (Some(least), None) => format!(
                "The spring counts with its least output as stated, {least:.4} N·m closed (UN R11 Annex 4, 2.1.1; SAE \
                 J839). The column nominal is without it."
            ),
            (None, _) => "The spring counts with its nominal output, and the standards count its least: state \
                          tolerance.preload_torque_nm, 0 being a statement, or the spring's least torque."
                .into(),
        }
    }
}

/// Says what the numbers cover and leave out.
fn notes(lever: &StaticLever, spring: &SpringOutput, is_replayed: bool) -> Vec<String> {
    let mut notes = Vec::new();
    notes.push(spring.text());
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
    notes.extend(lever.implausible.iter().cloned());
    if !is_replayed {
        notes.push(
            "A load that comes at once, as a sled pulse does, carries the lever on by its speed and may exceed 30 g: a \
             latch that holds here can open under it."
                .into(),
        );
    }
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
            "Held is not told of a linkage, whose elements turn by different angles. Step: at once and for good, \
             undamped; without axes what lifts the linkage off counts in its place. Apart: the elements that are not \
             pinned part, with their springs, where the acceleration presses them shut."
                .into(),
        );
    }
    if lever.has_catch {
        notes.push(
            "The inertia catch is not counted: these are the levels of the lever alone.".into(),
        );
    }
    notes.push(
        "49 CFR 571.206, 571.201 and UN R11 were read in copies, SAE J839 was not: compare before filing."
            .into(),
    );
    notes
}
