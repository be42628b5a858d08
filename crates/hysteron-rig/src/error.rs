//! Errors of a simulated bench or its drive.

use hysteron_numeric::display::{exact, short};
use thiserror::Error;

/// Why the simulated bench could not be run.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RigError {
    /// A parameter of the truth is outside its valid range.
    #[error("truth: {parameter} is {value}, expected {expected}", value = exact(*.value))]
    Parameter {
        /// Path of the field, as in the truth file.
        parameter: String,
        /// Its value.
        value: f64,
        /// Allowed values.
        expected: &'static str,
    },
    /// A list of the truth that must not be empty is empty.
    #[error("truth: {parameter} is empty, give at least one entry")]
    EmptyList {
        /// Path of the field, as in the truth file.
        parameter: &'static str,
    },
    /// A list of the truth is too long.
    #[error("truth: {parameter} has {count} entries, expected at most {most}")]
    TooMany {
        /// Path of the field, as in the truth file.
        parameter: &'static str,
        /// Its entries.
        count: usize,
        /// Most that are taken.
        most: usize,
    },
    /// A number of the plan is outside its valid range.
    #[error("plan: {parameter} is {value}, expected {expected}", value = exact(*.value))]
    Plan {
        /// Name of the field, as in the plan file.
        parameter: &'static str,
        /// Value found.
        value: f64,
        /// Allowed values.
        expected: &'static str,
    },
    /// The displacement is no finite number.
    #[error(
        "truth: the displacement at {} s is {value}: the plant cannot be computed",
        short(*.time_s),
        value = exact(*.value)
    )]
    NotFinite {
        /// Time \[s\].
        time_s: f64,
        /// The value.
        value: f64,
    },
    /// The numerator's highest order is above the denominator's.
    #[error(
        "truth: the transfer function is improper, numerator order {numerator_order} above denominator order \
         {denominator_order}",
        numerator_order = exact(*.numerator_order),
        denominator_order = exact(*.denominator_order)
    )]
    Improper {
        /// Highest order of the numerator.
        numerator_order: f64,
        /// Highest order of the denominator.
        denominator_order: f64,
    },
    /// The linear dynamics have a pole in the closed right half plane.
    #[error(
        "truth: the dynamics are unstable, pole at {re} + {im}i rad/s",
        re = exact(*.re),
        im = exact(*.im)
    )]
    Unstable {
        /// Real part \[rad/s\].
        re: f64,
        /// Imaginary part \[rad/s\].
        im: f64,
    },
    /// Poles and branch cut do not add up to the transfer function.
    #[error(
        "truth: the transfer function could not be split into poles and branch cut, relative error \
         {error:.1e} remains (repeated poles, or a pole on the negative real axis of a fractional plant)"
    )]
    Decomposition {
        /// Largest error over the checked frequencies, relative to the largest gain.
        error: f64,
    },
    /// The hysteresis state is no longer finite.
    #[error(
        "truth: the hysteresis state diverged at {} s, drive {} V (parameters outside the stable class)",
        short(*.time_s),
        short(*.drive_v)
    )]
    Diverged {
        /// Time \[s\].
        time_s: f64,
        /// Drive \[V\].
        drive_v: f64,
    },
    /// A drive that starts away from 0 V needs a finite static gain to be at rest there.
    #[error(
        "the drive starts at {drive_v} V, but the dynamics have no finite static gain; start at 0 V",
        drive_v = exact(*.drive_v)
    )]
    NoRest {
        /// First sample of the drive \[V\].
        drive_v: f64,
    },
    /// The drive waveform cannot be played.
    #[error("drive: {what} is {value}, expected {expected}", value = exact(*.value))]
    Drive {
        /// Quantity that is wrong.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Allowed values.
        expected: &'static str,
    },
    /// A linearly interpolating converter in a control loop, where the next sample is not yet known.
    #[error(
        "truth: the converter draws straight lines to samples that a controller does not know yet; set dac \
         to \"hold\""
    )]
    Ahead,
    /// A parameter of a waveform is outside its valid range.
    #[error("{waveform}: {parameter} is {value}, expected {expected}", value = exact(*.value))]
    Waveform {
        /// Kind of waveform.
        waveform: &'static str,
        /// Field of the specification.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// Allowed values.
        expected: String,
    },
    /// A list of a waveform that must not be empty is empty.
    #[error("{waveform}: {parameter} is empty, give at least one value")]
    EmptyWaveform {
        /// Kind of waveform.
        waveform: &'static str,
        /// Field of the specification.
        parameter: &'static str,
    },
    /// The waveform exceeds the maximum length.
    #[error(
        "{waveform}: {samples:.3e} samples asked for, at most {max} are made; lower the sample rate or the \
         duration"
    )]
    TooLong {
        /// Kind of waveform.
        waveform: &'static str,
        /// Samples it would take.
        samples: f64,
        /// Most samples made.
        max: usize,
    },
    /// A sample leaves the amplifier's voltage range.
    #[error(
        "sample {sample} at {} s is {} V, outside the amplifier's {low_v} V to {high_v} V; change \
         low_v/high_v of the waveform",
        short(*.time_s),
        short(*.value_v),
        low_v = exact(*.low_v),
        high_v = exact(*.high_v)
    )]
    Voltage {
        /// First offending sample.
        sample: usize,
        /// Its time \[s\].
        time_s: f64,
        /// Its value \[V\].
        value_v: f64,
        /// Lower limit \[V\].
        low_v: f64,
        /// Upper limit \[V\].
        high_v: f64,
    },
    /// The waveform rises or falls faster than the amplifier can.
    #[error(
        "from sample {sample} at {} s the drive moves at {} V/s, the amplifier allows {limit_v_per_s} V/s; \
         lower the frequency or the amplitude, or start softly",
        short(*.time_s),
        short(*.slew_v_per_s),
        limit_v_per_s = exact(*.limit_v_per_s)
    )]
    Slew {
        /// Sample at the start of the offending step.
        sample: usize,
        /// Its time \[s\].
        time_s: f64,
        /// Slew of that step \[V/s\], signed.
        slew_v_per_s: f64,
        /// Limit on its magnitude \[V/s\].
        limit_v_per_s: f64,
    },
    /// Charging the actuator's capacitance takes more current than the amplifier supplies.
    #[error(
        "from sample {sample} at {} s the actuator of {capacitance_f} F draws {} A, the amplifier gives \
         {limit_a} A; lower the frequency or the amplitude",
        short(*.time_s),
        short(*.current_a),
        capacitance_f = exact(*.capacitance_f),
        limit_a = exact(*.limit_a)
    )]
    Current {
        /// Sample at the start of the offending step.
        sample: usize,
        /// Its time \[s\].
        time_s: f64,
        /// Current C·du/dt \[A\], signed.
        current_a: f64,
        /// Limit on its magnitude \[A\].
        limit_a: f64,
        /// Capacitance of the actuator \[F\].
        capacitance_f: f64,
    },
    /// A limit of the amplifier is invalid.
    #[error("amplifier limit {parameter} is {value}, expected {expected}", value = exact(*.value))]
    Limit {
        /// Field of the limits.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// Allowed values.
        expected: &'static str,
    },
}
