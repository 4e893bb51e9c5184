//! Lasting motion of a lever at one amplitude, or over a range of amplitudes: its period, or the largest
//! Lyapunov exponent; and the same motion by a fixed-step method.

use super::orbit::{self, ForcedLever, Growth, GrowthSegment, Orbit};
use super::{Figures, Headline};
use latchgate_kernel::model::excitation::Harmonic;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::range::Range;
use latchgate_kernel::replay::strobe_batch::Ending;
use latchgate_kernel::replay::{self, Method, RunOptions, Section, State};
use latchgate_kernel::units::OpensWhen;
use latchgate_recording::error::Error;
use serde::Serialize;

/// Options of one section, or of sections over a range of amplitudes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Options {
    /// Lever, stop, frequency.
    #[serde(flatten)]
    pub forced: ForcedLever,
    /// Amplitudes [g]; least and largest are equal for a single one.
    #[serde(rename = "amplitude_g")]
    pub amplitudes_g: Range,
    /// Number of amplitudes, if least and largest differ.
    pub points: u32,
    /// Periods of the transient at each amplitude, which are not kept.
    pub transient: u32,
    /// Periods kept at each amplitude.
    pub periods: u32,
    /// Initial state; `None` for rest.
    pub initial: Option<State>,
    /// Steps per period of the excitation of the fixed-step method to compare with.
    #[serde(rename = "compare_steps")]
    pub compared_steps: Option<u32>,
}

impl Options {
    /// Returns the number of amplitudes.
    pub fn amplitudes(&self) -> u32 {
        if self.amplitudes_g.low < self.amplitudes_g.high {
            self.points.max(1)
        } else {
            1
        }
    }
}

/// One point of the section.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Row {
    /// `event-driven`, or `rk4` with its steps on the grid.
    pub method: &'static str,
    /// Amplitude [g].
    pub amplitude_g: f64,
    /// Angle at the start of a period [rad].
    pub angle_rad: f64,
    /// Angular velocity there [rad/s].
    pub angular_velocity_rad_s: f64,
}

/// Mean over amplitudes with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Mean {
    /// Mean.
    pub mean: f64,
    /// Standard error, the amplitudes being the sample.
    pub standard_error: f64,
}

/// Statistics over all amplitudes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Statistics {
    /// Angle [rad].
    pub angle_rad: Mean,
    /// Angular velocity [rad/s].
    pub angular_velocity_rad_s: Mean,
    /// Share of sections beyond 1 rad [-].
    pub share_beyond_1_rad: Mean,
    /// Amplitudes with a period of at most a third of the periods kept.
    pub periodic: u32,
    /// Amplitudes.
    pub amplitudes: u32,
}

/// Result of the study.
#[derive(Debug, Clone, PartialEq)]
pub struct Attractor {
    /// Options of the study.
    pub options: Options,
    /// Points of the section.
    pub rows: Vec<Row>,
    /// Period at each amplitude; `None` where none was seen, or only one that rounding made.
    pub periods: Vec<(f64, Option<u32>)>,
    /// The orbit at a single amplitude, if it has a period.
    pub orbit: Option<Orbit>,
    /// True if the orbit rests on the stop, which makes it attract at once.
    pub superstable: bool,
    /// Growth of small differences at a single amplitude.
    pub growth: Option<Growth>,
    /// Statistics over several amplitudes.
    pub statistics: Option<Statistics>,
    /// True if the work was not stopped.
    pub complete: bool,
}

/// Distance below which two states are the same [rad].
const SAME: f64 = 1e-9;

/// Result of one amplitude.
struct AmplitudeResult {
    amplitude_g: f64,
    sections: Vec<Section>,
    /// Its period, if rounding cannot have made it.
    period: Option<u32>,
    /// Growth of differences along the apparent period.
    growth: Option<Growth>,
    compared: Vec<State>,
    /// True if the fixed-step method was not stopped.
    complete: bool,
}

/// Follows the lever.
///
/// At one amplitude, a trajectory that shows no period in its first few thousand is joined by
/// others that start next to its last state: trajectories that differ in the sixth digit soon spread over
/// the attractor, and take less time side by side.
///
/// # Errors
///
/// As [`latchgate_kernel::replay::Strobe::new`] and [`replay::run_harmonic`].
pub fn run(options: &Options, control: &Control<'_>) -> Result<Attractor, Error> {
    let count = options.amplitudes();
    let Range { low, high } = options.amplitudes_g;
    let amplitude = |index: usize| {
        let part = index as f64 / f64::from(count.max(2) - 1);
        low + (high - low) * part
    };
    let side_by_side = if count > 1 {
        together(options, count as usize, &amplitude, control)?
    } else {
        vec![alone(options, low)?]
    };
    let mut results: Vec<AmplitudeResult> = control
        .map(side_by_side.len(), |index| {
            let sections = side_by_side[index].clone();
            see(options, amplitude(index), sections, control)
        })
        .into_iter()
        .flatten()
        .collect::<Result<_, _>>()?;
    let mut complete =
        results.len() == count as usize && results.iter().all(|result| result.complete);
    let mut answer = Attractor {
        options: options.clone(),
        rows: Vec::new(),
        orbit: None,
        superstable: false,
        growth: None,
        statistics: None,
        periods: results
            .iter()
            .map(|result| (result.amplitude_g, result.period))
            .collect(),
        complete,
    };
    if count > 1 {
        answer.statistics = Some(statistics(&results));
    } else if let Some(result) = results.first_mut() {
        if let (Some(period), Some(last)) = (result.period, result.sections.last()) {
            let start = last.state();
            answer.orbit = orbit::find(&options.forced, result.amplitude_g, period, start);
            answer.superstable = answer
                .orbit
                .as_ref()
                .is_some_and(|orbit| orbit.spectral_radius() < 1e-12);
            answer.growth = result.growth;
        } else {
            let (growth, growth_complete) = measured(options, result, control)?;
            answer.growth = growth;
            complete &= growth_complete && more(options, result, control)?;
        }
    }
    answer.complete = complete;
    answer.rows = results.iter().flat_map(rows).collect();
    Ok(answer)
}

/// Longest trajectory in which a period is sought [periods].
const FOLLOWED: u32 = 3_000;

/// Returns the sections at one amplitude.
fn alone(options: &Options, amplitude_g: f64) -> Result<Vec<Section>, Error> {
    let mut strobe = options.forced.strobe(amplitude_g, options.initial)?;
    let sections_max = options.periods.min(FOLLOWED) as usize;
    let mut sections = Vec::with_capacity(sections_max);
    let followed = (0..options.transient).all(|_| strobe.advance().is_some());
    while followed && sections.len() < sections_max {
        let Some(section) = strobe.advance() else {
            break;
        };
        sections.push(section);
    }
    Ok(sections)
}

/// Returns the sections at each of `count` amplitudes; of fewer if the work was stopped.
fn together(
    options: &Options,
    count: usize,
    amplitude: &(impl Fn(usize) -> f64 + Sync),
    control: &Control<'_>,
) -> Result<Vec<Vec<Section>>, Error> {
    let forced = &options.forced;
    let periods_max = options.transient + options.periods;
    let followed = forced.follow(
        count,
        |index| forced.start(options.initial, amplitude(index)),
        &forced.batch(periods_max, options.periods, false, control.threads),
        control,
    )?;
    // Work that was stopped leaves gaps; amplitudes behind the first gap are dropped, so that an index is an amplitude.
    Ok(followed
        .into_iter()
        .enumerate()
        .take_while(|(index, lever)| lever.index == *index)
        .map(|(_, lever)| match lever.ending {
            Ending::Lost => Vec::new(),
            Ending::Done | Ending::Periods => lever.sections,
        })
        .collect())
}

fn see(
    options: &Options,
    amplitude_g: f64,
    sections: Vec<Section>,
    control: &Control<'_>,
) -> Result<AmplitudeResult, Error> {
    let (compared, complete) = options
        .compared_steps
        .map_or(Ok((Vec::new(), true)), |steps| {
            compare(options, amplitude_g, steps, control)
        })?;
    let apparent = orbit::period_of(&options.forced, &sections, SAME);
    // Rounding can make a chaotic motion repeat itself. Such a period shows by differences that grow along it.
    let growth = match (apparent, sections.last()) {
        (Some(period), Some(last)) => orbit::difference_growth(
            &options.forced,
            amplitude_g,
            Some(last.state()),
            0,
            2 * period,
        )?,
        _ => None,
    };
    Ok(AmplitudeResult {
        amplitude_g,
        period: apparent.filter(|_| growth.is_none_or(|growth| growth.resolved())),
        growth,
        sections,
        compared,
        complete,
    })
}

/// Returns the start of trajectory `index` next to `state`.
fn beside(options: &Options, state: State, index: usize) -> State {
    /// Distance between neighbouring starts [rad].
    const APART: f64 = 1e-6;
    let away = APART * (index + 1) as f64;
    State::new(
        state.angle_rad.abs() + away,
        state.velocity_rad_s + away * options.forced.angular_frequency_rad_s,
    )
}

/// Periods after which neighbouring trajectories have spread over the attractor.
const APART_AFTER: u32 = 200;

/// Measures the growth of differences on a few trajectories; false if the work was stopped.
fn measured(
    options: &Options,
    result: &AmplitudeResult,
    control: &Control<'_>,
) -> Result<(Option<Growth>, bool), Error> {
    const TRAJECTORIES: usize = 4;
    const PERIODS: u32 = 3_000;
    let Some(last) = result.sections.last().map(Section::state) else {
        return Ok((None, true));
    };
    let stretches: Vec<GrowthSegment> = control
        .map(TRAJECTORIES, |index| {
            orbit::stretch(
                &options.forced,
                result.amplitude_g,
                Some(beside(options, last, index)),
                APART_AFTER,
                PERIODS,
            )
        })
        .into_iter()
        .flatten()
        .collect::<Result<Vec<_>, _>>()?
        .into_iter()
        .flatten()
        .collect();
    let complete = stretches.len() == TRAJECTORIES;
    Ok((orbit::growth(&stretches), complete))
}

/// Adds sections up to the requested number; false if the work was stopped.
fn more(
    options: &Options,
    result: &mut AmplitudeResult,
    control: &Control<'_>,
) -> Result<bool, Error> {
    const TRAJECTORIES: u32 = 64;
    let missing = options.periods.saturating_sub(FOLLOWED);
    let Some(last) = result.sections.last().map(Section::state) else {
        return Ok(true);
    };
    if missing == 0 {
        return Ok(true);
    }
    let each = missing.div_ceil(TRAJECTORIES);
    let count = missing.div_ceil(each) as usize;
    let forced = &options.forced;
    let followed = forced.follow(
        count,
        |index| forced.start(Some(beside(options, last, index)), result.amplitude_g),
        &forced.batch(APART_AFTER + each, each, false, control.threads),
        control,
    )?;
    let complete = followed.len() == count;
    result.sections.extend(
        followed
            .into_iter()
            .filter(|lever| lever.ending == Ending::Periods)
            .flat_map(|lever| lever.sections)
            .take(missing as usize),
    );
    Ok(complete)
}

/// Returns the sections by the fixed-step method with `steps` per period of the excitation; false if the work was
/// stopped. The grid restarts with each period, at the same instants as an unbroken one.
fn compare(
    options: &Options,
    amplitude_g: f64,
    steps: u32,
    control: &Control<'_>,
) -> Result<(Vec<State>, bool), Error> {
    let forced = &options.forced;
    let period = std::f64::consts::TAU / forced.angular_frequency_rad_s;
    let excitation: Harmonic = forced.sine(amplitude_g);
    let mut run = RunOptions {
        method: Method::Rk4 {
            steps_per_period: steps,
        },
        step_s: Some(period / f64::from(steps)),
        initial: options.initial,
        error_bound: false,
        ..RunOptions::new(forced.stop, OpensWhen::Negative)
    };
    let mut states = Vec::new();
    let last = options.transient + options.periods;
    for index in 0..last {
        // With several amplitudes each is short, and their count is the progress.
        if options.amplitudes() == 1 && !(control.proceed)(Some(f64::from(index) / f64::from(last)))
        {
            return Ok((states, false));
        }
        let outcome = replay::run_harmonic(&excitation, period, &forced.design, &run)?;
        let mut state = State::new(
            outcome.run.final_angle_rad,
            outcome.run.final_velocity_rad_s,
        );
        if !forced.stop.yields() {
            state.angle_rad = state.angle_rad.max(0.0);
        }
        let bounded = state.angle_rad.abs() <= 100.0 && state.velocity_rad_s.abs() <= 1e5;
        if outcome.broke_down || !bounded {
            break;
        }
        run.initial = Some(state);
        if index >= options.transient {
            states.push(state);
        }
    }
    Ok((states, true))
}

fn rows(result: &AmplitudeResult) -> Vec<Row> {
    let exact = result.sections.iter().map(|section| Row {
        method: "event-driven",
        amplitude_g: result.amplitude_g,
        angle_rad: section.angle_rad,
        angular_velocity_rad_s: section.velocity_rad_s,
    });
    let compared = result.compared.iter().map(|state| Row {
        method: "rk4",
        amplitude_g: result.amplitude_g,
        angle_rad: state.angle_rad,
        angular_velocity_rad_s: state.velocity_rad_s,
    });
    exact.chain(compared).collect()
}

fn statistics(results: &[AmplitudeResult]) -> Statistics {
    let mean_of = |quantity: &dyn Fn(&Section) -> f64| {
        let means: Vec<f64> = results
            .iter()
            .filter(|result| !result.sections.is_empty())
            .map(|result| {
                result.sections.iter().map(quantity).sum::<f64>() / result.sections.len() as f64
            })
            .collect();
        let count = means.len() as f64;
        let mean = means.iter().sum::<f64>() / count;
        let spread: f64 = means
            .iter()
            .map(|value| (value - mean) * (value - mean))
            .sum();
        Mean {
            mean,
            standard_error: (spread / (count * (count - 1.0).max(1.0))).sqrt(),
        }
    };
    Statistics {
        angle_rad: mean_of(&|section| section.angle_rad),
        angular_velocity_rad_s: mean_of(&|section| section.velocity_rad_s),
        share_beyond_1_rad: mean_of(&|section| f64::from(u8::from(section.angle_rad > 1.0))),
        periodic: u32::try_from(
            results
                .iter()
                .filter(|result| result.period.is_some())
                .count(),
        )
        .unwrap_or(u32::MAX),
        amplitudes: u32::try_from(results.len()).unwrap_or(u32::MAX),
    }
}

impl Attractor {
    /// Returns the headline figures.
    pub fn headlines(&self) -> Vec<Headline> {
        let forced = &self.options.forced;
        let Range { low, high } = self.options.amplitudes_g;
        let subject = if self.options.amplitudes() > 1 {
            format!(
                "A = {low} to {high} g, ω = {} rad/s",
                forced.angular_frequency_rad_s
            )
        } else {
            format!("A = {low} g, ω = {} rad/s", forced.angular_frequency_rad_s)
        };
        let mut figures = Figures::of(subject, forced.stop);
        if let Some(statistics) = &self.statistics {
            statistics.say(&mut figures);
            return figures.lines;
        }
        let period = self.periods.first().and_then(|(_, period)| *period);
        figures.say("period [periods of the excitation]", period.map(f64::from));
        if let Some(orbit) = &self.orbit {
            let modulus = orbit.spectral_radius();
            figures.say("largest modulus of its multipliers [-]", modulus);
            figures.say("largest angle [rad]", orbit.peak_angle_rad);
        }
        if let Some(growth) = &self.growth {
            if period.is_none() {
                say_growth(&mut figures, growth);
            }
            figures.say(
                "decades by which rounding grows at most [-]",
                growth.decades_max,
            );
        }
        if self.options.compared_steps.is_some() {
            let compared: Vec<State> = self
                .rows
                .iter()
                .filter(|row| row.method == "rk4")
                .map(|row| State::new(row.angle_rad, row.angular_velocity_rad_s))
                .collect();
            figures.say(
                "rk4: distinct points of its section, 1e-6 rad apart [-]",
                distinct(forced, &compared, 1e-6) as f64,
            );
        }
        figures.lines
    }
}

impl Statistics {
    fn say(&self, figures: &mut Figures) {
        let (angle, velocity) = (self.angle_rad, self.angular_velocity_rad_s);
        let beyond = self.share_beyond_1_rad;
        figures.say("mean angle of the sections [rad]", angle.mean);
        figures.say("its standard error [rad]", angle.standard_error);
        figures.say("mean angular velocity [rad/s]", velocity.mean);
        figures.say("its standard error [rad/s]", velocity.standard_error);
        figures.say("share of sections beyond 1 rad [-]", beyond.mean);
        figures.say("its standard error [-]", beyond.standard_error);
        figures.say("amplitudes with a period [-]", f64::from(self.periodic));
    }
}

/// Adds the growth of small differences in a motion without a period.
fn say_growth(figures: &mut Figures, growth: &Growth) {
    let exponent = growth.lyapunov();
    figures.say("largest Lyapunov exponent per period [-]", exponent);
    if exponent.is_some() {
        figures.say("its standard error [-]", growth.standard_error);
    } else {
        figures.say(
            "share of periods with a rest [-]",
            f64::from(growth.rests) / f64::from(growth.periods),
        );
        figures.say(
            "decades by which differences shrink at most [-]",
            growth.shrunk_max,
        );
    }
    if let Some(returned) = growth.returned {
        figures.say(
            "periods after which the digits repeat, by rounding [-]",
            f64::from(returned),
        );
    }
}

/// Returns the number of `states` that are further than `apart` [rad] from all before them, 5000 at most.
fn distinct(forced: &ForcedLever, states: &[State], apart: f64) -> usize {
    let mut distinct_states: Vec<State> = Vec::new();
    for state in states {
        if distinct_states.len() >= 5000 {
            break;
        }
        if distinct_states
            .iter()
            .all(|earlier| forced.distance(*state, *earlier) > apart)
        {
            distinct_states.push(*state);
        }
    }
    distinct_states.len()
}
