//! Guards verdict.json: its keys, their types and order, the digits of its numbers, its sentences.

use crate::support::{Folder, data, latchgate, signal_file, table, weak};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::{self, RunOptions};
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY, SampleRate};
use latchgate_verdict::conditioning::between::{self, Between};
use serde_json::Value;

/// What a key holds.
#[derive(Debug, Clone, Copy)]
enum Kind {
    Text,
    Number,
    Count,
    Truth,
    List,
    Object,
    /// A number, or null where there is none.
    Maybe,
}

#[track_caller]
fn check_keys(at: &str, value: &Value, keys: &[(&str, Kind)]) {
    for (key, kind) in keys {
        let found = value
            .get(key)
            .unwrap_or_else(|| panic!("{at} has no key {key}"));
        let good = match kind {
            Kind::Text => found.is_string(),
            Kind::Number => found.is_f64(),
            Kind::Count => found.is_u64(),
            Kind::Truth => found.is_boolean(),
            Kind::List => found.is_array(),
            Kind::Object => found.is_object(),
            Kind::Maybe => found.is_f64() || found.is_null(),
        };
        assert!(good, "{at}.{key} should be {kind:?}, found {found}");
    }
}

const RUN: &[(&str, Kind)] = &[
    ("model", Kind::Text),
    ("method", Kind::Text),
    ("opens_when", Kind::Text),
    ("peak_angle_rad", Kind::Number),
    ("peak_time_s", Kind::Number),
    ("first_crossing_s", Kind::Maybe),
    ("time_above_threshold_s", Kind::Number),
    ("first_release_s", Kind::Maybe),
    ("impacts", Kind::Count),
    ("impact_list", Kind::List),
    ("final_angle_rad", Kind::Number),
    ("final_velocity_rad_s", Kind::Number),
    ("moving_at_end", Kind::Truth),
    ("coast_peak_angle_rad", Kind::Maybe),
    ("numerical_error_rad", Kind::Number),
    ("work", Kind::Object),
];

fn check_document(document: &Value) {
    check_keys(
        "",
        document,
        &[
            ("schema", Kind::Text),
            ("verdict", Kind::Text),
            ("why", Kind::List),
            ("threshold_rad", Kind::Number),
            ("models", Kind::Object),
            ("error_budget_rad", Kind::Object),
            ("screens", Kind::Object),
            ("findings", Kind::List),
            ("recording", Kind::Object),
            ("design", Kind::Object),
            ("decision_rule", Kind::Text),
            ("run", Kind::Object),
        ],
    );
    assert_eq!(document["schema"], "latchgate.verdict/1");
    for reason in document["why"].as_array().unwrap() {
        check_keys("why", reason, &[("code", Kind::Text), ("text", Kind::Text)]);
    }
    for finding in document["findings"].as_array().unwrap() {
        check_keys(
            "findings",
            finding,
            &[
                ("code", Kind::Text),
                ("severity", Kind::Text),
                ("text", Kind::Text),
                ("at_s", Kind::Maybe),
            ],
        );
    }
    check_keys(
        "error_budget_rad",
        &document["error_budget_rad"],
        &[
            ("numerical", Kind::Maybe),
            ("interpolation", Kind::Maybe),
            ("model", Kind::Maybe),
            ("filter", Kind::Maybe),
            ("bias", Kind::Maybe),
            ("polarity", Kind::Maybe),
        ],
    );
    check_keys(
        "screens",
        &document["screens"],
        &[
            ("static_threshold_g", Kind::Number),
            ("impulse_threshold_m_s", Kind::Number),
        ],
    );
    check_keys(
        "run",
        &document["run"],
        &[("version", Kind::Text), ("elapsed_s", Kind::Number)],
    );
    for key in ["lever", "stop", "criterion", "tolerance", "input"] {
        assert!(document["design"][key].is_object(), "design.{key}");
    }
}

#[test]
fn verif_the_document_has_every_key_with_its_type() {
    let document = latchgate(&[
        "replay",
        &signal_file("burst.csv"),
        "--no-report",
        "--format",
        "json",
    ])
    .document();
    check_document(&document);
    for run in [
        &document["nominal"],
        &document["models"]["rigid"],
        &document["models"]["soft"],
    ] {
        check_keys("run", run, RUN);
        check_keys(
            "work",
            &run["work"],
            &[
                ("steps", Kind::Count),
                ("rhs", Kind::Count),
                ("events", Kind::Count),
            ],
        );
        let list = run["impact_list"].as_array().unwrap();
        assert_eq!(list.len() as u64, run["impacts"].as_u64().unwrap());
        assert!(
            list.iter()
                .all(|impact| impact[0].is_f64() && impact[1].as_f64().unwrap() < 0.0)
        );
    }
    check_keys(
        "recording",
        &document["recording"],
        &[
            ("file", Kind::Text),
            ("sha256", Kind::Text),
            ("format", Kind::Text),
            ("channel", Kind::Text),
            ("unit", Kind::Text),
            ("samples", Kind::Count),
            ("sample_rate_hz", Kind::Number),
            ("start_s", Kind::Number),
            ("end_s", Kind::Number),
            ("peak_g", Kind::Number),
        ],
    );
    check_keys(
        "conditioning",
        &document["conditioning"],
        &[
            ("bias_m_s2", Kind::Number),
            ("bias_standard_error_m_s2", Kind::Number),
            ("filter", Kind::Text),
            ("filter_standard", Kind::Text),
            ("resample_hz", Kind::Maybe),
        ],
    );
    let screens = &document["screens"];
    // T0/(mLg) and √(2 I0 (T0 φ* + k0 φ*²/2))/(mL) of the paper's lever.
    assert!((screens["static_threshold_g"].as_f64().unwrap() - 1.063_589_3).abs() < 1e-6);
    assert!((screens["impulse_threshold_m_s"].as_f64().unwrap() - 0.478_7).abs() < 1e-4);
    // What could not be read still has its document.
    check_document(
        &latchgate(&[
            "replay",
            "/nowhere/x.csv",
            "--no-report",
            "--format",
            "json",
        ])
        .document(),
    );
}

/// Top-level keys come in the order in which a person reads, `run` last.
#[test]
fn verif_keys_stand_in_their_order() {
    let folder = Folder::new("order-of-keys");
    let file = folder.write("a.csv", table(weak));
    let text = latchgate(&["replay", &file, "--no-report", "--format", "json"]).out;
    let keys: Vec<&str> = text
        .lines()
        .filter_map(|line| {
            line.strip_prefix("  \"")?
                .split_once('"')
                .map(|(key, _)| key)
        })
        .collect();
    let expected = [
        "schema",
        "report_id",
        "verdict",
        "why",
        "threshold_rad",
        "nominal",
        "models",
        "polarities",
        "answers",
        "opens",
        "opens_by_direction",
        "ensemble",
        "ensembles",
        "preload_answer",
        "what_if",
        "error_budget_rad",
        "screens",
        "filters",
        "findings",
        "recording",
        "conditioning",
        "design",
        "decision_rule",
        "test",
        "request",
        "run",
    ];
    assert_eq!(keys, expected);
}

/// Every number is printed with all its digits: what is read back is the same number.
#[test]
fn verif_numbers_are_printed_with_all_their_digits() {
    let file = signal_file("surviving.csv");
    let document = latchgate(&[
        "replay",
        &file,
        "--no-report",
        "--format",
        "json",
        "--filter",
        "none",
        "--bias",
        "none",
        "--model",
        "rigid",
    ])
    .document();
    let values: Vec<f64> = std::fs::read_to_string(&file)
        .unwrap()
        .lines()
        .skip(1)
        .map(|line| STANDARD_GRAVITY * line.split_once(',').unwrap().1.parse::<f64>().unwrap())
        .collect();
    let signal = Signal {
        start_s: -0.05,
        rate: SampleRate::from_hertz(10_000.0).unwrap(),
        samples: values,
    };
    let reading = between::read(std::borrow::Cow::Borrowed(&signal), Between::BandLimited).unwrap();
    let options = RunOptions::new(StopModel::Rigid, OpensWhen::Negative);
    let run = replay::run(reading, &Design::reference(), &options)
        .unwrap()
        .run;
    let nominal = &document["nominal"];
    for (key, expected) in [
        ("peak_angle_rad", run.peak_angle_rad),
        ("peak_time_s", run.peak_time_s),
        ("first_release_s", run.first_release_s.unwrap()),
        ("numerical_error_rad", run.numerical_error_rad),
        ("final_angle_rad", run.final_angle_rad),
    ] {
        assert_eq!(
            nominal[key].as_f64().unwrap().to_bits(),
            expected.to_bits(),
            "{key}"
        );
    }
}

/// An error of the peak beyond 90° has no figure, as an angle has none: on a channel whose impacts what lies
/// between the samples puts in another order.
#[test]
fn cli_an_error_beyond_90_degrees_is_told_as_that() {
    let recording = data("recordings/nhtsa_v07292.146");
    let question = [
        "replay",
        recording.to_str().unwrap(),
        "--opens-when",
        "negative",
        "--model",
        "soft",
        "--members",
        "0",
        "--no-report",
    ];
    let document = latchgate(&[&question[..], &["--format", "json"]].concat()).document();
    let why = document["why"].as_array().unwrap().iter();
    let told: Vec<&str> = why.filter_map(|reason| reason["text"].as_str()).collect();
    let shown = latchgate(&question).out;
    for text in told.into_iter().chain([shown.as_str()]) {
        assert!(!text.contains("± more than"), "{text}");
    }
    assert!(shown.contains(" cannot be computed"), "{shown}");
}

/// The first three sentences are those of the verdict card: what happened, how sure, what was
/// not looked at.
#[test]
fn cli_the_first_sentences_tell_a_crash_engineer_what_he_needs() {
    let first = |arguments: &[&str]| -> Vec<String> {
        let own = [&["replay"], arguments, &["--no-report", "--format", "json"]].concat();
        let document = latchgate(&own).document();
        let why = document["why"].as_array().unwrap();
        why.iter()
            .take(3)
            .map(|reason| reason["text"].as_str().unwrap().to_string())
            .collect()
    };
    let check = |arguments: &[&str], starts: [&str; 3]| {
        let found = first(arguments);
        for (found, start) in found.iter().zip(starts) {
            assert!(found.starts_with(start), "{arguments:?}: {found}");
        }
        assert_eq!(found.len(), 3);
    };
    let surviving = signal_file("surviving.csv");
    check(
        &[&surviving],
        [
            "The largest angle is 1.67° (0.0292 rad) at 24.6 ms (soft stop, negative acceleration), 29.2 % of the limit angle.",
            "0 of 128 varied levers open: fewer than 3.4 % of levers and readings, at 98.75 % confidence (soft stop, negative acceleration). A pass allows 5 %.",
            "The error of the largest angle is ±0.031°, less than the 4.06° to the limit angle.",
        ],
    );
    check(
        &[&signal_file("burst.csv")],
        [
            "The nominal lever opens first at 14.4 ms (soft stop, negative acceleration). The largest angle is more than 90°",
            "128 of 128 varied levers open: more than 96 % of levers and readings, at 98.75 % confidence (soft stop, negative acceleration). A fail needs 95 %.",
            "The error of the largest angle is ±0.072°, less than its distance to the limit angle.",
        ],
    );
    check(
        &[&surviving, "--members", "0"],
        [
            "The largest angle is 1.67° (0.0292 rad)",
            "The error of the largest angle",
            "No varied lever was asked (the setting `members` = 0).",
        ],
    );
}
