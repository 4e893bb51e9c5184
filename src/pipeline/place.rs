//! The sensor's place and axis: what a pass waits for, and what a verdict at the latch consists of.

use super::answer::RecordingFacts;
use latchgate_document::blocks::TransferBlock;
use latchgate_kernel::model::Design;
use latchgate_recording::card::AcceptedWord;
use latchgate_recording::setting::Setting;
use latchgate_recording::{Channel, Finding, SensorPlace};
use latchgate_verdict::conditioning::Conditioned;
use latchgate_verdict::margin::{Advice, Quantity};
use latchgate_verdict::{Assessment, Reason};
use std::borrow::Cow;

/// Largest direction cosine of another axis on the way of the centre of mass: beyond it one channel does not tell
/// what turns the lever.
const ACROSS_MAX: f64 = 0.02;

/// Factor below which a range is suspected: the two sills of one car differ by up to 8.6.
const FACTOR_LOW: f64 = 0.1;

/// A verdict, at the factor between place and latch that counts.
pub(super) struct Decided<'a> {
    pub(super) assessment: Assessment,
    /// The recording at that factor.
    pub(super) conditioned: Cow<'a, Conditioned>,
    /// The factors, where a person states them.
    pub(super) transfer: Option<TransferBlock>,
}

/// Returns what is to be said of the place of a channel's sensor: that a pass waits for it, or that card and file
/// differ.
pub(super) fn findings(facts: &RecordingFacts, channel: &Channel) -> Vec<Finding> {
    let in_file = latchgate_recording::place_of(channel);
    let code = channel.stated.location.as_ref().unwrap_or(&channel.name);
    let mut findings = Vec::new();
    if let (Some(card), Some(file)) = (facts.place_by_card(), in_file)
        && card != file
    {
        let text = format!(
            "the card places the sensor at the {}, the file at the {}: `{code}`. The card was used. Check which \
             is right",
            card.name(),
            file.name()
        );
        findings.push(Finding::warning("place-overridden", text));
    }
    let stated = facts.request.transfer(&facts.card);
    if let Some((range, _)) = stated
        && range.to() < FACTOR_LOW
    {
        let text = format!(
            "the largest factor from the sensor's place to the latch is {}: the latch is judged under less than a \
             tenth of what the sensor saw. Check {} = {range}",
            range.to(),
            Setting::Transfer
        );
        findings.push(Finding::warning("transfer-low", text));
    }
    let is_formula = facts.card.synthetic || channel.pulse.is_some();
    let place = facts.recording.place;
    let is_at_latch = place.is_some_and(SensorPlace::moves_as_latch);
    if is_formula || is_at_latch || stated.is_some() {
        return findings;
    }
    let what = match place {
        Some(_) => format!("the sensor sits on the body, not at the door or the latch: `{code}`"),
        None => {
            let axis = match facts.axis {
                Some(_) => "",
                None => ", nor along which axis",
            };
            format!(
                "nothing says where the sensor sits, at the latch, on the door or on the body{axis}"
            )
        }
    };
    let text = format!(
        "{what}. A pass needs the range of factors from the sensor's place to the latch, {} = LO..HI; 1 says that \
         both move alike",
        Setting::Transfer
    );
    findings.push(Finding::warning("place", text).needing_word());
    findings
}

/// Returns what is to be said of a channel that is known not to be lateral, for a lever, and of one whose axis nothing
/// tells though a person tells how its place moves.
pub(super) fn axis_finding(facts: &RecordingFacts, design: &Design) -> Option<Finding> {
    let accepted = facts.request.accepts(&facts.card, AcceptedWord::Axis);
    if facts.card.synthetic {
        return None;
    }
    let Some(axis) = facts.axis else {
        let is_told = facts.request.transfer(&facts.card).is_some();
        return (is_told && !accepted).then(|| {
            let text = "nothing says along which axis the channel is: the answer is that of a lever which this \
                        channel turns";
            Finding::warning("axis-unknown", text)
        });
    };
    if axis == 'Y' || fits(design, axis) {
        return None;
    }
    let text = format!(
        "the channel is along {axis}, not along the lateral axis Y, and the design states no axis that makes {axis} \
         the way of its centre of mass"
    );
    Some(match accepted {
        true => Finding::info(
            "axis-accepted",
            format!("{text}. A person has accepted the axis"),
        ),
        false => {
            let text = format!(
                "{text}. No factor mends an axis. If this channel is the one that turns the lever, a pass needs \
                 {} = axis",
                Setting::Accept
            );
            Finding::warning("axis", text).needing_word()
        }
    })
}

/// True if a design's centre of mass moves along an axis, X, Y or Z.
fn fits(design: &Design, axis: char) -> bool {
    let Some(directions) = design.lever.directions() else {
        return false;
    };
    let [x, y, z] = directions.tangential.0;
    let (one, other) = match axis {
        'X' => (y, z),
        'Y' => (x, z),
        _ => (x, y),
    };
    one.abs().max(other.abs()) <= ACROSS_MAX
}

/// Says at which factor of a range the verdict stands.
pub(super) fn reason(block: &TransferBlock) -> Reason {
    Reason {
        code: "transfer".into(),
        text: format!(
            "Judged at {} factors from {} to {} between the sensor's place and the latch; shown is the worst, {}.",
            block.judged.len(),
            block.from,
            block.to,
            block.worst
        ),
    }
}

/// Returns the advice that holds at both of two factors.
pub(super) fn stricter(quantity: Quantity, one: Advice, other: Advice) -> Advice {
    let other_is_stricter = match (one.safe_from, other.safe_from) {
        (None, _) => false,
        (_, None) => true,
        (Some(one), Some(other)) if quantity.is_safer_above() => other > one,
        (Some(one), Some(other)) => other < one,
    };
    if other_is_stricter { other } else { one }
}
