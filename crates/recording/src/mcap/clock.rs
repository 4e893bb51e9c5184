//! The clocks of a topic's messages: the one that is used, compared with the others.
//!
//! A message may say when it was measured (the stamp in its header); the log says when it was
//! published and when it was logged. A clock that is wrong makes the pulse longer or shorter, so
//! the clock that is used is compared with the others.

use crate::error::{Error, ErrorKind, Place};
use crate::examine::clock::{Comparison, Relation, UsedClock};
use crate::setting::Setting;
use crate::time_base::{MEND, TimeBase};
use crate::{Finding, Limits, ReadOptions};
use latchgate_kernel::units::MessageClock;

/// Stretches of messages whose mean times give the slope of one clock against another: delays of transport
/// are alike within a stretch, and independent from one to the next.
const STRETCHES: usize = 16;

/// Fewest stretches that tell a slope with its standard error.
const FEWEST_STRETCHES: usize = 4;

/// Times of a topic's messages by each clock [ns].
#[derive(Debug, Default)]
pub(super) struct MessageTimes {
    /// Stamps in the messages; empty where these have none.
    header: Vec<i64>,
    /// The first stamp that is not a time: its message, counted from 0, and its numbers [s, ns].
    bad_stamp: Option<(usize, [f64; 2])>,
    log: Vec<u64>,
    publish: Vec<u64>,
}

/// Seconds of one clock in a second of another, with the standard error [-].
#[derive(Debug, Clone, Copy)]
struct ClockSlope {
    slope: f64,
    standard_error: f64,
}

impl ClockSlope {
    /// A difference counts beyond three standard errors; three that are too large confirm nothing.
    fn relation(self) -> Relation {
        let three = 3.0 * self.standard_error;
        let relation = Relation::between(self.slope, 1.0, 0.0);
        let is_sure = match relation {
            Relation::Confirmed => Relation::between(1.0 + three, 1.0, 0.0) == relation,
            Relation::Silent => true,
            Relation::Contradicted => (self.slope - 1.0).abs() > three,
        };
        if is_sure { relation } else { Relation::Silent }
    }
}

/// A uniform time base, with the instants of the messages that it was fitted to.
#[derive(Debug)]
pub(super) struct MessageBase {
    pub(super) base: TimeBase,
    /// Instants of the messages after time zero [s].
    pub(super) times_s: Vec<f64>,
    /// Findings on the clock.
    pub(super) findings: Vec<Finding>,
    /// What a person must accept of the clock.
    pub(super) doubt: Option<String>,
}

impl MessageTimes {
    /// Takes in the times of one message: the two numbers of its stamp [s, ns], the others [ns].
    pub(super) fn push(&mut self, header: Option<[f64; 2]>, log: u64, publish: u64) {
        if let Some(pair) = header {
            let stamp = stamp_ns(pair);
            if stamp.is_none() {
                self.bad_stamp.get_or_insert((self.log.len(), pair));
            }
            self.header.push(stamp.unwrap_or_default());
        }
        self.log.push(log);
        self.publish.push(publish);
    }

    fn count(&self) -> usize {
        self.log.len()
    }

    /// Returns the time of a message [ns].
    fn time(&self, clock: MessageClock, index: usize) -> i128 {
        match clock {
            MessageClock::Header => self.header[index].into(),
            MessageClock::Log => self.log[index].into(),
            MessageClock::Publish => self.publish[index].into(),
        }
    }

    fn times(&self, clock: MessageClock) -> impl Iterator<Item = i128> {
        (0..self.count()).map(move |index| self.time(clock, index))
    }

    /// Returns the clocks other than one that the messages have.
    fn other_clocks(&self, used: MessageClock) -> impl Iterator<Item = MessageClock> {
        let has_stamps = !self.header.is_empty() && self.bad_stamp.is_none();
        let has = move |clock: &MessageClock| *clock != MessageClock::Header || has_stamps;
        let clocks = MessageClock::ALL.into_iter().filter(has);
        clocks.filter(move |clock| *clock != used)
    }

    /// Finds the uniform time base by the clock that is requested, else by the stamps in the
    /// messages where they have them, else by the times of logging.
    pub(super) fn base(
        &self,
        topic: &str,
        options: &ReadOptions,
        limits: &Limits,
    ) -> Result<MessageBase, Error> {
        let (clock, mut findings) = self.choose(options)?;
        self.check_rising(clock, topic, limits)?;
        let zero = self.zero(clock, options, &mut findings)?;
        let times_s: Vec<f64> = self.times(clock).map(|time| seconds(time - zero)).collect();
        let base = TimeBase::fit(&times_s, NANOSECOND, limits)?;
        for finding in &base.findings {
            let mut finding = finding.clone();
            // Times here count from time zero already.
            finding.text = finding.text.replace(" on the file's clock", "");
            if finding.code == "gap" {
                finding.text += &self.way_out(clock, limits, "has no gap");
            }
            findings.push(finding);
        }
        // Uneven times were resampled, so that the base's rate is not the file's.
        let span_s = times_s[times_s.len() - 1] - times_s[0];
        let is_uneven = base
            .findings
            .iter()
            .any(|finding| finding.code == "time-irregular");
        let hertz = match is_uneven {
            true => (times_s.len() - 1) as f64 / span_s,
            false => base.rate.hertz(),
        };
        let source = ("the times of the messages", false);
        findings.extend(options.check_rate(hertz, source, MEND)?);
        let used = UsedClock {
            name: words(clock),
            hertz,
            stated_hz: options.rate_hz,
        };
        let mut doubts = Vec::new();
        if let Some(found) = self.contradiction(clock, used) {
            found.tell(&mut findings, &mut doubts);
        }
        findings.extend(self.unseen_gap(clock, limits));
        Ok(MessageBase {
            base,
            times_s,
            findings,
            doubt: doubts.pop(),
        })
    }

    /// Chooses the clock. A finding names it where it was stated, or is not that of the stamps.
    fn choose(&self, options: &ReadOptions) -> Result<(MessageClock, Vec<Finding>), Error> {
        let stamped = !self.header.is_empty();
        if let Some(clock) = options.time_source {
            if clock == MessageClock::Header && !stamped {
                let hint = format!("state {} = log or publish", Setting::TimeSource);
                let expected = "messages with stamps";
                return Err(Error::malformed(expected, "none in them", hint));
            }
            let text = format!("{} is used, as stated", words(clock));
            return Ok((clock, vec![Finding::info("time-source", text)]));
        }
        // Stamps of a recorder that never set them are all 0, which would be a clock that stands still.
        if self.bad_stamp.is_some() || self.header.iter().any(|stamp| *stamp != 0) {
            return Ok((MessageClock::Header, Vec::new()));
        }
        let (code, observed) = match stamped {
            true => ("stamp-zero", "header.stamp is 0 in every message"),
            false => ("log-time", "the messages have no header.stamp"),
        };
        let used = "The time of logging is used, which includes delays of transport. Set the \
                    stamps when recording";
        let finding = Finding::warning(code, format!("{observed}. {used}"));
        Ok((MessageClock::Log, vec![finding]))
    }

    /// Returns the first message whose time is not after that of the message before.
    fn fault(&self, clock: MessageClock) -> Option<usize> {
        (1..self.count()).find(|index| self.time(clock, *index) <= self.time(clock, index - 1))
    }

    /// Refuses a clock that does not increase; the error names one that does.
    fn check_rising(&self, clock: MessageClock, topic: &str, limits: &Limits) -> Result<(), Error> {
        let refused = |index: usize, expected: String, found: String, why: &str| {
            let way_out = self.way_out(clock, limits, "is sound");
            let way_out = match way_out.is_empty() {
                true => "; no clock of the log is sound; record it again",
                false => &way_out,
            };
            let place = format!("{topic}, message {}", index + 1);
            let error = Error::malformed(expected, found, format!("{why}{way_out}"));
            Err(error.at(Place::default().channel(place)))
        };
        if let (MessageClock::Header, Some((index, [sec, nanosec]))) = (clock, self.bad_stamp) {
            let expected = "a stamp of whole seconds, and nanoseconds below 10^9".to_string();
            let found = format!("{sec} s and {nanosec} ns");
            return refused(index, expected, found, "the stamp is not a time");
        }
        let Some(index) = self.fault(clock) else {
            return Ok(());
        };
        let after_first = |index| seconds(self.time(clock, index) - self.time(clock, 0));
        let (previous, found) = (after_first(index - 1), after_first(index));
        let expected = format!(
            "{} later than {previous} s after the first message",
            words(clock)
        );
        refused(index, expected, format!("{found} s"), "time must increase")
    }

    /// Names the clocks that increase without a gap, where this one does not.
    fn way_out(&self, broken: MessageClock, limits: &Limits, is_sound: &str) -> String {
        let sound = self.other_clocks(broken).filter(|clock| {
            let first = self.time(*clock, 0);
            let times_s: Vec<f64> = self
                .times(*clock)
                .map(|time| seconds(time - first))
                .collect();
            let base = TimeBase::fit(&times_s, NANOSECOND, limits);
            base.is_ok_and(|base| base.findings.iter().all(|finding| finding.code != "gap"))
        });
        sound.fold(String::new(), |text, clock| {
            let (words, setting, name) = (words(clock), Setting::TimeSource, clock.name());
            format!("{text}; {words} {is_sound}: state {setting} = {name}")
        })
    }

    /// Compares the other clocks with the one that is used. A single step, as where a message comes
    /// late or a clock is set, does not change the rate, so that a difference of one step is no fault.
    fn contradiction(&self, used: MessageClock, clock: UsedClock) -> Option<Comparison> {
        let span = |clock: MessageClock| {
            let (low, high) = (self.times(clock).min()?, self.times(clock).max()?);
            // A clock that does not advance cannot contradict another.
            (high > low).then_some(high - low)
        };
        let longest_step = |clock: MessageClock| {
            let step = |index: usize| self.time(clock, index) - self.time(clock, index - 1);
            let steps = (1..self.count()).map(|index| step(index).abs());
            steps.max().unwrap_or(0)
        };
        let used_span = span(used)?;
        self.other_clocks(used).find_map(|other_clock| {
            let span = span(other_clock)?;
            let (short, long) = (used_span.min(span), used_span.max(span));
            let step = longest_step(used).max(longest_step(other_clock));
            let slope = self.slope(used, other_clock)?;
            let differs = slope.relation() == Relation::Contradicted && long - short > step;
            differs.then(|| {
                let text = format!(
                    "{} spans {} s, but {} {} s",
                    words(used),
                    seconds_text(used_span),
                    words(other_clock),
                    seconds_text(span),
                );
                clock.outcome(Relation::Contradicted, &text)
            })
        })
    }

    /// True if the stamps in the messages and the times of logging run alike, as correct clocks of sensor and
    /// recorder do.
    pub(super) fn log_confirms(&self) -> bool {
        let slope = self.slope(MessageClock::Header, MessageClock::Log);
        slope.is_some_and(|slope| slope.relation() == Relation::Confirmed)
    }

    /// Returns how a clock runs against another, by a straight line through the mean times of stretches;
    /// `None` of too few messages, or of a clock that stands still.
    fn slope(&self, clock: MessageClock, other_clock: MessageClock) -> Option<ClockSlope> {
        let has_stamps = !self.header.is_empty() && self.bad_stamp.is_none();
        let is_there = |clock| clock != MessageClock::Header || has_stamps;
        let count = self.count();
        let stretches = STRETCHES.min(count);
        if stretches < FEWEST_STRETCHES || !is_there(clock) || !is_there(other_clock) {
            return None;
        }
        let mean_s = |clock: MessageClock, stretch: usize| {
            let first = self.time(clock, 0);
            let range = stretch * count / stretches..(stretch + 1) * count / stretches;
            let length = range.len() as f64;
            range
                .map(|index| seconds(self.time(clock, index) - first))
                .sum::<f64>()
                / length
        };
        let points: Vec<[f64; 2]> = (0..stretches)
            .map(|stretch| [mean_s(clock, stretch), mean_s(other_clock, stretch)])
            .collect();
        let total = stretches as f64;
        let centre = [0, 1].map(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / total);
        let (mut spread, mut product) = (0.0, 0.0);
        for [x, y] in &points {
            spread += (x - centre[0]) * (x - centre[0]);
            product += (x - centre[0]) * (y - centre[1]);
        }
        if spread <= 0.0 {
            return None;
        }
        let slope = product / spread;
        let off = |[x, y]: &[f64; 2]| y - centre[1] - slope * (x - centre[0]);
        let left: f64 = points.iter().map(|point| off(point) * off(point)).sum();
        Some(ClockSlope {
            slope,
            standard_error: (left / (total - 2.0) / spread).sqrt(),
        })
    }

    /// Returns a finding on a gap that the stamps show and the clock in use does not.
    fn unseen_gap(&self, used: MessageClock, limits: &Limits) -> Option<Finding> {
        let header = MessageClock::Header;
        let has_stamps = self.other_clocks(used).any(|clock| clock == header);
        if !has_stamps || self.fault(header).is_some() {
            return None;
        }
        let first = self.time(header, 0);
        let times_s: Vec<f64> = self
            .times(header)
            .map(|time| seconds(time - first))
            .collect();
        let base = TimeBase::fit(&times_s, NANOSECOND, limits).ok()?;
        let gap = base
            .findings
            .into_iter()
            .find(|finding| finding.code == "gap")?;
        let text = format!(
            "{}, which is not used, has {}. Compare the two clocks",
            words(header),
            gap.text
                .replace("on the file's clock", "from the first message on")
        );
        Some(Finding::warning("log-time-differs", text))
    }

    /// Returns the instant that becomes time 0, on the clock that is used [ns]. A person may state
    /// it on that clock, or as times are shown, from the first message on.
    fn zero(
        &self,
        clock: MessageClock,
        options: &ReadOptions,
        findings: &mut Vec<Finding>,
    ) -> Result<i128, Error> {
        let Some(end) = self.count().checked_sub(1) else {
            return Ok(0);
        };
        let (first, last) = (self.time(clock, 0), self.time(clock, end));
        let (from, to) = (seconds_text(first), seconds_text(last));
        let Some(stated_s) = options.time_zero_s else {
            let text = format!(
                "time 0 is the first message, at {from} s of {}. State first contact with {} = S, \
                 on that clock or as times are shown here",
                words(clock),
                Setting::TimeZero
            );
            findings.push(Finding::info("time-zero-first", text));
            return Ok(first);
        };
        let (stated_ns, span) = (nanoseconds(stated_s)?, last - first);
        if (first..=last).contains(&stated_ns) {
            return Ok(stated_ns);
        }
        let outside = format!(
            "time zero, {stated_s} s, lies outside the messages, which run from {from} s to {to} s \
             of {}",
            words(clock)
        );
        if (0..=span).contains(&stated_ns) {
            let text = format!("{outside}. It was counted from the first message");
            findings.push(Finding::info("time-zero-outside", text));
            return Ok(first + stated_ns);
        }
        // Beyond that it is an instant of another clock, or of another day.
        if (first - span..=last + span).contains(&stated_ns) {
            let text = format!("{outside}. Check the setting `time_zero`");
            findings.push(Finding::warning("time-zero-outside", text));
            return Ok(stated_ns);
        }
        Err(ErrorKind::BadSetting {
            setting: Setting::TimeZero,
            wrong: format!(
                "must lie between {from} and {to} s of {}, or between 0 and {} s after the first \
                 message",
                words(clock),
                seconds_text(span)
            ),
            found: stated_s.to_string(),
        }
        .into())
    }
}

/// Last digit of a time in a log [s].
const NANOSECOND: f64 = 1e-9;

/// Names a clock in a sentence.
fn words(clock: MessageClock) -> &'static str {
    match clock {
        MessageClock::Header => "the stamp in the messages",
        MessageClock::Log => "the time of logging",
        MessageClock::Publish => "the time of publishing",
    }
}

/// Returns a stamp in whole nanoseconds; `None` for one that is not a time.
fn stamp_ns([sec, nanosec]: [f64; 2]) -> Option<i64> {
    // 9.2e9 s in nanoseconds still fit 64 bits.
    let is_whole = |value: f64| value.trunc().total_cmp(&value).is_eq();
    let fits =
        is_whole(sec) && sec.abs() <= 9.2e9 && is_whole(nanosec) && (0.0..1e9).contains(&nanosec);
    fits.then(|| sec as i64 * 1_000_000_000 + nanosec as i64)
}

/// Returns an instant in whole nanoseconds.
fn nanoseconds(instant_s: f64) -> Result<i128, Error> {
    if !instant_s.is_finite() || instant_s.abs() > 1e11 {
        return Err(Error::out_of_range(
            "time zero [s]",
            "an instant on the file's clock",
            format!("{instant_s}"),
        ));
    }
    // Taken as it was written: the nearest double to an instant of today is off by up to 0.1 µs,
    // its shortest decimal is not.
    let text = instant_s.abs().to_string();
    let (whole_digits, decimals) = text.split_once('.').unwrap_or((&text, ""));
    let digits = format!("{whole_digits}{decimals:0<9.9}");
    let time: i128 = digits.parse().unwrap_or_default();
    Ok(if instant_s < 0.0 { -time } else { time })
}

fn seconds(span_ns: i128) -> f64 {
    let span = span_ns as f64;
    span / 1e9
}

fn seconds_text(time_ns: i128) -> String {
    let sign = if time_ns < 0 { "-" } else { "" };
    let (time, second) = (time_ns.unsigned_abs(), 1_000_000_000);
    let text = format!("{sign}{}.{:09}", time / second, time % second);
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}
