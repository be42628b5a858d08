//! The step against a slow, obvious oracle: classical Runge–Kutta with tiny steps in u.

#![allow(clippy::unwrap_used)] // Helpers outside the test functions; a failure is a failed test.

use hysteron_rt::{BoucWen, BoucWenState, Dual, StepError};
use proptest::prelude::*;

/// dz/du of article Eq. 1 for s = sign Δu.
fn slope([alpha, beta, gamma, n]: [f64; 4], s: f64, z: f64) -> f64 {
    alpha - beta * s * z * z.abs().powf(n - 1.0) - gamma * z.abs().powf(n)
}

/// z after a monotone move by `du`, by `steps` classical Runge–Kutta steps.
fn oracle(p: [f64; 4], z: f64, du: f64, steps: u32) -> f64 {
    let (s, h) = (du.signum(), du / f64::from(steps));
    let mut z = z;
    for _ in 0..steps {
        let k1 = slope(p, s, z);
        let k2 = slope(p, s, z + 0.5 * h * k1);
        let k3 = slope(p, s, z + 0.5 * h * k2);
        let k4 = slope(p, s, z + h * k3);
        z += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    z
}

fn exact([alpha, beta, gamma, n]: [f64; 4], z: f64, du: f64) -> Result<f64, StepError<f64>> {
    BoucWen::new(alpha, beta, gamma, n).unwrap().advance(z, du)
}

fn assert_close(got: f64, want: f64, tolerance: f64) {
    assert!((got - want).abs() <= tolerance * want.abs().max(1.0), "{got:e} against {want:e}");
}

#[test]
fn agrees_with_runge_kutta_for_every_branch() {
    // Rows: α, β, γ, n, z, Δu. Every sign of α, of κ and of z, with and without a passage through 0.
    let rows = [
        ([-1.2039, 0.1111, 0.0024, 1.0], 4.0, 3.0),
        ([-1.2039, 0.1111, 0.0024, 1.0], -9.0, -30.0),
        ([0.7, 0.2, -0.5, 1.0], -1.0, 2.5),
        ([0.7, 0.2, 0.2, 1.0], 1.0, -4.0),
        ([0.7, -0.2, 0.2, 1.0], 1.0, 4.0),
        ([0.7, 0.3, 0.1, 2.0], 0.0, 1.0),
        ([0.7, 0.3, 0.1, 2.0], 1.0, -4.0),
        ([-0.7, 0.3, 0.5, 2.0], 0.8, 2.0),
        ([0.7, 0.3, -0.3, 2.0], -0.8, 2.0),
        ([0.7, -0.3, 0.1, 2.0], 0.3, 1.5),
        ([0.0, 0.3, 0.1, 2.0], 0.3, 1.5),
        ([0.9, 0.4, 0.2, 3.0], 0.0, 2.0),
        ([0.9, 0.4, 0.2, 3.0], 1.0, -3.0),
        ([-0.9, 0.4, 0.2, 5.0], 0.6, 3.0),
        ([0.9, -0.4, 0.2, 3.0], 0.1, 1.0),
        ([0.0, 0.4, 0.2, 3.0], -0.7, 4.0),
        ([0.9, 0.4, 0.2, 4.0], 0.9, 0.01),
    ];
    for (p, z, du) in rows {
        // Split at the passage through 0 by bisection on the oracle would hide an error of the split; so many
        // steps that the kink of the right-hand side there costs less than the tolerance.
        assert_close(exact(p, z, du).unwrap(), oracle(p, z, du, 200_000), 3e-10);
    }
    // Without a passage through 0 the right-hand side is smooth and the oracle good to rounding.
    for (p, z, du) in rows {
        let end = exact(p, z, du).unwrap();
        if end * z > 0.0 {
            assert_close(end, oracle(p, z, du, 20_000), 1e-12);
        }
    }
}

#[test]
fn agrees_with_runge_kutta_for_fractional_exponents() {
    for n in [1.0001, 1.1, 1.5, 1.9, 2.3, 2.7, 4.2, 11.0] {
        for (z, du) in [(0.5, 1.0), (0.5, -0.2), (-0.9, -2.0), (0.3, 0.004)] {
            let p = [0.6, 0.4, 0.1, n];
            assert_close(exact(p, z, du).unwrap(), oracle(p, z, du, 20_000), 1e-12);
        }
    }
}

#[test]
fn the_three_branches_meet_where_the_exponents_do() {
    for (z, du) in [(0.5, 1.0), (0.5, -3.0), (0.0, 0.7), (-0.2, 0.001), (-1e-9, 2.0), (3.0, -40.0)] {
        for n in [1.0, 2.0] {
            let closed = exact([0.6, 0.4, 0.1, n], z, du).unwrap();
            let series = BoucWen::new(0.6, 0.4, 0.1, n)
                .unwrap()
                .advance_with_sensitivities(Dual { value: z, partials: [0.0; 3] }, du)
                .unwrap();
            assert!(
                (closed - series.value).abs() <= 4e-15 * closed.abs().max(z.abs()),
                "n {n}, z {z}, Δu {du}: {closed:e} {:e}",
                series.value
            );
        }
    }
}

#[test]
fn saturates_where_the_slope_vanishes() {
    for (n, end) in [(1.0, 1.2), (2.0, 1.2_f64.sqrt()), (3.0, 1.2_f64.cbrt()), (1.5, 1.2_f64.powf(1.0 / 1.5))]
    {
        // dz/du = 0.6 − 0.5 zⁿ.
        assert_close(exact([0.6, 0.4, 0.1, n], 0.2, 400.0).unwrap(), end, 4e-15);
    }
}

#[test]
fn pole_of_the_tangent_is_an_error_that_says_where() {
    // ż = 1 + z² from 0: z = tan u, pole at π/2.
    for (n, pole) in [
        (2.0, std::f64::consts::FRAC_PI_2),
        // ∫ dz/(1 + z³) over [0, ∞) = 2π/(3√3).
        (3.0, 2.0 * std::f64::consts::PI / (3.0 * 3.0_f64.sqrt())),
    ] {
        let p = [1.0, -1.0, 0.0, n];
        match exact(p, 0.0, 2.0) {
            Err(StepError::BlowUp { after }) => assert_close(after, pole, 1e-12),
            other => panic!("{other:?}"),
        }
        assert!(exact(p, 0.0, 0.999 * pole).is_ok());
        // Down to 0 from −0.5 first, then to the pole.
        match exact(p, -0.5, -3.0) {
            Err(StepError::BlowUp { after }) => assert!(after < 0.0 && after > -pole, "{after}"),
            other => panic!("{other:?}"),
        }
    }
    // −ż = 1 − z², beyond the unstable rest point: z = coth.
    match exact([-1.0, -1.0, 0.0, 2.0], 1.5, 4.0) {
        Err(StepError::BlowUp { after }) => assert_close(after, (1.0_f64 / 1.5).atanh(), 1e-12),
        other => panic!("{other:?}"),
    }
}

#[test]
fn exponential_growth_beyond_the_number_range_is_an_error() {
    assert_eq!(exact([1.0, -1.0, 0.0, 1.0], 0.0, 1000.0), Err(StepError::Overflow));
    assert_eq!(exact([1.0, 1.0, 0.0, 1.0], f64::NAN, 1.0), Err(StepError::NotFinite));
}

#[test]
fn single_precision_follows_double() {
    for n in [1.0, 2.0, 1.4] {
        let double = BoucWen::new(0.6_f64, 0.4, 0.1, n).unwrap();
        let single = BoucWen::new(0.6_f32, 0.4, 0.1, n as f32).unwrap();
        let (mut z, mut z32) = (0.0, 0.0_f32);
        for k in 0..400 {
            let du = (f64::from(k) * 0.31).sin() * 0.5;
            z = double.advance(z, du).unwrap();
            z32 = single.advance(z32, du as f32).unwrap();
            assert!((z - f64::from(z32)).abs() < 2e-6, "n {n}, step {k}: {z} {z32}");
        }
    }
}

fn parameters() -> impl Strategy<Value = [f64; 4]> {
    let n = prop_oneof![Just(1.0), Just(2.0), 1.0..6.0_f64];
    (-2.0..2.0_f64, 0.0..0.6_f64, -1.0..1.0_f64, n).prop_map(|(alpha, beta, share, n)| {
        // The bounded class: |γ| ≤ β.
        [alpha, beta, beta * share, n]
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

    #[test]
    fn one_move_is_any_two_moves_in_the_same_direction(
        p in parameters(), z in -2.0..2.0_f64, du in -5.0..5.0_f64, share in 0.0..1.0_f64,
    ) {
        let whole = exact(p, z, du).unwrap();
        let parts = exact(p, exact(p, z, share * du).unwrap(), du - share * du).unwrap();
        prop_assert!((whole - parts).abs() <= 4e-14 * (1.0 + z.abs() + du.abs()), "{whole:e} {parts:e}");
    }

    #[test]
    fn is_odd(p in parameters(), z in -2.0..2.0_f64, du in -5.0..5.0_f64) {
        prop_assert_eq!(exact(p, z, du).unwrap(), -exact(p, -z, -du).unwrap());
    }

    #[test]
    fn unit_alpha_form_is_a_scaling(p in parameters(), z in -2.0..2.0_f64, du in -5.0..5.0_f64) {
        let [alpha, beta, gamma, n] = p;
        prop_assume!(alpha.abs() > 1e-3);
        let size = alpha.abs().powf(n - 1.0);
        let unit = BoucWen::unit(beta * size, alpha.signum() * gamma * size, n).unwrap();
        let zeta = unit.advance(z / alpha, du).unwrap();
        let want = exact(p, z, du).unwrap();
        prop_assert!(
            (alpha * zeta - want).abs() <= 1e-13 * (1.0 + z.abs() + du.abs()),
            "{} {}",
            alpha * zeta,
            want
        );
    }

    #[test]
    fn simulation_is_the_step_repeated_bit_for_bit(
        p in parameters(),
        z in -2.0..2.0_f64,
        u in prop::collection::vec(-5.0..5.0_f64, 0..60),
        factor in 1..5_usize,
    ) {
        let [alpha, beta, gamma, n] = p;
        let b = BoucWen::new(alpha, beta, gamma, n).unwrap();
        let start = BoucWenState { u: 0.5, z };
        let mut state = start;
        let stepped: Vec<f64> = u.iter().map(|&u| b.step(&mut state, u).unwrap()).collect();
        let mut end = start;
        let mut out = vec![0.0; u.len()];
        b.simulate(&mut end, &u, &mut out).unwrap();
        prop_assert_eq!(&out, &stepped);
        prop_assert_eq!(end, state);
        let mut end = start;
        let mut out = vec![0.0; u.len().div_ceil(factor)];
        b.simulate_every(factor, &mut end, &u, &mut out).unwrap();
        prop_assert_eq!(out, stepped.into_iter().step_by(factor).collect::<Vec<_>>());
        prop_assert_eq!(end, state);
    }

    #[test]
    fn order_of_states_is_kept(
        p in parameters(),
        z in -2.0..2.0_f64,
        gap in 0.0..1.0_f64,
        du in -5.0..5.0_f64,
    ) {
        prop_assert!(exact(p, z + gap, du).unwrap() >= exact(p, z, du).unwrap() - 1e-14);
    }

    #[test]
    fn sensitivities_are_the_difference_quotients(
        p in parameters(), z in -1.0..1.0_f64, first in 0.1..3.0_f64, second in -4.0..-0.1_f64,
    ) {
        let [alpha, beta, gamma, n] = p;
        prop_assume!(alpha.abs() > 0.05);
        let n = n + 0.01;
        let path = |alpha, beta, gamma, n| {
            let b = BoucWen::new(alpha, beta, gamma, n).unwrap();
            b.advance(b.advance(z, first).unwrap(), second).unwrap()
        };
        let b = BoucWen::new(alpha, beta, gamma, n).unwrap();
        let dual = b.advance_with_sensitivities(Dual { value: z, partials: [0.0; 3] }, first).unwrap();
        let middle = dual;
        let dual = b.advance_with_sensitivities(dual, second).unwrap();
        let h = 1e-4;
        // |z|ⁿ has a kink at z = 0: no difference quotient of order four across it.
        for point in [middle, dual] {
            let reach = point.partials.iter().fold(0.0_f64, |m, p| m.max(p.abs()));
            prop_assume!(point.value.abs() > 10.0 * h * reach && reach < 30.0);
        }
        // Fourth-order central differences.
        let quotient =
            |f: &dyn Fn(f64) -> f64| (8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h);
        let want = [
            quotient(&|d| path(alpha, beta + d, gamma, n)),
            quotient(&|d| path(alpha, beta, gamma + d, n)),
            quotient(&|d| path(alpha, beta, gamma, n + d)),
        ];
        for (got, want) in dual.partials.iter().zip(want) {
            prop_assert!((got - want).abs() <= 1e-7 * (1.0 + want.abs()), "{:?} {:?}", dual.partials, want);
        }
        for n in [1.0, 2.0] {
            let b = BoucWen::new(alpha, beta, gamma, n).unwrap();
            let halfway = b.advance_with_shape(Dual { value: z, partials: [0.0; 2] }, first).unwrap();
            let closed = b.advance_with_shape(halfway, second).unwrap();
            // Contributions of the two moves may cancel: rounding is relative to the largest derivative on
            // the way.
            let size = halfway.partials.iter().chain(&closed.partials).fold(1.0_f64, |m, p| m.max(p.abs()));
            let series = b.advance_with_sensitivities(Dual { value: z, partials: [0.0; 3] }, first).unwrap();
            let series = b.advance_with_sensitivities(series, second).unwrap();
            for (c, s) in closed.partials.iter().zip(series.partials) {
                prop_assert!((c - s).abs() <= 1e-12 * size, "n {}: {:?} {:?}", n, closed, series);
            }
        }
    }

    #[test]
    fn finite_numbers_give_a_finite_number_or_an_error(
        p in prop::array::uniform4(prop::num::f64::NORMAL | prop::num::f64::ZERO | prop::num::f64::SUBNORMAL),
        small in prop::array::uniform4(-3.0..3.0_f64),
        z in prop::num::f64::NORMAL | prop::num::f64::ZERO,
        du in prop::num::f64::NORMAL | prop::num::f64::ZERO,
        n in prop_oneof![Just(1.0), Just(2.0), 1.0..40.0_f64],
        mild in any::<bool>(),
    ) {
        let [alpha, beta, gamma, _] = if mild { small } else { p };
        let b = BoucWen::new(alpha, beta, gamma, n).unwrap();
        if let Ok(end) = b.advance(z, du) {
            prop_assert!(end.is_finite());
        }
        if let Ok(end) = b.advance_with_sensitivities(Dual { value: z, partials: [0.0; 3] }, du) {
            prop_assert!(end.value.is_finite());
        }
        let single = BoucWen::new(small[0] as f32, small[1] as f32, small[2] as f32, n as f32).unwrap();
        if let Ok(end) = single.advance(small[3] as f32, (du.abs().min(1e30)) as f32) {
            prop_assert!(end.is_finite());
        }
    }
}

/// Without a rise z decays to 0, however far the voltage moves.
#[test]
fn a_state_without_rise_decays_to_zero() {
    for k in 1..2000 {
        let (kappa, z) = (0.1 + 1e-4 * f64::from(k), 0.1 + 1e-3 * f64::from(k));
        let operator = BoucWen::new(0.0, kappa, 0.0, 1.0).unwrap();
        let end = operator.advance(z, 400.0).unwrap();
        assert!((end - z * (-400.0 * kappa).exp()).abs() <= 3e-16 * z, "{kappa} {z}: {end}");
    }
}
