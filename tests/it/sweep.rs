//! Guards the shares of a gate: whatever ends their processes, what is collected is what one
//! undisturbed process would have said, and nothing that is missing is left out.

mod collected;
mod ends;

use crate::support::{Done, Folder, finish, half_sine, program, table};
use std::fs;
use std::path::PathBuf;
use std::time::Duration;

/// A gate of pulses that grow, and levers of preloads that grow.
struct SweepYard {
    folder: Folder,
}

impl SweepYard {
    fn new(name: &str, recordings: usize, designs: usize, members: u32) -> Self {
        let yard = Self {
            folder: Folder::new(&format!("sweep-{name}")),
        };
        for number in 0..recordings {
            yard.recording(number, 4.0 + 30.0 * number as f64 / recordings as f64);
        }
        let mut gate = format!(
            "[[recordings]]\nfiles = \"recordings/*.csv\"\nopens_when = \"negative\"\nmembers = {members}\n"
        );
        for number in 0..designs {
            let preload = 0.6 + 6.0 * number as f64 / designs as f64;
            gate += &format!(
                "[[designs]]\nname = \"d{number:03}\"\nset = {{ \"lever.preload_torque_nm\" = {preload:.4} }}\n"
            );
        }
        yard.folder.write("gate.toml", gate);
        yard
    }

    /// Writes the recording of that number with that peak [g].
    fn recording(&self, number: usize, peak_g: f64) {
        let pulse = |time: f64| half_sine(time, 0.0, 0.03, -peak_g) + 0.01 * (time * 9_100.0).sin();
        let name = format!("recordings/r{number:04}.csv");
        self.folder.write(&name, table(pulse));
        self.folder
            .write(&format!("{name}.toml"), "synthetic = true\n");
    }

    fn command(&self, more: &[&str]) -> std::process::Command {
        let mut command = program();
        command
            .current_dir(self.folder.path())
            .args(["gate", "gate.toml", "--reports", "none"])
            .args(more);
        command
    }

    fn gate(&self, more: &[&str]) -> Done {
        finish(&mut self.command(more))
    }

    /// Judges a share into the folder `store`.
    fn part(&self, part: &str, more: &[&str]) -> Done {
        self.gate(&[&["--store", "store", "--part", part], more].concat())
    }

    fn collect(&self, more: &[&str]) -> Done {
        let own = ["--store", "store", "--collect", "--out", "collected"];
        self.gate(&[&own[..], more].concat())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Files of the store that hold decisions.
    fn files(&self) -> Vec<PathBuf> {
        let listed = fs::read_dir(self.path("store")).unwrap();
        let paths = listed.map(|entry| entry.unwrap().path());
        let mut found: Vec<PathBuf> = paths
            .filter(|path| path.extension().is_some_and(|end| end == "jsonl"))
            .collect();
        found.sort();
        found
    }

    /// Waits until the store's files hold so many lines.
    fn wait_for_lines(&self, least: usize) {
        let lines =
            |path: &PathBuf| fs::read_to_string(path).map_or(0, |text| text.lines().count());
        while !self.path("store").exists() || self.files().iter().map(lines).sum::<usize>() < least
        {
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

/// The number of pairs that a share says of a word, such as `pairs judged`.
#[track_caller]
fn told(done: &Done, what: &str) -> usize {
    // One is told of as one.
    let one = what
        .replacen("s ", " ", 1)
        .trim_end_matches('s')
        .to_string();
    let before = [what, &one]
        .into_iter()
        .find_map(|what| done.err.split_once(what));
    let before = before.map_or(done.err.as_str(), |(before, _)| before);
    let number = before.trim_end().rsplit([' ', '\n']).next().unwrap();
    number
        .parse()
        .unwrap_or_else(|_| panic!("{what}: {}", done.err))
}
