//! Guards against slips of the hand that change a verdict: a design file that nobody filled in, a window in
//! milliseconds.

use crate::support::{Folder, at_door, finish, latchgate, program, table, weak};
use serde_json::Value;
use std::fs;

/// A design that `init` wrote and nobody changed is called so wherever it is named.
#[test]
fn cli_a_design_left_as_init_wrote_it_says_so() {
    const SAYS: &str = "my latch (all values as in the paper's example)";
    let folder = Folder::new("slips-design");
    folder.write("one.csv", at_door(&table(weak)));
    folder.write("one.csv.toml", "opens_when = \"negative\"\n");
    let run = |words: &str| finish(program().current_dir(folder.path()).args(words.split(' ')));
    assert_eq!(run("init design").code, 0);
    let replay = "replay one.csv --members 0 --design design.toml";
    let done = run(&format!("{replay} --out report"));
    assert!(done.out.contains(SAYS), "{}", done.out);
    let page = fs::read_to_string(folder.path().join("report/report.html")).unwrap();
    assert!(page.contains("my latch (all values as in the paper"));
    let done = run("margin one.csv --members 0 --no-report --design design.toml");
    assert!(done.out.contains(SAYS), "{}", done.out);
    folder.write(
        "gate.toml",
        "[[recordings]]\nfiles = \"one.csv\"\nmembers = 0\n[[designs]]\nfile = \"design.toml\"\n",
    );
    let done = run("gate gate.toml --no-store --out gate");
    assert!(done.out.contains(SAYS), "{}{}", done.out, done.err);
    // Any value of its own makes it a design.
    let changed = run(&format!(
        "{replay} --no-report --set lever.preload_torque_nm=0.2"
    ));
    assert!(!changed.out.contains("as in the paper"), "{}", changed.out);
    let text = fs::read_to_string(folder.path().join("design.toml")).unwrap();
    let own = text.replacen("preload_torque_nm = 0.1", "preload_torque_nm = 0.2", 1);
    assert_ne!(own, text);
    folder.write("design.toml", own);
    let done = run(&format!("{replay} --no-report"));
    assert!(!done.out.contains("as in the paper"), "{}", done.out);
}

/// A window is in seconds; one that fits only in milliseconds is told, with what it would be.
#[test]
fn cli_a_window_in_milliseconds_is_told() {
    let folder = Folder::new("slips-window");
    let path = folder.write("one.csv", at_door(&table(weak)));
    let codes = |window: &str| -> Vec<Value> {
        let options = [
            "--members",
            "0",
            "--no-report",
            "--format",
            "json",
            "--window",
            window,
        ];
        let document = latchgate(&[&["replay", &path], options.as_slice()].concat()).document();
        let findings = document["findings"].as_array().unwrap().iter();
        let of_window = findings.filter(|one| one["code"] == "window-in-milliseconds");
        of_window.cloned().collect()
    };
    let found = codes("0..100");
    assert_eq!(found.len(), 1);
    assert_eq!(found[0]["severity"], "warning");
    let text = found[0]["text"].as_str().unwrap();
    assert!(
        text.starts_with("The window ends at 100 s, the record at 0."),
        "{text}"
    );
    assert!(
        text.ends_with("state the setting `window` = 0..0.1."),
        "{text}"
    );
    // Those that end a little behind the record, or where no time of a record could be meant.
    for window in ["0..0.1", "0..1", "0..1e9"] {
        assert!(codes(window).is_empty(), "{window}");
    }
}

/// What is measured stays: neither a report nor a series takes the place of a file that is read, by whatever name, or
/// of one that latchgate did not write.
#[cfg(unix)]
#[test]
fn cli_no_file_of_others_is_overwritten() {
    let folder = Folder::new("slips-overwritten");
    let place = |name: &str| folder.path().join(name);
    let recording = at_door(&table(weak));
    let own = "opens_when = \"negative\"\n";
    for name in ["one.csv", "inside/series.csv", "inside/verdict.json"] {
        fs::create_dir_all(place("inside")).unwrap();
        fs::write(place(name), &recording).unwrap();
    }
    // A report among the files makes the folder one of reports; the recording in it stays all the same.
    fs::write(
        place("inside/verdict.json"),
        "{\"schema\": \"latchgate.verdict/1\"}",
    )
    .unwrap();
    folder.write("one.csv.toml", own);
    folder.write("notes.txt", "my notes\n");
    fs::create_dir(place("foreign")).unwrap();
    folder.write("foreign/report.html", "somebody's page");
    fs::hard_link(place("one.csv"), place("linked.csv")).unwrap();
    std::os::unix::fs::symlink("one.csv", place("pointing.csv")).unwrap();
    let before = |name: &str| fs::read(place(name)).unwrap();
    let names = [
        "one.csv",
        "one.csv.toml",
        "notes.txt",
        "foreign/report.html",
        "inside/series.csv",
    ];
    let kept = names.map(before);
    for (words, message) in [
        (
            "one.csv --series one.csv --no-report",
            "a file that is read",
        ),
        (
            "one.csv --series linked.csv --no-report",
            "a file that is read",
        ),
        (
            "one.csv --series pointing.csv --no-report",
            "a file that is read",
        ),
        (
            "one.csv --series one.csv.toml --no-report",
            "a file that is read",
        ),
        ("one.csv --series notes.txt --no-report", "is no series"),
        ("inside/series.csv --out inside", "a file that is read"),
        ("one.csv --out foreign", "files that are no report"),
    ] {
        let words = format!("replay {words} --members 0");
        let done = finish(program().current_dir(folder.path()).args(words.split(' ')));
        assert_eq!(done.code, 4, "{words}\n{}", done.err);
        assert!(done.err.contains(message), "{words}\n{}", done.err);
        assert_eq!(names.map(before), kept, "{words}");
    }
    // An earlier series and an earlier report are replaced.
    for words in [
        "one.csv --series new.csv --out new",
        "one.csv --series new.csv --out new",
    ] {
        let words = format!("replay {words} --members 0");
        let done = finish(program().current_dir(folder.path()).args(words.split(' ')));
        assert_eq!(done.code, 0, "{words}\n{}", done.err);
    }
    let words = "margin inside/series.csv --out inside --members 0";
    let done = finish(program().current_dir(folder.path()).args(words.split(' ')));
    assert_eq!((done.code, names.map(before)), (4, kept), "{}", done.err);
}

/// No character of a file's name, a card or a gate file steers the terminal, on either stream, in text or JSON.
#[test]
fn cli_no_character_of_an_input_steers_the_terminal() {
    let folder = Folder::new("slips-steering");
    let odd = "a\u{1b}]0;x\u{7}\u{9b}\u{202e}\u{7f}.csv";
    let steers = |text: &str| {
        text.chars()
            .any(|c| c != '\n' && latchgate_document::json::steers(c))
    };
    folder.write(odd, at_door(&table(weak)));
    let gone = format!("gone-{odd}");
    for (card, words, code) in [
        ("", vec!["replay", odd, "--no-report", "--members", "0"], 3),
        ("", vec!["replay", odd, "--members", "0", "--out", odd], 4),
        (
            "",
            vec![
                "replay",
                odd,
                "--no-report",
                "--members",
                "0",
                "--format",
                "json",
            ],
            3,
        ),
        ("", vec!["inspect", odd], 0),
        ("", vec!["inspect", odd, "--format", "json"], 0),
        ("", vec!["replay", &gone], 4),
        ("", vec!["verify", &gone], 4),
        ("", vec!["gate", &gone], 4),
        ("", vec!["--odd\u{202e}", odd], 2),
        ("\"k\\u202e\\u001b\" = 1\n", vec!["replay", odd], 4),
        ("unit = \"g\\u202e\\u001b\"\n", vec!["replay", odd], 4),
    ] {
        folder.write(&format!("{odd}.toml"), card);
        let done = finish(program().current_dir(folder.path()).args(&words));
        assert_eq!(done.code, code, "{words:?}\n{}{}", done.out, done.err);
        assert!(!steers(&done.err), "{words:?}\n{:?}", done.err);
        assert!(!steers(&done.out), "{words:?}\n{:?}", done.out);
    }
    let pattern =
        "[[recordings]]\nfiles = \"n\\u202e\\u001b*.csv\"\n[[designs]]\nname = \"paper\"\n";
    folder.write("gate.toml", pattern);
    let done = finish(
        program()
            .current_dir(folder.path())
            .args(["gate", "gate.toml"]),
    );
    assert_eq!(done.code, 4);
    assert!(!steers(&done.err) && !steers(&done.out), "{:?}", done.err);
}
