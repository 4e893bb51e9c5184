//! Pulses by formula, in place of a recording: `pulse:half-sine,peak=30g,duration=11ms`.
//!
//! The text is the recording: its canonical form, defaults written out, is hashed and kept. The clock has a
//! sample at every vertex, and the channel carries the formula's own values between samples.
//!
//! # Source
//!
//! Half-sine, sawtooth and trapezoid: shapes of IEC 60068-2-27. The named pulses: `words/named-pulses.txt`.

use super::card::CardPolarity;
use super::source::{Reader, Source};
use super::words::{Words, word_list};
use super::{
    Channel, ExactPulse, Finding, Head, Outcomes, ReadOutcome, ReadTask, Stated, read_within,
};
use crate::error::{Error, ErrorKind, Place};
use crate::setting::Setting;
use latchgate_kernel::pulse::{Pulse, Vertex};
use latchgate_kernel::units::{AccelerationUnit, SampleRate, TimeUnit};
use std::path::Path;

/// Prefix of the word of a pulse.
pub use super::source::PULSE_PREFIX as PREFIX;

/// Longest sample interval that is chosen, that of 20 kHz [ns].
const INTERVAL_MAX_NS: u64 = 50_000;

/// Fewest intervals of a curved pulse at a chosen rate.
const CURVED_INTERVALS: u64 = 400;

/// Fewest intervals of a curved pulse at a stated rate.
const CURVED_INTERVALS_MIN: u64 = 200;

/// Time without acceleration after a pulse [ns]: a lever that the pulse pushed may still cross the limit.
const TAIL_NS: u64 = 200_000_000;

/// Samples of a pulse with its tail, at most.
const SAMPLES_MAX: u64 = 1_000_000;

/// Vertices of a polyline, at most.
const VERTICES_MAX: usize = 200;

/// Times of a pulse, at most [ns].
const TIME_MAX_NS: u64 = 100_000_000_000;

/// Bytes of a file of vertices, at most.
const VERTICES_BYTES: (&str, u64) = ("vertices_bytes", 64 << 10);

/// Named pulses: name, `verified` if the points were compared with the source, points in ms and a unit.
static NAMED: Words = word_list!("named-pulses");

/// True if the text of a recording is the word of a pulse.
pub fn recognises(head: &Head<'_>) -> bool {
    head.bytes.starts_with(PREFIX.as_bytes())
}

/// Returns the canonical form of a word, defaults written out, with the points of the file that it names
/// below `folder`.
///
/// # Errors
///
/// [`ErrorKind::Malformed`] and [`ErrorKind::UnknownName`] for what is no pulse; those of
/// [`read_within`] for a file of points, which a word without a `folder` may not name.
///
/// # Examples
///
/// ```
/// use latchgate_recording::pulse::canonical;
///
/// let word = canonical("pulse:half-sine,peak=30g,duration=0.011s", None)?;
/// assert_eq!(word, "pulse:half-sine,peak=30g,duration=11ms,rate=36363.63636363636Hz,tail=200ms,opens-when=both");
/// assert_eq!(canonical(&word, None)?, word);
/// # Ok::<(), latchgate_recording::error::Error>(())
/// ```
pub fn canonical(word: &str, folder: Option<&Path>) -> Result<String, Error> {
    let parsed = PulseWord::parse(word, folder).map_err(|error| error.at(Place::file(word)))?;
    Ok(parsed.text())
}

/// Returns the source of a path: a file or folder, or a pulse by its word.
///
/// # Errors
///
/// Those of a file of points that the word names. A word that is wrong is refused where it is read.
pub fn source_at(path: &Path) -> Result<Source, Error> {
    let Some(word) = path.to_str().filter(|word| word.starts_with(PREFIX)) else {
        return Ok(Source::File(path.into()));
    };
    let text = match canonical(word, Some(Path::new(""))) {
        Err(error) if word.contains(",file=") => return Err(error),
        text => text.unwrap_or_else(|_| word.into()),
    };
    Ok(Source::bytes(text.clone(), text.into_bytes()))
}

/// Reads a pulse.
///
/// # Errors
///
/// As [`canonical`]; [`ErrorKind::Malformed`] for settings that the word states itself.
pub fn read(source: &mut Reader, task: ReadTask) -> Result<Outcomes, Error> {
    let bytes = source.read_all("text_bytes", task.limits.text_bytes)?;
    let text = String::from_utf8_lossy(&bytes);
    let word = PulseWord::parse(text.trim_end(), None)?;
    refuse_settings(task)?;
    let channel = word.channel()?;
    Ok(task.each(|_| {
        Ok(ReadOutcome {
            channels: vec![channel.clone()],
            ..ReadOutcome::default()
        })
    }))
}

/// Refuses settings that a pulse states itself.
fn refuse_settings(task: ReadTask) -> Result<(), Error> {
    let options = task.options;
    let stated = [
        (Setting::Channel, options.channel.is_some()),
        (Setting::TimeColumn, options.time_column.is_some()),
        (Setting::TimeUnit, options.time_unit.is_some()),
        (Setting::RateHz, options.rate_hz.is_some()),
        (Setting::TimeZero, options.time_zero_s.is_some()),
        (Setting::Unit, options.unit.is_some()),
        (Setting::Sensitivity, options.sensitivity.is_some()),
    ];
    let Some((setting, _)) = stated.into_iter().find(|(_, is_stated)| *is_stated) else {
        return Ok(());
    };
    Err(Error::malformed(
        "a pulse, whose word states unit, rate and time",
        setting.to_string(),
        format!("leave out {setting}"),
    ))
}

/// A vertex in the pulse's own units.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Point {
    time_ns: u64,
    value: f64,
}

/// A shape that peak and duration determine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PlainShape {
    HalfSine,
    Haversine,
    Sawtooth,
    Triangle,
}

/// The shape of a pulse, in its own unit.
#[derive(Debug, Clone, PartialEq)]
enum Shape {
    Plain {
        shape: PlainShape,
        peak: f64,
        duration_ns: u64,
    },
    Trapezoid {
        peak: f64,
        /// Rise, plateau and fall.
        sides_ns: [u64; 3],
    },
    Polyline(Vec<Point>),
}

/// A pulse as its word states it.
#[derive(Debug, Clone, PartialEq)]
struct PulseWord {
    /// Its name; `None` of a pulse by shape.
    named: Option<NamedPulse>,
    shape: Shape,
    unit: AccelerationUnit,
    rate: SampleRate,
    tail_ns: u64,
    opens_when: CardPolarity,
}

/// A line of [`NAMED`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct NamedPulse {
    name: &'static str,
    is_verified: bool,
    word: &'static str,
}

impl NamedPulse {
    fn all() -> impl Iterator<Item = Self> {
        NAMED.iter().filter_map(|line| {
            let (name, columns) = line.split_once('\t')?;
            let (verified, word) = columns.split_once('\t')?;
            let is_verified = verified == "verified";
            Some(Self {
                name,
                is_verified,
                word,
            })
        })
    }
}

impl PlainShape {
    const ALL: [Self; 4] = [
        Self::HalfSine,
        Self::Haversine,
        Self::Sawtooth,
        Self::Triangle,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::HalfSine => "half-sine",
            Self::Haversine => "haversine",
            Self::Sawtooth => "sawtooth",
            Self::Triangle => "triangle",
        }
    }
}

/// The keys of a word; each is removed when it is read.
struct Keys<'a>(Vec<(&'a str, &'a str)>);

impl<'a> Keys<'a> {
    fn parse(text: &'a str) -> Result<Self, Error> {
        let mut keys: Vec<(&str, &str)> = Vec::new();
        for part in text.split(',').filter(|part| !part.is_empty()) {
            let Some((key, value)) = part.split_once('=') else {
                let hint = match key_of(part) {
                    Some(key) => format!("try {key}={part}"),
                    None => "see docs/standards.md".into(),
                };
                return Err(Error::malformed(
                    "KEY=VALUE after the name of a pulse",
                    format!("`{}`", super::text::shown(part)),
                    hint,
                ));
            };
            if keys.iter().any(|(earlier, _)| *earlier == key) {
                return Err(malformed("each key once", part));
            }
            keys.push((key, value));
        }
        Ok(Self(keys))
    }

    fn take(&mut self, key: &str) -> Option<&'a str> {
        let place = self.0.iter().position(|(entry, _)| *entry == key)?;
        Some(self.0.remove(place).1)
    }

    fn needed(&mut self, key: &'static str, example: &str) -> Result<&'a str, Error> {
        if let Some(value) = self.take(key) {
            return Ok(value);
        }
        let is_known = |key: &str| {
            let of_shapes = SHAPES.iter().flat_map(|(_, keys)| keys.iter());
            of_shapes.chain(&COMMON).any(|known| *known == key)
        };
        Err(match self.0.iter().find(|(key, _)| !is_known(key)) {
            Some((other, _)) => Error::unknown("key of this pulse", *other, &[key]),
            None => Error::malformed(
                format!("`{key}` of this pulse"),
                "none",
                format!("add for example {key}={example}"),
            ),
        })
    }

    fn time(&mut self, key: &'static str) -> Result<u64, Error> {
        time_ns(key, self.needed(key, "11ms")?)
    }

    /// Takes the peak with its unit.
    fn peak(&mut self) -> Result<(f64, AccelerationUnit), Error> {
        acceleration(self.needed("peak", "30g")?)
    }

    /// Refuses a key that was not read.
    fn end(self, names: &[&str]) -> Result<(), Error> {
        match self.0.first() {
            Some((key, _)) => Err(Error::unknown("key of this pulse", *key, names)),
            None => Ok(()),
        }
    }
}

/// Keys of every pulse.
const COMMON: [&str; 3] = ["rate", "tail", "opens-when"];

/// Shapes, each with its keys.
const SHAPES: [(&str, &[&str]); 6] = [
    ("half-sine", &["peak", "duration"]),
    ("haversine", &["peak", "duration"]),
    ("sawtooth", &["peak", "duration"]),
    ("triangle", &["peak", "duration"]),
    ("trapezoid", &["peak", "rise", "hold", "fall"]),
    ("polyline", &["points", "unit", "file"]),
];

impl PulseWord {
    fn parse(word: &str, folder: Option<&Path>) -> Result<Self, Error> {
        let Some(text) = word.strip_prefix(PREFIX) else {
            return Err(malformed(
                "the word of a pulse, pulse:SHAPE,KEY=VALUE",
                word,
            ));
        };
        let (name, parameters) = text.split_once(',').unwrap_or((text, ""));
        let mut keys = Keys::parse(parameters)?;
        let named = NamedPulse::all().find(|named| named.name == name);
        let (shape, unit) = match named {
            None => shape(name, &mut keys, folder)?,
            Some(NamedPulse { word, .. }) => {
                let (name, parameters) = word.split_once(',').unwrap_or((word, ""));
                shape(name, &mut Keys::parse(parameters)?, None)?
            }
        };
        let tail_ns = keys
            .take("tail")
            .map_or(Ok(TAIL_NS), |tail| time_or_none("tail", tail))?;
        let opens_when = match keys.take("opens-when") {
            None => CardPolarity::Both,
            Some(name) => CardPolarity::from_name(name)
                .ok_or_else(|| malformed("opens-when=negative|positive|both", name))?,
        };
        let rate = match keys.take("rate") {
            Some(rate) => stated_rate(&shape, rate)?,
            None => chosen_rate(&shape)?,
        };
        let shape_keys = SHAPES.iter().find(|(shape, _)| *shape == name);
        let shape_keys = shape_keys.map_or(&[][..], |(_, keys)| keys);
        keys.end(&[shape_keys, &COMMON].concat())?;
        let pulse = Self {
            named,
            shape,
            unit,
            rate,
            tail_ns,
            opens_when,
        };
        let samples = pulse.pulse().duration_s() * pulse.rate.hertz() + pulse.tail() as f64;
        if samples > SAMPLES_MAX as f64 {
            return Err(malformed(
                &format!("vertices on a clock of at most {SAMPLES_MAX} samples; round the times"),
                &format!("{samples:.0} samples"),
            ));
        }
        Ok(pulse)
    }

    /// Returns the number of intervals of the tail.
    fn tail(&self) -> usize {
        (self.tail_ns as f64 / 1e9 * self.rate.hertz() - 1e-6)
            .ceil()
            .max(0.0) as usize
    }

    /// Returns the canonical form.
    fn text(&self) -> String {
        let unit = self.unit.name();
        let shape = match (&self.named, &self.shape) {
            (Some(named), _) => named.name.into(),
            (
                None,
                Shape::Plain {
                    shape,
                    peak,
                    duration_ns,
                },
            ) => {
                let (name, duration) = (shape.name(), in_ms(*duration_ns));
                format!("{name},peak={peak}{unit},duration={duration}")
            }
            (None, Shape::Trapezoid { peak, sides_ns }) => {
                let [rise, hold, fall] = sides_ns.map(in_ms);
                format!("trapezoid,peak={peak}{unit},rise={rise},hold={hold},fall={fall}")
            }
            (None, Shape::Polyline(points)) => {
                let point =
                    |point: &Point| format!("{}:{}", point.time_ns as f64 / 1e6, point.value);
                let points: Vec<String> = points.iter().map(point).collect();
                format!("polyline,points={},unit={unit}", points.join("/"))
            }
        };
        let (rate, tail) = (self.rate.hertz(), in_ms(self.tail_ns));
        let opens_when = self.opens_when.name();
        format!("{PREFIX}{shape},rate={rate}Hz,tail={tail},opens-when={opens_when}")
    }

    /// Returns the pulse, in its own unit.
    fn pulse(&self) -> Pulse {
        match self.shape {
            Shape::Plain {
                shape,
                peak,
                duration_ns,
            } => {
                let duration_s = seconds(duration_ns);
                match shape {
                    PlainShape::HalfSine => Pulse::HalfSine { peak, duration_s },
                    PlainShape::Haversine => Pulse::Haversine { peak, duration_s },
                    PlainShape::Sawtooth => Pulse::Sawtooth { peak, duration_s },
                    PlainShape::Triangle => Pulse::Triangle { peak, duration_s },
                }
            }
            Shape::Trapezoid { peak, sides_ns } => {
                let [rise_s, plateau_s, fall_s] = sides_ns.map(seconds);
                Pulse::Trapezoid {
                    peak,
                    rise_s,
                    plateau_s,
                    fall_s,
                }
            }
            Shape::Polyline(ref points) => {
                let vertex = |point: &Point| Vertex::new(seconds(point.time_ns), point.value);
                Pulse::Polyline(points.iter().map(vertex).collect())
            }
        }
    }

    fn channel(&self) -> Result<Channel, Error> {
        let reading = self.pulse().reading(self.rate, self.tail())?;
        let is_unverified = self.named.is_some_and(|named| !named.is_verified);
        let finding = Finding::warning(
            "pulse-unverified",
            "The points of this pulse stand from memory. Compare them with the standard's table.",
        );
        Ok(Channel {
            name: "pulse".into(),
            unit: Some(self.unit),
            unit_source: "formula",
            start_s: 0.0,
            rate: self.rate,
            values: reading.signal().samples.clone(),
            stated: Stated::default(),
            findings: Vec::from_iter(is_unverified.then_some(finding)),
            pulse: Some(ExactPulse {
                reading,
                opens_when: self.opens_when,
            }),
        })
    }
}

/// Reads the shape of a name.
fn shape(
    name: &str,
    keys: &mut Keys<'_>,
    folder: Option<&Path>,
) -> Result<(Shape, AccelerationUnit), Error> {
    let plain = PlainShape::ALL
        .into_iter()
        .find(|shape| shape.name() == name);
    if let Some(shape) = plain {
        let (peak, unit) = keys.peak()?;
        let duration_ns = keys.time("duration")?;
        let shape = Shape::Plain {
            shape,
            peak,
            duration_ns,
        };
        return Ok((shape, unit));
    }
    Ok(match name {
        "trapezoid" => {
            let (peak, unit) = keys.peak()?;
            let mut side = |key: &'static str| time_or_none(key, keys.needed(key, "22ms")?);
            let sides_ns = [side("rise")?, side("hold")?, side("fall")?];
            if sides_ns.iter().sum::<u64>() == 0 {
                return Err(malformed("a pulse that takes time", "none"));
            }
            (Shape::Trapezoid { peak, sides_ns }, unit)
        }
        "polyline" => polyline(keys, folder)?,
        name => {
            let shapes = SHAPES.iter().map(|(name, _)| *name);
            let names: Vec<&str> = shapes
                .chain(NamedPulse::all().map(|named| named.name))
                .collect();
            return Err(Error::unknown("pulse", name, &names));
        }
    })
}

fn polyline(
    keys: &mut Keys<'_>,
    folder: Option<&Path>,
) -> Result<(Shape, AccelerationUnit), Error> {
    if let Some(file) = keys.take("file") {
        let Some(folder) = folder else {
            return Err(malformed("the points themselves, points=0:0/22:33", file));
        };
        let bytes = read_within(&folder.join(file), file, "read the points", VERTICES_BYTES)?;
        let text = String::from_utf8_lossy(&bytes);
        let (points, unit) = points_in_table(&text).map_err(|error| error.at(Place::file(file)))?;
        return Ok((Shape::Polyline(points), unit));
    }
    let points = points_of(keys.needed("points", "0:0/22:33/57:33/85:0")?)?;
    let unit = unit_of(keys.needed("unit", "g")?)?;
    Ok((Shape::Polyline(points), unit))
}

/// Reads points `MS:VALUE` between slashes.
fn points_of(text: &str) -> Result<Vec<Point>, Error> {
    let point = |pair: &str| {
        let expected = "points of time [ms] and acceleration, as 0:0/22:33/85:0";
        let (time, value) = pair
            .split_once(':')
            .ok_or_else(|| malformed(expected, pair))?;
        Ok(Point {
            time_ns: whole_ns("points", time, 6)?,
            value: number("points", value)?,
        })
    };
    checked(text.split('/').map(point).collect::<Result<_, Error>>()?)
}

/// Reads a table of points: a line of units, such as `ms,g`, then a time and an acceleration a line.
fn points_in_table(text: &str) -> Result<(Vec<Point>, AccelerationUnit), Error> {
    let mut lines = text
        .lines()
        .map(str::trim)
        .zip(1..)
        .filter(|(line, _)| !line.is_empty());
    let pair = |line: Option<(&str, u64)>, expected: &str| {
        let (line, number) = line.ok_or_else(|| malformed(expected, "no line"))?;
        let pair = line
            .split_once(',')
            .ok_or_else(|| malformed(expected, line));
        let (a, b) = pair.map_err(|error| error.at(Place::default().line(number)))?;
        Ok::<_, Error>((a.trim().to_string(), b.trim().to_string(), number))
    };
    let (time, unit, _) = pair(lines.next(), "a first line of both units, such as ms,g")?;
    let power = match TimeUnit::from_spelling(&time).map(TimeUnit::seconds) {
        Some(unit) if unit.total_cmp(&1.0).is_eq() => 9,
        Some(unit) if unit.total_cmp(&1e-3).is_eq() => 6,
        Some(unit) if unit.total_cmp(&1e-6).is_eq() => 3,
        _ => return Err(malformed("a first line of both units, such as ms,g", &time)),
    };
    let unit = unit_of(&unit)?;
    let mut points = Vec::new();
    for line in lines {
        let (time, value, line) = pair(Some(line), "a time and an acceleration")?;
        let place = |error: Error| error.at(Place::default().line(line));
        points.push(Point {
            time_ns: whole_ns("time", &time, power).map_err(place)?,
            value: number("acceleration", &value).map_err(place)?,
        });
    }
    Ok((checked(points)?, unit))
}

/// Checks the points of a polyline.
fn checked(points: Vec<Point>) -> Result<Vec<Point>, Error> {
    if points.len() < 2 || points.len() > VERTICES_MAX {
        let found = format!("{} points", points.len());
        return Err(malformed(&format!("2 to {VERTICES_MAX} points"), &found));
    }
    let moves = points.iter().any(|point| point.value.abs() > 0.0);
    let later = points
        .windows(2)
        .all(|pair| pair[0].time_ns < pair[1].time_ns);
    let starts_late = points[0].time_ns > 0 && points[0].value.abs() > 0.0;
    if !moves || !later || starts_late {
        let expected =
            "points in order of time that begin at 0, or at a value of 0, and are not all 0";
        return Err(malformed(expected, "others"));
    }
    Ok(points)
}

/// Requirements of a shape on its clock.
struct Grid {
    /// The longest interval at which every vertex falls on a sample [ns].
    common_ns: u64,
    /// Divisor that the number of intervals in `common_ns` must have.
    multiple: u64,
    is_curved: bool,
}

impl Grid {
    fn of(shape: &Shape) -> Self {
        let common = |times: &[u64]| times.iter().copied().fold(0, gcd);
        let (common_ns, multiple, is_curved) = match shape {
            // A triangle has a vertex in its middle.
            Shape::Plain {
                shape: PlainShape::Triangle,
                duration_ns,
                ..
            } => (*duration_ns, 2, false),
            Shape::Plain {
                shape, duration_ns, ..
            } => (*duration_ns, 1, *shape != PlainShape::Sawtooth),
            Shape::Trapezoid { sides_ns, .. } => (common(sides_ns), 1, false),
            Shape::Polyline(points) => {
                let times: Vec<u64> = points.iter().map(|point| point.time_ns).collect();
                (common(&times), 1, false)
            }
        };
        Self {
            common_ns,
            multiple,
            is_curved,
        }
    }
}

/// Returns the lowest rate of at least 20 kHz at which every vertex falls on a sample.
fn chosen_rate(shape: &Shape) -> Result<SampleRate, Error> {
    let grid = Grid::of(shape);
    let fewest = grid
        .common_ns
        .div_ceil(INTERVAL_MAX_NS)
        .max(if grid.is_curved { CURVED_INTERVALS } else { 1 });
    let count = fewest.next_multiple_of(grid.multiple);
    Ok(SampleRate::from_hertz(
        count as f64 * 1e9 / grid.common_ns as f64,
    )?)
}

/// Reads a stated rate, at which every vertex must fall on a sample.
fn stated_rate(shape: &Shape, text: &str) -> Result<SampleRate, Error> {
    let (value, unit) = quantity(text);
    let hertz = match unit {
        "Hz" => number("rate", value)?,
        "kHz" => shifted("rate", value, 3)?,
        _ => return Err(malformed("a rate, such as rate=20kHz", text)),
    };
    let rate = SampleRate::from_hertz(hertz)?;
    let grid = Grid::of(shape);
    let count = seconds(grid.common_ns) * hertz / grid.multiple as f64;
    if count < 0.5 || (count - count.round()).abs() > 1e-7 * count {
        let fitting = chosen_rate(shape)?.hertz();
        let expected = format!("a rate with a sample at every vertex, such as rate={fitting}Hz");
        return Err(malformed(&expected, text));
    }
    if grid.is_curved && count < CURVED_INTERVALS_MIN as f64 {
        let expected = format!(
            "a rate of {} samples a duration, or more",
            CURVED_INTERVALS_MIN
        );
        return Err(malformed(&expected, text));
    }
    Ok(rate)
}

fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Returns the key that a value without one most likely belongs to, by its unit.
fn key_of(value: &str) -> Option<&'static str> {
    let begins_as_number = value.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    match begins_as_number {
        true if value.ends_with('g') || value.ends_with("m/s2") => Some("peak"),
        true if value.ends_with('s') => Some("duration"),
        _ => None,
    }
}

fn malformed(expected: &str, found: &str) -> Error {
    Error::from(ErrorKind::Malformed {
        expected: expected.into(),
        found: format!("`{}`", super::text::shown(found)),
        hint: "see docs/standards.md".into(),
    })
}

fn unit_of(text: &str) -> Result<AccelerationUnit, Error> {
    let units = [
        AccelerationUnit::StandardGravity,
        AccelerationUnit::MetrePerSecondSquared,
    ];
    let unit = units
        .into_iter()
        .find(|unit| unit.name().eq_ignore_ascii_case(text));
    unit.ok_or_else(|| malformed("an acceleration in g or m/s2", text))
}

/// Splits a number and its unit.
fn quantity(text: &str) -> (&str, &str) {
    // The e of an exponent is before a digit or sign; a unit begins with another letter.
    let is_unit =
        |(_, letter): &(usize, char)| letter.is_alphabetic() && !matches!(letter, 'e' | 'E');
    let end = text
        .char_indices()
        .find(is_unit)
        .map_or(text.len(), |(index, _)| index);
    let (number, unit) = text.split_at(end);
    (number.trim_end(), unit)
}

fn acceleration(text: &str) -> Result<(f64, AccelerationUnit), Error> {
    let (value, unit) = quantity(text);
    let value = number("peak", value)?;
    if unit.is_empty() {
        let hint = format!("try peak={text}g or peak={text}m/s2");
        return Err(Error::malformed(
            "peak with its unit",
            format!("`{}`", super::text::shown(text)),
            hint,
        ));
    }
    let unit = unit_of(unit)?;
    if value.abs() > 0.0 {
        Ok((value, unit))
    } else {
        Err(malformed("a peak that is not 0", text))
    }
}

/// Reads a time that is not 0 [ns].
fn time_ns(key: &'static str, text: &str) -> Result<u64, Error> {
    match time_or_none(key, text)? {
        0 => Err(malformed(&format!("{key} of more than 0"), text)),
        time => Ok(time),
    }
}

/// Reads a time [ns].
fn time_or_none(key: &'static str, text: &str) -> Result<u64, Error> {
    let (value, unit) = quantity(text);
    let power = match &*unit.to_ascii_lowercase() {
        "s" => 9,
        "ms" => 6,
        "us" => 3,
        _ if value.parse() == Ok(0.0) && unit.is_empty() => 9,
        "" if number(key, value).is_ok() => {
            let hint = format!("try {key}={text}ms");
            let found = format!("`{}`", super::text::shown(text));
            return Err(Error::malformed(
                format!("{key} in s, ms or us"),
                found,
                hint,
            ));
        }
        _ => return Err(malformed(&format!("{key} in s, ms or us"), text)),
    };
    whole_ns(key, value, power)
}

/// Reads a time in a unit of 10^`power` ns.
fn whole_ns(key: &'static str, text: &str, power: i32) -> Result<u64, Error> {
    let ns = shifted(key, text, power)?;
    if ns < 0.0 || ns > TIME_MAX_NS as f64 || ns.fract().abs() > 0.0 {
        let expected = format!("{key} in whole nanoseconds, from 0 to 100 s");
        return Err(malformed(&expected, text));
    }
    Ok(ns as u64)
}

/// Reads a number times a power of ten, rounded only once.
fn shifted(key: &'static str, text: &str, power: i32) -> Result<f64, Error> {
    let (mantissa, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
    let exponent: i32 = exponent
        .parse()
        .map_err(|_| malformed(&format!("{key} as a number"), text))?;
    number(
        key,
        &format!("{mantissa}e{}", exponent.saturating_add(power)),
    )
}

fn number(key: &'static str, text: &str) -> Result<f64, Error> {
    let value = text.parse().ok().filter(|value: &f64| value.is_finite());
    // A negative zero means a plain one.
    value
        .map(|value| value + 0.0)
        .ok_or_else(|| malformed(&format!("{key} as a number"), text))
}

fn seconds(ns: u64) -> f64 {
    ns as f64 / 1e9
}

fn in_ms(ns: u64) -> String {
    format!("{}ms", ns as f64 / 1e6)
}
