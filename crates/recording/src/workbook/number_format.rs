//! Number formats of cells: which numbers are dates, and which are shown as others than they are.

/// What the format of a cell makes of its number.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) enum NumberFormat {
    #[default]
    Plain,
    /// A comma behind the digits shows a thousandth of it.
    Scaled,
    /// Days are shown as date, as time of day, or as hours and more that went by.
    Date { has_time: bool, is_elapsed: bool },
}

impl NumberFormat {
    /// Reads the code of a format, `dd.mm.yyyy hh:mm` or `#,##0.0,`.
    pub(super) fn of_code(code: &str) -> Self {
        let (mut has_date, mut has_time, mut is_elapsed, mut has_month) =
            (false, false, false, false);
        let (mut after_digit, mut comma_open, mut is_scaled) = (false, false, false);
        let mut letters = code.chars();
        while let Some(letter) = letters.next() {
            match letter {
                '"' => letters.by_ref().take_while(|c| *c != '"').for_each(drop),
                '\\' | '_' | '*' => drop(letters.next()),
                '[' => {
                    let inner: String = letters.by_ref().take_while(|c| *c != ']').collect();
                    let inner = inner.to_ascii_lowercase();
                    let is_of = |unit: char| !inner.is_empty() && inner.chars().all(|c| c == unit);
                    is_elapsed |= ['h', 'm', 's'].into_iter().any(is_of);
                }
                'y' | 'Y' | 'd' | 'D' => has_date = true,
                'h' | 'H' | 's' | 'S' => has_time = true,
                'm' | 'M' => has_month = true,
                ',' if after_digit => comma_open = true,
                '0' | '#' | '?' => (after_digit, comma_open) = (true, false),
                _ => {
                    is_scaled |= comma_open;
                    (after_digit, comma_open) = (false, false);
                }
            }
        }
        is_scaled |= comma_open;
        has_date |= has_month && !has_time && !is_elapsed;
        match (has_date || has_time || is_elapsed, is_scaled) {
            (true, _) => Self::Date {
                has_time: has_time || is_elapsed,
                is_elapsed,
            },
            (false, true) => Self::Scaled,
            (false, false) => Self::Plain,
        }
    }

    /// Returns a format that has a number and no code in the file.
    ///
    /// # Source
    ///
    /// ECMA-376, part 1, 18.8.30; the numbers from 27 on are dates of East Asia.
    pub(super) fn built_in(number: u32) -> Self {
        match number {
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

#[cfg(test)]
mod tests {
    use super::NumberFormat::{self, Date, Plain, Scaled};

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
        let cases = [
            ("General", Plain),
            ("0.00", Plain),
            ("#,##0.00", Plain),
            ("#,##0", Plain),
            ("0.00%", Plain),
            ("0.00E+00", Plain),
            ("[Red]0.0", Plain),
            ("0.0\" m/s\"", Plain),
            ("0.0\\ \\s", Plain),
            ("_(* #,##0.00_);_(* (#,##0.00)", Plain),
            ("0.0,", Scaled),
            ("#,##0,", Scaled),
            ("0,,\" M\"", Scaled),
            ("0.0;-0.0,", Scaled),
            ("yyyy-mm-dd", date),
            ("mmm", date),
            ("dd.mm.yyyy hh:mm", clock),
            ("[$-409]h:mm AM/PM", clock),
            ("mm:ss.000", clock),
            ("ss.0000", clock),
            ("[h]:mm:ss", elapsed),
            ("[ss].000", elapsed),
        ];
        for (code, format) in cases {
            assert_eq!(NumberFormat::of_code(code), format, "{code}");
        }
    }
}
