//! Reading the sources as text: what stands in comments and strings taken out, functions with
//! their lengths, types, modules, and which file names whose items.

use std::collections::{BTreeMap, BTreeSet};

/// Replaces comments, strings and characters by blanks; lines stay where they are.
pub(super) fn blank(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    let mut before = ' ';
    while let Some(c) = rest.chars().next() {
        let part_of_a_name = before.is_alphanumeric() || before == '_';
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            block_comment(rest)
        } else if c == '"' {
            string(rest)
        } else if !part_of_a_name && (c == 'r' || rest.starts_with("br")) {
            raw_string(rest)
        } else if c == '\'' {
            character(rest)
        } else {
            0
        };
        if length == 0 {
            out.push(c);
            rest = &rest[c.len_utf8()..];
            before = c;
        } else {
            let hidden = rest[..length].chars();
            out.extend(hidden.map(|c| if c == '\n' { '\n' } else { ' ' }));
            rest = &rest[length..];
            before = ' ';
        }
    }
    out
}

fn block_comment(text: &str) -> usize {
    let mut depth = 0;
    let mut at = 0;
    while at < text.len() {
        if text[at..].starts_with("/*") {
            depth += 1;
            at += 2;
        } else if text[at..].starts_with("*/") {
            depth -= 1;
            at += 2;
            if depth == 0 {
                return at;
            }
        } else {
            at += text[at..].chars().next().map_or(1, char::len_utf8);
        }
    }
    text.len()
}

fn string(text: &str) -> usize {
    let mut escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        if c == '"' && !escaped {
            return at + 1;
        }
        escaped = c == '\\' && !escaped;
    }
    text.len()
}

/// Length of a raw string; 0 where the letter begins a name or a plain byte string.
fn raw_string(text: &str) -> usize {
    let inner = text.trim_start_matches('b').trim_start_matches('r');
    let marks = inner.len() - inner.trim_start_matches('#').len();
    if !text.trim_start_matches('b').starts_with('r') || !inner[marks..].starts_with('"') {
        return 0;
    }
    let end = format!("\"{}", "#".repeat(marks));
    let start = text.len() - inner.len() + marks + 1;
    text[start..]
        .find(&end)
        .map_or(text.len(), |at| start + at + end.len())
}

/// Length of a character; 0 for a lifetime.
fn character(text: &str) -> usize {
    let inner = &text[1..];
    if let Some(escaped) = inner.strip_prefix('\\') {
        let first = escaped.chars().next().map_or(0, char::len_utf8);
        return escaped[first..]
            .find('\'')
            .map_or(0, |at| 2 + first + at + 1);
    }
    let length = inner.chars().next().map_or(0, char::len_utf8);
    if inner[length..].starts_with('\'') {
        length + 2
    } else {
        0
    }
}

/// Names and `::`, braces and other marks of code whose comments and strings are blank, each with
/// its line.
pub(super) fn tokens(code: &str) -> Vec<(usize, &str)> {
    let mut found = Vec::new();
    for (number, line) in (1..).zip(code.lines()) {
        let mut rest = line;
        while let Some(c) = rest.chars().next() {
            let is_name = |c: char| c.is_alphanumeric() || c == '_';
            let length = if is_name(c) {
                rest.find(|c| !is_name(c)).unwrap_or(rest.len())
            } else if rest.starts_with("::") || rest.starts_with("->") {
                2
            } else {
                c.len_utf8()
            };
            if !c.is_whitespace() {
                found.push((number, &rest[..length]));
            }
            rest = &rest[length..];
        }
    }
    found
}

/// A function of the sources: the name, the line of its `fn`, and how many lines it has from there to
/// its closing brace, both counted, blank lines and comments too; attributes and what is said
/// above it are not.
#[derive(Debug, PartialEq)]
pub(super) struct Function {
    pub(super) name: String,
    pub(super) line: usize,
    pub(super) lines: usize,
}

/// All functions with a body; one inside another counts by itself and for the outer one.
pub(super) fn functions(code: &str) -> Vec<Function> {
    let tokens = tokens(code);
    let mut found = Vec::new();
    for (index, pair) in tokens.windows(2).enumerate() {
        let [(line, "fn"), (_, name)] = *pair else {
            continue;
        };
        if !name.starts_with(|c: char| c.is_alphabetic() || c == '_') {
            continue;
        }
        // A body's brace is the first outside of parentheses and brackets, where arrays and
        // constant arguments may stand; a `;` there ends a function that has none.
        let (mut depth, mut braces, mut end) = (0_i32, 0_i32, None);
        for (at, token) in &tokens[index..] {
            match *token {
                "(" | "[" if braces == 0 => depth += 1,
                ")" | "]" if braces == 0 => depth -= 1,
                ";" if depth == 0 && braces == 0 => break,
                "{" => braces += 1,
                "}" => {
                    braces -= 1;
                    if braces == 0 && depth == 0 {
                        end = Some(*at);
                        break;
                    }
                }
                _ => {}
            }
        }
        if let Some(end) = end {
            let lines = end - line + 1;
            found.push(Function {
                name: name.to_string(),
                line,
                lines,
            });
        }
    }
    found
}

/// Structs, enums, unions and traits that a file defines, and its type aliases outside of
/// implementations, with their lines.
pub(super) fn types(code: &str) -> Vec<(String, usize)> {
    let mut found = Vec::new();
    let mut inner = 0_usize;
    for (number, line) in (1..).zip(code.lines()) {
        let declared = without_visibility(line.trim_start());
        let words: Vec<&str> = declared
            .split(|c: char| !(c.is_alphanumeric() || c == '_'))
            .filter(|word| *word != "unsafe" && !word.is_empty())
            .collect();
        if let [kind, name, ..] = words.as_slice() {
            let defines = ["struct", "enum", "union", "trait"].contains(kind)
                || (*kind == "type" && inner == 0);
            if defines && declared.starts_with(|c: char| c.is_lowercase()) {
                found.push(((*name).to_string(), number));
            }
        }
        inner += line.matches('{').count();
        inner -= line.matches('}').count().min(inner);
    }
    found
}

/// Cuts `pub`, `pub(crate)`, `pub(in crate::gate)` and their like off a line.
fn without_visibility(line: &str) -> &str {
    let Some(rest) = line.strip_prefix("pub") else {
        return line;
    };
    match rest.strip_prefix('(').and_then(|rest| rest.split_once(')')) {
        Some((_, rest)) => rest.trim_start(),
        None => rest.trim_start(),
    }
}

/// What a file does with names of other modules.
#[derive(Debug, Default)]
pub(super) struct File {
    /// Modules it declares.
    children: BTreeSet<String>,
    /// Items it defines.
    items: BTreeSet<String>,
    /// Names that `use` brings in, with their full paths, and whether they are passed on.
    imports: Vec<Import>,
    /// Paths written out elsewhere, by their segments.
    paths: Vec<Vec<String>>,
    /// Names outside of `use`.
    names: BTreeSet<String>,
}

#[derive(Debug)]
struct Import {
    name: String,
    path: Vec<String>,
    public: bool,
}

/// Which file names items of which other, by path, through whatever passes them on.
///
/// A module is made of those below it, so its arrows to them do not count; nor does `pub use`, which
/// passes an item on, where the file does not use the item itself. A path leads to the file that defines its item; one that ends at a module leads
/// nowhere yet. Methods and fields, which have no path, are not seen.
pub(super) struct Uses {
    files: BTreeMap<String, File>,
}

impl Uses {
    /// Takes sources by their module, `a::b` for `src/a/b.rs`, and `` for `src/lib.rs`.
    pub(super) fn of(sources: impl IntoIterator<Item = (String, String)>) -> Self {
        let read = |(module, text): (String, String)| {
            let file = File::read(&module, &blank(&text));
            (module, file)
        };
        Self {
            files: sources.into_iter().map(read).collect(),
        }
    }

    /// Each module with those whose items it uses, those below it left out.
    pub(super) fn arrows(&self) -> BTreeMap<String, BTreeSet<String>> {
        let of = |module: &String, file: &File| {
            let mut used = BTreeSet::new();
            for import in &file.imports {
                if !import.public || file.names.contains(&import.name) {
                    used.extend(self.owner(&import.path, 0));
                }
            }
            for path in &file.paths {
                if let Some(full) = self.absolute(module, path) {
                    used.extend(self.owner(&full, 0));
                }
            }
            let below = format!("{module}::");
            used.retain(|other| other != module && !other.starts_with(&below));
            used
        };
        self.files
            .iter()
            .map(|(module, file)| (module.clone(), of(module, file)))
            .collect()
    }

    /// A path from the crate's root, where its first name leads to a module of this crate.
    fn absolute(&self, module: &str, path: &[String]) -> Option<Vec<String>> {
        let first = path.first()?.as_str();
        if ["crate", "super", "self"].contains(&first) {
            return Some(from_root(module, path));
        }
        let file = &self.files[module];
        if file.children.contains(first) {
            return Some(from_root(module, &[&["self".to_string()], path].concat()));
        }
        let import = file.imports.iter().find(|import| import.name == first)?;
        Some([&import.path, &path[1..]].concat())
    }

    /// The module whose file defines the item at `path`.
    fn owner(&self, path: &[String], depth: usize) -> Option<String> {
        let mut module = String::new();
        let mut rest = path;
        while let Some(first) = rest.first() {
            let next = if module.is_empty() {
                first.clone()
            } else {
                format!("{module}::{first}")
            };
            if !self.files.contains_key(&next) {
                break;
            }
            module = next;
            rest = &rest[1..];
        }
        let item = rest.first()?;
        let file = self.files.get(&module)?;
        if file.items.contains(item) || depth > 8 {
            return Some(module);
        }
        let passed = file.imports.iter().find(|import| import.name == *item);
        match passed {
            Some(import) => self.owner(&[&import.path, &rest[1..]].concat(), depth + 1),
            // Brought in by `*`, or made by a macro.
            None => Some(module),
        }
    }
}

/// Resolves `crate`, `super` and `self` at the head of a path that stands in `module`.
fn from_root(module: &str, path: &[String]) -> Vec<String> {
    let mut at: Vec<String> = match path[0].as_str() {
        "crate" => Vec::new(),
        _ => module
            .split("::")
            .filter(|part| !part.is_empty())
            .map(str::to_string)
            .collect(),
    };
    for (index, part) in path.iter().enumerate() {
        match part.as_str() {
            "crate" | "self" if index == 0 => {}
            "super" => drop(at.pop()),
            _ => at.push(part.clone()),
        }
    }
    at
}

impl File {
    fn read(module: &str, code: &str) -> Self {
        let mut file = Self::default();
        let tokens: Vec<&str> = tokens(code).into_iter().map(|(_, token)| token).collect();
        for words in tokens.windows(3) {
            if words[0] == "mod" && words[2] == ";" {
                file.children.insert(words[1].to_string());
            }
        }
        let mut at = 0;
        let mut public = false;
        while at < tokens.len() {
            let next = tokens.get(at + 1).copied().unwrap_or_default();
            match tokens[at] {
                "pub" => public = true,
                "use" => {
                    let (end, found) = use_tree(&tokens, at + 1);
                    for path in found {
                        file.import(module, path, public);
                    }
                    at = end;
                }
                "fn" | "struct" | "enum" | "union" | "trait" | "const" | "static" | "type" => {
                    file.items.insert(next.to_string());
                }
                "macro_rules" => {
                    file.items
                        .extend(tokens.get(at + 2).map(|name| (*name).to_string()));
                }
                _ if next == "::" => {
                    let start = at;
                    while tokens.get(at + 1) == Some(&"::")
                        && tokens.get(at + 2).is_some_and(|name| is_name(name))
                    {
                        at += 2;
                    }
                    let path = tokens[start..=at].iter().step_by(2);
                    let path: Vec<String> = path.map(|part| (*part).to_string()).collect();
                    file.names.insert(path[0].clone());
                    if path.len() > 1 {
                        file.paths.push(path);
                    }
                }
                name if is_name(name) => {
                    file.names.insert(name.to_string());
                }
                _ => {}
            }
            // `pub(crate) use`: the word holds until the item itself.
            public &= ["pub", "(", ")", "crate", "super", "in", "self", "::"]
                .contains(&tokens.get(at).copied().unwrap_or_default());
            at += 1;
        }
        file
    }

    fn import(&mut self, module: &str, (path, alias): (Vec<String>, String), public: bool) {
        let full = match path[0].as_str() {
            "crate" | "super" | "self" => from_root(module, &path),
            first if self.children.contains(first) => {
                from_root(module, &[&["self".to_string()], &*path].concat())
            }
            // Another crate.
            _ => return,
        };
        self.imports.push(Import {
            name: alias,
            path: full,
            public,
        });
    }
}

fn is_name(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// Reads a tree of `use` up to its `;`: where that stands, and each path with the name it gets.
fn use_tree(tokens: &[&str], from: usize) -> (usize, Vec<(Vec<String>, String)>) {
    let mut found = Vec::new();
    let mut open: Vec<Vec<String>> = Vec::new();
    let mut path: Vec<String> = Vec::new();
    let mut alias = None;
    let mut at = from;
    while at < tokens.len() && tokens[at] != ";" {
        let mut end_of_path = |path: &mut Vec<String>, alias: &mut Option<String>| {
            if path.last().is_some_and(|last| last == "self") && path.len() > 1 {
                path.pop();
            }
            if let Some(last) = path.last().cloned() {
                found.push((path.clone(), alias.take().unwrap_or(last)));
            }
        };
        match tokens[at] {
            "{" => open.push(path.clone()),
            "}" | "," => {
                if !path.is_empty() && Some(&path) != open.last() {
                    end_of_path(&mut path, &mut alias);
                }
                if tokens[at] == "}" {
                    open.pop();
                    // What follows the brace belongs to the tree around it.
                    path.clear();
                    if let Some(around) = open.last() {
                        path.clone_from(around);
                    }
                } else {
                    path = open.last().cloned().unwrap_or_default();
                }
            }
            "as" => {
                alias = tokens.get(at + 1).map(|name| (*name).to_string());
                at += 1;
            }
            "::" => {}
            name => path.push(name.to_string()),
        }
        at += 1;
    }
    if !path.is_empty() && open.is_empty() {
        let last = path.last().cloned().expect("a path has a name");
        found.push((path, alias.unwrap_or(last)));
    }
    (at, found)
}

/// Groups of modules that reach one another along arrows, each of two or more.
pub(super) fn circles(arrows: &BTreeMap<String, BTreeSet<String>>) -> Vec<BTreeSet<String>> {
    let reach = |from: &String| {
        let mut seen = BTreeSet::new();
        let mut open = vec![from];
        while let Some(module) = open.pop() {
            for next in arrows.get(module).into_iter().flatten() {
                if seen.insert(next.clone()) {
                    open.push(next);
                }
            }
        }
        seen
    };
    let reached: BTreeMap<&String, BTreeSet<String>> = arrows
        .keys()
        .map(|module| (module, reach(module)))
        .collect();
    let mut found: BTreeSet<BTreeSet<String>> = BTreeSet::new();
    for (module, seen) in &reached {
        if seen.contains(*module) {
            let back = |other: &&String| reached.get(*other).is_some_and(|r| r.contains(*module));
            found.insert(seen.iter().filter(back).cloned().collect());
        }
    }
    found.into_iter().collect()
}
