//! Gates: every recording of a list judged with every design of another, one answer, one exit code.
//!
//! A recording that cannot be read, a pattern that matches nothing and a pair that was not judged
//! never count as a pass.
//!
//! - `file`: the words of a gate file;
//! - `init`: a first gate file, from the recordings in a folder;
//! - `plan`: the words looked up: recordings in order, designs by name, the required answer of each
//!   pair;
//! - `key`, `question`: the keys under which decisions are kept;
//! - `store`: decisions kept for the next run and for collecting shares;
//! - `run`: the decisions of all pairs;
//! - `share`, `share_task`: one of several equal parts of a gate, and the process that judges it;
//! - `collect`: the shares of a gate as a store holds them;
//! - `pairs`: the pairs of a gate, and their order;
//! - `baseline`: changes since another summary;
//! - `rule`: the decisions compared with the requirements;
//! - `summary`: the document of a gate: each pair, and the answer of all;
//! - `files`: the files of a gate, all written or none;
//! - `text`, `junit`, `markdown`, `page`: the summary for terminals, CI and browsers;
//! - `schema`: the words of a gate file for editors.

pub mod baseline;
pub mod collect;
pub mod file;
pub mod files;
pub mod init;
pub mod junit;
mod key;
pub mod markdown;
pub mod page;
pub mod pairs;
pub mod plan;
mod question;
pub mod rule;
pub mod run;
pub mod schema;
pub mod share;
pub mod share_task;
pub mod store;
pub mod summary;
pub mod text;

pub use baseline::Baseline;
pub use collect::{Collection, SweepStatus};
pub use file::{ERRORS_MAX, GateFile};
pub use pairs::{Pair, PairStanding};
pub use plan::Plan;
pub use rule::{SummaryOptions, summarise};
pub use run::{GateRun, JudgedRecording, run};
pub use share::Share;
pub use share_task::{ShareOutcome, ShareTask, judge_share};
pub use store::FOLDER as STORE_FOLDER;
pub use store::{Store, share_bytes};
pub use summary::GateSummary;
