//! CDR, the encoding of ROS 2 messages: numbers aligned to their size, in either byte order;
//! and that of ROS 1, which is the same without alignment and header.
//!
//! Read is plain CDR (XCDR version 1), which every ROS 2 middleware writes into logs.

use super::ros::Dialect;
use super::types::{Field, FieldKind, MessageTypes, Multiplicity, Number, Picker, Wanted, through};

/// Bytes of the header that tells the byte order.
const HEADER: usize = 4;
/// Bytes that may follow the last field: padding of the message to a multiple of four, as the
/// header's alignment asks. A field of four bytes that the schema lacks is no padding.
const PADDING: usize = 3;

/// Walks through one message and puts the numbers that are picked into `slots`; `longest` is the
/// longest text let in [byte].
///
/// # Errors
///
/// What is wrong with the message, in words: expected, then found.
pub(super) fn read(
    picker: &Picker,
    dialect: Dialect,
    message: &[u8],
    slots: &mut [f64],
    longest: u64,
) -> Result<(), MessageFault> {
    let (body, little, padding) = match (dialect, message) {
        (Dialect::Ros1, _) => (message, true, 0),
        (Dialect::Ros2, [0, order @ (0 | 1), _, _, body @ ..]) => (body, *order == 1, PADDING),
        (Dialect::Ros2, [high, low, _, _, ..]) => {
            return Err(fault(
                "a CDR header of 00 00 or 00 01 (plain CDR)",
                &format!("{high:02x} {low:02x}"),
            ));
        }
        (Dialect::Ros2, short) => {
            return Err(fault(
                "a message with a CDR header of 4 bytes",
                &format!("{} bytes", short.len()),
            ));
        }
    };
    let mut cursor = CdrCursor {
        types: &picker.types,
        body,
        at: 0,
        little,
        aligned: dialect == Dialect::Ros2,
        longest,
    };
    cursor.message(&picker.types.root, &picker.wanted(), slots)?;
    let left = body.len() - cursor.at;
    if left > padding {
        return Err(fault(
            "a message as long as its schema says",
            &format!("{left} bytes more"),
        ));
    }
    Ok(())
}

/// What is wrong with a message.
#[derive(Debug)]
pub(super) struct MessageFault {
    pub(super) expected: String,
    pub(super) found: String,
    /// Length of a text that is longer than allowed [byte].
    pub(super) too_long: Option<u64>,
}

fn fault(expected: &str, found: &str) -> MessageFault {
    MessageFault {
        expected: expected.to_string(),
        found: found.to_string(),
        too_long: None,
    }
}

/// Returns a number that two texts share only by a chance of one in 2⁵³.
pub(super) fn fingerprint(text: &[u8]) -> f64 {
    (hash(text) >> 11) as f64
}

/// Returns the hash of a text (FNV-1a).
pub(super) fn hash(text: &[u8]) -> u64 {
    text.iter().fold(0xCBF2_9CE4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01B3)
    })
}

struct CdrCursor<'a> {
    types: &'a MessageTypes,
    body: &'a [u8],
    at: usize,
    little: bool,
    aligned: bool,
    /// Longest text let in [byte].
    longest: u64,
}

impl<'a> CdrCursor<'a> {
    fn message(
        &mut self,
        name: &str,
        wanted: &[Wanted<'_>],
        slots: &mut [f64],
    ) -> Result<(), MessageFault> {
        let types = self.types;
        let fields = types.types.get(name).map_or(&[][..], Vec::as_slice);
        if fields.is_empty() {
            // An empty type of ROS 2 travels as one byte that stands for nothing.
            return self.aligned(1, usize::from(self.aligned)).map(|_| ());
        }
        for field in fields {
            self.field(field, &through(wanted, field), slots)?;
        }
        Ok(())
    }

    // Every element takes at least one byte, so that a count which promises more than the message
    // holds ends at the end of the message.
    fn field(
        &mut self,
        field: &Field,
        wanted: &[(Option<u64>, Wanted<'_>)],
        slots: &mut [f64],
    ) -> Result<(), MessageFault> {
        let count = match field.count {
            Multiplicity::One => 1,
            Multiplicity::Fixed(count) => count,
            Multiplicity::Sequence => self.length()?,
        };
        if let Some(index) = wanted.iter().filter_map(|(index, _)| *index).max()
            && index >= count
        {
            return Err(fault(
                &format!("an element {index} in the sequence"),
                &format!("{count} elements"),
            ));
        }
        let size = match &field.kind {
            FieldKind::Message(name) if self.types.empty.contains(name) => return Ok(()),
            FieldKind::Number(number) => number.size(),
            FieldKind::Bool => 1,
            _ => 0,
        };
        if wanted.is_empty() && size > 0 && count > 0 {
            let count = usize::try_from(count).ok();
            let bytes = count.and_then(|count| count.checked_mul(size));
            return self.aligned(size, bytes.unwrap_or(usize::MAX)).map(|_| ());
        }
        for index in 0..count {
            let here = wanted.iter();
            let here = here.filter(|(at, _)| at.is_none_or(|at| at == index));
            let here: Vec<Wanted<'_>> = here.map(|(_, wanted)| *wanted).collect();
            self.element(&field.kind, &here, slots)?;
        }
        Ok(())
    }

    fn element(
        &mut self,
        kind: &FieldKind,
        wanted: &[Wanted<'_>],
        slots: &mut [f64],
    ) -> Result<(), MessageFault> {
        let value = match kind {
            FieldKind::Message(name) => return self.message(name, wanted, slots),
            FieldKind::Number(number) => self.number(*number)?,
            FieldKind::Bool => f64::from(self.aligned(1, 1)?[0]),
            FieldKind::Text | FieldKind::Other => {
                let length = self.length()?;
                if length > self.longest {
                    return Err(MessageFault {
                        too_long: Some(length),
                        ..fault("a shorter string", "a longer one")
                    });
                }
                let text = self.aligned(1, usize::try_from(length).unwrap_or(usize::MAX))?;
                if wanted.is_empty() {
                    return Ok(());
                }
                // The zero at the end, which some writers leave out, is none of the text.
                fingerprint(text.strip_suffix(&[0]).unwrap_or(text))
            }
        };
        for (_, slot) in wanted {
            slots[*slot] = value;
        }
        Ok(())
    }

    fn length(&mut self) -> Result<u64, MessageFault> {
        self.bits(4)
    }

    fn number(&mut self, number: Number) -> Result<f64, MessageFault> {
        Ok(number.value(self.bits(number.size())?))
    }

    fn bits(&mut self, size: usize) -> Result<u64, MessageFault> {
        let mut array = [0; 8];
        array[..size].copy_from_slice(self.aligned(size, size)?);
        if !self.little {
            array[..size].reverse();
        }
        Ok(u64::from_le_bytes(array))
    }

    /// Steps to a multiple of `size` [byte] and takes `count` bytes.
    fn aligned(&mut self, size: usize, count: usize) -> Result<&'a [u8], MessageFault> {
        let start = if self.aligned {
            self.at.next_multiple_of(size)
        } else {
            self.at
        };
        let taken = start
            .checked_add(count)
            .and_then(|end| self.body.get(start..end));
        let Some(taken) = taken else {
            return Err(fault(
                &format!("a field at byte {} of the message", HEADER + start),
                &format!(
                    "the end of the message at byte {}",
                    HEADER + self.body.len()
                ),
            ));
        };
        self.at = start + count;
        Ok(taken)
    }
}
