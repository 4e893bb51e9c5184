//! Many levers on one smooth sine, observed once a period, side by side.
//!
//! The period is cut into equal pieces, and a table holds the unit sine's own series over each
//! of them: no sine is computed while levers fly. All lanes are at the same phase; those in eventless
//! flight take a piece together, one that meets the stop, turns near its peak or is too fast for
//! the piece takes it by the scalar kernel. A lane whose lever is done takes the next lever, so
//! none idles.
//!
//! What a lane does depends on its lever alone: a lever's sections have the same bits whatever
//! its neighbours, however many threads share the work and however wide the machine's vectors.
//! [`super::Strobe`] follows one such lever by the scalar kernel alone and agrees to rounding and
//! to what impacts make of it.
//!
//! - `cut`: a sine's period cut into equal pieces: what is known of each before any lever flies.

mod cut;

use super::eventless_step::{LaneState, Push, StepCoefficients, chosen};
use super::kernel::{Kernel, PEAK_TRUNCATION};
use super::recorder::Recorder;
use super::taylor::Turned;
use super::{Section, State};
use crate::error::Error;
use crate::model::Design;
use crate::model::excitation::Harmonic;
use crate::model::stop::StopModel;
use crate::numerics::lanes::{Lanes, Mask, Real, lanes};
use crate::parallel::on_threads;
use cut::{Cut, Piece, TERMS};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// One lever of a batch: where it starts, and how strongly it is shaken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HarmonicStart {
    /// Initial state; `None` for rest on the stop.
    pub initial: Option<State>,
    /// Amplitude A of A sin(ω t + θ), in the model's sign: negative opens [m/s²].
    pub amplitude_m_s2: f64,
}

/// What all levers of a batch share beside their design.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StrobeBatchOptions {
    /// Stop model.
    pub stop: StopModel,
    /// Angular frequency ω of the sine [rad/s].
    pub angular_frequency_rad_s: f64,
    /// Phase θ of the sine at the start of each period [rad].
    pub phase_rad: f64,
    /// Periods after which a lever is let go.
    pub periods_max: u32,
    /// Sections kept of each lever: its last ones.
    pub keep: usize,
    /// Find the largest angle in each period; without, it is NaN in each section, and the levers
    /// take less time.
    pub peaks: bool,
    /// Threads.
    pub threads: usize,
}

/// Why a lever was followed no further.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// The caller had seen enough.
    Done,
    /// The periods had run out.
    Periods,
    /// It can no longer be followed: more events than any chatter holds, or a state beyond a
    /// double. Its last section is that of the period before.
    Lost,
}

/// What one lever of a batch did.
#[derive(Debug, Clone, PartialEq)]
pub struct Followed {
    /// Which lever.
    pub index: usize,
    /// Periods followed.
    pub periods: u32,
    /// Why no more.
    pub ending: Ending,
    /// The last sections, oldest first.
    pub sections: Vec<Section>,
    /// Pieces of periods that were taken by the scalar kernel.
    pub scalar_pieces: u64,
}

/// Sections that one call keeps at most: 2 GB.
const SECTIONS_MAX: usize = 50_000_000;

/// Periods after which a group asks its watcher, if no lever ends before.
const ASK_EVERY: u32 = 64;

/// Gives a lever's start by its number; behind a pointer, as [`IsDone`], so that the vectors' code is compiled once
/// for all.
pub type StartOf<'a> = &'a (dyn Fn(usize) -> HarmonicStart + Sync);

/// Tells of a lever by its number, the periods that it has seen and its newest section whether it is done.
pub type IsDone<'a> = &'a (dyn Fn(usize, u32, &Section) -> bool + Sync);

/// Follows `count` levers, of which `start` gives each, until `done` says so of each, asked with
/// the lever's index, the periods it has seen (from 1 on) and its newest section.
///
/// `watch` is told the number of levers that have ended, now and then and from any thread (two
/// threads may tell theirs in either order); where it says no, all stop, and the result lacks the
/// levers that had not ended. The result is in the order of the levers.
///
/// # Errors
///
/// [`crate::error::Error::OutOfRange`] for an initial state that the stop does not admit, an
/// angular frequency that is not positive, an amplitude or a phase that is not finite, and for more
/// sections to keep than 50 million.
pub fn follow(
    design: &Design,
    count: usize,
    start: StartOf<'_>,
    options: &StrobeBatchOptions,
    done: IsDone<'_>,
    watch: Option<&(dyn Fn(usize) -> bool + Sync)>,
) -> Result<Vec<Followed>, Error> {
    let kept = count.saturating_mul(options.keep.min(options.periods_max as usize));
    if kept > SECTIONS_MAX {
        return Err(Error::out_of_range(
            "sections to keep of all levers together",
            format!("at most {SECTIONS_MAX}; keep fewer of each, or take fewer levers"),
            kept.to_string(),
        ));
    }
    let mut by_pieces: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for index in 0..count {
        let HarmonicStart {
            initial,
            amplitude_m_s2,
        } = start(index);
        super::harmonic::check(
            options.stop,
            &Harmonic {
                amplitude_m_s2,
                angular_frequency_rad_s: options.angular_frequency_rad_s,
                phase_rad: options.phase_rad,
            },
            initial,
        )?;
        let pieces = cut::pieces(design, options.angular_frequency_rad_s, amplitude_m_s2);
        by_pieces.entry(pieces).or_default().push(index);
    }
    let batch = StrobeBatch {
        design,
        options,
        start,
        done,
        watch,
        ended: AtomicUsize::new(0),
        stopped: AtomicBool::new(false),
    };
    let arch = pulp::Arch::new();
    let levers = Mutex::new(Vec::with_capacity(count));
    for (pieces, members) in by_pieces {
        let cut = Cut::new(design, options, pieces);
        let next = AtomicUsize::new(0);
        let threads = options.threads.clamp(1, members.len());
        on_threads(threads, &|| {
            let followed = arch.dispatch(StrobeWorker {
                batch: &batch,
                cut: &cut,
                members: &members,
                next: &next,
                lanes_max: members.len().div_ceil(threads),
            });
            let mut levers = levers.lock().unwrap_or_else(PoisonError::into_inner);
            levers.extend(followed);
        });
    }
    let mut levers = levers.into_inner().unwrap_or_else(PoisonError::into_inner);
    levers.sort_by_key(|followed: &Followed| followed.index);
    Ok(levers)
}

/// What all threads share.
struct StrobeBatch<'a> {
    design: &'a Design,
    options: &'a StrobeBatchOptions,
    start: StartOf<'a>,
    done: IsDone<'a>,
    watch: Option<&'a (dyn Fn(usize) -> bool + Sync)>,
    ended: AtomicUsize,
    stopped: AtomicBool,
}

impl StrobeBatch<'_> {
    /// Tells the watcher how many have ended, and notes whether it wants to go on.
    fn ask(&self, more: usize) {
        let ended = self.ended.fetch_add(more, Ordering::Relaxed) + more;
        if self.watch.is_some_and(|watch| !watch(ended)) {
            self.stopped.store(true, Ordering::Relaxed);
        }
    }
}

/// A thread's share, compiled once for each width of vectors and chosen by the machine.
struct StrobeWorker<'a> {
    batch: &'a StrobeBatch<'a>,
    cut: &'a Cut,
    members: &'a [usize],
    next: &'a AtomicUsize,
    lanes_max: usize,
}

impl pulp::WithSimd for StrobeWorker<'_> {
    type Output = Vec<Followed>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) -> Self::Output {
        let mut group = StrobeGroup::new(simd, self.cut);
        let mut finished = Vec::new();
        let mut periods = 0_u32;
        while !self.batch.stopped.load(Ordering::Relaxed) {
            for lane in 0..lanes::<S>().min(self.lanes_max) {
                if group.lanes[lane].is_none()
                    && let place = self.next.fetch_add(1, Ordering::Relaxed)
                    && let Some(index) = self.members.get(place)
                {
                    group.begin(lane, self.batch, *index);
                }
            }
            if group.lanes.iter().all(Option::is_none) {
                break;
            }
            group.period();
            let before = finished.len();
            for lane in 0..group.lanes.len() {
                finished.extend(group.observe(lane, self.batch));
            }
            periods += 1;
            if finished.len() > before || periods.is_multiple_of(ASK_EVERY) {
                self.batch.ask(finished.len() - before);
            }
        }
        finished
    }
}

/// Pieces after which sine and cosine are computed afresh.
const FRESH_EVERY: usize = 16;

/// Levers that advance together.
struct StrobeGroup<'a, S: pulp::Simd> {
    simd: S,
    cut: &'a Cut,
    lanes: Vec<Option<StrobeLane>>,
    coefficients: StepCoefficients<Lanes<S>>,
    /// b of a whole sine with time in pieces.
    gain: Lanes<S>,
    /// State of the lanes in eventless flight; the others' is in their kernel.
    state: LaneState<Lanes<S>>,
    /// Lanes in eventless flight.
    flying: usize,
    /// Largest angle so far in this period.
    best: Lanes<S>,
}

/// One lever of a group.
struct StrobeLane {
    kernel: Kernel,
    /// b = m L a/I0 of a whole sine, sign included [rad/s²].
    strength: f64,
    flying: bool,
    /// Impacts and rests before this period.
    before: (u64, u64),
    followed: Followed,
}

impl<'a, S: pulp::Simd> StrobeGroup<'a, S> {
    #[inline(always)]
    fn new(simd: S, cut: &'a Cut) -> Self {
        let zero = Lanes::splat(simd, 0.0);
        Self {
            coefficients: StepCoefficients::gather(|of| {
                // Levers whose own motion is too fast for the pieces never fly by the vector.
                zero.constant(cut.coefficients.as_ref().map_or(f64::NAN, of))
            }),
            gain: zero,
            state: LaneState {
                angle: zero.constant(-1.0),
                slope: zero,
                sine: zero,
                cosine: zero.constant(1.0),
            },
            flying: 0,
            best: zero,
            lanes: (0..lanes::<S>()).map(|_| None).collect(),
            simd,
            cut,
        }
    }

    /// Puts lever `index` into a lane.
    fn begin(&mut self, lane: usize, batch: &StrobeBatch<'_>, index: usize) {
        let HarmonicStart {
            initial,
            amplitude_m_s2,
        } = (batch.start)(index);
        let kernel = Kernel::new(
            batch.design,
            batch.options.stop,
            initial,
            None,
            Recorder::peak_only(),
        )
        .for_ever()
        .without_error_bound();
        let strength = kernel.gain() * amplitude_m_s2;
        self.gain
            .set(lane, strength * self.cut.length * self.cut.length);
        self.lanes[lane] = Some(StrobeLane {
            kernel,
            strength,
            flying: false,
            before: (0, 0),
            followed: Followed {
                index,
                periods: 0,
                ending: Ending::Periods,
                sections: Vec::new(),
                scalar_pieces: 0,
            },
        });
        self.load(lane);
        self.open(lane, batch.options.peaks);
    }

    /// Begins a lane's period.
    fn open(&mut self, lane: usize, peaks: bool) {
        self.best.set(lane, f64::INFINITY);
        let angle = self.state.angle.lane(lane);
        if let Some(StrobeLane {
            kernel,
            before,
            flying,
            ..
        }) = &mut self.lanes[lane]
        {
            *before = (kernel.recorder.impacts, kernel.rests);
            if peaks {
                let angle = if *flying { angle } else { kernel.angle };
                kernel.recorder.open_window(angle, 0.0, 0.0);
                self.best.set(lane, angle);
            }
        }
    }

    /// Ends a lane's period; returns its lever if it is followed no further.
    fn observe(&mut self, lane: usize, batch: &StrobeBatch<'_>) -> Option<Followed> {
        let options = batch.options;
        let lever = self.lanes[lane].as_mut()?;
        let section = (!lever.kernel.stuck).then(|| {
            let (angle_rad, velocity_rad_s) = if lever.flying {
                let slope = self.state.slope.lane(lane);
                (self.state.angle.lane(lane), slope / self.cut.length)
            } else {
                (lever.kernel.angle, lever.kernel.velocity)
            };
            Section {
                angle_rad,
                velocity_rad_s,
                peak_angle_rad: if options.peaks {
                    lever.kernel.recorder.peak.angle.max(angle_rad)
                } else {
                    f64::NAN
                },
                impacts: lever.kernel.recorder.impacts - lever.before.0,
                rested: lever.kernel.rests > lever.before.1,
            }
        });
        let followed = &mut lever.followed;
        let ended = if let Some(section) = section {
            followed.periods += 1;
            if options.keep > 0 {
                // Twice as many before the old ones go, so that each moves but once.
                if followed.sections.len() >= 2 * options.keep {
                    followed.sections.drain(..options.keep);
                }
                followed.sections.push(section);
            }
            let done = (batch.done)(followed.index, followed.periods, &section);
            if done {
                followed.ending = Ending::Done;
            }
            done || followed.periods >= options.periods_max
        } else {
            followed.ending = Ending::Lost;
            true
        };
        if !ended {
            self.open(lane, options.peaks);
            return None;
        }
        self.store(lane);
        let mut followed = self.lanes[lane].take()?.followed;
        let surplus = followed.sections.len().saturating_sub(options.keep);
        followed.sections.drain(..surplus);
        followed.sections.shrink_to_fit();
        Some(followed)
    }

    /// Advances every lane by a period.
    #[inline(always)]
    fn period(&mut self) {
        let pressing = self.cut.pressing;
        let asleep = |lane: &Option<StrobeLane>| match lane {
            Some(lane) => lane.kernel.stuck || lane.sleeps(pressing),
            None => true,
        };
        if self.flying == 0 && self.lanes.iter().all(asleep) {
            return;
        }
        let cut = self.cut;
        for (index, piece) in cut.table.iter().enumerate() {
            if index.is_multiple_of(FRESH_EVERY) {
                self.refresh();
            }
            self.piece(index, piece);
        }
    }

    /// Advances every lane over a piece.
    #[inline(always)]
    fn piece(&mut self, index: usize, piece: &Piece) {
        if self.flying == 0 {
            for lane in 0..self.lanes.len() {
                self.by_kernel(lane, index, piece);
            }
            return;
        }
        let (state, stands) = self.step(piece);
        if self.flying == self.lanes.len() && stands.all() {
            self.state = state;
            return;
        }
        self.state = chosen(stands, &state, &self.state);
        let stands = stands.bits();
        for lane in 0..self.lanes.len() {
            // A lane that does not fly lies below the stop, where no step stands.
            if stands & (1 << lane) == 0 {
                self.by_kernel(lane, index, piece);
            }
        }
    }

    /// One lane's piece by the scalar kernel.
    #[inline(always)]
    fn by_kernel(&mut self, lane: usize, index: usize, piece: &Piece) {
        let pressing = self.cut.pressing;
        if let Some(lever) = &self.lanes[lane]
            && !lever.kernel.stuck
            && !lever.sleeps(pressing)
            && !(lever.kernel.dwells() && piece.lowest(lever.strength) + pressing > 0.0)
        {
            self.advance(lane, index, piece);
        }
    }

    #[inline(never)]
    fn advance(&mut self, lane: usize, index: usize, piece: &Piece) {
        self.store(lane);
        if let Some(lever) = &mut self.lanes[lane] {
            if !self.cut.press(&mut lever.kernel, lever.strength, index) {
                lever
                    .kernel
                    .advance_sine(&piece.sine(self.cut, lever.strength));
                lever.followed.scalar_pieces += 1;
            }
            if lever.kernel.recorder.judging {
                self.best.set(lane, lever.kernel.recorder.peak.angle);
            }
        }
        self.load(lane);
    }

    /// Takes a lane that its kernel left in free flight into the vector.
    #[inline(always)]
    fn load(&mut self, lane: usize) {
        if let Some(StrobeLane { kernel, flying, .. }) = &mut self.lanes[lane] {
            *flying = kernel.flies_free();
            if *flying {
                self.flying += 1;
                let (angle, velocity) = (kernel.angle, kernel.velocity);
                let Turned { sine, cosine } = kernel.turned();
                self.state.angle.set(lane, angle);
                self.state.slope.set(lane, velocity * self.cut.length);
                self.state.sine.set(lane, sine);
                self.state.cosine.set(lane, cosine);
            }
        }
    }

    /// Gives a flying lane's state back to its kernel.
    #[inline(always)]
    fn store(&mut self, lane: usize) {
        if let Some(StrobeLane { kernel, flying, .. }) = &mut self.lanes[lane]
            && std::mem::take(flying)
        {
            self.flying -= 1;
            let turned = Turned {
                sine: self.state.sine.lane(lane),
                cosine: self.state.cosine.lane(lane),
            };
            let velocity = self.state.slope.lane(lane) / self.cut.length;
            kernel.put(self.state.angle.lane(lane), velocity, turned);
            self.state.angle.set(lane, -1.0);
            self.state.slope.set(lane, 0.0);
        }
    }

    fn refresh(&mut self) {
        for (lane, of) in self.lanes.iter().enumerate() {
            if of.as_ref().is_some_and(|of| of.flying) {
                let (sine, cosine) = libm::sincos(self.state.angle.lane(lane));
                self.state.sine.set(lane, sine);
                self.state.cosine.set(lane, cosine);
            }
        }
    }

    /// One step of all lanes over a piece, and for which of them it stands.
    #[inline(always)]
    fn step(&self, piece: &Piece) -> (LaneState<Lanes<S>>, Mask<S>) {
        let (state, coefficients) = (&self.state, &self.coefficients);
        let constant = |value: f64| Lanes::splat(self.simd, value);
        let mut b = [self.gain; TERMS];
        for (b, unit) in b.iter_mut().zip(&piece.series) {
            *b = *b * *unit;
        }
        let b = Push::along(b);
        let bounds = coefficients.bounds(state, self.gain.magnitude() * piece.strongest);
        let turns = state.slope.magnitude().at_most(bounds.curve * 1.01);
        let calm = bounds.lowest.above(constant(0.0)) & !(turns & bounds.highest.above(self.best));
        let mut orders = coefficients.orders(state, &bounds, &b);
        coefficients.up_to_eight(&mut orders, &b);
        coefficients.up_to_nine(&mut orders, &b);
        coefficients.up_to_eleven(&mut orders, &b);
        orders.swinging(constant(self.cut.swing));
        let short = orders
            .tail_of_eleven()
            .at_most(orders.motion() * PEAK_TRUNCATION)
            & orders.tail_turned().at_most(constant(PEAK_TRUNCATION));
        (orders.end_of_eleven(state), calm & short)
    }
}

impl StrobeLane {
    /// Tells whether the lever rests on the rigid stop for ever.
    fn sleeps(&self, pressing: f64) -> bool {
        self.kernel.dwells() && self.strength.abs() <= pressing
    }
}
