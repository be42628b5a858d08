//! Generalised plays: plays with saturating, unequal envelopes.
//!
//! Source: M. Al Janaideh, S. Rakheja, C.-Y. Su, "An analytical generalized Prandtl–Ishlinskii model
//! inversion for hysteresis compensation in micropositioning control", *IEEE/ASME Trans. Mechatronics* 16
//! (2011) 734–744, doi:10.1109/TMECH.2010.2052366.

use hysteron_rt::{Scalar, Sides};

use super::HysteresisError;
use super::columns::{ColumnKernel, parameter, positive, simulate_with_sensitivities};
use super::family::{
    ColumnFamily, DriveSpan, Elements, FamilyDescription, MOST_ELEMENTS, NumberUnit, RuntimeOperator, Search,
    ShapeNumber,
};

/// Columns Fⱼ ← max(γ_r(u) − rⱼ, min(γ_l(u) + rⱼ, Fⱼ)) with the envelopes
///
/// γ_r(u) = tanh(a_r (u − c_r)) where u rises,  γ_l(u) = tanh(a_l (u − c_l)) where it falls.
///
/// Columns and thresholds are in units of the envelopes, in which these end at ±1. Shape: `rise_right` a_r
/// \[1/V\], `centre_right` c_r \[V\], `rise_left` a_l, `centre_left` c_l. A play has an admissible state
/// wherever γ_r − γ_l ≤ 2rⱼ; a voltage at which the narrowest has none is an error. A virgin play is at ½
/// (γ_l + γ_r).
///
/// Equal envelopes give a sum of plays of γ(u).
#[derive(Clone, Debug, PartialEq)]
pub struct GeneralisedPlays {
    /// Half-widths, from 0 on (where the envelopes allow it), increasing.
    pub thresholds: Vec<f64>,
}

/// Present voltage and plays.
#[derive(Clone, Debug, PartialEq)]
pub struct GeneralisedPlayStates<S> {
    u: f64,
    plays: Vec<S>,
}

/// The envelopes of this shape.
fn envelopes<S: Scalar<Real = f64>>(shape: &[S]) -> Sides<S> {
    let of = |index| parameter(shape, index);
    Sides::Envelopes { right: [of(0), of(1)], left: [of(2), of(3)] }
}

impl GeneralisedPlays {
    fn half_widths<S: Scalar<Real = f64>>(&self) -> impl Iterator<Item = S> + Clone {
        self.thresholds.iter().map(|&threshold| S::constant(threshold))
    }
}

impl ColumnKernel for GeneralisedPlays {
    type State<S: Scalar<Real = f64>> = GeneralisedPlayStates<S>;

    simulate_with_sensitivities!(4);

    fn shape_names(&self) -> &'static [&'static str] {
        &["rise_right", "centre_right", "rise_left", "centre_left"]
    }

    fn check(&self, shape: &[f64]) -> Result<(), HysteresisError> {
        let mut above = -1.0;
        for (index, &value) in self.thresholds.iter().enumerate() {
            let least: f64 = if index == 0 { 0.0 } else { above };
            if !(value.is_finite() && value >= least && value > above) {
                return Err(HysteresisError::Threshold { index, value, above: least });
            }
            above = value;
        }
        positive("rise of the right envelope", parameter(shape, 0))?;
        positive("rise of the left envelope", parameter(shape, 2))?;
        for (name, index) in [("centre of the right envelope", 1), ("centre of the left envelope", 3)] {
            let value: f64 = parameter(shape, index);
            if !value.is_finite() {
                return Err(HysteresisError::ShapeParameter { name, value, must: "finite" });
            }
        }
        Ok(())
    }

    fn columns(&self) -> usize {
        self.thresholds.len()
    }

    fn virgin<S: Scalar<Real = f64>>(&self, shape: &[S], u: S) -> GeneralisedPlayStates<S> {
        let mut plays = vec![u; self.thresholds.len()];
        // Plays without an admissible state at rest are refused by the first move.
        let _ = envelopes(shape).rest_at(self.half_widths(), &mut plays, u);
        GeneralisedPlayStates { u: u.value(), plays }
    }

    fn advance<S: Scalar<Real = f64>>(
        &self,
        shape: &[S],
        state: &mut GeneralisedPlayStates<S>,
        u: f64,
    ) -> Result<(), HysteresisError> {
        let through = [S::constant(u); 2];
        envelopes(shape).advance(self.half_widths(), &mut state.plays, through, 0.0).map_err(|by| {
            let narrowest = self.thresholds.first().copied().unwrap_or(0.0);
            HysteresisError::Envelopes { u, by, narrowest }
        })?;
        state.u = u;
        Ok(())
    }

    fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &GeneralisedPlayStates<S>, out: &mut [S]) {
        out.iter_mut().zip(&state.plays).for_each(|(out, play)| *out = *play);
    }
}

/// The family: thresholds (j − ½)/plays.
#[derive(Debug)]
pub(super) struct Entry;

impl FamilyDescription for Entry {
    fn name(&self) -> &'static str {
        "generalised-plays"
    }

    fn summary(&self) -> &'static str {
        "8 plays behind saturating, unequal envelopes"
    }

    fn equation(&self) -> &'static str {
        "sum of weight_j F_j, F_j <- max(R(u) - r_j, min(L(u) + r_j, F_j)), r_j = (j - 1/2)/number, R = \
         tanh(rise_right (u - centre_right)), L = tanh(rise_left (u - centre_left))"
    }

    fn elements(&self) -> Option<Elements> {
        Some(Elements { usual: 8, most: MOST_ELEMENTS })
    }

    fn weight_unit(&self, _: usize) -> NumberUnit {
        NumberUnit::OUTPUT
    }

    fn shape_numbers(&self, _: usize, span: &DriveSpan) -> Vec<ShapeNumber> {
        let rise = Search::Logarithmic(0.05 / span.stroke, 20.0 / span.stroke);
        let (steepness, place) = (NumberUnit::PER_INPUT, NumberUnit::INPUT);
        vec![
            ShapeNumber::new("rise_right", steepness, "steepness of the envelope going up", rise),
            ShapeNumber::new("centre_right", place, "middle of the envelope going up", span.around()),
            ShapeNumber::new("rise_left", steepness, "steepness of the envelope coming down", rise),
            ShapeNumber::new("centre_left", place, "middle of the envelope coming down", span.around()),
        ]
    }

    fn starts(&self, _: usize, span: &DriveSpan) -> Vec<Vec<f64>> {
        let middle = span.middle();
        [0.3, 1.0, 3.0].map(|rise| vec![rise / span.stroke, middle, rise / span.stroke, middle]).into()
    }

    fn example(&self, _: usize, span: &DriveSpan) -> Vec<f64> {
        let middle = span.middle();
        vec![2.1 / span.stroke, middle + 0.03 * span.stroke, 1.9 / span.stroke, middle + 0.01 * span.stroke]
    }

    fn is_monotone(&self) -> bool {
        true
    }

    fn runtime(
        &self,
        plays: usize,
        _: &mut [f64],
        shape: &[f64],
        weights: &[f64],
        _: f64,
    ) -> RuntimeOperator {
        RuntimeOperator::sided(envelopes(shape), middles(plays), weights)
    }
}

/// (j − ½)/count, j = 1 … count.
fn middles(count: usize) -> Vec<f64> {
    (0..count).map(|j| (j as f64 + 0.5) / count as f64).collect()
}

impl ColumnFamily for Entry {
    type Kernel = GeneralisedPlays;

    fn kernel(&self, plays: usize, _: &[f64], _: f64) -> GeneralisedPlays {
        GeneralisedPlays { thresholds: middles(plays) }
    }
}
