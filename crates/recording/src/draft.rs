//! The last step of all readers: from a channel as it was found to one that is delivered.

use super::channel_name::{ChannelName, strip_brackets};
use super::remarks::{self, Remark, Span};
use super::time_base::TimeBase;
use super::{Channel, Finding, Limits, ReadOptions, ReadOutcome, Selection, Stated, text};
use crate::error::{Error, ErrorKind, Place};
use latchgate_kernel::units::{AccelerationUnit, SampleRate, SensorSensitivity};

/// A channel as it was found.
#[derive(Debug)]
pub(super) struct Draft {
    pub(super) name: String,
    pub(super) unit: Unit,
    /// The samples on the file's own clock.
    pub(super) clock: UniformSamples,
    pub(super) stated: Stated,
    /// Findings, each with its instant on the file's clock.
    pub(super) findings: Vec<Finding>,
    /// Free words on it.
    pub(super) remarks: Vec<Remark>,
}

impl Draft {
    /// Builds a draft of a channel that words describe.
    pub(super) fn of_words(
        words: &ChannelName,
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
        self.stated.test = self.stated.test.shortened();
        remarks::add_stated_filters(&self.remarks, &mut self.stated, &mut self.findings);
        let scale = self.unit.scale;
        if scale.total_cmp(&1.0).is_ne() {
            self.stated.full_scale = self.stated.full_scale.map(|full| full * scale);
            for value in &mut self.clock.values {
                *value *= scale;
            }
        }
        // The remarks of people come first.
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
            pulse: None,
        })
    }
}

/// Time beyond which a clock is refused [s]: near the largest number, so that no sum of times
/// overflows.
const LONGEST_S: f64 = 1e300;

/// Moves the instants of findings to a clock on which `zero_s` is 0.
pub(super) fn move_instants(findings: &mut [Finding], zero_s: f64) {
    for finding in findings {
        finding.at_s = finding.at_s.map(|at_s| at_s - zero_s);
    }
}

/// The unit of a channel, with its source.
#[derive(Debug, Clone, Copy)]
pub(super) struct Unit {
    pub(super) unit: Option<AccelerationUnit>,
    pub(super) source: &'static str,
    /// Acceleration of one of the file's numbers [`unit`]; 1 unless they are another quantity.
    scale: f64,
}

/// A file's statement of a channel's unit.
#[derive(Debug, Clone, Copy)]
pub(super) struct UnitStatement<'a> {
    /// The unit, if it is certainly one of acceleration.
    pub(super) unit: Option<AccelerationUnit>,
    /// Source of it, as documents name it.
    pub(super) source: &'static str,
    /// The unit as written, of acceleration or not.
    pub(super) text: Option<&'a str>,
    /// Text in the place of a unit that is not read as one.
    pub(super) unread: Option<&'a str>,
    /// Place of that text, in a message.
    pub(super) place: &'a str,
}

impl UnitStatement<'_> {
    /// Returns the unit of another quantity than an acceleration, if the file states one.
    fn other_quantity(&self) -> Option<&str> {
        let is_other =
            |text: &&str| AccelerationUnit::from_spelling(strip_brackets(text)).is_none();
        self.text
            .map(str::trim)
            .filter(|text| self.unit.is_none() && !says_nothing(text))
            .filter(is_other)
    }

    /// Refuses to read another quantity as an acceleration; `context` is appended to the place.
    fn refused(&self, quantity: &str, context: &str) -> Error {
        let quantity = text::shown(quantity);
        Error::malformed(
            "a unit of acceleration",
            format!("`{quantity}` in {}{context}", self.place),
            format!(
                "choose another channel, or state the sensitivity, with the sensor's number for \
                 20: the setting `sensitivity` = '20 g/{quantity}'"
            ),
        )
    }

    /// Returns the error of a sensitivity for another quantity than the file's.
    fn not_of(&self, found: &str, sensitivity: &SensorSensitivity) -> Error {
        Error::malformed(
            format!(
                "samples in {}, as the setting `sensitivity` = '{sensitivity}' needs",
                sensitivity.quantity()
            ),
            format!("`{}` in {}", text::shown(found), self.place),
            "leave the setting out, or state it for that unit",
        )
    }
}

/// True if a cell for a unit is empty or a placeholder.
fn says_nothing(text: &str) -> bool {
    let small = text.to_lowercase();
    let word = small.trim_matches(|c: char| !c.is_alphanumeric() && c != '%' && c != '°');
    word.is_empty() || matches!(word, "n/a" | "na" | "none" | "novalue" | "null" | "unknown")
}

impl Unit {
    /// Finds the unit of a channel of words; `source` states it, in `place`.
    pub(super) fn of_words(
        column: &ChannelName,
        (source, place): (&'static str, &str),
        options: &ReadOptions,
        selection: Selection,
        findings: &mut Vec<Finding>,
    ) -> Result<Self, Error> {
        let (text, unread) = (column.stated_unit(), column.unread_unit());
        let statement = UnitStatement {
            unit: column.unit,
            source,
            text: text.as_deref(),
            unread: unread.as_deref(),
            place,
        };
        Self::find(statement, options, selection, findings)
    }

    /// Returns the unit of option or card, else that of the file in `statement`. The one channel that is
    /// meant needs a unit.
    pub(super) fn find(
        statement: UnitStatement<'_>,
        options: &ReadOptions,
        selection: Selection,
        findings: &mut Vec<Finding>,
    ) -> Result<Self, Error> {
        let is_meant = selection == Selection::Lateral;
        let other_quantity = statement.other_quantity();
        let from_file = Self {
            unit: statement.unit,
            source: statement.unit.map_or("none", |_| statement.source),
            scale: 1.0,
        };
        let source = match options.unit_from_card {
            true => "card",
            false => "option",
        };
        if let Some(sensitivity) = &options.sensitivity {
            let file_unit = other_quantity.or(statement.unit.map(AccelerationUnit::name));
            let scale = match file_unit {
                None => Some(sensitivity.scale()),
                Some(file_unit) => sensitivity.scale_of(file_unit),
            };
            return match (scale, file_unit) {
                (Some(scale), file_unit) => {
                    findings.push(sensitivity_finding(
                        sensitivity,
                        source,
                        file_unit,
                        &statement,
                    ));
                    let unit = Some(sensitivity.unit());
                    Ok(Self {
                        unit,
                        source,
                        scale,
                    })
                }
                (None, Some(file_unit)) if is_meant => {
                    Err(statement.not_of(file_unit, sensitivity))
                }
                (None, _) => Ok(from_file),
            };
        }
        match (options.unit, other_quantity) {
            (Some(unit), None) => {
                let text = statement.text.or(statement.unread);
                let is_same = |text: &&str| AccelerationUnit::from_spelling(text) == Some(unit);
                if let Some(text) = text.filter(|text| !says_nothing(text) && !is_same(text))
                    && statement.unit != Some(unit)
                {
                    let text = format!(
                        "{} states `{}`, but the {source} states `{}`. The {source} was used. \
                         Check which is right",
                        statement.place,
                        text::shown(text),
                        unit.name()
                    );
                    findings.push(Finding::warning("unit-overridden", text));
                }
                Ok(Self {
                    unit: Some(unit),
                    source,
                    scale: 1.0,
                })
            }
            (stated_unit, Some(quantity)) if is_meant => {
                let context = stated_unit.map_or(String::new(), |unit| {
                    format!(", though the {source} states {}", unit.name())
                });
                Err(statement.refused(quantity, &context))
            }
            _ if is_meant && statement.unit.is_none() => Err(ErrorKind::MissingUnit.into()),
            _ => Ok(from_file),
        }
    }
}

/// Checks the unit of the channel that is meant, which was read before it was chosen.
pub(super) fn check_unit(channel: &Channel, options: &ReadOptions) -> Result<(), Error> {
    let is_overridden = matches!(channel.unit_source, "option" | "card");
    if options.sensitivity.is_none() && options.unit.is_none() {
        return channel
            .unit
            .map_or(Err(ErrorKind::MissingUnit.into()), |_| Ok(()));
    }
    if channel.unit.is_some() && is_overridden {
        return Ok(());
    }
    let statement = UnitStatement {
        unit: channel.unit,
        source: channel.unit_source,
        text: channel.unit.map(AccelerationUnit::name),
        unread: None,
        place: "the message type or the field's name",
    };
    let found = statement.text.unwrap_or("another quantity");
    Err(match &options.sensitivity {
        Some(sensitivity) => statement.not_of(found, sensitivity),
        None => statement.refused(found, ""),
    })
}

/// Returns the finding that names the sensitivity by which samples became accelerations.
fn sensitivity_finding(
    sensitivity: &SensorSensitivity,
    source: &str,
    file_unit: Option<&str>,
    statement: &UnitStatement<'_>,
) -> Finding {
    let stated = file_unit.map_or("no unit".to_string(), |unit| {
        format!("`{}`", text::shown(unit))
    });
    let text = format!(
        "{} states {stated}. The numbers were converted by {sensitivity}, as the {source} states. \
         Compare that with the sensor's calibration",
        statement.place
    );
    Finding::info("sensitivity-used", text)
}

/// Samples on a uniform clock, the file's.
#[derive(Debug)]
pub(super) struct UniformSamples {
    pub(super) start_s: f64,
    pub(super) rate: SampleRate,
    pub(super) values: Vec<f64>,
}

impl UniformSamples {
    /// Fits a clock to stamps [s], as printed to `digit_s` [s].
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

    /// Builds a clock that is stated.
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
/// `limit` is the name of a limit, and `sample_limit` its value, on the samples of all channels together.
pub(super) fn deliver(
    selection: Selection,
    indices: Vec<usize>,
    mut outcome: ReadOutcome,
    (limit, sample_limit): (&'static str, u64),
    mut channel: impl FnMut(usize, &mut ReadOutcome) -> Result<Option<Channel>, (String, Error)>,
) -> Result<ReadOutcome, Error> {
    let mut samples = 0;
    for index in indices {
        let (name, error) = match channel(index, &mut outcome) {
            Ok(None) => continue,
            Ok(Some(channel)) => {
                samples += channel.values.len() as u64;
                let name = channel.name.clone();
                outcome.channels.push(channel);
                if samples <= sample_limit {
                    continue;
                }
                let error = Error::over(limit, sample_limit, "more samples in all channels");
                (name, error)
            }
            Err(failure) => failure,
        };
        let ends = matches!(error.kind(), ErrorKind::LimitExceeded { .. });
        if selection == Selection::Lateral || ends {
            return Err(error.at(Place::default().channel(name)));
        }
        outcome.findings.push(left_out(&name, &error));
    }
    Ok(outcome)
}

/// Returns the finding on a channel that is not delivered.
pub(super) fn left_out(name: &str, error: &impl std::fmt::Display) -> Finding {
    Finding::warning("channel-left-out", format!("{name} was left out: {error}"))
}
