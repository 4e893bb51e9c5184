//! A row and a report answer alike.

use crate::support::{Random, half_sine};
use latchgate::pipeline::{
    Control, DecisionRow, Design, Document, Extras, Limits, Prepared, Request, Source,
};
use latchgate_document::design_file::apply_override;
use latchgate_kernel::range::Range;
use latchgate_verdict::Answer;
use std::fmt::Write as _;

/// Pairs of an ordinary run; `LATCHGATE_PAIRS` asks for another number:
/// `LATCHGATE_PAIRS=10000 cargo test --release --test it gate::rows`
const PAIRS: usize = 160;

/// Designs of each recording.
const DESIGNS: usize = 8;

/// A short noisy recording with a pulse or two, some of them clipped, dead or rough.
fn recording(random: &mut Random) -> Source {
    let rate = [5_000.0, 10_000.0, 12_500.0][random.below(3)];
    let count = 400 + random.below(900);
    let (first, second) = (random.scale(2.0, 80.0), random.scale(0.5, 60.0));
    let (long, later) = (random.scale(0.002, 0.03), random.between(0.0, 0.04));
    let sign = if random.one_in(3) { 1.0 } else { -1.0 };
    let ring = if random.one_in(3) {
        random.scale(1.0, 40.0)
    } else {
        0.0
    };
    let noise = random.scale(0.005, 0.5);
    let range = if random.one_in(6) {
        0.8 * first
    } else {
        f64::INFINITY
    };
    let mut text = String::from("time_s,acc_y_g\n");
    for n in 0..count {
        let t = n as f64 / rate - 0.02;
        let pulses = half_sine(t, 0.0, long, sign * first)
            + half_sine(t, later, 1.7 * long, -0.6 * sign * second);
        let ringing = if t > 0.0 {
            ring * (-t / 0.02).exp() * (2_500.0 * t).sin()
        } else {
            0.0
        };
        let value = (pulses + ringing + noise * random.normal()).clamp(-range, range);
        let _ = writeln!(text, "{t:.5},{value:.3}");
    }
    let made = Source::bytes("made.csv", text.into_bytes());
    // What a formula makes needs no person's word.
    match random.one_in(2) {
        true => made.with_card(*b"synthetic = true"),
        false => made,
    }
}

fn request(random: &mut Random) -> Request {
    let mut entries = serde_json::Map::new();
    let opens = ["negative", "positive", "both"];
    if !random.one_in(4) {
        entries.insert("opens_when".into(), opens[random.below(3)].into());
    }
    entries.insert(
        "model".into(),
        ["auto", "rigid", "soft"][random.below(3)].into(),
    );
    entries.insert("members".into(), [0, 0, 128, 512][random.below(4)].into());
    if random.one_in(3) {
        entries.insert("filter".into(), "none".into());
    }
    if random.one_in(3) {
        entries.insert("window".into(), "-0.01..0.05".into());
    }
    serde_json::from_value(entries.into()).unwrap()
}

fn design(random: &mut Random) -> Design {
    let mut design = Design::reference();
    for (key, low, high) in [
        ("lever.preload_torque_nm", 0.2, 9.0),
        ("lever.spring_stiffness_nm_per_rad", 1.0, 60.0),
        ("stop.restitution", 0.1, 0.9),
    ] {
        if random.one_in(2) {
            let value = random.scale(low, high);
            apply_override(&mut design, &format!("{key}={value}")).unwrap();
        }
    }
    design
}

/// Holds a row against the document of the same pair.
#[track_caller]
fn check(row: &DecisionRow, document: &Document, what: &str) {
    assert_eq!(row.report_id, document.report_id, "{what}");
    assert_eq!(row.verdict, document.verdict, "{what}");
    assert_eq!(Some(&row.reason), document.why.first(), "{what}");
    if document.verdict == Answer::Unusable {
        assert_eq!((row.peak_angle_rad, row.share), (None, None), "{what}");
        return;
    }
    let nominal = document.nominal.as_ref().unwrap();
    assert_eq!(row.peak_angle_rad, Some(nominal.peak_angle_rad), "{what}");
    assert_eq!(
        row.coast_peak_angle_rad, nominal.coast_peak_angle_rad,
        "{what}"
    );
    let answer = document
        .answers
        .iter()
        .find(|answer| answer.model == nominal.model && answer.opens_when == nominal.opens_when);
    assert_eq!(
        row.uncertainty_rad,
        answer.unwrap().uncertainty_rad,
        "{what}"
    );
    let share = document.ensemble.as_ref();
    assert_eq!(
        row.share,
        share.map(|one| Range::new(one.p_lower, one.p_upper)),
        "{what}"
    );
}

/// A gate asks for rows, a reader for reports; of one pair both say the same.
#[test]
fn prop_a_row_answers_as_a_report_does() {
    let asked = std::env::var("LATCHGATE_PAIRS").ok();
    let pairs = asked.map_or(PAIRS, |asked| asked.parse().unwrap());
    let (limits, control) = (Limits::default(), Control::default());
    let extras = Extras {
        filter_table: true,
        evidence: true,
        preload_answer: false,
    };
    let mut answers = std::collections::BTreeMap::new();
    for seed in 0..pairs.div_ceil(DESIGNS) as u64 {
        let mut random = Random::new(seed);
        let source = recording(&mut random);
        let request = request(&mut random);
        let prepared = match Prepared::open(&source, &request, &limits, &control) {
            Ok(prepared) => prepared,
            Err(refused) => {
                let design = design(&mut random);
                let row = refused.row(&design);
                check(
                    &row,
                    &refused.outcome(&design).document,
                    &format!("seed {seed}"),
                );
                *answers.entry("refused").or_insert(0) += 1;
                continue;
            }
        };
        for number in 0..DESIGNS {
            let design = design(&mut random);
            let row = prepared.row(&design, &control).unwrap();
            // The search for a preload costs as much as hundreds of rows.
            let extras = Extras {
                preload_answer: seed % 40 == 0 && number == 0,
                ..extras
            };
            let document = prepared.judge(&design, extras, &control).document;
            check(&row, &document, &format!("seed {seed}, design {number}"));
            *answers.entry(row.verdict.name()).or_insert(0) += 1;
        }
    }
    println!("{answers:?}");
    for name in ["pass", "fail", "undecided", "unusable"] {
        assert!(answers.get(name) > Some(&(pairs / 100)), "{answers:?}");
    }
}
