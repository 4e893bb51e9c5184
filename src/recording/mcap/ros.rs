//! ROS message definitions (`ros2msg`, `ros1msg`): from the text in the file to a plan that finds
//! numbers in a message.
//!
//! The text holds the definition of one type, then those of the types it uses, divided by
//! lines of 80 `=`, each opened by `MSG: package/Type`. A [`DecodePlan`] is the definition laid
//! flat: what to step over and what to take.

use super::types::{
    Budget, DEPTH, Field, FieldKind, MessageTypes, Multiplicity, Number, Segment, segments,
    unreadable,
};
use crate::error::Error;

/// Shortest line of `=` that divides definitions.
const DIVIDER: usize = 80;

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

/// Reads the text of a schema whose first part defines `root`.
pub(super) fn types(root: &str, text: &str, dialect: Dialect) -> Result<MessageTypes, Error> {
    let root = plain_name(root);
    let mut name = root.clone();
    let mut types = MessageTypes {
        root,
        ..MessageTypes::default()
    };
    let mut fields: Vec<Field> = Vec::new();
    let mut opening = false;
    for line in text.lines().map(str::trim) {
        if line.len() >= DIVIDER && line.bytes().all(|byte| byte == b'=') {
            types.define(&name, std::mem::take(&mut fields))?;
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
        types.define(&name, fields)?;
    }
    // Every reader knows these, so that some recorders leave them out. ROS 1 has both as types of
    // their own, the time without a sign.
    let (signed, whole) = (Number::I32, Number::U32);
    for (name, parts) in [
        (
            "builtin_interfaces/Time",
            [("sec", signed), ("nanosec", whole)],
        ),
        (
            "builtin_interfaces/Duration",
            [("sec", signed), ("nanosec", whole)],
        ),
        ("ros1/time", [("secs", whole), ("nsecs", whole)]),
        ("ros1/duration", [("secs", signed), ("nsecs", signed)]),
    ] {
        let part = |(name, number)| Field::new(name, FieldKind::Number(number), Multiplicity::One);
        let fields = || parts.map(part).to_vec();
        types.types.entry(name.to_string()).or_insert_with(fields);
    }
    Ok(types)
}

/// Lays the definition flat so that path number i ends in slot i.
///
/// # Errors
///
/// [`crate::error::ErrorKind::Malformed`] if a type is missing or nested too deep, or if the message
/// holds wide strings, whose layout differs between writers.
pub(super) fn plan(
    types: &MessageTypes,
    dialect: Dialect,
    paths: &[String],
    budget: &mut Budget,
) -> Result<DecodePlan, Error> {
    let all = paths.iter().enumerate();
    let wanted: Vec<(Vec<Segment>, usize)> = all
        .filter_map(|(slot, path)| Some((segments(path)?, slot)))
        .collect();
    let wanted: Vec<(&[Segment], usize)> = wanted
        .iter()
        .map(|(segments, slot)| (segments.as_slice(), *slot))
        .collect();
    let mut planner = Planner {
        types,
        dialect,
        budget,
    };
    let steps = planner.lay_type(&types.root, &wanted, DEPTH)?;
    Ok(DecodePlan { steps })
}

/// Lays definitions flat.
struct Planner<'a> {
    types: &'a MessageTypes,
    dialect: Dialect,
    budget: &'a mut Budget,
}

impl Planner<'_> {
    fn lay_type(
        &mut self,
        type_name: &str,
        wanted: &[(&[Segment], usize)],
        depth: usize,
    ) -> Result<Vec<DecodeStep>, Error> {
        let types = self.types;
        let Some(fields) = types.types.get(type_name) else {
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
            self.lay_field(field, &inner, depth, &mut steps)?;
        }
        Ok(steps)
    }

    fn lay_field(
        &mut self,
        field: &Field,
        wanted: &[(Option<u64>, &[Segment], usize)],
        depth: usize,
        steps: &mut Vec<DecodeStep>,
    ) -> Result<(), Error> {
        self.budget.spend()?;
        let mut lay = |wanted: &[(&[Segment], usize)]| self.lay_element(&field.kind, wanted, depth);
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
        &mut self,
        kind: &FieldKind,
        wanted: &[(&[Segment], usize)],
        depth: usize,
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
            FieldKind::Other => {
                return Err(unreadable(
                    "numbers, booleans, strings and messages",
                    "a wide string, whose layout differs between writers",
                ));
            }
            FieldKind::Message(name) => self.lay_type(name, wanted, depth - 1)?,
        })
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
fn field(line: &str, package: &str, dialect: Dialect) -> Result<Option<Field>, Error> {
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
        "wstring" => FieldKind::Other,
        "" => return Err(bad()),
        other if other.contains('/') => FieldKind::Message(plain_name(other)),
        other => FieldKind::Message(format!("{package}/{other}")),
    };
    Ok(Some(Field::new(name, kind, count)))
}

/// Returns `package/Type` for `package/msg/Type`.
pub(super) fn plain_name(name: &str) -> String {
    name.replacen("/msg/", "/", 1)
}
