//! Jiles–Atherton: against an integration of its equations.

use super::duhem_and_dahl::coleman_hodgdon;
use super::*;

proptest! {
    #![proptest_config(config(30))]

    #[test]
    fn jiles_atherton_solves_its_own_equations(
        a in 0.5..3.0_f64, k in 0.3..3.0_f64, c in 0.0..1.0_f64, part in 0.0..0.8_f64,
        turns in vec(-6.0..6.0_f64, 1..6),
    ) {
        let alpha = part * 3.0 * a;
        let m = column(&JilesAtherton, &[a, k, c, alpha], &turns, REST);
        let l = |x: f64| if x.abs() < 1e-3 { x / 3.0 - x.powi(3) / 45.0 } else { 1.0 / x.tanh() - 1.0 / x };
        let slope = |x: f64| {
            if x.abs() < 1e-3 { 1.0 / 3.0 - x * x / 15.0 } else { 1.0 / (x * x) - 1.0 / x.sinh().powi(2) }
        };
        // (p, m) over u, from the anhysteretic curve at 0.
        let (mut from, mut p, mut field) = (0.0, 0.0, 0.0);
        for (&to, got) in turns.iter().zip(&m) {
            let s = if to < from { -1.0 } else { 1.0 };
            let rates = |h: f64, p: f64| {
                let away = l(h / a) - p;
                let p_h = if s * away > 0.0 { away / (s * k) } else { 0.0 };
                let m_h = (1.0 - c) * p_h + c * slope(h / a) / a;
                (1.0 / (1.0 - alpha * m_h), p_h / (1.0 - alpha * m_h))
            };
            let step = (to - from) / 20_000.0;
            for _ in 0..20_000 {
                let one = rates(field, p);
                let two = rates(field + 0.5 * step * one.0, p + 0.5 * step * one.1);
                let three = rates(field + 0.5 * step * two.0, p + 0.5 * step * two.1);
                let four = rates(field + step * three.0, p + step * three.1);
                field += step / 6.0 * (one.0 + 2.0 * two.0 + 2.0 * three.0 + four.0);
                p += step / 6.0 * (one.1 + 2.0 * two.1 + 2.0 * three.1 + four.1);
            }
            from = to;
            let want = p + c * (l(field / a) - p);
            // The step across the end of the freezing meets a kink of the rate.
            prop_assert!((got - want).abs() < 1e-6, "{got} {want}");
        }
    }

    #[test]
    fn jiles_atherton_of_small_fields_is_duhem(k in 0.3..3.0_f64, u in vec(-6.0..6.0_f64, 1..10)) {
        // L(x) = x/3 (1 − x²/15 …) with x ≤ 1.2e-4; from rest at 0 and never turning before its anhysteretic
        // value.
        let tops: Vec<f64> =
            u.iter().enumerate().map(|(k, u)| if k % 2 == 0 { 6.0 + u } else { -6.0 + u }).collect();
        let a = 1e5;
        let m = column(&JilesAtherton, &[a, k, 0.0, 0.0], &tops, REST);
        let duhem = coleman_hodgdon(1.0 / k, &[1.0], &[]);
        let v = simulate(&duhem, &tops, REST);
        // Before its first turn; from there on the freezing of p sets them apart.
        prop_assert!((3.0 * a * m[0] - v[0]).abs() < 1e-7, "{} {}", 3.0 * a * m[0], v[0]);
    }
}

#[test]
fn jiles_atherton_that_is_all_reversible_is_anhysteretic() {
    // c = 1: m = L(h/a), h = u + αm, on every branch.
    let u = [3.0, -1.0, 0.5, -4.0];
    let m = column(&JilesAtherton, &[1.0, 0.7, 1.0, 1.5], &u, REST);
    for (u, m) in u.iter().zip(&m) {
        let x = u + 1.5 * m;
        assert!((1.0 / x.tanh() - 1.0 / x - m).abs() < 1e-14, "{u} {m}");
    }
}
