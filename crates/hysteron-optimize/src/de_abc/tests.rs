use super::super::evaluate::Evaluate;
use super::super::ledger::Ledger;
use super::super::points::Points;
use super::super::test_problems::cube;
use super::*;

struct ByFunction<F>(F);

impl<F: Fn(&[f64]) -> f64> Evaluate for ByFunction<F> {
    fn costs(&mut self, points: &Points, costs: &mut Vec<f64>) {
        costs.clear();
        costs.extend((0..points.len()).map(|i| (self.0)(points.get(i))));
    }
}

/// |x₁ − 0.1| + |x₂ − 0.7|, infeasible where x₁ > 0.24.
fn cost(x: &[f64]) -> f64 {
    if x[0] > 0.24 { f64::INFINITY } else { (x[0] - 0.1).abs() + (x[1] - 0.7).abs() }
}

/// Runs one generation from the sources (0.2, 0.6), the best, and (0.4, 0.3), with iter = 3 of Iter = 4: F =
/// 1/4. With two sources the partner is the other one, and a source of infinite cost draws no onlooker:
/// nothing is random.
fn one_generation(options: &DeAbcOptions, cost: fn(&[f64]) -> f64) -> (Colony, Ledger) {
    let mut sources = Points::new(2);
    let costs = [[0.2, 0.6], [0.4, 0.3]].map(|x| {
        sources.push(&x);
        cost(&x)
    });
    let mut colony = Colony { sources, costs: costs.to_vec(), trials: vec![0, 0], scouts_fired: 0 };
    let mut ledger = Ledger::new(2);
    ledger.count(&[0.2, 0.6], costs[0]);
    ledger.count(&[0.4, 0.3], costs[1]);
    ledger.generation = 3;
    let settings = Settings { generations: 4, ..Settings::default() };
    let bounds = cube(2, 0.0, 1.0);
    let mut evaluator = ByFunction(cost);
    let mut search =
        Search { ledger: &mut ledger, settings: &settings, bounds: &bounds, evaluator: &mut evaluator };
    generation(options, &mut colony, &mut search, &mut Scratch::new(2));
    (colony, ledger)
}

fn assert_close(found: &[f64], expected: &[f64]) {
    let close =
        found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15);
    assert!(close, "{found:?} is not {expected:?}");
}

#[test]
fn one_generation_is_the_one_computed_by_hand() {
    let options = DeAbcOptions { population: 2, scout: Scout::Off, ..DeAbcOptions::default() };
    let (colony, ledger) = one_generation(&options, cost);
    // Employed (Eqs. 8, 9): (0.2, 0.6) + ¼ ((0.2, 0.6) − (0.4, 0.3)) = (0.15, 0.675), cost 0.075 < 0.2:
    // taken. (0.2, 0.6) + ¼ ((0.4, 0.3) − (0.2, 0.6)) = (0.25, 0.525), infeasible: not taken, counter 1.
    // Onlookers, both on the first, which is x_best now: (0.15, 0.675) + ¼ ((0.15, 0.675) − (0.4, 0.3)) =
    // (0.0875, 0.76875), cost 0.08125 > 0.075: neither is taken, counter 2.
    assert_close(colony.sources.get(0), &[0.15, 0.675]);
    assert_close(colony.sources.get(1), &[0.4, 0.3]);
    assert_close(&colony.costs[..1], &[0.075]);
    assert_eq!(colony.costs[1], f64::INFINITY);
    assert_eq!(colony.trials, [2, 1]);
    assert_eq!((ledger.evaluations, colony.scouts_fired), (2 + 4, 0));
    assert_close(&ledger.best, &[0.15, 0.675]);
}

#[test]
fn one_moved_component_leaves_the_other_at_the_source() {
    let options = DeAbcOptions {
        population: 2,
        scout: Scout::Off,
        moved: MovedComponents::One,
        ..DeAbcOptions::default()
    };
    let (colony, _) =
        one_generation(&options, |x| if x[0] > 0.24 { f64::INFINITY } else { 1.0 - x[1] + x[0] });
    // From (0.2, 0.6) a bee reaches (0.15, 0.6) or (0.2, 0.675), both better; an onlooker then moves one
    // component of that: both components are x_best,j + ¼ Δ or untouched, never anything else.
    let found = colony.sources.get(0);
    let first = [0.2, 0.15, 0.15 + 0.25 * (0.15 - 0.4), 0.2 + 0.25 * (0.2 - 0.4)];
    let second = [0.6, 0.675, 0.675 + 0.25 * (0.675 - 0.3), 0.6 + 0.25 * (0.6 - 0.3)];
    assert!(first.iter().any(|x| (x - found[0]).abs() < 1e-15), "{found:?}");
    assert!(second.iter().any(|x| (x - found[1]).abs() < 1e-15), "{found:?}");
    assert_ne!(found, &[0.2, 0.6]);
}

fn with_scout(chaos: Chaos, keeps: ScoutKeeps, iterates: usize) -> (Colony, Ledger) {
    let scout = Scout::Chaotic { iterates, chaos, keeps };
    let options = DeAbcOptions { population: 2, scout, limit: Some(0), ..DeAbcOptions::default() };
    // The first source is the best, and every proposal is worse than both: counters 1 + onlookers, the second
    // is scouted. Chaotic points from (0.4, 0.3): C¹ = (0.96, 0.84), C² = (0.1536, 0.5376).
    one_generation(&options, |x| match x {
        [0.2, 0.6] => 1.0,
        [0.4, 0.3] => 2.0,
        x => 3.0 + x[0],
    })
}

#[test]
fn scout_follows_the_logistic_map_and_wraps_around_the_box() {
    // Eq. 12 wrapped: (1.36, 1.14) → (0.36, 0.14), then (0.5536, 0.8376); the first is the better one.
    let (colony, ledger) = with_scout(Chaos::Wrap, ScoutKeeps::Replacement, 2);
    assert_close(colony.sources.get(1), &[0.36, 0.14]);
    assert_close(&colony.costs, &[1.0, 3.36]);
    assert_eq!((colony.trials[1], colony.scouts_fired, ledger.evaluations), (0, 1, 2 + 4 + 2));
    // As the chaotic variable itself: (0.96, 0.84), then (0.1536, 0.5376), the better one.
    let (colony, _) = with_scout(Chaos::ChaoticMap, ScoutKeeps::Replacement, 2);
    assert_close(colony.sources.get(1), &[0.1536, 0.5376]);
}

#[test]
fn scout_that_keeps_the_best_keeps_the_source_where_no_point_is_better() {
    let (colony, ledger) = with_scout(Chaos::Wrap, ScoutKeeps::Best, 5);
    assert_close(colony.sources.get(1), &[0.4, 0.3]);
    assert_eq!((colony.trials[1], colony.scouts_fired, ledger.evaluations), (0, 1, 2 + 4 + 5));
}

#[test]
fn chaotic_search_never_starts_on_a_fixed_point() {
    for fixed in [0.0, 0.25, 0.5, 0.75, 1.0] {
        let mut c = chaotic_start(fixed, &mut Stream::new(3, 4));
        let first = c;
        for _ in 0..10 {
            c = logistic(c);
            assert!(c > 0.0 && c < 1.0);
        }
        assert_ne!(first, fixed);
    }
    assert_eq!(chaotic_start(0.4, &mut Stream::new(3, 4)), 0.4);
}

#[test]
fn mutation_factor_falls_from_one_to_one_over_the_number_of_generations() {
    let settings = Settings { generations: 150, ..Settings::default() };
    assert_eq!(mutation_factor(0, &settings), 1.0);
    assert!((mutation_factor(149, &settings) - 1.0 / 150.0).abs() < 1e-15);
}
