//! ROS message definitions (`ros2msg`, `ros1msg`): from the text in the file to a plan that finds
//! numbers in a message.
//!
//! The text holds the definition of one type, then those of the types it uses, divided by
//! lines of 80 `=`, each opened by `MSG: package/Type`. A [`DecodePlan`] is the definition laid
//! flat: what to step over and what to take.

use crate::error::{Error, ErrorKind};
use crate::recording::Limits;
use crate::units::AccelerationUnit;
use std::collections::BTreeMap;

/// Deepest nesting of types; a definition that uses itself ends here.
const DEPTH: usize = 32;
/// Shortest line of `=` that divides definitions.
const DIVIDER: usize = 80;

/// What the message types of a file may still cost, so that nested types cannot multiply without
/// end: one for each field looked at, wherever it is nested.
#[derive(Debug)]
pub(super) struct Budget {
    left: u64,
    limit: u64,
}

impl Budget {
    /// Returns the budget of a file.
    pub(super) fn new(limits: &Limits) -> Self {
        Self {
            left: limits.mcap_fields,
            limit: limits.mcap_fields,
        }
    }

    /// Takes one field from the budget.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::LimitExceeded`] if nothing is left.
    pub(super) fn spend(&mut self) -> Result<(), Error> {
        self.left = self.left.checked_sub(1).ok_or(ErrorKind::LimitExceeded {
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

/// Most number fields of one message type.
pub(super) const FIELDS: usize = 4096;

/// A number as CDR stores it.
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
}

/// One step through a message.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum DecodeStep {
    /// Steps over `count` values of `size` bytes, each aligned to its size.
    Skip { size: usize, count: u64 },
    /// Takes a number into a slot.
    Take { number: Number, slot: usize },
    /// Steps over a string; its fingerprint goes into the slot, if there is one.
    Text { slot: Option<usize> },
    /// Steps over `count` elements.
    Repeat {
        count: u64,
        element: Vec<DecodeStep>,
    },
    /// Goes through a sequence whose length stands before it; `picks` are taken at their
    /// index, in rising order, all others stepped over.
    Sequence {
        element: Vec<DecodeStep>,
        picks: Vec<(u64, Vec<DecodeStep>)>,
    },
}

/// How to find the wanted numbers in a message.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct DecodePlan {
    pub(super) steps: Vec<DecodeStep>,
}

/// Whose definitions and encoding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Dialect {
    /// Numbers aligned to their size.
    Ros2,
    /// Numbers one after another; `time` and `duration` are types of their own.
    Ros1,
}

impl Dialect {
    /// Returns the dialect of a schema encoding.
    pub(super) fn of_schema(encoding: &str) -> Option<Self> {
        match encoding {
            "ros2msg" => Some(Self::Ros2),
            "ros1msg" => Some(Self::Ros1),
            _ => None,
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
enum FieldKind {
    Number(Number),
    Bool,
    Text,
    WideText,
    Message(String),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Multiplicity {
    One,
    Fixed(u64),
    Sequence,
}

#[derive(Debug, Clone, PartialEq)]
struct MessageField {
    name: String,
    kind: FieldKind,
    count: Multiplicity,
}

/// A part of a field path: a name, with an index if it is an array.
#[derive(Debug, Clone, PartialEq)]
struct Segment {
    name: String,
    index: Option<u64>,
}

/// A number field, as a path leads to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NumberField {
    pub(super) number: Number,
    /// The unit that the message type prescribes, if the field is an acceleration.
    pub(super) unit: Option<AccelerationUnit>,
}

/// The definitions of a message type and of all types it uses.
#[derive(Debug, Clone)]
pub(super) struct Definitions {
    dialect: Dialect,
    root: String,
    types: BTreeMap<String, Vec<MessageField>>,
}

impl Definitions {
    /// Reads the text of a schema whose first part defines `root`.
    pub(super) fn read(root: &str, text: &str, dialect: Dialect) -> Result<Self, Error> {
        let root = plain_name(root);
        let mut types = BTreeMap::new();
        let mut name = root.clone();
        let mut fields: Vec<MessageField> = Vec::new();
        let mut opening = false;
        for line in text.lines().map(str::trim) {
            if line.len() >= DIVIDER && line.bytes().all(|byte| byte == b'=') {
                define(&mut types, &name, std::mem::take(&mut fields))?;
                opening = true;
            } else if opening {
                if line.is_empty() {
                    continue;
                }
                let Some(named) = line.strip_prefix("MSG:") else {
                    return Err(unreadable(
                        "`MSG: package/Type` after the dividing line",
                        &format!("`{line}`"),
                    ));
                };
                name = plain_name(named.trim());
                opening = false;
            } else {
                let package = name.split('/').next().unwrap_or_default();
                if let Some(field) = field(line, package, dialect)? {
                    if fields.iter().any(|known| known.name == field.name) {
                        return Err(unreadable(
                            &format!("each field of {name} once"),
                            &format!("`{}` twice", field.name),
                        ));
                    }
                    fields.push(field);
                }
            }
        }
        if !opening {
            define(&mut types, &name, fields)?;
        }
        // Every reader knows these two, so that some recorders leave them out.
        for name in ["Time", "Duration"] {
            let part = |name: &str, number| MessageField {
                name: name.to_string(),
                kind: FieldKind::Number(number),
                count: Multiplicity::One,
            };
            types
                .entry(format!("builtin_interfaces/{name}"))
                .or_insert_with(|| vec![part("sec", Number::I32), part("nanosec", Number::U32)]);
            // ROS 1 has both as types of their own, the time without a sign.
            let seconds = if name == "Time" {
                Number::U32
            } else {
                Number::I32
            };
            let rest = if name == "Time" {
                Number::U32
            } else {
                Number::I32
            };
            types
                .entry(format!("ros1/{}", name.to_lowercase()))
                .or_insert_with(|| vec![part("secs", seconds), part("nsecs", rest)]);
        }
        Ok(Self {
            dialect,
            root,
            types,
        })
    }

    /// Returns the number field that `path` leads to.
    pub(super) fn target(&self, path: &str) -> Option<NumberField> {
        let mut type_name = self.root.as_str();
        let mut unit = None;
        let segments = segments(path)?;
        let (last, _) = segments.split_last()?;
        for segment in &segments {
            let field = self
                .types
                .get(type_name)?
                .iter()
                .find(|field| field.name == segment.name)?;
            if !matches!(
                (field.count, segment.index),
                (Multiplicity::One, None)
                    | (Multiplicity::Fixed(_) | Multiplicity::Sequence, Some(_))
            ) {
                return None;
            }
            if let (Multiplicity::Fixed(count), Some(index)) = (field.count, segment.index)
                && index >= count
            {
                return None;
            }
            // REP 103 states SI units for these.
            if matches!(
                (type_name, field.name.as_str()),
                ("sensor_msgs/Imu", "linear_acceleration") | ("geometry_msgs/Accel", "linear")
            ) {
                unit = Some(AccelerationUnit::MetrePerSecondSquared);
            }
            match &field.kind {
                FieldKind::Message(name) => type_name = name,
                FieldKind::Number(number) if std::ptr::eq(segment, last) => {
                    return Some(NumberField {
                        number: *number,
                        unit,
                    });
                }
                _ => return None,
            }
        }
        None
    }

    /// Lists the paths of all number fields; an array shows as `name[0..N]`.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Malformed`] for a type with too many, [`ErrorKind::LimitExceeded`] once
    /// `budget` is spent.
    pub(super) fn numbers(&self, budget: &mut Budget) -> Result<Vec<(String, Number)>, Error> {
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
        found: &mut Vec<(String, Number)>,
    ) -> Result<(), Error> {
        let Some(fields) = self.types.get(type_name).filter(|_| depth > 0) else {
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
                FieldKind::Number(_) if found.len() >= FIELDS => return Err(too_many_fields()),
                FieldKind::Number(number) => found.push((path, *number)),
                FieldKind::Message(inner) => {
                    self.list(inner, &format!("{path}."), depth - 1, budget, found)?;
                }
                FieldKind::Bool | FieldKind::Text | FieldKind::WideText => {}
            }
        }
        Ok(())
    }

    /// Tells whether the root's field `field` is a message with a text `name`.
    pub(super) fn has_text(&self, field: &str, name: &str) -> bool {
        let of = |type_name: &str, name: &str| {
            let fields = self.types.get(type_name)?;
            fields
                .iter()
                .find(|field| field.name == name && field.count == Multiplicity::One)
        };
        match of(&self.root, field).map(|field| &field.kind) {
            Some(FieldKind::Message(inner)) => {
                of(inner, name).is_some_and(|f| f.kind == FieldKind::Text)
            }
            _ => false,
        }
    }

    /// Lays the definition flat so that path number i ends in slot i.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Malformed`] if a type is missing or nested too deep, or if the message
    /// holds wide strings, whose layout differs between writers.
    pub(super) fn plan(&self, paths: &[&str], budget: &mut Budget) -> Result<DecodePlan, Error> {
        let wanted: Vec<(Vec<Segment>, usize)> = paths
            .iter()
            .enumerate()
            .filter_map(|(slot, path)| Some((segments(path)?, slot)))
            .collect();
        let wanted: Vec<(&[Segment], usize)> = wanted
            .iter()
            .map(|(segments, slot)| (segments.as_slice(), *slot))
            .collect();
        let steps = self.lay_type(&self.root, &wanted, DEPTH, budget)?;
        Ok(DecodePlan { steps })
    }

    fn lay_type(
        &self,
        type_name: &str,
        wanted: &[(&[Segment], usize)],
        depth: usize,
        budget: &mut Budget,
    ) -> Result<Vec<DecodeStep>, Error> {
        let Some(fields) = self.types.get(type_name) else {
            return Err(unreadable(
                &format!("a definition of {type_name}"),
                "none in the schema",
            ));
        };
        if depth == 0 {
            return Err(unreadable(
                &format!("types nested at most {DEPTH} deep"),
                &format!("more, at {type_name}"),
            ));
        }
        if fields.is_empty() && self.dialect == Dialect::Ros2 {
            // An empty type travels as one byte that stands for nothing.
            return Ok(vec![DecodeStep::Skip { size: 1, count: 1 }]);
        }
        let mut steps = Vec::new();
        for field in fields {
            let inner: Vec<(Option<u64>, &[Segment], usize)> = wanted
                .iter()
                .filter_map(|(path, slot)| {
                    let (first, rest) = path.split_first()?;
                    (first.name == field.name).then_some((first.index, rest, *slot))
                })
                .collect();
            self.lay_field(field, &inner, depth, budget, &mut steps)?;
        }
        Ok(steps)
    }

    fn lay_field(
        &self,
        field: &MessageField,
        wanted: &[(Option<u64>, &[Segment], usize)],
        depth: usize,
        budget: &mut Budget,
        steps: &mut Vec<DecodeStep>,
    ) -> Result<(), Error> {
        budget.spend()?;
        let mut lay =
            |wanted: &[(&[Segment], usize)]| self.lay_element(&field.kind, wanted, depth, budget);
        let at = |index: Option<u64>| -> Vec<(&[Segment], usize)> {
            wanted
                .iter()
                .filter(|(found, _, _)| *found == index)
                .map(|(_, path, slot)| (*path, *slot))
                .collect()
        };
        let mut indices: Vec<u64> = wanted.iter().filter_map(|(index, _, _)| *index).collect();
        indices.sort_unstable();
        indices.dedup();
        match field.count {
            Multiplicity::One => steps.extend(lay(&at(None))?),
            Multiplicity::Fixed(count) => {
                let element = lay(&[])?;
                let mut next = 0;
                for index in indices.into_iter().filter(|index| *index < count) {
                    repeat(index - next, &element, steps);
                    steps.extend(lay(&at(Some(index)))?);
                    next = index + 1;
                }
                repeat(count - next, &element, steps);
            }
            Multiplicity::Sequence => {
                let element = lay(&[])?;
                let mut picks = Vec::new();
                for index in indices {
                    picks.push((index, lay(&at(Some(index)))?));
                }
                steps.push(DecodeStep::Sequence { element, picks });
            }
        }
        Ok(())
    }

    fn lay_element(
        &self,
        kind: &FieldKind,
        wanted: &[(&[Segment], usize)],
        depth: usize,
        budget: &mut Budget,
    ) -> Result<Vec<DecodeStep>, Error> {
        Ok(match kind {
            FieldKind::Number(number) => vec![match wanted.first() {
                Some((_, slot)) => DecodeStep::Take {
                    number: *number,
                    slot: *slot,
                },
                None => DecodeStep::Skip {
                    size: number.size(),
                    count: 1,
                },
            }],
            FieldKind::Bool => vec![DecodeStep::Skip { size: 1, count: 1 }],
            FieldKind::Text => vec![DecodeStep::Text {
                slot: wanted.first().map(|(_, slot)| *slot),
            }],
            FieldKind::WideText => {
                return Err(unreadable(
                    "numbers, booleans, strings and messages",
                    "a wide string, whose layout differs between writers",
                ));
            }
            FieldKind::Message(name) => self.lay_type(name, wanted, depth - 1, budget)?,
        })
    }
}

/// Adds a type; a second definition must equal the first.
fn define(
    types: &mut BTreeMap<String, Vec<MessageField>>,
    name: &str,
    fields: Vec<MessageField>,
) -> Result<(), Error> {
    match types.get(name) {
        Some(known) if *known != fields => Err(unreadable(
            &format!("one definition of {name}"),
            "two that differ",
        )),
        Some(_) => Ok(()),
        None => {
            types.insert(name.to_string(), fields);
            Ok(())
        }
    }
}

/// Appends `count` times `element`.
fn repeat(count: u64, element: &[DecodeStep], steps: &mut Vec<DecodeStep>) {
    match (count, element) {
        // An empty ROS 1 type takes no byte, however many of it there are.
        (0, _) | (_, []) => {}
        (1, _) => steps.extend_from_slice(element),
        (_, [DecodeStep::Skip { size, count: 1 }]) => {
            steps.push(DecodeStep::Skip { size: *size, count })
        }
        _ => steps.push(DecodeStep::Repeat {
            count,
            element: element.to_vec(),
        }),
    }
}

/// Reads one line of a definition; `None` for comments, constants and empty lines.
fn field(line: &str, package: &str, dialect: Dialect) -> Result<Option<MessageField>, Error> {
    let line = line.split('#').next().unwrap_or_default().trim();
    if line.is_empty() {
        return Ok(None);
    }
    let bad = || {
        unreadable(
            "`type name` in the message definition",
            &format!("`{line}`"),
        )
    };
    let (type_text, rest) = line.split_once(char::is_whitespace).ok_or_else(bad)?;
    let rest = rest.trim_start();
    let end = rest
        .find(|c: char| !c.is_ascii_alphanumeric() && c != '_')
        .unwrap_or(rest.len());
    let (name, after) = rest.split_at(end);
    if name.is_empty() {
        return Err(bad());
    }
    if after.trim_start().starts_with('=') {
        return Ok(None);
    }
    if !after.is_empty() && !after.starts_with(char::is_whitespace) {
        return Err(bad());
    }
    let (element, count) = match type_text.split_once('[') {
        None => (type_text, Multiplicity::One),
        Some((element, size)) => {
            let size = size.strip_suffix(']').ok_or_else(bad)?;
            let count = if size.is_empty() || size.starts_with("<=") {
                Multiplicity::Sequence
            } else {
                let count = size.parse().map_err(|_| bad())?;
                if count == 0 {
                    return Err(bad());
                }
                Multiplicity::Fixed(count)
            };
            (element, count)
        }
    };
    // A bounded string reads as a string: the bound changes nothing in the message.
    let element = element.split("<=").next().unwrap_or_default();
    let kind = match element {
        "time" if dialect == Dialect::Ros1 => FieldKind::Message("ros1/time".into()),
        "duration" if dialect == Dialect::Ros1 => FieldKind::Message("ros1/duration".into()),
        "Header" if dialect == Dialect::Ros1 => FieldKind::Message("std_msgs/Header".into()),
        "byte" if dialect == Dialect::Ros1 => FieldKind::Number(Number::I8),
        "bool" => FieldKind::Bool,
        "byte" | "char" | "uint8" => FieldKind::Number(Number::U8),
        "int8" => FieldKind::Number(Number::I8),
        "int16" => FieldKind::Number(Number::I16),
        "uint16" => FieldKind::Number(Number::U16),
        "int32" => FieldKind::Number(Number::I32),
        "uint32" => FieldKind::Number(Number::U32),
        "int64" => FieldKind::Number(Number::I64),
        "uint64" => FieldKind::Number(Number::U64),
        "float32" => FieldKind::Number(Number::F32),
        "float64" => FieldKind::Number(Number::F64),
        "string" => FieldKind::Text,
        "wstring" => FieldKind::WideText,
        "" => return Err(bad()),
        other if other.contains('/') => FieldKind::Message(plain_name(other)),
        other => FieldKind::Message(format!("{package}/{other}")),
    };
    Ok(Some(MessageField {
        name: name.to_string(),
        kind,
        count,
    }))
}

/// Returns `package/Type` for `package/msg/Type`.
pub(super) fn plain_name(name: &str) -> String {
    name.replacen("/msg/", "/", 1)
}

/// Reads a field path such as `linear_acceleration.y` or `values[3].x`.
fn segments(path: &str) -> Option<Vec<Segment>> {
    path.split('.')
        .map(|part| {
            let (name, index) = match part.split_once('[') {
                None => (part, None),
                Some((name, index)) => (name, Some(index.strip_suffix(']')?.parse().ok()?)),
            };
            (!name.is_empty()).then(|| Segment {
                name: name.to_string(),
                index,
            })
        })
        .collect()
}

fn unreadable(expected: &str, found: &str) -> Error {
    ErrorKind::Malformed {
        expected: expected.to_string(),
        found: found.to_string(),
        hint: "the schema in the file cannot be read; export the channel as CSV".into(),
    }
    .into()
}
