//! A stage of several axes to drive.

use crate::control::StageError;

/// A stage with amplifiers and sensors; a run begins with it at rest.
pub trait AxesStage: Sync {
    /// The stage in steady state at the voltages `rest_v`, driven through zero-order holds.
    ///
    /// # Errors
    /// [`StageError`]: a sample rate or voltages that the stage cannot take.
    fn at_rest(&self, sample_rate_hz: f64, rest_v: &[f64]) -> Result<Box<dyn AxesStageRun + '_>, StageError>;
}

/// One run of an [`AxesStage`], a period at a time.
pub trait AxesStageRun {
    /// Holds `drive_v` for one period; the sample is taken at its beginning.
    ///
    /// # Errors
    /// [`StageError`]: voltages that the stage cannot take.
    fn step(&mut self, drive_v: &[f64]) -> Result<(), StageError>;

    /// Readings of the sensors at the last sample \[µm\].
    fn reading_um(&self) -> &[f64];

    /// True displacements at the last sample \[µm\].
    fn true_um(&self) -> &[f64];
}
