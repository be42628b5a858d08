//! Columns of plays and of one-sided plays: the Prandtl–Ishlinskii model with weights left open.

use hysteron_rt::Scalar;

use super::HysteresisError;
use super::columns::{ColumnKernel, between, parameter, positive, simulate_with_sensitivities};

/// Columns Fⱼ ← max(u − rⱼ, min(u + rⱼ, Fⱼ)) \[V\], rⱼ = scale · `thresholds`\[j\]: the plays of
/// [`super::PrandtlIshlinskii`].
///
/// Shape: `scale`, 1 for the thresholds as they are. A virgin play stands at its voltage.
#[derive(Clone, Debug, PartialEq)]
pub struct Plays {
    /// Half-widths \[V\], positive and increasing.
    pub thresholds: Vec<f64>,
}

/// Columns Fⱼ ← max(u − rⱼ, min(u, Fⱼ)) \[V\], rⱼ = scale · `thresholds`\[j\], which only ever lag behind a voltage that
/// falls after they were taken along: one-sided plays.
///
/// The play of half-width rⱼ/2 moved by −rⱼ/2, with another virgin state: at rest it stands at u, the upper end of its
/// width. For devices that are driven to one side of their rest. Shape: `scale`. Source: K. Kuhnen, *Eur. J. Control* 9
/// (2003) 407–418, doi:10.3166/ejc.9.407-418.
#[derive(Clone, Debug, PartialEq)]
pub struct OneSidedPlays {
    /// Widths \[V\], positive and increasing.
    pub thresholds: Vec<f64>,
}

/// Where plays stand.
#[derive(Clone, Debug, PartialEq)]
pub struct PlayStates<S> {
    pub(super) plays: Vec<S>,
}

impl<S: Scalar<Real = f64>> PlayStates<S> {
    pub(super) fn at(count: usize, at: S) -> Self {
        Self { plays: vec![at; count] }
    }

    /// Moves to the voltage u: each play between u − below and u + above times its threshold.
    #[inline]
    pub(super) fn advance(&mut self, thresholds: &[f64], scale: S, [below, above]: [f64; 2], u: f64) {
        for (play, &threshold) in self.plays.iter_mut().zip(thresholds) {
            let r = scale.scale(threshold);
            *play = between((-r.scale(below)).shift(u), *play, r.scale(above).shift(u));
        }
    }
}

/// Finite, positive and increasing.
pub(super) fn check_thresholds(thresholds: &[f64]) -> Result<(), HysteresisError> {
    let mut above = 0.0;
    for (index, &value) in thresholds.iter().enumerate() {
        if !(value.is_finite() && value > above) {
            return Err(HysteresisError::Threshold { index, value, above });
        }
        above = value;
    }
    Ok(())
}

macro_rules! play_columns {
    ($kernel:ty, $sides:expr) => {
        impl ColumnKernel for $kernel {
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
                state.advance(&self.thresholds, parameter(shape, 0), $sides, u);
                Ok(())
            }

            fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &PlayStates<S>, out: &mut [S]) {
                out.iter_mut().zip(&state.plays).for_each(|(out, play)| *out = *play);
            }
        }
    };
}

play_columns!(Plays, [1.0, 1.0]);
play_columns!(OneSidedPlays, [1.0, 0.0]);
