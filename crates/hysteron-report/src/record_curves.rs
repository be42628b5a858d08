//! One record with the model's simulation of it: loop, time curves with their bands, residual.

use crate::figure::{
    Axis, Colour, Dash, Figure, Panel, Series, Style, correlogram, measured_and_model, residual,
};
use crate::number::significant;
use crate::sines;
use hysteron_identify::SineResponse;
use hysteron_model::record::{InputOutput, Quantity, Segment, Unit};
use hysteron_model::validate::{Correlogram, residual_input_correlation, residual_whiteness};

/// One record with the model's simulation, all of the same length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RecordCurves {
    /// Name, e.g. the file.
    pub name: String,
    /// `fitted` or `held out`.
    pub role: String,
    /// Time \[s\].
    pub time_s: Vec<f64>,
    /// Name and unit of the input, e.g. `("voltage", "V")`.
    pub input: (String, String),
    /// Input values.
    pub u: Vec<f64>,
    /// Name and unit of the output, e.g. `("displacement", "µm")`.
    pub output: (String, String),
    /// Measured output.
    pub measured: Vec<f64>,
    /// Simulated output.
    pub model: Vec<f64>,
    /// Whether a sample was used; empty means all. Unused samples are not drawn.
    pub valid: Vec<bool>,
    /// Half the widths of the 95 % bands; `None` where they are not known.
    pub band: Option<BandWidths>,
    /// Time up to which samples were skipped in the scores \[s\]; 0 for none.
    pub skipped_until_s: f64,
    /// Autocorrelation of the residual; `None` for a record too short for it.
    pub autocorrelation: Option<Correlogram>,
    /// Correlation of the residual with the input.
    pub input_correlation: Option<Correlogram>,
    /// Oscillations and rests of a record in segments: measured, and of the model.
    pub segments: Vec<(Segment, Segment)>,
    /// Gain and phase at its oscillations.
    pub sines: Vec<SineResponse>,
    /// Unit of a gain.
    pub gain_unit: String,
}

/// Half the widths of 95 % bands at every sample, in the unit of the output.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BandWidths {
    /// Band of the model's output, from the uncertainty of the parameters.
    pub model: Vec<f64>,
    /// Band of a new measurement, which adds the scatter of the residual.
    pub measurement: Vec<f64>,
}

impl RecordCurves {
    /// Curves of a record and its simulation, to which `offset` is added; the first `left_out` samples were
    /// not scored.
    pub fn new(data: &InputOutput, simulated: &[f64], offset: f64, left_out: usize) -> Self {
        let InputOutput { name, time, u, y, valid, .. } = data;
        let samples = u.len();
        let time_s: Vec<f64> = (0..samples).map(|k| time.time_s(k).unwrap_or(k as f64)).collect();
        let model: Vec<f64> = simulated.iter().map(|x| x + offset).collect();
        let residual: Vec<f64> = y.iter().zip(&model).map(|(y, model)| y - model).collect();
        let valid_at = |k: usize| valid.as_ref().is_none_or(|mask| mask.get(k) == Some(&true));
        let scored: Vec<bool> = (0..samples).map(|k| k >= left_out && valid_at(k)).collect();
        let of_model = InputOutput { y: model.clone(), ..data.clone() };
        let segments = data.segments().into_iter().zip(of_model.segments()).collect();
        let gain_unit = match (data.y_unit.symbol(), data.u_unit.symbol()) {
            ("", _) | (_, "") => String::new(),
            _ => format!("{}/{}", data.y_unit, data.u_unit),
        };
        Self {
            segments,
            sines: SineResponse::of_record(data, &model),
            gain_unit,
            name: name.clone(),
            role: String::new(),
            skipped_until_s: if left_out > 0 { time_s.get(left_out).copied().unwrap_or(0.0) } else { 0.0 },
            band: None,
            autocorrelation: residual_whiteness(&residual, &scored),
            input_correlation: residual_input_correlation(&residual, u, &scored),
            time_s,
            input: labelled(&data.input, &data.u_unit, "input"),
            u: u.clone(),
            output: labelled(&data.output, &data.y_unit, "output"),
            measured: y.clone(),
            model,
            valid: valid.clone().unwrap_or_default(),
        }
    }

    /// Loop, time curves, their start and the tests of the residual, marked for a simulated record.
    pub fn figures(&self) -> Vec<Figure> {
        let own = [
            Some(self.loop_figure()),
            Some(self.time_figure()),
            self.start_figure(),
            self.segments_figure(),
            self.residual_figure(),
        ];
        own.into_iter().flatten().map(|figure| self.marked(figure)).collect()
    }

    /// Marks the figure where the record comes from a simulated bench.
    pub fn marked(&self, figure: Figure) -> Figure {
        if is_simulated(&self.name) { figure.subtitled("simulated bench") } else { figure }
    }

    /// The values of valid samples, NaN elsewhere.
    fn masked(&self, values: &[f64]) -> Vec<f64> {
        let used = |k: usize| self.valid.is_empty() || self.valid.get(k).copied().unwrap_or(false);
        values.iter().enumerate().map(|(k, v)| if used(k) { *v } else { f64::NAN }).collect()
    }

    fn x_axis(&self) -> Axis {
        Axis::linear(&self.input.0, &self.input.1)
    }

    fn y_axis(&self) -> Axis {
        Axis::linear(&self.output.0, &self.output.1)
    }

    /// The loop, measured and model.
    pub fn loop_figure(&self) -> Figure {
        let (measured, model) = (self.masked(&self.measured), self.masked(&self.model));
        Figure::new(format!("Hysteresis loop: {}", self.name))
            .panel(measured_and_model(self.x_axis(), self.y_axis(), &self.u, &measured, &model))
            .panel_height(310.0)
            .captioned(format!(
                "Measured and simulated {} over {} of record {}.",
                self.output.0, self.input.0, self.name
            ))
    }

    /// Input, output and residual over time, on one time axis.
    pub fn time_figure(&self) -> Figure {
        self.curves_over_time(self.time_s.len()).titled(format!("Time curves: {}", self.name)).captioned(
            format!(
                "Input, measured and simulated output, and residual (measured − model) of record {}.{}",
                self.name,
                self.about_bands()
            ),
        )
    }

    /// Coverage and width of the bands, in words; empty without bands.
    fn about_bands(&self) -> String {
        let Some(band) = &self.band else { return String::new() };
        let used = |k: &usize| self.valid.is_empty() || self.valid.get(*k).copied().unwrap_or(false);
        let all: Vec<usize> = (0..self.measured.len().min(band.measurement.len())).filter(used).collect();
        let inside = |k: &&usize| (self.measured[**k] - self.model[**k]).abs() <= band.measurement[**k];
        let share = 100.0 * all.iter().filter(inside).count() as f64 / all.len().max(1) as f64;
        let largest = band.model.iter().copied().fold(0.0, f64::max);
        format!(
            " Bands around the model: the dark one (± {} {} at its widest) holds the output of the model \
             with the true parameters in 95 of 100 campaigns, the pale one 95 % of new measurements; it \
             holds {} % of these. Both assume that the model class is correct: its errors are in the scatter \
             of the residual, not in the dark band.",
            significant(largest, 2),
            self.output.1,
            significant(share, 3)
        )
    }

    /// The first periods of a record that has more than [`CROWDED`], over time; `None` for other records.
    pub fn start_figure(&self) -> Option<Figure> {
        let starts = self.period_starts();
        if starts.len() <= CROWDED {
            return None;
        }
        // The record may begin within a period, so its end is counted from the record's first sample.
        let end = starts.get(PERIODS_SHOWN)?.checked_sub(*starts.first()?)?;
        let figure = self.curves_over_time(end.min(self.time_s.len()));
        Some(figure.titled(format!("Start of the record: {}", self.name)).captioned(format!(
            "The first {PERIODS_SHOWN} of {} periods of record {}.",
            starts.len(),
            self.name
        )))
    }

    /// Gain and phase at the oscillations of a record in segments, measured and model, and how the output
    /// creeps at its rests; `None` for a record with fewer than two oscillations.
    pub fn segments_figure(&self) -> Option<Figure> {
        let figure = sines::figure(&self.name, &self.gain_unit, &self.sines)?;
        let rests = self.segments.iter().filter_map(|(own, model)| Some((own, own.creep?, model.creep?)));
        let rests = rests.map(|(own, measured, model)| {
            let (measured, model) = (significant(measured, 3), significant(model, 3));
            let (unit, at) = (&self.output.1, significant(own.start_s, 4));
            format!(
                " At rest from {at} s on the output creeps by {measured} {unit}, the model's by {model} \
                {unit}."
            )
        });
        let caption = format!("{}{}", figure.caption, rests.collect::<String>());
        Some(figure.captioned(caption))
    }

    /// Samples at which the input rises through the middle of its range, after having been below a tenth
    /// of the range under it.
    fn period_starts(&self) -> Vec<usize> {
        let values = || self.u.iter().copied().filter(|u| u.is_finite());
        let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), u| (a.min(u), b.max(u)));
        let (middle, armed_below) = (0.5 * (low + high), 0.4 * high + 0.6 * low);
        let (mut armed, mut starts) = (false, Vec::new());
        for (k, u) in self.u.iter().enumerate() {
            armed |= *u < armed_below;
            if armed && *u >= middle {
                armed = false;
                starts.push(k);
            }
        }
        starts
    }

    /// Correlation of the residual with itself and with the input; `None` for a record too short for it.
    pub fn residual_figure(&self) -> Option<Figure> {
        let tests = [
            ("with itself", self.autocorrelation.as_ref()?),
            ("with the input", self.input_correlation.as_ref()?),
        ];
        let mut figure = Figure::new(format!("Residual: {}", self.name)).in_columns(2).panel_height(150.0);
        let mut outside = Vec::new();
        for (title, c) in tests {
            figure = figure.panel(correlogram(title, c.first_lag, &c.coefficients, c.bound));
            let test = c.test();
            outside.push(format!("{} of {} lags {title}", test.outside, test.lags));
        }
        Some(figure.captioned(format!(
            "Correlation of the residual of record {}. Noise alone would stay within the 99 % bounds \
             (dashed) at all but about one lag in a hundred; outside are {}. Values outside indicate \
             structure that the model does not describe: creep, minor loops, dynamics (positive lags of the \
             input), or a delay that is too long (negative lags).",
            self.name,
            outside.join(" and ")
        )))
    }

    /// Input, output and residual of the first `samples` samples.
    fn curves_over_time(&self, samples: usize) -> Figure {
        let first = |values: &[f64]| values.iter().take(samples).copied().collect::<Vec<f64>>();
        let time_s = first(&self.time_s);
        let (measured, model) = (first(&self.masked(&self.measured)), first(&self.masked(&self.model)));
        let time = || Axis::linear("time", "s");
        let grey = Style::line(Colour::Grey).with_width(1.2);
        let input =
            Panel::new(time(), self.x_axis()).series(Series::line("", time_s.clone(), first(&self.u), grey));
        let mut output = measured_and_model(time(), self.y_axis(), &time_s, &measured, &model);
        let mut error = residual(time(), &self.output.1, &time_s, &measured, &model);
        if let Some(band) = &self.band {
            let around_zero = |label: &str, colour: Colour, half: &[f64]| {
                let half = first(half);
                let zero = vec![0.0; half.len()];
                let lower = half.iter().map(|h| -h).collect();
                let style = Style::line(colour).with_dash(Dash::None);
                Series::line(label, time_s.clone(), zero, style).with_band(lower, half)
            };
            let bands = [
                around_zero("95 % of new measurements", Colour::Sky, &band.measurement),
                around_zero("95 % band of the model", Colour::Ink, &band.model),
            ];
            // Behind the residual.
            error.series.splice(0..0, bands);
        }
        if let (Some(start), true) = (time_s.first(), self.skipped_until_s > 0.0) {
            output = output.span(*start, self.skipped_until_s, "not scored");
            error = error.span(*start, self.skipped_until_s, "");
        }
        Figure::new("").panel(input).panel(output).panel(error).panel_height(112.0).link_x()
    }
}

/// Whether a record of this name comes from a simulated bench, which marks every name.
pub fn is_simulated(record: &str) -> bool {
    record.to_lowercase().contains("simulated")
}

/// Quantity and name of a channel, and its unit.
fn labelled(channel: &str, unit: &Unit, otherwise: &str) -> (String, String) {
    let word = match unit.base().0 {
        Quantity::Voltage => "voltage",
        Quantity::Length => "displacement",
        Quantity::Angle => "angle",
        _ => otherwise,
    };
    (format!("{word} {channel}"), unit.to_string())
}

/// A time curve with more periods than this shows little: its start is drawn as well.
pub const CROWDED: usize = 12;

/// Periods in the figure of the start of a record.
const PERIODS_SHOWN: usize = 4;

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::*;
    use hysteron_model::record::TimeBase;
    use std::f64::consts::TAU;

    /// Sines of 5 and 50 Hz, each at its own rate, beside a ramp; the model's gain is 5 % larger.
    #[test]
    fn gain_and_phase_at_the_oscillations_are_shown_where_there_are_several() {
        let ramp = (0..200).map(|k| (f64::from(k) * 5e-3, 0.05 * f64::from(k)));
        let sine = |from: f64, hz: f64, rate: f64| {
            (0..400).map(move |k| {
                (from + f64::from(k) / rate, 10.0 + 0.2 * (TAU * hz * f64::from(k) / rate).sin())
            })
        };
        let (times_s, u): (Vec<f64>, Vec<f64>) =
            ramp.chain(sine(1.2, 5.0, 200.0)).chain(sine(3.4, 50.0, 2000.0)).unzip();
        let y: Vec<f64> = u.iter().map(|u| 0.2 * u).collect();
        let model: Vec<f64> = y.iter().map(|y| 1.05 * y).collect();
        let mut data = InputOutput::new("r", TimeBase::NonUniform { times_s }, u, y).unwrap();
        (data.u_unit, data.y_unit) = (Unit::new("V"), Unit::new("um"));
        let curves = RecordCurves::new(&data, &model, 0.0, 0);
        let figure = curves.segments_figure().unwrap();
        let of = |label: &str| figure.panels[0].series.iter().find(|s| s.label == label).unwrap();
        assert_eq!(of("measured").x.len(), 2);
        for (measured, model) in of("measured").y.iter().zip(&of("model").y) {
            assert!(
                (measured - 0.2).abs() < 1e-3 && (model / measured - 1.05).abs() < 1e-6,
                "{measured} {model}"
            );
        }
        assert_eq!(curves.gain_unit, "µm/V");
        let even = InputOutput { time: TimeBase::uniform(100.0), ..data };
        assert!(RecordCurves::new(&even, &model, 0.0, 0).segments_figure().is_none());
    }
}
