//! Panels of where methods fail.

use super::Figure;
use super::canvas::Canvas;
use crate::study::stability::Stability;

const NAME: &str = "stability";

pub(super) fn draw(_result: &Stability) -> Figure {
    let canvas = Canvas::with_capacity(64 * 1024);
    Figure {
        name: NAME,
        title: "Where methods fail".into(),
        caption: String::new(),
        description: String::new(),
        height: 100.0,
        body: canvas.into_string(),
    }
}
