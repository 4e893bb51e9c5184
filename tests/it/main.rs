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
mod batch;
mod between;
mod bounds;
mod catch;
mod catch_verdicts;
mod cells;
mod circles;
mod cli;
mod coast;
mod conditioning;
mod conditioning_cfc;
mod conditioning_quality;
mod conditioning_resample;
mod conditioning_spectrum;
mod csv;
mod damages;
mod ev5;
mod exports;
mod fan;
mod format_pages;
mod fuzzed;
mod gate;
mod golden;
mod gravity;
mod harmonic;
mod in_plane;
mod in_plane_verdicts;
mod ingest_agreement;
mod inspect;
mod interpolation;
mod known_cases;
mod limits;
mod lvm;
mod margin;
mod margin_cli;
mod mcap;
mod mcap_encodings;
mod methods;
mod mme;
mod oracle;
mod orbit;
mod pictures;
mod pipeline;
mod polynomial;
mod preambles;
mod pulse_words;
mod pulses;
mod recordings;
mod reference;
mod remark_words;
mod remarks;
mod replay;
mod replay_failures;
mod replay_properties;
mod report;
mod same_answers;
mod setting_decides;
mod shown;
mod signals;
mod sines;
mod slow_channels;
mod statements;
mod statics;
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
mod verdict;
mod verify_cli;
mod words;
mod work;
mod workbook;
