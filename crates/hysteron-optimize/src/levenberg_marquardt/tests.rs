use super::super::test_problems::{
    Residuals, bard, brown_dennis, cube, kowalik_osborne, powell_singular, rosenbrock,
};
use super::super::{
    Algorithm, Bounds, Derivative, Differences, Eliminated, LeastSquaresProblem, Outcome, Problem, Range,
    Unobserved, minimize,
};
use super::*;

/// y = c₁ exp(−x₁ t) + c₂ exp(−x₂ t), c ≥ 0 eliminated; with derivatives beside c, or for the coefficients
/// that are positive alone.
struct Exponentials {
    bounds: Bounds,
    y: Vec<f64>,
    beside: bool,
}

#[derive(Default)]
struct Elimination {
    columns: Vec<f64>,
    coefficients: Vec<f64>,
}

const TIMES: usize = 40;

fn time(k: usize) -> f64 {
    0.1 * k as f64
}

impl Exponentials {
    fn eliminate(&self, x: &[f64], ws: &mut Elimination) -> Vec<f64> {
        ws.columns = x.iter().flat_map(|x| (0..TIMES).map(move |k| (-x * time(k)).exp())).collect();
        let columns: Vec<&[f64]> = ws.columns.chunks_exact(TIMES).collect();
        ws.coefficients = hysteron_numeric::non_negative_least_squares(&columns, &self.y);
        let fit =
            |k: usize| columns.iter().zip(&ws.coefficients).map(|(column, c)| c * column[k]).sum::<f64>();
        (0..TIMES).map(|k| self.y[k] - fit(k)).collect()
    }
}

impl Problem for Exponentials {
    type Workspace = Elimination;

    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn workspace(&self) -> Elimination {
        Elimination::default()
    }

    fn cost(&self, x: &[f64], ws: &mut Elimination) -> f64 {
        super::super::root_mean_square(&self.eliminate(x, ws))
    }
}

impl LeastSquaresProblem for Exponentials {
    fn residual_count(&self) -> usize {
        TIMES
    }

    fn residuals(&self, x: &[f64], ws: &mut Elimination, out: &mut [f64]) -> bool {
        out.copy_from_slice(&self.eliminate(x, ws));
        true
    }

    fn jacobian(&self, x: &[f64], ws: &mut Elimination, out: &mut [f64]) -> Derivative {
        self.eliminate(x, ws);
        let each = out.chunks_exact_mut(TIMES).zip(ws.columns.chunks_exact(TIMES)).zip(&ws.coefficients);
        for ((out, column), c) in each {
            out.iter_mut().zip(column).enumerate().for_each(|(k, (out, e))| *out = c * time(k) * e);
        }
        if !self.beside {
            let positive: Vec<f64> = ws
                .columns
                .chunks_exact(TIMES)
                .zip(&ws.coefficients)
                .filter(|(_, c)| **c > 0.0)
                .flat_map(|(column, _)| column.to_vec())
                .collect();
            let q = DMatrix::from_vec(TIMES, positive.len() / TIMES, positive).qr().q();
            for column in out.chunks_exact_mut(TIMES) {
                let d = DVector::from_column_slice(column);
                column.copy_from_slice((&d - &q * q.tr_mul(&d)).as_slice());
            }
        }
        Derivative::Written
    }

    fn jacobian_with_eliminated<'w>(
        &self,
        x: &[f64],
        ws: &'w mut Elimination,
        out: &mut [f64],
    ) -> (Derivative, Eliminated<'w>) {
        let derivative = self.jacobian(x, ws, out);
        let Elimination { columns, coefficients } = ws;
        let known = Eliminated { columns, coefficients };
        (derivative, if self.beside { known } else { Eliminated::default() })
    }
}

/// While the same coefficients are positive a step beside them is that by projection; across an edge, from a
/// start where one coefficient is 0, it ends in the same optimum, in no more steps.
#[test]
fn coefficients_beside_the_numbers_lead_to_the_same_optimum() {
    let y =
        (0..TIMES).map(|k| 2.0 * (-0.4 * time(k)).exp() + 3.0 * (-1.7 * time(k)).exp()).collect::<Vec<_>>();
    for (start, edge) in [([0.3, 2.5], false), ([3.0, 5.0], true)] {
        let [beside, projected] = [true, false].map(|beside| {
            let problem = Exponentials { bounds: cube(2, 0.0, 10.0), y: y.clone(), beside };
            let mut ws = Elimination::default();
            problem.eliminate(&start, &mut ws);
            assert_eq!(ws.coefficients.contains(&0.0), edge, "{:?}", ws.coefficients);
            fit(&problem, &start)
        });
        for (x, truth) in beside.best.iter().zip([0.4, 1.7]) {
            assert!((x - truth).abs() < 1e-7, "{:?}", beside.best);
        }
        let steps = [&beside, &projected].map(|outcome| outcome.starts[0].iterations);
        assert!(steps[0] <= steps[1], "{steps:?}");
        if !edge {
            assert_eq!(steps[0], steps[1]);
        }
    }
}

/// One fit from `start`.
fn fit(problem: &impl LeastSquaresProblem, start: &[f64]) -> Outcome {
    fit_with(LeastSquaresOptions { iterations: 300, ..LeastSquaresOptions::default() }, problem, start)
}

fn fit_with(options: LeastSquaresOptions, problem: &impl LeastSquaresProblem, start: &[f64]) -> Outcome {
    let options = LeastSquaresOptions { starts: 1, ..options };
    let settings = Settings { starts: vec![start.to_vec()], ..Settings::default() };
    minimize(problem, &Algorithm::LeastSquares(options), &settings, &mut Unobserved, None).unwrap()
}

fn sum_of_squares(outcome: &Outcome, residuals: usize) -> f64 {
    outcome.cost * outcome.cost * residuals as f64
}

#[test]
fn rosenbrock_ends_at_its_minimum() {
    let outcome = fit(&rosenbrock(cube(2, -5.0, 5.0)), &[-1.2, 1.0]);
    assert!(outcome.best.iter().all(|x| (x - 1.0).abs() < 1e-9), "{:?}", outcome.best);
    assert!(outcome.starts[0].status.converged(), "{:?}", outcome.starts);
    assert!(outcome.evaluations < 120, "{}", outcome.evaluations);
}

#[test]
fn powell_singular_ends_at_its_minimum_though_the_jacobian_is_singular_there() {
    let outcome = fit(&powell_singular(), &[3.0, -1.0, 0.0, 1.0]);
    assert!(sum_of_squares(&outcome, 4) < 1e-13, "{}", outcome.cost);
    assert!(outcome.best.iter().all(|x| x.abs() < 2e-3), "{:?}", outcome.best);
    assert!(outcome.starts[0].status.converged(), "{:?}", outcome.starts);
}

#[test]
fn bard_ends_at_the_published_minimum() {
    let outcome = fit(&bard(), &[1.0, 1.0, 1.0]);
    // Printed truncated.
    assert!((8.21487e-3..8.21488e-3).contains(&sum_of_squares(&outcome, 15)));
    for (x, published) in outcome.best.iter().zip([0.0824, 1.133, 2.344]) {
        assert!((x - published).abs() < 5e-4, "{:?}", outcome.best);
    }
}

/// Gauss–Newton alone ends at its limit of 100 iterations, at a cost of 66.03 instead of 65.51.
#[test]
fn large_residuals_do_not_slow_the_end_of_a_fit() {
    let options =
        LeastSquaresOptions { differences: Differences::central(), ..LeastSquaresOptions::default() };
    let outcome = fit_with(options, &brown_dennis(), &[25.0, 5.0, -5.0, -1.0]);
    assert!((sum_of_squares(&outcome, 20) / 85_822.201_6 - 1.0).abs() < 1e-8, "{}", outcome.cost);
    assert!(outcome.starts[0].iterations <= 30, "{:?}", outcome.starts);
}

#[test]
fn kowalik_osborne_ends_at_the_published_minimum() {
    let outcome = fit(&kowalik_osborne(), &[0.25, 0.39, 0.415, 0.39]);
    // Printed truncated.
    assert!((3.07505e-4..3.07506e-4).contains(&sum_of_squares(&outcome, 11)));
    for (x, published) in outcome.best.iter().zip([0.1928, 0.1913, 0.1231, 0.1361]) {
        assert!((x - published).abs() < 1e-4, "{:?}", outcome.best);
    }
}

#[test]
fn active_bound_of_rosenbrock_is_met_exactly() {
    // On x₁ = ½ the minimum is x₂ = ¼, cost ½² = ¼; the multiplier of x₁ ≤ ½ is 2(1 − ½) = 1 > 0: a KKT
    // point.
    let mut bounds = cube(2, -5.0, 5.0);
    bounds.ranges[0].high = 0.5;
    let outcome = fit(&rosenbrock(bounds), &[-1.2, 1.0]);
    assert_eq!(outcome.best[0], 0.5);
    assert!((outcome.best[1] - 0.25).abs() < 1e-12, "{:?}", outcome.best);
    assert!((sum_of_squares(&outcome, 2) - 0.25).abs() < 1e-14);
    assert!(outcome.starts[0].status.converged());
}

#[test]
fn several_active_bounds_of_a_linear_fit_are_those_of_the_kkt_conditions() {
    // Residuals x − c with c outside the box in two components: the projection of c onto the box.
    let centre = [2.0, 0.25, -3.0, 0.5];
    let residuals = move |x: &[f64], out: &mut [f64]| {
        (0..4).for_each(|j| out[j] = x[j] - centre[j]);
        true
    };
    let problem = Residuals { bounds: cube(4, 0.0, 1.0), count: 4, residuals };
    // The cost, 10, is insensitive to the free components: iterate until they no longer change.
    let options = LeastSquaresOptions { cost_tolerance: 0.0, ..LeastSquaresOptions::default() };
    let outcome = fit_with(options, &problem, &[0.5; 4]);
    assert_eq!((outcome.best[0], outcome.best[2]), (1.0, 0.0));
    assert!((outcome.best[1] - 0.25).abs() < 1e-12, "{:?}", outcome.best);
    assert!((outcome.best[3] - 0.5).abs() < 1e-12);
    assert!((sum_of_squares(&outcome, 4) - 10.0).abs() < 1e-12);
}

#[test]
fn parameter_without_effect_does_no_harm() {
    let residuals = |x: &[f64], out: &mut [f64]| {
        out.copy_from_slice(&[x[0] - 0.3, 2.0 * x[0] - 0.6]);
        true
    };
    let outcome = fit(&Residuals { bounds: cube(2, 0.0, 1.0), count: 2, residuals }, &[0.9, 0.6]);
    assert!((outcome.best[0] - 0.3).abs() < 1e-12, "{:?}", outcome.best);
    assert!((outcome.best[1] - 0.6).abs() < 1e-12);
}

#[test]
fn fewer_residuals_than_parameters_are_fitted() {
    let residuals = |x: &[f64], out: &mut [f64]| {
        out[0] = x[0] * x[1] - 0.25;
        true
    };
    let outcome = fit(&Residuals { bounds: cube(2, 0.0, 1.0), count: 1, residuals }, &[0.9, 0.9]);
    assert!((outcome.best[0] * outcome.best[1] - 0.25).abs() < 1e-12, "{:?}", outcome.best);
}

#[test]
fn fit_walks_along_the_edge_of_an_infeasible_region() {
    // The straight path to (0.8, 0.8) crosses a disc that cannot be simulated.
    let residuals = |x: &[f64], out: &mut [f64]| {
        out.copy_from_slice(&[x[0] - 0.8, x[1] - 0.8]);
        (x[0] - 0.5).hypot(x[1] - 0.45) > 0.05
    };
    let outcome = fit(&Residuals { bounds: cube(2, 0.0, 1.0), count: 2, residuals }, &[0.1, 0.1]);
    assert!(outcome.best.iter().all(|x| (x - 0.8).abs() < 1e-9), "{:?} {:?}", outcome.best, outcome.starts);
}

#[test]
fn decaying_exponential_over_decades_is_fitted_on_a_logarithmic_scale() {
    // y = 3e4 exp(−70 t), amplitude in 1…1e7, rate in 1…1e4; the start is decades away.
    let residuals = |x: &[f64], out: &mut [f64]| {
        for (i, r) in out.iter_mut().enumerate() {
            let t = i as f64 * 1e-3;
            *r = x[0] * (-x[1] * t).exp() - 3e4 * (-70.0 * t).exp();
        }
        true
    };
    let ranges = vec![Range::logarithmic("amplitude", 1.0, 1e7), Range::logarithmic("rate", 1.0, 1e4)];
    let problem = Residuals { bounds: Bounds { ranges }, count: 60, residuals };
    let outcome = fit(&problem, &[10.0, 1000.0]);
    assert!((outcome.best[0] / 3e4 - 1.0).abs() < 1e-9, "{:?}", outcome.best);
    assert!((outcome.best[1] / 70.0 - 1.0).abs() < 1e-9);
}

#[test]
fn central_differences_come_closer_to_the_minimum_than_tolerances_ask() {
    let options = LeastSquaresOptions {
        differences: Differences::central(),
        cost_tolerance: 1e-16,
        ..LeastSquaresOptions::default()
    };
    let outcome = fit_with(options, &bard(), &[1.0, 1.0, 1.0]);
    // Minimum to more digits: the root of the exact gradient, in 40 digits.
    for (x, exact) in
        outcome.best.iter().zip([0.082_410_559_749_788_93, 1.133_036_092_029_721_6, 2.343_695_178_642_537])
    {
        assert!((x - exact).abs() < 1e-8, "{x} {exact}");
    }
}

#[test]
fn a_fit_is_hopeless_only_if_its_pace_cannot_bring_it_down_to_the_best() {
    // A decrease of 0.1 in ten iterations, ninety left: 1.0 is the lowest reachable cost.
    let creeping = || {
        let mut fit = LocalFit::new(&[0.5], 2.0, 0);
        (fit.iterations, fit.cost) = (10, 1.9);
        fit
    };
    assert!(creeping().is_hopeless(100, 0.99));
    assert!(!creeping().is_hopeless(100, 1.01));
    assert!(!creeping().is_hopeless(100, f64::INFINITY), "the first start has nothing to be measured by");
    let mut fit = creeping();
    fit.iterations = 11;
    assert!(!fit.is_hopeless(100, 0.0), "judged every ten iterations");
    fit.iterations = 20;
    assert!(fit.is_hopeless(100, 1.0), "a fall of 0.1 since the start, judged at 20");
    // The rate is that of the last ten iterations, not of all.
    (fit.iterations, fit.cost) = (30, 1.2);
    assert!(!fit.is_hopeless(100, 0.1));
}

/// Columns that are zero, as of operators that the drive does not move, or depend on others have no effect on
/// the model with second derivatives: its Hessian is RᵀR + S, and its step meets RᵀR p + S p = −Jᵀr.
#[test]
fn second_derivatives_count_beside_columns_of_zeros() {
    let wave = |j: usize| (0..50).map(move |k| ((k * (2 * j + 3)) as f64 * 0.37).sin());
    let columns: Vec<Vec<f64>> = (0..4).map(|j| wave(j).collect()).collect();
    let [zeros, twice] = [vec![0.0; 50], wave(0).map(|x| 2.0 * x).collect()];
    // A positive coefficient, two numbers, two coefficients that are 0; the residuals.
    let all: Vec<&[f64]> = vec![&columns[0], &columns[1], &columns[2], &zeros, &twice, &columns[3]];
    let whole = triangular(&all);
    let model = Linearised {
        r: whole.view((0, 0), (5, 5)).into_owned(),
        target: -whole.view((0, 5), (5, 1)).column(0),
        gradient: DVector::zeros(2),
        column_norms: vec![1.0; 2],
        positive: vec![1.0],
        zeros: 2,
        half_square: 1.0,
    };
    let second = DMatrix::from_row_slice(2, 2, &[-4.0, 1.0, 1.0, 3.0]);
    let curved = model.with_curvature(&second).unwrap();
    let hessian = |model: &Linearised| model.r.tr_mul(&model.r);
    let added = hessian(&curved) - hessian(&model);
    assert!((added.view((1, 1), (2, 2)) - &second).amax() < 1e-9, "{added}");
    assert!(added.view((0, 0), (1, 5)).amax() < 1e-12, "{added}");
    let gradient = |model: &Linearised| model.r.tr_mul(&model.target);
    assert!((gradient(&curved) - gradient(&model)).amax() < 1e-9);
    // Without a minimum there is no such model.
    assert!(model.with_curvature(&DMatrix::from_diagonal_element(2, 2, -1e3)).is_none());
}
