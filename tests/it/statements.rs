//! What a table states of clock, unit and gravity, in spellings that no list holds: a table that contradicts it
//! never passes unasked, and one that is sound is answered.
//!
//! The truth of each table opens the lever. Read ten times too fast, or in m/s² for g, it would stay shut.

use crate::support::{Folder, half_sine, latchgate};

/// A row of a table: by its number, true time [s] and acceleration [g].
type Row = fn(usize, f64, f64) -> String;

/// A table, what a person says of it, and what must come of that.
struct Case {
    head: &'static str,
    row: Row,
    options: &'static [&'static str],
    exit: i32,
    /// The code of a finding, or words of the message.
    says: &'static str,
}

const fn case(
    head: &'static str,
    row: Row,
    options: &'static [&'static str],
    exit: i32,
    says: &'static str,
) -> Case {
    Case {
        head,
        row,
        options,
        exit,
        says,
    }
}

/// A crash of 25 m/s at 5 kHz.
fn text(head: &str, row: Row) -> String {
    let mut text = format!("{head}\n");
    for index in 0..2001 {
        let t = f64::from(index) / 5e3 - 0.1;
        let noise = 0.1 * (f64::from(index) * 1.7).sin() + 0.07 * (f64::from(index) * 2.9).cos();
        let push = half_sine(t, 0.0, 0.08, 50.0) + noise;
        text += &row(index as usize, t, push);
        text.push('\n');
    }
    text
}

#[track_caller]
fn check_cases(name: &str, cases: &[Case]) {
    let folder = Folder::new(name);
    let asked = [
        "--opens-when",
        "positive",
        "--no-report",
        "--format",
        "json",
    ];
    let preload = "lever.preload_torque_nm=2.82";
    let design = ["--members", "0", "--transfer", "1", "--set", preload];
    for (index, case) in cases.iter().enumerate() {
        let path = folder.write(
            &format!("{index}.csv"),
            text(case.head, case.row).as_bytes(),
        );
        let done = latchgate(&[&["replay", &path][..], &asked, &design, case.options].concat());
        let found = format!("{}{}", done.out, done.err);
        let (head, options) = (case.head, case.options);
        assert_eq!(done.code, case.exit, "{head:?} {options:?}: {found}");
        assert!(found.contains(case.says), "{head:?} {options:?}: {found}");
    }
}

fn true_g(_: usize, t: f64, a: f64) -> String {
    format!("{t:.4},{a:.3}")
}

fn true_pair(_: usize, t: f64, a: f64) -> String {
    format!("{t:.4},{a:.3},{:.3}", 0.2 * a)
}

fn fast(_: usize, t: f64, a: f64) -> String {
    format!("{:.5},{a:.3}", t / 10.0)
}

fn fast_pair(_: usize, t: f64, a: f64) -> String {
    format!("{:.5},{a:.3},{:.3}", t / 10.0, 0.2 * a)
}

/// A clock under any name beside the one that is used, and what only counts rows.
#[test]
fn verif_a_second_clock_of_any_name_is_compared() {
    const BLOCKS: &str = "time-contradicted";
    check_cases(
        "second-clocks",
        &[
            case(
                ",Time (s),ay (g)",
                |_, t, a| format!("{t:.4},{:.5},{a:.3}", t / 10.0),
                &[],
                4,
                BLOCKS,
            ),
            case(
                "Time (s),mono_us,ay (g)",
                |_, t, a| format!("{:.5},{:.0},{a:.3}", t / 10.0, (t + 1.0) * 1e6),
                &[],
                4,
                BLOCKS,
            ),
            case(
                "Time (s),laufende Uhr,ay (g)",
                |_, t, a| format!("{:.5},{:.1},{a:.3}", t / 10.0, (t + 1.0) * 1e3),
                &[],
                4,
                BLOCKS,
            ),
            case(
                "Time (s),Sampling rate [kHz],ay (g)",
                |_, t, a| format!("{:.5},5,{a:.3}", t / 10.0),
                &[],
                4,
                BLOCKS,
            ),
            case(
                "Time (s),fs_Hz,ay (g)",
                |_, t, a| format!("{:.5},5000,{a:.3}", t / 10.0),
                &[],
                4,
                BLOCKS,
            ),
            // Every hundredth row of a frame, or microseconds: a person says which.
            case(
                "index,Time (s),ay (g)",
                |index, t, a| format!("{},{:.5},{a:.3}", 200 * index, t / 10.0),
                &[],
                3,
                "clock-implausible",
            ),
            case(
                "(index),ay (g)",
                true_g,
                &["--rate-hz", "50000"],
                4,
                "5000 Hz by the time column `(index)`",
            ),
            case(
                "(index),ay (g)",
                |index, _, a| format!("{},{a:.3}", 200 * index),
                &["--rate-hz", "50000", "--time-zero", "0.01"],
                3,
                "clock-implausible",
            ),
            case(
                ",Time (s),frame,ay (g)",
                |index, t, a| format!("{index},{t:.4},{},{a:.3}", index + 7),
                &[],
                1,
                "\"fail\"",
            ),
            case(
                ",Time (ms),ay (g)",
                |_, t, a| format!("{t:.4},{:.1},{a:.3}", t * 1e3),
                &[],
                1,
                "\"fail\"",
            ),
            case(
                "Time (100ns),ay (g)",
                |index, _, a| format!("{},{a:.3}", 1_714_557_600_000_000_u64 + 200 * index as u64),
                &[],
                4,
                BLOCKS,
            ),
        ],
    );
}

/// Units that a name or the rows above state, beside a number of the sensor or in a row that is wider.
#[test]
fn verif_a_stated_unit_is_never_overridden_in_silence() {
    const TOLD: &str = "unit-overridden";
    const SI: &[&str] = &["--channel", "2", "--unit", "m/s2"];
    const NONE: &[&str] = &["--channel", "2"];
    check_cases(
        "stated-units",
        &[
            case("time (s),sill ay Q7 (g)", true_g, SI, 0, TOLD),
            case("time (s),Kanal 3:S12B (g)", true_g, SI, 0, TOLD),
            case("time (s),ay R900 (g)", true_g, NONE, 1, "\"fail\""),
            case("time (s),ay 12k (g)", true_g, SI, 0, TOLD),
            case("time (s),ay (relative)", true_g, SI, 0, TOLD),
            case("Kopf,1\nDim.,s,g,g\ntime (s),ay,az", true_pair, SI, 0, TOLD),
            case(
                "Kopf,1\nDim.,s,g,g\ntime (s),ay,az",
                true_pair,
                NONE,
                1,
                "\"fail\"",
            ),
            case(
                "Kopf,1\nGrandeur,g,g\ntime (s),ay,az",
                true_pair,
                SI,
                0,
                TOLD,
            ),
            case(
                "Kopf,1\nWhat it is,[g],[g]\ntime (s),ay,az",
                true_pair,
                NONE,
                1,
                "\"fail\"",
            ),
            case(
                "Kopf,1\nEU,g,g\ntime (s),ay P1,az P2",
                true_pair,
                SI,
                0,
                TOLD,
            ),
            case(
                "Kopf,1\nSensitivity (mV/g),10\ntime (s),ay (V)",
                true_g,
                &["--channel", "2", "--sensitivity", "1 g/V"],
                1,
                TOLD,
            ),
        ],
    );
    // Another quantity, and what the refusal offers without `--unit`.
    for name in [
        "ay nC",
        "ay / mT",
        "ay in kN",
        "ay_V",
        "ay (16 bit) lsb",
        "ay Bits",
        "ay [cts]",
        "ay {V/V}",
        "ay (Vpp)",
        "ay (inch)",
        "ay mm/s",
        "Voltaje ay",
    ] {
        let folder = Folder::new("other-quantities");
        let file = text(&format!("time (s),{name}"), true_g);
        let path = folder.write("a.csv", file.as_bytes());
        for options in [SI, NONE] {
            let asked = ["replay", &path, "--opens-when", "positive", "--no-report"];
            let done = latchgate(&[&asked[..], options].concat());
            assert_eq!(done.code, 4, "{name}: {}", done.out);
            assert!(
                done.err.contains("--sensitivity '20 g/"),
                "{name}: {}",
                done.err
            );
        }
    }
}

/// Rows above the names, by keys that no list holds.
#[test]
fn verif_rows_that_state_the_clock_are_compared_whatever_their_key() {
    const BLOCKS: &str = "time-contradicted";
    const NONE: &[&str] = &["--channel", "2"];
    let mut cases = Vec::new();
    for (head, exit, says) in [
        (
            "Kopf,1\nSampling rate,,5000,5000\ntime (s),ay (g),az (g)",
            4,
            BLOCKS,
        ),
        ("Kopf,1\nFs,5 kHz,5 kHz\ntime (s),ay (g),az (g)", 4, BLOCKS),
        (
            "Kopf,1\nSampleRate_Hz,5000\ntime (s),ay (g),az (g)",
            4,
            BLOCKS,
        ),
        (
            "Kopf,1\nTrue sampling of unit 3,5 kHz\ntime (s),ay (g),az (g)",
            4,
            BLOCKS,
        ),
        (
            "Kopf,1\nScanner step,200 us\ntime (s),ay (g),az (g)",
            4,
            BLOCKS,
        ),
        (
            "Kopf,1\nDuration (s),0.4\ntime (s),ay (g),az (g)",
            3,
            "clock-implausible",
        ),
        (
            "Kopf,1\nStop time,300 ms\ntime (s),ay (g),az (g)",
            3,
            "clock-implausible",
        ),
        (
            "Kopf,1\nStart time (ms),-100\ntime (s),ay (g),az (g)",
            3,
            "clock-implausible",
        ),
        (
            "Kopf,1\nPretrigger time,100 ms\ntime (s),ay (g),az (g)",
            4,
            BLOCKS,
        ),
    ] {
        cases.push(case(head, fast_pair, NONE, exit, says));
    }
    for head in [
        "Kopf,1\nFs,5 kHz\nDuration,0.4 s\nStart time,-0.1 s\ntime (s),ay (g),az (g)",
        "Kopf,1\nVideo rate,1000 Hz\nLamp frequency,50 Hz\ntime (s),ay (g),az (g)",
        "Kopf,1\nStart time,10:00:00\nStart,0 s\ntime (s),ay (g),az (g)",
    ] {
        cases.push(case(head, true_pair, NONE, 1, "\"fail\""));
    }
    check_cases("stated-clocks", &cases);
}

/// What another place of a table says of a clock that is usual by itself holds back a pass until a person
/// accepts the clock: a length above the names, and a count that leaves rows out.
#[test]
fn verif_a_doubt_of_a_usual_clock_holds_back_a_pass() {
    const ACCEPTED: [&str; 2] = ["--accept", "clock"];
    const Y: [&str; 2] = ["--channel", "ay (g)"];
    const BY_RATE: [&str; 4] = ["--rate-hz", "5000", "--time-zero", "0.1"];
    const LENGTH: &str = "Kopf,1\nDuration (s),0.4\ntime (s),ay (g),az (g)";
    const OTHER: &str = "Kopf,1\nDuration (s),0.8\ntime (s),ay (g),az (g)";
    const COUNT: &str = "index,ay (g)";
    let stamped: Row = |_, t, a| format!("{t:.4},{:.4},{:.4}", 0.16 * a, 0.03 * a);
    let by_one: Row = |index, _, a| format!("{index},{:.4}", 0.16 * a);
    let by_three: Row = |index, _, a| format!("{},{:.4}", 3 * index, 0.16 * a);
    let accepted = |options: &[&'static str]| [options, &ACCEPTED].concat();
    let by_rate = [&Y[..], &BY_RATE].concat();
    let (y_accepted, by_rate_accepted) = (accepted(&Y), accepted(&by_rate));
    check_cases(
        "usual-clocks",
        &[
            case(LENGTH, stamped, &Y, 0, "\"pass\""),
            case(OTHER, stamped, &Y, 3, "clock-implausible"),
            case(OTHER, stamped, y_accepted.leak(), 0, "clock-accepted"),
            case(COUNT, by_one, by_rate.clone().leak(), 0, "\"pass\""),
            case(COUNT, by_three, by_rate.leak(), 3, "clock-implausible"),
            case(
                COUNT,
                by_three,
                by_rate_accepted.leak(),
                0,
                "clock-accepted",
            ),
        ],
    );
}

/// A rate that a person states decides where the file contradicts itself or that rate; a pass then waits until
/// the clock is accepted, and what was overridden is shown.
#[test]
fn verif_a_stated_rate_that_overrides_the_file_holds_back_a_pass() {
    const NO_STAMPS: &str = "Kopf,1\nSample rate (Hz),2500\nindex,ay (g)";
    const STAMPS: &str = "Kopf,1\nSample rate (Hz),7000\ntime (s),ay (g),az (g)";
    const Y: &[&str] = &["--channel", "ay (g)"];
    const BY_RATE: &[&str] = &[
        "--channel",
        "ay (g)",
        "--rate-hz",
        "5000",
        "--time-zero",
        "0.1",
        "--header-line",
        "3",
    ];
    const RATE: &[&str] = &["--channel", "ay (g)", "--rate-hz", "5000"];
    let stamped: Row = |_, t, a| format!("{t:.4},{:.4},{:.4}", 0.16 * a, 0.03 * a);
    let by_one: Row = |index, _, a| format!("{index},{:.4}", 0.16 * a);
    let accepted = |options: &[&'static str]| [options, &["--accept", "clock"]].concat();
    let cases = [
        case(
            NO_STAMPS,
            by_one,
            BY_RATE,
            3,
            "is `2500`, but the stated rate gives 5000 Hz",
        ),
        case(
            NO_STAMPS,
            by_one,
            accepted(BY_RATE).leak(),
            0,
            "clock-accepted",
        ),
        case(STAMPS, stamped, Y, 4, "state --rate-hz 5000"),
        case(
            STAMPS,
            stamped,
            RATE,
            3,
            "is `7000`, but the time column `time (s)` gives 5000 Hz",
        ),
        case(STAMPS, stamped, accepted(RATE).leak(), 0, "clock-accepted"),
    ];
    check_cases("overridden-clocks", &cases);
}

/// Whether gravity is in the samples, said in a row above the names.
#[test]
fn verif_rows_above_the_names_say_that_gravity_is_in_the_samples() {
    let imu: Row = |index, t, a| {
        let noise = 0.01 * (index as f64 * 2.3).sin();
        format!("{t:.4},{noise:.3},{:.3},{:.3}", a, 1.0 + noise)
    };
    let mut cases = Vec::new();
    for (head, exit) in [
        ("Kopf,1\nRemark,samples include gravity,,", 4),
        ("Kopf,1\nGravity,in the signal,,", 4),
        ("Kopf,1\nSchwerkraft,ja,,", 4),
        ("# from sensor_msgs/msg/Imu on /imu", 4),
        ("Kopf,1\nGravity,removed,,", 0),
        ("Kopf,1\nGravity compensation,on,,", 0),
    ] {
        let head: &'static str =
            Box::leak(format!("{head}\ntime (s),ax (m/s2),ay (m/s2),az (m/s2)").into());
        cases.push(case(
            head,
            imu,
            &["--velocity-change", "2.6"],
            exit,
            "gravity-contradicts-unit",
        ));
    }
    check_cases("gravity-above", &cases);
}

/// Stamps of too few digits: rows that are missing show in them, and zeros at the begin do not hide them.
#[test]
fn verif_coarse_stamps_are_cut_or_rounded_alike() {
    const RATE: &[&str] = &["--rate-hz", "5000", "--time-zero", "0.1"];
    const LOST: &str = "rows are doubled or missing";
    check_cases(
        "coarse-stamps",
        &[
            case(
                "Time (ms),ay (g)",
                |i, _, a| format!("{},{a:.3}", i / 5),
                RATE,
                1,
                "stamps-coarse",
            ),
            case(
                "Time (s),ay (g)",
                |i, _, a| format!("{:.3},{a:.4}", (i / 5) as f64 / 1e3),
                RATE,
                1,
                "stamps-coarse",
            ),
            case(
                "Time (s),ay (g)",
                |i, _, a| format!("{:.3},{a:.3}", i as f64 / 5e3),
                RATE,
                1,
                "stamps-coarse",
            ),
            // 60 ms are missing, and tenths of a second would hide them if each were off by one.
            case(
                "Time (s),ay (g)",
                |i, _, a| format!("{:.1},{a:.3}", (lost(i) / 500) as f64 / 10.0),
                RATE,
                4,
                LOST,
            ),
            case(
                "Time,ay (g)",
                |i, _, a| format!("10:00:00.{},{a:.3}", lost(i) / 500),
                RATE,
                4,
                LOST,
            ),
            case(
                "Time (ms),ay (g)",
                |i, _, a| format!("{}00,{a:.3}", (lost(i) + 250) / 500),
                RATE,
                4,
                LOST,
            ),
        ],
    );
}

/// The row of a table from which 60 ms were taken out.
fn lost(index: usize) -> usize {
    index + if index < 700 { 0 } else { 300 }
}

/// Two places that state one clock confirm it, so that a fast one needs no word.
#[test]
fn verif_a_clock_that_a_table_states_twice_needs_no_word() {
    let folder = Folder::new("clock-stated-twice");
    let table = |head: &str, clock: fn(f64) -> String| {
        let mut text = format!("{head}\n");
        for index in 0..20_480 {
            let t = f64::from(index) / 51_200.0 - 0.1;
            let a = half_sine(t, 0.0, 0.08, 8.0) + 0.02 * (f64::from(index) * 1.7).sin();
            text += &format!("{}{t:.9},{a:.4}\n", clock(t));
        }
        text
    };
    let none: fn(f64) -> String = |_| String::new();
    for (head, clock, code) in [
        ("time (s),ay (g)", none, 3),
        ("Kopf,1\nSample rate,51.2 kHz\ntime (s),ay (g)", none, 0),
        (
            "Kopf,1\nScan interval (us),19.53125\ntime (s),ay (g)",
            none,
            0,
        ),
        // Nothing says whether it is kHz.
        ("Kopf,1\nSample rate,51.2\ntime (s),ay (g)", none, 3),
        // A frame whose index was made of the very column, so that one slip is in both.
        (",time (s),ay (g)", |t| format!("{t:.9},"), 3),
        ("index,time (s),ay (g)", |t| format!("{:.9},", t + 9.0), 3),
        (
            "elapsed (us),time (s),ay (g)",
            |t| format!("{:.3},", (t + 9.0) * 1e6),
            0,
        ),
        (
            "Uhrzeit,time (s),ay (g)",
            |t| format!("10:00:{:09.6},", t + 9.0),
            0,
        ),
    ] {
        let path = folder.write("a.csv", table(head, clock).as_bytes());
        let done = latchgate(&[
            "replay",
            &path,
            "--opens-when",
            "positive",
            "--no-report",
            "--members",
            "0",
            "--transfer",
            "1",
            "--set",
            "lever.preload_torque_nm=2.82",
            "--time-column",
            "time (s)",
        ]);
        assert_eq!(done.code, code, "{head:?}: {}{}", done.out, done.err);
    }
}

/// Exports of oscilloscopes whose names are units, and what stands behind a table: the way on keeps what the file
/// says of itself.
#[test]
fn cli_the_way_on_keeps_what_a_table_states() {
    const VOLTS: &[&str] = &["--channel", "2", "--sensitivity", "1 g/V"];
    const SI: &[&str] = &["--channel", "2", "--unit", "m/s2"];
    const PAIR: &str = "X,CH1,Start,Increment\nSequence,Volt,-1.0e-1,2.0e-4";
    let counted: Row = |index, _, a| format!("{index},{a:.3}");
    check_cases(
        "way-on",
        &[
            case(
                "Model,A\nHorizontal Units,s\nVertical Units,V\nSample Interval,0.0002\nSecond,Volt",
                true_g,
                VOLTS,
                1,
                "preamble",
            ),
            case(
                "Model,A\nVertical Units,V\nSample Interval,0.0002\nSecond,Value",
                true_g,
                SI,
                4,
                "--sensitivity '20 g/V'",
            ),
            case(
                "Model,A\nSample Interval,0.0002\nsec,Volts",
                fast,
                VOLTS,
                4,
                "time-contradicted",
            ),
            case(
                "Model,A\nSample Interval,0.0002\nms,mV",
                |_, t, a| format!("{:.1},{:.1}", t * 1e3, a * 1e3),
                VOLTS,
                1,
                "preamble",
            ),
            case(PAIR, counted, &[], 4, "--skip-lines 2"),
            case(
                PAIR,
                counted,
                &[
                    "--skip-lines",
                    "2",
                    "--rate-hz",
                    "5000",
                    "--channel",
                    "2",
                    "--unit",
                    "m/s2",
                ],
                4,
                "--sensitivity '20 g/Volt'",
            ),
            case(
                PAIR,
                counted,
                &[
                    "--skip-lines",
                    "2",
                    "--rate-hz",
                    "50000",
                    "--channel",
                    "2",
                    "--sensitivity",
                    "1 g/V",
                ],
                3,
                "clock-implausible",
            ),
            case(
                PAIR,
                counted,
                &[
                    "--skip-lines",
                    "2",
                    "--rate-hz",
                    "5000",
                    "--channel",
                    "2",
                    "--sensitivity",
                    "1 g/V",
                ],
                1,
                "time-zero-shown",
            ),
            case(
                "Time,ay (g)",
                |index, _, a| format!("20240501100000.{:06},{a:.3}", 200 * index),
                &["--rate-hz", "50000"],
                4,
                "2024-05-01T10:00:00.0001",
            ),
            case(
                "time (s),ay (V)",
                true_g,
                &["--sensitivity", "0,05 V/g"],
                2,
                "0.05 V/g",
            ),
            case(
                "time (s),ay (g)",
                |index, t, a| {
                    if index < 2000 {
                        true_g(index, t, a)
                    } else {
                        "NaN,NaN".into()
                    }
                },
                &[],
                4,
                "--last-line 2001",
            ),
            case(
                "time (s),ay (g)",
                |index, t, a| {
                    if index < 2000 {
                        true_g(index, t, a)
                    } else {
                        "0,0".into()
                    }
                },
                &[],
                4,
                "--last-line 2001",
            ),
            case(
                "time (s),ay (g)",
                |index, t, a| {
                    if index < 2000 {
                        true_g(index, t, a)
                    } else {
                        "-1,50.1".into()
                    }
                },
                &[],
                4,
                "--last-line 2001",
            ),
        ],
    );
}
