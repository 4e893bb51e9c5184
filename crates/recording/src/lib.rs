//! Recordings: what a file holds, channel by channel, with what was found odd in it.
//!
//! A reader turns bytes into [`Channel`]s in the file's own unit on a uniform time base.
//! One table, [`FORMATS`], lists the readers; a new format is one file here and one line there. Readers never guess in silence: what they assume or mend they
//! return as a [`Finding`] beside the channel.
//!
//! - `archive`: archives: .zip, .tar.gz and .tar, unpacked within limits;
//! - `card`: cards: a recording's full name plus `.toml`, with facts that the file itself lacks;
//! - `channel_name`: the meaning of a channel's name: words, unit, time, filter, gravity;
//! - `code`: channel codes of ISO/TS 13499: 16 characters for place and quantity of a channel;
//! - `csv`: text tables: CSV and its relatives;
//! - `draft`: the last step of all readers: from a channel as it was found to one that is delivered;
//! - `encoding`: encodings: from a file's bytes to UTF-8 text whose lines end with a line feed;
//! - `error`: what was expected, what was found, where, and what to type next;
//! - `ev5`: NHTSA EV5 ASCII X-Y: a test's `.EV5` with its curve files, or one curve file;
//! - `finding`: findings: something odd in usable data, with its effect on a verdict;
//! - `held`: comparison of a file's statements with its samples: one rule for every format;
//! - `lateral`: the choice of the lateral acceleration among several named columns;
//! - `limits`: limits on input, so that memory stays bounded;
//! - `lvm`: LabVIEW measurement files (.lvm): text in two headers and a table;
//! - `mcap`: MCAP logs: messages of ROS 2 (CDR) and ROS 1, protobuf by its own descriptor, and
//!   JSON;
//! - `mme`: ISO/TS 13499 (ISO-MME): a test as folder, .zip, .tar.gz or .tar, or one channel of
//!   it;
//! - `number`: numbers in cells: decimal point or comma, and the digits they were printed with;
//! - `pulse`: pulses by formula, in place of a recording;
//! - `remarks`: remarks: free words of laboratories and operators, for a person to read;
//! - `sensor_place`: the place of a sensor, and the factors between it and the latch;
//! - `setting`: the settings of a question, by the names that every interface uses for them;
//! - `source`: the source of the bytes: a file, standard input or memory, hashed while it is read;
//! - `tdms`: NI TDMS (.tdms), as LabVIEW and DIAdem write it;
//! - `text`: tools of all readers of text: lines within limits, decimal numbers as the file writes
//!   them;
//! - `time_base`: time bases: from printed stamps to a uniform rate, or to a resampled one with a
//!   finding;
//! - `words`: lists of words that readers know, each in a file of its own in `words/`, where
//!   words are added without a look at the program;
//! - `workbook`: workbooks of Excel (.xlsx, .xlsm, .xls): a sheet is a table, read by the rules of
//!   text tables.

mod archive;
pub mod calendar;
pub mod card;
mod channel_name;
mod code;
pub mod csv;
mod draft;
mod encoding;
pub mod error;
pub mod ev5;
mod examine;
pub mod finding;
mod held;
mod lateral;
pub mod limits;
pub mod lvm;
pub mod mcap;
pub mod mme;
mod number;
pub mod pulse;
mod remarks;
mod sensor_place;
pub mod setting;
pub mod source;
pub mod tdms;
mod text;
pub mod time_base;
mod words;
pub mod workbook;

pub use card::Card;
pub use finding::{Finding, Severity};
pub use lateral::{ChannelAxis, axis_of, is_lateral, is_same_place, is_sibling, side_of};
pub use limits::Limits;
pub use remarks::AcceptedRemark;
pub use sensor_place::{SensorPlace, TransferRange, place_of};
pub use source::{Part, Source, read_within};

use crate::error::{Error, ErrorKind, Place};
use crate::setting::Setting;
use card::CardPolarity;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::signal::Reading as SignalReading;
use latchgate_kernel::units::{
    AccelerationUnit, DecimalMark, MessageClock, STANDARD_GRAVITY, SampleRate, SensorSensitivity,
    TimeUnit,
};
use remarks::{Remark, Span};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use words::{Words, word_list};

/// Settings of a person for one recording, from options and card (option before card).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReadOptions {
    /// Column name or 1-based number, MCAP `topic:field.path`, EV5 curve number, or ISO-MME
    /// code, pattern or file number.
    pub channel: Option<String>,
    /// Name or 1-based number of the column that holds the time.
    pub time_column: Option<String>,
    /// Unit of the time column.
    pub time_unit: Option<TimeUnit>,
    /// Clock of a log's messages that gives the time.
    pub time_source: Option<MessageClock>,
    /// Name of the sheet of a workbook.
    pub sheet: Option<String>,
    /// Line of a text table that names its columns, counted from 1; lines above hold no samples.
    pub header_line: Option<u32>,
    /// Line of a text table that holds the units of its columns.
    pub unit_line: Option<u32>,
    /// Last line of a text table; lines below hold no samples.
    pub last_line: Option<u32>,
    /// Lines at the start of a text table that are skipped.
    pub skip_lines: Option<u32>,
    /// Decimal mark of a text table.
    pub decimal: Option<DecimalMark>,
    /// Sample rate where there is no time column [Hz].
    pub rate_hz: Option<f64>,
    /// The instant of first contact on the file's clock [s]; becomes time 0.
    pub time_zero_s: Option<f64>,
    /// Unit of acceleration.
    pub unit: Option<AccelerationUnit>,
    /// Acceleration that one of the samples means, where they are another quantity.
    pub sensitivity: Option<SensorSensitivity>,
    /// True if a card, not an option, states `unit` or `sensitivity`.
    pub unit_from_card: bool,
    /// Format name of [`FORMATS`]; detected if absent.
    pub input_format: Option<String>,
    /// Remarks that a person has read and accepts.
    pub accepted_remarks: Vec<AcceptedRemark>,
}

impl ReadOptions {
    /// Returns the instant on the file's clock that becomes time 0 [s].
    fn zero_s(&self) -> f64 {
        self.time_zero_s.unwrap_or(0.0)
    }

    /// Refuses settings of the layout of a text table and of the clock of a log, for a format that has
    /// neither.
    fn refuse_foreign_settings(&self, format: &str) -> Result<(), Error> {
        if format != "mcap" && self.time_source.is_some() {
            return Err(Error::malformed(
                format!("a log of messages, as {} needs", Setting::TimeSource),
                format!("the format {format}"),
                format!("leave out {}", Setting::TimeSource),
            ));
        }
        if format != "workbook" && self.sheet.is_some() {
            return Err(Error::malformed(
                format!("a workbook, as {} needs", Setting::Sheet),
                format!("the format {format}"),
                format!("leave out {}", Setting::Sheet),
            ));
        }
        let stated = [
            (Setting::HeaderLine, self.header_line.is_some()),
            (Setting::SkipLines, self.skip_lines.is_some()),
            (Setting::UnitLine, self.unit_line.is_some()),
            (Setting::LastLine, self.last_line.is_some()),
            (Setting::Decimal, self.decimal.is_some()),
        ];
        let stated = stated.iter().filter(|(_, is_stated)| *is_stated);
        let stated: Vec<String> = stated.map(|(setting, _)| setting.to_string()).collect();
        if ["csv", "workbook"].contains(&format) || stated.is_empty() {
            return Ok(());
        }
        Err(Error::malformed(
            "a text table, as settings of lines and decimal marks need",
            format!("the format {format}"),
            format!("leave out {}", stated.join(" and ")),
        ))
    }

    /// Refuses a column of times for a format that states where its times are; `format` names it.
    fn refuse_time_column(&self, format: &str) -> Result<(), Error> {
        if self.time_column.is_none() {
            return Ok(());
        }
        Err(Error::malformed(
            format!("{format}, which states where its times are"),
            "another statement",
            format!("leave out {}", Setting::TimeColumn),
        ))
    }

    /// Refuses settings of the place or unit of times for a format that states the place and has
    /// seconds; `format` names it and `way_out` is another remedy.
    fn refuse_other_clock(&self, format: &str, way_out: &str) -> Result<(), Error> {
        let other_unit = self.time_unit.is_some_and(|unit| unit != TimeUnit::SECOND);
        if self.time_column.is_none() && !other_unit {
            return Ok(());
        }
        Err(Error::malformed(
            format!("{format}, which states where its times are, in seconds"),
            "another statement",
            format!("leave out the setting `time_column` and the setting `time_unit`{way_out}"),
        ))
    }
}

/// The channels that a reader delivers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Selection {
    /// The one that `ReadOptions::channel` names, or the one lateral acceleration.
    Lateral,
    /// Every channel that carries numbers, for `inspect`. Here a channel without a unit is
    /// no error, and one without a known time is left out with a finding.
    Every,
}

/// Task of a reader.
#[derive(Debug, Clone, Copy)]
pub struct ReadTask<'a> {
    /// Settings of a person.
    pub options: &'a ReadOptions,
    /// The selections to deliver; an error of one does not touch the others.
    pub selections: &'a [Selection],
    /// Limits beyond which input is refused.
    pub limits: &'a Limits,
}

impl ReadTask<'_> {
    /// Delivers each selection.
    fn each(self, mut read: impl FnMut(Selection) -> Result<ReadOutcome, Error>) -> Outcomes {
        self.selections
            .iter()
            .map(|selection| read(*selection))
            .collect()
    }
}

/// One measured channel on a uniform time base, in the file's own unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Column name, or MCAP `topic:field.path`.
    pub name: String,
    /// Unit of the values; `None` only under [`Selection::Every`].
    pub unit: Option<AccelerationUnit>,
    /// Source of the unit: `option`, `card`, `header`, `units row`, `format`.
    pub unit_source: &'static str,
    /// Time of the first sample, after `time_zero_s` was subtracted [s].
    pub start_s: f64,
    /// Sample rate of the uniform time base.
    pub rate: SampleRate,
    /// The samples, in `unit`.
    pub values: Vec<f64>,
    /// Facts that the file states of the channel beside its samples.
    pub stated: Stated,
    /// Findings made while reading.
    pub findings: Vec<Finding>,
    /// The formula that gave the samples, of a pulse.
    pub pulse: Option<ExactPulse>,
}

/// A channel by formula, exact between its samples.
#[derive(Debug, Clone, PartialEq)]
pub struct ExactPulse {
    /// The channel as its formula runs, in the channel's unit.
    pub reading: SignalReading<'static>,
    /// Sign of the acceleration that opens, as the pulse declares it.
    pub opens_when: CardPolarity,
}

/// Facts that file or card state of the test and of the sensor; `None` where they state none.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct TestFacts {
    /// The test: its number, and what it was.
    pub test: Option<String>,
    /// The vehicle, or the vehicles.
    pub vehicle: Option<String>,
    /// The laboratory.
    pub laboratory: Option<String>,
    /// The day of the test, as it is written.
    pub date: Option<String>,
    /// The speed, with its unit.
    pub speed: Option<String>,
    /// The sensor: make, serial number, calibration, full scale.
    pub sensor: Option<String>,
    /// Where the sensor sits, in the format's codes or in words.
    pub location: Option<String>,
}

impl TestFacts {
    /// Returns these facts, with those of `other` where these are missing.
    pub fn or(self, other: Self) -> Self {
        Self {
            test: self.test.or(other.test),
            vehicle: self.vehicle.or(other.vehicle),
            laboratory: self.laboratory.or(other.laboratory),
            date: self.date.or(other.date),
            speed: self.speed.or(other.speed),
            sensor: self.sensor.or(other.sensor),
            location: self.location.or(other.location),
        }
    }

    /// Returns the facts that `other` states as well, in the same words.
    pub fn shared_with(&self, other: &Self) -> Self {
        self.filtered(|fact| fact(self) == fact(other))
    }

    /// Returns the facts that are not among those of `other`.
    pub fn beyond(&self, other: &Self) -> Self {
        self.filtered(|fact| fact(self) != fact(other))
    }

    /// Returns the facts that `keeps` accepts, each passed to it by its field.
    fn filtered(&self, keeps: impl Fn(fn(&Self) -> &Option<String>) -> bool) -> Self {
        let kept = |fact: fn(&Self) -> &Option<String>| fact(self).clone().filter(|_| keeps(fact));
        Self {
            test: kept(|facts| &facts.test),
            vehicle: kept(|facts| &facts.vehicle),
            laboratory: kept(|facts| &facts.laboratory),
            date: kept(|facts| &facts.date),
            speed: kept(|facts| &facts.speed),
            sensor: kept(|facts| &facts.sensor),
            location: kept(|facts| &facts.location),
        }
    }

    /// Returns them with each text cut to a length that a line can show.
    fn shortened(self) -> Self {
        const MOST: usize = 200;
        let short = |text: Option<String>| {
            text.map(|text| match text.char_indices().nth(MOST) {
                Some((end, _)) => format!("{}…", &text[..end]),
                None => text,
            })
        };
        Self {
            test: short(self.test),
            vehicle: short(self.vehicle),
            laboratory: short(self.laboratory),
            date: short(self.date),
            speed: short(self.speed),
            sensor: short(self.sensor),
            location: short(self.location),
        }
    }
}

/// Returns the fact in the value of a header's key; `None` for a placeholder.
fn fact(value: &str) -> Option<String> {
    const PLACEHOLDERS: [&str; 4] = ["N/A", "NA", "NONE", "NOVALUE"];
    let value = value.trim();
    let says = value.contains(char::is_alphanumeric)
        && !PLACEHOLDERS
            .iter()
            .any(|word| word.eq_ignore_ascii_case(value));
    says.then(|| value.to_string())
}

/// Joins facts of one kind; `None` without any.
fn joined_facts<const N: usize>(facts: [Option<String>; N]) -> Option<String> {
    let facts: Vec<String> = facts.into_iter().flatten().collect();
    (!facts.is_empty()).then(|| facts.join(", "))
}

/// Facts that a file states of a channel beside its samples; `None` where it states none.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Stated {
    /// Place and axis of the sensor, in the format's own codes.
    pub location: Option<String>,
    /// That place as a latch sees it, of a format whose codes are no channel codes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<SensorPlace>,
    /// Full scale, in the channel's unit.
    pub full_scale: Option<f64>,
    /// Corner frequency of the analogue filter [Hz].
    pub prefilter_hz: Option<f64>,
    /// Channel frequency class that the laboratory has already applied.
    pub filter_class: Option<String>,
    /// True if the file states that the channel was not filtered.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub unfiltered: bool,
    /// True if the samples hold gravity, by the type of the message or by words.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub gravity: bool,
    /// The laboratory's judgement of the data, in the format's own codes.
    pub status: Option<String>,
    /// A second source of the clock, which agrees with the one that is used.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clock_confirmed_by: Option<String>,
    /// An observation against the clock that proves nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clock_doubt: Option<String>,
    /// Free words on the channel, as they are shown.
    #[serde(default)]
    pub remarks: Vec<String>,
    /// Facts of the test and of the sensor.
    #[serde(default)]
    pub test: TestFacts,
}

impl Channel {
    /// Returns the time of sample `index` [s].
    pub fn time_s(&self, index: usize) -> f64 {
        let steps = index as f64;
        self.start_s + steps / self.rate.hertz()
    }

    /// Returns the full scale that the file states [g].
    pub fn full_scale_g(&self) -> Option<f64> {
        let factor = self.unit?.metres_per_second_squared();
        Some(self.stated.full_scale? * factor / STANDARD_GRAVITY)
    }

    /// Returns the SHA-256 of the signal itself, lower-case hexadecimal: of the text
    /// `latchgate.signal/1` and a line feed, then of rate [Hz], time of the first sample [s] and
    /// samples [m/s²], each a little-endian IEEE 754 double. The same signal has the same hash
    /// whatever file it comes from. `None` without a unit.
    pub fn content_sha256(&self) -> Option<String> {
        let factor = self.unit?.metres_per_second_squared();
        let mut hasher = Sha256::new();
        hasher.update(b"latchgate.signal/1\n");
        // Adding zero turns a negative zero, which no measurement means, into a plain one.
        hasher.update((self.rate.hertz() + 0.0).to_le_bytes());
        hasher.update((self.start_s + 0.0).to_le_bytes());
        for value in &self.values {
            hasher.update((value * factor + 0.0).to_le_bytes());
        }
        Some(source::hexadecimal(&hasher.finalize()))
    }
}

/// Channel frequency classes below CFC 1000, which a latch needs.
const HEAVY_CLASSES: [&str; 4] = ["20", "60", "180", "600"];

/// Corner frequency below which an analogue filter weakens a latch's excitation [Hz].
const LEAST_PREFILTER_HZ: f64 = 1000.0;

impl Stated {
    /// Returns the finding that a channel frequency class was applied before the samples were stored.
    fn class_finding(class: &str) -> Finding {
        let reason = format!("the laboratory filtered the channel with CFC {class}");
        let mut finding = Finding::filtered(&reason);
        if !HEAVY_CLASSES.contains(&class) {
            finding.severity = Severity::Info;
        }
        finding
    }

    /// Returns the findings of the statements at a sample rate: filters that were applied before the
    /// samples were stored cannot be undone.
    pub fn findings(&self, rate: SampleRate) -> Vec<Finding> {
        let class = self.filter_class.iter();
        let mut findings: Vec<Finding> = class.map(|class| Self::class_finding(class)).collect();
        let Some(corner) = self.prefilter_hz else {
            return findings;
        };
        if corner >= 0.5 * rate.hertz() {
            let text = format!(
                "the analogue filter ends at {corner} Hz, beyond half the sample rate of {} Hz. \
                 Motion above that half shows as a slower one. Record at a higher rate",
                rate.hertz()
            );
            findings.push(Finding::warning("aliasing-suspected", text));
        } else if corner < LEAST_PREFILTER_HZ {
            findings.push(Finding::filtered(&format!(
                "the analogue filter ends at {corner} Hz, below what CFC 1000 lets through"
            )));
        }
        findings
    }
}

/// A file that was read: its identity and its channels.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// File name without folders; `-` for standard input.
    pub file: String,
    /// SHA-256 of the file's bytes, lower-case hexadecimal; of a folder, that of its list of parts.
    pub sha256: String,
    /// Further files that were read for it.
    pub parts: Vec<Part>,
    /// Format name of [`FORMATS`].
    pub format: &'static str,
    /// The channels delivered: exactly one under [`Selection::Lateral`].
    pub channels: Vec<Channel>,
    /// Findings on the file as a whole.
    pub findings: Vec<Finding>,
    /// Mapping of a text table or a sheet, under [`Selection::Every`].
    pub table: Option<csv::TableMapping>,
}

/// Start and names of a file, by which its format is recognised.
#[derive(Debug, Clone, Copy)]
pub struct Head<'a> {
    /// The first bytes, up to 4096; none of a folder.
    pub bytes: &'a [u8],
    /// File name without folders.
    pub file_name: &'a str,
    /// True if it is a folder.
    pub is_folder: bool,
    /// True if it is an archive that was unpacked.
    pub is_archive: bool,
    /// Names of the files in it, if it is a folder or an archive.
    pub entries: &'a [String],
}

/// A reader: a test for its files, and the function that reads them.
#[derive(Debug)]
pub struct Format {
    /// Name for the setting and for verdicts.
    pub name: &'static str,
    /// True if the file is of this format.
    pub recognises: fn(head: &Head<'_>) -> bool,
    /// Reads the channels of each selection in one pass over the bytes that `source` streams.
    pub read: fn(source: &mut source::Reader, task: ReadTask) -> Result<Outcomes, Error>,
}

impl Format {
    const fn new(
        name: &'static str,
        recognises: fn(&Head<'_>) -> bool,
        read: fn(&mut source::Reader, ReadTask) -> Result<Outcomes, Error>,
    ) -> Self {
        Self {
            name,
            recognises,
            read,
        }
    }
}

/// Result of a reader for each selection, in their order.
pub type Outcomes = Vec<Result<ReadOutcome, Error>>;

/// Result of a reader for one selection.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReadOutcome {
    /// The channels.
    pub channels: Vec<Channel>,
    /// Findings on the file as a whole.
    pub findings: Vec<Finding>,
    /// Names of the further files that were read for them.
    pub parts: BTreeSet<String>,
    /// Mapping of a text table or a sheet, under [`Selection::Every`].
    pub table: Option<csv::TableMapping>,
    /// Free words on the file as a whole.
    remarks: Vec<Remark>,
}

impl ReadOutcome {
    /// Adds the findings that the remarks on the file as a whole make.
    fn add_remark_findings(&mut self, options: &ReadOptions, selection: Selection) {
        let zero_s = options.zero_s();
        let span = |channel: &Channel| {
            Span::new(channel.start_s + zero_s, channel.rate, channel.values.len())
        };
        let spans = self.channels.iter().map(span);
        let accepted = &options.accepted_remarks;
        if let Some(span) = spans.reduce(Span::with) {
            let mut remark_findings = remarks::findings(&self.remarks, accepted, span);
            draft::move_instants(&mut remark_findings, zero_s);
            self.findings.extend(remark_findings);
        }
        if selection == Selection::Lateral {
            let channels = self.channels.iter();
            let channel_remarks = channels.flat_map(|channel| channel.stated.remarks.clone());
            let remarks: Vec<String> = channel_remarks
                .chain(remarks::shown(&self.remarks))
                .collect();
            self.findings.extend(remarks::not_found(accepted, &remarks));
        }
    }
}

/// Every format that is read, the most easily recognised first.
pub const FORMATS: &[Format] = &[
    Format::new("pulse", pulse::recognises, pulse::read),
    Format::new("mcap", mcap::recognises, mcap::read),
    Format::new("tdms", tdms::recognises, tdms::read),
    Format::new("ev5", ev5::recognises, ev5::read),
    Format::new("iso-mme", mme::recognises, mme::read),
    Format::new("workbook", workbook::recognises, workbook::read),
    Format::new("lvm", lvm::recognises, lvm::read),
    Format::new("csv", csv::recognises, csv::read),
];

/// Reads a recording.
///
/// # Errors
///
/// Any [`ErrorKind`] of the readers, each at the place in the file where it arose.
pub fn read(
    source: &Source,
    options: &ReadOptions,
    selection: Selection,
    limits: &Limits,
) -> Result<Recording, Error> {
    let [recording] = read_each(source, options, [selection], limits, Control::default());
    recording
}

/// Result of one reading of a file under either [`Selection`].
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// The one channel that is meant, as [`Selection::Lateral`] delivers it.
    pub chosen: Result<Recording, Error>,
    /// Every channel that carries numbers, as [`Selection::Every`] delivers them.
    pub every: Result<Recording, Error>,
}

/// Reads the channel that is meant and its neighbours in one pass over the bytes. An error of one of
/// the two does not touch the other. Where `control` stops the reading, both are errors.
pub fn read_both(
    source: &Source,
    options: &ReadOptions,
    limits: &Limits,
    control: &Control<'_>,
) -> Reading {
    let both = [Selection::Lateral, Selection::Every];
    let [chosen, every] = read_each(source, options, both, limits, *control);
    Reading { chosen, every }
}

/// Reads a recording under each of several selections.
fn read_each<const N: usize>(
    source: &Source,
    options: &ReadOptions,
    selections: [Selection; N],
    limits: &Limits,
    control: Control<'_>,
) -> [Result<Recording, Error>; N] {
    let task = ReadTask {
        options,
        selections: &selections,
        limits,
    };
    // An error of the whole file is an error of each selection.
    let outcomes = outcomes(source, task, control)
        .unwrap_or_else(|error| selections.map(|_| Err(error.clone())).into());
    let mut outcomes = outcomes.into_iter();
    selections.map(|_| {
        let outcome = outcomes.next();
        let outcome = outcome.expect("a reader gives one outcome for each selection");
        outcome.map_err(|error| error.at(Place::file(source.name())))
    })
}

/// Finds the format of a reader's file, and unpacks an archive.
fn format_of(reader: &mut source::Reader, task: ReadTask) -> Result<&'static Format, Error> {
    let bytes = reader.head()?;
    let named = task.options.input_format.as_deref();
    // Other formats are no archives, and a named one must see the bytes as they are.
    let may_be_archive = named.is_none_or(|name| ["ev5", "iso-mme", "workbook"].contains(&name));
    if may_be_archive && archive::is_archive(&bytes) {
        let packed = reader.read_all("archive_bytes", task.limits.archive_bytes)?;
        let files = archive::unpack(reader.name(), packed, task.limits)?;
        reader.set_siblings(files);
    }
    let entries = match reader.is_folder() || reader.is_archive() {
        true => reader.list(true, task.limits)?,
        false => Vec::new(),
    };
    let head = Head {
        bytes: &bytes,
        file_name: reader.name(),
        is_folder: reader.is_folder(),
        is_archive: reader.is_archive(),
        entries: &entries,
    };
    find_format(&head, named)
}

fn outcomes(
    source: &Source,
    task: ReadTask,
    control: Control<'_>,
) -> Result<Vec<Result<Recording, Error>>, Error> {
    let mut reader = source.open_watched(control)?;
    let format = format_of(&mut reader, task)?;
    task.options.refuse_foreign_settings(format.name)?;
    let mut outcomes = (format.read)(&mut reader, task)?;
    for (outcome, selection) in outcomes.iter_mut().zip(task.selections) {
        if let Ok(read) = outcome {
            read.add_remark_findings(task.options, *selection);
        }
    }
    if outcomes.iter().all(Result::is_err) {
        // Nothing is delivered, so the rest of the file need not be read for its hash.
        let failed = outcomes.into_iter().filter_map(Result::err);
        return Ok(failed.map(Err).collect());
    }
    let hashes = reader.finish_hashes()?;
    let recording = |outcome: ReadOutcome| {
        tracing::info!(file = %source.name(), format = format.name, channels = outcome.channels.len(), "recording read");
        let (sha256, parts) = hashes.with_parts(&outcome.parts);
        Recording {
            file: source.name(),
            sha256,
            parts,
            format: format.name,
            channels: outcome.channels,
            findings: outcome.findings,
            table: outcome.table,
        }
    };
    let read = outcomes.into_iter().map(|outcome| outcome.map(recording));
    Ok(read.collect())
}

/// Returns the mapping of a text table or a sheet, which is a guess where a setting is missing; `None`
/// of another format, and where nothing like a table is found.
pub fn table_mapping(
    source: &Source,
    options: &ReadOptions,
    limits: &Limits,
    control: &Control<'_>,
) -> Option<csv::TableMapping> {
    let mut reader = source.open_watched(*control).ok()?;
    let task = ReadTask {
        options,
        selections: &[],
        limits,
    };
    let format = format_of(&mut reader, task).ok()?;
    match format.name {
        "csv" => csv::mapping(&mut reader, task).ok(),
        "workbook" => workbook::mapping(&mut reader, task).ok(),
        _ => None,
    }
}

/// Formats that are known but not read: first bytes or suffix, name, remedy.
static REFUSED: Words = word_list!("refused-formats");

/// Recognises a format that is not read: name, remedy.
fn refused(head: &Head<'_>) -> Option<(&'static str, &'static str)> {
    let is_text = encoding::looks_like_text(head.bytes);
    let extension = head
        .file_name
        .rsplit_once('.')
        .map_or("", |(_, extension)| extension);
    let fits = |mark: &str| match mark.as_bytes()[0] {
        b'.' => !is_text && mark[1..].eq_ignore_ascii_case(extension),
        b'+' => begins_with(head.bytes, &mark[1..]),
        // A table may have column names that begin like a mark.
        _ => begins_with(head.bytes, mark) && !(is_text && csv::looks_like_table(head.bytes)),
    };
    let entries = REFUSED.iter().filter_map(|line| {
        let (mark, name_and_hint) = line.split_once('\t')?;
        Some((mark, name_and_hint.split_once('\t')?))
    });
    let listed = entries.filter(|(mark, _)| fits(mark));
    let longest = listed.max_by_key(|(mark, _)| mark.len());
    let refusal = longest.map(|(_, name_and_hint)| name_and_hint);
    refusal.or_else(|| refused_by_content(head, is_text))
}

/// True if bytes begin with a mark, in which `\xNN` is a byte, `\d` a digit and `\?` any byte.
fn begins_with(bytes: &[u8], mark: &str) -> bool {
    let (mut bytes, mut letters) = (bytes.iter(), mark.bytes());
    while let Some(letter) = letters.next() {
        let Some(byte) = bytes.next() else {
            return false;
        };
        let escape = if letter == b'\\' {
            letters.next()
        } else {
            None
        };
        let fits = match escape {
            None => *byte == letter,
            Some(b'd') => byte.is_ascii_digit(),
            Some(b'?') => true,
            Some(_) => {
                let digit = |letter: Option<u8>| char::from(letter?).to_digit(16);
                digit(letters.next())
                    .zip(digit(letters.next()))
                    .is_some_and(|(high, low)| u32::from(*byte) == 16 * high + low)
            }
        };
        if !fits {
            return false;
        }
    }
    true
}

/// Recognises formats that are not read and that the first bytes alone do not show: name, remedy.
fn refused_by_content(head: &Head<'_>, is_text: bool) -> Option<(&'static str, &'static str)> {
    let text = head.bytes.strip_prefix(b"\xEF\xBB\xBF");
    let text = text.unwrap_or(head.bytes);
    if text.starts_with(b"<?xml") && memchr::memmem::find(text, b"usi:tdm").is_some() {
        return Some(("NI DIAdem (.tdm)", "export the channel as CSV from DIAdem"));
    }
    if text.starts_with(b"<?xml") && memchr::memmem::find(text, b"<sie ").is_some() {
        return Some((
            "HBM SoMat (.sie)",
            "export the channel as CSV from InField or nCode",
        ));
    }
    let lines = text.split(|byte| *byte == b'\n');
    let lines: Vec<&[u8]> = lines.take(3).map(<[u8]>::trim_ascii_end).collect();
    if let [date, base, _] = lines.as_slice()
        && date.starts_with(b"date ")
        && base.starts_with(b"base ")
        && memchr::memmem::find(base, b"timestamps ").is_some()
    {
        let way_out = "decode the signal and export it as CSV from CANalyzer, or with python-can \
                       and cantools";
        return Some(("a CAN log of Vector (.asc)", way_out));
    }
    // A dataset begins with a line of -1 and one with its number, both in six columns, and text.
    if let [b"    -1", dataset, title] = lines.as_slice()
        && let Some(number) = dataset.strip_prefix(b"  ").and_then(|rest| rest.get(..4))
        && !number.trim_ascii_start().is_empty()
        && number.trim_ascii_start().iter().all(u8::is_ascii_digit)
        && title.iter().any(u8::is_ascii_alphabetic)
    {
        let way_out = "export the channel as CSV, for example with pyuff";
        return Some(("a universal file (.uff, .unv)", way_out));
    }
    if is_text && is_json(text) {
        let way_out = "write the samples as CSV, with a column of times and one of accelerations";
        return Some(("JSON", way_out));
    }
    match head.bytes {
        [first, 0, second, 0, ..] | [0, first, 0, second, ..]
            if first.is_ascii_graphic() && second.is_ascii_graphic() =>
        {
            let format = "UTF-16 text without its byte order mark";
            Some((format, "save it as UTF-8"))
        }
        _ => None,
    }
}

/// True if a text is JSON. A bracket may begin a unit or a date in a table.
fn is_json(text: &[u8]) -> bool {
    let text = text.trim_ascii_start();
    let inside = text.get(1..).unwrap_or_default().trim_ascii_start();
    matches!(
        (text.first(), inside.first()),
        (Some(b'{'), Some(b'"' | b'}')) | (Some(b'['), Some(b'{' | b'[' | b'"'))
    )
}

fn find_format(head: &Head<'_>, named: Option<&str>) -> Result<&'static Format, Error> {
    let names: Vec<&str> = FORMATS.iter().map(|format| format.name).collect();
    let mut formats = FORMATS.iter();
    if let Some(name) = named {
        let format = formats.find(|format| format.name == name);
        return format.ok_or_else(|| Error::unknown("input format", name, &names));
    }
    if head.bytes.is_empty() && !head.is_folder {
        return Err(Error::empty("the file is empty", "a recording"));
    }
    let format = formats.find(|format| (format.recognises)(head));
    // Any text may be a table, so `csv` only means that no other reader recognises it.
    let is_certain = format.is_some_and(|format| format.name != "csv") || head.is_folder;
    if let Some((format, way_out)) = refused(head).filter(|_| !is_certain) {
        return Err(ErrorKind::RefusedFormat { format, way_out }.into());
    }
    format.ok_or_else(|| {
        let (action, reason) = ("read the recording", "it is a folder; name a file in it");
        let start = &head.bytes[..head.bytes.len().min(8)];
        Error::from(if head.is_folder {
            let reason = reason.into();
            ErrorKind::Io { action, reason }
        } else if head.is_archive {
            let (format, way_out) = ("an archive of several tests", "unpack it and name one");
            ErrorKind::RefusedFormat { format, way_out }
        } else {
            ErrorKind::UnknownFormat {
                found: format!("first bytes {start:02x?}"),
                expected: names.join(", "),
            }
        })
    })
}
