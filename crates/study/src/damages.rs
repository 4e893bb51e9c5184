//! Detection of damage to a recording: recordings made by formula, or one from a file, are damaged at random
//! in every way of a table, and judged.
//!
//! A damage counts where the undamaged recording does not pass and the damaged one does. Such a
//! pass is *told* if it carries a warning that the undamaged recording does not have, and *silent* if
//! not. Kinds that leave another plausible recording cannot be detected; the table marks them.
//!
//! - `kind`: the kinds of damage, and the effect of each on the samples;
//! - `made`: recordings made by formula, as a sensor with noise and a grid would give them.

mod kind;
mod made;

use kind::Specimen;
use latchgate_kernel::error::Error as KernelError;

pub use kind::Kind;

use super::Headline;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::signal::Signal;
use latchgate_recording::error::Error;
use serde::Serialize;

/// Number of damages made to one recording.
const DAMAGES_PER_BASE: usize = 25;

/// Largest number of recordings made until one does not pass.
const TRIES: usize = 1_000;

/// Noise below which a channel is coarse [quanta].
const COARSE_QUANTA: f64 = 2.5;

/// Options of the study.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Options {
    /// Number of damages.
    pub runs: u32,
    /// Seed of chance.
    pub seed: u64,
    /// Recording to damage in place of made ones.
    #[serde(skip)]
    pub own: Option<Signal>,
}

/// Answer on one recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DamageAnswer {
    /// True if the lever passes once a person has confirmed what the samples cannot show.
    pub passes: bool,
    /// True if a pass needs that confirmation.
    pub needs_word: bool,
    /// Codes of findings that block.
    pub blocking: Vec<String>,
    /// Codes of warnings.
    pub warnings: Vec<String>,
}

/// Judges a recording whose negative acceleration opens.
pub type Judge<'a> = &'a (dyn Fn(&Signal) -> Result<DamageAnswer, Error> + Sync);

/// Answers on the damages of one kind, channel and severity.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Row {
    /// Kind of damage.
    pub kind: &'static str,
    /// True if such a damage cannot be distinguished from a sound recording.
    pub undetectable: bool,
    /// `coarse` if the noise of the channel is below two and a half steps of its grid, else `lively`.
    pub channel: &'static str,
    /// Severity: mild, middling, severe.
    pub severity: &'static str,
    /// Damages.
    pub runs: u32,
    /// Damaged recordings that a finding blocks.
    pub blocked: u32,
    /// Damaged recordings that do not pass without a finding that blocks, among them those that need a
    /// person's confirmation.
    pub not_passed: u32,
    /// Passes with a warning that the undamaged recording does not have.
    pub told: u32,
    /// Passes without one.
    pub silent: u32,
}

/// Counts of a finding.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FindingRate {
    /// Code of the finding.
    pub code: String,
    /// Undamaged recordings with it, of [`Damages::sound`].
    pub false_alarms: u32,
    /// Damaged recordings with it whose undamaged one does not have it.
    pub damages_found: u32,
}

/// Result of the study.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Damages {
    /// One row per kind and severity.
    #[serde(skip)]
    pub rows: Vec<Row>,
    /// Undamaged recordings.
    pub sound: u32,
    /// Undamaged recordings with a finding that blocks.
    pub sound_blocked: u32,
    /// Undamaged recordings with any warning.
    pub sound_warned: u32,
    /// Undamaged recordings whose pass needs a person's confirmation.
    pub sound_asked: u32,
    /// Findings, by code.
    pub findings: Vec<FindingRate>,
    /// Headline figures.
    #[serde(skip)]
    pub headlines: Vec<Headline>,
}

/// One damage with its answer.
struct Ended {
    kind: Kind,
    severity: usize,
    judged: DamageAnswer,
}

/// One recording with its answers, and its damages.
struct Batch {
    /// Answers on the recordings made, that of the damaged one last.
    sound: Vec<DamageAnswer>,
    coarse: bool,
    ended: Vec<Ended>,
}

/// Counter-based random numbers: SplitMix64.
///
/// # Source
///
/// G. L. Steele, D. Lea, C. H. Flood, Fast splittable pseudorandom number generators, OOPSLA 2014.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ (bits >> 31)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns a number between two positive ones, uniform in the logarithm.
    fn scale(&mut self, low: f64, high: f64) -> f64 {
        libm::exp(self.between(libm::log(low), libm::log(high)))
    }

    /// Returns a nearly normal number: the sum of twelve uniform ones.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.between(-0.5, 0.5)).sum()
    }
}

/// Damages recordings and counts the answers.
///
/// # Errors
///
/// As `judge`; [`Stopped`](latchgate_kernel::error::Error::Stopped) if `control` stops the work.
pub fn run(options: &Options, judge: Judge<'_>, control: &Control<'_>) -> Result<Damages, Error> {
    let count = (options.runs as usize).div_ceil(DAMAGES_PER_BASE);
    let batches = control
        .map(count, |index| batch(options, index as u64, judge))
        .into_iter()
        .map(|batch| batch.unwrap_or(Err(KernelError::Stopped.into())))
        .collect::<Result<Vec<_>, _>>()?;
    Ok(counted(&batches))
}

fn batch(options: &Options, index: u64, judge: Judge<'_>) -> Result<Batch, Error> {
    let mut chance = Chance(options.seed.wrapping_mul(1 << 32).wrapping_add(index));
    let mut sound = Vec::new();
    let signal = loop {
        let signal = match &options.own {
            Some(signal) => signal.clone(),
            None => made::recording(&mut chance),
        };
        let judged = judge(&signal)?;
        let passes = judged.passes;
        sound.push(judged);
        if !passes || options.own.is_some() || sound.len() == TRIES {
            break signal;
        }
    };
    let subject = Specimen::new(&signal);
    let mut ended = Vec::new();
    for place in 0..DAMAGES_PER_BASE {
        let number = index as usize * DAMAGES_PER_BASE + place;
        let kind = Kind::ALL[number % Kind::ALL.len()];
        let severity = chance.between(0.0, 1.0);
        let damaged = subject.damaged(kind, severity, &mut chance);
        ended.push(Ended {
            kind,
            severity: ((severity * 3.0) as usize).min(2),
            judged: judge(&damaged)?,
        });
    }
    Ok(Batch {
        sound,
        coarse: subject.noise < COARSE_QUANTA * subject.quantum,
        ended,
    })
}

fn counted(batches: &[Batch]) -> Damages {
    let mut rows = Row::empty_rows();
    let mut findings: Vec<FindingRate> = Vec::new();
    let (mut sound, mut sound_blocked, mut sound_warned, mut sound_asked) = (0, 0, 0, 0);
    for batch in batches {
        for base in &batch.sound {
            sound += 1;
            sound_blocked += u32::from(!base.blocking.is_empty());
            sound_warned += u32::from(!base.warnings.is_empty());
            sound_asked += u32::from(base.needs_word);
            for code in base.codes() {
                FindingRate::entry(&mut findings, code).false_alarms += 1;
            }
        }
        let Some(base) = batch.sound.last() else {
            continue;
        };
        for damage in &batch.ended {
            let place = Kind::ALL.iter().position(|kind| *kind == damage.kind);
            let place = 2 * place.unwrap_or(0) + usize::from(batch.coarse);
            rows[3 * place + damage.severity].count(base, &damage.judged);
            let new = damage.judged.codes().filter(|code| !base.has(code));
            for code in new {
                FindingRate::entry(&mut findings, code).damages_found += 1;
            }
        }
    }
    Damages {
        headlines: headlines(&rows, sound, sound_blocked, sound_warned),
        rows,
        sound,
        sound_blocked,
        sound_warned,
        sound_asked,
        findings,
    }
}

fn headlines(rows: &[Row], sound: u32, blocked: u32, warned: u32) -> Vec<Headline> {
    let headline = |subject: &str, what: &str, value: u32| Headline {
        subject: subject.into(),
        model: None,
        what: what.into(),
        value: Some(f64::from(value)),
        digits: 6,
    };
    let mut lines = vec![
        headline("sound", "recordings", sound),
        headline("sound", "blocked", blocked),
        headline("sound", "with a warning", warned),
    ];
    for (subject, undetectable, channel) in [
        ("damages", false, "lively"),
        ("damages of coarse channels", false, "coarse"),
        ("damages nobody can tell", true, "lively"),
    ] {
        let in_group = |row: &&Row| row.undetectable == undetectable && row.channel == channel;
        let sum = |count: fn(&Row) -> u32| rows.iter().filter(in_group).map(count).sum();
        lines.push(headline(subject, "number", sum(|row| row.runs)));
        let warned = sum(|row| row.told);
        lines.push(headline(subject, "passes with a new warning", warned));
        let silent = sum(|row| row.silent);
        lines.push(headline(subject, "passes in silence", silent));
    }
    lines
}

impl Row {
    /// Returns the rows of every kind, channel and severity, all counts zero.
    fn empty_rows() -> Vec<Self> {
        let mut rows = Vec::new();
        for kind in Kind::ALL {
            for channel in ["lively", "coarse"] {
                rows.extend(["mild", "middling", "severe"].map(|severity| Self {
                    kind: kind.name(),
                    undetectable: kind.is_undetectable(),
                    channel,
                    severity,
                    runs: 0,
                    blocked: 0,
                    not_passed: 0,
                    told: 0,
                    silent: 0,
                }));
            }
        }
        rows
    }

    fn count(&mut self, base: &DamageAnswer, judged: &DamageAnswer) {
        self.runs += 1;
        if !judged.blocking.is_empty() {
            self.blocked += 1;
        } else if !judged.passes || judged.needs_word {
            self.not_passed += 1;
        } else if judged.warnings.iter().any(|code| !base.has(code)) {
            self.told += 1;
        } else {
            self.silent += 1;
        }
    }
}

impl DamageAnswer {
    fn codes(&self) -> impl Iterator<Item = &str> {
        self.blocking
            .iter()
            .chain(&self.warnings)
            .map(String::as_str)
    }

    fn has(&self, code: &str) -> bool {
        self.codes().any(|own_code| own_code == code)
    }
}

impl FindingRate {
    /// Returns the rate of a code in `rates`, which are sorted by code; adds it if it is new.
    fn entry<'a>(rates: &'a mut Vec<Self>, code: &str) -> &'a mut Self {
        let search = rates.binary_search_by(|rate| rate.code.as_str().cmp(code));
        let place = search.unwrap_or_else(|place| {
            let rate = Self {
                code: code.into(),
                false_alarms: 0,
                damages_found: 0,
            };
            rates.insert(place, rate);
            place
        });
        &mut rates[place]
    }
}
