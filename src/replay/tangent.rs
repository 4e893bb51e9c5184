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

use super::sensitivity::Map;
use super::taylor::{Branch, Turned};

/// Coefficients kept of a step.
const ORDER: usize = 26;

/// Changes that are followed: of the angle, of the velocity, and of the excitation's strength.
const COLUMNS: usize = 3;

/// Changes of the state (angle [rad], angular velocity [rad/s]) per change at the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tangent(pub(super) [[f64; 2]; COLUMNS]);

/// A step of smooth motion.
pub(super) struct Step<'a> {
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
    #[expect(clippy::cast_precision_loss, reason = "a small order")]
    pub(super) fn smooth(&mut self, of: &Step<'_>) {
        let square = of.step * of.step;
        let at = |series: &[f64], n: usize| series.get(n).copied().unwrap_or(0.0);
        let (mut sine, mut cosine) = ([0.0; ORDER], [0.0; ORDER]);
        (sine[0], cosine[0]) = (of.turned.sine, of.turned.cosine);
        for n in 1..ORDER {
            for j in 1..=n {
                let weighted = j as f64 * at(of.angle, j);
                sine[n] += weighted * cosine[n - j];
                cosine[n] -= weighted * sine[n - j];
            }
            sine[n] /= n as f64;
            cosine[n] /= n as f64;
        }
        let (mut stiffness, mut push) = ([0.0; ORDER], [0.0; ORDER]);
        stiffness[0] = of.branch.stiffness * square;
        for n in 0..ORDER {
            for j in 0..=n {
                let b = at(of.excitation, j) * square;
                stiffness[n] -= b * sine[n - j];
                push[n] += b * cosine[n - j];
            }
        }
        let damping = of.branch.damping * of.step;
        for (column, change) in self.0.iter_mut().enumerate() {
            let mut x = [0.0; ORDER];
            (x[0], x[1]) = (change[0], change[1] * of.step);
            for n in 0..ORDER - 2 {
                let mut force = -damping * (n + 1) as f64 * x[n + 1];
                for j in 0..=n {
                    force -= stiffness[j] * x[n - j];
                }
                if column == 2 {
                    force -= push[n];
                }
                x[n + 2] = force / ((n + 1) * (n + 2)) as f64;
            }
            let (mut angle, mut slope) = (0.0, 0.0);
            for n in (1..ORDER).rev() {
                angle = angle * of.part + x[n];
                slope = slope * of.part + n as f64 * x[n];
            }
            *change = [x[0] + angle * of.part, slope / of.step];
        }
    }

    /// Carries the changes through an event.
    pub(super) fn event(&mut self, map: &Map) {
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
