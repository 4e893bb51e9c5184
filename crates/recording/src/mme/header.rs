//! The test's header, the `.mme`: test objects, and the side that was struck.

use super::channel::ChannelHeader;
use crate::code::VehicleSide;
use crate::held::Statement;
use crate::remarks::{self, Remark, RemarkPlace};
use crate::{Finding, TestFacts, fact, joined_facts, text};
use std::collections::BTreeMap;

/// Content of the test's header.
#[derive(Debug, Default)]
pub(super) struct TestHeader {
    /// Its file; `None` where the test has none.
    pub(super) file: Option<String>,
    /// The side of each test object that was struck, by the character that codes have for the object.
    pub(super) struck_sides: BTreeMap<u8, VehicleSide>,
    /// Free words on the whole test.
    pub(super) remarks: Vec<Remark>,
    /// Values other than placeholders, by their keys in small words without points; of a key that occurs
    /// twice, the first.
    facts: BTreeMap<String, String>,
}

impl TestHeader {
    /// Reads it from decoded text. Two sides of one test object exclude one another.
    pub(super) fn read(content: &str, findings: &mut Vec<Finding>) -> Self {
        let mut header = Self::default();
        for (key, value) in text::lines(content).filter_map(|(_, line)| line.split_once(':')) {
            if remarks::is_key(key) {
                let source = "the test's header says";
                let remark = Remark::new(value, RemarkPlace::Apart, source);
                header.remarks.push(remark);
            }
            if let Some(value) = fact(value) {
                header.facts.entry(plain(key)).or_insert(value);
            }
            header.take_side(key, value, findings);
        }
        header
    }

    /// Reads the side of a test object that was struck, if a line states it.
    fn take_side(&mut self, key: &str, value: &str, findings: &mut Vec<Finding>) {
        let key = key.trim().to_ascii_uppercase();
        let object = key.strip_prefix("IMPACT SIDE TEST OBJECT").map(str::trim);
        let value = value.trim().to_ascii_lowercase();
        let side = match value.split(|c: char| !c.is_alphabetic()).next() {
            Some("left" | "le" | "links") => VehicleSide::Left,
            Some("right" | "ri" | "rechts") => VehicleSide::Right,
            _ => return,
        };
        if let Some(&[object]) = object.map(str::as_bytes)
            && self
                .struck_sides
                .insert(object, side)
                .is_some_and(|earlier| earlier != side)
        {
            let (key, text) = (&*key, &*value);
            findings.push(Statement { key, text }.contradicts("another line says the other"));
        }
    }

    /// Returns the facts of the test and of the test object to which a channel belongs.
    pub(super) fn test_facts(&self, channel: &ChannelHeader) -> TestFacts {
        let value_of = |key: &str| self.facts.get(key).cloned();
        let number = value_of("laboratory test ref number")
            .or_else(|| value_of("test number"))
            .or_else(|| value_of("customer test ref number"));
        let object = channel.object().unwrap_or_default().to_lowercase();
        TestFacts {
            test: joined_facts([number, value_of("title"), value_of("type of the test")]),
            vehicle: joined_facts([
                value_of(&format!("name of test object {object}")),
                value_of(&format!("ref number of test object {object}")),
            ]),
            laboratory: value_of("laboratory name"),
            date: value_of("date of the test"),
            ..TestFacts::default()
        }
    }
}

/// Returns a key in small words, without the points of abbreviations, which some programs leave out.
fn plain(key: &str) -> String {
    let key = key.to_lowercase().replace('.', " ");
    key.split_whitespace().collect::<Vec<_>>().join(" ")
}
