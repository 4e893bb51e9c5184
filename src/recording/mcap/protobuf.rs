//! Protobuf messages, read by the descriptor that the file itself carries.
//!
//! The schema's data is a `FileDescriptorSet`. Of each message only the fields on the way to a
//! wanted number are entered; all others are passed over by their wire type.
//!
//! # Source
//!
//! Protocol Buffers, "Encoding"; `descriptor.proto` for the field numbers.

use super::schema::{Budget, FIELDS, too_many_fields};
use crate::error::{Error, ErrorKind};
use std::collections::{BTreeMap, BTreeSet};

/// Deepest nesting that is listed.
const DEPTH: usize = 16;

/// Message types of a descriptor set in all.
const TYPES: usize = 1 << 14;

/// How a number stands in a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Scalar {
    Double,
    Float,
    Int64,
    UInt64,
    Int32,
    UInt32,
    Fixed64,
    Fixed32,
    SFixed64,
    SFixed32,
    SInt32,
    SInt64,
}

impl Scalar {
    fn from_type(number: u64) -> Option<Self> {
        Some(match number {
            1 => Self::Double,
            2 => Self::Float,
            3 => Self::Int64,
            4 => Self::UInt64,
            5 => Self::Int32,
            6 => Self::Fixed64,
            7 => Self::Fixed32,
            13 => Self::UInt32,
            15 => Self::SFixed32,
            16 => Self::SFixed64,
            17 => Self::SInt32,
            18 => Self::SInt64,
            _ => return None,
        })
    }

    fn is_float(self) -> bool {
        matches!(self, Self::Double | Self::Float)
    }

    /// Returns the wire type of a single value.
    fn wire(self) -> u64 {
        match self {
            Self::Double | Self::Fixed64 | Self::SFixed64 => 1,
            Self::Float | Self::Fixed32 | Self::SFixed32 => 5,
            _ => 0,
        }
    }

    fn value(self, bits: u64) -> f64 {
        let zigzag = |bits: u64| (bits >> 1) as i64 ^ -((bits & 1) as i64);
        match self {
            Self::Double => f64::from_bits(bits),
            Self::Float => f64::from(f32::from_bits(bits as u32)),
            Self::Int64 | Self::SFixed64 => bits as i64 as f64,
            Self::UInt64 | Self::Fixed64 => bits as f64,
            Self::Int32 | Self::SFixed32 => f64::from(bits as u32 as i32),
            Self::UInt32 | Self::Fixed32 => f64::from(bits as u32),
            Self::SInt32 | Self::SInt64 => zigzag(bits) as f64,
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
enum ProtoKind {
    Number(Scalar),
    Message(String),
    Other,
}

#[derive(Debug, Clone, PartialEq)]
struct ProtoField {
    name: String,
    number: u64,
    kind: ProtoKind,
    repeated: bool,
    /// Whether a field that is not there means zero, as in proto3.
    zero_if_absent: bool,
}

/// The message types of a schema.
#[derive(Debug, Clone)]
pub(super) struct Descriptor {
    root: String,
    types: BTreeMap<String, Vec<ProtoField>>,
    /// The types of entries of maps, which stand in a message in any order.
    maps: BTreeSet<String>,
}

/// A step on the way to a number: field number, and index if it is repeated.
#[derive(Debug, Clone, Copy, PartialEq)]
struct FieldStep {
    number: u64,
    index: Option<u64>,
}

/// The way to one number.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ProtoTarget {
    steps: Vec<FieldStep>,
    scalar: Scalar,
    zero_if_absent: bool,
    /// Whether a message that lacks the way to it still has a value, zero.
    optional: bool,
    path: String,
}

impl Descriptor {
    /// Reads a descriptor set in which `root` is the message type of a topic.
    pub(super) fn read(root: &str, data: &[u8]) -> Result<Self, Error> {
        let mut descriptor = Self {
            root: root.trim_start_matches('.').to_string(),
            types: BTreeMap::new(),
            maps: BTreeSet::new(),
        };
        for part in fields(data) {
            let (1, Wire::Bytes(file)) = part? else {
                continue;
            };
            descriptor.file(file)?;
        }
        if !descriptor.types.contains_key(&descriptor.root) {
            return Err(unreadable(
                &format!("a definition of {}", descriptor.root),
                "none in the schema",
            ));
        }
        Ok(descriptor)
    }

    fn file(&mut self, data: &[u8]) -> Result<(), Error> {
        let (mut package, mut proto3) = (String::new(), false);
        for part in fields(data) {
            match part? {
                (2, Wire::Bytes(name)) => package = text(name)?,
                (12, Wire::Bytes(syntax)) => proto3 = syntax == b"proto3",
                _ => {}
            }
        }
        for part in fields(data) {
            if let (4, Wire::Bytes(message)) = part? {
                self.message(&package, message, proto3, DEPTH)?;
            }
        }
        Ok(())
    }

    fn message(
        &mut self,
        scope: &str,
        data: &[u8],
        proto3: bool,
        depth: usize,
    ) -> Result<(), Error> {
        if depth == 0 || self.types.len() >= TYPES {
            return Err(unreadable("a descriptor of moderate size", "more types"));
        }
        let mut name = String::new();
        for part in fields(data) {
            if let (1, Wire::Bytes(bytes)) = part? {
                name = text(bytes)?;
            }
        }
        let name = if scope.is_empty() {
            name
        } else {
            format!("{scope}.{name}")
        };
        let mut list = Vec::new();
        for part in fields(data) {
            match part? {
                (7, Wire::Bytes(options)) => {
                    for option in fields(options) {
                        if let (7, Wire::Varint(1)) = option? {
                            self.maps.insert(name.clone());
                        }
                    }
                }
                (2, Wire::Bytes(field)) => list.push(ProtoField::read(field, proto3)?),
                (3, Wire::Bytes(nested)) => self.message(&name, nested, proto3, depth - 1)?,
                _ => {}
            }
        }
        match self.types.insert(name.clone(), list.clone()) {
            Some(known) if known != list => Err(unreadable(
                &format!("one definition of {name}"),
                "two that differ",
            )),
            _ => Ok(()),
        }
    }

    /// Returns the way to the number at `path`.
    pub(super) fn target(&self, path: &str) -> Option<ProtoTarget> {
        let mut type_name = self.root.as_str();
        let mut steps = Vec::new();
        let parts: Vec<&str> = path.split('.').collect();
        for (position, part) in parts.iter().enumerate() {
            let (name, index) = match part.split_once('[') {
                None => (*part, None),
                Some((name, index)) => (name, Some(index.strip_suffix(']')?.parse().ok()?)),
            };
            let field = self
                .types
                .get(type_name)?
                .iter()
                .find(|field| field.name == name)?;
            if field.repeated != index.is_some() {
                return None;
            }
            steps.push(FieldStep {
                number: field.number,
                index,
            });
            match &field.kind {
                // An entry of a map has no number of its own.
                ProtoKind::Message(inner) if self.maps.contains(inner) => return None,
                ProtoKind::Message(inner) if position + 1 < parts.len() => type_name = inner,
                ProtoKind::Number(scalar) if position + 1 == parts.len() => {
                    return Some(ProtoTarget {
                        steps,
                        scalar: *scalar,
                        zero_if_absent: field.zero_if_absent && !field.repeated,
                        optional: false,
                        path: path.to_string(),
                    });
                }
                _ => return None,
            }
        }
        None
    }

    /// Returns the ways to seconds and nanoseconds of the messages' stamp.
    pub(super) fn stamp(&self) -> Option<[ProtoTarget; 2]> {
        let own = self.types.get(&self.root)?;
        let is_stamp = |field: &&ProtoField| {
            !field.repeated && field.kind == ProtoKind::Message("google.protobuf.Timestamp".into())
        };
        let named = ["stamp", "timestamp", "time"].iter().find_map(|name| {
            own.iter()
                .filter(is_stamp)
                .find(|field| field.name == *name)
        });
        let mut only = own.iter().filter(is_stamp);
        let only = only.next().filter(|_| only.next().is_none());
        let mut bases: Vec<String> = named
            .or(only)
            .map(|field| field.name.clone())
            .into_iter()
            .collect();
        bases.push("header.stamp".into());
        bases.push("header.timestamp".into());
        for base in bases {
            for [seconds, nanos] in [["seconds", "nanos"], ["sec", "nanosec"], ["sec", "nsec"]] {
                let way = |name: &str| {
                    self.target(&format!("{base}.{name}"))
                        .map(ProtoTarget::or_zero)
                };
                if let (Some(seconds), Some(nanos)) = (way(seconds), way(nanos)) {
                    return Some([seconds, nanos]);
                }
            }
        }
        None
    }

    /// Lists the paths of all number fields, and whether each is a floating-point one.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Malformed`] for a type with too many, [`ErrorKind::LimitExceeded`] once
    /// `budget` is spent.
    pub(super) fn numbers(&self, budget: &mut Budget) -> Result<Vec<(String, bool)>, Error> {
        let mut found = Vec::new();
        self.list(&self.root, "", DEPTH, budget, &mut found)?;
        Ok(found)
    }

    fn list(
        &self,
        type_name: &str,
        prefix: &str,
        depth: usize,
        budget: &mut Budget,
        found: &mut Vec<(String, bool)>,
    ) -> Result<(), Error> {
        let Some(list) = self.types.get(type_name).filter(|_| depth > 0) else {
            return Ok(());
        };
        for field in list {
            budget.spend()?;
            let array = if field.repeated { "[0..]" } else { "" };
            let path = format!("{prefix}{}{array}", field.name);
            match &field.kind {
                ProtoKind::Number(_) if found.len() >= FIELDS => return Err(too_many_fields()),
                ProtoKind::Number(scalar) => found.push((path, scalar.is_float())),
                ProtoKind::Message(inner) if !self.maps.contains(inner) => {
                    self.list(inner, &format!("{path}."), depth - 1, budget, found)?;
                }
                ProtoKind::Message(_) | ProtoKind::Other => {}
            }
        }
        Ok(())
    }
}

impl ProtoTarget {
    /// Returns the same way, on which a message that lacks it means zero.
    pub(super) fn or_zero(self) -> Self {
        Self {
            optional: true,
            ..self
        }
    }
}

impl ProtoField {
    fn read(data: &[u8], proto3: bool) -> Result<Self, Error> {
        let (mut name, mut type_name) = (String::new(), String::new());
        let (mut number, mut kind, mut repeated, mut explicit) = (0, 0, false, false);
        for part in fields(data) {
            match part? {
                (1, Wire::Bytes(bytes)) => name = text(bytes)?,
                (3, Wire::Varint(value)) => number = value,
                (4, Wire::Varint(label)) => repeated = label == 3,
                (5, Wire::Varint(value)) => kind = value,
                (6, Wire::Bytes(bytes)) => type_name = text(bytes)?,
                // A member of a oneof, or marked optional: absence is no zero.
                (9 | 17, Wire::Varint(_)) => explicit = true,
                _ => {}
            }
        }
        let kind = match (Scalar::from_type(kind), kind) {
            (Some(scalar), _) => ProtoKind::Number(scalar),
            (None, 11) => ProtoKind::Message(type_name.trim_start_matches('.').to_string()),
            _ => ProtoKind::Other,
        };
        Ok(Self {
            name,
            number,
            kind,
            repeated,
            zero_if_absent: proto3 && !explicit,
        })
    }
}

/// Takes the numbers at `targets` from a message.
///
/// # Errors
///
/// What is wrong with the message, in words: expected, then found.
pub(super) fn read(
    targets: &[ProtoTarget],
    message: &[u8],
    slots: &mut [f64],
) -> Result<(), (String, String)> {
    let mut values: Vec<Option<f64>> = vec![None; targets.len()];
    let wanted: Vec<(usize, &ProtoTarget, &[FieldStep])> = targets
        .iter()
        .enumerate()
        .map(|(slot, target)| (slot, target, target.steps.as_slice()))
        .collect();
    walk(message, &wanted, &mut values)?;
    for ((value, target), slot) in values.into_iter().zip(targets).zip(slots) {
        *slot = match value {
            Some(value) => value,
            None if target.optional => 0.0,
            None => {
                return Err((
                    format!("a value of {}", target.path),
                    "none in the message".into(),
                ));
            }
        };
    }
    Ok(())
}

fn walk(
    message: &[u8],
    wanted: &[(usize, &ProtoTarget, &[FieldStep])],
    values: &mut [Option<f64>],
) -> Result<(), (String, String)> {
    for (slot, target, steps) in wanted {
        if steps.len() == 1 && target.zero_if_absent && values[*slot].is_none() {
            values[*slot] = Some(0.0);
        }
    }
    // Elements of repeated fields seen, by field number.
    let mut seen: BTreeMap<u64, u64> = BTreeMap::new();
    for part in fields(message) {
        let (number, wire) =
            part.map_err(|error| ("a whole protobuf message".to_string(), error.to_string()))?;
        let here: Vec<&(usize, &ProtoTarget, &[FieldStep])> = wanted
            .iter()
            .filter(|(_, _, steps)| steps[0].number == number)
            .collect();
        if here.is_empty() {
            continue;
        }
        let index = *seen.get(&number).unwrap_or(&0);
        let mut elements = 1;
        for scalar in here.iter().filter(|(_, _, steps)| steps.len() == 1) {
            let (slot, target, steps) = scalar;
            elements = match (&wire, steps[0].index) {
                // Numbers of a repeated field may stand packed in one block.
                (Wire::Bytes(block), Some(wanted)) => {
                    packed(block, target.scalar, index, wanted, &mut values[*slot])?
                }
                (Wire::Bytes(_), None) => return Err(mismatch(target)),
                (single, at) => {
                    let Some(bits) = single.bits(target.scalar) else {
                        return Err(mismatch(target));
                    };
                    if at.is_none_or(|at| at == index) {
                        values[*slot] = Some(target.scalar.value(bits));
                    }
                    1
                }
            };
        }
        let deeper: Vec<(usize, &ProtoTarget, &[FieldStep])> = here
            .iter()
            .filter(|(_, _, steps)| steps.len() > 1 && steps[0].index.is_none_or(|at| at == index))
            .map(|(slot, target, steps)| (*slot, *target, &steps[1..]))
            .collect();
        if !deeper.is_empty() {
            let Wire::Bytes(inner) = wire else {
                return Err(mismatch(deeper[0].1));
            };
            walk(inner, &deeper, values)?;
        }
        seen.insert(number, index.saturating_add(elements));
    }
    Ok(())
}

fn mismatch(target: &ProtoTarget) -> (String, String) {
    (
        format!("{} as the schema describes it", target.path),
        "another wire type".into(),
    )
}

/// Reads a packed block; returns its number of elements.
fn packed(
    block: &[u8],
    scalar: Scalar,
    first: u64,
    wanted: u64,
    value: &mut Option<f64>,
) -> Result<u64, (String, String)> {
    let mut left = block;
    let mut count = 0;
    while !left.is_empty() {
        let Some(bits) = take_bits(&mut left, scalar.wire()) else {
            return Err((
                "whole numbers in a packed block".into(),
                "the end of it".into(),
            ));
        };
        if first.saturating_add(count) == wanted {
            *value = Some(scalar.value(bits));
        }
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
    fn bits(&self, scalar: Scalar) -> Option<u64> {
        match (self, scalar.wire()) {
            (Self::Varint(bits), 0) | (Self::Eight(bits), 1) => Some(*bits),
            (Self::Four(bits), 5) => Some(u64::from(*bits)),
            _ => None,
        }
    }
}

/// Walks the fields of a message: numbers and contents, up to the first that is damaged.
fn fields(data: &[u8]) -> impl Iterator<Item = Result<(u64, Wire<'_>), Error>> {
    let mut left = data;
    std::iter::from_fn(move || {
        if left.is_empty() {
            return None;
        }
        let field = next_field(&mut left);
        if field.is_none() {
            left = &[];
        }
        Some(field.ok_or_else(|| unreadable("whole protobuf fields", "a damaged one")))
    })
}

fn next_field<'a>(left: &mut &'a [u8]) -> Option<(u64, Wire<'a>)> {
    let key = varint(left)?;
    let number = key >> 3;
    if number == 0 {
        return None;
    }
    let wire = match key & 7 {
        0 => Wire::Varint(varint(left)?),
        1 => Wire::Eight(take_bits(left, 1)?),
        5 => Wire::Four(u32::try_from(take_bits(left, 5)?).ok()?),
        2 => {
            let length = usize::try_from(varint(left)?).ok()?;
            let (bytes, rest) = left.split_at_checked(length)?;
            *left = rest;
            Wire::Bytes(bytes)
        }
        // Groups, which no log written today holds.
        _ => return None,
    };
    Some((number, wire))
}

fn take_bits(left: &mut &[u8], wire: u64) -> Option<u64> {
    match wire {
        0 => varint(left),
        1 => {
            let (bytes, rest) = left.split_first_chunk::<8>()?;
            *left = rest;
            Some(u64::from_le_bytes(*bytes))
        }
        _ => {
            let (bytes, rest) = left.split_first_chunk::<4>()?;
            *left = rest;
            Some(u64::from(u32::from_le_bytes(*bytes)))
        }
    }
}

fn varint(left: &mut &[u8]) -> Option<u64> {
    let mut value = 0_u64;
    for shift in (0..70).step_by(7) {
        let (byte, rest) = left.split_first()?;
        *left = rest;
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

fn unreadable(expected: &str, found: &str) -> Error {
    ErrorKind::Malformed {
        expected: expected.to_string(),
        found: found.to_string(),
        hint: "the schema or message cannot be read; export the channel as CSV".into(),
    }
    .into()
}
