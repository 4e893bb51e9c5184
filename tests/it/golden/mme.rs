//! ISO-MME tests: folders, archives and single channels.

use super::{Case, FROM, TO, good, push, refused};
use crate::mme::{gzip_of, tar_of, zip_of};
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

pub(super) fn cases() -> Vec<Case> {
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
            let mut case =
                one("latin-1", &File::new()).finds(&["info encoding-assumed", "info notes"]);
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
            "near the latch before the rest",
            &[other("10VEHC000000ACYP"), File::new()],
        )
        .finds(&["info channel-chosen"]),
        folder(
            "acceleration before velocity",
            &[other("11DOORLE0000VEYP"), File::new()],
        ),
        refused_folder(
            "two of one code",
            &[File::new(), File::new()],
            &["several channels", CODE, "--channel"],
        ),
        refused_folder(
            "two doors",
            &[File::new(), other("13DOORRI0000ACYP")],
            &["several channels", "13DOORRI0000ACYP", "--channel"],
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
        .finds(&["info notes"]),
        // Free checksums.
        one(
            "peak as stated",
            &File::new().with("First global maximum value", &format!("{peak:E}")),
        ),
        one(
            "peak contradicted",
            &File::new().with("First global maximum value", "9.0E+2"),
        )
        .finds(&["warning peak-contradicted"]),
        one(
            "samples missing",
            &File::new().with("Number of samples", "900"),
        )
        .unusable(&["blocking samples-missing"], &["900"]),
        one(
            "samples to spare",
            &File::new().with("Number of samples", "700"),
        )
        .finds(&["warning count-contradicted"]),
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
    ]
}
