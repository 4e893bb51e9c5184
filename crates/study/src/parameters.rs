//! Effect of each of the lever's numbers on its peak under a shock.
//!
//! The paper concludes (section 5) that parameters cannot reduce the amplitude of the response. That holds of
//! small changes; over the whole range of each number it does not.

use super::{Figures, Headline, cases};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::replay::{self, RunOptions};
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::OpensWhen;
use latchgate_recording::error::Error;
use serde::Serialize;

/// Options of the study.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Options {
    /// The lever whose numbers are varied.
    pub design: Design,
    /// Stops to run.
    #[serde(rename = "model")]
    pub models: Vec<StopModel>,
    /// Acceleration of one g [m/s²].
    pub gravity_m_s2: f64,
    /// Number of values of each.
    pub points: u32,
}

/// A number of the lever that is varied.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Number {
    /// Preload torque T0 [N m].
    Preload,
    /// Stiffness of the spring k0 [N m/rad].
    Stiffness,
    /// Unbalance m·L, by the mass [kg m].
    Unbalance,
    /// Moment of inertia I0 [kg m²].
    Inertia,
    /// Restitution of the rigid stop R [-].
    Restitution,
    /// Stiffness of the soft stop ks [N/m].
    StopStiffness,
}

impl Number {
    /// Every number, in the order of the charts.
    pub const ALL: [Self; 6] = [
        Self::Preload,
        Self::Stiffness,
        Self::Unbalance,
        Self::Inertia,
        Self::Restitution,
        Self::StopStiffness,
    ];

    /// Returns the name of the number, with its unit.
    pub fn title(self) -> &'static str {
        match self {
            Self::Preload => "preload T0 [N·m]",
            Self::Stiffness => "stiffness k0 [N·m/rad]",
            Self::Unbalance => "unbalance m·L [kg·m]",
            Self::Inertia => "inertia I0 [kg·m²]",
            Self::Restitution => "restitution R [–]",
            Self::StopStiffness => "stiffness of the stop ks [N/m]",
        }
    }

    /// Returns true if the number matters on a stop.
    fn is_of(self, model: StopModel) -> bool {
        match self {
            Self::Restitution => !model.yields(),
            Self::StopStiffness => model.yields(),
            _ => true,
        }
    }

    /// Returns the value of the number in a design.
    pub fn of(self, design: &Design) -> f64 {
        match self {
            Self::Preload => design.lever.preload_torque_nm,
            Self::Stiffness => design.lever.spring_stiffness_nm_per_rad,
            Self::Unbalance => design.lever.unbalance_kg_m(),
            Self::Inertia => design.lever.moment_of_inertia_kg_m2,
            Self::Restitution => design.stop.restitution,
            Self::StopStiffness => design.stop.stiffness_n_per_m,
        }
    }

    /// Returns the design with another value of the number.
    fn applied(self, design: &Design, value: f64) -> Design {
        let mut changed = design.clone();
        match self {
            Self::Preload => changed.lever.preload_torque_nm = value,
            Self::Stiffness => changed.lever.spring_stiffness_nm_per_rad = value,
            Self::Unbalance => {
                changed.lever.mass_kg = value / design.lever.center_of_mass_m.abs();
            }
            Self::Inertia => changed.lever.moment_of_inertia_kg_m2 = value,
            Self::Restitution => changed.stop.restitution = value,
            Self::StopStiffness => changed.stop.stiffness_n_per_m = value,
        }
        changed
    }

    /// Returns least and largest value. Mass and inertia are bound by I0 ≥ m L².
    fn range(self, design: &Design) -> (f64, f64) {
        let lever = &design.lever;
        let arm = lever.center_of_mass_m.abs();
        match self {
            Self::Preload => (0.01, 100.0),
            Self::Stiffness => (0.01, 1000.0),
            Self::Unbalance => {
                let largest = lever.moment_of_inertia_kg_m2 / arm;
                (1e-4 * largest, largest)
            }
            Self::Inertia => {
                let smallest = lever.mass_kg * arm * arm;
                (smallest, 1e4 * smallest)
            }
            Self::Restitution => (0.0, 1.0),
            Self::StopStiffness => (1e4, 1e9),
        }
    }

    /// Returns the values to try, in equal ratios; those of a restitution in equal steps.
    fn values(self, design: &Design, points: u32) -> Vec<f64> {
        let (low, high) = self.range(design);
        let part = |index: u32| f64::from(index) / f64::from(points.max(2) - 1);
        let value = |index: u32| match self {
            Self::Restitution => low + (high - low) * part(index),
            _ => low * libm::pow(high / low, part(index)),
        };
        (0..points.max(2)).map(value).collect()
    }
}

/// A row of the table.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Row {
    /// Number that is varied.
    pub number: Number,
    /// Stop model.
    pub stop: StopModel,
    /// Its value.
    pub value: f64,
    /// Largest angle in the shock and after it [rad]; `None` if the lever could not be followed.
    pub peak_angle_rad: Option<f64>,
}

/// Result of the study.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameters {
    /// The table.
    pub rows: Vec<Row>,
    /// The design whose numbers are varied.
    pub design: Design,
    /// Headline figures.
    pub headlines: Vec<Headline>,
}

/// Largest number of values of each.
pub const POINTS_MAX: u32 = 100_000;

/// Runs the study.
///
/// # Errors
///
/// As [`replay::run`]; [`Stopped`](latchgate_kernel::error::Error::Stopped).
pub fn run(options: &Options, control: &Control<'_>) -> Result<Parameters, Error> {
    let case = cases::shock(options.gravity_m_s2)?;
    let signal = case
        .signal()
        .ok_or_else(|| Error::too_short("a replay", 2, 0))?;
    let mut tasks = Vec::new();
    for number in Number::ALL {
        for model in options.models.iter().filter(|model| number.is_of(**model)) {
            let values = number.values(&options.design, options.points);
            tasks.extend(values.into_iter().map(|value| (number, *model, value)));
        }
    }
    let rows = control.try_map(&tasks, |(number, model, value)| {
        let design = number.applied(&options.design, *value);
        Ok::<_, Error>(Row {
            number: *number,
            stop: *model,
            value: *value,
            peak_angle_rad: peak(signal, &design, *model)?,
        })
    })?;
    Ok(Parameters {
        headlines: headlines(options, &rows),
        design: options.design.clone(),
        rows,
    })
}

/// Returns the largest angle of a lever under the shock and after it [rad].
fn peak(signal: &Signal, design: &Design, model: StopModel) -> Result<Option<f64>, Error> {
    let options = RunOptions {
        error_bound: false,
        ..RunOptions::new(model, OpensWhen::Negative)
    };
    let outcome = replay::run(signal, design, &options)?;
    let run = outcome.run;
    let peak = run
        .coast_peak_angle_rad
        .map_or(run.peak_angle_rad, |coast| coast.max(run.peak_angle_rad));
    Ok((!outcome.broke_down).then_some(peak))
}

fn headlines(options: &Options, rows: &[Row]) -> Vec<Headline> {
    let limit = options.design.criterion.threshold_rad;
    let mut headlines = Vec::new();
    for model in &options.models {
        for number in Number::ALL {
            let number_rows = || {
                let rows = rows.iter();
                rows.filter(|row| row.number == number && row.stop == *model)
            };
            let points = || number_rows().filter_map(|row| Some((row.value, row.peak_angle_rad?)));
            let Some((best_value, least_peak_rad)) = points().min_by(|a, b| a.1.total_cmp(&b.1))
            else {
                continue;
            };
            let mut figures = Figures::of(number.title(), *model);
            figures.say("present value", number.of(&options.design));
            figures.say("least peak angle [rad]", least_peak_rad);
            figures.say("at", best_value);
            figures.say(
                "largest peak angle [rad]",
                points().map(|point| point.1).reduce(f64::max),
            );
            let within =
                number_rows().filter(|row| row.peak_angle_rad.is_some_and(|peak| peak <= limit));
            figures.say("values within the limit [-]", within.count() as f64);
            figures.say("values tried [-]", number_rows().count() as f64);
            headlines.extend(figures.lines);
        }
    }
    headlines
}
