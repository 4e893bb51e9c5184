//! The lever of latchgate and what replays it.
//!
//! A state of two numbers, angle and angular velocity, follows a sampled or a periodic acceleration of its
//! base, on a rigid or a soft stop. Everything is plain SI; nothing here reads a file, prints or looks at a
//! clock. The crate is compiled as one unit, so that its loops are optimised as a whole.

pub mod error;
pub mod range;
pub mod units;

// In reading order.

pub mod parallel;

pub mod numerics;

pub mod model;

pub mod signal;

pub mod pulse;

pub mod replay;
