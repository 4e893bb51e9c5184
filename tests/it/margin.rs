//! Guards margins: the values at which a verdict changes, against published and closed-form
//! values and against brute force.

mod advice;

use crate::support::{columns, signal, unconditioned};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::{self, StopModel};
use latchgate_kernel::parallel::Control;
use latchgate_kernel::replay::{self, RunOptions};
use latchgate_kernel::units::{OpensWhen, Restitution, STANDARD_GRAVITY};
use latchgate_recording::Finding;
use latchgate_recording::error::Error;
use latchgate_verdict::conditioning::{Conditioned, Signal};
use latchgate_verdict::margin::quantity::{SearchRange, applied};
use latchgate_verdict::margin::search::{Edge, Excess, Probe, changes};
use latchgate_verdict::margin::{
    self, Basis, MapAxis, MapRequest, Margin, MarginOptions, Margins, NominalAnswer, Quantity,
    critical_pulse,
};
use latchgate_verdict::{Answer, AssessExtras, Assessment, ModelChoice, Polarity, Policy};
use std::path::Path;

const RADIUS_M: f64 = 0.03;

fn conditioned(signal: Signal) -> Conditioned {
    unconditioned(&signal)
}

fn options(model: ModelChoice) -> MarginOptions {
    MarginOptions {
        policy: Policy::new(model, Polarity::Declared(OpensWhen::Negative)),
        basis: Basis::NominalRun,
        counterweight_radius_m: RADIUS_M,
        points: Some(200),
        map: None,
        limit: false,
    }
}

fn margins(
    conditioned: &Conditioned,
    findings: &[Finding],
    design: &Design,
    options: &MarginOptions,
) -> Result<Margins, Error> {
    margin::margins(conditioned, findings, design, options, &Control::default())
}

fn assess(
    conditioned: &Conditioned,
    findings: &[Finding],
    design: &Design,
    policy: &Policy,
) -> Result<Assessment, Error> {
    let (extras, control) = (AssessExtras::default(), Control::default());
    latchgate_verdict::assess(conditioned, findings, design, policy, extras, &control)
}

fn only(stop: StopModel) -> ModelChoice {
    ModelChoice::Only(stop)
}

fn of(margins: &Margins, quantity: Quantity) -> &Margin {
    margins
        .answers
        .iter()
        .find(|answer| answer.quantity == quantity)
        .unwrap()
}

#[track_caller]
fn check_near(what: &str, got: f64, want: f64, within: f64) {
    assert!(
        (got - want).abs() <= within,
        "{what}: got {got:e}, want {want:e}, off by {:e}",
        got - want
    );
}

// --- Values from outside --------------------------------------------------------------------

#[track_caller]
fn check_critical_scale(file: &str, stop: StopModel, want: f64, digits_after: f64) {
    let rows = columns(&format!("reference/signals/{file}"));
    let samples: Vec<f64> = rows.into_iter().map(|(_, value)| value).collect();
    assert!(samples.len() > 1000, "{file}");
    let found = margins(
        &conditioned(signal(10_000.0, samples)),
        &[],
        &Design::reference(),
        &options(only(stop)),
    )
    .unwrap();
    let scale = of(&found, Quantity::Scale);
    check_near(file, scale.at.unwrap(), want, digits_after);
    let (low, high) = scale.bracket.unwrap();
    assert!(low <= high && high - low <= 1e-9 * high, "{low}..{high}");
    assert_eq!(found.state, NominalAnswer::Fail);
}

/// Quad-precision critical scales of three reference pulses.
#[test]
fn val_critical_scales_of_the_reference_pulses() {
    for (file, rigid, soft) in [
        (
            "hs_30g_11ms_10k.csv",
            0.261_033_923_765_553_7,
            0.260_923_836_551_469_03,
        ),
        (
            "hv_100g_20ms_10k.csv",
            0.058_419_863_870_201_5,
            0.058_412_582_939_470_2,
        ),
        (
            "burst1_1000g_35ms_10k.csv",
            0.080_381_478_644_898_3,
            0.080_461_250_199_619_5,
        ),
    ] {
        check_critical_scale(file, StopModel::Rigid, rigid, 1e-12);
        check_critical_scale(file, StopModel::Soft, soft, 1e-12);
    }
}

/// 30 g without end, in the opening direction.
fn steady() -> Conditioned {
    conditioned(signal(1000.0, vec![-30.0 * STANDARD_GRAVITY; 1000]))
}

/// The preload that holds 30 g below 0.1 rad, published to five digits for both stops; lift-off
/// alone would ask for m·30 g·L.
#[test]
fn val_least_preload_under_a_steady_thirty_g() {
    for (stop, want) in [(StopModel::Rigid, 2.7974), (StopModel::Soft, 2.7977)] {
        let found = margins(&steady(), &[], &Design::reference(), &options(only(stop))).unwrap();
        let preload = of(&found, Quantity::Preload);
        check_near(stop.name(), preload.at.unwrap(), want, 5e-5);
        let lift_off = Design::reference().lever.unbalance_kg_m() * 30.0 * STANDARD_GRAVITY;
        check_near("lift-off", lift_off, 2.8206, 5e-5);
        assert!(preload.at.unwrap() < lift_off);
    }
}

/// Without damping the energy says it: mAL sin φ* = T0 φ* + k0 φ*²/2, on a rigid stop.
#[test]
fn val_steady_acceleration_against_the_energy_balance() {
    let mut design = Design::reference();
    design.lever.pivot_damping_nm_s_per_rad = 0.0;
    let lever = design.lever;
    let limit = design.criterion.threshold_rad;
    let torque = lever.unbalance_kg_m() * 30.0 * STANDARD_GRAVITY;
    let stored = 0.5 * lever.spring_stiffness_nm_per_rad * limit * limit;
    let preload = (torque * libm::sin(limit) - stored) / limit;
    let scale = (lever.preload_torque_nm * limit + stored) / (torque * libm::sin(limit));
    let found = margins(&steady(), &[], &design, &options(only(StopModel::Rigid))).unwrap();
    let at = |quantity| of(&found, quantity).at.unwrap();
    check_near("preload", at(Quantity::Preload), preload, 1e-11 * preload);
    check_near("scale", at(Quantity::Scale), scale, 1e-11 * scale);
    // A counterweight lowers the torque; its inertia has no part in an energy balance.
    let left = scale * lever.unbalance_kg_m();
    let mass = (lever.unbalance_kg_m() - left) / RADIUS_M;
    check_near("counterweight", at(Quantity::Counterweight), mass, 1e-11);
    check_near("unbalance", at(Quantity::Unbalance), left, 1e-13);
}

/// Published half-sine pulses that just bring the paper's lever to 0.1 rad, to the digits given.
#[test]
fn val_half_sine_limit_of_the_reference_lever() {
    for (duration_ms, amplitude, half_digit, change) in [
        (1.0, 77.6, 0.05, 0.485),
        (2.0, 39.2, 0.05, 0.490),
        (3.0, 26.4, 0.05, 0.495),
        (5.0, 16.2, 0.05, 0.506),
        (8.0, 10.45, 0.005, 0.522),
        (10.0, 8.53, 0.005, 0.533),
        (15.0, 5.98, 0.005, 0.560),
        (20.0, 4.71, 0.005, 0.588),
        (35.0, 3.08, 0.005, 0.673),
    ] {
        let point = critical_pulse(
            &Design::reference(),
            StopModel::Rigid,
            duration_ms / 1e3,
            &Control::default(),
        )
        .unwrap();
        let what = format!("{duration_ms} ms");
        check_near(&what, point.amplitude_g.unwrap(), amplitude, half_digit);
        check_near(&what, point.velocity_change_m_s.unwrap(), change, 6e-4);
    }
}

/// The shorter the pulse, the closer its change of velocity is to that of a blow on a lever without damping.
#[test]
fn val_very_short_pulses_approach_the_impulse_bound() {
    let mut design = Design::reference();
    design.lever.pivot_damping_nm_s_per_rad = 0.0;
    let lever = design.lever;
    let energy = lever.preload_torque_nm * 0.1 + 0.5 * lever.spring_stiffness_nm_per_rad * 0.01;
    let blow = (2.0 * lever.moment_of_inertia_kg_m2 * energy).sqrt() / lever.unbalance_kg_m();
    let point = critical_pulse(&design, StopModel::Rigid, 1e-5, &Control::default()).unwrap();
    let change = point.velocity_change_m_s.unwrap();
    assert!(change > blow, "{change} against {blow}");
    // While the pulse lasts the preload takes T0 D, half of which the pulse itself returns by
    // acting late; the rest is of second order in the duration.
    let held = lever.preload_torque_nm * 1e-5 / (2.0 * lever.unbalance_kg_m());
    check_near("blow", change, blow + held, 1e-6);
}

// --- Brute force ----------------------------------------------------------------------------

/// A plain generator of numbers between 0 and 1, so that a case can be repeated by its seed.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

/// A lever around the reference one, and a decaying burst of one to three tones.
fn case(seed: u64) -> (Design, Signal) {
    let mut numbers = Numbers(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15));
    for _ in 0..4 {
        numbers.next();
    }
    let mut design = Design::reference();
    design.lever.preload_torque_nm *= numbers.between(0.5, 5.0);
    design.lever.spring_stiffness_nm_per_rad *= numbers.between(0.2, 3.0);
    design.lever.mass_kg *= numbers.between(0.6, 1.2);
    design.stop.restitution = numbers.between(0.3, 0.95);
    let rate = 5000.0;
    let peak = STANDARD_GRAVITY * numbers.between(8.0, 60.0);
    let tones: Vec<(f64, f64)> = (0..1 + (seed % 3))
        .map(|_| (numbers.between(15.0, 160.0), numbers.between(0.0, 6.3)))
        .collect();
    let decay = numbers.between(0.015, 0.05);
    let samples = (0..300)
        .map(|index| {
            let t = f64::from(index) / rate;
            let sum: f64 = tones
                .iter()
                .map(|(hertz, phase)| libm::sin(std::f64::consts::TAU * hertz * t + phase))
                .sum();
            peak * libm::exp(-t / decay) * sum * (t / 0.002).min(1.0)
        })
        .collect();
    (design, signal(rate, samples))
}

/// What brute force does to the lever, written anew.
fn altered(quantity: Quantity, design: &Design, value: f64) -> (Design, f64) {
    let mut design = design.clone();
    let mut scale = 1.0;
    match quantity {
        Quantity::Scale => scale = value,
        Quantity::Preload => design.lever.preload_torque_nm = value,
        Quantity::Unbalance => design.lever.mass_kg = value / design.lever.center_of_mass_m,
        Quantity::Counterweight => {
            let unbalance = design.lever.mass_kg * design.lever.center_of_mass_m;
            design.lever.mass_kg =
                (unbalance - value * RADIUS_M).max(0.0) / design.lever.center_of_mass_m;
            design.lever.moment_of_inertia_kg_m2 += value * RADIUS_M * RADIUS_M;
        }
        Quantity::Restitution => {
            let ratio = |r: f64| stop::damping_ratio(Restitution::from_ratio(r).unwrap());
            design.stop.damping_n_s_per_m *= ratio(value) / ratio(design.stop.restitution);
            design.stop.restitution = value;
        }
    }
    (design, scale)
}

fn passes(design: &Design, signal: &Signal, scale: f64, stops: &[StopModel]) -> bool {
    let scaled = Signal {
        samples: signal.samples.iter().map(|a| a * scale).collect(),
        ..*signal
    };
    stops.iter().all(|stop| {
        let mut asked = RunOptions::new(*stop, OpensWhen::Negative);
        asked.error_bound = false;
        // As the search asks: a bracket may be as narrow as the rounding of a whole run.
        asked.peak_only = true;
        let run = replay::run(&scaled, design, &asked).unwrap().run;
        let highest = run
            .coast_peak_angle_rad
            .map_or(run.peak_angle_rad, |coast| coast.max(run.peak_angle_rad));
        highest <= design.criterion.threshold_rad
    })
}

/// Where a dense scan sees the answer change, an odd number of boundaries lies between; where it
/// sees none, an even number.
#[track_caller]
fn check_against_brute_force(seed: u64, model: ModelChoice, stops: &[StopModel]) -> usize {
    const DENSE: usize = 2000;
    let (design, signal) = case(seed);
    let mut asked = options(model);
    asked.points = None;
    let found = margins(&conditioned(signal.clone()), &[], &design, &asked).unwrap();
    let mut seen = 0;
    for answer in &found.answers {
        let boundaries: Vec<_> = found
            .boundaries
            .iter()
            .filter(|boundary| boundary.quantity == answer.quantity.name())
            .filter(|boundary| {
                (boundary.below == NominalAnswer::Pass) != (boundary.above == NominalAnswer::Pass)
            })
            .collect();
        let (low, high) = answer.searched;
        let at = |index: usize| {
            let share = index as f64 / DENSE as f64;
            if low > 0.0 {
                low * libm::pow(high / low, share)
            } else {
                low + (high - low) * share
            }
        };
        let state = |value: f64| {
            let (design, scale) = altered(answer.quantity, &design, value);
            passes(&design, &signal, scale, stops)
        };
        let mut before = state(at(0));
        for index in 0..DENSE {
            let now = state(at(index + 1));
            let between = boundaries
                .iter()
                .filter(|boundary| (at(index)..at(index + 1)).contains(&boundary.at))
                .count();
            assert_eq!(
                between % 2 == 1,
                before != now,
                "seed {seed}, {}, {} to {}: {between} boundaries, {before} then {now}",
                answer.quantity.name(),
                at(index),
                at(index + 1)
            );
            seen += usize::from(before != now);
            before = now;
        }
        let nearest = boundaries
            .iter()
            .map(|boundary| {
                if low > 0.0 {
                    libm::log(boundary.at / answer.present).abs()
                } else {
                    (boundary.at - answer.present).abs()
                }
            })
            .reduce(f64::min);
        let distance = answer.at.map(|at| {
            if low > 0.0 {
                libm::log(at / answer.present).abs()
            } else {
                (at - answer.present).abs()
            }
        });
        assert_eq!(nearest, distance, "seed {seed}, {}", answer.quantity.name());
        assert_eq!(answer.at.is_none(), answer.reason.is_some());
    }
    seen
}

#[test]
fn prop_margins_agree_with_brute_force_on_a_rigid_stop() {
    let seen: usize = (1..=4)
        .map(|seed| check_against_brute_force(seed, only(StopModel::Rigid), &[StopModel::Rigid]))
        .sum();
    assert!(seen >= 12, "only {seen} changes in all");
}

#[test]
fn prop_margins_agree_with_brute_force_on_a_soft_stop() {
    let seen: usize = (11..=12)
        .map(|seed| check_against_brute_force(seed, only(StopModel::Soft), &[StopModel::Soft]))
        .sum();
    assert!(seen >= 6, "only {seen} changes in all");
}

#[test]
fn prop_margins_agree_with_brute_force_on_both_stops() {
    let seen =
        check_against_brute_force(21, ModelChoice::Auto, &[StopModel::Rigid, StopModel::Soft]);
    assert!(seen >= 1, "no change at all");
}

// --- What the search promises ---------------------------------------------------------------

/// The answer on either side of every bracket is the one stated.
#[test]
fn verif_the_answer_differs_at_the_ends_of_every_bracket() {
    let (design, signal) = case(7);
    let found = margins(
        &conditioned(signal.clone()),
        &[],
        &design,
        &options(only(StopModel::Rigid)),
    )
    .unwrap();
    assert!(found.boundaries.len() >= 3, "{:?}", found.boundaries);
    for boundary in &found.boundaries {
        let quantity = Quantity::ALL
            .into_iter()
            .find(|quantity| quantity.name() == boundary.quantity)
            .unwrap();
        let (low, high) = boundary.bracket;
        assert!(boundary.at == low || boundary.at == high);
        // The unbalance's ends are those of the scale, a rounding apart.
        let slack = if quantity == Quantity::Unbalance {
            4.0 * f64::EPSILON
        } else {
            0.0
        };
        for (value, state) in [
            (low * (1.0 - slack), boundary.below),
            (high * (1.0 + slack), boundary.above),
        ] {
            let (design, scale) = altered(quantity, &design, value);
            assert_eq!(
                passes(&design, &signal, scale, &[StopModel::Rigid]),
                state == NominalAnswer::Pass,
                "{boundary:?} at {value}"
            );
        }
        assert!(high - low <= 1e-9 * high.abs().max(1e-3), "{boundary:?}");
    }
}

fn probe_of(f: &dyn Fn(f64) -> f64, near_rad: f64, grid: &[f64]) -> Vec<(f64, f64)> {
    let excess = |x: f64| Excess {
        pass: f(x),
        fail: f(x),
    };
    let scan = |values: &[f64]| Ok(values.iter().map(|x| excess(*x)).collect());
    let exact = |x: f64| Ok(excess(x));
    let found = changes(
        grid,
        &Probe {
            scan: &scan,
            exact: &exact,
            width: &|_| 1e-12,
            near_rad,
            distance: &|x| x,
            narrowed: 9,
            values_max: 55,
        },
    )
    .unwrap();
    found
        .crossings
        .iter()
        .map(|crossing| {
            assert_eq!(crossing.edge, Edge::Pass);
            assert!(crossing.high.0 - crossing.low.0 <= 1e-12);
            (crossing.low.0, crossing.high.0)
        })
        .collect()
}

fn tenths() -> Vec<f64> {
    (0..=10).map(|index| f64::from(index) / 10.0).collect()
}

/// A pair of crossings between two neighbouring values of the grid shows by how near the
/// function comes.
#[test]
fn verif_a_double_crossing_inside_a_cell_is_found() {
    let hump = |x: f64| 1e-3 - (x - 0.537) * (x - 0.537);
    let found = probe_of(&hump, 0.0, &tenths());
    assert_eq!(found.len(), 2, "{found:?}");
    for ((low, high), want) in found
        .iter()
        .zip([0.537 - 1e-3_f64.sqrt(), 0.537 + 1e-3_f64.sqrt()])
    {
        assert!(*low <= want + 1e-12 && want <= *high + 1e-12);
    }
}

/// A cell in which the answer changes may hide more changes: it is split as well where cells near the
/// threshold are.
#[test]
fn verif_further_changes_inside_a_cell_that_changes_are_found() {
    let peaks = |x: f64| match x {
        x if x < 0.42 => -0.1,
        x if x < 0.45 => 0.1,
        x if x < 0.48 => -0.1,
        _ => 0.1,
    };
    assert_eq!(probe_of(&peaks, 0.01, &tenths()).len(), 3);
}

/// What comes and goes between two values without a trace at either stays unseen, as the
/// documents say.
#[test]
fn verif_a_needle_between_two_values_stays_unseen() {
    let needle = |x: f64| if (x - 0.537).abs() < 1e-4 { 1.0 } else { -1.0 };
    assert!(probe_of(&needle, 0.01, &tenths()).is_empty());
}

/// Peaks of levers that are thrown wide open jump from one value to the next: a cell between two of
/// them is left, while the same picture near the threshold is looked into.
#[test]
fn verif_a_cell_between_levers_thrown_wide_open_is_left() {
    let peaks = |scale: f64| {
        move |x: f64| {
            if (0.42..0.47).contains(&x) {
                -0.1
            } else {
                scale * (2.0 + (x * 10.0).round() % 2.0)
            }
        }
    };
    assert_eq!(probe_of(&peaks(0.3), 0.0, &tenths()).len(), 2);
    assert_eq!(probe_of(&peaks(1.0), 0.0, &tenths()).len(), 0);
}

/// A jump, and a stretch that could not be followed, are narrowed down like any change.
#[test]
fn verif_jumps_and_unknown_stretches_are_narrowed_down() {
    let jump = |x: f64| if x < 1.0 / 3.0 { -0.2 } else { 7.0 };
    let found = probe_of(&jump, 0.0, &tenths());
    assert_eq!(found.len(), 1);
    assert!(found[0].0 < 1.0 / 3.0 && found[0].1 >= 1.0 / 3.0);
    let unknown = |x: f64| if x < 0.72 { -0.2 } else { f64::INFINITY };
    let found = probe_of(&unknown, 0.0, &tenths());
    assert_eq!(found.len(), 1);
    assert!(found[0].0 < 0.72 && found[0].1 >= 0.72);
}

/// A scan that is wrong by rounding about the sign at a value of the grid loses no change and
/// makes none up.
#[test]
fn verif_the_exact_run_overrules_the_scan() {
    let line = |x: f64| x - 0.5;
    let excess = |value: f64| Excess {
        pass: value,
        fail: value,
    };
    let grid = tenths();
    for noise in [-1e-13, 1e-13] {
        let scan = |values: &[f64]| Ok(values.iter().map(|x| excess(line(*x) + noise)).collect());
        let exact = |x: f64| Ok(excess(line(x)));
        let found = changes(
            &grid,
            &Probe {
                scan: &scan,
                exact: &exact,
                width: &|_| 1e-12,
                near_rad: 0.0,
                distance: &|x| x,
                narrowed: 9,
                values_max: 55,
            },
        )
        .unwrap();
        assert_eq!(found.crossings.len(), 1, "{noise}");
        let crossing = found.crossings[0];
        assert!(crossing.low.0 <= 0.5 && crossing.high.0 >= 0.5 && crossing.better_end() <= 0.5);
    }
}

/// The present value and both ends are on every grid, which ascends.
#[test]
fn verif_grids_hold_their_ends_and_the_present_value() {
    let design = Design::reference();
    for quantity in Quantity::ALL {
        for lift_off in [0.0, 0.01, 5.0, 1e6] {
            let stretch = SearchRange::of(quantity, &design, RADIUS_M, lift_off);
            let grid = stretch.grid(300);
            for value in [stretch.low, stretch.present, stretch.high] {
                assert!(grid.contains(&value), "{quantity:?} {value}");
            }
            assert!(grid.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }
}

/// A counterweight that balances the lever leaves nothing that could move it.
#[test]
fn verif_a_balanced_lever_does_not_move() {
    let design = Design::reference();
    let full = design.lever.unbalance_kg_m() / RADIUS_M;
    let (balanced, _) = applied(Quantity::Counterweight, &design, RADIUS_M, full);
    let steady = steady();
    for stop in [StopModel::Rigid, StopModel::Soft] {
        let run = replay::run(
            &steady.used,
            &balanced,
            &RunOptions::new(stop, OpensWhen::Negative),
        )
        .unwrap();
        assert!(!run.broke_down && run.run.peak_angle_rad <= 1e-15);
    }
    check_near(
        "inertia",
        balanced.lever.moment_of_inertia_kg_m2,
        design.lever.moment_of_inertia_kg_m2 + full * RADIUS_M * RADIUS_M,
        1e-18,
    );
}

#[test]
fn verif_threads_change_no_digit() {
    let (design, signal) = case(3);
    let mut asked = options(ModelChoice::Auto);
    asked.limit = true;
    asked.map = Some(MapRequest {
        x: axis("lever.preload_torque_nm", 0.05, 3.0),
        y: axis("stop.restitution", 0.2, 0.9),
        columns: 9,
        rows: 7,
    });
    let one = margins(&conditioned(signal.clone()), &[], &design, &asked).unwrap();
    let three = Control::unwatched(3);
    let three = margin::margins(&conditioned(signal), &[], &design, &asked, &three).unwrap();
    assert_eq!(one, three);
}

/// Nothing to be changed is said, with the range that was searched.
#[test]
fn verif_a_recording_of_rest_has_no_margin() {
    let rest = conditioned(signal(1000.0, vec![0.0; 50]));
    let found = margins(
        &rest,
        &[],
        &Design::reference(),
        &options(ModelChoice::Auto),
    )
    .unwrap();
    assert_eq!(found.state, NominalAnswer::Pass);
    assert!(found.boundaries.is_empty());
    for answer in &found.answers {
        assert!(answer.at.is_none() && answer.bracket.is_none());
        let reason = answer.reason.as_deref().unwrap();
        assert!(reason.contains("pass everywhere from"), "{reason}");
    }
}

/// Undeclared polarity judges both: the sign that opens earlier decides, whichever it is.
#[test]
fn verif_the_worse_polarity_sets_the_scale() {
    let (design, signal) = case(5);
    let of_signs: Vec<f64> = [OpensWhen::Negative, OpensWhen::Positive]
        .into_iter()
        .map(|sign| {
            let mut asked = options(only(StopModel::Rigid));
            asked.policy.polarity = Polarity::Declared(sign);
            let found = margins(&conditioned(signal.clone()), &[], &design, &asked).unwrap();
            first_no_pass(&found)
        })
        .collect();
    for polarity in [Polarity::Undeclared, Polarity::Both] {
        let mut asked = options(only(StopModel::Rigid));
        asked.policy.polarity = polarity;
        let found = margins(&conditioned(signal.clone()), &[], &design, &asked).unwrap();
        let least = of_signs[0].min(of_signs[1]);
        check_near("scale", first_no_pass(&found), least, 1e-11 * least);
    }
}

/// The least scale at which a pass ends.
fn first_no_pass(margins: &Margins) -> f64 {
    margins
        .boundaries
        .iter()
        .find(|b| b.quantity == "scale" && b.below == NominalAnswer::Pass)
        .unwrap()
        .at
}

/// The verdict's own change lies on the passing side of the nominal run's, and the rule says so
/// at both ends of its bracket.
#[test]
fn verif_the_change_of_the_verdict_is_one_by_the_rule() {
    for (seed, amplify) in [(2, 1.0), (2, 0.02), (4, 1.0)] {
        let (design, mut signal) = case(seed);
        signal.samples.iter_mut().for_each(|a| *a *= amplify);
        let mut asked = options(ModelChoice::Auto);
        asked.basis = Basis::Verdict;
        let found = margins(&conditioned(signal.clone()), &[], &design, &asked).unwrap();
        let scale = of(&found, Quantity::Scale);
        let (low, high) = scale.bracket.unwrap();
        let at = scale.at.unwrap();
        assert!(at == low || at == high);
        for value in [low, high] {
            let mut scaled = signal.clone();
            scaled.samples.iter_mut().for_each(|a| *a *= value);
            let answer = assess(&conditioned(scaled), &[], &design, &asked.policy)
                .unwrap()
                .answer;
            assert_eq!(
                answer == Answer::Pass,
                value == at,
                "{value} of {low}..{high}"
            );
        }
        check_near(
            "verdict against nominal",
            libm::log(at / scale.nominal_at.unwrap()),
            0.0,
            0.05,
        );
    }
}

/// With an ensemble each question ends where a pass has become impossible; at both ends of a
/// bracket the whole assessment says the same.
#[test]
fn verif_the_change_with_an_ensemble_is_one_by_the_rule() {
    for (seed, amplify, members, polarity) in [
        (2, 0.02, 128, Polarity::Declared(OpensWhen::Negative)),
        (4, 1.0, 700, Polarity::Undeclared),
        (5, 0.02, 2100, Polarity::Both),
    ] {
        let (design, mut signal) = case(seed);
        signal.samples.iter_mut().for_each(|a| *a *= amplify);
        let mut asked = options(ModelChoice::Auto);
        asked.basis = Basis::Verdict;
        asked.policy.members = members;
        asked.policy.polarity = polarity;
        let found = margins(&conditioned(signal.clone()), &[], &design, &asked).unwrap();
        let scale = of(&found, Quantity::Scale);
        let (low, high) = scale.bracket.unwrap();
        for value in [low, high] {
            let mut scaled = signal.clone();
            scaled.samples.iter_mut().for_each(|a| *a *= value);
            let assessed = assess(&conditioned(scaled), &[], &design, &asked.policy).unwrap();
            assert_eq!(
                assessed.answer == Answer::Pass,
                value == scale.at.unwrap(),
                "{value} of {low}..{high}, seed {seed}"
            );
        }
    }
}

/// On the way up the peak comes within its own error of the threshold, falls again, and crosses
/// only later: the verdict is no pass at that close call, so the margin ends there.
#[test]
fn regress_a_close_call_before_the_boundary_ends_the_margin() {
    let mut seen = 0;
    for seed in 1..=24 {
        let (mut design, mut signal) = case(seed);
        signal.samples.iter_mut().for_each(|a| *a *= 0.02);
        let mut asked = options(only(StopModel::Rigid));
        let wide = margins(&conditioned(signal.clone()), &[], &design, &asked).unwrap();
        let peaks: Vec<(f64, f64)> = wide
            .scans
            .iter()
            .find(|scan| scan.quantity == Quantity::Scale)
            .unwrap()
            .points
            .iter()
            .filter(|(at, _)| *at > 1.0)
            .map(|(at, peak)| (*at, peak.unwrap()))
            .collect();
        let mut highest = 1e-3;
        let mut top = None;
        for near in peaks.windows(2) {
            if near[0].1 > highest && near[1].1 < 0.98 * near[0].1 && near[0].1 < 1.0 {
                top = Some((near[0], near[1].0));
                break;
            }
            highest = near[0].1.max(highest);
        }
        let Some(((at, peak), next)) = top else {
            continue;
        };
        seen += 1;
        design.criterion.threshold_rad = peak * (1.0 + 1e-9);
        asked.basis = Basis::Verdict;
        let found = margins(&conditioned(signal), &[], &design, &asked).unwrap();
        let ends = of(&found, Quantity::Scale).at.unwrap();
        assert!(
            ends < next,
            "seed {seed}: {ends}, the close call is at {at}"
        );
    }
    assert!(seen >= 3, "{seen} close calls");
}

/// Several narrow stretches in which the nominal lever passes by luck lie nearer than the preload
/// from which on it always does, and by the rule none of them is a pass: the search went no
/// further and said that no preload passes.
#[test]
fn regress_the_least_preload_beyond_stretches_of_luck() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("signals/burst.csv");
    let samples: Vec<f64> = std::fs::read_to_string(path)
        .unwrap()
        .lines()
        .filter_map(|line| line.split(',').nth(1)?.parse::<f64>().ok())
        .map(|g| g * STANDARD_GRAVITY)
        .collect();
    assert!(samples.len() > 6000);
    let design = Design::reference();
    let mut asked = options(ModelChoice::Auto);
    asked.basis = Basis::Verdict;
    asked.policy.members = 128;
    asked.points = Some(300);
    let mut input = conditioned(signal(20_000.0, samples));
    input.used.start_s = -0.05;
    let found = margins(&input, &[], &design, &asked).unwrap();
    let preload = of(&found, Quantity::Preload);
    assert!(preload.changes > 6, "{} changes", preload.changes);
    let at = preload.at.expect("a preload that passes");
    let (passing, _) = applied(Quantity::Preload, &design, RADIUS_M, at);
    let answer = assess(&input, &[], &passing, &asked.policy).unwrap().answer;
    assert_eq!(answer, Answer::Pass, "at {at} N m");
    assert!(at < 60.0, "{at}");
}

/// A shake after which the lever bounces at random: the nominal peak says little of where scattered
/// levers fail. The answer is no further than what asking the whole rule step by step finds.
#[test]
fn regress_the_nearest_change_of_scattered_levers_is_found() {
    let tau = 2.0 * std::f64::consts::PI;
    let shake = |t: f64| 12.0 * (tau * 90.0 * t).sin() + 6.0 * (tau * 37.0 * t + 1.0).sin();
    let samples: Vec<f64> = (-200..1800)
        .map(|k| f64::from(k) / 10_000.0)
        .map(|t| {
            if (0.0..=0.1).contains(&t) {
                STANDARD_GRAVITY * shake(t)
            } else {
                0.0
            }
        })
        .collect();
    let input = conditioned(signal(10_000.0, samples));
    let mut asked = options(ModelChoice::Auto);
    asked.basis = Basis::Verdict;
    asked.points = None;
    asked.policy.members = 512;
    let mut design = Design::reference();
    design.lever.mass_kg = 0.0925;
    design.input.bias_g = 0.005;
    design.input.scale = 0.003;
    let passes_at = |scale: f64| {
        let mut scaled = input.clone();
        scaled.used.samples.iter_mut().for_each(|a| *a *= scale);
        assess(&scaled, &[], &design, &asked.policy).unwrap().answer == Answer::Pass
    };
    assert!(!passes_at(1.0));
    let nearest = (1..=20)
        .flat_map(|k| [1.0 + 0.01 * f64::from(k), 1.0 - 0.01 * f64::from(k)])
        .find(|scale| passes_at(*scale))
        .expect("a change within twenty steps");
    let found = margins(&input, &[], &design, &asked).unwrap();
    let at = of(&found, Quantity::Scale).at.unwrap();
    assert!(
        libm::log(at).abs() <= libm::log(nearest).abs(),
        "{at}, a change lies before {nearest}"
    );
}

/// A blocking finding leaves no verdict to change: the numbers are the nominal run's, and marked.
#[test]
fn verif_a_spoiled_recording_is_marked() {
    let (design, signal) = case(2);
    let mut asked = options(only(StopModel::Rigid));
    asked.basis = Basis::Verdict;
    let clipped = Finding::blocking("clipped", "for this test").at(0.01);
    let found = margins(&conditioned(signal), &[clipped], &design, &asked).unwrap();
    assert!(found.spoiled);
    assert_eq!(found.basis, Basis::NominalRun);
    assert!(of(&found, Quantity::Scale).verdict_at.is_none());
}

// --- The map --------------------------------------------------------------------------------

fn axis(key: &str, low: f64, high: f64) -> MapAxis {
    MapAxis {
        key: key.into(),
        low,
        high,
    }
}

/// Under a steady acceleration and without damping the boundary of preload against mass is the
/// straight line of the energy balance.
#[test]
fn val_the_boundary_of_a_map_against_the_energy_balance() {
    let mut design = Design::reference();
    design.lever.pivot_damping_nm_s_per_rad = 0.0;
    let limit = design.criterion.threshold_rad;
    let mut asked = options(only(StopModel::Rigid));
    asked.map = Some(MapRequest {
        x: axis("lever.mass_kg", 0.05, 0.2),
        y: axis("lever.preload_torque_nm", 0.5, 4.0),
        columns: 13,
        rows: 11,
    });
    let found = margins(&steady(), &[], &design, &asked).unwrap();
    let map = found.map.unwrap();
    assert!(map.vertices.len() > 12 && map.segments.len() + 1 == map.vertices.len());
    for vertex in &map.vertices {
        let torque = vertex.x * design.lever.center_of_mass_m * 30.0 * STANDARD_GRAVITY;
        let stored = 0.5 * design.lever.spring_stiffness_nm_per_rad * limit * limit;
        let preload = (torque * libm::sin(limit) - stored) / limit;
        check_near("boundary", vertex.y, preload, 1e-7);
        assert!(vertex.bracket.1 - vertex.bracket.0 <= 1e-9 * 3.5);
    }
    assert_eq!(map.judged, 13 * 11);
    assert_eq!(
        map.passing,
        map.passes
            .iter()
            .filter(|pass| **pass == Some(true))
            .count()
    );
}

/// Where the mass at its centre would alone have more inertia than the lever, there is none.
#[test]
fn verif_a_map_leaves_out_levers_that_cannot_be() {
    let mut asked = options(only(StopModel::Rigid));
    asked.map = Some(MapRequest {
        x: axis("lever.mass_kg", 0.1, 0.4),
        y: axis("lever.center_of_mass_m", 0.05, 0.1),
        columns: 6,
        rows: 5,
    });
    let map = margins(&steady(), &[], &Design::reference(), &asked)
        .unwrap()
        .map
        .unwrap();
    assert!(map.judged > 0 && map.judged < 30, "{}", map.judged);
    for (index, peak) in map.peaks_rad.iter().enumerate() {
        let mass = map.request.x.value(index % 6, 6);
        let distance = map.request.y.value(index / 6, 5);
        assert_eq!(peak.is_some(), mass * distance * distance <= 8.888e-4);
    }
}
