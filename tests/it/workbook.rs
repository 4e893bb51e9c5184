//! Workbooks: read to the last bit as openpyxl and xlrd read them, judged as the same samples in another
//! format, and never better when they are damaged.

use crate::support::workbook::{Cell, Records, Sheet, Workbook, container, of_rows, text, xls};
use crate::support::{Folder, Random, data, json, latchgate, read_path, with_channel, zip_of};
use latchgate::pipeline::{
    CardPolarity, Control, Design, Document, Extras, Limits, Request, Source, judge,
};
use latchgate_recording::{ReadOptions, Selection};
use std::collections::BTreeMap;

/// Files of `tests/data/workbook/`, with what openpyxl and xlrd find in them.
#[test]
fn val_every_sample_is_that_of_openpyxl_and_xlrd() {
    let truth = json("workbook/truth.json");
    let mut files: BTreeMap<&str, Vec<(String, Vec<u64>)>> = BTreeMap::new();
    for channel in truth.as_array().unwrap() {
        let word = |key: &str| channel[key].as_str().unwrap();
        let bits = channel["bits"].as_array().unwrap().iter();
        let bits = bits.map(|one| u64::from_str_radix(one.as_str().unwrap(), 16).unwrap());
        let entry = files.entry(word("file")).or_default();
        entry.push((word("channel").into(), bits.collect()));
    }
    assert_eq!(files.len(), 4);
    for (file, channels) in files {
        let path = data(&format!("workbook/{file}"));
        let recording = read_path(&path, &ReadOptions::default(), Selection::Every).unwrap();
        assert_eq!(recording.format, "workbook");
        assert_eq!(recording.channels.len(), channels.len(), "{file}");
        for (name, bits) in channels {
            let mut found = recording.channels.iter();
            let found = found.find(|one| one.name.starts_with(&name)).unwrap();
            let own: Vec<u64> = found.values.iter().map(|value| value.to_bits()).collect();
            assert_eq!(own, bits, "{file} {name}");
            assert_eq!(found.values.len(), 120, "{file} {name}");
            assert_eq!(found.rate.hertz(), 10_000.0, "{file} {name}");
            // What counts from a date or a time of day counts from its first stamp.
            let is_stamped = ["xlsxwriter.xlsx", "xlwt-dates.xls"].contains(&file);
            let start_s = if is_stamped { 0.0 } else { -1e-3 };
            assert_eq!(found.start_s, start_s, "{file} {name}");
        }
    }
    let path = data("workbook/openpyxl.xlsx");
    let recording = read_path(&path, &with_channel("door y"), Selection::Lateral).unwrap();
    let facts = &recording.channels[0].stated.test;
    assert_eq!(facts.test.as_deref(), Some("7292"));
    assert_eq!(facts.laboratory.as_deref(), Some("A laboratory"));
    assert_eq!(facts.date.as_deref(), Some("2026-01-15"));
}

fn judged(source: &Source, request: &Request) -> Document {
    let design = Design::reference();
    let (limits, control) = (Limits::default(), Control::default());
    judge(
        source,
        request,
        &design,
        Extras::default(),
        &limits,
        &control,
    )
    .document
}

/// The lateral curves of a crash test, each as a sheet with the rows above its names that say what the
/// header of the test does, as .xlsx and as .xls.
#[test]
fn val_nhtsa_curves_as_workbooks_give_the_verdicts_of_their_own_format() {
    let header = data("recordings/nhtsa_v07292.EV5");
    let lines = std::fs::read_to_string(&header).unwrap();
    for number in ["38", "56", "146", "148", "150"] {
        let recording = read_path(&header, &with_channel(number), Selection::Lateral).unwrap();
        let channel = &recording.channels[0];
        let line = lines
            .lines()
            .find(|line| line.split('|').nth(1) == Some(number));
        let fields: Vec<&str> = line.unwrap().split('|').collect();
        // What the laboratory says of the curve, and whether it is as measured.
        let mut rows = vec![
            vec![text("Comment"), text(fields[19])],
            vec![text("Status"), text(fields[17])],
            vec![text("Time [s]"), text("Acc Y [g]")],
        ];
        let samples = channel.values.iter().enumerate();
        rows.extend(
            samples.map(|(index, value)| {
                vec![Cell::Number(channel.time_s(index)), Cell::Number(*value)]
            }),
        );
        let mut sheet = Records::default();
        sheet.rows(&rows);
        let old = xls(&Records::default(), &sheet);
        for (name, bytes) in [("a.xlsx", of_rows(rows).bytes()), ("a.xls", old)] {
            for opens_when in [CardPolarity::Negative, CardPolarity::Positive] {
                let request = Request {
                    members: 128,
                    channel: Some(number.into()),
                    opens_when: Some(opens_when),
                    ..Request::default()
                };
                let own = judged(&Source::File(header.clone()), &request);
                let other = judged(
                    &Source::bytes(name, bytes.clone()),
                    &Request {
                        channel: None,
                        ..request
                    },
                );
                let signal = |document: &Document| {
                    let recording = &document.recording;
                    (recording.content_sha256.clone(), recording.samples)
                };
                assert_eq!(signal(&own), signal(&other), "{name} {number}");
                assert_eq!(own.nominal, other.nominal, "{name} {number}");
                assert_eq!(own.ensemble, other.ensemble, "{name} {number}");
                // Only what a laboratory says of a curve, and no sheet repeats, may part them.
                let is_said = own.findings.iter().any(|one| {
                    one.code.starts_with("laboratory-") || one.code == "invalid-by-laboratory"
                });
                assert!(
                    is_said || own.verdict == other.verdict,
                    "{name} {number}: {:?} {:?}",
                    own.why,
                    other.why
                );
            }
        }
    }
}

/// A push of 30 g for 20 ms, which opens the lever by far; the record goes on for 80 ms.
fn failing() -> Vec<Vec<Cell>> {
    let value = |k: i32| match (0..200).contains(&k) {
        true => -30.0 * (std::f64::consts::PI * f64::from(k) / 200.0).sin(),
        false => 0.05 * (0.91 * f64::from(k)).sin(),
    };
    let mut rows = vec![vec![text("Time [s]"), text("Acc Y [g]")]];
    rows.extend(
        (-200..800).map(|k| vec![Cell::Number(f64::from(k) / 1e4), Cell::Number(value(k))]),
    );
    rows
}

/// Judges a damaged file, which may be refused, unusable, undecided or fail.
#[track_caller]
fn check_no_pass(what: &str, bytes: Vec<u8>) -> String {
    let request = Request {
        members: 0,
        opens_when: Some(CardPolarity::Negative),
        ..Request::default()
    };
    let document = judged(&Source::bytes("a.bin", bytes), &request);
    let verdict = document.verdict.name();
    assert_ne!(verdict, "pass", "{what}");
    verdict.to_string()
}

#[test]
fn verif_a_damaged_workbook_never_passes_where_the_sound_one_fails() {
    let mut sheet = Records::default();
    sheet.rows(&failing());
    let formats = Workbook {
        formats: vec!["0.000"],
        ..of_rows(failing())
    };
    // What is packed is held by checksums, so that one that is not is looked at as well.
    let files = [
        ("xlsx", formats.bytes()),
        ("xls", xls(&Records::default(), &sheet)),
    ];
    for (kind, sound) in files {
        assert_eq!(check_no_pass("sound", sound.clone()), "fail", "{kind}");
        for length in (0..sound.len()).step_by(64) {
            let cut = sound[..length].to_vec();
            check_no_pass(&format!("{kind} cut after {length} bytes"), cut);
        }
        let mut random = Random::new(7);
        // Each bit of the container's first sector, and 2000 anywhere.
        let first = if kind == "xls" { 0..8 * 512 } else { 0..0 };
        let anywhere: Vec<usize> = (0..2000).map(|_| random.below(8 * sound.len())).collect();
        for bit in first.chain(anywhere) {
            let mut bytes = sound.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            check_no_pass(&format!("{kind}, bit {bit} flipped"), bytes);
        }
    }
}

/// Each bit of the parts of a workbook that say what its cells are, packed anew.
#[test]
fn verif_a_workbook_whose_parts_are_damaged_never_passes() {
    let sound = Workbook {
        formats: vec!["0.000"],
        ..of_rows(failing())
    };
    let parts = sound.parts();
    for (place, (name, content)) in parts.iter().enumerate() {
        // Of the sheet what stands before its samples; the other parts whole.
        let end = match name.ends_with("sheet1.xml") {
            true => memchr::memmem::find(content, b"r=\"2\"").unwrap(),
            false => content.len(),
        };
        for bit in 0..8 * end {
            let mut damaged = parts.clone();
            damaged[place].1[bit / 8] ^= 1 << (bit % 8);
            check_no_pass(&format!("{name}, bit {bit} flipped"), zip_of(&damaged));
        }
    }
}

/// What unpacks to far more than it takes, and what spreads over a whole sheet, is refused within bounds.
#[test]
fn verif_workbooks_that_would_fill_memory_are_refused() {
    let sheet = |before: &str, inner: String, after: &str| {
        let text = format!("<worksheet>{before}<sheetData>{inner}</sheetData>{after}</worksheet>");
        let mut parts = of_rows(failing()).parts();
        parts.retain(|(name, _)| !name.ends_with("sheet1.xml"));
        parts.push(("xl/worksheets/sheet1.xml".into(), text.into_bytes()));
        Source::bytes("a.xlsx", zip_of(&parts))
    };
    let far = "<row r=\"1\"><c r=\"A1\"><v>1</v></c></row><row r=\"1048576\"><c r=\"FZ1048576\"><v>1</v></c></row>";
    let wide = |row: u32| format!("<row r=\"{row}\"><c r=\"EZZ{row}\"><v>1</v></c></row>");
    let cases = [
        (
            "packed",
            sheet("", " ".repeat(64 << 20), ""),
            "unpacked_ratio",
        ),
        ("far", sheet("", far.into(), ""), "expected"),
        (
            "wide",
            sheet("", (1..60_000).map(wide).collect(), ""),
            "limit text_bytes",
        ),
    ];
    for (name, source, says) in cases {
        let limits = Limits::default();
        let options = ReadOptions::default();
        let read = latchgate_recording::read(&source, &options, Selection::Lateral, &limits);
        let error = read.unwrap_err().to_string();
        assert!(error.contains(says), "{name}: {error}");
    }
}

/// The sheet is asked for by option, card and request alike, and stands in the document's question.
#[test]
fn cli_the_sheet_is_asked_for_and_kept() {
    let sheets = ["One", "Two"].map(|name| Sheet {
        name,
        rows: failing(),
        ..Sheet::default()
    });
    let book = Workbook {
        sheets: sheets.into(),
        ..Workbook::default()
    };
    let folder = Folder::new("workbook-sheet");
    let path = folder.file("a.xlsx", book.bytes());
    let path = path.to_str().unwrap();
    let asked = latchgate(&["replay", path, "--no-report"]);
    assert_eq!(asked.code, 4);
    assert!(
        asked
            .err
            .contains("`One`, `Two`; choose one: state --sheet NAME"),
        "{}",
        asked.err
    );
    let options = [
        "--no-report",
        "--members",
        "0",
        "--format",
        "json",
        "--sheet",
        "two",
    ];
    let sign = ["--opens-when", "negative"];
    let document = latchgate(&[&["replay", path][..], &options, &sign].concat()).document();
    assert_eq!(document["verdict"], "fail");
    assert_eq!(document["request"]["sheet"], "two");
}

/// Reads a workbook for the judged channel; what went wrong, or what was found.
fn read_words(bytes: Vec<u8>, options: &ReadOptions) -> Result<Vec<String>, String> {
    let source = Source::bytes("a.bin", bytes);
    let read = latchgate_recording::read(&source, options, Selection::Lateral, &Limits::default());
    let recording = read.map_err(|error| error.to_string())?;
    let channels = recording.channels.iter();
    let findings = channels.flat_map(|channel| &channel.findings);
    let findings = recording.findings.iter().chain(findings);
    Ok(findings
        .map(|one| format!("{} {}", one.code, one.text))
        .collect())
}

/// The workbook is refused with a message that holds `says`.
#[track_caller]
fn check_refused(name: &str, bytes: Vec<u8>, says: &str) {
    let error = read_words(bytes, &ReadOptions::default()).expect_err(name);
    assert!(error.contains(says), "{name}: {error}");
}

/// The workbook is read, with a finding that begins so and holds `says`.
#[track_caller]
fn check_found(name: &str, bytes: Vec<u8>, code: &str, says: &str) {
    let findings = read_words(bytes, &ReadOptions::default()).expect(name);
    let mut found = findings.iter();
    assert!(
        found.any(|one| one.starts_with(code) && one.contains(says)),
        "{name}: {findings:?}"
    );
}

#[track_caller]
fn check_sound(name: &str, bytes: Vec<u8>) {
    if let Err(error) = read_words(bytes, &ReadOptions::default()) {
        panic!("{name}: {error}");
    }
}

/// Of two sheets whose names differ in a blank, the one that is named is read.
#[test]
fn verif_a_sheet_is_named_letter_by_letter_where_others_are_alike() {
    let sheets = ["Data", "Data ", "Other"].map(|name| Sheet {
        name,
        rows: match name {
            "Data " => failing(),
            _ => vec![vec![text("nothing")]],
        },
        ..Sheet::default()
    });
    let book = Workbook {
        sheets: sheets.into(),
        ..Workbook::default()
    };
    let read = |name: &str| {
        let options = ReadOptions {
            sheet: Some(name.into()),
            ..ReadOptions::default()
        };
        read_words(book.bytes(), &options)
    };
    read("Data ").unwrap();
    assert!(read("Data").is_err());
    assert!(!read("other").unwrap_err().contains("letter by letter"));
    let error = read("data").unwrap_err();
    assert!(
        error.contains("`Data`, `Data `; state the setting `sheet` = 'NAME' letter by letter"),
        "{error}"
    );
}

/// Ranges without an end, or from the last to the first, are damage.
#[test]
fn verif_ranges_without_an_end_are_refused() {
    let with = |change: fn(&mut Sheet)| of_rows(failing()).change(change).bytes();
    let says = "a workbook as a spreadsheet writes it";
    check_refused(
        "no last column",
        with(|sheet| sheet.before_rows = "<cols><col min=\"1\" hidden=\"1\"/></cols>"),
        says,
    );
    check_refused(
        "columns turned",
        with(|sheet| sheet.before_rows = "<cols><col min=\"2\" max=\"1\" hidden=\"1\"/></cols>"),
        "columns 2 to 1",
    );
    check_refused(
        "cells turned",
        with(|sheet| sheet.after_rows = "<mergeCells><mergeCell ref=\"B1:A1\"/></mergeCells>"),
        "cells `B1:A1`",
    );
    for (kind, range) in [
        (0x007D, &[1, 0, 0, 0, 0, 9, 0, 0, 1, 0, 0, 0][..]),
        (0x00E5, &[1, 0, 1, 0, 0, 0, 0, 0, 0, 0]),
    ] {
        let mut sheet = Records::default();
        sheet.rows(&failing());
        sheet.put(kind, range);
        check_refused(
            "turned",
            xls(&Records::default(), &sheet),
            "from the last to the first",
        );
    }
}

/// What a person sees in a cell is the number that is judged, in the unit of its column.
#[test]
fn verif_formats_that_show_another_number_or_unit_are_refused() {
    let shown = |column: usize, code: &'static str| {
        let mut rows = failing();
        for row in &mut rows[1..] {
            if let Cell::Number(value) = row[column] {
                row[column] = Cell::Formatted(value, 1);
            }
        }
        Workbook {
            formats: vec![code],
            ..of_rows(rows)
        }
        .bytes()
    };
    for code in [
        "# ?/?",
        "0.00%",
        "0.00;0.00",
        "-0.00;0.00",
        ";;;",
        "\"dropout\"",
        "0\\.0",
    ] {
        for column in [0, 1] {
            check_refused(code, shown(column, code), "its format shows another number");
        }
    }
    for (column, code, words) in [
        (1, "0.00\" mm/s2\"", "mm/s2"),
        (1, "0.00\\ \"m/s2\"", "m/s2"),
        (1, "0.0\"k\"", "k"),
        (1, "0\" invalid\"", "invalid"),
        (0, "0.0000\" ms\"", "ms"),
    ] {
        let says = format!("the number format shows `{words}`");
        check_refused(code, shown(column, code), &says);
    }
    for (column, code) in [
        (1, "0.00\" g\""),
        (1, "0.00;[Red]-0.00"),
        (0, "0.0000\" s\""),
    ] {
        check_sound(code, shown(column, code));
    }
}

/// Formulas of an .xls sheet that was not computed before it was saved.
#[test]
fn verif_formulas_of_a_sheet_that_was_not_computed_are_refused() {
    let with = |marks: &[(bool, u16)]| {
        let mut sheet = Records::default();
        let put = |sheet: &mut Records, before: bool| {
            for (_, kind) in marks.iter().filter(|(at, _)| *at == before) {
                sheet.put(*kind, &[0, 0]);
            }
        };
        put(&mut sheet, true);
        let rows = failing();
        sheet.rows(&rows);
        let row = u16::try_from(rows.len()).unwrap();
        sheet.rows_from(rows.len(), &[vec![Cell::Number(0.08)]]);
        let result = 0.5_f64.to_le_bytes();
        let cell = [&row.to_le_bytes()[..], &[1, 0, 0, 0], &result, &[0; 8]].concat();
        sheet.put(0x0006, &cell);
        put(&mut sheet, false);
        xls(&Records::default(), &sheet)
    };
    check_sound("computed", with(&[]));
    check_refused(
        "not computed",
        with(&[(true, 0x005E)]),
        "formula without a stored value",
    );
    check_refused("said late", with(&[(false, 0x005E)]), "none is computed");
}

/// Results of formulas that are computed only when a person asks for it may be old.
#[test]
fn verif_formulas_that_are_computed_when_asked_are_told() {
    let mut rows = failing();
    rows[500][1] = Cell::Xml("", "<f>C1*2</f><v>0.5</v>".into());
    let with = |calculation, rows| Workbook {
        calculation,
        ..of_rows(rows)
    };
    let told = |calculation, rows: &[Vec<Cell>]| {
        let bytes = with(calculation, rows.to_vec()).bytes();
        let findings = read_words(bytes, &ReadOptions::default()).unwrap();
        findings
            .iter()
            .any(|one| one.starts_with("formulas-manual"))
    };
    assert!(told("<calcPr calcMode=\"manual\"/>", &rows));
    assert!(!told("<calcPr calcMode=\"auto\"/>", &rows));
    assert!(!told("<calcPr calcMode=\"manual\"/>", &failing()));
    let old = |mode: u8| {
        let mut sheet = Records::default();
        sheet.put(0x000D, &[mode, 0]);
        let rows = failing();
        sheet.rows(&rows);
        sheet.rows_from(rows.len(), &[vec![Cell::Number(0.08)]]);
        let row = u16::try_from(rows.len()).unwrap().to_le_bytes();
        let result = 0.5_f64.to_le_bytes();
        let cell = [&row[..], &[1, 0, 0, 0], &result, &[0; 8]].concat();
        sheet.put(0x0006, &cell);
        let bytes = xls(&Records::default(), &sheet);
        let findings = read_words(bytes, &ReadOptions::default()).unwrap();
        findings
            .iter()
            .any(|one| one.starts_with("formulas-manual"))
    };
    assert!(old(0));
    assert!(!old(1));
}

/// Of cells that are merged only the first is shown.
#[test]
fn verif_merged_cells_of_samples_or_times_are_refused() {
    let with = |after: &'static str| {
        of_rows(failing())
            .change(|sheet| sheet.after_rows = after)
            .bytes()
    };
    for (range, says) in [
        (
            "<mergeCells><mergeCell ref=\"B300:B900\"/></mergeCells>",
            ":300, column 2",
        ),
        (
            "<mergeCells><mergeCell ref=\"A300:A301\"/></mergeCells>",
            ":300, column 1",
        ),
        (
            "<mergeCells><mergeCell ref=\"B1:B2\"/></mergeCells>",
            ":2, column 2",
        ),
        (
            "<mergeCells><mergeCell ref=\"B300:C300\"/></mergeCells>",
            "B300 to C300",
        ),
        (
            "<mergeCells><mergeCell ref=\"A300:B300\"/></mergeCells>",
            ":300, column 2",
        ),
    ] {
        check_refused(range, with(range), says);
        check_refused(range, with(range), "shown as one cell");
    }
    let beside = "<mergeCells><mergeCell ref=\"D2:D9\"/></mergeCells>";
    check_sound(beside, with(beside));
    // Below the line that a person calls the last one nothing is read.
    let below = with("<mergeCells><mergeCell ref=\"A990:B990\"/></mergeCells>");
    let options = ReadOptions {
        last_line: Some(989),
        ..ReadOptions::default()
    };
    read_words(below, &options).unwrap();
}

/// A workbook in XML with a further relation of a part, `xl/workbook.xml` or a sheet.
fn with_relation(part: &str, relation: &str) -> Vec<u8> {
    let mut parts = of_rows(failing())
        .change(|sheet| sheet.notes = vec![("B1", "fine")])
        .parts();
    let name = |name: &str| name.ends_with(&format!("{part}.rels"));
    let found = parts.iter_mut().find(|(other, _)| name(other));
    let content = &mut found.unwrap().1;
    let end = content.len() - "</Relationships>".len();
    content.splice(end..end, relation.bytes());
    zip_of(&parts)
}

/// What would be read over and over, for each sheet or each relation.
#[test]
fn verif_parts_that_stand_for_several_are_refused() {
    let relation =
        |kind: &str| format!("<Relationship Id=\"z\" Type=\"x/{kind}\" Target=\"other.xml\"/>");
    check_sound("drawing", with_relation("workbook.xml", &relation("theme")));
    let styles = with_relation("workbook.xml", &relation("styles"));
    check_refused("styles", styles, "several parts of the kind `styles`");
    let notes = with_relation("sheet1.xml", &relation("comments"));
    check_refused("notes", notes, "several parts of the kind `comments`");
    let two = Workbook {
        parts: vec![(
            "xl/workbook.xml",
            "<workbook><sheets><sheet name=\"A\" id=\"r1\"/><sheet name=\"B\" id=\"r1\"/></sheets></workbook>".into(),
        )],
        ..of_rows(failing())
    };
    check_refused("two names", two.bytes(), "the sheet `B` where another is");
    // A second entry in the list of an .xls file, of the same sheet.
    let mut stream = Records::default();
    stream.put(0x0809, &[0, 6, 5, 0]);
    let place = u32::try_from(8 + 2 * 13 + 4).unwrap().to_le_bytes();
    for name in [b'A', b'B'] {
        stream.put(0x0085, &[&place[..], &[0, 0, 1, 0, name]].concat());
    }
    stream.put(0x000A, &[]);
    stream.put(0x0809, &[0, 6, 16, 0]);
    stream.put(0x000A, &[]);
    let two = container("Workbook", &stream.0);
    check_refused("two places", two, "the sheet `B` where another is");
}

/// Fault words of a workbook beside the sheet that is read: in other sheets, in its name, on its pages.
#[test]
fn verif_fault_words_beside_the_sheet_block_the_verdict() {
    let sheet = |name: &'static str, rows: Vec<Vec<Cell>>| Sheet {
        name,
        rows,
        ..Sheet::default()
    };
    let with = |name: &'static str, beside: &'static str, page: &'static str| {
        let info = sheet("Info", vec![vec![], vec![Cell::Number(3.0), text(beside)]]);
        let data = Sheet {
            after_rows: page,
            ..sheet(name, failing())
        };
        Workbook {
            sheets: vec![info, data],
            ..Workbook::default()
        }
        .bytes()
    };
    let check = |name: &'static str, bytes: Vec<u8>, says: Option<&str>| {
        let options = ReadOptions {
            sheet: Some(name.into()),
            ..ReadOptions::default()
        };
        let findings = read_words(bytes, &options).unwrap();
        let found = findings
            .iter()
            .find(|one| one.starts_with("laboratory-remark"));
        match says {
            Some(says) => assert!(found.unwrap().contains(says), "{found:?}"),
            None => assert_eq!(found, None),
        }
    };
    const PAGE: &str = "<headerFooter><oddHeader>&amp;C&amp;\"Arial\"&amp;12sensor failed</oddHeader></headerFooter>";
    check("Data", with("Data", "A door", ""), None);
    let info = with("Data", "Acc Y: sensor failed", "");
    check(
        "Data",
        info,
        Some("row 2 of the sheet `Info` says: \"Acc Y: sensor failed\""),
    );
    let named = with("sensor failed", "A door", "");
    check("sensor failed", named, Some("the name of the sheet says"));
    let beside = Workbook {
        sheets: vec![sheet("INVALID", vec![]), sheet("Data", failing())],
        ..Workbook::default()
    };
    let says = "the name of another sheet says: \"INVALID\"";
    check("Data", beside.bytes(), Some(says));
    let page = with("Data", "A door", PAGE);
    check(
        "Data",
        page,
        Some("a page header or footer of the sheet `Data` says"),
    );
    // The same page header of an .xls file.
    let mut old = Records::default();
    old.rows(&failing());
    let words = b"&Csensor failed";
    let length = u8::try_from(words.len()).unwrap();
    old.put(0x0014, &[&[length, 0, 0], &words[..]].concat());
    check(
        "Data",
        xls(&Records::default(), &old),
        Some("a page header or footer"),
    );
}

/// What XML cannot hold is written as `_x000A_`, which is no part of a name or a unit.
#[test]
fn verif_escaped_characters_are_decoded_once() {
    for (head, name) in [
        ("Acc Y_x0020__x005B_g]", "Acc Y [g]"),
        ("Acc Y_x005F_x0041_ [g]", "Acc Y_x0041_ [g]"),
        ("Acc_x20_ Y_xD800_ [g]", "Acc_x20_ Y_xD800_ [g]"),
    ] {
        let mut rows = failing();
        rows[0][1] = text(head);
        let source = Source::bytes("a.xlsx", of_rows(rows).bytes());
        let (options, limits) = (ReadOptions::default(), Limits::default());
        let read = latchgate_recording::read(&source, &options, Selection::Every, &limits);
        assert_eq!(read.unwrap().channels[0].name, name);
    }
}

/// Rows and columns without height or width are hidden ones.
#[test]
fn verif_rows_and_columns_without_size_are_hidden() {
    let with = |change: fn(&mut Sheet)| of_rows(failing()).change(change).bytes();
    let flat = with(|sheet| sheet.row_attributes = vec![(9, "ht=\"0\"")]);
    check_found("row", flat, "hidden-cells", "hides rows 10.");
    let flat = with(|sheet| sheet.before_rows = "<sheetFormatPr zeroHeight=\"1\"/>");
    check_found("rows", flat, "hidden-cells", "hides rows 1 to 1001.");
    let flat = with(|sheet| sheet.before_rows = "<sheetFormatPr defaultColWidth=\"0\"/>");
    check_refused("columns", flat, "which is hidden");
    let old = |kind: u16, data: &[u8]| {
        let mut sheet = Records::default();
        sheet.put(kind, data);
        sheet.rows(&failing());
        xls(&Records::default(), &sheet)
    };
    let row = [9, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 1, 15, 0];
    check_found("row", old(0x0208, &row), "hidden-cells", "hides rows 10.");
    check_found(
        "rows",
        old(0x0225, &[2, 0, 0, 0]),
        "hidden-cells",
        "hides rows 1 to 1001.",
    );
    check_refused("columns", old(0x0055, &[0, 0]), "which is hidden");
}

/// Rows that each program takes otherwise, and notes that are not read.
#[test]
fn verif_alternate_rows_are_refused_and_threads_are_told() {
    let twice = of_rows(failing()).change(|sheet| sheet.after_rows = "<sheetData/>");
    check_refused("two lists", twice.bytes(), "a second list of rows");
    let sheet = "<worksheet><sheetData><mc:AlternateContent><mc:Choice><row r=\"1\"><c r=\"A1\"><v>1</v></c></row>\
                 </mc:Choice></mc:AlternateContent></sheetData></worksheet>";
    let alternate = Workbook {
        parts: vec![("xl/worksheets/sheet1.xml", sheet.into())],
        ..of_rows(failing())
    };
    check_refused("alternate", alternate.bytes(), "`AlternateContent`");
    let thread = "<Relationship Id=\"t\" Type=\"x/threadedComment\" Target=\"../threads.xml\"/>";
    let threads = with_relation("sheet1.xml", thread);
    check_found("threads", threads, "notes-not-read", "threads of notes");
}
