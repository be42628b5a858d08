//! Geometry of the loop of output over input: opening, sense, and whether it is a butterfly.

use super::turning_points::{range_of, turning_points};

/// Sense of the loop with the input to the right and the output upwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoopSense {
    /// The descending branch lies above: with a positive gain the output lags, as in every piezo stack.
    CounterClockwise,
    /// The descending branch lies below: with a positive gain the output leads.
    Clockwise,
}

/// Shape of the loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopShape {
    /// Smallest and largest input.
    pub input_range: (f64, f64),
    /// Largest less smallest output, in its unit.
    pub stroke: f64,
    /// Output coming down less output going up, both at the middle of the input's range, in the output's
    /// unit.
    pub opening: f64,
    /// |`opening`| in % of `stroke`.
    pub opening_percent: f64,
    /// Sense of the loop; `None` where the opening is below 0.1 % of the stroke.
    pub sense: Option<LoopSense>,
    /// Slope of the straight line from the lowest to the highest input: sign of the gain.
    pub gain: f64,
    /// True if the output turns about twice as often as the input: two minima a period, as a ferroelectric
    /// driven through polarisation reversal has.
    pub butterfly: bool,
    /// The record holds one loop alone, which ends where it began and is assumed to repeat.
    pub taken_to_repeat: bool,
}

/// Shape of the loop of `y` over `u`. The opening is the mean over all passes through the middle of the
/// input's range between reversals at least 80 % of the range apart (over all passes, if there are none
/// such), read between samples on a straight line. `None` where the input or the output is constant, or the
/// input does not pass its middle both ways.
pub fn loop_shape(u: &[f64], y: &[f64]) -> Option<LoopShape> {
    let n = u.len().min(y.len());
    let (u, y) = (&u[..n], &y[..n]);
    let (low, high) = range_of(u);
    let (y_low, y_high) = range_of(y);
    let (span, stroke) = (high - low, y_high - y_low);
    if !(span > 0.0 && stroke > 0.0) {
        return None;
    }
    // A record of few strokes that ends where it began is taken twice over, so that no stroke is cut by its
    // ends.
    let gap = |x: &[f64], range: f64| (x[0] - x[n - 1]).abs() <= 0.05 * range;
    if gap(u, span) && gap(y, stroke) && turning_points(u, 0.2 * span).len() < 6 {
        let (twice_u, twice_y) = (u.repeat(2), y.repeat(2));
        let butterfly = is_butterfly(&u.repeat(3), &y.repeat(3), span, stroke);
        let shape = shape_of(&twice_u, &twice_y, (low, high), stroke, butterfly)?;
        return Some(LoopShape { taken_to_repeat: true, ..shape });
    }
    shape_of(u, y, (low, high), stroke, is_butterfly(u, y, span, stroke))
}

fn shape_of(
    u: &[f64],
    y: &[f64],
    (low, high): (f64, f64),
    stroke: f64,
    butterfly: bool,
) -> Option<LoopShape> {
    let n = u.len();
    let span = high - low;
    let middle = 0.5 * (low + high);
    let reversals = turning_points(u, 0.02 * span);
    let mut ends: Vec<usize> = vec![0];
    ends.extend(reversals.iter().map(|p| p.index));
    ends.push(n - 1);
    let passes: Vec<(bool, f64, bool)> = ends
        .windows(2)
        .filter_map(|w| {
            let (from, to) = (w[0], w[1]);
            let rises = u[to] > u[from];
            let k = (from..to).find(|&k| (u[k] <= middle) != (u[k + 1] <= middle))?;
            let t = (middle - u[k]) / (u[k + 1] - u[k]);
            Some((rises, y[k] + t * (y[k + 1] - y[k]), (u[to] - u[from]).abs() >= 0.8 * span))
        })
        .collect();
    let mean = |rises: bool, large_only: bool| {
        let (sum, count) = passes
            .iter()
            .filter(|p| p.0 == rises && (p.2 || !large_only))
            .fold((0.0, 0), |(sum, count), p| (sum + p.1, count + 1));
        (count > 0).then(|| sum / f64::from(count))
    };
    let (up, down) = match (mean(true, true), mean(false, true)) {
        (Some(up), Some(down)) => (up, down),
        _ => (mean(true, false)?, mean(false, false)?),
    };
    let opening = down - up;
    let opening_percent = 100.0 * opening.abs() / stroke;
    let at = |wanted: f64| {
        let (sum, count) = u
            .iter()
            .zip(y)
            .filter(|(u, _)| (**u - wanted).abs() <= 0.02 * span)
            .fold((0.0, 0.0), |(s, c), (_, y)| (s + y, c + 1.0));
        sum / f64::max(count, 1.0)
    };
    Some(LoopShape {
        input_range: (low, high),
        stroke,
        opening,
        opening_percent,
        sense: (opening_percent >= 0.1).then_some(if opening > 0.0 {
            LoopSense::CounterClockwise
        } else {
            LoopSense::Clockwise
        }),
        gain: (at(high) - at(low)) / span,
        butterfly,
        taken_to_repeat: false,
    })
}

/// True if the output turns at least 1.6 times as often as the input, counting moves above 20 % of the
/// input's range and 10 % of the stroke (one wing of a butterfly that does not quite switch is that small).
fn is_butterfly(u: &[f64], y: &[f64], span: f64, stroke: f64) -> bool {
    let input = turning_points(u, 0.2 * span).len() as f64;
    let output = turning_points(y, 0.1 * stroke).len() as f64;
    input >= 1.0 && output >= 3.0 && output >= 1.6 * input
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn ellipse(lag: f64, gain: f64) -> (Vec<f64>, Vec<f64>) {
        (0..2000)
            .map(|k| TAU * f64::from(k) / 400.0)
            .map(|t| (5.0 + 3.0 * t.sin(), gain * (t - lag).sin()))
            .unzip()
    }

    #[test]
    fn a_lagging_sine_opens_by_twice_the_sine_of_its_lag_over_two() {
        // At mid-range y = ∓A sin(lag): opening 2A sin(lag), stroke 2A.
        for (lag, gain, sense) in [
            (0.25, 10.0, LoopSense::CounterClockwise),
            (-0.25, 10.0, LoopSense::Clockwise),
            (0.25, -10.0, LoopSense::Clockwise),
        ] {
            let (u, y) = ellipse(lag, gain);
            let shape = loop_shape(&u, &y).unwrap();
            assert!((shape.opening_percent - 100.0 * f64::sin(0.25)).abs() < 0.01, "{shape:?}");
            assert_eq!(shape.sense, Some(sense));
            assert_eq!(shape.gain > 0.0, gain > 0.0);
            assert!(!shape.butterfly);
        }
    }

    #[test]
    fn a_line_has_no_sense_and_a_constant_no_shape() {
        let (u, y) = ellipse(0.0, 10.0);
        assert_eq!(loop_shape(&u, &y).unwrap().sense, None);
        assert_eq!(loop_shape(&u, &vec![1.0; u.len()]), None);
        assert_eq!(loop_shape(&[0.0, 1.0], &[0.0, 1.0]), None);
    }

    #[test]
    fn two_minima_a_period_are_a_butterfly() {
        let (u, y): (Vec<f64>, Vec<f64>) = (0..401)
            .map(|k| TAU * f64::from(k) / 401.0)
            .map(|t| (1300.0 * t.sin(), -(2.0 * t - 0.8).cos()))
            .unzip();
        assert!(loop_shape(&u, &y).unwrap().butterfly);
    }

    #[test]
    fn minor_loops_do_not_narrow_the_opening() {
        // A play operator of half-width 1 driven by shrinking sines: the full loop opens by 2.
        let mut play = 0.0;
        let (u, y): (Vec<f64>, Vec<f64>) = (0..4000)
            .map(|k| {
                let amplitude = if k < 2000 { 10.0 } else { 3.0 };
                let u = amplitude * (TAU * f64::from(k) / 400.0).sin();
                play = f64::max(u - 1.0, f64::min(u + 1.0, play));
                (u, play)
            })
            .unzip();
        let shape = loop_shape(&u, &y).unwrap();
        assert!((shape.opening - 2.0).abs() < 1e-9, "{}", shape.opening);
    }
}
