//! Many levers on one recording, side by side.
//!
//! Lanes in plain flight, which is most of the work, take their Taylor step together; a lane
//! that meets an event, turns near its peak or needs more orders takes that one sample by the
//! scalar kernel. Whether it does depends on the lane alone, so a member's result is the same
//! whatever its neighbours and however many threads share the work. Against the scalar kernel a
//! result may differ by rounding and truncation, and by what impacts make of them: by no more
//! than the error that the scalar run states.

use super::kernel::Kernel;
use super::pressed_samples;
use super::tally::Tally;
use super::{MOVING_ENERGY_J, energy_of};
use crate::conditioning::Signal;
use crate::error::{Error, ErrorKind};
use crate::model::lever::Lever;
use crate::model::stop::{Stop, StopModel};
use crate::numerics::lanes::{LANES, Lanes};
use crate::units::OpensWhen;
use std::sync::atomic::{AtomicUsize, Ordering};

/// One lever of a batch and how it sees the recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Member {
    /// The lever.
    pub lever: Lever,
    /// Its stop.
    pub stop: Stop,
    /// Factor on the recorded acceleration [-].
    pub scale: f64,
    /// Added to the scaled acceleration, in the recording's polarity [m/s²].
    pub bias_m_s2: f64,
}

/// What one lever of a batch did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MemberPeak {
    /// Largest angle in the window [rad]; NaN if the lever could not be followed.
    pub peak_angle_rad: f64,
    /// Largest angle after the window's end [rad]; `None` if at rest there.
    pub coast_peak_angle_rad: Option<f64>,
    /// Samples that the lever took by the scalar kernel.
    pub scalar_samples: u32,
}

/// What a batch is asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BatchOptions {
    /// Stop model.
    pub stop: StopModel,
    /// Sign of the recorded acceleration that opens.
    pub opens_when: OpensWhen,
    /// Initial angle [rad] and angular velocity [rad/s]; `None` for rest on the stop.
    pub initial: Option<(f64, f64)>,
    /// First and last sample of the judged window; `None` for all.
    pub window: Option<(usize, usize)>,
    /// Follow the lever beyond the window's end.
    pub coast: bool,
    /// Threads.
    pub threads: usize,
}

/// Members that one thread takes at a time.
const CHUNK: usize = 32 * LANES;

/// Replays `count` members, of which `member` gives each, and returns their peaks in order.
///
/// # Errors
///
/// [`ErrorKind::TooShort`] for a signal of fewer than two samples.
pub fn peaks(
    signal: &Signal,
    count: usize,
    member: &(impl Fn(usize) -> Member + Sync),
    options: &BatchOptions,
) -> Result<Vec<MemberPeak>, Error> {
    if signal.samples.len() < 2 {
        return Err(ErrorKind::TooShort {
            what: "a replay",
            needed: 2,
            found: signal.samples.len(),
        }
        .into());
    }
    let arch = pulp::Arch::new();
    let next = AtomicUsize::new(0);
    let take = || {
        let mut done: Vec<(usize, Vec<MemberPeak>)> = Vec::new();
        loop {
            let first = next.fetch_add(CHUNK, Ordering::Relaxed);
            if first >= count {
                return done;
            }
            let last = (first + CHUNK).min(count);
            let mut results = Vec::with_capacity(last - first);
            for start in (first..last).step_by(LANES) {
                let members: [Member; LANES] =
                    std::array::from_fn(|lane| member((start + lane).min(last - 1)));
                let group = arch.dispatch(Wide(&members, signal, options));
                results.extend_from_slice(&group[..LANES.min(last - start)]);
            }
            done.push((first, results));
        }
    };
    let threads = options.threads.clamp(1, count.div_ceil(CHUNK).max(1));
    let mut chunks = std::thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|_| scope.spawn(take)).collect();
        let mut chunks = take();
        for other in others {
            match other.join() {
                Ok(more) => chunks.extend(more),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        chunks
    });
    chunks.sort_by_key(|(first, _)| *first);
    Ok(chunks
        .into_iter()
        .flat_map(|(_, results)| results)
        .collect())
}

/// A group's run, compiled once for each width of vectors and chosen by the machine.
struct Wide<'a>(&'a [Member; LANES], &'a Signal, &'a BatchOptions);

impl pulp::WithSimd for Wide<'_> {
    type Output = [MemberPeak; LANES];

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _simd: S) -> Self::Output {
        Group::new(self.0, self.1, self.2).run()
    }
}

/// Relative truncation that a lane's step lets pass, on ten coefficients.
const TRUNCATION: f64 = 1e-15;

/// Samples after which sine and cosine are computed afresh.
const FRESH_EVERY: usize = 64;

/// Largest turn within a sample for which sine and cosine are turned on [rad].
const TURN_MAX: f64 = 0.06;

/// Levers that advance together.
struct Group<'a> {
    signal: &'a Signal,
    options: &'a BatchOptions,
    kernels: [Kernel; LANES],
    /// Base acceleration to the model's: scale and bias, with the polarity's sign.
    scale: [f64; LANES],
    bias: [f64; LANES],
    constants: Constants,
    /// Lanes in plain flight, whose state is in `state`; the others' is in their kernel.
    flying: [bool; LANES],
    state: State,
    /// Largest angle so far, of judged samples.
    best: Lanes,
    scalar_samples: [u32; LANES],
    members: [Member; LANES],
}

/// Coefficients of the lanes' right-hand sides in scaled time.
#[derive(Clone, Copy)]
struct Constants {
    pressing: Lanes,
    stiffness: Lanes,
    damping: Lanes,
    /// Recorded acceleration to h² b: factor and offset.
    gain: Lanes,
    offset: Lanes,
}

/// Angle, derivative by the sample interval, sine and cosine.
#[derive(Clone, Copy)]
struct State {
    angle: Lanes,
    slope: Lanes,
    sine: Lanes,
    cosine: Lanes,
}

/// A step of all lanes and what tells whether it stands.
struct Step {
    state: State,
    lowest: Lanes,
    highest: Lanes,
    slope_start: Lanes,
    slope_curved: Lanes,
    tail: Lanes,
    size: Lanes,
    turn: Lanes,
}

impl<'a> Group<'a> {
    #[inline(always)]
    fn new(members: &[Member; LANES], signal: &'a Signal, options: &'a BatchOptions) -> Self {
        let length = signal.rate.interval().seconds();
        let sign = options.opens_when.sign();
        let kernels: [Kernel; LANES] = std::array::from_fn(|lane| {
            let member = &members[lane];
            let tally = Tally::peak_only();
            Kernel::of_parts(
                &member.lever,
                &member.stop,
                options.stop,
                options.initial,
                None,
                tally,
            )
            .without_error_bound()
        });
        let lanes = |value: &dyn Fn(usize) -> f64| Lanes(std::array::from_fn(value));
        let free = |lane: usize| *kernels[lane].free_branch();
        let square = length * length;
        let constants = Constants {
            pressing: lanes(&|lane| free(lane).pressing * square),
            stiffness: lanes(&|lane| free(lane).stiffness * square),
            damping: lanes(&|lane| free(lane).damping * length),
            gain: lanes(&|lane| kernels[lane].gain() * sign * members[lane].scale * square),
            offset: lanes(&|lane| kernels[lane].gain() * sign * members[lane].bias_m_s2 * square),
        };
        let zero = Lanes::splat(0.0);
        Self {
            signal,
            options,
            scale: std::array::from_fn(|lane| sign * members[lane].scale),
            bias: std::array::from_fn(|lane| sign * members[lane].bias_m_s2),
            kernels,
            constants,
            flying: [false; LANES],
            state: State {
                angle: zero,
                slope: zero,
                sine: zero,
                cosine: Lanes::splat(1.0),
            },
            best: Lanes::splat(f64::INFINITY),
            scalar_samples: [0; LANES],
            members: *members,
        }
    }

    #[inline(always)]
    fn run(mut self) -> [MemberPeak; LANES] {
        let count = self.signal.samples.len();
        let (first, last) = self.options.window.unwrap_or((0, count - 1));
        let (first, last) = (first.min(count - 1), last.min(count - 1));
        for lane in 0..LANES {
            self.load(lane);
        }
        let mut index = 0;
        while index < last {
            if index == first {
                self.open_window();
            }
            if !self.flying.contains(&true) && self.kernels.iter().all(Kernel::dwells) {
                let stop_at = if index < first { first } else { last };
                let moved = index + self.pressed(&self.signal.samples[index..=stop_at]);
                if moved > index {
                    index = moved;
                    continue;
                }
            }
            self.sample(index);
            index += 1;
        }
        if first >= last {
            self.open_window();
        }
        std::array::from_fn(|lane| self.finish(lane, last))
    }

    /// Advances every lane over the sample interval from `index`.
    #[inline(always)]
    fn sample(&mut self, index: usize) {
        let (from, to) = (self.signal.samples[index], self.signal.samples[index + 1]);
        let mut stands = [false; LANES];
        if self.flying.contains(&true) {
            if index.is_multiple_of(FRESH_EVERY) {
                self.refresh();
            }
            let step = self.step(from, to);
            for (lane, stands) in stands.iter_mut().enumerate() {
                let turns = step.slope_start.0[lane].abs() <= 1.01 * step.slope_curved.0[lane];
                *stands = self.flying[lane]
                    && step.lowest.0[lane] > 0.0
                    && step.tail.0[lane] <= TRUNCATION * step.size.0[lane]
                    && step.turn.0[lane].abs() <= TURN_MAX
                    && !(turns && step.highest.0[lane] > self.best.0[lane]);
            }
            let keep = |new: Lanes, old: Lanes| {
                Lanes(std::array::from_fn(|lane| {
                    if stands[lane] {
                        new.0[lane]
                    } else {
                        old.0[lane]
                    }
                }))
            };
            self.state = State {
                angle: keep(step.state.angle, self.state.angle),
                slope: keep(step.state.slope, self.state.slope),
                sine: keep(step.state.sine, self.state.sine),
                cosine: keep(step.state.cosine, self.state.cosine),
            };
        }
        for (lane, stands) in stands.iter().enumerate() {
            if !stands {
                self.by_kernel(lane, index, from, to);
            }
        }
    }

    /// One lane's sample by the scalar kernel.
    #[inline(never)]
    fn by_kernel(&mut self, lane: usize, index: usize, from: f64, to: f64) {
        self.store(lane);
        let seen = |a: f64| self.scale[lane] * a + self.bias[lane];
        let (from, to) = (seen(from), seen(to));
        let kernel = &mut self.kernels[lane];
        let lift_off = kernel.lift_off_acceleration();
        if kernel.stuck || (kernel.dwells() && from > lift_off && to > lift_off) {
            return;
        }
        kernel.advance(
            self.signal.time_s(index),
            self.signal.rate.interval().seconds(),
            from,
            to,
        );
        self.scalar_samples[lane] += 1;
        if kernel.tally.judging {
            self.best.0[lane] = kernel.tally.peak.angle;
        }
        self.load(lane);
    }

    /// Takes a lane that its kernel left in free flight into the vector.
    #[inline(always)]
    fn load(&mut self, lane: usize) {
        let kernel = &self.kernels[lane];
        self.flying[lane] = kernel.flies_free();
        if self.flying[lane] {
            let (angle, velocity) = kernel.state();
            let (sine, cosine) = libm::sincos(angle);
            self.state.angle.0[lane] = angle;
            self.state.slope.0[lane] = velocity * self.signal.rate.interval().seconds();
            self.state.sine.0[lane] = sine;
            self.state.cosine.0[lane] = cosine;
        }
    }

    /// Gives a flying lane's state back to its kernel.
    #[inline(always)]
    fn store(&mut self, lane: usize) {
        if self.flying[lane] {
            let velocity = self.state.slope.0[lane] * self.signal.rate.hertz();
            self.kernels[lane].fly_on(self.state.angle.0[lane], velocity);
        }
    }

    fn refresh(&mut self) {
        for lane in 0..LANES {
            let (sine, cosine) = libm::sincos(self.state.angle.0[lane]);
            self.state.sine.0[lane] = sine;
            self.state.cosine.0[lane] = cosine;
        }
    }

    /// Sample intervals from the first on that press every lane onto its stop.
    fn pressed(&self, samples: &[f64]) -> usize {
        (0..LANES)
            .map(|lane| {
                let limit = (self.kernels[lane].lift_off_acceleration() - self.bias[lane])
                    / self.scale[lane].abs();
                if limit.is_finite() {
                    pressed_samples(samples, self.scale[lane].signum(), limit)
                } else {
                    0
                }
            })
            .min()
            .unwrap_or(0)
    }

    fn open_window(&mut self) {
        for lane in 0..LANES {
            self.store(lane);
            let angle = self.kernels[lane].state().0;
            self.kernels[lane].tally.open_window(angle, 0.0, 0.0);
            self.best.0[lane] = angle;
        }
    }

    fn finish(&mut self, lane: usize, last: usize) -> MemberPeak {
        self.store(lane);
        let end = self.signal.time_s(last);
        let kernel = &mut self.kernels[lane];
        let (angle, velocity) = kernel.state();
        kernel.tally.close_window(angle, end, 0.0);
        let peak = if kernel.stuck {
            f64::NAN
        } else {
            kernel.tally.peak.angle
        };
        let member = &self.members[lane];
        let energy = energy_of(
            &member.lever,
            &member.stop,
            self.options.stop,
            angle,
            velocity,
        );
        let coast = (self.options.coast && !kernel.stuck && energy > MOVING_ENERGY_J).then(|| {
            kernel
                .clone()
                .coast(end)
                .map_or(f64::NAN, |peak| peak.angle)
        });
        MemberPeak {
            peak_angle_rad: peak,
            coast_peak_angle_rad: coast,
            scalar_samples: self.scalar_samples[lane],
        }
    }

    /// One Taylor step of all lanes over a whole sample; the recurrence of the scalar series.
    #[expect(unused_assignments, reason = "the last order's sine has no successor")]
    #[inline(always)]
    fn step(&self, from: f64, to: f64) -> Step {
        let Constants {
            pressing,
            stiffness,
            damping,
            gain,
            offset,
        } = self.constants;
        let b0 = gain * from + offset;
        let b1 = gain * (to - from);
        let State {
            angle,
            slope,
            sine,
            cosine,
        } = self.state;
        let zero = Lanes::splat(0.0);
        let mut x = [zero; 10];
        let mut w = [zero; 10];
        let mut s = [zero; 8];
        let mut c = [zero; 8];
        (x[0], x[1], w[1]) = (angle, slope, slope);
        (s[0], c[0]) = (sine, cosine);
        w[2] = -(pressing + stiffness * angle + damping * slope + b0 * cosine);
        x[2] = w[2] * 0.5;
        macro_rules! order {
            ($n:literal: $($j:literal)*) => {
                let mut s_sum = zero;
                let mut c_sum = zero;
                $(
                    s_sum = s_sum + w[$j] * c[$n - $j];
                    c_sum = c_sum + w[$j] * s[$n - $j];
                )*
                s[$n] = s_sum * (1.0 / $n as f64);
                c[$n] = c_sum * (-1.0 / $n as f64);
                let force = stiffness * x[$n] + damping * w[$n + 1] + b1 * c[$n - 1] + b0 * c[$n];
                w[$n + 2] = force * (-1.0 / ($n + 1) as f64);
                x[$n + 2] = w[$n + 2] * (1.0 / ($n + 2) as f64);
            };
        }
        order!(1: 1);
        order!(2: 2 1);
        order!(3: 3 2 1);
        order!(4: 4 3 2 1);
        order!(5: 5 4 3 2 1);
        order!(6: 6 5 4 3 2 1);
        order!(7: 7 6 5 4 3 2 1);
        let bend = (x[9] + x[8]) + (x[7] + x[6]) + (x[5] + x[4]) + x[3] + x[2];
        let turned = (w[9] + w[8]) + (w[7] + w[6]) + (w[5] + w[4]) + w[3] + w[2];
        let tail = x[9].abs() + x[8].abs();
        let curved = tail
            + (x[7].abs() + x[6].abs())
            + (x[5].abs() + x[4].abs())
            + (x[3].abs() + x[2].abs());
        let slope_curved = (w[9].abs() + w[8].abs())
            + (w[7].abs() + w[6].abs())
            + (w[5].abs() + w[4].abs())
            + (w[3].abs() + w[2].abs());
        let turn = slope + bend;
        let (turn_sine, versine) = turned_by(turn);
        Step {
            state: State {
                angle: angle + turn,
                slope: slope + turned,
                sine: sine + (cosine * turn_sine - sine * versine),
                cosine: cosine - (sine * turn_sine + cosine * versine),
            },
            lowest: angle + slope.min(zero) - curved,
            highest: angle + slope.max(zero) + curved,
            slope_start: slope,
            slope_curved,
            tail,
            size: angle.abs() + slope.abs() + curved,
            turn,
        }
    }
}

/// Sine and versine (1 − cos) of a small angle.
#[inline(always)]
fn turned_by(angle: Lanes) -> (Lanes, Lanes) {
    let one = Lanes::splat(1.0);
    let square = angle * angle;
    let nested = |a: f64, b: f64, c: f64, d: f64| {
        one - square * a * (one - square * b * (one - square * c * (one - square * d)))
    };
    let sine = angle * nested(1.0 / 6.0, 1.0 / 20.0, 1.0 / 42.0, 1.0 / 72.0);
    let versine = square * 0.5 * nested(1.0 / 12.0, 1.0 / 30.0, 1.0 / 56.0, 1.0 / 90.0);
    (sine, versine)
}
