//! Every value of one quantity at which the answer changes, found on a grid and then narrowed.
//!
//! The peak is no monotonic function of anything: an impact that comes a little later may throw
//! the lever further or less far. So the whole search range is scanned, cells in which the
//! threshold could be crossed twice unseen are looked into, and each change of sign is narrowed
//! down by the exact run.

use super::NominalAnswer;
use latchgate_recording::error::Error;

/// The distance of the lever from a pass and from a fail at one value of the quantity [rad].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Excess {
    /// Above zero the answer is no pass; infinite where the lever could not be followed.
    pub pass: f64,
    /// Above zero the answer is a fail; never more than `pass`.
    pub fail: f64,
}

impl Excess {
    /// Returns the answer.
    #[must_use]
    pub fn state(self) -> NominalAnswer {
        if self.pass <= 0.0 {
            NominalAnswer::Pass
        } else if self.fail > 0.0 {
            NominalAnswer::Fail
        } else {
            NominalAnswer::Undecided
        }
    }

    fn of(self, edge: Edge) -> f64 {
        match edge {
            Edge::Pass => self.pass,
            Edge::Fail => self.fail,
        }
    }
}

/// A kind of change of the answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edge {
    /// Between pass and what is none.
    Pass,
    /// Between fail and what is none.
    Fail,
}

/// A value of the quantity at which the answer changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Its kind.
    pub edge: Edge,
    /// The lower end of its bracket, and how far the answer is from its change there.
    pub low: (f64, Excess),
    /// The upper end.
    pub high: (f64, Excess),
}

impl Crossing {
    /// Returns the end of the bracket at which the answer is the better one: still a pass, or
    /// not yet a fail.
    #[must_use]
    pub fn better_end(&self) -> f64 {
        if self.low.1.of(self.edge) <= 0.0 {
            self.low.0
        } else {
            self.high.0
        }
    }
}

/// The excess at many values.
pub type ScanFn<'a> = dyn Fn(&[f64]) -> Result<Vec<Excess>, Error> + 'a;

/// The ways to ask for the answer.
pub struct Probe<'a> {
    /// The excess at many values, cheaply: it may differ from the exact one by rounding.
    pub scan: &'a ScanFn<'a>,
    /// The excess at one value, which decides.
    pub exact: &'a dyn Fn(f64) -> Result<Excess, Error>,
    /// Width of the bracket that ends the search around a value, in the quantity's unit.
    pub width: &'a dyn Fn(f64) -> f64,
    /// A cell that comes as near to the threshold as this is looked into once [rad].
    pub near_rad: f64,
    /// How far a value is from the present one.
    pub distance: &'a dyn Fn(f64) -> f64,
    /// Changes that are narrowed down, the nearest; of the others the bracket is that of the scan.
    pub narrowed: usize,
    /// Values that are looked at, at most.
    pub values_max: usize,
}

/// The values that a search looked at, and the changes among them.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchResult {
    /// Every value that was looked at, in ascending order.
    pub points: Vec<(f64, Excess)>,
    /// Every change of the answer, in ascending order.
    pub crossings: Vec<Crossing>,
}

/// Parts that a cell is split into where the threshold could be crossed twice unseen.
pub const PARTS: usize = 8;

/// Times that cells are split.
pub const SPLITS: usize = 3;

/// A cell is looked into where the threshold is no further than this many times the change of
/// the peak over the cell or a neighbour.
pub const REACH: f64 = 3.0;

/// A cell both ends of which lie further beyond the threshold than this is left as it is [rad]: a lever
/// that is thrown wide open changes its peak by radians from one value to the next, which says nothing
/// of the threshold.
pub const FAR_RAD: f64 = 1.0;

/// Returns the angle [rad] beyond which a lever of a scan is followed no further: its peak is at least that.
#[must_use]
pub fn followed_to_rad(threshold_rad: f64) -> f64 {
    threshold_rad + 2.0 * FAR_RAD
}

/// A value, the excess there, and whether the exact run gave it.
#[derive(Clone, Copy)]
struct Point {
    at: f64,
    excess: Excess,
    exact: bool,
}

impl Point {
    fn scanned((at, excess): (f64, Excess)) -> Self {
        Self {
            at,
            excess,
            exact: false,
        }
    }
}

/// Finds every change of the answer on `grid`, whose values ascend, and narrows the nearest down.
///
/// A pair of crossings between two neighbouring values is found where a cell is split: where
/// the peak at an end of the cell is no further from the threshold than [`REACH`] times what it
/// changes over the cell or one of its neighbours (each split by [`PARTS`], up to [`SPLITS`] times over), or
/// than `near_rad` (split once), but no further than [`FAR_RAD`] beyond it; no more values are looked
/// at than the probe says, the nearest to the threshold first. A cell in which a pass begins or ends may hide
/// more: it is split once, the outermost and the nearest first, for up to half as many values again. The
/// peak is that which decides about a pass: changes between a fail and what is none are told as far as
/// the values show them. A pair that shows in neither way stays unseen.
///
/// # Errors
///
/// Those of the probe.
pub fn changes(grid: &[f64], probe: &Probe<'_>) -> Result<SearchResult, Error> {
    search(scanned(grid, probe)?, probe)
}

/// As [`changes`], of values that were scanned before.
///
/// # Errors
///
/// Those of the probe.
pub fn changes_among(
    scanned: Vec<(f64, Excess)>,
    probe: &Probe<'_>,
) -> Result<SearchResult, Error> {
    search(scanned.into_iter().map(Point::scanned).collect(), probe)
}

fn search(mut points: Vec<Point>, probe: &Probe<'_>) -> Result<SearchResult, Error> {
    let most = probe.values_max;
    // What cells with a change take is no loss to the others.
    let mut in_changing = 0;
    for split in 0..SPLITS {
        let near = if split == 0 { probe.near_rad } else { 0.0 };
        let mut cells: Vec<(f64, usize)> = (0..points.len().saturating_sub(1))
            .filter_map(|cell| Some((doubtful(&points, cell, near)?, cell)))
            .collect();
        // The nearest to the threshold first, as many as may be looked into.
        cells.sort_by(|a, b| a.0.total_cmp(&b.0));
        cells.truncate((most + in_changing).saturating_sub(points.len()) / (PARTS - 1));
        let mut cells: Vec<usize> = cells.into_iter().map(|(_, cell)| cell).collect();
        if split == 0 {
            let changing = changing_cells(&points, Edge::Pass, probe, most / 2 / (PARTS - 1));
            in_changing = changing.len() * (PARTS - 1);
            cells.extend(changing);
        }
        let wanted: Vec<f64> = cells
            .iter()
            .flat_map(|cell| inside(points[*cell].at, points[cell + 1].at))
            .collect();
        if wanted.is_empty() {
            break;
        }
        points.extend(scanned(&wanted, probe)?);
        points.sort_by(|a, b| a.at.total_cmp(&b.at));
    }
    let narrowed = settle(&mut points, probe)?;
    let mut crossings: Vec<Crossing> = Vec::new();
    for (index, cell) in points.windows(2).enumerate() {
        for edge in [Edge::Pass, Edge::Fail] {
            if !changes_in(cell, edge) {
                continue;
            }
            let ends = ((cell[0].at, cell[0].excess), (cell[1].at, cell[1].excess));
            let (low, high) = if narrowed.contains(&index) {
                narrow(edge, probe, ends)?
            } else {
                ends
            };
            // One stop and one polarity have but one edge, which is found twice.
            let known = crossings
                .iter()
                .any(|known| same(known.low.0, low.0) && same(known.high.0, high.0));
            if !known {
                crossings.push(Crossing { edge, low, high });
            }
        }
    }
    crossings.sort_by(|a, b| a.low.0.total_cmp(&b.low.0));
    Ok(SearchResult {
        points: points
            .iter()
            .map(|point| (point.at, point.excess))
            .collect(),
        crossings,
    })
}

fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits()
}

fn scanned(values: &[f64], probe: &Probe<'_>) -> Result<Vec<Point>, Error> {
    let found = values.iter().copied().zip((probe.scan)(values)?);
    Ok(found.map(Point::scanned).collect())
}

fn changes_in(cell: &[Point], edge: Edge) -> bool {
    (cell[0].excess.of(edge) > 0.0) != (cell[1].excess.of(edge) > 0.0)
}

/// How far the threshold is from a cell whose ends lie on the same side and in which a pass may yet
/// begin and end, or end and begin [rad]; `None` for any other cell.
fn doubtful(points: &[Point], cell: usize, near: f64) -> Option<f64> {
    let value = |index: usize| points[index].excess.pass;
    let (from, to) = (value(cell), value(cell + 1));
    if (from > 0.0) != (to > 0.0) {
        return None;
    }
    if from.min(to) > FAR_RAD {
        return None;
    }
    let distance = from.abs().min(to.abs());
    let first = cell.saturating_sub(1);
    let last = (cell + 1).min(points.len() - 2);
    let change = (first..=last)
        .map(|index| (value(index + 1) - value(index)).abs())
        .filter(|change| change.is_finite())
        .fold(0.0, f64::max);
    (distance <= (REACH * change).max(near)).then_some(distance)
}

/// The values that split a cell, whichever end is the lower one.
pub(super) fn inside(from: f64, to: f64) -> impl Iterator<Item = f64> {
    let part = move |index: usize| from + (to - from) * index as f64 / PARTS as f64;
    (1..PARTS)
        .map(part)
        .filter(move |value| *value > from.min(to) && *value < from.max(to))
}

/// Returns the cells whose change of the answer is to be narrowed down: as many as the probe says,
/// the nearest and those towards the ends of the range, the ends of each run exactly, until no such
/// change rests on a scan alone.
fn settle(points: &mut [Point], probe: &Probe<'_>) -> Result<Vec<usize>, Error> {
    loop {
        let chosen = worth_narrowing(points, probe);
        let open: Vec<usize> = chosen
            .iter()
            .flat_map(|cell| [*cell, cell + 1])
            .filter(|index| !points[*index].exact)
            .collect();
        if open.is_empty() {
            return Ok(chosen);
        }
        for index in open {
            if !points[index].exact {
                points[index].excess = (probe.exact)(points[index].at)?;
                points[index].exact = true;
            }
        }
    }
}

fn worth_narrowing(points: &[Point], probe: &Probe<'_>) -> Vec<usize> {
    let of_edge =
        |edge: Edge| changing_cells(points, edge, probe, probe.narrowed.saturating_add(2));
    let mut chosen = of_edge(Edge::Pass);
    chosen.extend(of_edge(Edge::Fail));
    chosen.sort_unstable();
    chosen.dedup();
    chosen
}

/// The cells in which the answer changes, at most so many: the outermost, then those nearest to the
/// present value.
fn changing_cells(points: &[Point], edge: Edge, probe: &Probe<'_>, most: usize) -> Vec<usize> {
    let distance = |cell: &usize| {
        let of = |index: usize| (probe.distance)(points[index].at);
        of(*cell).min(of(cell + 1))
    };
    let cells = 0..points.len().saturating_sub(1);
    let mut cells: Vec<usize> = cells
        .filter(|cell| changes_in(&points[*cell..*cell + 2], edge))
        .collect();
    let outermost = [cells.first().copied(), cells.last().copied()];
    cells.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    let mut chosen: Vec<usize> = outermost.into_iter().flatten().collect();
    chosen.dedup();
    cells.retain(|cell| !chosen.contains(cell));
    chosen.extend(cells);
    chosen.truncate(most);
    chosen
}

pub(super) type BracketEnd = (f64, Excess);

/// Narrows a change down: interpolation held near the middle, so that it needs no more rounds
/// than halving plus one, and jumps do it no harm.
///
/// # Source
///
/// I. F. D. Oliveira and R. H. C. Takahashi, An enhancement of the bisection method average
/// performance preserving minmax optimality, ACM Transactions on Mathematical Software 47 (2020):
/// the ITP method, with κ1 = 0.2/(b − a), κ2 = 2, n0 = 1.
pub(super) fn narrow(
    edge: Edge,
    probe: &Probe<'_>,
    ends: (BracketEnd, BracketEnd),
) -> Result<(BracketEnd, BracketEnd), Error> {
    let (mut low, mut high) = ends;
    // As a function that rises.
    let turn = if high.1.of(edge) > 0.0 { 1.0 } else { -1.0 };
    let width = (probe.width)(f64::midpoint(low.0, high.0)).max(0.0);
    let first_width = high.0 - low.0;
    if first_width <= width {
        return Ok((low, high));
    }
    let halvings = libm::ceil(libm::log2(first_width / width)).clamp(0.0, 1100.0);
    let mut reach = 0.5 * width * libm::exp2(halvings + 1.0);
    while high.0 - low.0 > width {
        let (a, b) = (low.0, high.0);
        let middle = f64::midpoint(a, b);
        let (fa, fb) = (turn * low.1.of(edge), turn * high.1.of(edge));
        let secant = (fb * a - fa * b) / (fb - fa);
        let held = (reach - 0.5 * (b - a)).max(0.0);
        reach *= 0.5;
        let mut next = middle;
        if secant.is_finite() {
            let side = (middle - secant).signum();
            let shift = 0.2 / first_width * (b - a) * (b - a);
            if shift <= (middle - secant).abs() {
                next = secant + side * shift;
            }
            if (next - middle).abs() > held {
                next = middle - side * held;
            }
        }
        if !(next > a && next < b) {
            next = middle;
        }
        if !(next > a && next < b) {
            break;
        }
        let found = (next, (probe.exact)(next)?);
        if (found.1.of(edge) > 0.0) == (turn > 0.0) {
            high = found;
        } else {
            low = found;
        }
    }
    Ok((low, high))
}
