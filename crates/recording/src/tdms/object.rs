//! What is kept of an object of the file: its properties, and the samples of a channel.

use super::segment::{ObjectPath, RawIndex};
use super::value::{ByteOrder, DataType, Instant, Value, damaged};
use crate::Limits;
use crate::error::Error;
use crate::remarks::Cells;
use latchgate_kernel::error::Error as KernelError;
use std::collections::BTreeMap;

/// The file, a group or a channel.
#[derive(Debug)]
pub(super) struct Object {
    pub(super) path: ObjectPath,
    /// In the order in which they first came.
    properties: Vec<(String, Value)>,
    /// Their places by name; of those that are binding the name is in small letters.
    places: BTreeMap<String, usize>,
    /// The first place of each name in small letters.
    small_places: BTreeMap<String, usize>,
    /// Instants stated as `wf_start_time`, each with the number of samples before it.
    starts: Vec<StatedStart>,
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
    /// The sample from which on another start is stated that is no instant.
    restarted: Option<u64>,
}

/// An instant stated as a start, with the number of samples before it.
type StatedStart = (u64, Instant);

/// Tells whether unit, clock or scale rest on a property.
pub(super) fn is_binding(key: &str) -> bool {
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
            places: BTreeMap::new(),
            small_places: BTreeMap::new(),
            starts: Vec::new(),
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
        self.stated(key).filter(|value| !value.text().is_empty())
    }

    /// Returns a property, be it empty or of a type that is not read, whatever the case of its name.
    pub(super) fn stated(&self, key: &str) -> Option<&Value> {
        let place = self.small_places.get(&key.to_lowercase())?;
        Some(&self.properties[*place].1)
    }

    /// Returns the names in small letters that begin with `start`.
    pub(super) fn keys_from(&self, start: &str) -> impl Iterator<Item = &str> {
        let from = self.small_places.range(start.to_string()..);
        from.map(|(key, _)| &**key)
            .take_while(move |key| key.starts_with(start))
    }

    pub(super) fn properties(&self) -> impl Iterator<Item = (&str, &Value)> {
        self.properties.iter().map(|(key, value)| (&**key, value))
    }

    /// Takes a property; returns by how many bytes the properties grow. `has_samples` if samples that
    /// it speaks of were read.
    pub(super) fn set(&mut self, key: String, value: Value, has_samples: bool) -> i64 {
        let bytes = |key: &str, value: &Value| match value {
            Value::Text(text) => (3 * key.len() + text.len() + 64) as i64,
            _ => (3 * key.len() + 64) as i64,
        };
        let small = key.to_lowercase();
        let is_start = small == "wf_start_time";
        let is_one = is_start || is_binding(&key);
        if is_binding(&key) && matches!(value, Value::Other) {
            let property = format!("`{}` of another type", crate::text::shown(&key));
            let hint = "save it as double precision";
            let error = Error::malformed("a number or a text", property, hint);
            self.error.get_or_insert(error);
        }
        let mut grown = 0;
        if let (true, Value::Instant(instant)) = (is_start, &value)
            && self.starts.last().is_none_or(|(_, last)| last != instant)
        {
            self.starts.push((self.count, *instant));
            grown += 32;
        }
        let place_key = if is_one { &small } else { &key };
        let Some(place) = self.places.get(place_key).copied() else {
            grown += bytes(&key, &value);
            let place = self.properties.len();
            self.places.insert(place_key.clone(), place);
            self.small_places.entry(small).or_insert(place);
            self.properties.push((key, value));
            return grown;
        };
        let old = &self.properties[place].1;
        let changes = has_samples && *old != value && !old.text().is_empty();
        if changes && is_start {
            // The start of the file's clock stays; the next samples follow, or do not.
            let are_instants = matches!((old, &value), (Value::Instant(_), Value::Instant(_)));
            if !are_instants {
                self.restarted = self.restarted.or(Some(self.count));
            }
            return grown;
        }
        if changes && is_binding(&key) {
            let expected = format!("one `{key}` for all samples of a channel");
            let both_values = format!(
                "`{}`, and `{}` after {} samples",
                crate::text::shown(old.text()),
                crate::text::shown(value.text()),
                self.count
            );
            let error = Error::malformed(
                expected,
                both_values,
                "save each recording as a file of its own",
            );
            self.error.get_or_insert(error);
        }
        grown += bytes(&key, &value) - bytes(&key, old);
        self.properties[place].1 = value;
        grown
    }

    /// Returns the instants stated before the first sample, and those stated later.
    fn starts(&self) -> (&[StatedStart], &[StatedStart]) {
        let is_before = |(count, _): &StatedStart| *count == 0;
        self.starts.split_at(self.starts.partition_point(is_before))
    }

    fn first_start(&self) -> Option<&StatedStart> {
        // Of those before the first sample the last counts.
        let (before, later) = self.starts();
        before.last().or(later.first())
    }

    /// Returns by how much its start is stated after that of another object [s].
    pub(super) fn starts_after(&self, other: &Self) -> Option<f64> {
        let ((_, own), (_, others)) = (self.first_start()?, other.first_start()?);
        Some(own.since(*others))
    }

    /// Returns the sample from which on another start is stated that does not go on where those before end.
    pub(super) fn restarted(&self, interval_s: f64) -> Option<u64> {
        let (_, later) = self.starts();
        let first = self.first_start();
        let breaks = |(count, instant): &&(u64, Instant)| {
            first.is_some_and(|(first_count, first)| {
                let samples = count.saturating_sub(*first_count) as f64;
                let off_s = instant.since(*first) - samples * interval_s;
                off_s.abs() >= 0.5 * interval_s
            })
        };
        let stated = later.iter().find(breaks).map(|(count, _)| *count);
        stated.into_iter().chain(self.restarted).min()
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
            let sample = format!("{value} as sample {}", self.count);
            self.error = Some(KernelError::NonFinite { found: sample }.into());
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

/// Tells whether a property is one of the format's own, and no word of a person's.
pub(super) fn is_technical(key: &str) -> bool {
    let small = key.to_lowercase();
    ["ni_", "wf_"].iter().any(|start| small.starts_with(start))
        || [
            "name",
            "unit_string",
            "datatype",
            "displaytype",
            "monotony",
            "novaluekey",
        ]
        .contains(&&*small)
}
