//! The reproduction without its curves.

use serde::{Deserialize, Serialize};

use crate::optimizers::Contender;
use crate::{Claim, Contradictions, ModelFit, Plan, Recovery, Reproduction, StaticParameters};

/// Tables and verdicts of a [`Reproduction`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Seed, runs and records of the reproduction.
    pub plan: Plan,
    /// The article's claims, judged.
    pub claims: Vec<Claim>,
    /// Table 1, one row an optimiser.
    pub table_1: Vec<Table1Row>,
    /// Table 2.
    pub table_2: StaticRow,
    /// Table 3, one row a model.
    pub table_3: Vec<ModelFit>,
    /// Checks of the printed numbers against each other.
    pub contradictions: Contradictions,
    /// Table 2 and Eq. 13 as the truth.
    pub recovery: Recovery,
}

/// An optimiser of Table 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Table1Row {
    /// Short name.
    pub algorithm: String,
    /// The article's best fitness, where Table 1 has it.
    pub printed: Option<f64>,
    /// Median over the runs of the best RMSE \[µm\].
    pub median_rmse_um: f64,
    /// Lower and upper quartile.
    pub quartiles_um: (f64, f64),
    /// Runs within 1 % of the best reachable RMSE \[%\].
    pub success_percent: f64,
    /// Median number of evaluations to reach 1 %; `None` where fewer than half of the runs do.
    pub evaluations_to_1_percent: Option<f64>,
}

/// The static block of Table 2.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StaticRow {
    /// Parameters of the best fit by DE-ABC.
    pub parameters: StaticParameters,
    /// Relative error.
    pub re: f64,
    /// RMSE on the 1 Hz loop \[µm\].
    pub rmse_um: f64,
}

impl Reproduction {
    /// Everything but the curves.
    pub fn summary(&self) -> Summary {
        Summary {
            plan: self.plan.clone(),
            claims: self.claims.clone(),
            table_1: self.optimizers.contenders.iter().map(Table1Row::new).collect(),
            table_2: StaticRow {
                parameters: self.static_block.parameters,
                re: self.static_block.re,
                rmse_um: self.static_block.rmse_um,
            },
            table_3: self.models.models.clone(),
            contradictions: self.contradictions.clone(),
            recovery: self.recovery.clone(),
        }
    }
}

impl Table1Row {
    fn new(c: &Contender) -> Self {
        Self {
            algorithm: c.name.clone(),
            printed: c.printed,
            median_rmse_um: c.median_um,
            quartiles_um: c.quartiles_um,
            success_percent: c.success_percent,
            evaluations_to_1_percent: c.evaluations_to_1_percent,
        }
    }
}
