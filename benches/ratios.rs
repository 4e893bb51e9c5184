//! Times of the kernel, of batches and of the paper's method as ratios, measured in turns.
//! Run with `cargo bench --bench ratios`; `benches/peer` adds another program to the same tables.

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
mod scenes;

use contest::{Table, race};
use latchgate::model::stop::StopModel;

fn main() {
    // `cargo test --benches` runs this file without the argument, to see that it runs.
    let rounds = own::rounds(std::env::args().any(|argument| argument == "--bench"));
    println!("A time is the least of {rounds} rounds; the programs of a table ran in turns.\n");
    for stop in [StopModel::Rigid, StopModel::Soft] {
        let signal = scenes::recording(1.0);
        let truth = own::truth(&signal, stop);
        let mut entries = own::kernel(&signal, stop, &truth);
        entries.push(own::paper(&signal, stop, &truth));
        entries.extend(own::batches(&signal, stop));
        let title = format!("recording of 0.3 s, 10 kHz, 200 g; {} stop", stop.name());
        println!("{}", Table(&title, &race(entries, rounds)));
    }
    for stop in [StopModel::Rigid, StopModel::Soft] {
        let signal = scenes::recording(scenes::CHATTER);
        let truth = own::truth(&signal, stop);
        let mut entries = own::kernel(&signal, stop, &truth);
        entries.extend(own::batches(&signal, stop));
        let title = format!(
            "the same at a twentieth of its strength: chatter; {} stop",
            stop.name()
        );
        println!("{}", Table(&title, &race(entries, rounds)));
    }
}
