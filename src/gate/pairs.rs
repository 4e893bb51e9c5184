//! The pairs of a gate: what is asked of all of them stands in memory, the rest is read when it is
//! wanted.

use super::store::{RowAddress, Store};
use crate::error::Error;
use crate::pipeline::{Answer, Row};
use serde::ser::{Error as _, SerializeSeq};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::cmp::Reverse;
use std::sync::Arc;

/// Exit code of a gate of which something could not be done, or in which nothing was judged.
pub const COULD_NOT: u8 = 4;

/// Where a pair stands with what is required of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PairStanding {
    /// It answers as required.
    AsRequired,
    /// It is undecided, and an exception lets it through.
    Allowed,
    /// It is not as required, but was not in the baseline either and is no worse.
    NoWorse,
    /// It is not as required.
    NotAsRequired,
}

/// One recording with one design.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Pair {
    /// Name of the recording.
    pub recording: String,
    /// Name of the design.
    pub design: String,
    /// What is required.
    pub required: Answer,
    /// Where it stands.
    pub standing: PairStanding,
    /// Reason and last day of the exception that lets it through.
    pub exception: Option<(String, String)>,
    /// The decision.
    pub row: Row,
}

impl Pair {
    /// Returns the exit code that the pair alone would give: 0 where it stands.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        PairMark::of(self, None).exit_code()
    }
}

/// Pairs in the order of recordings, and of designs for each.
#[derive(Debug, Clone, Default)]
pub struct Pairs {
    marks: Vec<PairMark>,
    source: RowSource,
}

/// Where the rows of the pairs are.
#[derive(Debug, Clone)]
enum RowSource {
    /// Here, with their pairs, as a document was read.
    Here(Vec<Pair>),
    /// In a store.
    Stored(Arc<StoredRows>),
}

impl Default for RowSource {
    fn default() -> Self {
        Self::Here(Vec::new())
    }
}

#[derive(Debug)]
struct StoredRows {
    store: Arc<Store>,
    recordings: Vec<String>,
    designs: Vec<String>,
    /// Reason and last day of each exception.
    exceptions: Vec<(String, String)>,
    addresses: Vec<RowAddress>,
}

/// What of a pair orders and counts it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairMark {
    /// Its answer.
    pub verdict: Answer,
    /// What is required.
    pub required: Answer,
    /// Where it stands.
    pub standing: PairStanding,
    /// Number of the exception that lets it through.
    pub(super) exception: Option<u16>,
    /// Its margin in millionths of the threshold; of a pass where a fail was required the largest
    /// is the worst, and stands with its sign turned.
    ordered: i64,
}

// docs/gate.md says what a pair leaves in memory: this, and the address of its row.
const _: () = assert!(size_of::<PairMark>() + size_of::<RowAddress>() == 24);

impl PairMark {
    pub(super) fn of(pair: &Pair, exception: Option<u16>) -> Self {
        let sign = if pair.required == Answer::Fail {
            -1.0
        } else {
            1.0
        };
        let margin = pair.row.margin().map_or(f64::MIN, |margin| sign * margin);
        Self {
            verdict: pair.row.verdict,
            required: pair.required,
            standing: pair.standing,
            exception,
            ordered: (margin.clamp(-1e9, 1e9) * 1e6) as i64,
        }
    }

    /// Returns the exit code that the pair alone would give: 0 where it stands.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match (self.standing, self.verdict) {
            (PairStanding::NotAsRequired, Answer::Unusable) => COULD_NOT,
            (PairStanding::NotAsRequired, Answer::Undecided) => Answer::Undecided.exit_code(),
            // A pass where a fail was required is a failure of the gate.
            (PairStanding::NotAsRequired, _) => Answer::Fail.exit_code(),
            _ => 0,
        }
    }
}

/// Orders exit codes as contracts have it: 4 is worse than 1, 1 than 3, 3 than 0.
pub(super) fn severity(code: u8) -> u8 {
    match code {
        0 => 0,
        3 => 1,
        1 => 2,
        _ => 3,
    }
}

impl Pairs {
    /// Returns pairs whose rows are at hand.
    #[must_use]
    pub fn of(pairs: Vec<Pair>) -> Self {
        Self {
            marks: pairs.iter().map(|pair| PairMark::of(pair, None)).collect(),
            source: RowSource::Here(pairs),
        }
    }

    /// Reads the rows of each recording once, in order, and calls `held` for each pair; it says what
    /// is required, where the pair stands, and which exception lets it through.
    pub(super) fn stored(
        store: Arc<Store>,
        recordings: Vec<String>,
        designs: Vec<String>,
        exceptions: Vec<(String, String)>,
        rows: Vec<Vec<RowAddress>>,
        mut held: impl FnMut(&mut Pair) -> Option<u16>,
    ) -> Result<Self, Error> {
        let mut marks = Vec::with_capacity(recordings.len() * designs.len());
        let mut addresses = Vec::with_capacity(marks.capacity());
        for (recording, own) in recordings.iter().zip(rows) {
            let rows = store.rows(&own)?;
            for (design, row) in designs.iter().zip(rows) {
                let mut pair = Pair {
                    recording: recording.clone(),
                    design: design.clone(),
                    required: Answer::Pass,
                    standing: PairStanding::NotAsRequired,
                    exception: None,
                    row,
                };
                let exception = held(&mut pair);
                marks.push(PairMark::of(&pair, exception));
            }
            addresses.extend(own);
        }
        Ok(Self {
            marks,
            source: RowSource::Stored(Arc::new(StoredRows {
                store,
                recordings,
                designs,
                exceptions,
                addresses,
            })),
        })
    }

    /// Returns what orders and counts each pair.
    #[must_use]
    pub fn marks(&self) -> &[PairMark] {
        &self.marks
    }

    /// Returns how many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.marks.len()
    }

    /// Tells whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.marks.is_empty()
    }

    /// Returns the numbers of those that are not as required, the worst first: by exit code, by
    /// margin, by name.
    #[must_use]
    pub fn worst(&self) -> Vec<usize> {
        let mut found: Vec<usize> = (0..self.len())
            .filter(|&index| self.marks[index].exit_code() != 0)
            .collect();
        found.sort_by_key(|&index| self.rank(index));
        found
    }

    /// Returns the numbers of those that stand so.
    #[must_use]
    pub fn standing(&self, standing: PairStanding) -> Vec<usize> {
        let of = |index: &usize| self.marks[*index].standing == standing;
        (0..self.len()).filter(of).collect()
    }

    /// Orders pairs, the worst first. Their numbers follow the order of their names.
    #[must_use]
    pub fn rank(&self, index: usize) -> (Reverse<u8>, i64, usize) {
        let mark = &self.marks[index];
        (Reverse(severity(mark.exit_code())), mark.ordered, index)
    }

    /// Returns the pair of that number.
    ///
    /// # Errors
    ///
    /// [`crate::error::ErrorKind::Io`] if its row can no longer be read.
    pub fn get(&self, index: usize) -> Result<Pair, Error> {
        let mut found = self.some(index..index + 1)?;
        Ok(found.remove(0))
    }

    /// Returns neighbouring pairs, such as those of one recording.
    ///
    /// # Errors
    ///
    /// As [`Self::get`].
    pub fn some(&self, numbers: std::ops::Range<usize>) -> Result<Vec<Pair>, Error> {
        let stored = match &self.source {
            RowSource::Here(pairs) => return Ok(pairs[numbers].to_vec()),
            RowSource::Stored(stored) => stored,
        };
        let rows = stored.store.rows(&stored.addresses[numbers.clone()])?;
        let pairs = numbers.zip(rows).map(|(number, row)| {
            let mark = &self.marks[number];
            let designs = stored.designs.len();
            Pair {
                recording: stored.recordings[number / designs].clone(),
                design: stored.designs[number % designs].clone(),
                required: mark.required,
                standing: mark.standing,
                exception: mark
                    .exception
                    .map(|number| stored.exceptions[usize::from(number)].clone()),
                row,
            }
        });
        Ok(pairs.collect())
    }

    /// Calls `of` for each pair in order; few of them are in memory at a time.
    ///
    /// # Errors
    ///
    /// As [`Self::get`], and those of `of`.
    pub fn each<E: From<Error>>(
        &self,
        mut of: impl FnMut(&Pair) -> Result<(), E>,
    ) -> Result<(), E> {
        // Those of one recording lie together.
        let at_once = match &self.source {
            RowSource::Here(_) => 1,
            RowSource::Stored(stored) => stored.designs.len().clamp(1, 1024),
        };
        for first in (0..self.len()).step_by(at_once) {
            let pairs = self.some(first..self.len().min(first + at_once))?;
            pairs.iter().try_for_each(&mut of)?;
        }
        Ok(())
    }
}

/// Why a list of pairs was not written.
enum Unwritten<E> {
    Unread(Error),
    Refused(E),
}

impl<E> From<Error> for Unwritten<E> {
    fn from(error: Error) -> Self {
        Self::Unread(error)
    }
}

impl Serialize for Pairs {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut list = serializer.serialize_seq(Some(self.len()))?;
        let written = self.each(|pair| list.serialize_element(pair).map_err(Unwritten::Refused));
        written.map_err(|error| match error {
            Unwritten::Unread(error) => S::Error::custom(error),
            Unwritten::Refused(error) => error,
        })?;
        list.end()
    }
}

impl<'de> Deserialize<'de> for Pairs {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Self::of(Vec::deserialize(deserializer)?))
    }
}
