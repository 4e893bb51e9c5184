//! Names of places: what is not the structure of the struck vehicle.

use super::words;
use crate::recording::mme::code::Code;

/// Words for places in a dummy, on a barrier or on the test rig.
const OFF_THE_STRUCTURE: &[&str] = &[
    // Dummies and their parts.
    "dummy",
    "atd",
    "hybrid",
    "h3",
    "hiii",
    "sid",
    "sid2s",
    "siniis",
    "sidiis",
    "eurosid",
    "worldsid",
    "world",
    "es2",
    "es2re",
    "2re",
    "biorid",
    "thor",
    "puppe",
    "head",
    "skull",
    "face",
    "neck",
    "chest",
    "torso",
    "thorax",
    "thoracic",
    "spine",
    "spinal",
    "lumbar",
    "sternum",
    "rib",
    "ribs",
    "shoulder",
    "clavicle",
    "abdomen",
    "pelvis",
    "pelvic",
    "pubic",
    "sacrum",
    "iliac",
    "ilium",
    "hip",
    "femur",
    "knee",
    "tibia",
    "leg",
    "helmet",
    "kopf",
    "hals",
    "brust",
    "becken",
    "hüfte",
    "rippe",
    "rippen",
    "schulter",
    "wirbel",
    "wirbelsäule",
    "bauch",
    "helm",
    // The same as channel codes abbreviate them.
    "pelv",
    "thsp",
    "chst",
    "spin",
    "femr",
    "tibi",
    "abdo",
    "shld",
    "barr",
    // What strikes, carries or drives the vehicle.
    "barrier",
    "mdb",
    "amdb",
    "barriere",
    "sled",
    "schlitten",
    "trolley",
    "cart",
    "impactor",
    "impaktor",
    "striker",
    "striking",
    "bullet",
    "pole",
    "pfahl",
    "engine",
    "motor",
    "farside",
    "opposite",
    "gegenüber",
];

/// Words for persons; `driver door` is a door all the same.
const PERSONS: &[&str] = &[
    "driver",
    "passenger",
    "occupant",
    "fahrer",
    "beifahrer",
    "insasse",
];

/// Words that make a place of the vehicle of a person's.
const AT_THE_VEHICLE: &[&str] = &[
    "door",
    "doors",
    "pillar",
    "bpillar",
    "apillar",
    "cpillar",
    "sill",
    "rocker",
    "rail",
    "floor",
    "roof",
    "side",
    "seat",
    "lock",
    "latch",
    "compartment",
    "tür",
    "tuer",
    "säule",
    "saeule",
    "schweller",
    "seite",
    "schloss",
    "türschloss",
];

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
    has(OFF_THE_STRUCTURE)
        || words.iter().any(|word| is_vertebra(word))
        || (has(PERSONS) && !has(AT_THE_VEHICLE))
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
