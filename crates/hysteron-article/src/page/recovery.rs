//! Table 2 and Eq. 13 as the truth.

use crate::{RecoveredBlocks, RecoveryCase, Reproduction, printed};

use hysteron_report::number::significant;
use hysteron_report::page::{Block, Cell, Column, Row, Section, Table};

pub(super) fn section(found: &Reproduction) -> Section {
    let prototype = found.recovery.cases.iter().find(|c| c.case.prototype);
    Section::new("The article's own plant as the truth")
        .block(Block::paragraph(
            "Table 2 followed by Eq. 13, noise-free, measured on the bench with an ideal sensor. First each \
             block from its own data: the static block from a loop without dynamics, the dynamic block from \
             the exact hysteresis output. Then both together the two-step way, where the 1 Hz loop has \
             already passed through the dynamics and step 1 takes it for static. Fits by least squares, so \
             that what is shown is the minimum of the criterion and not the luck of a search.",
        ))
        .block(readings(&found.recovery.cases))
        .block(table(&found.recovery.cases))
        .blocks(prototype.map(beside_the_prototype))
        .block(Block::paragraph(
            "The size of the bias, and even its sign, depends on readings that the article does not print: \
             whether a sensor offset is estimated, the law of the sweep, how many periods the loop has, the \
             simulation scheme. The fit itself looks good in every case. So the coefficients of Eq. 13 \
             belong to the procedure as much as to the stage.",
        ))
}

/// Letter that denotes a case.
fn letter(index: usize) -> String {
    char::from_u32('A' as u32 + index as u32).map(String::from).unwrap_or_default()
}

fn readings(cases: &[RecoveredBlocks]) -> Table {
    let mut table = Table::new([
        Column::text("case"),
        Column::text("data of the two blocks"),
        Column::text("sensor offset"),
        Column::number("loop", "periods"),
        Column::text("sweep"),
        Column::text("scheme"),
        Column::number("RMSE", "µm on the loop"),
        Column::number("RMSE", "µm on the sweep"),
    ])
    .captioned("The readings under which Table 2 and Eq. 13 are recovered, and how well each fits.");
    for (i, found) in cases.iter().enumerate() {
        let RecoveryCase { blocks_apart, offset_estimated, loop_periods, linear_sweep, scheme, prototype } =
            found.case;
        let cells = [
            letter(i),
            if blocks_apart { "each its own" } else { "both together" }.to_owned(),
            if offset_estimated { "estimated" } else { "zero" }.to_owned(),
            loop_periods.to_string(),
            if linear_sweep { "linear" } else { "logarithmic" }.to_owned(),
            scheme.name().to_owned(),
            rmse(found.loop_rmse_um),
            rmse(found.sweep_rmse_um),
        ];
        table = if prototype { table.highlighted_row(cells) } else { table.row(cells) };
    }
    table
}

/// A fit to rounding errors is shown as exact.
fn rmse(value_um: f64) -> String {
    if value_um < 1e-9 { "exact".to_owned() } else { significant(value_um, 2) }
}

fn signed(value: f64, digits: usize) -> String {
    // A bias below the last digit shown is printed without sign.
    let text = format!("{:.digits$}", value.abs());
    if text.chars().all(|c| c == '0' || c == '.') {
        text
    } else {
        format!("{}{text}", if value < 0.0 { "−" } else { "+" })
    }
}

fn table(cases: &[RecoveredBlocks]) -> Table {
    let mut columns = vec![Column::text("case")];
    columns.extend(["x", "y", "α", "β"].map(|n| Column::number(n, "%")));
    columns.push(Column::number("γ", "1/V"));
    columns.extend(["b", "c₁", "c₀"].map(|n| Column::number(n, "%")));
    columns.extend(["α₂", "α₁"].map(|n| Column::number(n, "")));
    let mut table = Table::new(columns)
        .captioned("Recovery: bias of every parameter.")
        .group("", 1)
        .group("static block", 5)
        .group("dynamic block", 5);
    for (i, found) in cases.iter().enumerate() {
        let s = found.static_bias_percent();
        let mut texts: Vec<String> = s[..4].iter().map(|v| signed(*v, 1)).collect();
        texts.push(signed(found.static_block.gamma - printed::TABLE_2.gamma, 4));
        texts.extend(found.coefficient_bias_percent().map(|v| signed(v, 1)));
        texts.extend(found.order_bias().map(|v| signed(v, 3)));
        let mut cells = vec![Cell::new(letter(i))];
        cells.extend(texts.into_iter().map(Cell::new));
        table.rows.push(Row { cells, highlight: found.case.prototype });
    }
    table
        .note(format!(
            "Bias in % of the truth; that of γ and of the orders absolute, since γ = {} is close to zero.",
            printed::TABLE_2.gamma
        ))
        .note(
            "Grünwald–Letnikov fits to less than the noise of a real sensor and returns other coefficients \
             all the same: they belong to that scheme and that sample rate.",
        )
}

fn beside_the_prototype(found: &RecoveredBlocks) -> Table {
    let p = &printed::PROTOTYPE_BIAS;
    let (x, b, order) =
        (found.static_bias_percent()[0], found.coefficient_bias_percent()[0], found.order_bias()[0]);
    Table::new([
        Column::text("bias of the two-step way"),
        Column::number("earlier prototype", ""),
        Column::number("here", ""),
    ])
    .captioned("The bias beside that of an earlier, independent prototype (shaded reading above).")
    .row(["x [%]".to_owned(), signed(p.x_percent, 0), signed(x, 1)])
    .row(["b [%]".to_owned(), signed(p.b_percent, 0), signed(b, 1)])
    .row(["α₂".to_owned(), signed(p.alpha2, 2), signed(order, 3)])
    .note(
        "The prototype's figures come out when no offset is estimated, the 1 Hz loop has three periods from \
         rest, the sweep is linear and lasts 10 s, and the scheme is Tustin's.",
    )
}
