//! Stroboscopic sections against the excitation's amplitude, and where orbits are born and double.
//!
//! Columns of sections come first, each for itself; then neighbours are compared, which tells
//! where a branch goes on, doubles or ends. Both share what counts as the same orbit.

use super::Headline;
use super::cascade::{self, BranchBounds, Cascade};
use super::orbit::{self, Bifurcation, BifurcationKind, ForcedLever};
use latchgate_kernel::parallel::Control;
use latchgate_kernel::range::Range;
use latchgate_kernel::replay::strobe_batch::Ending;
use latchgate_kernel::replay::{Section, State};
use latchgate_recording::error::Error;
use serde::Serialize;

/// True if the state at the end of one amplitude starts the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sweep {
    /// Every amplitude starts from the same state.
    None,
    /// From the least to the largest, the state carried along.
    Up,
    /// From the largest to the least.
    Down,
}

/// Options of one bifurcation diagram.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Options {
    /// Lever, stop, frequency.
    #[serde(flatten)]
    pub forced: ForcedLever,
    /// Amplitudes [g].
    #[serde(rename = "amplitude_g")]
    pub amplitudes_g: Range,
    /// Amplitudes.
    pub points: u32,
    /// Periods left out at each.
    pub transient: u32,
    /// Periods kept at each.
    pub periods: u32,
    /// Initial state; `None` for rest.
    pub initial: Option<State>,
    /// True if the state is carried along.
    pub sweep: Sweep,
    /// Doublings that are looked for on each branch; 0 to follow none.
    pub doublings: u32,
}

/// One point of the diagram.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Row {
    /// Amplitude [g].
    pub amplitude_g: f64,
    /// Angle at the start of a period [rad].
    pub angle_rad: f64,
    /// Angular velocity there [rad/s].
    pub angular_velocity_rad_s: f64,
}

/// What happens at one amplitude.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AmplitudeColumn {
    /// Amplitude [g].
    pub amplitude_g: f64,
    /// Period, in periods of the excitation; `None` if none was seen that is not rounding's.
    pub period: Option<u32>,
    /// Largest angle among the periods kept [rad].
    pub peak_angle_rad: f64,
    /// Impacts per period.
    pub impacts_per_period: f64,
    /// The sections.
    #[serde(skip)]
    pub sections: Vec<Section>,
}

/// The study's answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagram {
    /// What it answers.
    pub options: Options,
    /// Columns, by amplitude; those left out when the work was stopped are missing.
    pub columns: Vec<AmplitudeColumn>,
    /// Branches of orbits, each from its birth through its doublings; the simplest first.
    pub branches: Vec<Cascade>,
    /// True if the work was done to its end.
    pub complete: bool,
}

/// Distance of two states that are taken for the same [rad].
const SAME: f64 = 1e-7;

/// Longest period of which births and doublings are looked for.
const PERIOD_MAX: u32 = 32;

/// Branches that are followed at most.
const BRANCHES_MAX: usize = 16;

/// Branches that are followed at a time.
const AT_A_TIME: usize = 4;

/// Branches that the answer on stdout lists.
const BRANCHES_SHOWN: usize = 6;

/// Work on each, in periods computed.
const WORK_MAX: u32 = 8_000;

/// Draws the diagram's points and looks where orbits change.
///
/// # Errors
///
/// As [`latchgate_kernel::replay::Strobe::new`].
pub fn run(options: &Options, control: &Control<'_>) -> Result<Diagram, Error> {
    let amplitude = |index: usize| {
        let Range { low, high } = options.amplitudes_g;
        let last = f64::from(options.points.max(2) - 1);
        let part = index as f64 / last;
        low + (high - low) * part
    };
    let count = options.points.max(2) as usize;
    let columns: Vec<AmplitudeColumn> = match options.sweep {
        Sweep::None => side_by_side(options, count, &amplitude, control)?,
        Sweep::Up | Sweep::Down => {
            let mut columns = Vec::with_capacity(count);
            let mut state = options.initial;
            for step in 0..count {
                let index = if options.sweep == Sweep::Up {
                    step
                } else {
                    count - 1 - step
                };
                let (column, reached) = column(options, amplitude(index), state)?;
                state = reached.or(options.initial);
                columns.push(column);
                if !(control.proceed)(Some((step + 1) as f64 / count as f64)) {
                    break;
                }
            }
            if options.sweep == Sweep::Down {
                columns.reverse();
            }
            columns
        }
    };
    let complete = columns.len() == count;
    let (branches, complete) = if complete && options.doublings > 0 {
        changes(options, &columns, control)
    } else {
        (Vec::new(), complete)
    };
    Ok(Diagram {
        options: options.clone(),
        columns,
        branches,
        complete,
    })
}

fn column(
    options: &Options,
    amplitude_g: f64,
    initial: Option<State>,
) -> Result<(AmplitudeColumn, Option<State>), Error> {
    let mut strobe = options.forced.strobe(amplitude_g, initial)?;
    let mut sections = Vec::with_capacity(options.periods as usize);
    let mut followed = (0..options.transient).all(|_| strobe.advance().is_some());
    while followed && sections.len() < options.periods as usize {
        match strobe.advance() {
            Some(section) => sections.push(section),
            None => followed = false,
        }
    }
    let column = summed_up(options, amplitude_g, sections);
    Ok((column, followed.then(|| strobe.state())))
}

/// Every amplitude from the same start, side by side.
fn side_by_side(
    options: &Options,
    count: usize,
    amplitude: &(impl Fn(usize) -> f64 + Sync),
    control: &Control<'_>,
) -> Result<Vec<AmplitudeColumn>, Error> {
    let followed = options.forced.follow(
        count,
        |index| (options.initial, amplitude(index)),
        (options.transient + options.periods, options.periods, true),
        control,
    )?;
    Ok(followed
        .into_iter()
        .map(|lever| {
            // Of one that was lost before its end the last sections may belong to the transient.
            let sections = if lever.ending == Ending::Lost {
                Vec::new()
            } else {
                lever.sections
            };
            summed_up(options, amplitude(lever.index), sections)
        })
        .collect())
}

fn summed_up(options: &Options, amplitude_g: f64, sections: Vec<Section>) -> AmplitudeColumn {
    let peak_angle_rad = sections
        .iter()
        .map(|section| section.peak_angle_rad)
        .fold(f64::NAN, f64::max);
    let impacts: u64 = sections.iter().map(|section| section.impacts).sum();
    let impacts_per_period = impacts as f64 / sections.len().max(1) as f64;
    AmplitudeColumn {
        amplitude_g,
        period: orbit::period_of(&options.forced, &sections, SAME)
            .filter(|period| believed(options, amplitude_g, &sections, *period)),
        peak_angle_rad,
        impacts_per_period,
        sections,
    }
}

/// True if a period is the lever's and not rounding's: one that rests, on either stop, repeats
/// itself to the last bit, however far rounding grew on the way.
fn believed(options: &Options, amplitude_g: f64, sections: &[Section], period: u32) -> bool {
    let Some(last) = sections.last() else {
        return false;
    };
    if period == 1 {
        return true;
    }
    let start = Some(last.state());
    orbit::difference_growth(&options.forced, amplitude_g, start, 0, 2 * period)
        .is_ok_and(|growth| growth.is_none_or(|growth| growth.resolved()))
}

/// Returns the periodic motions that do not go on from the amplitude before, with their periods,
/// the simplest first.
fn unlike_neighbours<'a>(
    options: &Options,
    columns: &'a [AmplitudeColumn],
) -> Vec<(&'a AmplitudeColumn, u32)> {
    let mut wanted: Vec<(&AmplitudeColumn, u32)> = Vec::new();
    let mut before: Option<&AmplitudeColumn> = None;
    // Orbits that rest every period neither double nor are born: their multipliers are zero.
    let moves = |column: &AmplitudeColumn| {
        !column.sections.iter().any(|section| section.rested) && column.peak_angle_rad > 0.0
    };
    for column in columns {
        let period = column.period.filter(|period| *period <= PERIOD_MAX);
        // Small motion lies near rest, and still does not go on from it.
        let new = before.is_none_or(|before| {
            before.period != column.period || !moves(before) || !continues(options, before, column)
        });
        if let Some(period) = period
            && new
            && moves(column)
        {
            wanted.push((column, period));
        }
        before = Some(column);
    }
    // The simplest first.
    wanted.sort_by(|a, b| {
        a.1.cmp(&b.1)
            .then(a.0.amplitude_g.total_cmp(&b.0.amplitude_g))
    });
    wanted
}

/// Returns what to take away of a branch, each with its value.
fn branch_headlines(branch: &Cascade) -> Vec<(String, f64)> {
    let period = branch
        .found()
        .map(|found| found.orbit.period)
        .min()
        .unwrap_or(1);
    let mut lines = Vec::new();
    let mut say = |what: &str, value: f64| lines.push((format!("period {period}: {what}"), value));
    if let Some(birth) = &branch.birth {
        let how = match birth.kind {
            BifurcationKind::SaddleNode => "born in a saddle-node at A [g]",
            BifurcationKind::PeriodDoubling => "doubles at A [g]",
        };
        say(how, birth.orbit.amplitude_g);
    }
    for doubling in &branch.doublings {
        let twice = 2 * doubling.orbit.period;
        say(
            &format!("doubles to {twice} at A [g]"),
            doubling.orbit.amplitude_g,
        );
    }
    if let Some(ratio) = branch.ratios().last() {
        say("last ratio of distances, Feigenbaum's is 4.669 [-]", *ratio);
    }
    if let (Some(at), true) = (branch.accumulation_g(), branch.doublings.len() >= 4) {
        say("the doublings tend to [g]", at);
    }
    lines
}

/// Follows orbits through their doublings and down to where they are born, at every amplitude at
/// which the motion is another than at the one before and that lies on none of the branches
/// followed before. Tells whether nobody stopped that.
fn changes(
    options: &Options,
    columns: &[AmplitudeColumn],
    control: &Control<'_>,
) -> (Vec<Cascade>, bool) {
    let mut wanted = unlike_neighbours(options, columns);
    let forced = &options.forced;
    let Range { low, high } = options.amplitudes_g;
    let pace = (high - low) / f64::from(options.points.max(2) - 1);
    let reach = BranchBounds {
        amplitudes_g: Range::new((low - pace).max(0.0), high + pace),
        levels: options.doublings,
        work: WORK_MAX,
    };
    let mut branches: Vec<Cascade> = Vec::new();
    // Followed, and nothing new found: not to be followed again.
    let mut spent: Vec<Cascade> = Vec::new();
    let mut whole = true;
    let known = |branches: &[Cascade], (column, period): (&AmplitudeColumn, u32)| {
        column.sections.last().is_some_and(|last| {
            branches
                .iter()
                .any(|branch| branch.contains(forced, column.amplitude_g, period, last.state()))
        })
    };
    while branches.len() < BRANCHES_MAX {
        // As many at a time whatever the threads, so that the numbers do not depend on them.
        wanted.retain(|one| !known(&branches, *one) && !known(&spent, *one));
        let mut batch: Vec<(&AmplitudeColumn, u32)> = Vec::new();
        for (column, period) in &wanted {
            // Two of one period may well lie on one branch.
            if batch.len() < AT_A_TIME && batch.iter().all(|(_, other)| other != period) {
                batch.push((column, *period));
            }
        }
        if batch.is_empty() {
            break;
        }
        // A batch of one is always begun, so that its end tells nothing.
        if !(control.proceed)(Some(branches.len() as f64 / BRANCHES_MAX as f64)) {
            whole = false;
            break;
        }
        wanted.retain(|(column, _)| {
            let index = |(column, _): &(&AmplitudeColumn, u32)| column.amplitude_g;
            !batch
                .iter()
                .any(|taken| index(taken).total_cmp(&column.amplitude_g).is_eq())
        });
        let followed = control.map(batch.len(), |index| {
            let (column, period) = batch[index];
            let start = column.sections.last()?.state();
            let orbit = orbit::find(forced, column.amplitude_g, period, start)?;
            Some(cascade::follow(forced, &orbit, pace, &reach))
        });
        let stopped = followed.iter().any(Option::is_none);
        for branch in followed.into_iter().flatten().flatten() {
            let bears = branch.found().next().is_some();
            match branches.iter_mut().find(|other| same(other, &branch)) {
                // Begun on an orbit that parts from another, a branch lacks that other's birth.
                Some(other) if begins_earlier(&branch, other) => {
                    spent.push(std::mem::replace(other, branch));
                }
                None if bears => branches.push(branch),
                _ => spent.push(branch),
            }
        }
        if stopped {
            whole = false;
            break;
        }
    }
    branches.truncate(BRANCHES_MAX);
    (branches, whole)
}

/// True if what is found first on a branch lies before that of another, or, with the same
/// beginning, whether more is found.
fn begins_earlier(a: &Cascade, b: &Cascade) -> bool {
    let first = |branch: &Cascade| {
        let amplitudes = branch.found().map(|found| found.orbit.amplitude_g);
        amplitudes.fold(f64::INFINITY, f64::min)
    };
    let (here, there) = (first(a), first(b));
    if (here - there).abs() > 1e-9 * there {
        here < there
    } else {
        a.found().count() > b.found().count()
    }
}

/// True if two branches are one: they share what was found first on both.
fn same(a: &Cascade, b: &Cascade) -> bool {
    let close = |a: &Bifurcation, b: &Bifurcation| {
        a.kind == b.kind
            && a.orbit.period == b.orbit.period
            && (a.orbit.amplitude_g - b.orbit.amplitude_g).abs() <= 1e-9 * b.orbit.amplitude_g
    };
    b.found()
        .any(|one| a.found().any(|other| close(one, other)))
}

/// True if the orbit at one amplitude is that at the next, a little moved.
fn continues(options: &Options, before: &AmplitudeColumn, after: &AmplitudeColumn) -> bool {
    /// Largest move of a section that is still taken for one [rad]; one that moves further is asked
    /// whether it lies on a branch that is known.
    const MOVED: f64 = 0.02;
    let Some(last) = after.sections.last().map(Section::state) else {
        return false;
    };
    before
        .sections
        .iter()
        .any(|section| options.forced.distance(section.state(), last) <= MOVED)
}

impl Diagram {
    /// Returns the diagram's points.
    pub fn rows(&self) -> Vec<Row> {
        self.columns
            .iter()
            .flat_map(|column| {
                column.sections.iter().map(|section| Row {
                    amplitude_g: column.amplitude_g,
                    angle_rad: section.angle_rad,
                    angular_velocity_rad_s: section.velocity_rad_s,
                })
            })
            .collect()
    }

    /// Returns every birth and doubling that was found.
    pub fn found(&self) -> impl Iterator<Item = &Bifurcation> {
        self.branches.iter().flat_map(Cascade::found)
    }

    /// Returns what to take away.
    pub fn headlines(&self) -> Vec<Headline> {
        let forced = &self.options.forced;
        let subject = format!("sine of {} rad/s", forced.angular_frequency_rad_s);
        let line = |what: String, value: Option<f64>| Headline {
            digits: Headline::DIGITS,
            subject: subject.clone(),
            model: Some(forced.stop),
            what,
            value,
        };
        let threshold = forced.design.criterion.threshold_rad;
        let moves = |column: &&AmplitudeColumn| column.peak_angle_rad > 1e-3 * threshold;
        let exceeds = |column: &&AmplitudeColumn| column.peak_angle_rad > threshold;
        let mut lines = vec![
            line(
                "a lever at rest leaves the rigid stop at A [g]".into(),
                Some(forced.lift_off_g()),
            ),
            line(
                "least A with lasting motion [g]".into(),
                self.columns.iter().find(moves).map(|c| c.amplitude_g),
            ),
            line(
                "least A with lasting motion beyond the threshold [g]".into(),
                self.columns.iter().find(exceeds).map(|c| c.amplitude_g),
            ),
        ];
        let share = |count: usize| count as f64 / self.columns.len().max(1) as f64;
        let irregular = self.columns.iter().filter(|c| c.period.is_none()).count();
        // The least period takes three to be seen, and what was not begun tells nothing.
        let seen = self.options.periods >= 3 && !self.columns.is_empty();
        lines.push(line(
            "share of amplitudes without a period seen [-]".into(),
            seen.then(|| share(irregular)),
        ));
        for branch in self.branches.iter().take(BRANCHES_SHOWN) {
            lines.extend(
                branch_headlines(branch)
                    .into_iter()
                    .map(|(what, value)| Headline {
                        digits: if what.ends_with("A [g]") {
                            Headline::EXACT
                        } else {
                            Headline::DIGITS
                        },
                        ..line(what, Some(value))
                    }),
            );
        }
        let more = self.branches.len().saturating_sub(BRANCHES_SHOWN) as f64;
        if more > 0.0 {
            lines.push(line(
                "further branches, in the JSON file".into(),
                Some(more),
            ));
        }
        lines
    }
}
