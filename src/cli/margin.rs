//! `latchgate margin`: how far a verdict is from changing, and what design would change it.

use super::args::{Common, MarginArguments, OutputFormat, ReplayArguments};
use super::replay::{self, Facts, Tables};
use super::{Failure, output};
use crate::error::{Error, Place};
use crate::margin::{Basis, MapRequest, MarginOptions, Margins, margins};
use crate::model::Design;
use crate::parallel::Control;
use crate::recording::{Finding, Limits, Source};
use crate::report;
use crate::report::MarginDocument;
use crate::report::document::RunBlock;
use crate::report::margin_document::Context;
use crate::verdict::Assessment;
use std::time::Instant;

/// Exit code where a blocking finding spoils the recording.
const SPOILED: u8 = super::COULD_NOT;

/// Runs the command; returns the exit code.
pub(super) fn command(own: &MarginArguments, common: &Common) -> Result<u8, Failure> {
    let started = Instant::now();
    let limits = Limits::default();
    let asked = &own.replay;
    replay::check_format_name(asked.read.input_format.as_deref()).map_err(Failure::Usage)?;
    replay::check_initial(asked)?;
    replay::check_method(asked)?;
    let design = replay::design(asked.design.as_deref(), &asked.set, &limits)?;
    replay::check_tolerances(asked, &design)?;
    let map = map_request(own);
    if let Some(request) = &map {
        request.check(&design).map_err(Failure::Usage)?;
    }
    let source = replay::source(&asked.read.recording);
    let mut facts = Facts::new(asked, common, &source);
    let (assessment, margins) =
        judge(own, common, &design, &source, &limits, map, &mut facts).map_err(Failure::Data)?;
    let mut findings = facts.findings.clone();
    findings.extend(assessment.findings);
    findings.sort_by_key(|finding: &Finding| std::cmp::Reverse(finding.severity));
    facts.request.command = command_line(own, &facts.request.command);
    let context = Context {
        verdict: assessment.answer,
        findings,
        recording: facts.block.clone(),
        conditioning: facts
            .conditioned
            .as_ref()
            .map(|conditioned| replay::conditioning_block(conditioned, &facts.card)),
        request: facts.request.clone(),
        run: RunBlock {
            version: env!("CARGO_PKG_VERSION"),
            elapsed_s: started.elapsed().as_secs_f64(),
        },
    };
    let document = MarginDocument::new(&margins, &design, own.counterweight_radius, context);
    let written = if asked.no_report {
        None
    } else {
        let folder = asked
            .out
            .clone()
            .unwrap_or_else(|| replay::default_folder(&source.name(), &design.name));
        report::margin::write(&folder, &document, &margins).map_err(Failure::Data)?;
        Some(folder)
    };
    match common.format {
        OutputFormat::Json => output::document(&report::json::render(&document)),
        OutputFormat::Text => output::text(&report::margin::text(&document, written.as_deref())),
    }
    .map_err(Failure::Data)?;
    if margins.spoiled {
        output::talk(&format!(
            "latchgate: {}: a blocking finding spoils the recording; its margins are no evidence",
            source.name()
        ));
        return Ok(SPOILED);
    }
    Ok(0)
}

fn judge(
    own: &MarginArguments,
    common: &Common,
    design: &Design,
    source: &Source,
    limits: &Limits,
    map: Option<MapRequest>,
    facts: &mut Facts,
) -> Result<(Assessment, Margins), Error> {
    let unseen = ReplayArguments {
        no_report: true,
        ..own.replay.clone()
    };
    let (assessment, _) = replay::judge(
        &unseen,
        common,
        design,
        source,
        limits,
        Tables::default(),
        facts,
    )?;
    let Some(conditioned) = &facts.conditioned else {
        return Err(crate::error::ErrorKind::MissingUnit.into());
    };
    let options = MarginOptions {
        policy: replay::policy(&unseen, facts.polarity),
        basis: if unseen.members == 0 {
            Basis::NominalRun
        } else {
            Basis::Verdict
        },
        counterweight_radius_m: own.counterweight_radius,
        points: own.points.map(|points| points as usize),
        map,
        limit: true,
    };
    let control = Control::unwatched(common.thread_count());
    let margins = margins(conditioned, &facts.findings, design, &options, &control)
        .map_err(|error| error.at(Place::file(source.name())))?;
    Ok((assessment, margins))
}

fn map_request(own: &MarginArguments) -> Option<MapRequest> {
    let axes = own.map.as_ref()?;
    let [x, y] = axes.as_slice() else {
        return None;
    };
    Some(MapRequest {
        x: x.clone(),
        y: y.clone(),
        columns: own.map_grid.columns,
        rows: own.map_grid.rows,
    })
}

/// The command that repeats the run: that of the replay with its own name and options.
fn command_line(own: &MarginArguments, replayed: &str) -> String {
    let mut line = replayed.replacen("latchgate replay", "latchgate margin", 1);
    let mut option = |name: &str, value: String| {
        line.push_str(&format!(" --{name} {}", replay::quoted(&value)));
    };
    option("counterweight-radius", own.counterweight_radius.to_string());
    if let Some(points) = own.points {
        option("points", points.to_string());
    }
    if let Some([x, y]) = own.map.as_deref() {
        let axis = |axis: &crate::margin::MapAxis| {
            replay::quoted(&format!("{}={}..{}", axis.key, axis.low, axis.high))
        };
        line.push_str(&format!(
            " --map {} {} --map-grid {}x{}",
            axis(x),
            axis(y),
            own.map_grid.columns,
            own.map_grid.rows
        ));
    }
    line
}
