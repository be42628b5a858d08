//! Random numbers: one stream per candidate.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Random stream of one candidate: xoshiro256++ (Blackman and Vigna 2021, doi:10.1145/3460772) seeded from
/// the run's seed and the candidate's number, so that no draw depends on the order of threads, and the random
/// state of a run is a single integer.
pub(super) struct Stream(Xoshiro256PlusPlus);

impl Stream {
    pub(super) fn new(seed: u64, number: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(mix(mix(seed).wrapping_add(number))))
    }

    /// Uniform in [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        self.0.random()
    }

    /// Uniform in [−1, 1).
    pub(super) fn symmetric(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// Uniform in 0 … count − 1; 0 for an empty range.
    pub(super) fn index(&mut self, count: usize) -> usize {
        self.0.random_range(0..count.max(1))
    }

    /// Uniform in 0 … count − 1 without the `excluded`, which are sorted, distinct and fewer than `count`.
    pub(super) fn index_except(&mut self, count: usize, excluded: &[usize]) -> usize {
        let mut index = self.index(count - excluded.len().min(count));
        for &e in excluded {
            if index >= e {
                index += 1;
            }
        }
        index
    }
}

/// Finaliser of splitmix64: a bijection of 64-bit words that spreads neighbouring numbers.
fn mix(word: u64) -> u64 {
    let word = word.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    word ^ (word >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn excluded_indices_are_never_drawn_and_all_others_are() {
        let mut counts = [0_usize; 6];
        for number in 0..6000 {
            counts[Stream::new(1, number).index_except(6, &[0, 3])] += 1;
        }
        assert_eq!((counts[0], counts[3]), (0, 0));
        // Expected 1500 each, standard deviation 34.
        assert!([1, 2, 4, 5].iter().all(|&i| counts[i].abs_diff(1500) < 170), "{counts:?}");
    }

    #[test]
    fn neighbouring_streams_are_uncorrelated() {
        let first: Vec<f64> = (0..20_000).map(|number| Stream::new(7, number).symmetric()).collect();
        let lagged: f64 = first.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / 19_999.0;
        let mean = first.iter().sum::<f64>() / 20_000.0;
        // Standard deviations 1/3/√20000 = 0.0024 and 1/√3/√20000 = 0.0041.
        assert!(lagged.abs() < 0.012 && mean.abs() < 0.02, "{lagged} {mean}");
    }
}
