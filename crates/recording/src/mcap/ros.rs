//! ROS message definitions (`ros2msg`, `ros1msg`), as the file holds them.
//!
//! The text holds the definition of one type, then those of the types it uses, divided by
//! lines of 80 `=`, each opened by `MSG: package/Type`.

use super::types::{Field, FieldKind, MessageTypes, Multiplicity, Number, unreadable};
use crate::error::Error;
use std::collections::BTreeSet;

/// Shortest line of `=` that divides definitions.
const DIVIDER: usize = 80;

/// The version of ROS, which decides definitions and encoding.
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
    let mut names = BTreeSet::new();
    let mut opening = false;
    for line in text.lines().map(str::trim) {
        if line.len() >= DIVIDER && line.bytes().all(|byte| byte == b'=') {
            types.define(&name, std::mem::take(&mut fields))?;
            names.clear();
            opening = true;
        } else if opening {
            if line.is_empty() {
                continue;
            }
            let Some(named) = line.strip_prefix("MSG:") else {
                let expected = "`MSG: package/Type` after the dividing line";
                return Err(unreadable(expected, &format!("`{line}`")));
            };
            name = plain_name(named.trim());
            opening = false;
        } else {
            let package = name.split('/').next().unwrap_or_default();
            if let Some(field) = field(line, package, dialect)? {
                if !names.insert(field.name.clone()) {
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
    let (signed, unsigned) = (Number::I32, Number::U32);
    let of_ros2 = [("sec", signed), ("nanosec", unsigned)];
    for (name, parts) in [
        ("builtin_interfaces/Time", of_ros2),
        ("builtin_interfaces/Duration", of_ros2),
        ("ros1/time", [("secs", unsigned), ("nsecs", unsigned)]),
        ("ros1/duration", [("secs", signed), ("nsecs", signed)]),
    ] {
        let part = |(name, number)| Field::new(name, FieldKind::Number(number), Multiplicity::One);
        let fields = || parts.map(part).to_vec();
        types.types.entry(name.to_string()).or_insert_with(fields);
    }
    Ok(types)
}

/// Reads one line of a definition; `None` for comments, constants and empty lines.
fn field(line: &str, package: &str, dialect: Dialect) -> Result<Option<Field>, Error> {
    let line = line.split('#').next().unwrap_or_default().trim();
    if line.is_empty() {
        return Ok(None);
    }
    let expected = "`type name` in the message definition";
    let bad = || unreadable(expected, &format!("`{line}`"));
    let (type_text, after_type) = line.split_once(char::is_whitespace).ok_or_else(bad)?;
    let after_type = after_type.trim_start();
    let end = after_type
        .find(|c: char| !c.is_ascii_alphanumeric() && c != '_')
        .unwrap_or(after_type.len());
    let (name, after) = after_type.split_at(end);
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
        type_name if type_name.contains('/') => FieldKind::Message(plain_name(type_name)),
        type_name => FieldKind::Message(format!("{package}/{type_name}")),
    };
    Ok(Some(Field::new(name, kind, count)))
}

/// Returns `package/Type` for `package/msg/Type`.
pub(super) fn plain_name(name: &str) -> String {
    name.replacen("/msg/", "/", 1)
}
