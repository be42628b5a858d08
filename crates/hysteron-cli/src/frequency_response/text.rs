//! The comparison for people and for programs.

use hysteron_identify::frequency_response::{Candidate, FrequencyResponse, Weighting};
use hysteron_report::number::{significant, with_std_error};
use serde::Serialize;

use super::{Found, empirical};
use crate::console;

pub const HEADER: [&str; 6] =
    ["structure", "formula", "parameters", "rms error [%]", "largest error [%]", "AIC above the best"];

/// One row of the comparison.
pub fn cells(candidate: &Candidate, best: f64) -> [String; 6] {
    let fit = &candidate.fit;
    [
        candidate.name.clone(),
        fit.structure.to_string(),
        fit.parameters.len().to_string(),
        significant(100.0 * fit.relative_rms, 3),
        significant(100.0 * fit.largest.0, 3),
        format!("{:.0}", fit.aic - best),
    ]
}

pub fn lowest_aic(found: &Found) -> f64 {
    found.candidates.iter().map(|c| c.fit.aic).fold(f64::INFINITY, f64::min)
}

/// Points, band and weights in one sentence.
pub fn what(response: &FrequencyResponse) -> String {
    let (low, high) = response.range_hz();
    let weights = match Weighting::of(response) {
        Weighting::Relative => "each counted by its relative error",
        Weighting::Uncertainty => "each counted by its uncertainty",
    };
    format!(
        "{}: {} points from {} to {} Hz, {weights}.",
        response.name,
        response.len(),
        significant(low, 4),
        significant(high, 4)
    )
}

/// What the criterion means.
pub const ABOUT_AIC: &str = "AIC: Akaike's criterion, lower is better; it takes residuals for independent, which those of a wrong structure are \
    not, so read small differences as none.";

pub fn text(found: &Found) -> String {
    let best = lowest_aic(found);
    let mut table = console::table(&HEADER);
    for candidate in &found.candidates {
        table.add_row(cells(candidate, best));
    }
    let explanations: String =
        found.candidates.iter().map(|c| format!("{}: {}\n", c.name, c.explanation)).collect();
    let mut parameters = console::table(&["structure", "parameter", "value", "std. error", "unit"]);
    for candidate in &found.candidates {
        for p in &candidate.fit.parameters {
            let (value, error) = with_std_error(p.value, p.std_error);
            let error = match (p.on_edge, error.is_empty()) {
                (true, _) => "on the edge".to_owned(),
                (false, true) => "-".to_owned(),
                (false, false) => error,
            };
            parameters.add_row([candidate.name.clone(), p.name.clone(), value, error, p.unit.clone()]);
        }
    }
    let records = found.empirical.as_ref().map_or_else(String::new, |e| empirical::words(e) + "\n");
    format!("{}\n{records}\n{table}\n\n{explanations}\n{parameters}\n\n{ABOUT_AIC}\n", what(&found.response))
}

/// What `--json` prints.
#[derive(Serialize)]
pub struct Summary {
    response: String,
    unit: String,
    points: usize,
    band_hz: (f64, f64),
    weighting: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    empirical: Option<empirical::Summary>,
    structures: Vec<StructureSummary>,
}

#[derive(Serialize)]
struct StructureSummary {
    name: String,
    formula: String,
    rms_error_percent: f64,
    largest_error_percent: f64,
    largest_error_at_hz: f64,
    aic: f64,
    starts: usize,
    starts_in_best_optimum: usize,
    explanation: String,
    parameters: Vec<ParameterSummary>,
}

#[derive(Serialize)]
struct ParameterSummary {
    name: String,
    value: f64,
    unit: String,
    std_error: Option<f64>,
    on_edge: bool,
}

pub fn summary(found: &Found) -> Summary {
    let response = &found.response;
    let structure = |c: &Candidate| StructureSummary {
        name: c.name.clone(),
        formula: c.fit.structure.to_string(),
        rms_error_percent: 100.0 * c.fit.relative_rms,
        largest_error_percent: 100.0 * c.fit.largest.0,
        largest_error_at_hz: c.fit.largest.1,
        aic: c.fit.aic,
        starts: c.fit.starts,
        starts_in_best_optimum: c.fit.agreeing,
        explanation: c.explanation.clone(),
        parameters: c
            .fit
            .parameters
            .iter()
            .map(|p| ParameterSummary {
                name: p.name.clone(),
                value: p.value,
                unit: p.unit.clone(),
                std_error: p.std_error,
                on_edge: p.on_edge,
            })
            .collect(),
    };
    Summary {
        response: response.name.clone(),
        unit: response.unit.clone(),
        points: response.len(),
        band_hz: response.range_hz(),
        weighting: match Weighting::of(response) {
            Weighting::Relative => "relative",
            Weighting::Uncertainty => "uncertainty",
        },
        empirical: found.empirical.as_ref().map(empirical::summary),
        structures: found.candidates.iter().map(structure).collect(),
    }
}
