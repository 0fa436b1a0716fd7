//! Tables, with rounded numbers for people and all digits for other programs.

use std::fmt::Write;

use super::markup::{escape, joined};

/// One entry of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Text.
    Text(String),
    /// A count.
    Count(usize),
    /// A number, with the number of decimals shown to people.
    Number(f64, usize),
    /// A difference, always with its sign, with the number of decimals shown to people.
    Difference(f64, usize),
    /// An unknown value.
    Missing,
}

/// A table with a name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Name of its CSV file, without the extension.
    pub name: String,
    /// One line above it.
    pub caption: String,
    /// Headings of the columns, with units.
    pub columns: Vec<String>,
    /// The entries, row by row.
    pub rows: Vec<Vec<Cell>>,
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Cell::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Cell::Text(text)
    }
}

impl From<Option<usize>> for Cell {
    fn from(count: Option<usize>) -> Self {
        count.map_or(Cell::Missing, Cell::Count)
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Self {
        Cell::Count(count)
    }
}

impl Cell {
    /// A number that may be missing.
    pub fn optional(value: Option<f64>, decimals: usize) -> Self {
        value.map_or(Cell::Missing, |value| Cell::Number(value, decimals))
    }

    /// The text shown to people.
    pub fn text(&self) -> String {
        match self {
            Cell::Text(text) => text.clone(),
            Cell::Count(count) => count.to_string(),
            Cell::Number(value, decimals) if value.is_finite() => format!("{value:.decimals$}"),
            Cell::Difference(value, decimals) if value.is_finite() => format!("{value:+.decimals$}"),
            Cell::Number(..) | Cell::Difference(..) | Cell::Missing => "–".into(),
        }
    }

    fn csv(&self) -> String {
        match self {
            Cell::Text(text) if text.contains([',', '"', '\n', '\r']) => format!("\"{}\"", text.replace('"', "\"\"")),
            Cell::Text(text) => text.clone(),
            Cell::Count(count) => count.to_string(),
            Cell::Number(value, _) | Cell::Difference(value, _) if value.is_finite() => value.to_string(),
            Cell::Number(..) | Cell::Difference(..) | Cell::Missing => String::new(),
        }
    }
}

/// A table of things, one in each row, that is filled column by column.
///
/// ```
/// use underbrush_report::drawing::Rows;
///
/// let reaches = [("leaf", 0.981), ("trunk", 0.667)];
/// let table = Rows::of(reaches).column("scene", |own| own.0).percent("goals / %", 1, |own| own.1);
/// assert!(table.text().contains("98.1"));
/// ```
#[derive(Clone, Debug)]
pub struct Rows<T> {
    things: Vec<T>,
    table: Table,
}

impl<T: Copy> Rows<T> {
    /// A row for each of these things, still without columns.
    pub fn of(things: impl IntoIterator<Item = T>) -> Self {
        let things: Vec<T> = things.into_iter().collect();
        let rows = vec![Vec::new(); things.len()];
        Rows { things, table: Table { rows, ..Table::default() } }
    }

    /// The things.
    pub fn things(&self) -> impl Iterator<Item = T> {
        self.things.iter().copied()
    }

    /// Adds a column.
    pub fn column<C: Into<Cell>>(self, heading: impl Into<String>, entry: impl Fn(T) -> C) -> Self {
        self.columns([heading], |thing| [entry(thing)])
    }

    /// Adds several columns at once.
    pub fn columns<E: IntoIterator<Item: Into<Cell>>>(
        mut self,
        headings: impl IntoIterator<Item: Into<String>>,
        entries: impl Fn(T) -> E,
    ) -> Self {
        self.table.columns.extend(headings.into_iter().map(Into::into));
        for (row, thing) in self.table.rows.iter_mut().zip(&self.things) {
            row.extend(entries(*thing).into_iter().map(Into::into));
        }
        self
    }

    /// Adds a column of numbers that may be missing, with the number of decimals shown to people.
    pub fn number<N: Into<Option<f64>>>(
        self,
        heading: impl Into<String>,
        decimals: usize,
        value: impl Fn(T) -> N,
    ) -> Self {
        self.column(heading, |thing| Cell::optional(value(thing).into(), decimals))
    }

    /// Adds a column of shares that may be missing, in per cent.
    pub fn percent<N: Into<Option<f64>>>(
        self,
        heading: impl Into<String>,
        decimals: usize,
        share: impl Fn(T) -> N,
    ) -> Self {
        self.number(heading, decimals, |thing| share(thing).into().map(|share| 100.0 * share))
    }

    /// Adds columns only if there is something to show in them.
    pub fn when(self, is_given: bool, add: impl FnOnce(Self) -> Self) -> Self {
        if is_given { add(self) } else { self }
    }

    /// The rows as a table for a terminal.
    ///
    /// ```
    /// use underbrush_report::drawing::Rows;
    ///
    /// let rows = Rows::of([("leaf", 7_usize), ("trunk", 12)]).column("category", |row| row.0).column("trials", |row| row.1);
    /// assert_eq!(rows.text().lines().last(), Some("trunk         12"));
    /// ```
    pub fn text(self) -> String {
        self.table("", "").first_columns(usize::MAX)
    }

    /// The finished table.
    pub fn table(self, name: &str, caption: impl Into<String>) -> Table {
        Table { name: name.into(), caption: caption.into(), ..self.table }
    }
}

impl Table {
    /// The rows as shown to people.
    pub fn texts(&self) -> Vec<Vec<String>> {
        self.rows.iter().map(|row| row.iter().map(Cell::text).collect()).collect()
    }

    /// The first columns, for a terminal, each padded to its widest entry. The first column is aligned left, the
    /// others right.
    pub fn first_columns(&self, columns: usize) -> String {
        let mut lines = [vec![self.columns.clone()], self.texts()].concat();
        lines.iter_mut().for_each(|line| line.truncate(columns));
        let width = |column: usize| {
            let entries = lines.iter().filter_map(|line| line.get(column));
            entries.map(|entry| entry.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..lines[0].len()).map(width).collect();
        let padded = |line: &Vec<String>| {
            let cells = line.iter().zip(&widths).enumerate().map(|(column, (cell, width))| {
                if column == 0 { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
            });
            joined(cells, "  ").trim_end().to_string() + "\n"
        };
        let rule = joined(widths.iter().map(|width| "-".repeat(*width)), "  ");
        padded(&lines[0]) + &rule + "\n" + &lines[1..].iter().map(padded).collect::<String>()
    }

    /// The table as CSV (RFC 4180), with a header and all digits. Missing values and those that are not finite are
    /// empty.
    pub fn csv(&self) -> String {
        let header: Vec<Cell> = self.columns.iter().map(|column| Cell::from(column.as_str())).collect();
        let rows = std::iter::once(&header).chain(&self.rows);
        rows.map(|row| joined(row.iter().map(Cell::csv), ",") + "\n").collect()
    }

    /// The table with unique headings, for programs that find columns by name. Before a heading that occurs more than once stands the
    /// last unique heading before it: `touched trials: accuracy / %`.
    #[must_use]
    pub fn with_own_headings(mut self) -> Self {
        let (all, mut group) = (self.columns.clone(), "");
        for (own, heading) in self.columns.iter_mut().zip(&all) {
            if all.iter().filter(|other| *other == heading).count() == 1 {
                group = heading.as_str();
            } else {
                *own = format!("{group}: {heading}");
            }
        }
        self
    }

    fn is_numeric(&self, column: usize) -> bool {
        let mut cells = self.rows.iter().filter_map(|row| row.get(column));
        cells.any(|cell| !matches!(cell, Cell::Text(_) | Cell::Missing))
    }

    /// The table as HTML, which scrolls sideways if it does not fit.
    pub fn html(&self) -> String {
        let caption = escape(&self.caption);
        // A wide table is scrolled by keys, too.
        let mut html = format!("<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{caption}\">");
        let _ = write!(html, "<table><caption>{caption}</caption>\n<thead><tr>");
        // Columns of numbers are aligned right, with their headings and any words in them; columns of text are aligned
        // left.
        let class = |column: usize| if self.is_numeric(column) { " class=\"number\"" } else { "" };
        for (column, heading) in self.columns.iter().enumerate() {
            let cell = if heading.is_empty() { "td" } else { "th scope=\"col\"" };
            let _ = write!(html, "<{cell}{}>{}</{}>", class(column), escape(heading), &cell[..2]);
        }
        html += "</tr></thead>\n<tbody>\n";
        for row in &self.rows {
            html += "<tr>";
            for (column, cell) in row.iter().enumerate() {
                let _ = write!(html, "<td{}>{}</td>", class(column), escape(&cell.text()));
            }
            html += "</tr>\n";
        }
        html + "</tbody></table></div>\n"
    }
}
