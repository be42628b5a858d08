//! Poles of a realisation: those of the model, and real ones for its branch cut.

use std::f64::consts::PI;

use nalgebra::DMatrix;

use super::target::{Pole, Target};
use crate::dynamics::{Arx, TransferFunction};
use hysteron_numeric::Complex64;

/// Steps per decade over which the density of a branch cut is summed.
const PER_DECADE: usize = 12;
/// Decades of a branch cut evaluated.
const DECADES: (i32, i32) = (-12, 12);
/// Poles are spread over ln x as this power of the density: weak ends of the cut get fewer.
const SPREAD: f64 = 0.2;
/// Steps per decade of the search for poles on the cut, and largest denominator at one, as a share of its
/// terms.
const ON_CUT_PER_DECADE: usize = 48;
const ON_CUT: f64 = 1e-9;
/// Relative distance of the members of a multiple pole.
const SPLIT: f64 = 1e-3;

/// The branch cut of a target as a density over ln x, in steps.
pub(super) struct Cut {
    /// x \[rad/s\] and the density up to the next.
    steps: Vec<(f64, f64)>,
}

impl Cut {
    /// The cut between two frequencies \[rad/s\], without ends that hold less than `share` together. A pole
    /// on the cut makes its density infinite there: more than `most` counts as that.
    pub fn new(target: Target<'_>, (low, high): (f64, f64), share: f64, most: f64) -> Self {
        let width = std::f64::consts::LN_10 / PER_DECADE as f64;
        let exponents = DECADES.0 * PER_DECADE as i32..DECADES.1 * PER_DECADE as i32;
        let mut steps: Vec<(f64, f64)> = exponents
            .map(|k| 10f64.powf(f64::from(k) / PER_DECADE as f64))
            .filter(|x| (low..=high).contains(x))
            .map(|x| (x, width * target.cut_density(x).min(most)))
            .filter(|(_, held)| held.is_finite())
            .collect();
        for _ in 0..2 {
            // From either end.
            let mut sum = 0.0;
            let weak = steps.iter().take_while(|(_, held)| {
                sum += held;
                sum < share
            });
            let weak = weak.count();
            steps.drain(..weak);
            steps.reverse();
        }
        Self { steps }
    }

    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    /// `count` places \[rad/s\], as dense over ln x as a power of the density.
    pub fn places(&self, count: usize) -> Vec<f64> {
        let weights: Vec<f64> = self.steps.iter().map(|(_, held)| held.powf(SPREAD)).collect();
        let total: f64 = weights.iter().sum();
        let mut places = Vec::with_capacity(count);
        let (mut index, mut before) = (0, 0.0);
        for k in 0..count {
            let wanted = total * (k as f64 + 0.5) / count as f64;
            while index + 1 < weights.len() && before + weights[index] < wanted {
                before += weights[index];
                index += 1;
            }
            let Some(&(x, _)) = self.steps.get(index) else { break };
            let share = ((wanted - before) / weights[index]).clamp(0.0, 1.0);
            places.push(x * 10f64.powf(share / PER_DECADE as f64));
        }
        places
    }
}

/// Poles on the main sheet, as those of sections; `count` is their number with multiplicity.
pub(super) fn of_transfer_function(target: Target<'_>, found: &[Complex64], count: usize) -> Vec<Pole> {
    // The search counts a multiple pole once, and does not say which it is.
    let copies = if found.is_empty() { 1 } else { count.div_ceil(found.len()).max(1) };
    let upper = found.iter().filter(|s| s.im >= 0.0);
    upper.flat_map(|&s| side_by_side(s, copies)).flat_map(|s| target.poles_of(s)).collect()
}

/// Poles of G that lie on its branch cut \[rad/s\], which no search of the main sheet finds: where the
/// denominator has a factor of whole orders, as creep by relaxations beside fractional modes has, it vanishes
/// on both sides of the cut at once. Between two of them, more than a step apart, the denominator reverses
/// its direction.
pub(super) fn on_the_cut(g: &TransferFunction) -> Vec<f64> {
    // The denominator on the upper side of the cut at e^ln_x, and what rounding is measured by.
    let at = |ln_x: f64| {
        g.denominator.iter().fold((Complex64::ZERO, 0.0), |(sum, size), term| {
            let magnitude = term.coefficient * (term.order * ln_x).exp();
            (sum + Complex64::from_polar(magnitude, PI * term.order), size + magnitude.abs())
        })
    };
    let turned = |a: Complex64, b: Complex64| (a * b.conj()).re < 0.0;
    let step = std::f64::consts::LN_10 / ON_CUT_PER_DECADE as f64;
    let grid = DECADES.0 * ON_CUT_PER_DECADE as i32..DECADES.1 * ON_CUT_PER_DECADE as i32;
    grid.filter_map(|k| {
        let (mut low, mut high) = (f64::from(k) * step, f64::from(k + 1) * step);
        let before = at(low).0;
        if !turned(before, at(high).0) {
            return None;
        }
        while high - low > 4.0 * f64::EPSILON * high.abs().max(1.0) {
            let middle = 0.5 * (low + high);
            *(if turned(before, at(middle).0) { &mut high } else { &mut low }) = middle;
        }
        let (value, size) = at(low);
        // One that turns without vanishing is no pole.
        (value.norm() < ON_CUT * size).then(|| low.exp())
    })
    .collect()
}

/// Poles of an ARX model: eigenvalues of the companion matrix of its denominator.
pub(super) fn of_arx(arx: &Arx) -> Vec<Pole> {
    let order = arx.a.iter().rposition(|a| *a != 0.0).map_or(0, |last| last + 1);
    if order == 0 {
        return Vec::new();
    }
    let mut companion = DMatrix::zeros(order, order);
    for (i, a) in arx.a.iter().take(order).enumerate() {
        companion[(0, i)] = -a;
        if i + 1 < order {
            companion[(i + 1, i)] = 1.0;
        }
    }
    // As 1 − a. Rounding spreads a multiple eigenvalue into a ring about itself.
    let mut left: Vec<Complex64> =
        companion.complex_eigenvalues().iter().map(|z| Complex64::new(1.0 - z.re, -z.im)).collect();
    let mut poles = Vec::new();
    while let Some(one) = left.pop() {
        let near = |other: &Complex64| (other - one).norm() < SPLIT * one.norm();
        let ring: Vec<Complex64> = std::iter::once(one).chain(left.iter().copied().filter(near)).collect();
        left.retain(|other| !near(other));
        let mut middle = ring.iter().sum::<Complex64>() / ring.len() as f64;
        if middle.im.abs() < 0.1 * SPLIT * middle.norm() {
            middle.im = 0.0;
        }
        if middle.im >= 0.0 {
            poles.extend(side_by_side(middle, ring.len()).map(|place| Pole { place }));
        }
    }
    poles
}

/// `count` places about one, far enough apart for weights to resolve them.
fn side_by_side(place: Complex64, count: usize) -> impl Iterator<Item = Complex64> {
    (0..count).map(move |j| place * (1.0 + SPLIT * (j as f64 - 0.5 * (count as f64 - 1.0))))
}

/// Angles about a resonance at `s` \[rad/s\]: as dense as it is narrow.
pub(super) fn about(s: Complex64, period: f64) -> impl Iterator<Item = f64> {
    (-12..=12).map(move |k: i32| (s.im + s.re.abs() * (0.45 * f64::from(k)).sinh()) * period)
}

/// Angles from `low` to `high` on a logarithmic scale, `per_decade` per decade.
pub(super) fn logarithmic(low: f64, high: f64, per_decade: usize) -> impl Iterator<Item = f64> {
    let count = ((high / low).log10() * per_decade as f64).ceil().max(1.0) as usize;
    (0..=count).map(move |k| low * (high / low).powf(k as f64 / count as f64))
}

/// Angles evenly over the upper part of (0, π].
pub(super) fn upper_half(count: usize) -> impl Iterator<Item = f64> {
    (0..=count).map(move |k| PI * (0.2 + 0.8 * k as f64 / count as f64))
}
