//! Settings that decide: a pass by the settings asked for is held against what the defaults say.

use super::prepared::Prepared;
use latchgate_document::request::Request;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::criterion::Criterion;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::replay::Method;
use latchgate_recording::Finding;
use latchgate_recording::error::Error;
use latchgate_recording::setting::Setting;
use latchgate_verdict::conditioning::{self, BiasWindow, Conditioned, FilterChoice};
use latchgate_verdict::{Answer, AssessDetail, AssessExtras, Assessment, Policy, Reason};

/// One departure from the defaults: how messages name it, and the way back.
struct Departure {
    name: String,
    undo: fn(&mut Request, &mut Design),
}

/// Lists what differs from the defaults and may decide.
fn departures(request: &Request, design: &Design) -> Vec<Departure> {
    let default = Request::default();
    // A limit below the default makes no pass of what is none.
    let raised = design.criterion.threshold_rad > design.default_threshold_rad();
    let mut found = Vec::new();
    let mut note = |differs: bool, name: String, undo: fn(&mut Request, &mut Design)| {
        if differs {
            found.push(Departure { name, undo });
        }
    };
    let of = |setting: Setting| setting.to_string();
    note(
        request.bias != default.bias,
        of(Setting::Bias),
        |request, _| {
            request.bias = BiasWindow::PreEvent;
        },
    );
    let filter = (request.filter, request.filter_standard);
    let differs = filter != (default.filter, default.filter_standard);
    note(differs, of(Setting::Filter), |request, _| {
        request.filter = FilterChoice::Default;
        request.filter_standard = Request::default().filter_standard;
    });
    note(
        request.between != default.between,
        of(Setting::Between),
        |request, _| {
            request.between = Request::default().between;
        },
    );
    note(
        request.resample_hz.is_some(),
        of(Setting::Resample),
        |request, _| {
            request.resample_hz = None;
        },
    );
    note(
        request.window_s.is_some(),
        of(Setting::Window),
        |request, _| {
            request.window_s = None;
        },
    );
    let method = (request.method, request.tolerance_rad);
    let differs = method != (default.method, default.tolerance_rad);
    note(differs, of(Setting::Method), |request, _| {
        request.method = Method::EventDriven;
        request.tolerance_rad = None;
    });
    note(
        raised,
        "the design's `criterion.threshold_rad`".into(),
        |_, design| {
            design.criterion.threshold_rad = design.default_threshold_rad();
            design.criterion.raised_from_rad = None;
        },
    );
    let usual = Criterion::default();
    let looser = design.criterion.open_share > usual.open_share;
    note(
        looser || design.criterion.confidence < usual.confidence,
        "the design's `criterion.open_share` and `criterion.confidence`".into(),
        |_, design| {
            let (own, usual) = (&mut design.criterion, Criterion::default());
            own.open_share = own.open_share.min(usual.open_share);
            own.confidence = own.confidence.max(usual.confidence);
        },
    );
    found
}

impl Prepared {
    /// Holds a pass against what would be said without a doubtful bias, and by the defaults.
    pub(super) fn hold_against_defaults(
        &self,
        design: &Design,
        assessment: &mut Assessment,
        control: &Control<'_>,
    ) -> Result<(), Error> {
        // Only a pass lets a design through, so only a pass may not hang on a choice.
        if assessment.answer != Answer::Pass {
            return Ok(());
        }
        let request = &self.facts.request;
        if let Some(biased) = conditioning::without_doubtful_bias(&self.conditioned)? {
            let policy = request.policy(self.facts.polarity);
            let answer = self.answer_on(&biased, &policy, design, control)?;
            if answer != Answer::Pass {
                assessment.answer = Answer::Undecided;
                assessment.why.insert(0, bias_decides(answer));
                return Ok(());
            }
        }
        let departures = departures(request, design);
        let by = |undone: &[&Departure]| {
            let (mut request, mut design) = (request.clone(), design.clone());
            for departure in undone {
                (departure.undo)(&mut request, &mut design);
            }
            self.answer_by(&request, &design, control)
        };
        let all: Vec<&Departure> = departures.iter().collect();
        if all.is_empty() {
            return Ok(());
        }
        let answer = by(&all)?;
        if answer == Answer::Pass {
            return Ok(());
        }
        // Named is what turns the answer alone, or else all, which do it together; of a single
        // departure that is known already.
        let mut alone = Vec::new();
        for departure in &departures {
            if departures.len() == 1 || by(&[departure])? != Answer::Pass {
                alone.push(departure);
            }
        }
        let named = if alone.is_empty() { all } else { alone };
        let names: Vec<&str> = named.iter().map(|of| of.name.as_str()).collect();
        let text = format!(
            "By {} the answer is pass, by the defaults it is {}. Judge by the defaults, or state \
             in the report why the setting is right.",
            names.join(" and "),
            answer.name()
        );
        assessment.why.insert(
            0,
            Reason {
                code: "setting-decides".into(),
                text: text.clone(),
            },
        );
        // The settings were asked for: the answer stays, and says what it hangs on.
        let finding = Finding::warning("setting-decides", text);
        assessment.findings.insert(0, finding);
        Ok(())
    }

    /// Returns the answer to another question to the same samples; unusable where there is none.
    fn answer_by(
        &self,
        request: &Request,
        design: &Design,
        control: &Control<'_>,
    ) -> Result<Answer, Error> {
        let options = request.conditioning_options(&self.facts.card);
        let policy = request.policy(self.facts.polarity);
        let answer = conditioning::reconditioned(&self.conditioned, &options)
            .and_then(|conditioned| self.answer_on(&conditioned, &policy, design, control));
        match answer {
            Err(error) if error.is_stopped() => Err(error),
            answer => Ok(answer.unwrap_or(Answer::Unusable)),
        }
    }

    fn answer_on(
        &self,
        conditioned: &Conditioned,
        policy: &Policy,
        design: &Design,
        control: &Control<'_>,
    ) -> Result<Answer, Error> {
        let extras = AssessExtras {
            detail: AssessDetail::Decision,
            ..AssessExtras::default()
        };
        let findings = &self.facts.findings;
        control
            .unmeasured(|control| {
                latchgate_verdict::assess(conditioned, findings, design, policy, extras, control)
            })
            .map(|assessment| assessment.answer)
    }
}

fn bias_decides(answer: Answer) -> Reason {
    Reason {
        code: "bias-decides".into(),
        text: format!(
            "Without the doubtful bias the answer is {}. A pass must hold with and without it. \
             Name a quiet window before contact with the setting `bias` = START..END.",
            answer.name()
        ),
    }
}
