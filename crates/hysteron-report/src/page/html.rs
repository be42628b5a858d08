//! Renders a page as one HTML file that needs nothing else.

use sha2::{Digest, Sha256};

use super::words::breakable;
use super::{Block, NoteKind, Page, table};
use crate::base64;
use crate::escape::escape;
use crate::figure::{Figure, palette};

const STYLE: &str = include_str!("../../assets/report.css");
const SCRIPT: &str = concat!(include_str!("../../assets/zoom.js"), include_str!("../../assets/tools.js"));

/// Sections from which on a page gets a table of contents.
const CONTENTS_FROM: usize = 3;

pub(super) fn render(page: &Page) -> String {
    let mut out = String::with_capacity(64 * 1024);
    let title = escape(&page.title);
    let style = palette::style() + STYLE;
    let contents = contents(page);
    let with_contents = if contents.is_empty() { "" } else { " class=\"with-contents\"" };
    put!(
        out,
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{}\">\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\
         <meta name=\"color-scheme\" content=\"light dark\">\
         <title>{title}</title><style>{style}</style></head>\n<body{with_contents}><header><h1>{}</h1>",
        policy(&style),
        breakable(&page.title)
    );
    if !page.subtitle.is_empty() {
        put!(out, "<p class=\"subtitle\">{}</p>", breakable(&page.subtitle));
    }
    out.push_str("</header>\n");
    out.push_str(&contents);
    out.push_str("<main>\n");
    let mut figures = 0;
    for (i, section) in page.sections.iter().enumerate() {
        put!(out, "<section id=\"s{i}\">");
        if !section.title.is_empty() {
            put!(out, "<h2>{}</h2>", breakable(&section.title));
        }
        for block in &section.blocks {
            render_block(&mut out, block, &mut figures);
        }
        out.push_str("</section>\n");
    }
    out.push_str("</main>\n");
    if !page.footer.is_empty() {
        out.push_str("<footer>");
        for line in &page.footer {
            put!(out, "<p>{}</p>", escape(line));
        }
        out.push_str("</footer>\n");
    }
    // Zoom, saving and copying; without it the page reads the same.
    if !page.sections.is_empty() {
        put!(out, "<script>{SCRIPT}</script>");
    }
    out.push_str("</body></html>\n");
    out
}

/// Links to the sections: at the side of a wide window, folded above the text in a narrow one; empty for a
/// page of few sections.
fn contents(page: &Page) -> String {
    let titled = || page.sections.iter().enumerate().filter(|(_, s)| !s.title.is_empty());
    if titled().count() < CONTENTS_FROM {
        return String::new();
    }
    let links = titled().map(|(i, s)| format!("<a href=\"#s{i}\">{}</a>", breakable(&s.title)));
    let links: String = links.collect();
    format!(
        "<nav class=\"side\" aria-label=\"Contents\">{links}</nav>\n\
         <details class=\"above\"><summary>Contents</summary>\
         <nav aria-label=\"Contents\">{links}</nav></details>\n"
    )
}

/// Nothing may be loaded or sent, and only this style sheet and this script run; a picture may be made of what
/// is on the page.
fn policy(style: &str) -> String {
    let hash = |text: &str| format!("'sha256-{}'", base64::encode(&Sha256::digest(text.as_bytes())));
    format!(
        "default-src 'none'; img-src blob:; style-src {}; script-src {}; base-uri 'none'; form-action 'none'",
        hash(style),
        hash(SCRIPT)
    )
}

fn render_block(out: &mut String, block: &Block, figures: &mut usize) {
    match block {
        Block::Heading(text) => put_tag(out, "h3", text),
        Block::Paragraph(text) => put_tag(out, "p", text),
        Block::Formula(text) => {
            put!(out, "<p class=\"formula\">{}</p>", escape(text));
        }
        Block::Note { kind, text } => {
            let (class, name) = match kind {
                NoteKind::Info => ("info", "Note"),
                NoteKind::Good => ("good", "Checked"),
                NoteKind::Warning => ("warning", "Warning"),
            };
            put!(out, "<p class=\"note {class}\" role=\"note\"><b>{name}</b> {}</p>", breakable(text));
        }
        Block::List(items) => {
            out.push_str("<ul>");
            items.iter().for_each(|item| put_tag(out, "li", item));
            out.push_str("</ul>");
        }
        Block::Highlights(items) => {
            out.push_str("<div class=\"highlights\">");
            for item in items {
                let (label, value, unit) = (escape(&item.label), breakable(&item.value), escape(&item.unit));
                put!(out, "<div><span>{label}</span><strong>{value}<small>{unit}</small></strong></div>");
            }
            out.push_str("</div>");
        }
        Block::KeyValues(pairs) => {
            out.push_str("<dl>");
            for (key, value) in pairs {
                put!(out, "<dt>{}</dt><dd>{}</dd>", breakable(key), breakable(value));
            }
            out.push_str("</dl>");
        }
        Block::Table(content) => table::render(out, content),
        Block::Figure(figure) => {
            *figures += 1;
            render_figure(out, figure, *figures);
        }
        Block::Code(text) => {
            put!(out, "<pre><code>{}</code></pre>", escape(text));
        }
        Block::Details { summary, blocks } => {
            put!(out, "<details><summary>{}</summary>", escape(summary));
            blocks.iter().for_each(|block| render_block(out, block, figures));
            out.push_str("</details>");
        }
    }
    out.push('\n');
}

/// The drawing, for a narrow screen once more, and its caption.
fn render_figure(out: &mut String, figure: &Figure, number: usize) {
    let narrow = figure.to_narrow_svg(&format!("n{number}"));
    let class = if narrow.is_some() { "" } else { " class=\"scrolls\"" };
    put!(out, "<figure id=\"f{number}\"{class}><div class=\"drawing\">");
    out.push_str(&figure.to_inline_svg(&format!("d{number}")));
    out.push_str(&narrow.unwrap_or_default());
    out.push_str("</div>");
    if !figure.caption.is_empty() {
        // A title that brings its own number, as those of a reproduced article do, keeps it.
        let own_number = figure.title.starts_with("Figure ");
        let number = if own_number { String::new() } else { format!("<b>Figure {number}.</b> ") };
        put!(out, "<figcaption>{number}{}</figcaption>", breakable(&figure.caption));
    }
    out.push_str("</figure>");
}

fn put_tag(out: &mut String, tag: &str, text: &str) {
    put!(out, "<{tag}>{}</{tag}>", breakable(text));
}
