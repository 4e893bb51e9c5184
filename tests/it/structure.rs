//! Guards the shape of the sources: which module may use which, no circle of files, functions that
//! fit on a screen, one meaning for a type's name.

mod allowance;
mod code;

use crate::tidy::{
    check_none, files_below, line_of, module_of, quoted, sources, text_of, without_comments,
};
use allowance::SHARED_NAMES;
use code::{Uses, blank, circles, functions, types};
use std::collections::{BTreeMap, BTreeSet};

// ---------------------------------------------------------------- modules

/// Reads the table "Who may use whom": module, then the modules it may use.
fn directions() -> BTreeMap<String, BTreeSet<String>> {
    let text = text_of("docs/architecture.md");
    let section = text
        .split("## Who may use whom")
        .nth(1)
        .expect("docs/architecture.md has a section \"Who may use whom\"");
    section
        .lines()
        .take_while(|line| !line.starts_with("## "))
        .filter(|line| line.starts_with("| `"))
        .map(|line| {
            let cells: Vec<&str> = line.split('|').map(str::trim).collect();
            let module = cells[1].trim_matches('`').to_string();
            (module, quoted(cells[2]).into_iter().collect())
        })
        .collect()
}

/// Returns the modules that a source file names through `crate::` (or `super::`, where that is
/// the crate's root), with the line.
fn uses(path: &str, code: &str) -> Vec<(usize, String)> {
    let depth = path.matches('/').count();
    let to_root = "super::".repeat(depth);
    let mut found = Vec::new();
    for root in ["crate::", to_root.as_str()] {
        for (offset, _) in code.match_indices(root) {
            if code[..offset].ends_with("::") {
                continue;
            }
            let rest = &code[offset + root.len()..];
            let line = line_of(code, offset);
            if let Some(list) = rest.strip_prefix('{') {
                found.extend(heads_of(list).into_iter().map(|name| (line, name)));
            } else {
                found.push((line, identifier(rest)));
            }
        }
    }
    found
}

fn identifier(text: &str) -> String {
    text.trim_start()
        .chars()
        .take_while(|c| c.is_alphanumeric() || *c == '_')
        .collect()
}

/// Returns the first name of each part of a `use` list, up to its closing brace.
fn heads_of(list: &str) -> Vec<String> {
    let mut depth = 0;
    let mut heads = Vec::new();
    let mut start = true;
    for (offset, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => start = true,
            c if start && !c.is_whitespace() => {
                heads.push(identifier(&list[offset..]));
                start = false;
            }
            _ => {}
        }
    }
    heads
}

#[test]
fn tidy_modules_know_only_whom_they_may_know() {
    let directions = directions();
    let modules: BTreeSet<String> = directions.keys().cloned().collect();
    let mut found = Vec::new();
    let mut idle = directions.clone();
    for (path, code) in sources() {
        let module = module_of(&path);
        if matches!(module.as_str(), "lib" | "main" | "kernel") {
            continue;
        }
        let Some(allowed) = directions.get(&module) else {
            found.push(format!("{path}: module `{module}` is not in the table"));
            continue;
        };
        for (line, name) in uses(&path, &code) {
            if modules.contains(&name) && name != module && !allowed.contains(&name) {
                found.push(format!("{path}:{line}: `{module}` uses `{name}`"));
            }
            idle.get_mut(&module).map(|left| left.remove(&name));
        }
    }
    let unused = idle.iter().filter(|(_, left)| !left.is_empty());
    found.extend(unused.map(|(module, left)| format!("`{module}` uses none of {left:?}")));
    check_none(
        "uses against the table in docs/architecture.md (mend the code, or decide and say why there)",
        &found,
    );
}

/// The scanner of the test above sees the forms in which a module can be named.
#[test]
fn tidy_the_scan_for_uses_sees_what_it_should() {
    let names = |path: &str, code: &str| -> Vec<String> {
        uses(path, code).into_iter().map(|(_, name)| name).collect()
    };
    assert_eq!(
        names("src/model.rs", "use crate::verdict::Answer;"),
        ["verdict"]
    );
    assert_eq!(
        names("src/model.rs", "use crate::{cli, report::{a, b}, units};"),
        ["cli", "report", "units"]
    );
    assert_eq!(names("src/model.rs", "use super::cli;"), ["cli"]);
    assert_eq!(
        names("src/model/stop.rs", "super::lever; super::super::cli::x();"),
        ["cli"]
    );
    assert_eq!(
        names(
            "src/model.rs",
            &without_comments("/// [`crate::cli`]\n// crate::cli")
        ),
        Vec::<String>::new()
    );
}

// ---------------------------------------------------------------- files

/// The module of each source file with its text; `src/main.rs` and `src/kernel.rs`, which lists modules that
/// `src/lib.rs` exports, are crates of their own.
fn modules() -> Vec<(String, String)> {
    let roots = ["src/main.rs", "src/kernel.rs"];
    files_below("src")
        .into_iter()
        .filter(|path| path.ends_with(".rs") && !roots.contains(&path.as_str()))
        .map(|path| {
            let inner = path
                .strip_prefix("src/")
                .unwrap()
                .strip_suffix(".rs")
                .unwrap();
            let module = if inner == "lib" {
                String::new()
            } else {
                inner.replace('/', "::")
            };
            (module, text_of(&path))
        })
        .collect()
}

/// No file uses, by however many steps, a file that uses it. A module and those below it are one
/// family: it may be put together from them, and they may use what it defines.
#[test]
fn tidy_no_circle_of_files() {
    let arrows = Uses::of(modules()).arrows();
    let mut found = Vec::new();
    for circle in circles(&arrows) {
        for module in &circle {
            let used: Vec<&str> = arrows[module]
                .intersection(&circle)
                .map(String::as_str)
                .collect();
            found.push(format!("  {module} uses {}", used.join(", ")));
        }
        found.push(String::new());
    }
    check_none("files that use one another in a circle", &found);
}

/// The scanner sees the forms in which a file can name another's items, and nothing else.
#[test]
fn tidy_the_scan_for_circles_sees_what_it_should() {
    let arrows = |sources: &[(&str, &str)]| -> Vec<String> {
        let owned = sources
            .iter()
            .map(|(module, text)| ((*module).into(), (*text).into()));
        Uses::of(owned)
            .arrows()
            .into_iter()
            .flat_map(|(from, to)| to.into_iter().map(move |to| format!("{from} > {to}")))
            .collect()
    };
    let a = ("a", "mod b;\npub use b::B;\npub struct A;\nuse std::fmt;");
    let uses = |text: &'static str| arrows(&[a, ("a::b", "pub struct B;"), ("c", text)]);
    assert_eq!(uses(""), [""; 0]);
    assert_eq!(uses("use crate::a::A;"), ["c > a"]);
    assert_eq!(uses("use super::a::{A, B as C};"), ["c > a", "c > a::b"]);
    assert_eq!(uses("fn f(_: crate::a::B) {}"), ["c > a::b"]);
    assert_eq!(uses("use crate::a;\nfn f(_: a::b::B) {}"), ["c > a::b"]);
    assert_eq!(
        uses("use crate::{a::{self, A}, c};\nfn f(_: a::B) {}"),
        ["c > a", "c > a::b"]
    );
    assert_eq!(uses("pub use crate::a::A;"), [""; 0]);
    assert_eq!(uses("pub use crate::a::A;\nstruct D(A);"), ["c > a"]);
    assert_eq!(
        uses("// use crate::a::A;\nconst T: &str = \"crate::a::A\";"),
        [""; 0]
    );
    // A module may use those below it and they what it defines, but not a neighbour in turn.
    let family = arrows(&[
        ("a", "mod b;\nmod c;\nuse b::B;\npub struct A;"),
        (
            "a::b",
            "use super::{A, c};\npub struct B;\nfn f(_: c::C) {}",
        ),
        ("a::c", "use super::b::B;\npub struct C;"),
    ]);
    assert_eq!(family, ["a::b > a", "a::b > a::c", "a::c > a::b"]);
    let ring = |text: &[(&str, &[&str])]| {
        let set = |to: &[&str]| to.iter().map(|name| (*name).to_string()).collect();
        circles(
            &text
                .iter()
                .map(|(from, to)| ((*from).to_string(), set(to)))
                .collect(),
        )
    };
    assert_eq!(
        ring(&[("a", &["b"]), ("b", &["c"]), ("c", &["b"])]).len(),
        1
    );
    assert_eq!(ring(&[("a", &["b"]), ("b", &["c"]), ("c", &[])]).len(), 0);
}

/// Code without comments, strings and the tests that stand at the end of some files.
fn production(text: &str) -> String {
    let code = blank(text);
    let end = code.find("#[cfg(test)]").unwrap_or(code.len());
    code[..end].to_string()
}

// ---------------------------------------------------------------- functions

/// A function has fewer than 100 lines, and fewer than one in thirty have more than 60, from the
/// line of `fn` to the closing brace, both counted, blank lines and comments too.
#[test]
fn tidy_functions_fit_on_a_screen() {
    let mut all = Vec::new();
    for (path, text) in files_below("src")
        .into_iter()
        .filter(|path| path.ends_with(".rs"))
        .map(|path| (path.clone(), text_of(&path)))
    {
        all.extend(
            functions(&production(&text))
                .into_iter()
                .map(|function| (path.clone(), function)),
        );
    }
    all.sort_by_key(|(_, function)| std::cmp::Reverse(function.lines));
    let long = all
        .iter()
        .filter(|(_, function)| function.lines > 60)
        .count();
    println!("{} functions, {long} above 60 lines", all.len());
    let told = |(path, function): &(String, code::Function)| {
        format!(
            "{path}:{}: {} has {} lines",
            function.line, function.name, function.lines
        )
    };
    let found: Vec<String> = all
        .iter()
        .filter(|(_, function)| function.lines >= 100)
        .map(told)
        .collect();
    check_none("functions of 100 lines and more", &found);
    let share = long as f64 / all.len() as f64;
    assert!(
        share < 1.0 / 30.0,
        "{long} of {} functions have more than 60 lines:\n{}",
        all.len(),
        all[..long].iter().map(told).collect::<Vec<_>>().join("\n")
    );
}

#[test]
fn tidy_the_count_of_lines_sees_functions_as_they_are() {
    let text = "fn a(x: [u8; 2]) -> [f64; 2] {\n    '}';\n    \"}\"\n}\ntrait T {\n    fn b();\n}\nfn c<'a>() { // }\n    fn d() {}\n    r#\"}\"#\n}\n";
    let found: Vec<(String, usize, usize)> = functions(&blank(text))
        .into_iter()
        .map(|function| (function.name, function.line, function.lines))
        .collect();
    let expected = [("a", 1, 4), ("c", 8, 4), ("d", 9, 1)];
    assert_eq!(
        found,
        expected.map(|(name, line, lines)| (name.to_string(), line, lines))
    );
}

// ---------------------------------------------------------------- names

#[test]
fn tidy_the_list_of_types_sees_every_visibility() {
    let text = "struct A;\npub enum B {}\npub(super) trait C {\n    type D;\n}\n\
                pub(in crate::gate) struct E(u8);\npub(crate) type F = u8;\nlet structure = 1;\n";
    let found: Vec<(String, usize)> = types(text);
    let expected = [("A", 1), ("B", 2), ("C", 3), ("E", 6), ("F", 7)];
    assert_eq!(found, expected.map(|(name, line)| (name.to_string(), line)));
}

/// A type's name leads to one definition, so that a search finds the thing.
#[test]
fn tidy_no_type_name_is_defined_twice() {
    let mut places: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for path in files_below("src") {
        if path.ends_with(".rs") {
            for (name, line) in types(&production(&text_of(&path))) {
                places
                    .entry(name)
                    .or_default()
                    .push(format!("{path}:{line}"));
            }
        }
    }
    assert!(places.len() > 200, "few types found");
    places.retain(|_, places| places.len() > 1);
    let idle: Vec<&str> = SHARED_NAMES
        .iter()
        .map(|(name, _)| *name)
        .filter(|name| !places.contains_key(*name))
        .collect();
    assert!(
        idle.is_empty(),
        "on the list of shared names, and not shared: {idle:?}"
    );
    let found: Vec<String> = places
        .into_iter()
        .filter(|(name, _)| !SHARED_NAMES.iter().any(|(known, _)| known == name))
        .map(|(name, places)| format!("{name}: {}", places.join(", ")))
        .collect();
    check_none("names of types that are defined more than once", &found);
}
