//! NI TDMS (.tdms), as LabVIEW and DIAdem write it.
//!
//! A file is a row of segments. Each may change the list of channels, add or change properties, and
//! holds a stretch of samples; what one does not say stands as before. The file is read once, from the
//! first byte to the last. Memory is bounded by the metadata of one segment and all properties
//! (`headers_bytes` each), and the samples kept (`samples` of a channel, `test_samples` in all; beyond
//! these those of the one channel that is meant, with its times).
//!
//! Unit, clock and scale are properties of a channel: `unit_string`, `wf_increment`,
//! `wf_start_offset`, `NI_Scale[…]`. Where one of them changes after samples were written, the channel
//! is refused. The index file beside a TDMS file (`.tdms_index`) repeats it and is not read.
//!
//! # Source
//!
//! NI, "TDMS File Format Internal Structure"; the scales as npTDMS applies them.
//!
//! - `clock`: the clock of a channel: its own interval, or a channel of times beside it;
//! - `entry`: a channel of the file with what its names and its unit say;
//! - `object`: what is kept of an object of the file: its properties, and the samples of a channel;
//! - `said`: what properties and channels of text say of samples and test;
//! - `scale`: scales: what turns stored numbers into the quantity of a channel;
//! - `segment`: the segments of a file: lead-in, the list of objects, and where their samples stand;
//! - `stream`: from a stream of bytes to objects;
//! - `value`: numbers, texts and instants as TDMS stores them.

mod clock;
mod entry;
mod object;
mod said;
mod scale;
mod segment;
mod stream;
mod value;

use super::channel_name::ChannelName;
use super::draft::{self, Draft, Unit};
use super::held::{self, Statement};
use super::lateral::{self, ChannelOffer};
use super::remarks::Span;
use super::source::Reader;
use super::time_base::brief;
use super::{Channel, Finding, Head, Outcomes, ReadOutcome, ReadTask, Selection, text};
use crate::error::{Error, ErrorKind};
use crate::examine::clock::UsedClock;
use crate::setting::Setting;
use clock::ChannelClock;
use entry::Entry;
use latchgate_kernel::error::Error as KernelError;
use object::Object;
use said::ParentsSaid;
use scale::Scales;
use std::collections::BTreeSet;
use std::io::BufReader;
use value::{DataType, Value};

/// Bytes asked of the source at a time.
const BUFFER_BYTES: usize = 64 << 10;

/// Tells whether the file begins with a segment.
pub fn recognises(head: &Head<'_>) -> bool {
    head.bytes.starts_with(segment::TAG)
}

/// Reads a TDMS file.
///
/// # Errors
///
/// - [`RefusedFormat`](crate::error::ErrorKind::RefusedFormat) for DAQmx raw data,
/// - [`Malformed`](crate::error::ErrorKind::Malformed) for a file that is damaged or contradicts itself,
///   at the segment where it shows, and for a channel whose scale is not read,
/// - [`MissingTime`](crate::error::ErrorKind::MissingTime) and
///   [`MissingUnit`](crate::error::ErrorKind::MissingUnit) where nothing says,
/// - [`NoSuchChannel`](crate::error::ErrorKind::NoSuchChannel),
///   [`AmbiguousChannel`](crate::error::ErrorKind::AmbiguousChannel),
///   [`NoChannel`](crate::error::ErrorKind::NoChannel),
/// - [`Truncated`](crate::error::ErrorKind::Truncated) without a whole list of channels,
///   [`LimitExceeded`](crate::error::ErrorKind::LimitExceeded) beyond a limit.
pub fn read(source: &mut Reader, asked: ReadTask) -> Result<Outcomes, Error> {
    let chosen = |objects: &[Object]| match asked.selections.contains(&Selection::Lateral) {
        true => TdmsFile::of(objects, false, asked).chosen_objects(),
        false => Vec::new(),
    };
    let buffered = BufReader::with_capacity(BUFFER_BYTES, source);
    let contents = stream::contents(buffered, asked.limits, &chosen)?;
    let file = TdmsFile::of(&contents.objects, contents.is_cut, asked);
    Ok(asked.each(|selection| file.outcome(selection)))
}

/// A file whose objects are read.
struct TdmsFile<'a> {
    objects: &'a [Object],
    /// All channels in the order of the file.
    entries: Vec<Entry<'a>>,
    /// Groups with samples of a quantity; what stands in others may speak of any channel.
    sample_groups: BTreeSet<&'a str>,
    bad_flags: Vec<BadFlag>,
    parents: ParentsSaid<'a>,
    is_cut: bool,
    asked: ReadTask<'a>,
}

impl<'a> TdmsFile<'a> {
    fn of(objects: &'a [Object], is_cut: bool, asked: ReadTask<'a>) -> Self {
        let entries = entry::of(objects, asked.options);
        let of_samples = entries.iter().filter(|entry| entry.is_of_samples());
        Self {
            objects,
            bad_flags: bad_flags(&entries),
            sample_groups: of_samples.map(|entry| entry.group).collect(),
            entries,
            parents: ParentsSaid::of(objects),
            is_cut,
            asked,
        }
    }

    /// Returns channels as they are offered.
    fn offers(&self, places: &[usize]) -> Vec<ChannelOffer> {
        let column = |place: &usize| (*place + 1, &self.entries[*place].column);
        let columns: Vec<(usize, &ChannelName)> = places.iter().map(column).collect();
        ChannelOffer::of_words(&columns, "channel")
    }

    /// Returns the place of the one channel that is meant.
    fn choose(&self) -> Result<(usize, Option<Finding>), Error> {
        let places: Vec<usize> = (0..self.entries.len()).collect();
        if let Some(name) = &self.asked.options.channel {
            let candidates: Vec<usize> = places
                .iter()
                .copied()
                .filter(|place| self.entries[*place].has_samples())
                .collect();
            let fits = |place: &usize| {
                self.entries[candidates[*place]].answers_to(name, candidates[*place] + 1)
            };
            let matching: Vec<usize> = (0..candidates.len()).filter(fits).collect();
            let place = candidates[lateral::named(name, &matching, &self.offers(&candidates))?];
            return Ok((place, self.entries[place].column.not_lateral_finding()));
        }
        let filled: Vec<usize> = places
            .iter()
            .copied()
            .filter(|place| self.is_filled(*place))
            .collect();
        if filled.is_empty() {
            let channels = "no channel of numbers with samples".to_string();
            return Err(ErrorKind::NoChannel { known: channels }.into());
        }
        let choices = self.offers(&filled);
        let (chosen, finding) = lateral::take(&choices, lateral::listed(&choices))?;
        Ok((filled[chosen], finding))
    }

    fn is_filled(&self, place: usize) -> bool {
        let entry = &self.entries[place];
        entry.object.count > 0 && entry.has_samples()
    }

    /// Returns the objects that the one channel that is meant needs, as far as it is clear.
    fn chosen_objects(&self) -> Vec<usize> {
        let Ok((place, _)) = self.choose() else {
            return Vec::new();
        };
        let channel = &self.entries[place];
        let is_named = |entry: &Entry<'_>, place: usize| {
            let name = self.asked.options.time_column.as_deref();
            name.is_some_and(|name| entry.answers_to(name, place + 1))
        };
        let has_clock = |entry: &Entry<'_>| entry.group == channel.group && entry.is_clock;
        let has_own_clock = self.entries.iter().any(has_clock);
        let is_beside = |entry: &Entry<'_>| match entry.group == channel.group {
            true => entry.is_clock || entry.is_flag(),
            false => (entry.is_clock && !has_own_clock) || entry.is_flag(),
        };
        let of_use = self.entries.iter().enumerate();
        let of_use = of_use.filter(|(place, entry)| is_beside(entry) || is_named(entry, *place));
        of_use
            .map(|(_, entry)| entry.at)
            .chain([channel.at])
            .collect()
    }

    /// Reads what a selection asks for.
    fn outcome(&self, selection: Selection) -> Result<ReadOutcome, Error> {
        let mut outcome = ReadOutcome {
            remarks: said::of_file(self.objects),
            ..ReadOutcome::default()
        };
        let places = 0..self.entries.len();
        let silent = places
            .clone()
            .filter(|place| self.entries[*place].object.count == 0);
        let silent: Vec<&str> = silent
            .map(|place| &*self.entries[place].column.name)
            .collect();
        if !silent.is_empty() {
            let (count, list) = (silent.len(), silent.join(", "));
            let text = format!("{count} channels hold no sample: {}", text::shown(list));
            outcome.findings.push(Finding::info("channels-empty", text));
        }
        let selected: Vec<usize> = match selection {
            Selection::Every => places.filter(|place| self.is_filled(*place)).collect(),
            Selection::Lateral => {
                let (place, finding) = self.choose()?;
                outcome.findings.extend(finding);
                vec![place]
            }
        };
        // Of texts beside channels it is not known to which of them they belong.
        let groups: BTreeSet<&str> = selected
            .iter()
            .map(|place| self.entries[*place].group)
            .collect();
        let texts = self.entries.iter().filter(|entry| {
            groups.contains(entry.group) || !self.sample_groups.contains(entry.group)
        });
        let remarks = texts.flat_map(|entry| said::of_texts(entry.object, entry.own_name));
        outcome.remarks.extend(remarks);
        let limits = self.asked.limits;
        let limit = ("test_samples", limits.test_samples);
        draft::deliver(selection, selected, outcome, limit, |place, _| {
            let name = || self.entries[place].column.name.clone();
            let channel = self.channel(place, selection);
            channel.map(Some).map_err(|error| (name(), error))
        })
    }

    fn channel(&self, place: usize, selection: Selection) -> Result<Channel, Error> {
        let entry = &self.entries[place];
        let (object, options, limits) = (entry.object, self.asked.options, self.asked.limits);
        let objects = &entry.objects;
        if let Some(error) = objects.iter().find_map(|object| object.error.clone()) {
            return Err(error);
        }
        if object.is_left_out {
            return Err(limits.over("test_samples", "more samples in all channels"));
        }
        let is_absent = object
            .missing
            .is_some_and(|(_, count)| count == object.values.len());
        if object.values.is_empty() || is_absent {
            let empty_channel = format!("channel {} holds no sample", entry.column.name);
            return Err(Error::empty(empty_channel, "a channel with samples"));
        }
        let values = self.scaled(entry, selection)?;
        let mut findings = Vec::new();
        let stated_in = ("header", "the property `unit_string`");
        let unit = Unit::of_words(&entry.column, stated_in, options, selection, &mut findings)?;
        let extremes = self.extremes(object, &values);
        let clock = ChannelClock::find(
            &self.entries,
            place,
            self.is_cut,
            values,
            self.asked,
            &mut findings,
        )?;
        let ChannelClock {
            samples,
            confirmed_by,
            doubt,
        } = clock;
        let span = samples.span();
        if let Some((from, count)) = object.missing {
            let text = format!(
                "{count} of {} samples are no numbers (NaN), the first of them sample {}: they are \
                 missing. Record or export again",
                object.values.len(),
                from + 1
            );
            let last = from.saturating_sub(1) as f64;
            let at_s = span.start_s + last * span.interval_s;
            findings.push(Finding::blocking("gap", text).at(at_s));
        }
        if let Some(from) = object.restarted(span.interval_s) {
            let text = format!(
                "another `wf_start_time` is stated after {from} samples, which is not where they end. \
                 What happened in between is unknown. Record or export again"
            );
            let last = from.saturating_sub(1) as f64;
            let at_s = span.start_s + last * span.interval_s;
            findings.push(Finding::blocking("gap", text).at(at_s));
        }
        findings.extend(self.other_start(entry, span.interval_s));
        if self.is_cut {
            let text = "the file ends before its last segment does. Later samples are missing. Copy \
                        or export the file again";
            findings.push(Finding::blocking("samples-missing", text).at(span.end_s));
        }
        let stated_count = object.property("wf_samples").and_then(Value::number);
        if let Some(stated) = stated_count.filter(|count| *count > object.count as f64) {
            let count = object.values.len();
            findings.extend(held::count(
                "the property `wf_samples`",
                stated,
                count,
                true,
                span.end_s,
            ));
        }
        findings.extend(extremes);
        findings.extend(said::status_findings(object, span));
        findings.extend(self.parents.findings(objects));
        let hertz = samples.rate.hertz();
        let mut doubts: Vec<String> = doubt.into_iter().collect();
        let used = UsedClock {
            name: "the clock",
            hertz,
            stated_hz: options.rate_hz,
        };
        findings.extend(self.parents.rate_finding(objects, used, &mut doubts));
        findings.extend(self.flag_findings(place, span));
        let mut draft = Draft::of_words(&entry.column, unit, samples, findings);
        said::state(object, &mut draft.stated, objects);
        let filter = draft.stated.findings(draft.clock.rate);
        draft.findings.extend(
            filter
                .into_iter()
                .filter(|one| !draft.findings.contains(one))
                .collect::<Vec<_>>(),
        );
        draft.stated.clock_confirmed_by = confirmed_by;
        draft.stated.clock_doubt = (!doubts.is_empty()).then(|| doubts.join("; "));
        draft.remarks = said::of_channel(object);
        draft.remarks.extend(said::of_filters(object));
        draft.remarks.extend(self.parents.filters(objects));
        draft.finish(options.zero_s(), options)
    }

    /// Returns the finding that another channel of samples begins at another instant: the one farthest away.
    fn other_start(&self, entry: &Entry<'_>, interval_s: f64) -> Option<Finding> {
        let others = self.entries.iter().filter(|other| other.object.count > 1);
        let apart = others.filter_map(|other| {
            let apart_s = other.object.starts_after(entry.object)?;
            (apart_s.abs() > 0.5 * interval_s).then_some((apart_s, &other.column.name))
        });
        let (apart_s, name) = apart.max_by(|one, other| one.0.abs().total_cmp(&other.0.abs()))?;
        let text = format!(
            "by `wf_start_time` channel `{name}` begins {} s {} than this one. Time counts from this channel's own \
             start. Check which instant is time zero, and state {} = S if it is another",
            brief(apart_s.abs()),
            if apart_s > 0.0 { "later" } else { "earlier" },
            Setting::TimeZero
        );
        Some(Finding::warning("starts-differ", text))
    }

    /// Returns the samples as the quantity that they are.
    fn scaled(&self, entry: &Entry<'_>, selection: Selection) -> Result<Vec<f64>, Error> {
        let (object, objects, options) = (entry.object, &entry.objects, self.asked.options);
        let scales = Scales::find(objects)?;
        let is_whole = entry.kind().is_some_and(DataType::is_whole);
        let are_whole = || object.values.iter().all(|value| value.fract().abs() <= 0.0);
        if scales.is_empty() && (is_whole || are_whole()) {
            // Counts of a converter, whose scale stands in words of the writer's own, or nowhere.
            let is_stated = options.unit.is_some() || options.sensitivity.is_some();
            let is_silent = is_whole && selection == Selection::Lateral && !is_stated;
            let silent = || "whole numbers without a scale (NI_Scale)".to_string();
            let words = scale::scale_in_words(object).or_else(|| self.parents.scale(objects));
            let unscaled = words.or_else(|| is_silent.then(silent));
            if let Some(unscaled) = unscaled {
                let hint = format!(
                    "save the channel scaled, as floating point; without a property of a scale, state \
                     what the numbers are with {} = g or {} = '20 g/V'",
                    Setting::Unit,
                    Setting::Sensitivity
                );
                let expected = "samples in the channel's unit";
                return Err(Error::malformed(expected, unscaled, hint));
            }
        }
        let values: Vec<f64> = object
            .values
            .iter()
            .map(|value| scales.apply(*value))
            .collect();
        match values.iter().position(|value| !value.is_finite()) {
            Some(index) => {
                let sample = format!("{} as sample {} after scaling", values[index], index + 1);
                Err(KernelError::NonFinite { found: sample }.into())
            }
            None => Ok(values),
        }
    }

    /// Holds the extremes that DIAdem states of a channel against the samples.
    fn extremes(&self, object: &Object, values: &[f64]) -> Vec<Finding> {
        let mut findings = Vec::new();
        let stated = |key: &str| object.property(key).and_then(Value::number);
        let (Some(low), Some(high)) = (stated("minimum"), stated("maximum")) else {
            return findings;
        };
        // Equal ones were never computed.
        if !(low < high && low.is_finite() && high.is_finite()) {
            return findings;
        }
        let least = values.iter().copied().fold(f64::MAX, f64::min);
        let largest = values.iter().copied().fold(f64::MIN, f64::max);
        let slack = EXTREME_AGREEMENT * least.abs().max(largest.abs());
        for (key, stated, actual) in [("minimum", low, least), ("maximum", high, largest)] {
            let text = &stated.to_string();
            Statement { key, text }.extreme(actual, slack, &mut findings);
        }
        findings
    }

    /// Says from when on channels of flags beside the samples speak against them.
    fn flag_findings(&self, place: usize, span: Span) -> Vec<Finding> {
        let channel = &self.entries[place];
        let of_own = |flag: &&BadFlag| {
            let group = self.entries[flag.place].group;
            let is_beside = group == channel.group || !self.sample_groups.contains(group);
            let is_of_all = is_beside && flag.speaks_of.is_empty();
            flag.place != place && (is_of_all || flag.speaks_of.contains(&place))
        };
        let bad = self.bad_flags.iter().filter(of_own).map(|flag| {
            let entry = &self.entries[flag.place];
            let name = text::shown(&entry.column.name);
            let Some((index, value)) = flag.first else {
                let text = format!(
                    "the channel `{name}` says whether samples are good, and could not be read. \
                     Export the channel alone, or look at it"
                );
                return Finding::blocking("invalid-by-laboratory", text);
            };
            let text = format!(
                "the channel `{name}` says {value} from sample {} on. Use another channel, or \
                 samples before that",
                index + 1
            );
            let is_beside = entry.object.count == channel.object.count;
            let at_s = span.start_s + index as f64 * span.interval_s;
            Finding::blocking("invalid-by-laboratory", text).since(is_beside.then_some(at_s))
        });
        bad.collect()
    }
}

/// A channel of flags that does not say throughout that all is well.
struct BadFlag {
    place: usize,
    /// Index of the first such flag, and the flag; `None` where they were not read.
    first: Option<(usize, f64)>,
    /// The channels that it is named after, as `acc_y_overload` is after `acc_y`; none for all.
    speaks_of: Vec<usize>,
}

/// Looks through the channels of flags.
fn bad_flags(entries: &[Entry<'_>]) -> Vec<BadFlag> {
    let mut bad_flags = Vec::new();
    let flags = entries.iter().enumerate();
    for (place, flag) in flags.filter(|(_, entry)| entry.is_flag() && entry.object.count > 0) {
        let values = &flag.object.values;
        let changes =
            |index: &usize| *index == 0 || values[*index].total_cmp(&values[*index - 1]).is_ne();
        let says_bad = |index: &usize| said::says_bad(flag.own_name, &values[*index].to_string());
        let first = (0..values.len()).filter(changes).find(says_bad);
        // Of flags with a scale it is not known which number says what.
        let is_plain = Scales::refuse_any(&flag.objects, false).is_ok();
        let is_known = flag.object.is_kept() && flag.object.missing.is_none() && is_plain;
        if first.is_none() && is_known {
            continue;
        }
        let is_of = |entry: &Entry<'_>| {
            let suffix = flag.own_name.strip_prefix(entry.own_name);
            let ends =
                suffix.is_some_and(|suffix| suffix.starts_with(|c: char| !c.is_alphanumeric()));
            entry.own_name.len() > 1 && ends
        };
        let of_group = |other: &usize| entries[*other].group == flag.group;
        let named: Vec<usize> = (0..entries.len())
            .filter(|other| is_of(&entries[*other]))
            .collect();
        // A name of its own group comes before the same one of another.
        let of_own: Vec<usize> = named.iter().copied().filter(of_group).collect();
        bad_flags.push(BadFlag {
            place,
            first: first.map(|index| (index, values[index])),
            speaks_of: if of_own.is_empty() { named } else { of_own },
        });
    }
    bad_flags
}

/// Part of the largest magnitude by which a stated extreme may be off [-].
const EXTREME_AGREEMENT: f64 = 1e-4;
