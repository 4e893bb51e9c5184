//! Bounds of a share from a count, and the looks that share their error.

/// Members after which the ensemble is looked at, unless it ends earlier.
pub const LOOKS: [u32; 4] = [128, 512, 2048, 10_000];

/// Returns the confidence of each one-sided bound at each look, where all looks together have `confidence` [-]: they
/// share what is missing to 1.
pub fn look_confidence(confidence: f64) -> f64 {
    1.0 - (1.0 - confidence) / LOOKS.len() as f64
}

/// Returns the least number of members of which none may open, so that fewer than `open_share` open at the
/// confidence of a look.
pub fn members_needed(open_share: f64, confidence: f64) -> u32 {
    let error = 1.0 - look_confidence(confidence);
    let members = libm::log(error) / libm::log1p(-open_share);
    // No ensemble is larger than a 32-bit count.
    members.ceil().min(f64::from(u32::MAX)) as u32
}

/// Returns the one-sided lower bound of Clopper and Pearson for the share of which `count` of
/// `members` were seen [-].
///
/// It is the share at which `count` or more would be seen with probability 1 − `confidence`.
///
/// # Source
///
/// C. J. Clopper, E. S. Pearson, Biometrika 26 (1934), 404.
pub fn lower(count: u64, members: u64, confidence: f64) -> f64 {
    if count == 0 || members == 0 {
        return 0.0;
    }
    let count = count.min(members);
    beta_quantile(
        1.0 - confidence,
        as_number(count),
        as_number(members - count + 1),
    )
}

/// Returns the one-sided upper bound of Clopper and Pearson for the share of which `count` of
/// `members` were seen [-].
pub fn upper(count: u64, members: u64, confidence: f64) -> f64 {
    if count >= members {
        return 1.0;
    }
    // By symmetry the lower bound of those that were not seen; 1 − x of a small x loses none
    // of the digits that matter.
    beta_quantile(confidence, as_number(count + 1), as_number(members - count))
}

fn as_number(count: u64) -> f64 {
    count as f64
}

/// Returns x at which the regularised incomplete beta function I(x; a, b) is `share`, by
/// halving until the interval has no inside.
fn beta_quantile(share: f64, a: f64, b: f64) -> f64 {
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    // 1100 halvings separate the smallest f64 from 1; the mean stops them long before.
    for _ in 0..1100 {
        let middle = f64::midpoint(low, high);
        if middle <= low || middle >= high {
            break;
        }
        if incomplete_beta(middle, a, b) < share {
            low = middle;
        } else {
            high = middle;
        }
    }
    f64::midpoint(low, high)
}

/// Returns the regularised incomplete beta function I(x; a, b) [-] for a, b ≥ 1.
///
/// Continued fraction, evaluated by Lentz's method, on the side of the mean where it converges
/// in about √max(a, b) terms. Relative error about 1e-16 times a + b, from the logarithm of the
/// beta function: 1e-11 at 10⁵ members.
///
/// # Source
///
/// NIST Digital Library of Mathematical Functions, eq. 8.17.22.
pub fn incomplete_beta(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if x >= 1.0 {
        return 1.0;
    }
    let front = libm::exp(
        a * libm::log(x) + b * libm::log1p(-x) + libm::lgamma(a + b)
            - libm::lgamma(a)
            - libm::lgamma(b),
    );
    if x < (a + 1.0) / (a + b + 2.0) {
        front / a * fraction(x, a, b)
    } else {
        1.0 - front / b * fraction(1.0 - x, b, a)
    }
}

fn fraction(x: f64, a: f64, b: f64) -> f64 {
    const TINY: f64 = 1e-300;
    /// Terms after which the value is taken as it is: √(10⁸) and some.
    const TERMS: u32 = 20_000;
    let nonzero = |value: f64| if value.abs() < TINY { TINY } else { value };
    let mut numerator = 1.0;
    let mut denominator = 1.0 / nonzero(1.0 - (a + b) * x / (a + 1.0));
    let mut value = denominator;
    for term in 1..TERMS {
        let m = f64::from(term);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let mut change = 1.0;
        for coefficient in [even, odd] {
            denominator = 1.0 / nonzero(1.0 + coefficient * denominator);
            numerator = nonzero(1.0 + coefficient / numerator);
            change = denominator * numerator;
            value *= change;
        }
        if (change - 1.0).abs() < 1e-16 {
            break;
        }
    }
    value
}
