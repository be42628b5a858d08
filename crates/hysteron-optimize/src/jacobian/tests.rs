use super::super::test_problems::{Residuals, cube};
use super::super::{Problem, Range};
use super::*;

/// (a e^(−b), a b²) on a linear and a logarithmic scale.
fn residuals(x: &[f64], out: &mut [f64]) -> bool {
    out.copy_from_slice(&[x[0] * (-x[1]).exp(), x[0] * x[1] * x[1]]);
    true
}

fn bounds() -> Bounds {
    Bounds { ranges: vec![Range::linear("a", -1.0, 3.0), Range::logarithmic("b", 0.01, 10.0)] }
}

fn exact([a, b]: [f64; 2]) -> DMatrix<f64> {
    DMatrix::from_row_slice(2, 2, &[(-b).exp(), -a * (-b).exp(), b * b, 2.0 * a * b])
}

#[test]
fn differences_agree_with_the_derivatives_by_hand() {
    let problem = Residuals { bounds: bounds(), count: 2, residuals };
    // Inside, and on two edges of the box, where the differences are one-sided. Central ones err by h²/6 (ln
    // 1000)³ = 6e-9 on the logarithmic scale, one-sided ones by h/2 ln 1000 = 3e-5 of the derivative.
    for (x, tolerance) in [([0.7, 0.4], 6e-9), ([3.0, 0.4], 6e-9), ([-1.0, 10.0], 2e-4)] {
        let central = residual_jacobian(&problem, &x, Differences::central()).unwrap();
        let error = (&central - exact(x)).abs().max() / exact(x).abs().max();
        assert!(error < tolerance, "{error} at {x:?}");
        let forward = residual_jacobian(&problem, &x, Differences::default()).unwrap();
        assert!((&forward - exact(x)).abs().max() / exact(x).abs().max() < 1e-5);
    }
}

/// These residuals with analytic derivatives.
struct WithDerivatives(Bounds);

impl Problem for WithDerivatives {
    type Workspace = ();

    fn bounds(&self) -> &Bounds {
        &self.0
    }

    fn workspace(&self) {}

    fn cost(&self, x: &[f64], workspace: &mut ()) -> f64 {
        let mut out = [0.0; 2];
        if self.residuals(x, workspace, &mut out) { root_mean_square(&out) } else { f64::INFINITY }
    }
}

impl LeastSquaresProblem for WithDerivatives {
    fn residual_count(&self) -> usize {
        2
    }

    fn residuals(&self, x: &[f64], _: &mut (), out: &mut [f64]) -> bool {
        residuals(x, out)
    }

    fn jacobian(&self, x: &[f64], _: &mut (), out: &mut [f64]) -> Derivative {
        out.copy_from_slice(exact([x[0], x[1]]).as_slice());
        Derivative::Written
    }
}

#[test]
fn derivatives_of_the_problem_are_used_scaled_and_counted_once() {
    let problem = WithDerivatives(bounds());
    let jacobian = residual_jacobian(&problem, &[0.7, 0.4], Differences::default()).unwrap();
    assert!((jacobian - exact([0.7, 0.4])).abs().max() < 1e-15);

    let mut evaluator = Evaluator::new(&problem, Some(1), None).unwrap();
    let mut unit = UnitResiduals::new(problem.bounds(), &mut evaluator);
    let mut ledger = Ledger::new(2);
    assert!(unit.load(&[0.5, 0.5]));
    unit.differentiate(&[0.5, 0.5], Differences::default(), &Settings::default(), &mut ledger).unwrap();
    assert_eq!(ledger.evaluations, 1);
    let on_unit_box = unit.columns().to_vec();
    let by_differences = Residuals { bounds: bounds(), count: 2, residuals };
    let mut evaluator = Evaluator::new(&by_differences, Some(1), None).unwrap();
    let mut unit = UnitResiduals::new(by_differences.bounds(), &mut evaluator);
    assert!(unit.load(&[0.5, 0.5]));
    unit.differentiate(&[0.5, 0.5], Differences::central(), &Settings::default(), &mut ledger).unwrap();
    assert_eq!(ledger.evaluations, 1 + 4);
    for (a, b) in on_unit_box.iter().zip(unit.columns()) {
        assert!((a - b).abs() < 1e-8, "{a} {b}");
    }
}

#[test]
fn difference_into_an_infeasible_region_is_taken_to_the_other_side() {
    let wall = |x: &[f64], out: &mut [f64]| {
        out[0] = 3.0 * x[0];
        x[0] <= 0.5
    };
    let problem = Residuals { bounds: cube(1, 0.0, 1.0), count: 1, residuals: wall };
    for differences in [Differences::default(), Differences::central()] {
        let jacobian = residual_jacobian(&problem, &[0.5], differences).unwrap();
        assert!((jacobian[(0, 0)] - 3.0).abs() < 1e-6);
    }
    let point = Residuals {
        bounds: cube(1, 0.0, 1.0),
        count: 1,
        residuals: |x: &[f64], out: &mut [f64]| {
            out[0] = x[0];
            x[0] == 0.5
        },
    };
    let error = residual_jacobian(&point, &[0.5], Differences::default()).unwrap_err();
    assert!(matches!(error, OptimizeError::NotDifferentiable { .. }), "{error}");
}

/// Where the first step of a parameter is infeasible the other side takes an evaluation of the budget, and the second
/// half of a central difference does not begin.
#[test]
fn central_differences_keep_to_the_budget() {
    let wall = |x: &[f64], out: &mut [f64]| {
        out[0] = x[0] + x[1];
        x[0] <= 0.5
    };
    let problem = Residuals { bounds: cube(2, 0.0, 1.0), count: 1, residuals: wall };
    let at = [0.5, 0.5];
    let settings = Settings { starts: vec![at.to_vec()], budget: Some(4), ..Settings::default() };
    let mut evaluator = Evaluator::new(&problem, None, None).unwrap();
    let mut residuals = UnitResiduals::new(&problem.bounds, &mut evaluator);
    let mut ledger = Ledger::new(2);
    assert!(residuals.load(&at));
    let ended = residuals.differentiate(&at, Differences::central(), &settings, &mut ledger);
    assert!(matches!(ended, Err(LocalStatus::Budget)));
    assert_eq!(ledger.evaluations, 3);
}
