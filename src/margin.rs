//! How far a verdict is from changing, and what design would change it.
//!
//! Each quantity (scale of the recording, preload, unbalance, counterweight, restitution) is
//! varied alone over a stated range; every value at which the answer changes is listed, and the
//! one nearest to the present is the margin.

mod change;
pub mod limit;
pub mod map;
mod preload;
pub mod quantity;
mod runs;
pub mod search;

pub use limit::{LimitCurve, LimitPoint, RecordingPoint, critical_pulse};
pub use map::{Map, MapAxis, MapRequest, MapVertex};
pub use preload::PreloadAnswer;
pub use preload::preload_answer;
pub use quantity::Quantity;

use crate::conditioning::Conditioned;
use crate::error::Error;
use crate::model::Design;
use crate::parallel::Control;
use crate::recording::Finding;
use crate::verdict::bench::{Recall, window_samples};
use crate::verdict::remarks::Faults;
use crate::verdict::{Policy, assess};
use change::{Change, VerdictSearch};
use quantity::{Stretch, applied};
use runs::{Bench, Setting};
use search::{Crossing, Edge, Excess, Found, Probe};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::cell::{Cell, RefCell};

/// What the nominal runs say at one value of a quantity, no error counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// No run goes beyond the threshold.
    Pass,
    /// Every run does (polarities declared as both: every run of one of them).
    Fail,
    /// Stops or polarities differ, or only the coast goes beyond.
    Undecided,
}

impl State {
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

/// What an answer rests on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Basis {
    /// The nominal run's peak against the threshold, no error counted.
    #[serde(rename = "nominal run")]
    NominalRun,
    /// The verdict by the whole rule.
    #[serde(rename = "verdict")]
    Verdict,
}

/// What is asked.
#[derive(Debug, Clone, PartialEq)]
pub struct MarginOptions {
    /// The question of the verdict.
    pub policy: Policy,
    /// Which answer's change is looked for.
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

/// Samples times values that a search begins with, at most, unless [`POINTS_MIN`] needs more.
const SAMPLES_TIMES_POINTS: usize = 24_000_000;

/// A change of the answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Boundary {
    /// What is varied: [`Quantity::name`].
    pub quantity: Cow<'static, str>,
    /// Its unit; empty for a ratio.
    pub unit: Cow<'static, str>,
    /// The end of the bracket with the better answer: the last value still to pass, or not yet
    /// to fail.
    pub at: f64,
    /// Values between which the answer changes.
    pub bracket: (f64, f64),
    /// What the nominal runs say below.
    pub below: State,
    /// What they say above.
    pub above: State,
}

/// The least change of one quantity that changes the answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Margin {
    /// What is varied.
    pub quantity: Quantity,
    /// What people call it.
    pub title: Cow<'static, str>,
    /// Its unit; empty for a ratio.
    pub unit: Cow<'static, str>,
    /// Its value at present.
    pub present: f64,
    /// Whether the answer it rests on passes at present.
    pub passes_at_present: bool,
    /// The value that still passes (or first passes) where the answer changes; `None` if no
    /// value searched changes it.
    pub at: Option<f64>,
    /// Values between which the answer changes.
    pub bracket: Option<(f64, f64)>,
    /// The change from the present value [%]; `None` without an answer or a present value.
    pub change_percent: Option<f64>,
    /// What it rests on.
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
    /// the end of the range that they pass at; `None` if they pass at both ends, or at none.
    pub settled_at: Option<f64>,
    /// What stays and what moves along.
    pub convention: Cow<'static, str>,
}

/// The peak over a quantity, as the search saw it.
#[derive(Debug, Clone, PartialEq)]
pub struct Scan {
    /// What is varied.
    pub quantity: Quantity,
    /// Its value at present.
    pub present: f64,
    /// Whether distances are ratios.
    pub ratios: bool,
    /// Value, and the largest angle of window and coast of all stops and polarities that count
    /// [rad]; `None` where the lever could not be followed.
    pub points: Vec<(f64, Option<f64>)>,
}

/// Everything that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Margins {
    /// What the nominal runs say at present, no error counted.
    pub state: State,
    /// What the answers rest on.
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
}

/// Finds the margins of the verdict on `conditioned`; `findings` are those of reading and
/// conditioning.
///
/// # Errors
///
/// As [`assess()`]; those of [`MapRequest::check`].
pub fn margins(
    conditioned: &Conditioned,
    findings: &[Finding],
    design: &Design,
    options: &MarginOptions,
    control: &Control<'_>,
) -> Result<Margins, Error> {
    let signal = &conditioned.used;
    let window = options
        .policy
        .window_s
        .map(|window| window_samples(signal, window))
        .transpose()?;
    if let Some(request) = &options.map {
        request.check(design)?;
    }
    let bench = Bench {
        signal,
        policy: &options.policy,
        control,
        window,
    };
    let faults = Faults::of(
        conditioned,
        conditioned.filter,
        findings,
        options.policy.window_s,
    );
    let spoiled = faults.first_bad.is_some();
    let search = Search {
        bench: &bench,
        conditioned,
        findings,
        design,
        options,
        // A spoiled recording never passes, whatever the design.
        basis: if spoiled {
            Basis::NominalRun
        } else {
            options.basis
        },
        lift_off_nm: lift_off_nm(&bench, design),
        state: bench.exact(design, 1.0)?.state(),
        passes: Cell::new(None),
    };
    let mut answers = Vec::new();
    let mut boundaries = Vec::new();
    let mut scans = Vec::new();
    let mut of_scale: Option<Found> = None;
    for quantity in Quantity::ALL {
        let stretch = search.stretch(quantity);
        let found = match (quantity, &of_scale) {
            (Quantity::Unbalance, Some(found)) => times(found, stretch.present),
            _ => search.found(quantity, &stretch)?,
        };
        answers.push(search.answer(quantity, &stretch, &found, spoiled)?);
        boundaries.extend(found.crossings.iter().map(|crossing| Boundary {
            quantity: quantity.name().into(),
            unit: quantity.unit().into(),
            at: crossing.better_end(),
            bracket: (crossing.low.0, crossing.high.0),
            below: crossing.low.1.state(),
            above: crossing.high.1.state(),
        }));
        scans.push(Scan {
            quantity,
            present: stretch.present,
            ratios: stretch.ratios,
            points: found
                .points
                .iter()
                .map(|(at, excess)| {
                    let peak = excess.pass + design.criterion.threshold_rad;
                    (*at, peak.is_finite().then_some(peak))
                })
                .collect(),
        });
        if quantity == Quantity::Scale {
            of_scale = Some(found);
        }
    }
    let limit = if options.limit {
        let points = options
            .policy
            .polarity
            .signs()
            .iter()
            .map(|sign| limit::recording_point(signal, *sign))
            .collect();
        Some(limit::limit_curve(
            design,
            options.policy.model,
            points,
            control,
        )?)
    } else {
        None
    };
    let map = options
        .map
        .as_ref()
        .map(|request| map::map(&bench, design, request))
        .transpose()?;
    Ok(Margins {
        state: search.state,
        basis: search.basis,
        answers,
        boundaries,
        scans,
        limit,
        map,
        spoiled,
    })
}

/// The torque with which the strongest opening sample lifts the lever [N m].
fn lift_off_nm(bench: &Bench<'_>, design: &Design) -> f64 {
    let strongest = bench
        .policy
        .polarity
        .signs()
        .iter()
        .flat_map(|sign| bench.signal.samples.iter().map(|a| -sign.sign() * a))
        .fold(0.0, f64::max);
    design.lever.unbalance_kg_m() * strongest
}

/// Changes of the unbalance, from those of the scale: the model holds both only as the product
/// of mass, distance and acceleration.
fn times(found: &Found, unbalance: f64) -> Found {
    let point = |(at, excess): (f64, Excess)| (at * unbalance, excess);
    Found {
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

struct Search<'a> {
    bench: &'a Bench<'a>,
    conditioned: &'a Conditioned,
    findings: &'a [Finding],
    design: &'a Design,
    options: &'a MarginOptions,
    basis: Basis,
    lift_off_nm: f64,
    state: State,
    /// Whether the verdict passes at present, once that was asked: it is the same of every
    /// quantity.
    passes: Cell<Option<bool>>,
}

impl Search<'_> {
    fn stretch(&self, quantity: Quantity) -> Stretch {
        Stretch::of(
            quantity,
            self.design,
            self.options.counterweight_radius_m,
            self.lift_off_nm,
        )
    }

    fn applied(&self, quantity: Quantity, value: f64) -> (Design, f64) {
        applied(
            quantity,
            self.design,
            self.options.counterweight_radius_m,
            value,
        )
    }

    fn found(&self, quantity: Quantity, stretch: &Stretch) -> Result<Found, Error> {
        let points = self.options.points.unwrap_or_else(|| {
            let samples = self.bench.signal.samples.len().max(1);
            (SAMPLES_TIMES_POINTS / samples).clamp(POINTS_MIN, POINTS_MAX)
        });
        let setting = |value: f64| {
            let (design, scale) = self.applied(quantity, value);
            Setting::new(&design, scale)
        };
        search::changes(
            &stretch.grid(points),
            &Probe {
                scan: &|values| {
                    let settings: Vec<Setting> =
                        values.iter().map(|value| setting(*value)).collect();
                    self.bench.scan(&settings)
                },
                exact: &|value| self.bench.exact_at(&setting(value)),
                width: &|value| stretch.width(value),
                near_rad: 0.01 * self.design.criterion.threshold_rad,
            },
        )
    }

    /// Whether the verdict by the whole rule is a pass at a value; `recall` is of values of the
    /// same quantity, and by it a pass may be `presumed`.
    fn verdict_passes(
        &self,
        quantity: Quantity,
        value: f64,
        recall: &mut Recall,
        presumed: bool,
    ) -> bool {
        let (design, scale) = self.applied(quantity, value);
        let mut scaled = self.conditioned.clone();
        if quantity == Quantity::Scale {
            for samples in [&mut scaled.raw.samples, &mut scaled.used.samples] {
                samples.iter_mut().for_each(|a| *a *= scale);
            }
            scaled.bias_m_s2 *= scale;
        }
        let policy = &self.options.policy;
        // What cannot be judged is no pass.
        assess::passes_again(
            &scaled,
            self.findings,
            &design,
            policy,
            recall,
            presumed,
            self.bench.control,
        )
        .unwrap_or(false)
    }

    fn answer(
        &self,
        quantity: Quantity,
        stretch: &Stretch,
        found: &Found,
        spoiled: bool,
    ) -> Result<Margin, Error> {
        let changes: Vec<&Crossing> = found
            .crossings
            .iter()
            .filter(|crossing| crossing.edge == Edge::Pass)
            .collect();
        let nominal = changes
            .iter()
            .min_by(|a, b| {
                let distance = |crossing: &Crossing| stretch.distance(crossing.better_end());
                distance(a).total_cmp(&distance(b))
            })
            .map(|crossing| (crossing.better_end(), (crossing.low.0, crossing.high.0)));
        let mut passes_at_present = self.state == State::Pass;
        let verdict = if spoiled {
            None
        } else {
            let recall = RefCell::new(Recall::default());
            let asked = |value: f64, presumed: bool| {
                self.verdict_passes(quantity, value, &mut recall.borrow_mut(), presumed)
            };
            let verdict = VerdictSearch {
                passes: &|value| asked(value, false),
                presumes: &|value| asked(value, true),
                stretch,
                points: &found.points,
                width: if self.basis == Basis::Verdict {
                    1e-4
                } else {
                    1e-6
                },
            };
            let passes = self
                .passes
                .get()
                .unwrap_or_else(|| (verdict.passes)(stretch.present));
            self.passes.set(Some(passes));
            if self.basis == Basis::Verdict {
                passes_at_present = passes;
            }
            verdict.nearest(&changes, self.state == State::Pass, passes)
        };
        let verdict_at = verdict.map(|change| change.passes);
        let verdict_bracket = verdict.map(Change::bracket);
        let (at, bracket) = match self.basis {
            Basis::NominalRun => (nominal.map(|(at, _)| at), nominal.map(|(_, b)| b)),
            Basis::Verdict => (verdict_at, verdict_bracket),
        };
        let change_percent = at
            .filter(|_| stretch.present > 0.0)
            .map(|at| (at / stretch.present - 1.0) * 100.0);
        Ok(Margin {
            quantity,
            title: quantity.title().into(),
            unit: quantity.unit().into(),
            present: stretch.present,
            passes_at_present,
            at,
            bracket,
            change_percent,
            basis: self.basis,
            nominal_at: nominal.map(|(at, _)| at),
            nominal_bracket: nominal.map(|(_, bracket)| bracket),
            verdict_at,
            verdict_bracket,
            reason: at
                .is_none()
                .then(|| self.reason(quantity, stretch, passes_at_present)),
            searched: (stretch.low, stretch.high),
            values: found.points.len(),
            changes: changes.len(),
            settled_at: settled(&changes),
            convention: quantity.convention().into(),
        })
    }

    fn reason(&self, quantity: Quantity, stretch: &Stretch, passes: bool) -> String {
        let (low, high) = (
            crate::units::plain(stretch.low, 5),
            crate::units::plain(stretch.high, 5),
        );
        let unit = match quantity.unit() {
            "" => String::new(),
            unit => format!(" {unit}"),
        };
        let whose = match self.basis {
            Basis::NominalRun => "the nominal run",
            Basis::Verdict => "the verdict",
        };
        if passes {
            format!("{whose} is a pass everywhere from {low} to {high}{unit}")
        } else {
            match self.basis {
                Basis::NominalRun => {
                    format!("{whose} is nowhere a pass from {low} to {high}{unit}")
                }
                Basis::Verdict => format!(
                    "no value from {low} to {high}{unit} was found at which the verdict is a pass"
                ),
            }
        }
    }
}

/// The last change on the way to the one end of the range that passes.
fn settled(changes: &[&Crossing]) -> Option<f64> {
    let (first, last) = (changes.first()?, changes.last()?);
    match (first.low.1.pass <= 0.0, last.high.1.pass <= 0.0) {
        (true, false) => Some(first.low.0),
        (false, true) => Some(last.high.0),
        _ => None,
    }
}
