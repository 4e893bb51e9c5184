//! Guards what a terminal shows, letter by letter, at two widths. `LATCHGATE_RENEW=1` writes the
//! texts anew; they are read by a person before they are kept.

use super::{fixture, text};
use latchgate_report::terminal::Look;
use std::path::{Path, PathBuf};

fn check(name: &str, shown: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/it/report/terminal")
        .join(format!("{name}.txt"));
    if std::env::var_os("LATCHGATE_RENEW").is_some() {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, shown).unwrap();
    }
    let stored = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(stored == shown, "{name} differs:\n{shown}");
}

#[test]
fn regress_texts_of_every_answer_at_two_widths() {
    for (name, case) in fixture::all() {
        for width in [80, 120] {
            let look = Look {
                width: Some(width),
                ..Look::default()
            };
            let report = PathBuf::from("reports/out/x-5e1f5e1f");
            let shown = text::render(&case.document, Some(&report), look);
            let long = |line: &&str| line.chars().count() > width && line.contains(' ');
            let paths = |line: &&str| !line.contains("reports/out");
            let wide: Vec<&str> = shown.lines().filter(long).filter(paths).collect();
            assert!(wide.is_empty(), "{name} at {width}: {wide:?}");
            check(&format!("{name}-{width}"), &shown);
        }
    }
}

#[test]
fn regress_a_table_of_every_answer() {
    let cases = fixture::all();
    let rows: Vec<text::TableRow> = cases
        .iter()
        .enumerate()
        .map(|(index, (_, case))| text::TableRow {
            document: &case.document,
            judged: index != 0,
            report: Some(Path::new("reports/out/x")),
        })
        .collect();
    for width in [80, 120] {
        let look = Look {
            width: Some(width),
            ..Look::default()
        };
        check(&format!("table-{width}"), &text::table(&rows, look));
    }
}

/// Colour adds nothing: without its sequences the text is the plain one.
#[test]
fn verif_colours_say_nothing_that_words_do_not() {
    for (name, case) in fixture::all() {
        let look = Look {
            width: Some(80),
            ..Look::default()
        };
        let plain = text::render(&case.document, None, look);
        let colour = Look {
            colour: true,
            ..look
        };
        let painted = text::render(&case.document, None, colour);
        assert!(painted.contains("\x1b[1;"), "{name}");
        let bare: String = painted
            .split("\x1b[")
            .enumerate()
            .map(|(index, part)| match part.split_once('m') {
                Some((_, rest)) if index > 0 => rest,
                _ => part,
            })
            .collect();
        assert_eq!(bare, plain, "{name}");
    }
}
