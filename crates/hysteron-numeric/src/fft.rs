//! Real FFT plans of fast lengths, shared by the whole process.

use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex, PoisonError, Weak};

use realfft::{ComplexToReal, FftError, RealFftPlanner, RealToComplex};

use super::Complex64;

/// A forward and an inverse real FFT of one length (unnormalised: inverse after forward multiplies by
/// the length).
#[derive(Clone)]
pub struct RealFft {
    /// Real to half-spectrum.
    pub forward: Arc<dyn RealToComplex<f64>>,
    /// Half-spectrum to real.
    pub inverse: Arc<dyn ComplexToReal<f64>>,
}

impl std::fmt::Debug for RealFft {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "RealFft({})", self.forward.len())
    }
}

impl RealFft {
    /// Plans of length `length`, shared with whoever else uses them. A length of 0 is planned as 1.
    pub fn new(length: usize) -> Self {
        static PLANS: Mutex<Option<Plans>> = Mutex::new(None);
        // A panic while planning leaves the plans usable: they only ever gain finished ones.
        let mut plans = PLANS.lock().unwrap_or_else(PoisonError::into_inner);
        plans.get_or_insert_default().of(length.max(1))
    }

    /// Spectrum of `time`, which is overwritten; both of the plan's lengths.
    pub fn transform(&self, time: &mut [f64], spectrum: &mut [Complex64]) {
        let mut scratch = self.forward.make_scratch_vec();
        self.transform_with(&mut scratch, time, spectrum);
    }

    /// [`Self::transform`] with scratch of at least [`RealToComplex::get_scratch_len`].
    pub fn transform_with(&self, scratch: &mut [Complex64], time: &mut [f64], spectrum: &mut [Complex64]) {
        let transformed = self.forward.process_with_scratch(time, spectrum, scratch);
        debug_assert!(transformed.is_ok(), "{transformed:?}");
    }

    /// Signal of `spectrum`, which is overwritten; both of the plan's lengths. The imaginary parts at 0 and
    /// at half the sample rate, which no real signal has, count as 0.
    pub fn invert(&self, spectrum: &mut [Complex64], time: &mut [f64]) {
        let mut scratch = self.inverse.make_scratch_vec();
        self.invert_with(&mut scratch, spectrum, time);
    }

    /// [`Self::invert`] with scratch of at least [`ComplexToReal::get_scratch_len`].
    pub fn invert_with(&self, scratch: &mut [Complex64], spectrum: &mut [Complex64], time: &mut [f64]) {
        let inverted = self.inverse.process_with_scratch(spectrum, time, scratch);
        debug_assert!(matches!(inverted, Ok(()) | Err(FftError::InputValues(..))), "{inverted:?}");
    }

    /// Length of the real side.
    pub fn len(&self) -> usize {
        self.forward.len()
    }

    /// Never: plans have at least length 1.
    pub fn is_empty(&self) -> bool {
        false
    }
}

/// Samples of all plans together that are kept when nobody uses them. A plan takes some 32 bytes a sample: those of
/// a long record take as much memory as its signals.
const KEPT: usize = 1 << 20;

/// Plans in use, and of those that are not the last used.
#[derive(Default)]
struct Plans {
    /// The last used first.
    kept: VecDeque<RealFft>,
    #[allow(clippy::type_complexity)]
    used: HashMap<usize, (Weak<dyn RealToComplex<f64>>, Weak<dyn ComplexToReal<f64>>)>,
}

impl Plans {
    fn of(&mut self, length: usize) -> RealFft {
        let used = self.used.get(&length);
        let shared = used.and_then(|(forward, inverse)| {
            Some(RealFft { forward: forward.upgrade()?, inverse: inverse.upgrade()? })
        });
        let plan = shared.unwrap_or_else(|| self.made(length));
        if length > KEPT {
            return plan;
        }
        self.kept.retain(|kept| kept.len() != length);
        self.kept.push_front(plan.clone());
        let mut samples = 0;
        self.kept.retain(|kept| {
            samples += kept.len();
            samples <= KEPT
        });
        plan
    }

    fn made(&mut self, length: usize) -> RealFft {
        let mut planner = RealFftPlanner::new();
        let (forward, inverse) = (planner.plan_fft_forward(length), planner.plan_fft_inverse(length));
        self.used.retain(|_, (forward, inverse)| forward.strong_count() + inverse.strong_count() > 0);
        self.used.insert(length, (Arc::downgrade(&forward), Arc::downgrade(&inverse)));
        RealFft { forward, inverse }
    }
}

/// Work of a transform per sample, in passes of radix 2, of each factor of its length, measured with AVX2 and
/// AVX-512: lengths with many factors of 5 take a sixth longer than their neighbours with few.
const WORK_OF: [(usize, f64); 3] = [(2, 1.0), (3, 1.9), (5, 3.3)];
/// Work per sample that does not depend on the factors: spectra are written, multiplied and read.
const WORK_OF_SPECTRA: f64 = 6.0;

/// The even 2ᵃ3ᵇ5ᶜ ≥ `at_least` (at least 2) whose transform takes least work; saturates at the largest power
/// of two.
pub fn fast_length(at_least: usize) -> usize {
    let at_least = at_least.max(2);
    let power_of_two = at_least.checked_next_power_of_two().unwrap_or(1 << (usize::BITS - 1));
    let mut best = (power_of_two, work(power_of_two));
    let mut fives = 1usize;
    while fives < power_of_two {
        let mut threes = fives;
        while threes < power_of_two {
            let mut candidate = threes.saturating_mul(2);
            while candidate < at_least {
                candidate = candidate.saturating_mul(2);
            }
            let found = (candidate, work(candidate));
            if candidate < power_of_two && found.1 < best.1 {
                best = found;
            }
            threes = threes.saturating_mul(3);
        }
        fives = fives.saturating_mul(5);
    }
    best.0
}

/// Work of a transform of this length, a product of 2, 3 and 5.
fn work(length: usize) -> f64 {
    let mut a_sample = WORK_OF_SPECTRA;
    for (factor, work) in WORK_OF {
        let mut left = length;
        while left.is_multiple_of(factor) {
            (left, a_sample) = (left / factor, a_sample + work);
        }
    }
    length as f64 * a_sample
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plans_are_shared_while_in_use_and_long_ones_kept_no_longer() {
        for (length, kept) in [(96, true), (2 * KEPT, false)] {
            let plan = RealFft::new(length);
            assert!(Arc::ptr_eq(&plan.forward, &RealFft::new(length).forward), "{length}");
            let inverse = Arc::downgrade(&plan.inverse);
            drop(plan);
            assert_eq!(inverse.upgrade().is_some(), kept, "{length}");
        }
    }

    #[test]
    fn of_plans_without_use_the_last_are_kept() {
        let mut plans = Plans::default();
        for length in 1..=2000 {
            plans.of(length);
        }
        let samples: usize = plans.kept.iter().map(RealFft::len).sum();
        assert!(samples <= KEPT && samples > KEPT - 2000, "{samples}");
        assert_eq!(plans.kept[0].len(), 2000);
        plans.of(1990);
        assert_eq!((plans.kept[0].len(), plans.kept[1].len()), (1990, 2000));
    }
}
