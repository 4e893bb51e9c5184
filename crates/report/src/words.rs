//! Words that the terminal and the page share.
//!
//! Numbers with their units, names of stops, numbers of the design and whole sentences, which must
//! not differ between the two. Each lays them out by itself.

use crate::angle::KnownPeak;
use crate::codes;
use crate::opening;
use latchgate_document::Document;
use latchgate_document::blocks::{ConditioningBlock, RecordingBlock};
use latchgate_document::number::{ABSENT, count, exact, significant, trimmed};
use latchgate_document::request::PolaritySource;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::parameters::{CATCH_PARAMETERS, DesignParameter, PARAMETERS, Slot};
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::model::tolerance::Tolerance;
use latchgate_kernel::replay::Run;
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY};
use latchgate_recording::card::CardPolarity;
use latchgate_recording::{Finding, Severity, TestFacts};
use latchgate_verdict::conditioning::{Cfc, VELOCITY_STRETCH_S};
use latchgate_verdict::decision::{FAIL_SHARE_WITH_NOMINAL, NOISE_TIMES};
use latchgate_verdict::in_plane::InPlane;
use latchgate_verdict::margin::{Advice, Quantity};
use latchgate_verdict::wording::percent_bound;
use latchgate_verdict::{Answer, Bound, Ensemble, ErrorBudget, FilterRow};
use serde::Serialize;
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

/// Digits of a result shown to people.
pub(super) const DIGITS: usize = 5;

/// Returns the verdict in capitals.
pub(super) fn answer(answer: Answer) -> &'static str {
    match answer {
        Answer::Pass => "PASS",
        Answer::Fail => "FAIL",
        Answer::Undecided => "UNDECIDED",
        Answer::Unusable => "UNUSABLE",
    }
}

/// Returns the bound that made the ensemble unnecessary for the nominal run: no varied lever reaches the limit.
pub(super) fn sparing_bound(document: &Document) -> Option<Bound> {
    let run = document.nominal.as_ref()?;
    document.answer_of(run)?.bound
}

/// Returns every nominal run that counts.
pub(super) fn judged_runs(document: &Document) -> Vec<&Run> {
    let by_sign = document.polarities.values().flat_map(BTreeMap::values);
    let by_sign: Vec<&Run> = by_sign.collect();
    match (by_sign.is_empty(), document.models.is_empty()) {
        (false, _) => by_sign,
        (true, false) => document.models.values().collect(),
        (true, true) => document.nominal.iter().collect(),
    }
}

/// Returns the largest angle that a run may reach in the record or after it, errors included [rad].
pub(super) fn highest_rad(document: &Document, run: &Run) -> f64 {
    let answer = document.answer_of(run);
    let error = answer.and_then(|answer| answer.uncertainty_rad);
    let coast_error = answer.and_then(|answer| answer.coast_uncertainty_rad);
    let coast = run
        .coast_peak_angle_rad
        .map_or(0.0, |coast| coast + coast_error.unwrap_or(0.0));
    (run.peak_angle_rad.max(0.0) + error.unwrap_or(0.0)).max(coast)
}

/// Returns the run whose angle is shown for all: of a pass the one that may come nearest to the limit, else the
/// nominal one.
pub(super) fn leading_run(document: &Document) -> Option<&Run> {
    if document.verdict != Answer::Pass {
        return document.nominal.as_ref();
    }
    let highest = |run: &&Run| highest_rad(document, run);
    let runs = judged_runs(document).into_iter();
    runs.max_by(|a, b| highest(a).total_cmp(&highest(b)))
}

/// Returns true if some preload between that of a pass and the advised one does not pass.
pub(super) fn is_isolated_pass(document: &Document) -> bool {
    let present = document.design.lever.preload_torque_nm;
    is_isolated(
        document,
        document.preload_answer.as_ref(),
        Quantity::Preload,
        present,
    )
}

/// Returns true if some restitution between that of a pass and the largest that is sure to pass does not.
pub(super) fn is_isolated_restitution(document: &Document) -> bool {
    let present = document.design.stop.restitution;
    is_isolated(
        document,
        document.restitution_answer.as_ref(),
        Quantity::Restitution,
        present,
    )
}

fn is_isolated(
    document: &Document,
    advice: Option<&Advice>,
    quantity: Quantity,
    present: f64,
) -> bool {
    let is_apart =
        |advice: &Advice| advice.safe_from.is_some() && !advice.covers(quantity, present);
    document.verdict == Answer::Pass && advice.is_some_and(is_apart)
}

/// Returns the advised preload; of one down to which a pass holds, with its distance in standard deviations of the
/// preload's scatter, where that is stated.
pub(super) fn preload(document: &Document) -> Option<String> {
    let advice = document.preload_answer.as_ref()?;
    let design = &document.design;
    let present = design.lever.preload_torque_nm;
    let holds = document.verdict == Answer::Pass && advice.covers(Quantity::Preload, present);
    let parameter = DesignParameter::named("lever.preload_torque_nm");
    let is_stated =
        |parameter: &&DesignParameter| design.tolerance.contains_key(parameter.tolerance_key());
    let deviation = parameter
        .filter(is_stated)
        .and_then(|one| design.deviation(one));
    let deviation = deviation.filter(|deviation| holds && *deviation > 0.0);
    let below = advice.safe_from.zip(deviation).map(|(from, deviation)| {
        let deviations = (present - from) / deviation;
        // A margin is rounded down; what has two digits already is not lowered by the rounding of a division.
        let unit = if deviations < 10.0 { 0.1 } else { 1.0 };
        let deviations = (deviations / unit + 1e-9).floor() * unit;
        match deviations > 0.0 {
            true => format!(
                "; that is {} standard deviations of the stated scatter below the present value",
                trimmed(deviations, 4)
            ),
            false => "; the present value is the lowest of them: no margin".into(),
        }
    });
    Some(format!("{}{}", advice.text, below.unwrap_or_default()))
}

/// Returns the largest restitution at which a pass stays one. The restitution of a stop is seldom measured, and never
/// constant.
pub(super) fn restitution(document: &Document) -> Option<String> {
    let advice = document.restitution_answer.as_ref()?;
    let tried = advice.tried;
    if is_isolated_restitution(document) {
        // A sentence for other restitutions would deny this pass.
        return Some(advice.text.clone());
    }
    Some(match (advice.safe_from, advice.does_not) {
        (Some(_), None) => format!("Passes at all {tried} restitutions tried from 0 to 1"),
        (Some(from), _) => format!(
            "Passes at all restitutions tried up to {}, not at each of the {tried} tried from 0 to 1",
            latchgate_kernel::units::shortest(from)
        ),
        (None, _) => "Does not pass for a restitution of 0: this pass hangs on the stop".into(),
    })
}

/// Faults that a pass does not exclude, since the samples of a recording cannot show them.
pub const UNSEEN: &str = "what samples need not show: a wrong sign, half the scale, half the time, a wrong axis under a right name";

/// Returns a text cut between two words, where it has more letters than `letters_max`.
pub(super) fn shortened(text: &str, letters_max: usize) -> String {
    if text.chars().count() <= letters_max {
        return text.to_string();
    }
    let cut: String = text.chars().take(letters_max).collect();
    // A word of half the text, such as a path, is cut itself.
    let end = cut.rfind(' ').filter(|end| 2 * end >= cut.len());
    let end = end.unwrap_or(cut.len());
    format!("{} …", cut[..end].trim_end_matches([',', ';', ':']))
}

/// Returns the first sentences of a text that have at most `letters_max` letters together; the first cut between two
/// words, where it alone has more.
pub(super) fn first_sentences(text: &str, letters_max: usize) -> String {
    let ends = text.match_indices(". ").map(|(stop, _)| stop + 1);
    let fits = |end: &usize| text[..*end].chars().count() <= letters_max;
    if text.chars().count() <= letters_max {
        return text.to_string();
    }
    match ends.filter(fits).last() {
        Some(end) => text[..end].to_string(),
        None => shortened(text, letters_max),
    }
}

/// Answer of an opening direction.
pub(super) struct DirectionRow {
    /// The sign of the recorded acceleration that opens.
    pub(super) sign: &'static str,
    /// The answer as a word in small letters; in capitals it would be taken for the verdict.
    pub(super) word: &'static str,
    /// What the lever does.
    pub(super) text: String,
}

/// Returns the answer of each opening direction.
pub(super) fn directions(document: &Document) -> Vec<DirectionRow> {
    let row = |(sign, stops): (&OpensWhen, &BTreeMap<StopModel, Run>)| {
        let answers = document.answers.iter();
        let answers = answers.filter(|answer| answer.opens_when == *sign);
        let answers: Vec<Answer> = answers.map(|answer| answer.answer).collect();
        let word = match answers.as_slice() {
            [first, others @ ..] if others.iter().all(|answer| answer == first) => first.name(),
            _ => "undecided",
        };
        let largest = stops
            .values()
            .max_by(|a, b| highest_rad(document, a).total_cmp(&highest_rad(document, b)));
        let does = match document.opens_by_direction.get(sign) {
            Some(opens) if word == Answer::Fail.name() => opening::sentence(opens, opening::OPENS),
            Some(opens) => opening::sentence(opens, opening::MAY_OPEN),
            None => "the nominal lever stays".into(),
        };
        DirectionRow {
            sign: sign.name(),
            word,
            text: largest.map_or_else(String::new, |run| {
                format!("{does}, {}", peak(document, run))
            }),
        }
    };
    document.polarities.iter().map(row).collect()
}

/// Returns where something was stated, of the word that a document has for it.
pub(super) fn stated(source: &str) -> &str {
    match source {
        "option" => "for this run",
        "card" => "in the card",
        "pulse" => "with the pulse",
        "undeclared" => "nowhere",
        other => other,
    }
}

/// Returns the sign of the recorded acceleration that opens, and where that is stated.
pub(super) fn direction(recording: &RecordingBlock) -> String {
    match &recording.opens_when {
        Some(CardPolarity::Both) => format!(
            "both signs judged, the worse counts; declared {}",
            stated(recording.opens_when_source.name())
        ),
        Some(declared) => format!(
            "opens on {} acceleration, declared {}",
            declared.name(),
            stated(recording.opens_when_source.name())
        ),
        None => "not declared; both signs were judged".into(),
    }
}

/// Returns the answer of each stop, if both were run.
pub(super) fn stops(document: &Document) -> Option<String> {
    if document.models.len() < 2 {
        return document
            .nominal
            .as_ref()
            .map(|run| format!("{} alone", run.model.label()));
    }
    let each: Vec<String> = document
        .models
        .values()
        .map(|run| match opening::of_run(document, run) {
            Some(opens) => format!("{} {opens}", run.model.label()),
            None => match peak_with_error(document, run) {
                KnownPeak::Open(words) => format!("{}: {words}", run.model.label()),
                _ => format!("{} stays, {}", run.model.label(), short_peak(document, run)),
            },
        })
        .collect();
    Some(each.join("; "))
}

/// Returns the ensemble of each stop and opening direction.
pub(super) fn ensembles(document: &Document) -> &[Ensemble] {
    match document.ensembles.is_empty() {
        true => document.ensemble.as_slice(),
        false => &document.ensembles,
    }
}

/// Returns the ensemble on which the answer hangs: of a pass the one of which most may open, of a fail the one of
/// which fewest do, else the one without an answer of which most may open.
pub(super) fn decisive_ensemble(document: &Document) -> Option<&Ensemble> {
    let answers_so = |ensemble: &&Ensemble| {
        let mut answers = document.answers.iter();
        answers.any(|answer| {
            (answer.model, answer.opens_when) == (ensemble.model, ensemble.opens_when)
                && answer.answer == document.verdict
        })
    };
    // Of equal ones that of the run whose angle is shown.
    let shown = leading_run(document).map(|run| (run.model, run.opens_when));
    let is_shown = |ensemble: &Ensemble| shown == Some((ensemble.model, ensemble.opens_when));
    let weight = |ensemble: &Ensemble| match document.verdict {
        Answer::Fail => -ensemble.p_lower,
        _ => ensemble.p_upper_with_coast,
    };
    let candidates = ensembles(document).iter().filter(answers_so);
    let decisive = candidates.max_by(|a, b| {
        let by_weight = weight(a).total_cmp(&weight(b));
        by_weight.then_with(|| is_shown(a).cmp(&is_shown(b)))
    });
    decisive.or(document.ensemble.as_ref())
}

/// Returns the shares that stand beside a decisive one: `rigid stop: 0 of 128`, or that a bound spares a stop.
pub(super) fn other_shares(document: &Document, decisive: &Ensemble) -> Vec<String> {
    let several = document.polarities.len() > 1;
    let others = judged_runs(document)
        .into_iter()
        .filter(|run| (run.model, run.opens_when) != (decisive.model, decisive.opens_when));
    let each = others.filter_map(|run| {
        let place = match several {
            true => place(run.model, run.opens_when),
            false => run.model.label().to_string(),
        };
        let mut own = ensembles(document).iter();
        let own = own.find(|one| (one.model, one.opens_when) == (run.model, run.opens_when));
        match (own, document.answer_of(run)?.bound) {
            (Some(own), _) => Some(format!(
                "{place}: {} of {}",
                count(u64::from(own.exceeded)),
                count(u64::from(own.members))
            )),
            (None, Some(_)) => Some(format!("{place}: none can")),
            (None, None) => None,
        }
    });
    each.collect()
}

/// Returns the stop and direction of an ensemble where several were judged, with a comma behind.
fn place_among_several(document: &Document, ensemble: &Ensemble) -> String {
    match (document.polarities.len() > 1, document.models.len() > 1) {
        (true, _) => format!("{}, ", place(ensemble.model, ensemble.opens_when)),
        (false, true) => format!("{}, ", ensemble.model.label()),
        (false, false) => String::new(),
    }
}

/// Returns how many of the varied levers open, of the decisive stop first.
pub(super) fn varied(document: &Document) -> Option<String> {
    let ensemble = decisive_ensemble(document)?;
    let others = other_shares(document, ensemble);
    let others = others.into_iter().map(|other| format!("; {other}"));
    Some(format!(
        "{} of {} {} open{} ({}{}{}){}",
        count(u64::from(ensemble.exceeded)),
        count(u64::from(ensemble.members)),
        ensemble.varied.members(),
        until(ensemble),
        place_among_several(document, ensemble),
        share(ensemble),
        match ensemble.exceeded_in_coast {
            0 => String::new(),
            members => format!("; {members} more may open later"),
        },
        others.collect::<String>()
    ))
}

/// Returns the share of levers and readings that open, as its bound, with what the bound counts of those that could
/// not be followed.
pub(super) fn share(ensemble: &Ensemble) -> String {
    let answer = match ensemble.p_lower > FAIL_SHARE_WITH_NOMINAL {
        true => Answer::Fail,
        false => Answer::Pass,
    };
    let lost = ensemble.lost_in_words(answer);
    let lost = lost.map_or_else(String::new, |lost| format!("; {lost}"));
    let share = ensemble.share_that_opens(answer);
    format!("{}{lost}", share.replace(" %", "\u{00A0}%"))
}

/// Tells whether nothing varies, so that one lever was judged on one reading of the recording.
pub(super) fn is_alone(document: &Document) -> bool {
    let mut why = document.why.iter();
    why.any(|reason| reason.code == "nothing-varied")
}

/// Returns what an ensemble varies and by how much, levers and readings apart: `preload torque ±5 %,
/// restitution of the stop ±0.02; reading: scale ±1 %, bias ±0.1 g`.
pub(super) fn what_was_varied(document: &Document) -> Option<String> {
    if document.request.members == 0 || document.nominal.is_none() {
        return None;
    }
    let design = &document.design;
    let of_each = design.parameters().filter_map(|parameter| {
        let is_of_lever =
            parameter.has_tolerance() && parameter.counts_at(document.request.model.stops());
        (is_of_lever && design.deviation(parameter)? > 0.0).then(|| {
            Some(format!(
                "{} ±{}",
                parameter.noun,
                tolerance(design, parameter)?
            ))
        })?
    });
    let levers: Vec<String> = of_each.collect();
    let bias_g = bias_error_g(design, document.conditioning.as_ref());
    let mut readings = Vec::new();
    if design.input.scale > 0.0 {
        readings.push(format!(
            "scale ±{}\u{00A0}%",
            trimmed(100.0 * design.input.scale, 3)
        ));
    }
    if bias_g > 0.0 {
        readings.push(format!("bias ±{}\u{00A0}g", trimmed(bias_g, 2)));
    }
    if levers.is_empty() && readings.is_empty() {
        return None;
    }
    let levers = match levers.is_empty() {
        true => "nothing of the lever".into(),
        false => levers.join(", "),
    };
    let readings = match readings.is_empty() {
        true => "nothing".into(),
        false => readings.join(", "),
    };
    Some(format!(
        "{levers}; reading: {readings} (one standard deviation each)"
    ))
}

/// Returns one standard deviation of the sensor's zero, the larger of what the design states and what was measured [g].
fn bias_error_g(design: &Design, conditioning: Option<&ConditioningBlock>) -> f64 {
    let measured = conditioning.map_or(0.0, |block| {
        block.bias_standard_error_m_s2 / STANDARD_GRAVITY
    });
    design.input.bias_g.max(measured)
}

/// Returns the velocity change with one standard deviation, which the sensor's scale and its zero give it:
/// `5.91 m/s ± 0.3 m/s`.
pub(super) fn velocity_change(
    recording: &RecordingBlock,
    design: &Design,
    conditioning: Option<&ConditioningBlock>,
) -> Option<String> {
    let velocity = recording.velocity_change_m_s?;
    let stretch_s = (recording.end_s? - recording.start_s?).min(VELOCITY_STRETCH_S);
    let of_scale = design.input.scale * velocity;
    let of_bias = bias_error_g(design, conditioning) * STANDARD_GRAVITY * stretch_s;
    let deviation = libm::hypot(of_scale, of_bias);
    Some(match deviation > 0.0 {
        true => format!(
            "{}\u{00A0}m/s ± {}\u{00A0}m/s (one standard deviation)",
            trimmed(velocity, 3),
            trimmed(deviation, 2)
        ),
        false => format!("{}\u{00A0}m/s", trimmed(velocity, 3)),
    })
}

/// Returns how far a number scatters, as the design states it, with its unit; `None` if it does not say.
pub(super) fn tolerance(design: &Design, parameter: &DesignParameter) -> Option<String> {
    let stated = design.tolerance.get(parameter.tolerance_key());
    match (parameter.has_tolerance(), stated) {
        (true, Some(share @ Tolerance::Share(_))) => {
            Some(format!("{}\u{00A0}%", trimmed(share.number(), 4)))
        }
        (true, Some(Tolerance::Deviation(deviation))) => {
            let unit = parameter.unit.trim_matches('1').replace(' ', "·");
            let blank = if unit.is_empty() { "" } else { "\u{00A0}" };
            Some(format!("{}{blank}{unit}", exact(*deviation)))
        }
        (true, None) => None,
        (false, _) => design.deviation(parameter).map(exact),
    }
}

/// Returns what the computation's error is against the distance to the limit angle, and the
/// largest influence that it does not count; nothing under a fail, which holds whatever the size of the peak.
pub(super) fn computation(document: &Document, run: &Run) -> Option<String> {
    let error = uncertainty(document, run)?;
    let beyond = error > FRAC_PI_2 || run.peak_angle_rad > FRAC_PI_2;
    if document.verdict == Answer::Fail || beyond || !has_figure(document, run) {
        return None;
    }
    let distance = (document.threshold_rad - run.peak_angle_rad).abs();
    let largest = budget(document)
        .into_iter()
        .skip(3)
        // Where both directions are judged, the other one has its own answer.
        .filter(|row| row.name != "polarity" || document.polarities.len() < 2)
        .filter_map(|row| Some((row.name, row.value?.abs())))
        .max_by(|a, b| a.1.total_cmp(&b.1));
    let largest = largest.map_or_else(String::new, |(name, value)| {
        let value = trimmed(value.to_degrees(), 2);
        format!(" Largest other influence: {name}, {value}° (not included).")
    });
    Some(format!(
        "Error of the largest angle ±{}°; distance to the limit angle {}°.{largest}",
        trimmed(error.to_degrees(), 2),
        trimmed(distance.to_degrees(), 2)
    ))
}

/// Returns a text with a capital first.
pub(super) fn capital(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().into_iter().flat_map(char::to_uppercase);
    first.chain(letters).collect()
}

/// Returns how the signal was conditioned, in a line.
pub(super) fn conditioned(block: &ConditioningBlock) -> String {
    let filter = match block.filter {
        Some(class) => format!("CFC\u{00A0}{}", class.class()),
        None => "no filter".into(),
    };
    let bias = match block.bias_window_s {
        Some(_) => {
            let bias = trimmed(block.bias_m_s2 / STANDARD_GRAVITY, 2);
            format!("bias {bias}\u{00A0}g removed")
        }
        None => "no bias removed".into(),
    };
    let peak = block.peak_g.map_or_else(String::new, |peak| {
        format!(", peak {}\u{00A0}g", trimmed(peak, 4))
    });
    format!("{filter}, {bias}{peak}")
}

/// Returns the answer of the samples before a fault, if it is a fail in one opening direction.
pub(super) fn before_fault(document: &Document) -> Option<&str> {
    let mut why = document.why.iter();
    let reason = why.find(|reason| reason.code == "failed-before-fault")?;
    Some(&reason.text)
}

/// Returns the answer of the recording without its filter, if it differs.
pub(super) fn without_filter(document: &Document) -> Option<String> {
    let chosen = document.conditioning.as_ref()?.filter?;
    let answer = |filter: Option<Cfc>| {
        let row = document.filters.iter().find(|row| row.filter == filter)?;
        Some(row.verdict)
    };
    let (with, without) = (answer(Some(chosen))??, answer(None)??);
    (with != without).then(|| format!("; without the filter: {}", without.name()))
}

/// Returns the facts of the test, names with values.
pub fn test_facts(test: &TestFacts) -> Vec<(&'static str, String)> {
    let location = test.location.as_ref().map(|code| {
        codes::spelt(code).map_or_else(|| code.clone(), |words| format!("{words} ({code})"))
    });
    [
        ("Test", test.test.clone()),
        ("Vehicle", test.vehicle.clone()),
        ("Date", test.date.clone()),
        ("Laboratory", test.laboratory.clone()),
        ("Speed", test.speed.clone()),
        ("Sensor", test.sensor.clone()),
        ("Location", location),
    ]
    .into_iter()
    .filter_map(|(name, value)| Some((name, value?)))
    .collect()
}

/// Returns a peak with its uncertainty and its degrees; beyond 90° that alone.
pub(super) fn peak(document: &Document, run: &Run) -> String {
    match peak_with_error(document, run) {
        KnownPeak::Beyond => "largest angle > 90°".into(),
        KnownPeak::Within(angle) => format!("largest angle {} ({})", angle.degrees, angle.radians),
        KnownPeak::Open(words) => words.into(),
    }
}

/// As [`peak`], in a cell of a table.
pub(super) fn short_peak(document: &Document, run: &Run) -> String {
    peak_with_error(document, run).short()
}

/// Returns true if a peak has a figure: its error is smaller than itself, or keeps it below the limit.
pub(super) fn has_figure(document: &Document, run: &Run) -> bool {
    !matches!(peak_with_error(document, run), KnownPeak::Open(_))
}

/// Returns a peak as it may be shown: without a figure if its error is as large as itself.
fn peak_with_error(document: &Document, run: &Run) -> KnownPeak {
    let opens = document.verdict == Answer::Fail && run.first_crossing_s.is_some();
    KnownPeak::of(
        run.peak_angle_rad,
        uncertainty(document, run),
        document.threshold_rad,
        opens,
    )
}

/// Returns an angle without known error, with its degrees; beyond 90° that alone.
pub(super) fn bounded_angle(radians: f64) -> String {
    if radians > FRAC_PI_2 {
        return "> 90°".into();
    }
    format!(
        "{}° ({}\u{00A0}rad)",
        trimmed(radians.to_degrees(), 3),
        trimmed(radians, 3)
    )
}

/// Returns the largest angle after a filter, as a cell of a table whose head says degrees: an error that leaves no answer
/// leaves no figure either, but for the run that the verdict rests on, whose error is known.
pub(super) fn filtered_angle(
    document: &Document,
    row: &FilterRow,
    radians: f64,
    answer: Option<Answer>,
) -> String {
    let nominal = document.nominal.as_ref().filter(|_| row.chosen);
    let is_known = match nominal {
        Some(run) => has_figure(document, run),
        None => answer != Some(Answer::Undecided),
    };
    match is_known || radians > FRAC_PI_2 {
        true => degrees_cell(radians, 3),
        false => "not known".into(),
    }
}

/// Returns the answer after a filter: of the one in use that of the verdict, where the varied levers make it a fail.
pub(super) fn filtered_answer(document: &Document, row: &FilterRow) -> &'static str {
    match row.verdict {
        None => ABSENT,
        Some(Answer::Undecided) if row.chosen && document.verdict == Answer::Fail => {
            "fail, by the varied levers"
        }
        Some(answer) => answer.name(),
    }
}

/// Returns an angle in a cell of a table whose head says degrees; beyond 90° that alone.
pub(super) fn degrees_cell(radians: f64, digits: usize) -> String {
    if radians.abs() > FRAC_PI_2 {
        return "> 90".into();
    }
    significant(radians.to_degrees(), digits)
}

/// Returns U of a run's peak.
pub(super) fn uncertainty(document: &Document, run: &Run) -> Option<f64> {
    document.answer_of(run)?.uncertainty_rad
}

/// Returns the limit angle with its degrees.
pub(super) fn limit_angle(threshold_rad: f64) -> String {
    let degrees = trimmed(threshold_rad.to_degrees(), 3);
    format!("{degrees}° ({})", limit(threshold_rad))
}

/// Returns an instant or duration with four digits.
pub(super) fn brief_time(seconds: f64) -> String {
    if seconds.abs() < 10.0 {
        format!("{}\u{00A0}ms", trimmed(seconds * 1e3, 4))
    } else {
        format!("{}\u{00A0}s", trimmed(seconds, 6))
    }
}

/// Returns the number of impacts on the stop in words.
pub(super) fn impacts(run: &Run) -> String {
    match run.impacts {
        0 => "the lever does not strike its stop".into(),
        1 => "the lever strikes its stop once".into(),
        many => format!("the lever strikes its stop {many} times"),
    }
}

/// Returns true if a finding holds a laboratory's words.
pub(super) fn is_remark(finding: &Finding) -> bool {
    finding.code.contains("remark")
}

/// Returns true if a finding is shown even without detail.
pub(super) fn is_always_shown(finding: &Finding) -> bool {
    finding.severity > Severity::Info || is_remark(finding)
}

/// Counts the findings: `1 blocking, 2 warnings`.
pub(super) fn findings_count(document: &Document) -> String {
    let number = |severity| {
        let findings = document.findings.iter();
        findings
            .filter(|finding| finding.severity == severity)
            .count()
    };
    let parts: Vec<String> = [
        (number(Severity::Blocking), "blocking", "blocking"),
        (number(Severity::Warning), "warning", "warnings"),
        (number(Severity::Info), "note", "notes"),
    ]
    .into_iter()
    .filter(|(number, _, _)| *number > 0)
    .map(|(number, singular, plural)| {
        format!("{number} {}", if number == 1 { singular } else { plural })
    })
    .collect();
    if parts.is_empty() {
        "none".into()
    } else {
        parts.join(", ")
    }
}

/// Returns the instant up to which members were judged, if a fault ends that before the record does.
pub(super) fn until(ensemble: &Ensemble) -> String {
    ensemble.judged_until_s.map_or_else(String::new, |until_s| {
        format!(" up to {}", instant(until_s))
    })
}

/// Returns the number of members that cross only after the last judged sample, if any do.
pub(super) fn coasting(ensemble: &Ensemble) -> Option<String> {
    (ensemble.exceeded_in_coast > 0).then(|| {
        format!(
            "After the last judged sample {} more coast beyond it (pale), with which up to \
             {}\u{00A0}% cross",
            ensemble.exceeded_in_coast,
            percent_bound(ensemble.p_upper_with_coast, f64::ceil)
        )
    })
}

/// Returns an instant or duration that was given or sampled, with its unit: milliseconds below ten seconds.
pub(super) fn instant(seconds: f64) -> String {
    if seconds.abs() < 10.0 {
        format!("{}\u{00A0}ms", trimmed(seconds * 1e3, 6))
    } else {
        format!("{}\u{00A0}s", trimmed(seconds, 8))
    }
}

/// Returns the limit [rad] with all its digits and its unit.
pub(super) fn limit(threshold_rad: f64) -> String {
    format!("{}\u{00A0}rad", exact(threshold_rad))
}

/// Returns limit − peak [rad] and the same in percent of the limit.
pub(super) fn margin(threshold_rad: f64, peak_rad: f64) -> (f64, f64) {
    let margin = threshold_rad - peak_rad;
    (margin, margin / threshold_rad * 100.0)
}

/// Returns the stop and the opening direction: `rigid stop, negative acceleration`.
pub(super) fn place(model: StopModel, opens_when: OpensWhen) -> String {
    format!("{}, {} acceleration", model.label(), opens_when.name())
}

/// Returns the polarity in words.
pub(super) fn opens(polarity: OpensWhen) -> &'static str {
    match polarity {
        OpensWhen::Negative => "negative opens",
        OpensWhen::Positive => "positive opens",
    }
}

/// Returns the opening direction, the source that declares it, and the sign with which the recording enters the model.
pub(super) fn polarity_sentence(document: &Document) -> String {
    let source = document.recording.opens_when_source.name();
    let place = stated(source);
    let Some(nominal) = &document.nominal else {
        return "Nothing was replayed.".into();
    };
    if source == "undeclared" {
        return "The opening direction is not declared, so both were judged. An answer needs both to agree."
            .into();
    }
    if document.polarities.len() > 1 {
        return format!(
            "Both opening directions were requested {place} and judged. The worse counts."
        );
    }
    match nominal.opens_when {
        OpensWhen::Negative => format!(
            "Negative recorded acceleration opens the lever (declared {place}). It enters the model as it is."
        ),
        OpensWhen::Positive => format!(
            "Positive recorded acceleration opens the lever (declared {place}). It enters the model with its sign changed."
        ),
    }
}

/// Returns the name of a report: the first eight digits of its identity, which stand in its
/// folder's name, its page and its plots.
pub(super) fn report_name(document: &Document) -> String {
    let digits = document.report_id.chars();
    digits.filter(char::is_ascii_alphanumeric).take(8).collect()
}

/// Returns the design's name, or that it is the paper's example, with the keys that were overridden, their values and what these took
/// the place of: `cable lever, modified: preload torque 5 N·m (0.1)`.
pub(super) fn design(design: &Design) -> String {
    let keys: Vec<String> = design
        .modified
        .iter()
        .map(|key| modified(design, key))
        .collect();
    if design.repeats_reference() {
        let of = match design.catch {
            Some(_) => "of lever and stop ",
            None => "",
        };
        return format!("{} (all values {of}as in the paper's example)", design.name);
    }
    match (design.is_reference_overridden(), keys.is_empty()) {
        (true, true) => "the paper's example lever, no vehicle's".into(),
        (true, false) => format!("the paper's example lever, modified: {}", keys.join("; ")),
        (false, true) => design.name.clone(),
        (false, false) => format!("{}, modified: {}", design.name, keys.join("; ")),
    }
}

/// Returns the numbers of lever, stop and criterion.
pub(super) fn lever_parameters(design: &Design) -> impl Iterator<Item = &'static DesignParameter> {
    let parameters = design.parameters();
    parameters.filter(|parameter| !matches!(parameter.slot, Slot::InputScale | Slot::InputBias))
}

/// Returns those of them that nobody stated.
pub(super) fn unstated(design: &Design) -> Vec<&'static DesignParameter> {
    let is_unstated =
        |parameter: &&DesignParameter| design.not_stated.iter().any(|key| key == parameter.name);
    lever_parameters(design).filter(is_unstated).collect()
}

/// Returns the design with the number of its values that nobody stated.
pub(super) fn with_unstated(shown: &Design) -> String {
    let name = design(shown);
    match unstated(shown).len() {
        0 => name,
        // These names say it.
        _ if shown.repeats_reference() || shown.is_reference_overridden() => name,
        1 => format!("{name}; 1 value not stated, taken from the paper's example"),
        count => format!("{name}; {count} values not stated, taken from the paper's example"),
    }
}

/// Says which second channel drives the lever, and how much of it, if one was given.
pub(crate) fn in_plane(document: &Document) -> Option<String> {
    let block = document.in_plane.as_ref()?;
    let InPlane {
        second_axis,
        tangential,
        radial,
    } = block.directions;
    let peak = block.peak_g.map_or_else(String::new, |peak| {
        format!(", peak {}\u{00A0}g", trimmed(peak, 4))
    });
    // The right door is the left one's mirror image: Y changes its sign.
    let side = if block.door.as_deref() == Some("right") {
        -1.0
    } else {
        1.0
    };
    let sum = |[y, second]: [f64; 2]| weighted([(side * y, 'Y'), (second, second_axis)]);
    Some(format!(
        "{} along {second_axis}{peak}; {} door: {} along the lever's way, {} across",
        block.radial_channel,
        block.door.as_deref().unwrap_or("left"),
        sum(tangential),
        sum(radial),
    ))
}

/// Writes a sum of two axes, without those that do not count: `−X`, `0.5 Y + 0.866 X`.
fn weighted(terms: [(f64, char); 2]) -> String {
    let mut sum = String::new();
    for (weight, axis) in terms {
        let size = trimmed(weight.abs(), 3);
        if size == "0" {
            continue;
        }
        sum += match (sum.is_empty(), weight < 0.0) {
            (true, true) => "\u{2212}",
            (true, false) => "",
            (false, true) => " \u{2212} ",
            (false, false) => " + ",
        };
        if size != "1" {
            sum += &format!("{size}\u{00A0}");
        }
        sum.push(axis);
    }
    sum
}

/// Says what an inertia catch did beside the leading run, if the design has one.
pub(crate) fn catch(document: &Document) -> Option<&str> {
    let mut reasons = document.why.iter();
    let reason = reasons.find(|reason| reason.code == "catch")?;
    Some(&reason.text)
}

fn modified(design: &Design, key: &str) -> String {
    let (tolerance, name) = match key.strip_prefix("tolerance.") {
        Some(name) => ("tolerance of ", name),
        None => ("", key),
    };
    let parameter = PARAMETERS
        .iter()
        .chain(CATCH_PARAMETERS)
        .find(|parameter| parameter.name == name || parameter.tolerance_key() == name);
    let what = parameter.map_or_else(
        || name.to_string(),
        |parameter| {
            let mut letters = parameter.what.chars();
            let first = letters.next().into_iter().flat_map(char::to_lowercase);
            first.chain(letters).collect()
        },
    );
    let unit = parameter
        .map_or("", |parameter| parameter.unit)
        .trim_matches('1');
    let unit = unit.replace(' ', "·");
    let number = |value: Option<f64>| value.map_or_else(|| "none".into(), exact);
    let share = design.tolerance.get(name).filter(|_| !tolerance.is_empty());
    if let Some(share @ Tolerance::Share(_)) = share {
        return format!("{tolerance}{what} {share}");
    }
    let blank = if unit.is_empty() { "" } else { "\u{00A0}" };
    format!(
        "{tolerance}{what} {}{blank}{unit} ({})",
        number(design.number(key)),
        number(design.modified_from.get(key).copied())
    )
}

/// Returns the word of a page for the severity of a finding.
pub(super) fn severity(severity: Severity) -> &'static str {
    match severity {
        Severity::Info => "note",
        other => other.name(),
    }
}

/// Returns the words for a number of the design, given by its name, in a sentence.
pub(super) fn parameter(name: &str) -> &str {
    match name {
        "input.radial_scale" => "scale of the second channel",
        "input.radial_bias_g" => "bias of the second channel",
        _ => DesignParameter::named(name).map_or(name, |parameter| parameter.noun),
    }
}

/// Returns the unit of a number of the design, given by its name; a ratio has none.
pub(super) fn parameter_unit(name: &str) -> &'static str {
    match DesignParameter::named(name) {
        Some(parameter) if parameter.unit != "1" => parameter.unit,
        _ => "",
    }
}

/// Returns which parameter drives the peak, in a sentence.
pub(super) fn drivers_sentence(ensemble: &Ensemble) -> String {
    let chance = ensemble.rank_correlation_by_chance.unwrap_or(1.0);
    let strong: Vec<_> = ensemble
        .drivers
        .iter()
        .filter_map(|driver| Some((driver, driver.rank_correlation?, driver.share?)))
        .collect();
    match strong.first() {
        None => "No parameter drives the peak: either none is varied, or the peak is the same \
                 for all members."
            .into(),
        Some((_, correlation, _)) if correlation.abs() <= chance => {
            "No parameter goes with the peak beyond what chance gives among so many members: what \
             moves it are their combinations, as when a chain of impacts falls out differently."
                .into()
        }
        Some((driver, correlation, share)) => format!(
            "The {} drives the peak most: its rank correlation with it is {}, which is {:.0}\u{00A0}% of \
             the squares of all. The shaded strip is what chance alone gives.",
            parameter(&driver.parameter),
            significant(*correlation, 2),
            100.0 * share
        ),
    }
}

/// Returns a text as a sentence: a capital first, if it begins with a plain word and not with
/// a name, and a full stop after a last letter or digit.
pub(super) fn sentence(text: &str) -> String {
    let first_word = text.split([' ', ',']).next().unwrap_or_default();
    let plain = !first_word.is_empty() && first_word.chars().all(|c| c.is_ascii_lowercase());
    let mut out = String::with_capacity(text.len() + 1);
    if plain {
        out.push_str(&text[..1].to_ascii_uppercase());
        out.push_str(&text[1..]);
    } else {
        out.push_str(text);
    }
    if out.ends_with(|c: char| c.is_alphanumeric() || matches!(c, ')' | '`')) {
        out.push('.');
    }
    out
}

/// One part of the error budget.
pub(super) struct BudgetRow {
    /// Its name in the verdict.
    pub(super) name: &'static str,
    /// The quantity that was varied.
    pub(super) meaning: &'static str,
    /// Change of the nominal peak [rad].
    pub(super) value: Option<f64>,
    /// Reason where there is no value.
    pub(super) absent: &'static str,
}

/// Returns the parts of the error budget with their words.
pub(super) fn budget(document: &Document) -> [BudgetRow; 7] {
    let ErrorBudget {
        numerical,
        interpolation,
        noise,
        noise_97_5,
        model,
        filter,
        bias,
        polarity,
    } = document.error_budget_rad;
    let unmeasured = "not measured: no rerun was possible";
    let conditioning = document.conditioning.as_ref();
    let unfiltered = conditioning.is_some_and(|block| block.filter.is_none());
    let unbiased = conditioning.is_some_and(|block| block.bias_window_s.is_none());
    let declared = document.recording.opens_when_source != PolaritySource::Undeclared;
    let unless = |applies: bool, reason| if applies { reason } else { unmeasured };
    [
        BudgetRow {
            name: "numerical",
            meaning: "integration and rounding, as the integrator bounds them",
            value: numerical,
            absent: unmeasured,
        },
        BudgetRow {
            name: "interpolation",
            meaning: "what may lie between the samples",
            value: interpolation,
            absent: unmeasured,
        },
        BudgetRow {
            name: "noise",
            meaning: "noise before contact, twice its deviation or more, as drawn",
            value: noise.map(|noise| (NOISE_TIMES * noise).max(noise_97_5.unwrap_or(0.0))),
            absent: unmeasured,
        },
        BudgetRow {
            name: "model",
            meaning: "rigid stop against soft stop",
            value: model,
            absent: unless(document.models.len() < 2, "only one stop was run"),
        },
        BudgetRow {
            name: "filter",
            meaning: "the filter chosen against none",
            value: filter,
            absent: unless(unfiltered, "no filter was applied"),
        },
        BudgetRow {
            name: "bias",
            meaning: "a standard error more and less bias, the larger change",
            value: bias,
            absent: unless(unbiased, "no bias was removed"),
        },
        BudgetRow {
            name: "polarity",
            meaning: "one opening direction against the other",
            value: polarity,
            absent: unless(declared, "the sign is declared"),
        },
    ]
}

/// Returns the settings of a request, a line each; those that it leaves to card and file are left
/// out.
pub(super) fn settings(request: &impl Serialize) -> String {
    let settings = serde_json::to_value(request).unwrap_or_default();
    let lines: Vec<String> = settings
        .as_object()
        .into_iter()
        .flatten()
        .map(|(key, value)| format!("{key} = {value}"))
        .collect();
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::sentence;

    #[test]
    fn verif_a_sentence_that_ends_in_a_setting_has_its_full_stop() {
        for (text, expected) in [
            (
                "confirm it with the setting `unit`",
                "Confirm it with the setting `unit`.",
            ),
            ("a peak (filtered)", "A peak (filtered)."),
            ("it is done.", "It is done."),
        ] {
            assert_eq!(sentence(text), expected);
        }
    }
}
