//! How far a verdict is from changing, and what design would change it.
//!
//! Each quantity is varied alone over its own grid ([`Quantity::grid`]), which no present value moves.
//! Nominal runs at every value are the guide: where they open, the rule cannot pass. The whole rule is
//! asked from the safe end of the grid on, down to the first value that does not pass (the advice), and
//! from the present value to either side, to the first that answers otherwise (the nearest change).
//!
//! - `quantity`: what each quantity does to the lever, and its grid;
//! - `search`: the runs and rules at one value, and the walk over a grid;
//! - `advice`: the value from which on every value tried passes, in words;
//! - `limit`: the design's limit under half-sine pulses: amplitude against change of velocity.

mod advice;
pub mod limit;
pub mod quantity;
mod search;

pub use advice::Advice;
pub use limit::{LimitCurve, LimitPoint, RecordingPoint, critical_pulse};
pub use quantity::Quantity;

use crate::Policy;
use crate::conditioning::Conditioned;
use crate::in_plane;
use latchgate_kernel::error::Error as KernelError;
use latchgate_kernel::model::Design;
use latchgate_kernel::parallel::Control;
use latchgate_recording::Finding;
use latchgate_recording::error::Error;
use search::MarginSearch;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// The answer of the nominal runs at one value of a quantity, no error counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NominalAnswer {
    /// No run goes beyond the limit angle.
    Pass,
    /// Every run does (polarities declared as both: every run of one of them).
    Fail,
    /// Stops or polarities differ, or only the coast goes beyond.
    Undecided,
}

impl NominalAnswer {
    /// Returns its word.
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
    /// The nominal run's peak against the limit angle, no error counted.
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
    /// Whether the verdict is a pass at present, where that is known already.
    pub passes_at_present: Option<bool>,
    /// Distance of the counterweight from the pivot [m].
    pub counterweight_radius_m: f64,
    /// Find the limit under half-sine pulses.
    pub limit: bool,
}

/// A change of the nominal runs' answer.
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

/// A change between pass and no pass.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// The value that still passes, or first passes.
    pub passes: f64,
    /// The value next to it that does not.
    pub does_not: f64,
}

impl Change {
    /// Returns the values between which the answer changes, in ascending order.
    pub fn bracket(self) -> (f64, f64) {
        let Self { passes, does_not } = self;
        (passes.min(does_not), passes.max(does_not))
    }
}

/// What one quantity would change.
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
    /// The answer it rests on.
    pub basis: Basis,
    /// The nearest change of that answer; `None` if no value tried answers otherwise.
    pub change: Option<Change>,
    /// The nearest change of the nominal runs between pass and no pass, no error counted.
    pub nominal_change: Option<Change>,
    /// The nearest change of the verdict, by the whole rule.
    pub verdict_change: Option<Change>,
    /// Why there is no change, where there is none.
    pub reason: Option<String>,
    /// Least and greatest value of the grid.
    pub searched: (f64, f64),
    /// Values of the grid.
    pub values: usize,
    /// The convention: what stays and what moves along.
    pub convention: Cow<'static, str>,
    /// From where on every value tried passes by the whole rule.
    pub advice: Advice,
}

impl Margin {
    /// Returns the value that still passes (or first passes) where the answer changes.
    pub fn at(&self) -> Option<f64> {
        self.change.map(|change| change.passes)
    }

    /// Returns the change from the present value [%]; `None` without an answer or a present value.
    pub fn change_percent(&self) -> Option<f64> {
        let passing_value = self.at().filter(|_| self.present > 0.0)?;
        Some((passing_value / self.present - 1.0) * 100.0)
    }

    /// Tells whether a pass of the verdict, at present or next to the change, has values that do not pass
    /// between itself and the advice.
    pub fn is_isolated(&self) -> bool {
        if self.basis == Basis::NominalRun {
            return false;
        }
        let pass = if self.passes_at_present {
            Some(self.present)
        } else {
            self.at()
        };
        pass.is_some_and(|pass| !self.advice.covers(self.quantity, pass))
    }
}

/// The peak over a quantity, as the nominal runs saw it.
#[derive(Debug, Clone, PartialEq)]
pub struct Scan {
    /// The quantity varied.
    pub quantity: Quantity,
    /// Its value at present.
    pub present: f64,
    /// Value, and the largest angle of window and coast of all stops and polarities that count [rad];
    /// `None` where the lever could not be followed.
    pub points: Vec<(f64, Option<f64>)>,
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
    /// The peaks that the nominal runs saw.
    pub scans: Vec<Scan>,
    /// The design's limit, if asked for.
    pub limit: Option<LimitCurve>,
    /// The recording carries a blocking finding: all of this rests on spoiled samples.
    pub spoiled: bool,
    /// The search was stopped: what it had until then is here, the limit is not.
    pub stopped: bool,
}

/// Finds the margins of the verdict on `conditioned`; `findings` are those of reading and
/// conditioning.
///
/// # Errors
///
/// As [`crate::assess()`], [`Stopped`](latchgate_kernel::error::Error::Stopped) only if no quantity was answered until
/// then.
pub fn margins(
    conditioned: &Conditioned,
    findings: &[Finding],
    design: &Design,
    options: &MarginOptions,
    control: &Control<'_>,
) -> Result<Margins, Error> {
    let search = MarginSearch::new(conditioned, findings, design, options, control)?;
    let parts = Quantity::ALL.len() + usize::from(options.limit);
    let part = |index: usize| index as f64 / parts as f64;
    let mut margins = Margins {
        state: search.state,
        basis: search.basis,
        answers: Vec::new(),
        boundaries: Vec::new(),
        scans: Vec::new(),
        limit: None,
        spoiled: search.spoiled,
        stopped: false,
    };
    for (index, quantity) in Quantity::ALL.into_iter().enumerate() {
        let answered = if (control.proceed)(Some(part(index))) {
            control.unmeasured(|control| kept(search.answer(quantity, control)))?
        } else {
            None
        };
        let Some(answered) = answered else {
            if index == 0 {
                return Err(KernelError::Stopped.into());
            }
            margins.stopped = true;
            let remaining = Quantity::ALL[index..].iter();
            margins
                .answers
                .extend(remaining.map(|quantity| search.unasked(*quantity)));
            return Ok(margins);
        };
        margins.answers.push(answered.margin);
        margins.boundaries.extend(answered.boundaries);
        margins.scans.push(answered.scan);
    }
    if options.limit {
        margins.limit = control.during(part(parts - 1), 1.0, |control| {
            kept(limit_curve(conditioned, design, &options.policy, control))
        })?;
        margins.stopped = margins.limit.is_none();
    }
    Ok(margins)
}

/// Finds from which value of a quantity on a recording passes, as [`margins`] advises it; none where a blocking
/// finding spoils it.
///
/// # Errors
///
/// As [`crate::assess()`].
pub fn advice(
    quantity: Quantity,
    conditioned: &Conditioned,
    findings: &[Finding],
    design: &Design,
    policy: &Policy,
    passes_at_present: Option<bool>,
    control: &Control<'_>,
) -> Result<Option<Advice>, Error> {
    let options = MarginOptions {
        policy: policy.clone(),
        basis: Basis::Verdict,
        passes_at_present,
        counterweight_radius_m: 1.0,
        limit: false,
    };
    let search = MarginSearch::new(conditioned, findings, design, &options, control)?;
    if search.spoiled {
        return Ok(None);
    }
    let advised = control.unmeasured(|control| search.advice(quantity, control))?;
    Ok(Some(advised))
}

/// Takes a wish to stop for nothing found.
fn kept<T>(found: Result<T, Error>) -> Result<Option<T>, Error> {
    match found {
        Err(error) if error.is_stopped() => Ok(None),
        found => found.map(Some),
    }
}

/// Finds the design's limit, with the recording beside it for each sign that counts.
fn limit_curve(
    conditioned: &Conditioned,
    design: &Design,
    policy: &Policy,
    control: &Control<'_>,
) -> Result<LimitCurve, Error> {
    let mut recording = Vec::new();
    for sign in policy.polarity.signs() {
        let along = in_plane::tangential(conditioned, &design.lever, *sign)?;
        recording.push(limit::recording_point(&along, *sign));
    }
    limit::limit_curve(design, policy.model, recording, control)
}
