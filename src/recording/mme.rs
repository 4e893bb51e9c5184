//! ISO/TS 13499 (ISO-MME): a test as folder, .zip, .tar.gz or .tar, or one channel of it.
//!
//! A channel is a file of its own: header lines `Key :value`, then one value a line. Its code
//! of 16 characters says where it was measured, in which direction and how it was filtered.
//! Codes may come twice, so channels are told apart by file. What the header states of the
//! samples (their number, extremes and the times of these) serves as a checksum.
//!
//! # Source
//!
//! ISO/TS 13499 and its related electronic document B (codes), as far as they show in the files.
//!
//! - `archive`: archives: .zip, .tar.gz and .tar, read within limits;
//! - `channel`: channel files: header and samples;
//! - `code`: channel codes: 16 characters that say what was measured where;
//! - `names`: names of a test's files: which are its header, its list and its channels;
//! - `package`: the files of a test, wherever they are: in a folder, in an archive, or beside the
//!   one given.

mod archive;
mod channel;
pub(super) mod code;
mod names;
mod package;

use super::draft::{self, Draft, UniformSamples, Unit};
use super::source::Reader;
use super::time_base::TimeBase;
use super::{
    Channel, Finding, Head, Limits, Outcomes, ReadOptions, ReadOutcome, Selection, encoding, text,
};
use crate::error::{Candidates, Error, ErrorKind, Place};
use crate::units::{SampleRate, TimeUnit};
use channel::{ChannelHeader, Samples};
use package::{ChannelEntry, Package};
use std::collections::BTreeMap;

/// Recognises archives, folders with an .mme or .chn file, and single files of a test.
#[must_use]
pub fn recognises(head: &Head<'_>) -> bool {
    if head.is_folder {
        return head.entries.iter().any(|name| names::is_test_file(name));
    }
    archive::is_archive(head.bytes)
        || (encoding::looks_like_text(head.bytes)
            && (names::is_test_file(head.file_name) || channel::looks_like_channel(head.bytes)))
}

/// Reads channels of a test.
///
/// `ReadOptions::channel` names a channel by its code, by a pattern of it (`?` for one
/// character, `[Y2]` for one of several, `*` for any), or by the number of its file.
///
/// # Errors
///
/// - [`ErrorKind::RefusedFormat`] for an archive without a test,
/// - [`ErrorKind::NoSuchChannel`], [`ErrorKind::AmbiguousChannel`], [`ErrorKind::NoChannel`],
/// - [`ErrorKind::MissingTime`], [`ErrorKind::MissingUnit`] where header and options say nothing,
/// - [`ErrorKind::Malformed`], [`ErrorKind::Truncated`] or [`ErrorKind::NonFinite`] for damage,
///   [`ErrorKind::LimitExceeded`] beyond a limit, at the byte where it was crossed.
pub fn read(
    source: &mut Reader,
    options: &ReadOptions,
    selections: &[Selection],
    limits: &Limits,
) -> Result<Outcomes, Error> {
    options.refuse_other_clock("an ISO-MME package", "")?;
    let mut package = Package::open(source, limits)?;
    let mut findings = Vec::new();
    let sides = package.impact_sides(source, limits)?;
    let mut channels = package.channels(source, limits, &mut findings)?;
    name_twins(&mut channels);
    let listed = package.list_finding(&channels, source, limits)?;
    findings.extend(listed);
    if channels.is_empty() {
        return Err(package.without_channels());
    }
    let mut outcomes = Vec::with_capacity(selections.len());
    for selection in selections {
        let mut outcome = ReadOutcome {
            findings: findings.clone(),
            ..ReadOutcome::default()
        };
        // The chosen channel is one of all, whose file is not read again for them.
        package.begin(*selection == Selection::Lateral);
        let choice = selected(&package, &channels, &sides, options, *selection);
        let read = choice.and_then(|(wanted, finding)| {
            outcome.findings.extend(finding);
            let mut test = TestReader {
                package: &mut package,
                source: &mut *source,
                channels: &channels,
                options,
                selection: *selection,
                limits,
            };
            test.read(&wanted, &mut outcome)
        });
        outcome.parts = package.parts();
        outcomes.push(read.map(|()| outcome));
    }
    Ok(outcomes)
}

/// Returns the channels to read, and what is to be said about the choice.
fn selected(
    package: &Package,
    channels: &[ChannelEntry],
    sides: &BTreeMap<u8, code::VehicleSide>,
    options: &ReadOptions,
    selection: Selection,
) -> Result<(Vec<usize>, Option<Finding>), Error> {
    if let Some(index) = package.only_channel() {
        check_named(&channels[index], options)?;
        let finding = channels[index].header.not_lateral_finding();
        return Ok((
            vec![index],
            finding.filter(|_| selection == Selection::Lateral),
        ));
    }
    if selection == Selection::Every {
        return Ok(((0..channels.len()).collect(), None));
    }
    let (index, finding) = choose(channels, sides, options)?;
    Ok((vec![index], finding))
}

/// A test whose channels are read for one selection.
struct TestReader<'a, 'r> {
    package: &'a mut Package,
    source: &'a mut Reader<'r>,
    channels: &'a [ChannelEntry],
    options: &'a ReadOptions,
    selection: Selection,
    limits: &'a Limits,
}

impl TestReader<'_, '_> {
    /// Reads the channels into `outcome`.
    fn read(&mut self, wanted: &[usize], outcome: &mut ReadOutcome) -> Result<(), Error> {
        let limits = self.limits;
        let more = || {
            Error::from(ErrorKind::LimitExceeded {
                limit: "test_samples",
                value: limits.test_samples,
                found: "more samples in all channels".into(),
            })
        };
        // What headers announce ends it before anything is unpacked; what they do not, after.
        let mut announced = 0.0;
        for index in wanted {
            let entry = &self.channels[*index];
            announced += entry.header.announced().min(to_float(limits.samples));
            if announced > to_float(limits.test_samples) && self.selection == Selection::Every {
                return Err(more().at(Place::default().channel(entry.label.clone())));
            }
        }
        let mut cells = 0_u64;
        for index in wanted {
            let entry = &self.channels[*index];
            let place = Place::default().channel(entry.label.clone());
            match self.channel(*index) {
                Ok(Some(channel)) => {
                    cells += channel.values.len() as u64;
                    if cells > limits.test_samples {
                        return Err(more().at(place));
                    }
                    outcome.channels.push(channel);
                }
                // A time channel serves others.
                Ok(None) => {}
                Err(error)
                    if self.selection == Selection::Every
                        && !matches!(error.kind(), ErrorKind::LimitExceeded { .. }) =>
                {
                    outcome.findings.push(draft::left_out(&entry.label, &error));
                }
                Err(error) => return Err(error.at(place)),
            }
        }
        Ok(())
    }
}

/// Refuses a name that the one channel file given does not bear.
fn check_named(entry: &ChannelEntry, options: &ReadOptions) -> Result<(), Error> {
    match &options.channel {
        Some(wanted) if !entry.answers_to(wanted) => Err(ErrorKind::NoSuchChannel {
            wanted: wanted.clone(),
            known: entry.label.clone(),
        }
        .into()),
        _ => Ok(()),
    }
}

/// Gives channels that share a code the number of their file.
fn name_twins(channels: &mut [ChannelEntry]) {
    let labels: Vec<String> = channels.iter().map(|entry| entry.label.clone()).collect();
    for (index, entry) in channels.iter_mut().enumerate() {
        let twins = labels
            .iter()
            .enumerate()
            .any(|(other, label)| other != index && *label == labels[index]);
        if twins {
            entry.label = format!("{} (file {})", entry.label, entry.suffix);
        }
    }
}

/// Lists channels for a message.
fn list<'a>(entries: impl Iterator<Item = &'a ChannelEntry>) -> String {
    const LISTED: usize = 40;
    let mut names: Vec<String> = entries.map(|entry| entry.label.clone()).collect();
    let more = names.len().saturating_sub(LISTED);
    names.truncate(LISTED);
    if more > 0 {
        names.push(format!("{more} more"));
    }
    names.join(", ")
}

/// Chooses the channel that is meant.
fn choose(
    channels: &[ChannelEntry],
    sides: &BTreeMap<u8, code::VehicleSide>,
    options: &ReadOptions,
) -> Result<(usize, Option<Finding>), Error> {
    if let Some(wanted) = &options.channel {
        return named(channels, wanted);
    }
    let of = |wanted: &dyn Fn(&ChannelEntry) -> bool| -> Vec<usize> {
        (0..channels.len())
            .filter(|index| wanted(&channels[*index]))
            .collect()
    };
    let accelerations = of(&|entry| entry.header.is_acceleration());
    let none = || {
        Error::from(ErrorKind::NoChannel {
            known: list(channels.iter()),
        })
    };
    // A code says what a channel is; only a name that is no code leaves it open.
    let alone = accelerations.len() == 1;
    if alone {
        let header = &channels[accelerations[0]].header;
        if header.code().is_none() {
            return match header.said_elsewhere() {
                Some(_) => Err(none()),
                None => Ok((accelerations[0], header.not_lateral_finding())),
            };
        }
    }
    let coded = |index: &usize| channels[*index].header.code();
    let mut objects: BTreeMap<u8, Vec<usize>> = BTreeMap::new();
    for index in 0..channels.len() {
        if let Some(code) = coded(&index).filter(|code| code.is_lateral() && code.is_structure()) {
            objects.entry(code.object()).or_default().push(index);
        }
    }
    // Of several test objects, the one whose struck side is stated, if it alone is.
    if objects
        .keys()
        .filter(|object| sides.contains_key(*object))
        .count()
        == 1
    {
        objects.retain(|object, _| sides.contains_key(object));
    }
    // Places are weighed within one object: those of two vehicles are no alternatives.
    let mut by_side = "";
    let mut candidates = Vec::new();
    for (object, mut found) in objects {
        let side = sides.get(&object);
        if preferred(channels, &mut found, side.copied()) {
            by_side = " on the struck side";
        }
        candidates.extend(found);
    }
    candidates.sort_unstable();
    let only = match candidates.as_slice() {
        [only] => *only,
        [] => return Err(none()),
        several => return Err(ambiguous(channels, several)),
    };
    let count = (!alone).then_some(accelerations.len());
    Ok((only, choice_finding(&channels[only], sides, count, by_side)))
}

/// Says what was weighed in the choice: among how many channels of acceleration, if it was not the
/// only one, and whether it lies `by_side` of the impact or on the other.
fn choice_finding(
    chosen: &ChannelEntry,
    sides: &BTreeMap<u8, code::VehicleSide>,
    count: Option<usize>,
    by_side: &str,
) -> Option<Finding> {
    let label = &chosen.label;
    let far = chosen.header.code().is_some_and(|code| {
        let struck = sides.get(&code.object());
        code.side()
            .is_some_and(|side| struck.is_some_and(|struck| *struck != side))
    });
    if far {
        return Some(Finding::warning(
            "side-not-struck",
            format!(
                "{label} was chosen as the one lateral acceleration of the structure, but it lies \
                 on the side that was not struck, as the test's header says: the struck side \
                 moved more"
            ),
        ));
    }
    let count = count?;
    Some(Finding::info(
        "channel-chosen",
        format!(
            "{label} was chosen among {count} channels of acceleration as the one lateral \
             acceleration of the structure{by_side}"
        ),
    ))
}

/// Finds the channel of a name or pattern.
fn named(channels: &[ChannelEntry], wanted: &str) -> Result<(usize, Option<Finding>), Error> {
    let of = |fits: &dyn Fn(&ChannelEntry) -> bool| -> Vec<usize> {
        (0..channels.len())
            .filter(|index| fits(&channels[*index]))
            .collect()
    };
    // A literal name comes before a pattern: codes may hold question marks.
    let mut found = of(&|entry| entry.is_named(wanted));
    if found.is_empty() {
        found = of(&|entry| entry.answers_to(wanted));
    }
    match found.as_slice() {
        [only] => Ok((*only, channels[*only].header.not_lateral_finding())),
        [] => Err(ErrorKind::NoSuchChannel {
            wanted: wanted.to_string(),
            known: list(channels.iter()),
        }
        .into()),
        several => Err(ambiguous(channels, several)),
    }
}

fn ambiguous(channels: &[ChannelEntry], several: &[usize]) -> Error {
    ErrorKind::AmbiguousChannel {
        candidates: Candidates::named(several.iter().map(|i| channels[*i].label.as_str())),
    }
    .into()
}

/// Keeps, of the lateral channels of one test object, those near a latch before others, primary
/// sensors before redundant ones and those on the struck side before the rest; returns whether
/// the side decided.
fn preferred(
    channels: &[ChannelEntry],
    found: &mut Vec<usize>,
    side: Option<code::VehicleSide>,
) -> bool {
    let coded = |index: &usize| channels[*index].header.code();
    let near = |index: &usize| coded(index).is_some_and(code::Code::is_near_a_latch);
    if found.iter().any(near) {
        found.retain(near);
    }
    let primary = |index: &usize| !channels[*index].header.is_redundant();
    if found.iter().any(primary) {
        found.retain(primary);
    }
    let struck =
        |index: &usize| side.is_some() && coded(index).is_some_and(|code| code.side() == side);
    let decides = found.len() > 1 && found.iter().any(struck);
    if decides {
        found.retain(struck);
    }
    decides
}

impl TestReader<'_, '_> {
    /// Reads one channel; `None` for a channel of times.
    fn channel(&mut self, index: usize) -> Result<Option<Channel>, Error> {
        let entry = &self.channels[index];
        let header = &entry.header;
        if self.selection == Selection::Every && header.is_time() {
            return Ok(None);
        }
        let place = self.package.place_of(&entry.file);
        header
            .check_repeated_keys()
            .map_err(|error| error.at(place.clone()))?;
        let mut findings = Vec::new();
        let unit = unit_of(header, self.options, &mut findings);
        if unit.unit.is_none() && self.selection == Selection::Lateral {
            return Err(without_unit(header));
        }
        let samples = self
            .package
            .samples(&entry.file, self.source, self.limits)?
            .map_err(|error| error.at(place))?;
        let clock = self.clock(index, &samples, &mut findings)?;
        let span = clock.span();
        let stamped = header.reference_channel()?.is_some();
        findings.extend(header.held_findings(&clock, samples.count, stamped));
        findings.extend(samples.cut.clone().map(|cut| cut.at(span.end_s)));
        findings.extend(samples.holes.iter().map(|hole| clock.hole(&samples, *hole)));
        findings.extend(header.validity_findings());
        for finding in &mut findings {
            span.hold(finding);
        }
        let stated = header.stated();
        findings.extend(header.contradictions());
        findings.extend(stated.findings(clock.rate));
        findings.extend(header.sign_finding());
        let draft = Draft {
            name: entry.label.clone(),
            unit,
            start_s: clock.start_s,
            rate: clock.rate,
            values: clock.values,
            stated,
            findings,
        };
        Ok(Some(draft.finish(self.options.time_zero_s)))
    }
}

/// Says that a channel has no unit of acceleration.
fn without_unit(header: &ChannelHeader) -> Error {
    match header.value("Unit") {
        Some(text) => ErrorKind::Malformed {
            expected: "a unit of acceleration".into(),
            found: format!("`{}` in the channel's header", text::shown(text)),
            hint: "choose another channel, or state the unit with the setting `unit`".into(),
        }
        .into(),
        None => ErrorKind::MissingUnit.into(),
    }
}

fn unit_of(header: &ChannelHeader, options: &ReadOptions, findings: &mut Vec<Finding>) -> Unit {
    let own = header
        .unit_of_acceleration()
        .filter(|_| header.code().is_none() || header.is_acceleration());
    Unit::find(
        own.map(|unit| (unit, "header")),
        options,
        findings,
        |source, used| {
            let text = header.value("Unit")?;
            Some(format!(
                "the channel's header says `{}`, the {source} says {used}, which was used",
                text::shown(text)
            ))
        },
    )
}

/// Returns the channel of times that a header names; `None` if there is none of that name.
fn channel_of_times<'a>(
    channels: &'a [ChannelEntry],
    own: usize,
    name: &str,
) -> Result<Option<&'a ChannelEntry>, Error> {
    let mut named: Vec<&ChannelEntry> = channels
        .iter()
        .enumerate()
        .filter(|(index, entry)| *index != own && entry.is_named(name))
        .map(|(_, entry)| entry)
        .collect();
    if named.iter().any(|entry| entry.header.is_time()) {
        named.retain(|entry| entry.header.is_time());
    }
    match named.as_slice() {
        [] => Ok(None),
        [only] => Ok(Some(only)),
        several => Err(ErrorKind::Malformed {
            expected: format!("one channel of times named {}", text::shown(name)),
            found: list(several.iter().copied()),
            hint: "which of them holds is not known; leave the right one in the test, or name it \
                   by its file's number in the channel's header"
                .into(),
        }
        .into()),
    }
}

impl UniformSamples {
    /// Says that samples are missing between two that are there.
    fn hole(&self, samples: &Samples, (from, to): (usize, usize)) -> Finding {
        // The last sample that is there before the hole.
        let last = from.saturating_sub(samples.skipped + 1);
        Finding::blocking(
            "gap",
            format!(
                "samples {} to {to} of {} are NOVALUE; what happened there is not known",
                from + 1,
                samples.count
            ),
        )
        .at(self.start_s + last as f64 / self.rate.hertz())
    }
}

impl TestReader<'_, '_> {
    /// Finds the clock of a channel: a channel of times, else what its header states.
    fn clock(
        &mut self,
        own: usize,
        samples: &Samples,
        findings: &mut Vec<Finding>,
    ) -> Result<UniformSamples, Error> {
        let header = &self.channels[own].header;
        if let Some(name) = header.reference_channel()? {
            if let Some(times) = channel_of_times(self.channels, own, name)? {
                let clock = self.explicit_clock(times, header, samples, findings)?;
                let hertz = clock.rate.hertz();
                self.options
                    .check_rate(hertz, "the channel of times", "leave out the rate")?;
                return Ok(clock);
            }
            findings.push(Finding::warning(
                "time-reference-missing",
                format!(
                    "the header names {} as the channel of times, which is not there",
                    text::shown(name)
                ),
            ));
        }
        let stated = header.interval()?;
        if let Some(stated) = stated {
            let by = "the channel's header";
            self.options
                .check_rate(stated.hertz(), by, "leave out the rate")?;
        }
        let rate = match (self.options.rate_hz, stated) {
            (Some(hertz), _) => SampleRate::from_hertz(hertz)?,
            (None, Some(stated)) => stated,
            (None, None) => return Err(ErrorKind::MissingTime.into()),
        };
        let first = match header.first_time()? {
            Some(first) => first,
            None => {
                findings.push(Finding::warning(
                    "time-start-assumed",
                    "the header does not state the time of the first sample; 0 was taken, so \
                     that first contact may be elsewhere",
                ));
                0.0
            }
        };
        if samples.values.len() < 2 {
            return Err(ErrorKind::TooShort {
                what: "a recording",
                needed: 2,
                found: samples.values.len(),
            }
            .into());
        }
        // Samples left out at the start move it by whole intervals.
        let start_s = if samples.skipped == 0 {
            first
        } else {
            first + samples.skipped as f64 / rate.hertz()
        };
        Ok(UniformSamples {
            start_s,
            rate,
            values: samples.values.clone(),
        })
    }

    /// Takes the clock that a channel of times gives.
    fn explicit_clock(
        &mut self,
        times: &ChannelEntry,
        header: &ChannelHeader,
        samples: &Samples,
        findings: &mut Vec<Finding>,
    ) -> Result<UniformSamples, Error> {
        let file = self.package.place_of(&times.file);
        let place = || file.clone().channel(times.label.clone());
        times
            .header
            .check_repeated_keys()
            .map_err(|error| error.at(place()))?;
        let unit = match times.header.value("Unit") {
            None => TimeUnit::Second,
            Some(text) => TimeUnit::from_spelling(text).ok_or_else(|| {
                Error::from(ErrorKind::Malformed {
                    expected: "a time in s, ms or us".into(),
                    found: format!("`{}`", text::shown(text)),
                    hint: "mend the header of the channel of times".into(),
                })
                .at(place())
            })?,
        };
        let stamps = self
            .package
            .samples(&times.file, self.source, self.limits)?
            .map_err(|error| error.at(place()))?;
        if stamps.count != samples.count || !stamps.holes.is_empty() || stamps.skipped > 0 {
            return Err(Error::from(ErrorKind::Malformed {
                expected: format!("{} times, one for each sample", samples.count),
                found: format!("{}", stamps.values.len()),
                hint: "fetch or export the test again".into(),
            })
            .at(place()));
        }
        let end = samples.skipped + samples.values.len();
        let stamps_s: Vec<f64> = stamps.values[samples.skipped..end]
            .iter()
            .map(|stamp| stamp / unit.per_second())
            .collect();
        let digit = stamps.last_digit / unit.per_second();
        findings.extend(header.clock_finding(&stamps.values, unit, digit));
        let base =
            TimeBase::fit(&stamps_s, digit, self.limits).map_err(|error| error.at(place()))?;
        findings.extend(base.findings.iter().cloned());
        Ok(UniformSamples {
            start_s: base.start_s,
            rate: base.rate,
            values: base.apply(&stamps_s, samples.values.clone())?,
        })
    }
}

fn to_float(limit: u64) -> f64 {
    limit as f64
}
