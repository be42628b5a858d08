//! Curves, bands, markers and bars of a panel, and the data a page's script zooms into.

use super::decimate::decimate;
use super::layout::{PlacedPanel, Rect, Sample, bar_slot};
use super::palette::SPAN;
use super::style::{Colour, Dash, Marker, Style};
use super::text::{number, push_number};
use super::{Panel, Series};
use crate::base64;

/// Points at most in a drawn curve, and in the data behind it on a page.
const DRAWN_POINTS: usize = 4000;
/// Raster of a drawn curve \[px\], and of one for narrow screens, which a wide one stands beside.
const DRAWN_CELL: f64 = 0.6;
const NARROW_CELL: f64 = 1.0;
const STORED_POINTS: usize = 8000;
/// Raster of the stored data: columns over the whole axis.
const STORED_RASTER: f64 = 2400.0;

/// A sample of a series for a legend.
pub(crate) struct Swatch {
    pub sample: Sample,
    pub x: f64,
    pub y: f64,
    pub length: f64,
}

/// Whether a panel has bars.
pub(crate) fn has_bars(panel: &Panel) -> bool {
    panel.series.iter().any(|s| s.style.marker == Marker::Bar)
}

/// How finely curves are drawn, and whether the data for zooming stand beside them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Detail {
    /// As fine as can be seen.
    Fine,
    /// Fine, with the data.
    Stored,
    /// For a narrow screen.
    Coarse,
}

/// Draws every series of a panel.
pub(crate) fn draw(out: &mut String, panel: &Panel, placed: &PlacedPanel, detail: Detail) {
    let stored = detail == Detail::Stored;
    let (cell, grain) = if detail == Detail::Coarse { (NARROW_CELL, 10.0) } else { (DRAWN_CELL, 1.0) };
    let bars: Vec<&Series> = panel.series.iter().filter(|s| s.style.marker == Marker::Bar).collect();
    for (index, series) in bars.iter().enumerate() {
        draw_bars(out, series, (index, bars.len()), panel, placed);
    }
    let frame = placed.frame;
    let in_frame = |points: &[(f64, f64)]| -> Vec<(f64, f64)> {
        points.iter().map(|p| (frame.x + p.0 * frame.w, frame.y + frame.h - p.1 * frame.h)).collect()
    };
    for series in panel.series.iter().filter(|s| s.style.marker != Marker::Bar) {
        let style = series.style;
        put!(out, "<g class=\"{}\" color=\"{}\">", style.colour.class(), style.colour.hex());
        let points: Vec<(f64, f64)> = series
            .x
            .iter()
            .zip(&series.y)
            .map(|(x, y)| (placed.x.fraction(*x), placed.y.fraction(*y)))
            .collect();
        for outline in band_outlines(series, placed) {
            put!(out, "<path class=\"band\" d=\"");
            push_path(out, &in_frame(&outline), true, grain);
            out.push('"');
            if stored {
                push_stored(out, &outline, true);
            }
            out.push_str(" fill=\"currentColor\" fill-opacity=\".18\" stroke=\"none\"/>");
        }
        if style.dash != Dash::None {
            out.push_str("<path class=\"line\" d=\"");
            push_path(out, &decimate(&in_frame(&points), cell, DRAWN_POINTS), false, grain);
            out.push('"');
            if stored {
                push_stored(out, &points, false);
            }
            push_stroke(out, style);
            out.push_str("/>");
        }
        if let Some(shape) = style.marker.path() {
            put!(out, "<path class=\"mark\" data-mark=\"{shape}\" d=\"");
            for p in decimate(&in_frame(&points), cell, DRAWN_POINTS)
                .iter()
                .filter(|p| p.0.is_finite() && p.1.is_finite())
            {
                put!(out, "M{} {}{shape}", number(p.0), number(p.1));
            }
            out.push('"');
            if stored {
                push_stored(out, &points, false);
            }
            push_mark_paint(out, style.marker);
            out.push_str("/>");
        }
        out.push_str("</g>");
    }
}

/// The sample of a series in a legend.
pub(crate) fn swatch(out: &mut String, s: &Swatch) {
    let Sample::Curve { style, band } = s.sample else {
        let (x, y, length) = (number(s.x), number(s.y - 6.0), number(s.length));
        put!(
            out,
            "<g class=\"span\"><rect x=\"{x}\" y=\"{y}\" width=\"{length}\" height=\"12\" \
             fill=\"{}\"/></g>",
            SPAN.light
        );
        return;
    };
    put!(out, "<g class=\"{}\" color=\"{}\">", style.colour.class(), style.colour.hex());
    let (x, y, middle) = (number(s.x), number(s.y), number(s.x + s.length / 2.0));
    if band {
        let top = number(s.y - 5.0);
        let length = number(s.length);
        put!(
            out,
            "<rect x=\"{x}\" y=\"{top}\" width=\"{length}\" height=\"10\" fill=\"currentColor\" \
             fill-opacity=\".18\"/>"
        );
    }
    if style.marker == Marker::Bar {
        let left = s.x + s.length - 14.0;
        push_bar(out, Rect { x: left, y: s.y - 5.5, w: 14.0, h: 11.0 }, style);
    } else {
        if style.dash != Dash::None {
            put!(out, "<path d=\"M{x} {y}h{}\"", number(s.length));
            push_stroke(out, style);
            out.push_str("/>");
        }
        if let Some(shape) = style.marker.path() {
            put!(out, "<path d=\"M{middle} {y}{shape}\"");
            push_mark_paint(out, style.marker);
            out.push_str("/>");
        }
    }
    out.push_str("</g>");
}

fn push_stroke(out: &mut String, style: Style) {
    let width = if style.width_px.is_finite() { style.width_px.clamp(0.2, 20.0) } else { 1.4 };
    put!(
        out,
        " fill=\"none\" stroke=\"currentColor\" stroke-width=\"{}\" stroke-linejoin=\"round\"",
        number(width)
    );
    if let Some(dashes) = style.dash.array(width) {
        put!(out, " stroke-dasharray=\"{dashes}\"");
        if style.dash == Dash::Dotted {
            out.push_str(" stroke-linecap=\"round\"");
        }
    }
}

fn push_mark_paint(out: &mut String, marker: Marker) {
    out.push_str(if marker == Marker::Cross {
        " fill=\"none\" stroke=\"currentColor\" stroke-width=\"1.6\""
    } else {
        " fill=\"currentColor\" stroke=\"none\""
    });
}

/// Appends path data through `points`: relative steps of `grain` hundredths of a pixel, breaks where not
/// finite.
fn push_path(out: &mut String, points: &[(f64, f64)], close: bool, grain: f64) {
    let hundredths = |v: f64| (v.clamp(-1e6, 1e6) * 100.0 / grain).round() * grain;
    let mut pen: Option<(f64, f64)> = None;
    for (i, p) in points.iter().enumerate() {
        if !(p.0.is_finite() && p.1.is_finite()) {
            pen = None;
            continue;
        }
        let here = (hundredths(p.0), hundredths(p.1));
        let alone = points.get(i + 1).is_none_or(|q| !(q.0.is_finite() && q.1.is_finite()));
        match pen {
            None => {
                out.push('M');
                push_pair(out, here);
                if alone {
                    out.push_str("h.01");
                }
            }
            Some(before) => {
                out.push('l');
                push_pair(out, (here.0 - before.0, here.1 - before.1));
            }
        }
        pen = Some(here);
    }
    if close && pen.is_some() {
        out.push('z');
    }
}

fn push_pair(out: &mut String, hundredths: (f64, f64)) {
    push_number(out, hundredths.0 / 100.0);
    if hundredths.1 >= 0.0 {
        out.push(' ');
    }
    push_number(out, hundredths.1 / 100.0);
}

/// Closed outlines of a band, one for each stretch where both edges can be drawn, in axis fractions.
fn band_outlines(series: &Series, placed: &PlacedPanel) -> Vec<Vec<(f64, f64)>> {
    let Some(band) = &series.band else { return Vec::new() };
    let mut outlines = Vec::new();
    let (mut lower, mut upper) = (Vec::new(), Vec::new());
    let mut flush = |lower: &mut Vec<(f64, f64)>, upper: &mut Vec<(f64, f64)>| {
        if lower.len() > 1 {
            let cell = 1.0 / STORED_RASTER;
            let mut outline = decimate(upper, cell, STORED_POINTS / 2);
            outline.extend(decimate(lower, cell, STORED_POINTS / 2).into_iter().rev());
            outlines.push(outline);
        }
        lower.clear();
        upper.clear();
    };
    for (x, (low, high)) in series.x.iter().zip(band.lower.iter().zip(&band.upper)) {
        let (x, low, high) = (placed.x.fraction(*x), placed.y.fraction(*low), placed.y.fraction(*high));
        if x.is_finite() && low.is_finite() && high.is_finite() {
            lower.push((x, low));
            upper.push((x, high));
        } else {
            flush(&mut lower, &mut upper);
        }
    }
    flush(&mut lower, &mut upper);
    outlines
}

/// Appends the data of a curve as axis fractions: 24 bits a coordinate over `-1 ..= 2`, base 64; all ones
/// is a break.
fn push_stored(out: &mut String, fractions: &[(f64, f64)], closed: bool) {
    let kept = if closed || fractions.len() <= STORED_POINTS {
        fractions.to_vec()
    } else {
        let scaled: Vec<_> = fractions.iter().map(|p| (p.0 * STORED_RASTER, p.1 * STORED_RASTER)).collect();
        let kept = decimate(&scaled, 1.0, STORED_POINTS);
        kept.into_iter().map(|p| (p.0 / STORED_RASTER, p.1 / STORED_RASTER)).collect()
    };
    const LAST: u32 = 0xff_ffff;
    let mut bytes = Vec::with_capacity(kept.len() * 6);
    for p in &kept {
        let whole = p.0.is_finite() && p.1.is_finite();
        for value in [p.0, p.1] {
            let code = if whole {
                (((value.clamp(-1.0, 2.0) + 1.0) / 3.0 * f64::from(LAST - 1)).round()) as u32
            } else {
                LAST
            };
            let [_, a, b, c] = code.to_be_bytes();
            bytes.extend([a, b, c]);
        }
    }
    put!(out, " data-points=\"{}\"", base64::encode(&bytes));
}

fn draw_bars(
    out: &mut String,
    series: &Series,
    (index, count): (usize, usize),
    panel: &Panel,
    placed: &PlacedPanel,
) {
    let f = placed.frame;
    let slot = bar_slot(panel);
    let histogram = count == 1 && !placed.x.categorical;
    let share = if histogram { 1.0 } else { 0.76 };
    let one = slot * share / count as f64;
    let floor = if placed.y.scale == super::Scale::Linear { placed.y.fraction(0.0) } else { 0.0 };
    put!(out, "<g class=\"{}\" color=\"{}\">", series.style.colour.class(), series.style.colour.hex());
    for (x, y) in series.x.iter().zip(&series.y) {
        let left = x - slot * share / 2.0 + one * index as f64;
        let (a, b) = (placed.x.fraction(left), placed.x.fraction(left + one));
        let top = placed.y.fraction(*y);
        if !(a.is_finite() && b.is_finite() && top.is_finite()) {
            continue;
        }
        let (low, high) = (top.min(floor).clamp(0.0, 1.0), top.max(floor).clamp(0.0, 1.0));
        let gap = if histogram { 0.5 } else { 1.0 };
        let rect = Rect {
            x: f.x + a * f.w + gap / 2.0,
            y: f.y + (1.0 - high) * f.h,
            w: ((b - a) * f.w - gap).max(0.5),
            h: (high - low) * f.h,
        };
        push_bar(out, rect, series.style);
    }
    out.push_str("</g>");
}

/// A bar: filled, and crossed by lines that differ with the colour, to be distinguished in grey.
fn push_bar(out: &mut String, r: Rect, style: Style) {
    let [x, y, w, h] = [r.x, r.y, r.w, r.h].map(number);
    put!(
        out,
        "<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" fill=\"currentColor\" fill-opacity=\".78\"/>"
    );
    let mut hatch = String::new();
    let (right, bottom) = (r.x + r.w, r.y + r.h);
    match style.colour {
        Colour::Vermillion | Colour::Purple => {
            let mut c = ((r.x + r.y) / 6.0).ceil() * 6.0;
            while c < right + bottom {
                let (x0, x1) = ((c - bottom).max(r.x), (c - r.y).min(right));
                put!(hatch, "M{} {}L{} {}", number(x0), number(c - x0), number(x1), number(c - x1));
                c += 6.0;
            }
        }
        Colour::Green | Colour::Sky => {
            let mut level = (r.y / 5.0).ceil() * 5.0;
            while level < bottom {
                put!(hatch, "M{x} {}h{w}", number(level));
                level += 5.0;
            }
        }
        _ => {}
    }
    if !hatch.is_empty() {
        put!(out, "<path class=\"hatch\" d=\"{hatch}\" stroke=\"#fff\" fill=\"none\"/>");
    }
}
