//! The jail of a child: limits on its resources, and no access to the system.
//!
//! A child has its pipes and memory. Landlock takes files and TCP away, seccomp every call of the
//! system that is not on a short list (so UDP, programs, other processes too), limits bound memory
//! and processor time. A kernel may lack a part: [`Jail`] says what is in force.

use landlock::{
    ABI, Access, AccessFs, AccessNet, CompatLevel, Compatible, Ruleset, RulesetAttr, RulesetStatus,
    Scope,
};
use rustix::process::{DumpableBehavior, Resource, Rlimit, Signal};
use seccompiler::{
    BpfProgram, SeccompAction, SeccompCmpArgLen, SeccompCmpOp, SeccompCondition, SeccompFilter,
    SeccompRule,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What is in force around a child.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Jail {
    /// Files are out of reach: `all`, `some` or `no`.
    pub files: String,
    /// TCP is out of reach by Landlock: `all`, `some` or `no`. Where seccomp is in force, no socket
    /// can be made anyway.
    pub tcp: String,
    /// Calls of the system that are not on the list are refused.
    pub seccomp: bool,
    /// Most memory a child may map [bytes]; `null` where the limit is not in force.
    pub memory_bytes: Option<u64>,
    /// What is lacking, in words; empty where the jail is whole.
    pub lacking: Vec<String>,
}

impl Jail {
    /// Returns true if nothing is lacking.
    pub fn is_whole(&self) -> bool {
        self.lacking.is_empty()
    }
}

/// Puts this process into the jail; returns what is in force.
pub fn enter(memory_bytes: u64) -> Jail {
    let mut lacking = Vec::new();
    let mut note = |what: &str, outcome: Result<(), String>| {
        let holds = outcome.is_ok();
        if let Err(reason) = outcome {
            lacking.push(format!("{what}: {reason}"));
        }
        holds
    };
    let plain = |error: rustix::io::Errno| error.to_string();
    note(
        "the child ends with its parent",
        rustix::process::set_parent_process_death_signal(Some(Signal::KILL)).map_err(plain),
    );
    note(
        "other processes may not look into the child",
        rustix::process::set_dumpable_behavior(DumpableBehavior::NotDumpable).map_err(plain),
    );
    note("no core is written", limit(Resource::Core, 0));
    let memory = note("memory", limit(Resource::As, memory_bytes));
    let files = note("files (Landlock)", shut_files());
    let tcp = note("TCP (Landlock)", shut_tcp());
    let seccomp = note("calls of the system (seccomp)", shut_calls());
    let word = |holds: bool| if holds { "all" } else { "no" }.to_string();
    Jail {
        files: word(files),
        tcp: word(tcp),
        seccomp,
        memory_bytes: memory.then_some(memory_bytes),
        lacking,
    }
}

/// Allows this process about `seconds` more of processor time.
pub fn allow_cpu(seconds: u64) {
    let used = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime).tv_sec;
    let until = used.unsigned_abs() + seconds + 1;
    let hard = rustix::process::getrlimit(Resource::Cpu).maximum;
    let _ = rustix::process::setrlimit(
        Resource::Cpu,
        Rlimit {
            current: Some(until),
            maximum: hard,
        },
    );
}

fn limit(resource: Resource, maximum: u64) -> Result<(), String> {
    let both = Rlimit {
        current: Some(maximum),
        maximum: Some(maximum),
    };
    rustix::process::setrlimit(resource, both).map_err(|error| error.to_string())
}

/// Removes all access to files that the kernel can control.
fn shut_files() -> Result<(), String> {
    // The first version of the rules is required; rights of later versions are added if the kernel knows them.
    let status = Ruleset::default()
        .set_compatibility(CompatLevel::HardRequirement)
        .handle_access(AccessFs::from_all(ABI::V1))
        .and_then(|rules| {
            rules
                .set_compatibility(CompatLevel::BestEffort)
                .handle_access(AccessFs::from_all(ABI::V5))
        })
        .and_then(|rules| rules.scope(Scope::from_all(ABI::V6)))
        .and_then(Ruleset::create)
        .and_then(landlock::RulesetCreated::restrict_self)
        .map_err(|error| error.to_string())?;
    match status.ruleset {
        RulesetStatus::NotEnforced => Err("not enforced".into()),
        _ => Ok(()),
    }
}

fn shut_tcp() -> Result<(), String> {
    Ruleset::default()
        .set_compatibility(CompatLevel::HardRequirement)
        .handle_access(AccessNet::from_all(ABI::V4))
        .and_then(Ruleset::create)
        .and_then(landlock::RulesetCreated::restrict_self)
        .map(|_| ())
        .map_err(|error| error.to_string())
}

/// System calls that a computing process with pipes needs; [`call_filter`] adds those that are allowed with
/// certain arguments alone.
const CALLS: &[i64] = &[
    libc::SYS_read,
    libc::SYS_write,
    libc::SYS_readv,
    libc::SYS_writev,
    libc::SYS_close,
    libc::SYS_fstat,
    libc::SYS_lseek,
    libc::SYS_munmap,
    libc::SYS_mremap,
    libc::SYS_madvise,
    libc::SYS_brk,
    libc::SYS_futex,
    libc::SYS_sched_yield,
    libc::SYS_sched_getaffinity,
    libc::SYS_clock_gettime,
    libc::SYS_clock_nanosleep,
    libc::SYS_nanosleep,
    libc::SYS_getrandom,
    libc::SYS_getpid,
    libc::SYS_getppid,
    libc::SYS_gettid,
    libc::SYS_rt_sigaction,
    libc::SYS_rt_sigprocmask,
    libc::SYS_rt_sigreturn,
    libc::SYS_sigaltstack,
    libc::SYS_restart_syscall,
    libc::SYS_exit,
    libc::SYS_exit_group,
];

fn shut_calls() -> Result<(), String> {
    let filter = call_filter().map_err(|error| error.to_string())?;
    seccompiler::apply_filter(&filter).map_err(|error| error.to_string())
}

fn call_filter() -> Result<BpfProgram, seccompiler::BackendError> {
    let mut rules: BTreeMap<i64, Vec<SeccompRule>> =
        CALLS.iter().map(|call| (*call, Vec::new())).collect();
    use SeccompCmpArgLen::{Dword, Qword};
    use SeccompCmpOp::{Eq, MaskedEq};
    let is = SeccompCondition::new;
    // The process may signal itself alone, as an abort does.
    let own_pid = u64::from(std::process::id());
    let rule = SeccompRule::new(vec![is(0, Dword, Eq, own_pid)?])?;
    rules.insert(libc::SYS_tgkill, vec![rule]);
    // Only its own limits are allowed: all may be read (no new value is given), and that of processor time
    // may be set, as each order needs. The filter cannot see whether it is raised, since the value is behind
    // a pointer; the parent ends late orders by its own clock.
    let is_read = vec![is(0, Dword, Eq, 0)?, is(2, Qword, Eq, 0)?];
    let is_time = vec![
        is(0, Dword, Eq, 0)?,
        is(1, Dword, Eq, u64::from(libc::RLIMIT_CPU))?,
    ];
    let limits = vec![SeccompRule::new(is_read)?, SeccompRule::new(is_time)?];
    rules.insert(libc::SYS_prlimit64, limits);
    // Memory may never become executable, so that data of a recording cannot run.
    let may_run = u64::from(libc::PROT_EXEC.unsigned_abs());
    for call in [libc::SYS_mmap, libc::SYS_mprotect] {
        let rule = SeccompRule::new(vec![is(2, Dword, MaskedEq(may_run), 0)?])?;
        rules.insert(call, vec![rule]);
    }
    let refused = SeccompAction::Errno(libc::EPERM.unsigned_abs());
    let arch = std::env::consts::ARCH.try_into()?;
    SeccompFilter::new(rules, refused, SeccompAction::Allow, arch)?.try_into()
}
