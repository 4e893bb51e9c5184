//! Shares as job arrays of Slurm.

use super::engine::run_program;
use latchgate_recording::error::Error;
use latchgate_report::escape::shell as quoted;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::hash::{BuildHasher, RandomState};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// The jobs that were submitted to Slurm for a submission.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct SlurmJobs {
    /// The submission.
    pub(super) submission: String,
    /// Numbers of job arrays, each with the offset from its task numbers to shares.
    arrays: Vec<(u64, u32)>,
    /// Number of the collecting job.
    pub(super) collecting: u64,
    /// Random name of this submission's answer. A job number would not do: a cluster that is set up
    /// anew counts from 1 again, and others may submit a gate of the same name to the store.
    #[serde(default)]
    pub(super) answer: u64,
    /// Number of times that the collecting job may still submit missing shares.
    pub(super) resubmits: u32,
    /// The user's own options of sbatch.
    options: Vec<String>,
}

/// Result of a collecting job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
struct CollectingAnswer {
    exit_code: u8,
}

/// Tasks of a submission in Slurm's queue.
#[derive(Debug, Default)]
pub(super) struct Queue {
    pub(super) running: usize,
    pub(super) waiting: usize,
    /// Tasks that will never run, by their numbers.
    pub(super) stuck: Vec<String>,
    /// Shares that run or wait.
    active: BTreeSet<u32>,
    /// Jobs with a task that runs or waits.
    jobs: BTreeSet<u64>,
    pub(super) is_collecting: bool,
}

/// A submission's folder in a store, and the command lines of its jobs.
pub(super) struct Slurm<'a> {
    /// Folder of scripts and of the tasks' output.
    pub(super) folder: PathBuf,
    /// Name of the gate file.
    pub(super) gate: &'a str,
    /// The submission.
    pub(super) submission: String,
    /// Number of shares.
    pub(super) shares: u32,
    /// Command line of a share up to its number.
    pub(super) share_command: Vec<String>,
    /// Command line of the collecting job.
    pub(super) collect_command: Vec<String>,
    /// Name of the answer, in a collecting job: the next collecting job gives the same answer.
    pub(super) answer: Option<u64>,
    /// Time limit for a program of Slurm.
    pub(super) time_limit: Duration,
}

impl Slurm<'_> {
    /// Returns the script of a share's task.
    pub(super) fn share_script(&self) -> String {
        let mut command = line(&self.share_command);
        // The script's argument is an offset: task numbers end at the cluster's MaxArraySize.
        let number = "$((SLURM_ARRAY_TASK_ID + ${1:-0}))";
        let _ = write!(
            command,
            " --threads \"${{SLURM_CPUS_PER_TASK:-1}}\" --part \"{number}/{}\"",
            self.shares
        );
        script(
            "Judges one share of a gate; pairs in the store are not judged again.",
            &command,
        )
    }

    fn collect_script(&self, answer: u64) -> String {
        script(
            "Collects the shares of a gate, and submits missing ones again.",
            &format!("{} --answer {answer}", line(&self.collect_command)),
        )
    }

    /// Submits shares, and the job that collects them and those of earlier arrays; returns the jobs.
    pub(super) fn submit(
        &self,
        shares: &[u32],
        mut arrays: Vec<(u64, u32)>,
        resubmits: u32,
        options: &[String],
    ) -> Result<SlurmJobs, Error> {
        let tasks_max = self.largest_array()?;
        fs::create_dir_all(&self.folder).map_err(|error| unwritten(&self.folder, &error))?;
        let script = self.write("share", &self.share_script())?;
        for (offset, shares) in arrays_of(shares, tasks_max) {
            let numbers = ranges(shares.iter().map(|share| share - offset));
            let array_options = [
                format!("--array={numbers}"),
                "--requeue".into(),
                script.clone(),
                offset.to_string(),
            ];
            arrays.push((self.sbatch(options, &array_options)?, offset));
        }
        let mut jobs = SlurmJobs {
            submission: self.submission.clone(),
            arrays,
            resubmits,
            options: options.to_vec(),
            ..SlurmJobs::default()
        };
        self.collect(&mut jobs)?;
        Ok(jobs)
    }

    /// Submits the job that collects after the arrays, and keeps the jobs in the store.
    pub(super) fn collect(&self, jobs: &mut SlurmJobs) -> Result<(), Error> {
        if jobs.answer == 0 {
            // The standard library seeds it with the system's random numbers.
            let random = || RandomState::new().hash_one(SystemTime::now());
            jobs.answer = self.answer.unwrap_or_else(random);
        }
        let script = self.write("collect", &self.collect_script(jobs.answer))?;
        let ids: Vec<String> = jobs.arrays.iter().map(|(id, _)| format!(":{id}")).collect();
        let mut job_options = vec!["--requeue".to_string()];
        if !ids.is_empty() {
            // After any end of the tasks: a task that fails leaves pairs that are to be listed.
            job_options.push(format!("--dependency=afterany{}", ids.concat()));
        }
        job_options.push(script);
        jobs.collecting = self.sbatch(&jobs.options, &job_options)?;
        put(&self.jobs_path(), jobs)
    }

    fn write(&self, name: &str, text: &str) -> Result<String, Error> {
        let path = self.folder.join(format!("{}.{name}.sh", self.gate));
        fs::write(&path, text).map_err(|error| unwritten(&path, &error))?;
        Ok(path.display().to_string())
    }

    /// Submits a job with the user's options and those of the job; returns its number.
    fn sbatch(&self, options: &[String], job_options: &[String]) -> Result<u64, Error> {
        let output = self.folder.join("%A_%a.out").display().to_string();
        let mut arguments = options.to_vec();
        arguments.extend([
            "--parsable".into(),
            // A requeued task would otherwise overwrite the output of its first run.
            "--open-mode=append".into(),
            format!("--job-name={}", self.job_name()),
            format!("--output={output}"),
        ]);
        // Last, since the script and its argument are positional.
        arguments.extend(job_options.iter().cloned());
        let output = self.run("sbatch", &arguments)?;
        // The number, and after a semicolon the cluster where there are several.
        let number = output.trim().split(';').next();
        let number = number.and_then(|id| id.parse().ok());
        number.ok_or_else(|| {
            Error::malformed(
                "the number of a job from sbatch",
                format!("`{}`", output.trim()),
                "see squeue for what was submitted",
            )
        })
    }

    fn run(&self, program: &str, arguments: &[String]) -> Result<String, Error> {
        run_program(program, arguments, self.time_limit)
    }

    /// Returns the largest task number that an array may have.
    fn largest_array(&self) -> Result<u32, Error> {
        let output = self.run("scontrol", &["show".into(), "config".into()])?;
        let value = |line: &str| -> Option<u32> {
            let (name, value) = line.split_once('=')?;
            (name.trim() == "MaxArraySize").then(|| value.trim().parse().ok())?
        };
        // 1001 is Slurm's default. Numbers begin with 0, so the largest is one less.
        let size = output.lines().find_map(value).unwrap_or(1001);
        Ok(size.saturating_sub(1).max(1))
    }

    /// Returns the name of the submission's jobs.
    fn job_name(&self) -> String {
        format!("latchgate-{}", self.submission)
    }

    /// Returns the tasks of the submission's `jobs` in the queue.
    pub(super) fn queue(&self, jobs: &SlurmJobs) -> Result<Queue, Error> {
        let name = format!("--name={}", self.job_name());
        let output = self.run(
            "squeue",
            &[
                "-h".into(),
                "-r".into(),
                name,
                "-o".into(),
                "%i|%T|%r".into(),
            ],
        )?;
        let mut queue = Queue::default();
        for row in output.lines() {
            let mut cells = row.split('|').map(str::trim);
            let (Some(task), Some(state), Some(why)) = (cells.next(), cells.next(), cells.next())
            else {
                continue;
            };
            let why = why.to_lowercase().replace('_', " ");
            // Slurm holds a task whose start failed until a person releases it, and the collecting
            // job waits for it.
            if why.contains("requeued held") {
                queue.stuck.push(task.into());
                continue;
            }
            if task == jobs.collecting.to_string() {
                queue.is_collecting = true;
                continue;
            }
            if state == "COMPLETING" {
                continue;
            }
            if state == "PENDING" {
                queue.waiting += 1;
            } else {
                queue.running += 1;
            }
            queue.active.extend(jobs.share_of(task));
            queue.jobs.extend(job_of(task));
        }
        Ok(queue)
    }

    /// Cancels tasks that will never run.
    pub(super) fn cancel(&self, tasks: &[String]) -> Result<(), Error> {
        if tasks.is_empty() {
            return Ok(());
        }
        self.run("scancel", tasks).map(drop)
    }

    /// Submits again the missing shares that neither run nor wait, and returns them. The collecting
    /// job of the earlier submission is cancelled if it waits.
    pub(super) fn resubmit(
        &self,
        missing: &[u32],
        resubmits: u32,
        options: Option<&[String]>,
    ) -> Result<Vec<u32>, Error> {
        let before = self.jobs()?.unwrap_or_default();
        let queue = self.queue(&before)?;
        let mut obsolete = queue.stuck.clone();
        // The collecting job itself may be the caller; it must not cancel itself.
        let this_job = std::env::var("SLURM_JOB_ID").unwrap_or_default();
        if queue.is_collecting && this_job != before.collecting.to_string() {
            obsolete.push(before.collecting.to_string());
        }
        self.cancel(&obsolete)?;
        let again: Vec<u32> = missing
            .iter()
            .copied()
            .filter(|share| !queue.active.contains(share))
            .collect();
        let mut earlier = before.arrays;
        earlier.retain(|(job, _)| queue.jobs.contains(job));
        let options = options.unwrap_or(&before.options);
        self.submit(&again, earlier, resubmits, options)?;
        Ok(again)
    }

    fn jobs_path(&self) -> PathBuf {
        self.folder.join(format!("{}.jobs.json", self.gate))
    }

    /// Reads the jobs of this submission.
    pub(super) fn jobs(&self) -> Result<Option<SlurmJobs>, Error> {
        let jobs: Option<SlurmJobs> = read(&self.jobs_path())?;
        Ok(jobs.filter(|jobs| jobs.submission == self.submission))
    }

    fn answer_path(&self, answer: u64) -> PathBuf {
        self.folder
            .join(format!("{}.answer-{answer}.json", self.gate))
    }

    /// Reads the exit code of the collecting job, once it has ended.
    pub(super) fn answer(&self, jobs: &SlurmJobs) -> Result<Option<u8>, Error> {
        let answer: Option<CollectingAnswer> = read(&self.answer_path(jobs.answer))?;
        Ok(answer.map(|answer| answer.exit_code))
    }

    /// Keeps the exit code of a collecting job under the name of its answer.
    pub(super) fn keep_answer(&self, answer: u64, exit_code: u8) -> Result<(), Error> {
        put(&self.answer_path(answer), &CollectingAnswer { exit_code })
    }
}

impl SlurmJobs {
    /// Returns the share of a task, `job_number`.
    fn share_of(&self, task: &str) -> Option<u32> {
        let (_, number) = task.split_once('_')?;
        let job = job_of(task)?;
        let (_, offset) = self.arrays.iter().find(|(id, _)| *id == job)?;
        Some(number.parse::<u32>().ok()? + offset)
    }
}

/// Returns the job of a task, `job_number`.
fn job_of(task: &str) -> Option<u64> {
    task.split('_').next()?.parse().ok()
}

/// Splits shares into arrays with task numbers from 1 to `tasks_max`, each with the offset from task
/// numbers to shares.
fn arrays_of(shares: &[u32], tasks_max: u32) -> Vec<(u32, Vec<u32>)> {
    let block = |share: &u32| (share - 1) / tasks_max;
    shares
        .chunk_by(|a, b| block(a) == block(b))
        .map(|shares| (block(&shares[0]) * tasks_max, shares.to_vec()))
        .collect()
}

/// Writes numbers in order as `1-3,5`.
pub(super) fn ranges(numbers: impl Iterator<Item = u32>) -> String {
    let mut runs: Vec<(u32, u32)> = Vec::new();
    for number in numbers {
        match runs.last_mut() {
            Some((_, last)) if *last + 1 == number => *last = number,
            _ => runs.push((number, number)),
        }
    }
    let written = runs.iter().map(|(first, last)| {
        if first == last {
            first.to_string()
        } else {
            format!("{first}-{last}")
        }
    });
    written.collect::<Vec<_>>().join(",")
}

fn line(words: &[String]) -> String {
    let words = words.iter().map(|word| quoted(word));
    words.collect::<Vec<_>>().join(" ")
}

fn script(what: &str, command: &str) -> String {
    let folder = std::env::current_dir().unwrap_or_default();
    let folder = quoted(&folder.to_string_lossy());
    format!(
        "#!/bin/bash\n# Written by latchgate gate --submit slurm. {what}\ncd {folder} || exit 4\nexec {command}\n"
    )
}

fn read<T: serde::de::DeserializeOwned>(path: &Path) -> Result<Option<T>, Error> {
    match fs::read(path) {
        Ok(text) => serde_json::from_slice(&text)
            .map(Some)
            .map_err(|error| unwritten(path, &error.into())),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(unwritten(path, &error)),
    }
}

fn put(path: &Path, what: &impl Serialize) -> Result<(), Error> {
    serde_json::to_vec(what)
        .map_err(std::io::Error::from)
        .and_then(|text| {
            let beside = path.with_extension("part");
            fs::write(&beside, text)?;
            fs::rename(&beside, path)
        })
        .map_err(|error| unwritten(path, &error))
}

fn unwritten(path: &Path, error: &std::io::Error) -> Error {
    Error::io_at("keep what was submitted", path, error)
}

#[cfg(test)]
mod tests {
    #[test]
    fn verif_arrays_hold_every_share_once_and_no_number_beyond_their_size() {
        for (count, tasks_max) in [(1, 1), (7, 3), (1000, 1000), (1001, 1000), (2500, 1000)] {
            let shares: Vec<u32> = (1..=count).filter(|share| share % 5 != 2).collect();
            let arrays = super::arrays_of(&shares, tasks_max);
            let submitted = arrays.iter().flat_map(|(_, shares)| shares.clone());
            assert_eq!(submitted.collect::<Vec<_>>(), shares);
            for (offset, shares) in arrays {
                let mut tasks = shares.iter().map(|share| share - offset);
                assert!(tasks.all(|task| (1..=tasks_max).contains(&task)));
            }
        }
        assert_eq!(super::ranges([1, 2, 3, 5, 8, 9].into_iter()), "1-3,5,8-9");
    }
}
