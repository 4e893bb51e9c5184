//! Recordings of which nobody states that they may be copied (`tests/data/README.md`). They lie in
//! `../shared/recordings`, beside the project, or they do not; so this is no part of `cargo test`:
//!
//! ```text
//! cargo test --test beside
//! ```

#![allow(missing_docs, reason = "tests are read, not linked")]
#![allow(clippy::unwrap_used, clippy::float_cmp, reason = "tests may")]

use latchgate::pipeline::{
    self, Answer, Control, Design, Extras, Limits, Outcome, Request, Source,
};
use latchgate_kernel::units::AccelerationUnit;
use latchgate_recording::{ReadOptions, Selection, read};
use std::path::Path;

/// Largest values of the columns of a real workbook, as xlrd reads them.
const LARGEST: [f64; 3] = [48.963, 9.9124, 16.518];

fn source(name: &str) -> Source {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/recordings");
    Source::File(folder.join(name))
}

fn judged(name: &str, channel: Option<&str>) -> Outcome {
    let request = Request {
        members: 0,
        channel: channel.map(str::to_string),
        ..Request::default()
    };
    let (design, limits) = (Design::reference(), Limits::default());
    let control = Control::default();
    pipeline::judge(
        &source(name),
        &request,
        &design,
        Extras::default(),
        &limits,
        &control,
    )
}

#[track_caller]
fn check_refused(name: &str, words: &[&str]) {
    let outcome = judged(name, None);
    assert_eq!(outcome.document.verdict, Answer::Unusable, "{name}");
    let said = outcome.refusal.expect("nothing was read").to_string();
    for word in words {
        assert!(said.contains(word), "{name}: `{word}` in {said}");
    }
}

#[test]
fn val_files_that_are_no_recordings_are_named() {
    check_refused("cougars_SO_bag_metadata.yaml", &["metadata.yaml"]);
}

/// A sheet of numbers without names, all of which a person has to state; the largest value of each column
/// is that of xlrd.
#[test]
fn val_a_real_workbook_is_read() {
    let name = "nhtsa_frontal_head_honda_crv.xls";
    check_refused(name, &["4 columns of numbers without names"]);
    for (channel, largest) in [("2", LARGEST[0]), ("3", LARGEST[1]), ("4", LARGEST[2])] {
        let options = ReadOptions {
            skip_lines: Some(0),
            time_column: Some("1".into()),
            channel: Some(channel.into()),
            unit: Some(AccelerationUnit::StandardGravity),
            ..ReadOptions::default()
        };
        let limits = Limits::default();
        let found = read(&source(name), &options, Selection::Lateral, &limits).unwrap();
        let values = found.channels[0].values.iter();
        let peak = values.fold(0.0_f64, |peak, value| peak.max(value.abs()));
        assert_eq!(peak.to_bits(), largest.to_bits(), "{channel}");
    }
}

/// A robot's log at 10 Hz is offered, its topics naming a robot; the channel that is asked for is read,
/// the first value being that of an independent reader, and is no crash recording.
#[test]
fn val_a_real_robot_log_is_read_and_unusable() {
    let name = "cougars_SO_bag_0.ros2.mcap";
    let asked = "/coug2/modem_imu:linear_acceleration.y";
    check_refused(name, &[asked, "`coug2`"]);
    let request = Request {
        channel: Some(asked.into()),
        ..Request::default()
    };
    let options = request.read_options(&pipeline::Card::default());
    let limits = Limits::default();
    let found = read(&source(name), &options, Selection::Lateral, &limits).unwrap();
    let channel = &found.channels[0];
    assert_eq!(channel.name, asked);
    assert_eq!(channel.values[0], -0.732_854_643_151_761_6);
    assert_eq!(channel.values.len(), 158);
    assert!((9.8..10.1).contains(&channel.rate.hertz()));
    assert_eq!(found.findings, []);

    let outcome = judged(name, Some(asked));
    assert!(outcome.refusal.is_none());
    assert_eq!(outcome.document.verdict, Answer::Unusable);
    let found = |code: &str| {
        outcome
            .document
            .findings
            .iter()
            .find(|one| one.code == code)
    };
    assert!(found("low-rate").is_some() && found("stamp-zero").is_some());
    assert_eq!(found("gap").and_then(|gap| gap.at_s), Some(0.272_027_638));
}

/// Of 35 lateral accelerations of a real side impact that its laboratory calls measured, none
/// carries a remark that blocks: plain words of places do not train people to accept.
#[test]
fn val_no_sound_channel_of_a_real_test_is_held_up_by_its_remark() {
    let Source::File(path) = source("nhtsa_v07292.EV5") else {
        unreachable!("a file")
    };
    let header = String::from_utf8_lossy(&std::fs::read(path).unwrap()).into_owned();
    let folder = std::env::temp_dir().join(format!("latchgate-beside-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let rows: String = (0..500)
        .map(|k| format!("{:.6}\t{k}\n", f64::from(k) / 12_500.0))
        .collect();
    let (mut channels, mut shown, mut blocked) = (0, Vec::new(), Vec::new());
    for line in header.lines() {
        let mut cells: Vec<&str> = line.split('|').collect();
        if cells.len() != 20 || cells[2] != "AC" || !cells[5].starts_with('Y') || cells[17] != "AM"
        {
            continue;
        }
        (cells[14], cells[15], cells[16]) = ("0", "499", "80");
        let curve = folder.join(format!("v1.{:0>3}", cells[1]));
        let text = format!("----- INSTRUMENTATION -----\n{}", cells.join("|"));
        std::fs::write(folder.join("v1.EV5"), text).unwrap();
        std::fs::write(&curve, &rows).unwrap();
        let options = Request::default().read_options(&pipeline::Card::default());
        let source = Source::File(curve.clone());
        let found = read(&source, &options, Selection::Lateral, &Limits::default()).unwrap();
        std::fs::remove_file(curve).unwrap();
        channels += 1;
        for finding in &found.channels[0].findings {
            if finding.code == "laboratory-remark" {
                match finding.severity {
                    pipeline::Severity::Blocking => blocked.push(finding.text.clone()),
                    _ => shown.push(finding.text.clone()),
                }
            }
        }
    }
    std::fs::remove_dir_all(folder).unwrap();
    assert_eq!((channels, blocked), (35, Vec::<String>::new()));
    assert_eq!(
        shown,
        ["the laboratory says of this channel: \"THORAX CG\""]
    );
}

/// Of 24 nominal runs of a real crash test, six channels in both directions on both stops, none passes by one seed
/// and fails by another. Those whose answer moves with the seed are printed.
#[test]
fn val_no_real_scene_passes_by_one_seed_and_fails_by_another() {
    let (mut scenes, mut passing, mut changing) = (0, 0, Vec::new());
    for number in 145..=150 {
        let name = format!("nhtsa_v07292.{number}");
        let mut by_scene: Vec<(String, Vec<Answer>)> = Vec::new();
        for seed in 1..=12 {
            let request = Request {
                members: 0,
                seed,
                ..Request::default()
            };
            let prepared = pipeline::Prepared::open(
                &source(&name),
                &request,
                &Limits::default(),
                &Control::default(),
            )
            .unwrap();
            let document = prepared
                .judge(
                    &Design::reference(),
                    Extras::default(),
                    &Control::unwatched(2),
                )
                .document;
            for (place, answer) in document.answers.iter().enumerate() {
                if seed == 1 {
                    let scene = format!("{number} {:?} {:?}", answer.opens_when, answer.model);
                    by_scene.push((scene, Vec::new()));
                }
                by_scene[place].1.push(answer.answer);
            }
        }
        for (scene, answers) in by_scene {
            let (passes, fails) = (
                answers.contains(&Answer::Pass),
                answers.contains(&Answer::Fail),
            );
            assert!(!(passes && fails), "{scene}: {answers:?}");
            scenes += 1;
            passing += usize::from(passes);
            if answers.iter().any(|answer| *answer != answers[0]) {
                changing.push((scene, answers));
            }
        }
    }
    println!(
        "{scenes} scenes, {passing} of them pass; the answer changes with the seed: {changing:?}"
    );
    assert_eq!(scenes, 24);
}
