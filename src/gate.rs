//! Gates: every recording of a list judged with every design of another, one answer, one exit code.
//!
//! What cannot be read, matches nothing or was not judged is never taken for a pass.
//!
//! - `block`: a block of the store's files, and its head, which tells what it is of;
//! - `collect`: what a store holds of all shares, and all of it as one summary;
//! - `columns`: decisions as arrays for NumPy;
//! - `file`: the words of a gate file;
//! - `files`: the files of a gate, written whole or not at all;
//! - `index`: what a store holds of shares, from the heads of its blocks;
//! - `init`: a first gate file, from what a folder holds;
//! - `plan`: the words made plain: recordings in order, designs by name, what is required of each
//!   pair;
//! - `question`: the keys under which a share's decisions are kept;
//! - `share`: the share of one process of a gate that many processes judge;
//! - `submission`: what a gate was when its shares were submitted;
//! - `store`: decisions that were made before, and those made now, kept for the next run;
//! - `pairs`: the pairs of a gate, read from the store when they are wanted;
//! - `run`: the decisions of all pairs;
//! - `baseline`: what changed since another summary;
//! - `rule`: the decisions held against what is required;
//! - `summary`: what became of each pair and of the whole; the document of a gate;
//! - `text`, `junit`, `markdown`, `page`: the summary for terminals, CI and browsers;
//! - `schema`: the words of a gate file for editors.

pub mod baseline;
mod block;
pub mod collect;
pub mod columns;
pub mod file;
pub mod files;
mod index;
pub mod init;
pub mod junit;
pub mod markdown;
pub mod page;
pub mod pairs;
pub mod plan;
mod question;
pub mod rule;
pub mod run;
pub mod schema;
pub mod share;
pub mod store;
mod submission;
pub mod summary;
pub mod text;

pub use baseline::Baseline;
pub use collect::{Collection, Standing};
pub use columns::Columns;
pub use file::GateFile;
pub use index::Share;
pub use pairs::{PairStanding, Pairs};
pub use plan::Plan;
pub use rule::{Asked, hold};
pub use run::{JudgedRecording, run};
pub use share::{ShareOutcome, ShareTask, judge_pair, judge_share, note_end};
pub use store::FOLDER as STORE_FOLDER;
pub use store::Store;
pub use submission::Submission;
pub use summary::GateSummary;
