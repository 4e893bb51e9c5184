//! One error for all that reads, judges and reports: what was expected, what was found, where, and what to try.
//!
//! A kind is the fault, a place is its position in the input, and candidates are the choices. All
//! messages are in this file, so that they are worded alike and name settings, never options.

use crate::setting::Setting;
use latchgate_kernel::error::Error as KernelError;
use latchgate_kernel::units::AccelerationUnit;
use std::fmt;
use std::ops::Range;
use std::path::Path;

/// A channel that could be meant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Candidate {
    /// Name under which the recording lists it.
    pub name: String,
    /// Distinction from others of its name, such as `column 2`.
    pub twin: Option<String>,
    /// Value of the setting `channel` for it; `None` if no value singles it out.
    pub setting_value: Option<String>,
    /// Reason why it is not chosen unless it is named: a word of its name, or a missing word.
    pub doubt: Option<String>,
}

impl Candidate {
    /// Returns a channel that its name singles out.
    pub fn named(name: impl Into<String>) -> Self {
        let name = name.into();
        Self {
            setting_value: Some(name.clone()),
            name,
            twin: None,
            doubt: None,
        }
    }

    /// Returns one of several channels of a name, distinguished by its number; `what` is the thing
    /// that is counted.
    pub fn numbered(name: impl Into<String>, what: &str, number: usize) -> Self {
        Self {
            name: name.into(),
            twin: Some(format!("{what} {number}")),
            setting_value: Some(number.to_string()),
            doubt: None,
        }
    }

    /// Adds the reason why it is not chosen unless it is named.
    pub fn doubted(self, doubt: Option<String>) -> Self {
        Self { doubt, ..self }
    }
}

/// Channels that could be meant, in the order of the recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Candidates(pub Vec<Candidate>);

impl Candidates {
    /// Returns channels that their names single out.
    pub fn named<T: Into<String>>(names: impl IntoIterator<Item = T>) -> Self {
        Self(names.into_iter().map(Candidate::named).collect())
    }

    /// Returns the reason for the choice.
    fn why(&self) -> &'static str {
        if self.0.iter().all(|candidate| candidate.doubt.is_some()) {
            "no channel is clearly the lateral acceleration of the struck vehicle's structure; \
             candidates, each with its doubt"
        } else {
            "several channels could be the lateral acceleration"
        }
    }
}

impl fmt::Display for Candidates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const LISTED: usize = 40;
        const LETTERS: usize = 100;
        for (index, candidate) in self.0.iter().take(LISTED).enumerate() {
            let comma = if index == 0 { "" } else { ", " };
            let mut letters = candidate.name.chars();
            let name: String = letters.by_ref().take(LETTERS).collect();
            let cut = if letters.next().is_some() { "…" } else { "" };
            write!(f, "{comma}{name}{cut}")?;
            if let Some(twin) = &candidate.twin {
                write!(f, " ({twin})")?;
            }
            if let Some(doubt) = &candidate.doubt {
                write!(f, " ({doubt})")?;
            }
        }
        match self.0.len() {
            ..=LISTED => Ok(()),
            count => write!(f, ", {} more", count - LISTED),
        }
    }
}

/// Position of a fault in the input; every part is optional.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Place {
    /// File name, `-` for standard input.
    pub file: Option<String>,
    /// Line, counted from 1.
    pub line: Option<u64>,
    /// Column (field of a table), counted from 1.
    pub column: Option<u64>,
    /// Byte offset, counted from 0.
    pub byte: Option<u64>,
    /// Channel name.
    pub channel: Option<String>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut wrote = false;
        if let Some(file) = &self.file {
            write!(f, "{file}")?;
            wrote = true;
        }
        if let Some(line) = self.line {
            write!(f, "{}{line}", if wrote { ":" } else { "line " })?;
            wrote = true;
        }
        for (word, number) in [("column", self.column), ("byte", self.byte)] {
            if let Some(number) = number {
                write!(f, "{}{word} {number}", if wrote { ", " } else { "" })?;
                wrote = true;
            }
        }
        if let Some(channel) = &self.channel {
            write!(f, "{}channel {channel}", if wrote { ", " } else { "" })?;
        }
        Ok(())
    }
}

impl Place {
    /// Names a file.
    pub fn file(name: impl Into<String>) -> Self {
        Self {
            file: Some(name.into()),
            ..Self::default()
        }
    }

    /// Names the file at `path`.
    pub fn path(path: &Path) -> Self {
        Self::file(path.display().to_string())
    }

    /// Adds a line, counted from 1.
    pub fn line(mut self, line: u64) -> Self {
        self.line = Some(line);
        self
    }

    /// Adds a column, counted from 1.
    pub fn column(mut self, column: u64) -> Self {
        self.column = Some(column);
        self
    }

    /// Adds a byte offset, counted from 0.
    pub fn byte(mut self, byte: u64) -> Self {
        self.byte = Some(byte);
        self
    }

    /// Adds a channel name.
    pub fn channel(mut self, channel: impl Into<String>) -> Self {
        self.channel = Some(channel.into());
        self
    }

    /// Names the line of `text` in which a span of bytes begins: the first line without a span.
    pub fn of_span(text: &str, span: Option<Range<usize>>) -> Self {
        let start = span.map_or(0, |span| span.start);
        let before = text.as_bytes().iter().take(start);
        Self::default().line(1 + before.filter(|byte| **byte == b'\n').count() as u64)
    }

    /// Names the line of `key` in a TOML text, below the line of its `[section]` if it has one.
    pub fn of_key(text: &str, section: Option<&str>, key: &str) -> Self {
        let names = |line: &str, name: &str| {
            let line = line.trim_start_matches(['[', '"', '\'', ' ']);
            line.strip_prefix(name)
                .is_some_and(|rest| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_'))
        };
        let lines = || text.lines().map(str::trim_start).zip(1_u64..);
        let start = section.map_or(Some(0), |section| {
            lines()
                .find(|(line, _)| line.starts_with('[') && names(line, section))
                .map(|(_, number)| number)
        });
        // A table written in one line, or a dotted key, holds its keys on the line of its name.
        let line = match (section, start) {
            (Some(section), None) => lines().find(|(line, _)| names(line, section)),
            (_, start) => {
                lines().find(|(line, number)| *number > start.unwrap_or(0) && names(line, key))
            }
        };
        line.map_or_else(Self::default, |(_, number)| Self::default().line(number))
    }

    fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// Kind of a fault. Each message states what was expected, what was found and what to try.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ErrorKind {
    /// A lever, a signal or a run that the kernel refuses.
    #[error(transparent)]
    Kernel(KernelError),
    /// A setting with a value that it does not take.
    #[error("{setting}: {wrong}, found {found}")]
    BadSetting {
        /// The setting.
        setting: Setting,
        /// What is wrong with the value: `must be a number`.
        wrong: String,
        /// The value found.
        found: String,
    },
    /// A key or name that is not known.
    #[error("unknown {what} `{}`; {}", shortened(found), match nearest { Some(name) => format!("did you mean `{name}`?"), None => format!("known: {known}") })]
    UnknownName {
        /// What kind of name it is, for example "key".
        what: &'static str,
        /// The name found.
        found: String,
        /// The nearest known name, if one is near.
        nearest: Option<String>,
        /// The known names in one line.
        known: String,
    },
    /// The operating system refused to read or write.
    #[error("cannot {action}: {reason}")]
    Io {
        /// What was tried, for example "open the file".
        action: &'static str,
        /// The system's reason.
        reason: String,
    },
    /// The input holds nothing, or nothing but a header.
    #[error("{found}; expected {expected}")]
    Empty {
        /// What was found, for example "the file is empty".
        found: String,
        /// What was expected.
        expected: String,
    },
    /// A known file format that latchgate does not read.
    #[error("this is {format}, which latchgate does not read; {way_out}")]
    RefusedFormat {
        /// The format's name.
        format: &'static str,
        /// How to get a readable file from it.
        way_out: &'static str,
    },
    /// A file whose format was not recognised.
    #[error(
        "unknown format ({found}); expected {expected}; state it with the setting `input_format`"
    )]
    UnknownFormat {
        /// What the first bytes look like.
        found: String,
        /// The formats that are read.
        expected: String,
    },
    /// The content contradicts its format.
    #[error("expected {expected}, found {found}; {hint}")]
    Malformed {
        /// What was expected.
        expected: String,
        /// What was found.
        found: String,
        /// What to try.
        hint: String,
    },
    /// A row with another number of cells than the rows before it.
    #[error(
        "expected {expected} cells as in the rows before, found {found}; correct the row, or \
         export again"
    )]
    RaggedRow {
        /// The number of cells of the first data row.
        expected: usize,
        /// The number of cells found.
        found: usize,
    },
    /// Time that stands still or goes back.
    #[error(
        "expected a time after {previous} s, found {found} s; time must increase, {}",
        if found < previous {
            "sort or cut the recording"
        } else {
            "remove the doubled row, or export the stamps with more digits; if digits are missing \
             in a text table, state the setting `rate_hz` = HZ"
        }
    )]
    TimeNotIncreasing {
        /// The stamp before [s].
        previous: f64,
        /// The stamp found [s].
        found: f64,
    },
    /// Columns of numbers without names, of which a person has to say what they are.
    #[error(
        "{columns} of numbers without names; state {}",
        stated_in_words(settings)
    )]
    UnnamedColumns {
        /// How many: `two columns`.
        columns: String,
        /// Every setting that is missing, each with the values of which one is meant.
        settings: Vec<(Setting, Vec<String>)>,
    },
    /// Nothing states the unit of acceleration.
    #[error(
        "no unit of acceleration is clear from header, units row or card; state the setting `unit` \
         = {}",
        AccelerationUnit::ALL.map(|(_, name)| name).join("|")
    )]
    MissingUnit,
    /// Nothing states the time of the samples.
    #[error(
        "no time column and no sample rate; state the setting `time_column` = NAME or the setting \
         `rate_hz` = HZ"
    )]
    MissingTime,
    /// A channel that was requested does not exist.
    #[error("no channel `{requested}`; the recording holds: {known}")]
    NoSuchChannel {
        /// The name requested.
        requested: String,
        /// The names there are.
        known: String,
    },
    /// Several channels could be meant.
    #[error(
        "{}: {candidates}; choose one with the setting `channel` = NAME",
        candidates.why()
    )]
    AmbiguousChannel {
        /// The candidates.
        candidates: Candidates,
    },
    /// No channel carries an acceleration.
    #[error(
        "no channel carries a lateral acceleration; the recording holds: {known}; choose one with the setting `channel` = NAME"
    )]
    NoChannel {
        /// The names there are.
        known: String,
    },
    /// The file ends, or contradicts itself, before its own end.
    #[error(
        "the file is cut or damaged: expected {expected}, found {found}; copy or record it again"
    )]
    Truncated {
        /// What was expected.
        expected: String,
        /// What was found.
        found: String,
    },
    /// A limit on input was crossed.
    #[error(
        "limit {limit} of {value} crossed: found {found}; cut the input, or raise it with the \
         setting `limit` = {limit}=VALUE"
    )]
    LimitExceeded {
        /// The limit's name.
        limit: &'static str,
        /// Its value.
        value: u64,
        /// What was found.
        found: String,
    },
    /// The sample rate does not carry the channel frequency class.
    #[error(
        "CFC {class} needs a sample rate of at least {needed_hz} Hz (ten times the class), found {found_hz} Hz; choose a lower class or the setting `filter` = none"
    )]
    RateTooLow {
        /// The channel frequency class.
        class: u32,
        /// The least rate [Hz].
        needed_hz: f64,
        /// The rate found [Hz].
        found_hz: f64,
    },
}

/// The library's error: a kind and the place where it arose.
///
/// Both are boxed: an error is rare, and every result would carry their size.
#[derive(Debug, Clone, PartialEq)]
pub struct Error(Box<Inner>);

#[derive(Debug, Clone, PartialEq)]
struct Inner {
    kind: ErrorKind,
    place: Place,
}

impl Error {
    /// Returns the error of content that contradicts its format, with a remedy.
    pub fn malformed(
        expected: impl Into<String>,
        found: impl Into<String>,
        hint: impl Into<String>,
    ) -> Self {
        let (expected, found, hint) = (expected.into(), found.into(), hint.into());
        Self::from(ErrorKind::Malformed {
            expected,
            found,
            hint,
        })
    }

    /// Returns the error of a quantity outside its permitted range.
    pub fn out_of_range(
        what: impl Into<String>,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> Self {
        KernelError::out_of_range(what, expected, found).into()
    }

    /// Returns the error of an action that the operating system refused, with its reason.
    pub fn io(action: &'static str, reason: &dyn fmt::Display) -> Self {
        let reason = reason.to_string();
        Self::from(ErrorKind::Io { action, reason })
    }

    /// Returns the error of an action on a file that the operating system refused.
    pub fn io_at(action: &'static str, path: &Path, reason: &dyn fmt::Display) -> Self {
        Self::io(action, reason).at(Place::path(path))
    }

    /// Returns the error of a crossed limit.
    pub fn over(limit: &'static str, value: u64, found: impl Into<String>) -> Self {
        let found = found.into();
        Self::from(ErrorKind::LimitExceeded {
            limit,
            value,
            found,
        })
    }

    /// Returns the error of an input without content.
    pub fn empty(found: impl Into<String>, expected: impl Into<String>) -> Self {
        let (found, expected) = (found.into(), expected.into());
        Self::from(ErrorKind::Empty { found, expected })
    }

    /// Returns the error of a file that ends, or contradicts itself, before its own end.
    pub fn truncated(expected: impl Into<String>, found: impl Into<String>) -> Self {
        let (expected, found) = (expected.into(), found.into());
        Self::from(ErrorKind::Truncated { expected, found })
    }

    /// Returns the error of fewer samples than `what` needs.
    pub fn too_short(what: &'static str, needed: usize, found: usize) -> Self {
        KernelError::TooShort {
            what,
            needed,
            found,
        }
        .into()
    }

    /// Returns the error of a name that is not `known`, with the nearest that is.
    pub fn unknown(what: &'static str, found: impl Into<String>, known: &[&str]) -> Self {
        let found = found.into();
        Self::from(ErrorKind::UnknownName {
            what,
            nearest: nearest_name(&found, known),
            known: known.join(", "),
            found,
        })
    }

    /// True if the caller's [`Control`](latchgate_kernel::parallel::Control) ended the work.
    pub fn is_stopped(&self) -> bool {
        self.0.kind == ErrorKind::Kernel(KernelError::Stopped)
    }

    /// Returns what went wrong.
    pub fn kind(&self) -> &ErrorKind {
        &self.0.kind
    }

    /// Returns where it went wrong.
    pub fn place(&self) -> &Place {
        &self.0.place
    }

    /// Puts the error at `place`, keeping the parts that are already known.
    pub fn at(mut self, place: Place) -> Self {
        let inner = std::mem::take(&mut self.0.place);
        // Line, column and byte of an outer file must not join the name of an inner one.
        let one_file = inner.file.is_none() || place.file.is_none() || inner.file == place.file;
        self.0.place = Place {
            file: inner.file.or(place.file),
            line: inner.line.or(place.line.filter(|_| one_file)),
            column: inner.column.or(place.column.filter(|_| one_file)),
            byte: inner.byte.or(place.byte.filter(|_| one_file)),
            channel: inner.channel.or(place.channel),
        };
        self
    }
}

impl From<ErrorKind> for Error {
    fn from(kind: ErrorKind) -> Self {
        Self(Box::new(Inner {
            kind,
            place: Place::default(),
        }))
    }
}

impl From<KernelError> for Error {
    fn from(error: KernelError) -> Self {
        match error {
            // This crate's error adds the nearest name.
            KernelError::UnknownName { what, found, known } => {
                let known: Vec<&str> = known.iter().map(String::as_str).collect();
                Self::unknown(what, found, &known)
            }
            error => Self::from(ErrorKind::Kernel(error)),
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.place.is_empty() {
            write!(f, "{}", self.0.kind)
        } else {
            write!(f, "{}: {}", self.0.place, self.0.kind)
        }
    }
}

impl std::error::Error for Error {}

/// Returns the name of a kind of value with its article: `an integer`.
#[doc(hidden)]
pub fn with_article(kind: &str) -> String {
    let article = if kind.starts_with(['a', 'i']) {
        "an"
    } else {
        "a"
    };
    format!("{article} {kind}")
}

/// Lists settings with the values of which one is meant.
fn stated_in_words(settings: &[(Setting, Vec<String>)]) -> String {
    let words = |(setting, values): &(Setting, Vec<String>)| {
        const LISTED: usize = 8;
        let more = if values.len() > LISTED { "|…" } else { "" };
        let values = values[..values.len().min(LISTED)].join("|");
        format!("{setting} = {values}{more}")
    };
    let settings: Vec<String> = settings.iter().map(words).collect();
    match settings.split_last() {
        Some((last, before)) if !before.is_empty() => format!("{} and {last}", before.join(", ")),
        _ => settings.concat(),
    }
}

/// Shortens a name for a message: one taken from a file may be as long as the file.
fn shortened(name: &str) -> String {
    const MOST: usize = 60;
    match name.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}…", &name[..end]),
        None => name.to_string(),
    }
}

/// Returns the name in `known` nearest to `found`, if one is near enough to be a slip.
pub fn nearest_name(found: &str, known: &[&str]) -> Option<String> {
    let near = |name: &str| 2.max(name.len() / 3);
    let length = found.chars().count();
    known
        .iter()
        // Names differ by no less than their lengths do. To compare costs time and memory as the
        // product of these, and `found` may be as long as a file.
        .filter(|name| name.chars().count().abs_diff(length) <= near(name))
        .map(|name| (strsim::damerau_levenshtein(found, name), *name))
        .filter(|(distance, name)| *distance <= near(name))
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, name)| name.to_string())
}
