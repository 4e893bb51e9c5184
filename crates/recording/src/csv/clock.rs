//! Clocks: the column that holds the time, and its unit.
//!
//! A column is the clock by its name, its unit or its dates. Where there is none, stamps as words count,
//! and then numbers under other words for a clock. A column without a name that rises as seconds of a
//! recorder do, as pandas writes its index, is offered, or compared with a rate that is stated.

use super::layout::{TableLayout, TimeSource, UnitOrigin};
use crate::error::{Error, ErrorKind};
use crate::time_base::brief;
use crate::words::{Words, word_list};
use crate::{Finding, ReadOptions, Selection};
use latchgate_kernel::units::{SampleRate, TimeUnit};

// The head of each list explains it.
static UNIT_KEYS: Words = word_list!("time-unit-keys");

/// The remedy for a unit of time that is missing or wrong.
pub(super) const STATE_UNIT: &str = "state its unit with the setting `time_unit` = \
                                     s|ms|us|ns|min|h|day, or with a number before it, such as \
                                     10us";

/// Rates of recorders [Hz]: a column without a name that rises so is offered as the clock.
const RECORDERS_HZ: std::ops::RangeInclusive<f64> = 250.0..=500e3;

/// True if a step of that many seconds is one of a recorder.
pub(super) fn is_recorder_step(seconds: f64) -> bool {
    RECORDERS_HZ.contains(&(1.0 / seconds))
}

/// Rates at which crashes are recorded [Hz]: a unit of time that makes such a rate is plausible.
const PLAUSIBLE_HZ: std::ops::RangeInclusive<f64> = 250.0..=200e3;

/// Share by which a step may be off a unit's [-].
const UNIT_AGREEMENT: f64 = 1e-3;

/// A time longer than any recorder runs [s]: a year. A month is possible, and microseconds since its
/// start have the size of milliseconds since 1970.
const LONGEST_RUN_S: f64 = 3.156e7;

/// First values of clocks that count from a date, and their unit: the years 2000 to 2100 as seconds
/// since 1970 and their thousandths, as Windows' ticks since 1601 and since year 1, as days of
/// spreadsheets since 1900, of MATLAB since year 0 and of astronomers.
const ABSOLUTE: [(f64, f64, TimeUnit); 9] = [
    (9.46e8, 4.11e9, TimeUnit::SECOND),
    (9.46e11, 4.11e12, TimeUnit::MILLISECOND),
    (9.46e14, 4.11e15, TimeUnit::MICROSECOND),
    (9.46e17, 4.11e18, TimeUnit::NANOSECOND),
    (1.259e17, 1.575e17, TimeUnit::WINDOWS_TICK),
    (6.308e17, 6.625e17, TimeUnit::WINDOWS_TICK),
    (36_526.0, 73_051.0, TimeUnit::DAY),
    (730_486.0, 767_011.0, TimeUnit::DAY),
    (2_451_544.0, 2_488_070.0, TimeUnit::DAY),
];

/// Returns the unit of a clock that counts from a date, by its first value.
pub(super) fn absolute_unit(first: f64) -> Option<TimeUnit> {
    let range = ABSOLUTE
        .iter()
        .find(|(low, high, _)| (*low..=*high).contains(&first));
    range.map(|(.., unit)| *unit)
}

/// Returns the unit of [`absolute_unit`] if the steps in it are those of a recorder; `rate` is that of
/// the stamps taken as seconds [Hz].
pub(super) fn absolute_clock(first: f64, rate: f64) -> Option<TimeUnit> {
    let runs = |unit: &TimeUnit| RECORDERS_HZ.contains(&(rate / unit.seconds()));
    absolute_unit(first).filter(runs)
}

/// Blocks where the stated unit of time makes the stamps run for longer than any recorder does, while
/// their size is that of a count from a date in another unit. `rate_hz` is that in the stated `unit`.
pub(super) fn unit_contradiction(
    name: &str,
    first_s: f64,
    rate_hz: f64,
    unit: TimeUnit,
) -> Option<Finding> {
    let first = first_s / unit.seconds();
    let counted = absolute_clock(first, rate_hz * unit.seconds())?;
    let text = format!(
        "`{name}` counts {counted} from a date, by the size of its stamps, but {unit} is stated. \
         Check the setting `time_unit`"
    );
    (first_s > LONGEST_RUN_S && counted != unit)
        .then(|| Finding::blocking("time-contradicted", text))
}

/// Finds a unit of time that a line among the first `above` states, such as `Time unit;10 us`, and
/// removes that line, which says nothing else.
pub(super) fn take_unit_above(lines: &mut Vec<(u64, String)>, above: u64) -> Option<String> {
    let stated_unit = |(line, text): &(u64, String)| {
        (*line <= above).then_some(())?;
        let (key, value) = text.split_once([':', '=', ';', ',', '\t'])?;
        let words = key.split(|c: char| !c.is_alphanumeric());
        let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
        let is_key = UNIT_KEYS.contains(&words.join(" ").to_lowercase().as_str());
        let value = value.trim().trim_end_matches([';', ',', '\t']);
        let cell = value.split([';', '\t']).next().unwrap_or_default();
        let texts = [value, cell, cell.split(',').next().unwrap_or_default()];
        let is_unit = |text: &&str| TimeUnit::from_spelling(text.trim_matches(QUOTES)).is_some();
        let unit = texts.into_iter().map(str::trim).find(is_unit);
        unit.filter(|_| is_key)
            .map(|unit| unit.trim_matches(QUOTES).to_string())
    };
    let index = lines.iter().position(|line| stated_unit(line).is_some())?;
    stated_unit(&lines.remove(index))
}

/// Marks around a unit.
const QUOTES: [char; 7] = ['"', '\'', '(', ')', '[', ']', ' '];

impl TableLayout {
    /// Gives the columns of time the unit that a line above the table states.
    pub(super) fn take_time_unit(&mut self, unit: &str) {
        let named = self.columns.iter().any(|column| column.says_time());
        for (index, column) in self.columns.iter_mut().enumerate() {
            let unnamed = index == 0 && column.label.is_empty() && self.steps[index].is_some();
            if column.says_time() || (!named && unnamed) {
                *column = std::mem::take(column).with_unit(unit, "line above the table");
            }
        }
    }

    /// Finds the source of the time. Without one, the result is an error for a judged channel, and `None`
    /// with a finding for a list of all channels.
    pub(super) fn time_or_left_out(
        &self,
        options: &ReadOptions,
        selection: Selection,
        findings: &mut Vec<Finding>,
    ) -> Result<Option<TimeSource>, Error> {
        if let Some(index) = self.find_time_column(options)? {
            let names = options.time_column.iter();
            findings.extend(names.filter_map(|name| self.by_name_finding(name, index)));
            return self.time_column(index, options, findings).map(Some);
        }
        if let Some(rate) = options.rate_hz {
            return Ok(Some(TimeSource::Rate(SampleRate::from_hertz(rate)?)));
        }
        if let Some(rate) = self.preamble.rate_hz() {
            let text = format!(
                "no column holds the time. The {rate} Hz of the rows above the table was used. \
                 Check it"
            );
            findings.push(Finding::info("rate-above-table", text));
            return Ok(Some(TimeSource::Rate(SampleRate::from_hertz(rate)?)));
        }
        let offer = self.clock_to_offer(options);
        if selection == Selection::Lateral {
            return Err(offer.unwrap_or_else(|| ErrorKind::MissingTime.into()));
        }
        let text = match offer {
            Some(offer) => offer.to_string(),
            None => format!(
                "no channel can be read: there is no time column and no sample rate. The columns \
                 are: {}. State the setting `time_column` = NAME or the setting `rate_hz` = HZ",
                self.list(0..self.columns.len())
            ),
        };
        findings.push(Finding::warning("time-missing", text));
        Ok(None)
    }

    fn find_time_column(&self, options: &ReadOptions) -> Result<Option<usize>, Error> {
        if let Some(name) = &options.time_column {
            return self.find_column(name, "time column").map(Some);
        }
        let columns_where = |matches: &dyn Fn(usize) -> bool| -> Vec<usize> {
            (0..self.columns.len()).filter(|i| matches(*i)).collect()
        };
        let mut clocks = columns_where(&|i| self.is_named_clock(i) || self.dated[i]);
        if clocks.is_empty() {
            clocks = columns_where(&|i| self.worded[i]);
        }
        if clocks.is_empty() {
            clocks = columns_where(&|i| self.is_other_clock(i));
        }
        if clocks.is_empty() && options.rate_hz.is_none() {
            // Stamps of an unknown form: the error of reading them names the cell.
            clocks = columns_where(&|i| self.columns[i].says_time());
        }
        if let [only] = clocks.as_slice() {
            clocks = columns_where(&|i| i == *only || self.is_twin_of_time(i, *only));
        }
        match clocks.as_slice() {
            [only] => Ok(Some(*only)),
            [] => Ok(self.unnamed_clock(options)),
            several => Err(Error::malformed(
                "one time column",
                self.list(several.iter().copied()),
                "choose one with the setting `time_column` = NAME; each may be the clock of the \
                 channels beside it",
            )),
        }
    }

    /// True if a column of numbers is a clock by its name or unit.
    pub(super) fn is_named_clock(&self, index: usize) -> bool {
        let column = &self.columns[index];
        self.numeric[index] && (column.says_time() || column.time_unit.is_some())
    }

    /// True if a column of numbers has a name that clocks have beside the one of times.
    pub(super) fn is_other_clock(&self, index: usize) -> bool {
        let column = &self.columns[index];
        self.numeric[index] && column.says_other_clock() && column.unit_text.is_none()
    }

    /// True if a column may be another clock beside the one of times, by the name of that one with a
    /// number or a word after it, such as `t.1`.
    fn is_twin_of_time(&self, index: usize, time: usize) -> bool {
        let column = &self.columns[index];
        let [first, label] = [time, index].map(|index| self.columns[index].label.to_lowercase());
        let suffix = label.strip_prefix(&first).filter(|_| !first.is_empty());
        let suffixed = suffix.is_some_and(|suffix| !suffix.starts_with(char::is_alphabetic));
        suffixed && self.numeric[index] && column.unit_text.is_none()
    }

    /// Returns the step of a column that is not named as a clock and may be one: the first column, or one
    /// without a name or with that of a running number, among others.
    fn step_of_unnamed(&self, index: usize, options: &ReadOptions) -> Option<f64> {
        let column = &self.columns[index];
        let requested = options.channel.as_ref();
        let requested = requested.and_then(|name| self.find_column(name, "channel").ok());
        let may_be = (index == 0 || self.is_index(index))
            && self.columns.len() > 1
            && requested != Some(index)
            && column.unit_text.is_none()
            && !column.hints_at_acceleration();
        self.steps[index].filter(|_| may_be)
    }

    /// Finds the column that is meant by a stated unit of time, or compared with a stated rate, where none
    /// is named as a clock: it rises by fractions as seconds of a recorder do, or it has no name and rises
    /// by fractions, or by the steps that the rate has in another unit.
    fn unnamed_clock(&self, options: &ReadOptions) -> Option<usize> {
        let fits = |index: &usize| {
            let Some(step) = self.step_of_unnamed(*index, options) else {
                return false;
            };
            let fractional = is_fractional(step);
            let unit_stated = options.time_unit.is_some();
            match options.rate_hz {
                None => unit_stated && (fractional || self.columns[*index].label.is_empty()),
                Some(_) if fractional => {
                    RECORDERS_HZ.contains(&(1.0 / step)) || self.is_unnamed(*index)
                }
                Some(rate) => {
                    let natural = natural_unit(1.0 / (rate * step), None).is_some();
                    self.is_unnamed(*index) && step > 1.5 && (natural || unit_stated)
                }
            }
        };
        (0..self.columns.len()).find(fits)
    }

    /// True if a column has no name, or one that counts rows.
    pub(super) fn is_unnamed(&self, index: usize) -> bool {
        self.is_index(index) || self.columns[index].label.is_empty()
    }

    /// Returns the error that offers a column as the clock which is not named so.
    fn clock_to_offer(&self, options: &ReadOptions) -> Option<Error> {
        let fits = |index: usize| {
            let step = self.step_of_unnamed(index, options)?;
            (is_fractional(step) && RECORDERS_HZ.contains(&(1.0 / step))).then_some((index, step))
        };
        let (index, step) = (0..self.columns.len()).find_map(fits)?;
        let number = (index + 1).to_string();
        let named_so = self.columns.iter().any(|column| column.name == number);
        let name = &self.columns[index].name;
        let chosen = if named_so { name } else { &number };
        Some(Error::malformed(
            "a time column or a sample rate",
            format!(
                "no time column by name; `{name}` rises by {} a row, {} Hz if in seconds",
                brief(step),
                brief(1.0 / step)
            ),
            format!(
                "if that is the time, state the setting `time_column` = {chosen}, and the setting \
                 `time_unit` unless in seconds; else the setting `rate_hz` = HZ"
            ),
        ))
    }

    fn time_column(
        &self,
        index: usize,
        options: &ReadOptions,
        findings: &mut Vec<Finding>,
    ) -> Result<TimeSource, Error> {
        if self.worded[index] {
            return Ok(TimeSource::Column {
                index,
                unit: TimeUnit::SECOND,
                origin: UnitOrigin::Stated,
                worded: true,
            });
        }
        let column = &self.columns[index];
        if let (Some(stated), Some(column_unit)) = (options.time_unit, column.time_unit)
            && stated != column_unit
        {
            let text = format!(
                "the {} states `{column_unit}` for `{}`, but the setting `time_unit` is `{stated}`. The \
                 setting was used. Check which is right",
                column.unit_source, column.name,
            );
            findings.push(Finding::warning("time-unit-overridden", text));
        }
        let unit = options.time_unit.or(column.time_unit);
        let silent = column.unit_text.is_none() && !column.doubtful;
        let unread = unit.is_none() && (!silent || column.has_brackets());
        if unread && options.rate_hz.is_none() {
            let text = column.unit_text.as_ref();
            let text = text.map_or(String::new(), |text| format!(" in `{text}`"));
            return Err(Error::malformed(
                "a known unit of time, such as s, ms, 10 us or day",
                format!("`{}`{text}", column.name),
                format!("{STATE_UNIT}, or the rate with the setting `rate_hz` = HZ"),
            ));
        }
        if unit.is_none() && options.rate_hz.is_none() {
            findings.push(seconds_assumed(&column.name));
        }
        let origin = match unit {
            Some(_) => UnitOrigin::Stated,
            None if unread && column.names_unread_unit() => UnitOrigin::Unread,
            None => UnitOrigin::Assumed,
        };
        Ok(TimeSource::Column {
            index,
            unit: unit.unwrap_or(TimeUnit::SECOND),
            origin,
            worded: false,
        })
    }
}

/// Returns the finding that stamps were taken as seconds.
pub(super) fn seconds_assumed(name: &str) -> Finding {
    let text = format!("nothing states the unit of the time column `{name}`. Seconds were assumed");
    Finding::info("time-unit-assumed", text)
}

/// True if a step is no whole number.
pub(super) fn is_fractional(step: f64) -> bool {
    (step - step.round()).abs() > 1e-6 * step
}

/// Returns the unit that a clock without a stated one may have, if it is so many seconds long; an
/// `absolute` clock has its own.
pub(super) fn natural_unit(seconds: f64, absolute: Option<TimeUnit>) -> Option<TimeUnit> {
    let fits = |unit: &TimeUnit| (unit.seconds() / seconds - 1.0).abs() <= UNIT_AGREEMENT;
    natural_units(absolute).into_iter().find(fits)
}

/// Lists the units that a clock without a stated one may have.
fn natural_units(absolute: Option<TimeUnit>) -> Vec<TimeUnit> {
    let units = [
        TimeUnit::SECOND,
        TimeUnit::MILLISECOND,
        TimeUnit::MICROSECOND,
        TimeUnit::NANOSECOND,
        TimeUnit::MINUTE,
        TimeUnit::HOUR,
        TimeUnit::DAY,
    ];
    absolute.map_or(units.to_vec(), |unit| vec![unit])
}

/// Returns the length of the unit [s] in which stamps run at a stated rate, where they run at another if
/// taken as seconds; `None` where the stamps contradict the rate.
///
/// Stamps of which the file names a unit that is not read may be in any. Others are seconds if that is a
/// plausible rate. A stated rate above every plausible one is not accepted: a slip by ten would otherwise
/// make a unit of its own.
pub(super) fn unit_by_rate(
    rate_in_seconds: f64,
    stated_hz: f64,
    origin: UnitOrigin,
    first: f64,
) -> Option<f64> {
    let seconds = rate_in_seconds / stated_hz;
    let absolute = absolute_clock(first, rate_in_seconds);
    let natural = natural_unit(seconds, absolute).map(TimeUnit::seconds);
    if absolute.is_some() {
        return natural;
    }
    if origin == UnitOrigin::Unread {
        return Some(natural.unwrap_or(seconds));
    }
    let plausible = |unit: &TimeUnit| {
        let rate = rate_in_seconds / unit.seconds();
        let contradicts = *unit == TimeUnit::SECOND || rate < stated_hz * (1.0 - UNIT_AGREEMENT);
        PLAUSIBLE_HZ.contains(&rate) && contradicts
    };
    let slower = natural_units(None).iter().any(plausible);
    natural
        .or_else(|| power_of_ten(seconds))
        .filter(|_| !slower)
}

/// Returns the power of ten that a length is [s], if it is one.
fn power_of_ten(seconds: f64) -> Option<f64> {
    let power = format!("{seconds:.2e}");
    let power: f64 = power
        .strip_prefix("1.00e")
        .map(|exponent| format!("1e{exponent}"))?
        .parse()
        .ok()?;
    ((power / seconds - 1.0).abs() <= UNIT_AGREEMENT).then_some(power)
}
