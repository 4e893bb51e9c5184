//! Workbooks of Excel (.xlsx, .xlsm, .xls): a sheet is a table, read by the rules of text tables.
//!
//! Cells become the text that they hold, numbers with all their digits, dates and times of day as a
//! clock shows them; a formula counts by the result that is stored. What is no plain number (a fault, a
//! formula without a result, a number whose format shows another one) stands there in words, and a
//! channel with such a cell is refused at its place.
//!
//! - `builder`: from cells to a table of text: what a cell holds, as it stands in a text table;
//! - `number_format`: number formats of cells: which numbers are dates, and which are shown as others
//!   than they are;
//! - `strings`: the texts that cells share;
//! - `xls`: workbooks of Excel 97 to 2003: records in a stream of an OLE2 container;
//! - `xlsx`: workbooks of Excel since 2007: parts in XML.

mod builder;
mod number_format;
mod strings;
mod xls;
mod xlsx;

use super::csv::{self, Sheet, TableMapping};
use super::source::Reader;
use super::{Finding, Head, Outcomes, ReadTask};
use crate::error::Error;
use crate::setting::Setting;
use std::collections::BTreeSet;

/// A sheet as the workbook lists it.
struct SheetEntry<P> {
    name: String,
    is_hidden: bool,
    /// Where its cells are.
    place: P,
}

/// What is read of a sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum SheetPass {
    /// Its first cell, to see whether it holds something.
    Probe,
    /// Its texts with fault words, since it may say what is wrong with another one.
    Words,
    Whole,
}

/// Tells whether a file in an archive is a part of a workbook that is read.
pub(super) fn is_part(name: &str) -> bool {
    let of_kind = name.ends_with(".xml") || name.ends_with(".rels");
    let is_of_sheets = !name.starts_with("xl/drawings/") && !name.starts_with("xl/charts/");
    name.starts_with("xl/") && of_kind && is_of_sheets
}

/// Tells whether a file in an archive makes it a workbook.
pub(super) fn is_main_part(name: &str) -> bool {
    name == xlsx::WORKBOOK
}

/// Tells whether the file is an OLE2 container, or an archive with the parts of a workbook.
pub fn recognises(head: &Head<'_>) -> bool {
    let mut entries = head.entries.iter();
    let is_workbook = head.is_archive && entries.any(|name| is_main_part(name));
    is_workbook || head.bytes.starts_with(xls::MAGIC)
}

/// Reads a sheet.
///
/// # Errors
///
/// As [`csv::read`], and
///
/// - [`RefusedFormat`](crate::error::ErrorKind::RefusedFormat) for an OLE2 container without a workbook,
///   and for a workbook under a password or of an older version,
/// - [`Malformed`](crate::error::ErrorKind::Malformed) for one that is damaged, and where several sheets
///   hold something and none is named,
/// - [`UnknownName`](crate::error::ErrorKind::UnknownName) for a sheet that is not there.
pub fn read(source: &mut Reader, asked: ReadTask) -> Result<Outcomes, Error> {
    csv::read_sheet(sheet(source, asked)?, asked)
}

/// Says how the table of a sheet was understood.
///
/// # Errors
///
/// As [`read`].
pub(super) fn mapping(source: &mut Reader, asked: ReadTask) -> Result<TableMapping, Error> {
    csv::mapping_of_sheet(sheet(source, asked)?, asked)
}

/// Reads the sheet that is meant.
fn sheet(source: &mut Reader, asked: ReadTask) -> Result<Sheet, Error> {
    let limits = asked.limits;
    if source.is_archive() {
        let workbook = xlsx::Workbook::open(source, limits)?;
        chosen(&workbook.sheets, asked, |entry, pass| {
            workbook.read(entry, pass, source, limits)
        })
    } else {
        let bytes = source.read_all("archive_bytes", limits.archive_bytes)?;
        let workbook = xls::Workbook::open(&bytes)?;
        chosen(&workbook.sheets, asked, |entry, pass| {
            workbook.read(entry, pass, limits)
        })
    }
}

/// Reads the sheet of the name that is asked for, else the only one that holds something.
fn chosen<P>(
    sheets: &[SheetEntry<P>],
    asked: ReadTask,
    mut read: impl FnMut(&SheetEntry<P>, SheetPass) -> Result<Sheet, Error>,
) -> Result<Sheet, Error> {
    let entry = match &asked.options.sheet {
        Some(wanted) => named(sheets, wanted)?,
        None => {
            // What cannot be read is not empty.
            let mut is_filled = |one: &&SheetEntry<P>| {
                read(one, SheetPass::Probe).map_or(true, |sheet| sheet.width > 0)
            };
            let filled: Vec<&SheetEntry<P>> = sheets.iter().filter(&mut is_filled).collect();
            match filled.as_slice() {
                [only] => *only,
                [] => {
                    let hint = "export time and samples to a sheet or as CSV, with `Time [s]` and \
                                `Acc Y [g]` above the columns";
                    let sheets = "no sheet holds a cell";
                    return Err(Error::malformed("a table in a sheet", sheets, hint));
                }
                several => {
                    let name = |one: &&SheetEntry<P>| {
                        let state = if one.is_hidden { " (hidden)" } else { "" };
                        format!("`{}`{state}", crate::text::shown(&one.name))
                    };
                    let names: Vec<String> = several.iter().map(name).collect();
                    let hint = format!("choose one: state {} = NAME", Setting::Sheet);
                    let expected = "one sheet that holds something";
                    return Err(Error::malformed(expected, names.join(", "), hint));
                }
            }
        }
    };
    let mut sheet = read(entry, SheetPass::Whole)?;
    let name = entry.name.clone();
    sheet
        .beside
        .push(("the name of the sheet says".into(), name));
    for other in sheets.iter().filter(|other| !std::ptr::eq(*other, entry)) {
        let words = read(other, SheetPass::Words)?;
        let name = crate::text::shown(&other.name);
        let teller = |line: u64| format!("row {line} of the sheet `{name}` says");
        let named = "the name of another sheet says".into();
        sheet.beside.push((named, other.name.clone()));
        let notes = words.notes.into_iter();
        sheet
            .beside
            .extend(notes.map(|(line, text)| (teller(line), text)));
        sheet.beside.extend(words.beside);
    }
    if entry.is_hidden {
        let text = format!("the sheet `{}` is hidden. Look at it", entry.name);
        sheet.findings.push(Finding::warning("hidden-cells", text));
    }
    Ok(sheet)
}

/// Returns the sheet of a name, letter by letter, else the only one whose name differs in case and blanks
/// at the ends alone.
fn named<'a, P>(sheets: &'a [SheetEntry<P>], name: &str) -> Result<&'a SheetEntry<P>, Error> {
    if let Some(exact) = sheets.iter().find(|one| one.name == name) {
        return Ok(exact);
    }
    let small = |name: &str| name.trim().to_lowercase();
    let alike = sheets.iter().filter(|one| small(&one.name) == small(name));
    let alike: Vec<&SheetEntry<P>> = alike.collect();
    match alike.as_slice() {
        [only] => Ok(*only),
        [] => {
            let names: Vec<&str> = sheets.iter().map(|one| one.name.as_str()).collect();
            Err(Error::unknown("sheet", name, &names))
        }
        several => {
            // With the blanks at its ends, in which it differs.
            let shown = |one: &&SheetEntry<P>| {
                let start: String = one.name.chars().take(60).collect();
                format!("`{}`", start.escape_debug())
            };
            let names: Vec<String> = several.iter().map(shown).collect();
            let matching_names = format!("`{}` for {}", crate::text::shown(name), names.join(", "));
            let hint = format!(
                "state {} = 'NAME' letter by letter, with its blanks",
                Setting::Sheet
            );
            Err(Error::malformed(
                "the name of one sheet",
                matching_names,
                hint,
            ))
        }
    }
}

/// Refuses sheets of which two are the same part or place: no spreadsheet writes them, and to look into
/// each costs their length over and over.
fn check_places<P: Ord>(sheets: &[SheetEntry<P>]) -> Result<(), Error> {
    let mut places = BTreeSet::new();
    for sheet in sheets {
        if !places.insert(&sheet.place) {
            let name = crate::text::shown(&sheet.name);
            return Err(damaged(format!("the sheet `{name}` where another is")));
        }
    }
    Ok(())
}

/// Says that results of formulas may be older than the numbers that they are computed from.
fn computed_when_asked() -> Finding {
    let text = "the workbook computes its formulas only when a person asks for it (manual calculation). \
                Their results may be older than their numbers. Compute them, and save it again";
    Finding::warning("formulas-manual", text)
}

/// How a damaged workbook is mended.
const MEND: &str = "the workbook is damaged; fetch it again, or open it in a spreadsheet program and save it \
                    as .xlsx anew";

/// Says that a workbook is none that a spreadsheet writes.
fn damaged(found: impl Into<String>) -> Error {
    Error::malformed("a workbook as a spreadsheet writes it", found, MEND)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_sheets_that_are_alike_are_listed_with_their_blanks() {
        let sheets = ["Data", "Data "].map(|name| SheetEntry {
            name: name.into(),
            is_hidden: false,
            place: 0,
        });
        assert_eq!(
            named(&sheets, "Data ").map(|one| one.name.as_str()).ok(),
            Some("Data ")
        );
        let error = named(&sheets, "data").map(|one| &one.name);
        let error = error.expect_err("two sheets");
        let says = "`Data`, `Data `; state the setting `sheet` = 'NAME' letter by letter";
        assert!(error.to_string().contains(says), "{error}");
    }
}
