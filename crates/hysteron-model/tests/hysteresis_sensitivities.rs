//! The derivatives of the Bouc–Wen operator against sixth-order central differences of its simulation.
#![allow(clippy::unwrap_used)] // Helpers outside the test functions; a failure is a failed test.

use hysteron_model::Start;
use hysteron_model::hysteresis::{BoucWenState, HysteresisError, Sensitivities, UnitShape};
use hysteron_rt::Dual;
use proptest::prelude::*;

/// Step of the differences where ζ is some 1 V: their truncation is some (10 V · H)⁶, their rounding some
/// ε/H.
const H: f64 = 1e-3;

/// The sixth-order central difference quotient of a vector, with step `h`.
fn difference(h: f64, f: impl Fn(f64) -> Vec<f64>) -> Vec<f64> {
    let weights = [(1.0, 45.0), (2.0, -9.0), (3.0, 1.0)];
    let mut sum = vec![0.0; f(0.0).len()];
    for (step, weight) in weights {
        for ((sum, plus), minus) in sum.iter_mut().zip(f(step * h)).zip(f(-step * h)) {
            *sum += weight * (plus - minus) / (60.0 * h);
        }
    }
    sum
}

fn zeta([beta, gamma, n]: [f64; 3], u: &[f64], start: Start<f64>) -> Vec<f64> {
    let mut out = vec![0.0; u.len()];
    UnitShape { beta, gamma, n }.simulate_every(1, u, start, &mut out).unwrap();
    out
}

fn sensitivities([beta, gamma, n]: [f64; 3], u: &[f64], start: Start<f64>, exponent: bool) -> Sensitivities {
    let mut out = Sensitivities::default();
    UnitShape { beta, gamma, n }.simulate_with_sensitivities(1, u, start, exponent, &mut out).unwrap();
    out
}

/// How far off ζ may be. A steady state is taken as settled where a period changes ζ by 1e-13 of its size,
/// and what is left then grows to 1/(1 − m) of that, m = ∂ζ_end/∂ζ(0): a weak loop forgets slowly.
fn inaccuracy(shape: [f64; 3], u: &[f64], start: Start<f64>, zeta: &[f64]) -> f64 {
    let size = zeta.iter().fold(0.0_f64, |m, z| m.max(z.abs()));
    if start != Start::PERIODIC {
        return 2.0 * f64::EPSILON * size;
    }
    let last = u.len() - 1;
    let settled = Start::Remembering { voltage_v: u[last], memory: zeta[last] };
    1e-13 * size / (1.0 - sensitivities(shape, u, settled, false).d_start[last])
}

/// Every derivative within 1e-9 of the largest of its kind, and what the inaccuracy of ζ makes of the
/// differences.
///
/// Samples at which ζ changes sign within reach of the differences are left out: the second derivative jumps
/// there. False where that happens at a turning point, from which it would spread.
fn meets_differences(shape: [f64; 3], u: &[f64], start: Start<f64>) -> Result<bool, TestCaseError> {
    let got = sensitivities(shape, u, start, true);
    let [beta, gamma, n] = shape;
    // β' and γ' are multiplied by |ζ|ⁿ⁻¹.
    let largest = got.zeta.iter().fold(1.0_f64, |m, z| m.max(z.abs()));
    let h = H / largest.powf(n - 1.0);
    let mut columns = vec![
        ("beta", h, &got.d_beta, difference(h, |h| zeta([beta + h, gamma, n], u, start))),
        ("gamma", h, &got.d_gamma, difference(h, |h| zeta([beta, gamma + h, n], u, start))),
    ];
    if n - 3.0 * H >= 1.0 {
        columns.push(("n", H, &got.d_n, difference(H, |h| zeta([beta, gamma, n + h], u, start))));
    }
    if let Start::Remembering { voltage_v: u_start, memory: z } = start {
        let from = |h| zeta(shape, u, Start::Remembering { voltage_v: u_start, memory: z + h });
        columns.push(("start", H, &got.d_start, difference(H, from)));
    }
    let smooth: Vec<bool> = (0..u.len())
        .map(|k| {
            let reach =
                columns.iter().fold(0.0_f64, |reach, (_, h, column, _)| reach.max(h * column[k].abs()));
            got.zeta[k].abs() > 8.0 * reach
        })
        .collect();
    let turns = |k: usize| k == 0 || k + 1 == u.len() || (u[k] - u[k - 1]) * (u[k + 1] - u[k]) <= 0.0;
    if (0..u.len()).any(|k| turns(k) && !smooth[k]) {
        return Ok(false);
    }
    let inaccuracy = inaccuracy(shape, u, start, &got.zeta);
    for (name, h, got, want) in columns {
        let size = want.iter().fold(0.0_f64, |m, w| m.max(w.abs()));
        for (k, (got, want)) in got.iter().zip(&want).enumerate().filter(|(k, _)| smooth[*k]) {
            prop_assert!(
                (got - want).abs() <= 1e-9 * size + 2.0 * inaccuracy / h,
                "{name}, sample {k}: {got:e} {want:e} of {size:e}"
            );
        }
    }
    Ok(true)
}

/// β', γ' of the bounded class, with n.
fn shape() -> impl Strategy<Value = [f64; 3]> {
    let n = prop_oneof![Just(1.0), Just(1.5), Just(2.0), Just(3.0)];
    (0.05..0.5_f64, -0.95..0.95_f64, n).prop_map(|(beta, share, n)| [beta, beta * share, n])
}

/// A drive through random turning points with `between` samples from each to the next.
fn drive() -> impl Strategy<Value = Vec<f64>> {
    let turns = prop::collection::vec(0.5..5.0_f64, 2..8);
    (turns, 1..9_usize, any::<bool>()).prop_map(|(turns, between, down)| {
        let mut u = Vec::new();
        let (mut last, mut side) = (0.0, if down { -1.0 } else { 1.0 });
        for turn in turns {
            let next = side * turn;
            u.extend((1..=between).map(|k| last + (next - last) * k as f64 / between as f64));
            (last, side) = (next, -side);
        }
        u
    })
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None, max_global_rejects: 4000, ..ProptestConfig::with_cases(150)
    })]

    #[test]
    fn from_a_state(shape in shape(), u in drive(), z in -1.5..1.5_f64, offset in -1.0..1.0_f64) {
        prop_assume!(z.abs() > 8.0 * H);
        let start = Start::Remembering { voltage_v: u[0] + offset, memory: z };
        prop_assume!(meets_differences(shape, &u, start)?);
    }

    #[test]
    fn from_rest(shape in shape(), u in drive(), offset in 0.5..1.0_f64) {
        prop_assume!(meets_differences(shape, &u, Start::Rest { voltage_v: -offset })?);
    }

    #[test]
    fn of_a_steady_state(shape in shape(), u in drive()) {
        // An even number of turning points closes the period without a turn between two samples' ends.
        prop_assume!(u[0] * u[u.len() - 1] < 0.0);
        let got = sensitivities(shape, &u, Start::PERIODIC, false);
        prop_assert!(got.d_start.iter().all(|d| *d == 0.0));
        prop_assume!(meets_differences(shape, &u, Start::PERIODIC)?);
    }

    /// A loop so weak that the differences are all rounding where the derivative by n is smallest.
    #[test]
    fn of_the_steady_state_of_a_weak_loop(share in -0.95..0.95_f64) {
        prop_assert!(meets_differences([0.05, 0.05 * share, 1.5], &[0.5, -0.5], Start::PERIODIC)?);
    }

    #[test]
    fn one_pass_is_the_step_repeated(
        shape in shape(),
        u in drive(),
        z in -1.5..1.5_f64,
        exponent in any::<bool>(),
    ) {
        let [beta, gamma, n] = shape;
        let operator = hysteron_rt::BoucWen::unit(beta, gamma, n).unwrap();
        let got = sensitivities(shape, &u, Start::Remembering { voltage_v: 0.2, memory: z }, exponent);
        let (mut last, mut with_n, mut without) =
            (0.2, Dual::<_, 4>::variable(z, 3), Dual::<_, 3>::variable(z, 2));
        for (k, &next) in u.iter().enumerate() {
            with_n = operator.advance_with_sensitivities(with_n, next - last).unwrap();
            without = operator.advance_with_shape(without, next - last).unwrap();
            last = next;
            let want = if exponent {
                [with_n.value, with_n.partials[0], with_n.partials[1], with_n.partials[3]]
            } else {
                [without.value, without.partials[0], without.partials[1], without.partials[2]]
            };
            for (got, want) in [got.zeta[k], got.d_beta[k], got.d_gamma[k], got.d_start[k]].iter().zip(want) {
                prop_assert!((got - want).abs() <= 1e-13 * (1.0 + want.abs()), "{got:e} {want:e}");
            }
            if exponent {
                prop_assert_eq!(got.d_n[k], with_n.partials[2]);
            }
        }
        if !exponent {
            let plain = zeta(shape, &u, Start::Remembering { voltage_v: 0.2, memory: z });
            if n == 1.0 {
                prop_assert_eq!(&got.zeta, &plain);
            }
            for (got, plain) in got.zeta.iter().zip(&plain) {
                prop_assert!((got - plain).abs() <= 1e-13 * (1.0 + plain.abs()), "{got:e} {plain:e}");
            }
            prop_assert!(got.d_n.is_empty());
        }
    }

    #[test]
    fn the_closed_forms_are_the_series(shape in shape(), u in drive(), z in -1.5..1.5_f64) {
        let start = Start::Remembering { voltage_v: 0.2, memory: z };
        let closed = sensitivities(shape, &u, start, false);
        let series = sensitivities(shape, &u, start, true);
        for (a, b) in [
            (&closed.zeta, &series.zeta),
            (&closed.d_beta, &series.d_beta),
            (&closed.d_gamma, &series.d_gamma),
            (&closed.d_start, &series.d_start),
        ] {
            for (a, b) in a.iter().zip(b) {
                prop_assert!((a - b).abs() <= 1e-12 * (1.0 + b.abs()), "{a:e} {b:e}");
            }
        }
    }

    #[test]
    fn a_finer_time_base_is_picked_from(
        shape in shape(),
        u in drive(),
        factor in 1..6_usize,
        periodic in any::<bool>(),
    ) {
        let [beta, gamma, n] = shape;
        let start = if periodic { Start::PERIODIC } else { Start::Rest { voltage_v: 0.1 } };
        let all = sensitivities(shape, &u, start, true);
        let mut out = Sensitivities::default();
        let end = UnitShape { beta, gamma, n }
            .simulate_with_sensitivities(factor, &u, start, true, &mut out)
            .unwrap();
        let pick = |column: &[f64]| column.iter().copied().step_by(factor).collect::<Vec<_>>();
        // A periodic start is settled to 1e-13 of the largest ζ among the samples kept.
        let tolerance = if periodic { 1e-10 } else { 0.0 };
        for (got, all) in [
            (&out.zeta, &all.zeta),
            (&out.d_beta, &all.d_beta),
            (&out.d_gamma, &all.d_gamma),
            (&out.d_n, &all.d_n),
            (&out.d_start, &all.d_start),
        ] {
            let want = pick(all);
            prop_assert_eq!(got.len(), want.len());
            for (got, want) in got.iter().zip(want) {
                prop_assert!((got - want).abs() <= tolerance * (1.0 + want.abs()), "{got:e} {want:e}");
            }
        }
        prop_assert!((end.z - all.zeta[u.len() - 1]).abs() <= tolerance);
        prop_assert_eq!(end.u, u[u.len() - 1]);
    }
}

#[test]
fn without_a_shape_the_drive_is_followed() {
    // β' = γ' = 0: ζ = u − u₀ and, from the differential equation, ∂ζ/∂β' = −∫ |dv| ζ, ∂ζ/∂γ' = −∫ dv |ζ|.
    let u = [2.0, -1.0, 3.0];
    let got = sensitivities([0.0, 0.0, 1.0], &u, Start::Rest { voltage_v: 0.0 }, false);
    let want = [("ζ", &got.zeta, [2.0, -1.0, 3.0]), ("β'", &got.d_beta, [-2.0, -3.5, -7.5])];
    for (name, got, want) in want
        .into_iter()
        .chain([("γ'", &got.d_gamma, [-2.0, 0.5, -4.5]), ("ζ(0)", &got.d_start, [1.0, 1.0, 1.0])])
    {
        for (got, want) in got.iter().zip(want) {
            assert!((got - want).abs() <= 1e-14, "{name}: {got} {want}");
        }
    }
}

#[test]
fn rest_is_the_state_with_zeta_0() {
    let u = [0.4, 2.0, -3.0, 1.0];
    for n in [1.0, 1.5, 2.0] {
        let rest = sensitivities([0.3, 0.1, n], &u, Start::Rest { voltage_v: 0.1 }, true);
        let state = Start::Remembering { voltage_v: 0.1, memory: 0.0 };
        assert_eq!(rest, sensitivities([0.3, 0.1, n], &u, state, true));
    }
}

#[test]
fn errors_are_typed_and_buffers_fit_the_drive() {
    let shape = UnitShape { beta: 0.2, gamma: 0.1, n: 1.0 };
    let mut out = Sensitivities { d_n: vec![1.0; 7], ..Sensitivities::default() };
    let rest = Start::Rest { voltage_v: 0.5 };
    let end = shape.simulate_with_sensitivities(3, &[], rest, false, &mut out).unwrap();
    assert_eq!((end, &out), (BoucWenState { u: 0.5, z: 0.0 }, &Sensitivities::default()));
    shape.simulate_with_sensitivities(1, &[], Start::PERIODIC, true, &mut out).unwrap();
    shape.simulate_with_sensitivities(3, &[1.0, 2.0, 3.0, 4.0], rest, true, &mut out).unwrap();
    for column in [&out.zeta, &out.d_beta, &out.d_gamma, &out.d_n, &out.d_start] {
        assert_eq!(column.len(), 2);
    }
    let mut run = |shape: UnitShape, factor, u: &[f64], start| {
        shape.simulate_with_sensitivities(factor, u, start, false, &mut out).unwrap_err()
    };
    assert_eq!(run(shape, 0, &[1.0], rest), HysteresisError::Factor);
    assert_eq!(run(shape, 1, &[1.0, f64::NAN], rest), HysteresisError::Drive { index: 1 });
    assert_eq!(
        run(shape, 1, &[1.0], Start::Rest { voltage_v: f64::INFINITY }),
        HysteresisError::Drive { index: 0 }
    );
    let low = UnitShape { n: 0.5, ..shape };
    assert_eq!(run(low, 1, &[1.0], rest), HysteresisError::Exponent { n: 0.5 });
    for n in [1.0, 1.5, 2.0] {
        let wild = UnitShape { beta: -1.0, gamma: 0.0, n };
        let error = run(wild, 1, &[1.0, 900.0, 0.0], rest);
        assert!(matches!(error, HysteresisError::RunsAway { index: 1, .. }), "{error}");
    }
    let shapeless = UnitShape { beta: 0.0, gamma: 0.0, n: 1.0 };
    let error = run(shapeless, 1, &[1.0, 2.0], Start::PERIODIC);
    assert_eq!(error, HysteresisError::NotContracting { slope: 1.0 });
}
