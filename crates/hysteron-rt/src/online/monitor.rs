//! Misfit detection by cumulative sums of the log-likelihood ratio of normalised residuals.

use super::{SampleError, clamp};
use crate::ParameterError;
use crate::real::Real;

/// Changes a monitor detects, and its false-alarm rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MonitorSettings<T> {
    /// Shift δ > 0 of the mean to detect soonest, in standard deviations, of either sign; `None`: not
    /// monitored.
    pub shift: Option<T>,
    /// Ratio κ > 1 of standard deviations to detect soonest; `None`: not monitored. It detects a wrong gain,
    /// whose residual under an alternating drive has zero mean.
    pub spread: Option<T>,
    /// Mean number of samples from start or reset to a false alarm: at least this, above 1.
    pub run_length: T,
    /// Fewest samples that raise an alarm: with 1 a single outlier may.
    pub fewest: u16,
}

/// Kind of misfit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Misfit {
    /// The residuals lie above zero: the output exceeds the model.
    Above,
    /// The residuals lie below zero.
    Below,
    /// The residuals scatter more than they should.
    Spread,
}

/// Cumulative sums (CUSUM) of the log-likelihood ratios of a shift of ±δ and of κ times the spread against
/// standard-normal residuals r:
///
/// ```text
/// S± ← max(0, S± ± δr − δ²/2),   S ← max(0, S + (1 − κ⁻²)r²/2 − ln κ),
/// alarm where a sum exceeds h = ln(c·L)
/// ```
///
/// c sums are watched (2 for a shift, 1 for a spread). For independent standard-normal r the mean number of
/// samples to a false alarm is at least L, the run length asked for: a sum that may begin at any sample
/// crosses h with a probability of at most e^−h, whence the bound (G. Lorden, *Ann. Math. Statist.* 42 (1971)
/// 1897–1908, Theorem 2, doi:10.1214/aoms/1177693055). The true one is longer, several times L. A change of
/// the design size is detected after about h/I samples on average, I the information of a sample: δ²/2, or
/// (κ² − 1)/2 − ln κ ([`Self::delay`]); no method with this run length is faster by more than a constant. An
/// increment is at most h/`fewest`, which only lengthens the run length.
///
/// The bound holds for residuals that are white with the stated deviation. The residual of a model that is
/// slightly wrong is neither; give it a deviation that covers this, or take every k-th residual.
///
/// Source of the sums: E. S. Page, *Biometrika* 41 (1954) 100–115, doi:10.1093/biomet/41.1-2.100.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitMonitor<T> {
    settings: MonitorSettings<T>,
    log_spread: T,
    threshold: T,
    most: T,
    sums: [T; 3],
}

impl<T: Real> FitMonitor<T> {
    /// Starts with sums of zero.
    ///
    /// # Errors
    /// [`ParameterError`]: no change to detect, a number that is not finite or out of its range.
    pub fn new(settings: MonitorSettings<T>) -> Result<Self, ParameterError<T>> {
        let MonitorSettings { shift, spread, run_length, fewest } = settings;
        let (zero, one) = (T::of(0.0), T::of(1.0));
        let refuse = |name, value, must| Err(ParameterError::Number { name, value, must });
        if let Some(shift) = shift.filter(|shift| !(*shift > zero && (*shift * *shift).is_finite())) {
            return refuse("the shift", shift, "positive and finite, its square too");
        }
        if let Some(spread) = spread.filter(|spread| !(*spread > one && (*spread * *spread).is_finite())) {
            return refuse("the ratio of spreads", spread, "above 1 and finite, its square too");
        }
        let charts = match (shift, spread) {
            (None, None) => return Err(ParameterError::NoChange),
            (None, Some(_)) => 1.0,
            (Some(_), None) => 2.0,
            (Some(_), Some(_)) => 3.0,
        };
        let threshold = run_length.ln() + T::of(charts).ln();
        if !(run_length > one && threshold.is_finite()) {
            return refuse("the run length", run_length, "above 1 and finite");
        }
        if fewest == 0 {
            return refuse("the fewest samples of an alarm", zero, "at least 1");
        }
        // Slightly above h/fewest, so that `fewest` outliers exceed h and fewer cannot.
        let most = threshold / T::of(f64::from(fewest)) * (one + T::of(4.0) * T::EPSILON);
        let log_spread = spread.map_or(zero, |spread| spread.ln());
        Ok(Self { settings, log_spread, threshold, most, sums: [zero; 3] })
    }

    /// Its settings.
    pub fn settings(&self) -> &MonitorSettings<T> {
        &self.settings
    }

    /// The threshold h of the sums.
    pub fn threshold(&self) -> T {
        self.threshold
    }

    /// The sums for above, below and spread.
    pub fn sums(&self) -> &[T; 3] {
        &self.sums
    }

    /// Mean detection delay of a change of the design size \[samples\], h/I (leading term for long run
    /// lengths); `None` where this change is not monitored.
    pub fn delay(&self, of: Misfit) -> Option<T> {
        let half = T::of(0.5);
        let information = match of {
            Misfit::Above | Misfit::Below => self.settings.shift.map(|shift| half * shift * shift),
            Misfit::Spread => {
                self.settings.spread.map(|spread| half * (spread * spread - T::of(1.0)) - self.log_spread)
            }
        };
        information.map(|information| self.threshold / information)
    }

    /// Updates the sums by one normalised residual r ([`crate::Residual::normalised`]). The alarm lasts while
    /// a sum exceeds h: until [`Self::reset`], or until the residuals have been small for long enough. Sums
    /// stop at 2h.
    ///
    /// # Errors
    /// [`SampleError::NotFinite`]: the sums are as they were.
    #[inline]
    pub fn step(&mut self, residual: T) -> Result<Option<Misfit>, SampleError> {
        if !residual.is_finite() {
            return Err(SampleError::NotFinite);
        }
        let (half, one) = (T::of(0.5), T::of(1.0));
        let [above, below, spread] = self.sums;
        if let Some(shift) = self.settings.shift {
            self.sums = [
                self.raised(above, shift * (residual - half * shift)),
                self.raised(below, shift * (-residual - half * shift)),
                spread,
            ];
        }
        if let Some(ratio) = self.settings.spread {
            let increment = half * (one - one / (ratio * ratio)) * residual * residual - self.log_spread;
            let [above, below, _] = self.sums;
            self.sums = [above, below, self.raised(spread, increment)];
        }
        Ok(self.alarm())
    }

    /// The sum that exceeds h by most, if one does.
    pub fn alarm(&self) -> Option<Misfit> {
        let mut found = None;
        let mut most = self.threshold;
        for (&sum, misfit) in self.sums.iter().zip([Misfit::Above, Misfit::Below, Misfit::Spread]) {
            if sum > most {
                (found, most) = (Some(misfit), sum);
            }
        }
        found
    }

    /// Resets the sums to 0, after an adaptation of the model or a handled alarm.
    pub fn reset(&mut self) {
        self.sums = [T::of(0.0); 3];
    }

    /// max(0, min(2h, sum + increment)); an increment that overflows counts as the greatest.
    #[inline(always)]
    fn raised(&self, sum: T, increment: T) -> T {
        let next = sum + if increment < self.most { increment } else { self.most };
        clamp(next, (T::of(0.0), T::of(2.0) * self.threshold))
    }
}
