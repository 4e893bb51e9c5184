//! The run inside a stored verdict made again, and compared key by key.

use super::compare::{self, Difference};
use super::prepared::Extras;
use super::{Control, Design, Limits, Request, Source, judge};
use latchgate_document::blocks::RecordingBlock;
use latchgate_document::design_file::design_from_document;
use latchgate_document::identity;
use latchgate_document::json;
use latchgate_kernel::error::Error as KernelError;
use latchgate_recording::error::Error;
use serde::de::{DeserializeSeed, Deserializer, Error as _, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fmt;
use std::fs;
use std::path::Path;

/// A verdict as it was stored.
#[derive(Debug, Clone)]
pub struct Stored {
    document: Value,
    design: Design,
    request: Request,
}

/// What making a stored verdict again came to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Verification {
    /// `latchgate.verify/1`.
    pub schema: String,
    /// Whether every key and every digit is the same.
    pub same: bool,
    /// The verdicts.
    pub verdict: StoredAndNow,
    /// The versions that made them.
    pub version: StoredAndNow,
    /// The recording.
    pub recording: VerifiedFile,
    /// The files beside the verdict.
    pub report: VerifiedReport,
    /// Keys that differ.
    pub differences: usize,
    /// The first of them.
    pub first_difference: Option<Difference>,
}

/// The files of a report beside a verdict, made again from the same run and compared byte for byte.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct VerifiedReport {
    /// Those that are the same.
    pub same: Vec<String>,
    /// Those that are not.
    pub different: Vec<String>,
    /// Those that were not compared.
    pub not_compared: Vec<String>,
    /// Those that belong to the report and are gone from beside its page.
    pub missing: Vec<String>,
}

impl VerifiedReport {
    /// Compares the files of a report that lie in `folder` with those `made` again; `None` where they cannot be
    /// expected to be the same. A page without the files that it shows or names is no whole report; a verdict alone
    /// may be kept alone.
    fn of(folder: &Path, made: Option<&[(String, Vec<u8>)]>) -> Self {
        let mut report = Self::default();
        let has_page = folder.join(latchgate_report::REPORT_FILE).exists();
        for name in latchgate_report::names() {
            if name == latchgate_report::VERDICT_FILE {
                continue;
            }
            let path = folder.join(&name);
            let made = made
                .into_iter()
                .flatten()
                .find(|(of_made, _)| *of_made == name);
            if !path.exists() {
                if has_page && made.is_some() {
                    report.missing.push(name);
                }
                continue;
            }
            let list = match made {
                None => &mut report.not_compared,
                Some((_, bytes)) if fs::read(&path).is_ok_and(|found| found == *bytes) => {
                    &mut report.same
                }
                Some(_) => &mut report.different,
            };
            list.push(name);
        }
        report
    }
}

/// A value in the stored verdict and in the one made again.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct StoredAndNow {
    /// As stored.
    pub stored: Option<String>,
    /// As it comes out now.
    pub now: Option<String>,
}

/// The file of a verification.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct VerifiedFile {
    /// Its name, as stored.
    pub file: String,
    /// Hashes of its bytes.
    pub sha256: StoredAndNow,
}

fn malformed(expected: impl Into<String>, found: impl Into<String>) -> Error {
    Error::malformed(
        expected,
        found,
        "give a verdict.json that latchgate replay wrote",
    )
}

impl Stored {
    /// Reads a stored verdict, checking that its parts belong together: where this version's
    /// numbers made it, its identity must be that of the question and the hashes in it.
    ///
    /// # Examples
    ///
    /// ```
    /// use latchgate::pipeline::Stored;
    ///
    /// let text = std::fs::read("reports/sill/verdict.json").unwrap();
    /// let stored = Stored::from_json(&text)?;
    /// assert_eq!(stored.file(), "sill_60g.csv");
    /// assert!(Stored::from_json(b"{}").is_err());
    /// # Ok::<(), latchgate_recording::error::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Malformed`] for anything but such a document, those of [`Design::set`] and of
    /// a [`Request`] for a design or question that is none.
    pub fn from_json(bytes: &[u8]) -> Result<Self, Error> {
        let document: Value = serde_json::from_slice(bytes)
            .map_err(|error| malformed("a JSON document", error.to_string()))?;
        // Of two keys of one name a reader takes the first, another the last.
        if let Some(key) = duplicate_key(bytes) {
            return Err(malformed("each key once", format!("`{key}` twice")));
        }
        match document["schema"].as_str() {
            Some("latchgate.verdict/1") if document["run"]["version"].is_string() => {}
            Some("latchgate.verdict/1") => return Err(malformed("run.version", "none")),
            found => {
                let found = found.map_or_else(|| "no schema".into(), |name| format!("{name:?}"));
                return Err(malformed("\"schema\": \"latchgate.verdict/1\"", found));
            }
        }
        let design = design(&document)?;
        let request = request(&document)?;
        let stored = Self {
            document,
            design,
            request,
        };
        stored.check_identity()?;
        Ok(stored)
    }

    /// Returns the design of the verdict.
    pub fn design(&self) -> &Design {
        &self.design
    }

    /// Returns the question.
    pub fn request(&self) -> &Request {
        &self.request
    }

    /// Returns the name of the recording's file.
    pub fn file(&self) -> &str {
        self.document["recording"]["file"].as_str().unwrap_or("")
    }

    /// Returns the hash of the recording's bytes.
    pub fn sha256(&self) -> Option<&str> {
        self.document["recording"]["sha256"].as_str()
    }

    /// Returns what goes with the verdict and is made again with it.
    fn extras(&self) -> Extras {
        let filters = self.document["filters"].as_array();
        Extras {
            filter_table: filters.is_some_and(|rows| !rows.is_empty()),
            preload_answer: self.document["preload_answer"].is_object(),
            evidence: true,
        }
    }

    /// Refuses a verdict whose question, design or hashes were changed by hand.
    fn check_identity(&self) -> Result<(), Error> {
        let id = self.document["report_id"]
            .as_str()
            .ok_or_else(|| malformed("report_id", "none"))?;
        let revision = self.document["run"]["numbers_revision"]
            .as_u64()
            .and_then(|revision| u32::try_from(revision).ok())
            .ok_or_else(|| malformed("run.numbers_revision", "none"))?;
        let recording: RecordingBlock = serde_json::from_value(self.document["recording"].clone())
            .map_err(|error| malformed("a recording block", error.to_string()))?;
        if identity::report_id_of(revision, &recording, &self.request, &self.design) == id {
            return Ok(());
        }
        Err(Error::malformed(
            "the report_id that recording, request and design of the verdict give",
            "another one",
            "replay the recording again; the verdict was changed by hand, or made of two",
        ))
    }
}

/// Takes the question from a verdict.
fn request(document: &Value) -> Result<Request, Error> {
    let block = &document["request"];
    if !block.is_object() {
        return Err(malformed("request, the question as data", "none"));
    }
    serde_json::from_value(block.clone())
        .map_err(|error| malformed("a request that this version knows", error.to_string()))
}

/// Takes the design from a verdict, with the checks of a design file.
fn design(document: &Value) -> Result<Design, Error> {
    design_from_document(&document["design"])
        .map_err(|wrong| malformed("a design that a latch can have", wrong))
}

/// Makes the run of a stored verdict again, as `request` asks, and compares every key but `run`
/// and every number to its last digit. `renamed` says that the recording goes by another name
/// now. The files of a report in `folder`, where there is one, are compared with those that belong to the run.
///
/// # Errors
///
/// [`Stopped`](latchgate_kernel::error::Error::Stopped) if `control` ends the work. A recording that is refused is no error: the
/// document that says so is compared.
pub fn verify(
    stored: &Stored,
    source: &Source,
    request: &Request,
    renamed: bool,
    folder: Option<&Path>,
    limits: &Limits,
    control: &Control<'_>,
) -> Result<Verification, Error> {
    let mut outcome = judge(
        source,
        request,
        &stored.design,
        stored.extras(),
        limits,
        control,
    );
    if outcome.was_stopped() {
        return Err(KernelError::Stopped.into());
    }
    let now = json::render(&outcome.document)
        .parse::<Value>()
        .map_err(|error| malformed("a document", error.to_string()))?;
    let mut before = stored.document.clone();
    let mut after = now;
    let revised = before["run"]["numbers_revision"] != after["run"]["numbers_revision"];
    let within = *limits != Limits::default();
    if within {
        // Whoever verifies may do it within limits of his own.
        after["request"]["limit"] = before["request"]["limit"].clone();
        before["request"]["limit"] = after["request"]["limit"].clone();
    }
    if renamed || revised || within {
        // Name, revision and limits are part of the identity, which was checked by itself.
        before["report_id"] = Value::Null;
        after["report_id"] = Value::Null;
    }
    let comparison = compare::compare(&before, &after, renamed);
    let both = |of: &dyn Fn(&Value) -> &Value| StoredAndNow {
        stored: of(&before).as_str().map(String::from),
        now: of(&after).as_str().map(String::from),
    };
    let version = both(&|document| &document["run"]["version"]);
    // The page tells name, identity and version, which may differ where no number does.
    let is_same_page = comparison.first.is_none()
        && !revised
        && stored.file() == outcome.document.recording.file
        && !within
        && version.stored == version.now;
    // Day and maker are those of the run that wrote the files.
    if let Ok(run) = serde_json::from_value(before["run"].clone()) {
        outcome.document.run = run;
    }
    let made =
        is_same_page.then(|| latchgate_report::files(&outcome.document, outcome.evidence.as_ref()));
    let report = folder.map(|folder| VerifiedReport::of(folder, made.as_deref()));
    let report = report.unwrap_or_default();
    Ok(Verification {
        schema: "latchgate.verify/1".into(),
        same: comparison.first.is_none()
            && report.different.is_empty()
            && report.missing.is_empty(),
        verdict: both(&|document| &document["verdict"]),
        version,
        report,
        recording: VerifiedFile {
            file: stored.file().to_string(),
            sha256: both(&|document| &document["recording"]["sha256"]),
        },
        differences: comparison.differences,
        first_difference: comparison.first,
    })
}

/// Returns a key that an object of a JSON document has twice.
fn duplicate_key(bytes: &[u8]) -> Option<String> {
    struct Unique;

    impl<'de> DeserializeSeed<'de> for Unique {
        type Value = ();

        fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
            deserializer.deserialize_any(self)
        }
    }

    impl<'de> Visitor<'de> for Unique {
        type Value = ();

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("JSON")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
            let mut seen = BTreeSet::new();
            while let Some(key) = map.next_key::<String>()? {
                if seen.contains(&key) {
                    return Err(A::Error::custom(key));
                }
                seen.insert(key);
                map.next_value_seed(Unique)?;
            }
            Ok(())
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
            while list.next_element_seed(Unique)?.is_some() {}
            Ok(())
        }

        fn visit_bool<E>(self, _: bool) -> Result<(), E> {
            Ok(())
        }

        fn visit_i64<E>(self, _: i64) -> Result<(), E> {
            Ok(())
        }

        fn visit_u64<E>(self, _: u64) -> Result<(), E> {
            Ok(())
        }

        fn visit_f64<E>(self, _: f64) -> Result<(), E> {
            Ok(())
        }

        fn visit_str<E>(self, _: &str) -> Result<(), E> {
            Ok(())
        }

        fn visit_unit<E>(self) -> Result<(), E> {
            Ok(())
        }
    }

    let mut deserializer = serde_json::Deserializer::from_slice(bytes);
    let error = Unique.deserialize(&mut deserializer).err()?;
    // The message is the key, with the place behind it.
    let text = error.to_string();
    Some(match text.rsplit_once(" at line ") {
        Some((key, _)) => key.to_string(),
        None => text,
    })
}
