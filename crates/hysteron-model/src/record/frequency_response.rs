//! A measured frequency response.

use super::Source;
use super::turning_points::median;
use crate::record::RecordError;
use hysteron_numeric::Complex64;
use nalgebra::Matrix4x3;

/// Fewest points for an estimate of scatter.
const FEWEST_POINTS: usize = 12;
/// Points whose scatter is combined.
const NEIGHBOURS: usize = 11;
/// A point that scatters by more than this share of its value is noise.
pub const NOISY: f64 = 0.3;

/// A complex frequency response G(2πi f) at measured frequencies, with its uncertainty where it is known.
#[derive(Clone, Debug, PartialEq)]
pub struct FrequencyResponse {
    /// Name for messages and reports.
    pub name: String,
    /// Frequencies \[Hz\], positive and strictly ascending.
    pub frequency_hz: Vec<f64>,
    /// Values, in `unit`.
    pub values: Vec<Complex64>,
    /// Standard deviation σ of each value, in `unit`: σ² = E|error|², half of it in the real and half in the
    /// imaginary part. `None`: unknown.
    pub std_dev: Option<Vec<f64>>,
    /// Output unit per input unit as in column headers (`um_per_V`); empty where not given.
    pub unit: String,
    /// File it was read from.
    pub source: Option<Source>,
}

impl FrequencyResponse {
    /// A checked response without uncertainty, unit or source.
    ///
    /// # Errors
    /// Those of [`Self::check`].
    pub fn new(name: &str, frequency_hz: Vec<f64>, values: Vec<Complex64>) -> Result<Self, RecordError> {
        let response = Self {
            name: name.to_owned(),
            frequency_hz,
            values,
            std_dev: None,
            unit: String::new(),
            source: None,
        };
        response.check()?;
        Ok(response)
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.frequency_hz.len()
    }

    /// True if there is no point.
    pub fn is_empty(&self) -> bool {
        self.frequency_hz.is_empty()
    }

    /// Lowest and highest frequency \[Hz\]; (0, 0) without points.
    pub fn range_hz(&self) -> (f64, f64) {
        match (self.frequency_hz.first(), self.frequency_hz.last()) {
            (Some(&low), Some(&high)) => (low, high),
            _ => (0.0, 0.0),
        }
    }

    /// Checks lengths, frequencies (positive, finite, strictly ascending), values (finite) and standard
    /// deviations (positive, finite).
    ///
    /// # Errors
    /// [`RecordError::ResponseLength`], [`RecordError::ResponseFrequency`], [`RecordError::ResponseValue`],
    /// [`RecordError::ResponseUncertainty`].
    pub fn check(&self) -> Result<(), RecordError> {
        let name = || self.name.clone();
        let lengths =
            [("value", Some(self.values.len())), ("uncertainty", self.std_dev.as_ref().map(Vec::len))];
        for (what, found) in lengths {
            if let Some(found) = found.filter(|&found| found != self.len()) {
                return Err(RecordError::ResponseLength { name: name(), what, found, expected: self.len() });
            }
        }
        let mut before = 0.0;
        for (i, (&f, value)) in self.frequency_hz.iter().zip(&self.values).enumerate() {
            if !(f > before && f.is_finite()) {
                return Err(RecordError::ResponseFrequency { name: name(), index: i + 1, value: f });
            }
            if !value.is_finite() {
                return Err(self.bad_value(i, "finite"));
            }
            before = f;
        }
        for (&f, &s) in self.frequency_hz.iter().zip(self.std_dev.iter().flatten()) {
            if !(s > 0.0 && s.is_finite()) {
                return Err(RecordError::ResponseUncertainty { name: name(), frequency_hz: f, found: s });
            }
        }
        Ok(())
    }

    #[doc(hidden)]
    pub fn bad_value(&self, index: usize, wanted: &'static str) -> RecordError {
        RecordError::ResponseValue {
            name: self.name.clone(),
            frequency_hz: self.frequency_hz.get(index).copied().unwrap_or(f64::NAN),
            found: self.values.get(index).map(ToString::to_string).unwrap_or_default(),
            wanted,
        }
    }

    /// The points with `low_hz` ≤ f ≤ `high_hz`.
    #[must_use]
    pub fn band(&self, low_hz: f64, high_hz: f64) -> Self {
        let from = self.frequency_hz.partition_point(|&f| f < low_hz);
        let to = self.frequency_hz.partition_point(|&f| f <= high_hz).max(from);
        Self {
            frequency_hz: self.frequency_hz[from..to].to_vec(),
            values: self.values[from..to].to_vec(),
            std_dev: self.std_dev.as_ref().map(|s| s[from..to].to_vec()),
            ..self.clone()
        }
    }

    /// Scatter of each point about its neighbours: |error| of a local quadratic in ln f through the two
    /// points on either side, over that from noise of unit deviation, the median of eleven such (of a
    /// Rayleigh distribution, whose median is √(ln 2) σ). An estimate of the noise where the response is
    /// smooth over a few points; larger at a resonance that only few points show.
    pub fn scatter(&self) -> Vec<f64> {
        let x: Vec<f64> = self.frequency_hz.iter().map(|f| f.ln()).collect();
        let n = self.len();
        if n < FEWEST_POINTS {
            return vec![0.0; n];
        }
        let mut off: Vec<f64> = (2..n - 2)
            .map(|i| {
                let neighbours = [i - 2, i - 1, i + 1, i + 2];
                let at = Matrix4x3::from_fn(|row, power| (x[neighbours[row]] - x[i]).powi(power as i32));
                // The value at x_i is the constant of the polynomial: the first row of the pseudo-inverse.
                let Ok(inverse) = at.pseudo_inverse(1e-12) else { return 0.0 };
                let weights = inverse.row(0);
                let value: Complex64 = weights.iter().zip(neighbours).map(|(w, k)| self.values[k] * *w).sum();
                (self.values[i] - value).norm() / (1.0 + weights.norm_squared()).sqrt()
            })
            .collect();
        off.splice(0..0, [off[0]; 2]);
        off.extend([off[off.len() - 1]; 2]);
        let reach = NEIGHBOURS / 2;
        let middle = |i: usize| median(off[i.saturating_sub(reach)..(i + reach + 1).min(n)].to_vec());
        (0..n).map(|i| middle(i) / 2f64.ln().sqrt()).collect()
    }

    /// Band of the points above the noise: without those at either end that scatter by more than 30 % of
    /// their value. `None` where that excludes nothing, where the uncertainty is known, or where fewer than
    /// 12 points remain.
    pub fn band_above_noise(&self) -> Option<(f64, f64)> {
        if self.std_dev.is_some() {
            return None;
        }
        let clear: Vec<bool> =
            self.scatter().iter().zip(&self.values).map(|(s, g)| *s <= NOISY * g.norm()).collect();
        // An end is noise up to the last noisy point before as many clear ones as are combined.
        let end = |flags: &mut dyn Iterator<Item = bool>| {
            let (mut run, mut cut) = (0, 0);
            for (k, clear) in flags.enumerate() {
                (run, cut) = if clear { (run + 1, cut) } else { (0, k + 1) };
                if run == NEIGHBOURS {
                    break;
                }
            }
            cut
        };
        let first = end(&mut clear.iter().copied());
        let last = self.len() - end(&mut clear.iter().rev().copied());
        let left = last.saturating_sub(first);
        (left >= FEWEST_POINTS && left < self.len())
            .then(|| (self.frequency_hz[first], self.frequency_hz[last - 1]))
    }

    /// This response over another at the same frequencies, e.g. stage over amplifier voltage from two
    /// responses to one command. Independent uncertainties are combined to first order; where only one is
    /// known it is used alone.
    ///
    /// # Errors
    /// [`RecordError::OtherFrequencies`]; [`RecordError::ResponseValue`] for a zero divisor.
    pub fn over(&self, under: &Self) -> Result<Self, RecordError> {
        if self.frequency_hz != under.frequency_hz {
            let (over, under) = (self.name.clone(), under.name.clone());
            return Err(RecordError::OtherFrequencies { over, under });
        }
        if let Some(index) = under.values.iter().position(|v| *v == Complex64::ZERO) {
            return Err(under.bad_value(index, "a divisor"));
        }
        let values: Vec<Complex64> = self.values.iter().zip(&under.values).map(|(a, b)| a / b).collect();
        let relative = |response: &Self, i: usize| {
            response.std_dev.as_ref().map_or(0.0, |s| s[i] / response.values[i].norm())
        };
        let std_dev = (self.std_dev.is_some() || under.std_dev.is_some())
            .then(|| {
                let of = |(i, v): (usize, &Complex64)| {
                    let own = self.std_dev.as_ref().map_or(0.0, |s| s[i] / under.values[i].norm());
                    own.hypot(v.norm() * relative(under, i))
                };
                values.iter().enumerate().map(of).collect::<Vec<f64>>()
            })
            // A zero numerator whose divisor alone is uncertain has no uncertainty to first order.
            .filter(|s| s.iter().all(|s| *s > 0.0));
        let unit = match (self.unit.split_once("_per_"), under.unit.split_once("_per_")) {
            (Some((a, c)), Some((b, d))) if c == d => format!("{a}_per_{b}"),
            _ => String::new(),
        };
        let ratio = Self {
            name: format!("{} over {}", self.name, under.name),
            frequency_hz: self.frequency_hz.clone(),
            values,
            std_dev,
            unit,
            source: self.source.clone(),
        };
        ratio.check()?;
        Ok(ratio)
    }

    /// Phase \[°\], unwrapped from the lowest frequency on.
    pub fn phase_deg(&self) -> Vec<f64> {
        unwrapped_phase_deg(&self.values)
    }
}

/// Phases \[°\] of successive values without jumps of more than half a turn.
pub fn unwrapped_phase_deg(values: &[Complex64]) -> Vec<f64> {
    let mut phases: Vec<f64> = Vec::with_capacity(values.len());
    for value in values {
        let phase = value.arg().to_degrees();
        let turns = phases.last().map_or(0.0, |last| ((last - phase) / 360.0).round());
        phases.push(phase + 360.0 * turns);
    }
    phases
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    fn response(f: &[f64]) -> Result<FrequencyResponse, RecordError> {
        FrequencyResponse::new("g", f.to_vec(), f.iter().map(|&f| Complex64::new(f, -1.0)).collect())
    }

    #[test]
    fn unsound_responses_are_refused() {
        assert!(response(&[1.0, 2.0, 4.0]).is_ok());
        for bad in [&[0.0, 1.0][..], &[1.0, 1.0], &[2.0, 1.0], &[1.0, f64::NAN], &[1.0, f64::INFINITY]] {
            assert!(matches!(response(bad), Err(RecordError::ResponseFrequency { .. })), "{bad:?}");
        }
        let short = FrequencyResponse::new("g", vec![1.0, 2.0], vec![Complex64::ONE]);
        assert!(matches!(short, Err(RecordError::ResponseLength { found: 1, expected: 2, .. })));
        let infinite = FrequencyResponse::new("g", vec![1.0], vec![Complex64::new(f64::INFINITY, 0.0)]);
        assert!(matches!(infinite, Err(RecordError::ResponseValue { .. })));
        let mut zero = response(&[1.0]).unwrap();
        zero.std_dev = Some(vec![0.0]);
        assert!(matches!(zero.check(), Err(RecordError::ResponseUncertainty { .. })));
    }

    #[test]
    fn a_band_keeps_its_ends_and_a_quotient_divides_values_units_and_uncertainties() {
        let whole = response(&[1.0, 2.0, 3.0, 4.0]).unwrap();
        assert_eq!(whole.band(2.0, 3.0).frequency_hz, [2.0, 3.0]);
        assert!(whole.band(5.0, 1.0).is_empty());
        let mut a = response(&[1.0]).unwrap();
        (a.values, a.std_dev, a.unit) = (vec![Complex64::new(0.0, 8.0)], Some(vec![0.4]), "um_per_V".into());
        let mut b = a.clone();
        (b.values, b.std_dev, b.unit) = (vec![Complex64::new(4.0, 0.0)], Some(vec![0.12]), "mV_per_V".into());
        let ratio = a.over(&b).unwrap();
        assert_eq!((ratio.values[0], ratio.unit.as_str()), (Complex64::new(0.0, 2.0), "um_per_mV"));
        // Relative 5 % and 3 %, together √34 %.
        assert!((ratio.std_dev.unwrap()[0] - 0.02 * 34f64.sqrt()).abs() < 1e-15);
        assert!(a.over(&whole).is_err());
    }

    #[test]
    fn phase_is_unwrapped() {
        let values: Vec<Complex64> =
            (0..20).map(|k| Complex64::from_polar(1.0, -0.9 * f64::from(k))).collect();
        for (k, phase) in unwrapped_phase_deg(&values).iter().enumerate() {
            assert!((phase + (0.9 * k as f64).to_degrees()).abs() < 1e-9);
        }
    }

    /// A first-order lag of 100 Hz under noise of 0.01: the scatter is that noise, and beyond some kilohertz
    /// there is nothing else.
    #[test]
    fn scatter_is_the_noise_and_the_band_ends_where_it_drowns_the_response() {
        let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(3);
        let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
        let frequency_hz: Vec<f64> = (0..300).map(|k| 10f64.powf(f64::from(k) / 60.0)).collect();
        let value = |f: &f64| Complex64::ONE / Complex64::new(1.0, f / 100.0);
        let sigma = 0.01 / 2f64.sqrt();
        let noisy = |f: &f64| value(f) + Complex64::new(sigma * normal(), sigma * normal());
        let values = frequency_hz.iter().map(noisy).collect();
        let response = FrequencyResponse::new("lag", frequency_hz.clone(), values).unwrap();
        let scatter = response.scatter();
        let mean = scatter.iter().sum::<f64>() / 300.0;
        assert!((mean / 0.01 - 1.0).abs() < 0.1, "{mean}");
        let (low, high) = response.band_above_noise().unwrap();
        // 0.01 is 30 % of the magnitude at 3 kHz.
        assert!(low == 1.0 && (1500.0..6000.0).contains(&high), "{low} {high}");
        let clean =
            FrequencyResponse::new("lag", frequency_hz.clone(), frequency_hz.iter().map(value).collect());
        assert_eq!(clean.unwrap().band_above_noise(), None);
    }
}
