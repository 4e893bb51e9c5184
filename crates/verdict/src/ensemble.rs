//! The ensemble: levers and recordings scattered as far as design and input are uncertain.
//!
//! Independent normal draws truncated at three standard deviations, where the share that may open is
//! small not at all: scale and bias of the
//! recording, restitution and every key that the design gives a tolerance. Member 0 is the
//! nominal lever, and counts as a member. How many members cross the threshold is looked at a
//! few times, each time with bounds that allow for the other looks, until the rule decides.
//!
//! - `bounds`: bounds of a share from a count, and the looks that share their error;
//! - `draw`: draws: a counter-based generator and the truncated normal distribution;
//! - `drivers`: what drives the peak, and how it is spread.

pub mod bounds;
pub mod draw;
pub(super) mod drivers;

use super::Answer;
use super::decision::{ROUNDING_PART, ShareBounds};
use super::policy::Variant;
use super::wording::{degrees, percent, percent_bound};
pub use bounds::LOOKS;
use draw::TRUNCATION;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::catch::Catch;
use latchgate_kernel::model::criterion::Criterion;
use latchgate_kernel::model::lever::Lever;
use latchgate_kernel::model::parameters::{
    CATCH_PARAMETERS, Condition, DesignParameter, PARAMETERS, Slot,
};
use latchgate_kernel::model::stop::{Stop, StopModel};
use latchgate_kernel::replay::MethodKind;
use latchgate_kernel::replay::batch::{Member, SensorView};
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY};
use latchgate_recording::error::Error;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Largest ensemble that may be asked for.
pub const MEMBERS_MAX: u32 = 1_000_000;

/// Returns the looks at an ensemble of at most `members`: those of [`LOOKS`] below it, at most
/// three, and itself.
///
/// An ensemble beyond 10 000 takes its last look there instead, so that there are never more
/// than the four looks that the bounds allow for.
pub fn looks(members: u32) -> Vec<u32> {
    let mut looks: Vec<u32> = LOOKS[..3]
        .iter()
        .copied()
        .filter(|look| *look < members)
        .collect();
    if members > 0 {
        looks.push(members);
    }
    looks
}

/// Quantiles of the members' peak angle [rad].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PeakQuantiles {
    /// Five in a hundred stay below.
    pub p05: f64,
    /// The median.
    pub p50: f64,
    /// Five in a hundred go beyond.
    pub p95: f64,
    /// The largest.
    pub max: f64,
}

/// The correlation of one scattered parameter with the peak.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Driver {
    /// Design key of the parameter.
    pub parameter: Cow<'static, str>,
    /// One standard deviation of it, in the key's unit.
    pub standard_deviation: f64,
    /// Spearman's rank correlation of its draws with the peak [-]; `None` if either does not
    /// vary.
    pub rank_correlation: Option<f64>,
    /// Its square by the sum of all squares [-].
    pub share: Option<f64>,
    /// What the rule says of the members alone whose draw a quarter of the standard deviation could give as well.
    pub answer_if_known: Answer,
}

/// What differs from member to member.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Varied {
    /// Numbers of the lever, its stop or its catch, and how the recording reads.
    LeversAndReadings,
    /// Numbers of the lever, its stop or its catch alone.
    Levers,
    /// How the recording reads: scale and bias of its sensors. The lever is one.
    Readings,
}

impl Varied {
    /// Names a number of members: `varied levers`, or `readings of this recording`.
    pub fn members(self) -> &'static str {
        match self {
            Self::LeversAndReadings | Self::Levers => "varied levers",
            Self::Readings => "readings of this recording",
        }
    }

    /// Names one of them.
    pub fn member(self) -> &'static str {
        match self {
            Self::LeversAndReadings | Self::Levers => "varied lever",
            Self::Readings => "reading of this recording",
        }
    }

    /// Names what the share is one of.
    pub fn whole(self) -> &'static str {
        match self {
            Self::LeversAndReadings => "levers and readings",
            Self::Levers => "levers",
            Self::Readings => "readings",
        }
    }
}

/// Why an ensemble ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum End {
    /// The rule decided.
    #[serde(rename = "decided")]
    Decided,
    /// All members were run, and the rule did not decide.
    #[serde(rename = "last look")]
    LastLook,
    /// Whatever more members would have said, the other stops and polarities had settled the
    /// answer.
    #[serde(rename = "could not change the answer")]
    NoMatter,
    /// The nominal lever's error forbids a pass, and the share is below what a fail needs.
    #[serde(rename = "the error forbids a pass")]
    NoPass,
    /// More members would have taken more steps than the limit `work` allows.
    #[serde(rename = "work limit")]
    WorkLimit,
}

/// The ensemble of one stop and polarity: how many of its levers cross, and how their peaks spread.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Ensemble {
    /// Stop model.
    pub model: StopModel,
    /// Sign of the recorded acceleration that opens.
    pub opens_when: OpensWhen,
    /// Members that were run, the nominal one included.
    pub members: u32,
    /// Members whose peak exceeds the threshold.
    pub exceeded: u32,
    /// Members that could not be followed: the upper bound counts them as exceeding, the lower
    /// one as not exceeding.
    pub failed_to_run: u32,
    /// What differs from member to member.
    pub varied: Varied,
    /// Seed of the draws.
    pub seed: u64,
    /// Generator of the draws.
    pub generator: Cow<'static, str>,
    /// Integrator of the members.
    pub method: MethodKind,
    /// The look at which it ended, counted from 1.
    pub look: usize,
    /// Why it ended there.
    pub ended: End,
    /// Confidence of each of the two bounds at each look [-].
    pub confidence: f64,
    /// One-sided lower bound of the share that exceeds the threshold [-].
    pub p_lower: f64,
    /// One-sided upper bound of that share [-].
    pub p_upper: f64,
    /// Members that exceed the threshold only in the coast after the last judged sample.
    pub exceeded_in_coast: u32,
    /// As `p_upper`, of the levers that exceed it in the window or in that coast [-]; this one
    /// decides about a pass.
    pub p_upper_with_coast: f64,
    /// Share that a pass allows [-].
    pub open_share: f64,
    /// Quantiles of the peak [rad]; `None` if no member could be followed.
    pub peak_angle_rad: Option<PeakQuantiles>,
    /// The last instant judged, where a fault ends the samples that the ensemble rests on [s].
    pub judged_until_s: Option<f64>,
    /// Rank correlation beyond which a parameter drives the peak by more than chance [-]:
    /// 1.96/√(members − 1).
    pub rank_correlation_by_chance: Option<f64>,
    /// What drives the peak, the strongest first.
    pub drivers: Vec<Driver>,
}

impl Ensemble {
    /// Returns the variant that was sampled.
    pub fn variant(&self) -> Variant {
        Variant {
            opens_when: self.opens_when,
            model: self.model,
        }
    }

    /// Works out how the peaks of its members are spread and what drives them; `answer` is what the rule says
    /// of a share.
    pub(super) fn spread(
        &mut self,
        scatter: &Scatter,
        members: &MemberPeaks,
        threshold_rad: f64,
        answer: impl Fn(ShareBounds) -> Answer,
    ) {
        /// Where the draws of a quarter of the standard deviation end [standard deviations]. Within it these are
        /// closer to the middle than the members that are counted, which so are the harder case.
        const QUARTER_END: f64 = 0.25 * TRUNCATION;
        let peaks = members.window_rad.as_slice();
        self.peak_angle_rad = drivers::quantiles(peaks);
        self.drivers = drivers::drivers(peaks, &scatter.parameters, |member, parameter| {
            let member = u32::try_from(member).unwrap_or(u32::MAX);
            scatter.draw(member, &scatter.parameters[parameter])
        });
        for driver in &mut self.drivers {
            let mut parameters = scatter.parameters.iter();
            let parameter = parameters.find(|parameter| parameter.name == driver.parameter);
            let near = members.filtered(|member| {
                parameter.is_some_and(|own| scatter.draw(member, own).abs() <= QUARTER_END)
            });
            driver.answer_if_known = answer(near.count(threshold_rad).share(&scatter.criterion));
        }
    }

    /// Says what share of levers and readings opens, as the bounds have it: what a pass rests on, a fail, or both
    /// bounds: `fewer than 3.4 % of levers and readings, at 98.75 % confidence`.
    pub fn share_that_opens(&self, answer: Answer) -> String {
        let whole = self.varied.whole();
        let confidence = percent(self.confidence);
        let most = percent_bound(self.p_upper, f64::ceil);
        let least = percent_bound(self.p_lower, f64::floor);
        match answer {
            Answer::Pass => format!("fewer than {most} % of {whole}, at {confidence} % confidence"),
            Answer::Fail => format!("more than {least} % of {whole}, at {confidence} % confidence"),
            Answer::Undecided | Answer::Unusable => {
                format!("{least} to {most} % of {whole}, each bound at {confidence} % confidence")
            }
        }
    }

    /// Says how many members open: `3 of 128 varied levers`.
    pub fn who_opens(&self) -> String {
        format!(
            "{} of {} {}",
            self.exceeded,
            self.members,
            self.varied.members()
        )
    }

    /// Says how many members could not be followed, and how they count in the bounds that an answer rests on; `None`
    /// if all could.
    pub fn lost_in_words(&self, answer: Answer) -> Option<String> {
        let counted = match answer {
            Answer::Pass => "as open",
            Answer::Fail => "as shut",
            Answer::Undecided | Answer::Unusable => {
                "as open in the upper bound and as shut in the lower"
            }
        };
        match self.failed_to_run {
            0 => None,
            1 => Some(format!("1 could not be followed and counts {counted}")),
            lost => Some(format!("{lost} could not be followed and count {counted}")),
        }
    }

    /// Says that rounding has lost the runs of this stop, and how its members count: where impacts have carried the
    /// rounding of its nominal run, `numerical_error_rad` [rad], to a part of the limit angle that a finding tells.
    pub fn rounding_in_words(
        &self,
        numerical_error_rad: f64,
        threshold_rad: f64,
    ) -> Option<String> {
        (numerical_error_rad > ROUNDING_PART * threshold_rad).then(|| {
            format!(
                "Impacts carry rounding to {} on the {} stop. Its {} {} count as computed: the confidence \
                 is that of the draws alone",
                degrees(numerical_error_rad, 2),
                self.model.name(),
                self.members,
                self.varied.members()
            )
        })
    }

    /// Returns the bounds of the share that exceeds the threshold.
    pub fn share(&self) -> ShareBounds {
        ShareBounds {
            lower: self.p_lower,
            upper: self.p_upper,
            upper_with_coast: self.p_upper_with_coast,
            allowed: self.open_share,
        }
    }
}

/// Members that exceed a threshold, and members that could not be followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Count {
    /// Members in all.
    pub members: u32,
    /// Of these, with a peak above the threshold.
    pub exceeded: u32,
    /// Of these, with a peak at or below it, but above it in the coast after the window.
    pub exceeded_in_coast: u32,
    /// Of these, not followed.
    pub failed_to_run: u32,
}

impl Count {
    /// Counts peaks [rad]; NaN is that of a member that was not followed, infinity that of one that is no lever.
    pub fn of(peaks: &[f64], threshold_rad: f64) -> Self {
        let number = |wanted: &dyn Fn(f64) -> bool| {
            u32::try_from(peaks.iter().filter(|peak| wanted(**peak)).count()).unwrap_or(u32::MAX)
        };
        Self {
            members: u32::try_from(peaks.len()).unwrap_or(u32::MAX),
            exceeded: number(&|peak| peak > threshold_rad),
            exceeded_in_coast: 0,
            failed_to_run: number(&f64::is_nan),
        }
    }

    /// Counts members as [`Self::of`] does, and those that exceed the threshold in the coast
    /// only. `highest` are the largest angles of window and coast [rad]; NaN where a coast was
    /// not followed.
    pub fn with_coast(peaks: &[f64], highest: &[f64], threshold_rad: f64) -> Self {
        let later = peaks.iter().zip(highest).filter(|(peak, highest)| {
            **peak <= threshold_rad && (highest.is_nan() || **highest > threshold_rad)
        });
        Self {
            exceeded_in_coast: u32::try_from(later.count()).unwrap_or(u32::MAX),
            ..Self::of(peaks, threshold_rad)
        }
    }

    /// Returns bounds of the share that exceeds the threshold, each at the confidence of a look, and the share that
    /// `criterion` allows; members that were not followed count against either answer.
    pub fn share(&self, criterion: &Criterion) -> ShareBounds {
        let confidence = bounds::look_confidence(criterion.confidence);
        let (members, exceeded) = (u64::from(self.members), u64::from(self.exceeded));
        let at_most = exceeded + u64::from(self.failed_to_run);
        let with_coast = at_most + u64::from(self.exceeded_in_coast);
        ShareBounds {
            lower: bounds::lower(exceeded, members, confidence),
            upper: bounds::upper(at_most, members, confidence),
            upper_with_coast: bounds::upper(with_coast, members, confidence),
            allowed: criterion.open_share,
        }
    }
}

/// One parameter that is scattered.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// Design key.
    pub name: &'static str,
    /// One standard deviation, in the key's unit.
    pub deviation: f64,
    /// Number of its stream.
    stream: u32,
    /// What moves with it in a member.
    target: Target,
}

impl Parameter {
    /// Returns whether it is a number of lever, stop or catch, and not of the sensors.
    pub fn is_of_lever(&self) -> bool {
        matches!(
            self.target,
            Target::Number(Slot::Lever(_) | Slot::Stop(_) | Slot::Catch(_))
        )
    }
}

/// What a draw moves.
#[derive(Debug, Clone, Copy)]
enum Target {
    /// A number of design or input.
    Number(Slot),
    /// The scale of the second in-plane sensor.
    SecondScale,
    /// Its bias.
    SecondBias,
}

/// Returns what is scattered, in the order that numbers the generator's streams.
fn scattered(design: &Design, bias_standard_error_m_s2: f64) -> Vec<Parameter> {
    let deviation = |parameter| {
        let stated = design.deviation(parameter).unwrap_or(0.0);
        match parameter.slot {
            Slot::InputBias => stated.max(bias_standard_error_m_s2 / STANDARD_GRAVITY),
            _ => stated,
        }
    };
    let mut parameters: Vec<Parameter> = design
        .parameters()
        .filter_map(|parameter| {
            Some(Parameter {
                name: parameter.name,
                deviation: deviation(parameter),
                stream: parameter.stream?,
                target: Target::Number(parameter.slot),
            })
        })
        .filter(|parameter| parameter.deviation > 0.0)
        .collect();
    parameters.sort_by_key(|parameter| parameter.stream);
    parameters
}

/// The scatter of design and input.
#[derive(Debug, Clone)]
pub struct Scatter {
    lever: Lever,
    stop: Stop,
    catch: Option<Catch>,
    criterion: Criterion,
    parameters: Vec<Parameter>,
    seed: u64,
}

/// Share of levers below which draws are not cut at [`TRUNCATION`] [-]: what is cut off, 0.27 % of each value, would
/// count beside it.
pub const WHOLE_DRAWS_BELOW: f64 = 0.02;

impl Scatter {
    /// Takes the scatter from a design; the bias's standard deviation is the larger of the
    /// design's and `bias_standard_error_m_s2`.
    ///
    /// # Errors
    ///
    /// As [`check`].
    pub fn new(design: &Design, bias_standard_error_m_s2: f64, seed: u64) -> Result<Self, Error> {
        check(design)?;
        Ok(Self {
            lever: design.lever,
            stop: design.stop,
            catch: design.catch,
            criterion: design.criterion,
            parameters: scattered(design, bias_standard_error_m_s2),
            seed,
        })
    }

    /// Takes the scatter of the recording's bias alone, whatever else the design scatters.
    pub(super) fn of_bias(design: &Design, bias_standard_error_m_s2: f64, seed: u64) -> Self {
        let scatter = Self {
            lever: design.lever,
            stop: design.stop,
            catch: design.catch,
            criterion: design.criterion,
            parameters: scattered(design, bias_standard_error_m_s2),
            seed,
        };
        scatter.bias_alone()
    }

    /// Leaves out what moves nothing at any of these stops: stiffness, damping and radius at the rigid one.
    pub(super) fn at(mut self, stops: &[StopModel]) -> Self {
        self.parameters.retain(|parameter| {
            DesignParameter::named(parameter.name).is_none_or(|of| of.counts_at(stops))
        });
        self
    }

    /// Leaves the scatter of the sensors' biases alone.
    pub(super) fn bias_alone(mut self) -> Self {
        self.parameters.retain(|parameter| {
            matches!(
                parameter.target,
                Target::Number(Slot::InputBias) | Target::SecondBias
            )
        });
        self
    }

    /// Adds the scatter of a second in-plane sensor, as uncertain as the first by the design; its bias's standard
    /// deviation is the larger of the design's and `bias_standard_error_m_s2`.
    pub fn with_second_sensor(mut self, design: &Design, bias_standard_error_m_s2: f64) -> Self {
        let parameter = |name, deviation, stream, target| Parameter {
            name,
            deviation,
            stream,
            target,
        };
        let bias_g = (design.input.bias_g).max(bias_standard_error_m_s2 / STANDARD_GRAVITY);
        let of_sensor = [
            parameter(
                "input.radial_scale",
                design.input.scale,
                23,
                Target::SecondScale,
            ),
            parameter("input.radial_bias_g", bias_g, 24, Target::SecondBias),
        ];
        let varied = of_sensor
            .into_iter()
            .filter(|parameter| parameter.deviation > 0.0);
        self.parameters.extend(varied);
        self
    }

    /// Returns what is scattered, in a fixed order.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// Returns what differs from member to member; `None` where nothing does.
    pub fn varied(&self) -> Option<Varied> {
        let of_lever = |parameter: &&Parameter| parameter.is_of_lever();
        let levers = self.parameters.iter().filter(of_lever).count();
        match (levers, self.parameters.len() - levers) {
            (0, 0) => None,
            (0, _) => Some(Varied::Readings),
            (_, 0) => Some(Varied::Levers),
            _ => Some(Varied::LeversAndReadings),
        }
    }

    /// Returns whether draws end at [`TRUNCATION`], so that there is a loosest lever.
    pub fn has_end(&self) -> bool {
        self.criterion.open_share >= WHOLE_DRAWS_BELOW
    }

    /// Returns member `index`'s draw of a parameter, in standard deviations [-]; 0 of member 0.
    pub fn draw(&self, index: u32, parameter: &Parameter) -> f64 {
        match index {
            0 => 0.0,
            _ if self.has_end() => draw::truncated_normal(self.seed, index, parameter.stream),
            _ => draw::normal(self.seed, index, parameter.stream),
        }
    }

    /// Returns false where draws that do not end give member `index` numbers that no lever has: it counts as open.
    pub(super) fn is_lever(&self, index: u32) -> bool {
        if self.has_end() {
            return true;
        }
        let drawn = self.shifted(|parameter| self.draw(index, parameter));
        // A restitution drawn beyond 0 or 1 is held there.
        let is_possible = |parameter: &DesignParameter, value: f64| match parameter.condition {
            Condition::Ratio => value.is_finite(),
            condition => condition.check(parameter.name, value).is_ok(),
        };
        let is_good = |parameter: &DesignParameter| match (parameter.slot, drawn.catch) {
            (Slot::Lever(field), _) => {
                let value = *field(&mut { drawn.lever });
                let keeps_sign = value * *field(&mut { self.lever }) >= 0.0;
                keeps_sign && is_possible(parameter, value)
            }
            (Slot::Stop(field), _) => is_possible(parameter, *field(&mut { drawn.stop })),
            (Slot::Catch(field), Some(mut catch)) => is_possible(parameter, *field(&mut catch)),
            _ => true,
        };
        let mut parameters = PARAMETERS.iter().chain(CATCH_PARAMETERS);
        let engages = drawn.catch.is_none_or(|catch| {
            catch.engagement_angle_rad > 0.0
                && catch.end_stop_angle_rad > catch.engagement_angle_rad
        });
        let reads = |scale: f64, bias: f64| scale > 0.0 && scale.is_finite() && bias.is_finite();
        parameters.all(is_good)
            && engages
            && reads(drawn.scale, drawn.bias_m_s2)
            && reads(drawn.second.scale, drawn.second.bias_m_s2)
    }

    /// Returns a member; member 0 is the nominal lever on the recording as it is.
    pub fn member(&self, index: u32) -> Member {
        self.build(|parameter| self.draw(index, parameter))
    }

    /// Returns the nominal lever with one parameter moved by `deviations` of its own.
    pub fn moved(&self, name: &str, deviations: f64) -> Member {
        self.build(|parameter| {
            if parameter.name == name {
                deviations
            } else {
                0.0
            }
        })
    }

    /// As [`Self::member`], the nominal lever in place of one that is none.
    pub(super) fn lever(&self, index: u32) -> Member {
        self.member(if self.is_lever(index) { index } else { 0 })
    }

    /// Returns the lever that an acceleration of this sign opens most easily, every parameter where its
    /// draws end.
    pub fn loosest(&self, sign: f64) -> Member {
        self.build(|parameter| match parameter.name {
            "lever.mass_kg" | "input.scale" | "input.radial_scale" => TRUNCATION,
            "lever.center_of_mass_m" => self.lever.unbalance_sign() * TRUNCATION,
            "input.bias_g" => -sign * TRUNCATION,
            _ => -TRUNCATION,
        })
    }

    fn build(&self, deviations: impl Fn(&Parameter) -> f64) -> Member {
        let mut member = self.shifted(deviations);
        // A third of a value, taken off three times, may leave less than nothing by rounding,
        // and a restitution near 1 is drawn beyond it.
        for parameter in PARAMETERS.iter().chain(CATCH_PARAMETERS) {
            let value = match (parameter.slot, &mut member.catch) {
                (Slot::Lever(field), _) => field(&mut member.lever),
                (Slot::Stop(field), _) => field(&mut member.stop),
                (Slot::Catch(field), Some(catch)) => field(catch),
                (Slot::Catch(_), None) => continue,
                (Slot::InputScale | Slot::InputBias | Slot::Criterion(_), _) => continue,
            };
            *value = parameter.condition.hold(*value);
        }
        member.stop.follow_restitution(&self.stop, &self.lever);
        member
    }

    /// Returns the nominal lever with every parameter moved, whether a lever can have the numbers or not.
    fn shifted(&self, deviations: impl Fn(&Parameter) -> f64) -> Member {
        let mut member = Member {
            lever: self.lever,
            stop: self.stop,
            scale: 1.0,
            bias_m_s2: 0.0,
            second: SensorView::default(),
            catch: self.catch,
        };
        for parameter in &self.parameters {
            let shift = deviations(parameter) * parameter.deviation;
            let slot = match parameter.target {
                Target::Number(slot) => slot,
                Target::SecondScale => {
                    member.second.scale += shift;
                    continue;
                }
                Target::SecondBias => {
                    member.second.bias_m_s2 += shift * STANDARD_GRAVITY;
                    continue;
                }
            };
            match slot {
                Slot::Lever(field) => *field(&mut member.lever) += shift,
                Slot::Stop(field) => *field(&mut member.stop) += shift,
                Slot::Catch(field) => {
                    if let Some(catch) = &mut member.catch {
                        *field(catch) += shift;
                    }
                }
                Slot::InputScale => member.scale += shift,
                Slot::InputBias => member.bias_m_s2 += shift * STANDARD_GRAVITY,
                // It has no stream.
                Slot::Criterion(_) => {}
            }
        }
        member
    }
}

/// Checks that no draw within [`TRUNCATION`] leaves what is physical: three standard deviations below their nominal
/// value, what must be positive still is, and what must not be negative is not. A restitution
/// is held within 0 and 1 instead: a stop of R = 0.98 ± 0.01 is a sound design, and its draws
/// beyond 1 become the liveliest stop there is.
///
/// # Errors
///
/// [`OutOfRange`](latchgate_kernel::error::Error::OutOfRange), naming the tolerance.
pub fn check(design: &Design) -> Result<(), Error> {
    let scale = design.input.scale;
    if TRUNCATION * scale >= 1.0 {
        return Err(refused("input.scale", "less than 1/3", scale));
    }
    for parameter in design.parameters() {
        if !parameter.has_tolerance() || parameter.condition == Condition::Ratio {
            continue;
        }
        let nominal = design.value(parameter);
        let may_vanish = parameter.condition == Condition::NotNegative;
        let deviation = design.deviation(parameter).unwrap_or(0.0);
        // A third that is written with 16 digits may exceed a third by rounding.
        let least = match parameter.condition {
            Condition::NotZero => nominal.abs(),
            _ => nominal,
        } - TRUNCATION * deviation;
        let good = if may_vanish {
            least >= -1e-12 * nominal
        } else {
            least > 0.0
        };
        if !(good || deviation <= 0.0) {
            let expected = format!(
                "{} a third of the value itself, {nominal}: draws reach {TRUNCATION} standard \
                 deviations, and {}",
                if may_vanish { "at most" } else { "less than" },
                match parameter.condition {
                    Condition::NotNegative => "it cannot be negative",
                    Condition::NotZero => "its sign must stay",
                    _ => "it must stay positive",
                }
            );
            return Err(refused(
                &format!("tolerance.{}", parameter.tolerance_key()),
                &expected,
                deviation,
            ));
        }
    }
    check_engagement(design)
}

/// Checks that no drawn engagement angle lies beyond the drawn end stop of the catch.
fn check_engagement(design: &Design) -> Result<(), Error> {
    let Some(catch) = design.catch else {
        return Ok(());
    };
    let deviation = |name: &str| {
        let parameter = DesignParameter::named(name);
        let deviation = parameter.and_then(|parameter| design.deviation(parameter));
        deviation.unwrap_or(0.0)
    };
    let (engagement, end) = (
        deviation("catch.engagement_angle_rad"),
        deviation("catch.end_stop_angle_rad"),
    );
    let apart = catch.end_stop_angle_rad - catch.engagement_angle_rad;
    if engagement + end > 0.0 && TRUNCATION * (engagement + end) >= apart {
        return Err(refused(
            "tolerance.catch.engagement_angle_rad and tolerance.catch.end_stop_angle_rad",
            &format!(
                "together less than a third of {apart}, by which the two angles are apart: draws reach {TRUNCATION} standard deviations, and a catch must be able to engage"
            ),
            engagement + end,
        ));
    }
    Ok(())
}

fn refused(what: &str, expected: &str, found: f64) -> Error {
    Error::out_of_range(
        what,
        expected,
        format!(
            "{found}; give a smaller one, or judge the nominal lever with the setting `members` = 0"
        ),
    )
}

/// The peaks of members, in their order.
#[derive(Debug, Clone, Default)]
pub(super) struct MemberPeaks {
    /// Largest angle of each in the window [rad]; NaN if it could not be followed.
    pub(super) window_rad: Vec<f64>,
    /// Largest angle of each in the window or in the coast after it [rad]; NaN if it could not be
    /// followed.
    pub(super) highest_rad: Vec<f64>,
    /// When each first exceeds the threshold in the window [s]; NaN if it does not.
    pub(super) crossings_s: Vec<f64>,
}

impl MemberPeaks {
    /// Returns the peaks of those members for which `keeps` holds.
    fn filtered(&self, keeps: impl Fn(u32) -> bool) -> Self {
        let indices = (0..self.window_rad.len())
            .filter(|index| keeps(u32::try_from(*index).unwrap_or(u32::MAX)));
        let (window_rad, highest_rad) = indices
            .map(|index| (self.window_rad[index], self.highest_rad[index]))
            .unzip();
        Self {
            window_rad,
            highest_rad,
            crossings_s: Vec::new(),
        }
    }

    /// Counts the members that exceed the threshold.
    pub(super) fn count(&self, threshold_rad: f64) -> Count {
        Count::with_coast(&self.window_rad, &self.highest_rad, threshold_rad)
    }
}

/// Sums up the ensemble of one variant, which ended at the look `look`, counted from 1; how its
/// peaks are spread is left open.
pub(super) fn summarise(
    scatter: &Scatter,
    members: &MemberPeaks,
    threshold_rad: f64,
    Variant { opens_when, model }: Variant,
    (look, ended): (usize, End),
    judged_until_s: Option<f64>,
) -> Ensemble {
    let count = members.count(threshold_rad);
    let share = count.share(&scatter.criterion);
    Ensemble {
        model,
        opens_when,
        members: count.members,
        exceeded: count.exceeded,
        failed_to_run: count.failed_to_run,
        varied: scatter.varied().unwrap_or(Varied::Readings),
        seed: scatter.seed,
        generator: match scatter.has_end() {
            true => draw::GENERATOR.into(),
            false => draw::GENERATOR_OF_WHOLE.into(),
        },
        method: MethodKind::EventDriven,
        look,
        ended,
        confidence: bounds::look_confidence(scatter.criterion.confidence),
        p_lower: share.lower,
        p_upper: share.upper,
        exceeded_in_coast: count.exceeded_in_coast,
        p_upper_with_coast: share.upper_with_coast,
        open_share: share.allowed,
        peak_angle_rad: None,
        judged_until_s,
        rank_correlation_by_chance: (count.members > 1)
            .then(|| 1.96 / f64::from(count.members - 1).sqrt()),
        drivers: Vec::new(),
    }
}
