//! Renders a page as one HTML file that needs nothing else.

use sha2::{Digest, Sha256};

use super::{Block, NoteKind, Page, table};
use crate::base64;
use crate::escape::escape;

const STYLE: &str = include_str!("../../assets/report.css");
const SCRIPT: &str = include_str!("../../assets/zoom.js");

/// Sections from which on a page gets a table of contents.
const CONTENTS_FROM: usize = 4;

pub(super) fn render(page: &Page) -> String {
    let mut out = String::with_capacity(64 * 1024);
    let title = escape(&page.title);
    put!(
        out,
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{}\">\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\
         <meta name=\"color-scheme\" content=\"light dark\">\
         <title>{title}</title><style>{STYLE}</style></head>\n<body><header><h1>{title}</h1>",
        policy()
    );
    if !page.subtitle.is_empty() {
        put!(out, "<p class=\"subtitle\">{}</p>", escape(&page.subtitle));
    }
    out.push_str("</header>\n");
    let titled: Vec<(usize, &str)> = page
        .sections
        .iter()
        .enumerate()
        .filter(|(_, s)| !s.title.is_empty())
        .map(|(i, s)| (i, s.title.as_str()))
        .collect();
    if titled.len() >= CONTENTS_FROM {
        out.push_str("<nav aria-label=\"Contents\">");
        for (i, title) in titled {
            put!(out, "<a href=\"#s{i}\">{}</a>", escape(title));
        }
        out.push_str("</nav>\n");
    }
    out.push_str("<main>\n");
    let mut figures = 0;
    for (i, section) in page.sections.iter().enumerate() {
        put!(out, "<section id=\"s{i}\">");
        if !section.title.is_empty() {
            put!(out, "<h2>{}</h2>", escape(&section.title));
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
    if figures > 0 {
        put!(out, "<script>{SCRIPT}</script>");
    }
    out.push_str("</body></html>\n");
    out
}

/// Nothing may be loaded or sent; only this style sheet and this script run.
fn policy() -> String {
    let hash = |text: &str| format!("'sha256-{}'", base64::encode(&Sha256::digest(text.as_bytes())));
    format!(
        "default-src 'none'; style-src {}; script-src {}; base-uri 'none'; form-action 'none'",
        hash(STYLE),
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
            put!(out, "<p class=\"note {class}\" role=\"note\"><b>{name}</b> {}</p>", escape(text));
        }
        Block::List(items) => {
            out.push_str("<ul>");
            items.iter().for_each(|item| put_tag(out, "li", item));
            out.push_str("</ul>");
        }
        Block::Highlights(items) => {
            out.push_str("<div class=\"highlights\">");
            for item in items {
                let (label, value, unit) = (escape(&item.label), escape(&item.value), escape(&item.unit));
                put!(out, "<div><span>{label}</span><strong>{value}<small>{unit}</small></strong></div>");
            }
            out.push_str("</div>");
        }
        Block::KeyValues(pairs) => {
            out.push_str("<dl>");
            for (key, value) in pairs {
                put!(out, "<dt>{}</dt><dd>{}</dd>", escape(key), escape(value));
            }
            out.push_str("</dl>");
        }
        Block::Table(content) => table::render(out, content),
        Block::Figure(figure) => {
            *figures += 1;
            put!(out, "<figure id=\"f{figures}\">{}", figure.to_inline_svg(&format!("f{figures}")));
            if !figure.caption.is_empty() {
                // A title that brings its own number, as those of a reproduced article do, keeps it.
                let own_number = figure.title.starts_with("Figure ");
                let number = if own_number { String::new() } else { format!("<b>Figure {figures}.</b> ") };
                put!(out, "<figcaption>{number}{}</figcaption>", escape(&figure.caption));
            }
            out.push_str("</figure>");
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

fn put_tag(out: &mut String, tag: &str, text: &str) {
    put!(out, "<{tag}>{}</{tag}>", escape(text));
}
