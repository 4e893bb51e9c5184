//! Guards the reasons of a verdict: the table of `docs/decision.md` lists each code that the sources
//! can give, and a test names each; here are the tests of codes that no other file covers.

use super::*;
use crate::support::{Folder, data, latchgate, table};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// A bounce that never ends: a perfect stop, no damping, and hardly any speed.
fn endless() -> (Design, Policy) {
    let mut design = Design::reference();
    design.stop.restitution = 1.0;
    design.lever.pivot_damping_nm_s_per_rad = 0.0;
    let own = Policy {
        initial_velocity_rad_s: Some(1e-10),
        ..options(RIGID, NEGATIVE)
    };
    (design, own)
}

#[test]
fn verif_a_lever_that_cannot_be_followed_is_undecided_and_said() {
    let (design, own) = endless();
    let quiet = samples(|_| 0.0);
    let lost = judge(&quiet, &[], &design, &own);
    check_answer(
        &lost,
        Answer::Undecided,
        &["method-broke-down", "nominal-runs-only"],
    );
    assert!(lost.why[0].text.contains("event-driven"), "{:?}", lost.why);
    assert!(
        lost.findings
            .iter()
            .any(|finding| finding.code == "method-broke-down")
    );
    // A pass of the others is none of the whole.
    let members = Policy {
        members: 16,
        ..own.clone()
    };
    let scattered = judge(&quiet, &[], &design, &members);
    assert_eq!(scattered.answer, Answer::Undecided);
    assert!(scattered.ensemble.unwrap().failed_to_run > 0);
}

/// A method that only estimates its error may have stepped over what opens the lever.
#[test]
fn verif_a_method_without_a_bound_decides_no_pass() {
    let own = |method| Policy {
        method,
        ..options(RIGID, NEGATIVE)
    };
    let at_samples = Method::Dopri5 { at_samples: true };
    let held = judge(&samples(weak), &[], &Design::reference(), &own(at_samples));
    check_answer(
        &held,
        Answer::Undecided,
        &[
            "method-without-bound",
            "threshold-not-crossed",
            "uncertainty",
            "nominal-runs-only",
        ],
    );
    let strong = samples(|t| half_sine(t, 0.0, 0.012, -14.0));
    let fails = judge(&strong, &[], &Design::reference(), &own(at_samples));
    assert_eq!(fails.answer, Answer::Fail);
}

/// Chatter that takes more than it may ends undecided, with the same count on any threads.
#[test]
fn verif_a_question_beyond_its_work_is_undecided_and_says_what_to_set() {
    let chatter = samples(|t| {
        if t > 0.0 {
            8.0 * (t * 700.0).sin()
        } else {
            0.0
        }
    });
    let mut design = with_threshold(0.002);
    design.lever.preload_torque_nm = 0.5;
    let own = |work| Policy {
        members: 10_000,
        work,
        ..options(ModelChoice::Auto, NEGATIVE)
    };
    let of = |work, threads| {
        let control = Control::unwatched(threads);
        let extras = AssessExtras {
            filter_table: true,
            ..AssessExtras::default()
        };
        let conditioned = as_recorded(chatter.clone());
        latchgate_verdict::assess(&conditioned, &[], &design, &own(work), extras, &control).unwrap()
    };
    for limit in [10_000, 100_000] {
        let found = of(limit, 1);
        assert_eq!(found.answer, Answer::Undecided, "{limit}");
        assert_eq!(found.why[0].code, "work-limit", "{:#?}", found.why);
        assert!(found.why[0].text.contains("`members`"), "{:#?}", found.why);
        assert!(
            found
                .findings
                .iter()
                .any(|finding| finding.code == "work-limit")
        );
        assert!(found.work <= 3 * limit, "{} of {limit}", found.work);
        assert_eq!(found, of(limit, 3));
    }
}

/// The soft stop can be followed and reaches further: the one that cannot is named all the same.
#[test]
fn verif_a_stop_beside_the_nominal_one_that_cannot_be_followed_is_said() {
    let (design, own) = endless();
    let own = Policy {
        model: ModelChoice::Auto,
        ..own
    };
    let found = judge(&samples(weak), &[], &design, &own);
    assert_eq!(found.nominal.model, StopModel::Soft);
    check_answer(
        &found,
        Answer::Undecided,
        &[
            "method-broke-down",
            "threshold-not-crossed",
            "uncertainty",
            "nominal-runs-only",
        ],
    );
    assert!(found.why[0].text.contains("rigid stop"), "{:?}", found.why);
}

#[test]
fn cli_a_lever_that_cannot_be_followed_ends_with_three() {
    let folder = Folder::new("endless");
    let file = folder.write("quiet.csv", table(weak));
    let done = latchgate(&[
        "replay",
        &file,
        "--model",
        "rigid",
        "--opens-when",
        "negative",
        "--members",
        "0",
        "--omega0",
        "1e-10",
        "--set",
        "stop.restitution=1",
        "--set",
        "lever.pivot_damping_nm_s_per_rad=0",
        "--no-report",
        "--format",
        "json",
    ]);
    assert_eq!(done.code, 3, "{}", done.err);
    let document = done.document();
    assert_eq!(document["why"][0]["code"], "method-broke-down");
    assert!(document["answers"][0]["uncertainty_rad"].is_null());
}

// ---------------------------------------------------------------- the bias of nominal runs

/// A channel that reads `offset_g` too much, its bias taken from the samples before zero.
fn with_offset(offset_g: f64, of: impl Fn(f64) -> f64) -> Conditioned {
    let channel = Channel {
        name: "acc_y".into(),
        unit: Some(AccelerationUnit::MetrePerSecondSquared),
        unit_source: "option",
        stated: latchgate_recording::Stated::default(),
        start_s: -0.05,
        rate: SampleRate::from_hertz(10_000.0).unwrap(),
        values: samples(|t| of(t) + offset_g).samples,
        findings: Vec::new(),
        pulse: None,
    };
    let options = ConditioningOptions {
        filter: FilterChoice::None,
        synthetic: true,
        ..ConditioningOptions::default()
    };
    let conditioned = conditioning::condition(&channel, &options).unwrap();
    assert!((conditioned.bias_m_s2 / G - offset_g).abs() < 1e-9);
    conditioned
}

fn codes(assessment: &Assessment) -> Vec<&str> {
    assessment.why.iter().map(|reason| &*reason.code).collect()
}

/// With nominal runs alone the bias is asked about as well: where leaving it in, or one standard
/// deviation of it, takes the lever across the limit, the reasons say so; the answer stays that
/// of the rule.
#[test]
fn verif_nominal_runs_name_the_bias_that_decides() {
    let pulse = |t: f64| half_sine(t, 0.0, 0.01, -8.0);
    let own = options(RIGID, NEGATIVE);
    let mut design = Design::reference();
    design.input.bias_g = 0.0;
    let peak_of = |offset_g: f64| {
        let mut biased = samples(pulse);
        biased.samples.iter_mut().for_each(|a| *a += G * offset_g);
        explicit(&biased, StopModel::Rigid, OpensWhen::Negative)
            .run
            .peak_angle_rad
    };
    let (without, with) = (peak_of(0.0), peak_of(-0.3));
    assert!(with > 1.02 * without, "{without} {with}");
    let judged = |offset_g: f64, threshold: f64, bias_g: f64| {
        let mut own_design = with_threshold(threshold);
        own_design.input.bias_g = bias_g;
        assess(&with_offset(offset_g, pulse), &[], &own_design, &own).unwrap()
    };
    let between = f64::midpoint(without, with);
    // Left in the recording, the lever crosses.
    let removed = judged(-0.3, between, 0.0);
    assert_eq!(removed.answer, Answer::Pass);
    let bias = removed
        .why
        .iter()
        .find(|reason| reason.code == "bias-decides")
        .unwrap();
    assert!(
        bias.text.contains("left in the recording (-0.3"),
        "{}",
        bias.text
    );
    // One standard deviation, the design's where it is the larger.
    let close = judged(0.0, 1.001 * without, 0.1);
    assert_eq!(close.answer, Answer::Pass);
    assert!(codes(&close).contains(&"bias-decides"), "{:?}", close.why);
    let more = close
        .what_if
        .iter()
        .find(|what_if| what_if.change < 0.0)
        .unwrap();
    assert_eq!(more.input, "input.bias_g");
    let moved = peak_of(-0.1);
    assert!(
        (more.peak_angle_rad / moved - 1.0).abs() < 1e-9,
        "{more:?} {moved}"
    );
    // Far from the limit, or without any doubt of the bias, nothing is said.
    for far in [
        judged(-0.3, 4.0 * with, 0.1),
        judged(0.0, 1.001 * without, 0.0),
    ] {
        assert_eq!(far.answer, Answer::Pass);
        assert!(!codes(&far).contains(&"bias-decides"), "{:?}", far.why);
    }
    // A design whose tolerances an ensemble refuses is judged all the same.
    let mut wide = with_threshold(4.0 * with);
    wide.tolerance.insert("mass_kg".into(), 1.0);
    let judged = assess(&with_offset(0.0, pulse), &[], &wide, &own).unwrap();
    assert_eq!(judged.answer, Answer::Pass);
    assert_eq!(judged.what_if.len(), 2);
}

/// NHTSA test 7292, curve 148, nominal runs alone: what an ensemble's reasons
/// name is named without one.
#[test]
fn val_nominal_runs_of_a_real_channel_name_the_bias() {
    let file = data("recordings/nhtsa_v07292.148");
    let document = latchgate(&[
        "replay",
        file.to_str().unwrap(),
        "--unit",
        "g",
        "--members",
        "0",
        "--no-report",
        "--format",
        "json",
    ])
    .document();
    assert_eq!(document["verdict"], "undecided");
    let codes: Vec<&str> = document["why"]
        .as_array()
        .unwrap()
        .iter()
        .map(|reason| reason["code"].as_str().unwrap())
        .collect();
    assert!(codes.contains(&"bias-decides"), "{codes:?}");
}

// ---- the table

fn text_of(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

/// Every string of lower-case words after `code: "`, or first in a pair of code and text, in the
/// one file that gives reasons.
fn codes_in_sources(root: &Path) -> BTreeSet<String> {
    let source = text_of(&root.join("crates/verdict/src/reasons.rs"));
    let is_code =
        |word: &str| word.contains('-') && word.chars().all(|c| c.is_ascii_lowercase() || c == '-');
    let mut found: BTreeSet<String> = source
        .split('"')
        .skip(1)
        .step_by(2)
        .filter(|word| is_code(word))
        .map(String::from)
        .collect();
    // A reason without a hyphen is named here, so that the scan above stays simple.
    assert!(source.contains("\"uncertainty\""));
    found.insert("uncertainty".into());
    found
}

/// Returns the codes in the table of reasons.
fn documented_codes(root: &Path) -> BTreeSet<String> {
    let text = text_of(&root.join("docs/decision.md"));
    let (_, rest) = text.split_once("## Reasons").expect("a table of reasons");
    let table = rest.split("\n## ").next().unwrap();
    table
        .lines()
        .filter_map(|line| Some(line.strip_prefix("| `")?.split_once('`')?.0.to_string()))
        .collect()
}

#[test]
fn tidy_every_reason_is_documented_and_a_test_names_it() {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let codes = documented_codes(&root);
    assert_eq!(codes, codes_in_sources(&root), "docs/decision.md, Reasons");
    let mut tests = text_of(&root.join("tests/it/verdict.rs"));
    for file in std::fs::read_dir(root.join("tests/it/verdict")).unwrap() {
        let text = text_of(&file.unwrap().path());
        // The scan of the sources above names a code too, and tests nothing.
        tests.push_str(text.split("// ---- the table").next().unwrap());
    }
    for code in &codes {
        assert!(
            tests.contains(&format!("\"{code}\"")),
            "no test names {code}"
        );
    }
}
