//! Preisach planes and densities.

use super::*;

fn plane() -> impl Strategy<Value = Preisach> {
    vec(0.5..3.0_f64, 1..6).prop_map(|gaps| {
        let mut at = -5.0;
        let above = gaps.into_iter().map(|gap| {
            at += gap;
            at
        });
        Preisach { levels: std::iter::once(-5.0).chain(above).collect() }
    })
}

proptest! {
    #![proptest_config(config(100))]

    #[test]
    fn laws(
        plane in plane(),
        u in drive(),
        moves in moves(),
        rest in -3.0..3.0_f64,
        inner in vec(0.0..1.0_f64, 0..8),
    ) {
        only_turning_points_count(&plane, &[], &u, 7, 1e-13)?;
        the_periodic_start_closes(&plane, &[], &u, 1e-13)?;
        continuous(&plane, &[], &moves, 2.0 / 0.5)?;
        return_point_memory(&plane, &[], &u, &inner, 1e-13)?;
        congruent(&plane, &[], [&u, &[]], (-3.0, 2.0), 1e-13)?;
            a_memory_is_a_move(&plane, &[], &u, (rest, 0.5))?;
        derivatives_are_differences(&plane, &[], &u, Start::Rest { voltage_v: rest }, 1e-8)?;
    }

    #[test]
    fn a_plane_symmetric_about_zero_is_odd(u in drive(), count in 2..7_usize) {
        // The cell (i, j) mirrored is (n − 1 − j, n − 1 − i).
        let plane = Preisach::regular([-4.0, 4.0], count);
        let n = count - 1;
        let mirrored: Vec<f64> = u.iter().map(|u| -u).collect();
        let (a, b) = (rows(&plane, &[], &u, REST), rows(&plane, &[], &mirrored, REST));
        let at = |i: usize, j: usize| i * (i + 1) / 2 + j;
        for (a, b) in a.iter().zip(&b) {
            for i in 0..n {
                for j in 0..=i {
                    prop_assert!((a[at(i, j)] + b[at(n - 1 - j, n - 1 - i)]).abs() <= 1e-13);
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(config(25))]

    #[test]
    fn laws_of_a_density(
        law in prop_oneof![Just(DensityLaw::Gaussian), Just(DensityLaw::Lorentzian)],
        half_width in 0.5..2.0_f64, spreads in (0.5..2.0_f64, 0.5..2.0_f64), bias in -1.0..1.0_f64,
        u in drive(), rest in -3.0..3.0_f64, inner in vec(0.0..1.0_f64, 0..8),
    ) {
        let kernel = PreisachDensity { plane: Preisach::regular([-5.0, 5.0], 9), law };
        let shape = [half_width, spreads.0, bias, spreads.1];
        only_turning_points_count(&kernel, &shape, &u, 7, 1e-13)?;
        the_periodic_start_closes(&kernel, &shape, &u, 1e-13)?;
        return_point_memory(&kernel, &shape, &u, &inner, 1e-13)?;
        congruent(&kernel, &shape, [&u, &[]], (-3.0, 2.0), 1e-13)?;
        odd(&kernel, &[half_width, spreads.0, 0.0, spreads.1], &u, 1e-13)?;
        derivatives_are_differences(&kernel, &shape, &u, Start::Rest { voltage_v: rest }, 1e-8)?;
        derivatives_are_differences(&kernel, &shape, &u, Start::PERIODIC, 1e-8)?;
    }
}

proptest! {
    #![proptest_config(config(30))]

    /// The sum that is kept up move by move is that of the plane's columns, over more moves than one
    /// reckoning of it, on the diagonal and off it, beyond the levels too.
    #[test]
    fn a_density_is_its_plane_with_its_weights(
        turns in vec(-7.0..7.0_f64, 1..12), count in 1..9_usize, rest in -3.0..3.0_f64, h in 0.0..2.0_f64,
    ) {
        let plane = Preisach::regular([-5.0, 4.0], count + 1);
        let kernel = PreisachDensity { plane: plane.clone(), law: DensityLaw::Gaussian };
        let shape = [h, 1.3, 0.4, 2.5];
        let weights: Vec<f64> = kernel.weights(&shape);
        let u = dense(&turns, 60);
        let start = Start::Rest { voltage_v: rest };
        for (own, cells) in rows(&kernel, &shape, &u, start).iter().zip(rows(&plane, &[], &u, start)) {
            let sum: f64 = cells.iter().zip(&weights).map(|(cell, w)| cell * w).sum();
            prop_assert!((own[0] - sum).abs() < 1e-12, "{} {sum}", own[0]);
        }
    }
}
