//! One integration-test binary; a module per subject.

#![allow(
    clippy::duplicate_mod,
    reason = "tests share the example's support file"
)]
#![allow(missing_docs, reason = "tests are read, not linked")]
#![allow(
    clippy::unwrap_used,
    clippy::float_cmp,
    clippy::print_stdout,
    clippy::print_stderr,
    clippy::disallowed_methods,
    clippy::disallowed_types,
    reason = "tests may"
)]

mod bad_files_cli;
mod bad_files_csv;
mod bad_files_mcap;
mod catch_verdicts;
mod cells;
mod circles;
mod cli;
mod csv;
mod damages;
mod ev5;
mod exports;
mod format_pages;
mod fuzzed;
mod gate;
mod gravity;
mod in_plane_verdicts;
mod ingest_agreement;
mod inspect;
mod known_cases;
mod limits;
mod lvm;
mod margin_cli;
mod mcap;
mod mcap_encodings;
mod methods;
mod mme;
mod orbit;
mod pipeline;
mod places;
mod preambles;
mod pulse_words;
mod recordings;
mod remark_words;
mod remarks;
mod report;
mod same_answers;
mod scatter;
mod setting_decides;
mod shown;
mod signals;
mod sines;
mod slow_channels;
mod spectrum_cli;
mod statements;
mod statics;
mod status_columns;
mod study;
mod study_parameters;
mod study_scenes;
mod support;
mod sweep;
mod tdms;
mod test_facts;
mod tidy;
mod unlike_crash;
mod unnamed;
mod verdict_cli;
mod verdict_document;
mod verify_cli;
mod words;
mod workbook;
