//! From a stream of bytes to objects: one pass, a block of metadata and a block of samples at a time.

use super::object::{self, Object};
use super::segment::{self, LEAD_IN_BYTES, LeadIn, ObjectPath, RawData, RawIndex};
use super::value::{ByteOrder, DataType, Value, damaged};
use crate::error::{Error, Place};
use crate::{Limits, text};
use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;

/// Bytes of samples read at a time.
const BLOCK_BYTES: u64 = 64 << 10;

/// The objects of a file, as they are read.
struct FileReader<'a, R> {
    source: R,
    limits: &'a Limits,
    /// Says of which objects samples are kept on where they cross their limit.
    keep: &'a dyn Fn(&[Object]) -> Vec<usize>,
    /// Bytes read.
    byte: u64,
    objects: Vec<Object>,
    places: BTreeMap<ObjectPath, usize>,
    /// Objects of the current list, each with samples in a segment or without.
    list: Vec<(usize, bool)>,
    /// Where each object stands in the list.
    list_places: BTreeMap<usize, usize>,
    /// Those of the list that have samples, and where.
    chunk: Vec<(usize, RawIndex)>,
    /// Bytes of a chunk.
    chunk_bytes: u64,
    property_bytes: i64,
    /// Samples kept of all channels.
    kept: u64,
    /// Whether `keep` was asked already.
    is_narrowed: bool,
    has_samples: bool,
    block: Vec<u8>,
    is_cut: bool,
    segments: u64,
    /// Objects and properties that were gone through.
    steps: u64,
}

/// What a file holds.
pub(super) struct Contents {
    pub(super) objects: Vec<Object>,
    /// Whether the file ends before its last segment does.
    pub(super) is_cut: bool,
}

/// Reads all segments. Where the samples of all channels together cross their limit, `keep` says of
/// which objects they are kept on; without any the limit stands as an error.
pub(super) fn contents<R: Read>(
    source: R,
    limits: &Limits,
    keep: &dyn Fn(&[Object]) -> Vec<usize>,
) -> Result<Contents, Error> {
    let mut reader = FileReader {
        source,
        limits,
        keep,
        byte: 0,
        objects: Vec::new(),
        places: BTreeMap::new(),
        list: Vec::new(),
        list_places: BTreeMap::new(),
        chunk: Vec::new(),
        chunk_bytes: 0,
        property_bytes: 0,
        kept: 0,
        is_narrowed: false,
        has_samples: false,
        block: Vec::new(),
        is_cut: false,
        segments: 0,
        steps: 0,
    };
    loop {
        let start = reader.byte;
        let placed = |error: Error| error.at(Place::default().byte(start));
        if !reader.segment().map_err(placed)? || reader.is_cut {
            break;
        }
    }
    let (segments, steps) = (reader.segments, reader.steps);
    tracing::debug!(segments, steps, "segments read");
    if reader.objects.is_empty() {
        let end = "the end of the file before the first list of channels";
        return Err(Error::truncated("a whole segment of TDMS", end));
    }
    Ok(Contents {
        objects: reader.objects,
        is_cut: reader.is_cut,
    })
}

impl<R: Read> FileReader<'_, R> {
    /// Reads `count` bytes into the block; fewer, and a cut, at the end of the file.
    fn fill(&mut self, count: u64) -> Result<(), Error> {
        self.block.clear();
        let read = (&mut self.source).take(count).read_to_end(&mut self.block);
        let read = read.map_err(|error| Error::io("read the file", &error))? as u64;
        self.byte += read;
        self.is_cut = read < count;
        Ok(())
    }

    /// Reads a segment; `false` at the end of the file.
    fn segment(&mut self) -> Result<bool, Error> {
        self.fill(LEAD_IN_BYTES as u64)?;
        if self.block.is_empty() {
            self.is_cut = false;
            return Ok(false);
        }
        let Ok(lead_in) = self.block.as_slice().try_into() else {
            let compared_bytes = self.block.len().min(segment::TAG.len());
            return match self.block[..compared_bytes] == segment::TAG[..compared_bytes] {
                true => Ok(true),
                false => Err(segment::untagged()),
            };
        };
        let lead_in = LeadIn::read(lead_in)?;
        self.segments += 1;
        if lead_in.metadata_bytes > self.limits.headers_bytes {
            let metadata = format!("metadata of {} bytes", lead_in.metadata_bytes);
            return Err(self.limits.over("headers_bytes", metadata));
        }
        self.fill(lead_in.metadata_bytes)?;
        if self.is_cut {
            return Ok(true);
        }
        if lead_in.has_metadata() {
            self.take_list(lead_in)?;
        } else if self.objects.is_empty() {
            return Err(damaged("a list of channels in the first segment", "none"));
        }
        if lead_in.has_data() {
            self.samples(lead_in)?;
        }
        // A segment that was not closed has no other end than that of the file.
        self.is_cut |= lead_in.data_bytes.is_none();
        Ok(true)
    }

    /// Takes in the metadata of a segment.
    fn take_list(&mut self, lead_in: LeadIn) -> Result<(), Error> {
        let listed = segment::listed(&self.block, lead_in.order(), self.limits)?;
        let mut is_changed = lead_in.has_new_list();
        if is_changed {
            self.list.clear();
            self.list_places.clear();
        }
        let mut listed_places = BTreeSet::new();
        for entry in listed {
            let object_place = self.place_of(&entry.path)?;
            if !listed_places.insert(object_place) {
                return Err(damaged("each object once in a segment", "one twice"));
            }
            let object = &mut self.objects[object_place];
            match entry.raw {
                RawData::As(index) => {
                    let before = object.index.replace(index);
                    is_changed |= before != Some(index);
                    if before.is_some_and(|before| before.kind != index.kind) {
                        let (kind, count) = (index.kind, object.count);
                        let change = format!("{kind:?} after {count} samples of another");
                        return Err(damaged("one type of data for a channel", change));
                    }
                }
                RawData::AsBefore if object.index.is_none() => {
                    let missing_index = "one as before, and none before";
                    return Err(damaged("a raw data index of a channel", missing_index));
                }
                RawData::AsBefore | RawData::Absent => {}
            }
            let has_data = entry.raw != RawData::Absent;
            match self.list_places.get(&object_place) {
                Some(place) => {
                    is_changed |= self.list[*place].1 != has_data;
                    self.list[*place].1 = has_data;
                }
                None => {
                    is_changed = true;
                    self.list_places.insert(object_place, self.list.len());
                    self.list.push((object_place, has_data));
                }
            }
            let object = &mut self.objects[object_place];
            let has_samples = match object.path {
                ObjectPath::Channel(..) => object.count > 0,
                ObjectPath::File | ObjectPath::Group(_) => self.has_samples,
            };
            let mut binding: BTreeMap<String, Value> = BTreeMap::new();
            self.steps += 1 + entry.properties.len() as u64;
            for (key, value) in entry.properties {
                if object::is_binding(&key)
                    && let Some(before) = binding.insert(key.to_lowercase(), value.clone())
                    && before != value
                {
                    let (key, before) = (text::shown(&key), text::shown(before.text()));
                    let both_values = format!("`{before}` and `{}`", text::shown(value.text()));
                    let error = damaged(format!("`{key}` once"), both_values);
                    object.error.get_or_insert(error);
                }
                self.property_bytes += object.set(key, value, has_samples);
                if self.property_bytes > self.limits.headers_bytes as i64 {
                    let excess = "more bytes of properties";
                    return Err(self.limits.over("headers_bytes", excess));
                }
            }
        }
        // Of many short segments most change nothing of the list.
        if !is_changed {
            return Ok(());
        }
        self.steps += self.list.len() as u64;
        let objects = &self.objects;
        let with_data = self.list.iter().filter(|(_, has_data)| *has_data);
        let chunk = with_data.filter_map(|(place, _)| Some((*place, objects[*place].index?)));
        self.chunk = chunk.filter(|(_, index)| index.bytes > 0).collect();
        let sizes = self.chunk.iter().map(|(_, index)| index.bytes);
        self.chunk_bytes = sizes.fold(0_u64, u64::saturating_add);
        Ok(())
    }

    /// Returns the number of an object, which may be new.
    fn place_of(&mut self, path: &ObjectPath) -> Result<usize, Error> {
        if let Some(place) = self.places.get(path) {
            return Ok(*place);
        }
        let place = self.objects.len();
        if place as u64 >= self.limits.columns {
            return Err(self.limits.over("columns", "more channels and groups"));
        }
        self.places.insert(path.clone(), place);
        let mut object = Object::new(path.clone());
        object.is_left_out = self.is_narrowed;
        self.objects.push(object);
        Ok(place)
    }

    /// Reads the samples of a segment.
    fn samples(&mut self, lead_in: LeadIn) -> Result<(), Error> {
        let chunk_bytes = self.chunk_bytes;
        let chunks = match (chunk_bytes, lead_in.data_bytes) {
            (0, None | Some(0)) => 0,
            (_, None) => u64::MAX,
            (1.., Some(bytes)) if bytes % chunk_bytes == 0 => bytes / chunk_bytes,
            (_, Some(bytes)) => {
                let expected = format!("whole chunks of {chunk_bytes} bytes, as the list says");
                return Err(damaged(expected, format!("{bytes} bytes of samples")));
            }
        };
        let is_interleaved = lead_in.is_interleaved() && self.chunk.len() > 1;
        if is_interleaved {
            let first = self.chunk[0].1.count;
            let fits = |index: &RawIndex| index.count == first && index.kind.bytes().is_some();
            if !self.chunk.iter().all(|(_, index)| fits(index)) {
                let expected = "interleaved numbers, as many of each channel";
                return Err(damaged(expected, "others in the list"));
            }
        }
        for _ in 0..chunks {
            match is_interleaved {
                true => self.interleaved_chunk(lead_in.order())?,
                false => self.contiguous_chunk(lead_in.order())?,
            }
            if self.is_cut {
                break;
            }
        }
        Ok(())
    }

    /// Reads a chunk in which the samples of each channel stand together.
    fn contiguous_chunk(&mut self, order: ByteOrder) -> Result<(), Error> {
        self.steps += self.chunk.len() as u64;
        for place in 0..self.chunk.len() {
            let (object_place, index) = self.chunk[place];
            let Some(size) = index.kind.bytes() else {
                self.texts(object_place, index, order)?;
                if self.is_cut {
                    return Ok(());
                }
                continue;
            };
            let mut remaining_bytes = index.bytes;
            while remaining_bytes > 0 {
                let count = remaining_bytes.min(BLOCK_BYTES);
                self.fill(count)?;
                remaining_bytes -= count;
                self.take(
                    object_place,
                    index.kind,
                    order,
                    (0, size as usize, size as usize),
                )?;
                if self.is_cut {
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// Reads a chunk in which the samples of all channels take turns.
    fn interleaved_chunk(&mut self, order: ByteOrder) -> Result<(), Error> {
        let size = |index: RawIndex| index.kind.bytes().unwrap_or(0);
        let row: u64 = self.chunk.iter().map(|(_, index)| size(*index)).sum();
        let mut remaining_rows = self.chunk[0].1.count;
        while remaining_rows > 0 {
            let rows = remaining_rows.min((BLOCK_BYTES / row).max(1));
            self.fill(rows * row)?;
            self.steps += self.chunk.len() as u64;
            remaining_rows -= rows;
            // Of a row that was cut no sample counts.
            let complete_bytes = self.block.len() - self.block.len() % row as usize;
            self.block.truncate(complete_bytes);
            let mut offset = 0;
            for place in 0..self.chunk.len() {
                let (object_place, index) = self.chunk[place];
                let size = size(index) as usize;
                self.take(
                    object_place,
                    index.kind,
                    order,
                    (offset, size, row as usize),
                )?;
                offset += size;
            }
            if self.is_cut {
                break;
            }
        }
        Ok(())
    }

    /// Takes the samples of an object from the block: each of so many bytes, at that offset in every
    /// stretch of so many.
    fn take(
        &mut self,
        place: usize,
        kind: DataType,
        order: ByteOrder,
        (offset, size, stretch): (usize, usize, usize),
    ) -> Result<(), Error> {
        let object = &mut self.objects[place];
        let before = object.values.len();
        for bytes in self.block.chunks_exact(stretch) {
            object.take(kind, &bytes[offset..offset + size], order);
        }
        self.has_samples |= object.count > 0;
        self.kept += (object.values.len() - before) as u64;
        object.check_count(self.limits);
        if self.kept > self.limits.test_samples {
            self.narrow()?;
        }
        Ok(())
    }

    /// Keeps the samples of few objects on.
    fn narrow(&mut self) -> Result<(), Error> {
        let kept = match self.is_narrowed {
            true => Vec::new(),
            false => (self.keep)(&self.objects),
        };
        self.is_narrowed = true;
        for (place, object) in self.objects.iter_mut().enumerate() {
            if !kept.contains(&place) {
                object.leave_out();
            }
        }
        self.kept = self
            .objects
            .iter()
            .map(|object| object.values.len() as u64)
            .sum();
        match kept.is_empty() || self.kept > self.limits.test_samples {
            true => Err(self
                .limits
                .over("test_samples", "more samples in all channels")),
            false => Ok(()),
        }
    }

    /// Reads a chunk of texts.
    fn texts(&mut self, place: usize, index: RawIndex, order: ByteOrder) -> Result<(), Error> {
        if index.bytes > self.limits.headers_bytes {
            let chunk_size = format!("{} bytes of text in a chunk", index.bytes);
            return Err(self.limits.over("headers_bytes", chunk_size));
        }
        self.fill(index.bytes)?;
        match self.is_cut {
            true => Ok(()),
            false => self.objects[place].take_texts(index.count, &self.block, order),
        }
    }
}
