//! The document of latch response spectra: a curve for each recording and direction, their envelope, designs.

use crate::blocks::{ConditioningBlock, RecordingBlock, RunBlock};
use crate::request::Request;
use latchgate_kernel::model::Design;
use latchgate_kernel::units::OpensWhen;
use latchgate_recording::error::Error;
use latchgate_recording::{Finding, TestFacts};
use latchgate_verdict::response_spectrum::plane::Place;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::f64::consts::FRAC_PI_2;

/// What is asked of spectra: how recordings are read and conditioned, and what their levers share.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SpectrumRequest {
    /// How each recording is read and conditioned, in which direction, and the seed.
    pub replay: Request,
    /// Restitution of the stop [-]: one value, or bounds between which it is drawn evenly.
    pub restitution: (f64, f64),
    /// Limit angle [rad].
    pub limit_angle_rad: f64,
    /// Share of the curves that a further curve is to cover [-].
    pub share: Option<f64>,
    /// Go on where a recording has no spectrum.
    pub leave_out_unusable: bool,
}

impl Default for SpectrumRequest {
    fn default() -> Self {
        Self {
            replay: Request::default(),
            restitution: (0.8, 0.8),
            limit_angle_rad: 0.1,
            share: None,
            leave_out_unusable: false,
        }
    }
}

impl SpectrumRequest {
    /// Checks what is beside the settings of a replay.
    ///
    /// # Errors
    ///
    /// [`OutOfRange`](latchgate_kernel::error::Error::OutOfRange) that names the setting.
    pub fn check(&self) -> Result<(), Error> {
        let (from, to) = self.restitution;
        let range = |what: &str, expected: &str, found: String| {
            Err(Error::out_of_range(what, expected, found))
        };
        if !((0.0..=1.0).contains(&from) && (from..=1.0).contains(&to)) {
            let found = format!("{from}..{to}");
            return range("restitution", "0 to 1, the lower bound first", found);
        }
        if !(self.limit_angle_rad > 0.0 && self.limit_angle_rad < FRAC_PI_2) {
            let found = self.limit_angle_rad.to_string();
            return range("limit angle [rad]", "more than 0, less than π/2", found);
        }
        match self.share {
            Some(share) if !(share > 0.0 && share <= 1.0) => range(
                "share of the recordings",
                "more than 0, at most 1",
                share.to_string(),
            ),
            _ => Ok(()),
        }
    }
}

/// `spectrum.json`, key by key.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SpectrumDocument {
    /// `latchgate.spectrum/1`.
    pub schema: Cow<'static, str>,
    /// SHA-256 of the question: recordings, cards, designs and every setting.
    pub report_id: String,
    /// The curves, a recording and a direction each.
    pub recordings: Vec<CurveBlock>,
    /// Recordings without a spectrum, where those are left out.
    pub left_out: Vec<LeftOut>,
    /// Strokes s* = φ* I0/(m L), at each of which the curves have a value [m].
    pub stroke_m: Vec<f64>,
    /// The spectrum of each curve, lift-off a* = T0/(m L) [m/s²]; where every window passes the lowest edge, above
    /// which it is not; `None` of a record of zeros.
    pub spectrum_m_s2: Vec<Vec<Option<f64>>>,
    /// The lower end of its zone [m/s²]; `None` where that is below the lowest window, or without a spectrum.
    pub zone_from_m_s2: Vec<Vec<Option<f64>>>,
    /// One push from rest, without bounces [m/s²].
    pub single_push_m_s2: Vec<Vec<f64>>,
    /// The highest of the curves [m/s²]; pulses by formula stand beside recordings and count without any alone.
    pub envelope_m_s2: Vec<Option<f64>>,
    /// Which curve that is, counted from 0.
    pub envelope_by: Vec<Option<usize>>,
    /// The lowest curve that covers the share of the curves that was asked for [m/s²].
    pub share_m_s2: Option<Vec<Option<f64>>>,
    /// Designs beside the curves.
    pub designs: Vec<DesignPoint>,
    /// What the levers of the curves share.
    pub settings: SpectrumSettings,
    /// What was asked.
    pub request: SpectrumRequest,
    /// Version and time; last.
    pub run: RunBlock,
}

/// One curve: the recording in one direction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CurveBlock {
    /// Name in charts and tables.
    pub name: String,
    /// Sign of the recorded acceleration that opens.
    pub opens_when: OpensWhen,
    /// Axis along which the sensor measures, X, Y or Z; `None` where nothing says.
    pub axis: Option<char>,
    /// Strongest acceleration in that direction [m/s²].
    pub strongest_m_s2: f64,
    /// The lowest window's lower edge [m/s²].
    pub floor_m_s2: Option<f64>,
    /// The last instant that counts, where a fault ends the samples: the curve may lie too low [s].
    pub judged_until_s: Option<f64>,
    /// Median, over the strokes, of the curve over the median of the others of its axis and direction, where that is
    /// far from 1 [-].
    pub times_the_others: Option<f64>,
    /// Levers that were followed.
    pub levers: usize,
    /// What was read.
    pub recording: RecordingBlock,
    /// How it was conditioned.
    pub conditioning: ConditioningBlock,
    /// What file and card say of the test.
    pub test: TestFacts,
    /// Everything odd about the recording.
    pub findings: Vec<Finding>,
}

/// A recording without a spectrum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LeftOut {
    /// File name.
    pub file: String,
    /// Why.
    pub reason: String,
}

/// What the levers of the curves share, and how many there are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SpectrumSettings {
    /// Restitution: bounds, equal where it is one value [-].
    pub restitution: (f64, f64),
    /// Its standard deviation, where it is one value [-].
    pub restitution_deviation: Option<f64>,
    /// Limit angle φ* [rad].
    pub limit_angle_rad: f64,
    /// Spring by inertia, k0/I0 [1/s²].
    pub spring_per_inertia_1_s2: f64,
    /// Damping by inertia, c0/I0 [1/s].
    pub damping_per_inertia_1_s: f64,
    /// Angular frequency of the soft stop in contact [rad/s].
    pub contact_rad_s: f64,
    /// Standard deviation of the recording's scale [-].
    pub scale_deviation: f64,
    /// That of its bias, at least [m/s²].
    pub bias_deviation_m_s2: f64,
    /// Levers followed in a window.
    pub levers: usize,
    /// Of these, how many may open in a window that passes.
    pub opening_allowed: usize,
    /// Of these, how many open at least below the zone.
    pub opening_surely: usize,
    /// Readings of the recording that they share, with noise and between the samples.
    pub readings: usize,
    /// Seed of the draws.
    pub seed: u64,
}

/// Where a design lies to the curves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DesignPoint {
    /// Name of the design.
    pub name: String,
    /// Stroke s* [m].
    pub stroke_m: f64,
    /// Its least and its largest, at three standard deviations [m].
    pub stroke_span_m: (f64, f64),
    /// Lift-off a* = T0/(m L) [m/s²].
    pub liftoff_m_s2: f64,
    /// Its least and its largest, at three standard deviations [m/s²].
    pub liftoff_span_m_s2: (f64, f64),
    /// The lift-off that counts by SAE J839, (T0 + k0 φ*/2)/(m L) [m/s²].
    pub counted_m_s2: f64,
    /// Above, in or below the zone of the curve that asks most of it.
    pub place: Option<Place>,
    /// Which curve that is, counted from 0.
    pub place_by: Option<usize>,
    /// Why it has no place.
    pub reason: Option<String>,
    /// What a person must still say of design and recordings before a pass counts, each as a phrase.
    pub awaits: Vec<String>,
    /// Reserve in load: times which a recording, its noise with it, is the first that does not pass, of the curve
    /// where that is least [-]; `None` with a reason.
    pub reserve_load: Option<f64>,
    /// Why there is none: it does not pass as it is, or passes a hundred times the recording.
    pub reserve_load_reason: Option<String>,
    /// Reserve in preload: 1 less the least preload that passes over its own, of the curve where that is least [-];
    /// negative where more is needed.
    pub reserve_preload: Option<f64>,
    /// Why there is none.
    pub reserve_preload_reason: Option<String>,
    /// Which curve leaves the least reserve in load, counted from 0.
    pub reserve_by: Option<usize>,
    /// The design.
    pub design: Design,
}

/// The highest of some curves.
#[derive(Debug, Clone, PartialEq)]
pub struct Envelope {
    /// Its value at each stroke [m/s²].
    pub values_m_s2: Vec<Option<f64>>,
    /// Which curve makes it.
    pub by: Vec<Option<usize>>,
}

impl Envelope {
    /// Returns the highest of `curves` at each of so many strokes; the first of equals.
    pub fn of(curves: &[Vec<Option<f64>>], strokes: usize) -> Self {
        let highest = |place: usize| {
            let values = curves.iter().enumerate();
            let known = values.filter_map(|(index, curve)| Some((index, curve[place]?)));
            known.reduce(|most, next| if next.1 > most.1 { next } else { most })
        };
        let highest: Vec<Option<(usize, f64)>> = (0..strokes).map(highest).collect();
        Self {
            values_m_s2: highest
                .iter()
                .map(|found| found.map(|(_, value)| value))
                .collect(),
            by: highest
                .iter()
                .map(|found| found.map(|(index, _)| index))
                .collect(),
        }
    }
}

/// Returns, at each stroke, the lowest value that at least `share` of the curves do not exceed; a curve without a
/// value exceeds none.
pub fn covering(curves: &[Vec<Option<f64>>], strokes: usize, share: f64) -> Vec<Option<f64>> {
    let needed = (share * curves.len() as f64 - 1e-9).ceil().max(1.0) as usize;
    let at = |place: usize| {
        let mut values: Vec<Option<f64>> = curves.iter().map(|curve| curve[place]).collect();
        // None is least of all.
        values.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
        values.get(needed - 1).copied().flatten()
    };
    (0..strokes).map(at).collect()
}

/// Times the others from which on a curve lies far from them, and by which part: below what a unit taken for another
/// makes, m/s² for g.
const FAR: f64 = 8.0;

/// Returns, of each curve, the median over the strokes of its value over the median of the others of its `group`, where
/// that is eightfold or an eighth and less; of groups of three curves and more.
pub fn times_the_others<G: PartialEq>(
    curves: &[Vec<Option<f64>>],
    group: impl Fn(usize) -> G,
) -> Vec<Option<f64>> {
    let median = |mut values: Vec<f64>| {
        values.sort_unstable_by(f64::total_cmp);
        values.get(values.len() / 2).copied()
    };
    let of = |index: usize| {
        let is_sister = |other: &usize| *other != index && group(*other) == group(index);
        let sisters: Vec<usize> = (0..curves.len()).filter(is_sister).collect();
        if sisters.len() < 2 {
            return None;
        }
        let others = |place: usize| {
            let values = sisters.iter().filter_map(|other| curves[*other][place]);
            median(values.collect())
        };
        let own = curves[index].iter().enumerate();
        let ratios = own.filter_map(|(place, value)| Some((*value)? / others(place)?));
        median(ratios.collect()).filter(|times| *times >= FAR || *times <= 1.0 / FAR)
    };
    (0..curves.len()).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::{Envelope, covering, times_the_others};

    #[test]
    fn verif_an_envelope_is_the_highest_and_names_it() {
        let curves = [
            vec![Some(1.0), None, Some(3.0)],
            vec![Some(2.0), None, Some(3.0)],
        ];
        let envelope = Envelope::of(&curves, 3);
        assert_eq!(envelope.values_m_s2, [Some(2.0), None, Some(3.0)]);
        assert_eq!(envelope.by, [Some(1), None, Some(0)]);
    }

    #[test]
    fn verif_a_share_of_curves_is_covered_by_the_lowest_that_does() {
        let curves: Vec<Vec<Option<f64>>> = (1..=20).map(|n| vec![Some(f64::from(n))]).collect();
        assert_eq!(covering(&curves, 1, 0.95), [Some(19.0)]);
        assert_eq!(covering(&curves, 1, 0.96), [Some(20.0)]);
        assert_eq!(covering(&curves, 1, 1.0), [Some(20.0)]);
        assert_eq!(covering(&curves, 1, 0.05), [Some(1.0)]);
        // One that every lever survives asks nothing.
        assert_eq!(covering(&[vec![None], vec![Some(2.0)]], 1, 0.5), [None]);
    }

    #[test]
    fn verif_a_curve_far_from_the_others_is_named() {
        let near = |times: f64| vec![Some(10.0 * times), Some(5.0 * times)];
        let curves = [near(1.0), near(1.2), near(0.9), near(9.8)];
        let told = times_the_others(&curves, |_| ());
        assert_eq!(told[..3], [None; 3]);
        assert!(told[3].is_some_and(|times| times > 9.0), "{told:?}");
        assert_eq!(times_the_others(&curves[2..], |_| ()), [None; 2]);
        // By axis and direction: two and two are too few.
        assert_eq!(times_the_others(&curves, |index| index % 2), [None; 4]);
    }
}
