//! The hash that names a report: the same question has the same one, any other another.

use crate::blocks::RecordingBlock;
use crate::request::{MarginRequest, Request};
use crate::spectrum_document::SpectrumRequest;
use latchgate_kernel::model::Design;
use latchgate_recording::source::sha256;
use serde_json::{Value, json};

/// Moves whenever a number or a finding of any golden case does, so that what was stored under
/// an older hash is not taken for an answer of today. `tests/data/numbers.txt` holds it to that.
pub const NUMBERS_REVISION: u32 = 24;

/// Returns the SHA-256, lower-case hexadecimal, of everything that can change the answer: the
/// bytes read (recording, files beside it, card), the file's name, since readers go by it, the
/// design, the settings that differ from their defaults, and [`NUMBERS_REVISION`]; as canonical
/// JSON: keys sorted, no blanks, each number in the fewest digits that read back.
///
/// Of a recording that was not read to its end the bytes are not known; its hash is that of the
/// question alone.
pub fn report_id(recording: &RecordingBlock, request: &Request, design: &Design) -> String {
    report_id_of(NUMBERS_REVISION, recording, request, design)
}

/// As [`report_id`], as another revision of the numbers has it.
pub fn report_id_of(
    numbers_revision: u32,
    recording: &RecordingBlock,
    request: &Request,
    design: &Design,
) -> String {
    hash(&question(numbers_revision, recording, request, design))
}

/// Returns the same of a margin, with the settings that a margin has beside those of a replay.
pub fn margin_id(recording: &RecordingBlock, request: &MarginRequest, design: &Design) -> String {
    let mut question = question(NUMBERS_REVISION, recording, &request.replay, design);
    question["margin"] = json!({
        "counterweight_radius_m": request.counterweight_radius_m,
    });
    hash(&question)
}

/// Returns the SHA-256 of a design as it was judged: of its block in a verdict's document, as canonical JSON.
pub fn design_sha256(design: &Design) -> String {
    hash(&json!(design))
}

/// Returns the same of latch response spectra.
pub fn spectrum_id(
    recordings: &[RecordingBlock],
    request: &SpectrumRequest,
    designs: &[Design],
) -> String {
    let read = |recording: &RecordingBlock| {
        json!({
            "file": recording.file,
            "channel": recording.channel,
            "sha256": recording.sha256,
            "parts": recording.parts,
            "card_sha256": recording.card_sha256,
        })
    };
    hash(&json!({
        "schema": "latchgate.spectrum-question/1",
        "numbers_revision": NUMBERS_REVISION,
        "recordings": recordings.iter().map(read).collect::<Vec<_>>(),
        "request": request.replay.stated(),
        "restitution": request.restitution,
        "limit_angle_rad": request.limit_angle_rad,
        "share": request.share,
        "leave_out_unusable": request.leave_out_unusable,
        "designs": designs,
    }))
}

fn question(
    numbers_revision: u32,
    recording: &RecordingBlock,
    request: &Request,
    design: &Design,
) -> Value {
    let mut design = json!(design);
    if let Some(keys) = design.as_object_mut()
        && keys["modified"].as_array().is_some_and(Vec::is_empty)
    {
        keys.remove("modified");
    }
    json!({
        "schema": "latchgate.question/1",
        "numbers_revision": numbers_revision,
        "file": recording.file,
        "sha256": recording.sha256,
        "parts": recording.parts,
        "card_sha256": recording.card_sha256,
        "request": request.stated(),
        "design": design,
    })
}

fn hash(question: &Value) -> String {
    let mut text = String::new();
    write_canonical(question, &mut text);
    sha256(text.as_bytes())
}

fn write_canonical(value: &Value, out: &mut String) {
    match value {
        Value::Object(table) => {
            let mut keys: Vec<&String> = table.keys().collect();
            keys.sort();
            out.push('{');
            for (index, key) in keys.into_iter().enumerate() {
                if index > 0 {
                    out.push(',');
                }
                out.push_str(&Value::from(key.as_str()).to_string());
                out.push(':');
                write_canonical(&table[key], out);
            }
            out.push('}');
        }
        Value::Array(list) => {
            out.push('[');
            for (index, item) in list.iter().enumerate() {
                if index > 0 {
                    out.push(',');
                }
                write_canonical(item, out);
            }
            out.push(']');
        }
        // A negative zero asks nothing else than a plain one.
        Value::Number(number) if number.as_f64() == Some(0.0) => out.push('0'),
        plain => out.push_str(&plain.to_string()),
    }
}
