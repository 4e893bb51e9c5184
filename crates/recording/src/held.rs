//! What a file states of its own samples, held against them: one rule for every format.
//!
//! A statement that the samples contradict blocks, for nobody knows which of the two is right. One
//! that is there and cannot be read is told, since what it would have shown stays unseen.

use super::{Finding, Severity, text};

/// Something that a header states: its key, as the format has it, and the text.
#[derive(Debug, Clone, Copy)]
pub(super) struct Statement<'a> {
    pub(super) key: &'a str,
    pub(super) text: &'a str,
}

impl Statement<'_> {
    /// Reads a number that `fits`; says so of one that cannot be read or does not.
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

    /// Says that the statement is there and says nothing that is understood here.
    pub(super) fn unread(self) -> Finding {
        let said = format!(
            "{} in the header is `{}`, which latchgate cannot read. It was not compared with the \
             samples. Check it",
            self.key,
            text::shown(self.text)
        );
        Finding::warning("statement-unread", said)
    }

    /// Says that another statement of the file contradicts this one.
    pub(super) fn contradicts(self, other: &str) -> Finding {
        let said = format!(
            "{} in the header is `{}`, but {other}. What the channel measured is unknown. Find out \
             which is right",
            self.key,
            text::shown(self.text)
        );
        Finding::blocking("header-contradicted", said)
    }

    /// Holds a number of samples against those that the file holds, which end at `end_s` [s];
    /// `stamped` if each has a stamp of its own, so that none can be missing between others.
    pub(super) fn count(
        self,
        found: usize,
        stamped: bool,
        end_s: f64,
        findings: &mut Vec<Finding>,
    ) {
        let whole = |number: f64| number >= 0.0 && number.fract().total_cmp(&0.0).is_eq();
        let Some(stated) = self.number(whole, findings) else {
            // Nothing else would show a sample that is missing.
            if let (Some(unread), false) = (findings.last_mut(), stamped) {
                unread.severity = Severity::Blocking;
            }
            return;
        };
        let by = format!("the header ({})", self.key);
        findings.extend(count(&by, stated, found, stamped, end_s));
    }

    /// Holds an extreme of the samples, printed as the file has it, against the one `found`;
    /// `slack` is what the statement may be off beside its last digit.
    pub(super) fn extreme(self, found: f64, slack: f64, findings: &mut Vec<Finding>) {
        let Some(stated) = self.number(f64::is_finite, findings) else {
            return;
        };
        if (found - stated).abs() > slack + text::last_digit(self.text) {
            let said = format!(
                "{} in the header is {stated}, but the samples have {found}. Unit or scale is \
                 wrong, or samples are cut off or not of this header. Check unit and files",
                self.key
            );
            findings.push(Finding::blocking("peak-contradicted", said));
        }
    }
}

/// Holds the number of samples that `by` states against those that the file holds, as
/// [`Statement::count`] does.
pub(super) fn count(
    by: &str,
    stated: f64,
    found: usize,
    stamped: bool,
    end_s: f64,
) -> Option<Finding> {
    let holds = found as f64;
    let text = format!("{by} states {stated} samples, but the file holds {found}");
    if holds < stated {
        let said = format!("{text}. The others are missing. Copy or export the file again");
        let missing = Finding::blocking("samples-missing", said);
        // Without stamps they may be missing anywhere.
        return Some(if stamped { missing.at(end_s) } else { missing });
    }
    let unknown =
        format!("{text}. No stamp tells which of them belong to the record. Export again");
    (holds > stated).then(|| match stamped {
        true => Finding::warning("count-contradicted", text),
        false => Finding::blocking("count-contradicted", unknown),
    })
}

/// Holds a clock that `by` states, from `start_s` [s] on at a rate [Hz], against stamps [s], as printed to
/// `digit_s`.
pub(super) fn clock(
    by: &str,
    start_s: f64,
    hertz: f64,
    stamps_s: &[f64],
    digit_s: f64,
) -> Option<Finding> {
    let interval_s = 1.0 / hertz;
    let slack = 0.5 * digit_s * (1.0 + 1e-6) + 1e-12 + STAMP_SLACK * interval_s;
    let off = |(index, stamp): (usize, &f64)| (stamp - (start_s + index as f64 * interval_s)).abs();
    let off_s = stamps_s.iter().enumerate().map(off).fold(0.0, f64::max);
    (off_s > slack).then(|| {
        let text = format!(
            "the stamps differ by up to {off_s:.3e} s from the clock that {by} states (first \
             sample at {start_s} s, {hertz} Hz). One of the two is wrong. Find out which, and \
             export again"
        );
        Finding::blocking("time-contradicted", text)
    })
}

/// Share of the interval by which a stamp may be off the clock that is stated [-].
const STAMP_SLACK: f64 = 0.01;

/// Says that a text ends in the middle of its last line: without the line's end, and with fewer
/// decimals, or cells, than every line before it has.
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
    let least = |of: fn((usize, usize)) -> usize| before.iter().map(shape).map(of).min();
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
