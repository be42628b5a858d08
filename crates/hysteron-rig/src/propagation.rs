//! Exact propagation of poles under an input that is linear between grid points (first-order hold).
//!
//! x' = λx + v with v(t) = v₀ + (v₁ − v₀)t/h gives x(θh) = e^z x₀ + θh[(φ₁ − θφ₂) v₀ + θφ₂ v₁], z = λθh,
//! φ₁ = (e^z − 1)/z, φ₂ = (e^z − 1 − z)/z².

use rustfft::num_complex::Complex64;

use super::partial_fractions::PartialFractions;

/// φ₁ and φ₂ without cancellation for small |z|.
fn phi(z: Complex64) -> (Complex64, Complex64) {
    if z.norm() > 1.0 {
        let p1 = (z.exp() - 1.0) / z;
        return (p1, (p1 - 1.0) / z);
    }
    // Taylor: φ₂ = Σ z^k/(k+2)!, φ₁ = 1 + z φ₂.
    let mut term = Complex64::new(0.5, 0.0);
    let mut p2 = term;
    for k in 1..22 {
        term *= z / (k + 2) as f64;
        p2 += term;
    }
    (p2 * z + 1.0, p2)
}

/// x(θh) = decay·x₀ + from_start·v₀ + from_end·v₁ for one pole.
#[derive(Clone, Copy, Debug)]
struct Hold<T> {
    decay: T,
    from_start: T,
    from_end: T,
}

impl Hold<Complex64> {
    fn new(pole: Complex64, step_s: f64, fraction: f64) -> Self {
        let dt = step_s * fraction;
        let z = pole * dt;
        let (p1, p2) = phi(z);
        Hold { decay: z.exp(), from_start: (p1 - p2 * fraction) * dt, from_end: p2 * (fraction * dt) }
    }

    fn re(self) -> Hold<f64> {
        Hold { decay: self.decay.re, from_start: self.from_start.re, from_end: self.from_end.re }
    }
}

/// The states of a linear plant on a uniform grid, with its output at grid points and at one fixed place
/// between them.
pub(super) struct Propagator {
    feedthrough: f64,
    fraction: f64,
    real: RealStates,
    pairs: Vec<PairState>,
}

/// Real poles as parallel arrays, so that the step runs over plain slices.
#[derive(Default)]
struct RealStates {
    state: Vec<f64>,
    decay: Vec<f64>,
    from_start: Vec<f64>,
    from_end: Vec<f64>,
    /// Output weights: of the state now, and of (state, v₀, v₁) for the output at the fraction.
    weight: Vec<f64>,
    weight_between: Vec<f64>,
    start_between: f64,
    end_between: f64,
}

struct PairState {
    state: Complex64,
    residue: Complex64,
    step: Hold<Complex64>,
    between: Hold<Complex64>,
}

impl Propagator {
    /// A plant at rest under the constant input `v_um`, stepping by `step_s`; `fraction` ∈ [0, 1) is the
    /// place in a step where [`Propagator::output`] evaluates.
    pub fn at_rest(plant: &PartialFractions, step_s: f64, fraction: f64, v_um: f64) -> Self {
        let mut real = RealStates::default();
        for p in &plant.real {
            let pole = Complex64::new(-p.rate, 0.0);
            let step = Hold::new(pole, step_s, 1.0).re();
            let between = Hold::new(pole, step_s, fraction).re();
            real.state.push(if v_um == 0.0 { 0.0 } else { v_um / p.rate });
            real.decay.push(step.decay);
            real.from_start.push(step.from_start);
            real.from_end.push(step.from_end);
            real.weight.push(p.weight);
            real.weight_between.push(p.weight * between.decay);
            real.start_between += p.weight * between.from_start;
            real.end_between += p.weight * between.from_end;
        }
        let pairs = plant
            .pairs
            .iter()
            .map(|p| PairState {
                state: -p.pole.inv() * v_um,
                residue: p.residue,
                step: Hold::new(p.pole, step_s, 1.0),
                between: Hold::new(p.pole, step_s, fraction),
            })
            .collect();
        Propagator { feedthrough: plant.feedthrough, fraction, real, pairs }
    }

    /// Output at the fraction of the coming step, over which the input goes from `v0` to `v1`.
    pub fn output(&self, v0: f64, v1: f64) -> f64 {
        let r = &self.real;
        let mut y = self.feedthrough * (v0 + self.fraction * (v1 - v0));
        let weights = if self.fraction == 0.0 {
            &r.weight
        } else {
            y += r.start_between * v0 + r.end_between * v1;
            &r.weight_between
        };
        y += weights.iter().zip(&r.state).map(|(w, x)| w * x).sum::<f64>();
        for p in &self.pairs {
            let x = if self.fraction == 0.0 {
                p.state
            } else {
                p.between.decay * p.state + p.between.from_start * v0 + p.between.from_end * v1
            };
            y += 2.0 * (p.residue * x).re;
        }
        y
    }

    /// One step under an input going from `v0` to `v1`.
    pub fn advance(&mut self, v0: f64, v1: f64) {
        let r = &mut self.real;
        let coefficients = r.decay.iter().zip(&r.from_start).zip(&r.from_end);
        for (x, ((decay, start), end)) in r.state.iter_mut().zip(coefficients) {
            *x = decay * *x + start * v0 + end * v1;
        }
        for p in &mut self.pairs {
            p.state = p.step.decay * p.state + p.step.from_start * v0 + p.step.from_end * v1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::partial_fractions::{PolePair, RealPole};
    use super::*;

    #[test]
    fn phi_functions_agree_across_the_switch_and_with_their_series() {
        for angle in [0.0, 1.0, 2.0, 3.1] {
            let (a, b) =
                (Complex64::from_polar(0.999_999_999, angle), Complex64::from_polar(1.000_000_001, angle));
            assert!((phi(a).0 - phi(b).0).norm() < 1e-8 && (phi(a).1 - phi(b).1).norm() < 1e-8);
        }
        let (p1, p2) = phi(Complex64::ZERO);
        assert_eq!((p1, p2), (Complex64::ONE, Complex64::new(0.5, 0.0)));
        // e − 1 and e − 2.
        let (p1, p2) = phi(Complex64::ONE);
        assert!((p1.re - 1.718281828459045).abs() < 1e-15 && (p2.re - 0.7182818284590452).abs() < 1e-15);
    }

    /// G = 3/(s + 2) + pair; ramp response in closed form, read between the grid points.
    #[test]
    fn ramp_response_is_exact_at_any_step_and_fraction() {
        let pole = Complex64::new(-0.7, 5.0);
        let residue = Complex64::new(0.2, -1.1);
        let plant = PartialFractions {
            feedthrough: 0.4,
            real: vec![RealPole { rate: 2.0, weight: 3.0 }],
            pairs: vec![PolePair { pole, residue }],
            static_gain: 0.0,
        };
        let ramp = |p: Complex64, t: f64| ((p * t).exp() - 1.0 - p * t) / (p * p);
        let exact = |t: f64| {
            0.4 * t + 3.0 * ramp(Complex64::new(-2.0, 0.0), t).re + 2.0 * (residue * ramp(pole, t)).re
        };
        for (h, fraction) in [(0.3, 0.0), (0.3, 0.37), (0.01, 0.999)] {
            let mut p = Propagator::at_rest(&plant, h, fraction, 0.0);
            for k in 0..20 {
                let (v0, v1) = (k as f64 * h, (k + 1) as f64 * h);
                let t = (k as f64 + fraction) * h;
                assert!((p.output(v0, v1) - exact(t)).abs() < 1e-13, "h {h} fraction {fraction} k {k}");
                p.advance(v0, v1);
            }
        }
    }

    #[test]
    fn rest_is_an_equilibrium() {
        let plant = PartialFractions {
            feedthrough: 0.0,
            real: vec![RealPole { rate: 2.0, weight: 3.0 }],
            pairs: vec![PolePair { pole: Complex64::new(-1.0, 4.0), residue: Complex64::new(0.0, -0.5) }],
            static_gain: f64::NAN,
        };
        let gain = plant.response(Complex64::ZERO).re;
        let mut p = Propagator::at_rest(&plant, 0.1, 0.25, 7.0);
        for _ in 0..50 {
            assert!((p.output(7.0, 7.0) - 7.0 * gain).abs() < 1e-13);
            p.advance(7.0, 7.0);
        }
    }
}
