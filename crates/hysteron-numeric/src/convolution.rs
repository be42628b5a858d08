//! Causal convolution of real sequences by FFT.

use super::Complex64;
use super::fft::{RealFft, fast_length};

/// y_k = Σ_{j ≤ k} kernel_j input_{k−j}, as many samples as the input, in O(N log N). Rounding error a few
/// units of ε · max|kernel ∗ input|.
pub fn causal_convolution(kernel: &[f64], input: &[f64]) -> Vec<f64> {
    let kernel = kernel.get(..input.len()).unwrap_or(kernel);
    let mut convolver = CausalConvolver::new(kernel, input.len() + kernel.len());
    let period = convolver.convolve(input);
    period.get(..input.len()).unwrap_or(period).to_vec()
}

/// One kernel, transformed once, convolved circularly with inputs up to a fixed period.
#[derive(Debug)]
pub struct CausalConvolver {
    fft: RealFft,
    kernel: Vec<Complex64>,
    time: Vec<f64>,
    spectrum: Vec<Complex64>,
}

impl CausalConvolver {
    /// A convolver of period ≥ `period`; samples of a convolution that reach past it wrap around.
    pub fn new(kernel: &[f64], period: usize) -> Self {
        let fft = RealFft::new(fast_length(period));
        let mut time = vec![0.0; fft.len()];
        let mut spectrum = fft.forward.make_output_vec();
        fill(&mut time, kernel);
        fft.transform(&mut time, &mut spectrum);
        Self { kernel: spectrum.clone(), fft, time, spectrum }
    }

    /// The convolution with `input`, one period of it; valid until the next call.
    pub fn convolve(&mut self, input: &[f64]) -> &[f64] {
        fill(&mut self.time, input);
        // All lengths come from the plan, so the transforms cannot fail.
        self.fft.transform(&mut self.time, &mut self.spectrum);
        let scale = 1.0 / self.fft.len() as f64;
        for (x, k) in self.spectrum.iter_mut().zip(&self.kernel) {
            *x *= k * scale;
        }
        self.fft.invert(&mut self.spectrum, &mut self.time);
        &self.time
    }
}

fn fill(buffer: &mut [f64], samples: &[f64]) {
    let count = samples.len().min(buffer.len());
    buffer[..count].copy_from_slice(&samples[..count]);
    buffer[count..].fill(0.0);
}
