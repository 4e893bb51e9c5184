//! Workbooks of Excel since 2007 (.xlsx, .xlsm): parts in XML.
//!
//! # Source
//!
//! ECMA-376, part 1, 18.2 to 18.8: workbook, sheets, shared strings, styles.

use super::builder::{Epoch, SheetBuilder, Value, place};
use super::number_format::NumberFormat;
use super::strings::Strings;
use super::{SheetEntry, SheetPass, check_places, computed_when_asked, damaged};
use crate::csv::{Merged, Sheet};
use crate::error::{Error, Place};
use crate::source::Reader as Source;
use crate::{Finding, Limits, text};
use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;
use std::collections::BTreeMap;

/// The part that lists the sheets.
pub(super) const WORKBOOK: &str = "xl/workbook.xml";

/// A workbook whose sheets are listed and not read yet.
pub(super) struct Workbook {
    pub(super) sheets: Vec<SheetEntry<String>>,
    epoch: Epoch,
    /// The program that opens the workbook shall compute its formulas: what is stored of them is no result.
    is_not_computed: bool,
    /// Formulas are computed only when a person asks for it.
    is_manual: bool,
    formats: Vec<NumberFormat>,
    strings: Strings,
}

impl Workbook {
    /// Reads all but the sheets.
    pub(super) fn open(source: &mut Source, limits: &Limits) -> Result<Self, Error> {
        let relations = Relations::of(WORKBOOK, source, limits)?;
        let mut workbook = Self {
            sheets: Vec::new(),
            epoch: Epoch::Of1900,
            is_not_computed: false,
            is_manual: false,
            formats: Vec::new(),
            strings: Strings::default(),
        };
        let bytes = part(WORKBOOK, source, limits)?;
        let mut xml = Xml::new(WORKBOOK, &bytes)?;
        while let Some(event) = xml.next()? {
            let (Event::Start(tag) | Event::Empty(tag)) = event else {
                continue;
            };
            match tag.local_name().as_ref() {
                "workbookPr" if xml.flag(&tag, "date1904")? => workbook.epoch = Epoch::Of1904,
                "calcPr" => {
                    let is_complete = xml.attribute(&tag, "calcCompleted")?;
                    let is_cut = is_complete.is_some_and(|word| word == "0" || word == "false");
                    workbook.is_not_computed = is_cut || xml.flag(&tag, "fullCalcOnLoad")?;
                    let mode = xml.attribute(&tag, "calcMode")?;
                    workbook.is_manual = mode.is_some_and(|mode| mode == "manual");
                }
                "sheet" => {
                    let name = xml.attribute(&tag, "name")?.unwrap_or_default();
                    let state = xml.attribute(&tag, "state")?;
                    let id = xml.attribute(&tag, "id")?.unwrap_or_default();
                    let (kind, target) = relations.0.get(&id).ok_or_else(|| {
                        xml.damaged(format!(
                            "the sheet `{}` without its part",
                            text::shown(&name)
                        ))
                    })?;
                    // Sheets of charts, macros and dialogs hold no table.
                    if kind == "worksheet" {
                        workbook.sheets.push(SheetEntry {
                            name,
                            is_hidden: state.is_some_and(|state| state != "visible"),
                            place: target.clone(),
                        });
                    }
                }
                _ => {}
            }
        }
        check_places(&workbook.sheets)?;
        if let Some(target) = relations.only("styles")? {
            workbook.formats = formats(target, source, limits)?;
        }
        if let Some(target) = relations.only("sharedStrings")? {
            workbook.strings = strings(target, source, limits)?;
        }
        Ok(workbook)
    }

    /// Reads a sheet as far as the pass needs it.
    pub(super) fn read(
        &self,
        sheet: &SheetEntry<String>,
        pass: SheetPass,
        source: &mut Source,
        limits: &Limits,
    ) -> Result<Sheet, Error> {
        let bytes = part(&sheet.place, source, limits)?;
        let mut xml = Xml::new(&sheet.place, &bytes)?;
        let mut builder = SheetBuilder::new(self.epoch, pass, limits);
        let mut row = 0;
        let mut next_row = 0;
        let mut next_column = 0;
        let (mut in_rows, mut had_rows) = (false, false);
        while let Some(event) = xml.next()? {
            let is_open = matches!(event, Event::Start(_));
            match event {
                Event::Start(tag)
                    if matches!(
                        tag.local_name().as_ref(),
                        "oddHeader"
                            | "oddFooter"
                            | "evenHeader"
                            | "evenFooter"
                            | "firstHeader"
                            | "firstFooter"
                    ) =>
                {
                    builder.put_page_words(&xml.text_of(&tag)?);
                }
                Event::Start(tag) | Event::Empty(tag) => match tag.local_name().as_ref() {
                    "sheetData" if had_rows => {
                        return Err(xml.damaged("a second list of rows (`sheetData`)"));
                    }
                    "sheetData" => (in_rows, had_rows) = (is_open, true),
                    // Rows of which each program takes others.
                    "AlternateContent" if in_rows => {
                        return Err(xml.damaged("rows that stand there twice (`AlternateContent`)"));
                    }
                    "row" if in_rows => {
                        row = match xml.number(&tag, "r")? {
                            Some(number) => xml.counted_from_zero(number)?,
                            None => next_row,
                        };
                        (next_row, next_column) = (row + 1, 0);
                        let height = xml.attribute(&tag, "ht")?;
                        let is_flat = height.is_some_and(|height| height.trim().parse() == Ok(0.0));
                        if is_flat || xml.flag(&tag, "hidden")? {
                            let line = u64::from(row) + 1;
                            match builder.hidden_rows.last_mut().filter(|one| one.end == line) {
                                Some(before) => before.end += 1,
                                None => builder.hidden_rows.push(line..line + 1),
                            }
                        }
                    }
                    "c" if in_rows => {
                        let column = match xml.attribute(&tag, "r")? {
                            Some(name) => {
                                let (own_row, column) = cell_of(&name)
                                    .ok_or_else(|| xml.damaged(format!("a cell `{name}`")))?;
                                if own_row != row {
                                    let misplaced_cell =
                                        format!("the cell `{name}` in row {}", row + 1);
                                    return Err(xml.damaged(misplaced_cell));
                                }
                                column
                            }
                            None => next_column,
                        };
                        next_column = column + 1;
                        if is_open {
                            self.take_cell(&mut xml, &tag, (row, column), &mut builder)?;
                        }
                        if builder.is_probed() {
                            return builder.finish(&sheet.name);
                        }
                    }
                    "sheetFormatPr" => {
                        let width = xml.attribute(&tag, "defaultColWidth")?;
                        if width.is_some_and(|width| width.trim().parse() == Ok(0.0)) {
                            builder.hide_all_columns();
                        }
                        if xml.flag(&tag, "zeroHeight")? {
                            builder.hide_all_rows();
                        }
                    }
                    "col" if !in_rows => {
                        let [first, last] = ["min", "max"].map(|name| xml.number(&tag, name));
                        let first = xml.counted_from_zero(first?.unwrap_or(0))? as usize;
                        let end = xml.counted_from_zero(last?.unwrap_or(0))? as usize + 1;
                        if first >= end {
                            let column_range = format!("columns {} to {end}", first + 1);
                            return Err(xml.damaged(column_range));
                        }
                        let width = xml.attribute(&tag, "width")?;
                        let is_flat = width.is_some_and(|width| width.trim().parse() == Ok(0.0));
                        if is_flat || xml.flag(&tag, "hidden")? {
                            builder.marks.hidden_columns.push(first..end);
                        }
                    }
                    "mergeCell" if !in_rows => {
                        let range = xml.attribute(&tag, "ref")?.unwrap_or_default();
                        let merged = merged(&range);
                        let merged =
                            merged.ok_or_else(|| xml.damaged(format!("cells `{range}`")))?;
                        builder.marks.merged.push(merged);
                    }
                    _ => {}
                },
                Event::End(tag) if tag.local_name().as_ref() == "sheetData" => in_rows = false,
                _ => {}
            }
        }
        let mut has_threads = false;
        if pass != SheetPass::Probe {
            let relations = Relations::of(&sheet.place, source, limits)?;
            let mut kinds = relations.0.values().map(|(kind, _)| kind);
            has_threads = kinds.any(|kind| kind == "threadedComment");
            if let Some(target) = relations.only("comments")? {
                take_notes(target, source, limits, &mut builder)?;
            }
        }
        let is_stale = self.is_manual && builder.has_formulas;
        let mut read = builder.finish(&sheet.name)?;
        read.findings.extend(is_stale.then(computed_when_asked));
        if has_threads {
            let text = "the sheet has threads of notes on cells, which are not read. Read them";
            read.findings.push(Finding::warning("notes-not-read", text));
        }
        Ok(read)
    }

    /// Takes in a cell whose tag was opened, up to its end.
    fn take_cell(
        &self,
        xml: &mut Xml<'_>,
        tag: &BytesStart<'_>,
        (row, column): (u32, u32),
        builder: &mut SheetBuilder<'_>,
    ) -> Result<(), Error> {
        let kind = xml.attribute(tag, "t")?;
        let format = xml.number(tag, "s")?.unwrap_or(0) as usize;
        let format = self.formats.get(format).cloned().unwrap_or_default();
        let (mut stored, mut inline, mut is_formula) = (None, None, false);
        while let Some(event) = xml.next()? {
            match event {
                Event::Start(tag) => match tag.local_name().as_ref() {
                    "f" => {
                        is_formula = true;
                        xml.text_of(&tag)?;
                    }
                    "v" if stored.is_none() => stored = Some(xml.text_of(&tag)?),
                    "is" if inline.is_none() => inline = Some(xml.text_of(&tag)?),
                    "v" | "is" => return Err(xml.damaged("a cell with two values")),
                    _ => drop(xml.text_of(&tag)?),
                },
                Event::Empty(tag) => match tag.local_name().as_ref() {
                    "f" => is_formula = true,
                    "v" if stored.is_none() => stored = Some(String::new()),
                    _ => {}
                },
                // That of the cell, since the others are read to theirs.
                Event::End(_) => break,
                _ => {}
            }
        }
        builder.has_formulas |= is_formula;
        let kind = kind.as_deref().unwrap_or("n");
        if is_formula && self.is_not_computed {
            return builder.put(row, column, Value::NotComputed, format);
        }
        let no_value = || {
            xml.damaged(format!("a cell of the kind `{kind}` without it"))
                .at(place(row, column))
        };
        let stored = stored.as_deref();
        let decoded;
        let value = match (kind, stored) {
            // A formula may have an empty text as its result.
            ("str", Some(text)) => {
                decoded = unescaped(text);
                Value::Text(&decoded)
            }
            ("inlineStr", _) => {
                decoded = unescaped(inline.as_deref().unwrap_or_default());
                Value::Text(&decoded)
            }
            (_, None | Some("")) if is_formula => Value::NotComputed,
            (_, None | Some("")) => return Ok(()),
            ("n", Some(text)) => Value::Number(text.trim().parse().map_err(|_| no_value())?),
            ("s", Some(text)) => {
                let number = text.trim().parse().ok();
                let shared = number.and_then(|number| self.strings.get(number));
                Value::Text(shared.ok_or_else(no_value)?)
            }
            ("b", Some("1" | "true")) => Value::Bool(true),
            ("b", Some("0" | "false")) => Value::Bool(false),
            ("e", Some(fault)) => Value::Fault(fault),
            ("d", Some(date)) => Value::Text(date),
            _ => return Err(no_value()),
        };
        builder.put(row, column, value, format)
    }
}

/// Decodes the characters of a text that XML cannot hold, `_x000A_`; a line that looks so has its first
/// stroke as `_x005F_`.
///
/// # Source
///
/// ECMA-376, part 1, 22.9.2.19 (`ST_Xstring`).
fn unescaped(text: &str) -> String {
    let mut decoded = String::with_capacity(text.len());
    let mut remaining = text;
    while let Some(start) = remaining.find("_x") {
        decoded.push_str(&remaining[..start]);
        remaining = &remaining[start..];
        let digits = remaining
            .get(2..6)
            .filter(|_| remaining.as_bytes().get(6) == Some(&b'_'));
        let digits = digits.filter(|digits| digits.bytes().all(|c| c.is_ascii_hexdigit()));
        let number = digits.and_then(|digits| u32::from_str_radix(digits, 16).ok());
        let (letter, length) = match number.and_then(char::from_u32) {
            Some(letter) => (letter, "_x0000_".len()),
            None => ('_', 1),
        };
        decoded.push(letter);
        remaining = &remaining[length..];
    }
    decoded + remaining
}

/// Reads a part that must be there.
fn part(name: &str, source: &mut Source, limits: &Limits) -> Result<Vec<u8>, Error> {
    let bytes = source.read_beside(name, limits)?;
    bytes.ok_or_else(|| damaged(format!("no part `{}`", text::shown(name))))
}

/// What a part refers to: kind and part, by the name of the reference.
struct Relations(BTreeMap<String, (String, String)>);

impl Relations {
    fn of(name: &str, source: &mut Source, limits: &Limits) -> Result<Self, Error> {
        let (folder, file) = name.rsplit_once('/').unwrap_or(("", name));
        let list = format!("{folder}/_rels/{file}.rels");
        let mut relations = BTreeMap::new();
        let Some(bytes) = source.read_beside(&list, limits)? else {
            return Ok(Self(relations));
        };
        let mut xml = Xml::new(&list, &bytes)?;
        while let Some(event) = xml.next()? {
            let (Event::Start(tag) | Event::Empty(tag)) = event else {
                continue;
            };
            let [id, kind, target] = ["Id", "Type", "Target"].map(|name| xml.attribute(&tag, name));
            let (Some(id), Some(kind), Some(target)) = (id?, kind?, target?) else {
                continue;
            };
            let kind = kind.rsplit('/').next().unwrap_or_default().to_string();
            relations.insert(id, (kind, resolved(folder, &target)));
        }
        Ok(Self(relations))
    }

    /// Returns the part of a kind, of which there is one at most.
    fn only(&self, kind: &str) -> Result<Option<&str>, Error> {
        let mut targets = self.0.values().filter(|(other, _)| other == kind);
        let first = targets.next();
        match targets.next() {
            None => Ok(first.map(|(_, target)| target.as_str())),
            Some(_) => Err(damaged(format!("several parts of the kind `{kind}`"))),
        }
    }
}

/// Returns the name of a part that another in `folder` refers to.
fn resolved(folder: &str, target: &str) -> String {
    let mut steps: Vec<&str> = match target.starts_with('/') {
        true => Vec::new(),
        false => folder.split('/').collect(),
    };
    for step in target.split('/') {
        match step {
            "" | "." => {}
            ".." => drop(steps.pop()),
            step => steps.push(step),
        }
    }
    steps.join("/")
}

/// Reads the formats of cells, in the order in which cells name them.
fn formats(name: &str, source: &mut Source, limits: &Limits) -> Result<Vec<NumberFormat>, Error> {
    let bytes = part(name, source, limits)?;
    let mut xml = Xml::new(name, &bytes)?;
    let (mut codes, mut formats, mut of_cells) = (BTreeMap::new(), Vec::new(), false);
    while let Some(event) = xml.next()? {
        let is_open = matches!(event, Event::Start(_));
        match event {
            Event::Start(tag) | Event::Empty(tag) => match tag.local_name().as_ref() {
                "numFmt" => {
                    let number = xml.number(&tag, "numFmtId")?.unwrap_or(0);
                    let code = xml.attribute(&tag, "formatCode")?.unwrap_or_default();
                    codes.insert(number, NumberFormat::of_code(&code));
                }
                "cellXfs" => of_cells = is_open,
                "xf" if of_cells => formats.push(xml.number(&tag, "numFmtId")?.unwrap_or(0)),
                _ => {}
            },
            Event::End(tag) if tag.local_name().as_ref() == "cellXfs" => of_cells = false,
            _ => {}
        }
    }
    let format = |number| codes.get(&number).cloned();
    let format = |number| format(number).unwrap_or_else(|| NumberFormat::built_in(number));
    Ok(formats.into_iter().map(format).collect())
}

/// Reads the texts that cells share.
fn strings(name: &str, source: &mut Source, limits: &Limits) -> Result<Strings, Error> {
    let bytes = part(name, source, limits)?;
    let mut xml = Xml::new(name, &bytes)?;
    let mut strings = Strings::default();
    while let Some(event) = xml.next()? {
        match event {
            Event::Start(tag) if tag.local_name().as_ref() == "si" => {
                strings.push_str(&unescaped(&xml.text_of(&tag)?));
                strings.end();
            }
            Event::Empty(tag) if tag.local_name().as_ref() == "si" => strings.end(),
            _ => {}
        }
    }
    Ok(strings)
}

/// Takes in the notes on cells.
fn take_notes(
    name: &str,
    source: &mut Source,
    limits: &Limits,
    builder: &mut SheetBuilder<'_>,
) -> Result<(), Error> {
    let bytes = part(name, source, limits)?;
    let mut xml = Xml::new(name, &bytes)?;
    while let Some(event) = xml.next()? {
        if let Event::Start(tag) = event
            && tag.local_name().as_ref() == "comment"
        {
            let cell = xml.attribute(&tag, "ref")?.unwrap_or_default();
            let line = cell_of(&cell).map_or(0, |(row, _)| u64::from(row) + 1);
            builder.notes.push((line, unescaped(&xml.text_of(&tag)?)));
        }
    }
    Ok(())
}

/// Returns row and column of a cell, `B7`, counted from 0; `None` if no sheet has it.
fn cell_of(name: &str) -> Option<(u32, u32)> {
    let name = name.trim();
    let letters = name.bytes().take_while(u8::is_ascii_alphabetic).count();
    let (letters, digits) = name.split_at(letters);
    let number =
        |column: u32, letter: u8| 26 * column + u32::from(letter.to_ascii_uppercase() - b'A') + 1;
    let column = (1..=3)
        .contains(&letters.len())
        .then(|| letters.bytes().fold(0, number))?;
    let is_plain = digits.bytes().all(|digit| digit.is_ascii_digit());
    let row: u32 = digits.parse().ok().filter(|_| is_plain)?;
    Some((row.checked_sub(1)?, column - 1)).filter(|(row, _)| *row < 1 << 20)
}

/// Returns the cells of a range, `B7:C9`.
fn merged(range: &str) -> Option<Merged> {
    let (first, last) = range.split_once(':').unwrap_or((range, range));
    let (first, last) = (cell_of(first)?, cell_of(last)?);
    let is_ordered = first.0 <= last.0 && first.1 <= last.1;
    is_ordered.then(|| Merged {
        lines: u64::from(first.0) + 1..u64::from(last.0) + 2,
        columns: first.1 as usize..last.1 as usize + 1,
    })
}

/// A part in XML.
struct Xml<'a> {
    name: &'a str,
    reader: Reader<&'a [u8]>,
    depth: usize,
    /// Whether a tag came.
    has_tags: bool,
}

impl<'a> Xml<'a> {
    fn new(name: &'a str, bytes: &'a [u8]) -> Result<Self, Error> {
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        let text = std::str::from_utf8(bytes);
        let text = text.map_err(|_| damaged(format!("{}: no UTF-8", text::shown(name))))?;
        Ok(Self {
            name,
            reader: Reader::from_str(text),
            depth: 0,
            has_tags: false,
        })
    }

    /// Says that the part is none that a spreadsheet writes.
    fn damaged(&self, found: impl AsRef<str>) -> Error {
        let byte = self.reader.buffer_position();
        damaged(format!("{}: {}", text::shown(self.name), found.as_ref()))
            .at(Place::default().byte(byte))
    }

    /// Returns the next event; `None` at the end, behind the last open tag.
    fn next(&mut self) -> Result<Option<Event<'a>>, Error> {
        let event = self.reader.read_event();
        let event = event.map_err(|error| self.damaged(error.to_string()))?;
        match event {
            Event::Start(_) => (self.depth, self.has_tags) = (self.depth + 1, true),
            Event::Empty(_) => self.has_tags = true,
            Event::End(_) => self.depth = self.depth.saturating_sub(1),
            Event::Eof if self.depth > 0 => return Err(self.damaged("the end within a tag")),
            Event::Eof if !self.has_tags => return Err(self.damaged("no XML")),
            Event::Eof => return Ok(None),
            _ => {}
        }
        Ok(Some(event))
    }

    /// Returns an attribute by its name without prefix.
    fn attribute(&self, tag: &BytesStart<'_>, name: &str) -> Result<Option<String>, Error> {
        for attribute in tag.attributes().with_checks(false) {
            let attribute = attribute.map_err(|error| self.damaged(error.to_string()))?;
            if attribute.key.local_name().as_ref() == name {
                let value = attribute.normalized_value(XmlVersion::Implicit1_0);
                let value = value.map_err(|error| self.damaged(error.to_string()))?;
                return Ok(Some(value.into_owned()));
            }
        }
        Ok(None)
    }

    /// Returns an attribute that is a whole number.
    fn number(&self, tag: &BytesStart<'_>, name: &str) -> Result<Option<u32>, Error> {
        let Some(text) = self.attribute(tag, name)? else {
            return Ok(None);
        };
        let number = text.trim().parse();
        number
            .map(Some)
            .map_err(|_| self.damaged(format!("{name}=\"{}\"", text::shown(&text))))
    }

    fn flag(&self, tag: &BytesStart<'_>, name: &str) -> Result<bool, Error> {
        let value = self.attribute(tag, name)?;
        Ok(value.is_some_and(|value| matches!(value.trim(), "1" | "true" | "on")))
    }

    /// Returns what is counted from 1 as counted from 0, where a sheet has it.
    fn counted_from_zero(&self, number: u32) -> Result<u32, Error> {
        let index = number.checked_sub(1).filter(|number| *number < 1 << 20);
        index.ok_or_else(|| self.damaged(format!("row or column {number}")))
    }

    /// Returns the text of a tag that was opened, up to its end; readings of characters are left out.
    fn text_of(&mut self, tag: &BytesStart<'_>) -> Result<String, Error> {
        let depth = self.depth;
        let is_rich = matches!(tag.local_name().as_ref(), "si" | "is" | "comment");
        let mut text = String::new();
        let (mut in_text, mut reading) = (!is_rich, None);
        loop {
            let event = self
                .next()?
                .ok_or_else(|| self.damaged("the end within a cell"))?;
            match event {
                Event::Start(tag) => match tag.local_name().as_ref() {
                    "rPh" if reading.is_none() => reading = Some(self.depth),
                    "t" => in_text = true,
                    _ => {}
                },
                Event::End(tag) => {
                    if tag.local_name().as_ref() == "t" {
                        in_text = !is_rich;
                    }
                    if reading.is_some_and(|reading| self.depth < reading) {
                        reading = None;
                    }
                    if self.depth < depth {
                        return Ok(text);
                    }
                }
                _ if !in_text || reading.is_some() => {}
                Event::Text(part) => text.push_str(&part.xml10_content()),
                Event::CData(part) => text.push_str(&part.xml10_content()),
                Event::GeneralRef(name) => {
                    let of_number = name.resolve_char_ref();
                    let of_number = of_number.map_err(|error| self.damaged(error.to_string()))?;
                    let letter = of_number.or_else(|| match &*name.xml10_content() {
                        "lt" => Some('<'),
                        "gt" => Some('>'),
                        "amp" => Some('&'),
                        "quot" => Some('"'),
                        "apos" => Some('\''),
                        _ => None,
                    });
                    text.push(letter.ok_or_else(|| self.damaged("an entity of its own"))?);
                }
                _ => {}
            }
        }
    }
}
