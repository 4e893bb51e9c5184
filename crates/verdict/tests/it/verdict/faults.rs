//! Guards how far a fault reaches: a filter without phase, resampling and a bias taken from bad
//! samples carry it to where the finding does not say it is.

use super::*;
use latchgate_kernel::range::Window;
use latchgate_verdict::conditioning::cfc::{CfcFilter, design_frequency_hz};
use latchgate_verdict::conditioning::resample::resample;
use latchgate_verdict::conditioning::{Cfc, FilterStandard};

/// How far a filter carries a sample, as `docs/decision.md` states it [s].
fn reach_s(class: Cfc, standard: FilterStandard) -> f64 {
    1.5 / design_frequency_hz(class, standard)
}

/// A recording as used after a filter, its bias not removed.
fn filtered(signal: &Signal, class: Cfc) -> Conditioned {
    let filter = CfcFilter::new(class, FilterStandard::Iso6487);
    Conditioned {
        used: filter.apply(signal).unwrap(),
        filter: Some(class),
        ..as_recorded(signal.clone())
    }
}

/// How far resampling carries a sample: half the length of its kernel, 40 intervals of the lower rate [s].
fn resampling_reach_s(from_hz: f64, to_hz: f64) -> f64 {
    40.0 / from_hz.min(to_hz)
}

/// A recording as used at another rate, and after a filter if there is one.
fn resampled(signal: &Signal, to_hz: f64, class: Option<Cfc>) -> Conditioned {
    let used = resample(signal, SampleRate::from_hertz(to_hz).unwrap()).unwrap();
    let filter = class.map(|class| CfcFilter::new(class, FilterStandard::Iso6487));
    Conditioned {
        used: match filter {
            Some(filter) => filter.apply(&used).unwrap(),
            None => used,
        },
        filter: class,
        resample_hz: Some(to_hz),
        ..as_recorded(signal.clone())
    }
}

fn judged(
    conditioned: &Conditioned,
    at_s: f64,
    window_s: Option<Window>,
    design: &Design,
) -> Assessment {
    let own = Policy {
        window_s,
        ..options(RIGID, NEGATIVE)
    };
    assess(conditioned, &blocking(Some(at_s)), design, &own).unwrap()
}

/// Less than a thousandth of what an impulse leaves lies further away than the reach, at the
/// least rate that carries a class and far above it.
#[test]
fn verif_what_a_filter_carries_beyond_its_reach_is_a_thousandth() {
    for class in Cfc::ALL {
        for standard in [FilterStandard::Iso6487, FilterStandard::SaeJ211] {
            for times in [10.0, 12.5, 50.0] {
                let rate = SampleRate::from_hertz(times * f64::from(class.class())).unwrap();
                let middle = 2000;
                let mut samples = vec![0.0; 4001];
                samples[middle] = 1.0;
                let impulse = Signal {
                    start_s: 0.0,
                    rate,
                    samples,
                };
                let answer = CfcFilter::new(class, standard).apply(&impulse).unwrap();
                let reach = reach_s(class, standard) * rate.hertz();
                let (mut all, mut beyond) = (0.0, 0.0);
                for (index, value) in answer.samples.iter().enumerate() {
                    all += value.abs();
                    if (middle as f64 - index as f64) > reach {
                        beyond += value.abs();
                    }
                }
                let part = beyond / all;
                assert!(part < 1e-3, "{class:?} {standard:?} {times}: {part:e}");
                // And it is no more than the reach that is called so.
                let near = answer.samples[middle - (0.25 * reach) as usize];
                assert!(near.abs() > 1e-3 * answer.samples[middle], "{class:?}");
            }
        }
    }
}

/// Values that were lost after the window's end change what the filter makes of the samples
/// before it: the answer for the window was a pass, as if they could not.
#[test]
fn regress_a_fault_just_after_the_window_reaches_into_it() {
    let sound = samples(|t| half_sine(t, 0.002, 0.02, -40.0));
    let mut faulty = sound.clone();
    let fault_s = 0.003;
    for (index, value) in faulty.samples.iter_mut().enumerate() {
        if index as f64 / 10_000.0 - 0.05 >= fault_s - 1e-9 {
            *value = 0.0;
        }
    }
    let class = Cfc::Cfc60;
    let window = Some(Window::new(-0.01, 0.0025));
    let (wrong, right) = (filtered(&faulty, class), filtered(&sound, class));
    let last = 525;
    let change = (wrong.used.samples[last] - right.used.samples[last]).abs() / G;
    assert!(change > 3.0, "{change} g inside the window");
    let answer = |reach: bool| {
        let end = if reach { 0.0025 } else { fault_s - 0.0125 };
        let window = Some(Window::new(-0.045, end));
        judged(&wrong, fault_s, window, &Design::reference())
    };
    let near = answer(true);
    assert_eq!(near.answer, Answer::Unusable, "{:?}", near.why);
    let finding = near
        .findings
        .iter()
        .find(|finding| finding.code == "fault-reaches-window")
        .unwrap();
    assert_eq!(finding.at_s, Some(fault_s));
    assert!(finding.text.contains("by 12 ms"), "{}", finding.text);
    let far = answer(false);
    assert_eq!(far.answer, Answer::Pass, "{:?}", far.why);
    assert!(
        far.findings
            .iter()
            .any(|finding| finding.code == "fault-after-window")
    );
    // As recorded, nothing is carried anywhere.
    let plain = judged(&as_recorded(faulty), fault_s, window, &Design::reference());
    assert_eq!(plain.answer, Answer::Pass);
}

/// To the sample: a fault counts up to the reach after the window's end, of each class.
#[test]
fn verif_a_fault_counts_as_far_as_its_filter_reaches() {
    let signal = samples(weak);
    let end = 0.1;
    for class in Cfc::ALL {
        let used = filtered(&signal, class);
        let reach = reach_s(class, FilterStandard::Iso6487);
        for (at_s, expected) in [
            (end, Answer::Unusable),
            (end + 0.999 * reach, Answer::Unusable),
            (end + 1.001 * reach, Answer::Pass),
        ] {
            let window = Some(Window::new(-0.01, end));
            let found = judged(&used, at_s, window, &Design::reference());
            assert_eq!(found.answer, expected, "{class:?} {at_s}");
        }
    }
}

/// Nothing of a sample is left further away than resampling reaches, and something right within.
#[test]
fn verif_what_resampling_carries_beyond_its_reach_is_nothing() {
    const MIDDLE: usize = 1000;
    for (from_hz, to_hz) in [
        (10_000.0, 5_000.0),
        (10_000.0, 3_700.0),
        (10_000.0, 20_000.0),
        (4_000.0, 10_000.0),
    ] {
        let mut samples = vec![0.0; 2 * MIDDLE + 1];
        samples[MIDDLE] = 1.0;
        let impulse = Signal {
            start_s: 0.0,
            rate: SampleRate::from_hertz(from_hz).unwrap(),
            samples,
        };
        let answer = resample(&impulse, SampleRate::from_hertz(to_hz).unwrap()).unwrap();
        let reach_s = resampling_reach_s(from_hz, to_hz);
        let mut most_s = 0.0_f64;
        for (index, value) in answer.samples.iter().enumerate() {
            if *value != 0.0 {
                most_s = most_s.max(impulse.time_s(MIDDLE) - answer.time_s(index));
            }
        }
        let case = format!("{from_hz} Hz to {to_hz} Hz: {most_s} s of {reach_s} s");
        assert!(most_s <= reach_s * (1.0 + 1e-9), "{case}");
        assert!(most_s > 0.95 * reach_s, "{case}");
    }
}

/// A fault counts up to the reach of resampling and filter together after the window's end, whether the rate went
/// up or down.
#[test]
fn verif_a_fault_counts_as_far_as_resampling_and_filter_reach() {
    let signal = samples(weak);
    let end_s = 0.1;
    for to_hz in [5_000.0, 20_000.0] {
        for class in [None, Some(Cfc::Cfc180), Some(Cfc::Cfc60)] {
            let used = resampled(&signal, to_hz, class);
            let filter_s = class.map_or(0.0, |class| reach_s(class, FilterStandard::Iso6487));
            let all_s = filter_s + resampling_reach_s(signal.rate.hertz(), to_hz);
            for (after_s, expected, code) in [
                (0.5 * all_s, Answer::Unusable, "fault-reaches-window"),
                (0.999 * all_s, Answer::Unusable, "fault-reaches-window"),
                (1.001 * all_s, Answer::Pass, "fault-after-window"),
            ] {
                let window = Some(Window::new(-0.01, end_s));
                let found = judged(&used, end_s + after_s, window, &Design::reference());
                let case = format!("{to_hz} Hz, {class:?}, {after_s} s: {:#?}", found.why);
                assert_eq!(found.answer, expected, "{case}");
                let mut findings = found.findings.iter();
                assert!(findings.any(|finding| finding.code == code), "{case}");
            }
        }
    }
}

/// A crossing before the fault is a fail, to the sample that the finding names; with a filter the
/// verdict says what of it the fault may have touched.
#[test]
fn verif_a_crossing_before_the_fault_fails_whatever_the_filter() {
    let signal = lost();
    for class in [Cfc::Cfc1000, Cfc::Cfc180] {
        let used = filtered(&signal, class);
        let crossing = explicit(&used.used, StopModel::Rigid, OpensWhen::Negative)
            .run
            .first_crossing_s
            .unwrap();
        let reach = reach_s(class, FilterStandard::Iso6487);
        let at = |after: f64| judged(&used, crossing + after, None, &Design::reference());
        assert_eq!(at(-3e-4).answer, Answer::Unusable, "{class:?}");
        for after in [3e-4, reach + 0.001] {
            let failed = at(after);
            assert_eq!(failed.answer, Answer::Fail, "{class:?} {:?}", failed.why);
            let told = failed
                .why
                .iter()
                .find(|reason| reason.code == "failed-before-fault")
                .unwrap();
            assert!(told.text.contains("The filter mixes"), "{}", told.text);
        }
    }
    let plain = as_recorded(signal.clone());
    let crossing = explicit(&signal, StopModel::Rigid, OpensWhen::Negative)
        .run
        .first_crossing_s
        .unwrap();
    let unfiltered = judged(&plain, crossing + 3e-4, None, &Design::reference());
    assert_eq!(unfiltered.answer, Answer::Fail);
}

/// A bias that was taken from bad samples spoils those before the fault as well.
#[test]
fn regress_a_bias_taken_after_the_fault_spoils_all() {
    let window = Some(Window::new(-0.01, 0.1));
    let of = |bias_end_s: f64| {
        let conditioned = Conditioned {
            bias_samples: 100,
            bias_window_s: Some(Window::new(bias_end_s - 0.01, bias_end_s)),
            ..as_recorded(samples(weak))
        };
        judged(&conditioned, 0.15, window, &Design::reference())
    };
    assert_eq!(of(-0.02).answer, Answer::Pass);
    let spoiled = of(0.2);
    assert_eq!(spoiled.answer, Answer::Unusable);
    assert!(
        spoiled
            .findings
            .iter()
            .any(|finding| finding.code == "fault-reaches-window")
    );
}

/// Each row of the filter table stands for its own reach.
#[test]
fn verif_the_filter_table_counts_each_filters_own_reach() {
    let end = 0.1;
    let at_s = end + 0.005;
    let own = Policy {
        window_s: Some(Window::new(-0.01, end)),
        ..options(RIGID, NEGATIVE)
    };
    let found = assess(
        &as_recorded(samples(weak)),
        &blocking(Some(at_s)),
        &Design::reference(),
        &own,
    )
    .unwrap();
    assert_eq!(found.answer, Answer::Pass);
    for row in &found.filters {
        let expected = if row.filter == Some(Cfc::Cfc60) {
            Answer::Unusable
        } else {
            Answer::Pass
        };
        assert_eq!(row.verdict, Some(expected), "{:?}", row.filter);
    }
}
