//! The result in words and as an object.

use hysteron::control::{FeedbackKind, Loop};
use hysteron::display::short;
use hysteron_report::number::significant;
use serde::Serialize;

use super::{Found, PlantArg, Run};
use crate::console;

pub const HEADER: [&str; 10] = [
    "controller",
    "rms",
    "largest",
    "rms, % of stroke",
    "largest, %",
    "−3 dB, Hz",
    "1 % error, Hz",
    "lowest drive",
    "highest drive",
    "held back, samples",
];

pub fn cells(run: &Run) -> Vec<String> {
    let (low, high) = ends(&run.played.drive);
    let (score, bandwidth) = (&run.score, &run.made.bandwidth);
    vec![
        run.controller.words().to_owned(),
        significant(score.rms, 3),
        significant(score.max, 3),
        significant(score.rms_percent, 3),
        significant(score.max_percent, 3),
        significant(bandwidth.minus_3_db_hz, 3),
        significant(bandwidth.one_percent_hz, 3),
        significant(low, 4),
        significant(high, 4),
        (run.played.at_range + run.played.at_slew).to_string(),
    ]
}

pub const MARGINS: [&str; 6] =
    ["feedback", "law", "gain margin", "phase margin, °", "least |1 + L|", "crossover, Hz"];

/// Margins of a controller that has feedback.
pub fn margins(run: &Run) -> Option<Vec<String>> {
    let m = run.made.margins()?;
    Some(vec![
        run.controller.words().to_owned(),
        law(&run.made),
        number(m.gain, 3),
        number(m.phase_deg, 3),
        number(m.modulus, 3),
        significant(m.crossover_hz, 3),
    ])
}

fn number(x: f64, digits: usize) -> String {
    if x.is_finite() { significant(x, digits) } else { "∞".to_owned() }
}

/// The law as a formula, s in rad/s.
pub fn law(made: &Loop) -> String {
    if let Some((gain, _)) = made.observer {
        return format!("observer, gain {}", significant(gain, 3));
    }
    let Some(tuned) = &made.feedback else { return "–".to_owned() };
    let (k, i) = (significant(tuned.law.proportional, 3), significant(tuned.law.integral_per_s, 3));
    match tuned.law.kind {
        FeedbackKind::Integral => format!("{i}/s"),
        FeedbackKind::Pi { corner_hz } => format!("{k} (1 + 2π {}/s)", significant(corner_hz, 3)),
        FeedbackKind::FractionalPi { corner_hz, order } => {
            format!("{k} (1 + (2π {}/s)^{order})", significant(corner_hz, 3))
        }
        FeedbackKind::NotchIntegral { notch } => format!(
            "{i}/s, notch at {} Hz, damping {} over {}",
            significant(notch.frequency_hz, 4),
            significant(notch.zeros, 2),
            significant(notch.poles, 2)
        ),
    }
}

fn ends(x: &[f64]) -> (f64, f64) {
    x.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)))
}

pub fn introduction(found: &Found) -> String {
    let from = found.scored_from as f64 / found.sample_rate_hz;
    let slew = if found.settings.slew_v_per_s.is_finite() {
        format!(", at most {} {}/s", significant(found.settings.slew_v_per_s, 3), found.input)
    } else {
        String::new()
    };
    let [low, high] = found.settings.range_v;
    format!(
        "Simulated: {} follows {} at {} Hz, driven from {} to {} {}{slew}. Errors in {} of the displacement from {} s on, their mean taken off; \
         bandwidths by formula, of the model taken for linear and true.",
        found.plant_words,
        found.name,
        short(found.sample_rate_hz),
        significant(low, 4),
        significant(high, 4),
        found.input,
        found.output,
        significant(from, 3)
    )
}

pub fn text(found: &Found) -> String {
    let mut table = console::table(&HEADER);
    for run in &found.runs {
        table.add_row(cells(run));
    }
    let mut out = format!("{}\n\n{table}\n", introduction(found));
    let rows: Vec<_> = found.runs.iter().filter_map(margins).collect();
    if !rows.is_empty() {
        let mut table = console::table(&MARGINS);
        table.add_rows(rows);
        out += &format!("\n{table}\n");
    }
    if !found.reach.is_empty() {
        let mut table = console::table(&["sine of amplitude", "drive, amplitude", "up to, Hz"]);
        for r in &found.reach {
            table.add_row([
                format!("{} {}", significant(r.amplitude, 3), found.output),
                format!("{} {}", significant(r.amplitude_v, 3), found.input),
                significant(r.highest_hz, 3),
            ]);
        }
        out += &format!("\nWhat the largest rate of the drive leaves, by formula:\n{table}\n");
    }
    out
}

#[derive(Serialize)]
pub struct Summary {
    simulated: bool,
    plant: PlantArg,
    samples: usize,
    sample_rate_hz: f64,
    scored_from_s: f64,
    range: [f64; 2],
    slew_per_s: Option<f64>,
    input_unit: String,
    output_unit: String,
    controllers: Vec<Row>,
    reach: Vec<ReachRow>,
}

#[derive(Serialize)]
struct Row {
    controller: String,
    rms: f64,
    max: f64,
    mean: f64,
    rms_percent_of_stroke: f64,
    max_percent_of_stroke: f64,
    minus_3_db_hz: f64,
    one_percent_error_hz: f64,
    drive_low: f64,
    drive_high: f64,
    samples_at_range: usize,
    samples_at_slew: usize,
    law: Option<String>,
    gain_margin: Option<f64>,
    phase_margin_deg: Option<f64>,
    modulus_margin: Option<f64>,
    crossover_hz: Option<f64>,
}

#[derive(Serialize)]
struct ReachRow {
    amplitude: f64,
    drive_amplitude: f64,
    highest_hz: f64,
}

pub fn summary(found: &Found) -> Summary {
    let finite = |x: f64| x.is_finite().then_some(x);
    let row = |run: &Run| {
        let (drive_low, drive_high) = ends(&run.played.drive);
        let margins = run.made.margins();
        Row {
            controller: run.controller.name(),
            rms: run.score.rms,
            max: run.score.max,
            mean: run.score.mean,
            rms_percent_of_stroke: run.score.rms_percent,
            max_percent_of_stroke: run.score.max_percent,
            minus_3_db_hz: run.made.bandwidth.minus_3_db_hz,
            one_percent_error_hz: run.made.bandwidth.one_percent_hz,
            drive_low,
            drive_high,
            samples_at_range: run.played.at_range,
            samples_at_slew: run.played.at_slew,
            law: margins.map(|_| law(&run.made)),
            gain_margin: margins.and_then(|m| finite(m.gain)),
            phase_margin_deg: margins.and_then(|m| finite(m.phase_deg)),
            modulus_margin: margins.and_then(|m| finite(m.modulus)),
            crossover_hz: margins.map(|m| m.crossover_hz),
        }
    };
    Summary {
        simulated: true,
        plant: found.plant,
        samples: found.reference.len(),
        sample_rate_hz: found.sample_rate_hz,
        scored_from_s: found.scored_from as f64 / found.sample_rate_hz,
        range: found.settings.range_v,
        slew_per_s: finite(found.settings.slew_v_per_s),
        input_unit: found.input.symbol().to_owned(),
        output_unit: found.output.symbol().to_owned(),
        controllers: found.runs.iter().map(row).collect(),
        reach: found
            .reach
            .iter()
            .map(|r| ReachRow {
                amplitude: r.amplitude,
                drive_amplitude: r.amplitude_v,
                highest_hz: r.highest_hz,
            })
            .collect(),
    }
}
