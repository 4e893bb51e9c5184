//! What a person must say of a recording before a pass on it counts.
//!
//! A record that is unlike a crash is judged as any other; margins and reruns take it as it is. Only
//! the verdict waits: a pass becomes undecided until the word is there.

use super::{Answer, Assessment, Reason};
use latchgate_recording::Finding;

impl Assessment {
    /// Turns a pass into an undecided verdict where `findings` ask for a person's word.
    pub fn wait_for_word(&mut self, findings: &[Finding]) {
        let asking = findings.iter().filter(|finding| finding.needs_word);
        let settings: Vec<&str> = asking.map(setting).collect();
        if self.answer != Answer::Pass || settings.is_empty() {
            return;
        }
        let text = format!(
            "The lever stays, but the record is unlike a crash. A pass needs a person's word: {}.",
            settings.join(" and ")
        );
        let code = "needs-word".into();
        self.why.insert(0, Reason { code, text });
        self.answer = Answer::Undecided;
        self.word_missing = true;
    }

    /// Tells whether the answer is a pass, or would be with a person's word.
    pub fn passes_with_word(&self) -> bool {
        self.answer == Answer::Pass || self.word_missing
    }
}

/// Returns the setting by which a person answers a finding.
fn setting(finding: &Finding) -> &'static str {
    match &*finding.code {
        "clock-implausible" => "the setting `accept` = clock",
        _ => "the setting `velocity_change`",
    }
}
