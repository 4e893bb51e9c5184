//! Colours and rules of the plots and of the page around them.

use std::fmt::Write as _;

/// One colour in light and dark.
struct ThemeColour {
    name: &'static str,
    light: &'static str,
    dark: &'static str,
}

const fn colour(name: &'static str, light: &'static str, dark: &'static str) -> ThemeColour {
    ThemeColour { name, light, dark }
}

/// Every colour. Text keeps a contrast of at least 4.5 to 1 against the paper in both themes.
const COLOURS: [ThemeColour; 19] = [
    colour("paper", "#ffffff", "#14181d"),
    colour("page", "#f3f5f7", "#0c0f12"),
    colour("ink", "#171c22", "#e6eaee"),
    colour("muted", "#56616c", "#9aa6b2"),
    colour("axis", "#8b96a1", "#5f6b77"),
    colour("grid", "#e4e8ec", "#262d35"),
    colour("rule", "#d3d9df", "#323b45"),
    colour("band", "#dfe9f5", "#1d2c3d"),
    colour("raw", "#8d98a3", "#788694"),
    colour("first", "#0a58a8", "#6db3f5"),
    colour("second", "#c2540a", "#f0975a"),
    colour("third", "#2b8a70", "#5cc4a4"),
    colour("fourth", "#8a4fb0", "#c495e6"),
    colour("pass", "#17753a", "#5fcf8a"),
    colour("fail", "#b4231c", "#ff8a80"),
    colour("undecided", "#8a5a00", "#eab54a"),
    colour("unusable", "#5b4a94", "#b7a5f2"),
    colour("code", "#eef1f4", "#1d232a"),
    colour("shade", "#f8fafb", "#191e24"),
];

/// Rules of the plots, in terms of the colours' variables.
pub const RULES: &str = include_str!("style.css");

/// Returns the colours of one theme as declarations of CSS variables.
pub fn variables(dark: bool) -> String {
    let mut out = String::with_capacity(512);
    for colour in &COLOURS {
        let value = if dark { colour.dark } else { colour.light };
        // Writing into a String cannot fail.
        let _ = write!(out, "--{}:{value};", colour.name);
    }
    out
}

/// Returns the rules of a plot that stands alone: plain colours, since not every viewer of SVG
/// knows variables, and those of the dark theme for viewers that know of themes.
pub(super) fn stand_alone() -> String {
    stand_alone_with("")
}

/// As [`stand_alone`] with further rules.
pub(super) fn stand_alone_with(rules: &str) -> String {
    let rules = format!("{RULES}{rules}");
    let mut dark = String::with_capacity(rules.len());
    for line in resolved(&rules, true)
        .lines()
        .filter(|line| line.contains('#'))
    {
        dark.push_str(line);
        dark.push('\n');
    }
    format!(
        "{}@media screen and (prefers-color-scheme:dark){{\n{dark}}}\n",
        resolved(&rules, false)
    )
}

fn resolved(rules: &str, dark: bool) -> String {
    let mut rules = rules.to_string();
    for colour in &COLOURS {
        let value = if dark { colour.dark } else { colour.light };
        rules = rules.replace(&format!("var(--{})", colour.name), value);
    }
    rules
}
