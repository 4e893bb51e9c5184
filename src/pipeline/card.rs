//! A card to start from: what a recording's file says of itself, and what it leaves to a person.

use crate::pipeline::{Control, Limits, Source};
use latchgate_recording::error::{Error, ErrorKind};
use latchgate_recording::{
    Channel, ReadOptions, Reading, SensorPlace, axis_of, place_of, read_both,
};
use latchgate_verdict::conditioning::{ConditioningOptions, condition};
use std::fmt::Write as _;

/// Writes a text as TOML has it.
pub(crate) fn in_quotes(text: &str) -> String {
    // TOML reads every escape of JSON. It also requires one for U+007F, which JSON does not make.
    serde_json::Value::from(text)
        .to_string()
        .replace('\u{7f}', "\\u007F")
}

/// A card in the making.
#[derive(Default)]
struct CardText(String);

impl CardText {
    fn comment(&mut self, text: &str) {
        let text = text.replace(|c: char| c.is_control(), " ");
        let _ = writeln!(self.0, "# {text}");
    }

    /// Writes what the file says, and where.
    fn says(&mut self, key: &str, value: &str, source: &str) {
        self.comment(source);
        let _ = write!(self.0, "{key} = {}\n\n", in_quotes(value));
    }

    /// Leaves a key to a person, with the reason.
    fn blank(&mut self, key: &str, form: &str, reason: &str) {
        self.comment(reason);
        let _ = write!(self.0, "# {key} = {form}\n\n");
    }
}

/// Returns the text of a card for a recording: what its file says, and a blank with a reason for the rest.
///
/// # Errors
///
/// Any [`ErrorKind`] of reading a file in which no channel can be found; a channel, a unit or a time that is
/// missing is a blank.
///
/// # Examples
///
/// ```
/// use latchgate::pipeline::{Card, Control, Limits, Source, card_for};
///
/// let source = Source::bytes("push.csv", *b"t_s,acc_y_g\n0,0.1\n0.001,0.2\n0.002,0.1\n");
/// let text = card_for(&source, &Limits::default(), &Control::default()).unwrap();
/// assert!(text.contains("unit = \"g\"\n") && text.contains("# transfer = \"LO..HI\"\n"));
/// assert!(Card::from_toml(&text).is_ok());
/// ```
pub fn card_for(source: &Source, limits: &Limits, control: &Control<'_>) -> Result<String, Error> {
    let Reading { chosen, every } = read_both(source, &ReadOptions::default(), limits, control);
    let refusal = chosen.as_ref().err().cloned();
    if let Some(error) = refusal.clone()
        && !is_blank(error.kind())
    {
        return Err(error);
    }
    let channels = every.map_or_else(|_| Vec::new(), |every| every.channels);
    let is_chosen = chosen.is_ok();
    let channel = match chosen {
        Ok(recording) => recording.channels.into_iter().next(),
        // Of a single channel much is known, though not all.
        Err(_) if channels.len() == 1 => channels.first().cloned(),
        Err(_) => None,
    };
    let mut card = CardText::default();
    card.comment(&format!(
        "Card of {}, which stands beside it.",
        source.name()
    ));
    card.comment("Written is what the file says. Take away the # of a line and fill it in where the file says nothing.");
    card.0.push('\n');
    let reason = refusal.map_or_else(String::new, |error| error.to_string());
    match &channel {
        Some(channel) if is_chosen => {
            card.says(
                "channel",
                &channel.name,
                "The channel that latchgate takes.",
            );
        }
        _ => card.blank("channel", "\"NAME\"", &reason),
    }
    match channel
        .as_ref()
        .and_then(|channel| Some((channel.unit?, channel.unit_source)))
    {
        Some((unit, stated_by)) => {
            card.says("unit", unit.name(), &format!("Stated by: {stated_by}."));
        }
        None => card.blank(
            "unit",
            "\"g\"",
            "The unit of acceleration: the file does not state it.",
        ),
    }
    card.blank(
        "opens_when",
        "\"negative\"",
        "The sign of the recorded acceleration that opens the lever, negative, positive or both: no file states it \
         (docs/opening-direction.md).",
    );
    of_place(&mut card, channel.as_ref());
    of_doubts(&mut card, channel.as_ref());
    if let Some(channel) = &channel {
        of_test(&mut card, channel);
    }
    Ok(card.0)
}

/// True of an error that a card mends.
fn is_blank(kind: &ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::MissingUnit
            | ErrorKind::MissingTime
            | ErrorKind::AmbiguousChannel { .. }
            | ErrorKind::NoChannel { .. }
            | ErrorKind::UnnamedColumns { .. }
    )
}

fn of_place(card: &mut CardText, channel: Option<&Channel>) {
    let place = channel.and_then(place_of);
    match (place, channel) {
        (Some(place), Some(channel)) => {
            let code = channel.stated.location.as_ref().unwrap_or(&channel.name);
            card.says("place", place.name(), &format!("By the code `{code}`."));
        }
        _ => card.blank(
            "place",
            "\"latch\"",
            "Where the sensor sits, latch, door or body: the file does not say.",
        ),
    }
    let reason = match place.is_some_and(SensorPlace::moves_as_latch) {
        true => {
            "Factors from the sensor's place to the latch: 1 at the door or the latch, if nothing is stated."
        }
        false => {
            "Factors from the sensor's place to the latch, which a pass waits for unless the place is door or latch: \
             no file states them. Each is judged, the worst counts; 1 says that both move alike."
        }
    };
    card.blank("transfer", "\"LO..HI\"", reason);
}

/// Leaves blank what a pass would wait for beside the place.
fn of_doubts(card: &mut CardText, channel: Option<&Channel>) {
    let Some(channel) = channel else {
        return;
    };
    let mut accepted: Vec<&str> = Vec::new();
    let mut reasons: Vec<String> = Vec::new();
    if let Some(axis) = axis_of(channel).filter(|axis| axis.letter != 'Y') {
        accepted.push("\"axis\"");
        reasons.push(format!(
            "The channel is along {}, not along the lateral axis Y.",
            axis.letter
        ));
    }
    // What cannot be conditioned has no velocity to doubt.
    let findings = condition(channel, &ConditioningOptions::default());
    let findings = findings.map_or_else(|_| Vec::new(), |conditioned| conditioned.findings);
    for finding in findings.iter().filter(|finding| finding.needs_word) {
        match &*finding.code {
            "implausible-velocity" => {
                card.blank("velocity_change_m_s", "4.6", &finding.text);
            }
            code @ ("clock-implausible" | "noise-unknown") => {
                let is_clock = code == "clock-implausible";
                accepted.push(if is_clock { "\"clock\"" } else { "\"noise\"" });
                reasons.push(format!("{}.", finding.text));
            }
            _ => card.comment(&finding.text),
        }
    }
    if !accepted.is_empty() {
        let list = format!("[{}]", accepted.join(", "));
        card.blank("accepted", &list, &reasons.join(" "));
    }
}

/// Writes what the file says of test and sensor.
fn of_test(card: &mut CardText, channel: &Channel) {
    let test = &channel.stated.test;
    let facts = [
        ("test", &test.test),
        ("vehicle", &test.vehicle),
        ("laboratory", &test.laboratory),
        ("date", &test.date),
        ("sensor", &test.sensor),
        ("location", &test.location),
    ];
    let stated = facts.iter().any(|(_, fact)| fact.is_some());
    if stated {
        card.comment("Of the test and the sensor, by the file.");
    }
    for (key, fact) in facts {
        if let Some(fact) = fact {
            let _ = writeln!(card.0, "{key} = {}", in_quotes(fact));
        }
    }
}
