//! Angles as people read them: degrees first, no more digits than are known.

use latchgate_document::number::trimmed;
use std::f64::consts::FRAC_PI_2;

/// A peak as it may be shown.
#[derive(Debug, Clone, PartialEq)]
pub enum KnownPeak {
    /// It lies beyond 90°, where no figure means anything.
    Beyond,
    /// It has a figure.
    Within(AngleText),
    /// Its error is as large as itself; the words say what cannot be computed.
    Open(&'static str),
}

/// An angle in both units.
#[derive(Debug, Clone, PartialEq)]
pub struct AngleText {
    /// In degrees, with its uncertainty.
    pub degrees: String,
    /// In radians.
    pub radians: String,
}

impl KnownPeak {
    /// Sorts a peak by its error: an error as large as the peak itself is not shown. Where peak and error stay
    /// below the threshold, their sum is shown beside the peak. `opens` is true if the lever certainly opens.
    pub fn of(peak_rad: f64, error_rad: Option<f64>, threshold_rad: f64, opens: bool) -> Self {
        if peak_rad > FRAC_PI_2 {
            return Self::Beyond;
        }
        let error_or_none = error_rad.unwrap_or(0.0);
        // A soft stop holds the lever a little below its surface, where no angle is worth a figure.
        if peak_rad <= 0.0 && peak_rad + error_or_none <= 0.0 {
            return Self::Within(AngleText {
                degrees: "0°".into(),
                radians: "0\u{00A0}rad".into(),
            });
        }
        // An error is shown rounded up, by a tenth at most.
        let large = error_rad.filter(|error| 1.1 * error >= peak_rad.abs() && *error > 0.0);
        let Some(large) = large else {
            return Self::Within(AngleText {
                degrees: degrees(peak_rad, error_rad),
                radians: format!("{}\u{00A0}rad", trimmed(peak_rad, 3)),
            });
        };
        let upper_rad = peak_rad.max(0.0) + large;
        if upper_rad <= threshold_rad {
            let peak = peak_rad.max(0.0).to_degrees();
            return Self::Within(AngleText {
                degrees: format!(
                    "{}°, at most {}°",
                    trimmed(peak, 2),
                    bound(upper_rad.to_degrees())
                ),
                radians: format!("{}\u{00A0}rad", bound(upper_rad)),
            });
        }
        Self::Open(if opens {
            "how far it opens cannot be computed"
        } else {
            "whether it opens cannot be computed"
        })
    }

    /// Returns the peak in a few words.
    pub fn short(self) -> String {
        match self {
            Self::Beyond => "> 90°".into(),
            Self::Within(angle) => angle.degrees,
            Self::Open(words) => words.into(),
        }
    }
}

/// Returns an upper bound with three digits, rounded up.
pub fn bound(value: f64) -> String {
    if value <= 0.0 || !value.is_finite() {
        return trimmed(value, 3);
    }
    let unit = libm::pow(10.0, libm::log10(value).floor() - 2.0);
    // What has three digits already is not raised by the rounding of a division.
    trimmed((value / unit - 1e-9).ceil() * unit, 3)
}

/// Returns an angle [rad] in degrees with its uncertainty, rounded up, and the digits that this allows, four
/// at most: `2.9° ± 0.4°`.
fn degrees(radians: f64, error_rad: Option<f64>) -> String {
    let (value, error) = (radians.to_degrees(), error_rad.map(f64::to_degrees));
    let place = |number: f64| libm::log10(number.abs()).floor();
    let decimals_max = if value == 0.0 {
        4.0
    } else {
        3.0 - place(value)
    };
    let Some(error) = error.filter(|error| error.is_finite() && *error > 0.0) else {
        return format!("{}°", trimmed(value, 4));
    };
    let decimals = (1.0 - place(error)).min(decimals_max).clamp(0.0, 9.0);
    let unit = libm::pow(10.0, -decimals);
    let error = (error / unit).ceil() * unit;
    let digits = decimals as usize;
    let text = format!("{value:.digits$}°\u{00A0}±\u{00A0}{error:.digits$}°");
    text.replace('-', "\u{2212}")
}
