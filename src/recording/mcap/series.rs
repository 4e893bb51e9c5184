//! One topic's messages turned into numbers, each at its stamp.

use super::layout::{
    self, ESTIMATE, FRAME, Laid, MessageLayout, Messages, Unfit, WantedFields, name_of,
};
use super::types::{Leaf, damaged_message, hash};
use super::{cdr, json, protobuf};
use crate::error::{Error, ErrorKind, Place};
use crate::recording::csv::header::Column as Named;
use crate::recording::draft::{Draft, UniformSamples, Unit};
use crate::recording::remarks::Remark;
use crate::recording::time_base::{MEND, TimeBase};
use crate::recording::{Channel, Finding, Limits, ReadOptions};
use crate::units::AccelerationUnit;
use std::rc::Rc;

/// How much later than it was measured a message may be logged [ns].
const LATE_NS: i128 = 50_000_000;

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
    pub(super) words: Named,
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
    /// Stamps in the messages [ns].
    stamps: Vec<i64>,
    /// Times of recording [ns].
    logged: Vec<u64>,
    /// The frame that the first message names.
    frame: Option<f64>,
    /// Whether its messages have nothing that is wanted.
    is_other: bool,
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
        let neighbours = neighbours.count() as u64 + if meant { 0 } else { 2 };
        kept.meant += self.columns.len() as u64 + 2 - neighbours;
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
                (self.stamps, self.logged) = (Vec::new(), Vec::new());
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
            match layout::json_layout(message.data, &self.wanted) {
                Ok(layout) => self.take_layout(Rc::new(layout), kept),
                Err(Unfit::Unreadable(error)) => return Err(error.at(place(""))),
                Err(Unfit::Other) => self.is_other = true,
            }
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
            let found = format!("-1 in {ESTIMATE}, by which the sensor says that it has none");
            let error = damaged_message("an estimate of the acceleration", &found);
            return Err(error.at(place("")));
        }
        if layout.frame {
            let frame = rest.next();
            if self.frame.is_some() && self.frame != frame {
                return Err(Error::malformed(
                    "the messages of one sensor, with one frame_id",
                    "another frame_id than before",
                    "write each sensor to a topic of its own",
                )
                .at(place("header.frame_id")));
            }
            self.frame = frame;
        }
        if layout.stamped {
            let pair = [rest.next(), rest.next()].map(Option::unwrap_or_default);
            let stamp = stamp_ns(pair).map_err(|error| error.at(place("header.stamp")))?;
            self.stamps.push(stamp);
        }
        self.logged.push(message.log_time);
        for (column, value) in self.columns.iter_mut().zip(&self.slots) {
            if column.error.is_some() {
                continue;
            }
            column.values.push(*value);
            if !value.is_finite() {
                let found = value.to_string();
                let error = Error::from(ErrorKind::NonFinite { found });
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
                ErrorKind::NonFinite { found }.into()
            };
            let error: Error = match *leaf {
                Some(Leaf::Number(value)) => {
                    self.slots[place] = value;
                    continue;
                }
                Some(Leaf::Text(fingerprint)) if path == FRAME => {
                    self.slots[place] = fingerprint;
                    continue;
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
                 topic of its own",
            );
            self.further.get_or_insert(error);
        }
        Ok(())
    }

    /// Returns the name of the first field.
    fn name(&self) -> String {
        let path = self.columns.first().map_or("", |column| &column.path);
        name_of(&self.topic, path)
    }

    /// Brings the fields to a uniform time base; `known` is the path of the lateral acceleration in a
    /// message type that is known to have one.
    pub(super) fn finish(
        mut self,
        known: Option<&str>,
        options: &ReadOptions,
        limits: &Limits,
    ) -> Finished {
        let base = match self.error.take() {
            Some(error) => Err(error),
            None => self.base(options, limits),
        };
        let layout = self.layout.take();
        let is_read = layout.is_some();
        let asked = self.wanted.path.as_deref().zip(layout);
        let missing = asked.and_then(|(path, layout)| {
            let there = self.columns.iter().any(|column| column.path == path);
            (!there).then(|| layout::no_field(&self.topic, path, &layout.known))
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
            let words = layout::words_of(&topic, &path);
            let may_be_lateral = match known {
                Some(known) => path == known,
                None => layout::names_lateral(&path) || !is_read,
            };
            let channel = match (column.error.clone(), &base) {
                (Some(error), _) => Err(error),
                (None, Err(error)) => Err(error.clone()),
                (None, Ok((base, stamps, findings))) => {
                    column.into_channel((&words, &remarks), base, stamps, findings, options)
                }
            };
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
            missing,
            further: self.further,
        }
    }

    /// Finds the uniform time base, with the stamps and what is odd about them.
    fn base(
        &self,
        options: &ReadOptions,
        limits: &Limits,
    ) -> Result<(TimeBase, Vec<f64>, Vec<Finding>), Error> {
        let mut findings = Vec::new();
        let stamps = self.stamps_s(options, &mut findings)?;
        let base = TimeBase::fit(&stamps, 1e-9, limits)?;
        findings.extend(base.findings.iter().cloned());
        let by = ("the times of the messages", false);
        findings.extend(options.check_rate(base.rate.hertz(), by, MEND)?);
        Ok((base, stamps, findings))
    }

    /// Returns the instants of the messages after time zero [s].
    fn stamps_s(
        &self,
        options: &ReadOptions,
        findings: &mut Vec<Finding>,
    ) -> Result<Vec<f64>, Error> {
        let stamped = self.layout.as_ref().is_some_and(|layout| layout.stamped);
        let use_stamps = stamped && self.stamps.iter().any(|stamp| *stamp != 0);
        let time = |index: usize| match use_stamps {
            true => i128::from(self.stamps[index]),
            false => i128::from(self.logged[index]),
        };
        if !use_stamps {
            let (code, seen) = match stamped {
                true => ("stamp-zero", "header.stamp is 0 in every message"),
                false => ("log-time", "the messages have no header.stamp"),
            };
            let used = "the time of logging is used, which carries the delays of transport";
            findings.push(Finding::warning(code, format!("{seen}; {used}")));
        }
        let Some(end) = self.logged.len().checked_sub(1) else {
            return Ok(Vec::new());
        };
        let (first, last) = (time(0), time(end));
        for index in 1..=end {
            let (previous, found) = (time(index - 1), time(index));
            if found <= previous {
                let (name, number) = (self.name(), index + 1);
                let text = format!("{name}, message {number} (seconds after the first)");
                let error = Error::from(ErrorKind::TimeNotIncreasing {
                    previous: seconds(previous - first),
                    found: seconds(found - first),
                });
                return Err(error.at(Place::default().channel(text)));
            }
        }
        if use_stamps {
            let logged = i128::from(self.logged[end]) - i128::from(self.logged[0]);
            let stamped = last - first;
            // Transport comes late now and then; a clock that runs slow is late all the time.
            if logged > stamped + stamped / 2 + LATE_NS {
                let text = format!(
                    "the messages' own stamps span {} s, the times at which they were logged {} s: \
                     one of the two clocks is wrong, or what was measured before was sent slowly; \
                     the stamps are used",
                    seconds_text(stamped),
                    seconds_text(logged)
                );
                findings.push(Finding::warning("log-time-differs", text));
            }
        }
        let zero = match options.time_zero_s {
            Some(instant_s) => nanoseconds(instant_s)?,
            None => first,
        };
        if !(first..=last).contains(&zero) {
            let said = format!(
                "time zero is not between the first and the last message; on the file's clock \
                 these are at {} s and {} s",
                seconds_text(first),
                seconds_text(last)
            );
            findings.push(Finding::warning("time-zero-outside", said));
        }
        Ok((0..=end).map(|index| seconds(time(index) - zero)).collect())
    }
}

/// Values kept in all, times and all topics included, per sample that is allowed.
const KEPT_PER_SAMPLE: u64 = 4;

impl FieldColumn {
    fn into_channel(
        self,
        (words, remarks): (&Named, &[Remark]),
        base: &TimeBase,
        stamps: &[f64],
        findings: &[Finding],
        options: &ReadOptions,
    ) -> Result<Channel, Error> {
        let mut told = Vec::new();
        if options.channel.is_some() {
            told.extend(words.not_lateral_finding());
        }
        let own = self.unit.map(|unit| (unit, "format"));
        let unit = Unit::find(own, options, &mut told, |_, used| {
            let own = self.unit?.name();
            Some(format!(
                "the message type prescribes {own}; {used} was stated and is used"
            ))
        });
        let clock = UniformSamples {
            start_s: base.start_s,
            rate: base.rate,
            values: base.apply(stamps, self.values)?,
        };
        let mut draft = Draft::of_words(words, unit, clock, findings.to_vec());
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

/// Returns a stamp in whole nanoseconds.
fn stamp_ns([sec, nanosec]: [f64; 2]) -> Result<i64, Error> {
    // 9.2e9 s in nanoseconds still fit 64 bits.
    let whole = |value: f64| value.trunc().total_cmp(&value).is_eq();
    if !(whole(sec) && sec.abs() <= 9.2e9 && whole(nanosec) && (0.0..1e9).contains(&nanosec)) {
        let expected = "a stamp of whole seconds, and nanoseconds below 10^9";
        let found = format!("{sec} s and {nanosec} ns");
        return Err(damaged_message(expected, &found));
    }
    Ok(sec as i64 * 1_000_000_000 + nanosec as i64)
}

/// Returns an instant in whole nanoseconds.
fn nanoseconds(instant_s: f64) -> Result<i128, Error> {
    if !instant_s.is_finite() || instant_s.abs() > 1e11 {
        return Err(ErrorKind::OutOfRange {
            what: "time zero [s]".into(),
            expected: "an instant on the file's clock".into(),
            found: format!("{instant_s}"),
        }
        .into());
    }
    // Taken as it was written: the nearest double to an instant of today is off by up to 0.1 µs,
    // its shortest decimal is not.
    let text = instant_s.abs().to_string();
    let (whole, rest) = text.split_once('.').unwrap_or((&text, ""));
    let digits = format!("{whole}{rest:0<9.9}");
    let time: i128 = digits.parse().unwrap_or_default();
    Ok(if instant_s < 0.0 { -time } else { time })
}

fn seconds(span_ns: i128) -> f64 {
    let span = span_ns as f64;
    span / 1e9
}

fn seconds_text(time_ns: i128) -> String {
    let sign = if time_ns < 0 { "-" } else { "" };
    let (time, second) = (time_ns.unsigned_abs(), 1_000_000_000);
    format!("{sign}{}.{:09}", time / second, time % second)
}
