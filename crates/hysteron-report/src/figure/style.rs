//! Style of a curve: colours of the palette, dashes that survive a grey print, marker shapes.

use super::palette::{CURVES, Tone};

/// A colour of the palette.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Colour {
    /// Text colour (black on white paper).
    #[default]
    Ink,
    /// Blue.
    Blue,
    /// Vermillion.
    Vermillion,
    /// Bluish green.
    Green,
    /// Orange.
    Orange,
    /// Sky blue.
    Sky,
    /// Reddish purple.
    Purple,
    /// Neutral grey, for what stands in the background.
    Grey,
}

impl Colour {
    /// Colour on white paper.
    pub fn hex(self) -> &'static str {
        self.tone().light
    }

    /// Class by which a page's style sheet replaces the colour on a dark background.
    pub(crate) fn class(self) -> &'static str {
        self.tone().name
    }

    fn tone(self) -> Tone {
        CURVES[self as usize]
    }
}

/// Line pattern.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Dash {
    /// ────
    #[default]
    Solid,
    /// ─ ─ ─
    Dashed,
    /// ·····
    Dotted,
    /// ─ · ─
    DashDot,
    /// No line, markers alone.
    None,
}

impl Dash {
    /// Value of `stroke-dasharray` for a line of `width` px; `None` draws solid.
    pub(crate) fn array(self, width: f64) -> Option<String> {
        let pattern: &[f64] = match self {
            Self::Solid | Self::None => return None,
            Self::Dashed => &[4.5, 2.5],
            Self::Dotted => &[1.1, 2.0],
            Self::DashDot => &[6.0, 2.0, 1.1, 2.0],
        };
        let unit = width.max(1.2);
        Some(pattern.iter().map(|part| super::text::number(part * unit)).collect::<Vec<_>>().join(" "))
    }
}

/// Mark at every point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Marker {
    /// No mark.
    #[default]
    None,
    /// ●
    Circle,
    /// ■
    Square,
    /// ▲
    Triangle,
    /// ◆
    Diamond,
    /// ✕, drawn by strokes.
    Cross,
    /// A small dot, for clouds of points.
    Dot,
    /// A bar from the axis to the point; bars of several series stand side by side.
    Bar,
}

impl Marker {
    /// Path of the mark relative to its centre, or `None` where there is no such path.
    pub(crate) fn path(self) -> Option<&'static str> {
        match self {
            Self::None | Self::Bar => None,
            Self::Circle => Some("m-3.4 0a3.4 3.4 0 1 0 6.8 0a3.4 3.4 0 1 0-6.8 0z"),
            Self::Square => Some("m-3-3h6v6h-6z"),
            Self::Triangle => Some("m0-4l3.8 6.6h-7.6z"),
            Self::Diamond => Some("m0-4.2l4.2 4.2l-4.2 4.2l-4.2-4.2z"),
            Self::Cross => Some("m-3-3l6 6m0-6l-6 6"),
            Self::Dot => Some("m-1.1 0a1.1 1.1 0 1 0 2.2 0a1.1 1.1 0 1 0-2.2 0z"),
        }
    }
}

/// Look of one series.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Style {
    /// Colour of line and mark.
    pub colour: Colour,
    /// Line pattern.
    pub dash: Dash,
    /// Line width \[px\].
    pub width_px: f64,
    /// Mark at every point.
    pub marker: Marker,
}

impl Default for Style {
    fn default() -> Self {
        Self::nth(0)
    }
}

impl Style {
    /// Solid line of the given colour, 1.4 px.
    pub fn line(colour: Colour) -> Self {
        Self { colour, dash: Dash::Solid, width_px: 1.4, marker: Marker::None }
    }

    /// Measured curve: a wide line that a model drawn over it leaves visible.
    pub fn measured() -> Self {
        Self { width_px: 4.0, ..Self::line(Colour::Sky) }
    }

    /// Model curve: a thin dark line on top.
    pub fn model() -> Self {
        Self { width_px: 1.3, ..Self::line(Colour::Ink) }
    }

    /// Residual curve.
    pub fn residual() -> Self {
        Self { width_px: 1.0, ..Self::line(Colour::Vermillion) }
    }

    /// The `index`-th of several equals: colour, dash and marker shape all differ, so that the curves are
    /// distinct without colour. Repeats after 24.
    pub fn nth(index: usize) -> Self {
        const COLOURS: [Colour; 6] =
            [Colour::Blue, Colour::Vermillion, Colour::Green, Colour::Orange, Colour::Purple, Colour::Sky];
        const DASHES: [Dash; 4] = [Dash::Solid, Dash::Dashed, Dash::DashDot, Dash::Dotted];
        let colour = COLOURS[index % COLOURS.len()];
        let dash = DASHES[(index + index / COLOURS.len()) % DASHES.len()];
        Self { colour, dash, width_px: 1.6, marker: Marker::None }
    }

    /// Sets the `index`-th marker shape, at every point.
    #[must_use]
    pub fn marked(mut self, index: usize) -> Self {
        const SHAPES: [Marker; 5] =
            [Marker::Circle, Marker::Square, Marker::Triangle, Marker::Diamond, Marker::Cross];
        self.marker = SHAPES[index % SHAPES.len()];
        self
    }

    /// Sets the marker.
    #[must_use]
    pub fn with_marker(mut self, marker: Marker) -> Self {
        self.marker = marker;
        self
    }

    /// Sets the line pattern.
    #[must_use]
    pub fn with_dash(mut self, dash: Dash) -> Self {
        self.dash = dash;
        self
    }

    /// Sets the line width \[px\].
    #[must_use]
    pub fn with_width(mut self, width_px: f64) -> Self {
        self.width_px = width_px;
        self
    }
}
