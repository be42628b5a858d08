//! Images of a staircase or a polygon: its content above half its sample rate, as an addition to G.
//!
//! With s′ = sh, h the sample period of the drive, and s′ₖ = s′ + 2πik, the samples of the response to a
//! staircase (p = 1) or a polygon (p = 2) behind a delay τ are those of
//!
//! E (G + s′^p Cₚ),  Cₚ(s′) = Σ qᵏ G(s′ₖ/h)/s′ₖ^p over k ≠ 0,  q = e^(−2πiτ/h),
//!
//! E the factor of delay and reconstruction, e^(−sτ) being taken at the s of each image; the derivative in τ
//! is −s E (G + s′^(p−1) Cₚ₋₁). Within the band Cₚ is smooth: its singularities are those of G in the
//! neighbouring bands. It is worked out at a few nodes, all images of them ([`BlockRule`]), and interpolated.
//! The nearest images are worked out at every frequency instead where that is not enough: where a resonance
//! lies above half the sample rate, or close to it. Resonances beyond [`NEAR`] times the sample rate are not
//! resolved.
//!
//! A direct term d of G jumps with the staircase. Its sum over all k has the closed form Σ qᵏ/s′ₖ =
//! e^(−s′φ)/(1 − e^(−s′)), q = e^(2πiφ), 0 ≤ φ < 1, continuous from the right; and minus its derivative in s′
//! for p = 2.

mod weights;

use std::f64::consts::TAU;
use std::sync::OnceLock;

use super::blocks::BLOCK;
use super::frequencies::{Frequencies, Points};
use super::plan::LARGEST;
use super::sums::{self, Block, Candidate};
use super::tangent::Tangent;
use super::transfer_function::highest;
use super::{SimulationPlan, Term, TransferFunction};
use hysteron_numeric::{
    Complex64, InstructionSet, SeriesPanel, multiply_and_add, multiply_by, multiply_quotient, quotient_parts,
    quotient_tangent,
};
use weights::{BlockRule, PLACES, cardinal, node, turn};

/// Images to either side that are interpolated by pieces, or worked out at every frequency.
const NEAR: usize = 3;
/// Pieces of the band, of equal width, and nodes of each.
const PIECES: usize = 8;
const NODES: usize = SeriesPanel::TERMS;
/// Nodes of the band for the other images.
const FAR_NODES: usize = 7;
/// Nodes of the pieces; those of the other images come behind them.
const NEAR_NODES: usize = PIECES * NODES;
/// The last coefficients of a piece, as a share of the largest value, above which the nearest images are not
/// interpolated.
const UNRESOLVED: f64 = 3e-8;

/// Everything about the images of a plan that does not depend on the candidate.
#[derive(Debug)]
pub(super) struct Images {
    /// p.
    power: i32,
    /// h in sample periods of the plan, whose frequencies are s = damping + i·step·bin.
    period: f64,
    damping: f64,
    step: f64,
    /// Length of the transforms.
    length: usize,
    /// Logarithm of the sample rate of the drive.
    log_rate: f64,
    rule: BlockRule,
    /// All images of all nodes.
    points: Frequencies,
    /// Node and weight of each point; weights of the images below come behind those of the images above.
    places: Vec<(usize, usize)>,
    /// s′ₖ^−p and s′ₖ^(1 − p) at each point.
    falls: [Vec<Complex64>; 2],
    /// s′ of the nodes of the pieces.
    nodes: Vec<Complex64>,
    /// s′^p of every bin.
    rises: Vec<Complex64>,
    /// From the nodes of the far images to those of the pieces.
    spread: Vec<[f64; FAR_NODES]>,
    /// From the values at the nodes of a piece to its coefficients.
    coefficients: [[f64; NODES]; NODES],
    /// The nearest images of every frequency.
    nearest: OnceLock<Vec<Frequencies>>,
}

/// Weights of a candidate's images.
pub(super) struct ImageWeights {
    /// For Cₚ and Cₚ₋₁.
    weights: [[Complex64; 2 * PLACES]; 2],
    /// Derivative of those for Cₚ in how fast G falls.
    slopes: [Complex64; 2 * PLACES],
    /// Delay in periods of the drive.
    turns: f64,
    /// G(∞).
    gain: f64,
}

/// Number in sums of images: the nodes of the pieces and of the far images, later the coefficients of the
/// pieces.
pub(super) const SUMS: usize = NEAR_NODES + FAR_NODES;

impl Images {
    /// Images of the staircase (`power` 1) or the polygon (2) that drives the inputs of a plan.
    pub(super) fn new(plan: &SimulationPlan, power: i32) -> Self {
        let (length, period) = (plan.transform_length(), plan.drive_period);
        let mut images = Self {
            power,
            period,
            damping: plan.damping,
            step: TAU / length as f64,
            length,
            log_rate: (plan.sample_rate_hz / period).ln(),
            rule: BlockRule::new(),
            points: Frequencies { bins: 0, top: f64::NEG_INFINITY, points: Vec::new(), panels: Vec::new() },
            places: Vec::new(),
            falls: [Vec::new(), Vec::new()],
            nodes: Vec::new(),
            rises: Vec::new(),
            spread: Vec::new(),
            coefficients: coefficients(),
            nearest: OnceLock::new(),
        };
        let half = 0.5 * length as f64;
        let far_bins: [f64; FAR_NODES] = std::array::from_fn(|j| 0.5 * half * (1.0 + node(FAR_NODES, j)));
        let near_bins: Vec<f64> = (0..NEAR_NODES)
            .map(|j| {
                let (piece, j) = (j / NODES, j % NODES);
                half / PIECES as f64 * (piece as f64 + 0.5 * (1.0 + node(NODES, j)))
            })
            .collect();
        images.rises = (0..=length / 2).map(|bin| images.place(bin as f64).powi(power)).collect();
        images.nodes = near_bins.iter().map(|bin| images.place(*bin)).collect();
        let row = |bin: &f64| std::array::from_fn(|j| cardinal(FAR_NODES, j, 2.0 * bin / half - 1.0));
        images.spread = near_bins.iter().map(row).collect();
        let (mut at, mut shares) = (Vec::new(), Vec::new());
        for (which, k) in images.rule.places().into_iter().enumerate() {
            let (bins, first) = if which < NEAR { (&near_bins[..], 0) } else { (&far_bins[..], NEAR_NODES) };
            for (k, weight) in [(k, which), (-k, PLACES + which)] {
                for (j, bin) in bins.iter().enumerate() {
                    let image = Complex64::new(0.0, TAU * k);
                    let s = images.place(*bin);
                    at.push(s + image);
                    shares.push(if which == PLACES - 1 { s / image } else { Complex64::ONE });
                    images.places.push((first + j, weight));
                }
            }
        }
        images.falls = [power, power - 1].map(|power| {
            let fall = |(s, share): (&Complex64, &Complex64)| s.powi(-power) * share;
            at.iter().zip(&shares).map(fall).collect()
        });
        images.points = images.frequencies(&at);
        images
    }

    /// s′ at a bin or between two.
    fn place(&self, bin: f64) -> Complex64 {
        Complex64::new(self.damping, self.step * bin) * self.period
    }

    /// ln s at many s′, point by point.
    fn frequencies(&self, at: &[Complex64]) -> Frequencies {
        let points = at.chunks(BLOCK).enumerate().map(|(block, at)| Points {
            first: block * BLOCK,
            log_abs: at.iter().map(|s| s.norm().ln() + self.log_rate).collect(),
            angle: at.iter().map(|s| s.arg()).collect(),
        });
        let points: Vec<Points> = points.collect();
        let top = points.iter().flat_map(|p| &p.log_abs).copied().fold(f64::NEG_INFINITY, f64::max);
        Frequencies { bins: at.len(), top, points, panels: Vec::new() }
    }

    /// Weights for a candidate behind a delay of `turns` periods of the drive; `None` where G grows with
    /// frequency, so that its samples do not exist, or overflows at the highest image.
    pub(super) fn weights(&self, tf: &TransferFunction, turns: f64) -> Option<ImageWeights> {
        let HighEnd { gain, fall, .. } = HighEnd::of(tf)?;
        // Squares of the polynomials must stay in range here too.
        let shift = sums::shift(tf);
        let size = |term: &Term| term.coefficient.abs().ln() + (term.order - shift) * self.points.top;
        if tf.numerator.iter().chain(&tf.denominator).any(|term| size(term) > LARGEST) {
            return None;
        }
        let [own, before] =
            [self.power, self.power - 1].map(|power| self.rule.weights(turns, f64::from(power) + fall));
        let mut slopes = [Complex64::ZERO; PLACES];
        slopes[PLACES - 2..].copy_from_slice(&self.rule.slopes(&own));
        let weights = [both_sides(&own.at_places), both_sides(&before.at_places)];
        Some(ImageWeights { weights, slopes: both_sides(&slopes), turns, gain })
    }

    /// Cₚ of the candidate and of its derivatives, and Cₚ₋₁ into `delay`, as coefficients of the pieces.
    /// `false` where the nearest images are left out, because pieces do not resolve them.
    pub(super) fn sum(
        &self,
        candidate: Candidate<'_>,
        weights: &ImageWeights,
        value: &mut [Complex64],
        tangents: &mut [Tangent],
        delay: &mut [Complex64],
    ) -> bool {
        let ImageWeights { weights: [own, before], slopes, gain, .. } = weights;
        let set = candidate.set;
        // Derivative of the value in the roll-off order of G − G(∞).
        let mut moved = [Complex64::ZERO; SUMS];
        let (mut g, mut w) = (Block::ZERO, Block::ZERO);
        let mut out = [Complex64::ZERO; BLOCK];
        for sums in [&mut *value, &mut *delay] {
            sums.fill(Complex64::ZERO);
        }
        for (which, tangent) in tangents.iter_mut().enumerate().filter(|(_, tangent)| !tangent.zero) {
            tangent.images.fill(Complex64::ZERO);
            tangent.gain = if *gain == 0.0 { 0.0 } else { candidate.end_tangents(which).1 };
        }
        candidate.over(&self.points, tangents, |points, sums, tangents| {
            let count = points.len();
            let [fall, slower] = [&self.falls[0][points.clone()], &self.falls[1][points.clone()]];
            let places = &self.places[points];
            let (n, d) = (sums.numerator.first(count), sums.denominator.first(count));
            quotient_parts(set, n, d, fall, g.first_mut(count), w.first_mut(count), &mut out[..count]);
            gather(own, *gain, fall, &out, places, value);
            if candidate.linearised.is_some() {
                gather(slopes, *gain, fall, &out, places, &mut moved);
            }
            for tangent in tangents.iter_mut().filter(|tangent| !tangent.zero) {
                let (dn, dd) = (
                    tangent.polynomials.numerator.first(count),
                    tangent.polynomials.denominator.first(count),
                );
                quotient_tangent(set, dn, dd, g.first(count), w.first(count), &mut out[..count]);
                gather(own, tangent.gain, fall, &out, places, &mut tangent.images[..]);
            }
            if !delay.is_empty() {
                multiply_quotient(set, n, d, slower, &mut out[..count]);
                gather(before, *gain, slower, &out, places, delay);
            }
        });
        for (which, tangent) in tangents.iter_mut().enumerate().filter(|(_, tangent)| !tangent.zero) {
            let slope = HighEnd::of(candidate.tf).map_or(0.0, |end| end.fall_tangent(candidate, which));
            tangent.images.iter_mut().zip(moved).for_each(|(sum, moved)| *sum += moved * slope);
        }
        let resolved = self.resolves(value);
        self.finish(value, resolved, (*gain, self.power, weights.turns));
        for tangent in tangents.iter_mut().filter(|tangent| !tangent.zero) {
            self.finish(&mut tangent.images[..], resolved, (tangent.gain, self.power, weights.turns));
        }
        if !delay.is_empty() {
            self.finish(delay, resolved, (*gain, self.power - 1, weights.turns));
        }
        resolved
    }

    /// True if the pieces resolve the sums at their nodes.
    fn resolves(&self, sums: &[Complex64]) -> bool {
        let largest = sums[..NEAR_NODES].iter().map(|x| x.norm()).fold(0.0, f64::max);
        sums[..NEAR_NODES].chunks_exact(NODES).all(|values| {
            [NODES - 2, NODES - 1].into_iter().all(|order| {
                let row = &self.coefficients[order];
                let leading: Complex64 = row.iter().zip(values).map(|(c, x)| x * *c).sum();
                // Of the Chebyshev polynomial of this order the leading coefficient is 2^(order − 1).
                leading.norm() <= UNRESOLVED * largest * 2f64.powi(order as i32 - 1)
            })
        })
    }

    /// From sums at nodes to coefficients of the pieces; the contribution of `gain` to C of this power is in
    /// closed form.
    fn finish(&self, sums: &mut [Complex64], with_nearest: bool, (gain, power, turns): (f64, i32, f64)) {
        let (near, far) = sums.split_at_mut(NEAR_NODES);
        for ((near, spread), s) in near.iter_mut().zip(&self.spread).zip(&self.nodes) {
            if !with_nearest {
                *near = Complex64::ZERO;
            }
            *near += spread.iter().zip(&*far).map(|(c, x)| x * *c).sum::<Complex64>();
            if gain != 0.0 {
                *near += jump(*s, power, turns) * gain;
            }
        }
        for values in near.chunks_exact_mut(NODES) {
            let at_nodes: [Complex64; NODES] = std::array::from_fn(|j| values[j]);
            for (value, row) in values.iter_mut().zip(&self.coefficients) {
                *value = row.iter().zip(at_nodes).map(|(c, x)| x * *c).sum();
            }
        }
    }

    /// `factors` of the bins from `first` on, times s′^p, or s′^(p − 1) where `slower`.
    pub(super) fn raise(&self, set: InstructionSet, first: usize, slower: bool, factors: &mut [Complex64]) {
        if !slower {
            multiply_by(set, &self.rises[first..], factors);
        } else if self.power == 2 {
            for (j, factor) in factors.iter_mut().enumerate() {
                *factor *= self.place((first + j) as f64);
            }
        }
    }

    /// Adds `factors` times the sum of images to the bins from `first` on.
    pub(super) fn add(
        &self,
        set: InstructionSet,
        coefficients: &[Complex64],
        first: usize,
        factors: &[Complex64],
        out: &mut [Complex64],
    ) {
        let piece_bins = 0.5 * self.length as f64 / PIECES as f64;
        let (mut re, mut im) = ([0.0; BLOCK], [0.0; BLOCK]);
        let mut done = 0;
        while done < out.len() {
            let from = first + done;
            let piece = ((from as f64 / piece_bins) as usize).min(PIECES - 1);
            let end = if piece + 1 < PIECES {
                ((piece + 1) as f64 * piece_bins).ceil() as usize
            } else {
                usize::MAX
            };
            let count = (out.len() - done).min((end - from).max(1));
            let middle = from as f64 + 0.5 * (count - 1) as f64;
            let mut c: [Complex64; NODES] = std::array::from_fn(|j| coefficients[piece * NODES + j]);
            let y = 2.0 * (middle / piece_bins - piece as f64) - 1.0;
            // Taylor's series about the middle, in bins.
            for order in 0..NODES {
                for j in (order..NODES - 1).rev() {
                    let next = c[j + 1];
                    c[j] += next * y;
                }
            }
            let mut scale = 1.0;
            let c = c.map(|c| {
                let scaled = [c.re * scale, c.im * scale];
                scale *= 2.0 / piece_bins;
                scaled
            });
            SeriesPanel::evaluate_one(set, &c, NODES - 1, &mut re[..count], &mut im[..count]);
            let part = done..done + count;
            multiply_and_add(set, &factors[part.clone()], (&re, &im), &mut out[part]);
            done += count;
        }
    }

    /// The nearest images at every frequency, each with its frequencies.
    pub(super) fn nearest(&self) -> impl Iterator<Item = (NearImage, &Frequencies)> {
        let all = self.nearest.get_or_init(|| {
            let of = |image: NearImage| {
                let at: Vec<Complex64> = (0..=self.length / 2).map(|bin| self.image(bin, image)).collect();
                self.frequencies(&at)
            };
            NearImage::all().map(of).collect()
        });
        NearImage::all().zip(all)
    }

    fn image(&self, bin: usize, image: NearImage) -> Complex64 {
        self.place(bin as f64) + Complex64::new(0.0, TAU * f64::from(image.0))
    }

    /// `factors` of the bins from `first` on, times what the value of G at an image is weighted with: qᵏ
    /// (s′/s′ₖ)^p, or with p − 1 where `slower`.
    pub(super) fn weigh(
        &self,
        image: NearImage,
        weights: &ImageWeights,
        (first, slower): (usize, bool),
        factors: &mut [Complex64],
    ) {
        let phase = turn(weights.turns * f64::from(image.0));
        for (j, factor) in factors.iter_mut().enumerate() {
            let ratio = self.place((first + j) as f64) / self.image(first + j, image);
            *factor *= phase * ratio.powi(self.power - i32::from(slower));
        }
    }
}

/// Number of an image, −[`NEAR`] to [`NEAR`].
#[derive(Clone, Copy)]
pub(super) struct NearImage(i32);

impl NearImage {
    fn all() -> impl Iterator<Item = Self> {
        (1..=NEAR as i32).flat_map(|k| [Self(k), Self(-k)])
    }
}

impl ImageWeights {
    /// G(∞).
    pub(super) fn gain(&self) -> f64 {
        self.gain
    }
}

/// Adds the values, without the direct term, to the sums of their nodes.
fn gather(
    weights: &[Complex64; 2 * PLACES],
    gain: f64,
    falls: &[Complex64],
    values: &[Complex64],
    places: &[(usize, usize)],
    sums: &mut [Complex64],
) {
    for ((value, fall), &(node, weight)) in values.iter().zip(falls).zip(places) {
        sums[node] += (value - fall * gain) * weights[weight];
    }
}

/// Σ qᵏ/s′ₖ^power over k ≠ 0, power 0 to 2, q = e^(−2πi·turns): for power 0, whose sum over all k is 0
/// between jumps, −1.
fn jump(s: Complex64, power: i32, turns: f64) -> Complex64 {
    let phase = turns.ceil() - turns;
    let less = 1.0 - (-s).exp();
    let turned = (-s * phase).exp();
    match power {
        0 => Complex64::from(-1.0),
        1 => turned / less - s.inv(),
        _ => turned * (less * phase + (-s).exp()) / (less * less) - s.powi(-2),
    }
}

/// Weights of images above and, conjugate, below.
fn both_sides(above: &[Complex64; PLACES]) -> [Complex64; 2 * PLACES] {
    let mut weights = [Complex64::ZERO; 2 * PLACES];
    weights[..PLACES].copy_from_slice(above);
    weights[PLACES..].iter_mut().zip(above).for_each(|(below, above)| *below = above.conj());
    weights
}

/// High-frequency asymptote of G.
struct HighEnd {
    /// d = G(∞).
    gain: f64,
    /// G − d falls as s^−fall.
    fall: f64,
    /// The orders whose difference that is.
    orders: Option<[f64; 2]>,
}

impl HighEnd {
    /// `None` where G grows.
    fn of(tf: &TransferFunction) -> Option<Self> {
        /// `fall` of a constant, whose G − d is 0.
        const AT_ONCE: f64 = 40.0;
        let (b, a) = (highest(&tf.numerator), highest(&tf.denominator));
        if b.order > a.order {
            return None;
        }
        if b.order < a.order || b.coefficient == 0.0 {
            return Some(Self { gain: 0.0, fall: a.order - b.order, orders: Some([a.order, b.order]) });
        }
        let gain = b.coefficient / a.coefficient;
        let remains = |order: &f64| {
            let sum = |terms: &[Term]| -> f64 {
                terms.iter().filter(|term| term.order == *order).map(|term| term.coefficient).sum()
            };
            sum(&tf.numerator) - gain * sum(&tf.denominator) != 0.0
        };
        let below = tf.numerator.iter().chain(&tf.denominator).map(|term| term.order);
        let next = below.filter(|order| *order < a.order).filter(remains).max_by(f64::total_cmp);
        let fall = next.map_or(AT_ONCE, |next| a.order - next);
        Some(Self { gain, fall, orders: next.map(|next| [a.order, next]) })
    }

    /// Derivative of the fall in parameter `which`.
    fn fall_tangent(&self, candidate: Candidate<'_>, which: usize) -> f64 {
        self.orders.map_or(0.0, |orders| {
            let [upper, lower] = orders.map(|order| candidate.order_tangent(order, which));
            upper - lower
        })
    }
}

/// Row `order`: from the values at Chebyshev nodes to the coefficient of y^order.
fn coefficients() -> [[f64; NODES]; NODES] {
    let mut rows = [[0.0; NODES]; NODES];
    for j in 0..NODES {
        let x = node(NODES, j);
        // T_m(y) by its coefficients, and T_m(x).
        let (mut before, mut now) = ([0.0; NODES + 1], [0.0; NODES + 1]);
        let (mut at_before, mut at_now) = (1.0, x);
        (before[0], now[1]) = (1.0, 1.0);
        rows[0][j] += 1.0 / NODES as f64;
        for _ in 1..NODES {
            for (row, c) in rows.iter_mut().zip(now) {
                row[j] += 2.0 / NODES as f64 * at_now * c;
            }
            let mut next = [0.0; NODES + 1];
            for order in 0..=NODES {
                let raised = if order > 0 { now[order - 1] } else { 0.0 };
                next[order] = 2.0 * raised - before[order];
            }
            (before, now) = (now, next);
            (at_before, at_now) = (at_now, 2.0 * x * at_now - at_before);
        }
    }
    rows
}
