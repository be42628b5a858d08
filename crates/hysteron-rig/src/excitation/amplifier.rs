//! Limits of the amplifier.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Excitation;
use crate::RigError;

/// Limits of the drive amplifier at its command input or at its output, whichever the waveform describes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AmplifierLimits {
    /// Lowest voltage \[V\].
    pub low_v: f64,
    /// Highest voltage \[V\].
    pub high_v: f64,
    /// Largest |du/dt| \[V/s\].
    #[serde(default)]
    pub slew_v_per_s: Option<f64>,
    /// Largest output current \[A\]; needs `capacitance_f`.
    #[serde(default)]
    pub current_a: Option<f64>,
    /// Capacitance of the actuator \[F\], referred to the voltage of the waveform.
    #[serde(default)]
    pub capacitance_f: Option<f64>,
}

impl Default for AmplifierLimits {
    /// No limits.
    fn default() -> Self {
        Self {
            low_v: -BEYOND_EVERY_AMPLIFIER_V,
            high_v: BEYOND_EVERY_AMPLIFIER_V,
            slew_v_per_s: None,
            current_a: None,
            capacitance_f: None,
        }
    }
}

const BEYOND_EVERY_AMPLIFIER_V: f64 = 1e12;
/// Voltages may exceed a limit by this fraction of the range: rounding of offset plus amplitude.
const ROUNDING: f64 = 1e-12;

impl AmplifierLimits {
    /// Checks every sample and every step of a waveform; the step from 0 V (rest) to the first sample is left
    /// to the experimenter and not checked.
    ///
    /// # Errors
    /// [`RigError::Voltage`], [`RigError::Slew`] or [`RigError::Current`] at the first sample that violates a
    /// limit; [`RigError::Limit`] for invalid limits.
    pub fn check(&self, excitation: &Excitation) -> Result<(), RigError> {
        self.validate()?;
        let fs = excitation.sample_rate_hz;
        let slack = ROUNDING * (self.high_v - self.low_v);
        let slew_limit = self.slew_v_per_s.unwrap_or(f64::INFINITY);
        let current = self.current_a.zip(self.capacitance_f);
        let samples = &excitation.samples_v;
        for (k, &u) in samples.iter().enumerate() {
            let time_s = k as f64 / fs;
            if !(self.low_v - slack..=self.high_v + slack).contains(&u) {
                let (low_v, high_v) = (self.low_v, self.high_v);
                return Err(RigError::Voltage { sample: k, time_s, value_v: u, low_v, high_v });
            }
            let Some(&next) = samples.get(k + 1) else { break };
            let slew = (next - u) * fs;
            if slew.abs() > slew_limit * (1.0 + ROUNDING) {
                return Err(RigError::Slew {
                    sample: k,
                    time_s,
                    slew_v_per_s: slew,
                    limit_v_per_s: slew_limit,
                });
            }
            if let Some((limit_a, capacitance_f)) = current
                && (capacitance_f * slew).abs() > limit_a * (1.0 + ROUNDING)
            {
                let current_a = capacitance_f * slew;
                return Err(RigError::Current { sample: k, time_s, current_a, limit_a, capacitance_f });
            }
        }
        Ok(())
    }

    fn validate(&self) -> Result<(), RigError> {
        let wrong = |parameter, value, expected| RigError::Limit { parameter, value, expected };
        if !self.low_v.is_finite() {
            return Err(wrong("low_v", self.low_v, "a finite voltage"));
        }
        if !(self.high_v.is_finite() && self.high_v > self.low_v) {
            return Err(wrong("high_v", self.high_v, "a finite voltage above low_v"));
        }
        let optional = [
            ("slew_v_per_s", self.slew_v_per_s),
            ("current_a", self.current_a),
            ("capacitance_f", self.capacitance_f),
        ];
        for (name, value) in optional {
            if let Some(x) = value
                && !(x.is_finite() && x > 0.0)
            {
                return Err(wrong(name, x, "a finite number above 0"));
            }
        }
        if let (Some(current_a), None) = (self.current_a, self.capacitance_f) {
            return Err(wrong("current_a", current_a, "capacitance_f beside it: the current is C·du/dt"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn waveform(samples_v: Vec<f64>) -> Excitation {
        Excitation {
            name: "test".into(),
            description: String::new(),
            samples_v,
            sample_rate_hz: 1000.0,
            lead_in_samples: 0,
            lead_out_samples: 0,
            period_samples: None,
            excited_hz: vec![],
            odd_detection_hz: vec![],
            even_detection_hz: vec![],
        }
    }

    fn limits() -> AmplifierLimits {
        AmplifierLimits {
            low_v: -1.0,
            high_v: 10.0,
            slew_v_per_s: Some(2000.0),
            current_a: None,
            capacitance_f: None,
        }
    }

    #[test]
    fn names_the_first_sample_outside_the_voltage_range() {
        let err = limits().check(&waveform(vec![0.0, 1.0, 2.0, -1.5, -2.0])).unwrap_err();
        let RigError::Slew { sample: 2, .. } = err else { panic!("{err}") };
        let err = limits().check(&waveform(vec![0.0, -1.0, -1.5, -2.0])).unwrap_err();
        assert_eq!(
            err,
            RigError::Voltage { sample: 2, time_s: 0.002, value_v: -1.5, low_v: -1.0, high_v: 10.0 }
        );
    }

    #[test]
    fn slew_is_the_difference_times_the_sample_rate() {
        let w = waveform(vec![0.0, 1.5, 4.0, 3.0]);
        assert_eq!(w.max_slew_v_per_s(), 2500.0);
        let err = limits().check(&w).unwrap_err();
        assert_eq!(
            err,
            RigError::Slew { sample: 1, time_s: 0.001, slew_v_per_s: 2500.0, limit_v_per_s: 2000.0 }
        );
        assert!(limits().check(&waveform(vec![0.0, 2.0, 0.0, 2.0])).is_ok(), "exactly at the limit");
    }

    #[test]
    fn current_is_capacitance_times_slew() {
        let limits = AmplifierLimits {
            slew_v_per_s: None,
            current_a: Some(0.01),
            capacitance_f: Some(6e-6),
            ..limits()
        };
        assert!(limits.check(&waveform(vec![0.0, 1.5])).is_ok());
        let err = limits.check(&waveform(vec![0.0, 1.5, -0.5])).unwrap_err();
        let RigError::Current { sample: 1, current_a, .. } = err else { panic!("{err}") };
        assert!((current_a + 0.012).abs() < 1e-15);
    }

    #[test]
    fn limits_that_make_no_sense_are_refused_by_name() {
        let refuse = |l: AmplifierLimits, name| match l.check(&waveform(vec![0.0])) {
            Err(RigError::Limit { parameter, .. }) => assert_eq!(parameter, name),
            other => panic!("{other:?}"),
        };
        refuse(AmplifierLimits { high_v: -1.0, ..limits() }, "high_v");
        refuse(AmplifierLimits { low_v: f64::NAN, ..limits() }, "low_v");
        refuse(AmplifierLimits { slew_v_per_s: Some(0.0), ..limits() }, "slew_v_per_s");
        refuse(AmplifierLimits { current_a: Some(0.1), ..limits() }, "current_a");
    }

    #[test]
    fn a_waveform_that_is_not_a_number_is_refused() {
        let err = limits().check(&waveform(vec![0.0, f64::NAN])).unwrap_err();
        assert!(matches!(err, RigError::Voltage { sample: 1, .. }), "{err}");
    }
}
