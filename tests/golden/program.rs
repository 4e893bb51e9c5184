//! Some sixty cases go through the program as well, so that it is held to the library: the same
//! document, exit code and message.

use super::answer::{errors, inspect, inspect_words, judge, replay_words, written};
use super::process::{advised, without_run};
use super::{Case, TABLES, each_case};
use latchgate::document::json::render;
use latchgate::report::escape;
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::path::Path;

/// True of the cases that are asked of the program: all that fail or are undecided, which are few,
/// and of the others about one in forty by the hash of its name. A case that is added moves none.
fn is_asked_of_the_program(case: &Case) -> bool {
    [1, 3].contains(&case.exit) || Sha256::digest(case.name.as_bytes())[0] < 7
}

/// Lists in what the program's answers differ from the library's.
fn differences(case: &Case, path: &Path) -> Vec<String> {
    let name = path.to_str().unwrap();
    let mut faults = Vec::new();
    let mut same = |what: &str, program: &str, library: &str| {
        if program != library {
            let case = &case.name;
            faults.push(format!(
                "{case}: {what}: {program}\nof the library: {library}"
            ));
        }
    };
    let outcome = judge(case, path);
    let replayed = advised(&replay_words(case, name));
    same(
        "exit code",
        &replayed.code.to_string(),
        &case.exit.to_string(),
    );
    let document = written(&outcome);
    same(
        "document",
        without_run(&replayed.out),
        without_run(&document),
    );
    let message = errors(case, path, &outcome);
    let lines = message.lines().map(|line| escape::terminal(line) + "\n");
    same("stderr", &replayed.err, &lines.collect::<String>());
    let inspected = advised(&inspect_words(case, name));
    match inspect(case, path) {
        Ok(listing) => {
            same("exit code of inspect", &inspected.code.to_string(), "0");
            same("listing", &inspected.out, &render(&listing));
        }
        Err(_) => same("exit code of inspect", &inspected.code.to_string(), "4"),
    }
    faults
}

#[test]
fn cli_the_program_answers_as_the_library_does() {
    let mut asked = 0;
    let mut exits = BTreeSet::new();
    let mut faults = Vec::new();
    for table in &TABLES {
        let mut cases = table.cases();
        cases.retain(is_asked_of_the_program);
        assert!(!cases.is_empty(), "no case of {}", table.name);
        asked += cases.len();
        exits.extend(cases.iter().map(|case| case.exit));
        let differing = each_case(
            &format!("{}-program", table.name),
            &cases,
            |_, case, path| differences(case, path),
        );
        faults.extend(differing.into_iter().flatten());
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(asked >= 60, "{asked} cases");
    assert_eq!(exits, BTreeSet::from([0, 1, 3, 4]));
}
