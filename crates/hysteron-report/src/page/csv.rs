//! Tables as comma-separated values (RFC 4180), to be opened by a spreadsheet.

use super::Table;
use super::table::is_number;

impl Table {
    /// The table as comma-separated values: one line of headings with their units, then the rows.
    ///
    /// Numbers are written plain (`-12000.5` for `−12 000.5`), missing ones as empty cells. A text that a
    /// spreadsheet would take for a formula (it begins with `=`, `+`, `-` or `@`) gets a leading apostrophe.
    pub fn to_csv(&self) -> String {
        let mut out = String::new();
        let mut groups =
            self.groups.iter().flat_map(|(heading, n)| std::iter::repeat_n(heading, (*n).max(1)));
        let headings = self.columns.iter().map(|column| {
            let group = groups.next().filter(|group| !group.is_empty());
            let unit = if column.unit.is_empty() { String::new() } else { format!(" ({})", column.unit) };
            let group = group.map(|group| format!("{group}: ")).unwrap_or_default();
            format!("{group}{}{unit}", column.header)
        });
        push_line(&mut out, headings);
        for row in &self.rows {
            let cell = |c: usize| row.cells.get(c).map_or("", |cell| cell.text.as_str());
            push_line(&mut out, (0..self.columns.len()).map(|c| cell(c).to_owned()));
        }
        out
    }
}

fn push_line(out: &mut String, cells: impl Iterator<Item = String>) {
    for (i, text) in cells.enumerate() {
        if i > 0 {
            out.push(',');
        }
        let text = plain(&text);
        if text.contains([',', '"', '\n', '\r']) {
            put!(out, "\"{}\"", text.replace('"', "\"\""));
        } else {
            out.push_str(&text);
        }
    }
    out.push_str("\r\n");
}

/// A cell's text without what is only for the eye.
fn plain(text: &str) -> String {
    let text: String = text.replace('\u{a0}', " ").replace('\u{200b}', "");
    if matches!(text.trim(), "-" | "–" | "—") {
        return String::new();
    }
    if is_number(&text) {
        return text.replace('−', "-").replace(['\u{2009}', '\u{202f}'], "");
    }
    match text.trim_start().chars().next() {
        Some('=' | '+' | '-' | '@') => format!("'{text}"),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use crate::page::{Column, Table};

    #[test]
    fn numbers_are_plain_and_texts_stay_texts() {
        let table = Table::new([Column::text("record"), Column::number("RMSE", "µm")])
            .row(["a, \"b\"", "−12\u{2009}000.5"])
            .row(["=HYPERLINK(\"x\")", "—"])
            .row(["<b>@</b>", "+1"])
            .row(["@x", "-1e+3|cmd"])
            .row(["only"]);
        assert_eq!(
            table.to_csv(),
            "record,RMSE (µm)\r\n\"a, \"\"b\"\"\",-12000.5\r\n\"'=HYPERLINK(\"\"x\"\")\",\r\n\
             <b>@</b>,+1\r\n'@x,'-1e+3|cmd\r\nonly,\r\n"
        );
    }

    #[test]
    fn headings_carry_their_groups() {
        let table = Table::new([Column::text("f"), Column::number("max", "µm"), Column::number("max", "µm")])
            .group("", 1)
            .group("printed", 1)
            .group("here", 1);
        assert_eq!(table.to_csv(), "f,printed: max (µm),here: max (µm)\r\n");
    }
}
