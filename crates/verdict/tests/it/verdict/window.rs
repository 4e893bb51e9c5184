//! Guards the ends of the judged window: its first and its last sample are judged, and none beyond them.

use super::*;

const RATE_HZ: f64 = 10_000.0;
const START_S: f64 = -0.002;
/// Last sample of the record.
const LAST: usize = 60;

/// The paper's lever without damping, which moves by a closed form where nothing accelerates it.
fn undamped() -> Design {
    let mut design = Design::reference();
    design.lever.pivot_damping_nm_s_per_rad = 0.0;
    design
}

/// Angle of the free lever at a sample [rad]: (φ0 + T0/k0) cos ωt + (φ'0/ω) sin ωt − T0/k0.
fn free_angle_rad(start_angle_rad: f64, start_velocity_rad_s: f64, index: f64) -> f64 {
    let lever = undamped().lever;
    let shift = lever.preload_torque_nm / lever.spring_stiffness_nm_per_rad;
    let omega = (lever.spring_stiffness_nm_per_rad / lever.moment_of_inertia_kg_m2).sqrt();
    let (sine, cosine) = libm::sincos(omega * index / RATE_HZ);
    (start_angle_rad + shift) * cosine + start_velocity_rad_s / omega * sine - shift
}

/// A lever that rises has its peak on the last sample of the window, one that falls on the first; a limit half an
/// interval to either side of it is exceeded or not, by nominal run and ensemble.
#[test]
fn verif_a_peak_on_the_first_or_last_sample_of_the_window_counts() {
    let windows = [
        // Ends that are meant to hit a sample, which no binary number does.
        (0.0, 0.0031, 20, 51),
        (0.0007, 0.0013, 27, 33),
        // Ends between samples.
        (0.000_04, 0.003_16, 21, 51),
        // Two samples.
        (0.0009, 0.001, 29, 30),
        // Ends outside the record.
        (-1.0, 0.001, 0, 30),
        (0.001, 9.0, 30, LAST),
        (START_S, START_S + LAST as f64 / RATE_HZ, 0, LAST),
    ];
    let quiet = Signal {
        start_s: START_S,
        rate: SampleRate::from_hertz(RATE_HZ).unwrap(),
        samples: vec![0.0; LAST + 1],
    };
    let recording = as_recorded(quiet.clone());
    for (from_s, until_s, first, last) in windows {
        for (start_angle_rad, start_velocity_rad_s, at_peak) in
            [(0.01, 9.0, last), (0.3, -1.0, first)]
        {
            let angle = |index: f64| free_angle_rad(start_angle_rad, start_velocity_rad_s, index);
            let rises = at_peak == last;
            let (peak_index, outwards) = (at_peak as f64, if rises { 1.0 } else { -1.0 });
            let exceeded = angle(peak_index - 0.5 * outwards);
            let kept = angle(peak_index + 0.5 * outwards);
            for (model, polarity) in [
                (RIGID, NEGATIVE),
                (RIGID, Polarity::Declared(OpensWhen::Positive)),
                (ModelChoice::Only(StopModel::Soft), NEGATIVE),
                (ModelChoice::Auto, Polarity::Undeclared),
            ] {
                let policy = Policy {
                    window_s: Some(Window::new(from_s, until_s)),
                    initial_angle_rad: Some(start_angle_rad),
                    initial_velocity_rad_s: Some(start_velocity_rad_s),
                    members: 128,
                    ..options(model, polarity)
                };
                let judged = |limit_rad: f64| {
                    let mut design = undamped();
                    design.criterion.threshold_rad = limit_rad;
                    design.input.bias_g = 0.0;
                    assess(&recording, &[], &design, &policy).unwrap()
                };
                let case = format!("{from_s}..{until_s}, {start_angle_rad}, {policy:?}");
                let found = judged(exceeded);
                assert_eq!(found.answer, Answer::Fail, "{case}: {:#?}", found.why);
                let peak = &found.nominal;
                let away = (peak.peak_angle_rad - angle(peak_index)).abs();
                assert!(away < 1e-9, "{case}: {peak:?}");
                let away_s = (peak.peak_time_s - quiet.time_s(at_peak)).abs();
                assert!(away_s < 1e-9, "{case}: {peak:?}");
                // One that rises coasts on beyond the limit.
                let expected = if rises {
                    Answer::Undecided
                } else {
                    Answer::Pass
                };
                let found = judged(kept);
                assert_eq!(found.answer, expected, "{case}: {:#?}", found.why);
            }
        }
    }
}
