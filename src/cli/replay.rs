//! `latchgate replay`: recordings, one design, a verdict each.
//!
//! - `answer`: its output on stdout and stderr, and its exit code.

mod answer;

pub use answer::message;

use super::clock;
use super::design::{RequestedDesign, requested_design};
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

/// A recording's answer, and the paths of its report.
struct ReplayedFile {
    outcome: Outcome,
    /// Folder of the report.
    report: Option<PathBuf>,
    /// The report as a PDF.
    pdf: Option<PathBuf>,
    /// Error of writing the report or the series.
    unwritten: Option<Error>,
}

/// Runs the command; returns the exit code.
pub(super) fn command(arguments: &ReplayCommand, common: &Common) -> Result<u8, Failure> {
    // Errors that the command line alone shows come before those of files: exit code 2, not 4.
    let request = arguments.replay.request(common).map_err(Failure::Usage)?;
    let RequestedDesign { design, file } = requested_design(&arguments.replay, &request, common)?;
    let inputs = Inputs::of(&arguments.replay, &arguments.further);
    if let Some(series) = &arguments.series {
        inputs.check_series_file(series).map_err(Failure::Data)?;
    }
    let first = &arguments.replay.read.recording;
    let recordings: Vec<&Path> = std::iter::once(first)
        .chain(&arguments.further)
        .map(PathBuf::as_path)
        .collect();
    let progress = Progress::new("replay");
    // The preload advice is a separate search. Only a single text answer includes it; a program
    // calls `latchgate margin`.
    let is_single_text = common.format == OutputFormat::Text && recordings.len() == 1;
    let advises = is_single_text && !arguments.no_advice;
    let limits = Limits::default();
    let mut judged = Vec::with_capacity(recordings.len());
    for (index, recording) in recordings.iter().enumerate() {
        let step = match recordings.len() {
            1 => format!("replay {}", recording.display()),
            many => format!("replay {} of {many}: {}", index + 1, recording.display()),
        };
        let started = Instant::now();
        let extras = Extras {
            filter_table: is_single_text || !arguments.replay.no_report || request.members > 0,
            preload_answer: false,
            evidence: !arguments.replay.no_report || arguments.series.is_some(),
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
        let run = &mut outcome.document.run;
        run.elapsed_s = started.elapsed().as_secs_f64();
        run.date = Some(clock::date_of_run());
        if arguments.by.is_some() {
            run.by.clone_from(&arguments.by);
        }
        run.set_design_file(file.clone());
        if is_single_text {
            // The answer comes before the search for advice, which takes longer.
            progress::wipe();
            answer::print_first(&outcome, common).map_err(Failure::Data)?;
        }
        let prepared = prepared.filter(|_| outcome.refusal.is_none());
        let is_stored = !arguments.replay.no_report && !arguments.no_advice;
        if let (Some(prepared), true) = (&prepared, advises || is_stored) {
            let step = format!("{step}: preloads that pass");
            let advised = progress.watch(&step, common.thread_count(), |control| {
                prepared.advise(&design, &mut outcome.document, control)
            });
            if let Err(error) = advised {
                if is_single_text && error.is_stopped() {
                    output::talk(
                        "latchgate: interrupted: the verdict stands, without advice and report",
                    );
                    return Ok(outcome.document.verdict.exit_code());
                }
                return Err(Failure::of_data(error));
            }
        }
        judged.push(write_report(
            arguments,
            &inputs,
            recording,
            recordings.len() > 1,
            outcome,
        ));
    }
    drop(progress);
    answer::print(&judged, common).map_err(Failure::Data)?;
    for (recording, judged) in recordings.iter().zip(&judged) {
        answer::print_errors(recording, judged);
        if let (true, Some(report)) = (arguments.open, &judged.report) {
            output::open(&report.join(latchgate_report::REPORT_FILE));
        }
    }
    Ok(answer::exit_code(&judged))
}

/// Writes series and report, where they are requested. A recording that was not judged has none.
fn write_report(
    arguments: &ReplayCommand,
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
    if let (Some(path), Some(evidence)) = (&arguments.series, &judged.outcome.evidence) {
        judged.unwritten = latchgate_report::series::write(path, &evidence.series).err();
    }
    let document = &judged.outcome.document;
    if arguments.replay.no_report || judged.outcome.refusal.is_some() {
        return judged;
    }
    let name = latchgate_report::folder_name(
        &document.recording.file,
        &document.design.name,
        &document.report_id,
    );
    let folder = match &arguments.replay.out {
        Some(out) if several => out.join(name),
        Some(out) => out.clone(),
        None => Path::new("reports/out").join(name),
    };
    if let Err(error) = inputs.check_report_folder(&folder) {
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
            if arguments.pdf {
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
