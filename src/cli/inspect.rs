//! `latchgate inspect`: what a recording holds. Judges nothing.

use super::args::{Common, InspectArguments, OutputFormat};
use super::candidates::{self, Offer};
use super::replay::{check_format_name, read_options, source};
use super::{Failure, output};
use crate::conditioning::{self, ConditioningOptions, neighbours};
use crate::error::ErrorKind;
use crate::recording::{self, Channel, Finding, Recording, Selection};
use crate::report::{escape, number};
use serde::Serialize;
use std::fmt::Write as _;
use std::path::Path;

/// The document that `inspect --format json` prints.
#[derive(Debug, Serialize)]
struct Listing {
    schema: &'static str,
    recording: Source,
    channels: Vec<Entry>,
    /// The channel that `replay` would take with the same options, or why it takes none.
    replay: Choice,
    findings: Vec<Finding>,
}

#[derive(Debug, Serialize)]
struct Source {
    file: String,
    sha256: String,
    /// Further files that were read with it.
    parts: Vec<recording::Part>,
    format: &'static str,
}

#[derive(Debug, Serialize)]
struct Choice {
    channel: Option<String>,
    /// Why this channel, or why none.
    reason: Option<String>,
    /// What `--channel` takes for each of the channels among which it has to choose.
    candidates: Vec<String>,
    #[serde(skip)]
    offers: Vec<Offer>,
}

#[derive(Debug, Serialize)]
struct Entry {
    name: String,
    unit: Option<&'static str>,
    unit_source: &'static str,
    samples: usize,
    sample_rate_hz: f64,
    start_s: f64,
    end_s: f64,
    /// Value of largest magnitude, in `unit`.
    peak: f64,
    peak_time_s: f64,
    /// SHA-256 of the signal itself, whatever file it came from; `None` without a unit.
    content_sha256: Option<String>,
    stated: recording::Stated,
    findings: Vec<Finding>,
    #[serde(skip)]
    spark: String,
}

/// Runs the command; returns the exit code.
pub(super) fn command(own: &InspectArguments, common: &Common) -> Result<u8, Failure> {
    check_format_name(own.read.input_format.as_deref()).map_err(Failure::Usage)?;
    let limits = common.limits().map_err(Failure::Usage)?;
    let source = source(&own.read.recording)
        .held_in_memory(&limits)
        .map_err(Failure::Data)?;
    let mut options = read_options(&own.read, common);
    let mut conditioning = ConditioningOptions::default();
    if let Some((card, _)) =
        recording::card::read_beside(&super::replay::source(&own.read.recording), &limits)
            .map_err(Failure::Data)?
    {
        card.merge_into(&mut options);
        conditioning.range_g = card.range_g;
        conditioning.synthetic = card.synthetic;
    }
    let everything =
        recording::read(&source, &options, Selection::Every, &limits).map_err(Failure::Data)?;
    if everything.channels.is_empty() {
        // Where it is one channel's fault, replay's own message says it best.
        if let Err(error) = recording::read(&source, &options, Selection::Lateral, &limits)
            && !matches!(error.kind(), ErrorKind::NoChannel { .. })
        {
            return Err(Failure::Data(error));
        }
        // What the reader passed over is all there is to tell.
        let passed_over: Vec<&str> = everything
            .findings
            .iter()
            .map(|finding| finding.text.as_str())
            .collect();
        let known = if passed_over.is_empty() {
            "no channel of numbers".into()
        } else {
            format!("no channel of numbers ({})", passed_over.join("; "))
        };
        return Err(Failure::Data(
            crate::error::Error::from(ErrorKind::NoChannel { known })
                .at(crate::error::Place::file(source.name())),
        ));
    }
    let choice = match recording::read(&source, &options, Selection::Lateral, &limits) {
        Ok(chosen) => {
            let channel = chosen.channels.first();
            let of_channel = channel.into_iter().flat_map(|channel| &channel.findings);
            let why =
                chosen.findings.iter().chain(of_channel).find(|finding| {
                    matches!(&*finding.code, "channel-chosen" | "channel-not-lateral")
                });
            let plain = if own.read.channel.is_some() {
                "--channel names it"
            } else if options.channel.is_some() {
                "the card names it"
            } else if everything.channels.len() == 1 {
                "it is the only channel"
            } else {
                "no other channel is a lateral acceleration"
            };
            Choice {
                channel: channel.map(|channel| channel.name.clone()),
                reason: Some(match why {
                    None => plain.into(),
                    Some(finding) if finding.code == "channel-chosen" => finding.text.clone(),
                    Some(finding) => format!("{plain}, but: {}", finding.text),
                }),
                candidates: Vec::new(),
                offers: Vec::new(),
            }
        }
        Err(error) => {
            let offers = candidates::offers(&error, &everything.channels);
            Choice {
                channel: None,
                reason: Some(error.to_string()),
                candidates: offers.iter().map(|offer| offer.channel.clone()).collect(),
                offers,
            }
        }
    };
    let listing = listing(everything, choice, &conditioning);
    match common.format {
        OutputFormat::Json => {
            let mut text = serde_json::to_string_pretty(&listing).map_err(|error| {
                Failure::Data(
                    ErrorKind::Io {
                        action: "write the listing",
                        reason: error.to_string(),
                    }
                    .into(),
                )
            })?;
            text.push('\n');
            output::document(&text)
        }
        OutputFormat::Text => output::text(&table(&listing, &own.read.recording)),
    }
    .map_err(Failure::Data)?;
    Ok(0)
}

fn listing(recording: Recording, choice: Choice, conditioning: &ConditioningOptions) -> Listing {
    let beside = neighbours::findings(&recording.channels);
    Listing {
        schema: "latchgate.inspect/1",
        recording: Source {
            file: recording.file,
            sha256: recording.sha256,
            parts: recording.parts,
            format: recording.format,
        },
        channels: recording
            .channels
            .into_iter()
            .enumerate()
            .map(|(index, channel)| {
                let own = beside.iter().filter(|(of, _)| *of == index);
                entry(
                    channel,
                    conditioning,
                    own.map(|(_, finding)| finding.clone()),
                )
            })
            .collect(),
        replay: choice,
        findings: recording.findings,
    }
}

fn entry(
    channel: Channel,
    conditioning: &ConditioningOptions,
    beside: impl Iterator<Item = Finding>,
) -> Entry {
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
                format!("replay would refuse the channel: {error}"),
            )),
        }
    }
    findings.extend(beside);
    Entry {
        spark: candidates::spark(&channel.values),
        name: channel.name,
        unit: channel.unit.map(crate::units::AccelerationUnit::name),
        unit_source: channel.unit_source,
        samples: count,
        sample_rate_hz: channel.rate.hertz(),
        start_s,
        end_s,
        peak: peak.1,
        peak_time_s,
        content_sha256,
        stated: channel.stated,
        findings,
    }
}

/// Returns a number with so many significant digits, zeros at the end left out.
fn short(value: f64, digits: usize) -> String {
    let text = number::plain(value, digits);
    if text.contains('.') && !text.contains('e') {
        text.trim_end_matches('0').trim_end_matches('.').to_string()
    } else {
        text
    }
}

fn table(listing: &Listing, asked: &Path) -> String {
    let mut text = String::new();
    let source = &listing.recording;
    let _ = writeln!(
        text,
        "{}  ({}, sha256 {})",
        escape::terminal(&source.file),
        source.format,
        source.sha256
    );
    let mut rows = vec![
        [
            "channel", "unit", "samples", "rate Hz", "from s", "to s", "peak", "at s", "shape",
        ]
        .map(String::from),
    ];
    for entry in &listing.channels {
        rows.push([
            escape::terminal(&entry.name).into_owned(),
            entry.unit.unwrap_or("?").to_string(),
            entry.samples.to_string(),
            short(entry.sample_rate_hz, 7),
            short(entry.start_s, 6),
            short(entry.end_s, 6),
            number::plain(entry.peak, 5),
            short(entry.peak_time_s, 5),
            entry.spark.clone(),
        ]);
    }
    let widths: Vec<usize> = (0..9)
        .map(|column| {
            rows.iter()
                .map(|row| row[column].chars().count())
                .max()
                .unwrap_or(0)
        })
        .collect();
    for row in &rows {
        for (column, cell) in row.iter().enumerate() {
            let pad = " ".repeat(widths[column].saturating_sub(cell.chars().count()));
            // Words to the left, numbers to the right.
            let _ = match column {
                0 | 1 => write!(text, "{cell}{pad}  "),
                8 => write!(text, "{cell}"),
                _ => write!(text, "{pad}{cell}  "),
            };
        }
        text.truncate(text.trim_end_matches(' ').len());
        text.push('\n');
    }
    match (&listing.replay.channel, &listing.replay.reason) {
        (Some(name), reason) => {
            let _ = writeln!(text, "replay takes: {}", escape::terminal(name));
            if let Some(reason) = reason {
                let _ = writeln!(text, "because {}", escape::terminal(reason));
            }
            let taken = listing.channels.iter().find(|entry| entry.name == *name);
            if let Some(hash) = taken.and_then(|entry| entry.content_sha256.as_ref()) {
                let _ = writeln!(text, "signal: sha256 {hash}, whatever file it came from");
            }
        }
        (None, Some(reason)) => {
            let _ = writeln!(text, "replay takes none: {}", escape::terminal(reason));
        }
        (None, None) => {}
    }
    text += &candidates::lines(asked, &listing.replay.offers);
    let of_channels = listing.channels.iter().flat_map(|entry| {
        entry
            .findings
            .iter()
            .map(move |finding| (Some(&entry.name), finding))
    });
    // What several channels share, such as a clock, is said once.
    let mut told: Vec<(Vec<&String>, &Finding)> = Vec::new();
    for (name, finding) in listing
        .findings
        .iter()
        .map(|finding| (None, finding))
        .chain(of_channels)
    {
        match told.iter_mut().find(|(_, known)| *known == finding) {
            Some((names, _)) => names.extend(name),
            None => told.push((name.into_iter().collect(), finding)),
        }
    }
    told.sort_by_key(|(_, finding)| std::cmp::Reverse(finding.severity));
    for (names, finding) in told {
        let severity = format!("{:?}", finding.severity).to_lowercase();
        let place = finding
            .at_s
            .map_or_else(String::new, |at| format!(" at {} s", short(at, 6)));
        let owner = match names.as_slice() {
            [] => String::new(),
            [name] => format!("{}: ", escape::terminal(name)),
            _ if names.len() == listing.channels.len() => "every channel: ".into(),
            [first, .., last] => format!(
                "{} channels, {} to {}: ",
                names.len(),
                escape::terminal(first),
                escape::terminal(last)
            ),
        };
        let _ = writeln!(
            text,
            "{severity} {}{place}: {owner}{}",
            finding.code,
            escape::terminal(&finding.text)
        );
    }
    text
}
