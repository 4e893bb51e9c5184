//! Parts that the pages share. Texts of a document pass [`line`], which replaces what must not be
//! shown; maud escapes the markup.

use crate::escape::terminal as line;
use crate::plot::Figure;
use crate::words;
use latchgate_document::blocks::RecordingBlock;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::units::OpensWhen;
use maud::{Markup, PreEscaped, html};

/// Returns a drawing with its caption.
pub(super) fn figure(figure: &Figure) -> Markup {
    html! {
        figure id=(figure.name) {
            (PreEscaped(figure.inline()))
            figcaption { (line(&figure.caption)) }
        }
    }
}

/// Returns a part that is folded at first; nothing for an empty part.
pub(super) fn fold(id: &str, title: &str, part: &Markup) -> Markup {
    html! {
        @if !part.0.is_empty() { details id=(id) { summary { (title) } (part) } }
    }
}

/// Returns the heads of a table's columns; one that starts with `#` is of numbers.
pub(super) fn heads(heads: &[&str]) -> Markup {
    html! {
        thead {
            tr {
                @for head in heads {
                    th .number[head.starts_with('#')] scope="col" { (head.trim_start_matches('#')) }
                }
            }
        }
    }
}

/// Returns a table's row of a name and its value.
pub(super) fn fact(name: &str, value: &str) -> Markup {
    html! { tr { th { (line(name)) } td { (line(value)) } } }
}

/// As [`fact`], of a value to be read letter by letter.
pub(super) fn code_fact(name: &str, value: &str) -> Markup {
    html! { tr { th { (line(name)) } td { code { (line(value)) } } } }
}

/// Returns the channel, where one is named, and the design.
pub(super) fn channel_and_design(recording: &RecordingBlock, design: &Design) -> Markup {
    html! {
        @if let Some(channel) = &recording.channel { "channel " (line(channel)) " · " }
        "design: " (line(&words::design(design)))
    }
}

/// Returns the stop and the opening sign of a run in words.
pub(super) fn stop_and_sign(model: StopModel, opens_when: OpensWhen) -> String {
    format!("{}, {}", model.label(), words::opens(opens_when))
}
