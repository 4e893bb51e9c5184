//! The decisions of all pairs: recordings side by side, one thread each.

use super::plan::{Plan, PlannedRecording};
use super::store::{RowAddress, Store};
use crate::pipeline::{Control, DecisionRow, Design, Limits, Prepared, Source};
use latchgate_recording::error::Error;
use std::time::Duration;

/// Rows of a recording that are kept together: what a kill costs, and what is read again for one.
const KEPT_TOGETHER: usize = 64;

/// Tells the time since some instant.
pub type Clock<'a> = &'a (dyn Fn() -> Duration + Sync);

/// What became of one recording.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct JudgedRecording {
    /// SHA-256 of the file, where it was read.
    pub sha256: Option<String>,
    /// The channel that was judged.
    pub channel: Option<String>,
    /// Where the row of each design lies, in the plan's order.
    pub rows: Vec<RowAddress>,
    /// How many of them come from the store.
    pub cached: usize,
    /// The time that each decision took, its part of the reading included; none where they were made elsewhere.
    pub times: Vec<Duration>,
}

/// Judges every recording of a plan with every design, each recording opened once.
///
/// What was judged before lies in `store`; what is judged now is put there as soon as it is known, so
/// that a run that is stopped loses little. `clock` tells the time since some instant.
///
/// # Errors
///
/// [`Stopped`](latchgate_kernel::error::Error::Stopped) if `control` ends the work, [`ErrorKind::Io`] if the store cannot be
/// written. A recording that cannot be read is no error: its rows say so.
pub fn run(
    plan: &Plan,
    limits: &Limits,
    store: &Store,
    clock: Clock<'_>,
    control: &Control<'_>,
) -> Result<Vec<JudgedRecording>, Error> {
    control.try_map(&plan.recordings, |recording| {
        // How far one recording is says nothing of the whole.
        control.unmeasured(|control| {
            let control = control.with_threads(1);
            judged(recording, &plan.designs, limits, store, clock, &control)
        })
    })
}

fn judged(
    recording: &PlannedRecording,
    designs: &[Design],
    limits: &Limits,
    store: &Store,
    clock: Clock<'_>,
    control: &Control<'_>,
) -> Result<JudgedRecording, Error> {
    let began = clock();
    let source = Source::File(recording.path.clone());
    let prepared = match Prepared::open(&source, &recording.request, limits, control) {
        Ok(prepared) => prepared,
        Err(refused) if refused.error.is_stopped() => return Err(refused.error),
        // It takes no time to find out again, and may be mended until then.
        Err(refused) => {
            let mut rows = Vec::with_capacity(designs.len());
            for some in designs.chunks(KEPT_TOGETHER) {
                let refusals: Vec<DecisionRow> =
                    some.iter().map(|design| refused.row(design)).collect();
                rows.extend(store.put_aside(&refusals)?);
            }
            return Ok(JudgedRecording {
                sha256: refused.recording().sha256.clone(),
                channel: None,
                rows,
                cached: 0,
                times: Vec::new(),
            });
        }
    };
    let mut judged = JudgedRecording {
        sha256: prepared.recording().sha256.clone(),
        channel: prepared.recording().channel.clone(),
        rows: Vec::with_capacity(designs.len()),
        cached: 0,
        times: Vec::with_capacity(designs.len()),
    };
    let reading = clock().saturating_sub(began) / u32::try_from(designs.len()).unwrap_or(u32::MAX);
    for some in designs.chunks(KEPT_TOGETHER) {
        let known: Vec<Option<RowAddress>> = some
            .iter()
            .map(|design| store.find(&prepared.report_id(design)))
            .collect();
        let mut fresh = Vec::new();
        let judging: Result<(), Error> = some.iter().zip(&known).try_for_each(|(design, known)| {
            let began = clock();
            if known.is_none() {
                fresh.push(prepared.row(design, control)?);
            }
            judged.times.push(reading + clock().saturating_sub(began));
            Ok(())
        });
        // What is done is kept, also where the rest is stopped.
        let mut put = store.put(&fresh)?.into_iter();
        judging?;
        judged.cached += some.len() - fresh.len();
        let all = known
            .into_iter()
            .filter_map(|known| known.or_else(|| put.next()));
        judged.rows.extend(all);
    }
    Ok(judged)
}
