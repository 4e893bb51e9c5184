//! Sixty exports as programs of laboratories and loggers write them: each is answered, or asks for
//! one thing at a time with a setting or a command that then works. The file is never touched.

use crate::support::{Folder, latchgate};
use std::fmt::Write as _;

/// What is in one export.
#[derive(Clone, Copy)]
struct Variant {
    rate_hz: f64,
    /// Whether samples are in m/s² instead of g.
    si: bool,
    /// Whether another channel stands beside.
    beside: bool,
}

/// What the person who exported the file knows of it.
struct Known {
    channel: &'static str,
    unit: &'static str,
    time_column: &'static str,
    time_unit: &'static str,
}

struct Style {
    name: &'static str,
    /// The lines above the samples, for a unit and with or without another channel.
    head: fn(unit: &str, beside: bool) -> String,
    separator: char,
    decimal_comma: bool,
    /// Stamps per second, and their decimals.
    clock: (f64, usize),
    quoted: bool,
    known: Known,
}

fn sample(t: f64) -> f64 {
    let pulse = if (0.0..0.02).contains(&t) {
        30.0 * (std::f64::consts::PI * t / 0.02).sin()
    } else {
        0.0
    };
    pulse + 0.05 * (9_100.0 * t).sin() + 0.03 * (23_000.0 * t + 1.0).sin()
}

impl Style {
    fn text(&self, variant: Variant) -> String {
        let unit = match (variant.si, self.known.unit) {
            (true, _) => "m/s^2",
            (false, unit) => unit,
        };
        let mut text = (self.head)(unit, variant.beside);
        let si = variant.si || !self.known.unit.eq_ignore_ascii_case("g");
        let factor = if si { 9.806_65 } else { 1.0 };
        for row in -200..600 {
            let t = f64::from(row) / variant.rate_hz;
            let (per_second, decimals) = self.clock;
            let mut cells = vec![format!("{:.decimals$}", t * per_second)];
            cells.push(format!("{:.4}", sample(t) * factor));
            if variant.beside {
                cells.push(format!("{:.4}", 0.1 * sample(t) - 1.0));
            }
            if self.quoted {
                cells = cells.iter().map(|cell| format!("\"{cell}\"")).collect();
            }
            let line = cells.join(&self.separator.to_string());
            let line = if self.decimal_comma {
                line.replace('.', ",")
            } else {
                line
            };
            writeln!(text, "{line}").unwrap();
        }
        text
    }
}

const KNOWN: Known = Known {
    channel: "Door Y",
    unit: "g",
    time_column: "Time",
    time_unit: "s",
};

fn styles() -> Vec<Style> {
    let plain = |name, head| Style {
        name,
        head,
        separator: ',',
        decimal_comma: false,
        clock: (1.0, 7),
        quoted: false,
        known: KNOWN,
    };
    vec![
        plain("dewesoft", |unit, beside| {
            let more = if beside { ",AI 2 (V)" } else { "" };
            format!(
                "Dewesoft text export\nFile name:,C:\\data\\sled_07.dxd\nStart time:,2024-05-01 10:00:00\n\
                 Sample rate:,10000,Hz\nChannels:,2\n\nTime (s),Door Y ({unit}){more}\n"
            )
        }),
        Style {
            separator: '\t',
            decimal_comma: true,
            known: Known {
                channel: "Tür quer",
                time_column: "Zeit  1 - Standardmessrate",
                ..KNOWN
            },
            ..plain("catman", |unit, beside| {
                let more = if beside {
                    ("\tDMS 2", "\tµm/m")
                } else {
                    ("", "")
                };
                format!(
                    "DATEINAME:\tsled_07.bin\nT0:\t01.05.2024 10:00:00\nANZAHL KANÄLE:\t2\n\
                     MAXIMALE LÄNGE:\t800\nOPERATOR:\tA. B.\n\nZeit  1 - Standardmessrate\tTür quer{}\n\
                     s\t{unit}{}\n",
                    more.0, more.1
                )
            })
        },
        plain("slice", |unit, beside| {
            let more = if beside {
                (",Belt force", ",(N)")
            } else {
                ("", "")
            };
            format!(
                "Test ID:,T07\nTest date:,2024-05-01\nData channels:,1\nSample rate (Hz):,10000\n\
                 Pre-trigger samples:,200\n\nTime,Door Y{}\n(s),({unit}){}\n",
                more.0, more.1
            )
        }),
        Style {
            separator: ';',
            ..plain("kistler", |unit, beside| {
                let more = if beside { ";Fz [N]" } else { "" };
                format!(
                    "[2024-05-01 10:00:00] jBEAM export\nTitle;Sled 07\nOperator;A. B.\n\
                     Number of values;800\n\nTime [s];Door Y [{unit}]{more}\n"
                )
            })
        },
        Style {
            separator: '\t',
            clock: (1e3, 4),
            known: Known {
                channel: "Shimmer_1_Accel_WR_Y_CAL",
                unit: "m/(s^2)",
                time_column: "Shimmer_1_Timestamp_Unix_CAL",
                time_unit: "ms",
            },
            ..plain("shimmer", |unit, beside| {
                let more = if beside {
                    ("\tShimmer_1_Temp_CAL", "\tDegC")
                } else {
                    ("", "")
                };
                format!(
                    "sep=\t\nShimmer_1_Timestamp_Unix_CAL\tShimmer_1_Accel_WR_Y_CAL{}\nms\t{unit}{}\n",
                    more.0, more.1
                )
            })
        },
        Style {
            quoted: true,
            known: Known {
                channel: "G Force Lat",
                unit: "G",
                ..KNOWN
            },
            ..plain("motec", |unit, beside| {
                let more = if beside {
                    (",\"Ground Speed\"", ",\"km/h\"")
                } else {
                    ("", "")
                };
                format!(
                    "\"Format\",\"MoTeC CSV File\"\n\"Venue\",\"Crash hall\"\n\"Vehicle\",\"Sled 07\"\n\
                     \"Sample Rate\",\"10000\",\"Hz\"\n\"Duration\",\"0.08\",\"s\"\n\n\
                     \"Time\",\"G Force Lat\"{}\n\"s\",\"{unit}\"{}\n\n",
                    more.0, more.1
                )
            })
        },
        Style {
            clock: (1e9, 0),
            known: Known {
                channel: "inertial-6284:scaledAccelY",
                time_column: "Time",
                time_unit: "ns",
                ..KNOWN
            },
            ..plain("sensorconnect", |_, beside| {
                let more = if beside {
                    ",inertial-6284:estPitch"
                } else {
                    ""
                };
                format!(
                    "FILE_INFO\nType,Data\nVersion,1.2\n;;\nSESSION_INFO\nName,sled 07\nTimestamp,100000000\n;;\n\
                     DATA_START\nTime,inertial-6284:scaledAccelY{more}\n"
                )
            })
        },
        plain("described", |unit, beside| {
            let more = if beside {
                (",Belt", ",kN", ",shoulder belt")
            } else {
                ("", "", "")
            };
            format!(
                "Time,Door Y{}\ns,{unit}{}\nfrom trigger,\"left front, inner panel\"{}\n",
                more.0, more.1, more.2
            )
        }),
        Style {
            known: Known {
                channel: "acc",
                time_column: "time",
                ..KNOWN
            },
            ..plain("plain", |_, beside| {
                let more = if beside { ",speed" } else { "" };
                format!("time,acc{more}\n")
            })
        },
        Style {
            separator: ';',
            decimal_comma: true,
            known: Known {
                channel: "Beschl. quer",
                time_column: "Zeit",
                ..KNOWN
            },
            ..plain("european", |unit, beside| {
                let more = if beside { ";Kraft [N]" } else { "" };
                format!("Zeit [s];Beschl. quer [{unit}]{more}\n")
            })
        },
        Style {
            separator: ';',
            clock: (1e3, 4),
            known: Known {
                channel: "Door striker Y",
                time_column: "t",
                time_unit: "ms",
                ..KNOWN
            },
            ..plain("spreadsheet", |unit, beside| {
                let more = if beside { ";Temp 1 (°C)" } else { "" };
                format!("Sled 07;;\nCreated by;A. B.;\n;;\nt (ms);Door striker Y ({unit}){more}\n")
            })
        },
        Style {
            clock: (1e9, 0),
            known: Known {
                channel: "a_RS_S_y",
                unit: "m s^-2",
                time_column: "timestamp [ns]",
                time_unit: "ns",
            },
            ..plain("ros", |unit, beside| {
                let more = if beside { ",w_RS_S_y [rad s^-1]" } else { "" };
                format!("#timestamp [ns],a_RS_S_y [{unit}]{more}\n")
            })
        },
    ]
}

/// Returns the words of a printed command, quotes taken off.
fn words(command: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut quoted = false;
    for letter in command.chars() {
        match letter {
            '\'' => quoted = !quoted,
            ' ' if !quoted => words.push(String::new()),
            other => words.last_mut().unwrap().push(other),
        }
    }
    words
}

/// Returns the question with what a message asks for, from the message alone but for the names,
/// units and rates that only the person who made the file knows.
fn advised(question: &[String], message: &str, known: &Known, rate_hz: f64) -> Option<Vec<String>> {
    let asks = |option: &str| {
        let option = format!("--{option} ");
        message.split_once(&option).map(|(_, rest)| {
            let value = rest.split([' ', ',', ';', '\n']).next().unwrap_or_default();
            value.to_string()
        })
    };
    let with = |option: &str, value: &str| {
        let mut question = question.to_vec();
        question.extend([format!("--{option}"), value.to_string()]);
        Some(question)
    };
    let command = message
        .lines()
        .filter_map(|line| line.strip_prefix("  choose: latchgate "))
        .find(|line| line.contains(known.channel));
    if let Some(command) = command {
        // The shape and the doubt stand behind two blanks.
        let command = command
            .split_once("  ")
            .map_or(command, |(command, _)| command);
        let mut words = words(command);
        if let Some(at) = words.iter().position(|word| word == "--format") {
            words.drain(at..at + 2);
        }
        return Some(words);
    }
    for option in ["header-line", "skip-lines"] {
        if let Some(value) = asks(option) {
            assert!(value.parse::<u32>().is_ok(), "{message}");
            return with(option, &value);
        }
    }
    if asks("time-unit").is_some() {
        return with("time-unit", known.time_unit);
    }
    if asks("unit").is_some() {
        let unit = if known.unit == "g" || known.unit == "G" {
            "g"
        } else {
            "m/s2"
        };
        return with("unit", unit);
    }
    if asks("time-column").is_some() {
        return with("time-column", known.time_column);
    }
    if asks("decimal").is_some() {
        return with("decimal", ".");
    }
    asks("rate-hz")?;
    with("rate-hz", &rate_hz.to_string())
}

#[track_caller]
fn check_answered(folder: &Folder, style: &Style, index: usize, text: &[u8], variant: Variant) {
    let path = folder.write(&format!("{}-{index}.csv", style.name), text);
    let mut question: Vec<String> = [
        "replay",
        &path,
        "--opens-when",
        "negative",
        "--no-report",
        "--members",
        "0",
        "--accept",
        "clock",
        "--transfer",
        "1",
    ]
    .map(String::from)
    .to_vec();
    let mut told = String::new();
    for _ in 0..=4 {
        let arguments: Vec<&str> = question.iter().map(String::as_str).collect();
        let done = latchgate(&[&arguments[..], &["--format", "json"]].concat());
        assert_ne!(done.code, 2, "{}-{index}: {told}{}", style.name, done.err);
        if done.code != 4 {
            let document = done.document();
            let recording = &document["recording"];
            assert_eq!(done.code, 0, "{}-{index}: {told}{}", style.name, done.out);
            assert_eq!(recording["samples"], 800, "{}-{index}: {told}", style.name);
            let rate = recording["sample_rate_hz"].as_f64().unwrap();
            assert!((rate / variant.rate_hz - 1.0).abs() < 1e-6, "{rate} {told}");
            let peak = recording["peak_g"].as_f64().unwrap();
            assert!(
                (peak.abs() - 30.0).abs() < 0.2,
                "{}-{index}: {peak} {told}",
                style.name
            );
            return;
        }
        told += &format!("{question:?}\n{}\n", done.err);
        let next = advised(&question, &done.err, &style.known, variant.rate_hz);
        question = next.unwrap_or_else(|| panic!("{}-{index}: no way on\n{told}", style.name));
    }
    panic!("{}-{index}: more than four questions\n{told}", style.name);
}

/// 12 styles with 5 variants each.
#[test]
fn cli_sixty_exports_are_answered_by_following_what_is_asked() {
    let folder = Folder::new("exports");
    let base = Variant {
        rate_hz: 10_000.0,
        si: false,
        beside: false,
    };
    for style in styles() {
        let plain = style.text(base);
        let beside = Variant {
            beside: true,
            ..base
        };
        // A file without a unit has none to change.
        let other = Variant {
            rate_hz: 12_500.0,
            si: !matches!(style.name, "plain" | "sensorconnect"),
            ..base
        };
        let marked: Vec<u8> = ("\u{feff}".to_string() + &plain)
            .encode_utf16()
            .flat_map(u16::to_le_bytes)
            .collect();
        let variants: [(Vec<u8>, Variant); 5] = [
            (plain.replace('\n', "\r\n").into(), base),
            (plain.trim_end().into(), base),
            (style.text(beside).into(), beside),
            (style.text(other).into(), other),
            (marked, base),
        ];
        for (index, (text, variant)) in variants.iter().enumerate() {
            check_answered(&folder, &style, index, text, *variant);
        }
    }
}
