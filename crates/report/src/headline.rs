//! The first line of a verdict: what the lever does, what would decide, or why there is no answer.

use crate::opening;
use crate::words;
use latchgate_document::Document;
use latchgate_document::blocks::TransferBlock;
use latchgate_document::number::{count, exact, trimmed};
use latchgate_recording::Severity;
use latchgate_verdict::decision::{NOISE_TIMES, unanimous};
use latchgate_verdict::ensemble::{Driver, Varied};
use latchgate_verdict::{Answer, Ensemble, Reason, RunAnswer};

/// Remedy where no single quantity decides.
const FARTHER: &str = "a design farther from the limit angle would decide.";

/// Reasons that name a single input as deciding.
const DECIDING: [&str; 2] = ["bias-decides", "tolerance-decides"];

/// Largest number of letters of a headline.
const HEADLINE_LETTERS: usize = 240;

/// Returns the meaning of a verdict in a sentence: what the lever does, or what would decide it, or
/// why there is no answer. Without an ensemble the sentence speaks of the nominal lever alone.
pub fn headline(document: &Document) -> String {
    let of_factor = document.transfer.as_ref().and_then(of_factor);
    let answer = answer_in_words(document);
    match of_factor {
        Some(of_factor) => {
            let mut letters = answer.chars();
            let first = letters.next().into_iter().flat_map(char::to_lowercase);
            format!("{of_factor}{}", first.chain(letters).collect::<String>())
        }
        None => answer,
    }
}

/// Returns the factor between sensor and latch to which the answer belongs, where not all of those judged answer alike.
fn of_factor(block: &TransferBlock) -> Option<String> {
    let is_mixed = block.answers.windows(2).any(|pair| pair[0] != pair[1]);
    is_mixed.then(|| {
        format!(
            "At factor {}, the worst of {}: ",
            exact(block.worst),
            block.judged.len()
        )
    })
}

fn answer_in_words(document: &Document) -> String {
    let lever = match &document.ensemble {
        None if words::is_alone(document) => "This one lever",
        None if words::sparing_bound(document).is_none() => "The nominal lever",
        Some(ensemble) if ensemble.varied == Varied::Readings => "This one lever",
        _ => "The lever",
    };
    let first = document.why.first();
    match (document.verdict, &document.nominal) {
        (Answer::Pass, Some(_)) => {
            let runs = words::judged_runs(document).into_iter();
            let highest_rad = runs
                .map(|run| words::highest_rad(document, run))
                .fold(0.0, f64::max);
            let share = share_of_limit(document, highest_rad);
            let varied = varied_levers(document, highest_rad);
            if highest_rad <= 0.0 {
                return format!("{lever} never leaves its stop, errors included{varied}.");
            }
            format!("{lever} stays: at most {share} of the limit angle, errors included{varied}.")
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
        // The findings hold the full text.
        _ => first.map_or_else(String::new, |reason| cause(document, reason)),
    }
}

/// Returns an angle [rad] as a share of the limit angle, rounded up, since it is a bound.
fn share_of_limit(document: &Document, angle_rad: f64) -> String {
    let percent = 100.0 * angle_rad / document.threshold_rad;
    let percent = if percent > 10.0 {
        percent.ceil()
    } else {
        (10.0 * percent).ceil() / 10.0
    };
    format!("{}\u{00A0}%", trimmed(percent, 3))
}

/// Returns the largest angle of the varied levers of a pass over all stops and opening directions; nothing if the
/// nominal levers reach it.
fn varied_levers(document: &Document, nominal_rad: f64) -> String {
    let ensembles = words::ensembles(document);
    if let Some(worst) = ensembles.iter().max_by_key(|ensemble| ensemble.exceeded)
        && worst.exceeded > 0
    {
        let (exceeded, members) = (worst.exceeded, worst.members);
        let varied = worst.varied.members();
        return format!("; {exceeded} of {members} {varied} open");
    }
    let peaks = ensembles
        .iter()
        .filter_map(|ensemble| ensemble.peak_angle_rad);
    let highest_rad = peaks.map(|peak| peak.max).fold(0.0, f64::max);
    if highest_rad <= nominal_rad {
        return String::new();
    }
    let varied = ensembles
        .first()
        .map_or(Varied::Levers, |ensemble| ensemble.varied);
    format!(
        "; {} up to {}",
        varied.members(),
        share_of_limit(document, highest_rad)
    )
}

/// Returns the instant from which a recording is unusable, if known, and the cause without its remedy.
fn cause(document: &Document, reason: &Reason) -> String {
    let finding = document
        .findings
        .iter()
        .find(|finding| finding.code == reason.code && finding.severity == Severity::Blocking);
    let from = finding.and_then(|finding| finding.at_s);
    let from = from.map_or_else(String::new, |at_s| {
        format!("From {}: ", words::instant(at_s))
    });
    let cause = words::sentence(first_clause(&reason.text));
    words::shortened(&format!("{from}{cause}"), HEADLINE_LETTERS)
}

/// Returns a text up to its first semicolon or full stop, those of quoted words aside.
fn first_clause(text: &str) -> &str {
    let mut quoted = false;
    let end = text.char_indices().find_map(|(index, letter)| {
        quoted ^= letter == '"';
        let ends = matches!(letter, ';' | '.') && text[index + 1..].starts_with(' ');
        (ends && !quoted).then_some(index)
    });
    &text[..end.unwrap_or(text.len())]
}

/// Returns what would decide: the remedy of the largest obstacle to an answer.
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
            let mut reasons = document.why.iter();
            let others = reasons.find(|reason| reason.code == "needs-word");
            let others = others.map_or_else(String::new, |reason| format!(" {}", reason.text));
            let mut answers = words::directions(document).into_iter().map(|row| row.word);
            let first = answers.next();
            match first.filter(|first| !others.is_empty() && answers.all(|word| word == *first)) {
                // What is to be stated stands in the reason.
                Some(word) => format!(
                    "{} in both opening directions.{others}",
                    words::capital(word)
                ),
                None => format!(
                    "State the opening direction, the setting `opens_when`: {}.{others}",
                    each.join(", ")
                ),
            }
        }
        "stop-model-decides" => {
            "The stops answer differently: state which one the latch has, the setting `model`."
                .into()
        }
        "members-cross" | "most-members-cross" => {
            format!(
                "{}{}",
                share_that_opens(document),
                remedy_of_scatter(document)
            )
        }
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

/// Returns how many of the levers of the decisive ensemble open: `46 % of the varied levers open (4644 of 10 000). `.
fn share_that_opens(document: &Document) -> String {
    let Some(shown) = words::decisive_ensemble(document).filter(|shown| shown.exceeded > 0) else {
        return String::new();
    };
    let (exceeded, members) = (u64::from(shown.exceeded), u64::from(shown.members));
    let percent = trimmed(100.0 * exceeded as f64 / members as f64, 2);
    format!(
        "{percent}\u{00A0}% of the {} open ({} of {}). ",
        shown.varied.members(),
        count(exceeded),
        count(members)
    )
}

/// The largest part of an error.
#[derive(Clone, Copy, PartialEq, Eq)]
enum LargestPart {
    Interpolation,
    Noise,
    Numerical,
}

/// Returns what would decide where errors of the largest angles reach the limit angle: the remedy of their largest
/// part, if it is the same for every undecided stop and opening direction, and each run has an answer without it.
fn remedy_of_error(document: &Document) -> String {
    let undecided = document.answers.iter();
    let undecided = undecided.filter(|answer| answer.answer == Answer::Undecided);
    let parts: Vec<Option<LargestPart>> = undecided
        .map(|answer| deciding_part(document, answer))
        .collect();
    let remedy = match parts.as_slice() {
        [Some(first), rest @ ..] if rest.iter().all(|part| *part == Some(*first)) => first,
        several => return several_errors(document, several),
    };
    match remedy {
        LargestPart::Interpolation => {
            "What lies between the samples is not known: a higher sample rate would decide.".into()
        }
        LargestPart::Noise => {
            "The noise hides the answer: a quieter channel or a finer recorder would decide.".into()
        }
        LargestPart::Numerical => format!("Impacts amplify the smallest errors: {FARTHER}"),
    }
}

/// Says what hides the answer where stops and opening directions have different largest parts, or one has none that
/// hides it alone: then how well the largest angle is known.
fn several_errors(document: &Document, parts: &[Option<LargestPart>]) -> String {
    let causes = [
        (
            LargestPart::Interpolation,
            "what lies between the samples is not known",
        ),
        (LargestPart::Noise, "the noise hides the answer"),
        (
            LargestPart::Numerical,
            "impacts amplify the smallest errors",
        ),
    ];
    if parts.is_empty() || parts.contains(&None) {
        let error_rad = document
            .answers
            .iter()
            .filter_map(|one| one.uncertainty_rad);
        let error_rad = error_rad.fold(0.0, f64::max);
        let known = match error_rad > std::f64::consts::FRAC_PI_2 {
            true => "not known at all".to_string(),
            false => format!("known to ±{}° only", trimmed(error_rad.to_degrees(), 2)),
        };
        let remedy = match error_rad > document.threshold_rad {
            // No lever that stays is that far from the limit angle.
            true => "a lever that impacts push off less, by its preload or its stop, may decide.",
            false => FARTHER,
        };
        return format!("The largest angle is {known}: {remedy}");
    }
    let found = causes
        .into_iter()
        .filter(|(part, _)| parts.contains(&Some(*part)));
    let found: Vec<&str> = found.map(|(_, words)| words).collect();
    words::capital(&format!("{}: {FARTHER}", found.join(", and ")))
}

/// Returns the largest part of a run's error, if without it the error does not reach the limit angle.
fn deciding_part(document: &Document, answer: &RunAnswer) -> Option<LargestPart> {
    let total_rad = answer.uncertainty_rad?;
    let interpolation_rad = answer.interpolation_error_rad?;
    let noise_rad = (NOISE_TIMES * answer.noise_rad?).max(answer.noise_97_5_rad.unwrap_or(0.0));
    let numerical_rad = total_rad - interpolation_rad - noise_rad;
    let parts = [
        (interpolation_rad, LargestPart::Interpolation),
        (noise_rad, LargestPart::Noise),
        (numerical_rad, LargestPart::Numerical),
    ];
    let (part_rad, part) = parts.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    let distance_rad = distance_to_limit_rad(document, answer)?;
    (total_rad - part_rad < distance_rad).then_some(part)
}

/// Returns true if the error of an undecided run reaches the limit angle.
fn error_reaches_limit(document: &Document) -> bool {
    document.answers.iter().any(|answer| {
        let distance_rad = distance_to_limit_rad(document, answer);
        answer.answer == Answer::Undecided
            && answer
                .uncertainty_rad
                .zip(distance_rad)
                .is_some_and(|(error_rad, distance_rad)| error_rad >= distance_rad)
    })
}

/// Returns how far the largest angle of a run is from the limit angle [rad].
fn distance_to_limit_rad(document: &Document, answer: &RunAnswer) -> Option<f64> {
    let mut runs = words::judged_runs(document).into_iter();
    let run = runs.find(|run| (run.model, run.opens_when) == (answer.model, answer.opens_when))?;
    Some((run.peak_angle_rad - document.threshold_rad).abs())
}

/// Returns what would decide where neither few nor most varied levers open: the remedy of the input that drives
/// the largest angle most, among those that would decide if they were known better.
fn remedy_of_scatter(document: &Document) -> String {
    let ensembles = words::ensembles(document);
    let drivers = document
        .ensemble
        .iter()
        .flat_map(|ensemble| &ensemble.drivers);
    let deciding = drivers.filter(|driver| decides(document, ensembles, &driver.parameter));
    let share = |driver: &&Driver| driver.share.unwrap_or(0.0);
    match deciding.max_by(|a, b| share(a).total_cmp(&share(b))) {
        Some(driver) if driver.parameter == "input.bias_g" => format!(
            "The sensor's zero is known to ±{}\u{00A0}g only: a longer quiet stretch before contact, or the setting `bias`, would decide.",
            trimmed(driver.standard_deviation, 2)
        ),
        Some(driver) => format!(
            "The tolerance of the {} counts most: a quarter of it would decide.",
            words::parameter(&driver.parameter)
        ),
        None if error_reaches_limit(document) => remedy_of_error(document),
        // One that moves the nominal lever across the limit decides something, if not the share.
        None if document
            .why
            .iter()
            .any(|reason| DECIDING.contains(&&*reason.code)) =>
        {
            format!("The levers and readings lie on both sides of the limit angle: {FARTHER}")
        }
        None => format!("No single tolerance decides: {FARTHER}"),
    }
}

/// Returns true if all stops and opening directions would give one answer if a parameter were known better.
fn decides(document: &Document, ensembles: &[Ensemble], parameter: &str) -> bool {
    let answer_if_known = |answer: &RunAnswer| {
        if answer.answer != Answer::Undecided {
            return answer.answer;
        }
        let ensemble = ensembles.iter().find(|ensemble| {
            (ensemble.model, ensemble.opens_when) == (answer.model, answer.opens_when)
        });
        let mut drivers = ensemble.into_iter().flat_map(|ensemble| &ensemble.drivers);
        let driver = drivers.find(|driver| driver.parameter == parameter);
        driver.map_or(Answer::Undecided, |driver| driver.answer_if_known)
    };
    let answers: Vec<Answer> = document.answers.iter().map(answer_if_known).collect();
    unanimous(&answers) != Answer::Undecided
}
