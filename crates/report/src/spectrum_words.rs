//! What terminal, page and chart of latch response spectra say in the same words.

use crate::escape;
use latchgate_document::SpectrumDocument;
use latchgate_document::number::significant;
use latchgate_document::spectrum_document::{CurveBlock, DesignPoint};
use latchgate_kernel::units::STANDARD_GRAVITY;
use latchgate_recording::Severity;
use latchgate_verdict::response_spectrum::plane::Place;

/// Strokes of the table on the page [mm].
pub(crate) const ON_PAGE_MM: &[f64] = &[1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0];

/// Returns the answer in a sentence: at which strokes which recording asks most.
pub(crate) fn headline(document: &SpectrumDocument) -> String {
    let at = |mm: f64| {
        let place = place_of(document, mm)?;
        let value = document.envelope_m_s2[place]?;
        let by = document.envelope_by[place]?;
        let is_floor = document.recordings[by].floor_m_s2 == Some(value);
        (!is_floor).then(|| format!("{} at {mm} mm", g(value)))
    };
    let asked: Vec<String> = [1.0, 10.0, 100.0].into_iter().filter_map(at).collect();
    let what = match document.recordings.len() {
        1 => "This recording demands",
        _ => "Together they demand",
    };
    match asked.as_slice() {
        [] => "Of the lift-offs that were followed none opens: no latch above the lowest is asked for more.".into(),
        _ => format!("{what} a lift-off of more than {} of stroke.", asked.join(", ")),
    }
}

/// Returns the place of a stroke [mm] in the document's list.
fn place_of(document: &SpectrumDocument, mm: f64) -> Option<usize> {
    let near = |stroke: &f64| (stroke * 1e3 - mm).abs() < 1e-6;
    document.stroke_m.iter().position(near)
}

pub(crate) fn g(value_m_s2: f64) -> String {
    format!("{}\u{00A0}g", significant(value_m_s2 / STANDARD_GRAVITY, 3))
}

/// Returns the table of curves: one a row, its zone and spectrum at some strokes [mm], in g.
pub(crate) fn rows(document: &SpectrumDocument, strokes_mm: &[f64]) -> Vec<Vec<String>> {
    let strokes = strokes_mm.iter().map(|mm| format!("#{mm} mm"));
    let head = ["curve", "sensor", "#peak"].map(String::from);
    let mut rows = vec![head.into_iter().chain(strokes).collect::<Vec<_>>()];
    let value = |value: Option<f64>| {
        value.map_or_else(
            || "–".into(),
            |value| significant(value / STANDARD_GRAVITY, 3),
        )
    };
    let names = short_names(document);
    for (index, curve) in document.recordings.iter().enumerate() {
        let cells = strokes_mm.iter().map(|mm| {
            let place = place_of(document, *mm)?;
            let spectrum = document.spectrum_m_s2[index][place];
            let zone = document.zone_from_m_s2[index][place];
            spectrum.map(|_| match zone {
                Some(_) => format!("{}…{}", value(zone), value(spectrum)),
                // Not above the lowest window that was followed.
                None if spectrum == curve.floor_m_s2 => format!("≤{}", value(spectrum)),
                None => format!("…{}", value(spectrum)),
            })
        });
        let cells = cells.map(|cell| cell.unwrap_or_else(|| "–".into()));
        let first = [
            names[index].clone(),
            sensor(curve),
            value(Some(curve.strongest_m_s2)),
        ];
        rows.push(first.into_iter().chain(cells).collect());
    }
    if document.recordings.len() > 1 {
        let cells = strokes_mm.iter().map(|mm| {
            let place = place_of(document, *mm);
            value(place.and_then(|place| document.envelope_m_s2[place]))
        });
        let first = ["envelope".to_string(), String::new(), String::new()];
        rows.push(first.into_iter().chain(cells).collect());
    }
    rows
}

/// Letters of a curve's name in a table or legend.
const NAME_LETTERS: usize = 26;

/// Returns the names of the curves without the words that all begin with, each with its last letters where it is long.
pub(crate) fn short_names(document: &SpectrumDocument) -> Vec<String> {
    let names: Vec<String> = document
        .recordings
        .iter()
        .map(|curve| escape::terminal(&curve.name).into_owned())
        .collect();
    let recorded: Vec<&String> = names
        .iter()
        .zip(&document.recordings)
        .filter(|(_, curve)| !is_pulse(curve))
        .map(|(name, _)| name)
        .collect();
    let first = recorded.first().map_or("", |name| name.as_str());
    let alike = |length: usize| {
        recorded
            .iter()
            .all(|name| name.get(..length) == first.get(..length))
    };
    // Behind a sign between words.
    let shared = first
        .char_indices()
        .filter(|(_, letter)| !letter.is_alphanumeric())
        .map(|(index, letter)| index + letter.len_utf8())
        .take_while(|length| alike(*length));
    let shared = shared.last().filter(|_| recorded.len() > 1).unwrap_or(0);
    let short = |name: &String| {
        let begins_alike = name.get(..shared) == first.get(..shared);
        let name = name
            .get(shared..)
            .filter(|rest| begins_alike && rest.chars().count() > 3)
            .unwrap_or(name);
        match name.chars().count() {
            0..=NAME_LETTERS => name.to_string(),
            count => {
                let end: String = name.chars().skip(count - NAME_LETTERS + 1).collect();
                format!("…{end}")
            }
        }
    };
    names.iter().map(short).collect()
}

/// Tells whether a curve is that of a pulse by formula.
pub(crate) fn is_pulse(curve: &CurveBlock) -> bool {
    curve.recording.format.as_deref() == Some("pulse")
}

/// Returns where a curve's sensor stands, and along which axis.
pub(crate) fn sensor(curve: &CurveBlock) -> String {
    let axis = curve
        .axis
        .map_or_else(|| "axis ?".to_string(), |axis| format!("axis {axis}"));
    let place = match (curve.recording.place, &curve.recording.format) {
        (Some(place), _) => place.name().to_string(),
        (None, Some(format)) if format == "pulse" => return "formula".into(),
        (None, _) => "place ?".into(),
    };
    format!("{place}, {axis}")
}

/// Returns which curves make the envelope, with the strokes at which each does.
pub(crate) fn makers(document: &SpectrumDocument) -> Vec<String> {
    let mut makers = Vec::new();
    let names = short_names(document);
    for (index, curve) in document.recordings.iter().enumerate() {
        let own = document.envelope_by.iter().zip(&document.stroke_m);
        let own: Vec<f64> = own
            .filter(|(by, _)| **by == Some(index))
            .map(|(_, stroke)| stroke * 1e3)
            .collect();
        let (Some(first), Some(last)) = (own.first(), own.last()) else {
            continue;
        };
        let strokes = match own.len() {
            1 => format!("{} mm", significant(*first, 3)),
            count => format!(
                "{count} of {} strokes, {} to {} mm",
                document.stroke_m.len(),
                significant(*first, 3),
                significant(*last, 3)
            ),
        };
        makers.push(format!("{} ({}): {strokes}", names[index], sensor(curve)));
    }
    makers
}

/// Says where a design lies.
pub(crate) fn design(document: &SpectrumDocument, design: &DesignPoint) -> String {
    let place = match design.place {
        Some(Place::Above) if design.awaits.is_empty() => "above every curve: stays",
        Some(Place::Above) => "above every curve",
        Some(Place::Zone) => "in the zone, where small things decide",
        Some(Place::Below) => "below the zone: opens",
        None => "without a place",
    };
    let names = short_names(document);
    let by = design.place_by.and_then(|index| names.get(index));
    let by = by.filter(|_| names.len() > 1 && design.place != Some(Place::Above));
    let by = by.map_or_else(String::new, |name| format!(" ({name})"));
    let reason = design.reason.as_ref().map(|reason| format!(": {reason}"));
    let awaits = match (design.place, &*design.awaits) {
        (Some(Place::Above), [_, ..]) => {
            let what = design.awaits.join(", ");
            format!("; a pass needs a person's word on {what}")
        }
        _ => String::new(),
    };
    format!(
        "{}: stroke {} mm, lift-off {}; {place}{by}{}{}{awaits}",
        design.name,
        significant(design.stroke_m * 1e3, 3),
        g(design.liftoff_m_s2),
        reason.unwrap_or_default(),
        reserves(design)
    )
}

/// Says what reserve a design has.
fn reserves(design: &DesignPoint) -> String {
    let load = match (design.reserve_load, &design.reserve_load_reason) {
        (Some(times), _) => format!(
            "; reserve in load {} (the first multiple that does not pass)",
            significant(times, 3)
        ),
        (None, Some(reason)) => format!("; {reason}"),
        (None, None) => String::new(),
    };
    let preload = design.reserve_preload.map(|part| {
        let per_cent = significant(part.abs() * 100.0, 2);
        match part >= 0.0 {
            true => format!("; reserve in preload {per_cent} %"),
            false => format!("; needs {per_cent} % more preload"),
        }
    });
    load + &preload.unwrap_or_default()
}

/// Returns what a reader must know of single curves: faults that end one, one far from the others, findings.
pub(crate) fn remarks(document: &SpectrumDocument) -> Vec<(Severity, String)> {
    let mut remarks = Vec::new();
    for left in &document.left_out {
        remarks.push((Severity::Blocking, format!("left out: {}", left.reason)));
    }
    for curve in &document.recordings {
        let name = &curve.name;
        if let Some(until_s) = curve.judged_until_s {
            let text = format!(
                "{name}: ends at {} ms, before a fault: the curve may lie too low",
                significant(until_s * 1e3, 4)
            );
            remarks.push((Severity::Warning, text));
        }
        if let Some(times) = curve.times_the_others {
            let text = format!(
                "{name}: {} times the median of the others of its axis and direction. Look at its unit and place",
                significant(times, 2)
            );
            remarks.push((Severity::Warning, text));
        }
    }
    let names = short_names(document);
    let mut codes: Vec<&str> = Vec::new();
    for finding in document.recordings.iter().flat_map(|curve| &curve.findings) {
        let counts = finding.needs_word || finding.severity == Severity::Blocking;
        if counts && !codes.contains(&&*finding.code) {
            codes.push(&finding.code);
        }
    }
    for code in codes {
        let has = |curve: &CurveBlock| curve.findings.iter().any(|finding| finding.code == code);
        let with = document.recordings.iter().zip(&names);
        let with: Vec<&str> = with
            .filter(|(curve, _)| has(curve))
            .map(|(_, name)| name.as_str())
            .collect();
        let text = format!("{code}, as inspect tells: {}", with.join(", "));
        remarks.push((Severity::Warning, text));
    }
    for axis in ['X', 'Z'] {
        let along = document.recordings.iter().zip(&names);
        let along: Vec<&str> = along
            .filter(|(curve, _)| curve.axis == Some(axis))
            .map(|(_, name)| name.as_str())
            .collect();
        if !along.is_empty() {
            let text = format!(
                "measured along axis {axis}, not across the vehicle: {}",
                along.join(", ")
            );
            remarks.push((Severity::Warning, text));
        }
    }
    remarks
}

/// Returns what the levers share, in two lines.
pub(crate) fn subtitle(document: &SpectrumDocument) -> [String; 2] {
    let settings = &document.settings;
    let (from, to) = settings.restitution;
    let restitution = match settings.restitution_deviation {
        Some(deviation) => format!("{} ± {}", significant(from, 3), significant(deviation, 2)),
        None => format!(
            "{} to {}, drawn evenly",
            significant(from, 3),
            significant(to, 3)
        ),
    };
    [
        format!(
            "restitution {restitution}; spring k0/I0 {} 1/s², damping c0/I0 {} 1/s",
            significant(settings.spring_per_inertia_1_s2, 3),
            significant(settings.damping_per_inertia_1_s, 3),
        ),
        format!(
            "both stops, the higher; {} levers a window",
            settings.levers
        ),
    ]
}
