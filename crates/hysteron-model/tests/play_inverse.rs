//! Promise: the inverses of the Prandtl–Ishlinskii block undo it from both sides, and are refused where there
//! is none.
#![allow(clippy::unwrap_used)] // Helpers outside the test functions; a failure is a failed test.

use hysteron_model::Start;
use hysteron_model::hysteresis::{DriveLimits, Hysteresis, HysteresisError, PrandtlIshlinskii};
use proptest::collection::vec;
use proptest::prelude::*;

/// Voltages of the tests, and the range asked of the inverse \[V\].
const RANGE: [f64; 2] = [-10.0, 10.0];

/// 1e-12 of the range \[V\].
const TOLERANCE: f64 = 2e-11;

/// Thresholds, and weights with partial slopes p₀ + w₁ + … of at least p₀ + `least`.
fn plays(least: f64) -> impl Strategy<Value = (Vec<f64>, Vec<f64>)> {
    vec((0.05..1.5_f64, least..2.0_f64), 0..12).prop_map(|plays| {
        let (mut threshold, mut slope) = (0.0, 0.0);
        plays
            .into_iter()
            .map(|(gap, next)| {
                threshold += gap;
                let weight = next - slope;
                slope = next;
                (threshold, weight)
            })
            .unzip()
    })
}

fn linear() -> impl Strategy<Value = PrandtlIshlinskii> {
    (0.3..2.0_f64, plays(-0.2)).prop_map(|(p, (r, w))| PrandtlIshlinskii::new(vec![p], r, w).unwrap())
}

/// Degree 3, l' ≥ 0.8 − 0.4 − 0.15 within the range, least partial sum −0.2.
fn cubic() -> impl Strategy<Value = PrandtlIshlinskii> {
    (0.8..2.0_f64, -0.02..0.02_f64, -0.0005..0.0005_f64, plays(-0.2))
        .prop_map(|(a, b, c, (r, w))| PrandtlIshlinskii::new(vec![a, b, c], r, w).unwrap())
}

fn drive() -> impl Strategy<Value = Vec<f64>> {
    vec(prop_oneof![RANGE[0]..RANGE[1], Just(RANGE[0]), Just(RANGE[1])], 1..40)
}

/// Output, and the plays at its end.
fn simulate(model: &PrandtlIshlinskii, u: &[f64], start: Start<f64>) -> (Vec<f64>, Vec<f64>) {
    let (mut v, mut plays) = (vec![0.0; u.len()], vec![0.0; model.weights.len()]);
    model.simulate(u, start, &mut plays, &mut v).unwrap();
    (v, plays)
}

fn close(a: &[f64], b: &[f64], tolerance: f64) -> Result<(), TestCaseError> {
    prop_assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(b) {
        prop_assert!((a - b).abs() <= tolerance, "{a} {b}");
    }
    Ok(())
}

#[test]
fn closed_form_by_hand() {
    // Slopes 1, 2, 4; φ(1) = 1, φ(3) = 5.
    let model = PrandtlIshlinskii::new(vec![1.0], vec![1.0, 3.0], vec![1.0, 2.0]).unwrap();
    let inverse = model.inverse().unwrap();
    assert_eq!(inverse, PrandtlIshlinskii::new(vec![1.0], vec![1.0, 5.0], vec![-0.5, -0.25]).unwrap());
    assert_eq!(model.loading_curve(4.0), 9.0);
    assert_eq!(inverse.loading_curve(9.0), 4.0);
    let mut plays = [0.0; 2];
    model.inverse_plays(&[3.0, 1.0], &mut plays).unwrap();
    assert_eq!(plays, [2.0 * 3.0 + 2.0, 4.0]);
}

#[test]
fn where_there_is_no_inverse_it_is_refused() {
    let new = |p: &[f64], w: &[f64]| PrandtlIshlinskii::new(p.to_vec(), vec![1.0, 2.0], w.to_vec()).unwrap();
    let refused = |p: &[f64], w: &[f64]| new(p, w).inverse().unwrap_err();
    assert_eq!(refused(&[0.0], &[1.0, 1.0]), HysteresisError::PartialSlope { plays: 0, slope: 0.0 });
    assert_eq!(refused(&[1.0], &[-1.5, 2.0]), HysteresisError::PartialSlope { plays: 1, slope: -0.5 });
    assert_eq!(refused(&[1.0], &[1.0, -2.0]), HysteresisError::PartialSlope { plays: 2, slope: 0.0 });
    assert_eq!(refused(&[1.0, 0.0, 0.1, 0.0], &[1.0, 1.0]), HysteresisError::NotLinear { degree: 3 });
    assert!(new(&[1.0, 0.0], &[1.0, 1.0]).inverse().is_ok());
    let wrong = HysteresisError::PlayStates { expected: 2, found: 1 };
    assert_eq!(new(&[1.0], &[1.0, 1.0]).inverse_plays(&[0.0; 2], &mut [0.0]), Err(wrong.clone()));
    assert_eq!(new(&[1.0], &[1.0, 1.0]).inverse_plays(&[0.0], &mut [0.0; 2]), Err(wrong));

    // l' = 1 − 0.2 u vanishes at 5 V; with a weight of −0.5 a branch turns down from 2.5 V on.
    let bent = new(&[1.0, -0.1], &[1.0, 1.0]);
    assert!(bent.step_inverse([-3.0, 4.9]).is_ok());
    assert_eq!(bent.step_inverse([-3.0, 5.0]).unwrap_err(), HysteresisError::NotSteep { u: 5.0, slope: 0.0 });
    let loose = new(&[1.0, -0.1], &[-0.5, 1.0]);
    assert!(loose.step_inverse([-3.0, 2.4]).is_ok());
    assert!(matches!(loose.step_inverse([-3.0, 2.6]), Err(HysteresisError::NotSteep { u: 2.6, .. })));
    for [low, high] in [[1.0, 1.0], [f64::NEG_INFINITY, 1.0]] {
        assert_eq!(bent.step_inverse([low, high]).unwrap_err(), HysteresisError::Range { low, high });
    }
    assert!(matches!(bent.step_inverse([0.0, f64::NAN]), Err(HysteresisError::Range { .. })));
}

#[test]
fn outputs_out_of_reach_are_refused_with_what_can_be_reached() {
    // From rest u − 0.1 u² + 2 max(u − 1, 0): 0 µm at 0 V, 6.1 µm at 3 V.
    let model = PrandtlIshlinskii::new(vec![1.0, -0.1], vec![1.0], vec![2.0]).unwrap();
    let inverse = model.step_inverse([0.0, 3.0]).unwrap();
    assert!((inverse.solve(&[0.0], 6.1).unwrap() - 3.0).abs() < 1e-15);
    match inverse.solve(&[0.0], 6.2).unwrap_err() {
        HysteresisError::OutOfReach { index: 0, v, from, to } => {
            assert!(v == 6.2 && from == 0.0 && (to - 6.1).abs() < 1e-15, "{from} {to}");
        }
        other => assert_eq!(other, HysteresisError::Factor),
    }
    assert!(matches!(inverse.solve(&[0.0], -0.1), Err(HysteresisError::OutOfReach { .. })));
    let (mut plays, mut u) = ([0.0], [0.0; 3]);
    let error = inverse.follow(&[1.0, 6.0, 7.0], &mut plays, &mut u).unwrap_err();
    assert!(matches!(error, HysteresisError::OutOfReach { index: 2, .. }), "{error}");
    assert_eq!(plays, [u[1] - 1.0]);
    assert_eq!(inverse.solve(&[0.0], f64::NAN), Err(HysteresisError::Drive { index: 0 }));
    assert_eq!(inverse.solve(&[], 1.0), Err(HysteresisError::PlayStates { expected: 1, found: 0 }));
    assert_eq!(
        inverse.follow(&[1.0], &mut plays, &mut []),
        Err(HysteresisError::Lengths { expected: 1, found: 0 })
    );
    let two = PrandtlIshlinskii::new(vec![1.0], vec![1.0, 2.0], vec![1.0, 1.0]).unwrap();
    assert_eq!(
        two.step_inverse(RANGE).unwrap().solve(&[0.0, 2.0], 1.0),
        Err(HysteresisError::PlayHistory { index: 1 })
    );
}

#[test]
fn a_polynomial_that_turns_beyond_the_range_does_not_matter() {
    // u − 0.1 u² is −120 µm at 40 V, where the second play would take hold.
    let model = PrandtlIshlinskii::new(vec![1.0, -0.1], vec![1.0, 40.0], vec![0.5, 3.0]).unwrap();
    let inverse = model.step_inverse([-4.9, 4.9]).unwrap();
    let u: Vec<f64> = (0..99).map(|k| 0.1 * f64::from(k) - 4.9).collect();
    let (v, _) = simulate(&model, &u, Start::Rest { voltage_v: 0.0 });
    let mut back = vec![0.0; 99];
    inverse.follow(&v, &mut [0.0; 2], &mut back).unwrap();
    assert!(u.iter().zip(&back).all(|(a, b)| (a - b).abs() < 1e-12), "{back:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(300) })]

    #[test]
    fn the_closed_form_undoes_the_model_from_both_sides(
        model in linear(),
        u in drive(),
        rest in -10.0..10.0_f64,
    ) {
        let inverse = model.inverse().unwrap();
        let total = model.polynomial[0] + model.weights.iter().sum::<f64>();
        let (v, _) = simulate(&model, &u, Start::Rest { voltage_v: rest });
        close(&simulate(&inverse, &v, Start::Rest { voltage_v: total * rest }).0, &u, TOLERANCE)?;
        let (back, _) = simulate(&inverse, &u, Start::Rest { voltage_v: rest });
        // The drive of the model, up to 10 µm / 0.1 µm/V, is this side's intermediate result.
        close(&simulate(&model, &back, Start::Rest { voltage_v: rest / total }).0, &u, TOLERANCE)?;
    }

    #[test]
    fn states_of_the_closed_form_correspond(model in linear(), past in drive(), u in drive()) {
        let inverse = model.inverse().unwrap();
        let (v, mut plays) = simulate(&model, &past, Start::Rest { voltage_v: 0.0 });
        let (_, followed) = simulate(&inverse, &v, Start::Rest { voltage_v: 0.0 });
        let mut states = vec![0.0; plays.len()];
        model.inverse_plays(&plays, &mut states).unwrap();
        // The states are in µm, up to some 2 × 10 of them.
        close(&states, &followed, 1e-11)?;
        let mut v = vec![0.0; u.len()];
        model.resume(&u, &mut plays, &mut v).unwrap();
        let mut back = vec![0.0; u.len()];
        inverse.resume(&v, &mut states, &mut back).unwrap();
        close(&back, &u, TOLERANCE)?;
    }

    #[test]
    fn the_inverse_of_the_inverse_is_the_model(model in linear(), u in -20.0..20.0_f64) {
        let inverse = model.inverse().unwrap();
        let back = inverse.inverse().unwrap();
        for (a, b) in [
            (&model.polynomial, &back.polynomial),
            (&model.thresholds, &back.thresholds),
            (&model.weights, &back.weights),
        ] {
            close(a, b, 1e-11)?;
        }
        close(&[inverse.loading_curve(model.loading_curve(u))], &[u], TOLERANCE)?;
    }

    #[test]
    fn moves_are_undone_for_any_degree(
        model in prop_oneof![linear(), cubic()], u in drive(), rest in -10.0..10.0_f64,
    ) {
        let inverse = model.step_inverse(RANGE).unwrap();
        let (v, after) = simulate(&model, &u, Start::Rest { voltage_v: rest });
        let (mut plays, mut back) = (vec![rest; after.len()], vec![0.0; u.len()]);
        inverse.follow(&v, &mut plays, &mut back).unwrap();
        close(&back, &u, TOLERANCE)?;
        close(&plays, &after, TOLERANCE)?;
        // The other side: outputs asked for, and the model driven by the answer.
        close(&simulate(&model, &back, Start::Rest { voltage_v: rest }).0, &v, 1e-12 * 20.0)?;
    }

    #[test]
    fn the_two_inverses_agree(model in linear(), u in drive()) {
        let (v, _) = simulate(&model, &u, Start::Rest { voltage_v: 0.0 });
        let (mut plays, mut back) = (vec![0.0; model.weights.len()], vec![0.0; u.len()]);
        model.step_inverse(RANGE).unwrap().follow(&v, &mut plays, &mut back).unwrap();
        close(&back, &simulate(&model.inverse().unwrap(), &v, Start::Rest { voltage_v: 0.0 }).0, TOLERANCE)?;
    }

    #[test]
    fn a_move_is_where_bisection_of_the_model_finds_it(
        model in cubic(), history in drive(), share in 0.0..1.0_f64,
    ) {
        let (_, plays) = simulate(&model, &history, Start::Rest { voltage_v: 0.0 });
        let moved = |u: f64| {
            let mut v = [0.0];
            model.resume(&[u], &mut plays.clone(), &mut v).unwrap();
            v[0]
        };
        let [mut low, mut high] = RANGE;
        let v = moved(low) + share * (moved(high) - moved(low));
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if moved(middle) < v { low = middle } else { high = middle }
        }
        let u = model.step_inverse(RANGE).unwrap().solve(&plays, v).unwrap();
        prop_assert!((u - low).abs() <= TOLERANCE, "{u} {low}");
    }
}

#[test]
fn plays_follow_as_their_closed_form_does() {
    let plays = PrandtlIshlinskii::new(vec![1.0, 0.02], vec![0.31, 0.9, 1.7, 3.3], vec![0.3, 0.2, -0.1, 0.1])
        .unwrap();
    let limits = DriveLimits { range: [-2.0, 10.0], step: f64::INFINITY, interval_s: None };
    let wanted: Vec<f64> = (0..500).map(|k| 6.0 + 4.0 * (f64::from(k) * 0.31).sin()).collect();
    let mut states = vec![2.0; plays.thresholds.len()];
    let mut exact = vec![0.0; wanted.len()];
    plays.step_inverse(limits.range).unwrap().follow(&wanted, &mut states, &mut exact).unwrap();
    let found = Hysteresis::from(plays).follow(&wanted, 2.0, None, &limits).unwrap();
    for (found, exact) in found.drive.iter().zip(&exact) {
        assert!((found - exact).abs() < 1e-12, "{found} {exact}");
    }
}
