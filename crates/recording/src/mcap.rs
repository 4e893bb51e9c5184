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
//! - `clock`: the clocks of a topic's messages: which one is used, and whether the others agree with
//!   it;
//! - `decompress`: chunks: decompression within limits, checked against the chunk's own size and
//!   checksum;
//! - `json`: JSON messages: one walk through the text that hands out every scalar with its path;
//! - `layout`: where in the messages of a type stands what is wanted of them, and in which unit;
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
use layout::{Contents, Laid, Schema, WantedFields};
use records::{PREFIX_BYTES, damaged};
use series::{Finished, Kept, LoggedMessage, TopicField, TopicSeries};
use std::collections::BTreeMap;
use std::io::{self, Read};
use types::Budget;

/// Bytes asked of the source at a time.
const READ_BYTES: usize = 64 << 10;

/// Tells whether the head carries MCAP's magic bytes.
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
pub fn read(source: &mut Reader, asked: ReadTask) -> Result<Outcomes, Error> {
    let way_out = ", or state the clock with the setting `time_source`";
    asked.options.refuse_other_clock("an MCAP log", way_out)?;
    let mut log = LogReader::new(asked);
    stream(source, &mut log, asked.limits)?;
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
            LinearReadEvent::ReadRequest(wanted) => {
                let wanted = wanted.clamp(1, READ_BYTES);
                let count = loop {
                    match source.read(reader.insert(wanted)) {
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

/// Says in our words what the framing of the file has wrong.
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
        McapError::RecordTooLarge { .. } | McapError::ChunkTooLarge(_) => log
            .asked
            .limits
            .over("mcap_record_bytes", error.to_string()),
        other => {
            let expected = format!("whole records, whose checksums fit, {after}");
            damaged(expected, other.to_string())
        }
    }
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
    /// Whether it may carry a lateral acceleration by its type, or be it JSON.
    likely: bool,
    /// What was read of it, from its first message on.
    series: Option<TopicSeries>,
    /// What its messages hold; `None` where only their type can tell.
    contents: Option<Contents>,
}

/// The state of reading one file.
#[derive(Debug)]
struct LogReader<'a> {
    asked: ReadTask<'a>,
    schemas: BTreeMap<u16, Schema>,
    schema_bytes: u64,
    topics: BTreeMap<u16, Topic>,
    /// Where in the messages of a type stands what is wanted of it.
    layouts: BTreeMap<(u16, String, WantedFields), Laid>,
    /// What the message types may still cost.
    budget: Budget,
    /// Values kept in all.
    kept: Kept,
    messages: u64,
    account: Account,
    /// What a person wrote of the file.
    remarks: Vec<Remark>,
}

/// Remarks on a file that are kept.
const REMARKS: usize = 1000;

impl<'a> LogReader<'a> {
    fn new(asked: ReadTask<'a>) -> Self {
        Self {
            asked,
            schemas: BTreeMap::new(),
            schema_bytes: 0,
            topics: BTreeMap::new(),
            layouts: BTreeMap::new(),
            budget: Budget::new(asked.limits),
            kept: Kept::default(),
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

    /// Takes in the fields of a record; `byte` is where it starts, or the chunk that holds it.
    fn parsed(&mut self, record: Record<'_>, byte: u64) -> Result<(), Error> {
        match record {
            Record::Schema { header, data } => self.schema(header, &data),
            Record::Channel(record) => self.channel(record),
            Record::Message { header, data } => self.message(header, &data, byte),
            Record::Chunk { header, data } => {
                let unpacked = decompress::records(&header, &data, self.asked.limits)?;
                self.chunk(&unpacked, byte)
            }
            Record::ChunkIndex(index) => {
                let (count, sum) = self.account.indexed;
                self.account.indexed = (count + 1, sum.wrapping_add(index.chunk_start_offset));
                Ok(())
            }
            Record::Statistics(said) => self.statistics(&said),
            Record::Footer(footer) => self.footer(footer.summary_start),
            _ => Ok(()),
        }
    }

    /// Takes in the records of the chunk that starts at `byte`.
    fn chunk(&mut self, mut left: &[u8], byte: u64) -> Result<(), Error> {
        let (count, sum) = self.account.chunks;
        self.account.chunks = (count + 1, sum.wrapping_add(byte));
        while let Some((opcode, data)) = records::next_in_chunk(&mut left)? {
            match opcode {
                op::SCHEMA | op::CHANNEL | op::MESSAGE => {
                    self.parsed(records::parse(opcode, data)?, byte)?;
                }
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

    /// Takes in what a person wrote of the file; `None` for a record that cannot be read.
    fn metadata(&mut self, record: Option<&Record<'_>>) {
        let comments: Vec<(&str, RemarkPlace)> = match record {
            Some(Record::Metadata(record)) => records::comments(&record.metadata)
                .map(|comment| (comment, RemarkPlace::Channel))
                .collect(),
            // What a person wrote there, nobody knows.
            _ => vec![("a record that cannot be read", RemarkPlace::State(None))],
        };
        for (comment, place) in comments {
            let (text, place) = match self.remarks.len() {
                ..REMARKS => (comment, place),
                REMARKS => ("more than is read", RemarkPlace::State(None)),
                _ => break,
            };
            let told = "the log's metadata say";
            self.remarks.push(Remark::new(text, place, told));
        }
    }

    fn schema(&mut self, record: SchemaHeader, data: &[u8]) -> Result<(), Error> {
        let texts = [&*record.name, &record.encoding];
        records::check_texts(&texts, "schema", self.asked.limits)?;
        if record.id == 0 {
            return Err(damaged("a schema id from 1", "0"));
        }
        if let Some(known) = self.schemas.get(&record.id) {
            let own = (&*known.name, &*known.encoding, &*known.data);
            if own == (&*record.name, &*record.encoding, data) {
                return Ok(());
            }
            let expected = format!("schema {} ({}) as before", record.id, known.name);
            let found = format!("another definition ({})", record.name);
            return Err(damaged(expected, found));
        }
        self.schema_bytes += (record.name.len() + record.encoding.len() + data.len()) as u64;
        if self.schema_bytes > self.asked.limits.mcap_record_bytes {
            let found = "schemas of more bytes together";
            return Err(self.asked.limits.over("mcap_record_bytes", found));
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
        records::check_texts(&texts, "channel", self.asked.limits)?;
        if let Some(known) = self.topics.get(&record.id) {
            let own = (&*known.name, &*known.encoding, known.schema_id);
            if own == (&*record.topic, &*record.message_encoding, record.schema_id) {
                return Ok(());
            }
            let expected = format!("channel {} (topic {}) as before", record.id, known.name);
            let found = format!("another definition (topic {})", record.topic);
            return Err(damaged(expected, found));
        }
        if record.schema_id != 0 && !self.schemas.contains_key(&record.schema_id) {
            let expected = format!("schema {} before topic {}", record.schema_id, record.topic);
            return Err(damaged(expected, "none"));
        }
        if self.topics.len() as u64 >= self.asked.limits.mcap_channels {
            return Err(self.asked.limits.over("mcap_channels", "more topics"));
        }
        let (wanted, likely) = self.wanted(&record)?;
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
                wanted,
                likely,
                series: None,
                contents: None,
            },
        );
        Ok(())
    }

    /// Returns what a person's word for a channel asks of a topic: the field at a path, or any. The
    /// word may end with the channel's id, as the names of topics that were recorded twice do.
    fn asked(&self, id: u16, topic: &str) -> Option<Option<&str>> {
        let wanted = self.asked.options.channel.as_deref()?;
        let wanted = lateral::without_twin_mark(wanted, id)?;
        let rest = wanted.strip_prefix(topic)?;
        match rest.is_empty() {
            true => Some(None),
            false => rest.strip_prefix(':').map(Some),
        }
    }

    /// Tells what is wanted of a topic, if anything, and whether it may carry a lateral acceleration.
    fn wanted(
        &mut self,
        record: &::mcap::records::Channel,
    ) -> Result<(Option<WantedFields>, bool), Error> {
        let likely = match self.schemas.get_mut(&record.schema_id) {
            _ if record.message_encoding == "json" => true,
            None => false,
            Some(schema) if layout::lateral_path(&schema.name).is_some() => true,
            Some(schema) => match schema.has_lateral_field {
                Some(known) => known,
                None => match layout::has_lateral_field(schema, &mut self.budget) {
                    Ok(found) => *schema.has_lateral_field.insert(found),
                    Err(error) if self.asked.options.channel.is_none() => return Err(error),
                    Err(error) => {
                        self.kept.over.get_or_insert(error);
                        false
                    }
                },
            },
        };
        let asked = self.asked(record.id, &record.topic);
        let all = self.asked.options.channel.is_none()
            || self.asked.selections.contains(&Selection::Every);
        let wanted = WantedFields {
            every: (all && likely) || asked == Some(None),
            path: asked.flatten().map(str::to_string),
            meant: self.asked.options.channel.is_none() || asked.is_some(),
        };
        let any = wanted.every || wanted.path.is_some();
        Ok((any.then_some(wanted), likely))
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
                    let laid = layout::layout(&topic.encoding, schema, wanted, &mut self.budget);
                    let laid = match laid {
                        Err(error) if !wanted.meant => {
                            self.kept.over.get_or_insert(error);
                            return Ok(());
                        }
                        laid => laid?,
                    };
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
            series.push(&message, &mut self.kept, self.asked.limits)?;
        }
        Ok(())
    }

    fn statistics(&mut self, said: &Statistics) -> Result<(), Error> {
        let (stated, by_channel) = (said.message_count, &said.channel_message_counts);
        let holds = |expected: String, stated: u64, found: u64| match stated == found {
            true => Ok(()),
            false => Err(Error::truncated(expected, format!("{found}"))),
        };
        let text = format!("{stated} messages, as the statistics say");
        holds(text, stated, self.messages)?;
        let mut sum = 0_u64;
        for (id, count) in by_channel {
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

    /// Holds what the footer says against what was read; `said` is where the summary starts.
    fn footer(&mut self, said: u64) -> Result<(), Error> {
        let account = &mut self.account;
        account.footer = true;
        if (said != 0 || account.summarised) && said != account.summary {
            return Err(Error::truncated(
                format!("the summary at byte {said}, as the footer says"),
                format!("the end of the data at byte {}", account.summary),
            ));
        }
        if account.indexed.0 > 0 && account.indexed != account.chunks {
            return Err(Error::truncated(
                format!("the {} chunks of the chunk index", account.indexed.0),
                format!("{} chunks, or others", account.chunks.0),
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
                let known = self.schemas.get(&topic.schema_id);
                let known = known.and_then(|schema| layout::lateral_path(&schema.name));
                let is_twin = names.iter().filter(|name| **name == topic.name).count() > 1;
                let mark = match is_twin {
                    true => lateral::twin_mark(*id),
                    false => String::new(),
                };
                let finished = series.finish(known, &mark, self.asked.options, self.asked.limits);
                topic.contents = finished.contents.clone();
                read.push((*id, topic.likely, finished));
            }
        }
        self.asked.each(|selection| match selection {
            Selection::Every => match &self.kept.over {
                Some(error) => Err(error.clone()),
                None => Ok(self.every(&read, outcome.clone())),
            },
            Selection::Lateral => self.lateral(&read, outcome.clone()),
        })
    }

    fn every(&self, read: &[(u16, bool, Finished)], mut outcome: ReadOutcome) -> ReadOutcome {
        let mut taken = Vec::new();
        let asked = |id: &u16| self.asked(*id, &self.topics[id].name).is_some();
        let meant = |(id, likely, topic): &&(u16, bool, Finished)| {
            (*likely || asked(id)) && !topic.is_other
        };
        for (id, _, topic) in read.iter().filter(meant) {
            taken.push(*id);
            for field in &topic.fields {
                let left_out = |error| draft::left_out(&field.words.name, error);
                match &field.channel {
                    Ok(channel) => outcome.channels.push(channel.clone()),
                    Err(error) => outcome.findings.push(left_out(error)),
                }
            }
        }
        let others = self.topics.iter().filter(|(id, _)| !taken.contains(id));
        let others: Vec<&Topic> = others.map(|(_, topic)| topic).collect();
        if !others.is_empty() {
            let others = self.describe(others);
            let text = format!("topics without acceleration messages: {others}");
            let left_out = Finding::info("topics-left-out", text);
            outcome.findings.push(left_out);
        }
        outcome
    }

    /// Takes the one channel that is meant.
    fn lateral(
        &self,
        read: &[(u16, bool, Finished)],
        mut outcome: ReadOutcome,
    ) -> Result<ReadOutcome, Error> {
        let named = self.asked.options.channel.as_ref();
        let name_of = |id: &u16| self.topics[id].name.as_str();
        let topics: Vec<(u16, &Finished)> = read
            .iter()
            .filter(|(id, likely, topic)| match named {
                Some(_) => self.asked(*id, name_of(id)).is_some(),
                None => *likely && !topic.is_other,
            })
            .map(|(id, _, topic)| (*id, topic))
            .collect();
        if let (Some(wanted), [_, _, ..]) = (named, topics.as_slice()) {
            let twin = |(id, _): &(u16, &Finished)| format!("{wanted}{}", lateral::twin_mark(*id));
            let candidates = Candidates::named(topics.iter().map(twin));
            return Err(ErrorKind::AmbiguousChannel { candidates }.into());
        }
        let path = topics
            .first()
            .and_then(|(id, _)| self.asked(*id, name_of(id)).flatten());
        let fields: Vec<(usize, &TopicField)> = topics
            .iter()
            .flat_map(|(id, topic)| topic.fields.iter().map(|field| (usize::from(*id), field)))
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
        let columns: Vec<(usize, &ChannelName)> =
            fields.iter().map(|(id, one)| (*id, &one.words)).collect();
        let index = match (path, fields.len()) {
            (_, 0) => return Err(self.no_channel(topics.first().map(|(_, topic)| *topic))),
            (Some(_), _) => 0,
            (None, _) => {
                let choices = ChannelOffer::of_words(&columns, "channel id");
                lateral::take(&choices, self.list())?.0
            }
        };
        let field = fields[index].1;
        let further = topics.iter().find_map(|(_, topic)| topic.further.clone());
        if let Some(error) = further.filter(|_| path.is_none()) {
            return Err(error);
        }
        let mut channel = field.channel.clone()?;
        // What a topic that cannot be read holds, nobody knows; a type may say what it should.
        for (id, topic) in &topics {
            let unread = topic.fields.iter().find(|one| one.path.is_empty());
            if let Some((name, Err(error))) = unread.map(|one| (&one.words.name, &one.channel)) {
                match self.topics[id].encoding == "json" {
                    true => outcome.findings.push(draft::left_out(name, error)),
                    false => return Err(error.clone()),
                }
            }
        }
        let name = &field.words.name;
        let place = || Place::default().channel(name);
        draft::check_unit(&channel, self.asked.options).map_err(|error| error.at(place()))?;
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

    /// Says why there is nothing to take, of the topic that is meant if there is one.
    fn no_channel(&self, topic: Option<&Finished>) -> Error {
        if let Some(error) = topic.and_then(|topic| topic.missing.clone()) {
            return error;
        }
        let named = self.asked.options.channel.as_ref();
        let mut silent = self.topics.iter().filter(|(id, topic)| {
            let meant = match named {
                Some(_) => self.asked(**id, &topic.name).is_some(),
                None => topic.likely && topic.encoding != "json",
            };
            meant && topic.messages == 0
        });
        if let Some((_, topic)) = silent.next() {
            let found = format!("topic {} holds no message", topic.name);
            return Error::empty(found, "messages with an acceleration");
        }
        let known = self.list();
        if let Some(wanted) = named.cloned() {
            return ErrorKind::NoSuchChannel { wanted, known }.into();
        }
        let contents: Vec<Contents> = self.topics.values().map(|one| self.contents(one)).collect();
        let has_field = contents.iter().any(|one| !one.numbers.is_empty());
        let is_why = |one: &Contents| one.why_none().is_some() && !(has_field && one.is_foreign());
        match contents.iter().any(is_why) {
            true => Error::malformed(
                "a topic with one sample in each message",
                known,
                "export the topic as CSV, one row a sample",
            ),
            false => ErrorKind::NoChannel { known }.into(),
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

    /// Returns what the messages of a topic hold, as far as a person is told.
    fn contents(&self, topic: &Topic) -> Contents {
        let schema = self.schemas.get(&topic.schema_id);
        let of_schema = || layout::contents(&topic.encoding, schema, self.asked.limits);
        topic.contents.clone().unwrap_or_else(of_schema)
    }
}
