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
    let mut table =
        ChannelTable::read(&content, &header, first_row, (options, selections), limits)?;
    findings.extend(header.findings.iter().cloned());
    findings.extend(header.decimal_finding(table.decimal));
    findings.extend(table.silent_finding(&header));
    let mut remarks = header.remarks.clone();
    remarks.extend(table.words.remarks("Comment", |at_s| (at_s, String::new())));
    let choices = selections.iter().map(|selection| {
        if let Some(error) = table.over.clone()
            && (*selection == Selection::Every || options.channel.is_none())
        {
            return Err(error);
        }
        // Where nobody has said which channel is meant, the whole table has to be in order.
        let unnamed = *selection == Selection::Lateral && options.channel.is_none();
        let mut channels = table.channels.iter().filter(|_| unnamed);
        if let Some(error) = channels.find_map(|numbers| numbers.error.clone()) {
            return Err(error);
        }
        let (wanted, chosen) = choose(&header, &table, options, *selection)?;
        let outcome = ReadOutcome {
            findings: findings.iter().cloned().chain(chosen).collect(),
            remarks: remarks.clone(),
            ..ReadOutcome::default()
        };
        Ok((*selection, wanted, outcome))
    });
    let choices = choices.collect();
    let most = ("table_cells", limits.table_cells);
    Ok(draft::deliver(choices, most, |index, selection, _| {
        let name = || header.channels[index].column.name.clone();
        channel(&header, &mut table, index, (options, selection), limits)
            .map(Some)
            .map_err(|error| (name(), error))
    }))
}

/// The numbers of one column.
#[derive(Default)]
struct ColumnNumbers {
    /// The numbers, where they are kept.
    values: Vec<f64>,
    /// How many there are, kept or not.
    count: usize,
    marks: Marks,
    /// The first number that may have a mark between thousands, and where it stands.
    doubtful: Option<(Place, String)>,
    /// The first thing wrong; nothing is taken after it.
    error: Option<Error>,
}

impl ColumnNumbers {
    /// Tells whether the column holds nothing, not even something wrong.
    fn is_silent(&self) -> bool {
        self.count == 0 && self.error.is_none()
    }

    /// Takes in a cell that holds something.
    fn take(&mut self, cell: &str, decimal: &mut Decimal, place: Place) -> Result<f64, Error> {
        let number = text::sample(cell, decimal).map_err(|error| error.at(place.clone()))?;
        if self.marks.look(cell.as_bytes()) {
            self.doubtful = Some((place, text::shown(cell)));
        }
        self.count += 1;
        Ok(number)
    }

    /// Refuses numbers whose mark may separate thousands or decimals. One that the header declares
    /// is the decimal one; another must prove to be.
    fn check_marks(&self, declared: Option<char>) -> Result<(), Error> {
        let Some((place, cell)) = &self.doubtful else {
            return Ok(());
        };
        let is_clear = match declared.map(|mark| cell.contains(mark)) {
            Some(true) => true,
            Some(false) => self.marks.decimal,
            None => !self.marks.may_be_thousands(),
        };
        if is_clear {
            return Ok(());
        }
        Err(Error::from(ErrorKind::Malformed {
            expected: "numbers whose mark is clear".into(),
            found: format!(
                "`{cell}`, with no number in the column whose mark can only be a decimal one"
            ),
            hint: "the mark may separate thousands or decimals; declare it as Decimal_Separator \
                   if it is the decimal one, else export without marks between thousands"
                .into(),
        })
        .at(place.clone()))
    }
}

/// The table of a file, while its rows are read and after.
struct ChannelTable {
    channels: Vec<ColumnNumbers>,
    /// The columns of stamps, with the digits that they were printed with.
    stamps: Vec<(ColumnNumbers, PrintedDigits)>,
    decimal: Decimal,
    /// What the Comment column says, by the instant of each row.
    words: Cells<Option<f64>>,
    /// That the file ends in the middle of a row, if it does.
    cut: Option<Finding>,
    /// Rows so far, those without a cell among them, for without stamps each takes its time.
    row: usize,
    /// Cells kept.
    cells: u64,
    /// Which channels are kept, and why that is no longer all of them.
    keeps: Vec<bool>,
    over: Option<Error>,
}

/// Returns the place of a cell.
fn at(line: u64, column: usize) -> Place {
    Place::default().line(line).column(column as u64 + 1)
}

impl ChannelTable {
    /// Reads the rows, once for all selections. Where all channels are too many, the one that is
    /// named is read on.
    fn read(
        content: &str,
        header: &Header,
        first_row: u64,
        (options, selections): (&ReadOptions, &[Selection]),
        limits: &Limits,
    ) -> Result<Self, Error> {
        let is_named = |index: usize| match &options.channel {
            Some(wanted) => header.channels[index].answers_to(wanted, index),
            None => true,
        };
        let named: Vec<bool> = (0..header.channels.len()).map(is_named).collect();
        let all = selections.contains(&Selection::Every);
        let fresh = |_| (ColumnNumbers::default(), PrintedDigits::new());
        let mut table = Self {
            channels: named.iter().map(|_| ColumnNumbers::default()).collect(),
            stamps: header.time_columns().into_iter().map(fresh).collect(),
            decimal: Decimal::Unknown,
            words: Cells::new(false),
            cut: held::cut_line(content),
            row: 0,
            cells: 0,
            keeps: named.iter().map(|named| all || *named).collect(),
            over: None,
        };
        for (number, line) in text::lines(content).filter(|(number, _)| *number >= first_row) {
            table.take(header, number, line, limits)?;
            if table.cells > limits.table_cells {
                let error = Error::from(ErrorKind::LimitExceeded {
                    limit: "table_cells",
                    value: limits.table_cells,
                    found: "more cells".into(),
                })
                .at(at(number, 0));
                if table.over.is_some() || !selections.contains(&Selection::Lateral) {
                    return Err(error);
                }
                table.keep_only(&named);
                table.over = Some(error);
            }
        }
        if table.channels.iter().all(ColumnNumbers::is_silent) {
            return Err(ErrorKind::Empty {
                found: "the table holds no sample".into(),
                expected: "rows of numbers after the second header".into(),
            }
            .into());
        }
        Ok(table)
    }

    /// Forgets the samples of all channels but the named ones.
    fn keep_only(&mut self, named: &[bool]) {
        for (channel, _) in self
            .channels
            .iter_mut()
            .zip(named)
            .filter(|(_, named)| !**named)
        {
            channel.values = Vec::new();
        }
        self.keeps = named.to_vec();
        let kept = self
            .channels
            .iter()
            .map(|channel| channel.values.len() as u64);
        self.cells = kept.sum();
    }

    /// Names the channels without a sample.
    fn silent_finding(&self, header: &Header) -> Option<Finding> {
        let channels = header.channels.iter().zip(&self.channels);
        let silent = channels.filter(|(_, numbers)| numbers.is_silent());
        let names: Vec<&str> = silent
            .map(|(channel, _)| channel.column.name.as_str())
            .collect();
        let text = format!(
            "{} channels hold no sample: {}",
            names.len(),
            names.join(", ")
        );
        (!names.is_empty()).then(|| Finding::info("channels-empty", text))
    }

    /// Takes in a line.
    fn take(
        &mut self,
        header: &Header,
        number: u64,
        line: &str,
        limits: &Limits,
    ) -> Result<(), Error> {
        if line.trim().is_empty() {
            // An empty line before the table is none of its rows.
            self.row += usize::from(self.row > 0 || !line.is_empty());
            return Ok(());
        }
        let cells: Vec<&str> = line.split(header.separator).map(str::trim).collect();
        check_shape(header, number, &cells)?;
        let cell = |column: usize| cells.get(column).copied().filter(|cell| !cell.is_empty());
        let mut instant = None;
        for ((stamps, digits), column) in self.stamps.iter_mut().zip(header.time_columns()) {
            let Some(cell) = cell(column) else { continue };
            let stamp = stamps.take(cell, &mut self.decimal, at(number, column))?;
            if let Some(previous) = stamps.values.last().copied()
                && stamp <= previous
            {
                let found = stamp;
                return Err(
                    Error::from(ErrorKind::TimeNotIncreasing { previous, found })
                        .at(at(number, column)),
                );
            }
            digits.count(cell.as_bytes());
            stamps.values.push(stamp);
            instant = instant.or(Some(stamp));
        }
        for (index, described) in header.channels.iter().enumerate() {
            let Some(cell) = cell(described.index) else {
                continue;
            };
            let numbers = &mut self.channels[index];
            let place = at(number, described.index);
            // A sample without the stamp of its row, or after a row without one.
            let before = match header.time_slot(index) {
                Some(slot) => self.stamps[slot].0.count.checked_sub(1),
                None => Some(self.row),
            };
            if numbers.error.is_some() {
                continue;
            }
            if numbers.count as u64 >= limits.samples {
                return Err(text::too_many_samples(limits).at(place));
            }
            let taken = match before == Some(numbers.count) {
                true => numbers.take(cell, &mut self.decimal, place),
                false => Err(missing_cell(&described.column.name, place)),
            };
            match taken {
                Ok(value) if self.keeps[index] => {
                    numbers.values.push(value);
                    self.cells += 1;
                }
                Ok(_) => {}
                Err(error) => numbers.error = Some(error),
            }
        }
        self.row += 1;
        let words = cell(header.comment_column).unwrap_or_default();
        self.words.hear(instant, words);
        Ok(())
    }
}

/// Refuses a second header, cells after the Comment column, and a column of times that there
/// should not be.
fn check_shape(header: &Header, number: u64, cells: &[&str]) -> Result<(), Error> {
    let malformed = |expected: &str, found: String, hint: &str, column: usize| {
        let (expected, hint) = (expected.into(), hint.into());
        let kind = ErrorKind::Malformed {
            expected,
            found,
            hint,
        };
        Err(Error::from(kind).at(at(number, column)))
    };
    let shown = |cell: &str| format!("`{}`", text::shown(cell));
    if Header::begins_again(cells) {
        let hint = "which samples belong together is not known; write each section to a file of \
                    its own, or export as CSV";
        return malformed("one section of data", "a second header".into(), hint, 0);
    }
    if header.time == TimeColumns::No && !cells[0].is_empty() {
        let expected = "an empty X_Value column, as X_Columns No says";
        let hint = "whether the column holds the time is not known; read the rows as a table with \
                    the setting `input_format` = csv";
        return malformed(expected, shown(cells[0]), hint, 0);
    }
    let beyond = header.comment_column + 1;
    match cells.iter().skip(beyond).find(|cell| !cell.is_empty()) {
        None => Ok(()),
        Some(cell) => {
            let expected = "nothing after the Comment column";
            malformed(expected, shown(cell), "mend the export", beyond)
        }
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
        .filter(|index| !table.channels[*index].is_silent())
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
    let columns: Vec<(usize, &Column)> = filled
        .iter()
        .map(|index| (index + 1, &header.channels[*index].column))
        .collect();
    let (index, finding) = lateral::choose(&columns, "channel", &known)?;
    // Here units stand with every channel, so that forces and temperatures do not compete.
    let rivals = columns
        .iter()
        .filter(|(_, column)| !column.has_foreign_unit());
    let several = rivals.count() > 1;
    Ok((vec![filled[index]], finding.filter(|_| several)))
}

fn channel(
    header: &Header,
    table: &mut ChannelTable,
    index: usize,
    (options, selection): (&ReadOptions, Selection),
    limits: &Limits,
) -> Result<Channel, Error> {
    let described = &header.channels[index];
    let column = &described.column;
    let mut findings = Vec::new();
    let numbers = &mut table.channels[index];
    if let Some(error) = &numbers.error {
        return Err(error.clone());
    }
    if numbers.count == 0 {
        return Err(ErrorKind::Empty {
            found: format!("channel {} holds no sample", column.name),
            expected: "a channel with samples".into(),
        }
        .into());
    }
    let slot = header.time_slot(index);
    let stamps = slot.map(|slot| &table.stamps[slot].0);
    // A mark among the stamps that can only be a decimal one tells for the samples, too.
    if !stamps.is_some_and(|stamps| stamps.marks.decimal) {
        stamps.map_or(Ok(()), |stamps| stamps.check_marks(header.decimal))?;
        numbers.check_marks(header.decimal)?;
    }
    // The chosen channel comes first, and is one of all.
    let values = match selection {
        Selection::Lateral => numbers.values.clone(),
        Selection::Every => std::mem::take(&mut numbers.values),
    };
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
            let (numbers, digits) = &table.stamps[slot];
            let stamps = &numbers.values;
            let stamps = stamps.get(..values.len()).unwrap_or(stamps);
            let base = TimeBase::fit(stamps, digits.last_digit(), limits)?;
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
