//! Which of several named columns is the lateral acceleration.

use super::csv::header::Column;
use super::{Channel, Finding};
use crate::error::{Candidate, Candidates, Error, ErrorKind};

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

/// A channel whose codes say what it is.
pub(super) struct CodedChannel {
    pub(super) name: String,
    pub(super) is_acceleration: bool,
    /// What keeps it from being taken unasked.
    pub(super) doubt: Option<String>,
}

/// Takes the one channel that is plainly a lateral acceleration of the structure. Of several a
/// person chooses, and where there is none among all other accelerations.
///
/// # Errors
///
/// [`ErrorKind::AmbiguousChannel`] with those to choose from, [`ErrorKind::NoChannel`] where no
/// channel is an acceleration.
pub(super) fn take(coded: &[CodedChannel]) -> Result<(usize, Option<Finding>), ErrorKind> {
    let of = |wanted: &dyn Fn(&CodedChannel) -> bool| -> Vec<usize> {
        (0..coded.len())
            .filter(|index| wanted(&coded[*index]))
            .collect()
    };
    let all = of(&|one| one.is_acceleration);
    let plain = of(&|one| one.is_acceleration && one.doubt.is_none());
    match plain.as_slice() {
        [only] => {
            let text = format!(
                "{} was chosen among {} channels of acceleration as the one lateral acceleration \
                 of the structure",
                coded[*only].name,
                all.len()
            );
            let finding = Finding::info("channel-chosen", text);
            Ok((*only, (all.len() > 1).then_some(finding)))
        }
        [] => Err(ErrorKind::NoChannel {
            known: listed(coded),
        }),
        several => Err(ambiguous(coded, several)),
    }
}

/// Returns the one channel among those `found` for the name that was `wanted`.
///
/// # Errors
///
/// [`ErrorKind::NoSuchChannel`] and [`ErrorKind::AmbiguousChannel`].
pub(super) fn named(wanted: &str, found: &[usize], coded: &[CodedChannel]) -> Result<usize, Error> {
    match found {
        [only] => Ok(*only),
        [] => Err(ErrorKind::NoSuchChannel {
            wanted: wanted.to_string(),
            known: listed(coded),
        }
        .into()),
        several => Err(ambiguous(coded, several).into()),
    }
}

fn listed(coded: &[CodedChannel]) -> String {
    let any = coded.iter().any(|one| one.is_acceleration);
    let shown = coded.iter().filter(|one| one.is_acceleration || !any);
    Candidates::named(shown.map(|one| one.name.as_str())).to_string()
}

fn ambiguous(coded: &[CodedChannel], several: &[usize]) -> ErrorKind {
    ErrorKind::AmbiguousChannel {
        candidates: Candidates::named(several.iter().map(|index| coded[*index].name.as_str())),
    }
}
