//! The decisions of all pairs: recordings side by side, one thread each.

use super::plan::{Plan, PlannedRecording};
use super::store::Store;
use crate::error::{Error, ErrorKind};
use crate::pipeline::{Control, Design, Limits, Prepared, Row, Source};

/// Rows of a recording that are kept together, so that a kill costs no more than their work.
const KEPT_TOGETHER: usize = 256;

/// What became of one recording.
#[derive(Debug, Clone, PartialEq)]
pub struct JudgedRecording {
    /// SHA-256 of the file, where it was read.
    pub sha256: Option<String>,
    /// The channel that was judged.
    pub channel: Option<String>,
    /// One row per design, in the plan's order.
    pub rows: Vec<Row>,
    /// How many of them come from the store.
    pub cached: usize,
}

/// Judges every recording of a plan with every design, each recording opened once.
///
/// What was judged before is taken from `store`; what is judged now is kept there as soon as it is
/// known, so that a run that is stopped loses little.
///
/// # Errors
///
/// [`ErrorKind::Stopped`] if `control` ends the work, [`ErrorKind::Io`] if the store cannot be
/// written. A recording that cannot be read is no error: its rows say so.
pub fn run(
    plan: &Plan,
    limits: &Limits,
    store: Option<&Store>,
    control: &Control<'_>,
) -> Result<Vec<JudgedRecording>, Error> {
    control.try_map(&plan.recordings, |recording| {
        // How far one recording is says nothing of the whole.
        control.unmeasured(|control| {
            let control = control.with_threads(1);
            judged(recording, &plan.designs, limits, store, &control)
        })
    })
}

fn judged(
    recording: &PlannedRecording,
    designs: &[Design],
    limits: &Limits,
    store: Option<&Store>,
    control: &Control<'_>,
) -> Result<JudgedRecording, Error> {
    let source = Source::File(recording.path.clone());
    let prepared = match Prepared::open(&source, &recording.request, limits, control) {
        Ok(prepared) => prepared,
        Err(refused) if *refused.error.kind() == ErrorKind::Stopped => return Err(refused.error),
        // It takes no time to find out again, and may be mended until then.
        Err(refused) => {
            return Ok(JudgedRecording {
                sha256: refused.recording().sha256.clone(),
                channel: None,
                rows: designs.iter().map(|design| refused.row(design)).collect(),
                cached: 0,
            });
        }
    };
    let mut judged = JudgedRecording {
        sha256: prepared.recording().sha256.clone(),
        channel: prepared.recording().channel.clone(),
        rows: Vec::with_capacity(designs.len()),
        cached: 0,
    };
    for some in designs.chunks(KEPT_TOGETHER) {
        let mut fresh = Vec::new();
        let first = judged.rows.len();
        for design in some {
            let known = store.and_then(|store| store.get(&prepared.report_id(design)));
            match known {
                Some(row) => {
                    judged.cached += 1;
                    judged.rows.push(row.clone());
                }
                None => {
                    fresh.push(judged.rows.len() - first);
                    judged.rows.push(prepared.row(design, control)?);
                }
            }
        }
        if let Some(store) = store {
            let rows = &judged.rows[first..];
            let fresh: Vec<&Row> = fresh.into_iter().map(|index| &rows[index]).collect();
            store.put(&fresh)?;
        }
    }
    Ok(judged)
}
