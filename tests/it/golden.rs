//! The golden set: small files of every dialect and every fault that was seen in the wild, each
//! with the channel, unit, rate, samples, findings, message and exit code that it must give.
//!
//! One recording is behind them all: a push of 30 g for 20 ms with noise, 800 samples at 10 kHz
//! from -20 ms on, which the paper's lever survives if a negative acceleration opens it. A case
//! is one entry in a table of `golden/`: what is written, and what it says to a careful reader.
//! What comes out is held against the samples as they were written, by their hash, so that no
//! value, rate or start can be misread in silence. The expectations come from the files alone.

mod clocks;
mod labview;
mod logs;
mod mme;
mod names;
mod nhtsa;
mod numbers;
mod samples;
mod tables;
mod tdms;
mod topics;
mod workbook;

use crate::support::{Done, Folder, latchgate};
use latchgate::pipeline::{Control, Document, Listing};
use latchgate_kernel::units::{AccelerationUnit, SampleRate};
use latchgate_recording::{Channel, Limits, ReadOptions, Selection, Source, Stated, card};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Index of the first sample and of the one after the last; sample 0 lies at first contact.
const FROM: i64 = -200;
const TO: i64 = 600;

/// How each case is judged; the push is a shorter record than a crash recorder takes.
const ASKED: [&str; 4] = ["--members", "0", "--accept", "clock"];

/// Sample `k` [g] at 10 kHz.
fn push(k: i64) -> f64 {
    let x = k as f64;
    let pulse = if (0..200).contains(&k) {
        30.0 * (std::f64::consts::PI * x / 200.0).sin()
    } else {
        0.0
    };
    pulse + 0.05 * (0.91 * x).sin() + 0.03 * (2.3 * x + 1.0).sin()
}

/// Sample `k` as files write it [g].
fn g(k: i64) -> String {
    format!("{:.3}", push(k))
}

/// Sample `k` as files write it [m/s²].
fn si(k: i64) -> String {
    format!("{:.3}", push(k) * 9.806_65)
}

/// Time of sample `k` as files write it [s].
fn s(k: i64) -> String {
    format!("{:.4}", k as f64 / 1e4)
}

/// How far the stamps of an irregular clock are off [µs]; its median step stays as it was.
fn to_and_fro(k: i64) -> f64 {
    [0.0, 0.0, 5.0, 0.0, 0.0, -5.0][k.rem_euclid(6) as usize]
}

/// The numbers that the texts of all samples stand for.
fn numbers(text: impl Fn(i64) -> String) -> Vec<f64> {
    (FROM..TO).map(|k| text(k).parse().unwrap()).collect()
}

/// A file with what must come out of it.
struct Case {
    name: String,
    files: Vec<(String, Vec<u8>)>,
    /// Which of the files is opened; empty for their folder.
    opened: String,
    options: Vec<String>,
    exit: i32,
    /// What is read; `None` where the file must be refused.
    read: Option<Read>,
    /// Findings as `severity code`, in any order; those of the conditioning left aside.
    findings: Vec<String>,
    /// Words that the message on stderr must hold.
    says: Vec<String>,
}

/// What is read.
struct Read {
    channel: String,
    unit: &'static str,
    rate_hz: f64,
    start_s: f64,
    samples: usize,
    /// The samples in `unit`; `None` where time was brought to a uniform clock.
    values: Option<Vec<f64>>,
}

/// A file `name` that is read and passes: channel `acc_y_g` in g, until told otherwise.
fn good(name: &str, bytes: impl Into<Vec<u8>>) -> Case {
    Case {
        name: name.into(),
        files: vec![(name.into(), bytes.into())],
        opened: name.into(),
        options: ["--opens-when", "negative"].map(String::from).to_vec(),
        exit: 0,
        read: Some(Read {
            channel: "acc_y_g".into(),
            unit: "g",
            rate_hz: 10_000.0,
            start_s: -0.02,
            samples: (TO - FROM) as usize,
            values: Some(numbers(g)),
        }),
        findings: Vec::new(),
        says: Vec::new(),
    }
}

/// A file that is refused with a message that holds `says`.
fn refused(name: &str, bytes: impl Into<Vec<u8>>, says: &[&str]) -> Case {
    Case {
        exit: 4,
        read: None,
        findings: vec!["blocking input-refused".into()],
        ..good(name, bytes)
    }
    .says(says)
}

impl Case {
    /// The other sign opens the lever.
    fn positive_opens(mut self) -> Self {
        self.options[1] = "positive".into();
        self
    }

    /// Gives the case a name that says more than its file's.
    fn named(mut self, name: &str) -> Self {
        self.name = name.into();
        self
    }

    fn options(mut self, options: &[&str]) -> Self {
        self.options
            .extend(options.iter().map(|text| (*text).to_string()));
        self
    }

    /// Puts a further file beside the first.
    fn beside(mut self, name: &str, bytes: impl Into<Vec<u8>>) -> Self {
        self.files.push((name.into(), bytes.into()));
        self
    }

    /// Opens another file than the first, or with an empty name the folder.
    fn open(mut self, name: &str) -> Self {
        self.opened = name.into();
        self
    }

    fn change(mut self, change: impl FnOnce(&mut Read)) -> Self {
        change(self.read.as_mut().expect("a file that is read"));
        self
    }

    fn channel(self, name: &str) -> Self {
        self.change(|read| read.channel = name.into())
    }

    /// The unit, with the samples as their texts say in that unit.
    fn unit(self, unit: &'static str, text: impl Fn(i64) -> String) -> Self {
        self.change(|read| {
            read.unit = unit;
            read.values = Some(numbers(text));
        })
    }

    fn values(self, values: Vec<f64>) -> Self {
        self.change(|read| {
            read.samples = values.len();
            read.values = Some(values);
        })
    }

    /// As many samples of unstated value.
    fn samples(self, samples: usize) -> Self {
        self.change(|read| {
            read.samples = samples;
            read.values = None;
        })
    }

    fn clock(self, rate_hz: f64, start_s: f64) -> Self {
        self.change(|read| {
            read.rate_hz = rate_hz;
            read.start_s = start_s;
        })
    }

    fn finds(mut self, findings: &[&str]) -> Self {
        self.findings
            .extend(findings.iter().map(|text| (*text).to_string()));
        self
    }

    /// A file that is read and cannot be judged, for a finding that blocks.
    fn unusable(mut self, findings: &[&str], says: &[&str]) -> Self {
        self.exit = 4;
        assert!(findings.iter().any(|text| text.starts_with("blocking ")));
        self.finds(findings).says(says)
    }

    fn says(mut self, words: &[&str]) -> Self {
        self.says
            .extend(words.iter().map(|text| (*text).to_string()));
        self
    }

    fn exit(mut self, code: i32) -> Self {
        self.exit = code;
        self
    }
}

/// Findings that speak of the conditioning and the replay, not of the file, and of the push, which is a
/// short formula.
const LEFT_ASIDE: &[&str] = &[
    "band-empty",
    "beyond-geometry",
    "clock-accepted",
    "filter-not-causal",
    "peak-in-end-padding",
    "polarity-undeclared",
];

fn codes(findings: &Value) -> BTreeSet<String> {
    let listed = findings.as_array().unwrap().iter();
    listed
        .map(|finding| {
            let word = |key: &str| finding[key].as_str().unwrap().to_string();
            (word("severity"), word("code"))
        })
        .filter(|(_, code)| !LEFT_ASIDE.contains(&code.as_str()))
        .map(|(severity, code)| format!("{severity} {code}"))
        .collect()
}

fn hash(read: &Read) -> Option<String> {
    let channel = Channel {
        name: String::new(),
        unit: Some(AccelerationUnit::from_spelling(read.unit).unwrap()),
        unit_source: "",
        start_s: read.start_s,
        rate: SampleRate::from_hertz(read.rate_hz).unwrap(),
        values: read.values.clone()?,
        stated: Stated::default(),
        findings: Vec::new(),
        pulse: None,
    };
    channel.content_sha256()
}

/// Says everything in which an answer differs from what was expected.
fn differences(case: &Case, replayed: &Done, inspected: &Done) -> Vec<String> {
    let mut wrong = Vec::new();
    let mut same = |what: &str, found: String, expected: String| {
        if found != expected {
            wrong.push(format!("{what}: expected {expected}, found {found}"));
        }
    };
    same(
        "exit code",
        replayed.code.to_string(),
        case.exit.to_string(),
    );
    let document = replayed.document();
    let expected: BTreeSet<String> = case.findings.iter().cloned().collect();
    same(
        "findings",
        format!("{:?}", codes(&document["findings"])),
        format!("{expected:?}"),
    );
    // What to choose from belongs to the message before it.
    let chosen = |line: &&str| {
        line.starts_with("  choose: latchgate replay ") || line.starts_with("  try: latchgate ")
    };
    if std::env::var_os("SHOWERR").is_some() {
        eprintln!("@@ {}", replayed.err.trim());
    }
    let lines = replayed.err.lines().filter(|line| !chosen(line)).count();
    same(
        "messages",
        lines.to_string(),
        usize::from(case.exit == 4).to_string(),
    );
    for words in &case.says {
        same(
            &format!("`{words}` in the message"),
            (if replayed.err.contains(words.as_str()) {
                "there"
            } else {
                &*replayed.err
            })
            .into(),
            "there".into(),
        );
    }
    let Some(read) = &case.read else {
        same(
            "verdict",
            document["verdict"].to_string(),
            "\"unusable\"".into(),
        );
        // What `inspect` says of such a file is no promise of a verdict.
        if inspected.code == 0 {
            let taken = &inspected.document()["replay"]["channel"];
            same("inspect takes", taken.to_string(), "null".into());
        }
        return wrong;
    };
    let recording = &document["recording"];
    same(
        "channel",
        recording["channel"].to_string(),
        Value::from(read.channel.clone()).to_string(),
    );
    same(
        "unit",
        recording["unit"].to_string(),
        format!("\"{}\"", read.unit),
    );
    same(
        "samples",
        recording["samples"].to_string(),
        read.samples.to_string(),
    );
    let close = |found: &Value, expected: f64| {
        let found = found.as_f64().unwrap_or(f64::NAN);
        // Where time was mended, its rate is a measurement.
        let slack = if read.values.is_some() { 1e-12 } else { 1e-3 };
        (found - expected).abs() <= slack * expected.abs().max(1e-3)
    };
    for (key, expected) in [("sample_rate_hz", read.rate_hz), ("start_s", read.start_s)] {
        if !close(&recording[key], expected) {
            same(key, recording[key].to_string(), expected.to_string());
        }
    }
    if let Some(hash) = hash(read) {
        same(
            "hash of the signal",
            recording["content_sha256"].to_string(),
            format!("\"{hash}\""),
        );
    }
    // What `inspect` lists is what `replay` takes.
    same(
        "exit code of inspect",
        inspected.code.to_string(),
        "0".into(),
    );
    if inspected.code == 0 {
        let listing = inspected.document();
        let taken = &listing["replay"]["channel"];
        same(
            "inspect takes",
            taken.to_string(),
            recording["channel"].to_string(),
        );
        let entry = listing["channels"]
            .as_array()
            .unwrap()
            .iter()
            .find(|entry| {
                entry["name"] == *taken && entry["content_sha256"] == recording["content_sha256"]
            });
        same(
            "status in the list of inspect",
            entry
                .map_or(&Value::Null, |entry| &entry["status"])
                .to_string(),
            "\"taken\"".into(),
        );
        let series = listing["series"]["time_s"].as_array();
        same(
            "samples of inspect's series",
            series.map_or(0, Vec::len).to_string(),
            read.samples.to_string(),
        );
    }
    wrong
}

/// Writes the files of every case to `folder/INDEX/`, and to `folder/INDEX.case` its name, the file
/// that is opened and its options, one a line: what `tests/same-answers` asks two programs.
fn write_cases(folder: &Path, cases: &[Case]) {
    for (index, case) in cases.iter().enumerate() {
        for (name, bytes) in &case.files {
            let path = folder.join(index.to_string()).join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, bytes).unwrap();
        }
        let lines = [&[case.name.clone(), case.opened.clone()], &*case.options].concat();
        assert!(lines.iter().all(|line| !line.contains('\n')), "{lines:?}");
        fs::write(folder.join(format!("{index}.case")), lines.join("\n")).unwrap();
    }
}

/// Tells where one reading for the chosen channel and for all of them gives another answer than
/// two, with what a card or options could say.
fn one_reading_differs(path: &Path) -> Option<String> {
    let limits = Limits::default();
    let source = Source::File(path.to_path_buf());
    let card = card::read_beside(&source, &limits).ok().flatten();
    let card = card.map(|(card, _)| card).unwrap_or_default();
    let stated = ReadOptions {
        channel: card.channel,
        rate_hz: card.rate,
        unit: card.unit,
        unit_from_card: card.unit.is_some(),
        ..ReadOptions::default()
    };
    let rated = ReadOptions {
        rate_hz: Some(10_000.0),
        unit: Some(AccelerationUnit::StandardGravity),
        ..stated.clone()
    };
    let all = latchgate_recording::read(&source, &stated, Selection::Every, &limits);
    let channels = all.iter().flat_map(|all| &all.channels).take(3);
    let named = channels.map(|channel| ReadOptions {
        channel: Some(channel.name.clone()),
        ..stated.clone()
    });
    let ways: Vec<ReadOptions> = named.chain([stated.clone(), rated]).collect();
    ways.iter().find_map(|options| {
        let both = latchgate_recording::read_both(&source, options, &limits, &Control::default());
        let alone = |selection| latchgate_recording::read(&source, options, selection, &limits);
        let (chosen, every) = (alone(Selection::Lateral), alone(Selection::Every));
        (both.chosen != chosen || both.every != every).then(|| {
            format!("read once: {both:?}\nread twice: {chosen:?}\n{every:?}\n with {options:?}")
        })
    })
}

/// Judges every case of a table, and tells all that went wrong with its file.
fn check_read_back<T: Serialize + DeserializeOwned>(name: &str, text: &str) {
    let written: Value = serde_json::from_str(text).unwrap();
    let document: T = serde_json::from_str(text).unwrap_or_else(|error| panic!("{name}: {error}"));
    let again = serde_json::to_value(&document).unwrap();
    assert_eq!(
        again, written,
        "{name}: a document is read back as it was written"
    );
}

#[track_caller]
fn check(table: &str, cases: &[Case]) {
    if let Some(to) = std::env::var_os("LATCHGATE_GOLDEN_CASES") {
        return write_cases(&Path::new(&to).join(table), cases);
    }
    let folder = Folder::new(&format!("golden-{table}"));
    let mut wrong = Vec::new();
    for (index, case) in cases.iter().enumerate() {
        let own = format!("{index}");
        for (name, bytes) in &case.files {
            folder.file(&format!("{own}/{name}"), bytes);
        }
        let path = folder.path().join(own).join(&case.opened);
        let path = path.to_str().unwrap();
        let options: Vec<&str> = case.options.iter().map(String::as_str).collect();
        let with = |own: &[&str], options: &[&str]| {
            latchgate(&[own, options, &["--format", "json"]].concat())
        };
        let replayed = with(
            &[&["replay", path, "--no-report"], &ASKED[..]].concat(),
            &options,
        );
        wrong.extend(
            one_reading_differs(Path::new(path))
                .map(|text| format!("{} ({index}): {text}", case.name)),
        );
        // `--opens-when NAME` is for those who judge.
        let inspected = with(&["inspect", path], &options[2..]);
        if inspected.code == 0 {
            // Each channel that is offered can be taken, and leads further.
            let listing = inspected.document();
            for offered in listing["replay"]["candidates"].as_array().unwrap() {
                let named = ["inspect", path, "--channel", offered.as_str().unwrap()];
                let document = with(&named, &[]).document();
                let said = document["replay"].to_string();
                if said.contains("several channels") || said.contains("no channel") {
                    wrong.push(format!("{} ({index}): {offered}: {said}", case.name));
                }
            }
        }
        check_read_back::<Document>(&case.name, &replayed.out);
        let document: Document = serde_json::from_str(&replayed.out).unwrap();
        let shown = crate::shown::faults(&document).into_iter();
        wrong.extend(shown.map(|fault| format!("{} ({index}): {fault}", case.name)));
        if inspected.code == 0 {
            check_read_back::<Listing>(&case.name, &inspected.out);
        }
        for text in differences(case, &replayed, &inspected) {
            wrong.push(format!("{} ({index}): {text}", case.name));
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn val_golden_tables() {
    check("tables", &tables::cases());
}

#[test]
fn val_golden_clocks() {
    check("clocks", &clocks::cases());
}

#[test]
fn val_golden_names() {
    check("names", &names::cases());
}

#[test]
fn val_golden_labview_files() {
    check("labview", &labview::cases());
}

#[test]
fn val_golden_tdms_files() {
    check("tdms", &tdms::cases());
}

#[test]
fn val_golden_workbooks() {
    check("workbook", &workbook::cases());
}

#[test]
fn val_golden_nhtsa_tests() {
    check("nhtsa", &nhtsa::cases());
}

#[test]
fn val_golden_iso_mme_tests() {
    check("mme", &mme::cases());
}

#[test]
fn val_golden_logs() {
    check("logs", &logs::cases());
}

#[test]
fn val_golden_topics() {
    check("topics", &topics::cases());
}

#[test]
fn val_golden_faults_in_samples() {
    check("samples", &samples::cases());
}

/// The set is as large as it claims to be, and no bad recording in it may pass.
#[test]
fn tidy_the_golden_set_is_whole() {
    let tables = [
        tables::cases(),
        clocks::cases(),
        names::cases(),
        labview::cases(),
        tdms::cases(),
        workbook::cases(),
        nhtsa::cases(),
        mme::cases(),
        logs::cases(),
        samples::cases(),
    ];
    let cases: Vec<Case> = tables.into_iter().flatten().collect();
    let (good, bad): (Vec<&Case>, Vec<&Case>) = cases.iter().partition(|case| case.exit != 4);
    println!(
        "golden set: {} files, {} of them refused or unusable",
        cases.len(),
        bad.len()
    );
    assert!(cases.len() >= 160, "{} cases", cases.len());
    assert!(good.len() >= 60 && bad.len() >= 60);
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
