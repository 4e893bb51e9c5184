//! No circle of files inside a crate; between crates cargo forbids them.

use crate::tidy::{CRATES, check_none, files_below, text_of, without_comments};
use std::collections::{BTreeMap, BTreeSet};

/// Arrows of one crate: a module, and the modules outside its own family that it names.
type Arrows = BTreeMap<String, BTreeSet<String>>;

/// Returns the paths in `code` that begin at the crate's root or at a module above, as written.
fn paths(code: &str) -> Vec<String> {
    let word = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    let mut found = Vec::new();
    for root in ["crate::", "super::"] {
        for (offset, _) in code.match_indices(root) {
            if code[..offset].ends_with(|c: char| c == ':' || c.is_alphanumeric()) {
                continue;
            }
            let rest = &code[offset..];
            let end = rest.find(|c| !word(c)).unwrap_or(rest.len());
            let path = rest[..end].trim_end_matches(':');
            match rest[end..].strip_prefix('{') {
                // `use super::{a, b::C}`: the modules are first on each entry.
                Some(list) => {
                    let list = list.split([';', '}']).next().unwrap_or_default();
                    let entries = list.split([',', '{']).map(str::trim);
                    found.extend(entries.map(|entry| format!("{path}::{entry}")));
                }
                None => found.push(path.to_string()),
            }
        }
    }
    found
}

/// Returns the arrows of a crate's modules, each with its code.
fn arrows(modules: &BTreeMap<String, String>) -> Arrows {
    let family = |a: &str, b: &str| {
        a == b || a.starts_with(&format!("{b}::")) || b.starts_with(&format!("{a}::"))
    };
    let target = |module: &str, path: &str| -> Option<String> {
        let mut base: Vec<&str> = module.split("::").filter(|part| !part.is_empty()).collect();
        let mut rest = path.split("::").peekable();
        while let Some(root) = rest.next_if(|part| matches!(*part, "crate" | "super")) {
            match root {
                "crate" => base.clear(),
                _ => drop(base.pop()),
            }
        }
        let mut deepest = base.join("::");
        for part in rest {
            base.push(part);
            if modules.contains_key(&base.join("::")) {
                deepest = base.join("::");
            }
        }
        (!deepest.is_empty()).then_some(deepest)
    };
    let named = |(module, code): (&String, &String)| {
        let targets = paths(code)
            .iter()
            .filter_map(|path| target(module, path))
            .filter(|other| !family(module, other))
            .collect();
        (module.clone(), targets)
    };
    modules.iter().map(named).collect()
}

/// Returns each module that reaches itself, with those it names on the way.
fn circles(arrows: &Arrows) -> Vec<String> {
    let reach = |from: &String| {
        let mut seen = BTreeSet::new();
        let mut open = vec![from];
        while let Some(next) = open.pop() {
            for module in arrows.get(next).into_iter().flatten() {
                if seen.insert(module) {
                    open.push(module);
                }
            }
        }
        seen
    };
    let reached: BTreeMap<&String, BTreeSet<&String>> = arrows
        .keys()
        .map(|module| (module, reach(module)))
        .collect();
    let mut found = Vec::new();
    for (module, seen) in &reached {
        if seen.contains(module) {
            let back = |other: &&&String| reached.get(**other).is_some_and(|r| r.contains(module));
            let circle: Vec<&str> = seen
                .iter()
                .filter(back)
                .map(|other| other.as_str())
                .collect();
            found.push(format!("{module} is in a circle of {}", circle.join(", ")));
        }
    }
    found
}

#[test]
fn tidy_no_circle_of_files() {
    let mut found = Vec::new();
    for folder in CRATES {
        let modules = files_below(folder)
            .into_iter()
            .filter(|path| path.ends_with(".rs"))
            .map(|path| {
                let code = without_comments(&text_of(&path));
                let end = code.find("#[cfg(test)]").unwrap_or(code.len());
                let inner = path[folder.len() + 1..].trim_end_matches(".rs");
                let module = match inner {
                    "lib" | "main" => String::new(),
                    inner => inner.replace('/', "::"),
                };
                (module, code[..end].to_string())
            })
            .collect();
        let here = circles(&arrows(&modules));
        found.extend(here.into_iter().map(|circle| format!("{folder}: {circle}")));
    }
    check_none("files that use one another in a circle", &found);
}

/// The scan sees the forms in which a file names another.
#[test]
fn tidy_the_scan_for_circles_sees_what_it_should() {
    let ring = |of_b: &str, of_c: &str| {
        let modules = [("a", ""), ("a::b", of_b), ("a::c", of_c)];
        let modules = modules.map(|(name, code)| (name.to_string(), code.to_string()));
        circles(&arrows(&BTreeMap::from(modules))).len()
    };
    assert_eq!(ring("use super::c::C;", "use crate::a::b::B;"), 2);
    assert_eq!(ring("use super::{A, c};", "fn f(_: super::b::B) {}"), 2);
    assert_eq!(ring("use super::c::C;", "use super::A;"), 0);
    assert_eq!(ring("use super::A;", "use crate::a;"), 0);
}
