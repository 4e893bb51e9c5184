//! What a lever does for good at one amplitude, or over a few close by: its period, or the largest
//! Lyapunov exponent; and what a fixed-step method makes of the same motion.

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
    /// Amplitudes [g]; the same for one.
    #[serde(rename = "amplitude_g")]
    pub amplitudes_g: Range,
    /// Amplitudes, where least and largest differ.
    pub points: u32,
    /// Periods left out at each.
    pub transient: u32,
    /// Periods kept at each.
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

/// The study's answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Attractor {
    /// What it answers.
    pub options: Options,
    /// Points of the section.
    pub rows: Vec<Row>,
    /// Period at each amplitude, where one was seen that is none of rounding's.
    pub periods: Vec<(f64, Option<u32>)>,
    /// The orbit at a single amplitude, where there is a period.
    pub orbit: Option<Orbit>,
    /// True if the orbit rests on the stop, which makes it attract at once.
    pub superstable: bool,
    /// How small differences grow at a single amplitude.
    pub growth: Option<Growth>,
    /// Over several amplitudes.
    pub statistics: Option<Statistics>,
    /// True if the work was done to its end.
    pub complete: bool,
}

/// Distance of two states that are taken for the same [rad].
const SAME: f64 = 1e-9;

/// What one amplitude gave.
struct AmplitudeResult {
    amplitude_g: f64,
    sections: Vec<Section>,
    /// Its period, where rounding leaves no doubt of it.
    period: Option<u32>,
    /// How differences grow along what looks like a period.
    growth: Option<Growth>,
    compared: Vec<State>,
    /// True if nobody stopped the fixed-step method.
    whole: bool,
}

/// Follows the lever.
///
/// At one amplitude, a trajectory that shows no period in its first few thousand is joined by
/// others that start next to where it has come: what differs in the sixth digit is soon anywhere
/// on the attractor, and they take less time side by side.
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
    let mut seen: Vec<AmplitudeResult> = control
        .map(side_by_side.len(), |index| {
            let sections = side_by_side[index].clone();
            see(options, amplitude(index), sections, control)
        })
        .into_iter()
        .flatten()
        .collect::<Result<_, _>>()?;
    let mut complete = seen.len() == count as usize && seen.iter().all(|one| one.whole);
    let mut answer = Attractor {
        options: options.clone(),
        rows: Vec::new(),
        orbit: None,
        superstable: false,
        growth: None,
        statistics: None,
        periods: seen
            .iter()
            .map(|one| (one.amplitude_g, one.period))
            .collect(),
        complete,
    };
    if count > 1 {
        answer.statistics = Some(statistics(&seen));
    } else if let Some(only) = seen.first_mut() {
        if let (Some(period), Some(last)) = (only.period, only.sections.last()) {
            let start = last.state();
            answer.orbit = orbit::find(&options.forced, only.amplitude_g, period, start);
            answer.superstable = answer
                .orbit
                .as_ref()
                .is_some_and(|orbit| orbit.spectral_radius() < 1e-12);
            answer.growth = only.growth;
        } else {
            let (growth, whole) = measured(options, only, control)?;
            answer.growth = growth;
            complete &= whole && more(options, only, control)?;
        }
    }
    answer.complete = complete;
    answer.rows = seen.iter().flat_map(rows).collect();
    Ok(answer)
}

/// Periods of one trajectory that a search for its period takes.
const FOLLOWED: u32 = 3_000;

/// Sections at one amplitude.
fn alone(options: &Options, amplitude_g: f64) -> Result<Vec<Section>, Error> {
    let mut strobe = options.forced.strobe(amplitude_g, options.initial)?;
    let wanted = options.periods.min(FOLLOWED) as usize;
    let mut sections = Vec::with_capacity(wanted);
    let followed = (0..options.transient).all(|_| strobe.advance().is_some());
    while followed && sections.len() < wanted {
        let Some(section) = strobe.advance() else {
            break;
        };
        sections.push(section);
    }
    Ok(sections)
}

/// Sections at each of `count` amplitudes; fewer if somebody stopped that.
fn together(
    options: &Options,
    count: usize,
    amplitude: &(impl Fn(usize) -> f64 + Sync),
    control: &Control<'_>,
) -> Result<Vec<Vec<Section>>, Error> {
    let followed = options.forced.follow(
        count,
        |index| (options.initial, amplitude(index)),
        (options.transient + options.periods, options.periods, false),
        control,
    )?;
    // Where the work was stopped, the first gap ends what is kept.
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
    let (compared, whole) = options
        .compared_steps
        .map_or(Ok((Vec::new(), true)), |steps| {
            compare(options, amplitude_g, steps, control)
        })?;
    let apparent = orbit::period_of(&options.forced, &sections, SAME);
    // A period that rounding has made is none.
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
        whole,
    })
}

/// Trajectories that start next to `state`, one after the other.
fn beside(options: &Options, state: State, index: usize) -> State {
    /// How far apart [rad].
    const APART: f64 = 1e-6;
    let away = APART * (index + 1) as f64;
    State::new(
        state.angle_rad.abs() + away,
        state.velocity_rad_s + away * options.forced.angular_frequency_rad_s,
    )
}

/// Periods after which trajectories that were next to each other are anywhere.
const APART_AFTER: u32 = 200;

/// Measures how differences grow, on a few trajectories; and whether nobody stopped that.
fn measured(
    options: &Options,
    seen: &AmplitudeResult,
    control: &Control<'_>,
) -> Result<(Option<Growth>, bool), Error> {
    const TRAJECTORIES: usize = 4;
    const PERIODS: u32 = 3_000;
    let Some(last) = seen.sections.last().map(Section::state) else {
        return Ok((None, true));
    };
    let stretches: Vec<GrowthSegment> = control
        .map(TRAJECTORIES, |index| {
            orbit::stretch(
                &options.forced,
                seen.amplitude_g,
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
    let whole = stretches.len() == TRAJECTORIES;
    Ok((orbit::growth(&stretches), whole))
}

/// Adds sections up to the number asked for; tells whether nobody stopped that.
fn more(
    options: &Options,
    seen: &mut AmplitudeResult,
    control: &Control<'_>,
) -> Result<bool, Error> {
    const TRAJECTORIES: u32 = 64;
    let missing = options.periods.saturating_sub(FOLLOWED);
    let Some(last) = seen.sections.last().map(Section::state) else {
        return Ok(true);
    };
    if missing == 0 {
        return Ok(true);
    }
    let each = missing.div_ceil(TRAJECTORIES);
    let count = missing.div_ceil(each) as usize;
    let followed = options.forced.follow(
        count,
        |index| (Some(beside(options, last, index)), seen.amplitude_g),
        (APART_AFTER + each, each, false),
        control,
    )?;
    let whole = followed.len() == count;
    seen.sections.extend(
        followed
            .into_iter()
            .filter(|lever| lever.ending == Ending::Periods)
            .flat_map(|lever| lever.sections)
            .take(missing as usize),
    );
    Ok(whole)
}

/// The same by the fixed-step method with `steps` per period of the excitation. Its grid begins
/// anew with each period, on the very instants on which it would go on. Tells whether nobody
/// stopped that.
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
        // Of several amplitudes each is short, and their number says how far the work is.
        if options.amplitudes() == 1 && !(control.proceed)(Some(f64::from(index) / f64::from(last)))
        {
            return Ok((states, false));
        }
        let outcome = replay::run_harmonic(&excitation, period, &forced.design, &run)?;
        let mut state = State::new(
            outcome.run.final_angle_rad,
            outcome.run.final_velocity_rad_s,
        );
        if forced.stop == latchgate_kernel::model::stop::StopModel::Rigid {
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

fn rows(seen: &AmplitudeResult) -> Vec<Row> {
    let exact = seen.sections.iter().map(|section| Row {
        method: "event-driven",
        amplitude_g: seen.amplitude_g,
        angle_rad: section.angle_rad,
        angular_velocity_rad_s: section.velocity_rad_s,
    });
    let compared = seen.compared.iter().map(|state| Row {
        method: "rk4",
        amplitude_g: seen.amplitude_g,
        angle_rad: state.angle_rad,
        angular_velocity_rad_s: state.velocity_rad_s,
    });
    exact.chain(compared).collect()
}

fn statistics(seen: &[AmplitudeResult]) -> Statistics {
    let mean_of = |of: &dyn Fn(&Section) -> f64| {
        let means: Vec<f64> = seen
            .iter()
            .filter(|seen| !seen.sections.is_empty())
            .map(|seen| seen.sections.iter().map(of).sum::<f64>() / seen.sections.len() as f64)
            .collect();
        let count = means.len() as f64;
        let mean = means.iter().sum::<f64>() / count;
        let spread: f64 = means.iter().map(|one| (one - mean) * (one - mean)).sum();
        Mean {
            mean,
            standard_error: (spread / (count * (count - 1.0).max(1.0))).sqrt(),
        }
    };
    Statistics {
        angle_rad: mean_of(&|section| section.angle_rad),
        angular_velocity_rad_s: mean_of(&|section| section.velocity_rad_s),
        share_beyond_1_rad: mean_of(&|section| f64::from(u8::from(section.angle_rad > 1.0))),
        periodic: u32::try_from(seen.iter().filter(|one| one.period.is_some()).count())
            .unwrap_or(u32::MAX),
        amplitudes: u32::try_from(seen.len()).unwrap_or(u32::MAX),
    }
}

impl Attractor {
    /// Returns what to take away.
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

/// Says how small differences grow in a motion without a period.
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

/// Returns how many of `states` are further than `apart` [rad] from all before them.
fn distinct(forced: &ForcedLever, states: &[State], apart: f64) -> usize {
    let mut kept: Vec<State> = Vec::new();
    for state in states {
        if kept.len() >= 5000 {
            break;
        }
        if kept
            .iter()
            .all(|other| forced.distance(*state, *other) > apart)
        {
            kept.push(*state);
        }
    }
    kept.len()
}
