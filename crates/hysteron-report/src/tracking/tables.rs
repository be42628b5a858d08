//! Tables of the result, for any front end.

use hysteron_model::control::Edge;
use hysteron_model::record::range_of;
use hysteron_model::tracking::{ControllerRun, Tracking, differ, law};

use crate::number::significant;
use crate::page::{Column, Table};

/// A table as text, with the unit of each column.
#[derive(Clone, Debug)]
pub struct TextTable {
    /// Headings with their units.
    pub columns: Vec<(&'static str, String)>,
    /// Number of columns, the first ones, that hold words.
    pub words: usize,
    /// Cells.
    pub rows: Vec<Vec<String>>,
}

impl TextTable {
    fn new(words: usize, columns: impl IntoIterator<Item = (&'static str, String)>) -> Self {
        Self { columns: columns.into_iter().collect(), words, rows: Vec::new() }
    }

    fn filled(self, rows: impl IntoIterator<Item = Vec<String>>) -> Option<Self> {
        let rows: Vec<_> = rows.into_iter().collect();
        (!rows.is_empty()).then_some(Self { rows, ..self })
    }

    /// Table of a page.
    pub fn for_page(self) -> Table {
        let words = self.words;
        let columns =
            self.columns.into_iter().enumerate().map(|(i, (name, unit))| {
                if i < words { Column::text(name) } else { Column::number(name, unit) }
            });
        self.rows.into_iter().fold(Table::new(columns), Table::row)
    }
}

fn number(x: f64, digits: usize) -> String {
    if x.is_finite() { significant(x, digits) } else { "∞".to_owned() }
}

/// Tracking error and drive range of each controller.
pub fn errors(found: &Tracking) -> Option<TextTable> {
    let (input, output) = (found.input.to_string(), found.output.to_string());
    let columns = [
        ("controller", String::new()),
        ("rms", output.clone()),
        ("largest", output),
        ("rms", "% of stroke".to_owned()),
        ("largest", "% of stroke".to_owned()),
        ("lowest drive", input.clone()),
        ("highest drive", input),
        ("at a limit", "samples".to_owned()),
    ];
    let row = |run: &ControllerRun| {
        let (low, high) = range_of(&run.played.drive);
        let score = &run.score;
        vec![
            run.controller.words().to_owned(),
            significant(score.rms, 3),
            significant(score.max, 3),
            significant(score.rms_percent, 3),
            significant(score.max_percent, 3),
            significant(low, 4),
            significant(high, 4),
            (run.played.at_range + run.played.at_slew).to_string(),
        ]
    };
    TextTable::new(1, columns).filled(found.runs.iter().map(row))
}

/// Bandwidths of each controller, by formula and by simulated sines.
pub fn bandwidths(found: &Tracking) -> Option<TextTable> {
    let hz = || "Hz".to_owned();
    let columns = [
        ("controller", String::new()),
        ("−3 dB, formula", hz()),
        ("−3 dB, simulated", hz()),
        ("1 % error, formula", hz()),
        ("1 % error, simulated", hz()),
        ("more than 10 % apart", String::new()),
    ];
    let edge = |edge: Edge| match edge {
        Edge::Below(f) => format!("< {}", significant(f, 3)),
        Edge::At(f) => significant(f, 3),
        Edge::Above(f) => format!("> {}", significant(f, 3)),
    };
    let row = |run: &ControllerRun| {
        let both = run.bandwidths()?;
        let apart =
            ["−3 dB", "1 %"].into_iter().zip(both).filter(|(_, (formula, played))| differ(*formula, *played));
        let apart: Vec<&str> = apart.map(|(name, _)| name).collect();
        let mut cells = vec![run.controller.words().to_owned()];
        for (formula, played) in both {
            cells.extend([significant(formula, 3), edge(played)]);
        }
        cells.push(if apart.is_empty() { "–".to_owned() } else { apart.join(", ") });
        Some(cells)
    };
    TextTable::new(1, columns).filled(found.runs.iter().filter_map(row))
}

/// Margins of the controllers that have feedback.
pub fn margins(found: &Tracking) -> Option<TextTable> {
    let columns = [
        ("feedback", String::new()),
        ("law", String::new()),
        ("gain margin", String::new()),
        ("phase margin", "°".to_owned()),
        ("least |1 + L|", String::new()),
        ("crossover", "Hz".to_owned()),
    ];
    let row = |run: &ControllerRun| {
        let m = run.made.margins()?;
        Some(vec![
            run.controller.words().to_owned(),
            law(&run.made),
            number(m.gain, 3),
            number(m.phase_deg, 3),
            number(m.modulus, 3),
            significant(m.crossover_hz, 3),
        ])
    };
    TextTable::new(2, columns).filled(found.runs.iter().filter_map(row))
}

/// Weight adaptation of the controllers that have it: step size, stability limit, phase margin.
pub fn adaptations(found: &Tracking) -> Option<TextTable> {
    let columns = [
        ("adaptation", String::new()),
        ("step", String::new()),
        ("largest stable", String::new()),
        ("there, at", "Hz".to_owned()),
        ("margin", String::new()),
        ("phase, stage to model", "°".to_owned()),
        ("there, at", "Hz".to_owned()),
        ("margin to 90°", "°".to_owned()),
        ("error, rms", "% of stroke".to_owned()),
        ("best weights", "% of stroke".to_owned()),
    ];
    let row = |run: &ControllerRun| {
        let own = run.adaptation.as_ref()?;
        let filter = &own.filter;
        let phase = own.phase_error.map_or([const { String::new() }; 3], |(degrees, at_hz)| {
            [significant(degrees, 3), significant(at_hz, 3), significant(90.0 - degrees, 3)]
        });
        let step = [filter.rate, filter.limit].map(|x| significant(x, 3));
        let mut cells = vec![run.controller.words().to_owned()];
        cells.extend(step);
        cells.extend([significant(filter.limit_at_hz, 3), significant(filter.limit / filter.rate, 3)]);
        cells.extend(phase);
        cells.extend([run.score.rms_percent, own.best_percent].map(|x| significant(x, 3)));
        Some(cells)
    };
    TextTable::new(1, columns).filled(found.runs.iter().filter_map(row))
}

/// Highest frequency of a sine within the slew limit of the drive, by amplitude.
pub fn reaches(found: &Tracking) -> Option<TextTable> {
    let columns = [
        ("amplitude of a sine", found.output.to_string()),
        ("of its drive", found.input.to_string()),
        ("up to", "Hz".to_owned()),
    ];
    let rows = found
        .reach
        .iter()
        .map(|r| [r.amplitude, r.amplitude_v, r.highest_hz].map(|x| significant(x, 3)).to_vec());
    TextTable::new(0, columns).filled(rows)
}
