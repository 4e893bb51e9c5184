//! Where other methods fail: grazing, chatter that meets a release, spikes shorter than any
//! step, a torque that hovers at zero, stiff contacts, extreme levers. Values in quadruple
//! precision come from `tests/data/reference`.

use crate::oracle;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::{Breakdown, RunOptions, RunOutcome, State, TracePoint};
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY};
use latchgate_test_support::{Random, data, json, number, options, replay, signal};
use serde_json::Value;

const RIGID: StopModel = StopModel::Rigid;
const SOFT: StopModel = StopModel::Soft;

fn samples(name: &str) -> Vec<f64> {
    std::fs::read_to_string(data(&format!("reference/{name}")))
        .unwrap()
        .lines()
        .filter_map(|line| line.split(',').nth(1)?.trim().parse().ok())
        .collect()
}

#[track_caller]
fn check_close(what: &str, got: f64, want: f64, tolerance: f64) {
    assert!(
        (got - want).abs() <= tolerance,
        "{what}: got {got:e}, want {want:e}, off by {:e}",
        got - want
    );
}

/// Releases and contact exits: (time, velocity) at φ = 0 on the way out, no impact before.
fn exits(trace: &[TracePoint]) -> Vec<(f64, f64)> {
    let mut found = vec![];
    let mut inside = true;
    for pair in trace.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        if to.angle_rad > 0.0 && inside {
            found.push((from.time_s, from.velocity_rad_s));
        }
        inside = to.angle_rad <= 0.0 && (to.velocity_rad_s <= 0.0 || to.angle_rad < 0.0 || inside);
    }
    found
}

/// Every event listed for a case of `failure_cases.json`: kind 0 impact, 1 rest, 2 release,
/// 3 contact entry, 4 contact exit.
#[track_caller]
fn check_case(label: &str, case: &Value, outcome: &RunOutcome, stop: StopModel) {
    let run = &outcome.run;
    let close = |what: &str, got: f64, key: &Value, absolute: f64| {
        let want = number(key);
        check_close(
            &format!("{label}: {what}"),
            got,
            want,
            absolute + 1e-11 * want.abs(),
        );
    };
    close("peak", run.peak_angle_rad, &case["peak"], 1e-15);
    close("peak time", run.peak_time_s, &case["t_peak"], 1e-9);
    let mut hits = run.impact_list.iter();
    let exits = if stop == SOFT {
        exits(&outcome.trace)
    } else {
        vec![]
    };
    let mut exits = exits.iter();
    for event in case["events"].as_array().unwrap() {
        match event[0].as_u64().unwrap() {
            0 | 3 => {
                if number(&event[2]).abs() <= 1e-3 {
                    continue;
                }
                let hit = hits.next().unwrap();
                close("impact time", hit[0], &event[1], 1e-15);
                close("impact velocity", hit[1], &event[2], 1e-14);
            }
            2 => close("release", run.first_release_s.unwrap(), &event[1], 1e-18),
            4 => {
                let exit = exits.next().unwrap();
                close("exit time", exit.0, &event[1], 1e-15);
                close("exit velocity", exit.1, &event[2], 1e-13);
            }
            _ => {}
        }
    }
    let end = &case["final"];
    close("final angle", run.final_angle_rad, &end["u"], 1e-13);
    close("final velocity", run.final_velocity_rad_s, &end["v"], 1e-11);
}

/// Spikes shorter than the motion, coarse samples with several impacts in each, a torque a
/// hair above and below zero: every listed event, both stops.
#[test]
fn val_failure_cases_agree_with_quad_precision() {
    let cases = json("reference/failure_cases.json");
    for name in [
        "F4_spike_1kHz",
        "F4b_spike_20kHz",
        "F6_coarse_500Hz",
        "F6b_coarse_sine90Hz_500Hz",
        "F7_just_below",
        "F7_just_above",
    ] {
        let case = &cases[name];
        let mut samples = samples(case["file"].as_str().unwrap());
        let rate = number(&case["fs"]);
        // The reference ran on after the record, under a = 0 from its last sample.
        let last = (number(&case["tend"]) * rate).round() as usize;
        samples.resize(last + 1, 0.0);
        let record = signal(rate, samples);
        for stop in [RIGID, SOFT] {
            let outcome = replay(&record, &Design::reference(), &options(stop));
            check_case(
                &format!("{name} {}", stop.name()),
                &case[stop.name()],
                &outcome,
                stop,
            );
        }
    }
}

/// Free vibration: every impact listed in `free.json`, both stops, with and without preload.
#[test]
fn val_free_vibrations_agree_with_quad_precision() {
    let cases = json("reference/free.json");
    for stop in [RIGID, SOFT] {
        for preload in ["0", "0.1"] {
            let label = format!("free_{}_T0={preload}", stop.name());
            let case = &cases["cases"][label.as_str()];
            let mut design = Design::reference();
            design.lever.preload_torque_nm = preload.parse().unwrap();
            let record = signal(10_000.0, vec![0.0; 25_001]);
            let start = RunOptions {
                initial: Some(State::new(0.5, 0.0)),
                ..options(stop)
            };
            let outcome = replay(&record, &design, &start);
            let listed: Vec<_> = case["events"]
                .as_array()
                .unwrap()
                .iter()
                .filter(|e| matches!(e[0].as_str().unwrap(), "impact" | "contact_in"))
                .filter(|e| number(&e[2]).abs() > 1e-3)
                .collect();
            assert_eq!(outcome.run.impacts, listed.len() as u64, "{label}");
            for (hit, event) in outcome.run.impact_list.iter().zip(listed) {
                check_close(&label, hit[0], number(&event[1]), 1e-12);
                check_close(&label, hit[1], number(&event[2]), 2e-12);
            }
            let end = &case["final"];
            check_close(
                &label,
                outcome.run.final_angle_rad,
                number(&end["u"]),
                1e-12,
            );
            check_close(
                &label,
                outcome.run.final_velocity_rad_s,
                number(&end["v"]),
                1e-10,
            );
        }
    }
}

/// The scale at which a shock's peak reaches exactly 0.1 rad: the answer flips there, and
/// nowhere else within a part in 10⁹.
#[test]
fn val_critical_scales_agree_with_quad_precision() {
    let cases = json("reference/failure_cases.json");
    for (name, case) in cases["F10_critical_scale"].as_object().unwrap() {
        let (file, stop) = name.rsplit_once('_').unwrap();
        let stop = if stop == "rigid" { RIGID } else { SOFT };
        let samples = samples(&format!("signals/{file}.csv"));
        for (scale, exceeded) in [
            (number(&case["scale_lo"]) * (1.0 - 1e-12), false),
            (number(&case["scale_hi"]) * (1.0 + 1e-12), true),
        ] {
            let scaled = samples.iter().map(|a| scale * a).collect();
            let run = replay(
                &signal(10_000.0, scaled),
                &Design::reference(),
                &options(stop),
            )
            .run;
            assert_eq!(run.first_crossing_s.is_some(), exceeded, "{name} {scale}");
            assert_eq!(run.peak_angle_rad > 0.1, exceeded, "{name} {scale}");
            check_close(name, run.peak_time_s, number(&case["t_peak"]), 1e-9);
        }
    }
}

/// The library against the independent integrator: peak within the stated error, instants
/// and final state with it.
#[track_caller]
fn check_truth(
    label: &str,
    record: &Signal,
    design: &Design,
    stop: StopModel,
    initial: Option<State>,
) {
    let options = RunOptions {
        initial,
        ..RunOptions::new(stop, OpensWhen::Negative)
    };
    let outcome = replay(record, design, &options);
    let run = outcome.run;
    assert!(!outcome.broke_down, "{label}");
    let truth = oracle::follow(record, 1.0, design, stop, initial);
    let error = (truth.peak - run.peak_angle_rad.into()).to_f64().abs();
    assert!(
        error <= run.numerical_error_rad + f64::EPSILON * run.peak_angle_rad.abs(),
        "{label}: peak {} off by {error:e}, stated {:e}",
        run.peak_angle_rad,
        run.numerical_error_rad
    );
    if run.numerical_error_rad > 1e-10 {
        return;
    }
    assert_eq!(run.impacts, truth.counted() as u64, "{label}");
    for (name, got, want) in [
        ("release", run.first_release_s, truth.first_release),
        ("crossing", run.first_crossing_s, truth.first_crossing),
    ] {
        assert_eq!(got.is_some(), want.is_some(), "{label}: {name}");
        check_close(
            &format!("{label}: {name}"),
            got.unwrap_or(0.0),
            want.unwrap_or(0.0),
            1e-10,
        );
    }
}

/// The independent integrator itself, against the closed form of the first impact and the
/// accumulation time of the bounces.
#[test]
fn val_the_independent_integrator_agrees_with_the_closed_form() {
    let design = Design::reference();
    let record = signal(250.0, vec![0.0; 40]);
    let truth = oracle::follow(&record, 1.0, &design, RIGID, Some(State::new(0.5, 0.0)));
    check_close("time", truth.impacts[0].0, 0.059_485_194_674_3, 1e-13);
    check_close("velocity", truth.impacts[0].1, -14.678_784_023, 1e-9);
    let (sine, cosine) = oracle::sine_cosine(0.7.into());
    let one = sine * sine + cosine * cosine - 1.0.into();
    assert!(one.to_f64().abs() < 1e-30);
    check_close("sine", sine.to_f64(), libm::sin(0.7), 1e-16);
}

/// Sampled −5 g sin(100 t + 1), from a start that touches the stop with no speed: impact,
/// none, or within rounding of either. The answer jumps by the square root of the distance.
#[test]
fn val_grazing_is_followed_or_its_doubt_stated() {
    let design = Design::reference();
    let record = signal(
        10_000.0,
        (0..121)
            .map(|k| -5.0 * 9.81 * libm::sin(100.0 * f64::from(k) / 10_000.0 + 1.0))
            .collect(),
    );
    // The start that grazes this sampled record, found by bisection on the independent
    // integrator: the slowest that does not touch.
    let angle = 0.004_973_986_935_791_459;
    let (mut touching, mut free) = (-1.95, -1.90);
    for _ in 0..60 {
        let middle = 0.5 * (touching + free);
        let start = Some(State::new(angle, middle));
        let truth = oracle::follow(&record, 1.0, &design, RIGID, start);
        if truth.impacts.is_empty() {
            free = middle;
        } else {
            touching = middle;
        }
    }
    for off in [
        0.0, 1e-15, -1e-15, 1e-12, -1e-12, 1e-9, -1e-9, 1e-6, -1e-6, 1e-3, -1e-3,
    ] {
        for stop in [RIGID, SOFT] {
            check_truth(
                &format!("graze {off:e} {}", stop.name()),
                &record,
                &design,
                stop,
                Some(State::new(angle, touching + off)),
            );
        }
    }
}

/// A chatter that ends just when the torque changes sign: rest and release, or no rest at
/// all. The motion that follows is the same to rounding.
#[test]
fn val_chatter_that_meets_a_release() {
    let design = Design::reference();
    let record = signal(
        10_000.0,
        (0..2601)
            .map(|k| 2.0 * 9.81 * libm::sin(20.0 * f64::from(k) / 10_000.0))
            .collect(),
    );
    let follow = |angle: f64| {
        let start = RunOptions {
            initial: Some(State::new(angle, 0.0)),
            ..options(RIGID)
        };
        let outcome = replay(&record, &design, &start);
        let rests = outcome
            .trace
            .iter()
            .filter(|p| p.time_s > 0.1 && p.time_s < 0.2)
            .any(|p| p.angle_rad == 0.0 && p.velocity_rad_s == 0.0);
        (rests, outcome.run)
    };
    let (mut rests, mut bounces) = (0.0503, 0.0505);
    for _ in 0..60 {
        let middle = 0.5 * (rests + bounces);
        if follow(middle).0 {
            rests = middle;
        } else {
            bounces = middle;
        }
    }
    assert!(follow(rests).0 && !follow(bounces).0);
    assert!((rests - 0.050_373_29).abs() < 1e-6, "{rests}");
    let (one, other) = (follow(rests).1, follow(bounces).1);
    check_close(
        "state after",
        other.final_angle_rad,
        one.final_angle_rad,
        1e-12,
    );
    for angle in [0.0503, rests, bounces, bounces + 1e-12, bounces + 1e-9] {
        let start = Some(State::new(angle, 0.0));
        check_truth("chatter", &record, &design, RIGID, start);
    }
}

/// Work that a replay may cost: no hang, whatever the lever and the record.
#[track_caller]
fn check_ends(label: &str, record: &Signal, design: &Design, start: Option<State>) {
    for stop in [RIGID, SOFT] {
        let options = RunOptions {
            initial: start,
            ..RunOptions::new(stop, OpensWhen::Negative)
        };
        let outcome = replay(record, design, &options);
        let run = &outcome.run;
        let label = format!("{label} {} {start:?}", stop.name());
        let most = 20_300_000 + 16 * record.samples.len() as u64;
        assert!(run.work.steps <= most, "{label}: {:?}", run.work);
        for number in [
            run.peak_angle_rad,
            run.final_angle_rad,
            run.final_velocity_rad_s,
            run.numerical_error_rad,
            outcome.coast_error_rad,
            run.coast_peak_angle_rad.unwrap_or(0.0),
        ] {
            assert!(number.is_finite(), "{label}: {number}");
        }
        if !outcome.broke_down {
            assert_eq!(
                run.first_crossing_s.is_some(),
                run.peak_angle_rad > design.criterion.threshold_rad,
                "{label}"
            );
        }
    }
}

fn extreme_designs() -> Vec<(&'static str, Design)> {
    let with = |change: fn(&mut Design)| {
        let mut design = Design::reference();
        change(&mut design);
        design
    };
    vec![
        ("reference", Design::reference()),
        ("R = 0", with(|d| d.stop.restitution = 0.0)),
        ("R = 1", with(|d| d.stop.restitution = 1.0)),
        ("R = 0.999999", with(|d| d.stop.restitution = 0.999_999)),
        ("T0 = 0", with(|d| d.lever.preload_torque_nm = 0.0)),
        (
            "k0 = 0",
            with(|d| d.lever.spring_stiffness_nm_per_rad = 0.0),
        ),
        ("c0 = 0", with(|d| d.lever.pivot_damping_nm_s_per_rad = 0.0)),
        (
            "c0 = 10",
            with(|d| d.lever.pivot_damping_nm_s_per_rad = 10.0),
        ),
        ("ks 1e13", with(|d| d.stop.stiffness_n_per_m = 1e13)),
        ("ks 1e-3", with(|d| d.stop.stiffness_n_per_m = 1e-3)),
        ("cs 0", with(|d| d.stop.damping_n_s_per_m = 0.0)),
        ("cs 1e5", with(|d| d.stop.damping_n_s_per_m = 1e5)),
        ("cs 1e9", with(|d| d.stop.damping_n_s_per_m = 1e9)),
        (
            "tiny",
            with(|d| {
                d.lever.moment_of_inertia_kg_m2 = 1e-12;
                d.lever.mass_kg = 1e-9;
                d.lever.center_of_mass_m = 1e-2;
            }),
        ),
        (
            "everything perfect",
            with(|d| {
                d.stop.restitution = 1.0;
                d.lever.pivot_damping_nm_s_per_rad = 0.0;
                d.stop.damping_n_s_per_m = 0.0;
            }),
        ),
        (
            "nothing but a spring",
            with(|d| {
                d.lever.preload_torque_nm = 0.0;
                d.lever.pivot_damping_nm_s_per_rad = 0.0;
                d.stop.restitution = 1.0;
            }),
        ),
    ]
}

#[test]
fn verif_extreme_levers_and_records_end() {
    let mut random = Random(7);
    for (name, design) in extreme_designs() {
        let lift_off = design.lever.lift_off_acceleration_m_s2();
        let records = [
            ("two zeros", signal(10_000.0, vec![0.0; 2])),
            ("two samples", signal(250.0, vec![-1e6, 1e6])),
            ("steps", signal(250.0, [[-1e6, 1e6]; 4].concat())),
            ("fast", signal(1e6, [[-1e6, 1e6]; 8].concat())),
            ("holding", signal(1000.0, vec![1e4; 40])),
            ("opening", signal(1000.0, vec![-50.0; 100])),
            ("critical", signal(1000.0, vec![-lift_off; 40])),
            (
                "noise",
                signal(
                    10_000.0,
                    (0..200).map(|_| random.between(-3000.0, 3000.0)).collect(),
                ),
            ),
        ];
        for (kind, record) in &records {
            let starts = [
                None,
                Some(State::new(0.0, 0.0)),
                Some(State::new(0.0, -1.0)),
                Some(State::new(0.0, 1e-10)),
            ];
            let starts = if *kind == "two zeros" {
                &starts[..]
            } else {
                &starts[..1]
            };
            for start in starts.iter().copied() {
                check_ends(&format!("{name}, {kind}"), record, &design, start);
            }
        }
    }
}

/// Levers of everyday size and stiff stops must not only end but be right.
#[test]
fn val_extreme_levers_agree_with_the_independent_integrator() {
    let record = signal(
        1000.0,
        vec![
            0.0, -40.0, -700.0, -300.0, 100.0, 20.0, 0.0, -10.0, 0.0, 0.0, 5.0, 0.0,
        ],
    );
    for (name, design) in extreme_designs() {
        for stop in [RIGID, SOFT] {
            // What only a rigid stop would be modelled by, or the slow reference cannot follow.
            if stop == SOFT && ["ks 1e13", "cs 1e9", "cs 1e5"].contains(&name) || name == "tiny" {
                continue;
            }
            check_truth(name, &record, &design, stop, None);
        }
    }
}

/// Numbers that overflow break the run down; they do not pass for an answer.
#[test]
fn verif_overflow_is_a_breakdown() {
    for peak in [1e150, 1e300] {
        let record = signal(1000.0, vec![0.0, -peak, peak, 0.0]);
        for stop in [RIGID, SOFT] {
            let outcome = replay(&record, &Design::reference(), &options(stop));
            assert!(outcome.broke_down, "{peak:e}");
            assert!(outcome.run.peak_angle_rad.is_finite());
        }
    }
}

/// A bounce that never ends on a perfect stop: too much work is a breakdown, not a hang.
#[test]
fn verif_endless_bounces_are_given_up() {
    let mut design = Design::reference();
    design.stop.restitution = 1.0;
    design.lever.pivot_damping_nm_s_per_rad = 0.0;
    let record = signal(10_000.0, vec![0.0; 200]);
    for speed in [1e-10, 1e-14] {
        let start = RunOptions {
            initial: Some(State::new(0.0, speed)),
            ..RunOptions::new(RIGID, OpensWhen::Negative)
        };
        let outcome = replay(&record, &design, &start);
        assert!(outcome.broke_down, "{speed:e}");
        assert_eq!(outcome.breakdown, Some(Breakdown::TooManyEvents));
        assert!(outcome.run.work.steps < 1_000_000);
    }
}

/// A long quiet record costs a rigid lever nothing and a soft one a step per sample.
#[test]
fn verif_quiet_records_cost_little() {
    let record = signal(10_000.0, vec![0.0; 1_000_000]);
    let design = Design::reference();
    let rigid = replay(
        &record,
        &design,
        &RunOptions::new(RIGID, OpensWhen::Negative),
    )
    .run;
    assert_eq!((rigid.work.steps, rigid.peak_angle_rad), (0, 0.0));
    let soft = replay(
        &record,
        &design,
        &RunOptions::new(SOFT, OpensWhen::Negative),
    )
    .run;
    assert!(soft.work.steps <= 1_000_000);
    assert!(soft.work.rhs <= 24_000_000);
    check_close(
        "angle",
        soft.final_angle_rad,
        -9.999_963_000_136_899e-7,
        1e-20,
    );
    assert!(soft.numerical_error_rad < 1e-15);
}

/// Weak signals far below lift-off leave a rigid lever where it is, however long.
#[test]
fn verif_a_lever_below_lift_off_stays() {
    let design = Design::reference();
    let mut random = Random(3);
    let limit = 0.99 * 1.063 * STANDARD_GRAVITY;
    let record = signal(
        10_000.0,
        (0..100_000).map(|_| random.between(-limit, 20.0)).collect(),
    );
    let run = replay(&record, &design, &options(RIGID)).run;
    assert_eq!((run.peak_angle_rad, run.work.steps), (0.0, 0));
    assert_eq!(run.first_release_s, None);
    assert!(!run.moving_at_end);
}
