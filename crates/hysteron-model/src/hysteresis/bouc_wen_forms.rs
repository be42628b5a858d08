//! Other ways to write the Bouc–Wen model, and exact ways there and back.
//!
//! Sources: F. Ikhouane, J. Rodellar, *Systems with Hysteresis*, Wiley 2007, doi:10.1002/9780470513200, ch. 5 (normalised
//! form); Y.-K. Wen, *J. Eng. Mech. Div. ASCE* 102 (1976) 249–263.

use super::{BoucWen, HysteresisError, UnitShape};

/// Normalised form v = l\[u\] + κ_w w,  ẇ = ρ (u̇ − σ |u̇| w |w|ⁿ⁻¹ + (σ − 1) u̇ |w|ⁿ), in which |w| saturates at 1 and no two
/// parameter sets give the same operator. The linear coefficient of l is κ_x.
///
/// With ζ = w/ρ: β' = ρⁿ σ, γ' = ρⁿ (1 − σ), α = −κ_w ρ. Bounded where ρ > 0, σ ≥ ½.
#[derive(Clone, Debug, PartialEq)]
pub struct NormalisedBoucWen {
    /// Coefficients of u, u², … \[µm/V, …\], κ_x first.
    pub polynomial: Vec<f64>,
    /// κ_w \[µm\]; negative where the displacement lags.
    pub kappa_w: f64,
    /// ρ > 0 \[1/V\].
    pub rho: f64,
    /// σ.
    pub sigma: f64,
    /// n ≥ 1.
    pub n: f64,
}

/// Classical form v = l\[u\] + κ z,  ż = A u̇ − β |u̇| z |z|ⁿ⁻¹ − γ u̇ |z|ⁿ; in mechanics l = α k u, κ = (1 − α) D k.
///
/// One parameter more than the operator has: A, β, γ and κ may be scaled against each other. Here α = −κ A.
#[derive(Clone, Debug, PartialEq)]
pub struct ClassicalBoucWen {
    /// Coefficients of u, u², … \[µm/V, …\].
    pub polynomial: Vec<f64>,
    /// κ \[µm per unit of z\]; negative where the displacement lags and A > 0.
    pub kappa: f64,
    /// A \[unit of z per V\].
    pub a: f64,
    /// β.
    pub beta: f64,
    /// γ.
    pub gamma: f64,
    /// n ≥ 1.
    pub n: f64,
}

impl NormalisedBoucWen {
    /// The same operator in the article's symbols.
    ///
    /// # Errors
    /// [`HysteresisError::ShapeParameter`] for ρ that is not positive; as [`BoucWen::validate`].
    pub fn bouc_wen(&self) -> Result<BoucWen, HysteresisError> {
        super::columns::positive("Bouc–Wen ρ", self.rho)?;
        let power = self.rho.powf(self.n);
        let shape = UnitShape { beta: power * self.sigma, gamma: power * (1.0 - self.sigma), n: self.n };
        BoucWen::from_unit(self.polynomial.clone(), -self.kappa_w * self.rho, shape)
    }

    /// The normalised form of an operator that saturates.
    ///
    /// # Errors
    /// As [`BoucWen::validate`]; [`HysteresisError::ShapeParameter`] where β' + γ' is not positive: then z does not
    /// saturate and there is no such form.
    pub fn of(model: &BoucWen) -> Result<Self, HysteresisError> {
        model.validate()?;
        let UnitShape { beta, gamma, n } = model.unit_shape();
        let sum = beta + gamma;
        super::columns::positive("Bouc–Wen β' + γ'", sum)?;
        let rho = sum.powf(1.0 / n);
        Ok(Self {
            polynomial: model.polynomial.clone(),
            kappa_w: -model.alpha / rho,
            rho,
            sigma: beta / sum,
            n,
        })
    }
}

impl ClassicalBoucWen {
    /// The same operator in the article's symbols.
    ///
    /// # Errors
    /// As [`BoucWen::validate`]; with κ A = 0 it has no hysteresis and the article's β and γ exist for n = 1 only.
    pub fn bouc_wen(&self) -> Result<BoucWen, HysteresisError> {
        // With the loop size A alone this is the article's form without its sign.
        let inner = BoucWen::new(self.polynomial.clone(), self.a, self.beta, self.gamma, self.n)?;
        BoucWen::from_unit(inner.polynomial.clone(), -self.kappa * self.a, inner.unit_shape())
    }

    /// The classical form with the A given, which is free: usual are 1 and the article's α (then κ = −1).
    ///
    /// # Errors
    /// As [`BoucWen::validate`]; [`HysteresisError::ShapeParameter`] for A = 0 or one that is not finite.
    pub fn of(model: &BoucWen, a: f64) -> Result<Self, HysteresisError> {
        model.validate()?;
        if !(a.is_finite() && a != 0.0) {
            let (name, must) = ("Bouc–Wen A", "finite and not 0");
            return Err(HysteresisError::ShapeParameter { name, value: a, must });
        }
        let BoucWen { polynomial, beta, gamma, n, .. } =
            BoucWen::from_unit(model.polynomial.clone(), a, model.unit_shape())?;
        Ok(Self { polynomial, kappa: -model.alpha / a, a, beta, gamma, n })
    }
}
