//! Branch-free exp, sin, cos and smooth minimum of one number, written so that loops over them become vector code.
//!
//! Only +, −, ×, comparisons that become selects, and bit operations on the exponent are used, and no
//! fused multiply-add: every instruction set rounds alike, so results are bit-identical between them.
//!
//! Measured against the standard library (tests in `tests/array_kernels.rs`): exp ≤ 1 ulp on
//! \[−708, 709\]; sin and cos ≤ 1e-16 absolute (half a unit of 1) on |x| ≤ 1e5.

/// Adding and subtracting 1.5·2⁵² rounds to the nearest integer, which is then in the low mantissa bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

const LN2_HI: f64 = 0.693_147_180_559_890_3;
const LN2_LO: f64 = 5.497_923_018_708_371e-14;

/// π/2 in three parts of at most 33 bits (the first two), so that n·part is exact for |n| < 2²⁰.
const PIO2_HI: f64 = 1.570_796_326_734_125_6;
const PIO2_MID: f64 = 6.077_100_506_303_966e-11;
const PIO2_LO: f64 = 2.022_266_248_795_950_6e-21;

/// (eʳ − 1 − r)/r² on |r| ≤ ln 2 / 2, Chebyshev fit, relative error of eʳ 1.7e-17; descending powers.
const EXP: [f64; 10] = [
    2.510_047_250_569_499_6e-8,
    2.762_020_159_103_154_7e-7,
    2.755_726_827_690_569_6e-6,
    2.480_152_105_786_820_5e-5,
    1.984_126_986_317_155_7e-4,
    1.388_888_891_736_708_1e-3,
    8.333_333_333_330_039e-3,
    4.166_666_666_662_382_4e-2,
    1.666_666_666_666_666_9e-1,
    5.000_000_000_000_001e-1,
];

/// Coefficients of (artanh s − s)/s³ in s², descending: 1/33 to 1/3, relative error 1e-17 for s ≤ 1/3.
const ARTANH: [f64; 16] = [
    1.0 / 33.0,
    1.0 / 31.0,
    1.0 / 29.0,
    1.0 / 27.0,
    1.0 / 25.0,
    1.0 / 23.0,
    1.0 / 21.0,
    1.0 / 19.0,
    1.0 / 17.0,
    1.0 / 15.0,
    1.0 / 13.0,
    1.0 / 11.0,
    1.0 / 9.0,
    1.0 / 7.0,
    1.0 / 5.0,
    1.0 / 3.0,
];

/// (sin r − r)/r³ and (cos r − 1 + r²/2)/r⁴ on |r| ≤ π/4, ascending powers of r² (fdlibm's).
const SIN: [f64; 6] = [
    -1.666_666_666_666_663_2e-1,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_006_8e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];
const COS: [f64; 6] = [
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];

/// eˣ, the argument limited to \[−708, 709\] (no subnormal or infinite result); NaN stays NaN.
#[inline(always)]
pub(super) fn exp(x: f64) -> f64 {
    let (scale, m) = exp_parts(x);
    (1.0 + m) * scale
}

/// eˣ − 1 with full relative precision near 0, the argument limited as by [`exp`].
#[inline(always)]
pub(super) fn exp_m1(x: f64) -> f64 {
    let (scale, m) = exp_parts(x);
    scale * m + (scale - 1.0)
}

/// (2ⁿ, m) with eˣ = 2ⁿ (1 + m).
#[inline(always)]
fn exp_parts(x: f64) -> (f64, f64) {
    let x = if x < -708.0 { -708.0 } else { x };
    let x = if x > 709.0 { 709.0 } else { x };
    let shifted = x * std::f64::consts::LOG2_E + ROUND;
    let n = shifted - ROUND;
    let r = (x - n * LN2_HI) - n * LN2_LO;
    let r2 = r * r;
    let r4 = r2 * r2;
    // Pairs (Estrin) shorten the dependency chain.
    let low = (EXP[9] + EXP[8] * r) + (EXP[7] + EXP[6] * r) * r2;
    let high = (EXP[5] + EXP[4] * r) + (EXP[3] + EXP[2] * r) * r2 + (EXP[1] + EXP[0] * r) * r4;
    let p = low + high * r4;
    let scale = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
    (scale, r + r2 * p)
}

/// ln(1 + x) for 0 ≤ x ≤ 1.
#[inline(always)]
fn ln_1p(x: f64) -> f64 {
    // ln(1 + x) = 2 artanh s, s = x/(2 + x) ≤ 1/3.
    let s = x / (2.0 + x);
    let z = s * s;
    let sum = ARTANH.iter().fold(0.0, |sum, c| sum * z + c);
    2.0 * (s + s * z * sum)
}

/// Smooth minimum m = −σ ln(e^(−a/σ) + e^(−b/σ)), below the lesser of a and b by up to σ ln 2, with ∂m/∂a =
/// 1 − ∂m/∂b, and ∂m/∂σ. Branch-free: loops over it become vector code.
#[inline(always)]
pub fn smooth_minimum(a: f64, b: f64, sigma: f64) -> (f64, f64, f64) {
    let (less, more) = if a < b { (a, b) } else { (b, a) };
    let apart = (more - less) / sigma;
    let ratio = exp(-apart);
    let below = ln_1p(ratio);
    let of_more = ratio / (1.0 + ratio);
    let by_a = if a < b { 1.0 - of_more } else { of_more };
    (less - sigma * below, by_a, -(below + apart * of_more))
}

/// (sin x, cos x) for |x| ≤ 1e5; meaningless beyond.
#[inline(always)]
pub(super) fn sin_cos(x: f64) -> (f64, f64) {
    let shifted = x * std::f64::consts::FRAC_2_PI + ROUND;
    let n = shifted - ROUND;
    let r = ((x - n * PIO2_HI) - n * PIO2_MID) - n * PIO2_LO;
    let q = shifted.to_bits();
    let z = r * r;
    let z2 = z * z;
    let ps = (SIN[0] + SIN[1] * z) + ((SIN[2] + SIN[3] * z) + (SIN[4] + SIN[5] * z) * z2) * z2;
    let pc = (COS[0] + COS[1] * z) + ((COS[2] + COS[3] * z) + (COS[4] + COS[5] * z) * z2) * z2;
    let s = r + r * (z * ps);
    let half = 0.5 * z;
    let w = 1.0 - half;
    let c = w + (((1.0 - w) - half) + z2 * pc);
    // Odd quadrants exchange sine and cosine; the second bit of q (and of q + 1) is the sign.
    let swap = (q & 1).wrapping_neg();
    let (sb, cb) = (s.to_bits(), c.to_bits());
    let flip = (sb ^ cb) & swap;
    let sin = (sb ^ flip) ^ ((q & 2) << 62);
    let cos = (cb ^ flip) ^ ((q.wrapping_add(1) & 2) << 62);
    (f64::from_bits(sin), f64::from_bits(cos))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ln_1p_is_within_two_units_in_the_last_place() {
        for k in 0..=100_000_i32 {
            let x = (f64::from(k) / 100_000.0).powi(3);
            let (found, expected) = (ln_1p(x), x.ln_1p());
            let units = (found.to_bits() as i64 - expected.to_bits() as i64).abs();
            assert!(units <= 2, "ln(1 + {x}): {units} units");
        }
    }

    #[test]
    fn smooth_minimum_is_its_definition_with_its_slopes() {
        for k in -400..=400_i32 {
            let (a, b, sigma) = (0.7, 0.7 + 0.05 * f64::from(k), 0.3);
            let defined = |a: f64, sigma: f64| {
                let shift = a.min(b);
                shift - sigma * ((-(a - shift) / sigma).exp() + (-(b - shift) / sigma).exp()).ln()
            };
            let (found, by_a, by_sigma) = smooth_minimum(a, b, sigma);
            assert!((found - defined(a, sigma)).abs() < 1e-15, "{a} {b}");
            let slope = |f: &dyn Fn(f64) -> f64| (f(1e-5) - f(-1e-5)) / 2e-5;
            assert!((by_a - slope(&|d| defined(a + d, sigma))).abs() < 1e-8);
            assert!((by_sigma - slope(&|d| defined(a, sigma + d))).abs() < 1e-8);
        }
    }
}
