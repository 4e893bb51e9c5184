//! What a small change of the start, or of the excitation's strength, makes of the state.
//!
//! The variational equation is solved by the Taylor series of the motion itself, to the accuracy
//! of the motion; impacts carry a change along by their saltation matrix. For Newton's method on
//! periodic orbits and for Lyapunov exponents; [`super::sensitivity`] is the cheap relative that
//! travels with every verdict.
//!
//! # Source
//!
//! Leine and Nijmeijer, "Dynamics and Bifurcations of Non-Smooth Mechanical Systems", ch. 7.

use super::sensitivity::StateMap;
use super::taylor::{Branch, Turned};

/// Coefficients kept of a step.
const ORDER: usize = 26;

/// Changes that are followed: of the angle, of the velocity, and of the excitation's strength.
const COLUMNS: usize = 3;

/// Columns that are computed side by side, the last of them unused.
const LANES: usize = 4;

/// Size of a term, against the largest of its series, that no longer counts.
const SMALL: f64 = 1e-18;

/// Changes of the state (angle [rad], angular velocity [rad/s]) per change at the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tangent(pub(super) [[f64; 2]; COLUMNS]);

/// A step of smooth motion.
pub(super) struct TangentStep<'a> {
    pub(super) branch: &'a Branch,
    /// The angle in powers of the time over the step [rad].
    pub(super) angle: &'a [f64],
    /// The same of b [rad/s²].
    pub(super) excitation: &'a [f64],
    pub(super) turned: Turned,
    /// Length [s].
    pub(super) step: f64,
    /// How much of it was taken.
    pub(super) part: f64,
}

impl Tangent {
    /// No change but that at the start itself.
    pub(super) const START: Self = Self([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]);

    /// Carries the changes over a step of smooth motion.
    ///
    /// With u'' = −p − γ u' − k u − b cos u, a change δ obeys δ'' = −γ δ' − (k − b sin u) δ, and
    /// that by the strength of b has −b cos u on top.
    ///
    /// The series end where three terms after one another no longer count.
    pub(super) fn smooth(&mut self, of: &TangentStep<'_>) {
        let square = of.step * of.step;
        let damping = of.branch.damping * of.step;
        let mut slope = [0.0; ORDER];
        for (n, (slope, angle)) in slope.iter_mut().zip(of.angle).enumerate() {
            *slope = n as f64 * angle;
        }
        let mut excitation = [0.0; ORDER];
        for (scaled, b) in excitation.iter_mut().zip(of.excitation) {
            *scaled = b * square;
        }
        let slope = &slope[1..of.angle.len().min(ORDER)];
        let excitation = &excitation[..of.excitation.len().min(ORDER)];
        // What is multiplied backwards lies in reverse: its n-th term at ORDER − 1 − n.
        let mut turned = [[0.0; 2]; ORDER];
        let mut stiffness = [0.0; ORDER];
        let mut changes = [[0.0; LANES]; ORDER];
        turned[ORDER - 1] = [of.turned.cosine, -of.turned.sine];
        for (column, change) in self.0.iter().enumerate() {
            changes[ORDER - 1][column] = change[0];
            changes[ORDER - 2][column] = change[1] * of.step;
        }
        let mut size = [0.0; LANES];
        let mut small = 0;
        let mut count = 2;
        while count < ORDER && small < 3 {
            let n = count - 2;
            let last = ORDER - 1 - n;
            if n > 0 {
                let [sine, cosine] = product(slope, &turned[last + 1..]);
                turned[last] = [cosine / n as f64, -sine / n as f64];
            }
            let [push, stiff] = product(excitation, &turned[last..]);
            stiffness[n] = stiff;
            if n == 0 {
                stiffness[0] += of.branch.stiffness * square;
            }
            let mut force = product(&stiffness[..=n], &changes[last..]);
            force[2] += push;
            let [before, next] = [last - 1, last - 2];
            let mut counts = false;
            for (lane, force) in force.into_iter().enumerate() {
                let drag = damping * (n + 1) as f64 * changes[before][lane];
                let term = -(force + drag) / ((n + 1) * (n + 2)) as f64;
                changes[next][lane] = term;
                size[lane] = f64::max(size[lane], changes[last][lane].abs());
                counts |= term.abs() > SMALL * size[lane];
            }
            small = if counts { 0 } else { small + 1 };
            count += 1;
        }
        let (mut angle, mut slope) = ([0.0; LANES], [0.0; LANES]);
        for (term, n) in changes[ORDER - count..ORDER - 1]
            .iter()
            .zip((1..count).rev())
        {
            for lane in 0..LANES {
                angle[lane] = angle[lane] * of.part + term[lane];
                slope[lane] = slope[lane] * of.part + n as f64 * term[lane];
            }
        }
        for (column, change) in self.0.iter_mut().enumerate() {
            *change = [
                changes[ORDER - 1][column] + angle[column] * of.part,
                slope[column] / of.step,
            ];
        }
    }

    /// Carries the changes through an event.
    pub(super) fn event(&mut self, map: &StateMap) {
        for change in &mut self.0 {
            let [angle, velocity] = *change;
            let [[a, b], [c, d]] = map.0;
            *change = [a * angle + b * velocity, c * angle + d * velocity];
        }
    }

    /// Rest: whatever was different is so no longer.
    pub(super) fn rest(&mut self) {
        self.0 = [[0.0; 2]; COLUMNS];
    }
}

/// Returns the sum of a_j b_(n − j), with b in reverse from its n-th term on.
#[inline]
fn product<const WIDTH: usize>(a: &[f64], b: &[[f64; WIDTH]]) -> [f64; WIDTH] {
    let mut sum = [0.0; WIDTH];
    for (a, b) in a.iter().zip(b) {
        for (sum, b) in sum.iter_mut().zip(b) {
            *sum += a * b;
        }
    }
    sum
}
