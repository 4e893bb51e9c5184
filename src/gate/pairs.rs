//! The pairs of a gate: what is asked of all of them stands in memory, the rest is read when it is
//! wanted.

use super::store::{RowAddress, Store};
use crate::pipeline::{Answer, DecisionRow};
use latchgate_recording::error::Error;
use serde::ser::{Error as _, SerializeSeq};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::cmp::Reverse;
use std::collections::BTreeSet;
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
    pub row: DecisionRow,
}

impl Pair {
    /// Returns the exit code that the pair alone would give: 0 where it stands.
    pub fn exit_code(&self) -> u8 {
        PairMark::of(self, None).exit_code()
    }
}

/// Pairs in the order of recordings, and of designs for each.
#[derive(Debug, Clone, Default)]
pub struct Pairs {
    marks: Vec<PairMark>,
    /// The place of each among all pairs, where only some are kept.
    numbers: Option<Vec<usize>>,
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
    names: PairNames,
    addresses: Vec<RowAddress>,
}

/// Names that pairs are put together from.
#[derive(Debug)]
pub(super) struct PairNames {
    pub(super) recordings: Vec<String>,
    pub(super) designs: Vec<String>,
    /// Reason and last day of each exception.
    pub(super) exceptions: Vec<(String, String)>,
}

/// The rows of a recording with where they lie, a row for each design.
pub(super) type PlacedRows = Vec<(RowAddress, DecisionRow)>;

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
    pub fn exit_code(&self) -> u8 {
        match (self.standing, self.verdict) {
            (PairStanding::NotAsRequired, Answer::Unusable) => COULD_NOT,
            (PairStanding::NotAsRequired, Answer::Undecided) => Answer::Undecided.exit_code(),
            // A pass where a fail was required is a failure of the gate.
            (PairStanding::NotAsRequired, _) => Answer::Fail.exit_code(),
            _ => 0,
        }
    }

    fn rank(&self, number: usize) -> (Reverse<u8>, i64, usize) {
        (Reverse(severity(self.exit_code())), self.ordered, number)
    }
}

/// Most pairs of which all are kept; of more those that an output names.
pub(super) const WHOLE_MAX: usize = 100_000;

/// Most pairs of each kind that are kept of more: what the longest output lists.
const NAMED_MAX: usize = 5000;

/// A pair that is kept.
#[derive(Debug, Clone, Copy)]
struct KeptPair {
    number: usize,
    mark: PairMark,
    address: RowAddress,
}

impl KeptPair {
    fn rank(&self) -> (Reverse<u8>, i64, usize) {
        self.mark.rank(self.number)
    }
}

/// The pairs that are kept: all, or the worst, those let through, and the worst of each recording
/// and design.
struct KeptPairs {
    whole: bool,
    designs: usize,
    all: Vec<KeptPair>,
    through: Vec<KeptPair>,
    exceptions: BTreeSet<u16>,
    of_recordings: Vec<KeptPair>,
    of_designs: Vec<Option<KeptPair>>,
}

impl KeptPairs {
    fn new(pairs: usize, designs: usize, whole: bool) -> Self {
        Self {
            whole,
            designs,
            all: Vec::with_capacity(if whole { pairs } else { 2 * NAMED_MAX }),
            through: Vec::new(),
            exceptions: BTreeSet::new(),
            of_recordings: Vec::new(),
            of_designs: vec![None; designs],
        }
    }

    fn take(&mut self, pair: KeptPair) {
        if self.whole {
            self.all.push(pair);
            return;
        }
        match self.of_recordings.last_mut() {
            Some(held) if held.number / self.designs == pair.number / self.designs => {
                if pair.rank() < held.rank() {
                    *held = pair;
                }
            }
            _ => self.of_recordings.push(pair),
        }
        let held = self.of_designs[pair.number % self.designs].get_or_insert(pair);
        if pair.rank() < held.rank() {
            *held = pair;
        }
        if pair.mark.exit_code() != 0 {
            self.all.push(pair);
            if self.all.len() == 2 * NAMED_MAX {
                self.all
                    .select_nth_unstable_by_key(NAMED_MAX, KeptPair::rank);
                self.all.truncate(NAMED_MAX);
            }
        } else if pair.mark.standing != PairStanding::AsRequired {
            // No exception is left out, whatever others let through.
            let is_first = pair
                .mark
                .exception
                .is_some_and(|own| self.exceptions.insert(own));
            if is_first || self.through.len() < NAMED_MAX {
                self.through.push(pair);
            }
        }
    }

    fn in_order(mut self) -> Vec<KeptPair> {
        if !self.whole {
            self.all.sort_unstable_by_key(KeptPair::rank);
            self.all.truncate(NAMED_MAX);
            self.all.extend(self.through);
            self.all.extend(self.of_recordings);
            self.all.extend(self.of_designs.into_iter().flatten());
            self.all.sort_unstable_by_key(|pair| pair.number);
            self.all.dedup_by_key(|pair| pair.number);
        }
        self.all
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
    pub fn of(pairs: Vec<Pair>) -> Self {
        Self {
            marks: pairs.iter().map(|pair| PairMark::of(pair, None)).collect(),
            numbers: None,
            source: RowSource::Here(pairs),
        }
    }

    /// Reads the rows of each recording once, in order, and calls `held` for each pair; it says what
    /// is required, where the pair stands, and which exception lets it through. Of more than `most`
    /// pairs those are kept that an output names.
    pub(super) fn stored(
        store: Arc<Store>,
        names: PairNames,
        most: usize,
        mut rows: impl FnMut(usize) -> Result<PlacedRows, Error>,
        mut held: impl FnMut(&mut Pair) -> Option<u16>,
    ) -> Result<Self, Error> {
        let designs = names.designs.len();
        let all = names.recordings.len() * designs;
        let mut kept = KeptPairs::new(all, designs, all <= most);
        for (number, recording) in names.recordings.iter().enumerate() {
            let rows = rows(number)?;
            for (place, (address, row)) in rows.into_iter().enumerate() {
                let mut pair = Pair {
                    recording: recording.clone(),
                    design: names.designs[place].clone(),
                    required: Answer::Pass,
                    standing: PairStanding::NotAsRequired,
                    exception: None,
                    row,
                };
                let exception = held(&mut pair);
                kept.take(KeptPair {
                    number: number * designs + place,
                    mark: PairMark::of(&pair, exception),
                    address,
                });
            }
        }
        let whole = kept.whole;
        let kept = kept.in_order();
        Ok(Self {
            marks: kept.iter().map(|pair| pair.mark).collect(),
            numbers: (!whole).then(|| kept.iter().map(|pair| pair.number).collect()),
            source: RowSource::Stored(Arc::new(StoredRows {
                store,
                names,
                addresses: kept.iter().map(|pair| pair.address).collect(),
            })),
        })
    }

    /// Tells whether every pair is here, not only those that an output names.
    pub fn is_whole(&self) -> bool {
        self.numbers.is_none()
    }

    /// Returns the place of a pair among all pairs.
    pub fn place(&self, index: usize) -> usize {
        self.numbers
            .as_ref()
            .map_or(index, |numbers| numbers[index])
    }

    /// Returns what orders and counts each pair.
    pub fn marks(&self) -> &[PairMark] {
        &self.marks
    }

    /// Returns how many there are.
    pub fn len(&self) -> usize {
        self.marks.len()
    }

    /// Tells whether there is none.
    pub fn is_empty(&self) -> bool {
        self.marks.is_empty()
    }

    /// Returns the numbers of those that are not as required, the worst first: by exit code, by
    /// margin, by name.
    pub fn worst(&self) -> Vec<usize> {
        let mut found: Vec<usize> = (0..self.len())
            .filter(|&index| self.marks[index].exit_code() != 0)
            .collect();
        found.sort_by_key(|&index| self.rank(index));
        found
    }

    /// Returns the numbers of those that stand so.
    pub fn standing(&self, standing: PairStanding) -> Vec<usize> {
        let of = |index: &usize| self.marks[*index].standing == standing;
        (0..self.len()).filter(of).collect()
    }

    /// Returns how many of those that stand so have an answer.
    pub(super) fn counted(&self, standing: PairStanding, verdict: Answer) -> usize {
        let of = |mark: &&PairMark| mark.standing == standing && mark.verdict == verdict;
        self.marks.iter().filter(of).count()
    }

    /// Orders pairs, the worst first. Their numbers follow the order of their names.
    pub fn rank(&self, index: usize) -> (Reverse<u8>, i64, usize) {
        self.marks[index].rank(index)
    }

    /// Returns the pair of that number.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if its row can no longer be read.
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
        let names = &stored.names;
        let pairs = numbers.zip(rows).map(|(index, row)| {
            let (mark, number) = (&self.marks[index], self.place(index));
            let designs = names.designs.len();
            Pair {
                recording: names.recordings[number / designs].clone(),
                design: names.designs[number % designs].clone(),
                required: mark.required,
                standing: mark.standing,
                exception: mark
                    .exception
                    .map(|number| names.exceptions[usize::from(number)].clone()),
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
            RowSource::Stored(stored) => stored.names.designs.len().clamp(1, 1024),
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
