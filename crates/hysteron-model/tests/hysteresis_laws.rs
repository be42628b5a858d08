//! Laws of the Bouc–Wen block that hold for every parameter set of the bounded class.
//!
//! Wiping-out (a larger excursion erases the memory of smaller ones, minor loops close) is *not* among them:
//! Bouc–Wen violates it. What does hold is fading memory: any two histories approach each other under a
//! common drive.
#![allow(clippy::unwrap_used)] // Helpers outside the test functions; a failure is a failed test.

use hysteron_model::Start;
use hysteron_model::hysteresis::BoucWen;
use proptest::prelude::*;

fn bounded_model() -> impl Strategy<Value = BoucWen> {
    let n = prop_oneof![Just(1.0), Just(2.0), 1.0..5.0_f64];
    (-2.0..2.0_f64, 0.01..0.6_f64, -0.99..0.99_f64, n)
        .prop_map(|(alpha, beta, share, n)| BoucWen::new(vec![0.0], alpha, beta, beta * share, n).unwrap())
}

fn simulate(model: &BoucWen, u: &[f64], start: Start<f64>) -> Vec<f64> {
    let mut v = vec![0.0; u.len()];
    model.simulate(u, start, &mut v).unwrap();
    v
}

#[test]
fn minor_loops_do_not_close() {
    let model = BoucWen::new(vec![1.0], 0.7, 0.2, 0.1, 1.0).unwrap();
    let v = simulate(&model, &[10.0, 5.0, 10.0], Start::Rest { voltage_v: 0.0 });
    assert!((v[2] - v[0]).abs() > 0.1, "{v:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(200) })]

    #[test]
    fn only_the_turning_points_count(
        model in bounded_model(),
        turns in prop::collection::vec(-6.0..6.0_f64, 1..12),
        between in 1..20_usize,
    ) {
        let direct = simulate(&model, &turns, Start::Rest { voltage_v: 0.0 });
        let mut dense = Vec::new();
        let mut last = 0.0;
        for &turn in &turns {
            dense.extend((1..between).map(|k| last + (turn - last) * k as f64 / between as f64));
            dense.push(turn);
            last = turn;
        }
        let v = simulate(&model, &dense, Start::Rest { voltage_v: 0.0 });
        for (a, b) in direct.iter().zip(v.iter().skip(between - 1).step_by(between)) {
            prop_assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
        let mut every = vec![0.0; turns.len()];
        let shifted: Vec<f64> = turns.iter().take(1).chain(dense.iter().skip(between)).copied().collect();
        model.simulate_every(between, &shifted, Start::Rest { voltage_v: 0.0 }, &mut every).unwrap();
        for (a, b) in direct.iter().zip(&every) {
            prop_assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
    }

    #[test]
    fn periodic_start_closes_the_loop(
        model in bounded_model(), u in prop::collection::vec(-6.0..6.0_f64, 2..40),
    ) {
        let mut first = vec![0.0; u.len()];
        let end = model.simulate(&u, Start::PERIODIC, &mut first).unwrap();
        let second = simulate(&model, &u, Start::from(end));
        for (a, b) in first.iter().zip(&second) {
            prop_assert!((a - b).abs() <= 1e-11, "{a} {b}");
        }
    }

    #[test]
    fn histories_fade(
        model in bounded_model(), u in prop::collection::vec(-6.0..6.0_f64, 1..40), z in -3.0..3.0_f64,
        gap in 0.0..2.0_f64,
    ) {
        let a = simulate(&model, &u, Start::Remembering { voltage_v: 0.0, memory: z });
        let b = simulate(&model, &u, Start::Remembering { voltage_v: 0.0, memory: z + gap });
        let mut last = gap;
        for (a, b) in a.iter().zip(&b) {
            // The states keep their order (v = −z here) and their distance never grows.
            prop_assert!(a - b >= -1e-13 && a - b <= last + 1e-13, "{} after {last}", a - b);
            last = a - b;
        }
    }

    #[test]
    fn reversing_drive_and_state_reverses_the_output(
        model in bounded_model(), u in prop::collection::vec(-6.0..6.0_f64, 1..40),
    ) {
        let mirrored: Vec<f64> = u.iter().map(|u| -u).collect();
        let a = simulate(&model, &u, Start::Rest { voltage_v: 0.0 });
        let b = simulate(&model, &mirrored, Start::Rest { voltage_v: 0.0 });
        for (a, b) in a.iter().zip(&b) {
            prop_assert_eq!(*a, -*b);
        }
    }

    #[test]
    fn the_bound_of_the_verdict_holds(
        model in bounded_model(), u in prop::collection::vec(-100.0..100.0_f64, 1..40),
    ) {
        let hysteron_model::hysteresis::Admissibility::Bounded { saturation_v } = model.admissibility() else {
            return Err(TestCaseError::fail("not in the bounded class"));
        };
        for v in simulate(&model, &u, Start::Rest { voltage_v: 0.0 }) {
            prop_assert!(v.abs() <= model.alpha.abs() * saturation_v * (1.0 + 1e-12));
        }
    }

    #[test]
    fn any_finite_input_gives_finite_output_or_an_error(
        p in prop::array::uniform3(prop::num::f64::NORMAL | prop::num::f64::ZERO),
        n in prop_oneof![Just(1.0), Just(2.0), 1.0..30.0_f64],
        u in prop::collection::vec(prop::num::f64::NORMAL | prop::num::f64::ZERO, 0..8),
        periodic in any::<bool>(),
    ) {
        let model = BoucWen::new(vec![0.0], p[0], p[1], p[2], n).unwrap();
        let start = if periodic { Start::PERIODIC } else { Start::Rest { voltage_v: 0.0 } };
        let mut v = vec![0.0; u.len()];
        if model.simulate(&u, start, &mut v).is_ok() {
            prop_assert!(v.iter().all(|v| v.is_finite()), "{v:?}");
        }
    }
}
