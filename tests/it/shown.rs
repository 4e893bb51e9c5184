//! What a person sees of an answer: lines that fit, instants that are the document's, and no error
//! as large as its peak.

mod faults;

use crate::support::{data, latchgate};
use faults::faults;
use latchgate_document::Document;

/// Six real channels, each with every opening direction.
#[test]
fn val_real_answers_are_shown_as_a_person_can_read_them() {
    let mut wrong = Vec::new();
    // The second lever passes some of them, its stops with errors of different sizes.
    let levers = ["0.1", "3.6"];
    let channels = ["145", "146", "147", "148", "149", "150"];
    let asked = channels
        .iter()
        .flat_map(|channel| levers.map(|preload| (channel, preload)));
    for (channel, preload) in asked {
        for sign in ["negative", "positive", "both"] {
            let file = data(&format!("recordings/nhtsa_v07292.{channel}"));
            let file = file.to_str().unwrap();
            let set = format!("lever.preload_torque_nm={preload}");
            let asked = [
                "replay",
                file,
                "--opens-when",
                sign,
                "--set",
                &set,
                "--no-report",
            ];
            let json = latchgate(&[&asked[..], &["--format", "json"]].concat());
            let document: Document = serde_json::from_str(&json.out).unwrap();
            if let Some(opens) = &document.opens {
                check_earliest(&document, opens.first_s);
            }
            let faults = faults(&document);
            wrong.extend(
                faults
                    .into_iter()
                    .map(|fault| format!("{channel} {sign}: {fault}")),
            );
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

/// No nominal run crosses before the instant that the document names.
#[track_caller]
fn check_earliest(document: &Document, first_s: Option<f64>) {
    let runs = document
        .polarities
        .values()
        .flat_map(|stops| stops.values());
    let runs = document.models.values().chain(runs);
    let earliest = runs.filter_map(|run| run.first_crossing_s).reduce(f64::min);
    assert_eq!(first_s, earliest);
}
