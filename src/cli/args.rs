//! The command line as a whole: options of every command, and the commands.

use super::gate::GateArguments;
use super::init::InitArguments;
use super::options::{
    Common, CompareArguments, InspectArguments, MarginArguments, ReplayCommand, VerifyArguments,
};
use super::spectrum::SpectrumArguments;
use super::statics::StaticArguments;
use super::study::Study;
use clap::{Args, Parser, Subcommand};
use std::ffi::OsString;

/// Replays measured crash accelerations through a model of a door-latch lever and shows, with
/// evidence, whether the lever stays or opens.
///
/// Exit codes of replay: 0 pass, 1 fail, 2 wrong usage, 3 undecided, 4 unusable.
#[derive(Debug, Parser)]
#[command(
    name = "latchgate",
    version,
    propagate_version = true,
    max_term_width = 100
)]
pub struct Arguments {
    /// Options of every command.
    #[command(flatten)]
    pub common: Common,
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

/// The most frequent uses of `replay`.
const EXAMPLES_REPLAY: &str = "\
Examples:
  latchgate replay burst.csv
  latchgate replay v07292.EV5 --channel 'DSRF YG' --opens-when negative --open
  latchgate replay signals/*.csv --design latch.toml
  latchgate replay burst.csv --set lever.preload_torque_nm=2.82 --series burst-series.csv";

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Replay recordings: a verdict and a report each
    #[command(after_help = EXAMPLES_REPLAY)]
    Replay(Box<ReplayCommand>),
    /// List channels, rates, units, peaks and findings; judges nothing
    Inspect(InspectArguments),
    /// How far the verdict is from changing, and what design would change it
    ///
    /// Varies one quantity at a time: scale of the recording, preload, unbalance, counterweight,
    /// restitution. The answer states each range. The counterweight is fixed to the lever; one that
    /// only touches it is not covered. With --members 0 the numbers are those of the nominal lever,
    /// else those of the verdict. Exit codes: 0 answered, 2 wrong usage, 4 could not answer, or the
    /// recording has a blocking finding.
    Margin(Box<MarginArguments>),
    /// What any latch must have to survive the recordings: a curve each, and their envelope
    ///
    /// The latch response spectrum: lift-off T0/(m L) over stroke φ* I0/(m L) at which levers of this
    /// restitution stay shut, with the zone in which small things decide. It describes and passes
    /// nothing: a verdict comes from replay. Exit codes: 0 answered, 2 wrong usage, 4 could not
    /// answer, or a recording is unusable.
    Spectrum(Box<SpectrumArguments>),
    /// Static thresholds by direction, with the clause of the regulations that each answers
    ///
    /// The constant acceleration that lifts the lever off, opens it by SAE J839, holds it at the limit
    /// angle, or opens it as a step; along the vehicle's axes where the design states lever.axis and
    /// lever.center_of_mass, and in the worst direction. A linkage of several elements is reduced
    /// first. Exit codes: 0 answered, 2 wrong usage, 4 could not answer.
    Static(StaticArguments),
    /// Judge many recordings with many designs: one summary, JUnit XML, one exit code
    ///
    /// Writes summary.json, junit.xml, summary.md and index.html. Exit codes, over the pairs that
    /// are not as required: 0 none, 1 fail (or a pass where a fail was required), 3 undecided, 4
    /// unusable or could not be done; 2 wrong usage.
    Gate(GateArguments),
    /// Rerun a verdict and compare: same numbers or a clear difference
    ///
    /// The verdict holds the request, the design and the file name. Every key but those of
    /// the run is compared, every number to its last digit. Exit codes: 0 same, 1 different, 4 could not.
    Verify(VerifyArguments),
    /// Show what differs between two to eight verdicts; exit code 0 same, 1 different
    Compare(CompareArguments),
    /// The paper's analyses, accuracy against speed, and where each method fails
    Study(StudyArguments),
    /// Write a commented card, design or gate file to start from; never replaces a file
    Init(InitArguments),
    /// List every limit on input, with its value and how to change it
    Limits,
    /// Serve recordings and verdicts over HTTP, with a web page
    ///
    /// Starts latchgate-serve, which lies beside this program or on the path. All options are
    /// passed to it. Build it: cargo build --release -p latchgate-service
    Serve(ServeArguments),
    /// Print completions for a shell
    Completions(CompletionsArguments),
    /// Print the manual page of latchgate or of one of its commands
    Man(ManArguments),
}

/// Options of `study`.
#[derive(Debug, Clone, Args)]
pub struct StudyArguments {
    /// The study.
    #[command(subcommand)]
    pub study: Study,
}

/// Options of `serve`.
#[derive(Debug, Clone, Args)]
pub struct ServeArguments {
    /// Options and commands of latchgate-serve, for example --listen 127.0.0.1:8420 --data DIR
    #[arg(
        value_name = "SERVICE_OPTIONS",
        trailing_var_arg = true,
        allow_hyphen_values = true
    )]
    pub options: Vec<OsString>,
}

/// Options of `completions`.
#[derive(Debug, Clone, Args)]
pub struct CompletionsArguments {
    /// Shell to complete for
    pub shell: clap_complete::Shell,
}

/// Options of `man`.
#[derive(Debug, Clone, Args)]
pub struct ManArguments {
    /// Command whose page to print, for example study bifurcation [default: latchgate]
    pub command: Vec<String>,
}
