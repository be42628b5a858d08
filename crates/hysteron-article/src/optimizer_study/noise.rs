//! Measurement noise of the study's records.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Adds independent normal numbers of standard deviation `deviation` (Box and Muller 1958,
/// doi:10.1214/aoms/1177706645) to `y`.
pub(super) fn add_noise(y: &mut [f64], deviation: f64, seed: u64) {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    for pair in y.chunks_mut(2) {
        // 1 − [0, 1) is never 0.
        let radius = deviation * (-2.0 * (1.0 - random.random::<f64>()).ln()).sqrt();
        let (sin, cos) = (std::f64::consts::TAU * random.random::<f64>()).sin_cos();
        pair.iter_mut().zip([radius * cos, radius * sin]).for_each(|(y, noise)| *y += noise);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_the_moments_of_a_normal_distribution() {
        let mut y = vec![0.0; 100_001];
        add_noise(&mut y, 2.0, 5);
        let moment = |k: i32| y.iter().map(|y| (y / 2.0).powi(k)).sum::<f64>() / y.len() as f64;
        // Standard deviations of the first four: 0.0032, 0.0045, 0.012, 0.031.
        for (k, expected, tolerance) in [(1, 0.0, 0.013), (2, 1.0, 0.018), (3, 0.0, 0.05), (4, 3.0, 0.125)] {
            assert!((moment(k) - expected).abs() < tolerance, "moment {k}: {}", moment(k));
        }
    }
}
