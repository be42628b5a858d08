//! One-sided plays, for devices that are driven to one side of their rest.

use hysteron_rt::{Scalar, Sides};

use super::HysteresisError;
use super::columns::{ColumnKernel, parameter, positive, simulate_with_sensitivities};
use super::family::{
    ColumnFamily, DriveSpan, Elements, FamilyDescription, MOST_ELEMENTS, NumberUnit, RuntimeOperator, Search,
    ShapeNumber,
};
use super::plays::{PlayStates, check_thresholds, evenly_below, scaled};

/// Columns Fⱼ ← max(u − rⱼ, min(u, Fⱼ)) \[V\], rⱼ = scale · `thresholds`\[j\], which lag behind a rising
/// voltage by up to rⱼ and not behind a falling one: one-sided plays.
///
/// The play of half-width rⱼ/2 moved by −rⱼ/2, with another virgin state: at rest it is at u, the upper end
/// of its width. Shape: `scale`. Source: K. Kuhnen, *Eur. J. Control* 9 (2003) 407–418,
/// doi:10.3166/ejc.9.407-418.
#[derive(Clone, Debug, PartialEq)]
pub struct OneSidedPlays {
    /// Widths \[V\], positive and increasing.
    pub thresholds: Vec<f64>,
}

impl ColumnKernel for OneSidedPlays {
    type State<S: Scalar<Real = f64>> = PlayStates<S>;

    simulate_with_sensitivities!(1);

    fn shape_names(&self) -> &'static [&'static str] {
        &["scale"]
    }

    fn check(&self, shape: &[f64]) -> Result<(), HysteresisError> {
        check_thresholds(&self.thresholds)?;
        positive("scale of the thresholds", parameter(shape, 0))
    }

    fn columns(&self) -> usize {
        self.thresholds.len()
    }

    fn virgin<S: Scalar<Real = f64>>(&self, _: &[S], u: S) -> PlayStates<S> {
        PlayStates::at(self.thresholds.len(), u)
    }

    fn advance<S: Scalar<Real = f64>>(
        &self,
        shape: &[S],
        state: &mut PlayStates<S>,
        u: f64,
    ) -> Result<(), HysteresisError> {
        let thresholds = scaled(&self.thresholds, parameter(shape, 0));
        let _ = Sides::Below.advance(thresholds, &mut state.plays, [S::constant(u); 2], 0.0);
        Ok(())
    }

    fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &PlayStates<S>, out: &mut [S]) {
        state.read(out);
    }
}

/// The family: widths `scale` · j/(plays + 1).
#[derive(Debug)]
pub(super) struct Entry;

impl FamilyDescription for Entry {
    fn name(&self) -> &'static str {
        "one-sided-plays"
    }

    fn summary(&self) -> &'static str {
        "12 plays for a drive to one side of rest"
    }

    fn equation(&self) -> &'static str {
        "sum of weight_j F_j, F_j <- max(u - r_j, min(u, F_j)), r_j = scale j/(number + 1)"
    }

    fn elements(&self) -> Option<Elements> {
        Some(Elements { usual: 12, most: MOST_ELEMENTS })
    }

    fn shape_numbers(&self, _: usize, span: &DriveSpan) -> Vec<ShapeNumber> {
        vec![ShapeNumber::new(
            "scale",
            NumberUnit::INPUT,
            "width beyond the widest play",
            Search::Held(span.stroke),
        )]
    }

    fn starts(&self, _: usize, span: &DriveSpan) -> Vec<Vec<f64>> {
        vec![vec![span.stroke]]
    }

    fn example(&self, _: usize, span: &DriveSpan) -> Vec<f64> {
        vec![0.53 * span.stroke]
    }

    fn is_monotone(&self) -> bool {
        true
    }

    /// Plays that lag only behind a rising voltage retain a memory of lower voltages only.
    fn first_memory(&self, _: &[f64], first: f64, _: [f64; 2], stroke: f64, settled: bool) -> f64 {
        if settled { first - 0.25 * stroke } else { first }
    }

    fn runtime(
        &self,
        plays: usize,
        _: &mut [f64],
        shape: &[f64],
        weights: &[f64],
        _: f64,
    ) -> RuntimeOperator {
        RuntimeOperator::sided(Sides::Below, evenly_below(parameter(shape, 0), plays), weights)
    }
}

impl ColumnFamily for Entry {
    type Kernel = OneSidedPlays;

    fn kernel(&self, plays: usize, _: &[f64], _: f64) -> OneSidedPlays {
        OneSidedPlays { thresholds: evenly_below(1.0, plays) }
    }
}
