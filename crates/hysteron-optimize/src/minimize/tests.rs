use super::super::test_problems::{
    Cost, ResidualFunction, Residuals, cube, powell_singular, rastrigin, rosenbrock, sphere,
};
use super::super::{
    AbcOptions, CmaEsOptions, DeAbcOptions, DeOptions, LeastSquaresOptions, OptimizeError, PsoOptions, Range,
    Scout, Stagnation, Unobserved,
};
use super::*;
use std::ops::ControlFlow;

fn population_methods() -> [Algorithm; 5] {
    [
        Algorithm::DeAbc(DeAbcOptions::default()),
        Algorithm::Abc(AbcOptions::default()),
        Algorithm::De(DeOptions::default()),
        Algorithm::Pso(PsoOptions::default()),
        Algorithm::CmaEs(CmaEsOptions::default()),
    ]
}

fn all_algorithms() -> Vec<Algorithm> {
    let mut all = population_methods().to_vec();
    // A limit low enough to trigger the scout, so that its state is tested too.
    all.push(Algorithm::DeAbc(DeAbcOptions { limit: Some(3), ..DeAbcOptions::default() }));
    all.push(Algorithm::LeastSquares(LeastSquaresOptions {
        agreement: None,
        ..LeastSquaresOptions::default()
    }));
    all
}

fn curved() -> Residuals<ResidualFunction> {
    rosenbrock(cube(2, -3.0, 4.0))
}

/// A residual problem of which half the box is infeasible.
fn half_infeasible() -> Residuals<impl Fn(&[f64], &mut [f64]) -> bool + Sync> {
    let residuals = |x: &[f64], out: &mut [f64]| {
        out.copy_from_slice(&[x[0] - 0.2, 3.0 * (x[1] - 0.3) * (1.0 + x[0])]);
        if x[1] > 0.9 {
            out[0] = f64::NAN;
        }
        x[0] + x[1] < 1.0
    };
    Residuals { bounds: cube(2, 0.0, 1.0), count: 2, residuals }
}

#[test]
fn sphere_is_minimised_by_every_population_method() {
    for algorithm in population_methods() {
        let outcome =
            minimize_cost(&sphere(3), &algorithm, &Settings::default(), &mut Unobserved, None).unwrap();
        assert!(outcome.cost < 1e-6, "{} {}", algorithm.name(), outcome.cost);
        assert!(outcome.best.iter().all(|x| x.abs() < 1e-3));
        assert_eq!((outcome.generations, outcome.stopped), (150, StopReason::Generations));
        assert_eq!(outcome.history.len(), 151);
    }
}

#[test]
fn rosenbrock_is_minimised_by_every_algorithm_with_enough_generations() {
    for algorithm in all_algorithms() {
        // A bee colony changes one parameter at a time: it is slow in a curved valley.
        let target = if let Algorithm::Abc(_) = algorithm { 0.05 } else { 1e-3 };
        let settings = Settings { generations: 1000, target: Some(target), ..Settings::default() };
        let outcome = minimize(&curved(), &algorithm, &settings, &mut Unobserved, None).unwrap();
        assert_eq!(outcome.stopped, StopReason::Target, "{} {}", algorithm.name(), outcome.cost);
        // |1 − x₁| ≤ √2 J, and |x₂ − x₁²| ≤ √2 J / 10.
        let [x1, x2] = outcome.best[..] else { panic!() };
        assert!((x1 - 1.0).abs() <= 1.5 * target && (x2 - x1 * x1).abs() <= 0.15 * target);
        assert!(outcome.evaluations_to(target).unwrap() <= outcome.evaluations);
    }
}

#[test]
fn rastrigin_minimum_is_found_among_its_many_others() {
    let settings = Settings { generations: 400, ..Settings::default() };
    for algorithm in population_methods() {
        let outcome = minimize_cost(&rastrigin(2), &algorithm, &settings, &mut Unobserved, None).unwrap();
        assert!(outcome.cost < 1e-6, "{} {}", algorithm.name(), outcome.cost);
    }
}

#[test]
fn outcome_has_the_same_bits_for_any_number_of_threads() {
    for algorithm in all_algorithms() {
        let run = |threads| {
            let settings = Settings {
                generations: 30,
                threads: Some(threads),
                budget: Some(1111),
                ..Settings::default()
            };
            minimize(&half_infeasible(), &algorithm, &settings, &mut Unobserved, None).unwrap()
        };
        let one = run(1);
        for threads in [2, 5] {
            assert_eq!(one, run(threads), "{} with {threads} threads", algorithm.name());
        }
    }
}

#[test]
fn another_seed_gives_another_run() {
    for algorithm in all_algorithms() {
        let run = |seed| {
            let settings = Settings { seed, generations: 5, budget: Some(300), ..Settings::default() };
            minimize(&curved(), &algorithm, &settings, &mut Unobserved, None).unwrap().history
        };
        assert_ne!(run(1), run(2), "{}", algorithm.name());
    }
}

/// Stops after `generations`; keeps the last checkpoint as JSON, as a program would on disk.
fn interrupted_at(generation: usize, json: &mut String) -> impl FnMut(&Progress<'_>) -> ControlFlow<()> {
    move |progress| {
        if progress.generation == generation {
            *json = serde_json::to_string(progress.checkpoint()).unwrap();
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }
}

#[test]
fn resumed_run_ends_with_the_bits_of_an_uninterrupted_one() {
    let problem = half_infeasible();
    for algorithm in all_algorithms() {
        let settings = Settings { generations: 20, ..Settings::default() };
        let settings = match algorithm {
            // The first start is feasible: a run cancelled before any feasible point has no result.
            Algorithm::LeastSquares(_) => {
                Settings { budget: Some(150), starts: vec![vec![0.1, 0.6]], ..settings }
            }
            _ => settings,
        };
        let straight = minimize(&problem, &algorithm, &settings, &mut Unobserved, None).unwrap();
        for at in [0, 7] {
            let mut json = String::new();
            let cancelled =
                minimize(&problem, &algorithm, &settings, &mut interrupted_at(at, &mut json), None).unwrap();
            assert_eq!((cancelled.stopped, cancelled.generations), (StopReason::Cancelled, at));
            assert_eq!(serde_json::to_string(&cancelled.checkpoint).unwrap(), json);
            let checkpoint: Checkpoint = serde_json::from_str(&json).unwrap();
            assert_eq!(checkpoint, cancelled.checkpoint, "{}", algorithm.name());
            let resumed =
                minimize(&problem, &algorithm, &settings, &mut Unobserved, Some(checkpoint)).unwrap();
            assert_eq!(resumed, straight, "{} resumed at {at}", algorithm.name());
        }
        // A finished run does nothing further.
        let again =
            minimize(&problem, &algorithm, &settings, &mut Unobserved, Some(straight.checkpoint.clone()))
                .unwrap();
        assert_eq!(again, straight);
    }
}

#[test]
fn scouts_fire_in_the_run_that_is_to_test_them() {
    let settings = Settings { generations: 20, ..Settings::default() };
    let fired = |limit, scout| {
        let algorithm = Algorithm::DeAbc(DeAbcOptions { limit, scout, ..DeAbcOptions::default() });
        minimize(&half_infeasible(), &algorithm, &settings, &mut Unobserved, None).unwrap().scouts_fired
    };
    let chaotic = DeAbcOptions::default().scout;
    assert!(fired(Some(3), chaotic) > 5);
    assert!(fired(Some(3), Scout::Random) > 5);
    assert_eq!(fired(Some(3), Scout::Off), 0);
    assert_eq!(fired(None, chaotic), 0);
}

#[test]
fn cancelled_run_keeps_its_best_so_far() {
    for algorithm in population_methods() {
        let mut seen = (f64::NAN, Vec::new());
        let mut observer = |progress: &Progress<'_>| {
            assert_eq!((progress.generations, progress.best.len()), (150, 3));
            seen = (progress.best_cost, progress.best.to_vec());
            if progress.generation == 4 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let outcome =
            minimize_cost(&sphere(3), &algorithm, &Settings::default(), &mut observer, None).unwrap();
        assert_eq!(outcome.stopped, StopReason::Cancelled);
        assert_eq!((outcome.cost, outcome.best), seen);
    }
}

/// A stop asked for in the middle of a generation, by the evaluation of this number.
#[test]
fn stop_within_a_generation_makes_no_further_evaluation_and_loses_no_bit() {
    for algorithm in all_algorithms() {
        let settings = Settings { generations: 12, threads: Some(1), ..Settings::default() };
        let straight = minimize(&curved(), &algorithm, &settings, &mut Unobserved, None).unwrap();
        for at in [0, 1, 30, 77, 130].into_iter().filter(|at| *at < straight.evaluations) {
            let stop = Stop::new();
            let count = std::sync::atomic::AtomicUsize::new(0);
            let problem = Residuals {
                bounds: cube(2, -3.0, 4.0),
                count: 2,
                residuals: |x: &[f64], out: &mut [f64]| {
                    if count.fetch_add(1, std::sync::atomic::Ordering::Relaxed) == at {
                        stop.request();
                    }
                    out.copy_from_slice(&[10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]);
                    true
                },
            };
            let stopped = minimize(&problem, &algorithm, &settings, &mut stop.clone(), None).unwrap();
            assert_eq!(stopped.stopped, StopReason::Cancelled, "{}", algorithm.name());
            assert_eq!(count.load(std::sync::atomic::Ordering::Relaxed), at + 1, "{}", algorithm.name());
            let text = serde_json::to_string(&stopped.checkpoint).unwrap();
            let checkpoint = serde_json::from_str(&text).unwrap();
            let resumed =
                minimize(&curved(), &algorithm, &settings, &mut Unobserved, Some(checkpoint)).unwrap();
            assert_eq!(resumed.best, straight.best, "{} stopped at {at}", algorithm.name());
            assert_eq!(resumed.cost.to_bits(), straight.cost.to_bits());
        }
    }
}

#[test]
fn budget_is_met_exactly_even_inside_a_generation() {
    for budget in [7, 163, 330] {
        for algorithm in all_algorithms() {
            let settings = Settings { budget: Some(budget), ..Settings::default() };
            let mut calls = 0;
            let counter = std::sync::atomic::AtomicUsize::new(0);
            let problem = Residuals {
                bounds: cube(2, -3.0, 4.0),
                count: 3,
                residuals: |x: &[f64], out: &mut [f64]| {
                    counter.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                    out.copy_from_slice(&[x[0] - 0.3, 10.0 * x[1] * x[0], (x[1] * 9.0).sin() + x[0]]);
                    true
                },
            };
            let mut observer = |_: &Progress<'_>| {
                calls += 1;
                ControlFlow::Continue(())
            };
            let outcome = minimize(&problem, &algorithm, &settings, &mut observer, None).unwrap();
            assert_eq!(outcome.stopped, StopReason::Budget, "{}", algorithm.name());
            assert_eq!(outcome.evaluations, counter.into_inner(), "{} counts", algorithm.name());
            assert_eq!(calls, outcome.history.len());
            // Least squares does not begin a Jacobian beyond its budget.
            let unused = if let Algorithm::LeastSquares(_) = algorithm { 1 } else { 0 };
            assert!((budget - unused..=budget).contains(&outcome.evaluations), "{}", algorithm.name());
        }
    }
}

#[test]
fn flat_cost_stagnates_and_a_falling_one_does_not() {
    let settings = Settings {
        stagnation: Some(Stagnation { generations: 6, relative: 1e-9 }),
        generations: 40,
        ..Settings::default()
    };
    let flat = Cost { bounds: cube(2, 0.0, 1.0), cost: |_: &[f64]| 3.0 };
    for algorithm in population_methods() {
        let outcome = minimize_cost(&flat, &algorithm, &settings, &mut Unobserved, None).unwrap();
        assert_eq!((outcome.stopped, outcome.generations), (StopReason::Stagnation, 6));
    }
    let de = Algorithm::De(DeOptions::default());
    let falling = minimize_cost(&sphere(2), &de, &settings, &mut Unobserved, None).unwrap();
    assert_eq!((falling.stopped, falling.generations), (StopReason::Generations, 40));
}

#[test]
fn given_starts_are_members_of_the_first_population() {
    let settings =
        Settings { starts: vec![vec![9.0, 0.0], vec![1e-4, 0.0]], budget: Some(2), ..Settings::default() };
    for algorithm in population_methods() {
        let outcome = minimize_cost(&sphere(2), &algorithm, &settings, &mut Unobserved, None).unwrap();
        assert!((outcome.cost - 1e-8).abs() < 1e-18, "{}", outcome.cost);
        // The first is clipped to the box, whose upper end is 7.
        assert!((outcome.improvements[0].cost - 49.0).abs() < 1e-12);
    }
}

#[test]
fn infeasible_candidates_never_win() {
    for algorithm in all_algorithms() {
        let settings = Settings { generations: 60, budget: Some(6000), ..Settings::default() };
        let outcome = minimize(&half_infeasible(), &algorithm, &settings, &mut Unobserved, None).unwrap();
        assert!(outcome.cost < 1e-4, "{} {}", algorithm.name(), outcome.cost);
        assert!(outcome.best[0] + outcome.best[1] < 1.0);
    }
}

#[test]
fn run_without_a_feasible_candidate_is_an_error() {
    let nowhere =
        Residuals { bounds: cube(2, 0.0, 1.0), count: 1, residuals: |_: &[f64], _: &mut [f64]| false };
    for algorithm in all_algorithms() {
        let settings = Settings { generations: 3, ..Settings::default() };
        let error = minimize(&nowhere, &algorithm, &settings, &mut Unobserved, None).unwrap_err();
        assert!(
            matches!(error, OptimizeError::NoFeasiblePoint { evaluations } if evaluations >= 20),
            "{error}"
        );
    }
}

#[test]
fn least_squares_of_a_plain_cost_is_refused() {
    let algorithm = Algorithm::LeastSquares(LeastSquaresOptions::default());
    let error =
        minimize_cost(&sphere(2), &algorithm, &Settings::default(), &mut Unobserved, None).unwrap_err();
    assert_eq!(error, OptimizeError::NeedsResiduals);
}

#[test]
fn settings_and_options_outside_their_range_are_refused() {
    let settings = Settings::default;
    for (wrong, option) in [
        (Settings { generations: 0, ..settings() }, "generations"),
        (Settings { budget: Some(0), ..settings() }, "budget"),
        (Settings { threads: Some(0), ..settings() }, "threads"),
        (Settings { target: Some(f64::NAN), ..settings() }, "target"),
        (
            Settings { stagnation: Some(Stagnation { generations: 5, relative: 1.0 }), ..settings() },
            "stagnation.relative",
        ),
    ] {
        let de = Algorithm::De(DeOptions::default());
        let error = minimize_cost(&sphere(2), &de, &wrong, &mut Unobserved, None).unwrap_err();
        assert!(matches!(error, OptimizeError::Option { option: o, .. } if o == option), "{error}");
    }
    for (wrong, option) in [
        (Algorithm::DeAbc(DeAbcOptions { population: 1, ..Default::default() }), "population"),
        (Algorithm::Abc(AbcOptions { population: 0, ..Default::default() }), "population"),
        (Algorithm::De(DeOptions { population: 3, ..Default::default() }), "population"),
        (Algorithm::De(DeOptions { factor: f64::NAN, ..Default::default() }), "factor"),
        (Algorithm::Pso(PsoOptions { inertia: 1.0, ..Default::default() }), "inertia"),
        (Algorithm::LeastSquares(LeastSquaresOptions { starts: 0, ..Default::default() }), "starts"),
    ] {
        let error = minimize(&curved(), &wrong, &settings(), &mut Unobserved, None).unwrap_err();
        assert!(matches!(error, OptimizeError::Option { option: o, .. } if o == option), "{error}");
    }
    let starts = Settings { starts: vec![vec![0.0, 0.0], vec![0.0]], ..settings() };
    let de = Algorithm::De(DeOptions::default());
    let error = minimize_cost(&sphere(2), &de, &starts, &mut Unobserved, None).unwrap_err();
    assert!(matches!(error, OptimizeError::Start { index: 1, parameters: 2, .. }), "{error}");
}

fn checkpoint_of(
    problem: &impl LeastSquaresProblem,
    algorithm: &Algorithm,
    settings: &Settings,
) -> Checkpoint {
    let mut json = String::new();
    let outcome = minimize(problem, algorithm, settings, &mut interrupted_at(3, &mut json), None).unwrap();
    outcome.checkpoint
}

#[test]
fn checkpoint_of_another_run_is_refused() {
    let de = Algorithm::De(DeOptions::default());
    let settings = Settings::default();
    let checkpoint = checkpoint_of(&curved(), &de, &settings);
    let resume = |problem: &Residuals<ResidualFunction>, algorithm: &Algorithm, settings: &Settings| {
        minimize(problem, algorithm, settings, &mut Unobserved, Some(checkpoint.clone())).unwrap_err()
    };
    let mut narrower = cube(2, -3.0, 4.0);
    narrower.ranges[1] = Range::linear("x1", -3.0, 3.9);
    let error = resume(&rosenbrock(narrower), &de, &settings);
    assert_eq!(error, OptimizeError::CheckpointBounds { parameter: "x1".to_owned() });
    let error = resume(&powell_singular(), &de, &settings);
    assert!(matches!(error, OptimizeError::CheckpointBounds { .. }), "{error}");
    let error =
        resume(&curved(), &Algorithm::De(DeOptions { factor: 0.6, ..DeOptions::default() }), &settings);
    assert!(matches!(error, OptimizeError::CheckpointAlgorithm { .. }), "{error}");
    let error = resume(&curved(), &de, &Settings { seed: 2, ..Settings::default() });
    assert!(matches!(error, OptimizeError::CheckpointSettings { setting: "seed", .. }), "{error}");
    let other_data: ResidualFunction = |x, out| {
        out.copy_from_slice(&[x[0] - 0.7, x[1] - 1.1]);
        true
    };
    let other_data = Residuals { residuals: other_data, ..curved() };
    let error = resume(&other_data, &de, &settings);
    assert!(matches!(error, OptimizeError::CheckpointCost { .. }), "{error}");
    // The number of threads is not part of a run.
    let threads = Settings { threads: Some(2), ..Settings::default() };
    assert!(minimize(&curved(), &de, &threads, &mut Unobserved, Some(checkpoint.clone())).is_ok());
}

#[test]
fn damaged_checkpoint_is_refused_without_a_panic() {
    let settings = Settings::default();
    for algorithm in all_algorithms() {
        let checkpoint = checkpoint_of(&curved(), &algorithm, &settings);
        let json = serde_json::to_value(&checkpoint).unwrap();
        let mut paths = Vec::new();
        number_lists(&json, String::new(), &mut paths);
        let state: Vec<_> =
            paths.iter().filter(|path| path.starts_with("/state") || path.ends_with("/best")).collect();
        assert!(state.len() >= 2, "{paths:?}");
        for path in state {
            for damage in [Vec::new(), vec![serde_json::json!(7.5); 40]] {
                let mut json = json.clone();
                *json.pointer_mut(path).unwrap().as_array_mut().unwrap() = damage;
                // It either is no longer a checkpoint (a list of integers) or is rejected.
                if let Ok(damaged) = serde_json::from_value::<Checkpoint>(json) {
                    let error = minimize(&curved(), &algorithm, &settings, &mut Unobserved, Some(damaged))
                        .unwrap_err();
                    let refused = matches!(error, OptimizeError::CheckpointDamaged { .. });
                    assert!(refused, "{} {path}: {error}", algorithm.name());
                }
            }
        }
    }
}

/// JSON pointers of all lists of numbers in `value`.
fn number_lists(value: &serde_json::Value, path: String, found: &mut Vec<String>) {
    match value {
        serde_json::Value::Array(items) if items.first().is_some_and(|item| item.is_number()) => {
            found.push(path)
        }
        serde_json::Value::Array(items) => {
            items.iter().enumerate().for_each(|(i, item)| number_lists(item, format!("{path}/{i}"), found));
        }
        serde_json::Value::Object(entries) => {
            entries.iter().for_each(|(key, item)| number_lists(item, format!("{path}/{key}"), found));
        }
        _ => {}
    }
}

#[test]
fn checkpoint_of_another_format_is_refused() {
    let de = Algorithm::De(DeOptions::default());
    let mut json = serde_json::to_value(checkpoint_of(&curved(), &de, &Settings::default())).unwrap();
    json["version"] = serde_json::json!(99);
    let later: Checkpoint = serde_json::from_value(json).unwrap();
    let error = minimize(&curved(), &de, &Settings::default(), &mut Unobserved, Some(later)).unwrap_err();
    assert!(matches!(error, OptimizeError::CheckpointFormat { version: 99, .. }), "{error}");
}

#[test]
fn infinite_costs_survive_json() {
    // Half of the box is infeasible, so some costs of the population are infinite.
    let de = Algorithm::De(DeOptions::default());
    let checkpoint = checkpoint_of(&half_infeasible(), &de, &Settings::default());
    let json = serde_json::to_string(&checkpoint).unwrap();
    let mut first = None;
    let mut observer = |progress: &Progress<'_>| {
        first = Some(serde_json::to_string(progress.checkpoint()).unwrap());
        ControlFlow::Break(())
    };
    minimize(&half_infeasible(), &de, &Settings::default(), &mut observer, None).unwrap();
    let first = first.unwrap();
    assert!(first.contains("null,"), "the first population has an infinite cost");
    let back: Checkpoint = serde_json::from_str(&first).unwrap();
    assert_eq!(serde_json::to_string(&back).unwrap(), first);
    assert_eq!(serde_json::from_str::<Checkpoint>(&json).unwrap(), checkpoint);
}
