//! From a question to a document: what every door calls, be it the command line, a gate or a
//! service.
//!
//! [`Prepared::open`] reads and conditions a recording once, as a [`Request`] asks;
//! [`Prepared::judge`] answers for one design after another; [`judge`] does both for one. A
//! recording that cannot be read, or a design that cannot be judged, is answered with a document,
//! too ([`Outcome::refusal`] says why). [`latchgate_report::files`] turns an answer into named bytes.
//! [`inspect`] lists what a recording holds, [`Prepared::margin`] says how far its verdict is from
//! changing, [`verify`] makes the run inside a stored verdict again.
//!
//! Nothing here reads a clock or prints; who calls adds the time it took
//! ([`latchgate_document::blocks::RunBlock::elapsed_s`]).
//!
//! - `prepared`: the recording, read and conditioned once;
//! - `answer`: what was known and found, put together as a document;
//! - `place`: the sensor's place and axis, and what a pass waits for;
//! - `transfer`: every factor between the sensor's place and the latch;
//! - `row`: the decision alone, for gates;
//! - `siblings`: the lateral channels of one side, judged together;
//! - `defaults`: settings that decide, held against the defaults;
//! - `card`: a card to start from;
//! - `candidates`: the channels to choose from where several could be meant;
//! - `inspect`, `margin`, `spectrum`, `statics`, `verify` with `compare`: the other answers.
//!
//! # Examples
//!
//! ```
//! use latchgate::pipeline::{self, Control, Design, Extras, Limits, Request, Source};
//!
//! let table: String = (-200..600)
//!     .map(|k| format!("{},{}\n", f64::from(k) / 1e4, if (0..200).contains(&k) { -30.0 } else { 0.0 }))
//!     .collect();
//! let source = Source::bytes("push.csv", format!("t_s,acc_y_g\n{table}").into_bytes())
//!     .with_card(*b"synthetic = true\nopens_when = \"negative\"\n");
//! let outcome = pipeline::judge(
//!     &source,
//!     &Request::default(),
//!     &Design::reference(),
//!     Extras::default(),
//!     &Limits::default(),
//!     &Control::default(),
//! );
//! assert_eq!(outcome.document.verdict.name(), "fail");
//! ```

mod answer;
mod candidates;
mod card;
mod compare;
mod defaults;
mod inspect;
mod margin;
mod place;
mod prepared;
mod row;
mod siblings;
mod spectrum;
mod statics;
mod transfer;
pub mod verify;

pub use candidates::Offer;
pub use card::card_for;
pub(crate) use card::in_quotes;
pub use compare::{Difference, DifferenceKind};
pub use inspect::{
    ChannelStatus, Choice, ListedChannel, ListedFile, ListedSeries, Listing, inspect, table_mapping,
};
pub use latchgate_document::design_file::{
    apply_override, design_from_bytes, design_from_json, static_from_bytes as static_design,
};
pub use latchgate_document::identity::NUMBERS_REVISION;
pub use latchgate_document::request::words_of;
pub use latchgate_document::spectrum_document::{SpectrumDocument, SpectrumRequest};
pub use latchgate_document::{
    Document, MarginDocument, MarginRequest, PolaritySource, Request, blocks,
};
pub use latchgate_kernel::error::Error as KernelError;
pub use latchgate_kernel::model::Design;
pub use latchgate_kernel::model::parameters::{CATCH_PARAMETERS, PARAMETERS};
pub use latchgate_kernel::model::stop::StopModel;
pub use latchgate_kernel::parallel::Control;
pub use latchgate_kernel::replay::{Method, Run};
pub use latchgate_kernel::units;
pub use latchgate_recording::calendar;
pub use latchgate_recording::card::{AcceptedWord, CardPolarity};
pub use latchgate_recording::csv::TableMapping;
pub use latchgate_recording::error::{Error, ErrorKind};
pub use latchgate_recording::pulse;
pub use latchgate_recording::setting::Setting;
pub use latchgate_recording::{
    Card, Finding, Limits, SensorPlace, Severity, Source, TransferRange, read_within,
};
pub use latchgate_verdict::conditioning::{Between, BiasWindow, Cfc, FilterChoice, FilterStandard};
pub use latchgate_verdict::{Answer, Evidence, ModelChoice, Reason};
pub use margin::{MarginOutcome, margin};
pub use prepared::{Extras, Outcome, Prepared, Refused};
pub use row::DecisionRow;
pub use spectrum::spectrum;
pub use statics::static_document;
pub use verify::{Stored, Verification, VerifiedReport, verify};

/// Reads, conditions, replays and decides: one recording, one design, one document.
///
/// Whoever judges several designs on one recording opens it once with [`Prepared::open`].
pub fn judge(
    source: &Source,
    request: &Request,
    design: &Design,
    extras: Extras,
    limits: &Limits,
    control: &Control<'_>,
) -> Outcome {
    match Prepared::open(source, request, limits, control) {
        Ok(prepared) => prepared.judge(design, extras, control),
        Err(refused) => refused.outcome(design),
    }
}
