//! The golden set: small files of every dialect and every fault that was seen in the wild, each
//! with the channel, unit, rate, samples, findings, message and exit code that it must give.
//!
//! One recording is behind them all: a push of 30 g for 20 ms with noise, 800 samples at 10 kHz
//! from -20 ms on, which the paper's lever survives if a negative acceleration opens it. A case
//! is one entry in a table: what is written, and what it says to a careful reader. Tables of text files
//! are data (`tests/data/golden/`, read by `data`), those of binary files are built here.
//! What comes out is held against the samples as they were written, by their hash, so that no
//! value, rate or start can be misread in silence. The expectations come from the files alone.
//!
//! Each case is judged once, in this process, and every test reads that one answer. The program
//! answers a small part of the set again (`program`), and other processors a quarter of it: with
//! `LATCHGATE_GOLDEN_HASHES=FOLDER` in the environment the tests of the tables check nothing and
//! write the hash of each answer, with `LATCHGATE_GOLDEN_EVERY=N` that of each Nth (`tests/machines`).

#![allow(missing_docs, reason = "tests are read, not linked")]
#![allow(
    clippy::unwrap_used,
    clippy::float_cmp,
    clippy::print_stdout,
    clippy::print_stderr,
    clippy::disallowed_methods,
    clippy::disallowed_types,
    reason = "tests may"
)]

mod answer;
mod built;
mod case;
mod check;
mod clock;
mod data;
mod logs;
mod numbers;
#[path = "../it/support/program.rs"]
#[allow(dead_code, reason = "the other tests feed the program, these do not")]
mod process;
mod program;
#[path = "../it/shown/faults.rs"]
mod shown;
mod tdms;
mod template;
mod topics;
mod workbook;

use case::{Case, FROM, Read, TO, g, good, push, refused, s, to_and_fro};
use latchgate_test_support::Folder;
use process::without_run;
use sha2::{Digest, Sha256};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A table of cases.
struct Table {
    name: &'static str,
    built: fn() -> Vec<Case>,
    answers: OnceLock<Vec<Answered>>,
}

impl Table {
    /// A table that is data.
    const fn of_data(name: &'static str) -> Self {
        Self::built(name, Vec::new)
    }

    const fn built(name: &'static str, built: fn() -> Vec<Case>) -> Self {
        Self {
            name,
            built,
            answers: OnceLock::new(),
        }
    }

    fn cases(&self) -> Vec<Case> {
        let built = (self.built)();
        match built.is_empty() {
            true => data::cases(self.name),
            false => built,
        }
    }

    /// The answers to its cases; whoever comes first judges them.
    fn answers(&self) -> &[Answered] {
        self.answers.get_or_init(|| {
            each_case(self.name, &self.cases(), |index, case, path| {
                let judged = check::judged(case, path);
                let place = |fault: &String| format!("{} ({index}): {fault}", case.name);
                Answered {
                    name: format!("{} {index:03} {}", self.name, case.name),
                    essence: numbers::hash(judged.code, &judged.document),
                    faults: judged.faults.iter().map(place).collect(),
                }
            })
        })
    }
}

static TABLES: [Table; 11] = [
    Table::of_data("tables"),
    Table::of_data("clocks"),
    Table::of_data("names"),
    Table::of_data("labview"),
    Table::built("tdms", tdms::cases),
    Table::built("workbook", workbook::cases),
    Table::of_data("nhtsa"),
    Table::of_data("mme"),
    Table::built("logs", logs::cases),
    Table::built("topics", topics::cases),
    Table::of_data("samples"),
];

/// What is kept of the answer to a case.
struct Answered {
    /// Table, index and name of the case.
    name: String,
    /// Hash of its numbers and findings.
    essence: String,
    /// All that is wrong with it.
    faults: Vec<String>,
}

/// Writes the files of each case and calls `work` with its index and the path to open, on all
/// cores; the results have the order of the cases.
fn each_case<T: Send>(
    table: &str,
    cases: &[Case],
    work: impl Fn(usize, &Case, &Path) -> T + Sync,
) -> Vec<T> {
    let folder = Folder::new(&format!("golden-{table}"));
    let next = AtomicUsize::new(0);
    let worker = || {
        let mut results = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(case) = cases.get(index) else {
                return results;
            };
            let path = write_case(&folder.path().join(index.to_string()), case);
            results.push((index, work(index, case, &path)));
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut results: Vec<(usize, T)> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(worker)).collect();
        let ended = workers.into_iter().map(|worker| worker.join().unwrap());
        ended.flatten().collect()
    });
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}

/// Writes the files of a case and returns the path of the one that is opened.
fn write_case(folder: &Path, case: &Case) -> PathBuf {
    for (name, bytes) in &case.files {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    folder.join(&case.opened)
}

/// Writes the files of every case to `folder/INDEX/`, and to `folder/INDEX.case` its name, the file
/// that is opened and its options, one a line: what `tests/same-answers` asks two programs.
fn write_cases(folder: &Path, cases: &[Case]) {
    for (index, case) in cases.iter().enumerate() {
        write_case(&folder.join(index.to_string()), case);
        let lines = [&[case.name.clone(), case.opened.clone()], &*case.options].concat();
        assert!(lines.iter().all(|line| !line.contains('\n')), "{lines:?}");
        fs::write(folder.join(format!("{index}.case")), lines.join("\n")).unwrap();
    }
}

/// Writes the hash of the document of every case without its run, one a line.
fn write_hashes(folder: &Path, table: &Table) {
    let every = std::env::var("LATCHGATE_GOLDEN_EVERY");
    let every: usize = every.map_or(1, |every| every.parse().unwrap());
    let lines = each_case(table.name, &table.cases(), |index, case, path| {
        if !index.is_multiple_of(every) {
            return String::new();
        }
        let document = answer::written(&answer::judge(case, path));
        let digest = Sha256::digest(without_run(&document).as_bytes());
        format!("{} {index:03} {}\n", hex(&digest), case.name)
    });
    fs::create_dir_all(folder).unwrap();
    fs::write(folder.join(table.name), lines.concat()).unwrap();
}

fn hex(digest: &[u8]) -> String {
    digest.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// Judges every case of a table, and lists all that went wrong with its file.
#[track_caller]
fn check(name: &str) {
    let table = TABLES.iter().find(|table| table.name == name);
    let table = table.expect("a table of the set");
    let folder = |variable| std::env::var_os(variable).map(PathBuf::from);
    if let Some(folder) = folder("LATCHGATE_GOLDEN_CASES") {
        return write_cases(&folder.join(name), &table.cases());
    }
    if let Some(folder) = folder("LATCHGATE_GOLDEN_HASHES") {
        return write_hashes(&folder, table);
    }
    let answers = table.answers().iter();
    let faults: Vec<&str> = answers
        .flat_map(|answered| &answered.faults)
        .map(String::as_str)
        .collect();
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn val_golden_tables() {
    check("tables");
}

#[test]
fn val_golden_clocks() {
    check("clocks");
}

#[test]
fn val_golden_names() {
    check("names");
}

#[test]
fn val_golden_labview_files() {
    check("labview");
}

#[test]
fn val_golden_tdms_files() {
    check("tdms");
}

#[test]
fn val_golden_workbooks() {
    check("workbook");
}

#[test]
fn val_golden_nhtsa_tests() {
    check("nhtsa");
}

#[test]
fn val_golden_iso_mme_tests() {
    check("mme");
}

#[test]
fn val_golden_logs() {
    check("logs");
}

#[test]
fn val_golden_topics() {
    check("topics");
}

#[test]
fn val_golden_faults_in_samples() {
    check("samples");
}

/// The set is as large as it claims to be, and no bad recording in it may pass.
#[test]
fn tidy_the_golden_set_is_whole() {
    let cases: Vec<Case> = TABLES.iter().flat_map(|table| table.cases()).collect();
    let (good, bad): (Vec<&Case>, Vec<&Case>) = cases.iter().partition(|case| case.exit != 4);
    println!(
        "golden set: {} files, {} of them refused or unusable",
        cases.len(),
        bad.len()
    );
    assert!(cases.len() >= 1800, "{} cases", cases.len());
    assert!(good.len() >= 700 && bad.len() >= 1100);
    for case in &cases {
        let blocks = case
            .findings
            .iter()
            .any(|text| text.starts_with("blocking"));
        assert!(
            !blocks || case.exit != 0,
            "{}: a pass from a bad one",
            case.name
        );
        assert!(
            case.exit != 4 || !case.says.is_empty(),
            "{}: no message",
            case.name
        );
    }
}

/// The samples of every table that is written in g.
#[test]
fn verif_the_samples_of_the_set_rise_and_fall_as_meant() {
    let values = case::numbers(g);
    let peak = values.iter().copied().fold(f64::MIN, f64::max);
    assert!((peak - 30.05).abs() < 0.05, "{peak}");
    let sum: f64 = values.iter().sum();
    assert!((sum * 9.806_65 / 1e4 - 3.745).abs() < 0.01, "{sum}");
}
