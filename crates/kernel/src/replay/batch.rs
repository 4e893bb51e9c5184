//! Many levers on one recording, side by side.
//!
//! Lanes in eventless flight, which is most of the work, take their Taylor step together; a lane
//! that meets an event, turns near its peak or needs more orders takes that one sample by the
//! scalar kernel. Whether it does depends on the lane alone, so a member's result is the same
//! whatever its neighbours, however many threads share the work and however wide the machine's
//! vectors are. Against the scalar kernel a result may differ by rounding and truncation, and by
//! what impacts make of them: each of the two is within the error that the scalar run states, so
//! that they differ by twice that at most, and mostly by a tenth of it.

#![expect(
    clippy::needless_range_loop,
    reason = "in code compiled for the machine's vectors adaptors such as zip stay calls"
)]

use super::contact_fast::FastContact;
use super::energy::{energy_of, impulse_ahead, stays_below};
use super::eventless_step::{Bounds, LaneState, Push, StepCoefficients, TURN_MAX, chosen};
use super::kernel::{CURVED_TRUNCATION, Coasting, Kernel, PEAK_TRUNCATION};
use super::recorder::Recorder;
use super::taylor::Turned;
use super::{MOVING_ENERGY_J, RunOptions, State, Within, check_finite, check_initial, run_within};
use crate::error::Error;
use crate::model::Design;
use crate::model::catch::Catch;
use crate::model::lever::Lever;
use crate::model::stop::{Stop, StopModel};
use crate::numerics::lanes::{LANES_MAX, Lanes, Mask, Real, lanes};
use crate::parallel::Control;
use crate::signal::{CURVED, Mix, Piece, Pieces, Projection, Reading, STRAIGHT};
use crate::units::OpensWhen;
use std::ops::Range;

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
    /// How it sees a second sensor's acceleration.
    pub second: SensorView,
    /// An inertia catch beside the lever.
    pub catch: Option<Catch>,
}

/// How a lever sees the acceleration that a second sensor recorded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorView {
    /// Factor on it [-].
    pub scale: f64,
    /// Added to the scaled acceleration [m/s²].
    pub bias_m_s2: f64,
}

impl Default for SensorView {
    /// As it was recorded.
    fn default() -> Self {
        Self {
            scale: 1.0,
            bias_m_s2: 0.0,
        }
    }
}

/// What one lever of a batch did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MemberPeak {
    /// Largest angle in the window [rad]; NaN if the lever could not be followed.
    pub peak_angle_rad: f64,
    /// Largest angle after the window's end [rad]; `None` if at rest there, or if the peak is
    /// certainly larger.
    pub coast_peak_angle_rad: Option<f64>,
    /// When the angle first exceeds the threshold in the window [s], between samples by a straight
    /// line; `None` if it does not.
    pub first_crossing_s: Option<f64>,
    /// Samples that the lever took by the scalar kernel.
    pub scalar_samples: u32,
    /// Samples that were left out at the end, since nothing in them could raise the peak.
    pub spared_samples: u32,
    /// What it cost, as limits count it: four samples side by side count as one.
    pub spent: u64,
}

impl MemberPeak {
    /// Returns the largest angle in the window or in the coast after it [rad]; NaN if the lever
    /// could not be followed.
    pub fn highest_rad(&self) -> f64 {
        let (peak, coast) = (self.peak_angle_rad, self.coast_peak_angle_rad);
        match coast {
            Some(coast) if coast.is_nan() || coast > peak => coast,
            _ => peak,
        }
    }
}

/// The angles between which a peak is asked for: of a lever that certainly stays below the lower one,
/// or has gone beyond the upper one, the highest angle until that was known will do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AskedPeaks {
    /// The lower one [rad].
    pub from_rad: f64,
    /// The upper one [rad].
    pub to_rad: f64,
}

impl AskedPeaks {
    /// Every peak.
    pub const ALL: Self = Self {
        from_rad: f64::NEG_INFINITY,
        to_rad: f64::INFINITY,
    };
}

/// What a batch is asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BatchOptions {
    /// Stop model.
    pub stop: StopModel,
    /// Sign of the recorded acceleration that opens.
    pub opens_when: OpensWhen,
    /// Initial state; `None` for rest on the stop.
    pub initial: Option<State>,
    /// What two sensors' accelerations are along and across the way of the centre of mass.
    pub projection: Projection,
    /// First and last sample of the judged window; `None` for all.
    pub window: Option<(usize, usize)>,
    /// Follow the lever beyond the window's end.
    pub coast: bool,
    /// The peaks that are asked for.
    pub asked: AskedPeaks,
    /// The angle whose first crossing is told [rad]; infinite for none.
    pub threshold_rad: f64,
    /// Threads.
    pub threads: usize,
}

/// Gives a member by its number; behind a pointer, so that the vectors' code is compiled once for all.
pub type MemberOf<'a> = &'a (dyn Fn(usize) -> Member + Sync);

/// Members that one thread takes at a time.
const CHUNK: usize = 2 * LANES_MAX;

/// Replays `count` members, of which `member` gives each, and returns their peaks in order.
///
/// # Errors
///
/// [`Error::TooShort`] for a signal of fewer than two samples, [`Error::NonFinite`] for
/// one with a sample that is not finite, [`Error::OutOfRange`] for an initial state that the
/// stop does not admit.
pub fn peaks<'a>(
    reading: impl Into<Reading<'a>>,
    count: usize,
    member: MemberOf<'_>,
    options: &BatchOptions,
) -> Result<Vec<MemberPeak>, Error> {
    peaks_within(reading, count, member, options, &Within::UNBOUNDED)
}

/// As [`peaks`], of members each of which may take so much, and may be stopped.
///
/// # Errors
///
/// As [`peaks`]; [`Error::Stopped`].
pub fn peaks_within<'a>(
    reading: impl Into<Reading<'a>>,
    count: usize,
    member: MemberOf<'_>,
    options: &BatchOptions,
    within: &Within<'_>,
) -> Result<Vec<MemberPeak>, Error> {
    peaks_by(&reading.into(), count, member, (options, within), true)
}

/// As [`peaks`] with the same bits, without the machine's vectors: slower, to compare with.
///
/// # Errors
///
/// As [`peaks`].
pub fn peaks_without_vectors<'a>(
    reading: impl Into<Reading<'a>>,
    count: usize,
    member: MemberOf<'_>,
    options: &BatchOptions,
) -> Result<Vec<MemberPeak>, Error> {
    let within = &Within::UNBOUNDED;
    peaks_by(&reading.into(), count, member, (options, within), false)
}

fn peaks_by(
    reading: &Reading<'_>,
    count: usize,
    member: MemberOf<'_>,
    (options, within): (&BatchOptions, &Within<'_>),
    vectors: bool,
) -> Result<Vec<MemberPeak>, Error> {
    check(reading, options)?;
    if let Some(angles) = catch_angles(count, member) {
        return beside_catches(reading, angles, member, (options, within), vectors);
    }
    plain_peaks(reading, count, member, (options, within), vectors)
}

/// Returns the peaks of members whose catches are left out.
fn plain_peaks(
    reading: &Reading<'_>,
    count: usize,
    member: MemberOf<'_>,
    (options, within): (&BatchOptions, &Within<'_>),
    vectors: bool,
) -> Result<Vec<MemberPeak>, Error> {
    if reading.is_straight() {
        let pieces = reading.pieces::<STRAIGHT>();
        shared_out(pieces, count, member, (options, within), vectors)
    } else {
        let pieces = reading.pieces::<CURVED>();
        shared_out(pieces, count, member, (options, within), vectors)
    }
}

/// Returns the angle at which each member's catch blocks its lever [rad]; infinite of one without a catch,
/// and `None` if none has one.
fn catch_angles(count: usize, member: MemberOf<'_>) -> Option<Vec<f64>> {
    let angle = |index: usize| {
        let catch = member(index).catch.filter(|catch| !catch.never_moves());
        catch.map_or(f64::INFINITY, |catch| catch.lever_angle_rad)
    };
    let angles: Vec<f64> = (0..count).map(angle).collect();
    angles
        .iter()
        .any(|angle| angle.is_finite())
        .then_some(angles)
}

/// Returns the peaks of members beside catches. A lever that stays below the angle at which it is blocked
/// never meets its catch: only the others are replayed with it, one by one.
fn beside_catches(
    reading: &Reading<'_>,
    angles: Vec<f64>,
    member: MemberOf<'_>,
    (options, within): (&BatchOptions, &Within<'_>),
    vectors: bool,
) -> Result<Vec<MemberPeak>, Error> {
    /// Part of the angle that leaves room for what vectors round otherwise than the scalar kernel.
    const NEAR: f64 = 1.0 - 1e-9;
    let lowest_rad = angles.iter().copied().fold(f64::INFINITY, f64::min);
    let highest_rad = angles.iter().copied().fold(0.0, f64::max);
    let asked = AskedPeaks {
        from_rad: options.asked.from_rad.min(NEAR * lowest_rad),
        to_rad: options.asked.to_rad.max(highest_rad),
    };
    let plain = BatchOptions { asked, ..*options };
    let mut peaks = plain_peaks(reading, angles.len(), member, (&plain, within), vectors)?;
    // What lies before the window is not in the peak.
    let (judged_from, _) = options.window.unwrap_or((0, 0));
    let meets = |index: &usize| {
        let stays = judged_from == 0 && peaks[*index].highest_rad() < NEAR * angles[*index];
        angles[*index].is_finite() && !stays
    };
    let meeting: Vec<usize> = (0..angles.len()).filter(meets).collect();
    let control = Control::unwatched(options.threads);
    let replayed = control.try_map(&meeting, |index| {
        let mut peak = beside_catch(reading, &member(*index), options, within)?;
        peak.spent += peaks[*index].spent;
        Ok::<_, Error>(peak)
    })?;
    for (index, peak) in meeting.into_iter().zip(replayed) {
        peaks[index] = peak;
    }
    Ok(peaks)
}

/// Replays one member beside its catch by the scalar kernel. Of one of which nobody can tell whether lever
/// or catch came first the peak is unknown.
fn beside_catch(
    reading: &Reading<'_>,
    member: &Member,
    options: &BatchOptions,
    within: &Within<'_>,
) -> Result<MemberPeak, Error> {
    let mut design = Design {
        lever: member.lever,
        stop: member.stop,
        catch: member.catch,
        ..Design::reference()
    };
    design.criterion.threshold_rad = options.threshold_rad;
    let run_options = RunOptions {
        initial: options.initial,
        window: options.window,
        error_bound: false,
        peak_only: true,
        ..RunOptions::new(options.stop, options.opens_when)
    };
    let reading = reading.scaled(member.scale, member.bias_m_s2);
    let outcome = run_within(reading, &design, &run_options, within)?;
    let is_unknown = outcome.broke_down || outcome.catch.is_some_and(|catch| catch.tie_s.is_some());
    let run = outcome.run;
    let if_followed = |angle: f64| if is_unknown { f64::NAN } else { angle };
    Ok(MemberPeak {
        peak_angle_rad: if_followed(run.peak_angle_rad),
        coast_peak_angle_rad: run
            .coast_peak_angle_rad
            .filter(|_| options.coast)
            .map(if_followed),
        first_crossing_s: run.first_crossing_s,
        scalar_samples: u32::try_from(run.work.steps).unwrap_or(u32::MAX),
        spared_samples: 0,
        spent: outcome.spent,
    })
}

/// Shares the members out over the threads, a chunk at a time.
fn shared_out<const K: usize>(
    pieces: Pieces<'_, K>,
    count: usize,
    member: MemberOf<'_>,
    (options, within): (&BatchOptions, &Within<'_>),
    vectors: bool,
) -> Result<Vec<MemberPeak>, Error> {
    let (_, last) = judged(&pieces, options);
    let ahead = impulse_ahead(&pieces, last, ASKED_EVERY);
    let control = Control::unwatched(options.threads);
    let arch = pulp::Arch::new();
    let chunks = control.map(count.div_ceil(CHUNK), |index| {
        let first = index * CHUNK;
        let chunk = Chunk {
            members: first..(first + CHUNK).min(count),
            member,
            pieces,
            ahead: &ahead,
            options,
            within,
        };
        match (pieces.second().is_some(), vectors) {
            (true, true) => arch.dispatch(Across(chunk)),
            (true, false) => pulp::WithSimd::with_simd(Across(chunk), pulp::Scalar::new()),
            (false, true) => arch.dispatch(chunk),
            (false, false) => pulp::WithSimd::with_simd(chunk, pulp::Scalar::new()),
        }
    });
    within.control.check()?;
    Ok(chunks.into_iter().flatten().flatten().collect())
}

/// First and last sample that are judged.
fn judged<const K: usize>(pieces: &Pieces<'_, K>, options: &BatchOptions) -> (usize, usize) {
    let end = pieces.signal.samples.len() - 1;
    let (first, last) = options.window.unwrap_or((0, end));
    (first.min(end), last.min(end))
}

fn check(reading: &Reading<'_>, options: &BatchOptions) -> Result<(), Error> {
    let signal = reading.signal();
    if signal.samples.len() < 2 {
        return Err(Error::TooShort {
            what: "a replay",
            needed: 2,
            found: signal.samples.len(),
        });
    }
    check_initial(&RunOptions {
        initial: options.initial,
        ..RunOptions::new(options.stop, options.opens_when)
    })?;
    check_finite(reading)
}

/// A chunk's run, compiled once for each width of vectors and chosen by the machine.
struct Chunk<'a, const K: usize> {
    members: Range<usize>,
    member: MemberOf<'a>,
    pieces: Pieces<'a, K>,
    ahead: &'a [f64],
    options: &'a BatchOptions,
    within: &'a Within<'a>,
}

/// The same under two sensors' accelerations.
struct Across<'a, const K: usize>(Chunk<'a, K>);

impl<const K: usize> pulp::WithSimd for Chunk<'_, K> {
    type Output = Vec<MemberPeak>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) -> Self::Output {
        self.run::<S, false>(simd)
    }
}

impl<const K: usize> pulp::WithSimd for Across<'_, K> {
    type Output = Vec<MemberPeak>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) -> Self::Output {
        self.0.run::<S, true>(simd)
    }
}

impl<const K: usize> Chunk<'_, K> {
    #[inline(always)]
    fn run<S: pulp::Simd, const ACROSS: bool>(self, simd: S) -> Vec<MemberPeak> {
        let mut results = Vec::with_capacity(self.members.len());
        for start in self.members.clone().step_by(lanes::<S>()) {
            let member_of = |lane: usize| (self.member)((start + lane).min(self.members.end - 1));
            let members: Vec<Member> = (0..lanes::<S>()).map(member_of).collect();
            let wanted = self.members.end - start;
            let group = Group::<S, K, ACROSS>::new(simd, members, wanted, &self).run();
            results.extend(group.take(wanted));
        }
        results
    }
}

/// Samples after which sine and cosine are computed afresh.
const FRESH_EVERY: usize = 64;

/// Samples after which it is asked whether the rest could still raise a lane's peak.
const ASKED_EVERY: usize = 32;

/// Levers that advance together, `ACROSS` under two sensors' accelerations.
struct Group<'a, S: pulp::Simd, const K: usize, const ACROSS: bool> {
    simd: S,
    pieces: Pieces<'a, K>,
    /// The second sensor's; those of the first where there is none.
    second: Pieces<'a, K>,
    ahead: &'a [f64],
    options: &'a BatchOptions,
    within: &'a Within<'a>,
    lanes: Vec<Lane<K>>,
    coefficients: StepCoefficients<Lanes<S>>,
    /// Recorded accelerations to b with time in sample intervals, and to what acts across.
    along: LaneMix<S>,
    across: LaneMix<S>,
    /// State of the lanes in eventless flight; the others' is in their kernel.
    state: LaneState<Lanes<S>>,
    /// Lanes in eventless flight, each as the bit of its number.
    flying: u32,
    /// Largest angle so far, of judged samples.
    best: Lanes<S>,
    /// The threshold, of lanes that are judged and have not crossed it; else infinite.
    threshold: Lanes<S>,
}

/// [`Mix`] of each lane.
#[derive(Clone, Copy)]
struct LaneMix<S: pulp::Simd> {
    own: Lanes<S>,
    other: Lanes<S>,
    offset: Lanes<S>,
}

impl<S: pulp::Simd> LaneMix<S> {
    #[inline(always)]
    fn gather(simd: S, mix: impl Fn(usize) -> Mix) -> Self {
        Self {
            own: Lanes::from_fn(simd, |lane| mix(lane).own),
            other: Lanes::from_fn(simd, |lane| mix(lane).other),
            offset: Lanes::from_fn(simd, |lane| mix(lane).offset),
        }
    }

    /// Returns the coefficients of a sensor's acceleration over an interval, times its factor and with the
    /// offset, and the largest magnitude there.
    #[inline(always)]
    fn scaled<const K: usize>(&self, simd: S, piece: &Piece<K>) -> ([Lanes<S>; K], Lanes<S>) {
        let constant = |value: f64| Lanes::splat(simd, value);
        let mut terms = [self.offset; K];
        terms[0] = self.own.fused(constant(piece.terms[0]), self.offset);
        if K == STRAIGHT {
            terms[1] = self.own.fused(constant(piece.end), self.offset) - terms[0];
        } else {
            for n in 1..K {
                terms[n] = self.own * constant(piece.terms[n]);
            }
        }
        let low = self.own.fused(constant(piece.range.low), self.offset);
        let high = self.own.fused(constant(piece.range.high), self.offset);
        (terms, low.magnitude().upper(high.magnitude()))
    }

    /// Returns the coefficients of two sensors' accelerations over an interval, each times its factor, and a bound
    /// on their sum: see [`Mix::of`].
    #[inline(always)]
    fn of<const K: usize>(
        &self,
        simd: S,
        own: &Piece<K>,
        other: &Piece<K>,
    ) -> ([Lanes<S>; K], Lanes<S>) {
        let (mut terms, strongest) = self.scaled(simd, own);
        for n in 0..K {
            let term = Lanes::splat(simd, other.terms[n]);
            terms[n] = self.other.fused(term, terms[n]);
        }
        let largest = other.range.low.abs().max(other.range.high.abs());
        (terms, strongest + self.other.magnitude() * largest)
    }
}

/// Samples that one lane takes in contact, compiled for the machine's vectors.
struct Press<'a, const K: usize> {
    pressed: &'a FastContact<K>,
    kernel: &'a mut Kernel,
    pieces: Pieces<'a, K>,
    samples: Range<usize>,
}

impl<const K: usize> pulp::NullaryFnOnce for Press<'_, K> {
    type Output = usize;

    #[inline(always)]
    fn call(self) -> usize {
        let Range { start, end } = self.samples;
        self.pressed.press(self.kernel, &self.pieces, start, end)
    }
}

/// One lever of a group.
struct Lane<const K: usize> {
    member: Member,
    kernel: Kernel,
    pressed: Option<FastContact<K>>,
    /// Recorded accelerations to the model's, with the polarity's sign, and to what acts across.
    along: Mix,
    across: Mix,
    lift_off: f64,
    /// The sample it has got to, of a lane that was carried through several in contact.
    reached: usize,
    /// Nothing to come can raise the peak; the lane is left where it was.
    settled: bool,
    first_crossing_s: Option<f64>,
    scalar_samples: u32,
    spared_samples: u32,
}

impl<const K: usize> Lane<K> {
    fn new<const ACROSS: bool>(
        member: Member,
        interval: f64,
        options: &BatchOptions,
        steps_max: u64,
    ) -> Self {
        let mut kernel = Kernel::of_parts(
            &member.lever,
            &member.stop,
            options.stop,
            options.initial,
            None,
            Recorder::peak_from(options.asked.from_rad),
        )
        .without_error_bound()
        .for_peak();
        kernel.at_most(steps_max);
        let (along, across) = mixes::<ACROSS>(&member, options);
        Self {
            pressed: FastContact::new(&kernel, interval, along, across),
            lift_off: kernel.lift_off_acceleration(),
            member,
            kernel,
            along,
            across,
            reached: 0,
            settled: false,
            first_crossing_s: None,
            scalar_samples: 0,
            spared_samples: 0,
        }
    }

    /// Tells whether the lever stays below its peak so far, or below what is asked for. `ahead` is the
    /// recordings' ∫|a| dt [m/s] over the `left` seconds to come.
    fn stays_below(&self, state: State, ahead: f64, left: f64, options: &BatchOptions) -> bool {
        let Member { lever, stop, .. } = &self.member;
        let Self { along, across, .. } = self;
        let scale =
            (along.own.abs() + across.other.abs()).max(along.other.abs() + across.own.abs());
        let impulse = scale * ahead + (along.offset.abs() + across.offset.abs()) * left;
        let best = self.kernel.recorder.highest();
        stays_below((lever, stop, options.stop), state, best, impulse)
    }

    /// Returns the least model acceleration along in an interval [m/s²].
    fn lowest(&self, first: &Piece<K>, second: &Piece<K>) -> f64 {
        let Mix { own, other, offset } = self.along;
        let least = |factor: f64, piece: &Piece<K>| {
            (factor * piece.range.low).min(factor * piece.range.high)
        };
        let lowest = least(own, first);
        if other != 0.0 {
            lowest + least(other, second) + offset
        } else {
            lowest + offset
        }
    }

    /// Tells whether the lever rests, or need not be followed.
    fn idles(&self) -> bool {
        self.settled || self.kernel.dwells()
    }

    /// Sample intervals from `first` on, before `last`, that press the lever onto its stop; all, if it
    /// need not be followed.
    fn pressed_samples(
        &self,
        (pieces, second): (&Pieces<'_, K>, &Pieces<'_, K>),
        first: usize,
        last: usize,
    ) -> usize {
        if self.settled {
            return last - first;
        }
        let Mix { own, other, offset } = self.along;
        if other != 0.0 {
            let mut index = first;
            while index < last && self.lowest(&pieces.of(index), &second.of(index)) > self.lift_off
            {
                index += 1;
            }
            return index - first;
        }
        let limit = (self.lift_off - offset) / own.abs();
        if limit.is_finite() {
            pieces.above(first, last, own.signum(), limit)
        } else {
            0
        }
    }
}

/// Returns how a member sees the recorded accelerations along and across.
fn mixes<const ACROSS: bool>(member: &Member, options: &BatchOptions) -> (Mix, Mix) {
    let sign = options.opens_when.sign() * member.lever.unbalance_sign();
    let (scale, bias) = (member.scale, member.bias_m_s2);
    if !ACROSS {
        return (
            Mix::scaled(sign * scale, sign * bias),
            Mix::scaled(1.0, 0.0),
        );
    }
    let Projection { tangential, radial } = options.projection;
    let second = member.second;
    let offset = |cosines: [f64; 2]| cosines[0] * bias + cosines[1] * second.bias_m_s2;
    let along = Mix {
        own: sign * tangential[0] * scale,
        other: sign * tangential[1] * second.scale,
        offset: sign * offset(tangential),
    };
    let across = Mix {
        own: radial[1] * second.scale,
        other: radial[0] * scale,
        offset: offset(radial),
    };
    (along, across)
}

impl<'a, S: pulp::Simd, const K: usize, const ACROSS: bool> Group<'a, S, K, ACROSS> {
    #[inline(always)]
    fn new(simd: S, members: Vec<Member>, wanted: usize, chunk: &Chunk<'a, K>) -> Self {
        let Chunk {
            pieces,
            ahead,
            options,
            within,
            ..
        } = *chunk;
        let interval = pieces.signal.rate.interval().seconds();
        let lanes: Vec<Lane<K>> = members
            .into_iter()
            .enumerate()
            .map(|(lane, member)| Lane {
                // What only fills the vector need not be followed.
                settled: lane >= wanted,
                ..Lane::new::<ACROSS>(member, interval, options, within.steps_max)
            })
            .collect();
        let scaled: Vec<Option<StepCoefficients<f64>>> = lanes
            .iter()
            .map(|lane| StepCoefficients::scaled(lane.kernel.free_branch(), interval))
            .collect();
        let gain = |lane: usize| lanes[lane].kernel.gain() * interval * interval;
        let zero = Lanes::splat(simd, 0.0);
        Self {
            coefficients: StepCoefficients::gather(|of| {
                // A lane whose samples are too long for its own motion never flies by the vector.
                Lanes::from_fn(simd, |lane| scaled[lane].as_ref().map_or(f64::NAN, of))
            }),
            along: LaneMix::gather(simd, |lane| lanes[lane].along.times(gain(lane))),
            across: LaneMix::gather(simd, |lane| lanes[lane].across.times(gain(lane))),
            state: LaneState {
                angle: zero,
                slope: zero,
                sine: zero,
                cosine: zero.constant(1.0),
            },
            flying: 0,
            best: zero.constant(f64::INFINITY),
            threshold: zero.constant(f64::INFINITY),
            simd,
            pieces,
            second: pieces.second().unwrap_or(pieces),
            ahead,
            options,
            within,
            lanes,
        }
    }

    #[inline(always)]
    fn run(mut self) -> impl Iterator<Item = MemberPeak> {
        let (first, last) = judged(&self.pieces, self.options);
        for lane in 0..self.lanes.len() {
            self.load(lane);
        }
        let (mut index, mut looked) = (0, 0);
        while index < last {
            if index == first {
                self.open_window();
            }
            if (index == first || index > first && index.is_multiple_of(ASKED_EVERY))
                && self.settle(index, last)
            {
                break;
            }
            if self.flying != self.all() {
                let steps = self.lanes.iter().map(|lane| lane.kernel.work.steps);
                if self.within.ends(steps.sum(), &mut looked) {
                    break;
                }
            }
            if self.flying == 0 && self.lanes.iter().all(Lane::idles) {
                let stop_at = if index < first {
                    first
                } else {
                    self.next_question(index)
                };
                let moved = index + self.pressed(index, stop_at);
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
        for lane in 0..self.lanes.len() {
            self.store(lane);
        }
        let (end, options, within) = (self.pieces.signal.time_s(last), self.options, self.within);
        self.lanes
            .into_iter()
            .map(move |lane| finish(lane, end, last, options, within))
    }

    /// Advances every lane over the sample interval from `index`.
    #[inline(always)]
    fn sample(&mut self, index: usize) {
        let piece = self.pieces.of(index);
        let second = if ACROSS { self.second.of(index) } else { piece };
        if self.flying == 0 {
            for lane in 0..self.lanes.len() {
                self.by_kernel(lane, index, (&piece, &second));
            }
            return;
        }
        if index.is_multiple_of(FRESH_EVERY) {
            self.refresh();
        }
        let before = self.state.angle;
        let (state, stands) = self.step(&piece, &second);
        if self.flying == self.all() && stands.all() {
            self.state = state;
            self.note_crossings(index, before);
            return;
        }
        self.state = chosen(stands, &state, &self.state);
        self.note_crossings(index, before);
        let mut scalar_lanes = self.all() & !(self.flying & stands.bits());
        while scalar_lanes != 0 {
            self.by_kernel(
                scalar_lanes.trailing_zeros() as usize,
                index,
                (&piece, &second),
            );
            scalar_lanes &= scalar_lanes - 1;
        }
    }

    /// Notes of flying lanes when they cross the threshold on the way from `before`.
    #[inline(always)]
    fn note_crossings(&mut self, index: usize, before: Lanes<S>) {
        if !self.state.angle.at_most(self.threshold).all() {
            self.cross(index, before);
        }
    }

    #[cold]
    #[inline(never)]
    fn cross(&mut self, index: usize, before: Lanes<S>) {
        for lane in 0..self.lanes.len() {
            let (from, to) = (before.lane(lane), self.state.angle.lane(lane));
            if self.flies(lane) && to > self.threshold.lane(lane) {
                self.crossed(lane, self.crossing_between(index, from, to));
            }
        }
    }

    /// Returns when a lane that is at `from` at the sample `index`, and above the threshold at `to` one later,
    /// crosses it [s].
    fn crossing_between(&self, index: usize, from: f64, to: f64) -> f64 {
        let interval = self.pieces.signal.rate.interval().seconds();
        let part = (self.options.threshold_rad - from) / (to - from);
        self.pieces.signal.time_s(index) + interval * part.clamp(0.0, 1.0)
    }

    fn crossed(&mut self, lane: usize, at_s: f64) {
        self.lanes[lane].first_crossing_s = Some(at_s);
        self.threshold.set(lane, f64::INFINITY);
    }

    /// All lanes, each as the bit of its number.
    fn all(&self) -> u32 {
        u32::MAX >> (u32::BITS - self.lanes.len() as u32)
    }

    /// Returns the next sample at which lanes are looked at, up to which one may go on alone: so what
    /// is found of a lane does not depend on the others.
    fn next_question(&self, index: usize) -> usize {
        let (first, last) = judged(&self.pieces, self.options);
        let asked = index - index % ASKED_EVERY + ASKED_EVERY;
        let end = if index < first { first } else { last };
        end.min(asked)
    }

    /// One lane's sample by the scalar kernel.
    #[inline(never)]
    fn by_kernel(&mut self, lane: usize, index: usize, (first, second): (&Piece<K>, &Piece<K>)) {
        let Lane {
            kernel,
            along,
            across,
            lift_off,
            settled,
            reached,
            ..
        } = &self.lanes[lane];
        let mixed = |mix: &Mix, own: &Piece<K>, other: &Piece<K>| {
            let mut base = own.terms;
            for (a, other) in base.iter_mut().zip(&other.terms) {
                *a *= mix.own;
                if ACROSS {
                    *a += mix.other * other;
                }
            }
            base[0] += mix.offset;
            base
        };
        let base = mixed(along, first, second);
        let radial = ACROSS.then(|| mixed(across, second, first));
        let rests = || kernel.dwells() && self.lanes[lane].lowest(first, second) > *lift_off;
        if *settled || kernel.stuck || *reached > index || rests() {
            return;
        }
        self.store(lane);
        let before = self.lanes[lane].kernel.angle;
        let until = self.next_question(index);
        let Lane {
            kernel,
            pressed,
            reached,
            scalar_samples,
            ..
        } = &mut self.lanes[lane];
        let pressed_samples = pressed.as_ref().map_or(0, |pressed| {
            self.simd.vectorize(Press {
                pressed,
                kernel,
                pieces: self.pieces,
                samples: index..until,
            })
        });
        if pressed_samples == 0 {
            let interval = self.pieces.signal.rate.interval().seconds();
            kernel.advance(
                self.pieces.signal.time_s(index),
                interval,
                &base,
                radial.as_ref(),
            );
        }
        *reached = index + pressed_samples.max(1);
        *scalar_samples += u32::try_from(pressed_samples.max(1)).unwrap_or(u32::MAX);
        if kernel.recorder.judging {
            let (after, peak) = (kernel.angle, kernel.recorder.peak);
            self.best.set(lane, kernel.recorder.highest());
            let threshold = self.threshold.lane(lane);
            if after > threshold {
                self.crossed(lane, self.crossing_between(index, before, after));
            } else if peak.angle > threshold {
                // It was above between the two samples.
                self.crossed(lane, peak.time);
            }
        }
        self.load(lane);
    }

    /// Puts the lanes aside that can no longer raise their peak, or came far enough, and tells whether these are all.
    #[inline(never)]
    fn settle(&mut self, index: usize, last: usize) -> bool {
        let interval = self.pieces.signal.rate.interval().seconds();
        let remaining_s = (last - index) as f64 * interval;
        for lane in 0..self.lanes.len() {
            let judged_lane = &self.lanes[lane];
            let state = if self.flies(lane) {
                let velocity = self.state.slope.lane(lane) * self.pieces.signal.rate.hertz();
                State::new(self.state.angle.lane(lane), velocity)
            } else {
                judged_lane.kernel.state()
            };
            let enough = self.options.asked.to_rad;
            if !judged_lane.settled
                && !judged_lane.kernel.stuck
                && (judged_lane.kernel.recorder.peak.angle.max(state.angle_rad) > enough
                    || judged_lane.stays_below(
                        state,
                        self.ahead[index / ASKED_EVERY],
                        remaining_s,
                        self.options,
                    ))
            {
                self.store(lane);
                let settled_lane = &mut self.lanes[lane];
                settled_lane.settled = true;
                settled_lane.spared_samples = u32::try_from(last - index).unwrap_or(u32::MAX);
            }
        }
        self.lanes.iter().all(|lane| lane.settled)
    }

    /// Takes a lane that its kernel left in free flight into the vector.
    #[inline(always)]
    fn load(&mut self, lane: usize) {
        let Lane {
            kernel, settled, ..
        } = &self.lanes[lane];
        if kernel.flies_free() && !*settled {
            self.flying |= 1 << lane;
            let (angle, velocity) = (kernel.angle, kernel.velocity);
            let Turned { sine, cosine } = kernel.turned();
            let interval = self.pieces.signal.rate.interval().seconds();
            self.state.angle.set(lane, angle);
            self.state.slope.set(lane, velocity * interval);
            self.state.sine.set(lane, sine);
            self.state.cosine.set(lane, cosine);
        }
    }

    fn flies(&self, lane: usize) -> bool {
        self.flying & (1 << lane) != 0
    }

    /// Gives a flying lane's state back to its kernel.
    #[inline(always)]
    fn store(&mut self, lane: usize) {
        if self.flies(lane) {
            self.flying &= !(1 << lane);
            let velocity = self.state.slope.lane(lane) * self.pieces.signal.rate.hertz();
            let turned = Turned {
                sine: self.state.sine.lane(lane),
                cosine: self.state.cosine.lane(lane),
            };
            let angle = self.state.angle.lane(lane);
            self.lanes[lane].kernel.put(angle, velocity, turned);
        }
    }

    fn refresh(&mut self) {
        for lane in 0..self.lanes.len() {
            let (sine, cosine) = libm::sincos(self.state.angle.lane(lane));
            self.state.sine.set(lane, sine);
            self.state.cosine.set(lane, cosine);
        }
    }

    /// Sample intervals from the first on that press every lane onto its stop.
    fn pressed(&self, first: usize, last: usize) -> usize {
        self.lanes
            .iter()
            .map(|lane| lane.pressed_samples((&self.pieces, &self.second), first, last))
            .min()
            .unwrap_or(0)
    }

    fn open_window(&mut self) {
        let start_s = (self.pieces.signal).time_s(judged(&self.pieces, self.options).0);
        for lane in 0..self.lanes.len() {
            self.store(lane);
            let kernel = &mut self.lanes[lane].kernel;
            let angle = kernel.angle;
            kernel.recorder.open_window(angle, 0.0, 0.0);
            self.best.set(lane, kernel.recorder.highest());
            if angle > self.options.threshold_rad {
                self.lanes[lane].first_crossing_s = Some(start_s);
            } else {
                self.threshold.set(lane, self.options.threshold_rad);
            }
            self.load(lane);
        }
    }

    /// One step of all lanes over a whole sample, and for which of them it stands.
    #[inline(always)]
    fn step(&self, piece: &Piece<K>, second: &Piece<K>) -> (LaneState<Lanes<S>>, Mask<S>) {
        let (simd, state, coefficients) = (self.simd, &self.state, &self.coefficients);
        let constant = |value: f64| Lanes::splat(simd, value);
        let (b, strongest) = if ACROSS {
            let (along, strongest) = self.along.of(simd, piece, second);
            let (across, turning) = self.across.of(simd, second, piece);
            (Push::<_, K, ACROSS> { along, across }, strongest + turning)
        } else {
            let (along, strongest) = self.along.scaled(simd, piece);
            let across = along;
            (Push::<_, K, ACROSS> { along, across }, strongest)
        };
        let bounds = coefficients.bounds(state, strongest);
        let turns = state.slope.magnitude().at_most(bounds.curve * 1.01);
        let calm = bounds.lowest.above(constant(0.0)) & !(turns & bounds.highest.above(self.best));
        let mut orders = coefficients.orders(state, &bounds, &b);
        coefficients.up_to_eight(&mut orders, &b);
        let part = if K == STRAIGHT {
            PEAK_TRUNCATION
        } else {
            CURVED_TRUNCATION
        };
        let allowed = orders.motion() * part;
        let within = |tail: Lanes<S>, turn_max: f64| {
            tail.at_most(allowed) & bounds.turn.at_most(constant(turn_max))
        };
        let (enough, short) = if K == STRAIGHT {
            let enough = within(orders.tail_of_eight(), TURN_MAX[1]);
            (enough, orders.end_of_eight(state))
        } else {
            coefficients.up_to_nine(&mut orders, &b);
            let beyond = orders.beyond_nine(coefficients, &b);
            let enough = within(beyond[2], TURN_MAX[2]);
            (enough, orders.end_beyond_nine(state, beyond))
        };
        if (calm & enough).all() {
            return (short, calm);
        }
        // What the end of the step tells is asked of those alone that the start has left open.
        let calm = calm | (enough & self.was_calm(&short, &bounds, &b, strongest));
        if (enough | !calm).all() {
            return (short, calm & enough);
        }
        let tail = if K == STRAIGHT {
            coefficients.up_to_nine(&mut orders, &b);
            coefficients.up_to_eleven(&mut orders, &b);
            orders.tail_of_eleven()
        } else {
            coefficients.up_to_eleven(&mut orders, &b);
            orders.tail_of_products(&b)
        };
        let eleven = within(tail, TURN_MAX[3]);
        let long = orders.end_of_eleven(state);
        // A lane that needs no more keeps what it would have alone.
        (chosen(enough, &short, &long), calm & (enough | eleven))
    }

    /// Tells of which lanes a step to `after` met neither the stop nor a peak: angle and slope each lie between
    /// their values at the ends but for an eighth of their largest second derivative.
    #[inline(always)]
    fn was_calm(
        &self,
        after: &LaneState<Lanes<S>>,
        bounds: &Bounds<Lanes<S>>,
        b: &Push<Lanes<S>, K, ACROSS>,
        strongest: Lanes<S>,
    ) -> Mask<S> {
        let (state, zero) = (&self.state, after.angle.constant(0.0));
        let third = self.coefficients.third(bounds, strongest, b.change()) * 0.125;
        let bend = bounds.curve * 0.125;
        let clear = (state.angle.lower(after.angle) - bend).above(zero);
        let rises = (state.slope.lower(after.slope) - third).above(zero);
        let falls = zero.above(state.slope.upper(after.slope) + third);
        let below = !(state.angle.upper(after.angle) + bend).above(self.best);
        clear & (rises | falls | below)
    }
}

fn finish<const K: usize>(
    lane: Lane<K>,
    end: f64,
    samples: usize,
    options: &BatchOptions,
    within: &Within<'_>,
) -> MemberPeak {
    let (angle, velocity) = (lane.kernel.angle, lane.kernel.velocity);
    let raises = !lane.stays_below(lane.kernel.state(), 0.0, 0.0, options);
    let Lane {
        member, mut kernel, ..
    } = lane;
    kernel.recorder.close_window(angle, end, 0.0);
    let peak = if kernel.stuck {
        f64::NAN
    } else {
        kernel.recorder.peak.angle
    };
    let energy = energy_of(&member.lever, &member.stop, options.stop, angle, velocity);
    let coasts =
        options.coast && raises && !kernel.stuck && !lane.settled && energy > MOVING_ENERGY_J;
    let coast = coasts.then(|| {
        kernel
            .coast(end, within)
            .map_or(f64::NAN, |peak| peak.angle)
    });
    let apart = u64::from(lane.scalar_samples) + u64::from(lane.spared_samples);
    // A maximum within rounding of the threshold: the peak decides.
    let first_crossing_s = (peak > options.threshold_rad)
        .then(|| lane.first_crossing_s.unwrap_or(kernel.recorder.peak.time));
    MemberPeak {
        first_crossing_s,
        peak_angle_rad: peak,
        coast_peak_angle_rad: coast,
        spent: kernel.work.counted() + (samples as u64).saturating_sub(apart) / 4,
        scalar_samples: lane.scalar_samples,
        spared_samples: lane.spared_samples,
    }
}
