//! Values and derivatives of a candidate's response, block by block of frequencies.

use super::blocks::BLOCK;
use super::error::check_length;
use super::linearised::TermTangent;
use super::shift::InputFactor;
use super::transfer_function::{highest_index, lowest_index};
use super::{DynamicsError, Linearised, Response, Sampling, SimulationPlan, Term, TransferFunction};
use crate::numeric::{
    Complex64, InstructionSet, accumulate_power, accumulate_tangent, multiply_quotient, quotient_parts,
    quotient_tangent,
};

/// Derivative of a response in one direction.
#[derive(Clone, Debug)]
pub(super) struct Tangent {
    pub(super) bins: Vec<Complex64>,
    /// Zero at every frequency; the bins are then not written.
    pub(super) zero: bool,
    polynomials: Polynomials,
}

impl Tangent {
    pub(super) fn new(bins: usize) -> Self {
        Self { bins: vec![Complex64::ZERO; bins], zero: true, polynomials: Polynomials::ZERO }
    }
}

/// Real and imaginary parts over one block of frequencies.
#[derive(Clone, Debug)]
struct Block {
    re: [f64; BLOCK],
    im: [f64; BLOCK],
}

impl Block {
    const ZERO: Self = Self { re: [0.0; BLOCK], im: [0.0; BLOCK] };

    fn first(&self, count: usize) -> (&[f64], &[f64]) {
        (&self.re[..count], &self.im[..count])
    }

    fn first_mut(&mut self, count: usize) -> (&mut [f64], &mut [f64]) {
        (&mut self.re[..count], &mut self.im[..count])
    }

    fn fill(&mut self, value: f64, count: usize) {
        self.re[..count].fill(value);
        self.im[..count].fill(0.0);
    }
}

/// Numerator and denominator, or their derivatives, over one block.
#[derive(Clone, Debug)]
struct Polynomials {
    numerator: Block,
    denominator: Block,
}

impl Polynomials {
    const ZERO: Self = Self { numerator: Block::ZERO, denominator: Block::ZERO };

    fn clear(&mut self, count: usize) {
        self.numerator.fill(0.0, count);
        self.denominator.fill(0.0, count);
    }
}

/// One of the two polynomials of a transfer function.
#[derive(Clone, Copy)]
enum Part {
    Numerator,
    Denominator,
}

impl Part {
    fn terms(self, tf: &TransferFunction) -> &[Term] {
        match self {
            Part::Numerator => &tf.numerator,
            Part::Denominator => &tf.denominator,
        }
    }

    fn tangents(self, linearised: Option<&Linearised>, term: usize) -> &[TermTangent] {
        match (self, linearised) {
            (Part::Numerator, Some(linearised)) => linearised.numerator_term(term),
            (Part::Denominator, Some(linearised)) => linearised.denominator_term(term),
            (_, None) => &[],
        }
    }

    fn of(self, polynomials: &mut Polynomials) -> &mut Block {
        match self {
            Part::Numerator => &mut polynomials.numerator,
            Part::Denominator => &mut polynomials.denominator,
        }
    }
}

/// A candidate: its transfer function and, where asked for, the derivatives.
#[derive(Clone, Copy)]
struct Candidate<'a> {
    tf: &'a TransferFunction,
    linearised: Option<&'a Linearised>,
    set: InstructionSet,
}

impl Candidate<'_> {
    /// The polynomials over one block at ln s = `log_abs` + i `angle`, and their derivatives. Terms of equal order
    /// above and below share one power.
    fn sum(&self, log_abs: &[f64], angle: &[f64], values: &mut Polynomials, tangents: &mut [Tangent]) {
        let count = log_abs.len();
        values.clear(count);
        for tangent in tangents.iter_mut().filter(|tangent| !tangent.zero) {
            tangent.polynomials.clear(count);
        }
        let mut power = Block::ZERO;
        let mut next = [(Part::Numerator, 0), (Part::Denominator, 0)];
        loop {
            let order_of = |(part, i): (Part, usize)| part.terms(self.tf).get(i).map(|term| term.order);
            let Some(order) = next.into_iter().filter_map(order_of).min_by(f64::total_cmp) else { return };
            self.raise(order, log_abs, angle, &mut power);
            let power = power.first(count);
            for (part, i) in &mut next {
                let Some(term) = part.terms(self.tf).get(*i).filter(|term| term.order == order) else {
                    continue;
                };
                let add = |t: TermTangent, to: &mut Block| {
                    let (slope, weight) = (t.coefficient, t.weighted_order);
                    accumulate_tangent(self.set, slope, weight, (log_abs, angle), power, to.first_mut(count));
                };
                let value = TermTangent { coefficient: term.coefficient, weighted_order: 0.0 };
                add(value, part.of(values));
                for (tangent, t) in tangents.iter_mut().zip(part.tangents(self.linearised, *i)) {
                    if !t.is_zero() {
                        add(*t, part.of(&mut tangent.polynomials));
                    }
                }
                *i += 1;
            }
        }
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
}

impl SimulationPlan {
    /// The response of `tf` and, where given, its derivatives.
    pub(super) fn respond(
        &self,
        tf: &TransferFunction,
        linearised: Option<&Linearised>,
        delay_s: f64,
        sampling: Sampling,
        response: &mut Response,
    ) -> Result<(), DynamicsError> {
        check_length("response", response.values.len(), self.log_abs.len())?;
        self.check_candidate(tf)?;
        let factor = InputFactor::new(self, delay_s, sampling)?;
        response.differentiated = false;
        let candidate = Candidate { tf, linearised, set: self.set };
        let Response { values, tangents, .. } = response;
        let Some((delay, parameters)) = tangents.split_last_mut() else { return Ok(()) };
        let parameters = if linearised.is_some() { parameters } else { &mut [] };
        for (which, tangent) in parameters.iter_mut().enumerate() {
            tangent.zero = linearised.is_none_or(|linearised| linearised.is_still(which));
        }
        delay.zero = linearised.is_none() || !factor.depends_on_delay();
        let mut sums = Polynomials::ZERO;
        let (mut e, mut slope) = ([Complex64::ZERO; BLOCK], [Complex64::ZERO; BLOCK]);
        let (mut g, mut w) = (Block::ZERO, Block::ZERO);
        for (block, (log_abs, angle)) in self.log_abs.chunks(BLOCK).zip(self.angle.chunks(BLOCK)).enumerate()
        {
            let (first, count) = (block * BLOCK, log_abs.len());
            let bins = first..first + count;
            candidate.sum(log_abs, angle, &mut sums, parameters);
            factor.write(first, &mut e[..count]);
            let (n, d) = (sums.numerator.first(count), sums.denominator.first(count));
            let out = &mut values[bins.clone()];
            if linearised.is_none() {
                multiply_quotient(self.set, n, d, &e[..count], out);
                continue;
            }
            let (value, weight) = (g.first_mut(count), w.first_mut(count));
            quotient_parts(self.set, n, d, &e[..count], value, weight, out);
            for tangent in parameters.iter_mut().filter(|tangent| !tangent.zero) {
                let Polynomials { numerator, denominator } = &tangent.polynomials;
                let (dn, dd) = (numerator.first(count), denominator.first(count));
                let out = &mut tangent.bins[bins.clone()];
                quotient_tangent(self.set, dn, dd, g.first(count), w.first(count), out);
            }
            if !delay.zero {
                factor.differentiate(first, &e[..count], &mut slope[..count]);
                multiply_quotient(self.set, n, d, &slope[..count], &mut delay.bins[bins]);
            }
        }
        self.response_ends(candidate, &factor, values, parameters, delay);
        response.differentiated = linearised.is_some();
        Ok(())
    }

    /// The first and last frequencies, where s may be 0 or ∞.
    fn response_ends(
        &self,
        candidate: Candidate<'_>,
        factor: &InputFactor<'_>,
        values: &mut [Complex64],
        parameters: &mut [Tangent],
        delay: &mut Tangent,
    ) {
        let (tf, last) = (candidate.tf, values.len() - 1);
        let (mut e, mut slope) = ([Complex64::ZERO; 2], [Complex64::ZERO; 2]);
        for ((bin, e), slope) in [0, last].into_iter().zip(&mut e).zip(&mut slope) {
            factor.write(bin, std::slice::from_mut(e));
            factor.differentiate(bin, &[*e], std::slice::from_mut(slope));
        }
        let (dc, top) = (tf.dc_gain(), tf.high_frequency_gain());
        self.settle_ends(values, dc * e[0].re, top * e[1].re);
        if candidate.linearised.is_none() {
            return;
        }
        for (which, tangent) in parameters.iter_mut().enumerate() {
            let dc = candidate.limit_tangent(lowest_index, which);
            let top = candidate.limit_tangent(highest_index, which);
            self.settle_ends(&mut tangent.bins, dc * e[0].re, top * e[1].re);
        }
        self.settle_ends(&mut delay.bins, dc * slope[0].re, top * slope[1].re);
    }
}

impl Candidate<'_> {
    /// Derivative of the quotient b/a of the terms that rule at one end, 0 where their orders differ.
    fn limit_tangent(&self, ruling: fn(&[Term]) -> usize, which: usize) -> f64 {
        let of = |part: Part| {
            let i = ruling(part.terms(self.tf));
            let term = part.terms(self.tf).get(i)?;
            let tangent = part.tangents(self.linearised, i).get(which)?;
            Some((*term, tangent.coefficient))
        };
        match (of(Part::Numerator), of(Part::Denominator)) {
            (Some((b, db)), Some((a, da))) if b.order == a.order => {
                (db - b.coefficient / a.coefficient * da) / a.coefficient
            }
            _ => 0.0,
        }
    }
}
