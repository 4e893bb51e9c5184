//! The sensor's place and the factors to the latch, in words.

use crate::words::stated;
use latchgate_document::blocks::{RecordingBlock, SiblingBlock, TransferBlock};
use latchgate_document::number::exact;
use latchgate_verdict::Answer;

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
    let source = stated(block.source.name());
    Some(match block.judged.as_slice() {
        [factor] => format!(
            "{place}; factor {} to the latch, stated {source}",
            exact(*factor)
        ),
        several => format!(
            "{place}; factor {} to {} to the latch, stated {source}; {} judged: {}; shown is {}",
            exact(block.from),
            exact(block.to),
            several.len(),
            by_factor(block),
            exact(block.worst)
        ),
    })
}

/// Returns the answers of the factors, equal neighbours together: `pass at 0.8 to 0.953, fail at 1 to 1.25`.
fn by_factor(block: &TransferBlock) -> String {
    let each: Vec<(&f64, &Answer)> = block.judged.iter().zip(&block.answers).collect();
    let spans = each.chunk_by(|(_, one), (_, next)| one == next);
    let words = spans.filter_map(|span| {
        let ((from, answer), (to, _)) = (span.first()?, span.last()?);
        let until = if span.len() == 1 {
            String::new()
        } else {
            format!(" to {}", exact(**to))
        };
        Some(format!("{} at {}{until}", answer.name(), exact(**from)))
    });
    words.collect::<Vec<_>>().join(", ")
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
