//! Gates: every recording of a list judged with every design of another, one answer, one exit code.
//!
//! What cannot be read, matches nothing or was not judged is never taken for a pass.
//!
//! - `file`: the words of a gate file;
//! - `files`: the files of a gate, written whole or not at all;
//! - `init`: a first gate file, from what a folder holds;
//! - `plan`: the words made plain: recordings in order, designs by name, what is required of each
//!   pair;
//! - `store`: decisions that were made before, and those made now, kept for the next run;
//! - `pairs`: the pairs of a gate, read from the store when they are wanted;
//! - `run`: the decisions of all pairs;
//! - `baseline`: what changed since another summary;
//! - `rule`: the decisions held against what is required;
//! - `summary`: what became of each pair and of the whole; the document of a gate;
//! - `text`, `junit`, `markdown`, `page`: the summary for terminals, CI and browsers;
//! - `schema`: the words of a gate file for editors.

pub mod baseline;
pub mod file;
pub mod files;
pub mod init;
pub mod junit;
pub mod markdown;
pub mod page;
pub mod pairs;
pub mod plan;
pub mod rule;
pub mod run;
pub mod schema;
pub mod store;
pub mod summary;
pub mod text;

pub use baseline::Baseline;
pub use file::GateFile;
pub use pairs::{PairStanding, Pairs};
pub use plan::Plan;
pub use rule::{Asked, hold};
pub use run::{JudgedRecording, run};
pub use store::Store;
pub use summary::GateSummary;
