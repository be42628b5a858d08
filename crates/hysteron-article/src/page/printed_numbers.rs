//! Where the article's printed numbers contradict each other.

use crate::{Reproduction, printed};

use hysteron_report::number::significant;
use hysteron_report::page::{Block, Cell, Column, Row, Section, Table};

pub(super) fn section(found: &Reproduction) -> Section {
    let c = &found.contradictions;
    let mut table = Table::new([
        Column::number("frequency", "Hz"),
        Column::number("RMSE printed", "µm"),
        Column::number("RMSE implied", "µm"),
        Column::number("implied, best gain", "µm"),
        Column::number("implied / printed", ""),
    ])
    .captioned(
        "Eq. 13 behind the loop of Table 2: the error that a static model must have, and the one printed in \
        Table 3.",
    );
    for row in &c.behind_the_loop {
        table.rows.push(Row {
            cells: vec![
                Cell::new(row.frequency_hz.to_string()),
                Cell::quiet(format!("{:.4}", row.printed_um)),
                Cell::new(significant(row.rmse_um, 3)),
                Cell::new(significant(row.rmse_best_gain_um, 3)),
                Cell::strong(significant(row.rmse_um / row.printed_um, 2)),
            ],
            highlight: false,
        });
    }
    table = table.note(format!(
        "Drive 0–10 V, loop of {} µm, steady state, each signal about its own mean. Computed from printed \
         numbers alone: no bench, no fit. Printed: classic Bouc–Wen, Table 3. Implied: block of Table 2 \
         against that block followed by Eq. 13. Best gain: the same with the static model scaled to each \
         frequency.",
        significant(c.stroke_um, 3)
    ));
    let t = &printed::TABLE_2;
    let (largest, at) = c.largest_fractional_rmse;
    let classic: Vec<f64> = printed::TABLE_3.iter().map(|r| r.classic.rmse_um).collect();
    Section::new("Where the printed numbers contradict each other").block(table).block(Block::list([
        format!(
            "RE {} with RMSE {} implies a mean displacement of {} to {} µm (Gaussian or sinusoidal residual; \
             at most {} µm), while the loop of Table 2 has a mean of {} µm: the unit or the stroke is not \
             what one would think.",
            t.re,
            significant(t.rmse, 3),
            significant(c.mean_y_gaussian_um, 2),
            significant(c.mean_y_sinusoidal_um, 2),
            significant(c.mean_y_at_most_um, 2),
            significant(c.mean_um, 3)
        ),
        format!(
            "The abstract calls {} the maximum RMSE of the model; Table 3 has {} at {at} Hz. It is one row \
             of four.",
            printed::ABSTRACT.rmse_um, largest
        ),
        format!(
            "§4.4 says that the error of the classic model begins to increase with frequency; its printed \
             RMSE falls from {} at 10 Hz to {} at 20 Hz.",
            classic[0], classic[1]
        ),
        format!(
            "At 100 Hz the running text has a max error of {} µm, the table {}.",
            printed::TEXT_MAX_100HZ_UM,
            printed::TABLE_3[3].fractional.max_um
        ),
        format!(
            "Put into Eq. 1 as printed, Table 2 gives a clockwise loop ({} µm going up through 5 V, {} µm \
             coming down), the opposite sense of a real stack.",
            significant(c.at_5_v_um.0, 4),
            significant(c.at_5_v_um.1, 4)
        ),
        format!(
            "The search box is garbled: MinX = {:?}, MaxX = {:?}; for {} of 5 parameters the lower bound \
             lies above the upper one, and the order of the parameters is not said.",
            printed::SEARCH_BOX.0, printed::SEARCH_BOX.1, c.inverted_bounds
        ),
        "ARX is called far inferior, without a number.".into(),
        "The symbol x is both the output and a coefficient in Eq. 1; n, the sample rate, the voltage span, L \
         and the number of chaotic iterates are not printed."
            .into(),
    ]))
}
