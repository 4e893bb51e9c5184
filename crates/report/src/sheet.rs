//! The page's style sheet: screen in light and dark, paper in light alone.

use crate::plot::style;

/// Returns the rules of all pages. `identity` stands at the foot of every printed page; it holds
/// nothing but letters, digits, `-`, `_` and `.`.
pub(super) fn style(identity: &str) -> String {
    rules(&foot(identity))
}

/// Returns the rules of all pages with those of the report, without the foot.
pub(super) fn plain() -> String {
    rules("") + REPORT
}

fn rules(foot: &str) -> String {
    let light = style::variables(false);
    let dark = style::variables(true);
    let plots = style::RULES;
    format!(
        ":root{{color-scheme:light dark;{light}}}\n\
         @media screen and (prefers-color-scheme:dark){{:root{{{dark}}}}}\n\
         {PAGE}{plots}{foot}{PRINT}"
    )
}

fn foot(identity: &str) -> String {
    format!(
        "@page{{size:A4;margin:11mm 15mm 13mm;\
         @bottom-left{{content:\"latchgate report {identity}\";font:8pt sans-serif;color:#56616c}}\
         @bottom-right{{content:\"page \" counter(page) \" of \" counter(pages);font:8pt sans-serif;color:#56616c}}}}\n"
    )
}

const PAGE: &str = include_str!("sheet/page.css");

const PRINT: &str = include_str!("sheet/print.css");

/// Rules that the static page adds: one sheet of paper.
pub(super) const STATIC: &str = concat!(
    include_str!("sheet/report.css"),
    include_str!("sheet/static.css")
);

/// Rules that reports and comparisons add.
pub(super) const REPORT: &str = include_str!("sheet/report.css");
