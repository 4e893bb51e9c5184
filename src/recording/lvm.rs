//! LabVIEW measurement files (.lvm): text in two headers and a table.
//!
//! The header says much that the table does not keep: a number of samples, an interval where a
//! time column runs otherwise, a decimal mark. What the table shows counts; where the two
//! differ a finding says so. Words in the Comment column are the operator's, and count as a
//! laboratory's do.
//!
//! # Source
//!
//! NI, "Specification for the LabVIEW Measurement File (.lvm)".
//!
//! - `header`: the two headers of a LabVIEW measurement file.

mod header;

use super::csv::header::Column;
use super::draft::{self, Draft, UniformSamples, Unit};
use super::held::Statement;
use super::number::{Decimal, Marks, PrintedDigits};
use super::remarks::Cells;
use super::source::Reader;
use super::time_base::{self, TimeBase};
use super::{
    Channel, Finding, Head, Limits, Outcomes, ReadOptions, ReadOutcome, Selection, csv, encoding,
    held, lateral, text,
};
use crate::error::{Candidate, Candidates, Error, ErrorKind, Place};
use crate::units::SampleRate;
use header::{Header, TimeColumns};

/// What to do where option or card state another rate than the file.
const RATE_HINT: &str = "leave out the rate, or mend the header if it is the one that is wrong";

/// Tells whether the file begins as LabVIEW's do.
#[must_use]
pub fn recognises(head: &Head<'_>) -> bool {
    const MAGIC: &[u8] = b"LabVIEW Measurement";
    let wide = |order: fn(u16) -> [u8; 2]| -> Vec<u8> {
        let mark = order(0xFEFF).into_iter();
        mark.chain(MAGIC.iter().flat_map(|byte| order(u16::from(*byte))))
            .collect()
    };
    let start = head
        .bytes
        .strip_prefix(b"\xEF\xBB\xBF")
        .unwrap_or(head.bytes);
    start.starts_with(MAGIC)
        || start.starts_with(&wide(u16::to_le_bytes))
        || start.starts_with(&wide(u16::to_be_bytes))
}

/// Reads a LabVIEW measurement file.
///
/// # Errors
///
/// - [`ErrorKind::Malformed`] for a header that cannot be read, a second section of data, a cell
///   that is no number, or a cell that is missing among others,
/// - [`ErrorKind::MissingTime`] and [`ErrorKind::MissingUnit`] where nothing says,
/// - [`ErrorKind::NoSuchChannel`], [`ErrorKind::AmbiguousChannel`], [`ErrorKind::NoChannel`],
/// - [`ErrorKind::Empty`] without samples, [`ErrorKind::LimitExceeded`] beyond a limit.
pub fn read(
    source: &mut Reader,
    options: &ReadOptions,
    selections: &[Selection],
    limits: &Limits,
) -> Result<Outcomes, Error> {
    options.refuse_other_clock("a LabVIEW file", "")?;
    let bytes = source.read_text(limits)?;
    let (bytes, mut findings) = encoding::decode(bytes, limits)?;
    text::check_line_lengths(&bytes, limits)?;
    let content = String::from_utf8_lossy(&bytes);
    let (header, first_row) = Header::read(&content, limits)?;
    let (mut table, shares) =
        ChannelTable::read(&content, &header, first_row, (options, selections), limits);
    table.cut = held::cut_line(&content);
    findings.extend(header.findings.iter().cloned());
    findings.extend(header.decimal_finding(table.decimal));
    findings.extend(table.silent_finding(&header));
    let mut remarks = header.remarks.clone();
    remarks.extend(table.words.remarks("Comment", |at_s| (at_s, String::new())));
    let mut left = selections.len();
    let mut outcomes = Vec::with_capacity(left);
    for (selection, share) in selections.iter().zip(shares) {
        left -= 1;
        let choice = (options, *selection);
        let deliver = |()| {
            let outcome = ReadOutcome {
                findings: findings.clone(),
                remarks: remarks.clone(),
                ..ReadOutcome::default()
            };
            deliver(&header, &mut table, outcome, choice, left == 0, limits)
        };
        outcomes.push(share.and_then(deliver));
    }
    Ok(outcomes)
}

/// Makes channels of a table; the `last` time its samples are not copied, for there may be many.
fn deliver(
    header: &Header,
    table: &mut ChannelTable,
    mut outcome: ReadOutcome,
    (options, selection): (&ReadOptions, Selection),
    last: bool,
    limits: &Limits,
) -> Result<ReadOutcome, Error> {
    let (wanted, chosen) = choose(header, table, options, selection)?;
    for index in wanted {
        let name = header.channels[index].column.name.clone();
        let values = if last {
            std::mem::take(&mut table.values[index])
        } else {
            table.values[index].clone()
        };
        match channel(header, table, index, values, (options, selection), limits) {
            Ok(mut channel) => {
                channel.findings.extend(chosen.clone());
                outcome.channels.push(channel);
            }
            Err(error) if selection == Selection::Every => {
                outcome.findings.push(draft::left_out(&name, &error));
            }
            Err(error) => return Err(error.at(Place::default().channel(name))),
        }
    }
    draft::move_instants(&mut outcome.findings, options.time_zero_s.unwrap_or(0.0));
    Ok(outcome)
}

/// The table of a file.
struct ChannelTable {
    /// Samples of each channel; empty where they are not wanted.
    values: Vec<Vec<f64>>,
    /// Number of samples of each channel.
    lengths: Vec<usize>,
    /// Stamps of each time column [s], with the size of their last digit.
    stamps: Vec<(Vec<f64>, f64)>,
    decimal: Decimal,
    /// What the Comment column says, by the instant of each row.
    words: Cells<Option<f64>>,
    /// That the file ends in the middle of a row, if it does.
    cut: Option<Finding>,
    /// Of each channel the place and text of a number that may have a mark between thousands.
    doubts: Vec<Option<(Place, String)>>,
}

/// What the marks in a column may be, and where the first doubtful one stands.
#[derive(Clone, Default)]
struct ChannelMarks {
    marks: Marks,
    first: Option<(u64, usize, String)>,
}

impl ChannelMarks {
    fn look(&mut self, cell: &str, line: u64, column: usize) {
        if self.marks.look(cell.as_bytes()) {
            self.first = Some((line, column, text::shown(cell)));
        }
    }

    /// Judges the marks of each channel by its own numbers and those of its stamps. A mark that
    /// the header declares is the decimal one; another must prove to be.
    fn among(header: &Header, channels: &[Self], stamps: &[Self]) -> Vec<Option<(Place, String)>> {
        let doubtful = |doubt: &Self| {
            let (line, column, cell) = doubt.first.as_ref()?;
            let doubtful = match header.decimal.map(|mark| cell.contains(mark)) {
                Some(true) => false,
                Some(false) => !doubt.marks.decimal,
                None => doubt.marks.may_be_thousands(),
            };
            doubtful.then(|| {
                let place = Place::default().line(*line).column(*column as u64 + 1);
                (place, cell.clone())
            })
        };
        let of = |(index, doubt): (usize, &Self)| {
            let stamps = header.time_slot(index).and_then(|slot| stamps.get(slot));
            match stamps {
                Some(stamps) if stamps.marks.decimal => None,
                Some(stamps) => doubtful(stamps).or_else(|| doubtful(doubt)),
                None => doubtful(doubt),
            }
        };
        channels.iter().enumerate().map(of).collect()
    }
}

/// What one selection takes of the table.
struct SelectionProgress {
    /// Whether each channel is wanted.
    wanted: Vec<bool>,
    /// Cells taken so far.
    cells: u64,
    /// The first thing wrong; nothing is taken after it.
    error: Option<Error>,
}

impl SelectionProgress {
    fn takes(&self, channel: usize) -> bool {
        self.error.is_none() && self.wanted[channel]
    }

    fn fail(&mut self, error: &Error) {
        self.error.get_or_insert_with(|| error.clone());
    }
}

/// A table while its rows are read.
struct TableReader<'a> {
    header: &'a Header,
    limits: &'a Limits,
    table: ChannelTable,
    shares: Vec<SelectionProgress>,
    time_columns: Vec<usize>,
    digits: Vec<PrintedDigits>,
    marks: Vec<ChannelMarks>,
    stamp_marks: Vec<ChannelMarks>,
    /// Rows so far, those without a cell among them, for without stamps each takes its time.
    row: usize,
}

/// Returns the place of a cell.
fn at(line: u64, column: usize) -> Place {
    Place::default().line(line).column(column as u64 + 1)
}

impl ChannelTable {
    /// Reads the rows once for all selections; what is wrong with one selection's channels leaves
    /// the others alone.
    fn read(
        content: &str,
        header: &Header,
        first_row: u64,
        (options, selections): (&ReadOptions, &[Selection]),
        limits: &Limits,
    ) -> (Self, Vec<Result<(), Error>>) {
        let mut reader = TableReader::new(header, options, selections, limits);
        let rows = text::lines(content).filter(|(number, _)| *number >= first_row);
        for (number, line) in rows {
            if let Err(error) = reader.take(number, line) {
                reader
                    .shares
                    .iter_mut()
                    .for_each(|share| share.fail(&error));
            }
            if reader.shares.iter().all(|share| share.error.is_some()) {
                break;
            }
        }
        reader.finish()
    }

    /// Names the channels without a sample.
    fn silent_finding(&self, header: &Header) -> Option<Finding> {
        let channels = header.channels.iter().zip(&self.lengths);
        let silent: Vec<&str> = channels
            .filter(|(_, length)| **length == 0)
            .map(|(channel, _)| channel.column.name.as_str())
            .collect();
        (!silent.is_empty()).then(|| {
            Finding::info(
                "channels-empty",
                format!(
                    "{} channels hold no sample: {}",
                    silent.len(),
                    silent.join(", ")
                ),
            )
        })
    }
}

impl<'a> TableReader<'a> {
    fn new(
        header: &'a Header,
        options: &ReadOptions,
        selections: &[Selection],
        limits: &'a Limits,
    ) -> Self {
        let count = header.channels.len();
        let time_columns = header.time_columns();
        let stamps = time_columns.len();
        let share = |selection: &Selection| SelectionProgress {
            wanted: (0..count)
                .map(|index| match (&options.channel, selection) {
                    (Some(wanted), Selection::Lateral) => {
                        header.channels[index].answers_to(wanted, index)
                    }
                    _ => true,
                })
                .collect(),
            cells: 0,
            error: None,
        };
        Self {
            header,
            limits,
            table: ChannelTable {
                values: vec![Vec::new(); count],
                lengths: vec![0; count],
                stamps: vec![(Vec::new(), 0.0); stamps],
                decimal: Decimal::Unknown,
                words: Cells::new(false),
                cut: None,
                doubts: Vec::new(),
            },
            shares: selections.iter().map(share).collect(),
            digits: time_columns.iter().map(|_| PrintedDigits::new()).collect(),
            marks: vec![ChannelMarks::default(); count],
            stamp_marks: vec![ChannelMarks::default(); stamps],
            time_columns,
            row: 0,
        }
    }

    /// Takes in a line.
    fn take(&mut self, number: u64, line: &str) -> Result<(), Error> {
        if line.trim().is_empty() {
            // An empty line before the table is none of its rows.
            self.row += usize::from(self.row > 0 || !line.is_empty());
            return Ok(());
        }
        let cells: Vec<&str> = line.split(self.header.separator).map(str::trim).collect();
        self.check_shape(number, &cells)?;
        if self.header.time == TimeColumns::No && !cells[0].is_empty() {
            return Err(Error::from(ErrorKind::Malformed {
                expected: "an empty X_Value column, as X_Columns No says".into(),
                found: format!("`{}`", text::shown(cells[0])),
                hint: "whether the column holds the time is not known; read the rows as a table \
                       with the setting `input_format` = csv"
                    .into(),
            })
            .at(at(number, 0)));
        }
        let instant = self.take_stamps(number, &cells)?;
        self.take_samples(number, &cells)?;
        for share in &mut self.shares {
            if share.cells > self.limits.table_cells {
                let error = Error::from(ErrorKind::LimitExceeded {
                    limit: "table_cells",
                    value: self.limits.table_cells,
                    found: "more cells".into(),
                });
                share.fail(&error.at(at(number, 0)));
            }
        }
        self.row += 1;
        let words = cells.get(self.header.comment_column).copied();
        self.table.words.hear(instant, words.unwrap_or_default());
        Ok(())
    }

    /// Refuses a second header, and cells after the Comment column.
    fn check_shape(&self, number: u64, cells: &[&str]) -> Result<(), Error> {
        if Header::begins_again(cells) {
            return Err(Error::from(ErrorKind::Malformed {
                expected: "one section of data".into(),
                found: "a second header".into(),
                hint: "which samples belong together is not known; write each section to a file of its own, or export as CSV".into(),
            })
            .at(at(number, 0)));
        }
        let beyond = self.header.comment_column + 1;
        match cells.iter().skip(beyond).find(|cell| !cell.is_empty()) {
            None => Ok(()),
            Some(cell) => Err(Error::from(ErrorKind::Malformed {
                expected: "nothing after the Comment column".into(),
                found: format!("`{}`", text::shown(cell)),
                hint: "mend the export".into(),
            })
            .at(at(number, beyond))),
        }
    }

    /// Takes in the stamps of a row; returns the first.
    fn take_stamps(&mut self, number: u64, cells: &[&str]) -> Result<Option<f64>, Error> {
        let mut instant = None;
        for (slot, column) in self.time_columns.iter().enumerate() {
            let cell = cells.get(*column).copied().unwrap_or_default();
            if cell.is_empty() {
                continue;
            }
            let stamp = text::sample(cell, &mut self.table.decimal)
                .map_err(|error| error.at(at(number, *column)))?;
            let (stamps, _) = &mut self.table.stamps[slot];
            if let Some(previous) = stamps.last().copied()
                && stamp <= previous
            {
                return Err(Error::from(ErrorKind::TimeNotIncreasing {
                    previous,
                    found: stamp,
                })
                .at(at(number, *column)));
            }
            self.digits[slot].count(cell.as_bytes());
            self.stamp_marks[slot].look(cell, number, *column);
            stamps.push(stamp);
            instant = instant.or(Some(stamp));
        }
        Ok(instant)
    }

    fn take_samples(&mut self, number: u64, cells: &[&str]) -> Result<(), Error> {
        let table = &mut self.table;
        for (index, channel) in self.header.channels.iter().enumerate() {
            let cell = cells.get(channel.index).copied().unwrap_or_default();
            if cell.is_empty() {
                continue;
            }
            // A sample without the stamp of its row, or after a row without one.
            let before = match self.header.time_slot(index) {
                Some(slot) => table.stamps[slot].0.len().checked_sub(1),
                None => Some(self.row),
            };
            if before != Some(table.lengths[index]) {
                return Err(missing_cell(
                    &channel.column.name,
                    at(number, channel.index),
                ));
            }
            table.lengths[index] += 1;
            if table.lengths[index] as u64 > self.limits.samples {
                return Err(text::too_many_samples(self.limits).at(at(number, channel.index)));
            }
            let value = text::sample(cell, &mut table.decimal)
                .map_err(|error| error.at(at(number, channel.index)));
            self.marks[index].look(cell, number, channel.index);
            let mut is_wanted = false;
            for share in self.shares.iter_mut().filter(|share| share.takes(index)) {
                match &value {
                    Ok(_) => share.cells += 1,
                    Err(error) => share.fail(error),
                }
                is_wanted = true;
            }
            if let (true, Ok(value)) = (is_wanted, value) {
                table.values[index].push(value);
            }
        }
        Ok(())
    }

    fn finish(self) -> (ChannelTable, Vec<Result<(), Error>>) {
        let Self {
            mut table,
            mut shares,
            ..
        } = self;
        table.doubts = ChannelMarks::among(self.header, &self.marks, &self.stamp_marks);
        if table.lengths.iter().all(|length| *length == 0) {
            let error = Error::from(ErrorKind::Empty {
                found: "the table holds no sample".into(),
                expected: "rows of numbers after the second header".into(),
            });
            shares.iter_mut().for_each(|share| share.fail(&error));
        }
        for ((_, digit), digits) in table.stamps.iter_mut().zip(&self.digits) {
            *digit = digits.last_digit();
        }
        let outcome = |share: SelectionProgress| share.error.map_or(Ok(()), Err);
        (table, shares.into_iter().map(outcome).collect())
    }
}

impl ChannelTable {
    /// Refuses a channel whose numbers have marks that may separate thousands or decimals.
    fn check_marks(&self, index: usize) -> Result<(), Error> {
        if let Some((place, cell)) = self.doubts.get(index).and_then(Option::as_ref) {
            return Err(Error::from(ErrorKind::Malformed {
                expected: "numbers whose mark is clear".into(),
                found: format!(
                    "`{cell}`, with no number in the column whose mark can only be a decimal one"
                ),
                hint: "the mark may separate thousands or decimals; declare it as Decimal_Separator if it is the decimal one, else export without marks between thousands".into(),
            })
            .at(place.clone()));
        }
        Ok(())
    }
}

fn missing_cell(name: &str, place: Place) -> Error {
    Error::from(ErrorKind::Malformed {
        expected: format!("samples of {name} without a break"),
        found: "one after an empty cell".into(),
        hint: "a missing sample is not taken for zero; export the channels one by one".into(),
    })
    .at(place)
}

/// Chooses the channels to deliver.
fn choose(
    header: &Header,
    table: &ChannelTable,
    options: &ReadOptions,
    selection: Selection,
) -> Result<(Vec<usize>, Option<Finding>), Error> {
    let filled: Vec<usize> = (0..header.channels.len())
        .filter(|index| table.lengths[*index] > 0)
        .collect();
    if selection == Selection::Every {
        return Ok((filled, None));
    }
    let known = header.list();
    if let Some(wanted) = &options.channel {
        let found: Vec<usize> = (0..header.channels.len())
            .filter(|index| header.channels[*index].answers_to(wanted, *index))
            .collect();
        return match found.as_slice() {
            [only] => Ok((
                vec![*only],
                header.channels[*only].column.not_lateral_finding(),
            )),
            [] => Err(ErrorKind::NoSuchChannel {
                wanted: wanted.clone(),
                known,
            }
            .into()),
            several => Err(ErrorKind::AmbiguousChannel {
                candidates: Candidates(
                    several
                        .iter()
                        .map(|index| Candidate::numbered(wanted, "channel", index + 1))
                        .collect(),
                ),
            }
            .into()),
        };
    }
    // Here units stand with every channel, so that forces and temperatures do not compete.
    let possible: Vec<usize> = filled
        .iter()
        .copied()
        .filter(|index| !header.channels[*index].column.has_foreign_unit())
        .collect();
    let columns: Vec<(usize, &Column)> = possible
        .iter()
        .map(|index| (index + 1, &header.channels[*index].column))
        .collect();
    match lateral::choose(&columns, "channel", &known) {
        Ok((index, finding)) => {
            let column = &header.channels[possible[index]].column;
            // The only one of its unit, but not the only one.
            let by_unit =
                (finding.is_none() && filled.len() > 1 && !column.says_lateral_acceleration())
                    .then(|| {
                        Finding::info(
                            "channel-chosen",
                            format!(
                                "`{}` was chosen among {} channels, since no other can be an \
                         acceleration by its unit; its name does not say that it is lateral",
                                column.name,
                                filled.len()
                            ),
                        )
                    });
            Ok((vec![possible[index]], finding.or(by_unit)))
        }
        Err(kind) => Err(kind.into()),
    }
}

fn channel(
    header: &Header,
    table: &ChannelTable,
    index: usize,
    values: Vec<f64>,
    (options, selection): (&ReadOptions, Selection),
    limits: &Limits,
) -> Result<Channel, Error> {
    let described = &header.channels[index];
    let column = &described.column;
    let mut findings = Vec::new();
    if values.is_empty() {
        return Err(ErrorKind::Empty {
            found: format!("channel {} holds no sample", column.name),
            expected: "a channel with samples".into(),
        }
        .into());
    }
    table.check_marks(index)?;
    let own = column.unit.map(|unit| (unit, "header"));
    let text = ("the header", column.unit_text.as_deref());
    let unit = Unit::of_header(own, text, options, selection, &mut findings)?;
    let count = values.len();
    let clock = on_clock(
        (header, table, index),
        values,
        options,
        limits,
        &mut findings,
    )?;
    let end_s = clock.span().end_s;
    let stamped = header.time != TimeColumns::No;
    if let Some(stated) = described.stated("Samples", &described.samples) {
        stated.count(count, stamped, end_s, &mut findings);
    }
    findings.extend(table.cut.clone().map(|cut| cut.at(end_s)));
    let UniformSamples {
        start_s,
        rate,
        values,
    } = clock;
    let stated = column.stated();
    findings.extend(stated.findings(rate));
    findings.extend(column.name_findings());
    let draft = Draft {
        name: column.name.clone(),
        unit,
        start_s,
        rate,
        values,
        stated,
        findings,
        remarks: Vec::new(),
    };
    Ok(draft.finish(options.time_zero_s, &options.accepted_remarks))
}

/// Puts the samples of a channel on its uniform clock: by its column of stamps, else as the header
/// or the rate that was asked for has it.
fn on_clock(
    (header, table, index): (&Header, &ChannelTable, usize),
    values: Vec<f64>,
    options: &ReadOptions,
    limits: &Limits,
    findings: &mut Vec<Finding>,
) -> Result<UniformSamples, Error> {
    let described = &header.channels[index];
    match header.time_slot(index) {
        Some(slot) => {
            let (stamps, digit) = &table.stamps[slot];
            let stamps = stamps.get(..values.len()).unwrap_or(stamps);
            let base = TimeBase::fit(stamps, *digit, limits)?;
            options.check_rate(base.rate.hertz(), "the file's time column", RATE_HINT)?;
            findings.extend(implausible_rate(base.rate, "the time column", options)?);
            findings.extend(base.findings.iter().cloned());
            let stated = described.stated("Delta_X", &described.interval);
            if let Some(stated) = stated
                && stated.number(|interval| interval > 0.0, findings).is_some()
            {
                findings.extend(interval_finding(described.interval(), base.rate));
            }
            Ok(UniformSamples {
                start_s: base.start_s,
                rate: base.rate,
                values: base.apply(stamps, values)?,
            })
        }
        None => {
            let rate = match (described.interval(), options.rate_hz) {
                (Some(rate), _) => {
                    options.check_rate(rate.hertz(), "Delta_X in the header", RATE_HINT)?;
                    findings.extend(implausible_rate(rate, "Delta_X in the header", options)?);
                    rate
                }
                (None, Some(hertz)) => SampleRate::from_hertz(hertz)?,
                (None, None) => return Err(ErrorKind::MissingTime.into()),
            };
            if values.len() < 2 {
                return Err(ErrorKind::TooShort {
                    what: "a recording",
                    needed: 2,
                    found: values.len(),
                }
                .into());
            }
            Ok(UniformSamples {
                start_s: described.start_s,
                rate,
                values,
            })
        }
    }
}

/// Doubts a rate that crash recordings do not have: beyond all belief only the user's word counts.
fn implausible_rate(
    rate: SampleRate,
    told_by: &str,
    options: &ReadOptions,
) -> Result<Option<Finding>, Error> {
    let hertz = rate.hertz();
    if hertz > csv::INCREDIBLE && options.rate_hz.is_none() {
        return Err(ErrorKind::Malformed {
            expected: "a rate that crash recordings have".into(),
            found: format!("{hertz} Hz by {told_by}"),
            hint: "mend the header, or confirm the rate with the setting `rate_hz` if it is right"
                .into(),
        }
        .into());
    }
    let (low, high) = csv::PLAUSIBLE_STATED;
    Ok((!(low..=high).contains(&hertz)).then(|| {
        Finding::warning(
            "time-unit-implausible",
            format!("{told_by} gives {hertz} Hz, which no crash recording has; check its unit"),
        )
    }))
}

/// Says where `Delta_X` is not the interval of the time column.
fn interval_finding(stated: Option<SampleRate>, found: SampleRate) -> Option<Finding> {
    let stated = stated?.hertz();
    let found = found.hertz();
    ((stated - found).abs() > 0.01 * found).then(|| {
        Finding::warning(
            "rate-contradicted",
            format!(
                "Delta_X in the header means {stated} Hz, the time column runs at {found} Hz; \
                 the time column was used"
            ),
        )
    })
}

impl Header {
    fn time_columns(&self) -> Vec<usize> {
        match self.time {
            TimeColumns::No => Vec::new(),
            TimeColumns::One => vec![0],
            TimeColumns::Multi => (0..self.channels.len()).map(|index| 2 * index).collect(),
        }
    }

    fn time_slot(&self, channel: usize) -> Option<usize> {
        match self.time {
            TimeColumns::No => None,
            TimeColumns::One => Some(0),
            TimeColumns::Multi => Some(channel),
        }
    }
}

impl header::Described {
    /// Returns a statement of the header on this channel, if there is one.
    fn stated<'a>(&self, key: &'a str, text: &'a Option<String>) -> Option<Statement<'a>> {
        let text = text.as_deref()?;
        Some(Statement { key, text })
    }

    fn interval(&self) -> Option<SampleRate> {
        let cell = self.interval.as_deref()?;
        let interval = text::header_number(cell)?;
        time_base::rate_of_interval(interval, text::last_digit(cell)).ok()
    }
}
