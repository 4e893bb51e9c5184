//! Compares the answers of two builds of latchgate, so that a change which should move no number
//! can be seen to move none.
//!
//! `tests/same-answers BEFORE AFTER` builds this file, writes the cases of the golden set out and
//! runs it. Both programs get the same questions: every recording of `signals/` with two dozen
//! sets of options (`replay`, and `verify` of its own verdict and of the other program's),
//! `inspect`, `margin`, the text answers and a whole report, then every case of the golden set
//! (`replay`, `inspect`, and `inspect` of each channel that can be chosen). Standard output,
//! standard error, the exit code and the files of a report are held against each other: documents
//! key by key in their order and digit by digit, but for their block `run`; all else line by line.
//!
//! What differs is put together by kind: the command, the key with `[]` for any index, and what
//! became of it. Each kind is one paragraph with the number of its cases and examples;
//! `--all` names every case. Differences on purpose are named in a file, `--intended FILE`, one a
//! line, `#` before a remark:
//!
//! ```text
//! added report_id              a key that AFTER has and BEFORE has not, in any answer
//! removed replay:request.old   the same the other way round, in answers of one command alone
//! changed findings[].text      a value of this key
//! changed margin:boundaries*   and of every key that begins so
//! changed stderr               standard error; likewise `stdout`, `exit`
//! ```
//!
//! Exit codes: 0 no difference but those, 1 others, 2 wrong usage.
//!
//! It needs nothing but the standard library, so that it builds in seconds whatever state the
//! sources are in.

#![allow(clippy::disallowed_methods, reason = "a program of its own")]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

const USAGE: &str = "usage: same_answers BEFORE AFTER --signals DIR [--golden DIR] \
                     [--intended FILE] [--only TEXT] [--all] [--threads N]";

fn main() -> ExitCode {
    match Task::from_arguments(std::env::args().skip(1)).and_then(|task| task.run()) {
        Ok(same) => ExitCode::from(u8::from(!same)),
        Err(message) => {
            eprintln!("same_answers: {message}");
            ExitCode::from(2)
        }
    }
}

/// What the command line asks for.
struct Task {
    programs: [PathBuf; 2],
    signals: PathBuf,
    golden: Option<PathBuf>,
    intended: Vec<Intended>,
    only: Option<String>,
    all: bool,
    threads: usize,
}

impl Task {
    fn from_arguments(arguments: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut programs = Vec::new();
        let (mut signals, mut golden, mut intended, mut only) = (None, None, Vec::new(), None);
        let mut all = false;
        let mut threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let mut arguments = arguments;
        while let Some(argument) = arguments.next() {
            let mut value = || {
                let missing = || format!("{argument} needs a value\n{USAGE}");
                arguments.next().ok_or_else(missing)
            };
            match argument.as_str() {
                "--signals" => signals = Some(PathBuf::from(value()?)),
                "--golden" => golden = Some(PathBuf::from(value()?)),
                "--intended" => {
                    let file = value()?;
                    let text = fs::read_to_string(&file).map_err(|e| format!("{file}: {e}"))?;
                    for line in text.lines() {
                        intended.extend(Intended::parse(line)?);
                    }
                }
                "--only" => only = Some(value()?),
                "--all" => all = true,
                "--threads" => threads = value()?.parse().map_err(|e| format!("--threads: {e}"))?,
                option if option.starts_with('-') => return Err(format!("{option}?\n{USAGE}")),
                _ => programs
                    .push(fs::canonicalize(&argument).map_err(|e| format!("{argument}: {e}"))?),
            }
        }
        let programs = <[PathBuf; 2]>::try_from(programs).map_err(|_| USAGE.to_string())?;
        let absolute =
            |path: PathBuf| fs::canonicalize(&path).map_err(|e| format!("{path:?}: {e}"));
        Ok(Self {
            programs,
            signals: absolute(signals.ok_or(USAGE)?)?,
            golden: golden.map(absolute).transpose()?,
            intended,
            only,
            all,
            threads,
        })
    }

    /// Runs all cases; `true` where nothing differs but what was intended.
    fn run(&self) -> Result<bool, String> {
        let scratch = std::env::temp_dir().join(format!("same-answers-{}", std::process::id()));
        let mut cases = signal_cases(&self.signals, &scratch)?;
        if let Some(golden) = &self.golden {
            cases.extend(golden_cases(golden)?);
        }
        if let Some(only) = &self.only {
            cases.retain(|case| case.name.contains(only.as_str()));
        }
        let next = AtomicUsize::new(0);
        let (answers, found) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
        std::thread::scope(|scope| {
            for _ in 0..self.threads {
                scope.spawn(|| {
                    while let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
                        let differences = case.compare(&self.programs, &answers);
                        found.lock().expect("no thread panics").extend(differences);
                    }
                });
            }
        });
        let _ = fs::remove_dir_all(&scratch);
        let mut found = found.into_inner().expect("no thread panics");
        found.sort_by(|a, b| (&a.case, &a.step).cmp(&(&b.case, &b.step)));
        println!(
            "{} answers of {} cases compared",
            answers.into_inner(),
            cases.len()
        );
        let (intended, others): (Vec<Found>, Vec<Found>) = found
            .into_iter()
            .partition(|found| self.intended.iter().any(|one| one.covers(found)));
        self.tell("intended", &intended);
        self.tell("DIFFERENT", &others);
        for unused in self
            .intended
            .iter()
            .filter(|one| !intended.iter().any(|f| one.covers(f)))
        {
            println!("\nintended, not seen: {} {}", unused.what, unused.path);
        }
        if others.is_empty() {
            println!(
                "\nno difference{}",
                if intended.is_empty() {
                    ""
                } else {
                    " but those"
                }
            );
        }
        Ok(others.is_empty())
    }

    fn tell(&self, title: &str, found: &[Found]) {
        let mut kinds: BTreeMap<(String, String, String), Vec<&Found>> = BTreeMap::new();
        for one in found {
            let difference = &one.difference;
            let key = (
                difference.what.into(),
                one.command().into(),
                difference.path.clone(),
            );
            kinds.entry(key).or_default().push(one);
        }
        for ((what, command, path), members) in kinds {
            // Equal changes of words inside a kind are one line; numbers stay apart.
            let mut changes: Vec<(String, Vec<&Found>)> = Vec::new();
            for one in members.iter().copied() {
                let change = one.difference.change();
                match changes.iter_mut().find(|(text, _)| *text == change) {
                    Some((_, same)) => same.push(one),
                    None => changes.push((change, vec![one])),
                }
            }
            changes.sort_by_key(|(_, same)| std::cmp::Reverse(same.len()));
            println!(
                "\n{title}: {what} {command}:{path}, {} times",
                members.len()
            );
            let shown = if self.all { usize::MAX } else { 4 };
            for (change, same) in changes.iter().take(shown) {
                println!("  {} x {change}", same.len());
                for one in same.iter().take(if self.all { usize::MAX } else { 1 }) {
                    println!("      {} / {}", one.case, one.step);
                    println!("      - {}", short(&one.difference.before, 300));
                    println!("      + {}", short(&one.difference.after, 300));
                }
            }
            if changes.len() > shown {
                println!(
                    "  and {} other changes; --all shows them",
                    changes.len() - shown
                );
            }
        }
    }
}

/// A difference that is meant.
struct Intended {
    what: String,
    command: Option<String>,
    path: String,
}

impl Intended {
    fn parse(line: &str) -> Result<Option<Self>, String> {
        let line = line.split('#').next().unwrap_or_default().trim();
        let mut words = line.split_whitespace();
        let (Some(what), Some(path)) = (words.next(), words.next()) else {
            return if line.is_empty() {
                Ok(None)
            } else {
                Err(format!("`{line}`: no key"))
            };
        };
        if !["added", "removed", "changed"].contains(&what) {
            return Err(format!("`{line}`: expected added, removed or changed"));
        }
        let (command, path) = match path.split_once(':') {
            Some((command, path)) => (Some(command.to_string()), path),
            None => (None, path),
        };
        Ok(Some(Self {
            what: what.into(),
            command,
            path: path.into(),
        }))
    }

    fn covers(&self, found: &Found) -> bool {
        let path = &found.difference.path;
        self.what == found.difference.what
            && self
                .command
                .as_deref()
                .is_none_or(|command| command == found.command())
            && match self.path.strip_suffix('*') {
                Some(start) => path.starts_with(start),
                None => *path == self.path,
            }
    }
}

/// One recording with what is asked of it.
struct Case {
    name: String,
    place: Place,
    steps: Vec<Step>,
    /// Asks about each channel that the answer to the last step offers.
    each_candidate: bool,
}

/// Where a case is run.
enum Place {
    /// In a folder that nothing writes to.
    Shared(PathBuf),
    /// In a folder of its own, which holds these files.
    Own {
        folder: PathBuf,
        files: Vec<PathBuf>,
    },
}

/// One call of the program.
struct Step {
    name: String,
    arguments: Vec<String>,
    /// File that keeps standard output for a later step.
    kept_as: Option<&'static str>,
    /// Folder of the report whose files are compared.
    report: Option<&'static str>,
}

impl Step {
    fn new(name: &str, arguments: &[&str]) -> Self {
        Self {
            name: name.into(),
            arguments: arguments.iter().map(|text| (*text).to_string()).collect(),
            kept_as: None,
            report: None,
        }
    }
}

/// What a call left behind, by name: `exit`, `stderr`, `stdout`, files of a report.
type Answer = Vec<(String, Vec<u8>)>;

/// A difference with where it was found.
struct Found {
    case: String,
    step: String,
    difference: Difference,
}

impl Found {
    fn command(&self) -> &str {
        self.step.split(' ').next().unwrap_or_default()
    }
}

impl Case {
    fn compare(&self, programs: &[PathBuf; 2], answers: &AtomicUsize) -> Vec<Found> {
        let folders = match &self.place {
            Place::Shared(folder) => [folder.clone(), folder.clone()],
            Place::Own { folder, files } => ["before", "after"].map(|side| {
                let folder = folder.join(side);
                fs::create_dir_all(&folder).expect("the scratch folder can be written");
                for file in files {
                    let name = file.file_name().expect("a file");
                    fs::copy(file, folder.join(name)).expect("a recording can be copied");
                }
                folder
            }),
        };
        let mut found = Vec::new();
        let mut both = |step: &Step| {
            let before = run(&programs[0], &folders[0], step);
            answers.fetch_add(1, Ordering::Relaxed);
            if let (Some(name), Place::Own { .. }) = (step.kept_as, &self.place) {
                let document = &before
                    .iter()
                    .find(|(key, _)| key == "stdout")
                    .expect("kept")
                    .1;
                for folder in &folders {
                    fs::write(folder.join(format!("before-{name}")), document).expect("written");
                }
            }
            let after = run(&programs[1], &folders[1], step);
            found.extend(
                differences(&before, &after)
                    .into_iter()
                    .map(|difference| Found {
                        case: self.name.clone(),
                        step: step.name.clone(),
                        difference,
                    }),
            );
            before
        };
        let mut last = Vec::new();
        for step in &self.steps {
            last = both(step);
        }
        if self.each_candidate {
            for name in candidates(&last) {
                let step = self.steps.last().expect("a case has a step");
                let path = step.arguments[1].as_str();
                let arguments = ["inspect", path, "--channel", &name, "--format", "json"];
                both(&Step::new(&format!("inspect --channel {name}"), &arguments));
            }
        }
        if let Place::Own { folder, .. } = &self.place {
            let _ = fs::remove_dir_all(folder);
        }
        found
    }
}

/// Channels that an answer of `inspect` offers to replay.
fn candidates(answer: &Answer) -> Vec<String> {
    let text = answer
        .iter()
        .find(|(key, _)| key == "stdout")
        .map(|(_, text)| text.as_slice());
    let Some(document) = text.and_then(|text| Json::parse(std::str::from_utf8(text).ok()?)) else {
        return Vec::new();
    };
    match document
        .at("replay")
        .and_then(|replay| replay.at("candidates"))
    {
        Some(Json::Array(names)) => names
            .iter()
            .filter_map(|name| match name {
                Json::Scalar(text) => Some(text.trim_matches('"')),
                _ => None,
            })
            // What would have to be unescaped is asked by the golden test itself.
            .filter(|name| !name.contains('\\'))
            .map(str::to_string)
            .collect(),
        _ => Vec::new(),
    }
}

fn run(program: &Path, folder: &Path, step: &Step) -> Answer {
    let output = Command::new(program)
        .args(&step.arguments)
        .current_dir(folder)
        .env_remove("NO_COLOR")
        .env_remove("CLICOLOR_FORCE")
        .stdin(Stdio::null())
        .output()
        .expect("the program starts");
    if let Some(name) = step.kept_as {
        fs::write(folder.join(name), &output.stdout).expect("the scratch folder can be written");
    }
    let mut answer = vec![
        (
            "exit".to_string(),
            format!("{:?}", output.status.code()).into_bytes(),
        ),
        ("stderr".into(), output.stderr),
        ("stdout".into(), output.stdout),
    ];
    if let Some(report) = step.report {
        let mut files: Vec<PathBuf> = fs::read_dir(folder.join(report))
            .map(|entries| {
                entries
                    .filter_map(|entry| Some(entry.ok()?.path()))
                    .collect()
            })
            .unwrap_or_default();
        files.sort();
        for file in files {
            let name = file
                .file_name()
                .expect("a file")
                .to_string_lossy()
                .into_owned();
            answer.push((name, fs::read(&file).unwrap_or_default()));
        }
    }
    answer
}

/// Sets of options of `replay`, one a line.
const OPTIONS: &str = "
--members 128
--members 0
--members 400 --seed 7 --model rigid
--members 128 --model soft
--members 64 --opens-when both
--members 0 --opens-when positive
--members 128 --opens-when negative --filter none
--members 0 --filter cfc180 --filter-standard saej211
--members 0 --resample 4000
--members 0 --bias none
--members 0 --bias=-0.015..-0.005
--members 64 --window 0..0.03
--members 0 --window 5..6
--members 0 --method rk4 --steps-per-period 600
--members 0 --method rk4-located --steps-per-period 600
--members 0 --method dopri5 --tolerance 1e-8
--members 0 --method dopri5-samples --tolerance 1e-8
--members 0 --method moreau-jean --model rigid --steps-per-period 2000
--members 0 --method moreau-jean
--members 128 --set lever.preload_torque_nm=2.82 --set stop.restitution=0.5
--members 0 --set lever.preload_torqe_nm=2.82
--members 0 --phi0 0.02 --omega0 1
--members 0 --channel nothing
--members 0 --unit m/s2
--members 0 --time-unit ms
--members 0 --rate-hz 1000
--members 0 --limit samples=100
--members 0 --design missing.toml
--members 0 --input-format mcap
--members 0 --time-zero 0.01
";

/// Cases of `signals/`: all sets of options, then the other commands and a whole report.
fn signal_cases(signals: &Path, scratch: &Path) -> Result<Vec<Case>, String> {
    let mut files: Vec<PathBuf> = fs::read_dir(signals)
        .map_err(|e| format!("{}: {e}", signals.display()))?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|end| end != "toml"))
        .collect();
    files.sort();
    let mut cases = Vec::new();
    for file in files {
        let name = file
            .file_name()
            .expect("a file")
            .to_string_lossy()
            .into_owned();
        let card = file.with_file_name(format!("{name}.toml"));
        let mut case = |what: &str, steps: Vec<Step>| {
            cases.push(Case {
                name: format!("{name} {what}"),
                place: Place::Own {
                    folder: scratch.join(cases.len().to_string()),
                    files: vec![file.clone(), card.clone()],
                },
                steps,
                each_candidate: false,
            });
        };
        let json = ["--format", "json"];
        for options in OPTIONS.lines().filter(|line| !line.is_empty()) {
            let words: Vec<&str> = options.split(' ').collect();
            let mut replay = Step::new(
                "replay",
                &[&["replay", &name, "--no-report"], &*words, &json].concat(),
            );
            replay.kept_as = Some("verdict.json");
            let own = Step::new("verify", &[&["verify", "verdict.json"][..], &json].concat());
            let other = ["verify", "before-verdict.json"];
            let other = Step::new("verify of BEFORE", &[&other[..], &json].concat());
            case(options, vec![replay, own, other]);
        }
        let mut report = Step::new("report", &["replay", &name, "--out", "report"]);
        report.report = Some("report");
        let margin = ["margin", &name];
        case(
            "other commands",
            vec![
                report,
                Step::new("inspect", &[&["inspect", &name][..], &json].concat()),
                Step::new("inspect as text", &["inspect", &name]),
                Step::new(
                    "replay as text",
                    &["replay", &name, "--no-report", "--members", "64"],
                ),
                Step::new(
                    "margin",
                    &[&margin[..], &["--no-report", "--members", "0"], &json].concat(),
                ),
            ],
        );
        // With members only where few samples make it quick.
        if fs::metadata(&file).is_ok_and(|data| data.len() < 60_000) {
            let few = [&margin[..], &["--members", "40"]].concat();
            let mut margin = Step::new("margin-report", &[&few[..], &["--out", "margin"]].concat());
            margin.report = Some("margin");
            case(
                "margin with members",
                vec![
                    Step::new("margin", &[&few[..], &["--no-report"], &json].concat()),
                    margin,
                ],
            );
        }
    }
    Ok(cases)
}

/// Cases of the golden set as its tests wrote them out: `TABLE/INDEX.case` beside `TABLE/INDEX/`.
fn golden_cases(folder: &Path) -> Result<Vec<Case>, String> {
    let wrong = |path: &Path, e: std::io::Error| format!("{}: {e}", path.display());
    let mut lists = Vec::new();
    for table in fs::read_dir(folder).map_err(|e| wrong(folder, e))? {
        let table = table.map_err(|e| wrong(folder, e))?.path();
        if table.is_dir() {
            for entry in fs::read_dir(&table).map_err(|e| wrong(&table, e))? {
                let path = entry.map_err(|e| wrong(&table, e))?.path();
                if path.extension().is_some_and(|end| end == "case") {
                    lists.push(path);
                }
            }
        }
    }
    lists.sort();
    if lists.len() < 100 {
        return Err(format!(
            "{}: {} cases, too few",
            folder.display(),
            lists.len()
        ));
    }
    let case = |list: &PathBuf| {
        let text = fs::read_to_string(list).map_err(|e| wrong(list, e))?;
        let mut lines = text.lines();
        let name = lines.next().unwrap_or_default();
        let opened = lines.next().unwrap_or_default();
        let options: Vec<&str> = lines.collect();
        let table = list.parent().and_then(Path::file_name).unwrap_or_default();
        let index = list.file_stem().unwrap_or_default().to_string_lossy();
        // A folder is opened by its own name, so that no machine's path is in an answer.
        let path = if opened.is_empty() {
            format!("{index}/")
        } else {
            format!("{index}/{opened}")
        };
        fn call<'a>(own: &[&'a str], options: &[&'a str]) -> Vec<&'a str> {
            [own, options, &["--format", "json"]].concat()
        }
        let replay = call(
            &["replay", &path, "--no-report", "--members", "0"],
            &options,
        );
        // `--opens-when NAME` is for those who judge.
        let inspect = call(&["inspect", &path], &options[2..]);
        Ok(Case {
            name: format!("golden {} {index} {name}", table.to_string_lossy()),
            place: Place::Shared(list.parent().expect("a table").to_path_buf()),
            steps: vec![Step::new("replay", &replay), Step::new("inspect", &inspect)],
            each_candidate: true,
        })
    };
    lists.iter().map(case).collect()
}

/// One difference between two answers.
struct Difference {
    /// `added`, `removed` or `changed`.
    what: &'static str,
    /// Key with `[]` for any index, or the name of the file or stream.
    path: String,
    before: String,
    after: String,
}

impl Difference {
    fn new(what: &'static str, path: &str, before: &str, after: &str) -> Self {
        Self {
            what,
            path: path.into(),
            before: before.into(),
            after: after.into(),
        }
    }

    /// What differs in words, without the words around it that both share; numbers stay whole.
    fn change(&self) -> String {
        if self.what != "changed" {
            return format!("{}{}", short(&self.before, 60), short(&self.after, 60));
        }
        let (before, after): (Vec<&str>, Vec<&str>) = (
            self.before.split(' ').collect(),
            self.after.split(' ').collect(),
        );
        let pairs = before.iter().zip(&after);
        let head = pairs.take_while(|(a, b)| a == b).count();
        let pairs = before[head..].iter().rev().zip(after[head..].iter().rev());
        let tail = pairs.take_while(|(a, b)| a == b).count();
        let middle = |words: &[&str]| short(&words[head..words.len() - tail].join(" "), 120);
        format!("{} -> {}", middle(&before), middle(&after))
    }
}

fn short(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.into();
    }
    let start: String = text.chars().take(most).collect();
    format!("{start} ...")
}

fn differences(before: &Answer, after: &Answer) -> Vec<Difference> {
    let mut found = Vec::new();
    let get = |answer: &Answer, name: &str| {
        answer
            .iter()
            .find(|(key, _)| key == name)
            .map(|(_, bytes)| bytes.clone())
    };
    for (name, old) in before {
        let Some(new) = get(after, name) else {
            found.push(Difference::new("removed", name, "", ""));
            continue;
        };
        let (old_text, new_text) = (String::from_utf8_lossy(old), String::from_utf8_lossy(&new));
        match (Json::document(&old_text), Json::document(&new_text)) {
            (Some(old), Some(new)) => {
                let start = if name == "stdout" { "" } else { name };
                compare(start, &old, &new, &mut found);
                if old == new && old_text.lines().count() != new_text.lines().count() {
                    found.push(Difference::new("changed", "layout of the document", "", ""));
                }
            }
            _ if *old != new => lines(name, &old_text, &new_text, &mut found),
            _ => {}
        }
    }
    for (name, _) in after {
        if get(before, name).is_none() {
            found.push(Difference::new("added", name, "", ""));
        }
    }
    found
}

/// Compares text line by line where both have as many lines, else tells the first that differs.
fn lines(name: &str, before: &str, after: &str, found: &mut Vec<Difference>) {
    let (old, new): (Vec<&str>, Vec<&str>) = (before.lines().collect(), after.lines().collect());
    let differing = (0..old.len().max(new.len())).filter(|&i| old.get(i) != new.get(i));
    let most = if old.len() == new.len() {
        usize::MAX
    } else {
        1
    };
    for index in differing.take(most) {
        let line = |lines: &[&str]| (*lines.get(index).unwrap_or(&"(ended)")).to_string();
        found.push(Difference::new("changed", name, &line(&old), &line(&new)));
    }
    if old == new {
        found.push(Difference::new(
            "changed",
            &format!("{name}, line ends"),
            "",
            "",
        ));
    }
}

/// A JSON value whose scalars stay the text they were and whose keys keep their order.
#[derive(Debug, PartialEq)]
enum Json {
    Object(Vec<(String, Json)>),
    Array(Vec<Json>),
    Scalar(String),
}

impl Json {
    /// Reads a document without its block `run`; `None` for any other text.
    fn document(text: &str) -> Option<Self> {
        match Self::parse(text)? {
            Self::Object(mut entries) => {
                entries.retain(|(key, _)| key != "run");
                Some(Self::Object(entries))
            }
            _ => None,
        }
    }

    fn parse(text: &str) -> Option<Self> {
        let mut rest = text.trim();
        let value = Self::take(&mut rest)?;
        rest.trim().is_empty().then_some(value)
    }

    fn at(&self, key: &str) -> Option<&Self> {
        match self {
            Self::Object(entries) => entries
                .iter()
                .find(|(name, _)| name == key)
                .map(|(_, value)| value),
            _ => None,
        }
    }

    fn take(rest: &mut &str) -> Option<Self> {
        *rest = rest.trim_start();
        match rest.bytes().next()? {
            b'{' => {
                let mut entries = Vec::new();
                Self::list(rest, '}', |rest| {
                    let Self::Scalar(key) = Self::take(rest)? else {
                        return None;
                    };
                    *rest = rest.trim_start().strip_prefix(':')?;
                    entries.push((key.trim_matches('"').into(), Self::take(rest)?));
                    Some(())
                })?;
                Some(Self::Object(entries))
            }
            b'[' => {
                let mut entries = Vec::new();
                Self::list(rest, ']', |rest| {
                    entries.push(Self::take(rest)?);
                    Some(())
                })?;
                Some(Self::Array(entries))
            }
            b'"' => {
                let mut escaped = false;
                let end = rest.char_indices().skip(1).find(|&(_, c)| {
                    let ends = c == '"' && !escaped;
                    escaped = c == '\\' && !escaped;
                    ends
                })?;
                Some(Self::scalar(rest, end.0 + 1))
            }
            _ => {
                let end = rest.find(|c: char| c.is_whitespace() || ",]}".contains(c));
                let end = end.unwrap_or(rest.len());
                let known = |text: &str| {
                    ["true", "false", "null"].contains(&text) || text.parse::<f64>().is_ok()
                };
                known(&rest[..end]).then(|| Self::scalar(rest, end))
            }
        }
    }

    fn scalar(rest: &mut &str, end: usize) -> Self {
        let (text, after) = rest.split_at(end);
        *rest = after;
        Self::Scalar(text.into())
    }

    fn list(
        rest: &mut &str,
        end: char,
        mut entry: impl FnMut(&mut &str) -> Option<()>,
    ) -> Option<()> {
        *rest = rest[1..].trim_start();
        if let Some(after) = rest.strip_prefix(end) {
            *rest = after;
            return Some(());
        }
        loop {
            entry(rest)?;
            *rest = rest.trim_start();
            if let Some(after) = rest.strip_prefix(end) {
                *rest = after;
                return Some(());
            }
            *rest = rest.strip_prefix(',')?;
        }
    }

    fn text(&self) -> String {
        match self {
            Self::Object(entries) => {
                let one = |(key, value): &(String, Self)| format!("\"{key}\": {}", value.text());
                format!(
                    "{{{}}}",
                    entries.iter().map(one).collect::<Vec<_>>().join(", ")
                )
            }
            Self::Array(entries) => {
                format!(
                    "[{}]",
                    entries
                        .iter()
                        .map(Self::text)
                        .collect::<Vec<_>>()
                        .join(", ")
                )
            }
            Self::Scalar(text) => text.clone(),
        }
    }
}

fn compare(path: &str, before: &Json, after: &Json, found: &mut Vec<Difference>) {
    match (before, after) {
        (Json::Object(old), Json::Object(new)) => {
            let below = |key: &str| {
                if path.is_empty() {
                    key.into()
                } else {
                    format!("{path}.{key}")
                }
            };
            for (key, value) in old {
                match after.at(key) {
                    Some(other) => compare(&below(key), value, other, found),
                    None => {
                        found.push(Difference::new("removed", &below(key), &value.text(), ""));
                    }
                }
            }
            for (key, value) in new {
                if before.at(key).is_none() {
                    found.push(Difference::new("added", &below(key), "", &value.text()));
                }
            }
            let common = |own: &[(String, Json)], other: &Json| {
                let keys = own.iter().map(|(key, _)| key.as_str());
                keys.filter(|key| other.at(key).is_some())
                    .collect::<Vec<_>>()
                    .join(", ")
            };
            let (first, second) = (common(old, after), common(new, before));
            if first != second {
                let name = below("(order of keys)");
                found.push(Difference::new("changed", &name, &first, &second));
            }
        }
        (Json::Array(old), Json::Array(new)) if old.len() == new.len() => {
            for (value, other) in old.iter().zip(new) {
                compare(&format!("{path}[]"), value, other, found);
            }
        }
        (Json::Array(old), Json::Array(new)) => {
            let one = old.iter().zip(new).find(|(a, b)| a != b);
            let number = |list: &[Json], value: Option<&Json>| {
                let value = value.or(list.last()).map_or(String::new(), Json::text);
                format!("{} entries, the first that differs: {value}", list.len())
            };
            let (first, second) = (number(old, one.map(|p| p.0)), number(new, one.map(|p| p.1)));
            found.push(Difference::new(
                "changed",
                &format!("{path}[]"),
                &first,
                &second,
            ));
        }
        _ if before == after => {}
        _ => found.push(Difference::new(
            "changed",
            path,
            &before.text(),
            &after.text(),
        )),
    }
}

/// What is told of two contents of one stream or file, as `what path`; for the test of this
/// program.
#[allow(dead_code, reason = "a test calls it")]
pub(crate) fn told(name: &str, before: &[u8], after: &[u8]) -> Vec<String> {
    let answer = |bytes: &[u8]| vec![(name.to_string(), bytes.to_vec())];
    differences(&answer(before), &answer(after))
        .iter()
        .map(|one| format!("{} {}", one.what, one.path))
        .collect()
}
