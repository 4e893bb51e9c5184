//! The lever and what replays it: the numeric part of latchgate, a package of its own.
//!
//! It is compiled as one unit, so that its loops are optimised as a whole; the package that reads, judges and
//! reports is compiled in many at once and leaves that out. Its modules are those of `latchgate`, which
//! exports them under the same names.

pub mod error;
pub mod setting;
pub mod units;

// In reading order.

pub mod parallel;

pub mod numerics;

pub mod model;

pub mod signal;

pub mod replay;
