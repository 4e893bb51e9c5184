//! Guards the filters of SAE J211-1 and ISO 6487: coefficients, gain, phase and record ends.

use crate::support::{Random, data, signal};
use latchgate_kernel::units::SampleRate;
use latchgate_recording::error::ErrorKind;
use latchgate_verdict::conditioning::cfc::{
    CfcFilter, design_frequency_hz, end_treatment, iso_6487, padding_samples, sae_j211,
};
use latchgate_verdict::conditioning::{Cfc, FilterStandard};
use std::f64::consts::PI;

const STANDARDS: [FilterStandard; 2] = [FilterStandard::Iso6487, FilterStandard::SaeJ211];

#[track_caller]
fn check_near(found: f64, expected: f64, relative: f64, absolute: f64, what: &str) {
    let allowed = (relative * expected.abs()).max(absolute);
    assert!(
        (found - expected).abs() <= allowed,
        "{what}: expected {expected:.12e}, found {found:.12e}"
    );
}

/// Amplitude of a tone after the filter over that before, away from the ends.
fn measured_gain(filter: CfcFilter, rate_hz: f64, frequency_hz: f64) -> f64 {
    let periods = (0.05 * frequency_hz).ceil();
    let window = (periods * rate_hz / frequency_hz).round() as usize;
    // A whole number of samples holds a whole number of periods.
    let step = 2.0 * PI * periods / window as f64;
    let margin = (0.1 * rate_hz) as usize;
    let tone: Vec<f64> = (0..window + 2 * margin)
        .map(|n| (step * n as f64).sin())
        .collect();
    let filtered = filter.apply(&signal(rate_hz, tone)).unwrap();
    let (mut sine, mut cosine) = (0.0, 0.0);
    for n in margin..margin + window {
        sine += filtered.samples[n] * (step * n as f64).sin();
        cosine += filtered.samples[n] * (step * n as f64).cos();
    }
    let half = window as f64 / 2.0;
    assert!((cosine / half).abs() < 1e-9, "the filter shifts the phase");
    sine / half
}

#[track_caller]
fn check_gain(class: Cfc, standard: FilterStandard, rate_hz: f64, frequency_hz: f64) {
    let periods = (0.05 * frequency_hz).ceil();
    let window = (periods * rate_hz / frequency_hz).round();
    let exact_hz = periods * rate_hz / window;
    let design = (PI * design_frequency_hz(class, standard) / rate_hz).tan();
    let expected = 1.0 / (1.0 + ((PI * exact_hz / rate_hz).tan() / design).powi(4));
    let found = measured_gain(CfcFilter::new(class, standard), rate_hz, frequency_hz);
    check_near(found, expected, 1e-9, 1e-10, "gain");
}

/// G(f) = 1/(1 + (tan(π f T)/tan(π fd T))⁴), the square of a bilinear Butterworth's gain.
#[test]
fn val_gain_is_the_closed_form_of_two_butterworth_passes() {
    for standard in STANDARDS {
        for (class, rate_hz) in [
            (Cfc::Cfc60, 10_000.0),
            (Cfc::Cfc180, 12_500.0),
            (Cfc::Cfc600, 10_000.0),
            (Cfc::Cfc1000, 10_000.0),
            (Cfc::Cfc1000, 20_000.0),
            (Cfc::Cfc60, 100_000.0),
        ] {
            for part in [0.25, 0.5, 1.0, 1.0 / 0.6, 2.0, 3.0] {
                check_gain(class, standard, rate_hz, part * f64::from(class.class()));
            }
        }
    }
}

#[track_caller]
fn check_decibels(standard: FilterStandard, part: f64, expected_db: f64) {
    let filter = CfcFilter::new(Cfc::Cfc60, standard);
    let found = 20.0 * measured_gain(filter, 100_000.0, part * 60.0).log10();
    check_near(found, expected_db, 0.0, 0.01, "gain [dB]");
}

/// The corridor points that both standards are known by, far below the Nyquist frequency.
#[test]
fn val_gain_in_decibels_at_the_corridor_points() {
    check_decibels(FilterStandard::SaeJ211, 0.25, -0.002);
    check_decibels(FilterStandard::SaeJ211, 0.5, -0.029);
    check_decibels(FilterStandard::SaeJ211, 1.0, -0.454);
    check_decibels(FilterStandard::SaeJ211, 1.0 / 0.6, -3.010);
    check_decibels(FilterStandard::SaeJ211, 2.0 / 0.6, -17.65);
    check_decibels(FilterStandard::Iso6487, 1.0, -0.449);
    check_decibels(FilterStandard::Iso6487, 1.0 / 0.6, -2.982);
    check_decibels(FilterStandard::Iso6487, 2.0 / 0.6, -17.56);
}

/// At 10 kHz the pre-warped frequency of ISO 6487's CFC 600 is tan(π/8) = √2 − 1.
#[test]
fn val_coefficients_of_iso_cfc_600_at_10_khz_are_closed_forms() {
    let found = iso_6487(Cfc::Cfc600)
        .coefficients(SampleRate::from_hertz(10_000.0).unwrap())
        .unwrap();
    let root = 2.0_f64.sqrt();
    check_near(found.b1, 2.0 * root / 3.0, 1e-15, 0.0, "b1");
    check_near(found.b2, -1.0 / 3.0, 2e-15, 0.0, "b2");
    let a0 = (1.0 - 2.0 * root / 3.0 + 1.0 / 3.0) / 4.0;
    check_near(found.a0, a0, 1e-14, 0.0, "a0");
    check_near(found.a1, 2.0 * a0, 1e-14, 0.0, "a1");
    check_near(found.a2, a0, 1e-14, 0.0, "a2");
}

/// The response to an impulse is the autocorrelation of the one-pass response
/// h\[n\] = a0 (g\[n\] + 2 g\[n−1\] + g\[n−2\]), g\[n\] = rⁿ sin((n+1)θ)/sin θ, which comes from the
/// poles alone.
#[track_caller]
fn check_impulse_response(class: Cfc, standard: FilterStandard, rate_hz: f64) {
    let (length, middle) = (4001, 2000);
    let mut impulse = vec![0.0; length];
    impulse[middle] = 1.0;
    let found = CfcFilter::new(class, standard)
        .apply(&signal(rate_hz, impulse))
        .unwrap()
        .samples;

    let warped = (PI * design_frequency_hz(class, standard) / rate_hz).tan();
    let scale = 1.0 + 2.0_f64.sqrt() * warped + warped * warped;
    let a0 = warped * warped / scale;
    let radius = ((1.0 - 2.0_f64.sqrt() * warped + warped * warped) / scale).sqrt();
    let angle = ((1.0 - warped * warped) / scale / radius).acos();
    let resonance = |n: i32| {
        if n < 0 {
            0.0
        } else {
            radius.powi(n) * (f64::from(n + 1) * angle).sin() / angle.sin()
        }
    };
    let one_pass: Vec<f64> = (0..4000)
        .map(|n| a0 * (resonance(n) + 2.0 * resonance(n - 1) + resonance(n - 2)))
        .collect();
    for lag in 0..60 {
        let expected: f64 = one_pass
            .iter()
            .zip(&one_pass[lag..])
            .map(|(a, b)| a * b)
            .sum();
        for index in [middle - lag, middle + lag] {
            check_near(found[index], expected, 1e-9, 1e-12, "impulse response");
        }
    }
}

#[test]
fn val_impulse_response_follows_from_the_poles_and_is_symmetric() {
    for standard in STANDARDS {
        for class in Cfc::ALL {
            check_impulse_response(class, standard, 10_000.0);
            check_impulse_response(class, standard, 12_500.0);
        }
    }
    check_impulse_response(Cfc::Cfc1000, FilterStandard::Iso6487, 50_000.0);
}

#[track_caller]
fn check_constant(class: Cfc, rate_hz: f64, count: usize) {
    let filtered = iso_6487(class)
        .apply(&signal(rate_hz, vec![-42.5; count]))
        .unwrap();
    assert_eq!(filtered.samples.len(), count);
    for value in filtered.samples {
        check_near(value, -42.5, 1e-12, 0.0, "constant");
    }
}

#[test]
fn verif_a_constant_stays_a_constant_after_iso_6487() {
    for class in Cfc::ALL {
        for count in [1, 2, 3, 20, 101, 4000] {
            check_constant(class, 12_500.0, count);
        }
    }
}

/// The point mirror pins the end values to the raw ones where the padding outlasts the filter.
#[test]
fn verif_iso_6487_pins_the_ends_and_keeps_a_ramp() {
    let ramp: Vec<f64> = (0..400).map(|n| 0.3 * f64::from(n) - 7.0).collect();
    let filtered = iso_6487(Cfc::Cfc1000)
        .apply(&signal(10_000.0, ramp.clone()))
        .unwrap();
    for (found, expected) in filtered.samples.iter().zip(ramp) {
        check_near(*found, expected, 1e-10, 1e-10, "ramp");
    }
}

#[test]
fn verif_sae_j211_starts_both_passes_at_zero() {
    let filtered = sae_j211(Cfc::Cfc180)
        .apply(&signal(10_000.0, vec![1.0; 400]))
        .unwrap()
        .samples;
    assert_eq!(filtered[398..], [0.0, 0.0]);
    assert!(filtered[0] < 0.5 && (filtered[200] - 1.0).abs() < 1e-9);
}

/// A filter without phase, run over the reversed record, gives the reversed output.
#[test]
fn prop_time_reversal_commutes_with_the_filter_away_from_the_ends() {
    for seed in 1..=20 {
        println!("seed {seed}");
        let mut random = Random::new(seed);
        let mut record = vec![0.0; 3000];
        for value in &mut record[1000..2000] {
            *value = random.between(-500.0, 500.0);
        }
        let reversed: Vec<f64> = record.iter().rev().copied().collect();
        for standard in STANDARDS {
            for class in Cfc::ALL {
                let filter = CfcFilter::new(class, standard);
                let there = filter.apply(&signal(10_000.0, record.clone())).unwrap();
                let back = filter.apply(&signal(10_000.0, reversed.clone())).unwrap();
                for (a, b) in there.samples.iter().zip(back.samples.iter().rev()) {
                    check_near(*a, *b, 0.0, 1e-9, "reversed");
                }
            }
        }
    }
}

#[track_caller]
fn check_refused(class: Cfc, rate_hz: f64, expected: Option<f64>) {
    let found = iso_6487(class).apply(&signal(rate_hz, vec![0.0; 50]));
    match (expected, found) {
        (None, found) => assert!(found.is_ok(), "{found:?}"),
        (Some(least), Err(error)) => assert!(
            matches!(error.kind(), ErrorKind::RateTooLow { needed_hz, .. } if *needed_hz == least),
            "{error}"
        ),
        (Some(_), Ok(_)) => panic!("{rate_hz} Hz was taken for CFC {}", class.class()),
    }
}

/// Below 2·fd the formula turns unstable without a word; far above it already passes everything.
#[test]
fn verif_a_rate_below_ten_times_the_class_is_refused() {
    check_refused(Cfc::Cfc1000, 9_999.9, Some(10_000.0));
    check_refused(Cfc::Cfc1000, 4_000.0, Some(10_000.0));
    check_refused(Cfc::Cfc60, 599.0, Some(600.0));
    check_refused(Cfc::Cfc1000, 10_000.0, None);
    // Rates are compared after rounding to 1e-4 Hz.
    check_refused(Cfc::Cfc1000, 9_999.999_99, None);
    check_refused(Cfc::Cfc60, 600.0, None);
}

/// 0.01/8e-5 is 124.99999999999999: the padding is counted at the rounded rate instead.
#[test]
fn regress_padding_at_12_5_khz_is_125_samples() {
    for (rate_hz, count, expected) in [
        (12_500.0, 4000, 125),
        (1.0 / 8e-5, 4000, 125),
        (100_000.0, 4000, 1000),
        (1.0 / 1e-5, 4000, 1000),
        (10_000.0, 4000, 100),
        (2_000.0, 4000, 100),
        (10_000.0, 20, 19),
        (10_000.0, 1, 0),
        (10_000.0, 0, 0),
    ] {
        let rate = SampleRate::from_hertz(rate_hz).unwrap();
        assert_eq!(padding_samples(rate, count), expected, "{rate_hz} {count}");
    }
}

#[test]
fn verif_short_records_are_filtered_without_panic() {
    for standard in STANDARDS {
        for count in 0..12 {
            let record: Vec<f64> = (0..count).map(f64::from).collect();
            let filtered = CfcFilter::new(Cfc::Cfc60, standard)
                .apply(&signal(10_000.0, record))
                .unwrap();
            assert_eq!(filtered.samples.len(), count as usize);
            assert!(filtered.samples.iter().all(|value| value.is_finite()));
        }
        assert!(end_treatment(standard).len() > 20);
    }
}

/// One row of the table of outside reference values.
struct Row {
    record: String,
    class: Cfc,
    index: String,
    j211: f64,
    iso: f64,
}

fn rows(text: &str) -> Vec<Row> {
    let mut record = String::new();
    let mut rows = Vec::new();
    for line in text.lines() {
        if let Some(title) = line.strip_prefix("**V") {
            record = title.chars().take(1).collect();
        }
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [class, index, _, j211, iso] = cells.as_slice() else {
            continue;
        };
        let class = match *class {
            "60" => Cfc::Cfc60,
            "180" => Cfc::Cfc180,
            "600" => Cfc::Cfc600,
            "1000" => Cfc::Cfc1000,
            _ => continue,
        };
        if record.is_empty() {
            continue;
        }
        rows.push(Row {
            record: record.clone(),
            class,
            index: (*index).to_string(),
            j211: j211.parse().unwrap(),
            iso: iso.parse().unwrap(),
        });
    }
    rows
}

fn reference_record(name: &str) -> Vec<f64> {
    let count = 400;
    match name {
        "1" => vec![1.0; count],
        "2" => (0..count)
            .map(|n| if n < 200 { 0.0 } else { 1.0 })
            .collect(),
        "3" => (0..count)
            .map(|n| if n == 200 { 1.0 } else { 0.0 })
            .collect(),
        "4" => (0..count)
            .map(|n| {
                if (150..=250).contains(&n) {
                    30.0 * (PI * (n as f64 - 150.0) / 100.0).sin()
                } else {
                    0.0
                }
            })
            .collect(),
        "5" => (0..count).map(|n| 0.01 * n as f64).collect(),
        "6" => {
            let mut state = 12345_u64;
            (0..count)
                .map(|_| {
                    state = (1_103_515_245 * state + 12345) % (1 << 31);
                    200.0 * state as f64 / f64::from(1_u32 << 31) - 100.0
                })
                .collect()
        }
        _ => (0..20).map(|n| f64::from(n * n)).collect(),
    }
}

/// Records of formula, filtered by another program.
#[test]
fn val_reference_vectors_of_both_standards() {
    let rows = rows(&std::fs::read_to_string(data("reference/cfc_vectors.md")).unwrap());
    assert_eq!(2 * rows.len(), 392);
    for row in rows {
        let record = signal(10_000.0, reference_record(&row.record));
        for (filter, expected) in [
            (sae_j211(row.class), row.j211),
            (iso_6487(row.class), row.iso),
        ] {
            let output = filter.apply(&record).unwrap().samples;
            let found = match row.index.as_str() {
                "sum" => output.iter().sum(),
                "rms" => (output.iter().map(|y| y * y).sum::<f64>() / output.len() as f64).sqrt(),
                index => output[index.parse::<usize>().unwrap()],
            };
            let what = format!("V{} {filter:?} at {}", row.record, row.index);
            check_near(found, expected, 1e-9, 1e-12, &what);
        }
    }
}
