//! The values of settings as words, for options, files and documents alike.

use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::range::Window;
use latchgate_kernel::replay::Method;
use latchgate_kernel::units::{
    AccelerationUnit, DecimalMark, MessageClock, SensorSensitivity, TimeUnit,
};
use latchgate_recording::FORMATS;
use latchgate_recording::card::{AcceptedWord, CardPolarity};
use latchgate_recording::error::nearest_name;
use latchgate_recording::setting::Setting;
use latchgate_verdict::ModelChoice;
use latchgate_verdict::conditioning::resample::LEAST_RATE_HZ;
use latchgate_verdict::conditioning::{Between, BiasWindow, Cfc, FilterChoice, FilterStandard};

/// Largest ensemble unless a request says otherwise.
pub const MEMBERS_DEFAULT: u32 = 10_000;

/// Seed of the ensemble unless a request says otherwise.
pub const SEED_DEFAULT: u64 = 1;

/// Steps of the fixed-step methods per natural period unless a request says otherwise.
pub const STEPS_PER_PERIOD_DEFAULT: u32 = 10_000;

/// Reads a number.
///
/// # Errors
///
/// Says what was expected, as every function here does.
pub fn parse_number(text: &str) -> Result<f64, String> {
    text.trim()
        .parse::<f64>()
        .map_err(|_| format!("`{text}` is not a number"))
}

/// Reads a finite number.
///
/// # Errors
///
/// As [`parse_number`].
pub fn parse_finite(text: &str) -> Result<f64, String> {
    parse_number(text).and_then(finite)
}

/// Reads a finite number above zero.
///
/// # Errors
///
/// As [`parse_number`].
pub fn parse_positive(text: &str) -> Result<f64, String> {
    parse_number(text).and_then(positive)
}

pub(super) fn finite(value: f64) -> Result<f64, String> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err("must be finite".into())
    }
}

pub(super) fn positive(value: f64) -> Result<f64, String> {
    finite(value).and_then(|value| {
        if value > 0.0 {
            Ok(value)
        } else {
            Err("must be positive".into())
        }
    })
}

/// Refuses what [`latchgate_kernel::replay::run`] would refuse on either stop.
fn within(value: f64, most: f64, unit: &str) -> Result<f64, String> {
    finite(value).and_then(|value| {
        if value.abs() <= most {
            Ok(value)
        } else {
            Err(format!("must be at most {most} {unit} in magnitude"))
        }
    })
}

pub(super) fn phi0(value: f64) -> Result<f64, String> {
    within(value, 100.0, "rad")
}

pub(super) fn velocity(value: f64) -> Result<f64, String> {
    within(value, 1e5, "rad/s")
}

/// Returns what the integration may be off in a step [rad], if it is in bounds.
pub(super) fn tolerance(value: f64) -> Result<f64, String> {
    positive(value).and_then(|value| {
        if (1e-20..=1e-2).contains(&value) {
            Ok(value)
        } else {
            Err("must lie between 1e-20 and 1e-2 rad".into())
        }
    })
}

pub(super) fn rate_to_resample(hertz: f64) -> Result<f64, String> {
    let hertz = positive(hertz)?;
    if hertz < LEAST_RATE_HZ {
        return Err(format!(
            "must be at least {LEAST_RATE_HZ} Hz, the least rate that is judged"
        ));
    }
    Ok(hertz)
}

/// Reads an initial angle [rad].
///
/// # Errors
///
/// As [`parse_number`].
pub fn parse_phi0(text: &str) -> Result<f64, String> {
    parse_number(text).and_then(phi0)
}

/// Reads an initial angular velocity [rad/s].
///
/// # Errors
///
/// As [`parse_number`].
pub fn parse_velocity(text: &str) -> Result<f64, String> {
    parse_number(text).and_then(velocity)
}

/// Reads the truncation that a step lets pass [rad].
///
/// # Errors
///
/// As [`parse_number`].
pub fn parse_tolerance(text: &str) -> Result<f64, String> {
    parse_number(text).and_then(tolerance)
}

/// Finds a word among those that a setting takes, whatever its case.
fn one_of<T: Copy>(text: &str, known: &[(T, &str)]) -> Result<T, String> {
    let word = text.trim();
    if let Some((value, _)) = known
        .iter()
        .find(|(_, name)| name.eq_ignore_ascii_case(word))
    {
        return Ok(*value);
    }
    let names: Vec<&str> = known.iter().map(|(_, name)| *name).collect();
    let near = nearest_name(&word.to_ascii_lowercase(), &names);
    // A letter or two are near to any.
    let nearest = near.filter(|name| name.len() > 2 && word.len() > 2);
    let meant = nearest.map_or(String::new(), |name| format!("; did you mean {name}?"));
    Err(format!("expected {}{meant}", in_words(&names)))
}

/// Joins names: "rigid or soft", "s, ms or us".
fn in_words(names: &[&str]) -> String {
    match names {
        [] => String::new(),
        [one] => (*one).to_string(),
        [others @ .., last] => format!("{} or {last}", others.join(", ")),
    }
}

/// A value that is one of a few words.
pub trait Word: Copy + PartialEq + Send + Sync + 'static {
    /// Lists the values with their words, in the order in which people are shown them.
    fn all() -> Vec<(Self, &'static str)>;

    /// Reads a word, whatever its case.
    ///
    /// # Errors
    ///
    /// Says what was expected.
    fn from_word(text: &str) -> Result<Self, String> {
        one_of(text, &Self::all())
    }

    /// Returns the word of the value; empty for one that is stated by absence alone.
    fn word(self) -> &'static str {
        Self::all()
            .into_iter()
            .find(|(value, _)| *value == self)
            .map_or("", |(_, word)| word)
    }
}

impl Word for AccelerationUnit {
    fn all() -> Vec<(Self, &'static str)> {
        Self::ALL.to_vec()
    }

    fn from_word(text: &str) -> Result<Self, String> {
        Self::from_spelling(text).map_or_else(|| one_of(text, &Self::ALL), Ok)
    }
}

impl Word for MessageClock {
    fn all() -> Vec<(Self, &'static str)> {
        Self::ALL.map(|clock| (clock, clock.name())).to_vec()
    }
}

impl Word for DecimalMark {
    fn all() -> Vec<(Self, &'static str)> {
        Self::ALL.map(|mark| (mark, mark.name())).to_vec()
    }

    /// Reads `.` and `,`, and the words that a shell need not quote.
    fn from_word(text: &str) -> Result<Self, String> {
        match text.trim() {
            "point" => Ok(Self::Point),
            "comma" => Ok(Self::Comma),
            _ => one_of(text, &Self::all()),
        }
    }
}

impl Word for CardPolarity {
    fn all() -> Vec<(Self, &'static str)> {
        Self::ALL.map(|sign| (sign, sign.name())).to_vec()
    }
}

impl Word for AcceptedWord {
    fn all() -> Vec<(Self, &'static str)> {
        Self::ALL.map(|word| (word, word.name())).to_vec()
    }
}

impl Word for FilterChoice {
    fn all() -> Vec<(Self, &'static str)> {
        let classes = Cfc::ALL.into_iter().rev();
        let classes = classes.map(|class| (Self::Class(class), class.name()));
        [(Self::None, "none")].into_iter().chain(classes).collect()
    }
}

impl Word for FilterStandard {
    fn all() -> Vec<(Self, &'static str)> {
        [Self::Iso6487, Self::SaeJ211]
            .map(|standard| (standard, standard.name()))
            .to_vec()
    }
}

impl Word for Between {
    fn all() -> Vec<(Self, &'static str)> {
        [Self::BandLimited, Self::Linear]
            .map(|between| (between, between.name()))
            .to_vec()
    }
}

impl Word for ModelChoice {
    fn all() -> Vec<(Self, &'static str)> {
        let each = StopModel::ALL.into_iter().map(Self::Only);
        let all = std::iter::once(Self::Auto).chain(each);
        all.map(|model| (model, model.name())).collect()
    }
}

/// Lists the words that a setting takes, in the order in which people are shown them: all there are,
/// or some beside numbers; none for a setting that takes text or numbers alone.
pub fn words_of(setting: Setting) -> Vec<&'static str> {
    fn of<T: Word>() -> Vec<&'static str> {
        T::all().into_iter().map(|(_, word)| word).collect()
    }
    match setting {
        Setting::InputFormat => {
            let mut names: Vec<_> = FORMATS.iter().map(|format| format.name).collect();
            names.sort_unstable();
            names
        }
        Setting::TimeUnit => TimeUnit::NAMES.to_vec(),
        Setting::TimeSource => of::<MessageClock>(),
        Setting::Decimal => of::<DecimalMark>(),
        Setting::Unit => of::<AccelerationUnit>(),
        Setting::Accept => of::<AcceptedWord>(),
        Setting::OpensWhen => of::<CardPolarity>(),
        Setting::Bias => vec!["none"],
        Setting::Filter => of::<FilterChoice>(),
        Setting::FilterStandard => of::<FilterStandard>(),
        Setting::Between => of::<Between>(),
        Setting::Resample => vec!["native"],
        Setting::Model => of::<ModelChoice>(),
        _ => Vec::new(),
    }
}

/// Reads what one of a quantity that is no acceleration means.
///
/// # Errors
///
/// As [`parse_number`].
pub fn parse_sensitivity(text: &str) -> Result<SensorSensitivity, String> {
    SensorSensitivity::from_text(text)
}

/// Reads a unit of time.
///
/// # Errors
///
/// As [`parse_number`].
pub fn parse_time_unit(text: &str) -> Result<TimeUnit, String> {
    TimeUnit::from_spelling(text).ok_or_else(|| {
        let names = in_words(&TimeUnit::NAMES);
        format!("expected {names}, or a number with one, as in 10us")
    })
}

/// Reads an integrator, those of fixed step with so many steps per natural period of the lever.
///
/// # Errors
///
/// As [`parse_number`].
pub fn parse_method(text: &str, steps_per_period: u32) -> Result<Method, String> {
    let methods = [
        Method::EventDriven,
        Method::Rk4 { steps_per_period },
        Method::Rk4Located { steps_per_period },
        Method::Dopri5 { at_samples: false },
        Method::Dopri5 { at_samples: true },
        Method::MoreauJean { steps_per_period },
    ];
    one_of(text, &methods.map(|method| (method, method.name())))
}

/// Reads a count, which may be written as `1e4`.
///
/// # Errors
///
/// As [`parse_number`].
pub fn parse_count(text: &str) -> Result<u64, String> {
    /// Beyond this not every whole number is a double.
    const MOST: f64 = 9_007_199_254_740_992.0;
    let text = text.trim();
    text.parse().or_else(|_| {
        let number = parse_number(text)?;
        let is_whole = number.fract().abs() <= 0.0 && (0.0..MOST).contains(&number);
        let wrong = || format!("`{text}` is no whole number from 0");
        is_whole.then_some(number as u64).ok_or_else(wrong)
    })
}

/// Reads the rate fed to the model [Hz]; `None` for `native`.
///
/// # Errors
///
/// As [`parse_number`].
pub fn parse_resample(text: &str) -> Result<Option<f64>, String> {
    if text.trim().eq_ignore_ascii_case("native") {
        return Ok(None);
    }
    parse_number(text).and_then(rate_to_resample).map(Some)
}

/// Reads an interval of time, START..END [s].
///
/// # Errors
///
/// As [`parse_number`].
pub fn parse_window(text: &str) -> Result<Window, String> {
    let (start, end) = text
        .split_once("..")
        .ok_or("expected START..END in seconds, for example -0.02..0.3")?;
    let (from_s, until_s) = (parse_finite(start)?, parse_finite(end)?);
    if from_s < until_s {
        Ok(Window { from_s, until_s })
    } else {
        Err("START must lie before END".into())
    }
}

/// Reads which samples give the bias: START..END [s], or none.
///
/// # Errors
///
/// As [`parse_number`].
pub fn parse_bias(text: &str) -> Result<BiasWindow, String> {
    if text.trim().eq_ignore_ascii_case("none") {
        return Ok(BiasWindow::None);
    }
    parse_window(text).map(BiasWindow::Window)
}

/// Writes a window so that [`parse_window`] reads it back.
pub(super) fn window(Window { from_s, until_s }: Window) -> String {
    // A negative zero asks nothing else than a plain one.
    format!("{}..{}", from_s + 0.0, until_s + 0.0)
}
