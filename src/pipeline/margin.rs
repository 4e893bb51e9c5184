//! How far a verdict is from changing, as a document.

use super::answer;
use super::place::{self, Decided};
use super::prepared::Prepared;
use latchgate_document::MarginDocument;
use latchgate_document::identity;
use latchgate_document::margin_document::Context;
use latchgate_document::request::MarginRequest;
use latchgate_kernel::model::Design;
use latchgate_kernel::parallel::Control;
use latchgate_recording::error::{Error, Place};
use latchgate_recording::{Limits, Source};
use latchgate_verdict::margin::{Basis, MarginOptions, Margins, margins};
use latchgate_verdict::{Answer, AssessDetail, AssessExtras, transfer};

/// A margin with what its report draws.
#[derive(Debug, Clone)]
pub struct MarginOutcome {
    /// The document.
    pub document: MarginDocument,
    /// What a report draws.
    pub margins: Margins,
}

/// Reads a recording and says how far its verdict is from changing.
///
/// # Examples
///
/// ```
/// use latchgate::pipeline::{Control, Design, Limits, MarginRequest, Source, margin};
///
/// let request: MarginRequest = serde_json::from_str(r#"{"members": 0}"#).unwrap();
/// let source = Source::File("signals/surviving.csv".into());
/// let (limits, control) = (Limits::default(), Control::unwatched(2));
/// let outcome = margin(&source, &request, &Design::reference(), &limits, &control)?;
/// assert!(outcome.document.number("scale_to_flip").is_some_and(|factor| factor > 1.0));
/// # Ok::<(), latchgate_recording::error::Error>(())
/// ```
///
/// # Errors
///
/// Those of [`Prepared::open`] and [`Prepared::margin`].
pub fn margin(
    source: &Source,
    request: &MarginRequest,
    design: &Design,
    limits: &Limits,
    control: &Control<'_>,
) -> Result<MarginOutcome, Error> {
    let prepared = Prepared::open(source, &request.replay, limits, control)
        .map_err(|refused| refused.error)?;
    prepared.margin(design, request, control)
}

impl Prepared {
    /// Says how far the verdict of `design` is from changing. Of `request` what is replayed is not
    /// read again: it is that with which the recording was opened.
    ///
    /// # Errors
    ///
    /// As [`margins`] and [`latchgate_verdict::assess()`].
    pub fn margin(
        &self,
        design: &Design,
        request: &MarginRequest,
        control: &Control<'_>,
    ) -> Result<MarginOutcome, Error> {
        let every = self.every()?;
        let extras = AssessExtras {
            detail: AssessDetail::Decision,
            ..AssessExtras::default()
        };
        let decided = every.iter().map(|prepared| {
            control.during(0.0, 0.05, |control| {
                prepared.decide(design, extras, control)
            })
        });
        let decided = decided.collect::<Result<Vec<_>, Error>>()?;
        let worst = transfer::index_of_worst(decided.iter().map(|decided| &decided.assessment));
        let facts = &every[worst].facts;
        // Channels and factors beside the worst: an advice must hold at every one.
        let mut others: Vec<(&Self, f64, bool)> = Vec::new();
        for (index, (prepared, decided)) in every.iter().zip(&decided).enumerate() {
            let at_worst = decided.transfer.as_ref().map_or(1.0, |block| block.worst);
            let factors = decided.transfer.as_ref().map_or_else(
                || vec![(1.0, decided.assessment.passes_with_word())],
                |block| {
                    let passes = block.answers.iter().map(|answer| *answer == Answer::Pass);
                    block.judged.iter().copied().zip(passes).collect()
                },
            );
            let is_other = |factor: f64| index != worst || factor.to_bits() != at_worst.to_bits();
            let factors = factors.into_iter().filter(|(factor, _)| is_other(*factor));
            others.extend(factors.map(|(factor, passes)| (*prepared, factor, passes)));
        }
        let Some(Decided {
            assessment,
            conditioned,
            transfer,
        }) = decided.into_iter().nth(worst)
        else {
            unreachable!("the recording itself is one of those that were decided");
        };
        let options = MarginOptions {
            policy: facts.request.policy(facts.polarity),
            basis: if facts.request.members == 0 {
                Basis::NominalRun
            } else {
                Basis::Verdict
            },
            passes_at_present: Some(assessment.passes_with_word()),
            counterweight_radius_m: request.counterweight_radius_m,
            limit: true,
        };
        let share = |index: usize| 0.05 + 0.95 * index as f64 / (others.len() + 1) as f64;
        let place = || Place::file(facts.recording.file.clone());
        let mut margins_found = control
            .during(share(0), share(1), |control| {
                margins(&conditioned, &facts.findings, design, &options, control)
            })
            .map_err(|error| error.at(place()))?;
        for (index, (prepared, factor, passes)) in others.iter().enumerate() {
            if margins_found.stopped {
                break;
            }
            let options = MarginOptions {
                passes_at_present: Some(*passes),
                limit: false,
                ..options.clone()
            };
            let samples = &prepared.at_factor(*factor).conditioned;
            let found = control
                .during(share(index + 1), share(index + 2), |control| {
                    margins(samples, &prepared.facts.findings, design, &options, control)
                })
                .map_err(|error| error.at(place()))?;
            margins_found.stopped = found.stopped;
            for (margin, other) in margins_found.answers.iter_mut().zip(found.answers) {
                let advice = margin.advice.clone();
                margin.advice = place::stricter(margin.quantity, advice, other.advice);
            }
        }
        let margins = margins_found;
        let channels = every
            .iter()
            .filter_map(|prepared| prepared.recording().channel.clone());
        let together: Vec<String> = channels.collect();
        let request = MarginRequest {
            replay: facts.request.clone(),
            ..request.clone()
        };
        let context = Context {
            report_id: identity::margin_id(&facts.recording, &request, design),
            verdict: assessment.answer,
            word_missing: assessment.word_missing,
            transfer,
            together,
            findings: facts.findings_with(assessment.findings),
            recording: facts.recording.clone(),
            conditioning: Some(facts.conditioning(&conditioned)),
            test: facts.test.clone(),
            request,
            run: answer::run_block(),
        };
        let document = MarginDocument::new(&margins, design, context);
        Ok(MarginOutcome { document, margins })
    }
}
