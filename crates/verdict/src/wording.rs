//! Words and numbers as every sentence of a verdict spells them.

use std::f64::consts::FRAC_PI_2;

use super::policy::Variant;
use crate::conditioning::{Cfc, bias};
use latchgate_kernel::units::{plain, short};

/// Returns the name of a filter as verdicts state it.
pub fn filter_name(filter: Option<Cfc>) -> &'static str {
    filter.map_or("none", Cfc::name)
}

/// Returns how the bias's standard error counts correlated samples.
pub fn bias_method() -> &'static str {
    bias::STANDARD_ERROR_METHOD
}

/// Returns an instant with its unit: milliseconds below ten seconds, as in the report.
pub(super) fn instant(seconds: f64) -> String {
    if seconds.abs() < 10.0 {
        format!("{} ms", short(1e3 * seconds, 5))
    } else {
        format!("{} s", short(seconds, 7))
    }
}

/// As [`instant`], with the digits that a nominal run's instant deserves.
pub(super) fn brief_instant(seconds: f64) -> String {
    if seconds.abs() < 10.0 {
        format!("{} ms", short(1e3 * seconds, 3))
    } else {
        format!("{} s", short(seconds, 3))
    }
}

/// Returns an angle of the lever, degrees first; beyond 90°, where the model of the lever means
/// nothing, that alone.
pub(crate) fn angle(radians: f64, digits: usize) -> String {
    if radians > FRAC_PI_2 {
        return "more than 90°".into();
    }
    let radians_text = plain(radians, digits);
    format!("{} ({radians_text} rad)", degrees(radians, digits))
}

/// Returns an angle, or an error of one, in degrees alone.
pub(crate) fn degrees(radians: f64, digits: usize) -> String {
    if radians > FRAC_PI_2 {
        return "more than 90°".into();
    }
    format!("{}°", plain(radians.to_degrees(), digits))
}

/// Returns an upper bound of an angle in degrees with three digits, rounded up.
pub(crate) fn degrees_at_most(radians: f64) -> String {
    let value = radians.to_degrees();
    let unit = libm::pow(10.0, libm::log10(value).floor() - 2.0);
    // What has three digits already is not raised by the rounding of a division.
    format!("{}°", short((value / unit - 1e-9).ceil() * unit, 3))
}

/// Returns a share that somebody set, in percent.
pub fn percent(share: f64) -> String {
    short(100.0 * share, 6)
}

/// Returns a bound of a share in percent with two digits, rounded to the side on which it still bounds.
pub fn percent_bound(share: f64, round: fn(f64) -> f64) -> String {
    let percent = 100.0 * share;
    let unit = match percent {
        10.0.. => 1.0,
        1.0.. => 0.1,
        _ => libm::pow(10.0, libm::log10(percent.max(1e-9)).floor() - 1.0),
    };
    short(round(percent / unit) * unit, 3)
}

/// Returns a change with its sign.
pub(super) fn signed(change: f64) -> String {
    let sign = if change < 0.0 { "" } else { "+" };
    format!("{sign}{}", plain(change, 3))
}

/// Names a stop and an opening direction.
pub(super) fn place(variant: Variant) -> String {
    format!(
        "{} stop, {} acceleration",
        variant.model.name(),
        variant.opens_when.name()
    )
}

/// Makes a sentence of a finding's text: a capital first, a full stop last.
pub(super) fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let mut sentence: String = letters
        .next()
        .map(|first| first.to_uppercase().chain(letters).collect())
        .unwrap_or_default();
    if !sentence.ends_with(['.', '!', '?']) {
        sentence.push('.');
    }
    sentence
}
