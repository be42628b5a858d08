//! The discrete algebraic Riccati equation of a regulator with one input, or several.

use nalgebra::{DMatrix, DVector, RowDVector};

/// x⁺ = A x + b u, y = c x + d u.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct StateSpace {
    pub a: DMatrix<f64>,
    pub b: DVector<f64>,
    pub c: RowDVector<f64>,
    pub d: f64,
}

/// Doublings at most: 2⁶⁰ samples of horizon.
const DOUBLINGS: usize = 60;
/// Relative change of P at which the doubling has settled.
const SETTLED: f64 = 1e-14;

/// Linear-quadratic regulator u = −K x: minimises Σ q(x, u), q = xᵀQx + 2 xᵀs u + r u².
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Regulator {
    /// K.
    pub gains: RowDVector<f64>,
    /// r + bᵀPb.
    pub weight: f64,
    /// Cost to come, P.
    pub cost: DMatrix<f64>,
}

/// The regulator of the stabilising solution; `None` where there is none.
pub(super) fn regulator(plant: &StateSpace, q: &DMatrix<f64>, s: &DVector<f64>, r: f64) -> Option<Regulator> {
    let n = plant.b.len();
    // u = u' − sᵀx/r eliminates the cross term.
    let a = &plant.a - &plant.b * s.transpose() / r;
    let g = &plant.b * plant.b.transpose() / r;
    let p = stabilising_solution(a, g, q - s * s.transpose() / r)?;
    let weight = r + (plant.b.transpose() * &p * &plant.b)[(0, 0)];
    let gains = (s.transpose() + plant.b.transpose() * &p * &plant.a) / weight;
    Some(Regulator { gains: RowDVector::from_iterator(n, gains.iter().copied()), weight, cost: p })
}

/// Linear-quadratic regulator u = −K x of several inputs: minimises Σ xᵀQx + 2 xᵀS u + uᵀR u.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SeveralInputs {
    /// K, inputs × states.
    pub gains: DMatrix<f64>,
    /// (R + BᵀPB)⁻¹.
    pub inverse_weight: DMatrix<f64>,
    /// Cost to come, P.
    pub cost: DMatrix<f64>,
}

/// The regulator of x⁺ = A x + B u; `None` where there is no stabilising solution.
pub(crate) fn several_inputs(
    (a, b): (&DMatrix<f64>, &DMatrix<f64>),
    q: &DMatrix<f64>,
    s: &DMatrix<f64>,
    r: &DMatrix<f64>,
) -> Option<SeveralInputs> {
    let inverse = r.clone().try_inverse()?;
    let cross = &inverse * s.transpose();
    let p = stabilising_solution(a - b * &cross, symmetric(&(b * &inverse * b.transpose())), q - s * cross)?;
    let inverse_weight = (r + b.transpose() * &p * b).try_inverse()?;
    let gains = &inverse_weight * (s.transpose() + b.transpose() * &p * a);
    Some(SeveralInputs { gains, inverse_weight, cost: p })
}

/// P = Q + AᵀP(I + GP)⁻¹A, by structure-preserving doubling (E. K.-W. Chu, H.-Y. Fan, W.-W. Lin, C.-S. Wang,
/// *Int. J. Control* 77 (2004) 767–788, doi:10.1080/00207170410001714988); `None` where it does not settle.
fn stabilising_solution(
    mut a: DMatrix<f64>,
    mut g: DMatrix<f64>,
    mut p: DMatrix<f64>,
) -> Option<DMatrix<f64>> {
    let identity = DMatrix::<f64>::identity(a.nrows(), a.nrows());
    for _ in 0..DOUBLINGS {
        let factors = (&identity + &g * &p).lu();
        let a_next = &a * factors.solve(&a)?;
        let g_next = &g + &a * factors.solve(&(&g * a.transpose()))?;
        let p_next = &p + a.transpose() * &p * factors.solve(&a)?;
        let change = (&p_next - &p).amax();
        let size = p_next.amax();
        (a, g) = (a_next, symmetric(&g_next));
        p = symmetric(&p_next);
        if !(size.is_finite() && g.amax().is_finite()) {
            return None;
        }
        if change <= SETTLED * size {
            return Some(p);
        }
    }
    None
}

fn symmetric(x: &DMatrix<f64>) -> DMatrix<f64> {
    0.5 * (x + x.transpose())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// x⁺ = x + u with q = r = 1: P² − P − 1 = 0, the golden ratio.
    #[test]
    fn the_integrator_gives_the_golden_ratio() {
        let one = || DMatrix::from_element(1, 1, 1.0);
        let plant = StateSpace {
            a: one(),
            b: DVector::from_element(1, 1.0),
            c: RowDVector::from_element(1, 1.0),
            d: 0.0,
        };
        let found = regulator(&plant, &one(), &DVector::zeros(1), 1.0).unwrap();
        let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
        assert!((found.cost[(0, 0)] - golden).abs() < 1e-14);
        assert!((found.gains[0] - golden / (1.0 + golden)).abs() < 1e-14);
    }

    /// The equation itself, with a cross term: P = AᵀPA + Q − Kᵀ(r + bᵀPb)K.
    #[test]
    fn the_equation_is_met() {
        let plant = StateSpace {
            a: DMatrix::from_row_slice(3, 3, &[0.9, 0.3, 0.0, -0.2, 0.95, 0.1, 0.0, 0.0, 0.999]),
            b: DVector::from_column_slice(&[0.1, 0.4, 0.01]),
            c: RowDVector::zeros(3),
            d: 0.0,
        };
        let q = DMatrix::from_row_slice(3, 3, &[2.0, 0.3, 0.0, 0.3, 1.0, 0.1, 0.0, 0.1, 0.5]);
        let s = DVector::from_column_slice(&[0.1, -0.05, 0.02]);
        let found = regulator(&plant, &q, &s, 0.3).unwrap();
        let k = &found.gains;
        let right = plant.a.transpose() * &found.cost * &plant.a + &q - k.transpose() * k * found.weight;
        assert!((right - &found.cost).amax() < 1e-11 * found.cost.amax());
        let closed = &plant.a - &plant.b * k;
        assert!(closed.complex_eigenvalues().iter().all(|z| z.norm() < 1.0));
    }

    /// P = AᵀPA + Q − Kᵀ(R + BᵀPB)K, and with one input the regulator above.
    #[test]
    fn the_equation_of_several_inputs_is_met() {
        let a = DMatrix::from_row_slice(3, 3, &[0.9, 0.3, 0.0, -0.2, 0.95, 0.1, 0.0, 0.0, 0.999]);
        let b = DMatrix::from_row_slice(3, 2, &[0.1, 0.0, 0.4, -0.2, 0.01, 0.3]);
        let q = DMatrix::from_row_slice(3, 3, &[2.0, 0.3, 0.0, 0.3, 1.0, 0.1, 0.0, 0.1, 0.5]);
        let s = DMatrix::from_row_slice(3, 2, &[0.1, 0.02, -0.05, 0.0, 0.02, 0.01]);
        let r = DMatrix::from_row_slice(2, 2, &[0.3, 0.05, 0.05, 0.2]);
        let found = several_inputs((&a, &b), &q, &s, &r).unwrap();
        let weight = &r + b.transpose() * &found.cost * &b;
        let right = a.transpose() * &found.cost * &a + &q - found.gains.transpose() * weight * &found.gains;
        assert!((right - &found.cost).amax() < 1e-11 * found.cost.amax());
        let one = b.column(0).into_owned();
        let plant = StateSpace { a: a.clone(), b: one.clone(), c: RowDVector::zeros(3), d: 0.0 };
        let single = regulator(&plant, &q, &s.column(0).into_owned(), 0.3).unwrap();
        let column = |x: &DMatrix<f64>| DMatrix::from_column_slice(3, 1, x.column(0).as_slice());
        let several =
            several_inputs((&a, &column(&b)), &q, &column(&s), &DMatrix::from_element(1, 1, 0.3)).unwrap();
        assert!((several.gains - single.gains).amax() < 1e-11);
    }
}
