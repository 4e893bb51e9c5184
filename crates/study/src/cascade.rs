//! Branches of periodic orbits: from the birth of an orbit through the doublings of its period.
//!
//! # Source
//!
//! Feigenbaum, J. Stat. Phys. 19 (1978) 25.

use super::orbit::{self, Bifurcation, BifurcationKind, ForcedLever, Orbit, STEP_MAX};
use latchgate_kernel::range::Range;
use latchgate_kernel::replay::State;
use serde::Serialize;

/// A branch: the birth of its orbit, and its doublings.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cascade {
    /// Birth of the first orbit.
    pub birth: Option<Bifurcation>,
    /// Doublings of the period, one after the other.
    pub doublings: Vec<Bifurcation>,
    /// Stable orbits on the way, by period and amplitude.
    #[serde(skip)]
    pub way: Vec<Orbit>,
}

/// Bounds of a branch that is followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BranchBounds {
    /// Amplitudes [g].
    pub amplitudes_g: Range,
    /// Largest number of doublings.
    pub levels: u32,
    /// Largest work [periods computed].
    pub work: u32,
}

impl BranchBounds {
    /// Returns bounds on the doublings alone: `levels` of them.
    pub fn all(levels: u32) -> Self {
        Self {
            amplitudes_g: Range::new(0.0, f64::INFINITY),
            levels,
            work: u32::MAX,
        }
    }
}

impl Cascade {
    /// Returns the bifurcations of the branch, its birth first.
    pub fn bifurcations(&self) -> impl Iterator<Item = &Bifurcation> {
        self.birth.iter().chain(&self.doublings)
    }

    /// Returns the ratios of successive distances, which tend to Feigenbaum's 4.6692.
    pub fn ratios(&self) -> Vec<f64> {
        let amplitudes_g: Vec<f64> = self
            .doublings
            .iter()
            .map(|doubling| doubling.orbit.amplitude_g)
            .collect();
        amplitudes_g
            .windows(3)
            .map(|three| (three[1] - three[0]) / (three[2] - three[1]))
            .collect()
    }

    /// Returns the amplitude to which the doublings tend [g], by Feigenbaum's ratio.
    pub fn accumulation_g(&self) -> Option<f64> {
        /// Feigenbaum's δ.
        const RATIO: f64 = 4.669_201_609_102_99;
        let [.., before, last] = self.doublings.as_slice() else {
            return None;
        };
        let gap = last.orbit.amplitude_g - before.orbit.amplitude_g;
        Some(last.orbit.amplitude_g + gap / (RATIO - 1.0))
    }

    /// Returns true if an orbit of `period` periods through `state` lies on the way.
    pub fn contains(
        &self,
        forced: &ForcedLever,
        amplitude_g: f64,
        period: u32,
        state: State,
    ) -> bool {
        self.way.windows(2).any(|two| {
            let (low, high) = (&two[0], &two[1]);
            if low.period != period
                || high.period != period
                || !(low.amplitude_g..=high.amplitude_g).contains(&amplitude_g)
            {
                return false;
            }
            let part =
                (amplitude_g - low.amplitude_g) / (high.amplitude_g - low.amplitude_g).max(1e-300);
            let on = |a: f64, b: f64| a + part * (b - a);
            low.points
                .iter()
                .zip(&high.points)
                .any(|(a, b)| forced.distance(combined(*a, *b, on), state) <= 0.5 * STEP_MAX)
        })
    }
}

/// Combines angle with angle and velocity with velocity.
fn combined(a: State, b: State, combine: impl Fn(f64, f64) -> f64) -> State {
    State::new(
        combine(a.angle_rad, b.angle_rad),
        combine(a.velocity_rad_s, b.velocity_rad_s),
    )
}

/// Follows a stable orbit to its birth, at smaller amplitudes, and through doublings at larger ones. `pace` [g] is the first step upward.
pub fn follow(forced: &ForcedLever, orbit: &Orbit, pace: f64, reach: &BranchBounds) -> Cascade {
    let mut walk = BranchWalk {
        forced,
        reach: *reach,
        spent: 0,
        way: Vec::new(),
    };
    let birth = walk.birth(orbit);
    let mut doublings: Vec<Bifurcation> = Vec::new();
    let mut current = orbit.clone();
    let mut pace = pace;
    for _ in 0..reach.levels {
        let Some(doubling) = walk.doubling(&current, pace) else {
            break;
        };
        let gap = doublings
            .last()
            .map_or(0.1 * doubling.orbit.amplitude_g, |before| {
                doubling.orbit.amplitude_g - before.orbit.amplitude_g
            });
        let next = walk.doubled(&doubling, gap);
        doublings.push(doubling);
        let Some(next) = next else {
            break;
        };
        pace = 0.25 * (next.amplitude_g - doublings[doublings.len() - 1].orbit.amplitude_g);
        current = next;
    }
    let mut way = walk.way;
    way.sort_by(|a, b| {
        a.period
            .cmp(&b.period)
            .then(a.amplitude_g.total_cmp(&b.amplitude_g))
    });
    Cascade {
        birth,
        doublings,
        way,
    }
}

/// Largest number of steps of Newton's method along a branch, where the guess is near.
const STEPS_MAX: u32 = 12;

/// Growth of a step of the amplitude after one that succeeded.
const GROWTH: f64 = 1.5;

/// Least step of the amplitude, relative to the amplitude.
const PACE_MIN: f64 = 1e-6;

struct BranchWalk<'a> {
    forced: &'a ForcedLever,
    reach: BranchBounds,
    spent: u32,
    way: Vec<Orbit>,
}

impl BranchWalk<'_> {
    /// Finds the orbit at `amplitude_g` [g] near `guess` that continues `before`.
    fn next(&mut self, before: &Orbit, amplitude_g: f64, guess: State) -> Option<Orbit> {
        let period = before.period;
        let spent = &mut self.spent;
        orbit::find_within(self.forced, amplitude_g, period, guess, STEPS_MAX, spent)
            .filter(|next| next.period == period)
            .filter(|next| self.forced.distance(next.points[0], before.points[0]) <= STEP_MAX)
    }

    /// Finds a bifurcation near `orbit`.
    fn locate(
        &mut self,
        kind: BifurcationKind,
        period: u32,
        guess: State,
        amplitude_g: f64,
    ) -> Option<Bifurcation> {
        if self.spent >= self.reach.work {
            return None;
        }
        let spent = &mut self.spent;
        orbit::locate(self.forced, kind, period, guess, amplitude_g, spent)
    }

    /// Follows `orbit` to larger amplitudes until a multiplier passes −1.
    fn doubling(&mut self, orbit: &Orbit, longest: f64) -> Option<Bifurcation> {
        let kind = BifurcationKind::PeriodDoubling;
        let mut current = orbit.clone();
        let mut pace = longest;
        self.way.push(current.clone());
        while current.amplitude_g <= self.reach.amplitudes_g.high && self.spent < self.reach.work {
            match self.next(&current, current.amplitude_g + pace, current.points[0]) {
                Some(next) if next.condition(kind) > 0.0 => {
                    self.way.push(next.clone());
                    current = next;
                    pace = (0.05 * current.amplitude_g).max(longest).min(GROWTH * pace);
                }
                Some(next) => {
                    // The doubling lies between the two orbits; the nearer one is the better guess.
                    let near = if next.condition(kind).abs() < current.condition(kind) {
                        next
                    } else {
                        current
                    };
                    let bifurcation =
                        self.locate(kind, near.period, near.points[0], near.amplitude_g)?;
                    self.way.push(bifurcation.orbit.clone());
                    return Some(bifurcation);
                }
                None => {
                    pace *= 0.5;
                    if pace < PACE_MIN * current.amplitude_g {
                        return None;
                    }
                }
            }
        }
        None
    }

    /// Finds a stable orbit of twice the period beyond a doubling; `gap` is the distance to the
    /// doubling before [g].
    fn doubled(&mut self, doubling: &Bifurcation, gap: f64) -> Option<Orbit> {
        /// Number of amplitudes tried.
        const TRIES: u32 = 8;
        /// Periods of the old orbit in which a nudged state settles.
        const SETTLING: u32 = 60;
        let old = &doubling.orbit;
        let mut beyond = 0.05 * gap;
        for _ in 0..TRIES {
            let amplitude = old.amplitude_g + beyond;
            let mut nudged = old.points[0];
            nudged.angle_rad += 1e-3 * nudged.angle_rad.abs().max(1e-3);
            if self.spent >= self.reach.work {
                return None;
            }
            // A period without derivatives costs about a fifth of one with them.
            self.spent = self.spent.saturating_add(SETTLING / 5 * old.period);
            let settled =
                orbit::settle(self.forced, amplitude, Some(nudged), SETTLING * old.period)
                    .ok()??;
            let period = 2 * old.period;
            let spent = &mut self.spent;
            let orbit =
                orbit::find_within(self.forced, amplitude, period, settled, STEPS_MAX, spent);
            if let Some(orbit) = orbit
                && orbit.period == 2 * old.period
                && orbit.spectral_radius() < 1.0
            {
                return Some(orbit);
            }
            beyond *= 0.5;
        }
        None
    }

    /// Follows `orbit` to smaller amplitudes until it ends, and finds the saddle-node there, or the doubling
    /// that it comes from.
    fn birth(&mut self, orbit: &Orbit) -> Option<Bifurcation> {
        let kind = BifurcationKind::SaddleNode;
        let mut current = orbit.clone();
        let mut before: Option<Orbit> = None;
        let mut pace = 0.05 * orbit.amplitude_g;
        // A motion that shrinks to nothing with the excitation has no birth.
        let least = self.reach.amplitudes_g.low.max(1e-3 * orbit.amplitude_g);
        let mut is_fold_tried = false;
        while self.spent < self.reach.work {
            if current.amplitude_g < least {
                return None;
            }
            if pace >= current.amplitude_g {
                pace *= 0.5;
            }
            if let Some(before) = &before {
                // Near a fold the square of its condition is linear in the amplitude, so two orbits predict it.
                let (condition, condition_before) =
                    (current.condition(kind), before.condition(kind));
                let fall = (condition_before * condition_before - condition * condition)
                    / (before.amplitude_g - current.amplitude_g);
                let fold = current.amplitude_g - condition * condition / fall;
                // The same two orbits predict the same fold, so it is tried once.
                if fall > 0.0 && current.amplitude_g - fold < pace && !is_fold_tried {
                    is_fold_tried = true;
                    let bifurcation = self
                        .locate(kind, current.period, current.points[0], fold)
                        .filter(|bifurcation| {
                            let amplitude = bifurcation.orbit.amplitude_g;
                            (fold - pace..=current.amplitude_g).contains(&amplitude)
                                && self
                                    .forced
                                    .distance(bifurcation.orbit.points[0], current.points[0])
                                    <= STEP_MAX
                        });
                    if let Some(bifurcation) = bifurcation {
                        self.way.push(bifurcation.orbit.clone());
                        return Some(bifurcation);
                    }
                }
            }
            // The guess extrapolates linearly from the last two orbits.
            let guess = before.as_ref().map_or(current.points[0], |before| {
                let part = pace / (before.amplitude_g - current.amplitude_g);
                let on = |a: f64, b: f64| a + part * (a - b);
                combined(current.points[0], before.points[0], on)
            });
            let next = self
                .next(&current, current.amplitude_g - pace, guess)
                .filter(|next| next.condition(kind) > 0.0);
            match next {
                Some(next) => {
                    self.way.push(next.clone());
                    before = Some(std::mem::replace(&mut current, next));
                    is_fold_tried = false;
                    pace = (0.05 * current.amplitude_g).min(GROWTH * pace);
                }
                None => {
                    pace *= 0.5;
                    if pace < PACE_MIN * orbit.amplitude_g {
                        break;
                    }
                }
            }
        }
        self.parting(&current).or_else(|| {
            self.locate(kind, current.period, current.points[0], current.amplitude_g)
                .filter(|bifurcation| near(bifurcation, &current))
        })
    }

    /// Finds the doubling at which `orbit` parts from an orbit of half its period.
    fn parting(&mut self, orbit: &Orbit) -> Option<Bifurcation> {
        if !orbit.period.is_multiple_of(2) {
            return None;
        }
        let (state, half) = (orbit.points[0], orbit.points[orbit.period as usize / 2]);
        if self.forced.distance(state, half) > 0.5 * STEP_MAX {
            return None;
        }
        let middle = combined(state, half, f64::midpoint);
        self.locate(
            BifurcationKind::PeriodDoubling,
            orbit.period / 2,
            middle,
            orbit.amplitude_g,
        )
        .filter(|bifurcation| near(bifurcation, orbit))
        .filter(|bifurcation| self.forced.distance(bifurcation.orbit.points[0], state) <= STEP_MAX)
    }
}

fn near(bifurcation: &Bifurcation, orbit: &Orbit) -> bool {
    (bifurcation.orbit.amplitude_g - orbit.amplitude_g).abs() < 0.01 * orbit.amplitude_g
}
