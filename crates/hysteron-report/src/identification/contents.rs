//! Contents of the report, from the identification itself.

use super::{DegreeRow, IdentificationReportData, ScoreRow, StructureRow};
use crate::figure::{ConvergenceCurve, FrequencyResponseCurve};
use crate::number::significant;
use crate::page::Highlight;
use crate::record_curves::{BandWidths, RecordCurves, is_simulated};
use crate::titles;
use hysteron_identify::structure::Neighbours;
use hysteron_identify::{
    FindingKind, Identification, IdentifyError, Method, PredictionBand, RecordFit, RecordRole,
};
use hysteron_model::dynamics::{Dynamics, TransferFunction};
use hysteron_model::model_file::ModelFile;
use hysteron_model::validate::definitions;

use super::degrees::reason;
use super::parameters;
use super::searches::starts;

/// Frequencies at which the response is drawn.
const RESPONSE_POINTS: usize = 400;

/// Most terms of a polynomial that the report prints.
const PRINTED_TERMS: usize = 9;

/// Scores in the report's table, by key.
const SHOWN: [&str; 7] = [
    "samples",
    "skipped_samples",
    "rmse",
    "max_abs_error",
    "rmse_percent_of_stroke",
    "max_percent_of_stroke",
    "fit_percent",
];

/// Everything the report shows.
pub(super) fn data(
    model_name: &str,
    found: &Identification,
    file: &ModelFile,
    others: Option<&Result<Neighbours, IdentifyError>>,
) -> IdentificationReportData {
    let of_kind = |kind| found.findings.iter().filter(move |f| f.kind == kind).map(|f| f.text.clone());
    let unit = found.records.first().map(|r| r.data.y_unit.to_string()).unwrap_or_default();
    IdentificationReportData {
        title: title(found, file),
        model_name: model_name.to_owned(),
        summary: summary(found),
        simulated: found.records.iter().any(|r| is_simulated(&r.data.name)),
        highlights: highlights(found),
        warnings: of_kind(FindingKind::Warning).collect(),
        limits: of_kind(FindingKind::Advice).collect(),
        equations: equations(found),
        parameters: parameters::rows(found, file),
        verdicts: found
            .findings
            .iter()
            .filter(|f| f.kind == FindingKind::Verdict)
            .map(|f| (f.topic.to_string(), f.text.clone()))
            .collect(),
        scores: found
            .records
            .iter()
            .map(|r| ScoreRow {
                record: r.data.name.clone(),
                role: format!("fitted ({})", role_name(r.role)),
                samples: r.scores.samples,
                skipped: r.scores.skipped_samples,
                unit: r.data.y_unit.to_string(),
                rmse: r.scores.rmse,
                max_abs_error: r.scores.max_abs_error,
                rmse_percent_of_stroke: r.scores.rmse_percent_of_stroke.unwrap_or(f64::NAN),
                max_percent_of_stroke: r.scores.max_percent_of_stroke.unwrap_or(f64::NAN),
                fit_percent: r.scores.fit_percent.unwrap_or(f64::NAN),
            })
            .collect(),
        score_definitions: definitions()
            .iter()
            .filter(|d| SHOWN.contains(&d.key))
            .map(|d| format!("{}: {}", d.name, d.meaning))
            .collect(),
        preparation: found.treatment.clone(),
        records: found
            .records
            .iter()
            .zip(left_out(found))
            .map(|(fit, left_out)| curves(fit, left_out, file))
            .collect(),
        convergence: found
            .searches
            .iter()
            .map(|s| ConvergenceCurve {
                label: format!("{} ({})", s.step, s.algorithm),
                x: s.outcome.history.iter().map(|h| h.evaluations as f64).collect(),
                runs: vec![s.outcome.history.iter().map(|h| h.best_cost).collect()],
            })
            .collect(),
        convergence_note: convergence_note(found, &unit),
        starts: starts(found, &unit),
        objective: if found.method == Method::Joint { "weighted RMSE".into() } else { "RMSE".into() },
        objective_unit: unit,
        convergence_x_label: "cost evaluations".into(),
        frequency_response: response(found).into_iter().collect(),
        excited_hz: found.excited_hz,
        magnitude_unit: String::new(),
        correlations: found.correlations.clone(),
        degrees: found
            .structure
            .degrees
            .iter()
            .map(|tried| DegreeRow {
                degree: tried.degree,
                rmse: tried.rmse,
                bic: tried.bic,
                chosen: tried.degree == found.structure.degree,
            })
            .collect(),
        degrees_note: reason(&found.structure.degrees, found.structure.degree),
        structures: others.map_or_else(Vec::new, structures),
        structures_note: others.map_or_else(String::new, |others| about_structures(found, others)),
        provenance: provenance(file),
        commands: file.provenance.iter().filter_map(|p| p.command.clone()).collect(),
        footer: vec![file.provenance.as_ref().map(|p| p.program.clone()).unwrap_or_default()],
    }
}

fn role_name(role: RecordRole) -> &'static str {
    match role {
        RecordRole::QuasiStatic => "quasi-static",
        RecordRole::Dynamic => "dynamic",
    }
}

/// Dynamic block in words, `None` without one.
fn block(dynamics: &Dynamics) -> Option<&'static str> {
    match dynamics {
        Dynamics::None => None,
        Dynamics::Integer(g) if g.denominator.len() == 2 => Some("a first-order lag"),
        Dynamics::Integer(_) => Some("integer-order dynamics"),
        Dynamics::Arx(_) => Some("a difference equation"),
        Dynamics::Fractional(_) => Some("fractional-order dynamics"),
    }
}

fn hysteresis_title(found: &Identification) -> String {
    let operator = &found.model.hysteresis;
    operator.form().description().title(operator.weights().len())
}

/// Device, records and structure.
fn title(found: &Identification, file: &ModelFile) -> String {
    let hysteresis = hysteresis_title(found);
    let structure = match block(&found.model.dynamics) {
        Some(dynamics) => format!("{hysteresis}, {dynamics}"),
        None => hysteresis,
    };
    titles::title(file.name.as_deref(), found.records.iter().map(|r| r.data.name.as_str()), &structure)
}

fn summary(found: &Identification) -> String {
    let degree = found.structure.degree;
    let dynamics = match (block(&found.model.dynamics), &found.model.dynamics) {
        (None, _) if found.model.delay_s > 0.0 => "behind a delay, without dynamics".to_owned(),
        (None, _) => "without dynamics".to_owned(),
        (Some(block), Dynamics::Arx(_)) => format!("followed by {block}"),
        (Some(block), _) => format!("followed by {block} with delay"),
    };
    let how = match found.method {
        _ if found.model.dynamics == Dynamics::None => "",
        Method::Joint => "; identified from all records in one joint fit",
        Method::TwoStep => "; identified in two steps, hysteresis first",
    };
    let hysteresis = format!("{} with a polynomial of degree {degree}", hysteresis_title(found));
    format!("{hysteresis}, {dynamics}{how}")
}

fn highlights(found: &Identification) -> Vec<Highlight> {
    let Some(worst) = found.records.iter().max_by(|a, b| a.scores.rmse.total_cmp(&b.scores.rmse)) else {
        return Vec::new();
    };
    let unit = worst.data.y_unit.to_string();
    let scores = &worst.scores;
    let mut list = vec![
        Highlight::new("RMSE (training)", significant(scores.rmse, 3), unit.clone()),
        Highlight::new("largest error", significant(scores.max_abs_error, 3), unit),
    ];
    if let Some(percent) = scores.rmse_percent_of_stroke {
        list.push(Highlight::new("RMSE over stroke", significant(percent, 2), "%"));
    }
    if found.model.delay_s > 0.0 {
        list.push(Highlight::new("delay", significant(1e3 * found.model.delay_s, 3), "ms"));
    }
    list
}

fn equations(found: &Identification) -> Vec<String> {
    let powers = ["u", "u²", "u³", "u⁴", "u⁵", "u⁶", "u⁷", "u⁸", "u⁹"];
    let polynomial: Vec<String> = powers
        .iter()
        .take(found.structure.degree)
        .enumerate()
        .map(|(i, u)| format!("l{}·{u}", subscript(i + 1)))
        .collect();
    let polynomial = polynomial.join(" + ");
    let family = found.model.hysteresis.form().description();
    let mut list = family.printed_equations(&polynomial);
    match &found.model.dynamics {
        Dynamics::None => list.push("y(t) = offset + v(t − τ)".into()),
        Dynamics::Integer(g) | Dynamics::Fractional(g) => {
            list.push("y(t) = offset + (G ∗ v)(t − τ)".into());
            let (above, below) = (g.numerator.len(), g.denominator.len());
            list.push(if below > PRINTED_TERMS {
                format!("G(s): a ratio of {above} over {below} powers of s, written out in the model file")
            } else {
                format!("G(s) = {g}{}", if is_article_form(g) { "   (form of Eq. 13)" } else { "" })
            });
            list.extend(
                found.structure.creep.equations().map(|equations| format!("creep in G: {equations}")),
            );
        }
        Dynamics::Arx(_) => list.push("y = offset + B(z)/A(z) v(t − τ)   (sampled)".into()),
    }
    list
}

/// b / (s^α₂ + c₁ s^α₁ + c₀).
fn is_article_form(g: &TransferFunction) -> bool {
    g.numerator.len() == 1 && g.denominator.len() == 3 && g.denominator[0].order == 0.0
}

fn subscript(i: usize) -> String {
    i.to_string().chars().map(|c| char::from_u32(0x2080 + c.to_digit(10).unwrap_or(0)).unwrap_or(c)).collect()
}

/// Samples left out at the start of every record.
fn left_out(found: &Identification) -> Vec<usize> {
    let mut quasi_static = found.structure.left_out.iter().copied();
    let of = |r: &RecordFit| match r.role {
        RecordRole::QuasiStatic => quasi_static.next().unwrap_or(0),
        RecordRole::Dynamic => 0,
    };
    found.records.iter().map(of).collect()
}

/// Note on why the search's own RMSE is not the score: weighted records, or creep that the model does not
/// have.
fn convergence_note(found: &Identification, unit: &str) -> String {
    let (Some(search), Some(record)) = (found.searches.first(), found.records.first()) else {
        return String::new();
    };
    if let Some(reduction) = found.reduction {
        return format!(
            "{} The last fit ends at {} {unit}; each record is weighted by its noise.",
            reduction.describe(),
            significant(search.outcome.cost, 4)
        );
    }
    if found.structure.creeps.iter().all(|creep| *creep == 0.0) {
        return String::new();
    }
    format!(
        "The search ends at {} {unit} where the score is {} {unit}: the fit allows for a slow creep of each \
         quasi-static record so that it does not distort the loop; the model has no creep, and the score \
         includes it.",
        significant(search.outcome.cost, 3),
        significant(record.scores.rmse, 3)
    )
}

/// The identified structure and its neighbours.
fn structures(others: &Result<Neighbours, IdentifyError>) -> Vec<StructureRow> {
    let Ok(others) = others else { return Vec::new() };
    let lowest = others.entries.iter().map(|e| e.bic).fold(f64::INFINITY, f64::min);
    let row = |(place, entry): (usize, &hysteron_identify::structure::Neighbour)| StructureRow {
        name: entry.candidate.to_string(),
        parameters: entry.parameters,
        rmse: entry.rmse,
        bic_above: entry.bic - lowest,
        chosen: place == 0,
    };
    others.entries.iter().enumerate().map(row).collect()
}

/// Method by which the structures were compared, or the reason why they were not.
fn about_structures(found: &Identification, others: &Result<Neighbours, IdentifyError>) -> String {
    match others {
        Ok(others) => format!(
            "Each fitted to the same records, from the identified model on, thinned where they are \
             oversampled; shaded: the one identified. The polynomial is a cubic where no degree is named. \
             RMSE over all samples, on the data of the fit: a richer structure always has a lower one. BIC \
             counts parameters against it, over the {:.0} independent samples (of {}) that the residuals are \
             worth; differences below 10 mean little. Predictive accuracy is measured on held-out records: \
             hysteron compare {}.",
            others.independent_samples,
            others.samples,
            found
                .records
                .iter()
                .map(|r| r.data.source.as_ref().map_or(r.data.name.as_str(), |s| s.path.as_str()))
                .collect::<Vec<_>>()
                .join(" ")
        ),
        Err(IdentifyError::CannotRank { because, measure }) => {
            format!("Not compared: {because}. To distinguish structures, measure {measure}.")
        }
        Err(error) => format!("Not compared: {error}."),
    }
}

/// Half the widths of the bands, by the fit or else by the model file. `None` where they are unknown.
fn band(fit: &RecordFit, file: &ModelFile) -> Option<BandWidths> {
    let of_file = || {
        let band = PredictionBand::of_file(file, &fit.data.u, &fit.data.time, &fit.start).ok()?;
        // A training record has its own residual; the misfit is for records of another kind.
        Some(PredictionBand { noise: fit.scores.rmse, misfit: None, ..band })
    };
    let band = fit.band.clone().or_else(of_file)?;
    Some(BandWidths { model: band.of_output(), measurement: band.of_measurement() })
}

fn curves(fit: &RecordFit, left_out: usize, file: &ModelFile) -> RecordCurves {
    let curves = RecordCurves::new(&fit.data, &fit.simulated, fit.scores.offset, left_out);
    let sines = fit.sines.clone();
    RecordCurves { role: role_name(fit.role).to_owned(), band: band(fit, file), sines, ..curves }
}

fn response(found: &Identification) -> Option<FrequencyResponseCurve> {
    let rate = found.model.sample_rate_hz?;
    let (low, high) = found.excited_hz?;
    let (low, high) = ((0.1 * low).max(1e-3), (20.0 * high).min(0.5 * rate));
    let frequency_hz: Vec<f64> = (0..RESPONSE_POINTS)
        .map(|k| low * (high / low).powf(k as f64 / (RESPONSE_POINTS - 1) as f64))
        .collect();
    if found.model.dynamics == Dynamics::None {
        return None;
    }
    let values = found.model.frequency_response(&frequency_hz).ok()?;
    let mut phase_deg: Vec<f64> = Vec::with_capacity(values.len());
    for value in &values {
        let phase = value.arg().to_degrees();
        let turns = phase_deg.last().map_or(0.0, |last| ((last - phase) / 360.0).round());
        phase_deg.push(phase + 360.0 * turns);
    }
    Some(FrequencyResponseCurve {
        label: "dynamic block with delay".into(),
        magnitude: values.iter().map(|v| v.norm()).collect(),
        phase_deg,
        frequency_hz,
        as_points: false,
    })
}

fn provenance(file: &ModelFile) -> Vec<(String, String)> {
    let Some(p) = &file.provenance else { return Vec::new() };
    let mut list = vec![("program".to_owned(), p.program.clone())];
    list.extend(p.created.clone().map(|c| ("created".to_owned(), c)));
    for record in &p.records {
        list.push(("record".to_owned(), format!("{} ({} samples)", record.path, record.samples)));
        list.extend(record.sha256.clone().map(|s| ("SHA-256".to_owned(), s)));
    }
    list.extend(p.options.iter().map(|(name, value)| (name.clone(), value.clone())));
    list.extend(p.seed.map(|s| ("seed".to_owned(), s.to_string())));
    list
}
