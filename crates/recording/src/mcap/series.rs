//! One topic's messages turned into numbers, each at its stamp.

use super::clock::{MessageBase, MessageTimes};
use super::layout::{
    self, Contents, ESTIMATE, FRAME, IMU_FIELD, IMU_PATH, LayoutResult, MessageLayout, Messages,
    RequestedFields, Unfit, name_of,
};
use super::types::{Leaf, damaged_message, hash};
use super::{cdr, json, protobuf};
use crate::channel_name::ChannelName;
use crate::draft::{Draft, UniformSamples, Unit, UnitStatement};
use crate::error::{Error, Place};
use crate::remarks::Remark;
use crate::{Channel, Limits, ReadOptions, Selection};
use latchgate_kernel::error::Error as KernelError;
use latchgate_kernel::units::AccelerationUnit;
use std::rc::Rc;

/// One field's values.
#[derive(Debug, Default)]
struct FieldColumn {
    path: String,
    unit: Option<AccelerationUnit>,
    values: Vec<f64>,
    /// True if the setting `channel` does not mean it, so that a limit may drop its values.
    is_neighbour: bool,
    /// The first thing wrong with this field; its values end there.
    error: Option<Error>,
}

/// A field of a topic: its words, and its channel or the reason why there is none.
#[derive(Debug)]
pub(super) struct TopicField {
    pub(super) path: String,
    pub(super) words: ChannelName,
    /// True if it may be the lateral acceleration of its topic.
    pub(super) may_be_lateral: bool,
    pub(super) channel: Result<Channel, Error>,
}

/// The channels of a topic, at the end of the file.
#[derive(Debug)]
pub(super) struct TopicChannels {
    pub(super) fields: Vec<TopicField>,
    /// True if its messages have nothing that is requested.
    pub(super) has_nothing_requested: bool,
    /// Contents of messages in JSON.
    pub(super) contents: Option<Contents>,
    /// Error for a field that a person names and that is not there.
    pub(super) missing: Option<Error>,
    /// Error for a later message with other fields than the first.
    pub(super) changed_fields: Option<Error>,
}

/// The messages of one topic, as far as they were read.
#[derive(Debug, Default)]
pub(super) struct TopicSeries {
    topic: Rc<str>,
    /// The fields requested of it.
    requested: RequestedFields,
    /// `None` for JSON before its first message, which alone shows its fields, and where an
    /// error gives the reason.
    layout: Option<Rc<MessageLayout>>,
    columns: Vec<FieldColumn>,
    /// The requested scalars of the current message, as they are stored.
    leaves: Vec<Option<Leaf>>,
    /// Numbers of the current message, in the order of the layout.
    slots: Vec<f64>,
    times: MessageTimes,
    /// The frame that the first message names.
    frame: Option<f64>,
    /// True if its messages have nothing that is requested.
    has_nothing_requested: bool,
    /// Contents of messages in JSON.
    contents: Option<Contents>,
    /// Error for a later message with other fields than the first.
    changed_fields: Option<Error>,
    /// Fingerprint of the fields that the first message in JSON had.
    shape: Option<u64>,
    /// Comments on the topic.
    pub(super) remarks: Vec<Remark>,
    /// The first error of the topic; nothing is read after it.
    error: Option<Error>,
}

/// A message of a topic: its number, counted from 1, and the byte of its record.
#[derive(Debug, Clone, Copy)]
pub(super) struct LoggedMessage<'a> {
    pub(super) number: u64,
    pub(super) log_time: u64,
    pub(super) publish_time: u64,
    pub(super) data: &'a [u8],
    pub(super) byte: u64,
}

/// Numbers of values that are kept of all topics.
#[derive(Debug, Default)]
pub(super) struct KeptValues {
    /// Values of fields that may be meant, and times.
    candidates: u64,
    neighbours: u64,
    /// Error once the neighbours are too many; none of them is kept any more.
    pub(super) exceeded: Option<Error>,
}

/// Cost of one path or column beside its values [values].
const OVERHEAD: u64 = 16;

impl TopicSeries {
    /// Prepares to read the messages of a topic; those of a JSON topic have no layout yet.
    pub(super) fn new(
        topic: &str,
        requested: &RequestedFields,
        laid: Option<&LayoutResult>,
        kept: &mut KeptValues,
    ) -> Self {
        let mut series = Self {
            topic: topic.into(),
            requested: requested.clone(),
            ..Self::default()
        };
        match laid {
            None => {}
            Some(Ok(layout)) => series.take_layout(Rc::clone(layout), kept),
            Some(Err(Unfit::NothingRequested)) => series.has_nothing_requested = true,
            Some(Err(Unfit::Unreadable(error))) => series.error = Some(error.clone()),
        }
        series
    }

    fn take_layout(&mut self, layout: Rc<MessageLayout>, kept: &mut KeptValues) {
        let column = |(path, unit): &(String, Option<AccelerationUnit>)| FieldColumn {
            path: path.clone(),
            unit: *unit,
            is_neighbour: !self.requested.is_candidate
                || (!layout::names_lateral(path) && self.requested.path.as_ref() != Some(path)),
            ..FieldColumn::default()
        };
        self.columns = layout.columns.iter().map(column).collect();
        self.slots = vec![0.0; layout.paths.len()];
        kept.candidates += OVERHEAD * self.columns.len() as u64;
        self.layout = Some(layout);
    }

    /// Takes in one message; an error in it is kept until the series is finished.
    pub(super) fn push(
        &mut self,
        message: &LoggedMessage<'_>,
        kept: &mut KeptValues,
        limits: &Limits,
    ) -> Result<(), Error> {
        if self.error.is_some() || self.has_nothing_requested {
            return Ok(());
        }
        if let Err(error) = self.take(message, kept, limits) {
            self.error = Some(error);
            return Ok(());
        }
        // Each message costs one value per column and one for each of its times.
        let is_candidate = self.requested.is_candidate;
        let neighbours = self.columns.iter().filter(|column| column.is_neighbour);
        let neighbours = neighbours.count() as u64 + if is_candidate { 0 } else { CLOCKS };
        kept.candidates += self.columns.len() as u64 + CLOCKS - neighbours;
        kept.neighbours += neighbours;
        let value_limit = limits.samples.saturating_mul(KEPT_PER_SAMPLE);
        let full = message.number > limits.samples;
        let over = || {
            let found = format!("more, at message {} of {}", message.number, self.topic);
            limits
                .over("samples", found)
                .at(Place::default().byte(message.byte))
        };
        if (full && is_candidate) || kept.candidates > value_limit {
            return Err(over());
        }
        if full || kept.candidates + kept.neighbours > value_limit {
            let error = kept.exceeded.get_or_insert_with(over).clone();
            for column in self.columns.iter_mut().filter(|column| column.is_neighbour) {
                column.error.get_or_insert_with(|| error.clone());
                column.values = Vec::new();
            }
            if !is_candidate {
                self.times = MessageTimes::default();
                self.error = Some(error);
            }
        }
        Ok(())
    }

    fn take(
        &mut self,
        message: &LoggedMessage<'_>,
        kept: &mut KeptValues,
        limits: &Limits,
    ) -> Result<(), Error> {
        let topic = Rc::clone(&self.topic);
        let place = |path: &str| place(&topic, message, path);
        if self.layout.is_none() {
            let contents = Contents::of_json(message.data, &self.requested);
            let contents = contents.map_err(|error| error.at(place("")))?;
            match layout::json_layout(&contents, &self.requested) {
                Some(layout) => self.take_layout(Rc::new(layout), kept),
                None => self.has_nothing_requested = true,
            }
            self.contents = Some(contents);
        }
        let Some(layout) = self.layout.clone() else {
            return Ok(());
        };
        self.extract(&layout, message.data, limits)
            .map_err(|error| error.at(place("")))?;
        for column in &mut self.columns {
            let error = column.error.take();
            column.error = error.map(|error| error.at(place(&column.path)));
        }
        let mut trailing = self.slots.iter().skip(self.columns.len()).copied();
        if layout.estimate && trailing.next() == Some(-1.0) {
            let found = format!("-1 in {ESTIMATE}, by which the sensor states that it has none");
            let error = damaged_message("an estimate of the acceleration", &found);
            return Err(error.at(place("")));
        }
        if layout.frame {
            let frame = trailing.next();
            if self.frame.is_some() && self.frame != frame {
                return Err(Error::malformed(
                    "the messages of one sensor, with one frame_id",
                    "another frame_id than before",
                    "write each sensor to a separate topic",
                )
                .at(place("header.frame_id")));
            }
            self.frame = frame;
        }
        let stamp = match layout.stamped {
            true => Some([trailing.next(), trailing.next()].map(Option::unwrap_or_default)),
            false => None,
        };
        self.times
            .push(stamp, message.log_time, message.publish_time);
        for (column, value) in self.columns.iter_mut().zip(&self.slots) {
            if column.error.is_some() {
                continue;
            }
            column.values.push(*value);
            if !value.is_finite() {
                let found = value.to_string();
                let error = Error::from(KernelError::NonFinite { found });
                column.error = Some(error.at(place(&column.path)));
                column.values = Vec::new();
            }
        }
        Ok(())
    }

    /// Writes the requested numbers of a message into the slots.
    fn extract(
        &mut self,
        layout: &MessageLayout,
        data: &[u8],
        limits: &Limits,
    ) -> Result<(), Error> {
        let paths = &layout.paths;
        self.leaves.clear();
        self.leaves.resize(paths.len(), None);
        match &layout.messages {
            Messages::Ros(plan) => {
                cdr::walk(plan, data, limits.mcap_string_bytes, &mut self.leaves)?;
            }
            Messages::Protobuf(types) => {
                let path = &mut String::new();
                let mut take_leaf = |path: &str, leaf| _ = put(&mut self.leaves, paths, path, leaf);
                protobuf::walk(types, &types.root, path, data, paths, &mut take_leaf)?;
            }
            Messages::Json => self.extract_json(paths, data)?,
        }
        let is_json = matches!(layout.messages, Messages::Json);
        for (place, (leaf, path)) in self.leaves.iter().zip(paths).enumerate() {
            let non_finite = |kind: &str| {
                let found = format!("{kind} in {path}");
                KernelError::NonFinite { found }.into()
            };
            let error: Error = match *leaf {
                Some(Leaf::Number(value)) => {
                    self.slots[place] = value;
                    continue;
                }
                Some(Leaf::Text(text)) if path == FRAME => {
                    self.slots[place] = text.fingerprint;
                    continue;
                }
                Some(Leaf::Text(text)) if text.is_number => {
                    non_finite("a number written as a text")
                }
                Some(Leaf::Text(_)) => non_finite("a text"),
                Some(Leaf::Null) => non_finite("null"),
                Some(Leaf::Boolean) => non_finite("a boolean"),
                // A stamp of protobuf that is not written is zero.
                None if !is_json && place >= self.columns.len() => {
                    self.slots[place] = 0.0;
                    continue;
                }
                None => {
                    let expected = format!("a value of {path}");
                    damaged_message(&expected, "none in the message")
                }
            };
            match self.columns.get_mut(place) {
                // The error concerns one field; the others are still read.
                Some(column) => column.error.get_or_insert(error),
                None => return Err(error),
            };
        }
        Ok(())
    }

    /// Reads a message in JSON, whose fields must be those of the first.
    fn extract_json(&mut self, paths: &[String], data: &[u8]) -> Result<(), Error> {
        let (mut twice, mut shape) = (None, 0_u64);
        let mut take_leaf = |path: &str, leaf: Leaf| {
            if put(&mut self.leaves, paths, path, leaf) {
                twice = Some(path.to_string());
            }
            let numeric = matches!(leaf, Leaf::Number(_) | Leaf::Null);
            if numeric && !path.contains('[') {
                shape = shape.wrapping_add(hash(path.as_bytes()));
            }
        };
        json::walk(data, &mut take_leaf)?;
        if let Some(path) = twice {
            let expected = format!("the field {path} once");
            return Err(damaged_message(&expected, "it twice"));
        }
        if *self.shape.get_or_insert(shape) != shape {
            let error = Error::malformed(
                "the fields of the first message",
                "other fields, of which one may be another lateral acceleration",
                "choose one with the setting `channel` = TOPIC:FIELD, or write each sensor to a \
                 separate topic",
            );
            self.changed_fields.get_or_insert(error);
        }
        Ok(())
    }

    /// Brings the fields to a uniform time base. `lateral_path` is the path of the lateral acceleration
    /// of a known message type; `mark` is appended to each name.
    pub(super) fn finish(
        mut self,
        lateral_path: Option<&str>,
        mark: &str,
        options: &ReadOptions,
        limits: &Limits,
    ) -> TopicChannels {
        let base = match self.error.take() {
            Some(error) => Err(error),
            None => self.times.base(&self.topic, options, limits),
        };
        let confirmed = self.times.log_confirms();
        let doubt = base.as_ref().ok().and_then(|base| base.doubt.clone());
        let layout = self.layout.take();
        let is_read = layout.is_some();
        let requested = self.requested.path.as_deref().zip(layout);
        let missing = requested.and_then(|(path, layout)| {
            let exists = self.columns.iter().any(|column| column.path == path);
            (!exists).then(|| layout::no_field(&self.topic, path, &layout.contents))
        });
        if !is_read && !self.has_nothing_requested {
            // A topic that cannot be read at all still yields one field, which carries the error.
            self.columns.push(FieldColumn {
                path: lateral_path
                    .or(self.requested.path.as_deref())
                    .unwrap_or("")
                    .into(),
                ..FieldColumn::default()
            });
        }
        let (topic, remarks) = (self.topic, self.remarks);
        let field = |column: FieldColumn| {
            let path = column.path.clone();
            let mut words = layout::words_of(&topic, &path);
            words.name.push_str(mark);
            let may_be_lateral = match lateral_path {
                Some(lateral_path) => path == lateral_path,
                None => layout::names_lateral(&path) || !is_read,
            };
            let channel = match (column.error.clone(), &base) {
                (Some(error), _) => Err(error),
                (None, Err(error)) => Err(error.clone()),
                (None, Ok(base)) => column.into_channel(&words, &remarks, base, options),
            };
            let channel = channel.map(|mut channel: Channel| {
                channel.stated.clock_confirmed_by = confirmed.then(|| "log times".into());
                channel.stated.clock_doubt.clone_from(&doubt);
                channel.stated.gravity |=
                    lateral_path == Some(IMU_PATH) && path.starts_with(IMU_FIELD);
                channel
            });
            let place = Place::default().channel(&words.name);
            let channel = channel.map_err(|error| error.at(place));
            TopicField {
                path,
                words,
                may_be_lateral,
                channel,
            }
        };
        TopicChannels {
            fields: self.columns.into_iter().map(field).collect(),
            has_nothing_requested: self.has_nothing_requested,
            contents: self.contents,
            missing,
            changed_fields: self.changed_fields,
        }
    }
}

/// Values kept in all, times and all topics included, per sample that is allowed.
const KEPT_PER_SAMPLE: u64 = 5;

/// Times that are kept of each message: one of each clock.
const CLOCKS: u64 = 3;

impl FieldColumn {
    fn into_channel(
        self,
        words: &ChannelName,
        remarks: &[Remark],
        clock: &MessageBase,
        options: &ReadOptions,
    ) -> Result<Channel, Error> {
        let mut findings = Vec::new();
        if options.channel.is_some() {
            findings.extend(words.not_lateral_finding());
        }
        let named = words.stated_unit();
        let statement = UnitStatement {
            unit: self.unit,
            source: "format",
            text: self.unit.map(AccelerationUnit::name).or(named.as_deref()),
            unread: None,
            place: "the message type",
        };
        // A missing unit is an error of the delivered channel only, which is not chosen yet:
        // `draft::check_unit` follows.
        let unit = Unit::find(statement, options, Selection::Every, &mut findings)?;
        let samples = UniformSamples {
            start_s: clock.base.start_s,
            rate: clock.base.rate,
            values: clock.base.apply(&clock.times_s, self.values)?,
        };
        let mut draft = Draft::of_words(words, unit, samples, clock.findings.clone());
        draft.findings.append(&mut findings);
        draft.remarks = remarks.to_vec();
        // The stamps count from time zero already, which in nanoseconds loses no digit.
        draft.finish(0.0, options)
    }
}

/// Returns the place of a message: the byte of its record and the channel with its number.
fn place(topic: &str, message: &LoggedMessage<'_>, path: &str) -> Place {
    let (name, number) = (name_of(topic, path), message.number);
    let place = Place::default().byte(message.byte);
    place.channel(format!("{name}, message {number}"))
}

/// Puts a scalar into each slot of that path; true if one of them held a scalar already.
fn put(leaves: &mut [Option<Leaf>], paths: &[String], path: &str, leaf: Leaf) -> bool {
    let mut twice = false;
    for (slot, slot_path) in leaves.iter_mut().zip(paths) {
        if slot_path == path {
            twice |= slot.replace(leaf).is_some();
        }
    }
    twice
}
