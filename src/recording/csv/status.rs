//! What a table says of its samples in words: comment lines, and columns that hold the state of
//! a channel or notes row by row.

use super::cell::shown;
use super::header::Column;
use super::layout::TableLayout;
use super::records::Records;
use crate::error::Error;
use crate::recording::laboratory::{self, Remark};
use crate::recording::words::{Words, word_list};
use crate::recording::{Finding, Severity};

/// Findings of one severity that comments may give.
const MOST: usize = 20;

/// Values that deny what the words before them say.
static NOTHING: Words = word_list!("status-denials");

/// Words of a column by which all is well.
static WELL: Words = word_list!("status-well");

/// Returns what a comment on `line` says of the channel `column`.
pub(super) fn of_comment(
    line: u64,
    comment: &str,
    columns: &[Column],
    column: usize,
) -> Option<Finding> {
    let (key, value) = comment
        .split_once([':', '=', ';', ',', '\t'])
        .unwrap_or(("", comment));
    let denied = !key.is_empty() && says_one_of(&NOTHING, &value.trim().to_lowercase());
    if denied {
        return None;
    }
    // Written below every table of some exports.
    let ended = comment.trim().to_lowercase().starts_with("end of ")
        && !comment.contains(|c: char| c.is_ascii_digit());
    let remark = laboratory::remark(comment).filter(|_| !ended)?;
    if matches!(remark, Remark::Unclear) {
        // An instant alone, such as that of the trigger, says nothing of the samples.
        return None;
    }
    let mut finding = laboratory::finding(comment, None)?;
    if finding.severity == Severity::Warning && laboratory::remark(&prose(comment)).is_none() {
        return None;
    }
    let is_of = |column: &Column| {
        let key = key.trim();
        !key.is_empty()
            && (column.name.eq_ignore_ascii_case(key) || column.label.eq_ignore_ascii_case(key))
    };
    let blocks = finding.severity == Severity::Blocking;
    if blocks && !columns.iter().any(is_of) && !is_about_samples(comment) {
        // The vehicle, the door or a setting may be meant.
        finding = Finding::warning(
            "laboratory-remark",
            format!(
                "the file says \"{}\": if that is said of the samples, they are no evidence",
                shown(comment.as_bytes())
            ),
        );
    }
    finding.text = format!("comment on line {line}: {}", finding.text);
    if columns.iter().any(is_of) && !is_of(&columns[column]) {
        finding = Finding::warning(
            "laboratory-remark",
            format!(
                "comment on line {line}, on another channel: \"{}\"",
                shown(comment.as_bytes())
            ),
        );
    }
    Some(finding)
}

/// Returns a comment without names of the kind `spike_1k`, which are no words of a person.
fn prose(comment: &str) -> String {
    let words = comment.split_whitespace();
    let words: Vec<&str> = words.filter(|word| !word.contains('_')).collect();
    words.join(" ")
}

/// Tells whether a comment speaks of samples and what they came from, and not of a setting.
fn is_about_samples(comment: &str) -> bool {
    static SAMPLES: Words = word_list!("status-samples");
    static SETTINGS: Words = word_list!("status-settings");
    let small = comment.to_lowercase();
    let words: Vec<&str> = small
        .split(|c: char| !c.is_alphanumeric())
        .filter(|word| !word.is_empty())
        .collect();
    let has = |list: &[&str]| words.iter().any(|word| list.contains(word));
    // "overload 5000 g" is what a sensor bears.
    let rated = words.windows(3).any(|three| {
        matches!(
            three[0],
            "overload" | "overrange" | "clipping" | "saturation" | "shock"
        ) && three[1].bytes().all(|byte| byte.is_ascii_digit())
            && matches!(three[2], "g" | "m" | "mm")
    });
    has(&SAMPLES) && !has(&SETTINGS) && !rated
}

/// Returns what all comments say of a channel, at most a screenful of each severity.
pub(super) fn of_comments(
    comments: &[(u64, String)],
    columns: &[Column],
    column: usize,
) -> Vec<Finding> {
    let mut found: Vec<Finding> = Vec::new();
    for (line, comment) in comments {
        let Some(finding) = of_comment(*line, comment, columns, column) else {
            continue;
        };
        let alike = |known: &&mut Finding| known.severity == finding.severity;
        if found.iter_mut().filter(alike).count() < MOST {
            found.push(finding);
        } else if let Some(last) = found.iter_mut().rfind(alike) {
            // The earliest instant counts, and none at all is earlier still.
            last.at_s = last.at_s.zip(finding.at_s).map(|(a, b)| a.min(b));
        }
    }
    found
}

/// What the words of a column are about.
#[derive(Clone, Copy, PartialEq)]
enum About {
    /// Whether samples are good: yes or no.
    Valid,
    /// Whether a fault is there: yes or no.
    Fault,
    /// The state of something.
    State,
    /// Whatever a person noted.
    Notes,
}

/// Names of columns that say whether samples are good.
static VALID: Words = word_list!("status-valid");

/// Names of columns that say whether a fault is there.
static FAULT: Words = word_list!("status-fault");

/// Names of columns that hold a state.
static STATE: Words = word_list!("status-state");

/// Names of columns that hold what a person noted.
static NOTES: Words = word_list!("status-notes");

/// Tells whether a text is one of the list, or nothing at all.
fn says_one_of(list: &[&str], text: &str) -> bool {
    text.is_empty() || list.contains(&text)
}

fn about(column: &Column) -> Option<About> {
    let small = column.label.to_lowercase();
    let has = |list: &[&str]| {
        small
            .split(|c: char| !c.is_alphanumeric())
            .any(|word| list.contains(&word))
    };
    if column.unit_text.is_some() {
        None
    } else if has(&VALID) {
        Some(About::Valid)
    } else if has(&FAULT) {
        Some(About::Fault)
    } else if has(&STATE) {
        Some(About::State)
    } else if has(&NOTES) {
        Some(About::Notes)
    } else {
        None
    }
}

/// A column of words, and what it said first.
pub(super) struct StatusColumn {
    index: usize,
    about: About,
    first: Option<String>,
    last: String,
    /// The first words that take the worth from the samples, and the first others, by row.
    bad: Option<(usize, String)>,
    odd: Option<(usize, String)>,
}

impl StatusColumn {
    /// Returns the one column of which it speaks: `acc_y_status` speaks of `acc_y`.
    fn is_about(&self, layout: &TableLayout) -> Option<usize> {
        let label = layout.columns[self.index].label.to_lowercase();
        (0..layout.columns.len())
            .filter(|other| {
                let own = layout.columns[*other].label.to_lowercase();
                *other != self.index
                    && own.len() > 1
                    && label
                        .strip_prefix(&own)
                        .is_some_and(|rest| rest.starts_with(|c: char| !c.is_alphanumeric()))
            })
            .max_by_key(|other| layout.columns[*other].label.len())
    }

    fn look(&mut self, row: usize, cell: &[u8]) {
        let cell = cell.trim_ascii();
        if row > 0 && cell == self.last.as_bytes() {
            return;
        }
        let text = String::from_utf8_lossy(cell).into_owned();
        self.last.clone_from(&text);
        let small = text.to_lowercase();
        let first = self.first.get_or_insert_with(|| small.clone()).clone();
        let yes = matches!(small.as_str(), "1" | "true" | "yes" | "y" | "ja" | "wahr");
        let no = matches!(
            small.as_str(),
            "0" | "0.0" | "false" | "no" | "n" | "nein" | "falsch"
        );
        let bad = match self.about {
            About::Valid if yes => return,
            About::Valid if no => true,
            About::Fault if yes => true,
            _ if says_one_of(&WELL, &small) => return,
            About::Notes => matches!(laboratory::remark(&text), Some(Remark::Invalid(_))),
            _ => {
                matches!(
                    small.as_str(),
                    "bad" | "error" | "err" | "fail" | "schlecht"
                ) || matches!(laboratory::remark(&text), Some(Remark::Invalid(_)))
            }
        };
        if bad {
            self.bad.get_or_insert((row, text));
        } else if small != first || self.about == About::Notes {
            // A state that never changes says nothing of single samples.
            self.odd.get_or_insert((row, text));
        }
    }
}

/// What a column of words says, with the column it is said of, if it is only one.
pub(super) struct StatusFinding {
    of: Option<usize>,
    pub(super) finding: Finding,
}

impl StatusFinding {
    /// Tells whether it is said of the column `index`, among others perhaps.
    pub(super) fn is_of(&self, index: usize) -> bool {
        self.of.is_none_or(|of| of == index)
    }
}

/// Reads the columns of words.
///
/// # Errors
///
/// Those of the table reader.
pub(super) fn read(text: &[u8], layout: &TableLayout) -> Result<Vec<StatusColumn>, Error> {
    let mut columns: Vec<StatusColumn> = layout
        .columns
        .iter()
        .enumerate()
        .filter_map(|(index, header)| {
            Some(StatusColumn {
                index,
                about: about(header)?,
                first: None,
                last: String::new(),
                bad: None,
                odd: None,
            })
        })
        .collect();
    if columns.is_empty() {
        return Ok(columns);
    }
    let mut records =
        Records::after_header(text, layout.separator, layout.quoted, layout.header_rows)?;
    let mut number = 0;
    while let Some(row) = records.next()? {
        for column in &mut columns {
            let cell = (column.index < row.len()).then(|| &row[column.index]);
            column.look(number, cell.unwrap_or_default());
        }
        number += 1;
    }
    Ok(columns)
}

/// Returns what columns of words say, but for those `passed` over since they are read as numbers;
/// `at_s` tells the instant of a row [s].
pub(super) fn of_columns(
    columns: &[StatusColumn],
    layout: &TableLayout,
    passed: &[usize],
    at_s: impl Fn(usize) -> Option<f64>,
) -> Vec<StatusFinding> {
    let mut findings = Vec::new();
    for column in columns {
        if passed.contains(&column.index) {
            continue;
        }
        let of = column.is_about(layout);
        let name = &layout.columns[column.index].name;
        let mut push = |said: &Option<(usize, String)>, finding: fn(String) -> Finding| {
            let Some((row, word)) = said else { return };
            let text = format!(
                "the column `{name}` says \"{}\" from row {} on",
                shown(word.as_bytes()),
                row + 1
            );
            findings.push(StatusFinding {
                of,
                finding: Finding {
                    at_s: at_s(*row),
                    ..finding(text)
                },
            });
        };
        push(&column.bad, |text| {
            Finding::blocking("invalid-by-laboratory", text)
        });
        push(
            &column.odd,
            if column.about == About::Notes {
                |text| Finding::info("notes", text)
            } else {
                |text| Finding::warning("laboratory-remark", text)
            },
        );
    }
    findings
}
