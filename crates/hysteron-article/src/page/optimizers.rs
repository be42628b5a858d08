//! Table 1 and Figure 6.

use crate::{Contender, OptimizerStudy, Reproduction, printed};

use super::SIMULATED;
use hysteron_report::figure::{Axis, ConvergenceCurve, Figure, convergence};
use hysteron_report::number::significant;
use hysteron_report::page::{Block, Cell, Column, Row, Section, Table};

/// Contenders that Table 1 has.
const IN_TABLE_1: usize = printed::TABLE_1.len();

pub(super) fn section(found: &Reproduction) -> Section {
    let study = &found.optimizers;
    let split = IN_TABLE_1.min(study.contenders.len());
    let de_abc = study.contenders.get(split.saturating_sub(1)).into_iter();
    let variants: Vec<&Contender> = de_abc.chain(&study.contenders[split..]).collect();
    Section::new("Table 1 and Figure 6: the optimisers")
        .block(Block::paragraph(format!(
            "Static fit of the 1 Hz loop, five parameters, {} seeds each, {} generations. The article shows \
             one run of each algorithm and no spread. Best RMSE within reach of the model: {} µm (least \
             squares from many starts, {} evaluations in all).",
            found.plan.runs,
            found.plan.generations,
            significant(study.reachable_um, 5),
            study.reachable_evaluations
        )))
        .block(table(found))
        .block(
            figure("Figure 6. Convergence of DE, ABC and DE-ABC", study.contenders[..split].iter())
                .captioned(format!(
                    "Figure 6. Best RMSE so far by generation: median of {} runs, quartiles shaded.",
                    found.plan.runs
                )),
        )
        .block(figure("Figure 6b. Variants of DE-ABC", variants.into_iter()).captioned(
            "Figure 6b (not in the article). DE-ABC with and without its chaotic scout, with the scout sent \
             after 10 failures instead of SN·D, and in the literal reading in which one random component \
             moves.",
        ))
        .block(Block::paragraph(scout(study)))
}

fn table(found: &Reproduction) -> Table {
    let study = &found.optimizers;
    let of = |name: &str| study.contender(name).map_or(f64::NAN, |c| c.median_um);
    let (printed_best, best) =
        (printed::TABLE_1.iter().map(|t| t.1).fold(f64::INFINITY, f64::min), of("DE-ABC"));
    let mut table = Table::new([
        Column::text("algorithm"),
        Column::number("best fitness", ""),
        Column::number("ratio to DE-ABC", ""),
        Column::number("median RMSE", "µm"),
        Column::number("quartiles", "µm"),
        Column::number("ratio to DE-ABC", ""),
        Column::number("within 1 %", "% of runs"),
        Column::number("evaluations to 1 %", "median"),
        Column::number("scouts", "all runs"),
    ])
    .captioned("Table 1. Best fitness of each algorithm after the last generation.")
    .group("", 1)
    .group("article (printed)", 2)
    .group("here (simulated bench)", 6);
    for c in &study.contenders {
        let printed = |value: Option<f64>, digits: usize| {
            Cell::quiet(value.map_or_else(|| "—".to_owned(), |v| significant(v, digits)))
        };
        table.rows.push(Row {
            cells: vec![
                Cell::new(&c.name),
                printed(c.printed, 3),
                printed(c.printed.map(|p| p / printed_best), 3),
                Cell::new(significant(c.median_um, 5)),
                Cell::new(format!(
                    "{} … {}",
                    significant(c.quartiles_um.0, 5),
                    significant(c.quartiles_um.1, 5)
                )),
                Cell::new(significant(c.median_um / best, 3)),
                Cell::new(significant(c.success_percent, 3)),
                Cell::new(c.evaluations_to_1_percent.map_or_else(|| "—".to_owned(), |n| significant(n, 4))),
                Cell::new(c.scouts.to_string()),
            ],
            highlight: c.printed.is_some(),
        });
    }
    for c in &study.contenders {
        table.notes.push(format!("{}: {}.", c.name, c.variant));
    }
    table.notes.push(
        "Within 1 %: runs that end within 1 % of the best RMSE in reach. Evaluations to 1 %: median over all \
         runs, a run that never comes there counted as infinite. The printed fitness has no unit and a \
         residual of its own; only its ratios can be compared."
            .into(),
    );
    table
}

fn figure<'a>(title: &str, contenders: impl Iterator<Item = &'a Contender>) -> Figure {
    let curves: Vec<ConvergenceCurve> = contenders
        .map(|c| ConvergenceCurve {
            label: c.name.clone(),
            x: (0..c.histories_um.iter().map(Vec::len).max().unwrap_or(0)).map(|g| g as f64).collect(),
            runs: c.histories_um.clone(),
        })
        .collect();
    convergence(title, "generation", Axis::log("best RMSE so far", "µm"), &curves).subtitled(SIMULATED)
}

fn scout(study: &OptimizerStudy) -> String {
    let words = |name: &str| {
        study.contender(name).map_or_else(String::new, |c| {
            format!("{} scouts and a median of {} µm", c.scouts, significant(c.median_um, 5))
        })
    };
    let missed = |name: &str| {
        study.contender(name).map_or_else(String::new, |c| significant(100.0 - c.success_percent, 2))
    };
    format!(
        "DE-ABC ends more than 1 % above the best fit in {} % of its runs, DE in {} %. The chaotic scout: \
         with the default limit of SN·D failures, {} over all runs; switched off, {}; after 10 failures \
         already, {}.",
        missed("DE-ABC"),
        missed("DE"),
        words("DE-ABC"),
        words("DE-ABC, no scout"),
        words("DE-ABC, early scout")
    )
}
