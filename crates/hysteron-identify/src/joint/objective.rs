//! The joint fit as a standalone problem, for studies of its cost or for another optimiser.

use super::super::campaign::usable;
use super::super::{CampaignRecord, Choice, Engine, IdentifyError, Options, Watch};
use super::campaign::{JointMember, Rate};
use super::degree::DEGREE_OF_STARTS;
use super::problem::{JointProblem, JointWorkspace};
use super::setup::{self, JointSetup};
use hysteron_optimize::{Bounds, Derivative, Eliminated, LeastSquaresProblem, Problem, Settings};

/// Problem that [`super::super::identify`] solves in a joint fit: residuals of all records, each weighted by
/// its noise, with offsets, polynomial and α eliminated, over β', γ', the parameters of the dynamics, the
/// delay and the memory of each record.
#[derive(Debug)]
pub struct JointObjective {
    problem: JointProblem,
    starts: Vec<Vec<f64>>,
}

/// Scratch of one evaluation of a [`JointObjective`].
#[derive(Debug)]
pub struct JointScratch(JointWorkspace);

impl JointObjective {
    /// The problem of these records. `reduced`: on thinned records, as in the comparison of starts, else on
    /// all samples. With [`Choice::Auto`] the polynomial has the degree of the starts, 3.
    ///
    /// # Errors
    /// Those that [`super::super::identify`] returns before any fit.
    pub fn new(campaign: &[CampaignRecord], options: &Options, reduced: bool) -> Result<Self, IdentifyError> {
        options.validate()?;
        let facts = usable(campaign)?;
        let watch = Watch::silent();
        let mut engine = Engine::new(None, Settings::default(), &watch, super::PLAN, None);
        let members = facts
            .iter()
            .map(|facts| JointMember::new(facts, options, &mut engine))
            .collect::<Result<Vec<_>, _>>()?;
        let options = Options { scheme: Choice::Given(setup::scheme(options, &members)), ..options.clone() };
        let setup = JointSetup::new(&members, setup::form(&options), &options);
        let degree = match options.degree {
            Choice::Given(degree) => degree,
            Choice::Auto => DEGREE_OF_STARTS,
        };
        let problem = setup.problem(degree, if reduced { Rate::Reduced } else { Rate::Own })?;
        let starts = setup.guesses(&problem)?;
        Ok(Self { problem, starts })
    }

    /// The data-driven starts.
    pub fn starts(&self) -> &[Vec<f64>] {
        &self.starts
    }

    /// Weight of each sample of record `index` in the residuals; empty where there is no such record.
    pub fn weights(&self, index: usize) -> &[f64] {
        self.problem.records().get(index).map_or(&[], |record| record.weights())
    }
}

impl Problem for JointObjective {
    type Workspace = JointScratch;

    fn bounds(&self) -> &Bounds {
        self.problem.bounds()
    }

    fn workspace(&self) -> JointScratch {
        JointScratch(self.problem.workspace())
    }

    fn cost(&self, x: &[f64], workspace: &mut JointScratch) -> f64 {
        self.problem.cost(x, &mut workspace.0)
    }

    fn identity(&self) -> String {
        self.problem.identity()
    }
}

impl LeastSquaresProblem for JointObjective {
    fn residual_count(&self) -> usize {
        self.problem.residual_count()
    }

    fn residuals(&self, x: &[f64], workspace: &mut JointScratch, out: &mut [f64]) -> bool {
        self.problem.residuals(x, &mut workspace.0, out)
    }

    fn jacobian(&self, x: &[f64], workspace: &mut JointScratch, out: &mut [f64]) -> Derivative {
        self.problem.jacobian(x, &mut workspace.0, out)
    }

    fn jacobian_with_eliminated<'w>(
        &self,
        x: &[f64],
        workspace: &'w mut JointScratch,
        out: &mut [f64],
    ) -> (Derivative, Eliminated<'w>) {
        self.problem.jacobian_with_eliminated(x, &mut workspace.0, out)
    }
}
