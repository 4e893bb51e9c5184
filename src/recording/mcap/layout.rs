//! Where in the messages of a type stands what is wanted of them, and in which unit.

use super::cdr::{self, MessagePlan};
use super::json;
use super::protobuf;
use super::ros::{self, Dialect, plain_name};
use super::types::{Budget, FIELDS, FieldKind, Leaf, MessageTypes, too_many_fields};
use crate::error::{Error, ErrorKind};
use crate::recording::csv::header::Column as Named;
use crate::units::AccelerationUnit;
use std::rc::Rc;

/// Message types whose lateral acceleration is known, with the path to it. REP 103: x
/// forward, y to the left, z up.
const LATERAL: [(&str, &str); 2] = [
    ("sensor_msgs/Imu", "linear_acceleration.y"),
    ("geometry_msgs/AccelStamped", "accel.linear.y"),
];

/// Fields that a message type is asked for.
#[derive(Debug, Clone, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct WantedFields {
    /// Every floating-point field that is no array element.
    pub(super) every: bool,
    /// The field that a person names.
    pub(super) path: Option<String>,
    /// Whether the topic may be meant, so that it is no mere neighbour of the one that is.
    pub(super) meant: bool,
}

/// Tells whether a message type of our users' own has a field whose name says lateral
/// acceleration; one with too many fields to look at may have.
pub(super) fn has_lateral_field(schema: &Schema, budget: &mut Budget) -> Result<bool, Error> {
    let known = schema.language().is_some();
    let numbers = schema.types().and_then(|types| types.numbers(budget));
    match numbers {
        Ok(numbers) => Ok(floats(&numbers).iter().any(|path| names_lateral(path))),
        Err(error) => match error.kind() {
            ErrorKind::LimitExceeded { .. } => Err(error),
            _ => Ok(known && error == too_many_fields()),
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

/// Tells whether a path's own words say lateral acceleration, be it a dummy's.
pub(super) fn names_lateral(path: &str) -> bool {
    !path.contains('[') && named(path).says_lateral_acceleration()
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

/// Returns what the words of a topic and a field say.
pub(super) fn words_of(topic: &str, path: &str) -> Named {
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

/// How messages are walked through.
#[derive(Debug)]
pub(super) enum Messages {
    Ros(MessagePlan),
    Protobuf(MessageTypes),
    Json,
}

/// Where in a message of a type stands what is wanted of it; topics of one type share it.
#[derive(Debug)]
pub(super) struct MessageLayout {
    pub(super) messages: Messages,
    /// The paths to what is wanted, in the order of the slots.
    pub(super) paths: Vec<String>,
    /// The first of all fields that hold numbers.
    pub(super) known: Vec<String>,
    /// The fields, with their units.
    pub(super) columns: Vec<(String, Option<AccelerationUnit>)>,
    /// Whether a number follows the columns that says whether there is an estimate.
    pub(super) estimate: bool,
    /// Whether a fingerprint of the frame's name follows.
    pub(super) frame: bool,
    /// Whether the two numbers of a stamp come last.
    pub(super) stamped: bool,
}

/// Why a message type has no layout.
#[derive(Debug, Clone)]
pub(super) enum Unfit {
    /// It has no field that is wanted.
    Other,
    /// It cannot be read.
    Unreadable(Error),
}

impl From<Error> for Unfit {
    fn from(error: Error) -> Self {
        Self::Unreadable(error)
    }
}

/// The layout of a type's messages, or why there is none.
pub(super) type Laid = Result<Rc<MessageLayout>, Unfit>;

/// Finds what is wanted of the messages of a type that has a schema.
pub(super) fn layout(
    encoding: &str,
    schema: Option<&Schema>,
    wanted: &WantedFields,
    budget: &mut Budget,
) -> Result<Laid, Error> {
    match typed_layout(encoding, schema, wanted, budget) {
        Err(Unfit::Unreadable(error))
            if matches!(error.kind(), ErrorKind::LimitExceeded { .. }) =>
        {
            Err(error)
        }
        other => Ok(other.map(Rc::new)),
    }
}

fn typed_layout(
    encoding: &str,
    schema: Option<&Schema>,
    wanted: &WantedFields,
    budget: &mut Budget,
) -> Result<MessageLayout, Unfit> {
    let (expected, language) = match encoding {
        "cdr" => ("ros2msg", Language::Ros(Dialect::Ros2)),
        "ros1" => ("ros1msg", Language::Ros(Dialect::Ros1)),
        "protobuf" => ("protobuf", Language::Protobuf),
        other => {
            let expected = "messages encoded as cdr, ros1, protobuf or json";
            return Err(refused(expected, &format!("`{other}`")).into());
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
    let all = numbers
        .iter()
        .filter(|(_, is_float)| *is_float && wanted.every);
    let mut paths = shown(all.map(|(path, _)| path));
    let asked = wanted.path.iter().filter(|path| !paths.contains(path));
    let asked: Vec<String> = asked.cloned().collect();
    paths.extend(asked);
    paths.retain(|path| types.way_to_number(path).is_some());
    let unit = |path: &String| unit_of_type(&types, path).or_else(|| unit_in_name(path));
    let columns: Vec<_> = paths
        .iter()
        .map(|path| (path.clone(), unit(path)))
        .collect();
    let meant = |path: &&str| wanted.path.as_deref().is_none_or(|asked| asked == *path);
    let promised = lateral_path(&schema.name).filter(meant);
    if columns.is_empty() && wanted.path.is_none() && promised.is_none() {
        return Err(Unfit::Other);
    }
    let lacking = promised.filter(|path| !paths.iter().any(|known| known == path));
    let is_number = |path: &str| types.way_to_number(path).is_some();
    let kind = types.way(FRAME).and_then(|way| Some(&way.last()?.1.kind));
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
    let mut layout = MessageLayout::of(columns, (frame, &stamps), is_number);
    layout.known = listed(&numbers);
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
    /// Lays out columns and what follows them, of which `has` tells whether it is a number of the
    /// messages; of JSON, if nothing else is said.
    fn of(
        columns: Vec<(String, Option<AccelerationUnit>)>,
        (frame, stamps): (bool, &[[String; 2]]),
        has: impl Fn(&str) -> bool,
    ) -> Self {
        let mut paths: Vec<String> = columns.iter().map(|(path, _)| path.clone()).collect();
        // What an Imu's covariance may deny.
        let deniable = |path: &String| path.starts_with("linear_acceleration.");
        let estimate = paths.iter().any(deniable) && has(ESTIMATE);
        paths.extend(estimate.then(|| ESTIMATE.to_string()));
        paths.extend(frame.then(|| FRAME.to_string()));
        let stamp = stamps.iter().find(|pair| pair.iter().all(|path| has(path)));
        paths.extend(stamp.into_iter().flatten().cloned());
        Self {
            messages: Messages::Json,
            paths,
            known: Vec::new(),
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
    let prescribed = way.iter().any(|(own, field, _)| {
        let own = plain_name(&own.replace('.', "/"));
        matches!(
            (own.as_str(), field.name.as_str()),
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

/// Returns the first names of a list for a message.
fn listed(numbers: &[(String, bool)]) -> Vec<String> {
    let first = numbers.iter().take(LISTED);
    first.map(|(path, _)| path.clone()).collect()
}

/// Returns which of a message's numbers are wanted; of each is told whether it is one now, for what
/// is null now may be a number in the next message.
fn json_fields(numbers: &[(String, bool)], wanted: &WantedFields) -> Vec<String> {
    let every = wanted.every && numbers.iter().any(|(path, _)| names_lateral(path));
    let stamps = JSON_STAMPS.as_flattened();
    let data = |(path, is_number): &&(String, bool)| {
        every && !stamps.contains(&path.as_str()) && (*is_number || names_lateral(path))
    };
    let mut found = shown(numbers.iter().filter(data).map(|(path, _)| path));
    let asked = numbers
        .iter()
        .find(|(path, _)| Some(path) == wanted.path.as_ref());
    if let Some((path, _)) = asked.filter(|(path, _)| !found.contains(path)) {
        found.push(path.clone());
    }
    found
}

/// Learns the fields of a JSON topic from its first message.
pub(super) fn json_layout(data: &[u8], wanted: &WantedFields) -> Result<MessageLayout, Unfit> {
    let mut numbers: Vec<(String, bool)> = Vec::new();
    let (mut frame, mut too_many) = (false, false);
    let mut found = |path: &str, leaf: Leaf| {
        frame |= path == FRAME && matches!(leaf, Leaf::Text(_));
        // What is null now may be a number in the next message.
        let numeric = matches!(leaf, Leaf::Number(_) | Leaf::Null);
        let is_wanted = wanted.path.as_deref() == Some(path);
        if numeric && (is_wanted || path == ESTIMATE || !path.contains('[')) {
            too_many |= numbers.len() > FIELDS;
            if !too_many && !numbers.iter().any(|(known, _)| known == path) {
                numbers.push((path.to_string(), matches!(leaf, Leaf::Number(_))));
            }
        }
    };
    json::walk(data, &mut found)?;
    if too_many {
        return Err(too_many_fields().into());
    }
    let has = |path: &str| numbers.iter().any(|(known, _)| known == path);
    let chosen = json_fields(&numbers, wanted);
    if chosen.is_empty() && wanted.path.is_none() {
        return Err(Unfit::Other);
    }
    let unit = |path: String| (path.clone(), unit_in_name(&path));
    let columns = chosen.into_iter().map(unit).collect();
    let stamps = JSON_STAMPS.map(|stamp| stamp.map(str::to_string));
    let mut layout = MessageLayout::of(columns, (frame, &stamps), has);
    layout.known = listed(&numbers);
    Ok(layout)
}

/// A schema as the file holds it.
#[derive(Debug, PartialEq)]
pub(super) struct Schema {
    pub(super) name: String,
    pub(super) encoding: String,
    pub(super) data: Vec<u8>,
    /// Whether a field's name says lateral acceleration, once that was asked.
    pub(super) has_lateral_field: Option<bool>,
}

/// Says that a topic's messages have no number at a path.
pub(super) fn no_field(topic: &str, path: &str, known: &[String]) -> Error {
    let first = known.iter().take(LISTED);
    let mut names: Vec<String> = first.map(|path| name_of(topic, path)).collect();
    if names.len() >= LISTED {
        names.push("…".into());
    }
    let known = match names.as_slice() {
        [] => format!("no number field in {topic}"),
        names => names.join(", "),
    };
    let wanted = name_of(topic, path);
    ErrorKind::NoSuchChannel { wanted, known }.into()
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
