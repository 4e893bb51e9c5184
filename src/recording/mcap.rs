//! MCAP logs: messages of ROS 2 (CDR) and ROS 1, protobuf by its own descriptor, and JSON.
//!
//! The file is read once, from the first byte to the last, record by record. Memory is
//! bounded by one record (`mcap_record_bytes`), one chunk unpacked (`mcap_chunk_bytes`; the
//! zstd decoder may hold as much again), the schemas (together at most `mcap_record_bytes`)
//! and the samples kept: per topic at most `samples`, in all at most four times as many
//! values, times included.
//!
//! A log that was cut, damaged or put together from two must not pass for a whole one, so
//! everything the file says of itself is held against what it holds: the checksums of
//! chunks, data and summary, the numbers of messages in the statistics, the chunk index, the
//! start of the summary, and that nothing follows the first footer and end magic. A file
//! that says nothing of itself is read with a warning.
//!
//! # Source
//!
//! The MCAP specification, <https://mcap.dev/spec>; REP 103 for units and axes.
//!
//! - `cdr`: CDR, the encoding of ROS 2 messages: numbers aligned to their size, in either byte
//!   order;
//! - `decompress`: chunks: decompression within limits, checked against the chunk's own size and
//!   checksum;
//! - `json`: JSON messages: one walk through the text that hands out every scalar with its path;
//! - `layout`: where in the messages of a type stands what is wanted of them, and in which unit;
//! - `protobuf`: Protobuf messages, read by the descriptor that the file itself carries;
//! - `records`: the records of an MCAP file, read with checked lengths;
//! - `ros`: ROS message definitions (`ros2msg`, `ros1msg`): from the text in the file to a plan
//!   that finds numbers in a message;
//! - `series`: one topic's messages turned into numbers, each at its stamp;
//! - `types`: message types as a schema defines them, whatever its language.

mod cdr;
mod decompress;
mod json;
mod layout;
mod protobuf;
mod records;
mod ros;
mod series;
mod types;

use super::draft;
use super::remarks::{Remark, RemarkPlace};
use super::source::Reader;
use super::{Channel, Finding, Head, Limits, Outcomes, ReadOptions, ReadOutcome, Selection};
use crate::error::{Candidate, Candidates, Error, ErrorKind, Place};
use ::mcap::McapError;
use ::mcap::records::op;
use ::mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use layout::{Laid, Schema, WantedFields};
use records::{ChannelRecord, PREFIX_BYTES, SchemaRecord, damaged};
use series::{Standing, TopicSeries};
use std::collections::BTreeMap;
use std::io::Read;
use types::Budget;

/// Bytes asked of the source at a time.
const READ_BYTES: usize = 64 << 10;

/// Tells whether the head carries MCAP's magic bytes.
#[must_use]
pub fn recognises(head: &Head<'_>) -> bool {
    head.bytes.starts_with(::mcap::MAGIC)
}

/// Reads an MCAP log.
///
/// Without a name the one topic of type `sensor_msgs/msg/Imu` or
/// `geometry_msgs/msg/AccelStamped` (or of JSON messages with such a field) is taken, and of
/// it the y axis; failing that, the one field of any other type whose name says lateral
/// acceleration. Times are those of `header.stamp`, or of logging where there is none.
///
/// # Errors
///
/// - [`ErrorKind::Truncated`] and [`ErrorKind::Malformed`] for a file that is cut, damaged or
///   contradicts itself, at the byte where it shows,
/// - [`ErrorKind::LimitExceeded`] beyond a limit,
/// - [`ErrorKind::NoChannel`], [`ErrorKind::AmbiguousChannel`], [`ErrorKind::NoSuchChannel`]
///   where the channel is not clear, [`ErrorKind::RefusedFormat`] for encodings not read,
/// - [`ErrorKind::NonFinite`], [`ErrorKind::TimeNotIncreasing`] and
///   [`ErrorKind::MissingUnit`] for the channel itself.
pub fn read(
    source: &mut Reader,
    options: &ReadOptions,
    selections: &[Selection],
    limits: &Limits,
) -> Result<Outcomes, Error> {
    options.refuse_other_clock("an MCAP log", "")?;
    let log = |selection: &Selection| LogReader::new(options, *selection, limits);
    let mut logs = Logs(selections.iter().map(|one| Ok(log(one))).collect());
    stream(source, &mut logs, limits)?;
    Ok(logs.0.into_iter().map(|log| log?.finish()).collect())
}

/// The logs of all selections, which take the same records in; one that failed takes no more.
struct Logs<'a>(Vec<Result<LogReader<'a>, Error>>);

impl<'a> Logs<'a> {
    /// Hands something to each log that has not failed.
    fn each(&mut self, mut take: impl FnMut(&mut LogReader<'a>) -> Result<(), Error>) {
        for log in &mut self.0 {
            if let Ok(open) = log
                && let Err(error) = take(open)
            {
                *log = Err(error);
            }
        }
    }

    /// Takes in one record of the file, which starts at `byte`. A chunk is unpacked once for all.
    fn record(&mut self, opcode: u8, data: &[u8], byte: u64, limits: &Limits) {
        let place = Place::default().byte(byte);
        self.each(|log| {
            log.record(opcode, data, byte)
                .map_err(|error| error.at(place.clone()))
        });
        if opcode != op::CHUNK {
            return;
        }
        if let Err(error) = self.chunk(data, byte, limits) {
            self.each(|_| Err(error.clone().at(place.clone())));
        }
    }

    fn chunk(&mut self, data: &[u8], byte: u64, limits: &Limits) -> Result<(), Error> {
        let chunk = records::chunk(data, limits)?;
        let unpacked = decompress::records(&chunk, limits)?;
        let mut left = &*unpacked;
        let place = Place::default().byte(byte);
        while let Some((opcode, data)) = records::next_in_chunk(&mut left)? {
            self.each(|log| {
                log.inside(opcode, data, byte)
                    .map_err(|error| error.at(place.clone()))
            });
        }
        Ok(())
    }

    fn have_all_failed(&self) -> bool {
        self.0.iter().all(Result::is_err)
    }
}

/// Feeds the file's records to `logs`.
fn stream(source: &mut Reader, logs: &mut Logs<'_>, limits: &Limits) -> Result<(), Error> {
    let record_bytes = usize::try_from(limits.mcap_record_bytes).unwrap_or(usize::MAX);
    let mut reader = LinearReader::new_with_options(
        LinearReaderOptions::default()
            .with_emit_chunks(true)
            .with_check_finishes_after_end_magic(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true)
            .with_record_length_limit(record_bytes),
    );
    let mut byte = ::mcap::MAGIC.len() as u64;
    while let Some(event) = reader.next_event() {
        match event {
            Ok(LinearReadEvent::ReadRequest(wanted)) => {
                let wanted = wanted.clamp(1, READ_BYTES);
                let count = read_some(source, reader.insert(wanted))?;
                reader.notify_read(count);
            }
            Ok(LinearReadEvent::Record { data, opcode }) => {
                logs.record(opcode, data, byte, limits);
                if logs.have_all_failed() {
                    return Ok(());
                }
                byte += (PREFIX_BYTES + data.len()) as u64;
            }
            Err(error) => {
                let place = Place::default().byte(byte);
                logs.each(|log| Err(framing(&error, log).at(place.clone())));
                return Ok(());
            }
        }
    }
    Ok(())
}

fn read_some(source: &mut Reader, buffer: &mut [u8]) -> Result<usize, Error> {
    loop {
        match source.read(buffer) {
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
            Err(error) => {
                return Err(ErrorKind::Io {
                    action: "read the file",
                    reason: error.to_string(),
                }
                .into());
            }
            Ok(count) => return Ok(count),
        }
    }
}

/// Says in our words what the framing of the file has wrong.
fn framing(error: &McapError, log: &LogReader<'_>) -> Error {
    let account = &log.account;
    let after = format!("after {} messages", log.messages);
    match error {
        McapError::UnexpectedEof if account.footer => {
            truncated("the end magic after the footer", "the end of the file")
        }
        McapError::UnexpectedEof if account.data_end => truncated(
            "the rest of the summary, a footer and the end magic",
            "the end of the file",
        ),
        McapError::UnexpectedEof => truncated(
            "a whole record, and more up to the footer and the end magic",
            &format!("the end of the file {after}"),
        ),
        McapError::BadMagic if account.footer => {
            truncated("the end magic after the footer", "other bytes")
        }
        McapError::BadMagic => damaged("MCAP's magic at the start of the file", "other bytes"),
        McapError::BytesAfterEndMagic => truncated(
            "the end of the file after the first footer and end magic",
            "more bytes, as when a log is written over an older, longer one",
        ),
        McapError::RecordTooLarge { len: u64::MAX, .. } => truncated(
            "a record with its length",
            &format!(
                "a length field of all ones {after}: the writer ended before it closed the record"
            ),
        ),
        McapError::RecordTooLarge { opcode, len } => {
            too_large(&format!("a record {opcode:#04x} of {len} bytes"), log)
        }
        McapError::ChunkTooLarge(len) => too_large(&format!("a chunk of {len} bytes"), log),
        McapError::BadDataCrc { saved, calculated } => damaged(
            format!("checksum {saved:08x} of the data"),
            format!("{calculated:08x}"),
        ),
        McapError::BadSummaryCrc { saved, calculated } => damaged(
            format!("checksum {saved:08x} of the summary"),
            format!("{calculated:08x}"),
        ),
        other => damaged(format!("whole records {after}"), format!("{other}")),
    }
}

fn too_large(found: &str, log: &LogReader<'_>) -> Error {
    ErrorKind::LimitExceeded {
        limit: "mcap_record_bytes",
        value: log.limits.mcap_record_bytes,
        found: format!("{found}, as its length field says"),
    }
    .into()
}

fn truncated(expected: &str, found: &str) -> Error {
    ErrorKind::Truncated {
        expected: expected.to_string(),
        found: found.to_string(),
    }
    .into()
}

/// What the file has said of itself and what was seen.
#[derive(Debug, Default)]
struct Account {
    header: bool,
    data_end: bool,
    footer: bool,
    /// Byte after the data section, where the summary starts if there is one.
    summary: u64,
    /// Whether a summary has begun.
    summarised: bool,
    /// Chunks seen, and the sum of their starts.
    chunks: (u64, u64),
    /// Chunks indexed, and the sum of their starts.
    indexed: (u64, u64),
    /// Whether statistics or a checksum of the data vouch for the number of messages.
    vouched: bool,
}

/// A topic of the file.
#[derive(Debug)]
struct Topic {
    name: String,
    encoding: String,
    schema_id: u16,
    messages: u64,
    /// What a person wrote of it.
    remarks: Vec<Remark>,
    /// What is wanted of it, if anything.
    wanted: Option<WantedFields>,
    /// What was read of it, from its first message on.
    series: Option<TopicSeries>,
}

/// The state of reading one file.
#[derive(Debug)]
struct LogReader<'a> {
    options: &'a ReadOptions,
    selection: Selection,
    limits: &'a Limits,
    schemas: BTreeMap<u16, Schema>,
    schema_bytes: u64,
    topics: BTreeMap<u16, Topic>,
    /// Where in the messages of a type stands what is wanted of it.
    layouts: BTreeMap<(u16, String, WantedFields), Laid>,
    /// What the message types may still cost.
    budget: Budget,
    /// Values kept in all.
    kept: u64,
    messages: u64,
    account: Account,
    /// What a person wrote of the file.
    remarks: Vec<Remark>,
}

/// Remarks on a file that are kept.
const REMARKS: usize = 1000;

impl<'a> LogReader<'a> {
    fn new(options: &'a ReadOptions, selection: Selection, limits: &'a Limits) -> Self {
        Self {
            options,
            selection,
            limits,
            schemas: BTreeMap::new(),
            schema_bytes: 0,
            topics: BTreeMap::new(),
            layouts: BTreeMap::new(),
            budget: Budget::new(limits),
            kept: 0,
            messages: 0,
            account: Account::default(),
            remarks: Vec::new(),
        }
    }

    /// Takes in one record of the file, which starts at `byte`; what a chunk holds comes after.
    fn record(&mut self, opcode: u8, data: &[u8], byte: u64) -> Result<(), Error> {
        let account = &mut self.account;
        if !account.header && opcode != op::HEADER {
            return Err(damaged(
                "the header as the first record",
                format!("a record {opcode:#04x}"),
            ));
        }
        if account.data_end && opcode != op::FOOTER {
            account.summarised = true;
        }
        match opcode {
            op::HEADER if account.header => return Err(damaged("one header", "a second")),
            op::HEADER => account.header = true,
            op::CHUNK => {
                self.data_section("a chunk")?;
                let (count, sum) = self.account.chunks;
                self.account.chunks = (count + 1, sum.wrapping_add(byte));
            }
            op::SCHEMA | op::CHANNEL => self.definition(opcode, data)?,
            op::MESSAGE => {
                self.data_section("a message")?;
                self.message(data, byte)?;
            }
            op::STATISTICS => {
                // Statistics count the whole file, so they stand after the data.
                if !account.data_end {
                    return Err(damaged("statistics after the end of the data", "before it"));
                }
                self.statistics(data)?;
            }
            op::CHUNK_INDEX => {
                let start = records::indexed_chunk_start(data)?;
                let (count, sum) = account.indexed;
                account.indexed = (count + 1, sum.wrapping_add(start));
            }
            op::DATA_END => {
                if std::mem::replace(&mut account.data_end, true) {
                    return Err(damaged("one end of the data", "a second"));
                }
                account.summary = byte + (PREFIX_BYTES + data.len()) as u64;
                // The checksum itself was verified while the bytes passed.
                account.vouched |= data.iter().take(4).any(|byte| *byte != 0);
            }
            op::FOOTER => self.footer(data)?,
            // What cannot be read of it is no one's remark.
            op::METADATA => {
                let told = "the log's metadata say";
                for comment in records::metadata(data).unwrap_or_default() {
                    match self.remarks.len() {
                        ..REMARKS => {
                            self.remarks
                                .push(Remark::new(comment, RemarkPlace::Channel, told))
                        }
                        REMARKS => self.remarks.push(Remark::new(
                            "more than is read",
                            RemarkPlace::State(None),
                            told,
                        )),
                        _ => {}
                    }
                }
            }
            // Attachments, indexes and what later versions may add carry no samples.
            _ => {}
        }
        Ok(())
    }

    /// Refuses data after the end of the data.
    fn data_section(&self, what: &str) -> Result<(), Error> {
        if self.account.data_end {
            return Err(damaged("only a summary after the end of the data", what));
        }
        Ok(())
    }

    /// Takes in one record of the chunk that starts at `byte`.
    fn inside(&mut self, opcode: u8, data: &[u8], byte: u64) -> Result<(), Error> {
        match opcode {
            op::SCHEMA | op::CHANNEL => self.definition(opcode, data),
            op::MESSAGE => self.message(data, byte),
            0x01..=0x0F => Err(damaged(
                "only schemas, channels and messages in a chunk",
                format!("a record {opcode:#04x}"),
            )),
            _ => Ok(()),
        }
    }

    fn definition(&mut self, opcode: u8, data: &[u8]) -> Result<(), Error> {
        if opcode == op::SCHEMA {
            self.schema(&records::schema(data, self.limits)?)
        } else {
            self.channel(&records::channel(data, self.limits)?)
        }
    }

    fn schema(&mut self, record: &SchemaRecord<'_>) -> Result<(), Error> {
        if record.id == 0 {
            return Err(damaged("a schema id from 1", "0"));
        }
        if let Some(known) = self.schemas.get(&record.id) {
            if known.name == record.name
                && known.encoding == record.encoding
                && known.data == record.data
            {
                return Ok(());
            }
            return Err(damaged(
                format!("schema {} ({}) as before", record.id, known.name),
                format!("another definition ({})", record.name),
            ));
        }
        self.schema_bytes += (record.name.len() + record.encoding.len() + record.data.len()) as u64;
        if self.schema_bytes > self.limits.mcap_record_bytes {
            return Err(ErrorKind::LimitExceeded {
                limit: "mcap_record_bytes",
                value: self.limits.mcap_record_bytes,
                found: "schemas of more bytes together".into(),
            }
            .into());
        }
        self.schemas.insert(
            record.id,
            Schema {
                name: record.name.to_string(),
                encoding: record.encoding.to_string(),
                data: record.data.to_vec(),
                has_lateral_field: None,
            },
        );
        Ok(())
    }

    fn channel(&mut self, record: &ChannelRecord<'_>) -> Result<(), Error> {
        if let Some(known) = self.topics.get(&record.id) {
            if known.name == record.topic
                && known.encoding == record.encoding
                && known.schema_id == record.schema_id
            {
                return Ok(());
            }
            return Err(damaged(
                format!("channel {} (topic {}) as before", record.id, known.name),
                format!("another definition (topic {})", record.topic),
            ));
        }
        if record.schema_id != 0 && !self.schemas.contains_key(&record.schema_id) {
            return Err(damaged(
                format!("schema {} before topic {}", record.schema_id, record.topic),
                "none",
            ));
        }
        if self.topics.len() as u64 >= self.limits.mcap_channels {
            return Err(ErrorKind::LimitExceeded {
                limit: "mcap_channels",
                value: self.limits.mcap_channels,
                found: "more topics".into(),
            }
            .into());
        }
        let wanted = self.wanted(record)?;
        self.topics.insert(
            record.id,
            Topic {
                name: record.topic.to_string(),
                encoding: record.encoding.to_string(),
                schema_id: record.schema_id,
                messages: 0,
                remarks: record
                    .comments
                    .iter()
                    .map(|comment| Remark::of_channel(&[comment]))
                    .collect(),
                wanted,
                series: None,
            },
        );
        Ok(())
    }

    /// Tells what is wanted of a topic, if anything.
    fn wanted(&mut self, record: &ChannelRecord<'_>) -> Result<Option<WantedFields>, Error> {
        if self.selection == Selection::Lateral
            && let Some(name) = &self.options.channel
        {
            let Some(path) = name.strip_prefix(record.topic) else {
                return Ok(None);
            };
            return Ok(if path.is_empty() {
                Some(WantedFields::Lateral)
            } else {
                path.strip_prefix(':')
                    .map(|path| WantedFields::Path(path.to_string()))
            });
        }
        let likely = match self.schemas.get_mut(&record.schema_id) {
            _ if record.encoding == "json" => true,
            None => false,
            Some(schema) if layout::is_acceleration(&schema.name) => true,
            Some(schema) => match schema.has_lateral_field {
                Some(known) => known,
                None => {
                    let found = layout::has_lateral_field(schema, &mut self.budget)?;
                    schema.has_lateral_field = Some(found);
                    found
                }
            },
        };
        Ok(match self.selection {
            _ if !likely => None,
            Selection::Every => Some(WantedFields::Every),
            Selection::Lateral => Some(WantedFields::Lateral),
        })
    }

    /// Begins to read a topic of which something is wanted.
    fn begin(&mut self, id: u16) -> Result<(), Error> {
        let Some(topic) = self.topics.get_mut(&id) else {
            return Ok(());
        };
        let Some(wanted) = &topic.wanted else {
            return Ok(());
        };
        // Topics of one type share what was found out about it.
        let laid = if topic.encoding == "json" {
            None
        } else {
            let key = (topic.schema_id, topic.encoding.clone(), wanted.clone());
            let laid = match self.layouts.get(&key) {
                Some(laid) => laid.clone(),
                None => {
                    let schema = self.schemas.get(&topic.schema_id);
                    let laid = layout::layout(&topic.encoding, schema, wanted, &mut self.budget)?;
                    self.layouts.insert(key, laid.clone());
                    laid
                }
            };
            Some(laid)
        };
        let mut series = TopicSeries::new(&topic.name, wanted, laid.as_ref(), &mut self.kept);
        series.remarks.clone_from(&topic.remarks);
        topic.series = Some(series);
        Ok(())
    }

    fn message(&mut self, data: &[u8], byte: u64) -> Result<(), Error> {
        let (channel_id, log_time, content) = records::message(data)?;
        let Some(topic) = self.topics.get_mut(&channel_id) else {
            return Err(damaged(
                format!("channel {channel_id} before its messages"),
                "none",
            ));
        };
        self.messages += 1;
        topic.messages += 1;
        if topic.messages == 1 {
            self.begin(channel_id)?;
        }
        if let Some(topic) = self.topics.get_mut(&channel_id)
            && let Some(series) = &mut topic.series
        {
            series.push(
                topic.messages,
                log_time,
                content,
                byte,
                &mut self.kept,
                self.limits,
            )?;
        }
        Ok(())
    }

    fn statistics(&mut self, data: &[u8]) -> Result<(), Error> {
        let (stated, by_channel) = records::statistics(data)?;
        let holds = |expected: String, stated: u64, found: u64| match stated == found {
            true => Ok(()),
            false => Err(truncated(&expected, &format!("{found}"))),
        };
        let text = format!("{stated} messages, as the statistics say");
        holds(text, stated, self.messages)?;
        let mut sum = 0_u64;
        for (id, count) in &by_channel {
            sum = sum.saturating_add(*count);
            let found = self.topics.get(id).map_or(0, |topic| topic.messages);
            let text = format!("{count} messages of channel {id}, as the statistics say");
            holds(text, *count, found)?;
        }
        if !by_channel.is_empty() {
            let text = format!("{sum} messages, as the statistics say by channel");
            holds(text, sum, self.messages)?;
        }
        self.account.vouched = true;
        Ok(())
    }

    fn footer(&mut self, data: &[u8]) -> Result<(), Error> {
        let account = &mut self.account;
        account.footer = true;
        if !account.data_end {
            return Err(truncated("the end of the data before the footer", "none"));
        }
        let said = records::summary_start(data)?;
        if (said != 0 || account.summarised) && said != account.summary {
            return Err(truncated(
                &format!("the summary at byte {said}, as the footer says"),
                &format!("the end of the data at byte {}", account.summary),
            ));
        }
        if account.indexed.0 > 0 && account.indexed != account.chunks {
            return Err(truncated(
                &format!("the {} chunks of the chunk index", account.indexed.0),
                &format!("{} chunks, or others", account.chunks.0),
            ));
        }
        Ok(())
    }

    /// Turns what was kept into channels.
    fn finish(mut self) -> Result<ReadOutcome, Error> {
        let mut outcome = ReadOutcome {
            remarks: std::mem::take(&mut self.remarks),
            ..ReadOutcome::default()
        };
        if self.messages > 0 && !self.account.vouched {
            outcome.findings.push(Finding::warning(
                "mcap-unverified",
                "the file has neither statistics nor a checksum of its data; messages that were \
                 lost would not show",
            ));
        }
        let topics = self.list();
        let (series, silent) = self.sift(&mut outcome.findings);
        match self.selection {
            Selection::Every => self.finish_every(series, &mut outcome)?,
            Selection::Lateral => {
                let one = self.choose(series, &silent, topics)?;
                outcome.channels.push(self.finish_chosen(one)?);
            }
        }
        Ok(outcome)
    }

    /// Returns the series that can be meant, and the topics without a message.
    fn sift(&mut self, findings: &mut Vec<Finding>) -> (Vec<(u16, TopicSeries)>, Vec<String>) {
        let mut series: Vec<(u16, TopicSeries)> = Vec::new();
        let mut silent: Vec<String> = Vec::new();
        let mut doubtful: Vec<(u16, TopicSeries)> = Vec::new();
        let named = self.options.channel.is_some() && self.selection == Selection::Lateral;
        for (id, topic) in &mut self.topics {
            if topic.wanted.is_none() {
                continue;
            }
            let unknown = !named && topic.encoding == "json";
            let Some(found) = topic.series.take() else {
                if !unknown {
                    silent.push(topic.name.clone());
                }
                continue;
            };
            // A type of which more is known than its name has to have the field.
            let schema = self.schemas.get(&topic.schema_id);
            let is_known = schema.is_some_and(|schema| layout::is_acceleration(&schema.name));
            match found.standing() {
                Standing::Other if unknown || !(named || is_known) => {}
                Standing::Doubtful(_) if unknown => doubtful.push((*id, found)),
                _ => series.push((*id, found)),
            }
        }
        if series.is_empty() {
            // An unreadable topic speaks up where nothing else can be meant.
            series = doubtful;
        } else {
            for (_, found) in &doubtful {
                if let Standing::Doubtful(error) = found.standing() {
                    findings.push(draft::left_out(&found.name(), error));
                }
            }
        }
        (series, silent)
    }

    /// Makes the channel of the series that was chosen.
    fn finish_chosen(&self, one: TopicSeries) -> Result<Channel, Error> {
        let mut channels = one.finish(self.options, self.limits)?;
        let Some((name, channel)) = channels.pop() else {
            return Err(ErrorKind::NoChannel { known: self.list() }.into());
        };
        let mut channel = channel?;
        if channel.unit.is_none() {
            return Err(Error::from(ErrorKind::MissingUnit).at(Place::default().channel(name)));
        }
        if self.options.channel.is_none() {
            channel.findings.insert(
                0,
                Finding::info(
                    "channel-chosen",
                    format!(
                        "{name} is the one lateral acceleration in the file; its y axis points to \
                         the left by REP 103 unless the sensor is mounted otherwise"
                    ),
                ),
            );
        }
        Ok(channel)
    }

    /// Returns the one series that can be meant.
    fn choose(
        &self,
        mut series: Vec<(u16, TopicSeries)>,
        silent: &[String],
        topics: String,
    ) -> Result<TopicSeries, Error> {
        if self.options.channel.is_none() {
            // What is plainly meant comes before what a word makes doubtful.
            let plain = |(_, one): &(u16, TopicSeries)| one.doubt().is_none();
            if series.iter().any(plain) {
                series.retain(plain);
            }
        }
        // A topic of several such fields offers each of them itself.
        let doubted = |(_, one): &(u16, TopicSeries)| one.doubt().is_some() && !one.is_ambiguous();
        let doubted = self.options.channel.is_none() && series.iter().any(doubted);
        if series.len() > 1 || doubted {
            // Names tell topics apart, except where one name was asked for and several fit.
            let named = self.options.channel.is_some();
            let one = |(id, series): &(u16, TopicSeries)| match named {
                true => Candidate {
                    name: series.name(),
                    twin: Some(format!("channel id {id}")),
                    asked_as: None,
                    doubt: None,
                },
                false => Candidate::named(series.name()).doubted(series.doubt()),
            };
            return Err(ErrorKind::AmbiguousChannel {
                candidates: Candidates(series.iter().map(one).collect()),
            }
            .into());
        }
        if let Some((_, one)) = series.pop() {
            return Ok(one);
        }
        Err(match (&self.options.channel, silent) {
            (_, [topic, ..]) => ErrorKind::Empty {
                found: format!("topic {topic} holds no message"),
                expected: "messages with an acceleration".into(),
            },
            (Some(wanted), []) => ErrorKind::NoSuchChannel {
                wanted: wanted.clone(),
                known: topics,
            },
            (None, []) => ErrorKind::NoChannel { known: topics },
        }
        .into())
    }

    fn finish_every(
        &self,
        series: Vec<(u16, TopicSeries)>,
        outcome: &mut ReadOutcome,
    ) -> Result<(), Error> {
        let taken: Vec<u16> = series.iter().map(|(id, _)| *id).collect();
        for (_, series) in series {
            let name = series.name();
            match series.finish(self.options, self.limits) {
                Err(error) => outcome.findings.push(draft::left_out(&name, &error)),
                Ok(channels) => {
                    for (name, channel) in channels {
                        match channel {
                            Ok(channel) => outcome.channels.push(channel),
                            Err(error) => outcome.findings.push(draft::left_out(&name, &error)),
                        }
                    }
                }
            }
        }
        let others: Vec<u16> = self
            .topics
            .keys()
            .filter(|id| !taken.contains(id))
            .copied()
            .collect();
        if !others.is_empty() {
            outcome.findings.push(Finding::info(
                "topics-left-out",
                format!(
                    "topics without acceleration messages: {}",
                    self.describe(&others)
                ),
            ));
        }
        Ok(())
    }

    /// Lists the topics with their message types.
    fn list(&self) -> String {
        let all: Vec<u16> = self.topics.keys().copied().collect();
        if all.is_empty() {
            return "no topic".into();
        }
        self.describe(&all)
    }

    fn describe(&self, ids: &[u16]) -> String {
        let topics = ids.iter().filter_map(|id| self.topics.get(id));
        let names = topics.map(|topic| {
            let schema = self.schemas.get(&topic.schema_id);
            let schema = schema.map_or("no schema", |schema| schema.name.as_str());
            let plural = if topic.messages == 1 { "" } else { "s" };
            let (name, encoding, count) = (&topic.name, &topic.encoding, topic.messages);
            format!("{name} ({schema}, {encoding}): {count} message{plural}")
        });
        Candidates::named(names).to_string()
    }
}
