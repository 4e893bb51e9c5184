//! What is known of a recording and what was found, put together as a document.

use latchgate_document::blocks::{
    ConditioningBlock, Document, InPlaneBlock, RecordingBlock, RunBlock, TransferBlock,
};
use latchgate_document::identity;
use latchgate_document::request::{PolaritySource, Request};
use latchgate_kernel::model::Design;
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::STANDARD_GRAVITY;
use latchgate_recording::card::CardPolarity;
use latchgate_recording::error::Error;
use latchgate_recording::setting::Setting;
use latchgate_recording::{Card, Channel, Finding, SensorPlace, Severity, Source, TestFacts};
use latchgate_verdict::conditioning::{self, Between, Conditioned, SecondSensor, cfc};
use latchgate_verdict::in_plane::InPlane;
use latchgate_verdict::{
    Answer, Assessment, ErrorBudget, NOMINAL_DECISION_RULE, Polarity, Reason, Screens,
    decision_rule, wording,
};
use std::collections::BTreeMap;

/// What is known of a recording, as far as reading it came.
#[derive(Debug, Clone)]
pub(super) struct RecordingFacts {
    pub(super) request: Request,
    pub(super) card: Card,
    pub(super) recording: RecordingBlock,
    pub(super) findings: Vec<Finding>,
    pub(super) polarity: Polarity,
    pub(super) test: TestFacts,
    /// Axis of the channel, X, Y or Z, where it is known.
    pub(super) axis: Option<char>,
    /// The card states the place of another channel of the file.
    pub(super) is_sibling: bool,
}

impl RecordingFacts {
    pub(super) fn new(request: &Request, source: &Source) -> Self {
        let mut facts = Self {
            request: request.clone(),
            card: Card::default(),
            recording: RecordingBlock {
                file: source.name(),
                ..RecordingBlock::default()
            },
            findings: Vec::new(),
            polarity: Polarity::Undeclared,
            test: TestFacts::default(),
            axis: None,
            is_sibling: false,
        };
        // Without a card, what the request declares holds.
        facts.declare(Card::default());
        facts
    }

    /// Takes the card in, and with it who declares which sign opens.
    pub(super) fn declare(&mut self, card: Card) {
        let (polarity, source) = self.request.polarity(&card);
        self.polarity = polarity;
        self.recording.opens_when = self.request.opens_when.or(card.opens_when);
        self.recording.opens_when_source = source;
        self.card = card;
    }

    pub(super) fn describe(&mut self, channel: &Channel) -> Result<(), Error> {
        if let Some(pulse) = &channel.pulse {
            let stated = self.request.opens_when.unwrap_or(pulse.opens_when);
            if pulse.opens_when != CardPolarity::Both && stated != pulse.opens_when {
                let found = format!("{} = {}", Setting::OpensWhen, stated.name());
                return Err(Error::malformed(
                    format!(
                        "the direction of the pulse's word, {}",
                        pulse.opens_when.name()
                    ),
                    found,
                    "change the word, or leave the setting out",
                ));
            }
            self.declare(Card {
                opens_when: Some(pulse.opens_when),
                synthetic: true,
                ..Card::default()
            });
            if self.recording.opens_when_source == PolaritySource::Card {
                self.recording.opens_when_source = PolaritySource::Pulse;
            }
        }
        self.doubt_synthetic(channel);
        self.test = self.card.test.clone().or(channel.stated.test.clone());
        let is_pulse = channel.pulse.is_some();
        let axis = latchgate_recording::axis_of(channel).filter(|_| !is_pulse);
        self.axis = axis.map(|axis| axis.letter);
        let by_card = self.place_by_card();
        let block = &mut self.recording;
        block.place = by_card.or(latchgate_recording::place_of(channel));
        block.channel = Some(channel.name.clone());
        block.unit = channel.unit;
        block.unit_source = Some(channel.unit_source.into());
        block.content_sha256 = channel.content_sha256();
        block.samples = channel.values.len();
        block.sample_rate_hz = Some(channel.rate.hertz());
        block.start_s = Some(channel.start_s);
        block.end_s = Some(channel.time_s(channel.values.len().saturating_sub(1)));
        Ok(())
    }

    /// Judges as measured what a card calls synthetic though its file names the place of a sensor.
    fn doubt_synthetic(&mut self, channel: &Channel) {
        // Whoever writes a table by formula may name its columns by any code.
        let is_table = self.recording.format.as_deref() == Some("csv");
        let names_a_place = !is_table && latchgate_recording::place_of(channel).is_some();
        let place = channel.stated.location.as_ref();
        let place = place.or(names_a_place.then_some(&channel.name));
        let Some(place) = place.filter(|_| self.card.synthetic && channel.pulse.is_none()) else {
            return;
        };
        self.card.synthetic = false;
        let text = format!(
            "the card calls the recording synthetic, and the file names the place of a sensor, `{place}`. It is judged \
             as measured. Remove `synthetic = true` from the card, or the place from the file"
        );
        self.findings
            .push(Finding::warning("synthetic-contradicted", text));
    }

    /// Returns the place that the card states of this channel.
    pub(super) fn place_by_card(&self) -> Option<SensorPlace> {
        self.card.place.filter(|_| !self.is_sibling)
    }

    pub(super) fn report_id(&self, design: &Design) -> String {
        identity::report_id(&self.recording, &self.request, design)
    }

    /// Returns how the channel was conditioned.
    pub(super) fn conditioning(&self, conditioned: &Conditioned) -> ConditioningBlock {
        let used = &conditioned.used;
        let peak = conditioning::peak(used);
        ConditioningBlock {
            bias_m_s2: conditioned.bias_m_s2,
            bias_standard_error_m_s2: conditioned.bias_standard_error_m_s2,
            bias_standard_error_method: wording::bias_method().into(),
            bias_samples: conditioned.bias_samples,
            bias_window_s: conditioned
                .bias_window_s
                .map(|window| (window.from_s, window.until_s)),
            filter: conditioned.filter,
            filter_standard: conditioned.filter_standard,
            filter_design_frequency_hz: conditioned
                .filter
                .map(|filter| cfc::design_frequency_hz(filter, conditioned.filter_standard)),
            filter_end_treatment: conditioned
                .filter
                .map(|_| cfc::end_treatment(conditioned.filter_standard).into()),
            resample_hz: conditioned.resample_hz,
            between: match conditioned.is_exact() && self.request.between != Between::Linear {
                true => Between::Exact,
                false => self.request.between,
            },
            noise_m_s2: conditioned.noise.deviation_m_s2,
            peak_g: peak.map(|peak| used.samples[peak].abs() / STANDARD_GRAVITY),
            peak_time_s: peak.map(|peak| used.time_s(peak)),
            range_g: self.card.range_g,
            synthetic: self.card.synthetic,
        }
    }

    /// Returns the findings with those of the replay, the worst first; within a severity those of
    /// the question, then in the order of the line from file to replay.
    pub(super) fn findings_with(&self, of_replay: Vec<Finding>) -> Vec<Finding> {
        let mut findings = self.findings.clone();
        findings.extend(of_replay);
        // What the question itself makes doubtful is read before what the recording does.
        let of_question = ["design-implausible", "setting-decides"];
        findings.sort_by_key(|finding| {
            let place = of_question.iter().position(|code| *code == finding.code);
            // Then what a pass waits for.
            let place = place.unwrap_or(of_question.len() + usize::from(!finding.needs_word));
            (std::cmp::Reverse(finding.severity), place)
        });
        findings
    }
}

/// Returns what is known of the second in-plane channel, if there is one.
fn in_plane(
    conditioned: &Conditioned,
    polarity: Polarity,
    design: &Design,
) -> Option<InPlaneBlock> {
    let SecondSensor {
        name,
        conditioned,
        judged_is_reversed,
        ..
    } = conditioned.second.as_deref()?;
    let directions = InPlane::of(&design.lever).ok()?;
    let used = &conditioned.used;
    let peak = conditioning::peak(used);
    Some(InPlaneBlock {
        radial_channel: name.clone(),
        directions,
        door: match polarity.signs() {
            [sign] => Some(directions.door(*sign, *judged_is_reversed).into()),
            _ => None,
        },
        bias_m_s2: conditioned.bias_m_s2,
        bias_standard_error_m_s2: conditioned.bias_standard_error_m_s2,
        noise_m_s2: conditioned.noise.deviation_m_s2,
        peak_g: peak.map(|peak| used.samples[peak].abs() / STANDARD_GRAVITY),
        peak_time_s: peak.map(|peak| used.time_s(peak)),
    })
}

/// Returns the version of this program; day, maker and time are the caller's to tell.
pub(crate) fn run_block() -> RunBlock {
    RunBlock {
        version: env!("CARGO_PKG_VERSION").into(),
        numbers_revision: Some(identity::NUMBERS_REVISION),
        date: None,
        by: None,
        design_file: None,
        design_file_sha256: None,
        elapsed_s: 0.0,
    }
}

/// The document of an assessment.
pub(super) fn answered(
    facts: &RecordingFacts,
    conditioned: &Conditioned,
    design: &Design,
    assessment: Assessment,
    transfer: Option<TransferBlock>,
) -> Document {
    let empty = empty(facts, Some(conditioned), design);
    let decision_rule = match assessment.varied {
        Some(_) => empty.decision_rule.clone(),
        None => NOMINAL_DECISION_RULE.as_str().into(),
    };
    Document {
        decision_rule,
        verdict: assessment.answer,
        why: assessment.why,
        nominal: Some(assessment.nominal),
        models: assessment.models,
        polarities: assessment.polarities,
        answers: assessment.answers,
        opens: assessment.opens,
        opens_by_direction: assessment.openings,
        ensemble: assessment.ensemble,
        ensembles: assessment.ensembles,
        mechanism: assessment.mechanism,
        transfer,
        what_if: assessment.what_if,
        filters: assessment.filters,
        error_budget_rad: assessment.budget,
        findings: facts.findings_with(assessment.findings),
        ..empty
    }
}

/// The document of a recording that could not be read, conditioned or replayed.
pub(super) fn refused(
    facts: &RecordingFacts,
    conditioned: Option<&Conditioned>,
    design: &Design,
    error: &Error,
) -> Document {
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
    let mut document = Document {
        why,
        findings,
        ..empty(facts, conditioned, design)
    };
    if error.is_stopped() {
        // No answer to the question: it must not be found under the question's name.
        document.report_id = String::new();
    }
    document
}

/// Returns the signal of a recording that alone drives the lever.
fn lone_signal(conditioned: Option<&Conditioned>) -> Option<&Signal> {
    let alone = conditioned.filter(|conditioned| conditioned.second.is_none());
    alone.map(|conditioned| &conditioned.used)
}

/// The document with nothing in it but what is known before a lever is replayed.
fn empty(facts: &RecordingFacts, conditioned: Option<&Conditioned>, design: &Design) -> Document {
    Document {
        schema: "latchgate.verdict/1".into(),
        report_id: facts.report_id(design),
        verdict: Answer::Unusable,
        why: Vec::new(),
        threshold_rad: design.criterion.threshold_rad,
        nominal: None,
        models: BTreeMap::new(),
        polarities: BTreeMap::new(),
        answers: Vec::new(),
        opens: None,
        opens_by_direction: BTreeMap::new(),
        ensemble: None,
        ensembles: Vec::new(),
        preload_answer: None,
        restitution_answer: None,
        sled206: None,
        in_plane: conditioned.and_then(|conditioned| in_plane(conditioned, facts.polarity, design)),
        mechanism: None,
        transfer: None,
        siblings: Vec::new(),
        what_if: Vec::new(),
        error_budget_rad: ErrorBudget::default(),
        screens: Screens::of(design, lone_signal(conditioned)),
        filters: Vec::new(),
        findings: Vec::new(),
        recording: facts.recording.clone(),
        conditioning: conditioned.map(|conditioned| facts.conditioning(conditioned)),
        design: design.clone(),
        decision_rule: if facts.request.members == 0 {
            NOMINAL_DECISION_RULE.as_str().into()
        } else {
            decision_rule(&design.criterion).into()
        },
        test: facts.test.clone(),
        request: facts.request.clone(),
        run: RunBlock {
            by: facts.card.by.clone(),
            ..run_block()
        },
    }
}
