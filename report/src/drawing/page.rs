//! An HTML page in a single file.

use std::fmt::Write;

use super::markup::{escape, slug};
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
    contents: Vec<(String, String)>,
    body: String,
}

/// One column of readable width, with figures in as many columns as there is room for. In print, a section is kept
/// together if it fits. A table that is too wide for the page scrolls; its caption does not.
const STYLE: &str = "\
:root { color-scheme: light }
body { font: 1rem/1.5 system-ui, sans-serif; color: #1d2126; background: #ffffff; margin: 0 auto; padding: 1rem; max-width: 64rem }
h1 { font-size: 1.7rem; line-height: 1.2 } h2 { font-size: 1.3rem; margin-top: 2.5rem; border-bottom: 1px solid #c8ced4 }
p, ul { max-width: 44rem }
a { color: #0b57a4 } nav ul { columns: 18rem; padding-left: 1.2rem }
.scroll { overflow-x: auto } table { border-collapse: collapse; margin: 1rem 0; font-variant-numeric: tabular-nums }
caption { text-align: left; font-weight: 600; padding-bottom: .3rem; max-width: min(44rem, calc(100vw - 2rem)) }
th, td { padding: .2rem .45rem; border-bottom: 1px solid #e2e6ea; text-align: left; vertical-align: top; white-space: nowrap }
th { border-bottom: 2px solid #8a939c; font-weight: 600; white-space: normal; vertical-align: bottom }
th.number, td.number { text-align: right }
figure { margin: 1.2rem 0 } figcaption { max-width: 44rem; color: #3c444c }
.charts { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 25rem), 1fr)); gap: 1rem }
.charts.one { display: block; max-width: 36rem } svg { width: 100%; height: auto; display: block }
.paper { border-left: 4px solid #c98a00; padding-left: .8rem; max-width: 43rem }
@media (max-width: 40rem) { table { font-size: .85rem } th, td { padding: .2rem .25rem } td:not(.number) { white-space: normal }
td:first-child:not(.number) { min-width: 7rem } }
@media print { body { max-width: none; padding: 0; font-size: 10pt } figure, table { break-inside: avoid } h2 { break-after: avoid }
.scroll { overflow: visible } .charts { grid-template-columns: 1fr 1fr } .charts.one { max-width: 14cm } a { color: inherit } }
";

impl Page {
    /// An empty page.
    pub fn new(title: impl Into<String>) -> Self {
        Page { title: title.into(), ..Page::default() }
    }

    /// Begins a section, which is listed in the contents at the top.
    pub fn section(&mut self, heading: &str) {
        let name = slug(heading);
        let _ = writeln!(self.body, "<h2 id=\"{name}\">{}</h2>", escape(heading));
        self.contents.push((name, heading.to_owned()));
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) {
        let _ = writeln!(self.body, "<p>{}</p>", escape(text));
    }

    /// The paragraphs for which there is something to say.
    pub fn paragraphs(&mut self, texts: impl IntoIterator<Item = String>) {
        texts.into_iter().for_each(|text| self.paragraph(&text));
    }

    /// A quotation of the publication, set apart from the results.
    pub fn published(&mut self, text: &str) {
        let _ = writeln!(self.body, "<p class=\"paper\">In the paper: {}</p>", escape(text));
    }

    /// A list of statements.
    pub fn list(&mut self, items: &[String]) {
        let items: Vec<String> = items.iter().map(|item| format!("<li>{}</li>", escape(item))).collect();
        let _ = writeln!(self.body, "<ul>\n{}\n</ul>", items.join("\n"));
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
        let charts: Vec<String> = charts.iter().map(|chart| format!("<div>{chart}</div>")).collect();
        let _ = writeln!(
            self.body,
            "<figure><div class=\"{class}\">\n{}</div>\n<figcaption>{}</figcaption></figure>",
            charts.join("\n"),
            escape(caption)
        );
    }

    /// A paragraph that is a link to a file beside the page.
    pub fn link(&mut self, address: &str, text: &str) {
        let _ = writeln!(self.body, "<p><a href=\"{}\">{}</a></p>", escape(address), escape(text));
    }

    /// A paragraph of links, each with its address and text, after some words; nothing without links.
    pub fn links(&mut self, words: &str, links: &[(String, String)]) {
        if links.is_empty() {
            return;
        }
        let links: Vec<String> = links
            .iter()
            .map(|(address, text)| format!("<a href=\"{}\">{}</a>", escape(address), escape(text)))
            .collect();
        let _ = writeln!(self.body, "<p>{}: {}</p>", escape(words), links.join(", "));
    }

    /// The whole page.
    pub fn html(&self) -> String {
        let title = escape(&self.title);
        let contents: Vec<String> = self
            .contents
            .iter()
            .map(|(name, heading)| format!("<li><a href=\"#{name}\">{}</a></li>", escape(heading)))
            .collect();
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>{title}</title>\n\
             <style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n<nav aria-label=\"Contents\"><ul>\n{}\n</ul></nav>\n\
             <main>\n{}</main>\n</body>\n</html>\n",
            contents.join("\n"),
            self.body
        )
    }
}
