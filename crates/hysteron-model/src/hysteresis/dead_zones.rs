//! Dead zones, alone as columns and behind plays: Kuhnen's modified Prandtl–Ishlinskii operator and its inverse.
//!
//! Source: K. Kuhnen, "Modeling, identification and compensation of complex hysteretic nonlinearities: a modified
//! Prandtl–Ishlinskii approach", *Eur. J. Control* 9 (2003) 407–418, doi:10.3166/ejc.9.407-418.

use hysteron_rt::Scalar;

use super::columns::{ColumnKernel, simulate_with_sensitivities};
use super::{HysteresisError, PrandtlIshlinskii};
use crate::start::Start;

/// Columns S_r(u) = max(u − r, 0) for r > 0, min(u − r, 0) for r < 0 \[V\]: one-sided dead zones.
///
/// No hysteresis: together with the linear coefficient of the polynomial a broken line. Without shape parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct DeadZones {
    /// Thresholds r \[V\], not 0, increasing.
    pub thresholds: Vec<f64>,
}

/// S_r(x); 0 for r = 0, which is no dead zone.
fn dead_zone<S: Scalar<Real = f64>>(threshold: f64, x: S) -> S {
    let beyond = x.shift(-threshold);
    if (threshold > 0.0 && beyond.value() > 0.0) || (threshold < 0.0 && beyond.value() < 0.0) {
        beyond
    } else {
        S::constant(0.0)
    }
}

/// Finite, not 0, increasing.
fn check_zones(thresholds: &[f64]) -> Result<(), HysteresisError> {
    let name = "threshold of a dead zone";
    if let Some(&value) = thresholds.iter().find(|r| !r.is_finite() || **r == 0.0) {
        return Err(HysteresisError::ShapeParameter { name, value, must: "finite and not 0" });
    }
    match thresholds.windows(2).find(|pair| matches!(pair, [low, high] if low >= high)) {
        Some(pair) => {
            let value = pair.last().copied().unwrap_or(f64::NAN);
            Err(HysteresisError::ShapeParameter { name, value, must: "above the one before it" })
        }
        None => Ok(()),
    }
}

impl ColumnKernel for DeadZones {
    /// The present voltage.
    type State<S: Scalar<Real = f64>> = S;

    simulate_with_sensitivities!(0);

    fn shape_names(&self) -> &'static [&'static str] {
        &[]
    }

    fn check(&self, _: &[f64]) -> Result<(), HysteresisError> {
        check_zones(&self.thresholds)
    }

    fn columns(&self) -> usize {
        self.thresholds.len()
    }

    fn virgin<S: Scalar<Real = f64>>(&self, _: &[S], u: S) -> S {
        u
    }

    fn advance<S: Scalar<Real = f64>>(&self, _: &[S], state: &mut S, u: f64) -> Result<(), HysteresisError> {
        *state = S::constant(u);
        Ok(())
    }

    fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &S, out: &mut [S]) {
        out.iter_mut().zip(&self.thresholds).for_each(|(out, &r)| *out = dead_zone(r, *state));
    }
}

/// Broken line x ↦ linear · x + Σ weightsᵢ S_rᵢ(x).
#[derive(Clone, Debug, PartialEq)]
pub struct BrokenLine {
    /// Slope about 0.
    pub linear: f64,
    /// Places of its corners, not 0, increasing; in the unit of x.
    pub thresholds: Vec<f64>,
    /// Change of slope at each corner, outwards; in the unit of `linear`.
    pub weights: Vec<f64>,
}

impl BrokenLine {
    /// Checks that every number is finite, the corners not at 0 and increasing, one weight a corner.
    ///
    /// # Errors
    /// The first [`HysteresisError`] found.
    pub fn validate(&self) -> Result<(), HysteresisError> {
        check_zones(&self.thresholds)?;
        if !self.linear.is_finite() {
            return Err(HysteresisError::Coefficient { power: 1, value: self.linear });
        }
        if self.weights.len() != self.thresholds.len() {
            let (columns, weights) = (self.thresholds.len(), self.weights.len());
            return Err(HysteresisError::WeightCount { columns, weights });
        }
        match self.weights.iter().position(|w| !w.is_finite()) {
            Some(index) => Err(HysteresisError::ColumnWeight { index, value: self.weights[index] }),
            None => Ok(()),
        }
    }

    /// The value at x.
    pub fn at(&self, x: f64) -> f64 {
        let zones = self.thresholds.iter().zip(&self.weights);
        zones.fold(self.linear * x, |sum, (&r, w)| sum + w * dead_zone(r, x))
    }

    /// The inverse function, again a broken line: corners at the values of the corners, slopes the reciprocals.
    ///
    /// # Errors
    /// As [`Self::validate`]; [`HysteresisError::PartialSlope`] where a slope is not positive (numbered by corners passed,
    /// from 0 outwards).
    pub fn inverse(&self) -> Result<Self, HysteresisError> {
        self.validate()?;
        if self.linear.is_nan() || self.linear <= 0.0 {
            return Err(HysteresisError::PartialSlope { plays: 0, slope: self.linear });
        }
        let mut weights = vec![0.0; self.weights.len()];
        let negative = self.thresholds.iter().filter(|r| **r < 0.0).count();
        let mut outwards = |indices: &mut dyn Iterator<Item = usize>| {
            let mut slope = self.linear;
            for (index, plays) in indices.zip(1..) {
                let next = slope + self.weights[index];
                if next.is_nan() || next <= 0.0 {
                    return Err(HysteresisError::PartialSlope { plays, slope: next });
                }
                // 1/next − 1/slope without cancellation.
                weights[index] = -self.weights[index] / slope / next;
                slope = next;
            }
            Ok(())
        };
        outwards(&mut (0..negative).rev())?;
        outwards(&mut (negative..self.weights.len()))?;
        let thresholds = self.thresholds.iter().map(|&r| self.at(r)).collect();
        let inverse = Self { linear: 1.0 / self.linear, thresholds, weights };
        inverse.validate()?;
        Ok(inverse)
    }
}

/// Kuhnen's modified Prandtl–Ishlinskii operator v = S(H\[u\]): plays H, then a broken line S, which makes loops
/// asymmetric and saturating and has an inverse in closed form.
///
/// Minor loops close as in H; they are congruent no longer. H is in any unit (its output is the input of S); v in µm.
#[derive(Clone, Debug, PartialEq)]
pub struct ModifiedPrandtlIshlinskii {
    /// H. For [`Self::inverse`] its polynomial is linear.
    pub plays: PrandtlIshlinskii,
    /// S.
    pub line: BrokenLine,
}

/// Inverse u = H⁻¹\[S⁻¹(v)\] of [`ModifiedPrandtlIshlinskii`].
#[derive(Clone, Debug, PartialEq)]
pub struct ModifiedInverse {
    /// S⁻¹.
    pub line: BrokenLine,
    /// H⁻¹.
    pub plays: PrandtlIshlinskii,
}

impl ModifiedPrandtlIshlinskii {
    /// A checked operator.
    ///
    /// # Errors
    /// As [`Self::validate`].
    pub fn new(plays: PrandtlIshlinskii, line: BrokenLine) -> Result<Self, HysteresisError> {
        let model = Self { plays, line };
        model.validate()?;
        Ok(model)
    }

    /// Checks both parts.
    ///
    /// # Errors
    /// The first [`HysteresisError`] found.
    pub fn validate(&self) -> Result<(), HysteresisError> {
        self.plays.validate()?;
        self.line.validate()
    }

    /// v \[µm\] for the voltages `u` \[V\] given on a time base finer by `factor`: `out[k]` belongs to `u[k * factor]`.
    /// `plays` as in [`PrandtlIshlinskii::simulate_every`].
    ///
    /// # Errors
    /// As [`PrandtlIshlinskii::simulate_every`] and [`Self::validate`].
    pub fn simulate_every(
        &self,
        factor: usize,
        u: &[f64],
        start: Start<f64>,
        plays: &mut [f64],
        out: &mut [f64],
    ) -> Result<(), HysteresisError> {
        self.line.validate()?;
        self.plays.simulate_every(factor, u, start, plays, out)?;
        for (k, v) in out.iter_mut().enumerate() {
            *v = self.line.at(*v);
            if !v.is_finite() {
                return Err(HysteresisError::Overflow { index: k * factor });
            }
        }
        Ok(())
    }

    /// The inverse operator. It undoes the model from states that correspond: [`PrandtlIshlinskii::inverse_plays`].
    ///
    /// # Errors
    /// As [`PrandtlIshlinskii::inverse`] and [`BrokenLine::inverse`].
    pub fn inverse(&self) -> Result<ModifiedInverse, HysteresisError> {
        Ok(ModifiedInverse { line: self.line.inverse()?, plays: self.plays.inverse()? })
    }
}

impl ModifiedInverse {
    /// The drive \[V\] into `u` (same length) that makes the model put out `v` \[µm\]; `plays` are those of H⁻¹, as in
    /// [`PrandtlIshlinskii::simulate`] with the start given.
    ///
    /// # Errors
    /// As [`PrandtlIshlinskii::simulate`].
    pub fn simulate(
        &self,
        v: &[f64],
        start: Start<f64>,
        plays: &mut [f64],
        u: &mut [f64],
    ) -> Result<(), HysteresisError> {
        let between: Vec<f64> = v.iter().map(|&v| self.line.at(v)).collect();
        self.plays.simulate(&between, start, plays, u)
    }
}
