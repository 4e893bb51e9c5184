//! Designs by name and version, each with its differences to a baseline.

use super::fields::{self, DesignChoice};
use super::{layout, show};
use crate::app::App;
use crate::auth::{Scope, Visitor};
use crate::http::designs::find;
use crate::problem::{Problem, Queried};
use crate::store::StoredDesign;
use axum::extract::{Extension, State};
use latchgate::pipeline::Design;
use maud::{Markup, html};
use serde::Deserialize;
use serde_json::{Value, json};

/// What the page is asked for.
#[derive(Debug, Deserialize)]
pub(super) struct Compared {
    /// `name@version` of the baseline; each version's predecessor where none is named.
    baseline: Option<String>,
}

/// Lists the designs, and offers to keep one.
pub(super) async fn page(
    State(app): State<App>,
    Extension(visitor): Extension<Visitor>,
    Queried(compared): Queried<Compared>,
) -> Result<Markup, Problem> {
    let stored = app.on_disk(|parts| parts.ledger.designs(0, 1000)).await?;
    let (designs, left_out) = (stored.entries, stored.damaged.len());
    let chosen = compared.baseline.filter(|name| !name.is_empty());
    let baseline = match &chosen {
        Some(name) => Some(find(&app, name).await?),
        None => None,
    };
    let paper = json!(Design::reference());
    let body = html! {
        h1 { "Designs" }
        form.filters method="get" action="/designs" {
            label { "Differences to "
                select name="baseline" {
                    option value="" { "the version before" }
                    @for design in &designs { (choice(&design.reference(), chosen.as_deref())) }
                }
            }
            button { "Show" }
        }
        (show::damaged(left_out))
        @if designs.is_empty() { p { "None yet. Questions take the paper's lever." } } @else {
            div.wide tabindex="0" role="region" aria-label="Designs" {
                table.rows id="designs" {
                    thead { tr { th scope="col" { "Design" } th scope="col" { "Compared with" } th scope="col" { "Differences" } th scope="col" { "Runs" } } }
                    tbody { @for (index, design) in designs.iter().enumerate() {
                        // The newest version comes first, its predecessor after it.
                        @let before = designs.get(index + 1).filter(|before| before.name == design.name);
                        @let base = baseline.as_ref().or(before);
                        tr {
                            th scope="row" data-label="Design" { (design.reference()) }
                            td data-label="Compared with" { @match base { Some(base) => (base.reference()), None => "the paper's lever" } }
                            td data-label="Differences" { (differences(&design.design, base.map_or(&paper, |base| &base.design))) }
                            td data-label="Runs" { a href=(format!("/?design={}", show::encoded(design.design["name"].as_str().unwrap_or("")))) { "verdicts" } }
                        }
                    } }
                }
            }
        }
        @if visitor.may(Scope::Submit) { (keep(&designs)) }
    };
    Ok(layout(Some(&visitor), "Designs", &body))
}

fn keep(designs: &[StoredDesign]) -> Markup {
    let choices: Vec<DesignChoice> = designs
        .iter()
        .map(|design| DesignChoice {
            reference: design.reference(),
            numbers: design.design.clone(),
        })
        .collect();
    html! {
        h2 { "Keep a design" }
        form id="design" novalidate {
            div.fields {
                label { "Name: a to z, digits, “.”, “-”, “_” " input name="name" maxlength="64" autocomplete="off"; }
                (fields::design("base", "Made from", &choices))
            }
            (fields::lever())
            p { button.primary { "Keep" } }
            p.error id="design-told" role="alert" {}
        }
    }
}

fn choice(name: &str, chosen: Option<&str>) -> Markup {
    html! { option value=(name) selected[chosen == Some(name)] { (name) } }
}

fn differences(design: &Value, base: &Value) -> Markup {
    let texts = show::differences(design, base);
    html! {
        @if texts.is_empty() { "none" } @else { ul { @for text in &texts { li { (text) } } } }
    }
}
