//! The curve of one push from rest: the lift-off that a lever without spring and without bounces needs.

use latchgate_kernel::signal::Signal;

/// Instants of a record between which pushes are sought, about.
const INSTANTS: usize = 2_000;

/// Returns, for each stroke [m], the largest lift-off [m/s²] at which one push from rest reaches it:
/// a*(s) = max over τ of 2 (D(τ) − s)/τ², D(τ) being the longest way that the acceleration alone pushes in a time τ;
/// 0 where no push does. `sign` is that of the recorded acceleration that opens.
///
/// It leaves out bounces, which may open a lever above it, and the spring: it bounds nothing.
pub(super) fn single_push(signal: &Signal, sign: f64, strokes_m: &[f64]) -> Vec<f64> {
    let interval_s = signal.rate.interval().seconds();
    // Velocity and way of a free mass at each sample, by the trapezoidal rule.
    let (mut velocity, mut way) = (0.0, 0.0);
    let mut before: Option<f64> = None;
    let mut path = Vec::with_capacity(signal.samples.len());
    for sample in &signal.samples {
        let acceleration = sign * sample;
        if let Some(last) = before {
            let change = 0.5 * (last + acceleration) * interval_s;
            way += (velocity + 0.5 * change) * interval_s;
            velocity += change;
        }
        before = Some(acceleration);
        path.push((velocity, way));
    }
    let step = path.len().div_ceil(INSTANTS).max(1);
    let mut needed = vec![0.0_f64; strokes_m.len()];
    for apart in (step..path.len()).step_by(step) {
        let time_s = apart as f64 * interval_s;
        let starts = (0..path.len() - apart).step_by(step);
        let ways = starts.map(|from| {
            let (velocity, way) = path[from];
            path[from + apart].1 - way - velocity * time_s
        });
        let longest = ways.fold(0.0, f64::max);
        for (needed, stroke_m) in needed.iter_mut().zip(strokes_m) {
            *needed = needed.max(2.0 * (longest - stroke_m) / (time_s * time_s));
        }
    }
    needed
}
