//! Errors of a hysteresis block or its simulation.

use hysteron_rt::{ParameterError, SimulateError, StepError};
use thiserror::Error;

use hysteron_numeric::Stopped;
use hysteron_numeric::display::{exact, short};

/// A hysteresis block that cannot be built or simulated.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum HysteresisError {
    /// No polynomial coefficient.
    #[error("the polynomial of the hysteresis block is empty: give at least the linear coefficient")]
    EmptyPolynomial,
    /// A polynomial coefficient is infinite or not a number.
    #[error(
        "the coefficient of u^{power} is {value}: polynomial coefficients must be finite",
        value = exact(*.value)
    )]
    Coefficient {
        /// Power of u it belongs to.
        power: usize,
        /// Its value.
        value: f64,
    },
    /// A shape parameter is infinite or not a number.
    #[error("hysteresis parameter {name} is {value}: it must be finite", value = exact(*.value))]
    Parameter {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// n < 1.
    #[error("hysteresis exponent n is {n}: it must be at least 1", n = exact(*.n))]
    Exponent {
        /// The exponent given.
        n: f64,
    },
    /// The work was asked to stop.
    #[error("stopped before the end of the drive")]
    Stopped,
    /// A memory of an operator of another family.
    #[error("the memory that the record is to start with belongs to a hysteresis operator of another family")]
    Memory,
    /// The operator is rate dependent, and the time between samples is not known.
    #[error("this hysteresis depends on the rate of its input: it needs the time between samples")]
    Interval,
    /// The period of the steady state is not the whole drive.
    #[error(
        "the steady state of a hysteresis operator is that of its whole drive, {samples} samples, not of \
         {period_samples}"
    )]
    Period {
        /// Samples of the drive.
        samples: usize,
        /// Samples of the period requested.
        period_samples: usize,
    },
    /// The output does not have the length the input asks for.
    #[error("the output has {found} samples but {expected} are needed for this input")]
    Lengths {
        /// Samples the output must have.
        expected: usize,
        /// Samples it has.
        found: usize,
    },
    /// A voltage, or the state before the first sample, is infinite or not a number.
    #[error("drive sample {index} (or the state before it) is not finite: remove or mask such samples first")]
    Drive {
        /// Number of the sample, from 0.
        index: usize,
    },
    /// The hysteresis state runs away: parameters outside the bounded class.
    #[error(
        "the hysteresis state runs away at drive sample {index} ({cause}); keep β + γ > 0 and β − γ ≥ 0 for \
         α > 0, β − γ > 0 and β + γ ≥ 0 for α < 0"
    )]
    RunsAway {
        /// Number of the sample, from 0.
        index: usize,
        /// Message of the step.
        cause: StepError<f64>,
    },
    /// No periodic steady state was found.
    #[error(
        "no steady state after {periods} periods: z still changes by {change:e} a period; the record must be \
         a whole number of periods and the parameters in the bounded class"
    )]
    NotSettled {
        /// Periods simulated.
        periods: usize,
        /// Change of z over the last one \[µm\].
        change: f64,
    },
    /// The steady state of a period does not determine its own derivatives.
    #[error(
        "the steady state has no derivatives: a period multiplies a state difference by {slope}, which must \
         be less than 1; give the loop a shape with β' > |γ'|, or another start than the periodic one",
        slope = exact(*.slope)
    )]
    NotContracting {
        /// ∂ζ(end of the period)/∂ζ(its start).
        slope: f64,
    },
    /// The numbers of weights and thresholds differ.
    #[error("there are {thresholds} play thresholds but {weights} weights: give one weight a threshold")]
    PlayCount {
        /// Number of thresholds.
        thresholds: usize,
        /// Number of weights.
        weights: usize,
    },
    /// Thresholds of plays must be finite, positive and increasing.
    #[error(
        "play threshold {index} (from 0) is {value}: it must be finite and above {above}",
        value = exact(*.value),
        above = exact(*.above)
    )]
    Threshold {
        /// Number of the play, from 0.
        index: usize,
        /// Its threshold \[V\].
        value: f64,
        /// The threshold before it \[V\], 0 before the first.
        above: f64,
    },
    /// The weight of a play is infinite or not a number.
    #[error("the weight of play {index} (from 0) is {value}: it must be finite", value = exact(*.value))]
    Weight {
        /// Number of the play, from 0.
        index: usize,
        /// Its weight.
        value: f64,
    },
    /// The numbers of states and plays differ.
    #[error("there are {found} play states but {expected} plays: give one state a play")]
    PlayStates {
        /// Number of plays.
        expected: usize,
        /// States given.
        found: usize,
    },
    /// The states cannot result from any history of the voltage.
    #[error(
        "the play states have no common history: play {index} (from 0) is further from the one before it \
         than their thresholds differ; start from rest or from the states that a simulation left behind"
    )]
    PlayHistory {
        /// Number of the play, from 0.
        index: usize,
    },
    /// The output overflows.
    #[error("the output is not finite at drive sample {index}: the drive is far too large")]
    Overflow {
        /// Number of the sample, from 0.
        index: usize,
    },
    /// The closed-form inverse exists for a linear polynomial only.
    #[error(
        "the polynomial is of degree {degree}: the inverse has a closed form for a linear polynomial only; \
         invert move by move over the range of inputs needed"
    )]
    NotLinear {
        /// Its degree.
        degree: usize,
    },
    /// A branch of a model with a linear polynomial does not increase.
    #[error(
        "the model has no inverse: with its {plays} narrowest plays moving, the output moves by {slope} \
         times the input, which must be positive",
        slope = exact(*.slope)
    )]
    PartialSlope {
        /// Number of plays that move, from the narrowest.
        plays: usize,
        /// Slope of the branch \[µm/V\].
        slope: f64,
    },
    /// A branch of the model does not increase within the range of its inverse.
    #[error(
        "the model has no inverse over this range: at the input {u} a branch has the slope {slope}, which \
         must be positive beyond rounding; choose a range without this input or a polynomial and weights \
         that increase there",
        u = exact(*.u),
        slope = exact(*.slope)
    )]
    NotSteep {
        /// Voltage \[V\].
        u: f64,
        /// Least slope of a branch there \[µm/V\].
        slope: f64,
    },
    /// The range of voltages is empty.
    #[error(
        "the range from {} to {} is empty or not finite: give its lower end first",
        short(*low),
        short(*high)
    )]
    Range {
        /// Lower end \[V\].
        low: f64,
        /// Upper end \[V\].
        high: f64,
    },
    /// The device rests outside the range of its drive.
    #[error(
        "the device rests at the input {}, outside of the range of its drive, {} to {}",
        short(*rest),
        short(*low),
        short(*high)
    )]
    RestOutside {
        /// Where it rests \[V\].
        rest: f64,
        /// Lower end of the range \[V\].
        low: f64,
        /// Upper end \[V\].
        high: f64,
    },
    /// No voltage of the range gives the output.
    #[error(
        "no input of the range gives the output {v} of sample {index}: from where the plays stand it gives \
         {from} to {to}; ask for an output between these or allow a wider range",
        v = exact(*.v),
        from = exact(*.from),
        to = exact(*.to)
    )]
    OutOfReach {
        /// Number of the sample, from 0.
        index: usize,
        /// The output requested \[µm\].
        v: f64,
        /// Output at the lower end of the range \[µm\].
        from: f64,
        /// Output at its upper end \[µm\].
        to: f64,
    },
    /// The largest step of the drive is not positive.
    #[error(
        "the largest change of the drive from one sample to the next is {step}: it must be positive",
        step = exact(*.step)
    )]
    Step {
        /// The step \[V\].
        step: f64,
    },
    /// An output requested is infinite or not a number.
    #[error("the output wanted at sample {index} is not finite")]
    Wanted {
        /// Number of the sample, from 0.
        index: usize,
    },
    /// The output falls as the voltage rises.
    #[error(
        "the hysteresis has no inverse: on the move to sample {index} the output falls near the input {} as \
         the input rises; keep the drive away from there, or identify a family whose branches increase \
         (plays with weights of one sign do)",
        short(*u)
    )]
    NotIncreasing {
        /// Number of the sample, from 0.
        index: usize,
        /// Voltage \[V\].
        u: f64,
    },
    /// Up-sampling by 0.
    #[error("the up-sampling factor is 0: it must be at least 1")]
    Factor,
    /// The number of elements is out of range.
    #[error("{family} cannot have {found} elements: {allowed}")]
    Elements {
        /// Name of the family.
        family: &'static str,
        /// The number.
        found: usize,
        /// Allowed values.
        allowed: String,
    },
    /// The number of shape parameters is wrong.
    #[error("the shape has {found} parameters but this family has {expected}")]
    ShapeCount {
        /// Parameters of the family.
        expected: usize,
        /// Numbers given.
        found: usize,
    },
    /// A shape parameter or a number of the structure out of its range.
    #[error("{name} is {value}: it must be {must}", value = exact(*.value))]
    ShapeParameter {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Condition on the value.
        must: &'static str,
    },
    /// The envelopes leave no admissible state of a play.
    #[error(
        "at the input {u} the right envelope lies {by} above the left one, more than twice the narrowest \
         threshold {narrowest}: widen the thresholds or bring the envelopes together",
        u = exact(*.u),
        by = exact(*.by),
        narrowest = exact(*.narrowest)
    )]
    Envelopes {
        /// Voltage \[V\].
        u: f64,
        /// Right less left envelope.
        by: f64,
        /// Narrowest threshold.
        narrowest: f64,
    },
    /// The numbers of weights and columns differ.
    #[error("there are {columns} columns but {weights} weights: give one weight a column")]
    WeightCount {
        /// Columns of the family.
        columns: usize,
        /// Number of weights.
        weights: usize,
    },
    /// The weight of a column is infinite or not a number.
    #[error("the weight of column {index} (from 0) is {value}: it must be finite", value = exact(*.value))]
    ColumnWeight {
        /// Number of the column, from 0.
        index: usize,
        /// Its weight.
        value: f64,
    },
    /// The Fourier transform of the drive failed.
    #[error("band-limited interpolation of {samples} samples failed: {message}")]
    Fourier {
        /// Length of the transform.
        samples: usize,
        /// Message of the transform.
        message: String,
    },
}

impl From<Stopped> for HysteresisError {
    fn from(_: Stopped) -> Self {
        Self::Stopped
    }
}

impl HysteresisError {
    /// This error at drive sample `index`.
    pub(super) fn at_sample(self, index: usize) -> Self {
        match self {
            Self::Drive { .. } => Self::Drive { index },
            Self::Overflow { .. } => Self::Overflow { index },
            Self::RunsAway { cause, .. } => Self::RunsAway { index, cause },
            other => other,
        }
    }
}

impl From<ParameterError<f64>> for HysteresisError {
    fn from(error: ParameterError<f64>) -> Self {
        match error {
            ParameterError::Exponent { n } => Self::Exponent { n },
            ParameterError::NotFinite { name, value } => Self::Parameter { name, value },
            ParameterError::Lengths { thresholds, weights } => Self::PlayCount { thresholds, weights },
            ParameterError::Threshold { index, value, above } => Self::Threshold { index, value, above },
            ParameterError::Weight { index, value } => Self::Weight { index, value },
            ParameterError::Number { name, value, must } => Self::ShapeParameter { name, value, must },
            _ => Self::Parameter { name: "n", value: f64::NAN },
        }
    }
}

impl From<SimulateError<f64>> for HysteresisError {
    fn from(error: SimulateError<f64>) -> Self {
        match error {
            SimulateError::Lengths { expected, found } => Self::Lengths { expected, found },
            SimulateError::Step { index, cause: StepError::NotFinite } => Self::Drive { index },
            SimulateError::Step { index, cause } => Self::RunsAway { index, cause },
            _ => Self::Drive { index: 0 },
        }
    }
}
