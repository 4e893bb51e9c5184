//! CDR, the encoding of ROS 2 messages: numbers aligned to their size, in either byte order;
//! and that of ROS 1, which is the same without alignment and header.
//!
//! Read is plain CDR (XCDR version 1), which every ROS 2 middleware writes into logs.

use super::records;
use super::ros::Dialect;
use super::types::{
    self, Budget, DEPTH, FieldKind, Leaf, MessageTypes, Multiplicity, Number, TextMark,
    damaged_message, unreadable,
};
use crate::error::Error;

/// Bytes of the header that tells the byte order.
const HEADER: usize = 4;
/// Bytes that may follow the last field: padding of the message to a multiple of four, as the
/// header's alignment asks. A field of four bytes that the schema lacks is no padding.
const PADDING: usize = 3;
/// Bytes of the count before a sequence or a text.
const COUNT: usize = 4;

/// The steps through the messages of a type; nested messages are laid out in line.
#[derive(Debug)]
pub(super) struct MessagePlan {
    steps: Vec<PlanStep>,
    dialect: Dialect,
}

/// A step through a message. Requested values go to slots.
#[derive(Debug)]
enum PlanStep {
    /// Passes over numbers of a size [byte], or over a sequence of them.
    Skip(usize, Option<u64>),
    Number(Number, Box<[usize]>),
    Text(Box<[usize]>),
    Array(Box<Array>),
}

/// An array, or a sequence if no count is given.
#[derive(Debug)]
struct Array {
    count: Option<u64>,
    /// The steps through an element that is not requested.
    element: Vec<PlanStep>,
    /// The requested elements in order.
    requested: Vec<(u64, Vec<PlanStep>)>,
}

/// A requested field: its slot, and the steps that are left to it.
#[derive(Clone, Copy)]
struct Target<'a> {
    slot: usize,
    steps: &'a [types::Step<'a>],
}

/// Plans the steps through the messages of a type to the fields at `paths`, each of which gets a
/// slot.
///
/// # Errors
///
/// For a type whose messages cannot be walked through.
pub(super) fn plan(
    types: &MessageTypes,
    dialect: Dialect,
    paths: &[String],
    budget: &mut Budget,
) -> Result<MessagePlan, Error> {
    let ways: Vec<_> = paths.iter().map(|path| types.way(path)).collect();
    let steps = ways.iter().map(|way| way.as_deref().unwrap_or_default());
    let targets = steps
        .enumerate()
        .map(|(slot, steps)| Target { slot, steps });
    let targets: Vec<Target<'_>> = targets.collect();
    let mut planner = Planner {
        types,
        dialect,
        budget,
    };
    let steps = planner.message(&types.root, &targets, DEPTH)?;
    Ok(MessagePlan { steps, dialect })
}

struct Planner<'a> {
    types: &'a MessageTypes,
    dialect: Dialect,
    budget: &'a mut Budget,
}

impl Planner<'_> {
    /// Plans a message; there is no step if it takes no byte.
    fn message<'w>(
        &mut self,
        name: &str,
        targets: &[Target<'w>],
        depth: usize,
    ) -> Result<Vec<PlanStep>, Error> {
        let Some(fields) = self.types.types.get(name) else {
            let expected = format!("a definition of {name}");
            return Err(unreadable(&expected, "none in the schema"));
        };
        if depth == 0 {
            let expected = format!("types nested at most {DEPTH} deep");
            return Err(unreadable(&expected, &format!("more, at {name}")));
        }
        if fields.is_empty() && self.dialect == Dialect::Ros2 {
            // An empty type of ROS 2 travels as one byte that stands for nothing.
            return Ok(vec![PlanStep::Skip(1, Some(1))]);
        }
        let mut steps = Vec::new();
        for field in fields {
            self.budget.spend()?;
            let step_into = |target: &Target<'w>| {
                let (step, steps) = target.steps.split_first()?;
                (step.field.name == field.name).then_some((step.index, Target { steps, ..*target }))
            };
            let mut within: Vec<_> = targets.iter().filter_map(step_into).collect();
            within.sort_by_key(|(index, _)| *index);
            let count = match field.count {
                Multiplicity::One => {
                    let within: Vec<_> = within.into_iter().map(|(_, target)| target).collect();
                    steps.append(&mut self.element(&field.kind, &within, depth)?);
                    continue;
                }
                Multiplicity::Fixed(count) => Some(count),
                Multiplicity::Sequence => None,
            };
            let element = self.element(&field.kind, &[], depth)?;
            let mut elements = Vec::new();
            for same in within.chunk_by(|(index, _), (next_index, _)| index == next_index) {
                let within: Vec<_> = same.iter().map(|(_, target)| *target).collect();
                let index = same[0].0.unwrap_or_default();
                elements.push((index, self.element(&field.kind, &within, depth)?));
            }
            steps.extend(array(&field.kind, count, element, elements));
        }
        Ok(steps)
    }

    fn element(
        &mut self,
        kind: &FieldKind,
        targets: &[Target<'_>],
        depth: usize,
    ) -> Result<Vec<PlanStep>, Error> {
        let slots = || targets.iter().map(|target| target.slot).collect();
        Ok(vec![match kind {
            FieldKind::Message(name) => return self.message(name, targets, depth - 1),
            FieldKind::Number(number) if targets.is_empty() => {
                PlanStep::Skip(number.size(), Some(1))
            }
            FieldKind::Number(number) => PlanStep::Number(*number, slots()),
            FieldKind::Bool => PlanStep::Skip(1, Some(1)),
            FieldKind::Text => PlanStep::Text(slots()),
            FieldKind::Other => {
                return Err(unreadable(
                    "numbers, booleans, strings and messages",
                    "a wide string, whose layout differs between writers",
                ));
            }
        }])
    }
}

/// Returns the step through an array, if it takes a byte.
fn array(
    kind: &FieldKind,
    count: Option<u64>,
    element: Vec<PlanStep>,
    requested: Vec<(u64, Vec<PlanStep>)>,
) -> Option<PlanStep> {
    match (kind, element.as_slice()) {
        // Of elements without a byte there is but the count.
        (_, []) => count.is_none().then_some(PlanStep::Skip(COUNT, Some(1))),
        (FieldKind::Number(_) | FieldKind::Bool, [PlanStep::Skip(size, _)])
            if requested.is_empty() =>
        {
            Some(PlanStep::Skip(*size, count))
        }
        _ => Some(PlanStep::Array(Box::new(Array {
            count,
            element,
            requested,
        }))),
    }
}

/// Walks through one message and puts the requested values into `slots`; each text may have
/// `longest` bytes.
pub(super) fn walk(
    plan: &MessagePlan,
    message: &[u8],
    longest: u64,
    slots: &mut [Option<Leaf>],
) -> Result<(), Error> {
    let (body, little, padding) = match (plan.dialect, message) {
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
        body,
        offset: 0,
        little,
        aligned: plan.dialect == Dialect::Ros2,
        longest,
        slots,
    };
    cursor.walk(&plan.steps)?;
    let bytes_left = body.len() - cursor.offset;
    if bytes_left > padding {
        let expected = "a message as long as its schema says";
        return Err(damaged_message(
            expected,
            &format!("{bytes_left} bytes more"),
        ));
    }
    Ok(())
}

struct CdrCursor<'a> {
    body: &'a [u8],
    offset: usize,
    little: bool,
    aligned: bool,
    /// Longest text let in [byte].
    longest: u64,
    slots: &'a mut [Option<Leaf>],
}

impl<'a> CdrCursor<'a> {
    fn walk(&mut self, steps: &[PlanStep]) -> Result<(), Error> {
        for step in steps {
            match step {
                PlanStep::Skip(size, count) => {
                    let count = self.count(*count)?;
                    self.skip(*size, count)?;
                }
                PlanStep::Number(number, slots) => {
                    let value = number.value(self.bits(number.size())?);
                    self.put(slots, || Leaf::Number(value));
                }
                PlanStep::Text(slots) => {
                    let text = self.text()?;
                    // The zero at the end, which some writers leave out, is none of the text.
                    let text = text.strip_suffix(&[0]).unwrap_or(text);
                    self.put(slots, || Leaf::Text(TextMark::new(text)));
                }
                PlanStep::Array(array) => self.array(array)?,
            }
        }
        Ok(())
    }

    fn put(&mut self, slots: &[usize], leaf: impl Fn() -> Leaf) {
        for slot in slots {
            self.slots[*slot] = Some(leaf());
        }
    }

    fn array(&mut self, array: &Array) -> Result<(), Error> {
        let count = self.count(array.count)?;
        let mut next = 0;
        for (index, steps) in array.requested.iter().filter(|(index, _)| *index < count) {
            self.repeat(&array.element, index - next)?;
            self.walk(steps)?;
            next = index + 1;
        }
        self.repeat(&array.element, count - next)
    }

    // Every element takes at least one byte, so that a count which promises more than the message
    // holds ends at the end of the message.
    fn repeat(&mut self, element: &[PlanStep], count: u64) -> Result<(), Error> {
        // Numbers of which one is beyond the end go singly up to that one, which the error names.
        if let [PlanStep::Skip(size, Some(1))] = element
            && self.skip(*size, count).is_ok()
        {
            return Ok(());
        }
        (0..count).try_for_each(|_| self.walk(element))
    }

    /// Reads the count of a sequence, unless it is fixed.
    fn count(&mut self, fixed_count: Option<u64>) -> Result<u64, Error> {
        fixed_count.map_or_else(|| self.bits(COUNT), Ok)
    }

    fn text(&mut self) -> Result<&'a [u8], Error> {
        let length = self.bits(COUNT)?;
        if length > self.longest {
            return Err(records::too_long(self.longest, length, "message"));
        }
        self.take(1, usize::try_from(length).unwrap_or(usize::MAX))
    }

    fn bits(&mut self, size: usize) -> Result<u64, Error> {
        let bytes = self.take(size, size)?.iter();
        let push = |bits: u64, byte: &u8| (bits << 8) | u64::from(*byte);
        Ok(match self.little {
            true => bytes.rev().fold(0, push),
            false => bytes.fold(0, push),
        })
    }

    /// Passes over numbers of a size [byte].
    fn skip(&mut self, size: usize, count: u64) -> Result<(), Error> {
        if count > 0 {
            let count = usize::try_from(count).ok();
            let bytes = count.and_then(|count| count.checked_mul(size));
            self.take(size, bytes.unwrap_or(usize::MAX))?;
        }
        Ok(())
    }

    /// Steps to a multiple of `size` [byte], a power of two, and takes `count` bytes.
    fn take(&mut self, size: usize, count: usize) -> Result<&'a [u8], Error> {
        let start = match self.aligned {
            true => (self.offset + size - 1) & !(size - 1),
            false => self.offset,
        };
        let end = start.checked_add(count);
        let Some(bytes) = end.and_then(|end| self.body.get(start..end)) else {
            return Err(self.ends_before(start));
        };
        self.offset = start + count;
        Ok(bytes)
    }

    #[cold]
    fn ends_before(&self, start: usize) -> Error {
        let expected = format!("a field at byte {} of the message", HEADER + start);
        let end = HEADER + self.body.len();
        let found = format!("the end of the message at byte {end}");
        damaged_message(&expected, &found)
    }
}
