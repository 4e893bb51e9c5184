//! Siblings: the lateral channels of one side in a file, judged together; the worst answer counts.

use super::answer::RecordingFacts;
use super::prepared::{Extras, Outcome, Prepared, Refused};
use super::row::DecisionRow;
use latchgate_document::Document;
use latchgate_document::blocks::SiblingBlock;
use latchgate_document::request::Request;
use latchgate_kernel::model::Design;
use latchgate_kernel::parallel::Control;
use latchgate_recording::error::Error;
use latchgate_recording::{Finding, Limits, Part, Source};
use latchgate_verdict::Answer;
use std::sync::Arc;

/// Returns a place that orders answers by how bad they are, in the order of exit codes, the worst last.
fn badness(answer: Answer) -> u8 {
    match answer {
        Answer::Pass => 0,
        Answer::Undecided => 1,
        Answer::Fail => 2,
        Answer::Unusable => 3,
    }
}

/// Returns the index of the worst of several answers with their largest angles; the first of equals.
fn index_of_worst(answers: &[(Answer, Option<f64>)]) -> usize {
    let mut worst = 0;
    for (index, (answer, peak_rad)) in answers.iter().enumerate() {
        let (most, most_rad) = answers[worst];
        let by_answer = badness(*answer).cmp(&badness(most));
        let by_peak = peak_rad.unwrap_or(0.0).total_cmp(&most_rad.unwrap_or(0.0));
        if by_answer.then(by_peak).is_gt() {
            worst = index;
        }
    }
    worst
}

fn block(document: &Document) -> SiblingBlock {
    SiblingBlock {
        channel: document.recording.channel.clone(),
        place: document.recording.place,
        answer: document.verdict,
        peak_angle_rad: document.nominal.as_ref().map(|run| run.peak_angle_rad),
        reason: document.why.first().cloned(),
    }
}

impl Prepared {
    /// Opens the other channels that are judged with this one. All answer one question, so all name every file that
    /// was read for any of them.
    pub(super) fn open_siblings(
        &mut self,
        source: &Source,
        names: &[String],
        limits: &Limits,
        control: &Control<'_>,
    ) -> Result<(), Box<Refused>> {
        let mut siblings = Vec::with_capacity(names.len());
        for name in names {
            let request = Request {
                channel: Some(name.clone()),
                siblings: false,
                ..self.facts.request.clone()
            };
            let facts = RecordingFacts {
                is_sibling: true,
                ..RecordingFacts::new(&request, source)
            };
            let opened = Self::open_one(source, facts, limits, control);
            siblings.push(match opened {
                Err(refused) if refused.error.is_stopped() => return Err(refused),
                Err(mut refused) => {
                    refused.name_channel(name);
                    Err(refused)
                }
                Ok((prepared, _)) => Ok(prepared),
            });
        }
        let mut parts: Vec<Part> = self.facts.recording.parts.clone();
        for sibling in &siblings {
            let block = match sibling {
                Ok(prepared) => prepared.recording(),
                Err(refused) => refused.recording(),
            };
            for part in &block.parts {
                if !parts.contains(part) {
                    parts.push(part.clone());
                }
            }
        }
        parts.sort_by(|one, other| one.file.cmp(&other.file));
        let question = |facts: &mut RecordingFacts, own: &Self| {
            facts.request = own.facts.request.clone();
            facts
                .recording
                .sha256
                .clone_from(&own.facts.recording.sha256);
            facts.recording.parts.clone_from(&parts);
        };
        for sibling in &mut siblings {
            match sibling {
                Ok(prepared) => question(&mut prepared.facts, self),
                Err(refused) => question(refused.facts_mut(), self),
            }
        }
        self.facts.recording.parts.clone_from(&parts);
        self.siblings = Arc::new(siblings);
        Ok(())
    }

    /// Returns every channel that is judged, this one first.
    ///
    /// # Errors
    ///
    /// The first of those that left a channel unread.
    pub(super) fn every(&self) -> Result<Vec<&Self>, Error> {
        let siblings = self.siblings.iter().map(|sibling| {
            let sibling = sibling.as_ref();
            sibling.map_err(|refused| refused.error.clone())
        });
        std::iter::once(Ok(self)).chain(siblings).collect()
    }

    /// Judges every channel; the outcome is that of the worst, and names each.
    pub(super) fn judge_siblings(
        &self,
        design: &Design,
        extras: Extras,
        control: &Control<'_>,
    ) -> Outcome {
        let extras = Extras {
            preload_answer: false,
            ..extras
        };
        let all = 1 + self.siblings.len();
        let share = |index: usize| index as f64 / all as f64;
        let mut outcomes = vec![control.during(share(0), share(1), |control| {
            self.judge_alone(design, extras, control)
        })];
        for (index, sibling) in self.siblings.iter().enumerate() {
            let outcome = control.during(
                share(index + 1),
                share(index + 2),
                |control| match sibling {
                    Ok(prepared) => prepared.judge_alone(design, extras, control),
                    Err(refused) => refused.as_ref().clone().outcome(design),
                },
            );
            outcomes.push(outcome);
        }
        if let Some(stopped) = outcomes.iter().position(Outcome::was_stopped) {
            return outcomes.swap_remove(stopped);
        }
        let blocks: Vec<SiblingBlock> = outcomes
            .iter()
            .map(|outcome| block(&outcome.document))
            .collect();
        let answers: Vec<_> = blocks
            .iter()
            .map(|block| (block.answer, block.peak_angle_rad))
            .collect();
        let mut outcome = outcomes.swap_remove(index_of_worst(&answers));
        if self.siblings.is_empty() {
            let text = "the file holds no other lateral channel of that side, so one was judged. Name the archive that \
                        holds all curves of the test, or judge the files of its other channels beside it";
            let findings = &mut outcome.document.findings;
            findings.push(Finding::warning("siblings-none", text));
        }
        outcome.document.siblings = blocks;
        outcome
    }

    /// Returns the row of the worst channel.
    ///
    /// # Errors
    ///
    /// As [`Prepared::row`].
    pub(super) fn row_of_siblings(
        &self,
        design: &Design,
        control: &Control<'_>,
    ) -> Result<DecisionRow, Error> {
        let mut rows = vec![self.row_alone(design, control)?];
        for sibling in self.siblings.iter() {
            rows.push(match sibling {
                Ok(prepared) => prepared.row_alone(design, control)?,
                Err(refused) => refused.row(design),
            });
        }
        let answers: Vec<_> = rows
            .iter()
            .map(|row| (row.verdict, row.peak_angle_rad))
            .collect();
        Ok(rows.swap_remove(index_of_worst(&answers)))
    }
}
