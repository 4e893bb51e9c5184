//! Conditioning: units, bias, resampling and channel frequency class, in the order of
//! good practice: units → faults → bias → resample → filter. Polarity enters last, in the model.
//!
//! - `bandwidth`: what a channel holds at high frequencies, against what is said of it;
//! - `between`: what lies between samples;
//! - `bias`: bias: the mean of the samples before the event, with its standard error;
//! - `cfc`: channel frequency classes: the two-pass Butterworth low-pass of SAE J211-1 and ISO
//!   6487;
//! - `crash`: what tells a record of a crash from another one: velocity change and clock;
//! - `neighbours`: channels beside one another: lateral sensors of one body move alike, and two
//!   at one place measure the same;
//! - `processed`: samples that no raw recording has: smoothed, limited, repaired, scaled;
//! - `quality`: faults of a raw channel: clipping, dead and frozen sensors, records cut inside
//!   the event;
//! - `resample`: band-limited resampling with a Kaiser-windowed sinc;
//! - `spectrum`: amplitude spectra and spectrograms, for reports.

mod bandwidth;
pub mod between;
pub mod bias;
pub mod cfc;
mod crash;
pub mod neighbours;
mod processed;
pub mod quality;
pub mod resample;
pub mod spectrum;

use latchgate_kernel::range::Window;
use latchgate_kernel::units::{STANDARD_GRAVITY, SampleRate, plain};
use latchgate_recording::error::{Error, ErrorKind, Place};
use latchgate_recording::{Channel, Finding};
use serde::{Deserialize, Serialize};

pub use between::Between;
pub use bias::Noise;
pub use crash::{VELOCITY_STRETCH_S, velocity_change_m_s};
use latchgate_kernel::signal::Reading;
pub use latchgate_kernel::signal::Signal;
use quality::RawQuality;
pub use quality::SlowClock;

/// Which samples give the bias that is removed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BiasWindow {
    /// All samples at t ≤ −1 ms if they span at least 5 ms; else none, with a warning.
    PreEvent,
    /// The samples in a window, both ends included.
    Window(Window),
    /// None is removed.
    None,
}

/// Channel frequency class of SAE J211-1 and ISO 6487.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cfc {
    /// CFC 60: structures, for comparison.
    Cfc60,
    /// CFC 180: structures, for integration to velocity.
    Cfc180,
    /// CFC 600: components.
    Cfc600,
    /// CFC 1000: the widest class.
    Cfc1000,
}

impl Cfc {
    /// Every class, the widest first.
    pub const ALL: [Self; 4] = [Self::Cfc1000, Self::Cfc600, Self::Cfc180, Self::Cfc60];

    /// Returns the class's number, which is also its pass-band limit FH [Hz].
    pub fn class(self) -> u32 {
        match self {
            Self::Cfc60 => 60,
            Self::Cfc180 => 180,
            Self::Cfc600 => 600,
            Self::Cfc1000 => 1000,
        }
    }

    /// Returns the name that options and verdicts use, for example `cfc1000`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cfc60 => "cfc60",
            Self::Cfc180 => "cfc180",
            Self::Cfc600 => "cfc600",
            Self::Cfc1000 => "cfc1000",
        }
    }
}

/// The filter that was applied, as documents state it: `none` or the name of its class.
pub mod applied_filter {
    use super::Cfc;
    use serde::de::{Deserialize, Deserializer, Error as _};
    use serde::ser::Serializer;

    /// Writes the name.
    ///
    /// # Errors
    ///
    /// Those of the serializer.
    pub fn serialize<S: Serializer>(filter: &Option<Cfc>, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(filter.map_or("none", Cfc::name))
    }

    /// Reads a name.
    ///
    /// # Errors
    ///
    /// For a text that is neither `none` nor a class.
    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Cfc>, D::Error> {
        let name = String::deserialize(from)?;
        let class = Cfc::ALL.into_iter().find(|class| class.name() == name);
        match class {
            None if name != "none" => Err(D::Error::custom(format!("unknown filter `{name}`"))),
            class => Ok(class),
        }
    }
}

/// Which filter to apply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FilterChoice {
    /// CFC 1000 where the rate is at least 10 kHz (rounded to 1e-4), else none with a warning.
    Default,
    /// No filter.
    None,
    /// This class, or an error where the rate does not carry it.
    Class(Cfc),
}

/// The standard whose filter constant and end treatment are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FilterStandard {
    /// ISO 6487: ωd = 2π·CFC·25/12, point-mirrored ends of 10 ms.
    Iso6487,
    /// SAE J211-1: ωd = 2π·CFC·2.0775, both passes started at zero.
    SaeJ211,
}

impl FilterStandard {
    /// Returns the name that options and verdicts use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Iso6487 => "iso6487",
            Self::SaeJ211 => "saej211",
        }
    }
}

/// How a channel is conditioned.
#[derive(Debug, Clone, PartialEq)]
pub struct ConditioningOptions {
    /// Samples whose mean is removed.
    pub bias: BiasWindow,
    /// Channel frequency class.
    pub filter: FilterChoice,
    /// Whose filter.
    pub filter_standard: FilterStandard,
    /// Rate fed to the model [Hz]; `None` for the native one.
    pub resample_hz: Option<f64>,
    /// Full scale of the sensor, as a card states it [g].
    pub range_g: Option<f64>,
    /// The signal was made by a formula: no findings on sensors, and no person's word is needed.
    pub synthetic: bool,
    /// Velocity change that a person knows from another source [m/s].
    pub velocity_change_m_s: Option<f64>,
    /// Whether a card says that the channel holds what CFC 1000 lets pass, or was not filtered.
    pub wide_band: bool,
    /// Whether a person accepts sample rate and length of the record.
    pub clock_accepted: bool,
    /// Whether a person accepts the recorder's step as all the noise where no quiet stretch shows it.
    pub noise_accepted: bool,
    /// Whether a person accepts samples that are unlike those of a raw recording.
    pub processed_accepted: bool,
    /// Largest magnitude of the judged channel [m/s²], of a second channel beside it: what that one may have missed of
    /// the event is measured by the event, not by itself.
    pub judged_peak_m_s2: Option<f64>,
}

impl Default for ConditioningOptions {
    fn default() -> Self {
        Self {
            bias: BiasWindow::PreEvent,
            filter: FilterChoice::Default,
            filter_standard: FilterStandard::Iso6487,
            resample_hz: None,
            range_g: None,
            synthetic: false,
            velocity_change_m_s: None,
            clock_accepted: false,
            noise_accepted: false,
            processed_accepted: false,
            wide_band: false,
            judged_peak_m_s2: None,
        }
    }
}

/// A conditioned channel and how it came about.
#[derive(Debug, Clone, PartialEq)]
pub struct Conditioned {
    /// As recorded, in m/s².
    pub raw: Signal,
    /// As fed to the model, before polarity.
    pub used: Signal,
    /// The raw signal as its formula runs, of a pulse [m/s²].
    pub formula: Option<Reading<'static>>,
    /// Mean removed [m/s²]; 0 if none was.
    pub bias_m_s2: f64,
    /// Standard error of that mean, correlation of the samples counted [m/s²].
    pub bias_standard_error_m_s2: f64,
    /// Samples in the bias window; 0 if none.
    pub bias_samples: usize,
    /// The bias window, from its first to its last sample.
    pub bias_window_s: Option<Window>,
    /// White noise of the raw samples.
    pub noise: Noise,
    /// Class applied.
    pub filter: Option<Cfc>,
    /// Whose filter.
    pub filter_standard: FilterStandard,
    /// Rate asked for and applied [Hz].
    pub resample_hz: Option<f64>,
    /// Largest |∫a dt| over any 0.3 s of the record, without bias and unfiltered [m/s].
    pub velocity_change_m_s: f64,
    /// What a second sensor at the same place recorded, across the judged one.
    pub second: Option<Box<SecondSensor>>,
    /// What sensors of other axes beside the judged one recorded, where the file has them.
    pub neighbours: Vec<Neighbour>,
    /// The clock that the channel was interpolated from, if it was.
    pub slow_clock: Option<SlowClock>,
    /// The axis that is stated of the channel: X, Y or Z.
    pub axis: Option<char>,
    /// What was found odd, in the raw samples and on the way.
    pub findings: Vec<Finding>,
}

/// A second in-plane sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct SecondSensor {
    /// Name of its channel.
    pub name: String,
    /// The axis that the file states of it: X, Y or Z.
    pub axis: Option<char>,
    /// The sign of the judged channel is against SAE J211, by its code.
    pub judged_is_reversed: bool,
    /// The side that the judged channel's code names.
    pub judged_side: Option<&'static str>,
    /// Its channel, conditioned as the judged one.
    pub conditioned: Conditioned,
}

/// What a channel of another axis, at the place of the judged one, recorded.
#[derive(Debug, Clone, PartialEq)]
pub struct Neighbour {
    /// Name of the channel.
    pub name: String,
    /// Its axis: X, Y or Z.
    pub axis: char,
    /// Largest magnitude, without its bias [m/s²].
    pub peak_m_s2: f64,
}

/// Largest magnitude that is taken in [m/s²], a hundred million g: no sensor reads it, and sums
/// of squares stay finite below it.
const LARGEST_ACCELERATION: f64 = 1e9;

/// Conditions a channel: units → faults → bias → resample → filter.
///
/// The findings are those made here; what the reader found stays with the channel.
///
/// # Errors
///
/// [`ErrorKind::RateTooLow`] if a named class is not carried by the rate;
/// [`OutOfRange`](latchgate_kernel::error::Error::OutOfRange) if a window, rate or sample cannot be used;
/// [`ErrorKind::MissingUnit`] for a channel without a unit;
/// [`TooShort`](latchgate_kernel::error::Error::TooShort) for a channel of fewer than two samples.
pub fn condition(channel: &Channel, options: &ConditioningOptions) -> Result<Conditioned, Error> {
    conditioned(channel, options)
        .map_err(|error| error.at(Place::default().channel(channel.name.clone())))
}

/// Returns what is odd in a channel's own samples, before and after its bias is removed, with a
/// word on what it does before the event. For `inspect`, which conditions nothing.
///
/// # Errors
///
/// As [`condition`], for samples that cannot be used.
pub fn inspect(channel: &Channel, options: &ConditioningOptions) -> Result<Vec<Finding>, Error> {
    let raw = in_si(channel)?;
    if channel.pulse.is_some() {
        return Ok(Vec::new());
    }
    let mut findings = quality::findings(
        &raw,
        &ConditioningOptions {
            range_g: options.range_g.or(channel.full_scale_g()),
            ..*options
        },
    );
    let (bias, _) = bias::bias(&raw, BiasWindow::PreEvent)?;
    findings.extend(quality::before_event(&raw));
    let unbiased = without_bias(&raw, bias.mean_m_s2);
    findings.extend(crash::findings(&unbiased, options, &channel.stated));
    findings.extend(bandwidth::finding(&raw, channel, options));
    let processed = processed::finding(&raw, channel, &findings, options);
    findings.extend(processed);
    Ok(findings)
}

fn conditioned(channel: &Channel, options: &ConditioningOptions) -> Result<Conditioned, Error> {
    let options = &ConditioningOptions {
        synthetic: options.synthetic || channel.pulse.is_some(),
        ..options.clone()
    };
    let raw = in_si(channel)?;
    let formula = formula_in_si(channel);
    // What a card declares comes before what the file states.
    let quality = match formula {
        Some(_) => RawQuality::default(),
        None => quality::examine(
            &raw,
            &ConditioningOptions {
                range_g: options.range_g.or(channel.full_scale_g()),
                ..*options
            },
        ),
    };
    // What a formula gave carries none.
    let noise = match options.synthetic {
        true => Noise::default(),
        false => bias::noise(&raw),
    };
    let mut conditioned = from_raw(raw, formula, options, quality, noise)?;
    conditioned.axis = latchgate_recording::axis_of(channel).map(|axis| axis.letter);
    let unbiased = without_bias(&conditioned.raw, conditioned.bias_m_s2);
    let unlike = crash::findings(&unbiased, options, &channel.stated);
    conditioned.findings.extend(unlike);
    let empty = bandwidth::finding(&conditioned.raw, channel, options);
    conditioned.findings.extend(empty);
    let said = &conditioned.findings;
    let processed = processed::finding(&conditioned.raw, channel, said, options);
    conditioned.findings.extend(processed);
    tracing::debug!(
        channel = %channel.name,
        bias_m_s2 = conditioned.bias_m_s2,
        filter = conditioned.filter.map_or("none", Cfc::name),
        findings = conditioned.findings.len(),
        "channel conditioned"
    );
    Ok(conditioned)
}

/// Conditions the same samples in another way; what they are by themselves is not looked at again.
///
/// # Errors
///
/// As [`condition`] for bias, resampling and filter.
pub fn reconditioned(
    conditioned: &Conditioned,
    options: &ConditioningOptions,
) -> Result<Conditioned, Error> {
    let quality = RawQuality {
        findings: Vec::new(),
        slow_clock: conditioned.slow_clock,
    };
    let (raw, formula) = (conditioned.raw.clone(), conditioned.formula.clone());
    let again = from_raw(raw, formula, options, quality, conditioned.noise)?;
    let second = conditioned.second_by(|second| reconditioned(second, options))?;
    Ok(Conditioned {
        second,
        neighbours: conditioned.neighbours.clone(),
        axis: conditioned.axis,
        ..again
    })
}

/// Puts a second in-plane sensor beside a channel, conditioned alike. What is odd about it is said of the whole.
///
/// # Errors
///
/// As [`condition`]; [`OutOfRange`](latchgate_kernel::error::Error::OutOfRange) unless both have the same clock.
pub fn with_second(
    first: Conditioned,
    judged: &Channel,
    channel: &Channel,
    options: &ConditioningOptions,
) -> Result<Conditioned, Error> {
    // Its velocity is not that of the impact, and its clock is that of the judged channel.
    let unbiased = first.raw.samples.iter();
    let judged_peak = unbiased.map(|sample| (sample - first.bias_m_s2).abs());
    let options = &ConditioningOptions {
        velocity_change_m_s: None,
        clock_accepted: true,
        judged_peak_m_s2: Some(judged_peak.fold(0.0, f64::max)),
        ..options.clone()
    };
    let mut second = condition(channel, options)?;
    let clock = |signal: &Signal| (signal.samples.len(), signal.rate.hertz(), signal.start_s);
    let (judged_clock, second_clock) = (clock(&first.raw), clock(&second.raw));
    if judged_clock != second_clock {
        let shown = |(samples, hertz, start_s): (usize, f64, f64)| {
            format!("{samples} samples at {hertz} Hz from {start_s} s")
        };
        return Err(Error::out_of_range(
            "the clock of the second in-plane channel",
            format!("that of the judged one, {}", shown(judged_clock)),
            shown(second_clock),
        )
        .at(Place::default().channel(channel.name.clone())));
    }
    let first_texts: Vec<&str> = first
        .findings
        .iter()
        .map(|finding| finding.text.as_str())
        .collect();
    second
        .findings
        .retain(|finding| !finding.needs_word && !first_texts.contains(&finding.text.as_str()));
    for finding in &mut second.findings {
        finding.text = format!("`{}`: {}", channel.name, finding.text);
    }
    let findings = [first.findings, std::mem::take(&mut second.findings)].concat();
    Ok(Conditioned {
        second: Some(Box::new(SecondSensor {
            name: channel.name.clone(),
            axis: latchgate_recording::axis_of(channel).map(|axis| axis.letter),
            judged_is_reversed: latchgate_recording::axis_of(judged)
                .is_some_and(|axis| axis.is_reversed),
            judged_side: latchgate_recording::side_of(judged),
            conditioned: second,
        })),
        findings,
        ..first
    })
}

/// Returns the recording as it would be used with `filter`.
///
/// # Errors
///
/// As [`condition`] for resampling and filter.
pub fn refiltered(conditioned: &Conditioned, filter: Option<Cfc>) -> Result<Conditioned, Error> {
    let second = conditioned.second_by(|second| refiltered(second, filter))?;
    Ok(Conditioned {
        used: filtered(conditioned, filter)?,
        filter,
        findings: Vec::new(),
        second,
        ..conditioned.clone()
    })
}

/// Returns the recording with its bias left in, conditioned alike otherwise, where the bias that was
/// removed is so doubtful that a pass needs both.
///
/// # Errors
///
/// As [`condition`] for resampling and filter.
pub fn without_doubtful_bias(conditioned: &Conditioned) -> Result<Option<Conditioned>, Error> {
    if !conditioned.sensors().any(bias::must_pass_without) {
        return Ok(None);
    }
    let class = conditioned.filter;
    let options = ConditioningOptions {
        bias: BiasWindow::None,
        filter: class.map_or(FilterChoice::None, FilterChoice::Class),
        filter_standard: conditioned.filter_standard,
        resample_hz: conditioned.resample_hz,
        ..ConditioningOptions::default()
    };
    reconditioned(conditioned, &options).map(Some)
}

fn from_raw(
    raw: Signal,
    formula: Option<Reading<'static>>,
    options: &ConditioningOptions,
    quality: RawQuality,
    noise: Noise,
) -> Result<Conditioned, Error> {
    let RawQuality {
        mut findings,
        slow_clock,
    } = quality;
    // Of a formula nothing is removed, and nothing filtered, unless asked for.
    let (mut bias_window, mut filter_choice) = (options.bias, options.filter);
    if formula.is_some() {
        if bias_window == BiasWindow::PreEvent {
            bias_window = BiasWindow::None;
        }
        if filter_choice == FilterChoice::Default {
            filter_choice = FilterChoice::None;
        }
    }
    let (bias, odd) = bias::bias(&raw, bias_window)?;
    findings.extend(odd);
    let mut used = without_bias(&raw, bias.mean_m_s2);
    let velocity_change_m_s = velocity_change_m_s(&used);

    let resample_hz = match options.resample_hz {
        Some(hertz) => {
            let rate = SampleRate::from_hertz(hertz)?;
            if resample::is_native(&used, rate) {
                None
            } else {
                used = resample::resample(&used, rate)?;
                findings.extend(peak_near_end(
                    &used,
                    resample::end_padding_s(raw.rate, rate),
                    "The resampling reaches beyond the record",
                ));
                Some(rate.hertz())
            }
        }
        None => None,
    };

    // What was interpolated carries no more than its own clock does.
    let own_rate = match slow_clock {
        Some(clock) if clock.rate_hz < used.rate.hertz() => SampleRate::from_hertz(clock.rate_hz)?,
        _ => used.rate,
    };
    let (filter, odd) = choose_filter(filter_choice, own_rate);
    findings.extend(odd);
    if let Some(class) = filter {
        let filter = cfc::CfcFilter::new(class, options.filter_standard);
        used = filtered_by(filter, used, formula.is_some())?;
        if formula.is_none() {
            findings.extend(peak_near_end(
                &used,
                filter_padding_s(&used),
                "The filter uses assumed samples there",
            ));
        }
        findings.extend(filter_not_causal(class, options.filter_standard));
    }
    let rounding_m_s2 = if noise.may_be_offset() {
        noise.deviation_m_s2
    } else {
        0.0
    };
    Ok(Conditioned {
        bias_m_s2: bias.mean_m_s2,
        bias_standard_error_m_s2: bias.standard_error_m_s2.max(rounding_m_s2),
        bias_samples: bias.window.map_or(0, |(_, count)| count),
        bias_window_s: bias
            .window
            .map(|(first, count)| Window::new(raw.time_s(first), raw.time_s(first + count - 1))),
        noise,
        raw,
        used,
        formula,
        filter,
        filter_standard: options.filter_standard,
        resample_hz,
        velocity_change_m_s,
        second: None,
        neighbours: Vec::new(),
        slow_clock,
        axis: None,
        findings,
    })
}

/// Returns the signal as it would be used with `filter`: bias removed and resampled alike.
///
/// # Errors
///
/// As [`condition`] for resampling and filter.
pub fn filtered(conditioned: &Conditioned, filter: Option<Cfc>) -> Result<Signal, Error> {
    let signal = without_bias(&conditioned.raw, conditioned.bias_m_s2);
    resampled_and_filtered(signal, conditioned, filter)
}

/// Returns what betrays corners and jumps between the samples as recorded, as it would come through
/// resampling and filter [m/s²]: the magnitudes of what lies above 0.8 of the Nyquist frequency.
///
/// A filter takes away what betrays a jump, not what its unknown place does: so this is taken
/// before it. Both steps are linear: samples moved by a multiple of the magnitudes come out
/// moved by that multiple of this.
///
/// # Errors
///
/// As [`condition`] for resampling and filter.
pub fn corner_trace(conditioned: &Conditioned) -> Result<Signal, Error> {
    let mut trace = resample::near_nyquist(&conditioned.raw);
    trace.iter_mut().for_each(|a| *a = a.abs());
    through(conditioned, trace)
}

/// Returns samples that are added to those recorded as they come through resampling and filter [m/s²].
///
/// # Errors
///
/// As [`condition`] for resampling and filter.
pub fn through(conditioned: &Conditioned, samples: Vec<f64>) -> Result<Signal, Error> {
    let added = Signal {
        samples,
        ..conditioned.raw
    };
    resampled_and_filtered(added, conditioned, conditioned.filter)
}

fn resampled_and_filtered(
    mut signal: Signal,
    conditioned: &Conditioned,
    filter: Option<Cfc>,
) -> Result<Signal, Error> {
    if let Some(hertz) = conditioned.resample_hz {
        signal = resample::resample(&signal, SampleRate::from_hertz(hertz)?)?;
    }
    match filter {
        None => Ok(signal),
        Some(class) => filtered_by(
            cfc::CfcFilter::new(class, conditioned.filter_standard),
            signal,
            conditioned.formula.is_some(),
        ),
    }
}

/// Filters a signal. A pulse is zero before and after its formula: the mirror of a record's end would begin it with its
/// opposite.
fn filtered_by(
    filter: cfc::CfcFilter,
    mut signal: Signal,
    is_pulse: bool,
) -> Result<Signal, Error> {
    if !is_pulse {
        return filter.apply(&signal);
    }
    let padding = cfc::padding_samples(signal.rate, usize::MAX);
    let zeros = || std::iter::repeat_n(0.0, padding);
    let count = signal.samples.len();
    signal.samples = zeros().chain(signal.samples).chain(zeros()).collect();
    let mut filtered = filter.apply(&signal)?;
    filtered.samples.truncate(padding + count);
    filtered.samples.drain(..padding);
    Ok(filtered)
}

/// Returns the index of the sample of largest magnitude; the first of equals.
pub fn peak(signal: &Signal) -> Option<usize> {
    let mut largest: Option<(usize, f64)> = None;
    for (index, value) in signal.samples.iter().enumerate() {
        if largest.is_none_or(|(_, most)| value.abs() > most.abs()) {
            largest = Some((index, *value));
        }
    }
    largest.map(|(index, _)| index)
}

/// Returns a signal with its bias [m/s²] removed.
fn without_bias(raw: &Signal, bias_m_s2: f64) -> Signal {
    Signal {
        samples: raw
            .samples
            .iter()
            .map(|sample| sample - bias_m_s2)
            .collect(),
        ..*raw
    }
}

/// Returns the change of velocity since the first sample at each sample [m/s], of a signal that is
/// linear between its samples.
pub fn velocity_m_s(signal: &Signal) -> Vec<f64> {
    let mut sum = 0.0;
    let mut before = None;
    let samples = signal.samples.iter();
    samples
        .map(|sample| {
            sum += before.map_or(0.0, |before: f64| 0.5 * (before + sample));
            before = Some(*sample);
            sum / signal.rate.hertz()
        })
        .collect()
}

/// Returns a pulse as its formula runs [m/s²].
fn formula_in_si(channel: &Channel) -> Option<Reading<'static>> {
    let factor = channel.unit?.metres_per_second_squared();
    Some(channel.pulse.as_ref()?.reading.scaled(factor, 0.0))
}

impl Conditioned {
    /// Returns the second sensor with its channel made into another one.
    ///
    /// # Errors
    ///
    /// Those of `change`.
    pub fn second_by(
        &self,
        change: impl Fn(&Self) -> Result<Self, Error>,
    ) -> Result<Option<Box<SecondSensor>>, Error> {
        let changed = |second: &SecondSensor| {
            Ok(Box::new(SecondSensor {
                name: second.name.clone(),
                axis: second.axis,
                judged_is_reversed: second.judged_is_reversed,
                judged_side: second.judged_side,
                conditioned: change(&second.conditioned)?,
            }))
        };
        self.second.as_deref().map(changed).transpose()
    }

    /// Returns the channels of all sensors, the judged one first.
    pub fn sensors(&self) -> impl Iterator<Item = &Self> {
        let second = self.second.as_deref().map(|second| &second.conditioned);
        std::iter::once(self).chain(second)
    }

    /// True of a pulse that was neither filtered nor resampled: it is known between its samples.
    pub fn is_exact(&self) -> bool {
        self.formula.is_some() && self.filter.is_none() && self.resample_hz.is_none()
    }

    /// Returns the used signal as its formula runs, where [`Self::is_exact`].
    pub fn exact(&self) -> Option<Reading<'static>> {
        let formula = self.formula.as_ref().filter(|_| self.is_exact())?;
        Some(formula.scaled(1.0, -self.bias_m_s2))
    }
}

fn in_si(channel: &Channel) -> Result<Signal, Error> {
    let factor = channel
        .unit
        .ok_or(ErrorKind::MissingUnit)?
        .metres_per_second_squared();
    if channel.values.len() < 2 {
        return Err(Error::too_short("a recording", 2, channel.values.len()));
    }
    let samples: Vec<f64> = channel.values.iter().map(|value| value * factor).collect();
    if let Some(index) = samples
        .iter()
        .position(|value| !(value.is_finite() && value.abs() <= LARGEST_ACCELERATION))
    {
        return Err(Error::out_of_range(
            format!(
                "acceleration at {} s [m/s²]",
                plain(channel.time_s(index), 6)
            ),
            format!("finite and at most {LARGEST_ACCELERATION:e} in magnitude; check the unit"),
            format!("{:e}", samples[index]),
        ));
    }
    Ok(Signal {
        start_s: channel.start_s,
        rate: channel.rate,
        samples,
    })
}

fn choose_filter(choice: FilterChoice, rate: SampleRate) -> (Option<Cfc>, Option<Finding>) {
    let class = Cfc::Cfc1000;
    match choice {
        FilterChoice::None => (None, None),
        FilterChoice::Class(class) => (Some(class), None),
        FilterChoice::Default if rate.rounded() >= cfc::least_rate_hz(class) => (Some(class), None),
        FilterChoice::Default => (
            None,
            Some(Finding::warning(
                "rate-below-default-filter",
                format!(
                    "{} Hz is too slow for CFC {}, the default filter, which needs {} Hz. The \
                     samples were used unfiltered. Motion above half the rate may show as a slower \
                     one. State a class with the setting `filter`, or the setting `filter` = none",
                    rate.rounded(),
                    class.class(),
                    cfc::least_rate_hz(class)
                ),
            )),
        ),
    }
}

fn filter_padding_s(signal: &Signal) -> f64 {
    cfc::padding_samples(signal.rate, signal.samples.len()) as f64 / signal.rate.hertz()
}

fn peak_near_end(signal: &Signal, padding_s: f64, why: &str) -> Option<Finding> {
    let peak = peak(signal).filter(|peak| signal.samples[*peak].abs() > 0.0)?;
    let (value, time_s) = (signal.samples[peak], signal.time_s(peak));
    // Half an interval keeps a peak at exactly one padding from an end outside.
    let reach_s = padding_s - 0.5 * signal.rate.interval().seconds();
    let inside = time_s - signal.start_s < reach_s || signal.end_s() - time_s < reach_s;
    inside.then(|| {
        Finding::warning(
            "peak-in-end-padding",
            format!(
                "the peak of {:.4} g at {time_s:.5} s lies within {:.2} ms of an end of the \
                 record. {why}, so the peak is partly assumed. Record more before and after the \
                 event",
                value / STANDARD_GRAVITY,
                1e3 * padding_s
            ),
        )
        .at(time_s)
    })
}

fn filter_not_causal(class: Cfc, standard: FilterStandard) -> Option<Finding> {
    matches!(class, Cfc::Cfc60 | Cfc::Cfc180).then(|| {
        Finding::info(
            "filter-not-causal",
            format!(
                "CFC {} smears each instant by about ±{:.2} ms. Motion may precede its cause by \
                 that much. Short peaks are weakened",
                class.class(),
                1e3 / (2.0 * cfc::design_frequency_hz(class, standard))
            ),
        )
    })
}
