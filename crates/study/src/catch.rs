//! An inertia catch under two pulses, against the gap between them, and under ringing, against its frequency.
//!
//! Each pulse alone may be held, and every static number may hold, where the whole record opens: the catch falls
//! back between two pulses, and does not follow a fast ringing.

use super::{Figures, Headline};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::catch::Catch;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::pulse::{Pulse, Vertex};
use latchgate_kernel::replay::{self, RunOptions};
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY, SampleRate};
use latchgate_recording::error::Error;
use serde::Serialize;

/// Options of the study.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Options {
    /// Lever and catch.
    pub design: Design,
    /// Stops to run.
    #[serde(rename = "model")]
    pub models: Vec<StopModel>,
    /// Plateau of each of the two pulses [g].
    pub pulse_g: f64,
    /// Amplitude of the ringing [g].
    pub ringing_g: f64,
    /// Values of the gap and of the frequency.
    pub points: u32,
}

/// Most values of gap and frequency.
pub const POINTS_MAX: u32 = 10_000;

/// Longest gap [s].
pub const GAP_MAX_S: f64 = 0.04;

/// Frequencies of the ringing, from and to [Hz].
pub const FREQUENCIES_HZ: (f64, f64) = (20.0, 2000.0);

/// Rise and fall of a pulse [s].
const EDGE_S: f64 = 0.001;

/// Plateau of a pulse [s].
const PLATEAU_S: f64 = 0.01;

/// Half-waves of a ringing, the opening one first.
const HALF_WAVES: u32 = 24;

/// How long the lever is watched after the excitation [s].
const TAIL_S: f64 = 0.05;

/// What excites the lever.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scene {
    /// Two equal trapezoids, against the gap between them [s].
    TwoPulses,
    /// Triangle waves of both signs, against their frequency [Hz].
    Ringing,
}

/// What stands beside the lever.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Beside {
    /// Nothing.
    Nothing,
    /// The catch, falling back.
    ReversibleCatch,
    /// The catch, which once at its end stop stays there.
    IrreversibleCatch,
}

impl Beside {
    /// Every one, in the order of the charts.
    pub const ALL: [Self; 3] = [
        Self::Nothing,
        Self::ReversibleCatch,
        Self::IrreversibleCatch,
    ];

    /// Returns what it is called.
    pub fn title(self) -> &'static str {
        match self {
            Self::Nothing => "lever alone",
            Self::ReversibleCatch => "reversible catch",
            Self::IrreversibleCatch => "irreversible catch",
        }
    }

    fn applied(self, design: &Design) -> Design {
        let with = |reversible| {
            let catch = design.catch?;
            Some(Catch {
                reversible,
                ..catch
            })
        };
        Design {
            catch: match self {
                Self::Nothing => None,
                Self::ReversibleCatch => with(true),
                Self::IrreversibleCatch => with(false),
            },
            ..design.clone()
        }
    }
}

/// A row of the table.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Row {
    /// What excites the lever.
    pub scene: Scene,
    /// Stop model.
    pub stop: StopModel,
    /// What stands beside it.
    pub beside: Beside,
    /// Gap [s] or frequency [Hz].
    pub value: f64,
    /// Largest angle, of the excitation and after it [rad]; `None` where the lever could not be followed, or
    /// where its errors do not say whether it or the catch came first.
    pub peak_angle_rad: Option<f64>,
    /// Whether that exceeds the limit.
    pub opens: Option<bool>,
    /// First time the catch engages [s].
    pub engaged_s: Option<f64>,
    /// First time the lever comes to the catch [s].
    pub lever_arrives_s: Option<f64>,
    /// First time it goes past it [s].
    pub lever_passes_s: Option<f64>,
}

/// The study's answer.
#[derive(Debug, Clone, PartialEq)]
pub struct CatchStudy {
    /// The table.
    pub rows: Vec<Row>,
    /// Limit of the angle [rad].
    pub threshold_rad: f64,
    /// What to take away.
    pub headlines: Vec<Headline>,
}

/// Returns the example: the paper's lever with ten times its preload, and a catch of no vehicle.
pub fn example() -> Design {
    let mut design = Design::reference();
    design.name = "example of a lever with an inertia catch".into();
    design.lever.preload_torque_nm = 1.0;
    design.catch = Some(Catch {
        moment_of_inertia_kg_m2: 1e-6,
        pivot_damping_nm_s_per_rad: 1e-6,
        spring_stiffness_nm_per_rad: 0.002,
        preload_torque_nm: 0.0037,
        unbalance_kg_m: 4.8e-5,
        engagement_angle_rad: 0.15,
        end_stop_angle_rad: 0.3,
        lever_angle_rad: 0.06,
        rest_restitution: 0.4,
        end_stop_restitution: 0.4,
        engagement_restitution: 0.3,
        reversible: true,
    });
    design
}

/// Runs the study.
///
/// # Errors
///
/// [`OutOfRange`](latchgate_kernel::error::Error::OutOfRange) for a design without a catch; as [`replay::run`];
/// [`Stopped`](latchgate_kernel::error::Error::Stopped).
pub fn run(options: &Options, control: &Control<'_>) -> Result<CatchStudy, Error> {
    if options.design.catch.is_none() {
        return Err(Error::out_of_range(
            "the design",
            "one with an inertia catch, [catch]",
            "the lever alone",
        ));
    }
    let mut tasks = Vec::new();
    for model in &options.models {
        for beside in Beside::ALL {
            let gaps = gaps_s(options.points);
            tasks.extend(gaps.map(|gap| (Scene::TwoPulses, *model, beside, gap)));
            let frequencies = frequencies_hz(options.points);
            tasks.extend(frequencies.map(|hertz| (Scene::Ringing, *model, beside, hertz)));
        }
    }
    let rows = control.try_map(&tasks, |(scene, model, beside, value)| {
        row(options, *scene, *model, *beside, *value)
    })?;
    Ok(CatchStudy {
        headlines: headlines(options, &rows)?,
        threshold_rad: options.design.criterion.threshold_rad,
        rows,
    })
}

/// Returns the gaps [s], whole intervals of [`GAP_STEP_S`].
fn gaps_s(points: u32) -> impl Iterator<Item = f64> {
    let last = points.max(2) - 1;
    (0..=last).map(move |index| {
        let gap_s = GAP_MAX_S * f64::from(index) / f64::from(last);
        (gap_s / GAP_STEP_S).round() * GAP_STEP_S
    })
}

/// Returns the frequencies [Hz], by equal ratios.
fn frequencies_hz(points: u32) -> impl Iterator<Item = f64> {
    let (low, high) = FREQUENCIES_HZ;
    let last = points.max(2) - 1;
    (0..=last).map(move |index| low * libm::pow(high / low, f64::from(index) / f64::from(last)))
}

/// Samples of the two pulses lie this far apart, so that every gap of the table is a whole number of them [s].
const GAP_STEP_S: f64 = 1e-5;

/// As [`GAP_STEP_S`], where the gap from which two pulses open is sought [s].
const FINE_STEP_S: f64 = 1e-6;

fn row(
    options: &Options,
    scene: Scene,
    stop: StopModel,
    beside: Beside,
    value: f64,
) -> Result<Row, Error> {
    row_at(options, (scene, stop, beside), value, GAP_STEP_S)
}

fn row_at(
    options: &Options,
    (scene, stop, beside): (Scene, StopModel, Beside),
    value: f64,
    step_s: f64,
) -> Result<Row, Error> {
    let (pulse, interval_s) = match scene {
        Scene::TwoPulses => (two_pulses(options.pulse_g, value), step_s),
        // Twenty samples of each half-wave: its three vertices are among them.
        Scene::Ringing => (ringing(options.ringing_g, value), 0.025 / value),
    };
    let rate = SampleRate::from_hertz(1.0 / interval_s)?;
    let tail = (TAIL_S / interval_s).ceil() as usize;
    let reading = pulse.reading(rate, tail)?;
    let outcome = replay::run(
        &reading,
        &beside.applied(&options.design),
        &RunOptions::new(stop, OpensWhen::Negative),
    )?;
    let catch = outcome.catch.unwrap_or_default();
    let run = outcome.run;
    let highest = run
        .coast_peak_angle_rad
        .unwrap_or(0.0)
        .max(run.peak_angle_rad);
    let is_known = !outcome.broke_down && catch.tie_s.is_none();
    let peak_angle_rad = is_known.then_some(highest);
    Ok(Row {
        scene,
        stop,
        beside,
        value,
        peak_angle_rad,
        opens: peak_angle_rad.map(|peak| peak > options.design.criterion.threshold_rad),
        engaged_s: catch.engaged_s,
        lever_arrives_s: catch.lever_arrives_s,
        lever_passes_s: catch.lever_passes_s,
    })
}

/// Returns two equal trapezoids with a gap between them, negative, which opens [m/s²].
fn two_pulses(pulse_g: f64, gap_s: f64) -> Pulse {
    let level = -pulse_g * STANDARD_GRAVITY;
    let of_one = |start: f64| {
        [
            Vertex::new(start, 0.0),
            Vertex::new(start + EDGE_S, level),
            Vertex::new(start + EDGE_S + PLATEAU_S, level),
            Vertex::new(start + 2.0 * EDGE_S + PLATEAU_S, 0.0),
        ]
    };
    let second = 2.0 * EDGE_S + PLATEAU_S + gap_s;
    Pulse::Polyline([of_one(0.0), of_one(second)].concat())
}

/// Returns triangle waves of a frequency [Hz], the opening half first [m/s²].
fn ringing(amplitude_g: f64, frequency_hz: f64) -> Pulse {
    let level = amplitude_g * STANDARD_GRAVITY;
    let half_s = 0.5 / frequency_hz;
    let mut vertices = vec![Vertex::new(0.0, 0.0)];
    for half in 0..HALF_WAVES {
        let start = f64::from(half) * half_s;
        let value = if half % 2 == 0 { -level } else { level };
        vertices.push(Vertex::new(start + 0.5 * half_s, value));
        vertices.push(Vertex::new(start + half_s, 0.0));
    }
    Pulse::Polyline(vertices)
}

fn headlines(options: &Options, rows: &[Row]) -> Result<Vec<Headline>, Error> {
    let design = &options.design;
    let mut headlines = Vec::new();
    for model in &options.models {
        let mut figures = Figures::of("static", *model);
        let g = |acceleration: f64| acceleration / STANDARD_GRAVITY;
        figures.say(
            "lever lifts at [g]",
            g(design.lever.lift_off_acceleration_m_s2()),
        );
        if let Some(catch) = design.catch {
            figures.say("catch lifts at [g]", g(catch.lift_off_acceleration_m_s2()));
            figures.say("speed ratio χ [-]", catch.speed_ratio(&design.lever));
        }
        headlines.extend(figures.lines);
        for beside in Beside::ALL {
            let of_scene = |scene: Scene| {
                let rows = rows.iter();
                rows.filter(move |row| (row.scene, row.stop, row.beside) == (scene, *model, beside))
            };
            let mut figures = Figures::of(format!("two pulses, {}", beside.title()), *model);
            // Beyond the longest gap the second pulse comes as the first one did.
            let opens = |row: &&Row| row.opens == Some(true);
            figures.say("gaps tried [-]", of_scene(Scene::TwoPulses).count() as f64);
            figures.say(
                "gaps that open [-]",
                of_scene(Scene::TwoPulses).filter(opens).count() as f64,
            );
            let pairs: Vec<&Row> = of_scene(Scene::TwoPulses).collect();
            let first_change = pairs
                .windows(2)
                .find(|pair| pair[0].opens == Some(false) && pair[1].opens == Some(true));
            if let Some(pair) = first_change {
                let gap_s = least_gap_s(options, *model, beside, pair[0].value, pair[1].value)?;
                figures = figures.digits(5);
                figures.say("opens from a gap on [ms]", (1e6 * gap_s).round() / 1e3);
            }
            headlines.extend(figures.lines);
            let mut figures = Figures::of(format!("ringing, {}", beside.title()), *model);
            let open = || of_scene(Scene::Ringing).filter(opens).map(|row| row.value);
            figures.say(
                "frequencies tried [-]",
                of_scene(Scene::Ringing).count() as f64,
            );
            figures.say("frequencies that open [-]", open().count() as f64);
            figures.say("lowest that opens [Hz]", open().reduce(f64::min));
            figures.say("highest that opens [Hz]", open().reduce(f64::max));
            headlines.extend(figures.lines);
        }
    }
    Ok(headlines)
}

/// Bisects the gap from which two pulses open, between one that holds and one that opens, to a whole
/// [`FINE_STEP_S`] [s].
fn least_gap_s(
    options: &Options,
    stop: StopModel,
    beside: Beside,
    held_s: f64,
    open_s: f64,
) -> Result<f64, Error> {
    let steps = |gap_s: f64| (gap_s / FINE_STEP_S).round() as u64;
    let (mut held, mut open) = (steps(held_s), steps(open_s));
    while open - held > 1 {
        let middle = held.midpoint(open);
        let case = (Scene::TwoPulses, stop, beside);
        let row = row_at(options, case, middle as f64 * FINE_STEP_S, FINE_STEP_S)?;
        match row.opens {
            Some(false) => held = middle,
            _ => open = middle,
        }
    }
    Ok(open as f64 * FINE_STEP_S)
}
