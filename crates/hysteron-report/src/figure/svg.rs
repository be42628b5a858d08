//! Writes a laid-out figure as SVG.
//!
//! Colours stand as presentation attributes (so that any converter draws them) and as classes (so that a page
//! can replace them on a dark background). A drawing for a page also carries its data in `data-` attributes;
//! `assets/zoom.js` reads them and redraws axes and curves. The drawing for narrow screens has none: it
//! stands beside the wide one.

use super::curves::{self, Detail, Swatch};
use super::layout::{
    Layout, LegendEntry, NAME_LINE, PANEL_TITLE, PlacedAxis, PlacedPanel, SMALL, SWATCH, Sheet, TITLE,
    TITLE_LINE, layout,
};
use super::palette::{GRID, INK, MINOR, SOFT, SPAN};
use super::text::{FONT_FAMILY, fit, number, width};
use super::{Figure, Panel, Scale};
use super::{heat, names};
use crate::escape::escape;

/// Use of the drawing.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Use<'a> {
    /// A stand-alone file.
    StandAlone,
    /// An element of a page; `id` makes its references unique there.
    Inline { id: &'a str },
    /// An element of a page for narrow screens.
    Narrow { id: &'a str },
}

impl Use<'_> {
    fn id(&self) -> &str {
        match self {
            Self::StandAlone => "figure",
            Self::Inline { id } | Self::Narrow { id } => id,
        }
    }

    fn interactive(&self) -> bool {
        !matches!(self, Self::StandAlone)
    }

    fn detail(&self, zoomable: bool) -> Detail {
        match self {
            Self::Inline { .. } if zoomable => Detail::Stored,
            Self::Inline { .. } | Self::StandAlone => Detail::Fine,
            Self::Narrow { .. } => Detail::Coarse,
        }
    }

    fn sheet(&self) -> Sheet {
        if matches!(self, Self::Narrow { .. }) { Sheet::Narrow } else { Sheet::Wide }
    }

    /// Class of the drawing on a page.
    fn class(&self) -> &'static str {
        if matches!(self, Self::Narrow { .. }) { "figure narrow" } else { "figure" }
    }
}

/// The SVG of a figure.
pub(crate) fn draw(figure: &Figure, purpose: Use<'_>) -> String {
    let plan = layout(figure, purpose.sheet());
    let mut out = String::new();
    let (w, h) = (number(plan.width), number(plan.height));
    put!(out, "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\"");
    match purpose {
        Use::StandAlone => {
            put!(out, " width=\"{w}\" height=\"{h}\"");
        }
        Use::Inline { .. } | Use::Narrow { .. } => {
            put!(
                out,
                " class=\"{}\" role=\"img\" width=\"{w}\" height=\"{h}\"{}",
                purpose.class(),
                if figure.linked_x { " data-link=\"x\"" } else { "" }
            );
        }
    }
    put!(out, " font-family=\"{FONT_FAMILY}\" font-size=\"{SMALL}\" fill=\"{}\">", INK.light);
    put!(out, "<title>{}</title>", escape(&figure.title));
    if !figure.caption.is_empty() && !purpose.interactive() {
        put!(out, "<desc>{}</desc>", escape(&figure.caption));
    }
    if !purpose.interactive() {
        out.push_str("<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>");
    }
    heading(&mut out, &plan);
    for entry in &plan.legend {
        legend_entry(&mut out, entry);
    }
    for (index, (panel, placed)) in figure.panels.iter().zip(&plan.panels).enumerate() {
        draw_panel(&mut out, panel, placed, &format!("{}-{index}", purpose.id()), purpose);
    }
    out.push_str("</svg>");
    out
}

fn heading(out: &mut String, plan: &Layout) {
    for (line, title) in plan.title.iter().enumerate() {
        let (y, title) = (number(plan.title_y + line as f64 * TITLE_LINE), escape(title));
        put!(
            out,
            "<text class=\"t\" x=\"2\" y=\"{y}\" font-size=\"{TITLE}\" font-weight=\"600\">{title}</text>"
        );
    }
    if !plan.subtitle.is_empty() {
        let (y, text, soft) = (number(plan.subtitle_y), escape(&plan.subtitle), SOFT.light);
        put!(out, "<text class=\"t2\" x=\"2\" y=\"{y}\" fill=\"{soft}\">{text}</text>");
    }
}

fn legend_entry(out: &mut String, entry: &LegendEntry) {
    let y = entry.y - 4.0;
    curves::swatch(out, &Swatch { sample: entry.sample, x: entry.x, y, length: SWATCH });
    let (x, y, label) = (number(entry.x + SWATCH + 6.0), number(entry.y), escape(&entry.label));
    put!(out, "<text class=\"t\" x=\"{x}\" y=\"{y}\">{label}</text>");
}

/// The attribute that describes an axis to the script: scale, limits, label exponent, tick limit, labels
/// shown.
fn axis_data(axis: &PlacedAxis, labels: bool) -> String {
    let scale = if axis.scale == Scale::Log { "log" } else { "lin" };
    let (low, high, e, limit) = (axis.low, axis.high, axis.ticks.exponent, axis.limit);
    format!("{scale} {low:e} {high:e} {e} {limit} {}", u8::from(labels))
}

fn draw_panel(out: &mut String, panel: &Panel, placed: &PlacedPanel, id: &str, purpose: Use<'_>) {
    let f = placed.frame;
    let zoomable = purpose.interactive()
        && placed.has_data
        && !placed.x.categorical
        && !placed.y.categorical
        && !curves::has_bars(panel)
        && !names::has_names(panel);
    let [x, y, w, h] = [f.x, f.y, f.w, f.h].map(number);
    out.push_str("<g class=\"panel\"");
    if zoomable {
        let (ax, ay) = (axis_data(&placed.x, placed.show_x_labels), axis_data(&placed.y, true));
        put!(out, " data-frame=\"{x} {y} {w} {h}\" data-x=\"{ax}\" data-y=\"{ay}\"");
    }
    out.push('>');
    put!(out, "<clipPath id=\"{id}c\"><rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"/></clipPath>");
    spans(out, panel, placed);
    if placed.has_data {
        axes(out, placed);
        put!(out, "<g clip-path=\"url(#{id}c)\">");
        heat::draw(out, &panel.cells, placed);
        curves::draw(out, panel, placed, purpose.detail(zoomable));
        out.push_str("</g>");
        names::draw(out, panel, placed);
    } else {
        let (cx, cy) = (number(f.x + f.w / 2.0), number(f.y + f.h / 2.0 + 4.0));
        put!(
            out,
            "<text class=\"t2\" x=\"{cx}\" y=\"{cy}\" fill=\"{}\" text-anchor=\"middle\">no data</text>",
            SOFT.light
        );
    }
    put!(
        out,
        "<rect class=\"frame\" x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" fill=\"none\" \
         stroke=\"{}\"/>",
        SOFT.light
    );
    panel_texts(out, placed);
    out.push_str("</g>");
}

/// Title, axis titles and legend of a panel.
fn panel_texts(out: &mut String, placed: &PlacedPanel) {
    let f = placed.frame;
    if !placed.title.is_empty() {
        let (x, y, title) = (number(f.x), number(placed.title_y), escape(&placed.title));
        put!(
            out,
            "<text class=\"t\" x=\"{x}\" y=\"{y}\" font-size=\"{PANEL_TITLE}\" \
             font-weight=\"600\">{title}</text>"
        );
    }
    if placed.show_x_labels && !placed.x.title.is_empty() {
        let (x, y) = (number(f.x + f.w / 2.0), number(f.y + f.h + 36.0));
        let title = escape(&fit(&placed.x.title, SMALL, f.w + 40.0));
        put!(out, "<text class=\"t\" x=\"{x}\" y=\"{y}\" text-anchor=\"middle\">{title}</text>");
    }
    if !placed.y.title.is_empty() {
        let (x, y) = (number(placed.y_title_x), number(f.y + f.h / 2.0));
        let title = escape(&fit(&placed.y.title, SMALL, f.h + 30.0));
        put!(
            out,
            "<text class=\"t\" transform=\"translate({x} {y}) rotate(-90)\" \
             text-anchor=\"middle\">{title}</text>"
        );
    }
    for entry in &placed.legend {
        legend_entry(out, entry);
    }
}

/// Grid, tick marks and tick labels. The script replaces the content of the groups `grid`, `tx` and `ty`.
fn axes(out: &mut String, placed: &PlacedPanel) {
    let f = placed.frame;
    let at_x = |value: f64| f.x + placed.x.fraction(value) * f.w;
    let at_y = |value: f64| f.y + f.h - placed.y.fraction(value) * f.h;
    let (mut grid, mut faint, mut marks) = (String::new(), String::new(), String::new());
    let vertical = |path: &mut String, value: f64, from: f64, to: f64| {
        put!(path, "M{} {}V{}", number(at_x(value)), number(from), number(to));
    };
    let horizontal = |path: &mut String, value: f64, from: f64, to: f64| {
        put!(path, "M{} {}H{}", number(from), number(at_y(value)), number(to));
    };
    let bottom = f.y + f.h;
    for value in &placed.x.ticks.major {
        if !placed.x.categorical {
            vertical(&mut grid, *value, f.y, bottom);
            vertical(&mut marks, *value, bottom, bottom + 5.0);
        }
    }
    for value in &placed.x.ticks.minor {
        vertical(&mut faint, *value, f.y, bottom);
        vertical(&mut marks, *value, bottom, bottom + 3.0);
    }
    for value in &placed.y.ticks.major {
        if !placed.y.categorical {
            horizontal(&mut grid, *value, f.x, f.x + f.w);
            horizontal(&mut marks, *value, f.x - 5.0, f.x);
        }
    }
    for value in &placed.y.ticks.minor {
        horizontal(&mut faint, *value, f.x, f.x + f.w);
        horizontal(&mut marks, *value, f.x - 3.0, f.x);
    }
    put!(
        out,
        "<path class=\"minor\" d=\"{faint}\" stroke=\"{}\" fill=\"none\"/>\
         <path class=\"grid\" d=\"{grid}\" stroke=\"{}\" fill=\"none\"/>\
         <path class=\"marks\" d=\"{marks}\" stroke=\"{}\" fill=\"none\"/>",
        MINOR.light,
        GRID.light,
        SOFT.light
    );
    out.push_str("<g class=\"t tx\" text-anchor=\"middle\">");
    if placed.show_x_labels {
        let y = number(bottom + 18.0);
        let mut free_from = f64::NEG_INFINITY;
        for (value, label) in placed.x.ticks.major.iter().zip(&placed.x.ticks.labels) {
            let (x, half) = (at_x(*value), width(label, SMALL) / 2.0);
            if x - half >= free_from {
                put!(out, "<text x=\"{}\" y=\"{y}\">{}</text>", number(x), escape(label));
                free_from = x + half + 4.0;
            }
        }
    }
    out.push_str("</g><g class=\"t ty\" text-anchor=\"end\">");
    for (value, label) in placed.y.ticks.major.iter().zip(&placed.y.ticks.labels) {
        // A name of several lines stands centred at its position.
        let first = at_y(*value) + 4.2 - 0.5 * NAME_LINE * (label.lines().count().max(1) - 1) as f64;
        for (line, text) in label.lines().enumerate() {
            let (x, y) = (number(f.x - 8.0), number(first + line as f64 * NAME_LINE));
            put!(out, "<text x=\"{x}\" y=\"{y}\">{}</text>", escape(text));
        }
    }
    out.push_str("</g>");
}

/// Shaded stretches of the x axis, behind everything.
fn spans(out: &mut String, panel: &Panel, placed: &PlacedPanel) {
    let f = placed.frame;
    for span in &panel.spans {
        let (a, b) = (placed.x.fraction(span.from), placed.x.fraction(span.to));
        let (a, b) = (a.clamp(0.0, 1.0), b.clamp(0.0, 1.0));
        if a.is_nan() || b.is_nan() || b <= a {
            continue;
        }
        let (ta, tb) = (placed.x.transform(span.from), placed.x.transform(span.to));
        let [x, y, w, h] = [f.x + a * f.w, f.y, (b - a) * f.w, f.h].map(number);
        put!(
            out,
            "<g class=\"span\" data-span=\"{ta:e} {tb:e}\">\
             <rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" fill=\"{}\"/></g>",
            SPAN.light
        );
    }
}
