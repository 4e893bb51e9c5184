//! Guards `latchgate gate`: nothing that was not judged, or not as required, ends with exit 0.

mod hostile;
mod outputs;
mod rows;
mod store;

use crate::support::{Done, Folder, at_door, finish, half_sine, program, table, weak};
use serde_json::Value;
use std::fs;
use std::path::PathBuf;

/// A folder with recordings that pass, fail, are undecided and are clipped, and a second design.
pub(crate) struct Yard {
    pub(crate) folder: Folder,
}

/// A gate that stands: one pass, one control that must fail.
pub(crate) const STANDS: &str = "\
[[recordings]]
files = [\"pass.csv\", \"fail.csv\"]
opens_when = \"negative\"
members = 128
[[designs]]
name = \"paper\"
[[require]]
recordings = \"fail.csv\"
verdict = \"fail\"
";

/// Returns a text without its attributes `time`.
pub(crate) fn without_times(text: &str) -> String {
    let mut parts = text.split(" time=\"");
    let first = parts.next().unwrap().to_string();
    let rest = parts.map(|part| part.split_once('"').unwrap().1);
    first + &rest.collect::<String>()
}

impl Yard {
    pub(crate) fn new(name: &str) -> Self {
        let folder = Folder::new(&format!("gate-{name}"));
        folder.write("pass.csv", at_door(&table(weak)));
        folder.write("fail.csv", at_door(&table(strong)));
        folder.write("doubt.csv", at_door(&table(doubtful)));
        folder.write("clipped.csv", at_door(&table(weak)));
        folder.write("clipped.csv.toml", "range_g = 5\n");
        folder.write(
            "designs/stiff.toml",
            "base = \"paper\"\n[lever]\npreload_torque_nm = 9\n",
        );
        Self { folder }
    }

    /// Runs a gate of that text with further arguments, in a folder of its own.
    pub(crate) fn gate(&self, text: &str, more: &[&str]) -> Done {
        self.folder.write("gate.toml", text);
        finish(self.command(more))
    }

    pub(crate) fn command(&self, more: &[&str]) -> &mut std::process::Command {
        let mut command = program();
        command
            .current_dir(self.folder.path())
            .args(["gate", "gate.toml"])
            .args(more);
        for (option, value) in [
            ("--out", "out"),
            ("--reports", "none"),
            ("--date", "2026-11-22"),
        ] {
            if !more.contains(&option) {
                command.args([option, value]);
            }
        }
        // Used at once, by one test.
        Box::leak(Box::new(command))
    }

    pub(crate) fn out(&self, name: &str) -> PathBuf {
        self.folder.path().join("out").join(name)
    }

    pub(crate) fn text(&self, name: &str) -> String {
        fs::read_to_string(self.out(name)).unwrap()
    }

    pub(crate) fn summary(&self) -> Value {
        serde_json::from_str(&self.text("summary.json")).unwrap()
    }
}

/// A pulse that opens the paper's lever.
pub(crate) fn strong(time: f64) -> f64 {
    half_sine(time, 0.0, 0.02, -30.0) + 0.01 * (time * 9_100.0).sin()
}

/// A pulse of which the nominal lever stays a little below the limit and many others do not.
pub(crate) fn doubtful(time: f64) -> f64 {
    half_sine(time, 0.0, 0.01, -8.35) + 0.01 * (time * 9_100.0).sin()
}

#[test]
fn cli_a_gate_that_stands_says_so() {
    let yard = Yard::new("stands");
    let done = yard.gate(STANDS, &[]);
    assert_eq!(done.code, 0, "{}{}", done.out, done.err);
    assert!(
        done.out
            .starts_with("GATE PASSED  all 2 pairs are as required (exit 0)\n"),
        "{}",
        done.out
    );
    let summary = yard.summary();
    assert_eq!(summary["exit_code"], 0);
    assert_eq!(summary["counts"]["as_required"], 2);
    assert_eq!(summary["pairs"][0]["recording"], "fail.csv");
    assert_eq!(summary["pairs"][0]["row"]["verdict"], "fail");
}

#[test]
fn cli_the_exit_code_is_the_worst_of_what_is_not_as_required() {
    let yard = Yard::new("worst");
    let gate = |files: &str| {
        format!(
            "[[recordings]]\nfiles = [{files}]\nopens_when = \"negative\"\n[[designs]]\nname = \"paper\"\n"
        )
    };
    for (files, code) in [
        ("\"pass.csv\"", 0),
        ("\"pass.csv\", \"doubt.csv\"", 3),
        ("\"pass.csv\", \"doubt.csv\", \"fail.csv\"", 1),
        (
            "\"pass.csv\", \"doubt.csv\", \"fail.csv\", \"clipped.csv\"",
            4,
        ),
    ] {
        let done = yard.gate(&gate(files), &[]);
        assert_eq!(done.code, code, "{files}: {}{}", done.out, done.err);
        assert_eq!(yard.summary()["exit_code"], code);
        if code == 4 {
            let first = "GATE NOT PASSED  3 of 4 pairs are not as required: 1 fail, 1 undecided, 1 unusable (exit 4)\n";
            assert!(done.out.starts_with(first), "{}", done.out);
        }
    }
}

/// Some pairs can be asked for; what they say replaces nothing that is said of all.
#[test]
fn cli_some_pairs_of_a_gate_are_listed_or_judged() {
    let yard = Yard::new("only");
    let gate = format!(
        "{STANDS}[[designs]]\nname = \"stiff\"\nfile = \"designs/stiff.toml\"\n\
         [[allow]]\nrecordings = \"pass.csv\"\ndesigns = \"*\"\nreason = \"is not needed\"\nuntil = 2026-12-31\n"
    );
    let listed = yard.gate(&gate, &["--list"]);
    assert_eq!((listed.code, listed.err.as_str()), (0, ""));
    let all = "fail.csv with paper: fail required\nfail.csv with stiff: fail required\n\
               pass.csv with paper: pass required\npass.csv with stiff: pass required\n";
    assert_eq!(listed.out, all);
    assert!(!yard.out("summary.json").exists(), "nothing was judged");
    let some = ["--only-recording", "p*.csv", "--only-design", "paper"];
    let listed = yard.gate(&gate, &["--list", "--format", "json"]);
    let listed: Value = serde_json::from_str(&listed.out).unwrap();
    assert_eq!(
        listed[2],
        serde_json::json!({ "recording": "pass.csv", "design": "paper", "required": "pass" })
    );
    // The exception is not needed, but of some pairs that cannot be known.
    let chosen = |more: &[&str]| {
        let mut command = program();
        command
            .current_dir(yard.folder.path())
            .args(["gate", "gate.toml", "--date", "2026-11-22"])
            .args(more);
        finish(&mut command)
    };
    let done = chosen(&some);
    assert_eq!(done.code, 0, "{}{}", done.out, done.err);
    assert!(
        done.out.starts_with(
            "CHOSEN PAIRS PASSED  the one pair is as required; not the gate's answer, which needs every pair (exit 0)\n"
        ),
        "{}",
        done.out
    );
    assert!(
        done.err.contains("judged the 1 chosen of 4 pairs"),
        "{}",
        done.err
    );
    assert!(!yard.folder.path().join("reports").exists(), "no files");
    // What is printed is taken for no answer of the gate.
    let part = chosen(&["--only-design", "paper", "--format", "json"]);
    yard.folder.write("part.json", &part.out);
    let baseline = yard.gate(&gate, &["--baseline", "part.json"]);
    assert_eq!(baseline.code, 4);
    assert!(
        baseline.err.contains("latchgate.gate-part/1"),
        "{}",
        baseline.err
    );
    let nothing = chosen(&["--only-design", "nobody"]);
    assert_eq!(nothing.code, 4);
    assert!(nothing.err.contains("`nobody`"), "{}", nothing.err);
    // Neither a file, a baseline nor a share is of some pairs, and a list is of no share.
    for more in [
        ["--only-design", "paper", "--part", "1/2"],
        ["--only-design", "paper", "--baseline", "x.json"],
        ["--only-design", "paper", "--out", "out"],
        ["--list", "--collect", "--out", "out"],
    ] {
        assert_eq!(chosen(&more).code, 2, "{more:?}");
    }
}

#[test]
fn cli_a_form_of_the_answer_changes_no_exit_code() {
    let yard = Yard::new("forms");
    let failing = STANDS.replace("verdict = \"fail\"", "verdict = \"pass\"");
    for more in [
        &["--format", "json"][..],
        &["--format", "text"],
        &["--annotate", "github"],
        &["--annotate", "github", "--format", "json"],
        &["--reports", "failing"],
    ] {
        let done = yard.gate(&failing, more);
        assert_eq!(done.code, 1, "{more:?}: {}{}", done.out, done.err);
    }
}

#[test]
fn cli_the_last_requirement_that_matches_counts() {
    let yard = Yard::new("rules");
    let rules =
        "require = [{ verdict = \"fail\" }, { recordings = \"pass.csv\", verdict = \"pass\" }]\n";
    let gate = format!(
        "{rules}[[recordings]]\nfiles = \"*s*.csv\"\nopens_when = \"negative\"\n[[designs]]\nname = \"paper\"\n"
    );
    let done = yard.gate(&gate, &[]);
    assert_eq!(done.code, 0, "{}{}", done.out, done.err);
}

#[test]
fn cli_exceptions_let_an_undecided_pair_through_for_a_time() {
    let yard = Yard::new("exceptions");
    let gate = "[[recordings]]\nfiles = \"doubt.csv\"\nopens_when = \"negative\"\n[[designs]]\nname = \"paper\"\n\
                [[allow]]\nrecordings = \"doubt.csv\"\ndesigns = \"paper\"\nreason = \"repeat ordered\"\nuntil = 2026-12-31\n";
    let done = yard.gate(gate, &[]);
    assert_eq!(done.code, 0, "{}{}", done.out, done.err);
    for shown in [
        done.out.as_str(),
        &yard.text("junit.xml"),
        &yard.text("summary.md"),
        &yard.text("index.html"),
    ] {
        assert!(
            shown.contains("repeat ordered") && shown.contains("2026-12-31"),
            "{shown}"
        );
    }
    assert_eq!(yard.summary()["pairs"][0]["exception"][1], "2026-12-31");
    let late = yard.gate(gate, &["--date", "2027-01-01"]);
    assert_eq!(late.code, 4, "{}", late.out);
    assert!(
        late.out
            .contains("ended on 2026-12-31, today is 2027-01-01"),
        "{}",
        late.out
    );
}

#[test]
fn cli_a_baseline_tells_what_changed() {
    let yard = Yard::new("baseline");
    yard.gate(STANDS, &[]);
    let before = yard.folder.write("before.json", yard.text("summary.json"));
    let failing = STANDS
        .replace(
            "[\"pass.csv\", \"fail.csv\"]",
            "[\"pass.csv\", \"fail.csv\", \"doubt.csv\"]",
        )
        .replace("verdict = \"fail\"", "verdict = \"pass\"");
    let worse = yard.gate(&failing, &["--baseline", &before]);
    assert_eq!(worse.code, 1);
    let changed = &yard.summary()["baseline"];
    assert_eq!(
        changed["newly_failing"],
        serde_json::json!([["fail.csv", "paper"]])
    );
    assert_eq!(
        changed["added"],
        serde_json::json!([["doubt.csv", "paper"]])
    );

    // What stood so before is let stand, once it is asked for.
    let failing = failing.replace(", \"doubt.csv\"", "");
    yard.gate(&failing, &[]);
    let before = yard.folder.write("before.json", yard.text("summary.json"));
    assert_eq!(yard.gate(&failing, &["--baseline", &before]).code, 1);
    let stands = yard.gate(&failing, &["--baseline", &before, "--no-worse"]);
    assert_eq!(stands.code, 0, "{}", stands.out);
    assert!(
        stands.out.contains("no worse than the baseline"),
        "{}",
        stands.out
    );
    // A higher peak is worse.
    yard.folder
        .write("fail.csv", table(|time| 1.5 * strong(time)));
    assert_eq!(
        yard.gate(&failing, &["--baseline", &before, "--no-worse"])
            .code,
        1
    );
}

#[test]
fn cli_a_first_gate_file_is_one_that_runs() {
    let yard = Yard::new("init");
    yard.folder.write("notes.txt", "nothing measured\n");
    yard.folder
        .write("along.csv.toml", "channel = \"acc_x_g\"\n");
    yard.folder
        .write("along.csv", table(weak).replacen("acc_y", "acc_x", 1));
    yard.folder.write("reports/first/verdict.json", "{}");
    yard.folder.write("reports/first/series.csv", table(weak));
    let done = finish(
        program()
            .current_dir(yard.folder.path())
            .args(["gate", "--init", "."]),
    );
    assert_eq!(done.code, 0, "{}", done.err);
    let text = fs::read_to_string(yard.folder.path().join("gate.toml")).unwrap();
    assert!(text.contains("\"pass.csv\",\n"), "{text}");
    assert!(text.contains("# files = [\"notes.txt\"]"), "{text}");
    assert!(
        text.contains("is not clearly a lateral acceleration")
            && text.contains("# files = [\"along.csv\"]"),
        "{text}"
    );
    let of_report = "# files = [\"reports/first/**\"]";
    assert!(
        text.contains(of_report) && !text.contains("series.csv"),
        "{text}"
    );
    let done = finish(yard.command(&[]));
    assert!(
        yard.summary()["counts"]["pairs"].as_u64() == Some(4),
        "{}{}",
        done.out,
        done.err
    );
    // It is never written over.
    let again = finish(
        program()
            .current_dir(yard.folder.path())
            .args(["gate", "--init", "."]),
    );
    assert_eq!(again.code, 4);
    assert_eq!(
        fs::read_to_string(yard.folder.path().join("gate.toml")).unwrap(),
        text
    );
}

#[test]
fn cli_the_schema_is_the_one_of_the_documents() {
    let done = finish(program().args(["gate", "--schema"]));
    assert_eq!(done.code, 0);
    let kept = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/gate.schema.json");
    if std::env::var_os("LATCHGATE_RENEW").is_some() {
        fs::write(kept, &done.out).unwrap();
    }
    assert_eq!(
        done.out,
        fs::read_to_string(kept).unwrap(),
        "renew with LATCHGATE_RENEW=1"
    );
}

/// The gate that the documents show and continuous integration runs.
#[test]
fn cli_the_sample_gate_stands() {
    let folder = Folder::new("gate-sample");
    let gate = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/gate/gate.toml");
    let done = finish(program().current_dir(folder.path()).args([
        "gate",
        gate,
        "--no-store",
        "--reports",
        "none",
        "--out",
        "out",
    ]));
    assert_eq!(done.code, 0, "{}{}", done.out, done.err);
    assert!(
        done.out.contains("all 6 pairs are as required"),
        "{}",
        done.out
    );
    assert!(done.out.contains("pass 4, fail 2"), "{}", done.out);
}
