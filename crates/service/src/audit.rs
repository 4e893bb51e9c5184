//! Log of what people did: sign-in, tokens made and revoked, deletions, refusals. Its lines have the target
//! `audit` and are logged at any level.

use std::fmt::Display;

/// Target of the lines in the log.
pub const TARGET: &str = "audit";

/// Records that `who` did `what` with the thing named `which`, from an address or by the command line. None of
/// them may contain a secret, a query or a header.
pub fn record(what: &str, which: &str, who: &str, from: impl Display) {
    tracing::info!(target: TARGET, what, which, who, %from, "audit");
}
