//! Figures (SVG) and the self-contained HTML report.
#![forbid(unsafe_code)]

/// Appends formatted text to a string, which cannot fail.
macro_rules! put {
    ($out:expr, $($arg:tt)*) => {{
        use std::fmt::Write as _;
        let _ = $out.write_fmt(format_args!($($arg)*));
    }};
}

pub mod article;
mod base64;
mod escape;
pub mod figure;
pub mod identification;
pub mod number;
pub mod page;
mod write;

pub use write::{write_figures, write_page};
