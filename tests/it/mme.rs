//! ISO-MME tests: the same channels from folder and archives, what headers state against what
//! files hold, and archives that are no tests or mean harm.

use crate::support::{
    Folder, check_at, check_codes, check_refused, data, gzip_of, one, read_path, tar_of,
    with_channel, zip_of,
};
use latchgate_kernel::units::AccelerationUnit;
use latchgate_recording::error::ErrorKind;
use latchgate_recording::{Finding, ReadOptions, Selection, Severity};
use std::fmt::Write as _;
use std::time::Instant;

pub(crate) const PILLAR: &str = "14BPILLO0000ACYA";

/// A channel file: header lines and samples.
#[derive(Clone)]
pub(crate) struct File {
    lines: Vec<(String, String)>,
    samples: Vec<String>,
}

impl File {
    /// 10 kHz from −10 ms on, 400 samples, at most 250 m/s².
    pub(crate) fn new(code: &str) -> Self {
        let samples: Vec<f64> = (0..400).map(sample).collect();
        let lines = [
            ("Test object number", "1"),
            ("Name of the channel", "B-Pillar, left: lower"),
            ("Channel code", code),
            ("Unit", "m/(s*s)"),
            ("Reference channel", "implicit"),
            ("Reference channel name", "NOVALUE"),
            ("Data status", "ok"),
            ("Pre-filter type", "2000"),
            ("Channel frequency class", "NOVALUE"),
            ("Channel amplitude class", "5000"),
            ("Sampling interval", "1.0E-4"),
            ("Time of first sample", "-1.000000E-2"),
            ("Number of samples", "400"),
            ("First global maximum value", "2.500000E+2"),
            ("Time of maximum value", "1.000000E-2"),
            ("First global minimum value", "0.0"),
        ];
        Self {
            lines: lines
                .map(|(key, value)| (key.to_string(), value.to_string()))
                .to_vec(),
            samples: samples.iter().map(|value| format!("{value:.6}")).collect(),
        }
    }

    fn with(mut self, key: &str, value: &str) -> Self {
        match self.lines.iter_mut().find(|(known, _)| known == key) {
            Some((_, old)) => *old = value.to_string(),
            None => self.lines.push((key.to_string(), value.to_string())),
        }
        self
    }

    fn without(mut self, key: &str) -> Self {
        self.lines.retain(|(known, _)| known != key);
        self
    }

    fn text(&self) -> String {
        let mut text = String::new();
        for (key, value) in &self.lines {
            writeln!(text, "{key:<28}:{value}").unwrap();
        }
        for sample in &self.samples {
            writeln!(text, "{sample}").unwrap();
        }
        text.replace('\n', "\r\n")
    }
}

fn sample(index: usize) -> f64 {
    if (100..300).contains(&index) {
        250.0 - (index as f64 - 200.0).abs() * 2.5
    } else {
        0.0
    }
}

const TEST: &str = "Data format edition number  :1.6\r\nTest number                 :7\r\nImpact side test object 1   :left\r\n";

/// The files of a test with these channels.
pub(crate) fn test_of(channels: &[File]) -> Vec<(String, Vec<u8>)> {
    let mut files = vec![("T7.mme".to_string(), format!("\u{feff}{TEST}").into_bytes())];
    let mut list = format!("Number of channels          :{}\r\n", channels.len());
    for (index, channel) in channels.iter().enumerate() {
        let number = index + 1;
        let code = &channel
            .lines
            .iter()
            .find(|(key, _)| key == "Channel code")
            .map_or("", |(_, code)| code);
        write!(
            list,
            "Name of channel {number:03}         :{code} / a text\r\n"
        )
        .unwrap();
        files.push((
            format!("Channel/T7.{number:03}"),
            channel.text().into_bytes(),
        ));
    }
    files.push(("Channel/T7.chn".to_string(), list.into_bytes()));
    files
}

pub(crate) fn folder_of(name: &str, files: &[(String, Vec<u8>)]) -> Folder {
    let folder = Folder::new(name);
    for (name, bytes) in files {
        folder.file(name, bytes);
    }
    folder
}

#[test]
fn val_a_test_is_the_same_from_folder_archives_and_single_file() {
    let files = test_of(&[
        File::new("11HEAD0000??ACYA"),
        File::new(PILLAR),
        File::new("14BPILLO0000ACXA"),
        File::new("M0MBARLEMIUPACYP"),
    ]);
    let folder = folder_of("mme-same", &files);
    let archives = Folder::new("mme-same-archives");
    let mut hashes = Vec::new();
    for path in [
        folder.path().to_path_buf(),
        folder.path().join("T7.mme"),
        folder.path().join("Channel/T7.chn"),
        folder.path().join("Channel/T7.002"),
        archives.file("T7.zip", zip_of(&files)),
        archives.file("T7.tar.gz", gzip_of(&tar_of(&files))),
        archives.file("T7.tar", tar_of(&files)),
    ] {
        let (channel, findings) = one(&path, &ReadOptions::default());
        assert_eq!(channel.name, PILLAR, "{}", path.display());
        assert_eq!(channel.unit, Some(AccelerationUnit::MetrePerSecondSquared));
        assert_eq!((channel.rate.hertz(), channel.start_s), (10_000.0, -0.01));
        assert_eq!(channel.values, (0..400).map(sample).collect::<Vec<_>>());
        assert_eq!(channel.stated.prefilter_hz, Some(2000.0));
        assert_eq!(channel.stated.full_scale, Some(5000.0));
        assert_eq!(channel.stated.filter_class.as_deref(), Some("1000"));
        check_codes(&findings, Severity::Warning, &[]);
        check_codes(&findings, Severity::Blocking, &[]);
        hashes.push(channel.content_sha256().unwrap());
    }
    hashes.dedup();
    assert_eq!(hashes.len(), 1);
}

#[test]
fn val_the_one_plain_lateral_channel_is_taken_and_several_are_offered() {
    let twins = [File::new(PILLAR), File::new(PILLAR)];
    let far = File::new("16BPILLO0000ACYA");
    let tunnel = File::new("10TUNN000000ACYA");
    let check = |channels: &[File], expected: &str| {
        let folder = folder_of("mme-choice", &test_of(channels));
        let (channel, findings) = one(folder.path(), &ReadOptions::default());
        assert_eq!(channel.name, expected);
        check_at(&findings, "channel-chosen", None);
    };
    let barrier = File::new("M0MBARLEMIUPACYP");
    let wheel = File::new("14WHEE000000ACYA");
    check(&[twins[0].clone(), barrier, wheel.clone()], PILLAR);
    check(
        &[tunnel.clone(), File::new("10TUNN000000ACXA")],
        "10TUNN000000ACYA",
    );
    let ambiguous: fn(&ErrorKind) -> bool =
        |kind| matches!(kind, ErrorKind::AmbiguousChannel { .. });
    // Which of several is meant a person says; the side that was not struck is told.
    let several = [far.clone(), twins[0].clone(), tunnel.clone()];
    let folder = folder_of("mme-several", &test_of(&several));
    let names = &["16BPILLO0000ACYA, 14BPILLO0000ACYA, 10TUNN000000ACYA"];
    check_refused(folder.path(), &ReadOptions::default(), ambiguous, names);
    let side = &["side-not-struck"];
    for (options, expected) in [
        (with_channel("16BPILLO0000ACYA"), &side[..]),
        (with_channel(PILLAR), &[]),
    ] {
        let (_, findings) = one(folder.path(), &options);
        check_codes(&findings, Severity::Warning, expected);
    }
    let head = twins[0].clone().with("Name of the channel", "Dummy head Y");
    let folder = folder_of("mme-head", &test_of(&[head]));
    check_refused(
        folder.path(),
        &ReadOptions::default(),
        ambiguous,
        &[PILLAR, "head"],
    );
    let folder = folder_of("mme-twins", &test_of(&twins));
    let both = "14BPILLO0000ACYA (file 001), 14BPILLO0000ACYA (file 002)";
    check_refused(folder.path(), &ReadOptions::default(), ambiguous, &[both]);
    check_refused(folder.path(), &with_channel(PILLAR), ambiguous, &[both]);
    for name in ["2", "002", "14BPILLO0000ACYA (file 002)"] {
        let (channel, _) = one(folder.path(), &with_channel(name));
        assert_eq!(channel.name, "14BPILLO0000ACYA (file 002)");
    }
    let folder = folder_of("mme-pattern", &test_of(&[twins[0].clone(), wheel]));
    for name in ["1?BPIL??????AC[Y2]?", "14bpillo0000acya", "*BPIL*"] {
        assert_eq!(one(folder.path(), &with_channel(name)).0.name, PILLAR);
    }
    check_refused(
        folder.path(),
        &with_channel("*LOCK*"),
        |kind| matches!(kind, ErrorKind::NoSuchChannel { .. }),
        &[PILLAR],
    );
    let dummies = [File::new("11HEAD0000??ACYA"), File::new("11CHST0000??ACYC")];
    let folder = folder_of("mme-dummies", &test_of(&dummies));
    check_refused(
        folder.path(),
        &ReadOptions::default(),
        ambiguous,
        &["11HEAD0000??ACYA (its place", "11CHST0000??ACYC"],
    );
}

#[track_caller]
fn check_findings(file: File, severity: Severity, expected: &[&str]) {
    let folder = folder_of("mme-findings", &test_of(&[file]));
    let (_, findings) = one(folder.path(), &ReadOptions::default());
    check_codes(&findings, severity, expected);
}

#[test]
fn val_what_the_header_states_is_held_against_the_samples() {
    let file = || File::new(PILLAR);
    let (warning, blocking) = (Severity::Warning, Severity::Blocking);
    for count in ["401", "800"] {
        let folder = folder_of(
            "mme-missing",
            &test_of(&[file().with("Number of samples", count)]),
        );
        let (_, findings) = one(folder.path(), &ReadOptions::default());
        check_codes(&findings, blocking, &["samples-missing"]);
        // Without stamps they may be missing anywhere.
        check_at(&findings, "samples-missing", None);
    }
    for (key, value) in [
        ("First global maximum value", "2.500000E+8"),
        ("First global minimum value", "-1.0"),
        ("Time of maximum value", "2.0E-2"),
    ] {
        check_findings(file().with(key, value), blocking, &["peak-contradicted"]);
    }
    check_findings(
        file().with("Comments", "signal lost after 15 ms"),
        blocking,
        &["laboratory-remark"],
    );
    for status in ["fine", "nok", "n.i.O.", "partly ok", "5"] {
        let word = &["invalid-by-laboratory"];
        check_findings(file().with("Data status", status), blocking, word);
    }
    for (key, value) in [
        ("Direction", "X"),
        ("Dimension", "VE"),
        ("Data source", "Simulation LS-DYNA"),
        ("Cut off frequency", "60"),
        ("Channel frequency class", "60"),
    ] {
        check_findings(file().with(key, value), blocking, &["header-contradicted"]);
    }
    for (key, value) in [
        ("Direction", "Y"),
        ("Dimension", "AC"),
        ("Data source", "transducer"),
        ("Cut off frequency", "1650"),
        ("Maximum absolute value", "250"),
    ] {
        check_findings(file().with(key, value), blocking, &[]);
        check_findings(file().with(key, value), warning, &[]);
    }
    for (key, value) in [
        ("Data source", "Anlage 4"),
        ("Channel amplitude class", "2000 g"),
        ("Channel amplitude class", "nan"),
        ("Channel frequency class", "SAE"),
        ("Pre-filter type", "Butterworth"),
        ("Cut off frequency", "low"),
        ("First global maximum value", "much"),
    ] {
        let word = &["statement-unread"];
        check_findings(file().with(key, value), warning, word);
    }
    // Cut in the middle of the last number.
    let mut bytes = file().without("Number of samples").text().into_bytes();
    bytes.truncate(bytes.len() - 4);
    let folder = Folder::new("mme-cut");
    let (_, findings) = one(&folder.file("T7.001", bytes), &ReadOptions::default());
    check_codes(&findings, blocking, &["samples-missing"]);
    check_findings(
        file().with("Pre-filter type", "8000"),
        warning,
        &["aliasing-suspected"],
    );
    check_findings(File::new("14BPILLO0000AC2A"), warning, &["sign-diverges"]);
    // A package's only acceleration is taken unasked where it is the lateral one.
    for code in ["14BPILLO0000ACXA", "11HEAD0000H3ACYA"] {
        let folder = folder_of("mme-not-lateral", &test_of(&[File::new(code)]));
        check_refused(
            folder.path(),
            &ReadOptions::default(),
            |kind| matches!(kind, ErrorKind::AmbiguousChannel { .. }),
            &[code, "its ", "`channel`"],
        );
        let (_, findings) = one(folder.path(), &with_channel(code));
        check_codes(&findings, warning, &["channel-not-lateral"]);
    }
    // The stated time of the maximum shows that the assumption is wrong.
    let started = || file().without("Time of first sample");
    check_findings(started(), warning, &["time-start-assumed"]);
    check_findings(started(), blocking, &["peak-contradicted"]);
}

/// What people write of the whole test stands apart from the samples: fault words block.
#[test]
fn val_comments_of_the_test_are_remarks() {
    for (comment, expected) in [
        (
            "Comments :SENSOR FAILED IN PRETEST",
            &["laboratory-remark"][..],
        ),
        ("Comments :MDB AT 50 KM/H, 12 MS DELAY OF CAMERAS", &[]),
        ("Comments :NOVALUE", &[]),
    ] {
        let mut files = test_of(&[File::new(PILLAR)]);
        let header = files.iter_mut().find(|(name, _)| name.ends_with(".mme"));
        let (_, header) = header.expect("a test has a header");
        header.extend(format!("\r\n{comment}\r\n").into_bytes());
        let folder = folder_of("mme-comments", &files);
        let (_, findings) = one(folder.path(), &ReadOptions::default());
        check_codes(&findings, Severity::Blocking, expected);
    }
}

#[test]
fn val_missing_samples_block_and_are_not_zero() {
    let mut file = File::new(PILLAR);
    for index in [0, 1, 150, 151, 399] {
        file.samples[index] = "NOVALUE".into();
    }
    let folder = folder_of("mme-novalue", &test_of(&[file]));
    let (channel, findings) = one(folder.path(), &ReadOptions::default());
    check_codes(&findings, Severity::Blocking, &["gap"; 3]);
    // Each from the last sample that is there on.
    let gaps: Vec<f64> = findings
        .iter()
        .filter(|finding| finding.code == "gap")
        .map(|finding| finding.at_s.unwrap())
        .collect();
    for (found, index) in gaps.iter().zip([0.0, 149.0, 398.0]) {
        let expected = -0.01 + index * 1e-4;
        assert!((found - expected).abs() < 1e-12, "{found} for {expected}");
    }
    assert_eq!((channel.values.len(), channel.start_s), (400, -0.01));
    assert_eq!(channel.values[149..152], [sample(149); 3]);
    let mut file = File::new(PILLAR);
    file.samples.fill("NOVALUE".into());
    let folder = folder_of("mme-novalue", &test_of(&[file]));
    check_refused(
        folder.path(),
        &ReadOptions::default(),
        |kind| matches!(kind, ErrorKind::Empty { .. }),
        &["no sample"],
    );
}

#[test]
fn val_explicit_times_are_read_from_their_channel() {
    let mut times = File::new("10TIRS000000TI00").with("Unit", "ms");
    times.samples = (0..400)
        .map(|index| format!("{:.2}", index as f64 * 0.1 - 10.0))
        .collect();
    let file = File::new(PILLAR)
        .with("Reference channel", "explicit")
        .with("Reference channel name", "10TIRS000000TI00")
        .without("Sampling interval")
        .without("Time of first sample");
    let files = test_of(&[times.clone(), file.clone()]);
    let folder = folder_of("mme-explicit", &files);
    for path in [
        folder.path().to_path_buf(),
        folder.path().join("Channel/T7.002"),
    ] {
        let (channel, _) = one(&path, &ReadOptions::default());
        assert_eq!((channel.rate.hertz(), channel.start_s), (10_000.0, -0.01));
    }
    let everything = read_path(folder.path(), &ReadOptions::default(), Selection::Every).unwrap();
    assert_eq!(everything.channels.len(), 1);
    // Without a unit they are seconds, which is said; these would make 10 Hz.
    let silent = test_of(&[times.clone().without("Unit"), file.clone()]);
    let silent = folder_of("mme-explicit", &silent);
    let (channel, findings) = one(silent.path(), &ReadOptions::default());
    assert_eq!(channel.rate.hertz(), 10.0);
    for (code, severity) in [
        ("time-unit-assumed", Severity::Info),
        ("time-unit-implausible", Severity::Warning),
    ] {
        let told = |finding: &Finding| finding.code == code && finding.severity == severity;
        assert!(findings.iter().any(told), "{findings:?}");
    }
    // One time too few, no times at all, and nothing that says anything of time.
    let malformed: fn(&ErrorKind) -> bool = |kind| matches!(kind, ErrorKind::Malformed { .. });
    let missing: fn(&ErrorKind) -> bool = |kind| matches!(kind, ErrorKind::MissingTime);
    times.samples.pop();
    for (channels, kind, words) in [
        (vec![times, file.clone()], malformed, "400 times"),
        (vec![file.clone()], missing, "`rate_hz`"),
        (
            vec![file.with("Reference channel", "implicit")],
            missing,
            "`rate_hz`",
        ),
    ] {
        let folder = folder_of("mme-explicit", &test_of(&channels));
        check_refused(folder.path(), &ReadOptions::default(), kind, &[words]);
    }
}

#[test]
fn val_encodings_and_odd_headers() {
    for (name, bytes) in [
        ("B-Säule: unten", None),
        ("B-S\u{e4}ule: unten", Some(0xE4_u8)),
    ] {
        let text = File::new(PILLAR)
            .with("Name of the channel", name)
            .text()
            .replace("Unit   ", "Unit\t");
        let content = match bytes {
            Some(_) => text.chars().map(|c| c as u32 as u8).collect(),
            None => text.into_bytes(),
        };
        let folder = folder_of("mme-encoding", &[("T7.001".to_string(), content)]);
        let (channel, _) = one(&folder.path().join("T7.001"), &ReadOptions::default());
        assert_eq!(channel.stated.location.as_deref(), Some("B-Säule: unten"));
    }
}

#[test]
fn val_archives_without_a_test_are_refused_by_name() {
    let folder = Folder::new("mme-refused");
    let refused: fn(&ErrorKind) -> bool = |kind| matches!(kind, ErrorKind::RefusedFormat { .. });
    let files = |name: &str| vec![(name.to_string(), b"content".to_vec())];
    for (bytes, words) in [
        (zip_of(&files("xl/workbook.bin")), "Excel, binary (.xlsb)"),
        (zip_of(&files("a.txt")), ".zip that holds no ISO-MME"),
        (
            gzip_of(&tar_of(&files("a.txt"))),
            ".tar.gz that holds no ISO-MME",
        ),
        (tar_of(&files("a.txt")), ".tar that holds no ISO-MME"),
        (gzip_of(b"t,a\n0,1\n"), "gzip file"),
    ] {
        let path = folder.file("a.bin", bytes);
        check_refused(&path, &ReadOptions::default(), refused, &[words]);
    }
    let cut = gzip_of(&tar_of(&test_of(&[File::new(PILLAR)])));
    let path = folder.file("a.bin", &cut[..cut.len() / 2]);
    check_refused(
        &path,
        &ReadOptions::default(),
        |kind| {
            matches!(
                kind,
                ErrorKind::Malformed { .. } | ErrorKind::Truncated { .. }
            )
        },
        &["archive"],
    );
    check_refused(
        &data(
            "recordings/mcap_conformance_NoData_OneMessage_OneSchemalessMessage_OneMetadata.tar.gz",
        ),
        &ReadOptions::default(),
        refused,
        &["holds no ISO-MME"],
    );
}

/// Archives that would unpack to gigabytes end soon, at a limit with a name and a byte.
#[test]
fn val_bombs_end_at_a_limit() {
    let folder = Folder::new("mme-bombs");
    let mut zeros = File::new(PILLAR).text().into_bytes();
    zeros.resize(48 << 20, b'\n');
    let channel = |name: &str| {
        vec![
            ("T7.mme".to_string(), TEST.into()),
            (name.to_string(), zeros.clone()),
        ]
    };
    let many: Vec<(String, Vec<u8>)> = (0..20_001)
        .map(|i| (format!("{i}.txt"), Vec::new()))
        .collect();
    for (bytes, limit) in [
        (gzip_of(&tar_of(&channel("a.bin"))), "unpacked_ratio"),
        (
            gzip_of(&tar_of(&channel("Channel/T7.001"))),
            "unpacked_ratio",
        ),
        (
            zip_of(&[channel("Channel/T7.001"), vec![]].concat()),
            "unpacked_ratio",
        ),
        (zip_of(&many), "archive_entries"),
        (tar_of(&many), "archive_entries"),
        (gzip_of(&vec![0; 32 << 20]), "gzip"),
    ] {
        let path = folder.file("a.bin", bytes);
        let started = Instant::now();
        let error = read_path(&path, &ReadOptions::default(), Selection::Lateral).unwrap_err();
        assert!(error.to_string().contains(limit), "{limit}: {error}");
        // Generous, for a busy machine: what matters is that it does not run for minutes.
        assert!(started.elapsed().as_secs() < 10, "{limit}");
    }
}

/// Archives with bytes changed end in samples or in an error, never in a panic.
#[test]
fn prop_damaged_archives_never_panic() {
    use crate::support::Random;
    let folder = Folder::new("mme-damaged");
    let files = test_of(&[File::new(PILLAR), File::new("14BPILLO0000ACXA")]);
    let tar = tar_of(&files);
    for (kind, whole) in [("zip", zip_of(&files)), ("gz", gzip_of(&tar)), ("tar", tar)] {
        for seed in 0..100 {
            let mut random = Random(seed);
            let mut bytes = whole.clone();
            for _ in 0..=random.below(3) {
                let at = random.below(bytes.len());
                match random.below(3) {
                    0 => bytes.truncate(at.max(4)),
                    // Directories stand at the end, headers at the start.
                    1 if at.is_multiple_of(2) && bytes.len() > 600 => {
                        bytes[at % 600] = (random.next() & 0xFF) as u8
                    }
                    _ => {
                        let near = bytes.len() - 1 - at % bytes.len().min(400);
                        bytes[near] = (random.next() & 0xFF) as u8;
                    }
                }
            }
            let path = folder.file(&format!("{seed}.{kind}"), bytes);
            let read = std::panic::catch_unwind(|| {
                read_path(&path, &ReadOptions::default(), Selection::Every)
            });
            assert!(read.is_ok(), "{kind}, seed {seed}");
        }
    }
}

/// Headers and samples of many channels together end at a limit of their own.
#[test]
fn verif_what_a_test_holds_together_is_bounded() {
    let many = |count: usize| {
        let files: Vec<File> = (0..count)
            .map(|index| File::new(&format!("14BPIL{index:06}ACYA")))
            .collect();
        folder_of("mme-many", &test_of(&files))
    };
    let folder = many(20);
    let source = latchgate_recording::Source::File(folder.path().to_path_buf());
    for (assignment, name) in [
        ("header_bytes=100", "header_bytes"),
        ("headers_bytes=5000", "headers_bytes"),
        ("test_samples=1000", "test_samples"),
    ] {
        let mut limits = latchgate_recording::Limits::default();
        limits.set(assignment).unwrap();
        let options = ReadOptions::default();
        let error =
            latchgate_recording::read(&source, &options, Selection::Every, &limits).unwrap_err();
        assert!(
            matches!(error.kind(), ErrorKind::LimitExceeded { limit, .. } if *limit == name),
            "{name}: {error}"
        );
        let place = error.to_string();
        assert!(place.contains("T7.") || place.contains("14BPIL"), "{place}");
    }
    // One channel is read however many there are.
    let mut limits = latchgate_recording::Limits::default();
    limits.set("test_samples=1000").unwrap();
    let read =
        latchgate_recording::read(&source, &with_channel("003"), Selection::Lateral, &limits);
    assert_eq!(read.unwrap().channels[0].values.len(), 400);
}
