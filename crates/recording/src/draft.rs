//! A channel as a reader found it, made into one that is delivered: the last mile of all readers.

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
    /// What was found odd, each instant on the file's clock.
    pub(super) findings: Vec<Finding>,
    /// What was written of it in free words.
    pub(super) remarks: Vec<Remark>,
}

impl Draft {
    /// Takes a channel of which words say what it is.
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
        remarks::tell_of_filters(&self.remarks, &mut self.stated, &mut self.findings);
        let scale = self.unit.scale;
        if scale.total_cmp(&1.0).is_ne() {
            self.stated.full_scale = self.stated.full_scale.map(|full| full * scale);
            for value in &mut self.clock.values {
                *value *= scale;
            }
        }
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
            pulse: None,
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
    /// What one of the file's numbers is [`unit`]; 1 unless they are another quantity.
    scale: f64,
}

/// What a file states of a channel's unit.
#[derive(Debug, Clone, Copy)]
pub(super) struct UnitStatement<'a> {
    /// The unit, if it is one of acceleration beyond doubt.
    pub(super) unit: Option<AccelerationUnit>,
    /// What states it, as documents have it.
    pub(super) source: &'static str,
    /// The unit as it is written, be it one of acceleration or not.
    pub(super) text: Option<&'a str>,
    /// What stands in a unit's place and is none that is read.
    pub(super) unread: Option<&'a str>,
    /// Where that stands, in a message.
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

    /// Refuses to take another quantity for an acceleration; `by` says who wants that.
    fn refused(&self, quantity: &str, by: &str) -> Error {
        let quantity = text::shown(quantity);
        Error::malformed(
            "a unit of acceleration",
            format!("`{quantity}` in {}{by}", self.place),
            format!(
                "choose another channel, or state the sensitivity, with the sensor's number for \
                 20: the setting `sensitivity` = '20 g/{quantity}'"
            ),
        )
    }

    /// Says that the stated sensitivity is that of another quantity than the file's.
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

/// True if a cell for a unit says that nothing is known of it.
fn says_nothing(text: &str) -> bool {
    let small = text.to_lowercase();
    let word = small.trim_matches(|c: char| !c.is_alphanumeric() && c != '%' && c != '°');
    word.is_empty() || matches!(word, "n/a" | "na" | "none" | "novalue" | "null" | "unknown")
}

impl Unit {
    /// Finds the unit of a channel of words; `source` states it, and it stands in `place`.
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

    /// Takes the unit that option or card state, else that of the file, which `statement` tells. The
    /// one channel that is meant needs a unit.
    pub(super) fn find(
        statement: UnitStatement<'_>,
        options: &ReadOptions,
        selection: Selection,
        findings: &mut Vec<Finding>,
    ) -> Result<Self, Error> {
        let is_meant = selection == Selection::Lateral;
        let other = statement.other_quantity();
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
            let found = other.or(statement.unit.map(AccelerationUnit::name));
            let scale = match found {
                None => Some(sensitivity.scale()),
                Some(found) => sensitivity.scale_of(found),
            };
            return match (scale, found) {
                (Some(scale), found) => {
                    findings.push(sensitivity_finding(sensitivity, source, found, &statement));
                    let unit = Some(sensitivity.unit());
                    Ok(Self {
                        unit,
                        source,
                        scale,
                    })
                }
                (None, Some(found)) if is_meant => Err(statement.not_of(found, sensitivity)),
                (None, _) => Ok(from_file),
            };
        }
        match (options.unit, other) {
            (Some(said), None) => {
                let text = statement.text.or(statement.unread);
                let is_same = |text: &&str| AccelerationUnit::from_spelling(text) == Some(said);
                if let Some(text) = text.filter(|text| !says_nothing(text) && !is_same(text))
                    && statement.unit != Some(said)
                {
                    let text = format!(
                        "{} states `{}`, but the {source} states `{}`. The {source} was used. \
                         Check which is right",
                        statement.place,
                        text::shown(text),
                        said.name()
                    );
                    findings.push(Finding::warning("unit-overridden", text));
                }
                Ok(Self {
                    unit: Some(said),
                    source,
                    scale: 1.0,
                })
            }
            (said, Some(quantity)) if is_meant => {
                let by = said.map_or(String::new(), |said| {
                    format!(", though the {source} states {}", said.name())
                });
                Err(statement.refused(quantity, &by))
            }
            _ if is_meant && statement.unit.is_none() => Err(ErrorKind::MissingUnit.into()),
            _ => Ok(from_file),
        }
    }
}

/// Checks the unit of the channel that is meant, read before it was known which one that is.
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

/// Says by which sensitivity samples became accelerations.
fn sensitivity_finding(
    sensitivity: &SensorSensitivity,
    source: &str,
    found: Option<&str>,
    statement: &UnitStatement<'_>,
) -> Finding {
    let stated = found.map_or("no unit".to_string(), |found| {
        format!("`{}`", text::shown(found))
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
    Finding::warning("channel-left-out", format!("{name} was left out: {error}"))
}
