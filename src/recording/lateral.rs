//! Which of several named columns is the lateral acceleration.

use super::csv::header::Column;
use super::{Channel, Finding};
use crate::error::{Candidate, Candidates, Error, ErrorKind};

/// Tells whether a channel that was read measures lateral acceleration, by its name, its code or
/// its sensor's axis.
#[must_use]
pub fn is_lateral(channel: &Channel) -> bool {
    let named = |name: &str| Column::from_header(name, 1).doubt().is_none();
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

/// Chooses among columns, each with its number, which counts what `counted` says. Taken is the one
/// whose name is plainly that of a lateral acceleration of the structure, or the only one if
/// nothing speaks against it; a filtered one only where nothing else could be meant. Anything else that is
/// an acceleration by its unit, or could be one, is offered with what raises the doubt.
///
/// # Errors
///
/// [`ErrorKind::AmbiguousChannel`] with the candidates, [`ErrorKind::NoChannel`] with all names
/// where every unit says another quantity.
pub(super) fn choose(
    columns: &[(usize, &Column)],
    counted: &str,
    known: &str,
) -> Result<(usize, Option<Finding>), ErrorKind> {
    if let [(_, only)] = columns
        && only.contradiction().is_none()
    {
        return Ok((0, None));
    }
    let of = |wanted: &dyn Fn(&Column) -> bool| -> Vec<usize> {
        (0..columns.len())
            .filter(|i| wanted(columns[*i].1))
            .collect()
    };
    let plain = of(&|column| column.doubt().is_none());
    let mut offered = of(&|column| column.doubt().is_some() && !column.has_foreign_unit());
    // Without a unit a column could be anything, so that those that say more come alone.
    let says_more = |i: &usize| columns[*i].1.hints_at_acceleration();
    if offered.iter().any(says_more) {
        offered.retain(says_more);
    }
    match plain.as_slice() {
        // What was filtered does not stand in for what was not.
        [only]
            if !columns[*only].1.says_filtered()
                || offered.iter().all(|i| columns[*i].1.says_filtered()) =>
        {
            let (name, of) = (&columns[*only].1.name, columns.len());
            let text = format!(
                "`{name}` was chosen among {of} channels, since its name alone is plainly that of \
                 a lateral acceleration of the structure"
            );
            let finding = (of > 1).then(|| Finding::info("channel-chosen", text));
            return Ok((*only, finding));
        }
        [] | [_] => offered.extend(plain),
        _ => offered = plain,
    }
    if offered.is_empty() {
        let all = !columns.is_empty() && columns.iter().all(|(_, one)| one.has_foreign_unit());
        let why = if all {
            " (by its unit none is an acceleration)"
        } else {
            ""
        };
        return Err(ErrorKind::NoChannel {
            known: format!("{known}{why}"),
        });
    }
    offered.sort_unstable_by_key(|i| (!columns[*i].1.says_lateral_acceleration(), *i));
    let one = |index: &usize| {
        let (number, column) = columns[*index];
        let same = |(_, other): &&(usize, &Column)| other.name == column.name;
        let candidate = if columns.iter().filter(same).count() > 1 {
            Candidate::numbered(&column.name, counted, number)
        } else {
            Candidate::named(&column.name)
        };
        candidate.doubted(column.doubt())
    };
    Err(ErrorKind::AmbiguousChannel {
        candidates: Candidates(offered.iter().map(one).collect()),
    })
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
        [] if all.is_empty() => Err(ErrorKind::NoChannel {
            known: listed(coded),
        }),
        [] => Err(ambiguous(coded, &all)),
        several => Err(ambiguous(coded, several)),
    }
}

/// Returns the one channel among those `found` for the name that was `wanted`.
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
    let candidate = |index: &usize| {
        let one = &coded[*index];
        Candidate::named(&one.name).doubted(one.doubt.clone())
    };
    ErrorKind::AmbiguousChannel {
        candidates: Candidates(several.iter().map(candidate).collect()),
    }
}
