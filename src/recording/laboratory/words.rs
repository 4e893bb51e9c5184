//! The words that laboratories use, in capitals.

use crate::recording::words::{Phrases, Words, phrases, word_list};
use std::sync::LazyLock;

/// Words that take the worth from a sample. Umlauts are written out, as in all lists here.
pub(super) static FAULTS: Words = word_list!("validity-faults");

/// What carries a signal.
static CARRIERS: Words = word_list!("validity-carriers");

/// Successions of words, each one of several, that take the worth from a sample.
pub(super) static FAULTY_PHRASES: Phrases = LazyLock::new(|| {
    phrases(
        word_list!(@text "validity-faulty-phrases"),
        &[
            ("carriers", &CARRIERS),
            ("counted", &COUNTED),
            ("not-kept", &NOT_KEPT),
        ],
    )
});

/// What a recorder counts.
pub(super) static COUNTED: Words = word_list!("validity-counted");

/// What becomes of those that are not in the record.
static NOT_KEPT: Words = word_list!("validity-not-kept");

/// Words that take the worth from a sample if they are all that is said beside it.
pub(super) static FAULTS_ALONE: Words = word_list!("validity-faults-alone");

/// Words by whose misspellings a fault is known: "QUESTIONALBE".
pub(super) static OFTEN_MISSPELT: Words = word_list!("validity-often-misspelt");

/// Successions of words that are worth a look: whether the samples were mended is not said.
pub(super) static DOUBTFUL_PHRASES: Phrases =
    LazyLock::new(|| phrases(word_list!(@text "validity-doubtful-phrases"), &[]));

/// Words between "only" and the time for which samples are good: "USE ONLY THE FIRST 30 MS".
pub(super) static UP_TO: Words = word_list!("validity-up-to");

/// Words that show that it is the samples of which there are "only" some.
pub(super) static OF_SAMPLES: Words = word_list!("validity-of-samples");

/// Words for what is worth a look.
pub(super) static DOUBTS: Words = word_list!("validity-doubts");

/// Words for samples that can be used.
pub(super) static GOOD: Words = word_list!("validity-good");

/// Words whose denial takes the worth from the samples: "NO DATA", "DO NOT USE".
pub(super) static NEEDED: Words = word_list!("validity-needed");

/// Words whose denial does so if it is the samples that are spoken of: "DATA NOT RECORDED",
/// but not "SERIAL NUMBER NOT RECORDED".
pub(super) static NEEDED_OF_DATA: Words = word_list!("validity-needed-of-data");

/// What is spoken of, if it is the samples.
pub(super) static DATA: Words = word_list!("validity-data");

/// What may well be missing: "NO DATA LOST", "NO SIGNAL CONDITIONING".
pub(super) static MAY_BE_MISSING: Words = word_list!("validity-may-be-missing");

/// Words that deny the next one.
pub(super) static DENIALS: Words = word_list!("validity-denials");

/// Words that stand between a denial and what it denies.
pub(super) static BETWEEN: Words = word_list!("validity-between");

/// Words that point to the time before an instant.
pub(super) static BEFORE: Words = word_list!("validity-before");

/// Words that set a limit to what is good.
pub(super) static LIMITING: Words = word_list!("validity-limiting");

/// Words after which an instant stands.
pub(super) static AT: Words = word_list!("validity-at");

/// Units that show that a number is no instant.
pub(super) static OTHER_UNITS: Words = word_list!("validity-other-units");

/// Words between the two ends of a stretch of time.
pub(super) static STRETCH: Words = word_list!("validity-between-ends");

/// Words that fill the place of a comment.
pub(super) static NO_COMMENTS: Words = word_list!("validity-no-comments");
