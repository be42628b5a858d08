//! State-variable filter: sʲ/A(s) of a sampled signal, exact for zero-order hold or linear interpolation.

use nalgebra::DMatrix;

use hysteron_model::record::InterSample;

/// ż = A z + B u in the controllable canonical form of 1/A(s), over one sample period: the states are sʲ/A(s)
/// u, j = 0 … n − 1.
pub(super) struct VariableFilter {
    /// a₁ … a_n of sⁿ + a₁ sⁿ⁻¹ + … + a_n.
    a: Vec<f64>,
    transition: DMatrix<f64>,
    /// Input columns for u at the start of the period and for its rise over it.
    level: Vec<f64>,
    rise: Vec<f64>,
}

impl VariableFilter {
    /// `step`: sample period in the unit of time of A. Held signals step at their samples, others are
    /// interpolated linearly.
    pub(super) fn new(a: &[f64], step: f64, between: InterSample) -> Self {
        let n = a.len();
        // d/dt (z, u, u̇ h) with u̇ constant over the period.
        let rates = DMatrix::from_fn(n + 2, n + 2, |i, j| {
            let rate = match (i, j) {
                (i, j) if i + 1 < n && j == i + 1 => 1.0,
                (i, j) if i + 1 == n && j < n => -a[n - 1 - j],
                (i, j) if i + 1 == n && j == n => 1.0,
                (i, j) if i == n && j == n + 1 => 1.0 / step,
                _ => 0.0,
            };
            rate * step
        });
        let over = rates.exp();
        let held = between == InterSample::Hold;
        let rise = |i: usize| if held { 0.0 } else { over[(i, n + 1)] };
        Self {
            a: a.to_vec(),
            transition: over.view((0, 0), (n, n)).into_owned(),
            level: (0..n).map(|i| over[(i, n)]).collect(),
            rise: (0..n).map(rise).collect(),
        }
    }

    /// sʲ/A(s) u for j = 0 … n, one column each, from zero. A signal that is not held ramps to its first
    /// sample within the preceding period.
    pub(super) fn apply(&self, u: &[f64]) -> Vec<Vec<f64>> {
        let n = self.a.len();
        let mut out = vec![vec![0.0; u.len()]; n + 1];
        let (mut z, mut next) = (vec![0.0; n], vec![0.0; n]);
        let mut before = 0.0;
        for (k, &now) in u.iter().enumerate() {
            for (i, next) in next.iter_mut().enumerate() {
                let free: f64 = z.iter().enumerate().map(|(j, z)| self.transition[(i, j)] * z).sum();
                *next = free + self.level[i] * before + self.rise[i] * (now - before);
            }
            std::mem::swap(&mut z, &mut next);
            let mut highest = now;
            for (j, z) in z.iter().enumerate() {
                out[j][k] = *z;
                highest -= self.a[n - 1 - j] * z;
            }
            out[n][k] = highest;
            before = now;
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1/(s + 2) of a held step is (1 − e^(−2t))/2, of a ramp (t − (1 − e^(−2t))/2)/2; likewise by a filter
    /// of second order, (s + 5)/((s + 5)(s + 2)).
    #[test]
    fn steps_and_ramps_have_closed_forms() {
        let h = 0.13;
        let step = vec![1.0; 12];
        let ramp: Vec<f64> = (0..12).map(|k| h * f64::from(k)).collect();
        let one = |u: &[f64], between| VariableFilter::new(&[2.0], h, between).apply(u);
        let two = |u: &[f64], between| {
            let z = VariableFilter::new(&[7.0, 10.0], h, between).apply(u);
            (0..u.len()).map(|k| 5.0 * z[0][k] + z[1][k]).collect::<Vec<_>>()
        };
        for k in 0..12 {
            let t = h * k as f64;
            let of_step = -0.5 * (-2.0 * t).exp_m1();
            let of_ramp = 0.5 * (t - of_step);
            for (found, expected) in [
                (one(&step, InterSample::Hold)[0][k], of_step),
                (two(&step, InterSample::Hold)[k], of_step),
                (one(&ramp, InterSample::Linear)[0][k], of_ramp),
                (two(&ramp, InterSample::Linear)[k], of_ramp),
                // s/(s + 2) of the step.
                (one(&step, InterSample::Hold)[1][k], 1.0 - 2.0 * of_step),
            ] {
                assert!((found - expected).abs() < 1e-14, "{k}: {found} {expected}");
            }
        }
    }
}
