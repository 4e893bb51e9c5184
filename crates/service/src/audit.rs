//! What is told of people's doings, for whoever must know later who did what: sign-in, tokens made and
//! taken back, deletions, refusals. The lines have the target `audit` and are logged at any level.

use std::fmt::Display;

/// Target of the lines in the log.
pub const TARGET: &str = "audit";

/// Tells that `who` did something, `what`, with something named `which`, from an address or by the
/// command line. No secret, query or header belongs into any of them.
pub fn record(what: &str, which: &str, who: &str, from: impl Display) {
    tracing::info!(target: TARGET, what, which, who, %from, "audit");
}
