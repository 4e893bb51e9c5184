//! Studies: the paper's figures, cost and error of the methods, and the failures of each.
//!
//! A study computes rows and headline figures and hands them on as values; it writes no file
//! and reads no clock of its own.
//!
//! Motion on sines: `orbit` finds periodic orbits, `cascade` follows their branches; `bifurcation`,
//! `attractor`, `basins`, `histories` and `excitation_map` show the motion. Without
//! excitation: `free` is shared by `free_vibration` and `spectrogram`; `restitution` is one contact.
//! `shock` is a crash, `parameters` the effect of the lever's numbers on it, `catch` a lever beside an inertia
//! catch; `damages` is the detection of damage to a recording. Methods: `step_size`, `work_precision` and
//! `stability`, on `cases`.

pub mod attractor;
pub mod basins;
pub mod bifurcation;
pub mod cascade;
pub mod cases;
pub mod catch;
pub mod chart;
pub mod damages;
pub mod excitation_map;
pub mod files;
pub mod free;
pub mod free_vibration;
pub mod histories;
pub mod orbit;
pub mod parameters;
pub mod restitution;
pub mod sentence;
pub mod shock;
pub mod spectrogram;
pub mod stability;
pub mod step_size;
pub mod work_precision;

use latchgate_kernel::model::stop::StopModel;
use latchgate_report::plot::chart::Point;
use serde::{Deserialize, Serialize};

/// A clock: seconds since some instant.
pub type Stopwatch<'a> = &'a dyn Fn() -> f64;

/// A headline figure of a study.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Headline {
    /// Case or subject.
    pub subject: String,
    /// Stop model, if the figure depends on it.
    pub model: Option<StopModel>,
    /// Name of the figure, with its unit.
    pub what: String,
    /// The figure; `None` if there is none.
    pub value: Option<f64>,
    /// Significant digits worth showing; the JSON file has them all.
    #[serde(skip, default = "usual_digits")]
    pub digits: usize,
}

impl Headline {
    /// Significant digits of most figures.
    pub const DIGITS: usize = 4;
    /// Significant digits of figures that are solutions of equations.
    pub const EXACT: usize = 11;
}

const fn usual_digits() -> usize {
    Headline::DIGITS
}

/// Returns the slope of the straight line through points by least squares, on the logarithms of both
/// coordinates: the order of a power law. `None` for fewer than three points above zero.
pub fn fitted_order(points: &[Point]) -> Option<f64> {
    let logarithms: Vec<Point> = points
        .iter()
        .filter(|point| point.x > 0.0 && point.y > 0.0)
        .map(|point| Point::new(libm::log(point.x), libm::log(point.y)))
        .collect();
    if logarithms.len() < 3 {
        return None;
    }
    let count = logarithms.len() as f64;
    let middle_x = logarithms.iter().map(|point| point.x).sum::<f64>() / count;
    let middle_y = logarithms.iter().map(|point| point.y).sum::<f64>() / count;
    let (mut products, mut squares) = (0.0, 0.0);
    for Point { x, y } in logarithms {
        products += (x - middle_x) * (y - middle_y);
        squares += (x - middle_x) * (x - middle_x);
    }
    (squares > 0.0).then(|| products / squares)
}

/// Builder of the headline figures of one subject.
struct Figures {
    subject: String,
    model: StopModel,
    digits: usize,
    lines: Vec<Headline>,
}

impl Figures {
    fn of(subject: impl Into<String>, model: StopModel) -> Self {
        Self {
            subject: subject.into(),
            model,
            digits: Headline::DIGITS,
            lines: Vec::new(),
        }
    }

    /// Sets the digits of the figures that follow.
    fn digits(mut self, digits: usize) -> Self {
        self.digits = digits;
        self
    }

    fn say(&mut self, what: &str, value: impl Into<Option<f64>>) {
        self.lines.push(Headline {
            subject: self.subject.clone(),
            model: Some(self.model),
            what: what.into(),
            value: value.into(),
            digits: self.digits,
        });
    }
}
