//! Promise: a bank of plays moves as its definition says, and the inverse of a move is exact.

#![allow(clippy::unwrap_used)] // Helpers outside the test functions; a failure is a failed test.

use hysteron_rt::{ParameterError, PlayBank, PlayError, play};
use proptest::prelude::*;

/// Thresholds (V) from positive gaps, and weights (µm/V) whose partial sums stay above −0.9.
fn bank() -> impl Strategy<Value = (Vec<f64>, Vec<f64>)> {
    prop::collection::vec((0.05..2.0_f64, -0.9..2.0_f64), 0..12).prop_map(|plays| {
        let (mut threshold, mut slope) = (0.0, 0.0);
        plays
            .into_iter()
            .map(|(gap, next_slope)| {
                threshold += gap;
                let weight = next_slope - slope;
                slope = next_slope;
                (threshold, weight)
            })
            .unzip()
    })
}

/// States after a history from 0, by the definition with `f64::max` and `f64::min`.
fn after(thresholds: &[f64], history: &[f64]) -> Vec<f64> {
    let follow = |r: &f64| history.iter().fold(0.0, |w: f64, u| (u - r).max(w.min(u + r)));
    thresholds.iter().map(follow).collect()
}

/// p0 u + Σ wᵢ F_rᵢ after one move.
fn moved((thresholds, weights): (&[f64], &[f64]), p0: f64, states: &[f64], u: f64) -> f64 {
    let plays = thresholds.iter().zip(weights).zip(states);
    p0 * u + plays.map(|((r, w), f)| w * (u - r).max(f.min(u + r))).sum::<f64>()
}

#[test]
fn one_play_by_hand() {
    // Half-width 1: nothing up to 1, then one behind; on the way back nothing for 2.
    let path = [(0.5, 0.0), (3.0, 2.0), (2.0, 2.0), (1.0, 2.0), (0.0, 1.0), (-4.0, -3.0), (-2.5, -3.0)];
    let mut state = 0.0;
    for (u, want) in path {
        state = play(1.0, state, u);
        assert_eq!(state, want);
    }
    assert_eq!(play(0.0, 7.0, 3.0), 3.0);
}

#[test]
fn two_plays_and_their_inverse_by_hand() {
    // Virgin, 1·u + 2 F₁ + 3 F₂: slope 1 up to u = 1, 3 up to u = 2, then 6.
    let bank = PlayBank::new(&[1.0, 2.0], &[2.0, 3.0]).unwrap();
    for (v, u) in [(0.5, 0.5), (1.0, 1.0), (2.5, 1.5), (4.0, 2.0), (10.0, 3.0), (-0.5, -0.5), (-10.0, -3.0)] {
        assert_eq!(bank.inverse(1.0, &[0.0, 0.0], v).unwrap(), u);
    }
    let mut states = [0.0, 0.0];
    assert_eq!(bank.step(&mut states, 3.0).unwrap(), 7.0);
    assert_eq!(states, [2.0, 1.0]);
    // From there down: slope 1 to u = 1, 3 to u = −1, then 6.
    for (v, u) in [(9.0, 2.0), (8.0, 1.0), (5.0, 0.0), (2.0, -1.0), (-4.0, -2.0), (16.0, 4.0)] {
        assert_eq!(bank.inverse(1.0, &states, v).unwrap(), u);
    }
}

#[test]
fn an_empty_bank_is_a_straight_line() {
    let bank = PlayBank::<f32>::new(&[], &[]).unwrap();
    assert_eq!(bank.step(&mut [], 3.0), Ok(0.0));
    assert_eq!(bank.inverse(2.0, &[], 3.0), Ok(1.5));
}

#[test]
fn what_cannot_be_is_refused_with_its_numbers() {
    let new = |r: &'static [f64], w: &'static [f64]| PlayBank::new(r, w).unwrap_err();
    assert_eq!(new(&[1.0], &[]), ParameterError::Lengths { thresholds: 1, weights: 0 });
    assert_eq!(new(&[0.0], &[1.0]), ParameterError::Threshold { index: 0, value: 0.0, above: 0.0 });
    assert_eq!(new(&[1.0, 1.0], &[1.0, 1.0]), ParameterError::Threshold { index: 1, value: 1.0, above: 1.0 });
    assert!(matches!(new(&[f64::NAN], &[1.0]), ParameterError::Threshold { index: 0, .. }));
    assert!(matches!(new(&[1.0], &[f64::INFINITY]), ParameterError::Weight { index: 0, .. }));

    let bank = PlayBank::new(&[1.0, 2.0], &[-0.5, 2.0]).unwrap();
    assert_eq!(bank.step(&mut [0.0], 1.0), Err(PlayError::Lengths { expected: 2, found: 1 }));
    let mut states = [0.5, 0.25];
    assert_eq!(bank.step(&mut states, f64::NAN), Err(PlayError::NotFinite));
    assert_eq!(states, [0.5, 0.25]);
    assert_eq!(bank.step(&mut [f64::NAN, 0.0], 1.0), Err(PlayError::NotFinite));
    assert_eq!(bank.step(&mut states, 1.5e308), Err(PlayError::Overflow));
    assert_eq!(states, [0.5, 0.25]);

    assert_eq!(bank.inverse(0.5, &[0.0, 0.0], 1.0), Err(PlayError::Slope { least: 0.0 }));
    assert!(matches!(bank.inverse(f64::NAN, &[0.0, 0.0], 1.0), Err(PlayError::Slope { .. })));
    assert!(bank.inverse(0.6, &[0.0, 0.0], 1.0).is_ok());
    assert_eq!(bank.inverse(1.0, &[0.0, 1.1], 1.0), Err(PlayError::History { index: 1 }));
    assert_eq!(bank.inverse(1.0, &[0.0, 0.0], f64::INFINITY), Err(PlayError::NotFinite));
    assert_eq!(bank.inverse(1.0, &[f64::NAN, 0.0], 1.0), Err(PlayError::NotFinite));
    assert_eq!(bank.inverse(1.0, &[0.0], 1.0), Err(PlayError::Lengths { expected: 2, found: 1 }));
    let tiny = PlayBank::<f64>::new(&[], &[]).unwrap();
    assert_eq!(tiny.inverse(1e-300, &[], 1e300), Err(PlayError::Overflow));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

    #[test]
    fn the_step_is_the_definition(
        (r, w) in bank(), history in prop::collection::vec(-20.0..20.0_f64, 1..30),
    ) {
        let bank = PlayBank::new(&r, &w).unwrap();
        let mut states = vec![0.0; r.len()];
        for end in 1..=history.len() {
            let sum = bank.step(&mut states, history[end - 1]).unwrap();
            let want = after(&r, &history[..end]);
            prop_assert_eq!(&states, &want);
            prop_assert_eq!(sum, w.iter().zip(&want).fold(0.0, |sum, (w, f)| sum + w * f));
        }
    }

    #[test]
    fn the_inverse_undoes_any_move(
        (r, w) in bank(), history in prop::collection::vec(-20.0..20.0_f64, 0..30), u in -25.0..25.0_f64,
    ) {
        let bank = PlayBank::new(&r, &w).unwrap();
        let states = after(&r, &history);
        let v = moved((&r, &w), 1.0, &states, u);
        let back = bank.inverse(1.0, &states, v).unwrap();
        // Partial slopes are at least 0.1; voltages up to 25 V, slopes up to 3, sums of up to 13 terms.
        prop_assert!((back - u).abs() < 2e-12, "{back} for {u}");
        prop_assert!((moved((&r, &w), 1.0, &states, back) - v).abs() < 5e-13);
    }

    #[test]
    fn the_inverse_is_what_bisection_finds(
        (r, w) in bank(), history in prop::collection::vec(-20.0..20.0_f64, 0..30), v in -60.0..60.0_f64,
    ) {
        let states = after(&r, &history);
        let (mut low, mut high) = (-1e4, 1e4);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if moved((&r, &w), 1.0, &states, middle) < v { low = middle } else { high = middle }
        }
        let u = PlayBank::new(&r, &w).unwrap().inverse(1.0, &states, v).unwrap();
        prop_assert!((u - low).abs() <= 1e-12 * (100.0 + low.abs()), "{u} {low}");
    }

    #[test]
    fn single_precision_agrees_to_its_rounding(
        (r, w) in bank(), history in prop::collection::vec(-20.0..20.0_f64, 1..30),
    ) {
        let narrow = |x: &[f64]| x.iter().map(|&x| x as f32).collect::<Vec<f32>>();
        let (r32, w32) = (narrow(&r), narrow(&w));
        // Thresholds closer than single precision can tell apart cannot occur: gaps are at least 0.05.
        let (wide, single) = (PlayBank::new(&r, &w).unwrap(), PlayBank::new(&r32, &w32).unwrap());
        let (mut states, mut states32) = (vec![0.0; r.len()], vec![0.0_f32; r.len()]);
        for &u in &history {
            let sum = wide.step(&mut states, u).unwrap();
            let sum32 = single.step(&mut states32, u as f32).unwrap();
            prop_assert!((sum - f64::from(sum32)).abs() < 2e-4, "{sum} {sum32}");
            let back = single.inverse(1.0, &states32, u as f32 + sum32).unwrap();
            prop_assert!((back - u as f32).abs() < 2e-3, "{back} {u}");
        }
    }

    #[test]
    fn any_numbers_give_a_finite_result_or_an_error(
        r in prop::collection::vec(prop::num::f64::ANY, 0..5),
        w in prop::collection::vec(prop::num::f64::ANY, 0..5),
        f in prop::collection::vec(prop::num::f64::ANY, 0..5),
        u in prop::num::f64::ANY,
        p0 in prop::num::f64::ANY,
    ) {
        let mut r: Vec<f64> = r.iter().map(|r| r.abs()).collect();
        r.sort_by(f64::total_cmp);
        let count = r.len().min(w.len()).min(f.len());
        if let Ok(bank) = PlayBank::new(&r[..count], &w[..count]) {
            let mut states = f[..count].to_vec();
            if let Ok(sum) = bank.step(&mut states, u) {
                prop_assert!(sum.is_finite() && states.iter().all(|f| f.is_finite()));
            }
            if let Ok(u) = bank.inverse(p0, &f[..count], u) {
                prop_assert!(u.is_finite());
            }
        }
    }
}
