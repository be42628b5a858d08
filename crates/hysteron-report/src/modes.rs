//! Sections of the report of scheduled modes: modes, gains, hysteresis, responses, spectra of the errors.

use hysteron_identify::modes::{ModesIdentification, ModesRecordFit};
use hysteron_model::Model;
use hysteron_model::axes::spectrum;
use hysteron_numeric::Complex64;

use crate::figure::{
    Axis, Colour, Dash, Figure, FrequencyResponseCurve, Panel, Series, Style, frequency_response,
};
use crate::number::significant;
use crate::page::{Block, Section};
use crate::results::modes::{ABOUT_GAINS, ABOUT_WEIGHTS, Names, gains, modes, weights};

/// Frequencies of a drawn response.
const DRAWN: usize = 1200;
/// Share of the strongest line of the inputs below which a line is not excited.
const EXCITED: f64 = 1e-5;

/// The sections, for a model whose channels are named in `model`.
pub(crate) fn sections(found: &ModesIdentification, model: &Model) -> Vec<Section> {
    let names = Names::of(model);
    let mut all = vec![
        Section::new("Modes").block(modes(found).for_page(1)).block(Block::paragraph(
            "Standard errors are those of the joint fit: its Jacobian, the scatter of each output's residual \
             and its correlation. They assume that the model class is correct.",
        )),
        Section::new("Gains at rest").block(gains(found, &names).for_page(2).note(ABOUT_GAINS)),
    ];
    if let Some(listing) = weights(found, &names) {
        all.push(Section::new("Hysteresis").block(listing.for_page(1).note(ABOUT_WEIGHTS)));
    }
    all.push(Section::new("Frequency response").blocks(responses(found, &names)));
    let spectra = found.records.iter().filter(|record| !record.error.is_empty());
    all.push(Section::new("Spectrum of the error").blocks(spectra.map(|record| spectra_of(record, &names))));
    all
}

/// The linear part at the highest level: a figure per output.
fn responses(found: &ModesIdentification, names: &Names) -> Vec<Figure> {
    let model = &found.model;
    let (low_hz, high_hz) = found.excited_hz;
    if !(low_hz > 0.0 && high_hz > low_hz) {
        return Vec::new();
    }
    let step = (high_hz / low_hz).ln() / (DRAWN - 1) as f64;
    let frequency_hz: Vec<f64> = (0..DRAWN).map(|k| low_hz * (step * k as f64).exp()).collect();
    let highest = model.level.state(model.level.highest);
    let response: Vec<Vec<Complex64>> =
        frequency_hz.iter().map(|f| model.linear_response(*f, highest)).collect();
    let figure = |(o, output): (usize, &String)| {
        let curve = |(i, input): (usize, &String)| {
            let g = |k: usize| response[k][o * model.inputs + i];
            FrequencyResponseCurve {
                label: input.clone(),
                frequency_hz: frequency_hz.clone(),
                magnitude: (0..DRAWN).map(|k| g(k).norm()).collect(),
                phase_deg: unwrapped((0..DRAWN).map(g)),
                as_points: false,
            }
        };
        let curves: Vec<_> = names.inputs.iter().enumerate().map(curve).collect();
        frequency_response(format!("Response of {output}"), &names.gain_unit, &curves).captioned(format!(
            "Linear part from each input to {output} at {} {} rms, over the band of the records.",
            significant(model.level.highest, 3),
            names.input_unit
        ))
    };
    names.outputs.iter().enumerate().map(figure).collect()
}

/// Phase \[°\] without jumps.
fn unwrapped(values: impl Iterator<Item = Complex64>) -> Vec<f64> {
    let mut last: Option<f64> = None;
    values
        .map(|g| {
            let phase = g.arg().to_degrees();
            let near = last.map_or(phase, |last| phase - 360.0 * ((phase - last) / 360.0).round());
            *last.insert(near)
        })
        .collect()
}

/// Amplitudes of the outputs and of their errors at the excited lines.
fn spectra_of(record: &ModesRecordFit, names: &Names) -> Figure {
    let period = &record.steady;
    let (n, m, samples) = (period.inputs, period.outputs, period.samples());
    let (u, y, e) = (spectrum(&period.u, n), spectrum(&period.y, m), spectrum(&record.error, m));
    let power = |k: usize| u[k * n..(k + 1) * n].iter().map(|u| u.norm_sqr()).sum::<f64>();
    let lines = 1..samples.div_ceil(2);
    let most = lines.clone().map(power).fold(0.0, f64::max);
    let lines: Vec<usize> = lines.filter(|&k| power(k) > EXCITED * most).collect();
    let frequency: Vec<f64> =
        lines.iter().map(|&k| k as f64 * period.sample_rate_hz / samples as f64).collect();
    let amplitude = |of: &[Complex64], o: usize| -> Vec<f64> {
        lines.iter().map(|&k| 2.0 * of[k * m + o].norm()).collect()
    };
    let mut figure = Figure::new(format!("Output and error: {}", record.record)).panel_height(110.0).link_x();
    for (o, output) in names.outputs.iter().enumerate() {
        let points =
            |colour| Style::line(colour).with_dash(Dash::None).with_marker(crate::figure::Marker::Dot);
        let panel = Panel::new(Axis::log("frequency", "Hz"), Axis::log("amplitude", &names.output_unit))
            .titled(output.as_str())
            .series(Series::line("output", frequency.clone(), amplitude(&y, o), points(Colour::Blue)))
            .series(Series::line("error", frequency.clone(), amplitude(&e, o), points(Colour::Vermillion)));
        figure = figure.panel(panel);
    }
    figure.captioned(format!(
        "Amplitudes of the mean period of record {} and of its error, at the excited lines; {} {} rms, fit \
         {} %.",
        record.record,
        significant(record.level, 3),
        names.input_unit,
        significant(record.fit_percent, 4)
    ))
}
