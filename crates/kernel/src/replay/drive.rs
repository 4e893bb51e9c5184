//! The one loop that carries a body through the samples.
//!
//! ```text
//! samples ─▶ drive ─▶ Body::calm_samples  whole samples in which nothing happens, many at a time
//!                  └▶ Body::sample        one sample with its events
//!                     finish              closes the window, coasts on, tells what there was
//! ```
//!
//! Every mechanism is one [`Body`]: a lever alone is here, one beside a catch in `catch`.

use super::body::{Body, begin, limited};
use super::catch;
use super::contact_fast::FastContact;
use super::energy::{impulse_ahead, stays_below};
use super::flight_fast::FastFlight;
use super::kernel::{Coasting, Kernel};
use super::{
    Breakdown, CatchRun, ErrorStatement, MOVING_ENERGY_J, Question, Run, RunOutcome, TracePoint,
    energy_j,
};
use crate::signal::{Mix, Pieces};

/// The event-driven run, compiled for what the machine has and chosen when it runs.
pub(super) struct EventDriven<'a, const K: usize> {
    pub(super) pieces: Pieces<'a, K>,
    pub(super) question: Question<'a>,
}

impl<const K: usize> pulp::WithSimd for EventDriven<'_, K> {
    type Output = RunOutcome;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _simd: S) -> RunOutcome {
        let Self { pieces, question } = &self;
        match question.design.catch {
            Some(parts) if !parts.never_moves() => {
                drive(catch::Pair::new(*pieces, question, parts), pieces, question)
            }
            _ => drive(LeverAlone::new(*pieces, question), pieces, question),
        }
    }
}

/// Carries a body through the samples up to the last judged one, and on until it rests.
#[inline(always)]
fn drive<const K: usize>(
    mut body: impl Body,
    pieces: &Pieces<'_, K>,
    question: &Question<'_>,
) -> RunOutcome {
    let (first, last) = (question.first, question.last);
    let mut ends = None;
    if question.options.peak_only {
        ends = Some(PeakEnd::new(pieces, question));
    }
    let (mut index, mut looked) = (0, 0);
    while index < last {
        if index == first {
            open_window(body.lever(), pieces.signal.time_s(index));
        }
        let mut stop_at = if index < first { first } else { last };
        if let Some(ends) = &mut ends {
            // What stands beside a lever takes energy from it, and never gives any.
            if ends.here(question, body.lever(), index) {
                return finish(body, pieces.signal.time_s(index), question, true);
            }
            stop_at = stop_at.min(ends.asked);
        }
        let carried = body.calm_samples(index, stop_at);
        if carried > 0 {
            index += carried;
            continue;
        }
        body.sample(index);
        index += 1;
        let lever = body.lever();
        lever.stuck |= question.within.ends(lever.work.steps, &mut looked);
        if lever.stuck {
            break;
        }
    }
    if first >= last {
        open_window(body.lever(), pieces.signal.time_s(last));
    }
    finish(body, pieces.signal.time_s(last), question, false)
}

fn open_window(lever: &mut Kernel, time: f64) {
    let error = lever.angle_error();
    lever.recorder.open_window(lever.angle, time, error);
}

/// A lever with nothing beside it.
struct LeverAlone<'a, const K: usize> {
    pieces: Pieces<'a, K>,
    across: Option<Pieces<'a, K>>,
    interval: f64,
    /// Recorded acceleration to the model's.
    sign: f64,
    lift_off: f64,
    kernel: Kernel,
    flight: Option<FastFlight>,
    pressed: Option<FastContact<K>>,
}

impl<'a, const K: usize> LeverAlone<'a, K> {
    #[inline(always)]
    fn new(pieces: Pieces<'a, K>, question: &Question<'_>) -> Self {
        let (options, design) = (question.options, question.design);
        let signal = pieces.signal;
        let kernel = limited::<K>(begin(signal.start_s, design, options), question);
        let sign = options.opens_when.sign() * design.lever.unbalance_sign();
        let interval = signal.rate.interval().seconds();
        let (along, turning) = (Mix::scaled(sign, 0.0), Mix::scaled(1.0, 0.0));
        Self {
            pieces,
            across: pieces.second(),
            interval,
            sign,
            lift_off: kernel.lift_off_acceleration(),
            flight: FastFlight::new(&kernel, interval, sign),
            pressed: FastContact::new(&kernel, interval, along, turning),
            kernel,
        }
    }
}

impl<const K: usize> Body for LeverAlone<'_, K> {
    #[inline(always)]
    fn calm_samples(&mut self, index: usize, stop_at: usize) -> usize {
        let (kernel, pieces) = (&mut self.kernel, &self.pieces);
        if kernel.dwells() {
            // Pressed onto the rigid stop all through the samples: nothing moves.
            return pieces.above(index, stop_at, self.sign, self.lift_off);
        }
        // Without closures, which would not be compiled for the machine's vectors.
        let mut carried = 0;
        if let Some(flight) = &self.flight {
            carried = flight.fly(kernel, pieces, index, stop_at);
        }
        if carried == 0
            && let Some(pressed) = &self.pressed
        {
            carried = pressed.press(kernel, pieces, index, stop_at);
        }
        carried
    }

    #[inline(always)]
    fn sample(&mut self, index: usize) {
        let mut base = self.pieces.terms(index);
        for a in &mut base {
            *a *= self.sign;
        }
        let radial = self.across.as_ref().map(|across| across.terms(index));
        let time = self.pieces.signal.time_s(index);
        self.kernel
            .advance(time, self.interval, &base, radial.as_ref());
    }
}

impl<const K: usize> Coasting for LeverAlone<'_, K> {
    fn lever(&mut self) -> &mut Kernel {
        &mut self.kernel
    }

    fn carry_on(&mut self, time: f64, length: f64) {
        self.kernel.carry_on(time, length);
    }

    fn catch_run(&mut self) -> Option<(CatchRun, Vec<TracePoint>)> {
        None
    }
}

/// Where a run of which the peak alone is asked may end.
struct PeakEnd {
    /// ∫|a| dt from every [`Self::ASKED_EVERY`]th sample on [m/s].
    ahead: Vec<f64>,
    /// The sample at which it is asked next.
    asked: usize,
}

impl PeakEnd {
    /// Samples between two questions, in contact or flight without events.
    const ASKED_EVERY: usize = 128;

    fn new<const K: usize>(pieces: &Pieces<'_, K>, question: &Question<'_>) -> Self {
        Self {
            ahead: impulse_ahead(pieces, question.last, Self::ASKED_EVERY),
            asked: question.first,
        }
    }

    /// Tells, where it is time to ask, whether nothing to come can raise the peak.
    fn here(&mut self, question: &Question<'_>, kernel: &Kernel, index: usize) -> bool {
        if index < self.asked {
            return false;
        }
        self.asked = index + Self::ASKED_EVERY;
        let Question {
            design, options, ..
        } = question;
        let whose = (&design.lever, &design.stop, options.stop);
        let best = kernel.recorder.highest();
        stays_below(
            whose,
            kernel.state(),
            best,
            self.ahead[index / Self::ASKED_EVERY],
        )
    }
}

/// Ends an event-driven run at `end` [s]: closes the window, coasts on unless the lever `rests` or need
/// not be followed, tells what there was.
pub(super) fn finish(
    mut body: impl Coasting,
    end: f64,
    question: &Question<'_>,
    rests: bool,
) -> RunOutcome {
    let Question {
        design,
        options,
        within,
        ..
    } = *question;
    let kernel = body.lever();
    let (angle, velocity) = (kernel.angle, kernel.velocity);
    let error = kernel.angle_error();
    kernel.recorder.close_window(angle, end, error);
    kernel.recorder.point(end, angle, velocity);
    let moving = !rests && energy_j(design, options.stop, angle, velocity) > MOVING_ENERGY_J;
    let stuck = kernel.stuck;
    let (peak, work, trace) = (
        kernel.recorder.peak,
        kernel.work,
        kernel.recorder.trace.take(),
    );
    let finished = kernel.recorder.clone();
    if angle >= peak.angle {
        kernel.deviation = kernel.sensitivity.deviation();
    }
    let in_window = kernel.deviation;
    let coast = if moving && !stuck {
        body.coast(end, within)
    } else {
        None
    };
    let (catch, catch_trace) = body.catch_run().unzip();
    let spent = body.spent();
    let tie = catch.and_then(|catch| catch.tie_s);
    let kernel = body.lever();
    let too_many = kernel.took_too_many();
    let finite_peak = peak.angle.is_finite() && peak.bound().is_finite();
    let broke_down = stuck || (moving && coast.is_none()) || !finite_peak;
    let numerical_error_rad = if !options.error_bound {
        f64::INFINITY
    } else if peak.bound().is_finite() && tie.is_none() {
        peak.bound()
    } else {
        f64::MAX
    };
    RunOutcome {
        run: Run {
            model: options.stop,
            method: options.method.kind(),
            opens_when: options.opens_when,
            peak_angle_rad: finite(peak.angle),
            peak_time_s: peak.time,
            first_crossing_s: finished.first_crossing,
            time_above_threshold_s: finished.time_above,
            first_release_s: finished.first_release,
            impacts: finished.impacts,
            impact_list: finished.impact_list,
            final_angle_rad: finite(angle),
            final_velocity_rad_s: finite(velocity),
            moving_at_end: moving,
            coast_peak_angle_rad: coast.map(|peak| peak.angle),
            numerical_error_rad,
            error: ErrorStatement::Bound(numerical_error_rad),
            work,
        },
        trace: trace.unwrap_or_default(),
        catch,
        catch_trace: catch_trace.unwrap_or_default(),
        spent,
        coast_error_rad: coast.map_or(0.0, |peak| finite(peak.bound())),
        deviation_rad: options
            .noise_m2_s3
            .map(|_| finite(in_window.max(kernel.deviation))),
        final_error_rad: options.error_bound.then(|| finite(error)),
        broke_down,
        breakdown: match broke_down {
            true if too_many => Some(Breakdown::TooManySteps),
            true if !finite_peak => Some(Breakdown::NotFinite),
            true => kernel.breakdown,
            false => None,
        },
        lowest_angle_rad: None,
    }
}

/// The number, or the largest there is in place of what is none: a run that broke down still
/// has to be written down.
pub(super) fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { f64::MAX }
}
