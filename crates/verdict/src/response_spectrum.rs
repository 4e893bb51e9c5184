//! The latch response spectrum: what any latch must have to stay shut under a recording.
//!
//! With s = φ I0/(m L) the lever is a mass on a wall, s″ = −a* − (k0/I0) s − (c0/I0) s′ − a cos φ, held by the
//! lift-off acceleration a* = T0/(m L) and open beyond the stroke s* = φ* I0/(m L). So preload, unbalance, inertia
//! and limit angle of all levers are two numbers, and one curve of a* over s* says of each whether it stays. Spring,
//! damping and restitution stay outside and are stated with the curve. For a curve cos φ is 1, which is half a
//! per cent of the load at 0.1 rad: so one lever tells of all strokes, by how far it comes. A design's own column has
//! its own angles.
//!
//! Where the lever bounces, single levers that open and that stay lie among one another as fine as one looks. The
//! curve is therefore one of shares. Between two neighbours of E48, 128 levers are followed on each stop, a* shared
//! out over the window; scale, bias and restitution are drawn as those of an ensemble, noise and the reading between
//! the samples are shared out among them. A window passes at a stroke if at most one of them comes beyond it.
//!
//! - The **spectrum** at a stroke is the upper edge of the highest window that does not pass on both stops.
//! - The **zone** below it, where a lever stays or opens by small things, ends at the lower edge of the lowest window
//!   of which fewer than 95 % open on one of the stops.
//!
//! Windows reach from twice the strongest acceleration of either sign down to a hundredth of it, and further up while
//! the highest does not pass: a soft stop throws a lever back. Where every window passes the lowest edge stands for the
//! spectrum, which is not above it. Each is followed: a lever on a rigid
//! stop whose a* is above every acceleration that it may see never lifts off, and is the only one that is spared.
//!
//! - `plane`: the place of a design in the plane of stroke and lift-off;
//! - `single_push`: the curve of one push from rest, without bounces.

pub mod plane;
mod single_push;

use super::ensemble::{Scatter, draw};
use super::faults::Faults;
use super::meter::Meter;
use super::noise;
use super::policy::ModelChoice;
use super::readings::{ReadingCache, Readings, SampleReading};
use super::usable_span::{SampleSpan, UsableSpan, window_samples};
use crate::conditioning::{Between, Conditioned};
use crate::margin::quantity::preferred;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::range::Range;
use latchgate_kernel::replay;
use latchgate_kernel::replay::batch::{self, AskedPeaks, BatchOptions, Member};
use latchgate_kernel::signal::{Projection, Reading, Signal};
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY};
use latchgate_recording::Finding;
use latchgate_recording::error::Error;

/// Preferred numbers R10 (ISO 3) of a decade.
const R10: [f64; 10] = [1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0];

/// Levers that are followed in a window.
pub const LEVERS: usize = 128;

/// Of these, how many may open in a window that passes.
pub const OPENING_ALLOWED: usize = 1;

/// Of these, how many open at least in a window below the zone: 95 %.
pub const OPENING_SURELY: usize = 122;

/// Readings of the recording that the levers of a window share.
pub const READINGS: usize = 16;

/// How the samples of each are read: the own way beside each of the others.
const WAYS: [SampleReading; 8] = [
    SampleReading::Quintic,
    SampleReading::Cubic,
    SampleReading::Corners(-2.0),
    SampleReading::Quintic,
    SampleReading::Corners(2.0),
    SampleReading::Corners(-1.0),
    SampleReading::Quintic,
    SampleReading::Corners(1.0),
];

/// Times the strongest opening acceleration from which on windows are followed downwards [-].
const TOP_TIMES: f64 = 2.0;

/// Times at most up to which they are followed while the highest does not pass [-].
const TOP_TIMES_MOST: f64 = 8192.0;

/// Part of it down to which they are [-].
pub const FLOOR_PART: f64 = 0.01;

/// Windows that are followed side by side.
const SIDE_BY_SIDE: usize = 4;

/// Angle of a chart's levers at the largest stroke [rad]: its cosine is 1 but for 0.005 %.
const CHART_ANGLE_RAD: f64 = 0.01;

/// Streams of the draws that an ensemble has none of.
const STREAM_OF_LIFT_OFF: u32 = 1_000;
const STREAM_OF_RESTITUTION: u32 = 1_001;

/// Smallest and largest stroke of a chart [m].
const STROKE_MIN_M: f64 = 1e-3;
const STROKE_MAX_M: f64 = 0.2;

/// Returns the strokes of a chart: R10 from 1 to 200 mm [m].
pub fn strokes_m() -> Vec<f64> {
    let decades = [1e-3, 1e-2, 1e-1];
    let strokes = decades
        .iter()
        .flat_map(|decade| R10.map(|number| decade * number));
    strokes.take(24).collect()
}

/// Levers that differ in lift-off alone, each of which tells of every stroke up to the largest.
#[derive(Debug, Clone)]
pub struct LeverFamily {
    design: Design,
    /// Smallest and largest stroke that they are asked for [m].
    strokes_m: (f64, f64),
    /// Bounds of a restitution that is drawn evenly; `None` where the design says how it scatters.
    even_restitution: Option<(f64, f64)>,
}

impl LeverFamily {
    /// Levers with spring, damping and stops of the paper's example, each by its inertia, and of this restitution,
    /// which is drawn evenly where its bounds differ; their angles are small.
    pub fn of_chart((from, to): (f64, f64)) -> Self {
        let mut design = Design::reference();
        let Design { lever, stop, .. } = &mut design;
        let nominal = *stop;
        stop.restitution = 0.5 * (from + to);
        stop.follow_restitution(&nominal, lever);
        let angle_per_stroke = lever.unbalance_kg_m() / lever.moment_of_inertia_kg_m2;
        let smaller = CHART_ANGLE_RAD / STROKE_MAX_M / angle_per_stroke;
        // What each is by inertia stays; the energy of a lever at a stroke stays as well.
        let inertia_times = 1.0 / (smaller * smaller);
        lever.moment_of_inertia_kg_m2 *= inertia_times;
        lever.mass_kg *= smaller * inertia_times;
        lever.spring_stiffness_nm_per_rad *= inertia_times;
        lever.pivot_damping_nm_s_per_rad *= inertia_times;
        stop.stiffness_n_per_m *= inertia_times;
        stop.damping_n_s_per_m *= inertia_times;
        design.tolerance.retain(|key, _| key == "restitution");
        if from < to {
            design.tolerance.clear();
        }
        Self {
            design,
            strokes_m: (STROKE_MIN_M, STROKE_MAX_M),
            even_restitution: (from < to).then_some((from, to)),
        }
    }

    /// Levers that share a design's spring, damping, stops and angles, with their tolerances, between two strokes
    /// [m]; tolerances of preload, unbalance and inertia move a lever in the plane, and are left out.
    pub fn of_design(design: &Design, strokes_m: (f64, f64)) -> Self {
        const IN_PLANE: [&str; 4] = [
            "preload_torque_nm",
            "mass_kg",
            "center_of_mass_m",
            "moment_of_inertia_kg_m2",
        ];
        let mut design = design.clone();
        design
            .tolerance
            .retain(|key, _| !IN_PLANE.contains(&key.as_str()));
        Self {
            design,
            strokes_m,
            even_restitution: None,
        }
    }

    /// Returns the design whose numbers beside lift-off they share.
    pub fn design(&self) -> &Design {
        &self.design
    }

    /// Returns the standard deviation of their restitution [-].
    pub fn restitution_deviation(&self) -> f64 {
        let tolerance = self.design.tolerance.get("restitution");
        tolerance.map_or(0.0, |tolerance| {
            tolerance.deviation(self.design.stop.restitution)
        })
    }

    /// Returns the angle by which they turn for a way of their centre of percussion [rad/m].
    fn angle_per_stroke(&self) -> f64 {
        let lever = &self.design.lever;
        lever.unbalance_kg_m() / lever.moment_of_inertia_kg_m2
    }

    /// Returns the sign of the acceleration that opens, in the recording's polarity.
    fn opening_sign(&self, opens_when: OpensWhen) -> f64 {
        -opens_when.sign() * self.design.lever.unbalance_sign()
    }
}

/// What a spectrum is asked beside recording and levers.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectrumOptions {
    /// Seed of the draws.
    pub seed: u64,
    /// Steps that the columns of one direction may take together.
    pub work: u64,
    /// How the acceleration runs between samples.
    pub between: Between,
}

/// The spectrum at one stroke.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Column {
    /// The spectrum [m/s²]; the lower edge of the lowest window where every window passes; `None` without any window.
    pub spectrum_m_s2: Option<f64>,
    /// Lower end of the zone [m/s²]; `None` where it reaches below the lowest window, or without a spectrum.
    pub zone_from_m_s2: Option<f64>,
}

/// The spectrum of one recording in one direction, for one family of levers.
#[derive(Debug, Clone, PartialEq)]
pub struct ResponseSpectrum {
    /// Strongest acceleration that opens, of any reading [m/s²].
    pub strongest_m_s2: f64,
    /// Edges of the windows, descending [m/s²].
    edges_m_s2: Vec<f64>,
    /// What the levers between two edges come to.
    windows: Vec<Reached>,
    /// Levers that were followed.
    pub levers: usize,
}

/// How far the levers of a window come, over both stops [m].
#[derive(Debug, Clone, Copy, PartialEq)]
struct Reached {
    /// Beyond this stroke the window passes.
    passes_from_m: f64,
    /// Below this stroke its levers surely open.
    surely_below_m: f64,
}

impl Reached {
    /// Of levers on one stop; NaN is one that was not followed, which may open and does not surely.
    fn of(mut strokes_m: Vec<f64>) -> Self {
        let ranked = |strokes: &mut [f64], unknown: f64, rank: usize| {
            for stroke in strokes.iter_mut().filter(|stroke| stroke.is_nan()) {
                *stroke = unknown;
            }
            strokes.sort_unstable_by(|a, b| b.total_cmp(a));
            strokes.get(rank - 1).copied().unwrap_or(0.0)
        };
        let surely_below_m = ranked(&mut strokes_m.clone(), 0.0, OPENING_SURELY);
        Self {
            passes_from_m: ranked(&mut strokes_m, f64::INFINITY, OPENING_ALLOWED + 1),
            surely_below_m,
        }
    }

    /// On both of two stops.
    fn and(self, other: Self) -> Self {
        Self {
            passes_from_m: self.passes_from_m.max(other.passes_from_m),
            surely_below_m: self.surely_below_m.min(other.surely_below_m),
        }
    }
}

impl ResponseSpectrum {
    /// Returns the spectrum at a stroke [m]; of a chart's family at any, else up to its largest.
    pub fn at(&self, stroke_m: f64) -> Column {
        let mut windows = self.windows.iter();
        let Some(edge) = windows.position(|reached| reached.passes_from_m > stroke_m) else {
            return Column {
                spectrum_m_s2: self.floor_m_s2().filter(|_| !self.windows.is_empty()),
                zone_from_m_s2: None,
            };
        };
        let lowest = |reached: &Reached| reached.surely_below_m <= stroke_m;
        let last = self.windows.iter().rposition(lowest);
        // All of the highest window that does not pass may open: then there is no zone.
        let zone_from = last.map_or(edge, |last| (last + 1).max(edge));
        Column {
            spectrum_m_s2: self.edges_m_s2.get(edge).copied(),
            zone_from_m_s2: self
                .edges_m_s2
                .get(zone_from)
                .copied()
                .filter(|_| zone_from < self.windows.len()),
        }
    }

    /// Tells whether every window passes at a stroke [m].
    pub fn passes(&self, stroke_m: f64) -> bool {
        let mut windows = self.windows.iter();
        windows.all(|reached| reached.passes_from_m <= stroke_m)
    }

    /// Tells whether there are windows, and the levers of each surely open at a stroke [m].
    pub fn surely_opens(&self, stroke_m: f64) -> bool {
        let mut windows = self.windows.iter();
        !self.windows.is_empty() && windows.all(|reached| reached.surely_below_m > stroke_m)
    }

    /// Returns the lower edge of the lowest window [m/s²].
    pub fn floor_m_s2(&self) -> Option<f64> {
        self.edges_m_s2.last().copied()
    }
}

/// A recording as its spectrum sees it: its readings, and the samples that count.
#[derive(Debug)]
pub struct SpectrumRecording<'a> {
    conditioned: &'a Conditioned,
    readings: Vec<Reading<'a>>,
    window: Option<SampleSpan>,
    options: SpectrumOptions,
    /// The last instant that counts, where a fault ends the samples [s].
    pub judged_until_s: Option<f64>,
}

/// The judged samples, first and last, where they are not all; and the last instant that counts, where a fault ends
/// them [s].
type JudgedSpan = (Option<(usize, usize)>, Option<f64>);

/// Returns what of a recording its spectrum is of.
///
/// # Errors
///
/// [`Malformed`](latchgate_recording::error::ErrorKind::Malformed) where a blocking finding leaves no samples, or of a
/// recording with a second channel; those of conditioning.
pub fn judged_span(conditioned: &Conditioned, findings: &[Finding]) -> Result<JudgedSpan, Error> {
    if conditioned.second.is_some() {
        return Err(Error::malformed(
            "one channel: levers that two channels drive have no place in the plane",
            "two channels",
            "leave out the setting `radial_channel`",
        ));
    }
    let signal = &conditioned.used;
    let faults = Faults::of(conditioned, conditioned.filter, findings, None);
    match UsableSpan::of(&faults, signal, None) {
        UsableSpan::Whole => Ok((window_samples(signal, None)?, None)),
        UsableSpan::Until(span) => Ok((Some(span), Some(signal.time_s(span.1)))),
        UsableSpan::Nothing => {
            let blocking = findings
                .iter()
                .find(|finding| finding.severity == latchgate_recording::Severity::Blocking);
            let found = blocking.map_or("a fault from the start", |finding| &finding.text);
            Err(Error::malformed(
                "a recording without a blocking finding",
                found,
                "an unusable recording has no spectrum",
            ))
        }
    }
}

impl<'a> SpectrumRecording<'a> {
    /// Draws the readings of a recording; `findings` are those of reading and conditioning, and `cache` is of it.
    ///
    /// # Errors
    ///
    /// Those of [`judged_span`]; [`Stopped`](latchgate_kernel::error::Error::Stopped).
    pub fn new(
        conditioned: &'a Conditioned,
        findings: &[Finding],
        options: SpectrumOptions,
        cache: &'a ReadingCache,
        control: &Control<'_>,
    ) -> Result<Self, Error> {
        let (window, judged_until_s) = judged_span(conditioned, findings)?;
        let own = Readings::of(conditioned, cache, options.between);
        let readings = drawn_readings(&own, options.seed, control)?;
        Ok(Self {
            conditioned,
            readings,
            window,
            options,
            judged_until_s,
        })
    }

    /// Returns, for each stroke [m], the lift-off that one push from rest asks for [m/s²]: the curve without bounces.
    pub fn single_push(
        &self,
        family: &LeverFamily,
        opens_when: OpensWhen,
        strokes_m: &[f64],
    ) -> Vec<f64> {
        let sign = family.opening_sign(opens_when);
        let used = &self.conditioned.used;
        let counted = self.window.map_or(used.samples.len(), |(_, last)| last + 1);
        let counted = Signal {
            samples: used.samples[..counted.min(used.samples.len())].to_vec(),
            ..*used
        };
        single_push::single_push(&counted, sign, strokes_m)
    }

    /// Follows the levers of every window, in one direction.
    ///
    /// # Errors
    ///
    /// As [`Self::spectrum_between`].
    pub fn spectrum(
        &self,
        family: &LeverFamily,
        opens_when: OpensWhen,
        control: &Control<'_>,
    ) -> Result<ResponseSpectrum, Error> {
        self.spectrum_between(family, opens_when, (0.0, f64::INFINITY), control)
    }

    /// As [`Self::spectrum`], of the windows that hold a lift-off between two [m/s²].
    ///
    /// # Errors
    ///
    /// [`Stopped`](latchgate_kernel::error::Error::Stopped); those of the replay; as [`Scatter::new`];
    /// [`LimitExceeded`](latchgate_recording::error::ErrorKind::LimitExceeded) where that takes more work than is
    /// allowed.
    pub fn spectrum_between(
        &self,
        family: &LeverFamily,
        opens_when: OpensWhen,
        (least_m_s2, most_m_s2): (f64, f64),
        control: &Control<'_>,
    ) -> Result<ResponseSpectrum, Error> {
        let mut top_times = TOP_TIMES;
        loop {
            let range = (least_m_s2, most_m_s2);
            let found = self.windows(family, opens_when, (range, top_times), control)?;
            let highest = found.windows.first().map(|reached| reached.passes_from_m);
            let is_open = highest.is_some_and(|reached_m| reached_m > family.strokes_m.0);
            if !is_open || most_m_s2.is_finite() || top_times >= TOP_TIMES_MOST {
                return Ok(found);
            }
            top_times *= 4.0;
        }
    }

    fn windows(
        &self,
        family: &LeverFamily,
        opens_when: OpensWhen,
        ((least_m_s2, most_m_s2), top_times): ((f64, f64), f64),
        control: &Control<'_>,
    ) -> Result<ResponseSpectrum, Error> {
        let mut levers = Levers::new(self, family, opens_when, (least_m_s2, top_times))?;
        let edges = &mut levers.edges_m_s2;
        let above = edges.iter().filter(|edge| **edge >= most_m_s2).count();
        let until = edges.iter().filter(|edge| **edge > least_m_s2).count();
        // The edges around both.
        edges.truncate(until + 1);
        edges.drain(..above.saturating_sub(1));
        let count = levers.edges_m_s2.len().saturating_sub(1);
        let blocks: Vec<Vec<usize>> = (0..count)
            .step_by(SIDE_BY_SIDE)
            .map(|from| (from..count.min(from + SIDE_BY_SIDE)).collect())
            .collect();
        let reached = control.try_map(&blocks, |windows| levers.follow(windows, control))?;
        if let Some(limit) = levers.work.limit_reached() {
            return Err(Error::over("work", limit, "more steps of a spectrum"));
        }
        let followed = reached.iter().map(|(_, followed)| followed).sum();
        Ok(ResponseSpectrum {
            strongest_m_s2: levers.largest_m_s2,
            windows: reached
                .into_iter()
                .flat_map(|(windows, _)| windows)
                .collect(),
            edges_m_s2: levers.edges_m_s2,
            levers: followed,
        })
    }
}

/// Returns the readings that the levers of each window share.
fn drawn_readings<'a>(
    own: &Readings<'a>,
    seed: u64,
    control: &Control<'_>,
) -> Result<Vec<Reading<'a>>, Error> {
    if own.is_exact() {
        return Ok(vec![own.own()?]);
    }
    let spectra = own.noise_spectra();
    let numbers: Vec<u32> = (0..READINGS as u32).collect();
    control.unmeasured(|control| {
        control.try_map(&numbers, |number| {
            let noisy = noise::noisy(own, seed, Some(spectra), 0.0, *number)?;
            match WAYS[*number as usize % WAYS.len()] {
                _ if own.between() == Between::Linear => Ok(noisy),
                // Of its own: what it was read from goes.
                way => Ok(own.read_as(&noisy, way)?.scaled(1.0, 0.0)),
            }
        })
    })
}

/// The levers of one family on one recording in one direction.
struct Levers<'a> {
    recording: &'a SpectrumRecording<'a>,
    family: &'a LeverFamily,
    opens_when: OpensWhen,
    scatter: Scatter,
    /// Strongest opening acceleration of any reading [m/s²].
    largest_m_s2: f64,
    /// Acceleration above which no lever on a rigid stop lifts off [m/s²].
    never_lifting_m_s2: f64,
    /// Edges of the windows, descending [m/s²].
    edges_m_s2: Vec<f64>,
    work: Meter,
}

impl<'a> Levers<'a> {
    fn new(
        recording: &'a SpectrumRecording<'a>,
        family: &'a LeverFamily,
        opens_when: OpensWhen,
        (least_m_s2, top_times): (f64, f64),
    ) -> Result<Self, Error> {
        let bias_error_m_s2 = recording.conditioned.bias_standard_error_m_s2;
        let seed = recording.options.seed;
        let scatter = Scatter::new(&family.design, bias_error_m_s2, seed)?;
        let sign = family.opening_sign(opens_when);
        // Samples after a fault count for nothing.
        let last = recording.window.map_or(usize::MAX, |(_, last)| last);
        let strongest = |sign: f64| {
            let highest = move |range: &Range| if sign > 0.0 { range.high } else { -range.low };
            let of_reading = |reading: &Reading<'_>| {
                let ranges = reading.ranges();
                ranges.iter().take(last).map(highest).fold(0.0, f64::max)
            };
            recording
                .readings
                .iter()
                .map(of_reading)
                .fold(0.0, f64::max)
        };
        let largest = strongest(sign);
        let loosest = scatter.loosest(-sign);
        let either_g = largest.max(strongest(-sign)) / STANDARD_GRAVITY;
        let floor_g = FLOOR_PART * either_g;
        let least_g = Some(least_m_s2 / STANDARD_GRAVITY).filter(|least| *least > 0.0);
        let edges_g = match either_g > 0.0 {
            true => preferred(
                least_g.map_or(floor_g, |least| floor_g.min(least)),
                top_times * either_g,
            ),
            false => Vec::new(),
        };
        let edges = edges_g.iter().rev();
        Ok(Self {
            recording,
            family,
            opens_when,
            scatter,
            largest_m_s2: largest,
            never_lifting_m_s2: loosest.scale * largest + loosest.bias_m_s2.abs(),
            edges_m_s2: edges.map(|edge_g| edge_g * STANDARD_GRAVITY).collect(),
            work: Meter::new(recording.options.work),
        })
    }

    /// Follows the levers of some windows side by side; returns how far they come, and how many they were.
    fn follow(
        &self,
        windows: &[usize],
        control: &Control<'_>,
    ) -> Result<(Vec<Reached>, usize), Error> {
        let mut reached: Vec<Option<Reached>> = vec![None; windows.len()];
        let mut followed = 0;
        for stop in ModelChoice::Auto.stops() {
            let lowest_m_s2 = windows.last().map_or(0.0, |last| self.edges_m_s2[last + 1]);
            let strokes = match !stop.yields() && lowest_m_s2 > self.never_lifting_m_s2 {
                true => vec![vec![0.0; LEVERS]; windows.len()],
                false => {
                    followed += LEVERS * windows.len();
                    self.strokes_m(windows, *stop, control)?
                }
            };
            for (reached, strokes) in reached.iter_mut().zip(strokes) {
                let own = Reached::of(strokes);
                *reached = Some(reached.map_or(own, |before| before.and(own)));
            }
        }
        Ok((reached.into_iter().flatten().collect(), followed))
    }

    /// Returns how far each lever of some windows comes on one stop, window by window [m].
    fn strokes_m(
        &self,
        windows: &[usize],
        stop: StopModel,
        control: &Control<'_>,
    ) -> Result<Vec<Vec<f64>>, Error> {
        let Self {
            recording, family, ..
        } = self;
        let angle_per_stroke = family.angle_per_stroke();
        let (from_m, to_m) = family.strokes_m;
        let rate = recording.conditioned.used.rate;
        let parts = replay::subdivision(rate, &family.design, stop);
        let options = BatchOptions {
            stop,
            opens_when: self.opens_when,
            initial: None,
            projection: Projection::ALIGNED,
            window: recording
                .window
                .map(|(first, last)| (parts * first, parts * last)),
            coast: true,
            asked: AskedPeaks {
                from_rad: angle_per_stroke * from_m,
                to_rad: angle_per_stroke * to_m,
            },
            threshold_rad: f64::INFINITY,
            threads: 1,
        };
        let mut strokes = vec![Vec::with_capacity(LEVERS); windows.len()];
        for (number, reading) in recording.readings.iter().enumerate() {
            control.check()?;
            let own = levers_of(number, recording.readings.len());
            let place = |index: usize| (index / own.len(), own[index % own.len()]);
            let member = |index: usize| {
                let (window, lever) = place(index);
                self.member(windows[window], lever)
            };
            let reading = reading.divided(parts);
            let within = self.work.within_of_members(control);
            let count = own.len() * windows.len();
            let peaks = batch::peaks_within(&reading, count, &member, &options, &within)?;
            self.work.add(peaks.iter().map(|peak| peak.spent).sum());
            for (index, peak) in peaks.iter().enumerate() {
                strokes[place(index).0].push(peak.highest_rad() / angle_per_stroke);
            }
        }
        if self.work.left() == 0 {
            self.work.cut();
        }
        Ok(strokes)
    }

    /// Returns a lever of a window: its lift-off shared out over it, the rest drawn.
    fn member(&self, window: usize, lever: usize) -> Member {
        let number = (window * LEVERS + lever) as u32;
        let seed = self.recording.options.seed;
        let mut member = self.scatter.member(number);
        let (from, to) = (self.edges_m_s2[window + 1], self.edges_m_s2[window]);
        let within = draw::uniform(seed, number, STREAM_OF_LIFT_OFF);
        let part = (lever as f64 + within) / LEVERS as f64;
        let lift_off_m_s2 = from * libm::pow(to / from, part);
        member.lever.preload_torque_nm = lift_off_m_s2 * member.lever.unbalance_kg_m();
        if let Some((from, to)) = self.family.even_restitution {
            let place = draw::uniform(seed, number, STREAM_OF_RESTITUTION);
            let Design { lever, stop, .. } = &self.family.design;
            member.stop.restitution = from + place * (to - from);
            member.stop.follow_restitution(stop, lever);
        }
        member
    }
}

/// Returns the levers of a window that see one of some readings: spread over the window, whose lift-off rises from
/// lever to lever.
fn levers_of(reading: usize, readings: usize) -> Vec<usize> {
    (reading..LEVERS).step_by(readings).collect()
}

#[cfg(test)]
mod tests {
    use super::{LEVERS, READINGS, levers_of, strokes_m};

    #[test]
    fn verif_every_reading_has_levers_all_over_the_window() {
        let mut seen = Vec::new();
        for reading in 0..READINGS {
            let own = levers_of(reading, READINGS);
            let span = own[own.len() - 1] - own[0];
            assert!(span >= LEVERS * 3 / 4, "reading {reading}: {own:?}");
            seen.extend(own);
        }
        seen.sort_unstable();
        assert!(seen.into_iter().eq(0..LEVERS));
    }

    #[test]
    fn verif_strokes_are_r10_from_1_to_200_mm() {
        let strokes = strokes_m();
        assert_eq!(strokes.len(), 24);
        assert!((strokes[0] - 1e-3).abs() < 1e-15);
        assert!((strokes[23] - 0.2).abs() < 1e-12);
        assert!(
            strokes
                .windows(2)
                .all(|pair| (1.2..1.3).contains(&(pair[1] / pair[0])))
        );
    }
}
