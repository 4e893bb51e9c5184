//! The decisions of all pairs: recordings side by side, one thread each.

use super::key::Key;
use super::plan::{Plan, PlannedRecording};
use super::question::Questions;
use super::store::{DesignKey, ReadFacts, Store, StoredDecisions};
use crate::pipeline::{Control, DecisionRow, Limits, Prepared};
use latchgate_document::blocks::RecordingBlock;
use latchgate_kernel::error::Error as KernelError;
use latchgate_recording::error::{Error, ErrorKind, Place};
use std::time::Duration;

/// Returns the time since some fixed instant. The library reads no clock itself.
pub type Clock<'a> = &'a (dyn Fn() -> Duration + Sync);

/// Decisions of one recording.
#[derive(Debug, Clone, Default)]
pub struct JudgedRecording {
    /// SHA-256 of the file, where it was read.
    pub sha256: Option<String>,
    /// The channel that was judged.
    pub channel: Option<String>,
    /// The row of each design, in the plan's order.
    pub rows: Vec<DecisionRow>,
    /// Number of rows that come from the store.
    pub cached: usize,
    /// Time of each decision, its part of the reading included; empty where another run made them.
    pub times: Vec<Duration>,
    /// Error of reading that another try may not have; such rows are not kept.
    pub unread: Option<Error>,
}

/// Judges every recording of a plan with every design, each recording opened once.
///
/// Decisions of earlier runs are read from the store. Each new decision is kept there at once, so
/// that a stopped run loses little.
///
/// # Errors
///
/// [`Stopped`](latchgate_kernel::error::Error::Stopped) if `control` ends the work, [`ErrorKind::Io`] if the store cannot be read
/// or written, [`ErrorKind::Malformed`] if it holds decisions that contradict each other, or if a recording changes while
/// it is read. A recording that cannot be read is no error: its rows say so.
pub fn run(
    plan: &Plan,
    limits: &Limits,
    store: &Store,
    clock: Clock<'_>,
    control: &Control<'_>,
) -> Result<GateRun, Error> {
    let keys = plan.recording_keys(limits, control)?;
    let stored = store.decisions(keys.iter().copied(), None)?;
    plan.check_agreement(keys.iter().copied().enumerate(), &stored)?;
    let judge = GateJudge::new(plan, limits, store, clock);
    let numbers: Vec<usize> = (0..keys.len()).collect();
    let recordings = control.try_map(&numbers, |&number| {
        // The progress shown counts recordings; that within one of them would disturb it.
        control.unmeasured(|control| {
            judge.recording(number, keys[number], &stored, &control.with_threads(1))
        })
    });
    // Before the recordings are looked at: a stopped run, too, keeps what it judged.
    store.sync()?;
    Ok(GateRun {
        recordings: recordings?,
        damages: stored.damages,
    })
}

/// Decisions of a whole gate.
#[derive(Debug)]
pub struct GateRun {
    /// Recordings in the plan's order.
    pub recordings: Vec<JudgedRecording>,
    /// Damage to the store, one sentence each.
    pub damages: Vec<String>,
}

/// Judge of a gate's recordings, shared by its threads.
pub(super) struct GateJudge<'a> {
    plan: &'a Plan,
    limits: &'a Limits,
    store: &'a Store,
    clock: Clock<'a>,
    designs: Vec<DesignKey>,
}

impl<'a> GateJudge<'a> {
    pub(super) fn new(
        plan: &'a Plan,
        limits: &'a Limits,
        store: &'a Store,
        clock: Clock<'a>,
    ) -> Self {
        Self {
            plan,
            limits,
            store,
            clock,
            designs: plan.design_keys(),
        }
    }

    /// Returns the stored decision of each pair of a recording, which is not read for it.
    pub(super) fn stored_rows<'k>(
        &self,
        key: Key,
        stored: &'k StoredDecisions,
    ) -> Vec<Option<&'k DecisionRow>> {
        let designs = self.designs.iter();
        designs.map(|design| stored.row(key, design)).collect()
    }

    /// Judges the pairs of a recording that are not stored, and keeps them.
    ///
    /// # Errors
    ///
    /// As [`run`].
    pub(super) fn recording(
        &self,
        number: usize,
        key: Key,
        stored: &StoredDecisions,
        control: &Control<'_>,
    ) -> Result<JudgedRecording, Error> {
        let recording = &self.plan.recordings[number];
        let began = (self.clock)();
        let source = recording.source();
        let prepared = Prepared::open(&source, &recording.request, self.limits, control);
        // The key was taken before the reading and is taken again after it: if both are equal, no
        // other program wrote in between.
        if Questions::new(self.limits).key(recording) != key {
            return Err(changed(recording));
        }
        let (read, unread) = match &prepared {
            Ok(prepared) => (prepared.recording(), None),
            Err(refused) if refused.error.is_stopped() => {
                return Err(KernelError::Stopped.into());
            }
            Err(refused) => {
                // A failing disk or network may recover; any other refusal is an answer.
                let is_transient = matches!(refused.error.kind(), ErrorKind::Io { .. });
                let unread = is_transient.then(|| refused.error.clone());
                (refused.recording(), unread)
            }
        };
        let read = facts(read);
        if unread.is_none() && stored.facts(key) != Some(&read) {
            self.store.put_read(key, &read)?;
        }
        let designs = self.designs.len();
        let mut judged = JudgedRecording {
            sha256: read.sha256,
            channel: read.channel,
            rows: Vec::with_capacity(designs),
            cached: 0,
            times: Vec::with_capacity(designs),
            unread,
        };
        let mut before = (self.clock)();
        let reading = before.saturating_sub(began) / u32::try_from(designs).unwrap_or(u32::MAX);
        for (design, design_key) in self.plan.designs.iter().zip(&self.designs) {
            // The content as read decides: the `report_id`, not the key by which a row is found.
            let id = match &prepared {
                Ok(prepared) => prepared.report_id(design),
                Err(refused) => refused.row(design).report_id,
            };
            let kept = stored.row_of(key, design_key.key, &id);
            let row = match (&prepared, kept) {
                (Err(refused), _) => refused.row(design),
                (Ok(_), Some(kept)) => kept.clone(),
                (Ok(prepared), None) => prepared.row(design, control)?,
            };
            let now = (self.clock)();
            if kept.is_some() {
                judged.cached += 1;
            } else if judged.unread.is_none() {
                self.store.put(key, design_key.key, &row, now)?;
                tracing::debug!(recording = %recording.name, design = %design.name, "judged");
            }
            judged.rows.push(row);
            judged.times.push(reading + now.saturating_sub(before));
            before = now;
        }
        Ok(judged)
    }
}

fn facts(read: &RecordingBlock) -> ReadFacts {
    ReadFacts {
        sha256: read.sha256.clone(),
        channel: read.channel.clone(),
    }
}

/// Returns the error for a recording that changed while it was read.
fn changed(recording: &PlannedRecording) -> Error {
    let found = "another one, or another card: its hash changed while it was read";
    let hint = "run the gate again when no program writes there";
    Error::malformed("the recording as it was", found, hint).at(Place::file(recording.name.clone()))
}

impl Plan {
    /// Refuses a store with two decisions of a pair that contradict each other; `recordings` are
    /// numbers of recordings with their keys.
    pub(super) fn check_agreement(
        &self,
        recordings: impl Iterator<Item = (usize, Key)> + Clone,
        stored: &StoredDecisions,
    ) -> Result<(), Error> {
        let designs = self.design_keys();
        for contradiction in &stored.contradictions {
            let recording = recordings
                .clone()
                .find(|(_, key)| *key == contradiction.recording);
            let design = designs
                .iter()
                .position(|design| design.key == contradiction.design);
            let (Some((recording, _)), Some(design)) = (recording, design) else {
                continue;
            };
            let (recording, design) = (&self.recordings[recording], &self.designs[design]);
            let error = Error::malformed(
                format!("one decision of {} with {}", recording.name, design.name),
                "two that differ: a file changed unnoticed, or a machine is faulty",
                "keep this store as evidence, and judge into another one",
            );
            return Err(error.at(Place::file(contradiction.file.as_str())));
        }
        Ok(())
    }
}
