//! The targets: a function of bytes each, which panics where a reader breaks its word.
//!
//! Fuzzers call them, and so does the test that replays what was once found.

use latchgate_document::design_file::apply_override;
use latchgate_kernel::model::Design;
use latchgate_kernel::units::AccelerationUnit;
use latchgate_recording::{Card, Head, Limits, ReadOptions, Recording, Selection, Source};

/// A target with its name.
pub type Target = (&'static str, fn(&[u8]));

/// Every target.
pub const ALL: &[Target] = &[
    ("csv", csv),
    ("lvm", lvm),
    ("tdms", tdms),
    ("workbook", workbook),
    ("ev5", ev5),
    ("iso_mme", iso_mme),
    ("mcap", mcap),
    ("any", any),
    ("settings", settings),
];

/// Limits under which one input takes little time.
fn limits() -> Limits {
    Limits {
        samples: 50_000,
        lines: 60_000,
        table_cells: 200_000,
        test_samples: 200_000,
        headers_bytes: 1 << 20,
        unpacked_bytes: 4 << 20,
        unpacked_stream_bytes: 16 << 20,
        mcap_record_bytes: 4 << 20,
        mcap_chunk_bytes: 4 << 20,
        mcap_string_bytes: 1 << 20,
        ..Limits::default()
    }
}

fn read(
    name: &str,
    format: Option<&str>,
    data: &[u8],
    selection: Selection,
    options: &ReadOptions,
) -> Option<Recording> {
    let source = Source::bytes(name, data.to_vec());
    let options = ReadOptions {
        input_format: format.map(String::from),
        ..options.clone()
    };
    let limits = limits();
    match latchgate_recording::read(&source, &options, selection, &limits) {
        Err(error) => {
            let text = error.to_string();
            assert!(
                !text.is_empty() && text.len() < 20_000,
                "a message of {} bytes",
                text.len()
            );
            None
        }
        Ok(recording) => {
            if selection == Selection::Lateral {
                assert_eq!(recording.channels.len(), 1, "one channel");
            }
            for channel in &recording.channels {
                assert!(
                    channel.values.iter().all(|value| value.is_finite()),
                    "a sample is no number"
                );
                assert!(
                    channel.values.len() as u64 <= limits.samples,
                    "too many samples"
                );
                assert!(channel.start_s.is_finite(), "a start that is no number");
                let rate = channel.rate.hertz();
                assert!(rate.is_finite() && rate > 0.0, "a rate of {rate} Hz");
                let at = channel.findings.iter().filter_map(|finding| finding.at_s);
                assert!(
                    at.into_iter().all(f64::is_finite),
                    "a place that is no number"
                );
            }
            Some(recording)
        }
    }
}

/// Returns a number that each change of the bytes moves.
fn checksum(data: &[u8]) -> u8 {
    data.iter()
        .fold(0, |sum: u8, byte| sum.wrapping_mul(31) ^ byte)
}

/// Reads an input in both selections, with and without options; what one says the other must
/// not deny. Four inputs of eight state a rate: that of most seeds, twice it, and two that are odd.
fn both(name: &str, format: &str, data: &[u8]) {
    let rate_hz = match checksum(data) % 8 {
        0 => Some(10_000.0),
        1 => Some(20_000.0),
        2 => Some(1e-3),
        3 => Some(9_600.5),
        _ => None,
    };
    let plain = ReadOptions {
        rate_hz,
        ..ReadOptions::default()
    };
    let told = ReadOptions {
        unit: Some(AccelerationUnit::StandardGravity),
        ..plain.clone()
    };
    let one = read(name, Some(format), data, Selection::Lateral, &plain);
    read(name, Some(format), data, Selection::Every, &plain);
    let with_unit = read(name, Some(format), data, Selection::Lateral, &told);
    if let Some(one) = one {
        let other = with_unit.expect("an option that adds a unit takes no channel away");
        assert_eq!(one.channels[0].values, other.channels[0].values);
        assert_eq!(one.sha256, other.sha256);
    }
}

/// Text tables; the quick way and the careful one must agree.
pub fn csv(data: &[u8]) {
    both("a.csv", "csv", data);
    two_ways(data);
}

/// Text tables as [`csv`], where three inputs of four are read in two ways only: each reading
/// builds the table reader of the crate csv anew, which takes most of the time.
pub fn csv_lightly(data: &[u8]) {
    if checksum(data).is_multiple_of(4) {
        both("a.csv", "csv", data);
    }
    two_ways(data);
}

fn two_ways(data: &[u8]) {
    let rate = ReadOptions {
        rate_hz: Some(10_000.0),
        unit: Some(AccelerationUnit::StandardGravity),
        ..ReadOptions::default()
    };
    let quick = read("a.csv", Some("csv"), data, Selection::Lateral, &rate);
    // A quote in a comment is none of the table's, but the careful way is taken for it.
    if data.starts_with(b"\xFF\xFE")
        || data.starts_with(b"\xFE\xFF")
        || data.starts_with(b"\xEF\xBB\xBF")
    {
        return;
    }
    if data.contains(&b'"') {
        return;
    }
    let careful = read(
        "a.csv",
        Some("csv"),
        &[b"# \"\n", data].concat(),
        Selection::Lateral,
        &rate,
    );
    match (quick, careful) {
        (Some(quick), Some(careful)) => {
            let (one, two) = (&quick.channels[0], &careful.channels[0]);
            let bits = |values: &[f64]| {
                values
                    .iter()
                    .map(|value| value.to_bits())
                    .collect::<Vec<_>>()
            };
            assert_eq!(
                bits(&one.values),
                bits(&two.values),
                "the quick way differs"
            );
            assert_eq!(
                (one.start_s, one.rate),
                (two.start_s, two.rate),
                "the clocks differ"
            );
        }
        (None, None) => {}
        (quick, _) => panic!(
            "only the {} way reads it",
            if quick.is_some() { "quick" } else { "careful" }
        ),
    }
}

/// LabVIEW measurement files.
pub fn lvm(data: &[u8]) {
    both("a.lvm", "lvm", data);
}

/// TDMS files.
pub fn tdms(data: &[u8]) {
    both("a.tdms", "tdms", data);
}

/// Workbooks: an OLE2 container as it is, anything else as the parts of an .xlsx, with form feeds between
/// them, which are packed here: a checksum would hold every change off from the readers behind it.
pub fn workbook(data: &[u8]) {
    if data.starts_with(b"\xD0\xCF") {
        return both("a.xls", "workbook", data);
    }
    const PARTS: [&str; 5] = [
        "xl/workbook.xml",
        "xl/_rels/workbook.xml.rels",
        "xl/styles.xml",
        "xl/sharedStrings.xml",
        "xl/worksheets/sheet1.xml",
    ];
    let mut writer = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default();
    let options = options.compression_method(zip::CompressionMethod::Stored);
    for (name, part) in PARTS.into_iter().zip(data.split(|byte| *byte == b'\x0C')) {
        writer.start_file(name, options).expect("a new part");
        std::io::Write::write_all(&mut writer, part).expect("bytes in memory");
    }
    let bytes = writer.finish().expect("bytes in memory").into_inner();
    both("a.xlsx", "workbook", &bytes);
}

/// NHTSA headers and bare curves.
pub fn ev5(data: &[u8]) {
    both("v01.EV5", "ev5", data);
    both("v01.146", "ev5", data);
}

fn is_archive(data: &[u8]) -> bool {
    data.starts_with(b"PK") || data.starts_with(b"\x1F\x8B") || data.get(257..262) == Some(b"ustar")
}

/// ISO-MME: single files and archives. The name of an archive is looked at nowhere.
pub fn iso_mme(data: &[u8]) {
    let names: &[&str] = if is_archive(data) {
        &["t.zip"]
    } else {
        &["t.001", "t.mme", "t.chn", "t.zip"]
    };
    for name in names {
        both(name, "iso-mme", data);
    }
}

/// MCAP logs.
pub fn mcap(data: &[u8]) {
    both("a.mcap", "mcap", data);
}

/// Whatever it is: detection by content and name. Text tables, files of LabVIEW and logs are read
/// the same under every name, so each is read once.
pub fn any(data: &[u8]) {
    let mut seen = Vec::new();
    for name in ["a", "a.csv", "a.EV5", "a.146", "a.zip", "a.lvm"] {
        let head = Head {
            bytes: &data[..data.len().min(4096)],
            file_name: name,
            is_folder: false,
            is_archive: false,
            entries: &[],
        };
        let format = latchgate_recording::FORMATS
            .iter()
            .find(|format| (format.recognises)(&head))
            .map(|format| format.name);
        if let Some(format @ ("csv" | "lvm" | "mcap" | "tdms" | "workbook")) = format {
            if seen.contains(&format) {
                continue;
            }
            seen.push(format);
        }
        let read = read(
            name,
            None,
            data,
            Selection::Lateral,
            &ReadOptions::default(),
        );
        // What an archive is shows in its entries, which only the reader lists.
        let is_archive = is_archive(data);
        if let Some(recording) = read.filter(|_| !is_archive) {
            assert_eq!(
                Some(recording.format),
                format,
                "another reader than that found"
            );
        }
    }
}

/// Design files and cards; a design that is taken must be valid, and read back as it was.
pub fn settings(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    if let Ok(design) = latchgate_document::design_file::from_toml(text) {
        let _ = design.validate();
    }
    let mut design = Design::reference();
    for line in text.lines().take(20) {
        if apply_override(&mut design, line).is_ok() && design.validate().is_ok() {
            let lever = &design.lever;
            assert!(
                lever.moment_of_inertia_kg_m2 > 0.0,
                "a lever without inertia"
            );
        }
    }
    if let Err(error) = Card::from_toml(text) {
        assert!(!error.to_string().is_empty());
    }
}
