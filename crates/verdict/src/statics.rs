//! Static thresholds: the constant acceleration that lifts, holds or steps a lever open, by direction.
//!
//! What is filed for door latches by calculation (SAE J839; UN R11 Annex 4, 2.1): springs as the average of their least
//! outputs in closed and released position, friction and work left out, gravity left out only where it holds the latch
//! shut. The hold turns the force's arm with the lever; along a fixed axis it is larger by 1/cos φ*.

use crate::replay_findings::implausible;
use latchgate_kernel::error::Error;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::linkage::{LinkageElement, Reduced};
use latchgate_kernel::model::parameters::{DesignParameter, PARAMETERS};
use latchgate_kernel::model::vector::Vector;
use latchgate_kernel::units::STANDARD_GRAVITY;
use serde::{Deserialize, Serialize};

/// Inertial load of the door-latch regulations [g].
pub const REQUIRED_G: f64 = 30.0;

/// Transverse and vertical load of interior compartment doors [g].
pub const REQUIRED_INTERIOR_G: f64 = 10.0;

/// Standard deviations below its nominal output at which a spring is counted, unless others are asked for.
pub const SPRING_DEVIATIONS: f64 = 3.0;

/// Who asks for the load, and in which directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Standard {
    /// 49 CFR 571.206: along the vehicle's axes.
    #[serde(rename = "206")]
    Fmvss206,
    /// UN R11: in any direction.
    #[serde(rename = "r11")]
    UnR11,
    /// SAE J839: in any direction.
    #[serde(rename = "j839")]
    SaeJ839,
}

impl Standard {
    /// Every one, in the order of a page.
    pub const ALL: [Self; 3] = [Self::Fmvss206, Self::UnR11, Self::SaeJ839];

    /// Returns the word that options and gate files use.
    pub fn word(self) -> &'static str {
        match self {
            Self::Fmvss206 => "206",
            Self::UnR11 => "r11",
            Self::SaeJ839 => "j839",
        }
    }

    /// Returns how it is called, and in which directions it asks.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fmvss206 => "49 CFR 571.206, along the axes",
            Self::UnR11 => "UN R11, in any direction",
            Self::SaeJ839 => "SAE J839, in any direction",
        }
    }

    /// Tells whether a row of a door is one that it asks for.
    fn asks(self, direction: Direction, door: Door) -> bool {
        match (self, direction) {
            (Self::Fmvss206, Direction::Plane | Direction::Space) => false,
            (Self::Fmvss206, Direction::Down | Direction::Up) => door == Door::Back,
            _ => true,
        }
    }
}

/// The door that a latch holds: which rows and clauses count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Door {
    /// A hinged side door.
    #[default]
    Hinged,
    /// A sliding side door.
    Sliding,
    /// A back door.
    Back,
}

impl Door {
    /// Every one.
    pub const ALL: [Self; 3] = [Self::Hinged, Self::Sliding, Self::Back];

    /// Returns the word that options use.
    pub fn word(self) -> &'static str {
        match self {
            Self::Hinged => "hinged",
            Self::Sliding => "sliding",
            Self::Back => "back",
        }
    }

    /// Returns how it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hinged => "hinged side door",
            Self::Sliding => "sliding side door",
            Self::Back => "back door",
        }
    }
}

/// What the load is held against.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StaticQuestion {
    /// The one standard asked about; `None` for all.
    pub standard: Option<Standard>,
    /// The door.
    pub door: Door,
    /// Standard deviations below its nominal output at which the spring is counted.
    pub spring_deviations: f64,
    /// The least output of the closed spring [N m], where it is known.
    pub spring_torque_min_nm: Option<f64>,
}

impl Default for StaticQuestion {
    fn default() -> Self {
        Self {
            standard: None,
            door: Door::default(),
            spring_deviations: SPRING_DEVIATIONS,
            spring_torque_min_nm: None,
        }
    }
}

/// What one standard is answered.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StaticAnswer {
    /// The standard.
    pub standard: Standard,
    /// Whether the load is held; `None` where that is not shown.
    pub holds: Option<bool>,
    /// Why it is not shown.
    pub not_shown: Option<NotShown>,
    /// The least of what counts over the rows that it asks for [g]; `None` where nothing opens.
    pub opens_at_g: Option<f64>,
    /// In which of them.
    pub direction: Direction,
    /// The least over the same rows if the elements of a linkage that are not pinned part [g]; `None` where none would.
    pub apart_g: Option<f64>,
}

/// Why a load that the rows hold is not shown to be held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NotShown {
    /// It would be by the nominal spring, whose least output nobody states.
    Spring,
    /// It is while the elements of a linkage stay joined, and not if they part.
    Joined,
    /// No axis is stated, and the worst direction does not hold it.
    Axis,
}

/// What a static calculation needs of a lever.
#[derive(Debug, Clone, PartialEq)]
pub struct StaticLever {
    /// Name of the design.
    pub name: String,
    /// Preload torque T0 [N m].
    pub preload_torque_nm: f64,
    /// One standard deviation of it, where it is stated [N m].
    pub preload_deviation_nm: Option<f64>,
    /// Stiffness k0 [N m/rad].
    pub spring_stiffness_nm_per_rad: f64,
    /// One standard deviation of it, where it is stated [N m/rad].
    pub stiffness_deviation_nm_per_rad: Option<f64>,
    /// Mass m [kg] and arm L [m] of a single lever.
    pub mass_and_arm: Option<[f64; 2]>,
    /// What no latch has of it, a sentence each.
    pub implausible: Vec<String>,
    /// Unbalance m·L [kg m].
    pub unbalance_kg_m: f64,
    /// Limit angle φ* [rad].
    pub threshold_rad: f64,
    /// Keys that overrides gave another value, each with that and the one before.
    pub modified: Vec<String>,
    /// Numbers of the lever that count here and that the design leaves to the paper's example.
    pub not_stated: Vec<&'static str>,
    /// In which direction the unbalance moves as it opens, in the vehicle's axes.
    pub opening: Option<Vector>,
    /// Axis [-] and the way from the pivot to the centre of mass [m] of a single lever, where they are stated.
    pub axis_and_center: Option<[Vector; 2]>,
    /// From the pivot to the centre of mass, of a single lever with an axis.
    radial: Option<Vector>,
    /// The elements that it was reduced from.
    pub linkage: Vec<LinkageElement>,
    /// An inertia catch stands beside it, which is not counted.
    pub has_catch: bool,
}

/// Returns what no latch has of the elements of a linkage, a sentence each.
fn implausible_elements(linkage: &[LinkageElement]) -> Vec<String> {
    /// Largest mass of an element [kg] and largest distance of its centre of mass [m], as of a lever.
    const LARGEST: [f64; 2] = [5.0, 0.5];
    let of_each = linkage.iter().flat_map(|element| {
        let arm_m = element.arm_m.map(f64::abs);
        let distance_m = arm_m.or(element.center_of_mass.map(Vector::length));
        let numbers = [("mass", element.mass_kg, "kg"), ("arm", distance_m.unwrap_or(0.0), "m")];
        let beyond = numbers.into_iter().zip(LARGEST);
        let beyond = beyond.filter(|((_, value, _), largest)| value > largest);
        beyond.map(|((what, value, unit), largest)| {
            format!(
                "The {what} of element `{}` is {value} {unit}; an element of a latch has up to {largest} {unit}. Check \
                 the design file.",
                element.name
            )
        })
    });
    of_each.collect()
}

/// What a row asks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Direction {
    /// Forward.
    #[serde(rename = "+X")]
    Forward,
    /// Rearward.
    #[serde(rename = "-X")]
    Rearward,
    /// To the right.
    #[serde(rename = "+Y")]
    Right,
    /// To the left.
    #[serde(rename = "-Y")]
    Left,
    /// Downward.
    #[serde(rename = "+Z")]
    Down,
    /// Upward.
    #[serde(rename = "-Z")]
    Up,
    /// The worst in the horizontal plane.
    Plane,
    /// The worst of all.
    Space,
}

impl Direction {
    /// Every row, in the order of a page.
    pub const ALL: [Self; 8] = [
        Self::Forward,
        Self::Rearward,
        Self::Right,
        Self::Left,
        Self::Down,
        Self::Up,
        Self::Plane,
        Self::Space,
    ];

    /// Returns how it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Forward => "+X",
            Self::Rearward => "−X",
            Self::Right => "+Y",
            Self::Left => "−Y",
            Self::Down => "+Z",
            Self::Up => "−Z",
            Self::Plane => "worst in X-Y",
            Self::Space => "worst of all",
        }
    }

    /// Returns the clauses that its row answers for a door.
    pub fn clause(self, door: Door) -> &'static str {
        match (self, door) {
            (Self::Plane | Self::Space, _) => self.clause_of_any_direction(),
            (Self::Down | Self::Up, Door::Hinged | Door::Sliding) => {
                "none of a side door: back doors, 49 CFR 571.206 S4.1.1.4(c)"
            }
            (_, Door::Hinged) => {
                "49 CFR 571.206 S4.1.1.4(c), by calculation after S5.1.1.4(a); UN R11 6.1.4.1"
            }
            (_, Door::Sliding) => "49 CFR 571.206 S4.2.1.3(b); UN R11 6.2.3",
            (_, Door::Back) => "49 CFR 571.206 S4.1.1.4(c), by calculation after S5.1.1.4(a)",
        }
    }

    fn clause_of_any_direction(self) -> &'static str {
        match self {
            Self::Plane => "none by itself: an axis at 45° passes both axes and fails here",
            _ => "\"in any direction\": UN R11 Annex 4, 2.1.2; SAE J839",
        }
    }

    /// Returns the load of interior compartment doors in this direction [g].
    pub fn interior_g(self) -> Option<f64> {
        match self {
            Self::Forward | Self::Rearward => Some(REQUIRED_G),
            Self::Right | Self::Left | Self::Down | Self::Up => Some(REQUIRED_INTERIOR_G),
            Self::Plane | Self::Space => None,
        }
    }
}

/// The thresholds in one direction of the base's acceleration [g]; `None` where no size of it opens.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StaticRow {
    /// The direction.
    pub direction: Direction,
    /// The part of the acceleration that pushes the lever open, s [-].
    pub share: Option<f64>,
    /// Its part from the pivot to the centre of mass, r, which pushes the lever open once it has turned [-]; `None` of
    /// the worst direction, along the turned arm, and of a linkage.
    pub across: Option<f64>,
    /// Leaves its stop: T0/(m L).
    pub lift_off_g: Option<f64>,
    /// By SAE J839: the spring's average, (T0 + k0 φ*/2)/(m L).
    pub j839_g: Option<f64>,
    /// The same with gravity, where that pushes the lever open or its direction is not stated.
    pub j839_with_gravity_g: Option<f64>,
    /// Holds the lever at the limit angle, its arm turned with it.
    pub hold_g: Option<f64>,
    /// As a step, brings an undamped lever to the limit angle.
    pub step_g: Option<f64>,
    /// What counts: by J839, with gravity where that is told, or the step if that is less, which cannot be less than
    /// lifts the lever off.
    pub counts_g: Option<f64>,
    /// What counts if the elements of a linkage that are not pinned part; `None` where none would.
    pub apart_g: Option<f64>,
    /// What counts by the nominal spring.
    pub nominal_g: Option<f64>,
    /// `counts_g` over 30 g.
    pub margin: Option<f64>,
    /// `counts_g` over the load of interior doors in this direction.
    pub margin_interior: Option<f64>,
}

impl From<&Design> for StaticLever {
    fn from(design: &Design) -> Self {
        let lever = &design.lever;
        let directions = lever.directions();
        let reduced = Reduced::of(&design.linkage).ok();
        let vector = reduced.and_then(|reduced| reduced.unbalance_vector_kg_m);
        Self {
            name: design.name.clone(),
            preload_torque_nm: lever.preload_torque_nm,
            preload_deviation_nm: design.number("tolerance.preload_torque_nm"),
            spring_stiffness_nm_per_rad: lever.spring_stiffness_nm_per_rad,
            stiffness_deviation_nm_per_rad: design.number("tolerance.spring_stiffness_nm_per_rad"),
            mass_and_arm: design
                .linkage
                .is_empty()
                .then_some([lever.mass_kg, lever.center_of_mass_m]),
            implausible: implausible(design)
                .into_iter()
                .map(|finding| finding.text)
                .chain(implausible_elements(&design.linkage))
                .collect(),
            unbalance_kg_m: lever.unbalance_kg_m(),
            // A limit that was raised, or that no latch can bear, makes no latch of one that opens.
            threshold_rad: design.default_threshold_rad(),
            modified: modified(design),
            not_stated: not_stated(design),
            opening: vector
                .and_then(Vector::direction)
                .or(directions.map(|directions| directions.tangential)),
            axis_and_center: lever
                .axis
                .zip(lever.center_of_mass)
                .map(<[Vector; 2]>::from),
            radial: directions.map(|directions| directions.radial),
            linkage: design.linkage.clone(),
            has_catch: design.catch.is_some(),
        }
    }
}

/// Lists what overrides changed of a design.
fn modified(design: &Design) -> Vec<String> {
    let of_each = design.modified_from.iter().map(|(key, before)| {
        let now = design.number(key).unwrap_or(f64::NAN);
        format!("{key} {now} ({before})")
    });
    of_each.collect()
}

/// Names what a calculation rests on and the design does not state.
fn not_stated(design: &Design) -> Vec<&'static str> {
    const COUNTED: [&str; 4] = [
        "lever.preload_torque_nm",
        "lever.spring_stiffness_nm_per_rad",
        "lever.mass_kg",
        "lever.center_of_mass_m",
    ];
    let borrowed = |parameter: &&DesignParameter| {
        COUNTED.contains(&parameter.name)
            && (design.not_stated.iter()).any(|key| key == parameter.name)
            && !design.modified_from.contains_key(parameter.name)
    };
    let borrowed = PARAMETERS.iter().filter(borrowed);
    borrowed.map(|parameter| parameter.noun).collect()
}

impl StaticLever {
    /// Reduces a linkage, whose elements need no moment of inertia here.
    ///
    /// # Errors
    ///
    /// As [`Reduced::of`].
    pub fn of_linkage(
        name: String,
        threshold_rad: f64,
        linkage: Vec<LinkageElement>,
    ) -> Result<Self, Error> {
        let reduced = Reduced::of(&linkage)?;
        Ok(Self {
            name,
            preload_torque_nm: reduced.preload_torque_nm,
            preload_deviation_nm: None,
            spring_stiffness_nm_per_rad: reduced.spring_stiffness_nm_per_rad,
            stiffness_deviation_nm_per_rad: None,
            mass_and_arm: None,
            implausible: implausible_elements(&linkage),
            unbalance_kg_m: reduced.unbalance_kg_m.abs(),
            threshold_rad: threshold_rad.min(std::f64::consts::FRAC_PI_2),
            modified: Vec::new(),
            not_stated: Vec::new(),
            opening: reduced.unbalance_vector_kg_m.and_then(Vector::direction),
            axis_and_center: None,
            radial: None,
            linkage,
            has_catch: false,
        })
    }

    /// Returns the spring's average torque between closed and released [N m].
    pub fn averaged_torque_nm(&self) -> f64 {
        self.preload_torque_nm + 0.5 * self.spring_stiffness_nm_per_rad * self.threshold_rad
    }

    /// Returns the lever with the least output of its spring, where that is known: it is stated, or so many standard
    /// deviations below the nominal one. A stiffness whose scatter is not stated counts as none.
    pub fn with_least_spring(&self, question: &StaticQuestion) -> Option<Self> {
        let deviations = question.spring_deviations;
        let closed = match (question.spring_torque_min_nm, self.preload_deviation_nm) {
            (Some(least), _) => least,
            (None, Some(deviation)) => self.preload_torque_nm - deviations * deviation,
            (None, None) => return None,
        };
        // What is not stated of the stiffness adds nothing to the torque.
        let of_stiffness = self.stiffness_deviation_nm_per_rad;
        let stiffness = of_stiffness.map_or(0.0, |deviation| {
            self.spring_stiffness_nm_per_rad - deviations * deviation
        });
        Some(Self {
            preload_torque_nm: closed.max(0.0),
            spring_stiffness_nm_per_rad: stiffness.max(0.0),
            ..self.clone()
        })
    }

    /// Returns what each standard that is asked about is answered, by rows of [`Self::rows_at_least`].
    pub fn answers(
        question: &StaticQuestion,
        rows: &[StaticRow],
        is_stated: bool,
    ) -> Vec<StaticAnswer> {
        let asked = Standard::ALL.into_iter();
        let asked = asked.filter(|own| question.standard.is_none_or(|asked| asked == *own));
        asked
            .map(|standard| {
                let own = |row: &&StaticRow| standard.asks(row.direction, question.door);
                let mut own: Vec<&StaticRow> = rows.iter().filter(own).collect();
                if own.is_empty() {
                    // Without a stated direction the worst one answers for the axes.
                    own = rows.iter().collect();
                }
                let is_axis_stated = rows.len() > 1;
                let level = |row: &StaticRow| row.counts_g.map_or(f64::INFINITY, finite);
                let apart = own.iter().filter_map(|row| row.apart_g).map(finite);
                let apart_g = apart.reduce(f64::min);
                let worst = own
                    .into_iter()
                    .reduce(|a, b| if level(b) <= level(a) * TIE { b } else { a });
                let least = worst.map_or(f64::NEG_INFINITY, level);
                let holds = least >= REQUIRED_G;
                let not_shown = match holds {
                    true if apart_g.is_some_and(|apart| apart < REQUIRED_G) => {
                        Some(NotShown::Joined)
                    }
                    true if !is_stated => Some(NotShown::Spring),
                    false if standard == Standard::Fmvss206 && !is_axis_stated => {
                        Some(NotShown::Axis)
                    }
                    _ => None,
                };
                StaticAnswer {
                    standard,
                    holds: not_shown.is_none().then_some(holds),
                    not_shown,
                    apart_g,
                    opens_at_g: least.is_finite().then_some(least),
                    direction: worst.map_or(Direction::Space, |row| row.direction),
                }
            })
            .collect()
    }

    /// Returns the rows by the least output of the spring, or by its nominal one where no other is known.
    pub fn rows_at_least(&self, question: &StaticQuestion) -> Vec<StaticRow> {
        let least = self.with_least_spring(question);
        let mut rows = least.as_ref().unwrap_or(self).rows();
        for (row, nominal) in rows.iter_mut().zip(self.rows()) {
            row.nominal_g = nominal.counts_g;
        }
        rows
    }

    /// Returns the torque that is left under the required load in the worst direction, without gravity [N m].
    pub fn torque_left_nm(&self) -> f64 {
        self.averaged_torque_nm() - REQUIRED_G * STANDARD_GRAVITY * self.unbalance_kg_m
    }

    /// Returns the part of gravity that pushes the lever open [-], negative where it holds it shut.
    pub fn gravity_share(&self) -> Option<f64> {
        Some(self.opening?.0[2])
    }

    /// Returns every row that can be asked: one of a lever whose direction is not stated.
    pub fn rows(&self) -> Vec<StaticRow> {
        match self.opening {
            None => vec![self.row(Direction::Space, None)],
            Some(opening) => Direction::ALL
                .into_iter()
                .map(|direction| self.row(direction, Some(opening)))
                .collect(),
        }
    }

    /// Returns the row of the worst direction.
    pub fn worst(&self) -> StaticRow {
        self.row(Direction::Space, self.opening)
    }

    fn row(&self, direction: Direction, opening: Option<Vector>) -> StaticRow {
        let along = |direction: [f64; 3]| opening.map(|_| Vector(direction));
        // The base's acceleration pushes the lever the other way.
        let acceleration = match direction {
            Direction::Forward => along([1.0, 0.0, 0.0]),
            Direction::Rearward => along([-1.0, 0.0, 0.0]),
            Direction::Right => along([0.0, 1.0, 0.0]),
            Direction::Left => along([0.0, -1.0, 0.0]),
            Direction::Down => along([0.0, 0.0, 1.0]),
            Direction::Up => along([0.0, 0.0, -1.0]),
            Direction::Plane => {
                opening.and_then(|Vector([x, y, _])| Vector([-x, -y, 0.0]).direction())
            }
            Direction::Space => opening.map(|opening| opening.times(-1.0)),
        };
        let share = match (direction, acceleration, opening) {
            (Direction::Space, _, _) => Some(1.0),
            (_, Some(acceleration), Some(opening)) => Some(-acceleration.dot(opening)),
            _ => None,
        };
        // Rounding of a direction across the lever's way pushes nothing.
        let share = share.filter(|share| *share > 1e-12);
        let per_g = self.unbalance_kg_m * STANDARD_GRAVITY;
        let level = |torque: f64| share.map(|share| torque / (per_g * share));
        let lift_off_g = level(self.preload_torque_nm);
        let j839_g = level(self.averaged_torque_nm());
        // Without a stated direction gravity may push the lever open with all of it.
        let opens_by = self.gravity_share().or(Some(1.0));
        let opens_by = opens_by.filter(|gravity| *gravity > 1e-12);
        let j839_with_gravity_g = opens_by.and_then(|gravity| {
            let torque = self.averaged_torque_nm() - gravity * per_g;
            Some(level(torque)?.max(0.0))
        });
        let across = match (direction, acceleration, self.radial) {
            // The worst turns along with the lever.
            (Direction::Space, _, _) => None,
            (_, Some(acceleration), Some(radial)) => Some(acceleration.dot(radial)),
            _ => None,
        };
        let [hold_g, step_g] = match (direction, share) {
            (Direction::Space, _) => self.worst_hold_and_step(per_g),
            (_, Some(_)) if !self.linkage.is_empty() => [None, self.linkage_step(acceleration)],
            (_, Some(share)) => {
                across.map_or([None; 2], |across| self.hold_and_step(per_g, share, across))
            }
            _ => [None; 2],
        };
        // Along a direction fixed to the vehicle the arm may turn towards it, and a step opens sooner.
        let by_j839 = j839_with_gravity_g.or(j839_g);
        let step_opens_g = self.step_with_gravity_g(per_g, step_g, share, lift_off_g);
        // Elements by their arms turn by angles whose work is not told: what lifts them off counts.
        let is_by_arms = !self.linkage.is_empty() && opening.is_none();
        let step_opens_g = match is_by_arms {
            true => lift_off_g.map(|level| (level - opens_by.unwrap_or(0.0)).max(0.0)),
            false => step_opens_g,
        };
        let counts_g = match (by_j839, step_opens_g) {
            (Some(level), Some(step)) if step < level => Some(step),
            (level, _) => level,
        };
        StaticRow {
            direction,
            share,
            across: share.and(across),
            lift_off_g,
            j839_g,
            j839_with_gravity_g,
            hold_g,
            step_g,
            counts_g,
            apart_g: self.apart_g(direction, acceleration),
            nominal_g: counts_g,
            margin: counts_g.map(|counts| counts / REQUIRED_G),
            margin_interior: counts_g
                .zip(direction.interior_g())
                .map(|(counts, required)| counts / required),
        }
    }

    /// Returns the step that counts: with the work of gravity, where that pushes the lever open or its direction is not
    /// stated, and no less than lifts the lever off then.
    fn step_with_gravity_g(
        &self,
        per_g: f64,
        step_g: Option<f64>,
        share: Option<f64>,
        lift_off_g: Option<f64>,
    ) -> Option<f64> {
        let (step_g, share, lift_off_g) = (step_g?, share?, lift_off_g?);
        let (work, _) = self.work_and_torque();
        let along = self.gravity_share().unwrap_or(1.0);
        let across = self.radial.map_or(0.0, |Vector([_, _, down])| down);
        let (sine, cosine) = libm::sincos(self.threshold_rad);
        let pushed = match self.opening {
            Some(_) if !self.linkage.is_empty() => {
                self.linkage_moved_kg_m()?.0[2] / self.unbalance_kg_m
            }
            Some(_) => along * sine + across * (1.0 - cosine),
            // Along the arm that it turns to.
            None => 2.0 * libm::sin(0.5 * self.threshold_rad),
        };
        let of_gravity = per_g * pushed.max(0.0);
        let step = step_g * (1.0 - of_gravity / work).max(0.0);
        let lift_off = lift_off_g - along.max(0.0) / share;
        Some(step.max(lift_off).max(0.0))
    }

    /// Returns work up to the limit angle [J], and the torque there [N m].
    fn work_and_torque(&self) -> (f64, f64) {
        let (angle, stiffness) = (self.threshold_rad, self.spring_stiffness_nm_per_rad);
        let work = self.preload_torque_nm * angle + 0.5 * stiffness * angle * angle;
        (work, self.preload_torque_nm + stiffness * angle)
    }

    /// Returns the masses of a linkage times the ways of their centres at the limit angle, added up [kg m].
    fn linkage_moved_kg_m(&self) -> Option<Vector> {
        let moved = self.linkage.iter();
        let moved: Option<Vec<Vector>> = moved
            .map(|element| element.moved_kg_m(self.threshold_rad))
            .collect();
        Some(moved?.into_iter().fold(Vector::default(), Vector::plus))
    }

    /// Returns the step that brings a linkage to its limit angle: along `acceleration`, or in the worst direction.
    fn linkage_step(&self, acceleration: Option<Vector>) -> Option<f64> {
        let (work, _) = self.work_and_torque();
        let moved = self.linkage_moved_kg_m()?;
        let pushed = acceleration.map_or_else(|| moved.length(), |along| -along.dot(moved));
        (pushed > 1e-12 * moved.length()).then(|| work / (STANDARD_GRAVITY * pushed))
    }

    /// Returns what a row counts if the elements of a linkage that the acceleration presses shut part from the others,
    /// with their springs: by what stays, its spring's average, and gravity where that opens. The worst direction is
    /// looked for among those of each element, the axes, and 4000 others.
    fn apart_g(&self, direction: Direction, acceleration: Option<Vector>) -> Option<f64> {
        if self.linkage.is_empty() {
            return None;
        }
        let nominal = Reduced::of(&self.linkage).ok()?;
        let part = |counted: f64, nominal: f64| {
            if nominal > 0.0 {
                counted / nominal
            } else {
                0.0
            }
        };
        let of_torque = part(self.preload_torque_nm, nominal.preload_torque_nm);
        let of_stiffness = part(
            self.spring_stiffness_nm_per_rad,
            nominal.spring_stiffness_nm_per_rad,
        );
        let level = |along: Option<Vector>| {
            let staying = Reduced::staying(&self.linkage, along)?;
            if staying.unbalance_kg_m <= 0.0 {
                return None;
            }
            let torque = of_torque * staying.preload_torque_nm
                + 0.5 * of_stiffness * staying.spring_stiffness_nm_per_rad * self.threshold_rad;
            let of_gravity = match staying.unbalance_vector_kg_m {
                Some(Vector([_, _, down])) => down,
                None => staying.unbalance_kg_m,
            };
            let gravity = STANDARD_GRAVITY * of_gravity.max(0.0);
            Some(((torque - gravity) / (STANDARD_GRAVITY * staying.unbalance_kg_m)).max(0.0))
        };
        let Some(opening) = self.opening else {
            return level(None);
        };
        let tried: Vec<Vector> = match direction {
            Direction::Plane => (0..720)
                .map(|step| {
                    let (sine, cosine) =
                        libm::sincos(f64::from(step) * std::f64::consts::PI / 360.0);
                    Vector([cosine, sine, 0.0])
                })
                .collect(),
            Direction::Space => {
                let own = self.linkage.iter();
                let own =
                    own.filter_map(|element| element.reduced().unbalance_vector_kg_m?.direction());
                let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vector);
                let both = own
                    .chain(axes)
                    .chain([opening])
                    .flat_map(|along| [along, along.times(-1.0)]);
                both.chain(evenly(4000)).collect()
            }
            _ => acceleration.into_iter().collect(),
        };
        tried
            .into_iter()
            .filter_map(|along| level(Some(along)))
            .reduce(f64::min)
    }

    /// Returns hold and step in the direction that is worst for each: along the turned arm, and along the arm
    /// at half the limit angle. Of a linkage, whose elements turn by different angles, there is no hold, and a step
    /// where their axes are stated.
    fn worst_hold_and_step(&self, per_g: f64) -> [Option<f64>; 2] {
        if !self.linkage.is_empty() {
            return [None, self.linkage_step(None)];
        }
        let (work, torque) = self.work_and_torque();
        let arm = 2.0 * libm::sin(0.5 * self.threshold_rad);
        [Some(torque / per_g), Some(work / (per_g * arm))]
    }

    /// Returns hold and step along a direction fixed to the vehicle, of which `share` pushes the lever open and
    /// `across` points from the pivot to the centre of mass.
    fn hold_and_step(&self, per_g: f64, share: f64, across: f64) -> [Option<f64>; 2] {
        let (work, torque) = self.work_and_torque();
        let (sine, cosine) = libm::sincos(self.threshold_rad);
        let at_limit = share * cosine + across * sine;
        let over_way = share * sine + across * (1.0 - cosine);
        let level = |needed: f64, pushed: f64| (pushed > 1e-12).then(|| needed / (per_g * pushed));
        [level(torque, at_limit), level(work, over_way)]
    }
}

/// Returns so many directions, evenly over the sphere (the spiral of Fibonacci).
fn evenly(count: u32) -> impl Iterator<Item = Vector> {
    /// The golden angle [rad].
    const GOLDEN: f64 = 2.399_963_229_728_653;
    (0..count).map(move |index| {
        let height = 1.0 - (2.0 * f64::from(index) + 1.0) / f64::from(count);
        let (sine, cosine) = libm::sincos(GOLDEN * f64::from(index));
        let radius = libm::sqrt(1.0 - height * height);
        Vector([radius * cosine, radius * sine, height])
    })
}

/// Levels this close are one: the row of the worst direction is named.
const TIE: f64 = 1.0 + 1e-9;

/// The number, or one that holds nothing in place of what is none or too large for one.
fn finite(value: f64) -> f64 {
    if value.is_finite() {
        value
    } else {
        f64::NEG_INFINITY
    }
}
