//! Message types as a schema defines them, whatever its language: fields by name, and the ways to
//! the numbers in them.

use crate::Limits;
use crate::error::{Error, ErrorKind};
use std::collections::{BTreeMap, BTreeSet};

/// Most number fields of one message type, so that a list of them stays bounded.
pub(super) const FIELDS: usize = 4096;

/// Deepest nesting of types; a definition that uses itself ends here.
pub(super) const DEPTH: usize = 32;

/// Number of fields that may still be visited in a file, wherever they are nested. Without it,
/// nested types would multiply without end.
#[derive(Debug)]
pub(super) struct Budget {
    fields_left: u64,
    limit: u64,
}

impl Budget {
    /// Returns the budget of a file.
    pub(super) fn new(limits: &Limits) -> Self {
        Self {
            fields_left: limits.mcap_fields,
            limit: limits.mcap_fields,
        }
    }

    /// Takes one field from the budget.
    pub(super) fn spend(&mut self) -> Result<(), Error> {
        self.fields_left = self
            .fields_left
            .checked_sub(1)
            .ok_or(ErrorKind::LimitExceeded {
                limit: "mcap_fields",
                value: self.limit,
                found: "message types of more fields together".into(),
            })?;
        Ok(())
    }
}

/// Refuses a message type with more number fields than are looked at.
pub(super) fn too_many_fields() -> Error {
    unreadable(
        &format!("a message type of at most {FIELDS} numbers"),
        "more",
    )
}

pub(super) fn unreadable(expected: &str, found: &str) -> Error {
    let hint = "the schema or message cannot be read; export the channel as CSV";
    Error::malformed(expected, found, hint)
}

/// Says what is wrong with a message.
pub(super) fn damaged_message(expected: &str, found: &str) -> Error {
    let hint = "the message does not fit its schema; record it again";
    Error::malformed(expected, found, hint)
}

/// A number as messages store it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Number {
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    pub(super) fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }

    /// Returns the value of the bits, the lowest first.
    pub(super) fn value(self, bits: u64) -> f64 {
        match self {
            Self::I8 => f64::from(bits as u8 as i8),
            Self::U8 => f64::from(bits as u8),
            Self::I16 => f64::from(bits as u16 as i16),
            Self::U16 => f64::from(bits as u16),
            Self::I32 => f64::from(bits as u32 as i32),
            Self::U32 => f64::from(bits as u32),
            Self::I64 => bits as i64 as f64,
            Self::U64 => bits as f64,
            Self::F32 => f64::from(f32::from_bits(bits as u32)),
            Self::F64 => f64::from_bits(bits),
        }
    }
}

/// Encoding of a number in protobuf: its size in bytes, or seven bits to a byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Coding {
    Fixed,
    Varint,
    /// With the sign as the lowest bit.
    ZigZag,
}

/// Type of a field's value.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum FieldKind {
    Number(Number),
    Bool,
    Text,
    /// A wide string of ROS, or what protobuf has beside numbers and messages.
    Other,
    Message(String),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Multiplicity {
    One,
    Fixed(u64),
    Sequence,
}

/// A field of a message type.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Field {
    pub(super) name: String,
    pub(super) kind: FieldKind,
    pub(super) count: Multiplicity,
    /// Number of the field and coding, in protobuf.
    pub(super) tag: u64,
    pub(super) coding: Coding,
    /// True if an absent field means zero, as in proto3.
    pub(super) zero_if_absent: bool,
}

impl Field {
    /// Returns a field of ROS.
    pub(super) fn new(name: &str, kind: FieldKind, count: Multiplicity) -> Self {
        Self {
            name: name.to_string(),
            kind,
            count,
            tag: 0,
            coding: Coding::Fixed,
            zero_if_absent: false,
        }
    }
}

/// A part of a field path: a name, with an index if it is an array.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Segment {
    pub(super) name: String,
    pub(super) index: Option<u64>,
}

/// Reads a field path such as `linear_acceleration.y` or `values[3].x`.
pub(super) fn segments(path: &str) -> Option<Vec<Segment>> {
    // A number is written in one way only, as messages are compared by it: `3`, not `03`.
    let number = |text: &str| {
        let number: u64 = text.parse().ok()?;
        (number.to_string() == text).then_some(number)
    };
    let segment = |part: &str| {
        let (name, index) = match part.split_once('[') {
            None => (part, None),
            Some((name, index)) => (name, Some(number(index.strip_suffix(']')?)?)),
        };
        let name = name.to_string();
        (!name.is_empty()).then_some(Segment { name, index })
    };
    path.split('.').map(segment).collect()
}

/// A step on the way to a field.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step<'a> {
    /// The type that has the field.
    pub(super) type_name: &'a str,
    pub(super) field: &'a Field,
    /// The index, if the field is repeated.
    pub(super) index: Option<u64>,
}

/// The definitions of a message type and of all types it uses.
#[derive(Debug, Clone, Default)]
pub(super) struct MessageTypes {
    pub(super) root: String,
    pub(super) types: BTreeMap<String, Vec<Field>>,
    /// Types whose fields have no order by which one could be named: entries of protobuf's maps.
    pub(super) unordered: BTreeSet<String>,
}

/// A scalar of a message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Leaf {
    /// A number.
    Number(f64),
    /// A text.
    Text(TextMark),
    /// Nothing.
    Null,
    /// Yes or no.
    Boolean,
}

/// Receiver of the scalars of a message, each with its path, such as `a.b[2].c`.
pub(super) type Sink<'a> = &'a mut dyn FnMut(&str, Leaf);

/// Adds a field to a path.
pub(super) fn step_into(path: &mut String, name: &str) {
    if !path.is_empty() {
        path.push('.');
    }
    path.push_str(name);
}

/// True if a requested path is this one or may go on from it.
pub(super) fn leads_on(path: &str, requested: &[String]) -> bool {
    requested
        .iter()
        .any(|requested| requested.starts_with(path))
}

/// Properties of a text that are kept in its place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TextMark {
    /// A number that two texts share only by a chance of one in 2⁵³.
    pub(super) fingerprint: f64,
    /// True if it is a number in quotes.
    pub(super) is_number: bool,
}

impl TextMark {
    pub(super) fn new(text: &[u8]) -> Self {
        let number = std::str::from_utf8(text).ok().map(str::trim);
        Self {
            fingerprint: (hash(text) >> 11) as f64,
            is_number: number.is_some_and(|text| text.parse::<f64>().is_ok()),
        }
    }
}

/// Returns the hash of a text (FNV-1a).
pub(super) fn hash(text: &[u8]) -> u64 {
    text.iter().fold(0xCBF2_9CE4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01B3)
    })
}

impl MessageTypes {
    /// Adds a type; a second definition must equal the first.
    pub(super) fn define(&mut self, name: &str, fields: Vec<Field>) -> Result<(), Error> {
        if self
            .types
            .get(name)
            .is_some_and(|definition| *definition != fields)
        {
            let expected = format!("one definition of {name}");
            return Err(unreadable(&expected, "two that differ"));
        }
        self.types.insert(name.to_string(), fields);
        Ok(())
    }

    /// Returns the steps to a path, if it exists.
    pub(super) fn way(&self, path: &str) -> Option<Vec<Step<'_>>> {
        let mut type_name = Some(self.root.as_str());
        let mut steps = Vec::new();
        for segment in segments(path)? {
            let holder = type_name.filter(|name| !self.unordered.contains(*name))?;
            let fields = self.types.get(holder)?;
            let field = fields.iter().find(|field| field.name == segment.name)?;
            let fits = match (field.count, segment.index) {
                (Multiplicity::One, None) | (Multiplicity::Sequence, Some(_)) => true,
                (Multiplicity::Fixed(count), Some(index)) => index < count,
                _ => false,
            };
            if !fits {
                return None;
            }
            steps.push(Step {
                type_name: holder,
                field,
                index: segment.index,
            });
            type_name = match &field.kind {
                FieldKind::Message(inner) => Some(inner),
                _ => None,
            };
        }
        Some(steps)
    }

    /// Returns the steps to a number.
    pub(super) fn way_to_number(&self, path: &str) -> Option<(Vec<Step<'_>>, Number)> {
        let way = self.way(path)?;
        match way.last()?.field.kind {
            FieldKind::Number(number) => Some((way, number)),
            _ => None,
        }
    }

    /// Lists the paths of all number fields, and whether each is a floating-point one; an array
    /// shows as `name[0..N]`.
    pub(super) fn numbers(&self, budget: &mut Budget) -> Result<Vec<(String, bool)>, Error> {
        let mut numbers = Vec::new();
        self.list(&self.root, "", DEPTH, budget, &mut numbers)?;
        Ok(numbers)
    }

    fn list(
        &self,
        type_name: &str,
        prefix: &str,
        depth: usize,
        budget: &mut Budget,
        numbers: &mut Vec<(String, bool)>,
    ) -> Result<(), Error> {
        let is_open = depth > 0 && !self.unordered.contains(type_name);
        let Some(fields) = self.types.get(type_name).filter(|_| is_open) else {
            return Ok(());
        };
        for field in fields {
            budget.spend()?;
            let name = &field.name;
            let path = match field.count {
                Multiplicity::One => format!("{prefix}{name}"),
                Multiplicity::Fixed(count) => format!("{prefix}{name}[0..{}]", count - 1),
                Multiplicity::Sequence => format!("{prefix}{name}[0..]"),
            };
            match &field.kind {
                FieldKind::Number(_) if numbers.len() >= FIELDS => return Err(too_many_fields()),
                FieldKind::Number(number) => numbers.push((path, number.is_float())),
                FieldKind::Message(inner) => {
                    self.list(inner, &format!("{path}."), depth - 1, budget, numbers)?;
                }
                FieldKind::Bool | FieldKind::Text | FieldKind::Other => {}
            }
        }
        Ok(())
    }
}
