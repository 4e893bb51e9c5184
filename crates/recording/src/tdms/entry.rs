//! A channel of the file with what its names and its unit say.

use super::object::Object;
use super::said;
use super::segment::ObjectPath;
use super::value::{DataType, Value};
use crate::ReadOptions;
use crate::channel_name::{ChannelName, mark_columns, words};
use std::collections::BTreeMap;

/// A channel of the file.
pub(super) struct Entry<'a> {
    /// Index among the objects.
    pub(super) at: usize,
    pub(super) object: &'a Object,
    /// The objects whose properties hold for it: its own, its group, the file.
    pub(super) objects: Vec<&'a Object>,
    pub(super) group: &'a str,
    /// The name in its group.
    pub(super) own_name: &'a str,
    /// What name and unit say; the name with the group before it where others have the same.
    pub(super) column: ChannelName,
    /// Whether it holds times of samples. Kept, since each channel looks for clocks among all others.
    pub(super) is_clock: bool,
}

impl Entry<'_> {
    /// Returns the type of the samples; `None` of a channel without any.
    pub(super) fn kind(&self) -> Option<DataType> {
        self.object.index.map(|index| index.kind)
    }

    fn holds_times(&self) -> bool {
        let has_unit = self.column.unit_text.is_some() || self.column.unit.is_some();
        let says_time = self.column.says_time() && (self.column.time_unit.is_some() || !has_unit);
        self.object.count > 0
            && match self.kind() {
                Some(DataType::Timestamp) => true,
                Some(kind) => kind.is_number() && says_time,
                None => false,
            }
    }

    /// Tells whether it holds flags or states of samples.
    pub(super) fn is_flag(&self) -> bool {
        let is_bit = |value: &f64| matches!(*value, 0.0 | 1.0);
        let is_of_flags = || match self.kind() {
            // DIAdem stores flags as it stores samples.
            Some(DataType::F32 | DataType::F64) => self.object.values.iter().all(is_bit),
            kind => kind.is_some_and(DataType::is_whole),
        };
        said::says_bad(self.own_name, "unknown") && is_of_flags()
    }

    /// Tells whether it holds samples of a quantity.
    pub(super) fn is_of_samples(&self) -> bool {
        self.object.count > 0
            && self.kind().is_some_and(DataType::is_number)
            && !self.is_clock
            && !self.is_flag()
    }

    /// Tells whether it may be asked for: numbers that are no times.
    pub(super) fn has_samples(&self) -> bool {
        self.kind().is_none_or(DataType::is_number) && !self.is_clock
    }

    /// Tells whether a user's word means this channel: its name, with its group or unit or without,
    /// or its number, counted from 1.
    pub(super) fn answers_to(&self, word: &str, number: usize) -> bool {
        let word = word.trim();
        let label = self.column.label.trim();
        self.column.name == word
            || self.own_name == word
            || format!("{}/{}", self.group, self.own_name) == word
            || (!label.is_empty() && label == word)
            || word.parse() == Ok(number)
    }
}

/// Words of a group's name that say that its channels are none of the vehicle's.
const FOREIGN_GROUPS: [&str; 6] = ["atd", "barrier", "dummy", "mdb", "occupant", "sled"];

/// Words of a group's name that say nothing.
const EMPTY_GROUPS: [&str; 4] = ["data", "group", "gruppe", "untitled"];

/// Words of the name of an only group that say nothing of its channels, beside those.
const EMPTY_ONLY_GROUPS: [&str; 13] = [
    "all",
    "channel",
    "channels",
    "crash",
    "daten",
    "log",
    "main",
    "measurement",
    "messung",
    "recording",
    "run",
    "test",
    "versuch",
];

/// Tells whether a word of the name of an only group says nothing: one of a list, with a number or without,
/// or the number of a test.
fn is_empty_of_only_group(word: &str) -> bool {
    let stem = word.trim_end_matches(|c: char| c.is_ascii_digit());
    let digits = word.len() - stem.len();
    EMPTY_GROUPS.contains(&stem)
        || EMPTY_ONLY_GROUPS.contains(&stem)
        || (digits >= 4 && stem.chars().count() <= 1)
}

/// Returns all channels in the order of the file.
pub(super) fn of<'a>(objects: &'a [Object], options: &ReadOptions) -> Vec<Entry<'a>> {
    let mut entries: Vec<Entry<'a>> = Vec::new();
    let file = objects
        .iter()
        .find(|object| object.path == ObjectPath::File);
    let groups = objects.iter().filter_map(|object| match &object.path {
        ObjectPath::Group(name) => Some((name.as_str(), object)),
        _ => None,
    });
    let groups: BTreeMap<&str, &Object> = groups.collect();
    for (at, object) in objects.iter().enumerate() {
        if let ObjectPath::Channel(group, own_name) = &object.path {
            let number = entries.len() + 1;
            let unit = object.property("unit_string").map(Value::text);
            let column = ChannelName::from_header(own_name, number);
            entries.push(Entry {
                at,
                object,
                objects: [Some(object), groups.get(group.as_str()).copied(), file]
                    .into_iter()
                    .flatten()
                    .collect(),
                group,
                own_name,
                column: column.with_unit(&unit.unwrap_or_default(), "header"),
                is_clock: false,
            });
        }
    }
    let mut groups: Vec<&str> = entries.iter().map(|entry| entry.group).collect();
    groups.sort_unstable();
    groups.dedup();
    let mut names: Vec<&str> = entries.iter().map(|entry| entry.own_name).collect();
    names.sort_unstable();
    for entry in &mut entries {
        let first = names.partition_point(|name| *name < entry.own_name);
        if names.get(first + 1) == Some(&entry.own_name) {
            entry.column.name = format!("{}/{}", entry.group, entry.own_name);
        }
        // One group is as good as none, as long as nothing in its name speaks against its channels.
        let mut group_words = words(entry.group);
        group_words.retain(|word| !EMPTY_GROUPS.contains(&word.as_str()));
        let mut is_foreign = group_words
            .iter()
            .any(|word| FOREIGN_GROUPS.contains(&word.as_str()));
        if groups.len() == 1 {
            let mut telling_words = group_words.clone();
            telling_words.retain(|word| !is_empty_of_only_group(word));
            let mut only = ChannelName::unnamed(1);
            only.describe(telling_words.join(" "));
            // A letter alone says as little as none, unless beside others.
            let says = telling_words.iter().any(|word| word.chars().count() > 1);
            if says && (only.odd_word().is_some() || only.says_filtered()) {
                is_foreign = true;
                group_words = telling_words;
            }
        }
        if (groups.len() > 1 || is_foreign) && !group_words.is_empty() {
            let words = format!("{} {}", group_words.join(" "), entry.column.label);
            entry.column.describe(words);
        }
        entry.is_clock = entry.holds_times();
    }
    let columns = entries.iter_mut().map(|entry| &mut entry.column);
    mark_columns(columns.collect(), options);
    entries
}
