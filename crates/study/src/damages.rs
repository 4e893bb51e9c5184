//! What damage to a recording is seen: recordings made by formula, or one of one's own, damaged at random
//! in every way of a table, and judged.
//!
//! A damage counts where the undamaged recording does not pass and the damaged one does. Such a
//! pass is *told* if it carries a warning that the undamaged recording does not have, and *silent* if
//! not. Kinds that leave a plausible other recording cannot be told by anybody; the table names them.
//!
//! - `kind`: the kinds of damage, and what each does to samples;
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

/// Damages that one recording is given before the next is made.
const DAMAGES_PER_BASE: usize = 25;

/// Recordings that are made until one does not pass, at most.
const TRIES: usize = 1_000;

/// Noise below which a channel is coarse [quanta].
const COARSE_QUANTA: f64 = 2.5;

/// What is damaged.
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

/// What is said of one recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DamageAnswer {
    /// True if the lever passes, a person's word given.
    pub passes: bool,
    /// True if a pass needs that word.
    pub needs_word: bool,
    /// Codes of findings that block.
    pub blocking: Vec<String>,
    /// Codes of warnings.
    pub warnings: Vec<String>,
}

/// Judges a recording whose negative acceleration opens.
pub type Judge<'a> = &'a (dyn Fn(&Signal) -> Result<DamageAnswer, Error> + Sync);

/// How the damages of one kind and severity ended.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Row {
    /// Kind of damage.
    pub kind: &'static str,
    /// True if nobody can tell such a damage from a sound recording.
    pub undetectable: bool,
    /// True if the noise of the channel is below two and a half steps of its grid: coarse, or lively.
    pub channel: &'static str,
    /// Severity: mild, middling, severe.
    pub severity: &'static str,
    /// Damages.
    pub runs: u32,
    /// Damaged recordings that a finding blocks.
    pub blocked: u32,
    /// Damaged recordings that do not pass, without a finding that blocks; such as wait for a person's
    /// word are among them.
    pub not_passed: u32,
    /// Passes with a warning that the undamaged recording does not have.
    pub told: u32,
    /// Passes without one.
    pub silent: u32,
}

/// How often a finding speaks.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FindingRate {
    /// Code of the finding.
    pub code: String,
    /// Undamaged recordings with it, of [`Damages::sound`].
    pub false_alarms: u32,
    /// Damaged recordings with it, of those whose undamaged one has it not.
    pub damages_found: u32,
}

/// What the study found.
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
    /// Undamaged recordings whose pass needs a person's word.
    pub sound_asked: u32,
    /// Findings, by code.
    pub findings: Vec<FindingRate>,
    /// What to take away.
    #[serde(skip)]
    pub headlines: Vec<Headline>,
}

/// One damage and how it ended.
struct Ended {
    kind: Kind,
    severity: usize,
    judged: DamageAnswer,
}

/// One recording with what was said of it, and its damages.
struct Batch {
    /// Recordings that were made, the damaged one last.
    sound: Vec<DamageAnswer>,
    coarse: bool,
    ended: Vec<Ended>,
}

/// Counter-based chance: SplitMix64.
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

    /// Between two positive numbers, evenly by their logarithms.
    fn scale(&mut self, low: f64, high: f64) -> f64 {
        libm::exp(self.between(libm::log(low), libm::log(high)))
    }

    /// Nearly normal: the sum of twelve even draws.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.between(-0.5, 0.5)).sum()
    }
}

/// Damages recordings and counts what is seen.
///
/// # Errors
///
/// As `judge`; [`Stopped`](latchgate_kernel::error::Error::Stopped) if `control` stops the work.
pub fn run(options: &Options, judge: Judge<'_>, control: &Control<'_>) -> Result<Damages, Error> {
    let batches = (options.runs as usize).div_ceil(DAMAGES_PER_BASE);
    let done = control.map(batches, |index| batch(options, index as u64, judge));
    let mut all = Vec::with_capacity(batches);
    for one in done {
        match one {
            Some(batch) => all.push(batch?),
            None => return Err(KernelError::Stopped.into()),
        }
    }
    Ok(counted(&all))
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
    let mut rows = Row::all();
    let mut findings: Vec<FindingRate> = Vec::new();
    let (mut sound, mut sound_blocked, mut sound_warned, mut sound_asked) = (0, 0, 0, 0);
    for batch in batches {
        for base in &batch.sound {
            sound += 1;
            sound_blocked += u32::from(!base.blocking.is_empty());
            sound_warned += u32::from(!base.warnings.is_empty());
            sound_asked += u32::from(base.needs_word);
            for code in base.codes() {
                FindingRate::of(&mut findings, code).false_alarms += 1;
            }
        }
        let Some(base) = batch.sound.last() else {
            continue;
        };
        for one in &batch.ended {
            let place = Kind::ALL.iter().position(|kind| *kind == one.kind);
            let place = 2 * place.unwrap_or(0) + usize::from(batch.coarse);
            rows[3 * place + one.severity].count(base, &one.judged);
            let new = one.judged.codes().filter(|code| !base.has(code));
            for code in new {
                FindingRate::of(&mut findings, code).damages_found += 1;
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
    let mut all = vec![
        headline("sound", "recordings", sound),
        headline("sound", "blocked", blocked),
        headline("sound", "with a warning", warned),
    ];
    for (subject, undetectable, channel) in [
        ("damages", false, "lively"),
        ("damages of coarse channels", false, "coarse"),
        ("damages nobody can tell", true, "lively"),
    ] {
        let of = |row: &&Row| row.undetectable == undetectable && row.channel == channel;
        let sum = |count: fn(&Row) -> u32| rows.iter().filter(of).map(count).sum();
        all.push(headline(subject, "number", sum(|row| row.runs)));
        let told = sum(|row| row.told);
        all.push(headline(subject, "passes with a new warning", told));
        let silent = sum(|row| row.silent);
        all.push(headline(subject, "passes in silence", silent));
    }
    all
}

impl Row {
    /// Returns the rows of every kind, channel and severity, still empty.
    fn all() -> Vec<Self> {
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
        self.codes().any(|own| own == code)
    }
}

impl FindingRate {
    /// Returns that of a code among `all`, which stand in the order of their codes.
    fn of<'a>(all: &'a mut Vec<Self>, code: &str) -> &'a mut Self {
        let known = all.binary_search_by(|one| one.code.as_str().cmp(code));
        let place = known.unwrap_or_else(|place| {
            let rate = Self {
                code: code.into(),
                false_alarms: 0,
                damages_found: 0,
            };
            all.insert(place, rate);
            place
        });
        &mut all[place]
    }
}
