//! Bad recordings at the process boundary: each is one change to a recording that passes, and
//! each ends with its exit code, one message that names file and place, and no pass.

use crate::mcap::{
    MAGIC, channel, chunk, crc32, data_end, file, footer, header, imu, imu_schema, lz4, message,
    packed, record, schema, statistics,
};
use crate::support::{Folder, half_sine, latchgate, table, weak};

/// A bad recording and what must be said about it.
struct Bad {
    name: String,
    bytes: Vec<u8>,
    card: Option<Vec<u8>>,
    options: &'static [&'static str],
    code: i32,
    /// What the message says, the place included.
    fragments: Vec<String>,
}

#[derive(Default)]
struct Table(Vec<Bad>);

impl Table {
    /// Adds a file that is refused with exit code 4.
    fn add(&mut self, name: &str, bytes: impl Into<Vec<u8>>, fragments: &[&str]) -> &mut Bad {
        self.0.push(Bad {
            name: name.into(),
            bytes: bytes.into(),
            card: None,
            options: &["--opens-when", "negative"],
            code: 4,
            fragments: fragments.iter().map(|text| (*text).to_string()).collect(),
        });
        self.0.last_mut().unwrap()
    }
}

#[track_caller]
fn check(folder: &Folder, bad: &Bad) {
    let path = folder.write(&bad.name, &bad.bytes);
    let card = bad
        .card
        .as_ref()
        .map(|card| folder.write(&format!("{}.toml", bad.name), card));
    for form in ["text", "json"] {
        let own = ["replay", &path, "--no-report", "--format", form];
        // What blocks nothing is told in full where it is asked for.
        let all: &[&str] = match (form, bad.code) {
            ("text", 0..4) => &["-v"],
            _ => &[],
        };
        let done = latchgate(&[&own, bad.options, all].concat());
        let name = &bad.name;
        assert_eq!(done.code, bad.code, "{name}: {} {}", done.err, done.out);
        assert!(
            !done.err.contains("panicked") && !done.out.contains("panicked"),
            "{name}"
        );
        let words = (
            done.out.lines().next().unwrap_or(""),
            done.out.contains("\"verdict\": \"pass\""),
        );
        assert!(
            !words.0.contains("PASS") && !words.1,
            "{name}: {}",
            done.out
        );
        if bad.code == 4 {
            // What to choose from belongs to the message before it.
            let chosen = |line: &&str| {
                line.starts_with("  choose: latchgate replay ")
                    || line.starts_with("  try: latchgate ")
            };
            assert_eq!(
                done.err.lines().filter(|line| !chosen(line)).count(),
                1,
                "{name}: one message, found {}",
                done.err
            );
            let start = format!("latchgate: {name}");
            assert!(done.err.starts_with(&start), "{name}: {}", done.err);
            assert!(done.err.len() < 700, "{name}: a long message: {}", done.err);
        } else if form == "json" {
            assert_eq!(done.err, "", "{name}");
        }
        let said = if bad.code == 4 { &done.err } else { &done.out };
        // Whatever the lines it is wrapped to.
        let said = &said.split_whitespace().collect::<Vec<_>>().join(" ");
        for fragment in &bad.fragments {
            assert!(
                said.contains(fragment),
                "{name}: `{fragment}` not in {said}"
            );
        }
        if form == "json" {
            let document = done.document();
            let verdict = if bad.code == 4 {
                "unusable"
            } else {
                "undecided"
            };
            assert_eq!(document["verdict"], verdict, "{name}");
        }
    }
    if let Some(card) = card {
        std::fs::remove_file(card).unwrap();
    }
}

fn check_all(folder: &str, cases: &Table, least: usize) {
    assert!(cases.0.len() >= least, "{} cases", cases.0.len());
    let folder = Folder::new(folder);
    for bad in &cases.0 {
        check(&folder, bad);
    }
}

#[track_caller]
fn check_passes(name: &str, bytes: &[u8]) {
    let folder = Folder::new(&format!("whole-{name}"));
    let path = folder.write(name, bytes);
    let told = [
        "--opens-when",
        "negative",
        "--transfer",
        "1",
        "--accept",
        "noise",
    ];
    let done = latchgate(&[&["replay", &path, "--no-report"][..], &told].concat());
    assert_eq!(done.code, 0, "{} {}", done.err, done.out);
}

/// The line of the sample at 10 ms: a header, then 500 samples before 0.
const LINE: usize = 602;

/// Replaces the row of the sample at 10 ms of a table that passes.
fn with_row(row: &str) -> String {
    let text = table(weak);
    let mut lines: Vec<&str> = text.lines().collect();
    assert!(lines[LINE - 1].starts_with("0.0100,"));
    lines[LINE - 1] = row;
    lines.join("\n") + "\n"
}

fn with_header(header: &str) -> String {
    table(weak).replacen("time_s,acc_y_g", header, 1)
}

#[test]
fn cli_bad_tables_are_refused_at_their_place() {
    check_passes("whole.csv", table(weak).as_bytes());
    let mut t = Table::default();
    let at = |column: usize| format!(".csv:{LINE}, column {column}: ");

    // What stands in a cell or row.
    t.add(
        "nan.csv",
        with_row("0.0100,nan"),
        &[&at(2), "expected a finite number, found `nan`"],
    );
    t.add(
        "inf.csv",
        with_row("0.0100,-inf"),
        &[&at(2), "found `-inf`"],
    );
    t.add(
        "huge.csv",
        with_row("0.0100,1e999"),
        &[&at(2), "found `1e999`"],
    );
    t.add(
        "word.csv",
        with_row("0.0100,broken"),
        &[&at(2), "expected a number, found `broken`"],
    );
    t.add(
        "empty-cell.csv",
        with_row("0.0100,"),
        &[&at(2), "found an empty cell"],
    );
    t.add(
        "hex.csv",
        with_row("0.0100,0x1F"),
        &[&at(2), "found `0x1F`"],
    );
    t.add(
        "time-word.csv",
        with_row("noon,0.1"),
        &[&at(1), "found `noon`"],
    );
    t.add(
        "time-nan.csv",
        with_row("NaN,0.1"),
        &[&at(1), "found `NaN`"],
    );
    t.add(
        "short.csv",
        with_row("0.0100"),
        &[
            &format!(".csv:{LINE}"),
            "expected 2 cells as in the rows before, found 1",
        ],
    );
    t.add(
        "long.csv",
        with_row("0.0100,0.1,0.2"),
        &[
            &format!(".csv:{LINE}"),
            "expected 2 cells as in the rows before, found 3",
        ],
    );
    t.add(
        "back.csv",
        with_row("0.0001,0.1"),
        &[&format!(".csv:{LINE}"), "time must increase"],
    );
    t.add(
        "twice.csv",
        with_row("0.0099,0.1"),
        &[&format!("on line {LINE}"), "twice"],
    );
    t.add(
        "cut-row.csv",
        table(weak).trim_end_matches(|c| c != ',').to_string(),
        &["is cut"],
    );
    t.add("nul.csv", with_row("0.0100,0.1\0"), &["NUL"]);
    t.add(
        "too-large.csv",
        with_row("0.0100,1e12"),
        &["acceleration at 0.01", "check the unit"],
    );

    // What the table as a whole lacks.
    t.add("empty.csv", "", &["empty.csv: the file is empty"]);
    t.add("blank.csv", "\n\n  \n", &["expected"]);
    t.add("comments.csv", "# a\n# b\n", &["expected"]);
    t.add("header-only.csv", "time_s,acc_y_g\n", &["expected"]);
    t.add("one-sample.csv", "time_s,acc_y_g\n0.0,1.0\n", &["at least"]);
    t.add(
        "no-unit.csv",
        with_header("time_s,acc_y"),
        &["no unit of acceleration", "--unit"],
    );
    t.add(
        "odd-unit.csv",
        with_header("time_s,acc_y (furlong)"),
        &["`furlong`", "--channel"],
    );
    t.add(
        "no-time.csv",
        table(weak)
            .lines()
            .map(|line| line.split(',').nth(1).unwrap().to_string() + "\n")
            .collect::<String>(),
        &["no time column", "--rate-hz"],
    );
    t.add(
        "two.csv",
        table(weak)
            .lines()
            .map(|line| {
                format!(
                    "{line},{}\n",
                    line.split(',')
                        .nth(1)
                        .unwrap()
                        .replace("acc_y_g", "accel_y (g)")
                )
            })
            .collect::<String>(),
        &["several channels", "--channel"],
    );
    t.add("no-lateral.csv", with_header("time_s,temperature"), &["--"]);
    t.add(
        "same-names.csv",
        table(weak)
            .lines()
            .map(|line| format!("{line},{}\n", line.split(',').nth(1).unwrap()))
            .collect::<String>(),
        &["--channel"],
    );
    t.add(
        "page.csv",
        "<!DOCTYPE html>\n<html><body>404</body></html>\n",
        &["expected"],
    );
    t.add(
        "object.csv",
        "{\"time\": [0, 1], \"acc\": [0, 1]}\n",
        &["this is JSON", "as CSV"],
    );
    t.add(
        "no-column.csv",
        table(weak),
        &["no channel `acc_z_g`; the recording holds: time_s, acc_y_g"],
    )
    .options = &["--channel", "acc_z_g"];
    t.add(
        "no-clock.csv",
        table(weak),
        &["unknown time column `clock`"],
    )
    .options = &["--time-column", "clock"];
    t.add(
        "rate.csv",
        table(weak),
        &["found 10000 Hz by the time column"],
    )
    .options = &["--rate-hz", "5000"];

    // Readable, but no evidence.
    let shifted = |t: f64| weak(t - 0.0);
    t.add(
        "gap.csv",
        table(shifted)
            .lines()
            .enumerate()
            .filter(|(index, _)| !(700..900).contains(index))
            .map(|(_, line)| format!("{line}\n"))
            .collect::<String>(),
        &["unusable: ", "gap in time"],
    );
    t.add(
        "clipped.csv",
        table(|t| weak(t).max(-3.0)),
        &["unusable: ", "saturated"],
    );
    t.add("dead.csv", table(|_| 0.0), &["unusable: "]);
    t.add(
        "frozen.csv",
        table(|t| {
            if (0.02..0.2).contains(&t) {
                0.25
            } else {
                weak(t)
            }
        }),
        &["unusable: ", "are equal"],
    );
    t.add(
        "starts.csv",
        table(|t| weak(t) + half_sine(t, -0.06, 0.02, -4.0)),
        &["unusable: ", "The start of the event is missing"],
    );
    t.add(
        "ends.csv",
        table(|t| weak(t) + half_sine(t, 0.24, 0.02, -4.0)),
        &["unusable: ", "The end of the event is missing"],
    );
    t.add(
        "slow.csv",
        table(weak)
            .lines()
            .enumerate()
            .filter(|(index, _)| *index == 0 || index % 100 == 1)
            .map(|(_, line)| format!("{line}\n"))
            .collect::<String>(),
        &["unusable: ", "250 Hz"],
    );
    t.add(
        "undeclared.csv",
        table(|t| half_sine(t, 0.0, 0.03, 12.0)),
        &["The opening direction is not declared"],
    )
    .code = 3;
    t.0.last_mut().unwrap().options = &[];

    // Other formats by their first bytes, whatever the name says.
    for (name, head, format) in [
        ("mdf4.csv", &b"MDF     4.10    "[..], "ASAM MDF4"),
        (
            "unfinished.csv",
            b"UnFinMF 4.10    ",
            "unfinalised ASAM MDF4",
        ),
        ("tdms.csv", b"TDSh\x0e\0\0\0", "NI TDMS, its index"),
        (
            "xls.csv",
            b"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1",
            "legacy Excel",
        ),
        ("xlsx.csv", b"PK\x03\x04\x14\0", "zip"),
        ("hdf5.csv", b"\x89HDF\r\n\x1A\n\0", "HDF5"),
        ("matlab.csv", b"MATLAB 5.0 MAT-file, Platform", "MATLAB"),
        ("packed.csv", b"\x1F\x8B\x08\0", "gzip"),
    ] {
        t.add(name, head, &[format, "which latchgate does not read"]);
    }
    t.add(
        "picture.csv",
        b"\x89PNG\r\n\x1A\n\0\0\0\rIHDR\0\0\0\x01".to_vec(),
        &["picture.csv"],
    );

    // A card that is wrong spoils the recording beside it.
    for (card, fragment) in [
        (
            &b"opens_wen = \"negative\"\n"[..],
            ".toml:1: unknown card key `opens_wen`; did you mean `opens_when`?",
        ),
        (
            b"unit = \"g\"\nrange_g = -5.0\n",
            ".toml:2: range_g [g] must be finite and positive, found -5",
        ),
        (
            b"synthetic = \"yes\"\n",
            ".toml:1: expected `synthetic` to be true or false",
        ),
        (b"unit = \"g\nrate = 3\n", ".toml:1: expected TOML"),
        (b"notes = \"\xff\"\n", ".toml:1: expected a card in UTF-8"),
        (b"rate = 1000.0\n", "expected the stated rate of 1000 Hz"),
        (b"channel = \"acc_x_g\"\n", "no channel `acc_x_g`"),
    ] {
        t.add("carded.csv", table(weak), &[fragment]).card = Some(card.to_vec());
    }
    check_all("bad-tables", &t, 50);
}

const START: u64 = 1_700_000_000_000_000_000;
const COUNT: usize = 1500;

/// One message each 0.1 ms; the pulse begins 50 ms after the first.
fn stamp(index: usize) -> u64 {
    START + 100_000 * index as u64
}

fn sample(index: usize) -> f64 {
    9.806_65 * weak(index as f64 / 10_000.0 - 0.05)
}

fn imu_message(channel: u16, index: usize, stamp: u64, value: f64) -> Vec<u8> {
    let data = imu::imu_message_cdr(stamp, "imu", [0.0, value, 9.8]);
    message(channel, START + 100_000 * index as u64, &data)
}

fn topic() -> Vec<Vec<u8>> {
    vec![imu_schema(1), channel(1, 1, "/imu", "cdr")]
}

/// The records of a log that passes, with `change` made to its messages.
fn messages(change: impl FnOnce(&mut Vec<Vec<u8>>)) -> Vec<Vec<u8>> {
    let mut messages: Vec<Vec<u8>> = (0..COUNT)
        .map(|index| imu_message(1, index, stamp(index), sample(index)))
        .collect();
    change(&mut messages);
    [topic(), messages].concat()
}

/// A log of these records, with statistics that agree.
fn log(records: &[Vec<u8>]) -> Vec<u8> {
    let count = records.iter().filter(|record| record[0] == 5).count() as u64;
    file(records, &[statistics(&[(1, count)])])
}

fn in_chunk(chunk: Vec<u8>) -> Vec<u8> {
    file(&[chunk], &[statistics(&[(1, COUNT as u64)])])
}

#[test]
fn cli_bad_logs_are_refused_with_the_reason() {
    let whole = log(&messages(|_| {}));
    let records = messages(|_| {}).concat();
    let (size, crc) = (records.len() as u64, crc32(&records));
    for (name, bytes) in [
        ("whole.mcap", whole.clone()),
        ("zstd.mcap", in_chunk(packed("zstd", &records))),
        ("lz4.mcap", in_chunk(packed("lz4", &records))),
    ] {
        check_passes(name, &bytes);
    }
    let end = whole.len();
    let mut t = Table::default();

    // Cut, or at odds with itself.
    t.add(
        "cut.mcap",
        &whole[..end / 2],
        &["the file is cut or damaged"],
    );
    t.add("no-footer.mcap", &whole[..end - 37], &["footer"]);
    t.add("no-magic.mcap", &whole[..end - 8], &["end magic"]);
    t.add(
        "zeroed.mcap",
        [&whole[..end - 8], &[0; 8]].concat(),
        &["end magic"],
    );
    t.add(
        "tail.mcap",
        [&whole[..], &whole[end / 2..]].concat(),
        &["older, longer"],
    );
    t.add(
        "byte-more.mcap",
        [&whole[..], b"\n"].concat(),
        &["more bytes"],
    );
    t.add("magic.mcap", MAGIC, &["magic.mcap"]);
    t.add(
        "no-messages.mcap",
        file(&topic(), &[]),
        &["no-messages.mcap"],
    );
    let count = COUNT as u64;
    let lost = messages(|messages| drop(messages.remove(700)));
    t.add(
        "lost.mcap",
        file(&lost, &[statistics(&[(1, count)])]),
        &["1500 messages, as the statistics say", "found 1499"],
    );
    let extra = messages(|messages| messages.push(imu_message(1, COUNT, stamp(COUNT), 0.0)));
    t.add(
        "extra.mcap",
        file(&extra, &[statistics(&[(1, count)])]),
        &["found 1501"],
    );
    t.add(
        "headless.mcap",
        [MAGIC, &records, &data_end(0), &footer(0), MAGIC].concat(),
        &["header as the first"],
    );
    let wrong = [MAGIC, &header(), &records].concat();
    let wrong = [&wrong[..], &data_end(crc32(&wrong) ^ 1), &footer(0), MAGIC].concat();
    t.add("data-crc.mcap", wrong, &["checksum"]);
    let mut unclosed = [MAGIC, &header()].concat();
    unclosed.push(6);
    unclosed.extend([0xFF; 60]);
    t.add("unclosed.mcap", unclosed, &["all ones"]);

    // Chunks.
    t.add(
        "chunk-crc.mcap",
        in_chunk(chunk("", size, crc ^ 1, &records)),
        &["checksum"],
    );
    t.add(
        "chunk-short.mcap",
        in_chunk(chunk("", size + 4, 0, &records)),
        &["as its header says"],
    );
    t.add(
        "chunk-lz4.mcap",
        in_chunk(chunk("lz4", size, crc, &lz4(&records)[..200])),
        &["lz4"],
    );
    t.add(
        "chunk-zstd.mcap",
        in_chunk(chunk("zstd", size, crc, &[7; 100])),
        &["zstd"],
    );
    t.add(
        "chunk-brotli.mcap",
        in_chunk(chunk("brotli", size, crc, &records)),
        &["`brotli`"],
    );
    let mut endless = chunk("", size, crc, &records);
    endless[25..33].fill(0xFF);
    t.add(
        "chunk-endless.mcap",
        in_chunk(endless),
        &["limit mcap_chunk_bytes"],
    );
    let mut long = whole.clone();
    let at = MAGIC.len() + header().len() + 1;
    long[at..at + 8].copy_from_slice(&(1_u64 << 40).to_le_bytes());
    t.add("tebibyte.mcap", long, &["limit mcap_record_bytes"]);

    // Messages.
    let changed =
        |index: usize, record: Vec<u8>| log(&messages(|messages| messages[index] = record));
    t.add(
        "nan.mcap",
        changed(600, imu_message(1, 600, stamp(600), f64::NAN)),
        &["expected a finite number, found `NaN`", "/imu"],
    );
    t.add(
        "infinite.mcap",
        changed(600, imu_message(1, 600, stamp(600), f64::INFINITY)),
        &["expected a finite number, found `inf`"],
    );
    t.add(
        "back.mcap",
        changed(600, imu_message(1, 600, stamp(400), 0.0)),
        &["time must increase"],
    );
    t.add(
        "twice.mcap",
        changed(600, imu_message(1, 600, stamp(599), 0.0)),
        &["time must increase"],
    );
    t.add(
        "stub.mcap",
        changed(600, message(1, stamp(600), &[0, 1, 0, 0, 5])),
        &["/imu"],
    );
    let mut endless = imu_message(1, 600, stamp(600), 0.0);
    let text_length = 9 + 22 + 4 + 8;
    endless[text_length..text_length + 4].fill(0xFF);
    t.add("endless-text.mcap", changed(600, endless), &["/imu"]);
    t.add(
        "stranger.mcap",
        changed(600, message(9, stamp(600), &[])),
        &["channel 9"],
    );
    t.add(
        "record.mcap",
        log(&[messages(|_| {}), vec![record(5, &[1, 0])]].concat()),
        &["message record"],
    );

    // Topics.
    let other = |name: &str, encoding: &str, text: &str, of: &str| {
        let records = [
            vec![schema(1, name, encoding, text), channel(1, 1, "/imu", of)],
            messages(|_| {})[2..].to_vec(),
        ];
        log(&records.concat())
    };
    t.add(
        "protobuf.mcap",
        other("foxglove.Imu", "protobuf", "", "protobuf"),
        &["protobuf"],
    );
    t.add(
        "ros1.mcap",
        other("sensor_msgs/Imu", "ros1msg", "", "ros1"),
        &[
            "/imu:linear_acceleration.y",
            "none in the definition of sensor_msgs/Imu",
        ],
    );
    t.add(
        "text.mcap",
        other("std_msgs/msg/String", "ros2msg", "string data", "cdr"),
        &["no channel carries"],
    );
    t.add(
        "schema.mcap",
        other(imu::IMU_SCHEMA_NAME, "ros2msg", "what is this?", "cdr"),
        &["schema.mcap"],
    );
    t.add(
        "orphan.mcap",
        log(&[channel(1, 8, "/imu", "cdr"), imu_message(1, 0, START, 0.0)]),
        &["schema 8"],
    );
    let second: Vec<Vec<u8>> = (0..COUNT)
        .map(|index| imu_message(2, index, stamp(index), sample(index)))
        .collect();
    let both = [
        messages(|_| {}),
        vec![channel(2, 1, "/imu2", "cdr")],
        second,
    ]
    .concat();
    t.add(
        "two.mcap",
        file(&both, &[statistics(&[(1, count), (2, count)])]),
        &["several channels", "/imu:", "/imu2:", "--channel"],
    );
    t.add(
        "field.mcap",
        whole.clone(),
        &["no channel `/imu:linear_acceleration.w`"],
    )
    .options = &["--channel", "/imu:linear_acceleration.w"];

    // Whole, but no evidence.
    let gap = messages(|messages| drop(messages.drain(700..900)));
    t.add("gap.mcap", log(&gap), &["unusable: ", "gap in time"]);
    let slow: Vec<Vec<u8>> = (0..60)
        .map(|index| {
            imu_message(
                1,
                1000 * index,
                START + 100_000_000 * index as u64,
                (index as f64).sin(),
            )
        })
        .collect();
    t.add(
        "slow.mcap",
        log(&[topic(), slow].concat()),
        &["unusable: ", "250 Hz"],
    );
    let clipped: Vec<Vec<u8>> = (0..COUNT)
        .map(|index| imu_message(1, index, stamp(index), sample(index).max(-30.0)))
        .collect();
    t.add(
        "clipped.mcap",
        log(&[topic(), clipped].concat()),
        &["unusable: ", "saturated"],
    );
    check_all("bad-logs", &t, 35);
}
