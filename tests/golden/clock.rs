//! Two statements of one clock, in every format that can hold two: the outcome depends on how far they are apart,
//! not on the format.

use super::{FROM, TO, logs, tdms, template};
use latchgate_recording::{ReadOptions, Selection, Severity};
use latchgate_test_support::{Folder, one, read_path};
use std::path::PathBuf;

/// A format: its name, and a file of the push at 10 kHz by its stamps, whose other statement is this rate [Hz].
type Format = (&'static str, fn(&Folder, f64) -> PathBuf);

const FORMATS: [Format; 7] = [
    ("CSV", |folder, hertz| {
        let text = format!("Sample Rate (Hz),{hertz:.6}\n\ntime_s,acc_y_g\n{{rows}}{{t}},{{g}}\n");
        folder.file("a.csv", expanded(&text))
    }),
    ("CSV, two columns", |folder, hertz| {
        let part = 1e7 / hertz;
        let text = format!("Time (s);Time (ms);acc_y_g\n{{rows}}{{t}};{{t*{part}:.6}};{{g}}\n");
        folder.file("a.csv", expanded(&text))
    }),
    ("LVM", |folder, hertz| {
        let step = 1.0 / hertz;
        let text = format!(
            "LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\n\
             Multi_Headings\tYes\nX_Columns\tOne\nTime_Pref\tRelative\n***End_of_Header***\t\n\t\n\
             Channels\t1\t\nSamples\t800\t\nY_Unit_Label\tg\t\nX_Dimension\tTime\t\nX0\t-2.0E-2\t\n\
             Delta_X\t{step:.10}\t\n***End_of_Header***\t\t\nX_Value\tacc y\tComment\n{{rows}}{{t}}\t{{g}}\n"
        );
        folder.file("a.lvm", expanded(&text))
    }),
    ("TDMS", |folder, hertz| {
        folder.file("a.tdms", tdms::stamped(1.0 / hertz))
    }),
    ("EV5", |folder, hertz| {
        let head = format!(
            "# comment\n----- TEST -----\n7292|a test|\n----- INSTRUMENTATION -----\n\
             1|146|AC|NA|DSLF|YG|SEC|G'S|1650|MAKER|01/JAN/2010|2000|2|0.0|-200|599|{:.6}|AM|P|NO COMMENTS\n\
             ----- END -----",
            1e6 / hertz
        );
        folder.file("v07292.EV5", head);
        folder.file("v07292.146", expanded("{rows}{t:.6}\t{g:.6}\n"))
    }),
    ("ISO-MME", |folder, hertz| {
        let head = |code: &str, unit: &str, more: &str| {
            format!(
                "Test object number          :1\nName of the channel         :Door, left: lower\n\
                 Channel code                :{code}\nUnit                        :{unit}\n{more}\
                 Number of samples           :800\n"
            )
        };
        let times = "Reference channel           :explicit\nReference channel name      :11TIRS000000TI00\n";
        let own = format!(
            "{times}Sampling interval           :{:.10}\nTime of first sample        :-0.02\n",
            1.0 / hertz
        );
        let implicit = "Reference channel           :implicit\nSampling interval           :1.00000E-4\n\
                        Time of first sample        :-2.0E-2\n";
        let channel = head("11DOORLE0000ACYP", "m/(s*s)", &own) + "{rows}{si:.4}\n";
        let stamps = head("11TIRS000000TI00", "s", implicit) + "{rows}{t}\n";
        folder.file("Channel/T7.001", expanded(&channel));
        folder.file("Channel/T7.002", expanded(&stamps));
        let index = "Number of channels          :2\nName of channel 001         :11DOORLE0000ACYP / x\n\
                     Name of channel 002         :11TIRS000000TI00 / x\n";
        folder.file("Channel/T7.chn", index);
        folder.path().join("Channel/T7.001")
    }),
    ("MCAP", |folder, hertz| {
        folder.file("a.mcap", logs::logged_at(1e4 / hertz))
    }),
];

fn expanded(text: &str) -> String {
    template::expand(text).unwrap()
}

/// 0.05 % confirm, 0.5 % are told, 2 and 40 % make the recording unusable, either way and in every format.
#[test]
fn val_statements_of_one_clock_are_compared_alike_in_every_format() {
    let mut faults = Vec::new();
    for (name, written) in FORMATS {
        for (apart, expected) in [
            (0.0, "confirmed"),
            (5e-4, "confirmed"),
            (5e-3, "silent"),
            (0.02, "contradicted"),
            (0.4, "contradicted"),
        ] {
            for ratio in [1.0 + apart, 1.0 / (1.0 + apart)] {
                let folder = Folder::new(&format!("clock-{}", name.replace([' ', ','], "-")));
                let path = written(&folder, 1e4 * ratio);
                let options = ReadOptions {
                    time_column: (name == "CSV, two columns").then(|| "Time (s)".into()),
                    ..ReadOptions::default()
                };
                let (channel, findings) = one(&path, &options);
                let blocks = |code: &str| {
                    let mut all = findings.iter();
                    all.any(|one| one.code == code && one.severity == Severity::Blocking)
                };
                let found = match channel.stated.clock_confirmed_by {
                    _ if blocks("time-contradicted") => "contradicted",
                    Some(_) => "confirmed",
                    None => "silent",
                };
                // Between messages and their log delays make as much.
                let is_told = findings.iter().any(|one| one.code == "time-differs");
                if name != "MCAP" {
                    assert_eq!(is_told, expected == "silent", "{name}, {ratio}");
                }
                if found != expected {
                    faults.push(format!("{name}, {ratio}: {found}, not {expected}"));
                }
                assert_eq!(channel.values.len() as i64, TO - FROM, "{name}");
            }
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

/// A person who states the rate of the clock in use decides in every format, and must accept the clock.
#[test]
fn val_a_stated_rate_decides_between_two_clocks_in_every_format() {
    for (name, written) in FORMATS {
        let folder = Folder::new(&format!("clock-stated-{}", name.replace([' ', ','], "-")));
        let path = written(&folder, 1.4e4);
        let options = ReadOptions {
            time_column: (name == "CSV, two columns").then(|| "Time (s)".into()),
            // Of TDMS the clock in use is the interval.
            rate_hz: Some(if name == "TDMS" { 1.4e4 } else { 1e4 }),
            ..ReadOptions::default()
        };
        let (channel, findings) = one(&path, &options);
        let mut blocking = findings
            .iter()
            .filter(|one| one.severity == Severity::Blocking);
        assert_eq!(blocking.next(), None, "{name}");
        assert!(
            channel.stated.clock_doubt.is_some(),
            "{name}: {findings:#?}"
        );
    }
}

/// A log that runs backwards, or stands still, is no witness of the stamps.
#[test]
fn regress_a_log_that_runs_backwards_confirms_nothing() {
    let folder = Folder::new("clock-backwards");
    for times in [-5.0, -1.0, 0.0] {
        let path = folder.file("a.mcap", logs::logged_at(times));
        let (channel, _) = one(&path, &ReadOptions::default());
        assert_eq!(channel.stated.clock_confirmed_by, None, "{times}");
    }
}

/// A table without stamps below a line of 10 kHz in any words: a person who states the double rate must accept the
/// clock, one who states that rate need not.
#[test]
fn val_statements_in_any_words_are_held_against_a_stated_rate() {
    let doubt = |name: &str, head: &str, names: &str, hertz: f64| {
        let folder = Folder::new("clock-in-words");
        let path = folder.file(name, expanded(&format!("{head}{names}\n{{rows}}{{g}}\n")));
        let is_comment = head.starts_with('#') || head.is_empty();
        let lines = head.matches('\n').count() as u32;
        let options = ReadOptions {
            rate_hz: Some(hertz),
            header_line: (!is_comment).then_some(lines + 1),
            ..ReadOptions::default()
        };
        one(&path, &options).0.stated.clock_doubt
    };
    for head in [
        "Sampling Frequency - 10000\n",
        "Scan rate (Hz) 10000\n",
        "Rate 10 kS/s\n",
        "# 10 kHz\n",
        "# one sample every 100 us\n",
        "Frequency: 10000\n",
        "XINCR 1.0E-4\n",
        "Start,-0.02\nEnd,0.0599\n",
        "Start,-20\nEnd,60\n",
        "SR,10000 Hz\n",
        "Sample rate: 10,000 Hz\n",
        "Sample rate: 10 kHz (nominal)\n",
        "Sampling,10000 per second\n",
        "Messung mit 10 kHz, Filter 4 kHz\n",
        "Duration: 80 ms\n",
    ] {
        let told = doubt("a.csv", head, "acc_y_g", 2e4);
        let told = told.unwrap_or_else(|| panic!("{head}: nothing is told"));
        assert!(told.contains("line"), "{told}");
        assert_eq!(doubt("a.csv", head, "acc_y_g", 1e4), None, "{head}");
    }
    for head in [
        "",
        "# anti-alias filter 4 kHz\n",
        "# CFC 1000, cutoff 1650 Hz\n",
        "# camera at 1000 Hz, trigger delay 0.2 ms\n",
        "Test 7292 of 17/11/2010\n",
    ] {
        assert_eq!(doubt("a.csv", head, "acc_y_g", 2e4), None, "{head}");
    }
}

/// The zero that a file without stamps shows is used: sample numbers from below zero, a start in its head, an
/// oscilloscope's start and increment.
#[test]
fn val_the_zero_that_a_file_shows_is_used() {
    for (text, lines) in [
        ("Sample,acc_y_g\n{rows}{k},{g}\n", None),
        ("Start time: -20 ms\nacc_y_g\n{rows}{g}\n", Some(2)),
        ("Start,-0.02\nIncrement,1e-4\nacc_y_g\n{rows}{g}\n", Some(3)),
        ("Start,-20\nEnd,59.9\nacc_y_g\n{rows}{g}\n", Some(3)),
        (
            "X,CH1,Start,Increment\nSequence,g,-2.0e-2,1.0e-4\nn,acc_y_g,,\n{rows}{k+200},{g},,\n",
            Some(3),
        ),
    ] {
        let folder = Folder::new("clock-zero");
        let path = folder.file("a.csv", expanded(text));
        for (stated, code) in [
            (None, "time-zero-shown"),
            (Some(0.02), "time-zero-contradicted"),
        ] {
            let options = ReadOptions {
                rate_hz: Some(1e4),
                header_line: lines,
                time_zero_s: stated,
                ..ReadOptions::default()
            };
            let (channel, findings) = one(&path, &options);
            let start_s = -0.02 - stated.unwrap_or(0.0);
            assert!(
                (channel.start_s - start_s).abs() < 1e-12,
                "{text}: {}",
                channel.start_s
            );
            let codes: Vec<&str> = findings.iter().map(|one| one.code.as_ref()).collect();
            assert!(codes.contains(&code), "{text}: {codes:?}");
        }
    }
}

/// A second clock that runs back in one cell, or jumps once, contradicts as one that does not.
#[test]
fn regress_a_fault_of_a_second_clock_hides_no_contradiction() {
    let folder = Folder::new("clock-faulty");
    let rows = |fault: &str| {
        format!(
            "Time (s),Time (ms),acc_y_g\n{{rows ..100}}{{t}},{{k*0.2}},{{g}}\n{fault}{{rows 101..}}{{t}},{{k*0.2}},{{g}}\n"
        )
    };
    let jump = "Time (s),Time (ms),acc_y_g\n{rows ..100}{t},{k*0.105},{g}\n{rows 100..}{t},{k*0.105+12},{g}\n";
    let texts = [
        rows("{rows 100}{t},0,{g}\n"),
        rows("{rows 100}{t},900,{g}\n"),
        jump.into(),
    ];
    for text in texts {
        let path = folder.file("a.csv", expanded(&text));
        let options = ReadOptions {
            time_column: Some("Time (s)".into()),
            ..ReadOptions::default()
        };
        let (channel, findings) = one(&path, &options);
        assert_eq!(channel.stated.clock_confirmed_by, None, "{text}");
        let mut all = findings.iter();
        assert!(
            all.any(|one| one.code == "time-contradicted"),
            "{text}: {findings:?}"
        );
    }
}

/// Several channels below one another in one column are refused with their labels, whatever is stated of the clock.
#[test]
fn val_a_long_table_is_no_channel() {
    let refused = |text: &str, options: &ReadOptions| {
        let folder = Folder::new("clock-long");
        let path = folder.file("a.csv", expanded(text));
        let outcome = read_path(&path, options, Selection::Lateral);
        outcome.map_or_else(|error| error.to_string(), |_| String::new())
    };
    for (text, label) in [
        ("time,channel,value_g\n{rows}{t},{turn ax|ay},{g}\n", "`ax`"),
        ("Sensor,ay (g)\n{rows}{turn left|right},{g}\n", "`left`"),
        ("Sensor,ay (g)\n{rows}{turn 1|2},{g}\n", "`2`"),
    ] {
        for rate_hz in [None, Some(1e4), Some(2e4)] {
            let options = ReadOptions {
                rate_hz,
                ..ReadOptions::default()
            };
            let told = refused(text, &options);
            assert!(
                told.contains(label) && told.contains("below one another"),
                "{text}: {told}"
            );
        }
    }
    let rows = (0..400).flat_map(|row| {
        [1, 2].map(|place| format!("{},{place},{}\n", f64::from(row) / 1e4, row % 7))
    });
    let doubled = format!("Time (s),place,ay (g)\n{}", rows.collect::<String>());
    let told = refused(&doubled, &ReadOptions::default());
    assert!(told.contains("`1`, `2`"), "{told}");
    let states = "time_s,acc_y_g,Toggle\n{rows}{t},{g},{turn 0|1}\n";
    assert_eq!(refused(states, &ReadOptions::default()), "");
}
