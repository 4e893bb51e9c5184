//! Text tables, their time bases and their cards: what is read, and that it is read exactly.

use crate::support::{Random, data};
use latchgate_document::request::Request;
use latchgate_kernel::error::Error as KernelError;
use latchgate_kernel::units::{
    AccelerationUnit, DecimalMark, SampleRate, SensorSensitivity, TimeUnit,
};
use latchgate_recording::error::ErrorKind;
use latchgate_recording::time_base::TimeBase;
use latchgate_recording::{
    self, Card, Channel, Limits, ReadOptions, Recording, Selection, Severity, Source, card,
};
use std::fmt::Write as _;
use std::path::PathBuf;

/// Reads bytes as a recording, as a command would.
pub(crate) fn read_table(
    bytes: impl Into<Vec<u8>>,
    options: &ReadOptions,
    selection: Selection,
) -> Result<Recording, latchgate_recording::error::Error> {
    let source = Source::bytes("table.csv", bytes.into());
    latchgate_recording::read(&source, options, selection, &Limits::default())
}

fn with_unit(unit: AccelerationUnit) -> ReadOptions {
    ReadOptions {
        unit: Some(unit),
        ..ReadOptions::default()
    }
}

fn in_g() -> ReadOptions {
    with_unit(AccelerationUnit::StandardGravity)
}

#[track_caller]
fn check_channel(bytes: impl Into<Vec<u8>>, options: &ReadOptions) -> Channel {
    let recording = read_table(bytes, options, Selection::Lateral).unwrap();
    assert_eq!(recording.channels.len(), 1);
    recording.channels.into_iter().next().unwrap()
}

#[track_caller]
fn check_codes(text: &str, options: &ReadOptions, expected: &[&str]) {
    let recording = read_table(text, options, Selection::Lateral).unwrap();
    let mut codes: Vec<&str> = recording
        .findings
        .iter()
        .chain(&recording.channels[0].findings)
        .map(|finding| &*finding.code)
        .collect();
    codes.sort_unstable();
    assert_eq!(codes, expected, "{text:?}");
}

/// One way of writing a table.
#[derive(Debug, Clone, Copy)]
struct Dialect {
    separator: &'static str,
    decimal: char,
    header: Header,
    encoding: Encoding,
    newline: &'static str,
    ends_with_newline: bool,
    trailing_separator: bool,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Header {
    None,
    Names,
    UnitsInCells,
    UnitsRow,
    Quoted,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Encoding {
    Utf8,
    Utf8Marked,
    Utf16Little,
    Utf16Big,
    Windows1252,
}

impl Dialect {
    fn write(self, samples: &[f64]) -> Vec<u8> {
        let join = |cells: [String; 2]| {
            let mut line = cells.join(self.separator);
            if self.trailing_separator {
                line.push_str(self.separator);
            }
            line.push_str(self.newline);
            line
        };
        let row = |cells: [&str; 2]| join(cells.map(ToString::to_string));
        let mut text = format!("# gemessen bei 21 °C, unit m/s2{}", self.newline);
        match self.header {
            Header::None => {}
            Header::Names => text.push_str(&row(["time", "ay"])),
            Header::UnitsInCells => text.push_str(&row(["time_s", "ay[g]"])),
            Header::UnitsRow => text.push_str(&(row(["Zeit", "ay"]) + &row(["s", "[g]"]))),
            Header::Quoted => text.push_str(&row(["\"Time (s)\"", "\"acc, lateral (g)\""])),
        }
        for (index, sample) in samples.iter().enumerate() {
            let stamp = format!("{:.4}", (index as f64 - 20.0) * 1e-4);
            text.push_str(&join(
                [stamp, format!("{sample:.3}")]
                    .map(|number| number.replace('.', &self.decimal.to_string())),
            ));
            if index == 3 {
                text.push_str(self.newline);
                write!(text, "  # a remark{}", self.newline).unwrap();
            }
        }
        if !self.ends_with_newline {
            text.truncate(text.len() - self.newline.len());
        }
        match self.encoding {
            Encoding::Utf8 => text.into_bytes(),
            Encoding::Utf8Marked => format!("\u{feff}{text}").into_bytes(),
            Encoding::Utf16Little => format!("\u{feff}{text}")
                .encode_utf16()
                .flat_map(u16::to_le_bytes)
                .collect(),
            Encoding::Utf16Big => format!("\u{feff}{text}")
                .encode_utf16()
                .flat_map(u16::to_be_bytes)
                .collect(),
            Encoding::Windows1252 => text.chars().map(|c| u8::try_from(c).unwrap()).collect(),
        }
    }
}

#[track_caller]
fn check_dialect(dialect: Dialect) {
    let samples: Vec<f64> = (0..80)
        .map(|i| f64::from((i * 37) % 41 - 20) / 8.0)
        .collect();
    let stated = matches!(
        dialect.header,
        Header::UnitsInCells | Header::UnitsRow | Header::Quoted
    );
    let unnamed = dialect.header == Header::None;
    let options = ReadOptions {
        skip_lines: unnamed.then_some(1),
        time_column: unnamed.then(|| "1".into()),
        ..if stated {
            ReadOptions::default()
        } else {
            in_g()
        }
    };
    let channel = match read_table(dialect.write(&samples), &options, Selection::Lateral) {
        Ok(recording) => recording.channels.into_iter().next().unwrap(),
        Err(error) => panic!("{dialect:?}: {error}"),
    };
    assert_eq!(channel.values, samples, "{dialect:?}");
    assert_eq!(channel.rate.hertz(), 10_000.0, "{dialect:?}");
    assert_eq!(channel.start_s, -0.002, "{dialect:?}");
    assert_eq!(channel.unit, Some(AccelerationUnit::StandardGravity));
    let source = match dialect.header {
        Header::None | Header::Names => "option",
        Header::UnitsRow => "units row",
        Header::UnitsInCells | Header::Quoted => "header",
    };
    assert_eq!(channel.unit_source, source, "{dialect:?}");
}

/// Every way of writing gives the same samples, to the last bit.
#[test]
fn prop_every_dialect_reads_the_same() {
    let separators = [
        (",", '.'),
        (", ", '.'),
        (";", '.'),
        (";", ','),
        ("\t", '.'),
        ("\t", ','),
        ("  ", '.'),
        (" \t ", ','),
    ];
    let headers = [
        Header::None,
        Header::Names,
        Header::UnitsInCells,
        Header::UnitsRow,
        Header::Quoted,
    ];
    let encodings = [
        Encoding::Utf8Marked,
        Encoding::Utf16Little,
        Encoding::Utf16Big,
        Encoding::Windows1252,
    ];
    let mut endings = Vec::new();
    for newline in ["\n", "\r\n", "\r"] {
        for (ends_with_newline, trailing_separator) in [(true, false), (false, false), (true, true)]
        {
            endings.push((newline, ends_with_newline, trailing_separator));
        }
    }
    let mut count = 0;
    for (separator, decimal) in separators {
        for header in headers {
            // A quote opens a cell only where the cell begins.
            if header == Header::Quoted && separator == ", " {
                continue;
            }
            // All endings in UTF-8; each other encoding with one of them in turn.
            let plain = endings.iter().map(|ending| (Encoding::Utf8, *ending));
            let turned = encodings
                .iter()
                .enumerate()
                .map(|(i, encoding)| (*encoding, endings[(count + 2 * i) % endings.len()]));
            let cases: Vec<_> = plain.chain(turned).collect();
            for (encoding, (newline, ends_with_newline, trailing_separator)) in cases {
                check_dialect(Dialect {
                    separator,
                    decimal,
                    header,
                    encoding,
                    newline,
                    ends_with_newline,
                    trailing_separator,
                });
                count += 1;
            }
        }
    }
    assert_eq!(count, 39 * 13);
}

#[track_caller]
fn check_header(header: &str, unit: Option<AccelerationUnit>, time_scale: f64) {
    let mut text = format!("{header}\n");
    for i in 0..20 {
        writeln!(text, "{};{}", f64::from(i) * 2.5, i % 7).unwrap();
    }
    let recording = read_table(text, &ReadOptions::default(), Selection::Every)
        .unwrap_or_else(|error| panic!("{header}: {error}"));
    assert_eq!(recording.channels.len(), 1, "{header}");
    let channel = &recording.channels[0];
    assert_eq!(channel.unit, unit, "{header}");
    assert_eq!(channel.rate.hertz(), time_scale / 2.5, "{header}");
}

/// Spellings of names and units in header cells.
#[test]
fn val_units_in_header_cells() {
    use AccelerationUnit::{
        CentimetrePerSecondSquared, FootPerSecondSquared, InchPerSecondSquared,
        MetrePerSecondSquared, MilliStandardGravity, MillimetrePerMillisecondSquared,
        MillimetrePerSecondSquared, StandardGravity,
    };
    let (g, si) = (Some(StandardGravity), Some(MetrePerSecondSquared));
    for (header, unit, scale) in [
        ("Time (s);a (g)", g, 1.0),
        ("Time (ms);Acceleration y (m/s^2)", si, 1e3),
        ("time_ms;acc_y_g", g, 1e3),
        ("time_us;acceleration_m_s2", si, 1e6),
        ("t [ms];a [m/s²]", si, 1e3),
        ("t/s;a/g", g, 1.0),
        ("t / ms;a / m/s^2", si, 1e3),
        ("Zeit in ms;Beschleunigung in m/s²", si, 1e3),
        ("\"time, ms\";\"a, g\"", g, 1e3),
        ("Time ms;AC Y G'S", g, 1e3),
        ("milliseconds;a_mps2", si, 1e3),
        ("time;a (m/(s*s)) left", si, 1.0),
        ("time;a_mm_ms2", Some(MillimetrePerMillisecondSquared), 1.0),
        ("time;a {mm/s^2}", Some(MillimetrePerSecondSquared), 1.0),
        ("time;a_ft_s2", Some(FootPerSecondSquared), 1.0),
        // What could mean two things, or something else, states nothing.
        ("time;a_ms2", None, 1.0),
        ("time;v m/s", None, 1.0),
        ("time;a [mV]", None, 1.0),
        ("time;a (g) or (m/s2)", None, 1.0),
        ("time;mass (kg)", None, 1.0),
        ("time;g", None, 1.0),
        ("time;a (mg)", Some(MilliStandardGravity), 1.0),
        ("time;a_cm_s2", Some(CentimetrePerSecondSquared), 1.0),
        ("time;a (in/s^2)", Some(InchPerSecondSquared), 1.0),
    ] {
        check_header(header, unit, scale);
    }
}

#[track_caller]
fn check_choice(header: &str, expected: Result<&str, fn(&ErrorKind) -> bool>) {
    let columns = header.split(',').count();
    let mut text = format!("{header}\n");
    for i in 0..20 {
        let cells: Vec<String> = (0..columns)
            .map(|column| format!("{:.3}", f64::from(i) * 0.001 * (column as f64 + 1.0)))
            .collect();
        text.push_str(&(cells.join(",") + "\n"));
    }
    match (read_table(text, &in_g(), Selection::Lateral), expected) {
        (Ok(recording), Ok(name)) => assert_eq!(recording.channels[0].name, name, "{header}"),
        (Err(error), Err(is_expected)) => {
            assert!(is_expected(error.kind()), "{header}: {error}");
        }
        (Ok(recording), Err(_)) => panic!("{header}: chose {}", recording.channels[0].name),
        (Err(error), Ok(_)) => panic!("{header}: {error}"),
    }
}

/// The lateral acceleration is chosen where one name says so, and never otherwise.
#[test]
fn val_choice_of_the_lateral_channel() {
    let ambiguous: fn(&ErrorKind) -> bool =
        |kind| matches!(kind, ErrorKind::AmbiguousChannel { .. });
    let none: fn(&ErrorKind) -> bool = |kind| matches!(kind, ErrorKind::NoChannel { .. });
    for (header, expected) in [
        ("t,a", Ok("a")),
        ("t,sensor 7", Ok("sensor 7")),
        ("t,ax,ay,az", Ok("ay")),
        ("t,acc_x,acc_y,acc_z", Ok("acc_y")),
        ("t,accX,accY,accZ", Ok("accY")),
        ("t,Accel X,Accel Y,Accel Z", Ok("Accel Y")),
        ("t,long (g),Lateral (g)", Ok("Lateral (g)")),
        ("t,DSLF AC X,DSLF AC Y", Ok("DSLF AC Y")),
        (
            "t,linear_acceleration.y,angular_velocity.y,angular_acceleration.y",
            Ok("linear_acceleration.y"),
        ),
        (
            "t,13DOORLE0000ACXA,13DOORLE0000ACYA",
            Ok("13DOORLE0000ACYA"),
        ),
        ("sample,t,ay", Ok("ay")),
        ("t,acc_y_left,acc_y_right,acc_x", Err(ambiguous)),
        ("t,acc_x,acc_z", Err(ambiguous)),
        ("t,a (g),b (g)", Err(ambiguous)),
        ("t,y (mm),x (mm)", Err(none)),
    ] {
        check_choice(header, expected);
    }
}

const WIDE: &str = "time_s,acc_x_g,acc_y_g,ACC_Y_G\n0.000,1,2,3\n0.001,4,5,6\n0.002,7,8,9\n";

#[track_caller]
fn check_named(channel: &str, expected: &[f64]) {
    let options = ReadOptions {
        channel: Some(channel.into()),
        ..ReadOptions::default()
    };
    assert_eq!(check_channel(WIDE, &options).values, expected, "{channel}");
}

/// A channel is found by its name as it stands, without its unit, and by number.
#[test]
fn val_channel_by_name_and_number() {
    check_named("acc_x_g", &[1.0, 4.0, 7.0]);
    check_named("acc_x", &[1.0, 4.0, 7.0]);
    check_named(" Acc_X_G ", &[1.0, 4.0, 7.0]);
    check_named("acc_y_g", &[2.0, 5.0, 8.0]);
    check_named("ACC_Y_G", &[3.0, 6.0, 9.0]);
    check_named("3", &[2.0, 5.0, 8.0]);
    check_named("4", &[3.0, 6.0, 9.0]);
}

/// What is assumed or overridden is said.
#[test]
fn val_findings_of_the_reader() {
    let rows = "0.0000,1\n0.0001,2\n0.0002,3\n";
    let si = with_unit(AccelerationUnit::MetrePerSecondSquared);
    let none = ReadOptions::default();
    let in_ms = ReadOptions {
        time_unit: Some(TimeUnit::MILLISECOND),
        ..in_g()
    };
    check_codes(&format!("time_s,a_g\n{rows}"), &none, &[]);
    check_codes(&format!("time_s,a_g\n{rows}"), &in_g(), &[]);
    check_codes(&format!("time_s,a_g\n{rows}"), &si, &["unit-overridden"]);
    let of_volts = ReadOptions {
        sensitivity: SensorSensitivity::from_text("20 g/V").ok(),
        ..none.clone()
    };
    let volts = format!("time_s,a [mV]\n{rows}");
    check_codes(&volts, &of_volts, &["sensitivity-used"]);
    check_codes(&format!("time,a_g\n{rows}"), &none, &["time-unit-assumed"]);
    check_codes(
        &format!("time_s,acc_x_g\n{rows}"),
        &ReadOptions {
            channel: Some("acc_x_g".into()),
            ..ReadOptions::default()
        },
        &["channel-not-lateral"],
    );
    check_codes(
        "time_s;a_g\n0,0;1,5\n0,001;2,5\n",
        &none,
        &["decimal-comma"],
    );
    check_codes(
        "time,a_g\n0.0,1\n0.1,2\n0.2,3\n",
        &none,
        &["time-unit-assumed", "time-unit-implausible"],
    );
    check_codes(
        "time_s,a_g\n0,1\n5,2\n10,3\n",
        &none,
        &["time-unit-implausible"],
    );
    check_codes(
        "time_s,a_g\n0.0,1\n0.1,2\n0.2,3\n",
        &in_ms,
        &["time-unit-overridden"],
    );
}

/// Without a time column the rate is stated; a running number is no time.
#[test]
fn val_rate_beside_the_file() {
    let options = ReadOptions {
        rate_hz: Some(12_500.0),
        time_zero_s: Some(0.25),
        ..in_g()
    };
    let unnamed = |channel: Option<&str>| ReadOptions {
        skip_lines: Some(0),
        channel: channel.map(String::from),
        ..options.clone()
    };
    for (text, options) in [
        ("a\n1\n2\n3\n", &options),
        ("1\n2\n3\n", &unnamed(None)),
        ("index,a\n0,1\n1,2\n2,3\n", &options),
        (",a\n0,1\n1,2\n2,3\n", &options),
        ("0;1\n1;2\n2;3\n", &unnamed(Some("2"))),
    ] {
        let channel = check_channel(text, options);
        assert_eq!(channel.values, [1.0, 2.0, 3.0], "{text:?}");
        assert_eq!(channel.rate.hertz(), 12_500.0);
        assert_eq!(channel.start_s, -0.25);
    }
    // A rate that agrees with the time column does no harm.
    let agreeing = check_channel("t,a\n0.00000,1\n0.00008,2\n0.00016,3\n", &options);
    assert_eq!(agreeing.rate.hertz(), 12_500.0);
}

/// A header that does not fit its rows is left aside only where a person says so.
#[test]
fn val_header_mismatch_by_number() {
    let text = "time,acc,x,y\n0.000,1,2\n0.001,3,4\n0.002,5,6\n";
    let options = ReadOptions {
        channel: Some("3".into()),
        time_column: Some("1".into()),
        skip_lines: Some(1),
        ..in_g()
    };
    assert_eq!(check_channel(text, &options).values, [2.0, 4.0, 6.0]);
    check_codes(text, &options, &["time-unit-assumed"]);
}

/// Every numeric column, with and without unit, for those who only look.
#[test]
fn val_every_channel() {
    let text =
        "time_s,acc_x_g,note,speed (km/h),broken\n0.000,1,a,50,1\n0.001,2,b,49,x\n0.002,3,c,48,3\n";
    let recording = read_table(text, &ReadOptions::default(), Selection::Every).unwrap();
    let names: Vec<&str> = recording.channels.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["acc_x_g", "speed (km/h)"]);
    assert_eq!(recording.channels[1].unit, None);
    assert_eq!(recording.channels[1].values, [50.0, 49.0, 48.0]);
    let codes: Vec<&str> = recording.findings.iter().map(|f| &*f.code).collect();
    let notes = ["laboratory-remark"; 3];
    assert_eq!(codes, [&["channel-left-out"], &notes[..]].concat());
    assert!(
        recording.findings[0].text.contains("line 3, column 5"),
        "{:?}",
        recording.findings
    );

    let timeless =
        read_table("a,b\n1,2\n3,4\n", &ReadOptions::default(), Selection::Every).unwrap();
    assert!(timeless.channels.is_empty());
    assert_eq!(timeless.findings[0].code, "time-missing");
}

/// The exact double nearest to each printed number, whatever its spelling.
#[test]
fn val_spellings_of_numbers() {
    let spellings: [(&str, f64); 9] = [
        ("+1.0", 1.0),
        ("-1.94E0", -1.94),
        ("  -1.628164215E0", -1.628_164_215),
        (".5", 0.5),
        ("5.", 5.0),
        ("1e-3", 0.001),
        ("0.1000000000000000055511151231257827", 0.1),
        ("-0", -0.0),
        ("1e-400", 0.0),
    ];
    let mut text = "time_s,a_g\n".to_string();
    for (index, (spelling, _)) in spellings.iter().enumerate() {
        writeln!(text, "0.{index:03},{spelling}").unwrap();
    }
    let values = check_channel(text, &ReadOptions::default()).values;
    for ((spelling, expected), value) in spellings.iter().zip(values) {
        assert_eq!(value.to_bits(), expected.to_bits(), "{spelling}");
    }
}

// --- time bases ---

/// Samples brought to a uniform time base.
#[derive(Debug)]
struct Regular {
    start_s: f64,
    rate: SampleRate,
    values: Vec<f64>,
    findings: Vec<latchgate_recording::Finding>,
}

fn regularise(
    stamps_s: &[f64],
    values: Vec<f64>,
    printed_digit_s: f64,
) -> Result<Regular, latchgate_recording::error::Error> {
    let base = TimeBase::fit(stamps_s, printed_digit_s, &Limits::default())?;
    let values = base.apply(stamps_s, values)?;
    Ok(Regular {
        start_s: base.start_s,
        rate: base.rate,
        values,
        findings: base.findings,
    })
}

#[track_caller]
fn check_uniform(stamps: &[f64], digit: f64, rate: f64, start: f64) {
    let values: Vec<f64> = (0..stamps.len()).map(|i| i as f64).collect();
    let Regular {
        start_s,
        rate: found,
        values: kept,
        findings,
    } = regularise(stamps, values.clone(), digit).unwrap();
    assert!(findings.is_empty(), "{findings:?}");
    assert_eq!(found.hertz(), rate, "found {:?}", found.hertz());
    assert_eq!(kept, values);
    assert!(
        (start_s - start).abs() <= 0.5 * digit + 1e-15,
        "start {start_s}"
    );
}

fn rounded(value: f64, decimals: usize) -> f64 {
    format!("{value:.decimals$}").parse().unwrap()
}

/// Clocks of common rates, printed with few digits, come out exact.
#[test]
fn prop_rounded_stamps_give_the_exact_rate() {
    let seed = 7;
    let mut random = Random(seed);
    for rate in [
        9600.0, 10_000.0, 12_000.0, 12_500.0, 1024.0, 20_000.0, 51_200.0, 4_096.0,
    ] {
        for decimals in [6, 7, 9] {
            for _ in 0..20 {
                let count = 600 + random.below(4000);
                let first = random.below(2000) as f64 - 1500.0;
                let stamps: Vec<f64> = (0..count)
                    .map(|i| rounded((first + i as f64) / rate, decimals))
                    .collect();
                let digit: f64 = format!("1e-{decimals}").parse().unwrap();
                check_uniform(&stamps, digit, rate, first / rate);
            }
        }
    }
}

/// The same through text, where the printed digit is read off the stamps.
#[test]
fn prop_rounded_stamps_in_text_give_the_exact_rate() {
    for (rate, unit, scale, decimals) in [
        (9600.0, "s", 1.0, 6),
        (12_000.0, "s", 1.0, 6),
        (12_000.0, "ms", 1e3, 3),
        (12_500.0, "ms", 1e3, 2),
        (10_000.0, "us", 1e6, 0),
        (9600.0, "s", 1.0, 4),
    ] {
        let mut text = format!("time ({unit}),a (g)\n");
        for i in 0..3000 {
            let stamp = f64::from(i) / rate * scale;
            writeln!(text, "{stamp:.decimals$},{}", i % 5).unwrap();
        }
        let channel = check_channel(text, &ReadOptions::default());
        assert_eq!(channel.rate.hertz(), rate, "{rate} in {unit}");
        assert_eq!(channel.start_s, 0.0);
        assert!(channel.findings.is_empty(), "{:?}", channel.findings);
        assert_eq!(channel.values.len(), 3000);
    }
}

/// Stamps of an accumulated sum and of a trembling clock are uniform within 1 %.
#[test]
fn prop_a_trembling_clock_is_uniform() {
    let mut random = Random(11);
    let mut sum = 0.0;
    let accumulated: Vec<f64> = (0..20_000)
        .map(|_| {
            let stamp = sum;
            sum += 1e-4;
            stamp
        })
        .collect();
    check_uniform(&accumulated, 0.0, 10_000.0, 0.0);
    let trembling: Vec<f64> = (0..5000)
        .map(|i| f64::from(i) * 1e-4 + (random.unit() - 0.5) * 1e-6)
        .collect();
    let regular = regularise(&trembling, vec![0.0; 5000], 0.0).unwrap();
    assert!(regular.findings.is_empty());
    assert_eq!(regular.rate.hertz(), 10_000.0);
}

/// A rate that no short number gives comes out of the least squares.
#[test]
fn val_an_odd_rate_is_kept() {
    let rate = 9_999.123_456_7;
    let stamps: Vec<f64> = (0..200_000).map(|i| f64::from(i) / rate).collect();
    let regular = regularise(&stamps, vec![0.0; 200_000], 0.0).unwrap();
    assert!(
        (regular.rate.hertz() / rate - 1.0).abs() < 1e-12,
        "{:?}",
        regular.rate
    );
}

/// A missing row is a gap, even where the stamps have so few digits that a slightly slower
/// clock would explain them.
#[test]
fn val_missing_rows_are_gaps() {
    for missing in [1_usize, 2, 40] {
        let kept = |i: &usize| *i < 1000 || *i >= 1000 + missing;
        let indices: Vec<usize> = (0..3000).filter(kept).collect();
        let stamps: Vec<f64> = indices.iter().map(|i| *i as f64 / 1e4).collect();
        let values: Vec<f64> = indices.iter().map(|i| *i as f64).collect();
        for digit in [1e-4, 1e-6, 0.0] {
            let regular = regularise(&stamps, values.clone(), digit).unwrap();
            assert_eq!(regular.rate.hertz(), 10_000.0);
            assert_eq!(regular.values.len(), 3000);
            for (index, value) in regular.values.iter().enumerate() {
                assert!((value - index as f64).abs() < 1e-9, "{index}: {value}");
            }
            let codes: Vec<_> = regular
                .findings
                .iter()
                .map(|f| (&*f.code, f.severity, f.at_s))
                .collect();
            assert_eq!(
                codes,
                [("gap", Severity::Blocking, Some(0.0999))],
                "digit {digit}"
            );
        }
    }
}

/// Samples that are there stay as they are when a gap beside them is filled.
#[test]
fn verif_filling_a_gap_moves_no_sample() {
    let mut random = Random(3);
    let rate = 12_000.0;
    let indices: Vec<usize> = (0..4000)
        .filter(|i| !(700..750).contains(i) && !(2000..2003).contains(i))
        .collect();
    let stamps: Vec<f64> = indices
        .iter()
        .map(|i| rounded(*i as f64 / rate, 6))
        .collect();
    let values: Vec<f64> = indices.iter().map(|_| random.unit()).collect();
    let regular = regularise(&stamps, values.clone(), 1e-6).unwrap();
    assert_eq!(regular.rate.hertz(), rate);
    for (index, value) in indices.iter().zip(values) {
        assert_eq!(regular.values[*index], value);
    }
    assert_eq!(regular.findings.len(), 1);
    assert!(
        regular.findings[0].text.starts_with("2 gaps"),
        "{}",
        regular.findings[0].text
    );
}

/// An irregular clock is interpolated: a straight line stays straight.
#[test]
fn verif_irregular_stamps_are_interpolated() {
    let mut random = Random(5);
    let mut stamp = -0.05;
    let stamps: Vec<f64> = (0..2000)
        .map(|_| {
            stamp += 1e-3 * (0.8 + 0.4 * random.unit());
            stamp
        })
        .collect();
    let values: Vec<f64> = stamps.iter().map(|s| 3.0 * s + 1.0).collect();
    let regular = regularise(&stamps, values, 1e-9).unwrap();
    assert_eq!(regular.findings[0].code, "time-irregular");
    assert_eq!(regular.findings[0].severity, Severity::Warning);
    assert!((regular.rate.hertz() - 1000.0).abs() < 20.0);
    assert_eq!(regular.start_s, stamps[0]);
    for (index, value) in regular.values.iter().enumerate() {
        let at = regular.start_s + index as f64 / regular.rate.hertz();
        assert!(at <= stamps[1999] + 1e-9);
        assert!((value - (3.0 * at + 1.0)).abs() < 1e-9, "{index}");
    }
}

/// Stamps that no clock could have written are refused, and none costs memory.
#[test]
fn val_stamps_that_are_refused() {
    let refused = |stamps: &[f64]| {
        regularise(stamps, vec![0.0; stamps.len()], 0.0)
            .unwrap_err()
            .kind()
            .clone()
    };
    assert!(matches!(
        refused(&[]),
        ErrorKind::Kernel(KernelError::TooShort { .. })
    ));
    assert!(matches!(
        refused(&[1.0]),
        ErrorKind::Kernel(KernelError::TooShort { .. })
    ));
    assert!(matches!(
        refused(&[1.0, 1.0]),
        ErrorKind::TimeNotIncreasing { .. }
    ));
    assert!(matches!(
        refused(&[1.0, 2.0, 0.5]),
        ErrorKind::TimeNotIncreasing { .. }
    ));
    assert!(matches!(
        refused(&[0.0, f64::NAN]),
        ErrorKind::Kernel(KernelError::NonFinite { .. })
    ));
    assert!(matches!(
        refused(&[f64::MIN, f64::MAX]),
        ErrorKind::Kernel(KernelError::NonFinite { .. })
    ));
    assert!(matches!(
        refused(&[0.0, 1e-4, 2e-4, 1e9]),
        ErrorKind::LimitExceeded { .. }
    ));
    assert!(matches!(
        refused(&[0.0, 1e-300, 2e-300, 1e300]),
        ErrorKind::LimitExceeded { .. } | ErrorKind::Kernel(KernelError::NonFinite { .. })
    ));
    assert!(regularise(&[0.0, 1.0], vec![0.0], 0.0).is_err());
}

/// Random stamps never panic, and what comes out is finite and within its span.
#[test]
fn prop_any_increasing_stamps_give_a_base() {
    let seed = 23;
    let mut random = Random(seed);
    for round in 0..3000 {
        let count = 2 + random.below(60);
        let exponent = random.below(24) as i32 - 12;
        let mut stamp = (random.unit() - 0.5) * 10_f64.powi(random.below(8) as i32 - 4);
        let mut stamps = vec![stamp];
        for _ in 1..count {
            let long = if random.below(12) == 0 { 30.0 } else { 1.0 };
            let next = stamp + long * (0.2 + random.unit()) * 10_f64.powi(exponent);
            if next > stamp {
                stamp = next;
                stamps.push(stamp);
            }
        }
        let digit = 10_f64.powi(random.below(20) as i32 - 14);
        let values = vec![1.0; stamps.len()];
        if let Ok(regular) = regularise(&stamps, values, digit) {
            assert!(
                regular.values.iter().all(|v| (v - 1.0).abs() < 1e-12),
                "seed {seed} round {round}"
            );
            let end = regular.start_s + (regular.values.len() - 1) as f64 / regular.rate.hertz();
            let span = stamps[stamps.len() - 1] - stamps[0];
            assert!(
                (end - stamps[stamps.len() - 1]).abs() <= 0.5 * span + digit,
                "seed {seed} round {round}"
            );
        } else {
            assert!(stamps.len() < 2, "seed {seed} round {round}: {stamps:?}");
        }
    }
}

// --- real recordings ---

/// NHTSA channel files as plain tables: two tab-separated columns, no header, seconds and g.
#[test]
fn val_nhtsa_channel_files() {
    for curve in ["038", "056", "145", "146", "147", "148", "149", "150"] {
        let path = data(&format!("recordings/nhtsa_v07292.{curve}"));
        let text = std::fs::read_to_string(&path).unwrap();
        let printed: Vec<f64> = text
            .lines()
            .map(|line| line.split('\t').nth(1).unwrap().trim().parse().unwrap())
            .collect();
        let recording = latchgate_recording::read(
            &Source::File(path),
            &ReadOptions {
                input_format: Some("csv".into()),
                skip_lines: Some(0),
                time_column: Some("1".into()),
                ..in_g()
            },
            Selection::Lateral,
            &Limits::default(),
        )
        .unwrap();
        let channel = &recording.channels[0];
        assert_eq!(channel.values, printed);
        assert_eq!(channel.values.len(), 4126);
        assert_eq!(channel.rate.hertz(), 12_500.0);
        assert_eq!(channel.start_s, -0.02);
        assert!(channel.findings.is_empty());
    }
}

/// Shocks with a comment line and a header without units.
#[test]
fn val_reference_shocks() {
    let mut files: Vec<PathBuf> = std::fs::read_dir(data("reference/signals"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    assert!(!files.is_empty());
    for path in files {
        let options = with_unit(AccelerationUnit::MetrePerSecondSquared);
        let first = std::fs::read_to_string(&path)
            .unwrap()
            .lines()
            .next()
            .unwrap()
            .to_string();
        let rate: f64 = first.rsplit_once("fs=").unwrap().1.trim().parse().unwrap();
        let recording = latchgate_recording::read(
            &Source::File(path),
            &options,
            Selection::Lateral,
            &Limits::default(),
        )
        .unwrap();
        assert_eq!(recording.channels[0].rate.hertz(), rate);
        assert_eq!(recording.channels[0].start_s, 0.0);
        assert!(recording.channels[0].findings.is_empty());
    }
}

// --- cards ---

#[track_caller]
fn check_card_refused(text: &str, fragment: &str) {
    let error = Card::from_toml(text).unwrap_err();
    assert!(error.to_string().contains(fragment), "{error}");
}

/// A full card, and what cards may not say.
#[test]
fn val_cards() {
    let full = Card::from_toml(
        "channel = 2\nunit = \"mm/ms2\"\nopens_when = \"both\"\nrate = 12500\nrange_g = 2000.0\nsynthetic = true\nsource = \"a\"\nlicence = \"b\"\nnotes = \"c\"\n",
    )
    .unwrap();
    assert_eq!(full.channel.as_deref(), Some("2"));
    assert_eq!(
        full.unit,
        Some(AccelerationUnit::MillimetrePerMillisecondSquared)
    );
    assert_eq!(full.opens_when.unwrap().polarities().len(), 2);
    assert_eq!((full.rate, full.range_g), (Some(12_500.0), Some(2000.0)));
    assert!(full.synthetic);
    assert_eq!(Card::from_toml("").unwrap(), Card::default());

    check_card_refused(
        "unit = \"g\"\nrage_g = 3",
        "line 2: unknown card key `rage_g`; did you mean `range_g`?",
    );
    assert_eq!(
        Card::from_toml("unit = \"G\"\nskip_lines = 3\ndecimal = \",\"").unwrap(),
        Card {
            unit: Some(AccelerationUnit::StandardGravity),
            skip_lines: Some(3),
            decimal: Some(DecimalMark::Comma),
            ..Card::default()
        }
    );
    check_card_refused("unit = \"G2\"", "unknown unit `G2`; did you mean `g`?");
    check_card_refused(
        "header_line = 0",
        "`header_line` to be a whole number from 1",
    );
    check_card_refused(
        "unit = 9.81",
        "line 1: expected `unit` to be a unit in quotes, found a float",
    );
    check_card_refused("opens_when = \"left\"", "unknown polarity `left`");
    check_card_refused(
        "range_g = 0",
        "range_g [g] must be finite and positive, found 0",
    );
    check_card_refused("range_g = nan", "must be finite and positive, found NaN");
    check_card_refused(
        "rate = -1.0",
        "sample rate [Hz] must be finite and positive",
    );
    check_card_refused(
        "rate = \"10 kHz\"",
        "expected `rate` to be a number without quotes, found a string",
    );
    check_card_refused(
        "synthetic = \"yes\"",
        "expected `synthetic` to be true or false",
    );
    check_card_refused("unit = \"g\"\nunit = \"g\"", "line 2");
    check_card_refused("[lever]\nmass = 1", "unknown card key `lever`");
    check_card_refused("unit =", "expected TOML");
}

/// A card fills what the options leave open, and nothing else.
#[test]
fn val_options_go_before_cards() {
    let card = Card::from_toml("channel = \"ay\"\nunit = \"g\"\nrate = 5000").unwrap();
    let open = Request::default().read_options(&card);
    assert_eq!(
        (open.channel.as_deref(), open.rate_hz),
        (Some("ay"), Some(5000.0))
    );
    let channel = check_channel("ax,ay\n1,2\n3,4\n", &open);
    assert_eq!(
        (channel.unit_source, channel.rate.hertz()),
        ("card", 5000.0)
    );

    let stated = Request {
        rate_hz: Some(1e4),
        unit: Some(AccelerationUnit::MetrePerSecondSquared),
        ..Request::default()
    }
    .read_options(&card);
    let channel = check_channel("ax,ay\n1,2\n3,4\n", &stated);
    assert_eq!((channel.unit_source, channel.rate.hertz()), ("option", 1e4));
}

/// The card beside a file is found by the file's full name.
#[test]
fn val_card_beside_a_file() {
    let folder = std::env::temp_dir().join(format!("latchgate-card-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let source = Source::File(folder.join("burst.csv"));
    let read = || card::read_beside(&source, &Limits::default());
    assert_eq!(read().unwrap(), None);
    std::fs::write(folder.join("burst.csv.toml"), "\u{feff}unit = \"g\"\n").unwrap();
    let (card, hash) = read().unwrap().unwrap();
    assert_eq!(card.unit, Some(AccelerationUnit::StandardGravity));
    assert_eq!(hash.len(), 64);
    std::fs::write(folder.join("burst.csv.toml"), b"notes = \"\xFF\"").unwrap();
    assert!(
        read()
            .unwrap_err()
            .to_string()
            .starts_with("burst.csv.toml:1: expected a card in UTF-8")
    );
    std::fs::write(folder.join("burst.csv.toml"), "\n\nunits = 3").unwrap();
    assert!(
        read()
            .unwrap_err()
            .to_string()
            .starts_with("burst.csv.toml:3: unknown card key `units`")
    );
    std::fs::write(folder.join("burst.csv.toml"), vec![b'#'; 2 << 20]).unwrap();
    assert!(matches!(
        read().unwrap_err().kind(),
        ErrorKind::LimitExceeded { .. }
    ));
    std::fs::remove_dir_all(&folder).unwrap();
    let bytes = Source::bytes("x", []);
    assert_eq!(card::read_beside(&bytes, &Limits::default()).unwrap(), None);
}
