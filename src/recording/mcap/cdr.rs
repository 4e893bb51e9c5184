//! CDR, the encoding of ROS 2 messages: numbers aligned to their size, in either byte order;
//! and that of ROS 1, which is the same without alignment and header.
//!
//! Read is plain CDR (XCDR version 1), which every ROS 2 middleware writes into logs.

use super::records;
use super::ros::Dialect;
use super::types::{
    Field, FieldKind, Leaf, MessageTypes, Multiplicity, Number, Sink, damaged_message, fingerprint,
    leads_on, step_into,
};
use crate::error::Error;

/// Bytes of the header that tells the byte order.
const HEADER: usize = 4;
/// Bytes that may follow the last field: padding of the message to a multiple of four, as the
/// header's alignment asks. A field of four bytes that the schema lacks is no padding.
const PADDING: usize = 3;

/// Walks through one message; of arrays only those with `wanted` elements are handed out, and of
/// texts those that are wanted, each of at most `longest` [byte].
pub(super) fn walk(
    types: &MessageTypes,
    dialect: Dialect,
    message: &[u8],
    (wanted, longest): (&[String], u64),
    sink: Sink<'_>,
) -> Result<(), Error> {
    let (body, little, padding) = match (dialect, message) {
        (Dialect::Ros1, _) => (message, true, 0),
        (Dialect::Ros2, [0, order @ (0 | 1), _, _, body @ ..]) => (body, *order == 1, PADDING),
        (Dialect::Ros2, [high, low, _, _, ..]) => {
            let expected = "a CDR header of 00 00 or 00 01 (plain CDR)";
            return Err(damaged_message(expected, &format!("{high:02x} {low:02x}")));
        }
        (Dialect::Ros2, short) => {
            let expected = "a message with a CDR header of 4 bytes";
            return Err(damaged_message(expected, &format!("{} bytes", short.len())));
        }
    };
    let mut cursor = CdrCursor {
        types,
        wanted,
        path: String::new(),
        body,
        at: 0,
        little,
        aligned: dialect == Dialect::Ros2,
        longest,
    };
    cursor.message(&types.root, sink)?;
    let left = body.len() - cursor.at;
    if left > padding {
        let expected = "a message as long as its schema says";
        return Err(damaged_message(expected, &format!("{left} bytes more")));
    }
    Ok(())
}

struct CdrCursor<'a> {
    types: &'a MessageTypes,
    wanted: &'a [String],
    /// Path of the field at hand.
    path: String,
    body: &'a [u8],
    at: usize,
    little: bool,
    aligned: bool,
    /// Longest text let in [byte].
    longest: u64,
}

impl<'a> CdrCursor<'a> {
    fn message(&mut self, name: &str, sink: Sink<'_>) -> Result<(), Error> {
        let types = self.types;
        let fields = types.types.get(name).map_or(&[][..], Vec::as_slice);
        if fields.is_empty() {
            // An empty type of ROS 2 travels as one byte that stands for nothing.
            return self.aligned(1, usize::from(self.aligned)).map(|_| ());
        }
        for field in fields {
            let before = self.path.len();
            step_into(&mut self.path, &field.name);
            self.field(field, sink)?;
            self.path.truncate(before);
        }
        Ok(())
    }

    // Every element takes at least one byte, so that a count which promises more than the message
    // holds ends at the end of the message.
    fn field(&mut self, field: &Field, sink: Sink<'_>) -> Result<(), Error> {
        let count = match field.count {
            Multiplicity::One => return self.element(&field.kind, sink),
            Multiplicity::Fixed(count) => count,
            Multiplicity::Sequence => self.length()?,
        };
        let size = match &field.kind {
            FieldKind::Message(name) if self.types.empty.contains(name) => return Ok(()),
            FieldKind::Number(number) => number.size(),
            FieldKind::Bool => 1,
            _ => 0,
        };
        if size > 0 && count > 0 && !leads_on(&self.path, self.wanted) {
            let count = usize::try_from(count).ok();
            let bytes = count.and_then(|count| count.checked_mul(size));
            return self.aligned(size, bytes.unwrap_or(usize::MAX)).map(|_| ());
        }
        let before = self.path.len();
        for index in 0..count {
            self.path.push_str(&format!("[{index}]"));
            self.element(&field.kind, sink)?;
            self.path.truncate(before);
        }
        Ok(())
    }

    fn element(&mut self, kind: &FieldKind, sink: Sink<'_>) -> Result<(), Error> {
        let leaf = match kind {
            FieldKind::Message(name) => return self.message(name, sink),
            FieldKind::Number(number) => Leaf::Number(self.number(*number)?),
            FieldKind::Bool => self.aligned(1, 1).map(|_| Leaf::Boolean)?,
            FieldKind::Text | FieldKind::Other => {
                let length = self.length()?;
                if length > self.longest {
                    return Err(records::too_long(self.longest, length, "message"));
                }
                let text = self.aligned(1, usize::try_from(length).unwrap_or(usize::MAX))?;
                if !self.wanted.contains(&self.path) {
                    return Ok(());
                }
                // The zero at the end, which some writers leave out, is none of the text.
                Leaf::Text(fingerprint(text.strip_suffix(&[0]).unwrap_or(text)))
            }
        };
        sink(&self.path, leaf);
        Ok(())
    }

    fn length(&mut self) -> Result<u64, Error> {
        self.bits(4)
    }

    fn number(&mut self, number: Number) -> Result<f64, Error> {
        Ok(number.value(self.bits(number.size())?))
    }

    fn bits(&mut self, size: usize) -> Result<u64, Error> {
        let mut array = [0; 8];
        array[..size].copy_from_slice(self.aligned(size, size)?);
        if !self.little {
            array[..size].reverse();
        }
        Ok(u64::from_le_bytes(array))
    }

    /// Steps to a multiple of `size` [byte] and takes `count` bytes.
    fn aligned(&mut self, size: usize, count: usize) -> Result<&'a [u8], Error> {
        let start = match self.aligned {
            true => self.at.next_multiple_of(size),
            false => self.at,
        };
        let end = start.checked_add(count);
        let Some(taken) = end.and_then(|end| self.body.get(start..end)) else {
            let expected = format!("a field at byte {} of the message", HEADER + start);
            let end = HEADER + self.body.len();
            let found = format!("the end of the message at byte {end}");
            return Err(damaged_message(&expected, &found));
        };
        self.at = start + count;
        Ok(taken)
    }
}
