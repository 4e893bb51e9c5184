//! Curve files: two columns of numbers, no header.

use crate::encoding;
use crate::error::{Error, Place};
use crate::number::{Decimal, PrintedDigits};
use crate::{Finding, Limits, held, text, time_base};

/// The numbers of a curve file.
#[derive(Debug)]
pub(super) struct Curve {
    pub(super) stamps_s: Vec<f64>,
    pub(super) values: Vec<f64>,
    /// Size of the last printed digit of a stamp [s].
    pub(super) printed_digit_s: f64,
    /// The finding that the file ends in the middle of a line.
    pub(super) cut: Option<Finding>,
}

/// True if the first line is two numbers, divided by blanks or tabs.
pub(super) fn looks_like_curve(head: &[u8]) -> bool {
    let text = String::from_utf8_lossy(head);
    let first = text.lines().find(|line| !line.trim().is_empty());
    let mut cells = first.unwrap_or_default().split_whitespace();
    cells.clone().count() == 2 && cells.all(|cell| cell.parse::<f64>().is_ok_and(f64::is_finite))
}

impl Curve {
    pub(super) fn read(bytes: Vec<u8>, limits: &Limits) -> Result<Self, Error> {
        let (text_of_file, _) = encoding::text_of(bytes, limits)?;
        let mut curve = Self {
            stamps_s: Vec::new(),
            values: Vec::new(),
            printed_digit_s: 0.0,
            cut: held::cut_line(&text_of_file),
        };
        let mut digits = PrintedDigits::new();
        for (number, line) in text::lines(&text_of_file) {
            let place = |column: u64| Place::default().line(number).column(column);
            let mut cells = line.split_whitespace();
            let Some(stamp) = cells.next() else { continue };
            let (Some(value), None) = (cells.next(), cells.next()) else {
                return Err(Error::malformed(
                    "a stamp and a value",
                    format!("`{}`", text::shown(line)),
                    "the curve file is damaged; fetch it again",
                )
                .at(place(1)));
            };
            // The format writes decimal points, so that a comma is damage.
            let mut point = Decimal::PointOnly;
            let second = text::sample(stamp, &mut point).map_err(|error| error.at(place(1)))?;
            digits.count(stamp.as_bytes());
            let sample = text::sample(value, &mut point).map_err(|error| error.at(place(2)))?;
            curve.stamps_s.push(second);
            time_base::check_rising(&curve.stamps_s).map_err(|error| error.at(place(1)))?;
            curve.values.push(sample);
            if curve.values.len() as u64 > limits.samples {
                return Err(limits.over("samples", "more samples").at(place(1)));
            }
        }
        if curve.values.is_empty() {
            let found = "the curve file holds no sample";
            return Err(Error::empty(found, "lines of stamp and value"));
        }
        curve.printed_digit_s = digits.last_digit();
        Ok(curve)
    }
}
