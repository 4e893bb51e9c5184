//! The files of a test, wherever they are: in a folder, in an archive, or beside the one given.

use super::archive::{Archive, is_archive};
use super::channel::{ChannelHeader, Samples, looks_like_channel};
use super::code::{self, Code, VehicleSide};
use super::names::{is_channel_file, kept, number_of, suffix_of, test_of};
use crate::error::{Error, ErrorKind, Place};
use crate::recording::encoding;
use crate::recording::source::Reader;
use crate::recording::text;
use crate::recording::{Finding, Limits};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// Bytes up to which the one channel file that was given may be held twice.
const HELD_TWICE: usize = 16 << 20;

/// A channel of the test.
#[derive(Debug)]
pub(super) struct ChannelEntry {
    /// File, as the package names it.
    pub(super) file: String,
    /// The file's number as its suffix has it: `003`.
    pub(super) suffix: String,
    /// Name for people: code, or name if there is no code.
    pub(super) label: String,
    pub(super) header: ChannelHeader,
}

impl ChannelEntry {
    /// Tells whether a word is the channel's name, code or file number.
    pub(super) fn is_named(&self, wanted: &str) -> bool {
        let wanted = wanted.trim();
        let number = |text: &str| text.parse::<u32>().ok();
        self.label == wanted
            || self
                .header
                .value("Channel code")
                .is_some_and(|code| code.eq_ignore_ascii_case(wanted))
            || self.header.value("Name of the channel") == Some(wanted)
            || (number(wanted).is_some() && number(wanted) == number(&self.suffix))
    }

    /// Tells whether a word means this channel, a pattern of codes included.
    pub(super) fn answers_to(&self, wanted: &str) -> bool {
        self.is_named(wanted)
            || self
                .header
                .value("Channel code")
                .is_some_and(|code| code::fits(wanted, code))
    }
}

/// Refuses files that are not of one test: which channel goes with which clock and which struck
/// side would be a guess.
fn check_one_test(names: &[String], in_archive: bool) -> Result<(), Error> {
    const LISTED: usize = 8;
    // Of each test, one file that shows it; its own header, if there is one.
    let mut tests: BTreeMap<(String, String), &String> = BTreeMap::new();
    for name in names {
        let shows = tests.entry(test_of(name)).or_insert(name);
        if suffix_of(name).is_some_and(|suffix| suffix.eq_ignore_ascii_case("mme")) {
            *shows = name;
        }
    }
    if tests.len() > 1 {
        let mut shown: Vec<String> = tests
            .values()
            .take(LISTED)
            .map(|name| text::shown(name))
            .collect();
        if tests.len() > LISTED {
            shown.push("others".into());
        }
        return Err(ErrorKind::Malformed {
            expected: "the files of one test, which share folder and stem".into(),
            found: format!("those of {}: {}", tests.len(), shown.join(", ")),
            hint: if in_archive {
                "unpack the archive and name the .mme file of one test, or pack each test by itself"
            } else {
                "name the .mme file of one test, or one channel file"
            }
            .into(),
        }
        .into());
    }
    let mut numbers: BTreeMap<u32, &String> = BTreeMap::new();
    for name in names {
        if let Some(number) = number_of(name)
            && let Some(other) = numbers.insert(number, name)
        {
            return Err(ErrorKind::Malformed {
                expected: "one file for each channel's number".into(),
                found: format!("{} and {}", text::shown(other), text::shown(name)),
                hint: "which of the two holds is not known; leave out one of them".into(),
            }
            .into());
        }
    }
    Ok(())
}

/// The files of a test.
pub(super) struct Package {
    /// Names of the test's files, in order.
    names: Vec<String>,
    /// Name of the archive that holds them.
    archive: Option<String>,
    place: Where,
    /// The one channel file that was given, with its bytes.
    given: Option<(String, Vec<u8>)>,
    /// Bytes of headers read so far.
    header_bytes: u64,
    /// Samples that were read and are needed again, by file, and whether more shall be kept.
    kept: BTreeMap<String, Result<Rc<Samples>, Error>>,
    keeps: bool,
    /// Files beside the recording that were read for the selection at hand.
    parts: BTreeSet<String>,
}

enum Where {
    Beside,
    Archive(Box<Archive>),
}

impl Package {
    pub(super) fn open(source: &mut Reader, limits: &Limits) -> Result<Self, Error> {
        if source.is_folder() {
            let names = kept(source.list(true, limits)?);
            check_one_test(&names, false)?;
            return Ok(Self::beside(names));
        }
        let head = source.head()?;
        if is_archive(&head) {
            let archive = Archive::open(
                source.read_all("archive_bytes", limits.archive_bytes)?,
                limits,
            )?;
            let names = kept(archive.names());
            if !names.iter().any(|name| is_channel_file(name)) {
                return Err(archive.refused());
            }
            check_one_test(&names, true)?;
            return Ok(Self {
                archive: Some(source.name().to_string()),
                place: Where::Archive(Box::new(archive)),
                ..Self::beside(names)
            });
        }
        if looks_like_channel(&head) {
            let bytes = source.read_text(limits)?;
            let name = source.name().to_string();
            // Others are of use only for an explicit time, so that a large folder does no harm.
            let mut names = kept(source.list(false, limits).unwrap_or_default());
            names.retain(|other| test_of(other) == test_of(&name));
            if !names.contains(&name) {
                names.push(name.clone());
            }
            return Ok(Self {
                given: Some((name, bytes)),
                ..Self::beside(names)
            });
        }
        let name = source.name().to_string();
        let (mut names, others): (Vec<String>, Vec<String>) = kept(source.list(true, limits)?)
            .into_iter()
            .partition(|other| test_of(other) == test_of(&name));
        if !names.iter().any(|name| is_channel_file(name))
            && let Some(other) = others.iter().find(|name| is_channel_file(name))
        {
            let stem = name.rsplit_once('.').map_or(&*name, |(stem, _)| stem);
            return Err(ErrorKind::Malformed {
                expected: format!(
                    "channel files of the same stem, {stem}.001 or Channel/{stem}.001"
                ),
                found: format!("{}, of another test", text::shown(other)),
                hint: "give the test's files one stem, or name the channel file".into(),
            }
            .into());
        }
        if !names.contains(&name) {
            names.push(name);
        }
        check_one_test(&names, false)?;
        Ok(Self::beside(names))
    }

    /// A test of which nothing is read yet, its files beside one another in a folder.
    fn beside(names: Vec<String>) -> Self {
        Self {
            names,
            archive: None,
            place: Where::Beside,
            given: None,
            header_bytes: 0,
            kept: BTreeMap::new(),
            keeps: false,
            parts: BTreeSet::new(),
        }
    }

    /// Names a file for a message, with the archive that holds it.
    pub(super) fn place_of(&self, name: &str) -> Place {
        Place::file(match &self.archive {
            Some(archive) => format!("{archive}: {name}"),
            None => name.to_string(),
        })
    }

    /// Returns the index of the one channel file that was given.
    pub(super) fn only_channel(&self) -> Option<usize> {
        let (given, _) = self.given.as_ref()?;
        self.names
            .iter()
            .filter(|name| is_channel_file(name) || *name == given)
            .position(|name| name == given)
    }

    /// Begins to read for a selection; with `keeps` what is read for it is held for the next one.
    pub(super) fn begin(&mut self, keeps: bool) {
        self.keeps = keeps;
        self.parts = BTreeSet::new();
    }

    /// Returns the files beside the recording that were read for the selection at hand.
    pub(super) fn parts(&self) -> BTreeSet<String> {
        self.parts.clone()
    }

    /// Reads the samples of a channel file, once for all selections; within, what is wrong with
    /// the samples themselves.
    ///
    /// # Errors
    ///
    /// Those of reading the file.
    pub(super) fn samples(
        &mut self,
        name: &str,
        source: &mut Reader,
        limits: &Limits,
    ) -> Result<Result<Rc<Samples>, Error>, Error> {
        if matches!(self.place, Where::Beside) {
            self.parts.insert(name.to_string());
        }
        if let Some(samples) = self.kept.get(name) {
            return Ok(samples.clone());
        }
        let bytes = self.whole(name, source, limits)?;
        let samples = Samples::read(bytes, limits).map(Rc::new);
        if self.keeps {
            self.kept.insert(name.to_string(), samples.clone());
        }
        Ok(samples)
    }

    /// Reads a file whole, within limits.
    fn whole(
        &mut self,
        name: &str,
        source: &mut Reader,
        limits: &Limits,
    ) -> Result<Vec<u8>, Error> {
        if let Some((given, bytes)) = &mut self.given
            && given == name
        {
            // A large file is held once: it has no need to be its own channel of times.
            return Ok(if bytes.len() > HELD_TWICE {
                std::mem::take(bytes)
            } else {
                bytes.clone()
            });
        }
        let read = match &mut self.place {
            Where::Beside => source.read_beside(name, limits)?.ok_or_else(|| {
                ErrorKind::Io {
                    action: "read the test",
                    reason: format!("{name} is not there"),
                }
                .into()
            }),
            Where::Archive(archive) => archive.read(name, limits.unpacked_bytes, limits),
        };
        read.map_err(|error: Error| error.at(self.place_of(name)))
    }

    /// Reads up to `most` bytes from the start of a file.
    fn head(
        &mut self,
        name: &str,
        most: u64,
        source: &Reader,
        limits: &Limits,
    ) -> Result<Vec<u8>, Error> {
        if let Some((given, bytes)) = &self.given
            && given == name
        {
            let end = bytes.len().min(usize::try_from(most).unwrap_or(usize::MAX));
            return Ok(bytes[..end].to_vec());
        }
        let read = match &mut self.place {
            Where::Beside => source
                .read_head_of(name, most)
                .map(Option::unwrap_or_default),
            Where::Archive(archive) => archive.head(name, most, limits),
        };
        read.map_err(|error| error.at(self.place_of(name)))
    }

    /// Decodes the start of a file.
    fn decoded(
        &self,
        name: &str,
        bytes: Vec<u8>,
        limits: &Limits,
        findings: &mut Vec<Finding>,
    ) -> Result<String, Error> {
        let (bytes, found) =
            encoding::decode(bytes, limits).map_err(|error| error.at(self.place_of(name)))?;
        for finding in found {
            if !findings.contains(&finding) {
                findings.push(finding);
            }
        }
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }

    /// Reads the test's header or list.
    fn test_file(&mut self, name: &str, source: &Reader, limits: &Limits) -> Result<String, Error> {
        let bytes = self.head(name, limits.headers_bytes.saturating_add(1), source, limits)?;
        if bytes.len() as u64 > limits.headers_bytes {
            return Err(longer_headers(limits).at(self.place_of(name).byte(limits.headers_bytes)));
        }
        self.decoded(name, bytes, limits, &mut Vec::new())
    }

    /// Reads the header of a channel file.
    fn channel_header(
        &mut self,
        name: &str,
        source: &Reader,
        limits: &Limits,
        findings: &mut Vec<Finding>,
    ) -> Result<ChannelHeader, Error> {
        let mut bytes = self.head(name, limits.header_bytes.saturating_add(1), source, limits)?;
        let is_cut = bytes.len() as u64 > limits.header_bytes;
        if is_cut {
            bytes.truncate(whole_lines(&bytes));
        }
        let content = self.decoded(name, bytes, limits, findings)?;
        let header = ChannelHeader::read(&content);
        if is_cut && !header.is_whole() {
            return Err(Error::from(ErrorKind::LimitExceeded {
                limit: "header_bytes",
                value: limits.header_bytes,
                found: "no sample after as many bytes of header".into(),
            })
            .at(self.place_of(name).byte(limits.header_bytes)));
        }
        self.header_bytes += header.bytes();
        if self.header_bytes > limits.headers_bytes {
            return Err(longer_headers(limits).at(self.place_of(name).byte(header.bytes())));
        }
        Ok(header)
    }

    /// Says why a test without a channel file cannot be read.
    pub(super) fn without_channels(&self) -> Error {
        let inner = self
            .names
            .iter()
            .find_map(|name| name.split_once('/'))
            .map(|(folder, _)| folder)
            .filter(|folder| !folder.eq_ignore_ascii_case("channel"));
        match inner {
            Some(folder) => ErrorKind::Malformed {
                expected: "the folder of one test, with its channel files".into(),
                found: format!(
                    "a folder above it: the test lies in {}",
                    text::shown(folder)
                ),
                hint: "name the folder that lies inside".into(),
            }
            .into(),
            None => ErrorKind::NoChannel {
                known: "no channel file".into(),
            }
            .into(),
        }
    }

    /// Reads the headers of all channels.
    pub(super) fn channels(
        &mut self,
        source: &Reader,
        limits: &Limits,
        findings: &mut Vec<Finding>,
    ) -> Result<Vec<ChannelEntry>, Error> {
        let given = self.given.as_ref().map(|(name, _)| name.clone());
        let files: Vec<String> = self
            .names
            .iter()
            .filter(|name| is_channel_file(name) || Some(*name) == given.as_ref())
            .cloned()
            .collect();
        let mut entries = Vec::with_capacity(files.len());
        for file in files {
            let header = self.channel_header(&file, source, limits, findings)?;
            let suffix = suffix_of(&file).unwrap_or_default().to_string();
            let label = header
                .label()
                .unwrap_or_else(|| file.rsplit('/').next().unwrap_or(&file).to_string());
            entries.push(ChannelEntry {
                label: text::shown(&label),
                file,
                suffix,
                header,
            });
        }
        Ok(entries)
    }

    /// Holds the test's list of channels, the `.chn`, against the channel files.
    pub(super) fn list_finding(
        &mut self,
        channels: &[ChannelEntry],
        source: &Reader,
        limits: &Limits,
    ) -> Result<Option<Finding>, Error> {
        const SHOWN: usize = 3;
        let list = self
            .names
            .iter()
            .find(|name| suffix_of(name).is_some_and(|suffix| suffix.eq_ignore_ascii_case("chn")));
        let Some(list) = list.cloned() else {
            return Ok(None);
        };
        let content = self.test_file(&list, source, limits)?;
        let mut differences = list_differences(&content, channels);
        if differences.is_empty() {
            return Ok(None);
        }
        let more = differences.len().saturating_sub(SHOWN);
        differences.truncate(SHOWN);
        if more > 0 {
            differences.push(format!("{more} more"));
        }
        Ok(Some(Finding::warning(
            "list-contradicted",
            format!(
                "{} lists {}; the channel files were believed, but list and files may be of \
                 different tests",
                text::shown(&list),
                differences.join("; ")
            ),
        )))
    }

    /// Reads from the test's header which side of each test object was struck; objects are
    /// named by the character that codes have for them.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Malformed`] if it states two sides of one object.
    pub(super) fn impact_sides(
        &mut self,
        source: &Reader,
        limits: &Limits,
    ) -> Result<BTreeMap<u8, VehicleSide>, Error> {
        let header = self
            .names
            .iter()
            .find(|name| suffix_of(name).is_some_and(|suffix| suffix.eq_ignore_ascii_case("mme")));
        let Some(header) = header.cloned() else {
            return Ok(BTreeMap::new());
        };
        let content = self.test_file(&header, source, limits)?;
        let mut stated: BTreeMap<u8, String> = BTreeMap::new();
        for (number, line) in text::lines(&content) {
            let Some((key, value)) = line.split_once(':') else {
                continue;
            };
            let key = key.trim().to_ascii_uppercase();
            let Some(&[object]) = key
                .strip_prefix("IMPACT SIDE TEST OBJECT")
                .map(|object| object.trim().as_bytes())
            else {
                continue;
            };
            let value = value.trim().to_ascii_lowercase();
            if value.is_empty() || value == "novalue" {
                continue;
            }
            if let Some(other) = stated.get(&object)
                && *other != value
            {
                return Err(Error::from(ErrorKind::Malformed {
                    expected: format!(
                        "one `Impact side test object {}` in the test's header",
                        char::from(object)
                    ),
                    found: format!("`{}` and `{}`", text::shown(other), text::shown(&value)),
                    hint: "which of them holds is not known; mend the header".into(),
                })
                .at(self.place_of(&header).line(number)));
            }
            stated.insert(object, value);
        }
        let side = |value: &str| match value.split(|c: char| !c.is_alphabetic()).next() {
            Some("left" | "le" | "links") => Some(VehicleSide::Left),
            Some("right" | "ri" | "rechts") => Some(VehicleSide::Right),
            _ => None,
        };
        Ok(stated
            .iter()
            .filter_map(|(object, value)| Some((*object, side(value)?)))
            .collect())
    }
}

fn longer_headers(limits: &Limits) -> Error {
    ErrorKind::LimitExceeded {
        limit: "headers_bytes",
        value: limits.headers_bytes,
        found: "more bytes in the headers of the test".into(),
    }
    .into()
}

/// Returns how many bytes of a text that was cut are whole lines, in its encoding.
fn whole_lines(bytes: &[u8]) -> usize {
    let unit = match bytes {
        [0xFF, 0xFE, ..] => Some([b'\n', 0]),
        [0xFE, 0xFF, ..] => Some([0, b'\n']),
        _ => None,
    };
    match unit {
        Some(unit) => bytes
            .chunks_exact(2)
            .rposition(|pair| pair == unit)
            .map_or(2, |at| 2 * (at + 1)),
        // Old Macintosh files have carriage returns alone.
        None => bytes
            .iter()
            .rposition(|byte| matches!(byte, b'\n' | b'\r'))
            .map_or(0, |at| at + 1),
    }
}

/// Lists what a test's list of channels says otherwise than its channel files.
fn list_differences(content: &str, channels: &[ChannelEntry]) -> Vec<String> {
    let files: BTreeMap<u32, &ChannelEntry> = channels
        .iter()
        .filter_map(|entry| Some((number_of(&entry.file)?, entry)))
        .collect();
    let mut differences = Vec::new();
    let mut listed = BTreeSet::new();
    for (key, value) in text::lines(content).filter_map(|(_, line)| line.split_once(':')) {
        let key = key.trim().to_ascii_lowercase();
        let value = value.trim();
        if key == "number of channels" {
            if value
                .parse::<usize>()
                .is_ok_and(|number| number != files.len())
            {
                differences.push(format!("{value} channels for {} files", files.len()));
            }
            continue;
        }
        let number = key.strip_prefix("name of channel").map(str::trim);
        let Some(number) = number.and_then(|number| number.parse::<u32>().ok()) else {
            continue;
        };
        listed.insert(number);
        let code = value.split('/').next().and_then(Code::new);
        match (files.get(&number), code) {
            (None, _) => differences.push(format!("{number:03}, which has no file")),
            (Some(entry), Some(code)) => {
                if let Some(own) = entry.header.code()
                    && !own.agrees_with(&code)
                {
                    differences.push(format!(
                        "{} as {number:03}, whose file says {}",
                        code.text(),
                        own.text()
                    ));
                }
            }
            (Some(_), None) => {}
        }
    }
    if !listed.is_empty() {
        differences.extend(
            files
                .keys()
                .filter(|number| !listed.contains(number))
                .map(|number| format!("nothing as {number:03}, which has a file")),
        );
    }
    differences
}
