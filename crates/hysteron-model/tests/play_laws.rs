//! Promise: laws of the Prandtl–Ishlinskii block that hold for every parameter set.
//!
//! A play takes maxima and minima of rounded sums, and rounding keeps order. So most laws hold to the last
//! bit.
#![allow(clippy::unwrap_used)] // Helpers outside the test functions; a failure is a failed test.

use hysteron_model::Start;
use hysteron_model::hysteresis::PrandtlIshlinskii;
use proptest::collection::vec;
use proptest::prelude::*;

fn model() -> impl Strategy<Value = PrandtlIshlinskii> {
    (vec(-2.0..2.0_f64, 1..5), vec((0.05..1.5_f64, -1.0..2.0_f64), 0..10)).prop_map(|(polynomial, plays)| {
        let mut threshold = 0.0;
        let (thresholds, weights) = plays
            .into_iter()
            .map(|(gap, weight)| {
                threshold += gap;
                (threshold, weight)
            })
            .unzip();
        PrandtlIshlinskii::new(polynomial, thresholds, weights).unwrap()
    })
}

fn drive() -> impl Strategy<Value = Vec<f64>> {
    vec(-6.0..6.0_f64, 1..30)
}

const REST: Start<f64> = Start::Rest { voltage_v: 0.0 };

/// Output from these plays on, and the plays at its end.
fn resume(model: &PrandtlIshlinskii, u: &[f64], mut plays: Vec<f64>) -> (Vec<f64>, Vec<f64>) {
    let mut v = vec![0.0; u.len()];
    model.resume(u, &mut plays, &mut v).unwrap();
    (v, plays)
}

/// Output, and the plays at its end.
fn simulate(
    model: &PrandtlIshlinskii,
    u: &[f64],
    start: Start<f64>,
    mut plays: Vec<f64>,
) -> (Vec<f64>, Vec<f64>) {
    let mut v = vec![0.0; u.len()];
    plays.resize(model.weights.len(), 0.0);
    model.simulate(u, start, &mut plays, &mut v).unwrap();
    (v, plays)
}

fn from_rest(model: &PrandtlIshlinskii, u: &[f64]) -> (Vec<f64>, Vec<f64>) {
    simulate(model, u, REST, Vec::new())
}

/// `count` voltages on a monotone way, the last one `to`.
fn way(from: f64, to: f64, count: usize) -> impl Iterator<Item = f64> {
    let (low, high) = (from.min(to), from.max(to));
    (1..=count).map(move |k| {
        if k == count { to } else { (from + (to - from) * k as f64 / count as f64).clamp(low, high) }
    })
}

/// A bound of |dv/du| for |u| ≤ 6 V.
fn steepest(model: &PrandtlIshlinskii) -> f64 {
    let polynomial: f64 = model
        .polynomial
        .iter()
        .enumerate()
        .map(|(i, c)| (i + 1) as f64 * c.abs() * 6.0_f64.powi(i as i32))
        .sum();
    polynomial + model.weights.iter().map(|w| w.abs()).sum::<f64>()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(200) })]

    #[test]
    fn only_the_turning_points_count(model in model(), turns in drive(), between in 1..20_usize) {
        let mut dense = Vec::new();
        let mut last = 0.0;
        for &turn in &turns {
            dense.extend(way(last, turn, between));
            last = turn;
        }
        let (direct, plays) = from_rest(&model, &turns);
        let (v, dense_plays) = from_rest(&model, &dense);
        prop_assert_eq!(&plays, &dense_plays);
        prop_assert_eq!(&direct, &v.into_iter().skip(between - 1).step_by(between).collect::<Vec<_>>());
        // The same through the finer time base, whose first sample is a turning point.
        let shifted: Vec<f64> = turns[..1].iter().chain(&dense[between..]).copied().collect();
        let (mut every, mut every_plays) = (vec![0.0; turns.len()], vec![0.0; plays.len()]);
        model.simulate_every(between, &shifted, REST, &mut every_plays, &mut every).unwrap();
        prop_assert_eq!(&direct, &every);
        prop_assert_eq!(&plays, &every_plays);
    }

    #[test]
    fn a_larger_excursion_wipes_out_what_was_before(model in model(), history in vec(-5.0..5.0_f64, 0..20)) {
        let (straight, plays) = from_rest(&model, &[6.0]);
        let (v, after) = from_rest(&model, &[&history[..], &[6.0]].concat());
        prop_assert_eq!(straight.last(), v.last());
        prop_assert_eq!(plays, after);
    }

    #[test]
    fn minor_loops_close_and_leave_no_trace(
        model in model(), history in drive(), down in -5.0..4.0_f64, shares in vec(0.0..1.0_f64, 1..20),
    ) {
        // Up to 6, down, anything between the two, back to where it turned, back up.
        let minor: Vec<f64> = shares.iter().map(|s| down + (6.0 - down) * s).collect();
        let (_, top) = from_rest(&model, &[&history[..], &[6.0]].concat());
        let (first, bottom) = resume(&model, &[down], top.clone());
        let (second, again) = resume(&model, &[&minor[..], &[down]].concat(), bottom.clone());
        prop_assert_eq!(first.last(), second.last());
        prop_assert_eq!(&bottom, &again);
        prop_assert_eq!(resume(&model, &[6.0], again).1, top);
    }

    #[test]
    fn minor_loops_between_the_same_voltages_are_congruent(
        model in model(), one in drive(), other in drive(), ends in (-6.0..6.0_f64, -6.0..6.0_f64),
    ) {
        let period: Vec<f64> = way(ends.0, ends.1, 12).chain(way(ends.1, ends.0, 12)).collect();
        let settled = |history: &[f64]| {
            let plays = from_rest(&model, &[history, &[ends.0], &period].concat()).1;
            resume(&model, &period, plays).0
        };
        let (a, b) = (settled(&one), settled(&other));
        // Up to 10 terms of up to 2 × 10 µm, and a polynomial of up to 4000 µm.
        for (x, y) in a.iter().zip(&b) {
            prop_assert!(((x - a[0]) - (y - b[0])).abs() < 1e-11, "{x} {y}");
        }
    }

    #[test]
    fn odd_polynomials_make_odd_operators(mut model in model(), u in drive()) {
        model.polynomial.iter_mut().skip(1).step_by(2).for_each(|even| *even = 0.0);
        let mirrored: Vec<f64> = u.iter().map(|u| -u).collect();
        for (a, b) in from_rest(&model, &u).0.iter().zip(from_rest(&model, &mirrored).0) {
            prop_assert_eq!(*a, -b);
        }
    }

    #[test]
    fn any_start_settles_within_one_period(
        model in model(), u in vec(-6.0..6.0_f64, 1..30), plays in vec(-20.0..20.0_f64, 10),
    ) {
        let plays = plays[..model.weights.len()].to_vec();
        let (_, plays) = resume(&model, &u, plays);
        let (second, after) = resume(&model, &u, plays.clone());
        prop_assert_eq!(&plays, &after);
        prop_assert_eq!(second, resume(&model, &u, after).0);
    }

    #[test]
    fn the_periodic_start_closes_the_loop_and_does_not_depend_on_the_phase(
        model in model(), u in vec(-6.0..6.0_f64, 1..30), turn in 0..30_usize,
    ) {
        let (mut first, plays) = simulate(&model, &u, Start::PERIODIC, Vec::new());
        let (second, after) = resume(&model, &u, plays.clone());
        prop_assert_eq!(&first, &second);
        prop_assert_eq!(&plays, &after);
        let turn = turn % u.len();
        let mut turned = u.clone();
        turned.rotate_left(turn);
        first.rotate_left(turn);
        prop_assert_eq!(first, simulate(&model, &turned, Start::PERIODIC, Vec::new()).0);
    }

    #[test]
    fn the_output_is_continuous_at_reversals_as_elsewhere(
        model in model(), moves in vec((-6.0..6.0_f64, -12.0..0.0_f64), 1..30),
    ) {
        // Moves of all sizes, most of them reversals.
        let mut u = vec![0.0];
        for (to, exponent) in moves {
            let last = u[u.len() - 1];
            u.push(last + (to - last) * 10.0_f64.powf(exponent));
        }
        let v = from_rest(&model, &u).0;
        for (u, v) in u.windows(2).zip(v.windows(2)) {
            prop_assert!((v[1] - v[0]).abs() <= steepest(&model) * (u[1] - u[0]).abs() + 1e-11);
        }
    }

    #[test]
    fn one_step_at_a_time_is_the_whole_record(model in model(), u in drive(), rest in -6.0..6.0_f64) {
        let bank = model.bank().unwrap();
        let mut plays = vec![rest; model.weights.len()];
        let steps: Vec<f64> =
            u.iter().map(|&u| model.polynomial_at(u) + bank.step(&mut plays, u).unwrap()).collect();
        prop_assert_eq!((steps, plays), simulate(&model, &u, Start::Rest { voltage_v: rest }, Vec::new()));
    }

    #[test]
    fn any_finite_input_gives_finite_output_or_an_error(
        c in prop::num::f64::NORMAL | prop::num::f64::ZERO,
        w in prop::array::uniform2(prop::num::f64::NORMAL),
        u in vec(prop::num::f64::NORMAL | prop::num::f64::ZERO, 0..8),
        periodic in any::<bool>(),
    ) {
        let model = PrandtlIshlinskii::new(vec![c, 1.0], vec![1.0, 1e200], w.to_vec()).unwrap();
        let start = if periodic { Start::PERIODIC } else { REST };
        let mut v = vec![0.0; u.len()];
        if model.simulate(&u, start, &mut [0.0; 2], &mut v).is_ok() {
            prop_assert!(v.iter().all(|v| v.is_finite()), "{v:?}");
        }
    }
}
