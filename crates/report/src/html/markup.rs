//! A page that grows, with every text escaped on its way in.

use crate::escape;
use crate::plot::Figure;

/// The markup so far.
#[derive(Debug)]
pub(super) struct Page {
    out: String,
}

impl Page {
    pub(super) fn with_capacity(bytes: usize) -> Self {
        Self {
            out: String::with_capacity(bytes),
        }
    }

    pub(super) fn into_string(self) -> String {
        self.out
    }

    /// Adds markup that is known to be well formed; never text from a document.
    pub(super) fn raw(&mut self, markup: &str) {
        self.out.push_str(markup);
    }

    /// Adds text, escaped.
    pub(super) fn text(&mut self, text: &str) {
        self.out.push_str(&escape::markup(text));
    }

    pub(super) fn section(&mut self, id: &str, title: &str) {
        self.begin_section(id, "", title);
    }

    /// As [`Self::section`], of a table that a phone scrolls sideways: keys are to reach it.
    pub(super) fn wide_section(&mut self, id: &str, title: &str) {
        self.begin_section(id, " tabindex=\"0\"", title);
    }

    fn begin_section(&mut self, id: &str, attributes: &str, title: &str) {
        self.raw("<section id=\"");
        self.raw(id);
        self.raw("\"");
        self.raw(attributes);
        self.raw(">\n<h2>");
        self.text(title);
        self.raw("</h2>\n");
    }

    /// Adds a part that is folded at first; one with nothing in it is left out.
    pub(super) fn fold(&mut self, id: &str, title: &str, write: &dyn Fn(&mut Self)) {
        let before = self.out.len();
        self.raw("<details id=\"");
        self.raw(id);
        self.raw("\">\n<summary>");
        self.text(title);
        self.raw("</summary>\n");
        let empty = self.out.len();
        write(self);
        if self.out.len() == empty {
            self.out.truncate(before);
        } else {
            self.raw("</details>\n");
        }
    }

    /// Adds a heading within a folded part.
    pub(super) fn heading(&mut self, title: &str) {
        self.element("h3", "", title);
        self.raw("\n");
    }

    pub(super) fn end_section(&mut self) {
        self.raw("</section>\n");
    }

    pub(super) fn paragraph(&mut self, text: &str) {
        self.raw("<p>");
        self.text(text);
        self.raw("</p>\n");
    }

    /// Adds a drawing with its caption.
    pub(super) fn figure(&mut self, figure: &Figure) {
        self.raw("<figure id=\"");
        self.raw(figure.name);
        self.raw("\">\n");
        self.raw(&figure.inline());
        self.raw("<figcaption>");
        self.text(&figure.caption);
        self.raw("</figcaption>\n</figure>\n");
    }

    pub(super) fn note(&mut self, text: &str) {
        self.raw("<p class=\"note\">");
        self.text(text);
        self.raw("</p>\n");
    }

    /// Adds an element around escaped text; `class` may be empty.
    pub(super) fn element(&mut self, name: &str, class: &str, text: &str) {
        self.raw("<");
        self.raw(name);
        if !class.is_empty() {
            self.raw(" class=\"");
            self.raw(class);
            self.raw("\"");
        }
        self.raw(">");
        self.text(text);
        self.raw("</");
        self.raw(name);
        self.raw(">");
    }

    /// Opens a table with its column heads; a head that starts with `#` is of numbers.
    pub(super) fn table(&mut self, class: &str, heads: &[&str]) {
        self.raw("<table class=\"");
        self.raw(class);
        self.raw("\">\n<thead><tr>");
        for head in heads {
            match head.strip_prefix('#') {
                Some(head) => self.column("number", head),
                None => self.column("", head),
            }
        }
        self.raw("</tr></thead>\n<tbody>\n");
    }

    fn column(&mut self, class: &str, head: &str) {
        self.raw("<th scope=\"col\" class=\"");
        self.raw(class);
        self.raw("\">");
        self.text(head);
        self.raw("</th>");
    }

    pub(super) fn end_table(&mut self) {
        self.raw("</tbody>\n</table>\n");
    }

    /// Opens a table of names and values.
    pub(super) fn facts(&mut self) {
        self.raw("<table class=\"facts\">\n<tbody>\n");
    }

    /// Adds a name and its value.
    pub(super) fn fact(&mut self, name: &str, value: &str) {
        self.raw("<tr>");
        self.element("th", "", name);
        self.element("td", "", value);
        self.raw("</tr>\n");
    }

    /// Adds a name and a value to be read letter by letter.
    pub(super) fn code_fact(&mut self, name: &str, value: &str) {
        self.raw("<tr>");
        self.element("th", "", name);
        self.raw("<td>");
        self.element("code", "", value);
        self.raw("</td></tr>\n");
    }
}
