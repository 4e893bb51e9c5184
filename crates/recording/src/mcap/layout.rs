//! Layouts: the position of the requested fields in the messages of a type, and their units.

use super::cdr::{self, MessagePlan};
use super::json;
use super::protobuf;
use super::ros::{self, Dialect, plain_name};
use super::types::{Budget, FIELDS, FieldKind, Leaf, MessageTypes, too_many_fields};
use crate::Limits;
use crate::channel_name::ChannelName;
use crate::error::{Error, ErrorKind};
use latchgate_kernel::units::AccelerationUnit;
use std::rc::Rc;

/// Message types whose lateral acceleration is known, with the path to it. REP 103: x
/// forward, y to the left, z up.
const LATERAL: [(&str, &str); 2] = [
    ("sensor_msgs/Imu", IMU_PATH),
    ("geometry_msgs/AccelStamped", "accel.linear.y"),
];

/// The lateral acceleration of an IMU, and the field of all three, which hold gravity: REP 145 has
/// drivers publish what the sensor feels.
pub(super) const IMU_PATH: &str = "linear_acceleration.y";
pub(super) const IMU_FIELD: &str = "linear_acceleration.";

/// Fields that are requested of a message type.
#[derive(Debug, Clone, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct RequestedFields {
    /// Every floating-point field that is no array element.
    pub(super) every: bool,
    /// The field that a person names.
    pub(super) path: Option<String>,
    /// True if the topic may hold the channel that is meant; any other is read as a neighbour only.
    pub(super) is_candidate: bool,
}

/// True if a field of the schema has a name that says lateral acceleration. A schema with too many
/// fields to list counts as one, so that it is not passed over in silence.
pub(super) fn has_lateral_field(schema: &Schema, budget: &mut Budget) -> Result<bool, Error> {
    let is_readable = schema.language().is_some();
    let numbers = schema.types().and_then(|types| types.numbers(budget));
    match numbers {
        Ok(numbers) => Ok(floats(&numbers).iter().any(|path| names_lateral(path))),
        Err(error) => match error.kind() {
            ErrorKind::LimitExceeded { .. } => Err(error),
            _ => Ok(is_readable && error == too_many_fields()),
        },
    }
}

/// Returns the floating-point fields among a message type's numbers, those in arrays left out.
fn floats(numbers: &[(String, bool)]) -> Vec<String> {
    let single = numbers
        .iter()
        .filter(|(path, is_float)| *is_float && !path.contains('['));
    single.map(|(path, _)| path.clone()).collect()
}

/// The language of a schema.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Language {
    Ros(Dialect),
    Protobuf,
}

impl Schema {
    fn language(&self) -> Option<Language> {
        match self.encoding.as_str() {
            "ros2msg" => Some(Language::Ros(Dialect::Ros2)),
            "ros1msg" => Some(Language::Ros(Dialect::Ros1)),
            "protobuf" => Some(Language::Protobuf),
            _ => None,
        }
    }

    /// Reads the definitions.
    fn types(&self) -> Result<MessageTypes, Error> {
        match self.language() {
            Some(Language::Ros(dialect)) => {
                let text = std::str::from_utf8(&self.data);
                let text = text.map_err(|_| refused("a schema in UTF-8", "other bytes"))?;
                ros::types(&self.name, text, dialect)
            }
            Some(Language::Protobuf) => protobuf::types(&self.name, &self.data),
            None => Ok(MessageTypes::default()),
        }
    }
}

/// True if the words of a path say lateral acceleration, a dummy's included.
pub(super) fn names_lateral(path: &str) -> bool {
    !path.contains('[') && named(path).says_lateral_acceleration()
}

/// Reads a path as a column's name, with the unit that its end may state (`ay_g`).
fn named(path: &str) -> ChannelName {
    let (parents, field_name) = path.rsplit_once('.').unwrap_or(("", path));
    let column = ChannelName::from_header(field_name, 0);
    // The unit is that of the field; the names before it add to the meaning only.
    let mut words = ChannelName::from_header(&format!("{parents} {}", column.label), 0);
    words.name = path.to_string();
    words.unit = column.unit;
    words.unit_text = column.unit_text;
    words
}

/// Returns the meaning of the words of a topic and a field.
pub(super) fn words_of(topic: &str, path: &str) -> ChannelName {
    let mut column = named(path);
    column.label = format!("{} {}", topic.replace('/', " "), column.label);
    column.name = name_of(topic, path);
    column
}

/// Returns the unit of acceleration that the end of a field's name states.
fn unit_in_name(path: &str) -> Option<AccelerationUnit> {
    named(path).unit
}

/// Returns the path of the lateral acceleration in a message type that is known to have one.
pub(super) fn lateral_path(schema_name: &str) -> Option<&'static str> {
    let plain = plain_name(&schema_name.replace('.', "/"));
    LATERAL
        .iter()
        .find(|(name, _)| *name == plain)
        .map(|(_, path)| *path)
}

/// Most names in a list of fields.
const LISTED: usize = 60;
/// Paths of the two numbers of a stamp.
const STAMP: [&str; 2] = ["header.stamp.sec", "header.stamp.nanosec"];
/// The same in ROS 1.
const ROS1_STAMP: [&str; 2] = ["header.stamp.secs", "header.stamp.nsecs"];

/// Path of the number by which a message says that it holds no estimate: −1.
pub(super) const ESTIMATE: &str = "linear_acceleration_covariance[0]";
/// Path of the text that names the sensor's frame.
pub(super) const FRAME: &str = "header.frame_id";
/// Paths under which messages in JSON keep their stamp.
const JSON_STAMPS: [[&str; 2]; 4] = [
    STAMP,
    ROS1_STAMP,
    ["timestamp.sec", "timestamp.nsec"],
    ["header.timestamp.sec", "header.timestamp.nsec"],
];

/// Decoder of the messages of one topic.
#[derive(Debug)]
pub(super) enum Messages {
    Ros(MessagePlan),
    Protobuf(MessageTypes),
    Json,
}

/// Positions of the requested fields in the messages of a type. Topics of one type share it.
#[derive(Debug)]
pub(super) struct MessageLayout {
    pub(super) messages: Messages,
    /// The paths to what is requested, in the order of the slots.
    pub(super) paths: Vec<String>,
    pub(super) contents: Contents,
    /// The fields, with their units.
    pub(super) columns: Vec<(String, Option<AccelerationUnit>)>,
    /// True if the number that can deny an estimate follows the columns.
    pub(super) estimate: bool,
    /// True if a fingerprint of the frame's name follows.
    pub(super) frame: bool,
    /// True if the two numbers of a stamp come last.
    pub(super) stamped: bool,
}

/// The reason why a message type has no layout.
#[derive(Debug, Clone)]
pub(super) enum Unfit {
    /// It has no field that is requested.
    NothingRequested,
    /// It cannot be read.
    Unreadable(Error),
}

impl From<Error> for Unfit {
    fn from(error: Error) -> Self {
        Self::Unreadable(error)
    }
}

/// The layout of a type's messages, or the reason why there is none.
pub(super) type LayoutResult = Result<Rc<MessageLayout>, Unfit>;

/// Returns the layout for what is requested of the messages of a type with a schema.
pub(super) fn layout(
    encoding: &str,
    schema: Option<&Schema>,
    requested: &RequestedFields,
    budget: &mut Budget,
) -> Result<LayoutResult, Error> {
    match typed_layout(encoding, schema, requested, budget) {
        // A crossed limit ends the reading; any other fault only makes this topic unreadable.
        Err(Unfit::Unreadable(error))
            if matches!(error.kind(), ErrorKind::LimitExceeded { .. }) =>
        {
            Err(error)
        }
        layout => Ok(layout.map(Rc::new)),
    }
}

fn typed_layout(
    encoding: &str,
    schema: Option<&Schema>,
    requested: &RequestedFields,
    budget: &mut Budget,
) -> Result<MessageLayout, Unfit> {
    let (expected, language) = match encoding {
        "cdr" => ("ros2msg", Language::Ros(Dialect::Ros2)),
        "ros1" => ("ros1msg", Language::Ros(Dialect::Ros1)),
        "protobuf" => ("protobuf", Language::Protobuf),
        encoding => {
            let expected = "messages encoded as cdr, ros1, protobuf or json";
            return Err(refused(expected, &format!("`{encoding}`")).into());
        }
    };
    let Some(schema) = schema else {
        let found = "none: the topic is without schema";
        return Err(refused("a schema for the topic's messages", found).into());
    };
    if schema.language() != Some(language) {
        return Err(refused(
            &format!("a schema in the {expected} encoding"),
            &format!("`{}`", schema.encoding),
        )
        .into());
    }
    let types = schema.types()?;
    let numbers = types.numbers(budget)?;
    let floats = numbers
        .iter()
        .filter(|(_, is_float)| *is_float && requested.every);
    let mut paths = shown(floats.map(|(path, _)| path));
    if let Some(path) = &requested.path
        && !paths.contains(path)
    {
        paths.push(path.clone());
    }
    paths.retain(|path| types.way_to_number(path).is_some());
    let unit = |path: &String| unit_of_type(&types, path).or_else(|| unit_in_name(path));
    let columns: Vec<_> = paths
        .iter()
        .map(|path| (path.clone(), unit(path)))
        .collect();
    let is_requested = |path: &&str| {
        requested
            .path
            .as_deref()
            .is_none_or(|requested| requested == *path)
    };
    let promised = lateral_path(&schema.name).filter(is_requested);
    if columns.is_empty() && requested.path.is_none() && promised.is_none() {
        return Err(Unfit::NothingRequested);
    }
    let lacking = promised.filter(|path| !paths.iter().any(|listed| listed == path));
    let is_number = |path: &str| types.way_to_number(path).is_some();
    let kind = types
        .way(FRAME)
        .and_then(|way| Some(&way.last()?.field.kind));
    let frame = language != Language::Protobuf && kind == Some(&FieldKind::Text);
    let stamps = match language {
        Language::Ros(Dialect::Ros2) => vec![STAMP.map(str::to_string)],
        Language::Ros(Dialect::Ros1) => vec![ROS1_STAMP.map(str::to_string)],
        Language::Protobuf => {
            let parts = [["seconds", "nanos"], ["sec", "nanosec"], ["sec", "nsec"]];
            let pairs = |base: String| parts.map(|pair| pair.map(|part| format!("{base}.{part}")));
            let bases = protobuf::stamps(&types).into_iter();
            bases.flat_map(pairs).collect()
        }
    };
    let mut layout = MessageLayout::new(columns, frame, &stamps, is_number);
    layout.contents = Contents::of_types(&numbers);
    layout.messages = match language {
        Language::Protobuf => Messages::Protobuf(types),
        Language::Ros(dialect) => Messages::Ros(cdr::plan(&types, dialect, &layout.paths, budget)?),
    };
    if let Some(path) = lacking {
        let found = format!("none in the definition of {}", schema.name);
        return Err(refused(&format!("a floating-point {path}"), &found).into());
    }
    Ok(layout)
}

impl MessageLayout {
    /// Lays out the columns and what follows them. `has` is true for the path of a number in the
    /// messages. The messages are those of JSON until the caller sets another decoder.
    fn new(
        columns: Vec<(String, Option<AccelerationUnit>)>,
        frame: bool,
        stamps: &[[String; 2]],
        has: impl Fn(&str) -> bool,
    ) -> Self {
        let mut paths: Vec<String> = columns.iter().map(|(path, _)| path.clone()).collect();
        // A covariance of −1 states that the message holds no estimate of these fields.
        let deniable = |path: &String| path.starts_with("linear_acceleration.");
        let estimate = paths.iter().any(deniable) && has(ESTIMATE);
        paths.extend(estimate.then(|| ESTIMATE.to_string()));
        paths.extend(frame.then(|| FRAME.to_string()));
        let stamp = stamps.iter().find(|pair| pair.iter().all(|path| has(path)));
        paths.extend(stamp.into_iter().flatten().cloned());
        Self {
            messages: Messages::Json,
            paths,
            contents: Contents::default(),
            columns,
            estimate,
            frame,
            stamped: stamp.is_some(),
        }
    }
}

/// Returns the unit that a message type of ROS prescribes, whatever language it travels in: REP 103
/// states SI units.
fn unit_of_type(types: &MessageTypes, path: &str) -> Option<AccelerationUnit> {
    let way = types.way(path)?;
    let prescribed = way.iter().any(|step| {
        let type_name = plain_name(&step.type_name.replace('.', "/"));
        matches!(
            (type_name.as_str(), step.field.name.as_str()),
            ("sensor_msgs/Imu", "linear_acceleration") | ("geometry_msgs/Accel", "linear")
        )
    });
    prescribed.then_some(AccelerationUnit::MetrePerSecondSquared)
}

/// Returns the paths of fields that are no array elements, of very many the first; those that could be
/// meant are shown however many come before them.
fn shown<'a>(paths: impl Iterator<Item = &'a String>) -> Vec<String> {
    let single = paths.filter(|path| !path.contains('[')).enumerate();
    let shown = single.filter(|(place, path)| *place < LISTED || names_lateral(path));
    shown.map(|(_, path)| path.clone()).collect()
}

/// Returns the requested paths among a message's numbers, of which each says if it is a number now:
/// what is null now may be a number in the next message.
fn json_fields(numbers: &[(String, bool)], requested: &RequestedFields) -> Vec<String> {
    let every = requested.every && numbers.iter().any(|(path, _)| names_lateral(path));
    let stamps = JSON_STAMPS.as_flattened();
    let data = |(path, is_number): &&(String, bool)| {
        every && !stamps.contains(&path.as_str()) && (*is_number || names_lateral(path))
    };
    let mut paths = shown(numbers.iter().filter(data).map(|(path, _)| path));
    let requested = numbers
        .iter()
        .find(|(path, _)| Some(path) == requested.path.as_ref());
    if let Some((path, _)) = requested.filter(|(path, _)| !paths.contains(path)) {
        paths.push(path.clone());
    }
    paths
}

/// Returns the layout of a JSON topic by what its first message holds; `None` where nothing in it
/// is requested.
pub(super) fn json_layout(
    contents: &Contents,
    requested: &RequestedFields,
) -> Option<MessageLayout> {
    let numbers = &contents.numbers;
    let has = |path: &str| numbers.iter().any(|(listed, _)| listed == path);
    let chosen = json_fields(numbers, requested);
    if chosen.is_empty() && requested.path.is_none() {
        return None;
    }
    let unit = |path: String| (path.clone(), unit_in_name(&path));
    let columns = chosen.into_iter().map(unit).collect();
    let stamps = JSON_STAMPS.map(|stamp| stamp.map(str::to_string));
    let mut layout = MessageLayout::new(columns, contents.names_frame, &stamps, has);
    layout.contents = contents.clone();
    Some(layout)
}

/// Contents of a topic's messages: the fields that can be requested.
#[derive(Debug, Clone, Default)]
pub(super) struct Contents {
    /// Paths of numbers of which a message has one, and whether they are floating-point numbers, or
    /// in JSON numbers now.
    pub(super) numbers: Vec<(String, bool)>,
    /// Paths of numbers in arrays, as `samples[0..].ay`.
    arrays: Vec<String>,
    /// Paths of numbers in quotes.
    quoted: Vec<String>,
    /// The encoding, if it is none that is read.
    unread: Option<String>,
    /// True if messages in JSON name the sensor's frame.
    names_frame: bool,
}

/// Returns the contents of a topic's messages by their type.
pub(super) fn contents(encoding: &str, schema: Option<&Schema>, limits: &Limits) -> Contents {
    if !["cdr", "ros1", "protobuf", "json"].contains(&encoding) {
        return Contents {
            unread: Some(encoding.to_string()),
            ..Contents::default()
        };
    }
    let types = schema.and_then(|schema| schema.types().ok());
    let numbers = types.and_then(|types| types.numbers(&mut Budget::new(limits)).ok());
    Contents::of_types(&numbers.unwrap_or_default())
}

impl Contents {
    fn of_types(paths: &[(String, bool)]) -> Self {
        let (arrays, numbers): (Vec<_>, Vec<_>) = paths
            .iter()
            .cloned()
            .partition(|(path, _)| path.contains('['));
        Self {
            numbers,
            arrays: arrays.into_iter().map(|(path, _)| path).collect(),
            ..Self::default()
        }
    }

    /// Reads the contents of a message in JSON. What is null now may be a number in the next message.
    pub(super) fn of_json(data: &[u8], requested: &RequestedFields) -> Result<Self, Error> {
        let mut contents = Self::default();
        let mut too_many = false;
        let mut take_leaf = |path: &str, leaf: Leaf| {
            contents.names_frame |= path == FRAME && matches!(leaf, Leaf::Text(_));
            let is_plain = !path.contains('[');
            if let Leaf::Text(text) = leaf {
                let is_quoted = text.is_number && is_plain && path != FRAME;
                if is_quoted && contents.quoted.len() < LISTED {
                    contents.quoted.push(path.to_string());
                }
            }
            if !matches!(leaf, Leaf::Number(_) | Leaf::Null) {
                return;
            }
            let array = path.replace("[0]", "[0..]");
            if !array.replace("[0..]", "").contains('[') && !is_plain {
                contents
                    .arrays
                    .extend((contents.arrays.len() < LISTED).then_some(array));
            }
            let is_wanted = requested.path.as_deref() == Some(path);
            if is_wanted || path == ESTIMATE || is_plain {
                too_many |= contents.numbers.len() > FIELDS;
                if !too_many && !contents.numbers.iter().any(|(listed, _)| listed == path) {
                    let is_number = matches!(leaf, Leaf::Number(_));
                    contents.numbers.push((path.to_string(), is_number));
                }
            }
        };
        json::walk(data, &mut take_leaf)?;
        match too_many {
            true => Err(too_many_fields()),
            false => Ok(contents),
        }
    }

    /// Returns the reason why no sample can be requested, or not the one that a name promises.
    pub(super) fn why_none(&self) -> Option<String> {
        if let Some(encoding) = &self.unread {
            return Some(format!("messages in `{encoding}` are not read"));
        }
        let promising = |paths: &[String]| {
            let is_candidate = |path: &&String| self.fields().is_empty() || promises_lateral(path);
            let promising = paths.iter().filter(is_candidate).take(3).cloned();
            promising.collect::<Vec<String>>().join(", ")
        };
        let (arrays, quoted) = (promising(&self.arrays), promising(&self.quoted));
        if !arrays.is_empty() {
            return Some(format!(
                "arrays of numbers, {arrays}: latchgate reads one sample a message"
            ));
        }
        (!quoted.is_empty()).then(|| format!("numbers in quotes, {quoted}, are not read"))
    }

    /// True if no name in it promises a lateral acceleration.
    pub(super) fn is_foreign(&self) -> bool {
        let mut promised = self.arrays.iter().chain(&self.quoted);
        !promised.any(|path| promises_lateral(path))
    }

    /// Returns the paths of numbers that may be samples.
    fn fields(&self) -> Vec<&String> {
        let stamps = JSON_STAMPS.as_flattened();
        let is_stamp = |path: &str| stamps.contains(&path) || path == ESTIMATE;
        let paths = self.numbers.iter().map(|(path, _)| path);
        paths.filter(|path| !is_stamp(path)).collect()
    }

    /// Names the fields of a topic for a list of topics: only those that say lateral acceleration, if
    /// there are any.
    pub(super) fn in_words(&self, topic: &str) -> String {
        const SHOWN: usize = 3;
        let fields = self.fields();
        let lateral = || fields.iter().copied().filter(|path| names_lateral(path));
        let mut shown: Vec<&String> = lateral().take(SHOWN).collect();
        if shown.is_empty() {
            shown = fields.iter().copied().take(SHOWN).collect();
        }
        let names: Vec<String> = shown.iter().map(|path| name_of(topic, path)).collect();
        let mut text = match names.as_slice() {
            [] => String::new(),
            names => format!(" with {}", names.join(", ")),
        };
        if fields.len() > shown.len() {
            text += &format!(" and {} more", fields.len() - shown.len());
        }
        text + &self
            .why_none()
            .map_or(String::new(), |why| format!(" ({why})"))
    }
}

/// True if the words of a path say lateral acceleration, its arrays ignored.
fn promises_lateral(path: &str) -> bool {
    let parts = path
        .split('[')
        .map(|part| part.split_once(']').map_or(part, |(_, suffix)| suffix));
    named(&parts.collect::<String>()).says_lateral_acceleration()
}

/// A schema as the file holds it.
#[derive(Debug, PartialEq)]
pub(super) struct Schema {
    pub(super) name: String,
    pub(super) encoding: String,
    pub(super) data: Vec<u8>,
    /// True if a field's name says lateral acceleration; `None` until it was computed.
    pub(super) has_lateral_field: Option<bool>,
}

/// Returns the error for a topic whose messages have no number at a path.
pub(super) fn no_field(topic: &str, path: &str, contents: &Contents) -> Error {
    let numbers = contents.numbers.iter().map(|(path, _)| path);
    let first = numbers.chain(&contents.arrays).take(LISTED);
    let mut names: Vec<String> = first.map(|path| name_of(topic, path)).collect();
    if names.len() >= LISTED {
        names.push("…".into());
    }
    let mut available = match names.as_slice() {
        [] => format!("no number field in {topic}"),
        names => names.join(", "),
    };
    available += &contents
        .why_none()
        .map_or(String::new(), |why| format!(" ({why})"));
    let requested = name_of(topic, path);
    ErrorKind::NoSuchChannel {
        requested,
        known: available,
    }
    .into()
}

fn refused(expected: &str, found: &str) -> Error {
    let hint = "export the topic as CSV, or record it with a current rosbag2";
    Error::malformed(expected, found, hint)
}

/// Returns a channel's name.
pub(super) fn name_of(topic: &str, path: &str) -> String {
    if path.is_empty() {
        topic.to_string()
    } else {
        format!("{topic}:{path}")
    }
}
