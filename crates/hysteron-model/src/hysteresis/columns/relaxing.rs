//! Operators whose single state follows a law of one branch.

use hysteron_rt::branch::BranchLaw;
use hysteron_rt::{Scalar, StepError};

use crate::hysteresis::HysteresisError;

/// Present voltage and a state that relaxes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelaxingState<S> {
    u: S,
    pub(in crate::hysteresis) y: [S; 1],
}

impl<S: Scalar<Real = f64>> RelaxingState<S> {
    pub(in crate::hysteresis) fn virgin(law: &impl BranchLaw<S>, u: S) -> Self {
        Self { u, y: [law.virgin(u)] }
    }

    #[inline(always)]
    pub(in crate::hysteresis) fn advance<L: BranchLaw<S>>(
        &mut self,
        law: &L,
        u: f64,
    ) -> Result<(), HysteresisError> {
        let Self { u: from, y: [y] } = *self;
        let to = S::constant(u);
        let end = y + law.increment(y, from, to);
        *self = Self { u: to, y: [end] };
        if L::IS_BOUNDED || end.value().is_finite() {
            Ok(())
        } else {
            Err(HysteresisError::RunsAway { index: 0, cause: StepError::Overflow })
        }
    }
}

/// The [`super::ColumnKernel`] of a unit struct whose law, of the same name and with this number of
/// parameters, is in [`hysteron_rt::branch`]: its column is the state.
macro_rules! branch_kernel {
    ($law:ident, $parameters:literal) => {
        const _: () = {
            use hysteron_rt::branch::BranchLaw;
            use hysteron_rt::{Scalar, branch};
            use $crate::hysteresis::HysteresisError;
            use $crate::hysteresis::columns::{ColumnKernel, RelaxingState, simulate_with_sensitivities};

            impl ColumnKernel for $law {
                type State<S: Scalar<Real = f64>> = RelaxingState<S>;

                simulate_with_sensitivities!($parameters);

                fn shape_names(&self) -> &'static [&'static str] {
                    branch::$law::<f64>::NUMBERS
                }

                fn check(&self, shape: &[f64]) -> Result<(), HysteresisError> {
                    Ok(branch::$law::of(shape).check()?)
                }

                fn columns(&self) -> usize {
                    1
                }

                fn virgin<S: Scalar<Real = f64>>(&self, shape: &[S], u: S) -> RelaxingState<S> {
                    RelaxingState::virgin(&branch::$law::of(shape), u)
                }

                #[inline(always)]
                fn advance<S: Scalar<Real = f64>>(
                    &self,
                    shape: &[S],
                    state: &mut RelaxingState<S>,
                    u: f64,
                ) -> Result<(), HysteresisError> {
                    state.advance(&branch::$law::of(shape), u)
                }

                fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &RelaxingState<S>, out: &mut [S]) {
                    out.iter_mut().zip(state.y).for_each(|(out, y)| *out = y);
                }

                fn relaxing<S: Scalar<Real = f64>>(state: &mut RelaxingState<S>) -> &mut [S] {
                    &mut state.y
                }
            }
        };
    };
}
pub(in crate::hysteresis) use branch_kernel;
