//! Static thresholds, with a replay of the sled pulse beside them.

use super::prepared::Extras;
use super::{Answer, Control, Design, Limits, Request, answer, judge, pulse};
use latchgate_document::design_file::StaticDesign;
use latchgate_document::static_document::{SledBeside, StaticDocument};
use latchgate_kernel::error::Error as KernelError;
use latchgate_kernel::model::linkage::parting;
use latchgate_recording::error::Error;
use latchgate_verdict::statics::StaticQuestion;
use std::path::Path;

/// The pulse of the sled test.
const SLED: &str = "pulse:sled206-33g";

/// Answers the standards for a design, and replays the sled pulse beside it where the design is whole.
///
/// # Examples
///
/// ```
/// use latchgate::pipeline::{Control, Limits, static_design, static_document};
///
/// let file = b"base = \"paper\"\n[lever]\npreload_torque_nm = 5\n[tolerance]\npreload_torque_nm = 0\n";
/// let design = static_design("strong.toml", file, &[], &Limits::default())?;
/// let question = Default::default();
/// let document = static_document(design, &question, None, &Control::unwatched(1))?;
/// assert_eq!(document.answers[0].holds, Some(true));
/// assert!(document.sled.is_some());
/// # Ok::<(), latchgate::pipeline::Error>(())
/// ```
///
/// # Errors
///
/// [`Stopped`](latchgate_kernel::error::Error::Stopped) if `control` ends the work.
pub fn static_document(
    design: StaticDesign,
    question: &StaticQuestion,
    design_sha256: Option<String>,
    control: &Control<'_>,
) -> Result<StaticDocument, Error> {
    let whole = design.whole.as_ref();
    let sled = whole.map(|whole| sled_beside(whole, control)).transpose()?;
    Ok(StaticDocument::of(
        (&design.lever, design.document),
        question,
        sled.flatten(),
        design_sha256,
        answer::run_block(),
    ))
}

/// Replays the sled pulse along the direction that opens the lever; `None` where there is no verdict.
fn sled_beside(design: &Design, control: &Control<'_>) -> Result<Option<SledBeside>, Error> {
    let may_part = !parting(&design.linkage).is_empty();
    let mut design = design.clone();
    // As a lever without a stated direction the pulse has it along its way.
    design.lever.axis = None;
    design.lever.center_of_mass = None;
    design.linkage.clear();
    // The static load is that of the lever alone.
    design.catch = None;
    let outcome = judge(
        &pulse::source_at(Path::new(&format!("{SLED},opens-when=positive")))?,
        &Request::default(),
        &design,
        Extras::default(),
        &Limits::default(),
        control,
    );
    if outcome.was_stopped() {
        return Err(KernelError::Stopped.into());
    }
    let (mut verdict, mut headline) = (
        outcome.document.verdict,
        latchgate_report::headline(&outcome.document),
    );
    if may_part && verdict == Answer::Pass {
        verdict = Answer::Undecided;
        headline = format!("Its elements may part, which no replay follows. Joined: {headline}");
    }
    Ok(outcome.refusal.is_none().then(|| SledBeside {
        pulse: SLED.into(),
        verdict,
        headline,
        may_part,
        report_id: outcome.document.report_id,
        static_holds: None,
        static_holds_nominally: false,
    }))
}
