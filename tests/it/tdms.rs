//! TDMS files: read to the last bit as npTDMS reads them, judged as the same samples in another
//! format, and never better when they are damaged.

use crate::support::tdms::{F64, I16, INTERLEAVED, LITTLE, Property, Raw, Said, text};
use crate::support::{Folder, Random, data, json, latchgate, read_path, with_channel};
use latchgate::pipeline::{
    CardPolarity, Control, Design, Document, Extras, Limits, Request, Source, judge,
};
use latchgate_recording::{ReadOptions, Selection, Severity};
use std::collections::BTreeMap;

/// Files of `tests/data/tdms/`, with what npTDMS finds in them.
#[test]
fn val_every_sample_is_that_of_nptdms() {
    let truth = json("tdms/truth.json");
    let mut files: BTreeMap<&str, Vec<(String, Vec<u64>)>> = BTreeMap::new();
    for channel in truth.as_array().unwrap() {
        let word = |key: &str| channel[key].as_str().unwrap();
        let bits = channel["bits"].as_array().unwrap().iter();
        let bits = bits.map(|one| u64::from_str_radix(one.as_str().unwrap(), 16).unwrap());
        let entry = files.entry(word("file")).or_default();
        entry.push((word("channel").into(), bits.collect()));
    }
    assert_eq!(files.len(), 9);
    let mut samples = 0;
    for (file, channels) in files {
        let path = data(&format!("tdms/{file}"));
        let recording = read_path(&path, &ReadOptions::default(), Selection::Every).unwrap();
        assert_eq!(recording.channels.len(), channels.len(), "{file}");
        // The first word of a name is that of its group.
        let group = |name: &str| name.split(' ').next().unwrap_or_default().to_string();
        let counts: Vec<(String, usize)> = channels
            .iter()
            .map(|(name, bits)| (group(name), bits.len()))
            .collect();
        for (name, bits) in channels {
            let mut found = recording.channels.iter();
            let found = found.find(|one| one.name == name).unwrap();
            let own: Vec<u64> = found.values.iter().map(|value| value.to_bits()).collect();
            assert_eq!(own, bits, "{file} {name}");
            assert_eq!(found.rate.hertz(), 10_000.0, "{file} {name}");
            let is_stamped = file == "stamps.tdms";
            let start_s = if is_stamped { 0.0 } else { -1e-3 };
            assert_eq!(found.start_s, start_s, "{file} {name}");
            let blocks =
                |finding: &latchgate_recording::Finding| finding.severity == Severity::Blocking;
            let is_blocked = found.findings.iter().any(blocks);
            // Segments leave out samples of it that another channel has: the later ones have no place in time.
            let is_left_out = counts
                .iter()
                .any(|(other, count)| *other == group(&name) && bits.len() + 1 < *count);
            assert_eq!(
                is_blocked,
                file == "unclosed.tdms" || is_left_out,
                "{file} {name}: {:?}",
                found.findings
            );
            samples += bits.len();
        }
    }
    assert!(samples > 1000, "{samples}");
}

fn judged(source: &Source, request: &Request) -> Document {
    let design = Design::reference();
    let (limits, control) = (Limits::default(), Control::default());
    judge(
        source,
        request,
        &design,
        Extras::default(),
        &limits,
        &control,
    )
    .document
}

/// The lateral curves of a crash test, with all that its header says of a channel.
#[test]
fn val_nhtsa_curves_as_tdms_give_the_verdicts_of_their_own_format() {
    let header = data("recordings/nhtsa_v07292.EV5");
    let lines = std::fs::read_to_string(&header).unwrap();
    for number in ["38", "56", "146", "148", "150"] {
        let recording = read_path(&header, &with_channel(number), Selection::Lateral).unwrap();
        let channel = &recording.channels[0];
        let line = lines
            .lines()
            .find(|line| line.split('|').nth(1) == Some(number))
            .unwrap();
        let fields: Vec<&str> = line.split('|').collect();
        let value = |field: usize| Said::Number(fields[field].parse().unwrap());
        let said: [Property<'_>; 8] = [
            ("unit_string", text("g")),
            ("wf_increment", Said::Number(1.0 / channel.rate.hertz())),
            ("wf_start_offset", Said::Number(channel.start_s)),
            ("wf_xunit_string", text("s")),
            ("PREFIL", value(8)),
            ("INSRAT", value(11)),
            ("DASTAT", text(fields[17])),
            ("INSCOM", text(fields[19])),
        ];
        let path = format!("/'V07292'/'{number}'");
        let object = LITTLE.object(&path, Raw::Numbers(F64, channel.values.len() as u64), &said);
        let samples = channel.values.iter().flat_map(|value| value.to_le_bytes());
        let bytes = LITTLE.segment(0, Some(&[object]), &samples.collect::<Vec<u8>>());
        for opens_when in [CardPolarity::Negative, CardPolarity::Positive] {
            let request = Request {
                members: 128,
                channel: Some(number.into()),
                opens_when: Some(opens_when),
                ..Request::default()
            };
            let own = judged(&Source::File(header.clone()), &request);
            let other = Source::bytes("v07292.tdms", bytes.clone());
            let other = judged(
                &other,
                &Request {
                    channel: None,
                    ..request
                },
            );
            assert_eq!(
                own.verdict, other.verdict,
                "{number}: {:?} {:?}",
                own.why, other.why
            );
            let signal = |document: &Document| {
                let recording = &document.recording;
                (recording.content_sha256.clone(), recording.samples)
            };
            assert_eq!(signal(&own), signal(&other), "{number}");
            assert_eq!(own.nominal, other.nominal, "{number}");
            assert_eq!(own.ensemble, other.ensemble, "{number}");
        }
    }
}

/// A push of 30 g for 20 ms, which opens the lever by far, in two segments; the record goes on for
/// 80 ms.
fn failing() -> Vec<u8> {
    let value = |k: i32| match (0..200).contains(&k) {
        true => -30.0 * (std::f64::consts::PI * f64::from(k) / 200.0).sin(),
        false => 0.05 * (0.91 * f64::from(k)).sin(),
    };
    let samples = |from: i32, to: i32| {
        let bytes = (from..to).flat_map(|k| value(k).to_le_bytes());
        bytes.collect::<Vec<u8>>()
    };
    let said = [
        ("unit_string", text("g")),
        ("wf_increment", Said::Number(1e-4)),
        ("wf_start_offset", Said::Number(-0.02)),
        ("description", text("B-pillar, lower")),
    ];
    let object = LITTLE.object("/'Vehicle'/'acc y'", Raw::Numbers(F64, 500), &said);
    let file = LITTLE.object("/", Raw::Absent, &[("title", text("side impact"))]);
    let again = LITTLE.object("/'Vehicle'/'acc y'", Raw::AsBefore, &[]);
    [
        LITTLE.segment(0, Some(&[file, object]), &samples(-200, 300)),
        LITTLE.segment(0, Some(&[again]), &samples(300, 800)),
    ]
    .concat()
}

/// Judges a damaged file, which may be refused, unusable, undecided or fail.
#[track_caller]
fn check_no_pass(what: &str, bytes: Vec<u8>) -> String {
    let request = Request {
        members: 0,
        opens_when: Some(CardPolarity::Negative),
        ..Request::default()
    };
    let document = judged(&Source::bytes("a.tdms", bytes), &request);
    let verdict = document.verdict.name();
    assert_ne!(verdict, "pass", "{what}");
    verdict.to_string()
}

#[test]
fn verif_a_damaged_tdms_file_never_passes_where_the_sound_one_fails() {
    let sound = failing();
    assert_eq!(check_no_pass("sound", sound.clone()), "fail");
    for length in (0..sound.len()).step_by(64) {
        check_no_pass(
            &format!("cut after {length} bytes"),
            sound[..length].to_vec(),
        );
    }
    let flipped = |bit: usize| {
        let mut bytes = sound.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        bytes
    };
    // Each bit before the first sample and between the two segments, and 2000 anywhere.
    let first = memchr::memmem::find(&sound, b"B-pillar, lower").unwrap() + 15;
    let second = memchr::memmem::rfind(&sound, b"TDSm").unwrap();
    let between = sound.len() - 500 * 8;
    let mut bits: Vec<usize> = (0..8 * first).chain(8 * second..8 * between).collect();
    let mut random = Random::new(7);
    bits.extend((0..2000).map(|_| random.below(8 * sound.len())));
    for bit in bits {
        check_no_pass(&format!("bit {bit} flipped"), flipped(bit));
    }
}

/// The same push as counts of 3 g, with the chain of scales that says so.
fn failing_counts() -> Vec<u8> {
    let value = |k: i32| match (0..200).contains(&k) {
        true => -60.0 * (std::f64::consts::PI * f64::from(k) / 200.0).sin(),
        false => 0.0,
    };
    let counts = (-200..800).flat_map(|k| ((value(k) / 3.0).round() as i16).to_le_bytes());
    let said = [
        ("NI_Number_Of_Scales", Said::Count(2)),
        ("NI_Scaling_Status", text("unscaled")),
        ("NI_Scale[0]_Scale_Type", text("Linear")),
        ("NI_Scale[0]_Linear_Slope", Said::Number(3.0)),
        ("NI_Scale[0]_Linear_Y_Intercept", Said::Number(0.0)),
        ("NI_Scale[0]_Linear_Input_Source", Said::Count(u32::MAX)),
        ("NI_Scale[1]_Scale_Type", text("Linear")),
        ("NI_Scale[1]_Linear_Slope", Said::Number(1.0)),
        ("NI_Scale[1]_Linear_Y_Intercept", Said::Number(0.0)),
        ("NI_Scale[1]_Linear_Input_Source", Said::Count(0)),
        ("unit_string", text("g")),
        ("wf_increment", Said::Number(1e-4)),
        ("wf_start_offset", Said::Number(-0.02)),
    ];
    let object = LITTLE.object("/'Vehicle'/'acc y'", Raw::Numbers(I16, 1000), &said);
    LITTLE.segment(0, Some(&[object]), &counts.collect::<Vec<u8>>())
}

/// Each bit of what says of a scale; but not of slope and intercept, which are numbers like samples.
#[test]
fn verif_counts_whose_scale_is_damaged_never_pass() {
    let sound = failing_counts();
    assert_eq!(check_no_pass("sound", sound.clone()), "fail");
    let at = |what: &[u8]| memchr::memmem::find(&sound, what).unwrap();
    let (first, last) = (at(b"NI_Number_Of_Scales"), at(b"unit_string"));
    let mut numbers = Vec::new();
    for key in ["Linear_Slope", "Linear_Y_Intercept"] {
        let found = memchr::memmem::find_iter(&sound, key.as_bytes());
        numbers.extend(found.map(|at| at + key.len() + 4));
    }
    let is_number = |byte: usize| numbers.iter().any(|from| (*from..from + 8).contains(&byte));
    for byte in (first - 4..last).filter(|byte| !is_number(*byte)) {
        for bit in 0..8 {
            let mut bytes = sound.clone();
            bytes[byte] ^= 1 << bit;
            check_no_pass(&format!("bit {bit} of byte {byte} flipped"), bytes);
        }
    }
}

/// A channel of times that comes once samples are no longer kept is not passed over.
#[test]
fn regress_late_times_beyond_the_limit_are_named() {
    let said = [("unit_string", text("g"))];
    let half = |raw| LITTLE.object("/'g'/'acc y'", raw, &said);
    let other = LITTLE.object(
        "/'g'/'note z'",
        Raw::Numbers(F64, 250),
        &[("unit_string", text("V"))],
    );
    let time = LITTLE.object(
        "/'g'/'Time'",
        Raw::Numbers(F64, 200),
        &[("unit_string", text("s"))],
    );
    let bytes = [
        LITTLE.segment(
            0,
            Some(&[half(Raw::Numbers(F64, 100)), other]),
            &vec![0; 350 * 8],
        ),
        LITTLE.segment(0, Some(&[half(Raw::AsBefore), time]), &vec![0; 300 * 8]),
    ]
    .concat();
    let limits = Limits {
        test_samples: 320,
        ..Limits::default()
    };
    let source = Source::bytes("a.tdms", bytes);
    let options = with_channel("acc y");
    let read = latchgate_recording::read(&source, &options, Selection::Lateral, &limits);
    let error = read.unwrap_err().to_string();
    assert!(error.contains("limit test_samples"), "{error}");
}

/// Of many short segments that change nothing of a long list none goes through it again, which took minutes.
#[test]
fn regress_many_properties_and_short_segments_take_linear_time() {
    let keys: Vec<String> = (0..40_000).map(|k| format!("p{k}")).collect();
    let said: Vec<Property<'_>> = keys.iter().map(|key| (&**key, Said::Count(1))).collect();
    let many = LITTLE.object("/", Raw::Absent, &said);
    let names: Vec<String> = (0..2000).map(|k| format!("/'g'/'n{k}'")).collect();
    let mut objects: Vec<Vec<u8>> = vec![many];
    objects.extend(
        names
            .iter()
            .map(|name| LITTLE.object(name, Raw::Numbers(F64, 1), &[])),
    );
    let mut bytes = LITTLE.segment(0, Some(&objects), &vec![0; 8 * 2000]);
    let empty = LITTLE.with_end(8, None, &[], |end| end);
    bytes.extend(empty.repeat(200_000));
    let path = Folder::new("tdms-work");
    let path = path.write("a.tdms", bytes);
    let done = latchgate(&["inspect", &path, "--log", "json:debug"]);
    let line = done.err.lines().find(|line| line.contains("segments read"));
    let event: serde_json::Value = serde_json::from_str(line.unwrap()).unwrap();
    assert_eq!(event["segments"], 200_001);
    // Each object and property as it is listed, and the objects again for the list and for its one chunk.
    assert_eq!(event["steps"], 2001 + 40_000 + 2001 + 2000);
}

/// A damaged file, the time column and limits that are asked for, and what the message says.
type Damage<'a> = (Vec<u8>, Option<&'a str>, &'a [(&'a str, u64)], &'a str);

/// What each message of a file that is damaged, or beyond a limit, says.
#[test]
fn verif_each_damage_is_named() {
    const PATH: &str = "/'g'/'acc y'";
    let own = [
        ("unit_string", text("g")),
        ("wf_increment", Said::Number(1e-4)),
    ];
    let two = Raw::Numbers(F64, 2);
    let data: Vec<u8> = [1.0_f64, 2.0].map(f64::to_le_bytes).concat();
    let of = |path: &str, raw, said: &[Property<'_>], data: &[u8]| {
        LITTLE.segment(0, Some(&[LITTLE.object(path, raw, said)]), data)
    };
    let sound = of(PATH, two, &own, &data);
    let patched = |at: usize, bytes: &[u8]| {
        let mut patched = sound.clone();
        patched[at..at + bytes.len()].copy_from_slice(bytes);
        patched
    };
    let metadata = u64::from_le_bytes(sound[20..28].try_into().unwrap());
    let index = [20, F64, 1].map(u32::to_le_bytes).concat();
    let index = memchr::memmem::find(&sound, &index).unwrap();
    let list = |flags, raws: [Raw; 2], data: &[u8]| {
        let objects = [
            LITTLE.object(PATH, raws[0], &own),
            LITTLE.object("/'g'/'Time'", raws[1], &[("unit_string", text("s"))]),
        ];
        LITTLE.segment(flags, Some(&objects), data)
    };
    let many: Vec<String> = (0..9).map(|k| format!("p{k}")).collect();
    let many: Vec<Property<'_>> = many.iter().map(|key| (&**key, Said::Count(1))).collect();
    let text_object = |bytes| LITTLE.object("/'g'/'word'", Raw::Texts(1, bytes), &[]);
    let texts = |bytes: &[u8]| {
        let object = text_object(bytes.len() as u64);
        LITTLE.segment(0, Some(&[object]), bytes)
    };
    let scaled = [
        ("NI_Number_Of_Scales", Said::Count(1)),
        ("NI_Scale[0]_Scale_Type", text("Linear")),
        ("NI_Scale[0]_Linear_Slope", Said::Number(1e308)),
        ("NI_Scale[0]_Linear_Y_Intercept", Said::Number(0.0)),
    ];
    let late = [own[0], own[1], ("wf_start_offset", text("soon"))];
    let nan = [0.0, f64::NAN].map(f64::to_le_bytes).concat();
    let (clocked, three) = ([two, two], [two, Raw::Numbers(F64, 3)]);
    let five = vec![0; 40];
    let none: &[(&str, u64)] = &[];
    let time = Some("Time");
    let cases: [Damage<'_>; 25] = [
        (
            patched(12, &3_u64.to_le_bytes()),
            None,
            none,
            "an end of the segment behind",
        ),
        (
            patched(4, &[6]),
            None,
            none,
            "no samples, as the flags of the segment say",
        ),
        (
            patched(4, &[12]),
            None,
            none,
            "no metadata, as the flags of the segment say",
        ),
        (
            patched(index + 8, &[2]),
            None,
            none,
            "a raw data index of 20 bytes and dimension 1",
        ),
        (
            of("/'g'", two, &own, &data),
            None,
            none,
            "samples of channels alone",
        ),
        (
            patched(20, &(metadata + 8).to_le_bytes()),
            None,
            none,
            "bytes that belong to neither",
        ),
        (
            patched(20, &(metadata - 4).to_le_bytes()),
            None,
            none,
            "a property within the metadata",
        ),
        (
            LITTLE.segment(0, None, &data),
            None,
            none,
            "a list of channels in the first segment",
        ),
        (
            list(INTERLEAVED, three, &five),
            None,
            none,
            "as many of each channel",
        ),
        (
            texts(&[9; 8]),
            None,
            none,
            "texts with their ends before them",
        ),
        (sound.clone(), None, &[("samples", 1)], "limit samples"),
        (
            sound.clone(),
            None,
            &[("headers_bytes", 10)],
            "headers_bytes of 10 crossed: found metadata of 96 bytes",
        ),
        (
            of(PATH, two, &many, &data),
            None,
            &[("headers_bytes", 400)],
            "more bytes of properties",
        ),
        (
            texts(&[0; 500]),
            None,
            &[("headers_bytes", 400)],
            "500 bytes of text in a chunk",
        ),
        (
            list(0, clocked, &[0; 32]),
            None,
            &[("columns", 1)],
            "2 objects in a segment",
        ),
        (
            [sound.clone(), of("/'g'/'b'", two, &own, &data)].concat(),
            None,
            &[("columns", 1)],
            "more channels and groups",
        ),
        (
            of("/'g'/'Time'", two, &own[1..], &data),
            None,
            none,
            "no channel of numbers with samples",
        ),
        (
            of(PATH, two, &[&own[..], &scaled].concat(), &data),
            None,
            none,
            "inf as sample 2 after",
        ),
        (
            of(PATH, two, &late, &data),
            None,
            none,
            "a time of the first sample",
        ),
        (
            list(0, clocked, &[&data[..], &nan].concat()),
            time,
            none,
            "no number as sample 2",
        ),
        (list(0, three, &five), time, none, "3 times for 2 samples"),
        (sound.clone(), time, none, "0 of them; name it by"),
        (
            of(PATH, Raw::AsBefore, &own, &data),
            None,
            none,
            "a raw data index of a channel, found one as before, and none before",
        ),
        (
            patched(index + 4, &[99]),
            None,
            none,
            "a type of data that TDMS has, found a type 0x63",
        ),
        (
            [
                sound.clone(),
                of(
                    PATH,
                    Raw::AsBefore,
                    &[("unit_string", text("m/s^2"))],
                    &data,
                ),
            ]
            .concat(),
            None,
            none,
            "after 2 samples; save each recording as a file of its own",
        ),
    ];
    let mut others = Vec::new();
    for (bytes, time_column, changes, says) in cases {
        let mut limits = Limits::default();
        for (name, value) in changes {
            limits.set(&format!("{name}={value}")).unwrap();
        }
        let options = ReadOptions {
            time_column: time_column.map(String::from),
            ..ReadOptions::default()
        };
        let source = Source::bytes("a.tdms", bytes);
        let read = latchgate_recording::read(&source, &options, Selection::Lateral, &limits);
        let error = read.expect_err(says).to_string();
        if !error.contains(says) {
            others.push(format!("{says}: {error}"));
        }
    }
    assert!(others.is_empty(), "{others:#?}");
    let empty = [list(0, [two, Raw::Absent], &data), sound].concat();
    let read = |channel| {
        let (source, limits) = (Source::bytes("a.tdms", empty.clone()), Limits::default());
        latchgate_recording::read(&source, &with_channel(channel), Selection::Lateral, &limits)
    };
    assert!(read("acc y").is_ok());
    let error = read("Time").unwrap_err().to_string();
    assert!(error.contains("channel Time holds no sample"), "{error}");
}

/// Of more samples than are kept the one channel that is meant is judged all the same.
#[test]
fn verif_the_channel_that_is_meant_outlives_the_limit_on_all() {
    let clock = [
        ("unit_string", text("g")),
        ("wf_increment", Said::Number(1e-4)),
    ];
    let objects: Vec<Vec<u8>> = ["acc x", "acc y", "acc z"]
        .map(|name| LITTLE.object(&format!("/'g'/'{name}'"), Raw::Numbers(F64, 100), &clock))
        .into();
    let chunk: Vec<u8> = (0..300).flat_map(|k| f64::from(k).to_le_bytes()).collect();
    let bytes = LITTLE.segment(0, Some(&objects), &chunk.repeat(20));
    let limits = Limits {
        test_samples: 3000,
        ..Limits::default()
    };
    let source = Source::bytes("a.tdms", bytes);
    let read = |channel: Option<&str>, selection| {
        let options = ReadOptions {
            channel: channel.map(String::from),
            ..ReadOptions::default()
        };
        let read = latchgate_recording::read(&source, &options, selection, &limits);
        read.map_err(|error| error.to_string())
    };
    for channel in [None, Some("acc y")] {
        let recording = read(channel, Selection::Lateral).unwrap();
        let values = &recording.channels[0].values;
        let expected: Vec<f64> = (0..2000).map(|k| f64::from(100 + k % 100)).collect();
        assert_eq!(*values, expected);
    }
    let error = read(None, Selection::Every).unwrap_err();
    assert!(error.contains("limit test_samples"), "{error}");
    // Where it is not clear which channel is meant, none is kept.
    let error = read(Some("acc"), Selection::Lateral).unwrap_err();
    assert!(error.contains("limit test_samples"), "{error}");
}

/// Messages name channels in full, so that a name must not be as long as the file.
#[test]
fn regress_a_path_has_a_longest_length() {
    let path = format!("/'Door'/'{}'", "y".repeat(3000));
    let object = LITTLE.object(&path, Raw::Numbers(F64, 2), &[]);
    let source = Source::bytes("a.tdms", LITTLE.segment(0, Some(&[object]), &[0; 16]));
    let options = ReadOptions::default();
    let read = latchgate_recording::read(&source, &options, Selection::Every, &Limits::default());
    let error = read.unwrap_err().to_string();
    assert!(error.contains("a path of at most 2048 bytes"), "{error}");
}

/// A channel that a segment leaves out while another one of its group goes on is shorter than that; where
/// its samples are missing nothing tells.
#[test]
fn regress_a_channel_that_a_segment_leaves_out_is_blocked() {
    let said = |interval_s| {
        [
            ("unit_string", text("g")),
            ("wf_increment", Said::Number(interval_s)),
        ]
    };
    let half = vec![0; 100 * 8];
    let read = |other_interval_s, counts: [u64; 2]| {
        let object = |path, raw, interval_s| LITTLE.object(path, raw, &said(interval_s));
        let both = |raws: [Raw; 2]| {
            let y = object("/'g'/'acc y'", raws[0], 1e-4);
            [y, object("/'g'/'acc x'", raws[1], other_interval_s)]
        };
        let first = LITTLE.segment(0, Some(&both([Raw::Numbers(F64, 100); 2])), &half.repeat(2));
        let raws = counts.map(|count| match count {
            0 => Raw::Absent,
            count => Raw::Numbers(F64, count),
        });
        let samples = vec![0; 8 * (counts[0] + counts[1]) as usize];
        let second = LITTLE.segment(0, Some(&both(raws)), &samples);
        let source = Source::bytes("a.tdms", [first, second].concat());
        let (options, limits) = (with_channel("acc y"), Limits::default());
        let read = latchgate_recording::read(&source, &options, Selection::Lateral, &limits);
        let findings = read.unwrap().channels[0].findings.clone();
        let mut missing = findings
            .into_iter()
            .filter(|one| one.code == "samples-missing");
        missing.next().map(|one| (one.severity, one.at_s, one.text))
    };
    let (severity, at_s, says) = read(1e-4, [0, 100]).unwrap();
    assert_eq!((severity, at_s), (Severity::Blocking, None));
    let found = "the channel `acc x` holds 200 samples by the same clock, but this channel 100";
    assert!(says.contains(found), "{says}");
    for (interval_s, counts) in [(1e-4, [100, 100]), (1e-4, [99, 100]), (1e-5, [0, 100])] {
        assert_eq!(read(interval_s, counts), None, "{interval_s} {counts:?}");
    }
}
