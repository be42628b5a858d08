//! Problems to be minimised: a cost, or the root mean square of a residual vector.

use super::Bounds;

/// A function to be minimised over a box.
///
/// `x` is in the problem's own units; the optimiser scales them to the unit box ([`Bounds`]).
pub trait Problem: Sync {
    /// Scratch buffers of one evaluating thread: an evaluation allocates nothing.
    type Workspace: Send;

    /// The search box.
    fn bounds(&self) -> &Bounds;
    /// Fresh scratch buffers.
    fn workspace(&self) -> Self::Workspace;
    /// Cost at `x`; a non-finite one counts as +∞ and is never accepted.
    fn cost(&self, x: &[f64], workspace: &mut Self::Workspace) -> f64;
    /// Identity of the problem (model and data, say a hash of the record), written into checkpoints: resuming
    /// a run on a problem of another identity is rejected. The search box and the cost at the best point are
    /// compared in any case.
    fn identity(&self) -> String {
        String::new()
    }
}

/// A [`Problem`] whose cost is the root mean square of a residual vector.
///
/// [`Problem::cost`] must be [`root_mean_square`](crate::root_mean_square) of the same residuals, so that
/// every algorithm minimises the same number.
pub trait LeastSquaresProblem: Problem {
    /// Number of residuals.
    fn residual_count(&self) -> usize;
    /// Residuals at `x` into `out` (length [`Self::residual_count`]); `false` where the model cannot be
    /// simulated.
    fn residuals(&self, x: &[f64], workspace: &mut Self::Workspace, out: &mut [f64]) -> bool;
    /// Derivatives ∂rᵢ/∂xⱼ at `x`, in the problem's own units, into `out` column by column
    /// (`out[j·count + i]`).
    ///
    /// Counted as one evaluation. The default leaves `out` unchanged and requests finite differences.
    fn jacobian(&self, x: &[f64], workspace: &mut Self::Workspace, out: &mut [f64]) -> Derivative {
        let _ = (x, workspace, out);
        Derivative::ByDifferences
    }
    /// As [`Self::jacobian`], but with the non-negative coefficients c that the problem eliminates held at
    /// their values at `x`; and their columns, so that a step can be chosen for x and c together. The
    /// derivatives of [`Self::jacobian`] hold while the same coefficients are 0, a step often changes which.
    ///
    /// The default is [`Self::jacobian`], for problems that eliminate none.
    fn jacobian_with_eliminated<'w>(
        &self,
        x: &[f64],
        workspace: &'w mut Self::Workspace,
        out: &mut [f64],
    ) -> (Derivative, Eliminated<'w>) {
        (self.jacobian(x, workspace, out), Eliminated::default())
    }
}

/// Non-negative coefficients c that a problem eliminates, at one point.
#[derive(Clone, Copy, Debug, Default)]
pub struct Eliminated<'w> {
    /// −∂r/∂cⱼ, column by column.
    pub columns: &'w [f64],
    /// c.
    pub coefficients: &'w [f64],
}

/// Result of [`LeastSquaresProblem::jacobian`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Derivative {
    /// The derivatives were written.
    Written,
    /// The problem supplies no derivatives: take finite differences.
    ByDifferences,
    /// The model cannot be simulated or differentiated at this point.
    Infeasible,
}
