//! Messages of the interface in the words of the pages: what is a field there has a label here.

use crate::problem::for_http;
use latchgate::pipeline::{Setting, words_of};
use latchgate::report::escape::terminal as line;

/// Labels of the settings that pages offer.
pub(super) const LABELS: &[(Setting, &str)] = &[
    (Setting::Channel, "Channel"),
    (Setting::InputFormat, "Format"),
    (Setting::Sheet, "Sheet"),
    (Setting::TimeColumn, "Time column"),
    (Setting::TimeUnit, "Unit of time"),
    (Setting::TimeSource, "Clock of a log"),
    (Setting::RateHz, "Sample rate [Hz]"),
    (Setting::HeaderLine, "Line of the names"),
    (Setting::UnitLine, "Line of the units"),
    (Setting::LastLine, "Last line of the table"),
    (Setting::SkipLines, "Lines to pass over"),
    (Setting::Decimal, "Decimal mark"),
    (Setting::Unit, "Unit of acceleration"),
    (Setting::Sensitivity, "Sensitivity, as 20 g/V"),
    (Setting::TimeZero, "Time of first contact [s]"),
    (Setting::OpensWhen, "Opening direction"),
    (Setting::Filter, "Filter"),
    (Setting::Transfer, "Factor from sensor to latch"),
    (Setting::VelocityChange, "Velocity change [m/s]"),
    (Setting::Accept, "Accepted doubts"),
    (Setting::Siblings, "All lateral channels of that side"),
    (Setting::Model, "Stop"),
];

/// Returns the label of a setting.
pub(super) fn label(setting: Setting) -> &'static str {
    let entry = LABELS.iter().find(|(labelled, _)| *labelled == setting);
    entry.map_or("", |(_, label)| label)
}

/// Tells whether a message is about a setting.
pub(super) fn is_about(text: &str, setting: Setting) -> bool {
    for_http(text).contains(&format!("`request.{}`", setting.key()))
}

/// Words a message for whoever sees a page; nothing in it can reorder the text.
pub(super) fn on_the_page(text: &str) -> String {
    let mut text = for_http(&line(text));
    for prefix in ["request: ", "design: ", "set: "] {
        text = text.strip_prefix(prefix).unwrap_or(&text).to_string();
    }
    for (setting, label) in LABELS {
        let field = format!("the field `request.{}`", setting.key());
        text = text.replace(&format!("; choose one with {field} = NAME"), "");
        text = text.replace(&format!("{field} ="), &format!("“{label}” as"));
        text = text.replace(&field, &format!("“{label}”"));
    }
    // The form lists them.
    let units = format!(" as {}", words_of(Setting::Unit).join("|"));
    text.replace(&units, "")
        .replace("the field `request.", "the setting `")
}
