//! The parent's side: one child, driven over its pipes under a deadline.

use super::frame;
use super::words::{Answer, Beat, ChildMessage, Enclosed, Enclosure, Order, OrderMessage};
use crate::jail::Jail;
use crate::store::{Blobs, Manifest, StoreError, StoredFile};
use std::fmt;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::PathBuf;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Start and limits of children.
#[derive(Debug, Clone)]
pub struct ChildOptions {
    /// The program, this one.
    pub program: PathBuf,
    /// Memory that a child may map [bytes].
    pub memory_bytes: u64,
    /// Time that an order may take.
    pub order_time: Duration,
    /// Longest silence of a working child.
    pub silence: Duration,
    /// Largest size of the files with one answer [bytes].
    pub answer_bytes: u64,
    /// True if a child may work in an incomplete jail.
    pub without_jail: bool,
}

/// Niceness that a child gains when it decides a pair of a gate: beside a person's question it gets a tenth of the
/// processor.
const PAIR_NICENESS: i32 = 10;

/// An answer whose files are stored.
#[derive(Debug, Clone, PartialEq)]
pub struct Delivered {
    /// The answer.
    pub answer: Answer,
    /// Its files.
    pub files: Vec<StoredFile>,
}

/// Reason why an order has no answer.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Lost {
    /// No child could be started, or it ended before it had its order.
    #[error("no process could be started to read the recording ({reason})")]
    NotStarted {
        /// What the system said.
        reason: String,
    },
    /// The child ended under its order.
    #[error("the process that read the recording ended: {0}")]
    Ended(Ending),
    /// The child took too long and was ended.
    #[error("the process that read the recording took longer than {seconds} s and was ended")]
    Late {
        /// The time it had [s].
        seconds: u64,
    },
    /// The child said what no child says, and was ended.
    #[error("the process that read the recording gave no clear answer ({reason})")]
    Unclear {
        /// What was odd.
        reason: String,
    },
    /// Something could not be stored or read back.
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// End of a child.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// By a signal.
    Signal(i32),
    /// With an exit code.
    Exit(i32),
}

impl Ending {
    /// Returns true if the child ended by its own fault: it exited, or got a signal that a fault raises. Any
    /// other signal was sent: by a person, a supervisor, or a system short of memory.
    pub fn is_own_fault(self) -> bool {
        match self {
            Self::Exit(_) => true,
            Self::Signal(signal) => matches!(
                signal,
                libc::SIGABRT
                    | libc::SIGSEGV
                    | libc::SIGXCPU
                    | libc::SIGBUS
                    | libc::SIGSYS
                    | libc::SIGILL
                    | libc::SIGFPE
            ),
        }
    }
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Signal(signal) => write!(f, "signal {signal}{}", meaning(*signal)),
            Self::Exit(code) => write!(f, "exit code {code}"),
        }
    }
}

/// A child that runs.
#[derive(Debug)]
struct Running {
    process: Arc<Mutex<Child>>,
    input: BufWriter<ChildStdin>,
    output: BufReader<ChildStdout>,
    holds: Vec<String>,
    /// True if it was told to stand back from other processes.
    is_nice: bool,
}

impl Running {
    /// Has the system prefer other processes; where it refuses, the child works as all others do.
    fn stand_back(&mut self) {
        let id = i32::try_from(locked(&self.process).id()).ok();
        let id = id.and_then(rustix::process::Pid::from_raw);
        let told = id.map(|id| {
            let niceness = rustix::process::getpriority_process(Some(id))?;
            rustix::process::setpriority_process(Some(id), niceness + PAIR_NICENESS)
        });
        self.is_nice = told.is_some_and(|told| told.is_ok());
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let mut process = locked(&self.process);
        let _ = process.kill();
        let _ = process.wait();
    }
}

/// A place for one child, started when there is something to do.
#[derive(Debug)]
pub struct Slot {
    options: ChildOptions,
    running: Option<Running>,
    failed_to_start: bool,
    watchdog: Watchdog,
}

impl Slot {
    /// Makes a place.
    ///
    /// # Errors
    ///
    /// [`io::Error`] if no thread can be had.
    pub fn new(options: ChildOptions) -> io::Result<Self> {
        Ok(Self {
            options,
            running: None,
            failed_to_start: false,
            watchdog: Watchdog::new()?,
        })
    }

    /// Returns true if the child holds a recording.
    pub fn holds(&self, id: &str) -> bool {
        let holds = |running: &Running| running.holds.iter().any(|held| held == id);
        self.running.as_ref().is_some_and(holds)
    }

    /// Returns true if no child could be started for the last order.
    pub fn failed_to_start(&self) -> bool {
        self.failed_to_start
    }

    /// Starts a child if none runs; returns the jail of a new one.
    ///
    /// # Errors
    ///
    /// [`Lost`] if it cannot be started.
    pub fn start(&mut self) -> Result<Option<Jail>, Lost> {
        if let Some(running) = &self.running
            && matches!(locked(&running.process).try_wait(), Ok(None))
        {
            return Ok(None);
        }
        self.running = None;
        let mut running = spawn(&self.options).map_err(|error| Lost::NotStarted {
            reason: error.to_string(),
        })?;
        let late = self.watchdog.guard(&running.process, self.options.silence);
        let greeting = frame::read::<ChildMessage>(&mut running.output);
        self.watchdog.leave();
        match greeting {
            Ok(Some(ChildMessage::Hello { jail }))
                if !jail.is_whole() && !self.options.without_jail =>
            {
                Err(Lost::NotStarted {
                    reason: format!(
                        "its jail lacks {}; a kernel with Landlock and seccomp gives it, and \
                         --without-jail does without",
                        jail.lacking.join("; ")
                    ),
                })
            }
            Ok(Some(ChildMessage::Hello { jail })) => {
                self.running = Some(running);
                Ok(Some(jail))
            }
            Ok(Some(_)) => Err(Lost::NotStarted {
                reason: "it did not greet".into(),
            }),
            // The child has no order yet, so its end is no fault of a recording.
            Ok(None) | Err(_) => Err(Lost::NotStarted {
                reason: self.end_of(running, &late).to_string(),
            }),
        }
    }

    /// Sends an order and waits for its answer, whose files go into `blobs`. `beat` is called with each beat.
    ///
    /// # Errors
    ///
    /// [`Lost`]: the child is gone, and the next order starts another.
    pub fn order(
        &mut self,
        order: &Order,
        manifest: Option<&Manifest>,
        blobs: &dyn Blobs,
        beat: &mut dyn FnMut(Beat),
    ) -> Result<Delivered, Lost> {
        let stands_back = order.stands_back();
        if !stands_back {
            // What stands back cannot come forward again without a privilege, so another child takes the order.
            drop(self.running.take_if(|running| running.is_nice));
        }
        let started = self.start();
        self.failed_to_start = started.is_err();
        started?;
        let Some(mut running) = self.running.take() else {
            return Err(Lost::NotStarted {
                reason: "it ended at once".into(),
            });
        };
        if stands_back && !running.is_nice {
            running.stand_back();
        }
        let needed = manifest.filter(|_| {
            let id = order.needs().unwrap_or("");
            !running.holds.iter().any(|held_id| held_id == id)
        });
        // If a file is damaged, nothing was sent to the child yet, so it can stay.
        let files = match needed.map(|manifest| opened(manifest, blobs)).transpose() {
            Ok(files) => files,
            Err(error) => {
                self.running = Some(running);
                return Err(error.into());
            }
        };
        let late = self.watchdog.guard(&running.process, self.options.silence);
        let message = OrderMessage {
            order: order.clone(),
            enclosed: needed.map(enclosure),
            cpu_s: self.options.order_time.as_secs(),
        };
        let outcome = tell(&mut running, &message, files)
            .map_err(NoAnswer::from)
            .and_then(|()| self.listen(&mut running, blobs, beat));
        self.watchdog.leave();
        match outcome {
            Ok(delivered) => {
                self.running = Some(running);
                Ok(delivered)
            }
            Err(NoAnswer::Store(error)) => Err(error.into()),
            Err(NoAnswer::Odd(reason)) => Err(Lost::Unclear { reason }),
            Err(NoAnswer::Nothing) => Err(self.end_of(running, &late)),
        }
    }

    /// Reads the child's messages up to its answer.
    fn listen(
        &mut self,
        running: &mut Running,
        blobs: &dyn Blobs,
        beat: &mut dyn FnMut(Beat),
    ) -> Result<Delivered, NoAnswer> {
        let until = Instant::now() + self.options.order_time;
        loop {
            match frame::read::<ChildMessage>(&mut running.output)? {
                None => return Err(NoAnswer::Nothing),
                Some(ChildMessage::Hello { .. }) => {
                    return Err(NoAnswer::Odd("a second greeting".into()));
                }
                Some(ChildMessage::Beat(signs)) => {
                    let time_left = until.saturating_duration_since(Instant::now());
                    self.watchdog
                        .guard_again(time_left.min(self.options.silence));
                    beat(signs);
                }
                Some(ChildMessage::Answer {
                    answer,
                    files,
                    holds,
                }) => {
                    let files = self.take_files(running, files, blobs)?;
                    running.holds = holds;
                    return Ok(Delivered { answer, files });
                }
            }
        }
    }

    fn take_files(
        &self,
        running: &mut Running,
        files: Vec<Enclosed>,
        blobs: &dyn Blobs,
    ) -> Result<Vec<StoredFile>, NoAnswer> {
        let total = files
            .iter()
            .fold(0_u64, |sum, file| sum.saturating_add(file.bytes));
        if total > self.options.answer_bytes || files.len() > 64 {
            return Err(NoAnswer::Odd(format!(
                "{} files of {total} bytes, at most {}",
                files.len(),
                self.options.answer_bytes
            )));
        }
        let mut stored = Vec::with_capacity(files.len());
        for file in files {
            if !is_plain(&file.name) {
                return Err(NoAnswer::Odd("a file without a plain name".into()));
            }
            let mut writer = blobs.begin().map_err(NoAnswer::Store)?;
            let mut failed = None;
            frame::copy(&mut running.output, file.bytes, |piece| {
                // The remaining bytes are read all the same, so that the next message begins at its start.
                if failed.is_none() {
                    failed = writer.write(piece).err();
                }
                Ok(())
            })?;
            match failed {
                Some(error) => return Err(NoAnswer::Store(error)),
                None => stored.push(writer.finish(&file.name).map_err(NoAnswer::Store)?),
            }
        }
        Ok(stored)
    }

    /// Returns the reason for the end of a child.
    fn end_of(&self, running: Running, late: &AtomicBool) -> Lost {
        let status = {
            let mut process = locked(&running.process);
            // A child whose output has closed ends on its own at once; the pause leaves it time, so that its own
            // exit is seen and not the kill below.
            std::thread::sleep(Duration::from_millis(5));
            if let Ok(Some(status)) = process.try_wait() {
                Ok(status)
            } else {
                let _ = process.kill();
                process.wait()
            }
        };
        if late.load(Ordering::Relaxed) {
            return Lost::Late {
                seconds: self.options.order_time.min(self.options.silence).as_secs(),
            };
        }
        match status {
            Ok(status) => Lost::Ended(match status.signal() {
                Some(signal) => Ending::Signal(signal),
                None => Ending::Exit(status.code().unwrap_or_default()),
            }),
            Err(error) => Lost::Unclear {
                reason: error.to_string(),
            },
        }
    }
}

/// Outcome of listening without an answer.
enum NoAnswer {
    Nothing,
    Odd(String),
    Store(StoreError),
}

impl From<io::Error> for NoAnswer {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe | io::ErrorKind::UnexpectedEof => Self::Nothing,
            _ => Self::Odd(error.to_string()),
        }
    }
}

/// Returns the usual cause of a signal.
fn meaning(signal: i32) -> &'static str {
    match signal {
        libc::SIGABRT => ", as when it needs more memory than it may have",
        libc::SIGKILL => ", as the system sends it when memory is short",
        libc::SIGXCPU => ", more processor time than it may have",
        libc::SIGSEGV => ", as when its stack is used up",
        _ => "",
    }
}

fn is_plain(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_');
    !name.is_empty() && name.len() <= 64 && !name.starts_with('.') && name.chars().all(plain)
}

fn locked(process: &Mutex<Child>) -> std::sync::MutexGuard<'_, Child> {
    process
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
}

fn spawn(options: &ChildOptions) -> io::Result<Running> {
    let mut child = Command::new(&options.program)
        .arg("child")
        .arg(options.memory_bytes.to_string())
        .env_clear()
        .current_dir("/")
        // In a group of its own the child does not get a Ctrl-C or a signal to the service's group; the
        // service lets it finish.
        .process_group(0)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()?;
    let pipes = child.stdin.take().zip(child.stdout.take());
    let (input, output) = pipes.ok_or_else(|| io::Error::other("no pipes"))?;
    Ok(Running {
        process: Arc::new(Mutex::new(child)),
        input: BufWriter::new(input),
        output: BufReader::new(output),
        holds: Vec::new(),
        is_nice: false,
    })
}

fn enclosure(manifest: &Manifest) -> Enclosure {
    let enclosed = |file: &StoredFile| Enclosed {
        name: file.name.clone(),
        bytes: file.bytes,
    };
    Enclosure {
        name: manifest.name.clone(),
        files: manifest.files.iter().map(enclosed).collect(),
        card: manifest.card.as_ref().map(enclosed),
    }
}

/// Opens the files of a recording and checks their hashes, in the order of the enclosure.
fn opened(manifest: &Manifest, blobs: &dyn Blobs) -> Result<Vec<(File, u64)>, StoreError> {
    let files = manifest.files.iter().chain(&manifest.card);
    files
        .map(|file| Ok((blobs.open(&file.sha256)?, file.bytes)))
        .collect()
}

fn tell(
    running: &mut Running,
    message: &OrderMessage,
    files: Option<Vec<(File, u64)>>,
) -> io::Result<()> {
    frame::write(&mut running.input, message)?;
    for (file, bytes) in files.into_iter().flatten() {
        let mut file = file.take(bytes);
        io::copy(&mut file, &mut running.input)?;
    }
    running.input.flush()
}

/// Ends a child that is late.
#[derive(Debug)]
struct Watchdog {
    tell: Sender<Option<Guarded>>,
    guarded: Option<Guarded>,
}

/// A child with its deadline.
#[derive(Debug, Clone)]
struct Guarded {
    until: Instant,
    process: Arc<Mutex<Child>>,
    /// Set if the child was ended at its deadline.
    late: Arc<AtomicBool>,
}

impl Watchdog {
    fn new() -> io::Result<Self> {
        let (tell, watches) = channel();
        std::thread::Builder::new()
            .name("watchdog".into())
            .spawn(move || watch(&watches))?;
        Ok(Self {
            tell,
            guarded: None,
        })
    }

    /// Ends `process` after `time` unless that is changed; returns a mark that is set if it did.
    fn guard(&mut self, process: &Arc<Mutex<Child>>, time: Duration) -> Arc<AtomicBool> {
        let late = Arc::new(AtomicBool::new(false));
        self.guarded = Some(Guarded {
            until: Instant::now(),
            process: Arc::clone(process),
            late: Arc::clone(&late),
        });
        self.guard_again(time);
        late
    }

    fn guard_again(&mut self, time: Duration) {
        if let Some(guarded) = &mut self.guarded {
            guarded.until = Instant::now() + time;
            let _ = self.tell.send(Some(guarded.clone()));
        }
    }

    fn leave(&mut self) {
        self.guarded = None;
        let _ = self.tell.send(None);
    }
}

fn watch(watches: &Receiver<Option<Guarded>>) {
    let mut watched: Option<Guarded> = None;
    loop {
        let next = match &watched {
            None => watches.recv().map_err(|_| RecvTimeoutError::Disconnected),
            Some(Guarded { until, .. }) => {
                watches.recv_timeout(until.saturating_duration_since(Instant::now()))
            }
        };
        match next {
            Ok(next) => watched = next,
            Err(RecvTimeoutError::Disconnected) => return,
            Err(RecvTimeoutError::Timeout) => {
                if let Some(Guarded { process, late, .. }) = watched.take() {
                    late.store(true, Ordering::Relaxed);
                    let _ = locked(&process).kill();
                }
            }
        }
    }
}
