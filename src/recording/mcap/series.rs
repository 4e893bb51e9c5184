//! One topic's messages turned into numbers, each at its stamp.

use super::json::{self, Leaf};
use super::layout::{
    self, ESTIMATE, Extractor, FRAME, Laid, MessageLayout, Unfit, WantedFields, damaged_message,
    name_of, says_lateral,
};
use super::ros::Dialect;
use super::{cdr, protobuf, records};
use crate::error::{Error, ErrorKind, Place};
use crate::recording::csv::header::Column as Named;
use crate::recording::draft::{Draft, Unit};
use crate::recording::remarks::Remark;
use crate::recording::time_base::TimeBase;
use crate::recording::{Channel, Finding, Limits, ReadOptions};
use crate::units::AccelerationUnit;
use std::collections::BTreeSet;
use std::rc::Rc;

/// How much later than it was measured a message may be logged [ns].
const LATE_NS: i128 = 50_000_000;
/// Nanoseconds in a second.
const NANO: i128 = 1_000_000_000;
/// One field's values.
#[derive(Debug)]
struct Column {
    path: String,
    unit: Option<AccelerationUnit>,
    values: Vec<f64>,
    /// The first thing wrong with this field; its values end there.
    error: Option<Error>,
}

/// What a JSON topic turns out to be once its first message was seen.
pub(super) enum Standing<'a> {
    /// It carries an acceleration.
    Candidate,
    /// It is of another kind.
    Other,
    /// Its first message cannot be read.
    Doubtful(&'a Error),
}

/// The fields of a topic by name: a channel, or the reason why it is none.
pub(super) type Finished = Vec<(String, Result<Channel, Error>)>;

/// The messages of one topic, as far as they were read.
#[derive(Debug)]
pub(super) struct TopicSeries {
    topic: String,
    /// What was wanted of it.
    wanted: WantedFields,
    /// `None` for JSON before its first message, which alone tells its fields, and where an
    /// error says why there is none.
    layout: Option<Rc<MessageLayout>>,
    columns: Vec<Column>,
    /// Numbers of the message at hand, as the layout says.
    slots: Vec<f64>,
    /// Stamps in the messages [ns].
    stamps: Vec<i64>,
    /// Times of recording [ns].
    logged: Vec<u64>,
    /// The frame that the first message names.
    frame: Option<f64>,
    /// Fingerprints of the fields that messages in JSON had, each looked at once.
    shapes: BTreeSet<u64>,
    /// What a person wrote of the topic.
    pub(super) remarks: Vec<Remark>,
    /// The first thing wrong with the whole; nothing is read after it.
    error: Option<Error>,
}

/// What one path or column costs beside its values, in values.
const OVERHEAD: u64 = 16;

impl TopicSeries {
    /// Prepares to read the messages of a topic; those of a JSON topic have no layout yet.
    pub(super) fn new(
        topic: &str,
        wanted: &WantedFields,
        laid: Option<&Laid>,
        kept: &mut u64,
    ) -> Self {
        let mut series = Self {
            topic: topic.to_string(),
            wanted: wanted.clone(),
            layout: None,
            columns: Vec::new(),
            slots: Vec::new(),
            stamps: Vec::new(),
            logged: Vec::new(),
            frame: None,
            shapes: BTreeSet::new(),
            remarks: Vec::new(),
            error: None,
        };
        match laid {
            None => {}
            Some(Ok(layout)) => series.take_layout(Rc::clone(layout), kept),
            Some(Err(unfit)) => series.error = Some(unfit.of(topic)),
        }
        series
    }

    fn take_layout(&mut self, layout: Rc<MessageLayout>, kept: &mut u64) {
        let column = |(path, unit): &(String, Option<AccelerationUnit>)| Column {
            path: path.clone(),
            unit: *unit,
            values: Vec::new(),
            error: None,
        };
        self.columns = layout.columns.iter().map(column).collect();
        self.slots = vec![0.0; layout.slots()];
        *kept += OVERHEAD * self.columns.len() as u64;
        self.layout = Some(layout);
    }
    /// Takes in one message; what is wrong with it is kept until the series is asked for.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::LimitExceeded`] beyond the limit on samples.
    pub(super) fn push(
        &mut self,
        number: u64,
        log_time: u64,
        data: &[u8],
        byte: u64,
        kept: &mut u64,
        limits: &Limits,
    ) -> Result<(), Error> {
        if self.error.is_some() {
            return Ok(());
        }
        if let Err(error) = self.take(number, log_time, data, byte, kept, limits) {
            self.error = Some(error);
            return Ok(());
        }
        // Each message costs one value per column and one for each of its times.
        *kept += self.columns.len() as u64 + 2;
        let most = limits.samples;
        if number > most || *kept > most.saturating_mul(KEPT_PER_SAMPLE) {
            return Err(Error::from(ErrorKind::LimitExceeded {
                limit: "samples",
                value: most,
                found: format!("more, at message {number} of {}", self.topic),
            })
            .at(Place::default().byte(byte)));
        }
        Ok(())
    }

    fn take(
        &mut self,
        number: u64,
        log_time: u64,
        data: &[u8],
        byte: u64,
        kept: &mut u64,
        limits: &Limits,
    ) -> Result<(), Error> {
        let topic = self.topic.clone();
        let place = |path: &str| place(&topic, number, byte, path);
        if self.layout.is_none() {
            let laid = layout::json_layout(data, &self.wanted);
            let layout = laid.map_err(|unfit| match unfit {
                Unfit::Other(error) => error.at(place("")),
                other => other.of(&topic),
            })?;
            self.take_layout(Rc::new(layout), kept);
        }
        let Some(layout) = self.layout.clone() else {
            return Ok(());
        };
        self.extract(&layout, data, kept, limits)
            .map_err(|error| error.at(place("")))?;
        let mut rest = self.slots.iter().skip(self.columns.len()).copied();
        if layout.estimate && rest.next() == Some(-1.0) {
            return Err(damaged_message(
                "an estimate of the acceleration",
                &format!("-1 in {ESTIMATE}, by which the sensor says that it has none"),
            )
            .at(place("")));
        }
        if layout.frame {
            let frame = rest.next();
            if self.frame.is_some() && self.frame != frame {
                return Err(Error::from(ErrorKind::Malformed {
                    expected: "the messages of one sensor, with one frame_id".into(),
                    found: "another frame_id than before".into(),
                    hint: "write each sensor to a topic of its own".into(),
                })
                .at(place("header.frame_id")));
            }
            self.frame = frame;
        }
        if layout.stamped {
            let pair = [rest.next(), rest.next()].map(Option::unwrap_or_default);
            let stamp = stamp_ns(pair).map_err(|error| error.at(place("header.stamp")))?;
            self.stamps.push(stamp);
        }
        self.logged.push(log_time);
        for (column, value) in self.columns.iter_mut().zip(&self.slots) {
            if column.error.is_some() {
                continue;
            }
            if !value.is_finite() {
                let found = format!("{value}");
                let error = Error::from(ErrorKind::NonFinite { found });
                column.error = Some(error.at(place(&column.path)));
                column.values = Vec::new();
                continue;
            }
            column.values.push(*value);
        }
        Ok(())
    }

    /// Takes the numbers that are wanted from a message into the slots.
    fn extract(
        &mut self,
        layout: &MessageLayout,
        data: &[u8],
        kept: &mut u64,
        limits: &Limits,
    ) -> Result<(), Error> {
        let longest = limits.mcap_string_bytes;
        let odd = |fault: cdr::MessageFault| match fault.too_long {
            Some(length) => records::too_long(longest, length, "message"),
            None => damaged_message(&fault.expected, &fault.found),
        };
        let slots = &mut self.slots;
        match &layout.extractor {
            Extractor::Ros(plan, Dialect::Ros2) => {
                cdr::read(plan, data, slots, longest).map_err(odd)
            }
            Extractor::Ros(plan, Dialect::Ros1) => {
                cdr::read_ros1(plan, data, slots, longest).map_err(odd)
            }
            Extractor::Protobuf(targets) => protobuf::read(targets, data, slots)
                .map_err(|(expected, found)| damaged_message(&expected, &found)),
            Extractor::Json(paths) => {
                let shape = read_json(paths, data, slots)?;
                if self.wanted != WantedFields::Lateral || !self.shapes.insert(shape) {
                    return Ok(());
                }
                *kept += OVERHEAD;
                match further_lateral(paths, data)? {
                    None => Ok(()),
                    Some(path) => Err(ErrorKind::Malformed {
                        expected: "the fields of the first message".into(),
                        found: format!("a further lateral acceleration, {path}"),
                        hint: "choose one with the setting `channel` = TOPIC:FIELD, or write each \
                               sensor to a topic of its own"
                            .into(),
                    }
                    .into()),
                }
            }
        }
    }

    /// Tells whether the topic has a field that was wanted: for JSON, only its first message
    /// tells.
    fn has_fields(&self) -> bool {
        !self.columns.is_empty()
    }

    /// Tells what is known of a topic that was looked at without being named.
    pub(super) fn standing(&self) -> Standing<'_> {
        match &self.error {
            _ if self.has_fields() => Standing::Candidate,
            Some(error) => match error.kind() {
                ErrorKind::NoSuchChannel { .. } => Standing::Other,
                ErrorKind::AmbiguousChannel { .. } => Standing::Candidate,
                _ => Standing::Doubtful(error),
            },
            None => Standing::Other,
        }
    }

    /// Tells whether several of its fields could be meant.
    pub(super) fn is_ambiguous(&self) -> bool {
        let kind = self.error.as_ref().map(Error::kind);
        matches!(kind, Some(ErrorKind::AmbiguousChannel { .. }))
    }

    /// Returns what keeps the topic from being taken unasked; of several fields, that of the first
    /// if no field is without a doubt.
    pub(super) fn doubt(&self) -> Option<String> {
        match self.error.as_ref().map(Error::kind) {
            Some(ErrorKind::AmbiguousChannel { candidates }) => {
                let all = candidates.0.iter().all(|one| one.doubt.is_some());
                candidates.0.first().filter(|_| all)?.doubt.clone()
            }
            _ => layout::doubt(&self.topic, &self.columns.first()?.path),
        }
    }

    /// Returns the name of the first field.
    pub(super) fn name(&self) -> String {
        let path = self.columns.first().map_or("", |column| &column.path);
        name_of(&self.topic, path)
    }

    /// Brings the fields to a uniform time base.
    ///
    /// # Errors
    ///
    /// What is wrong with the topic as a whole, or with its only field.
    pub(super) fn finish(
        mut self,
        options: &ReadOptions,
        limits: &Limits,
    ) -> Result<Finished, Error> {
        if let Some(error) = self.error.take() {
            return Err(error);
        }
        if let [column] = &mut self.columns[..]
            && let Some(error) = column.error.take()
        {
            return Err(error);
        }
        let first = self.name();
        let place = Place::default().channel(&first);
        let mut findings = Vec::new();
        let stamps = self
            .stamps_s(options, &mut findings)
            .map_err(|error| error.at(place.clone()))?;
        let base = TimeBase::fit(&stamps, 1e-9, limits).map_err(|error| error.at(place.clone()))?;
        findings.extend(base.findings.iter().cloned());
        options
            .check_rate(
                base.rate.hertz(),
                "the times of the messages",
                "leave out the rate, which the messages themselves give",
            )
            .map_err(|error| error.at(place))?;
        let (topic, remarks) = (self.topic, self.remarks);
        Ok(self
            .columns
            .into_iter()
            .map(|column| {
                let name = name_of(&topic, &column.path);
                let place = Place::default().channel(&name);
                let words = layout::words_of(&topic, &column.path);
                let channel = column
                    .into_channel((&words, &remarks), &base, &stamps, &findings, options)
                    .map_err(|error| error.at(place));
                (name, channel)
            })
            .collect())
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
        if stamped && !use_stamps {
            findings.push(Finding::warning(
                "stamp-zero",
                "header.stamp is 0 in every message; the time of logging is used, which carries \
                 the delays of transport",
            ));
        } else if !use_stamps {
            findings.push(Finding::warning(
                "log-time",
                "the messages have no header.stamp; the time of logging is used, which carries \
                 the delays of transport",
            ));
        }
        let Some(end) = self.logged.len().checked_sub(1) else {
            return Ok(Vec::new());
        };
        let (first, last) = (time(0), time(end));
        for index in 1..=end {
            let (previous, found) = (time(index - 1), time(index));
            if found <= previous {
                let place = Place::default().channel(format!(
                    "{}, message {} (seconds after the first)",
                    self.name(),
                    index + 1
                ));
                return Err(Error::from(ErrorKind::TimeNotIncreasing {
                    previous: seconds(previous - first),
                    found: seconds(found - first),
                })
                .at(place));
            }
        }
        if use_stamps {
            let logged = i128::from(self.logged[end]) - i128::from(self.logged[0]);
            let stamped = last - first;
            // Transport comes late now and then; a clock that runs slow is late all the time.
            if logged > stamped + stamped / 2 + LATE_NS {
                findings.push(Finding::warning(
                    "log-time-differs",
                    format!(
                        "the messages' own stamps span {} s, the times at which they were logged \
                         {} s: one of the two clocks is wrong, or what was measured before was \
                         sent slowly; the stamps are used",
                        seconds_text(stamped),
                        seconds_text(logged)
                    ),
                ));
            }
        }
        let zero = match options.time_zero_s {
            Some(instant_s) => nanoseconds(instant_s)?,
            None => first,
        };
        if !(first..=last).contains(&zero) {
            findings.push(Finding::warning(
                "time-zero-outside",
                format!(
                    "time zero is not between the first and the last message; on the file's \
                     clock these are at {} s and {} s",
                    seconds_text(first),
                    seconds_text(last)
                ),
            ));
        }
        Ok((0..=end).map(|index| seconds(time(index) - zero)).collect())
    }
}

/// Values kept in all, times and all topics included, per sample that is allowed.
const KEPT_PER_SAMPLE: u64 = 4;

impl Column {
    fn into_channel(
        self,
        (words, remarks): (&Named, &[Remark]),
        base: &TimeBase,
        stamps: &[f64],
        findings: &[Finding],
        options: &ReadOptions,
    ) -> Result<Channel, Error> {
        if let Some(error) = self.error {
            return Err(error);
        }
        let mut findings = findings.to_vec();
        let stated = words.stated();
        findings.extend(stated.findings(base.rate));
        findings.extend(words.name_findings());
        if options.channel.is_some() {
            findings.extend(words.not_lateral_finding());
        }
        let own = self.unit.map(|unit| (unit, "format"));
        let unit = Unit::find(own, options, &mut findings, |_, used| {
            let own = self.unit?.name();
            Some(format!(
                "the message type prescribes {own}; {used} was stated and is used"
            ))
        });
        let draft = Draft {
            name: words.name.clone(),
            unit,
            start_s: base.start_s,
            rate: base.rate,
            values: base.apply(stamps, self.values)?,
            stated,
            findings,
            remarks: remarks.to_vec(),
        };
        // The stamps count from time zero already, which in nanoseconds loses no digit.
        Ok(draft.finish(None, &options.accepted_remarks))
    }
}

/// Returns where a message stands: the byte of its record and the channel with its number.
fn place(topic: &str, number: u64, byte: u64, path: &str) -> Place {
    Place::default()
        .byte(byte)
        .channel(format!("{}, message {number}", name_of(topic, path)))
}

/// Returns the path of a lateral acceleration in a JSON message that is not among `paths`.
fn further_lateral(paths: &[String], data: &[u8]) -> Result<Option<String>, Error> {
    let mut further = None;
    let mut found = |path: &str, leaf: Leaf| {
        let numeric = matches!(leaf, Leaf::Number(_) | Leaf::Null);
        if numeric && !paths.iter().any(|known| known == path) && says_lateral(path) {
            further = Some(path.to_string());
        }
    };
    json::walk(data, &mut found).map_err(|reason| damaged_message("a JSON message", &reason))?;
    Ok(further)
}

/// Takes the numbers at `paths` from a JSON message. Returns a fingerprint of its fields.
fn read_json(paths: &[String], data: &[u8], slots: &mut [f64]) -> Result<u64, Error> {
    let mut leaves: Vec<Option<Leaf>> = vec![None; paths.len()];
    let (mut twice, mut shape) = (None, 0_u64);
    let mut found = |path: &str, leaf: Leaf| {
        for (slot, wanted) in leaves.iter_mut().zip(paths) {
            if wanted == path && slot.replace(leaf).is_some() {
                twice = Some(path.to_string());
            }
        }
        if matches!(leaf, Leaf::Number(_) | Leaf::Null) && !path.contains('[') {
            shape = shape.wrapping_add(cdr::hash(path.as_bytes()));
        }
    };
    json::walk(data, &mut found).map_err(|reason| damaged_message("a JSON message", &reason))?;
    if let Some(path) = twice {
        return Err(damaged_message(
            &format!("the field {path} once"),
            "it twice",
        ));
    }
    let frame = FRAME.join(".");
    for ((leaf, path), slot) in leaves.into_iter().zip(paths).zip(slots) {
        let kind = match leaf {
            Some(Leaf::Number(value)) => {
                *slot = value;
                continue;
            }
            Some(Leaf::Text(fingerprint)) if *path == frame => {
                *slot = fingerprint;
                continue;
            }
            Some(Leaf::Text(_)) => "a text",
            Some(Leaf::Null) => "null",
            Some(Leaf::Boolean) => "a boolean",
            None => {
                return Err(damaged_message(
                    &format!("the field {path}, as in the first message"),
                    "none",
                ));
            }
        };
        let found = format!("{kind} in {path}");
        return Err(ErrorKind::NonFinite { found }.into());
    }
    Ok(shape)
}

/// Returns a stamp in whole nanoseconds.
fn stamp_ns([sec, nanosec]: [f64; 2]) -> Result<i64, Error> {
    // 9.2e9 s in nanoseconds still fit 64 bits.
    let whole = |value: f64| value.trunc().total_cmp(&value).is_eq();
    if !(whole(sec) && sec.abs() <= 9.2e9 && whole(nanosec) && (0.0..1e9).contains(&nanosec)) {
        return Err(damaged_message(
            "a stamp of whole seconds, and nanoseconds below 10^9",
            &format!("{sec} s and {nanosec} ns"),
        ));
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
    let text = format!("{}", instant_s.abs());
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
    let time = time_ns.unsigned_abs();
    let second = NANO.unsigned_abs();
    format!("{sign}{}.{:09}", time / second, time % second)
}
