//! `latchgate inspect`: the channels of a recording. Judges nothing.

use super::failure::Failure;
use super::offers::{command_words, offers};
use super::options::{Common, InspectArguments};
use super::output;
use super::progress::Progress;
use super::values::OutputFormat;
use crate::pipeline::{self, ChannelStatus, ListedChannel, Listing, TableMapping};
use latchgate_document::number;
use latchgate_kernel::units::AccelerationUnit;
use latchgate_kernel::units::short;
use latchgate_recording::{Finding, Limits};
use latchgate_report::terminal::{self, Look};
use latchgate_report::{escape, test_facts};
use latchgate_verdict::sled::SledCheck;
use std::fmt::Write as _;
use std::path::Path;

/// Runs the command; returns the exit code.
pub(super) fn command(arguments: &InspectArguments, common: &Common) -> Result<u8, Failure> {
    let mut request = arguments.read.request(common).map_err(Failure::Usage)?;
    request.sled206 = arguments.sled206;
    request.check().map_err(Failure::Usage)?;
    let source = arguments.read.source().map_err(Failure::Data)?;
    let step = format!("inspect {}", source.name());
    let progress = Progress::new(&step);
    let listing = progress.watch(&step, common.thread_count(), |control| {
        pipeline::inspect(&source, &request, &Limits::default(), control)
    });
    drop(progress);
    let listing = listing.map_err(Failure::of_data)?;
    match common.format {
        OutputFormat::Json => output::document(&latchgate_document::json::render(&listing)),
        OutputFormat::Text => output::text(&table(
            &listing,
            &arguments.read.recording,
            output::look(common),
        )),
    }
    .map_err(Failure::Data)?;
    Ok(0)
}

fn table(listing: &Listing, recording: &Path, look: Look) -> String {
    let source = &listing.recording;
    let mut text = format!(
        "{}  ({}, sha256 {})\n",
        escape::terminal(&source.file),
        source.format,
        source.sha256
    );
    if let Some(mapping) = &listing.table {
        table_head(&mut text, mapping, look.width);
    }
    stated_facts(&mut text, listing, look);
    channels(&mut text, &listing.channels, look.width);
    choice(&mut text, listing, look.width);
    text += &offers(recording, &listing.replay.offers, &command_words());
    for sentence in listing.sled206.iter().flat_map(SledCheck::sentences) {
        push_wrapped(&mut text, &sentence, look.width);
    }
    findings(&mut text, listing, look);
    text
}

/// Writes the lines of a table's names, units and samples, and the text above them.
fn table_head(text: &mut String, mapping: &TableMapping, width: Option<usize>) {
    let name = |what: &str, name: &str| format!("{what} `{}`", escape::terminal(name));
    let line = |what: &str, line: Option<u64>| Some(format!("{what} line {}", line?));
    let time = mapping.time_column.as_ref().map(|column| {
        let unit = mapping.time_unit.as_ref();
        let unit = unit.map_or(String::new(), |unit| {
            format!(" in {}", escape::terminal(unit))
        });
        format!("{}{unit}", name("time in", column))
    });
    let sheet = mapping.sheet.as_ref().map(|sheet| name("sheet", sheet));
    let facts = [
        sheet,
        line("names on", mapping.header_line),
        line("units on", mapping.unit_line),
        line("samples from", mapping.data_line),
        time,
    ];
    let facts: Vec<String> = facts.into_iter().flatten().collect();
    push_wrapped(text, &format!("table: {}", facts.join(", ")), width);
    if !mapping.above.is_empty() {
        let above = escape::terminal(&mapping.above.join("; ")).into_owned();
        push_wrapped(text, &format!("above it: {above}"), width);
    }
}

/// Lists the statements of a file's header about a channel, except its place and its sensor.
fn stated(entry: &ListedChannel) -> Vec<String> {
    let stated = &entry.stated;
    let unit = entry.unit.map(AccelerationUnit::name);
    let unit_source = unit.map(|unit| format!("unit {unit} by {}", entry.unit_source));
    let full_scale = stated.full_scale.map(|scale| {
        let scale = number::plain(scale, 5);
        format!("full scale {scale} {}", unit.unwrap_or_default())
    });
    let corner = stated
        .prefilter_hz
        .map(|hertz| format!("analogue filter to {} Hz", short(hertz, 6)));
    let class = stated
        .filter_class
        .as_ref()
        .map(|class| format!("filtered by CFC {class}"));
    let unfiltered = stated.unfiltered.then(|| "not filtered".to_string());
    let gravity = stated.gravity.then(|| "with gravity".to_string());
    let status = stated
        .status
        .as_ref()
        .map(|status| format!("status {status}"));
    let clock = stated
        .clock_confirmed_by
        .as_ref()
        .map(|source| format!("rate confirmed by {source}"));
    [
        unit_source,
        full_scale,
        corner,
        class,
        unfiltered,
        gravity,
        status,
        clock,
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Writes the statements of the file about the test, then those about single channels. Without `-v`
/// channels that a replay skips are left out.
fn stated_facts(text: &mut String, listing: &Listing, look: Look) {
    for (name, value) in test_facts(&listing.test) {
        let line = format!("{}: {}", name.to_lowercase(), escape::terminal(&value));
        push_wrapped(text, &line, look.width);
    }
    for entry in listing
        .channels
        .iter()
        .filter(|entry| is_shown(entry, look.detail))
    {
        let facts = test_facts(&entry.stated.test.beyond(&listing.test));
        let facts: Vec<String> = facts.into_iter().map(|(_, value)| value).collect();
        for facts in [facts, stated(entry)]
            .iter()
            .filter(|facts| !facts.is_empty())
        {
            let (name, facts) = (&entry.name, facts.join("; "));
            let (name, facts) = (escape::terminal(name), escape::terminal(&facts));
            push_wrapped(text, &format!("{name}: {facts}"), look.width);
        }
    }
}

/// Writes a line, wrapped with a hanging indent.
fn push_wrapped(text: &mut String, line: &str, width: Option<usize>) {
    text.push_str(&terminal::wrapped(line, width, 4));
    text.push('\n');
}

/// True if a replay takes or offers a channel, or all are requested.
fn is_shown(entry: &ListedChannel, all: bool) -> bool {
    all || entry.status != ChannelStatus::PassedOver
}

/// Writes a line for each channel, in columns; without its shape where that does not fit.
fn channels(text: &mut String, channels: &[ListedChannel], width: Option<usize>) {
    let mut rows = vec![
        [
            "channel", "status", "unit", "samples", "rate Hz", "from s", "to s", "peak", "at s",
            "shape",
        ]
        .map(String::from),
    ];
    for entry in channels {
        rows.push([
            escape::terminal(&entry.name).into_owned(),
            match (entry.status, &entry.unit) {
                (ChannelStatus::Taken, _) => "taken",
                (ChannelStatus::Offered, _) => "offered",
                (ChannelStatus::PassedOver, None) => "no unit",
                (ChannelStatus::PassedOver, Some(_)) => "passed over",
            }
            .to_string(),
            entry.unit.map_or("?", AccelerationUnit::name).to_string(),
            entry.samples.to_string(),
            short(entry.sample_rate_hz, 7),
            short(entry.start_s, 6),
            short(entry.end_s, 6),
            number::plain(entry.peak, 5),
            short(entry.peak_time_s, 5),
            entry.spark.clone(),
        ]);
    }
    let widths: Vec<usize> = (0..10)
        .map(|column| {
            rows.iter()
                .map(|row| row[column].chars().count())
                .max()
                .unwrap_or(0)
        })
        .collect();
    let table_width = widths.iter().sum::<usize>() + 2 * (widths.len() - 1);
    let shape_fits = width.is_none_or(|width| table_width <= width);
    let shown = if shape_fits { 10 } else { 9 };
    for row in &rows {
        for (column, cell) in row.iter().take(shown).enumerate() {
            let pad = " ".repeat(widths[column].saturating_sub(cell.chars().count()));
            // Words are aligned left, numbers right.
            let _ = match column {
                0..=2 => write!(text, "{cell}{pad}  "),
                9 => write!(text, "{cell}"),
                _ => write!(text, "{pad}{cell}  "),
            };
        }
        text.truncate(text.trim_end_matches(' ').len());
        text.push('\n');
    }
}

/// Writes the channel that a replay takes, and the reason.
fn choice(text: &mut String, listing: &Listing, width: Option<usize>) {
    match (&listing.replay.channel, &listing.replay.reason) {
        (Some(name), reason) => {
            let _ = writeln!(text, "replay takes: {}", escape::terminal(name));
            if let Some(reason) = reason {
                push_wrapped(
                    text,
                    &format!("because {}", escape::terminal(reason)),
                    width,
                );
            }
            let channel = listing.channels.iter().find(|entry| entry.name == *name);
            if let Some(hash) = channel.and_then(|entry| entry.content_sha256.as_ref()) {
                let _ = writeln!(text, "signal: sha256 {hash}, the same in any file format");
            }
        }
        (None, Some(reason)) => {
            let line = format!("replay takes none: {}", escape::terminal(reason));
            push_wrapped(text, &line, width);
        }
        (None, None) => {}
    }
}

/// Writes the findings, the gravest first. A finding that several channels share, such as that of a
/// clock, is written once. Without `-v` those of channels that a replay skips are only counted.
fn findings(text: &mut String, listing: &Listing, look: Look) {
    let shown = |entry: &&ListedChannel| is_shown(entry, look.detail);
    let channel_findings = listing.channels.iter().filter(shown).flat_map(|entry| {
        let findings = entry.findings.iter();
        findings.map(move |finding| (Some(&entry.name), finding))
    });
    let mut distinct: Vec<(Vec<&String>, &Finding)> = Vec::new();
    for (name, finding) in listing
        .findings
        .iter()
        .map(|finding| (None, finding))
        .chain(channel_findings)
    {
        match distinct.iter_mut().find(|(_, listed)| *listed == finding) {
            Some((names, _)) => names.extend(name),
            None => distinct.push((name.into_iter().collect(), finding)),
        }
    }
    distinct.sort_by_key(|(_, finding)| std::cmp::Reverse(finding.severity));
    for (names, finding) in distinct {
        let severity = finding.severity.name();
        let place = finding
            .at_s
            .map_or_else(String::new, |time_s| format!(" at {} s", short(time_s, 6)));
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
        let finding_text = (look.worded)(&finding.text);
        let finding_text = escape::terminal(&finding_text);
        let line = format!("{severity} {}{place}: {owner}{finding_text}", finding.code);
        push_wrapped(text, &line, look.width);
    }
    let skipped = listing.channels.iter().filter(|entry| !shown(entry));
    let hidden: usize = skipped.map(|entry| entry.findings.len()).sum();
    if hidden > 0 {
        let _ = writeln!(text, "{hidden} findings on other channels; -v shows them");
    }
}
