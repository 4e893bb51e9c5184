//! The summary in Markdown, for comments and step summaries, and annotations.

use super::pairs::PairStanding;
use super::summary::GateSummary;
use super::text;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Largest number of characters: GitHub refuses a comment beyond 65 536.
const CHARACTERS_MAX: usize = 60_000;

/// Largest number of pairs in a list.
const LISTED: usize = 10;

/// Recordings up to which the matrix is shown.
const MATRIX_RECORDINGS_MAX: usize = 40;

/// Designs up to which the matrix is shown.
const MATRIX_DESIGNS_MAX: usize = 20;

/// Largest number of characters of a name.
const NAME_MAX: usize = 120;

/// Largest number of characters of a sentence.
const TEXT_MAX: usize = 800;

/// Largest number of annotations: GitHub Actions shows ten a step.
const ANNOTATIONS_MAX: usize = 10;

/// Returns the summary: the answer, the matrix, the worst ten pairs, exceptions, changes, counts.
pub fn render(summary: &GateSummary) -> String {
    let mut out = String::new();
    let mark = if summary.exit_code == 0 { "✅" } else { "❌" };
    let _ = writeln!(out, "## {mark} latchgate {}\n", code(&summary.gate));
    let _ = writeln!(out, "{}\n", text::headline(summary));
    for problem in summary.problems.iter().take(LISTED) {
        let _ = writeln!(out, "- {}", prose(&problem.text));
    }
    if summary.problems.len() > LISTED {
        let _ = writeln!(
            out,
            "- {}",
            text::counted(summary.problems.len() - LISTED, "further problem")
        );
    }
    for standing in &summary.statics {
        let mark = if standing.holds { "✅" } else { "❌" };
        let _ = writeln!(out, "- {mark} static: {}", prose(&standing.text()));
    }
    matrix(&mut out, summary);
    let worst = summary.worst();
    table(
        &mut out,
        summary,
        "Not as required, the worst first",
        &worst,
    );
    exceptions(&mut out, summary);
    let title = "Not as required, but no worse than the baseline";
    table(
        &mut out,
        summary,
        title,
        &summary.with_standing(PairStanding::NoWorse),
    );
    if let Some(baseline) = &summary.baseline {
        let _ = writeln!(out, "\n### Since the baseline\n");
        for (what, pairs) in [
            ("newly failing", &baseline.newly_failing),
            ("fixed", &baseline.fixed),
            ("added", &baseline.added),
            ("gone", &baseline.removed),
        ] {
            let names = pairs
                .iter()
                .map(|(recording, design)| format!("{} with {}", code(recording), code(design)));
            let listed: Vec<String> = names.take(LISTED).collect();
            let more = if pairs.len() > LISTED { " …" } else { "" };
            let _ = writeln!(
                out,
                "- {} {what}{} {}{more}",
                pairs.len(),
                if listed.is_empty() { "" } else { ":" },
                listed.join(", ")
            );
        }
        let _ = writeln!(
            out,
            "- {} moved by more than the uncertainty",
            text::counted(baseline.moved.len(), "margin")
        );
    }
    let counts = &summary.counts;
    let _ = writeln!(
        out,
        "\npass {}, fail {}, undecided {}, unusable {}; {}, {}; latchgate {}",
        counts.pass,
        counts.fail,
        counts.undecided,
        counts.unusable,
        text::counted(summary.recordings.len(), "recording"),
        text::counted(summary.designs.len(), "design"),
        summary.version
    );
    for design in text::repeated_designs(summary) {
        let _ = writeln!(out, "\nDesigns: {}", prose(&design));
    }
    cut(out)
}

/// Writes the answers of all pairs, a row per recording, where there are few.
fn matrix(out: &mut String, summary: &GateSummary) {
    let designs = summary.designs.len();
    if summary.recordings.len() > MATRIX_RECORDINGS_MAX
        || !(1..=MATRIX_DESIGNS_MAX).contains(&designs)
    {
        return;
    }
    let names = summary.designs.iter().map(|design| code(&design.name));
    let heads: Vec<String> = names.collect();
    let _ = writeln!(out, "\n| | {} |", heads.join(" | "));
    let _ = writeln!(out, "| --- |{}", " :-: |".repeat(designs));
    let rows = summary.pairs.chunks(designs);
    for (recording, pairs) in summary.recordings.iter().zip(rows) {
        let _ = write!(out, "| {} |", code(&recording.name));
        for pair in pairs {
            let glyph = text::glyph(pair.row.verdict);
            let _ = match pair.standing {
                PairStanding::NotAsRequired => write!(out, " **{glyph}** |"),
                _ => write!(out, " {glyph} |"),
            };
        }
        out.push('\n');
    }
    out.push_str("\n✓ pass, ✗ fail, ? undecided, ∅ unusable; bold: not as required\n");
}

fn table(out: &mut String, summary: &GateSummary, title: &str, numbers: &[usize]) {
    if numbers.is_empty() {
        return;
    }
    let _ = writeln!(
        out,
        "\n### {title}\n\n| answer | recording | design | |\n| --- | --- | --- | --- |"
    );
    let mut shown = 0;
    for group in text::grouped(&summary.pairs, numbers).iter().take(LISTED) {
        let designs = match group.numbers.len() {
            1 => code(&group.worst.design),
            _ => prose(&group.designs(summary)),
        };
        let _ = writeln!(
            out,
            "| {} | {} | {designs} | {} |",
            group.worst.row.verdict.name(),
            code(&group.worst.recording),
            prose(&group.description(summary))
        );
        shown += group.numbers.len();
    }
    if numbers.len() > shown {
        let further = text::counted(numbers.len() - shown, "further pair");
        let _ = writeln!(out, "\n{further} in summary.csv.");
    }
}

/// Lists every exception that lets pairs through, with the number of pairs and the first of them.
fn exceptions(out: &mut String, summary: &GateSummary) {
    let mut counts: BTreeMap<(String, String), (usize, String)> = BTreeMap::new();
    for number in summary.with_standing(PairStanding::Allowed) {
        let pair = &summary.pairs[number];
        let first = || format!("{} with {}", code(&pair.recording), code(&pair.design));
        let exception = pair.exception.clone().unwrap_or_default();
        counts.entry(exception).or_insert_with(|| (0, first())).0 += 1;
    }
    if !counts.is_empty() {
        let _ = writeln!(
            out,
            "\n### Let through by an exception\n\n| until | reason | pairs | the first |\n| --- | --- | --- | --- |"
        );
    }
    for ((reason, until), (count, first)) in &counts {
        let _ = writeln!(out, "| {until} | {} | {count} | {first} |", prose(reason));
    }
}

/// Returns a name as code, in which nothing pings, links or ends a table's cell.
fn code(name: &str) -> String {
    let plain: String = name
        .chars()
        .take(NAME_MAX)
        .map(|c| match c {
            '`' => '\'',
            c if c.is_control() || is_direction(c) => '\u{fffd}',
            c => c,
        })
        .collect();
    format!("`{}`", plain.replace('|', "\\|"))
}

/// Returns a sentence in which nothing pings, links or is markup.
fn prose(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars().take(TEXT_MAX) {
        match c {
            // An invisible joiner keeps names of people and issues from being linked.
            '@' | '#' => {
                out.push(c);
                out.push('\u{2060}');
            }
            '\\' | '`' | '*' | '_' | '[' | ']' | '<' | '>' | '|' | '~' | '!' | '&' | '$' => {
                out.push('\\');
                out.push(c);
            }
            c if c.is_control() || is_direction(c) => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// True for a character that turns the direction of writing, with which a name can show as another.
fn is_direction(c: char) -> bool {
    matches!(c, '\u{200e}' | '\u{200f}' | '\u{061c}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Cuts at a line's end, and says so.
fn cut(text: String) -> String {
    if text.chars().count() <= CHARACTERS_MAX {
        return text;
    }
    let end = text
        .char_indices()
        .nth(CHARACTERS_MAX - 100)
        .map_or(text.len(), |(index, _)| index);
    let end = text[..end].rfind('\n').unwrap_or(end);
    format!("{}\n\nCut here; summary.json has the rest.\n", &text[..end])
}

/// Returns annotations as GitHub Actions reads them from a step's output, ten at most, in the gate file at
/// `path`; `line_of` returns the line of a recording's entry.
pub fn annotations(
    summary: &GateSummary,
    path: &str,
    line_of: impl Fn(&str) -> Option<u64>,
) -> String {
    let problems = summary.problems.iter();
    let mut lines: Vec<String> = problems
        .map(|problem| annotation(path, problem.line, &problem.code, &problem.text))
        .take(ANNOTATIONS_MAX)
        .collect();
    let worst = summary.worst();
    for &number in worst.iter().take(ANNOTATIONS_MAX - lines.len()) {
        let pair = &summary.pairs[number];
        let title = format!(
            "{}: {} with {}",
            pair.row.verdict.name(),
            pair.recording,
            pair.design
        );
        let line = line_of(&pair.recording);
        lines.push(annotation(path, line, &title, &text::describe(pair)));
    }
    let total = summary.problems.len() + worst.len();
    if total > ANNOTATIONS_MAX {
        lines.truncate(ANNOTATIONS_MAX - 1);
        let more = format!(
            "{} of what is not as required; see summary.json",
            text::counted(total - lines.len(), "further line")
        );
        lines.push(annotation(path, None, "latchgate", &more));
    }
    lines.concat()
}

fn annotation(path: &str, line: Option<u64>, title: &str, message: &str) -> String {
    let escape = |text: &str, more: &[(&str, &str)]| {
        let mut text: String = text
            .chars()
            .take(TEXT_MAX)
            .collect::<String>()
            .replace('%', "%25");
        text = text.replace('\r', "%0D").replace('\n', "%0A");
        for (from, to) in more {
            text = text.replace(from, to);
        }
        text.chars()
            .map(|c| if c.is_control() { ' ' } else { c })
            .collect::<String>()
    };
    let property = |text: &str| escape(text, &[(":", "%3A"), (",", "%2C")]);
    let line = line.map_or_else(String::new, |line| format!(",line={line}"));
    format!(
        "::error file={}{line},title={}::{}\n",
        property(path),
        property(title),
        escape(message, &[])
    )
}
