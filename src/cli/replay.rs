//! `latchgate replay`: one recording, one design, one verdict.

use super::args::{
    Common, MEMBERS_DEFAULT, ModelArgument, OutputFormat, ReadArguments, ReplayArguments, Resample,
    SEED_DEFAULT,
};
use super::{Failure, candidates, output};
use crate::conditioning::{self, BiasWindow, Conditioned, ConditioningOptions, FilterChoice, cfc};
use crate::error::{Error, ErrorKind, Place};
use crate::margin::{self, PreloadAnswer};
use crate::model::Design;
use crate::model::stop::StopModel;
use crate::parallel::Control;
use crate::recording::card::CardPolarity;
use crate::recording::{
    self, Card, Channel, Finding, Limits, ReadOptions, Recording, Selection, Severity, Source,
};
use crate::replay::{ADAPTIVE_TOLERANCE_MIN, Method};
use crate::report;
use crate::report::document::{ConditioningBlock, Document, RecordingBlock, Request, RunBlock};
use crate::units::{OpensWhen, STANDARD_GRAVITY};
use crate::verdict::{
    self, Answer, Assessment, DECISION_RULE, ErrorBudget, Evidence, Extras, ModelChoice,
    NOMINAL_DECISION_RULE, Polarity, Policy, Reason, Screens, assess, ensemble, screen,
};
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Runs the command; returns the exit code.
pub(super) fn command(own: &ReplayArguments, common: &Common) -> Result<u8, Failure> {
    let started = Instant::now();
    let limits = common.limits().map_err(Failure::Usage)?;
    // What the command line alone shows to be wrong comes before what a file says.
    check_format_name(own.read.input_format.as_deref()).map_err(Failure::Usage)?;
    check_initial(own)?;
    check_method(own)?;
    let design = design(own.design.as_deref(), &own.set, &limits)?;
    check_tolerances(own, &design)?;
    let source = source(&own.read.recording);
    let tables = Tables {
        // The nominal run alone, for a program that reads one number, is not to wait for more.
        filters: own.members > 0 || !own.no_report,
        preload: !own.no_report,
        evidence: !own.no_report,
    };
    let (mut document, evidence, refusal) =
        document(own, common, &design, &source, &limits, tables);
    document.run.elapsed_s = started.elapsed().as_secs_f64();
    let written = if own.no_report {
        None
    } else {
        let folder = own
            .out
            .clone()
            .unwrap_or_else(|| default_folder(&source.name(), &design.name));
        // A name that no file bears makes no folder; but an older report, perhaps a pass, must
        // not outlive a run that found its recording gone.
        let nothing_there = refusal
            .as_ref()
            .is_some_and(|error| matches!(error.kind(), ErrorKind::Io { .. }));
        if nothing_there && !folder.exists() {
            None
        } else {
            report::write(&folder, &document, evidence.as_ref()).map_err(Failure::Data)?;
            Some(folder)
        }
    };
    match common.format {
        OutputFormat::Json => output::document(&report::json::render(&document)),
        OutputFormat::Text => output::text(&report::text::render(&document, written.as_deref())),
    }
    .map_err(Failure::Data)?;
    if let Some(error) = refusal {
        output::talk(&format!("latchgate: {error}"));
        let mut options = read_options(&own.read, common);
        if let Ok(Some((card, _))) = recording::card::read_beside(&source, &limits) {
            card.merge_into(&mut options);
        }
        let asked = &own.read.recording;
        if let Some(lines) = candidates::of_refusal(&error, asked, &source, &options, &limits) {
            output::talk(&lines);
        }
    } else if document.verdict == Answer::Unusable {
        let reason = document
            .why
            .first()
            .map_or("", |reason| reason.text.as_str());
        output::talk(&format!("latchgate: {}: unusable: {reason}", source.name()));
    }
    Ok(document.verdict.exit_code())
}

/// What goes with a verdict and costs more than it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Tables {
    /// The verdict after each filter.
    pub(super) filters: bool,
    /// The preload that the recording asks for.
    pub(super) preload: bool,
    /// What a report draws.
    pub(super) evidence: bool,
}

/// Judges, and puts the document together either way: with what a report draws, or with the
/// error that left nothing to judge.
pub(super) fn document(
    own: &ReplayArguments,
    common: &Common,
    design: &Design,
    source: &Source,
    limits: &Limits,
    tables: Tables,
) -> (Document, Option<Evidence>, Option<Error>) {
    let mut facts = Facts::new(own, common, source);
    match judge(own, common, design, source, limits, tables, &mut facts) {
        Ok((mut assessment, preload)) => {
            let evidence = assessment.evidence.take();
            (
                answered(&facts, design, assessment, preload),
                evidence,
                None,
            )
        }
        Err(error) => {
            if facts.block.sha256.is_none() {
                facts.block.sha256 = hash_of_refused(source, limits);
            }
            (refused(&facts, design, &error), None, Some(error))
        }
    }
}

/// Hashes a regular file that was refused before its end was read; one beyond the limits on
/// size is not worth the wait.
fn hash_of_refused(source: &Source, limits: &Limits) -> Option<String> {
    source.sha256_within(limits.text_bytes)
}

/// What is known about the request so far, for a document that must be written either way.
pub(super) struct Facts {
    pub(super) recording: Option<Recording>,
    pub(super) card: Card,
    pub(super) conditioned: Option<Conditioned>,
    pub(super) block: RecordingBlock,
    pub(super) findings: Vec<Finding>,
    pub(super) polarity: Polarity,
    pub(super) request: Request,
}

impl Facts {
    pub(super) fn new(own: &ReplayArguments, common: &Common, source: &Source) -> Self {
        Self {
            recording: None,
            card: Card::default(),
            conditioned: None,
            block: RecordingBlock {
                file: source.name(),
                ..RecordingBlock::default()
            },
            findings: Vec::new(),
            polarity: Polarity::Undeclared,
            request: Request {
                command: command_line(own, common, source),
                opens_when_source: "undeclared",
                model: model_choice(own.model).name(),
                window_s: own.window.map(|window| (window.start_s, window.end_s)),
                phi0_rad: own.phi0,
                omega0_rad_s: own.omega0,
                members: own.members,
                seed: own.seed,
            },
        }
    }
}

/// Reads, conditions, replays and decides, noting in `facts` what became known on the way.
pub(super) fn judge(
    own: &ReplayArguments,
    common: &Common,
    design: &Design,
    source: &Source,
    limits: &Limits,
    tables: Tables,
    facts: &mut Facts,
) -> Result<(Assessment, Option<PreloadAnswer>), Error> {
    let mut options = read_options(&own.read, common);
    if let Some((card, sha256)) = recording::card::read_beside(source, limits)? {
        card.merge_into(&mut options);
        facts.card = card;
        facts.block.card_sha256 = Some(sha256);
    }
    let declared = own.opens_when.map(|polarity| (polarity, "option"));
    let declared = declared.or(facts.card.opens_when.map(|polarity| (polarity, "card")));
    if let Some((polarity, source)) = declared {
        facts.request.opens_when_source = source;
        facts.polarity = match polarity {
            CardPolarity::Negative => Polarity::Declared(OpensWhen::Negative),
            CardPolarity::Positive => Polarity::Declared(OpensWhen::Positive),
            CardPolarity::Both => Polarity::Both,
        };
    }
    let recording = recording::read(source, &options, Selection::Lateral, limits)?;
    facts.findings.clone_from(&recording.findings);
    let chosen = |finding: &Finding| finding.code == "channel-chosen";
    let several = options.channel.is_some() || facts.findings.iter().any(chosen);
    facts.block.sha256 = Some(recording.sha256.clone());
    facts.block.parts.clone_from(&recording.parts);
    facts.block.format = Some(recording.format);
    facts.recording = Some(recording);
    let channel = match facts
        .recording
        .as_ref()
        .and_then(|recording| recording.channels.first())
    {
        Some(channel) => channel.clone(),
        None => {
            return Err(Error::from(ErrorKind::NoChannel {
                known: "none".into(),
            })
            .at(Place::file(source.name())));
        }
    };
    describe_channel(&mut facts.block, &channel);
    facts.findings.extend(channel.findings.iter().cloned());
    if several {
        facts
            .findings
            .extend(beside(source, &options, &channel, limits));
    }
    let conditioned = conditioning::condition(&channel, &conditioning_options(own, &facts.card))
        .map_err(|error| error.at(Place::file(source.name())))?;
    if let Some((peak, time)) = conditioning::peak(&conditioned.raw) {
        facts.block.peak_g = Some(peak.abs() / STANDARD_GRAVITY);
        facts.block.peak_time_s = Some(time);
    }
    facts.findings.extend(conditioned.findings.iter().cloned());
    facts.conditioned = Some(conditioned);
    let Some(conditioned) = &facts.conditioned else {
        return Err(ErrorKind::MissingUnit.into());
    };
    let policy = policy(own, facts.polarity);
    let extras = Extras {
        filter_table: tables.filters,
        evidence: tables.evidence,
        follow_all: false,
    };
    let control = Control::unwatched(common.thread_count());
    let place = || Place::file(source.name()).channel(channel.name.clone());
    let assessment = verdict::assess(
        conditioned,
        &facts.findings,
        design,
        &policy,
        extras,
        &control,
    )
    .map_err(|error| error.at(place()))?;
    let preload = (tables.preload && assessment.whole)
        .then(|| {
            let passes = assessment.answer == Answer::Pass;
            margin::preload_answer(
                conditioned,
                &facts.findings,
                design,
                &policy,
                passes,
                &control,
            )
        })
        .transpose()
        .map_err(|error| error.at(place()))?;
    Ok((assessment, preload))
}

/// Returns what the recording's other channels say against the one that is replayed, or that they
/// could not be read for it, which is no fault of this one.
fn beside(
    source: &Source,
    options: &ReadOptions,
    channel: &Channel,
    limits: &Limits,
) -> Vec<Finding> {
    let unread = |why: &str| {
        vec![Finding::info(
            "neighbours-unread",
            format!("the other channels were not held against this one: {why}"),
        )]
    };
    if *source == Source::Stdin {
        return unread("standard input is read once");
    }
    let all = match recording::read(source, options, Selection::Every, limits) {
        Ok(all) => all,
        Err(error) => return unread(&error.to_string()),
    };
    let same = |other: &Channel| other.name == channel.name && other.values == channel.values;
    let Some(index) = all.channels.iter().position(same) else {
        return Vec::new();
    };
    conditioning::neighbours::findings(&all.channels)
        .into_iter()
        .filter(|(of, _)| *of == index)
        .map(|(_, finding)| finding)
        .collect()
}

pub(super) fn policy(own: &ReplayArguments, polarity: Polarity) -> Policy {
    Policy {
        model: model_choice(own.model),
        polarity,
        method: own.method.method(own.steps_per_period),
        tolerance_rad: own.tolerance,
        initial_angle_rad: own.phi0,
        initial_velocity_rad_s: own.omega0,
        window_s: own.window.map(|window| (window.start_s, window.end_s)),
        members: own.members,
        seed: own.seed,
    }
}

fn model_choice(model: ModelArgument) -> ModelChoice {
    match model {
        ModelArgument::Auto => ModelChoice::Auto,
        ModelArgument::Rigid => ModelChoice::Only(StopModel::Rigid),
        ModelArgument::Soft => ModelChoice::Only(StopModel::Soft),
    }
}

/// Takes what the options say about reading.
pub(super) fn read_options(own: &ReadArguments, common: &Common) -> ReadOptions {
    ReadOptions {
        channel: own.channel.clone(),
        time_column: own.time_column.clone(),
        time_unit: own.time_unit,
        rate_hz: own.rate_hz,
        time_zero_s: own.time_zero,
        unit: own.unit,
        input_format: own.input_format.clone(),
        one_thread: common.thread_count() == 1,
        ..ReadOptions::default()
    }
}

/// Refuses a format name that no reader bears.
pub(super) fn check_format_name(name: Option<&str>) -> Result<(), Error> {
    let known: Vec<&str> = recording::FORMATS
        .iter()
        .map(|format| format.name)
        .collect();
    match name {
        Some(name) if !known.contains(&name) => Err(ErrorKind::UnknownName {
            what: "input format",
            found: name.to_string(),
            nearest: crate::error::nearest_name(name, &known),
            known: known.join(", "),
        }
        .into()),
        _ => Ok(()),
    }
}

/// Takes `-` for standard input, anything else for a path.
pub(super) fn source(path: &Path) -> Source {
    if path == Path::new("-") {
        Source::Stdin
    } else {
        Source::File(path.to_path_buf())
    }
}

fn conditioning_options(own: &ReplayArguments, card: &Card) -> ConditioningOptions {
    ConditioningOptions {
        bias: own.bias.unwrap_or(BiasWindow::PreEvent),
        filter: own.filter.unwrap_or(FilterChoice::Default),
        filter_standard: own.filter_standard,
        resample_hz: match own.resample {
            Resample::Native => None,
            Resample::Hertz(hertz) => Some(hertz),
        },
        range_g: card.range_g,
        synthetic: card.synthetic,
    }
}

/// Reads the design file, if one is named, and applies the overrides.
pub(super) fn design(
    file: Option<&Path>,
    overrides: &[String],
    limits: &Limits,
) -> Result<Design, Failure> {
    let mut design = Design::reference();
    override_keys(&mut design, overrides).map_err(Failure::Usage)?;
    match file {
        None => design.validate().map_err(Failure::Usage)?,
        Some(path) => {
            design = read_design(path, limits).map_err(Failure::Data)?;
            override_keys(&mut design, overrides).map_err(Failure::Usage)?;
            // Here it takes the file to see that the values do not go together.
            design.validate().map_err(Failure::Data)?;
        }
    }
    Ok(design)
}

fn override_keys(design: &mut Design, overrides: &[String]) -> Result<(), Error> {
    overrides
        .iter()
        .try_for_each(|assignment| design.set(assignment))
        .map_err(|error| error.at(Place::file("--set")))
}

fn read_design(path: &Path, limits: &Limits) -> Result<Design, Error> {
    let place = Place::file(
        path.file_name()
            .map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
    );
    let unreadable = |error: std::io::Error| {
        Error::from(ErrorKind::Io {
            action: "read the design file",
            reason: error.to_string(),
        })
        .at(place.clone())
    };
    let mut bytes = Vec::new();
    std::fs::File::open(path)
        .and_then(|file| file.take(limits.settings_bytes + 1).read_to_end(&mut bytes))
        .map_err(unreadable)?;
    if bytes.len() as u64 > limits.settings_bytes {
        return Err(Error::from(ErrorKind::LimitExceeded {
            limit: "settings_bytes",
            value: limits.settings_bytes,
            found: "a larger design file".into(),
        })
        .at(place));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        Error::from(ErrorKind::Malformed {
            expected: "UTF-8".into(),
            found: format!(
                "a stray byte after {} bytes",
                error.utf8_error().valid_up_to()
            ),
            hint: "save the design file as UTF-8".into(),
        })
        .at(place.clone())
    })?;
    let mut design = Design::from_toml(&text).map_err(|error| error.at(place))?;
    if design.name.is_empty() {
        design.name = path.file_stem().map_or_else(
            || "design".into(),
            |stem| stem.to_string_lossy().into_owned(),
        );
    }
    Ok(design)
}

pub(super) fn check_initial(own: &ReplayArguments) -> Result<(), Failure> {
    if own.phi0.is_some_and(|angle| angle < 0.0) && own.model != ModelArgument::Soft {
        return Err(Failure::Usage(
            ErrorKind::OutOfRange {
                what: "--phi0 [rad]".into(),
                expected:
                    "0 or more on the rigid stop; choose --model soft for an angle inside the stop"
                        .into(),
                found: own.phi0.map_or_else(String::new, |angle| angle.to_string()),
            }
            .into(),
        ));
    }
    Ok(())
}

/// Refuses tolerances that leave what is physical, where levers are to be scattered by them.
pub(super) fn check_tolerances(own: &ReplayArguments, design: &Design) -> Result<(), Failure> {
    if own.members == 0 {
        return Ok(());
    }
    ensemble::check(design).map_err(match own.design {
        None => Failure::Usage,
        // Here it takes the file to see that value and tolerance do not go together.
        Some(_) => Failure::Data,
    })
}

/// Refuses a method that cannot do what is asked of it.
pub(super) fn check_method(own: &ReplayArguments) -> Result<(), Failure> {
    let method = own.method.method(own.steps_per_period);
    if !method.admits(StopModel::Soft) && own.model != ModelArgument::Rigid {
        return Err(Failure::Usage(
            ErrorKind::OutOfRange {
                what: "--method".into(),
                expected: format!(
                    "one that knows the soft stop; {} knows the rigid one only, choose --model rigid",
                    method.name()
                ),
                found: format!(
                    "{} with --model {}",
                    method.name(),
                    model_choice(own.model).name()
                ),
            }
            .into(),
        ));
    }
    if matches!(method, Method::Dopri5 { .. })
        && own
            .tolerance
            .is_some_and(|tolerance| tolerance < ADAPTIVE_TOLERANCE_MIN)
    {
        return Err(Failure::Usage(
            ErrorKind::OutOfRange {
                what: format!("--tolerance of {}", method.name()),
                expected: format!("at least {ADAPTIVE_TOLERANCE_MIN:e}"),
                found: own
                    .tolerance
                    .map_or_else(String::new, |tolerance| tolerance.to_string()),
            }
            .into(),
        ));
    }
    Ok(())
}

fn describe_channel(block: &mut RecordingBlock, channel: &Channel) {
    block.channel = Some(channel.name.clone());
    block.unit = channel.unit.map(crate::units::AccelerationUnit::name);
    block.unit_source = Some(channel.unit_source);
    block.content_sha256 = channel.content_sha256();
    block.samples = channel.values.len();
    block.sample_rate_hz = Some(channel.rate.hertz());
    block.start_s = Some(channel.start_s);
    block.end_s = Some(channel.time_s(channel.values.len().saturating_sub(1)));
}

pub(super) fn conditioning_block(conditioned: &Conditioned, card: &Card) -> ConditioningBlock {
    let peak = conditioning::peak(&conditioned.used);
    ConditioningBlock {
        bias_m_s2: conditioned.bias_m_s2,
        bias_standard_error_m_s2: conditioned.bias_standard_error_m_s2,
        bias_standard_error_method: assess::bias_method(),
        bias_samples: conditioned.bias_samples,
        bias_window_s: conditioned.bias_window_s,
        filter: assess::filter_name(conditioned.filter),
        filter_standard: conditioned.filter_standard.name(),
        filter_design_frequency_hz: conditioned
            .filter
            .map(|filter| cfc::design_frequency_hz(filter, conditioned.filter_standard)),
        filter_end_treatment: conditioned
            .filter
            .map(|_| cfc::end_treatment(conditioned.filter_standard)),
        resample_hz: conditioned.resample_hz,
        peak_g: peak.map(|(peak, _)| peak.abs() / STANDARD_GRAVITY),
        peak_time_s: peak.map(|(_, time)| time),
        velocity_change_m_s: conditioning::velocity_change_m_s(&conditioned.used),
        range_g: card.range_g,
        synthetic: card.synthetic,
    }
}

fn answered(
    facts: &Facts,
    design: &Design,
    assessment: Assessment,
    preload_answer: Option<PreloadAnswer>,
) -> Document {
    let mut findings = facts.findings.clone();
    findings.extend(assessment.findings);
    // The worst first; within a severity in the order of the line from file to replay.
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    let empty = skeleton(facts, design);
    Document {
        verdict: assessment.answer,
        why: assessment.why,
        nominal: Some(assessment.nominal),
        models: assessment.models,
        polarities: assessment.polarities,
        answers: assessment.answers,
        ensemble: assessment.ensemble,
        ensembles: assessment.ensembles,
        ladder: Some(assessment.ladder),
        preload_answer,
        what_if: assessment.what_if,
        filters: assessment.filters,
        error_budget_rad: assessment.budget,
        screens: Screens {
            runs: assessment.screens,
            ..empty.screens
        },
        findings,
        ..empty
    }
}

/// The document of a recording that could not be read, conditioned or replayed.
fn refused(facts: &Facts, design: &Design, error: &Error) -> Document {
    let text = error.to_string();
    let mut findings = vec![Finding::blocking("input-refused", text.clone())];
    findings.extend(facts.findings.clone());
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    let mut why = vec![Reason {
        code: "input-refused".into(),
        text,
    }];
    why.extend(
        facts
            .findings
            .iter()
            .filter(|finding| finding.severity == Severity::Blocking)
            .map(|finding| Reason {
                code: finding.code.clone(),
                text: finding.text.clone(),
            }),
    );
    Document {
        verdict: Answer::Unusable,
        why,
        findings,
        ..skeleton(facts, design)
    }
}

fn skeleton(facts: &Facts, design: &Design) -> Document {
    Document {
        schema: "latchgate.verdict/1",
        verdict: Answer::Unusable,
        why: Vec::new(),
        threshold_rad: design.criterion.threshold_rad,
        nominal: None,
        models: BTreeMap::new(),
        polarities: BTreeMap::new(),
        answers: Vec::new(),
        ensemble: None,
        ensembles: Vec::new(),
        ladder: None,
        preload_answer: None,
        what_if: Vec::new(),
        error_budget_rad: ErrorBudget::default(),
        screens: screen::screens(
            design,
            facts
                .conditioned
                .as_ref()
                .map(|conditioned| &conditioned.used),
        ),
        filters: Vec::new(),
        findings: Vec::new(),
        recording: facts.block.clone(),
        conditioning: facts
            .conditioned
            .as_ref()
            .map(|conditioned| conditioning_block(conditioned, &facts.card)),
        design: design.clone(),
        decision_rule: if facts.request.members == 0 {
            NOMINAL_DECISION_RULE
        } else {
            DECISION_RULE
        },
        request: facts.request.clone(),
        run: RunBlock {
            version: env!("CARGO_PKG_VERSION"),
            elapsed_s: 0.0,
        },
    }
}

/// `reports/out/<recording>-<design>`, of characters that any file system takes.
pub(super) fn default_folder(recording: &str, design: &str) -> PathBuf {
    let name = if recording == "-" { "stdin" } else { recording };
    let plain: String = format!("{name}-{design}")
        .chars()
        .map(|c| {
            if c.is_alphanumeric() || matches!(c, '.' | '_' | '-') {
                c
            } else {
                '_'
            }
        })
        .collect();
    Path::new("reports/out").join(plain)
}

/// The command that repeats the run, with file names only: options that change no number
/// (threads, output, log) are left out.
fn command_line(own: &ReplayArguments, common: &Common, source: &Source) -> String {
    let mut words = vec!["latchgate".to_string(), "replay".into(), source.name()];
    let mut option = |name: &str, value: Option<String>| {
        if let Some(value) = value {
            words.push(format!("--{name}"));
            words.push(value);
        }
    };
    let read = &own.read;
    option("input-format", read.input_format.clone());
    option("channel", read.channel.clone());
    option("time-column", read.time_column.clone());
    option("time-unit", read.time_unit.map(|unit| unit.name().into()));
    option("rate-hz", read.rate_hz.map(|rate| rate.to_string()));
    option("time-zero", read.time_zero.map(|zero| zero.to_string()));
    option("unit", read.unit.map(|unit| unit.name().into()));
    option(
        "opens-when",
        own.opens_when.map(|polarity| polarity.name().into()),
    );
    option(
        "bias",
        own.bias.map(|bias| match bias {
            BiasWindow::Window(start, end) => format!("{start}..{end}"),
            BiasWindow::None | BiasWindow::PreEvent => "none".into(),
        }),
    );
    option(
        "filter",
        own.filter.map(|filter| match filter {
            FilterChoice::Class(class) => class.name().into(),
            FilterChoice::None | FilterChoice::Default => "none".into(),
        }),
    );
    if own.filter_standard != crate::conditioning::FilterStandard::Iso6487 {
        option("filter-standard", Some(own.filter_standard.name().into()));
    }
    if let Resample::Hertz(hertz) = own.resample {
        option("resample", Some(hertz.to_string()));
    }
    option(
        "window",
        own.window
            .map(|window| format!("{}..{}", window.start_s, window.end_s)),
    );
    option(
        "design",
        own.design
            .as_ref()
            .and_then(|path| path.file_name())
            .map(|name| name.to_string_lossy().into_owned()),
    );
    for assignment in &own.set {
        option("set", Some(assignment.clone()));
    }
    if own.model != ModelArgument::Auto {
        option("model", Some(model_choice(own.model).name().into()));
    }
    let method = own.method.method(own.steps_per_period);
    if method != Method::EventDriven {
        option("method", Some(method.name().into()));
        option(
            "steps-per-period",
            method.steps_per_period().map(|steps| steps.to_string()),
        );
    }
    option(
        "tolerance",
        own.tolerance.map(|tolerance| tolerance.to_string()),
    );
    for assignment in &common.limit {
        option("limit", Some(assignment.clone()));
    }
    if own.members != MEMBERS_DEFAULT {
        option("members", Some(own.members.to_string()));
    }
    if own.seed != SEED_DEFAULT {
        option("seed", Some(own.seed.to_string()));
    }
    option("phi0", own.phi0.map(|angle| angle.to_string()));
    option("omega0", own.omega0.map(|velocity| velocity.to_string()));
    words
        .iter()
        .map(|word| quoted(word))
        .collect::<Vec<_>>()
        .join(" ")
}

/// Quotes a word for a POSIX shell where it needs it.
pub(super) fn quoted(word: &str) -> String {
    let plain = |c: char| {
        c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.' | '/' | '=' | ':' | ',' | '+')
    };
    if !word.is_empty() && word.chars().all(plain) {
        word.to_string()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}
