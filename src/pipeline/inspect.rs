//! What a recording holds, channel by channel; judges nothing.

use super::candidates::{self, Offer};
use latchgate_document::request::Request;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::units::AccelerationUnit;
use latchgate_recording::csv::TableMapping;
use latchgate_recording::error::{Error, ErrorKind, Place};
use latchgate_recording::setting::Setting;
use latchgate_recording::{
    self, Card, Channel, Finding, Limits, Part, ReadOptions, Reading, Recording, Source, Stated,
    TestFacts,
};
use latchgate_report::codes;
use latchgate_verdict::conditioning::{self, ConditioningOptions, neighbours};
use latchgate_verdict::sled::{self, SledCheck};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// What a recording holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Listing {
    /// `latchgate.inspect/1`.
    pub schema: Cow<'static, str>,
    /// The file.
    pub recording: ListedFile,
    /// How a text table or a sheet of a workbook was understood.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub table: Option<TableMapping>,
    /// What is said of the test, where the file says it of every channel listed.
    #[serde(default)]
    pub test: TestFacts,
    /// Every channel that carries numbers.
    pub channels: Vec<ListedChannel>,
    /// The channel that a replay would take with the same settings, or why it takes none.
    pub replay: Choice,
    /// The samples of that channel, as a replay reads them; `None` where it takes none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub series: Option<ListedSeries>,
    /// What that channel is as a sled pulse, where that was asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sled206: Option<SledCheck>,
    /// What was found odd in the file as a whole.
    pub findings: Vec<Finding>,
}

/// The samples of the channel that a replay takes, those of the series of its report.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ListedSeries {
    /// Time of each [s].
    pub time_s: Vec<f64>,
    /// Acceleration as recorded [m/s²].
    pub acceleration_recorded_m_s2: Vec<f64>,
}

/// What a replay would do with a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ChannelStatus {
    /// It takes it.
    Taken,
    /// It asks whether it is meant.
    Offered,
    /// It passes it over.
    PassedOver,
}

/// The file of a listing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ListedFile {
    /// File name without folders.
    pub file: String,
    /// SHA-256 of its bytes; of a folder, that of its list of parts.
    pub sha256: String,
    /// Further files that were read with it.
    pub parts: Vec<Part>,
    /// Format name.
    pub format: Cow<'static, str>,
}

/// Which channel a replay takes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// Its name.
    pub channel: Option<String>,
    /// Why this channel, or why none.
    pub reason: Option<String>,
    /// What the setting `channel` takes for each of the channels among which it has to choose.
    pub candidates: Vec<String>,
    /// The same with their shapes.
    #[serde(skip)]
    pub offers: Vec<Offer>,
    /// Their names as the file has them.
    #[serde(skip)]
    offered: Vec<String>,
    /// The channel itself: its name may be that of another one, too.
    #[serde(skip)]
    taken: Option<Channel>,
}

/// A channel of a listing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ListedChannel {
    /// Name.
    pub name: String,
    /// What a replay would do with it.
    pub status: ChannelStatus,
    /// Unit; `None` where nothing states one.
    pub unit: Option<AccelerationUnit>,
    /// What states it.
    pub unit_source: Cow<'static, str>,
    /// Number of samples.
    pub samples: usize,
    /// Sample rate [Hz].
    pub sample_rate_hz: f64,
    /// Time of the first sample [s].
    pub start_s: f64,
    /// Time of the last sample [s].
    pub end_s: f64,
    /// Value of largest magnitude, in `unit`.
    pub peak: f64,
    /// When [s].
    pub peak_time_s: f64,
    /// SHA-256 of the signal itself, whatever file it came from; `None` without a unit.
    pub content_sha256: Option<String>,
    /// What the file says of the channel beside its samples.
    pub stated: Stated,
    /// The sensor's place spelt out, where the file has a code for it that is known here.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
    /// What is odd about it.
    pub findings: Vec<Finding>,
    /// Its shape in a line of text.
    #[serde(skip)]
    pub spark: String,
}

/// Lists what a recording holds, and which channel a replay would take with the same settings.
///
/// # Examples
///
/// ```
/// use latchgate::pipeline::{Control, Limits, Request, Source, inspect};
///
/// let source = Source::File("signals/burst.csv".into());
/// let listing = inspect(&source, &Request::default(), &Limits::default(), &Control::default())?;
/// assert_eq!(listing.replay.channel.as_deref(), Some("acceleration y (g)"));
/// assert_eq!(listing.channels[0].samples, 6001);
/// # Ok::<(), latchgate_recording::error::Error>(())
/// ```
///
/// # Errors
///
/// Any [`ErrorKind`] of reading; [`ErrorKind::NoChannel`] where nothing carries numbers;
/// [`Stopped`](latchgate_kernel::error::Error::Stopped) if `control` ends the work.
pub fn inspect(
    source: &Source,
    request: &Request,
    limits: &Limits,
    control: &Control<'_>,
) -> Result<Listing, Error> {
    request.check()?;
    let limits = &request.limits(limits)?;
    let card = latchgate_recording::card::read_beside(source, limits)?
        .map_or_else(Card::default, |(card, _)| card);
    let options = request.read_options(&card);
    control.check()?;
    let Reading { chosen, every } =
        latchgate_recording::read_both(source, &options, limits, control);
    control.check()?;
    let every = every?;
    if every.channels.is_empty() {
        return Err(nothing_read(source, &every, chosen));
    }
    let conditioning = request.conditioning_options(&card);
    let sled206 = match (request.sled206, &chosen) {
        (false, _) => None,
        (true, Err(error)) => return Err(error.clone()),
        (true, Ok(recording)) => sled_check(recording, &conditioning)?,
    };
    let choice = choice(request, &options, chosen, &every);
    Ok(Listing {
        sled206,
        ..listing(every, choice, &conditioning)
    })
}

/// Checks the channel that a replay takes as a sled pulse.
fn sled_check(
    recording: &Recording,
    conditioning: &ConditioningOptions,
) -> Result<Option<SledCheck>, Error> {
    let Some(channel) = recording.channels.first() else {
        return Ok(None);
    };
    let checked = conditioning::condition(channel, conditioning)
        .and_then(|conditioned| {
            let mut findings = recording.findings.clone();
            findings.extend(channel.findings.iter().cloned());
            findings.extend(conditioned.findings.iter().cloned());
            sled::check(&conditioned, &findings)
        })
        .map_err(|error| error.at(Place::file(recording.file.clone())))?;
    Ok(Some(checked.0))
}

/// Says how a text table is understood with the same settings, or, where a person is asked, how it
/// seems to be; `None` of another format, and where nothing like a table is found.
///
/// # Examples
///
/// ```
/// use latchgate::pipeline::{Control, Limits, Request, Source, table_mapping};
///
/// let text = "Zeit [ms];a_y [g]\n0,1;2,5\n0,2;2,6\n0,3;2,7\n";
/// let source = Source::bytes("test.csv", text.as_bytes());
/// let (request, limits) = (Request::default(), Limits::default());
/// let mapping = table_mapping(&source, &request, &limits, &Control::default())?.unwrap();
/// assert_eq!((&*mapping.separator, mapping.decimal.as_deref()), ("semicolon", Some(",")));
/// assert_eq!((mapping.header_line, mapping.data_line), (Some(1), Some(2)));
/// assert_eq!(mapping.time_unit.as_deref(), Some("ms"));
/// # Ok::<(), latchgate_recording::error::Error>(())
/// ```
///
/// # Errors
///
/// [`ErrorKind`] of settings and card.
pub fn table_mapping(
    source: &Source,
    request: &Request,
    limits: &Limits,
    control: &Control<'_>,
) -> Result<Option<TableMapping>, Error> {
    request.check()?;
    let limits = &request.limits(limits)?;
    let card = latchgate_recording::card::read_beside(source, limits)?
        .map_or_else(Card::default, |(card, _)| card);
    let options = request.read_options(&card);
    Ok(latchgate_recording::table_mapping(
        source, &options, limits, control,
    ))
}

/// Says why a recording holds no channel.
fn nothing_read(source: &Source, every: &Recording, chosen: Result<Recording, Error>) -> Error {
    // Where it is one channel's fault, the message of a replay says it best; of a log it lists the
    // topics with their fields as well.
    let lists_topics = every
        .findings
        .iter()
        .any(|one| one.code == "topics-left-out");
    if let Err(error) = chosen
        && (lists_topics || !matches!(error.kind(), ErrorKind::NoChannel { .. }))
    {
        return error;
    }
    // What the reader passed over is all there is to tell.
    let passed_over: Vec<&str> = every
        .findings
        .iter()
        .map(|finding| finding.text.as_str())
        .collect();
    let known = if passed_over.is_empty() {
        "no channel of numbers".into()
    } else {
        format!("no channel of numbers ({})", passed_over.join("; "))
    };
    Error::from(ErrorKind::NoChannel { known }).at(Place::file(source.name()))
}

/// Says which channel a replay takes, and why.
fn choice(
    request: &Request,
    options: &ReadOptions,
    chosen: Result<Recording, Error>,
    every: &Recording,
) -> Choice {
    let recording = match chosen {
        Ok(recording) => recording,
        Err(error) => {
            let offers = candidates::offers(&error, &every.channels);
            return Choice {
                channel: None,
                reason: Some(error.to_string()),
                candidates: offers.iter().map(|offer| offer.channel.clone()).collect(),
                offers,
                offered: match error.kind() {
                    ErrorKind::AmbiguousChannel { candidates } => {
                        let names = candidates.0.iter().map(|candidate| candidate.name.clone());
                        names.collect()
                    }
                    _ => Vec::new(),
                },
                taken: None,
            };
        }
    };
    let channel = recording.channels.first();
    let of_channel = channel.into_iter().flat_map(|channel| &channel.findings);
    let told = recording
        .findings
        .iter()
        .chain(of_channel)
        .find(|finding| matches!(&*finding.code, "channel-chosen" | "channel-not-lateral"));
    let plain = if request.channel.is_some() {
        format!("{} names it", Setting::Channel)
    } else if options.channel.is_some() {
        "the card names it".into()
    } else if every.channels.len() == 1 {
        "it is the only channel".into()
    } else {
        "no other channel is a lateral acceleration".into()
    };
    Choice {
        channel: channel.map(|channel| channel.name.clone()),
        reason: Some(match told {
            None => plain,
            Some(finding) if finding.code == "channel-chosen" => finding.text.clone(),
            Some(finding) => format!("{plain}, but: {}", finding.text),
        }),
        candidates: Vec::new(),
        offers: Vec::new(),
        offered: Vec::new(),
        taken: recording.channels.into_iter().next(),
    }
}

fn listing(recording: Recording, choice: Choice, conditioning: &ConditioningOptions) -> Listing {
    let mut beside = neighbours::findings(&recording.channels);
    let gravity = (0..recording.channels.len().min(neighbours::MOST))
        .filter_map(|index| Some((index, neighbours::gravity(&recording.channels, index)?)));
    beside.extend(gravity);
    let status = |channel: &Channel| match &choice.taken {
        Some(taken) if taken.name == channel.name && taken.values == channel.values => {
            ChannelStatus::Taken
        }
        None if choice.offered.contains(&channel.name) => ChannelStatus::Offered,
        _ => ChannelStatus::PassedOver,
    };
    let series = choice.taken.as_ref().and_then(series);
    let facts = recording
        .channels
        .iter()
        .map(|channel| &channel.stated.test);
    let test = facts.clone().next().map(|first| {
        let shared = |known: TestFacts, other: &TestFacts| known.shared_with(other);
        facts.fold(first.clone(), shared)
    });
    Listing {
        schema: "latchgate.inspect/1".into(),
        sled206: None,
        recording: ListedFile {
            file: recording.file,
            sha256: recording.sha256,
            parts: recording.parts,
            format: recording.format.into(),
        },
        table: recording.table,
        test: test.unwrap_or_default(),
        channels: recording
            .channels
            .into_iter()
            .enumerate()
            .map(|(index, channel)| {
                let own = beside.iter().filter(|(of, _)| *of == index);
                listed(
                    status(&channel),
                    channel,
                    conditioning,
                    own.map(|(_, finding)| finding.clone()),
                )
            })
            .collect(),
        replay: choice,
        series,
        findings: recording.findings,
    }
}

/// Returns the samples of a channel in the unit of a report's series.
fn series(channel: &Channel) -> Option<ListedSeries> {
    let factor = channel.unit?.metres_per_second_squared();
    let count = channel.values.len();
    Some(ListedSeries {
        time_s: (0..count).map(|index| channel.time_s(index)).collect(),
        acceleration_recorded_m_s2: channel.values.iter().map(|value| value * factor).collect(),
    })
}

fn listed(
    status: ChannelStatus,
    channel: Channel,
    conditioning: &ConditioningOptions,
    beside: impl Iterator<Item = Finding>,
) -> ListedChannel {
    let count = channel.values.len();
    let (start_s, end_s) = (channel.start_s, channel.time_s(count.saturating_sub(1)));
    let mut peak = (0, 0.0_f64);
    for (index, value) in channel.values.iter().enumerate() {
        if value.abs() > peak.1.abs() {
            peak = (index, *value);
        }
    }
    let peak_time_s = channel.time_s(peak.0);
    let content_sha256 = channel.content_sha256();
    let mut findings = channel.findings.clone();
    if channel.unit.is_some() && count >= 2 {
        match conditioning::inspect(&channel, conditioning) {
            Ok(odd) => findings.extend(odd),
            Err(error) => findings.push(Finding::warning(
                "samples-unusable",
                format!("replay refuses this channel: {error}"),
            )),
        }
    }
    findings.extend(beside);
    ListedChannel {
        spark: candidates::spark(&channel.values),
        name: channel.name,
        status,
        unit: channel.unit,
        unit_source: channel.unit_source.into(),
        samples: count,
        sample_rate_hz: channel.rate.hertz(),
        start_s,
        end_s,
        peak: peak.1,
        peak_time_s,
        content_sha256,
        place: channel
            .stated
            .test
            .location
            .as_deref()
            .and_then(codes::spelt),
        stated: channel.stated,
        findings,
    }
}
