//! Batches of levers against the scalar kernel, which they must agree with to its stated error,
//! whatever the neighbours and the threads.

use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::batch::{
    self, AskedPeaks, BatchOptions, Member, MemberPeak, SensorView,
};
use latchgate_kernel::replay::{self, RunOptions, State};
use latchgate_kernel::signal::{Projection, Signal};
use latchgate_kernel::units::{OpensWhen, SampleRate};

/// A decaying burst of a few tones [m/s²], like a door's.
fn burst(amplitude: f64, samples: usize) -> Signal {
    let rate = 10_000.0;
    let value = |k: usize| {
        let t = k as f64 / rate;
        let tones: f64 = (1..=12)
            .map(|j| {
                libm::sin(
                    std::f64::consts::TAU * (20.0 * f64::from(j) * t + 0.618 * f64::from(j * j)),
                )
            })
            .sum();
        amplitude * t / 0.02 * libm::exp(1.0 - t / 0.02) * tones
    };
    Signal {
        start_s: 0.0,
        rate: SampleRate::from_hertz(rate).unwrap(),
        samples: (0..samples).map(value).collect(),
    }
}

/// Members spread over preload, stiffness, restitution, scale and bias.
fn member(index: usize) -> Member {
    let design = Design::reference();
    let part = |step: f64| (index as f64 * step).fract();
    let mut lever = design.lever;
    let mut stop = design.stop;
    lever.preload_torque_nm *= 0.5 + 2.0 * part(0.618_034);
    lever.spring_stiffness_nm_per_rad *= 0.5 + part(0.414_214);
    stop.restitution = 0.5 + 0.45 * part(0.732_051);
    Member {
        lever,
        stop,
        scale: 0.9 + 0.2 * part(0.236_068),
        bias_m_s2: part(0.302_776) - 0.5,
        second: SensorView::default(),
        catch: None,
    }
}

fn options(stop: StopModel, threads: usize) -> BatchOptions {
    BatchOptions {
        stop,
        projection: Projection::ALIGNED,
        opens_when: OpensWhen::Negative,
        initial: None,
        window: None,
        coast: true,
        asked: AskedPeaks::ALL,
        threshold_rad: Design::reference().criterion.threshold_rad,
        threads,
    }
}

/// Runs one member by the scalar kernel.
fn scalar(signal: &Signal, index: usize, options: &BatchOptions) -> replay::RunOutcome {
    let member = member(index);
    let mut seen = signal.clone();
    for a in &mut seen.samples {
        *a = member.scale * *a + member.bias_m_s2;
    }
    let design = Design {
        lever: member.lever,
        stop: member.stop,
        ..Design::reference()
    };
    let options = RunOptions {
        initial: options.initial,
        window: options.window,
        ..RunOptions::new(options.stop, options.opens_when)
    };
    replay::run(&seen, &design, &options).unwrap()
}

/// Batch and scalar run are each off by what the scalar run states, at most: so they differ by
/// twice that at most. Peaks and coasts.
#[track_caller]
fn check_agrees(amplitude: f64, options: &BatchOptions) {
    let signal = burst(amplitude, 1500);
    let count = 203;
    let peaks = batch::peaks(&signal, count, &member, options).unwrap();
    assert_eq!(peaks.len(), count);
    let (mut coasting, mut spared, mut crossing) = (0, 0, 0);
    let interval = signal.rate.interval().seconds();
    for (index, peak) in peaks.iter().enumerate() {
        let one = scalar(&signal, index, options);
        let what = format!("member {index} at {amplitude} m/s², {options:?}");
        let off = (peak.peak_angle_rad - one.run.peak_angle_rad).abs();
        let stated = one.run.numerical_error_rad;
        assert!(
            off <= 2.0 * stated,
            "{what}: off by {off:e}, stated {stated:e}"
        );
        // A straight line between two samples; what errs by so much may cross one sample on.
        match (peak.first_crossing_s, one.run.first_crossing_s) {
            (None, None) => {}
            (Some(got), Some(want)) => {
                crossing += 1;
                let part = (got - want).abs() / interval;
                assert!(part < 0.2, "{what}: crosses at {got} s, not {want} s");
            }
            (got, want) => panic!("{what}: crosses at {got:?}, scalar {want:?}"),
        }
        match (peak.coast_peak_angle_rad, one.run.coast_peak_angle_rad) {
            (None, None) => {}
            // Not followed to the end, since nothing could still exceed the peak.
            (None, Some(want)) => {
                spared += 1;
                assert!(want < peak.peak_angle_rad, "{what}: coasts to {want}");
            }
            (Some(got), Some(want)) => {
                coasting += 1;
                let (off, stated) = ((got - want).abs(), one.coast_error_rad);
                assert!(
                    off <= 2.0 * stated,
                    "{what}: coast off by {off:e}, stated {stated:e}"
                );
            }
            (got, want) => panic!("{what}: coast {got:?}, scalar {want:?}"),
        }
    }
    if amplitude >= 300.0 {
        assert!(crossing > 40, "{crossing} cross at {amplitude} m/s²");
    }
    if amplitude > 100.0 {
        assert!(
            coasting > 4 && coasting + spared > 10,
            "{coasting} and {spared} spared at {amplitude} m/s² are still moving"
        );
    }
}

#[track_caller]
fn check_agrees_at_every_amplitude(stop: StopModel) {
    let plain = options(stop, 1);
    for amplitude in [5.0, 30.0, 300.0] {
        check_agrees(amplitude, &plain);
        check_agrees(
            amplitude,
            &BatchOptions {
                opens_when: OpensWhen::Positive,
                window: Some((300, 900)),
                ..plain
            },
        );
        check_agrees(
            amplitude,
            &BatchOptions {
                initial: Some(State::new(0.3, -20.0)),
                ..plain
            },
        );
    }
}

#[test]
fn verif_rigid_members_agree_with_the_scalar_kernel() {
    check_agrees_at_every_amplitude(StopModel::Rigid);
}

#[test]
fn verif_soft_members_agree_with_the_scalar_kernel() {
    check_agrees_at_every_amplitude(StopModel::Soft);
}

fn bits(peaks: &[MemberPeak]) -> Vec<(u64, Option<u64>)> {
    peaks
        .iter()
        .map(|peak| {
            (
                peak.peak_angle_rad.to_bits(),
                peak.coast_peak_angle_rad.map(f64::to_bits),
            )
        })
        .collect()
}

/// Lanes of one number, which every machine has, give the bits of this machine's vectors.
#[test]
fn verif_the_width_of_the_vectors_changes_no_digit() {
    for stop in [StopModel::Rigid, StopModel::Soft] {
        for amplitude in [30.0, 300.0] {
            let signal = burst(amplitude, 900);
            let options = options(stop, 1);
            let wide = batch::peaks(&signal, 100, &member, &options).unwrap();
            let narrow = batch::peaks_without_vectors(&signal, 100, &member, &options).unwrap();
            assert_eq!(bits(&wide), bits(&narrow), "{amplitude} m/s², {stop:?}");
        }
    }
}

/// A member's digits depend on nothing but the member.
#[test]
fn verif_threads_and_neighbours_change_no_digit() {
    let signal = burst(60.0, 800);
    for stop in [StopModel::Rigid, StopModel::Soft] {
        let one = batch::peaks(&signal, 600, &member, &options(stop, 1)).unwrap();
        let three = batch::peaks(&signal, 600, &member, &options(stop, 3)).unwrap();
        assert!(bits(&one) == bits(&three), "{stop:?}");
        // The same members in another order, so that every lane has other neighbours.
        let other_order = |index| member(599 - index);
        let reversed = batch::peaks(&signal, 600, &other_order, &options(stop, 2)).unwrap();
        let mut back = bits(&reversed);
        back.reverse();
        assert!(bits(&one) == back, "{stop:?}");
    }
}

/// A member that no number describes has no peak, and changes none of its neighbours'.
#[test]
fn verif_a_member_that_is_no_number_stays_alone() {
    let signal = burst(300.0, 800);
    for stop in [StopModel::Rigid, StopModel::Soft] {
        let options = options(stop, 1);
        let sound = batch::peaks(&signal, 20, &member, &options).unwrap();
        for spoil in [
            |member: &mut Member| member.scale = f64::NAN,
            |member: &mut Member| member.bias_m_s2 = f64::NAN,
            |member: &mut Member| member.lever.preload_torque_nm = f64::NAN,
            |member: &mut Member| member.scale = f64::INFINITY,
        ] {
            let spoilt = |index: usize| {
                let mut member = member(index);
                if index == 5 {
                    spoil(&mut member);
                }
                member
            };
            let peaks = batch::peaks(&signal, 20, &spoilt, &options).unwrap();
            assert!(peaks[5].peak_angle_rad.is_nan(), "{stop:?}: {:?}", peaks[5]);
            for (index, (got, want)) in bits(&peaks).iter().zip(bits(&sound)).enumerate() {
                assert!(index == 5 || *got == want, "{stop:?}: neighbour {index}");
            }
        }
    }
}

#[track_caller]
fn check_refused(signal: &Signal, options: &BatchOptions, word: &str) {
    let error = batch::peaks(signal, 3, &member, options).unwrap_err();
    assert!(error.to_string().contains(word), "{error}");
}

/// What the scalar run refuses, a batch refuses as well.
#[test]
fn verif_a_batch_refuses_what_a_run_refuses() {
    let plain = options(StopModel::Rigid, 1);
    let mut signal = burst(30.0, 50);
    let inside = BatchOptions {
        initial: Some(State::new(-0.1, 0.0)),
        ..plain
    };
    check_refused(&signal, &inside, "initial state");
    let fast = BatchOptions {
        initial: Some(State::new(0.0, f64::NAN)),
        ..plain
    };
    check_refused(&signal, &fast, "initial state");
    signal.samples[7] = f64::NAN;
    check_refused(&signal, &plain, "NaN");
    signal.samples.truncate(1);
    check_refused(&signal, &plain, "replay");
}

/// Plain flight is taken side by side: few samples fall to the scalar kernel.
#[test]
fn verif_flight_needs_the_scalar_kernel_seldom() {
    let signal = burst(300.0, 1500);
    let peaks = batch::peaks(&signal, 64, &member, &options(StopModel::Rigid, 1)).unwrap();
    let scalar: u32 = peaks.iter().map(|peak| peak.scalar_samples).sum();
    let share = f64::from(scalar) / (64.0 * 1499.0);
    assert!(share < 0.25, "{share}");
}

/// The end of a recording that cannot raise the peak is left out, and what is left out changes
/// no peak: the scalar kernel follows it.
#[test]
fn verif_a_quiet_end_is_spared() {
    let signal = burst(300.0, 6000);
    for stop in [StopModel::Rigid, StopModel::Soft] {
        let options = options(stop, 2);
        let peaks = batch::peaks(&signal, 64, &member, &options).unwrap();
        let spared: u32 = peaks.iter().map(|peak| peak.spared_samples).sum();
        let share = f64::from(spared) / (64.0 * 5999.0);
        assert!(share > 0.25, "{stop:?}: {share} spared");
        for (index, peak) in peaks.iter().enumerate() {
            let one = scalar(&signal, index, &options);
            let off = (peak.peak_angle_rad - one.run.peak_angle_rad).abs();
            let stated = one.run.numerical_error_rad;
            assert!(
                off <= 2.0 * stated,
                "member {index}, {stop:?}: off by {off:e}, stated {stated:e}"
            );
        }
    }
}

/// A weak opening pulse, a pause longer than the distance between two questions, and a pulse that
/// presses the lever back into a stop from which it rebounds far beyond its first peak: the pause
/// must not be taken for the end.
#[test]
fn verif_a_rebound_after_a_pause_is_not_spared() {
    let samples: Vec<f64> = (0..800)
        .map(|k| match k {
            0..40 => -10.0 * 9.806_65,
            120..170 => 200.0 * 9.806_65,
            _ => 0.0,
        })
        .collect();
    let signal = Signal {
        start_s: 0.0,
        rate: SampleRate::from_hertz(10_000.0).unwrap(),
        samples,
    };
    let design = Design::reference();
    let nominal = |_: usize| Member {
        lever: design.lever,
        stop: design.stop,
        scale: 1.0,
        bias_m_s2: 0.0,
        second: SensorView::default(),
        catch: None,
    };
    let peaks = batch::peaks(&signal, 3, &nominal, &options(StopModel::Rigid, 1)).unwrap();
    let run = replay::run(
        &signal,
        &design,
        &RunOptions::new(StopModel::Rigid, OpensWhen::Negative),
    )
    .unwrap();
    assert!(run.run.peak_angle_rad > 0.5, "{:?}", run.run);
    for peak in peaks {
        let off = (peak.peak_angle_rad - run.run.peak_angle_rad).abs();
        assert!(off <= 2.0 * run.run.numerical_error_rad, "off by {off:e}");
    }
}

/// Peaks that are asked for from an angle on: those beyond it are what they are without the wish, to
/// twice the stated error, the others stay below it. Chatter that matters to nobody is cut short: few
/// samples are left to the scalar kernel.
#[test]
fn verif_peaks_beyond_the_angle_asked_for_are_the_same() {
    let from_rad = 0.08;
    let (mut beyond, mut below) = (0, 0);
    for (amplitude, stop) in [
        (5.0, StopModel::Rigid),
        (30.0, StopModel::Rigid),
        (60.0, StopModel::Rigid),
        (5.0, StopModel::Soft),
        (30.0, StopModel::Soft),
        (60.0, StopModel::Soft),
    ] {
        let signal = burst(amplitude, 1500);
        let every = options(stop, 2);
        let asked = BatchOptions {
            asked: AskedPeaks {
                from_rad,
                to_rad: f64::INFINITY,
            },
            ..every
        };
        let all = batch::peaks(&signal, 64, &member, &every).unwrap();
        let some = batch::peaks(&signal, 64, &member, &asked).unwrap();
        for (index, (all, some)) in all.iter().zip(&some).enumerate() {
            let (want, got) = (all.highest_rad(), some.highest_rad());
            if want > from_rad {
                beyond += 1;
                let stated = scalar(&signal, index, &every).run.numerical_error_rad;
                let off = (got - want).abs();
                assert!(
                    off <= 2.0 * stated,
                    "member {index} at {amplitude} m/s², {stop:?}: off by {off:e}, stated {stated:e}"
                );
            } else {
                below += 1;
                assert!(got <= from_rad, "member {index} at {amplitude} m/s²: {got}");
            }
        }
        let scalar = |of: &[MemberPeak]| of.iter().map(|peak| peak.spent).sum::<u64>();
        assert!(
            scalar(&some) <= scalar(&all),
            "{amplitude} m/s², {stop:?}: {} steps after {}",
            scalar(&some),
            scalar(&all)
        );
    }
    assert!(beyond > 50 && below > 50, "{beyond} beyond, {below} below");
}

/// A run of which the peak alone is asked has the same peak, at the same time, after the same
/// impacts, and leaves a quiet end out.
#[test]
fn verif_a_run_of_the_peak_alone_has_the_same_peak() {
    let design = Design::reference();
    for stop in [StopModel::Rigid, StopModel::Soft] {
        let (mut steps, mut steps_alone) = (0, 0);
        for amplitude in [8.0, 20.0, 50.0, 100.0, 300.0] {
            let signal = burst(amplitude, 6000);
            for window in [None, Some((200, 5000))] {
                let whole = RunOptions {
                    error_bound: true,
                    window,
                    ..RunOptions::new(stop, OpensWhen::Negative)
                };
                let alone = RunOptions {
                    error_bound: false,
                    peak_only: true,
                    ..whole
                };
                let whole = replay::run(&signal, &design, &whole).unwrap().run;
                let alone = replay::run(&signal, &design, &alone).unwrap().run;
                let what = format!("{amplitude} m/s², {stop:?}, {window:?}");
                let off = (alone.peak_angle_rad - whole.peak_angle_rad).abs();
                let stated = whole.numerical_error_rad;
                assert!(
                    off <= 2.0 * stated,
                    "{what}: off by {off:e}, stated {stated:e}"
                );
                assert!(
                    (alone.peak_time_s - whole.peak_time_s).abs() < 1e-6,
                    "{what}"
                );
                let before = |run: &replay::Run| {
                    let list = run.impact_list.iter();
                    list.filter(|impact| impact[0] <= run.peak_time_s).count()
                };
                assert_eq!(before(&alone), before(&whole), "{what}");
                steps += whole.work.steps;
                steps_alone += alone.work.steps;
            }
        }
        assert!(
            steps_alone < steps * 9 / 10,
            "{stop:?}: {steps_alone} steps of {steps}"
        );
    }
}

/// A lever without spring and damper, thrown off its stop under samples that stand still: its bounces
/// end within one sample by the closed form, but the first is so high that cos φ counts, and is the peak.
#[test]
fn verif_a_high_bounce_within_a_sample_is_followed() {
    let design = Design::reference();
    let mut lever = design.lever;
    lever.spring_stiffness_nm_per_rad = 0.0;
    lever.pivot_damping_nm_s_per_rad = 0.0;
    let mut stop = design.stop;
    stop.restitution = 0.1;
    let pressing = 1e4 * lever.moment_of_inertia_kg_m2 / lever.unbalance_kg_m();
    let signal = Signal {
        start_s: 0.0,
        rate: SampleRate::from_hertz(100.0).unwrap(),
        samples: vec![pressing; 20],
    };
    let options = BatchOptions {
        initial: Some(State::new(0.0, 40.0)),
        ..options(StopModel::Rigid, 1)
    };
    let member = |_: usize| Member {
        lever,
        stop,
        scale: 1.0,
        bias_m_s2: 0.0,
        second: SensorView::default(),
        catch: None,
    };
    let peak = batch::peaks(&signal, 1, &member, &options).unwrap()[0];
    let of_run = RunOptions {
        initial: options.initial,
        ..RunOptions::new(StopModel::Rigid, OpensWhen::Negative)
    };
    let lone = Design {
        lever,
        stop,
        ..design
    };
    let run = replay::run(&signal, &lone, &of_run).unwrap().run;
    assert!(run.peak_angle_rad > 0.07, "{run:?}");
    let off = (peak.peak_angle_rad - run.peak_angle_rad).abs();
    let stated = run.numerical_error_rad;
    assert!(off <= 2.0 * stated, "off by {off:e}, stated {stated:e}");
}
