//! Where each method fails.

use super::Headline;
use serde::Serialize;

/// A row.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Subject.
    pub subject: &'static str,
}

/// The study's answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Stability {
    /// Rows.
    pub rows: Vec<Row>,
    /// What to take away.
    pub headlines: Vec<Headline>,
}

/// What is asked.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// The lever.
    pub design: crate::model::Design,
    /// What one g is [m/s²].
    pub gravity_m_s2: f64,
    /// Steps on the map of step against stiffness.
    pub points: u32,
}

/// Runs.
///
/// # Errors
///
/// None.
pub fn run(_options: &Options) -> Result<Stability, crate::error::Error> {
    Ok(Stability {
        rows: Vec::new(),
        headlines: Vec::new(),
    })
}
