//! Figures as PNG, for places that show no SVG (feature `png`).

use hysteron_numeric::display::exact;
use resvg::{tiny_skia, usvg};

use super::Figure;

/// Why a figure could not be rasterised.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PngError {
    /// No font is installed, so the picture would have no text.
    #[error("no font was found on this system: install one, for example DejaVu Sans or Liberation Sans")]
    NoFont,
    /// The picture would have no or too many pixels.
    #[error(
        "a scale of {scale} gives a picture of {width_px:.0} × {height_px:.0} px; choose one that gives 1 to \
         20 000 px",
        scale = exact(*.scale)
    )]
    Size {
        /// Scale asked for.
        scale: f64,
        /// Width that follows \[px\].
        width_px: f64,
        /// Height that follows \[px\].
        height_px: f64,
    },
    /// The drawing could not be read by the rasteriser.
    #[error("the drawing could not be read by the rasteriser: {0}")]
    Svg(#[from] usvg::Error),
    /// The PNG could not be encoded.
    #[error("the picture could not be encoded: {0}")]
    Encode(String),
}

impl Figure {
    /// The figure as PNG bytes; `scale` 1 gives 96 dpi, 3.125 gives 300 dpi.
    ///
    /// # Errors
    /// [`PngError`] when the system has no font, or when the size is not between 1 and 20 000 px.
    pub fn to_png(&self, scale: f64) -> Result<Vec<u8>, PngError> {
        let mut options = usvg::Options::default();
        let fonts = options.fontdb_mut();
        fonts.load_system_fonts();
        if fonts.is_empty() {
            return Err(PngError::NoFont);
        }
        let tree = usvg::Tree::from_str(&self.to_svg(), &options)?;
        let (width_px, height_px) =
            (f64::from(tree.size().width()) * scale, f64::from(tree.size().height()) * scale);
        let wrong_size = PngError::Size { scale, width_px, height_px };
        let fits = |side: f64| (1.0..=20_000.0).contains(&side);
        if !(fits(width_px) && fits(height_px)) {
            return Err(wrong_size);
        }
        let Some(mut pixels) = tiny_skia::Pixmap::new(width_px.round() as u32, height_px.round() as u32)
        else {
            return Err(wrong_size);
        };
        let zoom = scale as f32;
        resvg::render(&tree, tiny_skia::Transform::from_scale(zoom, zoom), &mut pixels.as_mut());
        pixels.encode_png().map_err(|e| PngError::Encode(e.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Axis, Panel, Series, Style};
    use super::*;

    fn figure() -> Figure {
        let x: Vec<f64> = (0..100).map(f64::from).collect();
        let panel = Panel::new(Axis::linear("time", "s"), Axis::linear("displacement", "µm"));
        Figure::new("Loop").panel(panel.series(Series::line("measured", x.clone(), x, Style::model())))
    }

    #[test]
    fn a_png_has_the_size_asked_for() {
        let png = figure().to_png(2.0).unwrap();
        assert_eq!(&png[..8], b"\x89PNG\r\n\x1a\n");
        let side = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap());
        assert_eq!(side(16), 1360);
        assert!(side(20) > 400);
    }

    #[test]
    fn impossible_scales_are_refused() {
        for scale in [0.0, -1.0, f64::NAN, 1e6] {
            assert!(matches!(figure().to_png(scale), Err(PngError::Size { .. })), "{scale}");
        }
    }
}
