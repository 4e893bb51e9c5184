//! latchgate replays a measured lateral crash acceleration through a model of a
//! vehicle's door-latch lever and says, with evidence, whether the door stays shut.
//!
//! The modules follow the one line of the program, in reading order:
//! recording → channel → conditioned signal → replay → verdict → report.
//!
//! The lever model is that of Warmiński, Mitura and Jankowski, "Regular and chaotic
//! vibrations of a preloaded pendulum system": a lever pressed against a stop by a
//! preloaded spring, excited by the lateral acceleration of its base.

pub mod error;
pub mod parallel;
pub mod setting;
pub mod units;

pub mod recording;

pub mod conditioning;

pub mod numerics;

pub mod model;

pub mod replay;

pub mod study;

pub mod verdict;

pub mod margin;

pub mod request;

pub mod report;

pub mod pipeline;

pub mod cli;

/// The examples of the README, compiled with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
