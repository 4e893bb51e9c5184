//! `latchgate replay`: recordings, one design, a verdict each.
//!
//! - `answer`: what it prints, on stdout and on stderr, and its exit code.

mod answer;

use super::design::asked_design;
use super::failure::Failure;
use super::inputs::Inputs;
use super::options::{Common, ReplayCommand, is_pulse, source_of};
use super::output;
use super::pdf;
use super::progress::{self, Progress};
use super::values::OutputFormat;
use crate::pipeline::{Extras, Outcome, Prepared};
use latchgate_recording::Limits;
use latchgate_recording::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A recording's answer, and where its report lies.
struct ReplayedFile {
    outcome: Outcome,
    report: Option<PathBuf>,
    /// Its print.
    pdf: Option<PathBuf>,
    /// Why its report could not be written.
    unwritten: Option<Error>,
}

/// Runs the command; returns the exit code.
pub(super) fn command(own: &ReplayCommand, common: &Common) -> Result<u8, Failure> {
    // What the command line alone shows to be wrong comes before what a file says.
    let request = own.replay.request(common).map_err(Failure::Usage)?;
    let design = asked_design(&own.replay, &request, common)?;
    let inputs = Inputs::of(&own.replay, &own.further);
    if let Some(series) = &own.series {
        inputs.are_not(series).map_err(Failure::Data)?;
    }
    let first = &own.replay.read.recording;
    let recordings: Vec<&Path> = std::iter::once(first)
        .chain(&own.further)
        .map(PathBuf::as_path)
        .collect();
    let progress = Progress::new("replay");
    // A search of its own, for readers of one answer; a program asks for the margin.
    let advises = common.format == OutputFormat::Text && recordings.len() == 1;
    let limits = Limits::default();
    let mut judged = Vec::with_capacity(recordings.len());
    for (index, recording) in recordings.iter().enumerate() {
        let step = match recordings.len() {
            1 => format!("replay {}", recording.display()),
            many => format!("replay {} of {many}: {}", index + 1, recording.display()),
        };
        let started = Instant::now();
        let extras = Extras {
            filter_table: advises || !own.replay.no_report || request.members > 0,
            preload_answer: false,
            evidence: !own.replay.no_report || own.series.is_some(),
        };
        let source = source_of(recording).map_err(Failure::Data)?;
        let (prepared, mut outcome) =
            progress.watch(
                &step,
                common.thread_count(),
                |control| match Prepared::open(&source, &request, &limits, control) {
                    Ok(prepared) => {
                        let outcome = prepared.judge(&design, extras, control);
                        (Some(prepared), outcome)
                    }
                    Err(refused) => (None, refused.outcome(&design)),
                },
            );
        if outcome.was_stopped() {
            return Err(Failure::Interrupted);
        }
        outcome.document.run.elapsed_s = started.elapsed().as_secs_f64();
        if advises {
            // Whoever reads one answer does not wait for the search.
            progress::wipe();
            answer::print_first(&outcome, common).map_err(Failure::Data)?;
        }
        let prepared = prepared.filter(|_| outcome.refusal.is_none());
        if let (Some(prepared), true) = (&prepared, advises || !own.replay.no_report) {
            let step = format!("{step}: preloads that pass");
            let advised = progress.watch(&step, common.thread_count(), |control| {
                prepared.advise(&design, &mut outcome.document, control)
            });
            advised.map_err(Failure::of_data)?;
        }
        judged.push(kept(own, &inputs, recording, recordings.len() > 1, outcome));
    }
    drop(progress);
    answer::print(&judged, common).map_err(Failure::Data)?;
    for (recording, judged) in recordings.iter().zip(&judged) {
        answer::say(recording, judged);
        if let (true, Some(report)) = (own.open, &judged.report) {
            output::open(&report.join(latchgate_report::REPORT_FILE));
        }
    }
    Ok(answer::exit_code(&judged))
}

/// Writes the report, if there is to be one; what was not judged has none.
fn kept(
    own: &ReplayCommand,
    inputs: &Inputs,
    recording: &Path,
    several: bool,
    outcome: Outcome,
) -> ReplayedFile {
    let mut judged = ReplayedFile {
        outcome,
        report: None,
        pdf: None,
        unwritten: None,
    };
    if let (Some(path), Some(evidence)) = (&own.series, &judged.outcome.evidence) {
        judged.unwritten = latchgate_report::series::write(path, &evidence.series).err();
    }
    let document = &judged.outcome.document;
    if own.replay.no_report || judged.outcome.refusal.is_some() {
        return judged;
    }
    let name = latchgate_report::folder_name(
        &document.recording.file,
        &document.design.name,
        &document.report_id,
    );
    let folder = match &own.replay.out {
        Some(out) if several => out.join(name),
        Some(out) => out.clone(),
        None => Path::new("reports/out").join(name),
    };
    if let Err(error) = inputs.lie_outside(&folder) {
        judged.unwritten = Some(error);
        return judged;
    }
    let evidence = judged.outcome.evidence.as_ref();
    let is_file = recording != Path::new("-") && !is_pulse(recording);
    let path = is_file.then_some(recording);
    let earlier = latchgate_report::id_in(&folder);
    match latchgate_report::write(&folder, latchgate_report::files(document, evidence), path) {
        Ok(_) => {
            if earlier.is_some_and(|earlier| earlier != document.report_id) {
                let folder = folder.display();
                output::talk(&format!(
                    "latchgate: {folder}: an earlier report was replaced"
                ));
            }
            if own.pdf {
                match pdf::print(&folder) {
                    Ok(path) => judged.pdf = Some(path),
                    Err(error) => judged.unwritten = Some(error),
                }
            }
            judged.report = Some(folder);
        }
        Err(error) => judged.unwritten = Some(error),
    }
    judged
}
