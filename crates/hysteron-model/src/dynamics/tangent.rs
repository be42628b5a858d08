//! Values and derivatives of a candidate's response, block by block of frequencies.

use super::blocks::BLOCK;
use super::images::{ImageWeights, Images, SUMS};
use super::shift::InputFactor;
use super::stability::stability;
use super::sums::{Block, Candidate, Polynomials};
use super::{DynamicsError, Linearised, Response, Sampling, SimulationPlan, TransferFunction};
use crate::dynamics_error::check_length;
use hysteron_numeric::{Complex64, multiply_quotient, quotient_parts, quotient_tangent};

/// Derivative of a response in one direction.
#[derive(Clone, Debug)]
pub(super) struct Tangent {
    pub(super) bins: Vec<Complex64>,
    /// Zero at every frequency; the bins are then not written.
    pub(super) zero: bool,
    pub(super) polynomials: Box<Polynomials>,
    /// Its images, and its value at infinite frequency.
    pub(super) images: Box<[Complex64; SUMS]>,
    pub(super) gain: f64,
}

impl Tangent {
    pub(super) fn new(bins: usize) -> Self {
        Self {
            bins: vec![Complex64::ZERO; bins],
            zero: true,
            polynomials: Box::new(Polynomials::ZERO),
            images: Box::new([Complex64::ZERO; SUMS]),
            gain: 0.0,
        }
    }

    /// Derivatives of numerator and denominator, unless they are zero.
    pub(super) fn polynomials(&mut self) -> Option<&mut Polynomials> {
        (!self.zero).then_some(&mut self.polynomials)
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
        check_length("response", response.values.len(), self.bins())?;
        self.check_candidate(tf, || linearised.map_or_else(|| stability(tf), Linearised::stability))?;
        let factor = InputFactor::new(self, delay_s, sampling)?;
        response.differentiated = false;
        let candidate = Candidate { tf, linearised, set: self.set };
        let Response { values, tangents, images: value_images, .. } = response;
        let Some((delay, parameters)) = tangents.split_last_mut() else { return Ok(()) };
        let parameters = if linearised.is_some() { parameters } else { &mut [] };
        for (which, tangent) in parameters.iter_mut().enumerate() {
            tangent.zero = linearised.is_none_or(|linearised| linearised.is_still(which));
        }
        delay.zero = linearised.is_none() || !factor.depends_on_delay();
        let images = factor.images().and_then(|images| Some((images, images.weights(tf, factor.turns())?)));
        let with_nearest = images.as_ref().is_none_or(|(images, weights)| {
            let own_slope = !delay.zero && factor.turns_images();
            let delay = if own_slope { &mut delay.images[..] } else { &mut [] };
            images.sum(candidate, weights, &mut value_images[..], parameters, delay)
        });
        let (mut e, mut slope) = ([Complex64::ZERO; BLOCK], [Complex64::ZERO; BLOCK]);
        let (mut g, mut w) = (Block::ZERO, Block::ZERO);
        candidate.over(&self.frequencies, parameters, |bins, sums, parameters| {
            let count = bins.len();
            factor.write(bins.start, &mut e[..count]);
            let (n, d) = (sums.numerator.first(count), sums.denominator.first(count));
            let out = &mut values[bins.clone()];
            if linearised.is_none() {
                multiply_quotient(self.set, n, d, &e[..count], out);
            } else {
                let (value, weight) = (g.first_mut(count), w.first_mut(count));
                quotient_parts(self.set, n, d, &e[..count], value, weight, out);
            }
            for tangent in parameters.iter_mut().filter(|tangent| !tangent.zero) {
                let Polynomials { numerator, denominator, .. } = &*tangent.polynomials;
                let (dn, dd) = (numerator.first(count), denominator.first(count));
                let out = &mut tangent.bins[bins.clone()];
                quotient_tangent(self.set, dn, dd, g.first(count), w.first(count), out);
            }
            if !delay.zero {
                factor.differentiate(bins.start, &e[..count], &mut slope[..count]);
                multiply_quotient(self.set, n, d, &slope[..count], &mut delay.bins[bins.clone()]);
            }
            let Some((images, _)) = &images else { return };
            images.raise(self.set, bins.start, false, &mut e[..count]);
            images.add(self.set, &value_images[..], bins.start, &e[..count], &mut values[bins.clone()]);
            for tangent in parameters.iter_mut().filter(|tangent| !tangent.zero) {
                images.add(
                    self.set,
                    &tangent.images[..],
                    bins.start,
                    &e[..count],
                    &mut tangent.bins[bins.clone()],
                );
            }
            if !delay.zero {
                let own_slope = factor.turns_images();
                let sums = if own_slope { &delay.images[..] } else { &value_images[..] };
                images.raise(self.set, bins.start, own_slope, &mut slope[..count]);
                images.add(self.set, sums, bins.start, &slope[..count], &mut delay.bins[bins]);
            }
        });
        if let Some((images, weights)) = images.filter(|_| !with_nearest) {
            self.add_nearest(candidate, &factor, (images, &weights), values, parameters, delay);
        }
        self.response_ends(candidate, &factor, values, parameters, delay);
        response.differentiated = linearised.is_some();
        Ok(())
    }

    /// Adds the nearest images, worked out at every frequency.
    fn add_nearest(
        &self,
        candidate: Candidate<'_>,
        factor: &InputFactor<'_>,
        (images, weights): (&Images, &ImageWeights),
        values: &mut [Complex64],
        parameters: &mut [Tangent],
        delay: &mut Tangent,
    ) {
        let [mut e, mut slope, mut out] = [[Complex64::ZERO; BLOCK]; 3];
        let (mut g, mut w) = (Block::ZERO, Block::ZERO);
        let add = |more: &[Complex64], bins: &mut [Complex64]| {
            bins.iter_mut().zip(more).for_each(|(bin, more)| *bin += more);
        };
        for (image, frequencies) in images.nearest() {
            candidate.over(frequencies, parameters, |bins, sums, parameters| {
                let count = bins.len();
                factor.write(bins.start, &mut e[..count]);
                if !delay.zero {
                    factor.differentiate(bins.start, &e[..count], &mut slope[..count]);
                    images.weigh(image, weights, (bins.start, factor.turns_images()), &mut slope[..count]);
                }
                images.weigh(image, weights, (bins.start, false), &mut e[..count]);
                let (n, d) = (sums.numerator.first(count), sums.denominator.first(count));
                let (value, weight) = (g.first_mut(count), w.first_mut(count));
                quotient_parts(self.set, n, d, &e[..count], value, weight, &mut out[..count]);
                without(weights.gain(), &e[..count], &mut out);
                add(&out[..count], &mut values[bins.clone()]);
                for tangent in parameters.iter_mut().filter(|tangent| !tangent.zero) {
                    let Polynomials { numerator, denominator, .. } = &*tangent.polynomials;
                    let (dn, dd) = (numerator.first(count), denominator.first(count));
                    quotient_tangent(self.set, dn, dd, g.first(count), w.first(count), &mut out[..count]);
                    without(tangent.gain, &e[..count], &mut out);
                    add(&out[..count], &mut tangent.bins[bins.clone()]);
                }
                if !delay.zero {
                    multiply_quotient(self.set, n, d, &slope[..count], &mut out[..count]);
                    without(weights.gain(), &slope[..count], &mut out);
                    add(&out[..count], &mut delay.bins[bins]);
                }
            });
        }
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
            let (dc, top) = candidate.end_tangents(which);
            self.settle_ends(&mut tangent.bins, dc * e[0].re, top * e[1].re);
        }
        self.settle_ends(&mut delay.bins, dc * slope[0].re, top * slope[1].re);
    }
}

/// Subtracts `gain` · `factors`.
fn without(gain: f64, factors: &[Complex64], out: &mut [Complex64]) {
    if gain != 0.0 {
        out.iter_mut().zip(factors).for_each(|(out, factor)| *out -= factor * gain);
    }
}
