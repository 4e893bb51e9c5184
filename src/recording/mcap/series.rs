//! One topic's messages turned into numbers: which fields, at which stamps.

use super::json::{self, Leaf};
use super::schema::{Definitions, Dialect, Number, Plan, plain_name};
use super::{cdr, name_of, protobuf, records};

use crate::error::{Candidates, Error, ErrorKind, Place};
use crate::recording::csv::header::Column as Named;
use crate::recording::time_base::TimeBase;
use crate::recording::{Channel, Finding, Limits, ReadOptions};
use crate::units::AccelerationUnit;

/// Message types whose lateral acceleration is known, with the path to it. REP 103: x
/// forward, y to the left, z up.
const LATERAL: [(&str, &str); 2] = [
    ("sensor_msgs/Imu", "linear_acceleration.y"),
    ("geometry_msgs/AccelStamped", "accel.linear.y"),
];

/// Fields that a message type is asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Wanted {
    /// The lateral acceleration.
    Lateral,
    /// This one.
    Path(String),
    /// Every floating-point field that is no array element.
    Every,
}

/// Tells whether a message type carries a lateral acceleration.
pub(super) fn is_acceleration(schema_name: &str) -> bool {
    lateral_path(schema_name).is_some()
}

/// Tells whether a message type of our users' own has a field whose name says lateral
/// acceleration.
pub(super) fn has_lateral_field(name: &str, encoding: &str, data: &[u8]) -> bool {
    let paths: Vec<String> = match encoding {
        "protobuf" => protobuf::Descriptor::read(name, data)
            .map(|descriptor| descriptor.numbers(LISTED))
            .unwrap_or_default()
            .into_iter()
            .filter_map(|(path, is_float)| is_float.then_some(path))
            .collect(),
        _ => Dialect::of_schema(encoding)
            .and_then(|dialect| {
                let text = std::str::from_utf8(data).ok()?;
                Definitions::read(name, text, dialect).ok()
            })
            .map(|definitions| definitions.numbers(LISTED))
            .unwrap_or_default()
            .into_iter()
            .filter_map(|(path, number)| number.is_float().then_some(path))
            .collect(),
    };
    paths.iter().any(|path| says_lateral(path))
}

/// Tells whether a path's own words say lateral acceleration.
fn says_lateral(path: &str) -> bool {
    let named = named(path);
    !path.contains('[')
        && named.says_lateral_acceleration()
        && named.not_lateral_finding().is_none()
}

/// Reads a path as a column's name, with the unit that its end may state (`ay_g`).
fn named(path: &str) -> Named {
    let (parents, own) = path.rsplit_once('.').unwrap_or(("", path));
    let column = Named::from_header(own, 0);
    // The unit is that of the field; words on the way to it tell what it is.
    let mut whole = Named::from_header(&format!("{parents} {}", column.label), 0);
    whole.name = path.to_string();
    whole.unit = column.unit;
    whole.unit_text = column.unit_text;
    whole
}

/// Returns the unit of acceleration that the end of a field's name states.
fn unit_in_name(path: &str) -> Option<AccelerationUnit> {
    named(path).unit
}

fn lateral_path(schema_name: &str) -> Option<&'static str> {
    let plain = plain_name(&schema_name.replace('.', "/"));
    LATERAL
        .iter()
        .find(|(name, _)| *name == plain)
        .map(|(_, path)| *path)
}

/// Most names in a list of fields.
const LISTED: usize = 60;
/// Nanoseconds in a second.
const NANO: i128 = 1_000_000_000;
/// Paths of the two numbers of a stamp.
const STAMP: [&str; 2] = ["header.stamp.sec", "header.stamp.nanosec"];
/// The same in ROS 1.
const ROS1_STAMP: [&str; 2] = ["header.stamp.secs", "header.stamp.nsecs"];

/// How the numbers of a message are found.
#[derive(Debug)]
enum Extractor {
    Cdr(Plan),
    Ros1(Plan),
    Protobuf(Vec<protobuf::Target>),
    /// JSON tells its fields only in the first message.
    JsonUnseen(Wanted),
    Json(Vec<String>),
}

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
pub(super) struct Series {
    topic: String,
    extractor: Extractor,
    columns: Vec<Column>,
    /// Numbers of the message at hand: columns first, then the stamp if there is one.
    slots: Vec<f64>,
    stamped: bool,
    /// Stamps in the messages [ns].
    stamps: Vec<i64>,
    /// Times of recording [ns]; kept only while no stamp has shown to be of use.
    logged: Vec<u64>,
    /// The first thing wrong with the whole; nothing is read after it.
    error: Option<Error>,
}

impl Series {
    /// Prepares to read the messages of a topic.
    pub(super) fn new(
        topic: &str,
        encoding: &str,
        schema: Option<&Schema>,
        wanted: Wanted,
    ) -> Self {
        let mut series = Self {
            topic: topic.to_string(),
            extractor: Extractor::JsonUnseen(wanted.clone()),
            columns: Vec::new(),
            slots: Vec::new(),
            stamped: false,
            stamps: Vec::new(),
            logged: Vec::new(),
            error: None,
        };
        let prepared = match encoding {
            "json" => Ok(()),
            "protobuf" => series.prepare_protobuf(schema, &wanted),
            _ => series.prepare_ros(encoding, schema, &wanted),
        };
        series.error = prepared.err();
        series
    }

    fn prepare_ros(
        &mut self,
        encoding: &str,
        schema: Option<&Schema>,
        wanted: &Wanted,
    ) -> Result<(), Error> {
        refuse_encoding(encoding)?;
        let Some(schema) = schema else {
            return Err(refused(
                "a schema for the topic's messages",
                "none: the topic is without schema",
            ));
        };
        let expected = if encoding == "ros1" {
            "ros1msg"
        } else {
            "ros2msg"
        };
        let Some(dialect) =
            Dialect::of_schema(&schema.encoding).filter(|_| schema.encoding == expected)
        else {
            return Err(refused(
                &format!("a schema in the {expected} encoding"),
                &format!("`{}`", schema.encoding),
            ));
        };
        let text = std::str::from_utf8(&schema.data)
            .map_err(|_| refused("a schema in UTF-8", "other bytes"))?;
        let definitions = Definitions::read(&schema.name, text, dialect)?;
        let floats: Vec<String> = definitions
            .numbers(LISTED)
            .into_iter()
            .filter(|(path, number)| number.is_float() && !path.contains('['))
            .map(|(path, _)| path)
            .collect();
        let known: Vec<String> = definitions
            .numbers(LISTED)
            .into_iter()
            .map(|(path, _)| path)
            .collect();
        let paths = self.wanted_paths(&schema.name, wanted, floats, &known)?;
        for path in &paths {
            let Some(target) = definitions.target(path) else {
                return Err(no_field(&self.topic, path, known));
            };
            self.add_column(path, target.unit.or_else(|| unit_in_name(path)));
        }
        let (stamp, kinds) = match dialect {
            Dialect::Ros2 => (STAMP, [Number::I32, Number::U32]),
            Dialect::Ros1 => (ROS1_STAMP, [Number::U32, Number::U32]),
        };
        let found = stamp.map(|path| definitions.target(path).map(|target| target.number));
        self.stamped = found == kinds.map(Some);
        let mut all: Vec<&str> = paths.iter().map(String::as_str).collect();
        if self.stamped {
            all.extend(stamp);
        }
        self.slots = vec![0.0; all.len()];
        let plan = definitions.plan(&all)?;
        self.extractor = match dialect {
            Dialect::Ros2 => Extractor::Cdr(plan),
            Dialect::Ros1 => Extractor::Ros1(plan),
        };
        Ok(())
    }

    fn prepare_protobuf(&mut self, schema: Option<&Schema>, wanted: &Wanted) -> Result<(), Error> {
        let Some(schema) = schema else {
            return Err(refused(
                "a schema for the topic's messages",
                "none: the topic is without schema",
            ));
        };
        if schema.encoding != "protobuf" {
            return Err(refused(
                "a schema in the protobuf encoding",
                &format!("`{}`", schema.encoding),
            ));
        }
        let descriptor = protobuf::Descriptor::read(&schema.name, &schema.data)?;
        let numbers = descriptor.numbers(LISTED);
        let floats: Vec<String> = numbers
            .iter()
            .filter(|(path, is_float)| *is_float && !path.contains('['))
            .map(|(path, _)| path.clone())
            .collect();
        let known: Vec<String> = numbers.into_iter().map(|(path, _)| path).collect();
        let paths = self.wanted_paths(&schema.name, wanted, floats, &known)?;
        let mut targets = Vec::new();
        for path in &paths {
            let Some(target) = descriptor.target(path) else {
                return Err(no_field(&self.topic, path, known));
            };
            // The types of ROS keep their units when they travel as protobuf.
            let of_type = lateral_path(&schema.name).filter(|lateral| {
                path.trim_end_matches(['x', 'y', 'z']) == lateral.trim_end_matches('y')
            });
            let unit = of_type.map(|_| AccelerationUnit::MetrePerSecondSquared);
            self.add_column(path, unit.or_else(|| unit_in_name(path)));
            targets.push(target);
        }
        if let Some(stamp) = descriptor.stamp() {
            self.stamped = true;
            targets.extend(stamp);
        }
        self.slots = vec![0.0; targets.len()];
        self.extractor = Extractor::Protobuf(targets);
        Ok(())
    }

    /// Returns the paths of the fields that are wanted of a message type.
    fn wanted_paths(
        &self,
        schema_name: &str,
        wanted: &Wanted,
        floats: Vec<String>,
        known: &[String],
    ) -> Result<Vec<String>, Error> {
        let paths = match wanted {
            Wanted::Path(path) => vec![path.clone()],
            Wanted::Every => floats,
            Wanted::Lateral => match lateral_path(schema_name) {
                Some(path) => vec![path.to_string()],
                None => floats
                    .into_iter()
                    .filter(|path| says_lateral(path))
                    .collect(),
            },
        };
        match (wanted, paths.as_slice()) {
            (_, []) => Err(no_field(&self.topic, "", known.to_vec())),
            (Wanted::Lateral, [_, _, ..]) => {
                let names: Vec<String> = paths
                    .iter()
                    .map(|path| name_of(&self.topic, path))
                    .collect();
                Err(ErrorKind::AmbiguousChannel {
                    candidates: Candidates::named(names),
                }
                .into())
            }
            _ => Ok(paths),
        }
    }

    fn add_column(&mut self, path: &str, unit: Option<AccelerationUnit>) {
        self.columns.push(Column {
            path: path.to_string(),
            unit,
            values: Vec::new(),
            error: None,
        });
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
        if let Err(error) = self.take(number, log_time, data, byte, limits) {
            self.error = Some(error);
            return Ok(());
        }
        // Each message costs one value per column and one for its time.
        *kept += self.columns.len() as u64 + 1;
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
        limits: &Limits,
    ) -> Result<(), Error> {
        if let Extractor::JsonUnseen(wanted) = &self.extractor {
            let wanted = wanted.clone();
            self.prepare_json(&wanted, data)
                .map_err(|error| error.at(place(&self.topic, number, byte, "")))?;
        }
        let longest = limits.mcap_string_bytes;
        let odd = |fault: cdr::Fault| match fault.too_long {
            Some(length) => records::too_long(longest, length, "message"),
            None => damaged_message(&fault.expected, &fault.found),
        };
        let slots = &mut self.slots;
        let place = |path: &str| place(&self.topic, number, byte, path);
        match &self.extractor {
            Extractor::Cdr(plan) => cdr::read(plan, data, slots, longest).map_err(odd),
            Extractor::Ros1(plan) => cdr::read_ros1(plan, data, slots, longest).map_err(odd),
            Extractor::Protobuf(targets) => protobuf::read(targets, data, slots)
                .map_err(|(expected, found)| damaged_message(&expected, &found)),
            Extractor::Json(paths) => read_json(paths, data, slots),
            Extractor::JsonUnseen(_) => return Ok(()),
        }
        .map_err(|error| error.at(place("")))?;
        let stamp = if self.stamped {
            let pair = self.slots.last_chunk::<2>().copied().unwrap_or_default();
            Some(stamp_ns(pair).map_err(|error| error.at(place("header.stamp")))?)
        } else {
            None
        };
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
        if let Some(stamp) = stamp {
            if stamp != 0 {
                self.logged = Vec::new();
            } else if self.stamps.len() == self.logged.len() {
                self.logged.push(log_time);
            }
            self.stamps.push(stamp);
        } else {
            self.logged.push(log_time);
        }
        Ok(())
    }

    /// Learns the fields of a JSON topic from its first message.
    fn prepare_json(&mut self, wanted: &Wanted, data: &[u8]) -> Result<(), Error> {
        let mut numbers: Vec<String> = Vec::new();
        let lateral: Vec<&str> = LATERAL.iter().map(|(_, path)| *path).collect();
        let mut found = |path: &str, leaf: Leaf| {
            let base = path.strip_suffix(['x', 'y', 'z']);
            let needed = STAMP.contains(&path)
                || matches!(wanted, Wanted::Path(wanted) if wanted == path)
                || lateral
                    .iter()
                    .any(|lateral| lateral.strip_suffix('y') == base);
            let listed = matches!(leaf, Leaf::Number(_)) && numbers.len() < LISTED;
            if (needed || listed) && !numbers.iter().any(|known| known == path) {
                numbers.push(path.to_string());
            }
        };
        json::walk(data, &mut found)
            .map_err(|reason| damaged_message("a JSON message", &reason))?;
        let has = |path: &str| numbers.iter().any(|known| known == path);
        let chosen: Vec<String> = match wanted {
            Wanted::Path(path) if has(path) => vec![path.clone()],
            Wanted::Path(path) => return Err(no_field(&self.topic, path, numbers)),
            Wanted::Lateral => {
                let found: Vec<String> = lateral
                    .iter()
                    .filter(|path| has(path))
                    .map(|path| (*path).to_string())
                    .collect();
                let found = if found.is_empty() {
                    numbers
                        .iter()
                        .filter(|path| says_lateral(path))
                        .cloned()
                        .collect()
                } else {
                    found
                };
                if found.len() > 1 {
                    let names: Vec<String> = found
                        .iter()
                        .map(|path| name_of(&self.topic, path))
                        .collect();
                    return Err(ErrorKind::AmbiguousChannel {
                        candidates: Candidates::named(names),
                    }
                    .into());
                }
                found
            }
            Wanted::Every => {
                let bases = lateral
                    .iter()
                    .filter(|path| has(path))
                    .map(|path| path.trim_end_matches('y'));
                let triples: Vec<String> = bases
                    .flat_map(|base| ["x", "y", "z"].map(|axis| format!("{base}{axis}")))
                    .filter(|path| has(path))
                    .collect();
                if triples.is_empty() && numbers.iter().any(|path| says_lateral(path)) {
                    let no_stamp = |path: &&String| !STAMP.contains(&path.as_str());
                    numbers.iter().filter(no_stamp).cloned().collect()
                } else {
                    triples
                }
            }
        };
        if chosen.is_empty() {
            return Err(no_field(&self.topic, "", numbers));
        }
        self.stamped = STAMP.iter().all(|path| has(path));
        for path in &chosen {
            self.add_column(path, unit_in_name(path));
        }
        let mut paths = chosen;
        if self.stamped {
            paths.extend(STAMP.map(String::from));
        }
        self.slots = vec![0.0; paths.len()];
        self.extractor = Extractor::Json(paths);
        Ok(())
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
        let topic = self.topic;
        Ok(self
            .columns
            .into_iter()
            .map(|column| {
                let name = name_of(&topic, &column.path);
                let place = Place::default().channel(&name);
                let channel = column
                    .into_channel(name.clone(), &base, &stamps, &findings, options)
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
        let use_stamps = self.stamped && self.stamps.iter().any(|stamp| *stamp != 0);
        let (count, clock): (usize, Box<dyn Fn(usize) -> i128 + '_>) = if use_stamps {
            let stamps = &self.stamps;
            (stamps.len(), Box::new(|index| i128::from(stamps[index])))
        } else {
            let logged = &self.logged;
            (logged.len(), Box::new(|index| i128::from(logged[index])))
        };
        if self.stamped && !use_stamps {
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
        let Some(last) = count.checked_sub(1) else {
            return Ok(Vec::new());
        };
        let first = clock(0);
        for index in 1..count {
            let (previous, found) = (clock(index - 1), clock(index));
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
        let zero = match options.time_zero_s {
            Some(instant_s) => nanoseconds(instant_s)?,
            None => first,
        };
        if !(first..=clock(last)).contains(&zero) {
            findings.push(Finding::warning(
                "time-zero-outside",
                format!(
                    "time zero is not between the first and the last message; on the file's \
                     clock these are at {} s and {} s",
                    seconds_text(first),
                    seconds_text(clock(last))
                ),
            ));
        }
        Ok((0..count)
            .map(|index| seconds(clock(index) - zero))
            .collect())
    }
}

/// Values kept in all, times and all topics included, per sample that is allowed.
const KEPT_PER_SAMPLE: u64 = 4;

/// A schema as the file holds it.
#[derive(Debug, PartialEq)]
pub(super) struct Schema {
    pub(super) name: String,
    pub(super) encoding: String,
    pub(super) data: Vec<u8>,
    /// Whether a field's name says lateral acceleration.
    pub(super) has_lateral_field: bool,
}

impl Column {
    fn into_channel(
        self,
        name: String,
        base: &TimeBase,
        stamps: &[f64],
        findings: &[Finding],
        options: &ReadOptions,
    ) -> Result<Channel, Error> {
        if let Some(error) = self.error {
            return Err(error);
        }
        let mut findings = findings.to_vec();
        let named = named(&self.path);
        let stated = named.stated();
        findings.extend(stated.findings(base.rate));
        findings.extend(named.name_findings());
        if options.channel.is_some() {
            findings.extend(named.not_lateral_finding());
        }
        let (unit, unit_source) = match (self.unit, options.unit) {
            (Some(own), Some(said)) => {
                if own != said {
                    findings.push(Finding::warning(
                        "unit-overridden",
                        format!(
                            "the message type prescribes {}; {} was stated and is used",
                            own.name(),
                            said.name()
                        ),
                    ));
                }
                (Some(said), "option")
            }
            (Some(own), None) => (Some(own), "format"),
            (None, Some(said)) => (Some(said), "option"),
            (None, None) => (None, "none"),
        };
        Ok(Channel {
            name,
            unit,
            unit_source,
            start_s: base.start_s,
            rate: base.rate,
            values: base.apply(stamps, self.values)?,
            stated,
            findings,
        })
    }
}

/// Refuses a message encoding that is not read, by its name.
/// Returns where a message stands: the byte of its record and the channel with its number.
fn place(topic: &str, number: u64, byte: u64, path: &str) -> Place {
    Place::default()
        .byte(byte)
        .channel(format!("{}, message {number}", name_of(topic, path)))
}

fn refuse_encoding(encoding: &str) -> Result<(), Error> {
    Err(match encoding {
        "cdr" | "ros1" => return Ok(()),
        other => ErrorKind::Malformed {
            expected: "messages encoded as cdr, ros1, protobuf or json".into(),
            found: format!("`{other}`"),
            hint: "export the topic as CSV, or write it as JSON or ROS 2 messages".into(),
        },
    }
    .into())
}

/// Takes the numbers at `paths` from a JSON message.
fn read_json(paths: &[String], data: &[u8], slots: &mut [f64]) -> Result<(), Error> {
    let mut leaves: Vec<Option<Leaf>> = vec![None; paths.len()];
    let mut twice = None;
    let mut found = |path: &str, leaf: Leaf| {
        for (slot, wanted) in leaves.iter_mut().zip(paths) {
            if wanted == path && slot.replace(leaf).is_some() {
                twice = Some(path.to_string());
            }
        }
    };
    json::walk(data, &mut found).map_err(|reason| damaged_message("a JSON message", &reason))?;
    if let Some(path) = twice {
        return Err(damaged_message(
            &format!("the field {path} once"),
            "it twice",
        ));
    }
    for ((leaf, path), slot) in leaves.into_iter().zip(paths).zip(slots) {
        *slot = match leaf {
            Some(Leaf::Number(value)) => value,
            Some(Leaf::Other(kind)) => {
                return Err(ErrorKind::NonFinite {
                    found: format!("{kind} in {path}"),
                }
                .into());
            }
            None => {
                return Err(damaged_message(
                    &format!("the field {path}, as in the first message"),
                    "none",
                ));
            }
        };
    }
    Ok(())
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
    #[expect(
        clippy::cast_possible_truncation,
        reason = "both are whole numbers within range"
    )]
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
    let whole = instant_s.floor();
    #[expect(
        clippy::cast_possible_truncation,
        reason = "the range was checked above"
    )]
    Ok(whole as i128 * NANO + ((instant_s - whole) * 1e9).round() as i128)
}

fn seconds(span_ns: i128) -> f64 {
    #[expect(
        clippy::cast_precision_loss,
        reason = "exact up to 104 days, to the nearest double beyond"
    )]
    let span = span_ns as f64;
    span / 1e9
}

fn seconds_text(time_ns: i128) -> String {
    let sign = if time_ns < 0 { "-" } else { "" };
    let time = time_ns.unsigned_abs();
    let second = NANO.unsigned_abs();
    format!("{sign}{}.{:09}", time / second, time % second)
}

fn no_field(topic: &str, path: &str, known: Vec<String>) -> Error {
    let mut names: Vec<String> = known.iter().map(|path| name_of(topic, path)).collect();
    if names.len() >= LISTED {
        names.push("…".into());
    }
    ErrorKind::NoSuchChannel {
        wanted: name_of(topic, path),
        known: if names.is_empty() {
            format!("no number field in {topic}")
        } else {
            names.join(", ")
        },
    }
    .into()
}

fn refused(expected: &str, found: &str) -> Error {
    ErrorKind::Malformed {
        expected: expected.to_string(),
        found: found.to_string(),
        hint: "export the topic as CSV, or record it with a current rosbag2".into(),
    }
    .into()
}

fn damaged_message(expected: &str, found: &str) -> Error {
    ErrorKind::Malformed {
        expected: expected.to_string(),
        found: found.to_string(),
        hint: "the message and its schema contradict one another; record it again".into(),
    }
    .into()
}
