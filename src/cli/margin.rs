//! `latchgate margin`: how far a verdict is from changing, and what design would change it.

use super::design::requested_design;
use super::failure::{COULD_NOT, Failure};
use super::inputs::Inputs;
use super::options::{Common, MarginArguments};
use super::output;
use super::progress::Progress;
use super::values::OutputFormat;
use crate::pipeline;
use latchgate_recording::Limits;
use std::path::Path;
use std::time::Instant;

/// Runs the command; returns the exit code.
pub(super) fn command(arguments: &MarginArguments, common: &Common) -> Result<u8, Failure> {
    let started = Instant::now();
    let request = arguments.request(common).map_err(Failure::Usage)?;
    let design = requested_design(&arguments.replay, &request.replay, common)?.design;
    if let Some(out) = &arguments.replay.out {
        let inputs = Inputs::of(&arguments.replay, &[]);
        inputs.check_report_folder(out).map_err(Failure::Data)?;
    }
    let source = arguments.replay.read.source().map_err(Failure::Data)?;
    let step = format!("margin {}", source.name());
    let progress = Progress::new(&step).that_keeps();
    let outcome = progress.watch(&step, common.thread_count(), |control| {
        pipeline::margin(&source, &request, &design, &Limits::default(), control)
    });
    drop(progress);
    let pipeline::MarginOutcome {
        mut document,
        margins,
    } = outcome.map_err(Failure::of_data)?;
    document.run.elapsed_s = started.elapsed().as_secs_f64();
    let folder = (!arguments.replay.no_report).then(|| {
        let folder = || {
            let name = latchgate_report::folder_name(
                &document.recording.file,
                &design.name,
                &document.report_id,
            );
            Path::new("reports/out").join(name)
        };
        arguments.replay.out.clone().unwrap_or_else(folder)
    });
    if let Some(folder) = &folder {
        latchgate_report::margin::write(folder, &document, &margins).map_err(Failure::Data)?;
    }
    match common.format {
        OutputFormat::Json => output::document(&latchgate_document::json::render(&document)),
        OutputFormat::Text => output::text(&latchgate_report::margin::text(
            &document,
            folder.as_deref(),
            output::look(common),
        )),
    }
    .map_err(Failure::Data)?;
    if margins.stopped {
        return Err(Failure::Interrupted);
    }
    if margins.spoiled {
        output::talk(&format!(
            "latchgate: {}: the recording has a blocking finding; its margins prove nothing",
            document.recording.file
        ));
        return Ok(COULD_NOT);
    }
    Ok(0)
}
