//! `latchgate study damages`.

use super::analysis::{Analysis, Session, StudyAnswer};
use crate::cli::failure::Failure;
use crate::cli::options::StudyCommon;
use clap::Args;
use latchgate_kernel::model::Design;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::units::{AccelerationUnit, OpensWhen};
use latchgate_recording::error::Error;
use latchgate_recording::{Channel, Limits, ReadOptions, Selection, Severity, Source, Stated};
use latchgate_study::chart;
use latchgate_study::damages::{self, DamageAnswer};
use latchgate_study::files::StudyTable;
use latchgate_verdict::conditioning::{ConditioningOptions, Signal, condition};
use latchgate_verdict::{
    Answer, AssessDetail, AssessExtras, ModelChoice, Polarity, Policy, assess,
};
use serde_json::json;
use std::path::PathBuf;

/// Options of `study damages`.
#[derive(Debug, Clone, Args)]
pub struct Arguments {
    /// Lever and files.
    #[command(flatten)]
    pub study: StudyCommon,
    /// Number of damages
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000), default_value_t = 10_400, allow_negative_numbers = true)]
    pub points: u32,
    /// Seed of the random damages
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        allow_negative_numbers = true
    )]
    pub seed: u64,
    /// A recording to damage, negative opens [default: recordings by formula]
    #[arg(long, value_name = "FILE")]
    pub recording: Option<PathBuf>,
    /// Its channel
    #[arg(long, value_name = "NAME", requires = "recording")]
    pub channel: Option<String>,
}

impl Analysis for Arguments {
    fn run(&self, design: &Design, session: &Session) -> Result<StudyAnswer, Failure> {
        let options = damages::Options {
            runs: self.points,
            seed: self.seed,
            own: self.signal().map_err(Failure::Data)?,
        };
        let result = session.watch("damaging recordings", |control| {
            damages::run(&options, &|signal| judged(signal, design), control)
        })?;
        Ok(StudyAnswer {
            results: Some(json!(result)),
            tables: vec![StudyTable::of(&result.rows).map_err(Failure::Data)?],
            svg: chart::damages(&result),
            headlines: result.headlines,
            ..StudyAnswer::to(&options)
        })
    }
}

impl Arguments {
    /// Reads the recording that is damaged, if one is named.
    fn signal(&self) -> Result<Option<Signal>, Error> {
        let Some(path) = &self.recording else {
            return Ok(None);
        };
        let options = ReadOptions {
            channel: self.channel.clone(),
            ..ReadOptions::default()
        };
        let source = Source::File(path.clone());
        let read =
            latchgate_recording::read(&source, &options, Selection::Lateral, &Limits::default())?;
        let channel = read.channels.first();
        channel
            .map(|channel| condition(channel, &ConditioningOptions::default()))
            .transpose()
            .map(|conditioned| conditioned.map(|conditioned| conditioned.raw))
    }
}

/// Judges a signal by nominal runs on both stops, as a replay without members does.
fn judged(signal: &Signal, design: &Design) -> Result<DamageAnswer, Error> {
    let channel = Channel {
        name: "damaged".into(),
        unit: Some(AccelerationUnit::MetrePerSecondSquared),
        unit_source: "study",
        start_s: signal.start_s,
        rate: signal.rate,
        values: signal.samples.clone(),
        stated: Stated::default(),
        findings: Vec::new(),
        pulse: None,
    };
    let conditioned = condition(&channel, &ConditioningOptions::default())?;
    let codes = |severity: Severity| -> Vec<String> {
        let findings = conditioned.findings.iter();
        let findings = findings.filter(|finding| finding.severity == severity);
        findings.map(|finding| finding.code.to_string()).collect()
    };
    let blocking = codes(Severity::Blocking);
    let policy = Policy::new(ModelChoice::Auto, Polarity::Declared(OpensWhen::Negative));
    let findings = &conditioned.findings;
    let control = Control::default();
    let extras = AssessExtras {
        detail: AssessDetail::Decision,
        ..AssessExtras::default()
    };
    // A blocking finding rules a pass out, and thousands of damages are judged: no run for those.
    let passes = blocking.is_empty()
        && assess(&conditioned, findings, design, &policy, extras, &control)?.answer
            == Answer::Pass;
    Ok(DamageAnswer {
        passes,
        needs_word: findings.iter().any(|finding| finding.needs_word),
        blocking,
        warnings: codes(Severity::Warning),
    })
}
