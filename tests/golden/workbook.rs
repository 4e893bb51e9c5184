//! Workbooks of Excel: sheets that are tables, and what in a sheet is none.

use super::{Case, FROM, TO, g, good, push, refused, s};
use latchgate_test_support::workbook::{
    Cell, Records, Sheet, Workbook, container, of_rows, text, xls,
};
use latchgate_test_support::zip_of;

const NAMES: [&str; 2] = ["Time [s]", "Acc Y [g]"];

/// Rows of time and sample, below rows of words.
fn table(
    above: &[&[&str]],
    time: impl Fn(i64) -> Cell,
    sample: impl Fn(i64) -> Cell,
) -> Vec<Vec<Cell>> {
    let words = |row: &&[&str]| row.iter().map(|word| text(*word)).collect();
    let mut rows: Vec<Vec<Cell>> = above.iter().map(words).collect();
    rows.extend((FROM..TO).map(|k| vec![time(k), sample(k)]));
    rows
}

fn time(k: i64) -> Cell {
    Cell::Number(k as f64 / 1e4)
}

fn sample(k: i64) -> Cell {
    Cell::Number(push(k))
}

fn plain() -> Vec<Vec<Cell>> {
    table(&[&NAMES], time, sample)
}

/// A workbook of a plain table whose row of sample `k` has another cell.
fn with_cell(k: i64, column: usize, cell: Cell) -> Vec<u8> {
    let mut rows = plain();
    rows[usize::try_from(k - FROM + 1).unwrap()][column] = cell;
    of_rows(rows).bytes()
}

fn pushes() -> Vec<f64> {
    (FROM..TO).map(push).collect()
}

fn read(name: &str, bytes: Vec<u8>) -> Case {
    good(name, bytes)
        .channel("Acc Y [g]")
        .unit("g", |_| "0".into())
        .values(pushes())
}

/// The same samples from time 0 on, since the clock counts from its first stamp.
fn from_first(name: &str, bytes: Vec<u8>) -> Case {
    read(name, bytes)
        .clock(10_000.0, 0.0)
        .finds(&["warning no-pre-event-data"])
}

fn tables() -> Vec<Case> {
    let mut below: Vec<Vec<Cell>> = vec![
        vec![text("Test no"), Cell::Number(7292.0)],
        vec![text("Laboratory"), text("A laboratory")],
        vec![],
    ];
    below.extend(table(&[&["Time", "Acc Y"], &["s", "g"]], time, sample));
    let mut aside = plain();
    for row in &mut aside {
        row.insert(0, Cell::None);
    }
    let comma = |k: i64| text(s(k).replace('.', ","));
    let three = |k: i64| (push(k) * 8.0).round() / 8.0;
    let shared = Workbook {
        parts: vec![(
            "xl/sharedStrings.xml",
            "<sst><si><t>Time [s]</t></si><si><r><t>Acc </t></r><r><t>Y</t></r>\
             <r><t> [g]</t></r><rPh><t>X</t></rPh></si></sst>"
                .into(),
        )],
        ..of_rows(plain()).change(|sheet| {
            let of = |number: u8| Cell::Xml("t=\"s\"", format!("<v>{number}</v>"));
            sheet.rows[0] = vec![of(0), of(1)];
        })
    };
    let mut shared_parts = shared.parts();
    let relations = shared_parts
        .iter_mut()
        .find(|(name, _)| name.ends_with("workbook.xml.rels"));
    let relations = &mut relations.unwrap().1;
    let end = relations.len() - "</Relationships>".len();
    relations.splice(
        end..end,
        *b"<Relationship Id=\"t\" Type=\"x/sharedStrings\" Target=\"sharedStrings.xml\"/>",
    );
    vec![
        read("plain.xlsx", of_rows(plain()).bytes()),
        // The content counts, not the name.
        read("plain.csv", of_rows(plain()).bytes()),
        read("shared-texts.xlsx", zip_of(&shared_parts)),
        read("preamble.xlsx", of_rows(below).bytes())
            .channel("Acc Y")
            .finds(&["info preamble"]),
        read("second-column.xlsx", of_rows(aside).bytes()),
        read(
            "decimal-commas-as-text.xlsx",
            of_rows(table(&[&NAMES], comma, |k| text(g(k).replace('.', ",")))).bytes(),
        )
        .values((FROM..TO).map(|k| g(k).parse().unwrap()).collect())
        .finds(&["info decimal-comma"]),
        // Three decimals of a number are no thousands, whatever whole ones stand beside them.
        read(
            "three-decimals.xlsx",
            of_rows(table(&[&NAMES], time, |k| Cell::Number(three(k)))).bytes(),
        )
        .values((FROM..TO).map(three).collect()),
        refused(
            "thousands-as-text.xlsx",
            of_rows(table(&[&NAMES], time, |k| match k % 2 {
                0 => Cell::Number(push(k).round()),
                _ => text(format!("{},125", push(k).round().abs() + 1.0)),
            }))
            .bytes(),
            &["the same decimal mark in all numbers"],
        ),
        refused(
            "number-and-comma-text.xlsx",
            with_cell(50, 1, text("1,5")),
            &[":252, column 2", "`1,5`"],
        ),
        refused(
            "lines-of-csv.xlsx",
            of_rows(
                (FROM..TO)
                    .map(|k| vec![text(format!("{};{}", s(k), g(k)))])
                    .collect(),
            )
            .bytes(),
            &["expected"],
        ),
    ]
}

fn clocks() -> Vec<Case> {
    let clocked = |code: &'static str, first_days: f64| {
        let day_s = 86_400.0;
        let time = move |k: i64| Cell::Formatted(first_days + (k - FROM) as f64 * 1e-4 / day_s, 1);
        Workbook {
            formats: vec![code],
            ..of_rows(table(&[&["Time", "Acc Y [g]"]], time, sample))
        }
    };
    let of_1904 = Workbook {
        properties: "<workbookPr date1904=\"1\"/>",
        ..clocked("yyyy-mm-dd hh:mm:ss.000", 44_575.5)
    };
    let days = |k: i64| Cell::Number((k - FROM) as f64 * 1e-4 / 86_400.0);
    let two: Vec<Vec<Cell>> = plain()
        .into_iter()
        .map(|row| [&row[..], &[Cell::None], &row[..]].concat())
        .collect();
    vec![
        from_first("times-of-day.xlsx", clocked("hh:mm:ss.000", 0.5).bytes())
            .finds(&["info time-absolute"]),
        from_first(
            "lengths-of-time.xlsx",
            clocked("[h]:mm:ss.000", 0.0).bytes(),
        ),
        from_first(
            "dates.xlsx",
            clocked("dd/mm/yyyy hh:mm:ss.000", 46_037.5).bytes(),
        )
        .finds(&["info time-absolute"]),
        from_first("dates-1904.xlsx", of_1904.bytes()).finds(&["info time-absolute"]),
        from_first(
            "days.xlsx",
            of_rows(table(&[&["Time [day]", "Acc Y [g]"]], days, sample)).bytes(),
        ),
        refused(
            "dates-of-days.xlsx",
            clocked("yyyy-mm-dd", 46_037.0).bytes(),
            &["column 1"],
        ),
        refused(
            "two-tables.xlsx",
            of_rows(two).bytes(),
            &["one time column"],
        ),
        refused(
            "no-time.xlsx",
            of_rows(
                plain()
                    .into_iter()
                    .map(|mut row| vec![row.remove(1)])
                    .collect(),
            )
            .bytes(),
            &["no time column and no sample rate"],
        ),
        read("missing-row.xlsx", {
            let mut rows = plain();
            rows.remove(500);
            of_rows(rows).bytes()
        })
        .samples(800)
        .unusable(&["blocking gap"], &["A gap in time"]),
    ]
}

fn cells() -> Vec<Case> {
    let of = |attributes, inner: &str| Cell::Xml(attributes, inner.into());
    let in_sample = |name: &str, cell, says: &[&str]| refused(name, with_cell(50, 1, cell), says);
    let wanting = Workbook {
        calculation: "<calcPr fullCalcOnLoad=\"1\"/>",
        ..of_rows(table(&[&NAMES], time, |_| of("", "<f>C1</f><v>0</v>")))
    };
    let cut = Workbook {
        calculation: "<calcPr calcCompleted=\"0\"/>",
        ..wanting.clone()
    };
    let scaled = Workbook {
        formats: vec!["0.0,"],
        ..of_rows(table(&[&NAMES], time, |k| {
            Cell::Formatted(push(k) * 1000.0, 1)
        }))
    };
    let dated = Workbook {
        formats: vec!["yyyy-mm-dd"],
        ..of_rows(table(&[&NAMES], time, |k| Cell::Formatted(push(k), 1)))
    };
    vec![
        read(
            "formula.xlsx",
            of_rows(table(&[&NAMES], time, |k| {
                Cell::Xml("", format!("<f>C1*2</f><v>{:?}</v>", push(k)))
            }))
            .bytes(),
        ),
        in_sample(
            "formula-without-a-value.xlsx",
            of("", "<f>C1*2</f>"),
            &["column 2", "formula without a stored value"],
        ),
        in_sample(
            "formula-with-an-empty-value.xlsx",
            of("", "<f>C1*2</f><v></v>"),
            &["formula without a stored value"],
        ),
        refused(
            "formulas-to-compute.xlsx",
            wanting.bytes(),
            &["formula without a stored value"],
        ),
        refused(
            "formulas-cut-short.xlsx",
            cut.bytes(),
            &["formula without a stored value"],
        ),
        in_sample(
            "not-available.xlsx",
            of("t=\"e\"", "<v>#N/A</v>"),
            &["`error #N/A`"],
        ),
        refused(
            "not-available-time.xlsx",
            with_cell(50, 0, of("t=\"e\"", "<v>#N/A</v>")),
            &["`error #N/A`"],
        ),
        in_sample("true.xlsx", of("t=\"b\"", "<v>1</v>"), &["`TRUE`"]),
        in_sample("empty.xlsx", Cell::None, &["an empty cell"]),
        in_sample("infinite.xlsx", of("", "<v>1e999</v>"), &["inf"]),
        in_sample(
            "no-number.xlsx",
            of("", "<v>12x</v>"),
            &["a cell of the kind `n`"],
        ),
        in_sample(
            "two-values.xlsx",
            of("", "<v>1</v><v>2</v>"),
            &["two values"],
        ),
        in_sample(
            "no-shared-text.xlsx",
            of("t=\"s\"", "<v>7</v>"),
            &["a cell of the kind `s`"],
        ),
        refused(
            "thousandths.xlsx",
            scaled.bytes(),
            &["its format shows another number"],
        ),
        refused("dates-of-samples.xlsx", dated.bytes(), &["column 2"]),
    ]
}

fn sheets() -> Vec<Case> {
    let sheet = |name: &'static str, rows| Sheet {
        name,
        rows,
        ..Sheet::default()
    };
    let book = |sheets: &[Sheet]| Workbook {
        sheets: sheets.to_vec(),
        ..Workbook::default()
    };
    let info = || sheet("Info", vec![vec![text("A test")]]);
    let two = book(&[info(), sheet("Data & more", plain())]).bytes();
    let hidden = Sheet {
        state: "state=\"hidden\"",
        ..sheet("Raw", plain())
    };
    let marked = |change: fn(&mut Sheet)| of_rows(plain()).change(change).bytes();
    let third = |name: &str| -> Vec<Vec<Cell>> {
        let name = name.to_string();
        let own = plain().into_iter().enumerate();
        own.map(|(row, mut cells)| {
            cells.push(match row {
                0 => text(name.clone()),
                _ => Cell::Number(0.01),
            });
            cells
        })
        .collect()
    };
    let merged = of_rows(third("Corrected"))
        .change(|sheet| {
            sheet.after_rows = "<mergeCells><mergeCell ref=\"B1:C1\"/></mergeCells>";
        })
        .bytes();
    let mut titled = vec![vec![text("A test of a door")]];
    titled.extend(plain());
    let titled = of_rows(titled).change(|sheet| {
        sheet.after_rows = "<mergeCells><mergeCell ref=\"A1:B1\"/></mergeCells>";
    });
    let hide_samples: fn(&mut Sheet) = |sheet| {
        sheet.before_rows = "<cols><col min=\"2\" max=\"2\" hidden=\"1\"/></cols>";
    };
    vec![
        refused(
            "two-sheets.xlsx",
            two.clone(),
            &["`Info`, `Data & more`", "--sheet NAME"],
        ),
        read("two-sheets-named.xlsx", two.clone()).options(&["--sheet", "data & more"]),
        read("two-sheets-by-card.xlsx", two.clone())
            .beside("two-sheets-by-card.xlsx.toml", "sheet = \"Data & more\"\n"),
        refused(
            "two-sheets-misnamed.xlsx",
            two,
            &["unknown sheet `Dato & more`", "did you mean `Data & more`?"],
        )
        .options(&["--sheet", "Dato & more"]),
        read(
            "empty-sheets.xlsx",
            book(&[
                sheet("A", vec![]),
                sheet("B", plain()),
                sheet("C", vec![vec![text(" ")]]),
            ])
            .bytes(),
        ),
        refused(
            "no-cell.xlsx",
            book(&[sheet("A", vec![])]).bytes(),
            &["no sheet holds a cell", "`Acc Y [g]` above the columns"],
        ),
        read(
            "hidden-sheet.xlsx",
            book(std::slice::from_ref(&hidden)).bytes(),
        )
        .finds(&["warning hidden-cells"]),
        refused(
            "hidden-beside.xlsx",
            book(&[info(), hidden]).bytes(),
            &["`Raw` (hidden)"],
        ),
        refused(
            "hidden-samples.xlsx",
            marked(hide_samples),
            &["column 2", "which is hidden", "--channel 2"],
        ),
        read("hidden-samples-named.xlsx", marked(hide_samples))
            .options(&["--channel", "2"])
            .finds(&["warning hidden-cells"]),
        read(
            "hidden-time.xlsx",
            marked(|sheet| {
                sheet.before_rows = "<cols><col min=\"1\" max=\"1\" width=\"0\"/></cols>";
            }),
        )
        .finds(&["warning hidden-cells"]),
        read(
            "hidden-rows.xlsx",
            marked(|sheet| {
                sheet.row_attributes = vec![(9, "hidden=\"1\""), (10, "hidden=\"true\"")]
            }),
        )
        .finds(&["warning hidden-cells"]),
        refused(
            "merged-head.xlsx",
            merged.clone(),
            &["merged over B to C", "--channel 2"],
        ),
        read("merged-head-named.xlsx", merged)
            .options(&["--channel", "2"])
            .finds(&["warning merged-head"]),
        read("merged-title.xlsx", titled.bytes()),
        read(
            "note.xlsx",
            marked(|sheet| sheet.notes = vec![("B1", "sensor failure")]),
        )
        .unusable(&["blocking laboratory-remark"], &["sensor failure"]),
        read("word-beside.xlsx", {
            let mut rows = plain();
            rows[0].extend([Cell::None, text("sensor failure")]);
            of_rows(rows).bytes()
        })
        .unusable(&["blocking laboratory-remark"], &["sensor failure"]),
        refused(
            "sheet-of-a-text.csv",
            "time_s,acc_y_g\n0,1\n0.0001,2\n",
            &["a workbook, as --sheet needs"],
        )
        .options(&["--sheet", "Data"]),
        read("line-of-the-names.xlsx", of_rows(plain()).bytes()).options(&["--header-line", "1"]),
    ]
}

fn files() -> Vec<Case> {
    let file = |name: &str| zip_of(&[(name.to_string(), b"content".to_vec())]);
    const SHEET: &str = "xl/worksheets/sheet1.xml";
    let of_sheet = |name: &str, rows: &str, says: &str| {
        let book = Workbook {
            parts: vec![(SHEET, format!("<worksheet><sheetData>{rows}"))],
            ..of_rows(plain())
        };
        refused(name, book.bytes(), &[says])
    };
    let closed = |name: &str, rows: &str, says: &str| {
        of_sheet(name, &format!("{rows}</sheetData></worksheet>"), says)
    };
    let cell =
        |row: u32, name: &str| format!("<row r=\"{row}\"><c r=\"{name}\"><v>1</v></c></row>");
    let turned = cell(2, "A2") + &cell(1, "A1");
    let entity = "<row r=\"1\"><c r=\"A1\" t=\"str\"><v>&own;</v></c></row>";
    let spoilt = {
        let mut parts = of_rows(plain()).parts();
        let sheet = parts.iter_mut().find(|(name, _)| name == SHEET);
        sheet.unwrap().1.push(0xFF);
        zip_of(&parts)
    };
    let without = {
        let mut parts = of_rows(plain()).parts();
        parts.retain(|(name, _)| name != SHEET);
        zip_of(&parts)
    };
    let written = "a workbook as a spreadsheet writes it";
    let office = "a file of Office without a workbook";
    vec![
        refused(
            "binary.xlsb",
            file("xl/workbook.bin"),
            &["Excel, binary (.xlsb)"],
        ),
        refused("open.ods", file("content.xml"), &["OpenDocument (.ods)"]),
        refused("words.docx", file("[Content_Types].xml"), &[office]),
        refused(
            "no-xml.xlsx",
            file("xl/workbook.xml"),
            &[written, "save it as .xlsx anew"],
        ),
        closed("far-column.xlsx", &cell(1, "XFD1"), "limit columns"),
        closed(
            "far-row.xlsx",
            "<row r=\"9999999\"/>",
            "row or column 9999999",
        ),
        closed("rows-upside-down.xlsx", &turned, "A1 after a later cell"),
        closed("wrong-row.xlsx", &cell(2, "A3"), "`A3` in row 2"),
        of_sheet("open-tag.xlsx", "<row r=\"1\">", "within a tag"),
        closed("entity.xlsx", entity, "an entity of its own"),
        refused("no-utf-8.xlsx", spoilt, &["no UTF-8"]),
        refused(
            "no-sheet.xlsx",
            without,
            &["no part `xl/worksheets/sheet1.xml`"],
        ),
    ]
}

/// Workbooks of Excel 97 to 2003.
fn old() -> Vec<Case> {
    let book = |change: &dyn Fn(&mut Records, &mut Records)| {
        let (mut globals, mut sheet) = (Records::default(), Records::default());
        change(&mut globals, &mut sheet);
        xls(&globals, &sheet)
    };
    let rows = |sheet: &mut Records| sheet.rows(&plain());
    let format = |globals: &mut Records, code: &str| {
        let count = u16::try_from(code.len()).unwrap().to_le_bytes();
        globals.put(
            0x041E,
            &[&[164, 0], &count[..], &[0], code.as_bytes()].concat(),
        );
        globals.put(0x00E0, &[0; 20]);
        globals.put(0x00E0, &[&[0, 0, 164, 0][..], &[0; 16]].concat());
    };
    let with_formula = |result: [u8; 8], flags: u8| {
        book(&|_, sheet| {
            sheet.rows(&plain()[..=100]);
            let row = 101_u16.to_le_bytes();
            put_time_of(sheet, 101);
            let data = [
                &row[..],
                &[1, 0, 0, 0],
                &result,
                &[flags, 0, 0, 0, 0, 0, 0, 0],
            ]
            .concat();
            sheet.put(0x0006, &data);
        })
    };
    let clock = book(&|globals, sheet| {
        format(globals, "hh:mm:ss.000");
        let time = |k: i64| Cell::Formatted((k - FROM) as f64 * 1e-4 / 86_400.0, 1);
        sheet.rows(&table(&[&["Time", "Acc Y [g]"]], time, sample));
    });
    let whole = |k: i64| push(k).round();
    let packed = book(&|_, sheet| {
        sheet.rows(&plain()[..1]);
        for k in FROM..TO {
            let row = u16::try_from(k - FROM + 1).unwrap().to_le_bytes();
            // A hundredth of a whole number, and a whole number.
            let rk = |number: i32, of_hundred: u32| {
                ((number << 2).cast_unsigned() | 2 | of_hundred).to_le_bytes()
            };
            let time = rk(i32::try_from(k).unwrap() * 10, 1);
            let own = rk(whole(k) as i32, 0);
            sheet.put(
                0x00BD,
                &[&row[..], &[0, 0, 0, 0], &time, &[0, 0], &own, &[1, 0]].concat(),
            );
        }
    });
    vec![
        read("plain.xls", book(&|_, sheet| rows(sheet))),
        from_first("times.xls", clock),
        read("packed.xls", packed)
            .values((FROM..TO).map(whole).collect())
            .options(&["--time-unit", "ms"])
            .finds(&["warning time-unit-overridden"]),
        read(
            "hidden-rows.xls",
            book(&|_, sheet| {
                rows(sheet);
                sheet.put(0x0208, &[&[9, 0][..], &[0; 10], &[0x20, 0, 0, 0]].concat());
            }),
        )
        .finds(&["warning hidden-cells"]),
        refused(
            "hidden-samples.xls",
            book(&|_, sheet| {
                sheet.put(0x007D, &[1, 0, 1, 0, 0, 9, 0, 0, 1, 0, 0, 0]);
                rows(sheet);
            }),
            &["which is hidden"],
        ),
        refused(
            "merged-head.xls",
            book(&|_, sheet| {
                rows(sheet);
                sheet.put(0x00E5, &[1, 0, 0, 0, 0, 0, 0, 0, 1, 0]);
            }),
            &["merged over A to B"],
        ),
        read(
            "notes.xls",
            book(&|_, sheet| {
                rows(sheet);
                sheet.put(0x001C, &[0; 12]);
            }),
        )
        .finds(&["warning notes-not-read"]),
        refused(
            "formula.xls",
            with_formula([3, 0, 0, 0, 0, 0, 0xFF, 0xFF], 0),
            &["formula without a stored value"],
        ),
        refused(
            "formula-to-compute.xls",
            with_formula([0; 8], 2),
            &["formula without a stored value"],
        ),
        refused(
            "formula-fault.xls",
            with_formula([2, 0, 0x2A, 0, 0, 0, 0xFF, 0xFF], 0),
            &["`error #N/A`"],
        ),
        refused(
            "thousandths.xls",
            book(&|globals, sheet| {
                format(globals, "0.0,");
                sheet.rows(&table(&[&NAMES], time, |k| {
                    Cell::Formatted(push(k) * 1000.0, 1)
                }));
            }),
            &["its format shows another number"],
        ),
        refused(
            "password.xls",
            book(&|globals, sheet| {
                globals.put(0x002F, &[1, 0]);
                rows(sheet);
            }),
            &["a workbook under a password"],
        ),
        refused(
            "password.xlsx",
            container("EncryptedPackage", &[0; 5000]),
            &["a workbook under a password"],
        ),
        refused(
            "excel-95.xls",
            container("Book", &[0; 5000]),
            &["a workbook of Excel 5.0 or 95"],
        ),
        refused(
            "words.doc",
            container("WordDocument", &[0; 5000]),
            &["an OLE2 file that holds no workbook"],
        ),
        refused(
            "no-end.xls",
            {
                let mut stream = Records::default();
                stream.put(0x0809, &[0, 6, 5, 0]);
                container("Workbook", &stream.0)
            },
            &["the end before the last record"],
        ),
    ]
}

/// Puts the time of a row alone.
fn put_time_of(sheet: &mut Records, row: usize) {
    let mut rows = vec![Vec::new(); row];
    rows.push(vec![plain()[row][0].clone()]);
    sheet.rows(&rows);
}

pub(super) fn cases() -> Vec<Case> {
    let kinds = [tables(), clocks(), cells(), sheets(), files(), old()];
    kinds.into_iter().flatten().collect()
}
