//! The files of a test, wherever they are: in a folder, in an archive, or beside the one given.

use super::archive::{Archive, is_archive};
use super::channel::{ChannelHeader, looks_like_channel};
use super::code::{self, Side};
use super::{encoding, text};
use crate::error::{Error, ErrorKind, Place};
use crate::recording::source::Reader;
use crate::recording::{Finding, Limits};

/// Bytes at the start of a channel file in which its header ends.
const HEADER_BYTES: u64 = 64 << 10;

/// Bytes up to which the one channel file that was given may be held twice.
const HELD_TWICE: usize = 16 << 20;

/// A channel of the test.
#[derive(Debug)]
pub(super) struct Entry {
    /// File, as the package names it.
    pub(super) file: String,
    /// The file's number as its suffix has it: `003`.
    pub(super) suffix: String,
    /// Name for people: code, or name if there is no code.
    pub(super) label: String,
    pub(super) header: ChannelHeader,
}

impl Entry {
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

/// Tells whether a name is that of a test's header or channel list.
pub(super) fn is_test_file(name: &str) -> bool {
    suffix_of(name).is_some_and(|suffix| {
        suffix.eq_ignore_ascii_case("mme") || suffix.eq_ignore_ascii_case("chn")
    })
}

fn suffix_of(name: &str) -> Option<&str> {
    let file = name.rsplit('/').next()?;
    let (stem, suffix) = file.rsplit_once('.')?;
    (!stem.is_empty()).then_some(suffix)
}

/// Tells whether a name is that of a channel file: a suffix of three digits or more.
pub(super) fn is_channel_file(name: &str) -> bool {
    suffix_of(name)
        .is_some_and(|suffix| suffix.len() >= 3 && suffix.bytes().all(|byte| byte.is_ascii_digit()))
}

/// The files of a test.
pub(super) struct Package {
    /// Names of the test's files, in order.
    names: Vec<String>,
    place: Where,
    /// The one channel file that was given, with its bytes.
    given: Option<(String, Vec<u8>)>,
}

enum Where {
    Beside,
    Archive(Box<Archive>),
}

impl Package {
    pub(super) fn open(source: &mut Reader, limits: &Limits) -> Result<Self, Error> {
        if source.is_folder() {
            return Ok(Self {
                names: kept(source.list(true, limits)?),
                place: Where::Beside,
                given: None,
            });
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
            return Ok(Self {
                names,
                place: Where::Archive(Box::new(archive)),
                given: None,
            });
        }
        if looks_like_channel(&head) {
            let bytes = source.read_text(limits)?;
            let name = source.name().to_string();
            // Others are of use only for an explicit time, so that a large folder does no harm.
            let mut names = kept(source.list(false, limits).unwrap_or_default());
            let stem = |name: &str| name.rsplit_once('.').map(|(stem, _)| stem.to_lowercase());
            names.retain(|other| stem(other) == stem(&name));
            if !names.contains(&name) {
                names.push(name.clone());
            }
            return Ok(Self {
                names,
                place: Where::Beside,
                given: Some((name, bytes)),
            });
        }
        Ok(Self {
            names: kept(source.list(true, limits)?),
            place: Where::Beside,
            given: None,
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

    /// Reads a file whole, within limits.
    pub(super) fn whole(
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
        match &mut self.place {
            Where::Beside => source.read_beside(name, limits)?.ok_or_else(|| {
                ErrorKind::Io {
                    action: "read the test",
                    reason: format!("{name} is not there"),
                }
                .into()
            }),
            Where::Archive(archive) => archive.read(name, limits.unpacked_bytes, limits),
        }
        .map_err(|error: Error| error.at(Place::file(name)))
    }

    fn head(&mut self, name: &str, source: &Reader, limits: &Limits) -> Result<Vec<u8>, Error> {
        if let Some((given, bytes)) = &self.given
            && given == name
        {
            let end = bytes.len().min(64 << 10);
            return Ok(bytes[..end].to_vec());
        }
        match &mut self.place {
            Where::Beside => source
                .read_head_of(name, HEADER_BYTES)
                .map(Option::unwrap_or_default),
            Where::Archive(archive) => archive.head(name, HEADER_BYTES, limits),
        }
        .map_err(|error| error.at(Place::file(name)))
    }

    /// Reads the start of a file as text.
    fn head_text(
        &mut self,
        name: &str,
        source: &Reader,
        limits: &Limits,
        findings: &mut Vec<Finding>,
    ) -> Result<String, Error> {
        let mut bytes = self.head(name, source, limits)?;
        if bytes.len() as u64 >= HEADER_BYTES {
            let end = bytes
                .iter()
                .rposition(|byte| *byte == b'\n')
                .map_or(0, |at| at + 1);
            bytes.truncate(end);
        }
        let (bytes, found) =
            encoding::decode(bytes, limits).map_err(|error| error.at(Place::file(name)))?;
        for finding in found {
            if !findings.contains(&finding) {
                findings.push(finding);
            }
        }
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }

    /// Reads the headers of all channels.
    pub(super) fn channels(
        &mut self,
        source: &Reader,
        limits: &Limits,
        findings: &mut Vec<Finding>,
    ) -> Result<Vec<Entry>, Error> {
        let given = self.given.as_ref().map(|(name, _)| name.clone());
        let files: Vec<String> = self
            .names
            .iter()
            .filter(|name| is_channel_file(name) || Some(*name) == given.as_ref())
            .cloned()
            .collect();
        let mut entries = Vec::with_capacity(files.len());
        for file in files {
            let header = ChannelHeader::read(&self.head_text(&file, source, limits, findings)?);
            let suffix = suffix_of(&file).unwrap_or_default().to_string();
            let label = header
                .label()
                .unwrap_or_else(|| file.rsplit('/').next().unwrap_or(&file).to_string());
            entries.push(Entry {
                label: text::shown(&label),
                file,
                suffix,
                header,
            });
        }
        Ok(entries)
    }

    /// Reads from the test's header which side was struck.
    pub(super) fn impact_side(
        &mut self,
        source: &Reader,
        limits: &Limits,
    ) -> Result<Option<Side>, Error> {
        let header = self
            .names
            .iter()
            .find(|name| suffix_of(name).is_some_and(|suffix| suffix.eq_ignore_ascii_case("mme")));
        let Some(header) = header.cloned() else {
            return Ok(None);
        };
        let content = self.head_text(&header, source, limits, &mut Vec::new())?;
        let side = text::lines(&content)
            .filter_map(|(_, line)| line.split_once(':'))
            .find(|(key, _)| key.trim().eq_ignore_ascii_case("Impact side test object 1"))
            .map(|(_, value)| value.trim().to_ascii_lowercase());
        Ok(match side.as_deref() {
            Some("left" | "le" | "links") => Some(Side::Left),
            Some("right" | "ri" | "rechts") => Some(Side::Right),
            _ => None,
        })
    }
}

/// Keeps the names of the test's header, list and channels.
fn kept(mut names: Vec<String>) -> Vec<String> {
    names.retain(|name| is_test_file(name) || is_channel_file(name));
    names.sort();
    names
}
