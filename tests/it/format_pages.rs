//! Guards the pages of the formats: each example is read by the commands that stand below it.

use crate::support::{Folder, finish, program};
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

#[test]
fn cli_examples_on_the_pages_of_formats_are_read() {
    let pages = files_below("docs/formats");
    assert_eq!(pages.len(), 5, "{pages:?}");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut commands = 0;
    for page in pages {
        let folder = Folder::new(&format!("page-{}", page.replace('/', "-")));
        for (head, text) in blocks(&text_of(&page)) {
            if let Some((_, name)) = head.split_once(' ') {
                folder.write(name, text);
                continue;
            }
            for line in text.lines() {
                let quoted: Vec<&str> = line.split('"').collect();
                let mut words: Vec<&str> = Vec::new();
                for (index, part) in quoted.iter().enumerate() {
                    match index % 2 {
                        0 => words.extend(part.split_whitespace()),
                        _ => words.push(part),
                    }
                }
                assert_eq!(words.remove(0), "latchgate", "{page}: {line}");
                let at = if line.contains("signals/") {
                    root
                } else {
                    folder.path()
                };
                let done = finish(program().current_dir(at).args(&words));
                assert_eq!(done.code, 0, "{page}: {line}\n{}{}", done.out, done.err);
                commands += 1;
            }
        }
    }
    assert!(commands >= 12, "{commands}");
}
