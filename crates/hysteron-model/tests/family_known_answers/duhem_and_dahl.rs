//! The families that relax: Duhem and Dahl.

use super::*;

#[test]
fn the_duhem_loop_by_hand() {
    // From rest y₀ = (1 − e^(−bu))/b; settled between ±A it is tanh(bA)/b at the top. y₁ = (u − 1/b)/b + c
    // e^(−bu) going up and its mirror image going down, so that c = A/(b sinh bA) and y₁ = (A coth(bA) −
    // 1/b)/b at both ends.
    let (b, a) = (0.4_f64, 3.0);
    let y = column(&Duhem { degree: 0 }, &[b], &[1.0, 2.5], REST);
    for (y, u) in y.iter().zip([1.0, 2.5]) {
        assert!((y - (1.0 - (-b * u).exp()) / b).abs() < 1e-15);
    }
    let mut out = [0.0; 4];
    Duhem { degree: 1 }.simulate_every(&[b], 1, &[a, -a], Start::PERIODIC, &mut out).unwrap();
    let top = (b * a).tanh() / b;
    let ends = (a / (b * a).tanh() - 1.0 / b) / b;
    for (got, want) in out.iter().zip([top, -top, ends, ends]) {
        assert!((got - want).abs() < 1e-14, "{out:?} {want}");
    }
}

/// dv/du = ±b (f(u) − v) + g(u) in columns: `f` from the coefficient of u on, `g` from the constant on.
pub(super) fn coleman_hodgdon(rate: f64, f: &[f64], g: &[f64]) -> ColumnModel<Duhem> {
    let count = f.len().max(g.len());
    let at = |c: &[f64], j: usize| c.get(j).copied().unwrap_or(0.0);
    let weights = (0..count).map(|j| at(g, j) - (j + 1) as f64 * at(f, j)).collect();
    ColumnModel { polynomial: f.to_vec(), kernel: Duhem { degree: count - 1 }, shape: vec![rate], weights }
}

proptest! {
    #![proptest_config(config(40))]

    #[test]
    fn duhem_columns_solve_the_equation_of_coleman_and_hodgdon(
        rate in 0.05..1.5_f64, f in vec(-1.0..1.0_f64, 1..5), g in vec(-1.0..1.0_f64, 1..4),
        turns in vec(-5.0..5.0_f64, 1..6), rest in -2.0..2.0_f64,
    ) {
        let model = coleman_hodgdon(rate, &f, &g);
        let v = simulate(&model, &turns, Start::Rest { voltage_v: rest });
        let value = |c: &[f64], u: f64| c.iter().rev().fold(0.0, |sum, c| sum * u + c);
        let f_at = |u: f64| u * value(&f, u);
        let (mut from, mut z) = (rest, f_at(rest));
        for (&to, v) in turns.iter().zip(&v) {
            let s = if to < from { -1.0 } else { 1.0 };
            z = integrate(from, z, to, |u, z| s * rate * (f_at(u) - z) + value(&g, u));
            from = to;
            // Runge–Kutta of order 4 with steps of 2.5e-3 V at most.
            prop_assert!((v - z).abs() < 1e-8 * (1.0 + z.abs()), "{v} {z}");
        }
    }

    #[test]
    fn dahl_with_exponent_one_is_bouc_wen_without_gamma(
        reach in 0.2..8.0_f64,
        stiffness in 0.1..4.0_f64,
        u in vec(-6.0..6.0_f64, 1..40),
        rest in -2.0..2.0_f64,
    ) {
        let polynomial = vec![2.0, 0.1];
        let dahl =
            ColumnModel { polynomial, kernel: Dahl, shape: vec![reach, 1.0], weights: vec![-stiffness] };
        let bouc_wen = BoucWen::new(vec![2.0, 0.1], stiffness, 1.0 / reach, 0.0, 1.0).unwrap();
        let mut want = vec![0.0; u.len()];
        bouc_wen.simulate(&u, Start::Rest { voltage_v: rest }, &mut want).unwrap();
        for (v, want) in simulate(&dahl, &u, Start::Rest { voltage_v: rest }).iter().zip(&want) {
            prop_assert!((v - want).abs() < 2e-13, "{v} {want}");
        }
        bouc_wen.simulate(&u, Start::PERIODIC, &mut want).unwrap();
        for (v, want) in simulate(&dahl, &u, Start::PERIODIC).iter().zip(&want) {
            prop_assert!((v - want).abs() < 1e-11, "{v} {want}");
        }
    }

    #[test]
    fn dahl_solves_its_own_equation(
        reach in 0.5..8.0_f64, exponent in 0.2..3.0_f64, turns in vec(-5.0..5.0_f64, 1..6),
    ) {
        let zeta = column(&Dahl, &[reach, exponent], &turns, REST);
        let (mut from, mut z) = (0.0, 0.0);
        for (&to, zeta) in turns.iter().zip(&zeta) {
            let s = if to < from { -1.0 } else { 1.0 };
            z = integrate(from, z, to, |_, z| (1.0 - s * z / reach).max(0.0).powf(exponent));
            from = to;
            // Where ζ saturates within the move (i < 1) the last step of Runge–Kutta meets a kink.
            let tolerance = if exponent < 1.0 { 2e-3 } else { 1e-9 };
            prop_assert!((zeta - z).abs() < tolerance, "{zeta} {z}");
            z = *zeta;
        }
    }
}

#[test]
fn dahl_by_hand() {
    // i = 0 is a stop: up to u_c, then back with slope 1.
    assert_eq!(column(&Dahl, &[1.0, 0.0], &[0.5, 3.0, 2.5, 0.0], REST), [0.5, 1.0, 0.5, -1.0]);
    // i = 2: x = 1/(1 + u/u_c), ζ = u_c u/(u_c + u).
    let zeta = column(&Dahl, &[2.0, 2.0], &[1.0, 4.0], REST);
    assert!((zeta[0] - 2.0 / 3.0).abs() < 1e-15 && (zeta[1] - 4.0 / 3.0).abs() < 1e-15, "{zeta:?}");
}
