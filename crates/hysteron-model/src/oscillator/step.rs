//! One step of the classical Runge–Kutta scheme of fourth order, with and without derivatives.
//!
//! The derivatives are those of the step itself, not of the differential equation it approximates: each stage
//! carries its own (E. Hairer, S. P. Nørsett, G. Wanner, *Solving Ordinary Differential Equations I*, 2nd ed.
//! 1993, §II.1 and §I.14, doi:10.1007/978-3-540-78862-1).

use super::sensitivities::{PARTIALS, Tangent};
use super::{Oscillator, OscillatorState};

/// Case of the exponent n: 1, 2 or any other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Power {
    One,
    Two,
    Any,
}

/// The right-hand side of the equations of motion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    per_mass: f64,
    parameters: Oscillator,
    power: Power,
}

/// (y, ẏ, z).
pub(super) type State = [f64; 3];

impl From<OscillatorState> for State {
    fn from(state: OscillatorState) -> Self {
        [state.y, state.velocity, state.z]
    }
}

impl From<State> for OscillatorState {
    fn from([y, velocity, z]: State) -> Self {
        Self { y, velocity, z }
    }
}

/// −1, 0 or 1.
#[inline(always)]
fn sign(x: f64) -> f64 {
    if x > 0.0 {
        1.0
    } else if x < 0.0 {
        -1.0
    } else {
        0.0
    }
}

/// x + a d.
#[inline(always)]
fn moved(x: &State, a: f64, d: &State) -> State {
    [x[0] + a * d[0], x[1] + a * d[1], x[2] + a * d[2]]
}

/// x + h/6 (k₁ + 2 k₂ + 2 k₃ + k₄).
#[inline(always)]
fn combined(x: f64, h: f64, [k1, k2, k3, k4]: [f64; 4]) -> f64 {
    x + h / 6.0 * ((k1 + k4) + 2.0 * (k2 + k3))
}

impl Motion {
    pub(super) fn of(parameters: &Oscillator) -> Self {
        let power = match parameters.n {
            1.0 => Power::One,
            2.0 => Power::Two,
            _ => Power::Any,
        };
        Self { per_mass: 1.0 / parameters.mass, parameters: *parameters, power }
    }

    pub(super) fn parameters(&self) -> &Oscillator {
        &self.parameters
    }

    /// |z|ⁿ⁻¹.
    #[inline(always)]
    fn less(&self, z: f64) -> f64 {
        let size = z.abs();
        match self.power {
            Power::One => 1.0,
            Power::Two => size,
            Power::Any if size > 0.0 => size.powf(self.parameters.n - 1.0),
            Power::Any => 0.0,
        }
    }

    /// (ẏ, ÿ, ż) under the force u, `less` = |z|ⁿ⁻¹.
    #[inline(always)]
    fn rate(&self, &[y, v, z]: &State, u: f64, less: f64) -> State {
        let p = &self.parameters;
        let force = u - p.damping * v - p.stiffness * y - z;
        [v, force * self.per_mass, v * (p.alpha - p.gamma * (less * z.abs())) - p.beta * v.abs() * (less * z)]
    }

    /// The state a time `h` later, under the force `u` at the beginning, the middle and the end.
    #[inline(always)]
    pub(super) fn step(&self, x: &State, u: [f64; 3], h: f64) -> State {
        let rate = |x: &State, u: f64| self.rate(x, u, self.less(x[2]));
        let k1 = rate(x, u[0]);
        let k2 = rate(&moved(x, 0.5 * h, &k1), u[1]);
        let k3 = rate(&moved(x, 0.5 * h, &k2), u[1]);
        let k4 = rate(&moved(x, h, &k3), u[2]);
        std::array::from_fn(|i| combined(x[i], h, [k1[i], k2[i], k3[i], k4[i]]))
    }

    /// [`Self::rate`] and its derivatives where those of the state are `s`.
    #[inline(always)]
    fn rate_with_tangent(&self, x: &State, s: &Tangent, u: f64) -> (State, Tangent) {
        let p = &self.parameters;
        let [y, v, z] = *x;
        let less = self.less(z);
        let rate = self.rate(x, u, less);
        let (speed, size) = (v.abs(), z.abs());
        // ż = v (α − γ |z|ⁿ) − β |v| z |z|ⁿ⁻¹ with respect to v and z.
        let of_v = p.alpha - p.gamma * (less * size) - p.beta * sign(v) * (less * z);
        let pull = p.beta * speed + p.gamma * v * sign(z);
        let of_z = -(p.n * less) * pull;
        let logarithm = if size > 0.0 { size.ln() } else { 0.0 };
        let mut d = Tangent { y: s.v, v: [0.0; PARTIALS], z: [0.0; PARTIALS] };
        for j in 0..PARTIALS {
            d.v[j] = -self.per_mass * (p.damping * s.v[j] + p.stiffness * s.y[j] + s.z[j]);
            d.z[j] = of_v * s.v[j] + of_z * s.z[j];
        }
        d.v[0] -= rate[1] * self.per_mass;
        d.v[1] -= v * self.per_mass;
        d.v[2] -= y * self.per_mass;
        d.z[3] += v;
        d.z[4] -= speed * (less * z);
        d.z[5] -= v * (less * size);
        d.z[6] -= logarithm * (less * z) * (p.beta * speed + p.gamma * v * sign(z));
        (rate, d)
    }

    /// [`Self::step`], the same bits, and the derivatives of the state it leads to.
    #[inline(always)]
    pub(super) fn step_with_tangent(
        &self,
        (x, s): (&State, &Tangent),
        u: [f64; 3],
        h: f64,
    ) -> (State, Tangent) {
        let (k1, d1) = self.rate_with_tangent(x, s, u[0]);
        let (k2, d2) = self.rate_with_tangent(&moved(x, 0.5 * h, &k1), &s.moved(0.5 * h, &d1), u[1]);
        let (k3, d3) = self.rate_with_tangent(&moved(x, 0.5 * h, &k2), &s.moved(0.5 * h, &d2), u[1]);
        let (k4, d4) = self.rate_with_tangent(&moved(x, h, &k3), &s.moved(h, &d3), u[2]);
        let next = std::array::from_fn(|i| combined(x[i], h, [k1[i], k2[i], k3[i], k4[i]]));
        let column = |of: fn(&Tangent) -> &[f64; PARTIALS]| -> [f64; PARTIALS] {
            std::array::from_fn(|j| combined(of(s)[j], h, [of(&d1)[j], of(&d2)[j], of(&d3)[j], of(&d4)[j]]))
        };
        (next, Tangent { y: column(|t| &t.y), v: column(|t| &t.v), z: column(|t| &t.z) })
    }
}
