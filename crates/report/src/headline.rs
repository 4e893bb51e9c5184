//! The first line of a verdict: what the lever does, what would decide, or why there is no answer.

use crate::opening;
use crate::words;
use latchgate_document::Document;
use latchgate_document::number::trimmed;
use latchgate_recording::Severity;
use latchgate_verdict::decision::{NOISE_TIMES, unanimous};
use latchgate_verdict::ensemble::Driver;
use latchgate_verdict::{Answer, Ensemble, ErrorBudget, Reason, RunAnswer};

/// What remains where no single quantity decides.
const FARTHER: &str = "a design farther from the limit angle would decide.";

/// Letters of a headline, at most.
const HEADLINE_LETTERS: usize = 240;

/// Returns what the verdict means in a sentence: what the lever does, or what would decide it, or
/// why there is no answer. Without an ensemble it claims no more than the nominal lever does.
pub(super) fn headline(document: &Document) -> String {
    let lever = match document.ensemble {
        None if words::spared(document).is_none() => "The nominal lever",
        _ => "The lever",
    };
    let first = document.why.first();
    match (document.verdict, &document.nominal) {
        (Answer::Pass, Some(_)) => {
            let most = words::judged_runs(document).into_iter();
            let most = most.map(|run| words::highest_rad(document, run));
            let share = 100.0 * most.fold(0.0, f64::max) / document.threshold_rad;
            // Rounded up, since it is a bound.
            let share = if share > 10.0 {
                share.ceil()
            } else {
                (10.0 * share).ceil() / 10.0
            };
            let share = trimmed(share, 3);
            let varied = varied_levers(document);
            format!(
                "{lever} stays: at most {share}\u{00A0}% of the limit angle, errors included{varied}."
            )
        }
        (Answer::Fail, Some(_)) => {
            let Some(opens) = &document.opens else {
                return format!("{lever} opens.");
            };
            let place = words::place(opens.model, opens.opens_when);
            let sentence = opening::sentence(opens, opening::OPENS);
            match sentence.strip_suffix(')') {
                Some(open) => format!("{lever} {open}; {place})."),
                None if opens.first_s.is_none() => format!("{sentence} ({place})."),
                None => format!("{lever} {sentence} ({place})."),
            }
        }
        (Answer::Undecided, _) => would_decide(document),
        // The findings tell it in full.
        _ => first.map_or_else(String::new, |reason| cause(document, reason)),
    }
}

/// Says how far the varied levers of a pass come, where one comes farther than the nominal ones.
fn varied_levers(document: &Document) -> String {
    let Some(ensemble) = &document.ensemble else {
        return String::new();
    };
    if ensemble.exceeded > 0 {
        let (exceeded, members) = (ensemble.exceeded, ensemble.members);
        return format!("; {exceeded} of {members} varied levers open");
    }
    let most = ensemble.peak_angle_rad.map_or(0.0, |peak| peak.max);
    let nominal = words::judged_runs(document).into_iter();
    let nominal = nominal.map(|run| words::highest_rad(document, run));
    if most <= nominal.fold(0.0, f64::max) {
        return String::new();
    }
    let share = (100.0 * most / document.threshold_rad).ceil();
    format!("; varied levers up to {}\u{00A0}%", trimmed(share, 3))
}

/// Returns from when on a recording is unusable, where that is known, and the cause without its remedy.
fn cause(document: &Document, reason: &Reason) -> String {
    let finding = document
        .findings
        .iter()
        .find(|finding| finding.code == reason.code && finding.severity == Severity::Blocking);
    let from = finding.and_then(|finding| finding.at_s);
    let from = from.map_or_else(String::new, |at| format!("From {}: ", words::instant(at)));
    let cause = words::sentence(first_clause(&reason.text));
    words::shortened(&format!("{from}{cause}"), HEADLINE_LETTERS)
}

/// Returns a text up to its first semicolon or full stop, those of quoted words aside.
fn first_clause(text: &str) -> &str {
    let mut quoted = false;
    let end = text.char_indices().find_map(|(at, letter)| {
        quoted ^= letter == '"';
        let ends = matches!(letter, ';' | '.') && text[at + 1..].starts_with(' ');
        (ends && !quoted).then_some(at)
    });
    &text[..end.unwrap_or(text.len())]
}

/// Says what would decide: the remedy of what keeps the rule from an answer.
fn would_decide(document: &Document) -> String {
    let Some(first) = document.why.first() else {
        return "Nothing decides.".into();
    };
    match &*first.code {
        "polarity-decides" | "polarity-undeclared" => {
            let each: Vec<String> = words::directions(document)
                .into_iter()
                .map(|row| format!("{} if {} acceleration opens", row.word, row.sign))
                .collect();
            format!(
                "State the opening direction, the setting `opens_when`: {}.",
                each.join(", ")
            )
        }
        "stop-model-decides" => {
            "The stops answer differently: state which one the latch has, the setting `model`."
                .into()
        }
        "members-cross" | "most-members-cross" => remedy_of_scatter(document),
        "coast-reaches-limit" | "members-coast-beyond" => {
            "The lever still moves where the record ends: a longer recording would decide.".into()
        }
        "few-members-cross"
        | "uncertainty-spans-threshold"
        | "threshold-crossed"
        | "threshold-not-crossed"
        | "never-released" => remedy_of_error(document),
        _ => words::sentence(&first.text),
    }
}

/// Says what would decide where the error of the largest angle spans the limit angle: the remedy of the
/// largest part of that error, if the rest of it leaves an answer.
fn remedy_of_error(document: &Document) -> String {
    let ErrorBudget {
        numerical,
        interpolation,
        noise,
        ..
    } = document.error_budget_rad;
    let parts = [
        (
            interpolation.unwrap_or(0.0),
            "What lies between the samples is not known: a higher sample rate would decide.",
        ),
        (
            NOISE_TIMES * noise.unwrap_or(0.0),
            "The noise hides the answer: a quieter channel or a finer recorder would decide.",
        ),
        (
            numerical.unwrap_or(0.0),
            "Impacts amplify the smallest errors: a design farther from the limit angle would decide.",
        ),
    ];
    let total: f64 = parts.iter().map(|(part, _)| part).sum();
    let largest = parts.iter().max_by(|one, other| one.0.total_cmp(&other.0));
    match largest {
        Some((part, remedy)) if total - part < distance_to_limit_rad(document) => (*remedy).into(),
        _ => format!("The errors of the largest angle reach the limit angle: {FARTHER}"),
    }
}

fn error_spans_limit(document: &Document) -> bool {
    let run = document.nominal.as_ref();
    let error = run.and_then(|run| words::uncertainty(document, run));
    error.is_some_and(|error| error >= distance_to_limit_rad(document))
}

/// Returns how far the largest angle of the nominal lever is from the limit angle [rad].
fn distance_to_limit_rad(document: &Document) -> f64 {
    document.nominal.as_ref().map_or(f64::INFINITY, |run| {
        (run.peak_angle_rad - document.threshold_rad).abs()
    })
}

/// Says what would decide where neither few nor most varied levers open: the remedy of the input that goes
/// with the largest angle most, among those that decide if they are known better.
fn remedy_of_scatter(document: &Document) -> String {
    let shown: Vec<&Ensemble> = match document.ensembles.as_slice() {
        [] => document.ensemble.iter().collect(),
        several => several.iter().collect(),
    };
    let drivers = document.ensemble.iter().flat_map(|own| &own.drivers);
    let deciding = drivers.filter(|driver| decides(document, &shown, &driver.parameter));
    let share = |driver: &&Driver| driver.share.unwrap_or(0.0);
    match deciding.max_by(|one, other| share(one).total_cmp(&share(other))) {
        Some(driver) if driver.parameter == "input.bias_g" => format!(
            "The sensor's zero is known to ±{}\u{00A0}g only: a longer quiet stretch before contact, or the setting `bias`, would decide.",
            trimmed(driver.standard_deviation, 2)
        ),
        Some(driver) => format!(
            "The tolerance of the {} counts most: a quarter of it would decide.",
            words::parameter(&driver.parameter)
        ),
        None if error_spans_limit(document) => remedy_of_error(document),
        None => format!("No single tolerance decides: {FARTHER}"),
    }
}

/// Tells whether all stops and opening directions would give one answer if a parameter were known better.
fn decides(document: &Document, ensembles: &[&Ensemble], parameter: &str) -> bool {
    let answer_if_known = |answer: &RunAnswer| {
        if answer.answer != Answer::Undecided {
            return answer.answer;
        }
        let ensemble = ensembles
            .iter()
            .find(|own| (own.model, own.opens_when) == (answer.model, answer.opens_when));
        let mut drivers = ensemble.into_iter().flat_map(|own| &own.drivers);
        let driver = drivers.find(|driver| driver.parameter == parameter);
        driver.map_or(Answer::Undecided, |driver| driver.answer_if_known)
    };
    let answers: Vec<Answer> = document.answers.iter().map(answer_if_known).collect();
    unanimous(&answers) != Answer::Undecided
}
