//! Recordings of others (`tests/data/README.md`): each gives the right answer at the process
//! boundary.

use crate::support::{data, latchgate};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// A file, and what it must give.
struct Real {
    name: &'static str,
    /// What is read: channel, unit, samples, rate [Hz]; `None` where it is refused.
    read: Option<(&'static str, &'static str, u64, f64)>,
    /// Findings that must be there, with the instant where they begin.
    finds: &'static [(&'static str, Option<f64>)],
    /// Words of the message; empty where there must be an answer.
    says: &'static [&'static str],
}

const fn refused(name: &'static str, says: &'static [&'static str]) -> Real {
    Real {
        name,
        read: None,
        finds: &[],
        says,
    }
}

const fn curve(name: &'static str, channel: &'static str) -> Real {
    Real {
        name,
        read: Some((channel, "g", 4126, 12_500.0)),
        finds: &[],
        says: &[],
    }
}

const ALL: &[Real] = &[
    curve("nhtsa_v07292.146", "146 V1 AC DSLF YG"),
    curve("nhtsa_v07292.148", "148 V1 AC DSRF YG"),
    curve("nhtsa_v07292.150", "150 V1 AC VECG YG"),
    Real {
        finds: &[("channel-not-lateral", None)],
        ..curve("nhtsa_v07292.145", "145 V1 AC DSLF XG")
    },
    Real {
        finds: &[("channel-not-lateral", None)],
        ..curve("nhtsa_v07292.147", "147 V1 AC DSRF XG")
    },
    Real {
        finds: &[("channel-not-lateral", None)],
        ..curve("nhtsa_v07292.149", "149 V1 AC VECG XG")
    },
    Real {
        finds: &[
            ("laboratory-remark", Some(0.0646)),
            ("invalid-by-laboratory", Some(0.0646)),
            ("clipping", Some(0.064_56)),
        ],
        says: &["NO VALID DATA AFTER 64.6 MILLISECONDS"],
        ..curve("nhtsa_v07292.038", "38 V1 AC seat 01 FOTL YL")
    },
    Real {
        finds: &[
            ("laboratory-remark", Some(0.0614)),
            ("invalid-by-laboratory", Some(0.0614)),
            ("clipping", Some(0.062)),
        ],
        says: &["EXCEEDED FULL SCALE AT 61.4 MILLSECONDS"],
        ..curve("nhtsa_v07292.056", "56 V1 AC seat 01 FOTR YL")
    },
    refused(
        "nhtsa_v07292.EV5",
        &[
            "several channels",
            "146 V1 AC DSLF YG",
            "148 V1 AC DSRF YG",
            "--channel",
        ],
    ),
    refused("canedge_vehicle_imu_finalized.MF4", &["ASAM MDF4", "CSV"]),
    refused(
        "canedge_vehicle_imu_unfinalized.MF4",
        &["unfinalised ASAM MDF4", "CSV"],
    ),
    refused("canedge_canmod-gps.dbc", &["canedge_canmod-gps.dbc"]),
    refused("canedge_gnss.dbc", &["canedge_gnss.dbc"]),
    refused(
        "mcapcrate_compressed.ros1.mcap",
        &[
            "/diagnostics",
            "/tf",
            "no channel carries a lateral acceleration",
        ],
    ),
    refused(
        "mcapcrate_chunk_not_closed.mcap",
        &["the file is cut", "all ones"],
    ),
    refused(
        "mcap_conformance_NoData_OneMessage_OneSchemalessMessage_OneMetadata.tar.gz",
        &["holds no ISO-MME test"],
    ),
    refused(
        "lvm_short.lvm",
        &[
            "no channel is clearly",
            "Response (Trigger) (`response` is no known word)",
        ],
    ),
    Real {
        name: "lvm_no_decimal_separator.lvm",
        read: Some(("ay", "g", 4, 4000.0)),
        finds: &[("starts-inside-event", None)],
        says: &["unusable"],
    },
    refused(
        "lvm_with_comments.lvm",
        &["no channel carries a lateral acceleration", "Temperatura"],
    ),
    refused(
        "lvm_with_empty_fields.lvm",
        &[
            "no channel is clearly",
            "Dev0/Ai0 (`dev0` is no known word)",
        ],
    ),
];

#[track_caller]
fn check(path: &Path, real: &Real) {
    let arguments = [
        "replay",
        path.to_str().unwrap(),
        "--no-report",
        "--members",
        "0",
    ];
    let declared = ["--opens-when", "negative", "--format", "json"];
    let done = latchgate(&[arguments.as_slice(), &declared].concat());
    let document = done.document();
    let name = real.name;
    for words in real.says {
        assert!(
            done.err.contains(words),
            "{name}: `{words}` in {}",
            done.err
        );
    }
    let answers = real.says.is_empty();
    assert_eq!(
        done.code == 4,
        !answers,
        "{name}: {} {}",
        done.code,
        done.err
    );
    assert!(done.code != 0 || answers, "{name}: a pass from a bad one");
    let recording = &document["recording"];
    if let Some((channel, unit, samples, rate)) = real.read {
        assert_eq!(recording["channel"], channel, "{name}");
        assert_eq!(recording["unit"], unit, "{name}");
        assert_eq!(recording["samples"], samples, "{name}");
        let found = recording["sample_rate_hz"].as_f64().unwrap();
        assert!((found / rate - 1.0).abs() < 1e-9, "{name}: {found} Hz");
    }
    let findings = document["findings"].as_array().unwrap();
    for (code, at) in real.finds {
        let found = findings.iter().find(|finding| finding["code"] == *code);
        let found = found.unwrap_or_else(|| panic!("{name}: no {code} in {findings:?}"));
        if let Some(at) = at {
            let place = found["at_s"].as_f64().unwrap();
            assert!((place - at).abs() < 1e-9, "{name}: {code} at {place} s");
        }
    }
    if answers {
        let blocking = |finding: &&Value| finding["severity"] == "blocking";
        assert_eq!(findings.iter().find(blocking), None, "{name}");
    }
    // A curve's meaning stands in the header beside it, so the header is part of what was read.
    if name.starts_with("nhtsa_v07292.") && real.read.is_some() {
        let parts = recording["parts"].as_array().unwrap();
        let files: Vec<&str> = parts
            .iter()
            .map(|part| part["file"].as_str().unwrap())
            .collect();
        assert_eq!(files, ["nhtsa_v07292.EV5"], "{name}");
    }
}

#[test]
fn val_every_real_recording_gives_the_right_answer() {
    for real in ALL {
        check(&data(&format!("recordings/{}", real.name)), real);
    }
    let known: BTreeSet<&str> = ALL.iter().map(|real| real.name).collect();
    for entry in fs::read_dir(data("recordings")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(known.contains(name.as_str()), "{name} is not looked at");
    }
}

/// From the header as well as from the curve itself: one signal, and every file that told of it.
#[test]
fn val_a_verdict_names_every_file_it_rests_on() {
    let header = data("recordings/nhtsa_v07292.EV5");
    let curve = data("recordings/nhtsa_v07292.146");
    let replayed = |arguments: &[&str]| {
        let common = [
            "--no-report",
            "--members",
            "0",
            "--opens-when",
            "negative",
            "--format",
            "json",
        ];
        latchgate(&[&["replay"], arguments, &common].concat()).document()["recording"].clone()
    };
    let by_header = replayed(&[header.to_str().unwrap(), "--channel", "146"]);
    let by_curve = replayed(&[curve.to_str().unwrap()]);
    assert_eq!(by_header["content_sha256"], by_curve["content_sha256"]);
    assert_eq!(by_header["parts"][0]["file"], "nhtsa_v07292.146");
    assert_eq!(by_header["parts"][0]["sha256"], by_curve["sha256"]);
    assert_eq!(by_curve["parts"][0]["sha256"], by_header["sha256"]);
    // The hash of the curve file as its source states it.
    let stated = "f00b4bb08ea57e37aa17d0e51e0299eb2075fda9ed5f9695396fd65c0f03bf77";
    assert_eq!(by_curve["sha256"], stated);
}
