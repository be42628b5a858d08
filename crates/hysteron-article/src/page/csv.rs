//! Every table of the page as comma-separated values, at full precision.

use crate::{Reproduction, printed, quantile};

/// A table to be written as a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CsvTable {
    /// Name of the file, without folder.
    pub name: &'static str,
    /// Its content: a header line and the rows.
    pub text: String,
}

struct Builder {
    text: String,
}

impl Builder {
    fn new(header: &[&str]) -> Self {
        Self { text: header.join(",") + "\n" }
    }

    fn row(&mut self, cells: &[String]) {
        let quoted = |cell: &String| {
            if cell.contains([',', '"', '\n']) {
                format!("\"{}\"", cell.replace('"', "\"\""))
            } else {
                cell.clone()
            }
        };
        self.text += &cells.iter().map(quoted).collect::<Vec<_>>().join(",");
        self.text.push('\n');
    }

    fn done(self, name: &'static str) -> CsvTable {
        CsvTable { name, text: self.text }
    }
}

/// A number at full precision; empty if not finite.
fn number(value: f64) -> String {
    if value.is_finite() { format!("{value}") } else { String::new() }
}

fn optional(value: Option<f64>) -> String {
    value.map_or_else(String::new, number)
}

/// Every table, units in the headers; empty cells are numbers that do not exist.
pub fn tables(found: &Reproduction) -> Vec<CsvTable> {
    vec![
        claims(found),
        figure_1(found),
        table_1(found),
        figure_6(found),
        table_2(found),
        equation_13(found),
        table_3(found),
        contradictions(found),
        recovery(found),
    ]
}

fn claims(found: &Reproduction) -> CsvTable {
    let mut csv = Builder::new(&["claim", "place", "printed", "here", "verdict"]);
    for c in &found.claims {
        csv.row(&[
            c.claim.clone(),
            c.place.clone(),
            c.printed.clone(),
            c.here.clone(),
            c.verdict.word().into(),
        ]);
    }
    csv.done("claims.csv")
}

fn figure_1(found: &Reproduction) -> CsvTable {
    let mut csv = Builder::new(&[
        "frequency_Hz",
        "stroke_um",
        "opening_percent",
        "largest_distance_from_1_Hz_percent",
        "rms_distance_from_1_Hz_percent",
    ]);
    for l in &found.loops.loops {
        let values = [
            l.frequency_hz,
            l.stroke_um,
            l.opening_percent,
            l.largest_distance_percent,
            l.rms_distance_percent,
        ];
        csv.row(&values.map(number));
    }
    csv.done("figure_1_loops.csv")
}

fn table_1(found: &Reproduction) -> CsvTable {
    let mut csv = Builder::new(&[
        "algorithm",
        "variant",
        "printed_best_fitness",
        "median_rmse_um",
        "lower_quartile_um",
        "upper_quartile_um",
        "within_1_percent_of_runs",
        "median_evaluations_to_1_percent",
        "median_evaluations",
        "scouts",
    ]);
    for c in &found.optimizers.contenders {
        csv.row(&[
            c.name.clone(),
            c.variant.clone(),
            optional(c.printed),
            number(c.median_um),
            number(c.quartiles_um.0),
            number(c.quartiles_um.1),
            number(c.success_percent),
            optional(c.evaluations_to_1_percent),
            number(c.evaluations),
            c.scouts.to_string(),
        ]);
    }
    csv.done("table_1_optimisers.csv")
}

fn figure_6(found: &Reproduction) -> CsvTable {
    let mut csv =
        Builder::new(&["algorithm", "generation", "lower_quartile_um", "median_um", "upper_quartile_um"]);
    for c in &found.optimizers.contenders {
        for generation in 0..c.histories_um.iter().map(Vec::len).min().unwrap_or(0) {
            let best: Vec<f64> = c.histories_um.iter().map(|history| history[generation]).collect();
            let mut row = vec![c.name.clone(), generation.to_string()];
            row.extend([0.25, 0.5, 0.75].map(|p| number(quantile(&best, p))));
            csv.row(&row);
        }
    }
    csv.done("figure_6_convergence.csv")
}

fn table_2(found: &Reproduction) -> CsvTable {
    let (t, s) = (&printed::TABLE_2, &found.static_block);
    let p = &s.parameters;
    let mut csv = Builder::new(&["quantity", "unit", "printed", "here"]);
    for (name, unit, printed, here) in [
        ("x", "um/V^2", t.x, p.x),
        ("y", "um/V", t.y, p.y),
        ("alpha", "um/V", t.alpha, p.alpha),
        ("beta", "1/V", t.beta, p.beta),
        ("gamma", "1/V", t.gamma, p.gamma),
        ("RE", "1", t.re, s.re),
        ("RMSE", "um", t.rmse, s.rmse_um),
    ] {
        csv.row(&[name.into(), unit.into(), number(printed), number(here)]);
    }
    csv.done("table_2_static_block.csv")
}

fn equation_13(found: &Reproduction) -> CsvTable {
    let mut csv = Builder::new(&[
        "model",
        "b",
        "alpha2",
        "c1",
        "alpha1",
        "c0",
        "delay_s",
        "sweep_rmse_um",
        "at_end_of_range",
    ]);
    let g = &printed::EQ_13;
    let mut row = vec!["article (printed)".to_owned()];
    row.extend([g.b, g.alpha2, g.c1, g.alpha1, g.c0].map(number));
    row.extend([String::new(), String::new(), String::new()]);
    csv.row(&row);
    for m in &found.models.models {
        let Some(g) = &m.eq13 else { continue };
        let mut row = vec![m.kind.name().to_owned()];
        row.extend([g.b, g.alpha2, g.c1, g.alpha1, g.c0, m.delay_s].map(number));
        row.push(optional(m.fitted_rmse_um.last().map(|(_, rmse)| *rmse)));
        row.push(m.at_bounds.join(" "));
        csv.row(&row);
    }
    csv.done("equation_13.csv")
}

fn table_3(found: &Reproduction) -> CsvTable {
    use crate::ModelKind;
    let mut csv = Builder::new(&[
        "frequency_Hz",
        "model",
        "printed_max_um",
        "printed_rmse_um",
        "max_um",
        "rmse_um",
        "rmse_percent_of_stroke",
        "rmse_own_offset_um",
    ]);
    for row in &printed::TABLE_3 {
        for m in &found.models.models {
            let printed = match m.kind {
                ModelKind::Classic => Some(row.classic),
                ModelKind::Integer => Some(row.integer),
                ModelKind::Fractional => Some(row.fractional),
                _ => None,
            };
            let Some(s) = m.scores.iter().find(|s| s.frequency_hz == row.frequency_hz) else { continue };
            csv.row(&[
                number(row.frequency_hz),
                m.kind.name().into(),
                optional(printed.map(|p| p.max_um)),
                optional(printed.map(|p| p.rmse_um)),
                number(s.max_um),
                number(s.rmse_um),
                number(s.rmse_percent),
                number(s.rmse_own_offset_um),
            ]);
        }
    }
    csv.done("table_3_models.csv")
}

fn contradictions(found: &Reproduction) -> CsvTable {
    let mut csv =
        Builder::new(&["frequency_Hz", "printed_static_rmse_um", "implied_rmse_um", "implied_best_gain_um"]);
    for r in &found.contradictions.behind_the_loop {
        csv.row(&[r.frequency_hz, r.printed_um, r.rmse_um, r.rmse_best_gain_um].map(number));
    }
    csv.done("printed_numbers_contradict.csv")
}

fn recovery(found: &Reproduction) -> CsvTable {
    let mut csv = Builder::new(&[
        "blocks",
        "offset",
        "loop_periods",
        "sweep",
        "scheme",
        "x",
        "y",
        "alpha",
        "beta",
        "gamma",
        "b",
        "alpha2",
        "c1",
        "alpha1",
        "c0",
        "loop_rmse_um",
        "sweep_rmse_um",
    ]);
    let truth = (&found.recovery.static_truth, &found.recovery.dynamic_truth);
    let mut add = |words: [String; 5], s: &crate::StaticParameters, g: &crate::Eq13, rmse: [f64; 2]| {
        let mut row = words.to_vec();
        row.extend([s.x, s.y, s.alpha, s.beta, s.gamma, g.b, g.alpha2, g.c1, g.alpha1, g.c0].map(number));
        row.extend(rmse.map(number));
        csv.row(&row);
    };
    let blank = String::new;
    add(["truth".into(), blank(), blank(), blank(), blank()], truth.0, truth.1, [f64::NAN; 2]);
    for c in &found.recovery.cases {
        let words = [
            if c.case.blocks_apart { "apart" } else { "together" }.to_owned(),
            if c.case.offset_estimated { "estimated" } else { "zero" }.to_owned(),
            c.case.loop_periods.to_string(),
            if c.case.linear_sweep { "linear" } else { "logarithmic" }.to_owned(),
            c.case.scheme.name().to_owned(),
        ];
        add(words, &c.static_block, &c.dynamic_block, [c.loop_rmse_um, c.sweep_rmse_um]);
    }
    csv.done("recovery.csv")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_with_commas_and_quotes_are_quoted() {
        let mut csv = Builder::new(&["a", "b"]);
        csv.row(&["1, \"two\"".into(), "3".into()]);
        assert_eq!(csv.done("t.csv").text, "a,b\n\"1, \"\"two\"\"\",3\n");
    }
}
