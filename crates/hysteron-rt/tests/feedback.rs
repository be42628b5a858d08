//! Promise: feedback does not wind up, a line keeps to its limits, weights that adapt find the filter that is
//! missing.

#![allow(clippy::unwrap_used)] // A failure is a failed test.

use hysteron_rt::Compensated;
use hysteron_rt::{
    Drive, Feedback, FilteredLms, HeldBack, LANES, Limited, Limits, Line, Linear, LmsFilter, LmsMemory,
    LmsSettings, ModelError, Real, RealPoles, Sections, SectionsMemory,
};

/// 3 e + 0.01 Σ e + 0.5 of a pole 0.9.
fn with_feedback<T: Real>(run: impl FnOnce(&mut Feedback<'_, T>)) {
    let of = |x: f64| T::of(x);
    let zero = of(0.0);
    let real = [RealPoles { gain: [of(0.1), zero, zero, zero], weight: [of(0.5), zero, zero, zero] }];
    let mut states = [Compensated::<T, LANES>::zero()];
    let sections = Sections { taps: &[zero], real: &real, pairs: &[], rest_gain: of(0.5) };
    let memory = SectionsMemory { real: &mut states, pairs: &mut [], delay: &mut [] };
    let mut feedback = Feedback::new(of(3.0), of(0.01), Linear::new(sections, memory).unwrap()).unwrap();
    run(&mut feedback);
}

#[test]
fn a_constant_error_adds_up() {
    with_feedback::<f64>(|feedback| {
        for k in 1..=100 {
            let c = feedback.step(2.0, HeldBack::No);
            // The pole sees the error behind its tap, one sample later.
            let expected = 6.0 + 0.02 * f64::from(k) + (1.0 - 0.9_f64.powi(k - 1));
            assert!((c - expected).abs() < 1e-12, "{k}: {c} {expected}");
        }
        // One that is not a number leaves it where it is.
        let before = feedback.step(0.0, HeldBack::No);
        assert_eq!(feedback.step(f64::NAN, HeldBack::No), before);
        feedback.rest();
        assert_eq!(feedback.step(0.0, HeldBack::No), 0.0);
    });
}

#[test]
fn in_single_precision_a_slow_integral_loses_nothing() {
    with_feedback::<f32>(|feedback| {
        let mut last = 0.0;
        for _ in 0..2_000_000 {
            last = feedback.step(1e-3, HeldBack::No);
        }
        // 3e-3 + 0.01 · 2000 + 0.5e-3.
        assert!((last - 20.0035).abs() < 2e-5, "{last}");
    });
}

#[test]
fn what_is_held_back_does_not_wind_up() {
    with_feedback::<f64>(|feedback| {
        feedback.step(1.0, HeldBack::No);
        let standing = feedback.step(0.0, HeldBack::Above);
        for _ in 0..1000 {
            feedback.step(5.0, HeldBack::Above);
        }
        // 15 of the proportional part come and go.
        let after = feedback.step(5.0, HeldBack::Above) - 15.0;
        assert!((after - standing).abs() < 1e-12, "{after} {standing}");
        // Away from the limit it moves at once.
        let away = feedback.step(-1.0, HeldBack::Above);
        assert!(away + 3.0 < after + 0.1, "{away}");
        let below = feedback.step(-5.0, HeldBack::Below);
        assert!((feedback.step(-5.0, HeldBack::Below) - below).abs() < 1e-15);
    });
}

#[test]
fn a_drive_that_cannot_move_winds_nothing_up() {
    with_feedback::<f64>(|feedback| {
        let standing = feedback.step(0.0, HeldBack::No);
        for error in [0.3, -0.3].into_iter().cycle().take(1001) {
            feedback.step(error, HeldBack::Both);
        }
        assert_eq!(feedback.step(0.0, HeldBack::Both), standing);
    });
    let limits = Limits { low: 0.0, high: 10.0, step: 1.0 };
    let held = |voltage, limited, before| HeldBack::of(Drive { voltage, limited }, before, limits);
    assert_eq!(held(5.0, Limited::Overflow, 5.0), HeldBack::Both);
    assert_eq!(held(5.0, Limited::No, 4.0), HeldBack::No);
    assert_eq!([held(5.0, Limited::Step, 4.0), held(10.0, Limited::Range, 10.0)], [HeldBack::Above; 2]);
    assert_eq!([held(3.0, Limited::Step, 4.0), held(0.0, Limited::Range, 0.0)], [HeldBack::Below; 2]);
}

#[test]
fn errors_out_of_all_reason_are_left_out() {
    with_feedback::<f64>(|feedback| {
        for error in [1.7e308, -1.7e308, 1.7e308] {
            feedback.step(error, HeldBack::No);
        }
        assert_eq!(feedback.step(0.0, HeldBack::No), 0.0);
    });
    with_feedback::<f32>(|feedback| {
        (0..10).for_each(|_| {
            feedback.step(f32::MAX, HeldBack::No);
        });
        assert_eq!(feedback.step(0.0, HeldBack::No), 0.0);
    });
}

#[test]
fn what_was_learned_outlives_numbers_out_of_all_reason_and_leaks() {
    let (mut weights, mut a, mut b, mut turned) = ([0.5, -0.2], [0.0; 4], [0.0; 4], [0.0; 2]);
    let filter = LmsFilter { weights: &mut weights, secondary: &[1.0, 0.9], whitening: &[], stride: 1 };
    let ring = filter.ring();
    let memory = LmsMemory { references: &mut a[..ring], filtered: &mut b[..ring], turned: &mut turned };
    let mut lms =
        FilteredLms::new(filter, memory, LmsSettings { rate: 0.1, leak: 0.01, floor: 1e-9 }).unwrap();
    for (reference, error) in [(1.7e308, 1.0), (1.7e308, 1.7e308), (f64::NAN, f64::INFINITY), (1.0, f64::NAN)]
    {
        assert!(lms.step(reference, error).is_finite());
    }
    // Without an error that can be learnt from they fade by the leak alone.
    let expected = 0.99_f64.powi(4);
    assert!(
        (lms.weights()[0] - 0.5 * expected).abs() < 1e-15
            && (lms.weights()[1] + 0.2 * expected).abs() < 1e-15
    );
}

#[test]
fn a_line_keeps_to_its_limits_and_says_so() {
    let limits = Limits { low: 0.0, high: 10.0, step: 2.0 };
    let mut line = Line::new(1.0, 2.0, limits, 4.0).unwrap();
    let drive = line.step(13.0);
    assert_eq!((drive.voltage, drive.limited), (6.0, Limited::No));
    let drive = line.step(21.0);
    assert_eq!((drive.voltage, drive.limited), (8.0, Limited::Step));
    assert_eq!(HeldBack::of(drive, 6.0, limits), HeldBack::Above);
    line.step(21.0);
    let drive = line.step(99.0);
    assert_eq!((drive.voltage, drive.limited), (10.0, Limited::Range));
    assert_eq!(HeldBack::of(drive, 10.0, limits), HeldBack::Above);
    let drive = line.step(0.0);
    assert_eq!((drive.voltage, drive.limited), (8.0, Limited::Step));
    assert_eq!(HeldBack::of(drive, 10.0, limits), HeldBack::Below);
    assert_eq!(line.step(f64::NAN).limited, Limited::Reference);
    for (offset, slope, limits) in [
        (f64::NAN, 1.0, limits),
        (0.0, 0.0, limits),
        (0.0, 1.0, Limits { high: 0.0, ..limits }),
        (0.0, 1.0, Limits { step: 0.0, ..limits }),
    ] {
        assert!(Line::new(offset, slope, limits, 1.0).is_err());
    }
}

/// The error is the reference behind a filter of 5 taps that is missing, less what the weights put out, both
/// behind the secondary path. What is left of the weights after `samples` of a reference behind the pole
/// `slow`, over what was missing.
fn left(slow: f64, whitening: &[f64], samples: usize) -> f64 {
    const STRIDE: usize = 2;
    let missing = [0.5, -0.2, 0.1, 0.05, 0.3];
    let secondary = [0.0, 0.7, 0.2, 0.1];
    let mut weights = [0.0; 5];
    let filter = LmsFilter { weights: &mut weights, secondary: &secondary, whitening, stride: STRIDE };
    let (mut references, mut filtered, mut turned) = ([0.0; 10], [0.0; 10], [0.0; 5]);
    let memory = LmsMemory { references: &mut references, filtered: &mut filtered, turned: &mut turned };
    let settings = LmsSettings { rate: 0.05, leak: 0.0, floor: 1e-9 };
    let mut lms = FilteredLms::new(filter, memory, settings).unwrap();
    let mut seed = 1_u64;
    let (mut x, mut put): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    let (mut error, mut last) = (0.0, 0.0);
    for k in 0..samples {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        last = slow * last + (seed >> 33) as f64 / (1_u64 << 31) as f64 - 0.5;
        x.push(last);
        let correction = lms.step(x[k], error);
        let wanted: f64 = missing
            .iter()
            .enumerate()
            .filter_map(|(i, m)| k.checked_sub(i * STRIDE).map(|at| m * x[at]))
            .sum();
        put.push(wanted - correction);
        error =
            secondary.iter().enumerate().filter_map(|(j, s)| k.checked_sub(j).map(|at| s * put[at])).sum();
    }
    let square = |w: f64| w * w;
    let apart: f64 = lms.weights().iter().zip(missing).map(|(w, m)| square(w - m)).sum();
    (apart / missing.map(square).iter().sum::<f64>()).sqrt()
}

#[test]
fn weights_find_the_filter_that_is_missing() {
    assert!(left(0.0, &[], 60_000) < 1e-6);
}

/// A random walk's samples are nearly alike: white differences, the inverse covariance a tridiagonal matrix.
#[test]
fn whitened_they_find_it_as_fast_behind_a_slow_reference() {
    let slow: f64 = 0.98;
    let next = slow.powi(2);
    // Samples two apart of x ← 0.98 x + white, by the closed form of an autoregressive covariance's inverse.
    let mut whitening = [0.0; 25];
    for i in 0..5 {
        whitening[6 * i] = if i == 0 || i == 4 { 1.0 } else { 1.0 + next * next };
        if i < 4 {
            (whitening[6 * i + 1], whitening[6 * i + 5]) = (-next, -next);
        }
    }
    let (plain, whitened) = (left(slow, &[], 10_000), left(slow, &whitening, 10_000));
    assert!(whitened < 1e-4 && plain > 1e2 * whitened, "{plain} {whitened}");
}

#[test]
fn what_does_not_fit_is_refused() {
    let refused = |[rate, leak, floor]: [f64; 3], ring: usize, whitening: &[f64]| {
        let (mut weights, mut turned, mut a, mut b) = ([0.0; 4], [0.0; 4], vec![0.0; ring], vec![0.0; ring]);
        let filter = LmsFilter { weights: &mut weights, secondary: &[1.0], whitening, stride: 2 };
        let memory = LmsMemory { references: &mut a, filtered: &mut b, turned: &mut turned };
        FilteredLms::new(filter, memory, LmsSettings { rate, leak, floor }).err()
    };
    let sound = [0.1, 0.0, 1.0];
    assert_eq!(refused(sound, 8, &[]), None);
    assert_eq!(refused(sound, 8, &[1.0; 16]), None);
    assert_eq!(refused(sound, 7, &[]), Some(ModelError::Memory { expected: 8, found: 7 }));
    assert_eq!(refused(sound, 8, &[1.0; 4]), Some(ModelError::Memory { expected: 16, found: 4 }));
    assert_eq!(refused(sound, 8, &[f64::NAN; 16]), Some(ModelError::Coefficient));
    for numbers in [[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [0.1, 1.0, 1.0], [0.1, 0.0, 0.0], [f64::NAN, 0.0, 1.0]]
    {
        assert_eq!(refused(numbers, 8, &[]), Some(ModelError::Coefficient));
    }
}
