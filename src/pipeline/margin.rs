//! How far a verdict is from changing, as a document.

use super::answer;
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
use latchgate_verdict::{AssessDetail, AssessExtras};

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
        let facts = &self.facts;
        let assessment = control.during(0.0, 0.05, |control| {
            let extras = AssessExtras {
                detail: AssessDetail::Answer,
                ..AssessExtras::default()
            };
            self.decide(design, extras, control)
        })?;
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
        let margins = control
            .during(0.05, 1.0, |control| {
                margins(
                    &self.conditioned,
                    &facts.findings,
                    design,
                    &options,
                    control,
                )
            })
            .map_err(|error| error.at(Place::file(facts.recording.file.clone())))?;
        let request = MarginRequest {
            replay: facts.request.clone(),
            ..request.clone()
        };
        let context = Context {
            report_id: identity::margin_id(&facts.recording, &request, design),
            verdict: assessment.answer,
            word_missing: assessment.word_missing,
            findings: facts.findings_with(assessment.findings),
            recording: facts.recording.clone(),
            conditioning: Some(facts.conditioning(&self.conditioned)),
            test: facts.test.clone(),
            request,
            run: answer::run_block(),
        };
        let document = MarginDocument::new(&margins, design, context);
        Ok(MarginOutcome { document, margins })
    }
}
