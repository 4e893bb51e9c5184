//! Guards the pages that show examples: each is read, or refused, by the commands that stand below it.

use crate::support::{Done, Folder, finish, program};
use crate::tidy::{files_below, text_of};
use std::path::Path;

/// A fenced block of a page: what stands behind the fence, and its lines.
fn blocks(page: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        if let Some(head) = line.strip_prefix("```") {
            let inner: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
            found.push((head.to_string(), inner.join("\n") + "\n"));
        }
    }
    found
}

/// Runs a line of a page: beside its examples, or where the recordings of the project lie.
#[track_caller]
fn run(line: &str, folder: &Folder) -> Done {
    let quoted: Vec<&str> = line.split('"').collect();
    let mut words: Vec<&str> = Vec::new();
    for (index, part) in quoted.iter().enumerate() {
        match index % 2 {
            0 => words.extend(part.split_whitespace()),
            _ => words.push(part),
        }
    }
    assert_eq!(words.remove(0), "latchgate", "{line}");
    let at = if line.contains("signals/") || line.contains("tests/data/") {
        Path::new(env!("CARGO_MANIFEST_DIR"))
    } else {
        folder.path()
    };
    finish(program().current_dir(at).args(&words))
}

/// The first command of each section brings the message in its title, the others do not.
#[test]
fn cli_messages_on_the_page_of_troubles_come_and_go() {
    let page = text_of("docs/troubleshooting.md");
    let folder = Folder::new("page-troubles");
    let mut sections = 0;
    for section in page.split("\n## ").skip(1) {
        let title = section.lines().next().unwrap();
        let message = title.split('`').nth(1);
        let mut lines = Vec::new();
        for (head, text) in blocks(section) {
            match head.split_once(' ') {
                Some((_, name)) => {
                    folder.write(name, text);
                }
                None => lines.extend(text.lines().map(str::to_string)),
            }
        }
        for (index, line) in lines.iter().enumerate() {
            let done = run(line, &folder);
            // Lines are wrapped with a hanging indent.
            let said = format!("{}{}", done.out, done.err).replace("\n    ", " ");
            let comes = said.contains(message.unwrap());
            assert_eq!(comes, index == 0, "{line}\n{said}");
            sections += usize::from(index == 0);
        }
    }
    assert!(sections >= 8, "{sections}");
}

#[test]
fn cli_examples_on_the_pages_of_formats_are_read() {
    let pages = files_below("docs/formats");
    assert_eq!(pages.len(), 7, "{pages:?}");
    let mut commands = 0;
    for page in pages {
        let folder = Folder::new(&format!("page-{}", page.replace('/', "-")));
        for (head, text) in blocks(&text_of(&page)) {
            if let Some((_, name)) = head.split_once(' ') {
                folder.write(name, text);
                continue;
            }
            for line in text.lines() {
                let done = run(line, &folder);
                assert_eq!(done.code, 0, "{page}: {line}\n{}{}", done.out, done.err);
                commands += 1;
            }
        }
    }
    assert!(commands >= 12, "{commands}");
}
