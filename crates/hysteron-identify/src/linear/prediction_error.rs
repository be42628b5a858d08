//! Prediction error of a polynomial model and its exact derivatives.
//!
//! With x = B/F v and w = y − offset − x, e = D/C w. Derivatives are filtered signals: ∂x/∂b_j = z^−(j+nk)/F
//! v, ∂x/∂f_i = −z^−i/F x, ∂e/∂c_i = −z^−i/C e, ∂e/∂d_i = z^−i/C w. At a sample that is not valid e = 0, and
//! w is its prediction Σ c e − Σ d w.

use nalgebra::{DMatrix, DVector};

use super::filter::filter;
use super::gauss_newton::Linearisation;
use super::is_valid;
use super::polynomial::{PolynomialModel, PolynomialOrders};
use hysteron_model::dynamics::Arx;
use hysteron_model::dynamics::arx::ArxRecord;

pub(super) struct PredictionError<'a> {
    records: &'a [ArxRecord<'a>],
    orders: PolynomialOrders,
    /// Samples of all records.
    rows: usize,
}

impl<'a> PredictionError<'a> {
    pub(super) fn new(records: &'a [ArxRecord<'a>], orders: PolynomialOrders) -> Self {
        Self { records, orders, rows: records.iter().map(|r| r.input.len()).sum() }
    }

    /// Valid samples.
    pub(super) fn rows(&self) -> usize {
        let valid = |r: &ArxRecord<'_>| (0..r.input.len()).filter(|&k| is_valid(r, k)).count();
        self.records.iter().map(valid).sum()
    }

    /// Samples of each record.
    pub(super) fn segments(&self) -> Vec<usize> {
        self.records.iter().map(|r| r.input.len()).collect()
    }

    pub(super) fn model(&self, x: &[f64]) -> PolynomialModel {
        let PolynomialOrders { nb, nf, nk, nc, nd } = self.orders;
        let (b, rest) = x.split_at(nb);
        let (f, rest) = rest.split_at(nf);
        let (c, rest) = rest.split_at(nc);
        PolynomialModel { b: b.to_vec(), f: f.to_vec(), nk, c: c.to_vec(), d: rest[..nd].to_vec() }
    }

    pub(super) fn offsets<'b>(&self, x: &'b [f64]) -> &'b [f64] {
        &x[self.orders.count()..]
    }

    /// Residual (0 at samples that are not valid) and derivatives; `None` for an unstable polynomial.
    pub(super) fn at(&self, x: &[f64]) -> Option<Linearisation> {
        let model = self.model(x);
        let stable = |a: &[f64]| Arx { a: a.to_vec(), b: vec![1.0] }.is_stable();
        if !(stable(&model.f) && stable(&model.c) && stable(&model.d)) {
            return None;
        }
        let mut residual = DVector::zeros(self.rows);
        let mut jacobian = DMatrix::zeros(self.rows, x.len());
        let mut first = 0;
        for (index, record) in self.records.iter().enumerate() {
            self.of_record(&model, self.offsets(x)[index], (index, first), &mut residual, &mut jacobian);
            first += record.input.len();
        }
        residual.iter().all(|e| e.is_finite()).then_some(Linearisation { residual, jacobian })
    }

    fn of_record(
        &self,
        model: &PolynomialModel,
        offset: f64,
        (index, first): (usize, usize),
        residual: &mut DVector<f64>,
        jacobian: &mut DMatrix<f64>,
    ) {
        let PolynomialOrders { nb, nf, nk, nc, nd } = self.orders;
        let record = &self.records[index];
        let samples = record.input.len();
        let own = self.orders.count() + index;
        let mut by_v = vec![0.0; samples];
        filter(&[1.0], nk, &model.f, record.input, &mut by_v);
        let mut x = vec![0.0; samples];
        filter(&model.b, nk, &model.f, record.input, &mut x);
        let mut by_x = vec![0.0; samples];
        filter(&[-1.0], 0, &model.f, &x, &mut by_x);
        // Derivatives of w, then by the recursion those of e, in place.
        for j in 0..nb {
            (j..samples).for_each(|k| jacobian[(first + k, j)] = -by_v[k - j]);
        }
        for i in 0..nf {
            (i + 1..samples).for_each(|k| jacobian[(first + k, nb + i)] = -by_x[k - i - 1]);
        }
        (0..samples).for_each(|k| jacobian[(first + k, own)] = -1.0);
        let mut w: Vec<f64> = (0..samples).map(|k| record.output[k] - offset - x[k]).collect();
        let valid: Vec<bool> = (0..samples).map(|k| is_valid(record, k)).collect();
        if nc + nd == 0 {
            for (k, (&valid, w)) in valid.iter().zip(&w).enumerate() {
                if valid {
                    residual[first + k] = *w;
                } else {
                    (0..nb + nf).chain([own]).for_each(|p| jacobian[(first + k, p)] = 0.0);
                }
            }
            return;
        }
        let mut e = vec![0.0; samples];
        // Prediction of w by the noise model, negated.
        let predicted = |k: usize, w: &[f64], e: &[f64]| {
            let past = |c: &[f64], x: &[f64]| -> f64 {
                c.iter().enumerate().filter_map(|(i, c)| Some(c * x[k.checked_sub(i + 1)?])).sum()
            };
            past(&model.d, w) - past(&model.c, e)
        };
        for (k, &valid) in valid.iter().enumerate() {
            let past = predicted(k, &w, &e);
            if valid {
                e[k] = w[k] + past;
            } else {
                w[k] = -past;
            }
            residual[first + k] = e[k];
        }
        let (mut dw, mut de) = (vec![0.0; samples], vec![0.0; samples]);
        for p in (0..self.orders.count()).chain([own]) {
            // Direct derivative of the prediction with respect to coefficient p.
            let of_noise = p.checked_sub(nb + nf).filter(|i| *i < nc + nd);
            for (k, &valid) in valid.iter().enumerate() {
                let delayed = |x: &[f64], lag: usize| k.checked_sub(lag).map_or(0.0, |at| x[at]);
                let brought = match of_noise {
                    Some(i) if i < nc => -delayed(&e, i + 1),
                    Some(i) => delayed(&w, i - nc + 1),
                    None => 0.0,
                };
                let past = predicted(k, &dw, &de) + brought;
                let direct = if of_noise.is_some() { 0.0 } else { jacobian[(first + k, p)] };
                (dw[k], de[k]) = if valid { (direct, direct + past) } else { (-past, 0.0) };
            }
            (0..samples).for_each(|k| jacobian[(first + k, p)] = de[k]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_differences() {
        let signal = |seed: f64, n: usize| -> Vec<f64> {
            (0..n)
                .map(|k| (seed * (k * k) as f64 * 0.37).sin() + 0.3 * (k as f64 * 0.21 * seed).cos())
                .collect()
        };
        let (v, y) = ([signal(1.0, 60), signal(1.7, 45)], [signal(0.6, 60), signal(2.3, 45)]);
        let mask: Vec<bool> = (0..60).map(|k| k % 13 != 4 && k % 13 != 5).collect();
        let records = [
            ArxRecord { input: &v[0], output: &y[0], valid: Some(&mask) },
            ArxRecord { input: &v[1], output: &y[1], valid: None },
        ];
        let box_jenkins = PolynomialOrders { nb: 2, nf: 2, nk: 1, nc: 1, nd: 2 };
        let x = [0.5, -0.2, -1.1, 0.4, 0.3, -0.5, 0.2, 0.05, -0.1];
        let plain = PolynomialOrders { nc: 0, nd: 0, ..box_jenkins };
        for (orders, x) in [(box_jenkins, x.to_vec()), (plain, [&x[..4], &x[7..]].concat())] {
            let error = PredictionError::new(&records, orders);
            let at = error.at(&x).unwrap();
            for (j, &value) in x.iter().enumerate() {
                let h = 1e-3;
                let shifted = |d: f64| {
                    let mut x = x.clone();
                    x[j] = value + d;
                    error.at(&x).unwrap().residual
                };
                let difference = ((shifted(h) - shifted(-h)) * 45.0
                    - (shifted(2.0 * h) - shifted(-2.0 * h)) * 9.0
                    + (shifted(3.0 * h) - shifted(-3.0 * h)))
                    / (60.0 * h);
                let off = (at.jacobian.column(j) - &difference).norm();
                assert!(off < 1e-9 * difference.norm(), "{orders:?} {j}: {off:e}");
            }
            assert_eq!(at.residual[4], 0.0);
            assert_eq!(error.rows(), 105 - 10);
        }
    }
}
