//! Made-up verdicts: enough physics that the pictures look like those of real runs, and no
//! more. Nothing here is a reference for a number of the replay.

use crate::support::signal_from;
use latchgate_document::blocks::{ConditioningBlock, Document, RecordingBlock, RunBlock};
use latchgate_document::request::{PolaritySource, Request};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::{ErrorStatement, MethodKind, Run, TracePoint, Work};
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::{AccelerationUnit, OpensWhen, STANDARD_GRAVITY};
use latchgate_recording::Finding;
use latchgate_recording::card::CardPolarity;
use latchgate_verdict::conditioning::spectrum::{AmplitudeSpectrum, Spectrogram};
use latchgate_verdict::conditioning::{Between, Cfc, FilterStandard};
use latchgate_verdict::ensemble::{Driver, End, PeakQuantiles, Varied};
use latchgate_verdict::what_if::{Change, ChangedSide};
use latchgate_verdict::{
    Answer, Ensemble, ErrorBudget, Evidence, FilterRow, Opening, QuantileBand, Reason, RunAnswer,
    Screens, Trace, WhatIf,
};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// A case: what is drawn and what is said.
pub(super) struct Case {
    pub(super) document: Document,
    pub(super) evidence: Evidence,
}

const RATE_HZ: f64 = 10_000.0;
const START_S: f64 = -0.02;

/// A burst of vibration that throws the lever far beyond the limit.
pub(super) fn failing() -> Case {
    let samples = samples(0.15, |t| {
        let envelope = (PI * t / 0.035).sin().powi(2);
        let inside = (0.0..0.035).contains(&t);
        let noise = (t * 91_000.0).sin() * (t * 17_300.0).cos();
        let burst = 700.0 * (2.0 * PI * 420.0 * t).sin() + 240.0 * (2.0 * PI * 1330.0 * t).cos();
        let pulse = if inside {
            envelope * (burst - 14.0)
        } else {
            0.0
        };
        pulse + 0.6 * noise
    });
    let mut case = case("burst.csv", &samples, &[OpensWhen::Negative], Answer::Fail);
    case.document.findings = vec![
        Finding::info("filter-default", "CFC 1000 was applied because the rate of 10 kHz carries it and nothing else was asked for."),
        Finding::warning("filter-decides", "The filter decides what the nominal runs say."),
        Finding::warning("peak-near-end", "The largest filtered sample lies 9.2 ms from the record's end, inside the filter's end padding of 10 ms.").at(0.0123),
    ];
    with_ensemble(&mut case);
    case
}

/// Adds what an ensemble says of every stop and polarity, and the filter table.
fn with_ensemble(case: &mut Case) {
    let document = &mut case.document;
    document.request.members = 10_000;
    let driver = |parameter: &'static str,
                  standard_deviation,
                  rank_correlation: Option<f64>,
                  share| Driver {
        parameter: parameter.into(),
        standard_deviation,
        rank_correlation,
        share,
        answer_if_known: Answer::Undecided,
    };
    document.ensembles = document
        .answers
        .iter()
        .enumerate()
        .map(|(index, answer)| Ensemble {
            model: answer.model,
            opens_when: answer.opens_when,
            members: 2048,
            exceeded: 1731,
            failed_to_run: u32::from(index == 1),
            varied: Varied::LeversAndReadings,
            seed: 1,
            generator: "made up".into(),
            method: MethodKind::EventDriven,
            look: 3,
            ended: [End::Decided, End::LastLook, End::NoMatter, End::Decided][index],
            confidence: 0.9875,
            p_lower: 0.827_31,
            p_upper: 0.861_92,
            exceeded_in_coast: 0,
            p_upper_with_coast: 0.861_92,
            open_share: 0.05,
            peak_angle_rad: (index != 2).then_some(PeakQuantiles {
                p05: 0.081_23,
                p50: 0.21,
                p95: 0.44,
                max: 0.913,
            }),
            judged_until_s: (index == 3).then_some(0.04),
            rank_correlation_by_chance: Some(0.043),
            drivers: vec![
                driver("input.bias_g", 0.1, Some(-0.83), Some(0.91)),
                driver("stop.restitution", 0.02, Some(0.24), Some(0.08)),
                driver("lever.preload_torque_nm", 0.003, Some(-0.01), Some(0.01)),
                driver("stop.radius_m", 0.001, None, None),
            ],
        })
        .collect();
    document.ensemble = document.ensembles.first().cloned();
    if document.ensembles.len() < 2 {
        document.ensembles.clear();
    }
    document.what_if = [Change::BiasKept, Change::Less, Change::More]
        .into_iter()
        .map(|how| WhatIf {
            input: "input.bias_g".into(),
            how,
            change: if how == Change::Less { -0.1 } else { 0.1 },
            peak_angle_rad: 0.0987,
            changes_side: vec![ChangedSide {
                model: StopModel::Rigid,
                opens_when: OpensWhen::Negative,
                peak_angle_rad: 0.0987,
            }],
        })
        .collect();
    document.filters = std::iter::once(None)
        .chain(Cfc::ALL.map(Some))
        .enumerate()
        .map(|(index, filter)| FilterRow {
            filter,
            verdict: (index != 2).then_some(if index < 2 {
                Answer::Fail
            } else {
                Answer::Pass
            }),
            peak_angle_rad: (index != 2).then_some(0.13),
            by_direction: Vec::new(),
            chosen: index == 1,
            reason: (index == 2).then(|| "needs 6000 Hz & more".into()),
        })
        .collect();
    let nominal = &case.evidence.traces[0];
    let along = |factor: f64| -> Vec<f64> {
        nominal
            .points
            .iter()
            .map(|point| factor * point.angle_rad)
            .collect()
    };
    case.evidence.quantile_band = Some(QuantileBand {
        model: nominal.model,
        opens_when: nominal.opens_when,
        members: 128,
        time_s: nominal.points.iter().map(|point| point.time_s).collect(),
        p05: along(0.7),
        p50: along(0.95),
        p95: along(1.3),
    });
}

/// A pulse that the lever survives.
pub(super) fn passing() -> Case {
    let samples = samples(0.12, |t| {
        let inside = (0.0..0.012).contains(&t);
        let pulse = if inside {
            -5.5 * (PI * t / 0.012).sin()
        } else {
            0.0
        };
        pulse + 0.05 * (t * 91_000.0).sin()
    });
    let mut case = case(
        "soft_pulse.csv",
        &samples,
        &[OpensWhen::Negative],
        Answer::Pass,
    );
    case.document.why = vec![
        reason(
            "below-threshold",
            "Peak and coast peak plus their numerical and interpolation error stay below the limit of 0.1 rad on both stops.",
        ),
        reason(
            "stops-agree",
            "The rigid and the soft stop give the same answer.",
        ),
        reason(
            "nominal-only",
            "Only the nominal run was judged; tolerances and input uncertainty are not part of this verdict.",
        ),
    ];
    case
}

/// A recording whose sensor was driven beyond its range.
pub(super) fn unusable() -> Case {
    let samples = samples(0.12, |t| {
        let inside = (0.0..0.012).contains(&t);
        if inside {
            (-5.5 * (PI * t / 0.012).sin()).max(-4.0)
        } else {
            0.0
        }
    });
    let mut case = case(
        "clipped.csv",
        &samples,
        &[OpensWhen::Negative],
        Answer::Unusable,
    );
    case.document.why = vec![reason(
        "blocking-findings",
        "The sensor clipped from 3.1 ms on, before the lever could be judged, so the recording cannot carry an answer.",
    )];
    case.document.findings = vec![
        Finding::info("synthetic", "The card says that the signal was made by a formula."),
        Finding::blocking("clipped", "58 samples in a row stand at the full scale of 4 g; the true acceleration was larger by an unknown amount.").at(0.0031),
        Finding::blocking("ends-inside-event", "The median of the last three samples is 14 % of the peak; the event goes on after the record's end.").at(0.0999),
    ];
    case
}

/// A recording that could not be replayed at all.
pub(super) fn unread() -> Case {
    let mut case = unusable();
    case.document.nominal = None;
    case.document.models = BTreeMap::new();
    case.document.conditioning = None;
    case.document.error_budget_rad = ErrorBudget::default();
    case.document.screens.impulse_m_s = None;
    case.document.recording = RecordingBlock {
        file: "imu.mcap".into(),
        sha256: Some("ab".repeat(32)),
        format: Some("mcap".into()),
        ..RecordingBlock::default()
    };
    case.document.findings = vec![Finding::blocking(
        "rate-too-low",
        "The rate is 10.02 Hz; a crash is over in a tenth of a second and needs at least 250 Hz.",
    )];
    case.document.why = vec![reason(
        "blocking-findings",
        "At 10.02 Hz this is no crash recording.",
    )];
    case.evidence.traces.clear();
    case
}

/// A recording whose opening sign nobody declared, and both signs disagree.
pub(super) fn undecided() -> Case {
    let samples = samples(0.2, |t| {
        let inside = (0.0..0.03).contains(&t);
        let noise = (t * 91_000.0).sin() * (t * 17_300.0).cos();
        let pulse = if inside {
            22.0 * (PI * t / 0.03).sin()
        } else {
            0.0
        };
        pulse + 0.4 * noise
    });
    let mut case = case(
        "sled_0042.csv",
        &samples,
        &[OpensWhen::Positive, OpensWhen::Negative],
        Answer::Undecided,
    );
    case.document.why = vec![
        reason(
            "polarities-differ",
            "A positive recorded acceleration opening gives fail, a negative one gives pass, and nothing declares which holds; state it with --opens-when.",
        ),
        reason("nominal-only", "Only the nominal run was judged."),
    ];
    case.document.findings = vec![Finding::warning(
        "polarity-undeclared",
        "Neither an option nor a card says which sign opens the lever.",
    )];
    case
}

/// Every case with its name.
pub(super) fn all() -> Vec<(&'static str, Case)> {
    vec![
        ("fail", failing()),
        ("pass", passing()),
        ("unusable", unusable()),
        ("unread", unread()),
        ("undecided", undecided()),
    ]
}

fn reason(code: &'static str, text: &str) -> Reason {
    Reason {
        code: code.into(),
        text: text.into(),
    }
}

fn samples(duration_s: f64, acceleration_g: impl Fn(f64) -> f64) -> Vec<f64> {
    let count = (duration_s * RATE_HZ).round() as usize + 1;
    (0..count)
        .map(|index| acceleration_g(START_S + index as f64 / RATE_HZ) * STANDARD_GRAVITY)
        .collect()
}

fn signal(samples: Vec<f64>) -> Signal {
    signal_from(RATE_HZ, START_S, samples)
}

fn case(file: &str, samples: &[f64], polarities: &[OpensWhen], verdict: Answer) -> Case {
    let raw = signal(
        samples
            .iter()
            .map(|a| a + 0.46 * STANDARD_GRAVITY)
            .collect(),
    );
    let smooth = (0..samples.len())
        .map(|i| {
            let near = &samples[i.saturating_sub(2)..(i + 3).min(samples.len())];
            near.iter().sum::<f64>() / near.len() as f64
        })
        .collect();
    let used = signal(smooth);
    let mut design = Design::reference();
    design.name = "single pendulum latch lever".into();
    let mut runs = Vec::new();
    for &polarity in polarities {
        for (model, restitution) in [(StopModel::Rigid, 0.8), (StopModel::Soft, 0.76)] {
            runs.push(run(&used, &design, polarity, model, restitution));
        }
    }
    let (nominal, trace) = runs[0].clone();
    let mut models = BTreeMap::new();
    models.insert(StopModel::Rigid, runs[0].0.clone());
    models.insert(StopModel::Soft, runs[1].0.clone());
    let mut by_polarity = BTreeMap::new();
    if polarities.len() > 1 {
        for (polarity, pair) in polarities.iter().zip(runs.chunks(2)) {
            by_polarity.insert(
                *polarity,
                BTreeMap::from([
                    (StopModel::Rigid, pair[0].0.clone()),
                    (StopModel::Soft, pair[1].0.clone()),
                ]),
            );
        }
    }
    let peak_index = (0..raw.samples.len())
        .max_by(|&a, &b| raw.samples[a].abs().total_cmp(&raw.samples[b].abs()))
        .unwrap();
    let opens = runs
        .iter()
        .filter(|_| verdict != Answer::Unusable)
        .filter_map(|(run, _)| Some((run, run.first_crossing_s?)))
        .min_by(|one, other| one.1.total_cmp(&other.1))
        .map(|(run, first_s)| Opening {
            first_s: Some(first_s),
            model: run.model,
            opens_when: run.opens_when,
            p05_s: None,
            p50_s: None,
            p95_s: None,
            members: 0,
            exceeded: 0,
            varied: None,
        });
    let opens_by_direction = opens.filter(|_| by_polarity.len() > 1).into_iter();
    let document = Document {
        mechanism: None,
        transfer: None,
        siblings: Vec::new(),
        in_plane: None,
        opens,
        opens_by_direction: opens_by_direction
            .map(|opens| (opens.opens_when, opens))
            .collect(),
        test: latchgate_recording::TestFacts::default(),
        schema: "latchgate.verdict/1".into(),
        report_id: "5e1f".repeat(16),
        verdict,
        why: vec![
            reason(
                "crossed",
                &format!(
                    "The lever exceeds the limit of 0.1 rad on both stops; the nominal peak is {:.4} rad, far beyond its error.",
                    nominal.peak_angle_rad
                ),
            ),
            reason(
                "stops-agree",
                "The rigid and the soft stop give the same answer.",
            ),
            reason(
                "nominal-only",
                "Only the nominal run was judged; tolerances and input uncertainty are not part of this verdict.",
            ),
        ],
        threshold_rad: 0.1,
        models,
        polarities: by_polarity,
        answers: runs
            .iter()
            .map(|(run, _)| RunAnswer {
                model: run.model,
                opens_when: run.opens_when,
                answer: if run.peak_angle_rad > 0.1 {
                    Answer::Fail
                } else {
                    Answer::Pass
                },
                interpolation_error_rad: Some(4.2e-4),
                noise_rad: Some(2e-5),
                noise_97_5_rad: None,
                opening_draws: None,
                bound: None,
                uncertainty_rad: Some(4.2e-4),
                coast_uncertainty_rad: run.coast_peak_angle_rad.map(|_| 4.3e-4),
            })
            .collect(),
        ensemble: None,
        ensembles: Vec::new(),
        preload_answer: None,
        restitution_answer: None,
        sled206: None,
        what_if: Vec::new(),
        filters: Vec::new(),
        error_budget_rad: ErrorBudget {
            numerical: Some(3.1e-13),
            interpolation: Some(4.2e-4),
            noise: Some(2e-5),
            noise_97_5: None,
            model: Some((nominal.peak_angle_rad - runs[1].0.peak_angle_rad).abs()),
            filter: Some(1.29e-2),
            bias: Some(2.7e-3),
            polarity: (polarities.len() > 1).then_some(0.93),
        },
        nominal: Some(nominal),
        screens: Screens {
            j839_threshold_g: 1.2604,
            static_counts_g: 0.2604,
            hold_threshold_g: Some(1.4571),
            step_threshold_g: Some(1.2609),
            static_threshold_g: 1.063_61,
            static_threshold_m_s2: 10.430_247_718_383_31,
            impulse_threshold_m_s: 0.478_7,
            impulse_m_s: Some(used.samples.iter().map(|a| a.abs()).sum::<f64>() / RATE_HZ),
        },
        findings: Vec::new(),
        recording: RecordingBlock {
            file: file.into(),
            sha256: Some("3f5a9c0de1b27788".repeat(4)),
            format: Some("csv".into()),
            channel: Some("11DOORLE0000ACYP".into()),
            unit: Some(AccelerationUnit::StandardGravity),
            unit_source: Some("header".into()),
            samples: raw.samples.len(),
            sample_rate_hz: Some(RATE_HZ),
            start_s: Some(raw.start_s),
            end_s: Some(raw.end_s()),
            peak_g: Some(raw.samples[peak_index].abs() / STANDARD_GRAVITY),
            peak_time_s: Some(raw.time_s(peak_index)),
            velocity_change_m_s: Some(4.1),
            card_sha256: Some("0c9a71e2".repeat(8)),
            opens_when: (polarities.len() == 1).then_some(CardPolarity::Negative),
            opens_when_source: if polarities.len() > 1 {
                PolaritySource::Undeclared
            } else {
                PolaritySource::Card
            },
            ..RecordingBlock::default()
        },
        conditioning: Some(ConditioningBlock {
            bias_m_s2: 0.46 * STANDARD_GRAVITY,
            bias_standard_error_m_s2: 0.012,
            bias_standard_error_method: "integrated autocorrelation time".into(),
            bias_samples: 191,
            bias_window_s: Some((START_S, -0.001)),
            filter: Some(Cfc::Cfc1000),
            filter_standard: FilterStandard::Iso6487,
            filter_design_frequency_hz: Some(25.0 / 12.0 * 1000.0),
            filter_end_treatment: Some("10 ms of point-mirrored samples at each end".into()),
            resample_hz: None,
            between: Between::BandLimited,
            noise_m_s2: 0.3,
            peak_g: Some(0.97 * raw.samples[peak_index].abs() / STANDARD_GRAVITY),
            peak_time_s: Some(raw.time_s(peak_index)),
            range_g: Some(2000.0),
            synthetic: true,
        }),
        design,
        decision_rule: "Nominal run only. Pass if the peak angle and the coast peak, each plus numerical and interpolation error, are at most the limit; fail if the peak less that error exceeds it; undecided otherwise, or where two stops or two undeclared signs answer differently.".into(),
        request: Request {
            channel: Some("lever & co".into()),
            members: 0,
            ..Request::default()
        },
        run: RunBlock {
            version: "0.1.0".into(),
            numbers_revision: Some(1),
            date: Some("2026-03-01".into()),
            by: Some("A. Maker <QA>".into()),
            design_file: Some("my-latch.toml".into()),
            design_file_sha256: Some("ab".repeat(32)),
            elapsed_s: 0.012_345,
        },
    };
    let mut traces = vec![trace];
    traces.extend(runs[1..].iter().map(|(_, trace)| trace.clone()));
    let evidence = Evidence {
        sled206: None,
        catch_traces: Vec::new(),
        second: None,
        spectrum_raw: amplitudes(&raw),
        spectrum_used: amplitudes(&used),
        spectrogram: windows(&used),
        series: latchgate_verdict::SampledSeries::of(&raw, &used, &traces),
        raw,
        used,
        traces,
        quantile_band: None,
    };
    Case { document, evidence }
}

/// Steps a lever on a bouncing stop through the signal, coarsely.
fn run(
    used: &Signal,
    design: &Design,
    opens_when: OpensWhen,
    model: StopModel,
    restitution: f64,
) -> (Run, Trace) {
    let lever = &design.lever;
    let steps = 20;
    let h = 1.0 / RATE_HZ / f64::from(steps);
    let (mut angle, mut velocity) = (0.0_f64, 0.0_f64);
    let mut points = Vec::new();
    let mut impacts: Vec<[f64; 2]> = Vec::new();
    let (mut peak, mut peak_time) = (0.0, used.start_s);
    let (mut above, mut crossing, mut release) = (0.0, None, None);
    for (index, acceleration) in used.samples.iter().enumerate() {
        for step in 0..steps {
            let t = used.time_s(index) + f64::from(step) * h;
            let torque = -lever.preload_torque_nm
                - lever.spring_stiffness_nm_per_rad * angle
                - lever.pivot_damping_nm_s_per_rad * velocity
                - lever.unbalance_kg_m() * opens_when.sign() * acceleration * angle.cos();
            velocity += torque / lever.moment_of_inertia_kg_m2 * h;
            angle += velocity * h;
            if angle < 0.0 {
                if velocity.abs() > 0.02 {
                    points.push(TracePoint {
                        time_s: t,
                        angle_rad: 0.0,
                        velocity_rad_s: velocity,
                    });
                    impacts.push([t, velocity]);
                    velocity *= -restitution;
                } else {
                    velocity = 0.0;
                }
                angle = 0.0;
            }
            if angle > peak {
                (peak, peak_time) = (angle, t);
            }
            if angle > 0.0 && release.is_none() {
                release = Some(t);
            }
            if angle > 0.1 {
                above += h;
                crossing = crossing.or(Some(t));
            }
        }
        points.push(TracePoint {
            time_s: used.time_s(index),
            angle_rad: angle,
            velocity_rad_s: velocity,
        });
    }
    let count = impacts.len() as u64;
    impacts.truncate(200);
    let run = Run {
        model,
        method: MethodKind::EventDriven,
        opens_when,
        peak_angle_rad: peak,
        peak_time_s: peak_time,
        first_crossing_s: crossing,
        time_above_threshold_s: above,
        first_release_s: release,
        impacts: count,
        impact_list: impacts,
        final_angle_rad: angle,
        final_velocity_rad_s: velocity,
        moving_at_end: angle > 0.0,
        coast_peak_angle_rad: (angle > 0.0).then_some(angle * 1.02),
        numerical_error_rad: 3.1e-13,
        error: ErrorStatement::Bound(3.1e-13),
        work: Work {
            steps: 12_345,
            rhs: 98_760,
            events: 2 * count + 1,
        },
    };
    (
        run,
        Trace {
            model,
            opens_when,
            points,
        },
    )
}

fn amplitudes(signal: &Signal) -> AmplitudeSpectrum {
    let count = signal.samples.len();
    let bins: Vec<usize> = (0..=count / 2).step_by(3).collect();
    AmplitudeSpectrum {
        frequency_hz: bins
            .iter()
            .map(|&bin| bin as f64 * RATE_HZ / count as f64)
            .collect(),
        amplitude_m_s2: bins
            .iter()
            .map(|&bin| tone(&signal.samples, bin as f64 / count as f64))
            .collect(),
    }
}

fn windows(signal: &Signal) -> Spectrogram {
    let length = 64;
    let mut out = Spectrogram {
        window_s: length as f64 / RATE_HZ,
        frequency_hz: (0..=length / 2)
            .map(|bin| bin as f64 * RATE_HZ / length as f64)
            .collect(),
        ..Spectrogram::default()
    };
    for (index, window) in signal.samples.windows(length).enumerate().step_by(8) {
        let shaped: Vec<f64> = window
            .iter()
            .enumerate()
            .map(|(i, a)| a * 2.0 * (PI * i as f64 / length as f64).sin().powi(2))
            .collect();
        out.time_s.push(signal.time_s(index + length / 2));
        out.amplitude_m_s2.push(
            (0..=length / 2)
                .map(|bin| tone(&shaped, bin as f64 / length as f64))
                .collect(),
        );
    }
    out
}

fn tone(samples: &[f64], cycles_per_sample: f64) -> f64 {
    let (turn_re, turn_im) = (
        (2.0 * PI * cycles_per_sample).cos(),
        (2.0 * PI * cycles_per_sample).sin(),
    );
    let (mut re, mut im) = (0.0, 0.0);
    for sample in samples.iter().rev() {
        (re, im) = (
            re * turn_re - im * turn_im + sample,
            re * turn_im + im * turn_re,
        );
    }
    re.hypot(im) * 2.0 / samples.len() as f64
}
