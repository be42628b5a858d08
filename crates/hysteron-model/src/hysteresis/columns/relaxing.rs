//! The state of operators with one variable that forgets.

use hysteron_rt::Scalar;

/// Present voltage and a state ζ that relaxes towards it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelaxingState<S> {
    pub(in crate::hysteresis) u: S,
    pub(in crate::hysteresis) zeta: [S; 1],
}

impl<S: Scalar<Real = f64>> RelaxingState<S> {
    pub(in crate::hysteresis) fn virgin(u: S) -> Self {
        Self { u, zeta: [S::constant(0.0)] }
    }

    pub(in crate::hysteresis) fn read(&self, out: &mut [S]) {
        out.iter_mut().zip(self.zeta).for_each(|(out, zeta)| *out = zeta);
    }
}
