//! Error against cost, for every method at several settings.
//!
//! Truth is the event-driven kernel on the same excitation, with the error it states; no row claims a
//! smaller error than that. Time is the least of several repetitions, as a multiple of the kernel's time
//! with its default tolerance on the same case in the same run, both without an error statement. The
//! kernel is timed again in turns with every row and its least time counts, so that one busy moment of
//! the machine moves no row against the others, and its row is 1.

use super::cases::{self, BetweenSamples, Drive, StudyCase};
use super::{Headline, Stopwatch, fitted_order};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::{self, Method, RunOptions, RunOutcome};
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::OpensWhen;
use latchgate_recording::error::Error;
use latchgate_report::plot::chart::Point;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Options of the study of error against cost.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Options {
    /// The lever.
    pub design: Design,
    /// Stops to run.
    #[serde(rename = "model")]
    pub models: Vec<StopModel>,
    /// Acceleration of one g [m/s²].
    pub gravity_m_s2: f64,
    /// Angular frequency of the harmonic case [rad/s].
    #[serde(rename = "omega_rad_s")]
    pub angular_frequency_rad_s: f64,
    /// Its amplitude [g].
    pub amplitude_g: f64,
    /// Its length [periods].
    pub periods: u32,
    /// Number of settings of each method.
    pub points: u32,
    /// Repetitions of which the fastest counts.
    pub repetitions: u32,
}

/// Outcome of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// All impacts were seen.
    Ok,
    /// Impacts were missed.
    MissedImpacts,
    /// Impacts were seen that do not happen.
    ExtraImpacts,
    /// The lever went deeper into the stop than is possible.
    Tunnelled,
    /// The run broke down, or its peak is more than three times the true one.
    Unstable,
}

/// One method at one setting on one case.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Case.
    pub case: &'static str,
    /// Stop model.
    pub model: StopModel,
    /// Method.
    pub method: &'static str,
    /// Reading between the samples; absent for a smooth sine.
    pub between: Option<&'static str>,
    /// Steps per natural period, of a method with a fixed step.
    pub steps_per_period: Option<u32>,
    /// Its step [s].
    pub step_s: Option<f64>,
    /// Tolerance [rad], of a method that takes one.
    pub tolerance_rad: Option<f64>,
    /// Outcome.
    pub status: Status,
    /// Error of the peak angle [rad]; never below that stated for the truth.
    pub peak_angle_error_rad: Option<f64>,
    /// Error of the angle at the end [rad]; never below that stated for the truth.
    pub final_angle_error_rad: Option<f64>,
    /// Error of the angular velocity at the end [rad/s].
    pub final_velocity_error_rad_s: Option<f64>,
    /// Error of the first crossing of the threshold [s]; absent where only one of the two runs
    /// crosses, or neither.
    pub first_crossing_error_s: Option<f64>,
    /// Error of the peak angle that the method itself states [rad].
    pub stated_error_rad: Option<f64>,
    /// True if the stated error covers the true one.
    pub stated_covers: Option<bool>,
    /// Impacts faster than 1e-3 rad/s.
    pub impacts: u64,
    /// Impacts of the truth faster than 1e-3 rad/s.
    pub true_impacts: u64,
    /// Lowest angle [rad], where the method keeps it.
    pub lowest_angle_rad: Option<f64>,
    /// Steps tried.
    pub steps: u64,
    /// Right-hand sides.
    pub rhs: u64,
    /// Events.
    pub events: u64,
    /// Least time of the repetitions [s].
    pub time_s: f64,
    /// That time as a multiple of the event-driven kernel's.
    pub time_ratio: f64,
}

/// The truth of a case, with its bounds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Case.
    pub case: Cow<'static, str>,
    /// Stop model.
    pub model: StopModel,
    /// Description of the case.
    pub title: String,
    /// Samples; absent for a smooth sine.
    pub samples: Option<usize>,
    /// Peak angle [rad].
    pub peak_angle_rad: f64,
    /// Bound on its error [rad].
    pub peak_angle_bound_rad: f64,
    /// Angle at the end [rad].
    pub final_angle_rad: f64,
    /// Bound on its error [rad].
    pub final_angle_bound_rad: f64,
    /// First crossing of the threshold [s].
    pub first_crossing_s: Option<f64>,
    /// Bound on its error [s].
    pub first_crossing_bound_s: Option<f64>,
    /// Impacts faster than 1e-3 rad/s.
    pub impacts: u64,
    /// Time of the event-driven kernel [s].
    pub kernel_time_s: f64,
    /// That time per sample interval [ns]; absent for a smooth sine.
    pub kernel_ns_per_sample: Option<f64>,
}

/// Result of the study.
#[derive(Debug, Clone, PartialEq)]
pub struct WorkPrecision {
    /// The truth of each case and stop.
    pub truths: Vec<Truth>,
    /// Every run, by case, stop, method and setting.
    pub rows: Vec<Row>,
    /// Headline figures.
    pub headlines: Vec<Headline>,
}

/// Steps per natural period of the paper's reference lever that its authors chose.
pub const PAPER_STEPS: u32 = 10_000;

/// Coarsest and finest steps per natural period.
const STEPS: (f64, f64) = (1e3, 2e5);

/// Loosest and tightest tolerance of the adaptive methods.
const ADAPTIVE: (f64, f64) = (1e-3, 1e-13);

/// Loosest and tightest tolerance of the event-driven method.
const EVENT_DRIVEN: (f64, f64) = (1e-4, 1e-16);

/// Compares every method on every case.
///
/// # Errors
///
/// As [`replay::run`].
pub fn run(options: &Options, clock: Stopwatch<'_>) -> Result<WorkPrecision, Error> {
    let gravity = options.gravity_m_s2;
    let study_cases = [
        cases::shock(gravity)?,
        cases::recording(gravity)?,
        cases::harmonic(
            gravity,
            options.amplitude_g,
            options.angular_frequency_rad_s,
            options.periods,
        ),
    ];
    let mut answer = WorkPrecision {
        truths: Vec::new(),
        rows: Vec::new(),
        headlines: Vec::new(),
    };
    for case in &study_cases {
        for &model in &options.models {
            let mut bench = TimedCase::new(options, case, model, clock)?;
            let first = answer.rows.len();
            for (method, tolerance) in settings(options.points) {
                if method.admits(model) && has_step(method, &options.design) {
                    answer.rows.push(bench.row(method, tolerance)?);
                }
            }
            bench.finish(&mut answer.rows[first..]);
            headlines(&bench.truth, &answer.rows[first..], &mut answer.headlines);
            if matches!(case.drive, Drive::Sine { .. }) {
                orders(&bench, &mut answer.headlines)?;
            }
            answer.truths.push(bench.truth);
        }
    }
    let between = cases::between_samples(gravity)?;
    for &model in &options.models {
        between_samples(options, &between, model, clock, &mut answer)?;
    }
    Ok(answer)
}

/// Fits the orders of the fixed-step methods on a smooth sine, whose only kinks are impacts. Steps per natural period
/// double from the coarsest that does not fail to the finest before rounding. With events on the grid of a soft stop
/// no order shows at any step tried.
fn orders(bench: &TimedCase<'_>, out: &mut Vec<Headline>) -> Result<(), Error> {
    struct OrderFit {
        method: fn(u32) -> Method,
        coarsest_steps: u32,
        settings: u32,
        at_end: bool,
    }
    let located = |coarsest_steps, settings| OrderFit {
        method: |steps_per_period| Method::Rk4Located { steps_per_period },
        coarsest_steps,
        settings,
        at_end: false,
    };
    let on_grid = OrderFit {
        method: |steps_per_period| Method::Rk4 { steps_per_period },
        coarsest_steps: 10_000,
        settings: 9,
        at_end: true,
    };
    let fits = match bench.model {
        StopModel::Rigid => vec![located(100, 5), on_grid],
        StopModel::Soft => vec![located(32_000, 4)],
    };
    for fit in fits {
        let mut points = Vec::new();
        for doublings in 0..fit.settings {
            let method = (fit.method)(fit.coarsest_steps << doublings);
            if !has_step(method, &bench.options.design) {
                continue;
            }
            let run = bench.options_of(method, None);
            let run = bench.case.replay(&bench.options.design, &run)?.run;
            let error = if fit.at_end {
                run.final_angle_rad - bench.truth.final_angle_rad
            } else {
                run.peak_angle_rad - bench.truth.peak_angle_rad
            };
            let steps = method.steps_per_period().unwrap_or_default();
            let step_s = replay::fixed_step_s(&bench.options.design, steps);
            points.push(Point::new(step_s, error.abs()));
        }
        let what = if fit.at_end {
            "angle at the end"
        } else {
            "peak"
        };
        let name = (fit.method)(fit.coarsest_steps).name();
        out.push(Headline {
            digits: 2,
            subject: bench.truth.case.to_string(),
            model: Some(bench.model),
            what: format!("{name}: order of the error of the {what}, fitted [-]"),
            value: fitted_order(&points),
        });
    }
    Ok(())
}

/// Compares readings of one recording whose truth is its formula: the event-driven method on each, the others on
/// straight lines as in the other cases.
fn between_samples(
    options: &Options,
    cases: &BetweenSamples,
    model: StopModel,
    clock: Stopwatch<'_>,
    answer: &mut WorkPrecision,
) -> Result<(), Error> {
    let mut bench = TimedCase::new(options, &cases.truth, model, clock)?;
    let half = TimedCase::new(options, &cases.check, model, clock)?;
    let apart = bench.truth.peak_angle_rad - half.truth.peak_angle_rad;
    bench.truth.peak_angle_bound_rad += apart.abs();
    let Some((verdict, lines)) = cases.read.split_last() else {
        return Ok(());
    };
    bench.unit = verdict;
    let first = answer.rows.len();
    for case in lines.iter().chain([verdict]) {
        bench.case = case;
        answer.rows.push(bench.row(Method::EventDriven, None)?);
    }
    bench.case = &lines[0];
    for (method, tolerance) in settings(options.points) {
        let is_comparable = !matches!(method, Method::EventDriven | Method::MoreauJean { .. });
        if is_comparable && method.admits(model) && has_step(method, &options.design) {
            answer.rows.push(bench.row(method, tolerance)?);
        }
    }
    bench.finish(&mut answer.rows[first..]);
    headlines(&bench.truth, &answer.rows[first..], &mut answer.headlines);
    answer.truths.push(bench.truth);
    Ok(())
}

/// Returns true if the method has a step for the design: a lever without a spring has no natural period.
fn has_step(method: Method, design: &Design) -> bool {
    method
        .steps_per_period()
        .is_none_or(|steps| replay::fixed_step_s(design, steps).is_finite())
}

/// Returns `points` values from `from` to `to`, evenly by their logarithm.
fn geometric((from, to): (f64, f64), points: u32) -> impl Iterator<Item = f64> {
    let last = f64::from(points.max(2) - 1);
    (0..points.max(2)).map(move |index| from * libm::pow(to / from, f64::from(index) / last))
}

fn settings(points: u32) -> Vec<(Method, Option<f64>)> {
    let mut steps: Vec<u32> = geometric(STEPS, points)
        .map(|steps| steps.round() as u32)
        .collect();
    steps.push(PAPER_STEPS);
    steps.sort_unstable();
    steps.dedup();
    // Tolerances are rounded to decades, as is usual.
    let decade = |value: f64| {
        format!("1e{}", libm::log10(value).round())
            .parse()
            .unwrap_or(value)
    };
    let mut settings: Vec<(Method, Option<f64>)> = geometric(EVENT_DRIVEN, points)
        .map(|tolerance| (Method::EventDriven, Some(decade(tolerance))))
        .collect();
    settings.push((Method::EventDriven, None));
    for at_samples in [true, false] {
        settings.extend(
            geometric(ADAPTIVE, points)
                .map(|tolerance| (Method::Dopri5 { at_samples }, Some(decade(tolerance)))),
        );
    }
    let fixed: [fn(u32) -> Method; 3] = [
        |steps_per_period| Method::Rk4 { steps_per_period },
        |steps_per_period| Method::Rk4Located { steps_per_period },
        |steps_per_period| Method::MoreauJean { steps_per_period },
    ];
    for method in fixed {
        settings.extend(steps.iter().map(|steps| (method(*steps), None)));
    }
    settings
}

/// One case on one stop with its truth.
struct TimedCase<'a> {
    options: &'a Options,
    /// Case that the rows run.
    case: &'a StudyCase,
    /// Case on which the kernel is timed; its time is the unit.
    unit: &'a StudyCase,
    model: StopModel,
    truth: Truth,
    truth_velocity: f64,
    /// Bound on the angle into a stop [rad]; a lower angle is tunnelling.
    deepest: f64,
    clock: Stopwatch<'a>,
}

impl<'a> TimedCase<'a> {
    fn new(
        options: &'a Options,
        case: &'a StudyCase,
        model: StopModel,
        clock: Stopwatch<'a>,
    ) -> Result<Self, Error> {
        let base = RunOptions {
            initial: case.initial,
            ..RunOptions::new(model, OpensWhen::Negative)
        };
        let nominal = case.replay(&options.design, &base)?;
        let run = &nominal.run;
        let stated = |outcome: &RunOutcome| outcome.final_error_rad.unwrap_or(f64::INFINITY);
        let first_crossing_bound_s = match run.first_crossing_s {
            None => None,
            Some(crossing) => {
                let at_crossing = case.replay_until(crossing, &options.design, &base)?;
                let speed = at_crossing
                    .run
                    .final_velocity_rad_s
                    .abs()
                    .max(f64::MIN_POSITIVE);
                // The rounding of the instant is added.
                Some(stated(&at_crossing) / speed + f64::EPSILON * crossing.abs())
            }
        };
        let fastest = run
            .impact_list
            .iter()
            .map(|impact| impact[1].abs())
            .fold(1.0, f64::max);
        let frequency = options
            .design
            .stop
            .contact_angular_frequency_rad_s(&options.design.lever);
        let bench = Self {
            options,
            case,
            unit: case,
            model,
            truth: Truth {
                case: case.name.into(),
                model,
                title: case.title.clone(),
                samples: case.signal().map(|signal| signal.samples.len()),
                peak_angle_rad: run.peak_angle_rad,
                peak_angle_bound_rad: run.numerical_error_rad,
                final_angle_rad: run.final_angle_rad,
                final_angle_bound_rad: stated(&nominal),
                first_crossing_s: run.first_crossing_s,
                first_crossing_bound_s,
                impacts: run.impacts,
                kernel_time_s: f64::INFINITY,
                kernel_ns_per_sample: None,
            },
            truth_velocity: run.final_velocity_rad_s,
            deepest: -2.0 * fastest / frequency,
            clock,
        };
        Ok(bench)
    }

    fn options_of(&self, method: Method, tolerance_rad: Option<f64>) -> RunOptions {
        RunOptions {
            method,
            tolerance_rad,
            initial: self.case.initial,
            error_bound: false,
            ..RunOptions::new(self.model, OpensWhen::Negative)
        }
    }

    /// Runs a case once; returns the time [s] and the outcome.
    fn once(&self, case: &StudyCase, run: &RunOptions) -> Result<(f64, RunOutcome), Error> {
        let started = (self.clock)();
        let got = case.replay(&self.options.design, run)?;
        Ok(((self.clock)() - started, got))
    }

    /// Returns the least time of a run [s] and its outcome; times the kernel in turns with it.
    fn time(&mut self, run: &RunOptions) -> Result<(f64, RunOutcome), Error> {
        /// Duration from which a run is not repeated [s]: short disturbances hardly change it.
        const LONG_S: f64 = 0.2;
        let kernel = self.options_of(Method::EventDriven, None);
        let mut least = f64::INFINITY;
        let mut outcome = None;
        for _ in 0..self.options.repetitions.max(1) {
            let kernel_time_s = self.once(self.unit, &kernel)?.0;
            self.truth.kernel_time_s = self.truth.kernel_time_s.min(kernel_time_s);
            let (time_s, got) = self.once(self.case, run)?;
            least = least.min(time_s);
            outcome = Some(got);
            if least > LONG_S {
                break;
            }
        }
        Ok((least, outcome.expect("repeated once at least")))
    }

    /// Sets the time ratio of every row, to the least time of the kernel in any turn.
    fn finish(&mut self, rows: &mut [Row]) {
        let unit = self.unit.between();
        let is_unit_row = |row: &Row| {
            row.method == Method::EventDriven.name()
                && row.tolerance_rad.is_none()
                && row.between == unit
        };
        let kernel_time_s = rows
            .iter()
            .filter(|row| is_unit_row(row))
            .map(|row| row.time_s)
            .fold(self.truth.kernel_time_s, f64::min);
        for row in rows {
            if is_unit_row(row) {
                row.time_s = kernel_time_s;
            }
            row.time_ratio = row.time_s / kernel_time_s;
        }
        let per_sample = |signal: &Signal| kernel_time_s * 1e9 / (signal.samples.len() - 1) as f64;
        self.truth.kernel_time_s = kernel_time_s;
        self.truth.kernel_ns_per_sample = self.unit.signal().map(per_sample);
    }

    fn row(&mut self, method: Method, tolerance_rad: Option<f64>) -> Result<Row, Error> {
        let quick = self.options_of(method, tolerance_rad);
        let (time_s, outcome) = self.time(&quick)?;
        let bounded = RunOptions {
            error_bound: true,
            ..quick
        };
        let stated = self
            .case
            .replay(&self.options.design, &bounded)?
            .run
            .numerical_error_rad;
        let run = &outcome.run;
        let truth = &self.truth;
        let sound = !outcome.broke_down;
        let off = |value: f64, truth: f64, bound: f64| {
            (sound && value.is_finite()).then(|| (value - truth).abs().max(bound))
        };
        let peak_error = off(
            run.peak_angle_rad,
            truth.peak_angle_rad,
            truth.peak_angle_bound_rad,
        );
        let first_crossing_error_s = match (
            run.first_crossing_s,
            truth.first_crossing_s,
            truth.first_crossing_bound_s,
        ) {
            (Some(got), Some(want), Some(bound)) => off(got, want, bound),
            _ => None,
        };
        Ok(Row {
            case: self.case.name,
            model: self.model,
            method: method.name(),
            between: self.case.between(),
            steps_per_period: method.steps_per_period(),
            step_s: method
                .steps_per_period()
                .map(|steps| replay::fixed_step_s(&self.options.design, steps)),
            tolerance_rad,
            status: self.status(&outcome),
            peak_angle_error_rad: peak_error,
            final_angle_error_rad: off(
                run.final_angle_rad,
                truth.final_angle_rad,
                truth.final_angle_bound_rad,
            ),
            final_velocity_error_rad_s: off(run.final_velocity_rad_s, self.truth_velocity, 0.0),
            first_crossing_error_s,
            stated_error_rad: stated.is_finite().then_some(stated),
            stated_covers: peak_error.map(|_| {
                (run.peak_angle_rad - truth.peak_angle_rad).abs()
                    <= stated + truth.peak_angle_bound_rad
            }),
            impacts: run.impacts,
            true_impacts: truth.impacts,
            lowest_angle_rad: outcome.lowest_angle_rad.filter(|angle| angle.is_finite()),
            steps: run.work.steps,
            rhs: run.work.rhs,
            events: run.work.events,
            time_s,
            // `finish` sets it once the kernel has had all its turns.
            time_ratio: f64::NAN,
        })
    }

    fn status(&self, outcome: &RunOutcome) -> Status {
        let run = &outcome.run;
        if outcome.broke_down || run.peak_angle_rad.abs() > 3.0 * self.truth.peak_angle_rad.abs() {
            Status::Unstable
        } else if outcome
            .lowest_angle_rad
            .is_some_and(|angle| angle < self.deepest)
        {
            Status::Tunnelled
        } else if run.impacts < self.truth.impacts {
            Status::MissedImpacts
        } else if run.impacts > self.truth.impacts {
            Status::ExtraImpacts
        } else {
            Status::Ok
        }
    }
}

/// Sufficient accuracy of the peak [rad]: a hundred-thousandth of the usual threshold.
const GOOD_RAD: f64 = 1e-6;

fn headlines(truth: &Truth, rows: &[Row], out: &mut Vec<Headline>) {
    let mut say = |what: String, value: Option<f64>| {
        out.push(Headline {
            digits: Headline::DIGITS,
            subject: truth.case.to_string(),
            model: Some(truth.model),
            what,
            value,
        });
    };
    match truth.kernel_ns_per_sample {
        Some(time) => say("event-driven: time [ns per sample]".into(), Some(time)),
        None => say("event-driven: time [s]".into(), Some(truth.kernel_time_s)),
    }
    say(
        "event-driven: bound on the peak's error [rad]".into(),
        Some(truth.peak_angle_bound_rad),
    );
    if let Some(paper) = rows
        .iter()
        .find(|row| row.method == "rk4" && row.steps_per_period == Some(PAPER_STEPS))
    {
        say(
            "rk4 at the paper's step: error of the peak [rad]".into(),
            paper.peak_angle_error_rad,
        );
        say(
            "rk4 at the paper's step: error of the angle at the end [rad]".into(),
            paper.final_angle_error_rad,
        );
        say(
            "rk4 at the paper's step: time over event-driven [-]".into(),
            Some(paper.time_ratio),
        );
    }
    if truth.case == cases::BETWEEN_SAMPLES {
        let kernel = rows.iter().filter(|row| row.method == "event-driven");
        for row in kernel {
            let between = row.between.unwrap_or_default();
            say(
                format!("event-driven, {between}: error of the peak [rad]"),
                row.peak_angle_error_rad,
            );
            say(
                format!("event-driven, {between}: time over band-limited [-]"),
                Some(row.time_ratio),
            );
        }
    }
    let mut methods: Vec<&'static str> = Vec::new();
    for row in rows {
        if !methods.contains(&row.method) {
            methods.push(row.method);
        }
    }
    for method in methods {
        let method_rows = || rows.iter().filter(|row| row.method == method);
        if method != "event-driven" {
            let cheapest = method_rows()
                .filter(|row| row.status == Status::Ok)
                .filter(|row| {
                    row.peak_angle_error_rad
                        .is_some_and(|error| error <= GOOD_RAD)
                })
                .map(|row| row.time_ratio)
                .min_by(f64::total_cmp);
            say(
                format!("{method}: time over event-driven for 1e-6 rad [-]"),
                cheapest,
            );
        }
        let failed = method_rows().filter(|row| row.status != Status::Ok).count() as f64;
        say(format!("{method}: settings that failed [-]"), Some(failed));
    }
}
