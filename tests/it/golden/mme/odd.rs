//! ISO-MME tests that say less, or other, than they seem to: lines before the first sample, several
//! test objects, statements at odds, archives of other programs; and other formats by name.

use super::super::{Case, FROM, TO, g, good, refused, s};
use super::{CODE, File, files, folder, lateral, one, refused_folder};
use crate::support::{tar_of, zip_of};
use std::fmt::Write as _;

pub(super) fn cases() -> Vec<Case> {
    [
        beginnings(),
        objects(),
        statements(),
        packings(),
        other_formats(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// A test whose own header says `mme` besides.
fn folder_saying(name: &str, mme: &str, channels: &[File]) -> Case {
    let mut case = folder(name, channels);
    case.files[0].1.extend_from_slice(mme.as_bytes());
    case
}

/// A test that is refused, with what its own header says besides.
fn refused_saying(name: &str, mme: &str, channels: &[File], says: &[&str]) -> Case {
    let mut case = refused_folder(name, channels, says);
    case.files[0].1.extend_from_slice(mme.as_bytes());
    case
}

fn coded(code: &str) -> File {
    File::new().with("Channel code", code)
}

/// One channel file that is refused.
fn refused_one(name: &str, file: &File, says: &[&str]) -> Case {
    refused("t7.001", file.text(), says).named(name)
}

/// What stands before the first sample is no header, unless it is text that goes on.
fn beginnings() -> Vec<Case> {
    let mut cases = Vec::new();
    for word in [
        "NaN",
        "OVERRANGE",
        "-",
        "***",
        "#N/A",
        "inf",
        "1e400",
        "1,234.5",
        "NoValue",
        "1.2.3",
        "0.1234 *",
        "over range",
    ] {
        // The count comes last, a comment comes last, or nothing is counted.
        let comment = File::new().with("Comments", "the sensor was new");
        for (how, file) in [
            ("the count", File::new()),
            ("a comment", comment),
            ("the start", File::new().without("Number of samples")),
        ] {
            let mut file = file;
            for row in 0..3 {
                file = file.row(row, word);
            }
            let line = file.lines.len() + 1;
            cases.push(refused_one(
                &format!("{word} after {how}"),
                &file,
                &[&format!("t7.001:{line}")],
            ));
        }
    }
    let mut long = File::new();
    long.lines
        .push(("Comments", "a sensor that was glued to the".into()));
    let mut text = long.text();
    let at = text.find("glued to the\n").unwrap() + "glued to the\n".len();
    text.insert_str(
        at,
        "door by its inner panel and held\ntight by two screws\n",
    );
    // A short piece was not cut, so that a word behind it is none of the comment.
    let mut short = File::new();
    short.lines.push(("Comments", "as planned".into()));
    let short = short.text().replace("as planned\n", "as planned\nheld\n");
    let mut unit = File::new().text();
    unit = unit.replace("m/(s*s)\n", "m/(s*s)\nand so on\n");
    let clock = File::new()
        .with("Comments", "ok")
        .text()
        .replace(":ok\n", ":ok\n12:30\n");
    cases.extend([
        lateral(good("t7.001", text), "a comment that goes on").finds(&["info laboratory-remark"]),
        refused("t7.001", short, &["t7.001:15", "held"]).named("a word after a short comment"),
        refused("t7.001", unit, &["one `Unit`", "and so on"]).named("a unit that goes on"),
        refused("t7.001", clock, &["12:30"]).named("a time of day among the samples"),
    ]);
    for count in ["8OO", "800 samples", "-800", "799.5"] {
        let mut file = File::new().with("Number of samples", count);
        file.rows.truncate(600);
        cases.push(
            one(&format!("{count} as the count"), &file)
                .samples(600)
                .unusable(&["blocking statement-unread"], &[count]),
        );
    }
    let mut late = File::new();
    for number in 0..1700 {
        late.lines.push((
            "Laboratory word",
            format!("{number:04} of many that say little"),
        ));
    }
    late.lines.push(("Data status", "channel failed".into()));
    cases.push(refused_one(
        "a header that ends late",
        &late,
        &["header_bytes", "65536", "byte 65536"],
    ));
    cases
}

/// What belongs to which of several test objects.
fn objects() -> Vec<Case> {
    let left = "Impact side test object 1   :left\n";
    let right = "Impact side test object 1   :right\n";
    vec![
        refused_saying(
            "the struck side of one of two vehicles",
            left,
            &[coded("21DOORLE0000ACYP"), File::new()],
            &["several channels", "21DOORLE0000ACYP", CODE],
        ),
        folder_saying(
            "the other side of one of two vehicles",
            left,
            &[coded("13DOORRI0000ACYP"), coded("21DOORLE0000ACYP")],
        )
        .options(&["--channel", "13DOORRI0000ACYP"])
        .channel("13DOORRI0000ACYP")
        .finds(&["warning side-not-struck"]),
        folder_saying(
            "the only one lies on the other side",
            "Impact side test object 1 :RI\n",
            &[File::new()],
        )
        .finds(&["warning side-not-struck"]),
        refused_folder(
            "near a latch of another vehicle",
            &[coded("10VEHC000000ACYP"), coded("21BPILLE0000ACYP")],
            &["several channels", "10VEHC000000ACYP", "21BPILLE0000ACYP"],
        ),
        refused_saying(
            "two vehicles that were struck",
            "Impact side test object 1 :left\nImpact side test object 2 :left\n",
            &[File::new(), coded("21DOORLE0000ACYP")],
            &["several channels", CODE, "21DOORLE0000ACYP"],
        ),
        folder_saying(
            "the struck side in words, twice",
            &format!("{right}Impact side test object 1 :Right side\n"),
            &[File::new()],
        )
        .finds(&["warning side-not-struck"]),
        folder_saying(
            "two sides of one object",
            &format!("{right}{left}"),
            &[File::new()],
        )
        .unusable(&["blocking header-contradicted"], &["IMPACT SIDE"]),
    ]
}

/// Names that are no codes, clocks that are not understood, classes at odds, notes by other keys.
fn statements() -> Vec<Case> {
    let said = |key: &'static str, text: &str| {
        one(key, &File::new().with(key, text)).unusable(&["blocking laboratory-remark"], &[text])
    };
    let mut times = coded("11TIRS000000TI00")
        .with("Unit", "s")
        .without("Pre-filter type");
    times.rows = (FROM..TO)
        .map(|k| format!("{:.4}", 2.0 * k as f64 / 1e4))
        .collect();
    let refers = |kind: &str, name: &str| {
        vec![
            File::new()
                .with("Reference channel", kind)
                .with("Reference channel name", name),
            File {
                lines: times.lines.clone(),
                rows: times.rows.clone(),
            },
        ]
    };
    let named = "11TIRS000000TI00";
    let mut cases = vec![
        refused_folder(
            "a name that says a head",
            &[coded("Driver head X").with("Name of the channel", "Driver head acceleration X")],
            &["--channel", "Driver head X"],
        ),
        refused_folder(
            "a code that is too short, of a barrier",
            &[coded("M0MBARLEMIUPACX").with("Name of the channel", "NOVALUE")],
            &["--channel", "M0MBARLEMIUPACX"],
        ),
        refused_folder(
            "a name that says little",
            &[coded("Sensor 4").with("Name of the channel", "Sensor 4")],
            &["--channel", "Sensor 4"],
        ),
        folder(
            "a name that says little, asked for",
            &[coded("Sensor 4").with("Name of the channel", "Sensor 4")],
        )
        .options(&["--channel", "Sensor 4"])
        .channel("Sensor 4")
        .finds(&["warning channel-not-lateral"]),
        refused_folder(
            "a name that says a dummy's head against its code",
            &[File::new().with("Name of the channel", "Dummy head Y")],
            &["--channel", CODE],
        ),
        folder(
            "a name that says lateral",
            &[coded("Door_ACC_Y").with("Name of the channel", "Door acceleration Y")],
        )
        .channel("Door_ACC_Y"),
        refused_folder(
            "a reference that is not understood",
            &refers("yes", named),
            &["`Reference channel` implicit or explicit", "`yes`"],
        )
        .options(&["--channel", "001"]),
        refused_folder(
            "the channel of times as the kind of reference",
            &refers(named, named),
            &["`Reference channel` implicit or explicit"],
        )
        .options(&["--channel", "001"]),
        one(
            "a filter class at odds with the code",
            &coded("11DOORLE0000ACYD").with("Channel frequency class", "1000"),
        )
        .channel("11DOORLE0000ACYD")
        .finds(&["info already-filtered"])
        .unusable(&["blocking header-contradicted"], &["CFC 60"]),
        one(
            "a filter class as the code has it",
            &coded("11DOORLE0000ACYA").with("Channel frequency class", "CFC 1000"),
        )
        .channel("11DOORLE0000ACYA")
        .finds(&["info already-filtered"]),
        one("a unit in brackets", &File::new().with("Unit", "[m/s^2]")),
        said("Remarks", "Channel invalid after 10 ms"),
        said("Remark", "Channel invalid after 10 ms"),
        said("Bemerkung", "Kanal ung\u{fc}ltig"),
        said("Bemerkungen", "Kanal ung\u{fc}ltig"),
        said("Kommentar", "Kanal ung\u{fc}ltig"),
        said("Note", "Channel invalid after 10 ms"),
    ];
    for (kind, name) in [
        ("Explicit channel", named),
        ("explicit (002)", "002"),
        ("NOVALUE", named),
    ] {
        let mut case = folder(&format!("{kind} by {name}"), &refers(kind, name))
            .options(&["--channel", "001"])
            .unusable(
                &[
                    "blocking time-contradicted",
                    "warning rate-below-default-filter",
                ],
                &["channel of times"],
            );
        case = case.clock(5_000.0, -0.04);
        cases.push(case);
    }
    for class in ["cfc60", "cfc 60", "CFC_60", "CFC60", "D"] {
        cases.push(
            one(
                &format!("{class} before"),
                &File::new().with("Channel frequency class", class),
            )
            .finds(&["warning already-filtered"]),
        );
    }
    cases
}

/// A tar entry that links to another file.
fn link(name: &str, kind: u8) -> Vec<u8> {
    let mut header = tar_of(&[(name.into(), Vec::new())])[..512].to_vec();
    header[156] = kind;
    header[157..157 + 14].copy_from_slice(b"Channel/T7.001");
    header[148..156].fill(b' ');
    let sum: u32 = header.iter().map(|byte| u32::from(*byte)).sum();
    header[148..155].copy_from_slice(format!("{sum:06o}\0").as_bytes());
    header
}

/// Replaces bytes by as many others, wherever they stand.
fn with_bytes(mut bytes: Vec<u8>, old: &[u8], new: &[u8]) -> Vec<u8> {
    for at in 0..bytes.len() - old.len() {
        if bytes[at..].starts_with(old) {
            bytes[at..at + new.len()].copy_from_slice(new);
        }
    }
    bytes
}

/// The test's zip with another word in each file's two headers, at these places.
fn zip_saying(local: usize, central: usize, word: u16) -> Vec<u8> {
    let mut bytes = zip_of(&files(&[File::new()]));
    for at in 0..bytes.len() - 4 {
        let place = match &bytes[at..at + 4] {
            b"PK\x03\x04" => at + local,
            b"PK\x01\x02" => at + central,
            _ => continue,
        };
        bytes[place..place + 2].copy_from_slice(&word.to_le_bytes());
    }
    bytes
}

/// Archives that are cut, linked, doubled or packed otherwise, and files as other programs
/// write them.
fn packings() -> Vec<Case> {
    let test = files(&[coded("13DOORRI0000ACYP"), File::new()]);
    let whole = tar_of(&test);
    let rest = &test[2..];
    let after: usize = rest
        .iter()
        .map(|(_, bytes)| 512 + bytes.len().next_multiple_of(512))
        .sum();
    let cut = whole[..whole.len() - 1024 - after].to_vec();
    let one_test = tar_of(&files(&[File::new()]));
    let ends = one_test.len();
    let linked = |kind: u8| {
        let mut bytes = one_test[..ends - 1024].to_vec();
        bytes.extend(link("Channel/T7.002", kind));
        bytes.resize(bytes.len() + 1024, 0);
        bytes
    };
    let zip = zip_of(&files(&[File::new()]));
    let utf_16: Vec<u8> = std::iter::once(0xFEFF_u16)
        .chain(File::new().text().encode_utf16().collect::<Vec<_>>())
        .flat_map(u16::to_le_bytes)
        .collect();
    let inner = |(name, bytes): (String, Vec<u8>)| (format!("T7/{name}"), bytes);
    vec![
        refused("cut.tar", cut, &["cut.tar", "block of zeros"]).named("a tar cut between files"),
        lateral(
            good("t.tar", one_test[..ends - 512].to_vec()),
            "a tar with one block of zeros",
        ),
        refused(
            "t.tar",
            linked(b'1'),
            &["Channel/T7.002 as a link", "unpack"],
        )
        .named("a hard link to a channel"),
        refused(
            "t.tar",
            linked(b'2'),
            &["Channel/T7.002 as a link", "unpack"],
        )
        .named("a symbolic link to a channel"),
        refused(
            "two.zip",
            [zip.clone(), zip.clone()].concat(),
            &["one zip archive", "two archives"],
        )
        .named("two zips in one file"),
        lateral(
            good("t.zip", with_bytes(zip, b"Channel/T7", b"Channel\\T7")),
            "a zip with marks of Windows",
        ),
        refused(
            "t.zip",
            zip_saying(6, 8, 1),
            &["zip that is encrypted", "unpack"],
        )
        .named("an encrypted zip"),
        refused(
            "t.zip",
            zip_saying(8, 10, 12),
            &["packed in an unknown way", "unpack"],
        )
        .named("a zip of bzip2"),
        refused(
            "t.zip",
            zip_saying(8, 10, 14),
            &["packed in an unknown way", "unpack"],
        )
        .named("a zip of lzma"),
        lateral(good("t7.001", utf_16), "utf-16"),
        lateral(
            good("t7.001", File::new().text().replace('\n', "\r")),
            "carriage returns alone",
        ),
        lateral(
            good(
                "t7.001",
                File::new().text().replace("Channel code", "channel code"),
            ),
            "keys in small letters",
        ),
        {
            let mut case = refused_folder(
                "the folder above a test",
                &[File::new()],
                &["the test lies in T7", "name that folder"],
            );
            case.files = case.files.into_iter().map(inner).collect();
            case
        },
    ]
}

/// Other formats, by what they begin with.
fn other_formats() -> Vec<Case> {
    [
        ("a.parquet", &b"PAR1\x15\x04\x15\x80\x0c\x4c"[..], "Parquet"),
        ("a.mat", b"\0\0\0\0\x05\0\0\0\x01\0\0\0", "MATLAB"),
        ("a.bag", b"#ROSRECORD V1.1\n", "ROS 1 bag"),
        ("b.bag", b"#ROSBAG V1.2\n", "ROS 1 bag"),
        ("a.tdms_index", b"TDSh\x0e\0\0\0", "tdms_index"),
        (
            "a.tdm",
            b"<?xml version=\"1.0\"?>\n<usi:tdm version=\"1.0\">\n",
            "DIAdem",
        ),
        (
            "a.uff",
            b"    -1\n    58\nDoor acceleration\n     0.1\n",
            "universal file",
        ),
        ("a.raw", b"|CF,2,1,1;|CK,1,3,1,1;", "FAMOS"),
        ("a.json", b"{\n \"acc_y\": [1, 2]\n}\n", "JSON"),
        ("b.json", b"[[0, 1], [0.1, 2]]\n", "JSON"),
    ]
    .into_iter()
    .map(|(name, bytes, says)| refused(name, bytes, &[says, "CSV"]))
    .map(|mut case| {
        // The way out of a bag is another, and that of an index is its file.
        if case.opened.ends_with(".bag") {
            case.says[1] = "mcap convert".into();
        }
        if case.opened.ends_with(".tdms_index") {
            case.says[1] = "open the .tdms file beside it".into();
        }
        case
    })
    .chain([{
        // A table may begin with a unit in brackets.
        let mut text = String::from("[s],acc_y_g\n").replace("[s]", "[t] (s)");
        for k in FROM..TO {
            writeln!(text, "{},{}", s(k), g(k)).unwrap();
        }
        good("brackets.csv", text)
    }])
    .collect()
}
