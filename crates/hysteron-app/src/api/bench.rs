//! The simulated bench and drives.

use hysteron_rig::excitation::{ExcitationSpec, ExcitationSummary};
use hysteron_rig::{CampaignPlan, Truth};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Command, Curve};

/// Records to be made on the simulated bench.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BenchRequest {
    /// Folder in the workspace for the records; empty: `bench`.
    pub folder: String,
    /// True parameters.
    pub truth: Truth,
    /// Records of the campaign.
    pub plan: CampaignPlan,
    /// Seed of the noise.
    pub seed: u64,
}

/// Simulated records.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BenchMade {
    /// Identifiers of the records.
    pub records: Vec<String>,
    /// Samples in all.
    pub samples: usize,
    /// Command that makes the same.
    pub command: Command,
}

/// A drive to be made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DriveRequest {
    /// Waveform, range, sample rate.
    pub specification: ExcitationSpec,
    /// File to write; left out: it is only drawn.
    #[serde(default)]
    pub save: Option<String>,
    /// Width of the drawing in pixels.
    #[serde(default)]
    pub pixels: Option<usize>,
}

/// A drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DriveMade {
    /// Length, range, slew rate, excited lines.
    pub summary: ExcitationSummary,
    /// Drive over time.
    pub drive: Curve,
    /// File that was written.
    pub file: Option<String>,
}
