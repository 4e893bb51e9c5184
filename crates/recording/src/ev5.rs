//! NHTSA EV5 ASCII X-Y: a test's `.EV5` with its curve files, in a folder or an archive, or one
//! curve file.
//!
//! A curve file (`v01234.146`, or `v01234_146.tsv`) holds stamps and values, nothing else. One line of
//! the `.EV5` beside it describes the curve: its second field is the curve's number, the file's
//! extension. First and last sample index and interval state the clock; time 0 is first contact. They
//! are preferred to the printed stamps, which are rounded to a microsecond, and compared with them. The
//! laboratory's status and comment decide if the samples can be used.
//!
//! # Source
//!
//! NHTSA Test Reference Guide, volume I (instrumentation fields).
//!
//! - `curve`: curve files: two columns of numbers, no header;
//! - `header`: the `.EV5`: one line for each curve, fields divided by `|`.

mod curve;
mod header;

use super::draft::{self, Draft, UniformSamples, Unit, UnitStatement};
use super::encoding;
use super::lateral::{self, ChannelOffer};
use super::mme::names::{has_suffix, is_shadow, number_of};
use super::source::Reader;
use super::time_base::{self, MEND};
use super::{
    Channel, Finding, Head, Limits, Outcomes, ReadOptions, ReadOutcome, ReadTask, Selection,
};
use crate::error::{Error, ErrorKind, Place};
use crate::examine::clock::{Comparison, HeaderClock, StampsFit};
use curve::Curve;
use header::{CurveEntry, TestInstruments};
use latchgate_kernel::units::SampleRate;
use std::collections::{BTreeMap, BTreeSet};

/// Recognises a folder or an archive with one `.EV5`, an `.EV5`, or a curve file by its numeric
/// extension and its two columns.
pub fn recognises(head: &Head<'_>) -> bool {
    if head.is_folder || head.is_archive {
        let headers = head.entries.iter().filter(|name| is_header_name(name));
        return headers.count() == 1;
    }
    if !encoding::looks_like_text(head.bytes) {
        return false;
    }
    is_header(head.bytes)
        || (is_header_name(head.file_name) && !curve::looks_like_curve(head.bytes))
        || (number_of(head.file_name).is_some() && curve::looks_like_curve(head.bytes))
}

fn is_header_name(name: &str) -> bool {
    has_suffix(name, "ev5") && !is_shadow(name)
}

fn is_header(head: &[u8]) -> bool {
    const OPENING: [&str; 2] = ["----- EV5 -----", "----- INSTRUMENTATION -----"];
    let text = String::from_utf8_lossy(head);
    text.lines().any(|line| OPENING.contains(&line.trim()))
}

/// Reads curves of a test.
///
/// Of an `.EV5`, the curve that `ReadOptions::channel` names is read, else the one lateral
/// acceleration of the vehicle's structure, primary before redundant.
///
/// # Errors
///
/// - [`ErrorKind::NoSuchChannel`], [`ErrorKind::AmbiguousChannel`], [`ErrorKind::NoChannel`]
///   where the curve is not clear,
/// - [`ErrorKind::Io`] where a curve that is needed has no file,
/// - [`ErrorKind::Malformed`], [`NonFinite`](latchgate_kernel::error::Error::NonFinite) or [`ErrorKind::TimeNotIncreasing`] at
///   the first bad line, [`ErrorKind::MissingUnit`] where nothing states a unit,
/// - [`ErrorKind::LimitExceeded`] beyond a limit.
pub fn read(source: &mut Reader, task: ReadTask) -> Result<Outcomes, Error> {
    let head = source.head()?;
    if source.is_folder() || source.is_archive() {
        let names = source.list(true, task.limits)?;
        let absent = || missing("the test's .EV5 file");
        let name = names.into_iter().find(|name| is_header_name(name));
        let name = name.ok_or_else(absent)?;
        let bytes = source.read_beside(&name, task.limits)?;
        let parts = BTreeSet::from([name.clone()]);
        return read_test(source, (&name, bytes.ok_or_else(absent)?), parts, task);
    }
    if curve::looks_like_curve(&head) && !is_header(&head) {
        return read_bare(source, task);
    }
    let name = source.name().to_string();
    let bytes = source.read_text(task.limits)?;
    read_test(source, (&name, bytes), BTreeSet::new(), task)
}

fn missing(what: &str) -> Error {
    Error::io("read the test", &format!("{what} is missing"))
}

/// Reads a curve file, with the `.EV5` beside it if there is one.
fn read_bare(source: &mut Reader, task: ReadTask) -> Result<Outcomes, Error> {
    let (options, limits) = (task.options, task.limits);
    let mut outcome = ReadOutcome::default();
    let name = source.name().to_string();
    let bytes = source.read_text(limits)?;
    let beside = header_beside(source, &name, limits)?;
    let number = number_of(&name);
    let entry = beside
        .as_ref()
        .and_then(|(_, test)| test.find(number?).cloned());
    outcome.findings.push(match (&beside, &entry) {
        (Some((header, _)), Some(_)) => {
            let text = format!("{header} beside the curve describes it");
            Finding::info("header-beside", text)
        }
        (Some((header, _)), None) => {
            let text = format!(
                "{header} beside the curve has no line for it. Check that both are of one test"
            );
            Finding::warning("header-lacks-curve", text)
        }
        (None, _) => Finding::warning(
            "header-missing",
            "no .EV5 lies beside the curve. Unit, axis, range and the laboratory's status are \
             unknown. Put the test's .EV5 beside it",
        ),
    });
    outcome.parts.extend(beside.map(|(header, _)| header));
    let label = entry.as_ref().map_or(name.clone(), CurveEntry::name);
    options.refuse_other_clock(
        "a curve file of NHTSA",
        ", or read the file as a table with the setting `input_format` = csv",
    )?;
    if let Some(requested) = &options.channel {
        let fits = match &entry {
            Some(entry) => entry.answers_to(requested),
            None => number.is_some() && requested.trim().parse::<u32>().ok() == number,
        };
        if !fits && *requested != name {
            let (requested, known) = (requested.clone(), label);
            return Err(ErrorKind::NoSuchChannel { requested, known }.into());
        }
    }
    let place = Place::default().channel(label.clone());
    let curve = Curve::read(bytes, limits).map_err(|error| error.at(place.clone()))?;
    Ok(task.each(|selection| {
        let channel = channel(&curve, entry.as_ref(), &label, task, selection)
            .map_err(|error| error.at(place.clone()))?;
        Ok(ReadOutcome {
            channels: vec![channel],
            ..outcome.clone()
        })
    }))
}

/// Finds the `.EV5` that belongs to a curve file.
fn header_beside(
    source: &mut Reader,
    curve: &str,
    limits: &Limits,
) -> Result<Option<(String, TestInstruments)>, Error> {
    let Some((stem, _)) = curve.rsplit_once('.') else {
        return Ok(None);
    };
    // The stem may differ in case, as after a copy through a DOS disk. A folder too large to list holds no
    // test.
    let is_alike = |name: &String| {
        let name_stem = name.rsplit_once('.').map(|(name_stem, _)| name_stem);
        is_header_name(name)
            && name_stem.is_some_and(|name_stem| name_stem.eq_ignore_ascii_case(stem))
    };
    let mut names = source.list(false, limits).unwrap_or_default().into_iter();
    let Some(name) = names.find(is_alike) else {
        return Ok(None);
    };
    let bytes = source.read_beside(&name, limits)?.unwrap_or_default();
    let test = TestInstruments::read(bytes, limits);
    let test = test.map_err(|error| error.at(Place::file(name.clone())))?;
    Ok(Some((name, test)))
}

/// Reads a test from its `.EV5`; `parts` has that file's name where it is a part of the recording.
fn read_test(
    source: &mut Reader,
    (header_name, bytes): (&str, Vec<u8>),
    parts: BTreeSet<String>,
    task: ReadTask,
) -> Result<Outcomes, Error> {
    let (options, limits) = (task.options, task.limits);
    let test = TestInstruments::read(bytes, limits)
        .map_err(|error| error.at(Place::file(header_name.to_string())))?;
    if test.entries.is_empty() {
        let found = "the .EV5 has no line of instrumentation";
        return Err(Error::empty(found, "one line for each curve"));
    }
    let files = CurveFiles::find(source, header_name, limits)?;
    // The hash of an archive covers all its files already.
    let are_parts = !source.is_archive();
    Ok(task.each(|selection| {
        let mut outcome = ReadOutcome {
            parts: parts.iter().filter(|_| are_parts).cloned().collect(),
            ..ReadOutcome::default()
        };
        let indices = selected(&test, &files, options, selection, &mut outcome.findings)?;
        let limit = ("table_cells", limits.table_cells);
        draft::deliver(selection, indices, outcome, limit, |index, outcome| {
            let entry = &test.entries[index];
            let name = entry.name();
            let channel = files.only_name_of(entry.number).and_then(|file| {
                let absent = || missing(&format!("the {file}"));
                let bytes = source.read_beside(&file, limits)?.ok_or_else(absent)?;
                let place = Place::file(file.clone());
                if are_parts {
                    outcome.parts.insert(file);
                }
                let curve = Curve::read(bytes, limits).map_err(|error| error.at(place))?;
                channel(&curve, Some(entry), &name, task, selection)
            });
            channel.map(Some).map_err(|error| (name, error))
        })
    }))
}

/// Returns the curves to read.
fn selected(
    test: &TestInstruments,
    files: &CurveFiles,
    options: &ReadOptions,
    selection: Selection,
    findings: &mut Vec<Finding>,
) -> Result<Vec<usize>, Error> {
    if selection == Selection::Lateral {
        let (index, finding) = choose(test, files, options)?;
        findings.extend(finding);
        return Ok(vec![index]);
    }
    let count = test.entries.len();
    let is_there = |index: &usize| files.has(test.entries[*index].number);
    let available: Vec<usize> = (0..count).filter(is_there).collect();
    if available.len() < count {
        let absent = count - available.len();
        let text = format!(
            "{absent} of {count} curves have no file beside the .EV5. Fetch those of interest"
        );
        findings.push(Finding::info("curves-without-file", text));
    }
    Ok(available)
}

/// Returns the number of the curve that a file of the test with this stem holds: its suffix, or
/// the digits before `.tsv` (`v01234_146.tsv`, `v01234.146.tsv`).
fn curve_number(name: &str, stem: &str) -> Option<u32> {
    let (file_stem, suffix) = name.rsplit_once('.')?;
    let (front, after_stem) = file_stem.split_at_checked(stem.len())?;
    if is_shadow(name) || !front.eq_ignore_ascii_case(stem) {
        return None;
    }
    if !suffix.eq_ignore_ascii_case("tsv") {
        return number_of(name).filter(|_| after_stem.is_empty());
    }
    let digits = after_stem.trim_start_matches(['.', '_', '-', ' ']);
    let is_number = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
    digits.parse().ok().filter(|_| is_number)
}

/// The curve files beside an `.EV5`, by their number.
struct CurveFiles(BTreeMap<u32, Vec<String>>);

impl CurveFiles {
    fn find(source: &Reader, header_name: &str, limits: &Limits) -> Result<Self, Error> {
        let stem = header_name.rsplit_once('.').map_or("", |(stem, _)| stem);
        let mut files: BTreeMap<u32, Vec<String>> = BTreeMap::new();
        let deep = source.is_folder() || source.is_archive();
        for name in source.list(deep, limits)? {
            if let Some(number) = curve_number(&name, stem) {
                files.entry(number).or_default().push(name);
            }
        }
        Ok(Self(files))
    }

    fn has(&self, number: u32) -> bool {
        self.0.contains_key(&number)
    }

    /// Returns the name of a curve's file, existing or not.
    fn only_name_of(&self, number: u32) -> Result<String, Error> {
        match self.0.get(&number).map_or(&[][..], Vec::as_slice) {
            [] => Ok(format!("curve file .{number:03}")),
            [only] => Ok(only.clone()),
            several => Err(Error::malformed(
                format!("one file of curve {number}"),
                several.join(", "),
                "keep the one that belongs to the test",
            )),
        }
    }
}

/// Chooses the curve that is meant.
fn choose(
    test: &TestInstruments,
    files: &CurveFiles,
    options: &ReadOptions,
) -> Result<(usize, Option<Finding>), Error> {
    let is_there = |entry: &CurveEntry| files.has(entry.number);
    // A redundant channel counts only where its place has no primary one.
    let is_second = |entry: &CurveEntry| {
        let primary = |rival: &CurveEntry| !rival.is_redundant() && rival.place() == entry.place();
        let mut rivals = test.entries.iter().filter(|rival| is_there(rival));
        entry.is_redundant() && rivals.any(primary)
    };
    let offer = |entry: &CurveEntry| {
        let second = || "it is redundant; its place has a primary one".to_string();
        let doubt = entry.doubt();
        let doubt = doubt.or_else(|| is_second(entry).then(second));
        let is_acceleration = entry.of(header::SENSOR) == "AC" && is_there(entry);
        ChannelOffer::of_code(entry.name(), is_acceleration, doubt)
    };
    let offers: Vec<ChannelOffer> = test.entries.iter().map(offer).collect();
    if let Some(requested) = &options.channel {
        let fits = |index: &usize| test.entries[*index].answers_to(requested);
        let matches: Vec<usize> = (0..offers.len()).filter(fits).collect();
        return Ok((lateral::named(requested, &matches, &offers)?, None));
    }
    Ok(lateral::take(&offers, lateral::listed(&offers))?)
}

/// Builds a channel from a curve file and its line of the `.EV5`.
fn channel(
    curve: &Curve,
    entry: Option<&CurveEntry>,
    label: &str,
    task: ReadTask,
    selection: Selection,
) -> Result<Channel, Error> {
    let options = task.options;
    let mut findings = Vec::new();
    let statement = UnitStatement {
        unit: entry.and_then(CurveEntry::unit),
        source: "format",
        text: entry.map(|entry| entry.of(header::Y_UNIT)),
        unread: None,
        place: "the .EV5",
    };
    let unit = Unit::find(statement, options, selection, &mut findings)?;
    if let Some(entry) = entry
        && selection == Selection::Lateral
    {
        findings.extend(entry.not_lateral_finding());
    }
    let (clock, comparison) = UniformSamples::find(curve, entry, task, &mut findings)?;
    let mut doubts = Vec::new();
    let confirmed = comparison.is_some_and(|found| found.tell(&mut findings, &mut doubts));
    if let Some(entry) = entry {
        findings.extend(entry.time_unit_finding(confirmed));
        let span = clock.span();
        findings.extend(entry.status_finding(span));
        findings.extend(entry.unread_findings());
        findings.extend(entry.peak_finding(&clock.values));
        findings.extend(entry.count_finding(curve.values.len(), span.end_s));
    }
    let end_s = clock.span().end_s;
    findings.extend(curve.cut.clone().map(|cut| cut.at(end_s)));
    let mut stated = entry.map(CurveEntry::stated).unwrap_or_default();
    if confirmed {
        stated.clock_confirmed_by = Some("the .EV5".into());
    }
    stated.clock_doubt = doubts.pop();
    findings.extend(stated.findings(clock.rate));
    let draft = Draft {
        name: label.to_string(),
        unit,
        clock,
        stated,
        findings,
        remarks: entry.map(CurveEntry::remark).into_iter().collect(),
    };
    draft.finish(options.zero_s(), options)
}

impl UniformSamples {
    /// Returns the clock that the `.EV5` states where the stamps agree with it, else theirs; and what the
    /// comparison of the two comes to.
    fn find(
        curve: &Curve,
        entry: Option<&CurveEntry>,
        task: ReadTask,
        findings: &mut Vec<Finding>,
    ) -> Result<(Self, Option<Comparison>), Error> {
        let (stamps_s, digit_s) = (&curve.stamps_s, curve.printed_digit_s);
        let values = curve.values.clone();
        let stated_hz = task.options.rate_hz;
        let stated = entry.and_then(CurveEntry::clock).map(|(start_s, rate)| {
            // The .EV5 prints the interval in whole microseconds. A rate that a person states may be the same
            // with more digits, but does not replace another one.
            let finer = stated_hz.filter(|hertz| time_base::rates_agree(*hertz, rate.hertz()));
            HeaderClock {
                source: "the .EV5",
                start_s,
                start_digit_s: 0.0,
                start_intervals: start_s * rate.hertz(),
                hertz: finer.unwrap_or(rate.hertz()),
                slack: entry.map_or(0.0, CurveEntry::interval_slack),
            }
        });
        let clock = match &stated {
            Some(stated) if stated.fit(stamps_s, digit_s) == StampsFit::Exact => {
                let rate = SampleRate::from_hertz(stated.hertz)?;
                Self::stated(stated.start_s, rate, values)?
            }
            _ => Self::by_stamps(stamps_s, digit_s, values, task.limits, findings)?,
        };
        let source = ("the stamps", false);
        findings.extend(task.options.check_rate(clock.rate.hertz(), source, MEND)?);
        let comparison = stated.map(|stated| stated.compare(stamps_s, digit_s, stated_hz));
        Ok((clock, comparison))
    }
}
