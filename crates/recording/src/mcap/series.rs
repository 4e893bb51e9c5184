//! One topic's messages turned into numbers, each at its stamp.

use super::clock::{MessageBase, MessageTimes};
use super::layout::{
    self, Contents, ESTIMATE, FRAME, IMU_FIELD, IMU_PATH, Laid, MessageLayout, Messages, Unfit,
    WantedFields, name_of,
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
    /// Whether it is read as a neighbour only.
    is_neighbour: bool,
    /// The first thing wrong with this field; its values end there.
    error: Option<Error>,
}

/// A field of a topic: what its words say, and its channel or why it is none.
#[derive(Debug)]
pub(super) struct TopicField {
    pub(super) path: String,
    pub(super) words: ChannelName,
    /// Whether it may be the lateral acceleration of its topic.
    pub(super) may_be_lateral: bool,
    pub(super) channel: Result<Channel, Error>,
}

/// What a topic comes to.
#[derive(Debug)]
pub(super) struct Finished {
    pub(super) fields: Vec<TopicField>,
    /// Whether its messages have nothing that is wanted.
    pub(super) is_other: bool,
    /// What messages in JSON hold.
    pub(super) contents: Option<Contents>,
    /// That the field which a person names is not there.
    pub(super) missing: Option<Error>,
    /// That a later message had other fields than the first.
    pub(super) further: Option<Error>,
}

/// The messages of one topic, as far as they were read.
#[derive(Debug, Default)]
pub(super) struct TopicSeries {
    topic: Rc<str>,
    /// What was wanted of it.
    wanted: WantedFields,
    /// `None` for JSON before its first message, which alone tells its fields, and where an
    /// error says why there is none.
    layout: Option<Rc<MessageLayout>>,
    columns: Vec<FieldColumn>,
    /// What is wanted of the message at hand, as it stands there.
    leaves: Vec<Option<Leaf>>,
    /// Numbers of the message at hand, as the layout says.
    slots: Vec<f64>,
    times: MessageTimes,
    /// The frame that the first message names.
    frame: Option<f64>,
    /// Whether its messages have nothing that is wanted.
    is_other: bool,
    /// What messages in JSON hold.
    contents: Option<Contents>,
    /// That a later message had other fields than the first.
    further: Option<Error>,
    /// Fingerprint of the fields that the first message in JSON had.
    shape: Option<u64>,
    /// What a person wrote of the topic.
    pub(super) remarks: Vec<Remark>,
    /// The first thing wrong with the whole; nothing is read after it.
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

/// Values that are kept of all topics.
#[derive(Debug, Default)]
pub(super) struct Kept {
    /// Those of fields that may be meant, and times.
    meant: u64,
    neighbours: u64,
    /// That neighbours are too many, so that none is kept any more.
    pub(super) over: Option<Error>,
}

/// What one path or column costs beside its values, in values.
const OVERHEAD: u64 = 16;

impl TopicSeries {
    /// Prepares to read the messages of a topic; those of a JSON topic have no layout yet.
    pub(super) fn new(
        topic: &str,
        wanted: &WantedFields,
        laid: Option<&Laid>,
        kept: &mut Kept,
    ) -> Self {
        let mut series = Self {
            topic: topic.into(),
            wanted: wanted.clone(),
            ..Self::default()
        };
        match laid {
            None => {}
            Some(Ok(layout)) => series.take_layout(Rc::clone(layout), kept),
            Some(Err(Unfit::Other)) => series.is_other = true,
            Some(Err(Unfit::Unreadable(error))) => series.error = Some(error.clone()),
        }
        series
    }

    fn take_layout(&mut self, layout: Rc<MessageLayout>, kept: &mut Kept) {
        let column = |(path, unit): &(String, Option<AccelerationUnit>)| FieldColumn {
            path: path.clone(),
            unit: *unit,
            is_neighbour: !self.wanted.meant
                || (!layout::names_lateral(path) && self.wanted.path.as_ref() != Some(path)),
            ..FieldColumn::default()
        };
        self.columns = layout.columns.iter().map(column).collect();
        self.slots = vec![0.0; layout.paths.len()];
        kept.meant += OVERHEAD * self.columns.len() as u64;
        self.layout = Some(layout);
    }

    /// Takes in one message; what is wrong with it is kept until the series is asked for.
    pub(super) fn push(
        &mut self,
        message: &LoggedMessage<'_>,
        kept: &mut Kept,
        limits: &Limits,
    ) -> Result<(), Error> {
        if self.error.is_some() || self.is_other {
            return Ok(());
        }
        if let Err(error) = self.take(message, kept, limits) {
            self.error = Some(error);
            return Ok(());
        }
        // Each message costs one value per column and one for each of its times.
        let meant = self.wanted.meant;
        let neighbours = self.columns.iter().filter(|column| column.is_neighbour);
        let neighbours = neighbours.count() as u64 + if meant { 0 } else { CLOCKS };
        kept.meant += self.columns.len() as u64 + CLOCKS - neighbours;
        kept.neighbours += neighbours;
        let most = limits.samples.saturating_mul(KEPT_PER_SAMPLE);
        let full = message.number > limits.samples;
        let over = || {
            let found = format!("more, at message {} of {}", message.number, self.topic);
            limits
                .over("samples", found)
                .at(Place::default().byte(message.byte))
        };
        if (full && meant) || kept.meant > most {
            return Err(over());
        }
        if full || kept.meant + kept.neighbours > most {
            let error = kept.over.get_or_insert_with(over).clone();
            for column in self.columns.iter_mut().filter(|column| column.is_neighbour) {
                column.error.get_or_insert_with(|| error.clone());
                column.values = Vec::new();
            }
            if !meant {
                self.times = MessageTimes::default();
                self.error = Some(error);
            }
        }
        Ok(())
    }

    fn take(
        &mut self,
        message: &LoggedMessage<'_>,
        kept: &mut Kept,
        limits: &Limits,
    ) -> Result<(), Error> {
        let topic = Rc::clone(&self.topic);
        let place = |path: &str| place(&topic, message, path);
        if self.layout.is_none() {
            let contents = Contents::of_json(message.data, &self.wanted);
            let contents = contents.map_err(|error| error.at(place("")))?;
            match layout::json_layout(&contents, &self.wanted) {
                Some(layout) => self.take_layout(Rc::new(layout), kept),
                None => self.is_other = true,
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
        let mut rest = self.slots.iter().skip(self.columns.len()).copied();
        if layout.estimate && rest.next() == Some(-1.0) {
            let found = format!("-1 in {ESTIMATE}, by which the sensor states that it has none");
            let error = damaged_message("an estimate of the acceleration", &found);
            return Err(error.at(place("")));
        }
        if layout.frame {
            let frame = rest.next();
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
        let pair = || [rest.next(), rest.next()].map(Option::unwrap_or_default);
        let stamp = layout.stamped.then(pair);
        let (log, publish) = (message.log_time, message.publish_time);
        self.times.push(stamp, log, publish);
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

    /// Takes the numbers that are wanted from a message into the slots.
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
                let root = (&*types.root, &mut String::new());
                let mut found = |path: &str, leaf| _ = put(&mut self.leaves, paths, path, leaf);
                protobuf::walk(types, root, data, paths, &mut found)?;
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
                // Of one field alone; the others go on.
                Some(column) => column.error.get_or_insert(error),
                None => return Err(error),
            };
        }
        Ok(())
    }

    /// Takes what is wanted from a message in JSON, whose fields must be those of the first.
    fn extract_json(&mut self, paths: &[String], data: &[u8]) -> Result<(), Error> {
        let (mut twice, mut shape) = (None, 0_u64);
        let mut found = |path: &str, leaf: Leaf| {
            if put(&mut self.leaves, paths, path, leaf) {
                twice = Some(path.to_string());
            }
            let numeric = matches!(leaf, Leaf::Number(_) | Leaf::Null);
            if numeric && !path.contains('[') {
                shape = shape.wrapping_add(hash(path.as_bytes()));
            }
        };
        json::walk(data, &mut found)?;
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
            self.further.get_or_insert(error);
        }
        Ok(())
    }

    /// Brings the fields to a uniform time base; `known` is the path of the lateral acceleration in a
    /// message type that is known to have one, `mark` stands behind each name.
    pub(super) fn finish(
        mut self,
        known: Option<&str>,
        mark: &str,
        options: &ReadOptions,
        limits: &Limits,
    ) -> Finished {
        let base = match self.error.take() {
            Some(error) => Err(error),
            None => self.times.base(&self.topic, options, limits),
        };
        let confirmed = self.times.log_confirms();
        let layout = self.layout.take();
        let is_read = layout.is_some();
        let asked = self.wanted.path.as_deref().zip(layout);
        let missing = asked.and_then(|(path, layout)| {
            let there = self.columns.iter().any(|column| column.path == path);
            (!there).then(|| layout::no_field(&self.topic, path, &layout.contents))
        });
        if !is_read && !self.is_other {
            // Of what cannot be read at all one field is told.
            self.columns.push(FieldColumn {
                path: known.or(self.wanted.path.as_deref()).unwrap_or("").into(),
                ..FieldColumn::default()
            });
        }
        let (topic, remarks) = (self.topic, self.remarks);
        let field = |column: FieldColumn| {
            let path = column.path.clone();
            let mut words = layout::words_of(&topic, &path);
            words.name.push_str(mark);
            let may_be_lateral = match known {
                Some(known) => path == known,
                None => layout::names_lateral(&path) || !is_read,
            };
            let channel = match (column.error.clone(), &base) {
                (Some(error), _) => Err(error),
                (None, Err(error)) => Err(error.clone()),
                (None, Ok(base)) => column.into_channel((&words, &remarks), base, options),
            };
            let channel = channel.map(|mut channel: Channel| {
                channel.stated.clock_confirmed_by = confirmed.then(|| "log times".into());
                channel.stated.gravity |= known == Some(IMU_PATH) && path.starts_with(IMU_FIELD);
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
        Finished {
            fields: self.columns.into_iter().map(field).collect(),
            is_other: self.is_other,
            contents: self.contents,
            missing,
            further: self.further,
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
        (words, remarks): (&ChannelName, &[Remark]),
        clock: &MessageBase,
        options: &ReadOptions,
    ) -> Result<Channel, Error> {
        let mut told = Vec::new();
        if options.channel.is_some() {
            told.extend(words.not_lateral_finding());
        }
        let named = words.stated_unit();
        let statement = UnitStatement {
            unit: self.unit,
            source: "format",
            text: self.unit.map(AccelerationUnit::name).or(named.as_deref()),
            unread: None,
            place: "the message type",
        };
        // Which channel is meant is not known here: see `draft::check_unit`.
        let unit = Unit::find(statement, options, Selection::Every, &mut told)?;
        let samples = UniformSamples {
            start_s: clock.base.start_s,
            rate: clock.base.rate,
            values: clock.base.apply(&clock.times_s, self.values)?,
        };
        let mut draft = Draft::of_words(words, unit, samples, clock.findings.clone());
        draft.findings.append(&mut told);
        draft.remarks = remarks.to_vec();
        // The stamps count from time zero already, which in nanoseconds loses no digit.
        draft.finish(0.0, options)
    }
}

/// Returns where a message stands: the byte of its record and the channel with its number.
fn place(topic: &str, message: &LoggedMessage<'_>, path: &str) -> Place {
    let (name, number) = (name_of(topic, path), message.number);
    let place = Place::default().byte(message.byte);
    place.channel(format!("{name}, message {number}"))
}

/// Puts a scalar into every slot whose path is its own; tells whether one held another.
fn put(leaves: &mut [Option<Leaf>], paths: &[String], path: &str, leaf: Leaf) -> bool {
    let mut twice = false;
    for (slot, wanted) in leaves.iter_mut().zip(paths) {
        if wanted == path {
            twice |= slot.replace(leaf).is_some();
        }
    }
    twice
}
