//! Bouc–Wen's other forms and asymmetric extensions.

use super::*;

proptest! {
    #![proptest_config(config(30))]

    #[test]
    fn six_coefficients_solve_their_own_equation(
        first in 0.6..1.5_f64, others in prop::array::uniform5(-0.1..0.1_f64), n in 1.0..3.0_f64,
        turns in vec(-5.0..5.0_f64, 1..6),
    ) {
        let [a, b, c, d, e] = others;
        let zeta = column(&SongDerKiureghian { n }, &[first, a, b, c, d, e], &turns, REST);
        let (mut from, mut z) = (0.0, 0.0);
        for (&to, zeta) in turns.iter().zip(&zeta) {
            let s = f64::signum(to - from);
            // Split where u passes 0: x is its sign.
            let legs = if from * to < 0.0 { vec![(from, 0.0), (0.0, to)] } else { vec![(from, to)] };
            for (from, to) in legs {
                let x = f64::signum(from + to);
                z = integrate(from, z, to, |_, z| {
                    let w = z.signum();
                    1.0 - z.abs().powf(n) * (first * s * w + a * x * s + b * x * w + c * s + d * w + e * x)
                });
            }
            from = to;
            // The second derivative jumps where ζ passes 0.
            prop_assert!((zeta - z).abs() < 1e-5, "{zeta} {z}");
        }
    }

    #[test]
    fn the_delta_term_solves_its_own_equation(
        beta in 0.2..1.5_f64, part in -0.9..0.9_f64, delta in -0.5..0.5_f64, turns in vec(-5.0..5.0_f64, 1..6),
    ) {
        let zeta = column(&NonSymmetricBoucWen, &[beta, part * beta, delta], &turns, REST);
        let (mut from, mut z) = (0.0, 0.0);
        for (&to, zeta) in turns.iter().zip(&zeta) {
            let s = f64::signum(to - from);
            z = integrate(from, z, to, |u, z| 1.0 - (beta * s + part * beta * z.signum()) * z + delta * s * u);
            from = to;
            // The second derivative jumps where ζ passes 0.
            prop_assert!((zeta - z).abs() < 1e-5, "{zeta} {z}");
        }
    }

    #[test]
    fn asymmetric_operators_without_asymmetry_are_bouc_wen(
        beta in 0.2..1.5_f64, part in -0.9..0.9_f64, n in prop_oneof![Just(1.0), Just(2.0), 1.0..3.0_f64],
        u in vec(-6.0..6.0_f64, 1..30), rest in -2.0..2.0_f64,
    ) {
        let gamma = part * beta;
        let run = |beta: f64, gamma: f64, n: f64, u: &[f64], rest: f64| {
            let mut zeta = vec![0.0; u.len()];
            UnitShape { beta, gamma, n }.simulate_every(1, u, Start::Rest { voltage_v: rest }, &mut zeta).unwrap();
            zeta
        };
        let start = Start::Rest { voltage_v: rest };
        let symmetric = column(&NonSymmetricBoucWen, &[beta, gamma, 0.0], &u, start);
        let song = SongDerKiureghian { n };
        let first = column(&song, &[beta, 0.0, 0.0, 0.0, 0.0, 0.0], &u, start);
        let wanted = run(beta, gamma, 1.0, &u, rest).into_iter().zip(run(beta, 0.0, n, &u, rest));
        for ((symmetric, first), (want, want_first)) in symmetric.iter().zip(&first).zip(wanted) {
            prop_assert!((symmetric - want).abs() < 1e-12, "{symmetric} {want}");
            prop_assert!((first - want_first).abs() < 1e-12, "{first} {want_first}");
        }
        // Growing loops about 0, on which ζ never has the sign against u and its direction at once.
        let loops: Vec<f64> = (1..12).map(|k| if k % 2 == 0 { -0.5 } else { 0.5 } * f64::from(k)).collect();
        let three = column(&song, &[beta + gamma, -gamma, gamma, 0.0, 0.0, 0.0], &loops, REST);
        for (zeta, want) in three.iter().zip(run(beta, gamma, n, &loops, 0.0)) {
            prop_assert!((zeta - want).abs() < 1e-12, "{zeta} {want}");
        }
    }

    #[test]
    fn forms_of_bouc_wen_go_there_and_back(
        alpha in prop_oneof![-4.0..-0.1_f64, 0.1..4.0_f64], sum in 0.1..2.0_f64, sigma in 0.5..1.5_f64, n in 1.0..3.0_f64,
        a in prop_oneof![-4.0..-0.1_f64, 0.1..4.0_f64], turns in vec(-5.0..5.0_f64, 1..5),
    ) {
        let shape = UnitShape { beta: sum * sigma, gamma: sum * (1.0 - sigma), n };
        let model = BoucWen::from_unit(vec![2.0, 0.1], alpha, shape).unwrap();
        let close = |x: f64, y: f64| (x - y).abs() <= 1e-13 * (1.0 + x.abs());
        let normalised = NormalisedBoucWen::of(&model).unwrap();
        let classical = ClassicalBoucWen::of(&model, a).unwrap();
        for back in [normalised.bouc_wen().unwrap(), classical.bouc_wen().unwrap()] {
            prop_assert!(close(back.alpha, model.alpha) && close(back.beta, model.beta));
            prop_assert!(close(back.gamma, model.gamma) && back.n == n && back.polynomial == model.polynomial);
        }
        prop_assert!(close(normalised.sigma, sigma) && normalised.rho > 0.0);
        // The equations as they are printed, integrated.
        let mut v = vec![0.0; turns.len()];
        model.simulate(&turns, Start::Rest { voltage_v: 0.0 }, &mut v).unwrap();
        let (mut from, mut w, mut z) = (0.0, 0.0_f64, 0.0_f64);
        for (&to, v) in turns.iter().zip(&v) {
            let s = f64::signum(to - from);
            let NormalisedBoucWen { rho, sigma, kappa_w, .. } = normalised;
            w = integrate(from, w, to, |_, w| {
                rho * (1.0 - sigma * s * w * w.abs().powf(n - 1.0) + (sigma - 1.0) * w.abs().powf(n))
            });
            let ClassicalBoucWen { a, beta, gamma, kappa, .. } = classical;
            z = integrate(from, z, to, |_, z| {
                a - beta * s * z * z.abs().powf(n - 1.0) - gamma * z.abs().powf(n)
            });
            from = to;
            let line = model.polynomial_at(to);
            prop_assert!((line + kappa_w * w - v).abs() < 1e-5 && (line + kappa * z - v).abs() < 1e-5);
        }
    }
}

#[test]
fn bouc_wen_forms_by_hand() {
    // ρ = 2, σ = ¾, n = 1: β' = 1.5, γ' = 0.5; κ_w = −3: α = 6.
    let normalised =
        NormalisedBoucWen { polynomial: vec![1.0], kappa_w: -3.0, rho: 2.0, sigma: 0.75, n: 1.0 };
    assert_eq!(normalised.bouc_wen().unwrap(), BoucWen::new(vec![1.0], 6.0, 1.5, 0.5, 1.0).unwrap());
    let classical =
        ClassicalBoucWen { polynomial: vec![1.0], kappa: 2.0, a: 3.0, beta: 1.0, gamma: 0.5, n: 1.0 };
    assert_eq!(classical.bouc_wen().unwrap(), BoucWen::new(vec![1.0], -6.0, 1.0, -0.5, 1.0).unwrap());
    let hardening = BoucWen::new(vec![1.0], 1.0, -1.0, 0.5, 1.0).unwrap();
    assert!(matches!(NormalisedBoucWen::of(&hardening), Err(HysteresisError::ShapeParameter { .. })));
    assert!(matches!(ClassicalBoucWen::of(&hardening, 0.0), Err(HysteresisError::ShapeParameter { .. })));
}
