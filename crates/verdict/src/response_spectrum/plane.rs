//! The place of a design in the plane of stroke and lift-off, with its tolerances.

use super::{LeverFamily, SpectrumRecording};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::parameters::DesignParameter;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::units::OpensWhen;
use latchgate_recording::error::Error;
use serde::{Deserialize, Serialize};

/// Standard deviations to which a design reaches.
const REACH: f64 = 3.0;

/// A design in the plane: a point, and how far its tolerances move it, taken as independent and by their logarithms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanePoint {
    /// Stroke s* = φ* I0/(m L) [m].
    pub stroke_m: f64,
    /// Its least and largest, at three standard deviations [m].
    pub stroke_span_m: (f64, f64),
    /// Lift-off a* = T0/(m L) [m/s²].
    pub lift_off_m_s2: f64,
    /// Its least and largest, at three standard deviations [m/s²].
    pub lift_off_span_m_s2: (f64, f64),
}

impl PlanePoint {
    /// Returns the place of a lever alone; `None` of one beside a catch, whose motion two numbers do not tell.
    pub fn of(design: &Design) -> Option<Self> {
        if design.catch.is_some() {
            return None;
        }
        let lever = &design.lever;
        let stroke_m =
            design.criterion.threshold_rad * lever.moment_of_inertia_kg_m2 / lever.unbalance_kg_m();
        let lift_off_m_s2 = lever.lift_off_acceleration_m_s2();
        let unbalance = ["lever.mass_kg", "lever.center_of_mass_m"];
        let stroke = deviation(design, &["lever.moment_of_inertia_kg_m2"], &unbalance);
        let lift_off = deviation(design, &["lever.preload_torque_nm"], &unbalance);
        Some(Self {
            stroke_m,
            stroke_span_m: span(stroke_m, stroke),
            lift_off_m_s2,
            lift_off_span_m_s2: span(lift_off_m_s2, lift_off),
        })
    }

    /// Returns where all of it lies, by the design's own spring, damping, stops and angles: above the spectrum at its
    /// least, own and largest stroke, below the zone there, or in the zone.
    ///
    /// # Errors
    ///
    /// As [`SpectrumRecording::spectrum_between`].
    pub fn place(
        &self,
        design: &Design,
        recording: &SpectrumRecording<'_>,
        opens_when: OpensWhen,
        control: &Control<'_>,
    ) -> Result<Place, Error> {
        let family = LeverFamily::of_design(design, self.stroke_span_m);
        let (least, largest) = self.stroke_span_m;
        let strokes = [least, self.stroke_m, largest];
        let between = |range| recording.spectrum_between(&family, opens_when, range, control);
        let (low, high) = self.lift_off_span_m_s2;
        let higher = between((low, f64::INFINITY))?;
        // What is cut off after a fault may open it.
        let is_whole = recording.judged_until_s.is_none();
        if is_whole && strokes.iter().all(|stroke_m| higher.passes(*stroke_m)) {
            return Ok(Place::Above);
        }
        let lower = between((0.5 * low, high))?;
        Ok(
            match strokes.iter().all(|stroke_m| lower.surely_opens(*stroke_m)) {
                true => Place::Below,
                false => Place::Zone,
            },
        )
    }
}

/// Where a design with its tolerances lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Place {
    /// Surely opens.
    Below,
    /// Stays or opens by small things.
    Zone,
    /// Stays.
    Above,
}

/// Returns the relative standard deviation of a product or quotient of some numbers of a design [-].
fn deviation(design: &Design, of: &[&str], and: &[&str]) -> f64 {
    let squares = of.iter().chain(and).map(|name| {
        let Some(parameter) = DesignParameter::named(name) else {
            return 0.0;
        };
        let deviation = design.deviation(parameter).unwrap_or(0.0);
        let part = deviation / design.value(parameter).abs();
        if deviation > 0.0 { part * part } else { 0.0 }
    });
    squares.sum::<f64>().sqrt()
}

fn span(value: f64, deviation: f64) -> (f64, f64) {
    let times = libm::exp(REACH * deviation);
    (value / times, value * times)
}

#[cfg(test)]
mod tests {
    use super::PlanePoint;
    use latchgate_kernel::model::Design;

    #[test]
    fn verif_the_papers_lever_has_its_place_by_hand() {
        let point = PlanePoint::of(&Design::reference()).expect("a lever alone");
        // 0.1 · 8.888e-4 / (0.1475 · 0.065), 0.1 / (0.1475 · 0.065).
        assert!((point.stroke_m - 9.270_404_172_099_087e-3).abs() < 1e-15);
        assert!((point.lift_off_m_s2 - 10.430_247_718_383_31).abs() < 1e-12);
        // 5 % of the preload and 2 % of the mass; the stroke by the mass alone.
        let times = libm::exp(3.0 * libm::hypot(0.05, 0.02));
        assert!((point.lift_off_span_m_s2.1 / point.lift_off_m_s2 - times).abs() < 1e-12);
        let times = libm::exp(0.06);
        assert!((point.stroke_m / point.stroke_span_m.0 - times).abs() < 1e-12);
    }
}
