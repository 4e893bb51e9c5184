//! Situations in which a gate elsewhere is known to look like a pass.

use super::{STANDS, Yard};
use crate::support::{finish, program, table};
use std::fs;

/// Runs a gate and checks exit code and message.
#[track_caller]
fn check(yard: &Yard, gate: &str, more: &[&str], code: i32, message: &str) {
    let done = yard.gate(gate, more);
    let said = format!("{}{}", done.out, done.err);
    assert_eq!(done.code, code, "{gate}\n{said}");
    assert!(said.contains(message), "{gate}\n{message}\n{said}");
}

fn gate_of(files: &str) -> String {
    format!(
        "[[recordings]]\nfiles = {files}\nopens_when = \"negative\"\nmembers = 128\n[[designs]]\nname = \"paper\"\n"
    )
}

#[test]
fn cli_what_matches_nothing_is_an_error() {
    let yard = Yard::new("nothing");
    for (gate, message) in [
        (gate_of("\"none*.csv\""), "a recording at `none*.csv`"),
        (gate_of("\"gone.csv\""), "a recording at `gone.csv`"),
        (
            gate_of("[\"pass.csv\", \"gone/**/*.csv\"]"),
            "a recording at `gone/**/*.csv`",
        ),
        (gate_of("[]"), "`files` to be a text, or a list of texts"),
        ("[[designs]]\nname = \"paper\"\n".into(), "[[recordings]]"),
        (
            "[[recordings]]\nfiles = \"pass.csv\"\n".into(),
            "[[designs]]",
        ),
        (String::new(), "[[recordings]]"),
        (
            format!("{STANDS}[[require]]\nrecordings = \"burst.csv\"\nverdict = \"fail\"\n"),
            "with the name `burst.csv` for this requirement",
        ),
        (
            format!("{STANDS}[[require]]\ndesigns = \"stiff\"\nverdict = \"fail\"\n"),
            "with the name `stiff` for this requirement",
        ),
        (
            format!(
                "{STANDS}[[allow]]\nrecordings = \"x.csv\"\ndesigns = \"*\"\nreason = \"r\"\nuntil = 2027-01-01\n"
            ),
            "with the name `x.csv` for this exception",
        ),
        (
            format!(
                "{STANDS}[[allow]]\nrecordings = \"pass.csv\"\ndesigns = \"*\"\nreason = \"r\"\nuntil = 2027-01-01\n"
            ),
            "matches no undecided pair",
        ),
    ] {
        check(&yard, &gate, &[], 4, message);
    }
}

#[test]
fn cli_words_of_a_gate_file_that_are_not_known_are_errors() {
    let yard = Yard::new("words");
    for (gate, message) in [
        (
            format!("recordigns = 1\n{STANDS}"),
            "did you mean `recordings`?",
        ),
        (
            STANDS.replace("members", "menbers"),
            "did you mean `members`?",
        ),
        (
            STANDS.replace("members = 128", "file = \"x\""),
            "did you mean `files`?",
        ),
        (
            STANDS.replace("members = 128", "members = \"many\""),
            "members",
        ),
        (
            STANDS.replace("\"negative\"", "\"left\""),
            "expected negative, positive or both",
        ),
        (
            STANDS.replace("verdict = \"fail\"", "verdict = \"fails\""),
            "did you mean `fail`?",
        ),
        (
            STANDS.replace("verdict = \"fail\"", "verdict = \"undecided\""),
            "known: pass, fail",
        ),
        (
            STANDS.replace("name = \"paper\"", "named = \"paper\""),
            "did you mean `name`?",
        ),
        (
            format!("require = \"passes\"\n{}", gate_of("\"pass.csv\"")),
            "did you mean `pass`?",
        ),
        (
            format!("{STANDS}[[allow]]\nrecordings = \"*\"\n"),
            "`until`",
        ),
        (
            format!(
                "{STANDS}[[allow]]\nrecordings = \"*\"\ndesigns = \"*\"\nreason = \"\"\nuntil = 2027-02-30\n"
            ),
            "TOML",
        ),
        (
            format!(
                "{STANDS}[[allow]]\nrecordings = \"*\"\ndesigns = \"*\"\nreason = \"r\"\nuntil = \"2027-02-30\"\n"
            ),
            "a day such as 2027-03-31",
        ),
        (
            format!(
                "{STANDS}[[allow]]\nrecordings = \"*\"\ndesigns = \"*\"\nreason = \" \"\nuntil = 2027-02-03\n"
            ),
            "state why",
        ),
        ("[[recordings]\n".into(), "gate.toml:1"),
        (
            STANDS.replace("[[recordings]]", "[recordings]"),
            "expected [[recordings]] tables",
        ),
        (
            format!("require = \"pass\"\n{STANDS}"),
            "a [[require]] with only its `verdict`",
        ),
        (
            STANDS.replace("\"paper\"", "\" \""),
            "name the design, or leave `name` out",
        ),
        (gate_of("\"designs[1]/*\""), "[[] matches the letter ["),
        // In a gate file a setting is a key, no option.
        (
            STANDS.replace("members = 128", "filter = \"cfc77\""),
            "the setting `filter`",
        ),
        (STANDS.replace("\"pass.csv\"", "7"), "`files` to be a text"),
        (
            STANDS.replace("name = \"paper\"", "set = [\"lever.mas_kg=1\"]"),
            "mass_kg",
        ),
        (
            STANDS.replace("name = \"paper\"", "set = { \"lever.mass_kg\" = -1 }"),
            "lever.mass_kg",
        ),
        (
            STANDS.replace("name = \"paper\"", "file = \"designs/gone.toml\""),
            "designs/gone.toml",
        ),
        (
            STANDS.replace("fail.csv\"\nverdict", "[\"\nverdict"),
            "a pattern of names",
        ),
    ] {
        check(&yard, &gate, &[], 4, message);
    }
}

#[test]
fn cli_two_meanings_are_errors() {
    let yard = Yard::new("twice");
    let twice =
        format!("{STANDS}[[designs]]\nname = \"paper\"\nset = {{ \"lever.mass_kg\" = 0.2 }}\n");
    check(&yard, &twice, &[], 4, "one design named `paper`");
    let other = format!("{STANDS}[[recordings]]\nfiles = \"p*.csv\"\nopens_when = \"positive\"\n");
    check(&yard, &other, &[], 4, "`pass.csv` with one setting");
    // A tolerance may be a share, nothing else may.
    let share = |key: &str| {
        STANDS.replace(
            "name = \"paper\"",
            &format!("set = {{ \"{key}\" = \"5 %\" }}"),
        )
    };
    check(&yard, &share("tolerance.mass_kg"), &[], 0, "as required");
    check(&yard, &share("lever.mass_kg"), &[], 4, "without quotes");
    // The same twice is one.
    let same = format!(
        "{STANDS}[[recordings]]\nfiles = \"p*.csv\"\nopens_when = \"negative\"\nmembers = 128\n"
    );
    check(&yard, &same, &[], 0, "all 2 pairs are as required");
}

#[cfg(unix)]
#[test]
fn cli_what_cannot_be_judged_is_no_pass() {
    let yard = Yard::new("unjudged");
    check(
        &yard,
        &gate_of("[\"pass.csv\", \"clipped.csv\"]"),
        &[],
        4,
        "clipped.csv with paper",
    );
    yard.folder.write("empty.csv", "");
    check(
        &yard,
        &gate_of("[\"pass.csv\", \"empty.csv\"]"),
        &[],
        4,
        "the file is empty",
    );
    check(
        &yard,
        &gate_of("\"empty.csv\""),
        &[],
        4,
        "no pair was judged",
    );
    std::os::unix::fs::symlink("nowhere", yard.folder.path().join("broken.csv")).unwrap();
    check(
        &yard,
        &gate_of("\"[bp]*.csv\""),
        &[],
        4,
        "broken.csv with paper",
    );
    fs::remove_file(yard.folder.path().join("broken.csv")).unwrap();
    let channel = gate_of("\"pass.csv\"").replace("members", "channel = \"az\"\nmembers");
    check(&yard, &channel, &[], 4, "no channel `az`");
    yard.folder
        .write("pass.csv.toml", "opens_wen = \"negative\"\n");
    check(&yard, &gate_of("\"pass.csv\""), &[], 4, "opens_when");
    fs::remove_file(yard.folder.path().join("pass.csv.toml")).unwrap();
    let control = gate_of("\"pass.csv\"") + "[[require]]\nverdict = \"fail\"\n";
    check(&yard, &control, &[], 1, "fail required");
}

#[test]
fn cli_what_surrounds_a_gate_can_fail_it() {
    let yard = Yard::new("around");
    yard.gate(STANDS, &[]);
    let before = yard.text("summary.json");
    let gone = yard
        .folder
        .write("before.json", before.replace("pass.csv", "other.csv"));
    check(
        &yard,
        STANDS,
        &["--baseline", &gone],
        4,
        "other.csv with paper is in the baseline",
    );
    check(
        &yard,
        STANDS,
        &["--baseline", &gone, "--allow-removed"],
        0,
        "all 2 pairs are as required",
    );
    check(&yard, STANDS, &["--baseline", "gone.json"], 4, "gone.json");
    let wrong = yard.folder.write("wrong.json", "{}");
    check(
        &yard,
        STANDS,
        &["--baseline", &wrong],
        4,
        "a summary.json of latchgate gate",
    );
    let file = yard.folder.write("a-file", "");
    check(&yard, STANDS, &["--store", &file], 4, "store");
    check(
        &yard,
        STANDS,
        &["--out", &format!("{file}/below")],
        4,
        "report",
    );
    yard.folder.write("taken/thesis.txt", "all there is");
    check(&yard, STANDS, &["--out", "taken"], 4, "`thesis.txt` in it");
    assert!(yard.folder.path().join("taken/thesis.txt").exists());
    let missing = finish(
        program()
            .current_dir(yard.folder.path())
            .args(["gate", "gone.toml"]),
    );
    assert_eq!(missing.code, 4);
    assert!(missing.err.contains("gone.toml"), "{}", missing.err);
    for wrong in [
        &["gate"][..],
        &["gate", "gate.toml", "--date", "31.12.2026"],
        &["gate", "gate.toml", "--no-worse"],
    ] {
        let done = finish(program().current_dir(yard.folder.path()).args(wrong));
        assert_eq!(done.code, 2, "{wrong:?}: {}", done.err);
    }
}

/// A full disk leaves the answer on the terminal, the older report, and exit 4.
#[test]
fn cli_a_full_disk_is_no_pass() {
    let yard = Yard::new("disk");
    yard.folder.write("gate.toml", STANDS);
    let script = "mkdir -p small && mount -t tmpfs -o size=8k none small && \
                  exec \"$0\" gate gate.toml --no-store --out small/out --date 2026-11-22";
    let done = finish(
        std::process::Command::new("unshare")
            .args(["--user", "--map-root-user", "--mount", "sh", "-c", script])
            .arg(program().get_program())
            .current_dir(yard.folder.path()),
    );
    assert_eq!(done.code, 4, "{}{}", done.out, done.err);
    let said = format!("{}{}", done.out, done.err);
    assert!(
        done.out
            .starts_with("GATE NOT PASSED  all 2 pairs are as required; 1 problem (exit 4)\n"),
        "{said}"
    );
    assert!(done.err.contains("No space left"), "{said}");
}

/// What could not be judged in the baseline is no excuse for what opens now.
#[test]
fn regress_no_worse_lets_nothing_stand_that_was_not_judged() {
    let yard = Yard::new("no-worse");
    let gate = gate_of("[\"pass.csv\", \"fail.csv\"]");
    let strong = fs::read_to_string(yard.folder.path().join("fail.csv")).unwrap();
    yard.folder.write("fail.csv", "no table");
    check(&yard, &gate, &[], 4, "unusable");
    let before = yard.folder.write("before.json", yard.text("summary.json"));
    let more = ["--baseline", &before, "--no-worse"];
    check(&yard, &gate, &more, 4, "unusable");
    yard.folder.write("fail.csv", strong);
    check(&yard, &gate, &more, 1, "pass required");
    // A limit that was lowered below the same peak makes it worse.
    let design = |limit: &str| {
        gate.clone() + &format!("set = {{ \"criterion.threshold_rad\" = {limit} }}\n")
    };
    check(&yard, &design("0.1"), &[], 1, "pass required");
    let before = yard.folder.write("before.json", yard.text("summary.json"));
    let more = ["--baseline", &before, "--no-worse"];
    check(&yard, &design("0.1"), &more, 0, "no worse");
    check(&yard, &design("0.02"), &more, 1, "pass required");
    // A baseline that the run replaces would let stand anything the next time.
    let own = yard.out("summary.json").display().to_string();
    check(
        &yard,
        &gate,
        &["--baseline", &own, "--no-worse"],
        2,
        "outside the gate's report folder",
    );
}

/// A `/` in the name of a design or of a channel is a letter of it.
#[test]
fn regress_rules_reach_names_with_slashes() {
    let yard = Yard::new("slashes");
    let rule = "[[require]]\nrecordings = \"pass.csv\"\nverdict = \"fail\"\n";
    let gate = gate_of("\"pass.csv\"").replace("\"paper\"", "\"rev/2\"") + rule;
    check(&yard, &gate, &[], 1, "fail required");
    let text = table(crate::support::weak).replacen("acc_y_g", "acc y (m/s2)", 1);
    yard.folder.write("controls/a.csv", text);
    let rule = "[[require]]\nrecordings = \"controls/*\"\nverdict = \"fail\"\n";
    let keys = "channel = \"acc y (m/s2)\"\nvelocity_change = 0.24\ntransfer = 1";
    let gate = gate_of(&format!("\"controls/a.csv\"\n{keys}")) + rule;
    check(&yard, &gate, &[], 1, "fail required");
}

/// No pattern matches a name that is no UTF-8: it is not passed over in silence.
#[test]
#[cfg(unix)]
fn regress_names_that_no_pattern_matches_are_an_error() {
    use std::os::unix::ffi::OsStrExt as _;

    let yard = Yard::new("no-utf8");
    yard.folder
        .write("odd/pass.csv", table(crate::support::weak));
    let name = std::ffi::OsStr::from_bytes(b"\xff\xfe.csv");
    let odd = yard.folder.path().join("odd");
    fs::copy(yard.folder.path().join("fail.csv"), odd.join(name)).unwrap();
    for files in ["\"odd/*.csv\"", "\"**/*.csv\""] {
        check(
            &yard,
            &gate_of(files),
            &[],
            4,
            "names in UTF-8 where the pattern searches",
        );
    }
}

/// One file under two names with two settings is refused; with one setting it is judged once.
#[test]
fn regress_one_file_under_two_names_is_one_recording() {
    let yard = Yard::new("two-names");
    let twice = |second: &str| {
        format!(
            "{}[[recordings]]\nfiles = \"designs/../pass.csv\"\nopens_when = \"{second}\"\nmembers = 128\n",
            gate_of("\"pass.csv\"")
        )
    };
    check(&yard, &twice("positive"), &[], 4, "with one setting");
    check(
        &yard,
        &twice("negative"),
        &[],
        0,
        "the one pair is as required",
    );
}

/// What the gate wrote is no recording of the next run; a pipe is none at all.
#[test]
#[cfg(unix)]
fn regress_own_folders_and_pipes_are_no_recordings() {
    let yard = Yard::new("own-folders");
    let gate = gate_of("\"**/pass.csv\"").replace("pass.csv", "*s*.csv");
    let more = ["--reports", "all"];
    check(&yard, &gate, &more, 0, "the one pair is as required");
    check(&yard, &gate, &more, 0, "the one pair is as required");
    let pipe = yard.folder.path().join("s-pipe.csv");
    let made = finish(std::process::Command::new("mkfifo").arg(&pipe));
    assert_eq!(made.code, 0, "{}", made.err);
    check(&yard, &gate, &more, 4, "which is neither");
    check(
        &yard,
        &gate_of("\"s-pipe.csv\""),
        &[],
        4,
        "which is neither",
    );
}

/// One wrong setting is told once, however many designs it does not suit.
#[test]
fn cli_what_many_designs_share_is_told_once() {
    let yard = Yard::new("told-once");
    let mut gate = gate_of("[\"pass.csv\", \"fail.csv\"]");
    for number in 0..20 {
        gate +=
            &format!("[[designs]]\nname = \"d{number:02}\"\nset = {{ \"input.scale\" = 0.4 }}\n");
    }
    let done = yard.gate(&gate, &[]);
    assert_eq!(done.code, 4, "{}{}", done.out, done.err);
    assert_eq!(done.err.lines().count(), 1, "{}", done.err);
    assert!(
        done.err.contains("design d00 and 19 others"),
        "{}",
        done.err
    );
}

/// An exception that an earlier one makes needless is to go.
#[test]
fn cli_an_exception_behind_another_is_not_needed() {
    let yard = Yard::new("behind");
    let allow = |designs: &str| {
        format!(
            "[[allow]]\nrecordings = \"*\"\ndesigns = \"{designs}\"\nreason = \"{designs} waits\"\nuntil = 2027-01-01\n"
        )
    };
    let gate = gate_of("\"doubt.csv\"") + &allow("*");
    check(&yard, &gate, &[], 0, "by an exception");
    check(
        &yard,
        &(gate + &allow("paper")),
        &[],
        4,
        "the exception \"paper waits\" matches no undecided pair without",
    );
}

/// The margin moves with the limit, where the peak stays.
#[test]
fn cli_a_limit_that_moved_is_a_margin_that_moved() {
    let yard = Yard::new("moved");
    let gate = |limit: &str| {
        gate_of("\"pass.csv\"") + &format!("set = {{ \"criterion.threshold_rad\" = {limit} }}\n")
    };
    check(&yard, &gate("0.1"), &[], 0, "the one pair is as required");
    let before = yard.folder.write("before.json", yard.text("summary.json"));
    let more = ["--baseline", &before];
    check(&yard, &gate("0.1"), &more, 0, "0 margins moved");
    check(&yard, &gate("0.12"), &more, 0, "1 margin moved");
    let moved = &yard.summary()["baseline"]["moved"][0];
    let by =
        moved["margin_now_rad"].as_f64().unwrap() - moved["margin_before_rad"].as_f64().unwrap();
    assert!((by - 0.02).abs() < 1e-12, "{moved}");
}

/// A line of the gate file does not stand behind the name of another file.
#[test]
fn regress_a_line_of_one_file_is_none_of_another() {
    let yard = Yard::new("places");
    let gate = gate_of("\"pass.csv\"").replace("name = \"paper\"", "file = \"gone.toml\"");
    check(
        &yard,
        &gate,
        &[],
        4,
        "gone.toml: cannot read the design file",
    );
}

/// A gate file of nothing but errors is told in twenty of them, whatever their kind.
#[test]
fn cli_a_gate_file_tells_twenty_errors_at_a_time() {
    let yard = Yard::new("many-errors");
    let keys: String = (0..16_000)
        .map(|key| format!("wrong_{key} = 1\n"))
        .collect();
    let entries = |entry: &str| format!("{STANDS}{}", entry.repeat(16_000));
    for gate in [
        keys,
        entries("[[recordings]]\nwrong = 1\n"),
        entries("[[recordings]]\nfiles = \"gone.csv\"\n"),
        entries("[[require]]\nrecordings = \"gone\"\nverdict = \"fail\"\n"),
    ] {
        let done = yard.gate(&gate, &[]);
        assert_eq!(done.code, 4, "{}", done.err);
        let lines: Vec<&str> = done.err.lines().collect();
        assert!((2..=21).contains(&lines.len()), "{}", lines.len());
        assert!(
            done.err.contains("20 errors are told at a time"),
            "{}",
            done.err
        );
    }
}
