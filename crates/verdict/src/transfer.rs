//! From the sensor's place to the latch: the factors that are judged, and the recording at one of them.
//!
//! A factor multiplies the acceleration that drives the lever, as if the sensor had recorded it so: samples, bias,
//! bias error and noise alike. What is a number of the design or of a rule stays as it is: the limit angle,
//! `input.bias_g`, the least and greatest peak and velocity of a crash.

use crate::conditioning::{Conditioned, Noise, Signal};
use crate::margin::quantity::preferred;
use crate::{Answer, Assessment};
use latchgate_recording::TransferRange;

/// Returns the factors to judge, in ascending order: both ends of a range, and every value of E48 between, since a
/// lever may open between two factors at which it stays.
pub fn factors(range: TransferRange) -> Vec<f64> {
    let (from, to) = (range.from(), range.to());
    let within = |factor: &f64| *factor > from && *factor < to;
    let mut factors = vec![from];
    if from < to {
        factors.extend(preferred(from, to).into_iter().filter(within));
        factors.push(to);
    }
    factors
}

/// Returns a place that orders answers by how bad they are, the worst last.
fn badness(answer: Answer) -> u8 {
    match answer {
        Answer::Pass => 0,
        Answer::Undecided => 1,
        Answer::Unusable => 2,
        Answer::Fail => 3,
    }
}

/// Returns the index of the worst assessment: the worst answer, then the one that hangs on a setting, then the
/// largest angle; the first of equals.
pub fn index_of_worst<'a>(assessments: impl IntoIterator<Item = &'a Assessment>) -> usize {
    let rank = |assessment: &Assessment| {
        let hangs = |code: &str| code == "setting-decides";
        let on_setting = assessment.why.iter().any(|reason| hangs(&reason.code));
        let peak_rad = assessment.nominal.peak_angle_rad;
        (badness(assessment.answer), on_setting, peak_rad)
    };
    let mut worst: Option<(usize, (u8, bool, f64))> = None;
    for (index, assessment) in assessments.into_iter().enumerate() {
        let found = rank(assessment);
        let is_worse = worst.is_none_or(|(_, most)| {
            let order = (found.0, found.1).cmp(&(most.0, most.1));
            // Of equal ones the last: that of the largest factor.
            order.then(found.2.total_cmp(&most.2)).is_ge()
        });
        if is_worse {
            worst = Some((index, found));
        }
    }
    worst.map_or(0, |(index, _)| index)
}

impl Conditioned {
    /// Returns the recording as it would be with every sample times `factor`.
    pub fn at_factor(&self, factor: f64) -> Self {
        let signal = |signal: &Signal| Signal {
            samples: signal.samples.iter().map(|a| factor * a).collect(),
            ..*signal
        };
        let second = self.second.as_deref().map(|second| {
            let mut scaled = second.clone();
            scaled.conditioned = second.conditioned.at_factor(factor);
            Box::new(scaled)
        });
        let mut neighbours = self.neighbours.clone();
        for neighbour in &mut neighbours {
            neighbour.peak_m_s2 *= factor;
        }
        Self {
            raw: signal(&self.raw),
            used: signal(&self.used),
            formula: self
                .formula
                .as_ref()
                .map(|formula| formula.scaled(factor, 0.0)),
            bias_m_s2: factor * self.bias_m_s2,
            bias_standard_error_m_s2: factor * self.bias_standard_error_m_s2,
            noise: Noise {
                deviation_m_s2: factor * self.noise.deviation_m_s2,
                step_m_s2: factor * self.noise.step_m_s2,
                ..self.noise
            },
            second,
            neighbours,
            ..self.clone()
        }
    }
}
