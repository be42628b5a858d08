//! Eq. 13, Table 3 and Figures 8–11.

use crate::{Eq13, ModelFit, ModelKind, Reproduction, SineCurves, printed};

use super::{ComparisonRow, ComparisonTable, SIMULATED};
use hysteron_report::figure::{Axis, Dash, Figure, Panel, Series, Style, errors_by_frequency};
use hysteron_report::number::fixed;
use hysteron_report::number::significant;
use hysteron_report::page::{Block, Column, Section, Table};

/// The models of the article.
fn articles_own() -> impl Iterator<Item = ModelKind> {
    ModelKind::ALL.into_iter().filter(|k| k.is_the_articles())
}

pub(super) fn transfer_function_section(found: &Reproduction) -> Section {
    let mut table = Table::new([
        Column::text("model"),
        Column::number("b", ""),
        Column::number("α₂", ""),
        Column::number("c₁", ""),
        Column::number("α₁", ""),
        Column::number("c₀", ""),
        Column::number("b / c₀", ""),
        Column::number("delay", "µs"),
        Column::number("RMSE", "µm on the sweep"),
        Column::text("at the end of its range"),
    ])
    .captioned("Eq. 13. The dynamic block, G(s) = b / (s^α₂ + c₁ s^α₁ + c₀).");
    let numbers = |g: &Eq13, digits: usize| {
        [
            significant(g.b, digits),
            fixed(g.alpha2, 4),
            significant(g.c1, digits - 1),
            fixed(g.alpha1, 4),
            significant(g.c0, digits),
            fixed(g.b / g.c0, 4),
        ]
    };
    let mut first = vec!["article (printed)".to_owned()];
    first.extend(numbers(&printed::EQ_13, 5));
    first.extend(["0".into(), "—".into(), String::new()]);
    table = table.highlighted_row(first);
    for fit in &found.models.models {
        let Some(g) = &fit.eq13 else { continue };
        let sweep = fit.fitted_rmse_um.last().map_or(f64::NAN, |(_, rmse)| *rmse);
        let mut cells = vec![fit.kind.name().to_owned()];
        cells.extend(numbers(g, 5));
        cells.extend([significant(1e6 * fit.delay_s, 3), significant(sweep, 4), bounds(fit)]);
        table = table.row(cells);
    }
    table = table.note(format!(
        "Fractional and integer order: by DE-ABC, orders and coefficients at once, {} generations of 50 \
         evaluations, as the article does. The rows by least squares are not in the article; they show what \
         each structure could reach, so that a bad search and a bad structure are not confused. The bench is \
         not a plant of this form: its coefficients cannot be compared one by one with the printed ones.",
        found.plan.generations
    ));
    let formula = found.models.model(ModelKind::Fractional).and_then(|m| m.eq13).map(|g| {
        Block::Formula(format!(
            "G(s) = {} / (s^{} + {} s^{} + {})",
            significant(g.b, 5),
            fixed(g.alpha2, 4),
            significant(g.c1, 5),
            fixed(g.alpha1, 4),
            significant(g.c0, 5)
        ))
    });
    let ended: Vec<String> = found
        .models
        .models
        .iter()
        .filter(|m| !m.at_bounds.is_empty())
        .map(|m| format!("{} ({})", m.kind.name(), bounds(m)))
        .collect();
    let mut section = Section::new("Eq. 13: the dynamic block").blocks(formula).block(table);
    if !ended.is_empty() {
        section = section.block(Block::warning(format!(
            "Some parameters ended at an end of their range: {}. Without a delay the structure of Eq. 13 \
             bends its orders to emulate the bench's delay and creep; such a fit describes the records, not \
             the stage.",
            ended.join("; ")
        )));
    }
    section
}

fn bounds(fit: &ModelFit) -> String {
    let words = |name: &String| match name.as_str() {
        "order1" => "α₁".to_owned(),
        "order2" => "α₂".to_owned(),
        "natural_frequency" => "natural frequency".to_owned(),
        other => other.to_owned(),
    };
    fit.at_bounds.iter().map(words).collect::<Vec<_>>().join(", ")
}

pub(super) fn table_3_section(found: &Reproduction) -> Section {
    let mut section = Section::new("Table 3 and Figures 8–11: the models at 10, 20, 50 and 100 Hz")
        .block(table_3(found))
        .block(Block::paragraph(
            "Read the order with care. Eq. 7 counts the mean error, and the bench creeps from rest, so \
             records of different speed lie at different heights; the table at the end of this section also \
             has the errors with the mean removed. ARX is fitted by linear least squares on the equation \
             error, with an intercept that its simulation does not use. Integer order without a delay has no \
             means but its pole to follow the bench's delay.",
        ));
    for (number, curves) in (8..).zip(&found.models.curves) {
        section = section.block(sine_figure(number, curves));
    }
    section
        .block(Block::Heading("Beyond the article".into()))
        .block(errors_figure(found))
        .block(all_models(found))
}

fn table_3(found: &Reproduction) -> Table {
    let mut rows = Vec::new();
    for row in &printed::TABLE_3 {
        for kind in articles_own() {
            let printed = match kind {
                ModelKind::Classic => Some(row.classic),
                ModelKind::Integer => Some(row.integer),
                ModelKind::Fractional => Some(row.fractional),
                _ => None,
            };
            let classic =
                found.models.score(ModelKind::Classic, row.frequency_hz).map_or(f64::NAN, |s| s.rmse_um);
            let here = found.models.score(kind, row.frequency_hz);
            rows.push(ComparisonRow {
                name: format!("{} Hz, {}", row.frequency_hz, kind.name()),
                printed: printed.map_or_else(Vec::new, |p| {
                    vec![
                        format!("{:.4}", p.max_um),
                        format!("{:.4}", p.rmse_um),
                        significant(p.rmse_um / row.classic.rmse_um, 2),
                    ]
                }),
                here: here.map_or_else(Vec::new, |s| {
                    vec![
                        significant(s.max_um, 3),
                        significant(s.rmse_um, 3),
                        significant(s.rmse_um / classic, 2),
                    ]
                }),
                highlight: kind == ModelKind::Fractional,
            });
        }
    }
    ComparisonTable {
        caption: "Table 3. Max error and RMSE of the models.".into(),
        row_header: "frequency, model".into(),
        quantities: vec![
            ("max error".into(), "µm".into()),
            ("RMSE".into(), "µm".into()),
            ("RMSE / classic".into(), String::new()),
        ],
        rows,
        notes: vec![
            "Simulation from rest over the whole sine, no offset estimated (Eq. 7). The article claims that \
             ARX is far inferior and prints no number for it. Classic Bouc–Wen: linear input function, no \
             dynamics; the others: the quadratic block of Table 2 in front of their dynamics."
                .into(),
        ],
        ..ComparisonTable::default()
    }
    .to_table()
}

/// Loop and time curve, measured and modelled, and the errors of the models.
fn sine_figure(number: usize, curves: &SineCurves) -> Figure {
    let samples = curves.time_s.len();
    let last = samples / 2;
    let volts = || Axis::linear("voltage", "V");
    let seconds = || Axis::linear("time", "s");
    let micrometres = || Axis::linear("displacement", "µm");
    let error = || Axis::linear("error", "µm");
    let shown: Vec<(usize, &str, &[f64])> = articles_own()
        .enumerate()
        .filter_map(|(i, kind)| {
            let found = curves.simulated_um.iter().find(|(k, _)| *k == kind)?;
            Some((i, kind.name(), found.1.as_slice()))
        })
        .collect();
    let measured =
        |label: &str, x: &[f64], y: &[f64]| Series::line(label, x.to_vec(), y.to_vec(), Style::measured());
    let mut panels = [
        Panel::new(volts(), micrometres()).titled("(a) hysteresis loop"),
        Panel::new(seconds(), micrometres()).titled("(b) time curve"),
        Panel::new(volts(), error()),
        Panel::new(seconds(), error()),
    ];
    let [loop_panel, time_panel, loop_error, time_error] = &mut panels;
    loop_panel.series.push(measured("measured", &curves.u_v[last..], &curves.measured_um[last..]));
    time_panel.series.push(measured("", &curves.time_s, &curves.measured_um));
    for (i, name, simulated) in shown {
        let style = Style::nth(i).with_width(1.2).with_dash(Dash::Solid);
        let difference: Vec<f64> = curves.measured_um.iter().zip(simulated).map(|(y, s)| y - s).collect();
        let line = |label: &str, x: &[f64], y: &[f64]| Series::line(label, x.to_vec(), y.to_vec(), style);
        loop_panel.series.push(line(name, &curves.u_v[last..], &simulated[last..]));
        time_panel.series.push(line("", &curves.time_s, simulated));
        loop_error.series.push(line("", &curves.u_v[last..], &difference[last..]));
        time_error.series.push(line("", &curves.time_s, &difference));
    }
    let f = curves.frequency_hz;
    let mut figure = Figure::new(format!("Figure {number}. Models at {f} Hz"))
        .subtitled(SIMULATED)
        .in_columns(2)
        .panel_height(230.0)
        .captioned(format!(
            "Figure {number}. At {f} Hz: (a) the last period as a loop, (b) the last two periods over time; \
             below, measured minus model."
        ));
    figure.panels = panels.into();
    figure
}

fn errors_figure(found: &Reproduction) -> Figure {
    let frequencies: Vec<f64> = printed::TABLE_3.iter().map(|r| r.frequency_hz).collect();
    let models: Vec<(String, Vec<f64>)> = found
        .models
        .models
        .iter()
        .filter(|m| {
            m.kind.is_the_articles() || m.kind == ModelKind::Default || m.kind == ModelKind::ImprovedStatic
        })
        .map(|m| (m.kind.name().to_owned(), m.scores.iter().map(|s| s.rmse_um).collect()))
        .collect();
    errors_by_frequency(
        "Figure 12. RMSE of the models by frequency",
        &frequencies,
        Axis::log("RMSE", "µm"),
        &models,
    )
    .subtitled(SIMULATED)
    .captioned("Figure 12 (not in the article). RMSE on the validation sines, which no fit has seen.")
}

fn all_models(found: &Reproduction) -> Table {
    let mut columns = vec![Column::text("model")];
    for row in &printed::TABLE_3 {
        columns.push(Column::number("RMSE", "µm"));
        columns.push(Column::number("own offset", "µm"));
        debug_assert!(row.frequency_hz > 0.0);
    }
    columns.push(Column::number("evaluations", ""));
    let mut table = Table::new(columns).captioned("All models, those of the article first.").group("", 1);
    for row in &printed::TABLE_3 {
        table = table.group(format!("{} Hz", row.frequency_hz), 2);
    }
    table = table.group("", 1);
    for fit in &found.models.models {
        let mut cells = vec![fit.kind.name().to_owned()];
        for s in &fit.scores {
            cells.extend([significant(s.rmse_um, 3), significant(s.rmse_own_offset_um, 3)]);
        }
        cells.push(fit.evaluations.to_string());
        table = if fit.kind == ModelKind::Default { table.highlighted_row(cells) } else { table.row(cells) };
    }
    table.note(
        "Own offset: RMSE with the mean error removed, as if each record's sensor zero were unknown; the \
         bench creeps, and a fast record lies lower than a slow one. Evaluations: of all searches of the \
         model; the static block of the quadratic models is searched once and counted in each.",
    )
}
