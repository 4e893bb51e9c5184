//! Real roots of short polynomials on an interval, found in order and without misses.
//!
//! A polynomial is given by its coefficients in rising powers. Roots are isolated by the
//! sign variations of the Bernstein coefficients (Descartes' rule on an interval, after
//! Lane and Riesenfeld 1981), which cannot overlook a pair of close roots as a test of the
//! end values does, and refined by Newton's method kept inside the bracket.

/// Largest number of coefficients.
pub const CAPACITY: usize = 24;

/// Halvings after which two roots count as one point that is touched, not crossed.
const DEPTH_MAX: u32 = 50;

/// Part that rounding may take where a bound decides.
const ROOM: f64 = 1e-12;

/// Part of the last step of Newton's method below which the next follows from both.
const NEWTON_PART: f64 = 0.01;

/// Returns the value at `x`.
#[inline]
pub fn evaluate(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// Returns the value and the derivative at `x`.
#[inline]
pub fn evaluate_with_derivative(coefficients: &[f64], x: f64) -> (f64, f64) {
    let mut value = 0.0;
    let mut derivative = 0.0;
    for c in coefficients.iter().rev() {
        derivative = derivative * x + value;
        value = value * x + c;
    }
    (value, derivative)
}

/// Visits the sign changes on (0, `end`) from left to right with their place and whether the
/// polynomial rises there; stops when `visit` returns false.
///
/// A point that is touched without a change of sign is not visited. Coefficients beyond
/// [`CAPACITY`] are not looked at; of coefficients that are not finite, or overflow on the
/// interval, nothing is visited.
pub fn sign_changes(coefficients: &[f64], end: f64, visit: &mut impl FnMut(f64, bool) -> bool) {
    let count = coefficients.len().min(CAPACITY);
    if count < 2 {
        return;
    }
    let coefficients = &coefficients[..count];
    if stays_positive(coefficients, end) {
        return;
    }
    if is_monotone(coefficients, end) {
        let (first, last) = (coefficients[0], evaluate(coefficients, end));
        if (first < 0.0 && last > 0.0) || (first > 0.0 && last < 0.0) {
            // The root of the line, and what the parabola takes from it.
            let line = -first / coefficients[1];
            let bend = coefficients.get(2).map_or(0.0, |c| c / coefficients[1]);
            let guess = line * (1.0 - bend * line);
            let rises = last > 0.0;
            visit(refine(coefficients, 0.0, end, guess, rises), rises);
        }
        return;
    }
    if is_bent_once(coefficients, end) {
        let rises = coefficients[0] < 0.0;
        visit(refine(coefficients, 0.0, end, 0.5 * end, rises), rises);
        return;
    }
    let bernstein = to_bernstein(coefficients, end);
    if bernstein[..count].iter().any(|b| !b.is_finite()) {
        // No halving would ever settle the sign of what is not a number.
        return;
    }
    isolate(coefficients, &bernstein[..count], 0.0, end, 0, visit);
}

/// One weight for every power.
const ONES: [f64; CAPACITY] = [1.0; CAPACITY];

/// Weights of the powers in the first derivative: n.
const FIRST: [f64; CAPACITY] = falling_factorials(1);

/// Weights of the powers in the second derivative: n (n − 1).
const SECOND: [f64; CAPACITY] = falling_factorials(2);

const fn falling_factorials(factors: usize) -> [f64; CAPACITY] {
    let mut table = [0.0; CAPACITY];
    let mut n = factors;
    while n < CAPACITY {
        let (mut product, mut factor) = (1, 0);
        while factor < factors {
            product *= n - factor;
            factor += 1;
        }
        table[n] = product as f64;
        n += 1;
    }
    table
}

/// Returns Σ w_n |c_n| `end`^(n−`from`) of the coefficients from order `from` on.
///
/// Even and odd powers are summed side by side, since each sum waits for its own last term alone.
#[inline]
fn magnitudes(coefficients: &[f64], from: usize, weights: &[f64; CAPACITY], end: f64) -> f64 {
    let square = end * end;
    let (mut even, mut odd, mut power) = (0.0, 0.0, 1.0);
    let weighted = coefficients.iter().zip(weights).skip(from);
    let mut terms = weighted.map(|(c, weight)| c.abs() * weight);
    while let Some(term) = terms.next() {
        even += term * power;
        odd += terms.next().unwrap_or(0.0) * power;
        power *= square;
    }
    even + odd * end
}

/// Tells whether the parabola of the first three coefficients keeps above zero on (0, `end`) by more
/// than all others can take from it; `false` where that does not show it.
#[inline]
fn stays_positive(coefficients: &[f64], end: f64) -> bool {
    let [constant, linear, ..] = coefficients else {
        return false;
    };
    let bend = coefficients.get(2).map_or(0.0, |c| c * end * end);
    let line = linear * end;
    let last = constant + line + bend;
    let lowest = constant.min(last) - 0.25 * bend.max(0.0);
    let clear = lowest - ROOM * (constant.abs() + line.abs() + bend.abs());
    // What is not a number is not more.
    clear > 0.0
        && clear * (1.0 - ROOM) > magnitudes(coefficients, 3, &ONES, end) * (end * end * end)
}

/// Tells whether the first derivative's constant term outweighs all others on (0, `end`).
#[inline]
fn is_monotone(coefficients: &[f64], end: f64) -> bool {
    let slope = coefficients[1].abs();
    // What is not a number is not less.
    slope.is_finite() && magnitudes(coefficients, 2, &FIRST, end) * end < slope * (1.0 - ROOM)
}

/// Tells whether the second derivative's constant term outweighs all others on (0, `end`) where the
/// polynomial begins and ends on different sides: its Bernstein coefficients then change sign once.
#[inline]
fn is_bent_once(coefficients: &[f64], end: f64) -> bool {
    let (first, last) = (coefficients[0], evaluate(coefficients, end));
    let clear = ROOM * magnitudes(coefficients, 0, &ONES, end);
    let apart = (first > clear && last < -clear) || (first < -clear && last > clear);
    let bend = coefficients.get(2).map_or(0.0, |c| 2.0 * c.abs());
    apart && magnitudes(coefficients, 3, &SECOND, end) * end < bend * (1.0 - ROOM)
}

/// Returns the first place in (0, `end`) where the polynomial falls through zero.
pub fn first_fall(coefficients: &[f64], end: f64) -> Option<f64> {
    let mut fall = None;
    sign_changes(coefficients, end, &mut |x, rises| {
        if !rises {
            fall = Some(x);
        }
        rises
    });
    fall
}

/// C(n, j) in row n, exactly.
const BINOMIAL: [[f64; CAPACITY]; CAPACITY] = {
    let mut table = [[0.0; CAPACITY]; CAPACITY];
    let mut n = 0;
    while n < CAPACITY {
        table[n][0] = 1.0;
        let mut j = 1;
        while j <= n {
            table[n][j] = table[n - 1][j - 1] + table[n - 1][j];
            j += 1;
        }
        n += 1;
    }
    table
};

/// Bernstein coefficients on [0, end]: b_i = Σ_{j≤i} C(i,j)/C(n,j) c_j end^j.
fn to_bernstein(coefficients: &[f64], end: f64) -> [f64; CAPACITY] {
    let n = coefficients.len() - 1;
    let mut b = [0.0; CAPACITY];
    // c_j end^j / C(n,j), then repeated sums: b_i = Σ_j C(i,j) d_j by Pascal's rule in place.
    let mut power = 1.0;
    for ((b, c), binomial) in b.iter_mut().zip(coefficients).zip(&BINOMIAL[n]) {
        *b = c * power / binomial;
        power *= end;
    }
    for level in 1..=n {
        for i in (level..=n).rev() {
            b[i] += b[i - 1];
        }
    }
    b
}

fn isolate(
    coefficients: &[f64],
    bernstein: &[f64],
    low: f64,
    high: f64,
    depth: u32,
    visit: &mut impl FnMut(f64, bool) -> bool,
) -> bool {
    let mut variations = 0;
    let mut last = 0.0;
    for &b in bernstein {
        if b * last < 0.0 || (last != 0.0 && b != 0.0 && (b < 0.0) != (last < 0.0)) {
            variations += 1;
        }
        if b != 0.0 {
            last = b;
        }
    }
    if variations == 0 {
        return true;
    }
    let n = bernstein.len() - 1;
    let (first, end) = (bernstein[0], bernstein[n]);
    if variations == 1 && first != 0.0 && end != 0.0 {
        let guess = 0.5 * (low + high);
        return visit(refine(coefficients, low, high, guess, end > 0.0), end > 0.0);
    }
    if depth >= DEPTH_MAX {
        return true;
    }
    // de Casteljau at the middle: the left coefficients grow along the edge of the triangle.
    let mut left = [0.0; CAPACITY];
    let mut right = [0.0; CAPACITY];
    right[..=n].copy_from_slice(bernstein);
    for (i, edge) in left[..=n].iter_mut().enumerate() {
        *edge = right[0];
        for j in 0..n - i {
            right[j] = 0.5 * (right[j] + right[j + 1]);
        }
    }
    // The last pass leaves the right half in reverse growth: right[j] is the value at level n−j.
    let middle = 0.5 * (low + high);
    let go_on = isolate(coefficients, &left[..=n], low, middle, depth + 1, visit);
    if !go_on {
        return false;
    }
    if left[n] == 0.0 && left[..n].iter().any(|b| *b != 0.0) && crosses(&left[..=n], &right[..=n]) {
        let rises = right[1..=n]
            .iter()
            .find(|b| **b != 0.0)
            .is_some_and(|b| *b > 0.0);
        if !visit(middle, rises) {
            return false;
        }
    }
    isolate(coefficients, &right[..=n], middle, high, depth + 1, visit)
}

/// Tells whether a zero exactly at the joint of two halves is a change of sign.
fn crosses(left: &[f64], right: &[f64]) -> bool {
    let before = left.iter().rev().find(|b| **b != 0.0);
    let after = right.iter().find(|b| **b != 0.0);
    matches!((before, after), (Some(b), Some(a)) if (*b < 0.0) != (*a < 0.0))
}

/// Newton's method from `guess` inside a bracket with one simple root.
fn refine(coefficients: &[f64], low: f64, high: f64, guess: f64, rises: bool) -> f64 {
    let (mut low, mut high) = (low, high);
    let mut x = if guess > low && guess < high {
        guess
    } else {
        0.5 * (low + high)
    };
    // The last step of Newton's method; zero where it was none.
    let mut before = 0.0;
    for _ in 0..80 {
        let (value, derivative) = evaluate_with_derivative(coefficients, x);
        if (value > 0.0) == rises {
            high = x;
        } else {
            low = x;
        }
        let newton = x - value / derivative;
        let inside = newton > low && newton < high;
        let next = if inside { newton } else { 0.5 * (low + high) };
        let moved = (next - x).abs();
        x = next;
        // Each step is a constant times the square of the one before: what the next one would be.
        let ahead = if inside && moved < NEWTON_PART * before {
            moved * (moved / before) * (moved / before)
        } else {
            f64::INFINITY
        };
        let enough = 2.0 * f64::EPSILON * x.abs();
        if moved <= enough || ahead <= 0.125 * enough || high - low <= f64::EPSILON * high.abs() {
            break;
        }
        before = if inside { moved } else { 0.0 };
    }
    x
}
