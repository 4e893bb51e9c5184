//! A gate's words made plain: recordings in order, designs by name, what is required of each pair.
//!
//! Patterns become files, files become names, and names are matched with the requirements; each
//! step needs the one before. A pattern that matches nothing is an error. No recording is opened.

use super::file::{
    DesignEntry, ERRORS_MAX, Exception, GateFile, RecordingsEntry, StaticRequirement,
};
use crate::pipeline::{Answer, Design, Limits, Request, Source, design_from_bytes, read_within};
use glob::{MatchOptions, Pattern};
use latchgate_document::blocks::DesignFile;
use latchgate_document::design_file::apply_override;
use latchgate_recording::error::{Error, Place};
use latchgate_recording::pulse;
use latchgate_recording::source::sha256;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Recordings and designs of a gate with the answers that it requires.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Name of the gate file.
    pub gate: String,
    /// Recordings, in the order of their names.
    pub recordings: Vec<PlannedRecording>,
    /// Designs, in the order of their names.
    pub designs: Vec<Design>,
    /// Files of those that were read from one, by the design's name.
    pub(super) design_files: BTreeMap<String, DesignFile>,
    rules: Vec<Rule>,
    /// Exceptions, in the order of the file.
    pub exceptions: Vec<PlannedException>,
    /// True if only some pairs of the gate are judged.
    pub part: bool,
    /// Static load that every design is to hold.
    pub require_static: Option<StaticRequirement>,
}

/// A recording with its settings.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedRecording {
    /// Path relative to the gate file's folder, `/` between folders, and the channel where the
    /// gate names one; of a pulse its canonical word.
    pub name: String,
    /// Line of its entry in the gate file.
    pub line: Option<u64>,
    /// Path of the file or folder; of a pulse its canonical word.
    pub path: PathBuf,
    /// Settings of reading, conditioning and judging, shared by all recordings of an entry.
    pub request: Arc<Request>,
}

impl PlannedRecording {
    /// Returns the source that is read: a file or folder, or a pulse by its word.
    pub fn source(&self) -> Source {
        match self.is_pulse() {
            true => {
                let word = self.path.to_string_lossy().into_owned();
                Source::bytes(word.clone(), word.into_bytes())
            }
            false => Source::File(self.path.clone()),
        }
    }

    /// True for a pulse, whose `path` is its word.
    pub(super) fn is_pulse(&self) -> bool {
        is_pulse(&self.path.to_string_lossy())
    }
}

fn is_pulse(word: &str) -> bool {
    word.starts_with(pulse::PREFIX)
}

/// A rule that matches pairs by name.
#[derive(Debug, Clone)]
struct Rule {
    pairs: PairPattern,
    verdict: Answer,
}

/// An exception that matches pairs by name.
#[derive(Debug, Clone)]
pub struct PlannedException {
    /// Position in the gate file.
    pub place: Place,
    pairs: PairPattern,
    /// Reason, as the gate file states it.
    pub reason: String,
    /// Last day on which it holds, `YYYY-MM-DD`.
    pub until: String,
}

/// Patterns of a recording's and a design's name.
#[derive(Debug, Clone)]
struct PairPattern {
    recordings: Pattern,
    designs: Pattern,
}

/// A design's name is no path: `*` matches a `/` in it, too.
const DESIGNS: MatchOptions = MatchOptions {
    require_literal_separator: false,
    ..NAMES
};

/// `*` stops at a `/`, as in a shell; a leading dot is a letter like any other.
const NAMES: MatchOptions = MatchOptions {
    case_sensitive: true,
    require_literal_separator: true,
    require_literal_leading_dot: false,
};

impl PairPattern {
    fn new(recordings: &str, designs: &str) -> Result<Self, Error> {
        Ok(Self {
            recordings: pattern(recordings)?,
            designs: pattern(designs)?,
        })
    }

    fn matches(&self, recording: &str, design: &str) -> bool {
        names_recording(&self.recordings, recording) && names_design(&self.designs, design)
    }
}

/// True if a pattern names a recording: by its full name, or by that of its file, which ends
/// before the `#` of its channel.
fn names_recording(pattern: &Pattern, name: &str) -> bool {
    if is_pulse(name) {
        // A pulse's word is no path: a `/` in it separates nothing.
        return pattern.matches_with(name, DESIGNS);
    }
    // A file's name may hold a `#`, too, so each of them may begin the channel.
    let mut files = name.match_indices('#').map(|(index, _)| &name[..index]);
    pattern.matches_with(name, NAMES) || files.any(|file| pattern.matches_with(file, NAMES))
}

/// True if a pattern names a design.
fn names_design(pattern: &Pattern, name: &str) -> bool {
    pattern.matches_with(name, DESIGNS)
}

/// Marks each name that one of the patterns matches, or all where there is no pattern; `key` is the
/// plural of the named things, for errors.
fn chosen<'a>(
    names: impl Iterator<Item = &'a str>,
    key: &str,
    patterns: &[String],
    matches: fn(&Pattern, &str) -> bool,
) -> Result<Vec<bool>, Error> {
    const HINT: &str = "correct the pattern; the list of pairs shows the names";
    let names: Vec<&str> = names.collect();
    let mut chosen = vec![patterns.is_empty(); names.len()];
    for text in patterns {
        let pattern = pattern(text)?;
        let matched: Vec<bool> = names.iter().map(|name| matches(&pattern, name)).collect();
        if !matched.contains(&true) {
            return Err(matches_nothing("choice", key, text, HINT));
        }
        for (chosen, matched) in chosen.iter_mut().zip(matched) {
            *chosen |= matched;
        }
    }
    Ok(chosen)
}

impl PlannedException {
    /// True if the exception covers a pair.
    pub fn matches(&self, recording: &str, design: &str) -> bool {
        self.pairs.matches(recording, design)
    }
}

impl Plan {
    /// Looks up the recordings and designs of a gate file, relative to `folder`. Patterns skip
    /// `output_folders`, in which the gate writes.
    ///
    /// # Errors
    ///
    /// Everything that does not fit, each at its line: a pattern, requirement or exception that
    /// matches nothing, a recording with two settings, two designs of a name, a design that cannot
    /// be read, nothing to judge.
    pub fn of(
        gate: &str,
        file: &GateFile,
        folder: &Path,
        output_folders: &[PathBuf],
        limits: &Limits,
    ) -> Result<Self, Vec<Error>> {
        let mut errors = Vec::new();
        let recordings = recordings(&file.recordings, folder, output_folders, &mut errors);
        let (designs, design_files) = designs(&file.designs, folder, limits, &mut errors);
        let mut plan = Self::from_parts(gate, file, recordings, designs, errors)?;
        plan.design_files = design_files;
        Ok(plan)
    }

    /// Makes a plan of recordings and designs that are already looked up, both in the order of
    /// their names; `errors` are those of the lookup.
    ///
    /// # Errors
    ///
    /// `errors`, and all that does not fit as in [`Self::of`].
    pub fn from_parts(
        gate: &str,
        file: &GateFile,
        recordings: Vec<PlannedRecording>,
        designs: Vec<Design>,
        mut errors: Vec<Error>,
    ) -> Result<Self, Vec<Error>> {
        for (missing, what) in [
            (file.recordings.is_empty(), "[[recordings]]"),
            (file.designs.is_empty(), "[[designs]]"),
        ] {
            if missing {
                let hint = "add one; an empty gate would let everything through";
                errors.push(Error::malformed(what, "none", hint).at(Place::file(gate)));
            }
        }
        let mut plan = Self {
            gate: gate.into(),
            recordings,
            designs,
            design_files: BTreeMap::new(),
            rules: Vec::new(),
            exceptions: Vec::new(),
            part: false,
            require_static: file.require_static,
        };
        for entry in &file.require {
            if errors.len() >= ERRORS_MAX {
                break;
            }
            match plan.pairs(&entry.recordings, &entry.designs, "requirement") {
                Ok(pairs) => plan.rules.push(Rule {
                    pairs,
                    verdict: entry.verdict,
                }),
                Err(error) => errors.push(error.at(entry.place.clone())),
            }
        }
        for entry in &file.allow {
            if errors.len() >= ERRORS_MAX {
                break;
            }
            match plan.exception(entry) {
                Ok(exception) => plan.exceptions.push(exception),
                Err(error) => errors.push(error.at(entry.place.clone())),
            }
        }
        plan.check_designs(&mut errors);
        if errors.is_empty() {
            Ok(plan)
        } else {
            Err(errors)
        }
    }

    /// Keeps only recordings and designs that one of the patterns names, or all where there is no
    /// pattern.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Malformed`] for a pattern that is none, or that names nothing.
    pub fn only(&mut self, recordings: &[String], designs: &[String]) -> Result<(), Error> {
        let names = self.recordings.iter().map(|recording| &*recording.name);
        let chosen_recordings = chosen(names, "recordings", recordings, names_recording)?;
        let names = self.designs.iter().map(|design| &*design.name);
        let chosen_designs = chosen(names, "designs", designs, names_design)?;
        self.part = chosen_recordings.contains(&false) || chosen_designs.contains(&false);
        let mut is_chosen = chosen_recordings.into_iter();
        self.recordings
            .retain(|_| is_chosen.next().unwrap_or(false));
        let mut is_chosen = chosen_designs.into_iter();
        self.designs.retain(|_| is_chosen.next().unwrap_or(false));
        Ok(())
    }

    /// Checks every design with every recording's settings; an error that many designs share is
    /// reported once.
    fn check_designs(&self, errors: &mut Vec<Error>) {
        let mut by_message: BTreeMap<String, (Error, BTreeSet<&str>)> = BTreeMap::new();
        for recording in &self.recordings {
            for design in &self.designs {
                if let Err(error) = recording.request.check_design(design) {
                    let entry = by_message.entry(error.to_string());
                    let (_, names) = entry.or_insert_with(|| (error, BTreeSet::new()));
                    names.insert(&design.name);
                }
            }
        }
        for (error, names) in by_message.into_values() {
            let first = names.first().copied().unwrap_or_default();
            let designs = match names.len() {
                1 => format!("design {first}"),
                some => format!("design {first} and {} others", some - 1),
            };
            errors.push(error.at(Place::file(designs)));
        }
    }

    /// Returns the answer that is required of a pair: that of the last rule that matches it.
    pub fn required(&self, recording: &str, design: &str) -> Answer {
        self.rules
            .iter()
            .rfind(|rule| rule.pairs.matches(recording, design))
            .map_or(Answer::Pass, |rule| rule.verdict)
    }

    fn exception(&self, entry: &Exception) -> Result<PlannedException, Error> {
        Ok(PlannedException {
            place: entry.place.clone(),
            pairs: self.pairs(&entry.recordings, &entry.designs, "exception")?,
            reason: entry.reason.clone(),
            until: entry.until.clone(),
        })
    }

    fn pairs(&self, recordings: &str, designs: &str, what: &str) -> Result<PairPattern, Error> {
        let pairs = PairPattern::new(recordings, designs)?;
        let is_named =
            |recording: &PlannedRecording| names_recording(&pairs.recordings, &recording.name);
        if !self.recordings.iter().any(is_named) {
            return Err(matches_nothing(what, "recordings", recordings, ENTRY_HINT));
        }
        let is_named = |design: &Design| names_design(&pairs.designs, &design.name);
        if !self.designs.iter().any(is_named) {
            return Err(matches_nothing(what, "designs", designs, ENTRY_HINT));
        }
        Ok(pairs)
    }
}

/// Remedy for a pattern of an entry that names nothing.
const ENTRY_HINT: &str = "correct the pattern, or remove the entry";

fn matches_nothing(rule: &str, key: &str, pattern: &str, hint: &str) -> Error {
    Error::malformed(
        format!("one of the {key} with the name `{pattern}` for this {rule}"),
        "none",
        hint,
    )
}

fn pattern(text: &str) -> Result<Pattern, Error> {
    Pattern::new(text).map_err(|error| {
        Error::malformed(
            "a pattern of names",
            format!("`{text}` ({error})"),
            "write * for any letters, ** for any folders",
        )
    })
}

/// Finds the recordings of all entries, in the order of their names.
fn recordings(
    entries: &[RecordingsEntry],
    folder: &Path,
    output_folders: &[PathBuf],
    errors: &mut Vec<Error>,
) -> Vec<PlannedRecording> {
    let mut by_name: BTreeMap<String, PlannedRecording> = BTreeMap::new();
    let mut places: BTreeMap<(PathBuf, Option<String>), String> = BTreeMap::new();
    for entry in entries {
        let request = Arc::new(entry.request.clone());
        for files in &entry.files {
            if errors.len() >= ERRORS_MAX {
                break;
            }
            let paths = match paths(files, folder, output_folders) {
                Ok(paths) => paths,
                Err(error) => {
                    errors.push(error.at(entry.place.clone()));
                    continue;
                }
            };
            for path in paths {
                // A pipe or a device may never end, so it is refused before it is opened.
                let metadata = path.metadata();
                if metadata.is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir()) {
                    let kind = format!("`{}`, which is neither", path.display());
                    let error = Error::malformed("a file or a folder", &kind, "leave it out");
                    errors.push(error.at(entry.place.clone()));
                    continue;
                }
                let name = match is_pulse(files) {
                    true => path.display().to_string(),
                    false => name_of(&path, folder, entry.request.channel.as_deref()),
                };
                let planned = PlannedRecording {
                    name: name.clone(),
                    line: entry.place.line,
                    path,
                    request: Arc::clone(&request),
                };
                // Two entries may reach one file by different paths: a link, or `a/../b`.
                let place = planned.path.canonicalize();
                let place = place.unwrap_or_else(|_| planned.path.clone());
                let key = (place, planned.request.channel.clone());
                let earlier = places.get(&key).unwrap_or(&name);
                match by_name.get(earlier) {
                    Some(earlier) if !is_same(earlier, &planned) => {
                        let error = Error::malformed(
                            format!("`{name}` with one setting"),
                            "two entries that judge it differently",
                            "let only one entry match it, or state a channel in both",
                        );
                        errors.push(error.at(entry.place.clone()));
                    }
                    Some(_) => {}
                    None => {
                        places.insert(key, name.clone());
                        by_name.insert(name, planned);
                    }
                }
            }
        }
    }
    by_name.into_values().collect()
}

/// True if two entries name one file and judge it by the same settings.
fn is_same(one: &PlannedRecording, two: &PlannedRecording) -> bool {
    let place = |recording: &PlannedRecording| recording.path.canonicalize().ok();
    one.request == two.request && place(one) == place(two)
}

/// Returns the files and folders that a path or pattern names.
fn paths(files: &str, folder: &Path, output_folders: &[PathBuf]) -> Result<Vec<PathBuf>, Error> {
    let nothing = || {
        Error::malformed(
            format!("a recording at `{files}`"),
            "none",
            "correct the path or pattern; it is relative to the gate file; **/* matches all files \
             below it; [[] matches the letter [",
        )
    };
    if is_pulse(files) {
        return Ok(vec![pulse::canonical(files, Some(folder))?.into()]);
    }
    let plain = folder.join(files);
    if plain.exists() {
        return Ok(vec![plain]);
    }
    if !files.contains(['*', '?', '[']) {
        return Err(nothing());
    }
    let root = Pattern::escape(&folder.to_string_lossy());
    let pattern = Path::new(&root).join(files);
    let matches = glob::glob_with(&pattern.to_string_lossy(), NAMES).map_err(|error| {
        Error::malformed(
            "a pattern of files",
            format!("`{files}` ({error})"),
            "write * for any letters, ** for any folders",
        )
    })?;
    refuse_other_than_utf8(folder, files)?;
    let output_folders: Vec<PathBuf> = output_folders
        .iter()
        .filter_map(|folder| folder.canonicalize().ok())
        .collect();
    let is_output = |path: &Path| {
        let path = path.canonicalize();
        path.is_ok_and(|path| output_folders.iter().any(|folder| path.starts_with(folder)))
    };
    let mut recordings = BTreeSet::new();
    for path in matches {
        let path = path.map_err(|error| Error::io("look for recordings", &error))?;
        if is_recording(&path) && !is_output(&path) {
            recordings.insert(path);
        }
    }
    if recordings.is_empty() {
        return Err(nothing());
    }
    Ok(recordings.into_iter().collect())
}

/// Refuses a pattern that searches a folder in which a name is no UTF-8. No pattern matches such a
/// name, so the recording would be left unjudged without a word.
fn refuse_other_than_utf8(folder: &Path, files: &str) -> Result<(), Error> {
    let parts: Vec<&str> = files.split('/').collect();
    let plain = parts
        .iter()
        .take_while(|part| !part.contains(['*', '?', '[']));
    let plain = plain.count();
    let depth = if parts.contains(&"**") {
        usize::MAX
    } else {
        parts.len() - plain
    };
    let mut open = vec![(folder.join(parts[..plain].join("/")), depth)];
    while let Some((folder, depth)) = open.pop() {
        for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            let name = entry.file_name();
            if name.to_str().is_none() {
                return Err(Error::malformed(
                    "names in UTF-8 where the pattern searches",
                    format!("`{}` in {}", name.to_string_lossy(), folder.display()),
                    "rename the file; no pattern matches this name",
                ));
            }
            if depth > 1 && entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                open.push((entry.path(), depth - 1));
            }
        }
    }
    Ok(())
}

/// True if a match is a recording: a file that is no card of another one, or the folder of an
/// ISO-MME test.
pub(super) fn is_recording(path: &Path) -> bool {
    if path.is_dir() {
        let files = std::fs::read_dir(path).into_iter().flatten().flatten();
        let is_header = |name: &Path| {
            name.extension()
                .is_some_and(|end| end.eq_ignore_ascii_case("mme"))
        };
        return files.map(|file| file.path()).any(|file| is_header(&file));
    }
    let is_card =
        path.extension().is_some_and(|end| end == "toml") && path.with_extension("").exists();
    !is_card
}

fn name_of(path: &Path, folder: &Path, channel: Option<&str>) -> String {
    let relative = path.strip_prefix(folder).unwrap_or(path);
    let parts: Vec<_> = relative
        .components()
        .map(|part| part.as_os_str().to_string_lossy())
        .collect();
    // An absolute path begins with the part `/`, which `join` doubles.
    let name = parts.join("/").replacen("//", "/", 1);
    match channel {
        Some(channel) => format!("{name}#{channel}"),
        None => name,
    }
}

/// Reads the designs, in the order of their names.
fn designs(
    entries: &[DesignEntry],
    folder: &Path,
    limits: &Limits,
    errors: &mut Vec<Error>,
) -> (Vec<Design>, BTreeMap<String, DesignFile>) {
    let mut by_name: BTreeMap<String, Design> = BTreeMap::new();
    let mut files = BTreeMap::new();
    for entry in entries {
        if errors.len() >= ERRORS_MAX {
            break;
        }
        match design(entry, folder, limits) {
            Ok((design, _)) if by_name.contains_key(&design.name) => {
                let what = format!("one design named `{}`", design.name);
                let error = Error::malformed(&what, "two", "give one of them another `name`");
                errors.push(error.at(entry.place.clone()));
            }
            Ok((design, file)) => {
                files.extend(file.map(|file| (design.name.clone(), file)));
                by_name.insert(design.name.clone(), design);
            }
            Err(error) => errors.push(error.at(entry.place.clone())),
        }
    }
    (by_name.into_values().collect(), files)
}

fn design(
    entry: &DesignEntry,
    folder: &Path,
    limits: &Limits,
) -> Result<(Design, Option<DesignFile>), Error> {
    let mut design_file = None;
    let mut design = match &entry.file {
        None => Design::reference(),
        Some(file) => {
            let limit = ("settings_bytes", limits.settings_bytes);
            let bytes = read_within(&folder.join(file), file, "read the design file", limit)?;
            let name = Path::new(file).file_name().unwrap_or_default();
            design_file = Some(DesignFile {
                name: name.to_string_lossy().into_owned(),
                sha256: sha256(&bytes),
            });
            design_from_bytes(file, &bytes, limits)?
        }
    };
    for assignment in &entry.set {
        apply_override(&mut design, assignment)?;
    }
    if let Some(name) = &entry.name {
        design.name.clone_from(name);
    }
    design.validate()?;
    Ok((design, design_file))
}
