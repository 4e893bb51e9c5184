//! ISO-MME tests: folders, archives and single channels.

mod odd;

use super::{Case, FROM, TO, good, push, refused};
use crate::support::{gzip_of, tar_of, zip_of};
use std::fmt::Write as _;

const CODE: &str = "11DOORLE0000ACYP";

fn value(k: i64) -> String {
    format!("{:.4}", push(k) * 9.806_65)
}

/// A channel file: its header and its values.
struct File {
    lines: Vec<(&'static str, String)>,
    rows: Vec<String>,
}

impl File {
    fn new() -> Self {
        let lines = [
            ("Test object number", "1"),
            ("Name of the channel", "Door, left: lower"),
            ("Channel code", CODE),
            ("Unit", "m/(s*s)"),
            ("Reference channel", "implicit"),
            ("Reference channel name", "NOVALUE"),
            ("Data status", "ok"),
            ("Pre-filter type", "2000"),
            ("Channel frequency class", "NOVALUE"),
            ("Channel amplitude class", "5000"),
            ("Sampling interval", "1.0E-4"),
            ("Time of first sample", "-2.0E-2"),
            ("Number of samples", "800"),
        ];
        Self {
            lines: lines.map(|(key, text)| (key, text.to_string())).to_vec(),
            rows: (FROM..TO).map(value).collect(),
        }
    }

    fn with(mut self, key: &'static str, text: &str) -> Self {
        match self.lines.iter_mut().find(|(known, _)| *known == key) {
            Some((_, old)) => *old = text.to_string(),
            None => self.lines.push((key, text.to_string())),
        }
        self
    }

    fn without(mut self, key: &str) -> Self {
        self.lines.retain(|(known, _)| *known != key);
        self
    }

    fn row(mut self, index: usize, text: &str) -> Self {
        self.rows[index] = text.into();
        self
    }

    fn text(&self) -> String {
        let mut text = String::new();
        for (key, value) in &self.lines {
            writeln!(text, "{key:<28}:{value}").unwrap();
        }
        text + &self.rows.join("\n") + "\n"
    }
}

/// The files of a test, with those of its channels.
fn files(channels: &[File]) -> Vec<(String, Vec<u8>)> {
    let mme = "Data format edition number  :1.6\nTest number                 :7\n";
    let mut list = format!("Number of channels          :{}\n", channels.len());
    let mut files = vec![("T7.mme".to_string(), mme.into())];
    for (number, channel) in (1..).zip(channels) {
        let code = &channel
            .lines
            .iter()
            .find(|(key, _)| *key == "Channel code")
            .unwrap()
            .1;
        writeln!(list, "Name of channel {number:03}         :{code} / x").unwrap();
        files.push((format!("Channel/T7.{number:03}"), channel.text().into()));
    }
    files.push(("Channel/T7.chn".to_string(), list.into()));
    files
}

/// One channel, opened by itself.
fn one(name: &str, file: &File) -> Case {
    lateral(good("t7.001", file.text()), name)
}

fn lateral(mut case: Case, name: &str) -> Case {
    case.name = name.into();
    case.channel(CODE).unit("m/s2", value)
}

/// A test as a folder.
fn folder(name: &str, channels: &[File]) -> Case {
    let mut case = lateral(good("-", ""), name).open("");
    case.files = files(channels);
    case
}

/// A test as a folder that is refused.
fn refused_folder(name: &str, channels: &[File], says: &[&str]) -> Case {
    let mut case = refused(name, "", says).open("");
    case.files = files(channels);
    case
}

/// A zip that holds one channel twice under the same name.
fn doubled_zip() -> Vec<u8> {
    let mut files = files(&[File::new()]);
    files.push(("Channel/T7.009".into(), File::new().text().into()));
    let mut bytes = zip_of(&files);
    let name = b"Channel/T7.009";
    for at in 0..bytes.len() - name.len() {
        if bytes[at..].starts_with(name) {
            bytes[at + name.len() - 1] = b'1';
        }
    }
    bytes
}

/// Tests A and B in one package, each with a lateral channel.
fn two_tests(folders: [&str; 2]) -> Vec<(String, Vec<u8>)> {
    let text = File::new().text();
    ["A", "B"]
        .into_iter()
        .zip(folders)
        .flat_map(|(stem, folder)| {
            [
                (format!("{folder}{stem}.mme"), b"Test number :7\n".to_vec()),
                (format!("{folder}{stem}.001"), text.clone().into_bytes()),
            ]
        })
        .collect()
}

/// Numbers in thousands of a small unit, with thousands marks.
fn thousands(k: i64, mark: char) -> String {
    let whole = (push(k) * 9_806.65).round() as i64;
    let (sign, whole) = (if whole < 0 { "-" } else { "" }, whole.abs());
    if whole < 1000 {
        format!("{sign}{whole}")
    } else {
        format!("{sign}{}{mark}{:03}", whole / 1000, whole % 1000)
    }
}

pub(super) fn cases() -> Vec<Case> {
    let mut cases = readings();
    cases.extend(odd::cases());
    cases
}

fn readings() -> Vec<Case> {
    let other = |code: &str| File::new().with("Channel code", code);
    let stamps = |from: &str| {
        let mut file = other("11TIRS000000TI00")
            .with("Unit", "s")
            .without("Pre-filter type");
        file.rows = (FROM..TO)
            .map(|k| format!("{:.4}", k as f64 / 1e4))
            .collect();
        file.with("Reference channel", from)
    };
    let explicit = || {
        File::new()
            .with("Reference channel", "explicit")
            .with("Reference channel name", "11TIRS000000TI00")
            .without("Sampling interval")
            .without("Time of first sample")
    };
    let of_itself = |interval: &str, first: &str| {
        explicit()
            .with("Sampling interval", interval)
            .with("Time of first sample", first)
    };
    let refused_text = |name: &str, text: String, says: &[&str]| {
        let mut case = refused("t7.001", text, says);
        case.name = name.into();
        case
    };
    let twice = |key: &'static str, text: &str| {
        let mut file = File::new();
        file.lines.push((key, text.into()));
        file
    };
    let cut_comment = |pieces: &[&str]| {
        let mut file = File::new();
        for piece in pieces {
            file.lines.push(("Comments", (*piece).into()));
        }
        file
    };
    let said = |name: &str, file: &File, says: &str| {
        one(name, file).unusable(&["blocking invalid-by-laboratory"], &[says])
    };
    let remarked = |name: &str, file: &File, says: &str| {
        one(name, file).unusable(&["blocking laboratory-remark"], &[says, "--accept-remark"])
    };
    let peak = (FROM..TO)
        .map(|k| value(k).parse::<f64>().unwrap())
        .fold(f64::MIN, f64::max);
    vec![
        one("one channel", &File::new()),
        {
            let mut case = one("crlf", &File::new());
            case.files[0].1 = File::new().text().replace('\n', "\r\n").into();
            case
        },
        {
            let mut case = one("bom", &File::new());
            case.files[0].1 = format!("\u{feff}{}", File::new().text()).into();
            case
        },
        {
            let text = File::new().with("Comments", "T\u{fc}r \u{b0}").text();
            let mut case = one("latin-1", &File::new())
                .finds(&["info encoding-assumed", "info laboratory-remark"]);
            case.files[0].1 = text
                .chars()
                .map(|c| u8::try_from(u32::from(c)).unwrap())
                .collect();
            case
        },
        {
            let mut case = one("tabs after keys", &File::new());
            case.files[0].1 = File::new().text().replace("Unit      ", "Unit\t\t").into();
            case
        },
        folder("a folder", &[File::new()]),
        folder(
            "the lateral of three",
            &[
                other("11DOORLE0000ACXP"),
                File::new(),
                other("11DOORLE0000ACZP"),
            ],
        )
        .finds(&["info channel-chosen"]),
        folder(
            "vehicle before barrier",
            &[other("M0MBARLEMIUPACYP"), File::new()],
        )
        .finds(&["info channel-chosen"]),
        folder(
            "a plain place before the rest",
            &[other("10WHEE000000ACYP"), File::new()],
        )
        .finds(&["info channel-chosen"]),
        refused_folder(
            "two plain places",
            &[other("10VEHC000000ACYP"), File::new()],
            &["several channels", "--channel 10VEHC000000ACYP", CODE],
        ),
        folder(
            "acceleration before velocity",
            &[other("11DOORLE0000VEYP"), File::new()],
        ),
        refused_folder(
            "two of one code",
            &[File::new(), File::new()],
            &["several channels", CODE, "choose: latchgate replay", "▁"],
        ),
        refused_folder(
            "two doors",
            &[File::new(), other("13DOORRI0000ACYP")],
            &["several channels", "--channel 13DOORRI0000ACYP", "▁"],
        ),
        folder("by pattern", &[other("13DOORRI0000ACYP"), File::new()])
            .options(&["--channel", "11DOOR*AC[Y2]?"]),
        refused_folder(
            "none is lateral",
            &[other("11DOORLE0000ACXP"), other("11DOORLE0000ACZP")],
            &["--channel"],
        ),
        lateral(good("t.zip", zip_of(&files(&[File::new()]))), "zip"),
        lateral(
            good("t.tar.gz", gzip_of(&tar_of(&files(&[File::new()])))),
            "tar.gz",
        ),
        refused(
            "photos.zip",
            zip_of(&[("a.jpg".into(), vec![1, 2, 3])]),
            &["zip"],
        ),
        refused(
            "cut.zip",
            zip_of(&files(&[File::new()]))[..300].to_vec(),
            &["zip"],
        ),
        refused(
            "cut.tar.gz",
            gzip_of(&tar_of(&files(&[File::new()])))[..900].to_vec(),
            &["cut.tar.gz"],
        ),
        folder("explicit times", &[explicit(), stamps("implicit")]),
        folder("times missing", &[explicit()])
            .clock(10_000.0, 0.0)
            .options(&["--rate-hz", "10000"])
            .finds(&[
                "warning time-reference-missing",
                "warning time-start-assumed",
                "warning no-pre-event-data",
            ]),
        folder(
            "explicit times as the header says",
            &[of_itself("1.0E-4", "-2.0E-2"), stamps("implicit")],
        ),
        folder(
            "explicit times and no interval",
            &[of_itself("0", "NOVALUE"), stamps("implicit")],
        ),
        folder(
            "another interval than the times",
            &[of_itself("8.0E-5", "-2.0E-2"), stamps("implicit")],
        )
        .unusable(&["blocking time-contradicted"], &["12500 Hz"]),
        folder(
            "another start than the times",
            &[of_itself("NOVALUE", "-1.0E-2"), stamps("implicit")],
        )
        .unusable(&["blocking time-contradicted"], &["-0.01 s"]),
        refused_folder(
            "two channels of times",
            &[explicit(), stamps("implicit"), stamps("implicit")],
            &["one channel of times", "file 002", "file 003"],
        ),
        refused_folder(
            "another rate than the times",
            &[explicit(), stamps("implicit")],
            &[
                "777 Hz",
                "10000 Hz by the channel of times",
                "leave out --rate-hz",
            ],
        )
        .options(&["--rate-hz", "777"]),
        refused(
            "t7.001",
            File::new().text(),
            &["leave out --time-column and --time-unit"],
        )
        .named("time in another unit")
        .options(&["--time-unit", "ms"]),
        {
            let file = File::new()
                .without("Sampling interval")
                .without("Reference channel");
            let mut case = refused("t7.001", file.text(), &["--rate-hz"]);
            case.name = "no timing".into();
            case
        },
        one("no start", &File::new().without("Time of first sample"))
            .clock(10_000.0, 0.0)
            .finds(&["warning time-start-assumed", "warning no-pre-event-data"]),
        one("sign diverges", &other("11DOORLE0000AC2P"))
            .channel("11DOORLE0000AC2P")
            .finds(&["warning sign-diverges"]),
        one("unknown place", &other("11XXXX??0000ACYP"))
            .channel("11XXXX??0000ACYP")
            .finds(&["warning channel-not-lateral"]),
        one(
            "CFC 60 before",
            &File::new().with("Channel frequency class", "60"),
        )
        .finds(&["warning already-filtered"]),
        one("repeated keys", &{
            let mut file = File::new();
            file.lines
                .push(("Comments", "one line that was cut at a fixed wid".into()));
            file.lines.push(("Comments", "th: and goes on".into()));
            file
        })
        .finds(&["info laboratory-remark"]),
        // Free checksums.
        one(
            "peak as stated",
            &File::new().with("First global maximum value", &format!("{peak:E}")),
        ),
        one(
            "peak contradicted",
            &File::new().with("First global maximum value", "9.0E+2"),
        )
        .unusable(&["blocking peak-contradicted"], &["900"]),
        one(
            "samples missing",
            &File::new().with("Number of samples", "900"),
        )
        .unusable(&["blocking samples-missing"], &["900"]),
        one(
            "samples to spare",
            &File::new().with("Number of samples", "700"),
        )
        .unusable(&["blocking count-contradicted"], &["700"]),
        one(
            "at full scale",
            &File::new().with("Channel amplitude class", "295"),
        )
        .unusable(&["blocking clipping"], &["full scale"]),
        one("failed", &File::new().with("Data status", "channel failed"))
            .unusable(&["blocking invalid-by-laboratory"], &["channel failed"]),
        one(
            "questionable",
            &File::new().with("Data status", "questionable data"),
        )
        .unusable(&["blocking invalid-by-laboratory"], &["questionable data"]),
        one("no status", &File::new().with("Data status", "NOVALUE")),
        one("no value", &File::new().row(350, "NOVALUE"))
            .samples(800)
            .unusable(&["blocking gap"], &["NOVALUE"]),
        {
            let mut case = refused("t7.001", File::new().row(350, "x1.0").text(), &["x1.0"]);
            case.name = "a word".into();
            case
        },
        {
            let mut case = refused("t7.001", File::new().without("Unit").text(), &["unit"]);
            case.name = "no unit".into();
            case
        },
        // Which files are one test, and whether an archive is whole.
        {
            let mut case = lateral(good("A.mme", ""), "one of two tests").open("A.mme");
            case.files = two_tests(["", ""]);
            case
        },
        {
            let mut case = refused(
                "channels of another test",
                "",
                &["no channel file of the test's stem"],
            )
            .open("A.mme");
            case.files = two_tests(["", ""]);
            case.files.remove(1);
            case
        },
        {
            let mut case = refused(
                "two tests in a folder",
                "",
                &["files of one test", "A.mme", "B.mme", "name the .mme"],
            )
            .open("");
            case.files = two_tests(["", ""]);
            case
        },
        refused(
            "two.zip",
            zip_of(&two_tests(["A/", "B/"])),
            &["files of one test", "A/A.mme", "B/B.mme", "unpack"],
        ),
        refused(
            "number.zip",
            zip_of(&[
                ("T7.001".into(), File::new().text().into()),
                ("Channel/t7.001".into(), File::new().text().into()),
            ]),
            &[
                "one file for each channel's number",
                "Channel/t7.001",
                "T7.001",
            ],
        ),
        lateral(
            good(
                "mac.zip",
                zip_of(
                    &[
                        files(&[File::new()]),
                        vec![("__MACOSX/Channel/._T7.001".into(), vec![0, 5, 22, 7])],
                    ]
                    .concat(),
                ),
            ),
            "shadows of macOS",
        ),
        refused("twice.zip", doubled_zip(), &["each file once", "twice.zip"]),
        {
            let mut bytes = gzip_of(&tar_of(&files(&[File::new()])));
            let at = bytes.len() - 6;
            bytes[at] ^= 0xFF;
            refused(
                "checksum.tar.gz",
                bytes,
                &["archive that unpacks", "checksum.tar.gz"],
            )
        },
        {
            let mut tar = tar_of(&files(&[File::new()]));
            tar.extend_from_slice(&tar_of(&files(&[File::new()])));
            refused("two.tar", tar, &["after the end of the tar", "two.tar"])
        },
        {
            let mut bytes = zip_of(&files(&[File::new()]));
            // In the middle of the one large file.
            let at = bytes.len() / 2;
            bytes[at] ^= 0x55;
            refused("crc.zip", bytes, &["crc.zip: Channel/T7.001", "unpacks"])
        },
        {
            let mut case = folder("a list of another test", &[File::new()])
                .finds(&["warning list-contradicted"]);
            case.files[2].1 =
                b"Number of channels :2\nName of channel 001 :13DOORRI0000ACXP / x\n".to_vec();
            case
        },
        {
            let mut case = folder("a list that leaves places open", &[File::new()]);
            case.files[2].1 = b"Name of channel 001 :11DOORLE00??ACYP / x\n".to_vec();
            case
        },
        folder(
            "codes in small letters",
            &[
                other("11doorle0000acxp"),
                other("11doorle0000acyp"),
                other("11doorle0000aczp"),
            ],
        )
        .channel("11doorle0000acyp")
        .finds(&["info channel-chosen"]),
        // Samples that are not what they seem.
        refused_text(
            "an empty line",
            File::new().row(350, "").without("Number of samples").text(),
            &["t7.001:363", "empty line", "NOVALUE"],
        ),
        refused_text(
            "thousands by comma",
            {
                let mut file = File::new().with("Unit", "mm/s2");
                file.rows = (FROM..TO).map(|k| thousands(k, ',')).collect();
                file.text()
            },
            &["thousands marks", "a factor of 1000"],
        ),
        refused_text(
            "thousands by point",
            {
                let mut file = File::new().with("Unit", "mm/s2");
                file.rows = (FROM..TO).map(|k| thousands(k, '.')).collect();
                file.text()
            },
            &["thousands marks", "a factor of 1000"],
        ),
        // Keys that come twice.
        one("a key twice, alike", &twice("Sampling interval", "0.0001")),
        one(
            "a key twice, once without a value",
            &twice("Unit", "NOVALUE"),
        ),
        refused_text(
            "two intervals",
            twice("Sampling interval", "1.0E-5").text(),
            &[
                "one `Sampling interval`",
                "`1.0E-4` and `1.0E-5`",
                "keep the right one in the header",
            ],
        ),
        refused_text(
            "two units",
            twice("Unit", "g").text(),
            &["one `Unit`", "`m/(s*s)` and `g`"],
        ),
        refused_text(
            "two starts",
            twice("Time of first sample", "-5.0E-3").text(),
            &["one `Time of first sample`"],
        ),
        // What the laboratory says, wherever and however cut.
        remarked(
            "a comment cut in a word",
            &cut_comment(&["channel seems to be good but no val", "id data after 10 ms"]),
            "id data after 10 ms",
        ),
        remarked(
            "a comment cut between words",
            &cut_comment(&["channel seems to be good but no", "valid data after 10 ms"]),
            "valid data after 10 ms",
        ),
        said(
            "a status in words",
            &File::new().with("Data status", "Data invalid after 10 ms"),
            "Data invalid after 10 ms",
        ),
        said(
            "a status in German",
            &File::new().with("Data status", "ung\u{fc}ltig"),
            "ung\u{fc}ltig",
        ),
        said(
            "two states",
            &twice("Data status", "channel failed"),
            "channel failed",
        ),
        remarked(
            "an instant outside of the record",
            &cut_comment(&["no valid data after 300 ms"]),
            "outside the record",
        ),
        remarked(
            "an instant that is not understood",
            &cut_comment(&["look at 10 ms"]),
            "names an instant",
        ),
        one("filtered", &cut_comment(&["CFC60 filtered"]))
            .finds(&["info laboratory-remark", "warning already-filtered"]),
        remarked(
            "an instant cut in two",
            &cut_comment(&["hood touched mount at 1", "0 ms"]),
            "names an instant",
        ),
    ]
}
