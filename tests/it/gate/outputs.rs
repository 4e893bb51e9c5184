//! Guards what a gate writes: readable by its readers, within their limits, the same every time.

use super::{STANDS, Yard, strong, without_times};
use crate::support::{finish, program, table};
use latchgate::gate::{self, GateSummary};
use std::fs::{self, File};
use std::path::Path;

/// Files of names that break out of markup where they are not escaped.
const NAMES: [&str; 6] = [
    "a]]><b>.csv",
    "c|d`e.csv",
    "@team #12.csv",
    "bell\u{7}\u{1b}[31m.csv",
    "\"quote\"&'amp'.csv",
    "\u{202e}vsc.csv",
];

#[test]
fn cli_names_do_not_break_out_of_any_output() {
    let yard = Yard::new("names");
    for name in NAMES {
        yard.folder.write(&format!("odd/{name}"), table(strong));
    }
    let gate = "[[recordings]]\nfiles = \"odd/*\"\nopens_when = \"negative\"\nmembers = 0\n[[designs]]\nname = \"<i>@me|x\"\n";
    let done = yard.gate(gate, &["--annotate", "github"]);
    assert_eq!(done.code, 1, "{}{}", done.out, done.err);
    assert!(
        !done.out.contains('\u{1b}') && !done.out.contains('\u{7}'),
        "{:?}",
        done.out
    );
    assert_eq!(
        done.out
            .matches("::error file=gate.toml,line=1,title=")
            .count(),
        6,
        "{}",
        done.out
    );
    check_xml(&yard);
    let markdown = yard.text("summary.md");
    let rows: Vec<&str> = markdown
        .lines()
        .filter(|line| line.starts_with("| fail |"))
        .collect();
    assert_eq!(rows.len(), 6, "{markdown}");
    for row in rows {
        let cells = row.replace("\\|", "").matches('|').count();
        assert_eq!(cells, 5, "{row}");
    }
    let page = yard.text("index.html");
    assert!(
        !page.contains("<b>") && !page.contains("<i>"),
        "a name is markup"
    );
    assert!(page.contains("a]]&gt;&lt;b&gt;.csv"));
}

/// No name of a file or a design is a formula in a spreadsheet, and numbers stay numbers.
#[test]
fn regress_the_table_holds_no_formula() {
    let yard = Yard::new("formulas");
    for name in [
        "=1+2.csv", "+1.csv", "-1.csv", "@A1.csv", "\t=3.csv", "\r=4.csv", "a=5.csv",
    ] {
        yard.folder.write(&format!("odd/{name}"), table(strong));
    }
    let gate = "[[recordings]]\nfiles = [\"*.csv\"]\nopens_when = \"negative\"\nmembers = 0\n[[designs]]\nname = \"-2+3\"\n";
    let done = {
        yard.folder.write("odd/gate.toml", gate);
        let words = [
            "gate",
            "gate.toml",
            "--out",
            "../out",
            "--reports",
            "none",
            "--no-store",
        ];
        finish(
            program()
                .args(words)
                .current_dir(yard.folder.path().join("odd")),
        )
    };
    assert_eq!(done.code, 1, "{}{}", done.out, done.err);
    let text = yard.text("summary.csv");
    let mut csv = csv::Reader::from_reader(text.as_bytes());
    let lines: Vec<_> = csv.records().map(Result::unwrap).collect();
    assert_eq!(lines.len(), 7);
    let mut kept = 0;
    for line in &lines {
        for cell in line {
            let is_formula = cell.starts_with(['=', '+', '-', '@', '\t', '\r', '\n']);
            assert!(!is_formula || cell.parse::<f64>().is_ok(), "{cell:?}");
        }
        assert_eq!(&line[1], "'-2+3");
        kept += usize::from(&line[0] == "a=5.csv");
    }
    assert_eq!(kept, 1, "{text}");
}

/// Every exception stands in every output; a design may be named as a suite of the gate's own.
#[test]
fn cli_every_exception_is_shown_everywhere() {
    let yard = Yard::new("exceptions");
    let mut gate = String::from(
        "[[recordings]]\nfiles = \"doubt.csv\"\nopens_when = \"negative\"\nmembers = 128\n",
    );
    for number in 0..12 {
        let name = if number == 0 {
            "gate".into()
        } else {
            format!("d{number:02}")
        };
        gate += &format!(
            "[[designs]]\nname = \"{name}\"\n[[allow]]\nrecordings = \"*\"\ndesigns = \"{name}\"\nreason = \"waits for {name}\"\nuntil = 2027-01-{:02}\n",
            number + 1
        );
    }
    let done = yard.gate(&gate, &["--date", "2027-01-01"]);
    assert_eq!(done.code, 0, "{}{}", done.out, done.err);
    let outputs =
        ["summary.json", "junit.xml", "summary.md", "index.html"].map(|name| yard.text(name));
    for text in std::iter::once(&done.out).chain(&outputs) {
        for name in ["gate", "d01", "d11"] {
            assert!(
                text.contains(&format!("waits for {name}")),
                "{name}: {text}"
            );
        }
    }
    // One exception expired: a problem of the gate, beside the design of that name.
    let done = yard.gate(&gate, &["--date", "2027-01-02"]);
    assert_eq!(done.code, 4, "{}{}", done.out, done.err);
    check_xml(&yard);
    let suites = yard.text("junit.xml");
    assert_eq!(
        suites
            .matches("<testsuite name=\"gate\" tests=\"1\"")
            .count(),
        2,
        "{suites}"
    );
}

/// The file as a second parser reads it; returns the number of tests in it. Where `LATCHGATE_JUNIT_FILES`
/// names a folder the file is left there for `tests/junit`, which compares it with its schema.
#[track_caller]
fn check_xml(yard: &Yard) -> usize {
    let file = yard.out("junit.xml");
    if let Some(folder) = std::env::var_os("LATCHGATE_JUNIT_FILES") {
        let name = yard.folder.path().file_name().unwrap().to_str().unwrap();
        fs::copy(&file, Path::new(&folder).join(format!("{name}.xml"))).unwrap();
    }
    let text = fs::read_to_string(&file).unwrap();
    let mut reader = quick_xml::Reader::from_str(&text);
    let mut tests = 0;
    loop {
        match reader.read_event().unwrap() {
            quick_xml::events::Event::Start(start) if start.name().as_ref() == "testcase" => {
                tests += 1
            }
            quick_xml::events::Event::Eof => break,
            _ => {}
        }
    }
    assert!(tests > 0);
    tests
}

/// A summary of so many recordings and designs, of which every pair is the one pair of `yard`.
fn many(yard: &Yard, recordings: usize, designs: usize) -> GateSummary {
    let mut summary: GateSummary = serde_json::from_value(yard.summary()).unwrap();
    let (recording, design) = (summary.recordings.remove(0), summary.designs.remove(0));
    let pair = summary.pairs.remove(0);
    let mut pairs = Vec::new();
    summary.recordings.clear();
    for row in 0..recordings {
        let mut recording = recording.clone();
        recording.name = format!("r{row:05}.csv");
        for column in 0..designs {
            let mut pair = pair.clone();
            pair.recording.clone_from(&recording.name);
            pair.design = format!("d{column:02}");
            pairs.push(pair);
        }
        summary.recordings.push(recording);
    }
    summary.pairs = pairs;
    summary.designs = (0..designs)
        .map(|column| {
            let mut design = design.clone();
            design.name = format!("d{column:02}");
            design
        })
        .collect();
    summary
}

/// No page, comment or terminal is flooded; the tables hold every pair.
#[test]
fn cli_outputs_of_very_many_pairs_stay_readable() {
    let yard = Yard::new("many");
    let gate = "[[recordings]]\nfiles = \"fail.csv\"\nopens_when = \"negative\"\nmembers = 0\n[[designs]]\nname = \"paper\"\n";
    assert_eq!(yard.gate(gate, &[]).code, 1);
    let failing = many(&yard, 1667, 3);
    gate::junit::write(&failing, &mut File::create(yard.out("junit.xml")).unwrap()).unwrap();
    assert_eq!(check_xml(&yard), 5001);
    let markdown = gate::markdown::render(&failing);
    assert!(markdown.len() <= 60_000 && markdown.contains("further pairs in summary.csv"));
    let annotations = gate::markdown::annotations(&failing, "gate.toml", |_| Some(2));
    assert_eq!(annotations.matches("::error").count(), 10);
    assert!(gate::text::render(&failing, None).lines().count() < 40);
    let mut table = Vec::new();
    failing.write_csv(&mut table).unwrap();
    assert_eq!(String::from_utf8(table).unwrap().lines().count(), 5002);
    // Past 20 000 cells no browser shows the matrix well.
    let page = gate::page::render(&many(&yard, 1001, 20), &Default::default());
    assert!(page.contains("Too many pairs to show at once"));
    assert!(page.len() < 2_000_000, "{}", page.len());
    let page = gate::page::render(&many(&yard, 250, 20), &Default::default());
    assert!(!page.contains("Too many pairs"));
    assert_eq!(
        page.matches("d19").count(),
        1 + 250,
        "a head and a cell of each row"
    );
}

/// A table for other programs: the numbers of the summary, digit by digit.
#[test]
fn cli_the_table_holds_what_the_summary_holds() {
    let yard = Yard::new("table");
    let gate = "[[recordings]]\nfiles = [\"pass.csv\", \"fail.csv\", \"clipped.csv\"]\nopens_when = \"negative\"\nmembers = 128\n\
                [[designs]]\nname = \"a, \\\"b\\\"\"\n";
    yard.gate(gate, &[]);
    let text = yard.text("summary.csv");
    let mut table = csv::Reader::from_reader(text.as_bytes());
    let heads = table.headers().unwrap().clone();
    let lines: Vec<_> = table.records().map(Result::unwrap).collect();
    let summary = yard.summary();
    let pairs = summary["pairs"].as_array().unwrap();
    assert_eq!(lines.len(), pairs.len());
    let mut numbers = 0;
    for (line, pair) in lines.iter().zip(pairs) {
        let row = &pair["row"];
        for (head, cell) in heads.iter().zip(line) {
            let value = match head {
                "recording" | "design" | "required" | "standing" => &pair[head],
                "reason" => &row["reason"]["code"],
                "share_lower" => &row["share"][0],
                "share_upper" => &row["share"][1],
                _ => &row[head],
            };
            match value.as_f64() {
                Some(number) => {
                    assert_eq!(cell.parse::<f64>().unwrap().to_bits(), number.to_bits());
                    numbers += 1;
                }
                None => assert_eq!(cell, value.as_str().unwrap_or(""), "{head}"),
            }
        }
    }
    assert!(numbers >= 11, "{text}");
}

/// The same bytes on any number of threads, in any folder, locale and time zone, with a store that
/// is empty, half full or full.
#[test]
fn cli_outputs_are_the_same_bytes_everywhere() {
    let yard = Yard::new("same");
    let gate = "[[recordings]]\nfiles = \"*.csv\"\nopens_when = \"negative\"\nmembers = 512\n[[designs]]\nname = \"paper\"\n[[designs]]\nfile = \"designs/stiff.toml\"\n";
    yard.folder.write("gate.toml", gate);
    let elsewhere = yard.folder.path().join("elsewhere");
    fs::create_dir_all(&elsewhere).unwrap();
    let mut first = None;
    for (number, more) in [
        &["--threads", "1", "--no-store"][..],
        &["--threads", "2"],
        &["--threads", "4"],
        &["--threads", "2", "--reports", "failing"],
    ]
    .iter()
    .enumerate()
    {
        let out = elsewhere.join(format!("out-{number}"));
        let done = finish(
            program()
                .current_dir(&elsewhere)
                .env("TZ", "Asia/Tokyo")
                .env("LC_ALL", ["C", "de_DE.UTF-8", "tr_TR.UTF-8"][number % 3])
                .args(["gate", "../gate.toml", "--reports", "none", "--out"])
                .arg(&out)
                .args(if more.contains(&"--reports") {
                    &more[..2]
                } else {
                    more
                }),
        );
        assert_eq!(done.code, 4, "{}{}", done.out, done.err);
        if number == 1 {
            // From here on half of the store is gone.
            let store = yard.folder.path().join(".latchgate");
            let file = fs::read_dir(&store)
                .unwrap()
                .map(|entry| entry.unwrap().path())
                .find(|path| path.extension().is_some_and(|end| end == "jsonl"))
                .unwrap();
            let bytes = fs::read(&file).unwrap();
            fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
        }
        let files = [
            "index.html",
            "junit.xml",
            "summary.csv",
            "summary.json",
            "summary.md",
        ]
        .map(|name| {
            let text = fs::read_to_string(out.join(name)).unwrap();
            let text = match name {
                "junit.xml" => without_times(&text),
                _ => text,
            };
            (name, text)
        });
        match &first {
            None => first = Some(files),
            Some(first) => assert!(*first == files, "{more:?}"),
        }
    }
}

/// Full reports are those of the worst, and the page links to them.
#[test]
fn cli_full_reports_are_written_for_what_is_not_as_required() {
    let yard = Yard::new("full");
    yard.folder.write(
        "gate.toml",
        STANDS.replace("verdict = \"fail\"", "verdict = \"pass\""),
    );
    let done = finish(program().current_dir(yard.folder.path()).args([
        "gate",
        "gate.toml",
        "--out",
        "out",
        "--date",
        "2027-03-31",
    ]));
    assert_eq!(done.code, 1, "{}{}", done.out, done.err);
    let folders: Vec<String> = fs::read_dir(yard.out("reports"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    let [one] = folders.as_slice() else {
        panic!("{folders:?}")
    };
    assert!(
        yard.text("index.html")
            .contains(&format!("href=\"reports/{one}/report.html\""))
    );
    // Its series stand in the page.
    assert!(!yard.out(&format!("reports/{one}/series.csv")).exists());
    let page = fs::read_to_string(yard.out(&format!("reports/{one}/report.html"))).unwrap();
    assert!(page.contains("time_s,acceleration_recorded_m_s2"));
    let verdict = fs::read_to_string(yard.out(&format!("reports/{one}/verdict.json"))).unwrap();
    let verdict: serde_json::Value = serde_json::from_str(&verdict).unwrap();
    assert_eq!(verdict["run"]["date"], "2027-03-31");
    assert!(page.contains("<th>Run on</th><td>2027-03-31"));
    assert!(
        verdict["report_id"]
            .as_str()
            .unwrap()
            .starts_with(one.as_str())
    );
    // The folder is replaced as a whole.
    yard.gate(STANDS, &[]);
    assert!(!yard.out("reports").exists());
}

#[test]
fn cli_one_is_told_of_as_one() {
    let yard = Yard::new("one");
    yard.folder.write("one.csv", table(strong));
    let gate = "[[recordings]]\nfiles = \"one.csv\"\nopens_when = \"negative\"\nmembers = 0\n[[designs]]\nname = \"paper\"\n";
    let done = yard.gate(gate, &["--reports", "none"]);
    assert!(
        done.out
            .contains("1 of 1 pair is not as required: 1 fail (exit 1)"),
        "{}",
        done.out
    );
    let page = yard.text("index.html");
    assert!(page.contains("<dt>recording</dt><dd class=\"value\">1</dd>"));
    let markdown = yard.text("summary.md");
    assert!(markdown.contains("; 1 recording, 1 design; "), "{markdown}");
}

/// The answers of all pairs come first where they are seen at once.
#[test]
fn cli_the_matrix_stands_above_what_is_not_as_required() {
    let yard = Yard::new("matrix");
    let gate = "[[recordings]]\nfiles = [\"pass.csv\", \"fail.csv\", \"clipped.csv\"]\nopens_when = \"negative\"\nmembers = 0\n\
                [[designs]]\nname = \"paper\"\n[[designs]]\nname = \"stiff\"\nset = { \"lever.preload_torque_nm\" = 9 }\n\
                [[require]]\nrecordings = \"fail.csv\"\ndesigns = \"paper\"\nverdict = \"fail\"\n";
    let done = yard.gate(gate, &[]);
    assert_eq!(done.code, 4, "{}{}", done.out, done.err);
    let markdown = yard.text("summary.md");
    let matrix = "| | `paper` | `stiff` |\n| --- | :-: | :-: |\n\
                  | `clipped.csv` | **∅** | **∅** |\n| `fail.csv` | ✗ | ✓ |\n| `pass.csv` | ✓ | ✓ |\n";
    let (before, after) = markdown.split_once(matrix).expect(&markdown);
    assert!(!before.contains("Not as required,") && after.contains("Not as required,"));
    let page = yard.text("index.html");
    let place = |what: &str| page.find(what).expect(what);
    assert!(place(" id=\"matrix\"") < place(" id=\"worst\""));
}

/// Of each test it is told how long it took, of each suite the sum.
#[test]
fn cli_tests_of_a_run_have_times() {
    let yard = Yard::new("times");
    yard.gate(STANDS, &[]);
    assert_eq!(check_xml(&yard), 2);
    let text = yard.text("junit.xml");
    let times: Vec<f64> = text
        .split(" time=\"")
        .skip(1)
        .map(|rest| rest.split_once('"').unwrap().0.parse().unwrap())
        .collect();
    let [suite, tests @ ..] = &times[..] else {
        panic!("{text}")
    };
    assert_eq!(tests.len(), 2, "{text}");
    // Rounded to milliseconds.
    assert!((suite - tests.iter().sum::<f64>()).abs() < 0.002, "{text}");
    assert!(tests.iter().any(|time| *time > 0.0), "{text}");
}
