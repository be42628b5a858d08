//! The rig's own Bouc–Wen integrator (article Eq. 1), written independently of the one under test.

/// State of dz/du = α − β sign(du) z|z|^(n−1) − γ|z|^n with v = Σ polynomial\[i\] u^(i+1) − z.
pub(super) struct BoucWenState<'a> {
    pub polynomial: &'a [f64],
    pub alpha: f64,
    pub beta: f64,
    pub gamma: f64,
    pub n: f64,
    drive_v: f64,
    z: f64,
}

/// Runge–Kutta steps are so short that stiffness × step stays below this.
const RELATIVE_STEP: f64 = 1e-3;
/// Most Runge–Kutta steps in one call; beyond it the state is declared diverged.
const MAX_STEPS: f64 = 1e6;

impl<'a> BoucWenState<'a> {
    /// z = 0 at 0 V.
    pub fn new(polynomial: &'a [f64], alpha: f64, beta: f64, gamma: f64, n: f64) -> Self {
        BoucWenState { polynomial, alpha, beta, gamma, n, drive_v: 0.0, z: 0.0 }
    }

    /// Hysteresis output \[µm\] after the drive went monotonically to `drive_v`; not finite once the state
    /// has diverged.
    pub fn step(&mut self, drive_v: f64) -> f64 {
        let du = drive_v - self.drive_v;
        if du != 0.0 {
            self.z = if self.n == 1.0 { self.linear_branches(du) } else { self.runge_kutta(du) };
            self.drive_v = drive_v;
        }
        let l = self.polynomial.iter().rev().fold(0.0, |sum, c| (sum + c) * drive_v);
        l - self.z
    }

    /// n = 1: dz/du = α − c z with c = β sign(du) + γ sign(z), constant on either side of z = 0.
    fn linear_branches(&self, du: f64) -> f64 {
        let direction = du.signum();
        // Along the path: dz/dp = d·α − d·c·z, p = |du| ≥ 0.
        let drift = direction * self.alpha;
        let mut z = self.z;
        let mut left = du.abs();
        // At most one crossing of zero: the sign of dz/dp at z = 0 is that of the drift.
        for _ in 0..2 {
            let side = if z == 0.0 { drift.signum() } else { z.signum() };
            let rate = self.beta + direction * self.gamma * side;
            if z != 0.0 && z * drift < 0.0 {
                // z + (drift − rate z)·g(p) = 0, g = (1 − e^(−rate p))/rate.
                let slope = drift - rate * z;
                let g = -z / slope;
                let to_zero = if rate == 0.0 { g } else { -(-rate * g).ln_1p() / rate };
                if slope * z < 0.0 && to_zero.is_finite() && to_zero < left {
                    left -= to_zero;
                    z = 0.0;
                    continue;
                }
            }
            let g = if rate == 0.0 { left } else { -(-rate * left).exp_m1() / rate };
            return z + (drift - rate * z) * g;
        }
        z
    }

    fn slope(&self, z: f64, direction: f64) -> f64 {
        let power = z.abs().powf(self.n - 1.0);
        self.alpha - (self.beta * direction * z + self.gamma * z.abs()) * power
    }

    fn runge_kutta(&self, du: f64) -> f64 {
        let direction = du.signum();
        // Longest step: d(dz/du)/dz ≈ n(|β| + |γ|)|z|^(n−1), at the largest |z| reachable in this call.
        let reach = self.z.abs() + self.alpha.abs() * du.abs();
        let stiffness = self.n * (self.beta.abs() + self.gamma.abs()) * reach.powf(self.n - 1.0);
        let steps = (stiffness * du.abs() / RELATIVE_STEP).ceil().max(1.0);
        if !steps.is_finite() || steps > MAX_STEPS {
            return f64::NAN;
        }
        let h = du / steps;
        let mut z = self.z;
        for _ in 0..steps as usize {
            let k1 = self.slope(z, direction);
            let k2 = self.slope(z + 0.5 * h * k1, direction);
            let k3 = self.slope(z + 0.5 * h * k2, direction);
            let k4 = self.slope(z + h * k3, direction);
            z += h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
        }
        z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table 2 of the article as printed, third period of a 0–10 V loop from rest: clockwise, at 5 V 11.59 µm
    /// going up and 8.61 going down (converging to 11.56 and 8.60 in later periods).
    #[test]
    fn table_2_gives_a_clockwise_loop() {
        let polynomial = [2.0, 0.0031];
        let mut bw = BoucWenState::new(&polynomial, -1.2039, 0.1111, 0.0024, 1.0);
        let mut up = 0.0;
        for target in [10.0, 0.0, 10.0, 0.0] {
            bw.step(target);
        }
        for k in 1..=100 {
            let v = bw.step(f64::from(k) * 0.1);
            if k == 50 {
                up = v;
            }
        }
        let mut down = 0.0;
        for k in (0..100).rev() {
            let v = bw.step(f64::from(k) * 0.1);
            if k == 50 {
                down = v;
            }
        }
        assert!((up - 11.59).abs() < 5e-3 && (down - 8.61).abs() < 5e-3, "up {up} down {down}");
    }

    #[test]
    fn closed_form_for_n_1_agrees_with_fine_runge_kutta() {
        for (alpha, beta, gamma) in
            [(-1.2039, 0.1111, 0.0024), (0.7, 0.2, -0.35), (0.5, 0.1, 0.1), (0.5, 0.0, 0.0)]
        {
            let mut exact = BoucWenState::new(&[], alpha, beta, gamma, 1.0);
            let mut z = 0.0;
            for target in [3.0, -2.0, 5.0, 0.5, 1.0, -4.0] {
                let du: f64 = target - exact.drive_v;
                let steps = 200_000;
                let h = du / f64::from(steps);
                for _ in 0..steps {
                    let k1 = exact.slope(z, du.signum());
                    let k2 = exact.slope(z + 0.5 * h * k1, du.signum());
                    z += h * k2;
                }
                let v = exact.step(target);
                assert!((v + z).abs() < 1e-9, "{alpha} {beta} {gamma} at {target}: {} and {z}", -v);
            }
        }
    }

    /// n = 2 from z = 0 with rising drive: z = √(α/(β+γ)) tanh(√(α(β+γ)) u).
    #[test]
    fn n_2_follows_the_hyperbolic_tangent() {
        let (alpha, beta, gamma): (f64, f64, f64) = (0.8, 0.3, 0.1);
        let mut bw = BoucWenState::new(&[], alpha, beta, gamma, 2.0);
        let (scale, rate) = ((alpha / (beta + gamma)).sqrt(), (alpha * (beta + gamma)).sqrt());
        for u in [0.1, 1.0, 5.0] {
            let v = bw.step(u);
            let error = v + scale * (rate * u).tanh();
            assert!(error.abs() < 1e-11, "at {u}: {error:e}");
        }
    }

    #[test]
    fn an_inadmissible_n_2_ends_in_a_value_that_is_not_finite() {
        let mut bw = BoucWenState::new(&[], 1.0, -0.5, -0.5, 2.0);
        let v = (1..=200).map(|k| bw.step(f64::from(k) * 0.1)).last().unwrap();
        assert!(!v.is_finite());
    }
}
