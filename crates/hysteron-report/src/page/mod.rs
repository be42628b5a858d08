//! Pages as data: sections of paragraphs, notes, tables, figures and code, rendered as one HTML file.
//!
//! Every text given here is plain text; the renderer escapes it. The file loads nothing: style, script and
//! data are inside, and its content security policy forbids the network.
//!
//! ```
//! use hysteron_report::page::{Block, Page, Section};
//! let page = Page::new("Stack 7").section(
//!     Section::new("Result").block(Block::paragraph("The loop runs counter-clockwise.")),
//! );
//! assert!(page.to_html().starts_with("<!doctype html>"));
//! ```

mod csv;
mod html;
mod table;
mod words;

use crate::figure::Figure;
pub use table::{Align, Cell, Column, Row, Table};

/// One HTML file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Page {
    /// Title of the page and of the browser's tab.
    pub title: String,
    /// A line under the title.
    pub subtitle: String,
    /// Small print at the end, one line each: program version, date.
    pub footer: Vec<String>,
    /// Content.
    pub sections: Vec<Section>,
}

impl Page {
    /// An empty page.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), ..Self::default() }
    }

    /// Sets the line under the title.
    #[must_use]
    pub fn subtitled(mut self, subtitle: impl Into<String>) -> Self {
        self.subtitle = subtitle.into();
        self
    }

    /// Adds a line of small print.
    #[must_use]
    pub fn footer_line(mut self, line: impl Into<String>) -> Self {
        self.footer.push(line.into());
        self
    }

    /// Adds a section; one without content is left out.
    #[must_use]
    pub fn section(mut self, section: Section) -> Self {
        if !section.blocks.is_empty() {
            self.sections.push(section);
        }
        self
    }

    /// The page as HTML text. The same page always gives the same bytes.
    pub fn to_html(&self) -> String {
        html::render(self)
    }

    /// Every figure of the page in order, those inside details too, e.g. to write each as an SVG file.
    pub fn figures(&self) -> Vec<&Figure> {
        fn collect<'a>(blocks: &'a [Block], found: &mut Vec<&'a Figure>) {
            for block in blocks {
                match block {
                    Block::Figure(figure) => found.push(figure),
                    Block::Details { blocks, .. } => collect(blocks, found),
                    _ => {}
                }
            }
        }
        let mut found = Vec::new();
        self.sections.iter().for_each(|section| collect(&section.blocks, &mut found));
        found
    }
}

/// A heading with its content.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Section {
    /// Heading; an empty one is not shown.
    pub title: String,
    /// Content in order.
    pub blocks: Vec<Block>,
}

impl Section {
    /// An empty section.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), blocks: Vec::new() }
    }

    /// Adds a block.
    #[must_use]
    pub fn block(mut self, block: impl Into<Block>) -> Self {
        self.blocks.push(block.into());
        self
    }

    /// Adds blocks.
    #[must_use]
    pub fn blocks<B: Into<Block>>(mut self, blocks: impl IntoIterator<Item = B>) -> Self {
        self.blocks.extend(blocks.into_iter().map(Into::into));
        self
    }
}

/// Weight of a note.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoteKind {
    /// Worth knowing.
    Info,
    /// A check that passed.
    Good,
    /// The reader may draw a wrong conclusion without it.
    Warning,
}

/// One of the key figures of a page.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Highlight {
    /// Name of the quantity.
    pub label: String,
    /// The number, formatted.
    pub value: String,
    /// Its unit; may be empty.
    pub unit: String,
}

impl Highlight {
    /// A labelled number with its unit.
    pub fn new(label: impl Into<String>, value: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { label: label.into(), value: value.into(), unit: unit.into() }
    }
}

/// A piece of content.
#[derive(Debug, Clone, PartialEq)]
pub enum Block {
    /// A subheading.
    Heading(String),
    /// Running text.
    Paragraph(String),
    /// A remark set apart.
    Note {
        /// Its weight.
        kind: NoteKind,
        /// Plain words.
        text: String,
    },
    /// A list of short statements.
    List(Vec<String>),
    /// The key figures.
    Highlights(Vec<Highlight>),
    /// Names and values, one pair a line.
    KeyValues(Vec<(String, String)>),
    /// A table.
    Table(Table),
    /// A figure, zoomable.
    Figure(Figure),
    /// Text to be copied, e.g. a command line.
    Code(String),
    /// A formula, set apart.
    Formula(String),
    /// Content behind a summary line, opened by a click (and always open in print).
    Details {
        /// The line that is always visible.
        summary: String,
        /// The content that it opens.
        blocks: Vec<Block>,
    },
}

impl Block {
    /// Running text.
    pub fn paragraph(text: impl Into<String>) -> Self {
        Self::Paragraph(text.into())
    }

    /// A remark worth knowing.
    pub fn info(text: impl Into<String>) -> Self {
        Self::Note { kind: NoteKind::Info, text: text.into() }
    }

    /// A remark without which the reader may draw a wrong conclusion.
    pub fn warning(text: impl Into<String>) -> Self {
        Self::Note { kind: NoteKind::Warning, text: text.into() }
    }

    /// A check that passed.
    pub fn good(text: impl Into<String>) -> Self {
        Self::Note { kind: NoteKind::Good, text: text.into() }
    }

    /// A list of short statements.
    pub fn list(items: impl IntoIterator<Item = impl Into<String>>) -> Self {
        Self::List(items.into_iter().map(Into::into).collect())
    }

    /// Names and values.
    pub fn key_values<K: Into<String>, V: Into<String>>(pairs: impl IntoIterator<Item = (K, V)>) -> Self {
        Self::KeyValues(pairs.into_iter().map(|(k, v)| (k.into(), v.into())).collect())
    }

    /// Text to be copied.
    pub fn code(text: impl Into<String>) -> Self {
        Self::Code(text.into())
    }

    /// Content behind a summary line.
    pub fn details(summary: impl Into<String>, blocks: Vec<Self>) -> Self {
        Self::Details { summary: summary.into(), blocks }
    }
}

impl From<Table> for Block {
    fn from(table: Table) -> Self {
        Self::Table(table)
    }
}

impl From<Figure> for Block {
    fn from(figure: Figure) -> Self {
        Self::Figure(figure)
    }
}
