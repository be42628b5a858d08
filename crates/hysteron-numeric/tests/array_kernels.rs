//! Promise: the array kernels are as accurate as the standard library's functions to a rounding or two, and
//! give the same bits whichever instruction set runs them.

#![allow(clippy::unwrap_used)]

use hysteron_numeric::fft::{RealFft, fast_length};
use hysteron_numeric::{
    Complex64, InstructionSet, accumulate_power, accumulate_tangent, filter_every, half_turns, multiply,
    multiply_and_add, multiply_by, multiply_quotient, quotient_parts, quotient_tangent,
};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

fn uniform(count: usize, low: f64, high: f64, seed: u64) -> Vec<f64> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    (0..count).map(|_| random.random_range(low..high)).collect()
}

fn complex(count: usize, seed: u64) -> Vec<Complex64> {
    let (re, im) = (uniform(count, -1.0, 1.0, seed), uniform(count, -1.0, 1.0, seed + 100));
    re.into_iter().zip(im).map(|(re, im)| Complex64::new(re, im)).collect()
}

fn power(set: InstructionSet, order: f64, log_abs: &[f64], angle: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (mut re, mut im) = (vec![0.0; log_abs.len()], vec![0.0; log_abs.len()]);
    accumulate_power(set, 1.0, order, log_abs, angle, &mut re, &mut im);
    (re, im)
}

#[test]
fn exp_is_within_one_unit_in_the_last_place() {
    let x = uniform(200_000, -708.0, 709.0, 1);
    let (found, _) = power(InstructionSet::detected(), 1.0, &x, &vec![0.0; x.len()]);
    for (x, found) in x.iter().zip(found) {
        let expected = x.exp();
        let units = (found.to_bits() as i64 - expected.to_bits() as i64).abs();
        assert!(units <= 1, "exp({x}): {units} units");
    }
}

#[test]
fn sine_and_cosine_are_within_half_a_unit_of_one() {
    for range in [4.0, 20.0, 1e5] {
        let x = uniform(200_000, -range, range, 2);
        let (cos, sin) = power(InstructionSet::detected(), 1.0, &vec![0.0; x.len()], &x);
        for ((x, cos), sin) in x.iter().zip(cos).zip(sin) {
            assert!((cos - x.cos()).abs() <= 1.2e-16, "cos {x}");
            assert!((sin - x.sin()).abs() <= 1.2e-16, "sin {x}");
        }
    }
    // Near the zeros the error is relative.
    for k in 1..1000 {
        let x = std::f64::consts::PI * f64::from(k);
        let (_, sin) = power(InstructionSet::baseline(), 1.0, &[0.0], &[x]);
        assert!((sin[0] / x.sin() - 1.0).abs() < 1e-4, "sin {x}: {} {}", sin[0], x.sin());
    }
}

#[test]
fn powers_match_the_standard_complex_power() {
    let (log_abs, angle) = (uniform(50_000, -12.0, 12.0, 3), uniform(50_000, -3.2, 3.2, 4));
    for order in [0.0, 0.5, 1.0523, 2.0384, 7.3] {
        let (re, im) = power(InstructionSet::detected(), order, &log_abs, &angle);
        for k in 0..re.len() {
            let expected = Complex64::from_polar((order * log_abs[k]).exp(), order * angle[k]);
            let error = (Complex64::new(re[k], im[k]) - expected).norm() / expected.norm();
            // Exponential, sine and product: a few halves of 2.2e-16.
            assert!(error < 5e-16, "order {order} at {k}: {error:e}");
        }
    }
}

#[test]
fn arguments_out_of_range_are_limited_and_nan_stays() {
    let (re, _) = power(InstructionSet::detected(), 1.0, &[-1e4, 1e4, f64::NAN], &[0.0; 3]);
    assert!(re[0] > 0.0 && re[0] < 1e-300 && re[1].is_finite() && re[1] > 1e300 && re[2].is_nan());
}

#[test]
fn every_instruction_set_gives_the_same_bits() {
    // An odd length leaves a remainder after the widest vectors.
    let n = 1013;
    let (log_abs, angle) = (uniform(n, -30.0, 30.0, 5), uniform(n, -3.2, 3.2, 6));
    let factor = complex(n, 7);
    let run = |set| {
        let (re, im) = power(set, 1.37, &log_abs, &angle);
        let numerator = power(set, 0.2, &log_abs, &angle);
        let mut quotient = vec![Complex64::ZERO; n];
        multiply_quotient(set, (&numerator.0, &numerator.1), (&re, &im), &factor, &mut quotient);
        let turns = half_turns(set, &re, &im);
        let (mut value, mut weight) = ((re.clone(), im.clone()), (re.clone(), im.clone()));
        let mut product = vec![Complex64::ZERO; n];
        let (top, bottom) = ((&numerator.0[..], &numerator.1[..]), (&re[..], &im[..]));
        let parts = ((&mut value.0[..], &mut value.1[..]), (&mut weight.0[..], &mut weight.1[..]));
        quotient_parts(set, top, bottom, &factor, parts.0, parts.1, &mut product);
        for weight in [0.0, 0.7] {
            let sum = (&mut value.0[..], &mut value.1[..]);
            accumulate_tangent(set, 1.3, weight, (&log_abs, &angle), bottom, sum);
        }
        let mut tangent = vec![Complex64::ZERO; n];
        quotient_tangent(set, top, bottom, (&value.0, &value.1), (&weight.0, &weight.1), &mut tangent);
        let mut last = vec![Complex64::ZERO; n];
        multiply(set, &tangent, &product, &mut last);
        multiply_by(set, &product, &mut last);
        multiply_and_add(set, &tangent, (&re, &im), &mut last);
        quotient.extend(last);
        let bits: Vec<u64> = quotient.iter().flat_map(|q| [q.re.to_bits(), q.im.to_bits()]).collect();
        let mut filtered = vec![0.0; 321];
        filter_every(set, &angle[..51], 3, &log_abs, &mut filtered);
        (bits, re, im, turns, filtered)
    };
    let baseline = run(InstructionSet::baseline());
    for set in InstructionSet::available() {
        assert_eq!(run(set), baseline, "{set:?}");
    }
}

#[test]
fn a_thinned_filter_is_a_row_of_sums() {
    let (kernel, x) = (uniform(51, -1.0, 1.0, 5), uniform(1013, -1.0, 1.0, 6));
    // 321 windows of 51 samples, three apart, end at the last of 1013 samples but two.
    let mut out = vec![f64::NAN; 321];
    filter_every(InstructionSet::detected(), &kernel, 3, &x, &mut out);
    for (i, out) in out.iter().enumerate() {
        let sum: f64 = kernel.iter().zip(&x[3 * i..]).map(|(h, x)| h * x).sum();
        assert!((out - sum).abs() < 1e-14 * 51.0, "{i}");
    }
}

#[test]
fn the_quotient_is_the_complex_quotient() {
    let x = |seed| uniform(100, -2.0, 2.0, seed);
    let (nr, ni, dr, di, factor) = (x(1), x(2), x(3), x(4), complex(100, 5));
    let mut out = vec![Complex64::ZERO; 100];
    multiply_quotient(InstructionSet::detected(), (&nr, &ni), (&dr, &di), &factor, &mut out);
    for k in 0..100 {
        let expected = Complex64::new(nr[k], ni[k]) / Complex64::new(dr[k], di[k]) * factor[k];
        assert!((out[k] - expected).norm() < 1e-14 * expected.norm());
    }
}

#[test]
fn the_derivative_kernels_are_complex_arithmetic() {
    let set = InstructionSet::detected();
    let x = |seed| (uniform(100, -2.0, 2.0, seed), uniform(100, -2.0, 2.0, seed + 50));
    let (n, d, dn, dd, mut g, mut w, log) = (x(1), x(2), x(3), x(4), x(5), x(6), x(7));
    let (factor, mut out, mut product) = (complex(100, 8), complex(100, 9), complex(100, 10));
    let at = |pair: &(Vec<f64>, Vec<f64>), k: usize| Complex64::new(pair.0[k], pair.1[k]);
    let near = |a: Complex64, b: Complex64| assert!((a - b).norm() < 1e-13 * (1.0 + b.norm()), "{a} {b}");
    quotient_parts(
        set,
        (&n.0, &n.1),
        (&d.0, &d.1),
        &factor,
        (&mut g.0, &mut g.1),
        (&mut w.0, &mut w.1),
        &mut out,
    );
    for k in 0..100 {
        near(at(&g, k), at(&n, k) / at(&d, k));
        near(at(&w, k), factor[k] / at(&d, k));
        near(out[k], at(&n, k) / at(&d, k) * factor[k]);
    }
    multiply(set, &out, &factor, &mut product);
    (0..100).for_each(|k| near(product[k], out[k] * factor[k]));
    quotient_tangent(set, (&dn.0, &dn.1), (&dd.0, &dd.1), (&g.0, &g.1), (&w.0, &w.1), &mut out);
    (0..100).for_each(|k| near(out[k], (at(&dn, k) - at(&g, k) * at(&dd, k)) * at(&w, k)));
    for weight in [0.0, -0.4] {
        let before = dn.clone();
        let mut sum = dn.clone();
        accumulate_tangent(set, 1.5, weight, (&log.0, &log.1), (&n.0, &n.1), (&mut sum.0, &mut sum.1));
        (0..100).for_each(|k| near(at(&sum, k), at(&before, k) + (1.5 + weight * at(&log, k)) * at(&n, k)));
    }
}

#[test]
fn half_turns_count_the_winding() {
    for turns in [-3i32, -1, 0, 1, 2] {
        let n = 100;
        let angle = |k: usize| 0.1 + f64::from(turns) * std::f64::consts::TAU * k as f64 / n as f64;
        let re: Vec<f64> = (0..=n).map(|k| angle(k).cos()).collect();
        let im: Vec<f64> = (0..=n).map(|k| angle(k).sin()).collect();
        assert_eq!(half_turns(InstructionSet::detected(), &re, &im), 2.0 * f64::from(turns));
    }
    assert_eq!(half_turns(InstructionSet::baseline(), &[], &[]), 0.0);
}

#[test]
fn fast_lengths_are_even_products_of_two_three_and_five_not_far_above() {
    let is_smooth = |mut n: usize| {
        for p in [2, 3, 5] {
            while n.is_multiple_of(p) {
                n /= p;
            }
        }
        n == 1
    };
    for at_least in (0..3000).chain([99_999, 200_001, 1_234_567]) {
        let next = (at_least.max(2)..).find(|n: &usize| n.is_multiple_of(2) && is_smooth(*n)).unwrap();
        let found = fast_length(at_least);
        assert!(found.is_multiple_of(2) && is_smooth(found) && found >= next, "{at_least}: {found}");
        assert!(found as f64 <= 1.2 * next as f64, "{at_least}: {found} instead of {next}");
    }
    // 20 000 = 2⁵ 5⁴ takes longer.
    assert_eq!(fast_length(20_000), 20_480);
    assert_eq!(RealFft::new(0).len(), 1);
}
