//! Statements of time about one channel, held against one another: one rule for every format.
//!
//! | statements differ, half a unit of each last written place (1 % at most) aside, by | |
//! | --- | --- |
//! | less than 0.1 % | one confirms the other |
//! | up to 1 % | a warning; the stamps count |
//! | more | nothing shows which is right: the recording is unusable until a person states the rate |

use crate::Finding;
use crate::setting::Setting;
use crate::text;
use latchgate_kernel::units::short;

/// Part by which two statements may differ and confirm one another [-].
const CONFIRMED: f64 = 1e-3;

/// Part beyond which they contradict one another [-].
const CONTRADICTED: f64 = 0.01;

/// Most that few written digits excuse [-].
const ALLOWED: f64 = 0.01;

/// Share of the interval by which a stamp of a recorder may be early or late [-].
const JITTER: f64 = 0.01;

/// What two statements of one time are to each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Relation {
    Confirmed,
    Silent,
    Contradicted,
}

impl Relation {
    /// Of two values that few digits excuse a part `slack` [-] to differ.
    pub(crate) fn between(one: f64, other: f64, slack: f64) -> Self {
        let ratio = one / other;
        // A clock that stands still or runs backwards, and what is no number.
        if !(ratio.is_finite() && ratio > 0.0) {
            return Self::Contradicted;
        }
        let raw = ratio.max(1.0 / ratio) - 1.0;
        let apart = raw - slack.clamp(0.0, ALLOWED);
        // Few digits excuse a difference, and confirm none.
        let is_fine = raw <= CONFIRMED || slack <= CONFIRMED;
        match apart {
            apart if apart <= CONFIRMED && is_fine => Self::Confirmed,
            apart if apart <= CONTRADICTED => Self::Silent,
            _ => Self::Contradicted,
        }
    }
}

/// A rate that a file states, or the time from sample to sample.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RateStatement {
    /// The rates that it may mean [Hz].
    rates: Vec<f64>,
    /// Half a unit of the last written place, by the number [-].
    slack: f64,
}

impl RateStatement {
    /// A statement that may mean any of these rates [Hz], as a cell has it: `10 kHz`, `0.0001`.
    pub(crate) fn of(rates: Vec<f64>, printed: &str) -> Self {
        Self {
            rates,
            slack: slack(printed),
        }
    }

    /// Returns the rates that it may mean [Hz].
    pub(crate) fn rates(&self) -> &[f64] {
        &self.rates
    }

    /// The same, its number written to this digit.
    pub(crate) fn written_to(self, digit: f64, number: f64) -> Self {
        let slack = (0.5 * digit / number).abs();
        Self {
            slack: if slack.is_finite() { slack } else { 0.0 },
            ..self
        }
    }

    /// Returns the relation of the nearest of its rates to a rate [Hz].
    pub(crate) fn relation(&self, hertz: f64) -> Relation {
        let rates = self.rates.iter();
        let relations = rates.map(|rate| Relation::between(*rate, hertz, self.slack));
        relations.min().unwrap_or(Relation::Contradicted)
    }
}

/// Returns half a unit of the last written place of a number, which a unit may follow, by the number [-].
pub(crate) fn slack(printed: &str) -> f64 {
    let printed = printed.trim();
    let is_of_number = |c: char| c.is_ascii_digit() || ".,+-eE".contains(c);
    let end = printed.find(|c| !is_of_number(c)).unwrap_or(printed.len());
    let cell = printed[..end].trim_end_matches(['e', 'E', ',', '.']);
    let number = text::header_number(cell).map(f64::abs);
    let slack = number.map(|number| 0.5 * text::last_digit(cell) / number);
    slack.filter(|slack| slack.is_finite()).unwrap_or(0.0)
}

/// The clock that is used for a channel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct UsedClock<'a> {
    /// As messages name it: ``the time column `t` ``.
    pub(crate) name: &'a str,
    pub(crate) hertz: f64,
    /// The rate that a person states [Hz].
    pub(crate) stated_hz: Option<f64>,
}

/// What a comparison comes to.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Comparison {
    /// The statement says the same.
    Confirmed,
    /// It says too little to confirm or to contradict.
    Nothing,
    /// It does not, and this is to be said.
    Found(Finding),
    /// It does not, and a person states the rate that is used: a pass waits until the clock is accepted.
    Overridden(String),
}

impl Comparison {
    /// Adds what is to be said to findings and doubts; returns whether the statement confirms the clock.
    pub(crate) fn tell(self, findings: &mut Vec<Finding>, doubts: &mut Vec<String>) -> bool {
        match self {
            Self::Confirmed => return true,
            Self::Nothing => {}
            Self::Found(finding) => findings.push(finding),
            Self::Overridden(doubt) => doubts.push(doubt),
        }
        false
    }
}

impl UsedClock<'_> {
    /// Returns what a relation to it comes to; `difference` says both values.
    pub(crate) fn outcome(&self, relation: Relation, difference: &str) -> Comparison {
        let Self {
            hertz, stated_hz, ..
        } = *self;
        let by_person = stated_hz
            .is_some_and(|stated| Relation::between(stated, hertz, 0.0) == Relation::Confirmed);
        match (relation, by_person) {
            (Relation::Confirmed, _) => Comparison::Confirmed,
            (Relation::Silent, _) => {
                let text = format!(
                    "{difference}. {} is used. Check the clock",
                    capital(self.name)
                );
                Comparison::Found(Finding::warning("time-differs", text))
            }
            (Relation::Contradicted, true) => {
                Comparison::Overridden(format!("{difference}, as the setting `rate_hz` states"))
            }
            (Relation::Contradicted, false) => {
                let text = format!(
                    "{difference}. One of the two is wrong. Find out which, and export again; or, if {} is \
                     right, state {} = {}",
                    self.name,
                    Setting::RateHz,
                    short(hertz, 9)
                );
                Comparison::Found(Finding::blocking("time-contradicted", text))
            }
        }
    }

    /// Holds a statement of the rate against it; `said` shows the statement: `SampleRate is 10000`. Returns the
    /// sentence of a difference, and their relation.
    pub(crate) fn difference(&self, said: &str, stated: &RateStatement) -> (String, Relation) {
        let difference = format!(
            "{said}, but {} gives {} Hz",
            self.name,
            short(self.hertz, 7)
        );
        (difference, stated.relation(self.hertz))
    }

    /// As `difference`, with what the relation comes to.
    pub(crate) fn compare(&self, said: &str, stated: &RateStatement) -> Comparison {
        let (difference, relation) = self.difference(said, stated);
        self.outcome(relation, &difference)
    }
}

/// A clock that a header states.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HeaderClock<'a> {
    /// Who states it, in messages.
    pub(crate) source: &'a str,
    /// Instant of the first sample, and the size of its last written digit [s].
    pub(crate) start_s: f64,
    pub(crate) start_digit_s: f64,
    /// Intervals by which the start is counted from time zero, where it is; 0 where it is stated.
    pub(crate) start_intervals: f64,
    pub(crate) hertz: f64,
    /// Half a unit of the last written place of the interval, by the interval [-].
    pub(crate) slack: f64,
}

/// How stamps lie about the clock of a header.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum StampsFit {
    /// Each within half its last digit, or the jitter of a recorder.
    Exact,
    Related(Relation),
}

impl HeaderClock<'_> {
    /// Compares the clock with stamps [s], printed to `digit_s`: the first with its start, the others with
    /// what they are after the first.
    pub(crate) fn fit(&self, stamps_s: &[f64], digit_s: f64) -> StampsFit {
        let Some(first_s) = stamps_s.first() else {
            return StampsFit::Related(Relation::Contradicted);
        };
        let interval_s = 1.0 / self.hertz;
        // Half a digit of rounding, which is exact but for last bits, and a picosecond for stamps printed in full.
        let half = |digit_s: f64| 0.5 * digit_s * (1.0 + 1e-6);
        let jitter_s = 1e-12 + JITTER * interval_s;
        let allowed = self.slack.clamp(0.0, ALLOWED);
        let related = |off_s: f64, exact_s: f64, elapsed_s: f64| {
            let within = |part: f64| off_s <= exact_s + (allowed + part) * elapsed_s;
            match off_s <= exact_s {
                true => StampsFit::Exact,
                false if within(CONFIRMED) => StampsFit::Related(Relation::Confirmed),
                false if within(CONTRADICTED) => StampsFit::Related(Relation::Silent),
                false => StampsFit::Related(Relation::Contradicted),
            }
        };
        let start_off_s = (first_s - self.start_s).abs();
        let start_exact_s = half(digit_s) + half(self.start_digit_s) + jitter_s;
        let counted_s = self.start_intervals.abs() * interval_s;
        let of_start = related(start_off_s, start_exact_s, counted_s);
        // The first stamp may be off by as much as any.
        let exact_s = 2.0 * half(digit_s) + jitter_s;
        let of_others = stamps_s.iter().enumerate().map(|(index, stamp_s)| {
            let elapsed_s = index as f64 * interval_s;
            related((stamp_s - first_s - elapsed_s).abs(), exact_s, elapsed_s)
        });
        of_others.fold(of_start, StampsFit::max)
    }

    /// Holds the clock against stamps; a person may state their rate.
    pub(crate) fn compare(
        &self,
        stamps_s: &[f64],
        digit_s: f64,
        stated_hz: Option<f64>,
    ) -> Comparison {
        let [Some(first_s), Some(last_s)] = [stamps_s.first(), stamps_s.last()] else {
            return Comparison::Nothing;
        };
        let relation = match self.fit(stamps_s, digit_s) {
            // Stamps of few digits over a short record fit many a rate.
            StampsFit::Exact if digit_s > ALLOWED * (last_s - first_s) => {
                return Comparison::Nothing;
            }
            StampsFit::Exact => Relation::Confirmed,
            StampsFit::Related(relation) => relation,
        };
        let steps = stamps_s.len().saturating_sub(1) as f64;
        let hertz = match last_s - first_s {
            span_s if span_s > 0.0 => steps / span_s,
            _ => self.hertz,
        };
        // A start that is counted is one by the rate of the stamps as well.
        let by_stamps = match self.start_intervals.abs() >= 0.5 {
            true => Self {
                start_s: self.start_intervals / hertz,
                hertz,
                ..*self
            },
            false => *self,
        };
        let of_start = by_stamps.fit(&stamps_s[..1], digit_s);
        if of_start == StampsFit::Related(Relation::Contradicted) {
            // A rate that a person states says nothing of the first instant.
            let text = format!(
                "{} states the first sample at {} s, but the stamps begin at {} s. One of the two is wrong. \
                 Find out which, and export again",
                self.source,
                short(self.start_s, 7),
                short(*first_s, 7)
            );
            return Comparison::Found(Finding::blocking("time-contradicted", text));
        }
        let difference = format!(
            "{} states the first sample at {} s and {} Hz, but the stamps begin at {} s and run at {} Hz",
            self.source,
            short(self.start_s, 7),
            short(self.hertz, 7),
            short(*first_s, 7),
            short(hertz, 7)
        );
        // A person who states the rate of one of the two decides.
        let agrees =
            |stated: f64| Relation::between(stated, self.hertz, 0.0) == Relation::Confirmed;
        let used = UsedClock {
            name: "the clock of the stamps",
            hertz,
            stated_hz: stated_hz.map(|stated| if agrees(stated) { hertz } else { stated }),
        };
        used.outcome(relation, &difference)
    }
}

fn capital(words: &str) -> String {
    let mut chars = words.chars();
    match chars.next() {
        Some(first) => first.to_uppercase().chain(chars).collect(),
        None => String::new(),
    }
}
