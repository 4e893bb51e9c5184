//! The verdicts on a recording side by side: how near each lever comes to its limit angle. Each point leads to
//! its run.

use super::show;
use crate::http::verdicts::VerdictEntry;
use latchgate::document::number::trimmed;
use latchgate::report::escape::terminal as line;
use latchgate::report::plot::axis::{Axis, Scale};
use maud::{Markup, html};
use std::f64::consts::FRAC_PI_2;

/// Points that are drawn at most, the newest.
const POINTS: usize = 60;

/// Width of the drawing [units].
const WIDTH: f64 = 900.0;

/// Height of the drawing [units].
const HEIGHT: f64 = 260.0;

/// Margin left of the axis [units].
const MARGIN_LEFT: f64 = 60.0;

/// Margin below the axis [units].
const MARGIN_BELOW: f64 = 34.0;

/// Shares of the limit angle that the drawing spans, and those that have a line.
const SPAN: (f64, f64) = (0.05, 20.0);
const LEVELS: [f64; 5] = [0.1, 0.3, 1.0, 3.0, 10.0];

/// A verdict with its largest angle and that angle's error, as a share of the limit angle.
struct Point<'a> {
    entry: &'a VerdictEntry,
    share: f64,
}

impl Point<'_> {
    fn of(entry: &VerdictEntry) -> Option<Point<'_>> {
        let is_usable = entry.summary.verdict != "unusable";
        let margin = entry.summary.margin().filter(|_| is_usable)?;
        Some(Point {
            entry,
            share: 1.0 - margin,
        })
    }

    fn words(&self) -> String {
        let summary = &self.entry.summary;
        let channel = summary.channel.as_deref().unwrap_or("–");
        let direction = summary.opens_when.as_deref();
        let direction = direction.unwrap_or("direction not declared");
        let text = format!("{channel}, {direction}, {}", summary.full_design());
        line(&text).into_owned()
    }

    fn share_words(&self) -> String {
        if self.share * self.entry.summary.threshold_rad > FRAC_PI_2 {
            "beyond 90°".into()
        } else {
            format!("{} × the limit angle", trimmed(self.share, 2))
        }
    }
}

/// Draws how near the levers come to their limit angles, by design and version.
pub(super) fn nearness(verdicts: &[VerdictEntry]) -> Markup {
    let mut points: Vec<Point<'_>> = verdicts.iter().filter_map(Point::of).take(POINTS).collect();
    // Versions in their order, and runs of one design as they came.
    points.sort_by_cached_key(|point| {
        let full = point.entry.summary.full_design();
        let (name, suffix) = full.split_once('@').unwrap_or((&full, ""));
        let version: String = suffix.chars().take_while(char::is_ascii_digit).collect();
        (
            name.to_string(),
            version.parse().unwrap_or(0_u32),
            point.entry.created_ms,
        )
    });
    if points.len() < 2 {
        return html! {};
    }
    let x = |index: usize| {
        let part = (index as f64 + 0.5) / points.len() as f64;
        format!("{:.1}", MARGIN_LEFT + (WIDTH - MARGIN_LEFT - 10.0) * part)
    };
    // Far beyond the limit is as good as at the edge; the list has the number.
    let (share_min, share_max) = SPAN;
    let axis = Axis::new(
        Scale::Logarithmic(share_min, share_max),
        HEIGHT - MARGIN_BELOW,
        10.0,
    );
    let y = |share: f64| format!("{:.1}", axis.place(share.clamp(share_min, share_max)));
    html! {
        h2 { "How near the limit angle" }
        p.muted { "The nominal lever's largest angle with its error, in limit angles. Below the dashed line it stays shut. Each point leads to its run." }
        div.wide tabindex="0" role="region" aria-label="How near the limit angle" {
            svg.history viewBox=(format!("0 0 {WIDTH} {HEIGHT}")) role="group" aria-label="How near the limit angle" {
                @for level in LEVELS {
                    line.limit[(level - 1.0).abs() < 1e-9] x1=(MARGIN_LEFT) x2=(WIDTH - 10.0) y1=(y(level)) y2=(y(level)) {}
                    text x="4" y=(y(level)) dy="5" { (level) " ×" }
                }
                @for (index, point) in points.iter().enumerate() {
                    @let (px, py) = (x(index), y(point.share));
                    @let summary = &point.entry.summary;
                    @let words = format!("{}: {}, {}", point.words(), summary.verdict, point.share_words());
                    a href=(format!("/verdicts/{}", point.entry.report_id)) aria-label=(words) {
                        title { (words) }
                        circle.(summary.verdict) cx=(px) cy=(py) r="9" {}
                        text.sign x=(px) y=(py) dy="5" { (show::sign(&summary.verdict)) }
                    }
                    text.index x=(px) y=(HEIGHT - 12.0) { (index + 1) }
                }
            }
        }
        ol.designs { @for point in &points { li {
            a href=(format!("/verdicts/{}", point.entry.report_id)) { (point.words()) }
            ": " (point.share_words())
        } } }
    }
}
