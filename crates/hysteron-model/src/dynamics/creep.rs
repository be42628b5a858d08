//! Creep: the slow motion that follows every move, as a factor of the dynamics.

use super::form_parameter::{FormParameter, ParameterKind as Kind};
use super::linearised::{Number, Sum};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Most elements of a [`Creep::KelvinVoigt`] chain.
pub const MOST_CREEP_ELEMENTS: usize = 4;

/// Creep factor C(s) of a [`super::DynamicForm`], 1 for fast motion.
///
/// Fractional creep is an unbounded power law, logarithmic creep grows by the same amount every decade of
/// time, a Kelvin–Voigt chain settles. Sources: H. Jung, D.-G. Gweon, "Creep characteristics of piezoelectric
/// actuators", *Review of Scientific Instruments* 71 (2000) 1896, doi:10.1063/1.1150559 (logarithmic); D.
/// Croft, G. Shed, S. Devasia, "Creep, hysteresis, and vibration compensation for piezoactuators", *Journal
/// of Dynamic Systems, Measurement, and Control* 123 (2001) 35, doi:10.1115/1.1341197 (chain of springs and
/// dampers).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Creep {
    /// C = 1.
    #[default]
    None,
    /// C = 1 + k s^−μ, parameters `creep` (k, in s^−μ: seconds to the power −μ) and `creep_order` (μ). A unit
    /// step is followed by 1 + k t^μ/Γ(1 + μ): for the small μ of creep, k is about the share that has crept
    /// after one second.
    Fractional,
    /// A unit step is followed by 1 + γ log₁₀(1 + t/t₀), parameters `creep_per_decade` (γ) and `creep_start`
    /// (t₀, s).
    ///
    /// Its transform 1 + γ/ln 10 · e^(s t₀) E₁(s t₀) is no ratio of powers of s, but a spectrum of
    /// relaxations: ln(1 + t/t₀) = ∫ (1 − e^(−t/τ)) e^(−t₀/τ) dτ/τ (Frullani). The trapezoidal rule in ln τ
    /// makes it a chain with two time constants a decade, t₀ 10^(−1/2) to t₀ 10^6, and known weights ½ γ
    /// e^(−t₀/τ); the last one carries what lies beyond it. The step differs by less than 4e-4 γ up to 1e4 t₀
    /// and 1e-3 γ up to 1e5 t₀, the transform by less than 1e-3 γ (`tests/creep.rs`); after that creep comes
    /// to an end, so that G(0) is finite.
    Logarithmic,
    /// C = 1 + Σ kᵢ/(1 + τᵢ s): a unit step is followed by 1 + Σ kᵢ (1 − e^(−t/τᵢ)), springs with dampers
    /// beside them in series with a spring. Parameters `creep_1` (k₁ ≥ 0), `creep_time_1` (τ₁, s), `creep_2`,
    /// … Exchanging elements leaves C unchanged.
    KelvinVoigt {
        /// Number of elements, 1 to [`MOST_CREEP_ELEMENTS`].
        elements: usize,
    },
}

static FRACTIONAL: [FormParameter; 2] =
    [FormParameter::new("creep", Kind::CreepSize), FormParameter::new("creep_order", Kind::CreepOrder)];
static LOGARITHMIC: [FormParameter; 2] = [
    FormParameter::new("creep_per_decade", Kind::CreepPerDecade),
    FormParameter::new("creep_start", Kind::CreepStart),
];
static KELVIN_VOIGT: [FormParameter; 2 * MOST_CREEP_ELEMENTS] = [
    FormParameter::new("creep_1", Kind::CreepShare(1)),
    FormParameter::new("creep_time_1", Kind::CreepTime(1)),
    FormParameter::new("creep_2", Kind::CreepShare(2)),
    FormParameter::new("creep_time_2", Kind::CreepTime(2)),
    FormParameter::new("creep_3", Kind::CreepShare(3)),
    FormParameter::new("creep_time_3", Kind::CreepTime(3)),
    FormParameter::new("creep_4", Kind::CreepShare(4)),
    FormParameter::new("creep_time_4", Kind::CreepTime(4)),
];

impl Creep {
    /// Every kind of creep, with its usual number of elements.
    pub const USUAL: [Self; 3] = [Self::Fractional, Self::Logarithmic, Self::KelvinVoigt { elements: 2 }];

    /// One-line description.
    pub fn summary(self) -> &'static str {
        match self {
            Self::None => "no creep",
            Self::Fractional => "1 + k s^-mu: a power law, unbounded",
            Self::Logarithmic => {
                "1 + gamma log10(1 + t/t0) after a unit step: the same amount every decade of time"
            }
            Self::KelvinVoigt { .. } => "1 + sum of k/(1 + tau s): springs and dampers, creep that settles",
        }
    }

    /// This kind with another number of elements; `None` for a kind that has none.
    pub fn with_elements(self, elements: usize) -> Option<Self> {
        matches!(self, Self::KelvinVoigt { .. }).then_some(Self::KelvinVoigt { elements })
    }

    /// `none`, `fractional`, `logarithmic` or `kelvin-voigt`.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Fractional => "fractional",
            Self::Logarithmic => "logarithmic",
            Self::KelvinVoigt { .. } => "kelvin-voigt",
        }
    }

    /// Name as a part of a structure, where `fractional` is one of the dynamics: `creep`, `log-creep` or
    /// `kelvin-voigt`; `None` without creep.
    pub fn structure_name(self) -> Option<&'static str> {
        match self {
            Self::None => None,
            Self::Fractional => Some("creep"),
            Self::Logarithmic => Some("log-creep"),
            Self::KelvinVoigt { .. } => Some("kelvin-voigt"),
        }
    }

    /// Its factor of G and the response after a unit step; `None` without creep.
    pub fn equations(self) -> Option<&'static str> {
        match self {
            Self::None => None,
            Self::Fractional => Some("1 + k s^−μ, after a unit step 1 + k t^μ/Γ(1 + μ)"),
            Self::Logarithmic => Some("after a unit step 1 + γ log₁₀(1 + t/t₀)"),
            Self::KelvinVoigt { .. } => {
                Some("1 + Σ kᵢ/(1 + τᵢ s), after a unit step 1 + Σ kᵢ (1 − e^(−t/τᵢ))")
            }
        }
    }

    /// Number of its elements; 0 for a kind without elements.
    pub fn elements(self) -> usize {
        match self {
            Self::KelvinVoigt { elements } => elements,
            _ => 0,
        }
    }

    /// True if C has whole orders.
    pub fn has_whole_orders(self) -> bool {
        self != Self::Fractional
    }

    pub(super) fn parameters(self) -> &'static [FormParameter] {
        match self {
            Self::None => &[],
            Self::Fractional => &FRACTIONAL,
            Self::Logarithmic => &LOGARITHMIC,
            Self::KelvinVoigt { elements } => KELVIN_VOIGT.get(..2 * elements).unwrap_or(&[]),
        }
    }

    /// Terms of its numerator and of its denominator.
    pub(super) fn terms(self) -> (usize, usize) {
        match self {
            Self::None => (1, 1),
            Self::Fractional => (2, 1),
            Self::Logarithmic => (ELEMENTS + 1, ELEMENTS + 1),
            Self::KelvinVoigt { elements } => (elements + 1, elements + 1),
        }
    }

    /// Numerator and denominator of C; `p` begins with its parameters.
    pub(super) fn polynomials<S: Number, const T: usize>(self, p: &[S]) -> (Sum<S, T>, Sum<S, T>) {
        let one = S::constant(1.0);
        match (self, p) {
            (Self::Fractional, &[creep, order, ..]) => {
                let power = Sum::of([(one, order)]);
                (power.plus(&Sum::constant(creep)), power)
            }
            (Self::Logarithmic, &[per_decade, start, ..]) => logarithmic(per_decade, start),
            (Self::KelvinVoigt { elements }, p) => {
                let mut sum = (Sum::constant(one), Sum::constant(one));
                for element in p.chunks_exact(2).take(elements) {
                    let rate = one / element[1];
                    let relaxation = (Sum::constant(element[0] * rate), Sum::whole([rate, one]));
                    sum = Sum::add_fractions(&sum, &relaxation);
                }
                sum
            }
            _ => (Sum::constant(one), Sum::constant(one)),
        }
    }
}

/// Number of time constants in the chain of logarithmic creep.
const ELEMENTS: usize = 14;
/// Time constants per decade.
const PER_DECADE: f64 = 2.0;

/// 1/τ of the elements in 1/t₀ and their weights in γ: τ = t₀ 10^((j − 1)/2), weight ½ e^(−t₀/τ).
///
/// The rule's error is the aliasing of the spectrum of the integrand in ln τ, at most 4 |Γ(2πi · 2/ln 10)|/ln
/// 10 = 3.5e-4 of γ. The last element takes the slope of the omitted ones, which for t ≪ τ grow as t/τ: Σ
/// 10^(−j/2) over j ≥ 1.
fn spectrum() -> [(f64, f64); ELEMENTS] {
    let ratio = 10f64.powf(-1.0 / PER_DECADE);
    std::array::from_fn(|j| {
        let rate = 10f64.powf((1.0 - j as f64) / PER_DECADE);
        let beyond = if j + 1 == ELEMENTS { ratio / (1.0 - ratio) } else { 0.0 };
        (rate, (1.0 + beyond) * (-rate).exp() / PER_DECADE)
    })
}

/// In x = s t₀ the polynomials are d(x) + γ n(x) and d(x) with fixed coefficients, d = ∏ (x + rateⱼ).
fn logarithmic<S: Number, const T: usize>(per_decade: S, start: S) -> (Sum<S, T>, Sum<S, T>) {
    let (mut n, mut d) = ([0.0; ELEMENTS + 1], [0.0; ELEMENTS + 1]);
    d[0] = 1.0;
    for (count, (rate, weight)) in spectrum().into_iter().enumerate() {
        // n ← n (x + rate) + weight · rate · d, then d ← d (x + rate).
        for k in (0..=count + 1).rev() {
            let below = |c: &[f64]| if k > 0 { c[k - 1] } else { 0.0 };
            n[k] = n[k] * rate + below(&n) + weight * rate * d[k];
            d[k] = d[k] * rate + below(&d);
        }
    }
    let powers = std::iter::successors(Some(S::constant(1.0)), |power| Some(*power * start));
    let above = n.iter().zip(&d).map(|(n, d)| per_decade.scale(*n).shift(*d));
    (
        Sum::whole(above.zip(powers.clone()).map(|(c, power)| power * c)),
        Sum::whole(d.iter().zip(powers).map(|(d, power)| power.scale(*d))),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_are_those_of_the_kind_that_has_them() {
        assert_eq!(Creep::KelvinVoigt { elements: 3 }.elements(), 3);
        assert_eq!([Creep::None.elements(), Creep::Fractional.elements()], [0, 0]);
    }
}
