//! The values of settings as words, for options, files and documents alike.

use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::Method;
use latchgate_kernel::units::{
    AccelerationUnit, DecimalMark, MessageClock, SensorSensitivity, TimeUnit,
};
use latchgate_recording::card::{AcceptedWord, CardPolarity};
use latchgate_recording::error::nearest_name;
use latchgate_verdict::ModelChoice;
use latchgate_verdict::conditioning::resample::LEAST_RATE_HZ;
use latchgate_verdict::conditioning::{BiasWindow, Cfc, FilterChoice, FilterStandard};
use latchgate_verdict::margin::MapAxis;

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
    let wanted = text.trim();
    if let Some((value, _)) = known
        .iter()
        .find(|(_, name)| name.eq_ignore_ascii_case(wanted))
    {
        return Ok(*value);
    }
    let names: Vec<&str> = known.iter().map(|(_, name)| *name).collect();
    let near = nearest_name(&wanted.to_ascii_lowercase(), &names);
    // A letter or two are near to any.
    let nearest = near.filter(|name| name.len() > 2 && wanted.len() > 2);
    let meant = nearest.map_or(String::new(), |name| format!("; did you mean {name}?"));
    let (last, others) = names.split_last().ok_or("nothing is known")?;
    let others = match others {
        [] => String::new(),
        others => format!("{} or ", others.join(", ")),
    };
    Err(format!("expected {others}{last}{meant}"))
}

/// Reads a unit of acceleration.
///
/// # Errors
///
/// As [`parse_number`].
pub fn parse_unit(text: &str) -> Result<AccelerationUnit, String> {
    AccelerationUnit::from_spelling(text).map_or_else(|| one_of(text, &AccelerationUnit::ALL), Ok)
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
    let spelled = TimeUnit::from_spelling(text);
    spelled.ok_or_else(|| {
        "expected s, ms, us, ns, min, h or day, or a number with one, as in 10us".into()
    })
}

/// Reads whose clock tells the time of a log's messages.
///
/// # Errors
///
/// As [`parse_number`].
pub fn parse_time_source(text: &str) -> Result<MessageClock, String> {
    one_of(text, &MessageClock::ALL.map(|clock| (clock, clock.name())))
}

/// Reads a decimal mark.
///
/// # Errors
///
/// As [`parse_number`].
pub fn parse_decimal(text: &str) -> Result<DecimalMark, String> {
    let known = DecimalMark::ALL.map(|mark| (mark, mark.name()));
    match text.trim() {
        "point" => Ok(DecimalMark::Point),
        "comma" => Ok(DecimalMark::Comma),
        _ => one_of(text, &known),
    }
}

/// Reads which sign of the recorded acceleration opens.
///
/// # Errors
///
/// As [`parse_number`].
pub fn parse_polarity(text: &str) -> Result<CardPolarity, String> {
    one_of(text, &CardPolarity::ALL.map(|sign| (sign, sign.name())))
}

/// Reads what a person accepts of a recording.
///
/// # Errors
///
/// As [`parse_number`].
pub fn parse_accepted(text: &str) -> Result<AcceptedWord, String> {
    one_of(text, &AcceptedWord::ALL.map(|word| (word, word.name())))
}

/// Reads a channel frequency class.
///
/// # Errors
///
/// As [`parse_number`].
pub fn parse_filter(text: &str) -> Result<FilterChoice, String> {
    let mut known = vec![(FilterChoice::None, "none")];
    let classes = Cfc::ALL.into_iter().rev();
    known.extend(classes.map(|class| (FilterChoice::Class(class), class.name())));
    one_of(text, &known)
}

/// Reads whose filter is meant.
///
/// # Errors
///
/// As [`parse_number`].
pub fn parse_standard(text: &str) -> Result<FilterStandard, String> {
    let known = [FilterStandard::Iso6487, FilterStandard::SaeJ211];
    one_of(text, &known.map(|standard| (standard, standard.name())))
}

/// Reads which stop models decide.
///
/// # Errors
///
/// As [`parse_number`].
pub fn parse_model(text: &str) -> Result<ModelChoice, String> {
    let known = [
        ModelChoice::Auto,
        ModelChoice::Only(StopModel::Rigid),
        ModelChoice::Only(StopModel::Soft),
    ];
    one_of(text, &known.map(|model| (model, model.name())))
}

/// Reads an integrator, those of fixed step with so many steps per natural period of the lever.
///
/// # Errors
///
/// As [`parse_number`].
pub fn parse_method(text: &str, steps_per_period: u32) -> Result<Method, String> {
    let known = [
        Method::EventDriven,
        Method::Rk4 { steps_per_period },
        Method::Rk4Located { steps_per_period },
        Method::Dopri5 { at_samples: false },
        Method::Dopri5 { at_samples: true },
        Method::MoreauJean { steps_per_period },
    ];
    one_of(text, &known.map(|method| (method, method.name())))
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
        let whole = number.fract().abs() <= 0.0 && (0.0..MOST).contains(&number);
        let wrong = || format!("`{text}` is no whole number from 0");
        whole.then_some(number as u64).ok_or_else(wrong)
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
pub fn parse_window(text: &str) -> Result<(f64, f64), String> {
    let (start, end) = text
        .split_once("..")
        .ok_or("expected START..END in seconds, for example -0.02..0.3")?;
    let (start_s, end_s) = (parse_finite(start)?, parse_finite(end)?);
    if start_s < end_s {
        Ok((start_s, end_s))
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
    parse_window(text).map(|(start_s, end_s)| BiasWindow::Window(start_s, end_s))
}

/// Reads a design key with its range, KEY=LO..HI.
///
/// # Errors
///
/// As [`parse_number`].
pub fn parse_map_axis(text: &str) -> Result<MapAxis, String> {
    let parts = text.split_once('=').and_then(|(key, range)| {
        let (low, high) = range.split_once("..")?;
        Some((key.trim(), low, high))
    });
    let Some((key, low, high)) = parts else {
        return Err("expected KEY=LO..HI, for example lever.preload_torque_nm=0.1..3".into());
    };
    Ok(MapAxis {
        key: key.to_string(),
        low: parse_finite(low)?,
        high: parse_finite(high)?,
    })
}

/// Writes an interval so that [`parse_window`] reads it back.
pub(super) fn interval((start, end): (f64, f64)) -> String {
    // A negative zero asks nothing else than a plain one.
    format!("{}..{}", start + 0.0, end + 0.0)
}
