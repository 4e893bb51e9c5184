//! Where in the messages of a type stands what is wanted of them, and in which unit.

use super::json::{self, Leaf};
use super::protobuf;
use super::schema::{
    Budget, DecodePlan, Definitions, Dialect, FIELDS, Number, plain_name, too_many_fields,
};
use crate::error::{Candidates, Error, ErrorKind};
use crate::recording::csv::header::Column as Named;
use crate::units::AccelerationUnit;
use std::collections::BTreeSet;
use std::rc::Rc;

/// Message types whose lateral acceleration is known, with the path to it. REP 103: x
/// forward, y to the left, z up.
const LATERAL: [(&str, &str); 2] = [
    ("sensor_msgs/Imu", "linear_acceleration.y"),
    ("geometry_msgs/AccelStamped", "accel.linear.y"),
];

/// Fields that a message type is asked for.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum WantedFields {
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
/// acceleration; one with too many fields to look at may have.
///
/// # Errors
///
/// [`ErrorKind::LimitExceeded`] once `budget` is spent.
pub(super) fn has_lateral_field(schema: &Schema, budget: &mut Budget) -> Result<bool, Error> {
    match floats(schema, budget) {
        Ok(floats) => Ok(floats.iter().any(|path| names_lateral(path))),
        Err(error) => match error.kind() {
            ErrorKind::LimitExceeded { .. } => Err(error),
            _ => Ok(error == too_many_fields()),
        },
    }
}

/// Returns the paths of a message type's floating-point fields, those in arrays left out.
fn floats(schema: &Schema, budget: &mut Budget) -> Result<Vec<String>, Error> {
    let single = |path: &String| !path.contains('[');
    if schema.encoding == "protobuf" {
        let numbers = protobuf::Descriptor::read(&schema.name, &schema.data)?.numbers(budget)?;
        let floats = numbers.into_iter().filter(|(_, is_float)| *is_float);
        return Ok(floats.map(|(path, _)| path).filter(single).collect());
    }
    let Some(dialect) = Dialect::of_schema(&schema.encoding) else {
        return Ok(Vec::new());
    };
    let numbers = ros_definitions(schema, dialect)?.numbers(budget)?;
    let floats = numbers.into_iter().filter(|(_, number)| number.is_float());
    Ok(floats.map(|(path, _)| path).filter(single).collect())
}

fn ros_definitions(schema: &Schema, dialect: Dialect) -> Result<Definitions, Error> {
    let text = std::str::from_utf8(&schema.data)
        .map_err(|_| refused("a schema in UTF-8", "other bytes"))?;
    Definitions::read(&schema.name, text, dialect)
}

/// Tells whether a topic's own words say a dummy, a barrier or the like.
pub(super) fn is_elsewhere(topic: &str) -> bool {
    Named::from_header(&topic.replace('/', " "), 0).says_elsewhere()
}

/// Tells whether a path's own words say lateral acceleration, be it a dummy's.
fn names_lateral(path: &str) -> bool {
    !path.contains('[') && named(path).says_lateral_acceleration()
}

/// Tells whether a path's own words say lateral acceleration of the vehicle.
pub(super) fn says_lateral(path: &str) -> bool {
    names_lateral(path) && named(path).not_lateral_finding().is_none()
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

fn lateral_path(schema_name: &str) -> Option<&'static str> {
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
pub(super) const FRAME: [&str; 2] = ["header", "frame_id"];
/// Paths under which messages in JSON keep their stamp.
const JSON_STAMPS: [[&str; 2]; 4] = [
    STAMP,
    ROS1_STAMP,
    ["timestamp.sec", "timestamp.nsec"],
    ["header.timestamp.sec", "header.timestamp.nsec"],
];

/// How the numbers of a message are found.
#[derive(Debug)]
pub(super) enum Extractor {
    Cdr(DecodePlan),
    Ros1(DecodePlan),
    Protobuf(Vec<protobuf::ProtoTarget>),
    Json(Vec<String>),
}

/// Where in a message of a type stands what is wanted of it; topics of one type share it.
#[derive(Debug)]
pub(super) struct MessageLayout {
    pub(super) extractor: Extractor,
    /// The fields, with their units.
    pub(super) columns: Vec<(String, Option<AccelerationUnit>)>,
    /// Whether a number follows the columns that says whether there is an estimate.
    pub(super) estimate: bool,
    /// Whether a fingerprint of the frame's name follows.
    pub(super) frame: bool,
    /// Whether the two numbers of a stamp come last.
    pub(super) stamped: bool,
}

impl MessageLayout {
    /// Returns how many numbers are taken from a message.
    pub(super) fn slots(&self) -> usize {
        self.columns.len()
            + usize::from(self.estimate)
            + usize::from(self.frame)
            + 2 * usize::from(self.stamped)
    }
}

/// Why a message type has no layout.
#[derive(Debug)]
pub(super) enum Unfit {
    /// It lacks the field at this path; those it has are listed.
    NoField(String, Vec<String>),
    /// Several of its fields could be meant.
    Ambiguous(Vec<String>),
    /// It cannot be read.
    Other(Error),
}

impl From<Error> for Unfit {
    fn from(error: Error) -> Self {
        Self::Other(error)
    }
}

impl Unfit {
    /// Returns the error that this is for a topic.
    pub(super) fn of(&self, topic: &str) -> Error {
        match self {
            Self::NoField(path, known) => no_field(topic, path, known),
            Self::Ambiguous(paths) => ErrorKind::AmbiguousChannel {
                candidates: Candidates::named(paths.iter().map(|path| name_of(topic, path))),
            }
            .into(),
            Self::Other(error) => error.clone(),
        }
    }
}

/// The layout of a type's messages, or why there is none.
pub(super) type Laid = Result<Rc<MessageLayout>, Rc<Unfit>>;

/// Finds what is wanted of the messages of a type that has a schema.
///
/// # Errors
///
/// [`ErrorKind::LimitExceeded`] once `budget` is spent.
pub(super) fn layout(
    encoding: &str,
    schema: Option<&Schema>,
    wanted: &WantedFields,
    budget: &mut Budget,
) -> Result<Laid, Error> {
    let layout = match encoding {
        "protobuf" => protobuf_layout(schema, wanted, budget),
        _ => ros_layout(encoding, schema, wanted, budget),
    };
    match layout {
        Err(Unfit::Other(error)) if matches!(error.kind(), ErrorKind::LimitExceeded { .. }) => {
            Err(error)
        }
        other => Ok(other.map(Rc::new).map_err(Rc::new)),
    }
}

fn ros_layout(
    encoding: &str,
    schema: Option<&Schema>,
    wanted: &WantedFields,
    budget: &mut Budget,
) -> Result<MessageLayout, Unfit> {
    refuse_encoding(encoding)?;
    let Some(schema) = schema else {
        return Err(refused(
            "a schema for the topic's messages",
            "none: the topic is without schema",
        )
        .into());
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
        )
        .into());
    };
    let definitions = ros_definitions(schema, dialect)?;
    let numbers = definitions.numbers(budget)?;
    let floats = numbers
        .iter()
        .filter(|(path, number)| number.is_float() && !path.contains('['))
        .map(|(path, _)| path.clone())
        .collect();
    let known: Vec<String> = numbers.into_iter().map(|(path, _)| path).collect();
    let paths = wanted_paths(&schema.name, wanted, floats, &known)?;
    let mut columns = Vec::new();
    for path in &paths {
        let Some(target) = definitions.target(path) else {
            return Err(Unfit::NoField(path.clone(), listed(&known)));
        };
        columns.push((path.clone(), target.unit.or_else(|| unit_in_name(path))));
    }
    let (stamp, kinds) = match dialect {
        Dialect::Ros2 => (STAMP, [Number::I32, Number::U32]),
        Dialect::Ros1 => (ROS1_STAMP, [Number::U32, Number::U32]),
    };
    let found = stamp.map(|path| definitions.target(path).map(|target| target.number));
    let stamped = found == kinds.map(Some);
    let estimate = asks_for_estimate(&paths) && definitions.target(ESTIMATE).is_some();
    let [header, frame_id] = FRAME;
    let frame = definitions.has_text(header, frame_id);
    let frame_path = FRAME.join(".");
    let mut all: Vec<&str> = paths.iter().map(String::as_str).collect();
    all.extend(estimate.then_some(ESTIMATE));
    all.extend(frame.then_some(frame_path.as_str()));
    if stamped {
        all.extend(stamp);
    }
    let plan = definitions.plan(&all, budget)?;
    Ok(MessageLayout {
        extractor: match dialect {
            Dialect::Ros2 => Extractor::Cdr(plan),
            Dialect::Ros1 => Extractor::Ros1(plan),
        },
        columns,
        estimate,
        frame,
        stamped,
    })
}

fn protobuf_layout(
    schema: Option<&Schema>,
    wanted: &WantedFields,
    budget: &mut Budget,
) -> Result<MessageLayout, Unfit> {
    let Some(schema) = schema else {
        return Err(refused(
            "a schema for the topic's messages",
            "none: the topic is without schema",
        )
        .into());
    };
    if schema.encoding != "protobuf" {
        return Err(refused(
            "a schema in the protobuf encoding",
            &format!("`{}`", schema.encoding),
        )
        .into());
    }
    let descriptor = protobuf::Descriptor::read(&schema.name, &schema.data)?;
    let numbers = descriptor.numbers(budget)?;
    let floats = numbers
        .iter()
        .filter(|(path, is_float)| *is_float && !path.contains('['))
        .map(|(path, _)| path.clone())
        .collect();
    let known: Vec<String> = numbers.into_iter().map(|(path, _)| path).collect();
    let paths = wanted_paths(&schema.name, wanted, floats, &known)?;
    let (mut columns, mut targets) = (Vec::new(), Vec::new());
    for path in &paths {
        let Some(target) = descriptor.target(path) else {
            return Err(Unfit::NoField(path.clone(), listed(&known)));
        };
        // The types of ROS keep their units when they travel as protobuf.
        let of_type = lateral_path(&schema.name).filter(|lateral| {
            path.trim_end_matches(['x', 'y', 'z']) == lateral.trim_end_matches('y')
        });
        let unit = of_type.map(|_| AccelerationUnit::MetrePerSecondSquared);
        columns.push((path.clone(), unit.or_else(|| unit_in_name(path))));
        targets.push(target);
    }
    let estimate = descriptor
        .target(ESTIMATE)
        .filter(|_| asks_for_estimate(&paths));
    let estimated = estimate.is_some();
    targets.extend(estimate.map(protobuf::ProtoTarget::or_zero));
    let stamp = descriptor.stamp();
    let stamped = stamp.is_some();
    targets.extend(stamp.into_iter().flatten());
    Ok(MessageLayout {
        extractor: Extractor::Protobuf(targets),
        columns,
        estimate: estimated,
        frame: false,
        stamped,
    })
}

/// Tells whether what is wanted is what an Imu's covariance may deny.
fn asks_for_estimate(paths: &[String]) -> bool {
    paths
        .iter()
        .any(|path| path.starts_with("linear_acceleration."))
}

/// Returns the paths of the fields that are wanted of a message type.
fn wanted_paths(
    schema_name: &str,
    wanted: &WantedFields,
    mut floats: Vec<String>,
    known: &[String],
) -> Result<Vec<String>, Unfit> {
    let paths = match wanted {
        WantedFields::Path(path) => vec![path.clone()],
        WantedFields::Every => {
            // Those that could be meant are shown however many come before them.
            let mut place = 0;
            floats.retain(|path| {
                place += 1;
                place <= LISTED || names_lateral(path)
            });
            floats
        }
        WantedFields::Lateral => match lateral_path(schema_name) {
            Some(path) => vec![path.to_string()],
            None => primary(
                floats
                    .into_iter()
                    .filter(|path| says_lateral(path))
                    .collect(),
            ),
        },
    };
    match (wanted, paths.as_slice()) {
        (_, []) => Err(Unfit::NoField(String::new(), listed(known))),
        (WantedFields::Lateral, [_, _, ..]) => Err(Unfit::Ambiguous(paths)),
        _ => Ok(paths),
    }
}

/// Leaves redundant sensors out where there is a primary one.
fn primary(paths: Vec<String>) -> Vec<String> {
    let is_primary = |path: &String| !named(path).says_redundant();
    if paths.iter().any(is_primary) {
        paths.into_iter().filter(is_primary).collect()
    } else {
        paths
    }
}

/// Returns the first names of a list for a message.
fn listed(known: &[String]) -> Vec<String> {
    known.iter().take(LISTED).cloned().collect()
}

/// Returns which of a message's numbers are wanted.
fn json_fields(numbers: &[String], wanted: &WantedFields) -> Result<Vec<String>, Unfit> {
    let has = |path: &str| numbers.iter().any(|known| known == path);
    let lateral = || LATERAL.iter().map(|(_, path)| *path);
    match wanted {
        WantedFields::Path(path) if has(path) => Ok(vec![path.clone()]),
        WantedFields::Path(path) => Err(Unfit::NoField(path.clone(), listed(numbers))),
        WantedFields::Lateral => {
            let mut found: Vec<String> = lateral()
                .filter(|path| has(path))
                .map(str::to_string)
                .collect();
            let of_type = |path: &str| found.iter().any(|known| known == path);
            let named: Vec<String> = numbers
                .iter()
                .filter(|path| says_lateral(path) && !of_type(path))
                .cloned()
                .collect();
            found.extend(primary(named));
            if found.len() > 1 {
                return Err(Unfit::Ambiguous(found));
            }
            Ok(found)
        }
        WantedFields::Every => {
            let bases = lateral()
                .filter(|path| has(path))
                .map(|path| path.trim_end_matches('y'));
            let triples: Vec<String> = bases
                .flat_map(|base| ["x", "y", "z"].map(|axis| format!("{base}{axis}")))
                .filter(|path| has(path))
                .collect();
            let named = |path: &&String| names_lateral(path) && !triples.contains(path);
            if numbers.iter().any(|path| named(&path)) {
                let data = |path: &&String| {
                    !JSON_STAMPS.as_flattened().contains(&path.as_str()) && *path != ESTIMATE
                };
                Ok(numbers.iter().filter(data).cloned().collect())
            } else {
                Ok(triples)
            }
        }
    }
}

/// Learns the fields of a JSON topic from its first message.
///
/// Returns with it the paths whose names were looked at.
pub(super) fn json_layout(
    data: &[u8],
    wanted: &WantedFields,
) -> Result<(MessageLayout, BTreeSet<String>), Unfit> {
    let mut numbers: Vec<String> = Vec::new();
    let mut known = 0_usize;
    let mut frame = false;
    let frame_path = FRAME.join(".");
    let mut looked_at: BTreeSet<String> = BTreeSet::new();
    let lateral: Vec<&str> = LATERAL.iter().map(|(_, path)| *path).collect();
    let mut found = |path: &str, leaf: Leaf| {
        frame |= path == frame_path && matches!(leaf, Leaf::Text(_));
        let base = path.strip_suffix(['x', 'y', 'z']);
        let needed = JSON_STAMPS.as_flattened().contains(&path)
            || path == ESTIMATE
            || matches!(wanted, WantedFields::Path(wanted) if wanted == path)
            || lateral
                .iter()
                .any(|lateral| lateral.strip_suffix('y') == base);
        // What is null now may be a number in the next message.
        let numeric = matches!(leaf, Leaf::Number(_) | Leaf::Null);
        let single = numeric && !path.contains('[');
        let told = single && looked_at.len() <= FIELDS && looked_at.insert(path.to_string());
        let listed = matches!(leaf, Leaf::Number(_)) && known < LISTED;
        known += usize::from(listed);
        if (needed || listed || (told && names_lateral(path)))
            && !numbers.iter().any(|known| known == path)
        {
            numbers.push(path.to_string());
        }
    };
    json::walk(data, &mut found).map_err(|reason| damaged_message("a JSON message", &reason))?;
    if looked_at.len() > FIELDS {
        return Err(too_many_fields().into());
    }
    let has = |path: &str| numbers.iter().any(|known| known == path);
    let chosen = json_fields(&numbers, wanted)?;
    if chosen.is_empty() {
        return Err(Unfit::NoField(String::new(), listed(&numbers)));
    }
    let estimate = asks_for_estimate(&chosen) && has(ESTIMATE);
    let stamp = JSON_STAMPS
        .into_iter()
        .find(|stamp| stamp.iter().all(|path| has(path)));
    let columns = chosen
        .iter()
        .map(|path| (path.clone(), unit_in_name(path)))
        .collect();
    let mut paths = chosen;
    paths.extend(estimate.then(|| ESTIMATE.to_string()));
    paths.extend(frame.then_some(frame_path));
    paths.extend(stamp.into_iter().flatten().map(String::from));
    let layout = MessageLayout {
        extractor: Extractor::Json(paths),
        columns,
        estimate,
        frame,
        stamped: stamp.is_some(),
    };
    Ok((layout, looked_at))
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

/// Refuses a message encoding that is not read, by its name.
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

fn no_field(topic: &str, path: &str, known: &[String]) -> Error {
    let mut names: Vec<String> = known
        .iter()
        .take(LISTED)
        .map(|path| name_of(topic, path))
        .collect();
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

pub(super) fn damaged_message(expected: &str, found: &str) -> Error {
    ErrorKind::Malformed {
        expected: expected.to_string(),
        found: found.to_string(),
        hint: "the message and its schema contradict one another; record it again".into(),
    }
    .into()
}

/// Returns a channel's name.
pub(super) fn name_of(topic: &str, path: &str) -> String {
    if path.is_empty() {
        topic.to_string()
    } else {
        format!("{topic}:{path}")
    }
}
