//! Changes since another summary.

use super::pairs::{Pair, PairStanding};
use super::summary::{Changes, GateSummary, Moved, SCHEMA};
use crate::pipeline::{Answer, DecisionRow};
use latchgate_recording::error::{Error, Place};
use std::collections::{BTreeMap, BTreeSet};

/// An earlier summary.
#[derive(Debug)]
pub struct Baseline {
    /// By recording and design.
    pairs: BTreeMap<(String, String), Pair>,
    numbers_revision: u32,
}

impl Baseline {
    /// Reads a summary.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Malformed`] if it is none.
    pub fn from_json(name: &str, bytes: &[u8]) -> Result<Self, Error> {
        let summary: GateSummary = serde_json::from_slice(bytes).map_err(|error| {
            Error::malformed(
                "a summary.json of latchgate gate",
                error.to_string(),
                "run the gate once and keep its summary.json",
            )
            .at(Place::file(name))
        })?;
        if summary.schema != SCHEMA {
            return Err(Error::malformed(
                "the schema latchgate.gate/1",
                summary.schema,
                "make the baseline with this version",
            )
            .at(Place::file(name)));
        }
        let pairs = summary.pairs.into_iter();
        Ok(Self {
            pairs: pairs
                .map(|pair| ((pair.recording.clone(), pair.design.clone()), pair))
                .collect(),
            numbers_revision: summary.numbers_revision,
        })
    }

    fn get(&self, recording: &str, design: &str) -> Option<&Pair> {
        self.pairs.get(&(recording.to_string(), design.to_string()))
    }

    /// True if a pair was not as required in the baseline, and was no better than it is now. A pair
    /// that could not be judged, then or now, never counts as no worse.
    pub fn was_no_better(
        &self,
        recording: &str,
        design: &str,
        required: Answer,
        row: &DecisionRow,
    ) -> bool {
        let before = self.get(recording, design);
        before.is_some_and(|before| {
            let failed = matches!(
                before.standing,
                PairStanding::NotAsRequired | PairStanding::NoWorse
            );
            let rank = |verdict: Answer| badness(verdict, required);
            let no_worse = rank(row.verdict) < rank(before.row.verdict)
                || (row.verdict == before.row.verdict && !is_further(&before.row, row, required));
            let judged = ![row.verdict, before.row.verdict].contains(&Answer::Unusable);
            failed && judged && before.required == required && no_worse
        })
    }

    /// Begins a comparison.
    pub fn comparison(&self) -> BaselineComparison<'_> {
        BaselineComparison {
            baseline: self,
            compared: BTreeSet::new(),
            changes: Changes {
                numbers_revision: self.numbers_revision,
                ..Changes::default()
            },
        }
    }
}

/// A comparison of a baseline with pairs that come one by one.
#[derive(Debug)]
pub struct BaselineComparison<'a> {
    baseline: &'a Baseline,
    compared: BTreeSet<&'a (String, String)>,
    changes: Changes,
}

impl BaselineComparison<'_> {
    /// Compares a pair with that of the baseline.
    pub fn add(&mut self, pair: &Pair) {
        let name = (pair.recording.clone(), pair.design.clone());
        let changes = &mut self.changes;
        let Some((baseline_name, before)) = self.baseline.pairs.get_key_value(&name) else {
            changes.added.push(name);
            return;
        };
        self.compared.insert(baseline_name);
        let bad = |pair: &Pair| {
            matches!(
                pair.standing,
                PairStanding::NotAsRequired | PairStanding::NoWorse
            )
        };
        match (bad(before), bad(pair)) {
            (false, true) => changes.newly_failing.push(name.clone()),
            (true, false) => changes.fixed.push(name.clone()),
            _ => {}
        }
        if let (Some(margin_before_rad), Some(margin_now_rad)) =
            (margin(&before.row), margin(&pair.row))
            && (margin_now_rad - margin_before_rad).abs()
                > uncertainty(&before.row) + uncertainty(&pair.row)
        {
            changes.moved.push(Moved {
                recording: name.0,
                design: name.1,
                margin_before_rad,
                margin_now_rad,
            });
        }
    }

    /// Returns the changes.
    pub fn changes(mut self) -> Changes {
        let names = self.baseline.pairs.keys();
        let gone = names.filter(|name| !self.compared.contains(name));
        self.changes.removed = gone.cloned().collect();
        self.changes
    }
}

/// Returns the distance from the peak to the limit [rad].
fn margin(row: &DecisionRow) -> Option<f64> {
    row.peak_angle_rad.map(|peak| row.threshold_rad - peak)
}

fn uncertainty(row: &DecisionRow) -> f64 {
    row.uncertainty_rad.unwrap_or(0.0)
}

/// Orders answers by how far they are from what is required.
fn badness(verdict: Answer, required: Answer) -> u8 {
    match verdict {
        verdict if verdict == required => 0,
        Answer::Undecided => 1,
        Answer::Pass | Answer::Fail => 2,
        Answer::Unusable => 3,
    }
}

/// True if the margin moved away from the required answer by more than its uncertainty.
fn is_further(before: &DecisionRow, now: &DecisionRow, required: Answer) -> bool {
    match (margin(before), margin(now)) {
        (Some(margin_before), Some(margin_now)) => {
            let lost = margin_before - margin_now;
            let away = if required == Answer::Fail {
                -lost
            } else {
                lost
            };
            away > uncertainty(before) + uncertainty(now)
        }
        // A peak that is gone is no evidence that nothing got worse.
        (Some(_), None) => true,
        _ => false,
    }
}
