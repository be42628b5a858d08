//! Tables: columns with units, numbers aligned at the decimal point, groups of columns, notes.

use super::words::breakable;
use crate::escape::escape;

/// Alignment of a column's cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Align {
    /// Text.
    #[default]
    Left,
    /// Numbers, aligned at the decimal point.
    Decimal,
    /// Short marks.
    Centre,
}

/// A column.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Column {
    /// Heading.
    pub header: String,
    /// Unit shown under the heading; may be empty.
    pub unit: String,
    /// Alignment of its cells.
    pub align: Align,
}

impl Column {
    /// A column of text.
    pub fn text(header: impl Into<String>) -> Self {
        Self { header: header.into(), ..Self::default() }
    }

    /// A column of numbers in `unit`.
    pub fn number(header: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { header: header.into(), unit: unit.into(), align: Align::Decimal }
    }
}

/// A cell.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Cell {
    /// Text, or a formatted number.
    pub text: String,
    /// Set in bold: the best of its kind, or the subject of the text.
    pub strong: bool,
    /// Set in grey: printed elsewhere, or not comparable.
    pub quiet: bool,
    /// File that the text is a link to, relative to the page; empty for none.
    pub link: String,
}

impl Cell {
    /// A plain cell.
    pub fn new(text: impl Into<String>) -> Self {
        Self { text: text.into(), ..Self::default() }
    }

    /// A cell in bold.
    pub fn strong(text: impl Into<String>) -> Self {
        Self { text: text.into(), strong: true, ..Self::default() }
    }

    /// A cell in grey.
    pub fn quiet(text: impl Into<String>) -> Self {
        Self { text: text.into(), quiet: true, ..Self::default() }
    }

    /// A cell that is a link to a file, relative to the page.
    pub fn linked(text: impl Into<String>, link: impl Into<String>) -> Self {
        Self { text: text.into(), link: link.into(), ..Self::default() }
    }
}

impl<T: Into<String>> From<T> for Cell {
    fn from(text: T) -> Self {
        Self::new(text)
    }
}

/// A row.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Row {
    /// One cell for each column; missing ones stay empty, surplus ones are dropped.
    pub cells: Vec<Cell>,
    /// Shaded, to be found at a glance.
    pub highlight: bool,
}

/// A table.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// Text above the table; may be empty.
    pub caption: String,
    /// Headings over several columns: text and number of columns, from the left; may be empty.
    pub groups: Vec<(String, usize)>,
    /// Columns.
    pub columns: Vec<Column>,
    /// Rows.
    pub rows: Vec<Row>,
    /// Text under the table, one paragraph each: definitions, sources.
    pub notes: Vec<String>,
}

impl Table {
    /// A table without rows.
    pub fn new(columns: impl IntoIterator<Item = Column>) -> Self {
        Self { columns: columns.into_iter().collect(), ..Self::default() }
    }

    /// Sets the caption.
    #[must_use]
    pub fn captioned(mut self, caption: impl Into<String>) -> Self {
        self.caption = caption.into();
        self
    }

    /// Adds a heading over the next `columns` columns.
    #[must_use]
    pub fn group(mut self, heading: impl Into<String>, columns: usize) -> Self {
        self.groups.push((heading.into(), columns));
        self
    }

    /// Adds a row.
    #[must_use]
    pub fn row<C: Into<Cell>>(mut self, cells: impl IntoIterator<Item = C>) -> Self {
        self.rows.push(Row { cells: cells.into_iter().map(Into::into).collect(), highlight: false });
        self
    }

    /// Adds a shaded row.
    #[must_use]
    pub fn highlighted_row<C: Into<Cell>>(mut self, cells: impl IntoIterator<Item = C>) -> Self {
        self.rows.push(Row { cells: cells.into_iter().map(Into::into).collect(), highlight: true });
        self
    }

    /// Adds a note under the table.
    #[must_use]
    pub fn note(mut self, text: impl Into<String>) -> Self {
        self.notes.push(text.into());
        self
    }
}

/// Tables of up to this many rows, all of them low, are not broken over printed pages.
const UNBROKEN_ROWS: usize = 14;

/// Appends the HTML of a table.
pub(super) fn render(out: &mut String, table: &Table) {
    let tall = |cell: &Cell| cell.text.chars().count() > LONG;
    let low = !table.rows.iter().any(|row| row.cells.iter().any(tall));
    let short = if low && table.rows.len() <= UNBROKEN_ROWS { " short" } else { "" };
    put!(out, "<div class=\"table{short}\"");
    // For the button that copies it, which the script adds.
    if !table.rows.is_empty() {
        put!(out, " data-csv=\"{}\"", escape(&table.to_csv()));
    }
    out.push_str("><div class=\"wide\"><table>");
    if !table.caption.is_empty() {
        put!(out, "<caption>{}</caption>", breakable(&table.caption));
    }
    out.push_str("<thead>");
    if !table.groups.is_empty() {
        out.push_str("<tr class=\"groups\">");
        for (heading, columns) in &table.groups {
            let columns = columns.max(&1);
            if heading.is_empty() {
                put!(out, "<td colspan=\"{columns}\"></td>");
            } else {
                let heading = breakable(heading);
                put!(out, "<th colspan=\"{columns}\" scope=\"colgroup\" class=\"group\">{heading}</th>");
            }
        }
        out.push_str("</tr>");
    }
    out.push_str("<tr>");
    for column in &table.columns {
        put!(out, "<th scope=\"col\"{}>{}", class(column.align), breakable(&column.header));
        if !column.unit.is_empty() {
            put!(out, "<small>{}</small>", escape(&column.unit));
        }
        out.push_str("</th>");
    }
    out.push_str("</tr></thead><tbody>");
    let decimals: Vec<usize> = (0..table.columns.len())
        .map(|c| {
            table
                .rows
                .iter()
                .filter_map(|r| r.cells.get(c))
                .map(|cell| fraction(&cell.text))
                .max()
                .unwrap_or(0)
        })
        .collect();
    let empty = Cell::default();
    for row in &table.rows {
        out.push_str(if row.highlight { "<tr class=\"highlight\">" } else { "<tr>" });
        for (c, column) in table.columns.iter().enumerate() {
            let cell = row.cells.get(c).unwrap_or(&empty);
            let emphasis = match (cell.strong, cell.quiet) {
                (true, _) => ("<b>", "</b>"),
                (_, true) => ("<span class=\"quiet\">", "</span>"),
                _ => ("", ""),
            };
            put!(out, "<td{}>{}", cell_class(column.align, &cell.text), emphasis.0);
            if cell.link.is_empty() {
                put!(out, "{}", breakable(&cell.text));
            } else {
                put!(out, "<a href=\"{}\">{}</a>", file_link(&cell.link), breakable(&cell.text));
            }
            out.push_str(emphasis.1);
            if column.align == Align::Decimal && is_number(&cell.text) {
                pad(out, decimals[c] - fraction(&cell.text), fraction(&cell.text) == 0);
            }
            out.push_str("</td>");
        }
        out.push_str("</tr>");
    }
    out.push_str("</tbody></table></div>");
    for note in &table.notes {
        put!(out, "<p class=\"tablenote\">{}</p>", escape(note));
    }
    out.push_str("</div>");
}

/// Path as a relative link (RFC 3986): with every other character encoded it has no scheme.
fn file_link(path: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'/' | b'-' | b'_' | b'.' | b'~');
    let encoded = |byte: u8| if plain(byte) { (byte as char).to_string() } else { format!("%{byte:02X}") };
    path.bytes().map(encoded).collect()
}

fn class(align: Align) -> &'static str {
    match align {
        Align::Left => "",
        Align::Decimal => " class=\"n\"",
        Align::Centre => " class=\"c\"",
    }
}

/// Cells up to this many characters are kept on one line, those beyond that many get a column that is wide
/// enough to be read.
const SHORT: usize = 16;
const LONG: usize = 48;

fn cell_class(align: Align, text: &str) -> &'static str {
    match align {
        Align::Left if text.contains(' ') && text.chars().count() <= SHORT => " class=\"w\"",
        Align::Left if text.chars().count() > LONG => " class=\"l\"",
        other => class(other),
    }
}

/// Whether a cell holds one plain number.
pub(super) fn is_number(text: &str) -> bool {
    !text.is_empty()
        && text
            .chars()
            .all(|c| c.is_ascii_digit() || matches!(c, '.' | '-' | '−' | '+' | '\u{2009}' | '\u{202f}'))
        && text.chars().any(|c| c.is_ascii_digit())
}

/// Digits after the decimal point of a cell that holds one plain number.
fn fraction(text: &str) -> usize {
    match text.split_once('.') {
        Some((_, rest)) if is_number(text) => rest.chars().count(),
        _ => 0,
    }
}

/// Blanks as wide as `digits` digits (and a decimal point), so that points stand under each other.
fn pad(out: &mut String, digits: usize, point: bool) {
    if digits > 0 && point {
        out.push('\u{2008}');
    }
    (0..digits).for_each(|_| out.push('\u{2007}'));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_points_stand_under_each_other() {
        let table =
            Table::new([Column::number("RMSE", "µm")]).row(["0.125"]).row(["12.5"]).row(["3"]).row(["—"]);
        let mut html = String::new();
        render(&mut html, &table);
        assert!(html.contains(">0.125</td>"));
        assert!(html.contains(">12.5\u{2007}\u{2007}</td>"));
        assert!(html.contains(">3\u{2008}\u{2007}\u{2007}\u{2007}</td>"));
        assert!(html.contains(">—</td>"));
    }

    #[test]
    fn rows_of_the_wrong_length_keep_the_table_rectangular() {
        let table = Table::new([Column::text("a"), Column::text("b")]).row(["1"]).row(["1", "2", "3"]);
        let mut html = String::new();
        render(&mut html, &table);
        assert_eq!(html.matches("<td>").count(), 4);
    }
}
