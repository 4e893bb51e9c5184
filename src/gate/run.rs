//! The decisions of all pairs: recordings side by side, one thread each.

use super::key::Key;
use super::plan::{Plan, PlannedRecording};
use super::question::Questions;
use super::store::{DesignKey, Known, ReadFacts, Store};
use crate::pipeline::{Control, DecisionRow, Limits, Prepared};
use latchgate_document::blocks::RecordingBlock;
use latchgate_kernel::error::Error as KernelError;
use latchgate_recording::error::{Error, ErrorKind, Place};
use std::time::Duration;

/// Tells the time since some instant.
pub type Clock<'a> = &'a (dyn Fn() -> Duration + Sync);

/// What became of one recording.
#[derive(Debug, Clone, Default)]
pub struct JudgedRecording {
    /// SHA-256 of the file, where it was read.
    pub sha256: Option<String>,
    /// The channel that was judged.
    pub channel: Option<String>,
    /// The row of each design, in the plan's order.
    pub rows: Vec<DecisionRow>,
    /// How many of them come from the store.
    pub cached: usize,
    /// The time that each decision took, its part of the reading included; none where they were made elsewhere.
    pub times: Vec<Duration>,
    /// Why nothing could be read, where another try may do: nothing of it is kept.
    pub unread: Option<Error>,
}

/// Judges every recording of a plan with every design, each recording opened once.
///
/// What was judged before is read from the store; what is judged now is kept there as soon as it is
/// known, so that a run that is stopped loses little.
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
    let known = store.known(keys.iter().copied(), None)?;
    plan.check_agreement(keys.iter().copied().enumerate(), &known)?;
    let judging = Judging::new(plan, limits, store, clock);
    let numbers: Vec<usize> = (0..keys.len()).collect();
    let recordings = control.try_map(&numbers, |&number| {
        // How far one recording is says nothing of the whole.
        control.unmeasured(|control| {
            judging.recording(number, keys[number], &known, &control.with_threads(1))
        })
    });
    store.sync()?;
    Ok(GateRun {
        recordings: recordings?,
        damages: known.damages,
    })
}

/// What became of a gate's recordings, in the plan's order.
#[derive(Debug)]
pub struct GateRun {
    /// Each of them.
    pub recordings: Vec<JudgedRecording>,
    /// What is damaged in the store, one sentence each.
    pub damages: Vec<String>,
}

/// What recordings are judged with.
pub(super) struct Judging<'a> {
    plan: &'a Plan,
    limits: &'a Limits,
    store: &'a Store,
    clock: Clock<'a>,
    designs: Vec<DesignKey>,
}

impl<'a> Judging<'a> {
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

    /// Returns what is known of each pair of a recording that is not read.
    pub(super) fn known_rows<'k>(
        &self,
        key: Key,
        known: &'k Known,
    ) -> Vec<Option<&'k DecisionRow>> {
        let designs = self.designs.iter();
        designs.map(|design| known.row(key, design)).collect()
    }

    /// Judges the pairs of a recording that are not known, and keeps them.
    ///
    /// # Errors
    ///
    /// As [`run`].
    pub(super) fn recording(
        &self,
        number: usize,
        key: Key,
        known: &Known,
        control: &Control<'_>,
    ) -> Result<JudgedRecording, Error> {
        let recording = &self.plan.recordings[number];
        let began = (self.clock)();
        let source = recording.source();
        let prepared = Prepared::open(&source, &recording.request, self.limits, control);
        // Between the two keys it was read.
        if Questions::new(self.limits).key(recording) != key {
            return Err(changed(recording, "while it was read"));
        }
        let (read, unread) = match &prepared {
            Ok(prepared) => (prepared.recording(), None),
            Err(refused) if refused.error.is_stopped() => {
                return Err(KernelError::Stopped.into());
            }
            Err(refused) => {
                let may_pass = matches!(refused.error.kind(), ErrorKind::Io { .. });
                let why = may_pass.then(|| refused.error.clone());
                (refused.recording(), why)
            }
        };
        let read = facts(read);
        if unread.is_none() && known.facts(key) != Some(&read) {
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
            let pair = (key, design_key.key);
            // What was read decides, not the key by which it is found.
            let id = match &prepared {
                Ok(prepared) => prepared.report_id(design),
                Err(refused) => refused.row(design).report_id,
            };
            let kept = known.row_of(pair.0, pair.1, &id);
            let row = match (&prepared, kept) {
                (Err(refused), _) => refused.row(design),
                (Ok(_), Some(kept)) => kept.clone(),
                (Ok(prepared), None) => prepared.row(design, control)?,
            };
            let now = (self.clock)();
            if kept.is_some() {
                judged.cached += 1;
            } else if judged.unread.is_none() {
                self.store.put(pair, &row, now)?;
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

pub(super) fn changed(recording: &PlannedRecording, when: &str) -> Error {
    let found = format!("another one, or another card: its hash changed {when}");
    let hint = "run or submit the gate again when no program writes there";
    Error::malformed("the recording as it was", &found, hint)
        .at(Place::file(recording.name.clone()))
}

impl Plan {
    /// Refuses a store that holds two decisions of a pair which contradict each other; `recordings` are numbers of
    /// recordings with their keys.
    pub(super) fn check_agreement(
        &self,
        recordings: impl Iterator<Item = (usize, Key)> + Clone,
        known: &Known,
    ) -> Result<(), Error> {
        let designs = self.design_keys();
        for (recording, design, file) in &known.contradictions {
            let recording = recordings.clone().find(|(_, key)| key == recording);
            let design = designs.iter().position(|own| own.key == *design);
            let (Some((recording, _)), Some(design)) = (recording, design) else {
                continue;
            };
            let (recording, design) = (&self.recordings[recording], &self.designs[design]);
            let error = Error::malformed(
                format!("one decision of {} with {}", recording.name, design.name),
                "two that differ: a file changed unnoticed, or a machine is faulty",
                "keep this store as evidence, and judge into another one",
            );
            return Err(error.at(Place::file(file.as_str())));
        }
        Ok(())
    }
}
