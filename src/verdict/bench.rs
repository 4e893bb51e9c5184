//! What every run of one assessment shares, and the runs themselves.

use super::Answer;
use super::ErrorBudget;
use super::assess::{Scope, settled};
use super::decision::{Judged, PASS_SHARE_MAX, Standing, decide};
use super::ensemble::{self, Count, End, Ensemble, Scatter};
use super::filters;
use super::ladder::{self, Known};
use super::policy::{Polarity, Policy};
use crate::conditioning::{Conditioned, Signal};
use crate::error::{Error, ErrorKind};
use crate::model::Design;
use crate::model::stop::StopModel;
use crate::parallel::Control;
use crate::replay::batch::{self, BatchOptions};
use crate::replay::{self, Method, Outcome, Run, RunOptions};
use crate::units::OpensWhen;
use std::collections::BTreeMap;

/// A stop and the sign that opens.
pub(crate) type Pair = (OpensWhen, StopModel);

/// What a run is for, which says what it need not carry along.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// Decides, and is drawn.
    Drawing,
    /// Decides.
    Deciding,
    /// Is compared with one that decides: its own error does not matter.
    Comparison,
}

/// What every run of one assessment shares.
#[derive(Clone, Copy)]
pub(crate) struct Bench<'a> {
    pub(crate) design: &'a Design,
    pub(crate) policy: &'a Policy,
    /// Follow every stop in full.
    pub(crate) follow_all: bool,
    pub(crate) control: &'a Control<'a>,
    pub(crate) signal: &'a Signal,
    /// The band-limited fourfold of the samples.
    pub(crate) fine: &'a Signal,
}

/// Samples, of all runs, from which further threads gain more than their start costs.
const SHARED_SAMPLES: usize = 20_000;

/// Members that a thread takes at a time.
const MEMBERS_TAKEN: usize = 64;

/// Members that are run one after the other between two questions whether a pass is still
/// possible.
const MEMBERS_IN_A_ROW: usize = 256;

/// How far members come.
#[derive(Debug, Clone, Default)]
pub(crate) struct Reached {
    /// Largest angle of each in the window [rad]; NaN if it could not be followed.
    pub(crate) peaks: Vec<f64>,
    /// Largest angle of each in the window or in the coast after it [rad]; NaN if it could not be
    /// followed.
    pub(crate) highest: Vec<f64>,
}

/// What is asked of the ensemble of one stop and polarity.
struct Asked<'a> {
    scatter: &'a Scatter,
    pair: Pair,
    standing: Standing,
    window: Option<(usize, usize)>,
    /// A pass need not be certain.
    presumed: bool,
}

/// How the question at one look ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Asking {
    /// More members exceed the threshold than a pass allows.
    NoPass,
    /// Every member was run.
    Complete,
    /// Those that were likely to exceed the threshold were run.
    Presumed,
}

/// What members did when a design like the present one was asked about: it says whom to ask
/// first, and nothing else.
#[derive(Debug, Clone, Default)]
pub(crate) struct Recall {
    /// Peaks [rad] of the members of each stop and polarity, where they were run last.
    peaks: Vec<(Pair, BTreeMap<u32, f64>)>,
    /// The stop and polarity that did not pass last.
    in_the_way: Option<usize>,
}

impl Recall {
    fn of(&mut self, pair: Pair) -> &mut BTreeMap<u32, f64> {
        let index = match self.peaks.iter().position(|(known, _)| *known == pair) {
            Some(index) => index,
            None => {
                self.peaks.push((pair, BTreeMap::new()));
                self.peaks.len() - 1
            }
        };
        &mut self.peaks[index].1
    }
}

/// Part of the threshold from which on a peak makes its member worth asking first.
const NEAR_PART: f64 = 0.8;

/// Members that came near the threshold or went beyond, the furthest first.
fn likely(last: &BTreeMap<u32, f64>, threshold: f64) -> Vec<u32> {
    let mut near: Vec<(u32, f64)> = last
        .iter()
        .map(|(member, peak)| (*member, if peak.is_nan() { f64::INFINITY } else { *peak }))
        .filter(|(_, peak)| *peak > NEAR_PART * threshold)
        .collect();
    near.sort_by(|a, b| b.1.total_cmp(&a.1));
    near.into_iter().map(|(member, _)| member).collect()
}

/// Whether a member counts against a pass: it exceeds the threshold or was not followed.
fn exceeds(peak: f64, threshold: f64) -> bool {
    !peak.is_finite() || peak > threshold
}

fn exceeding(peaks: &[Option<f64>], threshold: f64) -> usize {
    let known = peaks.iter().flatten();
    known.filter(|peak| exceeds(**peak, threshold)).count()
}

/// The most members of a look that a pass lets exceed the threshold; none where not even that
/// is enough for a pass, which a complete look then shows.
fn most_of_a_pass(look: u32) -> usize {
    let allows = |count: u32| {
        let share = Count {
            members: look,
            exceeded: count,
            exceeded_in_coast: 0,
            failed_to_run: 0,
        }
        .share();
        share.upper <= PASS_SHARE_MAX
    };
    let (mut most, mut more) = (0, look);
    while more - most > 1 {
        let middle = u32::midpoint(most, more);
        if allows(middle) {
            most = middle;
        } else {
            more = middle;
        }
    }
    most as usize
}

impl Bench<'_> {
    /// Does `of` each item, which takes `runs` runs or so on all of them, and returns the results
    /// in the items' order; on one thread for few runs of a short recording.
    ///
    /// # Errors
    ///
    /// The first of `of`, in the items' order; [`ErrorKind::Stopped`].
    pub(crate) fn share<T: Sync, R: Send>(
        &self,
        runs: usize,
        items: &[T],
        of: impl Fn(&T) -> Result<R, Error> + Sync,
    ) -> Result<Vec<R>, Error> {
        let few = self.signal.samples.len().saturating_mul(runs) < SHARED_SAMPLES;
        let threads = if few { 1 } else { self.control.threads };
        self.control
            .unmeasured(|control| control.with_threads(threads).try_map(items, of))
    }

    /// The initial state asked for, what is left open being that of rest on the stop.
    pub(crate) fn initial(&self, stop: StopModel) -> Option<(f64, f64)> {
        let (angle, velocity) = (
            self.policy.initial_angle_rad,
            self.policy.initial_velocity_rad_s,
        );
        if angle.is_none() && velocity.is_none() {
            return None;
        }
        let rest = match stop {
            StopModel::Rigid => 0.0,
            StopModel::Soft => self.design.stop.rest_angle_rad(&self.design.lever),
        };
        Some((angle.unwrap_or(rest), velocity.unwrap_or(0.0)))
    }

    pub(crate) fn run(
        &self,
        signal: &Signal,
        pair: Pair,
        window: Option<(usize, usize)>,
        purpose: Purpose,
    ) -> Result<Outcome, Error> {
        // The error budget reruns with the other stop, which the method asked for may not know.
        let (method, tolerance_rad) = if self.policy.method.admits(pair.1) {
            (self.policy.method, self.policy.tolerance_rad)
        } else {
            (Method::EventDriven, None)
        };
        replay::run(
            signal,
            self.design,
            &RunOptions {
                stop: pair.1,
                opens_when: pair.0,
                method,
                tolerance_rad,
                step_s: None,
                initial: self.initial(pair.1),
                window,
                trace: purpose == Purpose::Drawing,
                error_bound: purpose != Purpose::Comparison,
            },
        )
    }

    /// Runs every pair on the samples and, unless `spare` knows enough of it, on their fourfold.
    /// `spare` sees the nominal runs and says of each pair what stands in for a run.
    pub(crate) fn judge_all(
        &self,
        pairs: &[Pair],
        window: Option<(usize, usize)>,
        purpose: Purpose,
        spare: &dyn Fn(&[Outcome]) -> Vec<Option<Known>>,
    ) -> Result<Vec<Judged>, Error> {
        let outcomes = self.share(1, pairs, |pair| {
            self.run(self.signal, *pair, window, purpose)
        })?;
        let known = spare(&outcomes);
        let fine_window = window.map(|(first, last)| (4 * first, 4 * last));
        let tasks: Vec<(Pair, Option<Known>)> = pairs
            .iter()
            .enumerate()
            .map(|(index, pair)| (*pair, known.get(index).copied().flatten()))
            .collect();
        let fine = self.share(4, &tasks, |(pair, known)| {
            known
                .is_none()
                .then(|| self.run(self.fine, *pair, fine_window, Purpose::Comparison))
                .transpose()
        })?;
        Ok(outcomes
            .into_iter()
            .zip(tasks)
            .zip(fine)
            .map(|((outcome, (_, known)), fine)| match (fine, known) {
                (Some(fine), _) => compared(outcome, &fine),
                (None, Some(known)) => known.judged(outcome),
                (None, None) => Known::default().judged(outcome),
            })
            .collect())
    }

    /// Returns what the nominal runs say alone. Of one that was left out because nearly all
    /// scattered levers cross, the error is not known: its fourfold is run.
    pub(crate) fn nominal_answers(
        &self,
        pairs: &[Pair],
        window: Option<(usize, usize)>,
        judged: &[Judged],
    ) -> Result<Vec<Answer>, Error> {
        let threshold = self.design.criterion.threshold_rad;
        let fine_window = window.map(|(first, last)| (4 * first, 4 * last));
        pairs
            .iter()
            .zip(judged)
            .map(|(pair, judged)| {
                let answer = judged.nominal_answer(threshold);
                if !(judged.left_out && answer == Answer::Undecided) {
                    return Ok(answer);
                }
                let fine = self.run(self.fine, *pair, fine_window, Purpose::Comparison)?;
                Ok(compared(judged.outcome.clone(), &fine).nominal_answer(threshold))
            })
            .collect()
    }

    /// Says of which pairs bounds prove what their nominal run says by the rule without an
    /// ensemble.
    pub(crate) fn spare_nominal(
        &self,
        pairs: &[Pair],
        window: Option<(usize, usize)>,
        scope: Scope,
        outcomes: &[Outcome],
    ) -> Vec<Option<Known>> {
        if ladder::may_leave_out(self.policy, self.follow_all, scope).is_err() {
            return Vec::new();
        }
        let threshold = self.design.criterion.threshold_rad;
        pairs
            .iter()
            .zip(outcomes)
            .map(|(pair, outcome)| {
                let known = ladder::known(self, None, *pair, window, outcome, None);
                known.proves(outcome, threshold, 0).map(|_| known)
            })
            .collect()
    }

    /// Runs the ensemble of every pair, look by look, until the rule decides or what is still
    /// open can no longer change the answer; notes in `judged` what it adds. A pair that was left
    /// out has no ensemble. `limited`: the samples end before a fault.
    pub(crate) fn ensembles(
        &self,
        scatter: &Scatter,
        pairs: &[Pair],
        judged: &mut [Judged],
        window: Option<(usize, usize)>,
        limited: bool,
    ) -> Result<Vec<Option<Ensemble>>, Error> {
        let threshold = self.design.criterion.threshold_rad;
        let polarity = self.policy.polarity;
        // The largest nominal peak comes first: its ensemble is the one that is shown.
        let mut order: Vec<usize> = (0..pairs.len()).collect();
        order.sort_by(|a, b| {
            let peak = |index: &usize| judged[*index].run().peak_angle_rad;
            peak(b).total_cmp(&peak(a))
        });
        let mut reached = vec![Reached::default(); pairs.len()];
        let mut looks = vec![0; pairs.len()];
        let mut answers: Vec<Option<Answer>> = judged
            .iter()
            .map(|judged| judged.left_out.then(|| judged.answer(threshold)))
            .collect();
        let mut ends = vec![End::NoMatter; pairs.len()];
        for (number, look) in (1..).zip(ensemble::looks(self.policy.members)) {
            for &pair in &order {
                let settled =
                    looks[pair] > 0 && settled(polarity, pairs, &answers, judged, threshold);
                if answers[pair].is_some() || settled {
                    continue;
                }
                self.extend(scatter, pairs[pair], window, look, &mut reached[pair])?;
                looks[pair] = number;
                let Reached { peaks, highest } = &reached[pair];
                let share = Count::with_coast(peaks, highest, threshold).share();
                judged[pair].share = Some(share);
                let answer = judged[pair].answer(threshold);
                if answer != Answer::Undecided {
                    (answers[pair], ends[pair]) = (Some(answer), End::Decided);
                } else if look == self.policy.members {
                    (answers[pair], ends[pair]) = (Some(answer), End::LastLook);
                }
            }
        }
        let until = window
            .filter(|_| limited)
            .map(|(_, last)| self.signal.time_s(last));
        Ok((0..pairs.len())
            .map(|pair| {
                (looks[pair] > 0).then(|| {
                    ensemble::summarise(
                        scatter,
                        (&reached[pair].peaks, &reached[pair].highest),
                        threshold,
                        pairs[pair],
                        (looks[pair], ends[pair]),
                        until,
                    )
                })
            })
            .collect())
    }

    /// Returns whether every pair passes by the rule, as [`Self::ensembles`] would have it, and
    /// asks no more members than that takes: first those that `recall` has seen near or beyond
    /// the threshold. Where a pass may be `presumed`, those alone, if it has seen all others stay
    /// below; what is no pass is so for certain.
    pub(crate) fn all_pass(
        &self,
        scatter: &Scatter,
        pairs: &[Pair],
        judged: &[Judged],
        window: Option<(usize, usize)>,
        recall: &mut Recall,
        presumed: bool,
    ) -> Result<bool, Error> {
        let threshold = self.design.criterion.threshold_rad;
        if judged
            .iter()
            .any(|judged| judged.nominal_answer(threshold) != Answer::Pass)
        {
            return Ok(false);
        }
        // The one that was in the way before is likely to be so again.
        let mut order: Vec<usize> = (0..pairs.len()).collect();
        order.sort_by_key(|index| Some(*index) != recall.in_the_way);
        for index in order {
            let asked = Asked {
                scatter,
                pair: pairs[index],
                standing: judged[index].standing(),
                window,
                presumed,
            };
            if !self.passes(&asked, recall.of(pairs[index]))? {
                recall.in_the_way = Some(index);
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Returns whether one pair passes by the rule. A look is done with as soon as more members
    /// exceed the threshold than it allows a pass, whichever they are.
    fn passes(&self, asked: &Asked<'_>, last: &mut BTreeMap<u32, f64>) -> Result<bool, Error> {
        let threshold = self.design.criterion.threshold_rad;
        let likely = likely(last, threshold);
        let mut peaks: Vec<Option<f64>> = vec![None; self.policy.members as usize];
        let mut before = Vec::new();
        let mut answer = Answer::Undecided;
        for look in ensemble::looks(self.policy.members) {
            let all_seen = asked.presumed && last.range(..look).count() == look as usize;
            match self.ask(asked, look, &likely, all_seen, &mut peaks)? {
                Asking::NoPass => {
                    before.push(look);
                    continue;
                }
                Asking::Presumed => {
                    answer = Answer::Pass;
                    break;
                }
                Asking::Complete => {}
            }
            // Every member of the look was run. An earlier one that fails comes first.
            before.push(look);
            let of_looks = before.iter().map(|look| {
                let known: Vec<f64> = peaks[..*look as usize].iter().flatten().copied().collect();
                let share = Count::of(&known, threshold).share();
                decide(&asked.standing, threshold, Some(share))
            });
            answer = of_looks
                .into_iter()
                .find(|answer| *answer != Answer::Undecided)
                .unwrap_or(Answer::Undecided);
            if answer != Answer::Undecided {
                break;
            }
        }
        for (member, peak) in (0..).zip(&peaks) {
            if let Some(peak) = peak {
                last.insert(member, *peak);
            }
        }
        Ok(answer == Answer::Pass)
    }

    /// Runs members of a look until it is certain that it allows no pass, or all of them; or,
    /// where `all_seen` says that the others stayed below when they were last asked, until hardly
    /// any of those that are likely to exceed the threshold still does.
    fn ask(
        &self,
        asked: &Asked<'_>,
        look: u32,
        likely: &[u32],
        all_seen: bool,
        peaks: &mut [Option<f64>],
    ) -> Result<Asking, Error> {
        let threshold = self.design.criterion.threshold_rad;
        let most = most_of_a_pass(look);
        // Where what was likely does not come true, one after the other is no worse.
        let worth_one_in = if all_seen { 32 } else { 4 };
        let mut likely = likely.iter().copied().filter(|member| *member < look);
        let mut worthwhile = true;
        loop {
            let count = exceeding(&peaks[..look as usize], threshold);
            if count > most {
                return Ok(Asking::NoPass);
            }
            let open = |member: &u32| peaks[*member as usize].is_none();
            let mut wanted: Vec<u32> = Vec::new();
            let from_likely = worthwhile;
            if worthwhile {
                let missing = (most + 1 - count).max(MEMBERS_TAKEN);
                wanted = likely.by_ref().filter(open).take(missing).collect();
                worthwhile = wanted.len() == missing;
            }
            if wanted.is_empty() {
                if all_seen {
                    return Ok(Asking::Presumed);
                }
                wanted = (0..look).filter(open).take(MEMBERS_IN_A_ROW).collect();
            }
            if wanted.is_empty() {
                return Ok(Asking::Complete);
            }
            let found = self.peaks_of(asked, &wanted)?;
            for (member, peak) in wanted.iter().zip(&found) {
                peaks[*member as usize] = Some(*peak);
            }
            if from_likely {
                let true_ones = found.iter().filter(|peak| exceeds(**peak, threshold));
                worthwhile &= worth_one_in * true_ones.count() >= found.len();
            }
        }
    }

    /// Returns the largest angles of the members named, coast included [rad], NaN where one could
    /// not be followed.
    fn peaks_of(&self, asked: &Asked<'_>, members: &[u32]) -> Result<Vec<f64>, Error> {
        let tasks: Vec<&[u32]> = members.chunks(MEMBERS_TAKEN).collect();
        let mut peaks = Vec::with_capacity(members.len());
        for found in self.share(members.len(), &tasks, |task| {
            self.peaks(asked.pair, asked.window, task.len(), &|index| {
                asked.scatter.member(task[index])
            })
        })? {
            peaks.extend(found.highest);
        }
        Ok(peaks)
    }

    /// Runs the members of one pair up to `look`, those that are in `reached` not again.
    fn extend(
        &self,
        scatter: &Scatter,
        pair: Pair,
        window: Option<(usize, usize)>,
        look: u32,
        reached: &mut Reached,
    ) -> Result<(), Error> {
        let known = u32::try_from(reached.peaks.len()).unwrap_or(look);
        let tasks: Vec<u32> = (known..look).step_by(MEMBERS_TAKEN).collect();
        let runs = tasks.len().saturating_mul(MEMBERS_TAKEN);
        for more in self.share(runs, &tasks, |&first| {
            let count = MEMBERS_TAKEN.min((look - first) as usize);
            self.peaks(pair, window, count, &|index| {
                scatter.member(first.saturating_add(u32::try_from(index).unwrap_or(0)))
            })
        })? {
            reached.peaks.extend(more.peaks);
            reached.highest.extend(more.highest);
        }
        Ok(())
    }

    /// Returns how far `count` members come on one stop and polarity.
    pub(crate) fn peaks(
        &self,
        pair: Pair,
        window: Option<(usize, usize)>,
        count: usize,
        member: &(impl Fn(usize) -> batch::Member + Sync),
    ) -> Result<Reached, Error> {
        let options = BatchOptions {
            stop: pair.1,
            opens_when: pair.0,
            initial: self.initial(pair.1),
            window,
            coast: true,
            threads: 1,
        };
        let peaks = batch::peaks(self.signal, count, member, &options)?;
        Ok(Reached {
            peaks: peaks.iter().map(|peak| peak.peak_angle_rad).collect(),
            highest: peaks.iter().map(batch::MemberPeak::highest_rad).collect(),
        })
    }

    /// When the lever first crosses the threshold outside the judged window, if it does so on
    /// a stop and polarity that do not cross inside.
    pub(crate) fn crossing_outside(
        &self,
        pairs: &[Pair],
        judged: &[Judged],
        window: Option<(usize, usize)>,
    ) -> Result<Option<f64>, Error> {
        let tasks: Vec<Pair> = pairs
            .iter()
            .zip(judged)
            .filter(|(_, judged)| window.is_some() && judged.run().first_crossing_s.is_none())
            .map(|(pair, _)| *pair)
            .collect();
        let mut first: Option<f64> = None;
        for outcome in self.share(1, &tasks, |pair| {
            self.run(self.signal, *pair, None, Purpose::Comparison)
        })? {
            let crossing = outcome.run.first_crossing_s;
            first = match (first, crossing) {
                (Some(first), Some(crossing)) => Some(first.min(crossing)),
                (first, crossing) => first.or(crossing),
            };
        }
        Ok(first)
    }

    pub(crate) fn budget(
        &self,
        conditioned: &Conditioned,
        window: Option<(usize, usize)>,
        pairs: &[Pair],
        judged: &[Judged],
        nominal: usize,
        unfiltered_peak: Option<f64>,
    ) -> Result<ErrorBudget, Error> {
        let (sign, stop) = pairs[nominal];
        let peak = judged[nominal].run().peak_angle_rad;
        let other_stop = match stop {
            StopModel::Rigid => StopModel::Soft,
            StopModel::Soft => StopModel::Rigid,
        };
        let known = |pair| {
            pairs
                .iter()
                .position(|known| *known == pair)
                .map(|index| judged[index].run().peak_angle_rad)
        };
        // Each entry is a rerun: the signal to use and the pair to run it with.
        let mut reruns: Vec<(Part, Signal, Pair)> = Vec::new();
        if unfiltered_peak.is_none() && conditioned.filter.is_some() {
            let unfiltered = filters::filtered(conditioned, None)?;
            reruns.push((Part::Filter, unfiltered, (sign, stop)));
        }
        if conditioned.bias_samples > 0 {
            for direction in [-1.0, 1.0] {
                let mut shifted = self.signal.clone();
                let shift = direction * conditioned.bias_standard_error_m_s2;
                shifted.samples.iter_mut().for_each(|a| *a += shift);
                reruns.push((Part::Bias, shifted, (sign, stop)));
            }
        }
        let model_peak = known((sign, other_stop));
        // A lever that starts inside the soft stop has no counterpart on the rigid one.
        let admitted = other_stop == StopModel::Soft
            || self
                .policy
                .initial_angle_rad
                .is_none_or(|angle| angle >= 0.0);
        if model_peak.is_none() && admitted {
            reruns.push((Part::Model, self.signal.clone(), (sign, other_stop)));
        }
        let outcomes = self.share(1, &reruns, |(_, signal, pair)| {
            self.run(signal, *pair, window, Purpose::Comparison)
        })?;
        let mut budget = ErrorBudget {
            numerical: Some(judged[nominal].run().numerical_error_rad),
            interpolation: Some(judged[nominal].interpolation_error_rad),
            model: model_peak.map(|other| (other - peak).abs()),
            filter: unfiltered_peak
                .or(conditioned.filter.is_none().then_some(peak))
                .map(|other| (other - peak).abs()),
            bias: None,
            polarity: None,
        };
        for ((part, _, _), outcome) in reruns.iter().zip(outcomes) {
            let change = (outcome.run.peak_angle_rad - peak).abs();
            let entry = match part {
                Part::Filter => &mut budget.filter,
                Part::Bias => &mut budget.bias,
                Part::Model => &mut budget.model,
            };
            *entry = Some(entry.map_or(change, |before| before.max(change)));
        }
        if self.policy.polarity == Polarity::Undeclared {
            budget.polarity = known((sign.reversed(), stop)).map(|other| (other - peak).abs());
        }
        Ok(budget)
    }
}

/// Sets a run beside the same on the fourfold of its samples.
fn compared(outcome: Outcome, fine: &Outcome) -> Judged {
    let highest = |run: &Run| {
        run.coast_peak_angle_rad
            .map_or(run.peak_angle_rad, |coast| coast.max(run.peak_angle_rad))
    };
    let interpolation_error_rad = (fine.run.peak_angle_rad - outcome.run.peak_angle_rad)
        .abs()
        .max(if outcome.run.coast_peak_angle_rad.is_some() {
            (highest(&fine.run) - highest(&outcome.run)).abs()
        } else {
            0.0
        });
    Judged {
        outcome,
        // A rerun that could not be followed bounds nothing.
        interpolation_error_rad: if fine.broke_down {
            f64::MAX
        } else {
            interpolation_error_rad
        },
        share: None,
        left_out: false,
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Filter,
    Bias,
    Model,
}

/// Spares no run, whatever bounds may know.
pub(crate) fn follow_all(_: &[Outcome]) -> Vec<Option<Known>> {
    Vec::new()
}

/// First and last sample inside a window.
pub(crate) fn window_samples(
    signal: &Signal,
    (from, to): (f64, f64),
) -> Result<(usize, usize), Error> {
    let rate = signal.rate.hertz();
    let count = signal.samples.len();
    // A billionth of a sample absorbs the rounding of a bound that was meant to hit a sample.
    let place = |time: f64| (time - signal.start_s) * rate;
    let last = count as f64 - 1.0;
    let first_index = (place(from) - 1e-6).ceil().max(0.0);
    let last_index = (place(to) + 1e-6).floor().min(last);
    if first_index.is_nan() || last_index.is_nan() || first_index >= last_index {
        return Err(ErrorKind::OutOfRange {
            what: "window [s]".into(),
            expected: format!(
                "an interval that holds at least two samples of the record, which runs from {} to {}",
                signal.start_s,
                signal.end_s()
            ),
            found: format!("{from}..{to}"),
        }
        .into());
    }
    Ok((first_index as usize, last_index as usize))
}

/// The judged samples before the first bad one, if there are two.
pub(crate) fn samples_before(
    signal: &Signal,
    bad_s: f64,
    window: Option<(usize, usize)>,
) -> Option<(usize, usize)> {
    let (first, last) = window.unwrap_or((0, signal.samples.len() - 1));
    let place = (bad_s - signal.start_s) * signal.rate.hertz();
    if place.is_nan() || place <= first as f64 + 2.0 {
        return None;
    }
    let good = ((place - 1e-6).ceil() as usize).saturating_sub(1).min(last);
    (good > first + 1).then_some((first, good))
}
