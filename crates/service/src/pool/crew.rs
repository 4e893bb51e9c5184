//! All places of the pool. Orders of waiting people and jobs of the ledger have a place each that takes nothing else;
//! the others take both by turns.

use super::orders::{HeldFirst, Orders};
use super::slot::{ChildOptions, Delivered, Lost, Slot};
use super::words::{Answer, Beat, FirstAnswer, How, Order, Step};
use crate::auth::NOBODY;
use crate::clock::{now_ms, running_ms};
use crate::jail::Jail;
use crate::problem::Problem;
use crate::store::{Blobs, Job, JobState, Ledger, Manifest, Question, StoreError, StoredResult};
use crate::supply::{Held, Supply};
use axum::http::StatusCode;
use latchgate::pipeline::NUMBERS_REVISION;
use std::collections::{BTreeMap, BTreeSet, HashMap, VecDeque};
use std::io;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tokio::sync::{oneshot, watch};

/// Largest number of attempts of an order that ends its child.
const ATTEMPTS: i64 = 3;

/// Pause of a place that could not start a child.
const START_PAUSE: Duration = Duration::from_millis(500);

/// Lease of a job, renewed by the child's beats.
const LEASE: Duration = Duration::from_secs(30);

/// Time after which an idle place looks for jobs without having been woken.
const LOOK: Duration = Duration::from_millis(500);

/// Largest number of waiting orders; an owner may have as many as are free, half of them if nobody else waits.
pub const WAITING: u64 = 128;

/// Options of the pool.
#[derive(Debug, Clone)]
pub struct CrewOptions {
    /// Start and limits of children.
    pub child: ChildOptions,
    /// Number of places for jobs, the first of them for nothing else; one more is for waiting people alone.
    pub places: usize,
}

/// Progress of a job.
#[derive(Debug, Clone, PartialEq)]
pub struct Progress {
    /// Its state.
    pub state: JobState,
    /// The part that is done, 0 to 1, if known.
    pub part: Option<f64>,
    /// Instant at which a child began with it, while it runs.
    pub began: Option<Instant>,
    /// The step that it is at, while it runs.
    pub step: Option<Step>,
    /// The verdict, where it is known before advice and report.
    pub first_answer: Option<FirstAnswer>,
}

impl From<JobState> for Progress {
    fn from(state: JobState) -> Self {
        Self {
            state,
            part: None,
            began: None,
            step: None,
            first_answer: None,
        }
    }
}

/// An order that waits for a place, with the channel for its answer.
struct WaitingOrder {
    order: Order,
    manifest: Option<Manifest>,
    reply: oneshot::Sender<Result<Delivered, Lost>>,
    /// Its part of the orders that may wait.
    held: Held,
}

/// Counters of the pool.
#[derive(Debug, Default)]
pub struct Counters {
    /// Children that ended under an order.
    pub children_lost: AtomicU64,
    /// Jobs that were answered.
    pub jobs_done: AtomicU64,
    /// Jobs that have no answer.
    pub jobs_refused: AtomicU64,
    /// Total working time of the places [ms].
    pub busy_ms: AtomicU64,
    /// Jobs by verdict, in the order of [`ANSWERS`].
    pub answers: [AtomicU64; ANSWERS.len()],
}

/// Work for one owner.
#[derive(Debug, Clone, Copy, Default)]
pub struct OwnerFigures {
    /// Time of places on orders.
    pub orders: Duration,
    /// Time of places on jobs.
    pub jobs: Duration,
    /// Orders that wait.
    pub waiting: u64,
}

/// Largest number of owners with figures of their own; all others share one name.
const OWNERS: usize = 1000;

/// Number of finished verdicts whose times are kept.
const FINISHED: usize = 100;

/// Verdicts that are counted.
pub const ANSWERS: [&str; 4] = ["pass", "fail", "undecided", "unusable"];

struct Shared {
    ledger: Arc<dyn Ledger>,
    blobs: Arc<dyn Blobs>,
    orders: Mutex<Orders<WaitingOrder>>,
    waiting: Arc<Supply>,
    bell: Condvar,
    /// Number of times the bell rang, changed under the lock of the orders.
    rings: AtomicU64,
    ends: AtomicBool,
    watched: Mutex<HashMap<String, watch::Sender<Progress>>>,
    counters: Counters,
    by_owner: Mutex<BTreeMap<String, OwnerFigures>>,
    /// Kinds of the last verdicts, and the time that each took.
    finished: Mutex<VecDeque<(String, Duration)>>,
}

/// The pool.
pub struct Crew {
    shared: Arc<Shared>,
    threads: Mutex<Vec<JoinHandle<()>>>,
    jail: Jail,
}

impl std::fmt::Debug for Crew {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Crew")
            .field("jail", &self.jail)
            .finish_non_exhaustive()
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Crew {
    /// Starts the pool, with one child that reports the jail that the kernel grants.
    ///
    /// # Errors
    ///
    /// [`io::Error`] if no child or no thread can be started.
    pub fn start(
        options: &CrewOptions,
        ledger: Arc<dyn Ledger>,
        blobs: Arc<dyn Blobs>,
    ) -> io::Result<Self> {
        let mut first = Slot::new(options.child.clone())?;
        let jail = first
            .start()
            .map_err(|lost| io::Error::other(lost.to_string()))?
            .ok_or_else(|| io::Error::other("a child was there before it was started"))?;
        let shared = Arc::new(Shared {
            ledger,
            blobs,
            // One of the places takes jobs alone.
            orders: Mutex::new(Orders::new(options.places)),
            waiting: Supply::new(WAITING),
            bell: Condvar::new(),
            rings: AtomicU64::new(0),
            ends: AtomicBool::new(false),
            watched: Mutex::default(),
            counters: Counters::default(),
            by_owner: Mutex::default(),
            finished: Mutex::default(),
        });
        let mut threads = Vec::new();
        let slots = (0..options.places).map(|_| Slot::new(options.child.clone()));
        for (number, slot) in std::iter::once(Ok(first)).chain(slots).enumerate() {
            let (slot, shared) = (slot?, Arc::clone(&shared));
            let takes = match number {
                0 => Takes::Orders,
                1 => Takes::Jobs,
                _ => Takes::Both,
            };
            let thread = std::thread::Builder::new().name(format!("place-{number}"));
            threads.push(thread.spawn(move || serve(&shared, slot, takes))?);
        }
        Ok(Self {
            shared,
            threads: Mutex::new(threads),
            jail,
        })
    }

    /// Returns the jail of the children.
    pub fn jail(&self) -> &Jail {
        &self.jail
    }

    /// Returns the counters.
    pub fn counters(&self) -> &Counters {
        &self.shared.counters
    }

    /// Returns the figures of each owner.
    pub fn by_owner(&self) -> BTreeMap<String, OwnerFigures> {
        let mut by_owner = locked(&self.shared.by_owner).clone();
        for (owner, count) in locked(&self.shared.orders).waiting() {
            by_owner.entry(owner.into()).or_default().waiting = count;
        }
        by_owner
    }

    /// Has an order carried out while the caller waits, in the turn of its owner.
    ///
    /// # Errors
    ///
    /// A problem: too many wait, or the order ended its child.
    pub async fn ask(
        &self,
        owner: &str,
        order: Order,
        manifest: Option<Manifest>,
    ) -> Result<Delivered, Problem> {
        let (mut faults, mut machine_losses) = (0, 0);
        loop {
            let (reply, replied) = oneshot::channel();
            {
                let mut orders = locked(&self.shared.orders);
                if self.shared.ends.load(Ordering::Relaxed) {
                    let text = "the service is ending; try again";
                    return Err(Problem::busy(StatusCode::SERVICE_UNAVAILABLE, text, 1));
                }
                orders.retain(|waiting| !waiting.reply.is_closed());
                let mut held = self.shared.waiting.open(owner);
                if !held.grow(1) {
                    let found = "more, most of them of this token".into();
                    let status = StatusCode::TOO_MANY_REQUESTS;
                    return Err(Problem::later(status, "waiting", WAITING, found, 1));
                }
                let waiting = WaitingOrder {
                    order: order.clone(),
                    manifest: manifest.clone(),
                    reply,
                    held,
                };
                orders.push(owner, order.needs(), waiting);
            }
            self.shared.ring();
            let lost = match replied.await {
                Ok(Ok(delivered)) => return Ok(delivered),
                Ok(Err(lost)) => lost,
                Err(_) => {
                    let text = "the service is ending; try again";
                    return Err(Problem::busy(StatusCode::SERVICE_UNAVAILABLE, text, 1));
                }
            };
            let again = match Cause::of(&lost) {
                Cause::Recording => {
                    faults += 1;
                    faults < ATTEMPTS
                }
                // A person waits for the answer, so the attempts and their pauses are few.
                Cause::Machine => {
                    machine_losses += 1;
                    tokio::time::sleep(Duration::from_millis(100 << machine_losses)).await;
                    machine_losses < ATTEMPTS
                }
                Cause::Unknown | Cause::Store => false,
            };
            if !again {
                return Err(of_lost(&lost, faults));
            }
        }
    }

    /// Wakes the places, since a job waits.
    pub fn ring(&self) {
        self.shared.ring();
    }

    /// Watches a job. The caller must read its state from the ledger afterwards, since it may have ended before.
    pub fn watch(&self, job: &str) -> watch::Receiver<Progress> {
        let queued = || watch::Sender::new(JobState::Queued.into());
        let mut watched = locked(&self.shared.watched);
        watched.retain(|_, sender| {
            sender.receiver_count() > 0 || sender.borrow().state == JobState::Running
        });
        let sender = watched.entry(job.into()).or_insert_with(queued);
        sender.subscribe()
    }

    /// Returns the time that a verdict of a question's kind takes a place: the median of the last ones of this process;
    /// `None` if there were none.
    pub fn usual_time(&self, question: &Question) -> Option<Duration> {
        let kind = question.kind();
        let finished = locked(&self.shared.finished);
        let same_kind = finished.iter().filter(|(other, _)| *other == kind);
        let mut times: Vec<Duration> = same_kind.map(|(_, time)| *time).collect();
        times.sort_unstable();
        times.get(times.len() / 2).copied()
    }

    /// Lets each place finish its work and take no more, and waits for that.
    pub fn end(&self) {
        self.shared.ends.store(true, Ordering::Relaxed);
        self.shared.ring();
        for thread in locked(&self.threads).drain(..) {
            let _ = thread.join();
        }
        locked(&self.shared.orders).retain(|_| false);
    }
}

/// Cause of an order without an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cause {
    /// The recording: its child ended by itself.
    Recording,
    /// The machine, or a person: no child could be started, or it was killed.
    Machine,
    /// Unknown: a late child may have had too little time on a busy machine.
    Unknown,
    /// The store.
    Store,
}

impl Cause {
    fn of(lost: &Lost) -> Self {
        match lost {
            Lost::Ended(ending) if ending.is_own_fault() => Self::Recording,
            Lost::Ended(_) | Lost::NotStarted { .. } => Self::Machine,
            Lost::Late { .. } | Lost::Unclear { .. } => Self::Unknown,
            Lost::Store(_) => Self::Store,
        }
    }
}

/// Returns the problem of an order without an answer. A recording that ends its reader by itself is unusable; a
/// fault of the machine is no fault of the recording.
fn of_lost(lost: &Lost, faults: i64) -> Problem {
    let code = match lost {
        Lost::Store(error) => return error.clone().into(),
        Lost::Ended(ending) if ending.is_own_fault() => {
            let detail = format!(
                "{lost}, {faults} of {ATTEMPTS} times; cut the recording to what is needed, or \
                 raise what a child may take in the service's configuration"
            );
            let title = "Reading the recording ends its process";
            let status = StatusCode::UNPROCESSABLE_ENTITY;
            let mut problem = Problem::new(status, "ends-its-reader", title, detail);
            problem.verdict = Some("unusable".into());
            return problem;
        }
        Lost::Ended(_) => "reader-was-killed",
        Lost::NotStarted { .. } => "reader-not-started",
        Lost::Late { .. } => "reader-was-late",
        Lost::Unclear { .. } => "reader-was-unclear",
    };
    let way_out = match lost {
        Lost::Late { .. } => {
            "ask again when the machine has less to do, or raise `order_s` in the service's \
             configuration"
        }
        _ => "ask again; the recording is not to blame",
    };
    Problem {
        retry_after_s: Some(5),
        ..Problem::new(
            StatusCode::SERVICE_UNAVAILABLE,
            code,
            "No answer this time",
            format!("{lost}; {way_out}"),
        )
    }
}

/// Longest pause of a job that was put back [ms].
const LONGEST_PAUSE_MS: i64 = 30_000;

/// Returns the pause of a job after a number of attempts [ms]; it doubles each time.
fn pause_ms(attempts: i64) -> i64 {
    (200 << attempts.clamp(0, 10)).min(LONGEST_PAUSE_MS)
}

/// Work that a place takes. A gate keeps nobody from looking, and people who look keep no verdict from being made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Takes {
    Orders,
    Jobs,
    Both,
}

/// Next work of a place.
enum Next {
    Order(String, Box<WaitingOrder>),
    Job(Box<Job>),
    End,
}

fn serve(shared: &Shared, mut slot: Slot, takes: Takes) {
    let mut place = Place {
        takes,
        order_was_last: false,
        held_first: HeldFirst::default(),
    };
    loop {
        let began;
        match place.next(shared, &slot) {
            Next::End => return,
            Next::Order(owner, waiting) => {
                began = Instant::now();
                let WaitingOrder {
                    order,
                    manifest,
                    reply,
                    held,
                } = *waiting;
                drop(held);
                let blobs = &*shared.blobs;
                let outcome = slot.order(&order, manifest.as_ref(), blobs, &mut |_| {});
                shared.count_lost(outcome.as_ref().err());
                let _ = reply.send(outcome);
                shared.count_work(&owner, |figures| figures.orders += began.elapsed());
                locked(&shared.orders).done(&owner);
                // Another place may wait for an owner who had all that an owner may have.
                shared.ring();
            }
            Next::Job(job) => {
                began = Instant::now();
                shared.work(&mut slot, &job);
                shared.count_work(&job.owner, |figures| figures.jobs += began.elapsed());
            }
        }
        let took = u64::try_from(began.elapsed().as_millis()).unwrap_or(u64::MAX);
        shared.counters.busy_ms.fetch_add(took, Ordering::Relaxed);
        if slot.failed_to_start() {
            // Without a child the next jobs would fail as well, and each would be written back to the ledger.
            std::thread::sleep(START_PAUSE);
        }
    }
}

/// A place, as far as it chooses its work.
struct Place {
    takes: Takes,
    order_was_last: bool,
    held_first: HeldFirst,
}

impl Place {
    /// Waits for the next work.
    fn next(&mut self, shared: &Shared, slot: &Slot) -> Next {
        loop {
            if shared.ends.load(Ordering::Relaxed) {
                return Next::End;
            }
            let rings = shared.rings.load(Ordering::Relaxed);
            let job_first = self.takes == Takes::Jobs || self.order_was_last;
            let next = if job_first {
                self.job(shared).or_else(|| self.order(shared, slot))
            } else {
                self.order(shared, slot).or_else(|| self.job(shared))
            };
            if let Some(next) = next {
                self.order_was_last = matches!(next, Next::Order(..));
                return next;
            }
            let orders = locked(&shared.orders);
            // What came since the look above was not seen there.
            if shared.rings.load(Ordering::Relaxed) == rings {
                let orders = shared.bell.wait_timeout(orders, LOOK);
                drop(orders);
            }
        }
    }

    fn order(&mut self, shared: &Shared, slot: &Slot) -> Option<Next> {
        if self.takes == Takes::Jobs {
            return None;
        }
        let mut orders = locked(&shared.orders);
        orders.retain(|waiting| !waiting.reply.is_closed());
        let (owner, waiting) = orders.take(|id| slot.holds(id), &mut self.held_first)?;
        Some(Next::Order(owner, Box::new(waiting)))
    }

    fn job(&self, shared: &Shared) -> Option<Next> {
        if self.takes == Takes::Orders {
            return None;
        }
        // A gate has no places beside those of people who wait, for there are as many places as cores. The place for
        // jobs alone takes its pairs in any case.
        let takes_pairs = self.takes == Takes::Jobs || locked(&shared.orders).is_empty();
        let (now, lease) = (running_ms(), running_ms() + LEASE.as_millis() as i64);
        let taken = if takes_pairs {
            shared.ledger.take(now, lease)
        } else {
            shared.ledger.take_question(now, lease)
        };
        match taken {
            Ok(job) => job.map(|job| Next::Job(Box::new(job))),
            Err(error) => {
                tracing::warn!(%error, "no job can be taken");
                None
            }
        }
    }
}

impl Shared {
    /// Wakes the places.
    fn ring(&self) {
        let _orders = locked(&self.orders);
        self.rings.fetch_add(1, Ordering::Relaxed);
        self.bell.notify_all();
    }

    fn count_work(&self, owner: &str, count: impl FnOnce(&mut OwnerFigures)) {
        let mut by_owner = locked(&self.by_owner);
        let is_one_too_many = by_owner.len() >= OWNERS && !by_owner.contains_key(owner);
        let owner = if is_one_too_many { "others" } else { owner };
        count(by_owner.entry(owner.into()).or_default());
    }

    fn count_lost(&self, lost: Option<&Lost>) {
        if let Some(lost) = lost {
            self.counters.children_lost.fetch_add(1, Ordering::Relaxed);
            tracing::warn!(%lost, "an order has no answer");
        }
    }

    fn count_answer(&self, verdict: &str) {
        let index = ANSWERS.iter().position(|answer| *answer == verdict);
        if let Some(counter) = index.and_then(|index| self.counters.answers.get(index)) {
            counter.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn tell(&self, job: &str, progress: impl Into<Progress>) {
        let progress = progress.into();
        let mut watched = locked(&self.watched);
        let ended = progress.state.has_ended();
        if progress.state == JobState::Running && !watched.contains_key(job) {
            // Whoever begins to watch later finds how far it is.
            watched.insert(job.into(), watch::Sender::new(progress));
        } else if let Some(sender) = watched.get(job) {
            sender.send_replace(progress);
            if ended {
                watched.remove(job);
            }
        }
    }

    /// Carries out a job and writes its outcome into the ledger.
    fn work(&self, slot: &mut Slot, job: &Job) {
        let began = Instant::now();
        self.tell(
            &job.id,
            Progress {
                began: Some(began),
                ..JobState::Running.into()
            },
        );
        let outcome = self.answer(slot, job, began);
        let (id, attempt) = (&job.id, job.attempt);
        let made = match &outcome {
            Ok(Answered::Judged(result)) => {
                let files = result.files.values().map(|file| file.sha256.clone());
                files.collect()
            }
            _ => BTreeSet::new(),
        };
        let done = |state: JobState| {
            self.counters.jobs_done.fetch_add(1, Ordering::Relaxed);
            let mut progress = Progress::from(state);
            progress.part = Some(1.0);
            self.tell(id, progress);
        };
        let written = match outcome {
            Ok(Answered::Judged(result)) => {
                let written = self.ledger.finish(id, attempt, &result);
                let report_id = result.report_id;
                written.map(|()| {
                    self.count_answer(&result.summary.verdict);
                    let mut finished = locked(&self.finished);
                    finished.push_back((job.question.kind(), began.elapsed()));
                    if finished.len() > FINISHED {
                        finished.pop_front();
                    }
                    drop(finished);
                    done(JobState::Done { report_id });
                })
            }
            Ok(Answered::Decided(row)) => {
                let written = self.ledger.decide(id, attempt, &row);
                written.map(|()| {
                    self.count_answer(row["row"]["verdict"].as_str().unwrap_or(""));
                    done(JobState::Decided { row });
                })
            }
            Err(Unanswered::Refused(problem)) => self.refuse(job, *problem, true),
            Err(Unanswered::Lost(lost)) => {
                self.count_lost(Some(&lost));
                self.lose(job, lost)
            }
        };
        if written.is_err() {
            // It waits until its lease runs out.
            self.tell(id, JobState::Queued);
        }
        match written {
            Ok(()) => {}
            Err(StoreError::Deleted) => {
                let forgotten = self.forget(job, &made);
                if let Err(error) = forgotten {
                    tracing::warn!(%error, job = %job.id, "a refusal could not be kept");
                }
            }
            Err(StoreError::Fenced) => {
                tracing::warn!(job = %job.id, attempt = job.attempt, "an attempt came too late");
            }
            // The lease runs out, and the job is taken again.
            Err(error) => tracing::warn!(%error, job = %job.id, "an answer could not be kept"),
        }
    }

    /// Removes the results of a recording that was deleted meanwhile.
    fn forget(&self, job: &Job, made: &BTreeSet<String>) -> Result<(), StoreError> {
        let recording = &job.question.recording;
        self.ledger.extend_deletion(recording, made)?;
        crate::store::sweep(&*self.ledger, &*self.blobs)?;
        self.refuse(job, StoreError::Deleted.into(), false)
    }

    fn refuse(&self, job: &Job, problem: Problem, lasts: bool) -> Result<(), StoreError> {
        let verdict = problem.verdict.clone();
        let problem = problem.to_value();
        self.ledger.refuse(&job.id, job.attempt, &problem, lasts)?;
        self.counters.jobs_refused.fetch_add(1, Ordering::Relaxed);
        self.count_answer(verdict.as_deref().unwrap_or(""));
        self.tell(&job.id, JobState::Refused { problem });
        Ok(())
    }

    /// Puts a job without an answer back into the queue, or refuses it.
    fn lose(&self, job: &Job, lost: Lost) -> Result<(), StoreError> {
        let cause = Cause::of(&lost);
        let refused = match cause {
            Cause::Recording => job.failures + 1 >= ATTEMPTS,
            // A job that is late each time would hold a place for ever, so it is refused. Asking again
            // starts it anew.
            Cause::Unknown => job.attempt >= ATTEMPTS,
            Cause::Store => matches!(
                lost,
                Lost::Store(StoreError::Damaged { .. } | StoreError::Deleted)
            ),
            Cause::Machine => false,
        };
        if refused {
            let lasts = cause == Cause::Recording;
            return self.refuse(job, of_lost(&lost, job.failures + 1), lasts);
        }
        let (id, attempt) = (&job.id, job.attempt);
        let counts = cause == Cause::Recording;
        let not_before_ms = running_ms() + pause_ms(attempt);
        self.ledger.give_back(id, attempt, counts, not_before_ms)?;
        self.tell(id, JobState::Queued);
        Ok(())
    }

    fn answer(&self, slot: &mut Slot, job: &Job, began: Instant) -> Result<Answered, Unanswered> {
        let question = &job.question;
        let recording = self
            .ledger
            .recording(&question.recording)
            .map_err(Lost::from)?
            .ok_or(Lost::Store(StoreError::Deleted))?;
        let order = Order::Answer {
            how: if question.decision_alone {
                How::Decide
            } else {
                How::Judge
            },
            recording: question.recording.clone(),
            request: question.request.clone(),
            design: question.design.clone(),
            by: match &*job.owner {
                NOBODY => String::new(),
                owner => owner.into(),
            },
        };
        let mut lease_renewed = Instant::now();
        let mut progress = Progress {
            began: Some(began),
            ..JobState::Running.into()
        };
        let mut beat = |beat: Beat| {
            progress.part = beat.part.or(progress.part);
            progress.step = beat.step.or(progress.step);
            progress.first_answer = beat.first_answer.or(progress.first_answer.take());
            self.tell(&job.id, progress.clone());
            if lease_renewed.elapsed() > LEASE / 4 {
                lease_renewed = Instant::now();
                let lease = running_ms() + LEASE.as_millis() as i64;
                if let Err(error) = self.ledger.hold(&job.id, job.attempt, lease) {
                    tracing::warn!(%error, job = %job.id, "a lease could not be held");
                }
            }
        };
        let manifest = Some(&recording.manifest);
        let delivered = slot.order(&order, manifest, &*self.blobs, &mut beat)?;
        match delivered.answer {
            Answer::Decision { row } if question.decision_alone => Ok(Answered::Decided(row)),
            Answer::Verdict {
                report_id,
                summary,
                content_sha256,
            } if is_hash(&report_id) && is_hash(&content_sha256) => {
                let mut summary = *summary;
                summary.design_version.clone_from(&question.design_name);
                if question.design_name.is_some() && summary.modified.is_empty() {
                    // A stored design is identified by name and version, so its changes are not listed.
                    summary.changes.clear();
                }
                let files = delivered.files.into_iter();
                Ok(Answered::Judged(Box::new(StoredResult {
                    report_id,
                    recording: question.recording.clone(),
                    summary,
                    files: files.map(|file| (file.name.clone(), file)).collect(),
                    created_ms: now_ms(),
                    content_sha256,
                    job: job.id.clone(),
                    numbers_revision: NUMBERS_REVISION,
                    is_stripped: false,
                    lost: BTreeSet::new(),
                    asked_by: String::new(),
                })))
            }
            Answer::Problem { problem } => {
                let problem = Problem::of_value(problem).ok_or_else(|| Lost::Unclear {
                    reason: "a problem that is none".into(),
                })?;
                Err(Unanswered::Refused(problem.into()))
            }
            _ => Err(Unanswered::Lost(Lost::Unclear {
                reason: "an answer to another order".into(),
            })),
        }
    }
}

/// Result of a job.
enum Answered {
    Judged(Box<StoredResult>),
    Decided(serde_json::Value),
}

/// Why a job has no result.
enum Unanswered {
    Refused(Box<Problem>),
    Lost(Lost),
}

impl From<Lost> for Unanswered {
    fn from(lost: Lost) -> Self {
        Self::Lost(lost)
    }
}

fn is_hash(text: &str) -> bool {
    text.len() == 64 && text.bytes().all(|byte| byte.is_ascii_hexdigit())
}
