//! Krasnosel'skii–Pokrovskii kernels.

use super::*;

const KERNEL: KrasnoselskiiPokrovskii = KrasnoselskiiPokrovskii { range: [-4.0, 4.0], lines: 5 };

proptest! {
    #![proptest_config(config(60))]

    #[test]
    fn laws(
        rise in 0.3..6.0_f64, u in drive(), moves in moves(), rest in -3.0..3.0_f64,
        inner in vec(0.0..1.0_f64, 0..8),
    ) {
        let shape = [rise];
        only_turning_points_count(&KERNEL, &shape, &u, 7, 0.0)?;
        the_periodic_start_closes(&KERNEL, &shape, &u, 0.0)?;
        continuous(&KERNEL, &shape, &moves, 2.0 / rise)?;
        return_point_memory(&KERNEL, &shape, &u, &inner, 0.0)?;
        congruent(&KERNEL, &shape, [&u, &[]], (-3.0, 2.0), 1e-14)?;
        derivatives_are_differences(&KERNEL, &shape, &u, Start::Rest { voltage_v: rest }, 1e-8)?;
        derivatives_are_differences(&KERNEL, &shape, &u, Start::PERIODIC, 1e-8)?;
        // A grid symmetric about 0: the column of (p₁, p₂) mirrored is that of (−p₂, −p₁).
        let mirrored: Vec<f64> = u.iter().map(|u| -u).collect();
        let (a, b) = (rows(&KERNEL, &shape, &u, REST), rows(&KERNEL, &shape, &mirrored, REST));
        let at = |i: usize, j: usize| i * (i + 1) / 2 + j;
        for (a, b) in a.iter().zip(&b) {
            for i in 0..5 {
                for j in 0..=i {
                    prop_assert!((a[at(i, j)] + b[at(4 - j, 4 - i)]).abs() <= 1e-15);
                }
            }
        }
    }
}
