//! Marks of a workbook's sheet besides its cells: hidden columns, merged cells.

use crate::error::{Error, Place};
use crate::{Finding, text};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

/// A sheet of a workbook as a table: a line for each row, tabs between its cells.
#[derive(Debug, Default)]
pub(crate) struct Sheet {
    pub(crate) name: String,
    pub(crate) text: Vec<u8>,
    /// Cells of each row.
    pub(crate) width: usize,
    pub(crate) marks: SheetMarks,
    /// Notes on cells, each with its line.
    pub(crate) notes: Vec<(u64, String)>,
    /// Words of the workbook outside the sheet, each with its source: "the page header says".
    pub(crate) beside: Vec<(String, String)>,
    /// Findings on it.
    pub(crate) findings: Vec<Finding>,
}

/// Marks of a sheet besides its cells.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct SheetMarks {
    /// Columns that are hidden, counted from 0.
    pub(crate) hidden_columns: Vec<Range<usize>>,
    pub(crate) merged: Vec<Merged>,
    /// Words that formats show after the numbers of a column, each with its last line.
    pub(crate) words_of_formats: BTreeMap<(usize, Arc<str>), u64>,
}

/// Cells that are shown as one: the first alone holds what is shown.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Merged {
    /// Rows, counted from 1.
    pub(crate) lines: Range<u64>,
    /// Columns, counted from 0.
    pub(crate) columns: Range<usize>,
}

impl SheetMarks {
    /// Refuses a column of which a cell in the lines of samples is shown as one with others, which hides
    /// all but merged.
    pub(super) fn refuse_merged(&self, column: usize, samples: &Range<u64>) -> Result<(), Error> {
        let hides = |merged: &&Merged| {
            let is_several = merged.lines.end - merged.lines.start > 1 || merged.columns.len() > 1;
            let is_of_samples =
                merged.lines.start < samples.end && samples.start < merged.lines.end;
            merged.columns.contains(&column) && is_several && is_of_samples
        };
        let Some(merged) = self.merged.iter().find(hides) else {
            return Ok(());
        };
        let (first, last) = (merged.columns.start, merged.columns.end - 1);
        let found = format!(
            "{}{} to {}{} shown as one cell",
            column_letters(first),
            merged.lines.start,
            column_letters(last),
            merged.lines.end - 1
        );
        let hint = "take the cells apart in the spreadsheet, and look at what they hold";
        let error = Error::malformed(
            "a cell of its own for each sample and each time",
            found,
            hint,
        );
        let line = merged.lines.start.max(samples.start);
        Err(error.at(Place::default().line(line).column(column as u64 + 1)))
    }

    /// Refuses a column whose cells show other words after their numbers than its unit.
    pub(super) fn refuse_other_words(
        &self,
        column: usize,
        head: &Range<u64>,
        is_unit: impl Fn(&str) -> bool,
    ) -> Result<(), Error> {
        let of_column = (column, Arc::from(""))..(column + 1, Arc::from(""));
        let mut words = self.words_of_formats.range(of_column);
        let mismatch = words.find(|((_, words), line)| **line >= head.end && !is_unit(words));
        let Some(((_, words), line)) = mismatch else {
            return Ok(());
        };
        let found = format!("the number format shows `{}`", text::shown(&**words));
        let hint = "state the unit that the cells show, or take the words off their format";
        let error = Error::malformed("numbers that show the unit of their column", found, hint);
        Err(error.at(Place::default().line(*line).column(column as u64 + 1)))
    }

    /// Returns the doubts on a column that is read by its name: it is hidden, or its name is shown above
    /// others as well. A column of samples that was not requested by name is refused then.
    pub(super) fn doubts(
        &self,
        column: usize,
        name: &str,
        head: &Range<u64>,
        is_requested: bool,
    ) -> Result<Vec<Finding>, Error> {
        let letters = column_letters(column);
        let mut doubts = Vec::new();
        if self
            .hidden_columns
            .iter()
            .any(|range| range.contains(&column))
        {
            doubts.push((
                "hidden-cells",
                format!("`{name}` in column {letters}, which is hidden"),
            ));
        }
        let above = |merged: &&Merged| {
            merged.columns.contains(&column)
                && merged.columns.len() > 1
                && merged.lines.start < head.end
                && head.start < merged.lines.end
        };
        if let Some(merged) = self.merged.iter().find(above) {
            let first = column_letters(merged.columns.start);
            let last = column_letters(merged.columns.end - 1);
            doubts.push((
                "merged-head",
                format!(
                    "`{name}` in column {letters}, whose head is merged over {first} to {last}"
                ),
            ));
        }
        if let (Some((_, text)), false) = (doubts.first(), is_requested) {
            let expected = "a channel that the sheet shows under a name of its own";
            let hint = format!(
                "if it is the one, state the setting `channel` = {}; else another",
                column + 1
            );
            let place = Place::default().line(head.start).column(column as u64 + 1);
            return Err(Error::malformed(expected, text, hint).at(place));
        }
        let finding =
            |(code, text)| Finding::warning(code, format!("{text}, was read. Look at the sheet"));
        Ok(doubts.into_iter().map(finding).collect())
    }
}

/// Returns the letters of a column, counted from 0.
pub(crate) fn column_letters(column: usize) -> String {
    let letter = char::from(b'A' + u8::try_from(column % 26).unwrap_or(0));
    match column / 26 {
        0 => letter.to_string(),
        more => format!("{}{letter}", column_letters(more - 1)),
    }
}
