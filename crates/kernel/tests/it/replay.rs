//! Replay against closed forms, and what the mathematics promises of it.

use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::{Method, RunOptions, RunOutcome, State, TracePoint, energy_j};
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY};
use latchgate_test_support::{Random, options, random_design, random_signal, replay, signal};

const RIGID: StopModel = StopModel::Rigid;
const SOFT: StopModel = StopModel::Soft;

#[track_caller]
fn check_close(what: &str, got: f64, want: f64, tolerance: f64) {
    assert!(
        (got - want).abs() <= tolerance,
        "{what}: got {got:e}, want {want:e}, off by {:e}",
        got - want
    );
}

fn quiet(rate_hz: f64, seconds: f64) -> Signal {
    signal(rate_hz, vec![0.0; (rate_hz * seconds).round() as usize + 1])
}

fn from(stop: StopModel, angle: f64, velocity: f64) -> RunOptions {
    RunOptions {
        initial: Some(State::new(angle, velocity)),
        ..options(stop)
    }
}

/// First root of a function that is positive before it and negative after it.
fn bisect(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if f(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// The damped oscillator without excitation in closed form:
/// u(t) = −T0/k + e^{−γt/2} (A cos ωt + B sin ωt), written so that nothing cancels when the
/// motion is small.
struct Oscillator {
    start: f64,
    velocity: f64,
    decay: f64,
    omega: f64,
    a: f64,
    b: f64,
}

impl Oscillator {
    /// In flight, or with `contact` in the soft stop.
    fn new(design: &Design, contact: bool, start: f64, velocity: f64) -> Self {
        let lever = &design.lever;
        let (c, k) = if contact {
            (
                design.stop.contact_damping_nm_s_per_rad(lever),
                design.stop.contact_stiffness_nm_per_rad(lever),
            )
        } else {
            (
                lever.pivot_damping_nm_s_per_rad,
                lever.spring_stiffness_nm_per_rad,
            )
        };
        let decay = 0.5 * c / lever.moment_of_inertia_kg_m2;
        let omega = (k / lever.moment_of_inertia_kg_m2 - decay * decay).sqrt();
        let a = start + lever.preload_torque_nm / k;
        Self {
            start,
            velocity,
            decay,
            omega,
            a,
            b: (velocity + decay * a) / omega,
        }
    }

    fn angle(&self, t: f64) -> f64 {
        let (shrink, turn) = (libm::expm1(-self.decay * t), self.omega * t);
        let half = libm::sin(0.5 * turn);
        self.start
            + self.a * (shrink * libm::cos(turn) - 2.0 * half * half)
            + self.b * (1.0 + shrink) * libm::sin(turn)
    }

    fn velocity(&self, t: f64) -> f64 {
        let turn = self.omega * t;
        let sine = self.decay * self.b + self.omega * self.a;
        libm::exp(-self.decay * t) * (self.velocity * libm::cos(turn) - sine * libm::sin(turn))
    }

    /// Time of the first maximum after a start with a velocity ≥ 0.
    fn top(&self) -> f64 {
        bisect(0.0, std::f64::consts::PI / self.omega, |t| self.velocity(t))
    }

    /// Time at which the angle falls to zero.
    fn landing(&self) -> f64 {
        let top = if self.velocity > 0.0 { self.top() } else { 0.0 };
        bisect(top, top + std::f64::consts::PI / self.omega, |t| {
            self.angle(t)
        })
    }
}

/// Impacts (time, velocity before) of a free lever on the rigid stop, as long as `speed`.
fn bounces(design: &Design, angle: f64, speed: f64) -> Vec<(f64, f64)> {
    let (mut time, mut start, mut velocity) = (0.0, angle, 0.0);
    let mut found = vec![];
    loop {
        let flight = Oscillator::new(design, false, start, velocity);
        let t = flight.landing();
        time += t;
        let before = flight.velocity(t);
        if -before < speed {
            return found;
        }
        found.push((time, before));
        start = 0.0;
        velocity = -design.stop.restitution * before;
    }
}

#[track_caller]
fn check_free_vibration(preload: f64, rate_hz: f64) {
    let mut design = Design::reference();
    design.lever.preload_torque_nm = preload;
    let run = replay(&quiet(rate_hz, 2.5), &design, &from(RIGID, 0.5, 0.0)).run;
    let want: Vec<_> = bounces(&design, 0.5, 1e-3)
        .into_iter()
        .take_while(|(t, _)| *t < 2.5)
        .collect();
    assert_eq!(run.impacts, want.len() as u64);
    for (k, (got, want)) in run.impact_list.iter().zip(&want).enumerate() {
        check_close(&format!("time of impact {k}"), got[0], want.0, 1e-12);
        check_close(
            &format!("velocity of impact {k}"),
            got[1],
            want.1,
            1e-12 * want.1.abs(),
        );
    }
    check_close("peak", run.peak_angle_rad, 0.5, 0.0);
    assert_eq!(run.first_release_s, Some(0.0));
    assert_eq!(run.first_crossing_s, Some(0.0));
}

/// Free vibration without preload: impacts at equal intervals, never rest.
#[test]
fn val_free_vibration_on_the_rigid_stop_without_preload() {
    check_free_vibration(0.0, 10_000.0);
    check_free_vibration(0.0, 250.0);
}

/// Free vibration with preload: bounces ever closer together.
#[test]
fn val_free_vibration_on_the_rigid_stop_with_preload() {
    check_free_vibration(0.1, 10_000.0);
    check_free_vibration(0.1, 250.0);
}

/// The bounces add up to 0.829523400832410 s, by their closed form and by an independent
/// computation in quadruple precision.
#[test]
fn val_bounces_come_to_rest_at_their_accumulation_time() {
    let design = Design::reference();
    let list = bounces(&design, 0.5, 1e-6);
    let (last, before) = *list.last().unwrap();
    let after = -design.stop.restitution * before;
    let pressing = design.lever.preload_torque_nm / design.lever.moment_of_inertia_kg_m2;
    let rest = last + 2.0 * after / (pressing * (1.0 - design.stop.restitution));
    check_close("closed form", rest, 0.829_523_400_832_410, 2e-13);
    for rate in [250.0, 10_000.0, 1e6] {
        let outcome = replay(&quiet(rate, 0.9), &design, &from(RIGID, 0.5, 0.0));
        let first = outcome
            .trace
            .iter()
            .find(|p| p.angle_rad == 0.0 && p.velocity_rad_s == 0.0)
            .unwrap();
        check_close("rest", first.time_s, 0.829_523_400_832_410, 1e-12);
        assert!(!outcome.run.moving_at_end);
        assert_eq!(outcome.run.coast_peak_angle_rad, None);
    }
}

/// a(t) = −s t reaches lift-off at T0/(m L s), inside a sample.
#[test]
fn val_a_ramp_releases_the_lever_at_the_instant_of_zero_torque() {
    let design = Design::reference();
    let lift_off = design.lever.lift_off_acceleration_m_s2();
    for (rate, slope) in [(10_000.0, 777.0), (250.0, 1234.5), (1e5, 5e5)] {
        let count = (1.5 * lift_off / slope * rate).ceil() as usize + 2;
        let ramp = (0..count).map(|k| -slope * k as f64 / rate).collect();
        let run = replay(&signal(rate, ramp), &design, &options(RIGID)).run;
        let want = lift_off / slope;
        check_close("release", run.first_release_s.unwrap(), want, 4e-16 * want);
    }
}

/// 1.0636 g opens the reference lever: a steady acceleration a hair above moves it, a hair
/// below does not.
#[test]
fn val_lift_off_acceleration_of_the_reference_lever() {
    let design = Design::reference();
    let lift_off = 0.1 / (0.1475 * 0.065);
    check_close("lift-off [g]", lift_off / STANDARD_GRAVITY, 1.063_589, 1e-6);
    for (factor, moves) in [(1.0 - 1e-12, false), (1.0 + 1e-12, true)] {
        let steady = signal(1000.0, vec![-lift_off * factor; 200]);
        let run = replay(&steady, &design, &options(RIGID)).run;
        assert_eq!(run.first_release_s.is_some(), moves, "factor {factor}");
        assert_eq!(run.peak_angle_rad > 0.0, moves, "factor {factor}");
    }
}

/// −T0/(k0 + ks ls²) = −9.99996300013690e-7 rad, from the first sample to the last.
#[test]
fn val_static_equilibrium_of_the_soft_stop() {
    let outcome = replay(&quiet(10_000.0, 0.5), &Design::reference(), &options(SOFT));
    for point in &outcome.trace {
        check_close("angle", point.angle_rad, -9.999_963_000_136_899e-7, 1e-20);
        check_close("velocity", point.velocity_rad_s, 0.0, 1e-15);
    }
    let run = outcome.run;
    assert_eq!((run.impacts, run.first_release_s), (0, None));
    assert!(run.peak_angle_rad < 0.0 && !run.moving_at_end);
}

/// Without preload the contact is a linear oscillator: it lasts π/ω_d and gives back
/// exp(−ξπ/√(1−ξ²)) of the speed.
#[track_caller]
fn check_contact(speed: f64, rate_hz: f64) {
    let mut design = Design::reference();
    design.lever.preload_torque_nm = 0.0;
    design.lever.pivot_damping_nm_s_per_rad = 0.0;
    let lever = &design.lever;
    let omega = design.stop.contact_angular_frequency_rad_s(lever);
    let xi = design.stop.damping_n_s_per_m * design.stop.radius_m * design.stop.radius_m
        / (2.0 * lever.moment_of_inertia_kg_m2 * omega);
    // What the stop's designers aimed at: ξ for a restitution of 0.8.
    check_close("damping ratio", xi, 0.070_850_300_195, 1e-6);
    let root = (1.0 - xi * xi).sqrt();
    let restitution = libm::exp(-xi * std::f64::consts::PI / root);
    let outcome = replay(&quiet(rate_hz, 0.01), &design, &from(SOFT, 0.0, -speed));
    let exit = outcome
        .trace
        .iter()
        .find(|p| p.angle_rad == 0.0 && p.velocity_rad_s > 0.0)
        .unwrap();
    check_close(
        "restitution",
        exit.velocity_rad_s / speed,
        restitution,
        1e-13,
    );
    let lasts = std::f64::consts::PI / (omega * root);
    check_close("duration", exit.time_s, lasts, 1e-13 * lasts);
}

#[test]
fn val_contact_of_the_soft_stop_gives_back_what_its_damping_ratio_says() {
    for speed in [1e-3, 1.0, 20.0] {
        for rate in [250.0, 1000.0, 10_000.0, 1e6] {
            check_contact(speed, rate);
        }
    }
}

/// After the last sample the lever coasts: its top in closed form, with and without impact.
#[test]
fn val_coast_reaches_the_peak_of_the_free_oscillation() {
    let design = Design::reference();
    for (angle, velocity) in [(0.05, 3.0), (0.0, 5.0), (0.3, 0.1), (0.0, 0.01)] {
        let run = replay(&quiet(1e6, 1e-6), &design, &from(RIGID, angle, velocity)).run;
        let flight = Oscillator::new(&design, false, angle, velocity);
        let want = flight.angle(flight.top());
        let coast = run.coast_peak_angle_rad.unwrap();
        check_close("coast peak", coast, want, 1e-13 * want);
    }
    for velocity in [-10.0, -3.0] {
        let run = replay(&quiet(1e6, 1e-6), &design, &from(RIGID, 0.01, velocity)).run;
        let flight = Oscillator::new(&design, false, 0.01, velocity);
        let landing = bisect(0.0, 0.02, |t| flight.angle(t));
        let back = -design.stop.restitution * flight.velocity(landing);
        let rebound = Oscillator::new(&design, false, 0.0, back);
        let want = rebound.angle(rebound.top());
        let coast = run.coast_peak_angle_rad.unwrap();
        check_close("coast peak", coast, want, 1e-12 * want);
    }
}

/// A record that ends while the stop is compressed: the stop throws the lever back, and the
/// coast's peak is that of the flight that follows.
#[test]
fn val_coast_out_of_a_compressed_soft_stop() {
    let design = Design::reference();
    for (angle, velocity) in [(-1e-4, 0.0), (-1e-4, -0.1), (-1e-4, 0.1), (-1e-3, -2.0)] {
        let record = quiet(1e9, 1e-9);
        let run = replay(&record, &design, &from(SOFT, angle, velocity)).run;
        let contact = Oscillator::new(&design, true, angle, velocity);
        // Turning point first, then the way out.
        let mut turn = 0.0;
        while contact.velocity(turn) < 0.0 {
            turn += 1e-7;
        }
        let out = bisect(turn, turn + 2e-4, |t| -contact.angle(t));
        let flight = Oscillator::new(&design, false, 0.0, contact.velocity(out));
        let want = flight.angle(flight.top());
        let coast = run.coast_peak_angle_rad.unwrap();
        check_close("coast peak", coast, want, 1e-11 * want);
    }
}

/// A step of constant acceleration on an undamped lever: at the peak the work of the
/// excitation, −m L a sin φ, equals T0 φ + k φ²/2.
#[test]
fn val_peak_under_constant_acceleration_from_the_energy() {
    let mut design = Design::reference();
    design.lever.pivot_damping_nm_s_per_rad = 0.0;
    let lever = design.lever;
    for acceleration in [10.5, 12.0, 20.0, 60.0, 150.0] {
        for rate in [500.0, 10_000.0] {
            let steady = signal(rate, vec![-acceleration; (0.4 * rate) as usize]);
            let work = |u: f64| {
                lever.unbalance_kg_m() * acceleration * libm::sin(u)
                    - lever.preload_torque_nm * u
                    - 0.5 * lever.spring_stiffness_nm_per_rad * u * u
            };
            let want = bisect(1e-4, std::f64::consts::PI, work);
            let run = replay(&steady, &design, &options(RIGID)).run;
            check_close("peak", run.peak_angle_rad, want, 1e-12 * want);
        }
    }
}

/// The damped oscillator's impulse: a brief push Δv = ∫ m L a/I0 dt from rest, within what
/// the preload and the push's own length allow.
#[test]
fn val_a_brief_push_gives_the_velocity_of_its_impulse() {
    let design = Design::reference();
    let (rate, height) = (1e6, -2e6);
    let mut samples = vec![0.0; 100_000];
    samples[10] = height;
    let run = replay(&signal(rate, samples), &design, &options(RIGID)).run;
    let gain = design.lever.unbalance_kg_m() / design.lever.moment_of_inertia_kg_m2;
    let flight = Oscillator::new(&design, false, 0.0, -gain * height / rate);
    let want = flight.angle(flight.top());
    check_close("peak", run.peak_angle_rad, want, 2e-5 * want);
}

// What the mathematics promises.

/// The state just before each of the events in the trace, and just after.
fn jumps(trace: &[TracePoint]) -> Vec<(f64, f64)> {
    trace
        .windows(2)
        .filter(|pair| {
            pair[0].time_s == pair[1].time_s
                && pair[0].angle_rad == 0.0
                && pair[0].velocity_rad_s < 0.0
                && pair[1].velocity_rad_s > 0.0
        })
        .map(|pair| (pair[0].velocity_rad_s, pair[1].velocity_rad_s))
        .collect()
}

#[test]
fn verif_every_impact_follows_the_restitution_law() {
    for seed in 0..200 {
        let mut random = Random(seed);
        let design = random_design(&mut random);
        let record = random_signal(&mut random, 150, 10.0, 3000.0);
        let outcome = replay(&record, &design, &options(RIGID));
        let jumps = jumps(&outcome.trace);
        assert!(jumps.len() as u64 + 2 >= outcome.run.impacts || design.stop.restitution == 0.0);
        for (before, after) in jumps {
            assert_eq!(after, -design.stop.restitution * before, "seed {seed}");
        }
    }
}

/// Without excitation nothing feeds the lever: its energy never grows, on either stop.
#[test]
fn verif_energy_never_grows_without_excitation() {
    for seed in 0..100 {
        let mut random = Random(seed);
        let design = random_design(&mut random);
        let start = (random.between(0.0, 1.0), random.between(-20.0, 20.0));
        for stop in [RIGID, SOFT] {
            let outcome = replay(&quiet(2000.0, 0.5), &design, &from(stop, start.0, start.1));
            let energy = |p: &TracePoint| energy_j(&design, stop, p.angle_rad, p.velocity_rad_s);
            let first = energy(&outcome.trace[0]);
            for pair in outcome.trace.windows(2) {
                assert!(
                    energy(&pair[1]) <= energy(&pair[0]) + 1e-13 * first.abs(),
                    "seed {seed} {} at {}: {:e} after {:e}",
                    stop.name(),
                    pair[1].time_s,
                    energy(&pair[1]),
                    energy(&pair[0])
                );
            }
        }
    }
}

/// Every sample interval in `parts` equal linear pieces.
fn split(record: &Signal, parts: usize) -> Signal {
    let mut samples = vec![];
    for pair in record.samples.windows(2) {
        for k in 0..parts {
            samples.push(pair[0] + (pair[1] - pair[0]) * k as f64 / parts as f64);
        }
    }
    samples.push(*record.samples.last().unwrap());
    signal(record.rate.hertz() * parts as f64, samples)
}

#[track_caller]
fn check_same(label: &str, got: &RunOutcome, want: &RunOutcome, factor: f64) {
    let (a, b) = (&got.run, &want.run);
    let slack = 1e-11_f64.max(a.numerical_error_rad + b.numerical_error_rad);
    check_close(
        &format!("{label}: peak"),
        a.peak_angle_rad,
        b.peak_angle_rad,
        slack,
    );
    if slack > 1e-10 {
        // Amplified rounding: only the stated error is promised.
        return;
    }
    assert_eq!(a.impacts, b.impacts, "{label}");
    for (x, y) in [
        (a.first_crossing_s, b.first_crossing_s),
        (a.first_release_s, b.first_release_s),
    ] {
        assert_eq!(x.is_some(), y.is_some(), "{label}");
        check_close(label, x.unwrap_or(0.0) * factor, y.unwrap_or(0.0), 1e-11);
    }
    for (x, y) in a.impact_list.iter().zip(&b.impact_list) {
        check_close(label, x[0] * factor, y[0], 1e-10);
    }
}

/// Nothing is tied to the samples: the same excitation cut into finer pieces gives the same
/// motion.
#[test]
fn verif_splitting_the_samples_changes_nothing() {
    for seed in 0..60 {
        let mut random = Random(seed);
        let design = random_design(&mut random);
        let record = random_signal(&mut random, 80, 10.0, 2000.0);
        for stop in [RIGID, SOFT] {
            let whole = replay(&record, &design, &options(stop));
            for parts in [2, 4, 8] {
                let pieces = replay(&split(&record, parts), &design, &options(stop));
                let label = format!("seed {seed} {} in {parts}", stop.name());
                check_same(&label, &pieces, &whole, 1.0);
            }
        }
    }
}

/// A record that starts elsewhere on the clock moves every instant along and nothing else.
#[test]
fn verif_the_start_on_the_clock_only_shifts_times() {
    for seed in 0..60 {
        let mut random = Random(seed);
        let design = random_design(&mut random);
        let record = random_signal(&mut random, 80, 10.0, 2000.0);
        let shifted = Signal {
            start_s: -0.25,
            ..record.clone()
        };
        for stop in [RIGID, SOFT] {
            let (here, there) = (
                replay(&record, &design, &options(stop)).run,
                replay(&shifted, &design, &options(stop)).run,
            );
            assert_eq!(here.peak_angle_rad, there.peak_angle_rad);
            assert_eq!(here.final_velocity_rad_s, there.final_velocity_rad_s);
            assert_eq!(here.work, there.work);
            check_close("time", there.peak_time_s + 0.25, here.peak_time_s, 1e-15);
            assert_eq!(
                here.first_release_s.is_some(),
                there.first_release_s.is_some()
            );
        }
    }
}

/// Torque, inertia, damping and stiffness doubled together: the same motion, bit for bit;
/// and at twice the pace with a quarter of the inertia.
#[test]
fn verif_scaled_levers_move_alike() {
    for seed in 0..60 {
        let mut random = Random(seed);
        let mut design = random_design(&mut random);
        design.stop.damping_n_s_per_m = 64.0;
        let record = random_signal(&mut random, 80, 10.0, 2000.0);
        let mut heavy = design.clone();
        heavy.lever.moment_of_inertia_kg_m2 *= 2.0;
        heavy.lever.pivot_damping_nm_s_per_rad *= 2.0;
        heavy.lever.spring_stiffness_nm_per_rad *= 2.0;
        heavy.lever.preload_torque_nm *= 2.0;
        heavy.lever.mass_kg *= 2.0;
        heavy.stop.stiffness_n_per_m *= 2.0;
        heavy.stop.damping_n_s_per_m *= 2.0;
        let mut quick = design.clone();
        quick.lever.moment_of_inertia_kg_m2 *= 0.25;
        quick.lever.pivot_damping_nm_s_per_rad *= 0.5;
        quick.stop.damping_n_s_per_m *= 0.5;
        let brief = signal(record.rate.hertz() * 2.0, record.samples.clone());
        for stop in [RIGID, SOFT] {
            let own = replay(&record, &design, &options(stop));
            let same = replay(&record, &heavy, &options(stop));
            assert_eq!(
                own.run.peak_angle_rad, same.run.peak_angle_rad,
                "seed {seed}"
            );
            assert_eq!(own.run.impact_list, same.run.impact_list);
            let faster = replay(&brief, &quick, &options(stop));
            let label = format!("seed {seed} {}", stop.name());
            // The bound of 1e-3 rad/s on counted impacts does not scale.
            check_close(
                &label,
                faster.run.peak_angle_rad,
                own.run.peak_angle_rad,
                1e-11_f64.max(2.0 * own.run.numerical_error_rad),
            );
        }
    }
}

/// Reading a record with the other polarity is reading its negative.
#[test]
fn verif_polarity_is_the_sign_of_the_samples() {
    for seed in 0..60 {
        let mut random = Random(seed);
        let design = random_design(&mut random);
        let record = random_signal(&mut random, 80, 10.0, 2000.0);
        let negative = Signal {
            samples: record.samples.iter().map(|a| -a).collect(),
            ..record.clone()
        };
        for stop in [RIGID, SOFT] {
            let positive = RunOptions {
                opens_when: OpensWhen::Positive,
                ..options(stop)
            };
            let mut one = replay(&record, &design, &positive);
            let other = replay(&negative, &design, &options(stop));
            one.run.opens_when = other.run.opens_when;
            assert_eq!(one, other, "seed {seed}");
        }
    }
}

/// The whole record drives the lever, only the window is judged.
#[test]
fn verif_the_window_judges_and_the_record_drives() {
    let design = Design::reference();
    let mut samples = vec![0.0; 3000];
    for (k, a) in samples.iter_mut().enumerate().take(110) {
        *a = -30.0 * STANDARD_GRAVITY * libm::sin(std::f64::consts::PI * k as f64 / 110.0);
    }
    let record = signal(10_000.0, samples);
    for stop in [RIGID, SOFT] {
        let whole = replay(&record, &design, &options(stop));
        let judged = |window| {
            replay(
                &record,
                &design,
                &RunOptions {
                    window: Some(window),
                    ..options(stop)
                },
            )
        };
        assert_eq!(judged((0, 2999)).run, whole.run);
        // Before the lever has reached the threshold.
        let early = judged((0, 80)).run;
        assert_eq!(early.first_crossing_s, None);
        assert!(early.peak_angle_rad < 0.1 && early.moving_at_end);
        // It rises still, so its last angle is the largest.
        assert!(early.final_velocity_rad_s > 0.0 && early.peak_angle_rad > 0.0);
        assert_eq!(early.peak_angle_rad, early.final_angle_rad);
        let reached = early.coast_peak_angle_rad.unwrap();
        assert!(reached > early.peak_angle_rad);
        // Opened while above it: the crossing is the window's start.
        let late = judged((300, 1000)).run;
        assert_eq!(late.first_crossing_s, Some(record.time_s(300)));
        assert_eq!(late.first_release_s, whole.run.first_release_s);
        assert_eq!(late.peak_angle_rad, whole.run.peak_angle_rad);
        // After the peak: the angle at the window's start is the largest in it.
        let after = judged((900, 1000)).run;
        assert_eq!(after.peak_time_s, record.time_s(900));
        assert!(after.peak_angle_rad < whole.run.peak_angle_rad);
        assert!(after.time_above_threshold_s <= 0.01 + 1e-15);
        // A window of one sample.
        let instant = judged((900, 900)).run;
        assert_eq!(instant.peak_angle_rad, after.peak_angle_rad);
        assert_eq!(instant.time_above_threshold_s, 0.0);
    }
}

/// A later maximum that is lower by less than its error may be the true peak, so the error of the peak reaches as far.
/// Here the first is the start, exactly known, and the later one that of a push after an impact.
#[test]
fn verif_the_error_of_a_peak_covers_a_less_certain_maximum() {
    const START_RAD: f64 = 0.15;
    const PARTED_AT: usize = 300;
    for stop in [RIGID, SOFT] {
        let judged = |height_m_s2: f64, first: usize| {
            let push = |k: usize| match k.checked_sub(800) {
                Some(k) if k < 50 => {
                    -height_m_s2 * libm::sin(std::f64::consts::PI * k as f64 / 50.0)
                }
                _ => 0.0,
            };
            let options = RunOptions {
                window: Some((first, 1999)),
                ..from(stop, START_RAD, 0.0)
            };
            let record = signal(10_000.0, (0..2000).map(push).collect());
            replay(&record, &Design::reference(), &options).run
        };
        let height = bisect(0.0, 1000.0, |height| {
            let later = judged(height, PARTED_AT);
            START_RAD - later.peak_angle_rad - 0.5 * later.numerical_error_rad
        });
        let later = judged(height, PARTED_AT);
        let whole = judged(height, 0);
        assert!(later.peak_angle_rad < START_RAD);
        assert_eq!((whole.peak_angle_rad, whole.peak_time_s), (START_RAD, 0.0));
        let highest_rad = later.peak_angle_rad + later.numerical_error_rad;
        assert!(highest_rad > START_RAD + 1e-15);
        // All but what the two sums round.
        let error_rad = highest_rad - START_RAD;
        check_close("error", whole.numerical_error_rad, error_rad, 1e-16);
    }
}

/// Exceeded means more than the threshold: reaching it is not enough.
#[test]
fn verif_the_threshold_is_exceeded_strictly() {
    let mut design = Design::reference();
    let record = quiet(10_000.0, 0.2);
    let start = from(RIGID, 0.0, 3.0);
    let peak = replay(&record, &design, &start).run.peak_angle_rad;
    for (threshold, exceeded) in [
        (peak, false),
        (peak * (1.0 + 1e-15), false),
        (peak * (1.0 - 1e-13), true),
    ] {
        design.criterion.threshold_rad = threshold;
        let run = replay(&record, &design, &start).run;
        assert_eq!(run.first_crossing_s.is_some(), exceeded, "{threshold}");
    }
    // Starting on the threshold: the crossing is at once if the lever rises.
    design.criterion.threshold_rad = 0.1;
    let rising = replay(&record, &design, &from(RIGID, 0.1, 1.0)).run;
    check_close("crossing", rising.first_crossing_s.unwrap(), 0.0, 1e-15);
    let falling = replay(&record, &design, &from(RIGID, 0.1, -1.0)).run;
    assert_eq!(falling.first_crossing_s, None);
}

/// The time above the threshold and the first crossing, against the closed form of two
/// flights.
#[test]
fn val_time_above_the_threshold() {
    let mut design = Design::reference();
    design.criterion.threshold_rad = 0.08;
    let record = quiet(10_000.0, 0.3);
    let run = replay(&record, &design, &from(RIGID, 0.0, 8.0)).run;
    let (mut time, mut velocity, mut above, mut first) = (0.0, 8.0, 0.0, None);
    while time < 0.3 {
        let flight = Oscillator::new(&design, false, 0.0, velocity);
        let (top, landing) = (flight.top(), flight.landing());
        if flight.angle(top) > 0.08 {
            let up = bisect(0.0, top, |t| 0.08 - flight.angle(t));
            let down = bisect(top, landing, |t| flight.angle(t) - 0.08);
            first = first.or(Some(time + up));
            above += (time + down).min(0.3) - (time + up).min(0.3);
        }
        time += landing;
        velocity = -design.stop.restitution * flight.velocity(landing);
    }
    check_close(
        "first crossing",
        run.first_crossing_s.unwrap(),
        first.unwrap(),
        1e-13,
    );
    check_close("time above", run.time_above_threshold_s, above, 1e-12);
}

/// A looser tolerance costs accuracy in proportion, and the stated error says so.
#[test]
fn verif_a_looser_tolerance_is_covered_by_the_stated_error() {
    let design = Design::reference();
    // One run may meet other events with another tolerance: the work is that of all.
    let mut work = [[0; 4]; 2];
    for seed in 0..20 {
        let mut random = Random(seed);
        let record = random_signal(&mut random, 80, 50.0, 2000.0);
        for (stop, work) in [RIGID, SOFT].into_iter().zip(&mut work) {
            let exact = replay(&record, &design, &options(stop)).run;
            work[0] += exact.work.rhs;
            for (tolerance, work) in [1e-12, 1e-9, 1e-6].into_iter().zip(&mut work[1..]) {
                let loose = replay(
                    &record,
                    &design,
                    &RunOptions {
                        tolerance_rad: Some(tolerance),
                        ..options(stop)
                    },
                )
                .run;
                let off = (loose.peak_angle_rad - exact.peak_angle_rad).abs();
                assert!(
                    off <= loose.numerical_error_rad + exact.numerical_error_rad,
                    "seed {seed} {} {tolerance:e}: {off:e} stated {:e}",
                    stop.name(),
                    loose.numerical_error_rad
                );
                *work += loose.work.rhs;
            }
        }
    }
    for of_stop in work {
        assert!(of_stop.is_sorted_by(|a, b| a >= b), "{of_stop:?}");
    }
}

// The fixed-step method of the paper.

fn fixed(stop: StopModel, initial: Option<State>, steps_per_period: u32) -> RunOptions {
    RunOptions {
        initial,
        method: Method::Rk4 { steps_per_period },
        trace: false,
        ..options(stop)
    }
}

/// Angle at the end of a smooth flight by the fixed-step method, against the event-driven one.
#[test]
fn verif_the_fixed_step_is_of_fourth_order_in_smooth_flight() {
    let design = Design::reference();
    // Linear excitation without a kink, the lever never near the stop.
    let ramp = signal(100.0, (0..6).map(|k| -4.0 - f64::from(k)).collect());
    let start = Some(State::new(1.0, 10.0));
    let exact = replay(
        &ramp,
        &design,
        &RunOptions {
            initial: start,
            ..options(RIGID)
        },
    )
    .run;
    let mut last: Option<f64> = None;
    for n in [32, 64, 128, 256] {
        let run = replay(&ramp, &design, &fixed(RIGID, start, n)).run;
        let error = (run.final_angle_rad - exact.final_angle_rad).abs();
        if let Some(last) = last {
            let order = (last / error).log2();
            assert!((3.6..4.6).contains(&order), "N {n}: order {order}");
        }
        last = Some(error);
    }
}

/// With impacts on its own grid it is of first order, whatever its stages: halving the step
/// halves the error on average.
#[test]
fn verif_the_fixed_step_is_of_first_order_over_impacts() {
    let design = Design::reference();
    let record = quiet(1000.0, 0.4);
    let start = Some(State::new(0.5, 0.0));
    let exact = replay(
        &record,
        &design,
        &RunOptions {
            initial: start,
            ..options(RIGID)
        },
    )
    .run;
    let mean = |n: u32| -> f64 {
        (0..16)
            .map(|k| {
                let steps = n + n * k / 32;
                let run = replay(&record, &design, &fixed(RIGID, start, steps)).run;
                (run.impact_list[2][0] - exact.impact_list[2][0]).abs()
            })
            .sum::<f64>()
            / 16.0
    };
    let errors: Vec<f64> = [1000, 4000, 16_000].into_iter().map(mean).collect();
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2() / 2.0;
        assert!((0.6..1.4).contains(&order), "order {order} of {errors:?}");
    }
}

/// N = 1000 steps in a period on the soft stop: ω_R·step = 3.33 lies beyond 2√2, the lever
/// gains energy from nothing; N = 10 000 does not.
#[test]
fn verif_the_fixed_step_gains_energy_on_a_stop_too_stiff_for_it() {
    let design = Design::reference();
    let record = quiet(1000.0, 0.5);
    let start = State::new(0.5, 0.0);
    let initial = energy_j(&design, SOFT, start.angle_rad, start.velocity_rad_s);
    let coarse = replay(&record, &design, &fixed(SOFT, Some(start), 1000)).run;
    let fastest = coarse
        .impact_list
        .iter()
        .map(|hit| 0.5 * design.lever.moment_of_inertia_kg_m2 * hit[1] * hit[1])
        .fold(0.0, f64::max);
    assert!(
        fastest > 4.0 * initial,
        "energy {fastest:e} J after {initial:e} J"
    );
    let fine = replay(&record, &design, &fixed(SOFT, Some(start), 10_000)).run;
    // The first rebound, after the impact at 59.5 ms: by the square of a speed that the grid
    // gives back up to 1.1 % wrong.
    let rebound = |options: RunOptions| {
        let window = Some((65, record.samples.len() - 1));
        let options = RunOptions { window, ..options };
        replay(&record, &design, &options).run.peak_angle_rad
    };
    let grid = rebound(fixed(SOFT, Some(start), 10_000));
    let right = rebound(from(SOFT, 0.5, 0.0));
    let off = (grid / right - 1.0).abs();
    assert!((1e-4..0.03).contains(&off), "{grid} where {right} is right");
    let energy = energy_j(
        &design,
        SOFT,
        fine.final_angle_rad,
        fine.final_velocity_rad_s,
    );
    assert!(energy < initial);
}

/// A lever that starts on the stop and is thrown off it at once is released at once: by its own
/// rebound, or by a torque that opens from the first sample on.
#[test]
fn regress_a_release_at_the_first_instant_is_told() {
    let design = Design::reference();
    let quiet = quiet(10_000.0, 0.05);
    let rebound = replay(&quiet, &design, &from(RIGID, 0.0, -3.0)).run;
    assert_eq!(rebound.first_release_s, Some(quiet.start_s));
    let mut opening = quiet;
    opening.samples.fill(-5.0 * STANDARD_GRAVITY);
    for stop in [RIGID, SOFT] {
        let run = replay(&opening, &design, &from(stop, 0.0, 0.0)).run;
        assert_eq!(run.first_release_s, Some(opening.start_s), "{stop:?}");
    }
}

/// A stop that returns all speed, and nothing that damps: the energy after 842 impacts is that at the start.
#[test]
fn verif_a_stop_that_returns_all_speed_keeps_the_energy() {
    const IMPACTS: u64 = 842;
    let mut design = Design::reference();
    design.stop.restitution = 1.0;
    design.lever.pivot_damping_nm_s_per_rad = 0.0;
    let energy = |angle: f64, velocity: f64| {
        let lever = &design.lever;
        0.5 * lever.moment_of_inertia_kg_m2 * velocity * velocity
            + lever.preload_torque_nm * angle
            + 0.5 * lever.spring_stiffness_nm_per_rad * angle * angle
    };
    let free = |seconds: f64| {
        let rate = 1000.0;
        let signal = signal(rate, vec![0.0; (seconds * rate) as usize + 2]);
        let options = RunOptions {
            initial: Some(State::new(0.4, 0.0)),
            ..RunOptions::new(StopModel::Rigid, OpensWhen::Negative)
        };
        latchgate_kernel::replay::run(&signal, &design, &options)
            .unwrap()
            .run
    };
    let few = free(2.0).impact_list;
    let period = few[1][0] - few[0][0];
    let run = free(few[0][0] + (IMPACTS as f64 - 0.6) * period);
    assert_eq!(run.impacts, IMPACTS);
    let start = energy(0.4, 0.0);
    let end = energy(run.final_angle_rad, run.final_velocity_rad_s);
    assert!(
        (end / start - 1.0).abs() <= 1e-13,
        "{:e}",
        end / start - 1.0
    );
    // The first 200 are listed: each as fast as the first.
    for impact in &run.impact_list {
        assert!((impact[1] / few[0][1] - 1.0).abs() <= 1e-13, "{impact:?}");
    }
}
