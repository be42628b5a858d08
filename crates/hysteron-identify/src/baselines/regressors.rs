//! Regressors of a NARX model: past outputs, inputs, and the direction of the drive.

/// Regressors of y_k, with samples one lag interval apart.
///
/// ```text
/// x = (y₁, ∇y₁, …, ∇^(ny−1) y₁;  u₁, ∇u₁, …, ∇^(nu−1) u₁;  Δ, s)
/// ```
///
/// where y₁ = y_{k−1} and u₁ = u_{k−1}, ∇ is the backward difference (∇y₁ = y_{k−1} − y_{k−2}), Δ = u_k −
/// u_{k−1} and s = ±1 is the direction in which the drive last moved. The differences span the same space as
/// the lagged samples y_{k−1} … y_{k−ny} and u_k … u_{k−nu}, so that polynomials of one degree are the same;
/// unlike these they are not nearly collinear.
///
/// Without Δ and s no NARX model has a loop that stays open in the quasi-static limit: with them a polynomial
/// includes the discrete hysteresis equation y_k = y₁ + Δ (c₀ + c₁u₁ + s (c₂u₁ + c₃y₁)), rate-independent
/// hysteresis (S. A. M. Martins, L. A. Aguirre, Mech. Syst. Signal Process. 75 (2016) 607–617).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Lags {
    /// ny, at least 1.
    pub output: usize,
    /// nu, at least 1.
    pub input: usize,
}

/// Signals in units of the training records' ranges, one lag interval apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Drive, −1 … 1 over the training records.
    pub u: Vec<f64>,
    /// Output, −1 … 1 over the training records.
    pub y: Vec<f64>,
    /// Direction in which the drive last moved, ±1.
    pub direction: Vec<f64>,
    /// Samples that may be used for training or scoring.
    pub valid: Vec<bool>,
}

/// Map from the past of a series to the regressors of a model, each divided by its scale.
#[derive(Clone, Debug, PartialEq)]
pub struct Regressors {
    /// Their lags.
    pub lags: Lags,
    /// Largest magnitude of each over the training rows.
    scales: Vec<f64>,
}

impl Lags {
    /// Number of regressors.
    pub fn count(self) -> usize {
        self.output + self.input + 2
    }

    /// Samples before the first that can be predicted.
    pub fn past(self) -> usize {
        self.output.max(self.input).max(1)
    }
}

impl Regressors {
    /// Regressors of these lags, each scaled by its largest magnitude over the usable rows of `series`.
    pub(super) fn scaled(lags: Lags, series: &[Series]) -> Self {
        let mut regressors = Self { lags, scales: vec![1.0; lags.count()] };
        let mut largest = vec![0.0_f64; lags.count()];
        let mut x = vec![0.0; lags.count()];
        for one in series {
            for k in one.rows(lags) {
                regressors.fill(one, &one.y, k, &mut x);
                largest.iter_mut().zip(&x).for_each(|(l, x)| *l = l.max(x.abs()));
            }
        }
        // A zero regressor is not scaled.
        largest.iter_mut().filter(|l| **l == 0.0).for_each(|l| *l = 1.0);
        regressors.scales = largest;
        regressors
    }

    /// Regressors with scales of 1.
    #[cfg(test)]
    pub(super) fn unscaled(lags: Lags) -> Self {
        Self { lags, scales: vec![1.0; lags.count()] }
    }

    /// x of sample k ≥ past, with `y` instead of the measured output.
    pub(super) fn fill(&self, series: &Series, y: &[f64], k: usize, x: &mut [f64]) {
        let Lags { output, input } = self.lags;
        for (i, x) in x.iter_mut().take(output).enumerate() {
            *x = y[k - 1 - i];
        }
        for (i, x) in x[output..].iter_mut().take(input).enumerate() {
            *x = series.u[k - 1 - i];
        }
        differences(&mut x[..output]);
        differences(&mut x[output..output + input]);
        x[output + input] = series.u[k] - series.u[k - 1];
        x[output + input + 1] = series.direction[k];
        x.iter_mut().zip(&self.scales).for_each(|(x, scale)| *x /= scale);
    }

    /// Derivatives with respect to y_{k−1} … y_{k−ny} from those with respect to x, in the first ny places.
    pub(super) fn to_lagged_outputs(&self, by_x: &mut [f64]) {
        by_x.iter_mut().zip(&self.scales).for_each(|(d, scale)| *d /= scale);
        transposed_differences(&mut by_x[..self.lags.output]);
    }

    /// Names, e.g. `∇y` for y_{k−1} − y_{k−2}.
    pub fn names(&self) -> Vec<String> {
        let of = |signal: &str, order: usize| match order {
            0 => format!("{signal}₁"),
            1 => format!("∇{signal}₁"),
            order => format!("∇^{order} {signal}₁"),
        };
        let outputs = (0..self.lags.output).map(|order| of("y", order));
        let inputs = (0..self.lags.input).map(|order| of("u", order));
        outputs.chain(inputs).chain(["Δ".to_owned(), "s".to_owned()]).collect()
    }

    /// Index of s, whose powers above the first are redundant.
    pub(super) fn direction(&self) -> usize {
        self.lags.count() - 1
    }
}

impl Series {
    /// Valid samples with all lagged samples valid and within the record.
    pub fn rows(&self, lags: Lags) -> impl Iterator<Item = usize> + '_ {
        let past = lags.past();
        (past..self.y.len()).filter(move |&k| self.valid[k - past..=k].iter().all(|v| *v))
    }
}

/// Backward differences of ascending order of (g₁, g₂, …), the newest first, in place.
fn differences(g: &mut [f64]) {
    for order in 1..g.len() {
        for j in (order..g.len()).rev() {
            g[j] = g[j - 1] - g[j];
        }
    }
}

/// The transpose of [`differences`].
fn transposed_differences(g: &mut [f64]) {
    for order in (1..g.len()).rev() {
        for j in order..g.len() {
            g[j - 1] += g[j];
            g[j] = -g[j];
        }
    }
}

/// Direction in which the drive last moved, with a dead band: it reverses only after a return from the last
/// extremum by more than `band`. Before the first such move it is that of this move.
pub(super) fn directions(u: &[f64], band: f64) -> Vec<f64> {
    let Some(&first) = u.first() else { return Vec::new() };
    let mut extremum = first;
    let mut direction = 0.0;
    let mut still = 0;
    let mut directions = Vec::with_capacity(u.len());
    for &now in u {
        if direction == 0.0 {
            if (now - first).abs() > band {
                (direction, extremum) = ((now - first).signum(), now);
                still = directions.len();
            }
        } else if direction * (now - extremum) > 0.0 {
            extremum = now;
        } else if direction * (extremum - now) > band {
            (direction, extremum) = (-direction, now);
        }
        directions.push(direction);
    }
    let of_first = directions.get(still).copied().filter(|d| *d != 0.0).unwrap_or(1.0);
    directions.iter_mut().filter(|d| **d == 0.0).for_each(|d| *d = of_first);
    directions
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_and_their_transpose_by_hand() {
        let mut g = [7.0, 4.0, 2.0];
        differences(&mut g);
        // 7, 7 − 4, 7 − 2·4 + 2.
        assert_eq!(g, [7.0, 3.0, 1.0]);
        // ⟨Da, b⟩ = ⟨a, Dᵀb⟩.
        let (a, b) = ([0.3, -1.2, 2.5, 0.7], [1.1, 0.4, -0.6, 2.0]);
        let (mut da, mut db) = (a, b);
        differences(&mut da);
        transposed_differences(&mut db);
        let inner = |x: &[f64; 4], y: &[f64; 4]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
        assert!((inner(&da, &b) - inner(&a, &db)).abs() < 1e-14);
    }

    #[test]
    fn the_direction_ignores_noise_and_turns_with_the_drive() {
        let u = [0.0, 0.005, 0.5, 0.495, 0.52, 1.0, 0.98, 0.5, 0.5, 0.505, 0.7];
        assert_eq!(directions(&u, 0.01), [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0, -1.0, 1.0]);
        assert_eq!(directions(&[1.0, 1.0], 0.01), [1.0, 1.0]);
        assert_eq!(directions(&[1.0, 0.5], 0.01), [-1.0, -1.0]);
    }

    #[test]
    fn rows_reach_over_neither_starts_nor_masks() {
        let valid = [true, true, true, false, true, true, true, true];
        let series =
            Series { u: vec![0.0; 8], y: vec![0.0; 8], direction: vec![1.0; 8], valid: valid.to_vec() };
        let rows: Vec<usize> = series.rows(Lags { output: 2, input: 1 }).collect();
        assert_eq!(rows, [2, 6, 7]);
    }

    #[test]
    fn regressors_by_hand() {
        let series = Series {
            u: vec![1.0, 3.0, 4.0],
            y: vec![10.0, 12.0, 0.0],
            direction: vec![1.0; 3],
            valid: vec![true; 3],
        };
        let regressors = Regressors::unscaled(Lags { output: 2, input: 2 });
        let mut x = [0.0; 6];
        regressors.fill(&series, &series.y, 2, &mut x);
        assert_eq!(x, [12.0, 2.0, 3.0, 2.0, 1.0, 1.0]);
        assert_eq!(regressors.names(), ["y₁", "∇y₁", "u₁", "∇u₁", "Δ", "s"]);
    }
}
