//! Attractor that a lever reaches from each initial state.
//!
//! The attractors are found first, from a coarse grid followed to the end. Then every cell is followed
//! until it rests or is captured by a known orbit: it comes within the radius from which rings of states
//! around each of the orbit's points converged. A cell that does neither is followed to the end and may
//! add an attractor.

use super::Headline;
use super::orbit::{self, ForcedLever, Orbit};
use latchgate_kernel::parallel::Control;
use latchgate_kernel::range::Range;
use latchgate_kernel::replay::strobe_batch::{self, Ending};
use latchgate_kernel::replay::{Section, State, Strobe};
use latchgate_recording::error::Error;
use serde::Serialize;
use std::sync::atomic::{AtomicBool, Ordering};

/// Options of the basins on one stop.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Options {
    /// Lever, stop, frequency.
    #[serde(flatten)]
    pub forced: ForcedLever,
    /// Amplitude [g].
    pub amplitude_g: f64,
    /// Initial angles [rad].
    pub angle_rad: Range,
    /// Initial angular velocities [rad/s].
    pub velocity_rad_s: Range,
    /// Cells along angle and velocity; a cell stands for its midpoint.
    pub grid: (u32, u32),
    /// Periods after which the motion counts as settled.
    pub transient: u32,
}

/// A final motion of the lever.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BasinAttractor {
    /// Number, as in the rows.
    pub index: u32,
    /// Roman numeral and kind, for people.
    pub name: String,
    /// Period, in periods of the excitation; 0 for one that is not periodic.
    pub period: u32,
    /// State at the start of each period.
    pub points: Vec<State>,
    /// Largest angle [rad].
    pub peak_angle_rad: f64,
    /// Share of the cells [-]; `None` if the work was stopped before all were known.
    pub share: Option<f64>,
    /// Standard error of the share as an estimate of the area, from pairs of neighbouring cells [-].
    pub standard_error: Option<f64>,
    /// Distance from its points within which a lever is captured, in the measure that shrinks from period
    /// to period [rad].
    pub capture_radius_rad: f64,
    /// For each point, the matrix from a difference (angle, velocity over ω) to coordinates in which the
    /// measure is a circle, row by row.
    #[serde(skip)]
    measures: Vec<[[f64; 2]; 2]>,
}

impl BasinAttractor {
    /// Returns the distance of a state from one of the points [rad].
    fn distance(&self, forced: &ForcedLever, index: usize, state: State) -> f64 {
        let (x, velocity) = (state - self.points[index]).into();
        let y = velocity / forced.angular_frequency_rad_s;
        let [[a, b], [c, d]] = self.measures[index];
        libm::hypot(a * x + b * y, c * x + d * y)
    }

    fn near(&self, forced: &ForcedLever, state: State) -> bool {
        (0..self.points.len())
            .any(|index| self.distance(forced, index, state) <= self.capture_radius_rad)
    }
}

/// One cell.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Row {
    /// Initial angle [rad].
    pub angle_rad: f64,
    /// Initial angular velocity [rad/s].
    pub angular_velocity_rad_s: f64,
    /// Number of the attractor reached.
    pub attractor: u32,
}

/// Result of the study.
#[derive(Debug, Clone, PartialEq)]
pub struct Basins {
    /// Options of the study.
    pub options: Options,
    /// The attractors, rest first, then by their largest angle.
    pub attractors: Vec<BasinAttractor>,
    /// Attractor of each cell, the angle running fastest; `None` for cells that were not reached before a stop.
    pub cells: Vec<Option<u32>>,
    /// The cells with each one at a boundary cut into four, for drawing; twice as many along either side.
    /// Empty for a grid that is fine already, and if the work was stopped.
    pub fine: Vec<Option<u32>>,
    /// Share of cells with a neighbour in another basin [-]; `None` if the work was stopped before all
    /// were known.
    pub boundary_share: Option<f64>,
    /// Exponent α with which the boundary share falls with the size of a cell; the boundary's dimension
    /// is 2 − α.
    ///
    /// # Source
    ///
    /// McDonald, Grebogi, Ott and Yorke, Physica D 17 (1985) 125.
    pub uncertainty_exponent: Option<f64>,
    /// True if the work was not stopped.
    pub complete: bool,
}

/// Distance below which two states are the same [rad].
const SAME: f64 = 1e-6;

/// Cells along either side of the grid that finds the attractors.
const COARSE: u32 = 20;

/// Largest radius of capture [rad].
const CAPTURE_MAX: f64 = 0.1;

/// Longest period sought.
const PERIOD_MAX: usize = 32;

/// Final motion of one lever.
#[derive(Debug, Clone, PartialEq)]
enum FinalMotion {
    Rest,
    Orbit(Vec<State>, f64),
    Irregular(f64),
}

/// Returns the attractor that a lever has certainly reached.
fn caught(forced: &ForcedLever, attractors: &[BasinAttractor], section: &Section) -> Option<u32> {
    let (angle, velocity) = (section.angle_rad, section.velocity_rad_s);
    attractors
        .iter()
        .find(|attractor| {
            if attractor.period > 0 && attractor.peak_angle_rad <= REST_ANGLE_RAD {
                // No impact in a whole period, and on the stop or in it at its end.
                section.impacts == 0 && angle <= 0.0 && (angle < 0.0 || velocity <= 0.0)
            } else {
                attractor.near(forced, section.state())
            }
        })
        .map(|attractor| attractor.index)
}

/// Largest angle of a lever that rests on its stop [rad].
const REST_ANGLE_RAD: f64 = 1e-9;

fn rests(section: &Section) -> bool {
    section.impacts == 0 && section.peak_angle_rad <= REST_ANGLE_RAD
}

/// Follows a lever from `state` to its final motion.
fn follow(options: &Options, state: State) -> Result<FinalMotion, Error> {
    let mut strobe = options.forced.strobe(options.amplitude_g, Some(state))?;
    let mut resting = 0;
    for _ in 0..options.transient {
        let Some(section) = strobe.advance() else {
            return Ok(FinalMotion::Irregular(f64::NAN));
        };
        resting = if rests(&section) { resting + 1 } else { 0 };
        if resting >= 2 {
            return Ok(FinalMotion::Rest);
        }
    }
    settled(options, &mut strobe)
}

fn settled(options: &Options, strobe: &mut Strobe) -> Result<FinalMotion, Error> {
    let mut sections = Vec::with_capacity(3 * PERIOD_MAX);
    for _ in 0..3 * PERIOD_MAX {
        let Some(section) = strobe.advance() else {
            return Ok(FinalMotion::Irregular(f64::NAN));
        };
        sections.push(section);
    }
    let peak = sections
        .iter()
        .map(|section| section.peak_angle_rad)
        .fold(f64::NEG_INFINITY, f64::max);
    let Some(period) = orbit::period_of(&options.forced, &sections, SAME) else {
        return Ok(FinalMotion::Irregular(peak));
    };
    let start = sections[sections.len() - 1].state();
    let points = orbit::find(&options.forced, options.amplitude_g, period, start).map_or_else(
        || {
            sections[sections.len() - period as usize..]
                .iter()
                .map(Section::state)
                .collect()
        },
        |Orbit { points, .. }| points,
    );
    Ok(FinalMotion::Orbit(points, peak))
}

/// Finds the attractors and the basins.
///
/// # Errors
///
/// As [`Strobe::new`].
pub fn run(options: &Options, control: &Control<'_>) -> Result<Basins, Error> {
    let coarse = Options {
        grid: (options.grid.0.min(COARSE), options.grid.1.min(COARSE)),
        ..options.clone()
    };
    let quiet = Control {
        threads: control.threads,
        proceed: &|_| (control.proceed)(None),
    };
    let ends: Vec<FinalMotion> = quiet
        .map(count(coarse.grid), |index| {
            follow(options, midpoint(&coarse, index))
        })
        .into_iter()
        .flatten()
        .collect::<Result<_, _>>()?;
    let mut attractors = Vec::new();
    for end in ends {
        admit(options, &mut attractors, end);
    }
    for attractor in &mut attractors {
        attractor.measures = measures(options, attractor);
        attractor.capture_radius_rad = capture_radius(options, attractor, &quiet)?;
    }
    let (cells, complete) = classify(options, &mut attractors, control)?;
    let mut basins = Basins {
        options: options.clone(),
        attractors,
        cells,
        fine: Vec::new(),
        boundary_share: None,
        uncertainty_exponent: None,
        complete,
    };
    basins.order();
    if complete {
        basins.measure(control)?;
    }
    Ok(basins)
}

fn count(grid: (u32, u32)) -> usize {
    grid.0 as usize * grid.1 as usize
}

fn midpoint(options: &Options, index: usize) -> State {
    let columns = options.grid.0 as usize;
    let midpoint_value = |place: usize, cells: u32, range: Range| {
        range.low + range.width() * (place as f64 + 0.5) / f64::from(cells)
    };
    State::new(
        midpoint_value(index % columns, options.grid.0, options.angle_rad),
        midpoint_value(index / columns, options.grid.1, options.velocity_rad_s),
    )
}

/// Returns the number of the attractor with the motion `end`; adds it if it is new.
fn admit(options: &Options, attractors: &mut Vec<BasinAttractor>, end: FinalMotion) -> u32 {
    let (period, points, peak) = match end {
        FinalMotion::Rest => (1, vec![State::new(0.0, 0.0)], 0.0),
        FinalMotion::Orbit(points, peak) => {
            (u32::try_from(points.len()).unwrap_or(0), points, peak)
        }
        FinalMotion::Irregular(peak) => (0, Vec::new(), peak),
    };
    let same = |attractor: &BasinAttractor| {
        attractor.period == period
            && (period == 0
                || attractor
                    .points
                    .iter()
                    .any(|point| options.forced.distance(*point, points[0]) <= 100.0 * SAME))
    };
    if let Some(attractor) = attractors.iter().find(|attractor| same(attractor)) {
        return attractor.index;
    }
    let index = u32::try_from(attractors.len()).unwrap_or(u32::MAX);
    attractors.push(BasinAttractor {
        index,
        name: String::new(),
        period,
        points,
        peak_angle_rad: peak,
        share: None,
        standard_error: None,
        capture_radius_rad: 0.0,
        measures: Vec::new(),
    });
    index
}

/// Returns for each point of an orbit the matrix from differences to the coordinates of the eigenvectors of the
/// map round the orbit, in which the map only turns and shrinks.
fn measures(options: &Options, attractor: &BasinAttractor) -> Vec<[[f64; 2]; 2]> {
    const ROUND: [[f64; 2]; 2] = [[1.0, 0.0], [0.0, 1.0]];
    let forced = &options.forced;
    let around = |point: &State| {
        let mut strobe = forced.strobe(options.amplitude_g, Some(*point)).ok()?;
        strobe.start_map();
        for _ in 0..attractor.period {
            strobe.advance()?;
        }
        let [[a, b], [c, d]] = strobe.map()?.by_state;
        let omega = forced.angular_frequency_rad_s;
        eigenvectors([[a, b * omega], [c / omega, d]])
    };
    attractor
        .points
        .iter()
        .map(|point| around(point).unwrap_or(ROUND))
        .collect()
}

/// Returns the inverse of the matrix of eigenvectors, or of real and imaginary part of a complex one, scaled to
/// keep areas; `None` if the vectors are nearly parallel.
fn eigenvectors([[a, b], [c, d]]: [[f64; 2]; 2]) -> Option<[[f64; 2]; 2]> {
    /// Bound on the stretch of a measure, as norm² over determinant.
    const STRETCH_MAX: f64 = 20.0;
    let (half, discriminant) = (0.5 * (a + d), 0.25 * (a - d) * (a - d) + b * c);
    let root = discriminant.abs().sqrt();
    let columns = if discriminant < 0.0 {
        // (b, λ − a) with λ = half + i root.
        [[b, 0.0], [half - a, root]]
    } else {
        let vector = |value: f64| {
            let (x, y) = if b.abs() > c.abs() {
                (b, value - a)
            } else {
                (value - d, c)
            };
            let length = libm::hypot(x, y);
            [x / length, y / length]
        };
        let (first, second) = (vector(half + root), vector(half - root));
        [[first[0], second[0]], [first[1], second[1]]]
    };
    let [[a, b], [c, d]] = columns;
    let determinant = a * d - b * c;
    let scale = determinant.abs().sqrt();
    let norm = a * a + b * b + c * c + d * d;
    (determinant.abs() > 0.0 && norm <= STRETCH_MAX * determinant.abs()).then(|| {
        let factor = scale / determinant;
        [[d * factor, -b * factor], [-c * factor, a * factor]]
    })
}

/// Returns the largest radius tried from which a disk of states around each point of the orbit
/// converges to it.
fn capture_radius(
    options: &Options,
    attractor: &BasinAttractor,
    control: &Control<'_>,
) -> Result<f64, Error> {
    /// States on a ring.
    const RING: usize = 64;
    /// Radii of rings.
    const RINGS: [f64; 6] = [1.0, 0.85, 0.7, 0.5, 0.3, 0.15];
    /// Ratio of one radius to the one tried before.
    const SHRINK: f64 = 0.8;
    if attractor.period == 0 || attractor.peak_angle_rad <= REST_ANGLE_RAD {
        return Ok(0.0);
    }
    let forced = &options.forced;
    let mut radius = CAPTURE_MAX;
    while radius > SAME {
        let states: Vec<State> = (0..attractor.points.len())
            .flat_map(|index| {
                let point = attractor.points[index];
                let [[a, b], [c, d]] = attractor.measures[index];
                // The measures keep areas, so their determinant is ±1 and the sign is all that the inverse divides by.
                let sign = (a * d - b * c).signum();
                RINGS.iter().flat_map(move |part| {
                    (0..RING).map(move |step| {
                        let turn = std::f64::consts::TAU * step as f64 / RING as f64;
                        let (sine, cosine) = libm::sincos(turn);
                        let (x, y) = (part * radius * cosine, part * radius * sine);
                        State::new(
                            point.angle_rad + sign * (d * x - b * y),
                            point.velocity_rad_s
                                + sign * (a * y - c * x) * forced.angular_frequency_rad_s,
                        )
                    })
                })
            })
            .filter(|state| forced.stop.yields() || state.angle_rad >= 0.0)
            .collect();
        if all_converge(options, attractor, &states, control)? {
            return Ok(radius);
        }
        radius *= SHRINK;
    }
    Ok(SAME)
}

/// Returns true if the lever converges to the orbit from each of `states`.
fn all_converge(
    options: &Options,
    attractor: &BasinAttractor,
    states: &[State],
    control: &Control<'_>,
) -> Result<bool, Error> {
    let forced = &options.forced;
    let arrived = |section: &Section| {
        let state = section.state();
        (0..attractor.points.len()).any(|index| attractor.distance(forced, index, state) <= SAME)
    };
    let failed = AtomicBool::new(false);
    let strayed = |section: &Section| {
        // A lever that rests has not converged to a moving orbit; once one has failed the others can end.
        failed.load(Ordering::Relaxed) || rests(section)
    };
    let followed = strobe_batch::follow(
        &forced.design,
        states.len(),
        &|index| forced.start(Some(states[index]), options.amplitude_g),
        &forced.batch(options.transient, 1, true, control.threads),
        &|_, _, section| {
            let arrived = arrived(section);
            if !arrived && strayed(section) {
                failed.store(true, Ordering::Relaxed);
                return true;
            }
            arrived
        },
        None,
    )?;
    Ok(followed
        .iter()
        .all(|lever| lever.sections.last().is_some_and(arrived)))
}

/// Returns the attractor of each cell; false if the work was stopped.
fn classify(
    options: &Options,
    attractors: &mut Vec<BasinAttractor>,
    control: &Control<'_>,
) -> Result<(Vec<Option<u32>>, bool), Error> {
    let states: Vec<State> = (0..count(options.grid))
        .map(|index| midpoint(options, index))
        .collect();
    reach(options, attractors, &states, control)
}

/// Returns the attractor that each of `states` reaches; false if the work was stopped.
fn reach(
    options: &Options,
    attractors: &mut Vec<BasinAttractor>,
    states: &[State],
    control: &Control<'_>,
) -> Result<(Vec<Option<u32>>, bool), Error> {
    let forced = &options.forced;
    let attractors_before: &[BasinAttractor] = attractors;
    let watch = |done: usize| (control.proceed)(Some(done as f64 / states.len() as f64));
    let followed = strobe_batch::follow(
        &forced.design,
        states.len(),
        &|index| forced.start(Some(states[index]), options.amplitude_g),
        &forced.batch(options.transient, 1, false, control.threads),
        &|_, _, section| caught(forced, attractors_before, section).is_some(),
        Some(&watch),
    )?;
    let mut cells = vec![None; states.len()];
    let mut unknown = Vec::new();
    for lever in &followed {
        let last = lever.sections.last();
        match last.and_then(|section| caught(forced, attractors_before, section)) {
            Some(index) if lever.ending == Ending::Done => cells[lever.index] = Some(index),
            _ => unknown.push(lever.index),
        }
    }
    // If no motion settles these are all cells, so this work is parallel and stoppable too.
    let ends = control.map(unknown.len(), |nth| follow(options, states[unknown[nth]]));
    for (index, end) in unknown.into_iter().zip(ends) {
        if let Some(end) = end {
            cells[index] = Some(admit(options, attractors, end?));
        }
    }
    let complete = cells.iter().all(Option::is_some);
    Ok((cells, complete))
}

/// Largest number of cells along a side of a grid whose boundary cells are cut into four. A picture shows at most
/// twice as many.
const REFINED_MAX: usize = 450;

/// Directions of the quarters of a cell from its midpoint.
const QUARTERS: [(f64, f64); 4] = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];

/// Counts the cells at a boundary.
fn boundary_count(cells: &[Option<u32>], size: (usize, usize)) -> f64 {
    let indices = 0..cells.len();
    indices
        .filter(|index| at_boundary(cells, size, *index))
        .count() as f64
}

/// Returns true if one of the four neighbours of a cell lies in another basin.
fn at_boundary(cells: &[Option<u32>], (columns, rows): (usize, usize), index: usize) -> bool {
    let (column, row) = (index % columns, index / columns);
    let differs = |neighbour: usize| cells[neighbour] != cells[index];
    (column > 0 && differs(index - 1))
        || (column + 1 < columns && differs(index + 1))
        || (row > 0 && differs(index - columns))
        || (row + 1 < rows && differs(index + columns))
}

impl Basins {
    /// Sorts the attractors by their largest angle, rest first, and names them.
    fn order(&mut self) {
        let mut order: Vec<usize> = (0..self.attractors.len()).collect();
        order.sort_by(|a, b| {
            let peak = |n: usize| self.attractors[n].peak_angle_rad;
            peak(*a).total_cmp(&peak(*b))
        });
        let mut renumbered = vec![0; order.len()];
        let mut attractors = Vec::with_capacity(order.len());
        for (new, old) in order.into_iter().enumerate() {
            let index = u32::try_from(new).unwrap_or(u32::MAX);
            renumbered[old] = index;
            let mut attractor = self.attractors[old].clone();
            attractor.index = index;
            let kind = if attractor.period == 0 {
                "not periodic".to_string()
            } else if attractor.peak_angle_rad <= REST_ANGLE_RAD {
                "rest".to_string()
            } else {
                format!("period {}", attractor.period)
            };
            attractor.name = format!("{} ({kind})", roman(new + 1));
            attractors.push(attractor);
        }
        self.attractors = attractors;
        for cell in self.cells.iter_mut().flatten() {
            *cell = renumbered[*cell as usize];
        }
    }

    /// Counts the share of each attractor.
    fn measure_shares(&mut self) {
        let (total, columns) = (self.cells.len() as f64, self.options.grid.0 as usize);
        for attractor in &mut self.attractors {
            let reaches_attractor = |cell: &Option<u32>| *cell == Some(attractor.index);
            attractor.share = Some(
                self.cells
                    .iter()
                    .filter(|cell| reaches_attractor(cell))
                    .count() as f64
                    / total,
            );
            let differing = self
                .cells
                .chunks(columns)
                .flat_map(|line| line.chunks_exact(2))
                .filter(|pair| reaches_attractor(&pair[0]) != reaches_attractor(&pair[1]))
                .count() as f64;
            attractor.standard_error = Some(differing.sqrt() / total);
        }
    }

    /// Counts the shares, and cuts the cells at a boundary into four.
    fn measure(&mut self, control: &Control<'_>) -> Result<(), Error> {
        let total = self.cells.len() as f64;
        let (columns, rows) = (self.options.grid.0 as usize, self.options.grid.1 as usize);
        self.measure_shares();
        let boundary: Vec<usize> = (0..self.cells.len())
            .filter(|index| at_boundary(&self.cells, (columns, rows), *index))
            .collect();
        let boundary_share = boundary.len() as f64 / total;
        self.boundary_share = Some(boundary_share);
        if columns.max(rows) > REFINED_MAX {
            let coarse: Vec<Option<u32>> = (0..rows / 2)
                .flat_map(|row| (0..columns / 2).map(move |column| 2 * (row * columns + column)))
                .map(|index| self.cells[index])
                .collect();
            let share =
                boundary_count(&coarse, (columns / 2, rows / 2)) / coarse.len().max(1) as f64;
            self.uncertainty_exponent =
                (boundary_share > 0.0).then(|| libm::log2(share / boundary_share));
            return Ok(());
        }
        let (quarter_angle, quarter_velocity) = (
            0.25 * self.options.angle_rad.width() / columns as f64,
            0.25 * self.options.velocity_rad_s.width() / rows as f64,
        );
        let states: Vec<State> = boundary
            .iter()
            .flat_map(|index| {
                let (angle, velocity) = midpoint(&self.options, *index).into();
                QUARTERS.map(|(x, y)| {
                    State::new(angle + x * quarter_angle, velocity + y * quarter_velocity)
                })
            })
            .collect();
        let listed = self.attractors.len();
        let (parts, complete) = reach(&self.options, &mut self.attractors, &states, control)?;
        // The list is that of the whole cells; attractors that only a quarter reaches are dropped.
        self.attractors.truncate(listed);
        self.complete = complete;
        if !complete {
            return Ok(());
        }
        let mut fine: Vec<Option<u32>> = (0..4 * self.cells.len())
            .map(|index| {
                let (column, row) = (index % (2 * columns), index / (2 * columns));
                self.cells[row / 2 * columns + column / 2]
            })
            .collect();
        for (cell, four) in boundary.iter().zip(parts.chunks(4)) {
            let (column, row) = (cell % columns, cell / columns);
            for ((x, y), part) in QUARTERS.iter().zip(four) {
                let column = 2 * column + usize::from(*x > 0.0);
                let row = 2 * row + usize::from(*y > 0.0);
                fine[row * 2 * columns + column] = part.filter(|part| (*part as usize) < listed);
            }
        }
        let finer = boundary_count(&fine, (2 * columns, 2 * rows)) / (4.0 * total);
        self.uncertainty_exponent = (finer > 0.0).then(|| libm::log2(boundary_share / finer));
        self.fine = fine;
        Ok(())
    }

    /// Returns the cells as rows.
    pub fn rows(&self) -> Vec<Row> {
        self.cells
            .iter()
            .enumerate()
            .filter_map(|(index, cell)| {
                let midpoint = midpoint(&self.options, index);
                cell.map(|attractor| Row {
                    angle_rad: midpoint.angle_rad,
                    angular_velocity_rad_s: midpoint.velocity_rad_s,
                    attractor,
                })
            })
            .collect()
    }

    /// Returns the headline figures.
    pub fn headlines(&self) -> Vec<Headline> {
        let forced = &self.options.forced;
        let subject = format!(
            "A = {} g, ω = {} rad/s",
            self.options.amplitude_g, forced.angular_frequency_rad_s
        );
        let mut lines = Vec::new();
        let mut say = |what: String, value: Option<f64>| {
            lines.push(Headline {
                digits: Headline::DIGITS,
                subject: subject.clone(),
                model: Some(forced.stop),
                what,
                value,
            });
        };
        for attractor in &self.attractors {
            let name = &attractor.name;
            say(
                format!("{name}: largest angle [rad]"),
                Some(attractor.peak_angle_rad),
            );
            say(format!("{name}: share of the cells [-]"), attractor.share);
            say(
                format!("{name}: its standard error [-]"),
                attractor.standard_error,
            );
        }
        say("cells at a boundary [-]".into(), self.boundary_share);
        if let Some(exponent) = self.uncertainty_exponent {
            say(
                "uncertainty exponent of the boundary, at this size of cells [-]".into(),
                Some(exponent),
            );
        }
        lines
    }
}

/// Returns a number in Roman numerals.
fn roman(number: usize) -> String {
    const NUMERALS: [(usize, &str); 9] = [
        (100, "C"),
        (90, "XC"),
        (50, "L"),
        (40, "XL"),
        (10, "X"),
        (9, "IX"),
        (5, "V"),
        (4, "IV"),
        (1, "I"),
    ];
    let mut remainder = number;
    let mut out = String::new();
    for (value, numeral) in NUMERALS {
        while remainder >= value {
            out.push_str(numeral);
            remainder -= value;
        }
    }
    out
}
