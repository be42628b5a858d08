//! Every kind of figure and block on two pages, to be looked at after a change of their look:
//! `cargo run -p hysteron-article --example gallery -- OUT_DIR [RECORD.csv]`
//!
//! The record has the columns time, input, output and a header line. Without one a synthetic loop is drawn.
//! The "model" is the record's own mean loop, delayed by two samples: there is no identification here.

use std::path::{Path, PathBuf};

use hysteron_article::page::{ComparisonRow, ComparisonTable};
use hysteron_model::validate::{residual_input_correlation, residual_whiteness};
use hysteron_report::figure::{
    Axis, ConvergenceCurve, Figure, FrequencyResponseCurve, Panel, Series, Style, convergence,
    errors_by_category, errors_by_frequency, histogram,
};
use hysteron_report::identification::{
    IdentificationReportData, ParameterRow, ScoreRow, identification_report,
};
use hysteron_report::page::{Block, Highlight, Page, Section};
use hysteron_report::record_curves::RecordCurves;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let folder = arguments.next().ok_or("usage: gallery OUT_DIR [RECORD.csv]")?;
    let record = match arguments.next() {
        Some(path) => read(&path)?,
        None => synthetic(),
    };
    std::fs::create_dir_all(&folder)?;
    for (name, page) in [("identification", identification(record)), ("article", article())] {
        std::fs::write(folder.join(format!("{name}.html")), page.to_html())?;
        for (i, figure) in page.figures().iter().enumerate() {
            let stem = folder.join(format!("{name}-{}", i + 1));
            std::fs::write(stem.with_extension("svg"), figure.to_svg())?;
            #[cfg(feature = "png")]
            std::fs::write(stem.with_extension("png"), figure.to_png(2.0)?)?;
        }
    }
    Ok(())
}

fn read(path: &Path) -> Result<RecordCurves, Box<dyn std::error::Error>> {
    let text = std::fs::read_to_string(path)?;
    let mut columns = [const { Vec::new() }; 3];
    for line in text.lines().skip(1) {
        for (column, field) in columns.iter_mut().zip(line.split(',')) {
            column.push(field.trim().parse()?);
        }
    }
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let [time_s, u, measured] = columns;
    Ok(curves(name, time_s, u, measured))
}

fn synthetic() -> RecordCurves {
    let time_s: Vec<f64> = (0..8000).map(|k| f64::from(k) * 0.005).collect();
    let u: Vec<f64> = time_s.iter().map(|t| 1.8 + 1.8 * (std::f64::consts::TAU * t).sin()).collect();
    let y = time_s.iter().map(|t| 22.0 * (std::f64::consts::TAU * t - 0.25).sin() - 97.0).collect();
    curves("synthetic".into(), time_s, u, y)
}

fn curves(name: String, time_s: Vec<f64>, u: Vec<f64>, measured: Vec<f64>) -> RecordCurves {
    let period = 200.min(measured.len().max(1));
    let mean: Vec<f64> = (0..period)
        .map(|k| {
            let values: Vec<f64> = measured.iter().skip(period + k).step_by(period).copied().collect();
            values.iter().sum::<f64>() / values.len().max(1) as f64
        })
        .collect();
    let model: Vec<f64> = (0..measured.len()).map(|k| mean[(k + period - 2) % period]).collect();
    let residual: Vec<f64> = measured.iter().zip(&model).map(|(y, model)| y - model).collect();
    let scored = vec![true; residual.len()];
    RecordCurves {
        segments: Vec::new(),
        sines: Vec::new(),
        gain_unit: String::new(),
        name,
        role: "fitted".into(),
        time_s,
        input: ("voltage".into(), "V".into()),
        autocorrelation: residual_whiteness(&residual, &scored),
        input_correlation: residual_input_correlation(&residual, &u, &scored),
        u,
        output: ("displacement".into(), "µm".into()),
        measured,
        model,
        valid: Vec::new(),
        band: None,
        skipped_until_s: 0.5,
    }
}

fn response(label: &str, corner_hz: f64, order: f64) -> FrequencyResponseCurve {
    let frequency_hz: Vec<f64> = (0..=300).map(|k| 0.1 * 10f64.powf(f64::from(k) / 75.0)).collect();
    FrequencyResponseCurve {
        label: label.into(),
        magnitude: frequency_hz.iter().map(|f| (1.0 + (f / corner_hz).powi(2)).powf(-order / 2.0)).collect(),
        phase_deg: frequency_hz.iter().map(|f| -order * (f / corner_hz).atan().to_degrees()).collect(),
        frequency_hz,
        as_points: false,
    }
}

fn runs(label: &str, rate: f64, floor: f64) -> ConvergenceCurve {
    let x: Vec<f64> = (0..=150).map(f64::from).collect();
    let run = |r: i32| {
        x.iter().map(move |g| {
            floor * (1.0 + 0.1 * f64::from(r)) + 2.0 * (-rate * g * (0.6 + 0.05 * f64::from(r))).exp()
        })
    };
    ConvergenceCurve { label: label.into(), runs: (0..21).map(|r| run(r).collect()).collect(), x }
}

fn identification(record: RecordCurves) -> Page {
    let parameter = |block: &str, symbol: &str, meaning: &str, value, unit: &str, std_error| ParameterRow {
        block: block.into(),
        symbol: symbol.into(),
        meaning: meaning.into(),
        value,
        unit: unit.into(),
        std_error,
        interval: None,
        is_profiled: false,
        note: if std_error.is_some() { String::new() } else { "fixed".into() },
    };
    let mut single = runs("least squares", 0.08, 0.05);
    single.runs.truncate(1);
    identification_report(&IdentificationReportData {
        title: "Stack 7, record.csv: Bouc–Wen hysteresis, fractional-order dynamics".into(),
        model_name: "stack".into(),
        summary: "Improved Bouc–Wen hysteresis, cubic, followed by first-order dynamics with delay".into(),
        highlights: vec![
            Highlight::new("RMSE", "0.164", "µm"),
            Highlight::new("largest error", "0.71", "µm"),
            Highlight::new("RMSE over stroke", "0.36", "%"),
            Highlight::new("loop sense", "counter-clockwise", ""),
        ],
        warnings: vec![
            "β and γ are hardly separated by this record: every loop in it has the same amplitude.".into(),
        ],
        limits: vec![
            "One amplitude repeated 40 times does not show how the loop shrinks with amplitude.".into(),
            "Nothing above 5 Hz was excited: the order of the dynamics is a guess from the start-up \
             transient."
                .into(),
        ],
        equations: vec!["v = l₁u + l₂u² + l₃u³ − z".into(), "ż = α u̇ − β |u̇| z |z|ⁿ⁻¹ − γ u̇ |z|ⁿ".into()],
        parameters: vec![
            parameter("hysteresis", "α", "slope of the hysteretic part", 9.4567, "µm/V", Some(0.21)),
            parameter("hysteresis", "β", "rate of saturation", 0.8123, "1/V", Some(0.0345)),
            parameter("hysteresis", "γ", "asymmetry of saturation", -0.0123, "1/V", Some(0.0311)),
            parameter("hysteresis", "n", "sharpness", 1.0, "", None),
            parameter("dynamics", "b", "gain", 5.2589e8, "s⁻²", Some(1.3e5)),
            parameter("dynamics", "τ", "dead time", 0.0101, "s", Some(0.00034)),
        ],
        verdicts: vec![
            ("loop sense".into(), "counter-clockwise: displacement lags voltage".into()),
            ("stability".into(), "all poles are in the left half-plane".into()),
        ],
        scores: vec![
            ScoreRow {
                record: record.name.clone(),
                role: "fitted".into(),
                samples: 7927,
                skipped: 100,
                unit: "µm".into(),
                rmse: 0.16423,
                max_abs_error: 0.712,
                rmse_percent_of_stroke: 0.362,
                max_percent_of_stroke: 1.57,
                fit_percent: 98.94,
            },
            ScoreRow {
                record: "minor loops".into(),
                role: "held out".into(),
                samples: 12000,
                skipped: 0,
                unit: "µm".into(),
                rmse: 0.2811,
                max_abs_error: 1.04,
                rmse_percent_of_stroke: 0.62,
                max_percent_of_stroke: 2.3,
                fit_percent: 97.2,
            },
        ],
        score_definitions: vec![
            "RMSE: √(mean of (y − ŷ)²) of the simulation, not of a one-step prediction.".into(),
            "fit: 100 (1 − ‖y − ŷ‖ / ‖y − ȳ‖). Stroke: max y − min y over the scored samples.".into(),
        ],
        preparation: vec![
            "Offset of the sensor removed: −97.3 µm.".into(),
            "No sample was resampled.".into(),
        ],
        records: vec![record],
        convergence: vec![single],
        objective_unit: "µm".into(),
        frequency_response: vec![response("", 12.0, 1.0)],
        excited_hz: Some((0.9, 5.0)),
        magnitude_unit: String::new(),
        correlations: vec![hysteron_identify::Correlation {
            step: "static block".into(),
            names: vec!["α".into(), "β".into(), "γ".into()],
            matrix: vec![vec![1.0, 0.97, -0.41], vec![0.97, 1.0, -0.55], vec![-0.41, -0.55, 1.0]],
            condition_number: 84.0,
        }],
        provenance: vec![("program".into(), "hysteron 0.1.0".into()), ("seed".into(), "1".into())],
        commands: vec!["hysteron identify record.csv -o model.json --report report.html".into()],
        footer: vec!["hysteron 0.1.0".into()],
        ..IdentificationReportData::default()
    })
}

fn article() -> Page {
    let table = ComparisonTable {
        caption: "Table 3. Errors on sines, classic Bouc–Wen".into(),
        row_header: "frequency".into(),
        quantities: vec![("max |error|".into(), "µm".into()), ("RMSE".into(), "µm".into())],
        rows: [
            (10, "0.5000", "0.1127"),
            (20, "0.5161", "0.1095"),
            (50, "0.6292", "0.1411"),
            (100, "1.2012", "0.2698"),
        ]
        .into_iter()
        .map(|(f, max, rmse)| ComparisonRow {
            name: format!("{f} Hz"),
            printed: vec![max.into(), rmse.into()],
            here: vec![format!("{:.2}", 0.08 * f64::from(f)), format!("{:.3}", 0.03 * f64::from(f))],
            highlight: f == 100,
        })
        .collect(),
        notes: vec!["The bench is simulated: compare order and ratios, not absolute values.".into()],
        ..ComparisonTable::default()
    };
    let frequencies = [10.0, 20.0, 50.0, 100.0];
    let models: Vec<(String, Vec<f64>)> =
        [("classic", 0.05), ("integer order", 0.02), ("ARX", 0.015), ("fractional", 0.004)]
            .map(|(name, k)| (name.to_owned(), frequencies.iter().map(|f| k * f).collect()))
            .to_vec();
    let cases = frequencies.map(|f| format!("{f} Hz"));
    let axis = || Axis::linear("voltage", "V");
    let mut loops =
        Figure::new("Figure 8. Loops at four frequencies").subtitled("simulated bench").in_columns(2);
    for f in frequencies {
        let phase: Vec<f64> = (0..=4000).map(|k| f64::from(k) * std::f64::consts::TAU / 1000.0).collect();
        let u: Vec<f64> = phase.iter().map(|p| 5.0 - 5.0 * p.cos()).collect();
        let mut panel = Panel::new(axis(), Axis::linear("displacement", "µm")).titled(format!("{f} Hz"));
        let y = |lag: f64| phase.iter().map(|p| 15.0 - 15.0 * (p - lag).cos()).collect::<Vec<f64>>();
        panel = panel.series(Series::line("bench", u.clone(), y(0.2 + f * 0.003), Style::measured()));
        for (i, name) in ["classic", "integer order", "fractional"].iter().enumerate() {
            panel =
                panel.series(Series::line(*name, u.clone(), y(0.2 + f * 0.001 * i as f64), Style::nth(i)));
        }
        loops = loops.panel(panel);
    }
    let errors: Vec<f64> =
        (0..20_000).map(|k| (f64::from(k) * 0.7).sin() + (f64::from(k) * 0.31).cos()).collect();
    Page::new("The article, reproduced")
        .subtitled("Every number of the article beside ours, on a simulated bench")
        .section(
            Section::new("Convergence").block(
                convergence(
                    "Figure 6. Convergence of the optimisers",
                    "generation",
                    Axis::log("best RMSE", "µm"),
                    &[runs("DE", 0.05, 0.025), runs("ABC", 0.07, 0.014), runs("DE-ABC", 0.12, 0.012)],
                )
                .captioned(
                    "Median over 21 seeds; the shaded bands run from the lower to the upper quartile.",
                ),
            ),
        )
        .section(
            Section::new("Errors").block(table.to_table()).block(
                errors_by_frequency("Errors", &frequencies, Axis::log("RMSE", "µm"), &models)
                    .captioned("RMSE by frequency."),
            ),
        )
        .section(
            Section::new("Loops")
                .block(loops.captioned("Measured on the bench and simulated by three models."))
                .block(errors_by_category("RMSE", "", &cases, Axis::linear("RMSE", "µm"), &models)),
        )
        .section(
            Section::new("Residuals")
                .block(histogram("Residuals", Axis::linear("residual", "µm"), &errors, 40))
                .block(Block::good("The article's claim that the loop hardly changes below 5 Hz holds here."))
                .block(Figure::new("An empty figure").panel(Panel::new(axis(), Axis::log("RMSE", "µm")))),
        )
}
