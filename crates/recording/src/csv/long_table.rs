//! Long tables: several channels below one another in one column, told apart by a column of labels. Their samples
//! are no channel, whatever the rate.

use super::layout::TableLayout;
use crate::error::{Error, Place};
use crate::text::shown;
use crate::{ReadTask, channel_name, number};

/// Most labels of one instant.
const LABELS: usize = 64;

/// Fewest instants whose labels repeat in one order.
const INSTANTS: usize = 8;

/// Names of a column that tells channels apart, by their words.
const NAMES: [&str; 12] = [
    "ch", "chan", "channel", "id", "kanal", "name", "sensor", "series", "signal", "trace",
    "variable", "voie",
];

/// The labels of a column while the same ones repeat in one order.
struct Labels {
    column: usize,
    /// Those of the first instant; complete once one came again.
    first: Vec<Vec<u8>>,
    is_complete: bool,
    rows: usize,
    /// True while each instant has one stamp, where the table has any.
    is_stamped: bool,
}

impl Labels {
    /// Takes the label of the next row; false once it breaks the order.
    fn take(&mut self, label: &[u8]) -> bool {
        let row = self.rows;
        self.rows += 1;
        if !self.is_complete {
            self.is_complete = self.first.first().is_some_and(|first| first == label);
            if !self.is_complete {
                let is_new = !self.first.iter().any(|one| one == label);
                self.first.push(label.to_vec());
                return is_new && self.first.len() <= LABELS && !label.is_empty();
            }
        }
        self.first.len() > 1 && self.first[row % self.first.len()] == label
    }

    /// True if the row just taken is the first of its instant.
    fn begins_instant(&self) -> bool {
        self.is_complete && (self.rows - 1).is_multiple_of(self.first.len())
    }
}

/// Refuses a table of one value a row whose labels repeat in one order: words, or numbers beside stamps of which
/// each stands once for every label, or below a name such as `Sensor`.
pub(super) fn refuse(text: &[u8], layout: &TableLayout, task: ReadTask) -> Result<(), Error> {
    let is_clock = |index: usize| layout.is_named_clock(index) || layout.worded[index];
    let stamps = (0..layout.columns.len()).find(|index| is_clock(*index));
    let is_named = |index: usize| {
        let words = channel_name::words(&layout.columns[index].label);
        words.iter().any(|word| NAMES.contains(&word.as_str()))
    };
    let is_candidate = |index: &usize| {
        let column = &layout.columns[*index];
        let is_label = !layout.numeric[*index] || is_named(*index) || stamps.is_some();
        is_label
            && !is_clock(*index)
            && column.unit_text.is_none()
            && !column.hints_at_acceleration()
    };
    let labels = |column| Labels {
        column,
        first: Vec::new(),
        is_complete: false,
        rows: 0,
        is_stamped: true,
    };
    let candidates = (0..layout.columns.len()).filter(is_candidate);
    let mut candidates: Vec<Labels> = candidates.map(labels).collect();
    if candidates.is_empty() {
        return Ok(());
    }
    let mut records = layout.records(text, task.limits)?;
    let mut stamp: Vec<u8> = Vec::new();
    while let Some(row) = records.next()? {
        let cell = |index: usize| row.get(index).unwrap_or_default().trim_ascii();
        candidates.retain_mut(|labels| labels.take(cell(labels.column)));
        if candidates.is_empty() {
            return Ok(());
        }
        if let Some(index) = stamps {
            let is_same = stamp == cell(index);
            for labels in &mut candidates {
                // Before the first label comes again each row may be of one instant.
                let begins = labels.rows == 1 || labels.begins_instant();
                labels.is_stamped &= begins != is_same;
            }
            stamp.clear();
            stamp.extend_from_slice(cell(index));
        }
    }
    let is_long = |labels: &&Labels| {
        let column = labels.column;
        let is_told_apart = match layout.numeric[column] {
            true => is_named(column) || (stamps.is_some() && labels.is_stamped),
            false => is_named(column) || stamps.is_none() || labels.is_stamped,
        };
        labels.is_complete && labels.rows >= INSTANTS * labels.first.len() && is_told_apart
    };
    let Some(found) = candidates.iter().find(is_long) else {
        return Ok(());
    };
    let shown_labels = found.first.iter().take(4);
    let shown_labels: Vec<String> = shown_labels
        .map(|label| format!("`{}`", shown(label)))
        .collect();
    let more = match found.first.len() {
        0..=4 => "",
        _ => " and so on",
    };
    let name = &layout.columns[found.column].name;
    let first = shown(&found.first[0]);
    let is_number = found.first.iter().all(|label| number::is_numeric(label));
    let error = Error::malformed(
        "one row for each instant",
        format!(
            "{} channels below one another, told apart by `{name}`: {}{more}",
            found.first.len(),
            shown_labels.join(", ")
        ),
        format!(
            "export a column for each; or keep the rows of one, as `grep` does with {}, in a file of its own",
            match is_number {
                true => format!("the cell {first}"),
                false => format!("`{first}`"),
            }
        ),
    );
    Err(error.at(Place::default().column(found.column as u64 + 1)))
}
