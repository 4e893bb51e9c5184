//! The inputs of the verdict: recording, conditioning, design, provenance, limits.

use super::markup::{code_fact, fact, heads};
use crate::escape::terminal as line;
use crate::sensor_place::{sensor_place, siblings};
use crate::words::{self, DIGITS, instant};
use latchgate_document::Document;
use latchgate_document::blocks::{
    ConditioningBlock, InPlaneBlock, RecordingBlock, SiblingBlock, TransferBlock,
};
use latchgate_document::identity::design_sha256;
use latchgate_document::number::{ABSENT, count, exact, significant, trimmed};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::parameters::{DesignParameter, Slot};
use latchgate_kernel::model::tolerance::Tolerance;
use latchgate_kernel::units::STANDARD_GRAVITY;
use latchgate_recording::TestFacts;
use latchgate_verdict::conditioning::FilterStandard;
use latchgate_verdict::in_plane::InPlane;
use maud::{Markup, html};

/// Returns what was judged: test, channel, design.
pub(super) fn judged(
    test: &TestFacts,
    recording: &RecordingBlock,
    design: &Design,
    lifts_off_g: Option<f64>,
    conditioning: Option<&ConditioningBlock>,
    transfer: Option<&TransferBlock>,
    together: &[SiblingBlock],
) -> Markup {
    html! {
        section #judged {
            h2 { "What was judged" }
            div.sides {
                table.facts {
                    tbody {
                        (fact("File", &recording.file))
                        @if let Some(channel) = &recording.channel { (fact("Channel", channel)) }
                        @for (name, value) in words::test_facts(test) { (fact(name, &value)) }
                    }
                }
                table.facts {
                    tbody {
                        (fact("Design", &words::with_unstated(design)))
                        @if let Some(lifts_off_g) = lifts_off_g.filter(|level| level.is_finite()) {
                            (fact("Lifts off at rest", &format!("above {}\u{00A0}g", trimmed(lifts_off_g, 3))))
                        }
                        (fact("Opening direction", &words::direction(recording)))
                        @if let Some(place) = sensor_place(recording, transfer) { (fact("Sensor's place", &place)) }
                        @if let Some(each) = siblings(together) { (fact("Channels judged", &each)) }
                        @if let Some(samples) = samples(recording) { (fact("Samples", &samples)) }
                        @if let Some(block) = conditioning { (fact("Signal", &words::conditioned(block))) }
                        @if let Some(velocity) = words::velocity_change(recording, design, conditioning) {
                            (fact("Velocity change", &velocity))
                        }
                    }
                }
            }
        }
    }
}

/// Returns number, rate and span of the samples.
fn samples(recording: &RecordingBlock) -> Option<String> {
    let (start_s, end_s) = (recording.start_s?, recording.end_s?);
    let rate = hertz(recording.sample_rate_hz?);
    let samples = count(recording.samples as u64);
    Some(format!(
        "{samples} at {rate}, {} to {}",
        words::brief_time(start_s),
        words::brief_time(end_s)
    ))
}

/// Returns the lines to sign on.
pub(super) fn signature() -> Markup {
    html! { div.sign { span { "Checked by" } span { "Date" } span { "Signature" } } }
}

/// Returns what tells this verdict from any other: the rule, the files, the run.
pub(super) fn record(document: &Document) -> Markup {
    let (recording, run) = (&document.recording, &document.run);
    let revision = run.numbers_revision;
    let revision = revision.map_or_else(String::new, |revision| {
        format!(", numbers revision {revision}")
    });
    html! {
        section #record {
            h2 { "Decision rule and record" }
            div.statement.rule {
                @for part in parts(&document.decision_rule) {
                    @let (before, answers) = answers(part);
                    p { (line(before)) }
                    @if !answers.is_empty() {
                        table { tbody { @for (answer, condition) in &answers { (fact(answer, condition)) } } }
                    }
                }
            }
            div.sides {
                table.facts {
                    tbody {
                        (code_fact("SHA-256 of the recording", recording.sha256.as_deref().unwrap_or("not read")))
                        @if let Some(sha256) = &recording.card_sha256 { (code_fact("SHA-256 of its card", sha256)) }
                        @match &run.design_file_sha256 {
                            Some(sha256) => (code_fact("SHA-256 of the design file", sha256)),
                            None => (code_fact("SHA-256 of the design, as judged", &design_sha256(&document.design))),
                        }
                        (code_fact("Report", &document.report_id))
                    }
                }
                table.facts {
                    tbody {
                        (fact("Design file", run.design_file.as_deref().unwrap_or("none")))
                        (fact("Program", &format!("latchgate {}{revision}", run.version)))
                        (fact("Run on", run.date.as_deref().unwrap_or(ABSENT)))
                        (fact("Made by", run.by.as_deref().unwrap_or("not stated")))
                    }
                }
            }
            (signature())
        }
    }
}

/// Returns the numbered parts of a rule, what stands before the first at the front.
fn parts(rule: &str) -> Vec<&str> {
    let (mut parts, mut rest) = (Vec::new(), rule);
    for number in 1.. {
        let Some(start) = rest.find(&format!("({number}) ")) else {
            break;
        };
        let (before, after) = rest.split_at(start);
        parts.push(before.trim());
        rest = after;
    }
    parts.push(rest.trim());
    parts
}

/// Splits a part of the rule that says when each answer is given: what stands before, and each answer with its
/// condition. Of another part all of it stands before.
fn answers(part: &str) -> (&str, Vec<(&'static str, String)>) {
    const ANSWERS: [(&str, [&str; 3]); 3] = [
        ("pass", [": pass, if ", ": pass if ", ": pass, "]),
        ("fail", ["; fail, if ", "; fail if ", "; fail, "]),
        (
            "undecided",
            ["; undecided, if ", "; else undecided", "; undecided, "],
        ),
    ];
    let starts = ANSWERS.map(|(answer, words)| {
        let found = words
            .iter()
            .find_map(|word| Some((part.find(word)?, word.len())));
        found.map(|(at, length)| (answer, at, at + length))
    });
    let [Some(pass), Some(fail), Some(undecided)] = starts else {
        return (part, Vec::new());
    };
    if !(pass.1 < fail.1 && fail.1 < undecided.1) {
        return (part, Vec::new());
    }
    let condition = |from: usize, until: usize| match part[from..until].trim_matches(['.', ' ']) {
        "" => "otherwise".to_string(),
        condition => format!("if {condition}"),
    };
    let rows = vec![
        (pass.0, condition(pass.2, fail.1)),
        (fail.0, condition(fail.2, undecided.1)),
        (undecided.0, condition(undecided.2, part.len())),
    ];
    // The colon belongs to what stands before.
    (&part[..=pass.1], rows)
}

/// Returns the lever's numbers.
pub(super) fn lever(design: &Design) -> Markup {
    let numbers: Vec<_> = words::lever_parameters(design).collect();
    let is_unstated =
        |parameter: &DesignParameter| design.not_stated.iter().any(|key| key == parameter.name);
    html! {
        section #lever {
            h2 { "Lever, stop and criterion" }
            div.sides {
                @for half in numbers.chunks(numbers.len().div_ceil(2)) {
                    table.facts {
                        tbody {
                            @for parameter in half {
                                @let unit = if parameter.unit == "1" { String::new() } else { parameter.unit.replace(' ', "·") };
                                @let is_scattered = design.deviation(parameter).is_some_and(|deviation| deviation > 0.0);
                                @let tolerance = design.tolerance.get(parameter.tolerance_key()).filter(|_| is_scattered);
                                tr {
                                    th {
                                        (parameter.what)
                                        @if is_unstated(parameter) { "\u{00A0}*" }
                                    }
                                    td {
                                        (exact(design.value(parameter)))
                                        @if let Some(Tolerance::Deviation(deviation)) = tolerance { " ± " (exact(*deviation)) }
                                        "\u{00A0}" (unit)
                                        @if let Some(share @ Tolerance::Share(_)) = tolerance { " ± " (share) }
                                    }
                                }
                            }
                        }
                    }
                }
            }
            p.note {
                "± is one standard deviation."
                @if numbers.iter().any(|parameter| is_unstated(parameter)) { " * not stated: the value of the paper's example." }
            }
        }
    }
}

/// Returns the recording as read.
pub(super) fn recording(document: &Document) -> Markup {
    let recording = &document.recording;
    let unit = match (&recording.unit, &recording.unit_source) {
        (Some(unit), Some(source)) => format!("{}, stated: {}", unit.name(), words::stated(source)),
        (Some(unit), None) => unit.name().to_string(),
        _ => ABSENT.to_string(),
    };
    let samples = match (recording.start_s, recording.end_s) {
        (Some(start), Some(end)) => format!("{} to {}", instant(start), instant(end)),
        _ => ABSENT.into(),
    };
    html! {
        h3 { "Recording" }
        table.facts {
            tbody {
                (fact("File", &recording.file))
                (code_fact("SHA-256", recording.sha256.as_deref().unwrap_or("not read")))
                (fact("Format", recording.format.as_deref().unwrap_or(ABSENT)))
                (fact("Channel", recording.channel.as_deref().unwrap_or(ABSENT)))
                (fact("Unit, and what states it", &unit))
                (fact("Samples", &count(recording.samples as u64)))
                (fact("Sample rate", &or(ABSENT, recording.sample_rate_hz.map(hertz))))
                (fact("First and last sample", &samples))
                (fact("Largest magnitude as recorded", &or(ABSENT, magnitude(recording.peak_g, recording.peak_time_s))))
                @if let Some(velocity) = recording.velocity_change_m_s {
                    tr {
                        th { "Velocity change" }
                        td {
                            (significant(velocity, DIGITS)) "\u{00A0}m/s, the largest |∫a dt| over any 0.3\u{00A0}s, "
                            "as recorded without bias"
                        }
                    }
                }
                @if let Some(sha256) = &recording.content_sha256 {
                    (code_fact("SHA-256 of the channel's signal", sha256))
                }
                @for part in &recording.parts { (code_fact(&format!("SHA-256 of {}", part.file), &part.sha256)) }
                @if let Some(sha256) = &recording.card_sha256 { (code_fact("SHA-256 of its card", sha256)) }
                @else { (fact("Card", "none")) }
            }
        }
    }
}

/// Returns the conditioning of the recording.
pub(super) fn conditioning(document: &Document) -> Markup {
    html! {
        h3 { "Conditioning" }
        @if let Some(block) = &document.conditioning { table.facts { tbody { (conditioning_facts(block)) } } }
        @else { p { "Nothing was conditioned." } }
        @if let Some(block) = &document.in_plane { table.facts { tbody { (second_channel(block)) } } }
    }
}

fn conditioning_facts(block: &ConditioningBlock) -> Markup {
    let rate = block.resample_hz;
    let rate = rate.map(|rate| format!("{}, band-limited", hertz(rate)));
    let range = block.range_g;
    let range = range.map(|range| format!("{}\u{00A0}g", exact(range)));
    html! {
        (bias(block))
        (fact("Rate fed to the model", &or("as recorded", rate)))
        (filter(block))
        @if let Some(magnitude) = magnitude(block.peak_g, block.peak_time_s) {
            (fact("Largest magnitude as used", &magnitude))
        }
        @if let Some(range) = range { (fact("Full scale, stated in the card", &range)) }
        @if block.synthetic {
            (fact("Made by a formula, as the card states", "yes: clipping and dead sensors were not looked for"))
        }
        (fact("Order", "units, faults, bias, resampling, filter; the sign enters last, in the model"))
    }
}

/// Returns how the second in-plane channel was used.
fn second_channel(block: &InPlaneBlock) -> Markup {
    let InPlane {
        second_axis,
        tangential,
        radial,
    } = block.directions;
    let cosines =
        |[y, second]: [f64; 2]| format!("{} of Y, {} of {second_axis}", exact(y), exact(second));
    html! {
        (fact("Second in-plane channel", &format!("{}, along {second_axis}, conditioned as the judged one", block.radial_channel)))
        (fact("Along the way of the centre of mass, left door", &cosines(tangential)))
        (fact("From the pivot to it, left door", &cosines(radial)))
        (fact("Bias removed of it", &format!("{}\u{00A0}m/s² ± {}", significant(block.bias_m_s2, DIGITS), significant(block.bias_standard_error_m_s2, 4))))
        @if let Some(magnitude) = magnitude(block.peak_g, block.peak_time_s) {
            (fact("Largest magnitude of it as used", &magnitude))
        }
    }
}

/// Returns the bias that was removed, with its error.
fn bias(block: &ConditioningBlock) -> Markup {
    let Some((from, to)) = block.bias_window_s else {
        return fact("Bias removed", "none");
    };
    let acceleration = |value: f64| {
        format!(
            "{}\u{00A0}m/s² ({}\u{00A0}g)",
            significant(value, DIGITS),
            significant(value / STANDARD_GRAVITY, 4)
        )
    };
    html! {
        (fact("Bias removed", &acceleration(block.bias_m_s2)))
        (fact("Its standard error", &acceleration(block.bias_standard_error_m_s2)))
        (fact("Method of that error", &block.bias_standard_error_method))
        tr {
            th { "Bias window" }
            td { (instant(from)) " to " (instant(to)) ", " (count(block.bias_samples as u64)) " samples" }
        }
    }
}

/// Returns the filter, with its standard.
fn filter(block: &ConditioningBlock) -> Markup {
    let Some(class) = block.filter else {
        return fact("Filter", "none");
    };
    let standard = match block.filter_standard {
        FilterStandard::Iso6487 => "ISO 6487: fd = 25/12 · CFC",
        FilterStandard::SaeJ211 => "SAE J211-1: fd = 2.0775 · CFC",
    };
    let design = block.filter_design_frequency_hz;
    let design = design.map(|design| format!("{}\u{00A0}Hz", trimmed(design, 7)));
    html! {
        tr { th { "Filter" } td { "CFC " (class.class()) ", two passes of a two-pole Butterworth, no phase" } }
        (fact("Standard and its constant", standard))
        (fact("Design frequency fd", &or(ABSENT, design)))
        (fact("End treatment", block.filter_end_treatment.as_deref().unwrap_or(ABSENT)))
    }
}

fn hertz(rate: f64) -> String {
    format!("{}\u{00A0}Hz", exact(rate))
}

/// Returns the largest magnitude [g] with its time, if it has one.
fn magnitude(peak_g: Option<f64>, time_s: Option<f64>) -> Option<String> {
    let instant_text = time_s.map_or_else(String::new, |time| format!(" at {}", instant(time)));
    Some(format!(
        "{}\u{00A0}g{instant_text}",
        significant(peak_g?, DIGITS)
    ))
}

/// Returns a value in words, or `absent`.
fn or(absent: &str, value: Option<String>) -> String {
    value.unwrap_or_else(|| absent.into())
}

/// Returns the design with its tolerances.
pub(super) fn design(document: &Document) -> Markup {
    let design = &document.design;
    let columns = [
        "Quantity",
        "Symbol",
        "#Value",
        "Unit",
        "#Tolerance (one standard deviation)",
    ];
    html! {
        p { strong { (line(&words::design(design))) } }
        table.design {
            (heads(&columns))
            tbody {
                @for parameter in design.parameters() {
                    @let modified = design.modified.iter().any(|key| {
                        key == parameter.name || key.strip_prefix("tolerance.") == Some(parameter.tolerance_key())
                    });
                    @let unstated = design.not_stated.iter().any(|key| key == parameter.name);
                    tr .nominal[modified] {
                        th {
                            (parameter.what)
                            @if modified { ", modified" }
                            @if unstated { ", not stated: the example's" }
                        }
                        td { (parameter.symbol) }
                        td.number {
                            @match parameter.slot {
                                // The nominal input has no factor or offset to show; only its uncertainty is stated.
                                Slot::InputScale | Slot::InputBias => (ABSENT),
                                Slot::Lever(_) | Slot::Stop(_) | Slot::Catch(_) | Slot::Criterion(_) => (exact(design.value(parameter))),
                            }
                        }
                        td { (parameter.unit) }
                        td.number { (or(ABSENT, words::tolerance(design, parameter))) }
                    }
                }
            }
        }
        p.note {
            "Model: I₀ φ″ + c φ′ + k φ = −T₀ − m a L cos φ; φ ≥ 0 on a rigid stop, spring and damper "
            "in place of the stop on a soft one."
        }
        @if let Some(catch) = &design.catch {
            p.note {
                "Inertia catch: I₂ ψ″ + c₂ ψ′ + k₂ ψ = −T₂ − S₂ a cos ψ, 0 ≤ ψ ≤ ψₘ. It stops the lever at φb while "
                "ψ ≥ ψb. " @if catch.reversible { "It falls back." } @else { "Once at its end stop it stays there." }
            }
        }
    }
}

/// Returns all that a repetition of the verdict needs.
pub(super) fn provenance(document: &Document) -> Markup {
    let request = &document.request;
    let settings = words::settings(request);
    let settings: Vec<_> = settings.lines().map(line).collect();
    let window = request.window_s;
    let window =
        window.map(|window| format!("{} to {}", instant(window.from_s), instant(window.until_s)));
    let state = match (request.phi0_rad, request.omega0_rad_s) {
        (None, None) => "at rest on the stop".to_string(),
        (Some(phi0), omega0) => format!(
            "φ = {}\u{00A0}rad, φ′ = {}\u{00A0}rad/s",
            exact(phi0),
            exact(omega0.unwrap_or(0.0))
        ),
        (None, Some(omega0)) => format!(
            "the angle of rest on the stop, φ′ = {}\u{00A0}rad/s",
            exact(omega0)
        ),
    };
    let ensemble = match request.members {
        0 => "none, nominal runs alone".to_string(),
        members => format!(
            "up to {} members, seed {}",
            count(u64::from(members)),
            request.seed
        ),
    };
    html! {
        pre { (settings.join("\n")) }
        table.facts {
            tbody {
                (fact("Stop model asked for", request.model.name()))
                (fact("Sign that opens, declared", words::stated(document.recording.opens_when_source.name())))
                (fact("Judged window", &or("the whole record", window)))
                (fact("Initial state", &state))
                (fact("Ensemble asked for", &ensemble))
                (fact("Standard gravity", &format!("{}\u{00A0}m/s², exact", exact(STANDARD_GRAVITY))))
                (code_fact("Verify", "latchgate verify verdict.json"))
                (fact("All digits", &format!("verdict.json beside this report, {}", document.schema)))
            }
        }
    }
}

/// Returns the limits of this report.
pub(super) fn limits(document: &Document) -> Markup {
    html! {
        section #limits {
            h2 { "What this report does not say" }
            div.statement {
                p {
                    "The model has one degree of freedom: a lever, its spring and its stop. It knows no "
                    "deformation of linkage, door or body, no friction that depends on load, no cable or rod "
                    "forces and no contact with an occupant."
                }
                p {
                    "This is a simulation. It does not replace a compliance test, such as those of FMVSS 206 "
                    "and UN Regulation No. 11."
                }
                p {
                    "The results hold for the recording " (line(&document.recording.file))
                    " and this design alone: " (line(&words::design(&document.design))) "."
                }
            }
        }
    }
}
