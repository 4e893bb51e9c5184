//! latchgate replays a measured lateral crash acceleration through a model of a
//! vehicle's door-latch lever and says, with evidence, whether the door stays shut.
//!
//! [`replay`] asks in one breath. [`pipeline`] is the face of the library: a [`Request`](pipeline::Request) is the question, a
//! [`Prepared`](pipeline::Prepared) recording is read and conditioned once and judged with as many
//! designs as one likes, and every answer is a [`Document`](pipeline::Document) that can be
//! written, read back and verified. Names there keep their meaning from version to version; the
//! crates below it (`latchgate-kernel`, `-recording`, `-verdict`, `-document`, `-report`, `-study`)
//! are the parts it is made of and may change with any commit.
//!
//! The lever model is that of Warmiński, Mitura and Jankowski, "Regular and chaotic
//! vibrations of a preloaded pendulum system": a lever pressed against a stop by a
//! preloaded spring, excited by the lateral acceleration of its base.
//!
//! # Examples
//!
//! A recording on disk, judged with the paper's lever:
//!
//! ```
//! let outcome = latchgate::replay("signals/surviving.csv").judge()?;
//! let document = &outcome.document;
//! assert_eq!(document.verdict.name(), "pass");
//! assert_eq!(document.verdict.exit_code(), 0);
//! assert_eq!(document.report_id.len(), 64);
//! # Ok::<(), latchgate::pipeline::Error>(())
//! ```

pub mod gate;
pub mod pipeline;
mod replay;

pub use replay::{Replay, replay};

#[doc(hidden)]
pub use latchgate_document as document;
#[doc(hidden)]
pub use latchgate_report as report;

#[doc(hidden)]
pub mod cli;

/// The examples of the README, compiled with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
