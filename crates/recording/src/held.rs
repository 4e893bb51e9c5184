//! Comparison of a file's statements with its samples: one rule for every format.
//!
//! A statement that the samples contradict blocks: nothing shows which of the two is right. One that
//! cannot be read warns, since its contradiction would stay hidden.

use super::{Finding, Severity, text};

/// A statement of a header: its key, as the format has it, and the text.
#[derive(Debug, Clone, Copy)]
pub(super) struct Statement<'a> {
    pub(super) key: &'a str,
    pub(super) text: &'a str,
}

impl Statement<'_> {
    /// Reads a number that `fits`; a finding names one that cannot be read or does not fit.
    pub(super) fn number(
        self,
        fits: impl Fn(f64) -> bool,
        findings: &mut Vec<Finding>,
    ) -> Option<f64> {
        let number = text::header_number(self.text.trim()).filter(|number| fits(*number));
        if number.is_none() {
            findings.push(self.unread());
        }
        number
    }

    /// Returns the finding on a statement that cannot be read.
    pub(super) fn unread(self) -> Finding {
        let text = format!(
            "{} in the header is `{}`, which latchgate cannot read. It was not compared with the \
             samples. Check it",
            self.key,
            text::shown(self.text)
        );
        Finding::warning("statement-unread", text)
    }

    /// Returns the finding on a statement that another one of the file contradicts.
    pub(super) fn contradicts(self, other_statement: &str) -> Finding {
        let text = format!(
            "{} in the header is `{}`, but {other_statement}. What the channel measured is unknown. Find out \
             which is right",
            self.key,
            text::shown(self.text)
        );
        Finding::blocking("header-contradicted", text)
    }

    /// Compares a number of samples with those of the file, which end at `end_s` [s]; `stamped` is true if
    /// each has a stamp, so that none can be missing between others.
    pub(super) fn count(
        self,
        found: usize,
        stamped: bool,
        end_s: f64,
        findings: &mut Vec<Finding>,
    ) {
        let is_count = |number: f64| number >= 0.0 && number.fract().total_cmp(&0.0).is_eq();
        let Some(stated) = self.number(is_count, findings) else {
            // Nothing else would show a sample that is missing.
            if let (Some(unread), false) = (findings.last_mut(), stamped) {
                unread.severity = Severity::Blocking;
            }
            return;
        };
        let source = format!("the header ({})", self.key);
        findings.extend(count(&source, stated, found, stamped, end_s));
    }

    /// Compares an extreme, printed as the file has it, with that of the samples, `found`; `slack` is the
    /// allowed difference besides the last digit.
    pub(super) fn extreme(self, found: f64, slack: f64, findings: &mut Vec<Finding>) {
        let Some(stated) = self.number(f64::is_finite, findings) else {
            return;
        };
        if (found - stated).abs() > slack + text::last_digit(self.text) {
            let text = format!(
                "{} in the header is {stated}, but the samples have {found}. Unit or scale is \
                 wrong, or samples are cut off or not of this header. Check unit and files",
                self.key
            );
            findings.push(Finding::blocking("peak-contradicted", text));
        }
    }
}

/// Compares the number of samples that `source` states with those of the file, as
/// [`Statement::count`] does.
pub(super) fn count(
    source: &str,
    stated: f64,
    found: usize,
    stamped: bool,
    end_s: f64,
) -> Option<Finding> {
    let held_samples = found as f64;
    let text = format!("{source} states {stated} samples, but the file holds {found}");
    if held_samples < stated {
        let text = format!("{text}. The others are missing. Copy or export the file again");
        let missing = Finding::blocking("samples-missing", text);
        // Without stamps they may be missing anywhere.
        return Some(if stamped { missing.at(end_s) } else { missing });
    }
    let unknown =
        format!("{text}. No stamp tells which of them belong to the record. Export again");
    (held_samples > stated).then(|| match stamped {
        true => Finding::warning("count-contradicted", text),
        false => Finding::blocking("count-contradicted", unknown),
    })
}

/// Returns the finding that a text ends in the middle of its last line: without the line's end, and
/// with fewer decimals, or cells, than every line before it.
pub(super) fn cut_line(content: &str) -> Option<Finding> {
    let lines: Vec<&str> = content.lines().rev().take(LOOKED_AT).collect();
    let (last, before) = lines.split_first()?;
    if content.ends_with(['\n', '\r']) || before.len() + 1 < LOOKED_AT {
        return None;
    }
    let shape = |line: &&str| {
        let line = line.trim_end();
        let cells = line.split(['\t', ';', ' ']).count();
        let number = line.rsplit(['\t', ';', ' ']).next().unwrap_or_default();
        let decimals = number
            .rsplit_once(['.', ','])
            .map_or(0, |(_, rest)| rest.len());
        (cells, decimals)
    };
    let (cells, decimals) = shape(last);
    let least = |part: fn((usize, usize)) -> usize| before.iter().map(shape).map(part).min();
    let cut = Some(cells) < least(|(cells, _)| cells) || Some(decimals) < least(|(_, d)| d);
    cut.then(|| {
        let shown = text::shown(last);
        let text = format!(
            "the last line, `{shown}`, is cut. Later samples are missing. Copy or export the file \
             again"
        );
        Finding::blocking("samples-missing", text)
    })
}

/// Lines at the end of a text that are compared with its last one.
const LOOKED_AT: usize = 64;
