//! Guards that work is bounded: what is dear ends at its limit, counted in steps, and a long run
//! looks up from its work.

use crate::support::{one, unconditioned};
use latchgate_kernel::error::Error as KernelError;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::replay::{self, Method, RunOptions, Within};
use latchgate_kernel::units::{OpensWhen, SampleRate};
use latchgate_recording::{Finding, ReadOptions};
use latchgate_verdict::conditioning::{self, Conditioned, ConditioningOptions, Signal};
use latchgate_verdict::{
    Answer, AssessDetail, AssessExtras, Assessment, ModelChoice, Polarity, Policy, assess,
};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A vibration of ten sines up to 40 % of the Nyquist frequency, about ±10 g, over `seconds`.
fn vibration(rate_hz: f64, seconds: f64) -> Signal {
    let at = |time: f64| {
        let sines = (1..=10).map(|n| {
            let frequency = 0.02 * f64::from(n) * rate_hz;
            (std::f64::consts::TAU * frequency * time + f64::from(n * n)).sin()
        });
        22.0 * sines.sum::<f64>()
    };
    Signal {
        start_s: 0.0,
        rate: SampleRate::from_hertz(rate_hz).unwrap(),
        samples: (0..(rate_hz * seconds) as usize)
            .map(|index| at(index as f64 / rate_hz))
            .collect(),
    }
}

fn judged(signal: &Signal, design: &Design, members: u32, work: u64) -> Assessment {
    let extras = AssessExtras {
        filter_table: true,
        ..AssessExtras::default()
    };
    judged_with(extras, signal, design, (members, work))
}

fn judged_with(
    extras: AssessExtras,
    signal: &Signal,
    design: &Design,
    (members, work): (u32, u64),
) -> Assessment {
    let conditioned = unconditioned(signal);
    let policy = Policy {
        members,
        work,
        ..Policy::new(ModelChoice::Auto, Polarity::Declared(OpensWhen::Negative))
    };
    let control = Control::unwatched(2);
    assess(&conditioned, &[], design, &policy, extras, &control).unwrap()
}

/// A limit on work leaves an answer undecided; it makes none of its own, not even where the draws of a noise are
/// what is left out.
#[test]
fn verif_a_limit_on_work_decides_nothing() {
    let (mut left_open, mut boundless) = (0, 0);
    for step in 0..40 {
        let mut signal = vibration(2000.0, 0.1);
        for sample in &mut signal.samples {
            *sample *= libm::pow(1.03, f64::from(step));
        }
        let design = Design::reference();
        let whole = judged_with(AssessExtras::default(), &signal, &design, (0, 100_000_000));
        for limit in 1..=40 {
            let limited = judged_with(AssessExtras::default(), &signal, &design, (0, 500 * limit));
            let open = limited.answer == Answer::Undecided;
            assert!(
                open || limited.answer == whole.answer,
                "{step}, {limit}: {:?} of {:?}",
                limited.answer,
                whole.answer
            );
            left_open += usize::from(open && whole.answer != Answer::Undecided);
            let noise_rad = limited.budget.noise.unwrap_or(0.0);
            boundless += usize::from(noise_rad > 1e300);
        }
    }
    println!("{left_open} left open, {boundless} noises boundless");
    assert!(left_open > 0 && boundless > 0, "{left_open}, {boundless}");
}

/// A recording of `signals/`, conditioned, with what was found on the way.
fn signal_as_used(name: &str) -> (Conditioned, Vec<Finding>) {
    let path = crate::support::root().join(format!("signals/{name}.csv"));
    let (channel, findings) = one(&path, &ReadOptions::default());
    let options = ConditioningOptions {
        synthetic: true,
        ..ConditioningOptions::default()
    };
    let conditioned = conditioning::condition(&channel, &options).unwrap();
    (conditioned, findings)
}

/// An ensemble that the limit on work leaves out is not one of which no lever crosses, nor one of which all do:
/// whatever the nominal levers say, the answer stays open until the ensembles of all stops have decided.
#[test]
fn verif_an_ensemble_that_the_limit_on_work_leaves_out_decides_nothing() {
    const PARTS: u64 = 16;
    for (name, expected) in [("surviving", Answer::Pass), ("burst", Answer::Fail)] {
        let (conditioned, findings) = signal_as_used(name);
        for model in [
            ModelChoice::Auto,
            ModelChoice::Only(StopModel::Rigid),
            ModelChoice::Only(StopModel::Soft),
        ] {
            let judged = |members: u32, work: u64, detail: AssessDetail| {
                let policy = Policy {
                    members,
                    work,
                    ..Policy::new(model, Polarity::Declared(OpensWhen::Negative))
                };
                let extras = AssessExtras {
                    detail,
                    ..AssessExtras::default()
                };
                let control = Control::unwatched(2);
                let design = Design::reference();
                assess(&conditioned, &findings, &design, &policy, extras, &control).unwrap()
            };
            let whole = judged(10_000, 100_000_000, AssessDetail::Whole);
            assert_eq!(whole.answer, expected, "{name}, {model:?}");
            let mut left_open = 0;
            for part in 1..=PARTS {
                let limit = whole.work * part / PARTS;
                let limited = judged(10_000, limit, AssessDetail::Whole);
                let case = format!("{name}, {model:?}, {limit}: {:#?}", limited.why);
                if limited.answer == expected {
                    assert_eq!(limited.ensemble, whole.ensemble, "{case}");
                    assert_eq!(limited.ensembles, whole.ensembles, "{case}");
                } else {
                    assert_eq!(limited.answer, Answer::Undecided, "{case}");
                    let mut codes = limited.findings.iter().map(|finding| &*finding.code);
                    assert!(codes.any(|code| code == "work-limit"), "{case}");
                    let nominal = judged(0, limit, AssessDetail::Whole);
                    left_open += usize::from(nominal.answer == expected);
                }
                let short = judged(10_000, limit, AssessDetail::Decision);
                let is_settled = limited.answer == expected;
                assert!(is_settled || short.answer == Answer::Undecided, "{case}");
            }
            assert!(
                left_open > 0,
                "{name}, {model:?}: nominal levers alone never decide"
            );
        }
    }
}

/// A record of 30 s at 500 Hz takes no more steps of its nominal levers than a few tens a sample
/// and reading, and its ensemble ends at the limit.
#[test]
fn verif_long_vibration_stays_within_its_work() {
    let signal = vibration(500.0, 30.0);
    let found = judged(&signal, &Design::reference(), 0, 100_000_000);
    let each = found.work / signal.samples.len() as u64;
    assert!(each < 4_000, "{each} steps a sample");
    let limit = 3_000_000;
    let scattered = judged(&signal, &Design::reference(), 10_000, limit);
    assert!(scattered.work <= 3 * limit, "{}", scattered.work);
    assert_ne!(scattered.answer, Answer::Pass);
}

/// A recording of which no sample can be judged takes little, however long its lever would swing between two samples;
/// how little is no limit to raise.
#[test]
fn verif_a_recording_that_cannot_be_judged_takes_little() {
    let signal = Signal {
        rate: SampleRate::from_hertz(1e-4).unwrap(),
        ..vibration(500.0, 0.5)
    };
    let judged = |findings: &[Finding]| {
        let conditioned = unconditioned(&signal);
        let policy = Policy {
            members: 128,
            ..Policy::new(ModelChoice::Auto, Polarity::Undeclared)
        };
        let control = Control::unwatched(1);
        let extras = AssessExtras::default();
        let design = Design::reference();
        assess(&conditioned, findings, &design, &policy, extras, &control).unwrap()
    };
    let blocked = judged(&[Finding::blocking("low-rate", "below 250 Hz")]);
    assert_eq!(blocked.answer, Answer::Unusable);
    assert!(blocked.work <= 16_000_000, "{}", blocked.work);
    let mut codes = blocked.findings.iter().map(|finding| &*finding.code);
    assert!(codes.all(|code| code != "work-limit"));
    let open = judged(&[]);
    assert!(
        open.work > 3 * blocked.work,
        "{} {}",
        open.work,
        blocked.work
    );
}

/// A stop so damped that its motion takes millions of steps breaks off, and no member is tried
/// beside a nominal lever that could not be followed.
#[test]
fn verif_a_stop_that_glues_the_lever_ends_at_the_limit() {
    let mut design = Design::reference();
    design.stop.damping_n_s_per_m = 1e6;
    let limit = 400_000;
    let found = judged(&vibration(10_000.0, 0.3), &design, 10_000, limit);
    assert!(found.work <= 3 * limit, "{}", found.work);
    assert_ne!(found.answer, Answer::Pass);
}

/// A stop in which a sample holds more steps than it may is given up at once: its nominal levers take no more
/// than those of one that can be followed, and it is no pass.
#[test]
fn verif_a_stop_beyond_all_steps_costs_no_more_than_a_soft_one() {
    let signal = vibration(10_000.0, 0.3);
    let [soft, hard] = [1e3, 1e12].map(|damping| {
        let mut design = Design::reference();
        design.stop.damping_n_s_per_m = damping;
        judged(&signal, &design, 0, 100_000_000)
    });
    assert!(hard.work <= soft.work, "{} and {}", hard.work, soft.work);
    assert_ne!(hard.answer, Answer::Pass);
}

/// Just below that a lever is followed as far as its steps reach; beyond it one that is glued breaks down and
/// says why, and one that lies on the face of its stop still leaves it.
#[test]
fn verif_a_stop_is_given_up_only_where_a_sample_holds_too_many_steps() {
    let (rate_hz, samples) = (10_000.0, vec![-200.0; 3]);
    let signal = Signal {
        start_s: 0.0,
        rate: SampleRate::from_hertz(rate_hz).unwrap(),
        samples,
    };
    let options = RunOptions::new(StopModel::Soft, OpensWhen::Negative);
    let run = |damping: f64, preload: f64| {
        let mut design = Design::reference();
        design.stop.damping_n_s_per_m = damping;
        design.lever.preload_torque_nm = preload;
        replay::run(&signal, &design, &options).unwrap()
    };
    assert!(!run(6e6, 0.1).broke_down);
    let glued = run(8e6, 0.1);
    assert!(glued.broke_down);
    assert_eq!(glued.breakdown, Some(replay::Breakdown::StopTooDamped));
    let free = run(1e12, 0.0);
    assert!(!free.broke_down && free.run.peak_angle_rad > 1e-6);
}

/// A single run asks whether to go on, by every method, and ends when it shall.
#[test]
fn verif_a_single_run_looks_up_from_its_work() {
    let signal = vibration(10_000.0, 4.0);
    let steps_per_period = 1_000_000;
    for method in [
        Method::Rk4 { steps_per_period },
        Method::Rk4Located { steps_per_period },
        Method::MoreauJean { steps_per_period },
        Method::EventDriven,
    ] {
        let options = RunOptions {
            method,
            ..RunOptions::new(StopModel::Rigid, OpensWhen::Negative)
        };
        let asked = AtomicUsize::new(0);
        let control = Control {
            threads: 1,
            proceed: &|_| asked.fetch_add(1, Ordering::Relaxed) < 1,
        };
        let within = Within {
            steps_max: u64::MAX,
            control: &control,
        };
        let ended = replay::run_within(&signal, &Design::reference(), &options, &within);
        if method == Method::EventDriven {
            // Short as it is, it is asked once, at its end.
            assert!(ended.is_ok());
            continue;
        }
        let error = ended.unwrap_err();
        assert_eq!(error, KernelError::Stopped, "{method:?}");
    }
}

/// What a run may take bounds it, and it says why it broke down.
#[test]
fn verif_a_run_that_takes_too_much_breaks_down() {
    let signal = vibration(10_000.0, 1.0);
    let control = Control::unwatched(1);
    let within = Within {
        steps_max: 500,
        control: &control,
    };
    for stop in [StopModel::Rigid, StopModel::Soft] {
        let options = RunOptions::new(stop, OpensWhen::Negative);
        let run = replay::run_within(&signal, &Design::reference(), &options, &within).unwrap();
        assert!(run.broke_down);
        assert_eq!(run.breakdown, Some(replay::Breakdown::TooManySteps));
        assert!(run.spent < 20_000, "{}", run.spent);
    }
}

/// The work of three typical verdicts is that of a table, so that a change that adds members or steps is seen.
/// `LATCHGATE_RENEW=1 cargo test -p latchgate-verdict work_of_three_typical_verdicts` renews the table.
#[test]
fn regress_work_of_three_typical_verdicts() {
    const FILE: &str = "tests/data/work.txt";
    let root = crate::support::root();
    let mut table = String::from("# signal, preload torque [N m]: answer, members, steps\n");
    for (signal, preload_torque_nm) in [("burst", 0.1), ("surviving", 0.1), ("sled_30g_30ms", 3.0)]
    {
        let (conditioned, findings) = signal_as_used(signal);
        let mut design = Design::reference();
        design.lever.preload_torque_nm = preload_torque_nm;
        let policy = Policy {
            members: 10_000,
            ..Policy::new(ModelChoice::Auto, Polarity::Declared(OpensWhen::Negative))
        };
        let extras = AssessExtras {
            filter_table: true,
            ..AssessExtras::default()
        };
        let control = Control::unwatched(2);
        let assessed = assess(&conditioned, &findings, &design, &policy, extras, &control).unwrap();
        let members: u32 = assessed.ensembles.iter().map(|e| e.members).sum();
        let (answer, steps) = (assessed.answer.name(), assessed.work);
        let row = format!("{signal}, {preload_torque_nm}: {answer}, {members}, {steps}\n");
        table.push_str(&row);
    }
    let path = root.join(FILE);
    if std::env::var_os("LATCHGATE_RENEW").is_some() {
        std::fs::write(&path, &table).unwrap();
    }
    let stored = std::fs::read_to_string(&path).unwrap();
    assert_eq!(
        table, stored,
        "the work of a verdict is not that of {FILE}. If it shall move, run `LATCHGATE_RENEW=1 cargo test -p latchgate-verdict \
         work_of_three_typical_verdicts` and look at the difference"
    );
}
