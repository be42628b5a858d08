//! Profile likelihood of one parameter of a least-squares fit, for confidence intervals of nonlinear fits.
//!
//! With S(v) the least sum of squares with the parameter at the value v, and S₀ its minimum, the signed root
//! of the deviance z(v) = ±√((S(v) − S₀)/(s² ρ)) is (v − v̂)/se where the model is linear, and much closer to
//! standard normal than that where it is not (Bates, Watts 1988, doi:10.1002/9780470316757, ch. 6). ρ, the
//! ratio of the variance of the estimate to that for white residuals, corrects for coloured ones (the
//! adjustment of Chandler, Bate 2007, doi:10.1093/biomet/asm015, for one parameter).

use super::super::projection::Projection;
use hysteron_numeric::{dot, triangular};

/// Tolerance of z.
const Z_TOLERANCE: f64 = 0.01;
/// Most linearisations for one point of the profile.
const MOST_TO_SETTLE: usize = 15;
/// Most dampings tried for one step, the least damping, and its factor after an accepted step.
const MOST_ATTEMPTS: usize = 10;
const LEAST_DAMPING: f64 = 1e-4;
const EASIER: f64 = 0.2;
/// Longest and shortest step of the value, in standard errors.
const FARTHEST: f64 = 1.5;
const NEAREST: f64 = 1e-3;

/// A least-squares fit in all of its parameters, including linear ones.
pub(in super::super) trait Fit {
    /// Residuals, measured minus model, and the model's derivatives one column a parameter; `None` where it
    /// cannot be simulated.
    fn linearise(&mut self, p: &[f64]) -> Option<(Vec<f64>, Vec<f64>)>;
    /// Sum of squares of the residuals.
    fn square(&mut self, p: &[f64]) -> Option<f64>;
    /// Range of a parameter.
    fn range(&self, parameter: usize) -> (f64, f64);
}

/// The optimum from which profiles start.
#[derive(Clone, Debug)]
pub(in super::super) struct Optimum<'a> {
    pub(in super::super) at: &'a [f64],
    /// Least sum of squares.
    pub(in super::super) square: f64,
    /// Indices of the free parameters.
    pub(in super::super) free: &'a [usize],
}

/// The parameter whose interval is wanted.
#[derive(Clone, Debug)]
pub(in super::super) struct Profiled<'a> {
    pub(in super::super) parameter: usize,
    /// Its standard error.
    pub(in super::super) std_error: f64,
    /// s² ρ: sum of squares per unit of deviance.
    pub(in super::super) unit: f64,
    /// Derivative of all parameters with respect to this one along the valley of the sum of squares, 1 for
    /// itself.
    pub(in super::super) direction: &'a [f64],
}

impl Profiled<'_> {
    /// z at `steps` standard errors along the tangent of the valley, which shows the departure from the
    /// quadratic to third order; 0 where it is undefined.
    pub(in super::super) fn along_valley(
        &self,
        fit: &mut impl Fit,
        optimum: &Optimum<'_>,
        steps: f64,
    ) -> f64 {
        let at: Vec<f64> =
            optimum.at.iter().zip(self.direction).map(|(p, d)| p + steps * self.std_error * d).collect();
        let outside = optimum.free.iter().any(|&j| {
            let (low, high) = fit.range(j);
            !(low..=high).contains(&at[j])
        });
        if outside {
            return 0.0;
        }
        fit.square(&at).map_or(0.0, |square| steps.signum() * self.root(square, optimum))
    }

    fn root(&self, square: f64, optimum: &Optimum<'_>) -> f64 {
        ((square - optimum.square).max(0.0) / self.unit).sqrt()
    }

    /// The value on this side (±1) at which z = ± `wanted`, or the end of the parameter's range; `None` where
    /// it is not found within `steps` linearisations. The valley is followed outwards, in shorter steps where
    /// it bends.
    pub(in super::super) fn end(
        &self,
        fit: &mut impl Fit,
        optimum: &Optimum<'_>,
        (side, wanted): (f64, f64),
        steps: usize,
    ) -> Option<f64> {
        let (low, high) = fit.range(self.parameter);
        let bound = if side > 0.0 { high } else { low };
        let mut from =
            Point { at: optimum.at.to_vec(), z: 0.0, rate: 0.0, direction: self.direction.to_vec() };
        let (farthest, nearest) = (FARTHEST * self.std_error, NEAREST * self.std_error);
        let mut length = wanted * self.std_error;
        let mut left = steps;
        while left > 0 && length > nearest {
            let value = from.at[self.parameter];
            let next = (value + side * length).clamp(low, high);
            let Some(to) =
                self.settled(fit, optimum, from.moved(self.parameter, next, fit), wanted, &mut left)
            else {
                length *= 0.5;
                continue;
            };
            if (to.z - wanted).abs() <= Z_TOLERANCE {
                return Some(next);
            }
            if to.z > wanted {
                let share = (wanted - from.z) / (to.z - from.z);
                length = (next - value).abs() * share.clamp(0.05, 0.95);
                continue;
            }
            if next == bound {
                return Some(bound);
            }
            // A valley that descends again is followed until it rises.
            let asked = (wanted - to.z) / (side * to.rate);
            length = if asked > 0.0 { asked.clamp(2.0 * nearest, farthest) } else { farthest };
            from = to;
        }
        None
    }

    /// Optimises the other parameters by damped Gauss–Newton steps (Levenberg–Marquardt) from `at`; `None`
    /// where this does not converge.
    fn settled(
        &self,
        fit: &mut impl Fit,
        optimum: &Optimum<'_>,
        mut at: Vec<f64>,
        wanted: f64,
        left: &mut usize,
    ) -> Option<Point> {
        let mut damping = 0.0;
        for _ in 0..MOST_TO_SETTLE {
            *left = left.checked_sub(1)?;
            let (residuals, columns) = in_their_span(fit.linearise(&at)?);
            let solve = |fit: &_, damping| {
                Rest::solve(fit, self.parameter, optimum.free, (&at, damping), &residuals, &columns)
            };
            let rest = solve(fit, 0.0);
            // Converged when the remaining expected gain is negligible in z.
            if rest.gain <= 2.0 * Z_TOLERANCE * wanted * self.unit {
                let z = self.root(rest.square, optimum);
                let mut direction = vec![0.0; at.len()];
                direction[self.parameter] = 1.0;
                for (&j, (tangent, change)) in rest.free.iter().zip(rest.tangent.iter().zip(&rest.change)) {
                    let (low, high) = fit.range(j);
                    direction[j] = *tangent;
                    at[j] = (at[j] + change).clamp(low, high);
                }
                // dz/dv from dS/dv = −2 Jᵀr, at the optimum of the others.
                return Some(Point { at, z, rate: -rest.gradient / (z * self.unit), direction });
            }
            let mut better = None;
            for attempt in 0..MOST_ATTEMPTS {
                let to = if damping > 0.0 {
                    solve(fit, damping).stepped(fit, &at)
                } else {
                    rest.stepped(fit, &at)
                };
                if fit.square(&to).is_some_and(|square| square < rest.before) {
                    better = Some(to);
                    damping *= if attempt == 0 { EASIER } else { 1.0 };
                    break;
                }
                damping = (damping / EASIER).max(LEAST_DAMPING);
            }
            at = better?;
            if damping < LEAST_DAMPING {
                damping = 0.0;
            }
        }
        None
    }
}

/// A point of the valley: the parameter at a value, the others at their optimum.
struct Point {
    at: Vec<f64>,
    z: f64,
    /// dz/dv.
    rate: f64,
    /// Derivative of all parameters with respect to the profiled one.
    direction: Vec<f64>,
}

impl Point {
    /// Moves along the tangent of the valley to the parameter `value`, clamped to all ranges.
    fn moved(&self, parameter: usize, value: f64, fit: &impl Fit) -> Vec<f64> {
        let by = value - self.at[parameter];
        let to = |(j, (p, d)): (usize, (&f64, &f64))| {
            let (low, high) = fit.range(j);
            // A held parameter may lie outside its range.
            if *d == 0.0 { *p } else { (p + by * d).clamp(low, high) }
        };
        let mut at: Vec<f64> = self.at.iter().zip(&self.direction).enumerate().map(to).collect();
        at[parameter] = value;
        at
    }
}

/// Residuals and columns in an orthonormal basis of their span: as many rows as there are columns, and the
/// same inner products.
fn in_their_span((residuals, columns): (Vec<f64>, Vec<f64>)) -> (Vec<f64>, Vec<f64>) {
    let mut all: Vec<&[f64]> = columns.chunks_exact(residuals.len().max(1)).collect();
    all.push(&residuals);
    let r = triangular(&all);
    let (columns, residuals) = r.as_slice().split_at((all.len() - 1) * all.len());
    (residuals.to_vec(), columns.to_vec())
}

/// Linear least squares over all parameters but the profiled one.
struct Rest {
    free: Vec<usize>,
    /// Step of each free parameter to the optimum.
    change: Vec<f64>,
    /// Derivative of each of them with respect to the profiled one.
    tangent: Vec<f64>,
    /// Sum of squares before the step, and its expected reduction.
    before: f64,
    gain: f64,
    /// Sum of squares after the step, as expected.
    square: f64,
    /// Jᵀr of the profiled parameter after the step.
    gradient: f64,
}

impl Rest {
    fn solve(
        fit: &impl Fit,
        parameter: usize,
        free: &[usize],
        (at, damping): (&[f64], f64),
        residuals: &[f64],
        columns: &[f64],
    ) -> Self {
        let rows = residuals.len();
        let column = |j: usize| &columns[j * rows..(j + 1) * rows];
        let before = dot(residuals, residuals);
        // Parameters held by a bound stay fixed.
        let free: Vec<usize> = free
            .iter()
            .copied()
            .filter(|&j| {
                let (low, high) = fit.range(j);
                let uphill = dot(column(j), residuals);
                j != parameter && !(at[j] <= low && uphill < 0.0 || at[j] >= high && uphill > 0.0)
            })
            .collect();
        // Damping adds one row per free parameter, in units of its column.
        let with_rows = |x: &[f64]| x.iter().copied().chain(free.iter().map(|_| 0.0)).collect::<Vec<f64>>();
        let mut basis = Projection::new(rows + free.len(), free.len());
        for (row, &j) in free.iter().enumerate() {
            basis.push(|q| {
                q[..rows].copy_from_slice(column(j));
                q[rows..].fill(0.0);
                q[rows + row] = damping * dot(column(j), column(j)).sqrt();
            });
        }
        let (mut residuals, own) = (with_rows(residuals), with_rows(column(parameter)));
        let change = basis.coefficients(&residuals);
        let tangent = basis.coefficients(&own).into_iter().map(|t| -t).collect();
        basis.project(&mut residuals);
        let square = dot(&residuals, &residuals);
        let gradient = dot(&own, &residuals);
        Self { free, change, tangent, before, gain: before - square, square, gradient }
    }

    /// The point after the step, within all ranges.
    fn stepped(&self, fit: &impl Fit, at: &[f64]) -> Vec<f64> {
        let mut to = at.to_vec();
        for (&j, change) in self.free.iter().zip(&self.change) {
            let (low, high) = fit.range(j);
            to[j] = (at[j] + change).clamp(low, high);
        }
        to
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEPS: usize = 60;

    /// y = θ₁ (1 − exp(−θ₂ t)): the classical example of a strongly curved fit.
    struct Saturation {
        t: Vec<f64>,
        y: Vec<f64>,
    }

    impl Fit for Saturation {
        fn linearise(&mut self, p: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
            let e: Vec<f64> = self.t.iter().map(|t| (-p[1] * t).exp()).collect();
            let r = self.y.iter().zip(&e).map(|(y, e)| y - p[0] * (1.0 - e)).collect();
            let first = e.iter().map(|e| 1.0 - e);
            let second = e.iter().zip(&self.t).map(|(e, t)| p[0] * t * e);
            Some((r, first.chain(second).collect()))
        }
        fn square(&mut self, p: &[f64]) -> Option<f64> {
            self.linearise(p).map(|(r, _)| dot(&r, &r))
        }
        fn range(&self, _: usize) -> (f64, f64) {
            (0.0, 1e4)
        }
    }

    /// BOD data of Marske (1967), as in Bates and Watts, table A1.4.
    fn bod() -> Saturation {
        Saturation { t: vec![1.0, 2.0, 3.0, 4.0, 5.0, 7.0], y: vec![8.3, 10.3, 19.0, 16.0, 15.6, 19.8] }
    }

    /// Least sum of squares at θ₂ = `rate`: θ₁ is linear.
    fn square_at_rate(fit: &Saturation, rate: f64) -> f64 {
        let shape: Vec<f64> = fit.t.iter().map(|t| 1.0 - (-rate * t).exp()).collect();
        let size = dot(&shape, &fit.y) / dot(&shape, &shape);
        fit.y.iter().zip(&shape).map(|(y, s)| (y - size * s).powi(2)).sum()
    }

    fn bisect(mut low: f64, mut high: f64, f: impl Fn(f64) -> bool) -> f64 {
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if f(middle) { high = middle } else { low = middle }
        }
        0.5 * (low + high)
    }

    #[test]
    fn finds_both_ends_of_a_strongly_curved_profile() {
        let mut fit = bod();
        // Published estimates: 19.143, 0.5311, s² = 25.99/4.
        let at = [19.1426, 0.5311];
        let square = fit.square(&at).unwrap();
        assert!((square - 25.99).abs() < 0.005, "{square}");
        let s2 = square / 4.0;
        let (_, columns) = fit.linearise(&at).unwrap();
        let (a, b) = columns.split_at(6);
        let (aa, ab, bb) = (dot(a, a), dot(a, b), dot(b, b));
        let std_error = (s2 / (bb - ab * ab / aa)).sqrt();
        assert!((std_error - 0.2031).abs() < 1e-3, "{std_error}");
        let direction = [-ab / aa, 1.0];
        let optimum = Optimum { at: &at, square, free: &[0, 1] };
        let profiled = Profiled { parameter: 1, std_error, unit: s2, direction: &direction };
        let wanted = 1.7;
        let deviance = |rate: f64| ((square_at_rate(&fit, rate) - square) / s2).max(0.0).sqrt();
        let high = bisect(0.5311, 5.0, |rate| deviance(rate) > wanted);
        let low = bisect(0.0, 0.5311, |rate| deviance(rate) < wanted);
        assert!(high - 0.5311 > 1.3 * (0.5311 - low), "{low} {high}: the example must be curved");
        let slope = |rate: f64| (deviance(rate + 1e-4) - deviance(rate - 1e-4)).abs() / 2e-4;
        for (side, oracle) in [(-1.0, low), (1.0, high)] {
            let tolerance = 1.5 * Z_TOLERANCE / slope(oracle);
            let found = profiled.end(&mut bod(), &optimum, (side, wanted), STEPS).unwrap();
            assert!((found - oracle).abs() <= tolerance, "{found} {oracle} {tolerance}");
        }
        // The tangent of the valley shows the profile's asymmetry: z(h) + z(−h) is of second order in h.
        let h = 0.2;
        let z = |side: f64| side * deviance(0.5311 + side * h * std_error);
        let of_profile = z(1.0) + z(-1.0);
        let mut fit = bod();
        let mut valley = |steps| profiled.along_valley(&mut fit, &optimum, steps);
        let of_valley = valley(h) + valley(-h);
        assert!(of_profile < -0.005, "{of_profile}");
        assert!((of_valley / of_profile - 1.0).abs() < 0.1, "{of_valley} {of_profile}");
    }

    #[test]
    fn stops_at_the_end_of_the_range() {
        struct Narrow(Saturation);
        impl Fit for Narrow {
            fn linearise(&mut self, p: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
                self.0.linearise(p)
            }
            fn square(&mut self, p: &[f64]) -> Option<f64> {
                self.0.square(p)
            }
            fn range(&self, j: usize) -> (f64, f64) {
                if j == 1 { (0.5, 0.6) } else { (0.0, 1e4) }
            }
        }
        let mut fit = Narrow(bod());
        let at = [19.1426, 0.5311];
        let square = fit.square(&at).unwrap();
        let optimum = Optimum { at: &at, square, free: &[0, 1] };
        let profiled = Profiled { parameter: 1, std_error: 0.2, unit: square / 4.0, direction: &[-9.0, 1.0] };
        assert_eq!(profiled.end(&mut fit, &optimum, (1.0, 1.96), STEPS), Some(0.6));
        assert_eq!(profiled.end(&mut fit, &optimum, (-1.0, 1.96), STEPS), Some(0.5));
    }
}
