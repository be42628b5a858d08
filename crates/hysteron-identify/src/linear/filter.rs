//! Rational filters in z.

/// output = B(z)/A(z) input from zero, A = 1 + a₁ z⁻¹ + …, B = b₀ z^−delay + ….
pub(super) fn filter(b: &[f64], delay: usize, a: &[f64], input: &[f64], output: &mut [f64]) {
    for k in 0..input.len() {
        let mut sum = 0.0;
        for (j, b) in b.iter().enumerate() {
            if let Some(at) = k.checked_sub(j + delay) {
                sum += b * input[at];
            }
        }
        for (i, a) in a.iter().enumerate() {
            if let Some(at) = k.checked_sub(i + 1) {
                sum -= a * output[at];
            }
        }
        output[k] = sum;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_impulse_gives_the_response_by_hand() {
        // (1 + 2 z⁻¹) z⁻¹ / (1 − 0.5 z⁻¹): 0, 1, 2.5, 1.25, 0.625.
        let mut y = [0.0; 5];
        filter(&[1.0, 2.0], 1, &[-0.5], &[1.0, 0.0, 0.0, 0.0, 0.0], &mut y);
        assert_eq!(y, [0.0, 1.0, 2.5, 1.25, 0.625]);
    }
}
