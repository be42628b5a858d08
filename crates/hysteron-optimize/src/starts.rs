//! Starts of local fits.

use super::stream::Stream;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Distribution over the unit box of the starts added to the given ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Starts {
    /// Halton's sequence (doi:10.1007/BF01386213) shifted at random modulo 1 (Cranley and Patterson,
    /// doi:10.1137/0713071): evenly spread whatever their number.
    #[default]
    Halton,
    /// Independent and uniform.
    Random,
}

/// Start number `index`, from 0, into `point`.
pub(super) fn fill_start(kind: Starts, index: usize, shift: &[f64], random: &mut Stream, point: &mut [f64]) {
    match kind {
        Starts::Random => point.iter_mut().for_each(|t| *t = random.unit()),
        Starts::Halton => {
            let bases = (2..).filter(|&n: &usize| (2..n).all(|d| n % d != 0));
            for ((t, base), shift) in point.iter_mut().zip(bases).zip(shift) {
                *t = (radical_inverse(index + 1, base) + shift).fract();
            }
        }
    }
}

/// Radical inverse: digits of `n` in `base`, mirrored at the radix point.
fn radical_inverse(mut n: usize, base: usize) -> f64 {
    let (mut sum, mut weight) = (0.0, 1.0);
    while n > 0 {
        weight /= base as f64;
        sum += (n % base) as f64 * weight;
        n /= base;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halton_points_are_the_published_ones() {
        let mut point = [0.0; 3];
        let expected = [
            [1.0 / 2.0, 1.0 / 3.0, 1.0 / 5.0],
            [1.0 / 4.0, 2.0 / 3.0, 2.0 / 5.0],
            [3.0 / 4.0, 1.0 / 9.0, 3.0 / 5.0],
        ];
        for (index, expected) in expected.iter().enumerate() {
            fill_start(Starts::Halton, index, &[0.0; 3], &mut Stream::new(0, 0), &mut point);
            assert!(point.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{point:?}");
        }
    }

    #[test]
    fn shifted_points_stay_in_the_box_and_one_falls_into_each_half_of_an_axis() {
        let mut point = [0.0; 2];
        let mut upper = 0;
        for index in 0..64 {
            fill_start(Starts::Halton, index, &[0.7, 0.9], &mut Stream::new(0, 0), &mut point);
            assert!(point.iter().all(|t| (0.0..1.0).contains(t)));
            upper += usize::from(point[0] >= 0.5);
        }
        assert!((31..=33).contains(&upper), "{upper}");
    }
}
