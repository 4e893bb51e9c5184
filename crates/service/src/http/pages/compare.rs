//! Verdicts side by side: the page of `latchgate compare`, with links. A list asks for the oldest first, so that the
//! page reads from before to after.

use super::layout;
use super::verdict::{SERIES_BYTES, find};
use crate::app::{App, Parts};
use crate::auth::Visitor;
use crate::problem::Problem;
use axum::extract::{Extension, RawQuery, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use latchgate::pipeline::Document;
use latchgate::report::comparison::{VERDICTS_MAX, letter, subject};
use latchgate::report::escape::terminal as line;
use latchgate::report::series::SampledSeries;
use latchgate::report::{differences, html as report};
use maud::{Markup, html};
use std::collections::HashMap;

/// Compares the verdicts that the query names, in its order; with `sort=oldest` by when they were made.
pub(super) async fn page(
    State(app): State<App>,
    Extension(visitor): Extension<Visitor>,
    RawQuery(query): RawQuery,
) -> Result<Response, Problem> {
    let query = query.unwrap_or_default();
    let mut ids: Vec<String> = Vec::new();
    for id in query.split('&').filter_map(|pair| pair.strip_prefix("id=")) {
        if !ids.iter().any(|earlier| earlier == id) {
            ids.push(id.to_string());
        }
    }
    if ids.len() < 2 || ids.len() > VERDICTS_MAX {
        let status = if ids.is_empty() {
            StatusCode::OK
        } else {
            StatusCode::BAD_REQUEST
        };
        return Ok((status, how_to_choose(&visitor, ids.len())).into_response());
    }
    let oldest_first = query.split('&').any(|pair| pair == "sort=oldest");
    let _place = app.pages.acquire().await;
    let page = app
        .apart(move |parts| {
            if oldest_first {
                sort_by_age(parts, &mut ids)?;
            }
            drawn(parts, &visitor, &ids)
        })
        .await?;
    Ok(page.into_response())
}

/// Explains how verdicts are chosen.
fn how_to_choose(visitor: &Visitor, chosen: usize) -> Markup {
    let body = html! {
        h1 { "Compare verdicts" }
        p {
            "Tick two to " (VERDICTS_MAX) " verdicts in the " a href="/" { "list of verdicts" }
            ", then press “Compare the chosen ones”."
            @if chosen > 0 { " Chosen: " (chosen) "." }
        }
    };
    layout(Some(visitor), "Compare", &body)
}

/// Puts the oldest verdict first; unknown ones stay in their order, for the page to name.
fn sort_by_age(parts: &Parts, ids: &mut [String]) -> Result<(), Problem> {
    let mut made = HashMap::new();
    for id in &*ids {
        let result = parts.ledger.result(id)?;
        made.insert(id.clone(), result.map(|result| result.created_ms));
    }
    ids.sort_by_key(|id| made[id]);
    Ok(())
}

fn drawn(parts: &Parts, visitor: &Visitor, ids: &[String]) -> Result<Markup, Problem> {
    let (mut documents, mut keys, mut tables) = (Vec::new(), Vec::new(), Vec::new());
    for id in ids {
        let verdict = find(parts, id, SERIES_BYTES / ids.len() as u64)?;
        let other_version =
            || Problem::not_found(&format!("verdict {id} of this version; judge it again"));
        documents.push(verdict.document.ok_or_else(other_version)?);
        keys.push(verdict.keys);
        // Nothing was replayed where there is no nominal run.
        let replayed = documents
            .last()
            .is_some_and(|document| document.nominal.is_some());
        tables.extend(verdict.series.filter(|_| replayed));
    }
    let documents: Vec<&Document> = documents.iter().collect();
    let tables: Option<&[SampledSeries]> = (tables.len() == ids.len()).then_some(&tables);
    let differing = differences::between(&keys.iter().collect::<Vec<_>>());
    let body = html! {
        (report::compared(&documents, tables, &differing))
        script src="/assets/event.js" defer {}
        h2 { "Verdicts" }
        ul {
            @for (place, id) in ids.iter().enumerate() {
                li {
                    (letter(place)) " · " (line(&subject(documents[place])))
                    @if documents[place].recording.opens_when.is_none() { ", direction not declared" }
                    ": " a href={ "/verdicts/" (id) } { "the verdict" }
                    " · " a href={ "/v1/verdicts/" (id) "/report.html" } { "its report" }
                    @if place > 0 { " · " a href=(first(ids, place)) { "put it first" } }
                }
            }
        }
    };
    Ok(layout(Some(visitor), "Compare", &body))
}

/// Returns the address of the same comparison with one verdict before the others.
fn first(ids: &[String], place: usize) -> String {
    let mut order: Vec<&str> = ids.iter().map(String::as_str).collect();
    order[..=place].rotate_right(1);
    format!("/compare?id={}", order.join("&id="))
}
