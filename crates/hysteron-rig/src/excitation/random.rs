//! Band-limited random signals.

use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;
use realfft::RealFftPlanner;
use rustfft::num_complex::Complex64;

use super::{SAMPLE_ROUNDING, Shape};

/// Generator of a seed's waveforms. The long jump separates it from other streams of the same seed.
pub(super) fn generator(seed: u64) -> Xoshiro256PlusPlus {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    rng.long_jump();
    rng
}

/// Uniform in \[0, 1).
pub(super) fn uniform(rng: &mut Xoshiro256PlusPlus) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

/// Samples of the real signal with the given half spectrum; `n` samples.
pub(super) fn synthesise(mut spectrum: Vec<Complex64>, n: usize) -> Vec<f64> {
    let mut values = vec![0.0; n];
    let inverse = RealFftPlanner::<f64>::new().plan_fft_inverse(n);
    if let Some(zero) = spectrum.first_mut() {
        zero.im = 0.0;
    }
    if n.is_multiple_of(2)
        && let Some(nyquist) = spectrum.last_mut()
    {
        nyquist.im = 0.0;
    }
    // Cannot fail: the lengths fit and the two real bins are real.
    let done = inverse.process(&mut spectrum, &mut values);
    debug_assert!(done.is_ok());
    values
}

/// Shifts and scales values to fill 0 … 1; a constant becomes ½.
pub(super) fn fill_range(values: &mut [f64]) {
    let (low, high) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &x| (l.min(x), h.max(x)));
    for x in values {
        *x = if high > low { ((*x - low) / (high - low)).clamp(0.0, 1.0) } else { 0.5 };
    }
}

/// Noise with complex normal lines inside the band and nothing outside.
pub(super) fn band_limited(low_hz: f64, high_hz: f64, duration_s: f64, fs: f64, seed: u64) -> Shape {
    let n = (duration_s * fs - SAMPLE_ROUNDING).ceil().max(1.0) as usize;
    let mut rng = generator(seed);
    let mut spectrum = vec![Complex64::ZERO; n / 2 + 1];
    for (line, bin) in spectrum.iter_mut().enumerate().skip(1) {
        let f = line as f64 * fs / n as f64;
        if f >= low_hz * (1.0 - 1e-12) && f <= high_hz * (1.0 + 1e-12) {
            let radius = (-2.0 * (1.0 - uniform(&mut rng)).ln()).sqrt();
            *bin = Complex64::from_polar(radius, std::f64::consts::TAU * uniform(&mut rng));
        }
    }
    let mut values = synthesise(spectrum, n);
    fill_range(&mut values);
    Shape { period_samples: Some(n), ..Shape::plain(values) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spectrum_ends_at_the_band_and_the_range_is_filled() {
        let s = band_limited(5.0, 40.0, 4.0, 1000.0, 3);
        let (low, high) = s.values.iter().fold((1.0f64, 0.0f64), |(l, h), &x| (l.min(x), h.max(x)));
        assert_eq!((low, high), (0.0, 1.0));
        let forward = RealFftPlanner::<f64>::new().plan_fft_forward(4000);
        let mut spectrum = forward.make_output_vec();
        forward.process(&mut s.values.clone(), &mut spectrum).unwrap();
        let (mut inside, mut outside) = (0.0f64, 0.0f64);
        for (line, x) in spectrum.iter().enumerate().skip(1) {
            // 0.25 Hz a line.
            if (20..=160).contains(&line) { inside += x.norm_sqr() } else { outside = outside.max(x.norm()) }
        }
        assert!(outside < 1e-9 * inside.sqrt(), "{outside} outside, {inside} inside");
    }

    #[test]
    fn the_seed_decides() {
        let at = |seed| band_limited(0.0, 40.0, 0.3, 1000.0, seed).values;
        assert_eq!(at(1), at(1));
        assert_ne!(at(1), at(2));
    }
}
