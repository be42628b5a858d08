//! Inner product and root mean square.

/// Σ aᵢ bᵢ in eight interleaved sums, which the compiler vectorises; the order of summation is fixed.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a8, b8) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a8.remainder().iter().zip(b8.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a8.zip(b8) {
        for i in 0..8 {
            sums[i] += x[i] * y[i];
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// √(Σ rᵢ² / N), the cost of a residual vector (article Eq. 7); +∞ if any residual is not finite or there is
/// none.
pub fn root_mean_square(residuals: &[f64]) -> f64 {
    // Eight interleaved sums do not wait for one another; the order of summation is fixed.
    let mut sums = [0.0; 8];
    let eights = residuals.chunks_exact(8);
    let rest: f64 = eights.remainder().iter().map(|r| r * r).sum();
    for eight in eights {
        for (sum, r) in sums.iter_mut().zip(eight) {
            *sum += r * r;
        }
    }
    let cost = ((sums.iter().sum::<f64>() + rest) / residuals.len() as f64).sqrt();
    if cost.is_finite() { cost } else { f64::INFINITY }
}
