//! The test's own header, the `.mme`: what was tested where, and which side was struck.

use super::channel::ChannelHeader;
use crate::code::VehicleSide;
use crate::held::Statement;
use crate::remarks::{self, Remark, RemarkPlace};
use crate::{Finding, TestFacts, fact, joined_facts, text};
use std::collections::BTreeMap;

/// What the test's own header says.
#[derive(Debug, Default)]
pub(super) struct TestHeader {
    /// Its file; `None` where the test has none.
    pub(super) file: Option<String>,
    /// Which side of each test object was struck, by the character that codes have for the object.
    pub(super) struck_sides: BTreeMap<u8, VehicleSide>,
    /// What people wrote there; it is of the whole test.
    pub(super) remarks: Vec<Remark>,
    /// Values that say something, by their keys in small words without points; of a key that comes
    /// twice the first.
    facts: BTreeMap<String, String>,
}

impl TestHeader {
    /// Reads it from decoded text. Two sides of one test object exclude one another.
    pub(super) fn read(content: &str, findings: &mut Vec<Finding>) -> Self {
        let mut header = Self::default();
        for (key, value) in text::lines(content).filter_map(|(_, line)| line.split_once(':')) {
            if remarks::is_key(key) {
                let teller = "the test's header says";
                let remark = Remark::new(value, RemarkPlace::Apart, teller);
                header.remarks.push(remark);
            }
            if let Some(value) = fact(value) {
                header.facts.entry(plain(key)).or_insert(value);
            }
            header.take_side(key, value, findings);
        }
        header
    }

    /// Takes in which side of a test object was struck, if a line says that.
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
                .is_some_and(|known| known != side)
        {
            let (key, text) = (&*key, &*value);
            findings.push(Statement { key, text }.contradicts("another line says the other"));
        }
    }

    /// Returns what it says of the test and of the test object to which a channel belongs.
    pub(super) fn test_facts(&self, channel: &ChannelHeader) -> TestFacts {
        let one = |key: &str| self.facts.get(key).cloned();
        let number = one("laboratory test ref number")
            .or_else(|| one("test number"))
            .or_else(|| one("customer test ref number"));
        let object = channel.object().unwrap_or_default().to_lowercase();
        TestFacts {
            test: joined_facts([number, one("title"), one("type of the test")]),
            vehicle: joined_facts([
                one(&format!("name of test object {object}")),
                one(&format!("ref number of test object {object}")),
            ]),
            laboratory: one("laboratory name"),
            date: one("date of the test"),
            ..TestFacts::default()
        }
    }
}

/// Returns a key in small words, without the points of abbreviations, which some programs leave out.
fn plain(key: &str) -> String {
    let key = key.to_lowercase().replace('.', " ");
    key.split_whitespace().collect::<Vec<_>>().join(" ")
}
