//! Shares on a Slurm that is none: what it says at the wrong time, and what lies there from before.

use super::SweepYard;
use crate::support::{Done, finish};
use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::PathBuf;

/// A gate beside which a Slurm lies that counts its jobs from 1.
struct FakeSlurm {
    yard: SweepYard,
}

impl FakeSlurm {
    fn new(name: &str, recordings: usize, designs: usize) -> Self {
        let yard = SweepYard::new(name, recordings, designs, 0);
        let tool = yard
            .folder
            .file("tools/slurm.sh", include_str!("fake_slurm.sh"));
        fs::set_permissions(&tool, PermissionsExt::from_mode(0o755)).unwrap();
        for name in ["sbatch", "squeue", "scontrol", "scancel"] {
            symlink("slurm.sh", tool.with_file_name(name)).unwrap();
        }
        Self { yard }
    }

    /// Calls the gate where this Slurm is on the path.
    fn gate(&self, more: &[&str]) -> Done {
        let own = ["--store", "store", "--out", "out"];
        let mut command = self.yard.command(&[&own[..], more].concat());
        let path = format!(
            "{}:{}",
            self.yard.path("tools").display(),
            std::env::var("PATH").unwrap()
        );
        finish(command.env("PATH", path))
    }

    fn submit(&self, shares: &str) -> Done {
        self.gate(&["--submit", "slurm", "--parts", shares, "--wait"])
    }

    fn state(&self, name: &str) -> PathBuf {
        self.yard.path("tools/state").join(name)
    }

    /// What the jobs printed.
    fn log(&self) -> String {
        fs::read_to_string(self.state("log")).unwrap_or_default()
    }
}

/// A cluster that was set up anew gives its jobs the numbers of those before: what such a job once
/// answered is no answer of this one.
#[test]
fn cli_an_answer_of_an_earlier_job_of_that_number_is_none() {
    let slurm = FakeSlurm::new("answers", 1, 1);
    let done = slurm.submit("2");
    assert_eq!(done.code, 0, "{}{}", done.err, slurm.log());
    slurm.yard.recording(0, 99.0);
    fs::remove_dir_all(slurm.state("")).unwrap();
    let done = slurm.submit("2");
    assert_eq!(done.code, 1, "{}{}", done.err, slurm.log());
    let submitted = fs::read_to_string(slurm.state("submitted")).unwrap();
    assert_eq!(submitted, "1 1-2\n2\n");
}
