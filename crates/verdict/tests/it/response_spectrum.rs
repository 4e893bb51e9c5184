//! The latch response spectrum against closed forms, single replays and itself.

use crate::support::{data, one, options, replay, signal, signal_from, unconditioned};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::replay::RunOptions;
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY};
use latchgate_recording::{Finding, ReadOptions};
use latchgate_verdict::conditioning::{self, Between, Conditioned, ConditioningOptions};
use latchgate_verdict::readings::ReadingCache;
use latchgate_verdict::response_spectrum::plane::{Place, PlanePoint};
use latchgate_verdict::response_spectrum::{
    LeverFamily, ResponseSpectrum, SpectrumOptions, SpectrumRecording, strokes_m,
};
use std::f64::consts::PI;

/// Sign of the accelerations of these tests that opens.
const OPENS: OpensWhen = OpensWhen::Negative;

fn asked() -> SpectrumOptions {
    SpectrumOptions {
        seed: 1,
        work: 1_000_000_000,
        between: Between::BandLimited,
    }
}

fn spectrum_on(
    conditioned: &Conditioned,
    family: &LeverFamily,
    threads: usize,
) -> ResponseSpectrum {
    let (cache, control) = (ReadingCache::default(), Control::unwatched(threads));
    let recording = SpectrumRecording::new(
        conditioned,
        &conditioned.findings,
        asked(),
        &cache,
        &control,
    );
    recording
        .unwrap()
        .spectrum(family, OPENS, &control)
        .unwrap()
}

fn spectrum(signal: &Signal) -> ResponseSpectrum {
    spectrum_on(&unconditioned(signal), &paper(), 2)
}

/// Levers of the paper's restitution.
fn paper() -> LeverFamily {
    LeverFamily::of_chart((0.8, 0.8))
}

/// A half-sine that opens, after 20 ms of rest and followed by `after_s` of it.
fn half_sine(peak_g: f64, length_s: f64, after_s: f64) -> Signal {
    let rate_hz = 20_000.0;
    let count = ((0.02 + length_s + after_s) * rate_hz) as usize;
    let at = |index: usize| {
        let time_s = index as f64 / rate_hz - 0.02;
        match (0.0..length_s).contains(&time_s) {
            true => -peak_g * STANDARD_GRAVITY * (PI * time_s / length_s).sin(),
            false => 0.0,
        }
    };
    signal_from(rate_hz, -0.02, (0..count).map(at).collect())
}

/// Spring by inertia of the paper's lever [1/s²].
fn spring() -> f64 {
    let lever = Design::reference().lever;
    lever.spring_stiffness_nm_per_rad / lever.moment_of_inertia_kg_m2
}

/// Curve and zone lie about a value that single levers of one push reach and that grows with a power of its scale: not
/// below it, and above it by three standard deviations of the scale and two windows at most.
#[track_caller]
fn check_about(spectrum: &ResponseSpectrum, stroke_m: f64, expected_m_s2: f64, power: i32) {
    const TWO_WINDOWS: f64 = 1.1;
    let column = spectrum.at(stroke_m);
    let (curve, zone) = (
        column.spectrum_m_s2.unwrap(),
        column.zone_from_m_s2.unwrap(),
    );
    let (above, below) = (curve / expected_m_s2, zone / expected_m_s2);
    let room = TWO_WINDOWS * 1.03_f64.powi(power);
    assert!((1.0..room).contains(&above), "{stroke_m} m: {above}");
    assert!((1.0 / room..=1.0).contains(&below), "{stroke_m} m: {below}");
}

#[test]
fn val_short_pulses_ask_for_their_impulse() {
    // 400 g over 0.5 ms: v = 2 A T/π. Held by a* from the beginning, it comes v²/(2 a*) − v T/2 far, the spring aside.
    let (length, peak) = (5e-4, 400.0 * STANDARD_GRAVITY);
    let spectrum = spectrum(&half_sine(400.0, length, 0.4));
    let speed = 2.0 * peak * length / PI;
    for stroke_m in [0.004, 0.005, 0.008] {
        let energy = speed * speed - spring() * stroke_m * stroke_m;
        check_about(
            &spectrum,
            stroke_m,
            energy / (2.0 * (stroke_m + 0.5 * speed * length)),
            2,
        );
    }
}

#[test]
fn val_a_step_asks_for_its_height_less_the_spring() {
    // s″ = A − a* − (k0/I0) s from rest turns at s = 2 (A − a*)/(k0/I0).
    let height = 40.0 * STANDARD_GRAVITY;
    let samples = (0..6_000).map(|index| if index < 200 { 0.0 } else { -height });
    let spectrum = spectrum(&signal(10_000.0, samples.collect()));
    for stroke_m in [0.001, 0.01, 0.1, 0.2] {
        check_about(&spectrum, stroke_m, height - 0.5 * spring() * stroke_m, 1);
    }
}

#[test]
fn val_long_pulses_ask_for_their_peak() {
    // 1 mm is run through long before a half-sine of 0.2 s has changed.
    let spectrum = spectrum(&half_sine(50.0, 0.2, 0.1));
    check_about(&spectrum, 0.001, 0.985 * 50.0 * STANDARD_GRAVITY, 1);
}

#[test]
fn verif_a_larger_stroke_asks_for_no_more() {
    let spectrum = spectrum(&half_sine(100.0, 0.01, 0.2));
    let columns: Vec<_> = strokes_m()
        .into_iter()
        .map(|stroke| spectrum.at(stroke))
        .collect();
    for pair in columns.windows(2) {
        let [shorter, longer] =
            [pair[0], pair[1]].map(|column| column.spectrum_m_s2.unwrap_or(0.0));
        assert!(longer <= shorter);
        assert!(pair[0].zone_from_m_s2.unwrap_or(0.0) <= shorter);
    }
}

/// One of NHTSA 7292's channels as a replay conditions it, up to 100 ms after contact.
fn real(number: u32) -> Conditioned {
    let path = data(&format!("recordings/nhtsa_v07292.{number}"));
    let (mut channel, _) = one(&path, &ReadOptions::default());
    let contact = (-channel.start_s * channel.rate.hertz()) as usize;
    channel.values.truncate(contact + 1_250);
    conditioning::condition(&channel, &ConditioningOptions::default()).unwrap()
}

#[test]
fn verif_threads_change_nothing_and_seeds_a_step() {
    let conditioned = real(146);
    let own = spectrum_on(&conditioned, &paper(), 1);
    assert_eq!(own, spectrum_on(&conditioned, &paper(), 3));
    let (cache, control) = (ReadingCache::default(), Control::unwatched(2));
    let other = SpectrumOptions { seed: 2, ..asked() };
    let recording =
        SpectrumRecording::new(&conditioned, &conditioned.findings, other, &cache, &control);
    let other = recording
        .unwrap()
        .spectrum(&paper(), OPENS, &control)
        .unwrap();
    // A window is 4.9 % wide.
    let ratios = strokes_m()
        .into_iter()
        .filter_map(|stroke| Some(other.at(stroke).spectrum_m_s2? / own.at(stroke).spectrum_m_s2?));
    let mut ratios: Vec<f64> = ratios.collect();
    ratios.sort_unstable_by(f64::total_cmp);
    let median = ratios[ratios.len() / 2];
    assert!((0.95..1.06).contains(&median), "{ratios:?}");
    assert!(
        ratios.iter().all(|ratio| (0.7..1.5).contains(ratio)),
        "{ratios:?}"
    );
}

/// Replays the paper's lever with another inertia and preload, which put it at a stroke and a lift-off; returns if it
/// opens.
fn opens(conditioned: &Conditioned, stroke_m: f64, lift_off_m_s2: f64, stop: StopModel) -> bool {
    let mut design = Design::reference();
    let Design {
        lever, stop: rest, ..
    } = &mut design;
    // Spring, damping and soft stop follow the inertia.
    let times = stroke_m / (0.1 * lever.moment_of_inertia_kg_m2 / lever.unbalance_kg_m());
    lever.moment_of_inertia_kg_m2 *= times;
    lever.spring_stiffness_nm_per_rad *= times;
    lever.pivot_damping_nm_s_per_rad *= times;
    rest.stiffness_n_per_m *= times;
    rest.damping_n_s_per_m *= times;
    lever.preload_torque_nm = lift_off_m_s2 * lever.unbalance_kg_m();
    let options = RunOptions {
        opens_when: OPENS,
        ..options(stop)
    };
    let run = replay(&conditioned.used, &design, &options).run;
    let coast = run.coast_peak_angle_rad.unwrap_or(0.0);
    run.peak_angle_rad.max(coast) > 0.1
}

#[test]
fn verif_single_levers_stay_above_the_curve_and_open_below_the_zone() {
    let (mut above, mut below) = ([0, 0], [0, 0]);
    for number in [145, 146, 147, 148, 150] {
        let conditioned = real(number);
        let spectrum = spectrum_on(&conditioned, &paper(), 2);
        for stroke_m in strokes_m().into_iter().step_by(2) {
            let column = spectrum.at(stroke_m);
            for stop in [StopModel::Rigid, StopModel::Soft] {
                if let Some(curve) = column.spectrum_m_s2 {
                    // Half a window and five above it.
                    for times in [1.025, 1.25] {
                        above[usize::from(opens(&conditioned, stroke_m, times * curve, stop))] += 1;
                    }
                }
                if let Some(zone) = column.zone_from_m_s2 {
                    for times in [0.975, 0.8] {
                        below[usize::from(opens(&conditioned, stroke_m, times * zone, stop))] += 1;
                    }
                }
            }
        }
    }
    // A window that passes may hold one lever of 128 that opens, one below the zone six that stay.
    assert!(
        above[0] > 180 && above[1] <= 2,
        "above the curve stay and open: {above:?}"
    );
    assert!(
        below[1] > 120 && below[0] <= 6,
        "below the zone stay and open: {below:?}"
    );
}

#[test]
fn verif_restitution_is_stated_and_may_be_drawn() {
    let conditioned = real(146);
    let at = |bounds| {
        let spectrum = spectrum_on(&conditioned, &LeverFamily::of_chart(bounds), 2);
        let strokes = strokes_m().into_iter().step_by(4);
        let curve = strokes.map(|stroke| spectrum.at(stroke).spectrum_m_s2.unwrap_or(0.0));
        curve.sum::<f64>()
    };
    let [dead, paper, lively] = [(0.0, 0.0), (0.8, 0.8), (0.95, 0.95)].map(at);
    assert!(dead < paper && paper < lively, "{dead} {paper} {lively}");
    let drawn = at((0.5, 0.9));
    assert!(dead < drawn && drawn < lively, "{dead} {drawn} {lively}");
}

#[test]
fn verif_a_fault_ends_the_samples_and_one_from_the_start_leaves_none() {
    let conditioned = unconditioned(&half_sine(100.0, 0.01, 0.2));
    let (cache, control) = (ReadingCache::default(), Control::unwatched(2));
    let with = |finding: Finding| {
        SpectrumRecording::new(&conditioned, &[finding], asked(), &cache, &control)
    };
    let cut = with(Finding::blocking("gap", "samples are missing").at(0.003)).unwrap();
    assert!(
        cut.judged_until_s
            .is_some_and(|until_s| (0.002..0.003).contains(&until_s))
    );
    let whole = spectrum_on(&conditioned, &paper(), 2);
    let of_part = cut.spectrum(&paper(), OPENS, &control).unwrap();
    let at = |spectrum: &ResponseSpectrum| spectrum.at(0.02).spectrum_m_s2.unwrap_or(0.0);
    assert!(at(&of_part) < at(&whole));
    let refused = with(Finding::blocking("gap", "samples are missing")).unwrap_err();
    let text = refused.to_string();
    assert!(
        text.contains("blocking") && text.contains("samples are missing"),
        "{text}"
    );
}

#[test]
fn verif_a_design_lies_where_its_cloud_does() {
    let conditioned = unconditioned(&half_sine(60.0, 0.02, 0.2));
    let (cache, control) = (ReadingCache::default(), Control::unwatched(2));
    let recording = SpectrumRecording::new(
        &conditioned,
        &conditioned.findings,
        asked(),
        &cache,
        &control,
    );
    let recording = recording.unwrap();
    let place = |preload_torque_nm: f64, share: f64| {
        let mut design = Design::reference();
        design.lever.preload_torque_nm = preload_torque_nm;
        let tolerance = latchgate_kernel::model::tolerance::Tolerance::Share(share);
        design
            .tolerance
            .insert("preload_torque_nm".into(), tolerance);
        let point = PlanePoint::of(&design).unwrap();
        point.place(&design, &recording, OPENS, &control).unwrap()
    };
    let curve = recording
        .spectrum(&paper(), OPENS, &control)
        .unwrap()
        .at(0.00927);
    let edge_nm = curve.spectrum_m_s2.unwrap() * Design::reference().lever.unbalance_kg_m();
    assert_eq!(place(1.3 * edge_nm, 0.02), Place::Above);
    // The same lever, less well known, reaches into the zone.
    assert_eq!(place(1.3 * edge_nm, 0.15), Place::Zone);
    assert_eq!(place(0.97 * edge_nm, 0.02), Place::Zone);
    assert_eq!(place(0.5 * edge_nm, 0.02), Place::Below);
}

#[test]
fn verif_more_work_than_allowed_is_said() {
    let conditioned = unconditioned(&half_sine(60.0, 0.02, 0.1));
    let (cache, control) = (ReadingCache::default(), Control::unwatched(2));
    let few = SpectrumOptions {
        work: 1_000,
        ..asked()
    };
    let recording =
        SpectrumRecording::new(&conditioned, &conditioned.findings, few, &cache, &control);
    let refused = recording
        .unwrap()
        .spectrum(&paper(), OPENS, &control)
        .unwrap_err();
    assert!(
        refused.to_string().contains("limit work of 1000"),
        "{refused}"
    );
}
