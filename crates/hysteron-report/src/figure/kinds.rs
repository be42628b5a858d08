//! The kinds of figure and panel that Hysteron's pages are made of.

use super::{Axis, Colour, Dash, Figure, Marker, Panel, Series, Style};

/// Measured and model over the same abscissa: over the input it is a loop, over time a time curve.
///
/// The measured curve is wide and pale, the model thin and dark on top.
pub fn measured_and_model(x_axis: Axis, y_axis: Axis, x: &[f64], measured: &[f64], model: &[f64]) -> Panel {
    Panel::new(x_axis, y_axis)
        .series(Series::line("measured", x.to_vec(), measured.to_vec(), Style::measured()))
        .series(Series::line("model", x.to_vec(), model.to_vec(), Style::model()))
}

/// Residual `measured − model` over `x`. Entries where either is missing break the line.
pub fn residual(
    x_axis: Axis,
    y_unit: impl Into<String>,
    x: &[f64],
    measured: &[f64],
    model: &[f64],
) -> Panel {
    let difference = measured.iter().zip(model).map(|(y, m)| y - m).collect();
    Panel::new(x_axis, Axis::linear("residual", y_unit)).series(Series::line(
        "",
        x.to_vec(),
        difference,
        Style::residual(),
    ))
}

/// Repeated runs of one optimiser, sampled at the same abscissae.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ConvergenceCurve {
    /// Name of the optimiser.
    pub label: String,
    /// Abscissae common to all runs (generations or evaluations).
    pub x: Vec<f64>,
    /// Best objective value so far of each run, at every abscissa.
    pub runs: Vec<Vec<f64>>,
}

impl ConvergenceCurve {
    /// The `p`-quantile (0 ≤ p ≤ 1) over the runs at every abscissa, with linear interpolation between
    /// order statistics (Hyndman & Fan type 7, doi:10.1080/00031305.1996.10473566); runs that are shorter
    /// or not finite there are left out, and an abscissa without any run is NaN.
    pub fn quantile(&self, p: f64) -> Vec<f64> {
        (0..self.x.len())
            .map(|k| {
                let mut values: Vec<f64> = self
                    .runs
                    .iter()
                    .filter_map(|run| run.get(k).copied())
                    .filter(|v| v.is_finite())
                    .collect();
                values.sort_by(f64::total_cmp);
                let position = p.clamp(0.0, 1.0) * values.len().saturating_sub(1) as f64;
                let (below, share) = (position.floor() as usize, position.fract());
                match (values.get(below), values.get(below + 1)) {
                    (Some(a), Some(b)) => a + share * (b - a),
                    (Some(a), None) => *a,
                    _ => f64::NAN,
                }
            })
            .collect()
    }
}

/// Convergence: median over the runs as a line, quartiles as a band, objective on a logarithmic axis.
/// Curves of a single run are drawn without a band.
pub fn convergence(
    title: impl Into<String>,
    x_label: impl Into<String>,
    y_axis: Axis,
    curves: &[ConvergenceCurve],
) -> Figure {
    let mut panel = Panel::new(Axis::linear(x_label, ""), y_axis);
    for (i, curve) in curves.iter().enumerate() {
        let style = Style::nth(i).with_width(1.8);
        let mut series = Series::line(curve.label.clone(), curve.x.clone(), curve.quantile(0.5), style);
        if curve.runs.len() > 1 {
            series = series.with_band(curve.quantile(0.25), curve.quantile(0.75));
        }
        panel = panel.series(series);
    }
    Figure::new(title).panel(panel).panel_height(260.0)
}

/// A frequency response `G(2πi f)`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FrequencyResponseCurve {
    /// Name in the legend; may be empty when there is only one.
    pub label: String,
    /// Frequencies \[Hz\], ascending.
    pub frequency_hz: Vec<f64>,
    /// |G|, in the unit named by the figure.
    pub magnitude: Vec<f64>,
    /// arg G \[°\], unwrapped.
    pub phase_deg: Vec<f64>,
    /// Marks instead of a line, for measured points.
    pub as_points: bool,
}

/// Magnitude above phase over a common logarithmic frequency axis.
pub fn frequency_response(
    title: impl Into<String>,
    magnitude_unit: impl Into<String>,
    curves: &[FrequencyResponseCurve],
) -> Figure {
    let frequency = || Axis::log("frequency", "Hz");
    let mut magnitude = Panel::new(frequency(), Axis::log("magnitude", magnitude_unit));
    let mut phase = Panel::new(frequency(), Axis::linear("phase", "°"));
    for (i, curve) in curves.iter().enumerate() {
        let mut style = Style::nth(i);
        if curve.as_points {
            style = style.marked(0).with_dash(Dash::None);
        }
        let series =
            |y: &[f64]| Series::line(curve.label.clone(), curve.frequency_hz.clone(), y.to_vec(), style);
        magnitude = magnitude.series(series(&curve.magnitude));
        phase = phase.series(series(&curve.phase_deg));
    }
    Figure::new(title).panel(magnitude).panel(phase).panel_height(180.0).link_x()
}

/// Correlation coefficients by lag as bars, with their bounds as dashed lines.
pub fn correlogram(title: impl Into<String>, first_lag: i64, coefficients: &[f64], bound: f64) -> Panel {
    let lags: Vec<f64> = (first_lag..).take(coefficients.len()).map(|lag| lag as f64).collect();
    let ends = match (lags.first(), lags.last()) {
        (Some(first), Some(last)) => vec![first - 0.5, last + 0.5],
        _ => Vec::new(),
    };
    let bars = Style::line(Colour::Blue).with_marker(Marker::Bar);
    let limit = Style::line(Colour::Vermillion).with_dash(Dash::Dashed).with_width(1.2);
    let line = |label: &str, y: f64| Series::line(label, ends.clone(), vec![y; ends.len()], limit);
    Panel::new(Axis::linear("lag", "samples"), Axis::linear("correlation", "").with_range(-1.05, 1.05))
        .titled(title)
        .series(Series::line("", lags, coefficients.to_vec(), bars))
        .series(line("99 % bounds", bound))
        .series(line("", -bound))
}

/// A correlation matrix as coloured cells: `names` and the square matrix, row by row.
pub fn correlation_matrix(title: impl Into<String>, names: &[String], matrix: &[Vec<f64>]) -> Figure {
    // Many rows are lower, so that the figure fits a page beside others.
    let cell_px = if names.len() > 10 { 24.0 } else { 34.0 };
    // Names are long: the columns are known by the numbers of the rows.
    let numbers: Vec<String> = (1..=names.len()).map(|k| k.to_string()).collect();
    let rows: Vec<String> = numbers.iter().zip(names).map(|(k, name)| format!("{name}  {k}")).collect();
    let mut panel = Panel::new(Axis::categories("", &numbers), Axis::categories("", rows.iter().rev()));
    panel.cells = matrix.to_vec();
    Figure::new(title).panel(panel).panel_height(cell_px * names.len().max(2) as f64)
}

/// Errors of several models at a few frequencies: marks joined by thin lines on logarithmic axes.
///
/// `models` holds a name and one value for each entry of `frequency_hz`.
pub fn errors_by_frequency(
    title: impl Into<String>,
    frequency_hz: &[f64],
    y_axis: Axis,
    models: &[(String, Vec<f64>)],
) -> Figure {
    let mut panel = Panel::new(Axis::log("frequency", "Hz"), y_axis);
    for (i, (name, values)) in models.iter().enumerate() {
        let style = Style::nth(i).marked(i).with_width(1.2);
        panel = panel.series(Series::line(name.clone(), frequency_hz.to_vec(), values.clone(), style));
    }
    Figure::new(title).panel(panel)
}

/// Bars of several models side by side over named cases.
///
/// `models` holds a name and one value for each entry of `cases`.
pub fn errors_by_category(
    title: impl Into<String>,
    x_label: impl Into<String>,
    cases: &[String],
    y_axis: Axis,
    models: &[(String, Vec<f64>)],
) -> Figure {
    let mut panel = Panel::new(Axis::categories(x_label, cases), y_axis);
    let positions: Vec<f64> = (0..cases.len()).map(|i| i as f64).collect();
    for (i, (name, values)) in models.iter().enumerate() {
        let style = Style::nth(i).with_marker(Marker::Bar);
        panel = panel.series(Series::line(name.clone(), positions.clone(), values.clone(), style));
    }
    Figure::new(title).panel(panel)
}

/// Histogram of the finite `values` in `bins` equal classes from the smallest to the largest.
pub fn histogram(title: impl Into<String>, x_axis: Axis, values: &[f64], bins: usize) -> Figure {
    let bins = bins.max(1);
    let finite = || values.iter().copied().filter(|v| v.is_finite());
    let (low, high) = finite().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    let width = (high - low) / bins as f64;
    let (mut centres, mut counts) = (Vec::new(), Vec::new());
    if width > 0.0 && width.is_finite() {
        counts = vec![0.0; bins];
        for v in finite() {
            counts[(((v - low) / width) as usize).min(bins - 1)] += 1.0;
        }
        centres = (0..bins).map(|i| low + (i as f64 + 0.5) * width).collect();
    } else if low == high {
        (centres, counts) = (vec![low], vec![finite().count() as f64]);
    }
    let style = Style::line(Colour::Blue).with_marker(Marker::Bar);
    Figure::new(title).panel(
        Panel::new(x_axis, Axis::linear("samples", "")).series(Series::line("", centres, counts, style)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_of_five_runs_are_the_second_third_and_fourth_value() {
        let runs = [5.0, 1.0, 4.0, 2.0, 3.0].map(|v| vec![v, 10.0 * v]).to_vec();
        let mut curve = ConvergenceCurve { label: String::new(), x: vec![0.0, 1.0, 2.0], runs };
        assert_eq!(curve.quantile(0.25)[..2], [2.0, 20.0]);
        assert_eq!(curve.quantile(0.5)[..2], [3.0, 30.0]);
        assert_eq!(curve.quantile(0.75)[..2], [4.0, 40.0]);
        assert!(curve.quantile(0.5)[2].is_nan(), "no run reaches the third abscissa");
        curve.runs.push(vec![f64::NAN, f64::INFINITY]);
        assert_eq!(curve.quantile(0.5)[..2], [3.0, 30.0]);
    }

    #[test]
    fn a_correlation_matrix_shows_every_coefficient_in_its_cell() {
        let names = ["α", "β"].map(String::from);
        let svg = correlation_matrix("c", &names, &[vec![1.0, -0.973], vec![-0.973, 1.0]]).to_svg();
        assert_eq!((svg.matches(">1.00<").count(), svg.matches(">−0.97<").count()), (2, 2), "{svg}");
        // The first row is the topmost one.
        let row = |name: &str| {
            let labels = svg.split("class=\"t ty\"").nth(1).unwrap();
            let before = labels.split(&format!(">{name}<")).next().unwrap();
            before.rsplit("y=\"").next().unwrap().split('"').next().unwrap().parse::<f64>().unwrap()
        };
        assert!(row("α  1") < row("β  2"));
    }

    #[test]
    fn a_histogram_counts_every_finite_value_once() {
        let values = [0.0, 0.1, 0.49, 0.5, 0.99, 1.0, f64::NAN];
        let figure = histogram("h", Axis::linear("x", ""), &values, 2);
        assert_eq!(figure.panels[0].series[0].x, [0.25, 0.75]);
        assert_eq!(figure.panels[0].series[0].y, [3.0, 3.0]);
        assert_eq!(histogram("h", Axis::linear("x", ""), &[2.0; 4], 9).panels[0].series[0].y, [4.0]);
        assert!(histogram("h", Axis::linear("x", ""), &[f64::NAN], 9).panels[0].series[0].y.is_empty());
    }
}
