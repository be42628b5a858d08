//! The page of the reproduced article: printed and reproduced numbers side by side.
//!
//! [`page`] lays out a [`Reproduction`]; [`tables`] gives every table of it as comma-separated values.

mod comparison;
mod csv;
mod loops;
mod models;
pub mod optimizer_study;
mod optimizers;
mod overview;
mod printed_numbers;
mod recovery;
mod static_block;

pub use comparison::{ComparisonRow, ComparisonTable};
pub use csv::{CsvTable, tables};

use crate::Reproduction;

use hysteron_report::page::Page;

/// Second title line of every figure.
const SIMULATED: &str = "simulated bench";

/// Lays the reproduction out in the order of the article.
pub fn page(found: &Reproduction) -> Page {
    Page::new("The article, reproduced")
        .subtitled(
            "Rate-Dependent Modeling of Piezoelectric Actuators for Nano Manipulation Based on Fractional \
             Hammerstein Model: its experiments on a simulated bench, its claims put to the test",
        )
        .section(overview::summary(found))
        .section(overview::claims(found))
        .section(overview::readings(found))
        .section(loops::section(found))
        .section(optimizers::section(found))
        .section(static_block::section(found))
        .section(models::transfer_function_section(found))
        .section(models::table_3_section(found))
        .section(printed_numbers::section(found))
        .section(recovery::section(found))
        .section(overview::repeat(found))
}
