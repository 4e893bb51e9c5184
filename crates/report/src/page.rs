//! The start and the end of every page: style, script, and a content security policy by which nothing
//! else is run or fetched.

use super::escape;
use super::sheet;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use sha2::{Digest, Sha256};

/// A page's title, its rules beside those of all pages, and its script.
#[derive(Debug, Clone, Copy)]
pub struct PageFrame<'a> {
    /// Title.
    pub title: &'a str,
    /// Identity at the foot of every printed page; letters, digits, blanks, `-`, `_` and `.` alone.
    pub identity: &'a str,
    /// Style rules.
    pub style: &'a str,
    /// Script; the page must be complete without it.
    pub script: &'a str,
}

impl PageFrame<'_> {
    /// Returns the page up to and with the opening of its body. A content security policy lets its
    /// own style and script run and nothing else.
    pub fn head(&self) -> String {
        let style = format!("{}{}", sheet::style(self.identity), self.style);
        let (of_style, of_script) = (hash(&style), hash(self.script));
        let title = escape::markup(self.title);
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src '{of_style}'; script-src '{of_script}'; img-src data:; base-uri 'none'; form-action 'none'\"/>\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
             <meta name=\"color-scheme\" content=\"light dark\"/>\n\
             <title>{title}</title>\n<style>{style}</style>\n</head>\n<body>\n"
        )
    }

    /// Returns the page's end, with its script.
    pub fn tail(&self) -> String {
        format!("<script>{}</script>\n</body>\n</html>\n", self.script)
    }
}

/// Returns the name by which a content security policy knows a style or script.
fn hash(text: &str) -> String {
    format!(
        "sha256-{}",
        STANDARD.encode(Sha256::digest(text.as_bytes()))
    )
}
