//! The clock of a channel: its own interval, or a channel of times beside it.

use super::entry::Entry;
use super::object::Object;
use super::said;
use super::scale::Scales;
use super::value::{DataType, Value};
use crate::channel_name::ChannelName;
use crate::draft::UniformSamples;
use crate::error::{Error, ErrorKind, Place};
use crate::examine::clock::{Comparison, HeaderClock, Relation, UsedClock};
use crate::setting::Setting;
use crate::time_base::{self, MEND};
use crate::{Finding, ReadTask, text};
use latchgate_kernel::error::Error as KernelError;
use latchgate_kernel::units::{SampleRate, TimeUnit};

/// What the properties of a waveform say of time.
struct Waveform {
    /// Time of the first sample, in the file's unit.
    start: f64,
    unit: TimeUnit,
    rate: SampleRate,
    /// Whether samples are counted by ones, as where no timing is attached.
    counts: bool,
}

impl Waveform {
    fn start_s(&self) -> f64 {
        self.unit.to_seconds(self.start)
    }

    /// Reads the properties of a channel; `None` without an interval.
    fn of(
        object: &Object,
        stated: Option<TimeUnit>,
        findings: &mut Vec<Finding>,
    ) -> Result<Option<Self>, Error> {
        let Some(increment) = object.property("wf_increment") else {
            return Ok(None);
        };
        let number = |value: &Value| value.number().filter(|number| number.is_finite());
        let malformed = |expected: &str, key: &str, value: &Value, hint: &str| {
            let statement = format!("{key} `{}`", text::shown(value.text()));
            Error::malformed(expected, statement, hint)
        };
        let interval = match number(increment) {
            // As some programs write where they know none.
            Some(interval) if interval.abs() <= 0.0 => return Ok(None),
            Some(interval) if interval > 0.0 => interval,
            _ => {
                let expected = "an interval above 0";
                return Err(malformed(expected, "wf_increment", increment, MEND));
            }
        };
        let unit = unit_of_x(object, stated, findings)?;
        let start = match object.property("wf_start_offset") {
            None => 0.0,
            Some(offset) => number(offset).ok_or_else(|| {
                malformed(
                    "a time of the first sample",
                    "wf_start_offset",
                    offset,
                    MEND,
                )
            })?,
        };
        let digit = match increment {
            Value::Number(_, DataType::F32) => interval * f64::from(f32::EPSILON),
            _ => 0.0,
        };
        let rate = time_base::rate_of_interval(unit.to_seconds(interval), unit.to_seconds(digit))?;
        Ok(Some(Self {
            start,
            unit,
            rate,
            counts: unit == TimeUnit::SECOND && (interval - 1.0).abs() < 1e-9,
        }))
    }
}

/// Returns the unit of the interval: as a person states it, else as the file does, else seconds. An
/// axis that is none of time is refused.
fn unit_of_x(
    object: &Object,
    stated: Option<TimeUnit>,
    findings: &mut Vec<Finding>,
) -> Result<TimeUnit, Error> {
    let label = |key| object.property(key).map(Value::text);
    let written = label("wf_xunit_string");
    let written_unit = written.as_deref().map(TimeUnit::from_spelling);
    let name = label("wf_xname");
    let says_time = |name: &String| ChannelName::from_header(name, 1).says_time();
    let refused = |statement: String| {
        let hint = format!(
            "export a signal over time, or state the unit with {} = s|ms|us|ns",
            Setting::TimeUnit
        );
        Err(Error::malformed("samples over time", statement, hint))
    };
    match (stated, written_unit, name) {
        (Some(stated), written_unit, _) => {
            if let (Some(written), false) = (
                &written,
                written_unit.flatten().is_none_or(|unit| unit == stated),
            ) {
                let text = format!(
                    "wf_xunit_string is `{}`, but the setting `time_unit` is `{stated}`. The setting \
                     was used. Check which is right",
                    text::shown(written)
                );
                findings.push(Finding::warning("time-unit-overridden", text));
            }
            Ok(stated)
        }
        (None, Some(Some(unit)), _) => Ok(unit),
        (None, Some(None), _) => refused(format!(
            "wf_xunit_string `{}`",
            text::shown(written.unwrap_or_default())
        )),
        (None, None, Some(name)) if !says_time(&name) => {
            refused(format!("wf_xname `{}`", text::shown(name)))
        }
        (None, None, _) => Ok(TimeUnit::SECOND),
    }
}

/// Times of samples.
struct Stamps<'a> {
    name: &'a str,
    values_s: Vec<f64>,
    /// What a stamp may be off by its type [s].
    digit_s: f64,
    /// Whether nothing states their unit.
    is_assumed: bool,
    /// Whether they are instants, counted from the first.
    are_instants: bool,
}

impl<'a> Stamps<'a> {
    fn of(entry: &'a Entry<'_>, asked: ReadTask<'_>) -> Result<Self, Error> {
        let stated = asked.options.time_unit;
        let object = entry.object;
        let name = &*entry.column.name;
        if object.is_left_out {
            let left_out = format!(
                "the channel of times `{}` among more samples",
                text::shown(name)
            );
            return Err(asked.limits.over("test_samples", left_out));
        }
        // Times that are no times without their scale would make another pulse of the samples.
        let is_whole = entry.kind().is_some_and(DataType::is_whole);
        Scales::refuse_any(&entry.objects, is_whole)
            .map_err(|error| error.at(Place::default().channel(name)))?;
        if let Some(error) = &object.error {
            return Err(error.clone());
        }
        if let Some((from, _)) = object.missing {
            let missing = format!("no number as sample {}", from + 1);
            let error = Error::from(KernelError::NonFinite { found: missing });
            return Err(error.at(Place::default().channel(name)));
        }
        let is_instant = entry.kind() == Some(DataType::Timestamp);
        let column_unit = entry
            .column
            .time_unit
            .or(is_instant.then_some(TimeUnit::SECOND));
        let unit = match is_instant {
            true => TimeUnit::SECOND,
            false => stated.or(column_unit).unwrap_or(TimeUnit::SECOND),
        };
        let values_s: Vec<f64> = object
            .values
            .iter()
            .map(|value| unit.to_seconds(*value))
            .collect();
        let last_s = values_s.last().copied().unwrap_or(0.0).abs();
        let digit_s = match entry.kind() {
            // Programs write instants to the microsecond.
            Some(DataType::Timestamp) => 1e-6,
            Some(DataType::F32) => last_s * f64::from(f32::EPSILON),
            Some(kind) if kind.is_whole() => unit.to_seconds(1.0),
            _ => 0.0,
        };
        Ok(Self {
            name,
            values_s,
            digit_s,
            is_assumed: column_unit.is_none() && stated.is_none(),
            are_instants: is_instant,
        })
    }
}

/// The samples of a channel on its clock.
pub(super) struct ChannelClock {
    pub(super) samples: UniformSamples,
    /// What states the clock beside what it was taken from, and agrees with that.
    pub(super) confirmed_by: Option<String>,
    /// What a person must accept of the clock.
    pub(super) doubt: Option<String>,
}

impl ChannelClock {
    /// Finds the clock of a channel: that of the times that a person names; else its own interval;
    /// else the one channel of times in its group; else the rate that a person states.
    pub(super) fn find(
        entries: &[Entry<'_>],
        place: usize,
        is_cut: bool,
        mut values: Vec<f64>,
        asked: ReadTask<'_>,
        findings: &mut Vec<Finding>,
    ) -> Result<Self, Error> {
        let (options, channel) = (asked.options, &entries[place]);
        let waveform = Waveform::of(channel.object, options.time_unit, findings)?;
        let is_timed = waveform.as_ref().is_some_and(|waveform| !waveform.counts);
        let is_named = options.time_column.is_some();
        let beside = match &options.time_column {
            Some(name) => Some(named(entries, channel, name, is_cut)?),
            None => beside(entries, channel, is_timed, is_cut)?,
        };
        let stamps = beside.map(|entry| Stamps::of(entry, asked));
        let mut stamps = stamps.transpose()?;
        let mut doubts = Vec::new();
        if let Some(waveform) = waveform.as_ref().filter(|_| is_timed) {
            for entry in others(entries, channel, beside) {
                let mut stamps = Stamps::of(entry, asked)?;
                stamps.values_s.truncate(values.len());
                match comparison(waveform, &stamps, options.rate_hz) {
                    Comparison::Found(finding) if !findings.contains(&finding) => {
                        findings.push(finding);
                    }
                    Comparison::Overridden(doubt) => doubts.push(doubt),
                    Comparison::Found(_) | Comparison::Confirmed | Comparison::Nothing => {}
                }
            }
        }
        if let Some(stamps) = &mut stamps {
            // Of a file that is cut samples or their times may be the fewer.
            stamps.values_s.truncate(values.len());
            values.truncate(stamps.values_s.len());
        }
        match (waveform, stamps) {
            (waveform, Some(stamps)) if is_named || !is_timed => {
                let (seconds, digit_s) = (&stamps.values_s, stamps.digit_s);
                let samples =
                    UniformSamples::by_stamps(seconds, digit_s, values, asked.limits, findings)?;
                let source = format!("the channel `{}`", text::shown(stamps.name));
                let rate = samples.rate.hertz();
                findings.extend(options.check_rate(rate, (&source, stamps.is_assumed), MEND)?);
                let timed_waveform = waveform.filter(|waveform| !waveform.counts);
                let compared =
                    timed_waveform.map(|waveform| comparison(&waveform, &stamps, options.rate_hz));
                let confirmed = compared.is_some_and(|found| found.tell(findings, &mut doubts));
                Ok(Self {
                    samples,
                    confirmed_by: confirmed.then(|| "wf_increment".into()),
                    doubt: (!doubts.is_empty()).then(|| doubts.join("; ")),
                })
            }
            (Some(waveform), stamps) if is_timed => {
                let rate = waveform.rate;
                let source = ("wf_increment", false);
                findings.extend(options.check_rate(rate.hertz(), source, MEND)?);
                let compared = stamps
                    .as_ref()
                    .map(|stamps| comparison(&waveform, stamps, options.rate_hz));
                let confirmed = compared.is_some_and(|found| found.tell(findings, &mut doubts));
                if !is_cut {
                    findings.extend(fewer_samples(entries, channel));
                }
                let samples = UniformSamples::stated(waveform.start_s(), rate, values)?;
                let name =
                    stamps.map(|stamps| format!("the channel `{}`", text::shown(stamps.name)));
                Ok(Self {
                    samples,
                    confirmed_by: name.filter(|_| confirmed),
                    doubt: (!doubts.is_empty()).then(|| doubts.join("; ")),
                })
            }
            (waveform, _) => {
                let (rate, start_s) = match (waveform, options.rate_hz) {
                    (Some(waveform), _) => {
                        let (rate, finding) = options.untimed(waveform.rate, "wf_increment")?;
                        findings.push(finding);
                        (rate, waveform.start / rate.hertz())
                    }
                    (None, Some(hertz)) => (SampleRate::from_hertz(hertz)?, 0.0),
                    (None, None) => return Err(ErrorKind::MissingTime.into()),
                };
                if options.rate_hz.is_some() {
                    let contradicted =
                        rate_contradiction(entries, channel, rate, values.len(), asked)?;
                    findings.extend(contradicted);
                }
                Ok(Self {
                    samples: UniformSamples::stated(start_s, rate, values)?,
                    confirmed_by: None,
                    doubt: (!doubts.is_empty()).then(|| doubts.join("; ")),
                })
            }
        }
    }
}

/// Holds the rate that a person states for a channel of `count` values against what else of the file shows
/// time: channels of times, and the intervals of its group, of the file and of channels with as many samples.
fn rate_contradiction(
    entries: &[Entry<'_>],
    channel: &Entry<'_>,
    rate: SampleRate,
    count: usize,
    asked: ReadTask<'_>,
) -> Result<Option<Finding>, Error> {
    for entry in others(entries, channel, None) {
        let mut stamps = Stamps::of(entry, asked)?;
        stamps.values_s.truncate(count);
        let first_s = stamps.values_s.first().copied().unwrap_or(0.0);
        let (stamps_s, digit_s) = (&stamps.values_s, stamps.digit_s);
        let stated = HeaderClock {
            source: STATED_RATE,
            start_s: first_s,
            start_digit_s: 0.0,
            start_intervals: 0.0,
            hertz: rate.hertz(),
            slack: 0.0,
        };
        if let Comparison::Found(finding) = stated.compare(stamps_s, digit_s, None) {
            return Ok(Some(finding));
        }
    }
    let alike = entries
        .iter()
        .filter(|entry| entry.object.count == channel.object.count);
    let objects = channel
        .objects
        .iter()
        .copied()
        .chain(alike.map(|entry| entry.object));
    let contradicts = |object: &Object| {
        // An interval that is none of time says nothing.
        let waveform = Waveform::of(object, asked.options.time_unit, &mut Vec::new());
        let waveform = waveform
            .ok()
            .flatten()
            .filter(|waveform| !waveform.counts)?;
        let hertz = waveform.rate.hertz();
        let said = format!("wf_increment of {} gives {hertz} Hz", said::teller(object));
        let used = UsedClock {
            name: STATED_RATE,
            hertz: rate.hertz(),
            stated_hz: None,
        };
        match used.outcome(Relation::between(hertz, rate.hertz(), 0.0), &said) {
            Comparison::Found(finding) => Some(finding),
            Comparison::Confirmed | Comparison::Nothing | Comparison::Overridden(_) => None,
        }
    };
    Ok(objects.into_iter().find_map(contradicts))
}

/// Says that a channel has fewer samples than another one of its group on the same clock: it was left out of
/// some segments, and nothing tells of which.
fn fewer_samples(entries: &[Entry<'_>], channel: &Entry<'_>) -> Option<Finding> {
    const CLOCK: [&str; 4] = [
        "wf_increment",
        "wf_start_offset",
        "wf_xunit_string",
        "wf_start_time",
    ];
    let clock = |object: &'_ Object| CLOCK.map(|key| object.property(key).cloned());
    let own_clock = clock(channel.object);
    let count = channel.object.count;
    // One sample more is what a recorder may write while it stops.
    let longer = entries.iter().find(|entry| {
        entry.object.count > count + 1
            && entry.group == channel.group
            && clock(entry.object) == own_clock
    })?;
    let text = format!(
        "{} holds {} samples by the same clock, but this channel {count}. The others are missing. \
         Export again",
        said::teller(longer.object),
        longer.object.count
    );
    Some(Finding::blocking("samples-missing", text))
}

/// The rate that a person states, in messages.
const STATED_RATE: &str = "the setting `rate_hz`";

/// Holds the interval of a channel against the times beside it; of instants the start is another one.
fn comparison(waveform: &Waveform, stamps: &Stamps<'_>, stated_hz: Option<f64>) -> Comparison {
    let stated = HeaderClock {
        source: "the waveform (wf_increment)",
        start_s: match stamps.are_instants {
            true => 0.0,
            false => waveform.start_s(),
        },
        start_digit_s: 0.0,
        start_intervals: 0.0,
        hertz: waveform.rate.hertz(),
        slack: 0.0,
    };
    stated.compare(&stamps.values_s, stamps.digit_s, stated_hz)
}

/// Returns the channel of times that a person names.
fn named<'a, 'b>(
    entries: &'a [Entry<'b>],
    channel: &Entry<'_>,
    name: &str,
    is_cut: bool,
) -> Result<&'a Entry<'b>, Error> {
    let fits = |(place, entry): &(usize, &Entry<'_>)| {
        let is_number = entry
            .kind()
            .is_some_and(|kind| kind.is_number() || kind == DataType::Timestamp);
        is_number && entry.answers_to(name, place + 1)
    };
    let mut matching: Vec<&Entry<'b>> = entries
        .iter()
        .enumerate()
        .filter(fits)
        .map(|(_, entry)| entry)
        .collect();
    if matching.len() > 1 {
        matching.retain(|entry| entry.group == channel.group);
    }
    let malformed = |counts: String| {
        let expected = format!("one channel of times `{}`", text::shown(name));
        let hint = format!("name it by {} = GROUP/CHANNEL", Setting::TimeColumn);
        Error::malformed(expected, counts, hint)
    };
    match matching.as_slice() {
        [only] if is_cut || only.object.count == channel.object.count => Ok(only),
        [only] => Err(malformed(format!(
            "{} times for {} samples",
            only.object.count, channel.object.count
        ))),
        several => Err(malformed(format!("{} of them", several.len()))),
    }
}

/// Returns the channels of times that an interval is held against beside the one `beside`: all others of the
/// group with about as many values; where the group has none, those of other groups with as many.
fn others<'a, 'b>(
    entries: &'a [Entry<'b>],
    channel: &Entry<'_>,
    beside: Option<&Entry<'_>>,
) -> Vec<&'a Entry<'b>> {
    let count = channel.object.count;
    let clocks = || entries.iter().filter(|entry| entry.is_clock);
    let has_own = clocks().any(|entry| entry.group == channel.group);
    let fits = |entry: &&Entry<'_>| match has_own {
        // One value more or less is a slip, half of them another channel's clock.
        true => {
            entry.group == channel.group && entry.object.count.abs_diff(count) <= 1 + count / 50
        }
        false => entry.object.count == count,
    };
    let is_other = |entry: &&Entry<'_>| beside.is_none_or(|beside| beside.at != entry.at);
    clocks().filter(fits).filter(is_other).collect()
}

/// Returns the one channel of times beside a channel, with as many values. Of several none counts
/// where the channel `is_timed` by itself.
fn beside<'a, 'b>(
    entries: &'a [Entry<'b>],
    channel: &Entry<'_>,
    is_timed: bool,
    is_cut: bool,
) -> Result<Option<&'a Entry<'b>>, Error> {
    let clocks = entries.iter().filter(|entry| {
        entry.is_clock
            && entry.group == channel.group
            && (is_cut || entry.object.count == channel.object.count)
    });
    let clocks: Vec<&Entry<'b>> = clocks.collect();
    match clocks.as_slice() {
        [] => Ok(None),
        [only] => Ok(Some(only).copied()),
        _ if is_timed => Ok(None),
        several => {
            let names: Vec<&str> = several.iter().map(|entry| &*entry.column.name).collect();
            let hint = format!("name one by {} = NAME", Setting::TimeColumn);
            let shown_names = text::shown(names.join(", "));
            Err(Error::malformed(
                "one channel of times in the group",
                shown_names,
                hint,
            ))
        }
    }
}
