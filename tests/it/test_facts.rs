//! What heads of files say of test, vehicle, laboratory and sensor: read, kept short, and shown.

use crate::support::{Folder, latchgate, one};
use latchgate_recording::{ReadOptions, TestFacts};
use std::path::{Path, PathBuf};

const MME: &str = "\
Data format edition number  :1.6
Laboratory name             :A laboratory
Laboratory test ref. number :98/7707
Customer test ref. number   :NOVALUE
Title                       :Pole, 29 km/h: left
Type of the test            :Side impact
Date of the test            :2024-05-01
Name of test object 1       :A car
Ref. number of test object 1:W0L000051T2123456
Name of test object 2       :A pole
";

const CHANNEL: &str = "\
Test object number          :1
Name of the channel         :Door, left, front, acceleration Y
Channel code                :11DOORLEFR00ACYP
Unit                        :m/(s*s)
Reference channel           :implicit
Transducer type             :7264C-2000
Transducer id               :P52113
Channel amplitude class     :5000
Sampling interval           :1.0E-4
Time of first sample        :-1.0E-2
";

fn rows(write: impl Fn(usize) -> String) -> String {
    (0..400).map(write).collect()
}

fn sample(index: usize) -> f64 {
    if (100..300).contains(&index) {
        -(index as f64 - 100.0) * (300.0 - index as f64) / 100.0
    } else {
        0.25 * (index as f64).sin()
    }
}

/// A test of one channel, as a folder.
fn mme(folder: &Folder, test: &str, channel: &str) -> PathBuf {
    let samples = rows(|index| format!("{:.4}\n", sample(index)));
    folder.write("T7/T7.mme", test);
    folder.write("T7/Channel/T7.001", format!("{channel}{samples}"));
    folder.path().join("T7")
}

/// A LabVIEW file with lines in its first header.
fn lvm(folder: &Folder, lines: &str) -> PathBuf {
    let samples = rows(|index| format!("{:.4}\t{:.4}\n", index as f64 * 1e-4, sample(index)));
    let text = format!(
        "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nX_Columns\tOne\n{lines}\
         ***End_of_Header***\t\n\t\nChannels\t1\t\nSamples\t400\t\nY_Unit_Label\tm/s^2\t\n\
         Delta_X\t1.0E-4\t\n***End_of_Header***\t\t\nX_Value\ta quer\tComment\n{samples}"
    );
    folder.file("door.lvm", text)
}

fn ev5(folder: &Folder, test: &str) -> PathBuf {
    let samples = rows(|index| {
        let time_s = index as f64 * 1e-4 - 0.01;
        format!("{time_s:.6}\t{:.6}\n", sample(index) / 10.0)
    });
    folder.file("v00001.007", samples);
    let line =
        "1|7|AC|NA|DSLF|YG|ENDEVCO|G'S|1650|X|01/JAN/2020|200|50|0|-100|299|100|AM|P|NO COMMENTS";
    let head = "# Test Number: 00001\n----- EV5 -----\n----- TEST -----\n";
    let text = format!("{head}{test}\n----- INSTRUMENTATION -----\n{line}\n----- END -----");
    folder.file("v00001.EV5", text)
}

fn facts(texts: [&str; 6]) -> TestFacts {
    let [test, vehicle, laboratory, date, sensor, location] =
        texts.map(|text| (!text.is_empty()).then(|| text.to_string()));
    TestFacts {
        test,
        vehicle,
        laboratory,
        date,
        sensor,
        location,
        speed: None,
    }
}

#[track_caller]
fn check_facts(path: &Path, expected: [&str; 6]) {
    let (channel, _) = one(path, &ReadOptions::default());
    assert_eq!(channel.stated.test, facts(expected));
}

/// Test, vehicle, laboratory, date, sensor, location.
#[test]
fn val_heads_say_what_was_tested_where() {
    let folder = Folder::new("facts-mme");
    let full = [
        "98/7707, Pole, 29 km/h: left, Side impact",
        "A car, W0L000051T2123456",
        "A laboratory",
        "2024-05-01",
        "7264C-2000, P52113",
        "11DOORLEFR00ACYP",
    ];
    check_facts(&mme(&folder, MME, CHANNEL), full);
    // Without the number of its test object the code's first character counts.
    let coded = CHANNEL.replacen("Test object number          :1\n", "", 1);
    check_facts(&mme(&folder, MME, &coded), full);
    let (_, number) = MME.split_at(MME.find("Laboratory test").unwrap());
    let number = number.replacen("98/7707", "-", 1);
    let number = number.replacen("ref. number   :NOVALUE", "ref number   :C-1", 1);
    let other = [
        "C-1, Pole, 29 km/h: left, Side impact",
        full[1],
        "",
        full[3],
        full[4],
        full[5],
    ];
    check_facts(&mme(&folder, &number, CHANNEL), other);

    let folder = Folder::new("facts-lvm");
    let lines = "Project\tDoor latch\t\nDescription\tSled 12\nOperator\tmt\t\t\nDate\t2016/12/12\nTime\t09:54:07\n";
    let expected = [
        "Door latch, Sled 12",
        "",
        "operator mt",
        "2016/12/12",
        "",
        "",
    ];
    check_facts(&lvm(&folder, lines), expected);
}

/// What only fills a place says nothing.
#[test]
fn val_placeholders_of_heads_say_nothing() {
    for nothing in ["NOVALUE", "", "-", "n/a", "none", "  ", "---"] {
        let folder = Folder::new("facts-nothing");
        let head = MME.lines().map(|line| {
            let (key, _) = line.split_once(':').unwrap();
            format!("{key}:{nothing}\n")
        });
        let head: String = head.collect();
        let channel = CHANNEL.replacen("7264C-2000", nothing, 1);
        let channel = channel.replacen("P52113", nothing, 1);
        let expected = ["", "", "", "", "", "11DOORLEFR00ACYP"];
        check_facts(&mme(&folder, &head, &channel), expected);
        let lines = ["Project", "Description", "Operator", "Date"];
        let lines = lines.map(|key| format!("{key}\t{nothing}\t\n")).concat();
        check_facts(&lvm(&folder, &lines), [""; 6]);
    }
}

/// Texts of any length stay short, in every format.
#[test]
fn prop_facts_of_hostile_heads_are_short_and_steer_no_terminal() {
    let folder = Folder::new("facts-hostile");
    let long = format!("\u{202E}[2J{}", "ä".repeat(5000));
    let paths = [
        mme(&folder, &MME.replacen("A laboratory", &long, 1), CHANNEL),
        lvm(&folder, &format!("Operator\t{long}\n")),
        ev5(&folder, &format!("V5|T|O|01/JAN/2020|{long}|")),
    ];
    for path in paths {
        let (channel, _) = one(&path, &ReadOptions::default());
        let laboratory = channel.stated.test.laboratory.unwrap();
        assert_eq!(laboratory.chars().count(), 201, "{path:?}");
        let done = latchgate(&["inspect", &path.to_string_lossy()]);
        assert_eq!(done.code, 0, "{}", done.err);
        assert!(done.out.contains("ää…"), "{}", done.out);
        assert!(!done.out.contains('\u{202E}'), "{}", done.out);
    }
}

/// `inspect` shows what a file says of its test, as a verdict does.
#[test]
fn cli_inspect_shows_what_heads_say() {
    let folder = Folder::new("facts-shown");
    for (path, lines) in [
        (
            mme(&folder, MME, CHANNEL),
            vec![
                "test: 98/7707, Pole, 29 km/h: left, Side impact",
                "laboratory: A laboratory",
                "location: door, left, front, Y (11DOORLEFR00ACYP)",
            ],
        ),
        (
            lvm(&folder, "Operator\tmt\n"),
            vec!["laboratory: operator mt"],
        ),
        (
            ev5(&folder, "V5|T|O|01/JAN/2020|L|"),
            vec![
                "test: 1, T",
                "laboratory: L",
                "location: door sill, left front, Y (DSLF YG)",
            ],
        ),
    ] {
        let path = path.to_string_lossy();
        let done = latchgate(&["inspect", &path]);
        for line in lines {
            assert!(
                done.out.lines().any(|one| one == line),
                "{line}\n{}",
                done.out
            );
        }
        let listed = latchgate(&["inspect", &path, "--format", "json"]).document();
        let options = ["--no-report", "--members", "0", "--format", "json"];
        let judged = latchgate(&[&["replay", &path], options.as_slice()].concat()).document();
        assert_eq!(listed["test"], judged["test"], "{path}");
    }
}

/// What channels differ in stands with each of them, not with the file.
#[test]
fn cli_inspect_tells_facts_of_the_file_from_those_of_channels() {
    let folder = Folder::new("facts-channels");
    let path = mme(&folder, MME, CHANNEL);
    let other = CHANNEL.replace("11DOORLEFR00ACYP", "14BPILLO0000ACYP");
    let other = other.replace("P52113", "P1");
    let samples = rows(|index| format!("{:.4}\n", sample(index)));
    folder.write("T7/Channel/T7.002", format!("{other}{samples}"));
    let path = path.to_string_lossy();
    let done = latchgate(&["inspect", &path, "--channel", "002"]);
    let line = "14BPILLO0000ACYP: 7264C-2000, P1; B-pillar, left, lower, Y (14BPILLO0000ACYP)";
    assert!(done.out.lines().any(|one| one == line), "{}", done.out);
    assert!(!done.out.contains("P52113"), "{}", done.out);
    let all = latchgate(&["inspect", &path, "--channel", "002", "-v"]);
    assert!(all.out.contains("P52113"), "{}", all.out);
    let listed = latchgate(&["inspect", &path, "--format", "json"]).document();
    assert_eq!(listed["test"]["vehicle"], "A car, W0L000051T2123456");
    assert!(listed["test"]["sensor"].is_null(), "{listed}");
    assert_eq!(listed["channels"][1]["place"], "B-pillar, left, lower, Y");
    assert_eq!(
        listed["channels"][1]["stated"]["test"]["sensor"],
        "7264C-2000, P1"
    );
}
