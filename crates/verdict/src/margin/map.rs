//! A map of the peak angle over two design keys, with the boundary of the pass.
//!
//! The request, the grid and the boundary share one geometry: the boundary is followed through the
//! cells of the grid, and its crossings are exact runs between two of its values.

use super::quantity::with_restitution;
use super::runs::{LeverTrial, NominalRuns};
use super::search::{self, Edge, Excess, Probe};
use latchgate_kernel::model::Design;
use latchgate_recording::error::Error;
use serde::{Deserialize, Serialize};

/// One axis of a map: a design key and its range.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MapAxis {
    /// Design key, for example `lever.preload_torque_nm`.
    pub key: String,
    /// Least value, in the key's unit.
    pub low: f64,
    /// Greatest value.
    pub high: f64,
}

impl MapAxis {
    /// Returns value `index` of `count` evenly spaced ones.
    #[must_use]
    pub fn value(&self, index: usize, count: usize) -> f64 {
        if index + 1 == count {
            return self.high;
        }
        self.low + (self.high - self.low) * index as f64 / (count - 1) as f64
    }
}

/// Options of one map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MapRequest {
    /// To the right.
    pub x: MapAxis,
    /// Upwards.
    pub y: MapAxis,
    /// Values of `x`.
    pub columns: usize,
    /// Values of `y`.
    pub rows: usize,
}

impl MapRequest {
    /// Checks that both keys can be varied over their ranges.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::UnknownName`] for a key that no design has,
    /// [`OutOfRange`](latchgate_kernel::error::Error::OutOfRange) for one that moves no nominal run, for two equal
    /// keys, for a range that does not ascend or whose ends the key cannot take, and for a grid of
    /// fewer than 2 or more than [`GRID_MAX`] values a side.
    pub fn check(&self, design: &Design) -> Result<(), Error> {
        let refuse = |expected: &str, found: String| {
            Err(Error::out_of_range(
                latchgate_recording::setting::Setting::Map.to_string(),
                expected,
                found,
            ))
        };
        for axis in [&self.x, &self.y] {
            let moves_a_run = ["lever.", "stop.", "criterion."]
                .iter()
                .any(|section| axis.key.starts_with(section));
            let mut trial = design.clone();
            for value in [axis.low, axis.high] {
                trial.override_number(axis.key.trim(), value)?;
            }
            if !moves_a_run {
                return refuse(
                    "a key of [lever], [stop] or [criterion], which move a nominal run",
                    axis.key.clone(),
                );
            }
            if axis.low >= axis.high || axis.low.is_nan() || axis.high.is_nan() {
                return refuse(
                    "LO below HI",
                    format!("{}={}..{}", axis.key, axis.low, axis.high),
                );
            }
        }
        if self.x.key == self.y.key {
            return refuse("two different keys", self.x.key.clone());
        }
        for count in [self.columns, self.rows] {
            if !(2..=GRID_MAX).contains(&count) {
                return refuse(&format!("2 to {GRID_MAX} values a side"), count.to_string());
            }
        }
        Ok(())
    }
}

/// Most values of a map's side.
pub const GRID_MAX: usize = 400;

/// A point of the boundary of the pass, on a line of the grid.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MapVertex {
    /// Value of the first key.
    pub x: f64,
    /// Value of the second.
    pub y: f64,
    /// Ends of the bracket, on the axis of the grid's line.
    pub bracket: (f64, f64),
    /// The bracket lies along the first key.
    pub along_x: bool,
}

/// The map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Map {
    /// Its options.
    #[serde(flatten)]
    pub request: MapRequest,
    /// Largest angle of window and coast, of the stops and polarities that count [rad]; rows from
    /// the least `y`, each from the least `x`. `None` where no lever can have both values, or
    /// none could be followed.
    #[serde(skip)]
    pub peaks_rad: Vec<Option<f64>>,
    /// Those that are a pass.
    #[serde(skip)]
    pub passes: Vec<Option<bool>>,
    /// Points of the boundary of the pass.
    #[serde(skip)]
    pub vertices: Vec<MapVertex>,
    /// Pairs of points that are joined.
    #[serde(skip)]
    pub segments: Vec<(usize, usize)>,
    /// The present values of both keys.
    pub present: Option<(f64, f64)>,
    /// Grid values that pass, of those that could be judged.
    pub passing: usize,
    /// Grid values that could be judged.
    pub judged: usize,
    /// Number of points of the boundary.
    pub boundary_points: usize,
}

/// A line between neighbouring grid values: the lower left one, and whether it runs along x.
type GridSide = (usize, usize, bool);

/// Replays every grid value and draws the boundary of the pass between them.
///
/// The boundary crosses a side of a cell where its ends differ; the crossing is narrowed down by
/// exact runs to 1e-9 of the range. A boundary that enters and leaves a cell through one side is
/// not seen.
pub(super) fn map(
    runs: &NominalRuns<'_>,
    design: &Design,
    request: &MapRequest,
) -> Result<Map, Error> {
    let field = PeakField {
        runs,
        design,
        request,
    };
    let mut values = field.scan()?;
    field.settle(&mut values)?;
    let mut outline = Outline {
        known: vec![None; 2 * request.columns * request.rows],
        ..Outline::default()
    };
    for row in 0..request.rows - 1 {
        for column in 0..request.columns - 1 {
            outline.take(&field, &values, column, row)?;
        }
    }
    let passes: Vec<Option<bool>> = values
        .iter()
        .map(|excess| excess.map(|excess| excess.pass <= 0.0))
        .collect();
    Ok(Map {
        request: request.clone(),
        present: present(design, &request.x.key).zip(present(design, &request.y.key)),
        peaks_rad: field.peaks_rad(&values),
        passing: passes.iter().filter(|pass| **pass == Some(true)).count(),
        judged: passes.iter().flatten().count(),
        passes,
        boundary_points: outline.vertices.len(),
        vertices: outline.vertices,
        segments: outline.segments,
    })
}

/// The boundary of the pass, as far as cells have been looked at.
#[derive(Default)]
struct Outline {
    vertices: Vec<MapVertex>,
    /// The vertex on each side that the boundary crosses, which two cells share.
    known: Vec<Option<usize>>,
    segments: Vec<(usize, usize)>,
}

impl Outline {
    /// Adds the part of the boundary inside one cell.
    fn take(
        &mut self,
        field: &PeakField<'_>,
        values: &[Option<Excess>],
        column: usize,
        row: usize,
    ) -> Result<(), Error> {
        // Sides of the cell: bottom, right, top, left.
        let sides: [GridSide; 4] = [
            (column, row, true),
            (column + 1, row, false),
            (column, row + 1, true),
            (column, row, false),
        ];
        let mut crossed = Vec::new();
        for side in sides {
            if field.differs(values, side) {
                crossed.push(self.vertex(field, values, side)?);
            }
        }
        match crossed.as_slice() {
            [a, b] => self.segments.push((*a, *b)),
            [bottom, right, top, left] => {
                let corner = values[row * field.request.columns + column];
                self.segments.extend(if field.joined(column, row, corner)? {
                    [(*bottom, *right), (*top, *left)]
                } else {
                    [(*left, *bottom), (*right, *top)]
                });
            }
            _ => {}
        }
        Ok(())
    }

    fn vertex(
        &mut self,
        field: &PeakField<'_>,
        values: &[Option<Excess>],
        side: GridSide,
    ) -> Result<usize, Error> {
        let (column, row, along_x) = side;
        let place = 2 * (row * field.request.columns + column) + usize::from(along_x);
        if let Some(index) = self.known[place] {
            return Ok(index);
        }
        let index = self.vertices.len();
        self.vertices.push(field.vertex(values, side)?);
        self.known[place] = Some(index);
        Ok(index)
    }
}

/// Returns the value that a design has at a key.
fn present(design: &Design, key: &str) -> Option<f64> {
    let (section, name) = key.split_once('.')?;
    serde_json::to_value(design)
        .ok()?
        .get(section)?
        .get(name)?
        .as_f64()
}

struct PeakField<'a> {
    runs: &'a NominalRuns<'a>,
    design: &'a Design,
    request: &'a MapRequest,
}

impl PeakField<'_> {
    fn x(&self, column: usize) -> f64 {
        self.request.x.value(column, self.request.columns)
    }

    fn y(&self, row: usize) -> f64 {
        self.request.y.value(row, self.request.rows)
    }

    /// The design with both values; `None` where no lever can have them.
    fn design_at(&self, x: f64, y: f64) -> Option<Design> {
        let mut changed = self.design.clone();
        let mut restitution = None;
        let given = [(&self.request.x.key, x), (&self.request.y.key, y)];
        let damping_given = given
            .iter()
            .any(|(key, _)| *key == "stop.damping_n_s_per_m");
        for (key, value) in given {
            if key == "stop.restitution" && !damping_given {
                restitution = Some(value);
            } else {
                changed.override_number(key.trim(), value).ok()?;
            }
        }
        if let Some(restitution) = restitution {
            changed.stop = with_restitution(&changed, restitution);
        }
        changed.validate().ok()?;
        Some(changed)
    }

    /// Whether the middle of a cell of which all sides are crossed, a saddle, has the answer of
    /// its lower left corner: the two belong together then.
    fn joined(&self, column: usize, row: usize, corner: Option<Excess>) -> Result<bool, Error> {
        let middle = self.at(
            f64::midpoint(self.x(column), self.x(column + 1)),
            f64::midpoint(self.y(row), self.y(row + 1)),
        )?;
        Ok(match (middle, corner) {
            (Some(middle), Some(corner)) => (middle.pass <= 0.0) == (corner.pass <= 0.0),
            _ => false,
        })
    }

    /// The largest angles [rad]; `None` where there is no lever or it could not be followed.
    fn peaks_rad(&self, values: &[Option<Excess>]) -> Vec<Option<f64>> {
        let columns = self.request.columns;
        let of_place = |(index, excess): (usize, &Option<Excess>)| {
            let excess = excess.filter(|excess| excess.pass.is_finite())?;
            let design = self.design_at(self.x(index % columns), self.y(index / columns))?;
            Some(excess.pass + design.criterion.threshold_rad)
        };
        values.iter().enumerate().map(of_place).collect()
    }

    fn at(&self, x: f64, y: f64) -> Result<Option<Excess>, Error> {
        self.design_at(x, y)
            .map(|design| self.runs.exact(&LeverTrial::new(&design, 1.0)))
            .transpose()
    }

    fn scan(&self) -> Result<Vec<Option<Excess>>, Error> {
        let count = self.request.columns * self.request.rows;
        let mut places = Vec::with_capacity(count);
        let mut trials = Vec::with_capacity(count);
        for index in 0..count {
            let (column, row) = (index % self.request.columns, index / self.request.columns);
            if let Some(design) = self.design_at(self.x(column), self.y(row)) {
                places.push(index);
                trials.push(LeverTrial::new(&design, 1.0));
            }
        }
        let mut values = vec![None; count];
        if !trials.is_empty() {
            for (place, excess) in places.into_iter().zip(self.runs.scan(&trials)?) {
                values[place] = Some(excess);
            }
        }
        Ok(values)
    }

    fn ends(&self, (column, row, along_x): GridSide) -> (usize, usize) {
        let from = row * self.request.columns + column;
        let step = if along_x { 1 } else { self.request.columns };
        (from, from + step)
    }

    fn differs(&self, values: &[Option<Excess>], side: GridSide) -> bool {
        let (from, to) = self.ends(side);
        match (values[from], values[to]) {
            (Some(from), Some(to)) => (from.pass > 0.0) != (to.pass > 0.0),
            _ => false,
        }
    }

    fn sides(&self) -> Vec<GridSide> {
        let (columns, rows) = (self.request.columns, self.request.rows);
        let mut sides = Vec::new();
        for row in 0..rows {
            for column in 0..columns {
                if column + 1 < columns {
                    sides.push((column, row, true));
                }
                if row + 1 < rows {
                    sides.push((column, row, false));
                }
            }
        }
        sides
    }

    /// Runs the ends of every side that the boundary crosses exactly, until no crossing rests
    /// on a scan alone.
    fn settle(&self, values: &mut [Option<Excess>]) -> Result<(), Error> {
        let sides = self.sides();
        let mut exact = vec![false; values.len()];
        loop {
            let mut again = false;
            for side in &sides {
                if !self.differs(values, *side) {
                    continue;
                }
                let (from, to) = self.ends(*side);
                for index in [from, to] {
                    if !exact[index] {
                        let columns = self.request.columns;
                        values[index] =
                            self.at(self.x(index % columns), self.y(index / columns))?;
                        exact[index] = true;
                        again = true;
                    }
                }
            }
            if !again {
                return Ok(());
            }
        }
    }

    fn vertex(&self, values: &[Option<Excess>], side: GridSide) -> Result<MapVertex, Error> {
        let (column, row, along_x) = side;
        let (x, y) = (self.x(column), self.y(row));
        let (from, to) = self.ends(side);
        let (low, high, range) = if along_x {
            (
                x,
                self.x(column + 1),
                self.request.x.high - self.request.x.low,
            )
        } else {
            (y, self.y(row + 1), self.request.y.high - self.request.y.low)
        };
        let unknown = Excess {
            pass: f64::INFINITY,
            fail: f64::NEG_INFINITY,
        };
        let exact = |value: f64| {
            let found = if along_x {
                self.at(value, y)?
            } else {
                self.at(x, value)?
            };
            Ok(found.unwrap_or(unknown))
        };
        let probe = Probe {
            scan: &|_| Ok(Vec::new()),
            exact: &exact,
            width: &|_| 1e-9 * range,
            near_rad: 0.0,
            distance: &|_| 0.0,
            narrowed: 1,
            values_max: 0,
        };
        let ends = (
            (low, values[from].unwrap_or(unknown)),
            (high, values[to].unwrap_or(unknown)),
        );
        let (below, above) = search::narrow(Edge::Pass, &probe, ends)?;
        let best = if below.1.pass <= 0.0 {
            below.0
        } else {
            above.0
        };
        Ok(MapVertex {
            x: if along_x { best } else { x },
            y: if along_x { y } else { best },
            bracket: (below.0, above.0),
            along_x,
        })
    }
}
