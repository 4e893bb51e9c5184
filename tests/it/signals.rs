//! Guards `signals/`: every byte follows from its formula, every recording has the shape its
//! card promises, and no recording carries by accident what a damaged one would carry.

use latchgate_document::request::Request;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::{RunOptions, run};
use latchgate_kernel::units::{AccelerationUnit, OpensWhen, SampleRate};
use latchgate_recording::card::read_beside;
use latchgate_recording::{Card, Channel, Limits, Selection, Severity, Source, read};
use latchgate_verdict::conditioning::{ConditioningOptions, condition};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

#[path = "../../examples/make_signals.rs"]
#[expect(dead_code, reason = "the example's own main is not called here")]
mod make_signals;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("signals")
}

/// Reads a plain table `time,value` below one header line, with no help from the library.
fn plain_table(name: &str) -> Vec<(f64, f64)> {
    let text = std::fs::read_to_string(folder().join(name)).unwrap();
    text.lines()
        .skip(1)
        .map(|line| {
            let (time, value) = line.split_once(',').unwrap();
            (time.parse().unwrap(), value.parse().unwrap())
        })
        .collect()
}

fn largest(samples: &[(f64, f64)]) -> (f64, f64) {
    *samples
        .iter()
        .max_by(|one, other| one.1.abs().total_cmp(&other.1.abs()))
        .unwrap()
}

#[test]
fn tidy_signals_are_byte_for_byte_what_their_formulas_make() {
    let made: BTreeMap<String, Vec<u8>> = make_signals::all().unwrap().into_iter().collect();
    let mut names: Vec<String> = std::fs::read_dir(folder())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(
        names,
        made.keys().cloned().collect::<Vec<_>>(),
        "signals/ holds exactly what examples/make_signals.rs makes"
    );
    for (name, bytes) in &made {
        let stored = std::fs::read(folder().join(name)).unwrap();
        assert!(
            stored == *bytes,
            "signals/{name} differs from its formula; run `cargo run --example make_signals` and look at the difference"
        );
    }
    let total: usize = made.values().map(Vec::len).sum();
    assert!(
        total < 1 << 20,
        "signals/ holds {total} bytes, expected less than 1 MiB"
    );
}

#[track_caller]
fn check_card(name: &str, channel: &str, rate_hz: f64, synthetic: bool) {
    let text = std::fs::read_to_string(folder().join(format!("{name}.toml"))).unwrap();
    let card: toml::Table = text.parse().unwrap();
    let word = |key: &str| card.get(key).and_then(toml::Value::as_str).unwrap_or("");
    let number = |key: &str| card.get(key).and_then(toml::Value::as_float).unwrap_or(0.0);
    assert_eq!(word("opens_when"), "negative", "{name}");
    assert_eq!(word("channel"), channel, "{name}");
    assert_eq!(number("rate"), rate_hz, "{name}");
    assert_eq!(
        card.get("synthetic")
            .is_some_and(|value| *value == toml::Value::Boolean(true)),
        synthetic,
        "{name}"
    );
    assert_eq!(word("licence"), "CC0-1.0", "{name}");
    assert!(
        AccelerationUnit::from_spelling(word("unit")).is_some() && number("range_g") > 0.0,
        "{name}"
    );
    assert!(word("source").contains("computed"), "{name}");
    assert!(
        word("notes").contains("a(t) ="),
        "{name}: the notes state the formula"
    );
}

#[test]
fn tidy_cards_of_the_signals_say_all_that_a_card_can_say() {
    let lateral = "acceleration y (g)";
    check_card("burst.csv", lateral, 20_000.0, true);
    check_card("half_sine_30g_11ms.csv", lateral, 10_000.0, true);
    check_card("sill_60g.csv", lateral, 10_000.0, true);
    check_card("sled_30g_30ms.csv", lateral, 10_000.0, true);
    // Without the key, clipping and dead sensors are looked for, also in a damaged copy.
    check_card("surviving.csv", lateral, 10_000.0, false);
    check_card("ugly.csv", "acceleration_y", 10_000.0, true);
    check_card(
        "burst_imu.mcap",
        "/door/imu:linear_acceleration.y",
        10_000.0,
        true,
    );
}

#[track_caller]
fn check_shape(name: &str, peak_g: (f64, f64), peak_time_s: (f64, f64), noise_g: f64) {
    let samples = plain_table(name);
    let (time, value) = largest(&samples);
    assert!(
        (peak_g.0..=peak_g.1).contains(&value),
        "{name}: peak {value} g, expected {peak_g:?}"
    );
    assert!(
        (peak_time_s.0..=peak_time_s.1).contains(&time),
        "{name}: peak at {time} s, expected {peak_time_s:?}"
    );
    let before: Vec<f64> = samples
        .iter()
        .filter(|(time, _)| *time < 0.0)
        .map(|(_, value)| *value)
        .collect();
    assert!(
        samples[0].0 <= -0.02,
        "{name}: 20 ms or more before first contact"
    );
    let after: Vec<f64> = samples
        .iter()
        .rev()
        .take(200)
        .map(|(_, value)| *value)
        .collect();
    for part in [before, after] {
        let square: f64 = part.iter().map(|value| value * value).sum();
        let rms = (square / part.len() as f64).sqrt();
        assert!(
            (0.8 * noise_g..1.2 * noise_g).contains(&rms),
            "{name}: quiet part of {rms} g rms, expected {noise_g}"
        );
    }
}

#[test]
fn val_signals_have_the_peaks_and_the_quiet_ends_their_cards_state() {
    check_shape("burst.csv", (-1000.0, -990.0), (0.010, 0.020), 0.05);
    check_shape(
        "half_sine_30g_11ms.csv",
        (-30.1, -29.9),
        (0.0053, 0.0057),
        0.03,
    );
    check_shape("sill_60g.csv", (-60.2, -59.8), (0.01, 0.03), 0.05);
    check_shape("sled_30g_30ms.csv", (-33.1, -33.0), (0.023, 0.056), 0.03);
    check_shape("surviving.csv", (-5.1, -4.9), (0.0045, 0.0055), 0.02);
}

/// The burst ends after 35 ms and uses both signs at full height, as the paper's Fig. 11 does.
#[test]
fn val_burst_lasts_35_ms() {
    let loud: Vec<f64> = plain_table("burst.csv")
        .into_iter()
        .filter(|(_, value)| value.abs() > 1.0)
        .map(|(time, _)| time)
        .collect();
    let (first, last) = (loud[0], *loud.last().unwrap());
    assert!(
        first > 0.0 && last < 0.035 && last - first > 0.030,
        "louder than 1 g from {first} to {last} s"
    );
    assert_eq!(make_signals::burst_g(-1e-9), 0.0);
    assert_eq!(make_signals::burst_g(0.035 + 1e-9), 0.0);
}

fn interpolate(points: &[(f64, f64)], time_ms: f64) -> Option<f64> {
    points
        .windows(2)
        .find(|pair| (pair[0].0..=pair[1].0).contains(&time_ms))
        .map(|pair| {
            let share = (time_ms - pair[0].0) / (pair[1].0 - pair[0].0);
            pair[0].1 + share * (pair[1].1 - pair[0].1)
        })
}

/// The corridor is that of docs/sources.md, known at second hand.
#[test]
fn val_sled_pulse_stays_in_its_corridor() {
    let upper = [(0.0, 6.0), (20.0, 36.0), (60.0, 36.0), (100.0, 0.0)];
    let lower = [(5.0, 0.0), (25.0, 30.0), (55.0, 30.0), (70.0, 0.0)];
    for step in 0..=1000 {
        let time_ms = f64::from(step) * 0.1;
        let pulse_g = -make_signals::sled_g(time_ms / 1000.0);
        if let Some(limit) = interpolate(&upper, time_ms) {
            assert!(
                pulse_g <= limit,
                "{pulse_g} g above {limit} at {time_ms} ms"
            );
        }
        if let Some(limit) = interpolate(&lower, time_ms) {
            assert!(
                pulse_g >= limit,
                "{pulse_g} g below {limit} at {time_ms} ms"
            );
        }
    }
    let above_ms = (0..1000)
        .filter(|step| make_signals::sled_g(f64::from(*step) * 1e-4) <= -30.0)
        .count() as f64
        * 0.1;
    assert!(above_ms >= 30.0, "30 g or more for {above_ms} ms");
}

/// What opens the lever again must not come from the rebound, and a copy whose card is lost, so
/// that both signs count, must survive too: static lift-off of the paper's lever is 1.0636 g.
#[test]
fn val_surviving_pulse_has_a_rebound_below_lift_off() {
    let positive = plain_table("surviving.csv")
        .into_iter()
        .map(|(_, value)| value)
        .fold(0.0, f64::max);
    assert!(
        positive < 0.7 * 1.0636,
        "largest positive sample {positive} g"
    );
    assert!(make_signals::surviving_g(0.041).abs() < 1e-12);
}

/// How many samples equal the largest one in size and sign.
fn at_extreme(values: &[f64]) -> usize {
    let extreme = values
        .iter()
        .copied()
        .max_by(|one, other| one.abs().total_cmp(&other.abs()))
        .unwrap();
    values.iter().filter(|value| **value == extreme).count()
}

/// A detector that counts equal samples at the extreme must stay quiet on the original and see
/// a copy limited to 80 % of its peak.
#[test]
fn val_surviving_pulse_has_no_flat_top_of_its_own() {
    let values: Vec<f64> = plain_table("surviving.csv")
        .into_iter()
        .map(|(_, value)| value)
        .collect();
    assert!(at_extreme(&values) < 3);
    let limit = 0.8
        * values
            .iter()
            .fold(0.0_f64, |most, value| most.max(value.abs()));
    let clipped: Vec<f64> = values
        .iter()
        .map(|value| value.clamp(-limit, limit))
        .collect();
    assert!(at_extreme(&clipped) > 30);
}

/// Reads a recording, with its card or without, and checks channel, clock and findings.
#[track_caller]
fn check_reads(name: &str, with_card: bool, expected: (&str, f64, f64, usize), findings: &[&str]) {
    let source = Source::File(folder().join(name));
    let limits = Limits::default();
    let card = if with_card {
        read_beside(&source, &limits).unwrap().unwrap().0
    } else {
        Card::default()
    };
    let options = Request::default().read_options(&card);
    let recording = read(&source, &options, Selection::Lateral, &limits).unwrap();
    let channel = &recording.channels[0];
    let unit = channel.unit.unwrap();
    let (expected_name, expected_rate, expected_start, expected_count) = expected;
    assert_eq!(channel.name, expected_name, "{name}");
    assert!(
        (channel.rate.hertz() - expected_rate).abs() < 1e-6 * expected_rate,
        "{name}: {} Hz",
        channel.rate.hertz()
    );
    assert!(
        (channel.start_s - expected_start).abs() < 1e-9,
        "{name}: starts at {} s",
        channel.start_s
    );
    assert_eq!(channel.values.len(), expected_count, "{name}");
    let found: Vec<&str> = recording
        .findings
        .iter()
        .chain(&channel.findings)
        .map(|finding| &*finding.code)
        .collect();
    assert_eq!(found, findings, "{name}, card: {with_card}");
    let peak_g = channel
        .values
        .iter()
        .fold(0.0_f64, |most, value| most.max(value.abs()))
        * unit.metres_per_second_squared()
        / 9.806_65;
    let stated = match name {
        "burst.csv" => 999.6,
        // At 10 kHz no sample falls on the top of the burst.
        "burst_imu.mcap" => (0..=350)
            .map(|step| make_signals::burst_g(f64::from(step) * 1e-4).abs())
            .fold(0.0, f64::max),
        "half_sine_30g_11ms.csv" => 30.0,
        "sled_30g_30ms.csv" => 33.1,
        "surviving.csv" => 5.0,
        _ => 40.0,
    };
    assert!(
        (peak_g - stated).abs() < 0.1,
        "{name}: peak {peak_g} g, expected {stated}"
    );
}

#[test]
fn verif_every_signal_reads_as_it_was_made() {
    let lateral = "acceleration y (g)";
    for with_card in [true, false] {
        check_reads(
            "burst.csv",
            with_card,
            (lateral, 20_000.0, -0.05, 6001),
            &[],
        );
        for name in [
            "half_sine_30g_11ms.csv",
            "sled_30g_30ms.csv",
            "surviving.csv",
        ] {
            check_reads(name, with_card, (lateral, 10_000.0, -0.05, 3001), &[]);
        }
    }
    check_reads(
        "ugly.csv",
        true,
        ("acceleration_y", 10_000.0, -0.05, 2501),
        &["encoding-assumed", "decimal-comma"],
    );
    check_reads(
        "ugly.csv",
        false,
        ("acceleration_y", 10_000.0, -0.05, 2501),
        &["encoding-assumed", "decimal-comma"],
    );
    // Without --time-zero an MCAP's clock starts at its first sample.
    let lateral = "/door/imu:linear_acceleration.y";
    check_reads(
        "burst_imu.mcap",
        true,
        (lateral, 10_000.0, 0.0, 1201),
        &["time-zero-first"],
    );
    check_reads(
        "burst_imu.mcap",
        false,
        (lateral, 10_000.0, 0.0, 1201),
        &["channel-chosen", "time-zero-first"],
    );
}

/// Conditions a plain table as a sensor's channel, no formula's, and returns the findings that
/// block and the peak angle on both stops in both polarities.
fn peaks(samples: &[(f64, f64)], rate_hz: f64) -> (Vec<String>, Vec<(OpensWhen, f64)>) {
    let channel = Channel {
        name: "acceleration y (g)".into(),
        unit: Some(AccelerationUnit::StandardGravity),
        unit_source: "header",
        stated: latchgate_recording::Stated::default(),
        start_s: samples[0].0,
        rate: SampleRate::from_hertz(rate_hz).unwrap(),
        values: samples.iter().map(|(_, value)| *value).collect(),
        findings: Vec::new(),
        pulse: None,
    };
    let conditioned = condition(&channel, &ConditioningOptions::default()).unwrap();
    let blocking = conditioned
        .findings
        .iter()
        .filter(|finding| finding.severity == Severity::Blocking)
        .map(|finding| finding.code.to_string())
        .collect();
    let mut found = Vec::new();
    for opens_when in [OpensWhen::Negative, OpensWhen::Positive] {
        for stop in [StopModel::Rigid, StopModel::Soft] {
            let options = RunOptions::new(stop, opens_when);
            let outcome = run(&conditioned.used, &Design::reference(), &options).unwrap();
            found.push((opens_when, outcome.run.peak_angle_rad));
        }
    }
    (blocking, found)
}

#[track_caller]
fn check_opens(name: &str, rate_hz: f64, at_least_rad: f64) {
    let (blocking, found) = peaks(&plain_table(name), rate_hz);
    assert_eq!(blocking, Vec::<&str>::new(), "{name}");
    for (opens_when, peak) in found {
        if opens_when == OpensWhen::Negative {
            assert!(peak > at_least_rad, "{name}: peak {peak} rad");
        }
    }
}

/// The bounds are those of a separate fixed-step simulation, less a fifth.
#[test]
fn val_failing_signals_swing_the_lever_far_beyond_the_threshold() {
    check_opens("burst.csv", 20_000.0, 1.6);
    check_opens("half_sine_30g_11ms.csv", 10_000.0, 0.65);
    check_opens("sled_30g_30ms.csv", 10_000.0, 2.0);
}

/// A separate fixed-step simulation gives 0.0292 rad on both stops, and 0 if the sign is the other.
#[test]
fn val_surviving_pulse_stays_far_below_the_threshold_in_both_polarities() {
    let (blocking, found) = peaks(&plain_table("surviving.csv"), 10_000.0);
    assert_eq!(blocking, Vec::<&str>::new());
    for (opens_when, peak) in found {
        let expected = if opens_when == OpensWhen::Negative {
            0.0292
        } else {
            0.0
        };
        assert!((peak - expected).abs() < 1e-4, "{opens_when:?}: {peak} rad");
    }
}

#[test]
fn val_clipped_copy_of_the_surviving_pulse_is_found_out() {
    let mut samples = plain_table("surviving.csv");
    let limit = 0.8 * largest(&samples).1.abs();
    for (_, value) in &mut samples {
        *value = value.clamp(-limit, limit);
    }
    let (blocking, _) = peaks(&samples, 10_000.0);
    assert_eq!(blocking, ["clipping"]);
}

#[test]
fn val_ugly_recording_is_as_ugly_as_its_card_says() {
    let bytes = std::fs::read(folder().join("ugly.csv")).unwrap();
    assert!(
        std::str::from_utf8(&bytes).is_err(),
        "ISO-8859-1, not UTF-8"
    );
    let text: String = bytes.iter().map(|byte| char::from(*byte)).collect();
    let lines: Vec<&str> = text.split("\r\n").collect();
    assert!(
        !text.replace("\r\n", "").contains(['\n', '\r']),
        "CRLF only"
    );
    assert!(lines[..3].iter().all(|line| line.starts_with('#')));
    assert_eq!(lines[3], "time;acceleration_y;temperature");
    assert_eq!(lines[4], "ms;m/s²;°C");
    assert_eq!(lines[5].split(';').count(), 3);
    assert!(lines[5].starts_with("-50,0;"));
    assert_eq!(lines.len(), 5 + 2501 + 1);
}
