//! Numerator and denominator of a candidate, and their derivatives, over the frequencies of a plan.

use std::ops::Range;

use super::blocks::BLOCK;
use super::frequencies::{Frequencies, Panel, Points};
use super::linearised::TermTangent;
use super::tangent::Tangent;
use super::transfer_function::{highest, highest_index, lowest_index};
use super::{Linearised, Term, TransferFunction};
use hysteron_numeric::{InstructionSet, SeriesPanel, accumulate_power, accumulate_tangent};

/// Real and imaginary parts over one block of frequencies.
#[derive(Clone, Debug)]
pub(super) struct Block {
    re: [f64; BLOCK],
    im: [f64; BLOCK],
}

impl Block {
    pub(super) const ZERO: Self = Self { re: [0.0; BLOCK], im: [0.0; BLOCK] };

    pub(super) fn first(&self, count: usize) -> (&[f64], &[f64]) {
        (&self.re[..count], &self.im[..count])
    }

    pub(super) fn first_mut(&mut self, count: usize) -> (&mut [f64], &mut [f64]) {
        (&mut self.re[..count], &mut self.im[..count])
    }

    fn fill(&mut self, value: f64, count: usize) {
        self.re[..count].fill(value);
        self.im[..count].fill(0.0);
    }
}

/// A polynomial in s over the runs of a panel.
#[derive(Clone, Debug)]
struct Series {
    panel: SeriesPanel,
    /// Holds more than a constant.
    varies: bool,
}

impl Series {
    const ZERO: Self = Self { panel: SeriesPanel::ZERO, varies: false };

    fn clear(&mut self) {
        if self.varies {
            self.panel = SeriesPanel::ZERO;
        } else {
            self.panel.re[0] = [0.0; SeriesPanel::LANES];
        }
        self.varies = false;
    }

    fn add_constant(&mut self, value: f64) {
        self.panel.re[0].iter_mut().for_each(|c| *c += value);
    }

    fn add(&mut self, factor: f64, other: &SeriesPanel) {
        self.panel.add(factor, other);
        self.varies = true;
    }

    /// Fills `out`, if the series is the same everywhere.
    fn fill(&self, out: &mut Block) {
        if !self.varies {
            out.fill(self.panel.re[0][0], BLOCK);
        }
    }

    /// Values on a run into `out`, after [`Self::fill`].
    fn evaluate(&self, set: InstructionSet, lane: usize, degree: usize, count: usize, out: &mut Block) {
        if self.varies {
            let (re, im) = out.first_mut(count);
            self.panel.evaluate(set, lane, degree, re, im);
        }
    }
}

/// Numerator and denominator, or their derivatives, over one block of frequencies; as series over the panel
/// it is in.
#[derive(Clone, Debug)]
pub(super) struct Polynomials {
    pub(super) numerator: Block,
    pub(super) denominator: Block,
    numerator_series: Series,
    denominator_series: Series,
}

impl Polynomials {
    pub(super) const ZERO: Self = Self {
        numerator: Block::ZERO,
        denominator: Block::ZERO,
        numerator_series: Series::ZERO,
        denominator_series: Series::ZERO,
    };

    fn clear(&mut self, count: usize) {
        self.numerator.fill(0.0, count);
        self.denominator.fill(0.0, count);
    }

    fn clear_series(&mut self) {
        self.numerator_series.clear();
        self.denominator_series.clear();
    }

    fn fill(&mut self) {
        self.numerator_series.fill(&mut self.numerator);
        self.denominator_series.fill(&mut self.denominator);
    }

    fn evaluate(&mut self, set: InstructionSet, lane: usize, degree: usize, count: usize) {
        self.numerator_series.evaluate(set, lane, degree, count, &mut self.numerator);
        self.denominator_series.evaluate(set, lane, degree, count, &mut self.denominator);
    }
}

/// One of the two polynomials of a transfer function.
#[derive(Clone, Copy)]
enum FractionPart {
    Numerator,
    Denominator,
}

impl FractionPart {
    const BOTH: [Self; 2] = [FractionPart::Numerator, FractionPart::Denominator];

    fn terms(self, tf: &TransferFunction) -> &[Term] {
        match self {
            FractionPart::Numerator => &tf.numerator,
            FractionPart::Denominator => &tf.denominator,
        }
    }

    fn tangents(self, linearised: Option<&Linearised>, term: usize) -> &[TermTangent] {
        match (self, linearised) {
            (FractionPart::Numerator, Some(linearised)) => linearised.numerator_term(term),
            (FractionPart::Denominator, Some(linearised)) => linearised.denominator_term(term),
            (_, None) => &[],
        }
    }

    fn of(self, polynomials: &mut Polynomials) -> &mut Block {
        match self {
            FractionPart::Numerator => &mut polynomials.numerator,
            FractionPart::Denominator => &mut polynomials.denominator,
        }
    }

    fn series_of(self, polynomials: &mut Polynomials) -> &mut Series {
        match self {
            FractionPart::Numerator => &mut polynomials.numerator_series,
            FractionPart::Denominator => &mut polynomials.denominator_series,
        }
    }
}

/// A candidate: its transfer function and, where requested, the derivatives.
#[derive(Clone, Copy)]
pub(super) struct Candidate<'a> {
    pub(super) tf: &'a TransferFunction,
    pub(super) linearised: Option<&'a Linearised>,
    pub(super) set: InstructionSet,
}

impl Candidate<'_> {
    /// Works out numerator and denominator and, for every tangent that is not zero, their derivatives, block
    /// by block of at most [`BLOCK`] frequencies, each once, and hands them to `each`.
    pub(super) fn over(
        &self,
        frequencies: &Frequencies,
        tangents: &mut [Tangent],
        mut each: impl FnMut(Range<usize>, &Polynomials, &mut [Tangent]),
    ) {
        let mut values = Polynomials::ZERO;
        for points in &frequencies.points {
            self.sum(points, &mut values, tangents);
            each(points.first..points.first + points.log_abs.len(), &values, tangents);
        }
        for panel in &frequencies.panels {
            self.sum_series(panel, &mut values, tangents);
            values.fill();
            tangents.iter_mut().filter_map(Tangent::polynomials).for_each(Polynomials::fill);
            for (lane, run) in panel.runs.iter().enumerate().take_while(|(_, run)| run.count > 0) {
                values.evaluate(self.set, lane, run.degree, run.count);
                for polynomials in tangents.iter_mut().filter_map(Tangent::polynomials) {
                    polynomials.evaluate(self.set, lane, run.degree, run.count);
                }
                each(run.first..run.first + run.count, &values, tangents);
            }
        }
    }

    /// Numerator and denominator are both divided by s^shift: with many orders their values, of which only
    /// the quotient is needed, would overflow at high frequencies. 0 up to order 8. The series of the runs
    /// hold sums of such powers to 3e-12 of their terms' size up to order 17, to 1e-10 up to 27.
    fn shift(&self) -> f64 {
        shift(self.tf)
    }

    /// Calls `each` with every order in turn and the terms of this order, above and below: they share one
    /// power.
    fn orders(&self, mut each: impl FnMut(f64, [Option<(FractionPart, usize, Term)>; 2])) {
        let mut next = [0, 0];
        loop {
            let heads: [Option<&Term>; 2] =
                std::array::from_fn(|which| FractionPart::BOTH[which].terms(self.tf).get(next[which]));
            let Some(order) = heads.iter().flatten().map(|term| term.order).min_by(f64::total_cmp) else {
                return;
            };
            let mut terms = [None, None];
            for (which, head) in heads.into_iter().enumerate() {
                if let Some(term) = head.filter(|term| term.order == order) {
                    terms[which] = Some((FractionPart::BOTH[which], next[which], *term));
                    next[which] += 1;
                }
            }
            each(order, terms);
        }
    }

    /// The polynomials point by point.
    fn sum(&self, points: &Points, values: &mut Polynomials, tangents: &mut [Tangent]) {
        let (log_abs, angle) = (&points.log_abs[..], &points.angle[..]);
        let count = log_abs.len();
        values.clear(count);
        for polynomials in tangents.iter_mut().filter_map(Tangent::polynomials) {
            polynomials.clear(count);
        }
        let mut power = Block::ZERO;
        let shift = self.shift();
        self.orders(|order, terms| {
            self.raise(order - shift, log_abs, angle, &mut power);
            let power = power.first(count);
            let add = |t: TermTangent, to: &mut Block| {
                let (slope, weight) = (t.coefficient, t.weighted_order);
                accumulate_tangent(self.set, slope, weight, (log_abs, angle), power, to.first_mut(count));
            };
            for (part, i, term) in terms.into_iter().flatten() {
                let value = TermTangent { coefficient: term.coefficient, weighted_order: 0.0 };
                add(value, part.of(values));
                for (tangent, t) in tangents.iter_mut().zip(part.tangents(self.linearised, i)) {
                    if let Some(polynomials) = tangent.polynomials().filter(|_| !t.is_zero()) {
                        add(*t, part.of(polynomials));
                    }
                }
            }
        });
    }

    /// power = s^order.
    fn raise(&self, order: f64, log_abs: &[f64], angle: &[f64], power: &mut Block) {
        if order == 0.0 {
            return power.fill(1.0, log_abs.len());
        }
        power.fill(0.0, log_abs.len());
        let (re, im) = power.first_mut(log_abs.len());
        accumulate_power(self.set, 1.0, order, log_abs, angle, re, im);
    }

    /// The polynomials as series.
    fn sum_series(&self, panel: &Panel, values: &mut Polynomials, tangents: &mut [Tangent]) {
        values.clear_series();
        for polynomials in tangents.iter_mut().filter_map(Tangent::polynomials) {
            polynomials.clear_series();
        }
        let (mut power, mut product) = (SeriesPanel::ZERO, SeriesPanel::ZERO);
        let shift = self.shift();
        self.orders(|order, terms| {
            let order = order - shift;
            if order != 0.0 {
                SeriesPanel::power(self.set, order, &panel.log, &mut power);
            }
            let add = |coefficient: f64, to: &mut Series| match order {
                0.0 => to.add_constant(coefficient),
                _ => to.add(coefficient, &power),
            };
            // Whether `product` is ln s · s^order, which is worked out for the first that needs it.
            let mut ready = false;
            for (part, i, term) in terms.into_iter().flatten() {
                add(term.coefficient, part.series_of(values));
                for (tangent, t) in tangents.iter_mut().zip(part.tangents(self.linearised, i)) {
                    let Some(polynomials) = tangent.polynomials().filter(|_| !t.is_zero()) else {
                        continue;
                    };
                    let to = part.series_of(polynomials);
                    if t.coefficient != 0.0 {
                        add(t.coefficient, to);
                    }
                    if t.weighted_order != 0.0 {
                        if !ready {
                            match order {
                                0.0 => product.clone_from(&panel.log),
                                _ => SeriesPanel::product(self.set, &power, &panel.log, &mut product),
                            }
                            ready = true;
                        }
                        to.add(t.weighted_order, &product);
                    }
                }
            }
        });
    }

    /// Derivative of the quotient b/a of the dominant terms at one end, 0 where their orders differ.
    fn limit_tangent(&self, ruling: fn(&[Term]) -> usize, which: usize) -> f64 {
        let of = |part: FractionPart| {
            let i = ruling(part.terms(self.tf));
            let term = part.terms(self.tf).get(i)?;
            let tangent = part.tangents(self.linearised, i).get(which)?;
            Some((*term, tangent.coefficient))
        };
        match (of(FractionPart::Numerator), of(FractionPart::Denominator)) {
            (Some((b, db)), Some((a, da))) if b.order == a.order => {
                (db - b.coefficient / a.coefficient * da) / a.coefficient
            }
            _ => 0.0,
        }
    }

    /// Derivative of an order in parameter `which`, 0 where no term has it.
    pub(super) fn order_tangent(&self, order: f64, which: usize) -> f64 {
        let of = |part: FractionPart| {
            let i = part.terms(self.tf).iter().position(|t| t.order == order && t.coefficient != 0.0)?;
            let tangent = part.tangents(self.linearised, i).get(which)?;
            Some(tangent.weighted_order / part.terms(self.tf).get(i)?.coefficient)
        };
        of(FractionPart::Numerator).or_else(|| of(FractionPart::Denominator)).unwrap_or(0.0)
    }

    /// Derivatives of G at the ends s = 0 and s = ∞ in parameter `which`, their orders held.
    pub(super) fn end_tangents(&self, which: usize) -> (f64, f64) {
        (self.limit_tangent(lowest_index, which), self.limit_tangent(highest_index, which))
    }
}

/// Half of the highest order above 8, a whole number.
pub(super) fn shift(tf: &TransferFunction) -> f64 {
    let highest = highest(&tf.numerator).order.max(highest(&tf.denominator).order);
    if highest > 8.0 { (0.5 * highest).floor() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::super::blocks::frequencies;
    use super::super::{Creep, DynamicForm, Modes, Scheme};
    use super::*;
    use hysteron_numeric::Complex64;

    /// Bin by bin: numerator and denominator, then those of each tangent.
    fn collect(candidate: Candidate<'_>, grid: &Frequencies, parameters: usize) -> Vec<Vec<Complex64>> {
        let mut tangents = vec![Tangent::new(0); parameters];
        for (which, tangent) in tangents.iter_mut().enumerate() {
            tangent.zero = candidate.linearised.is_none_or(|linearised| linearised.is_still(which));
        }
        let mut bins = vec![Vec::new(); grid.bins];
        candidate.over(grid, &mut tangents, |range, values, tangents| {
            let mut all = vec![values.clone()];
            all.extend(tangents.iter_mut().filter_map(|t| t.polynomials().cloned()));
            for (j, bin) in range.enumerate() {
                assert!(bins[bin].is_empty(), "bin {bin} comes twice");
                bins[bin] = all
                    .iter()
                    .flat_map(|p| [&p.numerator, &p.denominator])
                    .map(|block| Complex64::new(block.re[j], block.im[j]))
                    .collect();
            }
        });
        bins
    }

    /// Σ |coefficient + weighted order · ln s| |s|^order: what rounding is relative to.
    fn size(terms: &[Term], shift: f64, tangents: impl Fn(usize) -> TermTangent, ln: Complex64) -> f64 {
        let of = |(i, term): (usize, &Term)| {
            let t = tangents(i);
            (t.coefficient.abs() + t.weighted_order.abs() * ln.norm()) * ((term.order - shift) * ln.re).exp()
        };
        terms.iter().enumerate().map(of).sum()
    }

    #[test]
    fn by_series_they_are_what_they_are_point_by_point() {
        let (length, damping, rate) = (20_000, 23.0 / 20_000.0, 1e4);
        let forms: [(Modes, Creep, &[f64]); 6] = [
            (Modes::Fractional, Creep::None, &[320.0, 0.62, 1.94, 1.05]),
            (Modes::Fractional, Creep::Fractional, &[320.0, 0.62, 2.0, 1.0, 0.08, 0.12]),
            (
                Modes::TwoFractional,
                Creep::Fractional,
                &[320.0, 0.62, 1.94, 1.05, 710.0, 0.21, 1.87, 0.93, 0.7, 0.08, 0.12],
            ),
            (Modes::Fractional, Creep::Logarithmic, &[320.0, 0.62, 1.94, 1.05, 0.02, 0.1]),
            (
                Modes::Resonances { count: 3, lag: true },
                Creep::KelvinVoigt { elements: 2 },
                &[320.0, 0.1, 710.0, 0.02, 800.0, 0.03, 0.6, -0.1, 1e-4, 0.05, 0.1, 0.02, 3.0],
            ),
            (
                Modes::Resonances { count: 6, lag: true },
                Creep::Logarithmic,
                &[
                    320.0, 0.1, 710.0, 0.02, 800.0, 0.03, 950.0, 0.1, 1300.0, 0.1, 1700.0, 0.1, 0.6, -0.1,
                    0.2, 0.1, 0.1, 1e-4, 0.02, 0.1,
                ],
            ),
        ];
        for scheme in Scheme::ALL {
            let grid = Frequencies::new(scheme, length, damping, rate);
            let (log_abs, angle) = frequencies(scheme, length, damping, rate, 0, grid.bins);
            let points = (0..grid.bins).step_by(BLOCK).map(|first| {
                let bins = first..(first + BLOCK).min(grid.bins);
                Points { first, log_abs: log_abs[bins.clone()].to_vec(), angle: angle[bins].to_vec() }
            });
            let oracle =
                Frequencies { bins: grid.bins, top: grid.top, points: points.collect(), panels: Vec::new() };
            for (modes, creep, p) in &forms {
                let mut linearised = Linearised::new();
                DynamicForm { modes: *modes, creep: *creep }.linearise(p, &mut linearised).unwrap();
                let set = InstructionSet::detected();
                let tf = &linearised.transfer_function;
                let candidate = Candidate { tf, linearised: Some(&linearised), set };
                let found = collect(candidate, &grid, p.len());
                let expected = collect(candidate, &oracle, p.len());
                let mut worst = 0.0f64;
                let moving: Vec<usize> = (0..p.len()).filter(|&i| !linearised.is_still(i)).collect();
                for (bin, (found, expected)) in found.iter().zip(&expected).enumerate() {
                    let ln = Complex64::new(log_abs[bin], angle[bin]);
                    let value = |part: FractionPart| {
                        let terms = part.terms(tf);
                        let of =
                            |i: usize| TermTangent { coefficient: terms[i].coefficient, weighted_order: 0.0 };
                        size(terms, shift(tf), of, ln)
                    };
                    let slope = |part: FractionPart, which: usize| {
                        let of = |i: usize| part.tangents(Some(&linearised), i)[which];
                        size(part.terms(tf), shift(tf), of, ln)
                    };
                    let sizes = FractionPart::BOTH.map(value).into_iter().chain(
                        moving.iter().flat_map(|&which| FractionPart::BOTH.map(|part| slope(part, which))),
                    );
                    assert_eq!(found.len(), 2 + 2 * moving.len());
                    for ((found, expected), size) in found.iter().zip(expected).zip(sizes) {
                        let error = (found - expected).norm();
                        worst = worst.max(error / size);
                        // Exponents of up to 60 are rounded to half a unit. High powers need more terms of a
                        // series than there are.
                        let allowed = match shift(tf) {
                            0.0 => 5e-14,
                            few if few <= 8.0 => 3e-12,
                            _ => 1e-10,
                        };
                        assert!(
                            error <= allowed * size,
                            "{scheme} {modes:?} at {bin}: {error:e} of {size:e}"
                        );
                    }
                }
                println!("{scheme} {modes:?} {creep:?}: {worst:.1e}");
            }
        }
    }
}
