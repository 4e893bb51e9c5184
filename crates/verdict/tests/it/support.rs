//! What tests of the verdict share, with what the tests of all crates share.

use latchgate_kernel::signal::Signal;
use latchgate_verdict::conditioning::{Conditioned, FilterStandard, Noise};

pub(crate) use latchgate_test_support::*;

/// A recording to which nothing is done, of samples without noise.
pub(crate) fn unconditioned(signal: &Signal) -> Conditioned {
    Conditioned {
        raw: signal.clone(),
        used: signal.clone(),
        formula: None,
        bias_m_s2: 0.0,
        bias_standard_error_m_s2: 0.0,
        bias_samples: 0,
        bias_window_s: None,
        noise: Noise::default(),
        filter: None,
        filter_standard: FilterStandard::Iso6487,
        resample_hz: None,
        velocity_change_m_s: 0.0,
        second: None,
        neighbours: Vec::new(),
        slow_clock: None,
        axis: None,
        findings: Vec::new(),
    }
}
