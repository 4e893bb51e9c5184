//! LabVIEW measurement files (.lvm): text in two headers and a table.
//!
//! The header states much that the table does not show: a number of samples, an interval where a
//! time column runs differently, a decimal mark. The table counts; where the two differ, a finding
//! says so. Words in the Comment column are the operator's, and count as a laboratory's do.
//!
//! # Source
//!
//! NI, "Specification for the LabVIEW Measurement File (.lvm)".
//!
//! - `header`: the two headers of a LabVIEW measurement file.

mod header;

use super::channel_name::{ChannelName, mark_columns};
use super::draft::{self, Draft, UniformSamples, Unit};
use super::held::Statement;
use super::lateral::ChannelOffer;
use super::number::{Decimal, Marks, PrintedDigits};
use super::remarks::Cells;
use super::source::Reader;
use super::text::ColumnMarks;
use super::time_base::{self, MEND};
use super::{
    Channel, Finding, Head, Limits, Outcomes, ReadOutcome, ReadTask, Selection, encoding, held,
    lateral, text,
};
use crate::error::{Error, ErrorKind, Place};
use crate::examine::clock::{Comparison, RateStatement, UsedClock};
use header::{Header, TimeColumns};
use latchgate_kernel::units::{SampleRate, TimeUnit};

/// True if the file begins as LabVIEW's do.
pub fn recognises(head: &Head<'_>) -> bool {
    encoding::head_of(head.bytes).starts_with("LabVIEW Measurement")
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
pub fn read(source: &mut Reader, task: ReadTask) -> Result<Outcomes, Error> {
    task.options.refuse_time_column("a LabVIEW file")?;
    let bytes = source.read_text(task.limits)?;
    let (content, mut findings) = encoding::text_of(bytes, task.limits)?;
    let (mut header, first_row) = Header::read(&content, task.limits)?;
    header.take_time_units(task.options.time_unit)?;
    let columns = header
        .channels
        .iter_mut()
        .map(|channel| &mut channel.column);
    mark_columns(columns.collect(), task.options);
    findings.extend(header.findings.iter().cloned());
    let file = LabviewFile {
        content: &content,
        header: &header,
        first_row,
        findings,
        task,
    };
    Ok(task.each(|selection| file.outcome(selection)))
}

/// A file whose headers are read.
struct LabviewFile<'a> {
    content: &'a str,
    header: &'a Header,
    /// Line on which the table begins, counted from 1.
    first_row: u64,
    findings: Vec<Finding>,
    task: ReadTask<'a>,
}

impl LabviewFile<'_> {
    /// Reads the channels of a selection.
    fn outcome(&self, selection: Selection) -> Result<ReadOutcome, Error> {
        let (header, options) = (self.header, self.task.options);
        let named = match (&options.channel, selection) {
            (Some(requested), Selection::Lateral) => Some(header.named(requested)?),
            _ => None,
        };
        let mut table = ChannelTable::read(self, named)?;
        let mut outcome = ReadOutcome {
            findings: self.findings.clone(),
            remarks: header.remarks.clone(),
            ..ReadOutcome::default()
        };
        let comments = table.words.remarks("Comment", |at_s| (at_s, String::new()));
        outcome.remarks.extend(comments);
        outcome
            .findings
            .extend(header.decimal_finding(table.decimal));
        outcome.findings.extend(table.silent_finding(header));
        let filled = (0..header.channels.len()).filter(|index| !table.channels[*index].is_silent());
        let filled: Vec<usize> = filled.collect();
        let indices = match (selection, named) {
            (Selection::Every, _) => filled,
            (_, Some(index)) => {
                let column = &header.channels[index].column;
                outcome.findings.extend(column.not_lateral_finding());
                vec![index]
            }
            (_, None) => {
                // Any column could be the channel that is meant, so a fault in one must not hide it.
                if let Some(error) = table
                    .channels
                    .iter()
                    .find_map(|numbers| numbers.error.clone())
                {
                    return Err(error);
                }
                let choices = header.offers(filled.iter().copied());
                let (index, finding) = lateral::take(&choices, lateral::listed(&choices))?;
                outcome.findings.extend(finding);
                vec![filled[index]]
            }
        };
        let limit = ("table_cells", self.task.limits.table_cells);
        draft::deliver(selection, indices, outcome, limit, |index, _| {
            let name = || header.channels[index].column.name.clone();
            let channel = self.channel(&mut table, index, selection);
            channel.map(Some).map_err(|error| (name(), error))
        })
    }
}

/// The numbers of one column.
#[derive(Default)]
struct ColumnNumbers {
    values: Vec<f64>,
    /// Number of cells with content, kept or not.
    count: usize,
    marks: ColumnMarks,
    /// The first fault; nothing is read after it.
    error: Option<Error>,
}

impl ColumnNumbers {
    /// True if the column is empty: neither a number nor a fault.
    fn is_silent(&self) -> bool {
        self.count == 0 && self.error.is_none()
    }

    /// Reads a cell with content.
    fn take(&mut self, cell: &str, decimal: &mut Decimal, place: Place) -> Result<(), Error> {
        let number = text::sample(cell, decimal).map_err(|error| error.at(place.clone()))?;
        self.marks.look(cell.as_bytes(), || place);
        self.values.push(number);
        Ok(())
    }

    /// Refuses numbers whose mark may separate thousands or decimals. A mark that the header declares is
    /// the decimal one; any other must prove to be.
    fn check_marks(&self, declared: Option<char>) -> Result<(), Error> {
        let is_clear = |cell: &str, marks: Marks| match declared.map(|mark| cell.contains(mark)) {
            Some(declared) => declared || marks.decimal,
            None => !marks.may_be_thousands(),
        };
        let hint = "the mark may separate thousands or decimals; state the decimal mark as \
                    Decimal_Separator, or export without thousands marks";
        self.marks.check(is_clear, hint)
    }
}

/// The table of a file, during and after the reading of its rows.
struct ChannelTable {
    channels: Vec<ColumnNumbers>,
    /// The columns of stamps, with the digits that they were printed with.
    stamps: Vec<(ColumnNumbers, PrintedDigits)>,
    decimal: Decimal,
    /// Words of the Comment column, by the instant of each row.
    words: Cells<Option<f64>>,
    /// The finding that the file ends in the middle of a row.
    cut: Option<Finding>,
    /// Number of rows so far. One without a cell counts, since without stamps each row takes its time.
    row: usize,
    /// Cells kept.
    cells: u64,
    /// The one channel whose numbers are kept, if not all are.
    only: Option<usize>,
}

/// Returns the place of a cell.
fn cell_place(line: u64, column: usize) -> Place {
    Place::default().line(line).column(column as u64 + 1)
}

impl ChannelTable {
    /// Reads the rows.
    fn read(file: &LabviewFile<'_>, only: Option<usize>) -> Result<Self, Error> {
        let (header, limits) = (file.header, file.task.limits);
        let fresh = |_| (ColumnNumbers::default(), PrintedDigits::new());
        let channels = header.channels.iter();
        let mut table = Self {
            channels: channels.map(|_| ColumnNumbers::default()).collect(),
            stamps: header.time_columns().into_iter().map(fresh).collect(),
            decimal: Decimal::Unknown,
            words: Cells::new(false),
            cut: held::cut_line(file.content),
            row: 0,
            cells: 0,
            only,
        };
        let lines = text::lines(file.content);
        for (number, line) in lines.filter(|(number, _)| *number >= file.first_row) {
            table.take(header, number, line, limits)?;
            if table.cells > limits.table_cells {
                return Err(limits
                    .over("table_cells", "more cells")
                    .at(cell_place(number, 0)));
            }
        }
        if table.channels.iter().all(ColumnNumbers::is_silent) {
            let expected = "rows of numbers after the second header";
            return Err(Error::empty("the table holds no sample", expected));
        }
        Ok(table)
    }

    /// Returns the finding on channels without a sample.
    fn silent_finding(&self, header: &Header) -> Option<Finding> {
        let channels = header.channels.iter().zip(&self.channels);
        let silent = channels.filter(|(_, numbers)| numbers.is_silent());
        let names = silent.map(|(channel, _)| channel.column.name.as_str());
        let names: Vec<&str> = names.collect();
        let (count, list) = (names.len(), names.join(", "));
        let text = format!("{count} channels hold no sample: {list}");
        (count > 0).then(|| Finding::info("channels-empty", text))
    }

    /// Reads a line.
    fn take(
        &mut self,
        header: &Header,
        number: u64,
        line: &str,
        limits: &Limits,
    ) -> Result<(), Error> {
        if line.trim().is_empty() {
            // An empty line before the table is not one of its rows.
            self.row += usize::from(self.row > 0 || !line.is_empty());
            return Ok(());
        }
        let cells: Vec<&str> = line.split(header.separator).map(str::trim).collect();
        check_shape(header, number, &cells)?;
        let cell = |column: usize| cells.get(column).copied().filter(|cell| !cell.is_empty());
        let mut instant = None;
        let columns = header.time_columns().into_iter().zip(&header.channels);
        for ((stamps, digits), (column, channel)) in self.stamps.iter_mut().zip(columns) {
            let Some(cell) = cell(column) else { continue };
            stamps.take(cell, &mut self.decimal, cell_place(number, column))?;
            if let Some(stamp) = stamps.values.last_mut() {
                *stamp = channel.time_unit.to_seconds(*stamp);
            }
            time_base::check_rising(&stamps.values)
                .map_err(|e| e.at(cell_place(number, column)))?;
            stamps.count += 1;
            digits.count(cell.as_bytes());
            instant = instant.or(stamps.values.last().copied());
        }
        for (index, channel) in header.channels.iter().enumerate() {
            let Some(cell) = cell(channel.index) else {
                continue;
            };
            let numbers = &mut self.channels[index];
            let place = cell_place(number, channel.index);
            // A sample without the stamp of its row, or after a row without one.
            let rows_before = match header.time_slot(index) {
                Some(slot) => self.stamps[slot].0.count.checked_sub(1),
                None => Some(self.row),
            };
            let is_next = rows_before == Some(numbers.count);
            numbers.count += 1;
            // Cells after a fault, and those of channels that are not requested, are only counted.
            if numbers.error.is_some() || self.only.is_some_and(|only| only != index) {
                continue;
            }
            if numbers.count as u64 > limits.samples {
                return Err(limits.over("samples", "more samples").at(place));
            }
            let outcome = match is_next {
                true => numbers.take(cell, &mut self.decimal, place),
                false => Err(missing_cell(&channel.column.name, place)),
            };
            self.cells += 1;
            numbers.error = outcome.err();
        }
        self.row += 1;
        let words = cell(header.comment_column).unwrap_or_default();
        self.words.hear(instant, words);
        Ok(())
    }
}

/// Refuses a second header, cells after the Comment column, and a column of times that the header
/// excludes.
fn check_shape(header: &Header, number: u64, cells: &[&str]) -> Result<(), Error> {
    let malformed = |expected: &str, found: String, hint: &str, column: usize| {
        Err(Error::malformed(expected, found, hint).at(cell_place(number, column)))
    };
    let shown = |cell: &str| format!("`{}`", text::shown(cell));
    if Header::begins_again(cells) {
        let hint = "write each section to a separate file, or export as CSV";
        return malformed("one section of data", "a second header".into(), hint, 0);
    }
    if header.time == TimeColumns::No && !cells[0].is_empty() {
        let expected = "an empty X_Value column, as X_Columns No says";
        let hint = "correct the header, or read the rows as a table with the setting \
                    `input_format` = csv";
        return malformed(expected, shown(cells[0]), hint, 0);
    }
    let first_beyond = header.comment_column + 1;
    match cells
        .iter()
        .skip(first_beyond)
        .find(|cell| !cell.is_empty())
    {
        None => Ok(()),
        Some(cell) => {
            let expected = "nothing after the Comment column";
            malformed(expected, shown(cell), "export again", first_beyond)
        }
    }
}

fn missing_cell(name: &str, place: Place) -> Error {
    Error::malformed(
        format!("samples of {name} without a break"),
        "one after an empty cell",
        "export the channels one by one; a missing sample is not zero",
    )
    .at(place)
}

impl LabviewFile<'_> {
    fn channel(
        &self,
        table: &mut ChannelTable,
        index: usize,
        selection: Selection,
    ) -> Result<Channel, Error> {
        let (header, options) = (self.header, self.task.options);
        let channel = &header.channels[index];
        let column = &channel.column;
        let mut findings = Vec::new();
        let numbers = std::mem::take(&mut table.channels[index]);
        if let Some(error) = numbers.error {
            return Err(error);
        }
        if numbers.count == 0 {
            let found = format!("channel {} holds no sample", column.name);
            return Err(Error::empty(found, "a channel with samples"));
        }
        let stamps = header.time_slot(index).map(|slot| &table.stamps[slot].0);
        // A clear decimal mark among the stamps decides for the samples as well.
        if !stamps.is_some_and(|stamps| stamps.marks.marks.decimal) {
            stamps.map_or(Ok(()), |stamps| stamps.check_marks(header.decimal))?;
            numbers.check_marks(header.decimal)?;
        }
        let place = ("header", "the header");
        let unit = Unit::of_words(column, place, options, selection, &mut findings)?;
        let count = numbers.values.len();
        let mut doubts = Vec::new();
        let stated = (&mut findings, &mut doubts);
        let (clock, confirmed) = self.on_clock(table, index, numbers.values, stated)?;
        let end_s = clock.span().end_s;
        if let Some(stated) = channel.stated("Samples", &channel.samples) {
            stated.count(count, header.time != TimeColumns::No, end_s, &mut findings);
        }
        findings.extend(table.cut.clone().map(|cut| cut.at(end_s)));
        let mut draft = Draft::of_words(column, unit, clock, findings);
        draft.stated.test = header.test.clone();
        draft.stated.clock_confirmed_by = confirmed.then(|| "Delta_X".into());
        draft.stated.clock_doubt = doubts.pop();
        draft.finish(options.zero_s(), options)
    }

    /// Puts the samples of a channel on its uniform clock: by its column of stamps, else by the header or
    /// the requested rate; returns with it whether the header confirms the stamps.
    fn on_clock(
        &self,
        table: &ChannelTable,
        index: usize,
        values: Vec<f64>,
        (findings, doubts): (&mut Vec<Finding>, &mut Vec<String>),
    ) -> Result<(UniformSamples, bool), Error> {
        let (header, options) = (self.header, self.task.options);
        let channel = &header.channels[index];
        let check = |rate: SampleRate, by| options.check_rate(rate.hertz(), (by, false), MEND);
        if let Some(slot) = header.time_slot(index) {
            let (numbers, digits) = &table.stamps[slot];
            let stamps = &numbers.values[..values.len().min(numbers.values.len())];
            let digit = channel.time_unit.to_seconds(digits.last_digit());
            let mut stamp_findings = Vec::new();
            let limits = self.task.limits;
            let mut clock =
                UniformSamples::by_stamps(stamps, digit, values, limits, &mut stamp_findings)?;
            if channel.counts_samples(clock.rate) {
                let (rate, finding) = options.untimed(clock.rate, "Delta_X in the header")?;
                clock.start_s *= clock.rate.hertz() / rate.hertz();
                clock.rate = rate;
                findings.push(finding);
                return Ok((clock, false));
            }
            findings.extend(check(clock.rate, "the file's time column")?);
            findings.append(&mut stamp_findings);
            let stated = channel.stated("Delta_X", &channel.interval);
            let number =
                stated.and_then(|stated| stated.number(|interval| interval > 0.0, findings));
            let comparison =
                number.and_then(|_| channel.interval_comparison(clock.rate, options.rate_hz));
            let confirmed = comparison.is_some_and(|comparison| comparison.tell(findings, doubts));
            return Ok((clock, confirmed));
        }
        let rate = match (channel.interval(), options.rate_hz) {
            (Some(rate), _) if channel.counts_samples(rate) => {
                let (rate, finding) = options.untimed(rate, "Delta_X in the header")?;
                findings.push(finding);
                rate
            }
            (Some(rate), _) => {
                findings.extend(check(rate, "Delta_X in the header")?);
                rate
            }
            (None, Some(hertz)) => SampleRate::from_hertz(hertz)?,
            (None, None) => return Err(ErrorKind::MissingTime.into()),
        };
        let start_s = match channel.counts_samples(channel.interval().unwrap_or(rate)) {
            true => channel.start / rate.hertz(),
            false => channel.time_unit.to_seconds(channel.start),
        };
        Ok((UniformSamples::stated(start_s, rate, values)?, false))
    }
}

impl Header {
    /// Returns channels to choose from.
    fn offers(&self, indices: impl IntoIterator<Item = usize>) -> Vec<ChannelOffer> {
        let column = |index: usize| (index + 1, &self.channels[index].column);
        let columns: Vec<(usize, &ChannelName)> = indices.into_iter().map(column).collect();
        ChannelOffer::of_words(&columns, "channel")
    }

    /// Returns the one channel of a name or number.
    fn named(&self, requested: &str) -> Result<usize, Error> {
        let indices = 0..self.channels.len();
        let fits = |index: &usize| self.channels[*index].answers_to(requested, *index);
        let matches: Vec<usize> = indices.clone().filter(fits).collect();
        lateral::named(requested, &matches, &self.offers(indices))
    }

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

impl header::ChannelDescription {
    /// Returns a statement of the header on this channel, if there is one.
    fn stated<'a>(&self, key: &'a str, text: &'a Option<String>) -> Option<Statement<'a>> {
        let text = text.as_deref()?;
        Some(Statement { key, text })
    }

    /// Compares `Delta_X` with the interval of the time column.
    fn interval_comparison(
        &self,
        measured: SampleRate,
        stated_hz: Option<f64>,
    ) -> Option<Comparison> {
        let rate = self.interval()?.hertz();
        if (rate - 1.0).abs() < 1e-9 {
            let text = format!(
                "Delta_X in the header is 1, as LabVIEW writes it where it knows no interval. The time column runs \
                 at {} Hz and is used",
                measured.hertz()
            );
            return Some(Comparison::Found(Finding::warning("time-differs", text)));
        }
        let statement = RateStatement::of(vec![rate], self.interval.as_deref()?);
        let used = UsedClock {
            name: "the time column",
            hertz: measured.hertz(),
            stated_hz,
        };
        Some(used.compare(
            &format!("Delta_X in the header means {rate} Hz"),
            &statement,
        ))
    }

    fn interval(&self) -> Option<SampleRate> {
        let cell = self.interval.as_deref()?;
        let interval = text::header_number(cell)?;
        let digit = self.time_unit.to_seconds(text::last_digit(cell));
        time_base::rate_of_interval(self.time_unit.to_seconds(interval), digit).ok()
    }

    /// True if header and table, at that rate, only count the samples: by ones without a unit, or in
    /// seconds, at which no crash is sampled.
    fn counts_samples(&self, rate: SampleRate) -> bool {
        let is_one = |number: f64| (number - 1.0).abs() < 1e-9;
        let stated = self.interval.as_deref().and_then(text::header_number);
        self.time_unit == TimeUnit::SECOND && stated.is_some_and(is_one) && is_one(rate.hertz())
    }
}
