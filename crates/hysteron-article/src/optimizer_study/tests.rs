use super::*;
use crate::ArticleError;
use hysteron_identify::{Event, Watch};
use hysteron_optimize::{StopReason, Unobserved};
use std::ops::ControlFlow;

fn study_of(problem: StudyProblem, competitors: &[Competitor], seeds: usize, budget: usize) -> ProblemResult {
    let options = StudyOptions {
        problems: vec![problem],
        competitors: competitors.to_vec(),
        seeds,
        budget,
        ..StudyOptions::default()
    };
    run_study(&options, &Watch::silent()).unwrap().problems.remove(0)
}

#[test]
fn de_abc_is_ahead_of_de_on_the_static_block() {
    // The article's number of generations: with fewer, F falls too fast and DE-ABC gets stuck more often.
    let table = study_of(StudyProblem::StaticBlock, &[Competitor::DeAbc, Competitor::De], 2, 7550);
    let [de_abc, de] = &table.rows[..] else { panic!() };
    for (ours, theirs) in de_abc.runs.iter().zip(&de.runs) {
        let [ours, theirs] = [ours, theirs].map(|run| run.evaluations_to_target.unwrap());
        assert!(ours < theirs && ours < 3200, "{ours} {theirs}");
    }
}

#[test]
fn moving_one_dimension_as_the_article_words_it_gets_nowhere_on_the_static_block() {
    let table = study_of(StudyProblem::StaticBlock, &[Competitor::DeAbcOneDimension], 2, 7550);
    for run in &table.rows[0].runs {
        assert!(run.best_rmse > 5.0 * table.reachable_rmse, "{}", run.best_rmse);
    }
}

#[test]
fn least_squares_needs_a_few_hundred_evaluations_on_either_problem() {
    let competitors = [Competitor::LeastSquares, Competitor::DeAbcThenLeastSquares];
    for problem in StudyProblem::ALL {
        let table = study_of(problem, &competitors, 3, 1000);
        // RMSE of N noise samples, reduced by five fitted parameters: σ √(1 ± 1/√(2N)), within four times
        // that.
        assert!(
            (table.reachable_rmse / table.noise_um - 1.0).abs() < 4.0 * 0.016,
            "{}",
            table.reachable_rmse
        );
        for row in &table.rows {
            assert_eq!(row.success_percent, 100.0, "{} on {problem:?}", row.name);
            assert!(row.evaluations_to_target.unwrap().upper < 600.0);
            assert!(row.median_best_rmse >= table.reachable_rmse * (1.0 - 1e-9));
        }
    }
}

#[test]
fn study_does_not_depend_on_the_number_of_threads() {
    let run = |threads| {
        let options =
            StudyOptions { seeds: 2, budget: 200, threads: Some(threads), ..StudyOptions::default() };
        run_study(&options, &Watch::silent()).unwrap()
    };
    let one = run(1);
    assert_eq!(one, run(3));
    // Its JSON reads back the same, except the threads, which are no part of the result.
    let mut read: Study = serde_json::from_str(&serde_json::to_string(&one).unwrap()).unwrap();
    read.options.threads = one.options.threads;
    assert_eq!(read, one);
    assert_eq!((one.problems.len(), one.problems[0].rows.len()), (2, Competitor::ALL.len()));
    let curve = &one.problems[0].rows[0].curve;
    assert_eq!(curve.evaluations, [50, 100, 150, 200]);
    assert!(curve.median.windows(2).all(|pair| pair[1] <= pair[0]));
    assert!((0..4).all(|g| curve.lower[g] <= curve.median[g] && curve.median[g] <= curve.upper[g]));
}

#[test]
fn progress_counts_every_run_and_can_stop_the_study() {
    let options = StudyOptions { seeds: 2, budget: 200, threads: Some(1), ..StudyOptions::default() };
    let runs = 2 * 2 * Competitor::ALL.len();
    let mut seen = Vec::new();
    let count = Watch::new(|event: &Event<'_>| {
        seen.push((event.fraction * runs as f64).round() as usize);
        ControlFlow::Continue(())
    });
    run_study(&options, &count).unwrap();
    drop(count);
    assert_eq!(seen, (1..=runs).collect::<Vec<_>>());
    let mut told = 0;
    let third = Watch::new(|_: &Event<'_>| {
        told += 1;
        if told == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let stopped = run_study(&options, &third);
    assert!(matches!(stopped, Err(ArticleError::StudyStopped { done: 3, .. })), "{stopped:?}");
}

#[test]
fn hybrid_run_keeps_one_account_of_both_parts() {
    let problem = StaticBlock::new(1).unwrap();
    let outcome = Competitor::DeAbcThenLeastSquares.run(&problem, 2000, 5, &mut Unobserved).unwrap();
    assert!(outcome.evaluations > 100 && outcome.evaluations < 300, "{}", outcome.evaluations);
    let improvements = &outcome.improvements;
    assert!(improvements.windows(2).all(|pair| pair[0].evaluation < pair[1].evaluation));
    assert!(improvements.windows(2).all(|pair| pair[0].cost > pair[1].cost));
    assert!(improvements[0].evaluation == 1 && improvements.last().unwrap().evaluation > 100);
    assert_eq!(improvements.last().unwrap().cost, outcome.cost);
    assert_eq!(outcome.stopped, StopReason::StartsDone);
}

#[test]
fn options_outside_their_range_are_refused() {
    for (options, name) in [
        (StudyOptions { seeds: 0, ..StudyOptions::default() }, "seeds"),
        (StudyOptions { budget: 199, ..StudyOptions::default() }, "budget"),
        (StudyOptions { problems: vec![], ..StudyOptions::default() }, "problems"),
        (StudyOptions { competitors: vec![], ..StudyOptions::default() }, "competitors"),
        (StudyOptions { threads: Some(0), ..StudyOptions::default() }, "threads"),
    ] {
        let error = run_study(&options, &Watch::silent()).unwrap_err();
        assert!(matches!(error, ArticleError::StudyOption { option, .. } if option == name), "{error}");
    }
}
