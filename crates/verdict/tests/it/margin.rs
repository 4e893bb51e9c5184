//! Guards margins: the values at which a verdict changes, against published and closed-form
//! values and against brute force.

use crate::support::{columns, signal, unconditioned};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::{self, StopModel};
use latchgate_kernel::parallel::Control;
use latchgate_kernel::replay::{self, RunOptions};
use latchgate_kernel::units::{OpensWhen, Restitution, STANDARD_GRAVITY};
use latchgate_recording::Finding;
use latchgate_recording::error::Error;
use latchgate_verdict::conditioning::{Between, Conditioned, Signal};
use latchgate_verdict::margin::quantity::{GridBounds, between, three_digits, within_cell};
use latchgate_verdict::margin::{
    self, Advice, Basis, Margin, MarginOptions, Margins, NominalAnswer, Quantity, critical_pulse,
};
use latchgate_verdict::{Answer, AssessExtras, Assessment, ModelChoice, Polarity, Policy};

const RADIUS_M: f64 = 0.03;

fn conditioned(signal: Signal) -> Conditioned {
    unconditioned(&signal)
}

fn options(model: ModelChoice) -> MarginOptions {
    MarginOptions {
        policy: Policy {
            between: Between::Linear,
            ..Policy::new(model, Polarity::Declared(OpensWhen::Negative))
        },
        basis: Basis::NominalRun,
        passes_at_present: None,
        counterweight_radius_m: RADIUS_M,
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
    check_near(file, scale.at().unwrap(), want, digits_after);
    let (low, high) = scale.change.unwrap().bracket();
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
        check_near(stop.name(), preload.at().unwrap(), want, 5e-5);
        let lift_off = Design::reference().lever.unbalance_kg_m() * 30.0 * STANDARD_GRAVITY;
        check_near("lift-off", lift_off, 2.8206, 5e-5);
        assert!(preload.at().unwrap() < lift_off);
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
    let at = |quantity| of(&found, quantity).at().unwrap();
    check_near("preload", at(Quantity::Preload), preload, 1e-11 * preload);
    check_near("scale", at(Quantity::Scale), scale, 1e-11 * scale);
    let stiffness =
        2.0 * (torque * libm::sin(limit) - lever.preload_torque_nm * limit) / (limit * limit);
    let found_stiffness = at(Quantity::SpringStiffness);
    check_near("stiffness", found_stiffness, stiffness, 1e-11 * stiffness);
    // A counterweight lowers the torque; its inertia has no part in an energy balance.
    let left = scale * lever.unbalance_kg_m();
    let mass = (lever.unbalance_kg_m() - left) / RADIUS_M;
    check_near("counterweight", at(Quantity::Counterweight), mass, 1e-11);
    check_near("unbalance", at(Quantity::Unbalance), left, 1e-13);
    check_near("arm", at(Quantity::Arm), left / lever.mass_kg, 1e-12);
    // A torque that overcomes the preload at rest opens the lever at any limit up to 1.5 rad.
    let angle = of(&found, Quantity::LimitAngle);
    assert_eq!(angle.at(), None);
    assert!(angle.reason.as_deref().unwrap().contains("at no value"));
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
        Quantity::SpringStiffness => design.lever.spring_stiffness_nm_per_rad = value,
        Quantity::LimitAngle => design.criterion.threshold_rad = value,
        Quantity::Arm => design.lever.center_of_mass_m = value,
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

/// Whether the whole rule says pass with the quantity at a value.
fn rule_passes(
    quantity: Quantity,
    (design, input): (&Design, &Conditioned),
    policy: &Policy,
    value: f64,
) -> bool {
    let (changed, scale) = altered(quantity, design, value);
    let mut scaled = input.clone();
    for samples in [&mut scaled.raw.samples, &mut scaled.used.samples] {
        samples.iter_mut().for_each(|a| *a *= scale);
    }
    assess(&scaled, &[], &changed, policy).unwrap().answer == Answer::Pass
}

/// The values of every quantity's grid for a recording that opens where it is negative.
fn grid(quantity: Quantity, design: &Design, input: &Conditioned) -> Vec<f64> {
    let opening = input.used.samples.iter().map(|a| -a);
    let bounds = GridBounds {
        strongest_m_s2: opening.fold(0.0, f64::max),
        counterweight_radius_m: RADIUS_M,
    };
    quantity.grid(design, &bounds)
}

/// Values of a grid in the order of their distance from the present one.
fn nearest_first(quantity: Quantity, grid: &[f64], present: f64) -> Vec<f64> {
    let distance = |value: f64| {
        if quantity.is_ratio() {
            libm::log(value / present).abs()
        } else {
            (value - present).abs()
        }
    };
    let mut order: Vec<f64> = grid.to_vec();
    order.retain(|value| *value != present);
    order.sort_by(|a, b| distance(*a).total_cmp(&distance(*b)));
    order
}

/// Every value of each grid asked anew: the advice is where the first value from the safe end does not
/// pass, and the nearest change, by rule and by nominal run, is the nearest on the grid. Returns how many
/// advices and changes there were.
#[track_caller]
fn check_against_brute_force(
    seed: u64,
    members: u32,
    model: ModelChoice,
    stops: &[StopModel],
) -> usize {
    let (design, signal) = case(seed);
    let mut asked = options(model);
    asked.basis = Basis::Verdict;
    asked.policy.members = members;
    let input = conditioned(signal.clone());
    let found = margins(&input, &[], &design, &asked).unwrap();
    let mut answered = 0;
    for answer in &found.answers {
        let quantity = answer.quantity;
        let what = format!("seed {seed}, {}", answer.title);
        let rule = |value: f64| rule_passes(quantity, (&design, &input), &asked.policy, value);
        let nominal = |value: f64| {
            let (design, scale) = altered(quantity, &design, value);
            passes(&design, &signal, scale, stops)
        };
        let grid = grid(quantity, &design, &input);
        assert_eq!(
            (answer.values, answer.searched.1),
            (grid.len(), *grid.last().unwrap()),
            "{what}"
        );

        // The advice.
        let mut order = grid.clone();
        if quantity.is_safer_above() {
            order.reverse();
        }
        let advice = &answer.advice;
        let passing = order
            .iter()
            .take_while(|value| nominal(**value) && rule(**value))
            .count();
        let next = order.get(passing).copied();
        let last = passing.checked_sub(1).map(|last| order[last]);
        assert_eq!(advice.until, order[0], "{what}");
        assert_eq!(
            advice.safe_from.is_some(),
            last.is_some(),
            "{what}: {}",
            advice.text
        );
        assert_eq!(advice.safe_from.is_none(), advice.reason.is_some());
        if let (Some(from), Some(last)) = (advice.safe_from, last) {
            answered += 1;
            let stays = |value: &f64| nominal(*value) && rule(*value);
            assert!(stays(&from), "{what}: {}", advice.text);
            assert!(advice.covers(quantity, order[0]), "{what}: {}", advice.text);
            if let Some(next) = next {
                assert!(!advice.covers(quantity, next), "{what}: {}", advice.text);
            }
            if let Some(does_not) = advice.does_not {
                assert!(!stays(&does_not), "{what}: {does_not}");
                assert!(
                    between(from, does_not).is_empty(),
                    "{what}: {from} and {does_not}"
                );
            }
            let is_clean = |cell: &[f64]| {
                let values = within_cell(cell[0], cell[1]);
                values.iter().chain(cell).all(stays)
            };
            // Five cells beyond the advice pass throughout, and no five between it and the first failure do.
            let beyond = order
                .iter()
                .filter(|value| advice.covers(quantity, **value));
            let beyond: Vec<f64> = beyond.copied().collect();
            let nearest = &beyond[beyond.len().saturating_sub(6)..];
            assert!(nearest.windows(2).all(is_clean), "{what}: {}", advice.text);
            let short_of = &order[beyond.len() - 1..=passing.min(order.len() - 1)];
            let clean: Vec<bool> = short_of.windows(2).map(is_clean).collect();
            assert!(
                !clean.windows(5).any(|cells| !cells.contains(&false)),
                "{what}: {last}, {}",
                advice.text
            );
            assert!(
                advice.tried >= beyond.len(),
                "{what}: {} tried",
                advice.tried
            );
        }

        // The nearest changes.
        let present = quantity.present(&design);
        let now = (nominal(present), nominal(present) && rule(present));
        assert_eq!(answer.passes_at_present, now.1, "{what}");
        for (change, now, exact, of) in [
            (
                answer.nominal_change,
                now.0,
                true,
                &nominal as &dyn Fn(f64) -> bool,
            ),
            (answer.verdict_change, now.1, false, &|value| {
                nominal(value) && rule(value)
            }),
        ] {
            let order = nearest_first(quantity, &grid, present);
            let first = order.iter().position(|value| of(*value) != now);
            assert_eq!(change.is_some(), first.is_some(), "{what}");
            if let (Some(change), Some(first)) = (change, first) {
                answered += 1;
                let (low, high) = change.bracket();
                if exact {
                    assert!(high - low <= 1e-11 * high, "{what}: {low}..{high}");
                } else {
                    assert!(between(low, high).is_empty(), "{what}: {low}..{high}");
                }
                assert!(
                    of(change.passes) && !of(change.does_not),
                    "{what}: {change:?}"
                );
                let towards = (order[first] - present).signum();
                assert!(
                    (low - present) * towards >= 0.0
                        && (high - order[first]) * towards <= high * 1e-12,
                    "{what}"
                );
            }
        }
        assert_eq!(answer.change, answer.verdict_change);
        // Nothing that was asked refutes the advice, and an isolated pass has what is none behind it.
        if let Some(change) = answer.verdict_change.filter(|of| of.does_not != present) {
            assert!(
                !advice.covers(quantity, change.does_not),
                "{what}: {change:?}"
            );
        }
        if let (true, Some(none)) = (answer.is_isolated(), advice.does_not) {
            let pass = if now.1 { present } else { answer.at().unwrap() };
            assert!(
                (pass - none) * (advice.until - none) < 0.0,
                "{what}: {pass}, {none}"
            );
        }
        assert_eq!(answer.at().is_none(), answer.reason.is_some(), "{what}");
    }
    answered
}

#[test]
fn prop_margins_agree_with_brute_force_on_a_rigid_stop() {
    let answered: usize = (1..=3)
        .map(|seed| check_against_brute_force(seed, 0, only(StopModel::Rigid), &[StopModel::Rigid]))
        .sum();
    assert!(answered >= 30, "only {answered} in all");
}

#[test]
fn prop_margins_agree_with_brute_force_on_a_soft_stop() {
    let answered = check_against_brute_force(11, 0, only(StopModel::Soft), &[StopModel::Soft]);
    assert!(answered >= 10, "only {answered} in all");
}

/// With an ensemble a pass is one at its first look.
#[test]
fn prop_margins_agree_with_brute_force_on_both_stops_with_an_ensemble() {
    let answered = check_against_brute_force(
        21,
        128,
        ModelChoice::Auto,
        &[StopModel::Rigid, StopModel::Soft],
    );
    assert!(answered >= 8, "only {answered} in all");
}

// --- What the search promises ---------------------------------------------------------------

/// The answer on either side of every bracket is the one stated.
#[test]
fn verif_the_answer_differs_at_the_ends_of_every_bracket() {
    let (design, signal) = case(7);
    let asked = options(only(StopModel::Rigid));
    let found = margins(&conditioned(signal.clone()), &[], &design, &asked).unwrap();
    assert!(found.boundaries.len() >= 3, "{:?}", found.boundaries);
    for boundary in &found.boundaries {
        let mut all = Quantity::ALL.into_iter();
        let quantity = all
            .find(|quantity| quantity.name() == boundary.quantity)
            .unwrap();
        let (low, high) = boundary.bracket;
        assert!(boundary.at == low || boundary.at == high);
        for (value, state) in [(low, boundary.below), (high, boundary.above)] {
            let (design, scale) = altered(quantity, &design, value);
            assert_eq!(
                passes(&design, &signal, scale, &[StopModel::Rigid]),
                state == NominalAnswer::Pass,
                "{boundary:?} at {value}"
            );
        }
        assert!(high - low <= 1e-9 * high.abs(), "{boundary:?}");
    }
}

/// Grids ascend, hold numbers of three digits, and no present value of their own quantity moves them.
#[test]
fn verif_grids_are_absolute() {
    let bounds = |strongest_m_s2: f64| GridBounds {
        strongest_m_s2,
        counterweight_radius_m: RADIUS_M,
    };
    let design = Design::reference();
    for quantity in Quantity::ALL {
        for strongest in [0.0, 1.0, 500.0, 1e9] {
            let grid = quantity.grid(&design, &bounds(strongest));
            assert!(
                grid.windows(2).all(|pair| pair[0] < pair[1]),
                "{quantity:?}"
            );
            assert!(
                (40..700).contains(&grid.len()),
                "{quantity:?}: {}",
                grid.len()
            );
            for value in &grid {
                let read: f64 = format!("{value:.2e}").parse().unwrap();
                assert_eq!(read, *value, "{quantity:?}");
            }
            let (moved, _) = quantity.applied(&design, RADIUS_M, grid[grid.len() / 3]);
            if quantity != Quantity::Counterweight {
                assert_eq!(
                    quantity.grid(&moved, &bounds(strongest)),
                    grid,
                    "{quantity:?}"
                );
            }
        }
    }
    let preload = Quantity::Preload.grid(&design, &bounds(100.0));
    let ends = [
        preload[0],
        preload[1],
        preload[47],
        preload[48],
        *preload.last().unwrap(),
    ];
    assert_eq!(ends, [0.001, 0.00105, 0.00953, 0.01, 1.96]);
    let restitution = Quantity::Restitution.grid(&design, &bounds(1.0));
    assert_eq!(
        (restitution[0], restitution[7], restitution[100]),
        (0.0, 0.07, 1.0)
    );
}

/// Numbers of three digits next to a value and between two, as decimal numbers are read.
#[test]
fn verif_three_digits_are_those_of_decimal_numbers() {
    for (value, below, above) in [
        (0.123_456, 0.123, 0.124),
        (9.999, 9.99, 10.0),
        (5.3, 5.3, 5.3),
        (1234.0, 1230.0, 1240.0),
    ] {
        assert_eq!(
            (three_digits(value, false), three_digits(value, true)),
            (below, above)
        );
    }
    assert_eq!(between(5.36, 5.3), [5.35, 5.34, 5.33, 5.32, 5.31]);
    assert_eq!(
        between(0.0, 0.03),
        (1..300)
            .map(|n| format!("{n}e-4").parse().unwrap())
            .collect::<Vec<f64>>()
    );
    assert!(between(9.99, 10.0).is_empty());
    let across = between(0.000_957, 0.001_09);
    assert_eq!(
        (across.len(), across[0], across[2]),
        (51, 0.000_958, 0.000_96)
    );
    assert_eq!(
        (across[41], across[42], across[43]),
        (0.000_999, 0.001, 0.001_01)
    );
}

/// A counterweight that balances the lever leaves nothing that could move it.
#[test]
fn verif_a_balanced_lever_does_not_move() {
    let design = Design::reference();
    let full = design.lever.unbalance_kg_m() / RADIUS_M;
    let (balanced, _) = Quantity::Counterweight.applied(&design, RADIUS_M, full);
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
    let one = margins(&conditioned(signal.clone()), &[], &design, &asked).unwrap();
    let three = Control::unwatched(3);
    let three = margin::margins(&conditioned(signal), &[], &design, &asked, &three).unwrap();
    assert_eq!(one, three);
}

/// Nothing to be changed is said, with the range that was tried.
#[test]
fn verif_a_recording_of_rest_has_no_margin() {
    let rest = conditioned(signal(1000.0, vec![0.0; 50]));
    let asked = options(ModelChoice::Auto);
    let found = margins(&rest, &[], &Design::reference(), &asked).unwrap();
    assert_eq!(found.state, NominalAnswer::Pass);
    assert!(found.boundaries.is_empty());
    for answer in &found.answers {
        assert!(answer.change.is_none());
        let reason = answer.reason.as_deref().unwrap();
        assert!(
            reason.contains("a pass at every value tried from"),
            "{reason}"
        );
        assert!(
            answer.advice.text.starts_with("Passes "),
            "{}",
            answer.advice.text
        );
    }
}

/// Undeclared polarity judges both: the sign that opens earlier decides, whichever it is.
#[test]
fn verif_the_worse_polarity_sets_the_scale() {
    let (design, signal) = case(5);
    let first = |polarity: Polarity| {
        let mut asked = options(only(StopModel::Rigid));
        asked.policy.polarity = polarity;
        let found = margins(&conditioned(signal.clone()), &[], &design, &asked).unwrap();
        first_no_pass(&found)
    };
    let of_signs =
        [OpensWhen::Negative, OpensWhen::Positive].map(|sign| first(Polarity::Declared(sign)));
    let least = of_signs[0].min(of_signs[1]);
    for polarity in [Polarity::Undeclared, Polarity::Both] {
        check_near("scale", first(polarity), least, 1e-11 * least);
    }
}

/// The least scale at which a pass ends.
fn first_no_pass(margins: &Margins) -> f64 {
    let mut boundaries = margins.boundaries.iter();
    let first = boundaries.find(|b| b.quantity == "scale" && b.below == NominalAnswer::Pass);
    first.unwrap().at
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
    let scale = of(&found, Quantity::Scale);
    assert!(scale.verdict_change.is_none() && scale.nominal_change.is_some());
    assert!(
        scale
            .advice
            .text
            .ends_with("a blocking finding makes the recording unusable")
    );
}

/// The advice is the same in a report as in a margin.
#[test]
fn verif_a_report_and_a_margin_advise_alike() {
    for seed in [3, 8] {
        let (design, signal) = case(seed);
        let input = conditioned(signal);
        let mut asked = options(ModelChoice::Auto);
        asked.basis = Basis::Verdict;
        asked.policy.members = 300;
        let found = margins(&input, &[], &design, &asked).unwrap();
        let preload = of(&found, Quantity::Preload);
        let alone = |threads| {
            let control = Control::unwatched(threads);
            let passes = Some(preload.passes_at_present);
            margin::advice(
                Quantity::Preload,
                &input,
                &[],
                &design,
                &asked.policy,
                passes,
                &control,
            )
            .unwrap()
        };
        for threads in [1, 3] {
            assert_eq!(alone(threads).as_ref(), Some(&preload.advice));
        }
        assert!(
            preload.advice.safe_from.is_some(),
            "{}",
            preload.advice.text
        );
    }
}

/// The preload advised is one number whichever preload the lever has, and its sentence says what the
/// present one does: opens, stays shut beyond it, or passes by luck before it.
#[test]
fn verif_the_advice_moves_with_no_present_value() {
    let (design, signal) = case(3);
    let input = conditioned(signal);
    let asked = options(only(StopModel::Rigid));
    let advice = |preload_nm: f64| -> Advice {
        let mut design = design.clone();
        design.lever.preload_torque_nm = preload_nm;
        let (policy, control) = (&asked.policy, Control::default());
        let found = margin::advice(
            Quantity::Preload,
            &input,
            &[],
            &design,
            policy,
            None,
            &control,
        );
        found.unwrap().expect("not spoiled")
    };
    let grid = grid(Quantity::Preload, &design, &input);
    let from = advice(0.1).safe_from.unwrap();
    let before = grid.iter().filter(|value| **value < from);
    let isolated = before
        .copied()
        .find(|value| rule_passes(Quantity::Preload, (&design, &input), &asked.policy, *value));
    let mut seen = std::collections::BTreeSet::new();
    for preload_nm in [0.01, 0.1, from * 0.95, from, 2.0 * from]
        .into_iter()
        .chain(isolated)
    {
        let found = advice(preload_nm);
        assert_eq!(found.safe_from, Some(from), "asked from {preload_nm}");
        let passes = rule_passes(
            Quantity::Preload,
            (&design, &input),
            &asked.policy,
            preload_nm,
        );
        let kind = match (passes, found.covers(Quantity::Preload, preload_nm)) {
            (false, false) => "A preload of ",
            (false, true) => " values of the preload from ",
            (true, true) => "Passes down to a preload of ",
            (true, false) => "Isolated pass, do not design to it: a preload of ",
        };
        assert!(found.text.contains(kind), "{}", found.text);
        let tried = format!("{} values", found.tried);
        assert!(found.text.contains(&tried), "{}", found.text);
        seen.insert(kind);
    }
    assert!(
        seen.len() >= 2 + usize::from(isolated.is_some()),
        "{seen:?}"
    );
}

/// A bias that may push the lever open by itself leaves no scale that passes, and that is said.
#[test]
fn verif_a_bias_that_opens_alone_is_named() {
    let (design, signal) = case(3);
    let mut input = conditioned(signal);
    input.bias_standard_error_m_s2 = 2.0 * design.lever.lift_off_acceleration_m_s2();
    let mut asked = options(ModelChoice::Auto);
    asked.basis = Basis::Verdict;
    asked.policy.members = 128;
    let found = margins(&input, &[], &design, &asked).unwrap();
    let scale = of(&found, Quantity::Scale);
    assert_eq!(scale.advice.safe_from, None);
    let reason = scale.advice.reason.as_deref().unwrap();
    assert!(reason.starts_with("the bias alone opens"), "{reason}");
}

/// A stopped search keeps what it found and says of the rest that it was not asked.
#[test]
fn verif_a_stopped_search_keeps_what_it_has() {
    let (design, signal) = case(3);
    let input = conditioned(signal);
    let asked = options(only(StopModel::Rigid));
    let control = Control {
        threads: 1,
        proceed: &|part| part.is_none_or(|part| part < 0.3),
    };
    let found = margin::margins(&input, &[], &design, &asked, &control).unwrap();
    assert!(found.stopped);
    let whole = margins(&input, &[], &design, &asked).unwrap();
    assert_eq!(found.answers[..2], whole.answers[..2]);
    assert_eq!(found.answers.len(), Quantity::ALL.len());
    let reason = found.answers[4].reason.as_deref().unwrap();
    assert!(reason.contains("stopped"), "{reason}");
}

/// What the limit on work leaves unasked is no pass, and that is said.
#[test]
fn verif_the_limit_on_work_ends_a_search_on_the_safe_side() {
    let (design, signal) = case(3);
    let input = conditioned(signal);
    let mut asked = options(only(StopModel::Rigid));
    asked.basis = Basis::Verdict;
    let whole = margins(&input, &[], &design, &asked).unwrap();
    asked.policy.work = 3000;
    let found = margins(&input, &[], &design, &asked).unwrap();
    let (all, some) = (of(&whole, Quantity::Preload), of(&found, Quantity::Preload));
    assert!(all.advice.safe_from.unwrap() < some.advice.safe_from.unwrap_or(f64::INFINITY));
    let last = of(&found, Quantity::LimitAngle);
    assert_eq!(last.advice.safe_from, None);
    assert!(last.advice.text.contains("`work`"), "{}", last.advice.text);
}

/// Where the limit on work ends a search, no number of threads moves it.
#[test]
fn verif_threads_do_not_move_the_limit_on_work() {
    let (design, signal) = case(3);
    let input = conditioned(signal);
    for basis in [Basis::Verdict, Basis::NominalRun] {
        for work in [400, 1000, 3000, 10_000] {
            let mut asked = options(only(StopModel::Rigid));
            asked.basis = basis;
            asked.policy.work = work;
            let one = margins(&input, &[], &design, &asked).unwrap();
            let cut = of(&one, Quantity::LimitAngle);
            assert_eq!(cut.change, None, "{work}");
            for threads in [2, 3, 7] {
                let control = Control::unwatched(threads);
                let other = margin::margins(&input, &[], &design, &asked, &control).unwrap();
                assert_eq!(one, other, "{basis:?}, work {work}, {threads} threads");
            }
        }
    }
}

/// The advice speaks of the verdict at present, whichever answer the margins rest on: a nominal lever that
/// stays below the limit by less than its uncertainty is no pass.
#[test]
fn verif_the_advice_speaks_of_the_verdict() {
    let (mut design, signal) = case(3);
    let input = conditioned(signal);
    let asked = options(only(StopModel::Rigid));
    let found = margins(&input, &[], &design, &asked).unwrap();
    let change = of(&found, Quantity::Preload).nominal_change.unwrap();
    design.lever.preload_torque_nm = change.passes;
    let of_basis = |basis| {
        let asked = MarginOptions {
            basis,
            ..asked.clone()
        };
        margins(&input, &[], &design, &asked).unwrap()
    };
    let (nominal, verdict) = (of_basis(Basis::NominalRun), of_basis(Basis::Verdict));
    let (nominal, verdict) = (
        of(&nominal, Quantity::Preload),
        of(&verdict, Quantity::Preload),
    );
    assert!(nominal.passes_at_present && !verdict.passes_at_present);
    assert_eq!(nominal.advice, verdict.advice);
    assert_eq!(nominal.verdict_change, verdict.verdict_change);
}
