//! Recovery of the article's own Table 2 and Eq. 13, as the truth, from noise-free data.
//!
//! Each block is identified alone from its own data, then both by the two-step procedure, where the 1 Hz loop
//! has passed through the dynamics. Fits are by least squares, so the result is the minimum of the criterion,
//! independent of a random search.

use super::measurements::record;
use super::models::{Eq13, eq13};
use super::printed::{EQ_13, TABLE_2};
use super::progress::{Stage, Stages};
use super::static_block::{StaticParameters, article_options};
use super::{ArticleError, Plan};
use hysteron_identify::{
    CampaignRecord, Choice, Demands, IdentifyError, Options, RecordRole, Watch, identify,
};
use hysteron_model::dynamics::{Dynamics, Scheme};
use hysteron_rig::excitation::SweepLaw;
use hysteron_rig::{CampaignPlan, CampaignRun, Plant, PowerTerm, RigRun, Role, Truth, run_campaign};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Two-step identification of the article's own plant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Recovery {
    /// The truth: Table 2.
    pub static_truth: StaticParameters,
    /// The truth: Eq. 13.
    pub dynamic_truth: Eq13,
    /// The cases.
    pub cases: Vec<RecoveredBlocks>,
}

/// Interpretation of the article under which the blocks are recovered.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecoveryCase {
    /// The 1 Hz loop is that of the static block alone; otherwise the whole plant's.
    pub blocks_apart: bool,
    /// A sensor offset is estimated with each record; otherwise it is zero, as in Eq. 1.
    pub offset_estimated: bool,
    /// Periods of the 1 Hz loop, from rest.
    pub loop_periods: usize,
    /// Law of the sweep: linear (else logarithmic).
    pub linear_sweep: bool,
    /// Scheme by which the dynamic block is simulated in the fit.
    pub scheme: Scheme,
    /// The interpretation that reproduces the prototype's figures.
    pub prototype: bool,
}

/// Blocks recovered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecoveredBlocks {
    /// Reading.
    pub case: RecoveryCase,
    /// Static block.
    pub static_block: StaticParameters,
    /// Dynamic block.
    pub dynamic_block: Eq13,
    /// RMSE on the 1 Hz loop that the static block was fitted to \[µm\].
    pub loop_rmse_um: f64,
    /// RMSE on the sweep that the dynamic block was fitted to \[µm\].
    pub sweep_rmse_um: f64,
}

impl RecoveredBlocks {
    /// Relative bias of x, y, α, β, γ \[%\].
    pub fn static_bias_percent(&self) -> [f64; 5] {
        let (f, t) = (&self.static_block, StaticParameters::printed(&TABLE_2));
        [(f.x, t.x), (f.y, t.y), (f.alpha, t.alpha), (f.beta, t.beta), (f.gamma, t.gamma)].map(relative)
    }

    /// Relative bias of b, c₁, c₀ \[%\].
    pub fn coefficient_bias_percent(&self) -> [f64; 3] {
        let f = &self.dynamic_block;
        [(f.b, EQ_13.b), (f.c1, EQ_13.c1), (f.c0, EQ_13.c0)].map(relative)
    }

    /// Bias of α₂ and α₁.
    pub fn order_bias(&self) -> [f64; 2] {
        [self.dynamic_block.alpha2 - EQ_13.alpha2, self.dynamic_block.alpha1 - EQ_13.alpha1]
    }
}

fn relative((found, truth): (f64, f64)) -> f64 {
    100.0 * (found / truth - 1.0)
}

impl RecoveryCase {
    /// The cases, each block from its own data first.
    fn all() -> Vec<Self> {
        let apart = Self {
            blocks_apart: true,
            offset_estimated: false,
            loop_periods: 3,
            linear_sweep: true,
            scheme: Scheme::Tustin,
            prototype: false,
        };
        let gl = Scheme::GrunwaldLetnikov;
        let together = Self { blocks_apart: false, ..apart };
        vec![
            apart,
            Self { scheme: gl, ..apart },
            Self { prototype: true, ..together },
            Self { offset_estimated: true, ..together },
            Self { linear_sweep: false, ..together },
            Self { loop_periods: 2, ..together },
            Self { scheme: gl, ..together },
        ]
    }

    fn recover(self, plan: &Plan) -> Result<RecoveredBlocks, ArticleError> {
        let campaign = CampaignPlan {
            loop_periods: self.loop_periods as f64,
            sweep_law: if self.linear_sweep { SweepLaw::Linear } else { SweepLaw::Logarithmic },
            validation_hz: Vec::new(),
            ..plan.campaign()
        };
        let whole = Truth::article().with_ideal_sensor();
        let runs = run_campaign(&whole, &campaign, plan.seed)?;
        let sweep = find(&runs, Role::Sweep)?;
        let the_loop = if self.blocks_apart {
            let short = CampaignPlan { sweep_s: 0.1, ..campaign };
            record(
                find(&run_campaign(&without_dynamics(whole), &short, plan.seed)?, Role::QuasiStatic)?,
                plan.loop_decimation,
            )?
        } else {
            record(find(&runs, Role::QuasiStatic)?, plan.loop_decimation)?
        };
        let records = [
            CampaignRecord { data: the_loop, role: Some(RecordRole::QuasiStatic) },
            CampaignRecord { data: record(sweep, 1)?, role: Some(RecordRole::Dynamic) },
        ];
        let article = article_options(plan);
        let options = Options {
            algorithm: None,
            scheme: Choice::Given(self.scheme),
            demands: if self.offset_estimated { Demands::default() } else { article.demands.clone() },
            ..article
        };
        let failed = |source: IdentifyError| ArticleError::Identify {
            model: "article's own plant".into(),
            source: source.into(),
        };
        let found = identify(&records, &options, &Watch::silent(), None).map_err(failed)?;
        let Dynamics::Fractional(g) = &found.model.dynamics else { return Err(no_form()) };
        let cost = |i: usize| found.searches.get(i).map_or(f64::NAN, |s| s.outcome.cost);
        Ok(RecoveredBlocks {
            case: self,
            static_block: StaticParameters::of(&found.model.hysteresis),
            dynamic_block: eq13(g).ok_or_else(no_form)?,
            loop_rmse_um: cost(0),
            sweep_rmse_um: cost(1),
        })
    }
}

fn no_form() -> ArticleError {
    let source = IdentifyError::NoDynamicInformation {
        wanted: "fractional",
        because: "the fit has not the form of Eq. 13".into(),
    };
    ArticleError::Identify { model: "article's own plant".into(), source: source.into() }
}

fn find(runs: &[CampaignRun], role: Role) -> Result<&RigRun, ArticleError> {
    let found = runs.iter().find(|r| r.role == role).map(|r| &r.run);
    found.ok_or(ArticleError::Plan {
        setting: "campaign",
        value: runs.len() as f64,
        wanted: "a loop and a sweep",
    })
}

/// This bench with G = 1.
fn without_dynamics(mut truth: Truth) -> Truth {
    if let Plant::BoucWenFractional(plant) = &mut truth.plant {
        let one = vec![PowerTerm { coefficient: 1.0, order: 0.0 }];
        (plant.numerator, plant.denominator) = (one.clone(), one);
    }
    truth
}

impl Recovery {
    pub(super) fn run(plan: &Plan, stages: &Stages<'_, '_>) -> Result<Self, ArticleError> {
        let cases = RecoveryCase::all();
        stages.check(Stage::Recovery, 0.0, "")?;
        let done = std::sync::atomic::AtomicUsize::new(0);
        let cases: Vec<Result<RecoveredBlocks, ArticleError>> = cases
            .par_iter()
            .map(|case| {
                let found = case.recover(plan)?;
                let count = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
                stages.check(Stage::Recovery, count as f64 / cases.len() as f64, "")?;
                Ok(found)
            })
            .collect();
        Ok(Self {
            static_truth: StaticParameters::printed(&TABLE_2),
            dynamic_truth: EQ_13,
            cases: cases.into_iter().collect::<Result<_, _>>()?,
        })
    }
}
