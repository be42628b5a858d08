//! The reproduction for programs, without the curves.

use serde::Serialize;

use crate::optimizers::Contender;
use crate::{Claim, Contradictions, ModelFit, Plan, Recovery, Reproduction, StaticParameters};

/// Tables and verdicts of a [`Reproduction`].
#[derive(Clone, Debug, Serialize)]
pub struct Summary<'a> {
    plan: &'a Plan,
    claims: &'a [Claim],
    table_1: Vec<Table1Row<'a>>,
    table_2: Table2<'a>,
    table_3: &'a [ModelFit],
    contradictions: &'a Contradictions,
    recovery: &'a Recovery,
}

/// An optimiser of Table 1.
#[derive(Clone, Debug, Serialize)]
struct Table1Row<'a> {
    algorithm: &'a str,
    printed: Option<f64>,
    median_rmse_um: f64,
    quartiles_um: (f64, f64),
    success_percent: f64,
    evaluations_to_1_percent: Option<f64>,
}

/// The static block of Table 2.
#[derive(Clone, Debug, Serialize)]
struct Table2<'a> {
    parameters: &'a StaticParameters,
    re: f64,
    rmse_um: f64,
}

impl Reproduction {
    /// The result for programs: everything but the curves.
    pub fn summary(&self) -> Summary<'_> {
        Summary {
            plan: &self.plan,
            claims: &self.claims,
            table_1: self.optimizers.contenders.iter().map(Table1Row::new).collect(),
            table_2: Table2 {
                parameters: &self.static_block.parameters,
                re: self.static_block.re,
                rmse_um: self.static_block.rmse_um,
            },
            table_3: &self.models.models,
            contradictions: &self.contradictions,
            recovery: &self.recovery,
        }
    }
}

impl<'a> Table1Row<'a> {
    fn new(c: &'a Contender) -> Self {
        Self {
            algorithm: &c.name,
            printed: c.printed,
            median_rmse_um: c.median_um,
            quartiles_um: c.quartiles_um,
            success_percent: c.success_percent,
            evaluations_to_1_percent: c.evaluations_to_1_percent,
        }
    }
}
