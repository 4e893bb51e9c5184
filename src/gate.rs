//! Gates: every recording of a list judged with every design of another, one answer, one exit code.
//!
//! What cannot be read, matches nothing or was not judged is never taken for a pass.
//!
//! - `file`: the words of a gate file;
//! - `init`: a first gate file, from what a folder holds;
//! - `plan`: the words made plain: recordings in order, designs by name, what is required of each
//!   pair;
//! - `key`, `question`: the keys under which decisions are kept;
//! - `store`: decisions kept for the next run, and for whoever collects them;
//! - `run`: the decisions of all pairs;
//! - `share`, `share_task`: one of several equal parts of a gate, and the process that judges it;
//! - `submission`: what a gate was when its shares were submitted;
//! - `collect`: what a store holds of all shares;
//! - `pairs`: the pairs of a gate, and their order;
//! - `baseline`: what changed since another summary;
//! - `rule`: the decisions held against what is required;
//! - `summary`: what became of each pair and of the whole; the document of a gate;
//! - `files`: the files of a gate, written whole or not at all;
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
mod submission;
pub mod summary;
pub mod text;

pub use baseline::Baseline;
pub use collect::{Collection, Standing};
pub use file::{ERRORS_TOLD, GateFile};
pub use pairs::{Pair, PairStanding};
pub use plan::Plan;
pub use rule::{Asked, hold};
pub use run::{GateRun, JudgedRecording, run};
pub use share::Share;
pub use share_task::{ShareOutcome, ShareTask, judge_pair, judge_share};
pub use store::FOLDER as STORE_FOLDER;
pub use store::{Store, share_bytes};
pub use submission::Submission;
pub use summary::GateSummary;
