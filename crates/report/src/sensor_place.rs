//! The sensor's place and the factors to the latch, in words.

use latchgate_document::blocks::{RecordingBlock, SiblingBlock, TransferBlock};
use latchgate_document::number::exact;

/// Returns the place of the sensor and the factors between it and the latch with who states them; `None` where
/// neither is known.
pub(super) fn sensor_place(
    recording: &RecordingBlock,
    transfer: Option<&TransferBlock>,
) -> Option<String> {
    let place = recording.place.map(|place| place.name().to_string());
    let Some(block) = transfer else {
        return place;
    };
    let place = place.unwrap_or_else(|| "not known".into());
    let source = block.source.name();
    Some(match block.judged.as_slice() {
        [factor] => format!(
            "{place}; factor {} to the latch, stated by {source}",
            exact(*factor)
        ),
        several => format!(
            "{place}; factor {} to {} to the latch, stated by {source}; {} judged, shown is the worst, {}",
            exact(block.from),
            exact(block.to),
            several.len(),
            exact(block.worst)
        ),
    })
}

/// Returns the channels that were judged together, each with its answer; `None` where one was judged alone.
pub(super) fn siblings(siblings: &[SiblingBlock]) -> Option<String> {
    let each = siblings.iter().map(|sibling| {
        let channel = sibling.channel.as_deref().unwrap_or("not read");
        format!("{channel}: {}", sibling.answer.name())
    });
    let each: Vec<String> = each.collect();
    (!each.is_empty()).then(|| format!("{}; shown is the worst", each.join(", ")))
}
