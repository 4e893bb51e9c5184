//! The command line: arguments in, data to stdout, messages to stderr, an exit code out.
//!
//! - `args`: the command line as a whole: options of every command, and the commands;
//! - `clock`: the day of a run;
//! - `compare`: `latchgate compare`: two verdicts side by side, as far as they differ;
//! - `design`: the design of a command line: a file, or the paper's, with overrides;
//! - `failure`: the reasons for which a command ends without an answer;
//! - `gate`: `latchgate gate`: many recordings and designs, one exit code;
//! - `init`: `latchgate init`: a commented file to start from;
//! - `inputs`: protects the files that a command reads from what it writes;
//! - `inspect`: `latchgate inspect`: the channels of a recording;
//! - `limits`: `latchgate limits`: every limit on input, with its value and how to change it;
//! - `log`: tracing output: stderr, as text or JSON lines, off by default;
//! - `manual`: shell completions and manual pages;
//! - `margin`: `latchgate margin`: how far a verdict is from changing, and what design would
//!   change it;
//! - `offers`: the commands to choose from where a file leaves a setting open;
//! - `options`: options that commands share, and the request that they make;
//! - `output`: the only place that prints;
//! - `progress`: a line of progress on a terminal, and Ctrl-C;
//! - `replay`: `latchgate replay`: one recording, one design, one verdict;
//! - `serve`: `latchgate serve`: starts the service, another program;
//! - `spectrum`: `latchgate spectrum`: what any latch must have to survive the recordings;
//! - `statics`: `latchgate static`: static thresholds by direction, with the clause that each answers;
//! - `study`: `latchgate study`: one file per study, one line each in [`Study`] and in its
//!   `analysis`;
//! - `values`: values of options that only the command line has;
//! - `verify`: `latchgate verify`: repeats the run of a verdict and compares.

#![allow(
    clippy::disallowed_methods,
    reason = "the command line has clock and environment"
)]

pub mod args;
pub mod clock;
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
pub mod spectrum;
pub mod statics;
pub mod study;
pub mod values;
mod verify;

pub use output::look_at_stdout;
pub use replay::message;

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
                // The message quotes the command line, whose file names must not steer the terminal.
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
    // A Windows console needs colours switched on; elsewhere this does nothing.
    anstyle_query::windows::enable_ansi_colors();
    let code = match &arguments.command {
        Command::Replay(options) => replay::command(options, &arguments.common),
        Command::Inspect(options) => inspect::command(options, &arguments.common),
        Command::Margin(options) => margin::command(options, &arguments.common),
        Command::Spectrum(options) => spectrum::command(options, &arguments.common),
        Command::Static(options) => statics::command(options, &arguments.common),
        Command::Gate(options) => gate::command(options, &arguments.common),
        Command::Verify(options) => verify::command(options, &arguments.common),
        Command::Compare(options) => compare::command(options, &arguments.common),
        Command::Study(options) => study::command(&options.study, &arguments.common),
        Command::Init(options) => init::command(options),
        Command::Limits => limits::command(&arguments.common),
        Command::Serve(options) => serve::command(options),
        Command::Completions(options) => manual::completions(options),
        Command::Man(options) => manual::man(options),
    };
    match code {
        Ok(code) => ExitCode::from(code),
        Err(Failure::Usage(error)) => refuse_usage(&error),
        Err(Failure::Data(error)) => {
            output::talk(&format!("latchgate: {error}"));
            ExitCode::from(COULD_NOT)
        }
        Err(Failure::Interrupted) => {
            output::talk(progress::INTERRUPTED_MESSAGE);
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
