//! Guards the repository itself: what its documents say of it holds, and nothing in it speaks of the
//! machine it was written on.

use latchgate_kernel::model::Design;
use latchgate_recording::FORMATS;
use latchgate_recording::setting::Setting;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

pub(crate) fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

pub(crate) fn text_of(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Returns every file below `folder`, relative to the root with `/` between folders, without
/// build products and without what git keeps for itself.
pub(crate) fn files_below(folder: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut open = vec![PathBuf::from(folder)];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(root().join(&folder)).unwrap() {
            let entry = entry.unwrap();
            let name = entry.file_name().into_string().unwrap();
            let path = folder.join(&name);
            let shown = path.to_str().unwrap().replace('\\', "/");
            let shown = shown.trim_start_matches("./").to_string();
            if matches!(
                shown.as_str(),
                "target" | "fuzz/target" | "fuzz/found" | "fuzz/corpus" | ".git" | "reports/out"
            ) {
                continue;
            }
            let kind = entry.file_type().unwrap();
            if kind.is_dir() {
                open.push(path);
            } else if kind.is_file() {
                found.push(shown);
            }
        }
    }
    found.sort();
    found
}

/// Sources of each crate.
pub(crate) const CRATES: [&str; 9] = [
    "src",
    "crates/kernel/src",
    "crates/recording/src",
    "crates/verdict/src",
    "crates/document/src",
    "crates/report/src",
    "crates/study/src",
    "crates/service/src",
    "crates/python/src",
];

/// Returns the sources of the library, without those of command line and service, each with its text.
fn library_sources() -> Vec<(String, String)> {
    CRATES
        .into_iter()
        .flat_map(files_below)
        .filter(|path| path.ends_with(".rs"))
        .filter(|path| !path.starts_with("src/cli") && !path.starts_with("crates/service"))
        .map(|path| {
            let text = text_of(&path);
            (path, text)
        })
        .collect()
}

/// Drops lines that are comments whole; what is said there is not done.
pub(crate) fn without_comments(text: &str) -> String {
    text.lines()
        .map(|line| {
            if line.trim_start().starts_with("//") {
                ""
            } else {
                line
            }
        })
        .collect::<Vec<_>>()
        .join("\n")
}

pub(crate) fn line_of(text: &str, offset: usize) -> usize {
    1 + text[..offset].matches('\n').count()
}

#[track_caller]
pub(crate) fn check_none(what: &str, found: &[String]) {
    assert!(found.is_empty(), "{what}:\n{}", found.join("\n"));
}

/// Returns what stands between single backticks, outside of fenced blocks.
pub(crate) fn quoted(markdown: &str) -> Vec<String> {
    markdown
        .split("```")
        .step_by(2)
        .flat_map(|part| {
            part.split('`')
                .skip(1)
                .step_by(2)
                .map(str::to_string)
                .collect::<Vec<_>>()
        })
        .collect()
}

/// The architecture, and the recipes beside it, name files that there are.
#[test]
fn tidy_paths_named_in_the_architecture_exist() {
    let folders = [
        "tests/",
        "docs/",
        "signals/",
        "reports/",
        "examples/",
        ".ci/",
    ];
    for document in ["docs/architecture.md", "docs/gate.md", "docs/service.md"] {
        // The others speak of their users' files as well.
        let whole = document == "docs/architecture.md";
        let named: Vec<String> = quoted(&text_of(document))
            .into_iter()
            .filter(|word| {
                let sources = word.starts_with("src/") || word.starts_with("crates/");
                let led = folders.iter().any(|folder| word.starts_with(folder));
                let ends = [".md", ".rs", ".toml"]
                    .iter()
                    .any(|end| word.ends_with(end));
                sources || whole && (led || ends)
            })
            .filter(|word| !word.contains(['*', '<', 'N', ' ']))
            .collect();
        assert!(named.len() > 5, "few paths found: {named:?}");
        let missing: Vec<String> = named
            .into_iter()
            .filter(|path| path != "reports/out/" && !root().join(path).exists())
            .collect();
        check_none(
            &format!("{document} names paths that do not exist"),
            &missing,
        );
    }
}

/// Folders of the tests of each crate.
const TEST_FOLDERS: [&str; 4] = [
    "tests/it",
    "tests/golden",
    "crates/kernel/tests/it",
    "crates/verdict/tests/it",
];

/// Returns the sources of all tests.
fn test_sources() -> String {
    let files = TEST_FOLDERS.iter().flat_map(|folder| files_below(folder));
    let sources = files.filter(|path| path.ends_with(".rs"));
    sources.map(|path| text_of(&path)).collect()
}

/// A test that the architecture names is one.
#[test]
fn tidy_tests_named_in_the_architecture_exist() {
    let tests = test_sources();
    let named: Vec<String> = quoted(&text_of("docs/architecture.md"))
        .into_iter()
        .filter(|word| {
            ["tidy_", "verif_", "val_", "regress_", "prop_", "cli_"]
                .iter()
                .any(|prefix| word.starts_with(prefix))
        })
        .collect();
    assert!(named.len() > 5, "few tests found: {named:?}");
    let missing: Vec<String> = named
        .into_iter()
        .filter(|name| !tests.contains(&format!("fn {name}()")))
        .collect();
    check_none("tests that there are not", &missing);
}

/// Relative links of every document lead somewhere.
#[test]
fn tidy_links_in_documents_lead_somewhere() {
    let mut broken = Vec::new();
    for path in &files_below(".") {
        if !path.ends_with(".md") {
            continue;
        }
        let text = text_of(path);
        for link in text.split("](").skip(1) {
            let target = link.split([')', '#']).next().unwrap_or_default();
            if target.is_empty() || target.contains("://") {
                continue;
            }
            let folder = root().join(path).parent().unwrap().to_path_buf();
            if !folder.join(target).exists() {
                broken.push(format!("{path}: {target}"));
            }
        }
    }
    check_none("links that lead nowhere", &broken);
}

/// Errors and findings name a setting; only the command line spells it as an option.
#[test]
fn tidy_only_the_command_line_spells_options() {
    let mut found = Vec::new();
    for (path, text) in library_sources() {
        // Comments too: a library's documents speak of its own names.
        for (offset, mark) in text.match_indices("--") {
            let before = text[..offset].chars().next_back();
            let word: String = text[offset + mark.len()..]
                .chars()
                .take_while(|c| c.is_ascii_alphanumeric() || "-_".contains(*c))
                .collect();
            let option = word.starts_with(|c: char| c.is_ascii_lowercase());
            // A longer dash, and a style's own property: `var(--tone)`, `{--tone:`, `--tone: red`.
            let dash = before == Some('-');
            let property = path == "crates/report/src/sheet.rs"
                && text[offset + mark.len() + word.len()..].starts_with(':');
            let styles = text[..offset].ends_with("var(") || before == Some('{') || property;
            if option && !dash && !styles {
                found.push(format!("{path}:{}: --{word}", line_of(&text, offset)));
            }
        }
    }
    check_none("options spelt outside src/cli; name the setting", &found);
}

/// A setting that a text names is one, so that every door can word it.
#[test]
fn tidy_settings_named_in_texts_exist() {
    let mut unknown = Vec::new();
    let mut named = 0;
    for (path, text) in library_sources() {
        let code = without_comments(&text);
        for (offset, lead) in code.match_indices("the setting `") {
            let key = code[offset + lead.len()..].split('`').next().unwrap_or("");
            named += 1;
            if key != "{}" && !Setting::ALL.iter().any(|setting| setting.key() == key) {
                unknown.push(format!("{path}:{}: {key}", line_of(&code, offset)));
            }
        }
    }
    assert!(named > 20, "few settings found");
    check_none("settings that there are not", &unknown);
}

/// What `tests/run` leaves to `--all` is there.
#[test]
fn tidy_the_slow_tests_exist() {
    let missing: Vec<String> = text_of("tests/slow.txt")
        .lines()
        .filter(|name| {
            let (module, function) = name.rsplit_once("::").expect("a module and a test");
            let module = module.replace("::", "/");
            !TEST_FOLDERS.iter().any(|folder| {
                let file = format!("{folder}/{module}.rs");
                root().join(&file).exists() && text_of(&file).contains(&format!("fn {function}()"))
            })
        })
        .map(str::to_string)
        .collect();
    check_none("slow tests that there are not", &missing);
}

#[test]
fn tidy_every_signal_has_a_card() {
    let files = files_below("signals");
    let bare: Vec<String> = files
        .iter()
        .filter(|path| !path.ends_with(".toml") && !files.contains(&format!("{path}.toml")))
        .cloned()
        .collect();
    assert!(files.len() >= 12, "signals/ is nearly empty: {files:?}");
    check_none("recordings without a card", &bare);
}

#[test]
fn tidy_nothing_speaks_of_the_machine_it_was_written_on() {
    // Put together here, so that this file does not find itself.
    let folders: Vec<String> = ["work", "root", "home"]
        .iter()
        .map(|name| format!("/{name}/"))
        .collect();
    let mut found = Vec::new();
    for path in &files_below(".") {
        let told_by_end = [
            ".md", ".rs", ".toml", ".sh", ".html", ".json", ".svg", ".yml",
        ];
        let is_text = told_by_end.iter().any(|end| path.ends_with(end))
            || matches!(path.as_str(), "tests/run" | ".ci/run" | "Cargo.lock");
        if !is_text {
            continue;
        }
        let text = text_of(path);
        for (number, line) in (1..).zip(text.lines()) {
            if folders.iter().any(|folder| line.contains(folder)) {
                found.push(format!("{path}:{number}"));
            }
        }
    }
    check_none("absolute paths of some machine", &found);
}

/// Returns each finding's code and severity as the sources build them.
fn built_findings() -> BTreeSet<(String, String)> {
    let mut found = BTreeSet::new();
    for (path, code) in library_sources() {
        for severity in ["info", "warning", "blocking"] {
            let call = format!("Finding::{severity}(");
            for (offset, _) in code.match_indices(&call) {
                let rest = code[offset + call.len()..].trim_start();
                let Some(literal) = rest.strip_prefix('"') else {
                    // A code that is a constant or an argument: the reverse check covers it.
                    continue;
                };
                let name = literal.split('"').next().unwrap_or_default();
                assert!(
                    !name.is_empty()
                        && name.chars().all(|c| c.is_ascii_lowercase()
                            || c.is_ascii_digit()
                            || "-_".contains(c)),
                    "{path}: a finding's code is lower-case words, found `{name}`"
                );
                found.insert((name.to_string(), severity.to_string()));
            }
        }
    }
    found
}

#[test]
fn tidy_every_finding_is_documented_with_its_severity() {
    let text = text_of("docs/findings.md");
    let rows: Vec<(String, String)> = text
        .lines()
        .filter(|line| line.starts_with("| `"))
        .map(|line| {
            let cells: Vec<&str> = line.split('|').map(str::trim).collect();
            (cells[1].trim_matches('`').to_string(), cells[2].to_string())
        })
        .collect();
    let missing: Vec<String> = built_findings()
        .into_iter()
        .filter(|(code, severity)| {
            !rows
                .iter()
                .any(|(name, told)| name == code && told.contains(severity.as_str()))
        })
        .map(|(code, severity)| format!("| `{code}` | {severity} |"))
        .collect();
    check_none("findings that docs/findings.md does not list", &missing);

    let all: String = library_sources()
        .into_iter()
        .map(|(_, code)| code)
        .collect();
    let stale: Vec<String> = rows
        .into_iter()
        .map(|(code, _)| code)
        .filter(|code| !all.contains(&format!("\"{code}\"")))
        .collect();
    check_none("findings in docs/findings.md that nothing builds", &stale);
}

/// Every finding is named by a test, here or in the golden set.
#[test]
fn tidy_every_finding_has_a_test() {
    let text = text_of("docs/findings.md");
    let golden = files_below("tests/data/golden");
    let golden = golden.iter().filter(|path| path.ends_with(".toml"));
    let tests = test_sources() + &golden.map(|path| text_of(path)).collect::<String>();
    let untested: Vec<String> = text
        .lines()
        .filter_map(|line| Some(line.strip_prefix("| `")?.split_once('`')?.0.to_string()))
        .filter(|code| {
            !tests.contains(&format!("\"{code}\"")) && !tests.contains(&format!(" {code}\""))
        })
        .collect();
    check_none("findings that no test names", &untested);
}

/// Every format of the table is in the README, where a reader looks for it.
#[test]
fn tidy_the_readme_names_every_format() {
    let text = text_of("README.md").to_lowercase();
    let missing: Vec<String> = FORMATS
        .iter()
        .map(|format| format.name.to_string())
        .filter(|name| !text.contains(name.as_str()))
        .collect();
    check_none("formats that the README leaves out", &missing);
}

#[test]
fn tidy_the_design_file_in_the_readme_is_the_reference_design() {
    let text = text_of("README.md");
    let block = text
        .split("```toml\n")
        .nth(1)
        .and_then(|rest| rest.split("```").next())
        .expect("the README shows a design file");
    let mut design = latchgate_document::design_file::from_toml(block).unwrap();
    design.name = Design::reference().name;
    assert_eq!(design, Design::reference());
}

#[test]
fn tidy_every_version_in_the_change_notes_opens_with_verdicts() {
    let text = text_of("CHANGELOG.md");
    let versions: Vec<&str> = text.split("\n## ").skip(1).collect();
    assert!(!versions.is_empty());
    assert!(
        text.contains(env!("CARGO_PKG_VERSION")),
        "CHANGELOG.md does not speak of version {}",
        env!("CARGO_PKG_VERSION")
    );
    for version in versions {
        let mut lines = version.lines().filter(|line| !line.trim().is_empty());
        let title = lines.next().unwrap();
        assert_eq!(lines.next(), Some("### Verdicts"), "version {title}");
    }
}

fn help(arguments: &[&str]) -> String {
    let output = crate::support::program()
        .args(arguments)
        .arg("--help")
        .env_remove("CLICOLOR_FORCE")
        .env("NO_COLOR", "1")
        .env("COLUMNS", "100")
        .output()
        .unwrap();
    assert!(output.status.success(), "latchgate {arguments:?} --help");
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines()
        .map(str::trim_end)
        .collect::<Vec<_>>()
        .join("\n")
        .trim()
        .to_string()
}

/// Returns the commands that a help text lists, `help` itself left out.
fn commands_in(text: &str) -> Vec<String> {
    text.lines()
        .skip_while(|line| *line != "Commands:")
        .skip(1)
        .take_while(|line| !line.is_empty())
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|name| *name != "help")
        .map(str::to_string)
        .collect()
}

/// Options and arguments of help texts that a document has shown already.
#[derive(Default)]
struct ShownOptions {
    global: BTreeSet<String>,
    others: BTreeSet<String>,
}

impl ShownOptions {
    /// Returns a help text without what was shown before: options of the program itself are left
    /// out, those of another command are named.
    fn shorten(&mut self, text: &str, is_main: bool) -> String {
        let mut blocks: Vec<String> = Vec::new();
        for line in text.lines() {
            let indent = line.len() - line.trim_start().len();
            let starts =
                indent == 0 || indent < 10 && line.trim_start().starts_with(['-', '<', '[']);
            if starts && !line.is_empty() || blocks.is_empty() {
                blocks.push(String::new());
            }
            let block = blocks.last_mut().unwrap();
            block.push_str(line);
            block.push('\n');
        }
        let mut short = String::new();
        let mut heading = "";
        let mut known: Vec<&str> = Vec::new();
        for block in &blocks {
            if !block.starts_with(' ') {
                short.push_str(&as_above(heading, &known));
                known.clear();
                let is_heading = block.trim_end().ends_with(':') && !block.trim().contains('\n');
                heading = if is_heading { block } else { "" };
                if !is_heading {
                    short.push_str(block);
                }
            } else if self.others.contains(block.trim()) {
                known.extend(block.split_whitespace().find(|word| word.starts_with("--")));
            } else if !self.global.contains(block.trim()) {
                self.others.insert(block.trim().to_string());
                short.push_str(heading);
                short.push_str(block);
                heading = "";
            }
        }
        short.push_str(&as_above(heading, &known));
        if is_main {
            self.global = std::mem::take(&mut self.others);
        }
        short.trim_end().to_string()
    }
}

/// Returns the line that names options which another command explains.
fn as_above(heading: &str, known: &[&str]) -> String {
    if known.is_empty() {
        return String::new();
    }
    let lines: Vec<String> = known.chunks(7).map(|names| names.join(" ")).collect();
    format!("{heading}  As above: {}\n\n", lines.join("\n            "))
}

/// Returns docs/cli.md as the binary's own help texts make it.
fn cli_document() -> String {
    let main = help(&[]);
    let commands = commands_in(&main);
    assert!(
        commands.iter().any(|name| name == "replay"),
        "commands found: {commands:?}"
    );
    let mut shown = ShownOptions::default();
    let mut document = format!(
        "# Command line\n\nThe help texts of the program. Options of `latchgate` itself hold for every command; an option that\n\
         several commands share is explained once; `latchgate study NAME --help` explains those of a study. This file is written by\n\
         `LATCHGATE_RENEW=1 cargo test --test it tidy_docs_cli` and compared with `--help` by every test run.\n\n\
         ## latchgate\n\n```text\n{}\n```\n",
        shown.shorten(&main, true)
    );
    for name in &commands {
        document.push_str(&format!(
            "\n## latchgate {name}\n\n```text\n{}\n```\n",
            shown.shorten(&help(&[name]), false)
        ));
    }
    document
}

#[test]
fn tidy_docs_cli_equals_the_help_of_the_program() {
    let document = cli_document();
    let path = root().join("docs/cli.md");
    if std::env::var_os("LATCHGATE_RENEW").is_some() {
        fs::write(&path, &document).unwrap();
    }
    let stored = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        stored == document,
        "docs/cli.md differs from --help; run `LATCHGATE_RENEW=1 cargo test --test it tidy_docs_cli` and look at the difference"
    );
}

/// What a reader copies from a document must exist.
#[test]
fn tidy_files_named_in_the_readme_exist() {
    let text = text_of("README.md");
    let mut missing: Vec<String> = text
        .split(|c: char| c.is_whitespace() || "`()\"".contains(c))
        .map(|word| word.trim_end_matches(['.', ',', ':', ';']))
        .filter(|word| {
            ["signals/", "docs/", "tests/", "examples/"]
                .iter()
                .any(|folder| word.starts_with(folder))
        })
        .filter(|word| !Path::new(&root()).join(word).exists())
        .map(str::to_string)
        .collect();
    missing.dedup();
    check_none(
        "files that the README names and that do not exist",
        &missing,
    );
}

#[test]
fn tidy_every_command_of_a_figure_is_in_the_renewal() {
    let renewal = text_of("reports/renew");
    let renewed: Vec<&str> = renewal
        .lines()
        .filter_map(|line| line.strip_prefix("figure "))
        .filter_map(|line| line.split_once(' '))
        .map(|(_, command)| command)
        .collect();
    let mut found = 0;
    for line in text_of("docs/reproduction.md").lines() {
        let Some(command) = line.strip_prefix("latchgate ") else {
            continue;
        };
        if !command.starts_with("study ") {
            continue;
        }
        let command = command.split(" --out ").next().unwrap_or(command);
        assert!(
            renewed.contains(&command),
            "docs/reproduction.md: `{command}` is not in reports/renew"
        );
        found += 1;
    }
    assert!(found >= 15, "{found} commands found");
}
