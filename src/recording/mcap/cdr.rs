//! CDR, the encoding of ROS 2 messages: numbers aligned to their size, in either byte order;
//! and that of ROS 1, which is the same without alignment and header.
//!
//! Read is plain CDR (XCDR version 1), which every ROS 2 middleware writes into logs.

use super::ros::{DecodePlan, DecodeStep};
use super::types::Number;

/// Bytes of the header that tells the byte order.
const HEADER: usize = 4;
/// Bytes that may follow the last field: padding of the message to a multiple of four, as the
/// header's alignment asks. A field of four bytes that the schema lacks is no padding.
const PADDING: usize = 3;

/// Walks one message along `plan` and puts what it takes into `slots`; `longest` is the longest
/// text let in [byte].
///
/// # Errors
///
/// What is wrong with the message, in words: expected, then found.
pub(super) fn read(
    plan: &DecodePlan,
    message: &[u8],
    slots: &mut [f64],
    longest: u64,
) -> Result<(), MessageFault> {
    let Some((header, body)) = message.split_at_checked(HEADER) else {
        return Err(fault(
            "a message with a CDR header of 4 bytes",
            &format!("{} bytes", message.len()),
        ));
    };
    let little = match (header[0], header[1]) {
        (0, 0) => false,
        (0, 1) => true,
        (high, low) => {
            return Err(fault(
                "a CDR header of 00 00 or 00 01 (plain CDR)",
                &format!("{high:02x} {low:02x}"),
            ));
        }
    };
    finish(
        CdrCursor {
            body,
            at: 0,
            little,
            aligned: true,
            longest,
        },
        plan,
        slots,
        PADDING,
    )
}

/// Walks one ROS 1 message: little-endian numbers one after another, without a header.
///
/// # Errors
///
/// As [`read`].
pub(super) fn read_ros1(
    plan: &DecodePlan,
    message: &[u8],
    slots: &mut [f64],
    longest: u64,
) -> Result<(), MessageFault> {
    let walk = CdrCursor {
        body: message,
        at: 0,
        little: true,
        aligned: false,
        longest,
    };
    finish(walk, plan, slots, 0)
}

fn finish(
    mut walk: CdrCursor<'_>,
    plan: &DecodePlan,
    slots: &mut [f64],
    padding: usize,
) -> Result<(), MessageFault> {
    walk.run(&plan.steps, slots)?;
    let left = walk.body.len() - walk.at;
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
    body: &'a [u8],
    at: usize,
    little: bool,
    aligned: bool,
    /// Longest text let in [byte].
    longest: u64,
}

impl<'a> CdrCursor<'a> {
    // Every element of a repeat or a sequence takes at least one byte, so that a count which
    // promises more than the message holds ends at the end of the message.
    fn run(&mut self, steps: &[DecodeStep], slots: &mut [f64]) -> Result<(), MessageFault> {
        for step in steps {
            match step {
                DecodeStep::Skip { size, count } => {
                    let bytes = usize::try_from(*count)
                        .ok()
                        .and_then(|count| count.checked_mul(*size));
                    self.aligned(*size, bytes.unwrap_or(usize::MAX))?;
                }
                DecodeStep::Take { number, slot } => {
                    let value = self.number(*number)?;
                    if let Some(place) = slots.get_mut(*slot) {
                        *place = value;
                    }
                }
                DecodeStep::Text { slot } => {
                    let length = self.length()?;
                    if length > self.longest {
                        return Err(MessageFault {
                            too_long: Some(length),
                            ..fault("a shorter string", "a longer one")
                        });
                    }
                    let text = self.aligned(1, usize::try_from(length).unwrap_or(usize::MAX))?;
                    if let Some(place) = slot.and_then(|slot| slots.get_mut(slot)) {
                        // The zero at the end, which some writers leave out, is none of the text.
                        *place = fingerprint(text.strip_suffix(&[0]).unwrap_or(text));
                    }
                }
                DecodeStep::Repeat { count, element } => {
                    for _ in 0..*count {
                        self.run(element, slots)?;
                    }
                }
                DecodeStep::Sequence { element, picks } => self.sequence(element, picks, slots)?,
            }
        }
        Ok(())
    }

    fn sequence(
        &mut self,
        element: &[DecodeStep],
        picks: &[(u64, Vec<DecodeStep>)],
        slots: &mut [f64],
    ) -> Result<(), MessageFault> {
        let length = self.length()?;
        if let Some((index, _)) = picks.last()
            && *index >= length
        {
            return Err(fault(
                &format!("an element {index} in the sequence"),
                &format!("{length} elements"),
            ));
        }
        if let ([DecodeStep::Skip { size, count: 1 }], [], 1..) = (element, picks, length) {
            let bytes = usize::try_from(length)
                .ok()
                .and_then(|length| length.checked_mul(*size));
            self.aligned(*size, bytes.unwrap_or(usize::MAX))?;
            return Ok(());
        }
        if element.is_empty() && picks.is_empty() {
            return Ok(());
        }
        let mut picks = picks.iter().peekable();
        for index in 0..length {
            match picks.next_if(|(wanted, _)| *wanted == index) {
                Some((_, steps)) => self.run(steps, slots)?,
                None => self.run(element, slots)?,
            }
        }
        Ok(())
    }

    fn length(&mut self) -> Result<u64, MessageFault> {
        let bytes = self.aligned(4, 4)?;
        let mut array = [0; 4];
        array.copy_from_slice(bytes);
        Ok(u64::from(if self.little {
            u32::from_le_bytes(array)
        } else {
            u32::from_be_bytes(array)
        }))
    }

    fn number(&mut self, number: Number) -> Result<f64, MessageFault> {
        let size = number.size();
        let mut array = [0; 8];
        array[..size].copy_from_slice(self.aligned(size, size)?);
        if !self.little {
            array[..size].reverse();
        }
        Ok(number.value(u64::from_le_bytes(array)))
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
