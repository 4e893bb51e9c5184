//! What loses the door.

use serde::{Deserialize, Serialize};

/// The angle beyond which the door is lost, and how many varied levers may reach it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Criterion {
    /// Largest angle that keeps the door shut [rad].
    pub threshold_rad: f64,
    /// Share of varied levers and readings that a pass lets open [-].
    pub open_share: f64,
    /// Confidence with which fewer than that open, over all looks at an ensemble together [-].
    pub confidence: f64,
    /// The smaller one that an override took the place of [rad]; `None` if none did.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub raised_from_rad: Option<f64>,
}

impl Default for Criterion {
    fn default() -> Self {
        Self {
            threshold_rad: 0.1,
            open_share: 0.05,
            confidence: 0.95,
            raised_from_rad: None,
        }
    }
}
