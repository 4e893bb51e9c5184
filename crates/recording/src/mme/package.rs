//! The files of a test: in a folder, in an archive, or beside the recording.

use super::channel::{ChannelHeader, Samples, looks_like_channel};
use super::header::TestHeader;
use super::names::{has_suffix, is_channel_file, kept, number_of, suffix_of, test_of};
use crate::code::{self, Code};
use crate::error::{Error, ErrorKind, Place};
use crate::source::Reader;
use crate::{Finding, Limits, encoding, text};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// A channel of the test.
#[derive(Debug)]
pub(super) struct ChannelEntry {
    /// File, as the package names it.
    pub(super) file: String,
    /// Name for people: code, or name if there is no code; with the file's number if it has a twin.
    pub(super) label: String,
    pub(super) header: ChannelHeader,
}

impl ChannelEntry {
    /// True if a requested name is the channel's name, code or file number.
    pub(super) fn is_named(&self, requested: &str) -> bool {
        let requested = requested.trim();
        let number = requested.parse::<u32>().ok();
        let code = self.header.value("Channel code");
        self.label == requested
            || code.is_some_and(|code| code.eq_ignore_ascii_case(requested))
            || self.header.value("Name of the channel") == Some(requested)
            || (number.is_some() && number == number_of(&self.file))
    }

    /// True if a requested name means this channel, a pattern of codes included.
    pub(super) fn answers_to(&self, requested: &str) -> bool {
        let code = self.header.value("Channel code");
        self.is_named(requested) || code.is_some_and(|code| code::fits(requested, code))
    }
}

/// Refuses files that are not of one test: the clock of each channel would be a guess.
fn check_one_test(names: &[String]) -> Result<(), Error> {
    const LISTED: usize = 8;
    // For each test, one file that names it: its header, if there is one.
    let mut tests: BTreeMap<(String, String), &str> = BTreeMap::new();
    let mut numbers: BTreeMap<u32, &str> = BTreeMap::new();
    for name in names {
        let shown_file = tests.entry(test_of(name)).or_insert(name);
        if has_suffix(name, "mme") {
            *shown_file = name;
        }
        if let Some(number) = number_of(name)
            && let Some(twin) = numbers.insert(number, name)
            && test_of(twin) == test_of(name)
        {
            return Err(Error::malformed(
                "one file for each channel's number",
                format!("{} and {}", text::shown(twin), text::shown(name)),
                "keep the one that belongs to the test",
            ));
        }
    }
    if tests.len() <= 1 {
        return Ok(());
    }
    let shown = tests.values().take(LISTED).map(text::shown);
    let shown: Vec<String> = shown.collect();
    let found = format!("those of {}: {}", tests.len(), shown.join(", "));
    Err(Error::malformed(
        "the files of one test, which share folder and stem",
        found,
        "name the .mme file of one test, or one channel file; unpack an archive first",
    ))
}

/// Returns the files of the test to which the file `name` belongs, itself included.
fn files_of_test(beside: Vec<String>, name: &str) -> Vec<String> {
    let mut names = kept(beside);
    names.retain(|file| test_of(file) == test_of(name));
    if !names.iter().any(|file| file == name) {
        names.push(name.to_string());
    }
    names
}

/// The files of a test.
#[derive(Default)]
pub(super) struct Package {
    /// Names of the test's files, in order.
    names: Vec<String>,
    /// Name of the archive that holds them.
    archive: Option<String>,
    /// The one channel file that is the recording, with its bytes until they are read.
    opened: Option<(String, Vec<u8>)>,
    /// Bytes of headers read so far.
    header_bytes: u64,
    /// The two files that were used last, a channel and its times, with their samples or the error of
    /// reading them. More would fill memory, and fewer would read the times again for each channel.
    recent: Vec<(String, Result<Rc<Samples>, Error>)>,
}

impl Package {
    pub(super) fn open(source: &mut Reader, limits: &Limits) -> Result<Self, Error> {
        let mut package = Self::default();
        let name = source.name().to_string();
        let (head, is_folder) = (source.head()?, source.is_folder());
        if source.is_archive() {
            package.names = kept(source.list(true, limits)?);
            package.archive = Some(name);
        } else if !is_folder && looks_like_channel(&head) {
            let bytes = source.read_text(limits)?;
            // Other files are needed only for an explicit time, so a folder too large to list is no error.
            let beside = source.list(false, limits).unwrap_or_default();
            package.names = files_of_test(beside, &name);
            package.opened = Some((name, bytes));
            return Ok(package);
        } else if is_folder {
            package.names = kept(source.list(true, limits)?);
        } else {
            package.names = files_of_test(source.list(true, limits)?, &name);
        }
        check_one_test(&package.names)?;
        Ok(package)
    }

    /// Names a file for a message, with the archive that holds it.
    pub(super) fn place_of(&self, name: &str) -> Place {
        Place::file(match &self.archive {
            Some(archive) => format!("{archive}: {name}"),
            None => name.to_string(),
        })
    }

    /// Returns the name of the one channel file that is the recording.
    pub(super) fn opened_file(&self) -> Option<&str> {
        self.opened.as_ref().map(|(name, _)| name.as_str())
    }

    /// True if a file is a part of the recording: not one of an archive, nor the recording itself.
    pub(super) fn is_part(&self, name: &str) -> bool {
        self.archive.is_none() && self.opened_file() != Some(name)
    }

    /// Reads the samples of a channel file. The inner error is one of the samples themselves.
    pub(super) fn samples(
        &mut self,
        name: &str,
        source: &mut Reader,
        limits: &Limits,
    ) -> Result<Result<Rc<Samples>, Error>, Error> {
        if let Some(position) = self.recent.iter().position(|(file, _)| file == name) {
            let entry = self.recent.remove(position);
            self.recent.push(entry.clone());
            return Ok(entry.1);
        }
        let opened = self.opened.as_mut().filter(|(file, _)| file == name);
        let bytes = match opened {
            // Its bytes are needed only once: it is not its own channel of times.
            Some((_, bytes)) => std::mem::take(bytes),
            None => {
                let absent = || Error::io("read the test", &format!("{name} is missing"));
                let read = source.read_beside(name, limits);
                let read = read.and_then(|bytes| bytes.ok_or_else(absent));
                read.map_err(|error| error.at(self.place_of(name)))?
            }
        };
        let samples = Samples::read(bytes, limits).map(Rc::new);
        self.recent.drain(..self.recent.len().saturating_sub(1));
        self.recent.push((name.to_string(), samples.clone()));
        Ok(samples)
    }

    /// Reads up to `limit` bytes from the start of a file, and decodes them; the result is true if there are
    /// more.
    fn head(
        &self,
        name: &str,
        limit: u64,
        source: &Reader,
        limits: &Limits,
        findings: &mut Vec<Finding>,
    ) -> Result<(String, bool), Error> {
        let room = limit.saturating_add(1);
        let mut bytes = match &self.opened {
            Some((file, bytes)) if file == name => {
                let room = usize::try_from(room).unwrap_or(usize::MAX);
                bytes[..bytes.len().min(room)].to_vec()
            }
            _ => source
                .read_head_of(name, room)
                .map_err(|error| error.at(self.place_of(name)))?
                .unwrap_or_default(),
        };
        let is_cut = bytes.len() as u64 > limit;
        if is_cut {
            bytes.truncate(whole_lines(&bytes));
        }
        let (bytes, decoding_findings) =
            encoding::decode(bytes, limits).map_err(|error| error.at(self.place_of(name)))?;
        for finding in decoding_findings {
            if !findings.contains(&finding) {
                findings.push(finding);
            }
        }
        Ok((String::from_utf8_lossy(&bytes).into_owned(), is_cut))
    }

    /// Reads the test's file with a suffix, its header or its list, if there is one.
    fn test_file(
        &self,
        suffix: &str,
        source: &Reader,
        limits: &Limits,
    ) -> Result<Option<(String, String)>, Error> {
        let Some(name) = self.names.iter().find(|name| has_suffix(name, suffix)) else {
            return Ok(None);
        };
        let limit = limits.headers_bytes;
        let (content, is_cut) = self.head(name, limit, source, limits, &mut Vec::new())?;
        if is_cut {
            let place = self.place_of(name).byte(limit);
            return Err(limits.over("headers_bytes", ENDLESS).at(place));
        }
        Ok(Some((name.clone(), content)))
    }

    /// Reads the headers of all channels.
    pub(super) fn channels(
        &mut self,
        source: &Reader,
        limits: &Limits,
        findings: &mut Vec<Finding>,
    ) -> Result<Vec<ChannelEntry>, Error> {
        let is_channel = |name: &&String| is_channel_file(name) || self.opened_file() == Some(name);
        let files: Vec<String> = self.names.iter().filter(is_channel).cloned().collect();
        let mut entries: Vec<ChannelEntry> = Vec::with_capacity(files.len());
        for file in files {
            let limit = limits.header_bytes;
            let (content, is_cut) = self.head(&file, limit, source, limits, findings)?;
            let header = ChannelHeader::read(&content);
            if is_cut && !header.is_whole() {
                let place = self.place_of(&file).byte(limit);
                return Err(limits.over("header_bytes", ENDLESS).at(place));
            }
            self.header_bytes += header.bytes();
            if self.header_bytes > limits.headers_bytes {
                let place = self.place_of(&file).byte(header.bytes());
                return Err(limits.over("headers_bytes", ENDLESS).at(place));
            }
            let file_name = || file.rsplit('/').next().unwrap_or(&file).to_string();
            let label = text::shown(header.label().unwrap_or_else(file_name));
            entries.push(ChannelEntry {
                label,
                file,
                header,
            });
        }
        name_twins(&mut entries);
        Ok(entries)
    }

    /// Returns the error of a test without a channel file.
    pub(super) fn without_channels(&self) -> Error {
        let inner = self.names.iter().find_map(|name| name.split_once('/'));
        let inner = inner.filter(|(folder, _)| !folder.eq_ignore_ascii_case("channel"));
        let known = match inner {
            Some((folder, _)) => format!(
                "no channel file, but the test lies in {}: name that folder",
                text::shown(folder)
            ),
            None => "no channel file of the test's stem".into(),
        };
        ErrorKind::NoChannel { known }.into()
    }

    /// Compares the test's list of channels, the `.chn`, with the channel files.
    pub(super) fn list_finding(
        &self,
        channels: &[ChannelEntry],
        source: &Reader,
        limits: &Limits,
    ) -> Result<Option<Finding>, Error> {
        const SHOWN: usize = 3;
        let Some((list, content)) = self.test_file("chn", source, limits)? else {
            return Ok(None);
        };
        let mut differences = list_differences(&content, channels);
        let more = differences.len().saturating_sub(SHOWN);
        differences.truncate(SHOWN);
        differences.extend((more > 0).then(|| format!("{more} more")));
        Ok((!differences.is_empty()).then(|| {
            let text = format!(
                "{} and the channel files differ in {}. The files were used. Check that list and \
                 files are of one test",
                text::shown(&list),
                differences.join(", ")
            );
            Finding::warning("list-contradicted", text)
        }))
    }

    /// Reads the test's header, the `.mme`; an empty one if there is none.
    pub(super) fn test_header(
        &self,
        source: &Reader,
        limits: &Limits,
        findings: &mut Vec<Finding>,
    ) -> Result<TestHeader, Error> {
        let file = self.test_file("mme", source, limits)?;
        let Some((file, content)) = file else {
            return Ok(TestHeader::default());
        };
        let mut header = TestHeader::read(&content, findings);
        header.file = Some(file);
        Ok(header)
    }
}

/// Gives channels that share a code the number of their file.
fn name_twins(channels: &mut [ChannelEntry]) {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for entry in channels.iter() {
        *counts.entry(entry.label.clone()).or_default() += 1;
    }
    for entry in channels.iter_mut().filter(|entry| counts[&entry.label] > 1) {
        let suffix = suffix_of(&entry.file).unwrap_or_default();
        entry.label = format!("{} (file {suffix})", entry.label);
    }
}

/// Text of the error where a header crosses a limit.
const ENDLESS: &str = "no end of the header after as many bytes";

/// Returns the number of bytes in whole lines of a text that was cut, in its encoding.
fn whole_lines(bytes: &[u8]) -> usize {
    let feed = match bytes {
        [0xFF, 0xFE, ..] => &[b'\n', 0],
        [0xFE, 0xFF, ..] => &[0, b'\n'],
        // Old Macintosh files have carriage returns alone.
        _ => {
            let end = |byte: &u8| matches!(byte, b'\n' | b'\r');
            return bytes.iter().rposition(end).map_or(0, |index| index + 1);
        }
    };
    let pairs = bytes.chunks_exact(2).rposition(|pair| pair == feed);
    pairs.map_or(2, |index| 2 * (index + 1))
}

/// Lists the differences between a test's list of channels and its channel files.
fn list_differences(content: &str, channels: &[ChannelEntry]) -> Vec<String> {
    let mut differences = Vec::new();
    let mut listed: BTreeMap<u32, Option<Code>> = BTreeMap::new();
    for (key, value) in text::lines(content).filter_map(|(_, line)| line.split_once(':')) {
        let (key, value) = (key.trim().to_ascii_lowercase(), value.trim());
        let number = value.parse::<usize>();
        if key == "number of channels" && number.is_ok_and(|number| number != channels.len()) {
            differences.push(format!("their number ({value} and {})", channels.len()));
        }
        let number = key.strip_prefix("name of channel").map(str::trim);
        if let Some(number) = number.and_then(|number| number.parse().ok()) {
            listed.insert(number, value.split('/').next().and_then(Code::new));
        }
    }
    let files = channels
        .iter()
        .filter_map(|entry| Some((number_of(&entry.file)?, entry)));
    let files: BTreeMap<u32, &ChannelEntry> = files.collect();
    let numbers: BTreeSet<u32> = listed.keys().chain(files.keys()).copied().collect();
    for number in numbers.into_iter().filter(|_| !listed.is_empty()) {
        match (listed.get(&number), files.get(&number)) {
            (Some(Some(code)), Some(entry)) => {
                if let Some(file_code) = entry.header.code().filter(|own| !own.agrees_with(code)) {
                    differences.push(format!(
                        "{number:03} ({} and {})",
                        code.text(),
                        file_code.text()
                    ));
                }
            }
            (Some(None), Some(_)) => {}
            _ => differences.push(format!("{number:03} (there once)")),
        }
    }
    differences
}
