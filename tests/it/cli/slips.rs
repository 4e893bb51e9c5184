//! Guards against slips of the hand that change a verdict: a design file that nobody filled in, a window in
//! milliseconds.

use crate::support::{Folder, finish, latchgate, program, table, weak};
use serde_json::Value;
use std::fs;

/// A design that `init` wrote and nobody changed is called so wherever it is named.
#[test]
fn cli_a_design_left_as_init_wrote_it_says_so() {
    const SAYS: &str = "my latch (all values as in the paper's example)";
    let folder = Folder::new("slips-design");
    folder.write("one.csv", table(weak));
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
    let path = folder.write("one.csv", table(weak));
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
