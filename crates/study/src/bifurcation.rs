//! Stroboscopic sections against the excitation's amplitude, with the births and doublings of orbits.
//!
//! Columns of sections are computed first, each by itself. Then neighbours are compared: an orbit that
//! does not continue the one before is followed to its birth and its doublings.

use super::Headline;
use super::cascade::{self, BranchBounds, Cascade};
use super::orbit::{self, Bifurcation, BifurcationKind, ForcedLever};
use latchgate_kernel::parallel::Control;
use latchgate_kernel::range::Range;
use latchgate_kernel::replay::strobe_batch::Ending;
use latchgate_kernel::replay::{Section, State};
use latchgate_recording::error::Error;
use serde::Serialize;

/// Order of the amplitudes, and whether the state at the end of one starts the next.
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
    /// Number of amplitudes.
    pub points: u32,
    /// Periods of the transient at each amplitude, which are not kept.
    pub transient: u32,
    /// Periods kept at each amplitude.
    pub periods: u32,
    /// Initial state; `None` for rest.
    pub initial: Option<State>,
    /// Order of the amplitudes.
    pub sweep: Sweep,
    /// Doublings sought on each branch; 0 to follow none.
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

/// Motion at one amplitude.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AmplitudeColumn {
    /// Amplitude [g].
    pub amplitude_g: f64,
    /// Period, in periods of the excitation; `None` if none was seen, or only one that rounding made.
    pub period: Option<u32>,
    /// Largest angle among the periods kept [rad].
    pub peak_angle_rad: f64,
    /// Impacts per period.
    pub impacts_per_period: f64,
    /// The sections.
    #[serde(skip)]
    pub sections: Vec<Section>,
}

/// Result of the study.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagram {
    /// Options of the study.
    pub options: Options,
    /// Columns, by amplitude; those not reached before a stop are missing.
    pub columns: Vec<AmplitudeColumn>,
    /// Branches of orbits, each from its birth through its doublings; the simplest first.
    pub branches: Vec<Cascade>,
    /// True if the work was not stopped.
    pub complete: bool,
}

/// Distance below which two states are the same [rad].
const SAME: f64 = 1e-7;

/// Longest period whose births and doublings are sought.
const PERIOD_MAX: u32 = 32;

/// Largest number of branches followed.
const BRANCHES_MAX: usize = 16;

/// Branches followed in one batch.
const AT_A_TIME: usize = 4;

/// Branches that the answer on stdout lists.
const BRANCHES_SHOWN: usize = 6;

/// Largest work on a branch [periods computed].
const WORK_MAX: u32 = 8_000;

/// Computes the points of the diagram and the changes of orbits.
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

/// Returns the columns of all amplitudes from the same start, computed side by side.
fn side_by_side(
    options: &Options,
    count: usize,
    amplitude: &(impl Fn(usize) -> f64 + Sync),
    control: &Control<'_>,
) -> Result<Vec<AmplitudeColumn>, Error> {
    let forced = &options.forced;
    let periods_max = options.transient + options.periods;
    let followed = forced.follow(
        count,
        |index| forced.start(options.initial, amplitude(index)),
        &forced.batch(periods_max, options.periods, true, control.threads),
        control,
    )?;
    Ok(followed
        .into_iter()
        .map(|lever| {
            // The last sections of a lever that was lost before its end may belong to the transient.
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

/// Returns true if rounding cannot have made a period. A lever that rests, on either stop, repeats itself to the
/// last bit, however far rounding grew on the way.
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

/// Returns the periodic motions that do not continue the one at the amplitude before, with their periods, the
/// shortest period first.
fn unlike_neighbours<'a>(
    options: &Options,
    columns: &'a [AmplitudeColumn],
) -> Vec<(&'a AmplitudeColumn, u32)> {
    let mut candidates: Vec<(&AmplitudeColumn, u32)> = Vec::new();
    let mut before: Option<&AmplitudeColumn> = None;
    // Orbits that rest every period neither double nor are born: their multipliers are zero.
    let moves = |column: &AmplitudeColumn| {
        !column.sections.iter().any(|section| section.rested) && column.peak_angle_rad > 0.0
    };
    for column in columns {
        let period = column.period.filter(|period| *period <= PERIOD_MAX);
        // A small motion lies near rest but does not continue it.
        let new = before.is_none_or(|before| {
            before.period != column.period || !moves(before) || !continues(options, before, column)
        });
        if let Some(period) = period
            && new
            && moves(column)
        {
            candidates.push((column, period));
        }
        before = Some(column);
    }
    candidates.sort_by(|a, b| {
        a.1.cmp(&b.1)
            .then(a.0.amplitude_g.total_cmp(&b.0.amplitude_g))
    });
    candidates
}

/// Returns the headline figures of a branch, words with values.
fn branch_headlines(branch: &Cascade) -> Vec<(String, f64)> {
    let period = branch
        .bifurcations()
        .map(|bifurcation| bifurcation.orbit.period)
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
    if let (Some(limit_g), true) = (branch.accumulation_g(), branch.doublings.len() >= 4) {
        say("the doublings tend to [g]", limit_g);
    }
    lines
}

/// Follows orbits down to their birth and up through their doublings, at every amplitude whose motion does not
/// continue the one before and lies on no branch followed so far; false if the work was stopped.
fn changes(
    options: &Options,
    columns: &[AmplitudeColumn],
    control: &Control<'_>,
) -> (Vec<Cascade>, bool) {
    let mut candidates = unlike_neighbours(options, columns);
    let forced = &options.forced;
    let Range { low, high } = options.amplitudes_g;
    let pace = (high - low) / f64::from(options.points.max(2) - 1);
    let reach = BranchBounds {
        amplitudes_g: Range::new((low - pace).max(0.0), high + pace),
        levels: options.doublings,
        work: WORK_MAX,
    };
    let mut branches: Vec<Cascade> = Vec::new();
    // Branches that gave nothing new; an orbit on one of them is not followed again.
    let mut spent: Vec<Cascade> = Vec::new();
    let mut complete = true;
    let is_on_branch = |branches: &[Cascade], (column, period): (&AmplitudeColumn, u32)| {
        column.sections.last().is_some_and(|last| {
            branches
                .iter()
                .any(|branch| branch.contains(forced, column.amplitude_g, period, last.state()))
        })
    };
    while branches.len() < BRANCHES_MAX {
        // The size of a batch does not depend on the threads, so that the numbers do not either.
        candidates.retain(|candidate| {
            !is_on_branch(&branches, *candidate) && !is_on_branch(&spent, *candidate)
        });
        let mut batch: Vec<(&AmplitudeColumn, u32)> = Vec::new();
        for (column, period) in &candidates {
            // Two orbits of one period may lie on one branch, which would be followed twice.
            if batch.len() < AT_A_TIME
                && batch.iter().all(|(_, batch_period)| batch_period != period)
            {
                batch.push((column, *period));
            }
        }
        if batch.is_empty() {
            break;
        }
        // `map` begins a batch of one even after a stop, so the wish to stop is read here.
        if !(control.proceed)(Some(branches.len() as f64 / BRANCHES_MAX as f64)) {
            complete = false;
            break;
        }
        candidates.retain(|(column, _)| {
            !batch
                .iter()
                .any(|(in_batch, _)| in_batch.amplitude_g.total_cmp(&column.amplitude_g).is_eq())
        });
        let followed = control.map(batch.len(), |index| {
            let (column, period) = batch[index];
            let start = column.sections.last()?.state();
            let orbit = orbit::find(forced, column.amplitude_g, period, start)?;
            Some(cascade::follow(forced, &orbit, pace, &reach))
        });
        let stopped = followed.iter().any(Option::is_none);
        for branch in followed.into_iter().flatten().flatten() {
            let bears = branch.bifurcations().next().is_some();
            match branches.iter_mut().find(|earlier| same(earlier, &branch)) {
                // A branch followed from an orbit that parted from the earlier one lacks its birth.
                Some(earlier) if begins_earlier(&branch, earlier) => {
                    spent.push(std::mem::replace(earlier, branch));
                }
                None if bears => branches.push(branch),
                _ => spent.push(branch),
            }
        }
        if stopped {
            complete = false;
            break;
        }
    }
    branches.truncate(BRANCHES_MAX);
    (branches, complete)
}

/// Returns true if the first bifurcation of branch `a` lies below that of `b`, or, if both begin alike, `a` has
/// more of them.
fn begins_earlier(a: &Cascade, b: &Cascade) -> bool {
    let first = |branch: &Cascade| {
        let amplitudes = branch
            .bifurcations()
            .map(|bifurcation| bifurcation.orbit.amplitude_g);
        amplitudes.fold(f64::INFINITY, f64::min)
    };
    let (first_a, first_b) = (first(a), first(b));
    if (first_a - first_b).abs() > 1e-9 * first_b {
        first_a < first_b
    } else {
        a.bifurcations().count() > b.bifurcations().count()
    }
}

/// Returns true if two branches share a bifurcation, and so are one.
fn same(a: &Cascade, b: &Cascade) -> bool {
    let close = |a: &Bifurcation, b: &Bifurcation| {
        a.kind == b.kind
            && a.orbit.period == b.orbit.period
            && (a.orbit.amplitude_g - b.orbit.amplitude_g).abs() <= 1e-9 * b.orbit.amplitude_g
    };
    b.bifurcations()
        .any(|of_b| a.bifurcations().any(|of_a| close(of_b, of_a)))
}

/// Returns true if the orbit at one amplitude is that at the next, slightly moved.
fn continues(options: &Options, before: &AmplitudeColumn, after: &AmplitudeColumn) -> bool {
    /// Largest move of a section on one orbit [rad]. An orbit that moves further is compared with the branches
    /// followed so far.
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

    /// Returns all births and doublings.
    pub fn bifurcations(&self) -> impl Iterator<Item = &Bifurcation> {
        self.branches.iter().flat_map(Cascade::bifurcations)
    }

    /// Returns the headline figures.
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
        // A period shows only after three repetitions, and without columns there is no share.
        let can_show_period = self.options.periods >= 3 && !self.columns.is_empty();
        lines.push(line(
            "share of amplitudes without a period seen [-]".into(),
            can_show_period.then(|| share(irregular)),
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
