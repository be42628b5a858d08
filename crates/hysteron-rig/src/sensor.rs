//! Sensor of the bench: noise and quantisation of the true displacement.

use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

use super::truth::{Adc, Sensor};

/// Random stream number `index` of a seed: streams do not overlap (2^128 numbers each) and do not depend on
/// threads.
fn stream(seed: u64, index: usize) -> Xoshiro256PlusPlus {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    for _ in 0..index {
        rng.jump();
    }
    rng
}

/// Pair of independent standard normal numbers (Box and Muller 1958, doi:10.1214/aoms/1177706645).
fn normal_pair(rng: &mut Xoshiro256PlusPlus) -> (f64, f64) {
    const UNIT: f64 = 1.0 / (1u64 << 53) as f64;
    // In (0, 1], so that the logarithm is finite.
    let radius = (((rng.next_u64() >> 11) + 1) as f64 * UNIT).ln() * -2.0;
    let angle = (rng.next_u64() >> 11) as f64 * UNIT * std::f64::consts::TAU;
    (radius.sqrt() * angle.cos(), radius.sqrt() * angle.sin())
}

/// A sensor that is read once per sample.
pub(super) struct SensorState {
    sensor: Sensor,
    rng: Xoshiro256PlusPlus,
    sample_rate_hz: f64,
    walk_step_um: f64,
    walk_um: f64,
    read: usize,
    clipped: usize,
}

impl SensorState {
    /// The sensor with the noise of stream number `index` of a seed.
    pub fn new(sensor: &Sensor, sample_rate_hz: f64, seed: u64, index: usize) -> Self {
        SensorState {
            sensor: *sensor,
            rng: stream(seed, index),
            sample_rate_hz,
            walk_step_um: sensor.random_walk_um_per_sqrt_s / sample_rate_hz.sqrt(),
            walk_um: 0.0,
            read: 0,
            clipped: 0,
        }
    }

    /// Reading \[µm\] of the true displacement.
    pub fn read(&mut self, true_um: f64) -> f64 {
        let sensor = &self.sensor;
        let (noise, wander) = normal_pair(&mut self.rng);
        let time_s = self.read as f64 / self.sample_rate_hz;
        let analogue = true_um
            + sensor.offset_um
            + sensor.drift_um_per_s * time_s
            + self.walk_um
            + sensor.noise_um * noise;
        self.walk_um += self.walk_step_um * wander;
        self.read += 1;
        match &sensor.adc {
            None => analogue,
            Some(adc) => {
                let (value, inside) = convert(adc, analogue);
                self.clipped += usize::from(!inside);
                value
            }
        }
    }

    /// Readings so far at the ends of the converter's range.
    pub fn clipped(&self) -> usize {
        self.clipped
    }
}

/// Nearest code, and whether the value was inside the converter's range.
fn convert(adc: &Adc, value_um: f64) -> (f64, bool) {
    let step = adc.step_um();
    let code = ((value_um - adc.low_um) / step).round();
    let highest = 2f64.powi(adc.bits as i32) - 1.0;
    (adc.low_um + code.clamp(0.0, highest) * step, (0.0..=highest).contains(&code))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(sensor: &Sensor, y: &[f64], sample_rate_hz: f64, seed: u64, index: usize) -> (Vec<f64>, usize) {
        let mut state = SensorState::new(sensor, sample_rate_hz, seed, index);
        let readings = y.iter().map(|y| state.read(*y)).collect();
        (readings, state.clipped())
    }

    fn quiet() -> Sensor {
        Sensor { noise_um: 0.0, adc: None, ..Sensor::default() }
    }

    #[test]
    fn converter_rounds_to_its_step_and_clips_at_its_ends() {
        let adc = Adc { bits: 3, low_um: -1.0, high_um: 3.0 };
        assert_eq!(adc.step_um(), 0.5);
        let sensor = Sensor { adc: Some(adc), ..quiet() };
        let (y, clipped) = read(&sensor, &[-9.0, -0.7, 0.26, 0.24, 2.5, 2.7, 99.0], 1.0, 1, 0);
        assert_eq!(y, [-1.0, -0.5, 0.5, 0.0, 2.5, 2.5, 2.5]);
        assert_eq!(clipped, 2, "2.7 still rounds to the highest code 2.5");
    }

    #[test]
    fn sixteen_bits_leave_a_uniform_error_of_one_step() {
        let adc = Adc { bits: 16, low_um: -10.0, high_um: 50.0 };
        let sensor = Sensor { adc: Some(adc), ..quiet() };
        let truth: Vec<f64> = (0..20_000).map(|k| 30.0 * (f64::from(k) * 0.618).sin().abs()).collect();
        let (y, _) = read(&sensor, &truth, 1.0, 1, 0);
        let step = 60.0 / 65536.0;
        let errors: Vec<f64> = y.iter().zip(&truth).map(|(a, b)| a - b).collect();
        assert!(errors.iter().all(|e| e.abs() <= 0.5 * step * (1.0 + 1e-9)));
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / 20_000.0).sqrt();
        assert!((rms / (step / 12f64.sqrt()) - 1.0).abs() < 0.02, "{rms}");
    }

    #[test]
    fn noise_has_the_standard_deviation_asked_for_and_is_white() {
        let sensor = Sensor { noise_um: 0.005, ..quiet() };
        const N: usize = 100_000;
        let (y, _) = read(&sensor, &vec![0.0; N], 1e4, 7, 3);
        let mean = y.iter().sum::<f64>() / N as f64;
        let variance = y.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / N as f64;
        // 5 standard errors of each statistic.
        assert!(mean.abs() < 5.0 * 0.005 / (N as f64).sqrt());
        assert!((variance.sqrt() / 0.005 - 1.0).abs() < 5.0 / (2.0 * N as f64).sqrt());
        let lag_1 = y.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / N as f64 / variance;
        assert!(lag_1.abs() < 5.0 / (N as f64).sqrt());
        let fourth = y.iter().map(|v| v.powi(4)).sum::<f64>() / N as f64 / variance.powi(2);
        assert!((fourth - 3.0).abs() < 5.0 * (96.0 / N as f64).sqrt(), "kurtosis {fourth}");
    }

    #[test]
    fn drift_and_random_walk_have_the_size_asked_for() {
        let drift = Sensor { drift_um_per_s: 0.3, offset_um: -1.0, ..quiet() };
        let (y, _) = read(&drift, &[2.0; 11], 10.0, 1, 0);
        assert!((y[10] - (2.0 - 1.0 + 0.3)).abs() < 1e-12);
        let walk = Sensor { random_walk_um_per_sqrt_s: 0.2, ..quiet() };
        // End points of 400 walks of 1 s.
        let ends: Vec<f64> = (0..400).map(|i| read(&walk, &[0.0; 101], 100.0, i, 0).0[100]).collect();
        let rms = (ends.iter().map(|e| e * e).sum::<f64>() / 400.0).sqrt();
        assert!((rms / 0.2 - 1.0).abs() < 5.0 / 800f64.sqrt(), "{rms}");
    }

    #[test]
    fn streams_of_one_seed_differ() {
        let sensor = Sensor { noise_um: 1.0, ..quiet() };
        let at = |seed, index| read(&sensor, &[0.0; 4], 1.0, seed, index).0;
        assert_eq!(at(5, 2), at(5, 2));
        assert_ne!(at(5, 2), at(5, 1));
        assert_ne!(at(5, 2), at(6, 2));
    }
}
