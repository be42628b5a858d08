//! Overview at the top of the page: that the bench is simulated, the verdicts on the claims, the reading of
//! the text.

use crate::{Claim, ModelKind, Reproduction, Verdict};

use hysteron_report::number::significant;
use hysteron_report::page::{Block, Cell, Column, Highlight, Row, Section, Table};

pub(super) fn summary(found: &Reproduction) -> Section {
    let mut section = Section::new("");
    if found.plan.quick {
        section = section.block(Block::warning(format!(
            "A rehearsal (--quick): {} runs, {} generations, a sweep of {} s. Its numbers are provisional.",
            found.plan.runs, found.plan.generations, found.plan.sweep_s
        )));
    }
    let median = |name: &str| {
        found.optimizers.contender(name).map_or_else(|| "—".to_owned(), |c| significant(c.median_um, 4))
    };
    let worst = |kind: ModelKind| {
        let scores = found.models.model(kind).map(|m| m.scores.as_slice()).unwrap_or_default();
        significant(scores.iter().map(|s| s.rmse_um).fold(f64::NAN, f64::max), 3)
    };
    section
        .block(Block::Highlights(vec![
            Highlight::new("static fit, DE-ABC", median("DE-ABC"), "µm (median RMSE)"),
            Highlight::new("fractional, 10–100 Hz", worst(ModelKind::Fractional), "µm (largest RMSE)"),
            Highlight::new("integer order", worst(ModelKind::Integer), "µm (largest RMSE)"),
            Highlight::new("ARX", worst(ModelKind::Arx), "µm (largest RMSE)"),
            Highlight::new("classic Bouc–Wen", worst(ModelKind::Classic), "µm (largest RMSE)"),
        ]))
        .block(Block::warning(format!(
            "The article's data are not public. Everything under “here” was computed on a simulated bench \
             ({}), which lies outside every model class compared. Compare order and ratios with the printed \
             numbers, not absolute values.",
            found.bench
        )))
}

/// What the article claims, and whether it holds here.
pub(super) fn claims(found: &Reproduction) -> Section {
    Section::new("The article's claims").block(claims_table(&found.claims))
}

fn claims_table(claims: &[Claim]) -> Table {
    let mut table = Table::new([
        Column::text("claim"),
        Column::text("where"),
        Column::text("printed"),
        Column::text("here (simulated bench)"),
        Column::text("verdict"),
    ])
    .captioned("The article's claims, judged by the numbers of this page.");
    for c in claims {
        let word = c.verdict.word();
        table.rows.push(Row {
            cells: vec![
                Cell::new(&c.claim),
                Cell::quiet(&c.place),
                Cell::quiet(&c.printed),
                Cell::new(&c.here),
                Cell::strong(word),
            ],
            highlight: c.verdict != Verdict::Holds,
        });
    }
    table.note("Shaded: our result disagrees with the claim, wholly or in part.")
}

pub(super) fn readings(found: &Reproduction) -> Section {
    let plan = &found.plan;
    let search_box: Vec<String> = found
        .optimizers
        .search_box
        .iter()
        .map(|(name, low, high)| format!("{name} {} … {}", significant(*low, 3), significant(*high, 3)))
        .collect();
    Section::new("How the article was read").block(Block::paragraph(
        "The text leaves much open. These readings were chosen; where one departs from the words, it says \
         why.",
    )).block(Block::list([
        format!(
            "Drive: 0–10 V, cosine from rest at 0 V; sample rate {} Hz. Neither the voltage span nor the \
             rate is printed.",
            plan.sample_rate_hz
        ),
        format!(
            "Sweep 1–100 Hz, linear in time (the default law of MATLAB's chirp), {} s. Validation sines of \
             {} s that no fit has seen.",
            plan.sweep_s, plan.sine_s
        ),
        format!(
            "The 1 Hz loop (three periods) is used at every {}th sample, {} samples: a rate-independent \
             block loses nothing by it.",
            plan.loop_decimation, found.optimizers.samples
        ),
        "Eq. 1 with n = 1 (n is not printed) and z = 0 at rest; no sensor offset and no delay, since the \
         article has neither. Fitness is Eq. 7, the RMSE."
            .into(),
        format!(
            "The search box is ours, made from the record's slope and range: {}. The printed one is garbled \
             (below). Eq. 13 is searched as gain, natural frequency, damping and the two orders.",
            search_box.join(", ")
        ),
        format!(
            "SN = 25 food sources, so 50 evaluations a generation, {} generations; DE with a population of \
             50 spends the same.",
            plan.generations
        ),
        "Eq. 8 moves all components. The text says that one random component moves; that fails (Table 1, \
         last row), so we depart from it. Phases propose a generation, evaluate it, then accept."
            .into(),
        "Eq. 12 as printed can only move up and leaves the box: a coordinate above the box is wrapped back. \
         The scout is sent after SN·D failures of a source; the article prints no L."
            .into(),
        "“Classic” Bouc–Wen is Eq. 1 without the quadratic term; the article calls it symmetrical.".into(),
        "The dynamic block is simulated by convolution quadrature with Tustin's rule. The article's \
         Grünwald–Letnikov sums would bias the parameters by the sample rate (last section)."
            .into(),
    ]))
}

pub(super) fn repeat(found: &Reproduction) -> Section {
    let quick = if found.plan.quick { " --quick" } else { "" };
    Section::new("Reproduction")
        .block(Block::code(format!("hysteron article --out-dir DIR --seed {}{quick}", found.plan.seed)))
        .block(Block::paragraph(
            "The same seed gives the same bytes, whatever the number of threads. Beside this page: figures/ \
             (SVG), tables/ (CSV, every number in full), article.json (everything, curves too).",
        ))
}
