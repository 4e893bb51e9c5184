//! `verdict.json`: the document, key by key, with all digits of its numbers.

use serde::Serialize;
use serde_json::ser::{Formatter, Serializer};
use std::io;

/// Returns the document as JSON: objects indented, lists of numbers on one line, numbers in
/// their shortest form that reads back to the same value, a line end at the end.
///
/// A number that is not finite becomes `null`, since JSON has no word for it.
pub fn render<T: Serialize>(document: &T) -> String {
    let mut bytes = Vec::with_capacity(16 * 1024);
    let mut serializer = Serializer::with_formatter(&mut bytes, Indenter::default());
    document
        .serialize(&mut serializer)
        .expect("results have text keys only and a Vec takes every byte");
    bytes.push(b'\n');
    String::from_utf8(bytes).expect("serde_json writes UTF-8")
}

/// Indents objects and lists of objects or lists, and keeps lists of plain values on one line.
#[derive(Debug, Default)]
struct Indenter {
    /// Per open container: whether it is a list, and whether it holds a container.
    open: Vec<(bool, bool)>,
}

impl Indenter {
    fn new_line<W: ?Sized + io::Write>(&self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b"\n")?;
        for _ in 0..self.open.len() {
            writer.write_all(b"  ")?;
        }
        Ok(())
    }

    /// Opens a container; one inside a list starts its own line.
    fn begin<W: ?Sized + io::Write>(&mut self, writer: &mut W, list: bool) -> io::Result<()> {
        let in_list = self.open.last().is_some_and(|(list, _)| *list);
        if let Some((_, holds)) = self.open.last_mut() {
            *holds = true;
        }
        if in_list {
            self.new_line(writer)?;
        }
        self.open.push((list, false));
        Ok(())
    }

    fn end<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        let (_, holds) = self.open.pop().unwrap_or_default();
        if holds { self.new_line(writer) } else { Ok(()) }
    }
}

/// Tells whether a character steers a terminal or turns the reading direction: control characters, and those of
/// Unicode that reorder text.
pub fn steers(c: char) -> bool {
    matches!(c, '\u{200E}' | '\u{200F}' | '\u{061C}' | '\u{2028}'..='\u{202E}' | '\u{2066}'..='\u{2069}')
        || c.is_control()
}

impl Formatter for Indenter {
    fn write_string_fragment<W: ?Sized + io::Write>(
        &mut self,
        writer: &mut W,
        fragment: &str,
    ) -> io::Result<()> {
        let mut remaining = fragment;
        while let Some((index, c)) = remaining.char_indices().find(|(_, c)| steers(*c)) {
            writer.write_all(&remaining.as_bytes()[..index])?;
            write!(writer, "\\u{:04x}", u32::from(c))?;
            remaining = &remaining[index + c.len_utf8()..];
        }
        writer.write_all(remaining.as_bytes())
    }

    fn begin_array<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.begin(writer, true)?;
        writer.write_all(b"[")
    }

    fn end_array<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.end(writer)?;
        writer.write_all(b"]")
    }

    fn begin_array_value<W: ?Sized + io::Write>(
        &mut self,
        writer: &mut W,
        first: bool,
    ) -> io::Result<()> {
        if first {
            Ok(())
        } else {
            writer.write_all(b",")
        }
    }

    fn begin_object<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.begin(writer, false)?;
        writer.write_all(b"{")
    }

    fn end_object<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.end(writer)?;
        writer.write_all(b"}")
    }

    fn begin_object_key<W: ?Sized + io::Write>(
        &mut self,
        writer: &mut W,
        first: bool,
    ) -> io::Result<()> {
        if let Some((_, holds)) = self.open.last_mut() {
            *holds = true;
        }
        if !first {
            writer.write_all(b",")?;
        }
        self.new_line(writer)
    }

    fn begin_object_value<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b": ")
    }
}
