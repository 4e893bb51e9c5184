//! Axes: from values to units of the drawing, with ticks at round numbers.

use latchgate_document::number::{exact, superscript};

/// Least and largest value of an axis, and how it counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    /// Linear between two values.
    Linear(f64, f64),
    /// Logarithmic between two positive values.
    Logarithmic(f64, f64),
    /// So many cells, each of length one, without ticks.
    Cells(usize),
}

impl Default for Scale {
    fn default() -> Self {
        Self::Linear(0.0, 1.0)
    }
}

/// A stretch of values laid on a stretch of the drawing.
#[derive(Debug, Clone, Copy)]
pub struct Axis {
    low: f64,
    high: f64,
    /// Where `low` and `high` lie in the drawing.
    from: f64,
    to: f64,
    scale: Scale,
}

/// A value with its label; an empty label for a minor line.
#[derive(Debug, Clone, PartialEq)]
pub struct Tick {
    /// Where it stands, in data units.
    pub value: f64,
    /// What is written there; empty for a minor tick.
    pub label: String,
}

impl Axis {
    /// Lays a scale on `from..to`. An empty or infinite stretch is widened to a finite one; a
    /// logarithmic one without positive ends becomes 1 to 10.
    pub fn new(scale: Scale, from: f64, to: f64) -> Self {
        let (low, high) = match scale {
            Scale::Cells(count) => (0.0, count as f64),
            Scale::Logarithmic(low, high) if low > 0.0 && high > low && high.is_finite() => {
                (low, high)
            }
            Scale::Logarithmic(..) => (1.0, 10.0),
            Scale::Linear(low, high) if low.is_finite() && high.is_finite() && high > low => {
                (low, high)
            }
            Scale::Linear(low, _) if low.is_finite() => {
                let half = (low.abs() * 0.05).max(1e-9);
                (low - half, low + half)
            }
            Scale::Linear(..) => (0.0, 1.0),
        };
        Self {
            low,
            high,
            from,
            to,
            scale,
        }
    }

    /// As [`Axis::new`] of a linear scale.
    pub fn linear(low: f64, high: f64, from: f64, to: f64) -> Self {
        Self::new(Scale::Linear(low, high), from, to)
    }

    /// Returns the lower end.
    pub fn low(&self) -> f64 {
        self.low
    }

    /// Returns the upper end.
    pub fn high(&self) -> f64 {
        self.high
    }

    /// Returns where `value` lies in the drawing; not finite for a value that has no place.
    pub fn place(&self, value: f64) -> f64 {
        let share = if matches!(self.scale, Scale::Logarithmic(..)) {
            if value <= 0.0 {
                return f64::NAN;
            }
            (libm::log10(value) - libm::log10(self.low))
                / (libm::log10(self.high) - libm::log10(self.low))
        } else {
            (value - self.low) / (self.high - self.low)
        };
        self.from + share * (self.to - self.from)
    }

    /// True if `value` lies on the axis.
    pub fn contains(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }

    /// Returns the ticks: near every `spacing` units, and never so dense that labels of
    /// `character` units per letter would touch.
    pub fn ticks(&self, spacing: f64, character: f64) -> Vec<Tick> {
        let length = (self.to - self.from).abs();
        match self.scale {
            Scale::Linear(..) => {}
            Scale::Logarithmic(..) => return self.decades(),
            Scale::Cells(_) => return Vec::new(),
        }
        let mut target = (length / spacing).max(2.0);
        loop {
            let ticks = linear_ticks(self.low, self.high, target);
            let widest = ticks
                .iter()
                .map(|tick| tick.label.chars().count())
                .max()
                .unwrap_or(0);
            let crowded = widest as f64 * character * ticks.len() as f64 > length * 0.9;
            if !crowded || target <= 2.0 {
                return ticks;
            }
            target = (target / 1.5).max(2.0);
        }
    }

    fn decades(&self) -> Vec<Tick> {
        let first = libm::log10(self.low).floor() as i32;
        let last = libm::log10(self.high).ceil() as i32;
        let every = if last - first > 9 { 2 } else { 1 };
        let wide = (self.to - self.from).abs() / f64::from((last - first).max(1)) > 150.0;
        // All labels of an axis in one shape: 0.01, 0.1, 1 or powers of ten.
        let short = first >= -3 && last <= 5;
        let mut ticks = Vec::new();
        for decade in first..=last {
            let power = libm::pow(10.0, f64::from(decade));
            for times in 1..10 {
                let value = power * f64::from(times);
                if self.contains(value) {
                    let label = if times == 1 && (decade - first) % every == 0 {
                        decade_label(decade, short)
                    } else if wide && short && matches!(times, 2 | 5) {
                        exact(value)
                    } else {
                        String::new()
                    };
                    ticks.push(Tick { value, label });
                }
            }
        }
        ticks
    }
}

fn decade_label(decade: i32, short: bool) -> String {
    if short {
        return exact(libm::pow(10.0, f64::from(decade)));
    }
    let mut label = String::from("10");
    label.extend(decade.to_string().chars().map(superscript));
    label
}

/// Returns ticks at multiples of 1, 2 or 5 times a power of ten, about `target` of them.
fn linear_ticks(low: f64, high: f64, target: f64) -> Vec<Tick> {
    let rough = (high - low) / target;
    let decade = libm::log10(rough).floor();
    let power = libm::pow(10.0, decade);
    let (times, _) = [(1.0, 1.5), (2.0, 3.5), (5.0, 7.5), (10.0, f64::INFINITY)]
        .into_iter()
        .find(|(_, below)| rough / power < *below)
        .unwrap_or((10.0, f64::INFINITY));
    let step = times * power;
    let (first, last) = ((low / step).ceil(), (high / step).floor());
    // Values that differ only in their last digits have no round numbers between them.
    if !(step.is_normal() && last - first <= 100.0 && first.abs() < 1e15) {
        return Vec::new();
    }
    let decimals = if times >= 10.0 {
        -(decade as i32) - 1
    } else {
        -(decade as i32)
    };
    let magnitude = low.abs().max(high.abs());
    let mut ticks = Vec::new();
    let mut index = first;
    while index <= last {
        let value = index * step;
        ticks.push(Tick {
            value,
            label: tick_label(value, decimals, magnitude),
        });
        index += 1.0;
    }
    ticks
}

fn tick_label(value: f64, decimals: i32, magnitude: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if magnitude >= 1e6 || decimals > 5 {
        // The digits that tell neighbouring ticks apart, in the shape 1.25 × 10⁻⁷.
        let digits = (libm::log10(magnitude).floor() as i32 + decimals).clamp(0, 17);
        let text = format!("{value:.*e}", usize::try_from(digits).unwrap_or(0));
        let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        let mantissa = if mantissa.contains('.') {
            mantissa.trim_end_matches('0').trim_end_matches('.')
        } else {
            mantissa
        };
        let mut label = mantissa.replace('-', "\u{2212}");
        label.push_str("·10");
        label.extend(exponent.chars().map(superscript));
        return label;
    }
    let decimals = usize::try_from(decimals).unwrap_or(0);
    format!("{value:.decimals$}").replace('-', "\u{2212}")
}

/// A coordinate in a panel. Distances are in units of the drawing, to the right and downwards.
#[derive(Debug, Clone, Copy)]
pub enum At {
    /// At a value of the axis, and so far from there.
    Value(f64, f64),
    /// So far from the lower end of the axis.
    Low(f64),
    /// So far from the upper end of the axis.
    High(f64),
}
