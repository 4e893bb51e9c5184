//! The advice: the value from which on every value tried passes by the whole rule, in words.

use super::quantity::Quantity;
use serde::{Deserialize, Serialize};

/// From where on every value tried passes by the whole rule.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Advice {
    /// The value; `None` with a reason.
    pub safe_from: Option<f64>,
    /// The end of the grid, up to which every value tried passes.
    pub until: f64,
    /// The first value on the other side that does not pass; `None` if all of the grid passes.
    pub does_not: Option<f64>,
    /// Values from the advised one on that were tried.
    pub tried: usize,
    /// Why there is none.
    pub reason: Option<String>,
    /// In a sentence.
    pub text: String,
}

impl Advice {
    /// Returns that of a quantity that was not searched.
    pub(super) fn unasked(until: f64, why: &str) -> Self {
        Self {
            safe_from: None,
            until,
            does_not: None,
            tried: 0,
            reason: Some(why.into()),
            text: why.into(),
        }
    }

    /// Tells whether the advice is that a value passes.
    pub fn covers(&self, quantity: Quantity, value: f64) -> bool {
        self.safe_from.is_some_and(|from| {
            if quantity.is_safer_above() {
                value >= from
            } else {
                value <= from
            }
        })
    }

    /// Returns the advice in one sentence: what passes, what the present value does and how many values
    /// were tried.
    pub(super) fn sentence(&self, quantity: Quantity, present: f64, passes: bool) -> String {
        let above = quantity.is_safer_above();
        let (more, until) = if above {
            ("or more", "up to")
        } else {
            ("or less", "down to")
        };
        let title = quantity.title();
        let article = if title.starts_with(['a', 'u']) {
            "an"
        } else {
            "a"
        };
        let shown = |value: f64| quantity.shown(value);
        let number = |value: f64| latchgate_kernel::units::shortest(value);
        let end = number(self.until);
        let tried = format!("{} values tried {until} {end}", self.tried);
        match (self.safe_from, passes) {
            (Some(from), true) if self.covers(quantity, present) => {
                let direction = if above { "down to" } else { "up to" };
                format!(
                    "Passes {direction} {article} {title} of {} (now {}; {tried})",
                    shown(from),
                    number(present)
                )
            }
            (Some(from), false) if self.covers(quantity, present) => format!(
                "{} values of the {title} from {} {until} {end} pass, but the present one, {}, does not",
                self.tried,
                shown(from),
                number(present)
            ),
            (Some(from), false) => format!(
                "{} {title} of {} {more} passes (now {}; {tried})",
                if article == "an" { "An" } else { "A" },
                shown(from),
                number(present)
            ),
            (Some(from), true) => {
                let first = self.does_not.map_or_else(String::new, |value| {
                    format!(", but {} does not", number(value))
                });
                format!(
                    "Isolated pass, do not design to it: {article} {title} of {} passes{first}; {} {more} passes ({tried})",
                    shown(present),
                    number(from)
                )
            }
            (None, _) => {
                let why = self.reason.as_deref().unwrap_or("none was found");
                format!(
                    "No {title} is advised: {}, the safe end, does not pass: {why}",
                    shown(self.until)
                )
            }
        }
    }
}
