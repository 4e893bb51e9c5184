//! A tie: the errors do not say which of lever and catch comes first, and the lever's peak is unknown.
//!
//! Bodies here have no springs and no dampers, and turn by so little that the cosine of their angle takes
//! no part: under an acceleration −A (1 − t/τ) and a gain g, mass times arm over inertia, one goes
//! g A (t²/2 − t³/6τ), and a white noise q of the acceleration scatters that by g √(q t³/3).
//! What is sharp is held to 3 % on both sides.

use latchgate_kernel::model::Design;
use latchgate_kernel::model::catch::Catch;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::batch::{self, AskedPeaks, BatchOptions, Member, SensorView};
use latchgate_kernel::replay::{self, RunOptions, RunOutcome, State};
use latchgate_kernel::signal::{Projection, Signal};
use latchgate_kernel::units::{OpensWhen, SampleRate};

/// A [m/s²].
const PUSH_M_S2: f64 = 1.0;
/// τ [s].
const TURNS_S: f64 = 0.005;
/// Noise q of the acceleration [m²/s³].
const NOISE_M2_S3: f64 = 2e-10;
/// What the lever's preload takes from its angular acceleration [rad/s²].
const PRELOAD_RAD_S2: f64 = 2.0;
/// Gain of the catch [1/m].
const CATCH_GAIN: f64 = 48.0;
/// Angle at which the catch blocks the lever [rad].
const BLOCKED_RAD: f64 = 0.006;
/// Fine enough that little happens in a sample, and so coarse that everything happens in one [Hz].
const RATES_HZ: [f64; 2] = [400_000.0, 500.0];

/// −A (1 − t/τ) from 0 to `end_s`, of the sign that opens.
fn straight_line(rate_hz: f64, end_s: f64, opens_when: OpensWhen) -> Signal {
    let count = (end_s * rate_hz).round() as u32;
    let sign = opens_when.sign();
    let value = |index: u32| {
        let time = f64::from(index) / rate_hz;
        sign * -PUSH_M_S2 * (1.0 - time / TURNS_S)
    };
    Signal {
        start_s: 0.0,
        rate: SampleRate::from_hertz(rate_hz).unwrap(),
        samples: (0..=count).map(value).collect(),
    }
}

/// Angle of a body of gain 1 that starts at rest [rad], its velocity, and what the noise scatters it by.
fn angle_of_gain(time: f64) -> f64 {
    PUSH_M_S2 * (time * time / 2.0 - time.powi(3) / (6.0 * TURNS_S))
}

fn velocity_of_gain(time: f64) -> f64 {
    PUSH_M_S2 * (time - time * time / (2.0 * TURNS_S))
}

fn deviation_of_gain(time: f64) -> f64 {
    (NOISE_M2_S3 * time.powi(3) / 3.0).sqrt()
}

/// Returns where a function that changes its sign between two places does so.
fn root(from: f64, to: f64, function: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (from, to);
    let rises = function(high) > 0.0;
    assert!(rises != (function(low) > 0.0), "no root");
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if (function(middle) > 0.0) == rises {
            high = middle;
        } else {
            low = middle;
        }
    }
    0.5 * (low + high)
}

/// A catch of this engagement angle that falls back, and off which the lever does not rebound.
fn catch_at(engagement_angle_rad: f64) -> Catch {
    Catch {
        moment_of_inertia_kg_m2: 1e-6,
        unbalance_kg_m: 1e-6 * CATCH_GAIN,
        engagement_angle_rad,
        end_stop_angle_rad: 1.0,
        lever_angle_rad: BLOCKED_RAD,
        reversible: true,
        ..Catch::default()
    }
}

/// A lever of this gain beside a catch; of a gain of zero the acceleration does not move it.
fn design_of(lever_gain: f64, catch: Catch) -> Design {
    let mut design = Design::reference();
    let lever = &mut design.lever;
    lever.pivot_damping_nm_s_per_rad = 0.0;
    lever.spring_stiffness_nm_per_rad = 0.0;
    lever.preload_torque_nm = PRELOAD_RAD_S2 * lever.moment_of_inertia_kg_m2;
    // Zero itself would leave the sign of what opens open.
    lever.mass_kg = lever_gain.max(1e-30) * lever.moment_of_inertia_kg_m2 / lever.center_of_mass_m;
    design.catch = Some(catch);
    design
}

/// A run is a tie if, and only if, its peak is unknown.
#[track_caller]
fn check_tie(what: &str, outcome: &RunOutcome, is_tie: bool) {
    let tie_s = outcome.catch.unwrap().tie_s;
    assert_eq!(tie_s.is_some(), is_tie, "{what}: a tie at {tie_s:?}");
    let stated = outcome.run.numerical_error_rad;
    assert_eq!(stated == f64::MAX, is_tie, "{what}: stated {stated:e}");
    assert!(is_tie || stated < 1e-12, "{what}: stated {stated:e}");
}

/// Where and how a lever comes to a catch that goes up through its engagement angle and falls back.
struct Meeting {
    opens_when: OpensWhen,
    stop: StopModel,
    rate_hz: f64,
    lever_gain: f64,
    /// With which the lever rebounds off the catch.
    restitution: f64,
    /// The catch's engagement angle, as a part of where it turns.
    engages_at: f64,
    /// The catch falls back, else it rises.
    falls: bool,
    /// How far the catch is from its engagement angle, above it where positive, in doubts.
    doubts: f64,
}

#[track_caller]
fn check_meeting(meeting: &Meeting, is_tie: bool) {
    /// Angular velocity at which the lever starts [rad/s].
    const START_RAD_S: f64 = 0.3;
    let Meeting {
        opens_when,
        stop,
        rate_hz,
        lever_gain,
        restitution,
        engages_at,
        falls,
        doubts,
    } = *meeting;
    let top_s = 2.0 * TURNS_S;
    let engagement = engages_at * CATCH_GAIN * angle_of_gain(top_s);
    let lever_speed =
        |time: f64| START_RAD_S + lever_gain * velocity_of_gain(time) - PRELOAD_RAD_S2 * time;
    // Two deviations of the catch, and of the lever's as far as the catch goes in the same time.
    let doubt = |time: f64| {
        let catch_speed = CATCH_GAIN * velocity_of_gain(time);
        let scatter = CATCH_GAIN + lever_gain * (catch_speed / lever_speed(time)).abs();
        2.0 * scatter * deviation_of_gain(time)
    };
    let away = |time: f64| CATCH_GAIN * angle_of_gain(time) - engagement - doubts * doubt(time);
    let arrives = match falls {
        false => root(0.0, top_s, away),
        true => root(top_s, 3.0 * TURNS_S, away),
    };
    let pressed = 0.5 * PRELOAD_RAD_S2 * arrives * arrives;
    let start = BLOCKED_RAD + pressed - START_RAD_S * arrives - lever_gain * angle_of_gain(arrives);
    assert!(start > 0.0, "the lever starts off its stop");
    let options = RunOptions {
        initial: Some(State::new(start, START_RAD_S)),
        noise_m2_s3: Some(NOISE_M2_S3),
        ..RunOptions::new(stop, opens_when)
    };
    let signal = straight_line(rate_hz, 0.02, opens_when);
    let catch = Catch {
        engagement_restitution: restitution,
        ..catch_at(engagement)
    };
    let design = design_of(lever_gain, catch);
    let outcome = replay::run(&signal, &design, &options).unwrap();
    let what = format!(
        "{opens_when:?}, {stop:?}, {rate_hz} Hz, lever of {lever_gain}, restitution {restitution}, {}, {doubts} doubts",
        if falls { "falling" } else { "rising" }
    );
    let catch = outcome.catch.unwrap();
    let came = catch.lever_arrives_s.expect("the lever comes");
    let off = (came - arrives).abs() * lever_speed(arrives);
    assert!(off < 0.02 * doubt(arrives), "{what}: comes at {came}");
    assert_eq!(catch.stops > 0, doubts > 0.0, "{what}: {catch:?}");
    check_tie(&what, &outcome, is_tie);
}

/// The lever comes just before and just after the catch is there, and just before and after it has fallen back:
/// a tie within two deviations of both, and none beyond.
#[test]
fn verif_within_two_deviations_of_both_bodies_there_is_a_tie() {
    for opens_when in [OpensWhen::Negative, OpensWhen::Positive] {
        for stop in [StopModel::Rigid, StopModel::Soft] {
            for lever_gain in [0.0, 0.5 * CATCH_GAIN, CATCH_GAIN] {
                for (rate_hz, falls) in RATES_HZ
                    .iter()
                    .flat_map(|rate| [(*rate, false), (*rate, true)])
                {
                    for (doubts, is_tie) in
                        [(0.97, true), (-0.97, true), (1.03, false), (-1.03, false)]
                    {
                        let meeting = Meeting {
                            opens_when,
                            stop,
                            rate_hz,
                            lever_gain,
                            restitution: 0.0,
                            engages_at: 0.6,
                            falls,
                            doubts,
                        };
                        check_meeting(&meeting, is_tie);
                    }
                }
            }
        }
    }
}

/// The doubt is that before the impact, which scales the lever's error by its restitution, and that of the first
/// strike, though others follow in the same sample: pressed on, the lever is back within it off a soft face.
#[test]
fn regress_a_strike_is_as_uncertain_as_the_lever_was_before_it() {
    for opens_when in [OpensWhen::Negative, OpensWhen::Positive] {
        for rate_hz in RATES_HZ {
            for engages_at in [0.3, 0.6] {
                for restitution in [0.0, 0.004, 0.1, 0.5, 1.0] {
                    for (doubts, is_tie) in [(0.97, true), (1.03, false)] {
                        let meeting = Meeting {
                            opens_when,
                            stop: StopModel::Rigid,
                            rate_hz,
                            lever_gain: CATCH_GAIN,
                            restitution,
                            engages_at,
                            falls: false,
                            doubts,
                        };
                        check_meeting(&meeting, is_tie);
                    }
                }
            }
        }
    }
}

/// A catch that turns just below its engagement angle may as well have come there, within three deviations: a tie
/// if the lever comes, whenever that is.
#[test]
fn verif_a_catch_that_grazes_its_engagement_angle_is_a_tie_if_the_lever_comes() {
    let top_s = 2.0 * TURNS_S;
    let top_rad = CATCH_GAIN * angle_of_gain(top_s);
    let grazes = 3.0 * CATCH_GAIN * deviation_of_gain(top_s);
    for opens_when in [OpensWhen::Negative, OpensWhen::Positive] {
        for stop in [StopModel::Rigid, StopModel::Soft] {
            for (deviations, arrives, is_tie) in [
                (0.97, Some(2.4 * TURNS_S), true),
                (0.97, Some(2.9 * TURNS_S), true),
                (0.97, None, false),
                (1.03, Some(2.4 * TURNS_S), false),
                (1.03, Some(2.9 * TURNS_S), false),
            ] {
                // One that does not come is turned by its preload before.
                let speed = arrives.map_or(0.05, |time| {
                    0.5 * BLOCKED_RAD / time + 0.5 * PRELOAD_RAD_S2 * time
                });
                let options = RunOptions {
                    initial: Some(State::new(0.5 * BLOCKED_RAD, speed)),
                    noise_m2_s3: Some(NOISE_M2_S3),
                    window: Some((0, 6000)),
                    ..RunOptions::new(stop, opens_when)
                };
                let signal = straight_line(RATES_HZ[0], 0.015, opens_when);
                let catch = catch_at(top_rad + deviations * grazes);
                let design = design_of(0.0, catch);
                let outcome = replay::run(&signal, &design, &options).unwrap();
                let what =
                    format!("{opens_when:?}, {stop:?}, {deviations} deviations, {arrives:?}");
                assert_eq!(
                    outcome.catch.unwrap().lever_arrives_s.is_some(),
                    arrives.is_some(),
                    "{what}"
                );
                check_tie(&what, &outcome, is_tie);
            }
        }
    }
}

/// A lever and a catch of the same numbers, which move alike to the last bit.
fn twins(blocked_rad: f64, engagement_rad: f64) -> Design {
    let preload_torque_nm = 1e-6 * PRELOAD_RAD_S2;
    let mut design = design_of(
        CATCH_GAIN,
        Catch {
            preload_torque_nm,
            lever_angle_rad: blocked_rad,
            ..catch_at(engagement_rad)
        },
    );
    let lever = &mut design.lever;
    lever.moment_of_inertia_kg_m2 = 1e-6;
    lever.preload_torque_nm = preload_torque_nm;
    lever.mass_kg = 1e-6 * CATCH_GAIN;
    lever.center_of_mass_m = 1.0;
    design
}

/// At the same angle twins come together without any noise; a billionth apart they do not.
#[test]
fn verif_bodies_that_move_alike_come_together() {
    for opens_when in [OpensWhen::Negative, OpensWhen::Positive] {
        for rate_hz in RATES_HZ {
            for blocked in (1..=30).map(|step| 2e-5 * f64::from(step)) {
                for (apart, is_tie) in [(0.0, true), (1e-9, false), (-1e-9, false)] {
                    let design = twins(blocked, blocked * (1.0 + apart));
                    let options = RunOptions::new(StopModel::Rigid, opens_when);
                    let signal = straight_line(rate_hz, 0.012, opens_when);
                    let outcome = replay::run(&signal, &design, &options).unwrap();
                    let what = format!("{opens_when:?}, {rate_hz} Hz, {blocked} rad, {apart}");
                    check_tie(&what, &outcome, is_tie);
                }
            }
        }
    }
}

/// Members carry no error along: they tie where lever and catch come together to the last bit, as the same run
/// without a stated error does. Such a member has no peak.
#[test]
fn verif_a_member_with_a_tie_has_no_peak() {
    let (mut ties, mut others) = (0, 0);
    for rate_hz in RATES_HZ {
        for step in 1..=60 {
            let signal = straight_line(rate_hz, 0.012, OpensWhen::Negative);
            let blocked = 1e-5 * f64::from(step);
            // Every second pair is a billionth apart.
            let design = twins(blocked, blocked * (1.0 + 1e-9 * f64::from(step % 2)));
            let options = RunOptions {
                error_bound: false,
                ..RunOptions::new(StopModel::Rigid, OpensWhen::Negative)
            };
            let outcome = replay::run(&signal, &design, &options).unwrap();
            assert!(!outcome.broke_down);
            let is_tie = outcome.catch.unwrap().tie_s.is_some();
            let batch_options = BatchOptions {
                stop: options.stop,
                projection: Projection::ALIGNED,
                opens_when: options.opens_when,
                initial: None,
                window: None,
                coast: true,
                asked: AskedPeaks::ALL,
                threshold_rad: 0.1,
                threads: 1,
            };
            let member = |_: usize| Member {
                lever: design.lever,
                stop: design.stop,
                scale: 1.0,
                bias_m_s2: 0.0,
                second: SensorView::default(),
                catch: design.catch,
            };
            let member = batch::peaks(&signal, 1, &member, &batch_options).unwrap()[0];
            let what = format!("{rate_hz} Hz, {blocked} rad: {member:?}");
            assert_eq!(member.peak_angle_rad.is_nan(), is_tie, "{what}");
            assert_eq!(member.highest_rad().is_nan(), is_tie, "{what}");
            ties += u32::from(is_tie);
            others += u32::from(!is_tie);
        }
    }
    assert!(ties > 5 && others > 50, "{ties} ties, {others} others");
}

/// A lever that rests on the catch, which turns and falls back from under it while the lever is still pushed on.
mod slip {
    use super::*;

    /// Pushing, and still so when the catch falls [m/s²].
    const PUSH_M_S2: f64 = 100.0;
    const GAIN: f64 = 10.0;
    /// Part of the push that the catch's preload takes at first: it turns at 0.4 τ.
    const HELD_BACK: f64 = 0.8;
    const TOP_S: f64 = 0.4 * TURNS_S;

    /// Angle of the catch [rad], and its angular velocity.
    fn catch_angle(time: f64) -> f64 {
        CATCH_GAIN * PUSH_M_S2 * (0.1 * time * time - time.powi(3) / (6.0 * TURNS_S))
    }

    fn catch_velocity(time: f64) -> f64 {
        CATCH_GAIN * PUSH_M_S2 * (0.2 * time - time * time / (2.0 * TURNS_S))
    }

    /// Runs with a catch whose engagement angle it falls through at `falls_s`, `preload_parts` of its preload and
    /// `unbalance_parts` of its unbalance.
    pub(super) fn run(
        falls_s: f64,
        (preload_parts, unbalance_parts): (f64, f64),
        noise_m2_s3: Option<f64>,
        opens_when: OpensWhen,
        stop: StopModel,
    ) -> RunOutcome {
        const RATE_HZ: f64 = 100_000.0;
        const START_RAD_S: f64 = 3.0;
        // Just after the lever has turned: a coast in free fall is no part of this.
        let last = ((falls_s + flight_s(falls_s)) * RATE_HZ) as u32 + 10;
        let sign = opens_when.sign();
        let value = |index: u32| {
            let time = f64::from(index) / RATE_HZ;
            sign * -PUSH_M_S2 * (1.0 - time / TURNS_S)
        };
        let signal = Signal {
            start_s: 0.0,
            rate: SampleRate::from_hertz(RATE_HZ).unwrap(),
            samples: (0..=last).map(value).collect(),
        };
        let mut catch = catch_at(catch_angle(falls_s));
        catch.preload_torque_nm = HELD_BACK * PUSH_M_S2 * catch.unbalance_kg_m * preload_parts;
        catch.unbalance_kg_m *= unbalance_parts;
        let mut design = design_of(GAIN, catch);
        // The lever comes while the catch turns.
        let thrown = PUSH_M_S2 * GAIN * (TOP_S * TOP_S / 2.0 - TOP_S.powi(3) / (6.0 * TURNS_S));
        let pressed = 0.5 * PRELOAD_RAD_S2 * TOP_S * TOP_S;
        let start = State::new(0.008 + pressed - thrown - START_RAD_S * TOP_S, START_RAD_S);
        design.catch.as_mut().unwrap().lever_angle_rad = 0.008;
        let options = RunOptions {
            initial: Some(start),
            noise_m2_s3,
            ..RunOptions::new(stop, opens_when)
        };
        replay::run(&signal, &design, &options).unwrap()
    }

    /// How far a catch that is off by 1 rad moves the lever's peak [rad]: it is let go by 1/ψ' later, and the speed it
    /// then lacks it lacks until its peak, when all that pushed it has been taken back. Its preload is small
    /// against the push.
    pub(super) fn lever(falls_s: f64) -> f64 {
        let pushed = GAIN * PUSH_M_S2 * (1.0 - falls_s / TURNS_S);
        pushed * flight_s(falls_s) / catch_velocity(falls_s).abs()
    }

    fn flight_s(falls_s: f64) -> f64 {
        2.0 * (TURNS_S - falls_s)
    }

    /// Standard deviation of the peak [rad]: the catch's by that lever, and what the noise does after.
    pub(super) fn deviation(falls_s: f64, noise_m2_s3: f64) -> [f64; 2] {
        let of = |gain: f64, time: f64| gain * (noise_m2_s3 * time.powi(3) / 3.0).sqrt();
        [
            lever(falls_s) * of(CATCH_GAIN, falls_s),
            of(GAIN, flight_s(falls_s)),
        ]
    }
}

/// How uncertain the instant is at which the catch lets the lever go, so uncertain is the lever: by the closed form.
#[test]
fn verif_noise_of_a_catch_that_slips_is_handed_to_the_lever() {
    const NOISE: f64 = 1e-14;
    for opens_when in [OpensWhen::Negative, OpensWhen::Positive] {
        for stop in [StopModel::Rigid, StopModel::Soft] {
            for falls_s in [0.43, 0.46, 0.5].map(|part| part * TURNS_S) {
                let outcome = slip::run(falls_s, (1.0, 1.0), Some(NOISE), opens_when, stop);
                let what = format!("{opens_when:?}, {stop:?}, falls at {falls_s} s");
                let catch = outcome.catch.unwrap();
                assert!(
                    catch.stops > 0 && catch.lever_passes_s.is_some(),
                    "{what}: {catch:?}"
                );
                assert_eq!(catch.tie_s, None, "{what}");
                let [of_catch, of_lever] = slip::deviation(falls_s, NOISE);
                assert!(of_catch > 3.0 * of_lever, "{what}: the catch is to decide");
                let part = outcome.deviation_rad.unwrap() / of_catch.hypot(of_lever);
                assert!(
                    (0.97..=1.03).contains(&part),
                    "{what}: {part} of the closed form"
                );
            }
        }
    }
}

/// Two last digits of the catch's preload or unbalance, a rounding of the number and one of its quotient, move
/// the instant at which it lets the lever go: no peak is known better than to what that does to it.
#[test]
fn verif_error_of_a_catch_that_slips_is_handed_to_the_lever() {
    let digit = 2.0 * f64::EPSILON;
    for opens_when in [OpensWhen::Negative, OpensWhen::Positive] {
        for stop in [StopModel::Rigid, StopModel::Soft] {
            for falls_s in [0.4003, 0.401, 0.41].map(|part| part * TURNS_S) {
                let run = |parts| slip::run(falls_s, parts, None, opens_when, stop);
                let nominal = run((1.0, 1.0));
                let what = format!("{opens_when:?}, {stop:?}, falls at {falls_s} s");
                let catch = nominal.catch.unwrap();
                assert!(
                    catch.stops > 0 && catch.lever_passes_s.is_some(),
                    "{what}: {catch:?}"
                );
                let mut farthest = 0.0_f64;
                for parts in [
                    (1.0 + digit, 1.0),
                    (1.0 - digit, 1.0),
                    (1.0, 1.0 + digit),
                    (1.0, 1.0 - digit),
                ] {
                    let off = (run(parts).run.peak_angle_rad - nominal.run.peak_angle_rad).abs();
                    let stated = nominal.run.numerical_error_rad;
                    assert!(
                        off <= stated,
                        "{what}: {off:e} by a digit, stated {stated:e}"
                    );
                    farthest = farthest.max(off);
                }
                let last_digit = digit * nominal.run.peak_angle_rad;
                assert!(
                    farthest > 20.0 * last_digit,
                    "{what}: the catch is to decide, {farthest:e}"
                );
            }
        }
    }
}

/// A lever beyond the catch falls back slowly, and lets it go when it comes to where it blocks. The catch rises and
/// falls back; by then the lever has come to rest on its stop, and a blow throws it up to meet the catch. All that
/// is uncertain of that meeting is when the catch was let go.
mod release {
    use super::*;

    const RATE_HZ: f64 = 100_000.0;
    const LEVER_GAIN: f64 = 200.0;
    const CATCH_GAIN: f64 = 10.0;
    /// What holds the catch up and slows the lever's fall, and until when [m/s², s].
    const HOLDS: (f64, f64) = (20.0, 0.025);
    /// The preloads, as angular accelerations [rad/s²].
    const LEVER_PRELOAD: f64 = 4000.4;
    const CATCH_PRELOAD: f64 = 100.0;
    /// How far beyond the catch the lever starts [rad].
    const BEYOND_RAD: f64 = 5e-6;
    const ENGAGEMENT_RAD: f64 = 8e-4;
    /// The blow, a triangle: when it is highest, and half its length [s].
    const BLOW_S: (f64, f64) = (0.0736, 0.0002);
    /// Between these the lever meets the catch as it falls back [m/s²].
    pub(super) const BLOWS_M_S2: [f64; 2] = [215.0, 300.0];

    /// Runs with a blow of this height, and the lever's preload times a factor.
    pub(super) fn run(
        blow_m_s2: f64,
        preload_parts: f64,
        noise_m2_s3: Option<f64>,
        opens_when: OpensWhen,
    ) -> RunOutcome {
        let value = |index: u32| {
            let time = f64::from(index) / RATE_HZ;
            let (peak_s, half_s) = BLOW_S;
            let holds = if time < HOLDS.1 { HOLDS.0 } else { 0.0 };
            let blow = blow_m_s2 * (1.0 - (time - peak_s).abs() / half_s).max(0.0);
            -opens_when.sign() * (holds + blow)
        };
        let signal = Signal {
            start_s: 0.0,
            rate: SampleRate::from_hertz(RATE_HZ).unwrap(),
            samples: (0..=7700).map(value).collect(),
        };
        let mut catch = catch_at(ENGAGEMENT_RAD);
        catch.unbalance_kg_m = CATCH_GAIN * catch.moment_of_inertia_kg_m2;
        catch.preload_torque_nm = CATCH_PRELOAD * catch.moment_of_inertia_kg_m2;
        let mut design = design_of(LEVER_GAIN, catch);
        design.stop.restitution = 0.0;
        let lever = &mut design.lever;
        lever.preload_torque_nm = LEVER_PRELOAD * lever.moment_of_inertia_kg_m2 * preload_parts;
        let options = RunOptions {
            initial: Some(State::new(BLOCKED_RAD + BEYOND_RAD, 0.0)),
            noise_m2_s3,
            trace: true,
            ..RunOptions::new(StopModel::Rigid, opens_when)
        };
        replay::run(&signal, &design, &options).unwrap()
    }

    /// Returns how far above its engagement angle the catch is when the lever comes to it [rad], and how fast both are
    /// then [rad/s].
    pub(super) fn meeting(outcome: &RunOutcome) -> (f64, f64, f64) {
        let catch = outcome.catch.unwrap();
        let (time, speed) = (catch.lever_arrives_s, catch.lever_arrives_rad_s);
        let (time, speed) = (time.expect("the lever comes"), speed.unwrap());
        assert!(time > BLOW_S.0 + BLOW_S.1, "after the blow: {catch:?}");
        let after = outcome
            .catch_trace
            .partition_point(|point| point.time_s < time);
        let [from, to] = [&outcome.catch_trace[after - 1], &outcome.catch_trace[after]];
        let part = (time - from.time_s) / (to.time_s - from.time_s);
        let angle = from.angle_rad + part * (to.angle_rad - from.angle_rad);
        (angle - ENGAGEMENT_RAD, from.velocity_rad_s, speed)
    }

    /// Returns the deviation of the catch's angle at `time` from this noise [rad]: let go later by what the lever was
    /// off over its speed, it is slower by what pushed it meanwhile.
    pub(super) fn deviation(time: f64, noise_m2_s3: f64) -> f64 {
        let of = |gain: f64, time: f64| gain * (noise_m2_s3 * time.powi(3) / 3.0).sqrt();
        let falls = LEVER_PRELOAD - LEVER_GAIN * HOLDS.0 * BLOCKED_RAD.cos();
        let released_s = (2.0 * BEYOND_RAD / falls).sqrt();
        let pushed = CATCH_GAIN * HOLDS.0 - CATCH_PRELOAD;
        let delay = of(LEVER_GAIN, released_s) / (falls * released_s);
        let free_s = time - released_s;
        (pushed * delay * free_s).hypot(of(CATCH_GAIN, free_s))
    }
}

/// Two last digits of the lever's preload move the instant at which it lets the catch go, and that which of the two
/// comes first: where it decides, there is a tie.
#[test]
fn verif_error_of_a_lever_that_lets_a_catch_go_is_handed_to_the_catch() {
    let digit = 2.0 * f64::EPSILON;
    for opens_when in [OpensWhen::Negative, OpensWhen::Positive] {
        let run = |blow: f64, parts: f64| release::run(blow, parts, None, opens_when);
        let is_held = |outcome: &RunOutcome| outcome.catch.unwrap().lever_passes_s.is_none();
        let [passes, held] = release::BLOWS_M_S2;
        let decides = root(passes, held, |blow| {
            if is_held(&run(blow, 1.0)) { 1.0 } else { -1.0 }
        });
        for parts in [1.0 - digit, 1.0 + digit] {
            let what = format!("{opens_when:?}, preload times 1 + {:e}", parts - 1.0);
            check_tie(&what, &run(decides, parts), true);
        }
        let late = is_held(&run(decides, 1.0 - digit));
        let soon = is_held(&run(decides, 1.0 + digit));
        assert!(late != soon, "{opens_when:?}: the digits are to decide");
        for (parts, held) in [(1.0 - 1e-8, false), (1.0 + 1e-8, true)] {
            let outcome = run(decides * parts, 1.0);
            let what = format!("{opens_when:?}, the blow times 1 + {:e}", parts - 1.0);
            assert_eq!(is_held(&outcome), held, "{what}");
            check_tie(&what, &outcome, false);
        }
    }
}

/// As uncertain as the instant is at which the lever lets the catch go, so uncertain is the catch: by the closed form.
#[test]
fn regress_noise_of_a_lever_that_lets_a_catch_go_is_handed_to_the_catch() {
    const NOISE: f64 = 1e-14;
    for opens_when in [OpensWhen::Negative, OpensWhen::Positive] {
        for (doubts, is_tie) in [(0.95, true), (-0.95, true), (1.05, false), (-1.05, false)] {
            let [low, high] = release::BLOWS_M_S2;
            let blow = root(low, high, |blow| {
                let outcome = release::run(blow, 1.0, None, opens_when);
                let (away, ..) = release::meeting(&outcome);
                let time = outcome.catch.unwrap().lever_arrives_s.unwrap();
                // From rest, shortly before, the lever brings hardly any doubt along.
                away - doubts * 2.0 * release::deviation(time, NOISE)
            });
            let what = format!("{opens_when:?}, {doubts} doubts");
            let outcome = release::run(blow, 1.0, Some(NOISE), opens_when);
            check_tie(&what, &outcome, is_tie);
        }
    }
}
