//! A channel as a reader found it, made into one that is delivered: the last mile of all readers.

use super::{Channel, Finding, ReadOptions, Stated, laboratory};
use crate::units::{AccelerationUnit, SampleRate};

/// A channel on the file's own clock.
#[derive(Debug)]
pub(super) struct Draft {
    pub(super) name: String,
    pub(super) unit: Unit,
    /// Time of the first sample on the file's clock [s].
    pub(super) start_s: f64,
    pub(super) rate: SampleRate,
    pub(super) values: Vec<f64>,
    pub(super) stated: Stated,
    /// What was found odd, each instant on the file's clock.
    pub(super) findings: Vec<Finding>,
}

impl Draft {
    /// Moves the channel's clock so that `time_zero_s` becomes time 0.
    pub(super) fn finish(mut self, time_zero_s: Option<f64>) -> Channel {
        let zero = time_zero_s.unwrap_or(0.0);
        move_instants(&mut self.findings, zero);
        Channel {
            name: self.name,
            unit: self.unit.unit,
            unit_source: self.unit.source,
            start_s: self.start_s - zero,
            rate: self.rate,
            values: self.values,
            stated: self.stated,
            findings: self.findings,
        }
    }
}

/// Moves the instants of findings to a clock on which `zero_s` is 0.
pub(super) fn move_instants(findings: &mut [Finding], zero_s: f64) {
    for finding in findings {
        finding.at_s = finding.at_s.map(|at_s| at_s - zero_s);
    }
}

/// The unit of a channel, and what states it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Unit {
    pub(super) unit: Option<AccelerationUnit>,
    pub(super) source: &'static str,
}

impl Unit {
    /// Takes the unit that option or card state, else that of the file with what states it there.
    /// Where the file says another one, `differs` words it, from the name of what overrides it
    /// and the unit that is used; where it says nothing, `differs` gives nothing.
    pub(super) fn find(
        own: Option<(AccelerationUnit, &'static str)>,
        options: &ReadOptions,
        findings: &mut Vec<Finding>,
        differs: impl FnOnce(&str, &str) -> Option<String>,
    ) -> Self {
        let Some(said) = options.unit else {
            return Self {
                unit: own.map(|(unit, _)| unit),
                source: own.map_or("none", |(_, source)| source),
            };
        };
        let source = if options.unit_from_card {
            "card"
        } else {
            "option"
        };
        if own.is_none_or(|(unit, _)| unit != said) {
            let text = differs(source, said.name());
            findings.extend(text.map(|text| Finding::warning("unit-overridden", text)));
        }
        Self {
            unit: Some(said),
            source,
        }
    }
}

/// The span of a record on the file's clock.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span {
    pub(super) start_s: f64,
    /// Time of the last sample [s].
    pub(super) end_s: f64,
    pub(super) interval_s: f64,
}

impl Span {
    /// Takes what the laboratory says of an instant outside of the span as said of all of it.
    pub(super) fn hold(self, finding: &mut Finding) {
        laboratory::hold_against_record(finding, self.start_s, self.end_s, self.interval_s);
    }
}

/// Samples on a uniform clock, the file's.
pub(super) struct UniformSamples {
    pub(super) start_s: f64,
    pub(super) rate: SampleRate,
    pub(super) values: Vec<f64>,
}

impl UniformSamples {
    pub(super) fn span(&self) -> Span {
        let last = self.values.len().saturating_sub(1) as f64;
        Span {
            start_s: self.start_s,
            end_s: self.start_s + last / self.rate.hertz(),
            interval_s: 1.0 / self.rate.hertz(),
        }
    }
}

/// Says that a channel is not among those delivered.
pub(super) fn left_out(name: &str, error: &impl std::fmt::Display) -> Finding {
    Finding::warning("channel-left-out", format!("{name} is left out: {error}"))
}
