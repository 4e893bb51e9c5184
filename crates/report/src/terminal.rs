//! Lines of a terminal: names at the left, texts wrapped with a hanging indent. No meaning is carried by
//! colour alone.

use super::escape;
use latchgate_recording::Severity;
use latchgate_verdict::Answer;
use std::fmt::Write as _;
use std::path::Path;

/// Width of the names [columns].
const NAMES: usize = 12;

/// Least width of a text [columns], however narrow the terminal.
const NARROWEST: usize = 24;

/// Properties of the output that an answer is written to.
#[derive(Debug, Clone, Copy)]
pub struct Look {
    /// Width to wrap to [columns]; `None` leaves a text on one line.
    pub width: Option<usize>,
    /// True if colours are written.
    pub colour: bool,
    /// True if paths are written as links.
    pub links: bool,
    /// True if the text says how the answer was decided.
    pub detail: bool,
    /// Replaces names of settings by those of the interface in use, such as options of the command line.
    pub worded: fn(&str) -> String,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            width: None,
            colour: false,
            links: false,
            detail: false,
            worded: str::to_string,
        }
    }
}

/// Width of a text written to a file or another program [columns].
pub const PIPED: usize = 100;

impl Look {
    /// Returns `text` in a colour by its number.
    fn paint(&self, colour: &str, text: &str) -> String {
        if self.colour {
            format!("\x1b[{colour}m{text}\x1b[0m")
        } else {
            text.to_string()
        }
    }

    /// Returns a verdict with its sign and colour.
    pub(super) fn verdict(&self, answer: Answer) -> String {
        let (sign, colour) = sign(answer);
        self.paint(colour, &format!("{sign} {}", super::words::answer(answer)))
    }

    pub(super) fn severity(&self, severity: Severity) -> String {
        let colour = match severity {
            Severity::Blocking => "1;31",
            Severity::Warning => "33",
            Severity::Info => "2",
        };
        self.paint(colour, super::words::severity(severity))
    }

    /// Returns a path, to be clicked where that is possible.
    pub(super) fn path(&self, path: &Path) -> String {
        let shown = escape::terminal(&path.display().to_string()).into_owned();
        let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
        match (self.links, absolute.to_str()) {
            (true, Some(absolute)) => {
                let address = file_address(absolute, std::path::MAIN_SEPARATOR);
                format!("\x1b]8;;{address}\x1b\\{shown}\x1b]8;;\x1b\\")
            }
            _ => shown,
        }
    }
}

/// Returns the address of a whole path: `file:///tmp/a`, and of `C:\a` `file:///C:/a`.
fn file_address(path: &str, separator: char) -> String {
    let mut address = String::from("file://");
    // A path of Windows begins with its drive.
    if !path.starts_with(separator) {
        address.push('/');
    }
    for byte in path.replace(separator, "/").bytes() {
        if byte.is_ascii_alphanumeric() || b"/-_.~:".contains(&byte) {
            address.push(char::from(byte));
        } else {
            let _ = write!(address, "%{byte:02X}");
        }
    }
    address
}

fn sign(answer: Answer) -> (char, &'static str) {
    match answer {
        Answer::Pass => ('✓', "1;32"),
        Answer::Fail => ('✗', "1;31"),
        Answer::Undecided => ('?', "1;33"),
        Answer::Unusable => ('!', "1;35"),
    }
}

/// Lines of a terminal, written one after the other.
#[derive(Debug)]
pub(super) struct TerminalLines {
    out: String,
    look: Look,
}

impl TerminalLines {
    pub(super) fn new(look: Look) -> Self {
        Self {
            out: String::with_capacity(2048),
            look,
        }
    }

    pub(super) fn into_string(self) -> String {
        self.out
    }

    /// Writes the verdict and the sentence that says what it means.
    pub(super) fn headline(&mut self, answer: Answer, sentence: &str) {
        let plain = Look {
            colour: false,
            ..self.look
        };
        let indent = plain.verdict(answer).chars().count() + 2;
        let head = self.look.verdict(answer);
        self.wrapped(&format!("{head}  "), indent, sentence);
    }

    /// Writes a name and its text, escaped so that it cannot leave its lines.
    pub(super) fn line(&mut self, name: &str, text: &str) {
        self.marked(name, "", "", text);
    }

    /// As [`Self::line`] with a finding's severity before its text.
    pub(super) fn graded(&mut self, name: &str, severity: Severity, text: &str) {
        let shown = self.look.severity(severity);
        self.marked(name, super::words::severity(severity), &shown, text);
    }

    fn marked(&mut self, name: &str, plain: &str, shown: &str, text: &str) {
        let head = self.look.paint("2", &format!("{name:<NAMES$}"));
        let (gap, extra) = match plain.chars().count() {
            0 => ("", 0),
            letters => (" ", letters + 1),
        };
        let head = format!("  {head} {shown}{gap}");
        self.wrapped_from(&head, NAMES + 3, extra, text);
    }

    /// Writes a line as it is, for example a path.
    pub(super) fn raw(&mut self, name: &str, text: &str) {
        let head = self.look.paint("2", &format!("{name:<NAMES$}"));
        let _ = writeln!(self.out, "  {head} {text}");
    }

    /// Writes an empty line.
    pub(super) fn blank(&mut self) {
        self.out.push('\n');
    }

    /// Writes a table as [`table`] lays it out.
    pub(super) fn table(&mut self, rows: &[Vec<String>]) {
        for line in table(rows, &[]).lines() {
            let _ = writeln!(self.out, "  {}", escape::terminal(line));
        }
    }

    /// Replaces the names of settings in a text by those of [`Look::worded`].
    pub(super) fn worded(&self, text: &str) -> String {
        (self.look.worded)(text)
    }

    fn wrapped(&mut self, head: &str, indent: usize, text: &str) {
        self.wrapped_from(head, indent, 0, text);
    }

    /// Writes `head`, then words of `text` up to the width; further lines begin at `indent`, the
    /// first holds `first_column` columns beyond it already.
    fn wrapped_from(&mut self, head: &str, indent: usize, first_column: usize, text: &str) {
        let text = self.worded(text);
        let text = escape::terminal(&text);
        self.out.push_str(head);
        wrap(&mut self.out, &text, self.look.width, indent, first_column);
        self.out.push('\n');
    }
}

/// Returns a text wrapped to `width` columns; further lines begin at `indent`.
pub fn wrapped(text: &str, width: Option<usize>, indent: usize) -> String {
    let mut out = String::with_capacity(text.len() + 64);
    // The first line is not indented, so it keeps the columns of the indent free as well.
    match width {
        Some(width) => wrap(&mut out, text, Some(width), indent, 0),
        None => out.push_str(text),
    }
    out
}

/// Writes words up to the width; further lines begin at `indent`, the first holds `first_column` columns beyond it
/// already.
fn wrap(out: &mut String, text: &str, width: Option<usize>, indent: usize, first_column: usize) {
    let width = width.map_or(usize::MAX, |width| {
        width.saturating_sub(indent).max(NARROWEST)
    });
    let mut column = first_column;
    let mut first = true;
    for word in text.split(' ') {
        let letters = word.chars().count();
        if !first && column + 1 + letters > width {
            let _ = write!(out, "\n{:indent$}", "");
            column = 0;
        } else if !first {
            out.push(' ');
            column += 1;
        }
        out.extend(word.chars().map(|c| match c {
            '\u{00A0}' | '\u{202F}' => ' ',
            other => other,
        }));
        column += letters;
        first = false;
    }
}

/// Returns [`table`] where it fits `width` columns; else a paragraph for each row under its first `names`
/// cells, with a line for each further cell after the head of its column.
pub fn fitted_table(rows: &[Vec<String>], names: usize, width: Option<usize>) -> String {
    let table = table(rows, &[]);
    let Some(width) = width.filter(|width| widest(&table) > *width) else {
        return table;
    };
    let Some((head, rows)) = rows.split_first() else {
        return table;
    };
    let mut out = String::new();
    for row in rows {
        let name = row[..names].join(" ");
        let _ = writeln!(out, "{}", name.trim());
        for (title, cell) in head.iter().zip(row).skip(names) {
            let indent = letters(title) + 4;
            let line = wrapped(&format!("  {title}  {cell}"), Some(width), indent);
            let _ = writeln!(out, "{line}");
        }
    }
    out
}

/// Returns a table, columns as wide as their widest cell; cells of `right` columns stand at the
/// right.
pub fn table(rows: &[Vec<String>], right: &[usize]) -> String {
    let columns = rows.first().map_or(0, Vec::len);
    let width = |column: usize| {
        let widths = rows.iter().map(|row| letters(&row[column]));
        widths.max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut out = String::new();
    for row in rows {
        let mut line = String::new();
        for (column, cell) in row.iter().enumerate() {
            let pad = " ".repeat(widths[column].saturating_sub(letters(cell)));
            let gap = if column > 0 { "  " } else { "" };
            if right.contains(&column) {
                let _ = write!(line, "{gap}{pad}{cell}");
            } else {
                let _ = write!(line, "{gap}{cell}{pad}");
            }
        }
        out.push_str(line.trim_end());
        out.push('\n');
    }
    out
}

/// Returns the width of the longest line [columns].
pub(super) fn widest(text: &str) -> usize {
    text.lines().map(letters).max().unwrap_or(0)
}

/// Returns the width of a text [columns], without the escape sequences of colours and links.
fn letters(text: &str) -> usize {
    let mut count = 0;
    let mut letters = text.chars();
    while let Some(c) = letters.next() {
        if c != '\x1b' {
            count += 1;
        } else if letters.next() == Some(']') {
            // A link's address ends with an escape and a backslash.
            while letters.next().is_some_and(|c| c != '\x1b') {}
            letters.next();
        } else {
            while letters.next().is_some_and(|c| c != 'm') {}
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::file_address;

    #[test]
    fn verif_paths_of_each_system_are_addresses() {
        for (path, separator, address) in [
            ("/tmp/a b.html", '/', "file:///tmp/a%20b.html"),
            (r"/tmp/a\b", '/', "file:///tmp/a%5Cb"),
            (
                r"C:\my reports\a.html",
                '\\',
                "file:///C:/my%20reports/a.html",
            ),
            (
                r"\\server\share\a.html",
                '\\',
                "file:////server/share/a.html",
            ),
        ] {
            assert_eq!(file_address(path, separator), address);
        }
    }
}
