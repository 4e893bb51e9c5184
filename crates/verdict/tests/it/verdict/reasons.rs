//! Guards the reasons of a verdict: the table of `docs/decision.md` lists each code that the sources
//! can give, and a test names each; here are the tests of codes that no other file covers.

use super::*;
use latchgate_kernel::model::catch::Catch;

/// A bounce that never ends: a perfect stop, no damping, and hardly any speed.
fn endless() -> (Design, Policy) {
    let mut design = Design::reference();
    design.stop.restitution = 1.0;
    design.lever.pivot_damping_nm_s_per_rad = 0.0;
    let own = Policy {
        initial_velocity_rad_s: Some(1e-10),
        ..options(RIGID, NEGATIVE)
    };
    (design, own)
}

#[test]
fn verif_a_lever_that_cannot_be_followed_is_undecided_and_said() {
    let (design, own) = endless();
    let quiet = samples(|_| 0.0);
    let lost = judge(&quiet, &[], &design, &own);
    check_answer(
        &lost,
        Answer::Undecided,
        &["method-broke-down", "nominal-runs-only"],
    );
    assert!(lost.why[0].text.contains("event-driven"), "{:?}", lost.why);
    assert!(
        lost.findings
            .iter()
            .any(|finding| finding.code == "method-broke-down")
    );
    // A pass of the others is none of the whole.
    let members = Policy {
        members: 16,
        ..own.clone()
    };
    let scattered = judge(&quiet, &[], &design, &members);
    assert_eq!(scattered.answer, Answer::Undecided);
    assert!(scattered.ensemble.unwrap().failed_to_run > 0);
}

/// A method that only estimates its error may have stepped over what opens the lever.
#[test]
fn verif_a_method_without_a_bound_decides_no_pass() {
    let own = |method| Policy {
        method,
        ..options(RIGID, NEGATIVE)
    };
    let at_samples = Method::Dopri5 { at_samples: true };
    let held = judge(&samples(weak), &[], &Design::reference(), &own(at_samples));
    check_answer(
        &held,
        Answer::Undecided,
        &[
            "method-without-bound",
            "threshold-not-crossed",
            "uncertainty",
            "nominal-runs-only",
        ],
    );
    let strong = samples(|t| half_sine(t, 0.0, 0.012, -14.0));
    let fails = judge(&strong, &[], &Design::reference(), &own(at_samples));
    assert_eq!(fails.answer, Answer::Fail);
}

/// Chatter that takes more than it may ends undecided, with the same count on any threads.
#[test]
fn verif_a_question_beyond_its_work_is_undecided_and_says_what_to_set() {
    let chatter = samples(|t| {
        if t > 0.0 {
            8.0 * (t * 700.0).sin()
        } else {
            0.0
        }
    });
    let mut design = with_threshold(0.002);
    design.lever.preload_torque_nm = 0.5;
    let own = |work| Policy {
        members: 10_000,
        work,
        ..options(ModelChoice::Auto, NEGATIVE)
    };
    let of = |work, threads| {
        let control = Control::unwatched(threads);
        let extras = AssessExtras {
            filter_table: true,
            ..AssessExtras::default()
        };
        let conditioned = as_recorded(chatter.clone());
        latchgate_verdict::assess(&conditioned, &[], &design, &own(work), extras, &control).unwrap()
    };
    for limit in [10_000, 100_000] {
        let found = of(limit, 1);
        assert_eq!(found.answer, Answer::Undecided, "{limit}");
        assert_eq!(found.why[0].code, "work-limit", "{:#?}", found.why);
        assert!(found.why[0].text.contains("`members`"), "{:#?}", found.why);
        assert!(
            found
                .findings
                .iter()
                .any(|finding| finding.code == "work-limit")
        );
        assert!(found.work <= 3 * limit, "{} of {limit}", found.work);
        assert_eq!(found, of(limit, 3));
    }
}

/// The soft stop can be followed and reaches further: the one that cannot is named all the same.
#[test]
fn verif_a_stop_beside_the_nominal_one_that_cannot_be_followed_is_said() {
    let (design, own) = endless();
    let own = Policy {
        model: ModelChoice::Auto,
        ..own
    };
    let found = judge(&samples(weak), &[], &design, &own);
    assert_eq!(found.nominal.model, StopModel::Soft);
    check_answer(
        &found,
        Answer::Undecided,
        &[
            "method-broke-down",
            "threshold-not-crossed",
            "uncertainty",
            "nominal-runs-only",
        ],
    );
    assert!(found.why[0].text.contains("rigid stop"), "{:?}", found.why);
}

// ---------------------------------------------------------------- the bias of nominal runs

/// A channel that reads `offset_g` too much, its bias taken from the samples before zero.
fn with_offset(offset_g: f64, of: impl Fn(f64) -> f64) -> Conditioned {
    let channel = Channel {
        name: "acc_y".into(),
        unit: Some(AccelerationUnit::MetrePerSecondSquared),
        unit_source: "option",
        stated: latchgate_recording::Stated::default(),
        start_s: -0.05,
        rate: SampleRate::from_hertz(10_000.0).unwrap(),
        values: samples(|t| of(t) + offset_g).samples,
        findings: Vec::new(),
        pulse: None,
    };
    let options = ConditioningOptions {
        filter: FilterChoice::None,
        synthetic: true,
        ..ConditioningOptions::default()
    };
    let conditioned = conditioning::condition(&channel, &options).unwrap();
    assert!((conditioned.bias_m_s2 / G - offset_g).abs() < 1e-9);
    conditioned
}

fn codes(assessment: &Assessment) -> Vec<&str> {
    assessment.why.iter().map(|reason| &*reason.code).collect()
}

/// With nominal runs alone the bias is asked about as well: where leaving it in, or one standard
/// deviation of it, takes the lever across the limit, the reasons say so; the answer stays that
/// of the rule.
#[test]
fn verif_nominal_runs_name_the_bias_that_decides() {
    let pulse = |t: f64| half_sine(t, 0.0, 0.01, -8.0);
    let own = options(RIGID, NEGATIVE);
    let mut design = Design::reference();
    design.input.bias_g = 0.0;
    let peak_of = |offset_g: f64| {
        let mut biased = samples(pulse);
        biased.samples.iter_mut().for_each(|a| *a += G * offset_g);
        explicit(&biased, StopModel::Rigid, OpensWhen::Negative)
            .run
            .peak_angle_rad
    };
    let (without, with) = (peak_of(0.0), peak_of(-0.3));
    assert!(with > 1.02 * without, "{without} {with}");
    let judged = |offset_g: f64, threshold: f64, bias_g: f64| {
        let mut own_design = with_threshold(threshold);
        own_design.input.bias_g = bias_g;
        assess(&with_offset(offset_g, pulse), &[], &own_design, &own).unwrap()
    };
    let between = f64::midpoint(without, with);
    // Left in the recording, the lever crosses.
    let removed = judged(-0.3, between, 0.0);
    assert_eq!(removed.answer, Answer::Pass);
    let bias = removed
        .why
        .iter()
        .find(|reason| reason.code == "bias-decides")
        .unwrap();
    assert!(
        bias.text.contains("left in the recording (-0.3"),
        "{}",
        bias.text
    );
    // One standard deviation, the design's where it is the larger.
    let close = judged(0.0, 1.001 * without, 0.1);
    assert_eq!(close.answer, Answer::Pass);
    assert!(codes(&close).contains(&"bias-decides"), "{:?}", close.why);
    let more = close
        .what_if
        .iter()
        .find(|what_if| what_if.change < 0.0)
        .unwrap();
    assert_eq!(more.input, "input.bias_g");
    let moved = peak_of(-0.1);
    assert!(
        (more.peak_angle_rad / moved - 1.0).abs() < 1e-9,
        "{more:?} {moved}"
    );
    // Far from the limit, or without any doubt of the bias, nothing is said.
    for far in [
        judged(-0.3, 4.0 * with, 0.1),
        judged(0.0, 1.001 * without, 0.0),
    ] {
        assert_eq!(far.answer, Answer::Pass);
        assert!(!codes(&far).contains(&"bias-decides"), "{:?}", far.why);
    }
    // A design whose tolerances an ensemble refuses is judged all the same.
    let mut wide = with_threshold(4.0 * with);
    wide.tolerance.insert("mass_kg".into(), 1.0.into());
    let judged = assess(&with_offset(0.0, pulse), &[], &wide, &own).unwrap();
    assert_eq!(judged.answer, Answer::Pass);
    assert_eq!(judged.what_if.len(), 2);
}

/// A catch with the lever's numbers moves as the lever does on any reading of the samples: at the same angle nothing
/// says which of the two comes first. A hundredth earlier it holds the lever, a hundredth later it does not.
#[test]
fn verif_a_tie_of_lever_and_catch_is_undecided_and_said() {
    const BLOCKED_RAD: f64 = 0.05;
    for polarity in [OpensWhen::Negative, OpensWhen::Positive] {
        let sign = polarity.sign();
        let pulse = samples(|t| half_sine(t, 0.0, 0.011, -30.0 * sign));
        let policy = options(RIGID, Polarity::Declared(polarity));
        for (part, answer, leading) in [
            (1.0, Answer::Undecided, "catch-tie"),
            (0.99, Answer::Pass, "threshold-not-crossed"),
            (1.01, Answer::Fail, "threshold-crossed"),
        ] {
            let mut design = Design::reference();
            let (lever, stop) = (&design.lever, &design.stop);
            design.catch = Some(Catch {
                moment_of_inertia_kg_m2: lever.moment_of_inertia_kg_m2,
                pivot_damping_nm_s_per_rad: lever.pivot_damping_nm_s_per_rad,
                spring_stiffness_nm_per_rad: lever.spring_stiffness_nm_per_rad,
                preload_torque_nm: lever.preload_torque_nm,
                unbalance_kg_m: lever.unbalance_kg_m(),
                engagement_angle_rad: part * BLOCKED_RAD,
                end_stop_angle_rad: 10.0,
                lever_angle_rad: BLOCKED_RAD,
                rest_restitution: stop.restitution,
                end_stop_restitution: 0.4,
                engagement_restitution: 0.0,
                reversible: true,
            });
            let judged = judge(&pulse, &[], &design, &policy);
            let what = format!(
                "{polarity:?}, catch at {part} of the angle: {:?}",
                judged.why
            );
            assert_eq!(judged.answer, answer, "{what}");
            assert_eq!(judged.why[0].code, leading, "{what}");
            let is_tie = codes(&judged).contains(&"catch-tie");
            assert_eq!(is_tie, answer == Answer::Undecided, "{what}");
            assert!(codes(&judged).contains(&"catch"), "{what}");
        }
    }
}
