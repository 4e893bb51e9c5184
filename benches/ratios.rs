//! Times of the kernel, of batches and of the paper's method as ratios, measured in turns.
//! Run with `cargo bench --bench ratios`; `benches/peer` adds another program to the same tables.

#![allow(clippy::disallowed_methods, reason = "benches read the clock")]
#![allow(
    missing_docs,
    unreachable_pub,
    clippy::print_stdout,
    reason = "a program that prints tables"
)]

#[path = "support/contest.rs"]
mod contest;
#[path = "support/own.rs"]
mod own;
#[path = "support/scenes.rs"]
#[allow(dead_code, reason = "each program uses a part of it")]
mod scenes;

fn main() {
    // `cargo test --benches` runs this file without the argument, to see that it runs.
    let timed = std::env::args().any(|argument| argument == "--bench");
    own::contest(timed, &|_, _, _| Vec::new());
}
