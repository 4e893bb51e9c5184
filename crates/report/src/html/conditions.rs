//! The conditions of the decision rule: what it asks of each stop and opening direction, and what was found.

use super::markup::stop_and_sign;
use crate::angle::bound;
use crate::escape::terminal as line;
use crate::words;
use latchgate_document::Document;
use latchgate_document::number::{ABSENT, count, trimmed};
use latchgate_document::request::PolaritySource;
use latchgate_kernel::replay::Run;
use latchgate_verdict::decision::{
    FAIL_SHARE_MIN, FAIL_SHARE_WITH_NOMINAL, OPENING_DRAWS_MAX, PASS_DRAWS,
};
use latchgate_verdict::ensemble::Ensemble;
use latchgate_verdict::wording::{percent, percent_bound};
use latchgate_verdict::{Answer, RunAnswer};
use maud::{Markup, html};
use std::f64::consts::FRAC_PI_2;

/// A condition: what it is of, what it asks, and what each run shows.
struct Condition {
    what: String,
    asked: String,
    found: Vec<Found>,
}

/// What a run shows, and whether it meets the condition.
struct Found {
    text: String,
    is_met: bool,
}

impl Found {
    fn absent() -> Self {
        Self {
            text: ABSENT.into(),
            is_met: true,
        }
    }
}

/// A run with its answer and its ensemble.
struct Judged<'a> {
    run: &'a Run,
    answer: &'a RunAnswer,
    ensemble: Option<&'a Ensemble>,
}

/// Returns the conditions of a pass, of a fail those of a fail, with what each stop and opening direction shows.
pub(super) fn conditions(document: &Document) -> Markup {
    let judged: Vec<Judged<'_>> = judged(document);
    if judged.is_empty() {
        return html! {};
    }
    let fails = document.verdict == Answer::Fail;
    let rows = match fails {
        true => of_a_fail(document, &judged),
        false => of_a_pass(document, &judged),
    };
    let several = document.polarities.len() > 1;
    html! {
        section #conditions tabindex="0" {
            h2 { "Conditions of the rule" }
            table {
                thead {
                    tr {
                        th scope="col" { "Condition" }
                        th scope="col" { @if fails { "A fail asks" } @else { "A pass asks" } }
                        @for one in &judged {
                            th scope="col" {
                                @if several { (stop_and_sign(one.run.model, one.run.opens_when)) }
                                @else { (words::capital(one.run.model.label())) }
                            }
                        }
                    }
                }
                tbody {
                    @for row in &rows {
                        tr {
                            th { (line(&row.what)) }
                            td { (line(&row.asked)) }
                            @for found in &row.found { td.above[!found.is_met] { (line(&found.text)) } }
                        }
                    }
                    tr.nominal {
                        th { "Answer" }
                        td { @if document.polarities.len() > 1 || judged.len() > 1 { (together(document)) } }
                        @for one in &judged { td { (one.answer.answer.name()) } }
                    }
                }
            }
            @for text in lost(document, &judged) { p.note { (line(&text)) "." } }
        }
    }
}

/// Says of which stops members could not be followed or rounding has lost the runs, and how they count.
fn lost(document: &Document, judged: &[Judged<'_>]) -> Vec<String> {
    let answer = match document.verdict {
        Answer::Fail => Answer::Fail,
        _ => Answer::Pass,
    };
    let of_each = judged.iter().filter_map(|one| {
        let ensemble = one.ensemble?;
        let not_followed = ensemble.lost_in_words(answer).map(|lost| {
            let place = words::capital(ensemble.model.label());
            format!("{place}: {lost}")
        });
        let error_rad = one.run.numerical_error_rad;
        let rounded = ensemble.rounding_in_words(error_rad, document.threshold_rad);
        Some(not_followed.into_iter().chain(rounded))
    });
    of_each.flatten().collect()
}

fn judged(document: &Document) -> Vec<Judged<'_>> {
    let runs = words::judged_runs(document).into_iter();
    let judged = runs.filter_map(|run| {
        let ensembles = words::ensembles(document).iter();
        let mut own =
            ensembles.filter(|one| (one.model, one.opens_when) == (run.model, run.opens_when));
        Some(Judged {
            run,
            answer: document.answer_of(run)?,
            ensemble: own.next(),
        })
    });
    judged.collect()
}

/// Returns what joins the answers.
fn together(document: &Document) -> &'static str {
    let is_declared = document.recording.opens_when_source != PolaritySource::Undeclared;
    if is_declared && document.polarities.len() > 1 {
        "the worse direction counts"
    } else {
        "all alike, else undecided"
    }
}

fn degrees(radians: f64) -> String {
    if radians > FRAC_PI_2 {
        return "> 90°".into();
    }
    format!("{}°", trimmed(radians.to_degrees(), 3))
}

fn of_a_pass(document: &Document, judged: &[Judged<'_>]) -> Vec<Condition> {
    let limit_rad = document.threshold_rad;
    let at_most = format!("at most {}", degrees(limit_rad));
    let most = |angle_rad: f64, error_rad: Option<f64>| match error_rad {
        Some(error_rad) => Found {
            text: match angle_rad + error_rad {
                most if most > FRAC_PI_2 => "> 90°".into(),
                most => format!("{}°", bound(most.to_degrees())),
            },
            is_met: angle_rad + error_rad <= limit_rad,
        },
        None => Found {
            text: "not known".into(),
            is_met: false,
        },
    };
    let mut rows = vec![Condition {
        what: "Largest angle plus U".into(),
        asked: at_most.clone(),
        found: each(judged, |one| {
            most(one.run.peak_angle_rad, one.answer.uncertainty_rad)
        }),
    }];
    if judged
        .iter()
        .any(|one| one.run.coast_peak_angle_rad.is_some())
    {
        rows.push(Condition {
            what: "Coast after the record plus its U".into(),
            asked: at_most,
            found: each(judged, |one| match one.run.coast_peak_angle_rad {
                Some(coast) => most(coast, one.answer.coast_uncertainty_rad),
                None => Found::absent(),
            }),
        });
    }
    rows.push(Condition {
        what: "Draws of the noise that open".into(),
        asked: format!("at most {OPENING_DRAWS_MAX} of {PASS_DRAWS}"),
        found: each(judged, |one| match one.answer.opening_draws {
            Some(draws) => Found {
                text: draws.to_string(),
                is_met: draws <= OPENING_DRAWS_MAX,
            },
            None => Found {
                text: "not drawn".into(),
                is_met: true,
            },
        }),
    });
    let allowed = percent(document.design.criterion.open_share);
    rows.extend(share(
        document,
        judged,
        format!("at most {allowed} %"),
        |one| {
            let most = percent_bound(one.p_upper_with_coast, f64::ceil);
            let coasting = match one.exceeded_in_coast {
                0 => String::new(),
                more => format!(" and {} coasting", count(u64::from(more))),
            };
            Found {
                text: format!("{}{coasting}: up to {most} %", counted(one)),
                is_met: one.p_upper_with_coast <= one.open_share,
            }
        },
    ));
    rows
}

fn of_a_fail(document: &Document, judged: &[Judged<'_>]) -> Vec<Condition> {
    let limit_rad = document.threshold_rad;
    let opens = |one: &Judged<'_>| {
        let error_rad = one.answer.uncertainty_rad;
        error_rad.is_some_and(|error_rad| one.run.peak_angle_rad - error_rad > limit_rad)
    };
    let mut rows = vec![Condition {
        what: "Largest angle less U".into(),
        asked: format!("above {}", degrees(limit_rad)),
        found: each(judged, |one| Found {
            text: match one.answer.uncertainty_rad {
                Some(error_rad) if opens(one) || words::has_figure(document, one.run) => {
                    degrees(one.run.peak_angle_rad - error_rad)
                }
                // An error as large as the angle leaves no figure of it.
                _ => "not known".into(),
            },
            is_met: opens(one),
        }),
    }];
    let (nearly_all, most) = (percent(FAIL_SHARE_MIN), percent(FAIL_SHARE_WITH_NOMINAL));
    let asked = format!("{nearly_all} %; above {most} % if the line above is met");
    rows.extend(share(document, judged, asked, |one| {
        let least = percent_bound(one.p_lower, f64::floor);
        let nominal_opens = judged.iter().any(|judged| {
            (judged.run.model, judged.run.opens_when) == (one.model, one.opens_when)
                && opens(judged)
        });
        Found {
            text: format!("{}: at least {least} %", counted(one)),
            is_met: one.p_lower >= FAIL_SHARE_MIN
                || (nominal_opens && one.p_lower > FAIL_SHARE_WITH_NOMINAL),
        }
    }));
    rows
}

fn each(judged: &[Judged<'_>], found: impl Fn(&Judged<'_>) -> Found) -> Vec<Found> {
    judged.iter().map(found).collect()
}

/// Returns the condition on the share of levers and readings; none where nominal runs alone are judged.
fn share(
    document: &Document,
    judged: &[Judged<'_>],
    asked: String,
    found: impl Fn(&Ensemble) -> Found,
) -> Option<Condition> {
    let varied = words::ensembles(document)
        .first()
        .map(|one| one.varied.members());
    let is_spared = judged.iter().any(|one| one.answer.bound.is_some());
    (varied.is_some() || is_spared).then(|| Condition {
        what: format!(
            "{} that open",
            words::capital(varied.unwrap_or("varied levers"))
        ),
        asked,
        found: each(judged, |one| match (one.ensemble, one.answer.bound) {
            (Some(ensemble), _) => found(ensemble),
            (None, Some(bound)) => Found {
                text: format!("none can: {}", bound.name()),
                // Where none opens a pass has what it asks, and a fail has not.
                is_met: document.verdict != Answer::Fail,
            },
            (None, None) => Found::absent(),
        }),
    })
}

/// Returns how many members open, and how many could not be followed.
fn counted(ensemble: &Ensemble) -> String {
    let of = format!(
        "{} of {}",
        count(u64::from(ensemble.exceeded)),
        count(u64::from(ensemble.members))
    );
    match ensemble.failed_to_run {
        0 => of,
        lost => format!("{of}, {} not followed", count(u64::from(lost))),
    }
}
