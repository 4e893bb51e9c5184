//! A recording that was read and conditioned once, to be judged with many designs.

use super::answer::{self, RecordingFacts};
use super::candidates::{self, Offer};
use super::place::{self, Decided};
use latchgate_document::Document;
use latchgate_document::blocks::RecordingBlock;
use latchgate_document::request::Request;
use latchgate_kernel::model::Design;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::units::STANDARD_GRAVITY;
use latchgate_recording::card::CardFile;
use latchgate_recording::error::{Error, ErrorKind, Place};
use latchgate_recording::{Channel, Finding, Limits, ReadOptions, Reading, Selection, Source};
use latchgate_report::terminal::{Look, PIPED};
use latchgate_report::text;
use latchgate_verdict::assess::assess_again;
use latchgate_verdict::conditioning::{self, Conditioned};
use latchgate_verdict::in_plane::InPlane;
use latchgate_verdict::margin::{self, Advice, Quantity};
use latchgate_verdict::readings::ReadingCache;
use latchgate_verdict::sled;
use latchgate_verdict::{Answer, Assessment, Evidence, Policy};
use std::fmt;
use std::sync::Arc;

/// What is worked out beside the verdict and costs more than it; none of it changes the verdict.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Extras {
    /// The nominal runs' answer after each filter.
    pub filter_table: bool,
    /// The preload from which on the recording passes.
    pub preload_answer: bool,
    /// What a report draws.
    pub evidence: bool,
}

/// Runs, of levers one by one, that the search for a preload takes of each stop and polarity, about.
const PRELOAD_RUNS: u64 = 2000;

/// Times as long as a lever alone takes one beside a catch, since varied levers beside a catch are followed one by
/// one.
const CATCH_TIMES: u64 = 10;

/// An answer: the document, what a report draws, and why nothing could be judged.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The document; one that says `unusable` where `refusal` says why.
    pub document: Document,
    /// What a report draws, if that was asked for.
    pub evidence: Option<Evidence>,
    /// The error that left nothing to judge; see [`Self::was_stopped`].
    pub refusal: Option<Error>,
    /// The channels to choose from, where several could be meant.
    pub offers: Vec<Offer>,
}

impl Outcome {
    /// Returns the files of the report, names with bytes: page, document and plots, the page
    /// first; none where the work was stopped, which says nothing of the recording.
    ///
    /// # Examples
    ///
    /// ```
    /// use latchgate::pipeline::{Control, Design, Extras, Limits, Request, Source, judge};
    ///
    /// let outcome = judge(
    ///     &Source::bytes("empty.csv", *b""),
    ///     &Request::default(),
    ///     &Design::reference(),
    ///     Extras::default(),
    ///     &Limits::default(),
    ///     &Control::default(),
    /// );
    /// let names: Vec<String> = outcome.files().into_iter().map(|(name, _)| name).collect();
    /// assert_eq!(names, ["report.html", "verdict.json"]);
    /// ```
    pub fn files(&self) -> Vec<(String, Vec<u8>)> {
        if self.was_stopped() {
            return Vec::new();
        }
        latchgate_report::files(&self.document, self.evidence.as_ref())
    }

    /// Tells whether the work was stopped before its end: there is no answer, and the document,
    /// which has no identity, is not to be kept.
    pub fn was_stopped(&self) -> bool {
        let stopped = |error: &Error| error.is_stopped();
        self.refusal.as_ref().is_some_and(stopped)
    }
}

/// The terminal's text, without colours.
impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let look = Look {
            width: Some(PIPED),
            ..Look::default()
        };
        f.write_str(&text::render(&self.document, None, look))
    }
}

/// A recording that could not be read or conditioned.
#[derive(Debug, Clone)]
pub struct Refused {
    /// Why.
    pub error: Error,
    /// The channels to choose from, where several could be meant.
    pub offers: Vec<Offer>,
    facts: RecordingFacts,
}

impl Refused {
    /// Returns what is known of the recording.
    pub fn recording(&self) -> &RecordingBlock {
        &self.facts.recording
    }

    pub(super) fn facts(&self) -> &RecordingFacts {
        &self.facts
    }

    /// Returns the answer for a design: a document that says why there is none.
    pub fn outcome(self, design: &Design) -> Outcome {
        Outcome {
            document: answer::refused(&self.facts, None, design, &self.error),
            evidence: None,
            refusal: Some(self.error),
            offers: self.offers,
        }
    }

    /// Notes which channel was asked for, where reading did not come so far.
    pub(super) fn name_channel(&mut self, name: &str) {
        let channel = &mut self.facts.recording.channel;
        *channel = channel.take().or_else(|| Some(name.to_string()));
    }

    pub(super) fn facts_mut(&mut self) -> &mut RecordingFacts {
        &mut self.facts
    }
}

/// A recording that was read and conditioned as a request asks.
#[derive(Debug, Clone)]
pub struct Prepared {
    pub(super) facts: RecordingFacts,
    pub(super) conditioned: Conditioned,
    /// Other readings of the samples, for every design.
    readings: Arc<ReadingCache>,
    /// The other lateral channels of that side, where they are judged together.
    pub(super) siblings: Arc<Vec<Result<Self, Box<Refused>>>>,
}

impl Prepared {
    /// Reads the recording with its card and neighbours, and conditions the channel that is meant.
    ///
    /// `limits` hold but where the request changes them. The numbers do not depend on `control`.
    ///
    /// # Errors
    ///
    /// [`Refused`] with any [`ErrorKind`] of reading and conditioning, or of [`Request::check`];
    /// [`Stopped`](latchgate_kernel::error::Error::Stopped) if `control` ends the work.
    ///
    /// # Examples
    ///
    /// ```
    /// use latchgate::pipeline::{Control, Limits, Prepared, Request, Source};
    ///
    /// let (request, limits, control) = (Request::default(), Limits::default(), Control::default());
    /// let open = |source: &Source| Prepared::open(source, &request, &limits, &control);
    /// assert!(open(&Source::File("signals/burst.csv".into())).is_ok());
    /// let refused = open(&Source::bytes("empty.csv", *b"")).unwrap_err();
    /// assert!(refused.error.to_string().starts_with("empty.csv: the file is empty"));
    /// ```
    pub fn open(
        source: &Source,
        request: &Request,
        limits: &Limits,
        control: &Control<'_>,
    ) -> Result<Self, Box<Refused>> {
        let facts = RecordingFacts::new(request, source);
        let (mut prepared, siblings) = Self::open_one(source, facts, limits, control)?;
        prepared.open_siblings(source, &siblings, limits, control)?;
        Ok(prepared)
    }

    /// Reads and conditions one channel; returns the names of its siblings with it, where they are asked for.
    pub(super) fn open_one(
        source: &Source,
        mut facts: RecordingFacts,
        limits: &Limits,
        control: &Control<'_>,
    ) -> Result<(Self, Vec<String>), Box<Refused>> {
        let mut offers = Vec::new();
        let mut siblings = Vec::new();
        let asked = (&mut offers, &mut siblings);
        match read(source, limits, control, &mut facts, asked) {
            Ok(conditioned) => Ok((
                Self {
                    facts,
                    conditioned,
                    readings: Arc::default(),
                    siblings: Arc::default(),
                },
                siblings,
            )),
            Err(error) => {
                if facts.recording.sha256.is_none() {
                    facts.recording.sha256 = source.sha256_within(limits.text_bytes);
                }
                Err(Box::new(Refused {
                    error,
                    offers,
                    facts,
                }))
            }
        }
    }

    /// Returns the hash that names the report of this recording and `design`: the same question
    /// has the same one, any other another.
    ///
    /// # Examples
    ///
    /// ```
    /// use latchgate::pipeline::{Control, Design, Limits, Prepared, Request, Source};
    ///
    /// let source = Source::File("signals/burst.csv".into());
    /// let (limits, control) = (Limits::default(), Control::default());
    /// let prepared = Prepared::open(&source, &Request::default(), &limits, &control).unwrap();
    /// let paper = Design::reference();
    /// let mut heavier = Design::reference();
    /// heavier.override_number("lever.mass_kg", 0.16)?;
    /// assert_eq!(prepared.report_id(&paper), prepared.report_id(&paper));
    /// assert_ne!(prepared.report_id(&paper), prepared.report_id(&heavier));
    /// # Ok::<(), latchgate::pipeline::KernelError>(())
    /// ```
    pub fn report_id(&self, design: &Design) -> String {
        self.facts.report_id(design)
    }

    /// Returns the other readings of its samples.
    pub(super) fn readings(&self) -> &ReadingCache {
        &self.readings
    }

    /// Returns what was read.
    pub fn recording(&self) -> &RecordingBlock {
        &self.facts.recording
    }

    /// Returns what was found odd so far, by reading and conditioning.
    pub fn findings(&self) -> &[Finding] {
        &self.facts.findings
    }

    /// Replays the lever of `design` and decides, of every channel that is judged with this one.
    pub fn judge(&self, design: &Design, extras: Extras, control: &Control<'_>) -> Outcome {
        if !self.facts.request.siblings {
            return self.judge_alone(design, extras, control);
        }
        let mut outcome = self.judge_siblings(design, extras, control);
        if extras.preload_answer && outcome.refusal.is_none() {
            let advised =
                control.unmeasured(|control| self.advise(design, &mut outcome.document, control));
            if let Err(error) = advised {
                return Outcome {
                    document: answer::refused(&self.facts, None, design, &error),
                    evidence: None,
                    refusal: Some(error),
                    offers: Vec::new(),
                };
            }
        }
        outcome
    }

    /// Replays the lever of `design` on this channel alone.
    pub(super) fn judge_alone(
        &self,
        design: &Design,
        extras: Extras,
        control: &Control<'_>,
    ) -> Outcome {
        // The search for a preload makes more runs than the verdict.
        let share = if extras.preload_answer { 0.3 } else { 1.0 };
        let assessed = control.during(0.0, share, |control| self.assess(design, extras, control));
        let assessed = assessed.and_then(|(document, evidence)| {
            let mut document = document;
            if extras.preload_answer {
                control.during(share, 1.0, |control| {
                    self.advise(design, &mut document, control)
                })?;
            }
            Ok((document, evidence))
        });
        let (document, evidence, refusal) = match assessed {
            Ok((document, evidence)) => (document, evidence, None),
            Err(error) => {
                let conditioned = Some(&self.conditioned);
                let document = answer::refused(&self.facts, conditioned, design, &error);
                (document, None, Some(error))
            }
        };
        Outcome {
            document,
            evidence,
            refusal,
            offers: Vec::new(),
        }
    }

    fn assess(
        &self,
        design: &Design,
        extras: Extras,
        control: &Control<'_>,
    ) -> Result<(Document, Option<Evidence>), Error> {
        let own = latchgate_verdict::AssessExtras {
            filter_table: extras.filter_table,
            evidence: extras.evidence,
            ..latchgate_verdict::AssessExtras::default()
        };
        let Decided {
            mut assessment,
            conditioned,
            transfer,
        } = self.decide(design, own, control)?;
        let mut evidence = assessment.evidence.take();
        let mut document =
            answer::answered(&self.facts, &conditioned, design, assessment, transfer);
        if self.facts.request.sled206 {
            let checked = sled::check(&self.conditioned, &document.findings)
                .map_err(|error| error.at(self.place()));
            let (check, filtered) = checked?;
            document.sled206 = Some(check);
            if let Some(evidence) = &mut evidence {
                evidence.sled206 = Some(filtered);
            }
        }
        Ok((document, evidence))
    }

    /// Adds to the `document` of a verdict the preload from which on the recording passes, as
    /// [`Self::margin`] advises it, and of a pass the restitution up to which it does; nothing where a fault
    /// spoils the samples, or where a search would take more work than a verdict may.
    ///
    /// # Errors
    ///
    /// As [`margin::advice`].
    pub fn advise(
        &self,
        design: &Design,
        document: &mut Document,
        control: &Control<'_>,
    ) -> Result<(), Error> {
        let preload = self.advice(Quantity::Preload, design, document, control)?;
        if document.verdict == Answer::Pass && preload.is_some() {
            let restitution = self.advice(Quantity::Restitution, design, document, control)?;
            document.restitution_answer = restitution;
        }
        document.preload_answer = preload;
        Ok(())
    }

    /// Returns the advice that holds for every channel that is judged, at every factor between the sensor's place
    /// and the latch.
    fn advice(
        &self,
        quantity: Quantity,
        design: &Design,
        document: &Document,
        control: &Control<'_>,
    ) -> Result<Option<Advice>, Error> {
        let policy = self.facts.request.policy(self.facts.polarity);
        let Some(run) = &document.nominal else {
            return Ok(None);
        };
        let factors = self.factors();
        let mut runs = PRELOAD_RUNS * (document.answers.len() * factors.len()) as u64;
        runs *= 1 + self.siblings.len() as u64;
        if design.catch.is_some() {
            runs *= CATCH_TIMES;
        }
        // A lever that rests at present may move at every sample with another preload.
        let samples = self.conditioned.used.samples.len() as u64;
        if runs.saturating_mul(run.work.counted().max(samples)) > policy.work {
            return Ok(None);
        }
        let is_one = factors.len() == 1 && self.siblings.is_empty();
        // A verdict that waits for a person's word is asked anew, as if that had been said.
        let passes = (is_one && document.verdict == Answer::Pass).then_some(true);
        let mut advice: Option<Advice> = None;
        let siblings = self.siblings.iter().map(Result::as_ref);
        for prepared in std::iter::once(Ok(self)).chain(siblings) {
            let Ok(prepared) = prepared else {
                return Ok(None);
            };
            for factor in &factors {
                let found = margin::advice(
                    quantity,
                    &prepared.at_factor(*factor).conditioned,
                    &prepared.facts.findings,
                    design,
                    &policy,
                    passes,
                    control,
                );
                let found = found.map_err(|error| error.at(prepared.place()))?;
                let Some(found) = found else {
                    return Ok(None);
                };
                advice = Some(match advice {
                    Some(before) => place::stricter(quantity, before, found),
                    None => found,
                });
            }
        }
        Ok(advice)
    }

    /// Returns the same recording with other samples.
    pub(super) fn with_samples(&self, conditioned: Conditioned) -> Self {
        Self {
            facts: self.facts.clone(),
            conditioned,
            readings: Arc::default(),
            siblings: Arc::default(),
        }
    }

    /// Decides by the whole rule, the samples being the acceleration at the latch, with so much `work`.
    pub(super) fn decide_at_latch(
        &self,
        design: &Design,
        extras: latchgate_verdict::AssessExtras,
        work: u64,
        control: &Control<'_>,
    ) -> Result<Assessment, Error> {
        let RecordingFacts {
            request,
            findings,
            polarity,
            ..
        } = &self.facts;
        request.check_design(design)?;
        self.check_second_axis(design)
            .map_err(|error| error.at(self.place()))?;
        let policy = Policy {
            work,
            ..request.policy(*polarity)
        };
        let (conditioned, own) = (&self.conditioned, (extras, &*self.readings));
        assess_again(conditioned, findings, design, &policy, own, control)
            .and_then(|mut assessment| {
                self.hold_against_defaults(design, &mut assessment, control)?;
                Ok(assessment)
            })
            .map_err(|error| error.at(self.place()))
    }

    /// Refuses a second channel whose stated axis is not the one that the lever's plane needs.
    fn check_second_axis(&self, design: &Design) -> Result<(), Error> {
        let Some(second) = &self.conditioned.second else {
            return Ok(());
        };
        let needed = InPlane::of(&design.lever)?.second_axis;
        match second.axis.filter(|axis| *axis != needed) {
            None => Ok(()),
            Some(axis) => Err(Error::malformed(
                format!("a channel along {needed}, the second axis of the lever's plane"),
                format!("{}, along {axis}", second.name),
                "name the other channel with the setting `radial_channel`",
            )),
        }
    }

    pub(super) fn place(&self) -> Place {
        let place = Place::file(self.facts.recording.file.clone());
        match &self.facts.recording.channel {
            Some(channel) => place.channel(channel.clone()),
            None => place,
        }
    }
}

/// Reads and conditions, noting in `facts` what became known on the way.
fn read(
    source: &Source,
    limits: &Limits,
    control: &Control<'_>,
    facts: &mut RecordingFacts,
    (offers, siblings): (&mut Vec<Offer>, &mut Vec<String>),
) -> Result<Conditioned, Error> {
    facts.request.check()?;
    let limits = &facts.request.limits(limits)?;
    // Every limit that holds is part of the question, whoever changed it.
    facts.request.limits = limits.changed();
    if let Some(file) = CardFile::beside(source, limits)? {
        facts.recording.card_sha256 = Some(file.sha256());
        facts.declare(file.read()?);
    }
    control.check()?;
    let options = facts.request.read_options(&facts.card);
    let Reading { chosen, every } =
        latchgate_recording::read_both(source, &options, limits, control);
    control.check()?;
    let recording = chosen.inspect_err(|error| {
        let channels = every.as_ref().map_or(&[][..], |every| &every.channels);
        let by_card = facts.place_by_card();
        let only = channels.first().filter(|_| channels.len() == 1);
        facts.recording.place = by_card.or(only.and_then(latchgate_recording::place_of));
        *offers = candidates::offers(error, channels);
    })?;
    let several = options.channel.is_some()
        || recording
            .findings
            .iter()
            .any(|finding| finding.code == "channel-chosen");
    facts.recording.sha256 = Some(recording.sha256);
    facts.recording.parts = recording.parts;
    facts.recording.format = Some(recording.format.into());
    facts.findings = recording.findings;
    let Some(channel) = recording.channels.into_iter().next() else {
        return Err(Error::from(ErrorKind::NoChannel {
            known: "none".into(),
        })
        .at(Place::file(source.name())));
    };
    facts
        .describe(&channel)
        .map_err(|error| error.at(Place::file(source.name())))?;
    facts.findings.extend(channel.findings.iter().cloned());
    let of_place = place::findings(facts, &channel);
    facts.findings.extend(of_place);
    let every = every.as_ref().map(|every| every.channels.as_slice());
    if facts.request.siblings {
        let channels = every.map_err(Clone::clone)?.iter();
        let others = channels.filter(|other| latchgate_recording::is_sibling(&channel, other));
        siblings.extend(others.map(|other| other.name.clone()));
    }
    facts.findings.extend(neighbours(&channel, every, several));
    let options = facts.request.conditioning_options(&facts.card);
    let mut conditioned = conditioning::condition(&channel, &options)
        .map_err(|error| error.at(Place::file(source.name())))?;
    if let Some(read_options) = facts.request.radial_read_options(&facts.card) {
        let second = second_channel(source, &channel, &read_options, limits, facts)?;
        conditioned = conditioning::with_second(conditioned, &channel, &second, &options)
            .map_err(|error| error.at(Place::file(source.name())))?;
    } else {
        conditioned.neighbours =
            conditioning::neighbours::of_other_axes(every.unwrap_or(&[]), &channel);
    }
    if let Some(peak) = conditioning::peak(&conditioned.raw) {
        facts.recording.peak_g = Some(conditioned.raw.samples[peak].abs() / STANDARD_GRAVITY);
        facts.recording.peak_time_s = Some(conditioned.raw.time_s(peak));
    }
    facts.recording.velocity_change_m_s = Some(conditioned.velocity_change_m_s);
    facts.findings.extend(conditioned.findings.iter().cloned());
    Ok(conditioned)
}

/// Reads the second in-plane channel, and notes what is odd about it.
fn second_channel(
    source: &Source,
    judged: &Channel,
    options: &ReadOptions,
    limits: &Limits,
    facts: &mut RecordingFacts,
) -> Result<Channel, Error> {
    let refuse = |expected: String, found: String, hint: &str| {
        Error::malformed(expected, found, hint).at(Place::file(source.name()))
    };
    let recording = latchgate_recording::read(source, options, Selection::Lateral, limits)?;
    let second = recording.channels.first().cloned();
    let mut second = second.ok_or_else(|| {
        Error::from(ErrorKind::NoChannel {
            known: "none".into(),
        })
    })?;
    if judged.pulse.is_some() || second.values == judged.values || second.name == judged.name {
        return Err(refuse(
            "two channels of one recording".into(),
            format!("{} and {}, alike", judged.name, second.name),
            "name the channel across the judged one with the setting `radial_channel`",
        ));
    }
    let stated = latchgate_recording::axis_of(judged);
    if let Some(axis) = stated.filter(|axis| axis.letter != 'Y') {
        return Err(refuse(
            "Y, the lateral axis, of the judged channel beside a second one".into(),
            format!("{} of {}", axis.letter, judged.name),
            "judge the lateral channel, and name the other one with the setting `radial_channel`",
        ));
    }
    if latchgate_recording::axis_of(&second).is_none() {
        return Err(refuse(
            "an axis in the code or name of the second channel, such as acc_x".into(),
            second.name.clone(),
            "name the column after its axis: nothing else says which way it counts",
        ));
    }
    if !latchgate_recording::is_same_place(judged, &second) {
        return Err(refuse(
            format!(
                "a channel of the place of {}, named alike but for the axis",
                judged.name
            ),
            second.name.clone(),
            "choose the sensor beside the judged one with the setting `radial_channel`",
        ));
    }
    if latchgate_recording::axis_of(&second).is_some_and(|axis| axis.is_reversed) {
        // Across, the sign is that of SAE J211.
        second.values.iter_mut().for_each(|value| *value = -*value);
    }
    // That it is not the lateral one is what it is for.
    let telling = |finding: &&Finding| {
        !["channel-not-lateral", "channel-chosen", "sign-diverges"].contains(&&*finding.code)
    };
    for finding in second
        .findings
        .iter()
        .chain(&recording.findings)
        .filter(telling)
    {
        if facts
            .findings
            .iter()
            .any(|known| known.text == finding.text)
        {
            continue;
        }
        let mut finding = finding.clone();
        finding.text = format!("`{}`: {}", second.name, finding.text);
        facts.findings.push(finding);
    }
    Ok(second)
}

/// Returns what the recording's other channels say against the one that is judged, if one of `several`
/// was to be chosen, and what gravity says of its unit; or that they could not be read for it, which is
/// no fault of this one.
fn neighbours(channel: &Channel, every: Result<&[Channel], &Error>, several: bool) -> Vec<Finding> {
    let all = match every {
        Ok(all) => all,
        Err(_) if !several && !channel.stated.gravity => return Vec::new(),
        Err(error) => {
            return vec![Finding::info(
                "neighbours-unread",
                format!("the other channels were not compared with this one: {error}"),
            )];
        }
    };
    let same = |other: &Channel| other.name == channel.name && other.values == channel.values;
    let Some(index) = all.iter().position(same) else {
        return Vec::new();
    };
    let beside = match several {
        true => conditioning::neighbours::findings(all),
        false => Vec::new(),
    };
    let own = beside.into_iter().filter(|(of, _)| *of == index);
    own.map(|(_, finding)| finding)
        .chain(conditioning::neighbours::gravity(all, index))
        .collect()
}
