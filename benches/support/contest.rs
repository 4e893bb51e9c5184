//! Several programs timed in turns, so that whatever else the machine does hits them alike.
//!
//! Where other work interrupts every few milliseconds, a run of 30 ms never stays undisturbed and
//! one of 0.3 ms often does. So a long run is timed in laps that each try for their own minimum.

use std::fmt;
use std::time::{Duration, Instant};

/// Time that an entry gets in each round, at least one run.
const TURN: Duration = Duration::from_millis(4);

/// Time after which a race begins no further round.
const ENOUGH: Duration = Duration::from_secs(11);

/// One program on one task.
pub struct Entry<'a> {
    /// What the table calls it.
    pub name: String,
    /// Sample intervals of one run.
    pub samples: usize,
    /// Levers of one run.
    pub levers: usize,
    /// How far it is off.
    pub off: Off,
    /// One run, the end of each lap told.
    pub run: Box<dyn FnMut(&mut Laps) + 'a>,
}

/// The least time of each lap of a run; its end is the end of the last.
pub struct Laps {
    started: Instant,
    lap: usize,
    least: Vec<Duration>,
}

impl Laps {
    fn new() -> Self {
        Self {
            started: Instant::now(),
            lap: 0,
            least: Vec::new(),
        }
    }

    /// Ends a lap. Every run of a program must do so at the same points of its work.
    pub fn end_lap(&mut self) {
        let taken = self.started.elapsed();
        match self.least.get_mut(self.lap) {
            Some(least) => *least = taken.min(*least),
            None => self.least.push(taken),
        }
        self.lap += 1;
        self.started = Instant::now();
    }

    fn time(&mut self, run: &mut dyn FnMut(&mut Self)) {
        self.lap = 0;
        self.started = Instant::now();
        run(self);
        self.end_lap();
    }
}

/// Distance of an answer from the truth; `None` where it was not asked or there is none.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Off {
    /// Of the peak angle [rad].
    pub peak_rad: Option<f64>,
    /// Of the angle at the last sample [rad].
    pub final_rad: Option<f64>,
    /// Of the first crossing of the threshold [s].
    pub crossing_s: Option<f64>,
}

/// What an entry needed.
pub struct Timed {
    /// What the table calls it.
    pub name: String,
    /// Least time of its laps together, over samples and levers [ns].
    pub ns_per_sample: f64,
    /// Levers of one run.
    pub levers: usize,
    off: Off,
}

/// Times `entries` in up to `rounds` rounds, each in the reverse order of the one before, and
/// keeps the fastest of each lap.
pub fn race(mut entries: Vec<Entry<'_>>, rounds: usize) -> Vec<Timed> {
    let mut laps: Vec<Laps> = entries.iter().map(|_| Laps::new()).collect();
    let begun = Instant::now();
    for round in 0..rounds {
        if round > 0 && begun.elapsed() >= ENOUGH {
            break;
        }
        for place in 0..entries.len() {
            let index = if round % 2 == 0 {
                place
            } else {
                entries.len() - 1 - place
            };
            let turn = Instant::now();
            loop {
                laps[index].time(&mut entries[index].run);
                if turn.elapsed() >= TURN {
                    break;
                }
            }
        }
    }
    entries
        .into_iter()
        .zip(laps)
        .map(|(entry, laps)| Timed {
            name: entry.name,
            ns_per_sample: laps.least.iter().sum::<Duration>().as_secs_f64() * 1e9
                / (entry.samples * entry.levers) as f64,
            levers: entry.levers,
            off: entry.off,
        })
        .collect()
}

/// The entries of one race as a table, the first being 1.
pub struct Table<'a>(pub &'a str, pub &'a [Timed]);

impl fmt::Display for Table<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(title, rows) = self;
        writeln!(f, "{title}")?;
        writeln!(
            f,
            "  {:42} {:>10} {:>9} {:>9} {:>9} {:>9}",
            "", "ns/sample", "ratio", "peak", "final", "crossing"
        )?;
        writeln!(
            f,
            "  {:42} {:>10} {:>9} {:>9} {:>9} {:>9}",
            "", "least", "first = 1", "off, rad", "off, rad", "off, s"
        )?;
        let Some(first) = rows.first() else {
            return Ok(());
        };
        for row in *rows {
            writeln!(
                f,
                "  {:42} {:>10.2} {:>9} {:>9} {:>9} {:>9}",
                row.name,
                row.ns_per_sample,
                ratio(row.ns_per_sample / first.ns_per_sample),
                off(row.off.peak_rad),
                off(row.off.final_rad),
                off(row.off.crossing_s),
            )?;
        }
        Ok(())
    }
}

fn ratio(value: f64) -> String {
    match value {
        value if value >= 100.0 => format!("{value:.0}"),
        value if value >= 10.0 => format!("{value:.1}"),
        value => format!("{value:.2}"),
    }
}

fn off(value: Option<f64>) -> String {
    value.map_or_else(|| "-".into(), |value| format!("{value:.0e}"))
}
