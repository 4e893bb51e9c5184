//! Protobuf messages, read by the descriptor that the file itself carries.
//!
//! The schema's data is a `FileDescriptorSet`. Of each message only the fields on the way to a
//! requested number are entered; all others are passed over by their wire type.
//!
//! # Source
//!
//! Protocol Buffers, "Encoding"; `descriptor.proto` for the field numbers.

use super::types::{
    Coding, Field, FieldKind, Leaf, MessageTypes, Multiplicity, Number, Sink, damaged_message,
    leads_on, step_into, unreadable,
};
use crate::error::Error;

/// Deepest nesting of definitions.
const DEPTH: usize = 16;

/// Message types of a descriptor set in all.
const TYPES: usize = 1 << 14;

/// Returns how a number of a descriptor's type is stored.
fn number_of(kind: u64) -> Option<(Number, Coding)> {
    use Coding::{Fixed, Varint, ZigZag};
    Some(match kind {
        1 => (Number::F64, Fixed),
        2 => (Number::F32, Fixed),
        3 => (Number::I64, Varint),
        4 => (Number::U64, Varint),
        5 => (Number::I32, Varint),
        6 => (Number::U64, Fixed),
        7 => (Number::U32, Fixed),
        13 => (Number::U32, Varint),
        15 => (Number::I32, Fixed),
        16 => (Number::I64, Fixed),
        17 => (Number::I32, ZigZag),
        18 => (Number::I64, ZigZag),
        _ => return None,
    })
}

/// Reads a descriptor set in which `root` is the message type of a topic.
pub(super) fn types(root: &str, data: &[u8]) -> Result<MessageTypes, Error> {
    let mut types = MessageTypes {
        root: root.trim_start_matches('.').to_string(),
        ..MessageTypes::default()
    };
    for part in fields(data) {
        if let (1, Wire::Bytes(file)) = part? {
            let (mut package, mut proto3) = (String::new(), false);
            for part in fields(file) {
                match part? {
                    (2, Wire::Bytes(name)) => package = text(name)?,
                    (12, Wire::Bytes(syntax)) => proto3 = syntax == b"proto3",
                    _ => {}
                }
            }
            for part in fields(file) {
                if let (4, Wire::Bytes(message_type)) = part? {
                    define(&mut types, &package, message_type, proto3, DEPTH)?;
                }
            }
        }
    }
    if types.types.contains_key(&types.root) {
        return Ok(types);
    }
    let expected = format!("a definition of {}", types.root);
    Err(unreadable(&expected, "none in the schema"))
}

/// Reads a message type and those in it.
fn define(
    types: &mut MessageTypes,
    scope: &str,
    data: &[u8],
    proto3: bool,
    depth: usize,
) -> Result<(), Error> {
    if depth == 0 || types.types.len() >= TYPES {
        return Err(unreadable("a descriptor of moderate size", "more types"));
    }
    let mut name = String::new();
    for part in fields(data) {
        if let (1, Wire::Bytes(bytes)) = part? {
            name = text(bytes)?;
        }
    }
    if !scope.is_empty() {
        name = format!("{scope}.{name}");
    }
    let mut list = Vec::new();
    for part in fields(data) {
        match part? {
            (2, Wire::Bytes(field_data)) => list.push(field(field_data, proto3)?),
            (3, Wire::Bytes(nested)) => define(types, &name, nested, proto3, depth - 1)?,
            (7, Wire::Bytes(options)) => {
                for option in fields(options) {
                    if let (7, Wire::Varint(1)) = option? {
                        types.unordered.insert(name.clone());
                    }
                }
            }
            _ => {}
        }
    }
    types.define(&name, list)
}

fn field(data: &[u8], proto3: bool) -> Result<Field, Error> {
    let (mut name, mut type_name) = (String::new(), String::new());
    let (mut tag, mut kind, mut repeated, mut explicit) = (0, 0, false, false);
    for part in fields(data) {
        match part? {
            (1, Wire::Bytes(bytes)) => name = text(bytes)?,
            (3, Wire::Varint(value)) => tag = value,
            (4, Wire::Varint(label)) => repeated = label == 3,
            (5, Wire::Varint(value)) => kind = value,
            (6, Wire::Bytes(bytes)) => type_name = text(bytes)?,
            // A member of a oneof, or marked optional: absence is no zero.
            (9 | 17, Wire::Varint(_)) => explicit = true,
            _ => {}
        }
    }
    let (kind, coding) = match (number_of(kind), kind) {
        (Some((number, coding)), _) => (FieldKind::Number(number), coding),
        (None, 11) => {
            let name = type_name.trim_start_matches('.').to_string();
            (FieldKind::Message(name), Coding::Fixed)
        }
        _ => (FieldKind::Other, Coding::Fixed),
    };
    let count = match repeated {
        true => Multiplicity::Sequence,
        false => Multiplicity::One,
    };
    Ok(Field {
        tag,
        coding,
        zero_if_absent: proto3 && !explicit && !repeated,
        ..Field::new(&name, kind, count)
    })
}

/// Returns the names of the root message's fields that hold a stamp, the likeliest first.
pub(super) fn stamps(types: &MessageTypes) -> Vec<String> {
    let kind = FieldKind::Message("google.protobuf.Timestamp".into());
    let root_fields = types.types.get(&types.root).into_iter().flatten();
    let of_kind =
        root_fields.filter(|field| field.count == Multiplicity::One && field.kind == kind);
    let names: Vec<&str> = of_kind.map(|field| field.name.as_str()).collect();
    let named = ["stamp", "timestamp", "time"]
        .into_iter()
        .find(|name| names.contains(name));
    let only = || match names.as_slice() {
        [only] => Some(*only),
        _ => None,
    };
    let stamp = named.or_else(only).into_iter();
    stamp
        .chain(["header.stamp", "header.timestamp"])
        .map(str::to_string)
        .collect()
}

impl Field {
    /// Returns the wire type of a single number and its value by the bits there; `None` for a field of
    /// another kind.
    fn number(&self) -> Option<(u64, impl Fn(u64) -> f64)> {
        let FieldKind::Number(number) = self.kind else {
            return None;
        };
        let wire = match (self.coding, number.size()) {
            (Coding::Fixed, 8) => 1,
            (Coding::Fixed, _) => 5,
            _ => 0,
        };
        let zigzag = self.coding == Coding::ZigZag;
        let value = move |bits: u64| match zigzag {
            true => number.value((bits >> 1) ^ (bits & 1).wrapping_neg()),
            false => number.value(bits),
        };
        Some((wire, value))
    }
}

/// Walks through the parts of a message of the type `name`, itself at `path`, that lead to a
/// requested path. A number that proto3 leaves out is zero.
pub(super) fn walk(
    types: &MessageTypes,
    name: &str,
    path: &mut String,
    message: &[u8],
    requested: &[String],
    sink: Sink<'_>,
) -> Result<(), Error> {
    let defined = types.types.get(name).map_or(&[][..], Vec::as_slice);
    // Count of the elements of each field so far.
    let mut counts = vec![0_u64; defined.len()];
    let before = path.len();
    for part in fields(message) {
        path.truncate(before);
        let (tag, wire) =
            part.map_err(|error| damaged_message("a whole protobuf message", &error.to_string()))?;
        let Some(position) = defined.iter().position(|field| field.tag == tag) else {
            continue;
        };
        let (field, index) = (&defined[position], counts[position]);
        step_into(path, &field.name);
        if !leads_on(path, requested) {
            continue;
        }
        let repeated = field.count == Multiplicity::Sequence;
        counts[position] = index.saturating_add(1);
        match (&wire, field.number()) {
            // Numbers of a repeated field may stand packed in one block.
            (Wire::Bytes(block), Some((wire_type, value))) if repeated => {
                let elements = packed(block, wire_type, |place, bits| {
                    let element = format!("{path}[{}]", index + place);
                    sink(&element, Leaf::Number(value(bits)));
                })?;
                counts[position] = index.saturating_add(elements);
                continue;
            }
            _ if repeated => path.push_str(&format!("[{index}]")),
            _ => {}
        }
        match (wire, field.number()) {
            (single, Some((wire_type, value))) => {
                let bits = single.bits(wire_type).ok_or_else(|| mismatch(field))?;
                sink(path, Leaf::Number(value(bits)));
            }
            (Wire::Bytes(content), None) => {
                if let FieldKind::Message(name) = &field.kind {
                    walk(types, name, path, content, requested, sink)?;
                }
            }
            _ => return Err(mismatch(field)),
        }
    }
    path.truncate(before);
    let absent = defined.iter().zip(counts);
    let absent = absent.filter(|(field, count)| *count == 0 && field.zero_if_absent);
    for (field, _) in absent.filter(|(field, _)| field.number().is_some()) {
        step_into(path, &field.name);
        sink(path, Leaf::Number(0.0));
        path.truncate(before);
    }
    Ok(())
}

fn mismatch(field: &Field) -> Error {
    let expected = format!("{} as the schema describes it", field.name);
    damaged_message(&expected, "another wire type")
}

/// Hands out the numbers of a packed block with their places; returns how many there are.
fn packed(block: &[u8], wire: u64, mut take: impl FnMut(u64, u64)) -> Result<u64, Error> {
    let mut bytes_left = block;
    let mut count = 0;
    while !bytes_left.is_empty() {
        let Some(bits) = take_bits(&mut bytes_left, wire) else {
            let expected = "whole numbers in a packed block";
            return Err(damaged_message(expected, "the end of it"));
        };
        take(count, bits);
        count += 1;
    }
    Ok(count)
}

/// A field's content as it stands on the wire.
#[derive(Debug, Clone, Copy)]
enum Wire<'a> {
    Varint(u64),
    Eight(u64),
    Four(u32),
    Bytes(&'a [u8]),
}

impl Wire<'_> {
    fn bits(&self, wire: u64) -> Option<u64> {
        match (self, wire) {
            (Self::Varint(bits), 0) | (Self::Eight(bits), 1) => Some(*bits),
            (Self::Four(bits), 5) => Some(u64::from(*bits)),
            _ => None,
        }
    }
}

/// Iterates over the fields of a message: numbers and contents, up to the first damaged one.
fn fields(data: &[u8]) -> impl Iterator<Item = Result<(u64, Wire<'_>), Error>> {
    let mut bytes_left = data;
    std::iter::from_fn(move || {
        if bytes_left.is_empty() {
            return None;
        }
        let field = next_field(&mut bytes_left);
        if field.is_none() {
            bytes_left = &[];
        }
        Some(field.ok_or_else(|| unreadable("whole protobuf fields", "a damaged one")))
    })
}

fn next_field<'a>(bytes_left: &mut &'a [u8]) -> Option<(u64, Wire<'a>)> {
    let key = varint(bytes_left)?;
    let number = key >> 3;
    if number == 0 {
        return None;
    }
    let wire = match key & 7 {
        0 => Wire::Varint(varint(bytes_left)?),
        1 => Wire::Eight(take_bits(bytes_left, 1)?),
        5 => Wire::Four(u32::try_from(take_bits(bytes_left, 5)?).ok()?),
        2 => {
            let length = usize::try_from(varint(bytes_left)?).ok()?;
            let (bytes, tail) = bytes_left.split_at_checked(length)?;
            *bytes_left = tail;
            Wire::Bytes(bytes)
        }
        // Groups are deprecated, and no log written today holds one.
        _ => return None,
    };
    Some((number, wire))
}

fn take_bits(bytes_left: &mut &[u8], wire: u64) -> Option<u64> {
    match wire {
        0 => varint(bytes_left),
        1 => {
            let (bytes, tail) = bytes_left.split_first_chunk::<8>()?;
            *bytes_left = tail;
            Some(u64::from_le_bytes(*bytes))
        }
        _ => {
            let (bytes, tail) = bytes_left.split_first_chunk::<4>()?;
            *bytes_left = tail;
            Some(u64::from(u32::from_le_bytes(*bytes)))
        }
    }
}

fn varint(bytes_left: &mut &[u8]) -> Option<u64> {
    let mut value = 0_u64;
    for shift in (0..70).step_by(7) {
        let (byte, tail) = bytes_left.split_first()?;
        *bytes_left = tail;
        let bits = u64::from(byte & 0x7F);
        if shift == 63 && bits > 1 {
            return None;
        }
        value |= bits << shift;
        if byte & 0x80 == 0 {
            return Some(value);
        }
    }
    None
}

fn text(bytes: &[u8]) -> Result<String, Error> {
    String::from_utf8(bytes.to_vec()).map_err(|_| unreadable("names in UTF-8", "other bytes"))
}
