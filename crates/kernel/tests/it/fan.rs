//! Many levers on one sine against the stroboscope that follows one, to rounding and what impacts
//! make of it; and the same bits whatever the neighbours and the threads.

use latchgate_kernel::model::Design;
use latchgate_kernel::model::excitation::Harmonic;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::strobe_batch::{
    self, Ending, Followed, HarmonicStart, StrobeBatchOptions,
};
use latchgate_kernel::replay::{Section, State, Strobe};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Gravity of the quad-precision reference values [m/s²].
const GRAVITY: f64 = 9.81;

fn options(stop: StopModel, periods_max: u32) -> StrobeBatchOptions {
    StrobeBatchOptions {
        stop,
        angular_frequency_rad_s: 100.0,
        phase_rad: 0.0,
        periods_max,
        keep: periods_max as usize,
        peaks: true,
        threads: 1,
    }
}

fn start(amplitude: f64, angle: f64, velocity: f64) -> HarmonicStart {
    HarmonicStart {
        initial: Some(State::new(angle, velocity)),
        amplitude_m_s2: amplitude * GRAVITY,
    }
}

/// Follows all starts for all periods.
#[track_caller]
fn follow(starts: &[HarmonicStart], options: &StrobeBatchOptions) -> Vec<Followed> {
    let all = strobe_batch::follow(
        &Design::reference(),
        starts.len(),
        &|index| starts[index],
        options,
        &|_, _, _: &Section| false,
        None,
    )
    .unwrap();
    assert_eq!(all.len(), starts.len());
    for (index, one) in all.iter().enumerate() {
        assert_eq!(one.index, index);
        assert_eq!(
            (one.ending, one.periods),
            (Ending::Periods, options.periods_max)
        );
    }
    all
}

/// The same lever by the stroboscope.
fn strobe(start: &HarmonicStart, options: &StrobeBatchOptions) -> Vec<Section> {
    let excitation = Harmonic {
        amplitude_m_s2: start.amplitude_m_s2,
        angular_frequency_rad_s: options.angular_frequency_rad_s,
        phase_rad: options.phase_rad,
    };
    let mut strobe = Strobe::new(
        &Design::reference(),
        options.stop,
        &excitation,
        start.initial,
    )
    .unwrap();
    (0..options.periods_max)
        .map(|_| strobe.advance().unwrap())
        .collect()
}

/// Sections agree to `tolerance` [rad], [100 rad/s], and impacts and rests are the same.
#[track_caller]
fn check_agrees(starts: &[HarmonicStart], options: &StrobeBatchOptions, tolerance: f64) {
    for (one, start) in follow(starts, options).iter().zip(starts) {
        for (period, (got, want)) in one.sections.iter().zip(strobe(start, options)).enumerate() {
            let what = format!("{start:?}, {:?}, period {period}", options.stop);
            let off = [
                got.angle_rad - want.angle_rad,
                1e-2 * (got.velocity_rad_s - want.velocity_rad_s),
                got.peak_angle_rad - want.peak_angle_rad,
            ];
            assert!(
                off.iter().all(|off| off.abs() <= tolerance),
                "{what}: off by {off:?}"
            );
            assert_eq!(got.impacts, want.impacts, "{what}");
            assert_eq!(got.rested, want.rested, "{what}");
        }
    }
}

/// Starts all over the plane of the paper's basins, and rest.
fn spread(count: usize) -> Vec<HarmonicStart> {
    let part = |index: usize, step: f64| (index as f64 * step).fract();
    (0..count)
        .map(|index| {
            let amplitude = 5.0 * part(index, 0.302_776);
            let (angle, velocity) = (part(index, 0.618_034), 40.0 * part(index, 0.414_214) - 20.0);
            let mut start = start(amplitude, angle, velocity);
            if index.is_multiple_of(7) {
                start.initial = None;
            }
            start
        })
        .collect()
}

/// The three histories of the paper's Fig. 10, up to their attractors.
#[test]
fn verif_the_three_histories_agree_with_the_stroboscope() {
    let starts = [
        start(1.0, 0.8, 0.0),
        start(1.0, 0.56, 0.0),
        start(1.0, 0.9, 0.0),
    ];
    for stop in [StopModel::Rigid, StopModel::Soft] {
        check_agrees(&starts, &options(stop, 60), 1e-11);
    }
}

#[test]
fn verif_a_hundred_periods_agree_with_the_stroboscope() {
    let starts = [start(5.0, 0.1, 0.0)];
    for stop in [StopModel::Rigid, StopModel::Soft] {
        check_agrees(&starts, &options(stop, 100), 1e-11);
    }
}

/// ω = 100 rad/s, A = 5, from (0.1, 0): quad precision after 100 periods.
#[test]
fn val_a_hundred_periods_agree_with_quad_precision() {
    for (stop, angle, velocity) in [
        (
            StopModel::Rigid,
            0.772_335_922_557_793_9,
            -5.197_465_460_241_254,
        ),
        (
            StopModel::Soft,
            0.432_963_811_810_359_6,
            22.263_608_767_409_526,
        ),
    ] {
        let one = follow(&[start(5.0, 0.1, 0.0)], &options(stop, 100)).remove(0);
        let last = one.sections.last().unwrap();
        assert!((last.angle_rad - angle).abs() <= 1e-11, "{last:?}");
        assert!((last.velocity_rad_s - velocity).abs() <= 1e-9, "{last:?}");
    }
}

/// A few periods from anywhere, before growth can hide anything; other phases and frequencies too.
#[test]
fn verif_starts_from_anywhere_agree_with_the_stroboscope() {
    for stop in [StopModel::Rigid, StopModel::Soft] {
        check_agrees(&spread(100), &options(stop, 3), 1e-12);
        for (frequency, phase, amplitude) in [(20.0, 1.0, 40.0), (300.0, -30.0, -2.0)] {
            let mut starts = spread(20);
            for start in &mut starts {
                start.amplitude_m_s2 *= amplitude / 5.0;
            }
            let other = StrobeBatchOptions {
                angular_frequency_rad_s: frequency,
                phase_rad: phase,
                ..options(stop, 3)
            };
            check_agrees(&starts, &other, 1e-10);
        }
    }
}

/// All that a lever's result holds, bit by bit.
fn bits(of: &Followed) -> Vec<u64> {
    let mut bits = vec![u64::from(of.periods), of.scalar_pieces];
    for section in &of.sections {
        bits.extend([
            section.angle_rad.to_bits(),
            section.velocity_rad_s.to_bits(),
            section.peak_angle_rad.to_bits(),
            section.impacts,
            u64::from(section.rested),
        ]);
    }
    bits
}

/// Each lever alone in its lane, among others, in another order, on three threads: the same bits.
#[test]
fn verif_threads_and_neighbours_change_no_bit() {
    for stop in [StopModel::Rigid, StopModel::Soft] {
        let starts = spread(60);
        let one = follow(&starts, &options(stop, 12));
        let want: Vec<_> = one.iter().map(bits).collect();
        let three = StrobeBatchOptions {
            threads: 3,
            ..options(stop, 12)
        };
        let threaded: Vec<_> = follow(&starts, &three).iter().map(bits).collect();
        assert!(want == threaded, "threads");
        let reversed: Vec<HarmonicStart> = starts.iter().rev().copied().collect();
        let mut back: Vec<_> = follow(&reversed, &three).iter().map(bits).collect();
        back.reverse();
        assert!(want == back, "order");
        for (start, want) in starts.iter().zip(&want) {
            let alone = follow(&[*start], &options(stop, 12)).remove(0);
            assert!(*want == bits(&alone), "{start:?} alone");
        }
    }
}

/// Plain flight is taken side by side, and rest costs no piece.
#[test]
fn verif_few_pieces_need_the_scalar_kernel() {
    let pieces = |starts: &[HarmonicStart], stop: StopModel| {
        let options = StrobeBatchOptions {
            peaks: false,
            ..options(stop, 10)
        };
        let all = follow(starts, &options);
        assert!(all.iter().all(|one| {
            one.sections
                .iter()
                .all(|section| section.peak_angle_rad.is_nan())
        }));
        all.iter().map(|one| one.scalar_pieces).sum::<u64>() as f64 / (10 * starts.len()) as f64
    };
    let grid: Vec<HarmonicStart> = spread(64)
        .into_iter()
        .filter(|start| start.initial.is_some())
        .collect();
    for stop in [StopModel::Rigid, StopModel::Soft] {
        // Of 48 to a period.
        let flying = pieces(&grid, stop);
        assert!(flying < 8.0, "{stop:?}: {flying}");
        let mut resting = start(1.0, 0.0, 0.0);
        resting.initial = None;
        assert!(pieces(&[resting], stop) <= 0.0, "{stop:?}");
    }
}

/// Lanes take the next lever as soon as one is done; each is asked of its own periods.
#[test]
fn verif_each_lever_ends_when_it_is_done() {
    let starts = spread(100);
    let until = |index: usize| 1 + (index * 7 % 12) as u32;
    let mut options = options(StopModel::Rigid, 9);
    options.keep = 2;
    options.threads = 2;
    let seen = AtomicUsize::new(0);
    let all = strobe_batch::follow(
        &Design::reference(),
        starts.len(),
        &|index| starts[index],
        &options,
        &|index, period, _: &Section| period >= until(index),
        Some(&|ended| {
            seen.fetch_max(ended, Ordering::Relaxed);
            true
        }),
    )
    .unwrap();
    assert_eq!(seen.into_inner(), starts.len());
    assert_eq!(all.len(), starts.len());
    for (index, one) in all.iter().enumerate() {
        let (periods, ending) = if until(index) <= 9 {
            (until(index), Ending::Done)
        } else {
            (9, Ending::Periods)
        };
        assert_eq!(
            (one.index, one.periods, one.ending),
            (index, periods, ending)
        );
        let want = strobe(&starts[index], &options);
        let first = periods.saturating_sub(2) as usize;
        assert_eq!(one.sections.len(), periods as usize - first);
        for (got, want) in one.sections.iter().zip(&want[first..]) {
            assert!((got.angle_rad - want.angle_rad).abs() <= 1e-9, "{index}");
        }
    }
}

/// A watcher that says no gets what is done.
#[test]
fn verif_a_watcher_stops_the_fan() {
    let starts = spread(200);
    let all = strobe_batch::follow(
        &Design::reference(),
        starts.len(),
        &|index| starts[index],
        &options(StopModel::Rigid, 2),
        &|_, _, _: &Section| false,
        Some(&|ended| ended < 50),
    )
    .unwrap();
    assert!((50..100).contains(&all.len()), "{}", all.len());
    assert!(all.iter().all(|one| one.periods == 2));
    assert!(all.is_sorted_by_key(|one| one.index));
}

#[test]
fn verif_a_fan_refuses_what_it_cannot_do() {
    let refused = |start: HarmonicStart, options: StrobeBatchOptions, count: usize| {
        strobe_batch::follow(
            &Design::reference(),
            count,
            &|_| start,
            &options,
            &|_, _, _: &Section| true,
            None,
        )
        .is_err()
    };
    let (good, plain) = (start(1.0, 0.1, 0.0), options(StopModel::Rigid, 10));
    assert!(!refused(good, plain, 3));
    assert!(!refused(good, plain, 0));
    assert!(refused(start(1.0, -0.1, 0.0), plain, 1));
    assert!(refused(start(f64::NAN, 0.1, 0.0), plain, 1));
    assert!(refused(start(1.0, 0.1, f64::INFINITY), plain, 1));
    for angular_frequency_rad_s in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let options = StrobeBatchOptions {
            angular_frequency_rad_s,
            ..plain
        };
        assert!(refused(good, options, 1));
    }
    let endless = StrobeBatchOptions {
        periods_max: u32::MAX,
        keep: usize::MAX,
        ..plain
    };
    assert!(refused(good, endless, 1));
}
