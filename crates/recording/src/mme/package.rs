//! The files of a test, wherever they are: in a folder, in an archive, or beside the one given.

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
    /// True if a word is the channel's name, code or file number.
    pub(super) fn is_named(&self, wanted: &str) -> bool {
        let wanted = wanted.trim();
        let number = wanted.parse::<u32>().ok();
        let code = self.header.value("Channel code");
        self.label == wanted
            || code.is_some_and(|code| code.eq_ignore_ascii_case(wanted))
            || self.header.value("Name of the channel") == Some(wanted)
            || (number.is_some() && number == number_of(&self.file))
    }

    /// True if a word means this channel, a pattern of codes included.
    pub(super) fn answers_to(&self, wanted: &str) -> bool {
        let code = self.header.value("Channel code");
        self.is_named(wanted) || code.is_some_and(|code| code::fits(wanted, code))
    }
}

/// Refuses files that are not of one test: which channel goes with which clock would be a guess.
fn check_one_test(names: &[String]) -> Result<(), Error> {
    const LISTED: usize = 8;
    // Of each test, one file that shows it; its own header, if there is one.
    let mut tests: BTreeMap<(String, String), &str> = BTreeMap::new();
    let mut numbers: BTreeMap<u32, &str> = BTreeMap::new();
    for name in names {
        let shows = tests.entry(test_of(name)).or_insert(name);
        if has_suffix(name, "mme") {
            *shows = name;
        }
        if let Some(number) = number_of(name)
            && let Some(other) = numbers.insert(number, name)
            && test_of(other) == test_of(name)
        {
            return Err(Error::malformed(
                "one file for each channel's number",
                format!("{} and {}", text::shown(other), text::shown(name)),
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

/// Returns the files of the test to which the one of a name belongs, itself included.
fn files_of_test(beside: Vec<String>, name: &str) -> Vec<String> {
    let mut names = kept(beside);
    names.retain(|other| test_of(other) == test_of(name));
    if !names.iter().any(|other| other == name) {
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
    /// The one channel file that was given, with its bytes until they are read.
    given: Option<(String, Vec<u8>)>,
    /// Bytes of headers read so far.
    header_bytes: u64,
    /// The two files that were used last, a channel and its times, with their samples or what is
    /// wrong with these.
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
            // Others are of use only for an explicit time, so that a large folder does no harm.
            let beside = source.list(false, limits).unwrap_or_default();
            package.names = files_of_test(beside, &name);
            package.given = Some((name, bytes));
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

    /// Returns the name of the one channel file that was given.
    pub(super) fn given(&self) -> Option<&str> {
        self.given.as_ref().map(|(name, _)| name.as_str())
    }

    /// True if the files are parts of the recording: not those of an archive, nor the one
    /// that was given.
    pub(super) fn is_part(&self, name: &str) -> bool {
        self.archive.is_none() && self.given() != Some(name)
    }

    /// Reads the samples of a channel file; within, what is wrong with the samples themselves.
    pub(super) fn samples(
        &mut self,
        name: &str,
        source: &mut Reader,
        limits: &Limits,
    ) -> Result<Result<Rc<Samples>, Error>, Error> {
        if let Some(at) = self.recent.iter().position(|(file, _)| file == name) {
            let used = self.recent.remove(at);
            self.recent.push(used.clone());
            return Ok(used.1);
        }
        let given = self.given.as_mut().filter(|(given, _)| given == name);
        let bytes = match given {
            // It is needed once, for it is no channel of times of its own.
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

    /// Reads up to `most` bytes from the start of a file, and decodes them; tells whether there is
    /// more.
    fn head(
        &self,
        name: &str,
        most: u64,
        source: &Reader,
        limits: &Limits,
        findings: &mut Vec<Finding>,
    ) -> Result<(String, bool), Error> {
        let room = most.saturating_add(1);
        let mut bytes = match &self.given {
            Some((given, bytes)) if given == name => {
                let room = usize::try_from(room).unwrap_or(usize::MAX);
                bytes[..bytes.len().min(room)].to_vec()
            }
            _ => source
                .read_head_of(name, room)
                .map_err(|error| error.at(self.place_of(name)))?
                .unwrap_or_default(),
        };
        let is_cut = bytes.len() as u64 > most;
        if is_cut {
            bytes.truncate(whole_lines(&bytes));
        }
        let (bytes, found) =
            encoding::decode(bytes, limits).map_err(|error| error.at(self.place_of(name)))?;
        for finding in found {
            if !findings.contains(&finding) {
                findings.push(finding);
            }
        }
        Ok((String::from_utf8_lossy(&bytes).into_owned(), is_cut))
    }

    /// Reads the test's own file with a suffix, its header or its list, if there is one.
    fn test_file(
        &self,
        suffix: &str,
        source: &Reader,
        limits: &Limits,
    ) -> Result<Option<(String, String)>, Error> {
        let Some(name) = self.names.iter().find(|name| has_suffix(name, suffix)) else {
            return Ok(None);
        };
        let most = limits.headers_bytes;
        let (content, is_cut) = self.head(name, most, source, limits, &mut Vec::new())?;
        if is_cut {
            let place = self.place_of(name).byte(most);
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
        let is_channel = |name: &&String| is_channel_file(name) || self.given() == Some(name);
        let files: Vec<String> = self.names.iter().filter(is_channel).cloned().collect();
        let mut entries: Vec<ChannelEntry> = Vec::with_capacity(files.len());
        for file in files {
            let most = limits.header_bytes;
            let (content, is_cut) = self.head(&file, most, source, limits, findings)?;
            let header = ChannelHeader::read(&content);
            if is_cut && !header.is_whole() {
                let place = self.place_of(&file).byte(most);
                return Err(limits.over("header_bytes", ENDLESS).at(place));
            }
            self.header_bytes += header.bytes();
            if self.header_bytes > limits.headers_bytes {
                let place = self.place_of(&file).byte(header.bytes());
                return Err(limits.over("headers_bytes", ENDLESS).at(place));
            }
            let own = || file.rsplit('/').next().unwrap_or(&file).to_string();
            let label = text::shown(header.label().unwrap_or_else(own));
            entries.push(ChannelEntry {
                label,
                file,
                header,
            });
        }
        name_twins(&mut entries);
        Ok(entries)
    }

    /// Says why a test without a channel file cannot be read.
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

    /// Holds the test's list of channels, the `.chn`, against the channel files.
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

    /// Reads the test's own header, the `.mme`; one that is not there says nothing.
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

/// What is found where a header crosses a limit.
const ENDLESS: &str = "no end of the header after as many bytes";

/// Returns how many bytes of a text that was cut are whole lines, in its encoding.
fn whole_lines(bytes: &[u8]) -> usize {
    let feed = match bytes {
        [0xFF, 0xFE, ..] => &[b'\n', 0],
        [0xFE, 0xFF, ..] => &[0, b'\n'],
        // Old Macintosh files have carriage returns alone.
        _ => {
            let end = |byte: &u8| matches!(byte, b'\n' | b'\r');
            return bytes.iter().rposition(end).map_or(0, |at| at + 1);
        }
    };
    let pairs = bytes.chunks_exact(2).rposition(|pair| pair == feed);
    pairs.map_or(2, |at| 2 * (at + 1))
}

/// Lists what a test's list of channels says otherwise than its channel files.
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
                if let Some(own) = entry.header.code().filter(|own| !own.agrees_with(code)) {
                    differences.push(format!("{number:03} ({} and {})", code.text(), own.text()));
                }
            }
            (Some(None), Some(_)) => {}
            _ => differences.push(format!("{number:03} (there once)")),
        }
    }
    differences
}
