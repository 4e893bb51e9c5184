//! Which of several named columns is the lateral acceleration.

use super::csv::header::Column;
use super::{Channel, Finding};
use crate::error::{Candidate, Candidates, ErrorKind};

/// Tells whether a channel that was read measures lateral acceleration, by its name, its code or
/// its sensor's axis.
#[must_use]
pub fn is_lateral(channel: &Channel) -> bool {
    let named = |name: &str| Column::from_header(name, 1).says_lateral_acceleration();
    let axis = |text: &str| {
        text.split_whitespace()
            .any(|word| matches!(word, "YL" | "YG" | "Y"))
    };
    let place = channel.stated.location.as_deref();
    channel.unit.is_some()
        && (named(&channel.name)
            || named(channel.name.rsplit(['/', ':']).next().unwrap_or(""))
            || place.is_some_and(|place| axis(place) || named(place)))
}

/// Chooses among columns of numbers, each with its number, which counts what `counted` says. Taken is the only one; else the one whose name says
/// lateral acceleration; else the only one with a unit of acceleration among columns that all
/// state their units. A name that says another axis, a dummy, a barrier or something computed is
/// never taken, and a filtered channel not where an unfiltered one may be meant. Whatever was weighed is said in a finding.
///
/// # Errors
///
/// [`ErrorKind::AmbiguousChannel`] with the names of several candidates,
/// [`ErrorKind::NoChannel`] with all names where nothing tells.
pub(super) fn choose(
    columns: &[(usize, &Column)],
    counted: &str,
    known: &str,
) -> Result<(usize, Option<Finding>), ErrorKind> {
    let none = || ErrorKind::NoChannel {
        known: known.to_string(),
    };
    let other = |column: &Column| column.not_lateral_finding().is_some();
    if let [(_, only)] = columns {
        return if other(only) {
            Err(none())
        } else {
            Ok((0, None))
        };
    }
    let of = |wanted: &dyn Fn(&Column) -> bool| -> Vec<usize> {
        (0..columns.len())
            .filter(|i| wanted(columns[*i].1))
            .collect()
    };
    let chosen = |index: usize, reason: &str| {
        let (name, of) = (&columns[index].1.name, columns.len());
        let text = format!("`{name}` was chosen among {of} channels, since {reason}");
        (index, Some(Finding::info("channel-chosen", text)))
    };
    let named = named_lateral(columns);
    match named.as_slice() {
        [only] => Ok(chosen(*only, "its name alone says lateral acceleration")),
        [] => {
            let accelerations = of(&|column| column.unit.is_some());
            let silent = of(&|column| column.unit.is_none() && !column.has_foreign_unit());
            match accelerations.as_slice() {
                [only] if silent.is_empty() && !other(columns[*only].1) => Ok(chosen(
                    *only,
                    "it alone has a unit of acceleration; its name does not say that it is lateral",
                )),
                _ => Err(none()),
            }
        }
        several => {
            let one = |index: &usize| {
                let (number, column) = columns[*index];
                let same = |(_, other): &&(usize, &Column)| other.name == column.name;
                if columns.iter().filter(same).count() > 1 {
                    Candidate::numbered(&column.name, counted, number)
                } else {
                    Candidate::named(&column.name)
                }
            };
            Err(ErrorKind::AmbiguousChannel {
                candidates: Candidates(several.iter().map(one).collect()),
            })
        }
    }
}

/// Returns the columns whose names say lateral acceleration, and beside a filtered one those that
/// may be the same without a filter.
fn named_lateral(columns: &[(usize, &Column)]) -> Vec<usize> {
    let named: Vec<usize> = (0..columns.len())
        .filter(|i| {
            let column = columns[*i].1;
            column.says_lateral_acceleration() && column.not_lateral_finding().is_none()
        })
        .collect();
    // Redundant sensors count only where no primary one does.
    let primary: Vec<usize> = named
        .iter()
        .copied()
        .filter(|i| !columns[*i].1.says_redundant())
        .collect();
    let mut named = if primary.is_empty() { named } else { primary };
    // What was filtered does not stand in for what was not.
    if let [only] = named.as_slice()
        && columns[*only].1.says_filtered()
    {
        let taken = columns[*only].1;
        let raw = (0..columns.len()).filter(|i| {
            let column = columns[*i].1;
            !column.says_filtered()
                && column.not_lateral_finding().is_none()
                && !column.has_foreign_unit()
                && (column.unit.is_some()
                    || column.says_lateral_acceleration()
                    || column.is_short_for(taken))
        });
        named.extend(raw);
        named.sort_unstable();
    }
    named
}
