//! What bounds in closed form prove of a variant and of its scattered levers.
//!
//! A variant is left out, its nominal run apart, only where bounds prove what the whole rule
//! would say of it; `docs/decision.md` has the argument.

use super::decision::{FAIL_SHARE_MIN, PASS_SHARE_MAX, ShareBounds, VariantRun};
use super::ensemble::{self, Scatter, bounds};
use super::policy::{AssessDetail, ModelChoice, Policy, Variant};
use super::runs::RunSetup;
use super::screen::{self, Decided, Subject};
use super::usable_span::{SampleSpan, UsableSpan};
use super::{Answer, ScreenedRun};
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::{Method, RunOutcome};
use latchgate_recording::error::Error;

/// Scattered levers of which bounds prove an answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ProvenMembers {
    /// Stay below the threshold.
    pub(super) below: u32,
    /// Cross it.
    pub(super) crossing: u32,
    /// Were asked about.
    pub(super) of: u32,
}

impl ProvenMembers {
    /// Bounds of the share that crosses, as those of the first look, which are no wider.
    fn share(self) -> ShareBounds {
        let (confidence, of) = (bounds::LOOK_CONFIDENCE, u64::from(self.of));
        let not_below = u64::from(self.of.saturating_sub(self.below));
        let upper = bounds::upper(not_below, of, confidence);
        ShareBounds {
            lower: bounds::lower(u64::from(self.crossing), of, confidence),
            upper,
            // What stays below by the bounds does so in the coast as well.
            upper_with_coast: upper,
        }
    }
}

/// The proof that bounds give of one variant.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Proof {
    /// An interpolation error that is not exceeded [rad].
    pub(super) interpolation_at_most_rad: Option<f64>,
    /// The scattered levers; `None` where no bound was asked or too few are proven.
    pub(super) members: Option<ProvenMembers>,
}

impl Proof {
    /// Asks the bounds about one variant, of which `screened` is what they say of the nominal
    /// lever on the samples.
    ///
    /// A pass needs the error of the nominal peak, so that without it no member is asked about; a
    /// fail by nearly all members does not.
    pub(super) fn of(
        setup: &RunSetup<'_>,
        scatter: Option<&Scatter>,
        variant: Variant,
        outcome: &RunOutcome,
        screened: Option<Decided>,
    ) -> Result<Self, Error> {
        setup.control.check()?;
        // What is not proven of the samples is hardly ever proven of all their readings; where no bound
        // is asked, the error is measured.
        let interpolation_at_most_rad = (screened == Some(Decided::Pass))
            .then(|| setup.change_at_most(outcome))
            .flatten();
        let of_use = |wanted| wanted == Decided::Fail || interpolation_at_most_rad.is_some();
        let members = match (scatter, screened) {
            (Some(scatter), Some(wanted)) if of_use(wanted) => {
                members(setup, scatter, variant, wanted)
            }
            _ => None,
        };
        Ok(Self {
            interpolation_at_most_rad,
            members,
        })
    }

    /// Returns the run with what is proven in place of what would be measured.
    ///
    /// Every condition of the rule for a pass or a fail gets easier with a smaller error and with
    /// bounds of the share that lie closer together: what the rule says of this it also says of
    /// the run that was followed to the first look.
    fn stand_in(&self, outcome: &RunOutcome) -> VariantRun {
        VariantRun {
            outcome: outcome.clone(),
            interpolation_error_rad: self.interpolation_at_most_rad.unwrap_or(f64::MAX),
            share: self.members.map(ProvenMembers::share),
            left_out: true,
        }
    }

    /// Returns the run with its answer proven, by the rule with an ensemble if it has `members`;
    /// `None` if it is not.
    pub(super) fn proven(
        &self,
        outcome: &RunOutcome,
        threshold_rad: f64,
        members: u32,
    ) -> Option<VariantRun> {
        if members > 0 && self.members.is_none() {
            return None;
        }
        let stand_in = self.stand_in(outcome);
        (stand_in.answer(threshold_rad) != Answer::Undecided).then_some(stand_in)
    }
}

/// Returns whether a variant may be left out at all; otherwise why not.
pub(super) fn may_leave_out(
    policy: &Policy,
    follow_all: bool,
    span: UsableSpan,
) -> Result<(), &'static str> {
    if policy.model != ModelChoice::Auto {
        Err("the stop model is given")
    } else if follow_all {
        Err("every stop was to be followed in full")
    } else if policy.method != Method::EventDriven {
        Err("a method for comparison was asked for")
    } else if policy.initial_angle_rad.is_some() || policy.initial_velocity_rad_s.is_some() {
        Err("an initial state is given")
    } else if span != UsableSpan::Whole {
        Err("a blocking finding ends the samples that count")
    } else {
        Ok(())
    }
}

/// Returns for each nominal run what stands in for its fourfold by the rule without an ensemble,
/// where bounds prove what it says.
pub(super) fn nominal_stand_ins(
    setup: &RunSetup<'_>,
    span: UsableSpan,
    variants: &[Variant],
    outcomes: &[RunOutcome],
) -> Result<Vec<Option<VariantRun>>, Error> {
    if may_leave_out(setup.policy, setup.follow_all, span).is_err() {
        return Ok(vec![None; outcomes.len()]);
    }
    let of_each = variants.iter().zip(outcomes);
    of_each
        .map(|(variant, outcome)| {
            let proof = Proof::of(setup, None, *variant, outcome, decided(setup, *variant))?;
            Ok(proof.proven(outcome, setup.threshold_rad(), 0))
        })
        .collect()
}

/// Returns what each bound says of one variant.
pub(super) fn screened(setup: &RunSetup<'_>, variant: Variant) -> ScreenedRun {
    let Variant { opens_when, model } = variant;
    let (subject, seen) = (subject_of(setup, model), setup.readings.seen(opens_when));
    let screened = if setup.detail < AssessDetail::Whole {
        screen::screen_briefly(&subject, &seen)
    } else {
        screen::screen(&subject, &seen)
    };
    ScreenedRun {
        model,
        opens_when,
        answer: screened.answer,
        by: screened.by,
        peak_at_most_rad: screened.peak_at_most_rad,
        bounds: screened.bounds,
    }
}

/// Returns what bounds prove of one variant.
pub(super) fn decided(
    setup: &RunSetup<'_>,
    Variant { opens_when, model }: Variant,
) -> Option<Decided> {
    screen::decide(&subject_of(setup, model), &setup.readings.seen(opens_when))
}

fn subject_of(setup: &RunSetup<'_>, model: StopModel) -> Subject {
    Subject {
        initial: setup.initial(model),
        ..subject(setup, model, setup.window)
    }
}

fn subject(setup: &RunSetup<'_>, model: StopModel, window: Option<SampleSpan>) -> Subject {
    Subject {
        lever: setup.design.lever,
        stop: setup.design.stop,
        model,
        threshold_rad: setup.threshold_rad(),
        initial: None,
        window,
    }
}

/// Asks the bounds about the members of the first look, until it is clear that `wanted` cannot
/// be proven of enough of them.
fn members(
    setup: &RunSetup<'_>,
    scatter: &Scatter,
    Variant { opens_when, model }: Variant,
    wanted: Decided,
) -> Option<ProvenMembers> {
    let of = *ensemble::looks(setup.policy.members).first()?;
    let seen = setup.readings.seen(opens_when);
    let nominal = subject(setup, model, setup.window);
    let (mut below, mut crossing) = (0, 0);
    for index in 0..of {
        let member = scatter.member(index);
        let own = Subject {
            lever: member.lever,
            stop: member.stop,
            ..nominal
        };
        let decided = screen::decide(&own, &seen.changed(member.scale, member.bias_m_s2));
        match decided {
            Some(Decided::Pass) => below += 1,
            Some(Decided::Fail) => crossing += 1,
            None => {}
        }
        if decided == Some(wanted) {
            continue;
        }
        // The best that the members still to come can make of it.
        let best = ProvenMembers {
            below: of - (index + 1 - below),
            crossing: of - (index + 1 - crossing),
            of,
        }
        .share();
        let hopeless = match wanted {
            Decided::Pass => best.upper > PASS_SHARE_MAX,
            Decided::Fail => best.lower < FAIL_SHARE_MIN,
        };
        if hopeless {
            return None;
        }
    }
    Some(ProvenMembers {
        below,
        crossing,
        of,
    })
}
