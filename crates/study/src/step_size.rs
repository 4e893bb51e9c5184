//! The paper's Fig. 3: the fixed-step method on free impacts with the soft stop, and the reason for its
//! failures.

use super::free::{self, Against, FreeMotion, Release};
use super::stability::contact::contacts;
use super::{Figures, Headline};
use crate::restitution::FreeContact;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::range::Range;
use latchgate_kernel::replay::{self, Breakdown, Method, RunOptions, State, TracePoint};
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::{OpensWhen, SampleRate};
use latchgate_recording::error::Error;
use serde::Serialize;
use std::f64::consts::TAU;

/// Options of the study of the fixed step.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Options {
    /// The lever.
    pub design: Design,
    /// Angular frequency of the excitation whose period is cut into steps [rad/s].
    #[serde(rename = "omega_rad_s")]
    pub angular_frequency_rad_s: f64,
    /// Steps per period of each run.
    pub steps_per_period: Vec<u32>,
    /// Initial angle [rad].
    #[serde(rename = "phi0_rad")]
    pub angle_rad: f64,
    /// Initial angular velocity [rad/s].
    #[serde(rename = "omega0_rad_s")]
    pub velocity_rad_s: f64,
    /// Length [periods of the excitation].
    pub periods: u32,
    /// Number of step sizes of the scan.
    pub points: u32,
}

/// A run with a fixed step.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FixedStepRun {
    /// Steps per period of the excitation.
    pub steps_per_period: u32,
    /// The step [s].
    pub step_s: f64,
    /// Contact angular frequency times step [-].
    pub reach: f64,
    /// Factor |R(z)| by which one step multiplies the oscillation in contact [-].
    pub amplification: f64,
    /// Speed at the first point outside over that at the first point inside, contact by contact,
    /// at most the first 50 [-]; empty if the history does not keep every step.
    pub exit_over_entry: Vec<f64>,
    /// Largest angle after the first contact [rad].
    pub largest_after_contact_rad: Option<f64>,
    /// True if the lever rises higher after a contact than its start.
    pub gains_energy: bool,
    /// True if its numbers left the range of a double.
    pub broke_down: bool,
    /// The history.
    #[serde(skip)]
    pub trace: Vec<TracePoint>,
}

/// A step of the scan: one contact, entered at several phases of the step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StepScan {
    /// Steps per period of the excitation.
    pub steps_per_period: f64,
    /// Contact angular frequency times step [-].
    pub reach: f64,
    /// Least ratio of exit to entry speed over the phases [-].
    pub least_ratio: f64,
    /// Largest ratio [-]. Runs that do not leave the stop have no ratio.
    pub largest_ratio: f64,
    /// Share of the phases that gain energy or do not leave the stop [-].
    pub failing_share: f64,
}

/// A row of the histories.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Row {
    /// Steps per period of the excitation; empty for the exact motion.
    pub steps_per_period: Option<u32>,
    /// Time [s].
    pub time_s: f64,
    /// Angle [rad].
    pub angle_rad: f64,
    /// Angular velocity [rad/s].
    pub angular_velocity_rad_s: f64,
}

/// Result of the study.
#[derive(Debug, Clone, PartialEq)]
pub struct StepSize {
    /// The exact motion.
    pub exact: FreeMotion,
    /// The runs.
    pub runs: Vec<FixedStepRun>,
    /// The scan, from coarse to fine.
    pub scan: Vec<StepScan>,
    /// The right ratio of exit to entry speed [-]; `None` if the lever stays.
    pub right_ratio: Option<f64>,
    /// Contact angular frequency times step beyond which a step amplifies [-].
    pub limit: f64,
    /// That limit in steps per period.
    pub limit_steps_per_period: f64,
    /// Headline figures.
    pub headlines: Vec<Headline>,
}

/// Phases of entry within a step.
const PHASES: u32 = 24;

/// Steps per period of the scan.
const SCAN: Range = Range::new(500.0, 1e6);

/// Largest number of steps of which the trace keeps every one.
const KEPT_STEPS: u64 = 39_000;

/// Runs the study.
///
/// # Errors
///
/// As [`replay::run`].
pub fn run(options: &Options) -> Result<StepSize, Error> {
    let design = &options.design;
    let period = TAU / options.angular_frequency_rad_s;
    let duration_s = f64::from(options.periods) * period;
    let exact = free::run(
        design,
        Against::Soft,
        &Release {
            preload_torque_nm: design.lever.preload_torque_nm,
            start: State::new(options.angle_rad, options.velocity_rad_s),
            duration_s,
            rate_hz: 1000.0 / period,
        },
    )?;
    let frequency = design.stop.contact_angular_frequency_rad_s(&design.lever);
    let limit = latchgate_kernel::numerics::rk4::stability_limit(design.contact_damping_ratio());
    let mut runs = Vec::new();
    for steps in &options.steps_per_period {
        runs.push(one_run(options, *steps, duration_s, frequency)?);
    }
    let entry_speed_rad_s = exact.impacts.first().map_or(1.0, |impact| -impact[1]);
    let right_ratio = FreeContact::new(design, design.lever.preload_torque_nm)
        .and_then(|contact| contact.exit(entry_speed_rad_s))
        .map(|exit| exit.speed_rad_s / entry_speed_rad_s);
    let mut scan = Vec::new();
    for index in 0..options.points {
        let share = f64::from(index) / f64::from(options.points - 1);
        let steps = SCAN.low * libm::pow(SCAN.high / SCAN.low, share);
        scan.push(one_step(
            design,
            steps,
            period / steps,
            frequency,
            entry_speed_rad_s,
        )?);
    }
    let mut answer = StepSize {
        exact,
        runs,
        scan,
        right_ratio,
        limit,
        limit_steps_per_period: frequency * period / limit,
        headlines: Vec::new(),
    };
    answer.headlines = headlines(&answer);
    Ok(answer)
}

fn silence(length_s: f64) -> Result<Signal, Error> {
    Ok(Signal {
        start_s: 0.0,
        rate: SampleRate::from_hertz(1.0 / length_s)?,
        samples: vec![0.0; 2],
    })
}

fn fixed(step_s: f64, initial: State) -> RunOptions {
    RunOptions {
        // `step_s` overrides the steps per natural period, so their number has no effect.
        method: Method::Rk4 {
            steps_per_period: 1,
        },
        step_s: Some(step_s),
        initial: Some(initial),
        trace: true,
        error_bound: false,
        ..RunOptions::new(StopModel::Soft, OpensWhen::Negative)
    }
}

fn one_run(
    options: &Options,
    steps_per_period: u32,
    duration_s: f64,
    frequency: f64,
) -> Result<FixedStepRun, Error> {
    let design = &options.design;
    let step_s = TAU / (options.angular_frequency_rad_s * f64::from(steps_per_period));
    let start = State::new(options.angle_rad, options.velocity_rad_s);
    let outcome = replay::run(&silence(duration_s)?, design, &fixed(step_s, start))?;
    let mut trace = vec![TracePoint {
        time_s: 0.0,
        angle_rad: start.angle_rad,
        velocity_rad_s: start.velocity_rad_s,
    }];
    trace.extend(outcome.trace);
    let every_step = u64::from(steps_per_period) * u64::from(options.periods) <= KEPT_STEPS;
    let exit_over_entry: Vec<f64> = if every_step {
        contacts(design, &trace)
            .iter()
            .take(50)
            .map(|contact| contact.on_grid)
            .filter(|ratio| ratio.is_finite())
            .collect()
    } else {
        Vec::new()
    };
    let inside = trace.iter().position(|point| point.angle_rad < 0.0);
    let largest_after_contact_rad = inside.map(|index| {
        trace[index..]
            .iter()
            .map(|point| point.angle_rad)
            .filter(|angle| angle.is_finite())
            .fold(f64::NEG_INFINITY, f64::max)
    });
    let damping_ratio = design.contact_damping_ratio();
    let reach = frequency * step_s;
    let before = highest(options);
    Ok(FixedStepRun {
        steps_per_period,
        step_s,
        reach,
        amplification: latchgate_kernel::numerics::rk4::amplification(
            -reach * damping_ratio,
            reach * (1.0 - damping_ratio * damping_ratio).max(0.0).sqrt(),
        ),
        exit_over_entry,
        largest_after_contact_rad,
        gains_energy: outcome.breakdown == Some(Breakdown::NotFinite)
            || largest_after_contact_rad.is_some_and(|largest| largest > before),
        broke_down: outcome.broke_down,
        trace,
    })
}

/// Returns the highest angle that the energy at the start allows [rad].
fn highest(options: &Options) -> f64 {
    let lever = &options.design.lever;
    let (k, t) = (lever.spring_stiffness_nm_per_rad, lever.preload_torque_nm);
    let (q, v) = (options.angle_rad, options.velocity_rad_s);
    let energy = 0.5 * lever.moment_of_inertia_kg_m2 * v * v + t * q + 0.5 * k * q * q;
    // The root of k φ²/2 + T0 φ = E, in the form that also holds without a spring.
    2.0 * energy / (t + (t * t + 2.0 * k * energy).max(0.0).sqrt())
}

/// Computes one contact at one step, entered at every phase.
fn one_step(
    design: &Design,
    steps_per_period: f64,
    step_s: f64,
    frequency: f64,
    speed: f64,
) -> Result<StepScan, Error> {
    let (mut least, mut largest) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut failing = 0;
    for phase in 0..PHASES {
        let angle = (f64::from(phase) + 0.5) / f64::from(PHASES) * step_s * speed;
        // The run covers the way to the stop, one and a half contacts, and a few steps after the exit.
        let length = angle / speed + 1.5 * std::f64::consts::PI / frequency + 4.0 * step_s;
        let start = State::new(angle, -speed);
        let outcome = replay::run(&silence(length)?, design, &fixed(step_s, start))?;
        let mut trace = vec![TracePoint {
            time_s: 0.0,
            angle_rad: angle,
            velocity_rad_s: -speed,
        }];
        trace.extend(outcome.trace);
        let ratio = contacts(design, &trace)
            .first()
            .map(|contact| contact.at_stop)
            .filter(|ratio| ratio.is_finite());
        if let Some(ratio) = ratio {
            (least, largest) = (least.min(ratio), largest.max(ratio));
        }
        if ratio.is_none_or(|ratio| !(0.0..=1.0).contains(&ratio)) {
            failing += 1;
        }
    }
    Ok(StepScan {
        steps_per_period,
        reach: frequency * step_s,
        least_ratio: least,
        largest_ratio: largest,
        failing_share: f64::from(failing) / f64::from(PHASES),
    })
}

fn headlines(answer: &StepSize) -> Vec<Headline> {
    let mut headlines = Vec::new();
    for run in &answer.runs {
        let mut figures = Figures::of(format!("N = {}", run.steps_per_period), StopModel::Soft);
        figures.say("step [s]", run.step_s);
        figures.say("ωR times step [-]", run.reach);
        figures.say("|R(z)| in contact [-]", run.amplification);
        figures.say(
            "exit over entry speed of the first contact, on the grid [-]",
            run.exit_over_entry.first().copied(),
        );
        figures.say(
            "the same of the second [-]",
            run.exit_over_entry.get(1).copied(),
        );
        figures.say(
            "largest angle after the first contact [rad]",
            run.largest_after_contact_rad,
        );
        figures.say(
            "gains energy (1: yes) [-]",
            f64::from(u8::from(run.gains_energy)),
        );
        headlines.extend(figures.lines);
    }
    let mut limit = Figures::of("limit", StopModel::Soft);
    limit.say(
        "right exit over entry speed of the first contact [-]",
        answer.right_ratio,
    );
    limit.say("ωR times step beyond which |R(z)| > 1 [-]", answer.limit);
    limit.say(
        "the same as steps per period, N [-]",
        answer.limit_steps_per_period,
    );
    limit.say(
        "N from which no phase of entry gains energy, of those scanned [-]",
        finer_than(&answer.scan, |scan| scan.failing_share <= 0.0),
    );
    for (share, words) in [(0.01, "1 %"), (0.001, "0.1 %")] {
        limit.say(
            &format!("N from which the ratio is right to {words}, of those scanned [-]"),
            answer.right_ratio.and_then(|right| {
                finer_than(&answer.scan, |scan| {
                    scan.failing_share <= 0.0
                        && (scan.largest_ratio - right).abs() <= share * right
                        && (scan.least_ratio - right).abs() <= share * right
                })
            }),
        );
    }
    headlines.extend(limit.lines);
    headlines
}

/// Returns the fewest steps per period from which on every step of the scan is `good`.
fn finer_than(scan: &[StepScan], good: impl Fn(&StepScan) -> bool) -> Option<f64> {
    scan.iter()
        .rev()
        .take_while(|scan| good(scan))
        .last()
        .map(|scan| scan.steps_per_period)
}

impl StepSize {
    /// Returns the histories as rows: the exact one, then each run.
    pub fn rows(&self) -> impl Iterator<Item = Row> {
        let row = |steps_per_period: Option<u32>, point: &TracePoint| Row {
            steps_per_period,
            time_s: point.time_s,
            angle_rad: point.angle_rad,
            angular_velocity_rad_s: point.velocity_rad_s,
        };
        let exact = self.exact.trace.iter().map(move |point| row(None, point));
        let runs = self.runs.iter().flat_map(move |run| {
            // States that are not finite have no row.
            run.trace
                .iter()
                .filter(|point| point.angle_rad.is_finite() && point.velocity_rad_s.is_finite())
                .map(move |point| row(Some(run.steps_per_period), point))
        });
        exact.chain(runs)
    }
}
