//! The channels among which `--channel` has to choose, each with its shape and the command.

use super::replay::quoted;
use crate::error::{Candidate, Error, ErrorKind};
use crate::recording::{self, Channel, Limits, ReadOptions, Selection, Source};
use crate::report::{escape, sparkline};
use std::fmt::Write as _;
use std::path::Path;

/// Width of a sparkline in characters.
const SPARK_WIDTH: usize = 32;

/// Draws a channel's shape in a line of text.
pub(super) fn spark(values: &[f64]) -> String {
    sparkline::render(values, SPARK_WIDTH)
}

/// A channel to choose.
#[derive(Debug)]
pub(super) struct Offer {
    /// What `--channel` takes for it.
    pub(super) channel: String,
    /// Its shape; empty where it is not sure which of the channels read is meant.
    spark: String,
}

/// Returns the channels that a refusal asks to choose from, if it does, drawn where they are
/// among `channels`.
pub(super) fn offers(error: &Error, channels: &[Channel]) -> Vec<Offer> {
    let ErrorKind::AmbiguousChannel { candidates } = error.kind() else {
        return Vec::new();
    };
    let candidates = &candidates.0;
    let mut offers = Vec::new();
    for (index, candidate) in candidates.iter().enumerate() {
        let Some(asked_as) = &candidate.asked_as else {
            continue;
        };
        let twins = |others: &[Candidate]| {
            let same = |other: &&Candidate| other.name == candidate.name;
            others.iter().filter(same).count()
        };
        // Those of one name come in one order, but only where none of them was left out.
        let same: Vec<&Channel> = channels
            .iter()
            .filter(|channel| channel.name == candidate.name)
            .collect();
        let channel = (same.len() == twins(candidates))
            .then(|| same.get(twins(&candidates[..index])))
            .flatten();
        offers.push(Offer {
            channel: asked_as.clone(),
            spark: channel.map_or_else(String::new, |channel| spark(&channel.values)),
        });
    }
    offers
}

/// Returns a line for each channel to choose: the command that takes it, and its shape.
pub(super) fn lines(recording: &Path, offers: &[Offer]) -> String {
    let mut text = String::new();
    let recording = quoted(&recording.to_string_lossy());
    for offer in offers {
        let _ = writeln!(
            text,
            "  choose: latchgate replay {} --channel {}  {}",
            escape::terminal(&recording),
            escape::terminal(&quoted(&offer.channel)),
            offer.spark
        );
    }
    text
}

/// Returns what to add to a refusal: the channels to choose from, where several could be meant
/// and the recording can be read again to draw them.
pub(super) fn of_refusal(
    error: &Error,
    recording: &Path,
    source: &Source,
    options: &ReadOptions,
    limits: &Limits,
) -> Option<String> {
    if !matches!(error.kind(), ErrorKind::AmbiguousChannel { .. }) || *source == Source::Stdin {
        return None;
    }
    let all = recording::read(source, options, Selection::Every, limits);
    let offers = offers(error, all.as_ref().map_or(&[], |all| &all.channels));
    let lines = lines(recording, &offers);
    Some(lines.trim_end().to_string()).filter(|lines| !lines.is_empty())
}
