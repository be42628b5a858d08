//! Gain and phase at the sines of a record, measured and of the model, with their 95 % intervals.

use crate::figure::{Axis, Colour, Dash, Figure, Marker, Panel, Series, Style};
use crate::number::significant;
use hysteron_identify::{GainPhase, SineResponse};

/// Width of the bars behind the model's points \[px\].
const BAR_PX: f64 = 9.0;

/// Points of one panel, measured and model: values and half the widths of their intervals, NaN where there is
/// none.
struct Shown {
    measured: Vec<(f64, f64)>,
    model: Vec<(f64, f64)>,
}

impl Shown {
    fn of(sines: &[SineResponse], values: impl Fn(&SineResponse) -> [(f64, f64); 2]) -> Self {
        let (measured, model) = sines.iter().map(|sine| values(sine).into()).unzip();
        Self { measured, model }
    }

    fn panel(&self, hz: &[f64], y: Axis) -> Panel {
        let points = |label: &str, values: &[(f64, f64)], colour: Colour, marker: Marker| {
            let style = Style::line(colour).with_marker(marker).with_dash(Dash::None);
            Series::line(label, hz.to_vec(), values.iter().map(|v| v.0).collect(), style)
        };
        // Ends of an interval, then a break.
        let bars = |label: &str, values: &[(f64, f64)], style: Style| {
            let x = hz.iter().flat_map(|f| [*f, *f, f64::NAN]).collect();
            let y = values.iter().flat_map(|(v, half)| [v - half, v + half, f64::NAN]).collect();
            let known = values.iter().any(|(_, half)| half.is_finite());
            known.then(|| Series::line(label, x, y, style))
        };
        let wide = Style::line(Colour::Orange).with_width(BAR_PX);
        let series = [
            bars("model, 95 %", &self.model, wide),
            Some(points("model", &self.model, Colour::Ink, Marker::Square)),
            bars("measured, 95 %", &self.measured, Style::line(Colour::Blue)),
            Some(points("measured", &self.measured, Colour::Blue, Marker::Circle)),
        ];
        series.into_iter().flatten().fold(Panel::new(Axis::log("frequency", "Hz"), y), Panel::series)
    }
}

/// Gain and phase at the sines, measured and of the model, and their difference; `None` of fewer than two
/// sines. `record`: its name.
pub(crate) fn figure(record: &str, gain_unit: &str, sines: &[SineResponse]) -> Option<Figure> {
    if sines.len() < 2 {
        return None;
    }
    let mut sines = sines.to_vec();
    sines.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    let hz: Vec<f64> = sines.iter().map(|sine| sine.frequency_hz).collect();
    let half = |of: Option<f64>| of.unwrap_or(f64::NAN);
    let gain = |at: &GainPhase| (at.gain, half(at.gain_95()));
    let phase = |at: &GainPhase| (at.phase_deg, half(at.phase_95_deg()));
    let gains = Shown::of(&sines, |s| [gain(&s.measured), gain(&s.model)]);
    let phases = Shown::of(&sines, |s| [phase(&s.measured), phase(&s.model)]);
    let gain_errors = Shown::of(&sines, |s| {
        let percent = 100.0 / s.measured.gain;
        let [measured, model] = [gain(&s.measured), gain(&s.model)];
        [(0.0, percent * measured.1), (percent * (model.0 - measured.0), percent * model.1)]
    });
    let phase_errors = Shown::of(&sines, |s| {
        let [measured, model] = [phase(&s.measured), phase(&s.model)];
        let turned = model.0 - measured.0;
        [(0.0, measured.1), (turned - 360.0 * (turned / 360.0).round(), model.1)]
    });
    Some(
        Figure::new(format!("Gain and phase at the oscillations: {record}"))
            .in_columns(2)
            .panel_height(200.0)
            .panel(gains.panel(&hz, Axis::log("gain", gain_unit)))
            .panel(gain_errors.panel(&hz, Axis::linear("gain, model − measured", "%")))
            .panel(phases.panel(&hz, Axis::linear("phase", "°")))
            .panel(phase_errors.panel(&hz, Axis::linear("phase, model − measured", "°")))
            .link_x()
            .captioned(caption(record, &gain_errors, &phase_errors)),
    )
}

/// Caption, with the intervals at their widest.
fn caption(record: &str, gain: &Shown, phase: &Shown) -> String {
    let widest = |values: &[(f64, f64)]| values.iter().map(|v| v.1).fold(f64::NAN, f64::max);
    let about = |gain: f64, phase: f64| {
        format!("± {} % and ± {}° at its widest", significant(gain, 2), significant(phase, 2))
    };
    let mut text = format!(
        "Fundamental of the output over that of the input in every oscillating segment of record {record}, \
         measured and in the free run of the model; on the right the difference."
    );
    let [scatter_gain, scatter_phase] = [widest(&gain.measured), widest(&phase.measured)];
    if scatter_gain.is_finite() {
        text += &format!(
            " Thin bars: 95 % interval of what was measured, by the scatter of the output about the sine \
             ({}).",
            about(scatter_gain, scatter_phase)
        );
    }
    let [model_gain, model_phase] = [widest(&gain.model), widest(&phase.model)];
    if model_gain.is_finite() {
        text += &format!(
            " Wide bars: 95 % band of the model, from the uncertainty of its parameters ({}); it assumes \
             that the model class is correct: points farther apart than both bars show errors of the class.",
            about(model_gain, model_phase)
        );
    }
    text
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::*;

    fn sine(frequency_hz: f64, model_error: Option<f64>) -> SineResponse {
        let measured = GainPhase {
            gain: 0.2,
            gain_std_error: Some(1e-3),
            phase_deg: 179.0,
            phase_std_error_deg: Some(0.5),
        };
        let model = GainPhase {
            gain: 0.21,
            gain_std_error: model_error.map(|e| 0.21 * e),
            phase_deg: -179.0,
            phase_std_error_deg: model_error.map(f64::to_degrees),
        };
        SineResponse { samples: 0..100, frequency_hz, measured, model }
    }

    #[test]
    fn points_have_their_intervals_and_the_difference_is_seen_beside_them() {
        let figure = figure("r", "µm/V", &[sine(50.0, Some(0.01)), sine(5.0, Some(0.02))]).unwrap();
        let [gain, gain_less, _, phase_less] = &figure.panels[..] else { panic!("{}", figure.panels.len()) };
        assert_eq!(
            gain.series.iter().map(|s| s.label.as_str()).collect::<Vec<_>>(),
            ["model, 95 %", "model", "measured, 95 %", "measured"]
        );
        assert_eq!(gain.series[1].x, [5.0, 50.0]);
        // ± 1.96 · 2 % of 0.21.
        let band = &gain.series[0].y;
        assert!(
            (band[1] - band[0] - 2.0 * 1.959_964 * 0.02 * 0.21).abs() < 1e-6 && band[2].is_nan(),
            "{band:?}"
        );
        assert!((gain_less.series[1].y[0] - 5.0).abs() < 1e-9 && gain_less.series[3].y == [0.0, 0.0]);
        assert!((phase_less.series[1].y[0] - 2.0).abs() < 1e-9, "{:?}", phase_less.series[1]);
        assert!(
            figure.caption.contains("Wide bars") && figure.caption.contains("± 4.1 %"),
            "{}",
            figure.caption
        );
    }

    #[test]
    fn without_errors_of_the_model_there_is_no_band() {
        let figure = figure("r", "", &[sine(5.0, None), sine(50.0, None)]).unwrap();
        assert_eq!(figure.panels[0].series.len(), 3);
        assert!(!figure.caption.contains("Wide bars"));
        assert!(super::figure("r", "", &[sine(5.0, None)]).is_none());
    }
}
