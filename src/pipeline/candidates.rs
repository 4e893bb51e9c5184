//! The channels to choose from where several could be meant, each with its shape.

use latchgate_recording::Channel;
use latchgate_recording::error::{Candidate, Error, ErrorKind};
use latchgate_report::sparkline;
use serde::{Deserialize, Serialize};

/// Width of a sparkline in characters.
const SPARK_WIDTH: usize = 32;

/// Draws a channel's shape in a line of text.
pub(super) fn spark(values: &[f64]) -> String {
    sparkline::render(values, SPARK_WIDTH)
}

/// A channel to choose.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Offer {
    /// What the setting `channel` takes for it.
    pub channel: String,
    /// Its shape; empty where it is not sure which of the channels read is meant.
    pub spark: String,
    /// What keeps it from being taken unasked.
    pub doubt: Option<String>,
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
        let Some(setting_value) = &candidate.setting_value else {
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
            channel: setting_value.clone(),
            spark: channel.map_or_else(String::new, |channel| spark(&channel.values)),
            doubt: candidate.doubt.clone(),
        });
    }
    offers
}
