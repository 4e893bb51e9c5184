//! Names of places: what is not the structure of the struck vehicle.

use super::words;
use crate::recording::mme::code::Code;
use crate::recording::words::{Words, word_list};

/// Words for places in a dummy, on a barrier or on the test rig.
static OFF_THE_STRUCTURE: Words = word_list!("name-off-the-structure");

/// Words for persons; `driver door` is a door all the same.
static PERSONS: Words = word_list!("name-persons");

/// Words that make a place of the vehicle of a person's.
static AT_THE_VEHICLE: Words = word_list!("name-at-the-vehicle");

/// What an ISO/TS 13499 channel code in a name says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Coded {
    /// A lateral acceleration of the structure.
    Lateral,
    /// An acceleration of the structure along another axis.
    OtherAxis,
    /// Another quantity.
    OtherQuantity,
    /// A dummy, a barrier, or a place that is not known.
    Elsewhere,
}

/// Finds a channel code in a name: 16 capitals and digits that state a known dimension.
pub(super) fn code_in(label: &str) -> Option<Code> {
    /// Dimensions beside AC: velocity, displacement, force, moment, angular motion.
    const OTHERS: &[&str] = &["VE", "DS", "FO", "MO", "AV", "AA", "AN"];
    label
        .split(|c: char| !c.is_alphanumeric() && c != '?')
        .filter(|part| part.len() == 16)
        .filter(|part| {
            !part.contains(|c: char| c.is_ascii_lowercase())
                && part.contains(|c: char| c.is_ascii_digit() || c == '?')
        })
        .find_map(|part| {
            let axis = part.get(14..15)?;
            let known = matches!(axis, "X" | "Y" | "Z" | "R" | "1" | "2" | "3" | "0");
            let code = Code::new(part)?;
            (known && (code.is_acceleration() || OTHERS.contains(&part.get(12..14)?)))
                .then_some(code)
        })
}

/// Tells what the channel code in a name says, if there is one.
pub(super) fn coded(label: &str) -> Option<Coded> {
    let code = code_in(label)?;
    Some(if !code.is_acceleration() {
        Coded::OtherQuantity
    } else if !code.is_structure() {
        Coded::Elsewhere
    } else if !code.is_lateral() {
        Coded::OtherAxis
    } else {
        Coded::Lateral
    })
}

/// Tells whether a name says a place that is not the structure of the struck vehicle.
pub(super) fn says_elsewhere(label: &str) -> bool {
    let words = words(label);
    let has = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
    let follow = |first: &str, second: &str| {
        words
            .windows(2)
            .any(|pair| pair[0] == first && pair[1] == second)
    };
    has(&OFF_THE_STRUCTURE)
        || words.iter().any(|word| is_vertebra(word))
        || (has(&PERSONS) && !has(&AT_THE_VEHICLE))
        || follow("es", "2")
        || follow("far", "side")
        || coded(label) == Some(Coded::Elsewhere)
}

/// Tells whether a word is a vertebra of a dummy's spine, `T1` to `T12`. That it may number a
/// sensor does not make it safe to take.
fn is_vertebra(word: &str) -> bool {
    word.strip_prefix('t')
        .filter(|number| !number.starts_with('0'))
        .and_then(|number| number.parse::<u8>().ok())
        .is_some_and(|number| (1..=12).contains(&number))
}
