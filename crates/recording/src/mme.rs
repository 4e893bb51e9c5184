//! ISO/TS 13499 (ISO-MME): a test as folder, .zip, .tar.gz or .tar, or one channel of it.
//!
//! A channel is a separate file: header lines `Key :value`, then one value a line. Its code of 16
//! characters states place, direction and filter. Codes may occur twice, so channels are distinguished by
//! file. The header's statements on the samples (number, extremes and their times) serve as a checksum.
//!
//! # Source
//!
//! ISO/TS 13499 and its related electronic document B (codes), as far as they show in the files.
//!
//! - `channel`: channel files: header and samples;
//! - `header`: the test's header: test objects, and the side that was struck;
//! - `names`: names of a test's files: header, list and channels;
//! - `package`: the files of a test: in a folder, in an archive, or beside the recording.

mod channel;
mod header;
pub(super) mod names;
mod package;

use super::code::VehicleSide;
use super::draft::{self, Draft, UniformSamples, Unit, UnitStatement};
use super::lateral::ChannelOffer;
use super::source::Reader;
use super::time_base::{MEND, brief};
use super::{
    Channel, Finding, Head, Limits, Outcomes, ReadOptions, ReadOutcome, ReadTask, Selection,
    encoding, lateral, text,
};
use crate::error::{Candidates, Error, ErrorKind};
use channel::{ChannelHeader, Samples, extremes_are_apart};
use header::TestHeader;
use latchgate_kernel::units::{SampleRate, TimeUnit};
use package::{ChannelEntry, Package};
use std::collections::BTreeMap;

/// Recognises archives with a channel file, folders with an .mme or .chn file, and single files of
/// a test.
pub fn recognises(head: &Head<'_>) -> bool {
    let mut entries = head.entries.iter();
    if head.is_archive {
        // The curves of NHTSA's tests have such names as well.
        let is_nhtsa = head
            .entries
            .iter()
            .any(|name| names::has_suffix(name, "ev5"));
        return !is_nhtsa && entries.any(|name| names::is_channel_file(name));
    }
    if head.is_folder {
        return entries.any(|name| names::is_test_file(name));
    }
    encoding::looks_like_text(head.bytes)
        && (names::is_test_file(head.file_name) || channel::looks_like_channel(head.bytes))
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
/// - [`ErrorKind::Malformed`], [`ErrorKind::Truncated`] or [`NonFinite`](latchgate_kernel::error::Error::NonFinite) for damage,
///   [`ErrorKind::LimitExceeded`] beyond a limit, at the byte where it was crossed.
pub fn read(source: &mut Reader, task: ReadTask) -> Result<Outcomes, Error> {
    let (options, limits) = (task.options, task.limits);
    options.refuse_other_clock("an ISO-MME package", "")?;
    let mut package = Package::open(source, limits)?;
    let mut findings = Vec::new();
    let channels = package.channels(source, limits, &mut findings)?;
    if channels.is_empty() {
        return Err(package.without_channels());
    }
    findings.extend(package.list_finding(&channels, source, limits)?);
    let header = package.test_header(source, limits, &mut findings)?;
    // The header is shown with the result, so that its file is hashed as a part of the recording.
    let file = header.file.clone();
    let part = file.filter(|file| file != source.name() && package.is_part(file));
    if let Some(file) = &part {
        source.read_beside(file, limits)?;
    }
    let mut test = TestReader {
        package: &mut package,
        source,
        channels: &channels,
        header: &header,
        options,
        limits,
    };
    Ok(task.each(|selection| {
        let (indices, choice_findings) = selected(
            test.package,
            &channels,
            &header.struck_sides,
            options,
            selection,
        )?;
        let outcome = ReadOutcome {
            findings: findings.iter().cloned().chain(choice_findings).collect(),
            remarks: header.remarks.clone(),
            parts: part.iter().cloned().collect(),
            ..ReadOutcome::default()
        };
        let limit = ("test_samples", limits.test_samples);
        draft::deliver(selection, indices, outcome, limit, |index, outcome| {
            let channel = test.channel(index, selection, outcome);
            channel.map_err(|error| (channels[index].label.clone(), error))
        })
    }))
}

/// Returns the channels to read, with the findings on their choice.
fn selected(
    package: &Package,
    channels: &[ChannelEntry],
    sides: &BTreeMap<u8, VehicleSide>,
    options: &ReadOptions,
    selection: Selection,
) -> Result<(Vec<usize>, Vec<Finding>), Error> {
    let opened = channels
        .iter()
        .position(|entry| package.opened_file() == Some(&entry.file));
    if selection == Selection::Every {
        let every = || (0..channels.len()).collect();
        return Ok((opened.map_or_else(every, |index| vec![index]), Vec::new()));
    }
    let (index, finding) = match (&options.channel, opened) {
        (Some(requested), _) => (named(channels, opened, requested)?, None),
        (None, Some(opened)) => (opened, None),
        (None, None) => {
            let offers = offers(channels);
            lateral::take(&offers, lateral::listed(&offers))?
        }
    };
    let header = &channels[index].header;
    let side = header
        .code()
        .and_then(|code| sides.get(&code.object()).zip(code.side()));
    let far_side_finding = side.filter(|(struck, side)| *struck != side).map(|_| {
        let text = "the test's header says that the other side was struck. Choose a channel there \
                    with the setting `channel` = NAME, or confirm that this side is meant";
        let text = format!("{}: {text}", channels[index].label);
        Finding::warning("side-not-struck", text)
    });
    let findings = header
        .not_lateral_finding()
        .into_iter()
        .chain(finding)
        .chain(far_side_finding);
    Ok((vec![index], findings.collect()))
}

/// Returns channels to choose from.
fn offers(channels: &[ChannelEntry]) -> Vec<ChannelOffer> {
    let offer = |entry: &ChannelEntry| {
        let (label, header) = (entry.label.clone(), &entry.header);
        ChannelOffer::of_code(label, header.is_acceleration(), header.doubt())
    };
    channels.iter().map(offer).collect()
}

/// Finds the channel of a name or pattern; `opened` is the one file that is the recording.
fn named(
    channels: &[ChannelEntry],
    opened: Option<usize>,
    requested: &str,
) -> Result<usize, Error> {
    let entries_where = |fits: &dyn Fn(&ChannelEntry) -> bool| -> Vec<usize> {
        (0..channels.len())
            .filter(|index| opened.is_none_or(|opened| opened == *index) && fits(&channels[*index]))
            .collect()
    };
    // A literal name comes before a pattern, since codes may hold question marks.
    let mut matches = entries_where(&|entry| entry.is_named(requested));
    if matches.is_empty() {
        matches = entries_where(&|entry| entry.answers_to(requested));
    }
    let mut offers = offers(channels);
    if let Some(opened) = opened {
        offers = vec![offers.swap_remove(opened)];
    }
    lateral::named(requested, &matches, &offers)
}

/// A test whose channels are read.
struct TestReader<'a, 'r> {
    package: &'a mut Package,
    source: &'a mut Reader<'r>,
    channels: &'a [ChannelEntry],
    header: &'a TestHeader,
    options: &'a ReadOptions,
    limits: &'a Limits,
}

impl TestReader<'_, '_> {
    /// Reads one channel; `None` for a channel of times, which serves the others.
    fn channel(
        &mut self,
        index: usize,
        selection: Selection,
        outcome: &mut ReadOutcome,
    ) -> Result<Option<Channel>, Error> {
        let entry = &self.channels[index];
        let header = &entry.header;
        if selection == Selection::Every && header.is_time() {
            return Ok(None);
        }
        let place = self.package.place_of(&entry.file);
        let placed = |error: Error| error.at(place.clone());
        header.check_repeated_keys().map_err(placed)?;
        let mut findings = Vec::new();
        let unit = header.unit_of_acceleration();
        let statement = UnitStatement {
            unit: unit.filter(|_| header.code().is_none() || header.is_acceleration()),
            source: "header",
            text: header.value("Unit"),
            unread: None,
            place: "the channel's header",
        };
        let unit = Unit::find(statement, self.options, selection, &mut findings)?;
        let samples = self.samples(&entry.file, outcome)?.map_err(placed)?;
        let ChannelTime {
            clock,
            stamped,
            confirmed_by,
            doubt,
        } = self.clock(index, &samples, outcome, &mut findings)?;
        let span = clock.span();
        findings.extend(header.held_findings(&clock, samples.values.len(), stamped));
        findings.extend(samples.cut.clone().map(|cut| cut.at(span.end_s)));
        findings.extend(samples.holes.iter().map(|hole| clock.hole(*hole)));
        findings.extend(header.status_findings(span));
        let mut stated = header.stated(&mut findings);
        stated.clock_confirmed_by = match stamped {
            true => confirmed_by,
            // Where the start rests on these instants, only what lies between them confirms.
            false if header.first_time()?.is_some() || extremes_are_apart(&clock.values) => {
                header.instant_confirms(&clock)
            }
            false => None,
        };
        stated.clock_doubt = doubt;
        stated.test = stated.test.or(self.header.test_facts(header));
        findings.extend(header.contradictions());
        findings.extend(stated.findings(clock.rate));
        findings.extend(header.code().and_then(|code| code.sign_finding()));
        let draft = Draft {
            name: entry.label.clone(),
            unit,
            clock,
            stated,
            findings,
            remarks: vec![header.remark()],
        };
        draft.finish(self.options.zero_s(), self.options).map(Some)
    }

    /// Reads the samples of a file and notes it as a part of the recording if it is one.
    fn samples(
        &mut self,
        file: &str,
        outcome: &mut ReadOutcome,
    ) -> Result<Result<std::rc::Rc<Samples>, Error>, Error> {
        if self.package.is_part(file) {
            outcome.parts.insert(file.to_string());
        }
        self.package.samples(file, self.source, self.limits)
    }
}

/// Returns the channel of times that a header names; `None` if there is none of that name.
fn channel_of_times<'a>(
    channels: &'a [ChannelEntry],
    channel: usize,
    name: &str,
) -> Result<Option<&'a ChannelEntry>, Error> {
    let entries = channels
        .iter()
        .enumerate()
        .filter(|(index, _)| *index != channel);
    let entries = entries.map(|(_, entry)| entry);
    let mut named: Vec<&ChannelEntry> = entries.filter(|entry| entry.is_named(name)).collect();
    if named.iter().any(|entry| entry.header.is_time()) {
        named.retain(|entry| entry.header.is_time());
    }
    match named.as_slice() {
        [] => Ok(None),
        [only] => Ok(Some(only)),
        several => Err(Error::malformed(
            format!("one channel of times named {}", text::shown(name)),
            Candidates::named(several.iter().map(|entry| &*entry.label)).to_string(),
            "keep the right one in the test, or name it by its file's number in the channel's \
             header",
        )),
    }
}

impl UniformSamples {
    /// Returns the finding on missing samples, from the last one before them on.
    fn hole(&self, (from, to): (usize, usize)) -> Finding {
        let count = self.values.len();
        let text = format!(
            "samples {} to {to} of {count} are NOVALUE: they are missing. Record or export again",
            from + 1
        );
        let last = from.saturating_sub(1) as f64;
        Finding::blocking("gap", text).at(self.start_s + last / self.rate.hertz())
    }
}

/// The samples of a channel on its clock.
struct ChannelTime {
    clock: UniformSamples,
    /// Whether each sample has a stamp.
    stamped: bool,
    /// What of the header confirms the stamps.
    confirmed_by: Option<String>,
    /// What a person must accept of the clock.
    doubt: Option<String>,
}

impl TestReader<'_, '_> {
    /// Returns the clock of a channel, by a channel of times, else by its header.
    fn clock(
        &mut self,
        channel: usize,
        samples: &Samples,
        outcome: &mut ReadOutcome,
        findings: &mut Vec<Finding>,
    ) -> Result<ChannelTime, Error> {
        let header = &self.channels[channel].header;
        if let Some(name) = header.reference_channel()? {
            if let Some(times) = channel_of_times(self.channels, channel, name)? {
                let time = self.explicit_clock(times, header, samples, outcome, findings)?;
                let assumed = times.header.value("Unit").is_none();
                if assumed {
                    let text = "the channel of times states no unit. Seconds were assumed. Check \
                                the rate";
                    findings.push(Finding::info("time-unit-assumed", text));
                }
                let source = ("the channel of times", assumed);
                let finding = self
                    .options
                    .check_rate(time.clock.rate.hertz(), source, MEND)?;
                findings.extend(finding);
                return Ok(time);
            }
            let text = format!(
                "the header names {} as the channel of times, which is missing. Fetch its file",
                text::shown(name)
            );
            findings.push(Finding::warning("time-reference-missing", text));
        }
        let stated = header.interval()?;
        if let Some(hertz) = stated.map(SampleRate::hertz) {
            let source = ("the channel's header", false);
            findings.extend(self.options.check_rate(hertz, source, MEND)?);
        }
        let rate = match (self.options.rate_hz, stated) {
            (Some(hertz), _) => SampleRate::from_hertz(hertz)?,
            (None, Some(stated)) => stated,
            (None, None) => return Err(ErrorKind::MissingTime.into()),
        };
        let by_extremes = || header.start_by_extremes(&samples.values, rate.interval().seconds());
        let start_s = match (header.first_time()?, by_extremes()) {
            (Some(start_s), _) => start_s,
            (None, Some(start_s)) => {
                let text = format!(
                    "the header does not state the time of the first sample. By its instants of both extremes \
                     that is {} s",
                    brief(start_s)
                );
                findings.push(Finding::info("time-zero-shown", text));
                start_s
            }
            (None, None) => {
                findings.push(Finding::warning(
                    "time-start-assumed",
                    "the header does not state the time of the first sample. 0 was assumed, so first \
                     contact may lie elsewhere. State the setting `time_zero` = S",
                ));
                0.0
            }
        };
        let clock = UniformSamples::stated(start_s, rate, samples.values.clone())?;
        Ok(ChannelTime {
            clock,
            stamped: false,
            confirmed_by: None,
            doubt: None,
        })
    }

    /// Returns the clock that a channel of times gives.
    fn explicit_clock(
        &mut self,
        times: &ChannelEntry,
        header: &ChannelHeader,
        samples: &Samples,
        outcome: &mut ReadOutcome,
        findings: &mut Vec<Finding>,
    ) -> Result<ChannelTime, Error> {
        let file = self.package.place_of(&times.file);
        let placed = |error: Error| error.at(file.clone().channel(times.label.clone()));
        times.header.check_repeated_keys().map_err(placed)?;
        let unit = times.header.value("Unit").unwrap_or("s");
        let Some(unit) = TimeUnit::from_spelling(unit) else {
            return Err(placed(Error::malformed(
                "a known unit of time, such as s, ms or 10 us",
                format!("`{}`", text::shown(unit)),
                "correct the header of the channel of times",
            )));
        };
        let stamps = self.samples(&times.file, outcome)?.map_err(placed)?;
        if stamps.values.len() != samples.values.len() || !stamps.holes.is_empty() {
            return Err(placed(Error::malformed(
                format!("{} times, one for each sample", samples.values.len()),
                format!("{}, {} gaps", stamps.values.len(), stamps.holes.len()),
                "fetch or export the test again",
            )));
        }
        let seconds = |stamp: &f64| unit.to_seconds(*stamp);
        let stamps_s: Vec<f64> = stamps.values.iter().map(seconds).collect();
        let digit_s = seconds(&stamps.last_digit);
        let mut doubts = Vec::new();
        let comparison = header.clock_comparison(&stamps_s, digit_s, self.options.rate_hz);
        let confirmed = comparison.is_some_and(|found| found.tell(findings, &mut doubts));
        let values = samples.values.clone();
        let clock = UniformSamples::by_stamps(&stamps_s, digit_s, values, self.limits, findings)
            .map_err(placed)?;
        Ok(ChannelTime {
            clock,
            stamped: true,
            confirmed_by: confirmed.then(|| "Sampling interval".into()),
            doubt: doubts.pop(),
        })
    }
}
