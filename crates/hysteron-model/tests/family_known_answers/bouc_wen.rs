//! Bouc–Wen's other forms and asymmetric extensions.

use super::*;

proptest! {
    #![proptest_config(config(30))]

    #[test]
    fn six_coefficients_solve_their_own_equation(
        first in 0.6..1.5_f64,
        others in prop::array::uniform5(-0.1..0.1_f64),
        turns in vec(-5.0..5.0_f64, 1..6),
    ) {
        let [a, b, c, d, e] = others;
        let zeta = column(&SongDerKiureghian, &[first, a, b, c, d, e], &turns, REST);
        let (mut from, mut z) = (0.0, 0.0);
        for (&to, zeta) in turns.iter().zip(&zeta) {
            let s = f64::signum(to - from);
            // Split where u passes 0: x is its sign.
            let legs = if from * to < 0.0 { vec![(from, 0.0), (0.0, to)] } else { vec![(from, to)] };
            for (from, to) in legs {
                let x = f64::signum(from + to);
                z = integrate(from, z, to, |_, z| {
                    let w = z.signum();
                    1.0 - z.abs() * (first * s * w + a * x * s + b * x * w + c * s + d * w + e * x)
                });
            }
            from = to;
            // The second derivative jumps where ζ passes 0.
            prop_assert!((zeta - z).abs() < 1e-5, "{zeta} {z}");
        }
    }

    #[test]
    fn the_delta_term_solves_its_own_equation(
        beta in 0.2..1.5_f64,
        part in -0.9..0.9_f64,
        delta in -0.5..0.5_f64,
        turns in vec(-5.0..5.0_f64, 1..6),
    ) {
        let zeta = column(&NonSymmetricBoucWen, &[beta, part * beta, delta], &turns, REST);
        let (mut from, mut z) = (0.0, 0.0);
        for (&to, zeta) in turns.iter().zip(&zeta) {
            let s = f64::signum(to - from);
            z = integrate(from, z, to, |u, z| {
                1.0 - (beta * s + part * beta * z.signum()) * z + delta * s * u
            });
            from = to;
            // The second derivative jumps where ζ passes 0.
            prop_assert!((zeta - z).abs() < 1e-5, "{zeta} {z}");
        }
    }

    #[test]
    fn asymmetric_operators_without_asymmetry_are_bouc_wen(
        beta in 0.2..1.5_f64, part in -0.9..0.9_f64, u in vec(-6.0..6.0_f64, 1..30), rest in -2.0..2.0_f64,
    ) {
        let gamma = part * beta;
        let run = |beta: f64, gamma: f64, u: &[f64], rest: f64| {
            let mut zeta = vec![0.0; u.len()];
            UnitShape { beta, gamma, n: 1.0 }
                .simulate_every(1, u, Start::Rest { voltage_v: rest }, &mut zeta)
                .unwrap();
            zeta
        };
        let start = Start::Rest { voltage_v: rest };
        let symmetric = column(&NonSymmetricBoucWen, &[beta, gamma, 0.0], &u, start);
        let first = column(&SongDerKiureghian, &[beta, 0.0, 0.0, 0.0, 0.0, 0.0], &u, start);
        let wanted = run(beta, gamma, &u, rest).into_iter().zip(run(beta, 0.0, &u, rest));
        for ((symmetric, first), (want, want_first)) in symmetric.iter().zip(&first).zip(wanted) {
            prop_assert!((symmetric - want).abs() < 1e-12, "{symmetric} {want}");
            prop_assert!((first - want_first).abs() < 1e-12, "{first} {want_first}");
        }
        // Growing loops about 0, on which ζ never has the sign against u and its direction at once.
        let loops: Vec<f64> = (1..12).map(|k| if k % 2 == 0 { -0.5 } else { 0.5 } * f64::from(k)).collect();
        let three = column(&SongDerKiureghian, &[beta + gamma, -gamma, gamma, 0.0, 0.0, 0.0], &loops, REST);
        for (zeta, want) in three.iter().zip(run(beta, gamma, &loops, 0.0)) {
            prop_assert!((zeta - want).abs() < 1e-12, "{zeta} {want}");
        }
    }
}
