//! Guards that the short question of margins, whether the verdict is a pass, is answered as the
//! whole assessment answers it: the two end their ensembles in different places.

use super::ensemble::short_pulse;
use super::*;
use latchgate_kernel::range::Window;
use latchgate_kernel::replay::batch::{self, AskedPeaks, BatchOptions};
use latchgate_kernel::signal::Projection;
use latchgate_verdict::ensemble::Scatter;

const MODELS: [ModelChoice; 3] = [RIGID, ModelChoice::Only(StopModel::Soft), ModelChoice::Auto];

const POLARITIES: [Polarity; 3] = [NEGATIVE, Polarity::Undeclared, Polarity::Both];

/// Compares the two; returns whether they say pass.
#[track_caller]
fn check_same(
    conditioned: &Conditioned,
    findings: &[Finding],
    design: &Design,
    own: &Policy,
) -> bool {
    let whole = assess(conditioned, findings, design, own).unwrap();
    let short = passes(conditioned, findings, design, own).unwrap();
    assert_eq!(
        short,
        whole.answer == Answer::Pass,
        "{:?} at {} rad with {own:?}: {:?}",
        whole.answer,
        design.criterion.threshold_rad,
        whole.why
    );
    short
}

/// Peak and U of the nominal lever [rad].
fn nominal(signal: &Signal, stop: StopModel) -> (f64, f64) {
    let own = options(ModelChoice::Only(stop), NEGATIVE);
    let found = judge(signal, &[], &Design::reference(), &own);
    let uncertainty = found.answers[0].uncertainty_rad.unwrap();
    (found.nominal.peak_angle_rad, uncertainty)
}

/// Limits around the place where each part of the rule turns: the nominal peak, its error, and
/// shares of members about those that a look allows.
fn limits(signal: &Signal, stop: StopModel, members: u32) -> Vec<f64> {
    let (peak, uncertainty) = nominal(signal, stop);
    let scatter = Scatter::new(&Design::reference(), 0.0, 1).unwrap();
    let batch_options = BatchOptions {
        stop,
        projection: Projection::ALIGNED,
        opens_when: OpensWhen::Negative,
        initial: None,
        window: None,
        coast: false,
        asked: AskedPeaks::ALL,
        threshold_rad: f64::INFINITY,
        threads: 2,
    };
    let member = |index: usize| scatter.member(u32::try_from(index).unwrap());
    let mut peaks: Vec<f64> = batch::peaks(signal, 2048, &member, &batch_options)
        .unwrap()
        .iter()
        .map(|peak| peak.peak_angle_rad)
        .collect();
    let first = &mut peaks.clone()[..128];
    first.sort_by(f64::total_cmp);
    peaks.sort_by(f64::total_cmp);
    let mut limits = vec![
        0.5 * peak,
        peak - uncertainty,
        peak,
        peak + uncertainty,
        2.0 * peak,
    ];
    if members > 0 {
        // One and two of 128; 80 and 81 of 2048, which are the most a pass allows and one more.
        limits.extend([first[126], first[125], peaks[2047 - 80], peaks[2047 - 81]]);
        limits.extend([peaks[2047 - 102], peaks[1024], peaks[10], peaks[2047]]);
    }
    limits
}

#[test]
fn verif_the_short_question_is_answered_as_the_whole_assessment() {
    let (mut passing, mut not_passing) = (0, 0);
    for (length_s, peak_g) in [(0.006, 12.0), (0.012, 8.0), (0.025, 3.0)] {
        let signal = short_pulse(length_s, peak_g);
        let conditioned = as_recorded(signal.clone());
        for model in MODELS {
            let stop = model_stop(model);
            // The long ensembles of one pulse see every look.
            let ensembles: &[u32] = if (0.01..0.02).contains(&length_s) {
                &[0, 128, 2048]
            } else {
                &[0, 128]
            };
            for &members in ensembles {
                for threshold in limits(&signal, stop, members) {
                    for polarity in POLARITIES {
                        let own = Policy {
                            members,
                            ..options(model, polarity)
                        };
                        let design = with_threshold(threshold);
                        if check_same(&conditioned, &[], &design, &own) {
                            passing += 1;
                        } else {
                            not_passing += 1;
                        }
                    }
                }
            }
        }
    }
    assert!(
        passing > 50 && not_passing > 50,
        "{passing} pass, {not_passing} do not: the grid must see both"
    );
}

fn model_stop(model: ModelChoice) -> StopModel {
    match model {
        ModelChoice::Only(stop) => stop,
        ModelChoice::Auto => StopModel::Rigid,
    }
}

#[test]
fn verif_the_short_question_counts_faults_windows_and_coast_alike() {
    let signal = short_pulse(0.012, 8.0);
    let conditioned = as_recorded(signal.clone());
    let (peak, _) = nominal(&signal, StopModel::Rigid);
    let mut seen = [0, 0];
    for threshold in [0.5 * peak, 1.5 * peak] {
        for members in [0, 128] {
            for window_s in [
                None,
                Some(Window::new(0.0, 0.012)),
                Some(Window::new(0.0, 0.03)),
                Some(Window::new(0.03, 0.06)),
            ] {
                for at_s in [None, Some(-1.0), Some(0.01), Some(0.02), Some(0.05)] {
                    for with_fault in [false, true] {
                        let findings = if with_fault {
                            blocking(at_s)
                        } else {
                            Vec::new()
                        };
                        for model in MODELS {
                            let own = Policy {
                                members,
                                window_s,
                                ..options(model, NEGATIVE)
                            };
                            let design = with_threshold(threshold);
                            let pass = check_same(&conditioned, &findings, &design, &own);
                            seen[usize::from(pass)] += 1;
                        }
                    }
                }
            }
        }
    }
    assert!(seen[0] > 20 && seen[1] > 20, "{seen:?}");
}

/// What the one refuses, the other refuses.
#[test]
fn verif_the_short_question_refuses_alike() {
    let conditioned = as_recorded(short_pulse(0.012, 8.0));
    let mut wide = Design::reference();
    wide.tolerance.insert("mass_kg".into(), 1.0.into());
    let own = Policy {
        members: 128,
        ..options(RIGID, NEGATIVE)
    };
    let empty = Policy {
        window_s: Some(Window::new(7.0, 8.0)),
        ..own.clone()
    };
    for (design, own) in [(&wide, &own), (&Design::reference(), &empty)] {
        let whole = assess(&conditioned, &[], design, own).unwrap_err();
        let short = passes(&conditioned, &[], design, own).unwrap_err();
        assert_eq!(whole.to_string(), short.to_string());
    }
}
