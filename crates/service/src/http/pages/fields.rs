//! Fields of forms that more than one page has.

use latchgate::document::number::exact;
use latchgate::pipeline::{Design, PARAMETERS};
use latchgate::report::escape::terminal as line;
use maud::{Markup, html};
use serde_json::{Value, json};

/// A design to choose: how it is named, and its numbers, table by table.
pub(super) struct DesignChoice {
    pub(super) reference: String,
    pub(super) numbers: Value,
}

/// Chooses a design; the paper's lever where none is stored under the name "".
pub(super) fn design(name: &str, title: &str, choices: &[DesignChoice]) -> Markup {
    html! {
        label { (title) " "
            select name=(name) data-designs {
                option value="" data-numbers=(json!(Design::reference())) { "the paper's lever" }
                @for choice in choices {
                    option value=(choice.reference) data-numbers=(choice.numbers) { (line(&choice.reference)) }
                }
            }
        }
    }
}

/// A field for each number of a lever; one that is left empty stays as the design has it.
pub(super) fn lever() -> Markup {
    let paper = Design::reference();
    html! {
        details.change {
            summary { "Change numbers of the lever" }
            div.fields {
                @for parameter in PARAMETERS {
                    label { (parameter.what) (bracketed(parameter.unit)) " "
                        input name=(parameter.name) data-number inputmode="decimal" autocomplete="off"
                            placeholder=(exact(paper.value(parameter)));
                    }
                }
            }
        }
    }
}

/// Where a page says what is done for a verdict that it waits for. Steps are announced, seconds are not.
pub(super) fn waiting(id: &str) -> Markup {
    html! {
        div.waiting id=(id) hidden {
            progress aria-label="Judging" {}
            p role="status" {}
            p.muted role="timer" {}
        }
    }
}

/// Shows a unit behind a number; none of a ratio.
pub(super) fn unit(unit: &str) -> String {
    match unit {
        "1" => String::new(),
        unit => format!("\u{00A0}{}", unit.replace(' ', "·")),
    }
}

/// Shows a unit in brackets; none of a ratio.
pub(super) fn bracketed(unit: &str) -> String {
    match unit {
        "1" => String::new(),
        unit => format!(" [{}]", unit.replace(' ', "·")),
    }
}
