//! The commands of `latchgate-serve`.
//!
//! - `health`: asks a service whether it answers;
//! - `tokens`: tokens, made, listed and taken back;
//! - `upkeep`: backup, restore, and the check of everything that is stored.

mod health;
mod tokens;
mod upkeep;

use crate::app::{App, Parts, Store};
use crate::clock::{now_ms, running_ms};
use crate::config::{Config, Layers};
use crate::pool::{Answer, ChildOptions, Crew, CrewOptions, Lost, Order, Slot, Trial, child_work};
use crate::store::{self, Collected};
use crate::{audit, gate, http};
use clap::{Args, Parser, Subcommand};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use std::fmt::Display;
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tracing_subscriber::filter::Targets;
use tracing_subscriber::layer::{Layer as _, SubscriberExt as _};
use tracing_subscriber::util::SubscriberInitExt as _;

/// Serves latchgate over HTTP: recordings in, verdicts kept, with a page for people.
///
/// Without a command it serves until SIGTERM, which lets work under way end; a second one ends it
/// at once. Whatever was acknowledged survives even kill -9.
#[derive(Debug, Parser)]
#[command(name = "latchgate-serve", version, max_term_width = 100)]
struct Arguments {
    #[command(flatten)]
    common: CommonOptions,
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Args)]
struct CommonOptions {
    /// Address and port, or unix:PATH for a socket [default: 127.0.0.1:8420]
    #[arg(long, global = true, value_name = "ADDRESS:PORT")]
    listen: Option<String>,
    /// Folder of the data [default: $XDG_STATE_HOME/latchgate]
    #[arg(long, global = true, value_name = "DIR")]
    data: Option<String>,
    /// Configuration file [default: $LATCHGATE_SERVE_CONFIG]
    #[arg(long, global = true, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Start where the kernel does not give the whole jail: recordings may then reach more
    #[arg(long, global = true)]
    without_jail: bool,
    /// Any key of the configuration; see `config show`
    #[arg(long, global = true, value_name = "KEY=VALUE")]
    set: Vec<String>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Read and judge what stands on standard input; started by the service alone
    #[command(hide = true)]
    Child {
        /// Memory that it may map [bytes]
        memory_bytes: u64,
    },
    /// Make, list and take back tokens
    #[command(subcommand)]
    Token(tokens::TokenCommand),
    /// Show the configuration
    #[command(subcommand)]
    Config(ConfigCommand),
    /// Try what a child is kept from: files, network, programs, memory, time
    Jail,
    /// Copy everything that is stored into a folder that does not exist, while the service runs
    Backup {
        /// Folder of the copy
        folder: PathBuf,
    },
    /// Take a backup as the data; the folder of the data must not hold any
    Restore {
        /// Folder of the copy
        folder: PathBuf,
    },
    /// Read every row and every file again and compare each with its hash
    Fsck {
        /// Remove files older than a day that no row names, as each start of the service does; not
        /// while it runs
        #[arg(long)]
        collect: bool,
    },
    /// Ask the service that listens at `listen` whether it answers
    Health,
    /// Print the description of the HTTP interface
    Openapi,
}

#[derive(Debug, Subcommand)]
enum ConfigCommand {
    /// Show each key with its value
    Show {
        /// And where it comes from
        #[arg(long)]
        origin: bool,
    },
}

/// Runs the command line of this process.
pub fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { 2 } else { 0 });
        }
    };
    match run(arguments) {
        Ok(code) => code,
        Err(text) => {
            let _ = writeln!(io::stderr(), "latchgate-serve: {text}");
            ExitCode::from(4)
        }
    }
}

fn run(arguments: Arguments) -> Result<ExitCode, String> {
    if let Some(Command::Child { memory_bytes }) = arguments.command {
        // The parent has gone or broken the protocol, so there is no one to report to.
        return Ok(match child_work(memory_bytes) {
            Ok(()) => ExitCode::SUCCESS,
            Err(_) => ExitCode::FAILURE,
        });
    }
    // Files are readable by their owner alone.
    rustix::process::umask(rustix::fs::Mode::from_raw_mode(0o077));
    let layers = layers(&arguments.common)?;
    match arguments.command {
        Some(Command::Config(ConfigCommand::Show { origin })) => show(&layers, origin),
        Some(Command::Openapi) => say(http::openapi().trim_end()),
        None => serve(Config::of(&layers)?),
        Some(command) => upkeep_of(command, &Config::of(&layers)?),
    }
}

fn upkeep_of(command: Command, config: &Config) -> Result<ExitCode, String> {
    match command {
        Command::Token(command) => tokens::run(command, &config.data),
        Command::Jail => trials(config),
        Command::Health => health::ask(&config.listen).and_then(say),
        Command::Backup { folder } => upkeep::backup(&config.data, &folder).and_then(say),
        Command::Restore { folder } => upkeep::restore(&folder, &config.data).and_then(say),
        Command::Fsck { collect } => {
            let check = upkeep::fsck(&config.data)?;
            say(check.text)?;
            if collect {
                say(upkeep::collect(config)?)?;
            }
            Ok(ExitCode::from(if check.is_sound { 0 } else { 4 }))
        }
        _ => Ok(ExitCode::SUCCESS),
    }
}

fn say(text: impl Display) -> Result<ExitCode, String> {
    let mut out = io::stdout().lock();
    let written = writeln!(out, "{text}").and_then(|()| out.flush());
    written.map_err(|error| error.to_string())?;
    Ok(ExitCode::SUCCESS)
}

fn layers(common: &CommonOptions) -> Result<Layers, String> {
    let mut flags = Vec::new();
    for assignment in &common.set {
        let (key, value) = assignment
            .split_once('=')
            .ok_or_else(|| format!("--set takes KEY=VALUE, found `{assignment}`"))?;
        flags.push((key.trim().to_string(), value.trim().to_string()));
    }
    for (name, value) in [("listen", &common.listen), ("data", &common.data)] {
        if let Some(value) = value {
            flags.push((name.into(), value.clone()));
        }
    }
    if common.without_jail {
        flags.push(("without_jail".into(), "true".into()));
    }
    let stated = std::env::var_os("LATCHGATE_SERVE_CONFIG").map(PathBuf::from);
    let file = common.config.clone().or(stated);
    Layers::gather(file.as_deref(), std::env::vars(), &flags)
}

fn show(layers: &Layers, origin: bool) -> Result<ExitCode, String> {
    let lines = layers.entries().map(|(name, value, from)| {
        let from = if origin {
            format!("  # {from}")
        } else {
            String::new()
        };
        format!("{name} = {value:?}{from}")
    });
    say(lines.collect::<Vec<_>>().join("\n"))
}

fn child_options(config: &Config) -> ChildOptions {
    // This is the running program, even if its file on the disk was replaced meanwhile.
    let program = PathBuf::from("/proc/self/exe");
    ChildOptions {
        program,
        memory_bytes: config.child_memory_bytes,
        order_time: config.order_time,
        silence: config.silence,
        answer_bytes: config.answer_bytes,
        without_jail: config.without_jail,
    }
}

fn log(config: &Config) {
    let lines = tracing_subscriber::fmt::layer().with_writer(io::stderr);
    let lines = if config.log_json {
        lines.json().boxed()
    } else {
        lines.boxed()
    };
    let levels = Targets::new()
        .with_default(config.log)
        .with_target(audit::TARGET, tracing::Level::INFO);
    tracing_subscriber::registry()
        .with(lines.with_filter(levels))
        .init();
}

fn serve(config: Config) -> Result<ExitCode, String> {
    log(&config);
    raise_open_files(config.connections)?;
    let store = Store::open(&config)?;
    // This process alone serves the folder, so the holders of these leases are gone.
    let error_text = |error: crate::store::StoreError| error.to_string();
    store
        .ledger
        .reclaim(running_ms(), true)
        .map_err(error_text)?;
    let tokens = store.ledger.tokens().map_err(error_text)?;
    let is_reachable = !config.listen.is_private() || !config.proxies.is_empty();
    if tokens.is_empty() && config.users.is_none() && is_reachable {
        return Err(format!(
            "{} can be reached from elsewhere, and no token exists: make one with `latchgate-serve \
             token create NAME`, state `user_header`, or listen on 127.0.0.1 without `proxies`",
            config.listen
        ));
    }
    let options = CrewOptions {
        child: child_options(&config),
        places: config.places,
    };
    let (ledger, blobs) = (Arc::clone(&store.ledger), Arc::clone(&store.blobs));
    let crew = Crew::start(&options, ledger, blobs)
        .map_err(|error| format!("no child can be started: {error}"))?;
    if !crew.jail().is_whole() {
        let lacking = crew.jail().lacking.join("; ");
        tracing::warn!(%lacking, "the jail of children is not whole");
    }
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .enable_all()
        .max_blocking_threads(64)
        .build()
        .map_err(|error| error.to_string())?;
    let app = App::new(config, store, crew);
    let outcome = runtime.block_on(listen(app));
    runtime.shutdown_timeout(Duration::from_secs(1));
    outcome
}

/// Raises the limit of open files to the need of the connections: two each, one for the client and one for a stored
/// file, and some for connections without a place, ledger, children and log. With fewer, idle connections could
/// take those that starting a child needs.
fn raise_open_files(connections: usize) -> Result<(), String> {
    let needed = (2 * connections + http::SPARE) as u64 + 64;
    let limits = getrlimit(Resource::Nofile);
    let within = |limit: Option<u64>| limit.is_none_or(|limit| limit >= needed);
    if within(limits.current) {
        return Ok(());
    }
    if !within(limits.maximum) {
        let maximum = limits.maximum.unwrap_or_default();
        return Err(format!(
            "{connections} connections need {needed} open files, and this process may have {maximum}: \
             raise that (`ulimit -n`, LimitNOFILE= of systemd), or lower `connections`"
        ));
    }
    let raised = Rlimit {
        current: Some(needed),
        maximum: limits.maximum,
    };
    setrlimit(Resource::Nofile, raised)
        .map_err(|error| format!("{needed} open files cannot be allowed: {error}"))
}

async fn listen(app: App) -> Result<ExitCode, String> {
    let signals = http::EndingSignals::catch().map_err(|error| error.to_string())?;
    let (listener, address) = http::Listener::bind(&app.config.listen).await?;
    let data = app.config.data.display();
    say(format!("latchgate serves {address}, data in {data}"))?;
    tokio::spawn(reclaim(app.clone()));
    tokio::spawn(keep_store(app.clone()));
    tokio::spawn(gate::keep(app.clone()));
    http::serve(app.clone(), listener, signals).await;
    // After this the ledger can be read without its log, for example from a read-only copy.
    if let Err(problem) = app.on_disk(|parts| parts.ledger.settle()).await {
        tracing::warn!(problem = %problem.detail, "the ledger's log stays");
    }
    Ok(ExitCode::SUCCESS)
}

/// Reclaims jobs whose lease has run out, periodically.
async fn reclaim(app: App) {
    loop {
        tokio::time::sleep(Duration::from_secs(5)).await;
        match app
            .on_disk(|parts| parts.ledger.reclaim(running_ms(), false))
            .await
        {
            Ok(0) => {}
            Ok(jobs) => tracing::warn!(jobs, "leases ran out"),
            Err(problem) => tracing::warn!(problem = %problem.detail, "leases cannot be looked at"),
        }
    }
}

/// Largest difference of clock and monotonic time with which recordings are deleted by age.
const CLOCK_DIFFERS: Duration = Duration::from_secs(600);

/// Largest advance of the clock since the last check by an earlier process [ms].
const CLOCK_GONE_MS: i64 = 7 * 86_400_000;

/// Time without deletions by age after a larger advance, in which an operator can notice a wrong clock.
const CLOCK_DOUBTED: Duration = Duration::from_secs(86_400);

/// Removes, at the start and then periodically, the files of deleted recordings, files of earlier processes that no
/// row names, and recordings older than `keep_days`.
async fn keep_store(app: App) {
    let (began, began_ms) = (Instant::now(), now_ms());
    let before = app
        .on_disk(move |parts| parts.ledger.note_upkeep(began_ms))
        .await;
    let is_doubted = match before {
        Ok(Some(before)) => began_ms - before > CLOCK_GONE_MS,
        // Without a record of the last check its distance is unknown.
        _ => true,
    };
    loop {
        {
            let _turn = app.sweeping.lock().await;
            if let Err(problem) = app.on_disk(Parts::sweep).await {
                tracing::warn!(problem = %problem.detail, "files of deleted recordings stay");
            }
        }
        let collecting = app.on_disk(|parts| store::collect(&*parts.ledger, &*parts.blobs));
        match collecting.await {
            Ok(collected) => {
                let Collected { files, bytes, .. } = collected;
                if files > 0 {
                    tracing::info!(files, bytes, "files that no row names were removed");
                }
            }
            Err(problem) => {
                tracing::warn!(problem = %problem.detail, "files that no row names stay");
            }
        }
        tokio::time::sleep(app.config.upkeep).await;
        let now = now_ms();
        if let Err(problem) = app
            .on_disk(move |parts| parts.ledger.note_upkeep(now))
            .await
        {
            tracing::warn!(problem = %problem.detail, "the time of this look was not noted");
        }
        let Some(keep) = app.config.keep else {
            continue;
        };
        if is_doubted && began.elapsed() < CLOCK_DOUBTED {
            tracing::warn!(
                "the clock went far since the last run: nothing is deleted by age for a day"
            );
            continue;
        }
        delete_aged(&app, keep, began.elapsed(), now - began_ms).await;
    }
}

/// Deletes recordings older than `keep`, unless the clock was set since the start: a wrong clock would delete new
/// ones.
async fn delete_aged(app: &App, keep: Duration, passed: Duration, by_clock_ms: i64) {
    let differs_ms = by_clock_ms.abs_diff(passed.as_millis() as i64);
    if u128::from(differs_ms) > CLOCK_DIFFERS.as_millis() {
        tracing::warn!(
            differs_ms,
            "the clock was set: nothing is deleted by age until the next start"
        );
        return;
    }
    let before_ms = now_ms().saturating_sub(keep.as_millis() as i64);
    let deleted = app.on_disk(move |parts| {
        let aged = parts.ledger.aged_recordings(before_ms)?;
        parts.delete(&aged, "latchgate", "keep_days", "the service")
    });
    match deleted.await {
        Ok(0) => {}
        Ok(recordings) => tracing::info!(recordings, "recordings were deleted by age"),
        Err(problem) => {
            tracing::warn!(problem = %problem.detail, "recordings stay beyond their age")
        }
    }
}

/// Has a child run each trial against its jail, and prints the outcomes.
fn trials(config: &Config) -> Result<ExitCode, String> {
    let mut options = child_options(config);
    // The limits make the trials of time end soon and that of 1 GiB of memory fail.
    options.memory_bytes = options.memory_bytes.min(1 << 30);
    options.silence = Duration::from_secs(2);
    let folder = FreshFolder::make()?;
    let blobs = store::BlobFolder::open(&folder.0).map_err(|error| error.to_string())?;
    let mut all_stopped = true;
    for trial in Trial::ALL {
        let mut slot = Slot::new(options.clone()).map_err(|error| error.to_string())?;
        let outcome = slot.order(&Order::Try { trial }, None, &blobs, &mut |_| {});
        let (stopped, how) = match outcome {
            Ok(delivered) => match delivered.answer {
                Answer::Tried { stopped, how } => (stopped, how),
                _ => (false, "no clear answer".into()),
            },
            Err(lost @ (Lost::Ended(_) | Lost::Late { .. })) => (true, lost.to_string()),
            Err(lost) => (false, lost.to_string()),
        };
        all_stopped &= stopped;
        let word = if stopped { "stopped" } else { "NOT STOPPED" };
        say(format!("{trial:?}: {word} ({how})"))?;
    }
    Ok(ExitCode::from(if all_stopped { 0 } else { 4 }))
}

/// A folder that this process made for itself; dropping it removes it. Other users write into the folder of
/// temporary files as well, so a name that exists or can be guessed may be their link.
struct FreshFolder(PathBuf);

impl FreshFolder {
    fn make() -> Result<Self, String> {
        use std::os::unix::fs::DirBuilderExt;
        let mut bits = [0; 16];
        getrandom::fill(&mut bits).map_err(|error| error.to_string())?;
        let name = format!("latchgate-trials-{}", store::Hex(&bits));
        let path = std::env::temp_dir().join(name);
        let made = std::fs::DirBuilder::new().mode(0o700).create(&path);
        made.map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(Self(path))
    }
}

impl Drop for FreshFolder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
