//! Figures (SVG) and self-contained HTML pages.
//!
//! In the order of use: a [`figure::Figure`] is panels of series with units; a [`page::Page`] is sections of
//! text, tables and figures; [`identification::identification_report`] composes
//! what the `hysteron` command shows; [`write_page`] puts it on the disk, [`figure_files`] are its figures.
//! [`number`] formats values for tables.
//!
//! Pages load nothing, work offline and without script, and print on A4. They hold curves reduced to what a
//! screen can show ([`figure::decimate`]), so that a record of any length gives a file of bounded size.
#![forbid(unsafe_code)]

/// Appends formatted text to a string, which cannot fail.
macro_rules! put {
    ($out:expr, $($arg:tt)*) => {{
        use std::fmt::Write as _;
        let _ = $out.write_fmt(format_args!($($arg)*));
    }};
}

mod base64;
pub mod comparison;
mod escape;
pub mod figure;
pub mod fit;
pub mod fleet;
pub mod frequency_response;
pub mod identification;
pub mod model;
mod modes;
pub mod modes_comparison;
pub mod page;
pub mod record_curves;
pub mod records;
pub mod results;
pub mod shell;
mod sines;
pub mod starts;
mod titles;
pub mod tracking;
pub mod validation;
mod write;

pub use hysteron_numeric::number;
pub use write::{figure_files, write_page};
