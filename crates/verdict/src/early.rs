//! Whether every variant passes, asked of as few members as that takes.
//!
//! A search over designs asks this hundreds of times. A look cannot pass any more as soon as more
//! members cross than it allows, whichever they are: members that crossed at a design nearby are
//! asked first, and most of the others never.

use super::Answer;
use super::decision::{PeakEstimate, VariantRun, decide};
use super::ensemble::{self, Count, Scatter, most_of_a_pass};
use super::looks::MEMBERS_TAKEN;
use super::policy::Variant;
use super::runs::RunSetup;
use latchgate_kernel::replay::batch::AskedPeaks;
use latchgate_recording::error::Error;

/// Members that are run one after the other between two questions whether a pass is still
/// possible.
const MEMBERS_IN_A_ROW: usize = 256;

/// Members that the widest vectors take side by side.
const IN_A_VECTOR: usize = 16;

/// Part of the threshold from which on a peak makes its member worth asking first.
const NEAR_PART: f64 = 0.8;

/// Highest angles of the members, coast included, at designs that were asked about before.
///
/// The cache says whom to ask first. The answer does not depend on it, unless it is trusted.
#[derive(Debug, Clone, Default)]
pub(crate) struct MemberCache {
    /// Of each variant, the angle [rad] of each member where it was run last.
    peaks: Vec<(Variant, Vec<Option<f64>>)>,
    /// The variant that did not pass last.
    in_the_way: Option<Variant>,
}

impl MemberCache {
    /// Returns the variants with the one first that was in the way before: it is likely to be so again.
    pub(crate) fn in_the_way_first(&self, mut variants: Vec<Variant>) -> Vec<Variant> {
        let before = variants
            .iter()
            .position(|one| Some(*one) == self.in_the_way);
        if let Some(place) = before {
            variants[..=place].rotate_right(1);
        }
        variants
    }

    /// Notes the variant that did not pass.
    pub(crate) fn stands_in_the_way(&mut self, variant: Variant) {
        self.in_the_way = Some(variant);
    }

    fn peaks_of(&mut self, variant: Variant) -> &mut Vec<Option<f64>> {
        let known = self.peaks.iter().position(|(one, _)| *one == variant);
        let place = known.unwrap_or_else(|| {
            self.peaks.push((variant, Vec::new()));
            self.peaks.len() - 1
        });
        &mut self.peaks[place].1
    }
}

/// The question of one variant.
struct Question<'a> {
    setup: &'a RunSetup<'a>,
    scatter: &'a Scatter,
    variant: Variant,
    estimate: PeakEstimate,
    trust_cache: bool,
}

/// The end of the question at one look.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LookEnd {
    /// More members exceed the threshold than a pass allows.
    NoPass,
    /// Every member was run.
    Complete,
    /// Those that were likely to exceed the threshold were run; the cache is trusted for the rest.
    Trusted,
}

/// Returns whether every variant passes by the rule, as its whole ensemble would have it, of `runs`
/// which pass alone; asked first is the one that was in the way before.
///
/// With `trust_cache` a pass is not certain: where the cache has seen every member of a look, those
/// that stayed well below the threshold are not run again. "No pass" is certain in any case.
pub(super) fn all_pass(
    setup: &RunSetup<'_>,
    scatter: &Scatter,
    runs: &[VariantRun],
    cache: &mut MemberCache,
    trust_cache: bool,
) -> Result<bool, Error> {
    for variant in cache.in_the_way_first(runs.iter().map(VariantRun::variant).collect()) {
        let Some(run) = runs.iter().find(|run| run.variant() == variant) else {
            continue;
        };
        let question = Question {
            setup,
            scatter,
            variant,
            estimate: run.estimate(),
            trust_cache,
        };
        if !question.passes(cache.peaks_of(variant))? {
            cache.stands_in_the_way(variant);
            return Ok(false);
        }
    }
    Ok(true)
}

impl Question<'_> {
    /// Returns whether the variant passes by the rule, and notes in `cached` what members did.
    fn passes(&self, cached: &mut Vec<Option<f64>>) -> Result<bool, Error> {
        let members = self.setup.policy.members;
        let likely = likely(cached, self.setup.threshold_rad());
        let mut peaks: Vec<Option<f64>> = vec![None; members as usize];
        let mut looks = Vec::new();
        let mut answer = Answer::Undecided;
        for look in ensemble::looks(members) {
            let seen = cached.iter().take(look as usize).flatten().count();
            let all_seen = self.trust_cache && seen == look as usize;
            looks.push(look);
            match self.ask(look, &likely, all_seen, &mut peaks)? {
                LookEnd::NoPass => {}
                LookEnd::Trusted => answer = Answer::Pass,
                LookEnd::Complete => answer = self.first_answer(&looks, &peaks),
            }
            if answer != Answer::Undecided {
                break;
            }
        }
        cached.resize(cached.len().max(peaks.len()), None);
        for (cached, peak) in cached.iter_mut().zip(peaks) {
            *cached = peak.or(*cached);
        }
        Ok(answer == Answer::Pass)
    }

    /// Returns the answer of the first look that has one, every member of the last look being
    /// known: an earlier one that fails comes first.
    fn first_answer(&self, looks: &[u32], peaks: &[Option<f64>]) -> Answer {
        let threshold = self.setup.threshold_rad();
        looks
            .iter()
            .map(|look| {
                let known: Vec<f64> = peaks[..*look as usize].iter().flatten().copied().collect();
                let share = Count::of(&known, threshold).share();
                decide(&self.estimate, threshold, Some(share))
            })
            .find(|answer| *answer != Answer::Undecided)
            .unwrap_or(Answer::Undecided)
    }

    /// Runs members of a look until it is certain that it allows no pass, or all of them; or,
    /// where `all_seen` says that the others stayed below when they were last asked, until hardly
    /// any of those that are likely to exceed the threshold still does.
    fn ask(
        &self,
        look: u32,
        likely: &[u32],
        all_seen: bool,
        peaks: &mut [Option<f64>],
    ) -> Result<LookEnd, Error> {
        let threshold = self.setup.threshold_rad();
        let most = most_of_a_pass(look);
        // Where what was likely does not come true, one after the other is no worse.
        let worth_one_in = if all_seen { 32 } else { 4 };
        let mut likely = likely.iter().copied().filter(|member| *member < look);
        let mut worthwhile = true;
        let mut others: Option<std::vec::IntoIter<u32>> = None;
        loop {
            let count = exceeding(&peaks[..look as usize], threshold);
            if count > most {
                return Ok(LookEnd::NoPass);
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
                    return Ok(LookEnd::Trusted);
                }
                let taken = match others {
                    Some(_) => MEMBERS_IN_A_ROW,
                    None => (most + 1 - count).max(MEMBERS_TAKEN),
                };
                let others =
                    others.get_or_insert_with(|| self.loosest_first((0..look).filter(open)));
                wanted = others.by_ref().take(taken).collect();
            }
            if wanted.is_empty() {
                return Ok(LookEnd::Complete);
            }
            let found = self.peaks_of(&wanted)?;
            for (member, peak) in wanted.iter().zip(&found) {
                peaks[*member as usize] = Some(*peak);
            }
            if from_likely {
                let true_ones = found.iter().filter(|peak| exceeds(**peak, threshold));
                worthwhile &= worth_one_in * true_ones.count() >= found.len();
            }
        }
    }

    /// Returns the members in the order of how little holds them against the recording: that in which
    /// they are likely to open.
    fn loosest_first(&self, members: impl Iterator<Item = u32>) -> std::vec::IntoIter<u32> {
        let mut held: Vec<(f64, u32)> = members
            .map(|index| {
                let member = self.scatter.member(index);
                let unbalance = member.scale.abs() * member.lever.unbalance_kg_m();
                (member.lever.preload_torque_nm / unbalance, index)
            })
            .collect();
        held.sort_by(|a, b| a.0.total_cmp(&b.0));
        let order: Vec<u32> = held.into_iter().map(|(_, index)| index).collect();
        order.into_iter()
    }

    /// Returns the largest angles of the members named, coast included [rad], NaN where one could
    /// not be followed; no more than that it exceeds the threshold where it does, or stays well below.
    fn peaks_of(&self, members: &[u32]) -> Result<Vec<f64>, Error> {
        let threshold = self.setup.threshold_rad();
        let asked = AskedPeaks {
            from_rad: NEAR_PART * threshold,
            to_rad: threshold,
        };
        // A single task's members are shared among the threads, in whole vectors of the widest.
        let each = members.len().div_ceil(self.setup.control.threads.max(1));
        let taken = each.next_multiple_of(IN_A_VECTOR).min(MEMBERS_TAKEN);
        let tasks: Vec<&[u32]> = members.chunks(taken).collect();
        let found = self.setup.share(taken, &tasks, |task| {
            let member = |index: usize| self.scatter.member(task[index]);
            self.setup.peaks(self.variant, task.len(), &member, asked)
        })?;
        Ok(found.into_iter().flat_map(|of| of.highest_rad).collect())
    }
}

/// Returns the members that came near the threshold or went beyond, the furthest first.
fn likely(cached: &[Option<f64>], threshold: f64) -> Vec<u32> {
    let mut near: Vec<(u32, f64)> = (0..)
        .zip(cached)
        .filter_map(|(member, peak)| Some((member, (*peak)?)))
        .map(|(member, peak)| (member, if peak.is_nan() { f64::INFINITY } else { peak }))
        .filter(|(_, peak)| *peak > NEAR_PART * threshold)
        .collect();
    near.sort_by(|a, b| b.1.total_cmp(&a.1));
    near.into_iter().map(|(member, _)| member).collect()
}

/// Returns whether a member counts against a pass: it exceeds the threshold or was not followed.
fn exceeds(peak: f64, threshold: f64) -> bool {
    !peak.is_finite() || peak > threshold
}

fn exceeding(peaks: &[Option<f64>], threshold: f64) -> usize {
    let known = peaks.iter().flatten();
    known.filter(|peak| exceeds(**peak, threshold)).count()
}
