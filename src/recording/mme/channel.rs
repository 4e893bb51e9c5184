//! Channel files: header and samples.

use super::code::Code;
use super::{encoding, laboratory, text, time_base, to_f64};
use crate::error::{Error, ErrorKind, Place};
use crate::recording::csv::number::{Decimal, PrintedDigits};
use crate::recording::{Finding, Limits, Severity, Stated};
use crate::units::{AccelerationUnit, SampleRate};

/// What stands for "nothing" as a value.
const NOTHING: &str = "NOVALUE";

/// Part of the largest magnitude by which a stated extreme may be off [-].
const EXTREME_AGREEMENT: f64 = 1e-4;

/// Tells whether the head is that of a channel file.
pub(super) fn looks_like_channel(head: &[u8]) -> bool {
    let text = String::from_utf8_lossy(head);
    text.lines().take(64).any(|line| {
        line.split_once(':')
            .is_some_and(|(key, _)| key.trim() == "Channel code")
    })
}

/// The header of a channel file: keys and values in their order.
#[derive(Debug, Clone, Default)]
pub(super) struct ChannelHeader {
    lines: Vec<(String, String)>,
    code: Option<Code>,
}

impl ChannelHeader {
    /// Reads the header at the start of decoded text.
    pub(super) fn read(content: &str) -> Self {
        let mut header = Self::default();
        for (_, line) in text::lines(content) {
            if line.trim().is_empty() {
                continue;
            }
            match line.split_once(':') {
                Some((key, value)) => {
                    header
                        .lines
                        .push((key.trim().to_string(), value.trim().to_string()));
                }
                None if is_value(line) => break,
                // A value that was cut at a fixed width and goes on.
                None => {
                    if let Some((_, value)) = header.lines.last_mut() {
                        value.push(' ');
                        value.push_str(line.trim());
                    }
                }
            }
        }
        header.code = header.value("Channel code").and_then(Code::new);
        header
    }

    /// Returns a value that says something.
    pub(super) fn value(&self, key: &str) -> Option<&str> {
        self.lines
            .iter()
            .find(|(known, _)| known.eq_ignore_ascii_case(key))
            .map(|(_, value)| value.as_str())
            .filter(|value| !value.is_empty() && *value != NOTHING)
    }

    fn number(&self, key: &str) -> Option<f64> {
        self.value(key).and_then(text::header_number)
    }

    pub(super) fn code(&self) -> Option<&Code> {
        self.code.as_ref()
    }

    /// Returns what the channel is called: its code, else its name.
    pub(super) fn label(&self) -> Option<String> {
        let code = self.value("Channel code").map(ToString::to_string);
        code.or_else(|| self.value("Name of the channel").map(ToString::to_string))
    }

    pub(super) fn is_time(&self) -> bool {
        self.code.is_some_and(|code| code.is_time())
    }

    /// Tells whether the channel is a linear acceleration: by its code, else by its unit.
    pub(super) fn is_acceleration(&self) -> bool {
        match &self.code {
            Some(code) => code.is_acceleration(),
            None => self
                .value("Unit")
                .and_then(AccelerationUnit::from_spelling)
                .is_some(),
        }
    }

    /// Tells whether name or comment say that another sensor is the primary one.
    pub(super) fn is_redundant(&self) -> bool {
        [
            "Name of the channel",
            "Comments",
            "Laboratory channel code",
            "Customer channel code",
        ]
        .iter()
        .filter_map(|key| self.value(key))
        .any(|value| value.to_ascii_uppercase().contains("REDUNDANT"))
    }

    pub(super) fn not_lateral_finding(&self) -> Option<Finding> {
        let code = self.code.as_ref()?;
        let reason = if !code.is_acceleration() {
            "its dimension is not AC (acceleration)"
        } else if !code.is_lateral() {
            "its direction is not Y"
        } else if !code.is_structure() {
            "it sits in a dummy or on a barrier, or at a place not known here"
        } else {
            return None;
        };
        Some(Finding::warning(
            "channel-not-lateral",
            format!(
                "{} is no lateral acceleration of a vehicle's structure: {reason}",
                code.text()
            ),
        ))
    }

    pub(super) fn sign_finding(&self) -> Option<Finding> {
        let code = self.code.filter(Code::diverges)?;
        Some(Finding::warning(
            "sign-diverges",
            format!(
                "{} has a direction whose sign diverges from SAE J211: state with --opens-when \
                 which sign of these samples opens",
                code.text()
            ),
        ))
    }

    /// Returns the name of the channel that holds the times, if they are explicit.
    pub(super) fn reference_channel(&self) -> Option<&str> {
        let kind = self.value("Reference channel")?;
        if !kind.eq_ignore_ascii_case("explicit") {
            return None;
        }
        Some(
            self.value("Reference channel name")
                .unwrap_or("a channel without a name"),
        )
    }

    /// Returns the rate that the sampling interval states.
    pub(super) fn interval(&self) -> Result<Option<SampleRate>, Error> {
        let Some(printed) = self.value("Sampling interval") else {
            return Ok(None);
        };
        let interval = text::header_number(printed).filter(|interval| *interval > 0.0);
        let Some(interval) = interval else {
            return Err(ErrorKind::Malformed {
                expected: "a sampling interval in seconds".into(),
                found: format!("`{}`", text::shown(printed)),
                hint: "state the rate with --rate-hz".into(),
            }
            .into());
        };
        time_base::rate_of_interval(interval, text::last_digit(printed)).map(Some)
    }

    pub(super) fn first_time(&self) -> Result<Option<f64>, Error> {
        let Some(printed) = self.value("Time of first sample") else {
            return Ok(None);
        };
        text::header_number(printed).map(Some).ok_or_else(|| {
            ErrorKind::Malformed {
                expected: "the time of the first sample in seconds".into(),
                found: format!("`{}`", text::shown(printed)),
                hint: "mend the header".into(),
            }
            .into()
        })
    }

    pub(super) fn stated(&self) -> Stated {
        let class = self
            .value("Channel frequency class")
            .map(ToString::to_string);
        let class = class
            .map(|class| class.trim_start_matches("CFC").trim().to_string())
            .or_else(|| self.code?.filter_class().map(ToString::to_string));
        Stated {
            location: self.value("Name of the channel").map(ToString::to_string),
            full_scale: self
                .number("Channel amplitude class")
                .filter(|range| *range > 0.0),
            prefilter_hz: self
                .number("Pre-filter type")
                .filter(|corner| *corner > 0.0),
            filter_class: class,
            status: self.value("Data status").map(ToString::to_string),
        }
    }

    /// Returns what status and comments say of the samples.
    pub(super) fn validity_findings(&self) -> Vec<Finding> {
        let comments: Vec<&str> = self
            .lines
            .iter()
            .filter(|(key, value)| {
                key.to_ascii_lowercase().starts_with("comment") && value != NOTHING
            })
            .map(|(_, value)| value.as_str())
            .collect();
        let comments = comments.join(" ");
        let mut found: Vec<Finding> = laboratory::told(&comments, None).into_iter().collect();
        let said = found
            .iter()
            .any(|finding| finding.severity == Severity::Blocking);
        let Some(status) = self.value("Data status") else {
            return found;
        };
        match status.to_ascii_lowercase().as_str() {
            "ok" | "o.k." | "as measured" => {}
            "linearised data" | "linearized data" | "scaling factor applied" => {
                found.push(Finding::info(
                    "channel-computed",
                    format!("the laboratory's word on the data: {status}"),
                ));
            }
            // The comment has said from when on.
            "questionable data" | "channel failed" if said => {}
            "questionable data" | "channel failed" | "meaningless data" | "no data"
            | "system failed" => found.push(Finding::blocking(
                "invalid-by-laboratory",
                format!("the laboratory's word on the data: {status}"),
            )),
            _ => found.push(Finding::warning(
                "laboratory-remark",
                format!(
                    "the laboratory's word on the data is not known here: {}",
                    text::shown(status)
                ),
            )),
        }
        found
    }

    /// Holds the stated number of samples against the file.
    pub(super) fn count_finding(&self, found: usize, end_s: f64) -> Option<Finding> {
        let stated = self.number("Number of samples")?;
        let found = to_f64(found);
        let text = format!("the header announces {stated} samples, the file holds {found}");
        if found < stated {
            Some(
                Finding::blocking(
                    "samples-missing",
                    format!("{text}; what came after is not known"),
                )
                .at(end_s),
            )
        } else {
            (found > stated).then(|| Finding::warning("count-contradicted", text))
        }
    }

    /// Holds the stated extremes and their times against the samples.
    pub(super) fn extreme_findings(
        &self,
        values: &[f64],
        start_s: f64,
        rate: SampleRate,
    ) -> Vec<Finding> {
        let largest = values
            .iter()
            .fold(0.0_f64, |most, value| most.max(value.abs()));
        let mut found = Vec::new();
        for (word, greatest) in [("maximum", true), ("minimum", false)] {
            let key = format!("First global {word} value");
            let (Some(stated), Some(printed)) = (self.number(&key), self.value(&key)) else {
                continue;
            };
            let extreme = values.iter().copied().fold(
                if greatest {
                    f64::NEG_INFINITY
                } else {
                    f64::INFINITY
                },
                |extreme, value| {
                    if greatest {
                        extreme.max(value)
                    } else {
                        extreme.min(value)
                    }
                },
            );
            let tolerance = text::last_digit(printed) + EXTREME_AGREEMENT * largest;
            if (extreme - stated).abs() > tolerance {
                found.push(Finding::warning(
                    "peak-contradicted",
                    format!(
                        "the header says that the {word} is {stated}, the samples have \
                         {extreme}: unit, scale or samples are not what the header says"
                    ),
                ));
                continue;
            }
            let key = format!("Time of {word} value");
            let (Some(time), Some(printed)) = (self.number(&key), self.value(&key)) else {
                continue;
            };
            let slack = 1.5 / rate.hertz() + text::last_digit(printed);
            let there = values.iter().enumerate().any(|(index, value)| {
                (value - extreme).abs() <= tolerance
                    && (start_s + to_f64(index) / rate.hertz() - time).abs() <= slack
            });
            if !there {
                found.push(Finding::warning(
                    "peak-contradicted",
                    format!(
                        "the header says that the {word} is at {time} s, the samples do not \
                         have it there: the time base is not what the header says"
                    ),
                ));
            }
        }
        found
    }
}

/// The samples of a channel file.
#[derive(Debug)]
pub(super) struct Samples {
    /// Samples between the first and the last that is there; missing ones are interpolated.
    pub(super) values: Vec<f64>,
    /// Missing samples before the first.
    pub(super) skipped: usize,
    /// Lines of samples, missing ones included.
    pub(super) count: usize,
    /// First and one past the last index of each run of missing samples.
    pub(super) holes: Vec<(usize, usize)>,
    /// Size of the last printed digit; 0 if unknown.
    pub(super) last_digit: f64,
}

impl Samples {
    pub(super) fn read(bytes: Vec<u8>, limits: &Limits) -> Result<Self, Error> {
        let (bytes, _) = encoding::decode(bytes, limits)?;
        text::check_line_lengths(&bytes, limits)?;
        let content = String::from_utf8_lossy(&bytes);
        let mut values: Vec<f64> = Vec::new();
        let mut holes: Vec<(usize, usize)> = Vec::new();
        let mut decimal = Decimal::Unknown;
        let mut digits = PrintedDigits::new();
        let mut inside = false;
        for (number, line) in text::lines(&content) {
            let cell = line.trim();
            if cell.is_empty() {
                continue;
            }
            inside = inside || (!cell.contains(':') && is_value(cell));
            if !inside {
                continue;
            }
            let place = Place::default().line(number);
            if values.len() as u64 >= limits.samples {
                return Err(text::too_many_samples(limits).at(place));
            }
            if cell == NOTHING {
                let index = values.len();
                match holes.last_mut() {
                    Some((_, end)) if *end == index => *end = index + 1,
                    _ => holes.push((index, index + 1)),
                }
                values.push(f64::NAN);
                continue;
            }
            values.push(text::sample(cell, &mut decimal).map_err(|error| error.at(place))?);
            digits.count(cell.as_bytes());
        }
        let count = values.len();
        let first = values.iter().position(|value| !value.is_nan());
        let last = values.iter().rposition(|value| !value.is_nan());
        let (Some(first), Some(last)) = (first, last) else {
            return Err(ErrorKind::Empty {
                found: "the channel file holds no sample".into(),
                expected: "one value a line after the header".into(),
            }
            .into());
        };
        for (start, end) in &holes {
            if *start > first && *end <= last {
                fill(&mut values, *start, *end);
            }
        }
        Ok(Self {
            values: values[first..=last].to_vec(),
            skipped: first,
            count,
            holes,
            last_digit: digits.last_digit(),
        })
    }
}

/// Puts a straight line where samples are missing between two that are there.
fn fill(values: &mut [f64], start: usize, end: usize) {
    let (before, after) = (values[start - 1], values[end]);
    let steps = to_f64(end - start + 1);
    for (index, value) in values[start..end].iter_mut().enumerate() {
        *value = before + (after - before) * (to_f64(index + 1) / steps);
    }
}

/// Tells whether a line is a sample, be it a missing one.
fn is_value(line: &str) -> bool {
    let cell = line.trim();
    cell == NOTHING || text::header_number(cell).is_some()
}
