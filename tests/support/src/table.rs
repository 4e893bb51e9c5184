//! Tables and signals of `signals/` as arguments.

use latchgate_kernel::pulse::Pulse;

/// The path of a recording of `signals/`.
pub fn signal_file(name: &str) -> String {
    let path = super::root().join("signals").join(name);
    path.to_str().unwrap().to_string()
}

/// A table at 10 kHz from −50 ms to 250 ms whose acceleration [g] is `of(t)`.
pub fn table(of: impl Fn(f64) -> f64) -> String {
    let mut text = String::from("time_s,acc_y_g\n");
    for index in -500..=2500 {
        let time = f64::from(index) / 10_000.0;
        text.push_str(&format!("{time:.4},{:.6}\n", of(time)));
    }
    text
}

/// Half a sine of `peak` [g] from `start` on, `length` long [s]; 0 elsewhere.
pub fn half_sine(time: f64, start: f64, length: f64, peak: f64) -> f64 {
    let duration_s = length;
    Pulse::HalfSine { peak, duration_s }.at(time - start)
}

/// A pulse that the paper's lever survives if a negative acceleration opens it, a push of 2.2 m/s
/// that holds the lever, as a crash has one, and noise that keeps the samples from standing still.
pub fn weak(time: f64) -> f64 {
    half_sine(time, 0.0, 0.005, -5.0)
        + half_sine(time, 0.01, 0.06, 6.0)
        + 0.01 * (time * 9_100.0).sin()
}
