//! Run-time choice of the instruction set; the only file of the library with `unsafe`.
//!
//! Each kernel is written once as an `#[inline(always)]` function and compiled for the baseline, AVX2 and
//! AVX-512. The wrappers are `unsafe` to call only because the processor must have the feature, which
//! [`InstructionSet::detected`] has checked.
#![allow(unsafe_code)]

use super::Complex64;
use super::complex_exponential::exponentials_less_one_kernel;
use super::elementary::{exp, sin_cos};
use super::feedback_tangent::{Recursion, feedback_tangent_kernel, feedback_tangent_single_kernel};
use super::filter::filter_every_kernel;
use super::inner_product::{inner_product_kernel, project_out_four_kernel, subtract_multiple_kernel};
use super::relaxation::{Relaxations, relaxations_kernel, relaxations_with_slopes_kernel};
use super::relaxation_bank::{
    Abreast, BankWeights, Parabolas, RelaxationBank, bank_advance_kernel, bank_read_kernel,
};
use super::resonance_bank::{
    Propagated, Propagators, ResonanceBank, propagators_kernel, resonances_advance_kernel,
    resonances_read_kernel,
};
use super::series::{SeriesPanel, series_evaluate_kernel, series_power_kernel, series_product_kernel};
use super::triangular::reflect_kernel;

/// Instruction set a kernel runs with. Results do not depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InstructionSet(Level);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Level {
    Baseline,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl InstructionSet {
    /// Instruction set of every processor of the target.
    pub fn baseline() -> Self {
        Self(Level::Baseline)
    }

    /// The best this processor has.
    pub fn detected() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("avx512dq")
            {
                return Self(Level::Avx512);
            }
            if is_x86_feature_detected!("avx2") {
                return Self(Level::Avx2);
            }
        }
        Self(Level::Baseline)
    }

    /// Every instruction set this processor can run, the baseline first.
    pub fn available() -> Vec<Self> {
        #[cfg_attr(not(target_arch = "x86_64"), allow(unused_mut))]
        let mut all = vec![Self::baseline()];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") {
                all.push(Self(Level::Avx2));
            }
            if Self::detected() != Self(Level::Avx2) && Self::detected() != Self::baseline() {
                all.push(Self::detected());
            }
        }
        all
    }
}

/// A pass that is not of this crate, to be compiled for every instruction set ([`run_pass`]).
pub trait Pass {
    /// The pass; `#[inline(always)]`, as must be what it calls.
    fn run(self);
}

/// Runs a pass, compiled for an instruction set.
pub fn run_pass<P: Pass>(set: InstructionSet, pass: P) {
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn avx2<P: Pass>(pass: P) {
        pass.run();
    }
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    fn avx512<P: Pass>(pass: P) {
        pass.run();
    }
    match set.0 {
        Level::Baseline => pass.run(),
        // SAFETY: this level is only constructed after the feature was detected on the processor.
        #[cfg(target_arch = "x86_64")]
        Level::Avx2 => unsafe { avx2(pass) },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        Level::Avx512 => unsafe { avx512(pass) },
    }
}

macro_rules! dispatched {
    ($(#[$doc:meta])* $name:ident => $kernel:ident($($arg:ident: $ty:ty),*) $(-> $ret:ty)?) => {
        $(#[$doc])*
        pub fn $name(set: InstructionSet, $($arg: $ty),*) $(-> $ret)? {
            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx2")]
            fn avx2($($arg: $ty),*) $(-> $ret)? {
                $kernel($($arg),*)
            }
            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
            fn avx512($($arg: $ty),*) $(-> $ret)? {
                $kernel($($arg),*)
            }
            match set.0 {
                Level::Baseline => $kernel($($arg),*),
                // SAFETY: this level is only constructed after the feature was detected on the processor.
                #[cfg(target_arch = "x86_64")]
                Level::Avx2 => unsafe { avx2($($arg),*) },
                // SAFETY: as above.
                #[cfg(target_arch = "x86_64")]
                Level::Avx512 => unsafe { avx512($($arg),*) },
            }
        }
    };
}

dispatched! {
    /// Adds coefficient · exp(order · (log_abs + i·angle)) to `re + i·im`, element by element: the term
    /// coefficient · s^order of a transfer function at s = exp(log_abs + i·angle).
    ///
    /// Works on the shortest of the four slices. |order · angle| must be ≤ 1e5 (it is ≤ π·order here);
    /// order · log_abs is limited to \[−708, 709\].
    accumulate_power => accumulate_power_kernel(
        coefficient: f64, order: f64, log_abs: &[f64], angle: &[f64], re: &mut [f64], im: &mut [f64])
}

dispatched! {
    /// out = numerator / denominator · factor, element by element, the first two as (re, im) pairs of slices.
    /// A zero denominator gives a value that is not finite.
    multiply_quotient => multiply_quotient_kernel(
        numerator: (&[f64], &[f64]), denominator: (&[f64], &[f64]), factor: &[Complex64],
        out: &mut [Complex64])
}

dispatched! {
    /// Adds (coefficient + weight · (log_abs + i·angle)) · power to `sum`, element by element; pairs are (re,
    /// im). With weight 0, coefficient · power.
    accumulate_tangent => accumulate_tangent_kernel(
        coefficient: f64, weight: f64, log: (&[f64], &[f64]), power: (&[f64], &[f64]),
        sum: (&mut [f64], &mut [f64]))
}

dispatched! {
    /// value = numerator / denominator, weight = factor / denominator and out = value · factor, element by
    /// element; pairs are (re, im).
    quotient_parts => quotient_parts_kernel(
        numerator: (&[f64], &[f64]), denominator: (&[f64], &[f64]), factor: &[Complex64],
        value: (&mut [f64], &mut [f64]), weight: (&mut [f64], &mut [f64]), out: &mut [Complex64])
}

dispatched! {
    /// out = (numerator − value · denominator) · weight, element by element, pairs (re, im): with the
    /// derivatives of numerator and denominator, and value and weight of [`quotient_parts`], the derivative
    /// of its `out`.
    quotient_tangent => quotient_tangent_kernel(
        numerator: (&[f64], &[f64]), denominator: (&[f64], &[f64]), value: (&[f64], &[f64]),
        weight: (&[f64], &[f64]), out: &mut [Complex64])
}

dispatched! {
    /// The recursion of [`super::FeedbackTangent::run`].
    feedback_tangent => feedback_tangent_kernel(recursion: Recursion<'_, '_, f64>)
}

dispatched! {
    /// The same in single precision.
    feedback_tangent_single => feedback_tangent_single_kernel(recursion: Recursion<'_, '_, f32>)
}

dispatched! {
    /// out = a · b, element by element.
    multiply => multiply_kernel(a: &[Complex64], b: &[Complex64], out: &mut [Complex64])
}

dispatched! {
    /// out ← out · factors, element by element.
    multiply_by => multiply_by_kernel(factors: &[Complex64], out: &mut [Complex64])
}

dispatched! {
    /// Adds factors · values to `out`, element by element; the values are a pair of slices (re, im).
    multiply_and_add => multiply_and_add_kernel(
        factors: &[Complex64], values: (&[f64], &[f64]), out: &mut [Complex64])
}

dispatched! {
    /// to = (from + before) · (coarse · fine) + after, element by element, on the shortest of the slices;
    /// false if any result is not finite.
    scale => scale_kernel(
        from: &[f64], before: f64, coarse: f64, fine: &[f64], after: f64, to: &mut [f64]) -> bool
}

dispatched! {
    /// out = factor · turns, element by element.
    rotate => rotate_kernel(factor: Complex64, turns: &[Complex64], out: &mut [Complex64])
}

dispatched! {
    /// Adds factor · turns to `out`, element by element.
    rotate_and_add => rotate_and_add_kernel(factor: Complex64, turns: &[Complex64], out: &mut [Complex64])
}

dispatched! {
    /// `out[i]` = Σ_j kernel\[j\] · x\[i · step + j\], for as many as `x` reaches: a filter of which every
    /// `step`-th output is computed, each in eight interleaved sums.
    filter_every => filter_every_kernel(kernel: &[f64], step: usize, x: &[f64], out: &mut [f64])
}

dispatched! {
    /// [`super::dot`].
    inner_product => inner_product_kernel(a: &[f64], b: &[f64]) -> f64
}

dispatched! {
    /// [`super::subtract`].
    subtract_multiple => subtract_multiple_kernel(x: &mut [f64], factor: f64, column: &[f64])
}

dispatched! {
    /// Projects four orthonormal columns, stored one after the other in `q`, out of `x`.
    project_out_four => project_out_four_kernel(q: &[f64], x: &mut [f64])
}

dispatched! {
    /// Reflects the columns of `work`, `height` rows each, to an upper triangle, and writes that to `factor`.
    reflect => reflect_kernel(work: &mut [f64], height: usize, factor: &mut [f64])
}

dispatched! {
    /// Signed half turns about the origin of a polygon of points re + i·im: +1 for each crossing of the
    /// real axis counter-clockwise, −1 clockwise. Points on the real axis count as above it.
    half_turns => half_turns_kernel(re: &[f64], im: &[f64]) -> f64
}

dispatched! {
    /// [`Relaxations::compute`] without slopes.
    relaxations => relaxations_kernel(up: f64, down: f64, count: usize, row: &mut Relaxations)
}

dispatched! {
    /// [`Relaxations::compute`] with slopes.
    relaxations_with_slopes => relaxations_with_slopes_kernel(
        up: f64, down: f64, count: usize, row: &mut Relaxations)
}

dispatched! {
    /// [`RelaxationBank::advance`].
    bank_advance => bank_advance_kernel(bank: &mut RelaxationBank, inputs: &Parabolas, length_s: f64)
}

dispatched! {
    /// [`RelaxationBank::read`].
    bank_read => bank_read_kernel(
        bank: &mut RelaxationBank, inputs: &Parabolas, length_s: f64, weights: &mut [BankWeights],
        sums: &mut [Abreast])
}

dispatched! {
    /// Propagators of a pole from the first, which is given.
    propagators => propagators_kernel(
        pole: Complex64, lengths_s: &[f64], propagated: Propagated, of: &mut Propagators)
}

dispatched! {
    /// [`ResonanceBank::advance`] with the propagators of a place in the stretch.
    resonances_advance => resonances_advance_kernel(
        bank: &mut ResonanceBank, inputs: &Parabolas, place: usize)
}

dispatched! {
    /// [`ResonanceBank::read`] with the propagators of a place in the stretch.
    resonances_read => resonances_read_kernel(
        bank: &ResonanceBank, inputs: &Parabolas, place: usize, weights: &[&[(Complex64, Complex64)]],
        sums: &mut [Abreast])
}

dispatched! {
    /// [`super::complex_exponential::exponentials_less_one`] where no angle is too large.
    exponentials_less_one => exponentials_less_one_kernel(
        pole: Complex64, times: &[f64], re: &mut [f64], im: &mut [f64])
}

dispatched! {
    /// [`SeriesPanel::power`].
    series_power => series_power_kernel(order: f64, log: &SeriesPanel, out: &mut SeriesPanel)
}

dispatched! {
    /// [`SeriesPanel::product`].
    series_product => series_product_kernel(a: &SeriesPanel, b: &SeriesPanel, out: &mut SeriesPanel)
}

dispatched! {
    /// [`SeriesPanel::evaluate`].
    series_evaluate => series_evaluate_kernel(
        coefficients: &[[f64; 2]; SeriesPanel::TERMS], degree: usize, re: &mut [f64], im: &mut [f64])
}

#[inline(always)]
fn accumulate_power_kernel(
    coefficient: f64,
    order: f64,
    log_abs: &[f64],
    angle: &[f64],
    re: &mut [f64],
    im: &mut [f64],
) {
    for (((&a, &t), re), im) in log_abs.iter().zip(angle).zip(re).zip(im) {
        let magnitude = coefficient * exp(order * a);
        let (s, c) = sin_cos(order * t);
        *re += magnitude * c;
        *im += magnitude * s;
    }
}

#[inline(always)]
fn multiply_quotient_kernel(
    numerator: (&[f64], &[f64]),
    denominator: (&[f64], &[f64]),
    factor: &[Complex64],
    out: &mut [Complex64],
) {
    let numerator = numerator.0.iter().zip(numerator.1);
    let denominator = denominator.0.iter().zip(denominator.1);
    for (((out, (&nr, &ni)), (&dr, &di)), f) in out.iter_mut().zip(numerator).zip(denominator).zip(factor) {
        let scale = 1.0 / (dr * dr + di * di);
        let gr = (nr * dr + ni * di) * scale;
        let gi = (ni * dr - nr * di) * scale;
        out.re = gr * f.re - gi * f.im;
        out.im = gr * f.im + gi * f.re;
    }
}

#[inline(always)]
fn accumulate_tangent_kernel(
    coefficient: f64,
    weight: f64,
    log: (&[f64], &[f64]),
    power: (&[f64], &[f64]),
    sum: (&mut [f64], &mut [f64]),
) {
    let sums = sum.0.iter_mut().zip(sum.1);
    let powers = power.0.iter().zip(power.1);
    if weight == 0.0 {
        for ((re, im), (&pr, &pi)) in sums.zip(powers) {
            *re += coefficient * pr;
            *im += coefficient * pi;
        }
        return;
    }
    for (((re, im), (&pr, &pi)), (&a, &t)) in sums.zip(powers).zip(log.0.iter().zip(log.1)) {
        let fr = coefficient + weight * a;
        let fi = weight * t;
        *re += fr * pr - fi * pi;
        *im += fr * pi + fi * pr;
    }
}

#[inline(always)]
fn quotient_parts_kernel(
    numerator: (&[f64], &[f64]),
    denominator: (&[f64], &[f64]),
    factor: &[Complex64],
    value: (&mut [f64], &mut [f64]),
    weight: (&mut [f64], &mut [f64]),
    out: &mut [Complex64],
) {
    let numerator = numerator.0.iter().zip(numerator.1);
    let denominator = denominator.0.iter().zip(denominator.1);
    let value = value.0.iter_mut().zip(value.1);
    let weight = weight.0.iter_mut().zip(weight.1);
    for (((((out, f), (&nr, &ni)), (&dr, &di)), (vr, vi)), (wr, wi)) in
        out.iter_mut().zip(factor).zip(numerator).zip(denominator).zip(value).zip(weight)
    {
        let scale = 1.0 / (dr * dr + di * di);
        let gr = (nr * dr + ni * di) * scale;
        let gi = (ni * dr - nr * di) * scale;
        *vr = gr;
        *vi = gi;
        *wr = (f.re * dr + f.im * di) * scale;
        *wi = (f.im * dr - f.re * di) * scale;
        out.re = gr * f.re - gi * f.im;
        out.im = gr * f.im + gi * f.re;
    }
}

#[inline(always)]
fn quotient_tangent_kernel(
    numerator: (&[f64], &[f64]),
    denominator: (&[f64], &[f64]),
    value: (&[f64], &[f64]),
    weight: (&[f64], &[f64]),
    out: &mut [Complex64],
) {
    let numerator = numerator.0.iter().zip(numerator.1);
    let denominator = denominator.0.iter().zip(denominator.1);
    let value = value.0.iter().zip(value.1);
    let weight = weight.0.iter().zip(weight.1);
    for ((((out, (&nr, &ni)), (&dr, &di)), (&gr, &gi)), (&wr, &wi)) in
        out.iter_mut().zip(numerator).zip(denominator).zip(value).zip(weight)
    {
        let xr = nr - (gr * dr - gi * di);
        let xi = ni - (gr * di + gi * dr);
        out.re = xr * wr - xi * wi;
        out.im = xr * wi + xi * wr;
    }
}

#[inline(always)]
fn multiply_kernel(a: &[Complex64], b: &[Complex64], out: &mut [Complex64]) {
    for ((out, a), b) in out.iter_mut().zip(a).zip(b) {
        out.re = a.re * b.re - a.im * b.im;
        out.im = a.re * b.im + a.im * b.re;
    }
}

#[inline(always)]
fn multiply_by_kernel(factors: &[Complex64], out: &mut [Complex64]) {
    for (out, f) in out.iter_mut().zip(factors) {
        *out = Complex64::new(out.re * f.re - out.im * f.im, out.re * f.im + out.im * f.re);
    }
}

#[inline(always)]
fn multiply_and_add_kernel(factors: &[Complex64], values: (&[f64], &[f64]), out: &mut [Complex64]) {
    for ((out, f), (re, im)) in out.iter_mut().zip(factors).zip(values.0.iter().zip(values.1)) {
        out.re += f.re * re - f.im * im;
        out.im += f.re * im + f.im * re;
    }
}

#[inline(always)]
fn scale_kernel(from: &[f64], before: f64, coarse: f64, fine: &[f64], after: f64, to: &mut [f64]) -> bool {
    let mut largest = 0u64;
    for ((to, from), fine) in to.iter_mut().zip(from).zip(fine) {
        *to = (from + before) * (coarse * fine) + after;
        // Without the sign, non-finite values have the largest bit patterns.
        largest = largest.max(to.to_bits() & (u64::MAX >> 1));
    }
    largest < f64::INFINITY.to_bits()
}

#[inline(always)]
fn rotate_kernel(factor: Complex64, turns: &[Complex64], out: &mut [Complex64]) {
    for (out, turn) in out.iter_mut().zip(turns) {
        out.re = factor.re * turn.re - factor.im * turn.im;
        out.im = factor.re * turn.im + factor.im * turn.re;
    }
}

#[inline(always)]
fn rotate_and_add_kernel(factor: Complex64, turns: &[Complex64], out: &mut [Complex64]) {
    for (out, turn) in out.iter_mut().zip(turns) {
        out.re += factor.re * turn.re - factor.im * turn.im;
        out.im += factor.re * turn.im + factor.im * turn.re;
    }
}

#[inline(always)]
fn half_turns_kernel(re: &[f64], im: &[f64]) -> f64 {
    let n = re.len().min(im.len());
    let (re, im) = (&re[..n], &im[..n]);
    let mut turns = 0.0;
    for ((x0, y0), (x1, y1)) in
        re.iter().zip(im).zip(re.get(1..).unwrap_or(&[]).iter().zip(im.get(1..).unwrap_or(&[])))
    {
        let cross = x0 * y1 - x1 * y0;
        let direction = if cross > 0.0 { 1.0 } else { -1.0 };
        turns += if (*y0 < 0.0) != (*y1 < 0.0) { direction } else { 0.0 };
    }
    turns
}
