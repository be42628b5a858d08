//! Reproduction of the source article: its experiments on the simulated bench, its claims tested.
//!
//! The article's data are not public, so [`reproduce`] runs its excitations (1 Hz loop, 1–100 Hz sweep, sines
//! of 10, 20, 50 and 100 Hz) on [`hysteron_rig`], whose default plant lies outside the model class, and
//! identifies the article's models by its procedure. Only rankings and ratios are compared with the
//! [`printed`] numbers, never absolute values.
//!
//! In the order of the article: [`LoopStudy`] (Fig. 1), [`OptimizerStudy`] (Fig. 6, Table 1), [`StaticStudy`]
//! (Fig. 7, Table 2), [`ModelStudy`] (Eq. 13, Table 3, Figs. 8–11). Beyond the article: [`Contradictions`]
//! computes what its printed numbers imply about each other, [`Recovery`] identifies Table 2 and Eq. 13 as
//! the truth by the two-step procedure, [`Claim`]s are judged by the computed numbers.
//!
//! Results are plain data; they depend on [`Plan`] alone, not on the number of threads.

mod claims;
mod contradictions;
mod error;
mod loops;
mod measurements;
mod models;
pub mod optimizer_study;
mod optimizers;
pub mod page;
mod plan;
pub mod printed;
mod progress;
mod recovery;
mod static_block;
mod summary;

pub use claims::{Claim, Verdict};
pub use contradictions::{BehindTheLoop, Contradictions};
pub use error::ArticleError;
pub use loops::{LoopAt, LoopStudy};
pub use models::{Eq13, ModelFit, ModelKind, ModelStudy, SineCurves, SineScore};
pub use optimizers::{Contender, OptimizerStudy, quantile};
pub use plan::Plan;
pub use recovery::{RecoveredBlocks, Recovery, RecoveryCase};
pub use static_block::{StaticParameters, StaticStudy};
pub use summary::{StaticRow, Summary, Table1Row};

use hysteron_identify::Watch;
use measurements::Measurements;
use progress::Stages;
use serde::{Deserialize, Serialize};

/// Everything that was computed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reproduction {
    /// Plan of the reproduction.
    pub plan: Plan,
    /// One-line description of the simulated plant.
    pub bench: String,
    /// Figure 1: loops against frequency.
    pub loops: LoopStudy,
    /// Table 1 and Figure 6.
    pub optimizers: OptimizerStudy,
    /// Table 2 and Figure 7.
    pub static_block: StaticStudy,
    /// Eq. 13, Table 3 and Figures 8–11.
    pub models: ModelStudy,
    /// Checks of the printed numbers against each other.
    pub contradictions: Contradictions,
    /// Table 2 and Eq. 13 as the truth.
    pub recovery: Recovery,
    /// The article's claims, judged.
    pub claims: Vec<Claim>,
}

/// Runs the whole reproduction in the current `rayon` pool.
///
/// # Errors
/// [`ArticleError::Stopped`] if it was stopped; otherwise what failed, in the order of the work.
pub fn reproduce(plan: &Plan, watch: &Watch<'_>) -> Result<Reproduction, ArticleError> {
    plan.validate()?;
    let stages = &Stages::new(watch);
    let bench = Measurements::take(plan, stages)?;
    let loops = LoopStudy::of(&bench)?;
    let optimizers = OptimizerStudy::run(plan, &bench, stages)?;
    let (static_block, models) = models::identify(plan, &bench, stages)?;
    let contradictions = Contradictions::compute()?;
    let recovery = Recovery::run(plan, stages)?;
    let claims = claims::judge(&loops, &optimizers, &models);
    Ok(Reproduction {
        plan: plan.clone(),
        bench: bench.plant,
        loops,
        optimizers,
        static_block,
        models,
        contradictions,
        recovery,
        claims,
    })
}
