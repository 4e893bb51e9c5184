//! What a person must say before a pass counts.
//!
//! Samples cannot say everything of themselves. What they leave open is judged as any other recording; margins and
//! reruns take it as it is. Only the verdict waits: a pass becomes undecided until every word is there, and one
//! message names all of them.

use super::ensemble::{Ensemble, Varied};
use super::reasons::{NOTHING_VARIED, WORK_LIMIT, work_limit};
use super::replay_findings::{SCATTER_UNSTATED, of_design, work_limit_reached};
use super::{Answer, Assessment, Reason};
use latchgate_kernel::model::Design;
use latchgate_recording::Finding;
use latchgate_recording::setting::Setting;

/// How a person answers one finding.
struct Word {
    /// Code of the finding; of the one that asks for tolerances, the key of one.
    code: &'static str,
    /// What is missing.
    what: &'static str,
    /// The setting that states it, with its value.
    setting: (Setting, &'static str),
    /// Key and value by which card or design state it for good.
    line: (File, &'static str, &'static str),
}

/// The file that states a word for good.
#[derive(Clone, Copy, PartialEq, Eq)]
enum File {
    Card,
    Design,
}

/// Every word, in the order in which they are named.
const WORDS: &[Word] = &[
    Word {
        code: "polarity-decides",
        what: "the opening direction",
        setting: (Setting::OpensWhen, "negative|positive|both"),
        line: (
            File::Card,
            "opens_when",
            "\"negative\"|\"positive\"|\"both\"",
        ),
    },
    Word {
        code: "place",
        what: "the factor from the sensor's place to the latch",
        setting: (Setting::Transfer, "LO..HI"),
        line: (File::Card, "transfer", "\"LO..HI\""),
    },
    Word {
        code: "axis",
        what: "the axis of the channel",
        setting: (Setting::Accept, "axis"),
        line: (File::Card, "accepted", "\"axis\""),
    },
    Word {
        code: "implausible-velocity",
        what: "the velocity change",
        setting: (Setting::VelocityChange, "M/S"),
        line: (File::Card, "velocity_change_m_s", "M/S"),
    },
    Word {
        code: "clock-implausible",
        what: "the clock",
        setting: (Setting::Accept, "clock"),
        line: (File::Card, "accepted", "\"clock\""),
    },
    Word {
        code: "noise-unknown",
        what: "the channel's noise",
        setting: (Setting::Accept, "noise"),
        line: (File::Card, "accepted", "\"noise\""),
    },
    Word {
        code: "processed",
        what: "samples unlike those of a raw recording",
        setting: (Setting::Accept, "processed"),
        line: (File::Card, "accepted", "\"processed\""),
    },
    Word {
        code: "preload_torque_nm",
        what: "how far the preload scatters",
        setting: (Setting::Set, "tolerance.preload_torque_nm=VALUE"),
        line: (File::Design, "preload_torque_nm", "VALUE"),
    },
    Word {
        code: "mass_kg",
        what: "how far the mass scatters",
        setting: (Setting::Set, "tolerance.mass_kg=VALUE"),
        line: (File::Design, "mass_kg", "VALUE"),
    },
];

/// Marks the settings of one command line, which the command line writes without commas.
pub const TOGETHER: &str = "State together: ";

impl Assessment {
    /// Turns a pass into an undecided verdict where `findings`, or those of the replay, ask for a person's word.
    /// Where only the direction is undecided, what a pass would wait for beside it is named with it.
    pub fn wait_for_word(&mut self, findings: &[Finding], design: &Design) {
        let mut codes = asking(findings.iter().chain(&self.findings), design);
        if codes.is_empty() {
            return;
        }
        let first = self.why.first().map_or("", |reason| &reason.code);
        let by_direction = ["polarity-decides", "polarity-undeclared"].contains(&first);
        let code = "needs-word".into();
        match self.answer {
            Answer::Pass => {
                let lever = match self.is_of_one_lever() {
                    true => "This one lever",
                    false => "The lever",
                };
                let text = format!("{lever} stays. {}", request(&codes));
                self.why.insert(0, Reason { code, text });
                self.answer = Answer::Undecided;
                self.word_missing = true;
            }
            Answer::Undecided if by_direction => {
                codes.push("polarity-decides");
                let text = request(&codes);
                self.why.insert(1, Reason { code, text });
            }
            _ => {}
        }
    }

    /// Tells whether no value of the lever was varied.
    fn is_of_one_lever(&self) -> bool {
        let nothing = |reason: &Reason| reason.code == NOTHING_VARIED;
        let readings = |ensemble: &Ensemble| ensemble.varied == Varied::Readings;
        self.why.iter().any(nothing) || self.ensemble.as_ref().is_some_and(readings)
    }

    /// Tells the limit of work that a person knows, where a part of it was left for this answer.
    pub fn tell_work_limit(&mut self, limit: u64) {
        let mut reasons = self.why.iter_mut();
        if let Some(reason) = reasons.find(|reason| reason.code == WORK_LIMIT) {
            reason.text = work_limit(limit).text;
        }
        let mut findings = self.findings.iter_mut();
        if let Some(finding) = findings.find(|finding| finding.code == WORK_LIMIT) {
            *finding = work_limit_reached(limit);
        }
    }

    /// Tells whether the answer is a pass, or would be with a person's word.
    pub fn passes_with_word(&self) -> bool {
        self.answer == Answer::Pass || self.word_missing
    }
}

/// Returns the codes of the words for which `findings` ask; of unstated scatter the keys of the tolerances.
fn asking<'a>(findings: impl Iterator<Item = &'a Finding>, design: &Design) -> Vec<&'a str> {
    let asking = findings.filter(|finding| finding.needs_word);
    let mut codes: Vec<&str> = asking.map(|finding| &*finding.code).collect();
    if codes.contains(&SCATTER_UNSTATED) {
        codes.retain(|code| *code != SCATTER_UNSTATED);
        codes.extend(design.missing_tolerances());
    }
    codes
}

/// Returns what a person must still say before a pass of `design` under recordings with these `findings` counts, each
/// as a phrase: "the clock", "how far the preload scatters".
pub fn awaited<'a>(findings: impl Iterator<Item = &'a Finding>, design: &Design) -> Vec<String> {
    let of_design = of_design(design);
    let mut codes = asking(findings, design);
    codes.extend(asking(of_design.iter(), design));
    let words = WORDS.iter().filter(|word| codes.contains(&word.code));
    let mut awaited: Vec<String> = words.map(|word| word.what.to_string()).collect();
    for code in codes {
        let other = format!("what `{code}` asks");
        if !WORDS.iter().any(|word| word.code == code) && !awaited.contains(&other) {
            awaited.push(other);
        }
    }
    awaited
}

/// Returns the message that names everything that findings of these codes ask for.
fn request(codes: &[&str]) -> String {
    let words: Vec<&Word> = WORDS
        .iter()
        .filter(|word| codes.contains(&word.code))
        .collect();
    let what: Vec<&str> = words.iter().map(|word| word.what).collect();
    let settings = grouped(words.iter().map(|word| word.setting));
    let settings = settings.iter().map(|(setting, values)| {
        // Several words of one setting are its list; several assignments are several settings.
        let named = |value: &str| format!("{setting} = {value}");
        match setting {
            Setting::Set => values.iter().map(|value| named(value)).collect(),
            _ => vec![named(&values.join(","))],
        }
    });
    let settings: Vec<String> = settings.flatten().collect();
    let mut text = format!(
        "A pass needs a person's word on {}. {TOGETHER}{}.",
        listed(&what),
        settings.join(", ")
    );
    for (file, name) in [
        (File::Card, "in the card"),
        (File::Design, "under [tolerance] of the design"),
    ] {
        let lines = words.iter().filter(|word| word.line.0 == file);
        let lines = grouped(lines.map(|word| (word.line.1, word.line.2)));
        let line = |(key, values): &(&str, Vec<&str>)| match *key {
            "accepted" => format!("`{key} = [{}]`", values.join(", ")),
            _ => format!("`{key} = {}`", values.join(", ")),
        };
        let lines: Vec<String> = lines.iter().map(line).collect();
        if !lines.is_empty() {
            text += &format!(" For good, {name}: {}.", lines.join(", "));
        }
    }
    // A finding without an entry above still holds the pass back, and says in its text what it asks.
    let known = |code: &&&str| !WORDS.iter().any(|word| word.code == **code);
    let others: Vec<String> = codes
        .iter()
        .filter(known)
        .map(|code| format!("`{code}`"))
        .collect();
    match (what.is_empty(), others.is_empty()) {
        (_, true) => text,
        (true, _) => format!(
            "A pass needs what the finding {} asks.",
            others.join(" and ")
        ),
        _ => format!("{text} The finding {} asks too.", others.join(" and ")),
    }
}

/// Puts the values of equal keys together, in the order of the keys.
fn grouped<K: PartialEq>(
    pairs: impl Iterator<Item = (K, &'static str)>,
) -> Vec<(K, Vec<&'static str>)> {
    let mut groups: Vec<(K, Vec<&'static str>)> = Vec::new();
    for (key, value) in pairs {
        match groups.iter_mut().find(|(known, _)| *known == key) {
            Some((_, values)) => values.push(value),
            None => groups.push((key, vec![value])),
        }
    }
    groups
}

/// Joins what is missing: "the clock", "the clock and the velocity change".
fn listed(what: &[&str]) -> String {
    match what {
        [] => String::new(),
        [one] => (*one).into(),
        [others @ .., last] => format!("{} and {last}", others.join(", ")),
    }
}
