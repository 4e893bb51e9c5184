//! The words of a gate file: recordings, designs and required answers.
//!
//! Tables and keys are read one by one, so that one run reports every error, each with its line.
//! Files and designs are looked up by `plan`.

use crate::pipeline::{Answer, Limits, Request};
use latchgate_recording::error::{Error, ErrorKind, Place, with_article};
use latchgate_verdict::statics::{Door, Standard};
use serde_json::Value;
use std::collections::BTreeMap;

/// A gate file as it is written. Patterns are not yet looked up, design files not yet read.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GateFile {
    /// Recordings that are judged.
    pub recordings: Vec<RecordingsEntry>,
    /// Levers with which they are judged.
    pub designs: Vec<DesignEntry>,
    /// Required answers; the last entry that matches a pair counts, a pass where none does.
    pub require: Vec<Requirement>,
    /// Undecided pairs that are let through for a time.
    pub allow: Vec<Exception>,
    /// Static load that every design is to hold.
    pub require_static: Option<StaticRequirement>,
}

/// A static load, and who asks for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StaticRequirement {
    /// The load [g].
    pub load_g: f64,
    /// The standard whose directions count.
    pub standard: Standard,
    /// The door that the latches hold.
    pub door: Door,
}

impl StaticRequirement {
    /// Reads a load, or a table of `g`, `standard` and `door`; names what is none of them.
    fn of(value: &toml::Value) -> Result<Self, String> {
        let number = |value: &toml::Value| {
            let level = value
                .as_float()
                .or(value.as_integer().map(|level| level as f64));
            let level = level.filter(|level| level.is_finite() && *level > 0.0);
            level.ok_or_else(|| shown(value))
        };
        let Some(table) = value.as_table() else {
            return Ok(Self {
                load_g: number(value)?,
                standard: Standard::SaeJ839,
                door: Door::default(),
            });
        };
        let known = ["g", "standard", "door"];
        if let Some(key) = table.keys().find(|key| !known.contains(&key.as_str())) {
            return Err(format!("the key `{key}`"));
        }
        let word = |key: &str| {
            let text = table.get(key).ok_or_else(|| format!("no `{key}`"))?;
            let word = text
                .as_str()
                .ok_or_else(|| format!("{} for `{key}`", shown(text)))?;
            Ok::<_, String>(word.to_ascii_lowercase())
        };
        let load_g = number(table.get("g").ok_or("no `g`")?)?;
        let standard = word("standard")?;
        let of_word = Standard::ALL.into_iter().find(|own| own.word() == standard);
        let standard = of_word.ok_or_else(|| format!("the standard `{standard}`"))?;
        let door = match table.contains_key("door") {
            true => {
                let door = word("door")?;
                let of_word = Door::ALL.into_iter().find(|own| own.word() == door);
                of_word.ok_or_else(|| format!("the door `{door}`"))?
            }
            false => Door::default(),
        };
        Ok(Self {
            load_g,
            standard,
            door,
        })
    }
}

/// Returns a number or text as it is written, of anything else its type.
fn shown(value: &toml::Value) -> String {
    match value {
        toml::Value::Integer(number) => format!("`{number}`"),
        toml::Value::Float(number) => format!("`{number}`"),
        toml::Value::String(text) => format!("`{text}`"),
        other => with_article(other.type_str()),
    }
}

/// Recordings that share their settings.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingsEntry {
    /// Position of the entry in the gate file.
    pub place: Place,
    /// Paths or patterns, relative to the gate file's folder.
    pub files: Vec<String>,
    /// Settings of reading, conditioning and judging.
    pub request: Request,
}

/// A lever.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignEntry {
    /// Position of the entry in the gate file.
    pub place: Place,
    /// Its name; that of the design file where none is given.
    pub name: Option<String>,
    /// Design file, relative to the gate file's folder; the paper's lever where none is named.
    pub file: Option<String>,
    /// Overrides, `key=value`.
    pub set: Vec<String>,
}

/// The required answer of the pairs that match.
#[derive(Debug, Clone, PartialEq)]
pub struct Requirement {
    /// Position of the entry in the gate file.
    pub place: Place,
    /// Pattern of the recordings' names.
    pub recordings: String,
    /// Pattern of the designs' names.
    pub designs: String,
    /// The answer that is required: pass or fail.
    pub verdict: Answer,
}

/// An undecided pair that is let through for a time.
#[derive(Debug, Clone, PartialEq)]
pub struct Exception {
    /// Position of the entry in the gate file.
    pub place: Place,
    /// Pattern of the recordings' names.
    pub recordings: String,
    /// Pattern of the designs' names.
    pub designs: String,
    /// Reason for the exception.
    pub reason: String,
    /// Last day on which it holds, `YYYY-MM-DD`.
    pub until: String,
}

/// The tables of a gate file.
pub(super) const TABLES: [&str; 4] = ["recordings", "designs", "require", "allow"];

/// The key of the static load that every design is to hold.
pub(super) const REQUIRE_STATIC: &str = "require_static_g";

/// The keys of `[[recordings]]` beside the settings of a replay.
pub(super) const FILES: &str = "files";

/// The keys of `[[designs]]`.
pub(super) const DESIGN_KEYS: [&str; 3] = ["name", "file", "set"];

/// The keys of `[[require]]`.
pub(super) const REQUIRE_KEYS: [&str; 3] = ["recordings", "designs", "verdict"];

/// The keys of `[[allow]]`.
pub(super) const ALLOW_KEYS: [&str; 4] = ["recordings", "designs", "reason", "until"];

/// Largest number of errors reported of a gate file: longer lists are not read.
pub const ERRORS_MAX: usize = 20;

impl GateFile {
    /// Reads a gate file from its TOML text; errors carry `name`.
    ///
    /// # Errors
    ///
    /// All errors of the file, [`ERRORS_MAX`] at most, each at its line: [`ErrorKind::Malformed`] where the text
    /// is no TOML or a value of the wrong type, [`ErrorKind::UnknownName`] for an unknown key with
    /// the nearest known one, [`ErrorKind::BadSetting`] for a setting with a value that it does not
    /// take.
    pub fn from_toml(name: &str, text: &str, limits: &Limits) -> Result<Self, Vec<Error>> {
        let table: toml::Table = toml::from_str(text).map_err(|error: toml::de::Error| {
            let hint = match error.message() {
                // A key and tables of the same name, which TOML does not allow.
                message if message.contains("duplicate key") => {
                    "write each key of a table once; for all pairs, put a [[require]] with only \
                     its `verdict` before the others"
                }
                _ => "write tables such as [[recordings]] and [[designs]]",
            };
            let error = Error::malformed("TOML", error.message(), hint)
                .at(Place::of_span(text, error.span()))
                .at(Place::file(name));
            vec![error]
        })?;
        let mut reading = FileReading {
            file: name,
            text,
            heads: heads(text),
            errors: Vec::new(),
        };
        let gate = reading.gate(table, limits);
        if reading.errors.is_empty() {
            Ok(gate)
        } else {
            Err(reading.errors)
        }
    }
}

/// A reading that goes on after an error, so that one run reports all of them.
struct FileReading<'a> {
    file: &'a str,
    text: &'a str,
    /// The lines on which the tables of each array begin.
    heads: BTreeMap<&'static str, Vec<u64>>,
    errors: Vec<Error>,
}

/// Finds the lines on which the tables of each array begin.
fn heads(text: &str) -> BTreeMap<&'static str, Vec<u64>> {
    let mut heads: BTreeMap<&'static str, Vec<u64>> = BTreeMap::new();
    for (line, number) in text.lines().zip(1..) {
        let Some(head) = line.trim_start().strip_prefix("[[") else {
            continue;
        };
        let head = head.split(']').next().unwrap_or_default();
        if let Some(kind) = TABLES.into_iter().find(|kind| *kind == head.trim()) {
            heads.entry(kind).or_default().push(number);
        }
    }
    heads
}

impl FileReading<'_> {
    fn gate(&mut self, table: toml::Table, limits: &Limits) -> GateFile {
        let mut gate = GateFile::default();
        for (key, value) in table {
            if self.errors.len() >= ERRORS_MAX {
                break;
            }
            match (key.as_str(), value) {
                ("require", toml::Value::String(word)) => {
                    let place = self.place_of("require", None);
                    match required_answer(&word) {
                        Ok(verdict) => gate.require.push(Requirement {
                            place,
                            recordings: "**".into(),
                            designs: "*".into(),
                            verdict,
                        }),
                        Err(error) => self.errors.push(error.at(place)),
                    }
                }
                (REQUIRE_STATIC, value) => match StaticRequirement::of(&value) {
                    Ok(required) => gate.require_static = Some(required),
                    Err(found) => {
                        let place = self.place_of(REQUIRE_STATIC, None);
                        let error = Error::malformed(
                            "a load in g, above 0, alone or with a standard, 206, r11 or j839, and a door, hinged, sliding or back",
                            found,
                            "write require_static_g = 30, or { g = 30, standard = \"206\", door = \"hinged\" }",
                        );
                        self.errors.push(error.at(place));
                    }
                },
                (kind, value) if TABLES.contains(&kind) => {
                    for (number, entry) in self.entries(kind, value) {
                        if self.errors.len() >= ERRORS_MAX {
                            break;
                        }
                        let place = self.place_of(kind, Some(number));
                        if let Err(error) = add_entry(&mut gate, kind, entry, &place, limits) {
                            self.errors.push(error.at(place));
                        }
                    }
                }
                (key, _) => {
                    let place = self.place_of(key, None);
                    let valid_keys = [&TABLES[..], &[REQUIRE_STATIC]].concat();
                    self.errors.push(unknown(key, &valid_keys).at(place));
                }
            }
        }
        gate
    }

    /// Returns the tables of an array with their numbers.
    fn entries(&mut self, kind: &str, value: toml::Value) -> Vec<(usize, toml::Table)> {
        let list = match value {
            toml::Value::Array(list) => list,
            other => {
                let place = self.place_of(kind, None);
                self.errors.push(not_tables(kind, &other).at(place));
                return Vec::new();
            }
        };
        let mut tables = Vec::new();
        for (number, entry) in list.into_iter().enumerate() {
            match entry {
                toml::Value::Table(table) => tables.push((number, table)),
                other => {
                    let place = self.place_of(kind, Some(number));
                    self.errors.push(not_tables(kind, &other).at(place));
                    break;
                }
            }
        }
        tables
    }

    /// Finds the line of a key, or of the numbered table of an array.
    fn place_of(&self, key: &str, number: Option<usize>) -> Place {
        let head = number.and_then(|number| self.heads.get(key)?.get(number));
        if let Some(line) = head {
            return Place::file(self.file).line(*line);
        }
        let is_assignment = |line: &str| {
            let value = line.strip_prefix(key);
            value.is_some_and(|value| value.trim_start().starts_with('='))
        };
        let mut lines = self.text.lines().map(str::trim_start);
        let head = format!("[{key}]");
        let index = lines.position(|line| is_assignment(line) || line.starts_with(&head));
        let place = Place::file(self.file);
        match index {
            Some(index) => place.line(index as u64 + 1),
            None => place,
        }
    }
}

fn not_tables(kind: &str, found: &toml::Value) -> Error {
    let expected = match kind {
        "require" => "\"pass\", \"fail\" or [[require]] tables".to_string(),
        _ => format!("[[{kind}]] tables"),
    };
    Error::malformed(
        &expected,
        with_article(found.type_str()),
        "correct the gate file",
    )
}

/// Adds the entry of one table.
fn add_entry(
    gate: &mut GateFile,
    kind: &str,
    table: toml::Table,
    place: &Place,
    limits: &Limits,
) -> Result<(), Error> {
    let place = place.clone();
    match kind {
        "recordings" => gate.recordings.push(recordings(table, place, limits)?),
        "designs" => gate.designs.push(design(table, place)?),
        "require" => {
            let mut table = Entry::new(table, &REQUIRE_KEYS)?;
            gate.require.push(Requirement {
                place,
                recordings: table.text("recordings")?.unwrap_or_else(|| "**".into()),
                designs: table.text("designs")?.unwrap_or_else(|| "*".into()),
                verdict: required_answer(&table.required_text("verdict")?)?,
            });
        }
        _ => {
            let mut table = Entry::new(table, &ALLOW_KEYS)?;
            let until = table.date("until")?;
            let reason = table.required_text("reason")?;
            if reason.trim().is_empty() {
                return Err(Error::malformed(
                    "a `reason`",
                    "none",
                    "state why the pair is let through",
                ));
            }
            gate.allow.push(Exception {
                place,
                recordings: table.required_text("recordings")?,
                designs: table.required_text("designs")?,
                reason,
                until,
            });
        }
    }
    Ok(())
}

fn recordings(
    mut table: toml::Table,
    place: Place,
    limits: &Limits,
) -> Result<RecordingsEntry, Error> {
    let files = table
        .remove(FILES)
        .ok_or_else(|| {
            Error::malformed(
                "`files`",
                "none",
                "name paths or patterns: files = [\"*.csv\"]",
            )
        })
        .and_then(|value| texts(FILES, value))?;
    let settings: BTreeMap<String, Value> = table
        .into_iter()
        .map(|(key, value)| (key, serde_json::to_value(value).unwrap_or(Value::Null)))
        .collect();
    let request = Request::from_entries(settings).map_err(|error| match error.kind() {
        // The request does not know `files`, which is a key of a gate file.
        ErrorKind::UnknownName { found, known, .. } => {
            let keys: Vec<&str> = std::iter::once(FILES).chain(known.split(", ")).collect();
            unknown(found, &keys)
        }
        _ => error,
    })?;
    request.check()?;
    request.limits(limits)?;
    Ok(RecordingsEntry {
        place,
        files,
        request,
    })
}

fn design(table: toml::Table, place: Place) -> Result<DesignEntry, Error> {
    let mut table = Entry::new(table, &DESIGN_KEYS)?;
    let name = table.text("name")?;
    if name.as_deref().is_some_and(|name| name.trim().is_empty()) {
        let hint = "name the design, or leave `name` out";
        return Err(Error::malformed("a `name`", "none", hint));
    }
    Ok(DesignEntry {
        place,
        name,
        file: table.text("file")?,
        set: table.overrides("set")?,
    })
}

/// A table of which the keys are known.
struct Entry(toml::Table);

impl Entry {
    fn new(table: toml::Table, known: &[&str]) -> Result<Self, Error> {
        match table.keys().find(|key| !known.contains(&key.as_str())) {
            Some(key) => Err(unknown(key, known)),
            None => Ok(Self(table)),
        }
    }

    fn text(&mut self, key: &str) -> Result<Option<String>, Error> {
        match self.0.remove(key) {
            None => Ok(None),
            Some(toml::Value::String(text)) => Ok(Some(text)),
            Some(other) => Err(wrong(key, "a text in quotes", &other)),
        }
    }

    fn required_text(&mut self, key: &str) -> Result<String, Error> {
        self.text(key)?
            .ok_or_else(|| Error::malformed(format!("`{key}`"), "none", "add it to the table"))
    }

    /// A day, as a TOML date or as a text.
    fn date(&mut self, key: &str) -> Result<String, Error> {
        let expected = "a day such as 2027-03-31";
        let text = match self.0.remove(key) {
            Some(toml::Value::Datetime(date)) => date.to_string(),
            Some(toml::Value::String(text)) => text,
            Some(other) => return Err(wrong(key, expected, &other)),
            None => {
                return Err(Error::malformed("`until`", "none", "state its last day"));
            }
        };
        if is_day(&text) {
            Ok(text)
        } else {
            Err(wrong(key, expected, &toml::Value::String(text)))
        }
    }

    /// Overrides of a design: a list of `key=value`, or a table of keys and values.
    fn overrides(&mut self, key: &str) -> Result<Vec<String>, Error> {
        match self.0.remove(key) {
            None => Ok(Vec::new()),
            Some(toml::Value::Table(table)) => {
                let mut assignments = Vec::new();
                flatten("", table, &mut assignments)?;
                Ok(assignments)
            }
            Some(list) => texts(key, list),
        }
    }
}

/// Writes a table of design keys, dotted or nested, as `key=value`.
fn flatten(prefix: &str, table: toml::Table, assignments: &mut Vec<String>) -> Result<(), Error> {
    for (key, value) in table {
        let name = format!("{prefix}{key}");
        match value {
            toml::Value::Table(inner) => flatten(&format!("{name}."), inner, assignments)?,
            toml::Value::Integer(number) => assignments.push(format!("{name}={number}")),
            toml::Value::Float(number) => assignments.push(format!("{name}={number}")),
            toml::Value::String(share)
                if name.starts_with("tolerance.") && share.trim_end().ends_with('%') =>
            {
                assignments.push(format!("{name}={share}"));
            }
            other => {
                let expected = match name.starts_with("tolerance.") {
                    true => "a number without quotes, or a share such as \"5 %\"",
                    false => "a number without quotes",
                };
                return Err(wrong(&name, expected, &other));
            }
        }
    }
    Ok(())
}

fn texts(key: &str, value: toml::Value) -> Result<Vec<String>, Error> {
    let expected = "a text, or a list of texts";
    match value {
        toml::Value::String(text) => Ok(vec![text]),
        toml::Value::Array(list) if !list.is_empty() => list
            .into_iter()
            .map(|item| match item {
                toml::Value::String(text) => Ok(text),
                other => Err(wrong(key, expected, &other)),
            })
            .collect(),
        other => Err(wrong(key, expected, &other)),
    }
}

fn required_answer(word: &str) -> Result<Answer, Error> {
    match word {
        "pass" => Ok(Answer::Pass),
        "fail" => Ok(Answer::Fail),
        other => Err(Error::unknown("required verdict", other, &["pass", "fail"])),
    }
}

/// True if a text is a day of the calendar, written as `YYYY-MM-DD`.
pub fn is_day(text: &str) -> bool {
    let date = text.parse::<toml::value::Datetime>();
    date.is_ok_and(|date| date.date.is_some() && date.time.is_none())
}

fn wrong(key: &str, expected: &str, value: &toml::Value) -> Error {
    let found = match value {
        toml::Value::String(text) => format!("\"{text}\""),
        other => with_article(other.type_str()),
    };
    Error::malformed(
        format!("`{key}` to be {expected}"),
        &found,
        "correct the gate file",
    )
}

fn unknown(key: &str, known: &[&str]) -> Error {
    Error::unknown("key", key, known)
}
