//! Figures as data: panels of series with axes in stated units, drawn as SVG and zoomable on a page.
//!
//! A [`Figure`] is built once and used three ways: [`Figure::to_svg`] for a paper, a block of a
//! [`crate::page::Page`] where its axes can be zoomed, and (feature `png`) `Figure::to_png`.
//!
//! ```
//! use hysteron_report::figure::{Axis, Figure, Panel, Series, Style};
//! let time_s: Vec<f64> = (0..500).map(|k| k as f64 / 500.0).collect();
//! let y_um: Vec<f64> = time_s.iter().map(|t| 15.0 * (6.28 * t).sin()).collect();
//! let svg = Figure::new("Step 1")
//!     .panel(
//!         Panel::new(Axis::linear("time", "s"), Axis::linear("displacement", "µm"))
//!             .series(Series::line("measured", time_s, y_um, Style::measured())),
//!     )
//!     .to_svg();
//! assert!(svg.starts_with("<svg"));
//! ```

mod breaks;
mod curves;
mod decimate;
mod heat;
mod kinds;
mod layout;
mod names;
pub(crate) mod palette;
mod passes;
#[cfg(feature = "png")]
mod png;
mod style;
mod svg;
mod text;
pub mod ticks;

pub use decimate::decimate;
pub use kinds::{
    ConvergenceCurve, FrequencyResponseCurve, convergence, correlation_matrix, correlogram,
    errors_by_category, errors_by_frequency, frequency_response, histogram, measured_and_model, residual,
};
#[cfg(feature = "png")]
pub use png::PngError;
pub use style::{Colour, Dash, Marker, Style};

/// Spacing law of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scale {
    /// Equal distances are equal differences.
    #[default]
    Linear,
    /// Equal distances are equal ratios; values ≤ 0 are not drawn.
    Log,
}

/// One axis: what is plotted, in which unit, on which scale.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Axis {
    /// Quantity, e.g. `displacement`.
    pub label: String,
    /// Unit as printed, e.g. `µm`; empty for a pure number.
    pub unit: String,
    /// Linear or logarithmic.
    pub scale: Scale,
    /// Fixed limits `(low, high)` in the axis' unit; `None` fits the data with a small margin.
    pub range: Option<(f64, f64)>,
    /// Names of the positions 0, 1, 2 … of a categorical axis; empty for a numeric axis.
    pub categories: Vec<String>,
}

impl Axis {
    /// A linear axis.
    pub fn linear(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { label: label.into(), unit: unit.into(), ..Self::default() }
    }

    /// A logarithmic axis.
    pub fn log(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { label: label.into(), unit: unit.into(), scale: Scale::Log, ..Self::default() }
    }

    /// An axis of named positions (x = 0 is the first name).
    pub fn categories(label: impl Into<String>, names: impl IntoIterator<Item = impl Into<String>>) -> Self {
        Self {
            label: label.into(),
            categories: names.into_iter().map(Into::into).collect(),
            ..Self::default()
        }
    }

    /// Sets fixed limits, in the axis's unit. Limits that are not finite or not ordered are ignored when
    /// drawing.
    #[must_use]
    pub fn with_range(mut self, low: f64, high: f64) -> Self {
        self.range = Some((low, high));
        self
    }
}

/// A shaded region between two curves over the same `x` as the series (quartiles, an error bar …).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Band {
    /// Lower edge at every `x` of the series.
    pub lower: Vec<f64>,
    /// Upper edge at every `x` of the series.
    pub upper: Vec<f64>,
}

/// One curve. Points whose `x` or `y` is not finite (or not positive on a logarithmic axis) break the line.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Series {
    /// Legend text; empty keeps the series out of the legend.
    pub label: String,
    /// Abscissae, any order: an XY loop is a series like any other.
    pub x: Vec<f64>,
    /// Ordinates; surplus entries of the longer of `x` and `y` are ignored.
    pub y: Vec<f64>,
    /// Colour, dash, width, marker.
    pub style: Style,
    /// Shaded band around the curve.
    pub band: Option<Band>,
}

impl Series {
    /// A series of `y` over `x`.
    pub fn line(label: impl Into<String>, x: Vec<f64>, y: Vec<f64>, style: Style) -> Self {
        Self { label: label.into(), x, y, style, band: None }
    }

    /// Adds a shaded band between `lower` and `upper`.
    #[must_use]
    pub fn with_band(mut self, lower: Vec<f64>, upper: Vec<f64>) -> Self {
        self.band = Some(Band { lower, upper });
        self
    }
}

/// A shaded stretch of the x axis with a short name, e.g. the samples a score skips.
#[derive(Debug, Clone, PartialEq)]
pub struct Span {
    /// Start, in the unit of the x axis.
    pub from: f64,
    /// End, in the unit of the x axis.
    pub to: f64,
    /// Text in the legend; may be empty.
    pub label: String,
}

/// Text beside a point.
#[derive(Debug, Clone, PartialEq)]
pub struct PointName {
    /// Abscissa, in the unit of the x axis.
    pub x: f64,
    /// Ordinate, in the unit of the y axis.
    pub y: f64,
    /// The text.
    pub text: String,
}

/// One pair of axes with its curves.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Panel {
    /// Short title above the frame; may be empty.
    pub title: String,
    /// Abscissa.
    pub x: Axis,
    /// Ordinate.
    pub y: Axis,
    /// Curves, drawn in order (the last one on top).
    pub series: Vec<Series>,
    /// Shaded stretches of the x axis, behind the curves.
    pub spans: Vec<Span>,
    /// Names of points, beside them. The axes of a panel with names cannot be zoomed.
    pub names: Vec<PointName>,
    /// Numbers from −1 to 1 as coloured cells, row by row from the top, between two categorical axes.
    pub cells: Vec<Vec<f64>>,
}

impl Panel {
    /// An empty panel.
    pub fn new(x: Axis, y: Axis) -> Self {
        Self { x, y, ..Self::default() }
    }

    /// Sets the title.
    #[must_use]
    pub fn titled(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// Adds a curve.
    #[must_use]
    pub fn series(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// Adds `text` beside the point (`x`, `y`).
    #[must_use]
    pub fn name(mut self, x: f64, y: f64, text: impl Into<String>) -> Self {
        self.names.push(PointName { x, y, text: text.into() });
        self
    }

    /// Adds a shaded stretch `from ..= to` of the x axis.
    #[must_use]
    pub fn span(mut self, from: f64, to: f64, label: impl Into<String>) -> Self {
        self.spans.push(Span { from, to, label: label.into() });
        self
    }
}

/// Panels under one title, with a caption for the page they stand on.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Title, drawn in the SVG.
    pub title: String,
    /// Second line, drawn smaller; say `simulated` here when the data are.
    pub subtitle: String,
    /// Caption under the figure on a page, which numbers it unless the title starts with `Figure `; becomes
    /// the description of a stand-alone SVG.
    pub caption: String,
    /// Panels in reading order.
    pub panels: Vec<Panel>,
    /// Panels per row (at least 1).
    pub columns: usize,
    /// Width of the whole figure \[px at 96 dpi\]; 680 px is 180 mm.
    pub width_px: f64,
    /// Height of one panel's frame \[px\].
    pub panel_height_px: f64,
    /// Whether panels share their x axis: zooming one zooms all.
    pub linked_x: bool,
}

impl Figure {
    /// An empty figure, one panel per row, 680 px (180 mm) wide.
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            subtitle: String::new(),
            caption: String::new(),
            panels: Vec::new(),
            columns: 1,
            width_px: 680.0,
            panel_height_px: 230.0,
            linked_x: false,
        }
    }

    /// Sets the title.
    #[must_use]
    pub fn titled(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// Sets the second title line.
    #[must_use]
    pub fn subtitled(mut self, subtitle: impl Into<String>) -> Self {
        self.subtitle = subtitle.into();
        self
    }

    /// Sets the caption.
    #[must_use]
    pub fn captioned(mut self, caption: impl Into<String>) -> Self {
        self.caption = caption.into();
        self
    }

    /// Adds a panel.
    #[must_use]
    pub fn panel(mut self, panel: Panel) -> Self {
        self.panels.push(panel);
        self
    }

    /// Sets the number of panels per row.
    #[must_use]
    pub fn in_columns(mut self, columns: usize) -> Self {
        self.columns = columns.max(1);
        self
    }

    /// Sets the height of the frames \[px\].
    #[must_use]
    pub fn panel_height(mut self, height_px: f64) -> Self {
        self.panel_height_px = height_px;
        self
    }

    /// Links the x axes of the panels.
    #[must_use]
    pub fn link_x(mut self) -> Self {
        self.linked_x = true;
        self
    }

    /// The figure as a stand-alone SVG document.
    ///
    /// Curves are reduced to what the drawing can show without losing an extreme value (see
    /// [`decimate`]); the same figure always gives the same bytes.
    pub fn to_svg(&self) -> String {
        svg::draw(self, svg::Use::StandAlone)
    }

    /// The figure as an SVG element for a page: the same drawing, plus the data its script zooms into.
    pub(crate) fn to_inline_svg(&self, id: &str) -> String {
        svg::draw(self, svg::Use::Inline { id })
    }

    /// The figure laid out anew for a narrow screen, beside [`Self::to_inline_svg`], whose data it shares;
    /// `None` where names of points need the room of the wide one.
    pub(crate) fn to_narrow_svg(&self, id: &str) -> Option<String> {
        let named = self.panels.iter().any(names::has_names);
        (!named).then(|| svg::draw(self, svg::Use::Narrow { id }))
    }
}
