//! An HTML page in a single file.

use std::fmt::Write;

use super::markup::{escape, joined, slug};
use super::table::Table;

/// A page that is being written. All text is escaped; SVG is copied unchanged.
///
/// ```
/// use underbrush_report::drawing::{Page, Rows};
///
/// let mut page = Page::new("Two reaches");
/// page.section("forces");
/// page.paragraph("Leaves press with less than 1 N.");
/// page.table(&Rows::of([("leaf", 0.4), ("trunk", 7.0)])
///     .column("category", |(name, _)| name)
///     .number("mean force / N", 1, |(_, force_n)| force_n)
///     .table("forces", "Mean forces"));
/// let html = page.html();
/// assert!(html.contains("less than 1 N") && html.contains("<td class=\"number\">7.0</td>"));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Page {
    title: String,
    body: String,
    /// What closes the open section, if there is one.
    end: &'static str,
}

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

impl Page {
    /// An empty page.
    pub fn new(title: impl Into<String>) -> Self {
        Page { title: title.into(), ..Page::default() }
    }

    /// Begins a section. It is folded: its heading is shown until a reader opens it.
    pub fn section(&mut self, heading: &str) {
        self.body += std::mem::replace(&mut self.end, "</details>\n");
        let (name, heading) = (slug(heading), escape(heading));
        let _ = writeln!(self.body, "<details><summary><h2 id=\"{name}\">{heading}</h2></summary>");
    }

    /// What the page says first, in large letters.
    pub fn lead(&mut self, text: &str) {
        let _ = writeln!(self.body, "<p class=\"lead\">{}</p>", escape(text));
    }

    /// Charts and pictures side by side, without a caption.
    pub fn side_by_side(&mut self, parts: &[String]) {
        let _ = writeln!(self.body, "<div class=\"first\">\n{}</div>", divisions(parts));
    }

    /// Cards with a heading and a list of statements. A card without statements is left out.
    pub fn cards<'a>(&mut self, cards: impl IntoIterator<Item = (&'a str, Vec<String>)>) {
        let cards = cards.into_iter().filter(|(_, statements)| !statements.is_empty());
        let card = |(heading, statements): (&str, Vec<String>)| {
            format!("<section><h2>{}</h2>{}</section>", escape(heading), list(statements))
        };
        let _ = writeln!(self.body, "<div class=\"cards\">\n{}</div>", joined(cards.map(card), "\n"));
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) {
        let _ = writeln!(self.body, "<p>{}</p>", escape(text));
    }

    /// A paragraph for each of these texts.
    pub fn paragraphs(&mut self, texts: impl IntoIterator<Item = String>) {
        texts.into_iter().for_each(|text| self.paragraph(&text));
    }

    /// A quotation of the publication, set apart from the results.
    pub fn published(&mut self, text: &str) {
        let _ = writeln!(self.body, "<p class=\"paper\">In the paper: {}</p>", escape(text));
    }

    /// A list of statements.
    pub fn list(&mut self, items: impl IntoIterator<Item = String>) {
        self.body += &list(items);
    }

    /// A table, with a link to its CSV file in the folder `csv` beside the page.
    pub fn table(&mut self, table: &Table) {
        self.body += &table.html();
        self.numbers(table);
    }

    /// A link to the CSV file of a table that is too long to be shown.
    pub fn numbers(&mut self, table: &Table) {
        let name = escape(&table.name);
        let _ = writeln!(self.body, "<p>Numbers: <a href=\"csv/{name}.csv\">{name}.csv</a></p>");
    }

    /// Related charts above one caption, side by side if there is room.
    pub fn figure(&mut self, caption: &str, charts: &[String]) {
        let class = if charts.len() == 1 { "charts one" } else { "charts" };
        let (charts, caption) = (divisions(charts), escape(caption));
        let _ = writeln!(
            self.body,
            "<figure><div class=\"{class}\">\n{charts}</div>\n<figcaption>{caption}</figcaption></figure>"
        );
    }

    /// A paragraph that is a link to a file beside the page.
    pub fn link(&mut self, address: &str, text: &str) {
        let _ = writeln!(self.body, "<p>{}</p>", anchor(address, text));
    }

    /// A paragraph of links, each with its address and text, after some words; nothing without links.
    pub fn links(&mut self, words: &str, links: impl Iterator<Item = (String, String)>) {
        let links = joined(links.map(|(address, text)| anchor(&address, &text)), ", ");
        if !links.is_empty() {
            let _ = writeln!(self.body, "<p>{}: {links}</p>", escape(words));
        }
    }

    /// The whole page.
    pub fn html(self) -> String {
        let Page { title, body, end } = self;
        let title = escape(&title);
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>{title}</title>\n\
             <style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n{body}{end}</main>\n\
             <script>\n{SCRIPT}</script>\n</body>\n</html>\n"
        )
    }
}

fn anchor(address: &str, text: &str) -> String {
    format!("<a href=\"{}\">{}</a>", escape(address), escape(text))
}

fn divisions(parts: &[String]) -> String {
    joined(parts.iter().map(|part| format!("<div>{part}</div>")), "\n")
}

fn list(items: impl IntoIterator<Item = String>) -> String {
    let items = items.into_iter().map(|item| format!("<li>{}</li>", escape(&item)));
    format!("<ul>\n{}\n</ul>\n", joined(items, "\n"))
}
