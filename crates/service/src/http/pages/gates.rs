//! Gates: the list with its form, the matrix with what changed first, and a pair of it.

use super::{fields, layout, show};
use crate::app::App;
use crate::auth::Visitor;
use crate::gate::{question, read};
use crate::http::gates::{GateEntry, GatePart, find, listed};
use crate::problem::{Placed, Problem, Queried};
use crate::store::{GateStanding, RecordingFilter};
use axum::extract::{Extension, State};
use axum::response::{IntoResponse, Redirect, Response};
use latchgate::document::number;
use latchgate::gate::summary::Changes;
use latchgate::gate::{GateSummary, PairStanding, pairs::Pair};
use latchgate::report::escape::terminal as line;
use maud::{Markup, html};
use serde_json::json;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::FRAC_PI_2;

/// Pairs up to which the whole matrix is shown; beyond, what changed and what is not as required.
const CELLS: usize = 5000;

/// Pairs that are listed above the matrix.
const LISTED: usize = 200;

/// What changed of a pair, by the names of recording and design.
type Marks<'a> = BTreeMap<(&'a str, &'a str), &'static str>;

/// Shows the gates and the form that submits one.
pub(super) async fn list(
    State(app): State<App>,
    Extension(visitor): Extension<Visitor>,
    Queried(part): Queried<GatePart>,
) -> Result<Markup, Problem> {
    let gates = listed(&app, part).await?;
    let draft = draft(&app).await?;
    let body = html! {
        h1 { "Gates" }
        p { "A gate tests every recording of a list against every design of another. It passes if each pair is as required." }
        @if gates.gates.is_empty() { p { "None yet." } } @else {
            div.wide tabindex="0" role="region" aria-label="Gates" {
                table.rows {
                    thead { tr {
                        th scope="col" { "Gate" } th scope="col" { "Outcome" } th scope="col" { "Pairs" }
                        th scope="col" { "Not as required" } th scope="col" { "Compared with" } th scope="col" { "Date (UTC)" }
                    } }
                    tbody { @for gate in &gates.gates { tr {
                        td data-label="Gate" { a href=(format!("/gates/{}", gate.id)) { (line(&gate.name)) " " code { (short(&gate.id)) } } }
                        td data-label="Outcome" { (outcome(gate)) }
                        td.number data-label="Pairs" { (gate.pairs) }
                        td.number data-label="Not as required" { @match gate.not_as_required { Some(count) => (count), None => "–" } }
                        td data-label="Compared with" { @match &gate.baseline { Some(id) => a href=(format!("/gates/{id}")) { code { (short(id)) } }, None => "–" } }
                        td.number data-label="Date (UTC)" { (show::instant(gate.created_ms)) }
                    } } }
                }
            }
        }
        (show::damaged(gates.damaged))
        @if let Some(next) = gates.next { p { a href=(format!("/gates?cursor={next}")) { "Older" } } }
        h2 { "A new gate" }
        form id="gate" novalidate {
            div.fields {
                label { "Name " input name="name" value="gate" maxlength="64" required; }
                label { "Compared with "
                    select name="baseline" {
                        option value="" { "nothing" }
                        @for gate in gates.gates.iter().filter(|gate| gate.exit_code.is_some()) {
                            option value=(gate.id) { (gate.name) " " (short(&gate.id)) }
                        }
                    }
                }
            }
            p { label { input type="checkbox" name="no_worse" value="true"; " Ignore failures that are no worse than there" } }
            p { label for="gate-text" { "The gate file of the command line; " code { "files" } " names stored recordings, " code { "file" } " a stored design." } }
            textarea id="gate-text" name="text" rows="14" spellcheck="false" { (draft) }
            p { button.primary { "Judge" } }
            p.error id="gate-told" role="alert" {}
        }
    };
    Ok(layout(Some(&visitor), "Gates", &body))
}

/// Writes a gate over what is stored, to begin with.
async fn draft(app: &App) -> Result<String, Problem> {
    let newest = RecordingFilter {
        limit: 20,
        ..RecordingFilter::default()
    };
    let (recordings, designs) = app
        .on_disk(move |parts| {
            Ok((
                parts.ledger.recordings(&newest)?,
                parts.ledger.designs(0, 200)?,
            ))
        })
        .await?;
    let names: BTreeSet<String> = recordings
        .entries
        .into_iter()
        .map(|recording| json!(recording.name).to_string())
        .collect();
    let names: Vec<String> = names.into_iter().collect();
    let designs = designs.entries.into_iter();
    let designs: BTreeSet<String> = designs.map(|design| design.name).collect();
    let mut text = format!(
        "require = \"pass\"\n\n[[recordings]]\nfiles = [{}]\n\n[[designs]]\nname = \"paper\"\n",
        names.join(", ")
    );
    for design in designs {
        text += &format!("\n[[designs]]\nfile = {}\n", json!(design));
    }
    Ok(text)
}

/// Words a reason for whoever writes the gate file.
fn in_the_file(text: &str) -> String {
    line(text).replace("the setting `", "the key `")
}

fn short(id: &str) -> &str {
    id.get(..8).unwrap_or(id)
}

fn outcome(gate: &GateEntry) -> Markup {
    html! {
        @match gate.exit_code {
            None => { (gate.decided) " of " (gate.pairs) " decided" }
            Some(_) if gate.problem.is_some() => span.verdict.unusable { span aria-hidden="true" { "∅" } " NOT JUDGED" },
            Some(0) => span.verdict.pass { span aria-hidden="true" { "✓" } " PASSED" }
            Some(code) => { span.verdict.fail { span aria-hidden="true" { "✗" } " NOT PASSED" } " (exit code " (code) ")" }
        }
    }
}

/// Shows a gate.
pub(super) async fn page(
    State(app): State<App>,
    Extension(visitor): Extension<Visitor>,
    Placed(id): Placed<String>,
) -> Result<Markup, Problem> {
    let standing = find(&app, &id).await?;
    let summary = summary(&app, &standing).await?;
    let names = |standing: &GateStanding| standing.gate.name.clone();
    let name = names(&standing);
    let entry = GateEntry::of(standing);
    let body = html! {
        h1 { "Gate “" (line(&name)) "” " code { (short(&id)) } }
        section.card.(if entry.exit_code == Some(0) { "pass" } else { "fail" }) aria-label="Outcome" {
            p.answer { (outcome(&entry)) }
            @if let Some(summary) = &summary { (counts(summary)) }
            @if let Some(problem) = &entry.problem { p { (problem["detail"].as_str().unwrap_or("")) } }
        }
        @if entry.exit_code.is_none() {
            div id="gate-running" data-events=(format!("/v1/gates/{id}/events")) {
                progress max=(entry.pairs) value=(entry.decided) aria-label="Decided pairs" {}
            }
        }
        @if let Some(summary) = &summary {
            @let marks = summary.baseline.as_ref().map(marks).unwrap_or_default();
            (changes(&id, summary, &marks, entry.baseline.as_deref()))
            (worst(&id, summary, &marks))
            @if summary.pairs.len() <= CELLS { (matrix(&id, summary, &marks)) }
            h2 { "Files" }
            ul { @for file in &entry.files { li { a href=(file) { (file.rsplit('/').next().unwrap_or("")) } } } }
        }
    };
    Ok(layout(Some(&visitor), &format!("Gate {name}"), &body))
}

async fn summary(app: &App, standing: &GateStanding) -> Result<Option<GateSummary>, Problem> {
    let Some(outcome) = &standing.outcome else {
        return Ok(None);
    };
    let Some(file) = outcome.files.get("summary.json").cloned() else {
        return Ok(None);
    };
    let bytes = app.on_disk(move |parts| read(&*parts.blobs, &file)).await?;
    let odd = |error: serde_json::Error| Problem::not_found(&format!("summary ({error})"));
    Ok(Some(serde_json::from_slice(&bytes).map_err(odd)?))
}

fn counts(summary: &GateSummary) -> Markup {
    let counts = &summary.counts;
    html! {
        ul { @for problem in &summary.problems { li { (problem.text) } } }
        dl {
            dt { "Pairs" } dd { (counts.pairs) ": " (show::count(summary.recordings.len(), "recording")) ", " (show::count(summary.designs.len(), "design")) }
            dt { "As required" } dd { (counts.as_required) }
            dt { "Not as required" } dd { (counts.not_as_required) }
            @if counts.allowed > 0 { dt { "Let through by an exception" } dd { (counts.allowed) } }
            @if counts.no_worse > 0 { dt { "No worse than the baseline" } dd { (counts.no_worse) } }
            dt { "Answers" } dd { (counts.pass) " pass, " (counts.fail) " fail, " (counts.undecided) " undecided, " (counts.unusable) " unusable" }
        }
    }
}

fn marks(changes: &Changes) -> Marks<'_> {
    let mut marks = Marks::new();
    for (list, word) in [
        (&changes.added, "new"),
        (&changes.fixed, "fixed"),
        (&changes.newly_failing, "newly failing"),
    ] {
        marks.extend(
            list.iter()
                .map(|(recording, design)| ((&**recording, &**design), word)),
        );
    }
    for moved in &changes.moved {
        let pair = (&*moved.recording, &*moved.design);
        marks.entry(pair).or_insert("margin moved");
    }
    marks
}

/// Lists what changed since the baseline.
fn changes(id: &str, summary: &GateSummary, marks: &Marks<'_>, baseline: Option<&str>) -> Markup {
    let Some((changes, baseline)) = summary.baseline.as_ref().zip(baseline) else {
        return html! {};
    };
    let changed: Vec<usize> = numbers(summary)
        .filter(|(name, _)| marks.contains_key(name))
        .map(|(_, number)| number)
        .collect();
    html! {
        h2 { "Changed since " a href=(format!("/gates/{baseline}")) { code { (short(baseline)) } } }
        @if changed.is_empty() { p { "Nothing." } } @else { (pairs("Changed", id, summary, &changed, marks)) }
        @if !changes.removed.is_empty() {
            p { "Gone: " (changes.removed.iter().take(LISTED).map(|(recording, design)| format!("{recording} with {design}")).collect::<Vec<_>>().join(", ")) }
        }
    }
}

/// Numbers the pairs by their names.
fn numbers(summary: &GateSummary) -> impl Iterator<Item = ((&str, &str), usize)> {
    let names = summary.recordings.iter().flat_map(|recording| {
        let designs = summary.designs.iter();
        designs.map(move |design| (&*recording.name, &*design.name))
    });
    names.zip(0..)
}

fn worst(id: &str, summary: &GateSummary, marks: &Marks<'_>) -> Markup {
    let worst = summary.worst();
    html! {
        @if !worst.is_empty() {
            h2 { "Not as required, the worst first" }
            (pairs("Not as required", id, summary, &worst, marks))
        }
    }
}

fn pairs(
    label: &str,
    id: &str,
    summary: &GateSummary,
    numbers: &[usize],
    marks: &Marks<'_>,
) -> Markup {
    let listed = numbers.iter().take(LISTED);
    let listed: Vec<(usize, &Pair)> = listed
        .map(|&number| (number, &summary.pairs[number]))
        .collect();
    html! {
        div.wide tabindex="0" role="region" aria-label=(label) {
            table.rows {
                thead { tr {
                    th scope="col" { "Answer" } th scope="col" { "Required" } th scope="col" { "Recording" } th scope="col" { "Design" }
                    th scope="col" { "Peak" } th scope="col" { "Limit" } th scope="col" { "Changed" } th scope="col" { "Reason" }
                } }
                tbody { @for (number, pair) in &listed { tr {
                    td data-label="Answer" { a href=(format!("/gates/{id}/runs/{number}")) { (show::verdict(pair.row.verdict.name())) } }
                    td data-label="Required" { (pair.required.name()) }
                    td data-label="Recording" { (line(&pair.recording)) } td data-label="Design" { (line(&pair.design)) }
                    td.number data-label="Peak" { (show::angle(pair.row.peak_angle_rad)) }
                    td.number data-label="Limit" { (show::angle(Some(pair.row.threshold_rad))) }
                    td data-label="Changed" { (marks.get(&(&*pair.recording, &*pair.design)).copied().unwrap_or("–")) }
                    td data-label="Reason" { (in_the_file(&pair.row.reason.text)) }
                } } }
            }
        }
        @if numbers.len() > listed.len() { p.muted { (numbers.len() - listed.len()) " further ones in summary.csv." } }
    }
}

/// Draws the matrix; rows and columns in which something changed come first.
fn matrix(id: &str, summary: &GateSummary, marks: &Marks<'_>) -> Markup {
    let changed = |recording: Option<&str>, design: Option<&str>| {
        let fits = |own: Option<&str>, name: &str| own.is_none_or(|own| own == name);
        let mut keys = marks.keys();
        keys.any(|(row, column)| fits(recording, row) && fits(design, column))
    };
    let mut rows: Vec<usize> = (0..summary.recordings.len()).collect();
    rows.sort_by_key(|row| !changed(Some(&summary.recordings[*row].name), None));
    let mut columns: Vec<usize> = (0..summary.designs.len()).collect();
    columns.sort_by_key(|column| !changed(None, Some(&summary.designs[*column].name)));
    html! {
        h2 { "Recordings and designs" }
        p.muted { "Answer and margin: how far the nominal peak and its error stay below the limit angle, in percent of the limit; far beyond, its angle. "
            "A ring marks what is not as required" @if !marks.is_empty() { ", ◆ what changed; rows and columns with changes come first" } "." }
        div.wide tabindex="0" role="region" aria-label="Matrix of recordings and designs" {
            table.matrix id="matrix" {
                thead { tr { th scope="col" { "Recording" } @for column in &columns { th scope="col" { (line(&summary.designs[*column].name)) } } } }
                tbody { @for row in &rows { tr {
                    th scope="row" { (line(&summary.recordings[*row].name)) }
                    @for column in &columns {
                        @let number = row * summary.designs.len() + column;
                        @let pair = &summary.pairs[number];
                        @let mark = marks.get(&(&*pair.recording, &*pair.design));
                        td.bad[pair.standing == PairStanding::NotAsRequired] {
                            a href=(format!("/gates/{id}/runs/{number}")) title=(in_the_file(&pair.row.reason.text)) {
                                (show::verdict(pair.row.verdict.name())) " " (nearness(pair))
                            }
                            @if let Some(mark) = mark { br; span.mark { "◆ " (mark) } }
                        }
                    }
                } } }
            }
        }
    }
}

/// Words how near a pair comes to its limit: the margin in percent; where it is far beyond, how far.
fn nearness(pair: &Pair) -> String {
    let row = &pair.row;
    match row.margin() {
        _ if row.peak_angle_rad.is_some_and(|peak| peak > FRAC_PI_2) => "> 90°".into(),
        Some(margin) if margin < -1.0 => {
            format!("{} × limit", number::trimmed(1.0 - margin, 2))
        }
        Some(margin) => format!("{:.0} %", (100.0 * margin).floor()).replace('-', "−"),
        None => number::ABSENT.into(),
    }
}

/// Leads to the run of a pair, or offers to make its report where it was decided alone.
pub(super) async fn run(
    State(app): State<App>,
    Extension(visitor): Extension<Visitor>,
    Placed((id, number)): Placed<(String, usize)>,
) -> Result<Response, Problem> {
    let standing = find(&app, &id).await?;
    let summary = summary(&app, &standing).await?;
    let summary = summary.filter(|summary| number < summary.pairs.len());
    let summary = summary.ok_or_else(|| Problem::not_found("such pair, or not yet"))?;
    let pair = &summary.pairs[number];
    let report_id = pair.row.report_id.clone();
    let result = app
        .on_disk(move |parts| parts.ledger.result(&report_id))
        .await?;
    if let Some(result) = result {
        return Ok(Redirect::to(&format!("/verdicts/{}", result.report_id)).into_response());
    }
    let question = question(&standing.gate, number, false);
    let asking = json!({
        "recording": question.recording, "request": question.request, "design": question.design,
    });
    let body = html! {
        h1 { (line(&pair.recording)) " with " (line(&pair.design)) }
        section.card.(pair.row.verdict.name()) aria-label="Decision" {
            p.answer { (show::verdict(pair.row.verdict.name())) }
            p { (in_the_file(&pair.row.reason.text)) }
            dl {
                dt { "Peak angle of the nominal lever" } dd { (show::angle(pair.row.peak_angle_rad)) " · limit " (show::angle(Some(pair.row.threshold_rad))) }
                dt { "Required" } dd { (pair.required.name()) }
            }
        }
        p { "The gate took the decision alone." }
        p { button.primary type="button" id="pair" data-asking=(asking.to_string()) { "Make the report with its plots" } }
        (fields::waiting("judging"))
        p.error id="pair-told" role="alert" {}
        p { a href=(format!("/gates/{id}")) { "Back to the gate “" (standing.gate.name) "”" } }
    };
    Ok(layout(
        Some(&visitor),
        &format!("{} with {}", pair.recording, pair.design),
        &body,
    )
    .into_response())
}
