//! The command line: arguments in, data to stdout, talk to stderr, an exit code out.
//!
//! - `args`: the command line as a whole: options of every command, and the commands;
//! - `compare`: `latchgate compare`: two verdicts side by side, as far as they differ;
//! - `design`: the design that the command line asks for: a file, or the paper's, with overrides;
//! - `failure`: why a command ended without an answer of its own;
//! - `gate`: `latchgate gate`: many recordings and designs, one exit code;
//! - `init`: `latchgate init`: a commented file to start from;
//! - `inputs`: keeps what a command reads from what it writes;
//! - `inspect`: `latchgate inspect`: what a recording holds;
//! - `limits`: `latchgate limits`: every limit on input, with its value and how to change it;
//! - `log`: tracing output: stderr, as text or JSON lines, silent unless asked for;
//! - `manual`: shell completions and manual pages;
//! - `margin`: `latchgate margin`: how far a verdict is from changing, and what design would
//!   change it;
//! - `offers`: what a person may mean where the file does not say it: for each choice the command that takes it;
//! - `options`: options that commands share, and what they ask as data;
//! - `output`: the only place that prints;
//! - `progress`: what a command is doing and how far it has come, on a terminal, and Ctrl-C,
//!   which ends it;
//! - `replay`: `latchgate replay`: one recording, one design, one verdict;
//! - `serve`: `latchgate serve`: the service, a program of its own;
//! - `statics`: `latchgate static`: static thresholds by direction, with the clause that each answers;
//! - `study`: `latchgate study`: one file per study, one line each in [`Study`] and in its
//!   `analysis`;
//! - `values`: values of options that only the command line knows, and how they are read;
//! - `verify`: `latchgate verify`: the run inside a verdict made again, and compared.

#![allow(
    clippy::disallowed_methods,
    reason = "the command line has clock and environment"
)]

pub mod args;
pub mod compare;
mod design;
mod failure;
pub mod gate;
pub mod init;
mod inputs;
mod inspect;
pub mod limits;
mod log;
mod manual;
mod margin;
mod offers;
pub mod options;
mod output;
pub mod pdf;
mod progress;
mod replay;
mod serve;
pub mod statics;
pub mod study;
pub mod values;
mod verify;

pub use output::look_at_stdout;

use args::{Arguments, Command};
use clap::Parser;
use failure::{COULD_NOT, Failure, INTERRUPTED, WRONG_USAGE};
use std::process::ExitCode;

/// Runs the command line of this process.
pub fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            // Help and version are answers, not errors; clap knows which stream is theirs.
            if error.use_stderr() {
                // It repeats words of the command line, file names among them.
                output::talk_plainly(error.render().to_string().trim_end());
                return ExitCode::from(WRONG_USAGE);
            }
            let _ = error.print();
            return ExitCode::SUCCESS;
        }
    };
    if let Err(error) = log::start(&arguments.common) {
        return refuse_usage(&error);
    }
    progress::listen();
    // A console of Windows must be told once that colours come; elsewhere this does nothing.
    anstyle_query::windows::enable_ansi_colors();
    let code = match &arguments.command {
        Command::Replay(own) => replay::command(own, &arguments.common),
        Command::Inspect(own) => inspect::command(own, &arguments.common),
        Command::Margin(own) => margin::command(own, &arguments.common),
        Command::Static(own) => statics::command(own, &arguments.common),
        Command::Gate(own) => gate::command(own, &arguments.common),
        Command::Verify(own) => verify::command(own, &arguments.common),
        Command::Compare(own) => compare::command(own, &arguments.common),
        Command::Study(own) => study::command(&own.study, &arguments.common),
        Command::Init(own) => init::command(own),
        Command::Limits => limits::command(&arguments.common),
        Command::Serve(own) => serve::command(own),
        Command::Completions(own) => manual::completions(own),
        Command::Man(own) => manual::man(own),
    };
    match code {
        Ok(code) => ExitCode::from(code),
        Err(Failure::Usage(error)) => refuse_usage(&error),
        Err(Failure::Data(error)) => {
            output::talk(&format!("latchgate: {error}"));
            ExitCode::from(COULD_NOT)
        }
        Err(Failure::Interrupted) => {
            output::talk(progress::WORD);
            ExitCode::from(INTERRUPTED)
        }
    }
}

fn refuse_usage(error: &latchgate_recording::error::Error) -> ExitCode {
    output::talk(&format!(
        "latchgate: {error}\n\nFor more information, try 'latchgate --help'."
    ));
    ExitCode::from(WRONG_USAGE)
}
