//! What is timed: recordings, levers and options, the same for every program in `benches/`.

use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::batch::{AskedPeaks, BatchOptions, Member, SensorView};
use latchgate_kernel::replay::{Method, RunOptions};
use latchgate_kernel::signal::{Projection, Signal};
use latchgate_kernel::units::OpensWhen;
use latchgate_study::cases;

/// What one g is in the scenes [m/s²].
const GRAVITY: f64 = 9.81;

/// Levers of a batch.
pub const LEVERS: usize = 1000;

/// Returns the recording of 0.3 s (10 kHz, near 200 g) of the study of error against cost,
/// `scale` times as strong.
pub fn recording(scale: f64) -> Signal {
    cases::recording(scale * GRAVITY)
        .expect("the rate is valid")
        .signal()
        .expect("it is a recording")
        .clone()
}

/// Scale at which the lever chatters through most of the recording.
pub const CHATTER: f64 = 0.05;

/// Scale at which it never leaves the stop.
pub const QUIET: f64 = 0.004;

/// Returns the options of a run by `method` without an error statement: what another program
/// is compared with makes none either.
pub fn plain(stop: StopModel, method: Method) -> RunOptions {
    let mut options = RunOptions::new(stop, OpensWhen::Negative);
    options.method = method;
    options.error_bound = false;
    options
}

/// Returns the options of the paper's Runge-Kutta run at the paper's step of 1/30 000 s, three
/// to a sample of 10 kHz.
pub fn as_in_the_paper(stop: StopModel) -> RunOptions {
    let mut options = plain(
        stop,
        Method::Rk4 {
            steps_per_period: 10_000,
        },
    );
    options.step_s = Some(1.0 / 30_000.0);
    options
}

/// Returns lever `index` of a grid of 40 preloads and 25 spring stiffnesses, each from half to
/// twice the reference.
pub fn lever(index: usize) -> Member {
    let design = Design::reference();
    let (column, row) = (index % 40, index / 40 % 25);
    let mut lever = design.lever;
    lever.preload_torque_nm *= 0.5 + 1.5 * column as f64 / 40.0;
    lever.spring_stiffness_nm_per_rad *= 0.5 + 1.5 * row as f64 / 25.0;
    Member {
        lever,
        stop: design.stop,
        scale: 1.0,
        bias_m_s2: 0.0,
        second: SensorView::default(),
        catch: None,
    }
}

/// Returns the options of a batch on `threads` threads that asks for peaks alone.
pub fn peaks_only(stop: StopModel, threads: usize) -> BatchOptions {
    BatchOptions {
        stop,
        projection: Projection::ALIGNED,
        opens_when: OpensWhen::Negative,
        initial: None,
        window: None,
        coast: false,
        asked: AskedPeaks::ALL,
        threshold_rad: f64::INFINITY,
        threads,
    }
}
