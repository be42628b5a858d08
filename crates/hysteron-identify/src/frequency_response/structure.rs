//! Structures of a frequency response: nonlinear and linear parameters, basis functions and derivatives.

use crate::IdentifyError;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::fmt;

use hysteron_numeric::Complex64;
use hysteron_optimize::Range;

/// Most poles of a [`Core::Rational`].
pub const MOST_POLES: usize = 40;

/// Largest damping of a mode: above 1/√2 there is no resonance, and the pair would mimic creep.
const MOST_DAMPING: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// G(s) = e^{−sτ} · e^{−iδ} · s^{−μ} · Σ_k c_k φ_k(s), s = 2πi f.
///
/// The basis φ is the [`Core`]; the three switches enable μ, δ and τ, which are zero otherwise. The c_k are
/// real and enter linearly: they are projected out of every fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Structure {
    /// The functions φ_k.
    pub core: Core,
    /// The power law s^{−μ}: a slope of −20μ dB per decade with a constant phase of −90°·μ, as for creep.
    pub power_law: bool,
    /// The loss angle e^{−iδ} (at −f its conjugate): a constant phase at constant gain, as for
    /// rate-independent hysteresis under sine drive. No causal linear system has it, so no model file can
    /// hold it.
    pub loss_angle: bool,
    /// The delay e^{−sτ}.
    pub delay: bool,
}

/// The functions φ_k of a [`Structure`], with x = s/2πf_j.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Core {
    /// φ = 1.
    Constant,
    /// φ = 1/(1 + x^α): a fractional lag.
    FractionalLag,
    /// φ = 1/(1 + 2ζ x^α₁ + x^α₂): the form of article Eq. 13, b/(s^α₂ + c₁ s^α₁ + c₀).
    FractionalOscillator,
    /// Poles in partial fractions: 1 if `direct`; 1/(1 + x) for the one real pole of an odd number; for each
    /// pair of poles 1/(1 + 2ζx + x²) and x/(1 + 2ζx + x²), ζ > 1 being two real poles. With `direct` as many
    /// zeros as poles, otherwise one less.
    Rational {
        /// Number of poles, 1 … [`MOST_POLES`].
        poles: usize,
        /// Includes a direct feedthrough.
        direct: bool,
    },
    /// Resonances (ζ ≤ 1/√2) with real residues, as light damping gives them: 1, and for each 1/(1 + 2ζx +
    /// x²). Unlike the free numerator of `Rational`, whose highest coefficient can replace a small delay,
    /// they leave a delay identifiable.
    Modes {
        /// Number of modes, 1 … [`MOST_POLES`]/2.
        count: usize,
    },
}

impl Structure {
    /// K s^{−μ}.
    pub const POWER_LAW: Self = Self::of(Core::Constant).with_power_law();
    /// K e^{−iδ} s^{−μ}.
    pub const LOSS_ANGLE: Self = Self::of(Core::Constant).with_power_law().with_loss_angle();
    /// K/(1 + (s/ω)^α).
    pub const FRACTIONAL_LAG: Self = Self::of(Core::FractionalLag);
    /// One real pole and one real zero.
    pub const LEAD_LAG: Self = Self::of(Core::Rational { poles: 1, direct: true });

    /// The core alone.
    pub const fn of(core: Core) -> Self {
        Self { core, power_law: false, loss_angle: false, delay: false }
    }

    /// With the factor s^{−μ}.
    #[must_use]
    pub const fn with_power_law(mut self) -> Self {
        self.power_law = true;
        self
    }

    /// With the factor e^{−iδ}.
    #[must_use]
    pub const fn with_loss_angle(mut self) -> Self {
        self.loss_angle = true;
        self
    }

    /// With a delay.
    #[must_use]
    pub const fn with_delay(mut self) -> Self {
        self.delay = true;
        self
    }

    /// # Errors
    /// [`IdentifyError::ResponseStructure`] for a number of poles out of range.
    pub fn check(&self) -> Result<(), IdentifyError> {
        match self.core {
            Core::Rational { poles, .. } if poles == 0 || poles > MOST_POLES => {
                let what = "the number of poles";
                Err(IdentifyError::ResponseStructure { what, found: poles, allowed: "1 to 40" })
            }
            Core::Modes { count } if count == 0 || count > MOST_POLES / 2 => {
                let what = "the number of modes";
                Err(IdentifyError::ResponseStructure { what, found: count, allowed: "1 to 20" })
            }
            _ => Ok(()),
        }
    }

    /// Parameters of the core that enter nonlinearly.
    pub(super) fn core_count(&self) -> usize {
        match self.core {
            Core::Constant => 0,
            Core::FractionalLag => 2,
            Core::FractionalOscillator => 4,
            Core::Rational { poles, .. } => poles,
            Core::Modes { count } => 2 * count,
        }
    }

    /// Number of nonlinear parameters.
    pub fn nonlinear_count(&self) -> usize {
        let factors = [self.power_law, self.loss_angle, self.delay];
        self.core_count() + factors.iter().filter(|&&there| there).count()
    }

    /// Number of linear coefficients c.
    pub fn linear_count(&self) -> usize {
        match self.core {
            Core::Rational { poles, direct } => poles + usize::from(direct),
            Core::Modes { count } => 1 + count,
            _ => 1,
        }
    }

    /// Number of all parameters.
    pub fn parameter_count(&self) -> usize {
        self.nonlinear_count() + self.linear_count()
    }

    /// Units of the nonlinear parameters, in the order of [`Self::ranges`].
    pub(super) fn units(&self) -> Vec<&'static str> {
        let mut units = match self.core {
            Core::Constant => vec![],
            Core::FractionalLag => vec!["Hz", ""],
            Core::FractionalOscillator => vec!["Hz", "", "", ""],
            Core::Rational { poles, .. } => {
                let real = if poles % 2 == 1 { &["Hz"][..] } else { &[] };
                [real, &["Hz", ""].repeat(poles / 2)].concat()
            }
            Core::Modes { count } => ["Hz", ""].repeat(count),
        };
        for (there, unit) in [(self.power_law, ""), (self.loss_angle, "rad"), (self.delay, "s")] {
            units.extend(there.then_some(unit));
        }
        units
    }

    /// Names and search ranges of the nonlinear parameters for data from `low_hz` to `high_hz`.
    pub(super) fn ranges(&self, low_hz: f64, high_hz: f64) -> Vec<Range> {
        let wide = |name: &str| Range::logarithmic(name, 1e-4 * low_hz, 1e4 * high_hz);
        let mut ranges = match self.core {
            Core::Constant => Vec::new(),
            Core::FractionalLag => vec![wide("corner_frequency"), Range::linear("order", 0.02, 1.98)],
            Core::FractionalOscillator => vec![
                wide("natural_frequency"),
                Range::linear("damping", 0.0, 100.0),
                // Separate ranges: two equal orders are not identifiable.
                Range::linear("order1", 0.02, 1.4),
                Range::linear("order2", 1.0, 2.5),
            ],
            Core::Rational { poles, .. } => sections(poles % 2 == 1, poles / 2, low_hz, high_hz),
            Core::Modes { count } => {
                let mode = |i: usize| {
                    let frequency = Range::logarithmic(&format!("mode{i}_frequency"), low_hz, 3.0 * high_hz);
                    [frequency, Range::logarithmic(&format!("mode{i}_damping"), 1e-4, MOST_DAMPING)]
                };
                (1..=count).flat_map(mode).collect()
            }
        };
        if self.power_law {
            ranges.push(Range::linear("exponent", -1.0, 1.5));
        }
        if self.loss_angle {
            ranges.push(Range::linear("loss_angle", -FRAC_PI_2, FRAC_PI_2));
        }
        if self.delay {
            ranges.push(Range::linear("delay", 0.0, 10.0 / high_hz));
        }
        ranges
    }

    /// Names of the linear coefficients.
    pub(super) fn linear_names(&self) -> Vec<String> {
        let mut names = Vec::new();
        let (poles, direct) = match self.core {
            Core::Rational { poles, direct } => (poles, direct),
            Core::Modes { count } => {
                names.push("direct".to_owned());
                names.extend((1..=count).map(|i| format!("mode{i}_gain")));
                return names;
            }
            _ => return vec!["gain".to_owned()],
        };
        if direct {
            names.push("direct".to_owned());
        }
        if poles % 2 == 1 {
            names.push("pole_gain".to_owned());
        }
        for i in 1..=poles / 2 {
            names.extend([format!("mode{i}_gain"), format!("mode{i}_slope")]);
        }
        names
    }

    /// Functions φ_k at s = iω with all factors into `values` (length [`Self::linear_count`]) and their
    /// derivatives ∂φ_k/∂x_j into `slopes[j · linear_count + k]`.
    pub(super) fn evaluate(&self, omega: f64, x: &[f64], values: &mut [Complex64], slopes: &mut [Complex64]) {
        slopes.fill(Complex64::ZERO);
        let s = Complex64::new(0.0, omega);
        self.evaluate_core(s, x, values, slopes);
        let width = values.len();
        let log_s = Complex64::new(omega.ln(), FRAC_PI_2);
        let mut factor = Complex64::ONE;
        let mut at = self.core_count();
        let i = Complex64::I;
        for (there, exponent) in [(self.power_law, -log_s), (self.loss_angle, -i), (self.delay, -s)] {
            if there {
                factor *= (exponent * x[at]).exp();
                for (slope, value) in slopes[at * width..(at + 1) * width].iter_mut().zip(&*values) {
                    *slope = exponent * value;
                }
                at += 1;
            }
        }
        values.iter_mut().chain(slopes.iter_mut()).for_each(|v| *v *= factor);
    }

    fn evaluate_core(&self, s: Complex64, x: &[f64], values: &mut [Complex64], slopes: &mut [Complex64]) {
        match self.core {
            Core::Constant => values[0] = Complex64::ONE,
            Core::FractionalLag => {
                let (f, order) = (x[0], x[1]);
                let log = logarithm(s, f);
                let power = (log * order).exp();
                let value = (1.0 + power).inv();
                let square = value * value;
                values[0] = value;
                slopes[0] = square * power * (order / f);
                slopes[1] = -square * power * log;
            }
            Core::FractionalOscillator => {
                let (f, damping, order1, order2) = (x[0], x[1], x[2], x[3]);
                let log = logarithm(s, f);
                let (one, two) = ((log * order1).exp(), (log * order2).exp());
                let value = (1.0 + one * (2.0 * damping) + two).inv();
                let square = value * value;
                values[0] = value;
                slopes[0] = square * (one * (2.0 * damping * order1) + two * order2) / f;
                slopes[1] = -square * one * 2.0;
                slopes[2] = -square * one * log * (2.0 * damping);
                slopes[3] = -square * two * log;
            }
            Core::Rational { poles, direct } => {
                let width = values.len();
                let (mut at, mut k) = (0, 0);
                if direct {
                    values[k] = Complex64::ONE;
                    k += 1;
                }
                if poles % 2 == 1 {
                    let y = s / (TAU * x[at]);
                    let value = (1.0 + y).inv();
                    values[k] = value;
                    slopes[at * width + k] = value * value * y / x[at];
                    at += 1;
                    k += 1;
                }
                while k < width {
                    let (f, damping) = (x[at], x[at + 1]);
                    let y = s / (TAU * f);
                    let value = (1.0 + y * (2.0 * damping) + y * y).inv();
                    let square = value * value;
                    let by_f = square * y * (2.0 * damping + 2.0 * y) / f;
                    let by_damping = -square * y * 2.0;
                    values[k] = value;
                    values[k + 1] = y * value;
                    slopes[at * width + k] = by_f;
                    slopes[at * width + k + 1] = y * by_f - y * value / f;
                    slopes[(at + 1) * width + k] = by_damping;
                    slopes[(at + 1) * width + k + 1] = y * by_damping;
                    at += 2;
                    k += 2;
                }
            }
            Core::Modes { count } => {
                values[0] = Complex64::ONE;
                let width = values.len();
                for i in 0..count {
                    let (f, damping) = (x[2 * i], x[2 * i + 1]);
                    let y = s / (TAU * f);
                    let value = (1.0 + y * (2.0 * damping) + y * y).inv();
                    let square = value * value;
                    values[1 + i] = value;
                    slopes[2 * i * width + 1 + i] = square * y * (2.0 * damping + 2.0 * y) / f;
                    slopes[(2 * i + 1) * width + 1 + i] = -square * y * 2.0;
                }
            }
        }
    }
}

/// Ranges of one real pole, if any, and of pole pairs.
fn sections(real: bool, pairs: usize, low_hz: f64, high_hz: f64) -> Vec<Range> {
    let near = |name: &str| Range::logarithmic(name, 1e-2 * low_hz, 1e2 * high_hz);
    let mut ranges = Vec::new();
    if real {
        ranges.push(near("pole_frequency"));
    }
    for i in 1..=pairs {
        ranges.push(near(&format!("mode{i}_frequency")));
        ranges.push(Range::logarithmic(&format!("mode{i}_damping"), 1e-5, 1e3));
    }
    ranges
}

/// Principal value of ln(s/2πf), for s on the positive imaginary axis.
fn logarithm(s: Complex64, f: f64) -> Complex64 {
    Complex64::new((s.im / (TAU * f)).ln(), FRAC_PI_2)
}

/// The formula, e.g. `K e^−iδ s^−μ`.
impl fmt::Display for Structure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let factors = [(self.delay, "e^−sτ "), (self.loss_angle, "e^−iδ "), (self.power_law, "s^−μ ")];
        let factors: String = factors.iter().filter(|(there, _)| *there).map(|(_, text)| *text).collect();
        match self.core {
            Core::Constant => write!(f, "K {}", factors.trim_end()),
            Core::FractionalLag => write!(f, "{factors}K/(1 + (s/ω)^α)"),
            Core::FractionalOscillator => write!(f, "{factors}K/(1 + 2ζ(s/ω)^α₁ + (s/ω)^α₂)"),
            Core::Rational { poles, direct } => {
                let zeros = if direct { poles } else { poles - 1 };
                write!(f, "{factors}B(s)/A(s), zeros: {zeros}, poles: {poles}")
            }
            Core::Modes { .. } => write!(f, "{factors}(d + Σ rω²/(s² + 2ζωs + ω²))"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> Vec<Structure> {
        let rational = |poles, direct| Structure::of(Core::Rational { poles, direct });
        vec![
            Structure::POWER_LAW,
            Structure::LOSS_ANGLE,
            Structure::FRACTIONAL_LAG,
            Structure::LEAD_LAG,
            Structure::of(Core::FractionalOscillator).with_delay(),
            rational(5, false).with_power_law(),
            rational(4, true).with_power_law().with_loss_angle().with_delay(),
            Structure::of(Core::Modes { count: 3 }).with_power_law().with_delay(),
        ]
    }

    fn point(structure: &Structure) -> Vec<f64> {
        let place = |i: usize| 0.35 + 0.07 * (i % 5) as f64;
        structure.ranges(1.0, 100.0).iter().enumerate().map(|(i, r)| r.from_unit(place(i))).collect()
    }

    fn values(structure: &Structure, omega: f64, x: &[f64]) -> Vec<Complex64> {
        let mut values = vec![Complex64::ZERO; structure.linear_count()];
        let mut slopes = vec![Complex64::ZERO; structure.linear_count() * x.len()];
        structure.evaluate(omega, x, &mut values, &mut slopes);
        values
    }

    #[test]
    fn derivatives_agree_with_differences_of_sixth_order() {
        for structure in all() {
            let x = point(&structure);
            assert_eq!(x.len(), structure.nonlinear_count());
            let width = structure.linear_count();
            for omega in [3.0, 90.0, 700.0] {
                let mut slopes = vec![Complex64::ZERO; width * x.len()];
                structure.evaluate(omega, &x, &mut vec![Complex64::ZERO; width], &mut slopes);
                for j in 0..x.len() {
                    let h = 1e-3 * x[j].abs().max(1e-3);
                    let at = |steps: f64| {
                        let mut moved = x.clone();
                        moved[j] += steps * h;
                        values(&structure, omega, &moved)
                    };
                    let sides: Vec<_> = [1.0, 2.0, 3.0].map(|k| (at(k), at(-k))).into();
                    for k in 0..width {
                        let d = |m: usize| sides[m].0[k] - sides[m].1[k];
                        let difference = (d(0) * 45.0 - d(1) * 9.0 + d(2)) / (60.0 * h);
                        let exact = slopes[j * width + k];
                        let scale =
                            exact.norm() + 1e-3 * values(&structure, omega, &x)[k].norm() / x[j].abs();
                        assert!(
                            (difference - exact).norm() <= 1e-8 * scale,
                            "{structure}, parameter {j}, function {k}: {difference} {exact}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn functions_are_the_formulas_at_a_point_computed_by_hand() {
        // x = s/ω = i: 1/(1 + i) = (1 − i)/2, 1/(2ζ i) with ζ = 1/4: −2i, times x: 2.
        let structure = Structure::of(Core::Rational { poles: 3, direct: true });
        let found = values(&structure, TAU * 5.0, &[5.0, 5.0, 0.25]);
        let expected = [(1.0, 0.0), (0.5, -0.5), (0.0, -2.0), (2.0, 0.0)];
        for (found, (re, im)) in found.iter().zip(expected) {
            assert!((found - Complex64::new(re, im)).norm() < 1e-15, "{found}");
        }
        // (i·4)^{−1/2} = e^{−iπ/4}/2, e^{−iπ/4} more by the loss angle: −i/2.
        let found = values(&Structure::LOSS_ANGLE, 4.0, &[0.5, FRAC_PI_2 / 2.0]);
        assert!((found[0] - Complex64::new(0.0, -0.5)).norm() < 1e-15);
        // 1/(1 + √(i)²) with two halves: x^1 = i.
        let found = values(&Structure::FRACTIONAL_LAG, TAU * 3.0, &[3.0, 1.0]);
        assert!((found[0] - Complex64::new(0.5, -0.5)).norm() < 1e-15);
    }

    #[test]
    fn numbers_of_poles_that_are_not_fitted_are_refused() {
        for poles in [0, MOST_POLES + 1] {
            assert!(Structure::of(Core::Rational { poles, direct: false }).check().is_err());
        }
        assert!(Structure::LEAD_LAG.check().is_ok());
        assert_eq!(Structure::LEAD_LAG.parameter_count(), 3);
        assert_eq!(Structure::LOSS_ANGLE.parameter_count(), 3);
    }
}
