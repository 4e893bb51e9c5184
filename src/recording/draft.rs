//! A channel as a reader found it, made into one that is delivered: the last mile of all readers.

use super::csv::header::Column;
use super::remarks::{self, Remark, Span};
use super::time_base::TimeBase;
use super::{Channel, Finding, Limits, ReadOptions, ReadOutcome, Selection, Stated, text};
use crate::error::{Error, ErrorKind, Place};
use crate::units::{AccelerationUnit, SampleRate};

/// A channel as it was found.
#[derive(Debug)]
pub(super) struct Draft {
    pub(super) name: String,
    pub(super) unit: Unit,
    /// The samples on the file's own clock.
    pub(super) clock: UniformSamples,
    pub(super) stated: Stated,
    /// What was found odd, each instant on the file's clock.
    pub(super) findings: Vec<Finding>,
    /// What was written of it in free words.
    pub(super) remarks: Vec<Remark>,
}

impl Draft {
    /// Takes a channel of which words say what it is.
    pub(super) fn of_words(
        words: &Column,
        unit: Unit,
        clock: UniformSamples,
        mut findings: Vec<Finding>,
    ) -> Self {
        let stated = words.stated();
        findings.extend(stated.findings(clock.rate));
        findings.extend(words.name_findings());
        Self {
            name: words.name.clone(),
            unit,
            clock,
            stated,
            findings,
            remarks: Vec::new(),
        }
    }

    /// Makes findings of the remarks and moves the channel's clock so that the instant `zero`
    /// [s] becomes time 0.
    pub(super) fn finish(mut self, zero: f64, options: &ReadOptions) -> Result<Channel, Error> {
        let span = self.clock.span();
        let distance_s = (span.end_s - zero).abs();
        if distance_s.is_nan() || distance_s >= LONGEST_S {
            let error = Error::out_of_range(
                "the time of the last sample [s]",
                "a time",
                format!("{:e} at {:e} Hz", span.end_s, self.clock.rate.hertz()),
            );
            return Err(error.at(Place::default().channel(self.name)));
        }
        self.stated.remarks = remarks::shown(&self.remarks);
        remarks::tell_of_filters(&self.remarks, &mut self.stated, &mut self.findings);
        // First what a person says.
        let mut findings = remarks::findings(&self.remarks, &options.accepted_remarks, span);
        findings.append(&mut self.findings);
        move_instants(&mut findings, zero);
        Ok(Channel {
            name: self.name,
            unit: self.unit.unit,
            unit_source: self.unit.source,
            start_s: self.clock.start_s - zero,
            rate: self.clock.rate,
            values: self.clock.values,
            stated: self.stated,
            findings,
        })
    }
}

/// Times beyond which a clock is none [s]: near the largest number there is, so that no sum of
/// them runs over it.
const LONGEST_S: f64 = 1e300;

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
        let source = match options.unit_from_card {
            true => "card",
            false => "option",
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

    /// As [`Self::find`], for a header: `place` says where its `text` stands, in a message. The one
    /// channel that is meant needs a unit.
    pub(super) fn of_header(
        own: Option<(AccelerationUnit, &'static str)>,
        (place, text): (&str, Option<&str>),
        options: &ReadOptions,
        selection: Selection,
        findings: &mut Vec<Finding>,
    ) -> Result<Self, Error> {
        let text = text.map(text::shown).filter(|text| !text.is_empty());
        let unit = Self::find(own, options, findings, |source, used| {
            let text = text.as_ref()?;
            Some(format!(
                "{place} says `{text}`, the {source} says {used}, which was used"
            ))
        });
        if unit.unit.is_some() || selection == Selection::Every {
            return Ok(unit);
        }
        Err(text.map_or(ErrorKind::MissingUnit.into(), |text| {
            Error::malformed(
                "a unit of acceleration",
                format!("`{text}` in {place}"),
                "choose another channel, or state the unit with the setting `unit`",
            )
        }))
    }
}

/// Samples on a uniform clock, the file's.
#[derive(Debug)]
pub(super) struct UniformSamples {
    pub(super) start_s: f64,
    pub(super) rate: SampleRate,
    pub(super) values: Vec<f64>,
}

impl UniformSamples {
    /// Takes the clock that stamps give [s], as printed to `digit_s` [s].
    pub(super) fn by_stamps(
        stamps_s: &[f64],
        digit_s: f64,
        values: Vec<f64>,
        limits: &Limits,
        findings: &mut Vec<Finding>,
    ) -> Result<Self, Error> {
        let base = TimeBase::fit(stamps_s, digit_s, limits)?;
        findings.extend(base.findings.iter().cloned());
        Ok(Self {
            start_s: base.start_s,
            rate: base.rate,
            values: base.apply(stamps_s, values)?,
        })
    }

    /// Takes a clock that is stated.
    pub(super) fn stated(start_s: f64, rate: SampleRate, values: Vec<f64>) -> Result<Self, Error> {
        if values.len() < 2 {
            return Err(Error::too_short("a recording", 2, values.len()));
        }
        Ok(Self {
            start_s,
            rate,
            values,
        })
    }

    pub(super) fn span(&self) -> Span {
        Span::new(self.start_s, self.rate, self.values.len())
    }
}

/// Delivers the channels of a selection. `channel` reads one; its error comes with the channel's name.
/// Together they hold at most as many samples as the limit `most` says.
pub(super) fn deliver(
    selection: Selection,
    wanted: Vec<usize>,
    mut outcome: ReadOutcome,
    (limit, most): (&'static str, u64),
    mut channel: impl FnMut(usize, &mut ReadOutcome) -> Result<Option<Channel>, (String, Error)>,
) -> Result<ReadOutcome, Error> {
    let mut samples = 0;
    for index in wanted {
        let (name, error) = match channel(index, &mut outcome) {
            Ok(None) => continue,
            Ok(Some(read)) => {
                samples += read.values.len() as u64;
                let name = read.name.clone();
                outcome.channels.push(read);
                if samples <= most {
                    continue;
                }
                let error = Error::over(limit, most, "more samples in all channels");
                (name, error)
            }
            Err(failed) => failed,
        };
        let ends = matches!(error.kind(), ErrorKind::LimitExceeded { .. });
        if selection == Selection::Lateral || ends {
            return Err(error.at(Place::default().channel(name)));
        }
        outcome.findings.push(left_out(&name, &error));
    }
    Ok(outcome)
}

/// Says that a channel is not among those delivered.
pub(super) fn left_out(name: &str, error: &impl std::fmt::Display) -> Finding {
    Finding::warning("channel-left-out", format!("{name} is left out: {error}"))
}
