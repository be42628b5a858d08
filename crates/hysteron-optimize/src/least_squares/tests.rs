use super::super::test_problems::{ResidualFunction, Residuals, cube};
use super::super::{Algorithm, Outcome, Unobserved, minimize};
use super::*;

/// Two minima in x₁: at −1 the better one (cost 0), at 2 a worse one.
fn two_minima() -> Residuals<ResidualFunction> {
    let residuals: ResidualFunction = |x, out| {
        out[0] = if x[0] < 0.5 { x[0] + 1.0 } else { 0.5 + (x[0] - 2.0).powi(2) };
        out[1] = x[1] - 0.3;
        true
    };
    Residuals { bounds: cube(2, -3.0, 3.0), count: 2, residuals }
}

fn run(options: LeastSquaresOptions, settings: &Settings) -> Outcome {
    minimize(&two_minima(), &Algorithm::LeastSquares(options), settings, &mut Unobserved, None).unwrap()
}

#[test]
fn run_stops_once_enough_starts_agree_on_the_best_minimum() {
    let outcome = run(LeastSquaresOptions::default(), &Settings::default());
    assert_eq!(outcome.stopped, StopReason::Agreement);
    let at_best = outcome.starts.iter().filter(|start| start.cost < 1e-8).count();
    assert_eq!(at_best, 3);
    assert!((outcome.best[0] + 1.0).abs() < 1e-8);
    assert_eq!(outcome.evaluations, outcome.starts.iter().map(|start| start.evaluations).sum::<usize>());
}

#[test]
fn given_starts_come_first_and_all_starts_are_used_without_agreement() {
    let options = LeastSquaresOptions { starts: 5, agreement: None, ..LeastSquaresOptions::default() };
    let settings = Settings { starts: vec![vec![2.5, 0.0], vec![-2.5, 0.0]], ..Settings::default() };
    let outcome = run(options, &settings);
    assert_eq!((outcome.stopped, outcome.starts.len()), (StopReason::StartsDone, 5));
    assert!((outcome.starts[0].best[0] - 2.0).abs() < 1e-3, "{:?}", outcome.starts[0]);
    assert!((outcome.starts[1].best[0] + 1.0).abs() < 1e-8);
    assert!(
        (outcome.starts[0].initial_cost - (0.75_f64.powi(2) + 0.09).sqrt() / 2.0_f64.sqrt()).abs() < 1e-15
    );
}

#[test]
fn infeasible_start_is_passed_over() {
    let residuals = |x: &[f64], out: &mut [f64]| {
        out[0] = x[0] - 0.75;
        x[0] > 0.5
    };
    let problem = Residuals { bounds: cube(1, 0.0, 1.0), count: 1, residuals };
    let settings = Settings { starts: vec![vec![0.2], vec![0.9]], ..Settings::default() };
    let options = LeastSquaresOptions { starts: 2, ..LeastSquaresOptions::default() };
    let outcome =
        minimize(&problem, &Algorithm::LeastSquares(options), &settings, &mut Unobserved, None).unwrap();
    assert_eq!(outcome.starts[0].status, LocalStatus::Infeasible);
    assert_eq!(outcome.starts[0].cost, f64::INFINITY);
    assert!((outcome.best[0] - 0.75).abs() < 1e-12);
}

#[test]
fn random_starts_differ_from_the_spread_ones() {
    let first = |spread| {
        let options =
            LeastSquaresOptions { starts: 4, agreement: None, spread, ..LeastSquaresOptions::default() };
        run(options, &Settings::default()).starts.iter().map(|start| start.initial_cost).collect::<Vec<_>>()
    };
    assert_ne!(first(Starts::Halton), first(Starts::Random));
}
