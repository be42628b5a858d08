//! What can be wrong with a requested waveform.

use thiserror::Error;

use hysteron_numeric::display::short;

/// Why a drive waveform was refused.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ExcitationError {
    /// A parameter is outside what makes sense.
    #[error("{waveform}: {parameter} is {value}, expected {expected}")]
    Parameter {
        /// Kind of waveform.
        waveform: &'static str,
        /// Field of the specification.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        expected: String,
    },
    /// A list that must not be empty is empty.
    #[error("{waveform}: {parameter} is empty, give at least one value")]
    EmptyList {
        /// Kind of waveform.
        waveform: &'static str,
        /// Field of the specification.
        parameter: &'static str,
    },
    /// The waveform would be absurdly long.
    #[error(
        "{waveform}: {samples:.3e} samples asked for, at most {max} are made; lower the sample rate or the duration"
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
        "sample {sample} at {} s is {} V, outside the amplifier's {low_v} V to {high_v} V; change low_v/high_v of the waveform",
        short(*.time_s),
        short(*.value_v)
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
        short(*.slew_v_per_s)
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
    /// Charging the actuator's capacitance that fast takes more current than the amplifier has.
    #[error(
        "from sample {sample} at {} s the actuator of {capacitance_f} F draws {} A, the amplifier gives {limit_a} A; \
         lower the frequency or the amplitude",
        short(*.time_s),
        short(*.current_a)
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
    /// A limit itself makes no sense.
    #[error("amplifier limit {parameter} is {value}, expected {expected}")]
    Limit {
        /// Field of the limits.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        expected: &'static str,
    },
}
