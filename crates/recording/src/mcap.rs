//! MCAP logs: messages of ROS 2 (CDR) and ROS 1, protobuf by its own descriptor, and JSON.
//!
//! The file is read once, from the first byte to the last, record by record. Memory is
//! bounded by one record (`mcap_record_bytes`), one chunk unpacked (`mcap_chunk_bytes`; the
//! zstd decoder may hold as much again), the schemas (together at most `mcap_record_bytes`),
//! the steps through the messages of their types (together at most `mcap_fields`) and the
//! samples kept: per topic at most `samples`, in all at most five times as many values, times
//! included.
//!
//! A log that was cut, damaged or put together from two must not pass for a whole one, so
//! everything the file says of itself is compared with what it holds: the checksums of
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
//! - `clock`: the clocks of a topic's messages: which one is used, and whether the others agree with
//!   it;
//! - `decompress`: chunks: decompression within limits, checked against the chunk's own size and
//!   checksum;
//! - `json`: JSON messages: one walk through the text that hands out every scalar with its path;
//! - `layout`: the position of the requested fields in the messages of a type, and their units;
//! - `protobuf`: Protobuf messages, read by the descriptor that the file itself carries;
//! - `records`: the records of an MCAP file, read by the `mcap` crate with checked lengths;
//! - `ros`: ROS message definitions (`ros2msg`, `ros1msg`), as the file holds them;
//! - `series`: one topic's messages turned into numbers, each at its stamp;
//! - `types`: message types as a schema defines them, whatever its language.

mod cdr;
mod clock;
mod decompress;
mod json;
mod layout;
mod protobuf;
mod records;
mod ros;
mod series;
mod types;

use super::channel_name::ChannelName;
use super::draft;
use super::lateral::{self, ChannelOffer};
use super::remarks::{Remark, RemarkPlace};
use super::source::Reader;
use super::{Finding, Head, Limits, Outcomes, ReadOutcome, ReadTask, Selection};
use crate::error::{Candidates, Error, ErrorKind, Place};
use ::mcap::McapError;
use ::mcap::records::{MessageHeader, Record, SchemaHeader, Statistics, op};
use ::mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use layout::{Contents, LayoutResult, RequestedFields, Schema};
use records::{PREFIX_BYTES, damaged};
use series::{KeptValues, LoggedMessage, TopicChannels, TopicField, TopicSeries};
use std::collections::BTreeMap;
use std::io::{self, Read};
use types::Budget;

/// Bytes asked of the source at a time.
const READ_BYTES: usize = 64 << 10;

/// True if the head carries MCAP's magic bytes.
pub fn recognises(head: &Head<'_>) -> bool {
    head.bytes.starts_with(::mcap::MAGIC)
}

/// Reads an MCAP log.
///
/// Without a name the one topic of type `sensor_msgs/msg/Imu` or
/// `geometry_msgs/msg/AccelStamped` (or of JSON messages with such a field) is taken, and of
/// it the y axis; failing that, the one field of any other type whose name says lateral
/// acceleration. Times are those of `ReadOptions::time_source`, else of `header.stamp`, or of
/// logging where there is none.
///
/// # Errors
///
/// - [`ErrorKind::Truncated`] and [`ErrorKind::Malformed`] for a file that is cut, damaged or
///   contradicts itself, at the byte where it shows,
/// - [`ErrorKind::LimitExceeded`] beyond a limit,
/// - [`ErrorKind::NoChannel`], [`ErrorKind::AmbiguousChannel`], [`ErrorKind::NoSuchChannel`]
///   where the channel is not clear, [`ErrorKind::RefusedFormat`] for encodings not read,
/// - [`NonFinite`](latchgate_kernel::error::Error::NonFinite), [`ErrorKind::TimeNotIncreasing`] and
///   [`ErrorKind::MissingUnit`] for the channel itself.
pub fn read(source: &mut Reader, task: ReadTask) -> Result<Outcomes, Error> {
    let way_out = ", or state the clock with the setting `time_source`";
    task.options.refuse_other_clock("an MCAP log", way_out)?;
    let mut log = LogReader::new(task);
    stream(source, &mut log, task.limits)?;
    Ok(log.finish())
}

/// Feeds the file's records to `log`.
fn stream(source: &mut Reader, log: &mut LogReader<'_>, limits: &Limits) -> Result<(), Error> {
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
        let placed = |error: Error| error.at(Place::default().byte(byte));
        match event.map_err(|error| placed(framing(&error, log)))? {
            // A read call is interrupted by signals; the loop tries again, as `Read::read_exact` does.
            LinearReadEvent::ReadRequest(byte_count) => {
                let wanted_bytes = byte_count.clamp(1, READ_BYTES);
                let count = loop {
                    match source.read(reader.insert(wanted_bytes)) {
                        Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                        read => break read.map_err(|error| Error::io("read the file", &error))?,
                    }
                };
                reader.notify_read(count);
            }
            LinearReadEvent::Record { data, opcode } => {
                log.record(opcode, data, byte).map_err(placed)?;
                byte += (PREFIX_BYTES + data.len()) as u64;
            }
        }
    }
    Ok(())
}

/// Restates the `mcap` crate's error about the file's framing in the program's terms.
fn framing(error: &McapError, log: &LogReader<'_>) -> Error {
    let after = format!("after {} messages", log.messages);
    match error {
        McapError::BadMagic if !log.account.footer => {
            damaged("MCAP's magic at the start of the file", "other bytes")
        }
        McapError::UnexpectedEof | McapError::BadMagic => Error::truncated(
            "whole records up to the footer and the end magic",
            format!("the end of the file {after}, or other bytes"),
        ),
        McapError::BytesAfterEndMagic => Error::truncated(
            "the end of the file after the first footer and end magic",
            "more bytes, as when a log is written over an older, longer one",
        ),
        McapError::RecordTooLarge { len: u64::MAX, .. } => Error::truncated(
            "a record with its length",
            format!("a length field of all ones {after}: the writer ended before it closed it"),
        ),
        McapError::RecordTooLarge { .. } | McapError::ChunkTooLarge(_) => {
            log.task.limits.over("mcap_record_bytes", error.to_string())
        }
        error => {
            let expected = format!("whole records, whose checksums fit, {after}");
            damaged(expected, error.to_string())
        }
    }
}

/// What the file states of itself, and what was counted, for the comparison at its end.
#[derive(Debug, Default)]
struct Account {
    header: bool,
    data_end: bool,
    footer: bool,
    /// Byte after the data section, where the summary starts if there is one.
    summary: u64,
    /// True if a summary has begun.
    summarised: bool,
    /// Chunks read.
    chunks: ChunkTally,
    /// Chunks that the chunk index lists.
    indexed: ChunkTally,
    /// True if statistics or a checksum of the data confirm the number of messages.
    vouched: bool,
}

/// Count of chunks and sum of their start bytes. Two lists of chunks are compared by these, so that
/// none is kept.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct ChunkTally {
    count: u64,
    start_sum: u64,
}

impl ChunkTally {
    fn add(&mut self, start: u64) {
        self.count += 1;
        self.start_sum = self.start_sum.wrapping_add(start);
    }
}

/// A topic of the file.
#[derive(Debug)]
struct Topic {
    name: String,
    encoding: String,
    schema_id: u16,
    messages: u64,
    /// Comments in the channel's metadata.
    remarks: Vec<Remark>,
    /// Fields requested of it; `None` if it is not read.
    requested: Option<RequestedFields>,
    /// True if its type may carry a lateral acceleration, which any JSON topic may.
    likely: bool,
    /// Samples read so far; `None` before its first message.
    series: Option<TopicSeries>,
    /// Fields its messages hold; `None` where the schema gives them.
    contents: Option<Contents>,
}

/// A topic of which channels were requested.
struct ReadTopic {
    id: u16,
    /// True if its type may carry a lateral acceleration.
    likely: bool,
    channels: TopicChannels,
}

/// The state of reading one file.
#[derive(Debug)]
struct LogReader<'a> {
    task: ReadTask<'a>,
    schemas: BTreeMap<u16, Schema>,
    schema_bytes: u64,
    topics: BTreeMap<u16, Topic>,
    /// Layouts by schema, encoding and requested fields. Topics of one type share them.
    layouts: BTreeMap<(u16, String, RequestedFields), LayoutResult>,
    /// Number of message fields that may still be visited.
    budget: Budget,
    /// Number of values kept of all topics.
    kept: KeptValues,
    messages: u64,
    account: Account,
    /// Comments in the file's metadata.
    remarks: Vec<Remark>,
}

/// Most remarks kept of one file: a person has to read them all.
const REMARKS: usize = 1000;

impl<'a> LogReader<'a> {
    fn new(task: ReadTask<'a>) -> Self {
        Self {
            task,
            schemas: BTreeMap::new(),
            schema_bytes: 0,
            topics: BTreeMap::new(),
            layouts: BTreeMap::new(),
            budget: Budget::new(task.limits),
            kept: KeptValues::default(),
            messages: 0,
            account: Account::default(),
            remarks: Vec::new(),
        }
    }

    /// Takes in one record of the file, which starts at `byte`.
    fn record(&mut self, opcode: u8, data: &[u8], byte: u64) -> Result<(), Error> {
        let account = &mut self.account;
        if !account.header && opcode != op::HEADER {
            let found = format!("a record {opcode:#04x}");
            return Err(damaged("the header as the first record", found));
        }
        // Any record but the footer after the end of the data belongs to a summary. The footer must then
        // point to it.
        if account.data_end && opcode != op::FOOTER {
            account.summarised = true;
        }
        let after_data = |what| damaged("only a summary after the end of the data", what);
        match opcode {
            op::HEADER if account.header => return Err(damaged("one header", "a second")),
            op::HEADER => account.header = true,
            op::CHUNK if account.data_end => return Err(after_data("a chunk")),
            op::MESSAGE if account.data_end => return Err(after_data("a message")),
            // Statistics count the whole file, so they stand after the data.
            op::STATISTICS if !account.data_end => {
                return Err(damaged("statistics after the end of the data", "before it"));
            }
            op::FOOTER if !account.data_end => {
                let expected = "the end of the data before the footer";
                return Err(Error::truncated(expected, "none"));
            }
            op::DATA_END if account.data_end => {
                return Err(damaged("one end of the data", "a second"));
            }
            op::DATA_END => {
                account.data_end = true;
                account.summary = byte + (PREFIX_BYTES + data.len()) as u64;
                // The checksum itself was verified while the bytes passed.
                account.vouched |= data.iter().take(4).any(|byte| *byte != 0);
            }
            op::METADATA => self.metadata(records::parse(opcode, data).ok().as_ref()),
            op::SCHEMA
            | op::CHANNEL
            | op::MESSAGE
            | op::CHUNK
            | op::CHUNK_INDEX
            | op::STATISTICS
            | op::FOOTER => self.parsed(records::parse(opcode, data)?, byte)?,

            // Attachments, indexes and what later versions may add carry no samples.
            _ => {}
        }
        Ok(())
    }

    /// Takes in the fields of a record; `byte` is its start, or that of the chunk that holds it.
    fn parsed(&mut self, record: Record<'_>, byte: u64) -> Result<(), Error> {
        match record {
            Record::Schema { header, data } => self.schema(header, &data),
            Record::Channel(record) => self.channel(record),
            Record::Message { header, data } => self.message(header, &data, byte),
            Record::Chunk { header, data } => {
                let unpacked = decompress::records(&header, &data, self.task.limits)?;
                self.chunk(&unpacked, byte)
            }
            Record::ChunkIndex(index) => {
                self.account.indexed.add(index.chunk_start_offset);
                Ok(())
            }
            Record::Statistics(statistics) => self.statistics(&statistics),
            Record::Footer(footer) => self.footer(footer.summary_start),
            _ => Ok(()),
        }
    }

    /// Takes in the records of the chunk that starts at `byte`.
    fn chunk(&mut self, mut records_left: &[u8], byte: u64) -> Result<(), Error> {
        self.account.chunks.add(byte);
        while let Some((opcode, data)) = records::next_in_chunk(&mut records_left)? {
            match opcode {
                op::SCHEMA | op::CHANNEL | op::MESSAGE => {
                    self.parsed(records::parse(opcode, data)?, byte)?;
                }
                // Opcodes below 0x10 are those of the specification, which allows no other record here.
                0x01..=0x0F => {
                    let found = format!("a record {opcode:#04x}");
                    let expected = "only schemas, channels and messages in a chunk";
                    return Err(damaged(expected, found));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Takes in the comments of a metadata record; `None` for a record that cannot be read.
    fn metadata(&mut self, record: Option<&Record<'_>>) {
        let comments: Vec<(&str, RemarkPlace)> = match record {
            Some(Record::Metadata(record)) => records::comments(&record.metadata)
                .map(|comment| (comment, RemarkPlace::Channel))
                .collect(),
            // An unreadable comment might say that the data are invalid, so it counts as a fault.
            _ => vec![("a record that cannot be read", RemarkPlace::State(None))],
        };
        for (comment, place) in comments {
            let (text, place) = match self.remarks.len() {
                ..REMARKS => (comment, place),
                REMARKS => ("more than is read", RemarkPlace::State(None)),
                _ => break,
            };
            let source = "the log's metadata say";
            self.remarks.push(Remark::new(text, place, source));
        }
    }

    fn schema(&mut self, record: SchemaHeader, data: &[u8]) -> Result<(), Error> {
        let texts = [&*record.name, &record.encoding];
        records::check_texts(&texts, "schema", self.task.limits)?;
        if record.id == 0 {
            return Err(damaged("a schema id from 1", "0"));
        }
        if let Some(schema) = self.schemas.get(&record.id) {
            let definition = (&*schema.name, &*schema.encoding, &*schema.data);
            if definition == (&*record.name, &*record.encoding, data) {
                return Ok(());
            }
            let expected = format!("schema {} ({}) as before", record.id, schema.name);
            let found = format!("another definition ({})", record.name);
            return Err(damaged(expected, found));
        }
        self.schema_bytes += (record.name.len() + record.encoding.len() + data.len()) as u64;
        if self.schema_bytes > self.task.limits.mcap_record_bytes {
            let found = "schemas of more bytes together";
            return Err(self.task.limits.over("mcap_record_bytes", found));
        }
        self.schemas.insert(
            record.id,
            Schema {
                name: record.name,
                encoding: record.encoding,
                data: data.to_vec(),
                has_lateral_field: None,
            },
        );
        Ok(())
    }

    fn channel(&mut self, record: ::mcap::records::Channel) -> Result<(), Error> {
        let texts = [&*record.topic, &record.message_encoding];
        records::check_texts(&texts, "channel", self.task.limits)?;
        if let Some(topic) = self.topics.get(&record.id) {
            let definition = (&*topic.name, &*topic.encoding, topic.schema_id);
            if definition == (&*record.topic, &*record.message_encoding, record.schema_id) {
                return Ok(());
            }
            let expected = format!("channel {} (topic {}) as before", record.id, topic.name);
            let found = format!("another definition (topic {})", record.topic);
            return Err(damaged(expected, found));
        }
        if record.schema_id != 0 && !self.schemas.contains_key(&record.schema_id) {
            let expected = format!("schema {} before topic {}", record.schema_id, record.topic);
            return Err(damaged(expected, "none"));
        }
        if self.topics.len() as u64 >= self.task.limits.mcap_channels {
            return Err(self.task.limits.over("mcap_channels", "more topics"));
        }
        let (requested, likely) = self.requested_fields(&record)?;
        let comments = records::comments(&record.metadata);
        let remarks = comments.map(|comment| Remark::of_channel(&[comment]));
        let remarks = remarks.collect();
        self.topics.insert(
            record.id,
            Topic {
                name: record.topic,
                encoding: record.message_encoding,
                schema_id: record.schema_id,
                messages: 0,
                remarks,
                requested,
                likely,
                series: None,
                contents: None,
            },
        );
        Ok(())
    }

    /// Returns the field path that the setting `channel` names in a topic. The outer `None` is another
    /// topic, the inner one the topic as a whole. The setting may end with the channel's id, as the
    /// names of topics that were recorded twice do.
    fn requested_path(&self, id: u16, topic: &str) -> Option<Option<&str>> {
        let requested = self.task.options.channel.as_deref()?;
        let requested = lateral::without_twin_mark(requested, id)?;
        let suffix = requested.strip_prefix(topic)?;
        match suffix.is_empty() {
            true => Some(None),
            false => suffix.strip_prefix(':').map(Some),
        }
    }

    /// Returns the fields requested of a topic, and true if it may carry a lateral acceleration.
    fn requested_fields(
        &mut self,
        record: &::mcap::records::Channel,
    ) -> Result<(Option<RequestedFields>, bool), Error> {
        let likely = match self.schemas.get_mut(&record.schema_id) {
            _ if record.message_encoding == "json" => true,
            None => false,
            Some(schema) if layout::lateral_path(&schema.name).is_some() => true,
            Some(schema) => match schema.has_lateral_field {
                Some(has_lateral_field) => has_lateral_field,
                None => match layout::has_lateral_field(schema, &mut self.budget) {
                    Ok(has_lateral_field) => *schema.has_lateral_field.insert(has_lateral_field),
                    // A named channel is read although the search for others ran out of budget. `KeptValues::exceeded`
                    // still refuses `Selection::Every`.
                    Err(error) if self.task.options.channel.is_none() => return Err(error),
                    Err(error) => {
                        self.kept.exceeded.get_or_insert(error);
                        false
                    }
                },
            },
        };
        let requested_path = self.requested_path(record.id, &record.topic);
        let no_name = self.task.options.channel.is_none();
        let every_topic = no_name || self.task.selections.contains(&Selection::Every);
        let fields = RequestedFields {
            every: (every_topic && likely) || requested_path == Some(None),
            path: requested_path.flatten().map(str::to_string),
            is_candidate: no_name || requested_path.is_some(),
        };
        let any = fields.every || fields.path.is_some();
        Ok((any.then_some(fields), likely))
    }

    /// Begins to read a topic of which fields are requested.
    fn begin(&mut self, id: u16) -> Result<(), Error> {
        let Some(topic) = self.topics.get_mut(&id) else {
            return Ok(());
        };
        let Some(requested) = &topic.requested else {
            return Ok(());
        };
        // Topics of one type share a layout, so that the budget is spent on it once.
        let layout = if topic.encoding == "json" {
            None
        } else {
            let key = (topic.schema_id, topic.encoding.clone(), requested.clone());
            let layout = match self.layouts.get(&key) {
                Some(layout) => layout.clone(),
                None => {
                    let schema = self.schemas.get(&topic.schema_id);
                    let layout =
                        layout::layout(&topic.encoding, schema, requested, &mut self.budget);
                    let layout = match layout {
                        Err(error) if !requested.is_candidate => {
                            self.kept.exceeded.get_or_insert(error);
                            return Ok(());
                        }
                        layout => layout?,
                    };
                    self.layouts.insert(key, layout.clone());
                    layout
                }
            };
            Some(layout)
        };
        let mut series = TopicSeries::new(&topic.name, requested, layout.as_ref(), &mut self.kept);
        series.remarks.clone_from(&topic.remarks);
        topic.series = Some(series);
        Ok(())
    }

    fn message(&mut self, header: MessageHeader, data: &[u8], byte: u64) -> Result<(), Error> {
        let channel_id = header.channel_id;
        let Some(topic) = self.topics.get_mut(&channel_id) else {
            let expected = format!("channel {channel_id} before its messages");
            return Err(damaged(expected, "none"));
        };
        self.messages += 1;
        topic.messages += 1;
        if topic.messages == 1 {
            self.begin(channel_id)?;
        }
        if let Some(topic) = self.topics.get_mut(&channel_id)
            && let Some(series) = &mut topic.series
        {
            let message = LoggedMessage {
                number: topic.messages,
                log_time: header.log_time,
                publish_time: header.publish_time,
                data,
                byte,
            };
            series.push(&message, &mut self.kept, self.task.limits)?;
        }
        Ok(())
    }

    fn statistics(&mut self, statistics: &Statistics) -> Result<(), Error> {
        let (stated, by_channel) = (statistics.message_count, &statistics.channel_message_counts);
        let check = |text: String, stated: u64, read: u64| match stated == read {
            true => Ok(()),
            false => Err(Error::truncated(text, format!("{read}"))),
        };
        let text = format!("{stated} messages, as the statistics say");
        check(text, stated, self.messages)?;
        let mut sum = 0_u64;
        for (id, count) in by_channel {
            sum = sum.saturating_add(*count);
            let count_read = self.topics.get(id).map_or(0, |topic| topic.messages);
            let text = format!("{count} messages of channel {id}, as the statistics say");
            check(text, *count, count_read)?;
        }
        if !by_channel.is_empty() {
            let text = format!("{sum} messages, as the statistics say by channel");
            check(text, sum, self.messages)?;
        }
        self.account.vouched = true;
        Ok(())
    }

    /// Compares the footer with what was read; `summary_start` is the byte where it puts the summary.
    fn footer(&mut self, summary_start: u64) -> Result<(), Error> {
        let account = &mut self.account;
        account.footer = true;
        // 0 stands for a file without a summary.
        if (summary_start != 0 || account.summarised) && summary_start != account.summary {
            return Err(Error::truncated(
                format!("the summary at byte {summary_start}, as the footer says"),
                format!("the end of the data at byte {}", account.summary),
            ));
        }
        // A file without a chunk index is valid.
        if account.indexed.count > 0 && account.indexed != account.chunks {
            return Err(Error::truncated(
                format!("the {} chunks of the chunk index", account.indexed.count),
                format!("{} chunks, or others", account.chunks.count),
            ));
        }
        Ok(())
    }

    /// Turns what was kept into channels.
    fn finish(mut self) -> Outcomes {
        let mut outcome = ReadOutcome {
            remarks: std::mem::take(&mut self.remarks),
            ..ReadOutcome::default()
        };
        if self.messages > 0 && !self.account.vouched {
            outcome.findings.push(Finding::warning(
                "mcap-unverified",
                "the file has neither statistics nor a checksum. Lost messages would not show. \
                 Write the file with a summary",
            ));
        }
        let mut read = Vec::new();
        let with_messages = self.topics.values().filter(|topic| topic.messages > 0);
        let names: Vec<String> = with_messages.map(|topic| topic.name.clone()).collect();
        for (id, topic) in &mut self.topics {
            if let Some(series) = topic.series.take() {
                let schema = self.schemas.get(&topic.schema_id);
                let lateral_path = schema.and_then(|schema| layout::lateral_path(&schema.name));
                let is_twin = names.iter().filter(|name| **name == topic.name).count() > 1;
                let mark = match is_twin {
                    true => lateral::twin_mark(*id),
                    false => String::new(),
                };
                let ReadTask {
                    options, limits, ..
                } = self.task;
                let channels = series.finish(lateral_path, &mark, options, limits);
                topic.contents = channels.contents.clone();
                read.push(ReadTopic {
                    id: *id,
                    likely: topic.likely,
                    channels,
                });
            }
        }
        self.task.each(|selection| match selection {
            Selection::Every => match &self.kept.exceeded {
                Some(error) => Err(error.clone()),
                None => Ok(self.every(&read, outcome.clone())),
            },
            Selection::Lateral => self.lateral(&read, outcome.clone()),
        })
    }

    /// True if the setting `channel` names a topic that was read, or a field of it.
    fn is_requested(&self, topic: &ReadTopic) -> bool {
        let name = &self.topics[&topic.id].name;
        self.requested_path(topic.id, name).is_some()
    }

    fn every(&self, read: &[ReadTopic], mut outcome: ReadOutcome) -> ReadOutcome {
        let mut delivered_ids = Vec::new();
        for topic in read {
            if topic.channels.has_nothing_requested || !(topic.likely || self.is_requested(topic)) {
                continue;
            }
            delivered_ids.push(topic.id);
            for field in &topic.channels.fields {
                let left_out = |error| draft::left_out(&field.words.name, error);
                match &field.channel {
                    Ok(channel) => outcome.channels.push(channel.clone()),
                    Err(error) => outcome.findings.push(left_out(error)),
                }
            }
        }
        let undelivered = self
            .topics
            .iter()
            .filter(|(id, _)| !delivered_ids.contains(id));
        let undelivered: Vec<&Topic> = undelivered.map(|(_, topic)| topic).collect();
        if !undelivered.is_empty() {
            let list = self.describe(undelivered);
            let text = format!("topics without acceleration messages: {list}");
            let left_out = Finding::info("topics-left-out", text);
            outcome.findings.push(left_out);
        }
        outcome
    }

    /// Delivers the one channel that is meant.
    fn lateral(&self, read: &[ReadTopic], mut outcome: ReadOutcome) -> Result<ReadOutcome, Error> {
        let named = self.task.options.channel.as_ref();
        let topics: Vec<&ReadTopic> = read
            .iter()
            .filter(|topic| match named {
                Some(_) => self.is_requested(topic),
                None => topic.likely && !topic.channels.has_nothing_requested,
            })
            .collect();
        if let (Some(requested), [_, _, ..]) = (named, topics.as_slice()) {
            let twin = |topic: &&ReadTopic| format!("{requested}{}", lateral::twin_mark(topic.id));
            let candidates = Candidates::named(topics.iter().map(twin));
            return Err(ErrorKind::AmbiguousChannel { candidates }.into());
        }
        let path = topics
            .first()
            .and_then(|topic| self.requested_path(topic.id, &self.topics[&topic.id].name)?);
        let fields: Vec<(usize, &TopicField)> = topics
            .iter()
            .flat_map(|topic| {
                let fields = topic.channels.fields.iter();
                fields.map(|field| (usize::from(topic.id), field))
            })
            .filter(|(_, field)| match path {
                Some(path) => field.path == path,
                None => field.may_be_lateral,
            })
            .collect();
        if let [(_, only)] = fields.as_slice()
            && let Err(error) = &only.channel
        {
            return Err(error.clone());
        }
        let columns: Vec<(usize, &ChannelName)> = fields
            .iter()
            .map(|(id, field)| (*id, &field.words))
            .collect();
        let index = match (path, fields.len()) {
            (_, 0) => return Err(self.no_channel(topics.first().copied())),
            (Some(_), _) => 0,
            (None, _) => {
                let choices = ChannelOffer::of_words(&columns, "channel id");
                lateral::take(&choices, self.list())?.0
            }
        };
        let field = fields[index].1;
        let mut errors = topics
            .iter()
            .filter_map(|topic| topic.channels.changed_fields.clone());
        if let Some(error) = errors.next().filter(|_| path.is_none()) {
            return Err(error);
        }
        let mut channel = field.channel.clone()?;
        // The fields of an unreadable topic are unknown: one may be the lateral acceleration that was
        // meant. Every topic of JSON is such a candidate, so that one gives a finding only.
        for topic in &topics {
            let mut fields = topic.channels.fields.iter();
            if let Some(unread) = fields.find(|field| field.path.is_empty())
                && let Err(error) = &unread.channel
            {
                let name = &unread.words.name;
                match self.topics[&topic.id].encoding == "json" {
                    true => outcome.findings.push(draft::left_out(name, error)),
                    false => return Err(error.clone()),
                }
            }
        }
        let name = &field.words.name;
        let place = || Place::default().channel(name);
        draft::check_unit(&channel, self.task.options).map_err(|error| error.at(place()))?;
        if named.is_none() {
            let text = format!(
                "{name} is the one lateral acceleration in the file. By REP 103 its y axis points \
                 left unless the sensor is mounted otherwise"
            );
            let chosen = Finding::info("channel-chosen", text);
            channel.findings.insert(0, chosen);
        }
        outcome.channels.push(channel);
        Ok(outcome)
    }

    /// Returns the reason why no channel is delivered; `topic` is the one that is meant, if any.
    fn no_channel(&self, topic: Option<&ReadTopic>) -> Error {
        if let Some(error) = topic.and_then(|topic| topic.channels.missing.clone()) {
            return error;
        }
        let named = self.task.options.channel.as_ref();
        let mut silent = self.topics.iter().filter(|(id, topic)| {
            let is_candidate = match named {
                Some(_) => self.requested_path(**id, &topic.name).is_some(),
                None => topic.likely && topic.encoding != "json",
            };
            is_candidate && topic.messages == 0
        });
        if let Some((_, topic)) = silent.next() {
            let found = format!("topic {} holds no message", topic.name);
            return Error::empty(found, "messages with an acceleration");
        }
        let available = self.list();
        if let Some(requested) = named.cloned() {
            return ErrorKind::NoSuchChannel {
                requested,
                known: available,
            }
            .into();
        }
        let topics = self.topics.values();
        let contents: Vec<Contents> = topics.map(|topic| self.contents(topic)).collect();
        let has_field = contents.iter().any(|topic| !topic.numbers.is_empty());
        // Arrays that no name calls lateral explain nothing where other topics have plain numbers.
        let explains =
            |topic: &Contents| topic.why_none().is_some() && !(has_field && topic.is_foreign());
        match contents.iter().any(explains) {
            true => Error::malformed(
                "a topic with one sample in each message",
                available,
                "export the topic as CSV, one row a sample",
            ),
            false => ErrorKind::NoChannel { known: available }.into(),
        }
    }

    /// Lists the topics with their message types.
    fn list(&self) -> String {
        match self.topics.is_empty() {
            true => "no topic".into(),
            false => self.describe(self.topics.values()),
        }
    }

    /// Describes topics, each with its type, its fields to choose from, and why there may be none.
    fn describe<'t>(&self, topics: impl IntoIterator<Item = &'t Topic>) -> String {
        const LISTED: usize = 40;
        let mut texts: Vec<String> = Vec::new();
        let mut more = 0;
        for topic in topics {
            if texts.len() >= LISTED {
                more += 1;
                continue;
            }
            let schema = self.schemas.get(&topic.schema_id);
            let schema = schema.map_or("no schema", |schema| schema.name.as_str());
            let plural = if topic.messages == 1 { "" } else { "s" };
            let (name, encoding, count) = (&topic.name, &topic.encoding, topic.messages);
            let head = Candidates::named([format!("{name} ({schema}, {encoding})")]);
            let mut text = format!("{head}: {count} message{plural}");
            if count > 0 {
                text += &self.contents(topic).in_words(name);
            }
            texts.push(text);
        }
        texts.extend((more > 0).then(|| format!("{more} more")));
        texts.join(", ")
    }

    /// Returns the contents of a topic for a list that a person reads.
    fn contents(&self, topic: &Topic) -> Contents {
        let schema = self.schemas.get(&topic.schema_id);
        match &topic.contents {
            Some(contents) => contents.clone(),
            None => layout::contents(&topic.encoding, schema, self.task.limits),
        }
    }
}
