//! Guards the size of the interpolation error, part by part, against replays of every reading:
//!
//! - the change by cubics plus the largest change by corners, of the peak in the window or of that in window
//!   and coast, whichever changes more;
//! - corners of two sensors to the same side and to opposite sides;
//! - three times the range of all peaks where a reading has other impacts before its peak, or its peak more
//!   than two sample intervals away;
//! - twice the deviation by a noise as strong as what cubics leave out.
//!
//! And the noise of two sensors, each by its weight. Each scene runs on both stops and mirrored. The corners'
//! trace itself is guarded in `interpolation::corners`.

use super::*;
use latchgate_kernel::model::vector::Vector;
use latchgate_kernel::replay::State;
use latchgate_kernel::signal::Projection;
use latchgate_verdict::in_plane::InPlane;

const STOPS: [StopModel; 2] = [StopModel::Rigid, StopModel::Soft];
const SIGNS: [OpensWhen; 2] = [OpensWhen::Negative, OpensWhen::Positive];

/// How often the trace of corners is added to the samples.
const TRACES: [f64; 4] = [-2.0, -1.0, 1.0, 2.0];

/// A recording and the lever that it drives from rest at an angle of zero.
struct Scene {
    recording: Conditioned,
    design: Design,
    stop: StopModel,
    opens_when: OpensWhen,
    /// First and last judged sample.
    window: Option<(usize, usize)>,
}

/// What a replay of one reading leads to.
#[derive(Debug, Clone, Copy)]
struct Replayed {
    peak_rad: f64,
    /// The larger of peak and coast [rad].
    highest_rad: f64,
    peak_s: f64,
    impacts_before: usize,
}

impl Replayed {
    fn change_rad(&self, other: &Self) -> f64 {
        let in_window = (self.peak_rad - other.peak_rad).abs();
        in_window.max((self.highest_rad - other.highest_rad).abs())
    }

    fn has_course_of(&self, other: &Self) -> bool {
        let apart_s = (self.peak_s - other.peak_s).abs();
        self.impacts_before == other.impacts_before && apart_s <= 2e-4
    }
}

/// What the replays of all readings say of a peak's error [rad].
#[derive(Debug, Clone, Copy)]
struct Expected {
    /// The change by cubics plus the largest by corners.
    by_changes: f64,
    /// The largest change by corners of two sensors to opposite sides, and to the same side.
    by_opposed: f64,
    by_corners: f64,
    /// Range of the peaks, in the window or with the coast.
    range: f64,
    /// Largest move of the peak in time by a reading with the same impacts before it [s].
    moved_s: f64,
    /// A reading comes to its peak another way.
    differs: bool,
    /// Twice the deviation by a noise as strong as what cubics leave out.
    by_noise: f64,
}

impl Expected {
    fn error_rad(&self) -> f64 {
        let least = if self.differs { 3.0 * self.range } else { 0.0 };
        self.by_changes.max(least) + self.by_noise
    }
}

impl Scene {
    /// Of one sensor whose acceleration is `along_g(t)` where a negative one opens.
    fn new(along_g: impl Fn(f64) -> f64, stop: StopModel, opens_when: OpensWhen) -> Self {
        let signal = samples(|t| opens_when.sign() * along_g(t));
        Self {
            recording: as_recorded(signal),
            design: with_certain_bias(0.1),
            stop,
            opens_when,
            window: None,
        }
    }

    /// Returns the reading of each sensor's samples, one beside the other.
    fn joined<'s>(&self, signal: impl Fn(&Conditioned) -> Signal) -> Reading<'s> {
        let readings = self
            .recording
            .sensors()
            .map(|sensor| between::read(Cow::Owned(signal(sensor)), Between::BandLimited).unwrap());
        readings
            .reduce(|first, second| first.beside(second).unwrap())
            .unwrap()
    }

    fn options(&self) -> RunOptions {
        let projection = match self.recording.second {
            Some(_) => InPlane::of(&self.design.lever)
                .unwrap()
                .projection(self.opens_when),
            None => RunOptions::new(self.stop, self.opens_when).projection,
        };
        RunOptions {
            initial: Some(State::new(0.0, 0.0)),
            window: self.window,
            projection,
            ..RunOptions::new(self.stop, self.opens_when)
        }
    }

    fn replayed(&self, reading: &Reading<'_>) -> Replayed {
        let run = replay::run(reading, &self.design, &self.options())
            .unwrap()
            .run;
        let before = |impact: &&[f64; 2]| impact[0] <= run.peak_time_s;
        let coast_rad = run.coast_peak_angle_rad.unwrap_or(0.0);
        Replayed {
            peak_rad: run.peak_angle_rad,
            highest_rad: run.peak_angle_rad.max(coast_rad),
            peak_s: run.peak_time_s,
            impacts_before: run.impact_list.iter().filter(before).count(),
        }
    }

    /// Returns what so many times the trace of corners makes of the readings; that of the second sensor by
    /// `second_sign`.
    fn with_corners(&self, times: f64, second_sign: f64) -> Replayed {
        let trace = self.joined(|sensor| conditioning::corner_trace(sensor).unwrap());
        let trace = trace.with_second_scaled(second_sign, 0.0);
        let quintic = self.joined(|sensor| sensor.used.clone());
        self.replayed(&quintic.plus(times, &trace))
    }

    /// Returns the weight of each sensor in an acceleration along the lever's way, at most, up to the limit.
    fn weights(&self) -> [f64; 2] {
        if self.recording.second.is_none() {
            return [1.0, 0.0];
        }
        let Projection { tangential, radial } = self.options().projection;
        let sine = self.design.criterion.threshold_rad.sin();
        [0, 1].map(|sensor| tangential[sensor].hypot(sine * radial[sensor]))
    }

    /// Returns the white noise along the lever's way of white noises of the sensors [m/s²].
    fn weighted(&self, noises_m_s2: [f64; 2]) -> f64 {
        let [first, second] = self.weights();
        (first * noises_m_s2[0]).hypot(second * noises_m_s2[1])
    }

    /// Returns how far quintics are from cubics, sensor by sensor [m/s²].
    fn left_out_m_s2(&self) -> [f64; 2] {
        let mut left_out = self
            .recording
            .sensors()
            .map(|sensor| left_out_m_s2(&sensor.used));
        [0, 1].map(|_| left_out.next().unwrap_or(0.0))
    }

    /// Returns the deviation of the peak by a white noise along the lever's way, to first order [rad].
    fn deviation_rad(&self, noise_m_s2: f64) -> f64 {
        let options = RunOptions {
            noise_m2_s3: Some(noise_m_s2 * noise_m_s2 / self.recording.used.rate.hertz()),
            ..self.options()
        };
        let quintic = self.joined(|sensor| sensor.used.clone());
        let outcome = replay::run(&quintic, &self.design, &options).unwrap();
        outcome.deviation_rad.unwrap()
    }

    fn expected(&self) -> Expected {
        let quintic = self.joined(|sensor| sensor.used.clone());
        let nominal = self.replayed(&quintic);
        let cubic = self.replayed(&quintic.cubic());
        let corners = |second_sign: f64| TRACES.map(|times| self.with_corners(times, second_sign));
        let (same_side, mut opposed) = (corners(1.0), Vec::new());
        if self.recording.second.is_some() {
            opposed.extend(corners(-1.0));
        }
        let largest = |all: &[Replayed]| {
            let changes = all.iter().map(|one| one.change_rad(&nominal));
            changes.fold(0.0, f64::max)
        };
        let (by_corners, by_opposed) = (largest(&same_side), largest(&opposed));
        let all = || {
            let corners = same_side.iter().chain(&opposed);
            corners.chain([&nominal, &cubic])
        };
        let range = |angle: fn(&Replayed) -> f64| {
            let largest = all().map(angle).fold(f64::MIN, f64::max);
            largest - all().map(angle).fold(f64::MAX, f64::min)
        };
        Expected {
            by_changes: cubic.change_rad(&nominal) + by_corners.max(by_opposed),
            by_opposed,
            by_corners,
            range: range(|one| one.peak_rad).max(range(|one| one.highest_rad)),
            moved_s: all()
                .filter(|one| one.impacts_before == nominal.impacts_before)
                .map(|one| (one.peak_s - nominal.peak_s).abs())
                .fold(0.0, f64::max),
            differs: !all().all(|one| one.has_course_of(&nominal)),
            by_noise: 2.0 * self.deviation_rad(self.weighted(self.left_out_m_s2())),
        }
    }

    fn judged(&self) -> Assessment {
        let time_s = |index: usize| self.recording.used.time_s(index);
        let policy = Policy {
            initial_angle_rad: Some(0.0),
            window_s: self
                .window
                .map(|(first, last)| Window::new(time_s(first), time_s(last))),
            ..options(
                ModelChoice::Only(self.stop),
                Polarity::Declared(self.opens_when),
            )
        };
        assess(&self.recording, &[], &self.design, &policy).unwrap()
    }

    /// The stated error is the expected one.
    #[track_caller]
    fn check(&self, expected: &Expected) {
        let stated = self.judged().answers[0].interpolation_error_rad.unwrap();
        let error = expected.error_rad();
        assert!(
            (stated - error).abs() <= 1e-6 * error,
            "{:?} {:?}: {stated:e} stated, {error:e} by {expected:?}",
            self.stop,
            self.opens_when
        );
    }
}

/// Each scene on both stops, and mirrored.
fn scenes(along_g: impl Fn(f64) -> f64) -> Vec<Scene> {
    let cases = STOPS
        .iter()
        .flat_map(|stop| SIGNS.map(|sign| (*stop, sign)));
    cases
        .map(|(stop, sign)| Scene::new(&along_g, stop, sign))
        .collect()
}

/// A judged window that ends while the lever still rises: the error is that of the coast, many times that of
/// the peak in the window.
#[test]
fn verif_the_error_between_samples_is_that_of_the_coast_as_well() {
    let push = |t: f64| half_sine(t, 0.0, 0.005, -7.0);
    for mut scene in scenes(push) {
        for end_ms in [3.0, 4.5, 7.0] {
            let last = 500 + (10.0 * end_ms) as usize;
            scene.window = Some((0, last));
            let quintic = scene.joined(|sensor| sensor.used.clone());
            let nominal = scene.replayed(&quintic);
            assert!(nominal.highest_rad > 1.5 * nominal.peak_rad, "{nominal:?}");
            let in_window = TRACES
                .map(|times| (scene.with_corners(times, 1.0).peak_rad - nominal.peak_rad).abs());
            let expected = scene.expected();
            let largest = in_window.into_iter().fold(0.0, f64::max);
            assert!(
                expected.by_corners > 1.5 * largest,
                "{expected:?} {largest}"
            );
            assert!(!expected.differs);
            scene.check(&expected);
        }
    }
}

/// Returns the acceleration of a smooth push and of a later one with jumps, so high that the second peak is a
/// little lower than the first on the samples, and higher with twice the trace of its jumps.
fn pushes_that_come_close(
    first: impl Fn(f64) -> f64 + Copy,
    second: impl Fn(f64) -> f64 + Copy,
    parted_at: usize,
    design: &Design,
    stop: StopModel,
) -> impl Fn(f64) -> f64 {
    let along_g = move |height_g: f64| move |t: f64| first(t) + height_g * second(t);
    let peaks = |height_g: f64, times: f64| {
        [(0, parted_at), (parted_at, 3000)].map(|window| {
            let mut scene = Scene::new(along_g(height_g), stop, OpensWhen::Negative);
            scene.design = design.clone();
            scene.window = Some(window);
            // The later peak is the one after all that came before.
            let options = RunOptions {
                window: Some(window),
                ..scene.options()
            };
            let trace = scene.joined(|sensor| conditioning::corner_trace(sensor).unwrap());
            let reading = scene.joined(|sensor| sensor.used.clone());
            let run = replay::run(reading.plus(times, &trace), &scene.design, &options);
            run.unwrap().run.peak_angle_rad
        })
    };
    // Bisects the height at which the second peak falls short of the first by so much [rad].
    let height_g = |short_rad: f64| {
        let (mut low, mut high) = (0.0, 40.0);
        for _ in 0..40 {
            let height = f64::midpoint(low, high);
            let [first, second] = peaks(height, 0.0);
            if second < first - short_rad {
                low = height;
            } else {
                high = height;
            }
        }
        high
    };
    let level = height_g(0.0);
    let [_, nominal] = peaks(level, 0.0);
    let [_, raised] = peaks(level, -2.0);
    assert!(raised > nominal * 1.001, "{raised} {nominal}");
    along_g(height_g(0.3 * (raised - nominal)))
}

/// Where one reading comes to its peak another way, by more impacts or by a later peak of one flight, the
/// error is three times the range of all peaks.
#[test]
fn verif_differing_courses_count_three_times_the_range_of_their_peaks() {
    let haversine = |t: f64, start: f64, length: f64| half_sine(t, start, length, 1.0).powi(2);
    let block = |t: f64, start: f64, length: f64| -> f64 {
        if t >= start && t < start + length {
            -1.0
        } else {
            0.0
        }
    };
    let mut bouncing = with_certain_bias(0.1);
    bouncing.stop.restitution = 0.2;
    for stop in STOPS {
        // A second push once the lever is back at rest, and one that lifts it again before it is back.
        let apart = pushes_that_come_close(
            |t| -3.6 * haversine(t, 0.0, 0.01),
            |t| block(t, 0.15, 0.005),
            1950,
            &bouncing,
            stop,
        );
        let in_flight = pushes_that_come_close(
            |t| -3.6 * haversine(t, 0.0, 0.01),
            |t| block(t, 0.026, 0.003),
            745,
            &bouncing,
            stop,
        );
        let cases: [(&dyn Fn(f64) -> f64, bool); 2] = [(&apart, true), (&in_flight, false)];
        for (along_g, more_impacts) in cases {
            for sign in SIGNS {
                let mut scene = Scene::new(along_g, stop, sign);
                scene.design = bouncing.clone();
                let nominal = scene.replayed(&scene.joined(|sensor| sensor.used.clone()));
                let raised = scene.with_corners(-2.0 * sign.sign(), 1.0);
                assert_eq!(
                    raised.impacts_before > nominal.impacts_before,
                    more_impacts,
                    "{nominal:?} {raised:?}"
                );
                assert!(raised.peak_s > nominal.peak_s + 2e-3);
                let expected = scene.expected();
                assert!(expected.differs);
                assert!(
                    3.0 * expected.range > 1.5 * expected.by_changes,
                    "{expected:?}"
                );
                scene.check(&expected);
            }
        }
    }
}

/// A peak that a reading moves by two sample intervals is the same peak; one that it moves further is another.
#[test]
fn verif_a_peak_is_another_one_from_two_samples_on() {
    let (mut nearest_same_s, mut nearest_other_s) = (0.0_f64, f64::MAX);
    // The higher the push, the further do its corners move the peak: 15 and 17 g are where it is two intervals.
    for height_g in 14..20 {
        let push = |t: f64| half_sine(t, 0.0, 0.002, -f64::from(height_g));
        for scene in scenes(push) {
            let expected = scene.expected();
            scene.check(&expected);
            if expected.differs {
                nearest_other_s = nearest_other_s.min(expected.moved_s);
            } else {
                nearest_same_s = nearest_same_s.max(expected.moved_s);
            }
        }
    }
    // Heights were found to either side of two intervals.
    assert!(nearest_same_s > 1.85e-4, "{nearest_same_s:e}");
    assert!(nearest_other_s < 2.15e-4, "{nearest_other_s:e}");
}

/// A push along Y and a block along X, on a lever whose centre of mass lies 35° off the vehicle's length, so that
/// both drive it.
fn of_two_sensors(stop: StopModel, opens_when: OpensWhen, second_g: f64) -> Scene {
    let (sine, cosine) = f64::sin_cos(35.0_f64.to_radians());
    let mut scene = Scene::new(|t| half_sine(t, 0.0, 0.006, -4.0), stop, opens_when);
    scene.design.lever.axis = Some(Vector([0.0, 0.0, 1.0]));
    scene.design.lever.center_of_mass = Some(Vector([-0.065 * cosine, -0.065 * sine, 0.0]));
    let channel = |name: &str, values: Vec<f64>| Channel {
        name: name.into(),
        unit: Some(AccelerationUnit::MetrePerSecondSquared),
        unit_source: "option",
        stated: latchgate_recording::Stated::default(),
        start_s: -0.05,
        rate: SampleRate::from_hertz(10_000.0).unwrap(),
        values,
        findings: Vec::new(),
        pulse: None,
    };
    let across = samples(|t| {
        if (0.001..0.005).contains(&t) {
            second_g
        } else {
            0.0
        }
    });
    let conditioning_options = ConditioningOptions {
        bias: BiasWindow::None,
        filter: FilterChoice::None,
        synthetic: true,
        ..ConditioningOptions::default()
    };
    scene.recording = conditioning::with_second(
        scene.recording.clone(),
        &channel("acc_y", scene.recording.raw.samples.clone()),
        &channel("acc_x", across.samples),
        &conditioning_options,
    )
    .unwrap();
    scene
}

/// Corners of two sensors may fall to the same side or to opposite ones; which of the two moves the lever more
/// hangs on the sign by which the second sensor drives it.
#[test]
fn verif_corners_of_two_sensors_count_to_the_same_and_to_opposite_sides() {
    for stop in STOPS {
        let mut opposed_are_larger = 0;
        for opens_when in SIGNS {
            for second_g in [-0.4, 0.4] {
                let scene = of_two_sensors(stop, opens_when, second_g);
                let expected = scene.expected();
                assert!(!expected.differs, "{expected:?}");
                let (same_side, opposed) = (expected.by_corners, expected.by_opposed);
                assert!((same_side / opposed).ln().abs() > 0.1, "{expected:?}");
                opposed_are_larger += usize::from(opposed > same_side);
                scene.check(&expected);
            }
        }
        assert_eq!(opposed_are_larger, 2, "{stop:?}");
    }
}

/// The noise of each of two sensors counts by the part of it that drives the lever; that of a run that cannot
/// pass is carried along to first order.
#[test]
fn verif_the_noise_of_both_sensors_counts_by_their_weights() {
    for stop in STOPS {
        for opens_when in SIGNS {
            for deviations_m_s2 in [[0.0, 0.4], [0.4, 0.0], [0.4, 0.4], [0.2, 0.9]] {
                let mut scene = of_two_sensors(stop, opens_when, 3.0);
                scene.design.criterion.threshold_rad = 1e-4;
                let of_deviation = |deviation_m_s2| Noise {
                    deviation_m_s2,
                    ..Noise::default()
                };
                scene.recording.noise = of_deviation(deviations_m_s2[0]);
                let second = scene.recording.second.as_mut().unwrap();
                second.conditioned.noise = of_deviation(deviations_m_s2[1]);
                let stated = scene.judged().answers[0].noise_rad.unwrap();
                // It is carried together with what lies between the samples, and has its share of both.
                let [recorded, left_out] =
                    [deviations_m_s2, scene.left_out_m_s2()].map(|each| scene.weighted(each));
                let both = recorded.hypot(left_out);
                let expected = scene.deviation_rad(both) * recorded / both;
                assert!(expected > 1e-6, "{expected}");
                assert!(
                    (stated / expected - 1.0).abs() < 1e-9,
                    "{stop:?} {opens_when:?} {deviations_m_s2:?}: {stated:e} stated, {expected:e}"
                );
            }
        }
    }
}
