//! What part a design is of: the `[document]` table of a design file, shown and never computed with.

use latchgate_recording::error::{Error, Place, with_article};
use serde::{Deserialize, Serialize};

/// What a design file says of its part.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DesignDocument {
    /// Part number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// Its revision.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub revision: Option<String>,
    /// Number of the drawing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drawing: Option<String>,
    /// Who states the numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub author: Option<String>,
    /// When.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
}

/// Key of its table.
pub(crate) const DOCUMENT: &str = "document";

/// Keys of the table, in the order of a page.
const KEYS: [&str; 5] = ["part", "revision", "drawing", "author", "date"];

impl DesignDocument {
    /// Reads the table of a design file.
    ///
    /// # Errors
    ///
    /// [`UnknownName`](latchgate_recording::error::ErrorKind::UnknownName) for another key,
    /// [`Malformed`](latchgate_recording::error::ErrorKind::Malformed) for a value that is no text on one line, each at
    /// its place in `text`.
    pub(crate) fn of_table(table: &toml::Table, text: &str) -> Result<Self, Error> {
        let mut document = Self::default();
        for (key, value) in table {
            let place = || Place::of_key(text, Some(DOCUMENT), key);
            let Some(slot) = document.slot(key) else {
                return Err(Error::unknown("key of [document]", key, &KEYS).at(place()));
            };
            let said = match value {
                toml::Value::String(said) if !said.chars().any(char::is_control) => said.clone(),
                // TOML has dates without quotes.
                toml::Value::Datetime(date) => date.to_string(),
                other => {
                    let hint = "write it in quotes, on one line";
                    let found = with_article(other.type_str());
                    let expected = format!("a text for `{key}` of [document]");
                    return Err(Error::malformed(expected, found, hint).at(place()));
                }
            };
            *slot = Some(said);
        }
        Ok(document)
    }

    fn slot(&mut self, key: &str) -> Option<&mut Option<String>> {
        match key {
            "part" => Some(&mut self.part),
            "revision" => Some(&mut self.revision),
            "drawing" => Some(&mut self.drawing),
            "author" => Some(&mut self.author),
            "date" => Some(&mut self.date),
            _ => None,
        }
    }

    /// Returns what is stated: names with values.
    pub fn stated(&self) -> Vec<(&'static str, &str)> {
        let Self {
            part,
            revision,
            drawing,
            author,
            date,
        } = self;
        [
            ("Part", part),
            ("Revision", revision),
            ("Drawing", drawing),
            ("Author", author),
            ("Date", date),
        ]
        .into_iter()
        .filter_map(|(name, value)| Some((name, value.as_deref()?)))
        .collect()
    }
}
