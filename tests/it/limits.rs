//! Guards the limits on input: each has a name, a value and an option, and a file made to burst
//! the reader ends at once, in little memory, with the limit and the byte where it was crossed.

use crate::mcap::{Cdr, channel, chunk, file, header, imu_schema, lz4, message, record, schema};
use crate::support::Random;
use crate::support::{Folder, finish, latchgate, program, table, weak};
use latchgate_recording::error::ErrorKind;
use latchgate_recording::{Limits, ReadOptions, Selection, Source};
use std::fmt::Write as _;
use std::io::{Read, Write};
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Memory that no refused file may take [KiB].
const MEMORY_KIB: u64 = 256 << 10;

/// How long a file is looked at after it has crossed a limit, as users run it and unoptimised.
const PATIENCE: Duration = Duration::from_secs(if cfg!(debug_assertions) { 4 } else { 1 });

/// Times that a slow run is tried again: where the machine is busy with other tests a part of
/// the time is theirs.
const AGAIN: u32 = 2;

/// What a fed program did.
struct Fed {
    code: i32,
    err: String,
    /// Bytes that it took before it went away.
    taken: u64,
    /// How long it lived after it had taken the byte that its message names.
    after: Duration,
    /// Largest resident memory seen [KiB].
    memory_kib: u64,
}

/// Feeds a program with blocks that `next` fills, until it goes away or nothing is left.
fn feed(arguments: &[&str], mut next: impl FnMut(&mut Vec<u8>) -> bool) -> Fed {
    let mut child = program()
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let status = format!("/proc/{}/status", child.id());
    let memory = move || {
        let text = std::fs::read_to_string(&status).ok()?;
        // A program that has ended but was not waited for has no memory any more.
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
        let kib = line.trim().trim_end_matches("kB").trim();
        kib.parse::<u64>().ok()
    };
    // It waits for its input, so that the first look never comes too late.
    let mut most = memory().expect("the program runs");
    let watcher = std::thread::spawn(move || {
        while let Some(now) = memory() {
            most = most.max(now);
            std::thread::sleep(Duration::from_millis(1));
        }
        most
    });
    let mut input = child.stdin.take().unwrap();
    let mut block = Vec::new();
    let mut marks = Vec::new();
    let mut taken = 0_u64;
    while next(&mut block) {
        if input.write_all(&block).is_err() {
            break;
        }
        taken += block.len() as u64;
        marks.push((taken, Instant::now()));
    }
    drop(input);
    let mut err = String::new();
    child
        .stderr
        .take()
        .unwrap()
        .read_to_string(&mut err)
        .unwrap();
    let code = child.wait().unwrap().code().unwrap();
    let ended = Instant::now();
    let memory_kib = watcher.join().unwrap();
    let byte: u64 = err
        .split("byte ")
        .nth(1)
        .and_then(|rest| {
            rest.split(|c: char| !c.is_ascii_digit())
                .next()?
                .parse()
                .ok()
        })
        .unwrap_or(0);
    let crossed = marks.iter().find(|(sum, _)| *sum > byte);
    Fed {
        code,
        err,
        taken,
        after: crossed.map_or(Duration::ZERO, |(_, at)| ended - *at),
        memory_kib,
    }
}

/// Feeds blocks of `block` up to `total` bytes.
fn repeated(arguments: &[&str], head: &[u8], block: &[u8], total: u64) -> Fed {
    let mut left = total;
    let mut first = true;
    let big = block.repeat((1 << 20) / block.len().max(1));
    feed(arguments, |out| {
        out.clear();
        if std::mem::replace(&mut first, false) {
            out.extend_from_slice(head);
        }
        if left == 0 {
            return !out.is_empty();
        }
        out.extend_from_slice(&big);
        left = left.saturating_sub(big.len() as u64);
        true
    })
}

/// Checks that a file ends at `limit`, at `byte` where that is known, in time and memory.
#[track_caller]
fn check_bomb(name: &str, limit: &str, byte: Option<u64>, mut run: impl FnMut() -> Fed) -> Fed {
    let mut fed = run();
    for _ in 0..AGAIN {
        if fed.after >= PATIENCE {
            fed = run();
        }
    }
    println!(
        "{name}: {} KiB, {:?} after the limit, {} bytes taken: {}",
        fed.memory_kib,
        fed.after,
        fed.taken,
        fed.err.trim()
    );
    assert_eq!(fed.code, 4, "{name}: {}", fed.err);
    assert_eq!(fed.err.lines().count(), 1, "{name}: {}", fed.err);
    assert!(
        fed.err.contains(&format!("limit {limit} of")),
        "{name}: {}",
        fed.err
    );
    match byte {
        Some(byte) => assert!(
            fed.err.contains(&format!("byte {byte}:")),
            "{name}: {}",
            fed.err
        ),
        None => assert!(fed.err.contains("byte "), "{name}: {}", fed.err),
    }
    assert!(
        fed.memory_kib > 0 && fed.memory_kib < MEMORY_KIB,
        "{name}: {} KiB",
        fed.memory_kib
    );
    assert!(fed.after < PATIENCE, "{name}: {:?}", fed.after);
    fed
}

const COMMANDS: [&[&str]; 2] = [&["replay", "-", "--no-report"], &["inspect", "-"]];

#[test]
fn verif_a_line_without_an_end_is_not_waited_for() {
    let line = Limits::default().line_bytes;
    for command in COMMANDS {
        let commas = check_bomb("commas", "line_bytes", Some(line), || {
            repeated(command, b"", b",", 256 << 20)
        });
        assert!(commas.taken < 8 << 20);
        let head = b"time_s,acc_y_g\n0.0,";
        let field = check_bomb("field", "line_bytes", Some(15 + line), || {
            repeated(command, head, b"7", 1 << 30)
        });
        assert!(field.taken < 8 << 20);
        check_bomb("quoted field", "line_bytes", Some(15 + line), || {
            repeated(command, b"time_s,acc_y_g\n0.0,\"", b"x", 1 << 30)
        });
    }
}

#[test]
fn verif_commas_on_a_line_of_their_own_are_counted() {
    let most = Limits::default().columns;
    let mut text = String::from("time_s,acc_y_g\n");
    text.push_str(&",".repeat(most as usize + 5));
    text.push('\n');
    check_bomb("commas on a line", "columns", Some(15), || {
        repeated(&["replay", "-", "--no-report"], text.as_bytes(), b"", 0)
    });
}

#[test]
fn verif_a_text_without_an_end_is_not_waited_for() {
    // Unoptimised, the hash alone takes long; there a smaller limit tells the same.
    let (limit, bytes) = if cfg!(debug_assertions) {
        ("text_bytes=8MiB", 8 << 20)
    } else {
        ("text_bytes=192MiB", 192 << 20)
    };
    let rows = b"0.000001,12.345678901234567890\n";
    for command in COMMANDS {
        let arguments = [command, &["--limit", limit]].concat();
        check_bomb("rows", "text_bytes", Some(bytes), || {
            repeated(&arguments, b"time_s,acc_y_g\n", rows, 2 * bytes)
        });
        check_bomb("empty lines", "lines", None, || {
            repeated(&arguments, b"t,a\n", b"\n", 2 * bytes)
        });
    }
}

/// Text that grows when it is decoded counts as what it grows to; before, 189 MiB of Windows-1252
/// took 1.1 GiB. The last is a table that is read, in no more than it holds and what is kept.
#[test]
fn regress_encodings_and_blanks_are_bounded_as_well() {
    // Unoptimised, all of it takes long; there smaller limits tell the same.
    let mebibytes: u64 = if cfg!(debug_assertions) { 8 } else { 192 };
    let limit = format!("text_bytes={mebibytes}MiB");
    let total = (mebibytes - 2) << 20;
    let euros = [b"#".as_slice(), &[0x80; 1000], b"\n"].concat();
    let umlauts = [b"#".as_slice(), &[0xE4; 1000], b"\n"].concat();
    let wide = |text: &str| -> Vec<u8> { text.encode_utf16().flat_map(u16::to_le_bytes).collect() };
    let marked = [b"\xFF\xFE".to_vec(), wide("t,a\n")].concat();
    let arguments = ["replay", "-", "--no-report", "--limit", &limit];
    for (name, head, block) in [
        ("euros", b"t,a\n".to_vec(), euros),
        ("umlauts", b"t,a\n".to_vec(), umlauts),
        (
            "UTF-16",
            marked.clone(),
            wide("0.000001,12.345678901234567890\n"),
        ),
        (
            "UTF-16, euros",
            marked,
            wide(&format!("#{}\n", "€".repeat(500))),
        ),
    ] {
        let fed = repeated(&arguments, &head, &block, total);
        println!("{name}: {} KiB: {}", fed.memory_kib, fed.err.trim());
        assert_eq!(fed.code, 4, "{name}: {}", fed.err);
        assert!(
            fed.err.contains("limit text_bytes of"),
            "{name}: {}",
            fed.err
        );
        assert!(fed.memory_kib < MEMORY_KIB, "{name}: {}", fed.memory_kib);
    }
    let blanks = [b"1 2".as_slice(), &[b' '; 900], b"\n"].concat();
    let fed = repeated(&arguments, b"t a\n", &blanks, total);
    println!("blanks: {} KiB: {}", fed.memory_kib, fed.err.trim());
    assert_eq!(fed.code, 4, "{}", fed.err);
    assert!(fed.memory_kib < MEMORY_KIB, "blanks: {}", fed.memory_kib);
}

#[test]
fn verif_rows_beyond_the_limit_are_counted_before_they_are_kept() {
    let mut text = table(weak);
    let at = |line: usize, text: &str| -> u64 {
        text.split_inclusive('\n')
            .take(line)
            .map(|line| line.len() as u64)
            .sum()
    };
    let byte = at(1001, &text);
    text.push_str("# a comment is no row\n");
    let short = ["replay", "-", "--no-report", "--limit", "samples=1000"];
    let fed = check_bomb("samples", "samples", Some(byte), || {
        repeated(&short, text.as_bytes(), b"", 0)
    });
    assert!(fed.err.contains("-:1002"), "{}", fed.err);
    let cells = ["inspect", "-", "--limit", "table_cells=1000"];
    check_bomb("cells", "table_cells", Some(byte), || {
        repeated(&cells, text.as_bytes(), b"", 0)
    });
}

/// A .tar.gz whose one file is a block of a mebibyte time and again.
fn gzip_of(name: &str, mebibytes: usize, block: &[u8]) -> Vec<u8> {
    let mut head = vec![0_u8; 512];
    head[..name.len()].copy_from_slice(name.as_bytes());
    let size = format!("{:011o}", mebibytes << 20);
    head[124..135].copy_from_slice(size.as_bytes());
    head[156] = b'0';
    head[257..263].copy_from_slice(b"ustar\0");
    head[148..156].fill(b' ');
    let sum: u32 = head.iter().map(|byte| u32::from(*byte)).sum();
    head[148..155].copy_from_slice(format!("{sum:06o}\0").as_bytes());
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(&head).unwrap();
    for _ in 0..mebibytes {
        encoder.write_all(block).unwrap();
    }
    encoder.finish().unwrap()
}

fn zip_of(name: &str, mebibytes: usize) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let options: zip::write::SimpleFileOptions =
        zip::write::FileOptions::default().compression_method(zip::CompressionMethod::Deflated);
    archive.start_file("t.mme", options).unwrap();
    archive.write_all(b"Test number :1\n").unwrap();
    archive.start_file(name, options).unwrap();
    let head = "Channel code                :11DOORLE0000ACYA\n\
                Unit                        :g\n\
                Sampling interval           :0.0001\n\
                Time of first sample        :0.0\n";
    archive.write_all(head.as_bytes()).unwrap();
    let block = b"0.000000\n".repeat(1 << 17);
    for _ in 0..mebibytes {
        archive.write_all(&block).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

#[test]
fn verif_archives_that_unpack_to_far_more_are_refused() {
    for command in COMMANDS {
        let bomb = gzip_of("Channel/t.001", 64, &[0; 1 << 20]);
        check_bomb("gzip", "unpacked_ratio", None, || {
            repeated(command, &bomb, b"", 0)
        });
        let bomb = zip_of("Channel/t.001", 64);
        check_bomb("zip", "unpacked_ratio", None, || {
            repeated(command, &bomb, b"", 0)
        });
    }
    let folder = Folder::new("limits-entries");
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for index in 0..300 {
        let options = zip::write::SimpleFileOptions::default();
        archive.start_file(format!("{index}"), options).unwrap();
    }
    let many = archive.finish().unwrap().into_inner();
    let path = folder.write("a.zip", many);
    let done = latchgate(&["inspect", &path, "--limit", "archive_entries=200"]);
    assert_eq!(done.code, 4);
    assert!(
        done.err.contains("limit archive_entries of 200"),
        "{}",
        done.err
    );
}

/// What is passed over in an archive counts as well: here a file that unpacks to 50 times its
/// size, well below the limit on that, and to more than a gibibyte.
#[test]
fn verif_an_archive_that_goes_on_and_on_ends_at_its_limit() {
    // Unoptimised, unpacking takes long; there a smaller limit tells the same.
    let mebibytes: usize = if cfg!(debug_assertions) { 16 } else { 1 << 10 };
    let mut random = Random(1);
    let mut block: Vec<u8> = (0..16 << 10)
        .map(|_| (random.next() & 0xFF) as u8)
        .collect();
    block.resize(1 << 20, 0);
    let bomb = gzip_of("long.bin", mebibytes + 1, &block);
    let limit = format!("unpacked_stream_bytes={mebibytes}MiB");
    for command in COMMANDS {
        let arguments = [command, &["--limit", &limit]].concat();
        let fed = repeated(&arguments, &bomb, b"", 0);
        println!("{} KiB: {}", fed.memory_kib, fed.err.trim());
        assert_eq!(fed.code, 4, "{}", fed.err);
        let named = format!("limit unpacked_stream_bytes of {}", mebibytes << 20);
        assert!(fed.err.contains(&named), "{}", fed.err);
        assert!(fed.err.contains("byte "), "{}", fed.err);
        assert!(fed.memory_kib < MEMORY_KIB, "{} KiB", fed.memory_kib);
    }
}

/// The program in a shell that bounds the address space; what asks for more is ended by its
/// allocator.
fn bounded() -> std::process::Command {
    let bounded = format!("ulimit -v {MEMORY_KIB} && exec \"$0\" \"$@\"");
    let mut shell = std::process::Command::new("sh");
    shell.args(["-c", &bounded, env!("CARGO_BIN_EXE_latchgate")]);
    shell
}

/// Settings with a key as long as they may be: to look for the name that was meant once took
/// the key's length times the name's, in memory as well, and the message repeated all of it.
#[cfg(unix)]
#[test]
fn regress_a_key_as_long_as_the_settings_costs_little() {
    let most = usize::try_from(Limits::default().settings_bytes).unwrap();
    let folder = Folder::new("limits-key");
    let recording = folder.write("a.csv", table(weak));
    let long = "k".repeat(most - 20);
    let design = folder.write("design.toml", format!("[lever]\n{long} = 1.0\n"));
    folder.write("b.csv", table(weak));
    folder.write("b.csv.toml", format!("{long} = 1.0\n"));
    let carded = folder.path().join("b.csv");
    for arguments in [
        vec!["replay", &recording, "--no-report", "--design", &design],
        vec!["replay", carded.to_str().unwrap(), "--no-report"],
    ] {
        let done = finish(bounded().args(&arguments));
        assert!(matches!(done.code, 2 | 4), "{} {}", done.code, done.err);
        assert!(done.err.contains("kkk…"), "{}", done.err);
        assert!(done.err.len() < 2000, "{} bytes", done.err.len());
    }
}

/// A zstd frame of repeated bytes, four bytes a block of 128 KiB.
fn zstd_of_zeros(blocks: u32) -> Vec<u8> {
    // No single segment, no checksum, no content size; a window of 1 MiB.
    let mut frame = vec![0x28, 0xB5, 0x2F, 0xFD, 0x00, 0x50];
    for block in 0..blocks {
        let last = u32::from(block + 1 == blocks);
        let head: u32 = last | (1 << 1) | (128 << 10 << 3);
        frame.extend(&head.to_le_bytes()[..3]);
        frame.push(0);
    }
    frame
}

#[test]
fn verif_chunks_that_unpack_to_far_more_are_refused() {
    let zeros = vec![0; 4 << 20];
    for (name, data) in [("zstd", zstd_of_zeros(80_000)), ("lz4", lz4(&zeros))] {
        // What the chunk says of itself crosses the limit ...
        let honest = [chunk(name, 10 << 30, 0, &data)];
        let bytes = file(&honest, &[]);
        for command in COMMANDS {
            check_bomb(name, "mcap_chunk_bytes", None, || {
                repeated(command, &bytes, b"", 0)
            });
        }
        // ... and what it does not say is not unpacked.
        let lying = [chunk(name, 1 << 20, 0, &data)];
        let fed = repeated(COMMANDS[0], &file(&lying, &[]), b"", 0);
        assert_eq!(fed.code, 4, "{}", fed.err);
        assert!(
            fed.err.contains("1048576 bytes in the chunk"),
            "{}",
            fed.err
        );
        assert!(fed.memory_kib < MEMORY_KIB);
    }
    // A record longer than allowed is not waited for.
    let mut long = file(&[], &[]);
    long.truncate(8 + header().len());
    long.extend([0x05]);
    long.extend((1_u64 << 40).to_le_bytes());
    for command in COMMANDS {
        check_bomb("record", "mcap_record_bytes", None, || {
            repeated(command, &long, b"x", 0)
        });
    }
    // Packed files that are no recording are refused by name.
    let zstd = latchgate(&[
        "inspect",
        &Folder::new("limits-zst").write("a.zst", zstd_of_zeros(9)),
    ]);
    assert!(zstd.err.contains("zstd"), "{}", zstd.err);
}

#[test]
fn verif_a_string_that_claims_four_gibibytes_is_refused() {
    let claims = u32::MAX.to_le_bytes();
    // In a record of the file, first text or last ...
    let body = |parts: &[&[u8]]| parts.concat();
    let map = |texts: &[u8]| [&(texts.len() as u32).to_le_bytes(), texts].concat();
    let in_records = [
        ("schema", 0x03, body(&[&[1, 0], &claims, b"a/B"])),
        (
            "schema",
            0x03,
            body(&[&[1, 0], &[1, 0, 0, 0], b"a", &claims, b"ros2msg"]),
        ),
        ("channel", 0x04, body(&[&[1, 0, 1, 0], &claims, b"/imu"])),
        (
            "channel",
            0x04,
            body(&[&[1, 0, 1, 0], &[0; 8], &map(&claims)]),
        ),
        ("chunk", 0x06, body(&[&[0; 28], &claims, b"zstd"])),
        ("chunk index", 0x08, body(&[&[0; 44], &claims, b"zstd"])),
        // An entry that goes beyond the length of its map moves what follows.
        (
            "channel",
            0x04,
            body(&[&[1, 0, 1, 0], &[0; 8], &map(&[0; 4]), &claims]),
        ),
        (
            "chunk index",
            0x08,
            body(&[&[0; 32], &map(&[0; 5]), &[0; 13], &claims, b"zstd"]),
        ),
    ];
    let metadata = body(&[&[0; 4], &map(&body(&[&[0; 4], &claims]))]);
    let odd_metadata = body(&[&[0; 4], &map(&[0; 4]), &claims]);
    // ... and in a message: the frame of an Imu.
    let text = Cdr::new(true).u32(1).u32(0).u32(u32::MAX).finish();
    let in_message = file(
        &[
            imu_schema(1),
            channel(1, 1, "/imu", "cdr"),
            message(1, 5, &text),
        ],
        &[],
    );
    let ros1 = file(
        &[
            schema(1, "a/B", "ros1msg", "string name\nfloat64 ay_g\n"),
            channel(1, 1, "/a", "ros1"),
            message(1, 5, &claims),
        ],
        &[],
    );
    for (name, bytes) in [("message", in_message), ("ros1", ros1)] {
        let fed = check_bomb(name, "mcap_string_bytes", None, || {
            repeated(COMMANDS[0], &bytes, b"", 0)
        });
        assert!(fed.err.contains("4294967295 bytes"), "{}", fed.err);
    }
    // A record's own text ends with its record; nobody asks for the memory it claims.
    let folder = Folder::new("limits-text");
    let replayed = |opcode, body: &[u8]| {
        let path = folder.write("log.mcap", file(&[record(opcode, body)], &[]));
        let done = finish(bounded().args(["replay", "--no-report", &path]));
        assert_eq!(done.code, 4, "{}", done.err);
        done.err
    };
    for (name, opcode, body) in in_records {
        let (told, whole) = (replayed(opcode, &body), format!("a whole {name} record"));
        assert!(told.contains(&whole), "{told}");
    }
    for metadata in [metadata, odd_metadata] {
        let told = replayed(0x0C, &metadata);
        assert!(told.contains("the recording holds: no topic"), "{told}");
    }
}

/// A type of many fields was held against itself field by field: 160 000 of them took 85 s.
#[test]
fn regress_a_type_of_many_fields_costs_what_its_text_does() {
    let mut text = String::from("float64 ay_g\n");
    for number in 0..600_000 {
        let _ = writeln!(text, "bool b{number}");
    }
    let log = file(
        &[
            schema(1, "a/B", "ros2msg", &text),
            channel(1, 1, "/a", "cdr"),
        ],
        &[],
    );
    let path = Folder::new("limits-fields");
    let path = path.write("log.mcap", log);
    let done = latchgate(&["replay", "--no-report", &path]);
    assert_eq!(done.code, 4, "{}", done.err);
    assert!(done.err.contains("/a"), "{}", done.err);
}

#[test]
fn cli_limits_lists_every_limit_and_how_to_change_it() {
    let text = latchgate(&["limits"]);
    assert_eq!((text.code, text.err.as_str()), (0, ""));
    let json = latchgate(&["limits", "--format", "json"]).document();
    assert_eq!(json["schema"], "latchgate.limits/1");
    let listed = json["limits"].as_array().unwrap();
    assert_eq!(listed.len(), Limits::NAMES.len());
    for (entry, name) in listed.iter().zip(Limits::NAMES) {
        assert_eq!(entry["name"], *name);
        assert_eq!(entry["value"], entry["default"]);
        assert_eq!(
            entry["change"],
            format!("--limit {name}={}", entry["value"])
        );
        assert!(entry["meaning"].as_str().unwrap().ends_with('.'));
        assert!(text.out.contains(name), "{}", text.out);
    }
    assert!(text.out.contains("--limit KEY=VALUE"));
    let changed = latchgate(&["limits", "--format", "json", "--limit", "text_bytes=2GiB"]);
    assert_eq!(changed.document()["limits"][0]["value"], 2_u64 << 30);
}

#[test]
fn cli_a_limit_that_is_none_is_wrong_usage() {
    for (assignment, words) in [
        ("text_byte=5", "did you mean `text_bytes`?"),
        ("samples=0", "whole number from 1"),
        ("samples=-3", "whole number from 1"),
        ("samples=4KiB", "whole number from 1"),
        ("samples", "whole number from 1"),
        ("text_bytes=99999999999GiB", "KiB, MiB and GiB"),
        ("line_bytes=1.5", "whole number from 1"),
    ] {
        let done = latchgate(&["limits", "--limit", assignment]);
        assert_eq!(done.code, 2, "{assignment}: {}", done.err);
        assert!(done.err.contains(words), "{assignment}: {}", done.err);
    }
}

/// Each limit, made small, is crossed by a small file and named; in the library as well.
#[test]
fn verif_every_limit_of_a_table_is_kept() {
    let bytes = table(weak).into_bytes();
    for name in [
        "text_bytes",
        "line_bytes",
        "lines",
        "samples",
        "columns",
        "table_cells",
    ] {
        let mut limits = Limits::default();
        limits.set(&format!("{name}=1")).unwrap();
        let source = Source::bytes("a.csv", bytes.clone());
        let error =
            latchgate_recording::read(&source, &ReadOptions::default(), Selection::Every, &limits)
                .unwrap_err();
        assert!(
            matches!(error.kind(), ErrorKind::LimitExceeded { limit, .. } if *limit == name),
            "{name}: {error}"
        );
        assert!(error.place().byte.is_some(), "{name}: {error}");
    }
}
