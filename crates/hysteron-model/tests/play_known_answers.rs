//! Promise: the Prandtl–Ishlinskii block agrees with numbers worked out by hand and with the rule of Masing
//! and Madelung, which knows no plays: a list of turning points, the loading curve, and its branches at twice
//! the size.
#![allow(clippy::unwrap_used)] // Helpers outside the test functions; a failure is a failed test.

use hysteron_model::Start;
use hysteron_model::hysteresis::{HysteresisError, PrandtlIshlinskii};
use proptest::collection::vec;
use proptest::prelude::*;

const REST: Start<f64> = Start::Rest { voltage_v: 0.0 };

fn simulate(model: &PrandtlIshlinskii, u: &[f64], start: Start<f64>) -> Vec<f64> {
    let mut v = vec![0.0; u.len()];
    model.simulate(u, start, &mut vec![0.0; model.weights.len()], &mut v).unwrap();
    v
}

/// Area enclosed by a closed way of (u, v), counter-clockwise positive.
fn area(u: &[f64], v: &[f64]) -> f64 {
    let next = |k: usize| (k + 1) % u.len();
    (0..u.len()).map(|k| 0.5 * (u[k] * v[next(k)] - u[next(k)] * v[k])).sum()
}

#[test]
fn the_loop_of_one_play_is_a_parallelogram() {
    // Half-width 1 V, weight 2 µm/V, triangle of ±4 V in steps of 0.25 V.
    let model = PrandtlIshlinskii::new(vec![0.0], vec![1.0], vec![2.0]).unwrap();
    let u: Vec<f64> = (0..64).map(|k| 4.0 - (0.25 * f64::from(k) - 8.0).abs()).collect();
    let v = simulate(&model, &u, Start::PERIODIC);
    // Wide 2r wherever it is open from side to side: up w (u − r), down w (u + r).
    for (k, (&u_now, &v_now)) in u.iter().zip(&v).enumerate() {
        let rising = u[(k + 1) % 64] > u_now;
        if u_now.abs() < 2.0 {
            assert_eq!(v_now, 2.0 * if rising { u_now - 1.0 } else { u_now + 1.0 });
        }
    }
    assert_eq!(v.iter().copied().fold(f64::MIN, f64::max), 2.0 * 3.0);
    // 2r wide, 2 (A − r) w high.
    assert!((area(&u, &v) - 2.0 * 2.0 * 3.0 * 2.0).abs() < 1e-12, "{}", area(&u, &v));
}

#[test]
fn areas_add_and_a_polynomial_has_none() {
    let two = PrandtlIshlinskii::new(vec![1.0], vec![0.5, 2.0], vec![1.0, 0.3]).unwrap();
    let u: Vec<f64> = (0..2400).map(|k| 0.005 * (f64::from(k) - 1200.0).abs() - 3.0).collect();
    let v = simulate(&two, &u, Start::PERIODIC);
    // Σ w 4r (A − r).
    let want = 2.0 * 2.5 + 0.3 * 8.0;
    assert!((area(&u, &v) - want).abs() < 1e-9, "{}", area(&u, &v));
    // There and back through the same points.
    let bent = PrandtlIshlinskii { polynomial: vec![2.0, -0.1, 0.02], ..two };
    let v = simulate(&bent, &u, Start::PERIODIC);
    assert!((area(&u, &v) - want).abs() < 1e-9, "{}", area(&u, &v));
}

#[test]
fn loading_curve_by_hand() {
    let model = PrandtlIshlinskii::new(vec![1.0, 0.5], vec![1.0, 2.0], vec![2.0, -1.0]).unwrap();
    for (u, v) in [(0.0, 0.0), (1.0, 1.5), (2.0, 6.0), (3.0, 10.5), (-1.0, -0.5), (-3.0, -1.5)] {
        assert_eq!(model.loading_curve(u), v);
        assert_eq!(simulate(&model, &[u], REST), [v]);
    }
}

#[test]
fn starts_are_what_they_say() {
    let model = PrandtlIshlinskii::new(vec![1.0], vec![1.0, 8.0], vec![2.0, 10.0]).unwrap();
    // At rest every play is in the middle of its width.
    assert_eq!(simulate(&model, &[3.0, 3.5], Start::Rest { voltage_v: 3.0 }), [39.0, 39.5]);
    // 8 V is too wide for ±2 V around 1 V: it stays at 1 V, from whatever sample the period begins.
    assert_eq!(simulate(&model, &[3.0, -1.0], Start::PERIODIC), [3.0 + 4.0 + 10.0, -1.0 + 10.0]);
    assert_eq!(simulate(&model, &[-1.0, 3.0], Start::PERIODIC), [-1.0 + 10.0, 3.0 + 4.0 + 10.0]);
    let (mut plays, mut v) = ([2.5, -4.0], [0.0]);
    model.resume(&[3.0], &mut plays, &mut v).unwrap();
    assert_eq!((plays, v), ([2.5, -4.0], [3.0 + 5.0 - 40.0]));
    model.resume(&[], &mut plays, &mut []).unwrap();
    assert_eq!(plays, [2.5, -4.0]);
    model.simulate(&[], Start::PERIODIC, &mut plays, &mut []).unwrap();
}

#[test]
fn errors_carry_the_numbers() {
    let new = |p: &[f64], r: &[f64], w: &[f64]| {
        PrandtlIshlinskii::new(p.to_vec(), r.to_vec(), w.to_vec()).unwrap_err()
    };
    assert_eq!(new(&[], &[], &[]), HysteresisError::EmptyPolynomial);
    assert!(matches!(new(&[1.0, f64::NAN], &[], &[]), HysteresisError::Coefficient { power: 2, .. }));
    assert_eq!(new(&[1.0], &[1.0], &[]), HysteresisError::PlayCount { thresholds: 1, weights: 0 });
    assert_eq!(
        new(&[1.0], &[1.0, 0.5], &[1.0, 1.0]),
        HysteresisError::Threshold { index: 1, value: 0.5, above: 1.0 }
    );
    assert_eq!(
        new(&[1.0], &[1.0], &[f64::INFINITY]),
        HysteresisError::Weight { index: 0, value: f64::INFINITY }
    );
    let model = PrandtlIshlinskii::new(vec![1.0], vec![1.0], vec![2.0]).unwrap();
    let run = |u: &[f64], start, plays: &mut [f64], out: usize| {
        model.simulate(u, start, plays, &mut vec![0.0; out]).unwrap_err()
    };
    assert_eq!(run(&[1.0], REST, &mut [0.0], 2), HysteresisError::Lengths { expected: 1, found: 2 });
    assert_eq!(run(&[1.0], REST, &mut [], 1), HysteresisError::PlayStates { expected: 1, found: 0 });
    for start in [REST, Start::PERIODIC] {
        assert_eq!(run(&[1.0, f64::NAN], start, &mut [0.0], 2), HysteresisError::Drive { index: 1 });
    }
    let rest = Start::Rest { voltage_v: f64::INFINITY };
    assert_eq!(run(&[1.0], rest, &mut [0.0], 1), HysteresisError::Drive { index: 0 });
    let resumed = model.resume(&[1.0], &mut [f64::NAN], &mut [0.0]).unwrap_err();
    assert_eq!(resumed, HysteresisError::Drive { index: 0 });
    assert_eq!(run(&[1.0, 1e308], REST, &mut [0.0], 2), HysteresisError::Overflow { index: 1 });
    let error = model.simulate_every(0, &[1.0], REST, &mut [0.0], &mut [0.0]).unwrap_err();
    assert_eq!(error, HysteresisError::Factor);
}

/// Turning points that the output still depends on, the rest voltage first and the present voltage last.
fn dominant(rest: f64, history: &[f64]) -> Vec<f64> {
    let mut e = vec![rest];
    for &u in history {
        if let [.., before, last] = e[..]
            && (u - last) * (last - before) >= 0.0
        {
            e.pop();
        }
        e.push(u);
        loop {
            match e[..] {
                // Beyond the mirror image of the first turn: back on the loading curve from rest.
                [rest, turn, u] if (u - rest).abs() >= (turn - rest).abs() => {
                    e.remove(1);
                }
                // A loop within a branch has closed.
                [_, .., from, turn, u] if e.len() > 3 && (u - turn).abs() >= (turn - from).abs() => {
                    e.drain(e.len() - 3..e.len() - 1);
                }
                _ => break,
            }
        }
    }
    e
}

/// Output by the rule of Masing: φ from rest, then every branch is φ at twice the size from where it turned.
fn masing(model: &PrandtlIshlinskii, rest: f64, history: &[f64]) -> f64 {
    let phi = |x: f64| model.loading_curve(x) - model.polynomial_at(x);
    let e = dominant(rest, history);
    let branches = e.windows(2).enumerate().map(|(k, e)| {
        let by = e[1] - e[0];
        if k == 0 { phi(by) } else { 2.0 * phi(0.5 * by) }
    });
    let line: f64 = model.weights.iter().map(|w| w * rest).sum();
    model.polynomial_at(e[e.len() - 1]) + line + branches.sum::<f64>()
}

#[test]
fn dominant_turning_points_by_hand() {
    assert_eq!(dominant(0.0, &[1.0, 3.0, 2.0, 2.5, 2.2]), [0.0, 3.0, 2.0, 2.5, 2.2]);
    assert_eq!(dominant(0.0, &[3.0, 2.0, 2.5, 1.9]), [0.0, 3.0, 1.9]);
    assert_eq!(dominant(0.0, &[3.0, 2.0, 2.5, 1.9, -3.5]), [0.0, -3.5]);
    assert_eq!(dominant(0.0, &[3.0, -1.0, 2.0, 0.0, 1.0, 3.5]), [0.0, 3.5]);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(500) })]

    #[test]
    fn plays_follow_the_rule_of_masing(
        polynomial in vec(-1.0..1.0_f64, 1..4),
        plays in vec((0.05..1.5_f64, -1.0..2.0_f64), 0..10),
        history in vec(prop_oneof![-6.0..6.0_f64, (-6..=6_i32).prop_map(f64::from)], 1..40),
        rest in -3.0..3.0_f64,
    ) {
        let mut threshold = 0.0;
        let (thresholds, weights) = plays
            .iter()
            .map(|(gap, w)| {
                threshold += gap;
                (threshold, *w)
            })
            .unzip();
        let model = PrandtlIshlinskii::new(polynomial, thresholds, weights).unwrap();
        let v = simulate(&model, &history, Start::Rest { voltage_v: rest });
        for (k, v) in v.iter().enumerate() {
            let want = masing(&model, rest, &history[..=k]);
            // Sums of some 40 × 10 terms of up to 20 µm beside a polynomial of up to 260 µm.
            prop_assert!((v - want).abs() < 2e-12, "{v} {want}");
        }
    }
}
