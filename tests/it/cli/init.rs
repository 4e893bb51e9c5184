//! Guards `latchgate init`: what it writes is read, says no other numbers, and never replaces a file.

use crate::support::{Folder, at_door, finish, program, table, weak};
use latchgate_kernel::model::Design;
use latchgate_recording::Card;
use std::fs;
use std::process::Command;

fn init<'a>(folder: &Folder, command: &'a mut Command, words: &[&str]) -> &'a mut Command {
    command.current_dir(folder.path()).arg("init").args(words)
}

#[test]
fn cli_init_writes_a_design_that_is_the_papers_but_for_its_name() {
    let folder = Folder::new("init-design");
    let done = finish(init(&folder, &mut program(), &["design"]));
    assert_eq!(
        (done.code, done.out.as_str()),
        (0, "design.toml\n"),
        "{}",
        done.err
    );
    let text = fs::read_to_string(folder.path().join("design.toml")).unwrap();
    let mut design = latchgate_document::design_file::from_toml(&text).unwrap();
    assert_eq!(design.name, "my latch");
    design.name = Design::reference().name;
    // How far one's own levers differ nobody else knows: these two are left to be stated.
    assert_eq!(
        design.missing_tolerances(),
        ["preload_torque_nm", "mass_kg"]
    );
    for (key, share) in [("preload_torque_nm", "\"5 %\""), ("mass_kg", "\"2 %\"")] {
        assert!(text.contains(&format!("# {key} = {share}\n")), "{text}");
        let tolerance = Design::reference().tolerance[key];
        design.tolerance.insert(key.into(), tolerance);
    }
    assert_eq!(design, Design::reference());
}

/// As it is written a card changes nothing; it holds every key there is, and with each taken in it is read.
#[test]
fn cli_init_writes_a_card_with_every_key_that_is_known() {
    let folder = Folder::new("init-card");
    folder.write("one.csv", table(weak));
    let done = finish(init(&folder, &mut program(), &["card", "one.csv.toml"]));
    assert_eq!(done.code, 0, "{}", done.err);
    let card = folder.path().join("one.csv.toml");
    let text = fs::read_to_string(&card).unwrap();
    assert_eq!(Card::from_toml(&text).unwrap(), Default::default());
    let mut keys: Vec<&str> = Vec::new();
    let mut whole = String::new();
    for line in text.lines() {
        let bare = line.strip_prefix("# ").unwrap_or(line);
        match bare.split_once(" = ") {
            Some((key, _)) if !key.contains(' ') => {
                keys.push(key);
                whole += bare;
            }
            _ => whole += line,
        }
        whole.push('\n');
    }
    let mut known = Card::keys();
    known.sort_unstable();
    keys.sort_unstable();
    assert_eq!(keys, known, "the template and the keys of a card");
    let read = Card::from_toml(&whole).unwrap();
    assert_eq!(read.range_g, Some(2000.0));
    assert!(read.synthetic && read.notes.is_some() && read.accepted_remarks.len() == 1);
}

#[test]
fn cli_init_writes_a_gate_that_judges() {
    let folder = Folder::new("init-gate");
    fs::create_dir(folder.path().join("recordings")).unwrap();
    folder.write("recordings/one.csv", at_door(&table(weak)));
    folder.write("recordings/one.csv.toml", "opens_when = \"negative\"\n");
    let done = finish(init(&folder, &mut program(), &["gate"]));
    assert_eq!(done.code, 0, "{}", done.err);
    let done = finish(program().current_dir(folder.path()).args([
        "gate",
        "gate.toml",
        "--reports",
        "none",
        "--no-store",
    ]));
    assert_eq!(done.code, 0, "{}{}", done.out, done.err);
}

#[test]
fn cli_init_never_replaces_a_file() {
    let folder = Folder::new("init-twice");
    for template in ["card", "design", "gate"] {
        let path = folder.write(&format!("{template}.toml"), "mine");
        let done = finish(init(&folder, &mut program(), &[template]));
        assert_eq!(done.code, 4, "{}", done.out);
        assert!(
            done.err.contains(&format!("{template}.toml: cannot write")),
            "{}",
            done.err
        );
        assert_eq!(fs::read_to_string(path).unwrap(), "mine");
    }
}
