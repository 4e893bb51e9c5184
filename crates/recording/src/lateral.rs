//! The choice of the lateral acceleration among several named columns.

use super::channel_name::{ChannelName, axis_of_word, without_axis, words};
use super::code::{Code, VehicleSide};
use super::words::{Words, word_list};
use super::{Channel, Finding, place_of};
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

/// Axis of the vehicle along which a channel measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ChannelAxis {
    /// X, Y or Z.
    pub letter: char,
    /// True if its sign is against SAE J211, by its code.
    pub is_reversed: bool,
}

/// Returns the axis that a channel's code, the axis of its sensor or its name states; `None` if none or several do.
pub fn axis_of(channel: &Channel) -> Option<ChannelAxis> {
    if let Some(code) = code_of(channel) {
        let letter = code.axis()?.chars().next()?;
        return Some(ChannelAxis {
            letter,
            is_reversed: code.sign_finding().is_some(),
        });
    }
    let mut letters: Vec<char> = words_of(channel)
        .iter()
        .filter_map(|word| axis_of_word(word))
        .collect();
    letters.sort_unstable();
    letters.dedup();
    match letters.as_slice() {
        [letter] => Some(ChannelAxis {
            letter: *letter,
            is_reversed: false,
        }),
        _ => None,
    }
}

/// Tells whether code, place or name say that two channels are of one place: all but the axis is alike.
pub fn is_same_place(one: &Channel, other: &Channel) -> bool {
    match (code_of(one), code_of(other)) {
        (Some(one), Some(other)) => one.is_same_place(&other),
        (None, None) => {
            // Names beside stated places count curves.
            let texts = match (&one.stated.location, &other.stated.location) {
                (Some(one), Some(other)) => [one.clone(), other.clone()],
                _ => [label_of(one), label_of(other)],
            };
            let [one, other] = texts.map(|text| -> Vec<String> {
                let words = words(&text);
                words.iter().filter_map(|word| without_axis(word)).collect()
            });
            one == other
        }
        _ => false,
    }
}

/// Returns the side of the vehicle that a channel's code names: `left` or `right`.
pub fn side_of(channel: &Channel) -> Option<&'static str> {
    Some(match code_of(channel)?.side()? {
        VehicleSide::Left => "left",
        VehicleSide::Right => "right",
    })
}

/// Attachments with the side that they name.
static SIDES: Words = word_list!("nhtsa-sides");

/// Returns the side of the vehicle that a channel's code or attachment names.
fn stated_side(channel: &Channel) -> Option<&'static str> {
    let place = channel.stated.location.as_deref().unwrap_or_default();
    let attachment = place.split_whitespace().next().unwrap_or_default();
    let listed = || {
        let mut lines = SIDES.iter().filter_map(|line| line.split_once(' '));
        let line = lines.find(|(name, _)| name.eq_ignore_ascii_case(attachment));
        line.map(|(_, side)| side)
    };
    side_of(channel).or_else(listed)
}

/// True if another channel of a file measures lateral acceleration on the same side of the same vehicle, as far as
/// is known: what is not stated of either counts as alike.
pub fn is_sibling(judged: &Channel, other: &Channel) -> bool {
    let is_judged = judged.name == other.name && judged.values == other.values;
    let doubted = other
        .findings
        .iter()
        .any(|finding| finding.code == "channel-not-lateral");
    let is_alike = |one: Option<String>, other: Option<String>| match (one, other) {
        (Some(one), Some(other)) => one == other,
        _ => true,
    };
    let side = |channel: &Channel| stated_side(channel).map(String::from);
    let vehicle = |channel: &Channel| channel.stated.test.vehicle.clone();
    let object = |channel: &Channel| code_of(channel).map(|code| code.object().to_string());
    // A dummy's head beside a sill is on no structure, and its code says so.
    let is_on_structure = place_of(judged).is_none() || place_of(other).is_some();
    !is_judged
        && !doubted
        && is_lateral(other)
        && is_on_structure
        && is_alike(side(judged), side(other))
        && is_alike(vehicle(judged), vehicle(other))
        && is_alike(object(judged), object(other))
}

/// Returns the code that is a channel's name, without a unit behind it, or its place.
pub(super) fn code_of(channel: &Channel) -> Option<Code> {
    let place = channel.stated.location.as_deref().unwrap_or_default();
    let label = label_of(channel);
    [label.as_str(), place].into_iter().find_map(Code::new)
}

/// Returns the name of a channel without the mark of a twin and without a unit.
fn label_of(channel: &Channel) -> String {
    let name = channel.name.rsplit_once(TWIN);
    let name = name.map_or(&*channel.name, |(name, _)| name);
    ChannelName::from_header(name, 1).label
}

/// Returns the words of a channel's place and name.
fn words_of(channel: &Channel) -> Vec<String> {
    let place = channel.stated.location.as_deref().unwrap_or_default();
    [words(place), words(&label_of(channel))].concat()
}

/// Mark by which the channels of a topic that was recorded twice are distinguished.
const TWIN: &str = " (channel id ";

/// Returns the mark after the name of a topic that was recorded twice.
pub(super) fn twin_mark(id: u16) -> String {
    format!("{TWIN}{id})")
}

/// Returns a name without the mark of a twin; `None` if it is that of another channel id.
pub(super) fn without_twin_mark(name: &str, id: u16) -> Option<&str> {
    match name.rsplit_once(TWIN) {
        Some((start, tail)) => (*tail == format!("{id})")).then_some(start),
        None => Some(name),
    }
}

/// A channel to choose from, as its words or its codes describe it.
pub(super) struct ChannelOffer {
    /// The candidate, with the reason why it is not chosen unless it is named.
    candidate: Candidate,
    /// True if unit or code state another quantity.
    is_foreign: bool,
    /// True if there is evidence against it, not only none for it.
    contradicted: bool,
    /// True if a word, unit or code says acceleration or names the axis.
    hints: bool,
    /// True if it says both.
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

    /// Describes columns by their words, each with its number, of the things that `counted` names.
    pub(super) fn of_words(columns: &[(usize, &ChannelName)], counted: &str) -> Vec<Self> {
        let offer = |(number, column): &(usize, &ChannelName)| {
            let same = |(_, twin): &&(usize, &ChannelName)| twin.name == column.name;
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
        columns.iter().map(offer).collect()
    }
}

/// Chooses the one channel that is plainly a lateral acceleration of the structure, or the only one if
/// there is no evidence against it; a filtered one only where no other could be meant. Any other channel
/// that is an acceleration, or could be one, is offered with the reason for its doubt.
pub(super) fn take(
    offers: &[ChannelOffer],
    known: String,
) -> Result<(usize, Option<Finding>), ErrorKind> {
    if let [only] = offers
        && !only.contradicted
    {
        return Ok((0, None));
    }
    let accelerations = |matches: &dyn Fn(&ChannelOffer) -> bool| -> Vec<usize> {
        let fits = |index: &usize| !offers[*index].is_foreign && matches(&offers[*index]);
        (0..offers.len()).filter(fits).collect()
    };
    let rivals = accelerations(&|_| true).len();
    let plain = accelerations(&|offer| offer.candidate.doubt.is_none());
    let mut offered = accelerations(&|offer| offer.candidate.doubt.is_some());
    // Without a unit a column could be anything, so that those with a hint are offered alone.
    if offered.iter().any(|index| offers[*index].hints) {
        offered.retain(|index| offers[*index].hints);
    }
    let filtered = |index: &usize| offers[*index].is_filtered;
    match plain.as_slice() {
        // A filtered channel must not replace an unfiltered one in silence.
        [only] if !filtered(only) || offered.iter().all(filtered) => {
            let text = format!(
                "`{}` was chosen of {rivals} channels: it alone is clearly a lateral acceleration \
                 of the structure",
                offers[*only].candidate.name
            );
            let finding = (rivals > 1).then(|| Finding::info("channel-chosen", text));
            return Ok((*only, finding));
        }
        [] | [_] => offered.extend(plain),
        _ => offered = plain,
    }
    if offered.is_empty() {
        let why = match offers {
            [] => "",
            _ => {
                " (by unit or code none is an acceleration; for volts, counts and the like, state \
                 the setting `sensitivity` = '20 g/V')"
            }
        };
        let known = format!("{known}{why}");
        return Err(ErrorKind::NoChannel { known });
    }
    offered.sort_unstable_by_key(|index| (!offers[*index].is_lateral, *index));
    Err(ambiguous(offers, &offered))
}

/// Returns the one channel among the `matches` of the `requested` name.
pub(super) fn named(
    requested: &str,
    matches: &[usize],
    offers: &[ChannelOffer],
) -> Result<usize, Error> {
    match matches {
        [only] => Ok(*only),
        [] => Err(ErrorKind::NoSuchChannel {
            requested: requested.to_string(),
            known: listed(offers),
        }
        .into()),
        several => Err(ambiguous(offers, several).into()),
    }
}

/// Lists the accelerations, or all channels where there is none.
pub(super) fn listed(offers: &[ChannelOffer]) -> String {
    let none = offers.iter().all(|offer| offer.is_foreign);
    let shown = offers.iter().filter(|offer| none || !offer.is_foreign);
    let plain = |offer: &ChannelOffer| offer.candidate.clone().doubted(None);
    Candidates(shown.map(plain).collect()).to_string()
}

fn ambiguous(offers: &[ChannelOffer], several: &[usize]) -> ErrorKind {
    let candidates = several.iter().map(|index| offers[*index].candidate.clone());
    ErrorKind::AmbiguousChannel {
        candidates: Candidates(candidates.collect()),
    }
}
