//! Regularised inverse of a response for a reference known ahead: accurate up to a bandwidth, quiet above it.
//!
//! A plant that lags cannot be inverted at every frequency: at half the sample rate its gain is nearly 0, and
//! its plain inverse rings there (that of the Tustin form with a pole at −1). The input v minimises
//!
//! Σ |r − P v|² + λ Σ |Δ²v|²
//!
//! with P the plant from held samples to samples, delay included, Δ² the second difference. The minimiser is
//! W r, W = P̄/(|P|² + λ|1 − z|⁴), which is non-causal: r must be known ahead. The relative error is 1 − P W
//! = λ|1 − z|⁴/(|P|² + λ|1 − z|⁴), a real number between 0 and 1 at every frequency: no phase error.

use std::f64::consts::PI;

use super::{Arx, DynamicsError, Response, SimulationPlan};
use crate::dynamics_error::check_length;
use hysteron_numeric::Complex64;

/// Specification of an inverse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InverseAim {
    /// Tracking bandwidth \[Hz\], below half the sample rate.
    pub bandwidth_hz: f64,
    /// Relative error there; below, it falls with the fourth power of the frequency, or faster.
    pub error: f64,
}

/// An inverse on the frequencies of its plan.
#[derive(Clone, Debug)]
pub struct Inverse {
    /// W, for [`SimulationPlan::apply`].
    pub response: Response,
    /// λ.
    pub weight: f64,
    /// Largest |W|.
    pub peak: f64,
    /// Root mean square of |W| over all frequencies: the gain of white noise from r to v.
    pub noise_gain: f64,
}

impl SimulationPlan {
    /// The response of an ARX block with a delay \[s\], band-limited between samples.
    ///
    /// # Errors
    /// [`DynamicsError::Length`] for a response of another plan; [`DynamicsError::Parameter`] for a delay
    /// that is negative or not finite.
    pub fn arx_response(
        &self,
        arx: &Arx,
        delay_s: f64,
        response: &mut Response,
    ) -> Result<(), DynamicsError> {
        check_length("response", response.values.len(), self.bins())?;
        if !(delay_s.is_finite() && delay_s >= 0.0) {
            return Err(DynamicsError::Parameter {
                name: "delay [s]",
                value: delay_s,
                allowed: "finite and not negative",
            });
        }
        let samples = delay_s * self.sample_rate_hz;
        for (bin, value) in response.values.iter_mut().enumerate() {
            let log_z = Complex64::new(-self.damping, -self.angle(bin));
            *value = arx.response_at(log_z.exp()) * (log_z * samples).exp();
        }
        self.make_ends_real(&mut response.values);
        response.differentiated = false;
        Ok(())
    }

    /// The regularised inverse of a response. λ gives the relative error `aim.error` at the bandwidth.
    ///
    /// # Errors
    /// [`DynamicsError::Length`] for a response of another plan; [`DynamicsError::Bandwidth`] for a bandwidth
    /// that is not between 0 and half the sample rate, or where the plant's gain is 0;
    /// [`DynamicsError::Parameter`] for an error that is not between 0 and 1.
    pub fn inverse(&self, plant: &Response, aim: InverseAim) -> Result<Inverse, DynamicsError> {
        check_length("response", plant.values.len(), self.bins())?;
        let edge = self.edge(aim)?;
        let InverseAim { bandwidth_hz, error } = aim;
        let refused = DynamicsError::Bandwidth { bandwidth_hz, highest_hz: 0.5 * self.sample_rate_hz };
        let length = self.transform_length() as f64;
        let passed = plant.values.get(edge).map_or(0.0, |p| p.norm_sqr());
        let weight = error / (1.0 - error) * passed / self.roughness(edge);
        if !(weight > 0.0 && weight.is_finite()) {
            return Err(refused);
        }
        let mut response = Response { differentiated: false, ..plant.clone() };
        let (mut peak, mut sum) = (0.0_f64, 0.0);
        let last = response.values.len() - 1;
        for (bin, value) in response.values.iter_mut().enumerate() {
            *value = value.conj() / (value.norm_sqr() + weight * self.roughness(bin));
            let size = value.norm_sqr();
            peak = peak.max(size);
            // Each bin except the first and an even last one counts twice.
            sum += if bin == 0 || (bin == last && self.transform_length().is_multiple_of(2)) {
                size
            } else {
                2.0 * size
            };
        }
        self.make_ends_real(&mut response.values);
        Ok(Inverse { response, weight, peak: peak.sqrt(), noise_gain: (sum / length).sqrt() })
    }

    /// Bin of the bandwidth of a valid aim.
    pub(super) fn edge(
        &self,
        InverseAim { bandwidth_hz, error }: InverseAim,
    ) -> Result<usize, DynamicsError> {
        if !(error > 0.0 && error < 1.0) {
            return Err(DynamicsError::Parameter {
                name: "error at the bandwidth",
                value: error,
                allowed: "between 0 and 1",
            });
        }
        if !(bandwidth_hz > 0.0 && bandwidth_hz < 0.5 * self.sample_rate_hz) {
            return Err(DynamicsError::Bandwidth { bandwidth_hz, highest_hz: 0.5 * self.sample_rate_hz });
        }
        let bin = bandwidth_hz / self.sample_rate_hz * self.transform_length() as f64;
        Ok(bin.round().max(1.0) as usize)
    }

    /// Angle of a bin \[rad\].
    pub(super) fn angle(&self, bin: usize) -> f64 {
        2.0 * PI * bin as f64 / self.transform_length() as f64
    }

    /// |1 − z|⁴.
    pub(super) fn roughness(&self, bin: usize) -> f64 {
        (2.0 * (0.5 * self.angle(bin)).sin()).powi(4)
    }

    pub(super) fn make_ends_real(&self, values: &mut [Complex64]) {
        let last = values.len() - 1;
        values[0].im = 0.0;
        if self.transform_length() == 2 * last {
            values[last].im = 0.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Scheme;
    use super::*;
    use crate::Start;

    fn plan() -> SimulationPlan {
        SimulationPlan::new(40, 1000.0, Scheme::BandLimited, Start::PERIODIC).unwrap()
    }

    /// e^(−iωτ) b: the delay turns every frequency backwards, and half the sample rate is real.
    #[test]
    fn a_delayed_gain_turns_the_phase() {
        let plan = plan();
        let gain = Arx { a: vec![], b: vec![2.0] };
        let mut response = plan.empty_values();
        plan.arx_response(&gain, 0.0013, &mut response).unwrap();
        for (bin, value) in response.values.iter().enumerate().take(20) {
            let wanted = Complex64::from_polar(2.0, -2.0 * PI * bin as f64 / 40.0 * 1.3);
            assert!((value - wanted).norm() < 1e-12, "{bin}: {value} {wanted}");
        }
        assert_eq!(response.values.len(), 21);
        assert!((response.values[20] - 2.0 * (PI * 1.3).cos()).norm() < 1e-12);
    }

    #[test]
    fn what_has_no_gain_at_the_bandwidth_is_refused_by_the_highest_frequency() {
        let plan = plan();
        let mut response = plan.empty_values();
        response.values.fill(Complex64::ZERO);
        let refused = plan.inverse(&response, InverseAim { bandwidth_hz: 100.0, error: 0.1 }).unwrap_err();
        let DynamicsError::Bandwidth { bandwidth_hz, highest_hz } = refused else { panic!("{refused}") };
        assert_eq!((bandwidth_hz, highest_hz), (100.0, 500.0));
    }
}
