//! The ensembles of all variants, look by look, until the rule decides or what is still open can
//! no longer change the answer.

use super::Answer;
use super::decision::{ShareBounds, VariantRun, awaits_nothing, decide, settled};
use super::ensemble::{self, End, MemberPeaks, Scatter};
use super::policy::{AssessDetail, Variant};
use super::runs::RunSetup;
use super::variant::{Crossings, VariantResult};
use latchgate_kernel::parallel::Control;
use latchgate_kernel::replay::Breakdown;
use latchgate_kernel::replay::batch::AskedPeaks;
use latchgate_recording::error::Error;

/// Members that a thread takes at a time.
pub(super) const MEMBERS_TAKEN: usize = 64;

/// The ensemble of one variant on its way.
#[derive(Clone)]
struct Sampling {
    peaks: MemberPeaks,
    /// Looks that it took part in.
    looks: usize,
    answer: Option<Answer>,
    ended: End,
    /// Steps that its members took.
    spent: u64,
}

/// Returns the steps that the members up to `look`, the next count at which an ensemble is judged, may take: as
/// those before them, or half of what the nominal run took each, since several advance side by side. A nominal
/// lever that took too much has members that do.
fn predicted(run: &VariantRun, sampling: &Sampling, look: u32) -> u64 {
    let followed = sampling.peaks.window_rad.len() as u64;
    let missing = u64::from(look).saturating_sub(followed);
    match followed {
        0 if matches!(
            run.outcome.breakdown,
            Some(Breakdown::TooManySteps | Breakdown::StopTooDamped)
        ) =>
        {
            u64::MAX
        }
        0 => missing.saturating_mul(run.outcome.spent / 2),
        _ => missing.saturating_mul(sampling.spent / followed),
    }
}

/// Runs the ensemble of every variant that was not left out and notes it in `results`, with the
/// share that crosses; `setup` has the samples that count as its window. `limited`: a fault ends
/// those samples.
pub(super) fn run_ensembles(
    setup: &RunSetup<'_>,
    scatter: &Scatter,
    results: &mut [VariantResult],
    limited: bool,
) -> Result<(), Error> {
    let criterion = &setup.design.criterion;
    let threshold = setup.threshold_rad();
    // The largest nominal peak comes first: its ensemble is the one that is shown.
    let mut order: Vec<usize> = (0..results.len()).collect();
    order.sort_by(|a, b| {
        let peak = |index: &usize| results[*index].counted().run().peak_angle_rad;
        peak(b).total_cmp(&peak(a))
    });
    let mut samplings: Vec<Sampling> = results
        .iter()
        .map(|result| Sampling {
            peaks: MemberPeaks::default(),
            looks: 0,
            answer: (result.counted().bound).map(|_| result.counted().answer(threshold)),
            ended: End::NoMatter,
            spent: 0,
        })
        .collect();
    let requested_peaks = asked_peaks(setup, results);
    let open = samplings.iter().filter(|of| of.answer.is_none()).count();
    let members = open as f64 * f64::from(setup.policy.members);
    for (number, look) in (1..).zip(ensemble::looks(setup.policy.members)) {
        for &index in &order {
            let variants = results.iter().map(VariantResult::counted);
            let answers = samplings.iter().map(|of| of.answer);
            let settled = samplings[index].looks > 0
                && settled(setup.policy.polarity, variants.zip(answers), threshold);
            if samplings[index].answer.is_some() || settled {
                continue;
            }
            let run = results[index].counted();
            // The limit is held against a look before it begins: a share counts all of its members.
            if !setup.work.allows(predicted(run, &samplings[index], look)) {
                results[index].counted_mut().share = Some(ShareBounds::UNKNOWN);
                let sampling = &mut samplings[index];
                (sampling.answer, sampling.ended) = (Some(Answer::Undecided), End::WorkLimit);
                continue;
            }
            let done: usize = samplings.iter().map(|of| of.peaks.window_rad.len()).sum();
            let sampling = &mut samplings[index];
            let missing = look as usize - sampling.peaks.window_rad.len();
            let before = setup.work.spent() - sampling.spent;
            let (from, to) = (done as f64 / members, (done + missing) as f64 / members);
            setup.control.during(from, to, |control| {
                let variant = results[index].variant;
                let peaks = (&mut sampling.peaks, requested_peaks);
                extend(setup, control, scatter, variant, look, peaks)
            })?;
            sampling.spent = setup.work.spent() - before;
            sampling.looks = number;
            let run = results[index].counted_mut();
            let count = sampling.peaks.count(threshold);
            let share = count.share(criterion);
            run.share = Some(share);
            let answer = run.answer(threshold);
            let awaits_nothing = awaits_nothing(&run.estimate(), threshold, share);
            if answer != Answer::Undecided {
                (sampling.answer, sampling.ended) = (Some(answer), End::Decided);
            } else if look < setup.policy.members && awaits_nothing {
                let sampling = &mut samplings[index];
                (sampling.answer, sampling.ended) = (Some(answer), End::NoPass);
            } else if look == setup.policy.members {
                let sampling = &mut samplings[index];
                (sampling.answer, sampling.ended) = (Some(answer), End::LastLook);
            }
        }
    }
    let last = setup.window.filter(|_| limited).map(|(_, last)| last);
    let until_s = last.map(|last| setup.signal.time_s(last));
    for (result, of) in results.iter_mut().zip(samplings) {
        let end = (of.looks, of.ended);
        result.ensemble = (of.looks > 0).then(|| {
            let mut summed =
                ensemble::summarise(scatter, &of.peaks, threshold, result.variant, end, until_s);
            if setup.detail == AssessDetail::Whole {
                let estimate = result.counted().estimate();
                summed.spread(scatter, &of.peaks, threshold, |share| {
                    decide(&estimate, threshold, Some(share))
                });
            }
            summed
        });
        result.crossings = Crossings(of.peaks.crossings_s);
    }
    Ok(())
}

/// Returns what is asked of the members: on which side of the threshold they stay, where nothing
/// is told but the decision and the members are far from the limit of work, which they would
/// come to later that way.
fn asked_peaks(setup: &RunSetup<'_>, results: &[VariantResult]) -> AskedPeaks {
    /// Times what a nominal run takes that a member may.
    const TIMES: u64 = 8;
    let samples = setup.signal.samples.len() as u64;
    let of_run = |result: &VariantResult| result.counted().outcome.spent + samples;
    let each: u64 = results.iter().map(of_run).sum();
    let allowed_each = TIMES * u64::from(setup.policy.members);
    if setup.detail < AssessDetail::Whole && each.saturating_mul(allowed_each) <= setup.work.left()
    {
        AskedPeaks {
            from_rad: setup.threshold_rad(),
            to_rad: setup.threshold_rad(),
        }
    } else {
        AskedPeaks::ALL
    }
}

/// Runs the members of one variant up to `look`, those that are in `peaks` not again.
fn extend(
    setup: &RunSetup<'_>,
    control: &Control<'_>,
    scatter: &Scatter,
    variant: Variant,
    look: u32,
    (peaks, requested_peaks): (&mut MemberPeaks, AskedPeaks),
) -> Result<(), Error> {
    let followed = u32::try_from(peaks.window_rad.len()).unwrap_or(look);
    let tasks: Vec<u32> = (followed..look).step_by(MEMBERS_TAKEN).collect();
    let chunks = setup.share_by(control, MEMBERS_TAKEN, &tasks, |&first| {
        let count = MEMBERS_TAKEN.min((look - first) as usize);
        let number = |index: usize| first.saturating_add(u32::try_from(index).unwrap_or(0));
        let member = |index: usize| scatter.lever(number(index));
        let mut peaks = setup.peaks(variant, count, &member, requested_peaks)?;
        for index in (0..count).filter(|index| !scatter.is_lever(number(*index))) {
            peaks.window_rad[index] = f64::INFINITY;
            peaks.highest_rad[index] = f64::INFINITY;
            peaks.crossings_s[index] = f64::NAN;
        }
        Ok(peaks)
    })?;
    for more in chunks {
        peaks.window_rad.extend(more.window_rad);
        peaks.highest_rad.extend(more.highest_rad);
        peaks.crossings_s.extend(more.crossings_s);
    }
    Ok(())
}

/// Returns when the first `count` members of a variant cross the threshold [s]; NaN of one that does not.
pub(super) fn crossings(
    setup: &RunSetup<'_>,
    scatter: &Scatter,
    variant: Variant,
    count: u32,
) -> Result<Vec<f64>, Error> {
    let mut peaks = MemberPeaks::default();
    setup.control.unmeasured(|control| {
        let peaks = (&mut peaks, AskedPeaks::ALL);
        extend(setup, control, scatter, variant, count, peaks)
    })?;
    Ok(peaks.crossings_s)
}
