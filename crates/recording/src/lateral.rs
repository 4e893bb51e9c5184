//! Which of several named columns is the lateral acceleration.

use super::channel_name::ChannelName;
use super::{Channel, Finding};
use crate::error::{Candidate, Candidates, Error, ErrorKind};

/// True if a channel that was read measures lateral acceleration, by its name, its code or
/// its sensor's axis.
pub fn is_lateral(channel: &Channel) -> bool {
    let named = |name: &str| ChannelName::from_header(name, 1).doubt().is_none();
    let name = channel
        .name
        .rsplit_once(TWIN)
        .map_or(&*channel.name, |(name, _)| name);
    let axis = |text: &str| {
        text.split_whitespace()
            .any(|word| matches!(word, "YL" | "YG" | "Y"))
    };
    let place = channel.stated.location.as_deref();
    channel.unit.is_some()
        && (named(name)
            || named(name.rsplit(['/', ':']).next().unwrap_or(""))
            || place.is_some_and(|place| axis(place) || named(place)))
}

/// What tells the channels of a topic that was recorded twice from one another.
const TWIN: &str = " (channel id ";

/// Returns what stands behind the name of a topic that was recorded twice.
pub(super) fn twin_mark(id: u16) -> String {
    format!("{TWIN}{id})")
}

/// Returns a name without the mark of a twin; `None` if it is that of another channel id.
pub(super) fn without_twin_mark(name: &str, id: u16) -> Option<&str> {
    match name.rsplit_once(TWIN) {
        Some((start, rest)) => (*rest == format!("{id})")).then_some(start),
        None => Some(name),
    }
}

/// A channel to choose from, as its words or its codes describe it.
pub(super) struct ChannelOffer {
    /// How it is offered, with what keeps it from being taken unasked.
    candidate: Candidate,
    /// True if unit or code say another quantity.
    is_foreign: bool,
    /// True if something speaks against it, not only nothing for it.
    contradicted: bool,
    /// True if a word, unit or code says acceleration or the axis, and both.
    hints: bool,
    is_lateral: bool,
    is_filtered: bool,
}

impl ChannelOffer {
    /// Describes a channel by its code.
    pub(super) fn of_code(name: String, is_acceleration: bool, doubt: Option<String>) -> Self {
        Self {
            is_foreign: !is_acceleration,
            contradicted: !is_acceleration || doubt.is_some(),
            hints: true,
            is_lateral: true,
            is_filtered: false,
            candidate: Candidate::named(name).doubted(doubt),
        }
    }

    /// Describes columns by their words, each with its number, which counts what `counted` says.
    pub(super) fn of_words(columns: &[(usize, &ChannelName)], counted: &str) -> Vec<Self> {
        let one = |(number, column): &(usize, &ChannelName)| {
            let same = |(_, other): &&(usize, &ChannelName)| other.name == column.name;
            let candidate = match columns.iter().filter(same).count() {
                1 => Candidate::named(&column.name),
                _ => Candidate::numbered(&column.name, counted, *number),
            };
            Self {
                candidate: candidate.doubted(column.doubt()),
                is_foreign: column.has_foreign_unit(),
                contradicted: column.contradiction().is_some(),
                hints: column.hints_at_acceleration(),
                is_lateral: column.says_lateral_acceleration(),
                is_filtered: column.says_filtered(),
            }
        };
        columns.iter().map(one).collect()
    }
}

/// Takes the one channel that is plainly a lateral acceleration of the structure, or the only one if
/// nothing speaks against it; a filtered one only where nothing else could be meant. Anything else
/// that is an acceleration, or could be one, is offered with what raises the doubt.
pub(super) fn take(
    all: &[ChannelOffer],
    known: String,
) -> Result<(usize, Option<Finding>), ErrorKind> {
    if let [only] = all
        && !only.contradicted
    {
        return Ok((0, None));
    }
    let of = |wanted: &dyn Fn(&ChannelOffer) -> bool| -> Vec<usize> {
        let fits = |index: &usize| !all[*index].is_foreign && wanted(&all[*index]);
        (0..all.len()).filter(fits).collect()
    };
    let rivals = of(&|_| true).len();
    let plain = of(&|one| one.candidate.doubt.is_none());
    let mut offered = of(&|one| one.candidate.doubt.is_some());
    // Without a unit a column could be anything, so that those that say more come alone.
    if offered.iter().any(|index| all[*index].hints) {
        offered.retain(|index| all[*index].hints);
    }
    let filtered = |index: &usize| all[*index].is_filtered;
    match plain.as_slice() {
        // What was filtered does not stand in for what was not.
        [only] if !filtered(only) || offered.iter().all(filtered) => {
            let text = format!(
                "`{}` was chosen of {rivals} channels: it alone is clearly a lateral acceleration \
                 of the structure",
                all[*only].candidate.name
            );
            let finding = (rivals > 1).then(|| Finding::info("channel-chosen", text));
            return Ok((*only, finding));
        }
        [] | [_] => offered.extend(plain),
        _ => offered = plain,
    }
    if offered.is_empty() {
        let why = match all {
            [] => "",
            _ => {
                " (by unit or code none is an acceleration; for volts, counts and the like, state \
                 the setting `sensitivity` = '20 g/V')"
            }
        };
        let known = format!("{known}{why}");
        return Err(ErrorKind::NoChannel { known });
    }
    offered.sort_unstable_by_key(|index| (!all[*index].is_lateral, *index));
    Err(ambiguous(all, &offered))
}

/// Returns the one channel among those `found` for the name that was `wanted`.
pub(super) fn named(wanted: &str, found: &[usize], all: &[ChannelOffer]) -> Result<usize, Error> {
    match found {
        [only] => Ok(*only),
        [] => Err(ErrorKind::NoSuchChannel {
            requested: wanted.to_string(),
            known: listed(all),
        }
        .into()),
        several => Err(ambiguous(all, several).into()),
    }
}

/// Lists the accelerations, or all channels where there is none.
pub(super) fn listed(all: &[ChannelOffer]) -> String {
    let none = all.iter().all(|one| one.is_foreign);
    let shown = all.iter().filter(|one| none || !one.is_foreign);
    let plain = |one: &ChannelOffer| one.candidate.clone().doubted(None);
    Candidates(shown.map(plain).collect()).to_string()
}

fn ambiguous(all: &[ChannelOffer], several: &[usize]) -> ErrorKind {
    let candidates = several.iter().map(|index| all[*index].candidate.clone());
    ErrorKind::AmbiguousChannel {
        candidates: Candidates(candidates.collect()),
    }
}
