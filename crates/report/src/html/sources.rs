//! What the verdict rests on: recording, conditioning, design, provenance, limits.

use super::markup::Page;
use crate::words::{self, DIGITS, instant};
use latchgate_document::Document;
use latchgate_document::blocks::ConditioningBlock;
use latchgate_document::number::{ABSENT, count, exact, significant, trimmed};
use latchgate_kernel::model::parameters::{PARAMETERS, Slot};
use latchgate_kernel::units::STANDARD_GRAVITY;
use latchgate_verdict::conditioning::FilterStandard;

/// Writes what was judged: test, channel, design, and who checked it.
pub(super) fn judged(page: &mut Page, document: &Document) {
    let recording = &document.recording;
    page.section("judged", "What was judged");
    page.raw("<div class=\"sides\">\n");
    page.facts();
    for (name, value) in words::test_facts(document) {
        page.fact(name, &value);
    }
    page.fact("File", &recording.file);
    if let Some(channel) = &recording.channel {
        page.fact("Channel", channel);
    }
    page.end_table();
    page.facts();
    page.fact("Design", &words::design(&document.design));
    page.fact("Opening direction", &words::direction(document));
    if let Some(block) = &document.conditioning {
        page.fact("Signal", &words::conditioned(block));
    }
    if let Some(velocity) = recording.velocity_change_m_s {
        let velocity = format!("{}\u{00A0}m/s", trimmed(velocity, 3));
        page.fact("Velocity change", &velocity);
    }
    page.end_table();
    page.raw("</div>\n<div class=\"sign\">");
    for word in ["Checked by", "Date", "Signature"] {
        page.element("span", "", word);
    }
    page.raw("</div>\n");
    page.end_section();
}

/// Writes what was read.
pub(super) fn recording(page: &mut Page, document: &Document) {
    let recording = &document.recording;
    page.heading("Recording");
    page.facts();
    page.fact("File", &recording.file);
    page.code_fact("SHA-256", recording.sha256.as_deref().unwrap_or("not read"));
    page.fact("Format", recording.format.as_deref().unwrap_or(ABSENT));
    page.fact("Channel", recording.channel.as_deref().unwrap_or(ABSENT));
    page.fact(
        "Unit, and what states it",
        &match (&recording.unit, &recording.unit_source) {
            (Some(unit), Some(source)) => format!("{}, stated by: {source}", unit.name()),
            (Some(unit), None) => unit.name().to_string(),
            _ => ABSENT.to_string(),
        },
    );
    page.fact("Samples", &count(recording.samples as u64));
    page.fact(
        "Sample rate",
        &recording.sample_rate_hz.map_or_else(
            || ABSENT.into(),
            |rate| format!("{}\u{00A0}Hz", exact(rate)),
        ),
    );
    page.fact(
        "First and last sample",
        &match (recording.start_s, recording.end_s) {
            (Some(start), Some(end)) => format!("{} to {}", instant(start), instant(end)),
            _ => ABSENT.into(),
        },
    );
    page.fact(
        "Largest magnitude as recorded",
        &match (recording.peak_g, recording.peak_time_s) {
            (Some(peak), Some(at)) => {
                format!("{}\u{00A0}g at {}", significant(peak, DIGITS), instant(at))
            }
            (Some(peak), None) => format!("{}\u{00A0}g", significant(peak, DIGITS)),
            _ => ABSENT.into(),
        },
    );
    if let Some(velocity) = recording.velocity_change_m_s {
        let velocity = significant(velocity, DIGITS);
        page.fact(
            "Velocity change",
            &format!("{velocity}\u{00A0}m/s, the largest |∫a dt| over any 0.3\u{00A0}s, as recorded without bias"),
        );
    }
    if let Some(sha256) = &recording.content_sha256 {
        page.code_fact("SHA-256 of the channel's signal", sha256);
    }
    for part in &recording.parts {
        page.code_fact(&format!("SHA-256 of {}", part.file), &part.sha256);
    }
    match &recording.card_sha256 {
        Some(sha256) => page.code_fact("SHA-256 of its card", sha256),
        None => page.fact("Card", "none"),
    }
    page.end_table();
}

/// Writes how it was conditioned.
pub(super) fn conditioning(page: &mut Page, document: &Document) {
    page.heading("Conditioning");
    let Some(block) = &document.conditioning else {
        page.paragraph("Nothing was conditioned.");
        return;
    };
    page.facts();
    bias(page, block);
    page.fact(
        "Rate fed to the model",
        &block.resample_hz.map_or_else(
            || "as recorded".into(),
            |rate| format!("{}\u{00A0}Hz, band-limited", exact(rate)),
        ),
    );
    filter(page, block);
    if let (Some(peak), Some(at)) = (block.peak_g, block.peak_time_s) {
        page.fact(
            "Largest magnitude as used",
            &format!("{}\u{00A0}g at {}", significant(peak, DIGITS), instant(at)),
        );
    }
    page.fact(
        "Full scale, by the card",
        &block.range_g.map_or_else(
            || "not stated".into(),
            |range| format!("{}\u{00A0}g", exact(range)),
        ),
    );
    if block.synthetic {
        page.fact(
            "Made by a formula, by the card",
            "yes: clipping and dead sensors were not looked for",
        );
    }
    page.fact(
        "Order",
        "units, faults, bias, resampling, filter; the sign enters last, in the model",
    );
    page.end_table();
}

/// Writes the bias that was removed, with its error.
fn bias(page: &mut Page, block: &ConditioningBlock) {
    let acceleration = |value: f64| {
        format!(
            "{}\u{00A0}m/s² ({}\u{00A0}g)",
            significant(value, DIGITS),
            significant(value / STANDARD_GRAVITY, 4)
        )
    };
    match block.bias_window_s {
        Some((from, to)) => {
            page.fact("Bias removed", &acceleration(block.bias_m_s2));
            page.fact(
                "Its standard error",
                &acceleration(block.bias_standard_error_m_s2),
            );
            page.fact("Method of that error", &block.bias_standard_error_method);
            page.fact(
                "Bias window",
                &format!(
                    "{} to {}, {} samples",
                    instant(from),
                    instant(to),
                    count(block.bias_samples as u64)
                ),
            );
        }
        None => page.fact("Bias removed", "none"),
    }
}

/// Writes the filter, with its standard.
fn filter(page: &mut Page, block: &ConditioningBlock) {
    let Some(class) = block.filter else {
        page.fact("Filter", "none");
        return;
    };
    let class = class.class();
    page.fact(
        "Filter",
        &format!("CFC {class}, two passes of a two-pole Butterworth, no phase"),
    );
    page.fact(
        "Standard and its constant",
        match block.filter_standard {
            FilterStandard::Iso6487 => "ISO 6487: fd = 25/12 · CFC",
            FilterStandard::SaeJ211 => "SAE J211-1: fd = 2.0775 · CFC",
        },
    );
    page.fact(
        "Design frequency fd",
        &block.filter_design_frequency_hz.map_or_else(
            || ABSENT.into(),
            |design| format!("{}\u{00A0}Hz", trimmed(design, 7)),
        ),
    );
    page.fact(
        "End treatment",
        block.filter_end_treatment.as_deref().unwrap_or(ABSENT),
    );
}

/// Writes the design with its tolerances.
pub(super) fn design(page: &mut Page, document: &Document) {
    let design = &document.design;
    page.raw("<p>");
    page.element("strong", "", &words::design(design));
    page.raw("</p>\n");
    page.table(
        "design",
        &[
            "Quantity",
            "Symbol",
            "#Value",
            "Unit",
            "#Tolerance (one standard deviation)",
        ],
    );
    for parameter in PARAMETERS {
        let value = match parameter.slot {
            // What is stated of the input is its uncertainty.
            Slot::InputScale | Slot::InputBias => ABSENT.to_string(),
            Slot::Lever(_) | Slot::Stop(_) | Slot::Threshold => exact(design.value(parameter)),
        };
        let of = |key: &String| {
            key == parameter.name || key.strip_prefix("tolerance.") == Some(parameter.key())
        };
        let modified = design.modified.iter().any(of);
        page.raw(if modified {
            "<tr class=\"nominal\">"
        } else {
            "<tr>"
        });
        page.element(
            "th",
            "",
            &format!(
                "{}{}",
                parameter.what,
                if modified { ", modified" } else { "" }
            ),
        );
        page.element("td", "", parameter.symbol);
        page.element("td", "number", &value);
        page.element("td", "", parameter.unit);
        let deviation = design.deviation(parameter);
        page.element(
            "td",
            "number",
            &deviation.map_or_else(|| ABSENT.into(), exact),
        );
        page.raw("</tr>\n");
    }
    page.end_table();
    page.note(
        "Model: I₀ φ″ + c φ′ + k φ = −T₀ − m a L cos φ; φ ≥ 0 on a rigid stop, spring and damper \
         in place of the stop on a soft one.",
    );
}

/// Writes what is needed to repeat the verdict and to see how it was decided.
pub(super) fn provenance(page: &mut Page, document: &Document) {
    let request = &document.request;
    page.raw("<p class=\"statement\">");
    page.text(&document.decision_rule);
    page.raw("</p>\n");
    page.raw("<pre>");
    for (index, line) in words::settings(request).lines().enumerate() {
        page.raw(if index > 0 { "\n" } else { "" });
        page.text(line);
    }
    page.raw("</pre>\n");
    page.facts();
    page.fact("Stop model asked for", request.model.name());
    page.fact(
        "Sign that opens, stated by",
        document.recording.opens_when_source.name(),
    );
    page.fact(
        "Judged window",
        &request.window_s.map_or_else(
            || "the whole record".into(),
            |(start, end)| format!("{} to {}", instant(start), instant(end)),
        ),
    );
    page.fact(
        "Initial state",
        &match (request.phi0_rad, request.omega0_rad_s) {
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
        },
    );
    page.fact(
        "Ensemble asked for",
        &match request.members {
            0 => "none, nominal runs alone".to_string(),
            members => format!(
                "up to {} members, seed {}",
                count(u64::from(members)),
                request.seed
            ),
        },
    );
    page.fact(
        "Standard gravity",
        &format!("{}\u{00A0}m/s², exact", exact(STANDARD_GRAVITY)),
    );
    page.fact("latchgate", &format!("version {}", document.run.version));
    page.code_fact("Report", &document.report_id);
    page.code_fact("Verify", "latchgate verify verdict.json");
    page.fact(
        "All digits",
        &format!("verdict.json beside this report, {}", document.schema),
    );
    page.end_table();
}

/// Writes what this report does not say.
pub(super) fn limits(page: &mut Page, document: &Document) {
    page.section("limits", "What this report does not say");
    page.raw("<div class=\"statement\">\n");
    page.paragraph(
        "The model has one degree of freedom: a lever, its spring and its stop. It knows no \
         deformation of linkage, door or body, no friction that depends on load, no cable or rod \
         forces and no contact with an occupant.",
    );
    page.paragraph(
        "This is a simulation. It does not replace a compliance test, such as those of FMVSS 206 \
         and UN Regulation No. 11.",
    );
    page.paragraph(&format!(
        "The results relate only to the recording {} and the design {} named above.",
        document.recording.file,
        words::design(&document.design)
    ));
    page.raw("</div>\n");
    page.end_section();
}

/// Writes the end.
pub(super) fn end(page: &mut Page, name: &str) {
    page.raw("<p class=\"end\">End of report ");
    page.text(name);
    page.raw("</p>\n");
}
