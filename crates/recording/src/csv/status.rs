//! Words of a table on its samples: comment lines, and columns that hold the state of a channel or
//! notes row by row.

use super::layout::TableLayout;
use crate::channel_name::ChannelName;
use crate::error::Error;
use crate::remarks::{self, Cells, Remark, RemarkPlace};
use crate::words::{Words, word_list};
use crate::{Finding, Limits};

// The head of each list explains it.
static WELL: Words = word_list!("status-well");
static VALID: Words = word_list!("status-valid");
static FAULT: Words = word_list!("status-fault");
static STATE: Words = word_list!("status-state");

/// A remark or finding with the column that it concerns; `None` for the whole table.
pub(super) type ByColumn<T> = (Option<usize>, T);

/// Remarks and flags of a table.
pub(super) struct TableWords {
    pub(super) remarks: Vec<ByColumn<Remark>>,
    /// Findings on flags of bad samples.
    pub(super) flags: Vec<ByColumn<Finding>>,
}

/// Returns the remark of a comment on `line`: on a column if it begins with its name.
pub(super) fn of_comment(line: u64, comment: &str, columns: &[ChannelName]) -> ByColumn<Remark> {
    let key = comment.split([':', '=', ';', ',', '\t']).next();
    let key = key
        .filter(|key| key.len() < comment.len())
        .unwrap_or_default()
        .trim();
    let is_of = |column: &ChannelName| {
        column.name.eq_ignore_ascii_case(key) || column.label.eq_ignore_ascii_case(key)
    };
    let column = columns.iter().position(is_of).filter(|_| !key.is_empty());
    let (place, teller) = match column {
        Some(_) => (
            RemarkPlace::Channel,
            format!("line {line} says of this channel"),
        ),
        None => (RemarkPlace::Apart, format!("line {line} says")),
    };
    (column, Remark::new(comment, place, teller))
}

/// Subject of the words of a column.
#[derive(Clone, Copy, PartialEq)]
enum About {
    /// Flags of good samples: yes or no.
    Valid,
    /// Flags of a fault: yes or no.
    Fault,
    /// The state of something.
    State,
    /// Notes of a person.
    Notes,
}

fn about(column: &ChannelName) -> Option<About> {
    match column.unit_text {
        Some(_) => None,
        None => about_name(&column.label),
    }
}

fn about_name(name: &str) -> Option<About> {
    let small = name.to_lowercase();
    let has = |list: &[&str]| {
        small
            .split(|c: char| !c.is_alphanumeric())
            .any(|word| list.contains(&word))
    };
    if has(&VALID) {
        Some(About::Valid)
    } else if has(&FAULT) {
        Some(About::Fault)
    } else if has(&STATE) {
        Some(About::State)
    } else {
        remarks::is_key(&small).then_some(About::Notes)
    }
}

/// Meaning of a word under a name that is about the state of samples.
#[derive(Clone, Copy, PartialEq)]
enum Word {
    /// All is well, or nothing is stated.
    Well,
    /// A flag of a bad sample.
    Bad,
    /// Anything else.
    Other,
}

impl About {
    fn word(self, text: &str) -> Word {
        let small = text.trim().to_lowercase();
        let number = small.parse::<f64>().ok();
        let yes = number == Some(1.0) || matches!(&*small, "true" | "yes" | "y" | "ja" | "wahr");
        let no = number == Some(0.0) || matches!(&*small, "false" | "no" | "n" | "nein" | "falsch");
        match self {
            Self::Notes => Word::Other,
            Self::Valid if yes => Word::Well,
            Self::Fault if no => Word::Well,
            Self::Valid | Self::Fault if yes || no => Word::Bad,
            _ if small.is_empty() || WELL.contains(&small.as_str()) => Word::Well,
            _ => Word::Other,
        }
    }
}

/// True if a text under a name such as `status` or `overload` does not say that all is well.
pub(crate) fn says_bad(name: &str, text: &str) -> bool {
    let about = about_name(name).filter(|about| *about != About::Notes);
    about.is_some_and(|about| about.word(text) != Word::Well)
}

/// True if a column holds the state of samples or notes.
pub(super) fn is_of_words(column: &ChannelName) -> bool {
    about(column).is_some()
}

/// A column of words.
pub(super) struct StatusColumn {
    index: usize,
    about: About,
    cells: Cells<usize>,
    /// The first row whose flag says that its sample is bad, and the flag.
    bad: Option<(usize, String)>,
}

impl StatusColumn {
    /// Returns the one column that it concerns: `acc_y_status` concerns `acc_y`.
    fn subject(&self, layout: &TableLayout) -> Option<usize> {
        let label = layout.columns[self.index].label.to_lowercase();
        (0..layout.columns.len())
            .filter(|index| {
                let name = layout.columns[*index].label.to_lowercase();
                *index != self.index
                    && name.len() > 1
                    && label
                        .strip_prefix(&name)
                        .is_some_and(|suffix| suffix.starts_with(|c: char| !c.is_alphanumeric()))
            })
            .max_by_key(|index| layout.columns[*index].label.len())
    }

    fn look(&mut self, row: usize, cell: &[u8]) {
        let text = String::from_utf8_lossy(cell.trim_ascii());
        match self.about.word(&text) {
            Word::Well => {}
            Word::Bad => {
                self.bad.get_or_insert_with(|| (row, text.into_owned()));
            }
            Word::Other => self.cells.hear(row, &text),
        }
    }
}

/// Reads the columns of words.
pub(super) fn read(
    text: &[u8],
    layout: &TableLayout,
    limits: &Limits,
) -> Result<Vec<StatusColumn>, Error> {
    let mut columns: Vec<StatusColumn> = layout
        .columns
        .iter()
        .enumerate()
        .filter_map(|(index, header)| {
            let about = about(header)?;
            Some(StatusColumn {
                index,
                about,
                cells: Cells::new(about != About::Notes),
                bad: None,
            })
        })
        .collect();
    if columns.is_empty() {
        return Ok(columns);
    }
    let mut records = layout.records(text, limits)?;
    let mut number = 0;
    while let Some(row) = records.next()? {
        for column in &mut columns {
            column.look(number, row.get(column.index).unwrap_or_default());
        }
        number += 1;
    }
    Ok(columns)
}

/// Returns the words of such columns, but for those `passed` over since they are read as numbers;
/// `instant` returns the time of a row [s].
pub(super) fn of_columns(
    columns: &[StatusColumn],
    layout: &TableLayout,
    passed: &[usize],
    instant: impl Fn(usize) -> Option<f64>,
) -> TableWords {
    let (mut remarks, mut flags) = (Vec::new(), Vec::new());
    for column in columns
        .iter()
        .filter(|column| !passed.contains(&column.index))
    {
        let subject = column.subject(layout);
        let name = &layout.columns[column.index].name;
        let place = |row| (instant(row), format!(" in row {}", row + 1));
        let column_remarks = column.cells.remarks(name, place);
        remarks.extend(column_remarks.into_iter().map(|remark| (subject, remark)));
        flags.extend(column.bad.as_ref().map(|(row, flag)| {
            let text = format!(
                "the column `{name}` says \"{flag}\" from row {} on. Use another channel, or \
                 samples before that",
                row + 1
            );
            let blocking = Finding::blocking("invalid-by-laboratory", text);
            (subject, blocking.since(instant(*row)))
        }));
    }
    TableWords { remarks, flags }
}
