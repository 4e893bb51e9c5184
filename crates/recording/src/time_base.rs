//! Time bases: from printed stamps to a uniform rate, or to a resampled one with a finding.
//!
//! Stamps are rounded where they are printed: at 12 kHz and microseconds they step by 83 and
//! 84 µs. A clock is therefore taken as uniform if a line t0 + n·dt passes within half a last
//! printed digit of every stamp, or within 1 % of the interval, whichever is larger. Among
//! the lines that fit, the one with the plainest number is chosen: an interval of 80 µs, a
//! rate of 9600 Hz, and only then the least-squares line.
//!
//! Where no line fits, rows may be missing from a uniform clock (a gap, which blocks), or the
//! clock is irregular (a warning): the samples are then interpolated at the median rate.
//!
//! Interpolation between irregular stamps is linear. It damps frequencies near half the sampling rate, so it
//! suits a recording sampled well above its relevant frequencies.

use super::{Finding, Limits, ReadOptions};
use crate::error::{Error, ErrorKind};
use crate::setting::Setting;
use latchgate_kernel::error::Error as KernelError;
use latchgate_kernel::range::Range;
use latchgate_kernel::units::SampleRate;

/// Share of the sample interval by which a stamp of a uniform clock may differ [-].
const JITTER: f64 = 0.01;

/// Steps beyond this multiple of the median are gaps [-].
const GAP: f64 = 1.5;

/// Most significant digits of a number that a person chose.
const CHOSEN_DIGITS: usize = 3;

/// Significant digits beyond which rounding to a plain number gains nothing.
const PLAIN_DIGITS: usize = 7;

/// Returns the rate that an interval [s] printed with a last digit of `printed_digit_s` [s]
/// means: the plainest one within half that digit, as for stamps.
///
/// # Errors
///
/// [`NotPositive`](latchgate_kernel::error::Error::NotPositive) if the interval is not finite and positive.
pub fn rate_of_interval(interval_s: f64, printed_digit_s: f64) -> Result<SampleRate, Error> {
    let stated = latchgate_kernel::units::SampleInterval::from_seconds(interval_s)?;
    let digit = believed_digit(printed_digit_s, interval_s);
    let slack = 0.5 * digit * (1.0 + 1e-9) + 4.0 * f64::EPSILON * interval_s;
    let plain = plain_rates(interval_s, slack, 15).next();
    Ok(SampleRate::from_hertz(
        plain.unwrap_or(stated.rate().hertz()),
    )?)
}

/// Returns the last printed digit [s], bounded by the step. A digit coarser than the step would print the
/// same stamp twice, so it is wrong and must not turn any clock into a uniform one.
fn believed_digit(printed_s: f64, step_s: f64) -> f64 {
    match printed_s.is_finite() {
        true => printed_s.clamp(0.0, step_s),
        false => 0.0,
    }
}

/// A uniform time base found in stamps; it serves every channel that shares them.
#[derive(Debug, Clone, PartialEq)]
pub struct TimeBase {
    /// Time of the first sample [s].
    pub start_s: f64,
    /// Sample rate.
    pub rate: SampleRate,
    /// Samples on the uniform base.
    pub samples: usize,
    /// Findings on the stamps.
    pub findings: Vec<Finding>,
    resampling: Resampling,
}

/// Conversion of samples at stamps to samples on the base.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Resampling {
    /// One for one.
    Keep,
    /// Each stays at its place; the missing ones between are interpolated.
    Fill,
    /// All are interpolated.
    Interpolate,
}

impl TimeBase {
    /// Finds the uniform time base of increasing stamps [s].
    ///
    /// `printed_digit_s` is the size of the last printed digit of a stamp [s], 0 if unknown.
    ///
    /// # Errors
    ///
    /// - [`TooShort`](latchgate_kernel::error::Error::TooShort) with fewer than two stamps,
    /// - [`NonFinite`](latchgate_kernel::error::Error::NonFinite) for a stamp that is no finite number,
    /// - [`ErrorKind::TimeNotIncreasing`] where a stamp repeats or goes back,
    /// - [`ErrorKind::LimitExceeded`] if filling gaps would take more samples than allowed.
    pub fn fit(stamps_s: &[f64], printed_digit_s: f64, limits: &Limits) -> Result<Self, Error> {
        check_stamps(stamps_s)?;
        let clock = ClockEstimate::measure(stamps_s, printed_digit_s);
        // One or two long steps fit many a line if a stamp has few digits: a row missing from
        // a 10 kHz record printed to 0.1 ms looks like a clock of 9997 Hz. The missing row is
        // the likelier story, and the safer one. Three or more that still fit a line cannot
        // be chance, for their distances must then agree to one row.
        if clock.long_steps == 0 || clock.long_steps >= 3 {
            let indices = (0..stamps_s.len()).map(|count| count as f64);
            if let Some(line) = clock.fit_line(stamps_s, indices) {
                return line.into_base(stamps_s.len(), Resampling::Keep, Vec::new(), limits);
            }
        }
        let mut findings: Vec<Finding> = clock.gap_finding(stamps_s).into_iter().collect();
        if clock.long_steps > 0 {
            let indices = clock.indices_with_gaps(stamps_s);
            if let Some(line) = clock.fit_line(stamps_s, indices.iter().copied()) {
                let last = indices.last().copied().unwrap_or(0.0);
                return line.into_base(count_samples(last)?, Resampling::Fill, findings, limits);
            }
        }
        findings.push(clock.irregular_finding());
        let line = ClockLine {
            start: stamps_s[0],
            rate: clock.rate_to_resample(),
        };
        let steps = (clock.span * line.rate * (1.0 + 4.0 * f64::EPSILON)).floor();
        line.into_base(
            count_samples(steps)?,
            Resampling::Interpolate,
            findings,
            limits,
        )
    }

    /// Builds a base that is stated: `samples` samples from `start_s` [s] on.
    pub(super) fn stated(
        start_s: f64,
        rate: SampleRate,
        samples: usize,
        findings: Vec<Finding>,
    ) -> Self {
        Self {
            start_s,
            rate,
            samples,
            findings,
            resampling: Resampling::Keep,
        }
    }

    /// Converts the values at `stamps_s`, to which the base was fitted, to the base; a stated base needs no
    /// stamps.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Malformed`] if there are not as many values as stamps.
    pub fn apply(&self, stamps_s: &[f64], values: Vec<f64>) -> Result<Vec<f64>, Error> {
        let count = match self.resampling {
            Resampling::Keep => self.samples,
            Resampling::Fill | Resampling::Interpolate => stamps_s.len(),
        };
        if values.len() != count {
            return Err(Error::malformed(
                format!("{count} values, one for each stamp"),
                format!("{}", values.len()),
                "correct the recording",
            ));
        }
        let place = |stamp: &f64| (stamp - self.start_s) * self.rate.hertz();
        let places = stamps_s.iter().map(place);
        Ok(match self.resampling {
            Resampling::Keep => values,
            Resampling::Fill => interpolate(places.map(f64::round), &values, self.samples),
            Resampling::Interpolate => interpolate(places, &values, self.samples),
        })
    }
}

fn check_stamps(stamps_s: &[f64]) -> Result<(), Error> {
    if stamps_s.len() < 2 {
        return Err(Error::too_short("a time base", 2, stamps_s.len()));
    }
    if let Some(stamp) = stamps_s.iter().find(|stamp| !stamp.is_finite()) {
        return Err(non_finite(stamp.to_string()));
    }
    stamps_s.windows(2).try_for_each(check_rising)?;
    match (stamps_s[stamps_s.len() - 1] - stamps_s[0]).is_finite() {
        true => Ok(()),
        false => Err(non_finite("a span of time too large to count")),
    }
}

fn non_finite(found: impl Into<String>) -> Error {
    let found = found.into();
    KernelError::NonFinite { found }.into()
}

/// Refuses a last stamp that is not later than the one before.
pub(super) fn check_rising(stamps_s: &[f64]) -> Result<(), Error> {
    match *stamps_s {
        [.., previous, found] if found <= previous => {
            Err(ErrorKind::TimeNotIncreasing { previous, found }.into())
        }
        _ => Ok(()),
    }
}

/// Rates outside of which a stated unit of time is doubted [Hz].
const PLAUSIBLE_STATED: Range = Range::new(1.0, 200e3);

/// Rates outside of which an assumed unit of time is doubted [Hz]; no crash recording is slower.
const PLAUSIBLE_ASSUMED: Range = Range::new(250.0, 200e3);

/// Rate from which on a person must confirm the unit of time [Hz]: a header that states milliseconds for
/// seconds makes 1 MHz of 1 kHz, and the pulse a thousandth of its length.
const INCREDIBLE: f64 = 500e3;

/// Rate below which seconds are not assumed [Hz]: nanoseconds and microseconds read as seconds give such
/// rates.
const LEAST_ASSUMED: f64 = 0.2;

/// Largest relative difference between a stated rate and that of the file [-].
const RATE_AGREEMENT: f64 = 1e-3;

/// The remedy for a wrong rate of a file whose format fixes the unit of times.
pub(super) const MEND: &str = "correct the file";

/// True if a stated rate is that of the file, but for its digits.
pub(super) fn rates_agree(stated_hz: f64, hertz: f64) -> bool {
    (stated_hz - hertz).abs() <= RATE_AGREEMENT * hertz
}

impl ReadOptions {
    /// Compares a rate that the file gives [Hz] with the one that option or card state, and warns of one that
    /// crash recordings do not have; an incredible one is refused unless a person has stated it. `source` is
    /// the file's source of the rate, with true if seconds are `assumed` because the unit of its times is not
    /// stated; `mend` is the remedy.
    pub(super) fn check_rate(
        &self,
        rate: f64,
        (source, assumed): (&str, bool),
        mend: &str,
    ) -> Result<Option<Finding>, Error> {
        let source = if assumed {
            &format!("{source}, seconds assumed")
        } else {
            source
        };
        let found = format!("{rate} Hz by {source}");
        if let Some(stated) = self.rate_hz
            && !rates_agree(stated, rate)
        {
            let expected = format!("the stated rate of {stated} Hz");
            let hint = format!("{mend}, or leave out the setting `rate_hz`");
            return Err(Error::malformed(expected, found, hint));
        }
        let plausible = match assumed {
            true => PLAUSIBLE_ASSUMED,
            false => PLAUSIBLE_STATED,
        };
        let incredible = rate > INCREDIBLE || (rate < LEAST_ASSUMED && assumed);
        if incredible && self.rate_hz.is_none() {
            let expected = "a rate that crash recordings have";
            let hint = format!("{mend}, or confirm the rate with the setting `rate_hz` = HZ");
            return Err(Error::malformed(expected, found, hint));
        }
        let text = format!("{found}, which no crash recording has. If that is wrong, {mend}");
        let is_implausible = !plausible.contains(rate);
        Ok(is_implausible.then(|| Finding::warning("time-unit-implausible", text)))
    }

    /// Returns the rate of a LabVIEW file without timing, as a person states it, else the one sample a second
    /// of the file, with a finding; `interval` names the file's statement.
    pub(super) fn untimed(
        &self,
        file_rate: SampleRate,
        interval: &str,
    ) -> Result<(SampleRate, Finding), Error> {
        let setting = Setting::RateHz;
        let (rate, remedy) = match self.rate_hz {
            Some(hertz) => {
                let remedy = format!("The stated {hertz} Hz was used");
                (SampleRate::from_hertz(hertz)?, remedy)
            }
            None => (file_rate, format!("State the rate with {setting} = HZ")),
        };
        let text = format!(
            "{interval} is 1, as LabVIEW writes it where the samples have no timing. {remedy}"
        );
        Ok((rate, Finding::warning("timing-absent", text)))
    }
}

/// Returns half a printed digit with the rounding of `f64` on top [s].
fn half_digit(digit: f64, first: f64, last: f64) -> f64 {
    let largest = first.abs().max(last.abs()).max(last - first);
    0.5 * digit * (1.0 + 1e-9) + 8.0 * f64::EPSILON * largest
}

/// Estimate of a clock from its stamps, before a line is fitted.
struct ClockEstimate {
    /// Last stamp less the first [s].
    span: f64,
    /// Median step [s].
    median: f64,
    /// Mean of the steps that are no gaps [s]; free of the rounding that the median carries.
    mean: f64,
    /// Shortest and longest step that is no gap [s].
    steps: Range,
    /// Steps longer than [`GAP`] medians.
    long_steps: usize,
    /// Half a last printed digit and the rounding of `f64` [s].
    half_digit: f64,
    /// Size of the last printed digit [s].
    digit: f64,
}

impl ClockEstimate {
    fn measure(stamps_s: &[f64], printed_digit_s: f64) -> Self {
        let (first, last) = (stamps_s[0], stamps_s[stamps_s.len() - 1]);
        let span = last - first;
        let mut steps: Vec<f64> = stamps_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        // Of two middle steps the shorter is chosen, so that the longer counts as a gap, not as the clock.
        let middle = (steps.len() - 1) / 2;
        let median = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
        let longest = GAP * median;
        let (mut sum, mut count, mut range) = (0.0, 0_usize, Range::new(median, median));
        for pair in stamps_s.windows(2) {
            let step = pair[1] - pair[0];
            if step <= longest {
                sum += step;
                count += 1;
                range = Range::new(range.low.min(step), range.high.max(step));
            }
        }
        let digit = believed_digit(printed_digit_s, median);
        Self {
            span,
            median,
            mean: sum / count.max(1) as f64,
            steps: range,
            long_steps: steps.len() - count,
            half_digit: half_digit(digit, first, last),
            digit,
        }
    }

    /// Returns the plainest line within half a digit of all stamps, else the one within 1 %
    /// of the interval, else `None`. `indices` counts the samples, missing ones included.
    fn fit_line(
        &self,
        stamps_s: &[f64],
        indices: impl Iterator<Item = f64> + Clone,
    ) -> Option<ClockLine> {
        let steps = indices.clone().last().unwrap_or(0.0);
        let interval = least_squares_interval(stamps_s, indices.clone());
        if !(interval.is_finite() && interval > 0.0 && steps > 0.0) {
            return None;
        }
        let try_rate = |rate: f64, tolerance: f64| {
            let range = residual_range(stamps_s, indices.clone(), 1.0 / rate, 2.0 * tolerance)?;
            Some(ClockLine {
                start: start_within(range, stamps_s[0], rate, tolerance),
                rate,
            })
        };
        // Two stamps, each off by half a digit, bound the interval this well.
        let slack = 2.0 * self.half_digit / steps;
        let mut plain = plain_rates(interval, slack, PLAIN_DIGITS);
        if let Some(line) = plain.find_map(|rate| try_rate(rate, self.half_digit)) {
            return Some(line);
        }
        let jitter = JITTER * interval;
        if jitter > self.half_digit {
            // The clock itself has jitter. A number that a person chose is accepted if its drift over the whole
            // record is within the jitter.
            let slack = 2.0 * jitter / steps;
            let mut chosen = plain_rates(interval, slack, CHOSEN_DIGITS);
            let line = chosen.find_map(|rate| try_rate(rate, jitter));
            return line.or_else(|| try_rate(1.0 / interval, jitter));
        }
        let interval = minimax_interval(stamps_s, indices.clone(), interval, slack);
        try_rate(1.0 / interval, self.half_digit)
    }

    /// Counts the samples with the missing ones, a gap being a whole number of intervals.
    fn indices_with_gaps(&self, stamps_s: &[f64]) -> Vec<f64> {
        let mut index = 0.0;
        let mut indices = Vec::with_capacity(stamps_s.len());
        indices.push(index);
        for pair in stamps_s.windows(2) {
            let step = pair[1] - pair[0];
            index += if step > GAP * self.median {
                (step / self.mean).round()
            } else {
                1.0
            };
            indices.push(index);
        }
        indices
    }

    /// Returns the rate for interpolated samples: that of the median step, to three digits
    /// where these agree within 0.1 %. The rate of a resampled base is free, and 9999.98 Hz would be
    /// below the 10 kHz that a filter class needs.
    fn rate_to_resample(&self) -> f64 {
        let is_rounded = (self.mean - self.median).abs() <= self.digit;
        let step = if is_rounded { self.mean } else { self.median };
        let mut plain = plain_rates(step, 1e-3 * step, CHOSEN_DIGITS);
        plain.next().unwrap_or(1.0 / step)
    }

    fn gap_finding(&self, stamps_s: &[f64]) -> Option<Finding> {
        let mut gaps = stamps_s
            .windows(2)
            .filter(|pair| pair[1] - pair[0] > GAP * self.median);
        let first = gaps.next()?;
        let length = |gap: &[f64]| gap[1] - gap[0];
        let longest = gaps.fold(first, |longest, gap| {
            if length(gap) > length(longest) {
                gap
            } else {
                longest
            }
        });
        let mut text = format!(
            "{} in time: after {} s on the file's clock the next sample comes {} s later. The \
             median step is {} s",
            match self.long_steps {
                1 => "a gap".into(),
                count => format!("{count} gaps"),
            },
            brief(first[0]),
            brief(first[1] - first[0]),
            brief(self.median)
        );
        if self.long_steps > 1 {
            text.push_str(&format!(
                ". The longest, {} s, begins at {} s",
                brief(longest[1] - longest[0]),
                brief(longest[0])
            ));
        }
        text.push_str(". What happened in between is unknown. Record or export again");
        Some(Finding::blocking("gap", text).at(first[0]))
    }

    fn irregular_finding(&self) -> Finding {
        let Range { low, high } = self.steps;
        let deviation = (high - self.median).max(self.median - low);
        let text = format!(
            "the stamps follow no uniform clock: steps of {} to {} s (gaps left out) around a \
             median of {} s, off by up to {:.1} %. The samples were interpolated at {} Hz. Export \
             at the recorder's rate",
            brief(low),
            brief(high),
            brief(self.median),
            100.0 * deviation / self.median,
            brief(self.rate_to_resample())
        );
        Finding::warning("time-irregular", text)
    }
}

/// A uniform clock: start [s] and rate [Hz].
struct ClockLine {
    start: f64,
    rate: f64,
}

impl ClockLine {
    fn into_base(
        self,
        samples: usize,
        resampling: Resampling,
        findings: Vec<Finding>,
        limits: &Limits,
    ) -> Result<TimeBase, Error> {
        if samples as u64 > limits.samples {
            let reason = findings.first().map_or("", |finding| finding.text.as_str());
            let found = format!("{samples} samples on a uniform time base ({reason})");
            return Err(limits.over("samples", found));
        }
        Ok(TimeBase {
            start_s: self.start,
            rate: SampleRate::from_hertz(self.rate)?,
            samples,
            findings,
            resampling,
        })
    }
}

/// Returns the number of samples after `steps` steps; beyond what memory can count it is a
/// number that every limit refuses.
fn count_samples(steps: f64) -> Result<usize, Error> {
    if !steps.is_finite() || steps < 0.0 {
        return Err(non_finite("a number of samples too large to count"));
    }
    let count = steps.min(1e15) as usize;
    Ok(count + 1)
}

/// Returns the slope of the least-squares line through the stamps over their indices [s].
fn least_squares_interval(stamps_s: &[f64], indices: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = stamps_s.len() as f64;
    let first = stamps_s[0];
    let index_mean = indices.clone().sum::<f64>() / count;
    let stamp_mean = stamps_s.iter().map(|stamp| stamp - first).sum::<f64>() / count;
    let (mut product, mut square) = (0.0, 0.0);
    for (stamp, index) in stamps_s.iter().zip(indices) {
        let from_mean = index - index_mean;
        product += from_mean * (stamp - first - stamp_mean);
        square += from_mean * from_mean;
    }
    product / square
}

/// Returns the least and greatest of stamp − index·interval [s], unless they lie more than
/// `width` apart.
fn residual_range(
    stamps_s: &[f64],
    indices: impl Iterator<Item = f64>,
    interval: f64,
    width: f64,
) -> Option<Range> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for (stamp, index) in stamps_s.iter().zip(indices) {
        let residual = stamp - index * interval;
        low = low.min(residual);
        high = high.max(residual);
        if high - low > width {
            return None;
        }
    }
    Some(Range { low, high })
}

/// Returns a start from which every stamp lies within `tolerance` of the line: the first
/// stamp if it serves, else a whole number of intervals from zero, else the middle.
fn start_within(range: Range, first: f64, rate: f64, tolerance: f64) -> f64 {
    let fits = |start: &f64| range.high - start <= tolerance && start - range.low <= tolerance;
    let on_grid = (first * rate).round() / rate;
    let plain = [first, on_grid].into_iter().find(fits);
    plain.unwrap_or(0.5 * (range.low + range.high))
}

/// Returns the interval near `interval` whose line has the smallest largest residual [s].
///
/// The width of the residuals is a convex function of the interval, so halving an interval of
/// three parts finds its minimum. It is needed only for a few coarse stamps, where the least
/// squares may miss the narrow range of lines that fit.
fn minimax_interval(
    stamps_s: &[f64],
    indices: impl Iterator<Item = f64> + Clone,
    interval: f64,
    slack: f64,
) -> f64 {
    let width = |interval: f64| {
        residual_range(stamps_s, indices.clone(), interval, f64::INFINITY)
            .map_or(f64::INFINITY, Range::width)
    };
    let (mut low, mut high) = (interval - slack, interval + slack);
    for _ in 0..80 {
        let third = (high - low) / 3.0;
        if width(low + third) <= width(high - third) {
            high -= third;
        } else {
            low += third;
        }
    }
    0.5 * (low + high)
}

/// Returns the rates [Hz] within `slack` [s] of `interval` [s] that have a plain number, as
/// an interval or as a rate, the plainest first.
fn plain_rates(interval: f64, slack: f64, max_digits: usize) -> impl Iterator<Item = f64> {
    (1..=max_digits)
        .flat_map(move |digits| {
            [
                // The reciprocal of a plain decimal is cleaned of the rounding of division, so
                // that 80 µs are 12500 Hz and not 12499.999999999998 Hz.
                round_to_digits(1.0 / round_to_digits(interval, digits), 14),
                round_to_digits(1.0 / interval, digits),
            ]
        })
        .filter(move |rate| {
            rate.is_finite() && *rate > 0.0 && (1.0 / rate - interval).abs() <= slack
        })
}

/// Rounds to a number of significant decimal digits.
pub(super) fn round_to_digits(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

/// Writes a number with six significant digits.
pub(super) fn brief(value: f64) -> String {
    format!("{}", round_to_digits(value, 6))
}

/// Interpolates `values` at increasing `places` (in intervals from the start) linearly at
/// 0, 1, 2 …; before the first and after the last place the value stays.
fn interpolate(places: impl Iterator<Item = f64>, values: &[f64], samples: usize) -> Vec<f64> {
    let mut result = Vec::with_capacity(samples);
    let mut previous: Option<(f64, f64)> = None;
    for (place, value) in places.zip(values.iter().copied()) {
        while result.len() < samples && (result.len() as f64) <= place {
            let target = result.len() as f64;
            result.push(match previous {
                Some((from, start)) if target < place && place > from => {
                    start + (value - start) * ((target - from) / (place - from))
                }
                _ => value,
            });
        }
        previous = Some((place, value));
    }
    let last = values.last().copied().unwrap_or(0.0);
    result.resize(samples, last);
    result
}
