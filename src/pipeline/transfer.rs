//! The verdict over every factor between the sensor's place and the latch.

use super::place::{Decided, axis_finding, reason};
use super::prepared::Prepared;
use latchgate_document::blocks::TransferBlock;
use latchgate_kernel::model::Design;
use latchgate_kernel::parallel::Control;
use latchgate_recording::TransferRange;
use latchgate_recording::card::AcceptedWord;
use latchgate_recording::error::Error;
use latchgate_verdict::{AssessDetail, AssessExtras, transfer};
use std::borrow::Cow;

impl Prepared {
    /// True if the channel is known not to be lateral, and nobody says that it may be so.
    pub fn is_across(&self) -> bool {
        let facts = &self.facts;
        let is_accepted = facts.request.accepts(&facts.card, AcceptedWord::Axis);
        facts.axis.is_some_and(|axis| axis != 'Y') && !facts.card.synthetic && !is_accepted
    }

    /// Returns the factors to judge between the sensor's place and the latch.
    pub(super) fn factors(&self) -> Vec<f64> {
        let stated = self.facts.request.transfer(&self.facts.card);
        transfer::factors(stated.map_or(TransferRange::ONE, |(range, _)| range))
    }

    /// Returns the recording as it is at a factor between the sensor's place and the latch.
    pub(super) fn at_factor(&self, factor: f64) -> Cow<'_, Self> {
        if factor.to_bits() == 1.0_f64.to_bits() {
            return Cow::Borrowed(self);
        }
        Cow::Owned(self.with_samples(self.conditioned.at_factor(factor)))
    }

    /// Decides by the whole rule at every factor between the sensor's place and the latch; the worst counts.
    pub(super) fn decide(
        &self,
        design: &Design,
        extras: AssessExtras,
        control: &Control<'_>,
    ) -> Result<Decided<'_>, Error> {
        let facts = &self.facts;
        let stated = facts.request.transfer(&facts.card);
        let factors = self.factors();
        let work = facts.request.policy(facts.polarity).work;
        let (worst, mut assessment, answers) = match factors.as_slice() {
            [factor] => {
                let at_latch = self.at_factor(*factor);
                let assessment = at_latch.decide_at_latch(design, extras, work, control)?;
                let answers = vec![assessment.answer];
                (*factor, assessment, answers)
            }
            several => {
                let brief = AssessExtras {
                    detail: AssessDetail::Decision,
                    ..AssessExtras::default()
                };
                let share = |index: usize| index as f64 / (several.len() + 1) as f64;
                let mut assessments = Vec::with_capacity(several.len());
                let mut left = Vec::with_capacity(several.len());
                let mut spent = 0;
                for (index, factor) in several.iter().enumerate() {
                    // One question may take so much work, however many factors it has.
                    left.push(work.saturating_sub(spent).max(1));
                    let at_latch = self.at_factor(*factor);
                    let assessment = control.during(share(index), share(index + 1), |control| {
                        at_latch.decide_at_latch(design, brief, left[index], control)
                    })?;
                    spent += assessment.work;
                    assessments.push(assessment);
                }
                let worst = transfer::index_of_worst(&assessments);
                let at_latch = self.at_factor(several[worst]);
                let mut whole = control.during(share(several.len()), 1.0, |control| {
                    at_latch.decide_at_latch(design, extras, left[worst], control)
                })?;
                let answers = assessments.iter().map(|tried| tried.answer).collect();
                whole.tell_work_limit(work);
                (several[worst], whole, answers)
            }
        };
        let block = stated.map(|(range, source)| TransferBlock {
            from: range.from(),
            to: range.to(),
            judged: factors,
            answers,
            worst,
            source,
        });
        assessment.findings.extend(axis_finding(facts, design));
        if let Some(block) = block.as_ref().filter(|block| block.judged.len() > 1) {
            let place = assessment.why.len().min(1);
            assessment.why.insert(place, reason(block));
        }
        assessment.wait_for_word(&facts.findings, design);
        let conditioned = match self.at_factor(worst) {
            Cow::Borrowed(prepared) => Cow::Borrowed(&prepared.conditioned),
            Cow::Owned(prepared) => Cow::Owned(prepared.conditioned),
        };
        Ok(Decided {
            assessment,
            conditioned,
            transfer: block,
        })
    }
}
