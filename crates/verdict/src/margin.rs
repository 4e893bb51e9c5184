//! How far a verdict is from changing, and what design would change it.
//!
//! Each quantity (scale of the recording, preload, unbalance, counterweight, restitution) is
//! varied alone over a stated range; every value at which the answer changes is listed, and the
//! one nearest to the present is the margin.
//!
//! - `advice`: the value from which on every value that is searched passes by the whole rule;
//! - `change`: where the verdict by the whole rule changes, which is dear to ask for;
//! - `limit`: the design's limit under half-sine pulses: amplitude against change of velocity;
//! - `map`: a map of the peak angle over two design keys, with the boundary of the pass;
//! - `margin_search`: the search for the margin of one quantity: first where the nominal runs
//!   change their answer, then, from there, where the verdict by the whole rule does;
//! - `preload`: the preload that a recording asks for, as a report quotes it;
//! - `quantity`: the quantities that a margin varies: what each does to the lever, over which
//!   range, on which grid;
//! - `runs`: the nominal runs that a search rests on: of one trial, or of many side by side;
//! - `search`: every value of one quantity at which the answer changes, found on a grid and then
//!   narrowed.

mod advice;
mod change;
pub mod limit;
pub mod map;
mod margin_search;
mod preload;
pub mod quantity;
mod runs;
pub mod search;

pub use advice::Advice;
pub use limit::{LimitCurve, LimitPoint, RecordingPoint, critical_pulse};
pub use map::{Map, MapAxis, MapRequest, MapVertex};
pub use preload::PreloadAnswer;
pub use preload::preload_answer;
pub use quantity::Quantity;

use crate::Policy;
use crate::conditioning::{Conditioned, Signal};
use crate::meter::Meter;
use latchgate_kernel::error::Error as KernelError;
use latchgate_kernel::model::Design;
use latchgate_kernel::parallel::Control;
use latchgate_recording::Finding;
use latchgate_recording::error::Error;
use margin_search::MarginSearch;
use quantity::SearchRange;
use runs::NominalRuns;
use search::{Crossing, Excess, SearchResult};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The answer of the nominal runs at one value of a quantity, no error counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NominalAnswer {
    /// No run goes beyond the threshold.
    Pass,
    /// Every run does (polarities declared as both: every run of one of them).
    Fail,
    /// Stops or polarities differ, or only the coast goes beyond.
    Undecided,
}

impl NominalAnswer {
    /// Returns its word.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "fail",
            Self::Undecided => "undecided",
        }
    }
}

/// The answers whose change is looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Basis {
    /// The nominal run's peak against the threshold, no error counted.
    #[serde(rename = "nominal run")]
    NominalRun,
    /// The verdict by the whole rule.
    #[serde(rename = "verdict")]
    Verdict,
}

/// Options of one search for margins.
#[derive(Debug, Clone, PartialEq)]
pub struct MarginOptions {
    /// The question of the verdict.
    pub policy: Policy,
    /// The answer whose change is looked for.
    pub basis: Basis,
    /// Distance of the counterweight from the pivot [m].
    pub counterweight_radius_m: f64,
    /// Values of a quantity that a search begins with; `None` for as many as the length of the
    /// recording allows, [`POINTS_MIN`] to [`POINTS_MAX`].
    pub points: Option<usize>,
    /// The map over two design keys.
    pub map: Option<MapRequest>,
    /// Find the limit under half-sine pulses.
    pub limit: bool,
}

/// Values that the search of a short recording begins with.
pub const POINTS_MAX: usize = 1200;

/// Values that the search of a long recording begins with.
pub const POINTS_MIN: usize = 200;

/// Times as many steps that a search for margins may take as a verdict.
const WORK_TIMES: u64 = 20;

/// A change of the answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Boundary {
    /// The quantity varied: [`Quantity::name`].
    pub quantity: Cow<'static, str>,
    /// Its unit; empty for a ratio.
    pub unit: Cow<'static, str>,
    /// The end of the bracket with the better answer: the last value still to pass, or not yet
    /// to fail.
    pub at: f64,
    /// Values between which the answer changes.
    pub bracket: (f64, f64),
    /// The answer of the nominal runs below.
    pub below: NominalAnswer,
    /// Their answer above.
    pub above: NominalAnswer,
}

impl Boundary {
    fn new(quantity: Quantity, crossing: &Crossing) -> Self {
        Self {
            quantity: quantity.name().into(),
            unit: quantity.unit().into(),
            at: crossing.better_end(),
            bracket: (crossing.low.0, crossing.high.0),
            below: crossing.low.1.state(),
            above: crossing.high.1.state(),
        }
    }
}

/// The least change of one quantity that changes the answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Margin {
    /// The quantity varied.
    pub quantity: Quantity,
    /// Its title.
    pub title: Cow<'static, str>,
    /// Its unit; empty for a ratio.
    pub unit: Cow<'static, str>,
    /// Its value at present.
    pub present: f64,
    /// The answer it rests on is a pass at present.
    pub passes_at_present: bool,
    /// The value that still passes (or first passes) where the answer changes; `None` if no
    /// value searched changes it.
    pub at: Option<f64>,
    /// Values between which the answer changes.
    pub bracket: Option<(f64, f64)>,
    /// The change from the present value [%]; `None` without an answer or a present value.
    pub change_percent: Option<f64>,
    /// The answer it rests on.
    pub basis: Basis,
    /// The same of the nominal run's peak, no error counted.
    pub nominal_at: Option<f64>,
    /// Its bracket.
    pub nominal_bracket: Option<(f64, f64)>,
    /// The same of the verdict, by the whole rule.
    pub verdict_at: Option<f64>,
    /// Its bracket.
    pub verdict_bracket: Option<(f64, f64)>,
    /// Why there is no value, where there is none.
    pub reason: Option<String>,
    /// Least and greatest value searched.
    pub searched: (f64, f64),
    /// Values that the search looked at before it narrowed any change down.
    pub values: usize,
    /// Changes between pass and no pass of the nominal runs within the range.
    pub changes: usize,
    /// Where the nominal runs change between pass and no pass for the last time on the way to
    /// the end of the range that they pass at, the safer one if they pass at both; `None` if they
    /// pass at none.
    pub settled_at: Option<f64>,
    /// The convention: what stays and what moves along.
    pub convention: Cow<'static, str>,
    /// From where on every value searched passes by the whole rule.
    pub advice: Advice,
    /// The change is one to a pass between which and the advice values were not found to pass.
    pub isolated: bool,
}

/// The peak over a quantity, as the search saw it.
#[derive(Debug, Clone, PartialEq)]
pub struct Scan {
    /// The quantity varied.
    pub quantity: Quantity,
    /// Its value at present.
    pub present: f64,
    /// Distances are ratios.
    pub ratios: bool,
    /// Value, and the largest angle of window and coast of all stops and polarities that count
    /// [rad]; `None` where the lever could not be followed.
    pub points: Vec<(f64, Option<f64>)>,
}

impl Scan {
    fn new(quantity: Quantity, range: &SearchRange, found: &SearchResult, design: &Design) -> Self {
        let peak = |(at, excess): &(f64, Excess)| {
            let peak = excess.pass + design.criterion.threshold_rad;
            (*at, peak.is_finite().then_some(peak))
        };
        Self {
            quantity,
            present: range.present,
            ratios: range.ratios,
            points: found.points.iter().map(peak).collect(),
        }
    }
}

/// The margins of one verdict.
#[derive(Debug, Clone, PartialEq)]
pub struct Margins {
    /// The answer of the nominal runs at present, no error counted.
    pub state: NominalAnswer,
    /// The answer that the margins rest on.
    pub basis: Basis,
    /// One answer per quantity, in the order of [`Quantity::ALL`].
    pub answers: Vec<Margin>,
    /// Every change of the nominal runs' answer.
    pub boundaries: Vec<Boundary>,
    /// The peaks that the searches saw.
    pub scans: Vec<Scan>,
    /// The design's limit, if asked for.
    pub limit: Option<LimitCurve>,
    /// The map, if asked for.
    pub map: Option<Map>,
    /// The recording carries a blocking finding: all of this rests on spoiled samples.
    pub spoiled: bool,
    /// The search was stopped: what it had until then is here, limit and map are not.
    pub stopped: bool,
}

/// Finds the margins of the verdict on `conditioned`; `findings` are those of reading and
/// conditioning.
///
/// # Errors
///
/// As [`crate::assess()`], [`Stopped`](latchgate_kernel::error::Error::Stopped) only if no quantity was answered until
/// then; those of [`MapRequest::check`].
pub fn margins(
    conditioned: &Conditioned,
    findings: &[Finding],
    design: &Design,
    options: &MarginOptions,
    control: &Control<'_>,
) -> Result<Margins, Error> {
    if let Some(request) = &options.map {
        request.check(design)?;
    }
    let progress = SearchProgress::new(control, options);
    let quiet = |_: Option<f64>| progress.proceed();
    let control = &Control {
        threads: control.threads,
        proceed: &quiet,
    };
    let work = Meter::new(options.policy.work.saturating_mul(WORK_TIMES));
    let search = MarginSearch::new(conditioned, findings, design, options, control, &work)?;
    let mut answers = Vec::new();
    let mut boundaries = Vec::new();
    let mut scans = Vec::new();
    let mut of_scale: Option<SearchResult> = None;
    let mut stopped = false;
    for quantity in Quantity::ALL {
        let range = search.range(quantity);
        let asked = if stopped {
            None
        } else {
            kept(answer(&search, quantity, &range, of_scale.as_ref()))?
        };
        let Some((margin, found)) = asked else {
            stopped = true;
            answers.push(search.unasked(quantity, &range));
            continue;
        };
        answers.push(margin);
        let crossings = found.crossings.iter();
        boundaries.extend(crossings.map(|crossing| Boundary::new(quantity, crossing)));
        scans.push(Scan::new(quantity, &range, &found, design));
        if quantity == Quantity::Scale {
            of_scale = Some(found);
        }
        progress.step();
    }
    if stopped && of_scale.is_none() {
        return Err(KernelError::Stopped.into());
    }
    let limit = (options.limit && !stopped)
        .then(|| limit_curve(&conditioned.used, design, &options.policy, control))
        .map_or(Ok(None), kept)?;
    stopped |= options.limit && limit.is_none();
    progress.step();
    let wanted = options.map.as_ref().filter(|_| !stopped);
    let map = wanted
        .map(|request| {
            let runs = NominalRuns {
                enough_rad: f64::INFINITY,
                ..search.runs
            };
            map::map(&runs, design, request)
        })
        .map_or(Ok(None), kept)?;
    stopped |= options.map.is_some() && map.is_none();
    Ok(Margins {
        state: search.state,
        basis: search.basis,
        answers,
        boundaries,
        scans,
        limit,
        map,
        spoiled: search.spoiled,
        stopped,
    })
}

/// Takes a wish to stop for nothing found.
fn kept<T>(found: Result<T, Error>) -> Result<Option<T>, Error> {
    match found {
        Err(error) if error.is_stopped() => Ok(None),
        found => found.map(Some),
    }
}

/// Finds the margin of one quantity; `of_scale` are the changes of the scale, once known.
fn answer(
    search: &MarginSearch<'_>,
    quantity: Quantity,
    range: &SearchRange,
    of_scale: Option<&SearchResult>,
) -> Result<(Margin, SearchResult), Error> {
    let found = match (quantity, of_scale) {
        (Quantity::Unbalance, Some(found)) => times(found, range.present),
        _ => search.changes(quantity, range)?,
    };
    let margin = search.answer(quantity, range, &found)?;
    Ok((margin, found))
}

/// The part of a search for margins that is done, quantity by quantity.
struct SearchProgress<'a> {
    control: &'a Control<'a>,
    steps: usize,
    done: AtomicUsize,
}

impl<'a> SearchProgress<'a> {
    fn new(control: &'a Control<'a>, options: &MarginOptions) -> Self {
        let beside = usize::from(options.limit) + usize::from(options.map.is_some());
        Self {
            control,
            steps: Quantity::ALL.len() + beside,
            done: AtomicUsize::new(0),
        }
    }

    fn step(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }

    fn proceed(&self) -> bool {
        let done = self.done.load(Ordering::Relaxed).min(self.steps);
        (self.control.proceed)(Some(done as f64 / self.steps as f64))
    }
}

/// Finds the design's limit, with the recording beside it for each sign that counts.
fn limit_curve(
    signal: &Signal,
    design: &Design,
    policy: &Policy,
    control: &Control<'_>,
) -> Result<LimitCurve, Error> {
    let signs = policy.polarity.signs().iter();
    let recording = signs.map(|sign| limit::recording_point(signal, *sign));
    limit::limit_curve(design, policy.model, recording.collect(), control)
}

/// Changes of the unbalance, from those of the scale: the model holds both only as the product
/// of mass, distance and acceleration.
fn times(found: &SearchResult, unbalance: f64) -> SearchResult {
    let point = |(at, excess): (f64, Excess)| (at * unbalance, excess);
    SearchResult {
        points: found.points.iter().copied().map(point).collect(),
        crossings: found
            .crossings
            .iter()
            .map(|crossing| Crossing {
                edge: crossing.edge,
                low: point(crossing.low),
                high: point(crossing.high),
            })
            .collect(),
    }
}
