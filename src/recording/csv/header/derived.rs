//! Names of what was computed from an acceleration, or is none: rectified, held, averaged,
//! modelled. Such numbers lack the sign or the shape of the motion that a lever feels.

use super::{ACCELERATION, LATERAL_ACCELERATION, words};

/// Words for what is computed. Whole words only: `std` is one, `studs` holds none.
const COMPUTED: &[&str] = &[
    // Without sign or direction.
    "abs",
    "absolute",
    "absolut",
    "betrag",
    "absolutbetrag",
    "magnitude",
    "norm",
    "rectified",
    "gleichgerichtet",
    "res",
    "resultant",
    "resultante",
    "resultierend",
    "resultierende",
    "xy",
    "yz",
    "xz",
    "xyz",
    "vector",
    "vektor",
    "sqrt",
    "squared",
    "quadrat",
    "inverted",
    "invertiert",
    "negated",
    // Extremes.
    "peak",
    "peakhold",
    "hold",
    "maxhold",
    "minhold",
    "max",
    "maximum",
    "maximal",
    "maximalwert",
    "maxima",
    "min",
    "minimum",
    "minimal",
    "minimalwert",
    "minima",
    "minmax",
    "spitze",
    "spitzenwert",
    "scheitelwert",
    "envelope",
    "hüllkurve",
    "huellkurve",
    "einhüllende",
    // Statistics.
    "mean",
    "average",
    "averaged",
    "avg",
    "median",
    "mittel",
    "mittelwert",
    "gemittelt",
    "rms",
    "effektiv",
    "effektivwert",
    "std",
    "stddev",
    "stdev",
    "sd",
    "sigma",
    "var",
    "variance",
    "varianz",
    "standardabweichung",
    "percentile",
    "perzentil",
    "uncertainty",
    "unsicherheit",
    "tolerance",
    "toleranz",
    // Spectra.
    "psd",
    "asd",
    "fft",
    "srs",
    "spectrum",
    "spectral",
    "spektrum",
    "spektral",
    // Operations on several samples or channels.
    "derivative",
    "deriv",
    "derived",
    "ableitung",
    "abgeleitet",
    "jerk",
    "ruck",
    "integral",
    "integrated",
    "integriert",
    "diff",
    "difference",
    "differenz",
    "delta",
    "minus",
    "sum",
    "summe",
    "ratio",
    "verhältnis",
    "normalized",
    "normalised",
    "normiert",
    "computed",
    "calculated",
    "calc",
    "berechnet",
    // What should be, not what was.
    "error",
    "err",
    "fehler",
    "residual",
    "abweichung",
    "target",
    "setpoint",
    "soll",
    "sollwert",
    "command",
    "commanded",
    "cmd",
    "demand",
    "reference",
    "ref",
    "referenz",
    "nominal",
    "expected",
    "limit",
    "limits",
    "grenze",
    "grenzwert",
    "threshold",
    "schwelle",
    "corridor",
    "korridor",
    "model",
    "modell",
    "modeled",
    "modelled",
    "predicted",
    "prediction",
    "estimate",
    "estimated",
    "simulated",
    "simulation",
    "simuliert",
    "sim",
    "cae",
    "fem",
    "status",
    "flag",
    "valid",
];

/// Words for other quantities than a linear acceleration.
const OTHER_QUANTITIES: &[&str] = &[
    "angular",
    "ang",
    "rot",
    "rotational",
    "gyro",
    "gyroscope",
    "alpha",
    "omega",
    "theta",
    "velocity",
    "vel",
    "velo",
    "speed",
    "geschwindigkeit",
    "geschw",
    "displacement",
    "disp",
    "weg",
    "deflection",
    "intrusion",
    "force",
    "kraft",
    "torque",
    "moment",
    "strain",
    "dehnung",
    "pressure",
    "druck",
    "mag",
    "magnetic",
    "mass",
    "masse",
    "weight",
    "gewicht",
    "energy",
    "energie",
    "temperature",
    "temperatur",
    "voltage",
    "spannung",
];

/// Tells whether a name says another quantity than a linear acceleration.
pub(super) fn says_other_quantity(label: &str) -> bool {
    words(label)
        .iter()
        .any(|word| OTHER_QUANTITIES.contains(&word.as_str()))
}

/// Tells whether a name says something computed: by a word, by bars (`|ay|`), by a sign before it
/// (`-ay`), or as a difference or sum of two of a kind (`ay1-ay2`).
pub(super) fn says_computed(label: &str) -> bool {
    let label = label.trim();
    let words = words(label);
    words.iter().any(|word| is_computed(word))
        || label.matches('|').count() > 1
        || label.contains(['‖', '√', '∑', 'Σ', 'Δ', '∫'])
        || label.starts_with(['-', '−'])
        || combines_two(label, &words)
}

/// Tells whether a word is one for what is computed, alone or grown together with one for an
/// acceleration: `ayabs`, `maxacc`.
fn is_computed(word: &str) -> bool {
    let word = word.trim_end_matches(|c: char| c.is_ascii_digit());
    let says = |word: &str| COMPUTED.contains(&word);
    says(word)
        || LATERAL_ACCELERATION
            .iter()
            .chain(ACCELERATION)
            .any(|stem| match stem.len() {
                // `amin` and `arms` are words of their own.
                1 => false,
                _ => {
                    word.strip_prefix(stem).is_some_and(says)
                        || word.strip_suffix(stem).is_some_and(says)
                }
            })
}

/// Tells whether arithmetic joins two words of one kind: `ay1-ay2`, `acc y left + acc y right`.
fn combines_two(label: &str, words: &[String]) -> bool {
    if !label.contains(['-', '−', '–', '+', '/', '*']) {
        return false;
    }
    let stems: Vec<&str> = words
        .iter()
        .map(|word| {
            let stem = word.trim_end_matches(|c: char| c.is_ascii_digit());
            // A letter alone is part of many a name: `A-pillar a y`.
            if word.len() > 1 { stem } else { "" }
        })
        .filter(|stem| {
            LATERAL_ACCELERATION.contains(stem) || ACCELERATION.contains(stem) || *stem == "y"
        })
        .collect();
    let twice = |stem: &&str| stems.iter().filter(|other| *other == stem).count() > 1;
    stems.iter().any(twice)
}
