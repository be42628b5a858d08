//! Preisach planes: against relays switched one by one.

use super::*;

#[test]
fn a_cell_of_relays_by_hand() {
    // Levels 0, 1, 2: column 1 is α in [1, 2], β in [0, 1]. Virgin at 1 V half of it is up.
    let plane = Preisach { levels: vec![0.0, 1.0, 2.0] };
    let cell = |u: &[f64]| {
        let mut out = vec![0.0; 3 * u.len()];
        plane.simulate_every(&[], 1, u, Start::Rest { voltage_v: 1.0 }, &mut out).unwrap();
        out[u.len()..2 * u.len()].to_vec()
    };
    // Up to 1.5 V: all below that, and above it the triangle under the antidiagonal, 1/8.
    assert_eq!(cell(&[1.0, 1.5, 2.0]), [0.0, 2.0 * 0.625 - 1.0, 1.0]);
    // Down to 0.25 V from 1.5 V: what lies left of it, 1/4, and nothing else: the triangle had β < 0.5.
    // Of it, α + β < 2 with α up to 2 V − 0.25 V all, above that the triangle of 0.25 V: 0.25 − 1/32.
    assert_eq!(cell(&[1.5, 0.25])[1], 2.0 * (0.25 - 1.0 / 32.0) - 1.0);
    assert_eq!(cell(&[0.0, 2.0, 0.5]), [-1.0, 1.0, 0.0]);
    // The ramps of the diagonal.
    let mut out = [0.0; 6];
    plane.simulate_every(&[], 1, &[0.25, 1.75], REST, &mut out).unwrap();
    assert_eq!([&out[..2], &out[4..]], [[-0.5, 1.0], [-1.0, 0.5]]);
}

fn weighted_plane() -> impl Strategy<Value = ColumnModel<Preisach>> {
    vec((0.5..2.0_f64, -5.0..-3.0_f64), 2..7).prop_flat_map(|gaps| {
        let mut at = gaps[0].1;
        let above = gaps.iter().map(|(gap, _)| {
            at += gap;
            at
        });
        let levels: Vec<f64> = std::iter::once(gaps[0].1).chain(above).collect();
        let n = levels.len() - 1;
        vec(-0.2..1.0_f64, n * (n + 1) / 2).prop_map(move |weights| ColumnModel {
            polynomial: vec![0.0],
            kernel: Preisach { levels: levels.clone() },
            shape: Vec::new(),
            weights,
        })
    })
}

proptest! {
    #![proptest_config(config(100))]

    #[test]
    fn relays_switched_one_by_one_give_the_cells(turns in vec(0..=6_i32, 1..40)) {
        // Levels and turning points at whole voltages: a cell is a relay at half voltages.
        let plane = Preisach::regular([0.0, 6.0], 7);
        let u: Vec<f64> = [-1].iter().chain(&turns).map(|&u| f64::from(u)).collect();
        let mut out = vec![0.0; 21 * u.len()];
        plane.simulate_every(&[], 1, &u, Start::Rest { voltage_v: 0.0 }, &mut out).unwrap();
        for i in 0..6 {
            for j in 0..i {
                let (alpha, beta) = (i as f64 + 0.5, j as f64 + 0.5);
                let mut relay = -1.0;
                for (k, &u) in u.iter().enumerate() {
                    relay = if u > alpha { 1.0 } else if u < beta { -1.0 } else { relay };
                    prop_assert_eq!(out[(i * (i + 1) / 2 + j) * out.len() / 21 + k], relay);
                }
            }
        }
    }

    #[test]
    fn virgin_is_what_a_slowly_decaying_voltage_leaves(
        model in weighted_plane(), rest in -3.0..1.0_f64, turns in vec(-6.0..6.0_f64, 1..8),
    ) {
        let decay = (0..24_000).map(|k| {
            let amplitude = 12.0 - 5e-4 * f64::from(k);
            if k % 2 == 0 { rest + amplitude } else { rest - amplitude }
        });
        let count = 24_000;
        let u: Vec<f64> = decay.chain(turns.iter().copied()).collect();
        let from_virgin = simulate(&model, &turns, Start::Rest { voltage_v: rest });
        // Steps of 5e-4 V beside intervals of at least 0.5 V, up to 21 cells.
        for (v, want) in simulate(&model, &u, REST)[count..].iter().zip(&from_virgin) {
            prop_assert!((v - want).abs() < 2e-2, "{v} {want}");
        }
    }

    #[test]
    fn a_gaussian_density_of_equal_spreads_is_a_product_of_normal_distributions(
        half_width in 0.5..1.5_f64, spread in 0.7..1.5_f64, bias in -0.5..0.5_f64,
    ) {
        let kernel = PreisachDensity { plane: Preisach::regular([-4.0, 4.0], 17), law: DensityLaw::Gaussian };
        let weights = kernel.weights(&[half_width, spread, bias, spread]);
        // α and β are independent with means m₀ ± h₀ and spread √2 σ.
        let share = |mean: f64, low: f64| {
            let z = |x: f64| libm::erf((x - mean) / (2.0 * spread));
            z(low + 0.5) - z(low)
        };
        let line = |index: usize| -4.0 + 0.5 * index as f64;
        let want = |i: usize, j: usize| {
            share(bias + half_width, line(i)) * share(bias - half_width, line(j))
        };
        let reference = weights[10 * 11 / 2 + 5] / want(10, 5);
        for i in 0..16 {
            for j in 0..i {
                let (got, want) = (weights[i * (i + 1) / 2 + j], reference * want(i, j));
                prop_assert!((got - want).abs() < 1e-9 * reference, "{i} {j}: {got} {want}");
            }
        }
        prop_assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-14);
    }
}
