//! NHTSA tests: a header and its curves.

use super::{Case, FROM, TO, good, push, refused};
use crate::support::{gzip_of, tar_of, zip_of};

/// What the line of curve 146 says, as far as a case changes it.
struct Line {
    sensor: &'static str,
    place: &'static str,
    axis: &'static str,
    unit: &'static str,
    prefilter: &'static str,
    percent: &'static str,
    first: &'static str,
    last: &'static str,
    interval: &'static str,
    status: &'static str,
    rank: &'static str,
    comment: &'static str,
}

const PLAIN: Line = Line {
    sensor: "AC",
    place: "DSLF",
    axis: "YG",
    unit: "G'S",
    prefilter: "1650",
    percent: "2",
    first: "-200",
    last: "599",
    interval: "100",
    status: "AM",
    rank: "P",
    comment: "NO COMMENTS",
};

impl Line {
    fn text(&self, number: u32) -> String {
        format!(
            "1|{number}|{}|NA|{}|{}|SEC|{}|{}|MAKER|01/JAN/2010|2000|{}|0.0|{}|{}|{}|{}|{}|{}\n",
            self.sensor,
            self.place,
            self.axis,
            self.unit,
            self.prefilter,
            self.percent,
            self.first,
            self.last,
            self.interval,
            self.status,
            self.rank,
            self.comment
        )
    }
}

fn header(lines: &[String]) -> String {
    format!(
        "# comment\n----- TEST -----\n7292|a test|\n----- INSTRUMENTATION -----\n{}----- END -----",
        lines.concat()
    )
}

fn value(k: i64) -> String {
    format!("{:.6}", push(k))
}

fn curve(rows: impl Iterator<Item = i64>) -> String {
    rows.map(|k| format!("{:.6}\t{}\n", k as f64 / 1e4, value(k)))
        .collect()
}

fn whole() -> String {
    curve(FROM..TO)
}

/// A curve with its header beside it.
fn read(name: &str, line: &Line) -> Case {
    good("v07292.146", whole())
        .beside("v07292.EV5", header(&[line.text(146)]))
        .channel("146 V1 AC DSLF YG")
        .unit("g", value)
        .finds(&["info header-beside"])
        .named(name)
}

/// A header whose curves 145 to 147 are all there.
fn test(name: &str, lines: [&Line; 3]) -> Case {
    let texts: Vec<String> = (145..)
        .zip(lines)
        .map(|(number, line)| line.text(number))
        .collect();
    good("v07292.EV5", header(&texts))
        .beside("v07292.145", whole())
        .beside("v07292.146", whole())
        .beside("v07292.147", whole())
        .channel("146 V1 AC DSLF YG")
        .unit("g", value)
        .named(name)
}

impl Case {
    /// Changes the text of the header.
    fn change_header(mut self, change: impl FnOnce(String) -> String) -> Self {
        let text = String::from_utf8(std::mem::take(&mut self.files[0].1)).unwrap();
        self.files[0].1 = change(text).into_bytes();
        self
    }

    fn refused(self, says: &[&str]) -> Self {
        let mut case = refused(&self.name.clone(), "", says);
        case.files = self.files;
        case.opened = self.opened;
        case
    }
}

/// Fields that are held against the samples and cannot be read.
fn unread() -> Vec<Case> {
    let case = |(name, from, to): (&str, &str, &str)| {
        let line = PLAIN.text(146).replace(from, to);
        good("v07292.146", whole())
            .beside("v07292.EV5", header(&[line]))
            .channel("146 V1 AC DSLF YG")
            .unit("g", value)
            .finds(&["info header-beside", "warning statement-unread"])
            .named(name)
    };
    [
        ("a rating that is no number", "|2000|2|", "|nan|2|"),
        ("a rating below zero", "|2000|2|", "|-5|2|"),
        ("a rating with its unit", "|2000|2|", "|2000 G|2|"),
        ("an interval of zero", "|100|AM", "|0|AM"),
        ("no interval", "|100|AM", "||AM"),
        ("an index that is no number", "|-200|", "|x|"),
    ]
    .into_iter()
    .map(case)
    .collect()
}

pub(super) fn cases() -> Vec<Case> {
    let mut cases = readings();
    cases.extend(unread());
    // The last number has lost its end, and nothing else says so.
    let cut = whole().trim_end().to_string();
    let line = PLAIN.text(146).replace("|599|", "||");
    cases.push(
        good("v07292.146", cut[..cut.len() - 3].to_string())
            .beside("v07292.EV5", header(&[line]))
            .channel("146 V1 AC DSLF YG")
            .samples(800)
            .finds(&["info header-beside", "warning statement-unread"])
            .unusable(&["blocking samples-missing"], &["is cut"])
            .named("a last line that is cut"),
    );
    cases.extend(archives());
    cases.extend(tab_separated());
    cases.push(slow_header());
    cases
}

/// The header and curve 146 under a folder's name, which may be empty, and a curve's name.
fn files(folder: &str, curve: &str) -> Vec<(String, Vec<u8>)> {
    let header = header(&[PLAIN.text(146)]).into_bytes();
    vec![
        (format!("{folder}v07292.EV5"), header),
        (format!("{folder}{curve}"), whole().into_bytes()),
    ]
}

/// A test as the database delivers it, packed.
fn archives() -> Vec<Case> {
    let read = |name: &str, bytes: Vec<u8>| {
        good(name, bytes)
            .channel("146 V1 AC DSLF YG")
            .unit("g", value)
    };
    let with = |file: (&str, &[u8])| {
        let more = (file.0.to_string(), file.1.to_vec());
        zip_of(&[files("", "v07292.146"), vec![more]].concat())
    };
    vec![
        read("v07292ascii.zip", zip_of(&files("", "v07292.146"))),
        read("folder.zip", zip_of(&files("v07292/", "V07292.146"))),
        read("windows.zip", zip_of(&files("a\\v07292\\", "v07292.146"))),
        read("t.tar.gz", gzip_of(&tar_of(&files("", "v07292.146")))),
        read("t.tar", tar_of(&files("7292/", "v07292.146"))),
        read("tabs.zip", zip_of(&files("", "v07292_146.tsv"))),
        read("report.zip", with(("v07292R001.pdf", b"%PDF-1.4"))),
        read("shadow.zip", with(("__MACOSX/._v07292.EV5", b"shadow"))),
        refused(
            "header-alone.zip",
            zip_of(&files("", "v07292.146")[..1]),
            &["no channel carries"],
        ),
        refused(
            "two-tests.zip",
            with(("v07293.EV5", header(&[PLAIN.text(146)]).as_bytes())),
            &["several tests", "unpack it"],
        ),
        refused(
            "two-headers.zip",
            zip_of(&[
                ("v07292.EV5".into(), b"----- EV5 -----".to_vec()),
                ("v07293.EV5".into(), b"----- EV5 -----".to_vec()),
            ]),
            &["several tests", "unpack it"],
        ),
        refused(
            "curve-twice.zip",
            with(("v07292_146.tsv", whole().as_bytes())),
            &["one file of curve 146", "v07292.146, v07292_146.tsv"],
        ),
        refused(
            "word-in-curve.zip",
            zip_of(&[
                files("", "v07292.146")[0].clone(),
                ("v07292.146".into(), b"-0.02 0\n-0.0199 x\n".to_vec()),
            ]),
            &["v07292.146:2"],
        ),
    ]
}

/// Curves whose number stands before `.tsv`.
fn tab_separated() -> Vec<Case> {
    let names = [
        "v07292_146.tsv",
        "v07292.146.tsv",
        "V07292-146.TSV",
        "v07292 0146.tsv",
    ];
    let read = |name: &&str| {
        let opened = |file| {
            good("v07292.EV5", header(&[PLAIN.text(146)]))
                .beside(name, whole())
                .open(file)
                .channel("146 V1 AC DSLF YG")
                .unit("g", value)
                .named(&format!("{name} with {file:?}"))
        };
        [opened("v07292.EV5"), opened("")]
    };
    let mut cases: Vec<Case> = names.iter().flat_map(read).collect();
    // Of another test, or no number.
    for name in ["v07293_146.tsv", "v07292_x146.tsv", "v07292.tsv"] {
        cases.push(
            good("v07292.EV5", header(&[PLAIN.text(146)]))
                .beside(name, whole())
                .named(name)
                .refused(&["no channel carries"]),
        );
    }
    cases
}

/// A rate that a person states is no witness against the header's interval.
fn slow_header() -> Case {
    let rows: String = (0..TO - FROM)
        .map(|k| format!("{:.6}\t{}\n", k as f64 / 1e4, value(k + FROM)))
        .collect();
    let line = PLAIN.text(146).replace("|-200|599|100|", "|0|799|200|");
    good("v07292.146", rows)
        .beside("v07292.EV5", header(&[line]))
        .options(&["--rate-hz", "10000"])
        .channel("146 V1 AC DSLF YG")
        .unit("g", value)
        .clock(10_000.0, 0.0)
        .finds(&["info header-beside", "warning no-pre-event-data"])
        .unusable(&["blocking time-contradicted"], &["differ"])
        .named("a header twice as slow as its stamps")
}

fn readings() -> Vec<Case> {
    let x = Line {
        axis: "XG",
        ..PLAIN
    };
    let z = Line {
        axis: "ZG",
        ..PLAIN
    };
    let red = Line { rank: "R", ..PLAIN };
    let dummy = Line {
        place: "HDCG",
        axis: "YL",
        ..PLAIN
    };
    let wheel = Line {
        place: "WHLF",
        ..PLAIN
    };
    let sill = Line {
        place: "SILR",
        ..PLAIN
    };
    let blocked = |name: &str, line: &Line, says: &str| {
        read(name, line).unusable(&["blocking invalid-by-laboratory"], &[says])
    };
    let remarked = |name: &str, line: &Line, says: &str| {
        read(name, line).unusable(&["blocking laboratory-remark"], &[says, "--accept-remark"])
    };
    vec![
        read("curve", &PLAIN),
        good("v07292.047", whole())
            .beside("v07292.EV5", header(&[PLAIN.text(47)]))
            .channel("47 V1 AC DSLF YG")
            .unit("g", value)
            .finds(&["info header-beside"])
            .named("zero-padded"),
        good("v07292.146", whole())
            .beside("v07292.ev5", header(&[PLAIN.text(146)]))
            .channel("146 V1 AC DSLF YG")
            .unit("g", value)
            .finds(&["info header-beside"])
            .named("lower-case"),
        good("v07292.146", whole().replace('\n', "\r\n"))
            .beside(
                "v07292.EV5",
                header(&[PLAIN.text(146)]).replace('\n', "\r\n"),
            )
            .channel("146 V1 AC DSLF YG")
            .unit("g", value)
            .finds(&["info header-beside"])
            .named("crlf"),
        good("v07292.146", whole())
            .options(&["--unit", "g"])
            .channel("v07292.146")
            .unit("g", value)
            .finds(&["warning header-missing"])
            .named("bare curve"),
        refused(
            "v07292.146",
            whole(),
            &["no unit of acceleration", "--unit"],
        ),
        good("v07292.146", whole())
            .beside("v07292.EV5", header(&[PLAIN.text(145)]))
            .options(&["--unit", "g"])
            .channel("v07292.146")
            .unit("g", value)
            .finds(&["warning header-lacks-curve"])
            .named("another test's header"),
        test("the lateral of three", [&x, &PLAIN, &z]).finds(&["info channel-chosen"]),
        test("primary before redundant", [&red, &PLAIN, &x]).finds(&["info channel-chosen"]),
        test("structure before dummy", [&dummy, &PLAIN, &x]).finds(&["info channel-chosen"]),
        test("by number", [&PLAIN, &PLAIN, &PLAIN]).options(&["--channel", "146"]),
        test("two primaries", [&PLAIN, &PLAIN, &x]).refused(&[
            "several channels",
            "145",
            "146",
            "choose: latchgate replay",
            "--channel '145",
            "▁",
        ]),
        good("v07292.EV5", header(&[x.text(145), PLAIN.text(146)]))
            .beside("v07292.146", whole())
            .channel("146 V1 AC DSLF YG")
            .unit("g", value)
            .named("a curve without file"),
        test("none is lateral", [&x, &x, &z]).refused(&["--channel"]),
        good("v07292.EV5", header(&[PLAIN.text(146)]))
            .named("no curve at all")
            .refused(&["v07292.EV5"]),
        // What the laboratory says, by status ...
        blocked(
            "questionable",
            &Line {
                status: "QD",
                ..PLAIN
            },
            "QD",
        ),
        blocked(
            "fails part-way",
            &Line {
                status: "CF",
                ..PLAIN
            },
            "CF",
        ),
        blocked(
            "no data",
            &Line {
                status: "NO",
                ..PLAIN
            },
            "NO",
        ),
        blocked(
            "meaningless",
            &Line {
                status: "MN",
                ..PLAIN
            },
            "MN",
        ),
        read(
            "computed",
            &Line {
                status: "CM",
                ..PLAIN
            },
        )
        .finds(&["info channel-computed"]),
        // ... and by words, where the truth is.
        remarked(
            "valid until",
            &Line {
                comment: "NO VALID DATA AFTER 34.6 MILLISECONDS",
                ..PLAIN
            },
            "34.6",
        ),
        remarked(
            "exceeded full scale",
            &Line {
                status: "QD",
                comment: "EXCEEDED FULL SCALE AT 11.4 MILLSECONDS, QUESTIONABLE DATA THEREAFTER",
                ..PLAIN
            },
            "FULL SCALE",
        )
        .finds(&["blocking invalid-by-laboratory"]),
        remarked(
            "a leading point",
            &Line {
                comment: "NO VALID DATA AFTER .010 SECONDS",
                ..PLAIN
            },
            ".010",
        ),
        remarked(
            "no data",
            &Line {
                comment: "NO DATA AFTER 10 MILLISECONDS",
                ..PLAIN
            },
            "NO DATA",
        ),
        remarked(
            "not useable",
            &Line {
                comment: "NOT USEABLE",
                ..PLAIN
            },
            "USEABLE",
        ),
        remarked(
            "over range",
            &Line {
                comment: "OVER RANGE AT 10 MS",
                ..PLAIN
            },
            "OVER RANGE",
        ),
        remarked(
            "an instant outside of the record",
            &Line {
                comment: "NO VALID DATA AFTER 1 SECOND",
                ..PLAIN
            },
            "outside the record",
        ),
        remarked(
            "an instant that is not understood",
            &Line {
                comment: "HOOD TOUCHED MOUNT AT 10 MS",
                ..PLAIN
            },
            "names an instant",
        ),
        good("v07292.146", whole())
            .beside(
                "v07292.EV5",
                header(&[PLAIN.text(146).replace("|SEC|", "|MSEC|")]),
            )
            .channel("146 V1 AC DSLF YG")
            .unit("g", value)
            .finds(&["info header-beside", "warning time-unit-overridden"])
            .named("milliseconds that are seconds"),
        good("v07292.146", whole())
            .beside(
                "v07292.EV5",
                header(&[PLAIN
                    .text(146)
                    .replace("|SEC|", "|MSEC|")
                    .replace("|100|AM", "||AM")]),
            )
            .channel("146 V1 AC DSLF YG")
            .unit("g", value)
            .finds(&["info header-beside", "warning statement-unread"])
            .unusable(&["blocking time-contradicted"], &["XUNITS"])
            .named("a unit of time that nothing confirms"),
        read(
            "a remark",
            &Line {
                comment: "SENSOR WAS REMOUNTED BEFORE THE TEST",
                ..PLAIN
            },
        )
        .finds(&["info laboratory-remark"]),
        remarked(
            "a doubt",
            &Line {
                comment: "SPIKE AT 40 MS",
                ..PLAIN
            },
            "SPIKE",
        ),
        read(
            "reached another peak",
            &Line {
                percent: "40",
                ..PLAIN
            },
        )
        .unusable(&["blocking peak-contradicted"], &["CHLMAX"]),
        // What header and samples say of one another.
        read(
            "samples missing",
            &Line {
                last: "899",
                ..PLAIN
            },
        )
        .unusable(&["blocking samples-missing"], &["1100"]),
        read(
            "samples to spare",
            &Line {
                last: "499",
                ..PLAIN
            },
        )
        .finds(&["warning count-contradicted"]),
        read(
            "another clock",
            &Line {
                interval: "80",
                ..PLAIN
            },
        )
        .unusable(&["blocking time-contradicted"], &["12500 Hz"]),
        read(
            "another unit",
            &Line {
                unit: "METERS/SEC**2",
                ..PLAIN
            },
        )
        .unit("m/s2", value)
        .exit(3)
        .finds(&["warning implausible-peak", "warning implausible-velocity"]),
        read(
            "soft filter",
            &Line {
                prefilter: "300",
                ..PLAIN
            },
        )
        .finds(&["warning already-filtered"]),
        read(
            "no filter",
            &Line {
                prefilter: "8000",
                ..PLAIN
            },
        )
        .finds(&["warning aliasing-suspected"]),
        read("another axis", &x)
            .channel("146 V1 AC DSLF XG")
            .finds(&["warning channel-not-lateral"]),
        read(
            "no acceleration",
            &Line {
                sensor: "DS",
                unit: "MM",
                ..PLAIN
            },
        )
        .refused(&["MM"]),
        good(
            "v07292.146",
            whole().replace("\n0.010000\t", "\n0.010000\tx"),
        )
        .beside("v07292.EV5", header(&[PLAIN.text(146)]))
        .named("a word")
        .refused(&["v07292.146:301"]),
        good("v07292.146", curve((FROM..100).chain(150..TO)))
            .beside("v07292.EV5", header(&[PLAIN.text(146)]))
            .channel("146 V1 AC DSLF YG")
            .samples(800)
            .finds(&["info header-beside"])
            .unusable(
                &[
                    "blocking gap",
                    "blocking straight-line",
                    "blocking samples-missing",
                    "blocking time-contradicted",
                ],
                &["differ"],
            )
            .named("a gap"),
        good("v07292.146", "")
            .beside("v07292.EV5", header(&[PLAIN.text(146)]))
            .named("nothing in it")
            .refused(&["empty"]),
        // What the laboratory says of a filter.
        read(
            "filtered",
            &Line {
                comment: "FILTERED CFC 60",
                ..PLAIN
            },
        )
        .finds(&["info laboratory-remark", "warning already-filtered"]),
        // Two files of one curve: which holds is not known.
        good("v07292.EV5", header(&[PLAIN.text(146)]))
            .beside("v07292.146", whole())
            .beside("V07292.146", whole())
            .named("a curve twice")
            .refused(&["one file of curve 146", "V07292.146, v07292.146"]),
        good("v07292.EV5", header(&[PLAIN.text(146)]))
            .beside("v07292.146", whole())
            .beside("v07292.0146", whole())
            .named("a curve twice by its number")
            .refused(&["one file of curve 146", "v07292.0146"]),
        test("a wheel is none of the plain places", [&x, &PLAIN, &wheel])
            .finds(&["info channel-chosen"]),
        // The sill of the one that strikes does not stand for the one that is struck.
        test("two vehicles", [&x, &sill, &z])
            .change_header(|text| {
                let struck = Line {
                    place: "VECG",
                    ..PLAIN
                };
                text.replace(&z.text(147), &struck.text(147).replacen("1|", "2|", 1))
            })
            .refused(&["146 V1 AC SILR YG", "147 V2 AC VECG YG"]),
    ]
}
