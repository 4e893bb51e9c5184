//! The signal that drives a lever, and how it is read between its samples.

#![expect(
    clippy::needless_range_loop,
    reason = "in code compiled for the machine's vectors adaptors such as zip stay calls"
)]

use crate::error::Error;
use crate::range::Range;
use crate::units::SampleRate;
use std::borrow::Cow;
use twofloat::TwoFloat;

/// A uniformly sampled acceleration.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    /// Time of the first sample [s].
    pub start_s: f64,
    /// Sample rate.
    pub rate: SampleRate,
    /// Samples [m/s²], in the recording's own polarity.
    pub samples: Vec<f64>,
}

impl Signal {
    /// Returns the time of sample `index` [s].
    pub fn time_s(&self, index: usize) -> f64 {
        self.start_s + index as f64 / self.rate.hertz()
    }

    /// Returns the time of the last sample [s], or the start of an empty signal.
    pub fn end_s(&self) -> f64 {
        self.time_s(self.samples.len().saturating_sub(1))
    }
}

/// A signal as it is read: one polynomial per interval between samples, zero after the last.
///
/// Straight lines, or polynomials of fifth degree through the samples and the first and second
/// derivatives there: those come from whoever knows what lies between.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading<'a> {
    signal: Cow<'a, Signal>,
    /// First derivative at each sample [m/s² per interval]; none of straight lines.
    slopes: Cow<'a, [f64]>,
    /// Second derivative at each sample [m/s² per interval²]; none of polynomials of third degree.
    bends: Cow<'a, [f64]>,
    tail: Tail,
    /// What another sensor at the same place recorded at the same instants, read alike.
    second: Option<Box<Reading<'a>>>,
}

/// How the accelerations of two sensors at one place make the one along the way of a lever's centre of mass and
/// the one across it: direction cosines of the first and the second sensor [-].
///
/// The first is in the recording's own polarity, as [`OpensWhen`](crate::units::OpensWhen) says; across, away
/// from the pivot is positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projection {
    /// Along the way of the centre of mass at φ = 0.
    pub tangential: [f64; 2],
    /// From the pivot to it.
    pub radial: [f64; 2],
}

impl Projection {
    /// The first sensor measures along the way of the centre of mass, the second across it.
    pub const ALIGNED: Self = Self {
        tangential: [1.0, 0.0],
        radial: [0.0, 1.0],
    };
}

/// The end of a pulse, from which on the acceleration is constant, whatever the sample there says: that one
/// ends the interval before it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Tail {
    /// Its first interval; [`usize::MAX`] of a signal without one.
    from: usize,
    /// The acceleration in it [m/s²].
    level: f64,
}

impl Tail {
    const NONE: Self = Self {
        from: usize::MAX,
        level: 0.0,
    };
}

impl<'a> From<&'a Signal> for Reading<'a> {
    /// Reads the samples by straight lines.
    fn from(signal: &'a Signal) -> Self {
        Self::of_parts(Cow::Borrowed(signal), Vec::new(), Vec::new())
    }
}

impl From<Signal> for Reading<'_> {
    /// Reads the samples by straight lines.
    fn from(signal: Signal) -> Self {
        Self::of_parts(Cow::Owned(signal), Vec::new(), Vec::new())
    }
}

impl<'a> From<&'a Reading<'_>> for Reading<'a> {
    fn from(reading: &'a Reading<'_>) -> Self {
        Self {
            signal: Cow::Borrowed(&reading.signal),
            slopes: Cow::Borrowed(&reading.slopes),
            bends: Cow::Borrowed(&reading.bends),
            tail: reading.tail,
            second: reading
                .second
                .as_deref()
                .map(|second| Box::new(second.into())),
        }
    }
}

/// Terms of a straight line.
pub(crate) const STRAIGHT: usize = 2;

/// Terms of the other polynomials.
pub(crate) const CURVED: usize = 6;

impl<'a> Reading<'a> {
    /// Reads the samples by polynomials of fifth degree, of these first and second derivatives at the
    /// samples [m/s² per interval and per interval²].
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] unless there is one of each for each sample.
    pub fn quintic(
        signal: Cow<'a, Signal>,
        slopes: Vec<f64>,
        bends: Vec<f64>,
    ) -> Result<Self, Error> {
        let count = signal.samples.len();
        if slopes.len() != count || bends.len() != count {
            return Err(Error::out_of_range(
                "derivatives",
                format!("{count} of each"),
                format!("{} and {}", slopes.len(), bends.len()),
            ));
        }
        Ok(Self::of_parts(signal, slopes, bends))
    }

    fn of_parts(signal: Cow<'a, Signal>, slopes: Vec<f64>, bends: Vec<f64>) -> Self {
        Self {
            signal,
            slopes: Cow::Owned(slopes),
            bends: Cow::Owned(bends),
            tail: Tail::NONE,
            second: None,
        }
    }

    /// Puts what a second sensor recorded beside it.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] unless both have as many samples at the same instants and are read alike, and
    /// neither is a pulse that ends between its samples.
    pub fn beside(mut self, second: Reading<'a>) -> Result<Self, Error> {
        let (first_clock, second_clock) = (self.clock(), second.clock());
        let is_alike = self.is_straight() == second.is_straight();
        let ends = self.tail != Tail::NONE || second.tail != Tail::NONE;
        if first_clock != second_clock || !is_alike || ends || second.second.is_some() {
            return Err(Error::out_of_range(
                "samples, start [s] and rate [Hz] of the second sensor",
                format!("those of the first, {first_clock:?}, read alike, without an end"),
                format!("{second_clock:?}"),
            ));
        }
        self.second = Some(Box::new(second));
        Ok(self)
    }

    fn clock(&self) -> (usize, f64, f64) {
        let Signal {
            start_s,
            rate,
            samples,
        } = self.signal();
        (samples.len(), *start_s, rate.hertz())
    }

    /// Returns what the second sensor recorded.
    pub fn second(&self) -> Option<&Reading<'a>> {
        self.second.as_deref()
    }

    /// Returns the accelerations along the way of the centre of mass and, beside it, across; the reading
    /// itself where there is no second sensor.
    pub fn projected(&self, projection: &Projection) -> Reading<'_> {
        let second = match &self.second {
            Some(second) if *projection != Projection::ALIGNED => second,
            _ => return self.into(),
        };
        let part = |cosines: [f64; 2]| {
            let sum = |first: &[f64], second: &[f64]| {
                let pairs = first.iter().zip(second);
                pairs
                    .map(|(first, second)| cosines[0] * first + cosines[1] * second)
                    .collect()
            };
            let signal = Signal {
                samples: sum(&self.signal.samples, &second.signal.samples),
                ..*self.signal
            };
            let slopes = sum(&self.slopes, &second.slopes);
            let bends = sum(&self.bends, &second.bends);
            Reading::of_parts(Cow::Owned(signal), slopes, bends)
        };
        Reading {
            second: Some(Box::new(part(projection.radial))),
            ..part(projection.tangential)
        }
    }

    /// Lets the acceleration be zero from sample `index` on, with a jump from what that sample says.
    pub fn ending_at(mut self, index: usize) -> Self {
        self.tail = Tail {
            from: index,
            level: 0.0,
        };
        self
    }

    /// Returns the reading of every sample times `scale` plus `offset_m_s2`; a second sensor's as it is.
    pub fn scaled(&self, scale: f64, offset_m_s2: f64) -> Reading<'static> {
        let times = |values: &[f64]| values.iter().map(|value| scale * value).collect();
        let samples = self.signal.samples.iter();
        let signal = Signal {
            samples: samples.map(|a| scale * a + offset_m_s2).collect(),
            ..*self.signal
        };
        Reading {
            tail: Tail {
                level: scale * self.tail.level + offset_m_s2,
                ..self.tail
            },
            second: self
                .second
                .as_ref()
                .map(|second| Box::new(second.scaled(1.0, 0.0))),
            ..Reading::of_parts(Cow::Owned(signal), times(&self.slopes), times(&self.bends))
        }
    }

    /// Returns the reading with every sample of the second sensor times `scale` plus `offset_m_s2`.
    pub fn with_second_scaled(self, scale: f64, offset_m_s2: f64) -> Self {
        let second = self
            .second
            .map(|second| Box::new(second.scaled(scale, offset_m_s2)));
        Self { second, ..self }
    }

    /// Reads the same samples and first derivatives by polynomials of third degree.
    pub fn cubic(&self) -> Reading<'_> {
        Reading {
            bends: Cow::Borrowed(&[]),
            second: self.second.as_ref().map(|second| Box::new(second.cubic())),
            ..self.into()
        }
    }

    /// Returns how far each interval's polynomial of fifth degree is from that of third degree halfway
    /// [m/s²]; nothing of straight lines or third degree.
    pub fn beyond_cubic(&self) -> impl Iterator<Item = f64> {
        let pairs = self.slopes.windows(2).zip(self.bends.windows(2));
        pairs.map(|(slopes, bends)| (slopes[0] - slopes[1]) / 32.0 + (bends[0] + bends[1]) / 64.0)
    }

    /// Adds so many times another signal of as many samples, read alike; of signals without an end of their own.
    /// A second sensor's is added where both have one.
    pub fn plus(&self, times: f64, other: &Reading<'_>) -> Reading<'static> {
        let sum = |of: &[f64], other: &[f64]| {
            let pairs = of.iter().zip(other);
            pairs.map(|(a, b)| a + times * b).collect()
        };
        let signal = Signal {
            samples: sum(&self.signal.samples, &other.signal.samples),
            ..*self.signal
        };
        let slopes = sum(&self.slopes, &other.slopes);
        let bends = sum(&self.bends, &other.bends);
        let seconds = self.second.as_deref().zip(other.second.as_deref());
        Reading {
            second: seconds.map(|(second, other)| Box::new(second.plus(times, other))),
            ..Reading::of_parts(Cow::Owned(signal), slopes, bends)
        }
    }

    /// Returns bounds of the acceleration in the interval after each sample, by the Bernstein coefficients
    /// of its polynomial [m/s²].
    pub fn ranges(&self) -> Vec<Range> {
        let intervals = 0..self.signal.samples.len().saturating_sub(1);
        if self.is_straight() {
            let pieces = self.pieces::<STRAIGHT>();
            intervals.map(|index| pieces.range(index)).collect()
        } else {
            let pieces = self.pieces::<CURVED>();
            intervals.map(|index| pieces.range(index)).collect()
        }
    }

    /// Returns the samples.
    pub fn signal(&self) -> &Signal {
        &self.signal
    }

    /// True of straight lines.
    pub fn is_straight(&self) -> bool {
        self.slopes.is_empty()
    }

    /// Returns the acceleration at `part`, 0 to 1, of the interval after sample `index` [m/s²]; none after
    /// the last.
    pub fn at(&self, index: usize, part: f64) -> Option<f64> {
        if index + 1 >= self.signal.samples.len() {
            return None;
        }
        Some(if self.is_straight() {
            value(&self.pieces::<STRAIGHT>().terms(index), part)
        } else {
            value(&self.pieces::<CURVED>().terms(index), part)
        })
    }

    /// Returns the reading with each interval divided into `parts`, the same everywhere; the reading
    /// itself where there is nothing to divide.
    pub fn divided(&self, parts: usize) -> Reading<'_> {
        let signal = self.signal();
        let rate = SampleRate::from_hertz(signal.rate.hertz() * parts as f64);
        let (true, Ok(rate), Some(last)) = (parts > 1, rate, signal.samples.last()) else {
            return self.into();
        };
        let part = 1.0 / parts as f64;
        let places = (0..signal.samples.len() - 1)
            .flat_map(|index| (0..parts).map(move |n| (index, n as f64)));
        let (straight, curved) = (self.pieces::<STRAIGHT>(), self.pieces::<CURVED>());
        // The sample at which a pulse ends stays what it is: the interval before it ends with it.
        let is_end = |index: usize, n: f64| index == self.tail.from && n <= 0.0;
        let mut samples: Vec<f64> = if self.is_straight() {
            let along = |(index, n): (usize, f64)| {
                let terms = straight.terms(index);
                let from = if is_end(index, n) {
                    signal.samples[index]
                } else {
                    terms[0]
                };
                from + terms[1] / parts as f64 * n
            };
            places.clone().map(along).collect()
        } else {
            let value_at = |(index, n)| match is_end(index, n) {
                true => signal.samples[index],
                false => value(&curved.terms(index), part * n),
            };
            places.clone().map(value_at).collect()
        };
        samples.push(*last);
        let derivative = |order: u8, at_samples: &[f64]| {
            let scale = if order == 1 { part } else { part * part };
            let derivative_at = |(index, n)| {
                let c = curved.terms(index);
                scale
                    * if is_end(index, n) {
                        at_samples[index]
                    } else if order == 1 {
                        slope(&c, part * n)
                    } else {
                        bend(&c, part * n)
                    }
            };
            let mut derivatives: Vec<f64> = Vec::new();
            if let Some(last) = at_samples.last() {
                derivatives.extend(places.clone().map(derivative_at));
                derivatives.push(scale * last);
            }
            derivatives
        };
        let signal = Signal {
            rate,
            samples,
            ..*signal
        };
        let (slopes, bends) = (derivative(1, &self.slopes), derivative(2, &self.bends));
        Reading {
            tail: Tail {
                from: self.tail.from.saturating_mul(parts),
                ..self.tail
            },
            second: self
                .second
                .as_ref()
                .map(|second| Box::new(second.divided(parts))),
            ..Reading::of_parts(Cow::Owned(signal), slopes, bends)
        }
    }

    /// Returns the polynomials; `K` is [`STRAIGHT`] for straight lines alone.
    pub(crate) fn pieces<const K: usize>(&self) -> Pieces<'_, K> {
        Pieces {
            signal: &self.signal,
            slopes: &self.slopes,
            bends: &self.bends,
            tail: self.tail,
            second: self.second.as_deref(),
        }
    }
}

/// The polynomials of a reading, made where they are asked for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pieces<'a, const K: usize> {
    pub(crate) signal: &'a Signal,
    slopes: &'a [f64],
    bends: &'a [f64],
    tail: Tail,
    second: Option<&'a Reading<'a>>,
}

/// The polynomial of one interval, in powers of the part of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Piece<const K: usize> {
    /// Coefficients [m/s²].
    pub(crate) terms: [f64; K],
    /// The sample at its end [m/s²].
    pub(crate) end: f64,
    /// Bounds of its values, by its Bernstein coefficients [m/s²].
    pub(crate) range: Range,
}

/// Values and derivatives at both ends of an interval.
struct Ends {
    a: [f64; 2],
    d: [f64; 2],
    s: [f64; 2],
}

impl<'a> Pieces<'a, STRAIGHT> {
    /// Joins samples by straight lines.
    pub(crate) fn straight(signal: &'a Signal) -> Self {
        Self {
            signal,
            slopes: &[],
            bends: &[],
            tail: Tail::NONE,
            second: None,
        }
    }
}

impl<'a, const K: usize> Pieces<'a, K> {
    /// Returns the polynomials of the second sensor's reading.
    pub(crate) fn second(&self) -> Option<Self> {
        self.second.map(Reading::pieces)
    }
}

impl<const K: usize> Pieces<'_, K> {
    #[inline(always)]
    fn ends(&self, index: usize) -> Ends {
        if index >= self.tail.from {
            let (a, d) = ([self.tail.level; 2], [0.0; 2]);
            return Ends { a, d, s: d };
        }
        let a = [self.signal.samples[index], self.signal.samples[index + 1]];
        let d = [self.slopes[index], self.slopes[index + 1]];
        let s = if self.bends.is_empty() {
            let rise = 6.0 * (a[1] - a[0]);
            [
                rise - 4.0 * d[0] - 2.0 * d[1],
                2.0 * d[0] + 4.0 * d[1] - rise,
            ]
        } else {
            [self.bends[index], self.bends[index + 1]]
        };
        Ends { a, d, s }
    }

    /// Returns the values at both ends of interval `index`.
    #[inline(always)]
    fn line(&self, index: usize) -> [f64; 2] {
        if index >= self.tail.from {
            return [self.tail.level; 2];
        }
        [self.signal.samples[index], self.signal.samples[index + 1]]
    }

    /// Returns the coefficients of interval `index`.
    #[inline(always)]
    pub(crate) fn terms(&self, index: usize) -> [f64; K] {
        let mut terms = [0.0; K];
        if K == STRAIGHT {
            let [from, to] = self.line(index);
            (terms[0], terms[1]) = (from, to - from);
        } else {
            self.ends(index).terms(&mut terms);
        }
        terms
    }

    /// Returns the coefficients of interval `index` without rounding them to doubles.
    pub(crate) fn exact_terms(&self, index: usize) -> [TwoFloat; K] {
        let mut terms = [TwoFloat::from_f64(0.0); K];
        if K == STRAIGHT {
            let [from, to] = self.line(index);
            (terms[0], terms[1]) = (from.into(), TwoFloat::new_sub(to, from));
            return terms;
        }
        let Ends { a, d, s } = self.ends(index);
        let rise = TwoFloat::new_sub(a[1], a[0]);
        let [d, mut s] = [d, s].map(|pair| pair.map(TwoFloat::from_f64));
        if index < self.tail.from && self.bends.is_empty() {
            s = [
                6.0 * rise - 4.0 * d[0] - 2.0 * d[1],
                2.0 * d[0] + 4.0 * d[1] - 6.0 * rise,
            ];
        }
        terms[0] = a[0].into();
        terms[1] = d[0];
        terms[2] = 0.5 * s[0];
        terms[3] = 10.0 * rise - 6.0 * d[0] - 4.0 * d[1] - 1.5 * s[0] + 0.5 * s[1];
        terms[4] = -15.0 * rise + 8.0 * d[0] + 7.0 * d[1] + 1.5 * s[0] - s[1];
        terms[5] = 6.0 * rise - 3.0 * (d[0] + d[1]) - 0.5 * (s[0] - s[1]);
        terms
    }

    /// Returns the Bernstein coefficients of interval `index`: it lies nowhere outside them.
    #[inline(always)]
    pub(crate) fn control(&self, index: usize) -> [f64; K] {
        let mut control = [0.0; K];
        if K == STRAIGHT {
            [control[0], control[1]] = self.line(index);
        } else {
            self.ends(index).control(&mut control);
        }
        control
    }

    /// Returns least and largest value of interval `index`, or a little less and more.
    #[inline(always)]
    pub(crate) fn range(&self, index: usize) -> Range {
        range(&self.control(index))
    }

    /// Returns the polynomial of interval `index`.
    #[inline(always)]
    pub(crate) fn of(&self, index: usize) -> Piece<K> {
        let (mut terms, mut control) = ([0.0; K], [0.0; K]);
        if K == STRAIGHT {
            (terms, control) = (self.terms(index), self.control(index));
        } else {
            let ends = self.ends(index);
            ends.terms(&mut terms);
            ends.control(&mut control);
        }
        Piece {
            terms,
            end: self.line(index)[1],
            range: range(&control),
        }
    }

    /// Returns how many intervals from `first` on, before `last`, lie wholly above `level` with `sign`.
    #[inline(always)]
    pub(crate) fn above(&self, first: usize, last: usize, sign: f64, level: f64) -> usize {
        // Without closures, which would not be compiled for the machine's vectors.
        let mut index = first;
        while index < last {
            let Range { low, high } = self.range(index);
            if !((sign * low > level) & (sign * high > level)) {
                break;
            }
            index += 1;
        }
        index - first
    }
}

impl Ends {
    #[inline(always)]
    fn terms(&self, terms: &mut [f64]) {
        let Self { a, d, s } = self;
        let rise = a[1] - a[0];
        terms[0] = a[0];
        terms[1] = d[0];
        terms[2] = 0.5 * s[0];
        terms[3] = 10.0 * rise - 6.0 * d[0] - 4.0 * d[1] - 1.5 * s[0] + 0.5 * s[1];
        terms[4] = -15.0 * rise + 8.0 * d[0] + 7.0 * d[1] + 1.5 * s[0] - s[1];
        terms[5] = 6.0 * rise - 3.0 * (d[0] + d[1]) - 0.5 * (s[0] - s[1]);
    }

    #[inline(always)]
    fn control(&self, control: &mut [f64]) {
        let Self { a, d, s } = self;
        control[0] = a[0];
        control[1] = a[0] + 0.2 * d[0];
        control[2] = a[0] + 0.4 * d[0] + 0.05 * s[0];
        control[3] = a[1] - 0.4 * d[1] + 0.05 * s[1];
        control[4] = a[1] - 0.2 * d[1];
        control[5] = a[1];
    }
}

#[inline(always)]
fn range<const K: usize>(control: &[f64; K]) -> Range {
    let (mut low, mut high) = (control[0], control[0]);
    for n in 1..K {
        let c = control[n];
        // Of a number that is none the first stays.
        low = if c < low { c } else { low };
        high = if c > high { c } else { high };
    }
    Range { low, high }
}

/// How the accelerations of two sensors become one: a factor of each and what is added.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mix {
    /// Of the sensor that measures most of it.
    pub(crate) own: f64,
    /// Of the other one.
    pub(crate) other: f64,
    /// Added, in the unit of the sum.
    pub(crate) offset: f64,
}

impl Mix {
    /// Takes one sensor's alone.
    pub(crate) fn scaled(factor: f64, offset: f64) -> Self {
        Self {
            own: factor,
            other: 0.0,
            offset,
        }
    }

    /// Returns the same in a unit that is `gain` times smaller.
    pub(crate) fn times(self, gain: f64) -> Self {
        Self {
            own: gain * self.own,
            other: gain * self.other,
            offset: gain * self.offset,
        }
    }

    /// Returns the sum's coefficients over an interval and its largest magnitude there.
    #[inline(always)]
    pub(crate) fn of<const K: usize>(&self, own: &Piece<K>, other: &Piece<K>) -> ([f64; K], f64) {
        let mut terms = own.scaled(self.own, self.offset);
        for n in 0..K {
            terms[n] = self.other.mul_add(other.terms[n], terms[n]);
        }
        let strongest = own.strongest(self.own, self.offset) + other.strongest(self.other, 0.0);
        (terms, strongest)
    }
}

impl<const K: usize> Piece<K> {
    /// Returns the coefficients times `gain`, with `offset` added.
    #[inline(always)]
    pub(crate) fn scaled(&self, gain: f64, offset: f64) -> [f64; K] {
        let mut scaled = self.terms;
        for term in &mut scaled {
            *term *= gain;
        }
        scaled[0] = gain.mul_add(self.terms[0], offset);
        if K == STRAIGHT {
            scaled[1] = gain.mul_add(self.end, offset) - scaled[0];
        }
        scaled
    }

    /// Returns the largest magnitude of the values times `gain`, with `offset` added.
    #[inline(always)]
    pub(crate) fn strongest(&self, gain: f64, offset: f64) -> f64 {
        let (low, high) = (
            gain.mul_add(self.range.low, offset),
            gain.mul_add(self.range.high, offset),
        );
        low.abs().max(high.abs())
    }
}

/// Returns the value of a polynomial.
#[inline(always)]
pub(crate) fn value<const K: usize>(terms: &[f64; K], at: f64) -> f64 {
    let mut sum = terms[K - 1];
    for n in (0..K - 1).rev() {
        sum = sum * at + terms[n];
    }
    sum
}

/// Returns its derivative.
#[inline(always)]
pub(crate) fn slope<const K: usize>(terms: &[f64; K], at: f64) -> f64 {
    let mut sum = 0.0;
    for n in (1..K).rev() {
        sum = sum * at + n as f64 * terms[n];
    }
    sum
}

/// Returns its second derivative.
#[inline(always)]
pub(crate) fn bend<const K: usize>(terms: &[f64; K], at: f64) -> f64 {
    let mut sum = 0.0;
    for n in (2..K).rev() {
        sum = sum * at + (n * (n - 1)) as f64 * terms[n];
    }
    sum
}

/// Returns a bound on the second derivative's magnitude in the interval.
#[inline(always)]
pub(crate) fn bend_at_most<const K: usize>(terms: &[f64; K]) -> f64 {
    let mut sum = 0.0;
    for n in 2..K {
        sum += (n * (n - 1)) as f64 * terms[n].abs();
    }
    sum
}
