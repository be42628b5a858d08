//! Figures (SVG) and the self-contained HTML report.
#![forbid(unsafe_code)]
