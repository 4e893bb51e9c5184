//! The samples that a verdict may rest on: the judged window, and what faults leave of it.

use super::Answer;
use super::faults::Faults;
use latchgate_kernel::range::Window;
use latchgate_kernel::signal::Signal;
use latchgate_recording::error::Error;

/// First and last sample of a span.
pub(crate) type SampleSpan = (usize, usize);

/// The part of the judged window that an answer may rest on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum UsableSpan {
    /// All of the judged window.
    Whole,
    /// Those from first to last, before a blocking finding.
    Until(SampleSpan),
    /// None: a blocking finding holds from the start.
    Nothing,
}

impl UsableSpan {
    /// Returns the samples that faults leave.
    pub(crate) fn of(faults: &Faults, signal: &Signal, window: Option<SampleSpan>) -> Self {
        faults.first_bad.map_or(Self::Whole, |bad_s| {
            samples_before(signal, bad_s, window).map_or(Self::Nothing, Self::Until)
        })
    }

    /// Parts 1 and 2 of the rule, from what part 3 says of all samples and of the good ones.
    pub(crate) fn answer(self, of_all: Answer, of_good: Answer) -> Answer {
        match self {
            Self::Whole => of_all,
            Self::Until(_) if of_good == Answer::Fail => Answer::Fail,
            Self::Until(_) | Self::Nothing => Answer::Unusable,
        }
    }
}

/// Returns the first and last sample inside a window.
///
/// # Errors
///
/// [`OutOfRange`](latchgate_kernel::error::Error::OutOfRange) for a window that holds fewer than two samples.
pub(crate) fn window_samples(
    signal: &Signal,
    window: Option<Window>,
) -> Result<Option<SampleSpan>, Error> {
    let Some(Window { from_s, until_s }) = window else {
        return Ok(None);
    };
    let rate = signal.rate.hertz();
    let count = signal.samples.len();
    // A millionth of a sample absorbs the rounding of a bound that was meant to hit a sample.
    let place = |time: f64| (time - signal.start_s) * rate;
    let last = count as f64 - 1.0;
    let first_index = (place(from_s) - 1e-6).ceil().max(0.0);
    let last_index = (place(until_s) + 1e-6).floor().min(last);
    if first_index.is_nan() || last_index.is_nan() || first_index >= last_index {
        return Err(Error::out_of_range(
            "window [s]",
            format!(
                "an interval that holds at least two samples of the record, which runs from {} to {}",
                signal.start_s,
                signal.end_s()
            ),
            format!("{from_s}..{until_s}"),
        ));
    }
    Ok(Some((first_index as usize, last_index as usize)))
}

/// Returns the judged samples before the first bad one, if there are two.
fn samples_before(signal: &Signal, bad_s: f64, window: Option<SampleSpan>) -> Option<SampleSpan> {
    let (first, last) = window.unwrap_or((0, signal.samples.len() - 1));
    let place = (bad_s - signal.start_s) * signal.rate.hertz();
    if place.is_nan() || place <= first as f64 + 2.0 {
        return None;
    }
    let good = ((place - 1e-6).ceil() as usize).saturating_sub(1).min(last);
    (good > first + 1).then_some((first, good))
}
