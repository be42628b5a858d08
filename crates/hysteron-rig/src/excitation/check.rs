//! Checks of numbers, for one kind of waveform.

use crate::RigError;
/// Kind of the waveform whose parameters are checked; every method names the parameter and what is allowed.
pub(super) struct Check(pub &'static str);

impl Check {
    pub fn wrong(&self, parameter: &'static str, value: f64, expected: impl Into<String>) -> RigError {
        RigError::Waveform { waveform: self.0, parameter, value, expected: expected.into() }
    }

    pub fn finite(&self, parameter: &'static str, value: f64) -> Result<(), RigError> {
        if value.is_finite() { Ok(()) } else { Err(self.wrong(parameter, value, "a finite number")) }
    }

    pub fn positive(&self, parameter: &'static str, value: f64) -> Result<(), RigError> {
        if value.is_finite() && value > 0.0 {
            Ok(())
        } else {
            Err(self.wrong(parameter, value, "a finite number above 0"))
        }
    }

    pub fn not_negative(&self, parameter: &'static str, value: f64) -> Result<(), RigError> {
        self.at_least(parameter, value, 0.0)
    }

    pub fn at_least(&self, parameter: &'static str, value: f64, least: f64) -> Result<(), RigError> {
        if value.is_finite() && value >= least {
            Ok(())
        } else {
            Err(self.wrong(parameter, value, format!("a finite number, at least {least}")))
        }
    }

    /// Strictly between two bounds.
    pub fn between(&self, parameter: &'static str, value: f64, low: f64, high: f64) -> Result<(), RigError> {
        if value > low && value < high {
            Ok(())
        } else {
            Err(self.wrong(parameter, value, format!("above {low} and below {high}")))
        }
    }

    pub fn below_nyquist(&self, parameter: &'static str, value: f64, fs: f64) -> Result<(), RigError> {
        if value > 0.0 && value < 0.5 * fs {
            Ok(())
        } else {
            let nyquist = 0.5 * fs;
            Err(self.wrong(parameter, value, format!("above 0 and below half the sample rate, {nyquist} Hz")))
        }
    }

    pub fn parts(&self, parameter: &'static str, values: &[f64]) -> Result<(), RigError> {
        self.not_empty(parameter, values)?;
        match values.iter().find(|a| !(**a > 0.0 && **a <= 1.0)) {
            Some(&bad) => Err(self.wrong(parameter, bad, "parts of the range, each above 0 and at most 1")),
            None => Ok(()),
        }
    }

    pub fn not_empty<T>(&self, parameter: &'static str, values: &[T]) -> Result<(), RigError> {
        if values.is_empty() { Err(RigError::EmptyWaveform { waveform: self.0, parameter }) } else { Ok(()) }
    }

    /// A band below half the sample rate.
    pub fn band(&self, low_hz: f64, high_hz: f64, fs: f64) -> Result<(), RigError> {
        self.not_negative("low_hz", low_hz)?;
        self.below_nyquist("high_hz", high_hz, fs)?;
        if high_hz <= low_hz {
            return Err(self.wrong("high_hz", high_hz, format!("above low_hz = {low_hz}")));
        }
        Ok(())
    }

    /// At least `least` multiples of 1/period in the band.
    pub fn lines_in_band(
        &self,
        parameter: &'static str,
        (low_hz, high_hz): (f64, f64),
        period_s: f64,
        least: f64,
    ) -> Result<(), RigError> {
        let first = (low_hz * period_s).ceil().max(1.0);
        if (high_hz * period_s).floor() - first + 1.0 < least {
            return Err(self.wrong(
                parameter,
                period_s,
                format!(
                    "so long that {least} multiples of its inverse lie between {low_hz} Hz and {high_hz} Hz"
                ),
            ));
        }
        Ok(())
    }
}
