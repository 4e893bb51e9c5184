//! Number formats of cells: which numbers are dates, and which are shown as others than they are.

use std::iter::Peekable;
use std::str::Chars;
use std::sync::Arc;

/// What the format of a cell makes of its number.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) enum NumberFormat {
    #[default]
    Plain,
    /// Another number is shown, or none: a thousandth, a percentage, a number without its sign, a word.
    Other,
    /// The number is shown, and these words behind it: `m/s2`.
    Worded(Arc<str>),
    /// Days are shown as date, as time of day, or as hours and more that went by.
    Date { has_time: bool, is_elapsed: bool },
}

/// What one section of a format shows.
#[derive(Debug, Default)]
struct Section {
    has_placeholder: bool,
    /// A stroke, of a fraction or between the parts of a date.
    has_stroke: bool,
    /// A comma behind the digits, a percent sign, words before them or a condition.
    is_other: bool,
    is_signed: bool,
    words: String,
    has_date: bool,
    has_time: bool,
    is_elapsed: bool,
    has_month: bool,
}

impl Section {
    /// Takes in characters that are shown as they are.
    fn show(&mut self, shown: &str) {
        self.is_signed |= shown.contains(['-', '\u{2212}', '\u{2013}']);
        self.is_signed |= !self.has_placeholder && shown.contains('(');
        self.words.push_str(shown);
    }

    fn take_placeholder(&mut self) {
        self.has_placeholder = true;
        self.is_other |= !self.words().is_empty();
    }

    /// Returns the words beside the number, without signs, blanks and the brackets of a negative one.
    fn words(&self) -> &str {
        let is_plain = |c: char| c.is_whitespace() || "()+-\u{2212}\u{2013}".contains(c);
        self.words.trim_matches(is_plain)
    }

    fn is_date(&self) -> bool {
        self.has_date || self.has_time || self.is_elapsed || self.has_month
    }
}

impl NumberFormat {
    /// Reads the code of a format, `dd.mm.yyyy hh:mm` or `#,##0.0,`.
    pub(super) fn of_code(code: &str) -> Self {
        let sections = sections(code);
        if sections.iter().any(Section::is_date) {
            let any = |is_so: fn(&Section) -> bool| sections.iter().any(is_so);
            return Self::Date {
                has_time: any(|one| one.has_time || one.is_elapsed),
                is_elapsed: any(|one| one.is_elapsed),
            };
        }
        // Of positive numbers, negative ones and zeros; the fourth is of texts.
        let of_numbers = &sections[..sections.len().min(3)];
        let is_other = |one: &Section| one.is_other || one.has_stroke || !one.has_placeholder;
        let is_signed = |number: usize| of_numbers.get(number).map(|one| one.is_signed);
        if of_numbers.iter().any(is_other)
            || is_signed(0) == Some(true)
            || is_signed(1) == Some(false)
        {
            return Self::Other;
        }
        let words = of_numbers.iter().map(Section::words);
        let mut words: Vec<&str> = words.filter(|words| !words.is_empty()).collect();
        words.dedup();
        match words.as_slice() {
            [] => Self::Plain,
            [only] => Self::Worded(Arc::from(*only)),
            _ => Self::Other,
        }
    }

    /// Returns a format that has a number and no code in the file.
    ///
    /// # Source
    ///
    /// ECMA-376, part 1, 18.8.30; the numbers from 27 on are dates of East Asia.
    pub(super) fn built_in(number: u32) -> Self {
        match number {
            // Amounts of money, percentages and fractions; the numbers from 67 on are of Thailand.
            5..=10 | 12 | 13 | 42 | 44 | 67..=81 => Self::Other,
            14..=17 | 27..=31 | 36 | 50..=58 => Self::Date {
                has_time: false,
                is_elapsed: false,
            },
            18..=22 | 32..=35 | 45 | 47 => Self::Date {
                has_time: true,
                is_elapsed: false,
            },
            46 => Self::Date {
                has_time: true,
                is_elapsed: true,
            },
            _ => Self::Plain,
        }
    }
}

/// Reads the sections of a format.
fn sections(code: &str) -> Vec<Section> {
    let mut sections = Vec::new();
    let mut section = Section::default();
    let mut comma_open = false;
    let mut letters = code.chars().peekable();
    while let Some(letter) = letters.next() {
        // Commas between digits part thousands.
        section.is_other |= comma_open && !matches!(letter, '0' | '#' | '?');
        comma_open = false;
        match letter {
            ';' => sections.push(std::mem::take(&mut section)),
            '"' => {
                let shown: String = letters.by_ref().take_while(|c| *c != '"').collect();
                section.show(&shown);
            }
            '\\' => {
                let shown = letters.next();
                section.show(shown.map(String::from).as_deref().unwrap_or_default());
            }
            // A blank of a width, and what fills the cell.
            '_' | '*' => drop(letters.next()),
            '[' => {
                let inner: String = letters.by_ref().take_while(|c| *c != ']').collect();
                let inner = inner.to_ascii_lowercase();
                let is_of = |unit: char| !inner.is_empty() && inner.chars().all(|c| c == unit);
                section.is_elapsed |= ['h', 'm', 's'].into_iter().any(is_of);
                section.is_other |= inner.starts_with(['<', '>', '=']);
                // A currency before the number of a language.
                if let Some(currency) = inner.strip_prefix('$') {
                    section.show(currency.split('-').next().unwrap_or_default());
                }
            }
            '0' | '#' | '?' | '@' => section.take_placeholder(),
            ',' => comma_open = section.has_placeholder,
            '%' | '\u{2030}' => section.is_other = true,
            // A power of ten with its sign; in other places an era.
            'E' | 'e' if letters.peek().is_some_and(|next| matches!(next, '+' | '-')) => {
                letters.next();
            }
            'G' | 'g' if rest_of_general(&letters) => {
                letters.by_ref().take("eneral".len()).for_each(drop);
                section.take_placeholder();
            }
            'y' | 'Y' | 'd' | 'D' => section.has_date = true,
            'h' | 'H' | 's' | 'S' => section.has_time = true,
            'm' | 'M' => section.has_month = true,
            '/' => section.has_stroke = true,
            '.' => {}
            other => section.show(&other.to_string()),
        }
    }
    section.is_other |= comma_open;
    sections.push(section);
    sections
}

/// Tells whether what follows a G makes it `General`.
fn rest_of_general(letters: &Peekable<Chars<'_>>) -> bool {
    let following: String = letters.clone().take("eneral".len()).collect();
    following.eq_ignore_ascii_case("eneral")
}

#[cfg(test)]
mod tests {
    use super::NumberFormat::{self, Date, Other, Plain, Worded};

    #[test]
    fn verif_codes_of_formats() {
        let date = Date {
            has_time: false,
            is_elapsed: false,
        };
        let clock = Date {
            has_time: true,
            is_elapsed: false,
        };
        let elapsed = Date {
            has_time: true,
            is_elapsed: true,
        };
        let worded = |words: &str| Worded(words.into());
        let cases = [
            ("General", Plain),
            ("GENERAL;-General", Plain),
            ("@", Plain),
            ("0.00", Plain),
            ("#,##0.00", Plain),
            ("#,##0", Plain),
            ("# ##0.00", Plain),
            ("0.00E+00", Plain),
            ("##0.0E-0", Plain),
            ("[Red]0.0", Plain),
            ("0.00;[Red]-0.00", Plain),
            ("0.0\" m/s\"", worded("m/s")),
            ("0.0\\ \\s", worded("s")),
            ("0.0 [$mm/s2-409]", worded("mm/s2")),
            ("0.0\" g\";-0.0\" g\";0.0", worded("g")),
            ("0.0\" g\";-0.0\" m/s2\"", Other),
            ("_(* #,##0.00_);_(* (#,##0.00)", Plain),
            ("_-* #,##0.00_-;\\-* #,##0.00_-;_-* \"-\"??_-;_-@_-", Plain),
            ("0.00%", Other),
            ("0.0,", Other),
            ("#,##0,", Other),
            ("0.0 ,", Other),
            ("0,,\" M\"", Other),
            ("0.0;-0.0,", Other),
            ("# ?/?", Other),
            ("0.0;-# ??/16", Other),
            ("0.0\\ \\g\\/\\2", worded("g/2")),
            ("0.00;0.00", Other),
            ("0.00;[Red]0.00", Other),
            ("-0.00;0.00", Other),
            ("-0.0", Other),
            (";;;", Other),
            ("0;-0;", Other),
            ("\"dropout\"", Other),
            ("0.00;-0.00;\"n/a\"", Other),
            ("\"clipped \"0.0", Other),
            ("0\\.0", Other),
            ("\"1\"0", Other),
            ("[>100]0;-0", Other),
            ("0\"00\"", worded("00")),
            ("0.0\"e3\"", worded("e3")),
            ("yyyy-mm-dd", date.clone()),
            ("mmm", date.clone()),
            ("dd.mm.yyyy hh:mm", clock.clone()),
            ("dd/mm/yyyy hh:mm", clock.clone()),
            ("[$-409]h:mm AM/PM", clock.clone()),
            ("mm:ss.000", clock.clone()),
            ("ss.0000", clock.clone()),
            ("[h]:mm:ss", elapsed.clone()),
            ("[ss].000", elapsed.clone()),
            ("[$-409]d-mmm-yy;@", date.clone()),
            ("hh:mm:ss\" Uhr\"", clock.clone()),
        ];
        for (code, format) in cases {
            assert_eq!(NumberFormat::of_code(code), format, "{code}");
        }
    }
}
