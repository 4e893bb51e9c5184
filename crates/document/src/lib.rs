//! Question and answer as data: what is asked of a recording, and what came of it.
//!
//! A [`Request`] and a design are the question; a [`Document`] is the answer, a [`MarginDocument`] that of a
//! margin. Nothing here reads a recording, integrates or draws: whoever stores, compares or shows answers
//! needs no more than this crate.
//!
//! - `request`: settings, by the names that options, keys and form fields share;
//! - `design_file`: designs from TOML, and overrides of their numbers;
//! - `blocks`: the document of a verdict, block by block; `margin_document`: that of a margin; `static_document`: that of static thresholds; `spectrum_document`: that of latch response spectra;
//! - `json`: documents as JSON; `number`: numbers as people read them;
//! - `identity`: `report_id`, the hash that names a question.

pub mod blocks;
pub mod design_document;
pub mod design_file;
pub mod identity;
pub mod json;
pub mod margin_document;
pub mod number;
pub mod request;
pub mod spectrum_document;
pub mod static_document;

pub use blocks::Document;
pub use margin_document::MarginDocument;
pub use request::{MarginRequest, PolaritySource, Request};
pub use spectrum_document::SpectrumDocument;
