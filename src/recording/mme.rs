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

mod archive;
mod channel;
pub(super) mod code;
mod package;

use super::source::Reader;
use super::time_base::{self, TimeBase};
use super::{
    Channel, Finding, Head, Limits, ReadOptions, ReadOutcome, Selection, csv::encoding, laboratory,
    text,
};
use crate::error::{Candidates, Error, ErrorKind, Place};
use crate::units::{AccelerationUnit, SampleRate, TimeUnit};
use channel::{ChannelHeader, Samples};
use package::{Entry, Package};
use std::collections::BTreeMap;

/// Recognises archives, folders with an .mme or .chn file, and single files of a test.
#[must_use]
pub fn recognises(head: &Head<'_>) -> bool {
    if head.is_folder {
        return head.entries.iter().any(|name| package::is_test_file(name));
    }
    archive::is_archive(head.bytes)
        || (encoding::looks_like_text(head.bytes)
            && (package::is_test_file(head.file_name) || channel::looks_like_channel(head.bytes)))
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
    selection: Selection,
    limits: &Limits,
) -> Result<ReadOutcome, Error> {
    options.refuse_other_clock("an ISO-MME package", "")?;
    let mut package = Package::open(source, limits)?;
    let mut outcome = ReadOutcome::default();
    let sides = package.impact_sides(source, limits)?;
    let mut channels = package.channels(source, limits, &mut outcome.findings)?;
    name_twins(&mut channels);
    let listed = package.list_finding(&channels, source, limits)?;
    outcome.findings.extend(listed);
    if channels.is_empty() {
        return Err(package.without_channels());
    }
    let only = package.only_channel();
    let (wanted, finding) = match (selection, only) {
        (Selection::Every, None) => ((0..channels.len()).collect(), None),
        (Selection::Lateral, None) => {
            let (index, finding) = choose(&channels, &sides, options)?;
            (vec![index], finding)
        }
        (_, Some(index)) => {
            check_named(&channels[index], options)?;
            let finding = channels[index].header.not_lateral_finding();
            (
                vec![index],
                finding.filter(|_| selection == Selection::Lateral),
            )
        }
    };
    outcome.findings.extend(finding);
    let more = || {
        Error::from(ErrorKind::LimitExceeded {
            limit: "test_samples",
            value: limits.test_samples,
            found: "more samples in all channels".into(),
        })
    };
    // What headers announce ends it before anything is unpacked; what they do not, after.
    let mut announced = 0.0;
    for index in &wanted {
        let entry = &channels[*index];
        announced += entry.header.announced().min(to_float(limits.samples));
        if announced > to_float(limits.test_samples) && selection == Selection::Every {
            return Err(more().at(Place::default().channel(entry.label.clone())));
        }
    }
    let mut cells = 0_u64;
    for index in wanted {
        let entry = &channels[index];
        let place = Place::default().channel(entry.label.clone());
        match read_channel(
            &mut package,
            source,
            &channels,
            index,
            options,
            selection,
            limits,
        ) {
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
                if selection == Selection::Every
                    && !matches!(error.kind(), ErrorKind::LimitExceeded { .. }) =>
            {
                outcome.findings.push(Finding::warning(
                    "channel-left-out",
                    format!("{} is left out: {error}", entry.label),
                ))
            }
            Err(error) => return Err(error.at(place)),
        }
    }
    Ok(outcome)
}

/// Refuses a name that the one channel file given does not bear.
fn check_named(entry: &Entry, options: &ReadOptions) -> Result<(), Error> {
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
fn name_twins(channels: &mut [Entry]) {
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
fn list<'a>(entries: impl Iterator<Item = &'a Entry>) -> String {
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
    channels: &[Entry],
    sides: &BTreeMap<u8, code::Side>,
    options: &ReadOptions,
) -> Result<(usize, Option<Finding>), Error> {
    let ambiguous = |several: &[usize]| {
        Error::from(ErrorKind::AmbiguousChannel {
            candidates: Candidates::named(several.iter().map(|i| channels[*i].label.as_str())),
        })
    };
    let of = |wanted: &dyn Fn(&Entry) -> bool| -> Vec<usize> {
        (0..channels.len())
            .filter(|index| wanted(&channels[*index]))
            .collect()
    };
    if let Some(wanted) = &options.channel {
        // A literal name comes before a pattern: codes may hold question marks.
        let mut found = of(&|entry| entry.is_named(wanted));
        if found.is_empty() {
            found = of(&|entry| entry.answers_to(wanted));
        }
        return match found.as_slice() {
            [only] => Ok((*only, channels[*only].header.not_lateral_finding())),
            [] => Err(ErrorKind::NoSuchChannel {
                wanted: wanted.clone(),
                known: list(channels.iter()),
            }
            .into()),
            several => Err(ambiguous(several)),
        };
    }
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
        several => return Err(ambiguous(several)),
    };
    let label = &channels[only].label;
    let far = coded(&only).is_some_and(|code| {
        let struck = sides.get(&code.object());
        code.side()
            .is_some_and(|side| struck.is_some_and(|struck| *struck != side))
    });
    let finding = if far {
        Some(Finding::warning(
            "side-not-struck",
            format!(
                "{label} was chosen as the one lateral acceleration of the structure, but it lies \
                 on the side that was not struck, as the test's header says: the struck side \
                 moved more"
            ),
        ))
    } else {
        (!alone).then(|| {
            Finding::info(
                "channel-chosen",
                format!(
                    "{label} was chosen among {} channels of acceleration as the one lateral \
                     acceleration of the structure{by_side}",
                    accelerations.len()
                ),
            )
        })
    };
    Ok((only, finding))
}

/// Keeps, of the lateral channels of one test object, those near a latch before others, primary
/// sensors before redundant ones and those on the struck side before the rest; returns whether
/// the side decided.
fn preferred(channels: &[Entry], found: &mut Vec<usize>, side: Option<code::Side>) -> bool {
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

/// Reads one channel; `None` for a channel of times.
fn read_channel(
    package: &mut Package,
    source: &mut Reader,
    channels: &[Entry],
    index: usize,
    options: &ReadOptions,
    selection: Selection,
    limits: &Limits,
) -> Result<Option<Channel>, Error> {
    let entry = &channels[index];
    let header = &entry.header;
    if selection == Selection::Every && header.is_time() {
        return Ok(None);
    }
    header
        .check_repeated_keys()
        .map_err(|error| error.at(package.place_of(&entry.file)))?;
    let mut findings = Vec::new();
    let (unit, unit_source) = unit(header, options, &mut findings);
    if unit.is_none() && selection == Selection::Lateral {
        return Err(match header.value("Unit") {
            Some(text) => ErrorKind::Malformed {
                expected: "a unit of acceleration".into(),
                found: format!("`{}` in the channel's header", text::shown(text)),
                hint: "choose another channel, or state the unit with the setting `unit`".into(),
            }
            .into(),
            None => ErrorKind::MissingUnit.into(),
        });
    }
    let bytes = package.whole(&entry.file, source, limits)?;
    let samples =
        Samples::read(bytes, limits).map_err(|error| error.at(package.place_of(&entry.file)))?;
    let clock = Clock::find(
        package,
        source,
        channels,
        index,
        &samples,
        options,
        limits,
        &mut findings,
    )?;
    let counted = header
        .count_finding(samples.count, clock.end_s())
        .map_err(|error| error.at(package.place_of(&entry.file)))?;
    findings.extend(counted);
    findings.extend(header.extreme_findings(&clock.values, clock.start_s, clock.rate));
    for (from, to) in &samples.holes {
        // The last sample that is there before the hole.
        let last = from.saturating_sub(samples.skipped + 1);
        let at = clock.start_s + to_f64(last) / clock.rate.hertz();
        findings.push(
            Finding::blocking(
                "gap",
                format!(
                    "samples {} to {to} of {} are NOVALUE; what happened there is not known",
                    from + 1,
                    samples.count
                ),
            )
            .at(at),
        );
    }
    findings.extend(header.validity_findings());
    for finding in &mut findings {
        let interval_s = 1.0 / clock.rate.hertz();
        laboratory::hold_against_record(finding, clock.start_s, clock.end_s(), interval_s);
    }
    let stated = header.stated();
    findings.extend(header.class_finding());
    findings.extend(stated.findings(clock.rate));
    findings.extend(header.sign_finding());
    let zero = options.time_zero_s.unwrap_or(0.0);
    for finding in &mut findings {
        finding.at_s = finding.at_s.map(|at| at - zero);
    }
    Ok(Some(Channel {
        name: entry.label.clone(),
        unit,
        unit_source,
        start_s: clock.start_s - zero,
        rate: clock.rate,
        values: clock.values,
        stated,
        findings,
    }))
}

fn unit(
    header: &ChannelHeader,
    options: &ReadOptions,
    findings: &mut Vec<Finding>,
) -> (Option<AccelerationUnit>, &'static str) {
    let text = header.value("Unit");
    let own = header
        .unit_of_acceleration()
        .filter(|_| header.code().is_none() || header.is_acceleration());
    let source = if options.unit_from_card {
        "card"
    } else {
        "option"
    };
    match (own, options.unit) {
        (_, Some(said)) => {
            if let Some(text) = text
                && own != Some(said)
            {
                findings.push(Finding::warning(
                    "unit-overridden",
                    format!(
                        "the channel's header says `{}`, the {source} says {}, which was used",
                        text::shown(text),
                        said.name()
                    ),
                ));
            }
            (Some(said), source)
        }
        (Some(own), None) => (Some(own), "header"),
        (None, None) => (None, "none"),
    }
}

/// Returns the channel of times that a header names; `None` if there is none of that name.
fn channel_of_times<'a>(
    channels: &'a [Entry],
    own: usize,
    name: &str,
) -> Result<Option<&'a Entry>, Error> {
    let mut named: Vec<&Entry> = channels
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

/// The uniform clock of a channel.
struct Clock {
    start_s: f64,
    rate: SampleRate,
    values: Vec<f64>,
}

impl Clock {
    #[expect(
        clippy::too_many_arguments,
        reason = "an explicit clock stands in another channel of the package"
    )]
    fn find(
        package: &mut Package,
        source: &mut Reader,
        channels: &[Entry],
        own: usize,
        samples: &Samples,
        options: &ReadOptions,
        limits: &Limits,
        findings: &mut Vec<Finding>,
    ) -> Result<Self, Error> {
        let header = &channels[own].header;
        if let Some(name) = header.reference_channel()? {
            if let Some(times) = channel_of_times(channels, own, name)? {
                let clock =
                    Self::explicit(package, source, times, header, samples, limits, findings)?;
                let hertz = clock.rate.hertz();
                options.check_rate(hertz, "the channel of times", "leave out the rate")?;
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
            options.check_rate(stated.hertz(), by, "leave out the rate")?;
        }
        let rate = match (options.rate_hz, stated) {
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
            first + to_f64(samples.skipped) / rate.hertz()
        };
        Ok(Self {
            start_s,
            rate,
            values: samples.values.clone(),
        })
    }

    fn explicit(
        package: &mut Package,
        source: &mut Reader,
        times: &Entry,
        header: &ChannelHeader,
        samples: &Samples,
        limits: &Limits,
        findings: &mut Vec<Finding>,
    ) -> Result<Self, Error> {
        let file = package.place_of(&times.file);
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
        let bytes = package.whole(&times.file, source, limits)?;
        let stamps = Samples::read(bytes, limits).map_err(|error| error.at(place()))?;
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
        let base = TimeBase::fit(&stamps_s, digit, limits).map_err(|error| error.at(place()))?;
        findings.extend(base.findings.iter().cloned());
        Ok(Self {
            start_s: base.start_s,
            rate: base.rate,
            values: base.apply(&stamps_s, samples.values.clone())?,
        })
    }

    fn end_s(&self) -> f64 {
        self.start_s + to_f64(self.values.len().saturating_sub(1)) / self.rate.hertz()
    }
}

fn to_float(limit: u64) -> f64 {
    limit as f64
}

fn to_f64(count: usize) -> f64 {
    count as f64
}
