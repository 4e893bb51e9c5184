//! Texts of the golden set as templates. A line that begins with `{rows}` stands for a row of every
//! sample, with `{rows 60..170}` for those of samples 60 to 169, with `{rows 100}` for that of one;
//! a bound that is left out is that of the record. All other lines are literal. In a row:
//!
//! | token | stands for |
//! | --- | --- |
//! | `{g}`, `{si}` | the sample in g or in m/s², three digits |
//! | `{t}` | its time in seconds, four digits |
//! | `{u}` | the time of a clock that runs unevenly, seven digits |
//! | `{k}` | its index |
//! | `{g@5}` | the sample five places later |
//! | `{t*1e3}`, `{g min 20}` | computed from left to right with `+ - * / min max` and numbers |
//! | `{g:,+.4}` | another format: `'` for a comma between thousands, `,` for the point, `+` for the sign of positive ones, `>9`, `<9` or `09` for the width, `.4` for digits, `e`, `E` or `x` for the notation |
//! | `{at 10:00 %H:%M:%S.%4}` | the time of day, sample 0 lying at 10:00; `%I` and `%p` of a clock of twelve hours, `%1` to `%7` digits of the second; `-10:00` runs backwards |
//! | `{turn a|b|c}` | the words in turn |
//! | `{{`, `}}` | a brace |

use super::case::{FROM, TO, push, to_and_fro};
use std::fmt::Write as _;
use std::ops::Range;

/// Standard gravity [m/s²].
const STANDARD_GRAVITY: f64 = 9.806_65;
/// Samples per second.
const TICKS: i64 = 10_000;
const DAY_S: i64 = 86_400;

/// The text that a template stands for; an error names the line of the template.
pub(super) fn expand(template: &str) -> Result<String, String> {
    let mut text = String::new();
    for (index, line) in template.split_inclusive('\n').enumerate() {
        let place = |reason| {
            format!(
                "line {} of the text, `{}`: {reason}",
                index + 1,
                line.trim_end()
            )
        };
        let Some(rest) = line.strip_prefix("{rows") else {
            text += line;
            continue;
        };
        let (range, row) = rest.split_once('}').ok_or_else(|| place("no `}`".into()))?;
        let range = rows(range).map_err(place)?;
        let (row, end) = match row.strip_suffix('\n') {
            Some(row) => (row, "\n"),
            None => (row, ""),
        };
        let parts = parts(row).map_err(place)?;
        let last = range.end - 1;
        for k in range {
            for part in &parts {
                part.write(k, &mut text);
            }
            text += if k == last { end } else { "\n" };
        }
    }
    Ok(text)
}

/// Reads what stands between `{rows` and `}`.
fn rows(text: &str) -> Result<Range<i64>, String> {
    let number = |text: &str, default| match text {
        "" => Ok(default),
        _ => whole(text),
    };
    let range = match text.strip_prefix(' ') {
        None if text.is_empty() => FROM..TO,
        None => return Err(format!("`{text}` is no range")),
        Some(text) => match text.split_once("..") {
            Some((from, to)) => number(from, FROM)?..number(to, TO)?,
            None => whole(text)?..whole(text)? + 1,
        },
    };
    if range.is_empty() {
        return Err("a range of no rows".into());
    }
    Ok(range)
}

fn whole(text: &str) -> Result<i64, String> {
    text.parse()
        .map_err(|_| format!("`{text}` is no whole number"))
}

/// A piece of a row.
enum Part {
    Text(String),
    Number(Number),
    TimeOfDay {
        at_s: i64,
        backwards: bool,
        pattern: String,
    },
    Turn(Vec<String>),
}

fn parts(row: &str) -> Result<Vec<Part>, String> {
    let mut parts = Vec::new();
    let mut rest = row;
    while let Some(at) = rest.find(['{', '}']) {
        let (text, from) = rest.split_at(at);
        parts.push(Part::Text(text.into()));
        if from.starts_with("{{") || from.starts_with("}}") {
            parts.push(Part::Text(from[..1].into()));
            rest = &from[2..];
            continue;
        }
        let token = from.strip_prefix('{').and_then(|from| from.split_once('}'));
        let (token, after) = token.ok_or("a brace without its other")?;
        parts.push(part(token)?);
        rest = after;
    }
    parts.push(Part::Text(rest.into()));
    Ok(parts)
}

fn part(token: &str) -> Result<Part, String> {
    if let Some(words) = token.strip_prefix("turn ") {
        return Ok(Part::Turn(words.split('|').map(String::from).collect()));
    }
    if let Some(clock) = token.strip_prefix("at ") {
        let (at, pattern) = clock
            .split_once(' ')
            .ok_or("a time of day without a pattern")?;
        let backwards = at.starts_with('-');
        let (hour, minute) = at
            .trim_start_matches('-')
            .split_once(':')
            .ok_or("a time of day is written as 10:00")?;
        let mut letters = pattern.chars();
        while let Some(letter) = letters.next() {
            if letter == '%' && !letters.next().is_some_and(|c| "HIMSp1234567".contains(c)) {
                return Err(format!("`{pattern}` is no pattern of a time of day"));
            }
        }
        return Ok(Part::TimeOfDay {
            at_s: 3600 * whole(hour)? + 60 * whole(minute)?,
            backwards,
            pattern: pattern.into(),
        });
    }
    Number::parsed(token).map(Part::Number)
}

impl Part {
    fn write(&self, k: i64, text: &mut String) {
        match self {
            Self::Text(literal) => text.push_str(literal),
            Self::Number(number) => number.write(k, text),
            Self::Turn(words) => text.push_str(&words[k.rem_euclid(words.len() as i64) as usize]),
            Self::TimeOfDay {
                at_s,
                backwards,
                pattern,
            } => {
                let ticks = at_s * TICKS + if *backwards { -k } else { k };
                write_time_of_day(ticks.rem_euclid(DAY_S * TICKS), pattern, text);
            }
        }
    }
}

fn write_time_of_day(ticks: i64, pattern: &str, text: &mut String) {
    let seconds = ticks / TICKS;
    let (hour, minute, second) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    let fraction = format!("{:04}000", ticks % TICKS);
    let mut letters = pattern.chars();
    while let Some(letter) = letters.next() {
        if letter != '%' {
            text.push(letter);
            continue;
        }
        match letters.next() {
            Some('H') => write!(text, "{hour:02}").unwrap(),
            Some('I') => write!(text, "{}", (hour + 11) % 12 + 1).unwrap(),
            Some('M') => write!(text, "{minute:02}").unwrap(),
            Some('S') => write!(text, "{second:02}").unwrap(),
            Some('p') => text.push_str(if hour < 12 { "AM" } else { "PM" }),
            digits => {
                let digits = digits.and_then(|digit| digit.to_digit(10)).unwrap();
                text.push_str(&fraction[..digits as usize]);
            }
        }
    }
}

/// A number of a sample, with what is computed of it and how it is written.
struct Number {
    kind: Kind,
    shift: i64,
    operations: Vec<(Operator, f64)>,
    format: Format,
}

#[derive(Clone, Copy)]
enum Kind {
    Gravities,
    MetresPerSecondSquared,
    Time,
    UnevenTime,
    Index,
}

#[derive(Clone, Copy)]
enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
    Min,
    Max,
}

impl Number {
    fn parsed(token: &str) -> Result<Self, String> {
        let unknown = || format!("`{{{token}}}` is no token");
        let (expression, format) = match token.split_once(':') {
            Some((expression, format)) => (expression, Some(format)),
            None => (token, None),
        };
        let name_end = expression
            .find(|c: char| !c.is_ascii_alphabetic())
            .unwrap_or(expression.len());
        let (name, mut rest) = expression.split_at(name_end);
        let (kind, default) = match name {
            "g" => (Kind::Gravities, ".3"),
            "si" => (Kind::MetresPerSecondSquared, ".3"),
            "t" => (Kind::Time, ".4"),
            "u" => (Kind::UnevenTime, ".7"),
            "k" => (Kind::Index, ".0"),
            _ => return Err(unknown()),
        };
        let mut shift = 0;
        if let Some(after) = rest.strip_prefix('@') {
            let sign = usize::from(after.starts_with('-'));
            let digits = after[sign..].find(|c: char| !c.is_ascii_digit());
            let (number, after) = after.split_at(digits.map_or(after.len(), |at| at + sign));
            shift = whole(number)?;
            rest = after;
        }
        let mut operations = Vec::new();
        while !rest.trim_start().is_empty() {
            let operators = [
                ("+", Operator::Add),
                ("-", Operator::Subtract),
                ("*", Operator::Multiply),
                ("/", Operator::Divide),
                ("min", Operator::Min),
                ("max", Operator::Max),
            ];
            rest = rest.trim_start();
            let (operator, after) = operators
                .iter()
                .find_map(|(word, operator)| Some((*operator, rest.strip_prefix(word)?)))
                .ok_or_else(unknown)?;
            let after = after.trim_start();
            let (number, after) = number(after).ok_or_else(unknown)?;
            operations.push((operator, number));
            rest = after;
        }
        let format = Format::parsed(format.unwrap_or(default)).ok_or_else(unknown)?;
        Ok(Self {
            kind,
            shift,
            operations,
            format,
        })
    }

    fn value(&self, k: i64) -> f64 {
        let k = k + self.shift;
        let first = match self.kind {
            Kind::Gravities => push(k),
            Kind::MetresPerSecondSquared => push(k) * STANDARD_GRAVITY,
            Kind::Time => k as f64 / 1e4,
            Kind::UnevenTime => k as f64 / 1e4 + to_and_fro(k) * 1e-6,
            Kind::Index => k as f64,
        };
        let operate = |value: f64, (operator, number): &(Operator, f64)| match operator {
            Operator::Add => value + number,
            Operator::Subtract => value - number,
            Operator::Multiply => value * number,
            Operator::Divide => value / number,
            Operator::Min => value.min(*number),
            Operator::Max => value.max(*number),
        };
        self.operations.iter().fold(first, operate)
    }

    fn write(&self, k: i64, text: &mut String) {
        text.push_str(&self.format.written(self.value(k)));
    }
}

/// Splits the number off with which a text begins.
fn number(text: &str) -> Option<(f64, &str)> {
    let mut end = 0;
    for (at, c) in text.char_indices() {
        let exponent = text[..at].ends_with('e');
        let sign = c == '-' && (at == 0 || exponent);
        if !(c.is_ascii_digit() || c == '.' || sign || c == 'e' && at > 0) {
            break;
        }
        end = at + 1;
    }
    Some((text[..end].parse().ok()?, &text[end..]))
}

/// How a number is written.
struct Format {
    thousands: bool,
    comma: bool,
    plus: bool,
    width: Option<(char, usize)>,
    digits: Option<usize>,
    notation: Option<char>,
}

impl Format {
    fn parsed(text: &str) -> Option<Self> {
        let (thousands, text) = flag(text, '\'');
        let (comma, text) = flag(text, ',');
        let (plus, text) = flag(text, '+');
        let notation = text.chars().last().filter(|last| "eEx".contains(*last));
        let text = text.trim_end_matches(['e', 'E', 'x']);
        let (width, digits) = match text.split_once('.') {
            Some((width, digits)) => (width, Some(digits.parse().ok()?)),
            None => (text, None),
        };
        let width = match width.chars().next() {
            None => None,
            Some(fill @ ('0' | '>' | '<')) => Some((fill, width[1..].parse().ok()?)),
            Some(_) => return None,
        };
        Some(Self {
            thousands,
            comma,
            plus,
            width,
            digits,
            notation,
        })
    }

    fn written(&self, value: f64) -> String {
        let mut text = match (self.notation, self.digits) {
            (Some('x'), _) => format!("{:x}", value as i64),
            (Some('e'), Some(digits)) => format!("{value:.digits$e}"),
            (Some('e'), None) => format!("{value:e}"),
            (Some(_), Some(digits)) => format!("{value:.digits$E}"),
            (Some(_), None) => format!("{value:E}"),
            (None, Some(digits)) => format!("{value:.digits$}"),
            (None, None) => format!("{value}"),
        };
        if self.plus && !text.starts_with('-') {
            text.insert(0, '+');
        }
        if self.thousands {
            let sign = usize::from(text.starts_with('-'));
            let mut at = text.len();
            while at > sign + 3 {
                at -= 3;
                text.insert(at, ',');
            }
        }
        if self.comma {
            text = text.replace('.', ",");
        }
        match self.width {
            Some(('0', width)) => {
                let sign = usize::from(text.starts_with(['-', '+']));
                while text.len() < width {
                    text.insert(sign, '0');
                }
                text
            }
            Some(('>', width)) => format!("{text:>width$}"),
            Some((_, width)) => format!("{text:<width$}"),
            None => text,
        }
    }
}

fn flag(text: &str, mark: char) -> (bool, &str) {
    match text.strip_prefix(mark) {
        Some(rest) => (true, rest),
        None => (false, text),
    }
}

#[track_caller]
fn check(template: &str, expected: &str) {
    assert_eq!(expand(template).as_deref(), Ok(expected), "{template}");
}

#[test]
fn verif_a_template_stands_for_its_text() {
    check(
        "a {t}\n{rows 0..2}{t};{k}\nb",
        "a {t}\n0.0000;0\n0.0001;1\nb",
    );
    check(
        "{rows 3}{k+200:04} {k*100} {k:>3} {{{k}}}",
        "0203 300   3 {3}",
    );
    check(
        "{rows -2..0}x\n{rows ..-198}{k}\n{rows 598..}{k}",
        "x\nx\n-200\n-199\n598\n599",
    );
    check(
        "{rows 2}{k*600:'.0} {k*-5000:'} {k*2:,.1}",
        "1,200 -10,000 4,0",
    );
    check("{rows 2}{t:,} {t:+.5} {t*1e3:.1}", "0,0002 +0.00020 0.2");
    check(
        "{rows 4096}{k:05x} {k:.2E} {k@-4095 / 4:}",
        "01000 4.10E3 0.25",
    );
    check(
        "{rows 2..5}{turn a|b|c} {u}",
        "c 0.0002050\na 0.0003000\nb 0.0004000",
    );
    check(
        "{rows -1}{at 0:00 %H:%M:%S.%4} {at -0:00 %S.%2} {at 12:00 %I:%M %p}",
        "23:59:59.9999 00.00 11:59 AM",
    );
    // 30 sin(π/2) and the noise, in g and in m/s².
    let noise = 0.05 * (91.0_f64).sin() + 0.03 * (231.0_f64).sin();
    let peak = 30.0 + noise;
    check("{rows 100}{g} {g@0 min 20:.1}", &format!("{peak:.3} 20.0"));
    check("{rows 100}{si}", &format!("{:.3}", peak * 9.806_65));
}

#[test]
fn verif_a_template_that_says_nothing_is_refused() {
    for (template, reason) in [
        (
            "a\n{rows 3..3}{g}",
            "line 2 of the text, `{rows 3..3}{g}`: a range of no rows",
        ),
        ("{rows x}{g}", "`x` is no whole number"),
        ("{rows", "no `}`"),
        ("{rows5}{g}", "`5` is no range"),
        ("{rows}{g", "a brace without its other"),
        ("{rows}g}", "a brace without its other"),
        ("{rows}{h}", "`{h}` is no token"),
        ("{rows}{g^2}", "`{g^2}` is no token"),
        ("{rows}{g*}", "`{g*}` is no token"),
        ("{rows}{g:5}", "`{g:5}` is no token"),
        ("{rows}{at 10:00}", "a time of day without a pattern"),
        ("{rows}{at 10 %H}", "a time of day is written as 10:00"),
        ("{rows}{at 10:00 %x}", "`%x` is no pattern"),
    ] {
        let refusal = expand(template).unwrap_err();
        assert!(refusal.contains(reason), "{template}: {refusal}");
    }
}
