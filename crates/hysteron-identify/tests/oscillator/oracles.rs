//! Slow, obvious simulations to check the library's with. None shares code with it but the arithmetic of one
//! Bouc–Wen step.

use hysteron_model::hysteresis::{InterSample, RecordEnds};
use hysteron_model::oscillator::Oscillator;
use hysteron_rt::Scalar;

/// The public benchmark's true parameters, in N, m and s.
pub const BENCHMARK: Oscillator =
    Oscillator { mass: 2.0, damping: 10.0, stiffness: 5e4, alpha: 5e4, beta: 800.0, gamma: -1100.0, n: 1.0 };

/// Random numbers that are the same everywhere (xorshift).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// From `low` to `high`, uniform in the logarithm.
    pub fn logarithmic(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }

    /// Normal with mean 0 and deviation 1 (Box and Muller).
    pub fn normal(&mut self) -> f64 {
        let size = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        size * (std::f64::consts::TAU * self.unit()).cos()
    }
}

/// A smooth force of 50 N rms that repeats after `samples` samples, with lines up to a fifth of the sample
/// rate.
pub fn multisine(samples: usize, seed: u64) -> Vec<f64> {
    let lines = samples / 5;
    let mut random = Random::new(seed);
    let phases: Vec<f64> = (0..lines).map(|_| std::f64::consts::TAU * random.unit()).collect();
    let amplitude = 50.0 * (2.0 / lines as f64).sqrt();
    let line = |k: usize, (l, phase): (usize, &f64)| {
        let turns = ((l + 1) * k % samples) as f64 / samples as f64;
        (std::f64::consts::TAU * turns + phase).cos()
    };
    (0..samples).map(|k| amplitude * phases.iter().enumerate().map(|p| line(k, p)).sum::<f64>()).collect()
}

pub fn rms(x: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = x.into_iter().fold((0.0, 0usize), |(s, n), x| (s + x * x, n + 1));
    (sum / count as f64).sqrt()
}

/// rms(a − b)/rms(b).
pub fn relative(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    rms(a.iter().zip(b).map(|(a, b)| a - b)) / rms(b.iter().copied())
}

/// Displacement from rest at every sample: tiny steps of Runge–Kutta for y and ẏ alone, z stepped exactly
/// along y.
pub fn tiny_steps(p: &Oscillator, u: &[f64], rate: f64, rule: InterSample, steps: usize) -> Vec<f64> {
    let operator = hysteron_rt::BoucWen::new(p.alpha, p.beta, p.gamma, p.n).unwrap();
    let force = rule.upsample(u, 2 * steps, RecordEnds::Open).unwrap();
    let h = 1.0 / (rate * steps as f64);
    let (mut y, mut v, mut z) = (0.0, 0.0, 0.0);
    let mut out = vec![0.0];
    for step in 0..(u.len() - 1) * steps {
        let [u0, u1, u2] = [0, 1, 2].map(|i| force[2 * step + i]);
        let z_at = |dy: f64| operator.advance(z, dy).unwrap();
        let acceleration =
            |dy: f64, v: f64, u: f64| (u - p.damping * v - p.stiffness * (y + dy) - z_at(dy)) / p.mass;
        let (v1, a1) = (v, acceleration(0.0, v, u0));
        let (v2, a2) = (v + 0.5 * h * a1, acceleration(0.5 * h * v1, v + 0.5 * h * a1, u1));
        let (v3, a3) = (v + 0.5 * h * a2, acceleration(0.5 * h * v2, v + 0.5 * h * a2, u1));
        let (v4, a4) = (v + h * a3, acceleration(h * v3, v + h * a3, u2));
        let dy = h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
        v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
        z = z_at(dy);
        y += dy;
        if (step + 1) % steps == 0 {
            out.push(y);
        }
    }
    out
}

/// The library's scheme written once for any kind of number: with duals, its derivatives by the chain rule.
/// Parameters in the order of `Oscillator::NAMES`, then y, ẏ, z at the first sample.
pub fn runge_kutta<S: Scalar<Real = f64>>(numbers: [S; 10], force: &[f64], steps: usize, h: f64) -> Vec<S> {
    let [m, c, k, alpha, beta, gamma, n, y, v, z] = numbers;
    // At a corner itself the derivative is the mean of both sides.
    let size = |x: S| x.scale(if x.value() == 0.0 { 0.0 } else { x.value().signum() });
    // |z|ⁿ and z |z|ⁿ⁻¹.
    let powers = |z: S| match z.value() {
        0.0 if n.value() == 1.0 => (size(z), z),
        0.0 => (z.scale(0.0), z.scale(0.0)),
        value => {
            let power = size(z).powf(n);
            (power, power.scale(value.signum()))
        }
    };
    let rate = |[y, v, z]: [S; 3], u: f64| {
        let (even, odd) = powers(z);
        [v, (S::constant(u) - c * v - k * y - z) / m, alpha * v - beta * size(v) * odd - gamma * v * even]
    };
    let moved = |x: [S; 3], a: f64, d: [S; 3]| [0, 1, 2].map(|i: usize| x[i] + d[i].scale(a));
    let mut x = [y, v, z];
    let mut out = vec![y];
    for step in 0..(force.len() - 1) / 2 {
        let u = |i: usize| force[2 * step + i];
        let k1 = rate(x, u(0));
        let k2 = rate(moved(x, 0.5 * h, k1), u(1));
        let k3 = rate(moved(x, 0.5 * h, k2), u(1));
        let k4 = rate(moved(x, h, k3), u(2));
        x = [0, 1, 2]
            .map(|i: usize| x[i] + (k1[i] + k2[i].scale(2.0) + k3[i].scale(2.0) + k4[i]).scale(h / 6.0));
        if (step + 1) % steps == 0 {
            out.push(x[0]);
        }
    }
    out
}
