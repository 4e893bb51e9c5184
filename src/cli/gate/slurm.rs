//! Shares as job arrays of Slurm.

use super::engine::ask;
use latchgate_recording::error::Error;
use latchgate_report::escape::shell as quoted;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::hash::{BuildHasher, RandomState};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// What was handed to Slurm for a submission.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct SlurmJobs {
    /// The submission.
    pub(super) submission: String,
    /// Job arrays, each with what its task numbers are to be raised by.
    arrays: Vec<(u64, u32)>,
    /// The job that collects.
    pub(super) collecting: u64,
    /// What names the answer to what was asked, and to nothing else: job numbers begin from 1 again
    /// on a cluster that was set up anew, and others submit gates of that name to the store.
    #[serde(default)]
    pub(super) answer: u64,
    /// How often the collecting job may still submit what is missing.
    pub(super) resubmits: u32,
    /// The user's own options of sbatch.
    options: Vec<String>,
}

/// What a collecting job ended with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
struct CollectingAnswer {
    exit_code: u8,
}

/// Tasks of a submission as the queue has them.
#[derive(Debug, Default)]
pub(super) struct Queue {
    pub(super) running: usize,
    pub(super) waiting: usize,
    /// Tasks that will never run, by their numbers.
    pub(super) stuck: Vec<String>,
    /// Shares that run or wait.
    active: BTreeSet<u32>,
    /// Jobs of which a task runs or waits.
    jobs: BTreeSet<u64>,
    pub(super) is_collecting: bool,
}

/// A submission's place in a store, and how Slurm is to call latchgate for it.
pub(super) struct Slurm<'a> {
    /// Folder of scripts and of what tasks print.
    pub(super) folder: PathBuf,
    /// Name of the gate file.
    pub(super) gate: &'a str,
    /// The submission.
    pub(super) submission: String,
    /// How many shares there are.
    pub(super) shares: u32,
    /// Command line of a share up to its number.
    pub(super) share_command: Vec<String>,
    /// Command line of the collecting job.
    pub(super) collect_command: Vec<String>,
    /// The name of the answer where this is a collecting job itself: the next one gives the same.
    pub(super) answer: Option<u64>,
    /// Time that a program of Slurm's has to answer.
    pub(super) answer_within: Duration,
}

impl Slurm<'_> {
    /// Returns the script of a share's task.
    pub(super) fn share_script(&self) -> String {
        let mut command = line(&self.share_command);
        // Raised by the script's argument, since an array's numbers end where its size does.
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

    /// Submits shares and the job that collects them and those of earlier arrays; returns what was
    /// handed over.
    pub(super) fn submit(
        &self,
        shares: &[u32],
        mut arrays: Vec<(u64, u32)>,
        resubmits: u32,
        options: &[String],
    ) -> Result<SlurmJobs, Error> {
        let most = self.largest_array()?;
        fs::create_dir_all(&self.folder).map_err(|error| unwritten(&self.folder, &error))?;
        let script = self.write("share", &self.share_script())?;
        for some in arrays_of(shares, most) {
            let numbers = ranges(some.1.iter().map(|share| share - some.0));
            let own = [
                format!("--array={numbers}"),
                "--requeue".into(),
                script.clone(),
                some.0.to_string(),
            ];
            arrays.push((self.sbatch(options, &own)?, some.0));
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

    /// Submits the job that collects behind the arrays, and keeps what was handed over.
    pub(super) fn collect(&self, jobs: &mut SlurmJobs) -> Result<(), Error> {
        if jobs.answer == 0 {
            // Of the system's random numbers.
            let random = || RandomState::new().hash_one(SystemTime::now());
            jobs.answer = self.answer.unwrap_or_else(random);
        }
        let script = self.write("collect", &self.collect_script(jobs.answer))?;
        let ids: Vec<String> = jobs.arrays.iter().map(|(id, _)| format!(":{id}")).collect();
        let mut own = vec!["--requeue".to_string()];
        if !ids.is_empty() {
            own.push(format!("--dependency=afterany{}", ids.concat()));
        }
        own.push(script);
        jobs.collecting = self.sbatch(&jobs.options, &own)?;
        put(&self.jobs_path(), jobs)
    }

    fn write(&self, name: &str, text: &str) -> Result<String, Error> {
        let path = self.folder.join(format!("{}.{name}.sh", self.gate));
        fs::write(&path, text).map_err(|error| unwritten(&path, &error))?;
        Ok(path.display().to_string())
    }

    fn sbatch(&self, options: &[String], own: &[String]) -> Result<u64, Error> {
        let output = self.folder.join("%A_%a.out").display().to_string();
        let mut arguments = options.to_vec();
        arguments.extend([
            "--parsable".into(),
            // A task that is requeued goes on writing where it wrote.
            "--open-mode=append".into(),
            format!("--job-name={}", self.job_name()),
            format!("--output={output}"),
        ]);
        arguments.extend(own.iter().cloned());
        let said = self.ask("sbatch", &arguments)?;
        // The number, and behind a semicolon the cluster where there are several.
        let number = said.trim().split(';').next().and_then(|id| id.parse().ok());
        number.ok_or_else(|| {
            Error::malformed(
                "the number of a job from sbatch",
                format!("`{}`", said.trim()),
                "see squeue for what was submitted",
            )
        })
    }

    fn ask(&self, program: &str, arguments: &[String]) -> Result<String, Error> {
        ask(program, arguments, self.answer_within)
    }

    /// Asks for the most tasks of an array.
    fn largest_array(&self) -> Result<u32, Error> {
        let said = self.ask("scontrol", &["show".into(), "config".into()])?;
        let value = |line: &str| -> Option<u32> {
            let (name, value) = line.split_once('=')?;
            (name.trim() == "MaxArraySize").then(|| value.trim().parse().ok())?
        };
        let size = said.lines().find_map(value).unwrap_or(1001);
        Ok(size.saturating_sub(1).max(1))
    }

    /// Returns the name of the submission's jobs.
    fn job_name(&self) -> String {
        format!("latchgate-{}", self.submission)
    }

    /// Returns what the queue holds of the submission, of which `jobs` were handed over.
    pub(super) fn queue(&self, jobs: &SlurmJobs) -> Result<Queue, Error> {
        let name = format!("--name={}", self.job_name());
        let said = self.ask(
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
        for row in said.lines() {
            let mut cells = row.split('|').map(str::trim);
            let (Some(task), Some(state), Some(why)) = (cells.next(), cells.next(), cells.next())
            else {
                continue;
            };
            let why = why.to_lowercase().replace('_', " ");
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

    /// Cancels tasks that will never run, and tells how many there were.
    pub(super) fn cancel(&self, tasks: &[String]) -> Result<(), Error> {
        if tasks.is_empty() {
            return Ok(());
        }
        self.ask("scancel", tasks).map(drop)
    }

    /// Submits again those of the missing shares that neither run nor wait; returns which, and what
    /// was handed over. The job that was to collect before is cancelled where it waits.
    pub(super) fn resubmit(
        &self,
        missing: &[u32],
        resubmits: u32,
        options: Option<&[String]>,
    ) -> Result<Vec<u32>, Error> {
        let before = self.jobs()?.unwrap_or_default();
        let queue = self.queue(&before)?;
        let mut lost = queue.stuck.clone();
        let own = std::env::var("SLURM_JOB_ID").unwrap_or_default();
        if queue.is_collecting && own != before.collecting.to_string() {
            lost.push(before.collecting.to_string());
        }
        self.cancel(&lost)?;
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

    /// Reads what was handed over for this submission.
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

/// Splits shares into arrays whose task numbers go from 1 to `most`; each with what they are to be
/// raised by.
fn arrays_of(shares: &[u32], most: u32) -> Vec<(u32, Vec<u32>)> {
    let block = |share: &u32| (share - 1) / most;
    shares
        .chunk_by(|a, b| block(a) == block(b))
        .map(|some| (block(&some[0]) * most, some.to_vec()))
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
    let here = std::env::current_dir().unwrap_or_default();
    let here = quoted(&here.to_string_lossy());
    format!(
        "#!/bin/bash\n# Written by latchgate gate --submit slurm. {what}\ncd {here} || exit 4\nexec {command}\n"
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
        for (count, most) in [(1, 1), (7, 3), (1000, 1000), (1001, 1000), (2500, 1000)] {
            let shares: Vec<u32> = (1..=count).filter(|share| share % 5 != 2).collect();
            let arrays = super::arrays_of(&shares, most);
            let all = arrays.iter().flat_map(|(_, some)| some.clone());
            assert_eq!(all.collect::<Vec<_>>(), shares);
            for (offset, some) in arrays {
                assert!(
                    some.iter()
                        .all(|share| (1..=most).contains(&(share - offset)))
                );
            }
        }
        assert_eq!(super::ranges([1, 2, 3, 5, 8, 9].into_iter()), "1-3,5,8-9");
    }
}
