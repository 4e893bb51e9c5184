//! What is kept of an object of the file: its properties, and the samples of a channel.

use super::segment::{ObjectPath, RawIndex};
use super::value::{ByteOrder, DataType, Instant, Value, damaged};
use crate::Limits;
use crate::error::Error;
use crate::remarks::Cells;
use latchgate_kernel::error::Error as KernelError;

/// The file, a group or a channel.
#[derive(Debug)]
pub(super) struct Object {
    pub(super) path: ObjectPath,
    /// In the order in which they first came.
    properties: Vec<(String, Value)>,
    /// Where its samples stand in a chunk, as last stated.
    pub(super) index: Option<RawIndex>,
    /// Samples in the file, kept or not.
    pub(super) count: u64,
    /// The samples as they are stored; instants count from the first one [s].
    pub(super) values: Vec<f64>,
    first: Option<Instant>,
    /// Index of the first sample that is NaN, and how many are.
    pub(super) missing: Option<(usize, usize)>,
    /// Texts, each with its number.
    pub(super) texts: Cells<usize>,
    /// Whether samples are kept no more, for there are too many of all channels.
    pub(super) is_left_out: bool,
    /// What is wrong with the samples.
    pub(super) error: Option<Error>,
    /// The sample from which on another start is stated that does not go on from the one before.
    pub(super) restarted: Option<u64>,
}

/// Tells whether unit, clock or scale rest on a property.
fn is_binding(key: &str) -> bool {
    let small = key.to_lowercase();
    small == "unit_string"
        || [
            "wf_increment",
            "wf_start_offset",
            "wf_xunit_string",
            "wf_xname",
        ]
        .contains(&&*small)
        || small.starts_with("ni_scal")
        || small == "ni_number_of_scales"
}

impl Object {
    pub(super) fn new(path: ObjectPath) -> Self {
        Self {
            path,
            properties: Vec::new(),
            index: None,
            count: 0,
            values: Vec::new(),
            first: None,
            missing: None,
            texts: Cells::new(false),
            is_left_out: false,
            error: None,
            restarted: None,
        }
    }

    /// Returns a property that says something, whatever the case of its name.
    pub(super) fn property(&self, key: &str) -> Option<&Value> {
        let mut known = self.properties.iter();
        let (_, value) = known.find(|(known, _)| known.eq_ignore_ascii_case(key))?;
        Some(value).filter(|value| !value.text().is_empty())
    }

    pub(super) fn properties(&self) -> impl Iterator<Item = (&str, &Value)> {
        self.properties.iter().map(|(key, value)| (&**key, value))
    }

    /// Takes a property; returns by how many bytes the properties grow. `has_samples` if samples that
    /// it speaks of were read.
    pub(super) fn set(&mut self, key: String, value: Value, has_samples: bool) -> i64 {
        let bytes = |key: &str, value: &Value| match value {
            Value::Text(text) => (key.len() + text.len() + 64) as i64,
            _ => (key.len() + 64) as i64,
        };
        let Some(at) = self.properties.iter().position(|(known, _)| *known == key) else {
            let grown = bytes(&key, &value);
            self.properties.push((key, value));
            return grown;
        };
        let old = &self.properties[at].1;
        let changes = has_samples && *old != value && !old.text().is_empty();
        if changes && key == "wf_start_time" {
            // The start of the file's clock stays; the next samples follow, or do not.
            if !self.goes_on(old, &value) {
                self.restarted = self.restarted.or(Some(self.count));
            }
            return 0;
        }
        if changes && is_binding(&key) {
            let expected = format!("one `{key}` for all samples of a channel");
            let found = format!(
                "`{}`, and `{}` after {} samples",
                crate::text::shown(old.text()),
                crate::text::shown(value.text()),
                self.count
            );
            let error =
                Error::malformed(expected, found, "save each recording as a file of its own");
            self.error.get_or_insert(error);
        }
        let grown = bytes(&key, &value) - bytes(&key, old);
        self.properties[at].1 = value;
        grown
    }

    /// Tells whether samples that start at another instant go on where those before end.
    fn goes_on(&self, first: &Value, next: &Value) -> bool {
        let increment = self.property("wf_increment").and_then(Value::number);
        let (Value::Instant(first), Value::Instant(next), Some(interval)) =
            (first, next, increment)
        else {
            return false;
        };
        (next.since(*first) - self.count as f64 * interval).abs() < 0.5 * interval
    }

    /// Tells whether values are kept as numbers.
    pub(super) fn is_kept(&self) -> bool {
        !self.is_left_out && self.error.is_none()
    }

    /// Keeps no samples, those that were read among them.
    pub(super) fn leave_out(&mut self) {
        self.is_left_out = true;
        self.values = Vec::new();
    }

    /// Takes in one sample from its bytes.
    pub(super) fn take(&mut self, kind: DataType, bytes: &[u8], order: ByteOrder) {
        self.count += 1;
        let value = match kind {
            DataType::Timestamp => {
                let instant = Instant::read(bytes, order);
                instant.map(|instant| instant.since(*self.first.get_or_insert(instant)))
            }
            _ => kind.number(bytes, order),
        };
        let Some(value) = value.filter(|_| self.is_kept()) else {
            return;
        };
        if value.is_infinite() {
            let found = format!("{value} as sample {}", self.count);
            self.error = Some(KernelError::NonFinite { found }.into());
        } else if value.is_nan() {
            let (_, count) = self.missing.get_or_insert((self.values.len(), 0));
            *count += 1;
            self.values.push(self.values.last().copied().unwrap_or(0.0));
        } else {
            self.values.push(value);
        }
    }

    /// Takes in a chunk of texts: where each ends, then all of them.
    pub(super) fn take_texts(
        &mut self,
        count: u64,
        bytes: &[u8],
        order: ByteOrder,
    ) -> Result<(), Error> {
        let wrong = || {
            damaged(
                "texts with their ends before them",
                format!("{} bytes", bytes.len()),
            )
        };
        let ends = count
            .checked_mul(4)
            .and_then(|ends| usize::try_from(ends).ok());
        let (ends, texts) = ends
            .and_then(|ends| bytes.split_at_checked(ends))
            .ok_or_else(wrong)?;
        let mut start = 0;
        for end in ends.chunks_exact(4) {
            let end = DataType::U32.number(end, order).ok_or_else(wrong)? as usize;
            let text = texts.get(start..end).ok_or_else(wrong)?;
            self.texts
                .hear(self.values.len(), &super::value::decoded(text));
            self.count += 1;
            start = end;
        }
        match start == texts.len() {
            true => Ok(()),
            false => Err(wrong()),
        }
    }

    /// Refuses more samples than a channel may have.
    pub(super) fn check_count(&mut self, limits: &Limits) {
        if self.values.len() as u64 > limits.samples {
            self.values = Vec::new();
            self.error
                .get_or_insert(limits.over("samples", "more samples"));
        }
    }
}
