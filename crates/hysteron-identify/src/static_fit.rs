//! The static step as a bare optimisation problem, for studies of optimisers.

use super::layout::Role;
use super::options::{Choice, Options};
use super::static_problem::{StaticProblem, StaticWorkspace};
use super::static_step::{Scales, Setup, Shift, prepare};
use super::{IdentifyError, RecordFacts};
use hysteron_model::Start;
use hysteron_model::hysteresis::ArticleOperator;
use hysteron_model::record::InputOutput;
use hysteron_optimize::{Bounds, LeastSquaresProblem, Problem};

/// Step 1 of the article on one record: RMSE (Eq. 7) of its hysteresis block (Eq. 1) over the search
/// box that [`super::identify`] would use, every parameter searched and only a free offset eliminated.
///
/// The search vector is, in the order of [`Problem::bounds`], the coefficients of u, u², …, then α, β, γ (and
/// n where it is free).
#[derive(Debug)]
pub struct StaticFit {
    problem: StaticProblem,
}

impl StaticFit {
    /// The problem of `record` under `options` (degree, n, demands), from the initial state `start`.
    ///
    /// # Errors
    /// [`IdentifyError`]: a missing degree, demands that cannot be met, an unsuitable start.
    pub fn new(record: &InputOutput, start: &Start, options: &Options) -> Result<Self, IdentifyError> {
        options.validate()?;
        let Choice::Given(degree) = options.degree else {
            return Err(IdentifyError::Demand { name: "degree".into(), wanted: "a given degree" });
        };
        let facts = RecordFacts::new(record.clone());
        let records =
            [prepare(&facts, start, 0, options.demands.fixed(super::static_step::OFFSET), options.scheme())?];
        let scales = Scales::of(&[&facts]);
        let shift = Shift { delay: false, lag: false };
        let setup = Setup { records: &records, scales: &scales, options, shift };
        let (problem, layout) = setup.problem(degree, false)?;
        debug_assert!(layout.polynomial.iter().all(|role| *role != Role::Projected));
        Ok(Self { problem })
    }

    /// The hysteresis block at the search vector `x`; `None` where it cannot be simulated.
    pub fn operator(&self, x: &[f64]) -> Option<ArticleOperator> {
        Some(self.problem.solve(x)?.hysteresis)
    }
}

impl Problem for StaticFit {
    type Workspace = StaticWorkspace;

    fn bounds(&self) -> &Bounds {
        self.problem.bounds()
    }

    fn workspace(&self) -> StaticWorkspace {
        self.problem.workspace()
    }

    fn cost(&self, x: &[f64], workspace: &mut StaticWorkspace) -> f64 {
        self.problem.cost(x, workspace)
    }

    fn identity(&self) -> String {
        self.problem.identity()
    }
}

impl LeastSquaresProblem for StaticFit {
    fn residual_count(&self) -> usize {
        self.problem.residual_count()
    }

    fn residuals(&self, x: &[f64], workspace: &mut StaticWorkspace, out: &mut [f64]) -> bool {
        self.problem.residuals(x, workspace, out)
    }
}
