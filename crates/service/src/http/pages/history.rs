//! The margin of a recording over designs and versions; each point leads to its run.

use super::{gates, show};
use crate::http::verdicts::VerdictEntry;
use maud::{Markup, html};

/// Points that are drawn at most, the newest.
const POINTS: usize = 60;

/// Width and height of the drawing, and its margins left and below.
const SIZE: (f64, f64, f64, f64) = (900.0, 260.0, 60.0, 34.0);

/// Draws the margins of verdicts on one recording, by design and version.
pub(super) fn margins(verdicts: &[VerdictEntry]) -> Markup {
    let mut points: Vec<(&VerdictEntry, f64)> = verdicts
        .iter()
        .filter_map(|entry| Some((entry, entry.summary.margin()?)))
        .take(POINTS)
        .collect();
    // Versions in their order, and runs of one design as they came.
    points.sort_by_cached_key(|(entry, _)| {
        let full = entry.summary.full_design();
        let (name, rest) = full.split_once('@').unwrap_or((&full, ""));
        let version: String = rest.chars().take_while(char::is_ascii_digit).collect();
        (
            name.to_string(),
            version.parse().unwrap_or(0_u32),
            entry.created_ms,
        )
    });
    if points.len() < 2 {
        return html! {};
    }
    let (width, height, left, below) = SIZE;
    let x = |index: usize| {
        let part = (index as f64 + 0.5) / points.len() as f64;
        format!("{:.1}", left + (width - left - 10.0) * part)
    };
    // Far beyond the limit is as good as at the edge; the table has the number.
    let y = |margin: f64| 10.0 + (height - below - 10.0) * 0.5 * (1.0 - margin.clamp(-1.0, 1.0));
    html! {
        h2 { "Margin over designs" }
        p.muted { "How far the nominal peak and its error stay below the limit angle, in percent of the limit. Each point leads to its run." }
        div.wide tabindex="0" role="region" aria-label="Margin over designs" {
            svg.history viewBox=(format!("0 0 {width} {height}")) role="group" aria-label="Margin over designs" {
                @for level in [1.0, 0.5, 0.0, -0.5, -1.0] {
                    line.limit[level == 0.0] x1=(left) x2=(width - 10.0) y1=(y(level)) y2=(y(level)) {}
                    text x="4" y=(y(level) + 5.0) { @if level < -0.9 { "≤ " } (gates::margin(Some(level))) }
                }
                @for (index, (entry, margin)) in points.iter().enumerate() {
                    @let (px, py) = (x(index), y(*margin));
                    @let told = format!("{}: {}, margin {}, limit {}", entry.summary.full_design(), entry.summary.verdict, gates::margin(Some(*margin)), show::angle(Some(entry.summary.threshold_rad)));
                    a href=(format!("/verdicts/{}", entry.report_id)) aria-label=(told) {
                        title { (told) }
                        circle.(entry.summary.verdict) cx=(px) cy=(py) r="9" {}
                        text.sign x=(px) y=(py + 5.0) { (show::sign(&entry.summary.verdict)) }
                    }
                    text.index x=(px) y=(height - 12.0) { (index + 1) }
                }
            }
        }
        ol.designs { @for (entry, margin) in &points { li {
            a href=(format!("/verdicts/{}", entry.report_id)) { (entry.summary.full_design()) }
            ": " (gates::margin(Some(*margin))) " of the limit " (show::angle(Some(entry.summary.threshold_rad)))
        } } }
    }
}
