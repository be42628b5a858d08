//! Layout of a figure: ranges of the axes, frames, legends. Nothing may overlap the data.

use super::text::{fit, width, wrap};
use super::ticks::{SMALLEST_SPAN, Ticks, ticks};
use super::{Axis, Figure, Marker, Panel, Scale, Series, Style};
use hysteron_numeric::number::superscript;

/// Sizes of text \[px\]; 12 px is 9 pt, the smallest that journals accept.
pub(crate) const SMALL: f64 = 12.0;
pub(crate) const PANEL_TITLE: f64 = 13.0;
pub(crate) const TITLE: f64 = 15.5;
/// Distances of the lines of a title, and of a name at a categorical ordinate \[px\].
pub(crate) const TITLE_LINE: f64 = 20.0;
pub(crate) const NAME_LINE: f64 = 13.0;
/// Height of one legend row \[px\] and length of its line sample.
pub(crate) const LEGEND_ROW: f64 = 18.0;
pub(crate) const SWATCH: f64 = 26.0;
/// Width of a drawing for narrow screens \[px\].
const NARROW_PX: f64 = 358.0;

/// What a figure is laid out for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sheet {
    /// Paper or a screen, as wide as the figure says.
    Wide,
    /// A narrow screen: panels one below the other, names and titles in several lines.
    Narrow,
}

impl Sheet {
    /// Longest line of a name at a categorical ordinate \[px\].
    fn longest_name(self) -> f64 {
        if self == Self::Narrow { 132.0 } else { 340.0 }
    }

    /// Lines of a title or a name at most.
    fn lines(self) -> usize {
        if self == Self::Narrow { 3 } else { 2 }
    }
}

/// A rectangle \[px\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rect {
    pub x: f64,
    pub y: f64,
    pub w: f64,
    pub h: f64,
}

/// One axis placed on the drawing: data run from `low` to `high` (in the transformed coordinate, i.e.
/// log₁₀ on a logarithmic axis) over `length` px.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlacedAxis {
    pub scale: Scale,
    pub low: f64,
    pub high: f64,
    pub ticks: Ticks,
    pub limit: usize,
    pub title: String,
    pub categorical: bool,
}

impl PlacedAxis {
    /// Transformed coordinate of a value; NaN where the value cannot be drawn.
    pub fn transform(&self, value: f64) -> f64 {
        transform(self.scale, value)
    }

    /// Position of a value as a fraction of the axis, 0 at `low`.
    pub fn fraction(&self, value: f64) -> f64 {
        (self.transform(value) - self.low) / (self.high - self.low)
    }
}

/// Sample drawn beside a legend entry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Sample {
    /// A series, with or without a band.
    Curve { style: Style, band: bool },
    /// A shaded stretch of the x axis.
    Span,
}

/// An entry of a legend and where its sample starts (baseline of its text).
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LegendEntry {
    pub label: String,
    pub sample: Sample,
    pub x: f64,
    pub y: f64,
}

/// One panel placed on the drawing.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlacedPanel {
    pub frame: Rect,
    pub x: PlacedAxis,
    pub y: PlacedAxis,
    pub has_data: bool,
    pub show_x_labels: bool,
    pub title: String,
    pub title_y: f64,
    pub y_title_x: f64,
    pub legend: Vec<LegendEntry>,
}

/// The whole drawing.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Layout {
    pub width: f64,
    pub height: f64,
    /// Lines; none without a title.
    pub title: Vec<String>,
    pub subtitle: String,
    pub title_y: f64,
    pub subtitle_y: f64,
    pub legend: Vec<LegendEntry>,
    pub panels: Vec<PlacedPanel>,
}

/// Values beyond this cannot be scaled without overflow and count as missing.
const LARGEST: f64 = 1e290;

/// log₁₀ or identity; NaN where the value cannot be drawn.
pub(crate) fn transform(scale: Scale, value: f64) -> f64 {
    match scale {
        Scale::Linear if value.abs() <= LARGEST => value,
        Scale::Log if value > 1e-290 && value <= LARGEST => value.log10(),
        _ => f64::NAN,
    }
}

/// Width of one bar slot on a numeric or categorical axis: the smallest distance between two bars.
pub(crate) fn bar_slot(panel: &Panel) -> f64 {
    let mut xs: Vec<f64> = panel
        .series
        .iter()
        .filter(|s| s.style.marker == Marker::Bar)
        .flat_map(|s| s.x.iter().copied().filter(|x| x.is_finite()))
        .collect();
    xs.sort_by(f64::total_cmp);
    let gap = xs.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 0.0).fold(f64::INFINITY, f64::min);
    if gap.is_finite() && panel.x.categories.is_empty() { gap } else { 1.0 }
}

fn is_bar(series: &Series) -> bool {
    series.style.marker == Marker::Bar
}

/// Range of one axis in transformed coordinates, and whether there were any data.
fn range(panel: &Panel, axis: &Axis, horizontal: bool) -> (f64, f64, bool) {
    if !axis.categories.is_empty() {
        return (-0.5, axis.categories.len() as f64 - 0.5, true);
    }
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut include = |value: f64| {
        let t = transform(axis.scale, value);
        if t.is_finite() {
            low = low.min(t);
            high = high.max(t);
        }
    };
    let other = if horizontal { &panel.y } else { &panel.x };
    for series in &panel.series {
        for (x, y) in series.x.iter().zip(&series.y) {
            let (value, partner) = if horizontal { (*x, *y) } else { (*y, *x) };
            if transform(other.scale, partner).is_finite() {
                include(value);
            }
        }
        if let (false, Some(band)) = (horizontal, &series.band) {
            band.lower.iter().chain(&band.upper).for_each(|v| include(*v));
        }
        if is_bar(series) && horizontal {
            let half = 0.5 * bar_slot(panel);
            series.x.iter().for_each(|x| {
                include(x - half);
                include(x + half);
            });
        }
    }
    let bars = panel.series.iter().any(is_bar);
    if bars && !horizontal && axis.scale == Scale::Linear && low <= high {
        low = low.min(0.0);
        high = high.max(0.0);
    }
    let any = low <= high;
    if let Some((a, b)) = axis.range {
        let (a, b) = (transform(axis.scale, a), transform(axis.scale, b));
        if b - a >= SMALLEST_SPAN {
            return (a, b, any);
        }
    }
    if !any {
        return (0.0, 1.0, false);
    }
    let size = low.abs().max(high.abs());
    if high - low <= (1e-9 * size).max(SMALLEST_SPAN) {
        let half = match axis.scale {
            Scale::Log => 0.5,
            Scale::Linear if size < 1e9 * SMALLEST_SPAN => 1.0,
            Scale::Linear => 0.1 * size,
        };
        return (low - half, high + half, true);
    }
    let time_like = panel.series.iter().all(|s| s.style.marker.path().is_none() && s.x.is_sorted());
    let share = match (horizontal, bars) {
        (true, true) => 0.0,
        (true, false) if time_like => 0.0,
        (true, false) => 0.03,
        (false, _) => 0.06,
    };
    let margin = share * (high - low);
    let zero_based = bars && !horizontal && axis.scale == Scale::Linear;
    (
        if zero_based && low == 0.0 { 0.0 } else { low - margin },
        if zero_based && high == 0.0 { 0.0 } else { high + margin },
        true,
    )
}

/// The axis over `length` px, from the first to the last of its data, or of all that share it.
fn place_axis(
    panel: &Panel,
    axis: &Axis,
    horizontal: bool,
    length: f64,
    (sheet, shared): (Sheet, Option<(f64, f64)>),
) -> (PlacedAxis, bool) {
    let (low, high, any) = range(panel, axis, horizontal);
    let (low, high) = if any { shared.unwrap_or((low, high)) } else { (low, high) };
    let limit = (length / if horizontal { 64.0 } else { 28.0 }).floor().clamp(3.0, 10.0) as usize;
    let marks = if !axis.categories.is_empty() {
        let slot = length / axis.categories.len() as f64;
        let label = |name: &String| match horizontal {
            true => fit(name, SMALL, slot - 4.0),
            false => wrap(name, SMALL, sheet.longest_name(), sheet.lines()).join("\n"),
        };
        Ticks {
            major: (0..axis.categories.len()).map(|i| i as f64).collect(),
            labels: axis.categories.iter().map(label).collect(),
            ..Ticks::default()
        }
    } else if any {
        let back = |t: f64| if axis.scale == Scale::Log { 10f64.powf(t) } else { t };
        ticks(axis.scale, back(low), back(high), limit)
    } else {
        Ticks::default()
    };
    let power = match marks.exponent {
        0 => String::new(),
        e => format!("10{}", superscript(e)),
    };
    let title = match (axis.unit.is_empty(), power.is_empty()) {
        (true, true) => axis.label.clone(),
        (true, false) => format!("{} (×{power})", axis.label),
        (false, true) => format!("{} ({})", axis.label, axis.unit),
        (false, false) => format!("{} ({power} {})", axis.label, axis.unit),
    };
    let categorical = !axis.categories.is_empty();
    (PlacedAxis { scale: axis.scale, low, high, ticks: marks, limit, title, categorical }, any)
}

/// The range of the data of all panels, where they share the x axis.
fn shared_range(figure: &Figure) -> Option<(f64, f64)> {
    let scale = figure.panels.first()?.x.scale;
    if !figure.linked_x || figure.panels.iter().any(|p| p.x.scale != scale || !p.x.categories.is_empty()) {
        return None;
    }
    let ranges = figure.panels.iter().map(|panel| range(panel, &panel.x, true)).filter(|r| r.2);
    ranges.map(|(low, high, _)| (low, high)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// Entries of a panel's legend: labelled series and stretches, equal ones once.
fn entries(panel: &Panel) -> Vec<(String, Sample)> {
    let curves =
        panel.series.iter().map(|s| (&s.label, Sample::Curve { style: s.style, band: s.band.is_some() }));
    let spans = panel.spans.iter().map(|s| (&s.label, Sample::Span));
    let mut found: Vec<(String, Sample)> = Vec::new();
    for (label, sample) in curves.chain(spans).filter(|(label, _)| !label.is_empty()) {
        if !found.iter().any(|(known, other)| known == label && *other == sample) {
            found.push((label.clone(), sample));
        }
    }
    found
}

/// Places entries in rows from `left` to `right`, first baseline at `y`; returns them and the rows used.
fn place_legend(found: Vec<(String, Sample)>, left: f64, right: f64, y: f64) -> (Vec<LegendEntry>, usize) {
    let (mut x, mut row) = (left, 0);
    let mut placed = Vec::with_capacity(found.len());
    for (label, sample) in found {
        let label = fit(&label, SMALL, right - left - SWATCH - 8.0);
        let w = SWATCH + 6.0 + width(&label, SMALL);
        if x + w > right && x > left {
            x = left;
            row += 1;
        }
        placed.push(LegendEntry { label, sample, x, y: y + row as f64 * LEGEND_ROW });
        x += w + 16.0;
    }
    let rows = if placed.is_empty() { 0 } else { row + 1 };
    (placed, rows)
}

/// Room for the names of a categorical ordinate, all as high as the highest \[px\]; 0 for a numeric one.
fn height_of_names(axis: &PlacedAxis) -> f64 {
    let most = axis.ticks.labels.iter().map(|name| name.lines().count()).max().unwrap_or(0);
    if axis.categorical && most > 1 {
        axis.ticks.labels.len() as f64 * (NAME_LINE * most as f64 + 5.0)
    } else {
        0.0
    }
}

/// Computes the drawing of a figure.
pub(crate) fn layout(figure: &Figure, sheet: Sheet) -> Layout {
    let total = match sheet {
        Sheet::Narrow => NARROW_PX,
        Sheet::Wide if figure.width_px.is_finite() => figure.width_px.clamp(200.0, 4000.0),
        Sheet::Wide => 680.0,
    };
    let mut frame_h =
        if figure.panel_height_px.is_finite() { figure.panel_height_px.clamp(60.0, 3000.0) } else { 230.0 };
    let columns = if sheet == Sheet::Narrow { 1 } else { figure.columns.max(1) };
    let columns = columns.min(figure.panels.len().max(1));
    let rows = figure.panels.len().div_ceil(columns);
    let column_width = total / columns as f64;

    let mut y = 8.0;
    let title = match figure.title.as_str() {
        "" => Vec::new(),
        title => wrap(title, TITLE, total - 24.0, sheet.lines()),
    };
    let subtitle = fit(&figure.subtitle, SMALL, total - 24.0);
    y += if title.is_empty() { 0.0 } else { 22.0 };
    let title_y = y - 4.0;
    y += title.len().saturating_sub(1) as f64 * TITLE_LINE;
    y += if subtitle.is_empty() { 0.0 } else { 18.0 };
    let subtitle_y = y - 4.0;

    // Left margins: the widest tick label of each column, so that frames line up.
    let mut left = vec![0f64; columns];
    let mut of_names = 0f64;
    for (i, panel) in figure.panels.iter().enumerate() {
        let (axis, _) = place_axis(panel, &panel.y, false, frame_h, (sheet, None));
        let lines = axis.ticks.labels.iter().flat_map(|label| label.lines());
        let widest = lines.map(|t| width(t, SMALL)).fold(0.0, f64::max);
        left[i % columns] = left[i % columns].max(widest.max(30.0) + 34.0);
        of_names = of_names.max(height_of_names(&axis));
    }
    frame_h = frame_h.max(of_names);

    let lists: Vec<_> = figure.panels.iter().map(entries).collect();
    // One legend above all, where it holds for every panel.
    let explains = |list: &Vec<(String, Sample)>| list.iter().all(|entry| lists[0].contains(entry));
    let shared = lists.len() > 1 && lists[1..].iter().all(explains);
    let x_range = shared_range(figure);
    let first_left = left.first().copied().unwrap_or(0.0);
    let (legend, legend_rows) = match lists.first() {
        Some(list) if shared => place_legend(list.clone(), first_left, total - 12.0, y + 14.0),
        _ => (Vec::new(), 0),
    };
    y += legend_rows as f64 * LEGEND_ROW + if legend_rows > 0 { 4.0 } else { 0.0 };

    let mut panels = Vec::with_capacity(figure.panels.len());
    for row in 0..rows {
        let members = row * columns..((row + 1) * columns).min(figure.panels.len());
        let row_panels = &figure.panels[members.clone()];
        let has_title = row_panels.iter().any(|p| !p.title.is_empty());
        let title_height = if has_title { 20.0 } else { 0.0 };
        let mut legends = Vec::new();
        let mut legend_rows = 0;
        for (column, i) in members.clone().enumerate() {
            let x0 = column as f64 * column_width;
            let list = if shared { Vec::new() } else { lists[i].clone() };
            let placed =
                place_legend(list, x0 + left[column], x0 + column_width - 12.0, y + title_height + 14.0);
            legend_rows = legend_rows.max(placed.1);
            legends.push(placed.0);
        }
        let legend_height = legend_rows as f64 * LEGEND_ROW + if legend_rows > 0 { 4.0 } else { 0.0 };
        let top = y + title_height + legend_height + 6.0;
        let show_x_labels = !(figure.linked_x && columns == 1 && row + 1 < rows);
        for (column, (panel, legend)) in row_panels.iter().zip(legends).enumerate() {
            let x0 = column as f64 * column_width;
            let w = (column_width - left[column] - 20.0).max(40.0);
            let frame = Rect { x: x0 + left[column], y: top, w, h: frame_h };
            let (x, any_x) = place_axis(panel, &panel.x, true, w, (sheet, x_range));
            let (y_axis, any_y) = place_axis(panel, &panel.y, false, frame_h, (sheet, None));
            panels.push(PlacedPanel {
                frame,
                x,
                y: y_axis,
                has_data: any_x
                    && any_y
                    && (!panel.cells.is_empty() || panel.series.iter().any(|s| drawable(panel, s))),
                show_x_labels,
                title: fit(&panel.title, PANEL_TITLE, w + 20.0),
                title_y: y + 15.0,
                y_title_x: x0 + 16.0,
                legend,
            });
        }
        y = top + frame_h + if show_x_labels { 44.0 } else { 8.0 };
    }
    Layout { width: total, height: (y + 4.0).max(60.0), title, subtitle, title_y, subtitle_y, legend, panels }
}

/// Whether a series has a point that can be drawn.
fn drawable(panel: &Panel, series: &Series) -> bool {
    series
        .x
        .iter()
        .zip(&series.y)
        .any(|(x, y)| transform(panel.x.scale, *x).is_finite() && transform(panel.y.scale, *y).is_finite())
}
