//! Workbooks of Excel 97 to 2003 (.xls): records in a stream of an OLE2 container.
//!
//! # Source
//!
//! Microsoft, [MS-XLS], 2.4 (records) and 2.5 (structures).

use super::builder::{Epoch, SheetBuilder, Value};
use super::number_format::NumberFormat;
use super::strings::Strings;
use super::{SheetEntry, SheetPass, check_places, computed_when_asked, damaged};
use crate::csv::{Merged, Sheet};
use crate::error::{Error, ErrorKind, Place};
use crate::{Finding, Limits};
use std::cell::Cell;
use std::collections::BTreeMap;
use std::io::{Cursor, Read};

/// What an OLE2 container begins with.
pub(super) const MAGIC: &[u8] = b"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1";

/// Number of the version that Excel 97 to 2003 write.
const VERSION: u16 = 0x0600;

// Kinds of records.
const BOF: u16 = 0x0809;
const EOF: u16 = 0x000A;
const FORMULA: u16 = 0x0006;
const CONTINUE: u16 = 0x003C;

/// A workbook whose sheets are listed and not read yet.
pub(super) struct Workbook {
    stream: Vec<u8>,
    pub(super) sheets: Vec<SheetEntry<usize>>,
    epoch: Epoch,
    formats: Vec<NumberFormat>,
    strings: Strings,
    /// Bytes of sheets that were looked into.
    probed: Cell<usize>,
}

impl Workbook {
    /// Reads all but the sheets.
    pub(super) fn open(bytes: &[u8]) -> Result<Self, Error> {
        let mut workbook = Self {
            stream: stream_of(bytes)?,
            sheets: Vec::new(),
            epoch: Epoch::Of1900,
            formats: Vec::new(),
            strings: Strings::default(),
            probed: Cell::new(0),
        };
        let (mut codes, mut formats) = (BTreeMap::new(), Vec::new());
        let mut shared: Vec<&[u8]> = Vec::new();
        let mut before = BOF;
        let mut records = Records::new(&workbook.stream, 0);
        records.begin()?;
        loop {
            let record = records.next()?;
            match record.kind {
                EOF => break,
                0x002F => {
                    return Err(refused(
                        "a workbook under a password",
                        "save it without one",
                    ));
                }
                0x0022 if record.u16(0)? == 1 => workbook.epoch = Epoch::Of1904,
                0x041E => {
                    let code = record.text(4, usize::from(record.u16(2)?))?;
                    codes.insert(record.u16(0)?, NumberFormat::of_code(&code));
                }
                0x00E0 => formats.push(record.u16(2)?),
                0x0085 => {
                    let (offset, state) = (record.u32(0)?, record.u16(4)?);
                    let name = record.text(7, usize::from(record.bytes(6, 1)?[0]))?;
                    // Sheets of charts, macros and Visual Basic hold no table.
                    if state >> 8 == 0 {
                        workbook.sheets.push(SheetEntry {
                            name,
                            is_hidden: state & 3 != 0,
                            place: offset as usize,
                        });
                    }
                }
                0x00FC => shared.push(record.data),
                CONTINUE if before == 0x00FC => shared.push(record.data),
                _ => {}
            }
            // What goes on goes on in the next record, too.
            if record.kind != CONTINUE {
                before = record.kind;
            }
        }
        let format = |number: &u16| {
            let built_in = || NumberFormat::built_in(u32::from(*number));
            codes.get(number).cloned().unwrap_or_else(built_in)
        };
        workbook.formats = formats.iter().map(format).collect();
        workbook.strings = strings(&shared)?;
        check_places(&workbook.sheets)?;
        Ok(workbook)
    }

    /// Reads a sheet as far as the pass needs it.
    pub(super) fn read(
        &self,
        sheet: &SheetEntry<usize>,
        pass: SheetPass,
        limits: &Limits,
    ) -> Result<Sheet, Error> {
        let mut builder = SheetBuilder::new(self.epoch, pass, limits);
        let mut records = Records::new(&self.stream, sheet.place);
        records.begin()?;
        // Charts within a sheet have records of their own.
        let (mut depth, mut has_notes) = (0_usize, false);
        let (mut is_computed, mut is_manual) = (true, false);
        let mut awaited: Option<(u32, u32, NumberFormat)> = None;
        loop {
            let record = records.next()?;
            if pass == SheetPass::Probe {
                // Sheets lie one behind the other, so that all of them are no longer than the file.
                let probed = self.probed.get() + records.at - record.start;
                self.probed.set(probed);
                if probed > self.stream.len() {
                    return Err(record.damaged("a sheet within another"));
                }
            }
            match record.kind {
                BOF => depth += 1,
                EOF if depth == 0 => break,
                EOF => depth -= 1,
                _ if depth > 0 => continue,
                _ => {}
            }
            let format = |at: usize| -> Result<NumberFormat, Error> {
                let format = self.formats.get(usize::from(record.u16(at)?));
                Ok(format.cloned().unwrap_or_default())
            };
            let cell = || -> Result<(u32, u32), Error> {
                Ok((u32::from(record.u16(0)?), u32::from(record.u16(2)?)))
            };
            let is_cell = matches!(
                record.kind,
                0x0203 | 0x027E | 0x00BD | 0x00FD | 0x0204 | 0x00D6 | 0x0205 | FORMULA
            );
            if is_cell && let Some((row, column, format)) = awaited.take() {
                builder.put(row, column, Value::NotComputed, format)?;
            }
            match record.kind {
                // NUMBER
                0x0203 => {
                    let (row, column) = cell()?;
                    builder.put(row, column, Value::Number(record.f64(6)?), format(4)?)?;
                }
                // RK and MULRK
                0x027E => {
                    let (row, column) = cell()?;
                    let number = of_rk(record.u32(6)?);
                    builder.put(row, column, Value::Number(number), format(4)?)?;
                }
                0x00BD => {
                    let (row, first) = cell()?;
                    let count = record.data.len().saturating_sub(6) / 6;
                    for index in 0..count {
                        let offset = 4 + 6 * index;
                        let number = of_rk(record.u32(offset + 2)?);
                        let column = first + index as u32;
                        builder.put(row, column, Value::Number(number), format(offset)?)?;
                    }
                    let last = record.u16(4 + 6 * count)?;
                    if u32::from(last) + 1 != first + count as u32 {
                        return Err(record.damaged("a row of numbers of another length"));
                    }
                }
                // LABELSST
                0x00FD => {
                    let (row, column) = cell()?;
                    let shared = self.strings.get(record.u32(6)? as usize);
                    let shared =
                        shared.ok_or_else(|| record.damaged("a text that is not there"))?;
                    builder.put(row, column, Value::Text(shared), NumberFormat::Plain)?;
                }
                // LABEL and RSTRING
                0x0204 | 0x00D6 => {
                    let (row, column) = cell()?;
                    let text = record.text(8, usize::from(record.u16(6)?))?;
                    builder.put(row, column, Value::Text(&text), NumberFormat::Plain)?;
                }
                // BOOLERR
                0x0205 => {
                    let (row, column) = cell()?;
                    let value = bool_or_fault(record.bytes(6, 2)?)?;
                    builder.put(row, column, value, NumberFormat::Plain)?;
                }
                FORMULA => {
                    let (row, column) = cell()?;
                    let result = record.bytes(6, 8)?;
                    // The second bit asks for a result when the workbook is opened.
                    let is_stored = is_computed && record.u16(14)? & 2 == 0;
                    builder.has_formulas = true;
                    let value = match result {
                        _ if !is_stored => Value::NotComputed,
                        [0, .., 0xFF, 0xFF] => {
                            awaited = Some((row, column, format(4)?));
                            continue;
                        }
                        [1, _, is_true, .., 0xFF, 0xFF] => Value::Bool(*is_true != 0),
                        [2, _, fault, .., 0xFF, 0xFF] => Value::Fault(fault_name(*fault)),
                        // An empty text, or, of some programs, nothing yet.
                        [.., 0xFF, 0xFF] => Value::NotComputed,
                        _ => Value::Number(record.f64(6)?),
                    };
                    builder.put(row, column, value, format(4)?)?;
                }
                // UNCALCED: the sheet was not computed before it was saved.
                0x005E if builder.has_formulas => {
                    return Err(record.damaged("formulas before what says that none is computed"));
                }
                0x005E => is_computed = false,
                // CALCMODE
                0x000D => is_manual = record.u16(0)? == 0,
                // STRING, the result of the formula before
                0x0207 => {
                    if let Some((row, column, format)) = awaited.take() {
                        let text = record.text(2, usize::from(record.u16(0)?))?;
                        builder.put(row, column, Value::Text(&text), format)?;
                    }
                }
                // ROW
                0x0208 if record.u16(12)? & 0x20 != 0 || record.u16(6)? & 0x7FFF == 0 => {
                    let line = u64::from(record.u16(0)?) + 1;
                    match builder.hidden_rows.last_mut().filter(|one| one.end == line) {
                        Some(before) => before.end += 1,
                        None => builder.hidden_rows.push(line..line + 1),
                    }
                }
                // DEFAULTROWHEIGHT and DEFCOLWIDTH
                0x0225 if record.u16(0)? & 2 != 0 => builder.hide_all_rows(),
                0x0055 if record.u16(0)? == 0 => builder.hide_all_columns(),
                // COLINFO
                0x007D if record.u16(8)? & 1 != 0 || record.u16(4)? == 0 => {
                    let columns = usize::from(record.u16(0)?)..usize::from(record.u16(2)?) + 1;
                    if columns.is_empty() {
                        return Err(record.damaged("columns from the last to the first"));
                    }
                    builder.marks.hidden_columns.push(columns);
                }
                // MERGEDCELLS
                0x00E5 => {
                    for index in 0..usize::from(record.u16(0)?) {
                        let bound = |place: usize| record.u16(2 + 8 * index + 2 * place);
                        let merged = Merged {
                            lines: u64::from(bound(0)?) + 1..u64::from(bound(1)?) + 2,
                            columns: usize::from(bound(2)?)..usize::from(bound(3)?) + 1,
                        };
                        if merged.lines.is_empty() || merged.columns.is_empty() {
                            return Err(record.damaged("cells from the last to the first"));
                        }
                        builder.marks.merged.push(merged);
                    }
                }
                // HEADER and FOOTER
                0x0014 | 0x0015 if !record.data.is_empty() => {
                    let words = record.text(2, usize::from(record.u16(0)?))?;
                    builder.put_page_words(&words);
                }
                // NOTE
                0x001C => has_notes = true,
                _ => {}
            }
            if builder.is_probed() {
                break;
            }
        }
        if let Some((row, column, format)) = awaited {
            builder.put(row, column, Value::NotComputed, format)?;
        }
        let is_stale = is_manual && builder.has_formulas;
        let mut read = builder.finish(&sheet.name)?;
        read.findings.extend(is_stale.then(computed_when_asked));
        if has_notes {
            let text = "the sheet has notes on cells, which are not read of an .xls file. Read them, \
                        or save the workbook as .xlsx";
            read.findings.push(Finding::warning("notes-not-read", text));
        }
        Ok(read)
    }
}

fn refused(format: &'static str, way_out: &'static str) -> Error {
    ErrorKind::RefusedFormat { format, way_out }.into()
}

/// Returns the stream of the workbook in a container.
fn stream_of(bytes: &[u8]) -> Result<Vec<u8>, Error> {
    let container = cfb::CompoundFile::open(Cursor::new(bytes));
    let mut container = container.map_err(|_| {
        let format = "legacy Excel (.xls) in a container that does not open";
        refused(
            format,
            "save the sheet as .xlsx or CSV, or fetch the file again",
        )
    })?;
    if !container.is_stream("/Workbook") {
        let has = |name: &str| container.is_stream(name);
        return Err(if has("/EncryptedPackage") {
            refused("a workbook under a password", "save it without one")
        } else if has("/Book") {
            refused(
                "a workbook of Excel 5.0 or 95",
                "save it as .xlsx, or the sheet as CSV",
            )
        } else {
            refused(
                "an OLE2 file that holds no workbook",
                "export the channel as CSV, with names of channels and units",
            )
        });
    }
    let mut stream = Vec::new();
    let opened = container.open_stream("/Workbook");
    opened
        .and_then(|mut opened| opened.read_to_end(&mut stream))
        .map_err(|error| damaged(error.to_string()))?;
    Ok(stream)
}

/// Returns the number that four bytes stand for: the first bits of a double, or a whole number, or a
/// hundredth of either.
fn of_rk(bits: u32) -> f64 {
    let number = match bits & 2 {
        0 => f64::from_bits(u64::from(bits & !3) << 32),
        _ => f64::from(bits.cast_signed() >> 2),
    };
    if bits & 1 == 0 {
        number
    } else {
        number / 100.0
    }
}

fn bool_or_fault(bytes: &[u8]) -> Result<Value<'static>, Error> {
    match bytes {
        [value, 0] => Ok(Value::Bool(*value != 0)),
        [fault, 1] => Ok(Value::Fault(fault_name(*fault))),
        _ => Err(damaged("a cell that is neither true, false nor a fault")),
    }
}

fn fault_name(fault: u8) -> &'static str {
    match fault {
        0x00 => "#NULL!",
        0x07 => "#DIV/0!",
        0x0F => "#VALUE!",
        0x17 => "#REF!",
        0x1D => "#NAME?",
        0x24 => "#NUM!",
        0x2A => "#N/A",
        _ => "without a name",
    }
}

/// A record.
#[derive(Debug, Clone, Copy)]
struct Record<'a> {
    kind: u16,
    data: &'a [u8],
    /// Where it begins in the stream.
    start: usize,
}

impl<'a> Record<'a> {
    fn damaged(&self, found: &str) -> Error {
        let place = Place::default().byte(self.start as u64);
        damaged(format!("{found} in a record of kind {:#06x}", self.kind)).at(place)
    }

    fn bytes(&self, at: usize, count: usize) -> Result<&'a [u8], Error> {
        let bytes = self.data.get(at..at + count);
        bytes.ok_or_else(|| self.damaged("too few bytes"))
    }

    fn u16(&self, at: usize) -> Result<u16, Error> {
        let bytes = self.bytes(at, 2)?;
        Ok(u16::from_le_bytes([bytes[0], bytes[1]]))
    }

    fn u32(&self, at: usize) -> Result<u32, Error> {
        Ok(u32::from(self.u16(at)?) | u32::from(self.u16(at + 2)?) << 16)
    }

    fn f64(&self, at: usize) -> Result<f64, Error> {
        let bits = u64::from(self.u32(at)?) | u64::from(self.u32(at + 4)?) << 32;
        Ok(f64::from_bits(bits))
    }

    /// Reads a text of so many characters, the flag of their width first.
    fn text(&self, at: usize, count: usize) -> Result<String, Error> {
        let is_wide = self.bytes(at, 1)?[0] & 1 != 0;
        let width = if is_wide { 2 } else { 1 };
        let mut text = String::new();
        push_characters(self.bytes(at + 1, count * width)?, is_wide, &mut text);
        Ok(text)
    }
}

/// Adds characters, of two bytes each if they are wide; narrow ones are the first 256 of Unicode.
fn push_characters(bytes: &[u8], is_wide: bool, text: &mut String) {
    if is_wide {
        let units = bytes
            .chunks_exact(2)
            .map(|pair| u16::from_le_bytes([pair[0], pair[1]]));
        let letters = char::decode_utf16(units);
        text.extend(letters.map(|letter| letter.unwrap_or(char::REPLACEMENT_CHARACTER)));
    } else {
        text.extend(bytes.iter().map(|byte| char::from(*byte)));
    }
}

/// The records of a stream, one after the other.
struct Records<'a> {
    stream: &'a [u8],
    at: usize,
}

impl<'a> Records<'a> {
    fn new(stream: &'a [u8], at: usize) -> Self {
        Self { stream, at }
    }

    /// Reads the record that begins the workbook or a sheet.
    fn begin(&mut self) -> Result<(), Error> {
        let first = self.next()?;
        match (first.kind, first.u16(0)) {
            (BOF, Ok(VERSION)) => Ok(()),
            (BOF, Ok(_)) => Err(refused(
                "a workbook of Excel 5.0 or 95",
                "save it as .xlsx, or the sheet as CSV",
            )),
            _ => Err(first.damaged("no beginning")),
        }
    }

    /// Reads the next record; the last one says that it is.
    fn next(&mut self) -> Result<Record<'a>, Error> {
        let start = self.at;
        let short =
            || damaged("the end before the last record").at(Place::default().byte(start as u64));
        let remaining = self.stream.get(start..).ok_or_else(short)?;
        let [kind_low, kind_high, low, high, body @ ..] = remaining else {
            return Err(short());
        };
        let length = usize::from(u16::from_le_bytes([*low, *high]));
        let data = body.get(..length).ok_or_else(short)?;
        self.at = start + 4 + length;
        Ok(Record {
            kind: u16::from_le_bytes([*kind_low, *kind_high]),
            data,
            start,
        })
    }
}

/// Reads the texts that cells share, which go on over the records.
fn strings(records: &[&[u8]]) -> Result<Strings, Error> {
    let mut strings = Strings::default();
    let Some(first) = records.first() else {
        return Ok(strings);
    };
    let mut bytes = SharedBytes {
        records,
        record: 0,
        at: 8,
    };
    let count = first.get(4..8).ok_or_else(short_text)?;
    let count = u32::from_le_bytes([count[0], count[1], count[2], count[3]]);
    for _ in 0..count {
        let characters = usize::from(bytes.u16()?);
        let flags = bytes.byte()?;
        let runs = if flags & 8 != 0 {
            usize::from(bytes.u16()?)
        } else {
            0
        };
        let extended = match flags & 4 {
            0 => 0,
            _ => usize::from(bytes.u16()?) | usize::from(bytes.u16()?) << 16,
        };
        let mut text = String::new();
        bytes.characters(characters, flags & 1 != 0, &mut text)?;
        strings.push_str(&text);
        strings.end();
        bytes.skip(4 * runs + extended)?;
    }
    Ok(strings)
}

fn short_text() -> Error {
    damaged("shared texts that end too early")
}

/// Bytes that go on over records.
struct SharedBytes<'a> {
    records: &'a [&'a [u8]],
    record: usize,
    at: usize,
}

impl<'a> SharedBytes<'a> {
    /// Returns what is left of the record, or the next one.
    fn rest(&mut self) -> Result<&'a [u8], Error> {
        loop {
            let record = *self.records.get(self.record).ok_or_else(short_text)?;
            match record.get(self.at..).filter(|rest| !rest.is_empty()) {
                Some(rest) => return Ok(rest),
                None => (self.record, self.at) = (self.record + 1, 0),
            }
        }
    }

    fn byte(&mut self) -> Result<u8, Error> {
        let byte = self.rest()?[0];
        self.at += 1;
        Ok(byte)
    }

    fn u16(&mut self) -> Result<u16, Error> {
        Ok(u16::from_le_bytes([self.byte()?, self.byte()?]))
    }

    fn skip(&mut self, mut count: usize) -> Result<(), Error> {
        while count > 0 {
            let step = self.rest()?.len().min(count);
            (self.at, count) = (self.at + step, count - step);
        }
        Ok(())
    }

    /// Reads characters; where they go on in the next record, that says their width anew.
    fn characters(
        &mut self,
        mut count: usize,
        mut is_wide: bool,
        text: &mut String,
    ) -> Result<(), Error> {
        let mut record = self.record;
        while count > 0 {
            let bytes = self.rest()?;
            if self.record != record {
                record = self.record;
                is_wide = self.byte()? & 1 != 0;
                continue;
            }
            let width = if is_wide { 2 } else { 1 };
            let step = (bytes.len() / width).min(count);
            if step == 0 {
                return Err(short_text());
            }
            push_characters(&bytes[..step * width], is_wide, text);
            (self.at, count) = (self.at + step * width, count - step);
        }
        Ok(())
    }
}
