//! Words that the terminal and the page share.

use crate::model::stop::StopModel;
use crate::recording::Severity;
use crate::report::Document;
use crate::report::number::{exact, milliseconds, significant, trimmed};
use crate::request::PolaritySource;
use crate::units::OpensWhen;
use crate::verdict::{Answer, Ensemble, ErrorBudget};
use serde::Serialize;

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

/// Returns what the verdict means, in half a sentence. Without an ensemble it claims no more
/// than that the errors of the computation are covered.
pub(super) fn meaning(document: &Document) -> &'static str {
    let ensemble = document.ensemble.is_some();
    match document.verdict {
        Answer::Pass if ensemble => "the lever stays below the limit, uncertainty included",
        Answer::Pass => "the nominal lever stays below the limit, numerical error included",
        Answer::Fail if ensemble => "the lever crosses the limit, uncertainty included",
        Answer::Fail => "the nominal lever crosses the limit, numerical error included",
        Answer::Undecided if ends_too_early(document) => {
            "the lever may cross the limit after the last judged sample"
        }
        Answer::Undecided => "the uncertainty of input, model or method spans the limit",
        Answer::Unusable => "the recording cannot carry an answer",
    }
}

fn ends_too_early(document: &Document) -> bool {
    document.why.first().is_some_and(|reason| {
        matches!(
            &*reason.code,
            "coast-reaches-limit" | "members-coast-beyond"
        )
    })
}

/// Returns up to when members were judged, where a fault ends that before the record does.
pub(super) fn until(ensemble: &Ensemble) -> String {
    ensemble
        .judged_until_s
        .map_or_else(String::new, |at| format!(" up to {}", instant(at)))
}

/// Returns how many members cross only after the last judged sample, if any do.
pub(super) fn coasting(ensemble: &Ensemble) -> Option<String> {
    (ensemble.exceeded_in_coast > 0).then(|| {
        format!(
            "After the last judged sample {} more coast beyond it (pale), with which up to \
             {}\u{00A0}% cross",
            ensemble.exceeded_in_coast,
            percent(ensemble.p_upper_with_coast)
        )
    })
}

/// Returns an instant or duration [s] with its unit: milliseconds below ten seconds.
pub(super) fn time(seconds: f64) -> String {
    if seconds.abs() < 10.0 {
        format!("{}\u{00A0}ms", milliseconds(seconds, DIGITS))
    } else {
        format!("{}\u{00A0}s", significant(seconds, 7))
    }
}

/// As [`time`] without zeros at the end: for instants that were given or sampled.
pub(super) fn instant(seconds: f64) -> String {
    if seconds.abs() < 10.0 {
        format!("{}\u{00A0}ms", trimmed(seconds * 1e3, 6))
    } else {
        format!("{}\u{00A0}s", trimmed(seconds, 8))
    }
}

/// Returns an angle [rad] with its unit.
pub(super) fn angle(radians: f64) -> String {
    format!("{}\u{00A0}rad", significant(radians, DIGITS))
}

/// Returns the limit [rad] with all its digits and its unit.
pub(super) fn limit(document: &Document) -> String {
    format!("{}\u{00A0}rad", exact(document.threshold_rad))
}

/// Returns limit − peak [rad] and the same in percent of the limit.
pub(super) fn margin(threshold_rad: f64, peak_rad: f64) -> (f64, f64) {
    let margin = threshold_rad - peak_rad;
    (margin, margin / threshold_rad * 100.0)
}

/// Returns the stop in words.
pub(super) fn stop(model: StopModel) -> &'static str {
    match model {
        StopModel::Rigid => "rigid stop",
        StopModel::Soft => "soft stop",
    }
}

/// Returns the polarity in words.
pub(super) fn opens(polarity: OpensWhen) -> &'static str {
    match polarity {
        OpensWhen::Negative => "negative opens",
        OpensWhen::Positive => "positive opens",
    }
}

/// Returns which recorded sign opens the lever, who says so, and how it enters the model.
pub(super) fn polarity_sentence(document: &Document) -> String {
    let entered = "A positive model acceleration holds the lever.";
    let source = document.recording.opens_when_source.name();
    let Some(nominal) = &document.nominal else {
        return format!("Nothing was replayed, so no sign was applied. {entered}");
    };
    if source == "undeclared" {
        return format!(
            "Neither an option nor a card declares which sign of the recorded acceleration opens \
             the lever, so both were judged; only where they agree is there an answer. {entered}"
        );
    }
    if document.polarities.len() > 1 {
        return format!(
            "Both signs of the recorded acceleration were asked for (by {source}) and judged; the \
             worse counts. {entered}"
        );
    }
    match nominal.opens_when {
        OpensWhen::Negative => format!(
            "A negative recorded acceleration opens the lever (declared by {source}); the \
             recording enters the model with its sign as it is. {entered}"
        ),
        OpensWhen::Positive => format!(
            "A positive recorded acceleration opens the lever (declared by {source}); the \
             recording enters the model with its sign changed. {entered}"
        ),
    }
}

/// Returns the report's identity: the first twelve digits of the recording's hash and the
/// design's name, letters, digits, `-`, `_` and `.` kept.
pub(super) fn identity(document: &Document) -> String {
    let mut id: String = document
        .recording
        .sha256
        .as_deref()
        .unwrap_or("unread")
        .chars()
        .filter(char::is_ascii_alphanumeric)
        .take(12)
        .collect();
    id.push('-');
    id.extend(document.design.name.chars().take(60).map(|c| {
        if c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.') {
            c
        } else {
            '-'
        }
    }));
    id
}

/// Returns a share [-] in percent, with the digits that matter near the bounds of the rule.
pub(super) fn percent(share: f64) -> String {
    trimmed(100.0 * share, 4)
}

/// Returns the word of a page for the severity of a finding.
pub(super) fn severity(severity: Severity) -> &'static str {
    match severity {
        Severity::Info => "note",
        other => other.name(),
    }
}

/// Returns what a design key of an ensemble's parameter means.
pub(super) fn parameter(key: &str) -> &str {
    match key {
        "input.scale" => "scale of the acceleration",
        "input.bias_g" => "bias of the acceleration",
        "lever.moment_of_inertia_kg_m2" => "moment of inertia",
        "lever.pivot_damping_nm_s_per_rad" => "damping at the pivot",
        "lever.spring_stiffness_nm_per_rad" => "stiffness of the spring",
        "lever.preload_torque_nm" => "preload torque",
        "lever.mass_kg" => "mass of the lever",
        "lever.center_of_mass_m" => "distance of its centre of mass",
        "stop.restitution" => "restitution of the stop",
        "stop.stiffness_n_per_m" => "stiffness of the stop",
        "stop.damping_n_s_per_m" => "damping of the stop",
        "stop.radius_m" => "distance of the stop",
        other => other,
    }
}

/// Returns the unit of a design key of an ensemble's parameter.
pub(super) fn parameter_unit(key: &str) -> &'static str {
    match key {
        "input.bias_g" => "g",
        "lever.moment_of_inertia_kg_m2" => "kg m²",
        "lever.pivot_damping_nm_s_per_rad" => "N m s/rad",
        "lever.spring_stiffness_nm_per_rad" => "N m/rad",
        "lever.preload_torque_nm" => "N m",
        "lever.mass_kg" => "kg",
        "lever.center_of_mass_m" | "stop.radius_m" => "m",
        "stop.stiffness_n_per_m" => "N/m",
        "stop.damping_n_s_per_m" => "N s/m",
        // Scale and restitution are ratios.
        _ => "",
    }
}

/// Says which parameter drives the peak.
pub(super) fn drivers_sentence(ensemble: &Ensemble) -> String {
    let chance = ensemble.rank_correlation_by_chance.unwrap_or(1.0);
    let strong: Vec<_> = ensemble
        .drivers
        .iter()
        .filter_map(|driver| Some((driver, driver.rank_correlation?, driver.share?)))
        .collect();
    match strong.first() {
        None => "No parameter drives the peak: either nothing is scattered, or the peak is the                  same for all members."
            .into(),
        Some((_, correlation, _)) if correlation.abs() <= chance => {
            "No parameter goes with the peak beyond what chance gives among so many members: what              moves it are their combinations, as when a chain of impacts falls out differently."
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
    /// What was varied.
    pub(super) meaning: &'static str,
    /// Change of the nominal peak [rad].
    pub(super) value: Option<f64>,
    /// Why there is no value, where there is none.
    pub(super) absent: &'static str,
}

/// Returns the parts of the error budget with their words.
pub(super) fn budget(document: &Document) -> [BudgetRow; 6] {
    let ErrorBudget {
        numerical,
        interpolation,
        model,
        filter,
        bias,
        polarity,
    } = document.error_budget_rad;
    let unmeasured = "not measured: no rerun was possible";
    let conditioning = document.conditioning.as_ref();
    let unfiltered = conditioning.is_some_and(|block| block.filter == "none");
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
            meaning: "straight lines between samples against a band-limited fourfold of them",
            value: interpolation,
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
            meaning: "one standard error more and less bias, the larger change of the two",
            value: bias,
            absent: unless(unbiased, "no bias was removed"),
        },
        BudgetRow {
            name: "polarity",
            meaning: "the sign as declared against reversed",
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
