//! Designs by name and version, each with its differences to a baseline.

use super::{show, whole};
use crate::app::App;
use crate::http::designs::find;
use crate::problem::{Problem, Queried};
use axum::extract::State;
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
        @if designs.is_empty() { p { "None yet: questions take the paper's lever." } } @else {
            div.wide tabindex="0" role="region" aria-label="Designs" {
                table id="designs" {
                    thead { tr { th scope="col" { "Design" } th scope="col" { "Held against" } th scope="col" { "Differences" } th scope="col" { "Runs" } } }
                    tbody { @for (index, design) in designs.iter().enumerate() {
                        // The newest version comes first, its predecessor after it.
                        @let before = designs.get(index + 1).filter(|before| before.name == design.name);
                        @let base = baseline.as_ref().or(before);
                        tr {
                            th scope="row" { (design.reference()) }
                            td { @match base { Some(base) => (base.reference()), None => "the paper's lever" } }
                            td { (differences(&design.design, base.map_or(&paper, |base| &base.design))) }
                            td { a href=(format!("/?design={}", show::encoded(design.design["name"].as_str().unwrap_or("")))) { "verdicts" } }
                        }
                    } }
                }
            }
        }
        h2 { "Keep a design" }
        form id="design" {
            div.fields {
                label { "Name " input name="name" required maxlength="64" pattern="[A-Za-z0-9._\\-]+"; }
                label { "Made from "
                    select name="base" {
                        option value="" { "the paper's lever" }
                        @for design in &designs { (choice(&design.reference(), None)) }
                    }
                }
                label { "Changed " input name="set" size="32" placeholder="lever.preload_torque_nm=2.82, stop.restitution=0.7"; }
            }
            p { button.primary { "Keep" } }
            p id="design-told" role="alert" {}
        }
    };
    Ok(whole("Designs", &body))
}

fn choice(name: &str, chosen: Option<&str>) -> Markup {
    html! { option value=(name) selected[chosen == Some(name)] { (name) } }
}

fn differences(design: &Value, base: &Value) -> Markup {
    let found = show::differences(design, base);
    html! {
        @if found.is_empty() { "none" } @else { ul { @for text in &found { li { (text) } } } }
    }
}
