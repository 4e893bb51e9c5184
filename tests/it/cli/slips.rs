//! Guards against slips of the hand that change a verdict: a design file that nobody filled in.

use crate::support::{Folder, finish, program, table, weak};
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
